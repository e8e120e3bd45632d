"""Structures of a program of KRL: one variable for each member in other languages, whatever they begin with."""

from __future__ import annotations

import pytest
from translated_texts import ROBOT, krl

from olp.fluent import read
from olp.timing.timing import time_plan
from olp.transpile import Context
from olp.transpile.convert import convert, run_converted
from olp.transpile.link import link

LAYOUT = "DEFDAT PART\nSTRUC AT_T INT A,REAL B\nSTRUC PART_T AT_T N,BOOL C,FRAME F\n{}ENDDAT\n"
DATA = "DECL PART_T P[6]\nDECL PART_T Q\n"
SET = ("DECL INT I", "I=2", "P[I].N.A=3", "P[I].N.B=0.5", "P[I].C=TRUE", "P[I].F={X 1,Y 2,Z 3,A 0,B 0,C 0}")
COPIED = (*SET, "Q=P[I]", "Q.N.A=Q.N.A+1", "IF Q.C THEN", "WAIT SEC Q.N.A+P[2].N.A+Q.N.B+Q.F.Z", "ENDIF")


def made(folder, target, rows, data=DATA, layout=LAYOUT):
    (folder / "part.dat").write_text(layout.format(data))
    (folder / "part.src").write_text(krl(*rows))
    program = link(read(folder / "part.src")).program
    return program, convert(program, target, Context(ROBOT, on_loss="comment"), date="2026/01/01 00:00")


@pytest.mark.parametrize("target", ["rapid", "tp", "inform", "urscript"])
def test_members_are_set_copied_and_read(tmp_path, target):
    data = DATA.replace("FRAME F", "") if target == "inform" else DATA
    program, found = made(tmp_path, target, COPIED, data)
    if target in ("rapid", "tp"):
        assert not [loss for loss in found.translated.losses if loss.leaves_out]
        waits = time_plan(run_converted(found, target, ROBOT, program)).duration_s
        assert sum(waits) == pytest.approx(4 + 3 + 0.5 + 3)
    else:  # what is left out there, if anything, is told
        left = {loss.line for loss in found.translated.losses if loss.leaves_out}
        assert left <= set(range(2, len(COPIED) + 2))


@pytest.mark.parametrize("target", ["rapid", "tp"])
def test_members_that_are_arrays_are_arrays_of_their_own(tmp_path, target):
    layout = LAYOUT.replace("BOOL C", "REAL C[4],CHAR T[20]")
    rows = ("I=2", "P[I].C[3]=0.5", "Q.C[I]=2", 'P[I].T[]="ab"', "Q.T[]=P[I].T[]", "WAIT SEC Q.C[2]",
            "WAIT SEC P[2].C[I+1]")  # fmt: skip
    program, found = made(tmp_path, target, rows, "DECL PART_T P[3]\nDECL PART_T Q\nINT I\n", layout)
    assert not found.translated.losses
    waits = time_plan(run_converted(found, target, ROBOT, program)).duration_s
    assert waits.tolist() == [2.0, 0.5]
    (written,) = found.files.values()
    assert (b"P_T{I}" if target == "rapid" else b"SR[") in written


def test_members_that_are_arrays_are_not_copied_at_once(tmp_path):
    layout = LAYOUT.replace("BOOL C", "REAL C[4]")
    _, found = made(tmp_path, "rapid", ("P.C[2]=3", "P=Q"), "DECL PART_T P\nDECL PART_T Q\n", layout)
    assert [loss.line for loss in found.translated.losses if loss.leaves_out] == [3]  # its neighbour stays


def test_a_member_that_the_declared_type_lacks_is_told(tmp_path):
    _, found = made(tmp_path, "rapid", ("P[2].N.A=3", "P[2].LATER=7"), "DECL PART_T P[3]\n")
    ((line, says),) = {(loss.line, loss.says) for loss in found.translated.losses}
    assert (line, says.split(":")[0]) == (3, "P_LATER is not declared here")


def test_more_numbers_than_the_controller_has_fall_alone(tmp_path):
    data = "DECL PART_T P[900]\n"
    _, found = made(tmp_path, "tp", ("P[2].N.A=3", "P[2].N.B=1", "WAIT SEC 1"), data)
    assert {loss.line for loss in found.translated.losses if loss.leaves_out} == {3}
    assert "more than 1500" in next(loss.says for loss in found.translated.losses if loss.leaves_out)


def test_more_numbers_than_delivered_ask_for_a_larger_controller(tmp_path):
    _, found = made(tmp_path, "tp", ("P[2].N.A=3", "P[2].N.B=1"), "DECL PART_T P[120]\n")
    assert not [loss for loss in found.translated.losses if loss.leaves_out]
    says = "set the controller up for more variables than it is delivered with"
    assert [one.split()[0] for one in found.translated.asks[says]] == ["R[240]"]


def test_the_types_of_data_that_other_files_share_come_with_them(tmp_path):
    (tmp_path / "kinds.dat").write_text(
        "DEFDAT KINDS PUBLIC\nGLOBAL STRUC LID_T INT TURNS\nGLOBAL STRUC BIN_T LID_T LID,INT N[2]\n"
        "DECL GLOBAL BIN_T BINS[3]\nENDDAT\n"
    )
    _, found = made(tmp_path, "rapid", ("BINS[2].LID.TURNS=3", "BINS[2].N[1]=3"), "")
    assert not found.translated.losses
    assert b"VAR num BINS_N{3,2};" in next(iter(found.files.values()))


def test_frames_of_a_list_are_computed_by_components_before_they_are_chosen(tmp_path):
    """FANUC's frames have numbers: what a program computes with is a position register."""
    layout = "DEFDAT PART\nFRAME PALLET={X 700,Y 100,Z 50,A 0,B 0,C 0}\nFRAME BY={X 5,Y 6,Z 7,A 0,B 0,C 0}\n{}ENDDAT\n"
    rows = ("PALLET.X=BY.Y+10", "PALLET.Z=PALLET.Y", "$BASE=PALLET", "LIN {X 1,Y 2,Z 3,A 0,B 0,C 0}")
    program, found = made(tmp_path, "tp", rows, "", layout.replace("{X", "{{X").replace("0}", "0}}"))
    assert not [loss for loss in found.translated.losses if loss.leaves_out]
    (target,) = [step.target for step in run_converted(found, "tp", ROBOT, program).steps()]
    assert (1000 * target).tolist() == pytest.approx([16 + 1, 100 + 2, 100 + 3])
