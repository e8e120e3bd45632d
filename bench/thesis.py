"""Recomputes what Apostolovic's thesis prints, from the points and times in samples/up20.

    python bench/thesis.py

Every line says how many numbers follow to their last printed digit, how many more follow once an oddity of the
print is known, and of how many; below it the oddities are named. What is wrong in the equations themselves is in
docs/thesis.md.
"""

from __future__ import annotations

import csv
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from olp.core.units import deg, mm  # noqa: E402
from olp.identification.apostolovic import (  # noqa: E402
    adjusted_acceleration,
    bearing,
    correction_factor,
    interpolated_factor,
)
from olp.timing.motion import load_model  # noqa: E402

Floats = NDArray[np.float64]
TICK = 0.01  # [s] what the controller and the simulator display

# Times displayed with two decimals whose printed error, percentage and factor all follow from a value half way
# between two hundredths: the mean of two readings, rounded when printed. Move number -> seconds.
MEANS_OF_TWO = {17: 2.705, 44: 2.715, 94: 2.865, 130: 3.515, 136: 2.965}


@dataclass(frozen=True, slots=True)
class Experiment:
    """The appendix: SI arrays of shape (146,) and the digits as printed."""

    rows: list[dict[str, str]]  # moves.csv
    printed: list[dict[str, str]]  # printed.csv
    step: Floats  # end - start, (146, 3) [m]
    length: Floats  # [m], from the coordinates
    speed: Floats  # [m/s]
    nominal: Floats  # [m/s²]
    robot: Floats  # [s]
    simulation: Floats  # [s]

    @property
    def downward(self) -> NDArray[np.bool_]:
        return np.array([row["test"] == "downward" for row in self.rows])


@dataclass(frozen=True, slots=True)
class Figure:
    """One promise: how many printed numbers follow as they stand, how many with an explanation, of how many."""

    name: str
    direct: int
    explained: int
    total: int
    notes: tuple[str, ...] = ()


def read() -> Experiment:
    """The experiment from samples/up20."""
    folder = ROOT / "samples" / "up20"
    tables = []
    for name in ("moves.csv", "printed.csv"):
        with (folder / name).open(encoding="utf-8", newline="") as file:
            tables.append(list(csv.DictReader(file)))
    rows, printed = tables

    def column(name: str) -> Floats:
        return np.array([float(row[name]) for row in rows])

    ends = [[column(f"{axis}_{end}_mm") for axis in "xyz"] for end in ("start", "end")]
    step = (np.array(ends[1]) - np.array(ends[0])).T * mm
    return Experiment(
        rows,
        printed,
        step,
        np.linalg.norm(step, axis=1),
        column("speed_mm_s") * mm,
        column("accel_mm_s2") * mm,
        column("duration_s"),
        column("sim_s"),
    )


def follows(value: float, text: str) -> bool:
    """Whether a number, rounded, prints as `text`; a tie may go either way."""
    return bool(abs(value - float(text)) <= _unit(text) / 2 + 1e-9)


def cut_off(value: float, text: str) -> bool:
    """Whether a number prints as `text` when its further digits are cut off instead of rounded."""
    return bool(-1e-9 <= abs(value) - abs(float(text)) < _unit(text))


def _unit(text: str) -> float:
    return float(10.0 ** -len(text.partition(".")[2]))


def where(e: Experiment, i: int) -> str:
    """Table, start and target of row i, for a note."""
    row = e.rows[i]
    return f"{row['table']} {row['start']} to {row['target']}"


def distances(e: Experiment) -> Figure:
    """Travel distance, equation 4.15."""
    notes, direct, explained = [], 0, 0
    for i, printed in enumerate(e.printed):
        value, text = float(e.length[i] / mm), printed["distance_mm"]
        if follows(value, text):
            direct += 1
            continue
        explained += cut_off(value, text)
        how = "cut off, not rounded" if cut_off(value, text) else "does not follow"
        notes.append(f"{where(e, i)}: printed {text}, is {value:.4f} ({how})")
    return Figure("distances (4.15), to 0.01 mm", direct, explained, len(e.rows), tuple(notes))


def bearings(e: Experiment) -> Figure:
    """Bearing and incline, equation 5.2."""
    along = np.where(e.downward, e.step[:, 2], e.step[:, 0])
    angle = bearing(along, e.step[:, 1]) / deg
    wrong = [i for i, p in enumerate(e.printed) if not follows(float(angle[i]), p["angle_deg"])]
    notes = tuple(f"{where(e, i)}: {angle[i]:.3f}" for i in wrong)
    return Figure("bearings and inclines (5.2), to 0.01 deg", len(e.rows) - len(wrong), 0, len(e.rows), notes)


