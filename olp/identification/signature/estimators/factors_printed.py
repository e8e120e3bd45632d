"""The factor tables with the combination as the thesis prints it (6.18), a_y² counted twice."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from olp.identification.signature.estimators.factors import Factors

Floats = NDArray[np.float64]


class FactorsPrinted(Factors):
    """a_corr² = C_H² a_x² + (C_H² + C_V² - 1) a_y² + C_V² a_z² (6.18); not a number where that is negative."""

    summary = "Apostolovic's factor tables, inclined planes as printed (6.18)"

    def combined(self, parts: Floats, horizontal: Floats, vertical: Floats) -> Floats:
        x, y, z = (parts**2).T
        square = horizontal**2 * x + (horizontal**2 + vertical**2 - 1.0) * y + vertical**2 * z
        return np.asarray(np.sqrt(np.where(square > 0, square, np.nan)))
