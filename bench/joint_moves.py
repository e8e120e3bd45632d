"""Recordings of joint moves among lines whose hidden cause is known, for `bench/made_up.py`.

    python bench/joint_moves.py FOLDER [--seed 1] [--cases 24] && python bench/made_up.py FOLDER

An arm of three axes runs from point to point, all axes together with the one that takes longest, and some lines. What
is hidden: the load's distance from the first axis, for the whole controller or for each axis by its own distance; a
weaker drive; ramps that pass a filter, or whose jerk is limited; a time per move, or per stop; one weaker axis.
"""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
from made_up import make_cases
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LAWS = ("reach", "reach of each axis", "acceleration", "jerk", "jerk limit", "dispatch", "settling", "axis")
TERMS = {"reach": "reach-inertia", "reach of each axis": "reach-inertia", "axis": "joint-acceleration-limit"}
TERMS |= {"jerk limit": "jerk"}
SHOULDER = np.array([0.15, 0.4])  # [m] of axis 2: from axis 1, and height
LINKS = np.array([0.7, 0.8])  # [m]
LOW, HIGH = np.radians([[-120.0, 10.0, -120.0], [120.0, 100.0, -20.0]])
PACE, RAMP = np.radians([150.0, 140.0, 180.0]), np.radians([400.0, 350.0, 500.0])  # [rad/s], [rad/s²]
SHARES, SPEEDS = (0.2, 0.4, 0.7, 1.0), (0.1, 0.25, 0.5, 1.0)  # [1], [m/s]


def place(q: Floats) -> Floats:
    """(3,) [m] of the tool at joints (3,)."""
    bent = np.array([q[1], q[1] + q[2]])
    out = SHOULDER[0] + LINKS @ np.cos(bent)
    return np.array([out * math.cos(q[0]), out * math.sin(q[0]), SHOULDER[1] + LINKS @ np.sin(bent)])


def joints(p: Floats) -> Floats | None:
    """(3,) [rad] at a place (3,), elbow up; None out of reach."""
    out, up = math.hypot(p[0], p[1]) - SHOULDER[0], p[2] - SHOULDER[1]
    bend = (out**2 + up**2 - LINKS @ LINKS) / (2.0 * LINKS[0] * LINKS[1])
    if abs(bend) > 0.98:
        return None
    q3 = -math.acos(bend)
    lean = math.atan2(LINKS[1] * math.sin(q3), LINKS[0] + LINKS[1] * bend)
    return np.array([math.atan2(p[1], p[0]), math.atan2(up, out) - lean, q3])


def seconds(way: float, speed: float, up: float, down: float, build: float = 0.0) -> float:
    """From rest to rest with ramps that pass a moving average of `build` [s]."""
    slow = 0.5 * (1.0 / up + 1.0 / down)
    top = min(speed, 2.0 * way / (build + math.sqrt(build**2 + 4.0 * slow * way)))
    return way / top + top * slow + build


def limited(way: float, speed: float, ramp: float, jerk: float) -> float:
    """From rest to rest with an acceleration that builds up by `jerk` [rad/s³ | m/s³]."""

    def build(top: float) -> float:
        return top / ramp + ramp / jerk if top > ramp**2 / jerk else 2.0 * math.sqrt(top / jerk)

    low, high = 0.0, speed
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if middle * build(middle) < way else (low, middle)
    return way / low + build(low)


def loads(q: Floats, law: str, growth: float) -> Floats:
    """(3,) by which each axis' inertia is larger than in the middle of the space, at joints (3,)."""
    p = place(q)
    first = p[0] ** 2 + p[1] ** 2 - 0.8
    if law == "reach":
        return np.full(3, 1.0 + growth * first)
    out, up = math.hypot(p[0], p[1]) - SHOULDER[0], p[2] - SHOULDER[1]
    return 1.0 + growth * np.array([first, out**2 + up**2 - 0.8, 0.0])


