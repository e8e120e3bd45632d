"""What programs of KRL hold that FANUC has under another name: modes, elements of joint values, the arm's own place."""

from __future__ import annotations

import re

import pytest
from translated_texts import ROBOT, converted, krl, read, run_elsewhere, translated

from olp.runtime.interpreter import run
from olp.transpile.compare import WRITTEN, compare_plans
from olp.transpile.context import Fate

JOINTS = "{A1 10,A2 -80,A3 90,A4 0,A5 30,A6 0}"
REACHED = "{A1 0,A2 -10,A3 20,A4 0,A5 10,A6 0}"


def listing(text):
    """The lines between /MN and /POS, without their numbers."""
    body = translated(text, "krl", "tp").partition("/MN")[2].partition("/POS")[0]
    return [re.sub(r"^\s*\d+:\s*|\s*;\s*$", "", row) for row in body.splitlines() if row.strip()]


def agreeing_steps(text):
    found = compare_plans(
        run(read(text, "krl"), robot=ROBOT), run_elsewhere(text, "krl", "tp"), tolerances=WRITTEN
    )
    assert not found.found
    return found.steps


def left_out(text, target="tp"):
    return [loss.says for loss in converted(text, "krl", target).translated.losses if loss.leaves_out]


@pytest.mark.parametrize("condition", ["$T1 OR $T2", "($T2 OR $T1)", "$T2 OR $IN[3] OR $T1"])
def test_a_manual_mode_is_the_enabled_pendant(condition):
    rows = listing(krl(f"IF {condition} THEN", "HALT", "ENDIF"))
    assert any("UO[8]" in row for row in rows)
    assert any("DI[3]" in row for row in rows) is ("IN[3]" in condition)
    assert "PAUSE" in rows


@pytest.mark.parametrize("condition", ["$T1 AND $T2", "$T2 AND $IN[3]"])
def test_the_manual_mode_at_full_speed_is_not_told_by_the_pendant(condition):
    """A flag tells it, which something has to set."""
    made = converted(krl(f"IF {condition} THEN", "HALT", "ENDIF"), "krl", "tp")
    says = "whether the mode is manual at full speed is asked of a variable, manual_full, which something has to set"
    assert says in [loss.says for loss in made.translated.losses]
    assert (
        "manual_full"
        in made.translated.asks["set, all the time, what the source's controller tells of itself"]
    )


def test_an_element_of_joint_values_that_nothing_changes_is_a_number():
    text = krl(f"DECL AXIS D={JOINTS}", "DECL REAL R", "R=D.A2+D.A5")
    assert "R[1:R]=(-80)+30" in listing(text)
    assert left_out(text) == []


def test_an_element_of_joint_values_that_change_is_a_registers():
    text = krl(f"DECL AXIS D={JOINTS}", f"DECL AXIS P={JOINTS}", "P.A1=D.A1+45", "PTP P")
    assert any(re.fullmatch(r"PR\[\d+,1:P\]=10\+45", row) for row in listing(text))


@pytest.mark.parametrize("place", ["$AXIS_ACT", "$POS_ACT"])
def test_a_move_to_where_the_arm_stands_goes_by_its_joints(place):
    text = krl("BAS(#INITMOV,0)", f"PTP {REACHED}", f"PTP {place}")
    rows = listing(text)
    assert rows[rows.index("PR[100]=JPOS") + 1].startswith("J PR[100]")
    assert agreeing_steps(text) == 1  # the second move goes nowhere


def test_what_a_switch_chooses_by_has_a_register():
    rows = (
        "DECL INT A[3]",
        "DECL INT N",
        "N=2",
        "A[2]=4",
        "SWITCH A[N]",
        "CASE 4",
        "$OUT[1]=TRUE",
        "ENDSWITCH",
    )
    text = krl(*rows)
    assert left_out(text) == []
    assert agreeing_steps(text) == 1


@pytest.mark.parametrize("target", ["rapid", "tp"])
def test_a_speed_that_only_a_move_names_is_declared_and_told(target):
    text = krl(f"DECL AXIS D={JOINTS}", "SPTP D WITH $VEL_AXIS[1]=SVEL_JOINT(Quick)")
    told = [loss.says for loss in converted(text, "krl", target).translated.losses]
    assert any(one.startswith("Quick is not declared here") for one in told)
    assert left_out(text, target) == []
    if target == "rapid":
        assert re.search(r"VAR num Quick;", translated(text, "krl", "rapid"))


