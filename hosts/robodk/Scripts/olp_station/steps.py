"""What a program does, step after step, with the speed and acceleration that make a move take the predicted time.

SI throughout: m, s, rad.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import olp
from olp.core.diagnostic import OlpError, error, raise_errors
from olp.identification.apostolovic import adjusted_acceleration
from olp.ir.program import Move, Path, SetOutput
from olp.robots.geometry import (
    quaternion_from_rotation,
    rotation_from_angles,
    rotation_from_quaternion,
    slerp,
)
from olp.robots.kinematics import forward
from olp.runtime.plan import PATHS, BlendCode, Plan, StepKind
from olp.transpile.context import Context
from olp.transpile.link import link
from olp.transpile.pipeline import canonical

Floats = NDArray[np.float64]
# Where a rounded corner belongs to two moves at once, a move may be shorter than its length over its speed.
_SPARE = 1.25
_SAME = 1e-5  # [m, 1] between two values of one tool


class Motion(NamedTuple):
    """A move. `length` [m], of joint moves [rad] of the axis that turns furthest; `speed` and `acceleration` per s, s².

    `pose` in the robot's base, `axes` nan where unknown; `via` of an arc. `radius` of the rounded end, 0: exact stop.
    `frame`, `tool`: names in `Run.systems`, "" for the base and the flange.
    """

    path: Path
    pose: tuple[Floats, Floats]  # position (3,), quaternion (4,)
    axes: Floats
    via: tuple[Floats, Floats] | None
    length: float
    speed: float
    acceleration: float
    radius: float
    frame: str
    tool: str


class Step(NamedTuple):
    """One executed statement; `motion` None: it only takes time, or switches `output` (number, on)."""

    line: int
    statement: str
    duration: float
    motion: Motion | None = None
    output: tuple[int, bool] | None = None


class Run(NamedTuple):
    """`start`: the axes where the program begins. `systems`: ("tool" or "frame", name) -> position, quaternion."""

    name: str
    robot: str
    steps: tuple[Step, ...]
    start: Floats
    systems: dict[tuple[str, str], tuple[Floats, Floats]]
    assumptions: tuple[str, ...]

    @property
    def total(self) -> float:
        """[s]"""
        return sum(step.duration for step in self.steps)


def executed(path: str, robot: str | None = None, signature: str | None = None) -> Run:
    """Reads, runs and times the program. Raises OlpError: what olp cannot read or place in space."""
    program = olp.read(path)
    raise_errors(program.diagnostics)
    whole = link(program).program
    plan = whole.plan(robot=robot)
    raise_errors(plan.diagnostics)
    table = plan.time(signature=signature)
    names, systems = _systems(whole, plan)
    outputs = _outputs(whole)
    steps = []
    for number, row in enumerate(table.itertuples()):
        line = int(row.line)
        motion = None
        if StepKind(int(plan.kind[number])) is StepKind.MOVE:
            frame, tool = names.get(line, ("", ""))
            tool = _tool(plan, plan.rows_of(number)[0], tool, systems)
            motion = _motion(plan, number, float(row.duration_s), frame, tool, path)
        steps.append(Step(line, str(row.statement), float(row.duration_s), motion, outputs.get(line)))
    first = next((plan.rows_of(n)[0] for n in range(len(plan)) if plan.kind[n] == StepKind.MOVE), None)
    start = np.array([]) if first is None else plan.positions.axes[plan.moves.start[first]]
    name = plan.robot.name if plan.robot is not None else ""
    said = tuple(f"line {a.line}: {a.says}" if a.line else a.says for a in plan.assumptions)
    if len(plan.mechanisms) > 1:
        others = ", ".join(plan.mechanisms[1:])
        said = (f"only {plan.mechanisms[0]} is imported, without {others}", *said)
    main = program.main or (program.routines[0].name if program.routines else "program")
    return Run(main, name, tuple(steps), start, systems, said)


def _motion(plan: Plan, step: int, duration: float, frame: str, tool: str, file: str) -> Motion:
    moves, row = plan.moves, plan.rows_of(step)[0]
    start, end = int(moves.start[row]), int(moves.target[row])
    where = plan.positions
    if np.isnan(where.position[end]).any():
        says = "nobody knows where this move ends"
        line = int(plan.line[step])
        help = "name a robot whose geometry olp knows, with --robot"
        raise OlpError(error("T001", f"line {line}: {says}", file=file, help=help))
    path = PATHS[int(moves.path[row])]
    if path is Path.JOINT:
        ways = np.abs(where.axes[end] - where.axes[start])
        known = np.isfinite(ways)
        axis = int(np.argmax(np.where(known, ways, -1.0)))
        length = float(ways[axis]) if known.any() else 0.0
        speed = _axis_speed(plan, row, axis)
    else:
        length = float(moves.length[row])
        if path is Path.SPLINE:  # RoboDK has none: the chord
            length = float(np.linalg.norm(where.position[end] - where.position[start]))
        speed = float(moves.travel[row])
    speed, acceleration = reached(duration, length, speed)
    via = _between(plan, row) if path is Path.CIRCULAR else None
    exact = int(moves.blend_code[row]) == BlendCode.EXACT
    radius = 0.0 if exact or not math.isfinite(moves.blend[row]) else float(moves.blend[row])
    pose = (where.position[end], where.quaternion[end])
    return Motion(path, pose, where.axes[end], via, length, speed, acceleration, radius, frame, tool)


def reached(duration: float, length: float, speed: float) -> tuple[float, float]:
    """Speed and acceleration with which constant acceleration takes just `duration` from stop to stop; nan: no move.

    The programmed `speed` (nan: none known) is kept wherever there is an acceleration that makes it so.
    """
    if not duration > 0 or not length > 0:
        return math.nan, math.nan
    least = _SPARE * length / duration
    top = (
        least
        if not math.isfinite(speed)
        else max(speed, least if speed * duration <= length * 1.02 else speed)
    )
    return top, float(adjusted_acceleration(duration, length, top))


def _axis_speed(plan: Plan, row: int, axis: int) -> float:
    share, given = float(plan.moves.fraction[row]), float(plan.moves.axis_speed[row])
    if math.isfinite(given):
        return given
    if plan.robot is None or not math.isfinite(share):
        return math.nan
    return share * plan.robot.axes[axis].speed


def _between(plan: Plan, row: int) -> tuple[Floats, Floats]:
    """A point of the arc halfway to its end. A plan's third point may lie beyond: that of the next arc of a chain."""
    moves, where = plan.moves, plan.positions
    index = [int(i) for i in (moves.start[row], moves.target[row], moves.via[row])]
    start, end, third = (where.position[i] for i in index)
    turn = slerp(where.quaternion[index[0]], where.quaternion[index[1]], 0.5)
    if index[2] < 0 or not moves.length[row] > 0:
        return (start + end) / 2, turn
    centre, normal = _circle(start, end, third)
    arm = start - centre
    radius = float(np.linalg.norm(arm))
    if radius == 0 or not np.isfinite(radius):
        return (start + end) / 2, turn
    angle = float(moves.length[row]) / radius
    ends = [centre + _turned(arm, sign * normal, angle) for sign in (1, -1)]
    sign = 1 if np.linalg.norm(ends[0] - end) <= np.linalg.norm(ends[1] - end) else -1
    return centre + _turned(arm, sign * normal, angle / 2), turn