def phases(e: Experiment) -> Figure:
    """Phases of the simulated moves by table 4.1 against the motion model, to 1e-12 s."""
    a, v = e.nominal, e.speed
    s1 = v**2 / (2 * a)  # 4.7
    by_hand = np.stack([v / a, (e.length - 2 * s1) / v, v / a], axis=1)  # 4.5, 4.16 with 4.17, 4.12
    model = load_model("constant").profile(e.length, v, a).durations
    good = np.abs(by_hand - model).max(axis=1) < 1e-12
    return Figure("phases of table 4.1 equal the motion model's, to 1e-12 s", int(good.sum()), 0, len(good))


def linear_phases(e: Experiment) -> Figure:
    """Phases by 4.23 to 4.66, one move at a time, against the motion model, to 1e-9 s."""
    model, total, good = load_model("linear"), 0, 0
    for speed in (0.3, 0.9, 0.05):
        for k1, k2 in ((4.0, 4.0), (1.1, 6.3), (6.3, 1.1), (0.5, 0.3)):
            got = model.profile(e.length, speed, e.nominal, k1=k1, k2=k2).durations
            for i, length in enumerate(e.length):
                expected = seven_phases(float(length), speed, float(e.nominal[i]), k1, k2)
                good += bool(np.abs(got[i] - expected).max() < 1e-9)
                total += 1
    return Figure("phases of section 4.3 equal the motion model's, to 1e-9 s", good, 0, total)


def seven_phases(length: float, speed: float, a_max: float, k1: float, k2: float) -> list[float]:
    """Durations [s] by the equations of section 4.3, corrected as docs/thesis.md says."""
    s = 1 / k1 + 1 / k2
    full = a_max**2 * s / 2  # speed at which a_max is just reached and left again (4.26 with 4.42)
    a = a_max if speed >= full else (2 * speed / s) ** 0.5  # 4.64 solved for a: the case left out
    t2 = speed / a - a * s / 2  # 4.46
    v1 = a**2 / (2 * k1)  # 4.26
    s123 = a**3 / (6 * k1**2) + v1 * t2 + a * t2**2 / 2  # 4.29 + 4.35
    s123 += (speed - a**2 / (2 * k2)) * a / k2 + a**3 / (3 * k2**2)  # 4.45 with 4.42
    if 2 * s123 <= length:
        t4 = (length - 2 * s123) / speed  # 4.51, 4.52
    else:
        t4 = 0.0
        c1, c2 = a_max / 2, a_max**2 / (2 * k1) + a_max**2 / k2
        c3 = a_max**3 * (1 / (6 * k1**2) + 1 / (2 * k1 * k2) + 1 / (3 * k2**2)) - length / 2
        if c3 <= 0 and speed > full:
            a, t2 = a_max, (-c2 + (c2**2 - 4 * c1 * c3) ** 0.5) / (2 * c1)  # 4.56
        else:
            a, t2 = (3 * length * k1**2 * k2**2 / ((2 * k1 + k2) * (k1 + k2))) ** (1 / 3), 0.0  # 4.66
    return [a / k1, t2, a / k2, t4, a / k2, t2, a / k1]


SIMULATION = "simulation times, to 0.01 s"


def simulation_times(e: Experiment) -> Figure:
    """The simulator's clock against 4.5 + 4.17 + 4.12, by a rule read off tables A.7 to A.13."""
    exact = load_model("constant").profile(e.length, e.speed, e.nominal).duration
    flat = ~e.downward
    ruled = np.floor(exact / TICK + 1e-9) * TICK + 2 * TICK
    off = e.simulation - exact
    notes = [
        f"A.7 to A.13 print L/v + v/a plus {off[flat].min():.4f} to {off[flat].max():.4f} s: "
        "the last full hundredth and two more",
        *(f"{where(e, i)}: printed {e.simulation[i]:.2f}, by that rule {ruled[i]:.2f}"
          for i in map(int, np.flatnonzero(flat & (np.abs(ruled - e.simulation) > 1e-6)))),
        f"A.14 and A.15 print L/v + v/a plus {off[~flat].min():.4f} to {off[~flat].max():.4f} s, no rule found: "
        "for the same length and speed the same simulator shows 2.90 s (A.11) and 2.86 s (A.14)",
    ]  # fmt: skip
    good = int((flat & (np.abs(ruled - e.simulation) < 1e-6)).sum())
    return Figure(SIMULATION, 0, good, len(exact), tuple(notes))


