"""What a program does, step by step, in SI: what a contract compares instead of texts or of olp's own plans."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, Final

import numpy as np

from olp.contracts.oracle import MM, Array, Circle, angle_between, circle, of_quaternion
from olp.ir.expressions import Compare, Expression, Named, Number, Signal, SignalState, Text
from olp.ir.program import Path, Program, PulseOutput, SetOutput, Wait
from olp.languages.vendor import Vendor
from olp.robots import EXAMPLE_ROBOT
from olp.robots.kinematics.configuration import forward
from olp.robots.model import Robot
from olp.robots.robot import load_robot
from olp.runtime.plan import PATHS, BlendCode, Plan, StepKind
from olp.timing.blending.law import load_law

ROBOT: Final = EXAMPLE_ROBOT
LENGTH: Final = 5e-6  # [m] that decimals of a text may take from a place
ANGLE: Final = 8e-6  # [rad]
_RATIO: Final = 2e-4  # of a speed
_ROUNDED: Final = 0.025  # of a speed that a receipt says to be rounded
_STILL: Final = 2e-6  # [m] a shorter move goes nowhere


@dataclass(frozen=True, slots=True, eq=False)
class OracleEvent:
    """One thing that happens. `kind`: joint, linear, arc, wait, output or input.

    `via` (3,) [m]: where an arc goes through; `beyond`: it lies behind its end on the same circle, as `Moves.via` does.
    `place` (4, 4): the tool centre point in the base; `flange` (4, 4): the flange, which shows the tool. `axes` [rad]:
    asked of joint targets. `share` [1], `axis` [rad/s]: speed of a joint move; `speed` [m/s]. `blend` [m], 0 an exact
    stop, nan: rounded, no size known. `seconds`: of a wait. `signal`, `on`: of signals, `signal` by number or name.
    nan, None and "" are not compared. `loose`: fields that a receipt says to be approximated,
    "stop" where the move may stop exactly.
    """

    kind: str
    place: Array | None = None
    flange: Array | None = None
    axes: tuple[float, ...] = ()
    via: Array | None = None
    beyond: bool = False
    share: float = math.nan
    axis: float = math.nan
    speed: float = math.nan
    asked: float = math.nan  # [s] that a joint move's speed asks for, as found
    needs: tuple[float, float, float] = (
        math.nan,
    ) * 3  # of it: [s] at full speed, [rad] of the leading axis, [m]
    blend: float = math.nan
    seconds: float = math.nan
    signal: int | str = ""
    on: bool | None = None
    line: int = 0
    loose: frozenset[str] = field(default=frozenset())


@lru_cache(maxsize=4)
def robot_of(name: str = ROBOT) -> Robot:
    return load_robot(name)


# --- what a plan says ---------------------------------------------------------------------------------------


def events_of(program: Program, plan: Plan, vendor: Vendor) -> list[OracleEvent]:
    """The events of a plan. Moves that go nowhere and waits of no time are left out, halves of arcs put together."""
    said = [_by_line(program if at == 0 else vendor.read(source)) for at, source in enumerate(plan.sources)]
    found: list[OracleEvent] = []
    via: Array | None = None
    for at in range(len(plan)):
        kind, row, line = StepKind(int(plan.kind[at])), int(plan.row[at]), int(plan.line[at])
        if kind is not StepKind.MOVE:
            statements = said[int(plan.source[at])].get(line, ())
            found += _signal_or_wait(kind, float(plan.durations[row]), statements, line, vendor)
            continue
        if _goes_nowhere(plan, row) and any(e.kind in ("joint", "linear", "arc") for e in found):
            continue
        half = _first_half(plan, at)
        if half is not None:
            via = half
            continue
        found.append(_move(plan, row, line, via))
        via = None
    return found


def _by_line(program: Program) -> Mapping[int, tuple[Any, ...]]:
    constants = {d.name: d.value for d in program.declarations()}
    found: dict[int, tuple[Any, ...]] = {}
    for one in program.statements():
        if isinstance(one, SetOutput | PulseOutput):
            signal = one.signal
            if isinstance(signal.index, Named):
                signal = Signal(signal.bus, constants.get(signal.index.name) or signal.index, signal.part)
            one = SetOutput(one.line, signal, one.value if isinstance(one, SetOutput) else SignalState(True))
        found[one.line] = (*found.get(one.line, ()), one)
    return found


def _signal_or_wait(
    kind: StepKind, seconds: float, statements: Sequence[Any], line: int, vendor: Vendor
) -> Iterator[OracleEvent]:
    if kind is StepKind.SIGNAL:
        yield from (
            OracleEvent("output", signal=_number(s.signal, vendor), on=_state(s.value), line=line)
            for s in statements
            if isinstance(s, SetOutput)
        )
        return
    asked = [one for one in statements if isinstance(one, Wait)]
    if asked:
        source, signal, on = _asked(asked[0].condition, vendor)
        yield OracleEvent(source, signal=signal, on=on, line=line)
    elif seconds > 0.0:
        yield OracleEvent("wait", seconds=seconds, line=line)


def _number(signal: Signal, vendor: Vendor) -> int | str:
    """By number, or by name; those that the language counts anew behind the usual ones by the number that they had."""
    if isinstance(signal.index, Number):
        further = (one for rows in vendor.conventions.counted_signals.values() for one in rows)
        first = next((first for first, bus in further if bus == signal.bus), 0)
        return first + int(signal.index.value)
    return signal.index.value if isinstance(signal.index, Text) else str(signal.index)


def _state(value: Expression) -> bool | None:
    if isinstance(value, SignalState):
        return value.on
    return bool(value.value) if isinstance(value, Number) else None


def _asked(condition: Expression, vendor: Vendor) -> tuple[str, int | str, bool | None]:
    """What a condition waits for, an input or the program's own output, and its state."""
    asked: Expression = condition
    on: bool | None = True
    if isinstance(condition, Compare):
        asked, right = condition.left, _state(condition.right)
        on = right if condition.operator == "=" or right is None else not right
    if not isinstance(asked, Signal):
        return "input", str(condition), None
    return "own output" if asked.bus.endswith("out") else "input", _number(asked, vendor), on


