"""What reading the translations of real programs beside their sources showed: a small program for each cause."""

from __future__ import annotations

import re

import pytest
from translated_texts import converted, read, script, translated

from olp.core.source import load
from olp.ir import program as st
from olp.languages.vendors.urscript.reader import read_program
from olp.transpile import Context
from olp.transpile.context import Fate
from olp.transpile.convert import convert
from olp.transpile.link import link

_LIBRARY = """def weld_on():
  weld = 1
  sleep(0.5)
end
def weld_off():
  weld = 0
end
"""


@pytest.mark.parametrize("target", ["krl", "rapid", "tp"])
def test_a_function_of_a_library_sets_its_values_each_time_it_is_called(tmp_path, target):
    (tmp_path / "weld.script").write_text(_LIBRARY)
    (tmp_path / "a.script").write_text(script("weld_on()", "weld_off()", "weld_on()"))
    program = link(read_program(load(str(tmp_path / "a.script"))), target).program
    made = convert(program, target, Context(on_loss="comment"), date="2026/01/01 00:00").files
    text = b"\n".join(made.values()).decode("cp1252").lower()
    on = re.search(r"(?:def|proc|/prog) +weld_on\b.*?(?:\bend\b|endproc|/end)", text, re.DOTALL)
    assert on is not None
    assert re.search(r"weld\]?:?=1\b", on[0])


@pytest.mark.parametrize(
    ("target", "place", "number"),
    [
        ("krl", "DECL E6POS p_between", "DECL REAL n"),
        ("rapid", "VAR robtarget p_between", "VAR num n"),
        ("tp", "L PR[", "IF (R["),
        ("inform", "MOVL P0", "IFTHEN R0"),
    ],
)
def test_what_a_function_of_no_file_returns_is_what_its_uses_take_it_for(target, place, number):
    rows = ("local p_between = between(1)", "movel(p_between, v=0.1)", "local n = count(1)", "if n > 3:")
    text = script(*rows, "  sleep(1)", "end")
    made = translated(text, "urscript", target)
    assert place in made
    assert number in made
    told = {
        loss.line for loss in converted(text, "urscript", target).translated.losses if loss.part == "variable"
    }
    assert told == {2, 4}
    assert all(
        loss.fate is Fate.APPROXIMATED for loss in converted(text, "urscript", target).translated.losses
    )


def robot_as(*rows, tables=()):
    return "\n".join([".PROGRAM part()", *rows, ".END", *tables, ""])


_TRUTHS = (
    "n = 5",
    "IF n AND SIG(1002) THEN",
    "SIGNAL 3",
    "END",
    "w = TRUE",
    "WHILE w DO",
    "w = SIG(1001)",
    "END",
)


@pytest.mark.parametrize(
    ("target", "wanted"),
    [
        ("krl", ("IF (n<>0) AND $IN[2] THEN", "DECL BOOL w=FALSE", "w=$IN[1]", "WHILE w")),
        ("rapid", ("IF n<>0 AND di2=1 THEN", "VAR bool w;", "w:=di1=1;", "WHILE w DO")),
        ("urscript", ("if (n != 0 and get_standard_digital_in(2)):", "global w = False", "while (w):")),
    ],
)
def test_numbers_that_decide_in_as_are_compared_with_zero_elsewhere(target, wanted):
    made = translated(robot_as(*_TRUTHS), "as", target)
    assert [row for row in wanted if row not in made] == []


def test_a_variable_of_as_that_is_also_a_number_has_numbers_for_true_and_false():
    made = translated(robot_as("v = TRUE", "IF v == FALSE THEN", "v = v - 1", "END"), "as", "krl")
    assert "DECL REAL v" in made
    assert "v=-1" in made
    assert "IF v==0 THEN" in made


_COUNTS = {
    "as": robot_as("count = count + 1", "IF count > 3 THEN", "SIGNAL 1", "END"),
    "pdl2": "\n".join(
        (
            "PROGRAM part",
            "VAR count : INTEGER",
            "BEGIN",
            "  count := count + 1",
            "  IF count > 3 THEN",
            "    $DOUT[1] := ON",
            "  ENDIF",
            "END part",
            "",
        )
    ),
}


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "tp", "urscript"])
@pytest.mark.parametrize("vendor", list(_COUNTS))
def test_what_other_programs_may_have_set_is_told_where_it_is_read_first(vendor, target):
    done = converted(_COUNTS[vendor], vendor, target).translated
    assert any("nothing has set count" in loss.says for loss in done.losses)
    begun = _COUNTS[vendor].replace("count + 1", "2")
    assert not [loss for loss in converted(begun, vendor, target).translated.losses if "count" in loss.says]


@pytest.mark.parametrize("target", ["krl", "rapid", "urscript"])
def test_the_size_that_is_taken_for_an_array_of_as_is_told(target):
    text = robot_as("FOR i = 1 TO n", "t[i] = i", "END", tables=(".REALS", "n = 3", ".END"))
    says = [loss.says for loss in converted(text, "as", target).translated.losses if loss.line == 3]
    assert says == ["nothing here tells how many elements t has: 1000 are taken"]


def overrides(*rows):
    place = "{{{}, 20, -90, 0, 60, 0}}"
    moves = (row.format(p=place.format(10 * n)) for n, row in enumerate(rows))
    return read("\n".join(("PROGRAM part", "BEGIN", *moves, "END part", "")), "pdl2")


def test_the_overrides_of_pdl2_are_multiplied_and_each_stands_in_for_itself_alone():
    program = overrides("$ARM_OVR := 50", "MOVE JOINT TO {p} WITH $PROG_SPD_OVR = 20", "$GEN_OVR := 100")
    assert [type(s) for s in program.routines[0].body] == [st.SetOverride, st.Move]
    assert not program.diagnostics
    program = overrides(
        "$ARM_OVR := 50", "MOVE JOINT TO {p} WITH $ARM_OVR = 20", "$PROG_SPD_OVR := 40", "MOVE JOINT TO {p}"
    )
    assert [(d.code, d.line) for d in program.diagnostics] == [("P595", 4), ("P591", 5)]


@pytest.mark.parametrize(
    ("target", "asked"), [("inform", True), ("krl", True), ("tp", True), ("rapid", False)]
)
def test_a_speed_in_a_variable_that_a_share_may_not_reach_is_asked_to_be_kept_below(target, asked):
    """URScript's arm moves as fast as it can; where 191 % is written, the controller stops."""
    move = "movej([{q}, -1.5, 1.5, -1.5, -1.5, 0.0], a=1.4, v={v})"
    text = script("quick = 6.0", move.format(q=0.1, v="quick"), move.format(q=0.4, v=6.0))
    found = [name for says in converted(text, "urscript", target).translated.asks.items() for name in says[1]]
    named = [name for name in found if re.match(r"quick: up to [\d.]+ rad/s, which is 100 %", name)]
    assert bool(named) is asked
