"""Texts that are put together, in KRL: StrAdd and SWRITE change an array of CHAR in place.

The oracle is the meaning in KUKA's and ABB's manuals: the waits are lengths of texts, as a person counts them.
"""

from __future__ import annotations

import pytest

from olp.core.source import decode
from olp.fluent import Program, read_source
from olp.runtime.plan import StepKind
from olp.transpile import Context
from olp.transpile.convert import convert


def rapid(body: str, more: str = "") -> Program:
    head = "MODULE M\nPROC main()\nVAR string line;\nVAR string s;\nVAR string t;\nVAR num n;\n"
    return read_source(decode(f"{head}{body}\nENDPROC\n{more}ENDMODULE\n".encode(), "M.mod"))


def waits(program: Program) -> list[float]:
    plan = program.plan()
    return [round(10 * float(plan.durations[row]), 6) for row in plan.row[plan.kind == StepKind.WAIT]]


CASES = [
    ('s:="abc"+"de"; WaitTime StrLen(s)/10;', [5]),
    ('s:="abc"; t:="x"; t:=s+t; t:=t+s+t; WaitTime StrLen(t)/10;', [11]),
    ('n:=2.345; s:=NumToStr(n,2)+" mm"; WaitTime StrLen(s)/10;', [7]),  # 2.35 mm or 2.34 mm
    ('n:=12; s:="x="+NumToStr(n+1,0)+";"; WaitTime StrLen(s)/10;', [5]),
]


@pytest.mark.parametrize(("body", "tenths"), CASES)
def test_joined_texts_are_as_long_in_krl(body: str, tenths: list[float]) -> None:
    made = convert(rapid(body), "krl", Context(on_loss="comment"))
    written = read_source(decode(made.files[made.main], made.main), vendor="krl")
    assert waits(rapid(body)) == tenths
    assert waits(written) == tenths
    assert not [loss for loss in made.translated.losses if loss.leaves_out]


def test_a_join_is_written_as_krl_has_it() -> None:
    made = convert(rapid('line:="x="+NumToStr(n,1); TPWrite line+"!";'), "krl", Context())
    rows = [row.strip() for row in made.files[made.main].decode().splitlines()]
    at = rows.index('line[]="x="')
    assert rows[at : at + 7] == [
        'line[]="x="',
        "TEXT_VALUE=n",
        "TEXT_OFFSET=StrLen(line[])",
        'SWRITE(line[],TEXT_STATE,TEXT_OFFSET,"%.1f",TEXT_VALUE)',
        "TEXT_WHOLE[]=line[]",
        'TEXT_LENGTH=StrAdd(TEXT_WHOLE[],"!")',
        "MsgNotify(TEXT_WHOLE[])",
    ]
    for word in ("CHAR TEXT_WHOLE[80]", "INT TEXT_LENGTH", "STATE_T TEXT_STATE", "REAL TEXT_VALUE"):
        assert f"DECL {word}" in rows


def test_kukas_own_joins_are_joins_elsewhere() -> None:
    declared = "DEF m()\nDECL CHAR a[20]\nDECL CHAR b[20]\nINT n\n"
    text = declared + 'a[]="abc"\nb[]="de"\nn=StrAdd(a[],b[])\nWAIT SEC n/10.0\nEND\n'
    source = read_source(decode(text.encode(), "m.src"))
    assert waits(source) == [5]
    made = convert(source, "rapid", Context())
    assert "a:=a + b;" in made.files[made.main].decode()


ROUTINE = "FUNC string part(string of, num first)\nRETURN StrPart(of,first,2);\nENDFUNC\n"
WITHIN = [
    ('s:="12;345"; t:=StrPart(s,1,StrMatch(s,1,";")-1); WaitTime StrLen(t)/10;', [2]),
    ('s:="12;345"; s:=StrPart(s,4,3); IF s="345" THEN WaitTime 0.7; ENDIF', [7]),
    ('s:="abcabc"; n:=StrFind(s,2,"c"); WaitTime n/10; n:=StrMatch(s,4,"bb"); WaitTime n/10;', [3, 7]),
    ('s:="ab"; IF StrPart(s,1,1)="b" THEN n:=1; ELSEIF StrPart(s,2,1)="b" THEN n:=4; ENDIF WaitTime n/10;', [4]),
    ('n:=1; WHILE StrLen(StrPart("abcdef",1,n))<3 DO n:=n+1; ENDWHILE WaitTime n/10;', [3]),
    ('s:="x1"; TEST StrPart(s,1,1) CASE "y": n:=1; CASE "x","z": n:=5; DEFAULT: n:=6; ENDTEST WaitTime n/10;', [5]),
    ('s:="n="+ValToStr(12)+ValToStr(n=0); WaitTime StrLen(s)/10;', [8]),
    ('t:=part("abc"+"de",4)+part("xyz",1); IF t="dexy" THEN WaitTime 0.9; ENDIF', [9]),
]  # fmt: skip


@pytest.mark.parametrize(("body", "tenths"), WITHIN)
def test_texts_within_statements_are_put_together_before_them(body: str, tenths: list[float]) -> None:
    program = rapid(body, ROUTINE)
    made = convert(program, "krl", Context(on_loss="comment"))
    written = read_source(decode(made.files[made.main], made.main), vendor="krl")
    assert waits(program) == tenths
    assert waits(written) == tenths
    assert not [loss for loss in made.translated.losses if loss.leaves_out]


def test_arrays_of_texts_have_their_rows_in_krl() -> None:
    body = """VAR string names{2}:=["ab","cde"];
    names{1}:="x"+names{2};
    WaitTime StrLen(names{1})/10;
    WaitTime StrLen(names{2})/10;"""
    made = convert(rapid(body), "krl", Context(on_loss="comment"))
    text = made.files[made.main].decode()
    assert "CHAR names[2,80]" in text
    assert 'names[2,]="cde"' in text
    written = read_source(decode(made.files[made.main], made.main), vendor="krl")
    assert waits(rapid(body)) == waits(written) == [4, 3]


def test_a_text_in_a_variable_of_numbers_is_refused_in_krl() -> None:
    source = 'def f():\n  x = 1\n  sleep(x)\n  x = "a" + to_str(2)\n  popup(x)\nend\n'
    made = convert(read_source(decode(source.encode(), "f.script")), "krl", Context(on_loss="comment"))
    assert 4 in {loss.line for loss in made.translated.losses if loss.leaves_out}
    assert "x_1[]" not in made.files[made.main].decode()
