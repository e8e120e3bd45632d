"""Changes positions and speeds of a program; all other bytes of its files stay.

A change is made in the text, number by number. The new text is read again and is accepted only if its program
equals the old one except for the requested change; with placed points it is also run.

Codes: O002 no such position, O003 a position written twice, O004 invalid numbers, O005 no speed on this line, O006
an impossible speed.

A point can also be placed by the pose of the tool: the numbers that bring it there are computed, and checked by
running the program.

The frame of a point need not be known. The tool goes to B = F P with the point's numbers P and all transforms F
that the program applies before them; for the tool to go to B' the numbers become P B⁻¹ B'.

Codes: O007 a place that the robot cannot reach, O009 a move whose target is computed.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, Span, error, info, raise_errors
from olp.core.units import deg, mm
from olp.ir.expressions import Named, PositionLiteral, Taught, Variable
from olp.ir.points import PointKind
from olp.ir.program import Assign, Declare, Move, Program, SpeedUnit, like
from olp.languages.literals import (
    Token,
    WrittenPoint,
    by_name,
    language,
    replaced,
    speed_of,
    speeds,
    written_points,
    written_speed,
)
from olp.robots.geometry import Pose, rotation_angle, rotation_from_quaternion
from olp.runtime.plan import StepKind

if TYPE_CHECKING:
    from olp.core.source import Source
    from olp.runtime.plan import Plan

__all__ = ["ChangeSpeed", "Edited", "PlacePoint", "SetPoint", "Visit", "edited", "speeds", "visits"]

_SAME_POINT = (
    0.1 * mm
)  # a placed point that lands further off is refused: rounding is far below, a wrong frame far above
_SAME_TURN = 0.02 * deg


class Visit(NamedTuple):
    """Step `step` of a plan goes to the written position `name`; with `is_via` as the via point of an arc.

    `pose`: the tool's pose there in the robot's base; None if unknown.
    """

    name: str
    step: int
    is_via: bool
    pose: Pose | None


def visits(program: Program, plan: Plan) -> Iterator[Visit]:
    """The steps of `plan` that go to a written position without an offset."""
    points = written_points(program)
    by_target = {point.target: name for name, point in points.items() if point.target is not None}
    by_line = {point.line: name for name, point in points.items() if point.target is None}
    moves = {one.line: one for one in program.statements() if isinstance(one, Move)}
    here = [index for index, source in enumerate(plan.sources) if source.path == program.path]
    steps = np.flatnonzero((plan.kind == StepKind.MOVE) & np.isin(plan.source, here))
    for step, line in zip(steps.tolist(), plan.line[steps].tolist(), strict=True):
        move = moves.get(line)
        if move is None or not move.targets or move.relative is not None or move.search is not None:
            continue
        if move.offset is not None or move.tool_offset is not None:
            continue
        name = by_target.get(move.targets[0], by_line.get(line))
        if name is None:
            continue
        pose = _target(plan, step)
        yield Visit(name, step, False, pose)
        via = None if move.via is None else by_target.get(move.via)
        if via is not None:
            yield Visit(via, step, True, _on_the_way(plan, pose, points[name], points[via]))


def _target(plan: Plan, step: int) -> Pose | None:
    at = int(plan.moves.target[int(plan.row[step])])
    position, quaternion = plan.positions.position[at], plan.positions.quaternion[at]
    if np.isnan(position).any() or np.isnan(quaternion).any():
        return None
    return Pose(position.copy(), rotation_from_quaternion(quaternion))


def _on_the_way(plan: Plan, pose: Pose | None, target: WrittenPoint, via: WrittenPoint) -> Pose | None:
    """Pose of an arc's via point, which is in the frame of its target; None where the program does not pass it."""
    if pose is None or target.kind is not PointKind.POSE or via.kind is not PointKind.POSE:
        return None
    found = pose @ target.pose().inverse() @ via.pose()
    return found if _passes(plan, found.position) else None


def _passes(plan: Plan, position: NDArray[np.float64]) -> bool:
    apart = np.linalg.norm(plan.positions.position - position, axis=1)
    return bool((apart < _SAME_POINT).any())