def _goes_nowhere(plan: Plan, row: int) -> bool:
    a, b = int(plan.moves.start[row]), int(plan.moves.target[row])
    apart = plan.positions.position[a] - plan.positions.position[b]
    turn = np.abs(plan.positions.quaternion[a] - plan.positions.quaternion[b])
    return a == b or (float(np.abs(apart).max()) < _STILL and float(turn.max()) < _STILL)


def _first_half(plan: Plan, at: int) -> Array | None:
    """Where the first half of an arc ends that is written as a chain of points: what the arc goes through."""
    moves, row = plan.moves, int(plan.row[at])
    if PATHS[int(moves.path[row])] is not Path.CIRCULAR or int(moves.via[row]) < 0 or moves.before[row]:
        return None
    if at + 1 >= len(plan) or plan.kind[at + 1] != StepKind.MOVE:
        return None
    following = int(plan.row[at + 1])
    continues = PATHS[int(moves.path[following])] is Path.CIRCULAR and bool(moves.before[following])
    there: Array = plan.positions.position[int(moves.target[row])]
    return there if continues else None


def _move(plan: Plan, row: int, line: int, via: Array | None) -> OracleEvent:
    moves, positions, robot = plan.moves, plan.positions, plan.robot
    start, target, middle = int(moves.start[row]), int(moves.target[row]), int(moves.via[row])
    path = PATHS[int(moves.path[row])]
    if path is Path.CIRCULAR and via is None and middle < 0:
        path = Path.LINEAR
    kind = {Path.JOINT: "joint", Path.LINEAR: "linear", Path.CIRCULAR: "arc"}.get(path, str(path))
    code = BlendCode(int(moves.blend_code[row]))
    known = code is BlendCode.RADIUS or (code is BlendCode.ZONE and not load_law(plan.zone_law).share_zones)
    axes, travel = positions.axes[target], float(moves.travel[row])
    turned = np.abs(axes - positions.axes[start])
    count = len(robot.axes) if robot is not None else 0
    asked, needs = math.nan, (math.nan,) * 3
    if robot is not None and kind == "joint":
        least = float((turned[:count] / robot.speeds).max())
        needs = (least, float(turned[:count].max()), float(moves.length[row]))
        asked = _seconds(
            needs,
            float(moves.fraction[row]),
            float(moves.axis_speed[row]),
            travel,
            float(moves.duration[row]),
        )
    return OracleEvent(
        kind,
        _pose(positions.position[target], positions.quaternion[target]),
        None if robot is None else _flange(robot, axes[:count]),
        tuple(axes[:count].tolist()),
        via if via is not None else positions.position[middle] if middle >= 0 and kind == "arc" else None,
        via is None,
        share=float(moves.fraction[row]),
        axis=float(moves.axis_speed[row]),
        speed=travel,
        asked=asked,
        needs=needs,
        blend=0.0 if code is BlendCode.EXACT else float(moves.blend[row]) if known else math.nan,
        line=line,
    )


