"""Blending: promises of every law, closed forms against driving the moves in small steps, and bad input."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from olp.core.diagnostic import OlpError
from olp.timing.blending import Corners, law_names, load_law

EVERY_LAW = pytest.mark.parametrize("name", law_names())
OVERLAPS = ("acceleration_filter", "fanuc", "yaskawa")
PARABOLAS = ("abb", "kuka", "ur")


def some_corners(name: str, scale: float = 1.0) -> Corners:
    """60 corners without round numbers; `scale`: the same in another unit of length."""
    rng = np.random.default_rng(7)
    n = 60
    share = name == "fanuc"
    return Corners.of(
        before=scale * rng.uniform(0.04, 0.5, n),
        after=scale * rng.uniform(0.04, 0.5, n),
        speed_before=scale * rng.uniform(0.02, 0.9, n),
        speed_after=scale * rng.uniform(0.02, 0.9, n),
        turn=rng.uniform(0.0, 3.0, n),
        amount=rng.uniform(0, 1, n) if share else scale * rng.uniform(0.001, 0.1, n),
        deceleration=scale * rng.uniform(1.0, 6.0, n),
        acceleration=scale * rng.uniform(1.0, 6.0, n),
    )


def test_each_controller_family_has_its_law():
    assert {"yaskawa", "acceleration_filter", "radius", "abb", "kuka", "fanuc", "ur"} <= set(law_names())


@EVERY_LAW
def test_a_law_says_what_it_is_what_the_number_means_and_where_it_comes_from(name):
    law = load_law(name)
    assert law.summary
    assert len(law.source) > 20
    assert law.measured or "not measured" in law.source.lower()
    assert "[" in law.amount or "share" in law.amount or "not used" in law.amount
    assert all(p.unit and p.source for p in law.parameters)


@EVERY_LAW
def test_the_time_saved_is_what_the_shape_of_the_corner_takes(name):
    """The corner's own positions, over the two speeds, hold the same time as the closed form."""
    law, corners = load_law(name), some_corners(name)
    passage = law.passage(corners)
    ends = np.stack([np.zeros(len(corners)), law.span(corners)], axis=1)
    way = law.position(corners, ends)
    moving = passage.speed_in > 0
    saved = -way[:, 0, 0] / passage.speed_in + way[:, 1, 1] / passage.speed_out - ends[:, 1]
    slack = 3e-3 * (passage.speed_in + passage.speed_out) / passage.speed_out
    assert np.all(np.abs(saved - passage.saving)[moving] < np.maximum(slack, 1e-9)[moving])
    assert np.allclose(way[:, 1, 0], 0.0, atol=3e-3)
    assert np.allclose(way[:, 0, 1], 0.0, atol=1e-12)


@EVERY_LAW
def test_positions_are_the_sum_of_the_velocities(name):
    law, corners = load_law(name), some_corners(name)
    share = np.linspace(0.0, 1.0, 1501)
    time = law.span(corners)[:, None] * share
    rate, way = law.velocity(corners, time), law.position(corners, time)
    step = np.diff(time, axis=1)[..., None]
    summed = np.sum((rate[:, 1:] + rate[:, :-1]) / 2 * step, axis=1)
    assert np.allclose(summed, way[:, -1] - way[:, 0], atol=1e-4)


@EVERY_LAW
def test_a_corner_in_millimetres_takes_the_same_time(name):
    law = load_law(name)
    metres, millimetres = (some_corners(name, scale) for scale in (1.0, 1000.0))
    one, other = law.passage(metres), law.passage(millimetres)
    assert np.allclose(one.duration, other.duration, rtol=1e-9)
    assert np.allclose(one.trim_before * 1000, other.trim_before, rtol=1e-9)
    assert np.allclose(law.distance(metres) * 1000, law.distance(millimetres), rtol=1e-6)


@EVERY_LAW
def test_a_corner_takes_no_more_than_half_of_a_move_and_says_when_it_would(name):
    law, corners = load_law(name), some_corners(name)
    passage = law.passage(corners)
    if name == "acceleration_filter":  # a linear filter has no such cap
        return
    assert np.all(passage.trim_before <= corners.before / 2 + 1e-12)
    if name not in OVERLAPS:
        assert np.all(passage.trim_after <= corners.after / 2 + 1e-12)
    if name not in ("fanuc", "radius"):
        assert np.array_equal(passage.capped, corners.amount > corners.half)
        assert passage.capped.any()
        assert not passage.capped.all()


