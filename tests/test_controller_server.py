"""The controller behind its socket: the same steps as in Python, and nothing that is sent can harm it."""

from __future__ import annotations

import json
import random
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path as File

import numpy as np
import pytest

from olp.core.diagnostic import OlpError
from olp.ir.program import Path
from olp.robots.geometry import Pose
from olp.robots.robot import load_robot
from olp.servers.controller import Controller, Target
from olp.servers.controller.server import (
    HOST,
    LONGEST_LINE,
    MOST_SESSIONS,
    MOST_STEPS,
    ControllerServer,
    Session,
)

ROOT = File(__file__).parent.parent
HOME = [11.5, 5.5, -8.5, 12.5, -61.5, 20.5]
START = [
    {"do": "robot", "name": "yaskawa/ma2010", "cycle_s": 0.004},
    {"do": "tool", "pose_mm_deg": [12, -7, 310, 5.7, 29.8, 11.5]},
    {"do": "position", "joints_deg": HOME},
]


@pytest.fixture
def server() -> Iterator[ControllerServer]:
    with ControllerServer(0) as running:
        thread = threading.Thread(target=running.serve_forever, args=(0.02,), daemon=True)
        thread.start()
        yield running
        running.shutdown()
        thread.join(5)


class Client:
    """A simulator that speaks over a raw socket."""

    def __init__(self, port: int) -> None:
        self.socket = socket.create_connection((HOST, port), timeout=10)
        self.answers = self.socket.makefile("rb")

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.answers.close()
        self.socket.close()

    def send(self, data: bytes) -> dict:
        self.socket.sendall(data)
        return json.loads(self.answers.readline())

    def ask(self, **request: object) -> dict:
        return self.send(json.dumps(request).encode() + b"\n")


def ask(session: Session, **request: object) -> dict:
    return json.loads(session.answer(json.dumps(request).encode()).line)


def begun() -> Session:
    session = Session()
    for request in START:
        assert ask(session, **request)["ok"]
    return session


def codes(answer: dict) -> list[str]:
    assert answer["ok"] is False
    return [d["code"] for d in answer["diagnostics"]]


def test_a_client_gets_the_steps_that_python_gets(server):
    joints = [[12.5, 7.5, -3.5, 4.5, -57.5, 8.5], [-8.5, 11.5, 2.5, -6.5, -63.5, 21.5]]
    arm = Controller(load_robot("yaskawa/ma2010"), cycle=0.004)
    arm.set_tool(Pose.from_xyz_angles([0.012, -0.007, 0.31, *np.radians([5.7, 29.8, 11.5])]))
    arm.set_position(np.radians(HOME))
    for zone, speed, angles in zip((0.025, 0.0), (0.4, 0.25), joints, strict=True):
        arm.target(Target(Path.JOINT, joints=tuple(np.radians(angles)), speed=speed, zone=zone))
    arm.end()
    expected = list(arm.run())
    with Client(server.port) as client:
        for request in START:
            assert client.ask(**request)["ok"]
        for number, (zone, speed, angles) in enumerate(zip((25, 0), (40, 25), joints, strict=True), 1):
            answer = client.ask(do="target", path="joint", joints_deg=angles, speed_pct=speed, zone_mm=zone)
            assert answer == {"ok": True, "target": number}
        assert client.ask(do="end") == {"ok": True}
        steps, state = [], "moving"
        while state == "moving":
            answer = client.ask(do="step", count=100)
            steps += answer["steps"]
            state = answer["state"]
        assert client.ask(do="bye") == {"ok": True}
    assert state == "done"
    assert len(steps) == len(expected)
    for told, step in zip(steps, expected, strict=True):
        assert told["t_s"] == pytest.approx(step.time, abs=1e-12)
        assert told["joints_deg"] == pytest.approx(np.degrees(step.joints).tolist(), abs=1e-9)
        assert told["pose_mm_deg"][:3] == pytest.approx((step.tool.position * 1e3).tolist(), abs=1e-9)
        assert told["speed_mm_s"] == pytest.approx(step.speed * 1e3, abs=1e-9)
        assert told["target"] == step.target


