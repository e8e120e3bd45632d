"""Linear acceleration against an independent solver, small steps, and the equations of the thesis."""

from __future__ import annotations

import numpy as np
import pytest
import ruckig

from olp.timing.motion import load_model

MODEL = load_model("linear")


def ruckig_time(length: float, speed: float, a: float, jerk: float, v0: float, v1: float) -> float:
    """Duration [s] of the time-optimal motion with a symmetric jerk limit."""
    task = ruckig.InputParameter(1)
    task.current_position, task.current_velocity = [0.0], [v0]
    task.target_position, task.target_velocity = [length], [v1]
    task.max_velocity, task.max_acceleration, task.max_jerk = [speed], [a], [jerk]
    trajectory = ruckig.Trajectory(1)
    result = ruckig.Ruckig(1).calculate(task, trajectory)
    assert result in (ruckig.Result.Working, ruckig.Result.Finished)
    return trajectory.duration


def ruckig_moves(n: int) -> tuple[np.ndarray, ...]:
    rng = np.random.default_rng(11)
    return tuple(10 ** rng.uniform(*bounds, n) for bounds in [(-3, 0.7), (-2, 0.5), (-0.7, 0.8), (-0.5, 2)])


def test_from_rest_to_rest_it_agrees_with_an_independent_solver() -> None:
    length, speed, a, jerk = ruckig_moves(400)
    profile = MODEL.profile(length, speed, a, k1=jerk, k2=jerk)
    expected = [ruckig_time(*row, 0.0, 0.0) for row in zip(length, speed, a, jerk, strict=True)]
    assert profile.duration == pytest.approx(expected, rel=1e-9)
    shapes = (profile.durations > 1e-12)[:, [1, 3]]
    # All four shapes occurred: with and without constant acceleration, with and without cruise.
    assert len(np.unique(shapes, axis=0)) == 4


def test_between_speeds_other_than_zero_it_agrees_with_an_independent_solver() -> None:
    length, speed, a, jerk = ruckig_moves(400)
    rng = np.random.default_rng(12)
    v0, v1 = speed * rng.uniform(0, 1, (2, 400))
    profile = MODEL.profile(length, speed, a, a, v0, v1, k1=jerk, k2=jerk)
    possible = np.flatnonzero(profile.feasible)
    assert len(possible) > 100
    expected = [ruckig_time(length[i], speed[i], a[i], jerk[i], v0[i], v1[i]) for i in possible]
    assert profile.duration[possible] == pytest.approx(expected, rel=1e-12)


def test_closed_form_and_bracketing_give_the_same_for_any_pair_of_rates() -> None:
    rng = np.random.default_rng(13)
    length, speed, a = ruckig_moves(300)[:3]
    k1, k2 = 10 ** rng.uniform(-0.5, 2, (2, 300))
    closed = MODEL.profile(length, speed, a, k1=k1, k2=k2)
    bracketed = MODEL.profile(length, speed, a, a * (1 + 1e-13), k1=k1, k2=k2)
    assert closed.duration == pytest.approx(bracketed.duration, rel=1e-9)
    assert closed.peak_speed == pytest.approx(bracketed.peak_speed, rel=1e-9)


def test_the_deceleration_is_the_acceleration_seen_backwards_in_time() -> None:
    profile = MODEL.profile([0.9, 0.2, 0.01, 0.9], [0.4, 2.0, 2.0, 0.05], 1.7, k1=5.0, k2=19.0)
    assert profile.durations[:, :3] == pytest.approx(profile.durations[:, :3:-1])
    t = np.linspace(0, 1, 50)[None, :] * profile.duration[:, None]
    back = profile.moves.length[:, None] - profile.position(profile.duration[:, None] - t)
    assert back == pytest.approx(profile.position(t), abs=1e-12)


def test_the_acceleration_has_no_steps() -> None:
    profile = MODEL.profile([0.9, 0.2, 0.01, 0.9], [0.4, 2.0, 2.0, 0.05], 1.7, 2.3, k1=5.0, k2=19.0)
    t = np.linspace(0, 1, 20001)[None, :] * profile.duration[:, None]
    step = np.abs(np.diff(profile.acceleration(t), axis=1)).max(axis=1)
    assert (step <= 19.0 * profile.duration / 20000 * (1 + 1e-9)).all()


def test_an_unlimited_rate_is_constant_acceleration() -> None:
    length, speed, a, _ = ruckig_moves(50)
    linear = MODEL.profile(length, speed, a, 2 * a, k1=1e9, k2=1e9)
    constant = load_model("constant").profile(length, speed, a, 2 * a)
    assert linear.duration == pytest.approx(constant.duration, rel=1e-6)


def test_the_default_rate_builds_the_acceleration_up_in_the_stated_time() -> None:
    profile = MODEL.profile(3.0, 1.0, 2.0)
    assert profile.durations[0, [0, 2]] == pytest.approx([0.12, 0.12])
    # Equal rates smooth the trapezoid by one ramp time.
    constant = load_model("constant").profile(3.0, 1.0, 2.0)
    assert profile.duration == pytest.approx(constant.duration + 0.12)
    assert MODEL.profile(3.0, 1.0, 2.0, ramp_time=0.3).durations[0, 0] == pytest.approx(0.3)


def test_no_mixture_of_extreme_numbers_and_speeds_makes_the_model_miss_its_target() -> None:
    rng = np.random.default_rng(14)
    length, speed, a, d, k1, k2 = 10 ** rng.uniform(-6, 6, (6, 40_000))
    v0, v1 = speed * rng.choice([0, 1e-9, 0.3, 1 - 1e-12, 1, 1.3], (2, 40_000))
    # A profile that, integrated, misses its length by 1e-9 raises.
    assert 0.3 < MODEL.profile(length, speed, a, d, v0, v1, k1=k1, k2=k2).feasible.mean() < 0.8


def test_start_and_end_speeds_that_hardly_differ_lose_no_digits() -> None:
    apart = 10.0 ** np.arange(-16, -3)
    v0, length, jerk = 1.0, 0.7, 50.0
    v1 = v0 + apart
    profile = MODEL.profile(length, v1, 3.0, 3.0, v0, v1, k1=jerk, k2=jerk)
    change = 2 * np.sqrt((v1 - v0) / jerk)
    assert profile.duration == pytest.approx(change + (length - (v0 + v1) / 2 * change) / v1, rel=1e-14)
