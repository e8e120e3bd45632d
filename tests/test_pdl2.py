"""Comau PDL2: its turns, speeds, corners, ports and blocks, against independent values."""

from __future__ import annotations

import numpy as np
import pytest
from handling_sample import SAMPLES, check_damage, check_plan, check_whole
from scipy.spatial.transform import Rotation

import olp
from olp.core.source import decode
from olp.core.units import mm
from olp.fluent import read_source
from olp.ir.expressions import Binary, Function, Logic, Named, Number, Signal
from olp.ir.program import (
    Assign,
    Blend,
    BlendKind,
    Declare,
    Dwell,
    EndWhile,
    Move,
    Path,
    Program,
    SpeedUnit,
    While,
)
from olp.languages.vendor import recognise

SAMPLE = SAMPLES / "pdl2" / "handling.pdl"


def program(*lines: str, data: str = "") -> Program:
    text = f"PROGRAM main\nVAR\n{data}\nBEGIN\n" + "".join(f"{line}\n" for line in lines) + "END main\n"
    return read_source(decode(text.encode(), "made.pdl"))


def codes(found: Program) -> list[str]:
    return [d.code for d in found.diagnostics]


def moves(found: Program) -> list[Move]:
    return [one for one in found.routines[0].body if isinstance(one, Move)]


@pytest.mark.parametrize("turn", [(30, 15, -72), (-113.3, 2.7, 146.3), (10, 0, 20), (5, 180, 7)])
def test_the_turn_of_a_position_is_zyz(turn: tuple[float, float, float]) -> None:
    found = program(f"MOVE LINEAR TO POS(10.5, -20, 30, {turn[0]}, {turn[1]}, {turn[2]}, 'W T1:0')")
    (target,) = moves(found)[0].targets
    np.testing.assert_allclose(target.values[:3], [10.5 * mm, -20 * mm, 30 * mm])
    ours = Rotation.from_euler("xyz", target.values[3:]).as_matrix()
    np.testing.assert_allclose(ours, Rotation.from_euler("ZYZ", turn, degrees=True).as_matrix(), atol=1e-12)
    assert target.native == (("CNFG", "W T1:0"),)


def test_a_computed_position_turns_like_a_written_one() -> None:
    lines = ("x := 31.5", "MOVE LINEAR TO POS(1,2,3,x,15,-72,'')", "MOVE LINEAR TO POS(1,2,3,31.5,15,-72,'')")
    plan = program("$LIN_SPD := 0.1", *lines, data="x : REAL").plan()
    first, second = plan.moves.target
    np.testing.assert_allclose(
        plan.positions.quaternion[first], plan.positions.quaternion[second], atol=1e-12
    )


def test_positions_compose_by_a_colon() -> None:
    plan = program("MOVE LINEAR TO POS(100,0,0,90,0,0,'') : POS(10,20,0,0,0,0,'')").plan()
    np.testing.assert_allclose(plan.positions.position[plan.moves.target[0]], [0.08, 0.01, 0], atol=1e-12)


def test_the_path_of_a_move_that_names_none_is_that_of_move_type() -> None:
    found = program("MOVE TO {1,2,3,4,5,6}", "$MOVE_TYPE := LINEAR", "MOVE TO POS(1,2,3,4,5,6,'')")
    first, second = moves(found)
    assert (first.path, second.path) == (Path.JOINT, Path.LINEAR)
    assert first.speed is not None
    assert (first.speed.unit, first.speed.value.literal) == (SpeedUnit.FRACTION, 1.0)
    assert second.speed is None


def test_a_move_carries_what_stands_behind_with_over_several_lines() -> None:
    found = program(
        "MOVEFLY LINEAR TO p,",
        " WITH $LIN_SPD = 0.6, $FLY_DIST = 12,",
        " WITH $TOOL = t,",
        "ENDMOVE",
        data="p, t : POSITION",
    )
    (move,) = moves(found)
    assert codes(found) == []
    assert move.speed is not None
    assert (move.speed.unit, move.speed.value.literal) == (SpeedUnit.TRAVEL, 0.6)
    assert move.blend is not None
    assert move.blend.value is not None
    assert move.blend.value.literal == pytest.approx(0.012)
    assert move.tool is not None


