"""RAPID's interrupts in KRL: the text is what KUKA's programming instructions say of INTERRUPT; no run raises one."""

import pytest
from translated_texts import converted, module, read, translated

from olp.transpile.context import Fate

TRAP = "TRAP tStop\r\nStopMove;\r\nSetDO do1,1;\r\nStartMove;\r\nENDTRAP\r\nENDMODULE"
ROWS = (
    "IDelete hit;",
    "CONNECT hit WITH tStop;",
    "ISignalDI di3,1,hit;",
    "ISleep hit;",
    "IWatch hit;",
    "IDisable;",
    "IEnable;",
    "IDelete hit;",
)


def program(*rows):
    return module(*rows, data=("VAR intnum hit;", "VAR intnum other;")).replace("ENDMODULE", TRAP)


def lines(text):
    return [row.strip() for row in translated(text, "rapid", "krl").splitlines()]


def test_an_interrupt_of_a_signal_is_krls_own():
    rows = lines(program(*ROWS))
    found = [row for row in rows if "INTERRUPT" in row]
    assert found == [
        "GLOBAL INTERRUPT DECL 21 WHEN $IN[3]==TRUE DO tStop ( )",
        "INTERRUPT ON 21",
        "INTERRUPT OFF 21",
        "INTERRUPT ON 21",
        "INTERRUPT DISABLE",
        "INTERRUPT ENABLE",
        "INTERRUPT OFF 21",
    ]
    at = rows.index("BRAKE")
    assert rows[at - 1 : at + 3] == ["DEF tStop ( )", "BRAKE", "$OUT[1]=TRUE", "END"]


def test_it_is_told_where_it_is_ordered():
    losses = converted(program(*ROWS), "rapid", "krl").translated.losses
    assert {loss.line for loss in losses if "no run here lets it happen" in loss.says} == {7}
    assert not [loss for loss in losses if loss.leaves_out and loss.fate is not Fate.EXACT]


def test_one_that_comes_once_switches_itself_off():
    rows = lines(program("CONNECT hit WITH tStop;", "ISignalDI\\Single,di3,0,hit;"))
    assert "GLOBAL INTERRUPT DECL 21 WHEN $IN[3]==FALSE DO tStop ( )" in rows
    at = rows.index("DEF tStop ( )")
    assert rows[at + 1] == "INTERRUPT OFF 21"


@pytest.mark.parametrize(
    "rows",
    [
        ("CONNECT hit WITH tStop;", "ITimer 2,hit;"),
        ("CONNECT hit WITH tStop;", "ISignalDI di3,2,hit;"),
        ("CONNECT hit WITH tStop;", "CONNECT other WITH tStop;", "ISignalDI di3,1,hit;"),
        ("ISignalDI di3,1,hit;", "WaitTime 1;"),
    ],
)
def test_what_krl_cannot_say_so_is_left_out(rows):
    text = program(*rows)
    assert not [row for row in lines(text) if "INTERRUPT DECL" in row]
    losses = converted(text, "rapid", "krl").translated.losses
    assert 5 in {loss.line for loss in losses if loss.fate is Fate.COMMENTED}


def test_a_stop_that_nothing_ends_in_the_trap_is_left_out():
    text = program(*ROWS).replace("StartMove;\r\n", "")
    losses = converted(text, "rapid", "krl").translated.losses
    assert [loss for loss in losses if loss.fate is Fate.COMMENTED]
    assert "BRAKE" not in lines(text)


@pytest.mark.parametrize("target", ["tp", "inform", "urscript"])
def test_other_languages_leave_interrupts_out(target):
    losses = converted(program(*ROWS), "rapid", target).translated.losses
    gone = {loss.line for loss in losses if loss.fate is Fate.COMMENTED}
    assert {5, 6, 7, 8, 9, 12} <= gone


def test_interrupts_take_no_step_of_a_run():
    assert len(read(program(*ROWS), "rapid").plan()) == 0
