"""The cases of `bench/fourth_author`: the same for a seed, read by olp; its arms and ramps are where olp's are."""

import json

import numpy as np
import pandas as pd
import pytest

from bench.fourth_author.cases import Hidden, _numbered, generate
from bench.fourth_author.motion import JOINT, LINEAR, World, ramped, seconds
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


@pytest.mark.slow
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


def written(folder, moves, arm, sim, accelerations):
    """The recording of a program that the robot runs as simulated, `sim` (m,) [s]."""
    table = {
        "move": np.arange(len(moves)),
        "type": np.array(["joint", "linear"])[moves.kind],
        "blend_mm": moves.zone * 1e3,
    }
    for word, k in (("start", 0), ("end", -1)):
        table |= {f"{axis}_{word}_mm": moves.p[:, k, i] * 1e3 for i, axis in enumerate("xyz")}
        table |= {f"q{i + 1}_{word}_deg": np.degrees(moves.q[:, k, i]) for i in range(arm.n)}
    straight = moves.kind == LINEAR
    table["speed_mm_s"] = np.where(straight, moves.speed * 1e3, np.nan)
    table["speed_pct"] = moves.percent
    if accelerations:
        table["accel_mm_s2"] = np.where(straight, moves.accel * 1e3, np.nan)
    table["sim_s"] = table["duration_s"] = np.round(sim, 4)
    pd.DataFrame(table).to_csv(folder / "moves.csv", index=False)
    (folder / "arm.toml").write_text(arm.toml())
    (folder / "recording.toml").write_text('robot = "arm.toml"\n')
    return read_recording(folder)


@pytest.mark.slow("0.08-0.0-False", "0.08-0.05-False", "0.08-0.0-True", "0.08-0.05-True")
@pytest.mark.parametrize("accelerations", [True, False])
@pytest.mark.parametrize(("ramp", "settle"), [(0.08, 0.0), (0.0, 0.05), (0.08, 0.05)])
def test_the_motion_of_a_pallet_whose_few_lines_are_alike_is_told_by_its_corners(
    ramp, settle, accelerations, tmp_path
):
    """Its joint moves meet a corner each: what they take beside their ramps is told by how alike each axis' are."""
    arm = next(arm for arm in all_arms() if arm.name == "heavy")
    moves = write_program(np.random.default_rng(6), arm, "palletising", 90, 1.7, 1.0)
    assert (moves.zone > 0).any()
    assert (moves.kind == JOINT).any()
    sim = seconds(moves, World(ramp=ramp, settle=settle, blend=1.0), arm)
    case = case_of(written(tmp_path, moves, arm, sim, accelerations)).case
    assert np.abs(case.base.duration() - sim).mean() < 5e-4
    if accelerations or not (
        ramp and settle
    ):  # four kinds of lines do not tell two times, a ramp and a corner
        assert case.base.accelerate[~case.joint] == pytest.approx(1.7, rel=0.02)


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