def _seconds(
    needs: tuple[float, float, float], share: float, axis: float, speed: float, duration: float = math.nan
) -> float:
    """[s] that the programmed speed of a joint move asks for, no less than its axes need."""
    least, turn, length = needs
    asked = (least / share, max(turn / axis, least), max(length / speed, least), max(duration, least))
    return next((one for one in asked if not math.isnan(one)), math.nan)


def _pose(position: Array, quaternion: Array) -> Array:
    made = np.eye(4)
    made[:3, 3] = position
    made[:3, :3] = of_quaternion(*quaternion)
    return made


def _flange(robot: Robot, axes: Array) -> Array | None:
    if np.isnan(axes).any():
        return None
    position, rotation = forward(robot, axes[None, :])
    made = np.eye(4)
    made[:3, 3], made[:3, :3] = position[0], rotation[0]
    return made


# --- comparing ----------------------------------------------------------------------------------------------


def differences(wanted: Sequence[OracleEvent], found: Sequence[OracleEvent]) -> Iterator[str]:
    """What differs, a sentence each; up to the first event of another kind, behind which nothing fits."""
    names: dict[str, int | str] = {}
    before: OracleEvent | None = None
    for at, (a, b) in enumerate(zip(wanted, found, strict=False), 1):
        where = f"event {at} of {len(wanted)} (line {b.line})"
        if a.kind != b.kind:
            yield f"{where}: {_shown(a)} is wanted and {_shown(b)} found"
            return
        yield from (f"{where}, a {a.kind}: {text}" for text in _of_event(a, b, before, names))
        before = b if b.place is not None else before
    if len(wanted) != len(found):
        yield f"{len(wanted)} events are wanted and {len(found)} found"


def stopped_by_advance(events: Sequence[OracleEvent], *vendors: Vendor) -> list[OracleEvent]:
    """The events where the arm may stop exactly at a blend.

    Those are moves before a wait, where a controller of one of `vendors` stops there (`Vendor.advance_stops`) before a
    signal too, and moves like them right before, which may be the same statement of a loop.
    """
    signals = ("output", "input") if any(vendor.advance_stops for vendor in vendors) else ()
    stands = False  # whether a wait comes before the next move
    found: list[OracleEvent] = []
    after: OracleEvent | None = None
    for event in reversed(events):
        waits = stands or (after is not None and after.kind in signals)
        same = after is not None and "stop" in after.loose and _alike(event, after)
        if event.blend > 0.0 and (waits or same):
            event = replace(event, loose=event.loose | {"stop"})
        found.insert(0, event)
        stands = event.kind == "wait" or (stands and event.kind in ("output", "input"))
        after = event
    return found


def _alike(a: OracleEvent, b: OracleEvent) -> bool:
    return (a.kind, a.blend, a.speed) == (b.kind, b.blend, b.speed)


def _shown(event: OracleEvent) -> str:
    if event.signal != "":
        return f"{event.kind} {event.signal} {'on' if event.on else 'off'}"
    return f"{event.kind} of {event.seconds:g} s" if event.kind == "wait" else f"{event.kind} move"


