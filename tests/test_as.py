"""Kawasaki AS: its turns, speeds, blends, signals and blocks, against independent values."""

from __future__ import annotations

from importlib import import_module

import numpy as np
import pytest
from handling_sample import SAMPLES, check_damage, check_plan, check_whole
from scipy.spatial.transform import Rotation

import olp
from olp.core.result_cache import TextCache, remembering
from olp.core.source import decode
from olp.core.units import mm
from olp.fluent import read_source
from olp.ir.expressions import Number, Signal, SignalState
from olp.ir.program import Declare, Move, Program, SpeedUnit, While
from olp.ir.program import Path as Shape

SAMPLE = SAMPLES / "as" / "handling.as"


def program(*lines: str, tables: str = "") -> Program:
    text = ".PROGRAM main()\n" + "".join(f"{line}\n" for line in lines) + f".END\n{tables}"
    return read_source(decode(text.encode(), "made.as"))


def codes(found: Program) -> list[str]:
    return [d.code for d in found.diagnostics]


def moves(found: Program) -> list[Move]:
    return [one for one in found.routines[0].body if isinstance(one, Move)]


def test_the_module_whose_name_is_a_word_of_python_can_be_imported() -> None:
    assert import_module("olp.languages.vendors.as").VENDOR.name == "as"


@pytest.mark.parametrize("turn", [(30, 15, -72), (-113.3, 2.7, 146.3), (10, 0, 20), (5, 180, 7)])
def test_the_turn_of_a_transformation_is_zyz(turn: tuple[float, float, float]) -> None:
    found = program(f"LMOVE TRANS(10.5,-20,30,{turn[0]},{turn[1]},{turn[2]})")
    (target,) = moves(found)[0].targets
    np.testing.assert_allclose(target.values[:3], [10.5 * mm, -20 * mm, 30 * mm])
    ours = Rotation.from_euler("xyz", target.values[3:]).as_matrix()
    np.testing.assert_allclose(ours, Rotation.from_euler("ZYZ", turn, degrees=True).as_matrix(), atol=1e-12)


def test_texts_choose_their_case_and_numbers_may_have_a_colon() -> None:
    found = program(
        '$s = "b"', "SCASE $s OF", 'SVALUE "a":', "TWAIT 1", 'SVALUE "b", "c":', "TWAIT 2", "ANY:", "TWAIT 3", "END",
        "GOTO 20", "TWAIT 4", "20: TWAIT 5",
    )  # fmt: skip
    assert codes(found) == []
    assert [step.duration for step in found.plan().steps()] == pytest.approx([2, 5])


@pytest.mark.parametrize("line", ["DRAW 10,,20,,,5", "DRAW 0,0,-50,0,0,0,100", "TDRAW ,,20,,,,50"])
def test_a_draw_that_turns_or_has_a_speed_is_kept_and_told(line: str) -> None:
    found = program(line)
    assert (codes(found), moves(found)) == (["P585"], [])


def test_the_first_of_a_chain_of_arcs_is_told() -> None:
    found = program("JMOVE a", "C1MOVE b", "C1MOVE c", "C2MOVE d")
    assert [(one.code, one.line) for one in found.diagnostics] == [("P585", 3)]
    assert [one.line for one in moves(found)] == [2, 5]


def test_a_computed_transformation_turns_like_a_written_one() -> None:
    plan = program(
        "x = 31.5",
        "LMOVE TRANS(10,20,30,x,15,-72)",
        "LMOVE TRANS(10,20,30,31.5,15,-72)",
        "LMOVE TRANS(1,2,3)",
    ).plan()
    first, second, _ = plan.moves.target
    np.testing.assert_allclose(
        plan.positions.quaternion[first], plan.positions.quaternion[second], atol=1e-12
    )


def test_speed_and_accuracy_hold_for_one_move_without_always() -> None:
    found = program("SPEED 120.5 MM/S", "ACCURACY 5", "LMOVE a", "LMOVE b", "SPEED 40", "JMOVE c")
    first, second, third = moves(found)
    assert first.speed is not None
    assert first.speed.unit is SpeedUnit.TRAVEL
    assert first.speed.value.literal == pytest.approx(0.1205)
    assert first.blend is not None
    assert first.blend.value is not None
    assert first.blend.value.literal == pytest.approx(0.005)
    assert second.speed is None
    assert second.blend is not None
    assert second.blend.value is None
    assert third.speed is not None
    assert third.speed.unit is SpeedUnit.FRACTION
    assert third.speed.value.literal == pytest.approx(0.4)


