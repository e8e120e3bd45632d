"""Labels, jumps, blocks, calls: which points a job visits in which order."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from interpreter_jobs import errors, findings, plan_of, program, said, visited, waits, write_jobs

from olp.fluent import read
from olp.ir.expressions import Store
from olp.runtime.assumptions import Assumptions
from olp.runtime.interpreter import run


def given(**values: int) -> Assumptions:
    """B variables by their names, so that nothing is left to assume."""
    return Assumptions(variables={(Store.BYTE, int(name[1:])): value for name, value in values.items()})


def test_a_straight_job_visits_its_points_in_order() -> None:
    plan = plan_of("MOVJ C00000 VJ=25.00\nMOVL C00001 V=187.0\nTIMER T=0.35\nMOVL C00002 V=46.0 PL=0")
    assert visited(plan) == [0, 1, 2]
    assert waits(plan) == [0.35]
    assert [plan.statement(i) for i in range(4)][2] == "TIMER T=0.35"


BRANCHES = """
IFTHENEXP B001=1
  MOVL C00001 V=50.0
ELSEIFEXP B001=2
  MOVL C00002 V=50.0
ELSEIFEXP B001=3
  MOVL C00003 V=50.0
ELSE
  MOVL C00004 V=50.0
ENDIF
MOVL C00009 V=50.0
"""


@pytest.mark.parametrize(("value", "branch"), [(1, 1), (2, 2), (3, 3), (0, 4), (7, 4)])
def test_exactly_one_branch_of_an_if_runs(value: int, branch: int) -> None:
    assert visited(plan_of(BRANCHES, given(B001=value))) == [branch, 9]


def test_an_if_without_a_true_branch_runs_none() -> None:
    body = "IFTHENEXP B001=1\nMOVL C00001 V=50.0\nELSEIFEXP B001=2\nMOVL C00002 V=50.0\nENDIF\nMOVL C00009 V=50.0"
    assert visited(plan_of(body, given(B001=0))) == [9]


@pytest.mark.parametrize(
    ("b1", "b2", "b3", "taken"),
    [(1, 0, 0, False), (1, 0, 1, True), (0, 1, 1, True), (0, 1, 0, False), (1, 1, 0, False)],
)
def test_conditions_are_evaluated_strictly_from_left_to_right(b1: int, b2: int, b3: int, taken: bool) -> None:
    # (b1 or b2) and b3: with the usual precedence of "and" the first case would be true
    body = "IFTHEN B001=1 ORIF B002=1 ANDIF B003=1\nMOVL C00001 V=50.0\nENDIF\nMOVL C00009 V=50.0"
    assert visited(plan_of(body, given(B001=b1, B002=b2, B003=b3))) == ([1, 9] if taken else [9])


def test_a_while_loop_runs_while_its_condition_holds() -> None:
    body = "SET B000 0\nWHILE B000<3\nMOVL C00001 V=50.0\nINC B000\nENDWHILE\nMOVL C00009 V=50.0"
    plan = plan_of(body)
    assert visited(plan) == [1, 1, 1, 9]
    assert not findings(plan)


def test_a_while_loop_that_never_holds_is_skipped() -> None:
    assert visited(plan_of("SET B000 5\nWHILE B000<3\nMOVL C00001 V=50.0\nENDWHILE\nMOVL C00009 V=50.0")) == [
        9
    ]


@pytest.mark.parametrize(
    ("head", "times"),
    [
        ("START= 0 TO 2", 3),
        ("START= 5 TO 5", 1),
        ("START= 3 TO 2", 0),
        ("START= 0 TO 6 STEP 2", 4),
        ("START= 0 TO 5 STEP 2", 3),
        ("START= 6 TO 0 STEP -3", 3),
    ],
)
def test_a_for_loop_counts_both_ends(head: str, times: int) -> None:
    body = f"FOR LI000 {head}\nMOVL C00001 V=50.0\nNEXT LI000\nMOVL C00009 V=50.0"
    assert visited(plan_of(body)) == [1] * times + [9]


def test_a_for_loop_up_to_the_largest_byte_ends() -> None:
    plan = plan_of("FOR B000 START= 253 TO 255\nMOVL C00001 V=50.0\nNEXT B000\nMOVL C00009 V=50.0")
    assert visited(plan) == [1, 1, 1, 9]
    assert not findings(plan)


def test_a_for_loop_with_step_zero_is_refused() -> None:
    plan = plan_of("FOR LI000 START= 0 TO 3 STEP 0\nMOVL C00001 V=50.0\nNEXT LI000\nMOVL C00009 V=50.0")
    assert errors(plan)[0][0] == "I105"
    assert visited(plan)[-1] == 9


def test_nested_loops_run_the_inner_one_anew_each_time() -> None:
    body = """
    FOR LI000 START= 0 TO 1
    FOR LI001 START= 0 TO 2
    MOVL C00001 V=50.0
    NEXT LI001
    MOVL C00002 V=50.0
    NEXT LI000
    """
    assert visited(plan_of(body)) == [1, 1, 1, 2, 1, 1, 1, 2]


def test_a_jump_out_of_nested_blocks_leaves_all_of_them() -> None:
    body = """
    SET B000 0
    WHILE B000<9
    FOR LI000 START= 0 TO 5
    IFTHENEXP LI000=2
    JUMP *OUT
    ENDIF
    MOVL C00001 V=50.0
    NEXT LI000
    INC B000
    ENDWHILE
    *OUT
    MOVL C00009 V=50.0
    """
    assert visited(plan_of(body)) == [1, 1, 9]


def test_a_label_inside_a_loop_is_a_loop_of_its_own() -> None:
    body = """
    FOR LI001 START= 0 TO 1
    SET LI000 0
    *ROW
    MOVL C00001 V=50.0
    INC LI000
    JUMP *ROW IF LI000<2
    MOVL C00002 V=50.0
    NEXT LI001
    """
    assert visited(plan_of(body)) == [1, 1, 2, 1, 1, 2]


SWITCH = """
SWITCH B001 CASE 1
  MOVL C00001 V=50.0