# --- tools by computed numbers ------------------------------------------------------------------------------


_CHOOSES = (
    "BAS (#INITMOV,0)", "PTP {A1 0,A2 -90,A3 90,A4 0,A5 40,A6 0}", "go(1)", "go(2)", "END",
    "DEF go(nTool:IN)", "INT nTool", "%s", "BAS(#BASE,0)", "$VEL.CP=0.1", "LIN {X 900,Y 0,Z 400,A 0,B 0,C 180}",
    "nTool=5", "LIN {X 900,Y 100,Z 400,A 0,B 0,C 180}",
)  # fmt: skip


def test_a_tool_whose_number_is_computed_is_chosen_by_a_register_that_keeps_it() -> None:
    text = krl(*_CHOOSES) % "BAS(#TOOL,nTool)"
    made = converted(text, "krl", "tp")
    go = next(data for name, data in made.files.items() if name.casefold() == "go.ls").decode("cp1252")
    rows = [row.split(":", 1)[1].strip(" ;") for row in go.splitlines() if re.match(r" *\d+:", row)]
    chosen = [row for row in rows if re.match(r"R\[|UTOOL|L P", row)]
    assert chosen == [
        "R[2:tool]=R[1:nTool]", "UTOOL_NUM=R[2:tool]", "L P[1] 100mm/sec FINE",
        "R[1:nTool]=5", "L P[2] 100mm/sec FINE",
    ]  # fmt: skip
    assert go.count("UT : F") == 2  # the tool that is selected
    told = [loss for loss in made.translated.losses if "UTOOL[n]" in loss.says]
    assert [(loss.line, loss.fate) for loss in told] == [(9, Fate.APPROXIMATED)]
    one, other = read(text, "krl").plan(robot=ROBOT), run_elsewhere(text, "krl", "tp")
    assert compare_plans(one, other).differences == []


@pytest.mark.parametrize(
    ("target", "before"), [("inform", ""), ("tp", "$TOOL={X 0,Y 0,Z 50,A 0,B 0,C 0}\r\nPTP $POS_ACT\r\n")]
)
def test_a_computed_tool_beside_one_that_is_written_out_and_one_for_inform_are_refused(
    target, before
) -> None:
    text = krl(*_CHOOSES) % (before + "BAS(#TOOL,nTool)")
    made = converted(text, "krl", target)
    lines = [n for n, row in enumerate(text.splitlines(), 1) if row.startswith("LIN")]
    assert {loss.line for loss in made.translated.losses if loss.leaves_out} >= set(lines)


def test_a_base_whose_number_is_computed_is_chosen_by_a_register() -> None:
    point = "LIN {X 1200,Y %d,Z 800,A 0,B 0,C 180}"
    rows = (
        "INT n",
        "n=2",
        "IF $IN[3] THEN",
        "n=3",
        "ENDIF",
        "BAS(#TOOL,1)",
        "$VEL.CP=0.1",
        "$BASE=BASE_DATA[1]",
    )
    text = krl(*rows, point % 0, "$BASE=BASE_DATA[n]", "n=4", point % 90, "$BASE=BASE_DATA[1]", point % 0)
    chosen = [row for row in listing(text) if re.match(r"UFRAME|R\[|L P", row)]
    held, n = "R[2:frame]", "R[1:n]"
    moves = [f"L P[{number}] 100mm/sec FINE" for number in (1, 2, 1)]
    assert [row for row in chosen if row != f"{held}=0"] == [
        f"{n}=2", f"{n}=3", "UFRAME_NUM=1", moves[0], f"{held}={n}", f"{n}=4", f"UFRAME_NUM={held}", moves[1],
        "UFRAME_NUM=1", moves[2],
    ]  # fmt: skip
    assert translated(text, "krl", "tp").count("UF : F") == 1


@pytest.mark.parametrize(("first", "is_left_out"), [("n=1", False), ("n=20", True), ("n=m+8", True)])
def test_a_computed_tool_that_the_text_shows_to_be_beyond_those_of_the_target_is_refused(first, is_left_out):
    text = krl("INT n", "INT m", "m=3", first, "go(n)", *_CHOOSES[4:]) % "BAS(#TOOL,nTool)"
    assert any("#TOOL" in says for says in left_out(text)) is is_left_out
