"""Error handlers in languages without them: waits that fail, and handlers of what is not translated."""

import math

import pytest
from translated_texts import ROBOT, converted, module, read, translated

import olp
from olp.runtime.assumptions import NAMED_SIGNAL, SignalKey
from olp.transpile.context import Context, Fate
from olp.transpile.convert import convert, run_converted
from olp.transpile.link import link

DATA = ("VAR num n:=0;", "VAR bool late:=FALSE;", "VAR errnum ERR_OWN:=-1;")
TARGETS = ["krl", "tp", "inform", "urscript"]


def handled(*handler, before=("WaitDI di2,1\\MaxTime:=3;",)):
    return module("SetDO do2,1;", *before, "SetDO do3,1;", "ERROR", *handler, data=DATA)


def outputs(text, target, **inputs):
    """What the translation sets: (the source's number, value), in order; `inputs`: di2=0 …"""
    source = read(text, "rapid")
    given = {SignalKey(NAMED_SIGNAL, name): (value,) for name, value in inputs.items()}
    made = converted(text, "rapid", target)
    names = {
        made.translated.mapping.get(("signal", f"out do{n}"), f"out {n}").split()[-1]: n for n in (2, 3, 4)
    }
    plan = run_converted(made, target, ROBOT, source, given)
    events = [event for _, event in sorted(plan.events.items()) if event.kind == "set"]
    numbers = [one.signals[0].rpartition("(")[2].rstrip(")") for one in events]
    return [
        (names.get(n, n), None if math.isnan(e.value) else e.value)
        for n, e in zip(numbers, events, strict=True)
    ]


def fates(text, target):
    made = converted(text, "rapid", target).translated.losses
    return {loss.line: loss.fate for loss in made if loss.statement == "Disabled"}


RETRIES = (
    "IF ERRNO=ERR_WAIT_MAXTIME THEN",
    "SetDO do2,0;",
    "n:=n+1;",
    "IF n<3 THEN",
    "RETRY;",
    "ELSE",
    "TRYNEXT;",
    "ENDIF",
    "ENDIF",
)


@pytest.mark.parametrize("target", TARGETS)
def test_a_wait_at_its_limit_does_what_its_handler_does(target):
    text = handled(*RETRIES)
    assert outputs(text, target, di2=1) == [(2, 1), (3, 1)]
    assert outputs(text, target, di2=0) == [(2, 1), (2, 0), (2, 0), (2, 0), (3, 1)]


@pytest.mark.parametrize("target", TARGETS)
def test_each_way_of_a_handler_ends_as_it_says(target):
    choice = (
        "TEST ERRNO",
        "CASE ERR_WAIT_MAXTIME:",
        "SetDO do4,1;",
        "RETURN;",
        "DEFAULT:",
        "TRYNEXT;",
        "ENDTEST",
    )
    assert outputs(handled(*choice), target, di2=0) == [(2, 1), (4, 1)]
    assert outputs(handled("SetDO do4,1;", "TRYNEXT;"), target, di2=0) == [(2, 1), (4, 1), (3, 1)]
    either = ("IF ERRNO=ERR_DIVZERO OR ERR_WAIT_MAXTIME=ERRNO THEN", "SetDO do4,1;", "ENDIF", "TRYNEXT;")
    assert outputs(handled(*either), target, di2=0) == [(2, 1), (4, 1), (3, 1)]
    other = ("IF ERRNO<>ERR_WAIT_MAXTIME THEN", "SetDO do4,1;", "ENDIF", "TRYNEXT;")
    assert outputs(handled(*other), target, di2=0) == [(2, 1), (3, 1)]


@pytest.mark.parametrize("target", TARGETS)
def test_a_wait_that_nothing_handles_stops_the_program_and_says_so(target):
    text = module("SetDO do2,1;", "WaitDI di2,1\\MaxTime:=3;", "SetDO do3,1;")
    stop = {"krl": "HALT", "tp": "PAUSE", "inform": "PAUSE", "urscript": "blocking=True"}[target]
    made = converted(text, "rapid", target)
    assert stop in translated(text, "rapid", target)
    assert [loss.fate for loss in made.translated.losses if "at its limit" in loss.says] == [
        Fate.APPROXIMATED
    ]
    assert outputs(text, target, di2=1) == [(2, 1), (3, 1)]


@pytest.mark.parametrize("target", TARGETS)
def test_a_wait_whose_limit_the_program_asks_for_stays_as_it_is(target):
    text = module("WaitDI di2,1\\MaxTime:=3\\TimeFlag:=late;", "SetDO do3,1;", data=DATA)
    assert "at its limit" not in str(converted(text, "rapid", target).translated.losses)


@pytest.mark.parametrize(
    "handler",
    [
        ("IF ERRNO=ERR_WAIT_MAXTIME THEN", "SetDO do4,1;", "ENDIF"),  # how it ends is not said
        ("IF ERRNO=ERR_WAIT_MAXTIME THEN", "RAISE;", "ENDIF"),
        ("IF n=ERRNO THEN", "n:=ERRNO;", "ENDIF", "TRYNEXT;"),
        ("SocketClose s;", "TRYNEXT;"),
    ],
)
def test_a_handler_that_cannot_be_said_is_left_out_as_a_whole(handler):
    text = handled(*handler)
    assert outputs(text, "krl", di2=1) == [(2, 1), (3, 1)]
    assert "HALT" in translated(text, "rapid", "krl")
    first = text.splitlines().index("ERROR") + 1
    assert set(fates(text, "krl").values()) == {Fate.COMMENTED}
    assert min(fates(text, "krl")) == first


