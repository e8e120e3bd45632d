"""Constant acceleration against the textbook, an independent solver, and hand-made cases."""

from __future__ import annotations

import numpy as np
import pytest
import ruckig

from olp.timing.motion import load_model

MODEL = load_model("constant")


def ruckig_time(length: float, speed: float, a: float, d: float, v0: float, v1: float) -> tuple[float, float]:
    """Duration [s] of the time-optimal motion without a jerk limit, and the lowest speed on the way [m/s]."""
    task = ruckig.InputParameter(1)
    task.current_position, task.current_velocity = [0.0], [v0]
    task.target_position, task.target_velocity = [length], [v1]
    task.max_velocity, task.max_acceleration, task.min_acceleration = [speed], [a], [-d]
    task.max_jerk = [float("inf")]
    trajectory = ruckig.Trajectory(1)
    result = ruckig.Ruckig(1).calculate(task, trajectory)
    assert result in (ruckig.Result.Working, ruckig.Result.Finished)
    span = np.linspace(0, trajectory.duration, 200)
    return trajectory.duration, min(trajectory.at_time(t)[1][0] for t in span)


def test_a_trapezoid_takes_length_over_speed_plus_speed_over_acceleration() -> None:
    profile = MODEL.profile(0.64, 0.3, 0.4)
    assert profile.duration == pytest.approx(0.64 / 0.3 + 0.3 / 0.4, rel=1e-14)
    assert profile.durations[0] == pytest.approx([0.75, (0.64 - 0.225) / 0.3, 0.75])


def test_a_triangle_takes_twice_the_root_of_length_over_acceleration() -> None:
    profile = MODEL.profile(0.1, 0.3, 0.4)
    assert profile.duration == pytest.approx(2 * np.sqrt(0.1 / 0.4))
    assert profile.peak_speed == pytest.approx(np.sqrt(0.4 * 0.1))
    assert profile.durations[0, 1] == 0.0


def test_trapezoid_and_triangle_meet_where_the_cruise_vanishes() -> None:
    length = 0.3**2 / 0.4
    profile = MODEL.profile([length * (1 - 1e-9), length, length * (1 + 1e-9)], 0.3, 0.4)
    assert profile.duration == pytest.approx(1.5, abs=1e-8)
    assert profile.reached.tolist()[1:] == [True, True]


def test_it_agrees_with_an_independent_solver_also_between_speeds_other_than_zero() -> None:
    rng = np.random.default_rng(7)
    n = 300
    speed = rng.uniform(0.05, 2.0, n)
    a, d = rng.uniform(0.2, 6.0, (2, n))
    v0, v1 = speed * rng.uniform(0, 1, (2, n)) * (rng.random((2, n)) < 0.7)
    length = 10 ** rng.uniform(-3, 0.7, n)
    profile = MODEL.profile(length, speed, a, d, v0, v1)
    compared = 0
    for i in np.flatnonzero(profile.feasible):
        expected, slowest = ruckig_time(length[i], speed[i], a[i], d[i], v0[i], v1[i])
        assert slowest > -1e-9
        assert profile.duration[i] == pytest.approx(expected, rel=1e-9)
        compared += 1
    assert compared > 150
    for i in np.flatnonzero(~profile.feasible):
        # The solver has no monotone way either: it has to swing back, or is asked for the impossible.
        needed = abs(v1[i] ** 2 - v0[i] ** 2) / (2 * (d[i] if v1[i] < v0[i] else a[i]))
        assert needed > length[i]


def test_braking_as_hard_as_possible_is_what_remains_when_the_way_is_too_short() -> None:
    profile = MODEL.profile(0.1, 1.0, 2.0, 3.0, 1.0, 0.0)
    assert profile.end_speed == pytest.approx(np.sqrt(1.0 - 2 * 3.0 * 0.1))
    assert profile.durations[0, :2].tolist() == [0.0, 0.0]
