"""Acceleration laws: promises of every law, and the by-pose law against measured poses of an MA2010."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np
import pytest

from olp.core.diagnostic import OlpError
from olp.robots.robot import load_robot
from olp.timing.acceleration import law_names, load_law
from olp.timing.blending.yaskawa import FILTER_TIME

EVERY_LAW = pytest.mark.parametrize("name", law_names())
MA2010 = load_robot("yaskawa/ma2010")


def poses() -> tuple[np.ndarray, np.ndarray]:
    """Joints (n, 6) [rad] and measured (n, 5) [rad/s²]: S, L+, L-, U+, U-."""
    text = (Path(__file__).parent / "data" / "ma2010_poses.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))
    joints = np.zeros((len(rows), 6))
    joints[:, 1], joints[:, 2] = [float(r["lean_rad"]) for r in rows], [float(r["lift_rad"]) for r in rows]
    return joints, np.array([[float(v) for v in list(r.values())[2:]] for r in rows])


@EVERY_LAW
def test_a_law_gives_a_positive_acceleration_or_says_that_it_does_not_know(name):
    law = load_law(name)
    joints = np.random.default_rng(3).uniform(-2.0, 2.0, (50, 6))
    for robot in (MA2010, load_robot("yaskawa/gp25")):
        values = law.accelerations(robot, joints, np.ones(6))
        assert values.shape == (50, 6)
        known = np.isfinite(values)
        assert np.all(values[known] > 0)
        assert known[:, :3].any() == law.knows(robot)
    if name in ("constant", "time_constant", "by_pose"):
        assert law.knows(MA2010)
    assert law.summary
    assert len(law.source) > 10


@EVERY_LAW
def test_no_direction_means_the_lower_of_both(name):
    law, (joints, _) = load_law(name), poses()
    forth, back, none = (law.accelerations(MA2010, joints, sign) for sign in (1.0, -1.0, 0.0))
    assert np.allclose(none, np.minimum(forth, back), equal_nan=True)


def test_the_by_pose_law_is_near_every_measured_pose_and_a_constant_is_not():
    joints, measured = poses()
    law = load_law("by_pose")
    up, down = law.accelerations(MA2010, joints, 1.0), law.accelerations(MA2010, joints, -1.0)
    told = np.stack([up[:, 0], up[:, 1], down[:, 1], up[:, 2], down[:, 2]], axis=1)
    rms = np.sqrt(np.mean((told - measured) ** 2, axis=0))
    spread = measured.std(axis=0)
    assert rms[0] < 0.45
    assert np.all(rms < 0.42)
    assert np.all(spread > 2.5 * rms)


def test_gravity_helps_where_the_arm_leans_forward():
    law = load_law("by_pose")
    forward = np.array([0.0, 1.2, 1.0, 0.0, 0.0, 0.0])
    plus, minus = (law.accelerations(MA2010, forward, sign)[0] for sign in (1.0, -1.0))
    assert plus[1] > minus[1] + 0.5  # leaning further forward
    assert minus[2] > plus[2] + 0.3  # letting the forearm down
    assert plus[0] == minus[0]


def test_an_outstretched_arm_turns_more_slowly():
    law = load_law("by_pose")
    folded, stretched = [0, -0.4, 0.6, 0, 0, 0], [0, 1.3, 1.3, 0, 0, 0]
    assert law.accelerations(MA2010, folded, 0)[0, 0] > 1.8 * law.accelerations(MA2010, stretched, 0)[0, 0]


def test_outside_the_measured_poses_the_law_stays_within_what_was_measured():
    joints = np.random.default_rng(5).uniform(-3.1, 3.1, (500, 6))
    values = load_law("by_pose").accelerations(MA2010, joints, 0)[:, :3]
    assert np.all(values >= [5.87, 3.95, 7.38])
    assert np.all(values <= [13.92, 10.34, 11.31])


def test_the_slowest_axis_limits_the_path():
    law = load_law("constant")
    rates = np.array([[0.1, -0.5, 0.2, 0.0, 0.0, 3.0]])
    limit, axis = law.along_path(MA2010, np.zeros((1, 6)), rates)
    assert axis[0] == 1  # axis T is faster per metre, but its acceleration is not known
    assert limit[0] == pytest.approx(MA2010.accelerations[1] / 0.5)


def test_the_pose_explains_why_the_800_mm_s_run_begins_more_slowly():
    """Start of the published corner runs: axis L would need 6.2 rad/s² for the 4.8 m/s² of the acceleration filter."""
    here = [[-0.472, 0.677, 0.364, 0.148, -0.896, -0.385]]
    rates = [[0.317, -1.282, -1.841, 0.207, 0.509, -0.487]]
    limit, axis = load_law("by_pose").along_path(MA2010, here, rates)
    assert axis[0] == 1
    assert 3.5 < limit[0] < 0.8 / FILTER_TIME


def test_what_was_measured_on_an_arm_stands_in_its_file(tmp_path):
    text = Path("olp/robots/yaskawa/ma2010.toml").read_text(encoding="utf-8").replace('"MA2010"', '"Own"')
    own = load_robot(written(tmp_path, text))
    joints, _ = poses()
    for name in ("by_pose", "time_constant"):
        law = load_law(name)
        assert law.knows(own)
        assert np.array_equal(law.accelerations(own, joints, 1), law.accelerations(MA2010, joints, 1), True)
    shorter = load_robot(written(tmp_path, text.replace("filter_s = 0.15", "filter_s = 0.1")))
    assert np.allclose(load_law("time_constant").accelerations(shorter, joints[:1], 1), own.speeds / 0.1)
    assert MA2010.acceleration_filter == FILTER_TIME


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("ahead_m = 0.91025, ", ""), "swing needs ahead_m"),
        (("ahead_m = 0.91025", "ahead_mm = 910.25"), "swing has no key 'ahead_mm'"),
        (("gravity = [0.0897, ", "gravity = ["), "gravity must be 4 numbers"),
        (("width = 0.05004", "width = 0"), "width above 0"),
        (("lowest_rad_s2 = [5.87", "lowest_rad_s2 = [15.87"), "below that of highest_rad_s2"),
        (("highest_rad_s2 = [13.92, 10.34, 11.31]", ""), "needs highest_rad_s2"),
        (("lift = {", "lifts = {"), "needs lift"),
        (('pose_accelerations = "', 'pose = "'), "no source is stated for: pose_accelerations"),
    ],
)
def test_wrong_numbers_of_an_arm_are_told(tmp_path, change, says):
    text = Path("olp/robots/yaskawa/ma2010.toml").read_text(encoding="utf-8")
    lines = [line for line in text.split("\n") if not line.startswith("pose = ")]
    text = "\n".join(lines).replace("pose_verified = true", "pose_verified = false")
    assert change[0] in text
    with pytest.raises(OlpError, match=re.escape(says)):
        load_robot(written(tmp_path, text.replace(*change)))


def written(folder: Path, text: str) -> Path:
    path = folder / "own.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_unknown_laws_and_wrong_points_are_told():
    with pytest.raises(OlpError, match=r"by_torque(.|\n)*by_pose"):
        load_law("by_torque")
    with pytest.raises(OlpError, match="6 axes"):
        load_law("constant").accelerations(MA2010, np.zeros((3, 5)), 1.0)