def test_errors_go_to_callers_whose_handlers_are_left_out():
    rows = [
        "take;",
        "ERROR",
        "IF ERRNO=ERR_WAIT_MAXTIME TRYNEXT;",
        "ENDPROC",
        "PROC take()",
        "WaitDI di2,1\\MaxTime:=3;",
    ]
    assert set(fates(module(*rows), "krl").values()) == {Fate.COMMENTED}


SOCKETS = (
    "IF ERRNO=ERR_SOCK_CLOSED THEN",
    "SocketClose s;",
    "RETRY;",
    "ELSEIF ERRNO=ERR_OWN THEN",
    "n:=1;",
    "TRYNEXT;",
)


@pytest.mark.parametrize("target", TARGETS)
def test_what_handles_only_what_is_not_translated_is_told_as_left_out(target):
    data = (*DATA, "VAR socketdev s;")
    rows = ("n:=2;", "SocketReceive s;", "IF n>3 RAISE ERR_OWN;", "ERROR", *SOCKETS, "ENDIF")
    assert set(fates(module(*rows, data=data), target).values()) == {Fate.APPROXIMATED}
    # The same behind a move, which may fail: what the handler does about that is lost.
    rows = ("MoveAbsJ [[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;", *rows[1:4])
    text = module(*rows, *SOCKETS, "ELSE", "n:=5;", "ENDIF", data=data)
    assert set(fates(text, target).values()) == {Fate.APPROXIMATED}
    made = converted(text, "rapid", target).translated.losses
    lost = [one.line for one in made if "stops where something fails" in one.says]
    text = text.splitlines()
    assert [text[line - 1] for line in lost] == [
        "ERROR", SOCKETS[0], SOCKETS[3], "ELSE", "n:=5;", "ENDIF",
    ]  # fmt: skip


@pytest.mark.parametrize("target", TARGETS)
def test_where_something_fails_the_target_stops_which_is_told(target):
    for row in ("n:=1/n;", "f;"):
        text = module(row, "ERROR", "IF ERRNO=ERR_SOCK_CLOSED TRYNEXT;", "RETRY;", data=DATA)
        made = converted(text, "rapid", target).translated.losses
        told = {one.line: one.says for one in made if one.statement == "Disabled"}
        assert set(fates(text, target).values()) == {Fate.APPROXIMATED}
        lines = text.splitlines()
        fails = {lines[n - 1] for n, says in told.items() if "itself stops where something fails" in says}
        assert fails == {"ERROR", "RETRY;"}


def test_what_a_handler_needs_of_other_files_comes_with_it(tmp_path):
    rows = ("WaitDI di2,1\\MaxTime:=3;", "ERROR", "undo_grip MOST;", "TRYNEXT;")
    (tmp_path / "M.mod").write_text(module(*rows))
    other = "MODULE O\nCONST num most:=4;\nPROC undo_grip(num n)\nIF n>3 SetDO do9,1;\nENDPROC\nENDMODULE\n"
    (tmp_path / "O.mod").write_text(other)
    linked = link(olp.read(tmp_path / "M.mod")).program
    assert "undo_grip" in {routine.name for routine in linked.routines}
    made = b"".join(convert(linked, "krl", Context(robot=ROBOT)).files.values()).decode()
    assert "undo_grip (most)" in made
    assert "most=4" in made


RAISING = (
    "IF ERRNO=ERR_OWN THEN",
    "SetDO do4,1;",
    "n:=n+1;",
    "TRYNEXT;",
    "ELSEIF ERRNO=ERR_WAIT_MAXTIME THEN",
    "RETURN;",
    "ENDIF",
    "RAISE;",
)


@pytest.mark.parametrize("target", TARGETS)
def test_an_error_of_the_program_does_what_its_handler_does_where_it_is_raised(target):
    text = handled(*RAISING, before=("IF DInput(di2)=1 RAISE ERR_OWN;",))
    assert outputs(text, target, di2=1) == [(2, 1), (4, 1), (3, 1)]
    assert outputs(text, target, di2=0) == [(2, 1), (3, 1)]
    assert not [loss for loss in converted(text, "rapid", target).translated.losses if loss.leaves_out]


def test_the_run_raises_errors_of_the_program_too():
    text = handled(*RAISING[:2], "RETURN;", *RAISING[4:], before=("RAISE err_own;", "WaitTime 7;"))
    plan = read(text, "rapid").plan()
    events = [event for _, event in sorted(plan.events.items()) if event.kind == "set"]
    assert [event.signals[0] for event in events] == ["SIGNAL#(do2)", "SIGNAL#(do4)"]
    assert not (plan.durations == 7).any()


@pytest.mark.parametrize("handler", [("RETRY;",), ("RAISE;",), ("TPWrite NumToStr(ERRNO,0);", "TRYNEXT;")])
def test_an_error_that_its_handler_does_not_end_there_stays(handler):
    text = handled(*handler, before=("IF DInput(di2)=1 RAISE ERR_OWN;",))
    assert 7 in {loss.line for loss in converted(text, "rapid", "krl").translated.losses if loss.leaves_out}
