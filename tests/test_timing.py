"""Timing a plan: the corner law against published recordings, and promises that hold for every motion model."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest

from olp.core.source import decode
from olp.fluent import read
from olp.ir.points import PointKind, PointState
from olp.ir.program import Path
from olp.robots.coordinate_systems import Cell, Mechanism
from olp.robots.kinematics import forward
from olp.robots.robot import load_robot
from olp.runtime.plan import PATHS, BlendCode, Plan
from olp.runtime.recorder import Recorder
from olp.timing.motion import model_names
from olp.timing.timing import time_plan
from olp.timing.track import track

LINEAR, JOINT = PATHS.index(Path.LINEAR), PATHS.index(Path.JOINT)
POSE = PointState(PointKind.POSE, frame="robot", configuration=(1, 0, 0, 0, 0, 0))
MM = 1e-3
PL_ZONES = (0.0, 12.5, 25.0, 50.0, 100.0)  # [mm], DX200 and MA2010
ANY_MODEL = pytest.mark.parametrize("model", model_names())


def plan_of(points_mm, speed_mm_s, blends, robot="yaskawa/ma2010", waits=()) -> Plan:
    """Lines through points; `blends`: per move a position level, or None for no tag; `waits`: {after move: s}."""
    text = "\r\n".join(f"move {i}" for i in range(len(points_mm) + 1)).encode()
    machine = load_robot(robot) if robot else None
    recorder = Recorder(Cell([Mechanism("RB1", machine)]), (decode(text, "test.jbi"),))
    tool = (3.1, 0.2, -0.4)
    indices = [recorder.position(0, POSE, (*(np.array(p) * MM), *tool)) for p in points_mm]
    recorder.at[0] = indices[0]
    waits = dict(waits)
    for i, (index, level) in enumerate(zip(indices[1:], blends, strict=True)):
        recorder.step(0, i + 1)
        code = BlendCode.UNTAGGED if level is None else BlendCode.ZONE if level else BlendCode.EXACT
        zone = PL_ZONES[level] * MM if level else np.nan
        recorder.row(0, index, LINEAR, 1, speed_mm_s * MM, code, zone)
        if i in waits:
            recorder.wait(0, i + 1, waits[i])
    return recorder.finish(())


STRAIGHT = [(1648, -1290, -231), (1648, -1240, -231), (1648, -1190, -231)]
_SIDE = 57.735
TURN = [
    (1648, -1290, -231),
    (1648, -1290 + _SIDE, -231),
    (1648 - _SIDE * 0.8660254, -1290 + 1.5 * _SIDE, -231),
]


@pytest.mark.parametrize(
    ("points", "level", "measured"),
    [
        # [s] from rest to rest; docs/blending.md says how the recordings' thresholds were taken off
        (STRAIGHT, 0, 10.32),
        (STRAIGHT, 1, 9.54),
        (STRAIGHT, 2, 8.92),
        (STRAIGHT, 3, 8.92),
        (TURN, 0, 11.89),
        (TURN, 1, 11.09),
        (TURN, 2, 10.46),
        (TURN, 3, 10.27),
    ],
)
def test_position_levels_take_the_time_that_a_dx200_took(points, level, measured):
    timing = time_plan(plan_of(points, 10.0, [level, 0]))
    assert timing.total_s == pytest.approx(measured, rel=0.004)


def test_a_move_without_position_level_neither_stops_nor_overlaps():
    timing = time_plan(plan_of(STRAIGHT, 10.0, [None, None]))
    assert timing.total_s == pytest.approx(10.01, abs=0.02)


def test_a_corner_is_faster_than_length_over_speed():
    stopped, blended = (time_plan(plan_of(TURN, 10.0, [level, 0])) for level in (0, 2))
    assert blended.total_s < 2 * _SIDE / 10.0 < stopped.total_s


def test_a_wait_that_takes_time_ends_the_overlap_and_one_that_takes_none_does_not():
    free = time_plan(plan_of(STRAIGHT, 10.0, [2, 0]))
    none = time_plan(plan_of(STRAIGHT, 10.0, [2, 0], waits={0: 0.0}))
    some = time_plan(plan_of(STRAIGHT, 10.0, [2, 0], waits={0: 0.7}))
    assert none.motion_s == pytest.approx(free.motion_s)
    assert some.motion_s > free.motion_s + 1.0
    assert some.wait_s == pytest.approx(0.7)


@ANY_MODEL
def test_running_total_ends_on_the_sum_of_motion_waits_and_signals(model):
    timing = time_plan(plan_of(TURN, 123.0, [1, 0], waits={0: 0.3}), model=model)
    assert timing.end_s[-1] == pytest.approx(timing.total_s)
    assert timing.total_s == pytest.approx(timing.motion_s + timing.wait_s + timing.io_s)


@ANY_MODEL
def test_an_override_of_the_acceleration_is_used_and_told(model):
    slow, fast = (time_plan(plan_of(TURN, 250.0, [0, 0]), model=model, acceleration=a) for a in (1.0, 5.0))
    assert slow.total_s > fast.total_s
    assert slow.accel_mm_s2[0] == pytest.approx(1000.0)


def test_dense_points_cannot_all_be_passed_at_full_speed_when_the_last_must_stop():
    points = [(1500 + 0.5 * i, 12.5, 33.0) for i in range(40)]
    timing = time_plan(plan_of(points, 400.0, [None] * 39), acceleration=3.0)
    assert timing.reached_mm_s.max() <= np.sqrt(3.0 * 39 * 0.5 * MM) / MM * 1.001
    assert timing.total_s == pytest.approx(2 * np.sqrt(39 * 0.5 * MM / 3.0), rel=1e-6)


def test_turning_alone_takes_time():
    machine = load_robot("yaskawa/ma2010")
    recorder = Recorder(Cell([Mechanism("RB1", machine)]), (decode(b"a\r\nb", "t.jbi"),))
    here = recorder.position(0, POSE, (1.3, 0.1, 0.2, 3.1, 0.2, -0.4))
    there = recorder.position(0, POSE, (1.3, 0.1, 0.2, 3.1, 0.2, 0.9))
    recorder.at[0] = here
    recorder.step(0, 1)
    recorder.row(0, there, LINEAR, 1, 0.2, BlendCode.EXACT)
    timing = time_plan(recorder.finish(()))
    assert timing.limited_by[0].startswith("orientation")
    assert timing.duration_s[0] > np.degrees(1.3) / 610.0


def test_the_track_starts_and_ends_where_the_program_does_and_passes_the_measured_corner_distance():
    timing = time_plan(plan_of(TURN, 10.0, [1, 0]))
    way = track(timing, 0.004)
    assert way.time[-1] == pytest.approx(timing.total_s)
    assert np.allclose(way.position[0] / MM, TURN[0], atol=1e-6)
    assert np.allclose(way.position[-1] / MM, TURN[2], atol=1e-6)
    nearest = np.linalg.norm(way.position / MM - TURN[1], axis=1).min()
    assert nearest == pytest.approx(3.34, abs=0.1)  # published recording, PL1, 60 degree turn
    steps = np.linalg.norm(np.diff(way.position, axis=0), axis=1) / 0.004 / MM
    assert steps.max() < 2 * 10.0 + 0.01


def test_the_track_tells_where_another_tool_is_taken_and_whose_segment_it_is():
    job = pathlib.Path(__file__).parent.parent / "samples" / "inform" / "handling" / "HANDLING.JBI"
    plan = read(job).plan()
    timing = time_plan(plan)
    table = track(timing, 0.001).frame()
    places = table[["x_mm", "y_mm", "z_mm"]].to_numpy()
    changes = np.diff(table.tool_changes) > 0
    jumped = np.linalg.norm(np.diff(places, axis=0), axis=1) > 20  # no joint move of this job makes 20 m/s
    assert changes.sum() == 2
    assert (changes == jumped).all()
    assert np.linalg.norm(np.diff(table.filter(like="q").to_numpy(), axis=0), axis=1)[changes].max() < 1.0
    ends = np.array([segment["end_s"] for segment in timing.segments()])
    assert (table.t_s <= ends[table.segment] + 1e-9).all()
    assert (plan.line[table.segment] == table.line).all()


@ANY_MODEL
def test_the_track_moves_no_faster_than_two_overlapping_moves(model):
    near = [(1300, 40, 210), (1300, 98, 205), (1250, 127, 214)]
    way = track(time_plan(plan_of(near, 300.0, [2, 0]), model=model), 0.002)
    speed = np.linalg.norm(np.diff(way.position, axis=0), axis=1) / np.diff(way.time)
    assert speed.max() < 0.6
    assert speed.min() >= 0.0
    position, _ = forward(load_robot("yaskawa/ma2010"), way.axes)
    assert np.allclose(position, way.position, atol=1e-9)
