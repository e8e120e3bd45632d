"""What `docs/physics.md` says of a term: its section, from the term itself."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np

from olp.timing.physics import Form, LogTerm, MoveTerm, Parameter, Term
from olp.timing.physics._case import Case

PAGE: Final = Path(__file__).resolve().parents[2] / "docs" / "physics.md"  # of a checkout


def section(term: Term, case: Case) -> str:
    """The section of a term in a page of a recording that tells everything, `case`."""
    lines = [f"\n## {term.name}\n", f"{_sentence(term.summary)} Trace: {term.does}.\n"]
    if (PAGE.parent / _picture(term)).exists():
        lines.append(f"![How much later moves are by {term.name}]({_picture(term)})\n")
    lines += _forms(term, case) if isinstance(term, MoveTerm) else []
    if isinstance(term, LogTerm):
        lines.append(f"- in logs: ${term.equation}$")  # type: ignore[attr-defined]
        lines += [_parameter(p) for p in term.parameters]  # type: ignore[attr-defined]
    return "\n".join([*lines, f"\nSource: {_sentence(term.source)}\n"])


def _picture(term: Term) -> str:
    """Seen from the page."""
    return f"images/physics/{term.name}.svg"


def _forms(term: MoveTerm, case: Case) -> Iterator[str]:
    """A list of forms with their parameters; axes of one limit share a line."""
    forms = term.forms(case)
    if not forms:
        yield f"- ${term.equation}$, what remains late beside all other terms"  # type: ignore[attr-defined]
    axes = [form.key for form in forms if form.axis >= 0]
    first = next((form for form in forms if form.axis >= 0), None)
    for form in forms:
        if form.axis >= 0 and form is not first:
            continue
        key = f"each of {', '.join(axes)}" if form.axis >= 0 else form.key
        yield f"- {key + ': ' if key else ''}${form.equation}$"
        yield from (_parameter(p) for p in form.parameters)
        yield from _search(term, form, case)


def _search(term: MoveTerm, form: Form, case: Case) -> Iterator[str]:
    """Where the search begins, and what a diagnosis would say there; what values cost that physics does not expect."""
    guesses = np.asarray(term.guesses(form, case), dtype=float)
    starts = "; ".join(", ".join(_number(value) for value in guess) for guess in guesses.tolist())
    yield f"    - sought from {starts}"
    says = dict.fromkeys(term.says(form, guess, case) for guess in (guesses[0], guesses[-1]))
    yield from (f"    - “{words}”" for words in says)
    ends = [np.array([getattr(p, side) for p in form.parameters]) for side in ("low", "high")]
    costs = [term.doubt(form, values) for values in (*ends, guesses[0])]
    if any(costs):
        when = "" if all(costs) else " where values are not expected"
        yield f"    - doubted by {_number(max(costs))} in BIC{when}"


def _parameter(p: Parameter) -> str:
    null = "" if np.isnan(p.null) else f"; null {_number(p.null)}"
    unit = "" if p.unit == "1" else f" {p.unit}"
    return f"    - `{p.name}`, {p.meaning}: {_number(p.low)} to {_number(p.high)}{unit}{null}"


def _number(value: float) -> str:
    return "∞" if np.isinf(value) else f"{value:.3g}"


def _sentence(text: str) -> str:
    return text[0].upper() + text[1:] + "."
