"""Decimal fractions of points, rounded as `round` does, in less of the time: there are six in every point."""

from __future__ import annotations

from functools import lru_cache


def trimmed(value: float, decimals: int) -> str | None:
    """`value` with at most so many decimals (up to 11), without zeros behind them; None for 10,000 or more, and nan.

    A whole number ends with its point: languages say for themselves what stands there. Never "-0.".
    """
    if not -1e4 < value < 1e4:  # fifteen digits at most, which a float keeps
        return None
    text = f"{value:.{decimals}f}".rstrip("0")
    return "0." if text == "-0." else text


def all_trimmed(values: tuple[float, ...], decimals: int) -> list[str] | None:
    """`trimmed` of each of a point's values, in a third of the time; None where it is None for one of them."""
    if not (min(values) > -1e4 and max(values) < 1e4):
        return None
    text = _pattern(len(values), decimals) % values
    if "n" in text:  # nan is neither the least nor the greatest
        return None
    found = [one.rstrip("0") for one in text.split(",")]
    return ["0." if one == "-0." else one for one in found] if "-0." in found else found


@lru_cache(maxsize=100)
def _pattern(count: int, decimals: int) -> str:
    return ",".join([f"%.{decimals}f"] * count)
