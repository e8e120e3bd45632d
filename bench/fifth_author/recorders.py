"""How a cell's recorder turns durations into a table: stamps, noise, digits and the columns that it has."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from .arm import Floats, WristedArm, write_robot
from .cells import ProgramMove, Rng


@dataclass(frozen=True)
class Recorder:
    """A kind of noise and its size [s]: a standard deviation, a grid, or a scan time."""

    kind: str
    size: float
    says_resolution: bool

    @property
    def sigma(self) -> float:
        """Standard deviation of a duration [s]."""
        return (
            self.size
            * {"white": 1, "heavy": 1, "grid": 12**-0.5, "stamps": 6**-0.5, "scan": 6**-0.5}[self.kind]
        )


def draw_recorder(rng: Rng, *, fine: bool) -> Recorder:
    """Any recorder, or one that is fine enough for a controller's cycle."""
    kind = str(rng.choice(["white", "white", "grid", "stamps", "heavy", "scan"]))
    if fine:
        return Recorder("white", float(rng.choice([0.0005, 0.001])), True)
    sizes = {
        "white": (0.001, 0.008),
        "heavy": (0.001, 0.006),
        "grid": (0.002, 0.02),
        "stamps": (0.002, 0.012),
        "scan": (0.004, 0.016),
    }
    low, high = sizes[kind]
    size = float(np.exp(rng.uniform(np.log(low), np.log(high))))
    if kind in ("grid", "stamps"):
        size = min((0.002, 0.004, 0.008, 0.01, 0.012, 0.02), key=lambda grid: abs(grid - size))
    return Recorder(kind, size, bool(rng.random() < 0.7))


def record(rng: Rng, recorder: Recorder, seconds: Floats) -> Floats:
    """Measured durations [s]."""
    n, size = len(seconds), recorder.size
    events = np.concatenate([[0.0], np.cumsum(seconds)]) + rng.uniform(0, 1)
    if recorder.kind == "white":
        return np.round(seconds + rng.normal(0, size, n), 4)
    if recorder.kind == "heavy":
        return np.round(seconds + rng.standard_t(3, n) * size / 3**0.5, 4)
    if recorder.kind == "grid":
        return np.round(np.round(seconds / size) * size, 6)
    if recorder.kind == "stamps":
        return np.round(np.diff(np.floor(events / size)) * size, 6)
    return np.round(np.diff(events + rng.uniform(0, size, n + 1)), 3)


@dataclass(frozen=True)
class Dress:
    """Which of the optional columns a table has."""

    joints: bool
    turns: bool
    acceleration: bool
    lines: bool
    cycles: bool
    starts: bool
    loads: bool
    robot: str  # "", "file" or "file with accelerations"
    digits: int
    extra: bool


def draw_dress(rng: Rng, moves: Sequence[ProgramMove], needs: set[str]) -> Dress:
    """Columns at random, but those without which the sealed effects could not be named."""
    joint = any(m.kind == "joint" for m in moves)
    coin = (rng.random(8) < (0.35, 0.6, 0.4, 0.6, 0.5, 0.6, 0.8, 0.5)).tolist()
    robot = str(rng.choice(["", "file", "file with accelerations"], p=[0.5, 0.25, 0.25]))
    on_axes = bool(
        needs
        & {"joint-acceleration-limit", "joint-speed-limit", "reach-inertia", "gravity", "payload-inertia"}
    )
    if needs & {"joint-acceleration-limit", "joint-speed-limit"} and not robot:
        robot = "file"
    turns = coin[1] or "orientation-limit" in needs or bool(robot) or (joint and on_axes)
    starts = coin[5] or bool(needs & {"warm-up", "clock"})
    loads = coin[6] or bool(needs & {"payload", "payload-inertia"})
    return Dress(
        joint or coin[0] or on_axes,
        turns,
        coin[2],
        coin[3],
        coin[4],
        starts,
        loads,
        robot,
        int(rng.choice([3, 4, 6])),
        coin[7],
    )


def write_table(
    rng: Rng,
    folder: Path,
    moves: Sequence[ProgramMove],
    measured: Floats,
    judged: Floats,
    dress: Dress,
    acceleration: float,
) -> None:
    """Write moves.csv in the dress."""
    rows = [_row(m, dress, acceleration) for m in moves]
    first = int(rng.choice([0, 1, 100]))
    for k, row in enumerate(rows):
        row |= {"move": first + k, "duration_s": measured[k], "sim_s": round(float(judged[k]), dress.digits)}
    table = pd.DataFrame(rows)
    if dress.starts:
        table["t_start_s"] = np.round(np.concatenate([[0.0], np.cumsum(measured)[:-1]]) + 12.5, 4)
    if dress.extra:
        table["temperature_c"] = np.round(24 + np.cumsum(rng.normal(0, 0.05, len(table))), 1)
        table["operator"] = np.where(np.arange(len(table)) < len(table) // 2, "early", "late")
    if (table.get("blend_mm", pd.Series([0.0])) == 0).all() and "blend_mm" in table:
        table = table.drop(columns="blend_mm")
    order = ["move", *[c for c in table.columns if c != "move"]]
    table[order].to_csv(folder / "moves.csv", index=False)


def _row(m: ProgramMove, dress: Dress, acceleration: float) -> dict[str, object]:
    row: dict[str, object] = {"type": m.kind}
    points = m.kind != "joint" or dress.turns
    for end, pose, q in (("start", m.start, m.q[0]), ("end", m.end, m.q[-1])):
        if points and m.kind != "wait":
            row |= {f"{a}_{end}_mm": round(float(v), 3) for a, v in zip("xyz", pose[:3], strict=True)}
            if dress.turns:
                row |= {
                    f"r{a}_{end}_deg": round(float(np.degrees(v)), 4)
                    for a, v in zip("xyz", pose[3:], strict=True)
                }
        if dress.joints and m.kind != "wait":
            row |= {f"q{k + 1}_{end}_deg": round(float(np.degrees(v)), 4) for k, v in enumerate(q)}
    if m.kind == "linear":
        row["speed_mm_s"] = m.speed
        row |= {"accel_mm_s2": acceleration} if dress.acceleration else {}
    if m.kind == "joint":
        row["speed_pct"] = m.speed * 100
    row["blend_mm"] = m.blend
    row |= {"job": m.job, "line": m.line} if dress.lines else {}
    row |= {"cycle": m.cycle} if dress.cycles else {}
    row |= {"payload_kg": m.payload, "payload_inertia_kg_m2": m.inertia} if dress.loads else {}
    return row | ({"override_pct": m.override * 100} if m.override != 1 else {})


def write_head(folder: Path, recorder: Recorder, dress: Dress, arm: WristedArm, rng: Rng) -> None:
    """Write recording.toml and the robot's file, where there are any."""
    lines = []
    if dress.robot:
        write_robot(arm, folder / "arm.toml", accelerations="with" in dress.robot)
        lines.append('robot = "arm.toml"')
    if dress.robot or rng.random() < 0.3:
        lines.append(f"tool = [0.0, 0.0, {arm.tool}, 0.0, 0.0, 0.0]")
    if recorder.says_resolution:
        step = (
            recorder.size
            if recorder.kind in ("grid", "stamps")
            else 0.001
            if recorder.kind == "scan"
            else 0.0001
        )
        lines.append(f"time_resolution_s = {step}")
    if lines or rng.random() < 0.5:
        (folder / "recording.toml").write_text("\n".join(lines) + "\n")
