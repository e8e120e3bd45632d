"""The base of all rules, and the list of them, which is the listing of `rules/`."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import replace
from importlib import import_module
from pkgutil import iter_modules
from typing import ClassVar, final

from olp.checks.lint.case import LintCase
from olp.ir.program import Program
from olp.reports.outcome.model import Level, OutcomeFinding

# First line, last line, the lines that take their place ("": none), and what that does in a few words.
Suggestion = tuple[int, int, str, str]


class Rule(ABC):
    """A mistake that a program can hold.

    `code` never changes. `why`: what it costs, in a paragraph; `example` and `better`: lines with and without it.
    `fixable`: whether findings can carry a change that alters neither path nor time. `suggests`: whether there are
    changes that do, for people to choose.
    """

    code: ClassVar[str] = ""
    title: ClassVar[str]
    level: ClassVar[Level] = Level.WARNING
    why: ClassVar[str]
    example: ClassVar[str]
    better: ClassVar[str]
    fixable: ClassVar[bool] = False
    suggests: ClassVar[bool] = False

    @abstractmethod
    def find(self, case: LintCase) -> Iterator[OutcomeFinding]:
        """The places where the program holds the mistake, in order of lines."""

    def suggest(self, program: Program, found: OutcomeFinding) -> Iterator[Suggestion]:
        """Changes that would mend a finding of this rule but alter the motion or its time, the best one first."""
        yield from ()

    @final
    def explained(self) -> str:
        """The rule for people: what it is, why, an example and what is better."""
        fix = "--fix" if self.fixable else "--fix --unsafe-fixes" if self.suggests else ""
        parts = [
            f"{self.code} ({self.level}): {self.title}",
            self.why,
            self.example,
            f"better: {self.better}",
        ]
        return "\n\n".join([*parts, f"`olp lint {fix}` corrects it where it can."] if fix else parts)

    @final
    def finding(
        self,
        case: LintCase,
        line: int,
        message: str,
        help: str = "",
        *,
        fixes: tuple[tuple[int, int, str], ...] = (),
        numbers: dict[str, float | str] | None = None,
    ) -> OutcomeFinding:
        """A finding of this rule at a line of the program."""
        text = case.text(line) if line else ""
        return OutcomeFinding(
            self.code,
            self.level,
            message,
            case.path,
            line,
            len(text) - len(text.lstrip()) + 1,
            len(text.rstrip()) + 1,
            self.title,
            help,
            text,
            numbers=numbers or {},
            fixes=fixes,
        )


class RunRule(Rule):
    """A rule whose places are found while the program is planned and timed. `codes`: under which they are told.

    `maybe`: codes that need not be a mistake, told as notes.
    """

    codes: ClassVar[tuple[str, ...]] = ()
    maybe: ClassVar[tuple[str, ...]] = ()

    def find(self, case: LintCase) -> Iterator[OutcomeFinding]:
        for found in case.told(*self.codes):
            yield self.finding(case, found.line, found.message, found.help)
        for found in case.told(*self.maybe):
            note = self.finding(case, found.line, found.message, found.help)
            yield replace(note, level=Level.NOTE)


def all_rules() -> tuple[Rule, ...]:
    """One instance of every rule, sorted by code."""
    package = import_module("olp.checks.lint.rules")
    found: list[Rule] = []
    for module in iter_modules(package.__path__):
        for thing in vars(import_module(f"olp.checks.lint.rules.{module.name}")).values():
            own = isinstance(thing, type) and thing.__module__.endswith(f".{module.name}")
            if own and issubclass(thing, Rule) and thing.code:  # without one it is the base of others
                found.append(thing())
    return tuple(sorted(found, key=lambda rule: rule.code))
