"""Random programs that compute with arrays, routines and branches; Python computes what they wait for."""

from __future__ import annotations

import random
from typing import NamedTuple

import pytest
from translated_texts import VENDORS, converted, read, run_elsewhere

# A program prints one number, as the duration of its only wait.
HEADS = {
    "rapid": """MODULE M
PROC main()
VAR num x:=1;
VAR num y:=2;
VAR num a{4}:=[1,2,3,4];
VAR num m{2,3}:=[[1,2,3],[4,5,6]];
""",
    "krl": "DEF P()\nDECL INT x,y,a[4],m[2,3],i,j\nx=1\ny=2\n"
    + "".join(f"a[{n}]={n}\n" for n in range(1, 5))
    + "".join(f"m[{n},{k}]={3 * n - 3 + k}\n" for n in (1, 2) for k in (1, 2, 3)),
}
TAILS = {
    "rapid": """ENDPROC
PROC lift(INOUT num v{*},num n)
FOR k FROM 1 TO Dim(v,1) DO
v{k}:=v{k}+n;
ENDFOR
ENDPROC
FUNC num pick(num n,INOUT num v{*})
v{1}:=v{1}+1;
IF n>10 RETURN 7;
RETURN n*2+v{2};
ENDFUNC
ENDMODULE
""",
    "krl": """END
DEF lift(v[]:OUT,n:IN)
DECL INT v[],n,k
FOR k=1 TO 4
v[k]=v[k]+n
ENDFOR
END
DEFFCT INT pick(n:IN,v[]:OUT)
DECL INT n,v[]
v[1]=v[1]+1
IF n>10 THEN
RETURN 7
ENDIF
RETURN n*2+v[2]
ENDFCT
""",
}


def quotient(of, by):
    """Both languages round towards zero."""
    return abs(of) // by * (1 if of >= 0 else -1)


def lift(v, n):
    v[1:] = [one + n for one in v[1:]]


def pick(n, v):
    v[1] += 1
    return 7 if n > 10 else n * 2 + v[2]


class Code(NamedTuple):
    """The same in each language."""

    rapid: str
    krl: str
    python: str

    def __mod__(self, parts):
        return Code(*(form % tuple(p[n] for p in parts) for n, form in enumerate(self)))


SUM, DIFFERENCE, PRODUCT = (Code(*[f"(%s{sign}%s)"] * 3) for sign in "+-*")
QUOTIENT = Code("(%s DIV %s)", "(%s/%s)", "quotient(%s, %s)")
SMALLER = Code(
    "((%s)-((%s) DIV 97)*97)", "((%s)-((%s)/97)*97)", "((%s)-quotient((%s), 97)*97)"
)  # whatever it was


def same(text):
    return Code(text, text, text)


def value(draw, deep=2):
    kind = draw.randrange(7 if deep else 4)
    if kind == 0:
        return same(str(draw.randint(0, 9)))
    if kind == 1:
        return same(draw.choice("xy"))
    if kind == 2:
        n = draw.randint(1, 4)
        return Code(f"a{{{n}}}", f"a[{n}]", f"a[{n}]")
    if kind == 3:
        n, k = draw.randint(1, 2), draw.randint(1, 3)
        return Code(f"m{{{n},{k}}}", f"m[{n},{k}]", f"m[{n}][{k}]")
    if kind == 4:
        return QUOTIENT % (value(draw, deep - 1), same(str(draw.randint(2, 5))))
    return draw.choice((SUM, DIFFERENCE, PRODUCT)) % (value(draw, deep - 1), value(draw, deep - 1))


def small(draw):
    found = value(draw)
    return SMALLER % (found, found)


def condition(draw, deep=1):
    if deep and draw.random() < 0.5:
        word = draw.choice(("and", "or"))
        form = Code(*[f"(%s {word.upper()} %s)"] * 2, f"(%s {word} %s)")
        return form % (condition(draw, 0), condition(draw, 0))
    sign = draw.choice(("<", "<=", ">", ">="))
    return Code(*[f"(%s{sign}%s)"] * 3) % (value(draw, 1), value(draw, 1))


def indented(body):
    return Code(body.rapid, body.krl, "".join(f" {row}\n" for row in body.python.splitlines()) or " pass\n")


