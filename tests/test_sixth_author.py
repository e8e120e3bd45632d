"""The cases of `bench/sixth_author`: the same for a seed, read by olp; its arm and its times are where oracles are."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from bench.sixth_author.arm import draw_arm, orientation
from bench.sixth_author.cases import FAMILIES, draw_cell, generate
from bench.sixth_author.motion import Controller, Engine
from bench.sixth_author.programs import Program
from bench.third_author.scoring import judge
from olp.identification.recorded_plan import case_of
from olp.identification.recording import read_recording

SEED, CASES = 6, 2
PLAIN = Controller(2000.0, 2000.0)


def engine(program, controller=PLAIN):
    return Engine(program.moves, draw_arm(np.random.default_rng(3)), controller)


def there_and_back():
    """Lines of 10, 100 and 300 mm and a short quick one, each and back."""
    program = Program()
    program.begin([900, 0, 500])
    for length, speed in ((10, 500), (100, 300), (300, 100), (300, 1500), (5, 1000)):
        program.go([900, length, 500], speed)
        program.go([900, 0, 500], speed)
    return program


def closed(program, acceleration):
    """Seconds of trapezoids between stops."""
    times = []
    for move in program.moves:
        length, speed = np.linalg.norm(move.end - move.start), move.speed
        whole = length > speed**2 / acceleration
        times.append(length / speed + speed / acceleration if whole else 2 * math.sqrt(length / acceleration))
    return np.array(times)


@pytest.mark.slow
def test_a_seed_makes_the_same_cases_and_olp_judges_their_moves(tmp_path):
    for folder in ("one", "two"):
        generate(tmp_path / folder, SEED, CASES)
    paths = [path for path in sorted((tmp_path / "one").rglob("*")) if path.is_file()]
    assert len(paths) == 3 * CASES
    for path in paths:
        assert path.read_bytes() == (tmp_path / "two" / path.relative_to(tmp_path / "one")).read_bytes()
    for case in sorted((tmp_path / "one" / "cases").iterdir()):
        assert len(case_of(read_recording(case)).case) > 20
        truth = json.loads((tmp_path / "one" / "truth" / f"{case.name}.json").read_text())
        assert truth["family"] in FAMILIES
        row = judge(truth, {"findings": [], "verdict": "no-mismatch"})
        assert row["exact"] is (truth["family"] in ("nothing", "outside"))
        told = [
            {"term": effect["term"], "parameters": {}, "moves": effect["moves"]}
            for effect in truth["effects"]
        ]
        assert judge(truth, {"findings": told, "verdict": "explained"})["exact"]


def test_joints_lead_to_the_pose_they_are_of():
    points = np.array([[900, 200, 500.0], [1000, -300, 400]])
    turns = orientation([170, 15, 40]).as_matrix()[None].repeat(2, 0)
    arm = draw_arm(np.random.default_rng(3))
    there, turned = arm.forward(arm.inverse(points, turns))
    assert there == pytest.approx(points, abs=1e-8)
    assert turned == pytest.approx(turns, abs=1e-12)


def test_the_phase_plane_between_stops_is_a_trapezoid():
    program = there_and_back()
    assert engine(program).run() == pytest.approx(closed(program, 2000.0), abs=1e-9)


@pytest.mark.parametrize(
    ("law", "whole_ramp"),
    [("sin2", math.pi / 2), ("ramp", 0.1 * 2000.0 / 300.0), ("dS", 1 + 0.08 * 2000.0 / 300.0)],
)
def test_ramps_of_other_laws_take_so_many_times_a_trapezoids(law, whole_ramp):
    """At 300 mm/s, whose trapezoid has ramps of 150 ms."""
    program = there_and_back()
    controller = replace(PLAIN, law=law, ramp_time=0.1, jerk=2000.0 / 0.08)
    ramp = max(300.0 / 2000.0 * whole_ramp, 0.1 if law != "ramp" else 0.15)
    assert engine(program, controller).run()[2] == pytest.approx(100 / 300 + ramp, abs=1e-6)


def test_weight_acts_up_and_down_and_not_along():
    program = Program()
    program.begin([900, 0, 400])
    for to in ([900, 0, 700], [900, 0, 400], [1000, 0, 400]):
        program.go(to, 800)
    run = engine(program).run
    for share, move in ((0.6, 0), (1.4, 1), (1.0, 2)):
        assert run(gravity=0.4, gravity_variant=1)[move] == pytest.approx(
            closed(program, 2000.0 * share)[move]
        )


def test_corners_take_away_of_the_path_and_of_the_time():
    program = Program()
    program.begin([900, 0, 400])
    for to in ([1000, 0, 400], [1000, 100, 400], [900, 100, 400], [900, 0, 400]):
        program.go(to, 200, blend=10)
    program.moves[-1].blend = 0.0
    square = engine(program)
    sharp, rounded, wide = (square.run(corner=k).sum() for k in (0.0, 1.0, 2.0))
    assert wide < rounded < sharp
    assert square.way(0.0).whole == pytest.approx(100.0)
    half = square.way(1.0).whole[0] - 90.0  # of a parabola within 10 mm
    assert 10 / math.sqrt(2) < half < 10


def test_half_a_circle_is_pi_radii_long():
    program = Program()
    program.begin([900, 0, 400])
    program.go([900, 100, 400], 200, "circular", via=np.array([950.0, 50, 400]))
    assert engine(program).way(1.0).whole[0] == pytest.approx(50 * math.pi, rel=1e-3)


@pytest.mark.parametrize(
    "change",
    [
        {"torque_loss": 0.7, "knee": 0.3},
        {"viscous": 0.5},
        {"wrist_inertia": 0.2},
        {"joint_speeds": np.full(6, 0.5)},
        {"joint_accelerations": np.full(6, 3.0)},
    ],
    ids=lambda change: next(iter(change)),
)
def test_what_slows_axes_makes_moves_longer_and_none_shorter(change):
    cell = draw_cell(np.random.default_rng(5), "torque-speed", ["torque-speed"], 64)
    late = cell.engine.run(**change) - cell.engine.run()
    assert late.min() > -1e-9
    assert late.max() > 1e-3
