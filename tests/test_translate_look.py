"""What a look at a routine finds, held against a walk through every statement and expression of it."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from translate_programs import own_program
from translated_texts import VENDORS, module, translated

import olp
from olp.ir.expressions import Expression, PositionLiteral
from olp.ir.program import Comment, Move, Program, Statement
from olp.ir.transformer import expressions_of, mapped, note_names, sets_numbers
from olp.robots.robot import load_robot
from olp.transpile import Context
from olp.transpile.dead_code import unnamed_speeds
from olp.transpile.occurrences import Look, changed_rare, with_routines, with_rows, with_same_parts
from olp.transpile.pipeline import work_for

ROBOT = load_robot("yaskawa/gp25")
KRL = """DEF m()
DECL E6POS a
$VEL.CP = 0.2
a = {X 900, Y 0, Z 800, A 0, B 90, C 0, E1 5}
LIN a C_DIS
LIN {X 950, Y 0, Z 800, A 0, B 90, C 0}
$VEL.CP = speed
WAIT SEC 1
END
"""


def krl(tmp_path: Path) -> Program:
    (tmp_path / "m.src").write_text(KRL)
    return olp.read(tmp_path / "m.src")


@pytest.mark.parametrize("vendor", VENDORS)
@pytest.mark.parametrize("seed", range(4))
def test_a_look_finds_what_a_walk_through_everything_finds(vendor: str, seed: int, tmp_path: Path) -> None:
    program = own_program(seed, vendor, tmp_path, ROBOT)
    for routine in program.routines:
        look = Look(routine.body)
        names: set[str] = set()
        for s in routine.body:
            note_names(s, names)
        assert look.names() == names
        settings = sum(map(sets_numbers, routine.body))
        assert len(look.rare) + len(look.plain) + settings == len(routine.body)
        assert all(routine.body[at] is s for at, s in look.rare)
    work = work_for(program, "tp", Context())
    everything = [*program.data, *(d for r in program.routines for d in r.data), *program.statements()]
    walked = Counter(e for s in everything for e in expressions_of(s) if type(e) is PositionLiteral)
    assert Counter(work.literals(program)).keys() == walked.keys()


@pytest.mark.parametrize("vendor", VENDORS)
def test_the_expressions_of_a_statement_are_those_that_would_be_changed(vendor: str, tmp_path: Path) -> None:
    program = own_program(5, vendor, tmp_path, ROBOT)
    for s in [*program.statements(), *program.data, *krl(tmp_path).statements()]:
        visited: list[Expression] = []

        def visit(e: Expression, visited: list[Expression] = visited) -> Expression:
            visited.append(e)
            return e

        assert mapped(s, visit) is s
        assert list(map(id, expressions_of(s))) == list(map(id, visited))


def test_plain_moves_and_settings_are_told_from_the_rest(tmp_path: Path) -> None:
    (routine,) = krl(tmp_path).routines
    look = Look(routine.body)
    assert [s.line for s in look.plain] == [5, 6]
    assert [s.line for s in look.direct()] == [s.line for s in look.unnamed()] == [6]
    assert not {3, 5, 6} & {s.line for _, s in look.rare}
    assert {4, 7, 8} <= {s.line for _, s in look.rare}


def test_only_what_is_not_plain_is_changed_and_nothing_is_made_anew_without_a_change(tmp_path: Path) -> None:
    program = krl(tmp_path)
    (routine,) = program.routines
    look = Look(routine.body)
    assert changed_rare(routine, look, lambda s: s) is routine
    assert with_rows(routine, list(routine.body)) is routine
    assert with_routines(program, [routine]) is program

    def change(s: Statement) -> Statement:
        assert not isinstance(s, Move)
        return Comment(s.line, "gone") if s.line == 8 else s

    changed = changed_rare(routine, look, change)
    assert [s.line for s in changed.body if isinstance(s, Comment)] == [8]
    assert len(changed.body) == len(routine.body)
    assert with_routines(program, [changed]).routines == (changed,)


def test_a_look_is_taken_anew_when_the_routine_has_changed(tmp_path: Path) -> None:
    program = krl(tmp_path)
    (routine,) = program.routines
    work = work_for(program, "tp", Context())
    first = work.look(routine)
    assert work.look(replace(routine, line=7)) is first
    shorter = replace(routine, body=routine.body[:-2])
    assert work.look(shorter).body is shorter.body
    assert work.symbols(program) is work.symbols(program)
    assert work.symbols(replace(program, data=())) is not work.symbols(program)


def test_a_program_that_is_put_together_anew_of_the_same_is_the_same(tmp_path: Path) -> None:
    program = krl(tmp_path)
    (routine,) = program.routines
    anew = replace(routine, body=(*routine.body[:1], *routine.body[1:]))
    assert with_same_parts(replace(program, routines=(anew,)), program) is program
    shorter = replace(anew, body=anew.body[:-1])
    assert with_same_parts(replace(program, routines=(shorter,)), program).routines == (shorter,)
    renamed = with_same_parts(replace(program, routines=(replace(anew, comment="new"),)), program)
    assert renamed.routines[0].comment == "new"
    assert renamed.routines[0].body is routine.body
    assert with_same_parts(replace(program, routines=(replace(anew, name="other"),)), program) != program


def test_speeds_that_nothing_names_are_not_looked_at(tmp_path: Path) -> None:
    data = [f"  CONST speeddata v{n}:=[{100 + n},500,5000,1000];" for n in range(1, 6)]
    data += ["  VAR speeddata held:=[1,2,3,4];", "  CONST zonedata near:=[FALSE,1,2,2,1,2,1];"]
    moves = [
        "    held:=v2;",
        "    MoveL [[900,0,800],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],held,fine,tool0;",
    ]
    rows = ["MODULE m", *data, "  PROC main()", *moves, "  ENDPROC", "ENDMODULE"]
    (tmp_path / "m.mod").write_text("\n".join(rows))
    program = olp.read(tmp_path / "m.mod")
    work = work_for(program, "krl", Context())
    left = unnamed_speeds(program, work)
    assert [d.name for d in left.data] == ["v2", "held", "near"]  # the last of each type tells its members
    assert unnamed_speeds(left, work).data == left.data
    assert unnamed_speeds(program, work_for(program, "rapid", Context())) is program


def test_elements_of_positions_are_compared_as_the_controller_counts_them():
    """IFTHENEXP compares a value with a value: quotients stood on both sides."""
    data = [
        f"VAR robtarget {name}:=[[900,0,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];" for name in "pq"
    ]
    rows = ("p.trans.z:=gi1;", "q.trans.z:=gi2;", "IF p.trans.z<q.trans.z x:=1;", "IF 100.5>p.trans.z x:=2;")
    text = translated(module(*rows, data=[*data, "VAR num x;"]), "rapid", "inform")
    assert re.search(r"GETE (D\d+) P000 \(3\)\s+GETE (D\d+) P001 \(3\)\s+IFTHEN \1<\2\s", text), text
    assert re.search(r"GETE (D\d+) P000 \(3\)\s+IFTHEN \1<100500\s", text), text


def test_lengths_of_poses_stay_in_metres_in_urscript():
    data = ("VAR robtarget p:=[[900,0,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];", "VAR num x;")
    rows = ("p.trans.z:=p.trans.z+x-5;", "IF p.trans.x<p.trans.z+100 x:=1;", "IF p.trans.x<x x:=2;")
    text = translated(module(*rows, data=data), "rapid", "urscript")
    assert "[2] + x * 0.001 - 0.005" in text
    assert re.search(r"if \((\w+)\[0\] < \1\[2\] \+ 0\.1\)", text), text
    assert re.search(r"\[0\] \* 1000\.0 < x", text), text


def test_what_holds_for_moves_holds_behind_a_call_that_neither_moves_nor_sets_it():
    """$TOOL, $BASE and $VEL.CP stood again behind each call."""
    data = (
        "CONST robtarget p:=[[900,0,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",
        "VAR num x;", "VAR num v:=100;",
    )  # fmt: skip
    rows = ("MoveL Offs(p,x,0,0),v100,fine,tool0;", "%s;", "MoveL Offs(p,x,0,0),v100,fine,tool0;")
    routines = (
        "PROC grip()", "SetDO do1,1;", "count;", "ENDPROC", "PROC count()", "x:=x+1;", "ENDPROC",
        "PROC away()", "MoveL p,v500,fine,tool0;", "ENDPROC",
    )  # fmt: skip
    text = module(*rows, data=data).replace("ENDMODULE", "\r\n".join((*routines, "ENDMODULE")))
    quiet, loud = (translated(text % name, "rapid", "krl") for name in ("grip", "away"))
    assert quiet.split("DEF grip")[0].count("$VEL.CP=0.1") == 1
    assert loud.split("DEF grip")[0].count("$VEL.CP=0.1") == 2


def test_what_holds_for_moves_is_followed_through_branches():
    """$TOOL and set_tcp stood again in each branch, and behind it."""
    data = (
        "CONST robtarget p:=[[900,0,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];", "VAR num x;",
        "PERS tooldata t1:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];",
        "PERS tooldata t2:=[TRUE,[[0,0,200],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];",
    )  # fmt: skip
    there = "MoveL Offs(p,x,0,0),%s,fine,%s;"
    rows = [
        "IF di3=1 x:=1;", there % ("v100", "t1"), "IF di1=1 THEN", there % ("v100", "t1"), "ELSEIF di2=1 THEN",
        there % ("v100", "%s"), "ELSE", there % ("v200", "t1"), "ENDIF", there % ("v100", "t1"),
    ]  # fmt: skip
    same, other = (module(*(row.replace("%s", tool) for row in rows), data=data) for tool in ("t1", "t2"))
    for target, word in (("krl", "$TOOL="), ("urscript", "set_tcp(")):
        assert translated(same, "rapid", target).count(word) == 1
        assert translated(other, "rapid", target).count(word) == 3
    assert (
        translated(same, "rapid", "krl").count("$VEL.CP=0.1\r") == 2
    )  # not known behind a branch with another one
