"""What a controller counts otherwise than another one: units and ranges of signals and times."""

from __future__ import annotations

import pytest
from translated_texts import converted, inform, krl, module, read, run_elsewhere, script, tp, translated

ANALOG = {
    "inform": inform("AOUT AO#(1) 2.5"),
    "krl": krl("$ANOUT[1]=0.25"),
    "rapid": module("SetAO ao1,2.5;"),
    "tp": tp("AO[1]=250"),
    "urscript": script("set_standard_analog_out(1, 0.25)"),
}


@pytest.mark.parametrize("source", ANALOG)
@pytest.mark.parametrize("target", ANALOG)
def test_the_unit_of_an_analog_signal_is_told(source, target):
    told = [loss.says for loss in converted(ANALOG[source], source, target).translated.losses]
    assert any("the value of an analog signal is" in says for says in told) is (source != target)


@pytest.mark.parametrize(("target", "longest"), [("inform", 655.35), ("tp", 327.67)])
def test_a_wait_that_is_too_long_for_a_word_is_several_or_refused(target, longest):
    text = module("WaitTime 700;", "SetDO do1,1;")
    here, there = read(text, "rapid").plan(), run_elsewhere(text, "rapid", target)
    assert there.durations.sum() == pytest.approx(here.durations.sum())
    assert there.durations.max() == longest
    for row in ("WaitTime 234000;", "WaitDI di1,1\\MaxTime:=700;"):
        told = converted(module(row), "rapid", target).translated.losses
        assert any(f"{longest:g} s is the longest one" in loss.says for loss in told)


def test_a_remainder_of_fractions_takes_no_operator_of_whole_numbers_in_rapid():
    rows = (
        "R[1]=10.5",
        "R[2]=R[1] DIV 4",
        "R[3]=R[1] MOD 4",
        "R[4]=7",
        "R[5]=R[4] DIV 2",
        "WAIT R[2]",
        "WAIT R[3]",
    )
    text = tp(*rows)
    written = translated(text, "tp", "rapid")
    assert "R2:=Trunc(R1 / 4);" in written
    assert "R3:=R1 - 4 * Trunc(R1 / 4);" in written
    assert "R5:=R4 DIV 2;" in written
    here, there = read(text, "tp").plan(), run_elsewhere(text, "tp", "rapid")
    assert there.durations.tolist() == here.durations.tolist() == [2.0, 2.5]


def test_a_position_that_is_read_while_a_corner_is_passed_is_told():
    pose = "p[0.4, 0.1, {}, 0, 3.14, 0]"
    rows = [f"movel({pose.format(0.3)}, r={{}})", f"movel({pose.format(0.4)})", "p = get_actual_tcp_pose()"]
    for zone, where in (("0.02", 2), ("0", 2), ("0.02", 1)):
        body = [rows[0].format(zone), *rows[1:where], rows[2]]
        told = converted(script(*body, f"movel({pose.format(0.5)})"), "urscript", "krl").translated.losses
        assert any("passes the corner before" in loss.says for loss in told) is (where == 1)
