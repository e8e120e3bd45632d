"""Arm flags in every language's own way of counting: written from the joint angles, and read back to the same ones."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from test_arm_branch import GP25, rotation_vector
from translate_programs import own_program, round_trip, written

import olp
from olp.ir.program import Path
from olp.languages.vendor import ArmFlags
from olp.languages.vendors.krl import values as krl
from olp.languages.vendors.rapid.literals import arm, confdata
from olp.robots.geometry import Pose
from olp.robots.kinematics import configuration_of, forward
from olp.transpile import Context
from olp.transpile.arm_flags import flags_of
from olp.transpile.compare import steps_of
from olp.transpile.convert import convert, run_converted
from olp.transpile.pipeline import canonical

START = np.radians([5.5, -12.25, 18.75, 3.5, -47.25, 21.0])


def some_joints(count, seed):
    """Anywhere inside the limits, T up to almost a turn, away from singularities."""
    joints = np.random.default_rng(seed).uniform(GP25.lower, np.minimum(GP25.upper, 6.1), (8 * count, 6))
    joints[:, 5] = np.clip(joints[:, 5], -6.1, 6.1)
    from olp.robots.kinematics import singularities

    near = singularities(GP25, joints, angle=0.1, length=0.05)
    return joints[~(near.wrist | near.elbow | near.shoulder)][:count]


def script(tmp_path, rows):
    path = tmp_path / "stands.script"
    path.write_text("\n".join(["def stands():", *(f"  {row}" for row in rows), "end", "stands()", ""]))
    return olp.read(path)


def near_to(joints):
    position, rotation = forward(GP25, joints)
    numbers = ", ".join(f"{v:.15f}" for v in [*position[0], *rotation_vector(rotation[0])])
    return f"movej(get_inverse_kin(p[{numbers}], qnear={list(map(float, joints))}), a=1.4, v=0.5)"


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "tp"])
def test_a_pose_is_reached_with_the_same_axes_in_every_language(target, tmp_path):
    joints = some_joints(25, seed=4)
    program = script(tmp_path, [f"movej({list(map(float, START))})", *map(near_to, joints)])
    made = convert(program, target, Context(robot=GP25))
    assert not [loss for loss in made.translated.losses if loss.part == "configuration"]
    plan = run_converted(made, target, GP25, program)
    found = plan.positions.axes[plan.moves.target][1:, :6]
    np.testing.assert_allclose(found, joints, atol=1e-5)
    # And none of them is the one that an arm without flags would take.
    assert len(found) == len(joints)


def in_front_of(joints, first, name):
    """The same move, its pose written as the product of a named pose and another one."""
    position, rotation = forward(GP25, joints)
    rest = first.inverse() @ Pose(position[0], rotation[0])
    numbers = ", ".join(f"{v:.15f}" for v in [*rest.position, *rotation_vector(rest.rotation)])
    pose = f"pose_trans({name}, p[{numbers}])"
    return f"movej(get_inverse_kin({pose}, qnear={list(map(float, joints))}), a=1.4, v=0.5)"


FEATURE = Pose.from_xyz_angles([0.61, -0.12, 0.23, 0.21, -0.34, 0.93])


def named_pose(name, pose):
    numbers = ", ".join(f"{v:.15f}" for v in [*pose.position, *rotation_vector(pose.rotation)])
    return f"global {name} = p[{numbers}]"


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "tp"])
def test_a_pose_in_a_frame_that_urscript_tells_joints_for_keeps_its_frame_and_its_flags(target, tmp_path):
    joints = some_joints(12, seed=6)
    rows = [named_pose("feature", FEATURE), f"movej({list(map(float, START))})"]
    program = script(tmp_path, [*rows, *(in_front_of(one, FEATURE, "feature") for one in joints)])
    made = convert(program, target, Context(robot=GP25))
    assert not [loss for loss in made.translated.losses if loss.part == "configuration"]
    assert not any(
        word in data for data in made.files.values() for word in (b"PoseMult", b"MULMAT", b"Offset")
    )
    plan = run_converted(made, target, GP25, program)
    np.testing.assert_allclose(plan.positions.axes[plan.moves.target][1:, :6], joints, atol=1e-5)


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "tp"])
def test_a_pose_off_a_waypoint_is_reached_with_the_same_axes_or_the_receipt_names_it(target, tmp_path):
    joints = some_joints(12, seed=7)
    rows = [named_pose("start_p", FEATURE), "movel(start_p)", f"movej({list(map(float, START))})"]
    program = script(tmp_path, [*rows, *(in_front_of(one, FEATURE, "start_p") for one in joints)])
    made = convert(program, target, Context(robot=GP25))
    named = {loss.line for loss in made.translated.losses if loss.part == "configuration"}
    ends = steps_of(run_converted(made, target, GP25, program))[-len(joints) :]
    for line, (step, wanted) in enumerate(zip(ends, joints, strict=True), 5):
        assert line in named or np.allclose(step.axes[:6], wanted, atol=1e-5), line
    if target == "rapid":  # PoseMult gives no flags: the controller is told not to look at them
        text = made.files[made.main].decode("latin-1")
        assert len(named) == len(joints)
        assert "ConfJ \\Off;" in text
    else:
        assert not named


@pytest.mark.parametrize("source", ["inform", "krl", "rapid", "tp"])
@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "tp", "urscript"])
def test_flags_go_from_language_to_language(source, target, tmp_path):
    if source == target:
        return
    joints = some_joints(8, seed=9)
    program = script(tmp_path, [f"movej({list(map(float, START))})", *map(near_to, joints)])
    first = convert(program, source, Context(robot=GP25))
    for name, data in first.files.items():
        (tmp_path / name).write_bytes(data)
    middle = olp.read(tmp_path / first.main, vendor=source)
    made = convert(middle, target, Context(robot=GP25))
    plan = run_converted(made, target, GP25, middle)
    np.testing.assert_allclose(plan.positions.axes[plan.moves.target][1:, :6], joints, atol=1e-5)


def test_confdata_counts_quarters_and_the_manuals_eight_cases():
    """cfx: 0 in front, in front, positive; 1 axis 5 negative; 2 behind the lower arm; 4 behind axis 1."""
    joints = some_joints(200, seed=2)
    flags = configuration_of(GP25, joints)
    for row, arm_flags, (arm_written, sectors) in zip(
        joints, flags, flags_of(GP25, joints, ArmFlags.QUARTERS), strict=True
    ):
        cf1, cf4, cf6, cfx = map(int, confdata(arm_written, sectors).split(","))
        for quarter, axis in ((cf1, 0), (cf4, 3), (cf6, 5)):
            assert quarter * 90 <= np.degrees(row[axis]) < (quarter + 1) * 90
        # Axis 5 of ABB's arms turns against Yaskawa's B: negative where B is positive.
        assert cfx == 4 * arm_flags[2] + 2 * arm_flags[1] + (row[4] > 0)
        read, quarters, _ = arm((cf1, cf4, cf6, cfx))
        assert read[:3] == tuple(arm_flags[:3])
        assert [bool(turn) for turn in read[3:]] == [bool(flag) for flag in arm_flags[3:]]
        np.testing.assert_allclose(quarters, sectors)


def test_turn_bits_are_the_signs_of_the_axes():
    for row, (flags, sectors) in zip(
        some_joints(100, 6), flags_of(GP25, some_joints(100, 6), ArmFlags.SIGNS), strict=True
    ):
        turn = krl.turn(sectors)
        assert [turn >> n & 1 for n in range(6)] == [int(value < 0) for value in row]
        assert krl.signs(turn) == sectors
        assert krl.flags(krl.status(flags))[:3] == flags[:3]


def test_fanuc_counts_turns_with_their_sign():
    joints = np.radians([[0, 0, 0, 181, -50, -190], [0, 0, 0, -179, -50, 355], [0, 0, 0, 10, -50, 541]])
    turns = [flags[3:6] for flags, _ in flags_of(GP25, joints, ArmFlags.COUNTED)]
    assert turns == [(1, -1, 0), (0, 1, 0), (0, 2, 0)]


MODULE = """MODULE way
  PROC main()
    {watch}
    MoveAbsJ [[5.5,-12.25,18.75,3.5,-47.25,21],[9E9,9E9,9E9,9E9,9E9,9E9]],v500,fine,tool0;
    MoveJ [[{place}],[{turn}],[{conf}],[9E9,9E9,9E9,9E9,9E9,9E9]],v500,fine,tool0;
  ENDPROC
