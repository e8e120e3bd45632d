"""What is wrong with a line that the grammar refuses, in words."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import TYPE_CHECKING, Final, NamedTuple

from olp.languages.lark_host import column_of, either, expected, in_words, shortened, word_at

if TYPE_CHECKING:
    from lark.exceptions import UnexpectedInput


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


class InformProblem(NamedTuple):
    """`column`, `end_column`: 1-based, in the line."""

    message: str
    column: int
    end_column: int
    wanted: str


def explain(problem: UnexpectedInput, line: str) -> InformProblem:
    """The refused line in words: what stands there, and what could stand there."""
    names, text = expected(problem), line.rstrip()
    length, column = len(text), column_of(problem, text)
    if column > length:
        return InformProblem("the line ends too early", column, column + 1, sentence(names))
    return _odd_word(line, column) or _unknown_tag(line, column, names) or _unexpected(line, column, names)


def _unexpected(line: str, column: int, names: set[str]) -> InformProblem:
    word = word_at(line, column)
    return InformProblem(
        f"'{_shown(word)}' is not expected here", column, column + len(word), sentence(names)
    )


def _odd_word(line: str, column: int) -> InformProblem | None:
    """A text without its end, a number with two points, a tag without its value."""
    if line[column - 1] == '"':
        return InformProblem("a text that is never closed", column, len(line) + 1, 'a " at its end')
    glued = _NUMBER_BEFORE.search(line[: column - 1])
    if glued is not None and line[column - 1] in _NUMBER_GOES_ON:
        start, word = glued.start() + 1, glued[0] + word_at(line, column)
        return InformProblem(f"'{_shown(word)}' is no number", start, start + len(word), "a number")
    bare = _BARE_TAG.search(line[: column - 1])
    if bare is not None and not (bare.end() == column - 1 and line[column - 1] not in " \t="):
        return InformProblem(
            f"{bare[1]} has no value", bare.start(1) + 1, bare.end(1) + 1, "a number or a variable"
        )
    return None


def _unknown_tag(line: str, column: int, names: set[str]) -> InformProblem | None:
    """`VV=1`: the grammar takes VV for a name and stumbles over the `=` only."""
    before = _WORD_BEFORE.search(line[: column - 1])
    if before is None or line[column - 1] not in "=#" or "COMPARE" in names:
        return None
    start, word = before.start() + 1, before[0] + line[column - 1]
    if word in _KNOWN_TAGS:
        missing = WORDS["TAUGHT"] if "TAUGHT" in names else sentence(names)
        return InformProblem(f"'{word}' is not expected here", start, start + len(word), missing)
    wanted = sentence(names - {"NAME", "VARIABLE", "ARRAY", "TAUGHT"})
    return InformProblem(f"'{_shown(word)}' is not known here", start, start + len(word), wanted)


def sentence(terminals: Iterable[str]) -> str:
    """`terminals` in words: the likely ones first, not more than six."""
    names = set(terminals)
    if "PLUS" in names:
        names.discard("NUMBER")  # a number with a sign continues a sum
    if "COMPARE" in names:
        names.discard("EQUAL")
    words = in_words(names, WORDS)
    likely = [word for word in words if word not in _LAST] or words
    if len(likely) > _MOST:
        return ", ".join([*likely[:_MOST], "…"])
    return either(likely) or "something else"


def _shown(word: str) -> str:
    from olp.languages.vendors.inform.expressions import unmangle

    return shortened(unmangle(word))
