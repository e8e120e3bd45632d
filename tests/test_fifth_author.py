"""The cases of `bench/fifth_author`: the same for a seed, read by olp; its arm and its ramps are where olp's are."""

import json

import numpy as np
import pytest

from bench.fifth_author.arm import forward, inverse, orientation, write_robot
from bench.fifth_author.cells import palletise
from bench.fifth_author.engine import Controller, SampledMove, chain_seconds, run
from bench.fifth_author.recorders import Dress, Recorder, write_head, write_table
from bench.fifth_author.score import judge
from bench.fifth_author.sealing import draw_arm, generate
from olp.identification.recorded_plan import case_of
from olp.identification.recording import read_recording
from olp.robots import kinematics
from olp.robots.robot import load_robot

SEED, CASES = 3, 2


def test_a_seed_makes_the_same_cases_and_olp_judges_their_moves(tmp_path):
    for folder in ("one", "two"):
        generate(tmp_path / folder, SEED, CASES)
    answers = (tmp_path / "one" / "answers.json").read_text()
    assert answers == (tmp_path / "two" / "answers.json").read_text()
    for name, truth in json.loads(answers).items():
        assert len(case_of(read_recording(tmp_path / "one" / name)).case) > 25
        row = judge(truth, {"findings": [], "verdict": "no-mismatch"}, "")
        assert row["exact"] is (truth["family"] in ("nothing", "outside"))


def test_positions_of_an_arm_are_those_of_olp_and_its_joints_lead_there(tmp_path):
    rng = np.random.default_rng(2)
    arm = draw_arm(rng)
    write_robot(arm, tmp_path / "arm.toml", accelerations=True)
    pose = np.array([0.7 * arm.reach, 0.1 * arm.reach, 0.1 * arm.reach, np.pi, 0.2, 0.3])
    joints = inverse(arm, pose[None, :3], orientation(pose[None, 3:]))
    assert forward(arm, joints)[0][0] == pytest.approx(pose[:3], abs=1e-6)
    flange = kinematics.forward(load_robot(str(tmp_path / "arm.toml")), joints)[0][0] * 1000.0
    along = orientation(pose[None, 3:])[0][:, 2]
    assert flange + arm.tool * along == pytest.approx(pose[:3], abs=1e-6)


def test_a_move_between_stops_takes_what_constant_acceleration_takes():
    cells = np.full(32, 400.0 / 32)
    limit = np.full(32, 1.0)
    move = SampledMove(cells, 500.0 * limit, 2000.0 * limit, 1000.0 * limit, np.inf, 0.0)
    ramps = 500.0 / 2000.0 + 500.0 / 1000.0
    cruise = (400.0 - 0.5 * 500.0 * ramps) / 500.0
    assert chain_seconds([move], []) == [pytest.approx(ramps + cruise, rel=1e-9)]


@pytest.mark.parametrize("smooth", [True, False])
def test_joint_moves_between_lines_ramp_as_the_lines_do_where_that_makes_their_accelerations_alike(
    smooth, tmp_path
):
    """A controller that knows no corner between a line and a joint move stops there, with ramps of one law."""
    rng = np.random.default_rng(8)
    arm = draw_arm(rng)
    programs = (palletise(np.random.default_rng(seed), arm, 40) for seed in range(20))
    moves = next(
        some for some in programs if some[0].blend == 0 and some[2].kind == "joint" and some[2].blend
    )
    controller = Controller(3500.0, arm.speeds, arm.accelerations, ramp_time=0.06, s_curve=smooth)
    sim = run(moves, [controller] * len(moves), arm)
    dress = Dress(True, True, False, True, False, False, True, "file", 4, False)
    write_table(rng, tmp_path, moves, sim, sim, dress, 3500.0)
    write_head(tmp_path, Recorder("white", 1e-4, False), dress, arm, rng)
    case = case_of(read_recording(tmp_path)).case
    assert np.abs(case.base.duration() - sim).max() < 5e-4
    assert case.base.accelerate[~case.joint] == pytest.approx(3.5, rel=1e-3)
    leading = np.argmax(np.abs(case.rates.path[case.joint, 0]), axis=1)
    for axis in np.unique(leading).tolist():
        own = case.base.accelerate[case.joint][leading == axis]
        assert own == pytest.approx(arm.accelerations[axis], rel=0.02)
