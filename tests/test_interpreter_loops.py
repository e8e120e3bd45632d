"""Loops without an end: one cycle of the main loop, and inputs that a loop waits for."""

from __future__ import annotations

import difflib
from pathlib import Path

import pytest
from interpreter_jobs import findings, plan_of, program, said, visited, waits, write_jobs

from olp.core.source import decode
from olp.fluent import read, read_source
from olp.ir.expressions import Store
from olp.runtime.assumptions import Assumptions, SignalKey
from olp.runtime.interpreter import run

MAIN_LOOP = "MOVL C00000 V=50.0\n*START\nMOVL C00001 V=50.0\nMOVL C00002 V=50.0\nINC B011\nJUMP *START"


def inputs(**values: int | list[int]) -> Assumptions:
    return Assumptions(
        inputs={
            SignalKey("in", int(name[2:])): tuple(value) if isinstance(value, list) else (value,)
            for name, value in values.items()
        }
    )


def test_the_main_loop_runs_once_and_says_where_it_stopped() -> None:
    plan = plan_of(MAIN_LOOP)
    assert visited(plan) == [0, 1, 2]
    start = plan.sources[0].lines.index("*START") + 1
    expected = f"the loop from line {start} to line {start + 4} has no end: stopped after 1 cycle"
    assert plan.stop_reason == expected
    assert f"{start + 4}: {expected}" in said(plan)
    assert not findings(plan)


@pytest.mark.parametrize("cycles", [1, 2, 5])
def test_the_main_loop_runs_as_often_as_asked(cycles: int) -> None:
    assert visited(plan_of(MAIN_LOOP, cycles=cycles)) == [0] + [1, 2] * cycles


def test_a_while_loop_whose_condition_never_changes_is_a_main_loop() -> None:
    body = "SET B000 1\nWHILE B000=1\nMOVL C00001 V=50.0\nENDWHILE\nMOVL C00009 V=50.0"
    plan = plan_of(body)
    assert visited(plan) == [1]
    assert "has no end" in plan.stop_reason


def test_a_main_loop_in_a_called_job_ends_the_run_as_well(tmp_path: Path) -> None:
    main = write_jobs(
        tmp_path, {"MAIN": "CALL JOB:PROD\nMOVL C00009 V=50.0", "PROD": "*A\nMOVL C00001 V=50.0\nJUMP *A"}
    )
    plan = run(read(main))
    assert visited(plan) == [1]
    assert "has no end" in plan.stop_reason
    assert [(c.start, c.stop) for c in plan.calls] == [(0, 1)]


def test_a_loop_that_counts_with_an_unconditional_way_back_is_no_main_loop() -> None:
    body = """
    SET B000 0
    *A
    JUMP *OUT IF B000=3
    MOVL C00001 V=50.0
    INC B000
    JUMP *A
    *OUT
    MOVL C00009 V=50.0
    """
    plan = plan_of(body)
    assert visited(plan) == [1, 1, 1, 9]
    assert not plan.stop_reason


def test_a_counting_loop_whose_exit_stands_in_a_block_is_no_main_loop() -> None:
    body = """
    SET B000 0
    *A
    MOVL C00001 V=50.0
    INC B000
    IFTHENEXP B000=3
    JUMP *OUT
    ENDIF
    JUMP *A
    *OUT
    MOVL C00009 V=50.0
    """
    assert visited(plan_of(body)) == [1, 1, 1, 9]


def test_a_counting_loop_whose_exit_is_skipped_by_a_jump_is_no_main_loop() -> None:
    body = """
    SET B000 0
    *A
    MOVL C00001 V=50.0
    INC B000
    JUMP *ON IF B000<3
    JUMP *OUT
    *ON
    JUMP *A
    *OUT
    MOVL C00009 V=50.0
    """
    assert visited(plan_of(body)) == [1, 1, 1, 9]


def test_a_counter_that_does_not_decide_about_the_exit_does_not_keep_the_loop_alive() -> None:
    body = """
    *A
    FOR LI000 START= 0 TO 1
    MOVL C00001 V=50.0
    NEXT LI000
    INC B011
    JUMP *A IF IN#(6)=OFF
    MOVL C00009 V=50.0
    """
    plan = plan_of(body)
    assert visited(plan) == [1, 1, 9]
    assert "IN#(6) is taken to change to ON, which ends the loop" in said(plan)


