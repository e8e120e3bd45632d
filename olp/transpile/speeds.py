"""Speeds in the target's units: percent of the axes, speed of the tool, of the leading axis, or a time.

A joint move's percent means another tool speed on every segment. The conversion takes each segment's own axis angles
from the plan and the rated axis speeds of both robots, so that it takes as long as it did.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from olp.core.units import deg, mm, percent
from olp.ir import program as st
from olp.ir import terminology
from olp.ir.expressions import Binary, Named, Number, Quantity, SystemValue
from olp.ir.transformer import edited, expressions_of
from olp.languages.limits import Limits, Range, range_text, within
from olp.robots.model import Robot
from olp.transpile.context import Fate, Loss, Segment, TranslationContext, walk_through
from olp.transpile.line_executions import LineExecutions, MoveExecution, moves_at_all

_SCALES: Final = {
    st.SpeedUnit.FRACTION: percent,
    st.SpeedUnit.TRAVEL: mm,
    st.SpeedUnit.TURN: deg,
    st.SpeedUnit.AXIS: 1.0,
    st.SpeedUnit.TIME: 1.0,
}
Told = tuple[tuple[str, float, str], ...]  # what the receipt says: why, how far off, in which unit
_UNITS: Final = {
    st.SpeedUnit.FRACTION: "%",
    st.SpeedUnit.TRAVEL: "mm/s",
    st.SpeedUnit.TURN: "deg/s",
    st.SpeedUnit.AXIS: "rad/s",
}
_SAME: Final = 1e-6  # relative: below this two speeds are one
_ORDER: Final = (
    st.SpeedUnit.AXIS,
    st.SpeedUnit.FRACTION,
    st.SpeedUnit.TRAVEL,
    st.SpeedUnit.TIME,
    st.SpeedUnit.TURN,
)
_USUAL: Final = (
    1.0  # [m/s] at full joint speed, where no move of the program tells; only for moves that never run
)
_USUAL_SPEED: Final = Quantity(Number(1000.0), mm)
_HARDLY: Final = 1.0 * mm  # [m/s] no move is that slow that goes anywhere
_NO_TURN: Final = (
    1e-4 * deg
)  # [rad] as finely as controllers hold angles: no speed of a turn has a meaning below
_HARDLY_TURNS: Final = 1.0 * deg  # [rad/s]
_LEAST, _MOST = 0.01, 1.0
_KEEP_BELOW: Final = "keep the speeds in these variables within what the controller takes"


def speeds(program: st.Program, work: TranslationContext) -> st.Program:
    """Every move's speed in a unit that the target has."""
    own = _Speeds(work, program)
    routines = tuple(
        replace(r, body=tuple([own.move(s) if type(s) is st.Move else s for s in r.body]))
        for r in program.routines
    )
    return replace(program, routines=routines)


