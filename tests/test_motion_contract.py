"""Promises of every motion model, run over all models found in the folder."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import olp.motion
from olp.diagnostic import OlpError
from olp.motion import MotionModel, Problem, Profile, load_model, model_names

MODELS = model_names()
every_model = pytest.mark.parametrize("model", [load_model(n) for n in MODELS], ids=MODELS)

lengths = st.floats(1e-4, 20.0)
speeds = st.floats(1e-2, 5.0)
limits = st.floats(1e-1, 20.0)
fractions = st.floats(0.0, 1.0)


def random_moves(seed: int, n: int = 400) -> dict[str, np.ndarray]:
    """Moves of all kinds: long and short, braking and gaining speed, possible and impossible."""
    rng = np.random.default_rng(seed)
    speed = 10 ** rng.uniform(-2, 0.5, n)
    return {
        "length": 10 ** rng.uniform(-4, 1, n),
        "speed": speed,
        "acceleration": 10 ** rng.uniform(-1, 1, n),
        "deceleration": 10 ** rng.uniform(-1, 1, n),
        "start_speed": speed * rng.uniform(0, 1.4, n) * (rng.random(n) < 0.7),
        "end_speed": speed * rng.uniform(0, 1.4, n) * (rng.random(n) < 0.7),
    }


def driven_in_small_steps(profile: Profile, steps: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    """Distance and speed gained when only the acceleration is known, added up in small steps."""
    dt = profile.duration / steps
    instants = (np.arange(steps) + 0.5)[None, :] * dt[:, None]
    a = profile.acceleration(instants)
    v = profile.moves.start_speed[:, None] + np.cumsum(a, axis=1) * dt[:, None]
    return ((v - a * dt[:, None] / 2).sum(axis=1)) * dt, v[:, -1]


def test_the_folder_is_the_list_of_models() -> None:
    folder = Path(olp.motion.__file__).parent
    files = {f.stem for f in folder.glob("*.py") if not f.stem.startswith("_")} - {"model"}
    assert set(MODELS) == files >= {"constant", "linear"}


def test_an_unknown_model_is_answered_with_the_models_there_are() -> None:
    with pytest.raises(OlpError) as caught:
        load_model("quadratic")
    assert "constant, linear" in caught.value.diagnostics[0].help


@every_model
def test_a_model_says_what_it_is_and_where_it_comes_from(model: MotionModel) -> None:
    assert model.name in MODELS
    assert model.summary
    assert model.source
    assert all(p.unit and p.source for p in model.parameters)


@every_model
def test_driving_the_acceleration_in_small_steps_arrives_at_the_target(model: MotionModel) -> None:
    profile = model.profile(**random_moves(1))
    distance, speed = driven_in_small_steps(profile)
    moves = profile.moves
    # A step of the acceleration is seen at most one small step too early or too late.
    coarse = (
        len(profile.phases) * np.maximum(moves.acceleration, moves.deceleration) * profile.duration / 4000
    )
    assert (np.abs(speed - profile.end_speed) <= coarse).all()
    assert (np.abs(distance - moves.length) <= coarse * profile.duration).all()
    assert np.median(np.abs(distance - moves.length) / moves.length) < 2e-4


@every_model
def test_no_mixture_of_very_large_and_very_small_numbers_misses_its_target(model: MotionModel) -> None:
    rng = np.random.default_rng(9)
    length, speed, a, d, k1, k2 = 10 ** rng.uniform(-6, 6, (6, 5000))
    v0, v1 = speed * rng.choice([0, 0, 1e-9, 0.3, 1, 1, 1.3], (2, 5000))
    rates = dict(zip([p.name for p in model.parameters if p.name.startswith("k")], (k1, k2), strict=False))
    # The model checks itself and raises when a profile misses its target by 1e-9 of its length.
    assert model.profile(length, speed, a, **rates).feasible.all()
    assert 0.1 < model.profile(length, speed, a, d, v0, v1, **rates).feasible.mean() < 0.9


@every_model
def test_speed_and_acceleration_are_the_derivatives_of_the_position(model: MotionModel) -> None:
    profile = model.profile(**random_moves(2, 60))
    t = np.linspace(0.03, 0.97, 40)[None, :] * profile.duration[:, None]
    h = 1e-6 * profile.duration[:, None]
    slope = (profile.position(t + h) - profile.position(t - h)) / (2 * h)
    assert np.max(np.abs(slope - profile.speed(t)) / profile.peak_speed[:, None]) < 1e-4
    rate = (profile.speed(t + h) - profile.speed(t - h)) / (2 * h)
    # Where an instant falls on a step of the acceleration the difference quotient averages both sides.
    steep = np.maximum(profile.moves.acceleration, profile.moves.deceleration)[:, None]
    assert np.mean(np.abs(rate - profile.acceleration(t)) / steep < 1e-3) > 0.99


@every_model
def test_no_limit_is_broken_at_any_instant(model: MotionModel) -> None:
    profile = model.profile(**random_moves(3))
    t = np.linspace(0, 1, 301)[None, :] * profile.duration[:, None]
    m, v, a = profile.moves, profile.speed(t), profile.acceleration(t)
    assert (v <= np.maximum(m.speed, m.start_speed)[:, None] * (1 + 1e-12)).all()
    assert (v >= -1e-12).all()
    assert (a <= m.acceleration[:, None] * (1 + 1e-12)).all()
    assert (a >= -m.deceleration[:, None] * (1 + 1e-12)).all()
    assert (profile.durations >= 0).all()


@every_model
def test_the_time_at_a_position_is_the_inverse_of_the_position(model: MotionModel) -> None:
    profile = model.profile(**random_moves(4, 80))
    s = np.linspace(0, 1, 23)[None, :] * profile.moves.length[:, None]
    assert np.allclose(profile.position(profile.time_at(s)), s, rtol=1e-9, atol=1e-13)
    assert np.allclose(profile.time_at(profile.moves.length), profile.duration, rtol=1e-5)


@every_model
@settings(max_examples=60, deadline=None)
@given(length=lengths, speed=speeds, a=limits, d=limits, unit=st.sampled_from([1000.0, 25.4, 0.3048]))
def test_the_same_motion_in_another_unit_takes_the_same_time(
    model: MotionModel, length: float, speed: float, a: float, d: float, unit: float
) -> None:
    metres = model.profile(length, speed, a, d, 0.3 * speed, 0.1 * speed)
    other = model.profile(*(unit * x for x in (length, speed, a, d, 0.3 * speed, 0.1 * speed)))
    assert other.duration == pytest.approx(metres.duration, rel=1e-9)
    assert other.peak_speed == pytest.approx(unit * metres.peak_speed, rel=1e-9)


@every_model
@settings(max_examples=60, deadline=None)
@given(length=lengths, more=st.floats(1.0001, 3.0), speed=speeds, a=limits, d=limits)
def test_a_longer_way_takes_longer_and_never_less_than_length_over_speed(
    model: MotionModel, length: float, more: float, speed: float, a: float, d: float
) -> None:
    profile = model.profile([length, length * more], speed, a, d)
    assert profile.duration[1] > profile.duration[0]
    assert (profile.duration >= profile.moves.length / speed).all()


@every_model
@settings(max_examples=60, deadline=None)
@given(length=lengths, speed=speeds, a=limits, d=limits, v0=fractions, v1=fractions)
def test_a_move_seen_backwards_in_time_takes_as_long(
    model: MotionModel, length: float, speed: float, a: float, d: float, v0: float, v1: float
) -> None:
    ramp = {p.name: 30.0 for p in model.parameters if p.name.startswith("k")}
    there = model.profile(length, speed, a, d, v0 * speed, v1 * speed, **ramp)
    back = model.profile(length, speed, d, a, v1 * speed, v0 * speed, **ramp)
    if there.feasible.all() and back.feasible.all():
        assert back.duration == pytest.approx(there.duration, rel=1e-7)


@every_model
def test_a_longer_way_cut_in_two_at_any_point_takes_no_less_than_the_whole(model: MotionModel) -> None:
    whole = model.profile(1.7, 0.6, 2.1)
    cut = np.linspace(0.05, 1.65, 9)
    there, on = model.profile(cut, 0.6, 2.1), model.profile(1.7 - cut, 0.6, 2.1)
    assert (there.duration + on.duration > whole.duration + 0.1).all()


@every_model
def test_faster_limits_never_make_a_move_slower(model: MotionModel) -> None:
    ramp = {p.name: 30.0 for p in model.parameters if p.name.startswith("k")}
    speeds = np.linspace(0.05, 3.0, 200)
    assert (np.diff(model.profile(0.8, speeds, 2.0, 3.0, **ramp).duration) <= 1e-12).all()
    assert (np.diff(model.profile(0.8, 1.1, 4 * speeds, 3.0, **ramp).duration) <= 1e-12).all()


@every_model
def test_a_move_of_no_length_takes_no_time(model: MotionModel) -> None:
    profile = model.profile([0.0, 0.0], [0.4, 0.0], 2.0)
    assert profile.duration.tolist() == [0.0, 0.0]
    assert profile.feasible.all()
    assert profile.position(1.0).tolist() == [0.0, 0.0]


@every_model
def test_a_move_without_speed_never_ends_and_says_so(model: MotionModel) -> None:
    profile = model.profile([0.5, 0.5, 0.5], [0.0, 0.2, 0.2], [1.0, 0.0, 1.0])
    assert profile.problem.tolist() == [Problem.NO_SPEED, Problem.NO_SPEED, Problem.NONE]
    assert np.isinf(profile.duration).tolist() == [True, True, False]
    assert not profile.reached[:2].any()
    assert profile.position(3.0)[:2].tolist() == [0.0, 0.0]
    assert "never ends" in Problem.NO_SPEED.says


@every_model
def test_an_end_speed_out_of_reach_becomes_the_nearest_one_and_says_so(model: MotionModel) -> None:
    profile = model.profile(0.02, 0.9, 1.0, 1.0, [0.8, 0.1, 0.3], [0.1, 0.8, 0.3])
    assert profile.problem.tolist() == [Problem.CANNOT_BRAKE, Problem.CANNOT_REACH, Problem.NONE]
    assert 0.1 < profile.end_speed[0] < 0.8
    assert 0.1 < profile.end_speed[1] < 0.8
    assert profile.end_speed[2] == pytest.approx(0.3)
    assert profile.positions[:, -1] == pytest.approx(0.02)


@every_model
def test_a_move_that_starts_too_fast_brakes_to_its_programmed_speed(model: MotionModel) -> None:
    profile = model.profile(2.0, 0.3, 1.5, 2.5, 0.7, 0.2)
    assert profile.feasible.all()
    assert profile.peak_speed == pytest.approx(0.7)
    assert profile.speed(profile.time_at(1.5)) == pytest.approx(0.3)


@every_model
def test_reached_says_whether_the_programmed_speed_was_reached(model: MotionModel) -> None:
    profile = model.profile([2.0, 0.01], 0.5, 2.0)
    assert profile.reached.tolist() == [True, False]
    assert profile.peak_speed[0] == pytest.approx(0.5)
    assert profile.peak_speed[1] < 0.5


@every_model
@pytest.mark.parametrize("bad", [-1.0, np.nan, np.inf])
def test_impossible_numbers_are_named_all_at_once(model: MotionModel, bad: float) -> None:
    with pytest.raises(OlpError) as caught:
        model.profile([1.0, bad], 0.5, [bad, 1.0])
    assert [d.message.split()[0] for d in caught.value.diagnostics] == ["length", "acceleration"]


@every_model
def test_a_parameter_the_model_does_not_know_is_refused(model: MotionModel) -> None:
    with pytest.raises(OlpError, match="no parameter 'snap'"):
        model.profile(1.0, 0.5, 2.0, snap=4.0)


@every_model
def test_the_check_finds_a_profile_that_misses_its_target(model: MotionModel) -> None:
    good = model.profile([0.5, 0.7], 0.4, 2.0)
    for what, spoil in [("durations", 1.001), ("accelerations", 1.001)]:
        changed = getattr(good, what).copy()
        changed[1, :] *= spoil
        parts = {"durations": good.durations, "accelerations": good.accelerations, what: changed}
        bad = Profile.build(good.moves, good.phases, jerks=good.jerks, problem=good.problem, **parts)
        assert bad.defects().tolist() == [False, True]
