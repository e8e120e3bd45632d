"""Moves: who goes where, how fast, and how the end is passed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from operator import itemgetter
from typing import Final, NamedTuple, TypeVar

from olp.core.diagnostic import Severity
from olp.core.units import mm
from olp.ir import expressions as ex
from olp.ir.program import AccelerationUnit, Blend, BlendKind, Move, PathTrigger, Process
from olp.robots.geometry import Pose
from olp.runtime.evaluate import evaluate, find_slot, quantity, read_variable, whole, write_name
from olp.runtime.first_move import MoveReachedError
from olp.runtime.memory import Record, SystemPosition, Value
from olp.runtime.paths import arc_by_angle
from olp.runtime.places import arc_poses, place_of
from olp.runtime.plan import BlendCode
from olp.runtime.poses import (
    FRACTION,
    JOINT,
    PATH_CODES,
    RATE_ABSOLUTE,
    RATE_FRACTION,
    TIME,
    TRAVEL,
    missing,
    move_speed,
    part_speed,
    place,
    share,
    turn_rate,
)
from olp.runtime.recorder import NO_EXTRA, NOWHERE, Extra
from olp.runtime.spelling import spell
from olp.runtime.state import Machine, StatementError, role

_EXACT, _ZONE, _UNTAGGED, _RADIUS = (
    int(c) for c in (BlendCode.EXACT, BlendCode.ZONE, BlendCode.UNTAGGED, BlendCode.RADIUS)
)
T = TypeVar("T")
_HIGHEST_LEVEL = 8
_MOST_TURNS = 100  # of one arc
_SAME_TURN = 1e-9  # of the elements of two rotations
_NAN = math.nan
# Looked up once: every move asks.
_ROBOT, _BY_RADIUS, _BY_SPEED = ex.Store.ROBOT, BlendKind.RADIUS, BlendKind.SPEED
_UNCHANGED = (BlendKind.LEVEL, BlendKind.CONTINUOUS)  # kinds whose number is no length
# The defaults of KRL's $config.dat, where a program sets none: 50 %, 3 mm, 100 %, 5 deg.
_MODAL_BLENDS = {
    BlendKind.SHARE: 0.5,
    BlendKind.RADIUS: 0.003,
    BlendKind.SPEED: 1.0,
    BlendKind.TURN: math.radians(5.0),
}


def move(m: Machine, s: Move) -> None:
    """Executes a move."""
    if m.seeks_move and not _stays(m, s):
        raise MoveReachedError
    targets = s.targets
    if (
        m.plain
        and m.conventions.taught_frames
        and not s.parts
        and len(targets) == 1
        and type(targets[0]) is ex.Taught
        and _is_simple(s)
    ):
        taught = targets[0]
        job = m.frame.job
        store = taught.store
        mechanism = job.roles.get((0, store))
        if mechanism is None:
            mechanism = role(m, 0, store)
        recorder = m.recorder
        target = recorder.taught(mechanism, job.key, job.points, store, taught.number)
        if target is None:
            raise missing(taught)
        path = PATH_CODES[s.path]
        unit, speed = move_speed(m, s.speed, path)
        code, zone = (_UNTAGGED, _NAN) if s.blend is None else _blend(m, s.blend, mechanism)
        recorder.step(job.source, s.line)
        recorder.row(mechanism, target, path, unit, speed, code, zone, 1.0, 1.0, s.end_of_arc)
        m.moves += 1
        return
    _compound(m, s)


def _is_simple(s: Move) -> bool:
    return (
        s.search is None
        and s.relative is None
        and s.until is None
        and s.acceleration is None
        and s.deceleration is None
        and not s.coordinated
        and not s.no_wait
        and not s.passes
        and s.tool is None
        and s.frame is None
        and s.via is None
        and s.rate is None
        and s.turn is None
        and s.offset is None
        and s.tool_offset is None
        and not s.triggers
    )


def _compound(m: Machine, s: Move) -> None:
    """A move of several mechanisms, or with anything besides target, speed and blend."""
    if s.arc is not None:
        m.operations.act(m, s, True)
        for arc in _by_angle(m, replace(s, triggers=()), quantity(m, s.arc)):
            _compound(m, arc)
        m.operations.act(m, s, False)
        return
    path = PATH_CODES[s.path]
    if _stays(m, s):
        m.assume("the move goes to the current position, which is unknown: it goes nowhere")
        return
    m.reached_move = True
    rows = _targets_of(m, s.targets, 0, s)
    for number_, part in enumerate(s.parts, 1):
        if part.path is not None:
            rows += _targets_of(m, part.targets, number_, s)
    if not rows:
        return
    unit, speed = move_speed(m, s.speed, path)
    if m.override != 1.0:
        # A time is as much longer under an override.
        speed = speed / m.override if unit == TIME else speed * m.override
    if unit == TRAVEL:
        speed = min(speed, m.fastest)
    modal = m.rates.get((path == JOINT, RATE_FRACTION), 1.0)
    acceleration = modal if s.acceleration is None else share(m, quantity(m, s.acceleration), "acceleration")
    deceleration = (
        (modal if s.acceleration is None else acceleration)
        if s.deceleration is None
        else share(m, quantity(m, s.deceleration), "deceleration")
    )
    extra = _extra(m, s, path, rows[0][1])
    _report_unknowables(m, s)
    arm = rows[0][1]
    if len(rows) > 1:
        arm = next((mech for _, mech, _ in rows if m.world.mechanisms[mech].is_robot), arm)
    recorded = []
    for part_number, mechanism, target in rows:
        row_path, row_unit, row_speed = path, unit, speed
        if part_number:
            row_path, row_unit, row_speed = part_speed(m, s.parts[part_number - 1], (unit, speed))
        if row_unit != FRACTION and not m.world.mechanisms[mechanism].is_robot:
            # A track or table under a linear move keeps step; only its own rated speed bounds it.
            row_path, row_unit, row_speed = JOINT, FRACTION, 1.0
        blend = (s.parts[part_number - 1].blend if part_number else None) or s.blend
        code, zone, kind = (_UNTAGGED, _NAN, "") if blend is None else _any_blend(m, blend, arm)
        if kind:
            extra = extra._replace(blend=kind)
        recorded.append((mechanism, target, row_path, row_unit, row_speed, code, zone))
    # Only now: a tag without a value leaves the whole move out, and a step without rows would be none.
    recorder = m.recorder
    acts = bool(s.triggers) or (bool(s.other) and m.conventions.actions_at_ends)
    if acts:
        m.operations.act(m, s, True)
    recorder.step(m.frame.job.source, s.line)
    if extra is not NO_EXTRA:
        recorder.extra(extra)
    for row in recorded:
        recorder.row(*row, acceleration, deceleration, s.end_of_arc)
    m.moves += 1
    if acts:
        m.operations.act(m, s, False)


def _by_angle(m: Machine, s: Move, angle: float) -> list[Move]:
    """An arc that turns by an angle [rad], whatever its target, as arcs through points, passed without a stop.

    Itself, to its target, where its points are on a line. Raises StatementError (I308) for more than a hundred turns.
    """
    assert s.via is not None
    if not abs(angle) <= _MOST_TURNS * 2.0 * math.pi:
        turns = f"{abs(angle) / (2.0 * math.pi):.6g}"
        raise StatementError(
            "I308", f"an arc of {turns} turns", f"write an angle of up to {_MOST_TURNS} turns"
        )
    mechanism = role(m, 0, _ROBOT)
    start, via, end = arc_poses(m, mechanism, s)
    arcs = arc_by_angle(start, via.position, end, angle)
    whole = replace(s, arc=None, relative=None)
    if not arcs:
        return [replace(s, arc=None)]
    if abs(start.rotation - end.rotation).max() > _SAME_TURN:
        m.assume_once("arc by angle", "an arc by an angle is taken to end with the orientation of its target")
    last = len(arcs) - 1
    return [
        replace(
            whole,
            via=_literal(Pose(point, pose.rotation)),
            targets=(_literal(pose),),
            blend=s.blend if k == last else Blend(BlendKind.CONTINUOUS),
            other=s.other if k == last else (),
        )
        for k, (point, pose) in enumerate(arcs)
    ]


def _literal(pose: Pose) -> ex.PositionLiteral:
    return ex.PositionLiteral("pose", tuple(float(v) for v in pose.xyz_angles()))


def _stays(m: Machine, s: Move) -> bool:
    """Whether a program begins by moving to the current position, so that a block selection is safe."""
    here = len(s.targets) == 1 and isinstance(s.targets[0], ex.SystemValue) and s.relative is None
    return here and not m.conventions.taught_frames and m.recorder.at[role(m, 0, ex.Store.ROBOT)] == NOWHERE


def _extra(m: Machine, s: Move, path: int, mechanism: int) -> Extra:
    """What a move of another language than INFORM says besides; NO_EXTRA where it says nothing."""
    rate = m.rates.get((path == JOINT, RATE_ABSOLUTE), _NAN)
    if s.rate is not None:
        given = quantity(m, s.rate.value)
        if given > 0.0 and s.rate.unit is not AccelerationUnit.FRACTION:
            rate = given
    turn = m.turn if s.turn is None else turn_rate(m, s.turn)
    if s.via is None and math.isnan(rate) and math.isnan(turn):
        return NO_EXTRA
    via = -1
    if s.via is not None:
        via = place_of(m, mechanism, s, s.via)
    return Extra(rate, turn, via)


def _targets_of(
    m: Machine, targets: tuple[ex.Expression, ...], part: int, s: Move
) -> list[tuple[int, int, int]]:
    """(part, mechanism, index in the pool) of each written position."""
    rows = []
    for position in targets:
        if _is_general(m, position, s):
            mechanism = role(m, part, _ROBOT)
            rows.append((part, mechanism, place_of(m, mechanism, s, position)))
            continue
        if not isinstance(position, (ex.Taught, ex.Variable)) or position.store not in ex.POSITION_STORES:
            raise StatementError(
                "I209", f"{spell(position)} is no position", "use a position variable or a taught point"
            )
        for store in _stores(m, position):
            rows.append(
                (part, mechanism := role(m, part, store), place(m, mechanism, position, store, s.relative))
            )
    return rows


def _is_general(m: Machine, position: ex.Expression, s: Move) -> bool:
    """Whether a target is more than a point or variable of an INFORM job."""
    if m.conventions.taught_frames and isinstance(position, (ex.Taught, ex.Variable, ex.Unknown)):
        return s.tool is not None or s.frame is not None
    return not isinstance(position, ex.Unknown) and getattr(position, "store", _ROBOT) is _ROBOT


def _stores(m: Machine, position: ex.Taught | ex.Variable) -> tuple[ex.Store, ...]:
    if position.store is not ex.Store.SYSTEM:
        return (position.store,)
    assert isinstance(position, ex.Variable)
    whole_position = read_variable(m, ex.Store.SYSTEM, whole(m, position.index), position.local)
    assert isinstance(
        whole_position, SystemPosition
    )  # what else a system variable holds is an error of its own
    return tuple(store for store, _ in whole_position.parts)


def _any_blend(m: Machine, blend: Blend, mechanism: int) -> tuple[int, float, str]:
    """(blend code, zone or radius [m] or share, what has still to become metres once the path is known)."""
    kind = blend.kind
    if m.conventions.taught_frames or kind in _UNCHANGED:
        return (*_blend(m, blend, mechanism), "")
    value = (
        m.blends.get(kind, _MODAL_BLENDS.get(kind, 0.0)) if blend.value is None else quantity(m, blend.value)
    )
    if value <= 0.0 and not (kind is _BY_SPEED and m.conventions.share_zones and blend.value is not None):
        return _EXACT, _NAN, ""
    if kind is _BY_RADIUS:
        return (_RADIUS if m.conventions.share_zones else _ZONE), value, ""
    if kind is _BY_SPEED and m.conventions.share_zones:
        return _ZONE, min(value, 1.0), ""
    return _ZONE, value, str(kind)


def _blend(m: Machine, blend: Blend, mechanism: int) -> tuple[int, float]:
    """(blend code, zone or radius [m])."""
    if blend.kind is BlendKind.CONTINUOUS or blend.value is None:
        return _UNTAGGED, _NAN
    value = quantity(m, blend.value)
    if blend.kind is BlendKind.RADIUS:
        return (_RADIUS, value) if value > 0.0 else (_EXACT, _NAN)
    level = round(value)
    if level <= 0:
        return _EXACT, _NAN
    if level > _HIGHEST_LEVEL:
        m.fault(
            StatementError("I304", f"position level {level} is taken as 8", "write 0 .. 8", Severity.WARNING)
        )
    zone = m.world.zone(mechanism, level)
    if mechanism in m.world.default_zones:
        m.world.default_zones.discard(mechanism)
        m.assume(
            "the blend zones of this controller are not known: 12.5 25 50 100 200 300 400 500 mm are taken"
        )
    return _ZONE, zone


def _report_unknowables(m: Machine, s: Move) -> None:
    if s.search is not None:
        m.assume("the search moves to its target")
    if s.until is not None:
        m.assume("the condition that ends the move early is taken not to come before its target")
    if s.coordinated:
        says = "the speed relative to the moving work is taken as the tool's speed in the base frame"
        m.assume_once("coordinated", says)
    if s.passes:
        m.assume_once("passes", "the tags of multi-pass welding are not followed: every pass runs as written")
    process = m.conventions.move_options.processes.get(s.other[0][0].casefold()) if s.other else None
    if process is not None:
        m.assume_once(
            s.other[0][0], f"{s.other[0][0]}: the move alone is planned, {process} takes no further time"
        )
    if s.no_wait:
        m.assume("the statements after this move are taken to run behind it, not beside it")


# --- Triggers ---
# Outputs that switch while a move is under way: the move names them (`PathTrigger`), or RAPID's TriggL, TriggJ and
# TriggC name variables that TriggIO or TriggEquip has set before (RAPID's technical reference manual, TriggIO). A plan
# has steps and no places within them: what acts near the start is a step before the move, everything else behind it.


# The type of a trigger, and the argument of a process instruction that names it.
_TRIGGER: Final = "triggdata"
_TRIGG: Final = "trigg"
_AT_START: Final = "start"
_METRES, _SECONDS = "metres", "seconds"  # how far behind that end it acts


class SwitchedOnTheWay(NamedTuple):
    """What switches `metres` and `seconds` behind an end of a move; nan where nothing tells it."""

    signal: ex.Signal
    value: ex.Expression
    metres: float
    seconds: float
    above: int = 0  # lines above the move


def define_trigger(m: Machine, s: Process) -> bool:
    """Keeps what a TriggIO or TriggEquip says in its variable; False for any other instruction."""
    given = dict(s.arguments)
    name, trigger = given.get(_TRIGGER), trigger_of(s)
    if not isinstance(name, ex.Named) or trigger is None or not isinstance(trigger.signal.index, ex.Text):
        return False
    members: dict[str, Value] = {
        "bus": trigger.signal.bus,
        "signal": trigger.signal.index.value,
        "value": evaluate(m, trigger.value),
        _AT_START: trigger.at_start,
        _METRES: _far(m, trigger.metres),
        _SECONDS: _far(m, trigger.seconds),
    }
    write_name(m, name.name, Record(_TRIGGER, members))
    return True


def trigger_of(s: Process) -> PathTrigger | None:
    """What an instruction that sets a trigger says, with lengths in m and times in s; None for any other one."""
    given = dict(s.arguments)
    signal = given.get("signal")
    if _TRIGGER not in given or not isinstance(signal, ex.Signal):
        return None
    at_start = given[_AT_START] == ex.SignalState(True)
    ahead = 1.0 if at_start else -1.0  # distances from the end lie before it
    metres = ex.Quantity(given["mm"], ahead * mm) if "mm" in given else None
    seconds = ex.Quantity(given["s"], ahead) if "s" in given else None
    if "lag" in given:  # of what is switched: the earlier
        seconds = ex.Quantity(given["lag"], -1.0)
    return PathTrigger(signal, given["value"], at_start, metres, seconds)


def _far(m: Machine, amount: ex.Quantity | None) -> float:
    return 0.0 if amount is None else quantity(m, amount)


def outputs_on_the_way(m: Machine, s: Move, at_start: bool) -> list[SwitchedOnTheWay]:
    """What a move's triggers switch near its start, or near its end, in the order of their places, if that is known."""
    found = [
        SwitchedOnTheWay(one.signal, one.value, _far(m, one.metres), _far(m, one.seconds), one.above)
        for one in s.triggers
        if one.at_start is at_start
    ]
    if s.other and s.other[0][0].casefold().startswith(_TRIGG):
        found += [one for _, e in s.other[1:] if (one := _set_trigger(m, e, at_start)) is not None]
    if found:
        says = "outputs that switch on the way of a move are shown at the nearer of its ends"
        m.assume_once(_TRIGGER, says)
    return in_order(found, [(one.metres, one.seconds) for one in found]) or found


