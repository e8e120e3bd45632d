"""Attacks olp as whoever sends programs, recordings, settings, caches and repositories could, and prints a table.

    python bench/hostile.py                          every attack once, and 1,000 made variants of them
    python bench/hostile.py --variants 20 --only git
    python bench/hostile.py --show GROUP/NAME/SEED   one of them, with all that olp says
    python bench/hostile.py --ways                   the same answers in the locale C, with -O, -W error, other Pythons
    python bench/hostile.py --killed 50              commands that are killed at random moments and started again
    python bench/hostile.py --many 10000             a check of that many jobs, one of a hundred hostile

An attack is a function that writes what is hostile into an empty folder and gives the command lines that meet it; what
it draws from its dice makes the variants. Each command runs in a process of its own that begins where olp's imports
end, in one of twenty variants in a Python of its own; it is held when it ends with status 0, 1 or 2, says why it has no
answer in a line with a code, and takes no traceback, no more than 2 s of CPU, no 2 s of waiting for nothing and no more
than 500 MB. Exit status 1 when anything was not held.
"""

from __future__ import annotations

import argparse
import gzip
import io
import json
import os
import random
import re
import resource
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
SAMPLES = ROOT / "samples"
CELL = SAMPLES / "inform" / "palletising"
JOB = CELL / "PICK.JBI"
LIMIT_S, LIMIT_MB = 2.0, 500.0
_GIVEN_UP_S = 30.0
_ANEW = 20  # one of so many variants begins with Python itself
_CODE = re.compile(r"\b[A-Z]\d{3}\b")
_NUMBER = re.compile(rb"\d+\.?\d*")

Words = list[str]
Attack = Callable[[Path, random.Random], Iterator[Words]]


# --- What is hostile ---

CONFIGURATIONS = {
    "a filter": '[filter "x"]\n\tsmudge = {0}\n\tclean = {0}\n\tprocess = {0}\n\trequired = true\n',
    "a text conversion": '[diff "x"]\n\ttextconv = {0}\n\tcommand = {0}\n[diff]\n\texternal = {0}\n',
    "an archiver": '[tar "tar"]\n\tcommand = {0}\n[tar "umask"]\n\tcommand = {0}\n',
    "a monitor": "[core]\n\tfsmonitor = {0}\n\tpager = {0}\n\teditor = {0}\n\tsshCommand = {0}\n\tgitProxy = {0}\n",
    "hooks": "[core]\n\thooksPath = hooks\n",
    "an alias": "[alias]\n\trev-parse = !{0}\n\tls-tree = !{0}\n\tcat-file = !{0}\n",
}
TOMLS = {
    "brackets within brackets": "x = " + "[" * 100_000,
    "tables within tables": "x = " + "{a=" * 3_000,
    "a key of 20,000 parts": ".".join("a" * 20_000) + " = 1",
    "a header of 20,000 parts": "[" + ".".join("a" * 20_000) + "]",
    "quoted parts": "x = {" + ".".join(['"a"'] * 5_000) + " = 1}",
    "an integer of 5,000 digits": "x = " + "9" * 5_000,
    "an integer of 400 digits": "accel_mm_s2 = " + "9" * 400,
    "a NUL in a path": 'robot = "a\\u0000b.toml"',
    "20,000 unknown keys": "\n".join(f"k{n} = 1" for n in range(19_000)),
    "20,000 unknown keys of a robot": "[axes]\n" + "\n".join(f"k{n} = 1" for n in range(19_000)),
    "3 MB": "# " + "x" * 3_000_000,
    "100,000 values": "x = [" + "1," * 100_000 + "]",
}
JSONS = {
    "deep": "[" * 60_000,
    "an integer of 400 digits": '{"a": ' + "9" * 400 + "}",
    "an integer of 5,000 digits": "9" * 5_000,
    "nothing that is finite": '{"a": NaN, "b": -Infinity, "c": 1e999}',
    "other things": '{"version": 1, "schema": "olp-signature", "findings": [{"fingerprint": 1, "count": 1e999}]}',
}
ABSURD = (
    "1e308", "-1e308", "1e-308", "1e200", "5e-324", "1.7976931348623157e308", "-0.0", "nan", "inf", "-inf",
    "9" * 400, "0x" + "f" * 40, "1e", "1..2", "-", "", "\u0661\u0662", "1_000", "1e-400", "4294967296",
)  # fmt: skip
HEADS = {
    "krl": ("DEF p()\nINT a\nx = ", "\nEND\n"),
    "rapid": ("MODULE m\nPROC main()\nx := ", ";\nENDPROC\nENDMODULE\n"),
    "tp": ("/PROG P\n/MN\n  1: R[1]=", " ;\n/END\n"),
    "urscript": ("def p():\n  x = ", "\nend\n"),
    "pdl2": ("PROGRAM p\nVAR x : INTEGER\nBEGIN\n  x := ", "\nEND p\n"),
    "val3": (
        '<?xml version="1.0"?>\n<Programs><Program name="p"><Code><![CDATA[begin\n  x=',
        "\nend]]></Code></Program></Programs>\n",
    ),
    "as": (".PROGRAM p()\n x = ", "\n.END\n"),
    "inform": (
        "/JOB\n//NAME P\n//INST\n///DATE 2020/01/01 00:00\n///ATTR SC,RW\nNOP\nSET B000 EXPRESS ",
        "\nEND\n",
    ),
}
NESTED: dict[str, Callable[[int], str]] = {
    "members": lambda n: ".".join("a" * n),
    "members without an end": lambda n: "a." * n,
    "parentheses": lambda n: "(" * n + "1" + ")" * n,
    "open parentheses": lambda n: "(" * n,
    "signs": lambda n: "-" * n + "1",
    "NOT": lambda n: "NOT " * n + "1",
    "sums": lambda n: "+".join("1" * n),
    "indices": lambda n: "a[" * n + "1" + "]" * n,
    "calls": lambda n: "f(" * n + "1" + ")" * n,
    "braces": lambda n: "{a " * n + "1" + "}" * n,
    "lists": lambda n: "[" * n + "1" + "]" * n,
    "products of frames": lambda n: ":".join("a" * n),
    "quotes": lambda n: '"' * n,
}
PROGRAMS = {
    "inform": JOB,
    "krl": SAMPLES / "krl" / "handling.src",
    "rapid": SAMPLES / "rapid" / "handling.mod",
    "tp": SAMPLES / "tp" / "handling.ls",
    "urscript": SAMPLES / "urscript" / "handling.script",
    "pdl2": SAMPLES / "pdl2" / "handling.pdl",
    "val3": SAMPLES / "val3" / "start.pgx",
    "as": SAMPLES / "as" / "handling.as",
}
NAMES = (
    b"\x83\x7d\x83b\x83N.JBI", b"-x.JBI", b"--help.JBI", b"=cmd.JBI", b"a\nb.JBI", b"\x1b[2J.JBI",
    "\u202egpj.JBI".encode(), b"a" * 251 + b".JBI", b" .JBI", b".JBI", b"[a].JBI", b"*.JBI", b"%s%n.JBI", b"{0}.JBI",
    b"$(id).JBI", b"CON.JBI", b"'\".JBI", b"\xff\xfe.JBI", b"a\\b.JBI", b"a\rb.JBI", b"]]>.JBI", b"<b>.JBI",
)  # fmt: skip
ESCAPES = (
    b"\x1b]0;owned\x07\x1b[2J",
    b"\xe2\x80\xae",
    b"\x9b2J",
    b"\x08\x08\x08",
    b"\x7f",
    b"\x1bP",
    b"\xc2\x9b2J",
)
ENDLESS = "with recursive n(i) as (select 1 union all select i + 1 from n)"


