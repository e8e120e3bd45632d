"""Lengths and shapes of arcs and splines, against brute force."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from olp.core.source import decode
from olp.ir.points import PointKind, PointState
from olp.ir.program import Path
from olp.robots.coordinate_systems import Cell, Mechanism
from olp.runtime.paths import circle, point_on_arc, point_on_parabola, swept_angle, turn_between
from olp.runtime.plan import PATHS, BlendCode
from olp.runtime.recorder import Recorder

POSE = PointState(PointKind.POSE, frame="base")
CODE = {path: PATHS.index(path) for path in Path}


def plan_of(points, paths, ends=()):
    """Moves of the given kinds through points [m]; `ends`: moves that end an arc."""
    recorder = Recorder(Cell([Mechanism("RB1")]), (decode(b"x\r\n" * 40, "t.jbi"),))
    places = [recorder.position(0, POSE, (*p, 0.1, 0.2, 0.3)) for p in points]
    recorder.at[0] = places[0]
    for i, (place, path) in enumerate(zip(places[1:], paths, strict=True)):
        recorder.step(0, i + 1)
        recorder.row(0, place, CODE[path], 1, 0.1, BlendCode.UNTAGGED, end_of_arc=i in ends)
    return recorder.finish(())


def on_circle(angle, radius=0.37):
    """A point of a circle in a plane that lies askew to all axes."""
    u, v = np.array([0.8, 0.36, 0.48]), np.array([-0.6, 0.48, 0.64])
    return tuple(np.array([0.9, -0.3, 0.4]) + radius * (u * np.cos(angle) + v * np.sin(angle)))


C, L, S = Path.CIRCULAR, Path.LINEAR, Path.SPLINE


@pytest.mark.parametrize("angles", [(0.0, 0.7, 1.9), (0.3, 2.9, 5.1), (1.0, 4.5, 5.0), (6.0, 3.0, 1.0)])
def test_three_points_of_a_circle_give_the_two_arcs_between_them(angles):
    first, middle, last = angles
    plan = plan_of([(0.1, 0.2, 0.3), *map(on_circle, angles)], [C, C, C])
    assert plan.moves.via.tolist()[0] == -1
    assert plan.moves.length[1:] == pytest.approx([0.37 * abs(middle - first), 0.37 * abs(last - middle)])


def test_a_chain_enters_its_first_point_on_a_line():
    points = [(0.1, 0.2, 0.3), *map(on_circle, (0.0, 0.7, 1.9))]
    plan = plan_of(points, [C, C, C])
    assert plan.moves.length[0] == pytest.approx(np.linalg.norm(np.subtract(points[1], points[0])))


def test_four_points_use_their_neighbours_and_the_last_one_the_three_last():
    points = [on_circle(0.0), on_circle(0.0), on_circle(0.9), on_circle(2.0), on_circle(2.8)]
    plan = plan_of(points, [L, C, C, C, C][1:])
    assert plan.moves.length == pytest.approx([0.0, 0.37 * 0.9, 0.37 * 1.1, 0.37 * 0.8], abs=1e-12)


def test_a_line_after_the_arc_breaks_the_chain():
    points = [on_circle(0.0), on_circle(0.0), on_circle(0.9), on_circle(2.0), (0.2, 0.3, 0.1), on_circle(1.0)]
    plan = plan_of(points, [C, C, C, L, C])
    assert plan.moves.via.tolist()[3:] == [-1, -1]


def test_the_marked_end_of_an_arc_begins_the_next_one():
    away = [on_circle(a, 0.2) for a in (1.2, 2.2)]
    points = [on_circle(0.0), on_circle(0.0), on_circle(0.9), on_circle(2.0), *away]
    joined = plan_of(points, [C] * 5)
    split = plan_of(points, [C] * 5, ends={2})
    assert split.moves.length[2] == pytest.approx(0.37 * 1.1)
    assert joined.moves.length[2] != pytest.approx(split.moves.length[2], abs=1e-6)


def test_two_curved_moves_alone_are_straight():
    plan = plan_of([(0.1, 0.2, 0.3), on_circle(0.0), on_circle(0.9)], [C, C])
    assert plan.moves.via.tolist() == [-1, -1]


def test_points_on_a_line_make_no_circle():
    line = [(0.1, 0.2, 0.3), (0.2, 0.3, 0.5), (0.4, 0.5, 0.9), (0.5, 0.6, 1.1)]
    plan = plan_of(line, [C, C, C])
    assert plan.moves.length.sum() == pytest.approx(np.linalg.norm(np.subtract(line[-1], line[0])))


def _measured(shape, start, target, third, before):
    """Length of a curve by 20,000 chords."""
    fractions = np.linspace(0.0, 1.0, 20_001)
    rows = [np.broadcast_to(np.array(p), (len(fractions), 3)) for p in (start, target, third)]
    points = shape(*rows, np.full(len(fractions), before), fractions)
    return points, np.linalg.norm(np.diff(points, axis=0), axis=1).sum()


@pytest.mark.parametrize(("path", "shape"), [(C, point_on_arc), (S, point_on_parabola)])
@pytest.mark.parametrize("before", [True, False])
def test_measured_length_is_the_length_of_the_curve_that_is_travelled(path, shape, before):
    points = [(0.1, 0.2, 0.3), (0.42, 0.11, 0.35), (0.61, -0.14, 0.52), (0.66, -0.4, 0.31)]
    plan = plan_of(points, [path] * 3)
    row, third = (2, 1) if before else (1, 3)
    way, length = _measured(shape, points[row], points[row + 1], points[third], before)
    assert plan.moves.length[row] == pytest.approx(length, rel=1e-7)
    assert way[0] == pytest.approx(points[row])
    assert way[-1] == pytest.approx(points[row + 1])
    chords = np.linalg.norm(np.diff(way, axis=0), axis=1)
    assert chords == pytest.approx(length / len(chords), rel=1e-5)  # a fraction is one of the length


@pytest.mark.parametrize("bend", [0.0, 1e-9, 1e-7, 1e-5, 1e-3, 0.1, 1.0])
@pytest.mark.parametrize("before", [True, False])
def test_a_spline_runs_evenly_however_much_it_bends_and_where_it_turns_back(bend, before):
    for points in ([(0, 0, 0), (1, 0, 0), (2, bend, 0)], [(0, 0, 0), (1, 0, 0), (0, bend, 0)]):
        a, b, c = (np.array(p, dtype=float) for p in points)
        start, target, third = (b, c, a) if before else (a, b, c)
        way, length = _measured(point_on_parabola, start, target, third, before)
        chords = np.linalg.norm(np.diff(way, axis=0), axis=1)
        assert chords[2:-2] == pytest.approx(
            length / len(chords), rel=2e-4
        )  # at a narrow turn a chord is short


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(-1, 1), min_size=9, max_size=9))
def test_circle_passes_through_its_points_in_their_order(numbers):
    a, b, c = (np.array([numbers[i : i + 3]]) for i in (0, 3, 6))
    centre, radius, axis = circle(a, b, c)
    sides = [np.linalg.norm(p - q) for p, q in ((a, b), (b, c), (a, c))]
    if not np.isfinite(radius[0]) or min(sides) < 1e-2 or radius[0] > 50:
        return
    for point in (a, b, c):
        assert np.linalg.norm(point - centre) == pytest.approx(radius[0], rel=1e-6)
    assert swept_angle(a - centre, b - centre, axis)[0] < swept_angle(a - centre, c - centre, axis)[0] + 1e-9


@settings(max_examples=60, deadline=None)
@given(st.floats(1e-9, np.pi), st.floats(-1, 1), st.floats(-1, 1))
def test_turn_between_orientations_keeps_its_digits_for_small_angles(angle, x, y):
    axis = np.array([x, y, 0.3]) / np.linalg.norm([x, y, 0.3])
    first = np.array([[1.0, 0.0, 0.0, 0.0]])
    second = np.array([[np.cos(angle / 2), *(np.sin(angle / 2) * axis)]])
    assert turn_between(first, second)[0] == pytest.approx(angle, rel=1e-6)
    assert turn_between(first, -second)[0] == pytest.approx(angle, rel=1e-6)