def test_a_main_loop_that_an_input_ends_goes_on_behind_it_after_the_wanted_cycles() -> None:
    body = "*A\nMOVL C00001 V=50.0\nJUMP *A IF IN#(6)=OFF\nMOVL C00009 V=50.0"
    assert visited(plan_of(body)) == [1, 9]
    assert visited(plan_of(body, cycles=3)) == [1, 1, 1, 9]


def test_an_exit_at_the_head_of_the_main_loop_is_taken_after_a_whole_cycle() -> None:
    body = """
    *A
    JUMP *OUT IF IN#(6)=ON
    MOVL C00001 V=50.0
    MOVL C00002 V=50.0
    JUMP *A
    *OUT
    MOVL C00009 V=50.0
    """
    assert visited(plan_of(body)) == [1, 2, 9]


def test_an_input_that_the_user_fixed_is_never_turned_over() -> None:
    body = "*A\nMOVL C00001 V=50.0\nJUMP *A IF IN#(6)=OFF\nMOVL C00009 V=50.0"
    plan = plan_of(body, inputs(IN6=0))
    assert visited(plan) == [1]
    assert "has no end" in plan.stop_reason
    assert visited(plan_of(body, inputs(IN6=1))) == [1, 9]


def test_a_list_of_inputs_is_read_one_by_one_and_its_last_value_stays() -> None:
    body = """
    *A
    MOVL C00001 V=50.0
    JUMP *A IF IN#(6)=OFF
    MOVL C00009 V=50.0
    JUMP *B IF IN#(6)=ON
    MOVL C00008 V=50.0
    *B
    """
    plan = plan_of(body, inputs(IN6=[0, 0, 1]))
    assert visited(plan) == [1, 1, 1, 9]


@pytest.mark.parametrize(
    "poll",
    [
        "*P\nJUMP *P IF IN#(3)=OFF",
        "*P\nTIMER T=0.10\nJUMP *P IF IN#(3)=OFF",
        "*P\nJUMP *GO IF IN#(3)=ON\nJUMP *P\n*GO",
        "*P\nDIN B005 IN#(3)\nJUMP *P IF B005=0",
        "WHILEEXP IN#(3)=OFF\nTIMER T=0.10\nENDWHILE",
        "*P\nIFTHENEXP IN#(3)=ON\nJUMP *GO\nENDIF\nJUMP *P\n*GO",
        "*P\nJUMP *P IF IN#(3)=OFF ORIF IN#(4)=OFF",
        "SET D000 0\n*P\nINC D000\nJUMP *B IF D000>900000\nJUMP *P IF IN#(3)=OFF\nJUMP *G\n*B\nMOVL C00007 V=5.0\n*G",
    ],
)
def test_a_loop_that_polls_an_input_ends_because_the_input_is_taken_to_change(poll: str) -> None:
    plan = plan_of(f"MOVL C00001 V=50.0\n{poll}\nMOVL C00002 V=50.0")
    assert visited(plan) == [1, 2]
    assert "IN#(3) is taken to change to ON" in said(plan)
    assert not plan.stop_reason
    assert not findings(plan)


def test_polling_works_again_each_time_round_the_main_loop() -> None:
    body = """
    *A
    *ON
    JUMP *ON IF IN#(3)=OFF
    MOVL C00001 V=50.0
    *OFF
    JUMP *OFF IF IN#(3)=ON
    MOVL C00002 V=50.0
    JUMP *A
    """
    assert visited(plan_of(body, cycles=3)) == [1, 2] * 3


def test_a_wait_for_an_input_makes_it_true_for_what_follows() -> None:
    body = "WAIT IN#(8)=ON\nIFTHENEXP IN#(8)=ON\nMOVL C00001 V=50.0\nELSE\nMOVL C00002 V=50.0\nENDIF"
    plan = plan_of(body)
    assert visited(plan) == [1]
    assert waits(plan) == [0.0]


def test_a_loop_that_waits_for_another_task_is_left_and_reported() -> None:
    plan = plan_of("*P\nJUMP *P IF B010=0\nMOVL C00001 V=50.0", Assumptions(variables={(Store.BYTE, 10): 0}))
    assert visited(plan) == [1]
    assert "waits for something outside" in said(plan)


