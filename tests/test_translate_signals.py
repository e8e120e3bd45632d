"""Signals that are computed, handed to routines or given another name: the same signals switch in both runs."""

from __future__ import annotations

import pytest
from translated_texts import assert_proven, converted, inform, read, translated

from olp.core.source import decode
from olp.fluent import read_source
from olp.robots.robot import load_robot
from olp.transpile.context import Context
from olp.transpile.convert import convert, run_converted, runs_of
from olp.transpile.link import link
from olp.transpile.receipt import receipt_of

HANDED = """MODULE M
VAR signaldo soNow;
PROC main()
  AliasIO "do5",soNow;
  SetDO soNow,1;
  grip do7,1;
  grip do9,0;
  IF shut(di4) WaitTime 1;
ENDPROC
PROC grip(VAR signaldo s,num v)
  SetDO s,v;
  WaitDO s,v;
ENDPROC
FUNC bool shut(VAR signaldi s)
  RETURN DInput(s)=0;
ENDFUNC
ENDMODULE
"""
COMPUTED = """DEF B()
INT I
FOR I=1 TO 3
$OUT[I]=TRUE
$OUT[I+10]=NOT $IN[I]
ENDFOR
IF $IN[I] OR $OUT[I+9] THEN
WAIT FOR $OUT[I+9]
ENDIF
PULSE($OUT[I],TRUE,0.5)
END
"""
SWITCHED = (("do5", 1), ("do7", 1), ("do9", 0))
PULSED = (("1", 1), ("11", 1), ("2", 1), ("12", 1), ("3", 1), ("13", 1), ("4", 0.5))


def switched(plan) -> tuple[tuple[str, float], ...]:
    """The outputs that a run sets or pulses, in order, by their numbers or names."""
    events = [e for _, e in sorted(plan.events.items()) if e.kind in ("set", "pulse")]
    return tuple((e.signals[0].partition("(")[2].rstrip(")"), e.value) for e in events)


def test_a_routine_switches_the_signal_that_it_is_handed():
    assert switched(read_source(decode(HANDED.encode(), "M.mod")).plan()) == SWITCHED


@pytest.mark.parametrize("target", ["inform", "krl", "tp", "urscript"])
def test_signals_that_are_handed_become_their_numbers(target):
    robot = load_robot("abb/irb140-6-0.81")
    made = convert(read_source(decode(HANDED.encode(), "M.mod")), target, Context(robot))
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    plan = run_converted(made, target, robot)
    there = {name[4:]: to for (kind, name), to in made.translated.mapping.items() if kind == "signal"}
    assert switched(plan) == tuple((there.get(name, name).split()[-1].strip("do"), v) for name, v in SWITCHED)
    assert sum(plan.durations) == pytest.approx(1.0)  # the input is off: the last condition holds


def test_signals_with_computed_numbers_have_the_names_of_these_numbers_in_rapid():
    robot = load_robot("kuka/kr16-2")
    program = read_source(decode(COMPUTED.encode(), "B.src"))
    assert switched(program.plan()) == PULSED
    made = convert(program, "rapid", Context(robot))
    assert not made.translated.losses
    assert switched(run_converted(made, "rapid", robot)) == tuple((f"do{n}", v) for n, v in PULSED)


GROUPS = ("DOUT OG#(26) B009", "DIN B010 IG#(3)", "DOUT OGH#(3) 5", "WAIT IG#(1)=B010", "DOUT OG#(26) 7")


def test_groups_of_inform_are_declared_in_krl():
    """INFORM's group n is the signals 8n-7 to 8n, a half group n those from 4n-3 to 4n."""
    text = inform(*GROUPS)
    made = converted(text, "inform", "krl")
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    written = translated(text, "inform", "krl")
    rows = (
        "OUT_201_208 $OUT[201] TO $OUT[208]",
        "IN_17_24 $IN[17] TO $IN[24]",
        "OUT_9_12 $OUT[9] TO $OUT[12]",
    )
    assert [written.count(f"SIGNAL {row}") for row in rows] == [1, 1, 1]
    assert "WAIT FOR IN_1_8==B10" in written
    runs = runs_of(read(text, "inform"), made, "krl", (None, None))
    found = receipt_of(
        link(read(text, "inform")), made.translated, "krl", tuple(made.files), runs, (None, None)
    )
    assert_proven(found)
    assert sum(one.steps for one in found.made_up) >= 4 * 4


NAMED = """DEF N()
SIGNAL grip $OUT[12] TO $OUT[15]
SIGNAL lamp $OUT[3]
PTP {A1 0,A2 -90,A3 90,A4 0,A5 45,A6 0}
grip=3
lamp=TRUE
END
"""


@pytest.mark.parametrize(
    ("target", "rows"), [("rapid", ["SetGO grip,3;", "SetDO do3,1;"]), ("tp", ["GO[1]=3", "DO[3]=ON"])]
)
def test_a_name_that_a_routine_gives_a_signal_is_no_variable(target, rows):
    """Names of signals are declared in a routine as variables are, and no run sets them: nothing is refused."""
    result = converted(NAMED, "krl", target, on_loss="error")
    written = b"".join(result.files.values()).decode("cp1252")
    assert all(row in written for row in rows)
    asked = [thing for things in result.translated.asks.values() for thing in things]
    assert "out-group grip is out 12 to 15" in asked


LISTED = (
    ("DO[3:grip]=ON", "grip"),
    ("DO[4:a, b]=PULSE,0.5sec", "a, b"),
    ("WAIT DI[7:rack free]=ON", "rack free"),
    ("IF DI[1:left]=ON,CALL ELSEWHERE", "left"),
    ("TIMER[1:cycle]=START", "cycle"),
    ("R[2]=TIMER[1:cycle]", "cycle"),
)


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "urscript"])
def test_what_a_listing_calls_its_signals_and_timers_are_comments_elsewhere(target):
    rows = "".join(f"   {n}:  {row} ;\n" for n, (row, _) in enumerate(LISTED, 1))
    text = translated("/PROG  P\n/ATTR\n/MN\n" + rows + "/POS\n/END\n", "tp", target)
    for row, name in LISTED:
        assert name in text, row


def test_a_signal_of_a_constant_number_has_its_own_name_in_rapid():
    rows = (
        "DEF grip( )",
        "DECL CONST INT gripper=3",
        "$OUT[gripper]=TRUE",
        "WAIT FOR $IN[gripper]",
        "END",
        "",
    )
    source = read_source(decode("\n".join(rows).encode(), "grip.src"))
    written = b"".join(convert(source, "rapid", Context()).files.values()).decode()
    assert "SetDO do3,1;" in written
    assert "WaitDI di3,1;" in written
    assert "AliasIO" not in written
