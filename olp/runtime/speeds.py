"""How fast moves are: their own speed, or the one that holds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from olp.core.diagnostic import Severity
from olp.ir.expressions import Number, Quantity
from olp.ir.program import MovePart, Path, SetSpeed, Speed, SpeedUnit
from olp.runtime.evaluate import number, quantity
from olp.runtime.plan import PATHS
from olp.runtime.state import Machine, StatementError

FRACTION, TRAVEL, TURN, AXIS, TIME = 0, 1, 2, 3, 4
UNITS: Mapping[SpeedUnit, int] = {
    SpeedUnit.FRACTION: FRACTION,
    SpeedUnit.TRAVEL: TRAVEL,
    SpeedUnit.TURN: TURN,
    SpeedUnit.AXIS: AXIS,
    SpeedUnit.TIME: TIME,
}
PATH_CODES: Final[Mapping[Path, int]] = {path: code for code, path in enumerate(PATHS)}
JOINT: Final = PATH_CODES[Path.JOINT]
# Nobody says how fast a move without any speed is; the slowest taught presets of the controllers, so that a
# prediction from them stands out.
_DEFAULT_SPEED: Final = (0.0078, 0.011, 0.1, 0.1, 10.0)  # [1], [m/s], [rad/s], [rad/s], [s]
_SHOWN: Final = ("0.78 % of the rated joint speed", "11 mm/s", "0.1 rad/s", "0.1 rad/s", "10 s")
_HIGHEST: Final = (1.0, 1e3, 1e3, 1e3, 1e5)  # faster than any machine, longer than any move
_TOO_FAST: Final = (
    "a joint speed above 100 % is taken as 100 %",
    "a speed above 1000 m/s is taken as 1000 m/s",
    "a speed above 1000 rad/s is taken as 1000 rad/s",
    "a speed above 1000 rad/s is taken as 1000 rad/s",
    "a move of more than a day is taken to last a day",
)


def set_speed(m: Machine, s: SetSpeed) -> None:
    """Keeps the speeds for the moves that name none."""
    for speed in s.speeds:
        m.modal[UNITS[speed.unit]] = _checked(m, UNITS[speed.unit], quantity(m, speed.value))
    if s.turn is not None:
        m.turn = turn_rate(m, s.turn)


def turn_rate(m: Machine, turn: Quantity) -> float:
    """[rad/s] that a move turns its tool at no faster; a bound of zero would keep it from turning at all."""
    value = quantity(m, turn)
    return _checked(m, UNITS[SpeedUnit.TURN], value) if value <= 0.0 else value


def part_speed(m: Machine, part: MovePart, leading: tuple[int, float]) -> tuple[int, int, float]:
    """(path, unit, speed) of a further group; `leading`: unit and speed of the leading one.

    Without a speed of its own a group keeps step: on a joint path only its rated speed bounds it, on another one
    the leading speed does.
    """
    assert part.path is not None
    path = PATH_CODES[part.path]
    value = 0.0 if part.speed is None else quantity(m, part.speed.value)
    if part.speed is not None and value > 0.0:
        unit = UNITS[part.speed.unit]
        return path, unit, _checked(m, unit, value)
    # Generators write VJ=0.0 for a table that only keeps step.
    if path == JOINT or leading[0] == FRACTION:
        return JOINT, FRACTION, 1.0
    return path, *leading


def move_speed(m: Machine, speed: Speed | None, path: int) -> tuple[int, float]:
    """(unit, SI value) of a move's own speed, or of the one that holds."""
    if speed is None:
        return _modal_speed(
            m, FRACTION if path == JOINT and AXIS not in m.modal else AXIS if path == JOINT else TRAVEL
        )
    unit = UNITS[speed.unit]
    written, scale = speed.value
    value = (written.value if type(written) is Number else number(m, written)) * scale
    if not 0.0 < value <= _HIGHEST[unit]:
        value = _checked(m, unit, value)
    m.last[unit] = value
    return unit, value


def _modal_speed(m: Machine, unit: int) -> tuple[int, float]:
    value = m.modal.get(unit) or m.last.get(unit)
    if value is None:
        m.assume(f"no speed was set before this move: {_SHOWN[unit]} is taken")
        value = _DEFAULT_SPEED[unit]
    elif unit not in m.modal:
        m.assume("the move names no speed and none was set: that of the last move of its kind is taken")
    return unit, value


def _checked(m: Machine, unit: int, value: float) -> float:
    """A usable speed; the controller refuses others, here the nearest one is taken with a warning."""
    if 0.0 < value <= _HIGHEST[unit]:
        return value
    if value > 0.0:
        m.fault(StatementError("I302", _TOO_FAST[unit], "write a lower speed", Severity.WARNING))
        return _HIGHEST[unit]
    advice = "set the variable it comes from, in the program or in olp.toml"
    says = f"the speed is not above zero: {_SHOWN[unit]} is taken"
    m.fault(StatementError("I301", says, advice, Severity.WARNING))
    return _DEFAULT_SPEED[unit]


def share(m: Machine, value: float, what: str) -> float:
    """A fraction of the rated acceleration in (0, 1]."""
    if 0.0 < value <= 1.0:
        return value
    m.fault(
        StatementError(
            "I303", f"{what} of {value:.0%} is taken as 100 %", "write 1 .. 100 %", Severity.WARNING
        )
    )
    return 1.0