def test_two_halves_make_one_arc() -> None:
    (arc,) = moves(program("C1MOVE a", "C2MOVE b"))
    assert arc.path is Shape.CIRCULAR
    assert arc.via is not None
    assert codes(program("C2MOVE b")) == codes(program("C1MOVE b")) == ["P587"]


def test_approach_and_departure_go_back_along_the_tool() -> None:
    plan = program(
        "LMOVE TRANS(500,10,300,20,160,40)", "LAPPRO TRANS(500,10,300,20,160,40),50", "LDEPART 20"
    ).plan()
    place = plan.positions.position[plan.moves.target]
    axis = Rotation.from_euler("ZYZ", (20, 160, 40), degrees=True).as_matrix()[:, 2]
    np.testing.assert_allclose(place[1] - place[0], -0.05 * axis, atol=1e-12)
    np.testing.assert_allclose(place[2] - place[1], -0.02 * axis, atol=1e-12)


def test_signals_are_outputs_inputs_or_flags_by_their_numbers() -> None:
    body = program("SIGNAL 5,-6", "SWAIT 1007").routines[0].body
    assert [one.signal for one in body[1:3]] == [Signal("out", Number(5)), Signal("out", Number(6))]  # type: ignore[union-attr]
    assert [one.value for one in body[1:3]] == [SignalState(True), SignalState(False)]  # type: ignore[union-attr]
    assert body[3].condition == Signal("in", Number(7))  # type: ignore[union-attr]


def test_end_closes_whatever_is_open() -> None:
    found = program(
        "FOR i = 1 TO 2",
        "IF i==1 THEN",
        "WHILE FALSE DO",
        "TWAIT 1",
        "END",
        "ELSE",
        "TWAIT 0.25",
        "END",
        "END",
    )
    assert codes(found) == []
    assert [step.duration for step in found.plan().steps()] == [0.25]
    assert any(isinstance(one, While) for one in found.routines[0].body)


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("LMOVE", "P580"),
        ("TWAIT )", "P580"),
        ("PULSE -7,0.5", "P580"),
        ("ALIGN", "P585"),
        ("RIGHTY", "P581"),
        ("n = " + "(" * 150 + "1" + ")" * 150, "P582"),
        ("WHILE TRUE DO", "P583"),
        ("GOTO 10", "P583"),
    ],
)
def test_each_mistake_has_its_code_and_a_place(line: str, code: str) -> None:
    (found,) = program(line).diagnostics
    assert (found.code, found.line) == (code, 2)
    assert found.help


def test_no_branch_stands_behind_else() -> None:
    (found,) = program("IF n == 1 THEN", "ELSE", "n = 2", "ELSE", "END").diagnostics
    assert (found.code, found.line) == ("P583", 5)


def test_rows_files_and_unclosed_programs_have_codes() -> None:
    assert codes(program(tables=".TRANS\np1 1 2 x\n.END\n")) == ["P586"]
    assert codes(read_source(decode(b"poem\n", "a.as"))) == ["P584"]
    assert codes(read_source(decode(b".PROGRAM a()\n", "a.as"))) == ["P583"]
    assert codes(program("SPEED 50 ALWAYS")) == ["P588"]


def test_a_saved_array_counts_from_zero_and_loops_reach_it() -> None:
    table = ".TRANS\np[0] 1 2 3 0 0 0\np[1] 11 12 13 0 0 0\n.END\n"
    plan = program("SPEED 10 MM/S ALWAYS", "FOR i = 0 TO 1", "LMOVE p[i]", "END", tables=table).plan()
    np.testing.assert_allclose(plan.positions.position[plan.moves.target][:, 0], [0.001, 0.011])


