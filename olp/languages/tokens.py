"""Names in the lines of a text: what is a point, a label, a job, a variable, a frame, and which of them stand where.

Beside them the layout of a text, its indentation, blanks and letters, line by line: no line comes, goes or moves.
"""

from __future__ import annotations

import re
from abc import ABC
from collections.abc import Iterator, Sequence
from enum import StrEnum
from functools import cached_property, lru_cache
from typing import ClassVar, NamedTuple

from olp.core.resources import read_text


class TokenKind(StrEnum):
    """What a name stands for."""

    POINT = "point"
    LABEL = "label"
    ROUTINE = "routine"
    VARIABLE = "variable"
    FRAME = "frame"
    TOOL = "tool"
    SIGNAL = "signal"


class Pattern(NamedTuple):
    """`text`: a regular expression with one group, the name. `local`: it is known within its routine only.

    `key`: what tells names apart, with {} for the name's number; empty: the name as it is spelt.
    """

    kind: TokenKind
    text: str
    defines: bool = False
    local: bool = False
    key: str = ""


class Word(NamedTuple):
    """A name in a line. `kind` None: any name, whose declaration says what it is. `plain`: no pattern says it."""

    kind: TokenKind | None
    key: str
    column: int
    end_column: int
    defines: bool = False
    local: bool = False
    plain: bool = False


class Words(ABC):
    """One language. `patterns`: names that show by their spelling what they are, the first that fits counts.

    `passed_over`: comments and texts, within which nothing is a name. `identifier`: any other name, empty for none.
    `keywords`: identifiers that are words of the language, in capitals where case does not count. `one_scope`: routines
    see each other's names. `first_counts`: a name comes into being where it is assigned first, and only there.
    `layout`: None where lines stay as they are.
    """

    patterns: ClassVar[tuple[Pattern, ...]]
    passed_over: ClassVar[str]
    identifier: ClassVar[str] = ""
    keywords: ClassVar[frozenset[str]] = frozenset()
    case_sensitive: ClassVar[bool] = False
    one_scope: ClassVar[bool] = False
    first_counts: ClassVar[bool] = False
    layout: ClassVar[Layout | None] = None

    @cached_property
    def _pattern(self) -> re.Pattern[str]:
        pieces = [f"({self.passed_over})", *(pattern.text for pattern in self.patterns)]
        if self.identifier:
            pieces.append(self.identifier)
        return re.compile("|".join(pieces), re.NOFLAG if self.case_sensitive else re.IGNORECASE)

    def words(self, line: str) -> Iterator[Word]:
        """The names of a line, from left to right."""
        declared = dict(self.declared(line))
        for match in self._pattern.finditer(line):
            group = match.lastindex or 0
            if group < 2:
                continue
            start, stop = match.span(group)
            if group == len(self.patterns) + 2:
                if self.folded(match[group]) in self.keywords:
                    continue
                kind = declared.get(start)
                yield Word(
                    kind, self.folded(match[group]), start + 1, stop + 1, start in declared, plain=True
                )
            else:
                pattern = self.patterns[group - 2]
                key = self._key(pattern, match[group])
                yield Word(pattern.kind, key, start + 1, stop + 1, pattern.defines, pattern.local)

    def declared(self, line: str) -> Iterator[tuple[int, TokenKind]]:
        """Where in a line identifiers come into being (offset), and as what."""
        return iter(())

    def vocabulary(self) -> frozenset[str]:
        """The words that somebody who writes may want: keywords, instructions, tags."""
        return grammar_words(type(self).__module__.split(".")[-2])

    def folded(self, name: str) -> str:
        """The name as it is compared."""
        return name if self.case_sensitive else name.upper()

    def _key(self, pattern: Pattern, name: str) -> str:
        number = _NUMBER.search(name)
        if pattern.key and number is not None:
            return pattern.key.format(int(number[0]))
        bare = _REMARK.sub("", name)
        return self.folded(_NUMBER.sub(lambda m: str(int(m[0])), bare))


def listed(words: str) -> frozenset[str]:
    """Words with blanks between them."""
    return frozenset(words.split())


_NUMBER = re.compile(r"\d+")
_REMARK = re.compile(r"[,:][^\]]*(?=\])|\s")  # in the brackets of a register: its element, what it is called


# --- Vocabulary ---
# The words of a language, as its grammar spells them.

_VOCABULARY_REMARK = re.compile(r"^\s*//.*$", re.MULTILINE)
_LITERAL = re.compile(r'"([A-Za-z][A-Za-z_]+)"')
_TERMINAL = re.compile(r"^_?[A-Z][A-Z_]*(?:\.-?\d+)?\s*:\s*/(.*)/i?\s*$", re.MULTILINE)
_LOOKAROUND = re.compile(r"\(\?<?[=!](?:[^()\[\]]|\[[^\]]*\])*\)|\\b")
_MOST = 60  # spellings of one terminal; a pattern of more is no list of words


@lru_cache(maxsize=32)
def grammar_words(vendor: str) -> frozenset[str]:
    """The keywords of grammars/`vendor`.lark; tags end in =."""
    text = _VOCABULARY_REMARK.sub("", read_text("grammars", f"{vendor}.lark"))
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


class Layout:
    """One language. Without more, blanks at the ends of lines go."""

    def lines(self, lines: Sequence[str], indent: str) -> list[str]:
        """The same lines as they should be; `indent`: one step of indentation."""
        return [line.rstrip(" \t") for line in lines]


class BlockLayout(Layout):
    """A language whose blocks are indented. Each pattern is matched at the first word of a line.

    `opens`: what follows stands one step further; `closes`: from here on one step less; `between`: this line only.
    `free_outside`: a line outside of all blocks stands where it stands, and a block begins there.
    """

    opens: ClassVar[re.Pattern[str]]
    closes: ClassVar[re.Pattern[str]]
    between: ClassVar[re.Pattern[str]]
    open_end: ClassVar[re.Pattern[str]] = re.compile(r"(?!)")  # a line that goes on in the next one
    kept: ClassVar[re.Pattern[str]] = re.compile(r"(?!)")  # lines that stay as they are
    free_outside: ClassVar[bool] = False

    def lines(self, lines: Sequence[str], indent: str) -> list[str]:
        found: list[str] = []
        depth, shift, goes_on, base = 0, 0, False, ""
        for line in lines:
            text = line.strip(" \t")
            if not text or self.kept.match(text):
                found.append(text and line)
                continue
            old = line[: len(line) - len(line.lstrip(" \t"))]
            if goes_on:
                # The rest of an instruction keeps its place below the first line.
                found.append(" " * max(0, len(old) + shift) + text)
            else:
                if self.closes.match(text):
                    depth = max(0, depth - 1)
                level = max(0, depth - 1) if self.between.match(text) else depth
                if self.free_outside and not depth:
                    base = old
                found.append(base + indent * level + text)
                shift = len(base + indent * level) - len(old)
                depth += self.opens.match(text) is not None
            goes_on = self.open_end.search(self.bare(text)) is not None
        return found

    def bare(self, text: str) -> str:
        """The line without its comment."""
        return text