# --- Attacks ---


def any_program(dice: random.Random) -> Path:
    return PROGRAMS[dice.choice(list(PROGRAMS))]


def asked_of(dice: random.Random, file: str, count: int = 2) -> Iterator[Words]:
    """Some of what can be asked of a program or a folder of them."""
    to = dice.choice(list(PROGRAMS)[:5])
    yield from dice.sample(
        [
            ["time", file],
            ["time", file, "--format", dice.choice(["json", "csv", "markdown"])],
            ["lint", file, "--format", dice.choice(["text", "json", "sarif", "junit", "github"])],
            ["lint", file, "--load"],
            ["check", file, "--no-cache", "--format", dice.choice(["text", "json", "sarif", "gitlab"])],
            ["export", file, "--to", "inform", "-o", "exported"],
            ["convert", file, "--to", to, "-o", "converted", "--receipt", "receipt.json"],
            ["annotate", file, "-o", "annotated"],
            ["track", file, "--dt", "0.5", "-o", "track.csv"],
            ["report", file, "-o", "page.html"],
            ["diff", file, str(JOB)],
        ],
        count,
    )


def copied(path: Path, folder: Path) -> str:
    """A copy of a sample and of what lies beside it."""
    for other in path.parent.iterdir():
        if other.is_file():
            shutil.copy(other, folder)
    return path.name


def foreign_name(folder: Path, dice: random.Random) -> Iterator[Words]:
    raw = dice.choice(NAMES)
    if dice.random() < 0.3:
        raw = bytes(dice.choice(range(1, 256)) for _ in range(12)).replace(b"/", b"_") + b".JBI"
    copied(JOB, folder)
    shutil.copy(JOB, os.fsencode(folder) + b"/" + raw)
    yield from asked_of(dice, ".")
    yield from asked_of(dice, os.fsdecode(raw))
    yield from asked_of(dice, "./" + os.fsdecode(raw), 1)


def device(folder: Path, dice: random.Random) -> Iterator[Words]:
    """Something that is no plain file, where a program, a setting, a recording or an output is wanted."""
    copied(JOB, folder)
    name = dice.choice(["X.JBI", "olp.toml", "moves.csv", "s.json", "m.toml", "VAR.DAT", "TOOL.CND"])
    path = folder / name
    path.unlink(missing_ok=True)
    kind = dice.choice(
        ["pipe", "zero", "random", "full", "socket", "folder", "huge", "itself", "nowhere", "memory"]
    )
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "socket":
        with closing(socket.socket(socket.AF_UNIX)) as made, suppress(OSError):
            made.bind(str(path))
    elif kind == "folder":
        path.mkdir()
    elif kind == "huge":
        with path.open("wb") as file:
            file.truncate(dice.choice([120_000_000, 3_000_000_000, 1 << 40]))
    else:
        leads = {"itself": name, "nowhere": "no/where", "memory": "/proc/self/mem"}
        path.symlink_to(leads.get(kind, f"/dev/{kind}"))
    file = "X.JBI" if name == "X.JBI" else "PICK.JBI"
    yield from asked_of(dice, file)
    yield from asked_of(dice, ".", 1)
    yield ["time", "PICK.JBI", dice.choice(["--assumptions", "--signature", "--robot"]), name]
    yield ["convert", "PICK.JBI", "--to", "krl", "-o", "out", "--map", name]
    yield ["check", "PICK.JBI", dice.choice(["--budgets", "--cache", "--store"]), name]
    yield ["recording", "check", name if dice.random() < 0.5 else "."]
    yield ["calibrate", name]
    yield ["lint", "PICK.JBI", "--baseline", name]
    yield ["report", "PICK.JBI", "-o", dice.choice([name, "/dev/full"])]


def links(folder: Path, dice: random.Random) -> Iterator[Words]:
    copied(JOB, folder)
    kind = dice.choice(["loop", "chain", "out", "both"])
    if kind in ("loop", "both"):
        (folder / "down").symlink_to(folder)
        (folder / "A.JBI").symlink_to("B.JBI")
        (folder / "B.JBI").symlink_to("A.JBI")
    if kind in ("chain", "both"):
        for n in range(60):
            (folder / f"L{n}.JBI").symlink_to(f"L{n + 1}.JBI")
        shutil.copy(JOB, folder / "L60.JBI")
    if kind == "out":
        (folder / "P.JBI").symlink_to("/etc/passwd")
        (folder / "olp.toml").unlink()
        (folder / "olp.toml").symlink_to("olp.toml")
    yield from asked_of(dice, ".", 3)


def encoding(folder: Path, dice: random.Random) -> Iterator[Words]:
    """A program, settings or a recording in another encoding, or with bytes that belong to none."""
    path = any_program(dice)
    name = copied(path, folder)
    if dice.random() < 0.3:
        name = dice.choice(["olp.toml", "moves.csv"])
        text = (CELL / "olp.toml" if name == "olp.toml" else SAMPLES / "up20" / "moves.csv").read_bytes()[
            :3000
        ]
    else:
        text = path.read_bytes()
    how = dice.choice(
        ["utf-16", "utf-16-le", "utf-16-be", "utf-32", "utf-7", "cp037", "bytes", "ends", "marks", "cut"]
    )
    if how == "bytes":
        for _ in range(dice.choice([1, 5, 50])):
            at, put = (
                dice.randrange(len(text)),
                bytes([dice.choice([0, 26, 0x80, 0x83, 0x9F, 0xC3, 0xFF, 0x0B])]),
            )
            text = text[:at] + put + text[at:]
    elif how == "ends":
        ends = ["\r", "\n", "\r\n", "\x85", "\u2028", "\x0b", "\x0c", "\x1c"]
        text = "".join(row + dice.choice(ends) for row in text.decode("latin-1").splitlines()).encode()
    elif how == "marks":
        text = dice.choice([b"\xef\xbb\xbf" * 3, b"\xff\xfe", b"\xfe\xff", b"\xff\xfe\0\0"]) + text
    elif how == "cut":
        text = text.decode("latin-1").encode("utf-16")[: -dice.choice([1, 3, 5])]
    else:
        text = text.decode("latin-1").encode(how, "replace")
    (folder / name).write_bytes(text)
    if name == "moves.csv":
        yield from (["recording", "check", "."], ["calibrate", "."])
    else:
        yield from asked_of(dice, name if name != "olp.toml" else path.name, 3)