def test_a_setting_behind_a_move_ends_with_its_line() -> None:
    """Nothing but a comma or an & takes the next line, unless that is WITH or ENDMOVE."""
    first, second, third = moves(
        program(
            "MOVE LINEAR TO p WITH $LIN_SPD = 0.2",
            "MOVE LINEAR TO p, WITH $LIN_SPD = 0.3, CONDITION[2],",
            " WITH CONDITION[1],",
            "ENDMOVE",
            "MOVE LINEAR TO p WITH $LIN_SPD = 0.4",
            "ENDMOVE",
            data="p : POSITION",
        )
    )
    assert [one.line for one in (first, second, third)] == [5, 6, 9]
    assert [one.speed and one.speed.value.literal for one in (first, second, third)] == [0.2, 0.3, 0.4]


def test_a_semicolon_may_end_an_instruction() -> None:
    found = program("MOVE LINEAR TO p ADVANCE;", "DELAY 100 ; -- then", data="p : POSITION;")
    assert codes(found) == []
    assert moves(found)[0].no_wait


def test_values_that_a_position_leaves_out_are_zero() -> None:
    found = program("MOVE LINEAR TO POS(0)", "MOVE LINEAR TO POS(10, 20, 30)")
    assert codes(found) == []
    np.testing.assert_allclose(moves(found)[1].targets[0].values, [0.01, 0.02, 0.03, 0, 0, 0], atol=1e-12)


def test_begin_cycle_runs_again() -> None:
    found = read_source(decode(b"PROGRAM main\nBEGIN CYCLE\n DELAY 150\nEND main\n", "a.pdl"))
    assert codes(found) == []
    assert [type(one) for one in found.routines[0].body] == [While, Dwell, EndWhile]


def test_a_variable_is_added_to() -> None:
    found = program("n := 10", "n += 150", "n -= 50", "DELAY n", data="n : INTEGER")
    assert codes(found) == []
    assert [step.duration for step in found.plan().steps()] == pytest.approx([0.11])


def test_a_program_goes_on_during_a_move_with_advance() -> None:
    first, second = moves(program("MOVE LINEAR TO p ADVANCE", "MOVE LINEAR TO p"))
    assert (first.no_wait, second.no_wait) == (True, False)


def test_only_a_flying_move_rounds_its_corner() -> None:
    first, second = moves(program("MOVE LINEAR TO p", "MOVEFLY LINEAR TO p"))
    assert first.blend is not None
    assert first.blend.value is not None
    assert first.blend.value.literal == 0
    assert second.blend == Blend(BlendKind.CONTINUOUS)


def test_ports_are_signals_and_delays_are_milliseconds() -> None:
    body = program("$DOUT[5] := ON", "DELAY 350", "PULSE $DOUT[2] FOR 500").routines[0].body
    assert body[0].signal == Signal("out", Number(5))  # type: ignore[union-attr]
    assert body[1].duration.literal == pytest.approx(0.35)  # type: ignore[union-attr]
    assert body[2].duration.literal == pytest.approx(0.5)  # type: ignore[union-attr]


def test_a_pulse_is_waited_for_unless_it_goes_on_in_advance() -> None:
    for line, wanted in (("PULSE $DOUT[2] FOR 500", [0.5]), ("PULSE $DOUT[2] FOR 500 ADVANCE", [])):
        body = program(line).routines[0].body
        assert [one.duration.literal for one in body if isinstance(one, Dwell)] == pytest.approx(wanted)


def test_a_case_runs_its_branch_and_a_cycle_runs_again() -> None:
    found = program(
        "n := 2", "SELECT n OF",
        "CASE (1, 3):", "DELAY 100", "CASE (2):", "DELAY 200", "ELSE:", "DELAY 300", "ENDSELECT",
        data="n : INTEGER",
    )  # fmt: skip
    assert [step.duration for step in found.plan().steps()] == pytest.approx([0.2])
    found = program("DELAY 50", "CYCLE", "DELAY 100")
    assert codes(found) == []
    assert [step.duration for step in found.plan().steps()][:2] == pytest.approx([0.05, 0.1])


def test_routines_take_arguments_and_names_have_no_case() -> None:
    text = (
        "PROGRAM main\nVAR\n n : INTEGER\nROUTINE sub(k : INTEGER; VAR r : INTEGER)\nBEGIN\n R := K * 2\nEND sub\n"
        "BEGIN\n SUB(150, N)\n DELAY n\nEND MAIN\n"
    )
    found = read_source(decode(text.encode(), "a.pdl"))
    assert codes(found) == []
    assert [step.duration for step in found.plan().steps()] == pytest.approx([0.3])


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("MOVE LINEAR p", "P590"),
        ("MOVE CIRCULAR TO p", "P590"),
        ("DELAY )", "P590"),
        ("MOVE ABOUT p BY 10", "P595"),
        ("MOVE LINEAR ALONG track[1..4] WITH $LIN_SPD = 0.3", "P595"),
        ("MOVE ARM[1] TO p SYNCMOVE ARM[2] TO q", "P595"),
        ("$HDIN_SUSP := 3", "P591"),
        ("OPEN HAND 1", "P591"),
        ("MOVE RELATIVE p", "P595"),
        ("n := " + "(" * 150 + "1" + ")" * 150, "P592"),
        ("WHILE TRUE DO", "P593"),
        ("GOTO nowhere", "P593"),
    ],
)
def test_each_mistake_has_its_code_and_a_place(line: str, code: str) -> None:
    (found,) = program(line).diagnostics
    assert (found.code, found.line) == (code, 5)
    assert found.help


