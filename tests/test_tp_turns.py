"""FANUC's turn numbers: which angles of J4, J5 and J6 they mean, over two turns to either side."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_arm_branch import GP25, rotation_vector
from tp_listings import listing, read

import olp
from olp.robots.geometry import Pose
from olp.robots.kinematics import configuration_of, forward
from olp.transpile import Context
from olp.transpile.compare import steps_of
from olp.transpile.convert import convert, run_converted

WIDE = replace(
    GP25,
    axes=(*GP25.axes[:3], *(replace(axis, lower=-13.0, upper=13.0) for axis in GP25.axes[3:])),
)
STANDS = (12.5, 7.25, -18.0, 31.0, -52.0, 24.0)  # [deg]
POSITION = """P[{number}]{{
   GP1:
\tUF : 0, UT : 0,\t\tCONFIG : '{config}',
\tX = {0:.6f}  mm,\tY = {1:.6f}  mm,\tZ = {2:.6f}  mm,
\tW = {3:.7f} deg,\tP = {4:.7f} deg,\tR = {5:.7f} deg
}};
"""


def turn(angle):
    """As the manual says it: 0 from -179 to 179, 1 from 180 to 539, -1 from -539 to -180, and so on. [deg]"""
    number = 0
    while angle >= 180.0:
        angle, number = angle - 360.0, number + 1
    while angle <= -180.0:
        angle, number = angle + 360.0, number - 1
    return number


def poses(joints):
    """The positions of a listing at which an arm stands with these joints (n, 6) [deg]."""
    angles = np.radians(joints)
    flags = configuration_of(WIDE, angles)
    rows = []
    for number, (row, (wrist, elbow, front)) in enumerate(zip(joints, flags[:, :3], strict=True), 1):
        position, rotation = forward(WIDE, np.radians([row]))
        xyz = Pose(position[0], rotation[0]).xyz_angles()
        words = f"{'FN'[wrist]} {'UD'[elbow]} {'TB'[front]}"
        config = ", ".join([words, *(str(turn(angle)) for angle in row[3:])])
        numbers = [*(xyz[:3] * 1e3), *np.degrees(xyz[3:])]
        rows.append(POSITION.format(*numbers, number=number, config=config))
    return "".join(rows)


def program(joints):
    moves = [f"J P[{n}] 20% FINE" for n in range(1, len(joints) + 1)]
    found = read(listing(*moves, positions=poses(joints)))
    assert not [one.render() for one in found.diagnostics if one.is_error]
    return found


def wound(axis):
    """One axis anywhere within two turns, the others at the same place; not where the wrist is stretched."""
    angles = [a for a in np.arange(-716.0, 717.0, 11.0) if axis != 4 or abs(np.sin(np.radians(a))) > 0.1]
    rows = np.tile(STANDS, (len(angles), 1))
    rows[:, axis] = angles
    return rows


@pytest.mark.parametrize("axis", [3, 4, 5])
def test_every_turn_of_an_axis_is_read_as_the_manual_counts_it(axis):
    joints = wound(axis)
    plan = program(joints).plan(robot=WIDE)
    found = np.degrees(plan.positions.axes[plan.moves.target][:, :6])
    np.testing.assert_allclose(found, joints, atol=1e-4)


def test_turns_of_several_axes_at_once_are_read_and_come_back():
    numbers = np.random.default_rng(5)
    joints = np.tile(STANDS, (60, 1)) + numbers.uniform(-8, 8, (60, 6))
    joints[:, 3:] += 360.0 * numbers.integers(-1, 2, (60, 3))
    source = program(joints)
    plan = source.plan(robot=WIDE)
    np.testing.assert_allclose(np.degrees(plan.positions.axes[plan.moves.target][:, :6]), joints, atol=1e-4)
    for target in ("rapid", "urscript"):
        made = convert(source, target, Context(robot=WIDE))
        named = {loss.line for loss in made.translated.losses if loss.part == "configuration"}
        told = steps_of(run_converted(made, target, WIDE, source))
        for step, there in zip(told, steps_of(plan), strict=True):
            assert np.allclose(step.axes[:6], there.axes[:6], atol=1e-5) or there.line in named


@pytest.mark.parametrize("angle", [-700, -430, 181, 400, 530, 541, 700])
def test_a_turn_that_is_written_is_the_one_that_is_read(angle, tmp_path):
    """Out of a language that tells joint values, into FANUC's pose and flags, and through its reader."""
    joints = np.radians([*STANDS[:5], float(angle)])
    position, rotation = forward(WIDE, joints[None])
    numbers = [*position[0], *rotation_vector(rotation[0])]
    pose, near = (", ".join(f"{v:.12f}" for v in row) for row in (numbers, joints))
    path = tmp_path / "wound.script"
    path.write_text(
        "def wound():\n  movej([0.2, 0.1, -0.3, 0.5, -0.9, 0.4])\n"
        f"  movej(get_inverse_kin(p[{pose}], qnear=[{near}]))\nend\n"
    )
    source = olp.read(path)
    made = convert(source, "tp", Context(robot=WIDE))
    assert f"{turn(angle)}'" in made.files[made.main].decode()
    assert not [loss for loss in made.translated.losses if loss.part == "configuration"]
    plan = run_converted(made, "tp", WIDE, source)
    np.testing.assert_allclose(plan.positions.axes[plan.moves.target][-1][:6], joints, atol=1e-5)
