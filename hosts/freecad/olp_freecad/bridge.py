"""Answers the workbench: one question as JSON on standard input, one answer on standard output.

Runs in the Python that has olp, in a process of its own, so that FreeCAD's Python needs nothing but itself.
Lengths are mm, orientations quaternions (x, y, z, w) as FreeCAD has them, times seconds.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import numpy as np

from olp.batch import Job, plan_and_time, time_program
from olp.diagnostic import Diagnostic, OlpError
from olp.edit import ChangeSpeed, PlacePoint, edited, speed_line, speed_of
from olp.files import write_output
from olp.geometry import Pose, quaternion_from_rotation, rotation_from_quaternion
from olp.kinematics import forward
from olp.moves import Move, Path, SetSpeed, SpeedUnit
from olp.placing import visits
from olp.plan import PATHS, StepKind
from olp.points import PointKind
from olp.program import Program
from olp.reading import read
from olp.timing import Timing
from olp.track import states
from olp.units import deg, mm, percent
from olp.written import written_points

_ON_LINE, _ON_CURVE = 10, 20  # pieces of a move that are drawn with a colour each
_MOST_PIECES = 20_000
_AFTER = 1e-6  # [s]
_UNITS = {
    SpeedUnit.TRAVEL: ("mm/s", mm),
    SpeedUnit.TURN: ("deg/s", deg),
    SpeedUnit.AXIS: ("deg/s of an axis", deg),
    SpeedUnit.FRACTION: ("%", percent),
    SpeedUnit.TIME: ("s", 1.0),
}


def main() -> int:
    """The answer, or what is wrong with the question, as JSON. Always 0: a question that failed is an answer."""
    request = json.load(sys.stdin)
    try:
        answer = {"open": opened, "track": tracked, "edit": rewritten}[request["do"]](request)
    except OlpError as problem:
        answer = {"problems": [_told(one) for one in problem.diagnostics]}
    except OSError as problem:
        answer = {"problems": [{"severity": "error", "text": str(problem), "line": 0}]}
    sys.stdout.write(json.dumps(answer, allow_nan=False))
    return 0


def _job(request: dict[str, Any]) -> Job:
    return Job(**{key: value for key, value in request.get("options", {}).items() if value})


def opened(request: dict[str, Any]) -> dict[str, Any]:
    """All that is shown of a program."""
    program = read(request["path"])
    timing = time_program(program, _job(request))
    segments = _segments(program, timing)
    return {
        "path": program.path,
        "language": program.vendor,
        "robot": timing.robot or "",
        "total_s": timing.total_s,
        "motion_s": timing.motion_s,
        "wait_s": timing.wait_s,
        "io_s": timing.io_s,
        "low_s": timing.low_s,
        "high_s": timing.high_s,
        "segments": segments,
        "points": _points(program, timing),
        "frames": _frames(program, timing),
        "tools": _tools(timing),
        "speeds": _speeds(program),
        "is_followed": not timing.untimed,
        "assumptions": [
            f"line {one.line}: {one.says}" if one.line else one.says for one in timing.assumptions
        ],
        "diagnostics": [_told(one) for one in dict.fromkeys((*program.diagnostics, *timing.diagnostics))],
    }


def tracked(request: dict[str, Any]) -> dict[str, Any]:
    """Where the tool is every `dt` seconds: times, places, and which segment is under way."""
    timing = plan_and_time(request["path"], _job(request))
    total = timing.total_s
    times = np.append(np.arange(0.0, total, max(request["dt"], total / 100_000)), total)
    position, rotation, _ = states(timing, times)
    ends = timing.end_s
    step = np.minimum(np.searchsorted(ends, times, side="left"), len(ends) - 1)
    quaternion = quaternion_from_rotation(np.where(np.isnan(rotation), np.eye(3), rotation))
    known = ~(np.isnan(position).any(axis=1) | np.isnan(rotation).any(axis=(1, 2)))
    return {
        "times": times[known].tolist(),
        "places": [_place(p, q) for p, q in zip(position[known], quaternion[known], strict=True)],
        "segments": step[known].tolist(),
    }


def rewritten(request: dict[str, Any]) -> dict[str, Any]:
    """The program with other points and speeds, written to `outputs` (path -> new path) or over itself."""
    program, job = read(request["path"]), _job(request)
    speeds = {one["line"]: one["value"] * one["scale"] for one in request["speeds"]}
    edits = [
        *(PlacePoint(one["name"], _pose(one["place"])) for one in request["points"]),
        *(ChangeSpeed(line, value) for line, value in speeds.items()),
    ]
    plan = time_program(program, job).plan if request["points"] else None
    result = edited(program, edits, plan, lambda changed: time_program(changed, job).plan)
    outputs = request.get("outputs") or {}
    for source in result.sources:
        target = outputs.get(source.path, source.path)
        write_output(target, source.raw, inputs=[source.path], in_place=target == source.path)
    return {
        "lines": [list(one) for one in result.lines],
        "files": [one.path for one in result.sources],
        "notes": [_told(one) for one in result.notes],
    }


def _segments(program: Program, timing: Timing) -> list[dict[str, Any]]:
    plan = timing.plan
    named = {one.step: one.name for one in visits_of(program, timing) if not one.is_via}
    moves = int((plan.kind == StepKind.MOVE).sum())
    ends = timing.end_s
    can_follow = not timing.untimed and moves > 0
    found = []
    for step, told in enumerate(timing.segments()):
        told["point"] = named.get(step)
        told["own"] = told["file"] == program.path
        told["start_s"] = float(ends[step]) - (told["duration_s"] or 0.0)
        if int(plan.kind[step]) == StepKind.MOVE:
            told.update(_course(timing, step, float(ends[step]), moves, can_follow))
        found.append(told)
    return found


def _course(timing: Timing, step: int, end: float, moves: int, can_follow: bool) -> dict[str, Any]:
    """`way`: instants and places of a move as the tool really runs; `target`: where it is programmed to go."""
    plan = timing.plan
    row = int(plan.row[step])
    path = PATHS[int(plan.moves.path[row])]
    target = _known(plan, int(plan.moves.target[row]))
    duration = float(np.nan_to_num(timing.duration_s[step]))
    start = _known(plan, int(plan.moves.start[row]))
    course = {"path": path.value, "target": target, "start": start, "way": []}
    if target is None or (can_follow and duration <= 0.0):
        return course
    if not can_follow:
        # Some time is not known, so nothing can be followed: straight from point to point.
        course["way"] = [] if start is None else [[end - duration, start], [end, target]]
        return course
    count = _ON_LINE if path is Path.LINEAR else _ON_CURVE
    count = max(1, min(count, _MOST_PIECES // moves))
    # Nearer together at both ends, where the speed changes.
    times = end - duration * 0.5 * (1.0 + np.cos(np.linspace(0.0, np.pi, count + 1)))
    # At its very start the tool may still be the one before.
    seen = np.maximum(times, end - duration + min(_AFTER, 0.01 * duration))
    position, rotation, _ = states(timing, np.clip(seen, 0.0, timing.total_s))
    if np.isnan(position).any() or np.isnan(rotation).any():
        return course
    places = [_place(p, q) for p, q in zip(position, quaternion_from_rotation(rotation), strict=True)]
    course["way"] = [[float(t), place] for t, place in zip(times, places, strict=True)]
    course["jump"] = _jump(plan, row, position)
    return course


def _jump(plan: Any, row: int, position: Any) -> int:
    """The piece (from 1) in which the next move's tool is taken, where its tip is elsewhere; 0: none."""
    if row + 1 >= len(plan.moves):
        return 0
    there, here = plan.moves.start[row + 1], plan.moves.target[row]
    jump = plan.positions.position[there] - plan.positions.position[here]
    if not float(np.linalg.norm(jump)) > 1.0 * mm:
        return 0
    off = np.linalg.norm(np.diff(position, axis=0) - jump, axis=1)
    piece = int(np.argmin(off))
    return piece + 1 if off[piece] < 0.5 * np.linalg.norm(jump) else 0


