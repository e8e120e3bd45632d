"""Puts the tool somewhere: which written numbers bring it there, and whether they do when the program runs.

The frame that a point stands in need not be known. Where the tool goes is B = F P with the point's numbers P and
whatever the program puts before them, F; for the tool to go to B' the numbers become P B⁻¹ B'.

Codes: O007 a place that the robot cannot take, O009 a move whose target is computed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError, error, raise_errors
from olp.core.units import deg, mm
from olp.ir.moves import Move
from olp.ir.points import PointKind
from olp.languages.literals import WrittenPoint, written_points
from olp.robots.geometry import Pose, rotation_angle, rotation_from_quaternion
from olp.runtime.plan import StepKind

if TYPE_CHECKING:
    from olp.ir.program import Program
    from olp.runtime.plan import Plan

_NEAR = (
    0.1 * mm
)  # a placed point that lands further off is refused: rounding is far below, a wrong frame far above
_TURNED = 0.02 * deg


class Visit(NamedTuple):
    """Step `step` of a plan goes to the written position `name`; as the point on an arc's way with `is_via`.

    `pose`: where the tool is there, in the robot's base; None where that is not known.
    """

    name: str
    step: int
    is_via: bool
    pose: Pose | None


def visits(program: Program, plan: Plan) -> Iterator[Visit]:
    """Which steps of `plan` go to a written position as it stands, without an offset."""
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
    """An arc's point stands in the frame of its target; None where the program passes no such place."""
    if pose is None or target.kind is not PointKind.POSE or via.kind is not PointKind.POSE:
        return None
    found = pose @ target.pose().inverse() @ via.pose()
    return found if _passes(plan, found.position) else None


def _passes(plan: Plan, position: NDArray[np.float64]) -> bool:
    apart = np.linalg.norm(plan.positions.position - position, axis=1)
    return bool((apart < _NEAR).any())


def placed_values(program: Program, point: WrittenPoint, pose: Pose, plan: Plan) -> tuple[float, ...]:
    """The values that bring the tool to the pose, as the program visits the point for the first time."""
    visit = _first_visit(program, plan, point.name)
    before = visit.pose
    assert before is not None
    if point.kind is PointKind.POSE:
        return tuple((point.pose() @ before.inverse() @ pose).xyz_angles().tolist())
    from olp.robots.kinematics import forward, joints_to_pulses, track

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
    """Raises OlpError (O009) where the tool would not go to what was asked."""
    new_plan, problems = run(after), []
    reached = {(one.name, one.step): one.pose for one in visits(after, new_plan)}
    for name, asked in places.items():
        pose = reached.get((name, _first_visit(before, plan, name).step))
        if (
            pose is None
            or float(np.linalg.norm(pose.position - asked.position)) > _NEAR
            or float(rotation_angle(pose.rotation, asked.rotation)) > _TURNED
        ):
            message = f"the program computes with {name}: the tool would not go where it was put"
            problems.append(error("O009", message, file=before.path, help="change the numbers by hand"))
    raise_errors(problems)
