"""What a controller adds to the motion: off unless asked for, and then exactly what was asked for."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError
from olp.core.source import decode
from olp.fluent import read
from olp.ir import program as ir
from olp.ir.points import PointKind, PointState
from olp.robots.controller_effects import GENERATIONS, Effects, effects_of, settling_of
from olp.robots.coordinate_systems import Cell, Mechanism
from olp.robots.robot import load_robot, robot_names
from olp.runtime.assumptions import load_assumptions
from olp.runtime.plan import PATHS, BlendCode, Plan, StepKind
from olp.runtime.recorder import Recorder
from olp.timing.motion import model_names
from olp.timing.timing import time_plan
from olp.timing.track import track

JOB = "samples/inform/welding/SEAM-LH.JBI"


@pytest.fixture(scope="module")
def plan() -> Plan:
    """A seam with exact stops, blended corners, a timer and process instructions."""
    return read(JOB).plan()


def with_effects(plan: Plan, **settings: float) -> Plan:
    return replace(plan, settings={**plan.settings, **settings})


def test_no_effect_changes_anything_until_it_is_asked_for(plan):
    nothing = with_effects(plan, cycle_s=0.0, dispatch_s=0.0, servo_lag_s=0.0, override_pct=100.0)
    assert time_plan(nothing).total_s == time_plan(plan).total_s
    assert effects_of({}) == Effects()
    assert effects_of({}).told == []


@pytest.mark.parametrize("model", model_names())
def test_stretches_between_stops_last_whole_cycles(plan, model):
    cycle = 0.0137
    plain, counted = time_plan(plan, model), time_plan(with_effects(plan, cycle_s=cycle), model)
    more = counted.duration_s - plain.duration_s
    assert (more >= -1e-12).all()
    assert (more < cycle).all()
    assert more.max() > 0
    motion = counted.motion_s / cycle
    assert motion == pytest.approx(round(motion), abs=1e-6)


def test_a_motion_that_is_whole_cycles_already_is_left_alone(plan):
    once = time_plan(with_effects(plan, cycle_s=0.0137))
    for count in (1, 2):
        finer = time_plan(with_effects(plan, cycle_s=0.0137 / count))
        assert finer.total_s <= once.total_s + 1e-9


def line_of(length: float, *around: str) -> Plan:
    """One line at 0.1 m/s with 1 m/s² and no settling; "signal" before or after it."""
    machine = load_robot("yaskawa/ma2010")
    recorder = Recorder(Cell([Mechanism("RB1", machine)]), (decode(b"move", "test.jbi"),))
    state = PointState(PointKind.POSE, frame="robot", configuration=(1, 0, 0, 0, 0, 0))
    recorder.at[0] = recorder.position(0, state, (1.1, 0.1, 0.2, 3.1, 0.2, -0.4))
    if "before" in around:
        recorder.signal(0, 1)
    recorder.step(0, 1)
    index = recorder.position(0, state, (1.1, 0.1 + length, 0.2, 3.1, 0.2, -0.4))
    recorder.row(0, index, PATHS.index(ir.Path.LINEAR), 1, 0.1, BlendCode.EXACT)
    if "after" in around:
        recorder.signal(0, 1)
    return replace(recorder.finish(()), settings={"accel_mm_s2": 1000.0, "settling_s": 0.0})


def test_rounding_noise_costs_no_cycle():
    for hundredths in range(5, 40):
        plain = time_plan(line_of(hundredths / 100))
        counted = time_plan(with_effects(line_of(hundredths / 100), cycle_s=0.05))
        assert counted.total_s == pytest.approx(plain.total_s, abs=1e-9)


def test_the_arm_stands_before_its_first_instruction():
    dispatched = time_plan(with_effects(line_of(0.2, "before", "after"), dispatch_s=0.011))
    assert dispatched.duration_s[[0, 2]] == pytest.approx([0.011, 0.011])
    plain = time_plan(line_of(0.2, "before", "after"))
    assert dispatched.total_s - plain.total_s == pytest.approx(3 * 0.011)


def test_every_stop_comes_later_by_the_lag_of_the_servos(plan):
    lag = 0.0312
    plain, late = time_plan(plan), time_plan(with_effects(plan, servo_lag_s=lag))
    more = late.duration_s - plain.duration_s
    stops = np.isclose(more, lag)
    assert np.allclose(more[~stops], 0.0)
    lines = plan.line[stops].tolist()
    assert 51 in lines, "the exact stop before the seam"
    assert 59 in lines, "the stop that the timer makes"
    assert 65 in lines, "the end"
    assert 50 not in lines, "a corner with a position level"


def test_instructions_take_time_to_begin_only_where_the_arm_stands(plan):
    plain, slow = time_plan(plan), time_plan(with_effects(plan, dispatch_s=0.011))
    more = dict(zip(plan.line.tolist(), (slow.duration_s - plain.duration_s).tolist(), strict=True))
    assert more[52] == pytest.approx(0.011), "ARCON after an exact stop"
    assert more[54] == pytest.approx(0.011), "the seam begins from rest"
    assert more[55] == pytest.approx(0.0), "the seam goes on"


def test_the_track_waits_and_lags_with_the_times(plan):
    timing = time_plan(with_effects(plan, dispatch_s=0.25, servo_lag_s=0.1))
    path = track(timing, 0.01)
    assert path.time[-1] == pytest.approx(timing.total_s)
    still = np.linalg.norm(np.diff(path.position, axis=0), axis=1) < 1e-9
    assert still.sum() * 0.01 > 3 * 0.35 - 0.1
    last = plan.moves.target[plan.moves.mechanism == 0][-1]
    assert path.position[-1] == pytest.approx(plan.positions.position[last], abs=1e-9)


@pytest.mark.parametrize("model", model_names())
def test_half_the_speed_takes_twice_as_long_where_only_speed_counts(plan, model):
    whole, half = time_plan(plan, model), time_plan(plan, model, override=0.5)
    seam = plan.line == 55
    assert half.duration_s[seam] == pytest.approx(2 * whole.duration_s[seam], rel=0.01)
    assert half.speed_mm_s[seam] == whole.speed_mm_s[seam], "the programmed speed stays what is written"
    assert half.reached_mm_s[seam] == pytest.approx(whole.reached_mm_s[seam] / 2)
    waits = half.wait_s + half.io_s
    assert waits == whole.wait_s + whole.io_s


def test_joint_moves_never_exceed_rated_speed(plan):
    joint = np.full_like(plan.moves.path, PATHS.index(ir.Path.JOINT))
    full = replace(plan, moves=replace(plan.moves, path=joint, fraction=np.ones(len(joint))))
    assert time_plan(full, override=1.5).total_s == time_plan(full).total_s
    assert time_plan(full, override=0.5).total_s >= time_plan(full).total_s * (1 - 1e-9), (
        "as fast: too short for half"
    )
    assert time_plan(full, override=0.4).total_s > time_plan(full).total_s


OVERRIDES = (1.5, 1.2, 1.0, 0.97, 0.9, 0.8, 0.7, 0.6, 0.55, 0.5, 0.45, 0.4, 0.3, 0.2, 0.1)
PROGRAMS = sorted(  # those of mistakes move no further than from one point to the next
    path
    for path in Path("samples").rglob("*")
    if path.parent.name not in ("broken", "pitfalls")
    and path.suffix.lower() in (".jbi", ".src", ".ls", ".mod", ".script", ".pdl", ".as")
    and path.stat().st_size < 20_000
)


@pytest.mark.slow(
    "samples/up20/APPR-1.JBI",
    "samples/up20/APPR-2.JBI",
    "samples/up20/APPR-3.JBI",
    "samples/up20/DEPT-1.JBI",
    "samples/up20/DEPT-2.JBI",
    "samples/up20/DEPT-L.JBI",
    "samples/up20/DOWN-2.JBI",
)
@pytest.mark.parametrize("path", PROGRAMS, ids=str)
def test_no_lower_override_makes_a_way_from_stop_to_stop_faster(path):
    """Corners included: which part of one counts for which line shifts with the speed, what both take does not fall."""
    plan = read(path).plan()
    before = stretches(plan, OVERRIDES[0])
    for override in OVERRIDES[1:]:
        after = stretches(plan, override)
        assert (after >= before * (1 - 1e-5) - 1e-9).all(), f"at {override}: {np.argmin(after / before)}"
        before = after


def test_an_override_that_stretches_time_makes_ramps_longer_too(tmp_path: Path) -> None:
    program = tmp_path / "lines.src"
    pose = "A 0, B 90, C 0, S 2, T 2}"
    lines = "\n".join(f"LIN {{X {x}, Y {y}, Z 500, {pose}" for x, y in ((400, 90), (300, -150), (390, 120)))
    program.write_text(
        f"DEF lines()\nBAS (#INITMOV, 0)\n$TOOL = $NULLFRAME\n$BASE = $NULLFRAME\n$VEL.CP = 0.7\n"
        f"PTP {{X 300, Y 0, Z 500, {pose}\n{lines}\nEND\n",
        encoding="utf-8",
    )
    plan = read(program).plan(robot="kuka/kr3-r540")
    whole, half = time_plan(plan), time_plan(plan, override=0.5)
    moving = [timing.duration_s[1:] - timing.stop_s[1:] for timing in (whole, half)]
    assert moving[1] == pytest.approx(2.0 * moving[0], rel=1e-9)


def stretches(plan: Plan, override: float) -> NDArray[np.float64]:
    """[s] from each exact stop, wait and signal to the next; a stop ends the motion at any override."""
    timing = time_plan(plan, override=override)
    move = plan.kind == StepKind.MOVE
    ends = ~move
    ends[move] = plan.moves.blend_code[plan.row[move]] == BlendCode.EXACT
    return (
        np.add.reduceat(np.nan_to_num(timing.duration_s), np.flatnonzero(np.append(True, ends[:-1])))
        if len(plan)
        else np.zeros(0)
    )


def test_settings_are_read_in_the_units_of_their_names(tmp_path):
    (tmp_path / "olp.toml").write_text(
        "[motion]\ncycle_s = 0.004\ndispatch_s = 0.002\nsettling_s = 0\nservo_lag_s = 0.03\noverride_pct = 45\n"
    )
    given = load_assumptions(tmp_path / "olp.toml")
    assert given.diagnostics == ()
    assert effects_of(given.motion) == Effects(0.004, 0.002, 0.0, 0.03, 0.45)
    assert effects_of(given.motion, override=0.8).override == 0.8
    assert len(effects_of(given.motion).told) == 4


@pytest.mark.parametrize(
    "line", ["override_pct = 0", "override_pct = 151", "cycle_s = -1", 'dispatch_s = "a"']
)
def test_impossible_settings_are_told_with_their_line(tmp_path, line):
    (tmp_path / "olp.toml").write_text(f"[motion]\n{line}\n")
    (problem,) = load_assumptions(tmp_path / "olp.toml").diagnostics
    assert (problem.code, problem.line) == ("V004", 2)


@pytest.mark.parametrize("override", [0.0, -0.5, 1.51, float("nan")])
def test_an_override_that_no_controller_has_is_refused(override):
    with pytest.raises(OlpError, match="override") as caught:
        effects_of({}, override)
    assert caught.value.diagnostics[0].code == "T006"


def test_settling_comes_from_the_file_then_the_robot_then_the_generation():
    arm = load_robot("yaskawa/ma2010")
    assert settling_of(Effects(settling=0.07), arm) == (0.07, "")
    assert settling_of(Effects(), arm) == (0.166, "")
    seconds, says = settling_of(Effects(), replace(arm, settling_time=None))
    assert seconds == 0.166
    assert "MA2010" in says
    seconds, says = settling_of(Effects(), replace(arm, settling_time=None, controllers=("XRC",)))
    assert seconds == 0.0
    assert "not known" in says


def test_every_controller_that_a_robot_file_names_is_in_the_table():
    named = {name for robot in robot_names() for name in load_robot(robot).controllers}
    yaskawa = {name for name in named if name[:2] in ("ER", "MR", "XR", "NX", "DX", "FS", "YR")}
    assert yaskawa <= set(GENERATIONS)


def test_every_number_of_the_table_has_a_source():
    for generation in GENERATIONS.values():
        for name in ("cycle", "dispatch", "settling", "servo_lag"):
            known = getattr(generation, name)
            assert known is None or (known.value > 0 and len(known.source) > 10)