@EVERY_LAW
def test_speeds_within_a_corner_lie_between_nothing_and_twice_the_programmed_one(name):
    law, corners = load_law(name), some_corners(name)
    slowest, fastest = law.speed_range(corners)
    assert np.all(slowest >= 0)
    assert np.all(slowest <= fastest)
    limit = corners.speed_before + corners.speed_after if name in OVERLAPS else None
    highest = limit if limit is not None else np.maximum(corners.speed_before, corners.speed_after)
    assert np.all(fastest <= highest * 1.001)


@EVERY_LAW
@pytest.mark.parametrize("turn", [0.0, 1e-9, np.pi])
def test_straight_on_and_straight_back_give_numbers(name, turn):
    law = load_law(name)
    for amount in (0.0, 0.01, 1.0):
        corners = Corners.of(0.3, 0.2, 0.25, 0.31, turn, amount, 2.0, 3.0)
        passage = law.passage(corners)
        for column in (passage.duration, passage.saving, law.distance(corners), *law.speed_range(corners)):
            assert np.isfinite(column).all()
        if turn < 1e-6:
            assert passage.speed_in[0] > 0
            assert law.distance(corners)[0] < 1e-4


@pytest.mark.slow("abb", "ur")
@EVERY_LAW
def test_five_thousand_corners_are_one_call(name):
    law = load_law(name)
    corners = Corners.of(np.full(5000, 0.3), 0.2, 0.25, 0.25, 1.1, 0.02, 2.0, 3.0)
    assert law.passage(corners).saving.shape == (5000,)
    assert np.ptp(law.distance(corners)) == 0.0


def driven(corners: Corners, law, drop, start, ramp, fall, rise, lag, time):
    """x and y of one corner, by driving both commands through a moving average and a lag in steps of 0.1 ms."""
    dt, lead = 1e-4, 0.6
    clock = np.arange(-lead, time[-1] + 0.01, dt) + dt / 2
    first = np.where(clock < drop, 1.0, 0.0)
    second = np.clip((clock - start) / ramp, 0, 1) if ramp > 0 else (clock > start).astype(float)
    places = []
    for command, window, steady in ((first, fall, 1.0), (second, rise, 0.0)):
        summed = np.concatenate([np.full(round(window / dt), steady), command]).cumsum()
        width = round(window / dt)
        average = (summed[width:] - summed[:-width]) / width
        if lag > 0:
            keep = np.exp(-dt / lag)
            out, value = np.empty_like(average), steady
            for i, command_now in enumerate(average):
                value = keep * value + (1 - keep) * command_now
                out[i] = value
            average = out
        places.append(np.interp(time, clock + dt / 2, np.cumsum(average) * dt))
    x = (places[0] - places[0][-1]) * corners.speed_before[0]
    return np.stack([x, places[1] * corners.speed_after[0]], axis=-1)


@pytest.mark.parametrize("name", OVERLAPS)
def test_overlapping_moves_are_where_driving_them_in_small_steps_takes_them(name):
    law = load_law(name)
    corners = Corners.of(0.2, 0.17, 0.11, 0.13, 1.2, 0.4 if name == "fanuc" else 0.016, 0.6, 0.9)
    overlap = law._overlap(corners)
    numbers = [float(v[0]) for v in (overlap.drop, overlap.start, overlap.ramp, overlap.fall, overlap.rise)]
    time = np.linspace(0.0, float(overlap.span[0]), 50)
    stepped = driven(corners, law, *numbers, overlap.lag, time)
    closed = law.position(corners, time[None])[0]
    closed[:, 0] -= closed[-1, 0]
    assert np.allclose(closed, stepped, atol=3e-5)


@given(st.floats(0.05, 3.0), st.floats(0.002, 0.05), st.floats(0.01, 2.0), st.sampled_from(PARABOLAS))
@settings(max_examples=40, deadline=None)
def test_a_parabola_passes_its_corner_at_half_the_zone_times_the_sine_and_keeps_the_acceleration(
    turn, zone, speed, name
):
    law = load_law(name)
    corners = Corners.of(0.3, 0.3, speed, speed, turn, zone, 3.0, 3.0)
    assert law.distance(corners)[0] == pytest.approx(zone / 2 * np.sin(turn / 2), rel=1e-3)
    span = law.span(corners)[0]
    time = np.linspace(0, span, 801)
    way = law.position(corners, time[None])[0]
    place = way[:, :1] * [1.0, 0.0] + way[:, 1:] * [np.cos(turn), np.sin(turn)]
    pull = np.linalg.norm(np.diff(place, 2, axis=0), axis=1)[10:-10] / (time[1] - time[0]) ** 2
    assert pull.max() < 3.0 * 1.02
    assert np.linalg.norm(np.diff(place, axis=0), axis=1).max() <= (time[1] - time[0]) * speed * 1.001


