"""The diagnosis on published recordings of a Yaskawa MA2010 (DX200): is what a simulation leaves out named?

    python bench/real_ma2010.py FOLDER [OUT]

FOLDER holds `ma2010_movl` (commands.csv and the joint recordings beside it). Recordings in olp's own form are made of
them, in OUT or a temporary folder, each with the times of a simulation that leaves something out, and diagnosed.
docs/real/ma2010.md explains.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from ma2010_runs import ROBOT, THRESHOLD, Run, read  # noqa: E402
from real_tables import Case, print_cases  # noqa: E402

from olp.identification.recording import RecordingSettings, write_recording  # noqa: E402
from olp.identification.recording.moves import LINEAR, RecordedMoves  # noqa: E402
from olp.robots.geometry import Pose, angles_from_rotation  # noqa: E402
from olp.robots.kinematics import forward  # noqa: E402

Floats = NDArray[np.float64]

STOP = 0.1655  # [s] what an exact stop costs at 10 mm/s, fitted on the runs `linear` (docs/blending.md)
ZONES = np.array([0.0, *(ROBOT.blend_zones or ())])
LEVEL_TESTS = ("linear", "linear2", "linear3", "linear4", "kink")
SPEEDS = (50, 100, 200, 400, 800)
FIVE_ACCELERATIONS = (3.05, 0.6)  # [m/s²] what olp time takes for the lines of an MA2010, and a fifth of it
LEVEL_CLOCK, SPEED_CLOCK = 0.046, 0.004  # [s] between the recorder's samples
STEP = 1e-3  # [s] of the simulation


@dataclass(frozen=True, slots=True)
class Executed:
    """One run of two moves. `zone` [m] of its corner, nan where no position level was programmed; `level` -1 then."""

    run: Run
    level: int
    name: str

    @property
    def zone(self) -> float:
        return float(ZONES[self.level]) if self.level > 0 else 0.0

    @property
    def end(self) -> Floats:
        """(3,) [m] where the run came to rest: some stopped short of the target."""
        return self.run.points[-1] - self.run.ahead[-1] * self.run.directions[-1]


# --- durations ------------------------------------------------------------------------------------------------------


def durations(run: Run, time: Floats, place: Floats, end: Floats) -> tuple[float, float]:
    """[s] of both moves: from 0.5 mm behind the start, over the plane that halves the corner, to 0.5 mm before the end.

    The plane is passed in the middle between 0.5 mm before and behind it: the tool may stand in it.
    """
    first, second = run.directions[:2]
    across = (first + second) / np.linalg.norm(first + second)
    middle = (place - run.points[1]) @ across
    begin = _crossing(time, (place - run.points[0]) @ first, THRESHOLD)
    corner = 0.5 * (_crossing(time, middle, -THRESHOLD) + _crossing(time, middle, THRESHOLD))
    stop = _crossing(time, (place - end) @ second, -THRESHOLD)
    return corner - begin, stop - corner


def _crossing(time: Floats, way: Floats, level: float) -> float:
    """[s] at which a rising way first passes a level."""
    after = int(np.argmax(way > level))
    share = (level - way[after - 1]) / (way[after] - way[after - 1])
    return float(time[after - 1] + share * (time[after] - time[after - 1]))


def simulated(made: Executed, kind: str, window: float) -> tuple[float, float]:
    """[s] of both moves in small time steps: commands at constant speed, smoothed over `window` [s] (ramps V/window).

    `kind`: "stops" (every point an exact stop), "passes" (rounded points passed at constant speed) or "overlaps" (the
    next move begins a zone before the point, at most half a move, and its speed rises over zone/V: docs/blending.md).
    """
    run, speed = made.run, made.run.speed
    first, second = float(run.lengths[0]), float(np.linalg.norm(made.end - run.points[1]))
    time = np.arange(0.0, (first + second) / speed + 3.0, STEP)
    stops = kind == "stops" or made.level == 0
    zone = min(made.zone, first / 2, second / 2) if kind == "overlaps" and not stops else 0.0
    begin = (first - zone) / speed + (window if stops else 0.0)
    one = np.clip(speed * time, 0.0, first)
    rise = max(zone / speed, 1e-9)
    late = np.maximum(time - begin, 0.0)
    two = np.clip(np.where(late < rise, speed * late**2 / (2 * rise), speed * (late - rise / 2)), 0.0, second)
    smooth = [_smoothed(way, window) for way in (one, two)]
    place = run.points[0] + np.outer(smooth[0], run.directions[0]) + np.outer(smooth[1], run.directions[1])
    return durations(run, time, place, made.end)


def _smoothed(way: Floats, window: float) -> Floats:
    """The mean over the last `window` seconds."""
    count = max(round(window / STEP), 1)
    total = np.concatenate([np.zeros(count), np.cumsum(way)])
    return (total[count:] - total[:-count]) / count


# --- recordings -----------------------------------------------------------------------------------------------------


def level_runs(folder: Path) -> list[Executed]:
    """Every position level on four straight lines and a corner of 60 degrees, at 10 mm/s."""
    made = []
    for test in LEVEL_TESTS:
        # The level 0 of linear2 was recorded with another control group.
        for level in range(1 if test == "linear2" else 0, 9):
            name = f"blending_test/{test}/blending_zone_test/pl{level}.csv"
            made.append(Executed(read(folder, True, name)[0], level, f"{test}-{level}"))
    return made


def speed_runs(folder: Path) -> list[Executed]:
    """A corner of 60 degrees without position level at five speeds."""
    names = [f"blending_test/streaming_movel/movel_test/joint_recording_{v}.csv" for v in SPEEDS]
    return [Executed(run, -1, f"V{v}") for v, run in zip(SPEEDS, read(folder, False, *names), strict=True)]


def write(
    folder: Path, made: list[Executed], kind: str, windows: list[float], title: str, tool: Floats
) -> Path:
    """A recording of the runs with the simulation's times, two moves each."""
    rows = [
        (item, k, measured, sim, window)
        for item, window in zip(made, windows, strict=True)
        for k, (measured, sim) in enumerate(
            zip(
                durations(item.run, item.run.time, item.run.place, item.end),
                simulated(item, kind, window),
                strict=True,
            )
        )
    ]
    count = len(rows)
    nothing = np.full(count, np.nan)
    start = np.array([i.run.points[k] for i, k, *_ in rows])
    end = np.array([i.run.points[1] if k == 0 else i.end for i, k, *_ in rows])
    joints = [_joints(i.run) for i, *_ in rows]
    first = np.array([q[k] for (_, k, *_), q in zip(rows, joints, strict=True)])
    last = np.array([q[k + 1] for (_, k, *_), q in zip(rows, joints, strict=True)])
    turned = [angles_from_rotation(forward(ROBOT, q)[1] @ tool[:3, :3]) for q in (first, last)]
    moves = RecordedMoves(
        move=np.arange(1, count + 1),
        kind=np.full(count, LINEAR, dtype=np.int8),
        duration=np.array([measured for *_, measured, _, _ in rows]),
        sim=np.array([sim for *_, sim, _ in rows]),
        start=start,
        end=end,
        via=np.full((count, 3), np.nan),
        start_angles=turned[0],
        end_angles=turned[1],
        joints_start=first,
        joints_end=last,
        slides=(False,) * 6,
        speed=np.array([i.run.speed for i, *_ in rows]),
        speed_fraction=nothing,
        acceleration=np.array([i.run.speed / window for i, *_, window in rows]),
        acceleration_fraction=nothing,
        blend=np.array([i.zone if k == 0 else 0.0 for i, k, *_ in rows]),
        level=np.array([i.level if k == 0 else 0 for i, k, *_ in rows], dtype=np.int8),
        t_start=nothing,
        cycle=np.full(count, -1),
        line=np.array([k + 1 for _, k, *_ in rows]),
        job=tuple(i.name for i, *_ in rows),
        payload=nothing,
        payload_inertia=nothing,
    )
    settings = RecordingSettings(
        robot="yaskawa/ma2010",
        controller="DX200",
        time_resolution=LEVEL_CLOCK if made[0].level >= 0 else SPEED_CLOCK,
        tool=tuple(Pose(tool[:3, 3], tool[:3, :3]).xyz_angles().tolist()),
    )
    write_recording(folder, moves, settings, comment=title)
    if any(i.level < 0 for i in made):
        _untagged(folder / "moves.csv", [i.level < 0 and k == 0 for i, k, *_ in rows])
    return folder


