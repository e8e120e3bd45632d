"""Corners of laws other than position levels: a plan names the law, the chain takes its speed, ends and time."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from test_timing import MM, PL_ZONES, plan_of

from olp.reports.explain import as_text, explain
from olp.runtime.plan import BlendCode
from olp.timing.blending import Corners, load_law
from olp.timing.motion import load_model
from olp.timing.timing import time_plan
from olp.timing.track import track

ACCELERATION = 3.05  # [m/s²] of an MA2010's lines
SQUARE = [(1648, -1290, -231), (1648, -1190, -231), (1548, -1190, -231)]  # [mm] a right angle
ZONES = ("abb", "kuka", "radius", "ur")  # laws whose amount is a length


def two_lines(speed_mm_s, level, law="yaskawa", points=SQUARE):
    return replace(plan_of(points, speed_mm_s, [level, 0]), zone_law=law)


def rounded(speed_mm_s, radius_mm, points=SQUARE):
    """The same with a corner radius."""
    plan = plan_of(points, speed_mm_s, [1, 0])
    code = np.where(plan.moves.blend_code == BlendCode.ZONE, BlendCode.RADIUS, plan.moves.blend_code)
    return replace(
        plan, moves=replace(plan.moves, blend_code=code, blend=plan.moves.blend * 0 + radius_mm * MM)
    )


def test_a_radius_at_full_speed_takes_the_length_of_the_rounded_path():
    speed, radius = 0.1, 0.01
    path = 0.2 - 2 * radius + np.pi / 2 * radius
    timing = time_plan(rounded(100.0, 10.0))
    assert timing.duration_s.sum() - 0.166 == pytest.approx(path / speed + speed / ACCELERATION)


def test_a_tight_radius_is_passed_at_the_speed_its_acceleration_allows():
    radius = 0.01
    slow = np.sqrt(ACCELERATION * radius)
    legs = load_model("constant").profile(
        [0.1 - radius] * 2, [0.3] * 2, [ACCELERATION] * 2, start_speed=[0, slow], end_speed=[slow, 0]
    )
    wanted = legs.duration.sum() + np.pi / 2 * radius / slow
    assert time_plan(rounded(300.0, 10.0)).duration_s.sum() - 0.166 == pytest.approx(wanted)


def test_a_radius_larger_than_half_a_move_is_cut_to_it():
    half, more = (time_plan(rounded(100.0, r)).total_s for r in (50.0, 90.0))
    assert more == pytest.approx(half)


@pytest.mark.parametrize("law", ZONES)
@pytest.mark.parametrize("speed", [20.0, 200.0])
def test_the_zones_of_a_plan_are_those_of_the_law_it_names(law, speed):
    """From the law itself: trimmed moves between rest and the corner's speed, and the corner's time."""
    limits = {"deceleration": ACCELERATION, "acceleration": ACCELERATION}
    corner = Corners.of(0.1, 0.1, speed * MM, speed * MM, np.pi / 2, PL_ZONES[1] * MM, **limits)
    passage = load_law(law).passage(corner)
    pace = min(passage.speed_in[0], passage.speed_out[0])
    trims = np.array([passage.trim_before[0], passage.trim_after[0]])
    legs = load_model("constant").profile(
        0.1 - trims, [speed * MM] * 2, [ACCELERATION] * 2, start_speed=[0, pace], end_speed=[pace, 0]
    )
    timing = time_plan(two_lines(speed, 1, law))
    assert timing.total_s - 0.166 == pytest.approx(legs.duration.sum() + passage.duration[0], rel=1e-6)


@pytest.mark.parametrize("law", ZONES)
def test_a_corner_is_faster_than_a_stop_and_no_faster_than_its_speed_allows(law):
    blended, stopped = (time_plan(two_lines(100.0, level, law)).total_s for level in (2, 0))
    assert blended < stopped
    assert blended > np.hypot(0.1, 0.1) / 0.1


def test_position_levels_do_not_care_for_the_law_of_others():
    assert time_plan(two_lines(100.0, 2)).total_s != time_plan(two_lines(100.0, 2, "radius")).total_s
    assert time_plan(two_lines(100.0, 0)).total_s == time_plan(two_lines(100.0, 0, "radius")).total_s


def test_a_corner_that_turns_back_is_a_stop():
    back = [SQUARE[0], SQUARE[1], SQUARE[0]]
    radius, none = time_plan(rounded(100.0, 10.0, back)), time_plan(two_lines(100.0, 0, points=back))
    assert radius.total_s == pytest.approx(none.total_s - 0.166)


def test_a_row_of_short_moves_with_radii_is_timed_and_braked_for():
    steps = [(1648, -1290 + 3 * i, -231 + (i % 2)) for i in range(30)]
    plan = replace(plan_of(steps, 400.0, [1] * 28 + [0]), zone_law="radius")
    timing = time_plan(plan)
    assert np.isfinite(timing.duration_s).all()
    assert (timing.duration_s >= 0).all()
    shortest = np.sum(np.linalg.norm(np.diff(np.array(steps), axis=0), axis=1)) * MM * 0.9
    assert timing.total_s - 0.166 > 2 * np.sqrt(shortest / ACCELERATION) * 0.99


def test_the_track_of_a_rounded_corner_ends_in_time_and_never_stands_still_in_it():
    timing = time_plan(rounded(100.0, 20.0))
    way = track(timing, 0.005)
    moving = way.time < timing.total_s - 0.25
    speed = np.linalg.norm(np.diff(way.position[moving], axis=0), axis=1) / 0.005
    assert speed[10:].min() > 0.05
    assert way.time[-1] == pytest.approx(timing.total_s)


def test_a_rounded_line_explained_tells_of_its_corner_and_blames_no_other_mechanism():
    timing = time_plan(rounded(100.0, 20.0))
    told = as_text(explain(timing, "1"))
    assert re.search(r"corner after .* 20\.0  +100\.0 → 0\.0", told)
    assert "another mechanism" not in told