def test_all_rows_of_a_saved_array_are_as_long_as_the_longest() -> None:
    table = ".TRANS\np[1,1] 1 2 3 0 0 0\np[1,3] 11 12 13 0 0 0\np[2,0] 21 22 23 0 0 0\n.END\n"
    (declared,) = program("LMOVE p[1,1]", tables=table).data
    rows = [[value for _, value in row.members] for _, row in declared.value.members]  # type: ignore[union-attr]
    assert [len(row) for row in rows] == [size.value for size in declared.sizes[1:]] * 3 == [4] * 3  # type: ignore[attr-defined]
    known = {(i, j): row[j].values[0] / mm for i, row in enumerate(rows) for j in range(4)}
    known = {place: round(x, 9) for place, x in known.items() if x == x}
    assert known == {(1, 1): 1, (1, 3): 11, (2, 0): 21}


def test_the_sample_goes_where_its_numbers_say() -> None:
    check_plan(olp.read(SAMPLE).plan("yaskawa/gp25"))


def test_the_sample_is_read_whole() -> None:
    check_whole([SAMPLE])


def test_no_damage_makes_the_reader_raise_or_hang() -> None:
    check_damage(SAMPLE, 7)


def test_lines_that_were_read_before_stand_where_they_stand_now() -> None:
    """As in a merge or an editor: versions of one text, with what was understood of their lines remembered."""
    lines = ["SPEED 40 MM/S", "LMOVE p1", "SPEED 50 MM/S", "LMOVE p1", "LMOVE p2"]
    versions = [lines, [*lines[:2], "SIGNAL 3", *lines[2:]], lines]
    fresh = [program(*one).routines for one in versions]
    with remembering(TextCache()):
        again = [program(*one).routines for one in versions]
    assert again == fresh
    assert [one.line for one in moves(program(*versions[1]))] == [3, 6, 7]


SAVED = """.SYSDATA
BASE           -120.000   143.000     0.000     0.000     0.000     0.000
TOOL              0.000     0.000    50.000     0.000     0.000     0.000
.END
.AUXDATA
1HOME            56.469     1.695   -86.766   -65.905   -71.719    -9.451     0.000     0.000
.END
"""


def test_a_saved_controller_says_the_base_the_tool_and_where_home_is() -> None:
    found = program("HOME", "LMOVE TRANS(500,10,300)", tables=SAVED)
    assert codes(found) == []
    plan = found.plan(robot="kawasaki/rs007n")
    there = plan.positions.position[plan.moves.target][-1]
    np.testing.assert_allclose(there / mm, [380, 153, 300], atol=1e-9)
    assert "#HOME" in {one.name for one in found.data}


def test_functions_of_places_and_texts_are_read() -> None:
    found = program("x = DZ(a)+INSTR($s,\"b\")*PI", "LMOVE a+RX(30)", "x = ASC($MID($s,2,1))",
                    tables='.TRANS\na 1 2 3 0 0 0\n.END\n.STRINGS\n$s = "ab"\n.END\n')  # fmt: skip
    assert codes(found) == []
    plan = found.plan()
    w, x, y, z = plan.positions.quaternion[plan.moves.target][0]
    turned = Rotation.from_quat((x, y, z, w)).as_rotvec(degrees=True)
    np.testing.assert_allclose(turned, [30, 0, 0], atol=1e-9)


def test_only_a_dot_in_front_makes_a_variable_the_programs_own() -> None:
    lines = ("p.offset = 5", "n.o[2] = 1", ".x = 2", '$.t = "a"')
    found = program(*lines)
    assert {one.name for one in found.data} >= {"p.offset", "n.o"}
    assert {one.name for one in found.routines[0].body if isinstance(one, Declare)} == {".x", "$.t"}


COUNTED = """.PROGRAM go()
  .n = 3
  .last[1] = 4
  .last[2] = 6
  FOR .i = 1 TO .n - 1
    FOR .j = 0 TO .last[.i]
      POINT .way[.i,.j] = home.p
    END
  END
  CALL trace(.&way[,])
.END
.PROGRAM trace(.&p[,])
  JMOVE .p[1,0]
  JMOVE .p[2,7]
.END
.TRANS
home.p 400 0 300 0 180 0
.END
"""


def sizes_of_way(text):
    routine = read_source(decode(text.encode(), "part.as"), vendor="as").routines[0]
    return [
        [size.value for size in s.sizes] for s in routine.body if isinstance(s, Declare) and s.name == ".way"
    ]


def test_the_ends_of_loops_tell_how_large_an_array_is():
    """Indices begin with 0: `.way[2,7]` is in the third row, the eighth. 100 x 100 were taken, as of open ones."""
    assert sizes_of_way(COUNTED) == [[3, 8]]