def test_a_loop_that_waits_for_another_task_is_left_where_it_returns() -> None:
    loop = "*P\nTIMER T=0.1\nRET IF B010=1\nJUMP *P"
    plan = plan_of(loop, Assumptions(variables={(Store.BYTE, 10): 0}))
    assert waits(plan) == [0.1]
    assert "waits for something outside" in said(plan)


@pytest.mark.parametrize(
    "body", ["*A\nJUMP *A", "*A\nTIMER T=0.50\nJUMP *A", "*A\nDOUT OT#(1) ON\nDOUT OT#(1) OFF\nJUMP *A"]
)
def test_a_loop_that_does_nothing_for_ever_is_stopped(body: str) -> None:
    plan = plan_of(body)
    assert "has no end" in plan.stop_reason
    assert len(plan) <= 2


def test_an_exit_inside_a_subroutine_that_moves_while_it_polls_is_found(tmp_path: Path) -> None:
    main = write_jobs(
        tmp_path,
        {
            "MAIN": "CALL JOB:SHAKE\nMOVL C00009 V=50.0",
            "SHAKE": "*A\nMOVL C00001 V=50.0\nMOVL C00002 V=50.0\nJUMP *A IF IN#(8)=OFF",
        },
    )
    plan = run(read(main))
    assert visited(plan) == [1, 2, 9]
    assert "IN#(8) is taken to change" in said(plan)


def test_every_run_of_any_loop_ends(tmp_path: Path) -> None:
    body = """
    *A
    JUMP *B IF IN#(1)=ON
    *C
    INC B000
    JUMP *A IF B000<200
    JUMP *D
    *B
    SET B000 0
    JUMP *C
    *D
    JUMP *A
    """
    plan = run(program(body), assumptions=Assumptions(), max_steps=5000)
    assert plan.stop_reason


def test_an_endless_loop_stays_endless_around_one_that_is_left(tmp_path):
    import olp

    script = tmp_path / "a.script"
    script.write_text(
        """def f():
  while (True):
    movel(p[0.3, 0, 0.4, 0, 3.14, 0])
    n = 0
    while (True):
      n = n + 1
      movel(p[0.3, 0.01, 0.4, 0, 3.14, 0])
      if (n >= 3):
        break
      end
    end
    movel(p[0.3, 0.2, 0.4, 0, 3.14, 0])
  end
end
"""
    )
    plan = olp.read(script).plan(max_steps=10_000)
    assert len(plan.moves) == 5
    assert "has no end" in plan.stop_reason


RETRY = """
MOVL C00000 V=50.0
*RETRY
SET B022 0
MOVL C00001 V=50.0
MOVL C00002 V=50.0
INC D030
{check}
JUMP *RETRY IF B022=1
MOVL C00009 V=50.0
"""


def test_a_retry_that_comes_back_with_the_same_values_is_one_pass_and_told() -> None:
    plan = plan_of(RETRY.format(check="SET B022 1"))
    assert visited(plan) == [0, 1, 2, 9]
    assert "repeats while B022 = 1, which nothing here changes: one pass is timed" in said(plan)
    assert not plan.stop_reason


def test_a_retry_that_a_called_job_asks_for_is_one_pass(tmp_path: Path) -> None:
    main = write_jobs(
        tmp_path,
        {"MAIN": RETRY.format(check="CALL JOB:CHECK"), "CHECK": "SET B022 0\nMOVL C00003 V=50.0\nSET B022 1"},
    )
    plan = run(read(main), max_steps=5000)
    assert visited(plan) == [0, 1, 2, 3, 9]
    assert [(c.start, c.stop) for c in plan.calls] == [(3, 4)]


@pytest.mark.parametrize("check", ["IFTHENEXP D030<4\nSET B022 1\nENDIF", "CALL JOB:CHECK"])
def test_a_retry_that_a_counter_ends_is_counted(tmp_path: Path, check: str) -> None:
    jobs = {
        "MAIN": "SET D030 0\n" + RETRY.format(check=check),
        "CHECK": "SET B022 0\nIFTHENEXP D030<4\nSET B022 1\nENDIF",
    }
    assert visited(run(read(write_jobs(tmp_path, jobs)))) == [0, *[1, 2] * 4, 9]


