"""What is wrong with an instruction that the grammar refuses, in words."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final, NamedTuple

from olp.languages.lark_host import expected

if TYPE_CHECKING:
    from lark.exceptions import UnexpectedInput


WORDS: Final = {
    "NAME": "a name",
    "NUMBER": "a number",
    "TEXT": 'a text such as "part ready"',
    "LPAR": "'('",
    "RPAR": "')'",
    "LSQB": "'['",
    "RSQB": "']'",
    "COMMA": "','",
    "COLON": "':'",
    "EQUAL": "'='",
    "DOT": "'.'",
    "COMPARE": "an operator",
    "SUM": "an operator",
    "PRODUCT": "an operator",
    "AND": "an operator",
    "OR": "an operator",
    "XOR": "an operator",
    "END": "end",
    "DEFINE": "def or thread",
    "$END": "the end of the line",
}
_VALUE: Final = frozenset({"NAME", "NUMBER", "TEXT", "LPAR", "LSQB"})
_FOREIGN: Final = {
    "for": "URScript has no for: count with while",
    "&&": "write and",
    "||": "write or",
    "try": "URScript has no try",
    "import": "URScript has no import",
    "++": "write x = x + 1",
}
_WORD = re.compile(r"\w+|\S")
_MOST = 6


class UrscriptProblem(NamedTuple):
    """`offset`, `length`: in the text of the instruction, from 0."""

    message: str
    offset: int
    length: int
    help: str


def explain(refused: UnexpectedInput, text: str) -> UrscriptProblem:
    """The refused instruction in words: what stands there, and what could stand there."""
    offset = refused.pos_in_stream if isinstance(refused.pos_in_stream, int) else len(text)
    token = getattr(refused, "token", None)
    if token is not None and token.type == "$END":
        offset = len(text)
    help = _foreign(text, offset) or _sentence(expected(refused))
    if not 0 <= offset < len(text):
        return UrscriptProblem("the line ends too early", len(text), 1, help)
    if text[offset] == '"':
        return UrscriptProblem(
            "a text that is not closed", offset, len(text) - offset, 'close it with " on the same line'
        )
    word = _WORD.match(text, offset)
    found = word[0] if word else text[offset]
    return UrscriptProblem(f"'{found[:40]}' does not fit here", offset, len(found), help)


def _foreign(text: str, offset: int) -> str:
    """What a word of another language is called here, or nothing."""
    if text[offset : offset + 1] == "=" and text.startswith(("if", "elif", "while")):
        return "compare with =="
    first = _WORD.match(text)
    for word, help in _FOREIGN.items():
        if (word.isalpha() and first is not None and first[0] == word) or (
            not word.isalpha() and word in text
        ):
            return help
    return ""


def _sentence(names: set[str]) -> str:
    if "SUM" in names and "COMPARE" in names:
        names = names - {"LPAR", "LSQB", "DOT"}  # what goes on behind any value helps nobody
    words = {WORDS.get(name, "") for name in names - _VALUE} - {""}
    if names >= {"NAME", "NUMBER"}:
        words.add("a value")
    elif names & _VALUE:
        words |= {WORDS[name] for name in names & _VALUE}
    if not words or len(words) > _MOST:
        return ""
    return f"expected {', '.join(sorted(words))}"
