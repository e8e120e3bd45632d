"""One line explained: its phases add up to its time, and what is said to limit it is what limits it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from olp.core.diagnostic import OlpError
from olp.core.source import decode
from olp.fluent import read
from olp.ir.points import PointKind, PointState
from olp.ir.program import Path
from olp.reports.explain import Explanation, as_text, explain
from olp.reports.plot.figure import TextLabel
from olp.reports.plot.motion import motion_figure
from olp.robots.coordinate_systems import Cell, Mechanism
from olp.robots.dynamics import dynamic_model, gravity_torques
from olp.robots.robot import load_robot
from olp.runtime.plan import PATHS, BlendCode
from olp.runtime.recorder import Recorder
from olp.timing.motion import model_names
from olp.timing.result import Timing
from olp.timing.timing import time_plan

SEAM = "samples/inform/welding/SEAM-LH.JBI"
WELD = "samples/inform/welding/WELD-MAIN.JBI"
FAN = "samples/up20/APPR-1.JBI"
MOVING_LINES = (50, 51, 54, 55, 57, 58, 59, 63, 65)
ANY_MODEL = pytest.mark.parametrize("model", model_names())


def timed(path: str, model: str = "constant", **settings: float) -> Timing:
    plan = read(path).plan()
    return time_plan(replace(plan, settings={**plan.settings, **settings}), model)


def told(path: str, place: object, model: str = "constant", **settings: float) -> Explanation:
    return explain(timed(path, model, **settings), str(place))


@ANY_MODEL
def test_phases_follow_one_another_and_cover_the_way(model):
    timing = timed(SEAM, model)
    for line in MOVING_LINES:
        found = explain(timing, str(line))
        for before, after in zip(found.phases, found.phases[1:], strict=False):
            assert after.begin == pytest.approx(before.end, abs=1e-9)
            assert after.speeds[0] == pytest.approx(before.speeds[1], abs=1e-6)
        step = int(np.nonzero(timing.plan.line == line)[0][0])
        row = int(timing.plan.row[step])
        assert sum(p.length for p in found.phases) == pytest.approx(timing.rows.length[row])


@ANY_MODEL
def test_a_line_from_stop_to_stop_lasts_as_long_as_its_phases(model):
    found = told(FAN, 51, model)
    assert found.phases[-1].end - found.phases[0].begin == pytest.approx(found.duration, abs=1e-9)
    assert found.entry == "begins from rest"
    assert "stops exactly" in found.exit


def test_the_phases_of_a_plain_line_are_those_of_the_textbook():
    found = told(FAN, 51)
    assert [p.kind for p in found.phases] == ["rise", "cruise", "fall"]
    rise, cruise, fall = found.phases
    assert rise.end - rise.begin == pytest.approx(0.3 / 0.4)
    assert rise.length == pytest.approx(0.3**2 / 2 / 0.4)
    assert cruise.speeds == pytest.approx((0.3, 0.3))
    assert fall.speeds == pytest.approx((0.3, 0.0), abs=1e-9)
    assert "400 mm/s²" in rise.limit
    assert "programmed speed, 300.0 mm/s" in cruise.limit


def test_an_exact_stop_shows_its_settling():
    (*_, last) = told(SEAM, 51, settling_s=0.217).phases
    assert (last.kind, last.name) == ("rest", "settling")
    assert last.end - last.begin == pytest.approx(0.217)
    assert "position window" in last.limit


def test_a_corner_is_told_from_both_sides():
    assert "line 51 begins before this one has ended" in told(SEAM, 50).exit
    assert "begins while line 50 still runs" in told(SEAM, 51).entry
    assert "zone 12.5 mm" in told(SEAM, 51).entry
    assert "goes on with line 55" in told(SEAM, 54).exit
    assert "goes on from line 54" in told(SEAM, 55).entry


def test_an_axis_that_limits_a_joint_move_is_named_with_its_kind():
    found = told(SEAM, 50)
    assert found.limited_by == "axis B acceleration"
    assert {p.limit for p in found.phases if not p.name.startswith("corner")} == {"acceleration of axis B"}
    slow = told("samples/up20/APPR-1.JBI", 49)
    assert slow.phases == ()


def test_a_smaller_acceleration_in_the_line_is_told():
    assert "fall" not in [p.kind for p in told(SEAM, 57).phases if "corner" not in p.name], (
        "the arc is passed"
    )
    timing = timed(SEAM)
    moves = replace(timing.plan.moves, deceleration=np.full(len(timing.plan.moves), 0.2))
    found = explain(time_plan(replace(timing.plan, moves=moves)), "51")
    assert "at 20 % (written in the line)" in next(p for p in found.phases if p.kind == "fall").limit


def test_the_load_of_the_axes_is_their_speed():
    found = told(FAN, 51)
    assert [axis.name for axis in found.axes] == ["S", "L", "U", "R", "B", "T"]
    assert found.time is not None
    assert found.speed is not None
    travelled = np.trapezoid(found.speed, found.time) if hasattr(np, "trapezoid") else None
    assert travelled is None or travelled == pytest.approx(0.6986, abs=0.001)
    timing = timed(FAN)
    plan, row = timing.plan, int(timing.plan.row[2])
    for i, axis in enumerate(found.axes):
        turned = float(np.sum((axis.speed[1:] + axis.speed[:-1]) / 2 * np.diff(found.time)))
        start, target = (
            plan.positions.axes[int(index), i] for index in (plan.moves.start[row], plan.moves.target[row])
        )
        assert turned == pytest.approx(target - start, abs=1e-3)
        assert (axis.share <= 1.0).all()


def test_what_would_be_saved_is_what_a_change_saves():
    found, timing = told(FAN, 51), timed(FAN)
    double = timed(FAN, accel_mm_s2=800.0)
    saved = timing.duration_s[2] - double.duration_s[2]
    assert f"twice the acceleration would save {saved:.3f} s" in found.gains


def test_what_is_not_counted_is_told_only_where_the_arm_stands():
    assert any("cycle_s" in note and "servo_lag_s" in note for note in told(SEAM, 51).notes)
    assert not any("cycle_s" in note for note in told(SEAM, 55).notes)
    some = told(SEAM, 51, cycle_s=0.004, servo_lag_s=0.02).notes
    assert any("dispatch_s" in note and "cycle_s" not in note for note in some)


def test_a_line_of_another_job_is_named_with_it():
    found = told(WELD, "SEAM-LH:57")
    assert found.kind == "circular"
    assert found.statement.startswith("MOVC C00005")
    assert told(WELD, "seam-lh:57").begin == found.begin


def test_a_line_that_runs_often_is_told_so():
    found = told("samples/inform/palletising/MAIN.JBI", "PLACE:45")
    assert found.executions > 5
    assert f"executed {found.executions} times" in as_text(found)


def test_a_wait_is_told_as_one():
    found = told(SEAM, 62)
    assert found.phases == ()
    assert as_text(found) == (
        "line 62: TIMER T=0.35\n"
        f"  wait, 0.350 s, from {found.begin:.3f} to {found.begin + 0.35:.3f} s of the program\n"
        "  the line takes 0.350 s: nothing moves\n"
    )


@pytest.mark.parametrize(
    ("path", "place", "code", "says"),
    [
        (SEAM, "47", "E002", "48, 49, 50"),
        (SEAM, "0", "E002", "48"),
        (SEAM, "999999999", "E002", "65"),
        (SEAM, "x", "E001", "JOB:LINE"),
        (SEAM, "", "E001", "JOB:LINE"),
        (SEAM, "-5", "E001", "JOB:LINE"),
        (SEAM, "NONE:5", "E001", "SEAM-LH"),
        (WELD, "57", "E002", "SEAM-LH:57"),
    ],
)
def test_a_place_that_is_none_is_told_with_those_there_are(path, place, code, says):
    with pytest.raises(OlpError) as caught:
        told(path, place)
    (problem,) = caught.value.diagnostics
    assert problem.code == code
    assert says in problem.help


def test_a_line_that_cannot_be_timed_says_why():
    plan = read(FAN).plan()
    with pytest.raises(OlpError) as caught:
        explain(time_plan(replace(plan, moves=replace(plan.moves, travel=plan.moves.travel * np.nan))), "51")
    assert {d.code for d in caught.value.diagnostics} == {"T101"}


def test_lines_are_explained_without_a_known_robot():
    plan = read("samples/inform/cam/FINISH.JBI").plan()
    found = explain(
        time_plan(replace(plan, robot=None, robots=(None,) * len(plan.robots))), str(plan.line[40])
    )
    assert found.axes == ()
    assert "axes" not in as_text(found)


def test_torques_stand_where_the_masses_are_known_and_balance_gravity_at_rest():
    machine = load_robot("universal-robots/ur10e")
    recorder = Recorder(Cell([Mechanism("RB1", machine)]), (decode(b"MOVJ P001 VJ=60", "test.jbi"),))
    state = PointState(PointKind.JOINT, "joint", None, 0)
    start, target = (np.radians(q) for q in ([10, -80, 70, -60, -85, 5], [55, -40, 85, -30, -60, 40]))
    recorder.at[0] = recorder.position(0, state, start.tolist())
    recorder.step(0, 1)
    index = recorder.position(0, state, target.tolist())
    recorder.row(0, index, PATHS.index(Path.JOINT), 0, 0.6, BlendCode.EXACT)
    timing = time_plan(recorder.finish(()), "linear")
    found = explain(timing, "1")
    torques = np.array([axis.torque for axis in found.axes])
    held = gravity_torques(dynamic_model(machine), np.array([start, target]))
    # The acceleration rises from nothing and falls to it, so at both ends the arm is only held.
    assert pytest.approx(held, abs=1.5) == torques[:, [0, -1]].T
    shoulder = found.axes[1]
    assert shoulder.torque_share is not None
    assert shoulder.torque_share.max() == pytest.approx(np.abs(shoulder.torque).max() / 330)
    assert "highest torque and share of its limit" in as_text(found)
    words = [s.text for s in motion_figure(found).shapes if isinstance(s, TextLabel)]
    assert "% of limit" in words
    assert told(FAN, 51).axes[0].torque is None