@pytest.mark.parametrize(
    ("row", "other"),
    [
        ("  .n = 3", "  .n = n"),
        ("  .last[1] = 4", '  PROMPT "rows", .last[1]'),
        ("  .n = 3", "  .n = 3\n  CALL ask(.n)"),
        ("    FOR .j = 0 TO .last[.i]", "    FOR .j = 0 TO .last[.i]\n      .j = .j + k"),
        ("CALL trace(.&way[,])", "CALL elsewhere(.&way[,])"),
    ],
    ids=["set by others", "asked", "handed over", "counted otherwise", "handed to an unknown program"],
)
def test_a_loop_whose_end_nothing_tells_leaves_an_array_open(row, other):
    assert sizes_of_way(COUNTED.replace(row, other)) == [[100, 100]]


def test_an_array_of_a_table_grows_where_the_program_sets_elements_beyond_it():
    """It had the table's two elements, and what was set beyond was the next register of the target."""
    rows = ["FOR i = 1 TO 9 STEP 2", "  a[i] = i", "END", "b[n] = 3"]
    table = [".REALS", "a[1] = 2", "b[1] = 3", ".END"]
    text = "\n".join([".PROGRAM main()", *rows, ".END", *table, ""])
    found = read_source(decode(text.encode(), "part.as"), vendor="as")
    sizes = {d.name: [size.value for size in d.sizes] for d in found.data}
    assert sizes["a"] == [10]
    assert sizes["b"] == [2]
    assert ["P589", 5] in [[d.code, d.line] for d in found.diagnostics]


def test_one_axis_is_driven_by_degrees_with_a_share_of_its_speed():
    found = program(
        "JMOVE #[0,10,-80,0,-90,0]", "DRIVE 6, 45, 50", "SPEED 20", "DRIVE 1, -10", "DRIVE 7, 1", "DRIVE n, 1"
    )
    plan = found.plan(robot="kawasaki/rs007l")
    axes = np.degrees(plan.positions.axes[plan.moves.target])[:, :6]
    expected = [[0, 10, -80, 0, -90, 0], [0, 10, -80, 0, -90, 45], [-10, 10, -80, 0, -90, 45]]
    np.testing.assert_allclose(axes, expected, atol=1e-9)
    speeds = [s.speed.value.literal for s in found.statements() if isinstance(s, Move) and s.speed]
    assert speeds[-2:] == pytest.approx([0.5, 0.2])
    assert {"P580", "P585"} <= {d.code for d in found.diagnostics}


def test_what_a_coordinate_or_a_parameter_is_assigned_to_is_a_number():
    text = ".PROGRAM main()\nx = DX(a)\nCALL sub(x)\n.END\n.PROGRAM sub(.n)\n.m = .n\nTWAIT .m\n.END\n"
    text += ".TRANS\na 400 0 300 0 180 0\n.END\n"
    found = read_source(decode(text.encode(), "main.as"))
    declared = {d.name: d.type for d in (*found.data, *found.statements()) if isinstance(d, Declare)}
    assert (declared["x"], declared[".m"]) == ("real", "real")


@pytest.mark.parametrize(("name", "type_"), [(".p", "position"), ("#q", "joints")])
def test_what_point_sets_is_a_place_also_where_nothing_tells_its_value(name, type_):
    """It was data of no type, which no other language has."""
    found = program(f"POINT {name} = letter[2]", "LMOVE letter[3]")
    declared = [*found.data, *(one for one in found.routines[0].body if isinstance(one, Declare))]
    assert [one.type for one in declared if one.name == name] == [type_]


def test_a_text_that_nothing_sets_is_no_value_of_the_controller() -> None:
    """`$` begins the names of texts; it was taken for the number 0 that the controller sets."""
    plan = program('$a = $b + "x"', "n = $c[1]").plan()
    assert not any("the controller sets it" in one.says for one in plan.assumptions)
    assert [d.code for d in plan.diagnostics] == ["I209", "I209"]


def test_whether_moves_stop_behind_a_branch_with_cp_is_told() -> None:
    found = program("IF SIG(1) THEN", "CP OFF", "END", "ACCURACY 20 ALWAYS", "LMOVE p")
    assert codes(found) == ["P589"]
    assert codes(program("CP OFF", "LMOVE p", "CP ON")) == []
