"""What a program does instead of what it says: its executed moves, waits and signals in a row."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from olp.ir import program as st
from olp.ir.expressions import Expression, FrameRef, Number, PositionLiteral, Quantity, SignalState
from olp.robots.geometry import Pose, rotation_from_quaternion, slerp
from olp.robots.kinematics.configuration import forward
from olp.runtime.paths import point_on_arc
from olp.runtime.plan import Plan, StepKind
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.records import literal_of

_BASE = FrameRef("base")
_DIGITS = 8  # of a tool [m, rad]: one tool is one value at all its positions


def executed(program: st.Program, work: TranslationContext) -> st.Program:
    """The plan of the source as one routine: every position in the base, or in joint values where no robot is known.

    The tool of a move is what stands between the flange, where the robot's axes put it, and the position.
    """
    plan = work.plan()
    if plan is None or not program.routines:
        work.lose(0, Fate.REFUSED, "statement", "the program cannot be run")
        return program
    by_line: dict[int, list[st.Statement]] = {}
    for s in program.statements():
        by_line.setdefault(s.line, []).append(s)
    rows: list[st.Statement] = [st.Begin(0)]
    for step in range(len(plan)):
        if plan.source[step] == 0:
            rows += _step(plan, step, by_line.get(int(plan.line[step]), []), work)
    name = program.main or program.routines[0].name
    main = next(r for r in program.routines if r.name == name)
    only = replace(main, body=(*rows, st.End(0)), parameters=(), returns="")
    return replace(program, routines=(only,), main=name)


def _step(plan: Plan, step: int, written: list[st.Statement], work: TranslationContext) -> list[st.Statement]:
    kind = StepKind(int(plan.kind[step]))
    line = int(plan.line[step])
    if kind is StepKind.MOVE:
        move = next((s for s in written if isinstance(s, st.Move)), None)
        return [] if move is None else _move(plan, step, move, work)
    if kind is StepKind.WAIT:
        wait = next((s for s in written if isinstance(s, st.Wait)), None)
        seconds = float(plan.durations[int(plan.row[step])])
        return [wait] if wait is not None else [st.Dwell(line, Quantity(Number(seconds), 1.0))]
    for s in written:
        if isinstance(s, st.SetOutput):
            if not isinstance(s.value, (SignalState, Number)):
                work.lose(s, Fate.REFUSED, "statement", "an output that takes a computed value")
            return [s]
        if isinstance(s, (st.PulseOutput, st.Message)):
            return [s]
    return []


def _move(plan: Plan, step: int, s: st.Move, work: TranslationContext) -> list[st.Statement]:
    row = int(plan.row[step])
    at = int(plan.moves.target[row])
    if row and s.path is not st.Path.JOINT and plan.moves.length[row] == 0.0 and plan.moves.angle[row] == 0.0:
        return []  # the point that an arc begins at: the arm is there
    target = _literal(plan, at, s.path is st.Path.JOINT)
    if target is None:
        work.need_robot(s, "where a move leads is known by its robot only")
        return [s]
    changes: dict[str, Any] = {
        "targets": (target,),
        "frame": _BASE,
        "relative": None,
        "offset": None,
        "tool_offset": None,
    }
    if s.via is not None:
        changes |= _arc(plan, row)
    tool = _tool(plan, at)
    if tool is not None:
        changes["tool"] = tool
    return [replace(s, **changes)]


def _arc(plan: Plan, row: int) -> dict[str, Any]:
    """A point half on the way of the arc, which ends at the target; a way through three points of a line is straight.

    The plan's own third point of an arc lies beyond its target.
    """
    if plan.moves.via[row] < 0:
        return {"via": None, "arc": None, "path": st.Path.LINEAR}
    rows = np.array([row])
    start, target, third = (getattr(plan.moves, name)[rows] for name in ("start", "target", "via"))
    where = plan.positions.position
    middle = point_on_arc(
        where[start], where[target], where[third], plan.moves.before[rows], np.array([0.5])
    )[0]
    turn = slerp(plan.positions.quaternion[start], plan.positions.quaternion[target], np.array([0.5]))[0]
    return {"via": literal_of(Pose(middle, rotation_from_quaternion(turn))), "arc": None}


def _tool(plan: Plan, at: int) -> PositionLiteral | None:
    """The tool with which the arm is at a position, None where its axes or the position are not known."""
    robot, axes = plan.robot, plan.positions.axes[at]
    position, turn = plan.positions.position[at], plan.positions.quaternion[at]
    if robot is None or robot.geometry is None or np.isnan(position).any():
        return None
    joints = axes[: len(robot.axes)]
    if np.isnan(joints).any():
        return None
    places, turns = forward(robot, joints[None])
    tool = Pose(places[0], turns[0]).inverse() @ Pose(position, rotation_from_quaternion(turn))
    values = literal_of(tool).values
    return PositionLiteral("pose", tuple(round(v, _DIGITS) + 0.0 for v in values))


def _literal(plan: Plan, at: int, joints: bool) -> Expression | None:
    """A pose in the base; of a joint move the axes where they are known."""
    positions = plan.positions
    axes = positions.axes[at][: len(plan.robot.axes) if plan.robot is not None else 6]
    if joints and not (axes != axes).any():
        return PositionLiteral("joint", tuple(axes.tolist()))
    position, turn = positions.position[at], positions.quaternion[at]
    if (position != position).any():
        return None
    return literal_of(Pose(position, rotation_from_quaternion(turn)))