def number(folder: Path, dice: random.Random) -> Iterator[Words]:
    """Numbers that nobody writes, in a program, its settings, its controller's files, a robot or a recording."""
    path = any_program(dice)
    name = copied(path, folder)
    robot = ROOT / "olp" / "robots" / "yaskawa" / "ma2010.toml"
    shutil.copy(robot, folder / "robot.toml")
    (folder / "moves.csv").write_bytes(
        b"".join((SAMPLES / "up20" / "moves.csv").read_bytes().splitlines(True)[:25])
    )
    shutil.copy(SAMPLES / "up20" / "recording.toml", folder)
    victim = dice.choice(
        [name, name, "olp.toml", "robot.toml", "moves.csv", "recording.toml", "VAR.DAT", "TOOL.CND"]
    )
    if not (folder / victim).is_file():
        victim = name
    text = (folder / victim).read_bytes()
    for _ in range(dice.choice([1, 1, 3, 20])):
        found = list(_NUMBER.finditer(text))
        if found:
            at = dice.choice(found)
            text = text[: at.start()] + dice.choice(ABSURD).encode() + text[at.end() :]
    (folder / victim).write_bytes(text)
    if victim in ("moves.csv", "recording.toml"):
        yield from (["recording", "check", "."], ["calibrate", ".", "--method", "factors", "-o", "s.json"])
        yield ["diagnose", "."]
    else:
        robot_given = ["--robot", "robot.toml"] if victim == "robot.toml" else []
        yield ["time", name, *robot_given]
        yield from asked_of(dice, name, 2)


def nesting(folder: Path, dice: random.Random) -> Iterator[Words]:
    vendor = dice.choice(list(HEADS))
    before, after = HEADS[vendor]
    name = f"P{PROGRAMS[vendor].suffix}"
    text = before + NESTED[dice.choice(list(NESTED))](dice.choice([150, 500, 3_000, 20_000])) + after
    (folder / name).write_bytes(text.encode())
    yield from asked_of(dice, name)


def blocks(folder: Path, dice: random.Random) -> Iterator[Words]:
    """Blocks within blocks, routines that call one another without an end, loops that never end."""
    deep = dice.choice([60, 500, 5_000])
    many = {
        "p.src": ("DEF p()\n" + "IF TRUE THEN\n" * deep + "ENDIF\n" * deep + "END\n"),
        "q.src": "DEF q()\nq()\nEND\n",
        "r.src": "DEF r()\nLOOP\nWAIT SEC 0\nENDLOOP\nEND\n",
        "p.mod": "MODULE m\nPROC main()\n"
        + "IF TRUE THEN\n" * deep
        + "ENDIF\n" * deep
        + "ENDPROC\nENDMODULE\n",
        "q.mod": "MODULE m\nPROC main()\nmain;\nENDPROC\nENDMODULE\n",
        "p.script": "def p():\n"
        + "".join(" " * n + "if True:\n" for n in range(1, min(deep, 500)))
        + "end\n",
        "q.script": "def p():\n  q()\nend\ndef q():\n  p()\nend\np()\n",
        "P.JBI": HEADS["inform"][0].replace("SET B000 EXPRESS ", "IFTHEN B000=1\n" * deep) + "END\n",
        "Q.JBI": HEADS["inform"][0].replace("SET B000 EXPRESS ", "*A\nJUMP *A\n") + "END\n",
        "p.ls": "/PROG P\n/MN\n"
        + "".join(f"  {n}: FOR R[1]=1 TO 99999 ;\n" for n in range(1, deep))
        + "/END\n",
        "p.pgx": '<?xml version="1.0"?>' + "<Programs>" * deep,
        "p.urp": "<URProgram>" + "<children>" * deep,
    }
    name = dice.choice(list(many))
    (folder / name).write_text(many[name], encoding="utf-8")
    yield from asked_of(dice, name)


def settings(folder: Path, dice: random.Random) -> Iterator[Words]:
    """A hostile TOML file wherever one is read."""
    copied(JOB, folder)
    (folder / "moves.csv").write_text("move,duration_s\n1,1.0\n", encoding="utf-8")
    text = TOMLS[dice.choice(list(TOMLS))]
    if dice.random() < 0.3:
        good = dice.choice(
            [CELL / "olp.toml", ROOT / "olp" / "robots" / "yaskawa" / "ma2010.toml"]
        ).read_text()
        at = dice.randrange(len(good))
        text = (
            good[:at]
            + dice.choice(["[", "{", '"""', "''", "=", "\n[x]\n", "\0", "\ud7ff", "]", ","])
            + good[at:]
        )
    for name in ("olp.toml", "recording.toml"):
        (folder / name).write_text(text, encoding="utf-8")
    yield ["time", "PICK.JBI"]
    yield ["time", "PICK.JBI", "--robot", "olp.toml"]
    yield ["convert", "PICK.JBI", "--to", "krl", "-o", "out", "--map", "olp.toml"]
    yield ["check", ".", "--no-cache"]
    yield ["lint", "."]
    yield ["recording", "check", "."]


def documents(folder: Path, dice: random.Random) -> Iterator[Words]:
    """Hostile JSON as a signature, a baseline, an earlier report, or a program."""
    copied(JOB, folder)
    text = JSONS[dice.choice(list(JSONS))]
    page = f'<html><script type="application/json" id="summary">{text}</script>'
    for name, whole in (("s.json", text), ("X.JBI", text), ("page.html", page)):
        (folder / name).write_text(whole, encoding="utf-8")
    yield ["time", "PICK.JBI", "--signature", "s.json"]
    yield ["signature", "show", "s.json"]
    yield ["lint", "PICK.JBI", "--baseline", "s.json"]
    yield ["report", "PICK.JBI", "-o", "page.html"]
    yield ["time", "X.JBI"]


