"""Blending against what a DX200 did with an MA2010: facts in tests/data/ma2010_corners.csv."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from olp.robots.robot import load_robot
from olp.timing.blending import Corners, load_law
from olp.timing.blending._overlap import response
from olp.timing.blending.yaskawa import intervals

MM = 1e-3
THRESHOLD = 0.5 * MM
ZONES = (0.0, *load_robot("yaskawa/ma2010").blend_zones)
LINES = {"kink": (57.735, 57.735), "dense": (100 / 49,) * 49, "corner": (230.940, 230.940)}
TURN = {"kink": np.pi / 3, "corner": np.pi / 3}


def facts() -> list[dict[str, str]]:
    text = (Path(__file__).parent / "data" / "ma2010_corners.csv").read_text(encoding="utf-8")
    return list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))


LEVELS = [row for row in facts() if row["level"]]
FILTERED = [row for row in facts() if row["test"] == "corner"]


def name_of(row: dict[str, str]) -> str:
    return f"{row['test']}-{row['level'] or row['speed_mm_s']}"


def late(speed: float, window: float, lag: float) -> float:
    """[s] until the filter lets a move of `speed` pass the threshold."""
    time = np.linspace(0.0, 1.0, 20_001)
    way = speed * response(1, time[None], np.array([window]), lag)[0]
    return float(np.interp(THRESHOLD, way, time))


def level_time(row: dict[str, str]) -> float:
    law = load_law("yaskawa")
    window, speed = law.values["stop_time"], float(row["speed_mm_s"]) * MM
    lengths = np.array(LINES.get(row["test"], (50.0, 50.0))) * MM
    corners = Corners.of(
        lengths[:-1], lengths[1:], speed, speed, TURN.get(row["test"], 0.0), ZONES[int(row["level"])]
    )
    zones = np.append(law.passage(corners).trim_before, 0.0)
    speeds = np.full(len(lengths), speed)
    gaps = intervals(lengths, speeds, np.insert(zones[:-1], 0, 0.0), zones, speeds, law.alone)
    gaps[:-1] += window if row["level"] == "0" else 0.0
    return float(gaps.sum()) + window - 2 * late(speed, window, 0.0)


@pytest.mark.parametrize("row", LEVELS, ids=name_of)
def test_a_run_with_position_levels_takes_the_measured_time(row):
    dense = row["test"] == "dense"
    assert level_time(row) == pytest.approx(float(row["total_s"]), rel=0.03 if dense else 0.01)


def test_runs_with_position_levels_are_off_by_a_tenth_of_a_percent_on_the_mean():
    rows = [row for row in LEVELS if row["test"] != "dense"]
    errors = [abs(level_time(row) / float(row["total_s"]) - 1) for row in rows]
    assert np.mean(errors) < 0.0015


def test_the_saving_of_the_law_is_the_interval_that_is_missing():
    lengths, speed, zone = np.array([0.05, 0.05]), np.array([0.01, 0.01]), np.array([0.0125, 0.0])
    passage = load_law("yaskawa").passage(Corners.of(0.05, 0.05, 0.01, 0.01, 0.4, 0.0125))
    whole = intervals(lengths, speed, np.array([0.0, 0.0125]), zone, speed, 0.083).sum()
    assert whole == pytest.approx(10.0 - passage.saving[0])


@pytest.mark.parametrize("row", [r for r in LEVELS if r["nearest_mm"]], ids=name_of)
def test_the_tool_passes_the_point_at_the_measured_distance(row):
    zone = ZONES[int(row["level"])]
    length, speed = LINES.get(row["test"], (50.0, 50.0))[0] * MM, float(row["speed_mm_s"]) * MM
    corner = Corners.of(length, length, speed, speed, TURN.get(row["test"], 0.0), zone)
    near = load_law("yaskawa").distance(corner)[0] if zone else 0.0
    assert near / MM == pytest.approx(float(row["nearest_mm"]), abs=0.1)


@pytest.mark.parametrize("row", FILTERED, ids=name_of)
def test_a_corner_without_position_level_is_cut_in_proportion_to_the_speed(row):
    """At 800 mm/s axes L and U allow no more than 5.0 m/s² there (by-pose law), and the filter gets longer."""
    speed = float(row["speed_mm_s"]) * MM
    corner = Corners.of(0.23094, 0.23094, speed, speed, np.pi / 3, 0.0, 5.0, 5.0)
    near = load_law("acceleration_filter").distance(corner)[0] / MM
    assert near == pytest.approx(float(row["nearest_mm"]), rel=0.06)


@pytest.mark.parametrize("row", [r for r in FILTERED if r["speed_mm_s"] != "800"], ids=name_of)
def test_a_corner_without_position_level_takes_the_measured_time(row):
    speed, side, stop = (float(row["speed_mm_s"]) * MM, 230.940 * MM, (float(row["short_mm"]) + 0.5) * MM)
    law = load_law("acceleration_filter")
    window, lag = np.array([law.values["acceleration_time"]]), law.values["servo_lag"]
    time = np.arange(0.0, 2 * side / speed + 1.5, 5e-4)
    start, turn, end = (response(1, time[None] - k * side / speed, window, lag)[0] for k in range(3))
    x, y = speed * (start - turn), speed * (turn - end)
    begin = np.interp(THRESHOLD, x + 0.5 * y, time)
    done = np.interp(-stop, -((side - y) + 0.5 * (side - x)), time)
    assert done - begin == pytest.approx(float(row["total_s"]), rel=0.01)


def chain_of(spacing: float, alone: float) -> np.ndarray:
    """Intervals [s] of 49 lines of `spacing` [m] at 10 mm/s, each zone the half of a line."""
    lengths, speeds = np.full(49, spacing), np.full(49, 0.01)
    out = np.full(49, spacing / 2)
    out[-1] = 0.0
    return intervals(lengths, speeds, np.insert(out[:-1], 0, 0.0), out, speeds, alone)


def test_dense_points_run_alone_for_half_an_acceleration_time():
    """49 lines of 2.04 mm: the first interval was 0.105 s, the others 0.167 s; overlap alone would be 8 % faster."""
    law = load_law("yaskawa")
    gaps = chain_of(0.1 / 49, law.alone)
    assert gaps[0] == pytest.approx(0.105, abs=0.005)
    assert gaps[1:-1].mean() == pytest.approx(0.167, abs=0.003)
    assert chain_of(0.1 / 49, 0.0)[1:-1].mean() < 0.92 * 0.167


def test_points_far_apart_never_wait_and_very_dense_ones_gain_nothing_and_lose_nothing():
    law = load_law("yaskawa")
    assert np.array_equal(chain_of(0.02, law.alone), chain_of(0.02, 0.0))
    assert chain_of(0.0002, law.alone)[1:-1].mean() == pytest.approx(0.02, rel=0.02)
