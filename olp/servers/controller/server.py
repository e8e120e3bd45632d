"""The stepping controller behind a TCP socket of this machine, for simulators in any language."""

from __future__ import annotations

import json
import math
import os
import socket
import socketserver
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from threading import Lock
from typing import Any, Final, NamedTuple, NoReturn

from olp.core.diagnostic import Diagnostic, OlpError, error
from olp.core.files import parse_json
from olp.core.units import deg, mm, percent
from olp.ir.program import Path
from olp.robots import EXAMPLE_ROBOT
from olp.robots.controller_effects import SETTINGS
from olp.robots.geometry import Pose
from olp.robots.model import Robot
from olp.robots.robot import load_robot, robot_names
from olp.servers.controller.controller import DEFAULT_CYCLE, Controller, State, Step
from olp.servers.controller.target import Target

HOST: Final = "127.0.0.1"  # never reachable from elsewhere: the protocol asks nobody who they are
MOST_SESSIONS: Final = 8
PATIENCE: Final = 3600.0  # [s] without a request, then the session ends
IDLE: Final = 60.0  # [s] without a request, then a session makes room for another one that is wanted

_BUSY = (
    b'{"ok": false, "diagnostics": [{"code": "S014", "severity": "error", '
    b'"message": "too many sessions at once", "help": "close another one first"}]}\n'
)


class _Handler(socketserver.StreamRequestHandler):
    """One connection is one session."""

    server: ControllerServer
    timeout = PATIENCE
    disable_nagle_algorithm = True  # a simulator waits for each answer

    def handle(self) -> None:
        if not self.server.admits(self.connection):
            self.wfile.write(_BUSY)
            return
        try:
            self._serve(Session())
        except OSError:
            pass  # the simulator has gone, or its place was given to another one
        finally:
            self.server.leaves(self.connection)

    def _serve(self, session: Session) -> None:
        while line := self.rfile.readline(LONGEST_LINE + 1):
            self.server.hears(self.connection)
            answer = session.answer(line)
            self.wfile.write(answer.line)
            self.server.hears(self.connection)
            if answer.last:
                return


class ControllerServer(socketserver.ThreadingTCPServer):
    """Serves until `shutdown`. Raises OlpError S015 for a port that cannot be had."""

    # Elsewhere it lets a server come back at once; on Windows two could share a port.
    allow_reuse_address = os.name != "nt"
    daemon_threads = True

    def __init__(self, port: int) -> None:
        self._heard: dict[socket.socket, float] = {}  # session -> when it last asked something [s]
        self._lock = Lock()
        try:
            super().__init__((HOST, port), _Handler)
        except (OSError, OverflowError) as problem:
            why = getattr(problem, "strerror", None) or str(problem)
            raise OlpError(
                error(
                    "S015", f"cannot listen on port {port}: {why}", help="another --port; 0 takes a free one"
                )
            ) from None

    def admits(self, session: socket.socket) -> bool:
        """Whether there is a place; the session that has been silent for longest, and long, makes room."""
        with self._lock:
            if len(self._heard) >= MOST_SESSIONS:
                silent = min(self._heard, key=lambda known: self._heard[known])
                if time.monotonic() - self._heard[silent] < IDLE:
                    return False
                del self._heard[silent]
                with suppress(OSError):
                    silent.shutdown(socket.SHUT_RDWR)
            self._heard[session] = time.monotonic()
            return True

    def hears(self, session: socket.socket) -> None:
        """Notes that a session has asked something, or was answered. Bytes that are no whole request do not count."""
        with self._lock:
            if session in self._heard:
                self._heard[session] = time.monotonic()

    def leaves(self, session: socket.socket) -> None:
        """Gives the place back."""
        with self._lock:
            self._heard.pop(session, None)

    @property
    def port(self) -> int:
        """The port it listens on."""
        port: int = self.socket.getsockname()[1]
        return port


# --- Session ---
# One simulator's session in lines of JSON: what it asks, and the answer. `docs/controller.md` is the reference.
#
# Bytes in, bytes out: nothing here knows of sockets, files or programs, and nothing that is sent is executed.

LONGEST_LINE: Final = 65_536  # [bytes]
MOST_STEPS: Final = 1_000  # per request
PROTOCOL: Final = 1

Fields = dict[str, Any]
_POSE = 6


class SessionReply(NamedTuple):
    line: bytes  # with its line end
    last: bool = False  # the session is over


