"""Reads RAPID by the syntax that ABB publishes, `rapid_kernel.lark`, which olp does not read by.

    python tests/rapid_kernel.py FILE…      prints a row for each: accepted or rejected, TAB, file, TAB, the line

It is a parser for `bench/parsers.py`.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from lark import Lark
from lark.exceptions import UnexpectedInput


@cache
def kernel() -> Lark:
    grammar = Path(__file__).with_name("rapid_kernel.lark").read_text(encoding="utf-8")
    return Lark(grammar, start="module", parser="lalr", lexer="basic")


def refused(text: str) -> str:
    """The line that the published syntax does not have, empty where it has all."""
    try:
        kernel().parse(text)
    except UnexpectedInput as problem:
        return text.splitlines()[problem.line - 1] if problem.line > 0 else str(problem)
    return ""


def main(files: Sequence[str]) -> int:
    for file in files:
        line = refused(Path(file).read_text(encoding="latin-1").lstrip("\u00ef\u00bb\u00bf"))
        print("rejected" if line else "accepted", file, line.strip(), sep="\t")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