def _of_event(
    a: OracleEvent, b: OracleEvent, before: OracleEvent | None, names: dict[str, int | str]
) -> Iterator[str]:
    yield from _of_places(a, b, before)
    yield from _of_numbers(a, b)
    if a.signal != "":
        # A language that names its signals gives one name to one number, and a number in the name is that one.
        same = (
            names.setdefault(b.signal, _named_number(b.signal, a.signal))
            if isinstance(b.signal, str)
            else b.signal
        )
        if same != a.signal:
            yield f"signal {a.signal} is wanted and {b.signal} found"
        if a.on is not b.on:
            yield f"the state {a.on} is wanted and {b.on} found"


def _named_number(name: str, wanted: int | str) -> int | str:
    """The number that a signal's name ends with where a number is wanted, else what is wanted: do3 is signal 3.

    >>> _named_number("do4", 3), _named_number("doGrip", 3), _named_number("do4", "gripper")
    (4, 3, 'gripper')
    """
    digits = re.search(r"\d+$", name)
    return int(digits[0]) if digits and isinstance(wanted, int) else wanted


def _of_places(a: OracleEvent, b: OracleEvent, before: OracleEvent | None) -> Iterator[str]:
    if a.place is not None:
        yield from _of_frames("the tool centre point", a.place, b.place, 1.0)
    if a.flange is not None:
        yield from _of_frames("the flange (it shows the tool)", a.flange, b.flange, 3.0)
    if a.axes and "axes" not in a.loose:
        apart = (
            float(np.abs(np.array(a.axes) - np.array(b.axes[: len(a.axes)])).max()) if b.axes else math.nan
        )
        if not apart <= ANGLE:
            yield f"the axes are {apart:g} rad apart"
    if a.via is not None and a.place is not None:
        if b.via is None or before is None or before.place is None:
            yield "the arc has no point that it goes through"
            return
        one, other = (_circle(before.place, e.via, a.place, e.beyond) for e in (a, b) if e.via is not None)
        apart = float(np.linalg.norm(one.centre - other.centre))
        if not apart <= 20 * LENGTH or not float(one.axis @ other.axis) > 1.0 - 1e-6:
            yield f"the arc's centre is {apart / MM:g} mm off, or it turns the other way"


def _circle(start: Array, via: Array, end: Array, beyond: bool) -> Circle:
    order = (end[:3, 3], via) if beyond else (via, end[:3, 3])
    return circle(start[:3, 3], *order)


def _of_frames(what: str, a: Array, b: Array | None, factor: float) -> Iterator[str]:
    if b is None or np.isnan(b).any():
        yield f"{what} is not known"
        return
    apart = float(np.linalg.norm(a[:3, 3] - b[:3, 3]))
    turn = angle_between(a[:3, :3], b[:3, :3])
    if apart > LENGTH * factor:
        yield f"{what} is {apart / MM:.4g} mm off"
    if turn > ANGLE * factor:
        yield f"{what} is turned by {math.degrees(turn):.4g} deg"


def _of_numbers(a: OracleEvent, b: OracleEvent) -> Iterator[str]:
    pairs = [(a.speed, b.speed, "m/s"), (a.seconds, b.seconds, "s")]
    if a.kind == "joint":
        same = [
            (a.share, b.share, "of the axes' speed"),
            (a.axis, b.axis, "rad/s"),
            (a.speed, b.speed, "m/s"),
        ]
        pairs = [one for one in same if not math.isnan(one[0]) and not math.isnan(one[1])]
        if not pairs:
            # Another kind of speed is the same when the move takes as long.
            pairs = [(_seconds(b.needs, a.share, a.axis, a.speed), b.asked, "s at the programmed speed")]
    for x, y, unit in pairs:
        if not math.isnan(x) and not abs(x - y) <= (_ROUNDED if "speed" in a.loose else _RATIO) * abs(x):
            yield f"{x:.6g} {unit} is wanted and {y:.6g} found"
    yield from _of_blends(a, b)


def _of_blends(a: OracleEvent, b: OracleEvent) -> Iterator[str]:
    if math.isnan(a.blend) or ("stop" in a.loose and b.blend == 0.0):
        return
    sizes = "blend" not in a.loose and not math.isnan(b.blend)
    if (a.blend == 0.0) != (b.blend == 0.0) or (sizes and not abs(a.blend - b.blend) <= 2e-6):
        yield f"a blend of {a.blend / MM:g} mm is wanted and {b.blend / MM:g} mm found"
