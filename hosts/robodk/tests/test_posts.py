"""The posts, driven as RoboDK drives them; poses compared with the conversions of RoboDK's own library."""

from __future__ import annotations

import importlib
import inspect
import re
from pathlib import Path
from typing import Any

import generated
import pytest
from robodk import robomath

import olp

ROBOT = "yaskawa/gp25"
VENDORS = {"inform": ".JBI", "krl": ".src", "rapid": ".mod", "tp": ".ls", "urscript": ".script"}
NUMBER = r"(-?\d+(?:\.\d+)?(?:[eE]-?\d+)?)"


def post(vendor: str, **settings: Any) -> Any:
    """A new post of that language, as RoboDK makes it."""
    base = importlib.import_module(f"olp_{vendor}").RobotPost
    kind = type("RobotPost", (base,), {"ROBOT": ROBOT, **settings})
    return kind("olp", "a robot of the station", 6, axes_type=["R"] * 6, ip_com="127.0.0.1", api_port=20500)


def written(vendor: str, folder: Path, drive: Any = generated.calls, **settings: Any) -> tuple[Any, str]:
    """The post after its work, and the text of all its files."""
    made = post(vendor, **settings)
    drive(made)
    made.ProgSave(str(folder), "Main")
    return made, "\n".join(Path(name).read_text() for name in made.PROG_FILES)


def numbers(pattern: str, text: str) -> list[list[float]]:
    """All places of `pattern`, in which # stands for a number."""
    regex = re.compile(re.escape(pattern).replace(r"\#", r"\s*" + NUMBER).replace(r"\ ", r"\s*"))
    return [[float(value) for value in found] for found in regex.findall(text)]


def quaternion(values: list[float]) -> Any:
    pose = robomath.quaternion_2_pose(values[3:])
    pose.setPos(values[:3])
    return pose


def from_metres(values: list[float]) -> Any:
    return robomath.UR_2_Pose([*(1000 * v for v in values[:3]), *values[3:]])


# How each language writes a pose, and RoboDK's own reading of it.
READ: dict[str, tuple[str, Any]] = {
    "inform": (r"=#,#,#,#,#,#", robomath.Motoman_2_Pose),
    "krl": ("X #,Y #,Z #,A #,B #,C #", robomath.KUKA_2_Pose),
    "rapid": ("[#,#,#],[#,#,#,#]", quaternion),
    "tp": ("X = # mm, Y = # mm, Z = # mm, W = # deg, P = # deg, R = # deg", robomath.Fanuc_2_Pose),
    "urscript": ("p[#,#,#,#,#,#]", from_metres),
}


def same(one: Any, other: Any, mm: float = 6e-4, turn: float = 2e-6) -> bool:
    ways = [abs(one[i, j] - other[i, j]) for i in range(3) for j in range(4)]
    return all(way < (mm if place % 4 == 3 else turn) for place, way in enumerate(ways))


@pytest.mark.parametrize("vendor", VENDORS)
def test_every_pose_is_the_one_that_robodks_own_conversion_reads(vendor, tmp_path):
    _, text = written(vendor, tmp_path)
    pattern, read = READ[vendor]
    found = [read(values) for values in numbers(pattern, text)]
    for pose in generated.POSES:
        assert any(same(pose, other) for other in found), robomath.pose_2_xyzrpw(pose)
    if vendor not in ("tp", "inform"):  # these write tools and frames element by element, or by three points
        for pose in (generated.TOOL, generated.FRAME):
            assert any(same(pose, other) for other in found)


@pytest.mark.parametrize("vendor", VENDORS)
def test_the_program_does_what_robodk_said(vendor, tmp_path):
    made, _ = written(vendor, tmp_path)
    assert Path(made.PROG_FILES[0]).suffix == VENDORS[vendor]
    program = olp.read(made.PROG_FILES[0])
    plan = program.plan(robot=ROBOT)
    assert not [
        d for d in (*program.diagnostics, *plan.diagnostics) if d.is_error and "MYCODE" not in d.source_line
    ]
    kinds = [(step.path.value, round(step.length * 1000)) for step in plan.steps() if hasattr(step, "path")]
    assert [kind for kind, length in kinds if length] in (
        ["linear", "linear", "circular", "linear", "joint"],
        ["linear", "linear", "circular", "circular", "linear", "joint"],  # INFORM: an arc is two statements
    )
    assert any(getattr(step, "duration", 0) == pytest.approx(0.35) for step in plan.steps())
    joints = plan.positions.axes[plan.moves.target[0]] * 180 / robomath.pi
    assert joints.tolist() == pytest.approx(generated.JOINTS, abs=1e-3)


@pytest.mark.parametrize("vendor", VENDORS)
def test_the_log_has_the_time_of_each_line_and_of_the_whole(vendor, tmp_path):
    made, _ = written(vendor, tmp_path)
    table = olp.read(made.PROG_FILES[0]).plan(robot=ROBOT).time()
    (total,) = re.findall(r"predicted: (\d+\.\d+) s, yaskawa/gp25", made.LOG)
    assert float(total) == pytest.approx(table["duration_s"].sum(), abs=0.0006)
    for row in table.itertuples():
        if row.duration_s:
            assert f"line {row.line}: {row.duration_s:.3f} s" in made.LOG


@pytest.mark.parametrize("vendor", VENDORS)
def test_the_users_own_code_stands_word_for_word_and_calls_are_calls(vendor, tmp_path):
    _, text = written(vendor, tmp_path)
    assert len(re.findall(r"(?m)^[\s\d:]*MYCODE 1,2\s*;?\s*$", text)) == 1
    assert "OLPCODE" not in text
    assert re.search(r"(?i)\b(CALL )?(JOB:)?SUB\b", text)


