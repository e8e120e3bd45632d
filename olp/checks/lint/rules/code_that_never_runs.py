"""W010 and W014: statements that nothing reaches, labels that nothing jumps to."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import dropwhile, takewhile

from olp.checks.guard.budget import budgets_for, label_name
from olp.checks.lint.rule import LintCase, Rule, Suggestion, routines
from olp.ir import program as st
from olp.reports.outcome.model import Level, OutcomeFinding

# Control arrives at these from elsewhere.
_ARRIVALS = (
    st.Label,
    st.Else,
    st.ElseIf,
    st.EndIf,
    st.EndWhile,
    st.EndSwitch,
    st.Case,
    st.Default,
    st.Next,
    st.Until,
    st.End,
)


class UnreachableCode(Rule):
    """Statements after a jump or return that no other path reaches."""

    code = "W010"
    title = "unreachable code"
    why = "The statements never run, although somebody may rely on them: a gripper that opens, a check."
    example = "JUMP *NEXT\nDOUT OT#(3) ON\n*NEXT"
    better = "remove them, or the jump before them"
    suggests = True

    def find(self, case: LintCase) -> Iterator[OutcomeFinding]:
        for routine in routines(case):
            dead = False
            told = False
            for statement in routine.body:
                if isinstance(statement, _ARRIVALS):
                    dead = told = False
                if dead and not told and not isinstance(statement, st.Comment):
                    told = True
                    yield self.finding(
                        case, statement.line, "nothing leads here: these statements never run", "remove them"
                    )
                if _leaves(statement):
                    dead = True

    def suggest(self, program: st.Program, found: OutcomeFinding) -> Iterator[Suggestion]:
        for routine in program.routines:
            dead = [
                s.line
                for s in takewhile(
                    lambda s: not isinstance(s, _ARRIVALS),
                    dropwhile(lambda s: s.line != found.line, routine.body),
                )
            ]
            if dead:
                yield found.line, max(dead), "", "remove what never runs"
                return


def _leaves(statement: st.Statement) -> bool:
    if isinstance(statement, (st.Jump, st.Return)):
        return statement.condition is None
    return isinstance(statement, st.Call) and statement.jump and statement.condition is None


class UnusedLabel(Rule):
    """A label that nothing jumps to."""

    code = "W014"
    title = "unused label"
    level = Level.NOTE
    why = (
        "Nothing jumps to the label: it is left over, or the jump was lost. Labels that a budget in olp.toml names "
        "count as used."
    )
    example = "*RETRY   and no JUMP *RETRY"
    better = "remove the label"
    fixable = True

    def find(self, case: LintCase) -> Iterator[OutcomeFinding]:
        marks = _budget_labels(case.path)
        for routine in routines(case):
            if any(isinstance(s, st.Jump) and not isinstance(s.target, str) for s in routine.body):
                continue  # a computed jump may lead anywhere
            wanted = {s.target for s in routine.body if isinstance(s, st.Jump)}
            texts = " ".join(case.text(s.line) for s in routine.body if not isinstance(s, st.Label))
            for s in routine.body:
                if not isinstance(s, st.Label) or s.name in wanted or s.name.casefold() in marks:
                    continue
                if re.search(rf"(?<!\w){re.escape(_written(case, s))}(?!\w)", texts) is None:
                    # A line that holds more than the label, or is numbered, is left to people.
                    alone = case.text(s.line).strip() in (f"*{s.name}", f"{s.name}:")
                    fixes = ((s.line, s.line, ""),) if alone else ()
                    yield self.finding(
                        case, s.line, f"nothing jumps to {s.name}", "remove the label", fixes=fixes
                    )


def _written(case: LintCase, label: st.Label) -> str:
    """The label with the sign that the language puts before it: *NEXT, LBL[7."""
    text = case.text(label.line)
    at = text.find(label.name)
    return text[max(0, at - 1) : at].strip() + label.name if at > 0 else label.name


def _budget_labels(path: str) -> set[str]:
    own = (b for budgets in budgets_for(path) for b in budgets.budgets if b.covers(path))
    return {label_name(name) for b in own for name in (b.start, b.stop) if name}