ENDMODULE
"""


def rapid(tmp_path, joints, conf, watch=""):
    from scipy.spatial.transform import Rotation

    position, rotation = forward(GP25, joints)
    x, y, z, w = Rotation.from_matrix(rotation[0]).as_quat()
    place = ",".join(f"{value * 1000:.9f}" for value in position[0])
    text = MODULE.format(
        watch=watch, place=place, turn=",".join(f"{v:.12f}" for v in (w, x, y, z)), conf=conf
    )
    path = tmp_path / "way.mod"
    path.write_text(text)
    plan = olp.read(path).plan(robot=GP25)
    return plan.positions.axes[plan.moves.target[1]][:6], [one.says for one in plan.assumptions]


def test_a_robtarget_is_reached_as_its_confdata_says(tmp_path):
    joints = np.radians([20, -5, 10, -170, 40, 200])  # flipped against the start
    found, _ = rapid(tmp_path, joints, "0,-2,2,1")
    np.testing.assert_allclose(found, joints, atol=1e-6)


def test_a_confdata_that_cannot_be_leaves_the_nearest_axes_and_is_told(tmp_path):
    joints = np.radians([20, -5, 10, -170, 40, 200])
    found, says = rapid(tmp_path, joints, "3,0,0,0")
    assert np.abs(found - START).max() < np.radians(60)
    assert any("arm configuration" in text for text in says)


def test_confj_off_leaves_the_nearest_axes(tmp_path):
    joints = np.radians([20, -5, 10, -170, 40, 200])
    found, says = rapid(tmp_path, joints, "0,-2,2,1", "ConfJ \\Off;")
    assert np.abs(found - START).max() < np.radians(60)
    assert not any("arm configuration" in text for text in says)


def test_without_a_robot_rapid_is_told_not_to_watch_joint_moves(tmp_path):
    path = tmp_path / "way.src"
    rows = [
        "DEF way( )", "$TOOL=$NULLFRAME", "$BASE=$NULLFRAME", "$VEL.CP=0.2", "BAS(#VEL_PTP,50)",
        "LIN {X 900,Y 0,Z 500,A 0,B 90,C 0}", "PTP {X 950,Y 0,Z 500,A 0,B 90,C 0,S 2,T 10}", "END", "",
    ]  # fmt: skip
    path.write_text("\n".join(rows))
    program = olp.read(path)
    made = convert(program, "rapid", Context(robot=GP25))
    assert "ConfJ" not in made.files[made.main].decode()
    # An arm without flags takes the nearest in every language: nothing is lost.
    other = olp.robots.robot.load_robot("universal-robots/ur10e")
    made = convert(program, "rapid", Context(robot=other))
    assert "ConfJ \\Off;" in made.files[made.main].decode()
    assert not [loss for loss in made.translated.losses if loss.part == "configuration"]
    for target in ("rapid", "urscript"):
        losses = canonical(program, target, Context()).losses
        assert [loss.line for loss in losses if loss.part == "configuration"] == [7]


JOB = """/JOB
//NAME TURNS
//POS
///NPOS 2,0,0,0,0,0
///TOOL 0
///POSTYPE BASE
///RECTAN
///RCONF 1,0,0,0,1,0
C00000=900.000,100.000,400.000,180.0000,0.0000,10.0000
///RCONF 1,0,0,0,0,0
C00001=950.000,100.000,400.000,180.0000,0.0000,10.0000
//INST
///DATE 2026/03/02 14:07
///ATTR SC,RW
///GROUP1 RB1
NOP
MOVJ C00000 VJ=50.00
MOVJ C00001 VJ=50.00
END
"""


@pytest.mark.parametrize("target", ["krl", "tp"])
def test_without_a_robot_turns_are_in_the_receipt(target, tmp_path):
    path = tmp_path / "TURNS.JBI"
    path.write_bytes(JOB.replace("\n", "\r\n").encode())
    program = olp.read(path)
    made = convert(program, target, Context())
    found = [loss for loss in made.translated.losses if loss.part == "configuration"]
    assert [loss.line for loss in found] == [17]
    made = convert(program, target, Context(robot=GP25))
    assert not [loss for loss in made.translated.losses if loss.part == "configuration"]


def test_the_first_pose_without_flags_is_an_assumption(tmp_path):
    program = script(tmp_path, ["movel(p[0.9, 0, 0.5, 0, 3.14, 0])", "movel(p[0.9, 0.1, 0.5, 0, 3.14, 0])"])
    says = [one.says for one in program.plan(robot=GP25).assumptions]
    assert sum("first pose" in text for text in says) == 1
    assert not any("first pose" in one.says for one in program.plan().assumptions)


WOUND = [-430, 430, -600, 700, -275]


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "tp"])
@pytest.mark.parametrize("turn", WOUND)
def test_what_no_flag_can_say_is_in_the_receipt_with_its_size(target, turn, tmp_path):
    joints = np.radians([10, 5, -20, 15, -50, turn])
    program = script(tmp_path, [f"movej({list(map(float, START))})", near_to(joints)])
    arm = replace(GP25, axes=(*GP25.axes[:5], replace(GP25.axes[5], lower=-13.0, upper=13.0)))
    made = convert(program, target, Context(robot=arm))
    found = [(loss.line, loss.size) for loss in made.translated.losses if loss.part == "configuration"]
    plan = run_converted(made, target, arm, program)
    stands = np.degrees(plan.positions.axes[plan.moves.target[1]][:6])
    off = float(np.abs(stands - np.degrees(joints)).max())
    assert found == ([] if off < 0.01 else [(3, round(off, 3))])
    if target == "rapid" or turn == -275:
        assert not found
    if target in ("inform", "krl") and turn in (-430, 430):
        assert off == pytest.approx(360.0)


@pytest.mark.parametrize("source", ["rapid", "tp", "urscript"])
@pytest.mark.parametrize("target", ["inform", "krl"])
def test_axes_differ_only_where_the_receipt_says_so(source, target, tmp_path):
    """Random program 26: RAPID's last axis comes to stand at -427 deg."""
    one = own_program(26, source, tmp_path / "a", GP25)
    made = convert(one, target, Context(robot=GP25))
    two = written(made, target, tmp_path / "b")
    # Joint moves only: an arc is one step in one language and several in another.
    steps = [[s for s in steps_of(p.plan(robot=GP25)) if s.path is Path.JOINT] for p in (one, two)]
    sizes = {loss.line: loss.size for loss in made.translated.losses if loss.part == "configuration"}
    assert sizes
    for a, b in zip(*steps, strict=True):
        off = np.degrees(np.abs(np.array(a.axes[:6]) - np.array(b.axes[:6])).max())
        assert off == pytest.approx(sizes.get(a.line, 0.0), abs=0.01)
    assert round_trip(26, source, target, GP25) == []


def test_a_wound_axis_that_is_given_by_its_joint_values_is_exact(tmp_path):
    program = script(tmp_path, [f"movej({list(map(math.radians, [10, 5, -20, 15, -50, -430]))})"])
    for target in ("inform", "krl", "rapid", "tp"):
        made = convert(program, target, Context(robot=GP25))
        assert not [loss for loss in made.translated.losses if loss.part == "configuration"]
        plan = run_converted(made, target, GP25, program)
        assert np.degrees(plan.positions.axes[plan.moves.target[0]][5]) == pytest.approx(-430, abs=1e-3)