def test_every_kind_of_target_can_be_given_in_lines():
    session = begun()
    x, y, z, *turn = ask(session, do="step")["steps"][0]["pose_mm_deg"]

    def pose(dx: float, dy: float, dz: float) -> list[float]:
        return [x + dx, y + dy, z + dz, *turn]

    requests = [
        {"path": "linear", "pose_mm_deg": pose(80, 41, 0), "speed_mm_s": 230, "zone_mm": None},
        {
            "path": "circular",
            "via_mm_deg": pose(110, 80, 3),
            "pose_mm_deg": pose(80, 120, 9),
            "speed_mm_s": 170,
        },
        {"path": "spline", "pose_mm_deg": pose(50, 90, 0), "speed_mm_s": 190, "zone_mm": None},
        {"path": "spline", "pose_mm_deg": pose(20, 100, 4), "speed_mm_s": 190, "acceleration_pct": 50},
        {"path": "linear", "pose_mm_deg": [*pose(20, 100, 4)[:3], turn[0] + 20, *turn[1:]], "turn_deg_s": 30},
        {"path": "joint", "pose_mm_deg": pose(0, 0, 0), "speed_pct": 30, "deceleration_pct": 40},
    ]
    for number, request in enumerate(requests, 1):
        assert ask(session, do="target", **request) == {"ok": True, "target": number}
    assert ask(session, do="wait", seconds=0.2) == {"ok": True, "target": 7}
    assert ask(session, do="end") == {"ok": True}
    state, last = "moving", {}
    while state == "moving":
        answer = ask(session, do="step", count=MOST_STEPS)
        state, last = answer["state"], answer["steps"][-1]
    assert state == "done"
    assert last["target"] == 7
    assert last["pose_mm_deg"][:3] == pytest.approx([x, y, z], abs=1e-6)


@pytest.mark.parametrize(
    ("fields", "expected_s"),
    [
        ({"turn_deg_s": 12}, 20 / 12),
        ({"turn_deg_s": 24}, 20 / 24),
        ({"turn_deg_s": 24, "acceleration_pct": 1, "deceleration_pct": 1}, 2 * (20 / 5.122) ** 0.5),
    ],
)
def test_turning_takes_as_long_as_its_degrees_and_accelerations_say(fields, expected_s):
    session = begun()
    x, y, z, rx, ry, rz = ask(session, do="step")["steps"][0]["pose_mm_deg"]
    turned = Pose.from_xyz_angles(np.radians([0, 0, 0, rx, ry, rz])) @ Pose.from_xyz_angles(
        np.radians([0, 0, 0, 20, 0, 0])
    )
    goal = [x, y, z, *np.degrees(turned.xyz_angles()[3:]).tolist()]
    assert ask(session, do="target", path="linear", pose_mm_deg=goal, **fields)["ok"]
    seconds, state = 0.0, "moving"
    while state == "moving":
        answer = ask(session, do="step", count=MOST_STEPS)
        state, seconds = answer["state"], answer["steps"][-1]["t_s"]
    assert expected_s < seconds < expected_s + 0.45


def test_a_frame_moves_targets_and_answers():
    session = begun()
    before = ask(session, do="step")["steps"][0]["pose_mm_deg"]
    assert ask(session, do="frame", pose_mm_deg=[100, -50, 25, 0, 0, 0]) == {"ok": True}
    after = ask(session, do="step")["steps"][0]["pose_mm_deg"]
    assert np.subtract(before, after) == pytest.approx([100, -50, 25, 0, 0, 0], abs=1e-9)


def test_settings_of_the_robot_reach_the_motion():
    times = []
    for extra in ({}, {"override_pct": 50}, {"model": "linear"}, {"settling_s": 0.5}, {"accel_mm_s2": 500}):
        session = Session()
        assert ask(session, do="robot", name="yaskawa/ma2010", **extra)["ok"]
        assert ask(session, do="position", joints_deg=HOME)["ok"]
        x, y, z, *turn = ask(session, do="step")["steps"][0]["pose_mm_deg"]
        ask(session, do="target", path="linear", pose_mm_deg=[x, y + 60, z, *turn], speed_mm_s=300)
        times.append(ask(session, do="step", count=1000)["steps"][-1]["t_s"])
    assert all(time > times[0] + 0.02 for time in times[1:])


