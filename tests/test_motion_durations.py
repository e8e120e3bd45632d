"""Durations alone against whole profiles, an independent solver, and themselves in compiled form."""

from __future__ import annotations

import numpy as np
import pytest
import ruckig

from olp.core.diagnostic import OlpError
from olp.timing.motion import durations, load_model

COMPILED = pytest.mark.parametrize("compiled", [False, True])
RNG = np.random.default_rng(31)
LENGTH = 10 ** RNG.uniform(-4, 1, (900, 6))
LIMITS = tuple(10 ** RNG.uniform(*bounds, 6) for bounds in [(-1, 1), (-0.5, 1.5), (0, 2), (0, 2)])


def slowest_profile(length, speed, acceleration, k1, k2):
    columns = (np.broadcast_to(c, length.shape).ravel() for c in (length, speed, acceleration, k1, k2))
    length_, speed_, acceleration_, k1_, k2_ = columns
    profile = load_model("linear").profile(length_, speed_, acceleration_, k1=k1_, k2=k2_)
    return profile.duration.reshape(length.shape).max(axis=1)


@COMPILED
def test_with_one_set_of_limits_they_are_those_of_the_slowest_profile(compiled):
    assert durations(LENGTH, *LIMITS, compiled=compiled) == pytest.approx(
        slowest_profile(LENGTH, *LIMITS), rel=1e-12
    )


@COMPILED
def test_with_limits_of_each_move_they_are_those_of_the_slowest_profile(compiled):
    limits = tuple(limit * RNG.uniform(0.1, 1, LENGTH.shape) for limit in LIMITS)
    assert durations(LENGTH, *limits, compiled=compiled) == pytest.approx(
        slowest_profile(LENGTH, *limits), rel=1e-12
    )


@COMPILED
def test_they_agree_with_an_independent_solver_of_six_axes(compiled):
    speed, acceleration, jerk = LIMITS[:3]
    task, answer = ruckig.InputParameter(6), ruckig.Trajectory(6)
    task.current_position = [0.0] * 6
    task.max_velocity, task.max_acceleration, task.max_jerk = (limit.tolist() for limit in LIMITS[:3])
    expected = []
    for target in LENGTH[:200].tolist():
        task.target_position = target
        ruckig.Ruckig(6).calculate(task, answer)
        expected.append(answer.duration)
    found = durations(LENGTH[:200], speed, acceleration, jerk, compiled=compiled)
    assert found == pytest.approx(expected, rel=1e-12)


@COMPILED
def test_every_case_of_the_law_occurs_and_the_pieces_meet(compiled):
    speed, rate = 1.0, 4.0
    for k1, k2 in ((100.0, 25.0), (25.0, 100.0), (3.0, 2.0)):
        length = np.linspace(1e-6, 1.5, 4001)[:, None]
        time = durations(length, speed, rate, k1, k2, compiled=compiled)
        steps = np.diff(time)
        assert (steps > 0).all()
        assert (steps[1:-1] < 1.01 * np.maximum(steps[:-2], steps[2:])).all()  # no gap between two pieces
        assert steps[-1] == pytest.approx(1.5 / 4000 / speed, rel=1e-3)


@COMPILED
def test_direction_does_not_matter_and_nothing_takes_no_time(compiled):
    length = np.array([[0.3, -0.7], [-0.3, 0.7], [0.0, 0.0]])
    time = durations(length, 0.5, 2.0, 20.0, compiled=compiled)
    assert time[0] == time[1] > 0.0
    assert time[2] == 0.0


def test_bad_numbers_are_named_all_at_once():
    with pytest.raises(OlpError) as caught:
        durations([[1.0, np.nan]], [0.5, 0.0], [1.0, 1.0, 1.0], 3.0)
    assert [d.message.split()[0] for d in caught.value.diagnostics] == ["length", "speed", "acceleration"]
    with pytest.raises(OlpError, match="moves, axes"):
        durations([1.0], 0.5, 1.0, 3.0)
