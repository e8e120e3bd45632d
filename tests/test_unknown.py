"""What no file at hand says: assumed with its name and told, an error where olp.toml asks for that."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import olp
from olp.runtime.assumptions import UNKNOWN
from olp.runtime.plan import ASSUMABLE, Plan, StepKind, leaves_open
from olp.timing.timing import time_plan

POSE = "{X 812.4,Y -33.1,Z 707.5,A 12,B 3,C 178}"
BODY = f"""DEF UNSAID()
LIN {POSE}
GRIP_7(3)
IF N_PARTS > 2 THEN
LIN {{X 700.1,Y -33.1,Z 707.5,A 12,B 3,C 178}}
ENDIF
LIN XNOWHERE
LIN {{X 812.4,Y 133.1,Z 707.5,A 12,B 3,C 178}}
END
"""


def planned(folder: Path, body: str = BODY, toml: str = "", robot: str = "kuka/kr16-2") -> Plan:
    (folder / "unsaid.src").write_text(body)
    (folder / "olp.toml").write_text(toml)
    return olp.read(folder / "unsaid.src").plan(robot)


def told(plan: Plan, severity: str) -> dict[str, str]:
    """Code -> message of the run's own findings."""
    return {d.code: d.message for d in plan.diagnostics if d.severity == severity and d.code[0] == "I"}


def test_a_total_is_complete_without_what_no_file_says_and_names_each_assumption(tmp_path: Path) -> None:
    plan = planned(tmp_path)
    assert not told(plan, "error")
    assert "left out" in told(plan, "warning")["I102"]
    said = [d.message for d in plan.diagnostics if d.code == "I209"]
    assert said == [
        "nothing defines N_PARTS: taken as 0",
        "nothing defines XNOWHERE: the statement is left out",
    ]
    assert list(plan.line[plan.kind == StepKind.MOVE]) == [2, 8]
    assert not np.isnan(time_plan(plan).duration_s).any()


@pytest.mark.parametrize(("key", "code"), [("routines", "I102"), ("values", "I209")])
def test_a_key_of_unknown_makes_it_an_error(tmp_path: Path, key: str, code: str) -> None:
    assert code in told(planned(tmp_path, toml=f'[unknown]\n{key} = "error"\n'), "error")


def test_a_known_routine_that_is_not_here_takes_the_time_that_olp_toml_gives_it(tmp_path: Path) -> None:
    plan = planned(tmp_path, toml="[known-routines]\nGrip_7 = 0.8\n")
    assert "I102" not in told(plan, "warning")
    assert time_plan(plan).wait_s == pytest.approx(0.8)


def test_a_wrong_choice_and_an_unknown_key_are_told_with_what_there_is(tmp_path: Path) -> None:
    plan = planned(tmp_path, toml='[unknown]\nroutines = "guess"\npoints = "error"\n')
    assert {"V003", "V004"} <= {d.code for d in plan.diagnostics}


def test_a_relative_move_before_any_other_begins_in_front_of_the_base(tmp_path: Path) -> None:
    body = "DEF UNSAID()\nLIN_REL {Z -55.5}\nEND\n"
    plan = planned(tmp_path, body)
    assert not told(plan, "error")
    assert any("in front of its base" in a.says for a in plan.assumptions)
    strict = planned(tmp_path, body, '[unknown]\nstart = "error"\n')
    assert "I215" in told(strict, "error")


def test_what_a_wrong_guess_breaks_is_no_error_of_the_program(tmp_path: Path) -> None:
    body = "DEF UNSAID()\nINT N\nN = 7 / N_PARTS\nEND\n"
    assert told(planned(tmp_path, body), "warning").keys() == {"I207", "I209"}


def test_routines_are_global_in_the_whole_tree_of_the_robot(tmp_path: Path) -> None:
    main, lib = tmp_path / "R1/Program/Cell", tmp_path / "R1/Program/Lib/Gripper"
    main.mkdir(parents=True)
    lib.mkdir(parents=True)
    (lib / "grip_7.src").write_text(f"DEF GRIP_7(N:IN)\nINT N\nLIN {POSE}\nWAIT SEC 0.7\nEND\n")
    (lib / "broken.src").write_text("DEF BROKEN()\nIF $IN[1] THEN\n:=(\nEND\n")
    (lib / "data.dat").write_text("DEFDAT DATA PUBLIC\nDECL GLOBAL INT N_PARTS=3\nENDDAT\n")
    plan = planned(main)
    assert time_plan(plan).wait_s == pytest.approx(0.7)
    assert 5 in plan.line[plan.kind == StepKind.MOVE]  # N_PARTS is 3
    assert not [d for d in plan.diagnostics if d.severity == "error"]