def bombs(folder: Path, dice: random.Random) -> Iterator[Words]:
    """A few bytes that unpack to many."""
    kind = dice.choice(["csv", "log", "urp", "entities", "entities in UTF-16", "lines", "cells"])
    lol = '<!DOCTYPE l [<!ENTITY a "aaaaaaaaaa">' + "".join(
        f'<!ENTITY {new} "{f"&{old};" * 10}">' for old, new in zip("abcdefghi", "bcdefghij", strict=True)
    )
    xml = f'<?xml version="1.0"{{}}?>{lol}]><URProgram name="&j;">&j;</URProgram>'
    if kind in ("csv", "log"):
        name = "moves.csv.gz" if kind == "csv" else "log.csv.gz"
        with gzip.open(folder / name, "wb", 1) as file:
            for _ in range(dice.choice([30, 700])):
                file.write(dice.choice([b"\0", b"1,", b"\n", b"9", b'"']) * 1_000_000)
        yield from (["recording", "check", "."], ["calibrate", "."], ["diagnose", "."])
        return
    if kind == "lines":
        (folder / "p.urp").write_bytes(b"\n" * 20_000_000)
    elif kind == "cells":
        (folder / "moves.csv").write_bytes(b"move,duration_s\n" + b"," * 2_000_000)
        yield ["recording", "check", "."]
        return
    elif kind == "urp":
        (folder / "p.urp").write_bytes(gzip.compress(b"<URProgram>" + b" " * 300_000_000, 1, mtime=0))
    else:
        sixteen = kind.endswith("16")
        data = xml.format(' encoding="UTF-16"' if sixteen else "").encode("utf-16" if sixteen else "utf-8")
        (folder / "p.urp").write_bytes(gzip.compress(data, mtime=0) if dice.random() < 0.5 else data)
        (folder / "p.pgx").write_bytes(data.replace(b"URProgram", b"Programs "))
        yield ["time", "p.pgx"]
    yield from asked_of(dice, "p.urp")


def cache_file(folder: Path, dice: random.Random) -> Iterator[Words]:
    """A cache or a store that somebody else has written."""
    copied(JOB, folder)
    (folder / "olp.toml").write_text("[[budget]]\nname = 'b'\nlimit_s = 0.01\n", encoding="utf-8")
    once = ["check", ".", "--cache", "cache", "--store", "store"]
    assert ran(once, folder).status in (1, 2)
    victim = dice.choice(["cache", "store"])
    table, column = ("result", "value") if victim == "cache" else ("program", "total_s")
    kind = dice.choice(["row", "bytes", "cut", "view", "trigger", "value", "wal", "huge"])
    path = folder / victim
    with suppress(sqlite3.Error), closing(sqlite3.connect(path)) as store:
        if kind == "view":
            columns = [row[1] for row in store.execute(f"pragma table_info({table})")]
            store.execute(f"drop table {table}")
            counted = ",".join("i" for _ in columns)
            store.execute(f"create view {table}({','.join(columns)}) as {ENDLESS} select {counted} from n")
        elif kind == "trigger":
            store.execute("create table x(i)")
            endless = "select a.i from x a, x b, x c, x d, x e, x f"
            store.execute(f"create trigger t after insert on {table} begin insert into x {endless}; end")
            store.executemany("insert into x values (?)", [(n,) for n in range(40)])
        elif kind == "value":
            odd = dice.choice([b"\xff\0", "[" * 100_000, 7, "x" * 9_000_000, "null", 1e308, -1])
            store.execute(f"update {table} set {column} = ?", (odd,))
        elif kind == "row" and victim == "cache":
            for name, text in store.execute("select path, value from result").fetchall():
                row = json.loads(text)
                for item in row["items"]:
                    item[dice.choice(list(item))] = dice.choice(
                        [None, -1, "held", 1e300, [], "\ud800", 10**400]
                    )
                row[dice.choice(list(row))] = dice.choice([None, -1, "x", [], {}, [["a\0"]]])
                store.execute("update result set value = ? where path = ?", (json.dumps(row), name))
        store.commit()
    data = bytearray(path.read_bytes())
    if kind == "bytes":
        for _ in range(30):
            data[dice.randrange(len(data))] = dice.randrange(256)
    elif kind == "cut":
        del data[dice.randrange(len(data)) :]
    if kind in ("bytes", "cut"):
        path.write_bytes(bytes(data))
    elif kind == "wal":
        (folder / f"{victim}-journal").write_bytes(bytes(dice.randrange(256) for _ in range(4096)))
        (folder / f"{victim}-wal").write_bytes(bytes(dice.randrange(256) for _ in range(4096)))
    yield once
    yield ["trend", "PICK", "--store", "store"]


def repository(folder: Path, dice: random.Random) -> Iterator[Words]:
    """A repository whose own configuration names programs, or whose objects, names and revisions are odd."""
    proof, program = folder / "proof", folder / "program"
    program.write_text(f"#!/bin/sh\necho ran >> '{proof}'\ncat\n", encoding="utf-8")
    program.chmod(0o755)
    home = folder / "cell"
    (home / "hooks").mkdir(parents=True)
    for hook in ("post-checkout", "post-index-change", "reference-transaction", "fsmonitor-watchman"):
        shutil.copy(program, home / "hooks" / hook)
    made_repository(home, CONFIGURATIONS[dice.choice(list(CONFIGURATIONS))].format(program))
    kind = dice.choice(["", "object", "head", "index", "gitfile", "bare"])
    git = home / ".git"
    if kind == "object":
        for path in dice.sample(sorted(git.glob("objects/??/*")), 3):
            path.chmod(0o644)
            path.write_bytes(dice.choice([b"", b"x\x9c", bytes(dice.randrange(256) for _ in range(200))]))
    elif kind == "head":
        (git / "HEAD").write_bytes(
            dice.choice([b"", b"ref: ../../x\n", b"\0" * 9, b"ref: refs/heads/" + b"a" * 9000])
        )
    elif kind == "index":
        (git / "index").write_bytes(bytes(dice.randrange(256) for _ in range(300)))
    elif kind == "gitfile":
        git.rename(home / "moved")
        git.write_bytes(
            dice.choice([b"gitdir: moved\n", b"gitdir: .git\n", b"gitdir: /proc/self/fd\n", b"\xff"])
        )
    odd = dice.choice(
        ["HEAD", "--output=proof", "-h", "--upload-pack=program", "HEAD:../..", "@{-1}", ":/x", "\x1b"]
    )
    for words in (
        ["diff", "HEAD~1", "HEAD"],
        ["diff", "HEAD~1", odd],
        ["check", "."],
        ["diff", odd, "PICK.JBI"],
    ):
        yield ["-C", "cell", *words]
    if proof.exists():
        raise AssertionError("a program that the repository names was run")


