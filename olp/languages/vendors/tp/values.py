"""TP's words for units, signals, elements and registers; the reader and the writer share them."""

from __future__ import annotations

from typing import Final

from olp.core.units import deg, mm
from olp.ir.expressions import Number, Quantity, Store
from olp.ir.program import Blend, BlendKind, Path, SpeedUnit

# Unit of a speed -> what it means, and SI per written unit.
UNITS: Final = {
    "%": (SpeedUnit.FRACTION, 0.01),
    "mm/sec": (SpeedUnit.TRAVEL, mm),
    "cm/min": (SpeedUnit.TRAVEL, 10.0 * mm / 60.0),
    "inch/min": (SpeedUnit.TRAVEL, 25.4 * mm / 60.0),
    "deg/sec": (SpeedUnit.TURN, deg),
    "sec": (SpeedUnit.TIME, 1.0),
    "msec": (SpeedUnit.TIME, 1e-3),
}
PERCENT: Final = 0.01
TICK: Final = 0.01  # [s] that $WAITTMOUT counts in
OVERRIDE: Final = "$MCR.$GENOVERRIDE"  # the system variable that OVERRIDE sets
TIMEOUT: Final = "$WAITTMOUT"
USUAL_TIMEOUT: Final = 3000  # [ticks] of a controller that nobody changed
FASTEST_LINE: Final = 2000.0  # [mm/s] that max_speed is bounded by on lines (manual: "Max Speed")

PATHS: Final = {"J": Path.JOINT, "L": Path.LINEAR, "C": Path.CIRCULAR, "A": Path.CIRCULAR, "S": Path.SPLINE}
BUSES: Final = {
    "DI": "in",
    "DO": "out",
    "RI": "robot-in",
    "RO": "robot-out",
    "GI": "in-group",
    "GO": "out-group",
    "AI": "analog-in",
    "AO": "analog-out",
    "SI": "panel-in",
    "SO": "panel-out",
    "UI": "system-in",
    "UO": "system-out",
    "WI": "weld-in",
    "WO": "weld-out",
    "WSI": "weld-stick-in",
    "WSO": "weld-stick-out",
    "F": "flag",
    "M": "marker",
}
ELEMENTS: Final = ("x", "y", "z", "rx", "ry", "rz", "e1", "e2", "e3")
STRING_FUNCTIONS: Final = {
    "STRLEN": "length-of-text",
    "FINDSTR": "position-in-text",
    "SUBSTR": "part-of-text",
}
FUNCTIONS: Final = {
    "SQRT": "sqrt",
    "SIN": "sin",
    "COS": "cos",
    "TAN": "tan",
    "ASIN": "asin",
    "ACOS": "acos",
    "ATAN": "atan",
    "ATAN2": "atan2",
    "ABS": "abs",
    "TRUNC": "trunc",
    "ROUND": "round",
    "LN": "log",
    "EXP": "exp",
}
# Motion groups: the first is the robot; the others are kept as positions of further mechanisms.
GROUP_STORES: Final = {1: Store.ROBOT, 2: Store.STATION, 3: Store.BASE, 4: Store.SYSTEM}

FINE: Final = Blend(BlendKind.RADIUS, Quantity(Number(0), mm), "FINE")
CORNERS: Final = {
    "CNT": (BlendKind.SPEED, PERCENT),
    "CR": (BlendKind.RADIUS, mm),
    "CD": (BlendKind.RADIUS, mm),
}


def number(text: str) -> int | float:
    """A literal as written: whole numbers stay whole."""
    return int(text) if text.isdigit() else float(text)
