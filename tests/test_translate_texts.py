"""RAPID's functions of texts in FANUC's string registers, which compute one value by an assignment of its own.

The oracle is the meaning of StrMatch, StrFind, StrLen and StrPart in ABB's reference manual: the waits are counts of
characters, as a person counts them.
"""

from __future__ import annotations

import re

import pytest
from translated_texts import krl, translated

from olp.core.source import decode
from olp.fluent import Program, read_source
from olp.runtime.plan import StepKind
from olp.transpile import Context
from olp.transpile.convert import Converted, convert

_HEAD = 'MODULE M\nPROC main()\nVAR string s:="12 345#rest";\nVAR string t;\nVAR num n;\n'


def module(body: str) -> Program:
    return read_source(decode(f"{_HEAD}{body}\nENDPROC\nENDMODULE\n".encode(), "M.mod"))


def tp(body: str) -> tuple[Converted, Program]:
    made = convert(module(body), "tp", Context(on_loss="comment"))
    return made, read_source(decode(made.files[made.main], made.main), vendor="tp")


def waits(program: Program) -> list[float]:
    plan = program.plan()
    return [round(10 * float(plan.durations[row]), 6) for row in plan.row[plan.kind == StepKind.WAIT]]


CASES = [
    ('n:=StrMatch(s,1,"#"); WaitTime n/10;', [7]),
    ('n:=StrMatch(s,4," "); WaitTime n/10;', [12]),  # none from the fourth on: one more than the length
    ('n:=StrMatch(s,2," ")+1; WaitTime n/10;', [4]),
    ('n:=StrFind(s,4,"#"); WaitTime n/10;', [7]),
    ("IF StrLen(s)>10 THEN WaitTime 0.3; ELSE WaitTime 0.4; ENDIF", [3]),
    ('IF s="x" THEN WaitTime 0.3; ELSEIF StrLen(StrPart(s,4,3))=3 THEN WaitTime 0.4; ENDIF', [4]),
    ('t:=StrPart(s,4,3); WHILE StrLen(t+"a")<6 DO t:=t+"x"; WaitTime 0.1; ENDWHILE', [1, 1]),
    ('t:=s+"ab"+"c"; WaitTime StrLen(t)/10;', [14]),
]


@pytest.mark.parametrize(("body", "tenths"), CASES)
def test_texts_mean_the_same_in_string_registers(body: str, tenths: list[float]) -> None:
    made, written = tp(body)
    assert waits(module(body)) == tenths
    assert waits(written) == tenths
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    for line in made.files[made.main].decode().splitlines():
        # They take registers and stand alone behind the sign (HandlingTool manual, string registers).
        if re.search("STRLEN|SUBSTR|FINDSTR", line):
            assert re.fullmatch(
                r"\s*\d+:\s+S?R\[\d+[^\]]*\]=(STRLEN|SUBSTR|FINDSTR) SR\[\d+[^\]]*\](,S?R\[\d+[^\]]*\])*\s*;",
                line,
            )


@pytest.mark.parametrize(
    ("body", "tenths"), [case for case in CASES if "Str" in case[0] and "StrPart" not in case[0]]
)
def test_places_of_texts_are_the_same_in_scripts(body: str, tenths: list[float]) -> None:
    made = convert(module(body), "urscript", Context(on_loss="comment"))
    written = read_source(decode(made.files[made.main], made.main), vendor="urscript")
    assert waits(written) == tenths
    assert not [loss for loss in made.translated.losses if loss.leaves_out]


def test_a_search_from_a_character_on_is_read_from_a_script() -> None:
    text = 'def a():\n  sleep(str_find("12 345 7", " ", 3) / 10)\n  sleep(str_find("12 345 7", "#", 3) + 1.5)\nend\n'
    program = read_source(decode(text.encode(), "a.script"), vendor="urscript")
    assert waits(program) == [6.0, 5.0]
    made = convert(program, "urscript", Context())
    assert 'str_find("12 345 7", " ", 3)' in made.files[made.main].decode()


def test_a_number_becomes_a_text_with_the_controllers_decimals() -> None:
    made, _ = tp('n:=3; t:=NumToStr(n,2)+"#";')
    assert re.search(r"SR\[\d+[^\]]*\]=R\[\d+", made.files[made.main].decode())
    assert {loss.part for loss in made.translated.losses} == {"text"}


def test_letters_are_not_searched_where_capitals_may_be_the_same() -> None:
    made, _ = tp('n:=StrMatch(s,1,"rest");')
    assert [loss.says for loss in made.translated.losses if loss.leaves_out]


def test_a_character_of_a_text_that_a_routine_takes_is_a_part_of_it():
    text = krl(
        "DECL CHAR M[10]",
        "T(M[])",
        "END",
        "DEF T(S[]:IN)",
        "DECL CHAR S[]",
        'IF S[1]=="C" THEN',
        "WAIT SEC 1",
        "ENDIF",
    )
    assert 'IF StrPart(S,1,1)="C" THEN' in translated(text, "krl", "rapid")


def test_a_name_is_a_text_in_the_routine_that_declares_it_as_one():
    text = krl(
        "DECL CHAR M[10]", "DECL INT L", "L=STRLEN(M[])", "END", "DEF T()", "DECL INT M[10],I", "I=M[2]"
    )
    assert "I:=M{2};" in translated(text, "krl", "rapid")
