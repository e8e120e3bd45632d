"""Programs for `bench/language.py`: moves with what stands between them in real ones, in all five languages."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator


def _between(
    number: int, chance: random.Random, words: dict[str, Callable[[random.Random, int], list[str]]]
) -> list[str]:
    """What stands behind every tenth move: an output, a wait, arithmetic, a condition, a comment, an input."""
    kinds = {2: "output", 3: "dwell", 4: "count", 5: "branch", 7: "remark", 8: "input"}
    kind = kinds.get(number % 10)
    return words[kind](chance, number) if kind else []


def _places(chance: random.Random) -> Iterator[tuple[float, float, float]]:
    """A raster over a sheet in front of the robot [mm]."""
    number = 0
    while True:
        row, column = divmod(number, 40)
        x = 900.0 + 7.3 * (column if row % 2 == 0 else 39 - column)
        yield x, -250.0 + 9.1 * (row % 60), 120.0 + 40.0 * chance.random()
        number += 1


def inform(lines: int) -> str:
    chance = random.Random(7)
    words = {
        "output": lambda c, n: [f"DOUT OT#({c.randrange(1, 99)}) ON"],
        "dwell": lambda c, n: [f"TIMER T={c.randrange(1, 90) / 100:.2f}"],
        "count": lambda c, n: [f"SET B{c.randrange(90):03d} {c.randrange(200)}"],
        "branch": lambda c, n: [
            f"IFTHENEXP B{c.randrange(90):03d}>{c.randrange(99)}", f"PULSE OT#({c.randrange(1, 99)}) T=0.30", "ENDIF"
        ],
        "remark": lambda c, n: [f"'seam {n} of the left side"],
        "input": lambda c, n: [f"WAIT IN#({c.randrange(1, 99)})=ON T={c.randrange(1, 30) / 10:.2f}"],
    }  # fmt: skip
    points: list[str] = []
    body: list[str] = []
    for x, y, z in _places(chance):
        number = len(points)
        points.append(
            f"C{number:05d}={x:.3f},{y:.3f},{z:.3f},179.1000,{chance.random() * 9:.4f},{chance.random():.4f}"
        )
        speed = f"V={chance.randrange(1000, 5000) / 10:.1f} PL={chance.randrange(4)}"
        body += [
            f"MOVL C{number:05d} {speed}" if number else "MOVJ C00000 VJ=25.00",
            *_between(number, chance, words),
        ]
        if len(points) + len(body) >= lines - 14:
            break
    head = [
        "/JOB",
        "//NAME LONG",
        "//POS",
        f"///NPOS {len(points)},0,0,0,0,0",
        "///TOOL 0",
        "///POSTYPE BASE",
        "///RECTAN",
    ]
    middle = ["//INST", "///DATE 2026/05/21 11:36", "///ATTR SC,RW", "///GROUP1 RB1", "NOP"]
    return "\r\n".join([*head, "///RCONF 1" + ",0" * 23, *points, *middle, *body, "END", ""])


def krl(lines: int) -> str:
    chance = random.Random(7)
    words = {
        "output": lambda c, n: [f"$OUT[{c.randrange(1, 99)}]=TRUE"],
        "dwell": lambda c, n: [f"WAIT SEC {c.randrange(1, 90) / 100}"],
        "count": lambda c, n: [f"n=n+{c.randrange(20)}"],
        "branch": lambda c, n: [
            f"IF n>{c.randrange(99)} THEN", f"  PULSE($OUT[{c.randrange(1, 99)}],TRUE,0.{c.randrange(10, 99)})", "ENDIF"
        ],
        "remark": lambda c, n: [f"; seam {n} of the left side"],
        "input": lambda c, n: [f"WAIT FOR $IN[{c.randrange(1, 99)}]"],
    }  # fmt: skip
    text = [
        "&ACCESS RVP",
        "DEF LONG ( )",
        "DECL INT n",
        "BAS (#INITMOV,0)",
        "PTP {X 900,Y -250,Z 140,A 1,B 2,C 179,S 2,T 10}",
    ]
    for number, (x, y, z) in enumerate(_places(chance), 1):
        text.append(
            f"LIN {{X {x:.3f},Y {y:.3f},Z {z:.3f},A {chance.random():.3f},B {chance.random() * 9:.3f},C 179.1}} C_DIS"
        )
        text += _between(number, chance, words)
        if len(text) >= lines - 2:
            return "\r\n".join([*text, "END", ""])
    raise AssertionError


def rapid(lines: int) -> str:
    chance = random.Random(7)
    words = {
        "output": lambda c, n: [f"    SetDO do{c.randrange(1, 99)},1;"],
        "dwell": lambda c, n: [f"    WaitTime {c.randrange(1, 90) / 100};"],
        "count": lambda c, n: [f"    n:=n+{c.randrange(20)};"],
        "branch": lambda c, n: [
            f"    IF n>{c.randrange(99)} THEN", f"      PulseDO\\PLength:=0.3,do{c.randrange(1, 99)};", "    ENDIF"
        ],
        "remark": lambda c, n: [f"    ! seam {n} of the left side"],
        "input": lambda c, n: [f"    WaitDI di{c.randrange(1, 99)},1;"],
    }  # fmt: skip
    rest = "[0.0087,0.9998,0.0174,0.0087],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    text = ["MODULE Long", "  VAR num n:=0;", "  PROC main()"]
    for number, (x, y, z) in enumerate(_places(chance), 1):
        text.append(
            f"    MoveL [[{x:.3f},{y:.3f},{z:.3f}],{rest},v{chance.choice([100, 200, 500])},z10,tool0;"
        )
        text += _between(number, chance, words)
        if len(text) >= lines - 3:
            return "\r\n".join([*text, "  ENDPROC", "ENDMODULE", ""])
    raise AssertionError


def tp(lines: int) -> str:
    chance = random.Random(7)
    words = {
        "output": lambda c, n: [f"  DO[{c.randrange(1, 99)}]=ON ;"],
        "dwell": lambda c, n: [f"  WAIT   {c.randrange(1, 90) / 100:.2f}(sec) ;"],
        "count": lambda c, n: [f"  R[{c.randrange(1, 90)}]=R[{c.randrange(1, 90)}]+{c.randrange(20)} ;"],
        "branch": lambda c, n: [
            f"  IF R[{c.randrange(1, 90)}]>{c.randrange(99)},JMP LBL[{n}] ;",
            f"  DO[{c.randrange(1, 99)}]=PULSE,0.3sec ;",
            f"  LBL[{n}] ;",
        ],
        "remark": lambda c, n: [f"  !seam {n} of the left side ;"],
        "input": lambda c, n: [f"  WAIT DI[{c.randrange(1, 99)}]=ON ;"],
    }  # fmt: skip
    body, points = ["  UFRAME_NUM=0 ;", "  UTOOL_NUM=1 ;"], list[str]()
    for number, (x, y, z) in enumerate(_places(chance), 1):
        body.append(f"L P[{number}] {chance.randrange(100, 500)}mm/sec CNT{chance.randrange(100)}    ;")
        body += _between(number, chance, words)
        points += [
            f"P[{number}]{{", "   GP1:", "\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',",
            f"\tX = {x:9.4f}  mm,\tY = {y:9.4f}  mm,\tZ = {z:9.4f}  mm,",
            f"\tW = 179.10000 deg,\tP = {chance.random():9.5f} deg,\tR = {chance.random():9.5f} deg", "};",
        ]  # fmt: skip
        if len(body) + len(points) >= lines - 7:
            break
    numbered = [f"{number:4d}:{text}" for number, text in enumerate(body, 1)]
    return "\r\n".join(
        [
            "/PROG  LONG",
            "/ATTR",
            "OWNER\t\t= MNEDITOR;",
            "/APPL",
            "/MN",
            *numbered,
            "/POS",
            *points,
            "/END",
            "",
        ]
    )


def urscript(lines: int) -> str:
    chance = random.Random(7)
    words = {
        "output": lambda c, n: [f"  set_standard_digital_out({c.randrange(8)}, True)"],
        "dwell": lambda c, n: [f"  sleep({c.randrange(1, 90) / 100})"],
        "count": lambda c, n: [f"  n = n + {c.randrange(20)}"],
        "branch": lambda c, n: [
            f"  if n > {c.randrange(99)}:",
            f"    set_digital_out({c.randrange(8)}, False)",
            "  end",
        ],
        "remark": lambda c, n: [f"  # seam {n} of the left side"],
        "input": lambda c, n: [
            f"  while get_standard_digital_in({c.randrange(8)}) == False:",
            "    sync()",
            "  end",
        ],
    }
    text = [
        "def long():",
        "  n = 0",
        "  set_tcp(p[0, 0, 0.1, 0, 0, 0])",
        "  movej([0, -1.57, 1.57, -1.57, -1.57, 0], a=1.4, v=1.05)",
    ]
    for number, (x, y, z) in enumerate(_places(chance), 1):
        place = f"p[{x / 2000:.4f}, {y / 2000:.4f}, {z / 1000:.4f}, 0, 3.14, {chance.random() / 9:.4f}]"
        text.append(f"  movel({place}, a=1.2, v=0.{chance.randrange(10, 90)}, r=0.002)")
        text += _between(number, chance, words)
        if len(text) >= lines - 2:
            return "\n".join([*text, "end", "long()", ""])
    raise AssertionError


PROGRAMS: dict[str, tuple[str, Callable[[int], str]]] = {
    "inform": ("LONG.JBI", inform),
    "krl": ("LONG.src", krl),
    "rapid": ("LONG.mod", rapid),
    "tp": ("LONG.LS", tp),
    "urscript": ("long.script", urscript),
}
