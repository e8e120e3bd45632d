"""What a controller counts otherwise than another one: units and ranges of signals and times."""

from __future__ import annotations

import pytest
from translated_texts import converted, inform, krl, module, read, run_elsewhere, script, tp

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