def _circle(a: Floats, b: Floats, c: Floats) -> tuple[Floats, Floats]:
    """Centre and unit normal of the circle through three points; nan when they lie on a line."""
    u, v = b - a, c - a
    normal = np.cross(u, v)
    square = float(normal @ normal)
    if square == 0:
        return np.full(3, np.nan), np.full(3, np.nan)
    centre = a + (np.cross(normal, u) * (v @ v) + np.cross(v, normal) * (u @ u)) / (2 * square)
    return centre, normal / math.sqrt(square)


def _turned(arm: Floats, axis: Floats, angle: float) -> Floats:
    turned: Floats = arm * math.cos(angle) + np.cross(axis, arm) * math.sin(angle)
    return turned


def _systems(
    program: olp.Program, plan: Plan
) -> tuple[dict[int, tuple[str, str]], dict[tuple[str, str], tuple[Floats, Floats]]]:
    """Line -> names of frame and tool, and their values: as a language says it that names both at every move.

    Empty where the program computes them: then everything stands in the robot's base.
    """
    other = "krl" if program.vendor == "rapid" else "rapid"  # a program of the same language stays as it is
    try:
        said = canonical(program, other, Context(plan.robot, on_loss="comment")).program
    except OlpError:
        return {}, {}
    values = {
        (d.type, d.name): _system(d.value)
        for d in said.data
        if d.type in ("tool", "frame") and getattr(d.value, "kind", "") == "pose"
    }
    names = {}
    for statement in said.statements():
        if isinstance(statement, Move):
            frame, tool = (getattr(s, "name", "") for s in (statement.frame, statement.tool))
            known = frame if ("frame", frame) in values else "", tool if ("tool", tool) in values else ""
            names[statement.line] = known
    return names, values


def _tool(plan: Plan, row: int, name: str, systems: dict[tuple[str, str], tuple[Floats, Floats]]) -> str:
    """The name of the tool that this move was planned with: what its end has beyond the flange.

    `name` where the program's tool of that name is the same; else the one in `systems` that is, or a new one there.
    """
    index = int(plan.moves.target[row])
    axes = plan.positions.axes[index : index + 1]
    if plan.robot is None or not np.isfinite(axes[:, : len(plan.robot.axes)]).all():
        return name
    flange, turn = (part[0] for part in forward(plan.robot, axes[:, : len(plan.robot.axes)]))
    position = turn.T @ (plan.positions.position[index] - flange)
    rotation = turn.T @ rotation_from_quaternion(plan.positions.quaternion[index])
    if np.abs(position).max() < _SAME and np.abs(rotation - np.eye(3)).max() < _SAME:
        return ""
    known = [name, *(n for kind, n in systems if kind == "tool")]
    for other in known:
        value = systems.get(("tool", other))
        if value is None or np.abs(value[0] - position).max() >= _SAME:
            continue
        if np.abs(rotation_from_quaternion(value[1]) - rotation).max() < _SAME:
            return other
    made = f"tool {len(known)}"
    systems["tool", made] = position, np.asarray(quaternion_from_rotation(rotation))
    return made


def _system(value: Any) -> tuple[Floats, Floats]:
    position, angles = np.array(value.values[:3]), np.array(value.values[3:6])
    return position, np.asarray(quaternion_from_rotation(rotation_from_angles(angles)))


def _outputs(program: olp.Program) -> dict[int, tuple[int, bool]]:
    """Line -> number and state of the digital output that it switches."""
    found = {}
    for statement in program.statements():
        if isinstance(statement, SetOutput) and statement.signal.bus == "out":
            number, value = getattr(statement.signal.index, "value", None), statement.value
            state = getattr(value, "on", getattr(value, "value", None))
            if isinstance(number, int) and isinstance(state, bool | int):
                found[statement.line] = (number, bool(state))
    return found