class Session:
    """Answers request by request. Every request gets one line: {"ok": true, …} or {"ok": false, "diagnostics": […]}."""

    def __init__(self) -> None:
        self._controller: Controller | None = None
        self._requests: Mapping[str, Callable[[Fields], Fields]] = {
            "hello": self._hello,
            "robot": self._robot,
            "tool": lambda fields: self._place(fields, self._arm().set_tool),
            "frame": lambda fields: self._place(fields, self._arm().set_frame),
            "position": self._position,
            "target": self._target,
            "wait": self._wait,
            "end": self._end,
            "step": self._step,
            "bye": lambda fields: _done(fields, {}),
        }

    def answer(self, line: bytes) -> SessionReply:
        """The answer to one request. A line that is no request ends the session."""
        try:
            request = _parsed(line)
        except OlpError as problem:
            return SessionReply(_failed(problem.diagnostics), last=True)
        name = request.pop("do", None)
        try:
            work = self._requests.get(name) if isinstance(name, str) else None
            if work is None:
                known = ", ".join(self._requests)
                raise OlpError(
                    error("S011", f"there is no request {str(name)[:40]!r}", help=f"known: {known}")
                )
            return SessionReply(_line({"ok": True, **work(request)}), last=name == "bye")
        except OlpError as problem:
            return SessionReply(_failed(problem.diagnostics))

    def _arm(self) -> Controller:
        if self._controller is None:
            raise OlpError(
                error("S013", "no robot was named yet", help=f'{{"do": "robot", "name": "{EXAMPLE_ROBOT}"}}')
            )
        return self._controller

    def _hello(self, fields: Fields) -> Fields:
        from olp.core.version import __version__

        return _done(fields, {"olp": __version__, "protocol": PROTOCOL, "robots": list(robot_names())})

    def _robot(self, fields: Fields) -> Fields:
        name = fields.pop("name", None)
        # A name is looked up in the library only: a session opens no file of its choosing.
        if name not in robot_names():
            raise OlpError(
                error("S012", f"the library has no robot {str(name)[:60]!r}", help="hello lists them")
            )
        model = fields.pop("model", "constant")
        if not isinstance(model, str):
            _wrong("model", "a name in quotes")
        acceleration = _number(fields, "accel_mm_s2", None)
        settings = {key: _number(fields, key, 0.0) for key in SETTINGS if key in fields and key != "cycle_s"}
        cycle = _number(fields, "cycle_s", DEFAULT_CYCLE)
        if acceleration is not None and acceleration <= 0:
            _wrong("accel_mm_s2", "above zero")
        _done(fields, {})
        robot = load_robot(name)
        self._controller = Controller(
            robot,
            model=model,
            cycle=cycle or 0.0,
            acceleration=None if acceleration is None else acceleration * mm,
            settings={key: value for key, value in settings.items() if value is not None},
        )
        return {"axes": list(robot.axis_names), "cycle_s": self._controller.cycle}

    def _place(self, fields: Fields, put: Callable[[Pose], None]) -> Fields:
        pose = _pose(fields, "pose_mm_deg")
        if pose is None:
            _wrong("pose_mm_deg", "six numbers: x, y, z in mm, Rx, Ry, Rz in deg")
        put(pose)
        return _done(fields, {})

    def _position(self, fields: Fields) -> Fields:
        arm = self._arm()
        joints = _joints(fields, "joints_deg", arm.robot)
        if joints is None:
            _wrong("joints_deg", "one number per axis, deg (a slide: mm)")
        _done(fields, {})
        arm.set_position(joints)
        return {}

    def _target(self, fields: Fields) -> Fields:
        arm = self._arm()
        path = fields.pop("path", None)
        if path not in tuple(Path):
            _wrong("path", f"one of {', '.join(Path)}")
        kind = Path(path)
        speed = (
            _number(fields, "speed_pct", None) if kind is Path.JOINT else _number(fields, "speed_mm_s", None)
        )
        turn, zone = _number(fields, "turn_deg_s", None), _number(fields, "zone_mm", 0.0)
        shares = [_number(fields, f"{name}_pct", 100.0) for name in ("acceleration", "deceleration")]
        target = Target(
            path=kind,
            joints=_joints(fields, "joints_deg", arm.robot),
            pose=_pose(fields, "pose_mm_deg"),
            speed=None if speed is None else speed * (percent if kind is Path.JOINT else mm),
            turn=None if turn is None else turn * deg,
            zone=None if zone is None else zone * mm,
            via=_pose(fields, "via_mm_deg"),
            acceleration=(shares[0] or 0.0) * percent,
            deceleration=(shares[1] or 0.0) * percent,
        )
        _done(fields, {})
        return {"target": arm.target(target)}

    def _wait(self, fields: Fields) -> Fields:
        seconds = _number(fields, "seconds", 0.0)
        _done(fields, {})
        return {"target": self._arm().wait(seconds or 0.0)}

    def _end(self, fields: Fields) -> Fields:
        _done(fields, {})
        self._arm().end()
        return {}

    def _step(self, fields: Fields) -> Fields:
        arm, count = self._arm(), fields.pop("count", 1)
        if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= MOST_STEPS:
            _wrong("count", f"a whole number, 1 to {MOST_STEPS}")
        _done(fields, {})
        steps = [arm.step()]
        while len(steps) < count and steps[-1].state is State.MOVING:
            steps.append(arm.step())
        return {"state": str(steps[-1].state), "steps": [_told(step, arm.robot) for step in steps]}


