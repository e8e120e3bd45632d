"""Decimal fractions of points, rounded as `round` does, in less of the time: there are six in every point."""

from __future__ import annotations


def trimmed(value: float, decimals: int) -> str | None:
    """`value` with at most so many decimals (up to 11), without zeros behind them; None for 10,000 or more, and nan.

    A whole number ends with its point: languages say for themselves what stands there. Never "-0.".
    """
    if not -1e4 < value < 1e4:  # fifteen digits at most, which a float keeps
        return None
    text = f"{value:.{decimals}f}".rstrip("0")
    return "0." if text == "-0." else text