def test_an_arc_is_an_arc():
    turn = np.array([0.3, 1.1, 2.0, 2.7])
    corners = Corners.of(0.9, 0.8, 0.2, 0.2, turn, 0.03, np.inf, np.inf)
    law = load_law("radius")
    assert np.allclose(law.distance(corners), 0.03 * (1 / np.cos(turn / 2) - 1), rtol=1e-5)
    passage = law.passage(corners)
    assert np.allclose(passage.duration, 0.03 * turn / 0.2)
    way = law.position(corners, passage.duration[:, None] * np.linspace(0, 1, 7))
    along = passage.trim_before[:, None] + way[..., 0] + way[..., 1] * np.cos(turn)[:, None]
    across = way[..., 1] * np.sin(turn)[:, None]
    assert np.allclose(np.hypot(along, across - 0.03), 0.03, rtol=1e-9)


def test_an_arc_is_slowed_until_its_pull_is_allowed():
    corners = Corners.of(0.9, 0.8, 0.7, 0.7, 1.0, 0.03, 4.0, 2.5)
    passage = load_law("radius").passage(corners)
    assert passage.speed_in[0] == pytest.approx(np.sqrt(2.5 * 0.03))


def test_cnt_between_0_and_100_goes_from_rest_to_no_loss():
    law = load_law("fanuc")
    share = np.linspace(0.0, 1.0, 11)
    corners = Corners.of(0.3, 0.3, 0.4, 0.4, 0.0, share, 2.0, 2.0)
    assert np.allclose(law.passage(corners).saving, -(1 - share) * 0.2)
    slowest = law.speed_range(corners).slowest
    assert slowest[0] == pytest.approx(0.0, abs=1e-9)
    assert slowest[-1] == pytest.approx(0.4)
    assert np.all(np.diff(slowest) > 0)


def test_cnt_rounds_more_at_higher_speed():
    law = load_law("fanuc")
    near = law.distance(Corners.of(0.8, 0.8, [0.1, 0.2, 0.4], [0.1, 0.2, 0.4], 1.5, 1.0, 2.0, 2.0))
    assert np.all(np.diff(near) > 0)


def test_zones_of_abb_have_their_names_and_numbers():
    from olp.timing.blending.abb import ZONES, zone

    assert list(ZONES)[:4] == ["fine", "z0", "z1", "z5"]
    assert zone("Z50").tcp == pytest.approx(0.05)
    assert zone("z0").tcp == pytest.approx(0.0003)
    sizes = [z.tcp for z in ZONES.values()]
    assert sizes == sorted(sizes)
    assert all(z.orientation >= z.tcp for z in ZONES.values())
    with pytest.raises(OlpError, match=r"z7(.|\n)*z200"):
        zone("z7")


def test_criteria_of_kuka_become_one_distance():
    from olp.runtime.recorder import from_angle, from_share, from_speed

    assert from_share(0.5, 0.4) == pytest.approx(0.1)
    assert from_angle(0.2, 0.8, 0.4) == pytest.approx(0.1)
    assert from_angle(0.9, 0.8, 0.4) == pytest.approx(0.4)
    # Braking from 0.5 m/s at 2 m/s²: what is left when 60 % of the speed is.
    assert from_speed(0.6, 0.5, 2.0) == pytest.approx(0.5**2 / 4 - (0.5**2 - 0.3**2) / 4)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"speed_before": 0.0}, "speed_before = 0.0"),
        ({"before": -1.0}, "before = -1.0"),
        ({"amount": np.nan}, "amount = nan"),
        ({"turn": 4.0}, "turn = 4.0"),
        ({"acceleration": [1.0, 0.0]}, "acceleration = 0.0 in 1 of 2"),
    ],
)
def test_numbers_without_sense_are_named(change, says):
    numbers = {"before": 0.2, "after": 0.2, "speed_before": 0.1, "speed_after": 0.1, "turn": 1.0, **change}
    with pytest.raises(OlpError, match=says):
        Corners.of(**numbers)


def test_all_senseless_numbers_are_named_at_once():
    with pytest.raises(OlpError) as caught:
        Corners.of(-1.0, np.inf, 0.1, 0.0, 1.0)
    assert len(caught.value.diagnostics) == 3


def test_unknown_laws_and_parameters_are_told_with_what_there_is():
    with pytest.raises(OlpError, match=r"staubli(.|\n)*yaskawa"):
        load_law("staubli")
    with pytest.raises(OlpError, match=r"gain(.|\n)*servo_lag"):
        load_law("yaskawa", gain=1.0)
    with pytest.raises(OlpError, match="servo_lag = -1"):
        load_law("yaskawa", servo_lag=-1.0)
    with pytest.raises(OlpError, match="not shape"):
        Corners.of(np.ones((2, 2)), 1.0, 1.0, 1.0, 1.0)
