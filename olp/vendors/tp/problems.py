"""What is wrong with a line that the grammar refuses, in words."""

from __future__ import annotations

from typing import Final, NamedTuple

from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

# The grammar's terminals in words, the likely ones first.
WORDS: Final = {
    "MOTION": "a move such as L P[1] 100mm/sec FINE",
    "POINT_OPEN": "a position such as P[1]",
    "POSITION_OPEN": "a position register such as PR[1]",
    "UNIT": "a unit such as mm/sec or %",
    "FINE": "FINE",
    "CORNER": "CNT0 .. CNT100",
    "REGISTER_OPEN": "a register such as R[1]",
    "SIGNAL_OPEN": "a signal such as DI[1]",
    "NUMBER": "a number",
    "STATE": "ON or OFF",
    "LABEL_OPEN": "a label such as LBL[1]",
    "PROGRAM": "the name of a program",
    "COMPARE": "a comparison",
    "EQUAL": "'='",
    "RSQB": "']'",
    "NAMED_CLOSE": "']'",
    "LPAR": "'('",
    "RPAR": "')'",
    "COMMA": "','",
    "THEN": "THEN",
    "AND": "AND",
    "OR": "OR",
    "TIMEOUT": "TIMEOUT,LBL[1]",
    "ACC": "an option such as ACC80 or Offset,PR[1]",
}
_MOST = 6


class Problem(NamedTuple):
    """`column` (from 1) of the instruction's text and `end_column`, exclusive; `wanted` in words, may be empty."""

    message: str
    column: int
    end_column: int
    wanted: str


def explain(problem: UnexpectedInput, text: str) -> Problem:
    """The first thing that the grammar did not take, and what it would have taken."""
    names: set[str] = set()
    at_end = False
    if isinstance(problem, UnexpectedToken):
        names, at_end = set(problem.accepts or problem.expected), problem.token.type == "$END"
    elif isinstance(problem, UnexpectedCharacters):
        names = set(problem.allowed or ())
    else:
        at_end = True
    column = problem.column if not at_end and 0 < problem.column <= len(text) else len(text) + 1
    wanted = _sentence(names)
    if column > len(text):
        return Problem("the line ends too early", column, column + 1, wanted)
    word = _word(text, column)
    shown = word if len(word) <= 40 else word[:40] + "…"
    return Problem(f"'{shown}' is not expected here", column, column + len(word), wanted)


def _sentence(names: set[str]) -> str:
    words = list(dict.fromkeys(words for name, words in WORDS.items() if name in names))
    if len(words) > _MOST:
        return ", ".join([*words[:_MOST], "…"])
    if len(words) == 1:
        return words[0]
    return f"{', '.join(words[:-1])} or {words[-1]}" if words else ""


def _word(text: str, column: int) -> str:
    """What stands at `column`, up to the next blank or bracket."""
    rest = text[column - 1 :]
    for length, char in enumerate(rest):
        if length and char in " \t()[]=,":
            return rest[:length]
    return rest