@dataclass(slots=True)
class _Speeds:
    work: TranslationContext
    program: st.Program
    rows: LineExecutions = field(init=False)
    shown: dict[int, Segment] | None = None
    written: dict[int, tuple[st.Speed, Told, st.Speed]] = field(default_factory=dict)  # by the id of the last
    turn: Quantity | None = None  # the fastest turning that the target can bound moves to
    scaled: bool = False  # the robots differ, so that a percent of one is not a percent of the other

    def __post_init__(self) -> None:
        self.rows = LineExecutions(self.work)
        target = self.work.context.target_robot
        self.scaled = (
            target is not None and self.work.robot is not None and target.name != self.work.robot.name
        )

    def move(self, s: st.Statement) -> st.Statement:
        assert isinstance(s, st.Move)
        changes: dict[str, st.Speed | Quantity | None] = {}
        if s.turn is not None and (turn := self._turning(s, s.turn)) is not s.turn:
            changes["turn"] = turn
        if s.speed is not None and (new := self._said(s, s.speed)) is not s.speed:
            changes["speed"] = new
            if new.unit is not s.speed.unit and self._hardly_moves(new):
                changes["speed"], changes["turn"] = (
                    st.Speed(new.unit, _USUAL_SPEED),
                    self._in_place(s, s.speed),
                )
        return edited(s, changes) if changes else s

    def _said(self, s: st.Move, speed: st.Speed) -> st.Speed:
        if type(speed.value.written) is Number and not speed.value.written.value > 0:
            self.work.lose(s, Fate.REFUSED, "statement", "a speed of 0: the move never ends")
            return speed
        allowed = self.work.limits.joint_speeds if s.path is st.Path.JOINT else self.work.limits.path_speeds
        if st.SpeedUnit.AXIS in allowed:
            # URScript's moves by shares of all limits (optimovej) exist on few controllers.
            allowed = allowed - {st.SpeedUnit.FRACTION}
        if speed.unit not in allowed or (self.scaled and speed.unit is st.SpeedUnit.FRACTION):
            # A linear move with a share of the axes' speed means what it means; its time is what can be said.
            speed = self._converted(s, speed, allowed)
        if type(speed.value.written) is not Number:
            return self._counted(speed)
        known = self.written.get(id(speed))
        if known is None:
            known = self.written[id(speed)] = (
                *_written(speed, self.work.limits),
                speed,
            )  # which keeps its id
        for says, size, unit in known[1]:
            self.work.lose(s, Fate.APPROXIMATED, "speed", says, size, unit)
        return known[0]

    def _hardly_moves(self, speed: st.Speed) -> bool:
        value = speed.value.literal
        return speed.unit is st.SpeedUnit.TRAVEL and value is not None and value < _HARDLY

    def _in_place(self, s: st.Move, speed: st.Speed) -> Quantity | None:
        """How fast a joint move turns a tool that stays where it is: a speed along its way says nothing there."""
        value = speed.value.literal
        times = (
            [] if value is None else [(r.angle, self._time(speed.unit, value, r)) for r in self.rows.of(s)]
        )
        turning = max((angle / time for angle, time in times if time and angle == angle), default=0.0)
        if turning < _HARDLY_TURNS:
            says = "only axes move, the tool does not: no tool speed limits them"
            self.work.lose(s, Fate.APPROXIMATED, "speed", says)
            return s.turn
        return Quantity(Number(_clean(turning / deg)), deg)

    def _counted(self, speed: st.Speed) -> st.Speed:
        """A speed in a variable; a language whose variables are numbered takes it in its own unit alone."""
        scale = _SCALES[speed.unit]
        if not self.work.limits.numbered or abs(speed.value.scale / scale - 1.0) < _SAME:
            return speed
        factor = Number(_clean(speed.value.scale / scale))
        return st.Speed(speed.unit, Quantity(Binary("*", speed.value.written, factor), scale))

    def _turning(self, s: st.Move, turn: Quantity) -> Quantity | None:
        """The bound on the tool's turning that the target can say; told where it makes the move longer."""
        limits, bound = self.work.limits, turn.literal
        if limits.bounds_turning and (bound is None or bound <= limits.largest_turning * (1.0 + _SAME)):
            return turn
        if limits.bounds_turning:
            worst = 0.0 if bound is None else self._longer(s, limits.largest_turning, bound)
            says = f"the tool turns by {limits.largest_turning / deg:g} deg/s at most, which slows this move"
        else:
            worst = self._longer(s, bound, math.inf) if bound else 0.0
            says = "the bound on the tool's turning is left out, and would have slowed this move"
        if worst > _SAME:
            self.work.lose(s, Fate.APPROXIMATED, "speed", says, 100.0 * worst, "%")
        elif limits.bounds_turning and bound is not None:
            most, here = limits.largest_turning / deg, bound / deg
            self.work.note_once(
                f"the tool turns by {most:g} deg/s at most, where up to {here:g} deg/s are programmed: no move of the "
                "run takes longer for it"
            )
        if limits.bounds_turning and self.turn is None:
            self.turn = Quantity(Number(_clean(limits.largest_turning / deg)), deg)
        return self.turn

    def _longer(self, s: st.Move, bound: float, other: float) -> float:
        """By which share a bound on the turning makes a move longer than the other bound does. [rad/s]"""
        speed = None if s.speed is None else s.speed.value.literal
        if not speed or s.speed is None or s.speed.unit is not st.SpeedUnit.TRAVEL:
            return 0.0
        longest = 0.0
        for length, angle in self._segments(s):
            time = max(length / speed, angle / other)
            if time > 0.0:
                longest = max(longest, angle / bound / time - 1.0)
        return longest

    def _segments(self, s: st.Move) -> list[Segment]:
        """Length and turn of each execution: from the text where it shows them, else from the plan."""
        if self.shown is None:
            self.shown = walk_through(self.program, self.work).segments()
        known = self.shown.get(id(s))
        return [known] if known is not None else [(row.length, row.angle) for row in self.rows.of(s)]

    # --- other units ------------------------------------------------------------------------------------

    def _converted(self, s: st.Move, speed: st.Speed, allowed: frozenset[st.SpeedUnit]) -> st.Speed:
        unit = next(unit for unit in _ORDER if unit in allowed)
        value = speed.value.literal
        found = [row for row in self.rows.of(s) if moves_at_all(row)]
        if value is None:
            return self._by_variable(s, speed, unit, found)
        times = [self._time(speed.unit, value, row) for row in found]
        lost = [row for t, row in zip(times, found, strict=True) if t is None]
        # A way that is known and has no axes is out of reach: who wants a file all the same gets the move with a loss.
        beyond = self.work.context.on_loss != "comment" and any(row.length == row.length for row in lost)
        if lost and (self.work.robot is None or beyond):
            self.work.need_robot(s, "the speed of a joint move depends on its axes")
            return speed
        wanted = [self._value(s, unit, t, row) for t, row in zip(times, found, strict=True) if t is not None]
        known = [w for w in wanted if w is not None and math.isfinite(w) and w > 0.0]
        if not known:
            return self._guessed(s, speed, value, unit)
        slowest = max(known) if unit is st.SpeedUnit.TIME else min(known)
        spread = max(abs(w - slowest) / slowest for w in known)
        if spread > _SAME:
            says = "the move runs with several lengths: the slowest value is written"
            self.work.lose(s, Fate.APPROXIMATED, "speed", says, 100.0 * spread, "%")
        if unit is st.SpeedUnit.FRACTION and slowest > _MOST * (1 + _SAME):
            if self.scaled:
                says = "faster than the target's robot can"
                self.work.lose(s, Fate.APPROXIMATED, "speed", says, 100.0 * (slowest - _MOST), "%")
            slowest = _MOST  # its axes bound the source's move as well
        if (
            speed.unit is st.SpeedUnit.TIME
            and unit is not st.SpeedUnit.TIME
            and self.work.conventions.ramps_in_time
        ):
            says = f"{value:g} s for the whole move are written as the speed of its way: ramps come on top"
            self.work.lose(s, Fate.APPROXIMATED, "speed", says)
        return st.Speed(unit, Quantity(Number(_clean(slowest / _SCALES[unit])), _SCALES[unit]))

    def _time(self, unit: st.SpeedUnit, value: float, row: MoveExecution) -> float | None:
        """[s] that the segment takes at this speed, None where the robot has to be known for it."""
        if unit is st.SpeedUnit.TIME:
            return value
        if unit is st.SpeedUnit.TRAVEL:
            return row.length / value if row.length == row.length else None
        if unit is st.SpeedUnit.TURN:
            return row.angle / value if row.angle > _NO_TURN else 0.0
        robot = self.work.robot
        axes = row.axes[: len(robot.axes)] if robot is not None else row.axes[:6]
        if any(a != a for a in axes):
            return None
        if unit is st.SpeedUnit.AXIS:
            return max(axes) / value
        if robot is None:
            return None
        return max(a / (w * value) for a, w in zip(axes, _rated(robot), strict=False))

    def _value(self, s: st.Move, unit: st.SpeedUnit, time: float, row: MoveExecution) -> float | None:
        """The speed at which the segment takes `time` [s]."""
        if unit is st.SpeedUnit.TIME:
            return time
        if time <= 0.0:
            return None
        if unit is st.SpeedUnit.TRAVEL:
            return row.length / time
        if unit is st.SpeedUnit.TURN:
            return row.angle / time
        if unit is st.SpeedUnit.AXIS:
            return max(a for a in row.axes if a == a) / time if any(a == a for a in row.axes) else None
        robot = self.work.target_robot
        if robot is None:
            self.work.need_robot(s, "a share of the axes' speed means nothing without the robot")
            return None
        if any(a != a for a in row.axes[: len(robot.axes)]):
            if self.work.context.on_loss != "comment":
                self.work.need_robot(s, "a share of the axes' speed means nothing where they do not reach")
            return None
        return max(a / w for a, w in zip(row.axes, _rated(robot), strict=False)) / time

    def _guessed(self, s: st.Move, speed: st.Speed, value: float, unit: st.SpeedUnit) -> st.Speed:
        """For a move that the plan does not show, or that goes nowhere."""
        factor = self._factor(speed.unit, unit)
        if factor is None:
            self.work.need_robot(s, "the speed of a joint move depends on its axes")
            return speed
        guess = value * factor
        if unit is st.SpeedUnit.FRACTION:
            guess = min(max(guess, _LEAST), _MOST)
        executed = self.rows.of(s)
        stays = bool(executed) and not any(map(moves_at_all, executed))
        straight = executed and speed.unit is st.SpeedUnit.TURN
        where = "this run does not show its path"
        where = "the tool does not turn on its way" if straight else where
        where = "the move goes nowhere in this run" if stays else where
        if stays and speed.unit is st.SpeedUnit.TIME:
            says = f"{where}, and takes {value:g} s for it: here it takes no time"
            self.work.lose(s, Fate.APPROXIMATED, "speed", says, value, "s")
        else:
            says = f"{where}: {_said(speed.unit, value)} is taken for {_said(unit, guess)}"
            self.work.lose(s, Fate.APPROXIMATED, "speed", says)
        return st.Speed(unit, Quantity(Number(_clean(guess / _SCALES[unit])), _SCALES[unit]))

    def _factor(self, unit: st.SpeedUnit, other: st.SpeedUnit) -> float | None:
        """SI value in `other` per SI value in `unit`, for a move of which nothing is known."""
        full = {
            st.SpeedUnit.TRAVEL: _USUAL,
            st.SpeedUnit.FRACTION: 1.0,
            st.SpeedUnit.TIME: 1.0,
            st.SpeedUnit.TURN: 1.0,
        }
        if st.SpeedUnit.AXIS in (unit, other):
            robot = self.work.target_robot
            if robot is None:
                return None
            full[st.SpeedUnit.AXIS] = float(robot.speeds.min())
        return full[other] / full[unit]

    def _by_variable(
        self, s: st.Move, speed: st.Speed, unit: st.SpeedUnit, found: list[MoveExecution]
    ) -> st.Speed:
        """A speed that a variable holds: times a factor that holds for this segment."""
        factors = []
        for row in found:
            time = self._time(speed.unit, 1.0, row)
            value = None if time is None else self._value(s, unit, time, row)
            if (
                value and unit is not st.SpeedUnit.TIME and speed.unit is not st.SpeedUnit.TIME
            ):  # 0: it goes nowhere
                factors.append(value)
        factor = factors[0] if factors else self._factor(speed.unit, unit)
        if factor is None or st.SpeedUnit.TIME in (unit, speed.unit):
            self.work.lose(
                s, Fate.REFUSED, "speed", "a speed in a variable, in a unit that the target does not have"
            )
            return speed
        spread = max((abs(f - factor) / factor for f in factors), default=math.nan)
        if not spread <= _SAME:
            says = "a speed in a variable is multiplied by what holds for one segment"
            self.work.lose(s, Fate.APPROXIMATED, "speed", says, 100.0 * spread, "%")
        self._ask_to_keep_below(speed, unit, factor)
        scaled = speed.value.scale * factor / _SCALES[unit]
        return st.Speed(
            unit, Quantity(Binary("*", speed.value.written, Number(_clean(scaled))), _SCALES[unit])
        )

    def _ask_to_keep_below(self, speed: st.Speed, unit: st.SpeedUnit, factor: float) -> None:
        """The source's controller moves as fast as the axes can; another one refuses a number above its highest.

        `factor`: SI value in `unit` that is written per SI value of `speed`.
        """
        ranges = self.work.limits.speed_ranges
        highest = ranges[unit][1] if unit in ranges else _MOST if unit is st.SpeedUnit.FRACTION else math.inf
        names = {e.name for e in expressions_of(speed.value) if isinstance(e, Named)}
        if names and math.isfinite(highest):
            bound = _said(speed.unit, highest / factor)
            says = f"{' and '.join(sorted(names))}: up to {bound}, which is {_said(unit, highest)}"
            self.work.ask(_KEEP_BELOW, says)


