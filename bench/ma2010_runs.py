"""Reads the published recordings of an MA2010 on a DX200: where the tool was and when, what was commanded."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from olp.core.units import deg, mm
from olp.robots.kinematics import forward, jacobian
from olp.robots.robot import load_robot

Floats = NDArray[np.float64]
ROBOT = load_robot("yaskawa/ma2010")
THRESHOLD = 0.5 * mm  # a run is timed from this far behind its start to this far before its end


@dataclass(frozen=True, slots=True)
class Run:
    """One recording. The tool's `place` (n, 3) [m] is shifted so that it fits the commanded `points` (p, 3) [m]."""

    name: str
    time: Floats  # (n,) [s]
    joints: Floats  # (n, 6) [rad]
    place: Floats
    points: Floats
    speed: float  # [m/s]
    tool: Floats  # (3,) [m] from the flange

    @property
    def directions(self) -> Floats:
        """(p - 1, 3) unit vectors."""
        step = np.diff(self.points, axis=0)
        return step / np.linalg.norm(step, axis=1, keepdims=True)

    @property
    def lengths(self) -> Floats:
        """(p - 1,) [m] as commanded."""
        return np.linalg.norm(np.diff(self.points, axis=0), axis=1)

    @property
    def behind(self) -> Floats:
        """(n,) [m] from the start along the first move."""
        return (self.place - self.points[0]) @ self.directions[0]

    @property
    def ahead(self) -> Floats:
        """(n,) [m] to the target along the last move."""
        return (self.points[-1] - self.place) @ self.directions[-1]

    @property
    def total(self) -> float:
        """[s] between the thresholds, interpolated between samples."""
        stop = self.ahead[-1] + THRESHOLD
        first = int(np.argmax(self.behind > THRESHOLD))
        last = int(np.nonzero(self.ahead > stop)[0][-1])
        begin = _crossing(self.time, self.behind, first - 1, THRESHOLD)
        return _crossing(self.time, self.ahead, last, stop) - begin

    @property
    def nearest(self) -> float:
        """[m] from the second point, on the straight pieces between the samples."""
        near = self.place - self.points[1]
        step = np.diff(near, axis=0)
        square = np.maximum(np.sum(step**2, axis=1), 1e-18)
        share = np.clip(-np.sum(near[:-1] * step, axis=1) / square, 0.0, 1.0)
        return float(np.linalg.norm(near[:-1] + share[:, None] * step, axis=1).min())

    def rates(self, index: int, direction: Floats) -> Floats:
        """(6,) [rad/m]: how far each axis turns per metre of the tool's way along `direction`, at sample `index`."""
        here = self.joints[index][None]
        _, rotation = forward(ROBOT, here)
        arm = rotation[0] @ self.tool
        columns = jacobian(ROBOT, here)[0]
        columns[:3] += np.cross(columns[3:].T, arm).T
        return np.linalg.solve(columns, np.concatenate([direction, np.zeros(3)]))


def read(folder: Path, at_rest_last: bool, *names: str) -> list[Run]:
    """The runs of these names below `folder`. Their place is fitted where they rest: at the end, or at the start."""
    with (folder / "commands.csv").open(encoding="utf-8", newline="") as file:
        commands = {row["file"]: row for row in csv.DictReader(file)}
    return [_run(folder, name, commands[name], at_rest_last) for name in names]


def _run(folder: Path, name: str, command: dict[str, str], at_rest_last: bool) -> Run:
    table = np.loadtxt(folder / name, delimiter=",")
    joints = table[:, 1:7] * (deg if command["joint_units"] == "deg" else 1.0)
    tool_file = "torch.csv" if "streaming" in name else "weldgun_old.csv"
    tool = np.loadtxt(folder / "config" / tool_file, delimiter=",")[:3, 3] * mm
    position, rotation = forward(ROBOT, joints)
    place = position + rotation @ tool
    points = np.array([[float(x) for x in point.split()] for point in command["points_mm"].split(";")]) * mm
    fixed = (-1, -1) if at_rest_last else (0, 0)
    place = place - place[fixed[0]] + points[fixed[1]]
    return Run(name, table[:, 0] - table[0, 0], joints, place, points, float(command["V_mm_s"]) * mm, tool)


def _crossing(time: Floats, way: Floats, index: int, level: float) -> float:
    """[s] at which `way` passes `level` between sample `index` and the next."""
    share = (level - way[index]) / (way[index + 1] - way[index])
    return float(time[index] + share * (time[index + 1] - time[index]))