def test_every_switch_switches_something() -> None:
    assert set(UNKNOWN) == set(ASSUMABLE.values())


GUARDED = f"""DEF UNSAID()
IF NOT $IN[7] THEN
RETURN
ENDIF
IF ($IN[8]==TRUE) AND ($IN[9]==TRUE) THEN
LIN {POSE}
LIN {{X 700.1,Y -33.1,Z 707.5,A 12,B 3,C 178}}
ENDIF
END
"""


def test_a_program_that_would_end_before_its_first_move_gets_inputs_with_which_it_makes_it(
    tmp_path: Path,
) -> None:
    plan = planned(tmp_path, GUARDED)
    assert list(plan.line[plan.kind == StepKind.MOVE]) == [6, 7]
    found = [(d.line, d.message) for d in plan.diagnostics if d.code == "I118"]
    assert sorted(found) == [
        (2, "IN#(7) is taken as ON: else the run ends before its first move"),
        (5, "IN#(8) is taken as ON: else the run ends before its first move"),
        (5, "IN#(9) is taken as ON: else the run ends before its first move"),
    ]


def test_values_are_taken_only_where_nothing_tells_them(tmp_path: Path) -> None:
    plan = planned(tmp_path, GUARDED, '[inputs]\n"IN#(7)" = false\n')
    assert not np.any(plan.kind == StepKind.MOVE)
    assert not any(map(leaves_open, plan.diagnostics))  # the user said it: this is what happens


def test_a_program_for_whose_first_move_no_values_are_found_asks_for_them(tmp_path: Path) -> None:
    plan = planned(tmp_path, GUARDED.replace("$IN[8]==TRUE", "$IN[7]==FALSE"))
    found = next(d for d in plan.diagnostics if d.code == "I118")
    assert found.message == "the run ends before the first move of the program"
    assert found.help == "say in olp.toml what it asks for: IN#(7)"
    assert leaves_open(found)


def test_what_fails_with_values_taken_for_the_first_move_is_a_warning(tmp_path: Path) -> None:
    body = GUARDED.replace("IF (", "DECL INT size[2]\nIF (").replace("ENDIF\nEND", "size[3]=1\nENDIF\nEND")
    plan = planned(tmp_path, body)
    assert "I223" in told(plan, "warning")
    assert "I223" not in told(plan, "error")


def test_nothing_is_taken_for_the_first_move_where_olp_toml_forbids_it(tmp_path: Path) -> None:
    plan = planned(tmp_path, GUARDED, '[unknown]\nfirst-move = "error"\n')
    assert told(plan, "error")["I118"] == "the run ends before the first move of the program"
    assert not np.any(plan.kind == StepKind.MOVE)


def test_what_unknown_functions_return_is_taken_so_that_the_program_moves(tmp_path: Path) -> None:
    (tmp_path / "served.script").write_text(
        'def served():\n  server = rpc_factory("xmlrpc", "http://127.0.0.1:40404")\n'
        "  ready = server.start()\n  if not ready:\n    halt\n  end\n  if server.job() != 7:\n    halt\n  end\n"
        "  movej([0.1, -1.3, 1.2, -0.4, 0.5, 0.6])\n  movej([0.4, -1.1, 1.0, -0.2, 0.3, 0.5])\nend\n"
    )
    plan = olp.read(tmp_path / "served.script").plan("universal-robots/ur10e")
    assert list(plan.line[plan.kind == StepKind.MOVE]) == [10, 11]
    found = {d.line: d.message.split(":")[0] for d in plan.diagnostics if d.code == "I118"}
    assert found == {
        3: "what server.start returns is taken as true",
        7: "what server.job returns is taken as 7",
    }


def test_of_many_values_the_one_that_lets_a_program_move_is_found(tmp_path: Path) -> None:
    ends = "".join(f"IF K{n}=={20 + n} THEN\nRETURN\nENDIF\n" for n in range(2, 13))
    body = f"DEF UNSAID()\nDECL INT n\nn=K1\n{ends}IF n==0 THEN\nRETURN\nENDIF\nLIN {POSE}\nEND\n"
    plan = planned(tmp_path, body)
    found = [d.message.split(":")[0] for d in plan.diagnostics if d.code == "I118"]
    assert found == ["k1 is taken as 1"]
    assert np.sum(plan.kind == StepKind.MOVE) == 1


def test_a_program_that_moves_keeps_its_inputs_off(tmp_path: Path) -> None:
    body = GUARDED.replace("IF NOT", f"LIN {POSE}\nIF NOT")
    assert "I118" not in told(planned(tmp_path, body), "warning")