def _written(speed: st.Speed, limits: Limits) -> tuple[st.Speed, Told]:
    """A literal speed that the target takes, in whole steps, and what is told of it."""
    value, scale, unit = speed.value.literal, _SCALES[speed.unit], _UNITS.get(speed.unit, "s")
    assert value is not None
    told: list[tuple[str, float, str]] = []
    bounds, step = limits.speed_ranges.get(speed.unit), limits.speed_steps.get(speed.unit)
    near = value if bounds is None else within(value, bounds)
    if bounds is not None and near != value:
        told.append((range_text(bounds, scale, unit), abs(near - value) / scale, unit))
    rounded = near if step is None else max(1, round(near / step)) * step
    if step is not None and abs(rounded - near) > _SAME * near:
        told.append((f"rounded to {step / scale:g} {unit}", abs(rounded - near) / scale, unit))
    if step is None and not told:
        return speed, ()
    written = _clean(rounded / scale)
    as_it_was = speed.value.scale == scale and speed.value.written in (Number(written), Number(int(written)))
    if as_it_was and not told:
        return speed, ()
    return st.Speed(speed.unit, Quantity(Number(int(written) if step == scale else written), scale)), tuple(
        told
    )


def _said(unit: st.SpeedUnit, value: float) -> str:
    return f"{value / _SCALES[unit]:.4g} {_UNITS.get(unit, 's')}"