def placed_values(program: Program, point: WrittenPoint, pose: Pose, plan: Plan) -> tuple[float, ...]:
    """The values that bring the tool to the pose at the program's first visit of the point."""
    visit = _first_visit(program, plan, point.name)
    before = visit.pose
    assert before is not None
    if point.kind is PointKind.POSE:
        return tuple((point.pose() @ before.inverse() @ pose).xyz_angles().tolist())
    from olp.robots.kinematics.configuration import forward, joints_to_pulses
    from olp.robots.kinematics.tracking import track

    robot, row = plan.robot, int(plan.row[visit.step])
    if robot is None:
        raise OlpError(
            error("O007", f"{point.name} is written in axes: the robot must be known", help="--robot NAME")
        )
    axes = plan.positions.axes[int(plan.moves.target[row])]
    axes = axes[: len(robot.axes)]
    flange = Pose(*(one[0] for one in forward(robot, axes[None])))
    wanted = pose @ (flange.inverse() @ before).inverse()  # the same tool on the flange
    positions, rotations = (
        np.stack((flange.position, wanted.position)),
        np.stack((flange.rotation, wanted.rotation)),
    )
    joints = track(robot, positions, rotations, axes)[1]
    if np.isnan(joints).any():
        raise OlpError(error("O007", f"{robot.name} does not reach the new place of {point.name}"))
    if point.kind is PointKind.PULSE:
        pulses: Sequence[float] = joints_to_pulses(robot, joints[None])[0].tolist()
        return (*pulses, *point.values()[len(pulses) :])
    # Between the written and the modelled axes stands the maker's convention; how far they turn is the same.
    moved = np.asarray(point.values()[: len(joints)]) + joints - axes
    return (*moved.tolist(), *point.values()[len(joints) :])


def _first_visit(program: Program, plan: Plan, name: str) -> Visit:
    for visit in visits(program, plan):
        if visit.name == name and visit.pose is not None:
            return visit
    raise OlpError(
        error(
            "O009",
            f"the program does not go to {name} as it is written, or where it is then is not known",
            help="give the point's own numbers instead of a place in space",
        )
    )


def check_places(
    before: Program, after: Program, places: Mapping[str, Pose], plan: Plan, run: Callable[[Program], Plan]
) -> None:
    """Raises OlpError (O009) where the tool would not go to the requested pose."""
    new_plan, problems = run(after), []
    reached = {(one.name, one.step): one.pose for one in visits(after, new_plan)}
    for name, asked in places.items():
        pose = reached.get((name, _first_visit(before, plan, name).step))
        if (
            pose is None
            or float(np.linalg.norm(pose.position - asked.position)) > _SAME_POINT
            or float(rotation_angle(pose.rotation, asked.rotation)) > _SAME_TURN
        ):
            message = f"the program computes with {name}: the tool would not go where it was put"
            problems.append(error("O009", message, file=before.path, help="change the numbers by hand"))
    raise_errors(problems)


@dataclass(frozen=True, slots=True)
class SetPoint:
    """`values` as `WrittenPoint.values()`: x y z [m] rx ry rz [rad] in the point's frame, axes [rad], or pulses."""

    name: str
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class PlacePoint:
    """Moves the tool centre point to `pose` in the robot's base, whatever the point's own frame."""

    name: str
    pose: Pose


@dataclass(frozen=True, slots=True)
class ChangeSpeed:
    """`value` in SI, of the line's kind of speed: m/s, rad/s, s, or a fraction of rated speed."""

    line: int
    value: float


Edit = SetPoint | PlacePoint | ChangeSpeed


class Edited(NamedTuple):
    """The changed program. `sources`: the changed files; `lines`: (path, line) of the changes.

    `notes`: values that could not be written to the last decimal.
    """

    program: Program
    sources: tuple[Source, ...]
    lines: tuple[tuple[str, int], ...]
    notes: tuple[Diagnostic, ...] = ()


def edited(
    program: Program,
    edits: Sequence[Edit],
    plan: Plan | None = None,
    replan: Callable[[Program], Plan] | None = None,
) -> Edited:
    """The program with all of `edits`. `plan`, `replan`: its run, needed to place points (default: without
    options).

    Raises OlpError with all problems; nothing is changed then.
    """
    from olp.runtime.interpreter import run as run_program

    run = replan or run_program
    placed = [one for one in edits if isinstance(one, PlacePoint)]
    if placed and plan is None:
        plan = run(program)
    problems: list[Diagnostic] = []
    changes: list[_Change] = []
    for edit in edits:
        try:
            changes.append(_change(program, edit, plan))
        except OlpError as problem:
            problems.extend(one if one.file else one.at(program.path) for one in problem.diagnostics)
    raise_errors(problems)
    texts = {(one.path, token): text for one in changes for token, text in one.texts.items()}
    old = {one.path: one for one in (program.source, *program.companions)}
    new = {
        path: replaced(source, {token: text for (of, token), text in texts.items() if of == path})
        for path, source in old.items()
    }
    result = _reread(program, new)
    lines = {(path, token.line) for path, token in texts}
    check_same(program, result, len(lines))
    # Of two changes of one thing the later one counts.
    notes = [note for one in {one.what: one for one in changes}.values() for note in _checked(result, one)]
    if placed and plan is not None:
        check_places(program, result, {one.name: one.pose for one in placed}, plan, run)
    different = tuple(one for path, one in new.items() if one.raw != old[path].raw)
    return Edited(result, different, tuple(sorted(lines)), tuple(notes))


