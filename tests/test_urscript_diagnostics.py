"""What is wrong with a script is told with its place, all at once, and nothing breaks the reader."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from cpu_time import cpu_time_below

from olp.core.diagnostic import Diagnostic
from olp.core.source import decode
from olp.fluent import read_source
from olp.ir.program import LineKind, Program

SAMPLES = Path(__file__).resolve().parent.parent / "samples" / "urscript"


def read(text: str | bytes) -> Program:
    raw = text.encode() if isinstance(text, str) else text
    return read_source(decode(raw, "a.script"), vendor="urscript")


def told(*lines: str) -> Diagnostic:
    """The one finding about these lines within a program."""
    program = read("\n".join(["def prog():", *(f"  {line}" for line in lines), "end", ""]))
    (found,) = program.diagnostics
    return found


@pytest.mark.parametrize(
    ("lines", "code", "says", "place"),
    [
        (["x = (1 +"], "P550", "the line ends too early", (2, 11)),
        (["x = 1 2"], "P550", "'2' does not fit here", (2, 9)),
        (["if x: y = 1 else: y = 1 2", "end"], "P550", "'2' does not fit here", (2, 27)),
        (["movej(q, a=)"], "P550", "')' does not fit here", (2, 14)),
        (['textmsg("open)'], "P550", "a text that is not closed", (2, 11)),
        (["x = foo(1,", "    2 3)"], "P550", "'3' does not fit here", (3, 9)),
        (["if x = 1:", "end"], "P550", "'=' does not fit here", (2, 8)),
        (["for i in range(3):"], "P550", "'i' does not fit here", (2, 7)),
        (["x = " + "(" * 500 + "1" + ")" * 500], "P553", "beyond what any controller takes", (2, 3)),
        (["x = 1" + " + 1" * 500], "P553", "beyond what any controller takes", (2, 3)),
        (["x = " + "9" * 30], "P553", "beyond what any controller takes", (2, 3)),
        (["elsewhere(1)"], "P555", "elsewhere is not defined in this file", (2, 3)),
        (["x = {{VALUE}}"], "P556", "a placeholder of a template", (2, 3)),
        (["def f():", "end", "def f():", "end"], "P557", "a second function f", (4, 3)),
        (["movel(p[1,0,0,0,0,0], speed=2)"], "P558", "movel takes no argument speed", (2, 3)),
        (["movej([0,0,0,0,0,0], 1, 2, 0, 0, 7)"], "P558", "movej takes 6 arguments", (2, 3)),
        (["movel(p[1,0,0,0,0,0], 1, a=2)"], "P558", "movel is given a twice", (2, 3)),
        (["movej()"], "P558", "movej has no target", (2, 3)),
        (["movec(p[1,0,0,0,0,0])"], "P558", "movec has no target", (2, 3)),
        (["sleep()"], "P558", "sleep takes one argument, not 0", (2, 3)),
        (["set_digital_out(1)"], "P558", "set_digital_out takes two arguments, not 1", (2, 3)),
        (["set_tcp()"], "P558", "set_tcp has no pose", (2, 3)),
        (["f(1) = 2"], "P558", "this cannot be assigned to", (2, 3)),
        (["movel(p[1, 2, 3, 4, 5])"], "P559", "a pose has six numbers, this one 5", (2, 3)),
        (["speedl([0,0,0.1,0,0,0], 0.5, 1)"], "P560", "speedl moves as sensors or other threads say", (2, 3)),
        (["movel(x, v=0.2, t=y)"], "P561", "movel with a time that is computed", (2, 3)),
        (["break"], "P565", "break outside of a loop", (2, 3)),
        (["if x:", "continue", "end"], "P565", "continue outside of a loop", (3, 3)),
        (["x"], "P566", "a value that nothing is done with", (2, 3)),
        (["movel(p[1,0,0,0,0,0], v=250)"], "P568", "movel with 250 m/s", (2, 3)),
    ],
)
def test_each_mistake_has_its_code_and_its_place(
    lines: list[str], code: str, says: str, place: tuple[int, int]
) -> None:
    found = told(*lines)
    assert found.code == code
    assert says in found.message
    assert (found.line, found.column) == place
    assert found.help


@pytest.mark.parametrize(
    ("text", "code", "line"),
    [
        ("def a():\n  if x:\n    sync()\n  end\n", "P551", 1),
        ("def a():\n  sync()\nend\nend\n", "P552", 4),
        ("def a():\n  else:\n  sync()\nend\n", "P552", 2),
        ("def a():\n  while x:\n  elif y:\n  end\nend\n", "P552", 3),
        ("def a():\n  if x:\n  else:\n    if y:\n    else:\n    end\n  elif z:\n  end\nend\n", "P552", 7),
        ("", "P564", 0),
        ("\n \n", "P564", 0),
        ("\x00binary", "P001", 0),
    ],
)
def test_blocks_and_files_that_are_not_whole(text: str, code: str, line: int) -> None:
    (found,) = read(text).diagnostics
    assert (found.code, found.line) == (code, line)


def test_a_broken_head_still_opens_its_block() -> None:
    program = read("def a(:\n  if x ==:\n    sync()\n  else\n    sync()\n  end\n  while (:\n  end\nend\n")
    assert {d.code for d in program.diagnostics} == {"P550"}
    assert [d.line for d in program.diagnostics] == [1, 2, 4, 7]


def test_words_of_other_languages_are_named() -> None:
    assert "count with while" in told("for i in range(3):").help
    assert "write and" in told("x = a && b").help


def test_all_mistakes_are_told_at_once_and_mark_their_lines() -> None:
    program = read("def a():\n  x = = 1\n  sync()\n  movej()\n  y = )\nend\n")
    assert [d.line for d in program.diagnostics] == [2, 4, 5]
    assert [n for n, kind in enumerate(program.line_kinds, 1) if kind == LineKind.ERROR] == [2, 4, 5]


def test_thousands_of_broken_lines_are_counted_and_not_examined() -> None:
    program = read("".join(f"x{n} = )\n" for n in range(6000)))
    codes = [d.code for d in program.diagnostics]
    assert codes.count("P550") == 2000
    assert codes.count("P554") == 1
    assert "more lines" in program.diagnostics[-1].message


def test_unknown_functions_are_told_once_each() -> None:
    program = read("def a():\n" + "  far()\n" * 40 + "end\n")
    (found,) = program.diagnostics
    assert "(and in 39 more lines)" in found.message


@pytest.mark.parametrize(
    "text",
    [
        "x = (\n" * 20_000,
        "x = 1 +\n" * 20_000,
        "if x:\n" * 20_000,
        "def f():\n" * 5_000,
        "def f():\n" * 2_000 + "f()\n" * 2_000 + "end\n" * 2_000,
        "end\n" * 20_000,
        'x = "' * 20_000,
        "x = " + "[" * 50_000,
        "movej(" + "1," * 50_000 + ")\n",
        "x = p[" + "1," * 50_000 + "1]\n",
        "a." * 20_000 + "b()\n",
        "x = " + "not " * 20_000 + "y\n",
        "x = " + "-" * 20_000 + "1\n",
        "# " + '"' * 50_000 + "\n",
        "x = f" + "(1)" * 20_000 + "\n",
        "x = y" + "[1]" * 20_000 + "\n",
        "movel(p[1e999,0,0,0,0,0], v=1e999)\nsleep(1e999)\nx = d2r(1e999)\n",
    ],
    ids=lambda text: text[:12],
)
def test_odd_texts_take_no_time_to_speak_of(text: str) -> None:
    with cpu_time_below(5.0):
        program = read(text)
    assert program.to_bytes() == text.encode()
    assert len(program.line_kinds) == len(program.source.lines)


def mutated(raw: bytes, rng: random.Random) -> bytes:
    """One to four faults: bytes changed, cut, doubled or swapped, lines lost or exchanged."""
    data = bytearray(raw)
    for _ in range(rng.randint(1, 4)):
        at = rng.randrange(len(data))
        match rng.randrange(7):
            case 0:
                data[at] = rng.randrange(256)
            case 1:
                del data[at : at + rng.randint(1, 30)]
            case 2:
                data[at:at] = data[at : at + rng.randint(1, 30)]
            case 3:
                data[at:at] = rng.choice(
                    (b"(", b")", b"[", b'"', b"end", b"p[", b"\n", b"#", b"def ", b" = ")
                )
            case 4:
                del data[at:]
            case 5:
                lines = bytes(data).split(b"\n")
                one, other = rng.randrange(len(lines)), rng.randrange(len(lines))
                lines[one], lines[other] = lines[other], lines[one]
                data = bytearray(b"\n".join(lines))
            case _:
                data[at : at + 1] = rng.choice(
                    (b"9" * 30, b"e999", b"0x", b"-", b"\xff", b"{{", b".", b"True")
                )
        if not data:
            break
    return bytes(data)


@pytest.mark.parametrize("path", sorted(SAMPLES.rglob("*.script")), ids=lambda path: path.name)
def test_damaged_files_neither_crash_nor_lose_a_byte(path: Path) -> None:
    rng, raw = random.Random(path.name), path.read_bytes()
    for _ in range(150):
        damaged = mutated(raw, rng)
        program = read(damaged)
        assert program.to_bytes() == damaged
        assert len(program.line_kinds) == len(program.source.lines)
