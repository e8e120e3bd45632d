"""Kinematic branches (arm configurations) of positions that do not state one: they follow from the moves before.

Along lines and curves the arm stays on its branch, whatever flags their end names: they decide on joint moves alone,
and controllers stop at lines that lead to others. A joint move to a pose without flags goes to the nearest axes. Arms
without a spherical wrist have no configurations that could be named.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from olp.core.result_cache import shelf
from olp.ir.points import PointKind, PointState
from olp.ir.program import Path
from olp.robots.coordinate_systems import Cell, Floats, Gap, quaternions
from olp.robots.geometry import (
    compose,
    quaternion_from_rotation,
    rotation_angle,
    rotation_from_quaternion,
    slerp,
)
from olp.runtime.plan import PATHS, Moves, Positions

if TYPE_CHECKING:
    from olp.robots.model import Robot

_JOINT: Final = PATHS.index(Path.JOINT)
_TURN = 2.0 * math.pi
# [rad] An axis that turns further along a line may have turned the other way round.
_SUDDEN = 0.5 * math.pi
# Decimals of axes [rad | m]: repetitions that differ by less have the same axes.
_SAME_STAND = 8
_NOISE = 1e-9  # [rad]
_AT_ONCE = (16, 512)  # lines whose axes are solved together: at first, and at most
# Samples along a line that is followed: [m] and [rad] between them, and how many at least and at most.
_SPACING, _TURNING, _FEWEST, _MOST = 0.01, 0.02, 16, 256
# Arms that are solved step by step: [m] and [rad] between steps, [rad] by which axes may differ from step to step.
_STEP, _STEP_TURN, _STEP_AXES = 0.05, 0.1, 0.5


class WrittenPosture(IntEnum):
    """What a written position says about the arm's configuration."""

    AXES = 0  # axis values, which leave nothing open; or the arm is unknown
    FLAGS = 1  # a pose with flags, which a joint move obeys
    NOTHING = 2  # a pose without flags, or of an arm that has no configurations
    OTHER = 3  # a pose with flags that the arm cannot have there


def named(cell: Cell, mechanism: int, state: PointState) -> WrittenPosture:
    """What a position with this state says."""
    robot = cell.robot(mechanism)
    if state.kind is not PointKind.POSE or robot is None or robot.geometry is None:
        return WrittenPosture.AXES
    if not cell.mechanisms[mechanism].is_robot:
        return WrittenPosture.AXES
    return (
        WrittenPosture.FLAGS
        if state.configuration and robot.geometry.links is not None
        else WrittenPosture.NOTHING
    )


def says_of(cell: Cell, mechanism: int, state: PointState, axes: Floats) -> NDArray[np.int8]:
    """(n,) WrittenPosture of positions with this state; `axes` (n, k): those of the poses under their flags."""
    said = named(cell, mechanism, state)
    found = np.full(len(axes), said, dtype=np.int8)
    if said is WrittenPosture.FLAGS and state.sectors:
        from olp.robots.kinematics.configuration import stands_in

        found[~stands_in(axes, state.sectors)] = WrittenPosture.OTHER
    return found