def test_a_loop_of_steps_goes_on_while_a_counter_decides_when_the_step_changes() -> None:
    rows = (
        "step=1",
        "WHILE step>0",
        "inner=inner+1",
        "IF inner>=3 THEN",
        "inner=0",
        "outer=outer+1",
        "ENDIF",
    )
    more = ("IF outer>=2 THEN", "step=-1", "ENDIF", "LIN {X 900,Y 0,Z 400,A 0,B 0,C 180}", "ENDWHILE")
    text = "\n".join(
        ["DEF steps()", "DECL INT step,inner,outer", "inner=0", "outer=0", *rows, *more, "END", ""]
    )
    assert len(run(read_source(decode(text.encode(), "steps.src"))).moves) == 6


@pytest.mark.parametrize("size", [4, 200])
def test_an_element_that_is_given_what_it_holds_has_not_changed(size: int) -> None:
    """A loop that waits for an input ran 20,000 passes where it stored the same into an array of many elements."""
    rows = ["WHILE state{1}=0 DO", "state{2}:=3;", "IF di5=1 THEN", "state{1}:=1;", "ENDIF", "ENDWHILE"]
    text = "\n".join(
        ["MODULE M", f"VAR num state{{{size}}};", "PROC main()", *rows, "ENDPROC", "ENDMODULE", ""]
    )
    plan = run(read_source(decode(text.encode(), "m.mod"), vendor="rapid"), max_steps=200)
    assert not plan.stop_reason
    assert "is taken to change to ON" in said(plan)


@pytest.mark.parametrize(
    ("body", "line"),
    [
        ("*A\nJUMP *A IF IN#(6)=OFF", 1),
        ("*A\nJUMP *OUT IF IN#(6)=ON\nJUMP *A\n*OUT", 1),
        ("WHILE IN#(6)=OFF\nENDWHILE", 0),
    ],
)
def test_a_loop_that_asks_an_input_is_a_wait_for_it(body: str, line: int) -> None:
    """As long as olp.toml says that the wait for the input lasts, at the statement that asks."""
    plan = plan_of(body + "\nMOVL C00009 V=50.0", Assumptions(waits={SignalKey("in", 6): 1.5}))
    assert waits(plan) == [1.5]
    first = plan.sources[0].lines.index(body.splitlines()[0])
    assert int(plan.line[0]) == first + line + 1
    assert "the wait for IN#(6) lasts 0 s" in said(plan_of(body))


def test_a_loop_is_ended_by_the_input_that_ends_it_alone() -> None:
    """The input that was read last holds already what the loop waits for."""
    body = "*A\nJUMP *OUT IFEXPRESS IN#(6)=ON ANDEXP IN#(7)=OFF\nJUMP *A\n*OUT\nMOVL C00009 V=50.0"
    plan = plan_of(body)
    assert visited(plan) == [9]
    assert "IN#(6) is taken to change" in said(plan)
    assert "IN#(7) is taken to change" not in said(plan)


def test_steps_with_numbers_that_ask_inputs_in_turn_are_asked_once(tmp_path: Path) -> None:
    """They come round to what they were: nothing here ends them. They turned 20,000 times before."""
    path = tmp_path / "d.script"
    path.write_text(
        "def d():\n  step = 0\n  while (step >= 0):\n    sleep(0.1)\n    if (step == 0):\n"
        "      if (get_standard_digital_in(1)):\n        step = 2\n      else:\n        step = 1\n      end\n"
        "    elif (step == 1):\n      if (get_standard_digital_in(2)):\n        step = 2\n      else:\n"
        "        step = 0\n      end\n    else:\n      step = -1\n    end\n  end\nend\n"
    )
    plan = run(read(path))
    assert waits(plan) == pytest.approx([0.1, 0.1, 0.0, 0.1, 0.1, 0.1])
    assert "IN#(2) is taken to change to ON" in said(plan)


def test_names_like_that_of_a_missing_routine_are_looked_for_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    look = difflib.get_close_matches
    monkeypatch.setattr(
        difflib, "get_close_matches", lambda *given, **more: asked.append(given[0]) or look(*given, **more)
    )
    body = "SET B000 0\nWHILE B000<50\nCALL JOB:PRODUCTS\nCALL JOB:PLACES\nINC B000\nENDWHILE"
    plan = plan_of(body)
    assert [one.code for one in plan.diagnostics] == ["I102", "I102"]
    assert sorted(asked) == ["PLACES", "PRODUCTS"]


