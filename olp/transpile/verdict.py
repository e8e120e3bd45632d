"""Whether a translation is proven: both programs ran to their end, and every step of both agrees.

What stands against it has a kind, and a reader may accept some: a difference that the receipt names at that line
("named"), a statement that is left out ("left-out"), runs that could not be compared to their end ("uncompared").
Nobody can accept a difference that the receipt does not name ("difference").
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

from olp.core.diagnostic import Diagnostic
from olp.runtime.machine import LIMIT
from olp.runtime.plan import Plan
from olp.runtime.state import ASSUMABLE
from olp.transpile.compare import Comparison, PlanDifference
from olp.transpile.context import Fate, Loss
from olp.transpile.pipeline import Translated

ACCEPTABLE: Final = ("named", "left-out", "uncompared")
# What the receipt names of a statement -> what of a step it explains.
_EXPLAINS: Final = {
    "speed": ("speed",),
    "acceleration": ("speed",),
    "override": ("speed",),
    "blend": ("blend",),
    "end": ("blend", "signal", "order"),
    "configuration": ("position", "orientation", "speed"),
    "joints": ("position", "orientation", "speed"),
    "base": ("position", "orientation"),
    "option": ("path", "orientation"),
    "wait": ("wait", "order"),
    "duration": ("wait", "signal", "order"),
}
_TURNED: Final = ("configuration", "joints")  # after which a joint move has another way
_FAILED: Final = ("I1", "I2", "I3")  # a statement that a run left out


class Objection(NamedTuple):
    """What stands against a translation. `line`: of the source, 0 the program as a whole."""

    kind: str
    line: int
    says: str


@dataclass(frozen=True, slots=True)
class Verdict:
    """`objections`: the worst kind first, in the order of the runs."""

    objections: tuple[Objection, ...] = ()

    @property
    def agrees(self) -> bool:
        return not self.objections

    def holds(self, accepted: Iterable[str] = ()) -> bool:
        """Whether nothing is left but what the reader accepts."""
        return {one.kind for one in self.objections} <= set(accepted)


def verdict_of(
    translated: Translated,
    plans: Sequence[Plan | None],
    comparisons: Sequence[Comparison],
    data_only: bool = False,
) -> Verdict:
    """`plans`: of the source and of the translation, None where it could not be run."""
    found = [
        *_differences(translated.losses, comparisons),
        *_left_out(translated.losses),
        *(() if data_only else _unfinished(plans, comparisons)),
    ]
    kinds = ("difference", *ACCEPTABLE)
    return Verdict(tuple(sorted(found, key=lambda one: kinds.index(one.kind))))


def _differences(losses: Sequence[Loss], comparisons: Sequence[Comparison]) -> Iterator[Objection]:
    named: dict[int, set[str]] = {}
    for loss in losses:
        if loss.fate is Fate.APPROXIMATED:
            named.setdefault(loss.line, set()).update(_EXPLAINS.get(loss.part, ()))
    turned = {loss.line for loss in losses if loss.part in _TURNED}
    for comparison in comparisons:
        before = 0
        for one in comparison.found:
            known = one.part in named.get(one.line, set()) or (
                one.part == "speed" and _follows(one, before, turned)
            )
            yield Objection("named" if known else "difference", one.line, one.says)
            before = one.line


def _follows(one: PlanDifference, before: int, turned: set[int]) -> bool:
    """Whether the joint move before a step ends with another arm configuration, as the receipt says."""
    return before in turned or any(line < one.line for line in turned if line > before)


def _left_out(losses: Sequence[Loss]) -> Iterator[Objection]:
    told: set[int] = set()
    for loss in losses:
        if loss.fate in (Fate.COMMENTED, Fate.REFUSED) and loss.line not in told:
            told.add(loss.line)
            yield Objection("left-out", loss.line, loss.says)


def _is_unfinished(found: Diagnostic) -> bool:
    """Whether a run left something out, or took what no file says for granted, so that the two may agree by chance."""
    return found.code in ASSUMABLE or (found.is_error and found.code.startswith(_FAILED))


def _unfinished(plans: Sequence[Plan | None], comparisons: Sequence[Comparison]) -> Iterator[Objection]:
    for name, plan in zip(("the source", "the translation"), plans, strict=False):
        if plan is None:
            yield Objection("uncompared", 0, f"{name} could not be run")
            continue
        for found in plan.diagnostics:
            if found.code == LIMIT or _is_unfinished(found):
                line = found.line if name == "the source" else 0
                where = "" if line else f" (its line {found.line})"
                yield Objection("uncompared", line, f"{name}{where}: {found.message}")
                break
    for comparison in comparisons:
        if comparison.until:
            says = "what runs from here on depends on a value that is not known here"
            yield Objection("uncompared", comparison.until, says)