def keep_branches(
    cell: Cell, positions: Positions, tools: NDArray[np.int32], says: NDArray[np.int8], moves: Moves
) -> tuple[Positions, Moves, NDArray[np.int32]]:
    """Positions whose axes follow from the moves that lead there, with the `moves` and `tools` for them.

    `says` (p,): WrittenPosture. A position that is reached with several sets of axes becomes several positions.
    """
    if not len(moves) or not says[moves.target].any():
        return positions, moves, tools
    axes = positions.axes.copy()
    target, start = moves.target.copy(), moves.start.copy()
    again: list[int] = []  # positions that are added again, with other axes
    again_axes: list[Floats] = []
    for mechanism in np.unique(moves.mechanism[says[moves.target] > 0]).tolist():
        rows = np.flatnonzero(moves.mechanism == mechanism)
        robot = cell.robot(mechanism)
        assert robot is not None
        width = len(robot.axes)
        arm = PlannedArm(robot, cell, positions, tools)
        reached = arm.follow(int(moves.start[rows[0]]), target[rows], moves.path[rows] == _JOINT, says)
        if says[target[rows[0]]] == WrittenPosture.NOTHING and moves.start[rows[0]] == target[rows[0]]:
            _tell_first(cell, robot)
        written = axes[target[rows], :width]
        _tell(cell, reached, written, says[target[rows]], moves.path[rows] == _JOINT)
        unsaid = says[target[rows]] >= WrittenPosture.NOTHING
        # A position without flags gets the axes with which it is reached first; reached again, it may need others.
        first = np.zeros(len(rows), dtype=bool)
        first[np.unique(target[rows], return_index=True)[1]] = True
        first &= unsaid
        axes[target[rows[first]], :width] = reached[first]
        other = (~_same(reached, written) | unsaid) & ~first & ~_same(axes[target[rows], :width], reached)
        padded = np.full((len(rows), axes.shape[1]), np.nan)
        padded[:, :width] = reached
        for at in np.flatnonzero(other).tolist():
            index = int(target[rows[at]])
            target[rows[at]] = len(positions) + len(again)
            again.append(index)
            again_axes.append(padded[at])
            if at + 1 < len(rows) and start[rows[at + 1]] == index:
                start[rows[at + 1]] = target[rows[at]]
    if not again:
        return replace(positions, axes=axes), moves, tools
    grown = Positions(
        np.concatenate([positions.position, positions.position[again]]),
        np.concatenate([positions.quaternion, positions.quaternion[again]]),
        np.concatenate([axes, np.array(again_axes)]),
    )
    return grown, replace(moves, start=start, target=target), np.concatenate([tools, tools[again]])


def _tell_first(cell: Cell, robot: Robot) -> None:
    """Reports which configuration is assumed for the first position, where it states none."""
    if robot.geometry is not None and robot.geometry.links is not None:
        taken = "in front, elbow up, wrist not flipped"
    else:
        taken = "near the middle of its axes' ranges"
    text = f"the first pose has no arm configuration: {taken} is used, and the next moves continue from it"
    cell.gaps.setdefault("first pose", Gap("first pose", text))


def _tell(
    cell: Cell, reached: Floats, written: Floats, says: NDArray[np.int8], joint: NDArray[np.bool_]
) -> None:
    """Reports lines to other flags than the arm has, and joint moves to flags that it cannot have there."""
    count = int(((says == WrittenPosture.OTHER) & joint).sum())
    if count:
        where = "a joint move leads" if count == 1 else f"{count} joint moves lead"
        text = (
            f"{where} to an arm configuration that this robot does not have there: the nearest axes are used"
        )
        cell.gaps.setdefault("arm configuration", Gap("arm configuration", text))
    told = (says == WrittenPosture.FLAGS) & ~np.isnan(reached).any(axis=1) & ~np.isnan(written).any(axis=1)
    from olp.robots.kinematics.configuration import wrap

    told[told] = (np.abs(wrap(reached[told] - written[told])) > _NOISE).any(axis=1)
    count = int(told.sum())
    if count:
        where = "a straight move leads" if count == 1 else f"{count} straight moves lead"
        text = f"{where} to other arm flags than the current ones: the arm keeps its configuration"
        cell.gaps.setdefault("arm flags", Gap("arm flags", text))


def _same(one: Floats, other: Floats) -> NDArray[np.bool_]:
    """(...,) whether two sets of axes (..., k) are equal, or unknown in both."""
    near = (np.abs(one - other) < _NOISE) | (np.isnan(one) & np.isnan(other))
    return np.asarray(near.all(axis=-1))


