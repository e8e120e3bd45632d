"""A station behind RoboDK's own socket protocol: the real `robodk.robolink` client talks to it.

It keeps what it is told, in order, and has a clock of its own: moves from stop to stop with constant acceleration,
integrated in small steps. Only what the import script uses is answered; anything else is a failure, not a guess.
"""

# ruff: noqa: N802  (the methods have the names of the protocol)

from __future__ import annotations

import math
import socketserver
import struct
import threading
from typing import Any

import numpy as np

ROBOT, BASE = 101, 102
TYPES = {"robot": 2, "frame": 3, "tool": 4, "target": 6, "program": 8}


class Wire:
    """Numbers and lines as the client sends them: big endian."""

    def __init__(self, read: Any, write: Any) -> None:
        self.read_from, self.write_to = read, write

    def take(self, form: str) -> Any:
        size = struct.calcsize(">" + form)
        data = self.read_from.read(size)
        if len(data) < size:
            raise EOFError
        values = struct.unpack(">" + form, data)
        return values[0] if len(values) == 1 else values

    def line(self) -> str:
        data = self.read_from.readline()
        if not data:
            raise EOFError
        return data.decode()[:-1]

    def array(self) -> list[float]:
        count = self.take("i")
        return [self.take("d") for _ in range(count)]

    def pose(self) -> np.ndarray:
        return np.array(self.take("16d")).reshape(4, 4).T

    def give(self, form: str, *values: Any) -> None:
        self.write_to.write(struct.pack(">" + form, *values))

    def give_line(self, text: str) -> None:
        self.write_to.write(text.encode() + b"\n")

    def done(self) -> None:
        self.give("i", 0)


class Station:
    """`items`: by number, a dict each. `instructions` of each program: tuples."""

    def __init__(self) -> None:
        self.items: dict[int, dict[str, Any]] = {
            ROBOT: {"kind": "robot", "name": "robot", "joints": [0.0] * 6},
            BASE: {"kind": "frame", "name": "robot base", "pose": np.eye(4)},
        }
        self.commands: list[str] = []

    def add(self, kind: str, name: str, **more: Any) -> int:
        number = 1000 + len(self.items)
        self.items[number] = {"kind": kind, "name": name, **more}
        return number

    def of(self, kind: str) -> dict[str, dict[str, Any]]:
        return {item["name"]: item for item in self.items.values() if item["kind"] == kind}

    def answer(self, command: str, wire: Wire) -> None:
        self.commands.append(command)
        getattr(self, "on_" + command)(wire)
        wire.write_to.flush()

    # One method per command of the protocol.

    def on_RDK_API(self, wire: Wire) -> None:
        wire.array()
        wire.give_line("RDK_API")
        wire.give("ii", 1, 30000)
        wire.done()

    def on_G_Item2(self, wire: Wire) -> None:
        name, kind = wire.line(), wire.take("i")
        found = next(
            (n for n, i in self.items.items() if TYPES[i["kind"]] == kind and i["name"].startswith(name)), 0
        )
        self._item(wire, found)

    def on_G_Parent(self, wire: Wire) -> None:
        assert wire.take("Q") == ROBOT
        self._item(wire, BASE)

    def on_Add_PROG(self, wire: Wire) -> None:
        name, robot = wire.line(), wire.take("Q")
        assert robot == ROBOT
        self._item(wire, self.add("program", name, instructions=[], params={}))

    def on_Add_FRAME(self, wire: Wire) -> None:
        name, parent = wire.line(), wire.take("Q")
        self._item(wire, self.add("frame", name, parent=parent))

    def on_AddToolEmpty(self, wire: Wire) -> None:
        assert wire.take("Q") == ROBOT
        pose, name = wire.pose(), wire.line()
        self._item(wire, self.add("tool", name, pose=pose))

    def on_Add_TARGET(self, wire: Wire) -> None:
        name, parent, robot = wire.line(), wire.take("Q"), wire.take("Q")
        assert robot == ROBOT
        self._item(wire, self.add("target", name, parent=parent))

    def on_S_Hlocal(self, wire: Wire) -> None:
        item = wire.take("Q")
        self.items[item]["pose"] = wire.pose()
        wire.done()

    def on_S_Thetas(self, wire: Wire) -> None:
        joints, item = wire.array(), wire.take("Q")
        self.items[item]["joints"] = joints
        wire.done()

    def on_S_Target_As_RT(self, wire: Wire) -> None:
        self.items[wire.take("Q")]["by_joints"] = False
        wire.done()

    def on_S_Target_As_JT(self, wire: Wire) -> None:
        self.items[wire.take("Q")]["by_joints"] = True
        wire.done()

    def on_S_Link_ptr(self, wire: Wire) -> None:
        frame, program = wire.take("Q"), wire.take("Q")
        self._instruct(wire, program, "frame", frame)

    def on_S_Tool_ptr(self, wire: Wire) -> None:
        tool, program = wire.take("Q"), wire.take("Q")
        self._instruct(wire, program, "tool", tool)

    def on_S_Speed4(self, wire: Wire) -> None:
        self._instruct(wire, wire.take("Q"), "speed", *wire.array())

    def on_S_ZoneData(self, wire: Wire) -> None:
        size = wire.take("i") / 1000
        self._instruct(wire, wire.take("Q"), "rounding", size)

    def on_Add_INSMOVE(self, wire: Wire) -> None:
        target, program, kind = wire.take("Q"), wire.take("Q"), wire.take("i")
        self._instruct(wire, program, {1: "joint", 2: "linear"}[kind], target)

    def on_Add_INSMOVEC(self, wire: Wire) -> None:
        via, target, program = wire.take("Q"), wire.take("Q"), wire.take("Q")
        self._instruct(wire, program, "circular", target, via)

    def on_RunPause(self, wire: Wire) -> None:
        program = wire.take("Q")
        self._instruct(wire, program, "pause", wire.take("i") / 1e6)

    def on_setDO(self, wire: Wire) -> None:
        program = wire.take("Q")
        self._instruct(wire, program, "output", wire.line(), wire.line())

    def on_RunCode2(self, wire: Wire) -> None:
        program, text, kind = wire.take("Q"), wire.line(), wire.take("i")
        assert kind == 3
        self.items[program]["instructions"].append(("comment", text))
        wire.give("i", 0)
        wire.done()

    def on_ICMD(self, wire: Wire) -> None:
        item, name, value = wire.take("Q"), wire.line(), wire.line()
        self.items[item]["params"][name] = value
        wire.give_line("")
        wire.done()

    def on_Prog_ShowIns(self, wire: Wire) -> None:
        wire.take("Q")
        wire.take("i")
        wire.done()

    def on_Render(self, wire: Wire) -> None:
        wire.take("i")
        wire.done()

    def _item(self, wire: Wire, number: int) -> None:
        wire.give("Qi", number, TYPES[self.items[number]["kind"]] if number else -1)
        wire.done()

    def _instruct(self, wire: Wire, program: int, *words: Any) -> None:
        assert self.items[program]["kind"] == "program"
        self.items[program]["instructions"].append(words)
        wire.done()

    # Its own clock.

    def placed(self, target: dict[str, Any]) -> np.ndarray:
        """The target's pose in the robot's base [mm]."""
        parent = self.items[target["parent"]]
        pose: np.ndarray = parent["pose"] @ target["pose"]
        return pose

    def cycle_time(self, program: dict[str, Any]) -> float:
        """[s] of one run, from where the robot stands."""
        joints = np.array(self.items[ROBOT]["joints"])
        flange: np.ndarray | None = None
        tool = np.eye(4)
        speed, total = [math.nan] * 4, 0.0
        for word, *rest in program["instructions"]:
            if word == "speed":
                speed = [new if new > 0 else old for new, old in zip(rest, speed, strict=True)]
            elif word == "pause":
                total += rest[0]
            elif word == "tool":
                tool = self.items[rest[0]]["pose"]
            elif word in ("joint", "linear", "circular"):
                target = self.items[rest[0]]
                pose = self.placed(target)
                end = pose[:3, 3]
                if word == "joint":
                    way = float(np.abs(np.array(target["joints"]) - joints).max())
                    total += integrated(way, speed[1], speed[3])
                else:
                    assert flange is not None, "the first move must be a joint move"
                    place = (flange @ tool)[:3, 3]  # another tool is at another place
                    points = (
                        [place, end]
                        if word == "linear"
                        else [place, self.placed(self.items[rest[1]])[:3, 3], end]
                    )
                    total += integrated(way_through(points), speed[0], speed[2])
                flange, joints = pose @ np.linalg.inv(tool), np.array(target["joints"])
        return total


