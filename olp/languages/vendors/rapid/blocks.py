"""Pairs IF, WHILE, FOR and TEST of one routine in RAPID's words."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from olp.core.diagnostic import Span
from olp.ir.program import (
    Case,
    Default,
    Else,
    ElseIf,
    EndIf,
    EndSwitch,
    EndWhile,
    For,
    If,
    Next,
    Statement,
    Switch,
    While,
)
from olp.languages.findings import Findings
from olp.languages.vendors.rapid.clauses import Clause

_OPENERS: Final = {If: "IF", While: "WHILE", For: "FOR", Switch: "TEST"}
_CLOSERS: Final = {EndIf: "IF", EndWhile: "WHILE", Next: "FOR", EndSwitch: "TEST"}
_BRANCHES: Final = {ElseIf: "IF", Else: "IF", Case: "TEST", Default: "TEST"}
_BRANCH_WORDS: Final = {ElseIf: "ELSEIF", Else: "ELSE", Case: "CASE", Default: "DEFAULT"}
_MARKERS: Final = {
    **{word: ("open", word) for word in ("IF", "WHILE", "FOR", "TEST")},
    **{f"END{word}": ("close", word) for word in ("IF", "WHILE", "FOR", "TEST")},
}


class OpenBlocks:
    """The open blocks of a routine: words and lines."""

    def __init__(self, findings: Findings) -> None:
        self._findings = findings
        self._open: list[tuple[str, int]] = []

    def note(self, statements: Iterable[Statement]) -> None:
        """Statements of one clause; what does not pair is told."""
        for one in statements:
            kind = type(one)
            if kind in _OPENERS:
                self._open.append((_OPENERS[kind], one.line))
            elif kind in _CLOSERS:
                self._close(_CLOSERS[kind], one.line, f"END{_CLOSERS[kind]}")
            elif kind in _BRANCHES and not any(word == _BRANCHES[kind] for word, _ in self._open[-1:]):
                self._branch(_BRANCHES[kind], _BRANCH_WORDS[kind], one.line)

    def stand_in(self, clause: Clause) -> None:
        """A broken clause that opens or closes a block does so all the same."""
        does, word = _MARKERS.get(clause.word, ("", ""))
        if does == "open" and (word != "IF" or clause.text.rstrip()[-4:].upper() == "THEN"):
            self._open.append((word, clause.line))
        elif does == "close":
            self._close(word, clause.line, f"END{word}")

    def _close(self, word: str, line: int, closer: str) -> None:
        depth = next((d for d in range(len(self._open) - 1, -1, -1) if self._open[d][0] == word), None)
        if depth is None:
            message = f"{closer} without {word}"
            self._findings.error(
                "P454", message, self._findings.whole_line(line), "remove it, or open the block"
            )
            return
        for inner, at in self._open[depth + 1 :]:
            self._never(inner, at)
        del self._open[depth:]

    def _branch(self, word: str, branch: str, line: int) -> None:
        if any(opened == word for opened, _ in self._open):
            while self._open[-1][0] != word:
                self._never(*self._open.pop())
            return
        message = f"{branch} without {word}"
        self._findings.error("P454", message, self._findings.whole_line(line), "remove it, or open the block")

    def close(self) -> None:
        """The routine, or what stands before its handlers, ends."""
        for word, line in self._open:
            self._never(word, line)
        self._open.clear()

    def _never(self, word: str, line: int) -> None:
        span = self._findings.whole_line(line) if line else Span(0)
        self._findings.error(
            "P453", f"{word} is never closed", span, f"add END{word} behind its last instruction"
        )