@pytest.mark.parametrize(
    ("request_", "code"),
    [
        ({"do": "dance"}, "S011"),
        ({"do": 3}, "S011"),
        ({}, "S011"),
        ({"do": "robot"}, "S012"),
        ({"do": "robot", "name": "yaskawa/none"}, "S012"),
        ({"do": "robot", "name": ["yaskawa/ma2010"]}, "S012"),
        ({"do": "robot", "name": "../../../etc/passwd"}, "S012"),
        ({"do": "robot", "name": "olp/robots/yaskawa/ma2010.toml"}, "S012"),
        ({"do": "robot", "name": "yaskawa/ma2010", "model": "jerky"}, "T004"),
        ({"do": "robot", "name": "yaskawa/ma2010", "model": 1}, "S012"),
        ({"do": "robot", "name": "yaskawa/ma2010", "cycle_s": 0}, "S002"),
        ({"do": "robot", "name": "yaskawa/ma2010", "accel_mm_s2": 0}, "S012"),
        ({"do": "robot", "name": "yaskawa/ma2010", "override_pct": 0}, "T006"),
        ({"do": "robot", "name": "yaskawa/ma2010", "colour": "red"}, "S011"),
        ({"do": "tool"}, "S012"),
        ({"do": "tool", "pose_mm_deg": [1, 2, 3]}, "S012"),
        ({"do": "tool", "pose_mm_deg": [1, 2, 3, 4, 5, "6"]}, "S012"),
        ({"do": "tool", "pose_mm_deg": [1, 2, 3, 4, 5, True]}, "S012"),
        ({"do": "frame", "pose_mm_deg": [1, 2, 3, 4, 5, 10**400]}, "S012"),
        ({"do": "position", "joints_deg": [1, 2]}, "S012"),
        ({"do": "position", "joints_deg": [1000, 0, 0, 0, 0, 0]}, "S005"),
        ({"do": "target", "path": "zigzag"}, "S012"),
        ({"do": "target", "path": "linear"}, "S003"),
        (
            {"do": "target", "path": "linear", "pose_mm_deg": [90000, 0, 0, 0, 0, 0], "speed_mm_s": 100},
            "S004",
        ),
        ({"do": "target", "path": "joint", "joints_deg": HOME, "speed_mm_s": 100}, "S011"),
        ({"do": "target", "path": "joint", "joints_deg": HOME, "speed_pct": 100, "zone": 3}, "S011"),
        ({"do": "wait", "seconds": -1}, "S003"),
        ({"do": "wait", "seconds": "long"}, "S012"),
        ({"do": "step", "count": 0}, "S012"),
        ({"do": "step", "count": MOST_STEPS + 1}, "S012"),
        ({"do": "step", "count": True}, "S012"),
        ({"do": "end", "now": True}, "S011"),
    ],
)
def test_wrong_requests_are_answered_with_a_diagnostic_and_the_session_goes_on(request_, code):
    session = begun()
    assert set(codes(ask(session, **request_))) == {code}
    assert ask(session, do="step")["state"] == "idle"


@pytest.mark.parametrize("name", ["tool", "frame", "position", "target", "wait", "end", "step"])
def test_a_robot_comes_first(name):
    fields = {"tool": {"pose_mm_deg": [0] * 6}, "frame": {"pose_mm_deg": [0] * 6}, "wait": {"seconds": 1}}
    assert codes(ask(Session(), do=name, **fields.get(name, {}))) == ["S013"]