def times(e: Experiment) -> Floats:
    """Measured times [s], with the five that are means of two readings unrounded."""
    robot = e.robot.copy()
    for move, seconds in MEANS_OF_TWO.items():
        robot[move - 1] = seconds
    return robot


def errors(e: Experiment) -> Figure:
    """Error and percentage, robot minus simulation over robot."""
    notes, counts = [], [0, 0]
    for i, (printed, unrounded) in enumerate(zip(e.printed, times(e), strict=True)):
        best = 0
        for explained, seconds in enumerate((float(e.robot[i]), float(unrounded))):
            error = seconds - float(e.simulation[i])
            good = int(follows(error, printed["error_s"]))
            good += follows(100 * error / seconds, printed["error_pct"])
            counts[explained] += max(good - best, 0)
            best = max(good, best)
        if unrounded != e.robot[i]:
            notes.append(
                f"{where(e, i)}: time printed {printed['robot_s']}, error and percentage need {unrounded}"
            )
    return Figure("errors in s and in %", counts[0], counts[1], 2 * len(e.rows), tuple(notes))


def accelerations(e: Experiment) -> Figure:
    """Equation 6.1: constant acceleration with the adjusted value takes the measured time."""
    a = adjusted_acceleration(e.robot, e.length, e.speed)
    profile = load_model("constant").profile(e.length, e.speed, a)
    good = (np.abs(profile.duration - e.robot) < 1e-9) & profile.reached
    notes = (f"from {a.min() / mm:.2f} to {a.max() / mm:.2f} mm/s², factors {a.min() / 0.4:.2f} to "
             f"{a.max() / 0.4:.2f}: {(a < 0.4).sum()} below 1, {(a > 0.8).sum()} above 2",)  # fmt: skip
    name = "adjusted accelerations (6.1) give the measured time back, to 1e-9 s"
    return Figure(name, int(good.sum()), 0, len(a), notes)


def factors(e: Experiment) -> Figure:
    """Table A.16, equation 6.2."""
    notes, direct, explained = [], 0, 0
    both = [
        correction_factor(adjusted_acceleration(t, e.length, e.speed), e.nominal) for t in (e.robot, times(e))
    ]
    listed = [i for i, p in enumerate(e.printed) if p["factor"]]
    for i in listed:
        text = e.printed[i]["factor"]
        plain, unrounded = float(both[0][i]), float(both[1][i])
        if follows(plain, text):
            direct += 1
            continue
        explained += follows(unrounded, text)
        notes.append(
            f"{where(e, i)}: printed {text}; from the printed time {plain:.4f}, from {times(e)[i]} {unrounded:.4f}"
        )
    return Figure("table A.16, C_H (6.2), to 0.01", direct, explained, len(listed), tuple(notes))


def examples(e: Experiment) -> Figure:
    """The two worked examples of section 6.2.1."""
    a = float(adjusted_acceleration(2.64, 0.640, 0.3)) / mm
    angles, table = [4.47 * deg, 8.88 * deg], [1.44, 1.39]
    c = float(interpolated_factor(7 * deg, angles, table))
    exact = correction_factor(adjusted_acceleration(e.robot[1:3], e.length[1:3], e.speed[1:3]), 0.4)
    unrounded = float(interpolated_factor(7 * deg, angles, exact))
    good = [follows(a, "592.11"), follows(a / 400, "1.48"), follows(c, "1.411")]
    notes = (
        f"from the rounded factors {c:.4f}, from unrounded ones {unrounded:.4f}: the third decimal is not known",
    )
    return Figure("worked examples 592.11 mm/s², 1.48, 1.411", sum(good), 0, 3, notes)


def figures() -> list[Figure]:
    """All figures, in the order of the thesis."""
    e = read()
    makers = (
        distances,
        phases,
        linear_phases,
        bearings,
        simulation_times,
        errors,
        accelerations,
        factors,
        examples,
    )
    return [make(e) for make in makers]


def main() -> int:
    """Prints the table; status 1 when a number neither follows nor is explained, the simulator's clock aside."""
    rows = figures()
    print("follow  explained  of     what")
    for figure in rows:
        print(f"{figure.direct:6d}  {figure.explained:9d}  {figure.total:5d}  {figure.name}")
        for note in figure.notes:
            print(f"                          - {note}")
    wrong = [f for f in rows if f.direct + f.explained < f.total and f.name != SIMULATION]
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