def _rated(robot: Robot) -> list[float]:
    return [axis.speed for axis in robot.axes]


def _clean(value: float) -> float:
    """Without the noise of the conversion."""
    return float(f"{value:.9g}")


# --- Accelerations ---
# Programmed accelerations in the target's units: shares of the rated one, or values.

_ACCELERATIONS_UNITS: Final = {st.AccelerationUnit.TRAVEL: "m/s²", st.AccelerationUnit.AXIS: "rad/s²"}


def accelerations(program: st.Program, work: TranslationContext) -> st.Program:
    """Every move's accelerations as the target says them; what it cannot say is left out, with a loss."""
    says = work.limits.unprogrammed_acceleration
    joints = st.AccelerationUnit.AXIS in work.limits.accelerations
    if says and any(type(s) is st.Move and _is_free(s, joints) for s in program.statements()):
        work.notes.append(says)
    if not any(
        type(s) is st.Move and not (s.acceleration is None and s.deceleration is None and s.rate is None)
        for s in program.statements()
    ):
        return program
    own = _Accelerations(work)
    routines = tuple(
        replace(r, body=tuple([own.move(s) if type(s) is st.Move else s for s in r.body]))
        for r in program.routines
    )
    return replace(program, routines=routines)


@dataclass(slots=True)
class _Accelerations:
    """`known`: by the ids of a move's accelerations, that move, what became of them, and what is lost of it."""

    work: TranslationContext
    known: dict[tuple[object, ...], tuple[st.Move, dict[str, Any], list[Loss]]] = field(default_factory=dict)

    def move(self, s: st.Move) -> st.Move:
        """Moves share what modal statements set: what becomes of it does not depend on the move."""
        if s.acceleration is None and s.deceleration is None and s.rate is None:
            return s
        key = (s.path, id(s.acceleration), id(s.deceleration), id(s.rate))
        known = self.known.get(key)
        if known is None:
            losses = len(self.work.losses)
            made = _rounded(_within(_converted(s, self.work), self.work), self.work)
            changes = {name: getattr(made, name) for name in ("acceleration", "deceleration", "rate")}
            self.known[key] = (s, changes, self.work.losses[losses:])
            return made
        for loss in known[2]:
            self.work.lose(s, loss.fate, loss.part, loss.says, loss.size, loss.unit)
        return edited(s, known[1])


