"""The instructions of /MN: the fast path first, then lines seen before, then the grammar."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from olp.core.diagnostic import Severity, Span
from olp.ir.program import (
    Case,
    Comment,
    Default,
    Disabled,
    EndSwitch,
    Jump,
    Label,
    LineKind,
    Move,
    Process,
    Statement,
    Switch,
)
from olp.languages.findings import Findings
from olp.languages.vendors.tp.fast import TpMoveLines
from olp.languages.vendors.tp.lines import TpLine
from olp.languages.vendors.tp.parsing import TpLineParser

BLOCK: Final = "P-SPS"  # the instructions that a controller runs beside a move


class TpInstructionReader:
    """Reads the instructions of one program. `german`: its keywords are German."""

    def __init__(self, findings: Findings, moves: TpMoveLines, german: bool) -> None:
        self._findings = findings
        self._kinds = findings.kinds
        self._moves = moves
        self._parser = TpLineParser(findings, german)
        self._body: list[Statement] = []
        self._block = 0  # line of the move that a P-SPS block belongs to
        self._switch = -1  # index behind the last action of an open SELECT

    @property
    def markers(self) -> list[Statement]:
        """Stand for broken lines that open a block."""
        return self._parser.markers

    def read(self, lines: Iterable[TpLine]) -> list[Statement]:
        """All statements, in order."""
        move, body, kinds = self._moves.read, self._body, self._kinds
        for line in lines:
            number = line.number
            for more in range(line.lines):
                kinds[number - 1 + more] = LineKind.STATEMENT
            statement = move(line.text, number)
            if statement is not None:
                if self._switch >= 0:
                    self._end_switch()
                body.append(statement)
            elif line.text:
                self._line(line)
            elif line.block_end:
                self._end_block(number)
            if not line.closed:
                self._unclosed(line)
        if self._switch >= 0:
            self._end_switch()
        return body

    # --- one line ---------------------------------------------------------------------------------------

    def _line(self, line: TpLine) -> None:
        text, number = line.text, line.number
        if text[0] == "!":
            self._kinds[number - 1] = LineKind.COMMENT
            self._body.append(Comment(number, text[1:]))
            return
        if text.startswith("--eg:"):
            self._kinds[number - 1] = LineKind.COMMENT
            self._body.append(Comment(number, text))
            return
        if text.startswith("//"):
            self._body.append(Disabled(number, text[2:].strip()))
            return
        for statement in self._statements(text, number):
            self._add(statement)

    def _add(self, statement: Statement) -> None:
        kind = type(statement)
        if self._switch >= 0:
            self._end_switch()
        if self._block and kind in (Label, Jump):
            statement = self._inside_block(statement)
        if kind is Move and any(BLOCK in getattr(value, "value", "") for _, value in statement.other):  # type: ignore[union-attr]
            self._block = statement.line
        self._body.append(statement)

    def _inside_block(self, statement: Statement) -> Statement:
        """Labels of a P-SPS block are its own: they get the block's line behind their number."""
        if isinstance(statement, Label):
            return replace(statement, name=f"{statement.name}/{self._block}")
        if isinstance(statement, Jump) and isinstance(statement.target, str):
            return replace(statement, target=f"{statement.target}/{self._block}")
        return statement

    def _end_block(self, number: int) -> None:
        if not self._block:
            self._findings.warning(
                "P532",
                "the end of a block that never began",
                self._span(number),
                "remove it, or add P-SPS to its move",
            )
            return
        self._block = 0
        if self._switch >= 0:
            self._end_switch()
        self._body.append(Process(number, f"{BLOCK} END"))
        message = "a P-SPS block runs beside its move; it is read as standing behind it"
        self._findings.once(
            Severity.INFO, "P531", "", message, self._span(number), "waits in it delay the next move"
        )

    def _end_switch(self) -> None:
        at = self._switch
        self._body.insert(at, EndSwitch(self._body[at - 1].line))
        self._switch = -1

    # --- SELECT -----------------------------------------------------------------------------------------

    def _statements(self, text: str, number: int) -> list[Statement]:
        found = self._parser.statements(text, number)
        if found and type(found[0]) in (Switch, Case, Default):
            self._begin_case(type(found[0]) is Switch, number)
            self._body.extend(found)
            self._switch = len(self._body)
            return []
        return found

    def _begin_case(self, opens: bool, number: int) -> None:
        if opens and self._switch >= 0:
            self._end_switch()
        elif not opens and self._switch < 0:
            self._findings.error(
                "P528", "a case without SELECT", self._span(number), "add SELECT R[1]=1,JMP LBL[1] above"
            )

    def _unclosed(self, line: TpLine) -> None:
        message = "no semicolon ends this instruction"
        self._findings.once(
            Severity.WARNING, "P504", "", message, self._span(line.number), "add ; at its end"
        )

    def _span(self, number: int) -> Span:
        return self._findings.whole_line(number)