def _points(program: Program, timing: Timing) -> list[dict[str, Any]]:
    """Where the positions that can be moved are; none that the program computes with."""
    found: dict[str, dict[str, Any]] = {}
    written, computed = written_points_of(program), _computed(program, timing)
    for one in visits_of(program, timing):
        if one.pose is None or one.name in computed:
            continue
        point = written[one.name]
        entry = found.setdefault(
            one.name,
            {
                "name": one.name,
                "line": point.line,
                "file": point.source.path,
                "kind": point.kind.value,
                "place": _place_of(one.pose),
                "via": one.is_via,
                "segments": [],
            },
        )
        entry["segments"].append(one.step)
    return list(found.values())


def _seen_frames(program: Program, timing: Timing) -> list[tuple[str, object, Pose]]:
    """Point, the frame that its move names, and the frame as the program runs: the tool seen from the numbers."""
    written = written_points_of(program)
    moves = {one.line: one for one in program.statements() if isinstance(one, Move)}
    found = []
    for one in visits_of(program, timing):
        point = written[one.name]
        if one.pose is not None and point.kind is PointKind.POSE:
            frame = moves[int(timing.plan.line[one.step])].frame
            found.append((one.name, frame, one.pose @ point.pose().inverse()))
    return found


def _computed(program: Program, timing: Timing) -> set[str]:
    """Points that stand in several frames although their moves name one: the program changes them on the way."""
    first: dict[tuple[str, str], Pose] = {}
    found = set()
    for name, frame, pose in _seen_frames(program, timing):
        if not _alike(first.setdefault((name, repr(frame)), pose), pose):
            found.add(name)
    return found


