"""Faults of meaning in a term of physics: what a careless author does, whatever the effect is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np

Planted = tuple[str, Callable[[], Callable[[], bool]]]


def _longer(before: Any, after: Any, factor: float) -> Any:
    """The motion whose durations are `factor` times what the term adds."""
    return after.with_(added=after.added + (factor - 1.0) * (after.duration() - before.duration()))


# (the motion before, the motion with the term, the case) -> another motion with the term
ACTS: Final[dict[str, Callable[[Any, Any, Any], Any]]] = {
    "it does nothing": lambda b, a, c: b,
    "it does 4 % too much": lambda b, a, c: _longer(b, a, 1.04),
    "it does the opposite": lambda b, a, c: _longer(b, a, -1.0),
    "it leaves the last moves out": lambda b, a, c: a.where(np.arange(len(a.way)) > 0.8 * len(a.way), b),
    "it leaves short moves out": lambda b, a, c: a.where((b.way > 0) & (b.way < np.median(b.way) / 4), b),
    "it takes a millisecond of its own": lambda b, a, c: a.with_(added=a.added + 1e-3),
    "waits take longer too": lambda b, a, c: a.with_(added=a.added + np.where(b.way > 0, 0.0, 0.02)),
    "durations that are no numbers": lambda b, a, c: a.with_(
        added=np.where(np.arange(len(a.way)) == 3, np.nan, a.added)
    ),
    "moves that are changed by looking": lambda b, a, c: _spoiled(b, a),
}
# a form -> another form
FORMS: Final[dict[str, Callable[[Any], Any]]] = {
    "a bound below its least value": lambda f: _first(f, lambda p: p._replace(low=p.high, high=p.low)),
    "another null": lambda f: _first(f, lambda p: p._replace(null=p.null + 0.3 * (p.high - p.null) + 1e-3)),
    "no unit": lambda f: _first(f, lambda p: p._replace(unit="?", meaning="")),
    "no equation": lambda f: f._replace(equation=""),
}


def _spoiled(before: Any, after: Any) -> Any:
    before.added[:] += 1e-6
    return after


def _first(form: Any, change: Callable[[Any], Any]) -> Any:
    """The form with its first parameter changed."""
    return form._replace(parameters=(change(form.parameters[0]), *form.parameters[1:]))


def term_faults(name: str) -> list[Planted]:
    """(what, plant) of every fault of a term of moves; a term of logs has words and columns only."""
    found = [(what, _plant_act(name, change)) for what, change in ACTS.items()]
    found += [(what, _plant_forms(name, change)) for what, change in FORMS.items()]
    words = {"no word of what it does": "does", "no source": "source", "no summary": "summary"}
    return found + [(what, _plant_word(name, word)) for what, word in words.items()]


def _kind(name: str) -> Any:
    from olp.timing.physics import load_term

    return type(load_term(name))


def _plant_act(name: str, change: Callable[[Any, Any, Any], Any]) -> Callable[[], Callable[[], bool]]:
    def plant() -> Callable[[], bool]:
        kind, changed = _kind(name), [False]
        whole = getattr(kind, "act", None)
        if whole is None:
            return lambda: False

        def act(self: Any, motion: Any, form: Any, values: Any, case: Any) -> Any:
            found = whole(self, motion, form, values, case)
            before = motion.added.copy()
            other = change(motion, found, case)
            changed[0] |= not np.array_equal(before, motion.added)
            changed[0] |= not np.array_equal(other.duration(), found.duration(), equal_nan=True)
            return other

        kind.act = act
        return lambda: changed[0]

    return plant


def _plant_forms(name: str, change: Callable[[Any], Any]) -> Callable[[], Callable[[], bool]]:
    def plant() -> Callable[[], bool]:
        kind, changed = _kind(name), [False]
        whole = getattr(kind, "forms", None)
        if whole is None:
            return lambda: False

        def forms(self: Any, case: Any) -> Any:
            found = whole(self, case)
            other = tuple(change(form) if form.parameters else form for form in found)
            changed[0] |= repr(other) != repr(found)
            return other

        kind.forms = forms
        return lambda: changed[0]

    return plant


def _plant_word(name: str, word: str) -> Callable[[], Callable[[], bool]]:
    def plant() -> Callable[[], bool]:
        setattr(_kind(name), word, "")
        return lambda: True

    return plant
