"""Answers the workbench: one question as JSON on standard input, one answer on standard output.

Runs in the Python that has olp, in a process of its own, so that FreeCAD's Python needs nothing but itself.
Lengths are mm, orientations quaternions (x, y, z, w) as FreeCAD has them, times seconds.
"""

from __future__ import annotations

import contextlib
import json
import sys
from typing import Any

import numpy as np

from olp.checks.edit import ChangeSpeed, PlacePoint, Visit, edited, visits
from olp.core.diagnostic import Diagnostic, OlpError
from olp.core.files import write_output
from olp.core.units import deg, mm, percent
from olp.fluent import read
from olp.ir.points import PointKind
from olp.ir.program import Move, Path, Program, SpeedUnit
from olp.languages.literals import WrittenPoint, speeds, written_points
from olp.reports.batch import Job, plan_and_time, time_program
from olp.robots.geometry import Pose, quaternion_from_rotation, rotation_from_quaternion
from olp.robots.kinematics import forward
from olp.runtime.plan import PATHS, StepKind
from olp.timing.result import Timing
from olp.timing.track import states

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
    scene = _Scene(program, timing)
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
        "segments": _segments(scene),
        "points": _points(scene),
        "frames": _frames(scene),
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
    values = {one["line"]: one["value"] * one["scale"] for one in request["speeds"]}
    edits = [
        *(PlacePoint(one["name"], _pose(one["place"])) for one in request["points"]),
        *(ChangeSpeed(line, value) for line, value in values.items()),
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


class _Scene:
    """A program and its times, with what several answers are made of."""

    def __init__(self, program: Program, timing: Timing) -> None:
        self.program, self.timing, self.plan = program, timing, timing.plan
        self.written: dict[str, WrittenPoint] = {}
        self.visits: list[Visit] = []
        # In a language that olp only reads nothing can be moved.
        with contextlib.suppress(OlpError):
            self.written = written_points(program)
            self.visits = list(visits(program, timing.plan))
        self.moves = {one.line: one for one in program.statements() if isinstance(one, Move)}
        self.frames = self._frames()
        # Points that stand in several frames although their moves name one: the program changes them on the way.
        self.computed: set[str] = set()
        first: dict[tuple[str, str], Pose] = {}
        for name, frame, pose in self.frames:
            if not _alike(first.setdefault((name, repr(frame)), pose), pose):
                self.computed.add(name)

    def _frames(self) -> list[tuple[str, object, Pose]]:
        """Point, the frame that its move names, and the frame as the program runs: the tool seen from the numbers."""
        found = []
        for one in self.visits:
            point = self.written[one.name]
            if one.pose is not None and point.kind is PointKind.POSE:
                frame = self.moves[int(self.plan.line[one.step])].frame
                found.append((one.name, frame, one.pose @ point.pose().inverse()))
        return found


def _segments(scene: _Scene) -> list[dict[str, Any]]:
    plan, timing = scene.plan, scene.timing
    named = {one.step: one.name for one in scene.visits if not one.is_via}
    ends = timing.end_s
    courses = _courses(timing)
    found = []
    for step, told in enumerate(timing.segments()):
        told["point"] = named.get(step)
        told["own"] = told["file"] == scene.program.path
        told["start_s"] = float(ends[step]) - (told["duration_s"] or 0.0)
        if int(plan.kind[step]) == StepKind.MOVE:
            told.update(_course(timing, step, courses))
        found.append(told)
    return found


def _courses(timing: Timing) -> dict[int, tuple[Any, Any, Any]]:
    """Step -> instants, positions and rotations of each move that can be followed; none where a time is unknown."""
    plan, ends = timing.plan, timing.end_s
    durations = np.nan_to_num(timing.duration_s)
    steps = [s for s in np.flatnonzero(plan.kind == StepKind.MOVE).tolist() if durations[s] > 0.0]
    if timing.untimed or not steps:
        return {}
    times: dict[int, Any] = {}
    for step in steps:
        is_line = PATHS[int(plan.moves.path[int(plan.row[step])])] is Path.LINEAR
        count = max(1, min(_ON_LINE if is_line else _ON_CURVE, _MOST_PIECES // len(steps)))
        # Nearer together at both ends, where the speed changes.
        shares = 0.5 * (1.0 + np.cos(np.linspace(0.0, np.pi, count + 1)))
        times[step] = ends[step] - durations[step] * shares
    seen = np.concatenate(list(times.values()))
    # At its very start the tool may still be the one before.
    after = [np.full(len(times[s]), ends[s] - durations[s] + min(_AFTER, 0.01 * durations[s])) for s in steps]
    seen = np.clip(np.maximum(seen, np.concatenate(after)), 0.0, timing.total_s)
    position, rotation, _ = states(timing, np.maximum.accumulate(seen))
    cuts = np.cumsum([len(times[step]) for step in steps])[:-1]
    parts = zip(steps, np.split(position, cuts), np.split(rotation, cuts), strict=True)
    return {step: (times[step], p, r) for step, p, r in parts}


def _course(timing: Timing, step: int, courses: dict[int, tuple[Any, Any, Any]]) -> dict[str, Any]:
    """`way`: instants and places of a move as the tool really runs; `target`: where it is programmed to go."""
    plan, end = timing.plan, float(timing.end_s[step])
    row = int(plan.row[step])
    target, start = (_known(plan, int(at[row])) for at in (plan.moves.target, plan.moves.start))
    course = {"path": PATHS[int(plan.moves.path[row])].value, "target": target, "start": start, "way": []}
    if target is None or start is None:
        return course
    if timing.untimed:
        # Some time is not known, so nothing can be followed: straight from point to point.
        course["way"] = [[end - float(np.nan_to_num(timing.duration_s[step])), start], [end, target]]
    elif step in courses:
        times, position, rotation = courses[step]
        if not (np.isnan(position).any() or np.isnan(rotation).any()):
            places = zip(position, quaternion_from_rotation(rotation), strict=True)
            course["way"] = [[float(t), _place(*one)] for t, one in zip(times, places, strict=True)]
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


def _points(scene: _Scene) -> list[dict[str, Any]]:
    """Where the positions that can be moved are; none that the program computes with."""
    found: dict[str, dict[str, Any]] = {}
    for one in scene.visits:
        if one.pose is None or one.name in scene.computed:
            continue
        point = scene.written[one.name]
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


def _frames(scene: _Scene) -> list[dict[str, Any]]:
    """The frames that positions stand in, the base left out."""
    found: list[tuple[str, Pose]] = []
    for point, frame, pose in scene.frames:
        known = any(_alike(pose, other) for other in (Pose.identity(), *(one for _, one in found)))
        if point not in scene.computed and not known:
            name = getattr(frame, "name", "") or _frame_name(scene, point) or f"frame of {point}"
            found.append((name, pose))
    return [{"name": name, "place": _place_of(pose)} for name, pose in found]


def _alike(one: Pose, other: Pose) -> bool:
    return bool(
        np.allclose(one.position, other.position, atol=0.05 * mm)
        and np.allclose(one.rotation, other.rotation, atol=1e-4)
    )


def _frame_name(scene: _Scene, point: str) -> str:
    target = scene.written[point].target
    for routine in scene.program.routines:
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
    try:
        spoken = speeds(program)
    except OlpError:
        return []
    moves = {one.line for one in program.statements() if isinstance(one, Move)}
    told: set[int] = set()
    found: dict[int, dict[str, Any]] = {}
    for one in sorted(spoken, key=lambda one: one.line not in moves):
        if one.written in told or one.line <= 0 or one.speed.value.literal is None:
            continue
        told.add(one.written)
        unit, scale = _UNITS[one.speed.unit]
        value = round(one.speed.value.literal / scale, 6)
        text = program.source.line(one.line).strip()
        found[one.line] = {"line": one.line, "statement": text, "value": value, "unit": unit, "scale": scale}
    return [found[line] for line in sorted(found)]


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