def _frames(program: Program, timing: Timing) -> list[dict[str, Any]]:
    """The frames that positions stand in, the base left out."""
    found: list[tuple[str, Pose]] = []
    computed = _computed(program, timing)
    for point, frame, pose in _seen_frames(program, timing):
        known = any(_alike(pose, other) for other in (Pose.identity(), *(one for _, one in found)))
        if point not in computed and not known:
            name = getattr(frame, "name", "") or _frame_name(program, point) or f"frame of {point}"
            found.append((name, pose))
    return [{"name": name, "place": _place_of(pose)} for name, pose in found]


def _alike(one: Pose, other: Pose) -> bool:
    return bool(
        np.allclose(one.position, other.position, atol=0.05 * mm)
        and np.allclose(one.rotation, other.rotation, atol=1e-4)
    )


def _frame_name(program: Program, point: str) -> str:
    target = written_points_of(program)[point].target
    for routine in program.routines:
        number = getattr(target, "number", None)
        store = getattr(target, "store", None)
        state = None if number is None else routine.points.find(store, True, number)
        if state is not None and state.state.frame == "user":
            return f"user {state.state.user}"
    return ""


def _tools(timing: Timing) -> list[dict[str, Any]]:
    """Tool centre points seen from the flange, where the robot is known; from which segment on."""
    plan = timing.plan
    robot = plan.robot
    found: list[tuple[int, Pose]] = []
    for step in np.flatnonzero(plan.kind == StepKind.MOVE).tolist() if robot is not None else ():
        assert robot is not None
        at = int(plan.moves.target[int(plan.row[step])])
        axes = plan.positions.axes[at][: len(robot.axes)]
        if np.isnan(axes).any() or np.isnan(plan.positions.position[at]).any() or robot.geometry is None:
            continue
        flange = Pose(*(one[0] for one in forward(robot, axes[None])))
        rotation = rotation_from_quaternion(plan.positions.quaternion[at])
        tool = flange.inverse() @ Pose(plan.positions.position[at], rotation)
        if not found or not _alike(found[-1][1], tool):
            found.append((step, tool))
    return [{"segment": step, "place": _place_of(tool)} for step, tool in found]


def _speeds(program: Program) -> list[dict[str, Any]]:
    """The speeds that can be changed, by line: that of the move where it is its alone, else of what sets it."""
    found: dict[int, dict[str, Any]] = {}
    told: set[int | None] = set()
    statements = [one for one in program.statements() if isinstance(one, Move | SetSpeed) and one.line > 0]
    for one in sorted(statements, key=lambda one: isinstance(one, SetSpeed)):
        try:
            speed, line = speed_of(program, one.line), speed_line(program, one.line)
        except OlpError:
            return []
        if speed is None or speed.value.literal is None or line in told:
            continue
        told.add(line)
        unit, scale = _UNITS[speed.unit]
        value = round(speed.value.literal / scale, 6)
        text = program.source.line(one.line).strip()
        found[one.line] = {"line": one.line, "statement": text, "value": value, "unit": unit, "scale": scale}
    return [found[line] for line in sorted(found)]


def written_points_of(program: Program) -> dict[str, Any]:
    """None for languages that olp only reads."""
    try:
        return dict(written_points(program))
    except OlpError:
        return {}


def visits_of(program: Program, timing: Timing) -> list[Any]:
    return list(visits(program, timing.plan)) if written_points_of(program) else []


def _known(plan: Any, at: int) -> dict[str, Any] | None:
    position, quaternion = plan.positions.position[at], plan.positions.quaternion[at]
    return None if np.isnan(position).any() or np.isnan(quaternion).any() else _place(position, quaternion)


def _place(position: Any, quaternion: Any) -> dict[str, Any]:
    w, x, y, z = (float(v) for v in quaternion)
    return {"position": [float(v) / mm for v in position], "quaternion": [x, y, z, w]}


def _place_of(pose: Pose) -> dict[str, Any]:
    return _place(pose.position, quaternion_from_rotation(pose.rotation))


def _pose(place: dict[str, Any]) -> Pose:
    x, y, z, w = place["quaternion"]
    return Pose(np.asarray(place["position"]) * mm, rotation_from_quaternion([w, x, y, z]))


def _told(one: Diagnostic) -> dict[str, Any]:
    where = f"line {one.line}: " if one.line else ""
    text = f"{where}{one.message} [{one.code}]" + (f"; {one.help}" if one.help else "")
    return {"severity": one.severity.value, "text": text, "line": one.line, "file": one.file}


if __name__ == "__main__":
    sys.exit(main())
