"""The stepped controller against the closed forms: `python bench/controller.py`. Exit status 1 when a figure is missed.

Random programs of every kind of segment, every way to pass a point and every motion model. Each is stepped by a
simulator that gives a target only when it is asked for one, which is the hard case, and is compared with the same
targets timed at once. For single lines from rest to rest the time is also worked out here, from the textbook formula.
The C example of the documentation is compiled with the system's compiler and run against the server.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path as File

import numpy as np
from tables import print_table

from olp.core.diagnostic import OlpError
from olp.ir.program import Path
from olp.robots.geometry import Pose
from olp.robots.robot import load_robot
from olp.servers.controller import Controller, State, Step, Target
from olp.servers.controller.server import ControllerServer
from olp.timing.motion import model_names
from olp.timing.result import Timing
from olp.timing.track import states

ROOT = File(__file__).parent.parent
ROBOT = load_robot("yaskawa/ma2010")
TOOL = Pose.from_xyz_angles([0.012, -0.007, 0.31, 0.1, 0.52, 0.2])
HOME = np.radians([11.3, 5.2, -8.4, 12.6, -61.7, 20.9])
CYCLE = 0.004  # [s]
PROGRAMS = 8  # per row of the table
TARGETS = 6  # per program
EXACT = 1e-9  # [s] and [m]
PASSES: dict[str, tuple[float | None, ...]] = {
    "exact stop": (0.0,),
    "no zone": (None,),
    "zone": (0.013, 0.06),
}
KINDS = ("joint", "linear", "circular", "spline", "mixed")


def main() -> int:
    generator = np.random.default_rng(20261120)
    rows, held = [], True
    for kind in KINDS:
        for passes, zones in PASSES.items():
            for model in model_names():
                row = compare(generator, kind, zones, model)
                held &= row[0] <= EXACT and row[1] <= EXACT and row[2] <= EXACT and row[3] <= CYCLE
                rows.append(
                    (kind, passes, model, *(f"{value:.1e}" for value in row[:3]), f"{row[3] / CYCLE:.2f}")
                )
    header = (
        "segments", "passing", "model", "last step - closed form, s", "last step - target, m",
        "step - closed form, m", "longest step, cycles",
    )  # fmt: skip
    print(
        f"{PROGRAMS} random programs of {TARGETS} targets per row, cycle {CYCLE * 1e3:g} ms; the largest of each\n"
    )
    print_table(header, rows)
    textbook = against_textbook(generator)
    held &= textbook <= EXACT
    print(f"\n200 single lines from rest to rest against L/v + v/a or 2 sqrt(L/a): {textbook:.1e} s")
    print(
        f"asked: last step exact ({EXACT:.0e}), no step longer than a cycle: {'held' if held else 'MISSED'}\n"
    )
    print_table(("speed", "measured"), speeds(generator))
    return 0 if held else 1


def compare(
    generator: np.random.Generator, kind: str, zones: tuple[float | None, ...], model: str
) -> tuple[float, float, float, float]:
    """The largest of: time [s] and place [m] of the last step, place of any step [m], length of a step [s]."""
    worst = np.zeros(4)
    compared = 0
    while compared < PROGRAMS:
        targets = program(generator, kind, zones)
        try:
            steps = list(starved(arm(model), targets))
        except OlpError:  # a rounded corner or a spline left the arm's reach: told, not stepped
            continue
        compared += 1
        timing = closed_form(targets, model)
        times = np.array([step.time for step in steps])
        position = np.array([step.tool.position for step in steps])
        # The track is asked in the same instants but for those after a starved exact stop, whose cycles begin anew.
        expected = states(timing, times)[0]
        goal = last_place(timing)
        worst = np.maximum(
            worst,
            [
                abs(times[-1] - timing.total_s),
                float(np.linalg.norm(position[-1] - goal)),
                float(np.linalg.norm(position - expected, axis=1).max()),
                max(step.elapsed for step in steps) - 1e-12,
            ],
        )
    return worst[0], worst[1], worst[2], worst[3]


def arm(model: str = "constant") -> Controller:
    controller = Controller(ROBOT, model=model, cycle=CYCLE)
    controller.set_tool(TOOL)
    controller.set_position(HOME)
    return controller


def program(generator: np.random.Generator, kind: str, zones: tuple[float | None, ...]) -> list[Target]:
    """Random targets that the arm can reach one after the other."""
    controller, targets = arm(), []
    while len(targets) < TARGETS:
        zone = zones[generator.integers(len(zones))]
        chosen = kind if kind != "mixed" else ("joint", "linear", "circular", "spline")[generator.integers(4)]
        target = random_target(generator, Path(chosen), zone)
        try:
            controller.target(target)
        except OlpError:
            continue
        targets.append(target)
    return targets


BASE = arm().step().tool


def pose(generator: np.random.Generator) -> Pose:
    angles = generator.uniform(-0.35, 0.35, 3)
    turned = Pose.from_xyz_angles([0.0, 0.0, 0.0, *angles])
    return Pose(BASE.position + generator.uniform(-0.19, 0.19, 3), BASE.rotation @ turned.rotation)


def random_target(generator: np.random.Generator, path: Path, zone: float | None) -> Target:
    if path is Path.JOINT:
        joints = tuple(HOME + generator.uniform(-0.4, 0.4, 6))
        return Target(path, joints=joints, speed=float(generator.uniform(0.1, 1.0)), zone=zone)
    speed = float(generator.uniform(0.03, 0.9))
    via = pose(generator) if path is Path.CIRCULAR else None
    return Target(path, pose=pose(generator), speed=speed, zone=zone, via=via)


def starved(controller: Controller, targets: list[Target]) -> Iterator[Step]:
    """Steps of a simulator that gives a target only when it is asked for one."""
    waiting = list(targets)
    while True:
        step = controller.step()
        if step.elapsed:
            yield step
        if step.state is State.DONE:
            return
        if step.state is not State.MOVING:
            if waiting:
                controller.target(waiting.pop(0))
            else:
                controller.end()


def closed_form(targets: list[Target], model: str) -> Timing:
    """The same targets, timed at once."""
    controller = arm(model)
    for target in targets:
        controller.target(target)
    controller.end()
    timing = controller._queue.known().timing
    assert timing is not None
    return timing


def last_place(timing: Timing) -> np.ndarray:
    return timing.plan.positions.position[timing.plan.moves.target[-1]]


def against_textbook(generator: np.random.Generator) -> float:
    """Largest difference [s] of single lines with the constant model, worked out from length, speed, acceleration."""
    acceleration, settling, worst = ROBOT.linear_acceleration, ROBOT.settling_time, 0.0
    assert acceleration is not None
    assert settling is not None
    for _ in range(200):
        shift, speed = generator.uniform(-0.2, 0.2, 3), float(generator.uniform(0.01, 1.5))
        length = float(np.linalg.norm(shift))
        reached = length * acceleration >= speed * speed
        expected = length / speed + speed / acceleration if reached else 2 * np.sqrt(length / acceleration)
        controller = arm()
        controller.target(Target(Path.LINEAR, pose=Pose(BASE.position + shift, BASE.rotation), speed=speed))
        worst = max(worst, abs(list(controller.run())[-1].time - expected - settling))
    return worst


def speeds(generator: np.random.Generator) -> list[tuple[str, str]]:
    targets = program(generator, "linear", (0.03,)) * 10
    controller = arm()
    for target in targets:
        controller.target(target)
    controller.end()
    began = time.perf_counter()
    count = sum(1 for _ in controller.run())
    stepped = time.perf_counter() - began
    rows = [("steps handed out, all targets known", f"{count / stepped:,.0f} per s")]
    began = time.perf_counter()
    count = sum(1 for _ in starved(arm(), targets))
    stepped = time.perf_counter() - began
    rows.append(
        (f"the same, each of {len(targets)} blended targets given late", f"{count / stepped:,.0f} per s")
    )
    rows.append(("C example over the socket, one request per step", client()))
    return rows


def client() -> str:
    """What the compiled C example does."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        return "no C compiler here"
    source = ROOT / "docs" / "examples" / "controller_client.c"
    with tempfile.TemporaryDirectory() as folder, ControllerServer(0) as server:
        program_ = File(folder) / "client"
        subprocess.run([compiler, "-O2", "-Wall", "-Wextra", "-Werror", "-o", program_, source], check=True)
        threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True).start()
        began = time.perf_counter()
        done = subprocess.run([program_, str(server.port)], capture_output=True, text=True, check=True)
        seconds = time.perf_counter() - began
        server.shutdown()
    *_, last, count = done.stdout.splitlines()
    return f"{count}, the last at {last.split()[0]} s; {int(count.split()[0]) / seconds:,.0f} per s"


if __name__ == "__main__":
    sys.exit(main())
