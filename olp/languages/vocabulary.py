"""The words of a language, as its grammar spells them."""

from __future__ import annotations

import re
from functools import lru_cache

from olp.core.resources import read_text

_REMARK = re.compile(r"^\s*//.*$", re.MULTILINE)
_LITERAL = re.compile(r'"([A-Za-z][A-Za-z_]+)"')
_TERMINAL = re.compile(r"^_?[A-Z][A-Z_]*(?:\.-?\d+)?\s*:\s*/(.*)/i?\s*$", re.MULTILINE)
_LOOKAROUND = re.compile(r"\(\?<?[=!](?:[^()\[\]]|\[[^\]]*\])*\)|\\b")
_MOST = 60  # spellings of one terminal; a pattern of more is no list of words


@lru_cache(maxsize=32)
def grammar_words(vendor: str) -> frozenset[str]:
    """The keywords of grammars/`vendor`.lark; tags end in =."""
    text = _REMARK.sub("", read_text("grammars", f"{vendor}.lark"))
    words = set(_LITERAL.findall(text))
    for pattern in _TERMINAL.findall(text):
        words.update(word for word in spellings(pattern) if _WORD.fullmatch(word))
    return frozenset(words)


_WORD = re.compile(r"[A-Za-z][A-Za-z0-9_]*=?|[A-Za-z]\w+")


def spellings(pattern: str) -> list[str]:
    """The texts that a plain pattern of letters, groups and options matches; none where it is not plain."""
    try:
        found, rest = _alternatives(_LOOKAROUND.sub("", pattern))
    except ValueError:
        return []
    return found if not rest and len(found) <= _MOST else []


def _alternatives(text: str) -> tuple[list[str], str]:
    """Spellings of `a|b|c` up to a closing parenthesis, and what follows. Raises ValueError."""
    found: list[str] = []
    while True:
        part, text = _sequence(text)
        found += part
        if not text.startswith("|"):
            return found, text
        text = text[1:]


def _sequence(text: str) -> tuple[list[str], str]:
    found = [""]
    while text and text[0] not in "|)":
        if text.startswith("(?:"):
            piece, text = _alternatives(text[3:])
            if not text.startswith(")"):
                raise ValueError(text)
            text = text[1:]
        elif text[0].isalnum() or text[0] in "_=":
            piece, text = [text[0]], text[1:]
        else:
            raise ValueError(text)
        if text.startswith("?"):
            piece, text = [*piece, ""], text[1:]
        found = [before + after for before in found for after in piece]
        if len(found) > _MOST:
            raise ValueError(text)
    return found, text
