"""A pulse lasts as long as it did and switches the way that it did, or the receipt says otherwise."""

from __future__ import annotations

import pytest

from olp.core.source import decode
from olp.fluent import read_source
from olp.ir.program import Move, PulseOutput, StartTask
from olp.transpile import Context
from olp.transpile.context import Fate
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


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "tp", "urscript"])
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


def test_a_pulse_is_a_thread_in_urscript_and_the_receipt_says_that_it_ends_with_the_program():
    made, program = converted(SOURCES["rapid"], "rapid", "urscript")
    text = made.files[made.main].decode()
    lines = [line.strip() for line in text.splitlines()]
    at = lines.index("thread olp_pulse_do3_0_2s():")
    assert lines[at + 1 : at + 5] == ["set_standard_digital_out(3, True)", "sleep(0.2)",
                                      "set_standard_digital_out(3, False)", "end"]  # fmt: skip
    assert "run olp_pulse_do3_0_2s()" in lines
    assert [one.says for one in made.translated.remarks if "thread" in one.says]
    assert len(program.routines) == 1  # the thread stands for the pulse


def test_a_pulse_thread_that_a_person_has_changed_is_no_pulse():
    made, _ = converted(SOURCES["rapid"], "rapid", "urscript")
    text = made.files[made.main].replace(b"sleep(0.2)", b"sleep(0.7)")
    program = read_source(decode(text, "p.script"), vendor="urscript")
    assert not [s for s in program.statements() if isinstance(s, PulseOutput)]
    assert [s.routine for s in program.statements() if isinstance(s, StartTask)] == ["olp_pulse_do3_0_2s"]


@pytest.mark.parametrize("target", ["krl", "rapid"])
def test_a_time_that_is_always_zero_means_nothing_to_a_move(target):
    """`t=t_fun` with `t_fun = 0`, as programs of functions write it."""
    text = "def p():\n  t_fun = 0\n  movel(p[0.4, 0.1, 0.3, 0, 3.14, 0], a=1.2, v=0.2, t=t_fun)\nend\n"
    made, program = converted(text, "urscript", target)
    assert any(isinstance(s, Move) for s in program.statements())
    assert [
        loss.says for loss in made.translated.losses if loss.line == 3 and loss.fate is Fate.REFUSED
    ] == []
    own, _ = converted(text, "urscript", "urscript")
    assert b"t=t_fun" in own.files[own.main]


def test_urscript_tells_that_a_second_pulse_ends_with_the_first():
    """Other controllers begin the time anew; there the first thread switches off what the second has switched on."""
    pulse = "PulseDO\\High\\PLength:=1,do5;\n"
    text = f"MODULE M\nPROC main()\n{pulse}WaitTime 0.3;\n{pulse}ENDPROC\nENDMODULE\n"
    made = convert(read_source(decode(text.encode(), "p"), vendor="rapid"), "urscript", Context())
    assert any(
        "ends with the first" in str(one) for one in (*made.translated.notes, *made.translated.remarks)
    )