def test_files_programs_and_handlers_have_codes() -> None:
    assert codes(read_source(decode(b"poem\n", "a.pdl"))) == ["P594"]
    assert codes(read_source(decode(b"PROGRAM a\nBEGIN\n", "a.pdl"))) == ["P593"]
    assert codes(program("CONDITION[1] :", "WHEN $DIN[1]+ DO", "PAUSE", "ENDCONDITION"))[:1] == ["P596"]


def test_the_sample_goes_where_its_numbers_say() -> None:
    check_plan(olp.read(SAMPLE).plan("yaskawa/gp25"))


def test_the_sample_is_read_whole() -> None:
    check_whole([SAMPLE])


def test_no_damage_makes_the_reader_raise_or_hang() -> None:
    check_damage(SAMPLE, 8)


@pytest.mark.parametrize(
    ("text", "name"), [("PROGRAM p\nBEGIN\nEND p\n", "pdl2"), ("PROGRAM p\nDELAY 100\nEND\n", None)]
)
def test_a_text_with_a_program_of_another_language_is_not_taken(text: str, name: str | None) -> None:
    found = recognise(decode(text.encode(), "unnamed"))
    assert (found and found.name) == name


@pytest.mark.parametrize(
    ("sets", "other"),
    [
        (("arm_number := 1",), ()),
        (("arm_number := 1", "arm_number := 2"), (("arm", Named("arm_number")),)),
        ((), (("arm", Named("arm_number")),)),
    ],
)
def test_a_move_of_an_arm_by_name_is_plain_where_the_name_holds_1(
    sets: tuple[str, ...], other: tuple[object, ...]
) -> None:
    found = program(*sets, "MOVE ARM[arm_number] TO {1,2,3,4,5,6}", data="arm_number : INTEGER")
    assert moves(found)[0].other == other


def test_and_or_xor_and_not_of_whole_numbers_compute_with_their_bits() -> None:
    """They were conditions: 13 AND 6 was 1."""
    data = "a, n : INTEGER\nb, c : BOOLEAN"
    found = program("n := a AND 6", "n := NOT a", "n := 13 XOR a OR 1", "b := b AND NOT c", data=data)
    values = [one.value for one in found.routines[0].body if isinstance(one, Assign)]
    assert values[0] == Binary("and", Named("a"), Number(6))
    assert values[1] == Function("bit-not", (Named("a"),))
    assert values[2] == Binary("or", Binary("xor", Number(13), Named("a")), Number(1))
    assert isinstance(values[3], Logic)


def test_a_constant_has_the_type_of_its_value() -> None:
    found = program("x := m", data="CONST\nm = 5\nr = 2.5\nt = 'a'\nf = TRUE\nVAR\nx : INTEGER")
    types = {d.name: d.type for d in (*found.data, *found.routines[0].body) if isinstance(d, Declare)}
    assert [types[name] for name in "mrtf"] == ["integer", "real", "string", "boolean"]


def test_a_routine_changes_the_variable_that_it_is_handed() -> None:
    """By reference, but not one in brackets, of which no copy is made here: it is told."""
    rows = (
        "ROUTINE up(k, l : INTEGER)",
        "BEGIN",
        "  k := k + l",
        "END up",
        "BEGIN",
        "  n := 1",
        "  up(n, 1)",
    )
    text = "\n".join(
        ["PROGRAM z", "VAR n : INTEGER", *rows, "  IF n = 2 THEN", "    DELAY 100", "  ENDIF", "END z"]
    )
    found = read_source(decode(f"{text}\n".encode(), "z.pdl"))
    assert [one.by_reference for routine in found.routines for one in routine.parameters] == [True, False]
    assert [step.duration for step in found.plan().steps()] == pytest.approx([0.1])
    found = read_source(decode(text.replace("up(n, 1)", "up((n), 1)").encode(), "z.pdl"))
    assert any("brackets" in d.message for d in found.diagnostics)
