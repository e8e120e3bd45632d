"""How fast and how right inverse kinematics is: `python bench/kinematics.py`. Exit status 1 when a figure is missed.

The path is smooth, of 100,000 poses, and takes R and T over several turns and B through zero. "All branches
tracked" means that each of the eight solutions is there for each pose, continuous from pose to pose. Times
are process CPU time, the median of seven runs; both layouts of the input are measured, the slower counts.
The independent libraries are py-opw-kinematics and EAIK, which the tests use too.
"""

from __future__ import annotations

import math
import statistics
import sys
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from tables import print_table

from olp.robots.kinematics import branches, forward, inverse, singularities, track, track_branches
from olp.robots.robot import Robot, load_robot

Array = NDArray[np.float64]

POSES = 100_000
RUNS = 7
ASKED_RATE = 1_000_000.0  # [poses/s]
ASKED_AGREEMENT = 1e-9  # [rad]
COMPARED = 2_000


def main() -> int:
    robot = load_robot("yaskawa/gp25")
    joints = smooth_joints()
    poses = forward(robot, joints)
    in_rows = tuple(np.ascontiguousarray(part) for part in poses)
    rate = min(poses_per_second(lambda p=p: track_branches(robot, *p)) for p in (poses, in_rows))
    tracked = track_branches(robot, *poses)
    jump = largest_jump(robot, tracked)
    opw, eaik = disagreement_with_opw(robot, tracked, poses), disagreement_with_eaik(robot, tracked, poses)
    held = rate >= ASKED_RATE and max(opw, eaik) <= ASKED_AGREEMENT
    print_table(
        ("figure", "asked", "measured"),
        [
            ("all 8 branches tracked", f">= {ASKED_RATE:,.0f} poses/s", f"{rate:,.0f} poses/s"),
            ("largest difference to py-opw-kinematics", f"{ASKED_AGREEMENT:.0e} rad", f"{opw:.1e} rad"),
            ("largest difference to EAIK", f"{ASKED_AGREEMENT:.0e} rad", f"{eaik:.1e} rad"),
            ("largest step of a tracked joint, away from singularities", "-", f"{jump:.1e} rad"),
            (
                "tracked branches against the joints that made the path",
                "-",
                f"{retraced(robot, joints):.1e} rad",
            ),
        ],
    )
    print("\nfor comparison, same path:\n")
    one = (0, 0, 0, 0, 0, 0)
    others = {
        "one branch by its flags": lambda: inverse(robot, *poses, one),
        "all 8 branches, untracked": lambda: branches(robot, *poses),
        "nearest branch from a start position": lambda: track(robot, *poses, joints[0]),
        "forward": lambda: forward(robot, joints),
    }
    print_table(("what", "poses/s"), [(k, f"{poses_per_second(f):,.0f}") for k, f in others.items()])
    return 0 if held else 1


def smooth_joints() -> Array:
    """(n, 6) [rad] in front of the GP25, well inside its limits."""
    u = np.linspace(0.0, 1.0, POSES)
    swings = (
        (0.05, 0.70, 7.0, 0.1), (0.35, 0.35, 11.0, 1.0), (-0.17, 0.26, 13.0, 0.7),
        (0.20, 3.30, 5.0, 0.3), (0.11, 1.05, 9.0, 0.4), (-0.30, 6.90, 3.0, 1.9),
    )  # fmt: skip
    return np.stack([mean + size * np.sin(rate * u + phase) for mean, size, rate, phase in swings], axis=1)


def poses_per_second(work: Callable[[], object]) -> float:
    work()
    times = []
    for _ in range(RUNS):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return POSES / statistics.median(times)


def largest_jump(robot: Robot, tracked: Array) -> float:
    """[rad] Largest step from pose to pose of any branch where no singularity is within 0.03."""
    largest = 0.0
    for number in range(8):
        joints = tracked[:, number]
        near = singularities(robot, joints, angle=0.03, length=0.03)
        calm = ~(near.wrist | near.elbow | near.shoulder) & ~np.isnan(joints[:, 0])
        steps = np.abs(np.diff(joints, axis=0)).max(axis=1)
        largest = max(largest, float(steps[calm[1:] & calm[:-1]].max(initial=0.0)))
    return largest


def retraced(robot: Robot, joints: Array) -> float:
    """[rad] Largest difference between the path's own joints and the branch tracked from its start."""
    return float(np.abs(track(robot, *forward(robot, joints), joints[0]) - joints).max())


def sample(robot: Robot, tracked: Array) -> NDArray[np.intp]:
    """Poses to compare: spread over the path, where joints are well-conditioned."""
    joints = np.nan_to_num(tracked[:, 0])
    near = singularities(robot, joints, angle=0.03, length=0.03)
    good = np.flatnonzero(~(near.wrist | near.elbow | near.shoulder))
    return good[np.linspace(0, len(good) - 1, COMPARED).astype(int)]


def largest_difference(ours: Array, theirs: Array) -> float:
    """[rad] Both ways over solutions (m, 6) of one pose, up to whole turns."""
    ours = ours[~np.isnan(ours[:, 0])]
    apart = ours[:, None, :] - theirs[None, :, :]
    apart = np.abs(apart - 2.0 * math.pi * np.rint(apart / (2.0 * math.pi))).max(axis=2)
    return float(max(apart.min(axis=0).max(), apart.min(axis=1).max()))


def disagreement_with_opw(robot: Robot, tracked: Array, poses: tuple[Array, Array]) -> float:
    from py_opw_kinematics import KinematicModel
    from py_opw_kinematics import Robot as OpwRobot
    from scipy.spatial.transform import RigidTransform

    assert robot.geometry is not None
    links = robot.geometry.links
    assert links is not None
    offsets, flips = (0.0, 0.0, -math.pi / 2, 0.0, 0.0, math.pi), (False, False, True, True, True, True)
    model = KinematicModel(links.a1, -links.a3, 0.0, 0.0, links.a2, links.d4, links.d6, offsets, flips)
    chosen = sample(robot, tracked)
    others = OpwRobot(model, degrees=False).reach(RigidTransform.from_matrix(matrices(poses, chosen))).joints
    pairs = zip(tracked[chosen], np.asarray(others), strict=True)
    return max(largest_difference(ours, theirs[~np.isnan(theirs[:, 0])]) for ours, theirs in pairs)


def disagreement_with_eaik(robot: Robot, tracked: Array, poses: tuple[Array, Array]) -> float:
    from eaik.IK_HP import HPRobot

    geometry = robot.geometry
    assert geometry is not None
    directions = np.array([joint.direction for joint in geometry.joints])
    offsets = np.array([*(joint.offset for joint in geometry.joints), geometry.flange_offset])
    other = HPRobot(directions, offsets)
    chosen = sample(robot, tracked)
    targets = matrices(poses, chosen)
    targets[:, :3, :3] = targets[:, :3, :3] @ np.array(geometry.flange_rotation).T
    worst = 0.0
    for ours, target in zip(tracked[chosen], targets, strict=True):
        solution = other.IK(target)
        exact = ~np.asarray(solution.is_LS, dtype=bool)
        worst = max(worst, largest_difference(ours, np.asarray(solution.Q)[exact]))
    return worst


def matrices(poses: tuple[Array, Array], chosen: NDArray[np.intp]) -> Array:
    result = np.tile(np.eye(4), (len(chosen), 1, 1))
    result[:, :3, 3], result[:, :3, :3] = poses[0][chosen], poses[1][chosen]
    return result


if __name__ == "__main__":
    sys.exit(main())
