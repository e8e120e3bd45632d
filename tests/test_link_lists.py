"""Data of other files are found whether or not every routine is."""

from __future__ import annotations

import pytest

import olp
from olp.runtime.interpreter import run
from olp.timing.timing import time_plan
from olp.transpile.convert import convert
from olp.transpile.link import link


@pytest.mark.parametrize("call", ["", "NOWHERE ( )\n"])
def test_a_global_list_is_found_beside_a_routine_that_is_nowhere(tmp_path, call):
    (tmp_path / "p.src").write_text(f"DEF p ( )\n{call}LIN XPICK\nEND\n")
    (tmp_path / "lists.src").write_text("DEF lists ( )\nEND\n")
    (tmp_path / "lists.dat").write_text(
        "DEFDAT lists PUBLIC\nDECL GLOBAL E6POS XPICK={X 900,Y 0,Z 900,A 0,B 90,C 0}\nENDDAT\n"
    )
    assert [d.name for d in link(olp.read(tmp_path / "p.src")).program.data] == ["XPICK"]


def _cell(tmp_path, *rows, shared):
    """A program whose list lies elsewhere in the robot's tree."""
    (tmp_path / "KRC" / "R1" / "Lists").mkdir(parents=True)
    (tmp_path / "KRC" / "R1" / "Jobs").mkdir()
    head = ["DEFDAT SHARED PUBLIC", *shared, "ENDDAT", ""]
    (tmp_path / "KRC" / "R1" / "Lists" / "shared.dat").write_text("\n".join(head))
    path = tmp_path / "KRC" / "R1" / "Jobs" / "p.src"
    path.write_text("\n".join(["DEF p ( )", *rows, "END", ""]))
    return path


def test_whole_numbers_of_a_list_elsewhere_are_divided_as_whole_numbers(tmp_path):
    shared = ["DECL GLOBAL INT ALL=7", "GLOBAL INT HALF=2", "DECL GLOBAL REAL SHARE=7.0"]
    path = _cell(tmp_path, "WAIT SEC ALL/HALF", "WAIT SEC SHARE/HALF", shared=shared)
    timing = time_plan(run(olp.read(path), "kuka/kr16-2"))
    assert timing.duration_s.tolist() == [3.0, 3.5]
    text = b"".join(convert(link(olp.read(path)).program, "rapid").files.values()).decode()
    assert "WaitTime ALL DIV HALF;" in text
    assert "WaitTime SHARE / HALF;" in text


def test_signals_of_a_list_elsewhere_are_signals(tmp_path):
    shared = [
        "GLOBAL SIGNAL doGrip $OUT[12]",
        "DECL GLOBAL SIGNAL diReady $IN[168]",
        "SIGNAL diPrivate $IN[3]",
        "GLOBAL SIGNAL goKind $OUT[20] TO $OUT[23]",
    ]
    rows = ["doGrip=TRUE", "WAIT FOR diReady", "PULSE(doGrip,TRUE,0.5)", "goKind=5", "diPrivate=TRUE"]
    path = _cell(tmp_path, *rows, shared=shared)
    program = olp.read(path)
    kinds = [type(s).__name__ for s in program.statements()]
    assert kinds == ["SetOutput", "Wait", "PulseOutput", "SetOutput", "Assign"]
    assert [d.name for d in program.data] == ["doGrip", "diReady", "goKind"]
    text = b"".join(convert(link(program).program, "tp").files.values()).decode()
    assert "DO[12]=ON" in text
    assert "WAIT (DI[168])" in text
    assert "DO[12]=PULSE,0.5sec" in text


@pytest.mark.parametrize(
    ("target", "set_", "asked"), [("rapid", "k:=2;", "IF at<>3 THEN"), ("tp", "]=2 ;", "]<>3) THEN")]
)
def test_enumerations_are_whole_numbers_elsewhere(tmp_path, target, set_, asked):
    """KRL counts the constants of an ENUM from 1."""
    shared = ["GLOBAL ENUM station HOME,INFEED,OUTFEED", "DECL GLOBAL station at=#HOME"]
    rows = ["ENUM kind RED,GREEN", "DECL kind k", "k=#GREEN", "IF at<>#OUTFEED THEN", "at=#INFEED", "ENDIF"]
    made = convert(link(olp.read(_cell(tmp_path, *rows, shared=shared))).program, target)
    text = b"".join(made.files.values()).decode()
    assert set_ in text
    assert asked in text
    assert not made.translated.losses
    assert "kind is a whole number there: RED 1, GREEN 2" in made.translated.notes


def test_what_other_programs_may_change_is_no_constant_without_a_word(tmp_path):
    """A program that chooses by a variable of a shared list is one for the value that the list has today."""
    shared = ["DECL GLOBAL INT SIDE=2", "DECL GLOBAL CONST INT LEFT=1"]
    path = _cell(tmp_path, "IF SIDE==LEFT THEN", "$OUT[1]=TRUE", "ENDIF", shared=shared)
    losses = convert(link(olp.read(path)).program, "tp").translated.losses
    assert [(loss.line, loss.says.split()[0]) for loss in losses] == [(2, "SIDE")]