@pytest.mark.parametrize("vendor", VENDORS)
def test_all_posts_have_all_of_robodks_methods(vendor):
    signatures = {
        name: list(inspect.signature(thing).parameters)[1:]
        for name, thing in inspect.getmembers(
            importlib.import_module(f"olp_{vendor}").RobotPost, inspect.isfunction
        )
    }
    asked = {
        "ProgStart": 1, "ProgFinish": 1, "ProgSave": 4, "ProgSendRobot": 4, "MoveJ": 3, "MoveL": 3, "MoveC": 6,
        "setFrame": 3, "setTool": 3, "Pause": 1, "setSpeed": 1, "setAcceleration": 1, "setSpeedJoints": 1,
        "setAccelerationJoints": 1, "setZoneData": 1, "setDO": 2, "setAO": 2, "waitDI": 3, "RunCode": 2,
        "RunMessage": 2, "addline": 1, "addlog": 1,
    }  # fmt: skip
    assert {name: len(signatures[name]) for name in asked} == asked


def test_what_the_target_cannot_say_is_in_the_log(tmp_path):
    made, _ = written("inform", tmp_path)
    assert "approximated: call 12, MoveL(" in made.LOG
    assert "acceleration is left out" in made.LOG


def test_a_move_without_a_pose_is_told_and_the_rest_is_written(tmp_path):
    def drive(made: Any) -> None:
        made.ProgStart("Main")
        made.MoveL(None, generated.JOINTS)
        made.MoveJ(None, generated.JOINTS)
        made.ProgFinish("Main")

    made, text = written("krl", tmp_path, drive)
    assert "a linear or circular move needs a pose" in made.LOG
    assert "PTP {A1 10.5," in text


def test_an_unknown_robot_is_told_and_a_rated_speed_helps(tmp_path):
    made, text = written("krl", tmp_path, ROBOT="")
    assert text == ""
    assert "olp does not know the robot" in made.LOG
    assert "nothing was written" in made.LOG
    made, text = written("krl", tmp_path, ROBOT="", AXIS_SPEED_DEG_S=200.0)
    assert "BAS (#VEL_PTP,30)" in text
    assert "joint moves are left out" in made.LOG


def test_a_robot_that_there_is_none_of_is_refused_at_once():
    with pytest.raises(olp.OlpError):
        post("krl", ROBOT="kuka/nobody")


@pytest.mark.parametrize(
    ("name", "found"), [("Motoman GP25", "yaskawa/gp25"), ("UR10e", "universal-robots/ur10e")]
)
def test_robodks_name_of_a_robot_is_understood(name, found):
    from olp_robodk.robots import robot_named

    robot = robot_named("", name)
    assert robot is not None
    assert robot.name == found
    assert robot_named("", "KUKA KR 6") is None
    assert robot_named("", "") is None


def test_a_tool_with_a_number_is_the_controllers_and_the_log_says_that_it_is_set(tmp_path):
    def drive(made: Any) -> None:
        made.ProgStart("Main")
        made.setTool(generated.TOOL, 2, "Gripper")
        made.MoveJ(None, generated.JOINTS)
        made.MoveL(generated.POSES[0], None)
        made.ProgFinish("Main")

    made, text = written("tp", tmp_path, drive)
    assert "UTOOL_NUM=2" in text
    assert "the program gives the controller this value" in made.LOG


def test_a_speed_that_robodk_does_not_say_is_slow_and_told(tmp_path):
    def drive(made: Any) -> None:
        made.ProgStart("Main")
        made.MoveJ(None, generated.JOINTS)
        made.MoveL(generated.POSES[0], None)
        made.ProgFinish("Main")

    made, text = written("krl", tmp_path, drive)
    assert "no speed is set: 100 mm/s is written" in made.LOG
    assert "no joint speed is set: 10 deg/s is written" in made.LOG
    assert "$VEL.CP=0.1" in text
    assert "$ACC.CP" not in text


def test_external_axes_are_refused_in_the_log(tmp_path):
    made = post("krl")
    made.calls.arm_axes = 6
    made.ProgStart("Main")
    made.MoveJ(None, [*generated.JOINTS, 250.0])
    made.ProgFinish("Main")
    made.ProgSave(str(tmp_path), "Main")
    assert "external axes are not written" in made.LOG


def test_names_that_the_language_changes_are_in_the_log(tmp_path):
    def drive(made: Any) -> None:
        made.ProgStart("Main")
        made.RunCode("Pick_the_part_and_place_it_on_the_table_over_there", True)
        made.ProgFinish("Main")
        made.ProgStart("Pick_the_part_and_place_it_on_the_table_over_there")
        made.setSpeedJoints(20)
        made.MoveJ(None, generated.JOINTS)
        made.ProgFinish("Pick_the_part_and_place_it_on_the_table_over_there")

    made, _ = written("krl", tmp_path, drive)
    assert "routine: Pick_the_part_and_place_it_on_the_table_over_there is " in made.LOG


@pytest.mark.parametrize("vendor", VENDORS)
def test_without_a_robot_each_language_is_written_or_refused_as_the_page_says(vendor, tmp_path):
    made, text = written(vendor, tmp_path, ROBOT="", AXIS_SPEED_DEG_S=200.0)
    if vendor in ("inform", "krl", "tp"):
        assert text
    else:  # their joint speeds depend on the axes of the robot
        assert text == ""
        assert "cannot be written without knowing the robot" in made.LOG
        assert "nothing was written" in made.LOG
