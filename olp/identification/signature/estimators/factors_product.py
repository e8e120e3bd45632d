"""The factor tables with the long-term goal of the thesis in inclined planes: a product of factors (6.19)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from olp.identification.signature.estimators.factors import Factors

Floats = NDArray[np.float64]


class FactorsProduct(Factors):
    """a_corr = a C_V C_H … (6.19): both planes' factors multiply; along Y the same motion is corrected twice."""

    summary = "Apostolovic's factor tables, inclined planes by the product of factors (6.19)"

    def combined(self, parts: Floats, horizontal: Floats, vertical: Floats) -> Floats:
        return np.asarray(horizontal * vertical)
