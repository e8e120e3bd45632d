"""Blending and acceleration against published recordings of a Yaskawa MA2010 on a DX200.

    python bench/ma2010.py FOLDER

FOLDER holds `ma2010_movl` (commands.csv and the joint recordings beside it) and `ma2010_acceleration`. Each
table says what was asked, what came out, and what was fitted on which runs; everything else in a table is
predicted. docs/blending.md explains.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize, minimize_scalar

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

import ma2010_poses as poses  # noqa: E402
from ma2010_runs import ROBOT, THRESHOLD, Run, read  # noqa: E402

from olp.core.source import decode  # noqa: E402
from olp.core.units import mm  # noqa: E402
from olp.ir import program as ir  # noqa: E402
from olp.ir.points import PointKind, PointState  # noqa: E402
from olp.robots.coordinate_systems import Cell, Mechanism  # noqa: E402
from olp.runtime.plan import PATHS, BlendCode  # noqa: E402
from olp.runtime.recorder import Recorder  # noqa: E402
from olp.timing.acceleration import load_law as load_acceleration  # noqa: E402
from olp.timing.blending import Corners, load_law  # noqa: E402
from olp.timing.blending._overlap import response  # noqa: E402
from olp.timing.blending.yaskawa import intervals  # noqa: E402
from olp.timing.motion import load_model  # noqa: E402
from olp.timing.timing import time_plan  # noqa: E402
from olp.timing.track import track  # noqa: E402

Floats = NDArray[np.float64]
SPEEDS = (50, 100, 200, 400, 800)
ZONES = np.array([0.0, *ROBOT.blend_zones])  # type: ignore[misc]


def answer(time: Floats | float, window: float, lag: float) -> Floats:
    """[s] What the filter makes of time passing from 0 on."""
    return response(1, np.atleast_1d(time)[:, None], np.atleast_1d(window), lag)[:, 0]


# --- position levels -------------------------------------------------------------------------------------------------


def level_time(run: Run, level: int, stop: float, window: float | None = None, lag: float = 0.0) -> float:
    """[s] between the thresholds: commands overlap by the law, an exact stop costs `stop`, filters make both ends."""
    lengths = run.lengths
    zones = np.append(np.minimum(ZONES[level], np.minimum(lengths[:-1], lengths[1:]) / 2), 0.0)
    before = np.insert(zones[:-1], 0, 0.0)
    speed = np.full_like(lengths, run.speed)
    gaps = intervals(lengths, speed, before, zones, speed, alone=stop / 2)
    gaps[:-1] += stop if level == 0 else 0.0
    return float(gaps.sum()) + _ends(run.speed, stop if window is None else window, lag)


def _ends(speed: float, window: float, lag: float) -> float:
    """[s] from the command's end to the last threshold, less from its begin to the first one."""

    def covered(t: float) -> float:
        return speed * float(answer(t, window, lag)[0])

    begin = brentq(lambda t: covered(t) - THRESHOLD, 1e-6, 5.0)
    end = brentq(lambda t: covered(t) - speed * (t - window / 2 - lag) - THRESHOLD, -5.0, 5.0)
    return float(end - begin)


def level_runs(folder: Path) -> None:
    print("Position levels, V = 10 mm/s. Fitted on `linear` alone: what a stop costs")
    tests = {
        name: read(folder, True, *(f"blending_test/{name}/blending_zone_test/pl{k}.csv" for k in range(9)))
        for name in ("linear", "linear3", "linear4", "kink")
    }

    def misfit(window: float) -> float:
        return sum((level_time(r, k, window) - r.total) ** 2 for k, r in enumerate(tests["linear"]))

    window = float(minimize_scalar(misfit, bounds=(0.05, 0.4), method="bounded").x)
    law = load_law("yaskawa")
    print(f"  a stop costs {window:.4f} s (the project carries {law.values['stop_time']} s)")
    errors, misses = [], []
    for name, runs in tests.items():
        off = [100 * (level_time(r, k, window) / r.total - 1) for k, r in enumerate(runs)]
        print(f"  {name:8s} measured s " + " ".join(f"{r.total:7.3f}" for r in runs))
        print("           error %    " + " ".join(f"{e:+7.2f}" for e in off))
        errors += off
        corners = [law.distance(_corner(r, ZONES[k])) if k else np.zeros(1) for k, r in enumerate(runs)]
        miss = [float(c[0]) - r.nearest for c, r in zip(corners, runs, strict=True)]
        print("           corner mm  " + " ".join(f"{r.nearest / mm:7.2f}" for r in runs))
        print("           error mm   " + " ".join(f"{m / mm:+7.2f}" for m in miss))
        misses += miss
    held = errors[9:]
    _asked("every run's total, %", 1.0, np.abs(errors).max())
    _asked("mean over all runs, %", 0.4, np.abs(errors).mean())
    _asked("mean over the runs not fitted on, %", 0.4, np.abs(held).mean())
    _asked("corner distance, mm", 0.5, np.abs(misses).max() / mm)
    ends = law.values["acceleration_time"], law.values["servo_lag"]
    other = [
        level_time(r, k, window, *ends) / r.total - 1 for runs in tests.values() for k, r in enumerate(runs)
    ]
    print(
        f"  the same with both ends from the corner runs' filter {ends}: worst {100 * np.abs(other).max():.2f} %,"
        f" mean {100 * np.abs(other).mean():.2f} %"
    )
    by_olp_time(tests, 1.0)
    dense(folder, window)


