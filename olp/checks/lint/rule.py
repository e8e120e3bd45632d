"""Base class of all rules, the list of rules (the files of `rules/`), and the input that they check."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cached_property, lru_cache
from importlib import import_module
from pkgutil import iter_modules
from typing import Any, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic
from olp.ir.expressions import Named, Taught
from olp.ir.program import Path, Program, Routine, Statement
from olp.reports.outcome.model import Level, OutcomeFinding
from olp.runtime.plan import PATHS, Plan, StepKind
from olp.timing.result import Timing

_JOINT = PATHS.index(Path.JOINT)
_TURN_DEG = 5.0  # less is within what a slow line needs anyway
_ONLY_TURNS_MM = 5.0  # a shorter move is meant to turn
_SLOWED = 0.7
_STEEP_DEG_PER_MM = 0.5


@dataclass(frozen=True)
class LintCase:
    """Input of the rules. `timing` covers the whole run; rules check the steps of this file only (`own`), called
    files are judged separately.
    """

    program: Program
    timing: Timing

    @property
    def plan(self) -> Plan:
        return self.timing.plan

    @property
    def path(self) -> str:
        return self.program.path

    def text(self, line: int) -> str:
        return self.program.source.line(line)

    @cached_property
    def steps(self) -> list[int]:
        """Steps of MOVE kind in this file, in order of execution."""
        plan = self.plan
        return np.flatnonzero((plan.kind == StepKind.MOVE) & (plan.source == 0)).tolist()

    def row(self, step: int) -> int:
        """The leading row in `plan.moves` of a step."""
        return int(self.plan.row[step])

    def on_path(self, step: int) -> bool:
        """Whether a step is a line, an arc or a spline."""
        return self.plan.kind[step] == StepKind.MOVE and int(self.plan.moves.path[self.row(step)]) != _JOINT

    @cached_property
    def lines(self) -> dict[int, list[int]]:
        """The steps of each line of this file."""
        found: dict[int, list[int]] = {}
        for step in self.steps:
            found.setdefault(int(self.plan.line[step]), []).append(step)
        return found

    @cached_property
    def statements(self) -> dict[int, Statement]:
        """The first statement of each line."""
        found: dict[int, Statement] = {}
        for statement in self.program.statements():
            found.setdefault(statement.line, statement)
        return found

    def turn(self, before: int, after: int) -> float:
        """Angle [rad] between the tool's directions in two steps, nan where one of them does not travel."""
        first, second = self._way(before), self._way(after)
        cosine = float(np.dot(first, second))
        return float(np.arccos(np.clip(cosine, -1.0, 1.0))) if np.isfinite(cosine) else float("nan")

    def _way(self, step: int) -> NDArray[np.float64]:
        moves, place = self.plan.moves, self.plan.positions.position
        row = self.row(step)
        way = place[int(moves.target[row])] - place[int(moves.start[row])]
        with np.errstate(divide="ignore", invalid="ignore"):
            unit: NDArray[np.float64] = way / np.linalg.norm(way)
        return unit

    def turn_rules(self, step: int) -> bool:
        """Whether reorientation limits a path move: it is slower than its length alone would allow.

        From rest to rest a length s allows the speed sqrt(s a), or the programmed one.
        """
        timing = self.timing
        angle, way = float(timing.angle_deg[step]), float(timing.distance_mm[step])
        if not (self.on_path(step) and angle >= _TURN_DEG and way > _ONLY_TURNS_MM):
            return False
        if timing.limited_by[step].startswith("orientation"):
            return True
        possible = min(float(timing.speed_mm_s[step]), float(np.sqrt(way * self.acceleration)))
        slow = float(timing.reached_mm_s[step]) < _SLOWED * possible
        return slow and angle > _STEEP_DEG_PER_MM * way

    @cached_property
    def acceleration(self) -> float:
        """Highest acceleration [mm/s²] of the program's path moves, nan if there are none."""
        known = self.timing.accel_mm_s2[[step for step in self.steps if self.on_path(step)]]
        return float(np.nanmax(known)) if np.isfinite(known).any() else float("nan")

    def told(self, *codes: str) -> Iterator[Diagnostic]:
        """Diagnostics with these codes from reading, running and timing this file."""
        for found in self.timing.diagnostics:
            if found.code in codes and found.file in ("", self.path):
                yield found


def case_of(program: Program, timing: Timing) -> LintCase:
    return LintCase(program, timing)


def routines(case: LintCase) -> tuple[Routine, ...]:
    return case.program.routines


def mentioned(thing: Any) -> Iterator[Taught | Named]:
    """Every taught point and every name in a statement or expression."""
    left = [thing]
    while left:
        it = left.pop()
        if isinstance(it, (Taught, Named)):
            yield it
        elif isinstance(it, tuple):
            left.extend(reversed(it))
        else:
            left.extend([getattr(it, name) for name in _parts(type(it))])  # type: ignore[arg-type]


@lru_cache(maxsize=1024)
def _parts(kind: type) -> tuple[str, ...]:
    """The fields of a class that may hold further nodes, the last one first; empty if it is not a dataclass."""
    return tuple(field.name for field in reversed(fields(kind))) if is_dataclass(kind) else ()


# First line, last line, the lines that take their place ("": none), and what that does in a few words.
Suggestion = tuple[int, int, str, str]


class Rule(ABC):
    """A mistake that a program can contain.

    `code` never changes. `why`: its cost, in a paragraph; `example` and `better`: lines with and without it.
    `fixable`: whether findings can carry a change that alters neither path nor time. `suggests`: whether there are
    changes that do, for users to choose.
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
        """Findings where the program contains the mistake, in order of lines."""

    def suggest(self, program: Program, found: OutcomeFinding) -> Iterator[Suggestion]:
        """Changes that would fix a finding of this rule but alter the motion or its time, the best one first."""
        yield from ()

    @final
    def explained(self) -> str:
        """Help text of the rule: what it is, why, an example and the better version."""
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
    """A rule whose findings come from planning and timing the program. `codes`: of their diagnostics.

    `maybe`: codes that need not be a mistake; they are reported as notes.
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