def _is_free(s: st.Move, joints: bool) -> bool:
    return (joints or s.path is not st.Path.JOINT) and s.acceleration is None and s.rate is None


def _within(s: st.Move, work: TranslationContext) -> st.Move:
    """The nearest accelerations that the target takes."""
    changes: dict[str, object] = {}
    for name in ("acceleration", "deceleration"):
        share: Quantity | None = getattr(s, name)
        near = None if share is None else _near(s, work, share, work.limits.acceleration_range, percent, "%")
        if near is not None:
            changes[name] = near
    largest = None if s.rate is None else work.limits.largest_rates.get(s.rate.unit)
    if s.rate is not None and largest is not None:
        near = _near(s, work, s.rate.value, (0.0, largest), 1.0, _ACCELERATIONS_UNITS[s.rate.unit])
        if near is not None:
            changes["rate"] = s.rate._replace(value=near)
    return edited(s, changes) if changes else s


def _near(
    s: st.Move, work: TranslationContext, value: Quantity, bounds: Range, scale: float, unit: str
) -> Quantity | None:
    """The nearest number within bounds, told with how far off it is; None where the value itself is within."""
    literal = value.literal
    near = literal if literal is None else within(literal, bounds)
    if literal is None or near is None or near == literal:
        return None
    off = abs(near - literal) / scale
    work.lose(s, Fate.APPROXIMATED, "acceleration", range_text(bounds, scale, unit), off, unit)
    return Quantity(Number(_accelerations_clean(near / scale)), scale)