def made_repository(folder: Path, config: str = "", attributes: str = "*.JBI filter=x diff=x text\n") -> Path:
    """Two commits of one job; afterwards the repository's own configuration becomes hostile."""

    def git(*words: str) -> None:
        who = ("-c", "user.name=a", "-c", "user.email=a@b.example", "-c", "core.autocrlf=false")
        subprocess.run(["git", *who, *words], cwd=folder, check=True, capture_output=True)

    git("init", "-q", "-b", "main")
    (folder / ".gitattributes").write_text(attributes, encoding="utf-8")
    text = JOB.read_bytes()
    for name in ("VAR.DAT", "TOOL.CND", "UFRAME.CND", "olp.toml"):
        shutil.copy(JOB.with_name(name), folder)
    (folder / "PICK.JBI").write_bytes(text)
    git("add", "-A")
    git("commit", "-qm", "one")
    (folder / "PICK.JBI").write_bytes(text.replace(b"V=", b"V=1"))
    git("add", "-A")
    git("commit", "-qm", "two")
    with (folder / ".git" / "config").open("a", encoding="utf-8") as file:
        file.write(config)
    return folder


def escapes(folder: Path, dice: random.Random) -> Iterator[Words]:
    """Controls in a program, its settings and its name, told to a terminal."""
    path = any_program(dice)
    name = copied(path, folder)
    text = path.read_bytes()
    for _ in range(dice.choice([1, 3, 20])):
        at = dice.randrange(len(text))
        text = text[:at] + dice.choice(ESCAPES) + text[at:]
    name = f"a\x1b[31m{name}" if dice.random() < 0.5 else name
    (folder / name).write_bytes(text)
    if dice.random() < 0.3:
        (folder / "olp.toml").write_bytes(
            b'[motion]\n"' + rb"\u001b[2J" + b'" = 1\nrobot = "' + rb"\u009b2J" + b'"\n'
        )
    for words in asked_of(dice, name, 3):
        yield ["--terminal", *words]


def clocks(folder: Path, dice: random.Random) -> Iterator[Words]:
    """Dates of files before time began and after it ends, and a clock that goes back while olp runs."""
    copied(JOB, folder)
    for path in folder.iterdir():
        with suppress(OSError, OverflowError):
            os.utime(path, (0, dice.choice([0, -1, -(2**31), 2**33, 2**40, 1e9])))
    commands = [
        ["check", ".", "--cache", "cache", "--store", "store"],
        ["report", ".", "-o", "page.html"],
        ["check", ".", "--cache", "cache", "--store", "store"],
        ["report", ".", "-o", "page.html"],
        ["trend", "PICK", "--store", "store"],
        ["convert", "PICK.JBI", "--to", "inform", "-o", "out"],
    ]
    for words in commands:
        yield ["--clock", str(dice.choice([0, -(2**40), 1e9, 2**33, 2**50])), *words]


def damage(folder: Path, dice: random.Random) -> Iterator[Words]:
    """A program of which bytes are lost, doubled or moved."""
    path = any_program(dice)
    name = copied(path, folder)
    raw = path.read_bytes()
    for _ in range(dice.choice([1, 2, 8])):
        at, to = sorted((dice.randrange(len(raw) + 1), dice.randrange(len(raw) + 1)))
        twice = raw[:to] + raw[at:to] * dice.choice([1, 30]) + raw[to:]
        raw = dice.choice([raw[:at] + raw[to:], twice, raw[:to], raw[to:] + raw[:to]])[:300_000] or b"\0"
    (folder / name).write_bytes(raw)
    yield from asked_of(dice, name, 3)


def formulas(folder: Path, dice: random.Random) -> Iterator[Words]:
    """Names that a spreadsheet would compute."""
    name = dice.choice(["=A.JBI", "@A.JBI", "+A.JBI", "-1+1.JBI", "'=A.JBI", "=a,b.JBI", "=1\n2.JBI"])
    copied(JOB, folder)
    shutil.copy(JOB, folder / name)
    yield ["time", f"./{name}" if name.startswith("-") else name, "--format", "csv", "-o", "a.csv"]
    yield ["time", ".", "--format", "csv", "-o", "b.csv"]
    yield ["track", f"./{name}", "--dt", "1", "-o", "c.csv"]


GROUPS: Mapping[str, Attack] = {
    "names": foreign_name,
    "devices": device,
    "links": links,
    "encodings": encoding,
    "numbers": number,
    "nesting": nesting,
    "blocks": blocks,
    "settings": settings,
    "documents": documents,
    "bombs": bombs,
    "caches": cache_file,
    "git": repository,
    "escapes": escapes,
    "clocks": clocks,
    "damage": damage,
    "formulas": formulas,
}


# --- Running ---


class Ran(NamedTuple):
    """What one command did. `cpu_s` and `mb`: of its process; `idle_s`: how long it neither ran nor wanted to."""

    words: tuple[str, ...]
    status: int
    said: str
    told: str
    cpu_s: float
    mb: float
    idle_s: float = 0.0

    @property
    def fault(self) -> str:
        """What was not held, "" where all was."""
        if self.status not in (0, 1, 2):
            return f"status {self.status}"
        if "Traceback (most recent call last)" in self.said + self.told or "Exception ignored" in self.told:
            return f"traceback: {self.told.strip().splitlines()[-1][:120]}"
        if self.status == 2 and not _CODE.search(self.told + self.said) and "unknown" not in self.said:
            return "no answer, and no code that says why"
        if self.cpu_s > LIMIT_S:
            return f"{self.cpu_s:.1f} s"
        if self.idle_s > LIMIT_S:
            return f"waits {self.idle_s:.1f} s"
        return f"{self.mb:.0f} MB" if self.mb > LIMIT_MB else ""


def ran(words: Sequence[str], folder: Path, *, anew: bool = False) -> Ran:
    """Runs a command line in a process of its own that begins where olp's imports end, or `anew` in another Python.

    Words of ours come first: `-C FOLDER`, `--terminal` for a pseudo-terminal as output, `--clock S` for a clock that
    goes back from there.
    """
    words, place, clock, terminal = list(words), folder, None, False
    while words and words[0] in ("-C", "--terminal", "--clock"):
        word = words.pop(0)
        if word == "-C":
            place = folder / words.pop(0)
        elif word == "--clock":
            clock = float(words.pop(0))
        else:
            terminal = True
    ready()
    with tempfile.TemporaryFile() as said, tempfile.TemporaryFile() as told:
        ours, theirs = os.openpty() if terminal else (-1, -1)
        sys.stdout.flush()
        sys.stderr.flush()
        child = os.fork()
        if not child:
            os.dup2(theirs if terminal else said.fileno(), 1)
            os.dup2(theirs if terminal else told.fileno(), 2)
            if anew and clock is None:
                new_python(words, place)
            as_olp(words, place, clock)
        began = time.monotonic()
        if terminal:
            os.close(theirs)
            drained(ours, said)
        idle = idled(child, began)
        status, cpu, mb = waited(child)
        said.seek(0)
        told.seek(0)
        texts = [file.read().decode("utf-8", "backslashreplace") for file in (said, told)]
    if terminal and (left := _STEERS.search(re.sub(r"\x1b\[(?:0|1|2|31|33)m", "", texts[0]))):
        texts[1] += f"\nTraceback (most recent call last)\n{left[0]!r} reached the terminal"
    return Ran(tuple(words), status, *texts, cpu, mb, idle)


