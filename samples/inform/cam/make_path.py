"""Writes FINISH.JBI: a finishing pass over a curved panel, as a CAM post processor would post it.

Run it again after a change: `python samples/inform/cam/make_path.py`. The same numbers come out every time.
"""

from __future__ import annotations

import sys
from math import cos, degrees, sin
from pathlib import Path
from typing import NamedTuple

PASSES = 26  # back and forth
POINTS = 121  # per pass
STEP = 2.618  # between neighbours of a pass [mm]
PITCH = 7.43  # between passes [mm]
HOVER = 46.7  # clearance at both ends [mm]


class Row(NamedTuple):
    pose: tuple[float, ...]  # x y z [mm], Rx Ry Rz [deg] in user frame 1
    move: str  # instruction and tags; {} is the point


def height(x: float, y: float) -> float:
    """The panel over the frame's plane [mm]."""
    return 21.3 * sin(0.0131 * x + 0.4) + 13.7 * cos(0.0223 * y - 0.2) + 0.017 * x


def pose(x: float, y: float, above: float = 0.0) -> tuple[float, ...]:
    """The spindle on the panel, tilted half as much as the panel is steep."""
    slope_x = 21.3 * 0.0131 * cos(0.0131 * x + 0.4) + 0.017
    slope_y = -13.7 * 0.0223 * sin(0.0223 * y - 0.2)
    tilt_x, tilt_y = degrees(slope_y) / 2, degrees(slope_x) / 2
    turn = 5.3 + 0.011 * x
    return (x, y, height(x, y) + above, 171.437 + tilt_x, 19.214 - tilt_y, turn)


def path() -> list[Row]:
    rows = [
        Row(pose(-31.4, -22.9, 187.3), "MOVJ {} VJ=37.50 PL=3"),
        Row(pose(-3.7, -1.9, HOVER), "MOVL {} V=480.0 PL=2"),
    ]
    for number in range(PASSES):
        y = 1.37 + PITCH * number
        along = range(POINTS) if number % 2 == 0 else range(POINTS - 1, -1, -1)
        for index in along:
            x = 4.19 + STEP * index
            # Slower where the panel is steepest, as the post writes it.
            speed = 95.5 if abs(x - 196.0) < 41.0 else 131.5
            rows.append(Row(pose(x, y), f"MOVL {{}} V={speed:.1f}"))
    rows.append(Row(pose(7.3, 203.8, HOVER), "MOVL {} V=480.0 PL=2"))
    rows.append(Row(pose(-29.6, 211.2, 191.8), "MOVJ {} VJ=37.50"))
    return rows


def job(rows: list[Row]) -> str:
    """The whole job, lines ending in LF."""
    head = [
        "/JOB", "//NAME FINISH", "//POS", f"///NPOS {len(rows)},0,0,0,0,0", "///USER 1", "///TOOL 3",
        "///POSTYPE USER", "///RECTAN", "///RCONF 1" + ",0" * 23,
    ]  # fmt: skip
    points = [
        f"C{number:05d}=" + ",".join(f"{value:.3f}" for value in row.pose[:3]) + ","
        + ",".join(f"{value:.4f}" for value in row.pose[3:])
        for number, row in enumerate(rows)
    ]  # fmt: skip
    middle = [
        "//INST", "///DATE 2026/05/21 11:36", "///COMM finishing pass, ball 12 mm", "///ATTR SC,RW,RJ",
        "////FRAME USER 1", "///GROUP1 RB1", "NOP", "DOUT OT#(31) ON", "TIMER T=1.75",
    ]  # fmt: skip
    moves = [row.move.format(f"C{number:05d}") for number, row in enumerate(rows)]
    return "\n".join([*head, *points, *middle, *moves, "DOUT OT#(31) OFF", "END", ""])


def main() -> int:
    target = Path(__file__).with_name("FINISH.JBI")
    target.write_bytes(job(path()).replace("\n", "\r\n").encode("ascii"))
    print(f"{target}: {len(path())} points")
    return 0


if __name__ == "__main__":
    sys.exit(main())
