"""A pulse lasts as long as it did and switches the way that it did, or the receipt says otherwise."""

from __future__ import annotations

import pytest

from olp.core.source import decode
from olp.fluent import read_source
from olp.ir.program import PulseOutput
from olp.transpile import Context
from olp.transpile.convert import convert

SOURCES = {
    "inform": (
        "/JOB\r\n//NAME P\r\n//POS\r\n///NPOS 0,0,0,0,0,0\r\n//INST\r\n///DATE 2026/01/01 00:00\r\n///ATTR SC,RW\r\n"
        "///GROUP1 RB1\r\nNOP\r\nPULSE OT#(3)\r\nEND\r\n"
    ),
    "rapid": "MODULE M\nPROC main()\nPulseDO\\High,do3;\nENDPROC\nENDMODULE\n",
    "tp": "/PROG  P\n/ATTR\n/MN\n   1:  DO[3]=PULSE ;\n/POS\n/END\n",
}
SECONDS = {"inform": 0.3, "rapid": 0.2, "tp": 0.4}  # of a pulse that names no time, by the makers' manuals


def converted(text, source, target):
    made = convert(
        read_source(decode(text.encode(), "p"), vendor=source),
        target,
        Context(on_loss="comment"),
        date="2026/01/01 00:00",
    )
    return made, read_source(decode(made.files[made.main], made.main), vendor=target)


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "tp"])
@pytest.mark.parametrize("source", SOURCES)
def test_a_pulse_without_a_time_lasts_as_long_as_in_its_own_language(source, target):
    if source == target:
        return
    made, program = converted(SOURCES[source], source, target)
    (pulse,) = [s for s in program.statements() if isinstance(s, PulseOutput)]
    assert pulse.duration is not None
    assert pulse.duration.literal == pytest.approx(SECONDS[source])
    assert [loss.part for loss in made.translated.losses] == (["duration"] if source == "tp" else [])


def test_a_pulse_that_switches_on_does_not_invert_in_rapid():
    made, _ = converted(SOURCES["tp"], "tp", "rapid")
    assert b"PulseDO \\High" in made.files[made.main]


@pytest.mark.parametrize("target", ["inform", "rapid", "tp"])
def test_a_pulse_to_off_is_not_written_as_one_to_on(target):
    text = "DEF p ( )\nPULSE ($OUT[3],FALSE,0.5)\nEND\n"
    made, program = converted(text, "krl", target)
    assert not [s for s in program.statements() if isinstance(s, PulseOutput)]
    assert [loss.line for loss in made.translated.losses if loss.leaves_out] == [2]