_STEERS = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\x80-\x9f\u202a-\u202e]")


@cache
def ready() -> None:
    """Imports what commands import, once for all of them."""
    sys.path.insert(0, str(ROOT))
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    import pandas  # noqa: F401

    import olp.__main__
    import olp.checks.guard.run
    import olp.fluent
    import olp.transpile.convert
    from olp.contracts.vendors import check_vendor  # noqa: F401

    for name in PROGRAMS.values():
        olp.fluent.read(name).plan().time()


def new_python(words: Words, place: Path) -> None:
    """Becomes `python -m olp WORDS`."""
    resource.setrlimit(resource.RLIMIT_CPU, (int(_GIVEN_UP_S), int(_GIVEN_UP_S)))
    os.chdir(place)
    known = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUTF8": "1"}
    os.execve(sys.executable, [sys.executable, "-m", "olp", *words], known)


def as_olp(words: Words, place: Path, clock: float | None) -> None:
    """Becomes `olp WORDS`, and ends."""
    status = 1
    try:
        resource.setrlimit(resource.RLIMIT_CPU, (int(_GIVEN_UP_S), int(_GIVEN_UP_S)))
        signal.alarm(int(4 * _GIVEN_UP_S))
        os.chdir(place)
        sys.stdout, sys.stderr = (
            io.TextIOWrapper(os.fdopen(one, "wb", closefd=False), encoding="utf-8") for one in (1, 2)
        )
        if clock is not None:
            ticks = iter(range(1 << 30))
            time.time = lambda: clock - next(ticks)
            time.monotonic = time.time
        from olp.__main__ import main

        status = main(words)
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else 1
    except BaseException:
        traceback.print_exc()
        status = 3
    finally:
        with suppress(Exception):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(status)


def drained(terminal: int, into: object) -> None:
    with suppress(OSError):  # how Linux tells the end of a pseudo-terminal
        while chunk := os.read(terminal, 65_536):
            into.write(chunk)  # type: ignore[attr-defined]
    os.close(terminal)


def idled(child: int, began: float) -> float:
    """Waits for a process: how long [s] it neither ran nor wanted to, 0 where others worked for it."""
    os.waitid(os.P_PID, child, os.WEXITED | os.WNOWAIT)
    lasted = time.monotonic() - began
    try:
        ran_ns, queued_ns, _ = map(int, Path(f"/proc/{child}/schedstat").read_text(encoding="ascii").split())
        times = (
            Path(f"/proc/{child}/stat")
            .read_text(encoding="ascii", errors="replace")
            .rpartition(")")[2]
            .split()
        )
    except (OSError, ValueError):  # not Linux, or without these figures
        return 0.0
    works = int(times[13]) + int(times[14])  # what others that it started have used, in ticks
    return 0.0 if works else lasted - (ran_ns + queued_ns) / 1e9


def waited(child: int) -> tuple[int, float, float]:
    """Status (minus the signal that ended it), CPU time [s] and most memory [MB] of a process."""
    _, status, used = os.wait4(child, 0)
    return os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def attacked(group: str, seed: int) -> list[Ran]:
    """One variant of an attack: what each of its commands did."""
    dice = random.Random(f"{group}/{seed}")
    done = []
    with tempfile.TemporaryDirectory(prefix="olp-hostile-") as temporary:
        folder = Path(temporary)
        try:
            for words in GROUPS[group](folder, dice):
                done.append(ran(words, folder, anew=seed % _ANEW == _ANEW - 1))
        except AssertionError as problem:
            done.append(Ran((), 3, "", str(problem), 0.0, 0.0))
    return done