@dataclass(slots=True)
class PlannedArm:
    """One arm among the positions of a plan. `tools` (p,): the tool's number of each."""

    robot: Robot
    cell: Cell
    positions: Positions
    tools: NDArray[np.int32]
    _known: dict[tuple[str | bytes, ...], Floats] = field(default_factory=dict)
    _lost: set[bytes] = field(default_factory=set)  # positions that cannot be reached from any start
    # Of each position, what does not depend on the way there, once it was asked for: after a line that has to be
    # followed, the lines behind it are decided again. Whether the flange is known (p,), its place (p, 3) [m] and
    # rotation (p, 3, 3); for each of the eight branches whether it is solved (8, p), the axes (8, p, k) [rad] and
    # whether the wrist is straight there (8, p).
    _flanges: tuple[NDArray[np.bool_], Floats, Floats] = field(init=False)
    _solved: tuple[NDArray[np.bool_], Floats, NDArray[np.bool_]] = field(init=False)

    def __post_init__(self) -> None:
        count = len(self.positions)
        self._flanges = np.zeros(count, dtype=bool), np.empty((count, 3)), np.empty((count, 3, 3))
        branches = np.zeros((2, 8, count), dtype=bool)
        self._solved = branches[0], np.empty((8, count, len(self.robot.axes))), branches[1]

    def follow(
        self, start: int, targets: NDArray[np.int32], joint: NDArray[np.bool_], says: NDArray[np.int8]
    ) -> Floats:
        """Axes (n, k) at `targets` (n,), indices of positions, one move after the other from the position `start`.

        `joint` (n,): joint moves. Where a line leads to flags as the arm has them, what they say stays.
        """
        width = len(self.robot.axes)
        result = self.positions.axes[targets][:, :width]
        here = self.positions.axes[start][:width]
        known = shelf("ways")
        if known is None:
            return self._follow(here, targets, joint, says, result)
        numbers, which = np.unique(self.tools[targets], return_inverse=True)
        tools = [self.cell.tool_pose(number) for number in numbers.tolist()]
        given = (here, result, self.positions.position[targets], self.positions.quaternion[targets])
        poses = (part for tool in tools for part in (tool.position, tool.rotation))
        rows = (*given, joint, says[targets], which, *poses)
        key = (id(self.robot), "follow", *(row.tobytes() for row in rows))
        found = known.get(key)
        if found is None:
            # With the robot, so that no other one gets its number.
            found = (self.robot, self._follow(here, targets, joint, says, result))
            known.put(key, found)
        axes: Floats = found[1].copy()
        return axes

    def _follow(
        self,
        here: Floats,
        targets: NDArray[np.int32],
        joint: NDArray[np.bool_],
        says: NDArray[np.int8],
        result: Floats,
    ) -> Floats:
        """As `follow`, from the axes `here` (k,), into `result` (n, k): the written axes at `targets`."""
        known = np.asarray(~np.isnan(result).any(axis=1))
        posed = np.asarray(says[targets] > 0)
        open_rows = (says[targets] >= WrittenPosture.NOTHING) | (posed & ~joint & self._changes(result, here))
        broken = joint | ~posed  # where runs along lines end
        self._settle(targets, result, known, open_rows, broken)
        breaks = np.append(np.flatnonzero(broken), len(targets))
        at, end = 0, 0
        for row in np.flatnonzero(open_rows).tolist():
            if row < at:
                continue
            before = np.flatnonzero(known[at:row])
            here = result[at + int(before[-1])] if len(before) else here
            if joint[row] or np.isnan(here).any():
                at = end = row + 1
                if not np.isnan(here).any():
                    result[row] = self._again(targets[row:at], here, self._nearest)
                here = here if np.isnan(result[row]).any() else result[row]
                continue
            at, end = row, int(breaks[np.searchsorted(breaks, row)])
            count = _AT_ONCE[0]
            while at < end:
                asked = targets[at : min(end, at + count)]
                rows = self._again(asked, here, self._along)
                result[at : at + len(rows)] = rows
                at += len(rows)
                # What stands behind an unsure line is solved again from there.
                count = min(2 * count, _AT_ONCE[1]) if len(rows) == len(asked) else _AT_ONCE[0]
                here = here if np.isnan(rows[-1]).any() else rows[-1]
        return result

    def _settle(
        self,
        targets: NDArray[np.int32],
        result: Floats,
        known: NDArray[np.bool_],
        open_rows: NDArray[np.bool_],
        broken: NDArray[np.bool_],
    ) -> None:
        """Solves all runs of lines that begin at written axes in one call: in most programs these are all.

        Writes axes into `result` (n, k) and updates `known` and `open_rows` (n,). Runs with an uncertain line are left.
        """
        if self.robot.geometry is None or self.robot.geometry.links is None:
            return
        run = np.cumsum(broken)
        begin = np.full(len(targets) + 1, len(targets))  # of each run: its first open row
        rows = np.flatnonzero(open_rows & ~broken)[::-1]
        begin[run[rows]] = rows
        before = begin[run] - 1
        written = (before >= 0) & (known & ~open_rows)[before]
        rows = np.flatnonzero(written & ~broken & (np.arange(len(targets)) > before))
        if not len(rows):
            return
        before = before[rows]
        joints, unsure = self._on_branch(targets[rows], result[before], rows == before + 1)
        sure = ~np.isin(before, before[unsure])
        rows = rows[sure]
        result[rows], known[rows], open_rows[rows] = joints[sure], True, False

    def _changes(self, axes: Floats, here: Floats) -> NDArray[np.bool_]:
        """(n,) where axes (n, k) change their branch, or jump, against the row before; the first row against `here`."""
        far = np.abs(np.diff(axes, axis=0, prepend=here[None])).max(axis=1) > _SUDDEN
        if self.robot.geometry is None or self.robot.geometry.links is None:
            return np.asarray(far)
        from olp.robots.kinematics.configuration import configuration_of

        flags = configuration_of(self.robot, np.concatenate([here[None], axes]))[:, :3]
        return np.asarray(far | (np.diff(flags, axis=0) != 0).any(axis=1))

    def _flange(self, targets: NDArray[np.int32]) -> tuple[Floats, Floats]:
        """Flange poses (n, 3) [m], (n, 3, 3) of positions."""
        known, place, turn = self._flanges
        new = targets[~known[targets]]
        if len(new):
            place[new], turn[new] = self._flange_of(new)
            known[new] = True
        return place[targets], turn[targets]

    def _flange_of(self, targets: NDArray[np.int32]) -> tuple[Floats, Floats]:
        position = self.positions.position[targets]
        rotation = rotation_from_quaternion(self.positions.quaternion[targets])
        for number in np.unique(self.tools[targets]).tolist():
            back = self.cell.tool_pose(number).inverse()
            own = self.tools[targets] == number
            position[own], rotation[own] = compose(position[own], rotation[own], back.position, back.rotation)
        return position, rotation

    def _nearest(self, targets: NDArray[np.int32], here: Floats) -> Floats:
        if self.robot.geometry is None or self.robot.geometry.links is not None:
            return self._sought(targets, here)
        return self._remembered(targets, here, self._sought)  # out of reach it takes thousands of steps

    def _sought(self, targets: NDArray[np.int32], here: Floats) -> Floats:
        from olp.robots.kinematics.inverse import nearest

        return nearest(self.robot, *self._flange(targets), here)

    def _again(
        self, targets: NDArray[np.int32], here: Floats, work: Callable[[NDArray[np.int32], Floats], Floats]
    ) -> Floats:
        """The cached result of `work` at `targets`, reached from `here`: loops pass them many times."""
        key = self._way(targets, here, work)
        found = self._known.get(key)
        if found is None:
            found = self._known[key] = work(targets, here)
        return found

    def _way(
        self, targets: NDArray[np.int32], here: Floats, work: Callable[[NDArray[np.int32], Floats], Floats]
    ) -> tuple[str | bytes, ...]:
        """The cache key of the result of `work` at `targets` from `here`."""
        given = (
            self.positions.position[targets],
            self.positions.quaternion[targets],
            self.tools[targets],
            np.round(here, _SAME_STAND),
        )
        return (work.__name__, *(one.tobytes() for one in given))

    def _along(self, targets: NDArray[np.int32], here: Floats) -> Floats:
        """Axes (m, k) at the first m of `targets`, one line after the other; m is 1 or more."""
        assert self.robot.geometry is not None
        closed_form = self.robot.geometry.links is not None
        alone = self._followed if closed_form else self._in_steps
        known = self._known.get(self._way(targets[:1], here, alone))
        if known is not None:  # a line that was followed alone before, whatever comes behind it now
            return known
        if not closed_form:
            return self._remembered(targets[:_FEWEST], here, self._step_by_step)
        first = np.arange(len(targets)) == 0
        joints, unsure = self._on_branch(targets, here[None], first)
        sure = int(unsure.argmax()) if unsure.any() else len(targets)
        return joints[:sure] if sure else self._again(targets[:1], here, self._followed)

    def _on_branch(
        self, targets: NDArray[np.int32], start: Floats, first: NDArray[np.bool_]
    ) -> tuple[Floats, NDArray[np.bool_]]:
        """Axes (m, k) at `targets` along lines, and for which of them (m,) they are uncertain.

        `start` (m, k) or (1, k): axes at the start of the run of lines that a target is in; `first` (m,): the first
        targets of runs.
        """
        from olp.robots.kinematics.configuration import configuration_of

        joints, straight = self._with_flags(targets, configuration_of(self.robot, start)[:, :3])
        steps = joints - np.where(first[:, None], start, np.roll(joints, 1, axis=0))
        turns = np.nan_to_num(np.rint(steps / _TURN))
        unsure = straight | ~(np.abs(steps - _TURN * turns) < _SUDDEN).all(axis=1)
        total = np.cumsum(turns, axis=0)
        begin = np.maximum.accumulate(np.where(first, np.arange(len(first)), 0))
        return joints - _TURN * (total - (total - turns)[begin]), unsure

    def _with_flags(
        self, targets: NDArray[np.int32], flags: NDArray[np.int64]
    ) -> tuple[Floats, NDArray[np.bool_]]:
        """Axes (m, k) at `targets` with `flags` (m, 3) or (1, 3) and no turns, and where (m,) the wrist is straight."""
        from olp.robots.kinematics.configuration import clearance
        from olp.robots.kinematics.inverse import inverse

        solved, joints, straight = self._solved
        branch = np.broadcast_to(flags @ (4, 2, 1), len(targets))
        new = np.flatnonzero(~solved[branch, targets])
        if len(new):
            at = branch[new], targets[new]
            joints[at], _ = inverse(
                self.robot, *self._flange(at[1]), np.broadcast_to(flags, (len(targets), 3))[new]
            )
            straight[at] = np.abs(clearance(self.robot, joints[at]).wrist) < 1e-6
            solved[at] = True
        return joints[branch, targets], straight[branch, targets]

    def _remembered(
        self, targets: NDArray[np.int32], here: Floats, work: Callable[[NDArray[np.int32], Floats], Floats]
    ) -> Floats:
        """As `_again`, with a cache that outlives the run: the result does not depend on speeds that are tried."""
        known = shelf("ways")
        if known is None:
            return work(targets, here)
        tool = self.cell.tool_pose(int(self.tools[targets[0]]))
        place = (here, *self._flange(targets), tool.position, tool.rotation)
        key = (id(self.robot), work.__name__, *(one.tobytes() for one in place))
        found = known.get(key)
        if found is None:
            found = (
                self.robot,
                work(targets, here),
            )  # the robot is kept with it, so that no other object gets its id
            known.put(key, found)
        axes: Floats = found[1]
        return axes

    def _followed(self, targets: NDArray[np.int32], here: Floats) -> Floats:
        """Axes (1, k) at the end of a line that is followed sample by sample."""
        return self._remembered(targets, here, self._tracked)

    def _tracked(self, targets: NDArray[np.int32], here: Floats) -> Floats:
        from olp.robots.kinematics.tracking import track

        target = int(targets[0])
        solved, found, _ = self._solved
        reached = bool((solved[:, target] & ~np.isnan(found[:, target]).any(axis=1)).any())
        # What one branch reaches needs no search among all eight; out of reach of all, no path leads there.
        if not reached and np.isnan(at_end := self._nearest(targets, here)).any():
            return at_end
        line = self._line(target, here, _SPACING, _TURNING, _FEWEST, _MOST)
        joints = track(self.robot, *line, here)[-1:]
        return self._nearest(targets, here) if np.isnan(joints).any() else joints

    def _step_by_step(self, targets: NDArray[np.int32], here: Floats) -> Floats:
        """As `_along`, for an arm whose axes are found from those of the step before."""
        from olp.robots.kinematics.inverse import farthest_flange, newton

        position, rotation = self._flange(targets)
        far = np.linalg.norm(position, axis=1) > farthest_flange(self.robot)
        # What was lost before ends what is solved together: it takes all steps, and nothing behind it is sure.
        lost = (self.positions.position[index].tobytes() in self._lost for index in targets[1:].tolist())
        far[1:] |= np.fromiter(lost, dtype=bool, count=len(targets) - 1)
        near = int(far.argmax()) if far.any() else len(targets)
        starts = np.broadcast_to(here, (near, len(here)))
        joints, solved = newton(self.robot, position[:near], rotation[:near], starts)
        unsure = ~solved | (np.abs(np.diff(joints, axis=0, prepend=here[None])) > _STEP_AXES).any(axis=1)
        sure = int(unsure.argmax()) if unsure.any() else near
        if sure:
            self._known[self._way(targets[:1], here, self._in_steps)] = joints[:1]
            return joints[:sure]
        return self._again(targets[:1], here, self._in_steps) if near else self._nearest(targets[:1], here)

    def _in_steps(self, targets: NDArray[np.int32], here: Floats) -> Floats:
        """Axes (1, k) at the end of a line along which each step begins where the one before ended."""
        from olp.robots.kinematics.inverse import newton

        seed = here[None]
        line = self._line(int(targets[0]), here, _STEP, _STEP_TURN, 1, _MOST)
        for position, rotation in zip(*line, strict=True):
            seed, solved = newton(self.robot, position[None], rotation[None], seed)
            if not solved[0]:
                found = self._nearest(targets, here)
                if np.isnan(found).any():
                    self._lost.add(self.positions.position[targets[0]].tobytes())
                return found
        return seed

    def _line(
        self, target: int, here: Floats, spacing: float, turning: float, fewest: int, most: int
    ) -> tuple[Floats, Floats]:
        """Flange poses (s, 3) [m], (s, 3, 3) on the tool's way from where the arm stands to a position."""
        from olp.robots.kinematics.configuration import forward

        tool = self.cell.tool_pose(int(self.tools[target]))
        place, turn = compose(*forward(self.robot, here), tool.position, tool.rotation)
        end, goal = self.positions.position[target], self.positions.quaternion[target]
        angle = float(rotation_angle(turn, rotation_from_quaternion(goal[None]))[0])
        wanted = max(float(np.linalg.norm(end - place[0])) / spacing, angle / turning)
        # To an unknown target there is no path.
        count = fewest if math.isnan(wanted) else max(math.ceil(min(wanted, most)), fewest)
        share = np.arange(1, count + 1) / count
        turned = slerp(
            np.repeat(quaternion_from_rotation(turn), count, axis=0),
            np.repeat(goal[None], count, axis=0),
            share,
        )
        back = tool.inverse()
        return compose(
            place + share[:, None] * (end - place),
            rotation_from_quaternion(turned),
            back.position,
            back.rotation,
        )


