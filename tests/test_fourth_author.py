"""The cases of `bench/fourth_author`: the same for a seed, read by olp; its arms and ramps are where olp's are."""

import json

import numpy as np
import pytest

from bench.fourth_author.cases import Hidden, _numbered, generate
from bench.fourth_author.motion import World, ramped, seconds
from bench.fourth_author.programs import write_program
from bench.fourth_author.robots import all_arms
from bench.third_author.scoring import judge
from olp.identification.recorded_plan import case_of
from olp.identification.recording import read_recording
from olp.timing.physics._motion import Motion

SEED, CASES = 3, 2


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fourth")
    generate(folder, SEED, CASES)
    return folder


def test_a_seed_makes_the_same_cases_and_olp_judges_their_moves(folder, tmp_path):
    generate(tmp_path, SEED, CASES)
    for k in range(CASES):
        name = f"c{k:03d}"
        truth = (folder / "truth" / f"{name}.json").read_text()
        assert truth == (tmp_path / "truth" / f"{name}.json").read_text()
        case = case_of(read_recording(folder / "cases" / name)).case
        assert len(case) > 40
        row = judge(json.loads(truth), {"findings": [], "verdict": "no-mismatch"})
        assert row["exact"] is (json.loads(truth)["family"] in ("nothing", "outside"))


def test_a_jerk_beside_another_acceleration_is_what_both_make():
    jerk, _ = _numbered(
        [Hidden("jerk", {"ramp": 0.02}, {"jerk": 100.0}), Hidden("acceleration", {"accel": 1.3})]
    )
    assert jerk.numbers == {"jerk": pytest.approx(130.0)}


def test_ramps_by_quadrature_take_what_olps_formulas_say():
    rng = np.random.default_rng(1)
    n = 200
    way, speed = np.exp(rng.uniform(np.log(0.005), np.log(1.5), n)), rng.choice([0.1, 0.3, 1.0], n)
    up, down, build = rng.uniform(0.5, 5, n), rng.uniform(0.5, 5, n), rng.choice([0.0, 0.05, 0.2], n)
    none = np.zeros(n)
    plain = Motion(way, speed, up, down, np.full(n, np.inf), none, none, none, none, none + 1, build=build)
    assert ramped(speed, up, down, way, build) == pytest.approx(plain.duration(), abs=5e-5)


def test_positions_of_an_arm_of_the_library_are_those_of_olp():
    from olp.robots.kinematics import forward
    from olp.robots.robot import load_robot

    for arm in all_arms():
        if arm.library:
            joints = arm.home + np.random.default_rng(2).uniform(-0.4, 0.4, (5, arm.n))
            assert arm.poses(joints)[0] == pytest.approx(
                forward(load_robot(arm.library), joints)[0], abs=1e-9
            )


def test_a_program_takes_longer_where_the_robot_is_weaker():
    arm = all_arms()[1]
    moves = write_program(np.random.default_rng(4), arm, "measuring", 60, 2.0, 1.0)
    plain = seconds(moves, World(), arm)
    for world in (
        World(accel=0.8),
        World(ramp=0.1),
        World(reach=0.3),
        World(viscous=0.5, brake=0.1),
        World(cruise=0.9),
    ):
        assert seconds(moves, world, arm).sum() > plain.sum()
