"""Other ways in which the same terms explain a case as well: other values of the same form, and other forms.

What the data do not choose between belongs into the intervals of all parameters that the ways have in common.
"""

from __future__ import annotations

from typing import NamedTuple

from olp.identification.diagnosis.fitting import ModelFit, Noise, evaluate, fit
from olp.identification.diagnosis.model import DurationModel, ModelPart
from olp.timing.physics._case import MeasuredMoves

ALIKE = 6.0  # in BIC: what is no worse than that is not told apart
_GUESSES = 2  # of a form, that are fitted
_SETTLED = 2.0  # in BIC: "not worth more than a bare mention" by R. Kass and A. Raftery, JASA 90, 1995
_STEPS = 12


class AlternativeModel(NamedTuple):
    """Parts stand in the same places as those of the best model, except the one at `place`, which is another."""

    fit: ModelFit
    worse: float  # in BIC
    place: int

    @property
    def part(self) -> ModelPart:
        return self.fit.model.parts[self.place]


def ways_of(best: ModelFit, case: MeasuredMoves, noise: Noise) -> list[AlternativeModel]:
    """The best fits in which one part has another form of its term, or starts elsewhere in its own, the best first."""
    found = list[AlternativeModel]()
    for index, part in enumerate(best.model.parts):
        if part.term.name == "cycle-quantisation":
            continue
        others = {p.label for k, p in enumerate(best.model.parts) if k != index}
        for form in part.term.forms(case):
            parts = [
                ModelPart(part.term, form, values, part.condition) for values in part.term.guesses(form, case)
            ]
            if not parts or parts[0].label in others or (form.axis >= 0) != (part.form.axis >= 0):
                continue
            models = [_replaced(best.model, index, other) for other in parts]
            models.sort(key=lambda model: evaluate(model, case, noise).loss)
            tried = [fit(model, case, noise, _STEPS) for model in models[:_GUESSES]]
            closest = min(tried, key=lambda f: f.bic)
            if closest.bic - best.bic < ALIKE:
                found.append(AlternativeModel(closest, max(closest.bic - best.bic, 0.0), index))
    return sorted(found, key=lambda way: way.worse)


def settled(best: ModelFit, case: MeasuredMoves, noise: Noise) -> ModelFit:
    """The same terms, each in the first of its forms that does as well with no more parameters: its plain law."""
    for index in range(len(best.model.parts)):
        part = best.model.parts[index]
        keys = [form.key for form in part.term.forms(case)]
        plainer = [
            way
            for way in ways_of(best, case, noise)
            if way.place == index
            and way.worse < _SETTLED
            and _key(way) in keys[: keys.index(part.form.key)]
            and len(way.part.values) <= len(part.values)
        ]
        if plainer:
            first = min(plainer, key=lambda way: keys.index(_key(way)))
            best = fit(first.fit.model, case, noise, 30)
    return best


def _key(way: AlternativeModel) -> str:
    return way.part.form.key


def _replaced(model: DurationModel, index: int, part: ModelPart) -> DurationModel:
    return DurationModel((*model.parts[:index], part, *model.parts[index + 1 :]))