def _rounded(s: st.Move, work: TranslationContext) -> st.Move:
    """As many decimals as the target writes."""
    step, share = work.limits.acceleration_step, s.acceleration
    value = None if share is None or not step else share.literal
    if value is None:
        return s
    rounded = max(1, round(value / step)) * step
    if abs(rounded - value) > _SAME * value:
        says = f"rounded to {step / percent:g} %"
        work.lose(s, Fate.APPROXIMATED, "acceleration", says, abs(rounded - value) / percent, "%")
    return edited(s, {"acceleration": Quantity(Number(_accelerations_clean(rounded / percent)), percent)})


def _converted(s: st.Move, work: TranslationContext) -> st.Move:
    allowed = work.limits.accelerations
    rated = _accelerations_rated(s, work)
    if s.rate is not None and s.rate.unit not in allowed:
        value = s.rate.value.literal
        s = edited(s, {"rate": None})
        if st.AccelerationUnit.FRACTION in allowed and rated and value is not None:
            return _bounded(
                edited(
                    s, {"acceleration": Quantity(Number(_accelerations_clean(100 * value / rated)), percent)}
                ),
                work,
            )
        says = "the acceleration is left out: what share of the rated one it is, is not known"
        work.lose(s, Fate.APPROXIMATED, "acceleration", says)
        return s
    if st.AccelerationUnit.FRACTION in allowed:
        return _one_share(s, work)
    return _as_rate(s, work, rated)