def in_order(several: Sequence[T], places: Sequence[tuple[float, float]]) -> list[T] | None:
    """What acts so many metres and seconds behind an end, in the order in which it acts.

    None where one of two is nearer in metres, the other one in seconds.

    >>> in_order("abc", [(-0.01, 0.0), (-0.01, -0.1), (-0.06, -0.1)])
    ['c', 'b', 'a']
    """
    rows = sorted(zip(places, several, strict=True), key=itemgetter(0))
    if any(first[0][1] > second[0][1] for first, second in pairwise(rows)):
        return None
    return [one for _, one in rows]


def _set_trigger(m: Machine, e: ex.Expression, at_start: bool) -> SwitchedOnTheWay | None:
    """What the trigger in a variable switches near that end of a move."""
    slot = find_slot(m, e.name) if isinstance(e, ex.Named) else None
    trigger = None if slot is None else slot.value
    if not isinstance(trigger, Record) or trigger.type != _TRIGGER:
        return None
    held = trigger.members
    value = held["value"]
    if held[_AT_START] != at_start or not isinstance(value, (bool, int, float)):
        return None
    metres, seconds = held[_METRES], held[_SECONDS]
    assert isinstance(metres, float)
    assert isinstance(seconds, float)
    state = ex.SignalState(value) if isinstance(value, bool) else ex.Number(value)
    return SwitchedOnTheWay(ex.Signal(str(held["bus"]), ex.Text(str(held["signal"]))), state, metres, seconds)
