"""What a language can say and how long its words may be, one value per language."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from math import inf
from typing import Final

from olp.diagnostic import OlpError, error
from olp.expression import Store
from olp.moves import AccelerationUnit, BlendKind, SpeedUnit

Range = tuple[float, float]
_SAME: Final = 1e-6  # relative: so far outside, a number is still within


def within(value: float, bounds: Range) -> float:
    """The nearest number that `bounds` hold; `value` itself where they hold it."""
    low, high = bounds
    if low * (1.0 - _SAME) <= value <= high * (1.0 + _SAME):
        return value
    return low if value < low else high


def range_text(bounds: Range, scale: float, unit: str) -> str:
    """What bounds say, in `unit` (SI per unit: `scale`): the reason of a number that is not the source's."""
    low, high = (float(f"{bound / scale:.6g}") for bound in bounds)
    return f"only {low:g} to {high:g} {unit} can be said"


@dataclass(frozen=True, slots=True)
class Limits:
    """One language, as its manual bounds it. Lengths in characters, 0: no bound.

    `numbered`: how many variables of a kind there are where they have numbers and no names ({}: variables have
    names). `points`: how many taught points a file holds. `joint_speeds`, `path_speeds`, `blends`,
    `accelerations`: kinds that a single move can name. `modal_speed`: moves name no speed, a variable holds it.
    `tool_and_frame`: "move" (named by each), "modal" (a statement or variable before), "point" (taught with it),
    "tool" (a statement before for the tool; targets are in the base).
    """

    routine_name: int
    variable_name: int
    label_name: int
    line: int
    comment: int
    points: int
    statements: int
    joint_speeds: frozenset[SpeedUnit]
    path_speeds: frozenset[SpeedUnit]
    blends: frozenset[BlendKind]
    accelerations: frozenset[AccelerationUnit]
    modal_speed: bool
    tool_and_frame: str
    names: str = r"[A-Za-z_][A-Za-z0-9_]*"  # pattern of routine and variable names
    case_sensitive: bool = False
    numbered: Mapping[Store, int] = field(default_factory=dict)
    has_goto: bool = True
    has_if: bool = True
    has_while: bool = True
    has_repeat: bool = True
    has_for: bool = True
    has_break: bool = True
    has_continue: bool = False
    has_switch: bool = True
    has_functions: bool = True  # routines that return a value within an expression
    has_parameters: bool = True
    nested_expressions: bool = True  # more than one operator in an expression
    one_routine_per_file: bool = False
    has_data_files: bool = False  # files of data alone, which programs beside them use
    reserved: frozenset[str] = frozenset()  # words that no name may be, upper case
    external_axes: int = 6
    joint_blends: frozenset[BlendKind] | None = None  # of joint moves, where they differ
    has_override: bool = True  # a statement that scales all speeds
    has_elseif: bool = True
    has_endless: bool = True  # a WHILE whose condition always holds
    for_variable_is_local: bool = False  # FOR declares its variable, which ends with the loop
    has_relative: bool = True  # a move by an offset from where the arm stands
    nested_logic: bool = True  # AND and OR in parentheses
    for_step_is_one: bool = False  # FOR counts up or down by one and by nothing else
    has_configuration: bool = True  # a pose can say how the arm stands
    speed_steps: Mapping[SpeedUnit, float] = field(default_factory=dict)  # the finest that is written, SI
    speed_ranges: Mapping[SpeedUnit, Range] = field(default_factory=dict)  # what is taken, SI
    largest_turning: float = inf  # that a move can bound its turning to [rad/s]
    acceleration_range: Range = (0.0, inf)  # of a share of the rated acceleration
    largest_rates: Mapping[AccelerationUnit, float] = field(default_factory=dict)  # [m/s², rad/s²]
    blend_ranges: Mapping[BlendKind, Range] = field(
        default_factory=dict
    )  # of those that are no exact stop, SI
    acceleration_step: float = 0.0  # of a share of the rated acceleration; 0: any
    unprogrammed_acceleration: str = ""  # the note where the language's own default is not the rated one
    radius_step: float = 0.0  # of a blend [m]; 0: any
    bounds_turning: bool = False  # a move can bound how fast the tool turns
    pulse: float = 0.0  # [s] of a pulse that names no time; 0: each names one
    blends_may_overlap: bool = True  # the controller cuts two that meet; else it leaves a point out
    comment_swaps: Mapping[str, str] = field(
        default_factory=dict
    )  # what no comment or message holds -> what does


def limits_of(vendor: str) -> Limits:
    """The limits of a language. Raises OlpError (X010) for one that cannot be written."""
    try:
        limits = import_module(f"olp.vendors.{vendor}.limits").LIMITS
    except ModuleNotFoundError:
        raise OlpError(error("X010", f"olp cannot write '{vendor}'")) from None
    assert isinstance(limits, Limits)
    return limits
