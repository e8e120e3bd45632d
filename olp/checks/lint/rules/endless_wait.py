"""W012: a wait without a limit."""

from __future__ import annotations

from collections.abc import Iterator

from olp.checks.lint.rule import LintCase, Rule
from olp.ir.program import Wait
from olp.reports.outcome.model import Level, OutcomeFinding


class EndlessWait(Rule):
    """A wait for a signal that lasts for ever when the signal does not come."""

    code = "W012"
    title = "wait without timeout"
    level = Level.NOTE
    why = (
        "If the signal does not come, the cell stops without a message. With a timeout the program can alert the "
        "operator or try again."
    )
    example = "WAIT IN#(5)=ON"
    better = "WAIT IN#(5)=ON T=10.00\nJUMP *ALARM IF IN#(5)=OFF"

    def find(self, case: LintCase) -> Iterator[OutcomeFinding]:
        for statement in case.program.statements():
            if isinstance(statement, Wait) and statement.timeout is None:
                yield self.finding(
                    case, statement.line, "this wait has no limit", "give it a time, and handle the timeout"
                )