def told_by_olp_time(run: Run, level: int) -> float:
    """[s] between the thresholds in what `olp track` draws of a job with these moves; nothing is fitted."""
    moves = len(run.points) - 1
    text = decode(b"\r\n".join(b"MOVL" for _ in range(moves + 1)), "runs.jbi")
    recorder = Recorder(Cell([Mechanism("RB1", ROBOT)]), (text,))
    state = PointState(PointKind.POSE, frame="robot", configuration=(1, 0, 0, 0, 0, 0))
    places = [recorder.position(0, state, (*point, 3.1, 0.2, -0.4)) for point in run.points.tolist()]
    recorder.at[0] = places[0]
    zone = float(ZONES[level]) if level else np.nan
    for number, place in enumerate(places[1:], 1):
        recorder.step(0, number)
        code = BlendCode.EXACT if level == 0 or number == moves else BlendCode.ZONE
        recorder.row(0, place, PATHS.index(ir.Path.LINEAR), 1, run.speed, code, zone)
    path = track(time_plan(recorder.finish(())), 1e-3)
    behind = (path.position - run.points[0]) @ run.directions[0]
    ahead = (run.points[-1] - path.position) @ run.directions[-1]
    begin = float(path.time[int(np.argmax(behind > THRESHOLD))])
    return float(path.time[int(np.nonzero(ahead > THRESHOLD)[0][-1])]) - begin


def by_olp_time(tests: dict[str, list[Run]], asked: float) -> None:
    """Every run of `tests`, PL 0 to 8, timed by `olp time`."""
    errors = []
    for name, runs in tests.items():
        off = [100 * (told_by_olp_time(r, k) / r.total - 1) for k, r in enumerate(runs)]
        print(f"  {name:8s} olp time, error % " + " ".join(f"{e:+7.2f}" for e in off))
        errors += off
    _asked("`olp time` itself, every run's total, %", asked, np.abs(errors).max())


def dense(folder: Path, window: float) -> None:
    runs = read(folder, True, *(f"blending_test/linear/dense_points_test/pl{k}.csv" for k in range(9)))
    off = [100 * (level_time(r, k, window) / r.total - 1) for k, r in enumerate(runs)]
    print(
        "50 points 2.04 mm apart, the same stop, nothing fitted (the rule for dense points was found on these runs)"
    )
    print("           measured s " + " ".join(f"{r.total:7.3f}" for r in runs))
    print("           error %    " + " ".join(f"{e:+7.2f}" for e in off))
    _asked("every dense run, %", 3.0, np.abs(off).max())
    by_olp_time({"dense": runs}, 3.0)


def _corner(run: Run, zone: float, limits: tuple[float, float] = (np.inf, np.inf)) -> Corners:
    first, second = run.directions[:2]
    turn = float(np.arccos(np.clip(first @ second, -1.0, 1.0)))
    speed = run.speed
    return Corners.of(run.lengths[0], run.lengths[1], speed, speed, turn, zone, *limits)


# --- the corner without a position level -----------------------------------------------------------------------------


def filtered(run: Run, time: Floats, windows: Floats, lag: float) -> tuple[Floats, Floats]:
    """[m] covered along both moves at `time` from the first command on; `windows`: at the begin, corner and end [s]."""
    begin, corner, end = windows
    first, second = run.lengths / run.speed
    # A slower begin hands over later: the command still covers the whole length.
    turn = first + (begin - corner) / 2
    stop = turn + second + (corner - end) / 2
    passed = answer(time - turn, corner, lag)
    return (
        run.speed * (answer(time, begin, lag) - passed),
        run.speed * (passed - answer(time - stop, end, lag)),
    )


def windows_of(run: Run, window: float, limited: bool) -> Floats:
    """[s] at the begin, corner and end: longer where an axis could not follow (the by-pose law, nothing fitted)."""
    if not limited:
        return np.full(3, window)
    law = load_acceleration("by_pose")
    corner = int(np.argmin(np.linalg.norm(run.place - run.points[1], axis=1)))
    first, second = run.directions
    changes = ((0, first), (corner, second - first), (len(run.time) - 1, -second))
    limits = [law.along_path(ROBOT, run.joints[i], run.rates(i, change))[0][0] for i, change in changes]
    return np.maximum(window, run.speed / np.array(limits))


