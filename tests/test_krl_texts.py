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


def rapid(body: str) -> Program:
    head = "MODULE M\nPROC main()\nVAR string line;\nVAR string s;\nVAR string t;\nVAR num n;\n"
    return read_source(decode(f"{head}{body}\nENDPROC\nENDMODULE\n".encode(), "M.mod"))


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