def _untagged(file: Path, which: list[bool]) -> None:
    """Column `corner`, as `olp recording from-log` writes it: no position level, so the controller passes the point."""
    header, *lines = file.read_text().splitlines()
    cells = [f"{line},{'untagged' if silent else ''}" for line, silent in zip(lines, which, strict=True)]
    file.write_text("\n".join([f"{header},corner", *cells, ""]))


def _joints(run: Run) -> Floats:
    """(3, 6) [rad] at the begin, nearest to the corner, and at the end."""
    corner = int(np.argmin(np.linalg.norm(run.place - run.points[1], axis=1)))
    return run.joints[[0, corner, -1]]


def cases(folder: Path, out: Path) -> list[Case]:
    """Recordings, and what has to be said of each."""
    old, new = (np.loadtxt(folder / "config" / f, delimiter=",") for f in ("weldgun_old.csv", "torch.csv"))
    for tool in (old, new):
        tool[:3, 3] /= 1000.0
    levels, speeds = level_runs(folder), speed_runs(folder)
    stop = [STOP] * len(levels)
    quick, slow = ([i.run.speed / a for i in speeds] for a in FIVE_ACCELERATIONS)
    agree = [i for i in levels if i.level == 0]
    wanted = (
        ("levels, exact stops", levels, "stops", stop, old, {"blending"}),
        ("levels, constant speed", levels, "passes", stop, old, {"blending"}),
        ("levels, overlap (agrees)", levels, "overlaps", stop, old, set()),
        ("level 0 alone, exact stops (agrees)", agree, "stops", [STOP] * len(agree), old, set()),
        ("five speeds, 0.6 m/s²", speeds, "passes", slow, new, {"acceleration", "jerk"}),
        ("five speeds, 3.05 m/s²", speeds, "passes", quick, new, {"acceleration", "jerk"}),
    )
    made = []
    for number, (title, runs, kind, windows, tool, names) in enumerate(wanted, 1):
        path = write(out / f"{number}", runs, kind, windows, title, tool)
        made.append(Case(title, path, frozenset(names)))
    return made


def main() -> int:
    if len(sys.argv) not in (2, 3):
        print(__doc__)
        return 2
    folder = Path(sys.argv[1]) / "ma2010_movl"
    with tempfile.TemporaryDirectory() as temporary:
        out = Path(sys.argv[2]) if len(sys.argv) == 3 else Path(temporary)
        print_cases(cases(folder, out))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