def test_a_helper_that_each_pass_sets_before_it_reads_it_does_not_keep_a_loop_going() -> None:
    text = (
        "DEF MAIN ( )\nDECL INT AT\nDECL INT STATE[300]\nSTATE[3]=0\nAGAIN:\nCHECK ( )\nAT=3\nIF STATE[AT]<>1 THEN\n"
        "GOTO AGAIN\nENDIF\nEND\n"
        "DEF CHECK ( )\nDECL INT AT\nAT=5\nAT=6\nIF $IN[AT] THEN\nAT=7\nENDIF\nEND\n"
    )
    plan = run(read_source(decode(text.encode(), "main.src")), max_steps=200)
    assert not plan.stop_reason.startswith("stopped after"), plan.stop_reason


@pytest.mark.parametrize(
    "counts", ["AT=AT+1", "IF $IN[1] THEN\nAT=3\nENDIF\nN=N+1\nAT=N", "STATE[AT]=STATE[AT]+1\nN=3\nAT=N"]
)
def test_a_variable_that_carries_something_from_pass_to_pass_does(counts: str) -> None:
    text = (
        "DEF MAIN ( )\nDECL INT AT\nDECL INT N\nDECL INT STATE[300]\nSTATE[3]=0\nSTATE[9]=4\nAT=3\nN=3\nAGAIN:\n"
        f"{counts}\nIF (STATE[AT]<4) AND (AT<9) THEN\nGOTO AGAIN\nENDIF\n"
        "PTP {A1 5,A2 -90,A3 90,A4 0,A5 0,A6 0}\nEND\n"
    )
    plan = run(read_source(decode(text.encode(), "main.src")), max_steps=2000)
    assert len(plan.moves) == 1, plan.stop_reason


def test_other_elements_of_an_array_do_not_keep_a_main_loop_going() -> None:
    move = "PTP {A1 5,A2 -90,A3 90,A4 0,A5 0,A6 0}\n"
    text = (
        "DEF MAIN ( )\nDECL REAL R[300]\nR[1]=0\nR[6]=1\nAGAIN:\n"
        f"{move}R[6]=2\nR[7]=3\nR[6]=5\nIF R[1]<>1 THEN\nGOTO AGAIN\nENDIF\nEND\n"
    )
    plan = run(read_source(decode(text.encode(), "main.src")), max_steps=200)
    assert len(plan.moves) == 1
    assert not plan.stop_reason.startswith("stopped after"), plan.stop_reason


def test_what_a_called_job_has_for_itself_does_not_keep_the_callers_loop_going(tmp_path: Path) -> None:
    polled = "*A\nSET LB000 0\nCALL JOB:ASK\nJUMP *A IF LB000=0"
    jobs = {"MAIN": polled, "ASK": "SET LB000 3\nSET LB001 1\nSET LB000 B[LB001]"}
    main = write_jobs(tmp_path, jobs)
    for path in tmp_path.glob("*.[jJ][bB][iI]"):
        text = path.read_text(encoding="latin-1")
        lines = text.replace("///GROUP1 RB1", "///GROUP1 RB1\n///LVARS 2,0,0,0,0,0,0,0", 1)
        path.write_text(lines, encoding="latin-1")
    plan = run(read(main), max_steps=200)
    assert not plan.stop_reason.startswith("stopped after"), plan.stop_reason


@pytest.mark.parametrize("type_", ["num", "num count{300}"])
def test_a_variable_that_a_routine_changes_for_its_caller_keeps_the_callers_loop_going(type_: str) -> None:
    many = "{" in type_
    declared, item = ("VAR num n{300};", "n{7}") if many else ("VAR num n;", "n")
    taken, inner = ("INOUT num count{*}", "count{7}") if many else ("INOUT num count", "count")
    text = (
        "MODULE M\nPROC main()\n"
        f"{declared}\n{item}:=0;\nWHILE {item}<40 DO\nbump n;\nENDWHILE\n"
        "MoveAbsJ [[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\nENDPROC\n"
        f"PROC bump({taken})\ninner count;\nENDPROC\nPROC inner({taken})\n{inner}:={inner}+1;\nENDPROC\nENDMODULE\n"
    )
    plan = run(read_source(decode(text.encode(), "m.mod"), vendor="rapid"), max_steps=2000)
    assert len(plan.moves) == 1, (plan.stop_reason, plan.diagnostics)
    assert "waits for something outside" not in "".join(said(plan))