def corner_time(run: Run, windows: Floats, lag: float) -> float:
    """[s] between the thresholds; a recording that ends short of the target ends there for the prediction too."""
    time = np.arange(0.0, run.lengths.sum() / run.speed + 2.0, 5e-4)
    x, y = filtered(run, time, windows, lag)
    cosine = float(run.directions[0] @ run.directions[1])
    stop = run.ahead[-1] + THRESHOLD
    begin = np.interp(THRESHOLD, x + cosine * y, time)
    end = np.interp(-stop, -((run.lengths[1] - y) + cosine * (run.lengths[0] - x)), time)
    return float(end - begin)


def misfit(run: Run, windows: Floats, lag: float) -> float:
    """Mean square of the difference in place over V [s²]: both moves' parts, the clock of the recording set free."""
    grid = np.arange(0.0, run.lengths.sum() / run.speed + 2.0, 1e-3)
    model = np.stack(filtered(run, grid, windows, lag))
    base = np.linalg.pinv(run.directions.T)
    parts = base @ (run.place - run.points[0]).T

    def off(shift: float) -> float:
        moved = np.stack([np.interp(run.time - shift, grid, m) for m in model])
        return float(np.mean((parts - moved) ** 2)) / run.speed**2

    return float(minimize_scalar(off, bounds=(0.02, 0.3), method="bounded").fun)


def fit_filter(runs: list[Run], limited: bool) -> Floats:
    """Acceleration time and lag [s] that reproduce where the tool was in these runs."""

    def total(x: Floats) -> float:
        window, lag = np.maximum(np.abs(x), 1e-3)
        return 1e6 * sum(misfit(r, windows_of(r, window, limited), lag) for r in runs)

    options = {"xatol": 1e-4, "fatol": 1e-3, "maxiter": 100}
    found: Floats = np.abs(minimize(total, [0.15, 0.03], method="Nelder-Mead", options=options).x)
    return found


def corner_runs(folder: Path) -> None:
    print(
        "\nThe corner without a position level, one speed left out. Fitted on the other four: acceleration time, lag"
    )
    names = [f"blending_test/streaming_movel/movel_test/joint_recording_{v}.csv" for v in SPEEDS]
    runs = read(folder, False, *names)
    for limited in (True, False):
        print("  acceleration limits of the axes " + ("by pose" if limited else "ignored"))
        errors = []
        for left_out, run in enumerate(runs):
            window, lag = fit_filter(runs[:left_out] + runs[left_out + 1 :], limited)
            windows = windows_of(run, window, limited)
            error = 100 * (corner_time(run, windows, lag) / run.total - 1)
            law = load_law("acceleration_filter", acceleration_time=float(windows[1]), servo_lag=float(lag))
            near = float(law.distance(_corner(run, 0.0))[0])
            print(
                f"    V {SPEEDS[left_out]:3d}: time {window:.4f} lag {lag:.4f} begin {windows[0]:.3f} s; measured"
                f" {run.total:.3f} s, error {error:+.2f} %; corner {run.nearest / mm:5.2f} mm,"
                f" error {(near - run.nearest) / mm:+.2f} mm"
            )
            errors.append(abs(error))
        _asked("every speed, %", 1.0, max(errors))
    print("  peers, one speed left out")
    path = np.array([_path(r) for r in runs])
    speed, measured = np.array([r.speed for r in runs]), np.array([r.total for r in runs])
    print("    recorded path over V:            error % " + _percent(path / speed / measured - 1))
    constant = [_constant_acceleration(path, speed, measured, k) for k in range(len(runs))]
    print("    recorded path over V + V/a:      error % " + _percent(np.array(constant) / measured - 1))
    for taken in (0.14, 0.15, 0.166):
        lag = _lag(runs[:-1], taken)
        error = corner_time(runs[-1], windows_of(runs[-1], taken, True), lag) / runs[-1].total - 1
        print(
            f"  V 800 from the other four, time held at {taken:.3f} s: lag {lag:.4f} s, error {100 * error:+.2f} %"
        )
    closed_forms(runs)
    both = fit_filter(runs, True)
    print(f"  all five together: acceleration time {both[0]:.4f} s, lag {both[1]:.4f} s")
    carried = load_law("acceleration_filter").values
    numbers = carried["acceleration_time"], carried["servo_lag"]
    assert numbers[0] is not None
    assert numbers[1] is not None
    errors = [corner_time(r, windows_of(r, numbers[0], True), numbers[1]) / r.total - 1 for r in runs]
    print(f"  all five with what the project carries, {numbers}: error % {_percent(np.array(errors))}")