class _Change(NamedTuple):
    """Effect of an edit on the text. `values`: the requested ones of a point, or the one number of a speed."""

    what: object
    path: str
    texts: dict[Token, str]
    values: tuple[float, ...]
    point: WrittenPoint | None = None
    line: int = 0


def _change(program: Program, edit: Edit, plan: Plan | None) -> _Change:
    if isinstance(edit, ChangeSpeed):
        return _respelt_speed(program, edit)
    point = _point(program, edit.name)
    if isinstance(edit, PlacePoint):
        assert plan is not None
        values = placed_values(program, point, edit.pose, plan)
    else:
        values = edit.values
    if len(values) != len(point.values()) or not all(map(math.isfinite, values)):
        raise OlpError(
            error(
                "O004",
                f"{point.name} needs {len(point.values())} numbers",
                help="x y z rx ry rz, or the axes",
            )
        )
    return _Change(point.name, point.source.path, point.respelt(values), tuple(values), point)


def _checked(program: Program, change: _Change) -> list[Diagnostic]:
    """Notes on a change in the program that was read again. Raises OlpError if the reader finds other values."""
    if change.point is not None:
        check_point(program, change.point, change.values)
        return []
    speed = speed_of(program, change.line)
    said = (
        math.nan if speed is None or speed.value.literal is None else speed.value.literal / speed.value.scale
    )
    return check_speed(program, change.line, change.values[0], said, change.texts)


def _point(program: Program, name: str) -> WrittenPoint:
    known: dict[str, list[WrittenPoint]] = by_name(program)
    found = known.get(name, [])
    if len(found) == 1:
        return found[0]
    if found:
        lines = " and ".join(str(one.line) for one in found)
        raise OlpError(error("O003", f"{name} is written twice, in lines {lines}", Span(found[1].line)))
    near = difflib.get_close_matches(name, known, 3) or list(known)[:3]
    raise OlpError(
        error(
            "O002",
            f"no position {name!r} is written out with all of its numbers",
            help=f"there are {', '.join(near)}" if near else "this program has none that can be changed",
        )
    )


def _respelt_speed(program: Program, edit: ChangeSpeed) -> _Change:
    found = written_speed(program, edit.line)
    span = Span(edit.line) if 0 < edit.line <= len(program.source.lines) else None
    if found is None:
        raise OlpError(
            error(
                "O005",
                "no speed of this line alone is written as a number",
                span,
                source_line=program.source.line(edit.line),
                help="change the line that sets it, where it may hold for other moves as well",
            )
        )
    written, speed = found
    highest = 1.0 if speed.unit is SpeedUnit.FRACTION else math.inf
    if not 0.0 < edit.value <= highest or not math.isfinite(edit.value):
        most = " and at most 100 %" if highest == 1.0 else ""
        raise OlpError(
            error("O006", f"a speed is above zero{most}, not {edit.value / speed.value.scale:g}", span)
        )
    number = float(f"{edit.value / speed.value.scale:.9g}")
    return _Change(written.line, written.source.path, written.respelt(number), (number,), line=edit.line)


def _reread(program: Program, sources: Mapping[str, Source]) -> Program:
    """The program of the new texts; data lists that belong to it are taken from `sources`, not from the disk."""
    from olp.languages.vendor import find_vendor

    source = sources[program.path]
    companions = tuple(sources[one.path] for one in program.companions)
    reread = getattr(language(program), "reread", None)
    if reread is not None:
        changed: Program = like(reread(source, companions), program)
        return changed
    return like(find_vendor(program.vendor).read(source), program)


# --- Edit check ---
# Whether a changed text says what was asked, as the language's own reader understands it, and nothing else.
#
# Codes: O008 a change that would do something else, O010 a number that had to be rounded.