def attack_all(groups: Sequence[str], variants: int) -> int:
    """Runs so many variants, in turn of every group, and prints the table."""
    head = (
        f"{'attack':12} {'variants':>8} {'commands':>8} {'status 0, 1, 2':>17} {'most s':>7} {'most MB':>8}"
    )
    print(f"{head} {'not held':>9}")
    whole: list[Ran] = []
    for index, group in enumerate(groups):
        seeds = range(variants // len(groups) + (index < variants % len(groups)))
        rows = [(seed, one) for seed in seeds for one in attacked(group, seed)]
        bad = [(seed, one) for seed, one in rows if one.fault]
        whole += [one for _, one in rows]
        print_row(group, len(seeds), [one for _, one in rows])
        for seed, one in bad:
            print(visible(f"    {group}/{seed}: {' '.join(one.words)[:90]}: {one.fault}"), flush=True)
    print_row("all", variants, whole)
    return int(any(one.fault for one in whole))


def visible(text: str) -> str:
    from olp.core.diagnostic import visible as shown

    return shown(text)


def print_row(name: str, variants: int, rows: Sequence[Ran]) -> None:
    counts = [sum(one.status == status for one in rows) for status in (0, 1, 2)]
    seconds, mb = max(one.cpu_s for one in rows), max(one.mb for one in rows)
    told = ", ".join(map(str, counts))
    bad = sum(bool(one.fault) for one in rows)
    print(f"{name:12} {variants:8} {len(rows):8} {told:>17} {seconds:7.2f} {mb:8.0f} {bad:9}", flush=True)


def show(which: str) -> int:
    group, seed = which.split("/")
    for one in attacked(group, int(seed)):
        print(
            f"\n$ olp {visible(' '.join(one.words))}\n{visible(one.said)[-1500:]}{visible(one.told)[-3000:]}"
        )
        print(f"status {one.status}, {one.cpu_s:.2f} s, {one.mb:.0f} MB: {one.fault or 'held'}")
    return 0


# --- Ways to start it ---

_WAYS: Mapping[str, tuple[tuple[str, ...], dict[str, str]]] = {
    "locale C": ((), {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}),
    "ASCII": (
        (),
        {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONIOENCODING": "ascii", "PYTHONCOERCECLOCALE": "0"},
    ),
    "-O": (("-O",), {}),
    "-OO": (("-OO",), {}),
    "-W error": (("-W", "error"), {}),
    "hash seed": ((), {"PYTHONHASHSEED": "12345"}),
    "far east": ((), {"TZ": "Asia/Tokyo"}),
}


def ways(pythons: Sequence[str]) -> int:
    """Whether olp says the same however Python is started, and under other Pythons."""
    others = {Path(python).name if "/" not in python else python: python for python in pythons}
    with tempfile.TemporaryDirectory(prefix="olp-ways-") as temporary:
        folder = Path(temporary) / "zelle-\u00e4"
        folder.mkdir()
        copied(JOB, folder)
        for path in PROGRAMS.values():
            shutil.copy(path, folder)
        text = JOB.read_bytes().replace(b"\r\nNOP\r\n", b"\r\nNOP\r\n'\x83\x7d\x83b\r\n")
        (folder / "B\u00fcgel.JBI").write_bytes(text)
        shutil.copytree(SAMPLES / "up20", folder / "up20")
        usual = {" ".join(words): started([sys.executable], {}, words, folder) for words in _ASKED}
        bad = 0
        for name, (options, environment) in _WAYS.items():
            bad += print_way(name, [sys.executable, *options], environment, folder, usual)
        for name, python in others.items():
            bad += print_way(name, [python], {}, folder, usual)
    for version in ("3.11", "3.12", "3.13", "3.14"):
        if not any(version in asked_version(python) for python in (sys.executable, *pythons)):
            print(f"Python {version}: not asked; name it with --python")
    return int(bad > 0)


_FOREIGN = re.compile(rb"(?:[^\x00-\x7f]|\?|\\+(?:u[0-9a-f]{4}|x[0-9a-f]{2}))+")
_ASKED: tuple[Words, ...] = (
    ["time", ".", "--format", "json"],
    ["lint", ".", "--format", "json"],
    ["check", ".", "--no-cache", "--format", "json"],
    ["time", "PICK.JBI"],
    ["time", "B\u00fcgel.JBI", "--format", "csv"],
    ["convert", "PICK.JBI", "--to", "krl", "-o", "out", "--force"],
    ["export", "handling.src", "--to", "krl"],
    ["recording", "check", "up20"],
    ["calibrate", "up20", "--method", "factors"],
    ["diff", "PICK.JBI", "PLACE.JBI"],
    ["robots"],
    ["--help"],
)


def started(
    python: Words, environment: dict[str, str], words: Words, folder: Path
) -> tuple[int, bytes, bytes]:
    known = {
        **os.environ,
        "PYTHONPATH": str(ROOT),
        "OPENBLAS_NUM_THREADS": "1",
        "PYTHONUTF8": "1",
        **environment,
    }
    done = subprocess.run(
        [*python, "-m", "olp", *words], cwd=folder, env=known, capture_output=True, timeout=120, check=False
    )
    return done.returncode, done.stdout, done.stderr


def print_way(
    name: str,
    python: Words,
    environment: dict[str, str],
    folder: Path,
    usual: Mapping[str, tuple[int, bytes, bytes]],
) -> int:
    bad = 0
    for words in _ASKED:
        wanted, found = usual[" ".join(words)], started(python, environment, words, folder)
        # Where the terminal has no such letters, others stand for them.
        same = [_FOREIGN.sub(b"?", out) for out in (wanted[1], found[1])]
        if found[0] != wanted[0] or same[0] != same[1] or b"Traceback" in found[2]:
            bad += 1
            last = found[2].decode("utf-8", "replace").strip().splitlines()[-1:]
            print(f"    olp {' '.join(words)}: status {found[0]}, not {wanted[0]}, or another answer {last}")
    print(f"{name:24} {len(_ASKED)} commands, {bad} with another answer", flush=True)
    return bad


@cache
def asked_version(python: str) -> str:
    return subprocess.run([python, "-V"], capture_output=True, text=True, check=False).stdout


# --- Killed and started again ---

_DATE = re.compile(rb"\d{4}[-/]\d\d[-/]\d\d \d\d:\d\d")


class Killable(NamedTuple):
    """A command line, and the files or folders that it writes."""

    words: Words
    outputs: tuple[str, ...]


KILLABLE: Mapping[str, Killable] = {
    "check": Killable(
        ["check", "cell", "--cache", "cache", "--also", "json=out.json", "--also", "sarif=out.sarif"],
        ("out.json", "out.sarif"),
    ),
    "calibrate": Killable(["calibrate", "moves", "--method", "factors", "-o", "s.json"], ("s.json",)),
    "diagnose": Killable(["diagnose", "moves", "--json", "d.json", "--html", "d.html"], ("d.json", "d.html")),
    "convert": Killable(
        ["convert", "moves", "--to", "krl", "-o", "out", "--force", "--receipt", "r.json"], ("out", "r.json")
    ),
    "report": Killable(["report", "cell", "-o", "page.html"], ("page.html",)),
    "fit": Killable(
        ["fit", "cell/PICK.JBI", "--to", "3.15", "-o", "F.JBI", "--front", "f.json"], ("F.JBI", "f.json")
    ),
    "merge": Killable(["merge", "cell/PICK.JBI", "ours.JBI", "theirs.JBI", "-o", "M.JBI"], ("M.JBI",)),
}


def kill_all(names: Sequence[str], moments: int) -> int:
    """Kills commands at random moments, half of them while they end, and starts them again."""
    from olp.cli import names as commands

    head = f"{'command':12} {'moments':>8} {'killed':>7} {'with outputs':>13} {'left hidden':>12}"
    print(f"{head} {'half':>5} {'run anew':>8} {'other bytes':>12}", flush=True)
    bad = 0
    for name in names:
        if name not in commands():
            print(f"{name:12} there is no such command")
            continue
        bad += killed(name, moments)
    return int(bad > 0)


def killed(name: str, moments: int) -> int:
    dice, killable = random.Random(name), KILLABLE[name]
    with tempfile.TemporaryDirectory(prefix="olp-killed-") as temporary:
        folder = Path(temporary)
        prepare(folder / "usual")
        ready()
        began = time.monotonic()
        first = ran(killable.words, folder / "usual")
        lasts = time.monotonic() - began
        whole = written(folder / "usual", killable)
        ran(killable.words, folder / "usual")
        twice = written(folder / "usual", killable)  # a report shows what has changed since the last one
        if first.status not in (0, 1) or not whole:
            print(f"{name:12} cannot be run: status {first.status}: {first.told[-300:]}")
            return 1
        died = partly = hidden = half = started_again = other = 0
        for moment in range(moments):
            home = folder / f"m{moment}"
            prepare(home)
            before = all_of(home)
            share = dice.uniform(0.0, 1.02) if moment % 2 else dice.uniform(0.85, 1.02)
            died += interrupted(killable.words, home, share * lasts)
            found = written(home, killable)
            partly += bool(found)
            hidden += sum(".part" in path.name for path in home.rglob("*"))
            half += any(whole.get(key) != data for key, data in found.items())
            if all_of(home) == before:  # nothing is left: started again it is the first run
                shutil.rmtree(home)
                continue
            again = ran(killable.words, home)
            started_again += 1
            other += again.status != first.status or written(home, killable) not in (whole, twice)
            shutil.rmtree(home)
    row = f"{name:12} {moments:8} {died:7} {partly:13} {hidden:12} {half:5} {started_again:8} {other:12}"
    print(row, flush=True)
    return half + other


def all_of(folder: Path) -> dict[str, bytes]:
    """Every file below a folder, with its bytes."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def prepare(folder: Path) -> None:
    """What the commands that are killed read."""
    shutil.copytree(CELL, folder / "cell")
    (folder / "cell" / "README.md").unlink()
    (folder / "moves").mkdir()
    rows = (SAMPLES / "up20" / "moves.csv").read_bytes().splitlines(keepends=True)[:41]
    (folder / "moves" / "moves.csv").write_bytes(b"".join(rows))
    shutil.copy(SAMPLES / "up20" / "recording.toml", folder / "moves")
    for path in (SAMPLES / "up20").glob("*.JBI"):
        shutil.copy(path, folder / "moves")
    text = JOB.read_bytes()
    (folder / "ours.JBI").write_bytes(text.replace(b"V=120.0", b"V=110.0"))
    (folder / "theirs.JBI").write_bytes(text.replace(b"T=0.", b"T=1."))


def interrupted(words: Words, folder: Path, after: float) -> bool:
    """Kills a command after so many seconds; whether it was still there."""
    ready()
    sys.stdout.flush()
    child = os.fork()
    if not child:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        as_olp(list(words), folder, None)
    time.sleep(after)
    with suppress(ProcessLookupError):
        os.kill(child, signal.SIGKILL)
    return waited(child)[0] == -signal.SIGKILL


def written(folder: Path, killable: Killable) -> dict[str, bytes]:
    """The outputs that are there, but for dates."""
    found = {}
    for name in killable.outputs:
        path = folder / name
        files = [path] if path.is_file() else sorted(path.rglob("*"))
        for file in files:
            if file.is_file() and ".part" not in file.name:
                data = _DATE.sub(b"DATE", file.read_bytes())
                found[str(file.relative_to(folder))] = data.replace(str(folder).encode(), b"HERE")
    return found


# --- Many jobs ---


def check_many(count: int, moves: int) -> int:
    """A check of many jobs, of which one of a hundred is replaced by something hostile, against one before."""
    from bench.check import write_jobs

    dice = random.Random(19)
    with tempfile.TemporaryDirectory(prefix="olp-many-") as temporary:
        folder = Path(temporary)
        write_jobs(folder, count, moves)
        seconds, mb, status, clean = checked(folder)
        print(
            f"{count} jobs: {seconds:.1f} s, {mb:.0f} MB, status {status}, {len(clean)} verdicts", flush=True
        )
        victims = dice.sample(sorted(folder.rglob("*.JBI")), count // 100)
        kinds = {str(path.relative_to(folder)): spoil(path, dice) for path in victims}
        seconds, mb, status, mixed = checked(folder)
        print(
            f"{len(victims)} of them hostile: {seconds:.1f} s, {mb:.0f} MB, status {status}, {len(mixed)} verdicts"
        )
        others = [name for name, told in clean.items() if name not in kinds and mixed.get(name) != told]
        silent = [
            f"{kind}: {name}" for name, kind in kinds.items() if mixed.get(name, ("held",))[0] != "unknown"
        ]
        slow = [
            (alone(folder / name), kind)
            for kind, name in {kind: name for name, kind in kinds.items()}.items()
        ]
    print(f"other verdicts than without them: {len(others)}")
    print(f"hostile jobs that no verdict names as unknown: {len(silent)}", *silent[:10], sep="\n    ")
    print(f"slowest of the hostile alone: {max(slow)[0]:.2f} s CPU ({max(slow)[1]})")
    return int(bool(others or silent) or mb > LIMIT_MB or max(slow)[0] > LIMIT_S)


def checked(folder: Path) -> tuple[float, float, int, dict[str, tuple[str, str]]]:
    """Seconds, most MB of one process, status, and the verdict of each job."""
    words = [
        sys.executable,
        "-m",
        "olp",
        "check",
        str(folder),
        "--no-cache",
        "--format",
        "json",
        "--workers",
        "2",
    ]
    began = time.monotonic()
    with tempfile.TemporaryFile() as said:
        process = subprocess.Popen(words, stdout=said, stderr=subprocess.DEVNULL, cwd=ROOT)
        status, _, mb = waited(process.pid)
        said.seek(0)
        told = json.load(said)
    items = [item for item in told["items"] if item["file"]]
    verdicts = {os.path.relpath(item["file"], folder): (item["status"], item["message"]) for item in items}
    return time.monotonic() - began, mb, status, verdicts


def alone(path: Path) -> float:
    return ran(["check", str(path), "--no-cache"], path.parent).cpu_s


def spoil(path: Path, dice: random.Random) -> str:
    """Puts something hostile in the place of a job."""
    kinds = (
        "pipe",
        "zero",
        "itself",
        "huge",
        "binary",
        "deep",
        "folder of bytes",
        "empty",
        "UTF-32",
        "other",
        "loop",
    )
    kind = dice.choice(kinds)
    raw = path.read_bytes()
    path.unlink()
    if kind == "pipe":
        os.mkfifo(path)
    elif kind in ("zero", "itself"):
        path.symlink_to("/dev/zero" if kind == "zero" else path.name)
    elif kind == "huge":
        with path.open("wb") as file:
            file.truncate(3_000_000_000)
    elif kind == "deep":
        path.write_bytes(raw.replace(b"NOP\r\n", b"NOP\r\nSET B000 EXPRESS " + b"(" * 20_000 + b"\r\n"))
    elif kind == "loop":
        path.write_bytes(raw.replace(b"NOP\r\n", b"NOP\r\n*A\r\nDOUT OT#(1) ON\r\nJUMP *A\r\n"))
    else:
        texts = {
            "binary": bytes(dice.randrange(256) for _ in range(20_000)),
            "folder of bytes": b"\0" * 1_000_000,
            "empty": b"",
            "UTF-32": raw.decode("latin-1").encode("utf-32"),
            "other": b"%PDF-1.4\n" + raw,
        }
        path.write_bytes(texts[kind])
    return kind


# --- Command line ---


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--variants", type=int, default=1_000 + len(GROUPS), metavar="N")
    parser.add_argument(
        "--only", action="append", metavar="NAME", help="of the attacks, or of the commands to kill"
    )
    parser.add_argument("--show", metavar="GROUP/SEED")
    parser.add_argument("--ways", action="store_true")
    parser.add_argument(
        "--python", action="append", default=[], metavar="PYTHON", help="another one, with --ways"
    )
    parser.add_argument("--killed", type=int, metavar="N")
    parser.add_argument("--many", type=int, metavar="N")
    parser.add_argument("--moves", type=int, default=8, help="of each of the many jobs")
    args = parser.parse_args(arguments)
    if args.show:
        return show(args.show)
    if args.ways:
        return ways(args.python)
    if args.killed:
        return kill_all(args.only or list(KILLABLE), args.killed)
    if args.many:
        return check_many(args.many, args.moves)
    return attack_all(args.only or list(GROUPS), args.variants)


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    sys.exit(main(sys.argv[1:]))
