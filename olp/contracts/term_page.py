"""What is written of a term, from the term itself: its section of `docs/physics.md`, and all its details for the tests.

Readers need the trace, the equations and the source. Bounds, starting values and sentences hang on the recording and
change with the code: they are kept beside the tests, where a change of any of them is seen.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from olp.timing.physics import Form, LogTerm, MoveTerm, Term, TermParameter
from olp.timing.physics._case import MeasuredMoves

_ROOT: Final = Path(__file__).resolve().parents[2]  # of a checkout
PAGE: Final = _ROOT / "docs" / "physics.md"
_ORDERS: Final = 3  # of the moves of a recording: how few tell a term hangs on which come first
_FOLLOWS: Final = ("of", "at", "that", "above")  # a meaning that goes on after the name without a comma
DETAILS: Final = _ROOT / "tests" / "data" / "physics_terms.txt"


def section(term: Term, cases: Sequence[MeasuredMoves]) -> str:
    """The section of a term on the page: each equation and each parameter that it has in any of `cases` once."""
    lines = [f"\n## {term.name}\n", f"{_sentence(term.does)}\n"]
    if (PAGE.parent / _picture(term)).exists():
        lines.append(f"![{term.name}]({_picture(term)})\n")
    if isinstance(term, MoveTerm):
        forms = [form for case in cases for form in term.forms(case)]
        lines += _equations(term, forms)
        lines += _meanings(
            p for form in forms for p in form.parameters if form.axis < 0 or _alone(form, forms)
        )
    if isinstance(term, LogTerm):
        lines.append(f"- in logs: ${term.equation}$")  # type: ignore[attr-defined]
        lines += _meanings(term.parameters)  # type: ignore[attr-defined]
    return "\n".join([*lines, f"\nSource: {_sentence(term.source)}\n"])


def _alone(form: Form, forms: Sequence[Form]) -> bool:
    """Whether a form of an axis is the first one, and no form of all axes explains its parameter."""
    axes = [one for one in forms if one.axis >= 0]
    names = {p.name for one in forms if one.axis < 0 for p in one.parameters}
    return form is axes[0] and not any(p.name.rsplit("_", 1)[0] in names for p in form.parameters)


def _equations(term: MoveTerm, forms: Sequence[Form]) -> Iterator[str]:
    """Each equation with the names of the forms that have it."""
    names: dict[str, dict[str, None]] = {}
    for form in forms:
        names.setdefault(form.equation, {})["one axis" if form.axis >= 0 else form.key or "plain"] = None
    if not forms:
        yield f"- ${term.equation}$, the lateness beside all other terms"  # type: ignore[attr-defined]
    for equation, those in names.items():
        which = "" if list(those) == ["plain"] else ", ".join(f"`{name}`" for name in those) + ": "
        yield f"- {which}${equation}$"


def _meanings(parameters: Iterable[TermParameter]) -> list[str]:
    """Each parameter once, also where moves of another kind give it in another unit; [] without parameters."""
    known: dict[tuple[str, str], str] = {}
    for p in parameters:
        unit = "" if p.unit == "1" else f" [{p.unit}]"
        follows = " " if p.meaning.split()[0] in _FOLLOWS else ", "
        known.setdefault((p.name, p.meaning), f"`{p.name}`{follows}{p.meaning}{unit}")
    return [f"    - {'; '.join(known.values())}"] if known else []


def details(term: Term, case: MeasuredMoves, others: Sequence[tuple[str, MeasuredMoves]]) -> str:
    """All of a term: its forms in a recording that tells everything, `case`, and what `others` have instead."""
    lines = [f"\n## {term.name}\n", f"{_sentence(term.summary)} Trace: {term.does}.\n"]
    if isinstance(term, MoveTerm):
        lines += _forms(term, case)
        lines += _elsewhere(term, case, others)
    if isinstance(term, LogTerm):
        lines.append(f"- in logs: ${term.equation}$")  # type: ignore[attr-defined]
        lines += [_parameter(p) for p in term.parameters]  # type: ignore[attr-defined]
    return "\n".join([*lines, f"\nSource: {_sentence(term.source)}\n"])


def _picture(term: Term) -> str:
    """Seen from the page."""
    return f"images/physics/{term.name}.svg"


def _forms(term: MoveTerm, case: MeasuredMoves) -> Iterator[str]:
    """A list of forms with their parameters; axes of one limit share a line."""
    forms = term.forms(case)
    if not forms:
        yield f"- ${term.equation}$, the lateness beside all other terms"  # type: ignore[attr-defined]
    yield from _listed(term, forms, case)


def _listed(term: MoveTerm, forms: Sequence[Form], case: MeasuredMoves) -> Iterator[str]:
    """Forms with their parameters; of those of single axes the first one whole, and the bounds of the others."""
    axes = [form.key for form in forms if form.axis >= 0]
    first = next((form for form in forms if form.axis >= 0), None)
    for form in forms:
        if form.axis >= 0 and form is not first:
            yield from (_parameter(p) for p in form.parameters)
            continue
        key = f"each of {', '.join(axes)}" if form.axis >= 0 else form.key
        yield f"- {key + ': ' if key else ''}${form.equation}$"
        yield from (_parameter(p) for p in form.parameters)
        yield from _search(term, form, case)


def _elsewhere(
    term: MoveTerm, case: MeasuredMoves, others: Sequence[tuple[str, MeasuredMoves]]
) -> Iterator[str]:
    """From how many moves on it is told, and which forms other recordings have instead."""
    forms = term.forms(case)
    fewest = next((n for n in range(1, len(case) + 1) if term.forms(case.take(np.arange(n)))), 0)
    if fewest:
        mixed = [np.random.default_rng(seed).permutation(len(case)) for seed in range(_ORDERS)]
        others_first = ", ".join(str(_fewest(term, case, order)) for order in mixed)
        yield f"- told from the first {fewest} of these moves on, in other orders from {others_first}"
    known = {_told(form) for form in forms}
    for name, other in others:
        there = term.forms(other)
        gone = [
            form.key or "the plain form" for form in forms if _told(form) not in {_told(one) for one in there}
        ]
        more = [
            form.key or "another plain form"
            for form in there
            if _told(form) not in {_told(one) for one in forms}
        ]
        if gone or more:
            less = f" without {', '.join(gone)}" if gone else ""
            and_ = f" with {', '.join(more)}" if more else ""
            yield f"- recordings {name}:{less}{';' if gone and more else ''}{and_}"
        new = [form for form in there if _told(form) not in known]
        known |= {_told(form) for form in there}
        yield from (f"    {line}" for line in _listed(term, tuple(new), other))


def _fewest(term: MoveTerm, case: MeasuredMoves, order: NDArray[np.int64]) -> int:
    """How many moves in this order tell the term: halving, as if more never told less."""
    return bisect_left(range(1, len(order)), True, key=lambda n: bool(term.forms(case.take(order[:n])))) + 1


def _told(form: Form) -> tuple[object, ...]:
    """What tells a form from others: bounds hang on the recording."""
    return form.key, form.equation, tuple((p.name, p.unit) for p in form.parameters)


def _search(term: MoveTerm, form: Form, case: MeasuredMoves) -> Iterator[str]:
    """Where the search begins, and what a diagnosis would say there; what values cost that physics does not expect."""
    guesses = np.asarray(term.guesses(form, case), dtype=float)
    starts = "; ".join(", ".join(_number(value) for value in guess) for guess in guesses.tolist())
    yield f"    - sought from {starts}"
    ends = [np.array([getattr(p, side) for p in form.parameters]) for side in ("low", "high")]
    says = dict.fromkeys(term.says(form, values, case) for values in (guesses[0], guesses[-1], ends[0]))
    yield from (f"    - “{words}”" for words in says)
    costs = [term.doubt(form, values) for values in (*ends, guesses[0])]
    if any(costs):
        when = "" if all(costs) else " where values are not expected"
        yield f"    - doubted by {_number(max(costs))} in BIC{when}"


def _parameter(p: TermParameter) -> str:
    null = "" if np.isnan(p.null) else f"; null {_number(p.null)}"
    unit = "" if p.unit == "1" else f" {p.unit}"
    how = ", by its logarithm" if p.log else ""
    return f"    - `{p.name}`, {p.meaning}: {_number(p.low)} to {_number(p.high)}{unit}{null}{how}"


def _number(value: float) -> str:
    return "∞" if np.isinf(value) else f"{value:.3g}"


def _sentence(text: str) -> str:
    first = text[0].upper() if text[1].isalpha() else text[0]
    return first + text[1:] + "."