def move(law: str, size: float, q: Floats, to: Floats, share: float, line: float) -> tuple[float, float]:
    """[s] simulated and real, of a joint move at `share` of full speed, or, where `line` > 0 [m/s], of a line."""
    starts, ends = (loads(at, law, size) if law.startswith("reach") else np.ones(3) for at in (q, to))
    weak = 1.0 / (1.0 + size) if law == "acceleration" else 1.0
    build = size if law == "jerk" else 0.0
    added = size if law in ("dispatch", "settling") else 0.0
    if line > 0:
        way = float(np.linalg.norm(place(to) - place(q)))
        sim = seconds(way, line, 2.0, 2.0)
        if law == "jerk limit":
            return sim, limited(way, line, 2.0, 2.0 / size)
        return sim, seconds(way, line, 2.0 * weak / starts[0], 2.0 * weak / ends[0], build) + added
    ways = np.maximum(np.abs(to - q), 1e-6)
    less = np.array([1.0, 1.0 / (1.0 + size) if law == "axis" else 1.0, 1.0]) * weak
    sims = [seconds(w, share * v, a, a) for w, v, a in zip(ways, PACE, RAMP, strict=True)]
    if law == "jerk limit":
        return max(sims), max(limited(ways[k], share * PACE[k], RAMP[k], RAMP[k] / size) for k in range(3))
    reals = [
        seconds(ways[k], share * PACE[k], RAMP[k] * less[k] / starts[k], RAMP[k] * less[k] / ends[k], build)
        for k in range(3)
    ]
    return max(sims), max(reals) + added


def case(rng: np.random.Generator, law: str) -> tuple[list[dict[str, float | str]], float]:
    """The rows of a recording, and its scatter [s]; `law`: one of `LAWS`."""
    size = {
        "reach": rng.uniform(0.5, 1.1),
        "reach of each axis": rng.uniform(0.5, 1.1),
        "acceleration": rng.uniform(0.2, 0.6),
        "jerk": rng.uniform(0.06, 0.15),
        "jerk limit": rng.uniform(0.06, 0.2),
        "dispatch": rng.uniform(0.012, 0.04),
        "settling": rng.uniform(0.03, 0.1),
        "axis": rng.uniform(0.4, 1.0),
    }[law]
    noise, straight = float(rng.uniform(0.0015, 0.004)), float(rng.choice([0.0, 0.4]))
    rows, q, clock = list[dict[str, float | str]](), rng.uniform(LOW, HIGH), 0.0
    for number in range(1, int(rng.integers(100, 260))):
        to = rng.uniform(LOW, HIGH)
        if rng.random() < 0.5:
            to = np.clip(q + rng.normal(size=3) * 0.3, LOW, HIGH)
        line = 0.0
        if rng.random() < straight:
            there = joints(place(q) + rng.normal(size=3) * 0.12)
            if there is not None and (there > LOW).all() and (there < HIGH).all():
                to, line = there, float(rng.choice(SPEEDS))
        share = float(rng.choice(SHARES))
        sim, real = move(law, size, q, to, share, line)
        blend = 10.0 if law == "settling" and line > 0 and rng.random() < 0.4 else 0.0
        real -= size if blend else 0.0
        measured = real + noise * rng.normal()
        row: dict[str, float | str] = {
            "move": number,
            "type": "linear" if line > 0 else "joint",
            "duration_s": round(measured, 3),
            "sim_s": sim,
            "t_start_s": clock,
            "speed_mm_s": 1000.0 * line if line > 0 else "",
            "accel_mm_s2": 2000.0 if line > 0 else "",
            "speed_pct": "" if line > 0 else 100.0 * share,
            "blend_mm": blend,
        }
        for end, at in (("start", q), ("end", to)):
            row |= {f"{axis}_{end}_mm": 1000.0 * v for axis, v in zip("xyz", place(at), strict=True)}
            row |= {f"q{k}_{end}_deg": math.degrees(v) for k, v in enumerate(at, 1)}
        rows.append(row)
        clock += measured + 0.2
        q = to
    return rows, noise


def write(folder: Path, rows: list[dict[str, float | str]]) -> None:
    """The recording in a folder that is there."""
    with open(folder / "moves.csv", "w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(rows[0]))
        table.writeheader()
        table.writerows(
            {k: f"{v:.6f}" if isinstance(v, float) else v for k, v in row.items()} for row in rows
        )


def made(folder: Path, number: int, rng: np.random.Generator) -> dict[str, Any]:
    law = LAWS[number % len(LAWS)]
    rows, noise = case(rng, law)
    write(folder, rows)
    return {
        "mode": law,
        "terms": [TERMS.get(law, law)],
        "moves": None,
        "noise_s": noise,
        "resolution_s": 0.001,
    }


if __name__ == "__main__":
    make_cases(__doc__, made)