@pytest.mark.parametrize(
    "line",
    [
        b"GET / HTTP/1.1\r\n",
        b"\n",
        b"[1, 2]\n",
        b'"step"\n',
        b'{"do": "step"\n',
        b"\xff\xfe\x00\n",
        b"[" * 60_000 + b"\n",
        b'{"a":' * 12_000 + b"\n",
        b"9" * 60_000 + b"\n",
        b" " * (LONGEST_LINE + 1),
    ],
)
def test_a_line_that_is_no_request_ends_the_session(line):
    answer = Session().answer(line)
    assert answer.last
    assert codes(json.loads(answer.line)) == ["S010"]


def test_infinite_numbers_do_not_get_in():
    session = begun()
    for text in (b"NaN", b"Infinity", b"-Infinity", b"1e999"):
        answer = json.loads(session.answer(b'{"do": "wait", "seconds": ' + text + b"}").line)
        assert codes(answer) == ["S012"]


def test_damaged_requests_never_break_a_session():
    generator = random.Random(40115)
    good = [json.dumps(request).encode() for request in START]
    good.append(b'{"do": "target", "path": "joint", "joints_deg": [12, 7, -3, 4, -57, 8], "speed_pct": 40}')
    good.append(b'{"do": "step", "count": 3}')
    session = Session()
    for _ in range(400):
        line = bytearray(generator.choice(good))
        for _ in range(generator.randrange(3)):
            line[generator.randrange(len(line))] = generator.choice(b'{}[]",:0123456789-e.atx \\')
        answer = session.answer(bytes(line))
        assert json.loads(answer.line)["ok"] in (True, False)
        assert answer.line.endswith(b"\n")


def test_the_server_listens_to_this_machine_only(server):
    assert server.socket.getsockname()[0] == "127.0.0.1"


def test_one_session_does_not_see_another(server):
    with Client(server.port) as one, Client(server.port) as two:
        for request in START:
            assert one.ask(**request)["ok"]
        assert codes(two.ask(do="step")) == ["S013"]
        assert one.ask(do="step")["state"] == "idle"


def test_a_client_that_leaves_or_talks_nonsense_leaves_the_server_running(server):
    with Client(server.port) as client:
        client.socket.sendall(b'{"do": "ste')
    with Client(server.port) as client:
        assert codes(client.send(b"x" * (LONGEST_LINE + 10))) == ["S010"]
    with Client(server.port) as client:
        assert client.ask(do="hello")["protocol"] == 1


def test_too_many_sessions_are_told_so(server):
    clients = [Client(server.port) for _ in range(MOST_SESSIONS)]
    for client in clients:
        assert client.ask(do="hello")["ok"]
    with Client(server.port) as late:
        assert codes(json.loads(late.answers.readline())) == ["S014"]
    for client in clients:
        client.__exit__()


def test_a_session_that_asks_nothing_makes_room_and_one_that_works_does_not(server, monkeypatch):
    monkeypatch.setattr("olp.servers.controller.server.IDLE", 0.2)
    clients = [Client(server.port) for _ in range(MOST_SESSIONS)]
    for client in clients:
        assert client.ask(do="hello")["ok"]
    time.sleep(0.25)
    clients[0].socket.sendall(b" ")  # is no request
    for client in clients[1:]:
        assert client.ask(do="hello")["ok"]
    with Client(server.port) as late:
        assert late.ask(do="hello")["ok"]
        assert clients[0].answers.readline() == b""
        with Client(server.port) as later:
            assert codes(json.loads(later.answers.readline())) == ["S014"]
    for client in clients:
        client.__exit__()


def test_a_port_that_is_taken_is_told_so(server):
    with pytest.raises(OlpError, match=str(server.port)) as caught:
        ControllerServer(server.port)
    assert caught.value.diagnostics[0].code == "S015"


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM])
def test_the_command_serves_until_it_is_ended(ending):
    command = [sys.executable, "-m", "olp", "controller", "--port", "0"]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            said = process.stdout.readline()
            with Client(int(said.split(",")[0].rpartition(":")[2])) as client:
                assert client.ask(do="hello")["ok"]
            process.send_signal(ending)
            assert process.wait(10) == 0
        finally:
            process.kill()  # without it a server that does not end would hold the whole run
