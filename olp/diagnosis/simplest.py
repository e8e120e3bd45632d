"""Of all sets of terms that were fitted, the one with the fewest names that does nearly as well as the best."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from olp.diagnosis.fitting import Fit, Noise, fit
from olp.diagnosis.search import price
from olp.physics._case import Case

TELLING = 10.0  # in BIC, of each name: "very strong" by R. Kass and A. Raftery, JASA 90, 1995
SMALL = 0.01  # of the mean square that all names explain: what fewer names cannot do without is more


def simplest(fits: Sequence[Fit], case: Case, noise: Noise, tries: int, steps: int) -> Fit:
    """A term's form is never quite the robot's: what that leaves, a second name explains a little better than none.

    `fits`: the best first. Of each size the first `tries` sets are fitted in up to `steps` steps. A smaller set will do
    when each name more is worth less than `TELLING` in BIC, or moves the prediction by less than `SMALL` of it.
    """
    best = min((fit(f.model, case, noise, steps) for f in fits[:tries]), key=price)
    foretold = best.model.seconds(case)
    whole = float(np.mean((foretold - case.simulated) ** 2))
    for size in range(len(best.model.parts)):
        more = len(best.model.parts) - size
        will_do = []
        for one in [f for f in fits if len(f.model.parts) == size][:tries]:
            fitted = fit(one.model, case, noise, steps)
            off = float(np.mean((fitted.model.seconds(case) - foretold) ** 2))
            if worth(fitted, best) < TELLING * more or off < SMALL * more * whole:
                will_do.append(fitted)
        if will_do:
            return min(will_do, key=price)
    return best


def worth(fewer: Fit, best: Fit) -> float:
    """By how much the larger set is better in BIC; values that physics does not expect count against a set."""
    doubts = [
        sum(part.term.doubt(part.form, part.values) for part in fitted.model.parts)
        for fitted in (fewer, best)
    ]
    return fewer.bic + doubts[0] - best.bic - doubts[1]
