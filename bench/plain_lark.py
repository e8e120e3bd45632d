"""What a straightforward lark parser makes of a job: the yardstick of bench/speed.py.

One LALR grammar for the whole text, a terminal per kind of word, the transformer embedded in the parser, so that no
tree is built. It knows point rows and moves only and produces their numbers, which is the least a reader has to do.
"""

from __future__ import annotations

from typing import Any

from lark import Lark, Token, Transformer, v_args

GRAMMAR = r"""
start: (line? _NEWLINE)*
line: RECORD                                 -> record
    | NAME "=" NUMBER ("," NUMBER)*          -> row
    | INSTRUCTION NAME tag* [COMMENT]        -> move
    | WORD                                   -> mark
tag: TAG "=" NUMBER

RECORD: /\/[^\r\n]*/
WORD.2: "NOP" | "END"
INSTRUCTION.2: "MOVJ" | "MOVL" | "MOVC" | "MOVS"
TAG.2: "VJ" | "VR" | "V" | "PL" | "ACC" | "DEC"
NAME: /(?:BC|EC|BP|EX|C|P)\d+/
NUMBER: /-?\d+(?:\.\d*)?/
COMMENT: /\/\/[^\r\n]*/
_NEWLINE: /\r?\n/
%ignore " "
"""


@v_args(inline=True)
class Numbers(Transformer[Token, int]):
    """Keeps the points and the moves; a line's value is 1, so that the lines are counted."""

    def __init__(self) -> None:
        super().__init__()
        self.points: dict[str, tuple[float, ...]] = {}
        self.moves: list[tuple[str, str, tuple[tuple[str, float], ...]]] = []

    def record(self, text: Token) -> int:
        return 1

    def mark(self, word: Token) -> int:
        return 1

    def row(self, name: Token, *values: Token) -> int:
        self.points[str(name)] = tuple(map(float, values))
        return 1

    def tag(self, name: Token, value: Token) -> tuple[str, float]:
        return str(name), float(value)

    def move(self, instruction: Token, point: Token, *tags: Any) -> int:
        self.moves.append(
            (str(instruction), str(point), tuple(tag for tag in tags if isinstance(tag, tuple)))
        )
        return 1

    def start(self, *lines: int) -> int:
        return len(lines)


def count_lines(text: str) -> int:
    """Parses `text` and returns how many lines it understood."""
    parser = Lark(GRAMMAR, parser="lalr", transformer=Numbers())
    lines = parser.parse(text)
    assert isinstance(lines, int)
    return lines