def _one_share(s: st.Move, work: TranslationContext) -> st.Move:
    """Braking and speeding up are one share where the target cannot tell them apart."""
    if s.deceleration is None or work.limits.separate_deceleration:
        return s
    share = s.acceleration or s.deceleration
    if share.literal != s.deceleration.literal or s.acceleration is None:
        which = "the first" if s.acceleration is not None else "that of braking"
        says = f"one share for speeding up and braking: {which} is written"
        work.lose(s, Fate.APPROXIMATED, "acceleration", says)
    return replace(s, acceleration=share, deceleration=None)


def _as_rate(s: st.Move, work: TranslationContext, rated: float | None) -> st.Move:
    share = s.acceleration or s.deceleration
    if share is None:
        return s
    s = edited(s, {"acceleration": None, "deceleration": None})
    unit = st.AccelerationUnit.AXIS if s.path is st.Path.JOINT else st.AccelerationUnit.TRAVEL
    if share is None or s.rate is not None:
        return s
    value = share.literal
    if value is None or rated is None or unit not in work.limits.accelerations:
        work.lose(s, Fate.APPROXIMATED, "acceleration", "the share of the rated acceleration is left out")
        return s
    return edited(
        s, {"rate": st.Acceleration(unit, Quantity(Number(_accelerations_clean(value * rated)), 1.0))}
    )


def _bounded(s: st.Move, work: TranslationContext) -> st.Move:
    assert s.acceleration is not None
    value = s.acceleration.literal
    if value is not None and value > 1.0:
        says = "more than the rated acceleration: 100 % is written"
        work.lose(s, Fate.APPROXIMATED, "acceleration", says, 100 * (value - 1.0), "%")
        return replace(s, acceleration=Quantity(Number(100), percent))
    return s


def _accelerations_rated(s: st.Move, work: TranslationContext) -> float | None:
    """[m/s²] or, of a joint move, [rad/s²]: the rated acceleration; None where no robot says it."""
    robot = work.target_robot
    if robot is None:
        return None
    if s.path is not st.Path.JOINT:
        return robot.linear_acceleration
    known = robot.accelerations[~np.isnan(robot.accelerations)]
    return float(known.min()) if len(known) else None


def _accelerations_clean(value: float) -> float:
    return float(f"{value:.9g}")


# --- Speed tables ---
# Speeds that a table of the controller holds: a variable that its operator sets.


def schedules(program: st.Program, work: TranslationContext) -> st.Program:
    """Speeds that stand in tables of the controller become one variable for each table."""
    names: dict[SystemValue, str] = {}
    routines = tuple(
        replace(r, body=tuple([_move(s, names, work) for s in r.body])) for r in program.routines
    )
    if not names:
        return program
    data = [st.Declare(0, name, "real", shared=True) for name in names.values()]
    return replace(program, routines=routines, data=(*program.data, *data))


def _move(s: st.Statement, names: dict[SystemValue, str], work: TranslationContext) -> st.Statement:
    if type(s) is not st.Move or s.speed is None:
        return s
    held = s.speed.value.written
    if type(held) is not SystemValue:
        return s
    name = names.get(held)
    if name is None:
        name = names[held] = work.fresh(terminology.state_variable(held.name))
        work.undeclared[name] = "real"  # both runs of the proof have the same speed there
    says = f"{terminology.value(held.name)} is not in the program: {name} has to be set, in mm/s"
    work.lose(s, Fate.APPROXIMATED, "speed", says)
    work.ask("set these variables, which have no values", f"{name} [mm/s]")
    return edited(
        s, {"speed": s.speed._replace(value=s.speed.value._replace(written=Named(name)), native="")}
    )