def axes_after(
    cell: Cell, mechanism: int, entries: Sequence[tuple[PointState, Sequence[float], bool]]
) -> Floats:
    """(k,) axes at the last of `entries`, positions as written in the order in which the arm takes them.

    Each with whether a joint move leads there. nan where they are not known.
    """
    robot = cell.robot(mechanism)
    width = len(robot.axes) if robot is not None else 6
    resolved = [
        cell.resolve(mechanism, state, np.asarray([row], dtype=np.float64)) for state, row, _ in entries
    ]
    axes = np.concatenate([r.axes[:, :width] for r in resolved])
    if robot is None or len(entries) < 2:
        last: Floats = axes[-1]
        return last
    positions = Positions(
        np.concatenate([r.position for r in resolved]),
        np.concatenate([quaternions(r) for r in resolved]),
        axes,
    )
    tools = np.array([state.tool for state, _, _ in entries], dtype=np.int32)
    says = np.concatenate(
        [says_of(cell, mechanism, state, r.axes) for (state, _, _), r in zip(entries, resolved, strict=True)]
    )
    joint = np.array([joint for _, _, joint in entries])
    order = np.arange(1, len(entries), dtype=np.int32)
    reached = PlannedArm(robot, cell, positions, tools).follow(0, order, joint[1:], says)
    after: Floats = reached[-1]
    return after