def closed_forms(runs: list[Run]) -> None:
    """The laws of `olp time`, without filter and lag: one ramp at each end of the whole length, no fit."""
    own = 3.05  # [m/s²] what olp time takes for the lines of an MA2010
    by_pose = [_by_pose(run) for run in runs]
    laws = {
        "constant": [(own, own)] * len(runs),
        "time_constant": [(min(own, run.speed / 0.15),) * 2 for run in runs],
        "by_pose": [(min(own, up), min(own, down)) for up, down in by_pose],
        "by_pose without the linear acceleration": by_pose,
    }
    print("  olp time's acceleration laws, closed forms between the same thresholds: error %")
    for name, pushes in laws.items():
        errors = [_closed_form(run, *push) / run.total - 1 for run, push in zip(runs, pushes, strict=True)]
        print(f"    {name:40s} {_percent(np.array(errors))}")


def _by_pose(run: Run) -> tuple[float, float]:
    """[m/s²] that the axes allow at the start and at the end."""
    law, (first, second) = load_acceleration("by_pose"), run.directions
    ends = ((0, first), (len(run.time) - 1, -second))
    up, down = (float(law.along_path(ROBOT, run.joints[i], run.rates(i, d))[0][0]) for i, d in ends)
    return up, down


def _closed_form(run: Run, up: float, down: float) -> float:
    """[s] between the thresholds."""
    length = float(run.lengths.sum())
    profile = load_model("constant").profile(length, run.speed, up, down)
    begin, end = (float(profile.time_at(at)[0]) for at in (THRESHOLD, length - run.ahead[-1] - THRESHOLD))
    return end - begin


def _lag(runs: list[Run], time: float) -> float:
    """[s] that reproduces where the tool was in these runs, the acceleration time given."""

    def total(lag: float) -> float:
        return 1e6 * sum(misfit(r, windows_of(r, time, True), lag) for r in runs)

    return float(minimize_scalar(total, bounds=(0.01, 0.1), method="bounded").x)


def _path(run: Run) -> float:
    """[m] between the thresholds."""
    whole = float(np.linalg.norm(np.diff(run.place, axis=0), axis=1).sum())
    return whole - 2 * THRESHOLD


def _constant_acceleration(path: Floats, speed: Floats, measured: Floats, left_out: int) -> float:
    """[s] path/V + V/a for one run, a fitted on the others' relative errors."""
    others = np.arange(len(path)) != left_out

    def off(a: float) -> float:
        return float(np.sum(((path / speed + speed / a) / measured - 1)[others] ** 2))

    a = minimize_scalar(off, bounds=(0.5, 20.0), method="bounded").x
    return float(path[left_out] / speed[left_out] + speed[left_out] / a)


def _percent(errors: Floats) -> str:
    return " ".join(f"{100 * e:+7.2f}" for e in errors)


# --- acceleration by pose --------------------------------------------------------------------------------------------


def acceleration(folder: Path) -> None:
    print("\nAcceleration over 202 poses, RMS of held-out poses [rad/s²]; + direction, - direction")
    table = poses.read(folder / "yaskawa_ma2010_real.csv")
    for axis, name in enumerate("SLU"):
        results = {}
        for candidate in poses.CANDIDATES[axis]:
            rms = [
                _rms(poses.held_out(candidate, table, axis, poses.groups(table, rows)))
                for rows in (False, True)
            ]
            results[candidate.name] = rms[0]
            print(f"  {name} {candidate.name:16s} tenths of the poses {rms[0]}   whole angles of L {rms[1]}")
        errors, names = poses.chosen_inside(table, axis)
        print(f"  {name} law chosen inside each fold: {_rms(errors)}, chosen {', '.join(sorted(set(names)))}")
        if axis == 0:
            _asked("axis S, rad/s²", 0.45, float(_rms(errors).max()))
        else:
            _asked(
                f"axis {name}, share of the constant's",
                1 / 3,
                float((_rms(errors) / results["constant"]).max()),
            )
        best = poses.CANDIDATES[axis][-1]
        print(
            "    all poses: "
            + " ".join(f"{x:.5f}" for x in best.fit(table.lean, table.lift, table.measured[axis]))
        )


def _rms(errors: Floats) -> Floats:
    result: Floats = np.sqrt(np.mean(errors**2, axis=0)).round(3)
    return result


def _asked(what: str, most: float, found: float) -> None:
    verdict = "holds" if found <= most else "DOES NOT HOLD"
    print(f"  asked: {what} <= {most:.3g}; measured {found:.3g}: {verdict}")


def main() -> int:
    if len(sys.argv) != 2:
        print(__doc__)
        return 2
    folder = Path(sys.argv[1])
    level_runs(folder / "ma2010_movl")
    corner_runs(folder / "ma2010_movl")
    acceleration(folder / "ma2010_acceleration")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
