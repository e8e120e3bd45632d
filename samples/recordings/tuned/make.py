"""Writes PICK-7.JBI and the recording of its run: a robot with a jerk limit, simulated without, and tuned to the total.

    python samples/recordings/tuned/make.py

Everything is invented. The robot accelerates at 3.1 m/s² and builds that up at 45 m/s³. The simulation knows no jerk;
somebody has lowered its acceleration until the whole program takes as long as on the robot, to the millisecond. So the
totals agree, and every move is wrong.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
STATIONS, EACH = 8, 10  # of the program, moves in each
MOVES = STATIONS * EACH
ACCELERATION, JERK = 3.1, 45.0  # [m/s²], [m/s³] of the robot
SPEEDS = (40, 80, 150, 300, 500, 800)  # [mm/s]
NOISE = 0.0015  # [s]


def program(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Points (n + 1, 3) [mm] and speeds (n,) [mm/s] that are reached on the way."""
    points = [np.array([930.0, -210.0, 340.0])]
    speeds: list[float] = []
    while len(speeds) < MOVES:
        side = -480 + 970 * (len(speeds) // EACH) / STATIONS  # from station to station along y
        point = np.round(rng.uniform((710, side - 60, 120), (1230, side + 180, 780)), 1)
        if rng.random() < 0.4:  # a short way
            point = np.round(points[-1] + rng.uniform(-60, 60, 3), 1)
        way = float(np.linalg.norm(point - points[-1]))
        speed = float(rng.choice(SPEEDS))
        # Long enough for robot and simulation to reach the speed, so that L/v + ramp is the time of both.
        if way > 1.1 * speed * max(ramp(speed / 1e3), speed / 1e3 / 1.5) and point[0] > 700:
            points.append(point)
            speeds.append(speed)
    return np.array(points), np.array(speeds)


def ramp(speed: float) -> float:
    """[s] from rest to a speed [m/s] and back, less its way at full speed."""
    full = speed * JERK >= ACCELERATION**2
    return float(speed / ACCELERATION + ACCELERATION / JERK if full else 2 * np.sqrt(speed / JERK))


def job(points: np.ndarray, speeds: np.ndarray) -> tuple[list[str], list[int]]:
    """The lines of the job, and those of its moves."""
    lines = ["/JOB", "//NAME PICK-7", "//POS", f"///NPOS {len(points)},0,0,0,0,0", "///TOOL 0"]
    lines += ["///POSTYPE ROBOT", "///RECTAN", "///RCONF " + ",".join(24 * "0")]
    lines += [
        f"C{i:05d}={x:.3f},{y:.3f},{z:.3f},180.0000,0.0000,0.0000"
        for i, (x, y, z) in enumerate(points.tolist())
    ]
    lines += ["//INST", "///DATE 2026/11/20 14:00", "///ATTR SC,RW", "///GROUP1 RB1", "NOP"]
    lines += ["MOVJ C00000 VJ=12.50 PL=0"]
    first = len(lines) + 1
    lines += [f"MOVL C{i:05d} V={speed:.1f} PL=0" for i, speed in enumerate(speeds.tolist(), 1)]
    return [*lines, "END"], list(range(first, first + len(speeds)))


def main() -> None:
    """Writes the files next to this script."""
    rng = np.random.default_rng(73)
    points, speeds = program(rng)
    cruise = np.linalg.norm(np.diff(points, axis=0), axis=1) / speeds
    ramps = np.array([ramp(v / 1e3) for v in speeds])
    duration = np.round(cruise + ramps + NOISE * rng.normal(size=MOVES), 3)
    tuned = float((speeds / 1e3).sum() / (duration - cruise).sum())
    sim = cruise + speeds / 1e3 / tuned
    start = np.cumsum(np.concatenate([[0.0], duration[:-1] + 0.12]))
    lines, at = job(points, speeds)
    (HERE / "PICK-7.JBI").write_bytes("".join(f"{line}\r\n" for line in lines).encode("ascii"))
    places = [f"{c}_{end}_mm" for end in ("start", "end") for c in "xyz"]
    rows = [
        "move,job,line,station,type,duration_s,sim_s,t_start_s,"
        + ",".join([*places, "rx_deg,ry_deg,rz_deg,speed_mm_s,accel_mm_s2"])
    ]
    for k in range(MOVES):
        cells = [
            f"{k + 1},PICK-7.JBI,{at[k]},{'ABCDEFGH'[k // EACH]},linear,{duration[k]:.3f},{sim[k]:.6f},{start[k]:.3f}"
        ]
        cells += [f"{v:.1f}" for v in (*points[k], *points[k + 1])]
        rows.append(",".join([*cells, f"180,0,0,{speeds[k]:.0f},{1e3 * tuned:.3f}"]))
    (HERE / "moves.csv").write_text("".join(f"{row}\n" for row in rows), encoding="utf-8")


if __name__ == "__main__":
    main()