def statements(draw, count, deep=2):
    made = same("")
    for _ in range(count):
        one = statement(draw, draw.randrange(7 if deep else 4), deep)
        made = Code(*(before + after for before, after in zip(made, one, strict=True)))
    return made


def statement(draw, kind, deep):
    if kind == 0:
        name = same(draw.choice("xy"))
        return Code("%s:=%s;\n", "%s=%s\n", "%s = %s\n") % (name, small(draw))
    if kind == 1:
        n = same(str(draw.randint(1, 4)))
        return Code("a{%s}:=%s;\n", "a[%s]=%s\n", "a[%s] = %s\n") % (n, small(draw))
    if kind == 2:
        return Code("lift a,%s;\n", "lift(a[],%s)\n", "lift(a, %s)\n") % (small(draw),)
    if kind == 3:
        name = same(draw.choice("xy"))
        return Code("%s:=pick(%s,a);\n", "%s=pick(%s,a[])\n", "%s = pick(%s, a)\n") % (name, small(draw))
    body = indented(statements(draw, 2, deep - 1))
    if kind == 4:
        first, last = (same(str(draw.randint(*ends))) for ends in ((1, 2), (2, 4)))
        i = same("ij"[deep - 1])  # KUKA's counter is the same variable in both loops
        form = Code(
            "FOR %s FROM %s TO %s DO\na{%s}:=a{%s}+%s;\n%sENDFOR\n",
            "FOR %s=%s TO %s\na[%s]=a[%s]+%s\n%sENDFOR\n",
            "for %s in range(%s, %s + 1):\n a[%s] = a[%s] + %s\n%s",
        )
        return form % (i, first, last, i, i, i, body)
    other = indented(statements(draw, 1, 0))
    if kind == 5:
        form = Code(*["IF %s THEN\n%sELSE\n%sENDIF\n"] * 2, "if %s:\n%selse:\n%s")
        return form % (condition(draw), body, other)
    form = Code(
        "TEST x\nCASE 1,2:\n%sDEFAULT:\n%sENDTEST\n",
        "SWITCH x\nCASE 1,2\n%sDEFAULT\n%sENDSWITCH\n",
        "if x in (1, 2):\n%selse:\n%s",
    )
    return form % (body, other)


def program(seed):
    """The program in each language, and what it waits for [s]."""
    draw = random.Random(seed)
    body = statements(draw, 6)
    always = Code(
        "lift a,1;\ny:=pick(1,a);\n", "lift(a[],1)\ny=pick(1,a[])\n", "lift(a, 1)\ny = pick(1, a)\n"
    )
    told = Code(
        "x+y*2+a{1}*3+a{2}*5+a{3}*7+a{4}*11+m{2,3}",
        "x+y*2+a[1]*3+a[2]*5+a[3]*7+a[4]*11+m[2,3]",
        "x+y*2+a[1]*3+a[2]*5+a[3]*7+a[4]*11+m[2][3]",
    )
    names = {"quotient": quotient, "lift": lift, "pick": pick}
    names |= {"x": 1, "y": 2, "a": [0, 1, 2, 3, 4], "m": [[], [0, 1, 2, 3], [0, 4, 5, 6]]}
    exec(f"{body.python}{always.python}told = {told.python}\n", names)
    texts = {
        "rapid": f"{HEADS['rapid']}{body.rapid}{always.rapid}WaitTime 20000+{told.rapid};\n{TAILS['rapid']}",
        "krl": f"{HEADS['krl']}{body.krl}{always.krl}WAIT SEC 20000+{told.krl}\n{TAILS['krl']}",
    }
    return texts, 20000 + names["told"]


@pytest.mark.slow("0", "2", "3", "5")
@pytest.mark.parametrize("seed", range(6))
def test_what_random_programs_compute_is_computed_everywhere(seed):
    texts, wanted = program(seed)
    for vendor, text in texts.items():
        assert read(text, vendor).plan().durations.sum() == pytest.approx(wanted)
        for target in VENDORS:
            if target == vendor:
                continue
            if not any(loss.leaves_out for loss in converted(text, vendor, target).translated.losses):
                plan = run_elsewhere(text, vendor, target)
                assert plan.durations.sum() == pytest.approx(wanted), (vendor, target)
            else:
                assert (vendor, target) == ("krl", "urscript")  # a function that hands an array back
