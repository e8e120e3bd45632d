"""The host of all grammars: one lark parser per language, what it refuses in words, and the bounds of what is read.

A language gives its grammar (`grammars/NAME.lark`), its rules (a lark Transformer), and a table of its terminals in
words. lark itself is imported with the first parser: files of plain moves need none.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields as dataclass_fields
from operator import attrgetter
from threading import Lock
from typing import TYPE_CHECKING, Any, Final

from olp.core.diagnostic import Severity, Span
from olp.core.resources import read_text
from olp.languages.findings import Findings

if TYPE_CHECKING:
    from lark import Token, Transformer
    from lark.exceptions import UnexpectedInput

MOST_BROKEN: Final = 2000  # lines; with more of them a file is no program, and each is no longer explained
_ENDS_OF_WORDS: Final = frozenset(" \t()[]=,")
_LONGEST_SHOWN: Final = 40  # characters


class BrokenLineError(Exception):
    """A line that is grammatical but makes no sense. `word`: what in it is wrong; `wanted`: what would be right."""

    def __init__(self, message: str, *, word: str = "", wanted: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.word = word
        self.wanted = wanted


class Grammar:
    """The parser of one language. `rules` build the result while lark parses; None: `parse` gives lark's tree.

    `terminals`: their patterns, by name; `written`: of those with one spelling, that. Safe to share between threads.
    """

    def __init__(
        self,
        language: str,
        rules: Transformer[Token, Any] | None = None,
        starts: Iterable[str] = ("instruction",),
    ) -> None:
        from lark import Lark

        self.rules = rules
        self.lark = Lark(
            read_text("grammars", f"{language}.lark"),
            parser="lalr",
            lexer="contextual",
            start=list(starts),
            transformer=rules,
            maybe_placeholders=True,
        )
        self._lock = Lock()
        self.terminals = {terminal.name: terminal.pattern.value for terminal in self.lark.terminals}
        self.written = {
            one.name: one.pattern.value for one in self.lark.terminals if one.pattern.type == "str"
        }

    def parse(self, text: str, start: str | None = None, then: Iterable[str] = (), **settings: Any) -> Any:
        """What the rules make of a text; with `then` a tuple of that and of these attributes of the rules.

        `settings`: attributes of the rules that hold for this text. Raises lark's UnexpectedInput, and what the rules
        raise (BrokenLineError for a line whose words contradict each other).
        """
        with self._lock:
            for name, value in settings.items():
                setattr(self.rules, name, value)
            found: Any = self.lark.parse(text, start=start)
            told = tuple(getattr(self.rules, name) for name in then)
        return (found, *told) if told else found


# --- what is refused, in words ----------------------------------------------------------------------------


def expected(problem: UnexpectedInput) -> set[str]:
    """The terminals that the grammar would have taken."""
    names = getattr(problem, "accepts", None) or getattr(problem, "expected", None)
    return set(names or getattr(problem, "allowed", None) or ())


def column_of(problem: UnexpectedInput, text: str) -> int:
    """Where in the text the grammar stumbled, from 1; behind its last character where the line ends too early."""
    token = getattr(problem, "token", None)
    at_end = (token is not None and token.type == "$END") or type(problem).__name__ == "UnexpectedEOF"
    column = problem.column
    return column if not at_end and 0 < (column or 0) <= len(text) else len(text) + 1


def word_at(text: str, column: int) -> str:
    """What stands at `column` (from 1), up to the next blank, bracket or `=`."""
    rest = text[column - 1 :]
    return next((rest[:at] for at, char in enumerate(rest) if at and char in _ENDS_OF_WORDS), rest)


def shortened(word: str) -> str:
    """A word as messages show it."""
    return word if len(word) <= _LONGEST_SHOWN else word[:_LONGEST_SHOWN] + "…"


def either(words: list[str]) -> str:
    """`a, b or c`."""
    return f"{', '.join(words[:-1])} or {words[-1]}" if len(words) > 1 else "".join(words)


def in_words(names: set[str], table: Mapping[str, str]) -> list[str]:
    """Terminals in words, in the order of the table; those that share their words are named once."""
    return list(dict.fromkeys(words for name, words in table.items() if name in names))


def give_up(findings: Findings, code: str, span: Span, what: str = "lines") -> None:
    """Thousands of broken lines mean that this is no program: stop explaining each."""
    message = f"more than {MOST_BROKEN} broken lines: from here on {what} are not examined"
    findings.once(Severity.ERROR, code, "", message, span, "correct the first ones")


# --- statements that are made anew for each line ------------------------------------------------------------

_getters: dict[type, Callable[[Any], tuple[Any, ...]]] = {}
_names: dict[type, tuple[str, ...]] = {}


def values_of(statement: Any) -> tuple[Any, ...]:
    """All fields of a statement but the line, in the order of the constructor."""
    kind = type(statement)
    getter = _getters.get(kind)
    if getter is None:
        names = [one.name for one in dataclass_fields(kind)][1:]
        getter = _getters[kind] = attrgetter(*names) if len(names) > 1 else _few(names)
    return getter(statement)


def _few(names: list[str]) -> Callable[[Any], tuple[Any, ...]]:
    return lambda statement: tuple(getattr(statement, name) for name in names)


def placed(statement: Any, line: int) -> Any:
    """The statement on its line."""
    if statement.line == line:
        return statement
    return type(statement)(line, *values_of(statement))


def changed(statement: Any, **fields: Any) -> Any:
    """The statement with other values of some fields: `dataclasses.replace`, for thousands of them."""
    kind = type(statement)
    names = _names.get(kind)
    if names is None:
        names = _names[kind] = tuple(one.name for one in dataclass_fields(kind)[1:])
    return kind(statement.line, **{**dict(zip(names, values_of(statement), strict=True)), **fields})


def bracket_depth(text: str) -> int:
    """How deep the brackets of a text are nested."""
    depth = deepest = 0
    for character in text:
        if character in "([{":
            depth += 1
            deepest = max(deepest, depth)
        elif character in ")]}":
            depth -= 1
    return deepest
