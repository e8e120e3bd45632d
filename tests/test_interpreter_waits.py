"""What takes time without moving, what olp.toml says about it, and what is assumed otherwise."""

from __future__ import annotations

import pytest
from interpreter_jobs import errors, findings, plan_of, said, visited, waits

from olp.runtime.assumptions import Assumptions, SignalKey
from olp.runtime.plan import StepKind

IN5, IN9 = SignalKey("in", 5), SignalKey("in", 9)


def test_timers_take_their_time_also_from_a_variable() -> None:
    plan = plan_of("TIMER T=1.25\nSET LI000 37\nTIMER T=LI000\nWAIT T=0.40")
    assert waits(plan) == pytest.approx([1.25, 0.37, 0.40])


def test_a_wait_without_any_word_about_it_takes_no_time_and_is_reported_with_its_line() -> None:
    plan = plan_of("WAIT IN#(5)=ON\nWAIT IN#(9)=OFF T=2.50")
    line = plan.sources[0].lines.index("WAIT IN#(5)=ON") + 1
    assert waits(plan) == [0.0, 0.0]
    assert f"{line}: the wait for IN#(5) lasts 0 s" in said(plan)
    assert f"{line + 1}: the wait for IN#(9) lasts 0 s" in said(plan)


@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        ("WAIT IN#(5)=ON", 1.2),
        ("WAIT IN#(5)=ON T=0.80", 0.8),
        ("WAIT IN#(5)=ON T=2.00", 1.2),
        ("WAIT IN#(7)=ON", 0.3),
        ("WAIT IN#(7)=ON T=0.10", 0.1),
        ("WAIT FOREXPRESS IN#(5)=OFF ANDEXP IN#(9)=ON T=6.00", 1.9),
    ],
)
def test_waits_last_as_long_as_given_but_never_longer_than_their_limit(
    statement: str, expected: float
) -> None:
    given = Assumptions(waits={IN5: 1.2, IN9: 1.9}, default_wait=0.3)
    plan = plan_of(statement, given)
    assert waits(plan) == pytest.approx([expected])


def test_a_wait_that_runs_into_its_limit_leaves_the_input_as_it_was() -> None:
    body = "WAIT IN#(5)=ON T=0.50\nIFTHENEXP IN#(5)=ON\nMOVL C00001 V=50.0\nELSE\nMOVL C00002 V=50.0\nENDIF"
    assert visited(plan_of(body, Assumptions(waits={IN5: 3.0}))) == [2]
    assert visited(plan_of(body, Assumptions(waits={IN5: 0.2}))) == [1]


@pytest.mark.parametrize(("state", "expected"), [(1, 0.0), (0, 2.5)])
def test_a_wait_for_an_input_that_is_given_ends_at_once_or_at_its_limit(state: int, expected: float) -> None:
    plan = plan_of("WAIT IN#(5)=ON T=2.50", Assumptions(inputs={IN5: (state,)}))
    assert waits(plan) == [expected]
    assert "wait" not in said(plan)


def test_an_endless_wait_for_an_input_that_never_comes_is_reported() -> None:
    plan = plan_of("WAIT IN#(5)=ON\nMOVL C00001 V=50.0", Assumptions(inputs={IN5: (0,)}))
    assert visited(plan) == [1]
    assert "although nothing here makes it true" in said(plan)


def test_a_wait_for_an_output_that_the_job_set_takes_no_time_and_no_assumption() -> None:
    plan = plan_of("DOUT OT#(4) ON\nWAIT OT#(4)=ON")
    assert waits(plan) == [0.0]
    assert not plan.assumptions


def test_a_pause_takes_what_olp_toml_says() -> None:
    assert waits(plan_of("PAUSE", Assumptions(pause=4.5))) == [4.5]
    silent = plan_of("PAUSE IF B000=1\nPAUSE IF B000=0")
    assert waits(silent) == [0.0]
    assert "operator" in said(silent)


def test_a_process_instruction_takes_what_olp_toml_says() -> None:
    plan = plan_of("ARCON ASF#(3)\nARCOF AEF#(2)\nARCOF AEF#(2)", Assumptions(process={"arcon": 0.35}))
    assert list(plan.durations) == [0.35, 0.0, 0.0]
    assert list(plan.kind) == [StepKind.SIGNAL] * 3
    assert "ARCON" not in said(plan)
    assert said(plan).count("ARCOF takes no time") == 1


def test_outputs_and_messages_are_steps_without_duration() -> None:
    plan = plan_of('DOUT OT#(7) ON\nPULSE OT#(22) T=0.40\nMSG "READY"\nDOUT OG#(26) 5')
    assert list(plan.kind) == [StepKind.SIGNAL] * 4
    assert not plan.durations.any()


def test_a_pulse_with_a_condition_that_does_not_hold_is_left_out() -> None:
    assert len(plan_of("PULSE OT#(22) T=0.40 IF B000=1\nPULSE OT#(22) T=0.40 IF B000=0")) == 1


def test_outputs_and_registers_can_be_read_back() -> None:
    body = """
    DOUT OT#(7) ON
    SETREG MREG#(14) 275
    GETREG LI000 MREG#(14)
    IFTHENEXP OT#(7)=ON ANDEXP LI000=275
    MOVL C00001 V=50.0
    ENDIF
    """
    plan = plan_of(body)
    assert visited(plan) == [1]
    assert "MREG" not in said(plan)


def test_other_tasks_are_reported_and_not_run() -> None:
    plan = plan_of("PSTART JOB:SIDE SUB1\nPWAIT SUB1\nTSYNC 1 SNUM=2\nMOVL C00001 V=50.0")
    assert visited(plan) == [1]
    assert "SIDE runs in a task of its own" in said(plan)
    assert not findings(plan)


def test_a_negative_wait_is_an_error_and_left_out() -> None:
    plan = plan_of("SET LI000 -5\nTIMER T=LI000\nMOVL C00001 V=50.0")
    assert [code for code, _ in errors(plan)] == ["I305"]
    assert visited(plan) == [1]
    assert waits(plan) == []
