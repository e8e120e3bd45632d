"""What is wrong with a line that the grammar refuses, in words."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final, NamedTuple

from lark.exceptions import UnexpectedCharacters, UnexpectedEOF, UnexpectedInput, UnexpectedToken

# Each terminal of the grammar in words. Those that share a sentence are told once.
WORDS: Final = {
    "NUMBER": "a number",
    "UNSIGNED": "a number",
    "STRING": 'a text such as "OK"',
    "VARIABLE": "a variable such as B000, LD012 or P040",
    "ARRAY": "a variable such as B000, LD012 or P040",
    "NAME": "a name from //ALIAS",
    "TAUGHT": "a position such as C00001",
    "SPEED_TAG": "a speed such as V=300.0 or VJ=25.00",
    "LEVEL_TAG": "a position level such as PL=1",
    "RATE_TAG": "ACC= or DEC=",
    "RADIUS_TAG": "CR=",
    "OTHER_TAG": "CV=, VE= or SPDL=",
    "TIME_TAG": "a time such as T=0.50",
    "DISTANCE_TAG": "a distance such as DIS=20.0",
    "KIND_TAG": "KIND=",
    "NUMBER_TAG": "PRMNO=",
    "COUNT_TAG": "SNUM=",
    "TAG": "a value such as AMP=2.0",
    "INDEXED": "a condition file such as ASF#(1)",
    "SIGNAL": "a signal such as IN#(1) or OT#(1)",
    "STATE": "ON or OFF",
    "HALF": "LOW or HIGH",
    "LPAR": "'('",
    "RPAR": "')'",
    "LSQB": "'['",
    "RSQB": "']'",
    "COMMA": "','",
    "EQUAL": "'='",
    "COMPARE": "a comparison such as =, <> or <",
    "PLUS": "'+'",
    "MINUS": "'-'",
    "TIMES": "'*'",
    "DIVIDE": "'/'",
    "COMMENT": "a comment such as //seam start",
    "LABEL": "a label such as *START",
    "JOB": "a job such as JOB:MAIN",
    "ARGF": "an argument such as ARGF1",
    "SUFFIX": "a condition such as IF IN#(1)=ON",
    "JOINT": "ANDIF, ORIF, ANDEXP or OREXP",
    "FOREXPRESS": "FOREXPRESS",
    "FRAME": "a coordinate system such as UF#(1) or BF",
    "USER_MARK": "a coordinate system such as UF#(1) or BF",
    "TOOL_MARK": "a tool such as TL#(1)",
    "MACRO_MARK": "a macro such as MJ#(1)",
    "IARG": "an argument such as IARG#(1)",
    "STEP_MARK": "a step such as STEP#(1)",
    "EXPRESS": "EXPRESS with an expression",
    "SRCH": "a search such as SRCH RIN#(1)=ON DIS=20.0",
    "UNTIL": "UNTIL with a condition",
    "CONTINUOUS": "CONT",
    "END_OF_ARC": "FPT",
    "NO_WAIT": "NWAIT",
    "PASSES": "a pass such as T00001",
    "MOVE": "MOVJ or MOVL",
    "REFERENCE": "REFP",
    "START": "START=",
    "CASE": "CASE",
    "TO": "TO",
    "STEP": "STEP=",
    "TASK": "a task such as SUB1",
    "SYNC": "SYNC",
    "ALL": "ALL",
    "CLEAR_WORD": "STACK or MPF",
    "MTOOL": "MTOOL",
    "RETURNED": "$RV",
    "SYSTEM_VALUE": "a system variable such as $PX000 or $B002",
    "DISABLED": "an instruction",
    "COMPUTED": "LABEL: with a variable",
    "$END": "the end of the line",
}
# The end of a line and a comment fit nearly everywhere and help nobody who misses something else.
_LAST = ("the end of the line", "a comment such as //seam start")
_MOST = 6
_NUMBER_BEFORE = re.compile(r"(?<![\w.])[\d.]+$")
_NUMBER_GOES_ON = frozenset(".0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_")
_BARE_TAG = re.compile(r"([A-Z]+=)(?:\s+[A-Z]+|\s*)$")
_WORD_BEFORE = re.compile(r"[^\W\d]\w*$")
_KNOWN_TAGS = frozenset({"V=", "VJ=", "VR=", "PL=", "ACC=", "DEC=", "CR=", "T=", "UF#", "SRCH="})


class Problem(NamedTuple):
    """`column`, `end_column`: 1-based, in the line."""

    message: str
    column: int
    end_column: int
    wanted: str


def explain(problem: UnexpectedInput, line: str) -> Problem:
    """The refused line in words: what stands there, and what could stand there."""
    if isinstance(problem, UnexpectedToken):
        expected: Iterable[str] = problem.accepts or problem.expected
        at_end = problem.token.type == "$END"
    elif isinstance(problem, UnexpectedCharacters):
        expected, at_end = problem.allowed or (), False
    else:
        assert isinstance(problem, UnexpectedEOF)
        expected, at_end = problem.expected, True
    names = set(expected)
    length = len(line.rstrip())
    column = problem.column if not at_end and 0 < problem.column <= length else length + 1
    if column > length:
        return Problem("the line ends too early", column, column + 1, sentence(names))
    return _odd_word(line, column) or _unknown_tag(line, column, names) or _unexpected(line, column, names)


def _unexpected(line: str, column: int, names: set[str]) -> Problem:
    word = _word(line, column)
    return Problem(f"'{_shown(word)}' is not expected here", column, column + len(word), sentence(names))


def _odd_word(line: str, column: int) -> Problem | None:
    """A text without its end, a number with two points, a tag without its value."""
    if line[column - 1] == '"':
        return Problem("a text that is never closed", column, len(line) + 1, 'a " at its end')
    glued = _NUMBER_BEFORE.search(line[: column - 1])
    if glued is not None and line[column - 1] in _NUMBER_GOES_ON:
        start, word = glued.start() + 1, glued[0] + _word(line, column)
        return Problem(f"'{_shown(word)}' is no number", start, start + len(word), "a number")
    bare = _BARE_TAG.search(line[: column - 1])
    if bare is not None and not (bare.end() == column - 1 and line[column - 1] not in " \t="):
        return Problem(
            f"{bare[1]} has no value", bare.start(1) + 1, bare.end(1) + 1, "a number or a variable"
        )
    return None


def _unknown_tag(line: str, column: int, names: set[str]) -> Problem | None:
    """`VV=1`: the grammar takes VV for a name and stumbles over the `=` only."""
    before = _WORD_BEFORE.search(line[: column - 1])
    if before is None or line[column - 1] not in "=#" or "COMPARE" in names:
        return None
    start, word = before.start() + 1, before[0] + line[column - 1]
    if word in _KNOWN_TAGS:
        missing = WORDS["TAUGHT"] if "TAUGHT" in names else sentence(names)
        return Problem(f"'{word}' is not expected here", start, start + len(word), missing)
    wanted = sentence(names - {"NAME", "VARIABLE", "ARRAY", "TAUGHT"})
    return Problem(f"'{_shown(word)}' is not known here", start, start + len(word), wanted)


def sentence(expected: Iterable[str]) -> str:
    """`expected` terminals in words: the likely ones first, not more than six."""
    names = set(expected)
    if "PLUS" in names:
        names.discard("NUMBER")  # a number with a sign continues a sum
    if "COMPARE" in names:
        names.discard("EQUAL")
    order = {name: place for place, name in enumerate(WORDS)}
    known = sorted(names & set(order), key=order.__getitem__)
    words = list(dict.fromkeys(WORDS[name] for name in known))
    likely = [word for word in words if word not in _LAST] or words
    shown = likely[:_MOST]
    if len(likely) > _MOST:
        return ", ".join([*shown, "…"])
    if len(shown) == 1:
        return shown[0]
    return f"{', '.join(shown[:-1])} or {shown[-1]}" if shown else "something else"


def _word(line: str, column: int) -> str:
    """What stands at `column`, up to the next blank, parenthesis or `=`."""
    rest = line[column - 1 :]
    for length, char in enumerate(rest):
        if length and char in " \t()[]=,":
            return rest[:length]
    return rest


def _shown(word: str) -> str:
    from olp.vendors.inform.names import unmangle

    word = unmangle(word)
    return word if len(word) <= 40 else word[:40] + "…"