def integrated(way: float, top: float, acceleration: float) -> float:
    """Seconds from stop to stop, in small steps, smallest at both ends: v² = 2 a s, up to `top`, and down again."""
    if way < 1e-9:
        return 0.0
    edges = np.linspace(0, 1, 20_001)
    edges = way * edges**2 * (3 - 2 * edges)
    s = (edges[1:] + edges[:-1]) / 2
    speed = np.minimum(top, np.sqrt(2 * acceleration * np.minimum(s, way - s)))
    return float((np.diff(edges) / speed).sum())


def way_through(points: list[np.ndarray]) -> float:
    """The length of a line, or of the arc through three points by the angles that it sees."""
    if len(points) == 2:
        return float(np.linalg.norm(points[1] - points[0]))
    a, b, c = points
    sides = [np.linalg.norm(c - b), np.linalg.norm(a - c), np.linalg.norm(b - a)]
    area = np.linalg.norm(np.cross(b - a, c - a)) / 2
    if area < 1e-9:
        return float(sides[1])
    radius = sides[0] * sides[1] * sides[2] / (4 * area)
    at_b = math.acos(np.clip(np.dot(a - b, c - b) / (sides[0] * sides[2]), -1, 1))
    return float(radius * 2 * (math.pi - at_b))


class Server:
    """The station behind a port of this machine, as long as the block lasts."""

    def __init__(self) -> None:
        self.station = Station()
        self.failed: list[BaseException] = []
        outer = self

        class Handler(socketserver.StreamRequestHandler):
            disable_nagle_algorithm = True
            wbufsize = -1

            def handle(self) -> None:
                wire = Wire(self.rfile, self.wfile)
                try:
                    while True:
                        outer.station.answer(wire.line(), wire)
                except EOFError:
                    return
                except Exception as problem:
                    outer.failed.append(problem)

        self.server = socketserver.ThreadingTCPServer(("127.0.0.1", 0), Handler)
        self.server.daemon_threads = True

    def __enter__(self) -> Server:
        threading.Thread(target=self.server.serve_forever, args=(0.01,), daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self.server.shutdown()
        self.server.server_close()
        assert not self.failed, self.failed

    @property
    def port(self) -> int:
        return int(self.server.server_address[1])