def _parsed(line: bytes) -> Fields:
    """The request. Raises OlpError S010 for anything but one JSON object."""
    help_text = 'one JSON object per line: {"do": "step"}'
    if len(line) > LONGEST_LINE:
        raise OlpError(error("S010", f"a line has at most {LONGEST_LINE} bytes", help=help_text))
    try:
        value = parse_json(line)
    except ValueError:
        raise OlpError(error("S010", "this line is not JSON", help=help_text)) from None
    if not isinstance(value, dict):
        raise OlpError(error("S010", "this line is no JSON object", help=help_text))
    return value


def _wrong(name: str, wanted: str) -> NoReturn:
    raise OlpError(error("S012", f"{name} is missing or wrong", help=f"{name} has to be {wanted}"))


def _done(fields: Fields, answer: Fields) -> Fields:
    """The answer, when every field was understood: a field nobody reads is a misspelt one."""
    if fields:
        names = ", ".join(repr(name[:40]) for name in list(fields)[:5])
        raise OlpError(
            error("S011", f"this request has no field {names}", help="docs/controller.md lists them")
        )
    return answer


def _is_number(value: Any) -> bool:
    try:
        return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:  # a whole number of thousands of digits
        return False


def _number(fields: Fields, name: str, default: float | None) -> float | None:
    value = fields.pop(name, default)
    if value is not None and not _is_number(value):
        _wrong(name, "a finite number")
    return None if value is None else float(value)


def _numbers(fields: Fields, name: str, count: int) -> list[float] | None:
    values = fields.pop(name, None)
    if values is None:
        return None
    if not isinstance(values, list) or len(values) != count or not all(map(_is_number, values)):
        _wrong(name, f"{count} finite numbers")
    return [float(value) for value in values]


def _pose(fields: Fields, name: str) -> Pose | None:
    numbers = _numbers(fields, name, _POSE)
    if numbers is None:
        return None
    return Pose.from_xyz_angles([n * (mm if i < 3 else deg) for i, n in enumerate(numbers)])


def _joints(fields: Fields, name: str, robot: Robot) -> tuple[float, ...] | None:
    numbers = _numbers(fields, name, len(robot.axes))
    if numbers is None:
        return None
    return tuple(n * (mm if axis.linear else deg) for n, axis in zip(numbers, robot.axes, strict=True))


def _told(step: Step, robot: Robot) -> Fields:
    units = [mm if axis.linear else deg for axis in robot.axes]
    pose = step.tool.xyz_angles()
    return {
        "t_s": step.time,
        "elapsed_s": step.elapsed,
        "state": str(step.state),
        "target": step.target,
        "joints_deg": [value / unit for value, unit in zip(step.joints.tolist(), units, strict=True)],
        "pose_mm_deg": [*(pose[:3] / mm).tolist(), *(pose[3:] / deg).tolist()],
        "speed_mm_s": step.speed / mm,
    }


def _failed(diagnostics: tuple[Diagnostic, ...]) -> bytes:
    told = [
        {"code": d.code, "severity": str(d.severity), "message": d.message, "help": d.help}
        for d in diagnostics
    ]
    return _line({"ok": False, "diagnostics": told})


def _line(value: Fields) -> bytes:
    return json.dumps(value, ensure_ascii=False, allow_nan=False).encode() + b"\n"