Floats = NDArray[np.float64]

# A number with the fewest decimals that there are: one of a millimetre's, two of a degree's (ERC).
_NEAR, _TURNED = 0.06 * mm, 0.02 * deg
_TOLD = 0.005  # [1] a speed that is rounded by more is told
_LAST_NUMBER = re.compile(r"\d*\.?\d+(?=\D*\Z)")


def check_same(before: Program, after: Program, most: int) -> None:
    """Raises OlpError (O008) when more than `most` pieces, one per line, differ."""
    old, new = _facts(before), _facts(after)
    different = [key for key in old.keys() | new.keys() if old.get(key) != new.get(key)]
    known = {(one.code, one.line, one.message) for one in before.diagnostics}
    worse = [
        one for one in after.diagnostics if one.is_error and (one.code, one.line, one.message) not in known
    ]
    if len(different) > most or old.keys() != new.keys() or worse:
        raise OlpError(_something_else(before), *worse)


def check_point(program: Program, point: WrittenPoint, values: Sequence[float]) -> None:
    """Raises OlpError (O008) when the reader finds other values of the point than `values`."""
    for said in _said(program, point):
        if not _alike(point.kind, np.asarray(said[: len(values)]), np.asarray(values[: len(said)])):
            raise OlpError(_something_else(program, point.line))


def check_speed(
    program: Program, line: int, asked: float, said: float, texts: dict[Token, str]
) -> list[Diagnostic]:
    """Notes about rounding. `asked`: the requested speed, `said`: the one that the reader finds, both in the
    written unit.

    Raises OlpError (O008) when the reader finds another number than the written one.
    """
    match = _LAST_NUMBER.search(next(iter(texts.values()), ""))
    if match is not None and not abs(float(match[0]) - said) <= 1e-6 * abs(said):
        raise OlpError(_something_else(program, line))
    if abs(said / asked - 1.0) <= _TOLD:
        return []
    message = f"a speed of {asked:g} is written as {said:g}: there are no further decimals"
    return [info("O010", message, Span(line), file=program.path, source_line=program.source.line(line))]


def _something_else(program: Program, line: int = 0) -> Diagnostic:
    message = "the change would do something else as well: nothing was changed"
    return error("O008", message, Span(line) if line else None, file=program.path)


def _facts(program: Program) -> dict[tuple[object, ...], str]:
    """Text of every piece of a program: data, routines, statements, points."""
    facts: dict[tuple[object, ...], str] = {("data", i): repr(one) for i, one in enumerate(program.data)}
    for routine in program.routines:
        head = replace(routine, body=(), points=type(routine.points)())
        facts["routine", routine.name] = repr(head)
        for i, statement in enumerate(routine.body):
            facts["statement", routine.name, i] = repr(statement)
        for store, taught, point in routine.points:
            facts["point", routine.name, store, taught, point.number] = repr(point)
    return facts


def _said(program: Program, point: WrittenPoint) -> Iterator[tuple[float, ...]]:
    """The values of the point in the program; none where it is not stored as numbers."""
    target = point.target
    for routine in program.routines:
        if isinstance(target, Taught | Variable):
            for store, taught, kept in routine.points:
                if isinstance(target, Taught) == taught and kept.line == point.line and store == target.store:
                    yield kept.values
    for one in (*program.data, *(d for r in program.routines for d in r.data), *program.statements()):
        value: object = None
        if isinstance(one, Declare) and isinstance(target, Named) and one.name == target.name:
            # Lists beside the program (KRL .dat) give no line; another routine may have a variable of this name.
            value = one.value if one.line in (0, point.line) else None
        elif isinstance(one, Assign) and isinstance(target, Named) and one.target == target:
            value = one.value if one.line == point.line else None
        elif isinstance(one, Move) and target is None and one.line == point.line and one.targets:
            value = one.targets[0]
        if isinstance(value, PositionLiteral):
            yield value.values


def _alike(kind: PointKind, one: Floats, other: Floats) -> bool:
    if kind is PointKind.PULSE:
        return bool((abs(one - other) <= 0.5).all())
    if kind is PointKind.JOINT:
        return bool((abs(one - other) <= _TURNED).all())
    a, b = Pose.from_xyz_angles(one[:6]), Pose.from_xyz_angles(other[:6])
    near = float(np.linalg.norm(a.position - b.position)) <= _NEAR
    return near and float(rotation_angle(a.rotation, b.rotation)) <= _TURNED