CASE 2,4
  MOVL C00002 V=50.0
DEFAULT
  MOVL C00003 V=50.0
ENDSWITCH
MOVL C00009 V=50.0
"""


@pytest.mark.parametrize(("value", "branch"), [(1, 1), (2, 2), (4, 2), (3, 3), (0, 3)])
def test_a_switch_runs_the_first_case_that_matches(value: int, branch: int) -> None:
    assert visited(plan_of(SWITCH, given(B001=value))) == [branch, 9]


@pytest.mark.parametrize(("value", "label"), [(7, 1), (8, 2)])
def test_a_computed_jump_goes_to_the_label_of_that_number(value: int, label: int) -> None:
    body = """
    JUMP LABEL: B001
    *7
    MOVL C00001 V=50.0
    JUMP *OUT
    *8
    MOVL C00002 V=50.0
    *OUT
    MOVL C00009 V=50.0
    """
    assert visited(plan_of(body, given(B001=value))) == [label, 9]


def test_a_computed_jump_to_nowhere_is_an_error_and_the_job_goes_on() -> None:
    plan = plan_of("JUMP LABEL: B001\n*7\nMOVL C00001 V=50.0", given(B001=3))
    assert [code for code, _ in errors(plan)] == ["I104"]
    assert "labels of this routine: 7" in plan.diagnostics[0].help
    assert visited(plan) == [1]


def test_a_conditional_jump_is_taken_only_when_its_condition_holds() -> None:
    body = "JUMP *A IF B001=1\nMOVL C00001 V=50.0\n*A\nMOVL C00009 V=50.0"
    assert visited(plan_of(body, given(B001=1))) == [9]
    assert visited(plan_of(body, given(B001=0))) == [1, 9]


def test_called_jobs_are_found_by_file_name_and_by_job_name(tmp_path: Path) -> None:
    main = write_jobs(
        tmp_path,
        {
            "MAIN": "CALL JOB:PART-A\nMOVL C00002 V=50.0\nCALL JOB:part-b\nMOVL C00004 V=50.0",
            "PART-A": "MOVL C00001 V=50.0",
            "PART-B": "MOVL C00003 V=50.0",
        },
    )
    (tmp_path / "PART-A.JBI").rename(tmp_path / "RENAMED.JBI")
    plan = run(read(main))
    assert visited(plan) == [1, 2, 3, 4]
    assert not findings(plan)
    assert sorted(Path(s.path).name for s in plan.sources) == ["MAIN.JBI", "PART-B.JBI", "RENAMED.JBI"]
    assert Path(plan.sources[plan.source[0]].path).name == "RENAMED.JBI"


def test_the_calls_of_the_main_routine_know_their_steps(tmp_path: Path) -> None:
    main = write_jobs(
        tmp_path,
        {
            "MAIN": "MOVL C00001 V=50.0\nCALL JOB:A\nMOVL C00002 V=50.0\nCALL JOB:A",
            "A": "CALL JOB:B\nMOVL C00003 V=50.0",
            "B": "TIMER T=0.10",
        },
    )
    plan = run(read(main))
    base = next(s for s in plan.sources if s.path == str(main)).lines.index("CALL JOB:A") + 1
    assert [(c.line, c.start, c.stop) for c in plan.calls] == [(base, 1, 3), (base + 2, 4, 6)]


def test_a_missing_job_is_an_error_that_names_similar_ones_and_the_run_goes_on(tmp_path: Path) -> None:
    main = write_jobs(
        tmp_path, {"MAIN": "CALL JOB:PLACE-1\nMOVL C00002 V=50.0", "PLACE-2": "MOVL C00001 V=50.0"}
    )
    plan = run(read(main))
    assert visited(plan) == [2]
    found = next(d for d in plan.diagnostics if d.code == "I102")
    assert "PLACE-2" in found.help
    assert found.source_line == "CALL JOB:PLACE-1"


def test_arguments_reach_the_called_job_and_its_value_comes_back(tmp_path: Path) -> None:
    main = write_jobs(
        tmp_path,
        {
            "MAIN": "SET D000 30\nCALL JOB:SUM ARGF12 ARGFD000\nGETS D001 $RV\nTIMER T=D001",
            "SUM": "GETARG LD000 IARG#(1)\nGETARG LD001 IARG#(2)\nADD LD000 LD001\nRET LD000\nTIMER T=9.00",
        },
    )
    plan = run(read(main))
    assert waits(plan) == pytest.approx([0.42])  # T=D001 counts hundredths
    assert not findings(plan)


def test_each_call_has_locals_of_its_own(tmp_path: Path) -> None:
    main = write_jobs(
        tmp_path,
        {
            "MAIN": "CALL JOB:DOWN ARGF3",
            "DOWN": """
            GETARG LB000 IARG#(1)
            JUMP *END IF LB000=0
            SET LI000 LB000
            SUB LI000 1
            CALL JOB:DOWN ARGFLI000
            SET LI001 LB000
            MUL LI001 100
            TIMER T=LI001
            *END
            """,
        },
    )
    assert waits(run(read(main))) == pytest.approx([1.0, 2.0, 3.0])


def test_a_job_that_calls_itself_for_ever_is_stopped(tmp_path: Path) -> None:
    main = write_jobs(tmp_path, {"MAIN": "MOVL C00001 V=50.0\nCALL JOB:MAIN"})
    plan = run(read(main))
    assert [code for code, _ in errors(plan)] == ["I106"]
    assert "deep" in plan.stop_reason


def test_ret_with_a_condition_returns_only_when_it_holds(tmp_path: Path) -> None:
    jobs = {
        "MAIN": "SET B001 {}\nCALL JOB:SUB\nMOVL C00009 V=50.0",
        "SUB": "RET IF B001=1\nMOVL C00001 V=50.0",
    }
    for value, expected in ((1, [9]), (0, [1, 9])):
        folder = tmp_path / str(value)
        folder.mkdir()
        main = write_jobs(folder, {name: body.format(value) for name, body in jobs.items()})
        assert visited(run(read(main))) == expected


def test_a_macro_calls_the_job_that_macro_dat_names(tmp_path: Path) -> None:
    main = write_jobs(
        tmp_path, {"MAIN": "MACRO1 MJ#(2) ARGF4\nMOVL C00009 V=50.0", "GRIP": "MOVL C00001 V=50.0"}
    )
    missing = run(read(main))
    assert findings(missing) == ["I107"]
    (tmp_path / "MACRO.DAT").write_bytes(b"//MACRO1 2\r\n///JOB1 GRIP\r\n")
    assert visited(run(read(main))) == [1, 9]


def test_a_jump_to_a_job_does_not_come_back(tmp_path: Path) -> None:
    main = write_jobs(tmp_path, {"MAIN": "JUMP JOB:NEXT\nMOVL C00001 V=50.0", "NEXT": "MOVL C00002 V=50.0"})
    assert visited(run(read(main))) == [2]


def test_jobs_that_jump_in_a_circle_run_for_the_wanted_number_of_cycles(tmp_path: Path) -> None:
    main = write_jobs(
        tmp_path, {"MAIN": "MOVL C00001 V=50.0\nJUMP JOB:NEXT", "NEXT": "MOVL C00002 V=50.0\nJUMP JOB:MAIN"}
    )
    assert visited(run(read(main))) == [1, 2]
    plan = run(read(main), cycles=2)
    assert visited(plan) == [1, 2, 1, 2]
    assert "circle" in said(plan)


def test_what_stands_behind_end_is_not_reached() -> None:
    assert visited(plan_of("MOVL C00001 V=50.0\nRET\nMOVL C00002 V=50.0")) == [1]


def test_the_number_of_statements_is_limited() -> None:
    body = "SET D000 0\n*A\nINC D000\nMOVL C00001 V=50.0\nJUMP *A IF D000<100000"
    plan = run(program(body), assumptions=Assumptions(), max_steps=1000)
    assert findings(plan) == ["I108"]
    assert plan.stop_reason == "stopped after 1000 statements"
    assert 300 < len(plan) < 340


def test_comments_do_not_count_as_statements() -> None:
    body = "\n".join([*["'spoken"] * 50, "MOVL C00001 V=50.0", "//SET B000 1", "MOVL C00002 V=50.0"])
    plan = run(program(body), assumptions=Assumptions(), max_steps=3)
    assert visited(plan) == [1, 2]
    assert not findings(plan)


def test_a_switch_without_a_matching_case_runs_nothing() -> None:
    body = (
        "SWITCH B001\nCASE 1\nMOVL C00001 V=50.0\nCASE 2\nMOVL C00002 V=50.0\nENDSWITCH\nMOVL C00009 V=50.0"
    )
    assert visited(plan_of(body, given(B001=3))) == [9]
    assert visited(plan_of(body, given(B001=2))) == [2, 9]


def test_the_counter_of_a_for_loop_stands_one_step_beyond_afterwards() -> None:
    assert waits(plan_of("FOR LI000 START= 0 TO 3\nNEXT LI000\nTIMER T=LI000")) == pytest.approx([0.04])
    assert waits(plan_of("FOR LI000 START= 0 TO 5 STEP 2\nNEXT LI000\nTIMER T=LI000")) == pytest.approx(
        [0.06]
    )


def test_an_emptied_call_stack_ends_the_program_with_the_routine(tmp_path: Path) -> None:
    main = write_jobs(
        tmp_path, {"MAIN": "CALL JOB:SUB\nMOVL C00009 V=50.0", "SUB": "MOVL C00001 V=50.0\nCLEAR STACK"}
    )
    assert visited(run(read(main))) == [1]


def test_what_a_run_is_allowed_grows_with_what_is_read_and_with_the_cycles() -> None:
    endless = "*A\nINC D000\nJUMP *A IF D000<100000000"
    alone = run(program(endless)).stop_reason
    longer = run(program("SET B001 1\n" * 100 + endless)).stop_reason
    counts = [int(re.findall(r"\d+", says)[0]) for says in (alone, longer)]
    assert counts[1] - counts[0] == 1000
    assert 200_000 < counts[0] < 200_200
    assert "2000 statements" in run(program(endless), max_steps=2000).stop_reason
