"""Writes a case: the recording in one folder, the sealed answer in another."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.concealed.arms import robot_file
from bench.concealed.cases import Case
from bench.concealed.programs import Moves
from bench.concealed.terms import KINDS

Floats = NDArray[np.float64]


def write(case: Case, folder: Path) -> Path:
    """`folder`/cases/NAME is what the tool sees; `folder`/sealed/NAME.json and .csv what the scorer sees."""
    place, sealed = folder / "cases" / case.name, folder / "sealed"
    place.mkdir(parents=True, exist_ok=True)
    sealed.mkdir(parents=True, exist_ok=True)
    columns, robot = _columns(case)
    _table(place / "moves.csv", columns)
    _settings(case, place, robot)
    (sealed / f"{case.name}.json").write_text(json.dumps(case.answer, indent=1))
    truth = {"move": [str(i) for i in range(len(case.real))], "real_s": _cells(case.real, 6)}
    truth |= {"sim_s": _cells(case.simulated, 6)}
    truth |= {f"{term}_s": _cells(part, 6) for term, part in case.parts.items()}
    _table(sealed / f"{case.name}.csv", truth)
    return place


def _columns(case: Case) -> tuple[dict[str, list[str]], bool]:
    """The columns that this recorder happened to write, and whether the recording names a robot."""
    moves, dice, hidden = case.world.moves, case.dice, {h.term for h in case.hidden}
    n = len(moves)
    needs_robot = any(KINDS[t].robot for t in hidden)
    robot = needs_robot or bool((moves.kind == 1).any()) or bool(dice.random() < 0.5)
    joints = (robot and (needs_robot or dice.random() < 0.5)) or bool((moves.kind == 1).any())
    columns = {"move": [str(i) for i in range(n)]}
    columns["duration_s"] = _cells(case.measured, 4)
    columns["sim_s"] = _cells(case.simulated, 5)
    columns["type"] = [("linear", "joint", "wait")[k] for k in moves.kind]
    columns |= _points(moves)
    if moves.angle.any() or robot:
        columns |= _turns(moves)
    if joints:
        columns |= _axes(moves)
    joint = moves.kind == 1
    columns["speed_mm_s"] = _where(moves.kind == 0, 1000 * moves.speed, 3)
    if joint.any():
        columns["speed_pct"] = _where(joint, 100 * moves.speed, 3)
    if dice.random() < 0.6 or case.recipe.tune:
        columns["accel_mm_s2"] = _where(moves.kind == 0, np.full(n, 1000 * case.world.acceleration), 3)
    if (moves.blend > 0).any():
        columns["blend_mm"] = _cells(1000 * moves.blend, 2)
    if "warm-up" in hidden or "clock" in hidden or case.recipe.note or dice.random() < 0.6:
        start = np.append(0.0, np.cumsum(case.real)[:-1]) + float(dice.uniform(0, 100))
        columns["t_start_s"] = _cells(np.round(start / case.resolution) * case.resolution, 4)
    if moves.plan.cycles > 1:
        columns["cycle"] = [str(c) for c in moves.cycle]
    if dice.random() < 0.6:
        columns["job"], columns["line"] = ["part.jbi"] * n, [str(i) for i in moves.line]
    if np.ptp(moves.load) > 0:
        columns["payload_kg"] = _cells(moves.load, 3)
    if moves.inertia.any():
        columns["payload_inertia_kg_m2"] = _cells(moves.inertia, 4)
    columns |= _innocent(case, dice, n)
    return columns, robot


def _innocent(case: Case, dice: np.random.Generator, n: int) -> dict[str, list[str]]:
    """A temperature that follows the running time: what warms up with the robot does not slow it."""
    if case.recipe.note != "warm-up = temperature" and dice.random() > 0.25:
        return {}
    at = np.cumsum(case.real)
    warm = 24 + 8 * (1 - np.exp(-at / (0.3 * at[-1]))) + dice.normal(0, 0.4, n)
    return {"temperature_c": _cells(warm, 2)}


def _points(moves: Moves) -> dict[str, list[str]]:
    return {
        f"{axis}_{end}_mm": _cells(1000 * moves.place[:, j, i], 3)
        for j, end in enumerate(("start", "end"))
        for i, axis in enumerate("xyz")
    }


def _turns(moves: Moves) -> dict[str, list[str]]:
    columns = {}
    for j, end in enumerate(("start", "end")):
        turn = moves.turn[:, j]
        angles = (
            np.arctan2(turn[:, 2, 1], turn[:, 2, 2]),
            np.arcsin(np.clip(-turn[:, 2, 0], -1, 1)),
            np.arctan2(turn[:, 1, 0], turn[:, 0, 0]),
        )
        columns |= {f"r{a}_{end}_deg": _cells(np.degrees(v), 4) for a, v in zip("xyz", angles, strict=True)}
    return columns


def _axes(moves: Moves) -> dict[str, list[str]]:
    return {
        f"q{i + 1}_{end}_deg": _cells(np.degrees(moves.axes[:, j, i]), 5)
        for j, end in enumerate(("start", "end"))
        for i in range(6)
    }


def _settings(case: Case, place: Path, robot: bool) -> None:
    lines = ['controller = "concealed"', f"time_resolution_s = {case.resolution:g}"]
    if robot:
        arm = case.world.moves.arm
        with_limits = case.dice.random() < 0.7 or bool((case.world.moves.kind == 1).any())
        (place / "robot.toml").write_text(robot_file(arm, "Arm", with_limits))
        lines = ['robot = "robot.toml"', *lines, f"tool = [0.0, 0.0, {1000 * arm.tool:.6f}, 0.0, 0.0, 0.0]"]
    (place / "recording.toml").write_text("\n".join(lines) + "\n")


def _table(path: Path, columns: dict[str, list[str]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))


def _cells(values: Floats, digits: int) -> list[str]:
    return [f"{v:.{digits}f}" for v in values]


def _where(flags: NDArray[np.bool_], values: Floats, digits: int) -> list[str]:
    return [f"{v:.{digits}f}" if f else "" for f, v in zip(flags, values, strict=True)]
