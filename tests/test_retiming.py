"""Retiming: closed forms, an independent solver, and limits that hold between the samples too."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from olp.core.diagnostic import OlpError
from olp.timing.motion import load_model
from olp.timing.retiming import Further, LimitKind, SampledPath, retime, spline_through

COMPILED = pytest.mark.parametrize("compiled", [False, True])
PLACE = np.linspace(0.0, 1.0, 25)
SPEED, RATE = np.array([3.4, 3.1, 4.0, 7.0, 6.8, 12.0]), np.array([11.0, 9.0, 13.0, 25.0, 22.0, 40.0])


def joints(seed: int, wild: bool = False) -> np.ndarray:
    """(25, 6) [rad]: smooth, or one random point after the other."""
    rng = np.random.default_rng(seed)
    if wild:
        return rng.normal(size=(25, 6))
    u = 2 * np.pi * PLACE[:, None]
    return sum(
        rng.normal(size=6) * np.sin((j + 1) * u / 2 + rng.uniform(0, 6, 6)) / (j + 1) for j in range(3)
    )


def worst(points: np.ndarray, run, speed=SPEED, rate=RATE) -> float:
    """The largest share of a limit that is used anywhere: the true spline at twelve places of every interval."""
    squares, part = run.speed**2, np.linspace(0, 1, 12)[None, :]
    at = run.place[:-1, None] * (1 - part) + run.place[1:, None] * part
    x = (squares[:-1, None] * (1 - part) + squares[1:, None] * part).reshape(-1, 1)
    u = np.repeat(np.diff(squares) / 2 / np.diff(run.place), 12)[:, None]
    curve = CubicSpline(PLACE, points)
    first, second = curve(at.ravel(), 1), curve(at.ravel(), 2)
    return max(
        (np.abs(first * u + second * x) / rate).max(), (np.abs(first) * np.sqrt(x.clip(0)) / speed).max()
    )


@pytest.mark.parametrize("count", [2, 3, 4, 5, 40])
def test_the_spline_is_the_one_of_an_independent_library(count):
    rng = np.random.default_rng(count)
    s, points = np.cumsum(rng.uniform(0.1, 2.0, count)), rng.normal(size=(count, 3))
    at = rng.uniform(s[0], s[-1], 200)
    other = CubicSpline(s, points)
    for order, ours in enumerate(spline_through(s, points)(at)):
        assert ours == pytest.approx(other(at, order), abs=1e-9)


@COMPILED
@pytest.mark.parametrize(("start", "end"), [(0.0, 0.0), (0.3, 0.1), (0.1, 0.3)])
def test_a_straight_way_is_the_trapezoid_of_constant_acceleration(compiled, start, end):
    path = SampledPath.through(np.linspace(0, 0.8, 5), np.linspace(0, 0.8, 5)[:, None] * 2.0, 400)
    run = retime(path, [0.9], [3.0], start_speed=start, end_speed=end, compiled=compiled)
    expected = load_model("constant").profile(1.6, 0.9, 3.0, 3.0, 2 * start, 2 * end).duration[0]
    assert run.duration == pytest.approx(expected, rel=1e-4)
    assert {run.names[i] for i in np.unique(run.limiter)} == {
        (0, LimitKind.SPEED),
        (0, LimitKind.ACCELERATION),
    }


@COMPILED
def test_programmed_speed_and_acceleration_of_the_tool_make_the_same_trapezoid(compiled):
    path = SampledPath.through(np.linspace(0, 0.8, 5), np.linspace(0, 0.8, 5)[:, None], 400)
    run = retime(path, [9.0], [90.0], path_speed=0.25, path_acceleration=1.7, compiled=compiled)
    assert run.duration == pytest.approx(load_model("constant").profile(0.8, 0.25, 1.7).duration[0], rel=1e-4)
    kinds = [run.names[i].kind for i in run.limiter]
    assert kinds[0] == kinds[-1] == LimitKind.PATH_ACCELERATION
    assert kinds[len(kinds) // 2] == LimitKind.PATH_SPEED


def test_a_circle_of_two_axes_is_run_at_the_speed_of_its_centripetal_acceleration():
    angle = np.linspace(0, 4 * np.pi, 801)
    path = SampledPath(
        angle,
        np.stack((-np.sin(angle), np.cos(angle)), axis=1),
        np.stack((-np.cos(angle), -np.sin(angle)), axis=1),
    )
    run = retime(path, [50.0, 50.0], [4.0, 4.0], compiled=False)
    # Where an axis turns round, its whole acceleration is centripetal; in between the two share it.
    assert run.speed[200:700:100] == pytest.approx(2.0, rel=1e-3)
    assert 2.1 < run.speed.max() < np.sqrt(4.0 * np.sqrt(2.0))


@COMPILED
@pytest.mark.parametrize("seed", range(6))
def test_it_is_as_fast_as_an_independent_solver_on_the_same_samples(compiled, seed):
    import toppra
    import toppra.algorithm
    import toppra.constraint as limits

    toppra.setup_logging("ERROR")
    points = joints(seed, wild=seed % 2 == 1)
    path = SampledPath.through(PLACE, points, 80)
    kind = limits.DiscretizationType.Interpolation
    both = [
        limits.JointVelocityConstraint(np.stack([-SPEED, SPEED], 1)),
        limits.JointAccelerationConstraint(np.stack([-RATE, RATE], 1), discretization_scheme=kind),
    ]
    curve = toppra.SplineInterpolator(PLACE, points)
    solver = toppra.algorithm.TOPPRA(both, curve, gridpoints=path.place, solver_wrapper="seidel")
    _, other, _ = solver.compute_parameterization(0.0, 0.0)
    expected = np.sum(2 * np.diff(path.place) / (other[1:] + other[:-1]))
    run = retime(path, SPEED, RATE, compiled=compiled)
    assert run.duration == pytest.approx(expected, rel=1e-3)


@COMPILED
@pytest.mark.parametrize("wild", [False, True])
@pytest.mark.parametrize("pieces", [10, 60])
def test_no_limit_is_exceeded_anywhere_not_even_between_the_samples(compiled, wild, pieces):
    for seed in range(4):
        points = joints(seed, wild)
        run = retime(SampledPath.through(PLACE, points, pieces), SPEED, RATE, compiled=compiled)
        assert worst(points, run) <= 1 + 1e-6
        assert run.excess <= 1e-6


def test_something_rules_nearly_everywhere_or_it_would_not_be_the_fastest():
    run = retime(SampledPath.through(PLACE, joints(3), 60), SPEED, RATE)
    assert np.mean(run.usage > 0.97) > 0.95


def test_many_paths_at_once_are_the_same_as_one_by_one_in_numpy_and_compiled():
    points = np.stack([joints(seed, seed % 3 == 0) for seed in range(7)])
    path = SampledPath.through(PLACE, points, 20)
    plain = retime(path, SPEED, RATE, path_speed=0.9, compiled=False)
    quick = retime(path, SPEED, RATE, path_speed=0.9, compiled=True)
    assert quick.duration == pytest.approx(plain.duration, rel=1e-9)
    assert quick.speed == pytest.approx(plain.speed, abs=1e-6)
    for i in range(7):
        alone = retime(SampledPath.through(PLACE, points[i], 20), SPEED, RATE, path_speed=0.9, compiled=False)
        assert alone.duration == pytest.approx(plain.duration[i], rel=1e-12)
        assert alone.speed.shape == alone.place.shape == (481,)


def test_limits_in_another_unit_of_time_scale_the_duration():
    path = SampledPath.through(PLACE, joints(2), 20)
    slow, fast = (retime(path, SPEED * f, RATE * f * f).duration for f in (1.0, 3.0))
    assert slow == pytest.approx(3.0 * fast, rel=1e-9)


def test_the_way_back_takes_as_long_and_lower_limits_never_less():
    points = joints(4)
    there, back = (
        retime(SampledPath.through(PLACE, p, 40), SPEED, RATE).duration for p in (points, points[::-1])
    )
    assert back == pytest.approx(there, rel=2e-3)
    path = SampledPath.through(PLACE, points, 20)
    times = [retime(path, SPEED, RATE * f).duration for f in (1.0, 0.7, 0.4)]
    times += [retime(path, SPEED * 0.5, RATE * 0.4).duration]
    assert (np.diff(times) >= -1e-12).all()


def test_limits_may_change_along_the_path():
    path = SampledPath.through(np.linspace(0, 1, 5), np.linspace(0, 1, 5)[:, None], 100)
    speed = np.where(path.place < 0.5, 1.0, 0.25)[:, None]
    run = retime(path, speed, [50.0])
    assert (run.speed <= speed[:, 0] + 1e-12).all()
    assert run.duration == pytest.approx(0.5 / 1.0 + 0.5 / 0.25, rel=0.05)


@COMPILED
def test_a_motor_that_lifts_a_mass_brakes_harder_than_it_accelerates(compiled):
    place = np.linspace(0, 1, 401)
    one = np.ones((401, 1))
    path = SampledPath(place, one, 0 * one)
    weight = Further(p=one, r=0 * one, low=-3.0 * one, high=1.0 * one)  # torque less gravity, mass 1
    run = retime(path, [90.0], [99.0], further=weight, compiled=compiled)
    expected = load_model("constant").profile(1.0, 90.0, 1.0, 3.0).duration[0]
    assert run.duration == pytest.approx(expected, rel=1e-4)
    assert run.names[run.limiter[0]].kind is LimitKind.FURTHER


def test_an_end_that_cannot_be_had_becomes_the_nearest_one_that_can():
    path = SampledPath.through(np.linspace(0, 0.1, 5), np.linspace(0, 0.1, 5)[:, None], 200)
    run = retime(path, [2.0], [1.0], start_speed=1.5)
    assert run.speed[0] == pytest.approx(np.sqrt(2 * 1.0 * 0.1), rel=1e-6)
    run = retime(path, [2.0], [1.0], end_speed=1.5)
    assert run.speed[-1] == pytest.approx(np.sqrt(2 * 1.0 * 0.1), rel=1e-6)


def test_a_start_speed_that_is_possible_is_kept():
    path = SampledPath.through(PLACE, joints(5), 40)
    run = retime(path, SPEED, RATE, start_speed=0.05, end_speed=0.07)
    assert run.speed[[0, -1]] == pytest.approx([0.05, 0.07])


def test_an_axis_that_stands_still_limits_nothing():
    path = SampledPath.through(np.linspace(0, 1, 5), np.linspace(0, 1, 5)[:, None] * [1.0, 0.0], 50)
    alone = SampledPath.through(np.linspace(0, 1, 5), np.linspace(0, 1, 5)[:, None], 50)
    both = retime(path, [1.0, 1e-6], [4.0, 1e-6])
    assert both.duration == pytest.approx(retime(alone, [1.0], [4.0]).duration)


@pytest.mark.parametrize(
    "bad",
    [
        {"speed": [0.0]},
        {"acceleration": [-1.0]},
        {"path_speed": 0.0},
        {"path_acceleration": np.nan},
        {"start_speed": -0.1},
        {"end_speed": np.nan},
        {"speed": [1.0, 2.0]},
    ],
)
def test_impossible_limits_are_refused(bad):
    path = SampledPath.through(np.linspace(0, 1, 5), np.linspace(0, 1, 5)[:, None], 5)
    with pytest.raises(OlpError) as caught:
        retime(path, **({"speed": [1.0], "acceleration": [1.0]} | bad))
    assert caught.value.diagnostics[0].code == "L002"


@pytest.mark.parametrize("place", [[0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.5]])
def test_places_that_do_not_increase_are_refused(place):
    with pytest.raises(OlpError) as caught:
        SampledPath.through(place, np.zeros((len(place), 2)))
    assert caught.value.diagnostics[0].code == "L001"


@pytest.mark.filterwarnings("error")
def test_an_axis_that_moves_by_less_than_any_number_counts_stands():
    """Rounding leaves ways of 1e-310 in real programs: their reciprocals are no numbers."""
    places = np.linspace(0.0, 1.0, 9)
    ways = [np.stack((places, still * np.sin(9.0 * places)), axis=1) for still in (0.0, 1e-310)]
    times = [retime(SampledPath.through(places, way, 200), [1.0, 1.0], [2.0, 2.0]).duration for way in ways]
    assert times[1] == times[0]
