"""Robot files: every number has its source, units are converted once, and every mistake is shown with its line."""

import math
import pickle
import tomllib
from pathlib import Path

import numpy as np
import pytest

import olp.robots
from olp.cli.robots import load_all
from olp.core.diagnostic import OlpError
from olp.core.units import deg
from olp.robots.geometry import rotation_from_angles
from olp.robots.kinematics import branches, forward, joints_to_pulses, within_limits
from olp.robots.kinematics.configuration import from_standard
from olp.robots.robot import SOURCE_GROUPS, candidates_for_pulses, load_robot, number_groups, robot_names

DOCS = Path(__file__).parent.parent / "docs" / "robots.md"
FILES = sorted(Path(olp.robots.__file__).parent.glob("*/*.toml"))

OWN = """
maker = "Own Works"
model = "Lifter 6"
controllers = ["YRC1000"]
payload_kg = 7.5
linear_acceleration_mm_s2 = 2500
settling_time_s = 0.11
blend_zones_mm = [11, 22, 44, 88, 160, 290, 370, 480]
axes = [
  { name = "S", lower_deg = -171, upper_deg = 172, speed_deg_s = 201, acceleration_deg_s2 = 603, pulses_per_deg = 1301.5 },
  { name = "L", lower_deg = -91, upper_deg = 152, speed_deg_s = 192, acceleration_rad_s2 = 8.25, pulses_per_deg = 1402.5 },
  { name = "U", lower_deg = -83, upper_deg = 203, speed_deg_s = 213, acceleration_time_ms = 355, pulses_per_deg = -1203.5 },
  { name = "R", lower_deg = -194, upper_deg = 195, speed_deg_s = 404, pulses_per_deg = 904.5 },
  { name = "B", lower_deg = -126, upper_deg = 127, speed_deg_s = 405, pulses_per_deg = 905.5 },
  { name = "T", lower_deg = -357, upper_deg = 358, speed_deg_s = 606, pulses_per_deg = 506.5 },
]

[links]
a1_mm = 151
a2_mm = 612
a3_mm = 193
d4_mm = 644
d6_mm = 105
base_height_mm = 456

[sources]
limits = "pendant"
speed = "data sheet"
acceleration = "measured"
pulses = "backup"
links = "data sheet"
base_height = "data sheet"
blend_zones = "backup"
linear_acceleration = "measured"
settling_time = "measured"
payload = "data sheet"
"""  # noqa: E501


def written(folder, text):
    path = folder / "own.toml"
    path.write_text(text, encoding="utf-8")
    return path


def problems(folder, text):
    with pytest.raises(OlpError) as caught:
        load_robot(written(folder, text))
    return caught.value.diagnostics


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_group_of_numbers_has_its_source(path):
    robot = load_robot(f"{path.parent.name}/{path.stem}")
    groups = number_groups(robot)
    assert set(robot.sources) == set(groups)
    assert all(len(source) > 10 for source in robot.sources.values())
    assert robot.name == f"{robot.maker}/{robot.model}".lower().replace(" ", "-")
    assert robot.controllers
    said = {group for group in groups if "inferred" in robot.sources[group]}
    assert said == set(robot.inferred)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_no_number_stands_outside_a_group(path):
    """A new key must join a group, or its number would need no source."""
    keys = set(tomllib.loads(path.read_text(encoding="utf-8"))) - {"dynamics"}  # tests/test_dynamics_files.py
    words = {"maker", "model", "kind", "controllers", "pose_verified", "inferred", "sources", "axes"}
    numbers = {
        "blend_zones_mm",
        "linear_acceleration_mm_s2",
        "settling_time_s",
        "payload_kg",
        "acceleration_filter_s",
        "pose_accelerations",
        "links",
        "chain",
    }
    assert keys <= words | numbers
    assert {name.rsplit("_mm", 1)[0].removesuffix("_s").removesuffix("_kg") for name in numbers} <= set(
        SOURCE_GROUPS
    )


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_numbers_are_those_of_a_machine(path):
    robot = load_robot(f"{path.parent.name}/{path.stem}")
    assert (robot.upper - robot.lower > 100 * deg).all()
    upright = np.zeros(len(robot.axes))
    if robot.geometry is not None and robot.geometry.links is not None:
        upright = from_standard(robot.geometry.links, upright)
    assert ((robot.lower < 0.0) & (robot.upper > 0.0) | within_limits(robot, upright)[0]).all()
    assert ((robot.speeds > 30 * deg) & (robot.speeds < 1500 * deg)).all()
    if robot.knows_pulses:
        assert (np.abs(robot.pulses_per_unit * deg) > 400).all()
        assert (np.abs(robot.pulses_per_unit * deg) < 3000).all()
    if robot.geometry is not None and robot.kind == "arm":
        reach = np.linalg.norm(forward(robot, np.zeros((1, len(robot.axes))))[0])
        assert 0.15 < reach < 4.3


def test_only_the_arms_that_were_compared_with_a_controller_are_called_verified():
    verified = {name for name in robot_names() if load_robot(name).pose_verified}
    assert verified == {"yaskawa/ar2010", "yaskawa/ma2010"}


def test_all_tabulated_machines_are_there():
    models = (
        "ar2010 d500b es165rd gp110 gp12 gp180 gp180-120 gp200r gp25 gp35l gp4 gp50 gp7 gp70l gp8 gp88 hc10 "
        "hc20 hp20d ma1440 ma2010 mh110 mh12 mh5 mh50 motomini ms210 sda20d sia20d up20"
    )
    assert set(robot_names()) >= {f"yaskawa/{model}" for model in models.split()}


def test_a_model_name_alone_is_enough_and_case_does_not_matter():
    assert load_robot("GP25") is load_robot("yaskawa/gp25")


def test_robots_can_be_compared_hashed_and_sent_to_another_process():
    robot = load_robot("yaskawa/ma2010")
    copied = pickle.loads(pickle.dumps(robot))
    assert copied == robot
    assert hash(copied) == hash(robot)


def test_the_ma2010_holds_what_was_measured():
    robot = load_robot("yaskawa/ma2010")
    assert robot.linear_acceleration == pytest.approx(3.05)
    assert robot.settling_time == 0.166
    assert robot.blend_zones == pytest.approx((0.0125, 0.025, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5))
    assert robot.accelerations[0] == 11.26
    assert math.isnan(robot.accelerations[5])
    assert robot.axes[5].acceleration is None


def test_the_up20s_wrist_reaches_its_published_1658_mm():
    links = load_robot("yaskawa/up20").geometry.links
    assert links.a1 + links.a2 + math.hypot(links.a3, links.d4) == pytest.approx(1.658, abs=0.0005)


def test_a_small_arm_with_its_flange_down_at_zero_looks_forward_at_b_90():
    robot = load_robot("yaskawa/motomini")
    _, rotations = forward(robot, np.array([[0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 90, 0]]) * deg)
    np.testing.assert_allclose(rotations[:, :, 2], [[0, 0, -1], [1, 0, 0]], atol=1e-12)


def test_a_shelf_arm_has_its_upper_arm_forward_and_its_forearm_down_at_zero():
    robot = load_robot("yaskawa/es165rd")
    positions, rotations = forward(robot, np.zeros((1, 6)))
    np.testing.assert_allclose(positions, [[0.740 + 1.150 + 0.250, 0.0, -1.225 - 0.225]], atol=1e-12)
    np.testing.assert_allclose(rotations[0, :, 2], [0, 0, -1], atol=1e-12)


def test_a_users_file_is_converted_to_si(tmp_path):
    robot = load_robot(str(written(tmp_path, OWN)))
    assert robot.name == "own-works/lifter-6"
    assert robot.lower[0] == pytest.approx(math.radians(-171))
    assert robot.speeds[5] == pytest.approx(math.radians(606))
    np.testing.assert_allclose(robot.accelerations[:3], [math.radians(603), 8.25, math.radians(213) / 0.355])
    assert robot.pulses_per_unit[2] == pytest.approx(-1203.5 * 180 / math.pi)
    assert robot.geometry.links[:5] == pytest.approx((0.151, 0.612, 0.193, 0.644, 0.105))
    assert robot.geometry.base_height == pytest.approx(0.456)
    assert robot.blend_zones[4] == pytest.approx(0.160)
    assert (robot.payload, robot.linear_acceleration, robot.settling_time) == (7.5, 2.5, 0.11)
    assert not robot.pose_verified


def test_a_users_track_counts_in_millimetres(tmp_path):
    text = """
maker = "Own"
model = "Rail"
kind = "track"
[[axes]]
name = "X"
lower_mm = -150
upper_mm = 5200
speed_mm_s = 1250
acceleration_mm_s2 = 900
pulses_per_mm = 85.5

[chain]
joints = [ { axis = "X", direction = [3, 4, 0], offset_mm = [10, 20, 30] } ]
flange_offset_mm = [0, 0, 400]
flange_x = "+x"
flange_z = "+z"
[sources]
limits = "drawing"
speed = "drawing"
acceleration = "drawing"
pulses = "drawing"
chain = "drawing"
"""
    robot = load_robot(written(tmp_path, text))
    assert robot.kind == "track"
    assert robot.axes[0].linear
    assert (robot.lower[0], robot.upper[0], robot.speeds[0]) == pytest.approx((-0.15, 5.2, 1.25))
    assert joints_to_pulses(robot, [[2.0]])[0, 0] == 171000
    np.testing.assert_allclose(forward(robot, [[1.0]])[0], [[0.61, 0.82, 0.43]])


@pytest.mark.parametrize(
    ("old", "new", "code", "row", "word", "message", "help_"),
    [
        ("speed_deg_s = 192", "speed_degs = 192", "R003", 11, "speed_degs", "no key 'speed_degs'", "speed_deg_s"),
        ("payload_kg", "paylod_kg", "R003", 5, "paylod_kg", "no key 'paylod_kg'", "payload_kg"),
        ("a3_mm = 193", "a3 = 193", "R003", 21, "a3", "no key 'a3'", "a3_mm"),
        ("a3_mm = 193", "", "R004", 18, "links", "links needs a3_mm", ""),
        ("lower_deg = -91, ", "", "R004", 11, "name", "axis L needs lower_deg", ""),
        ("= 404", "= '404'", "R005", 13, "speed_deg_s", "must be a number, not '404'", ""),
        ("= 404", "= nan", "R005", 13, "speed_deg_s", "must be a number, not nan", ""),
        ("= 404", "= true", "R005", 13, "speed_deg_s", "must be a number, not True", ""),
        ("= 404", "= 0", "R005", 13, "speed_deg_s", "must be greater than 0, not 0", ""),
        ("lower_deg = -194", "lower_deg = 196", "R005", 13, "lower_deg", "lower_deg must be below", ""),
        ("11, 22, 44, 88", "11, 22, 44", "R005", 8, "blend_zones_mm", "must be 8 numbers in brackets", ""),
        ("pulses_per_deg = 904.5", "pulses_per_deg = 0", "R005", 13, "pulses_per_deg", "must not be 0", ""),
        ('name = "B"', 'name = "R"', "R005", 13, '"R"', "two axes are called R", ""),
        (
            "acceleration_rad_s2 = 8.25", "acceleration_rad_s2 = 8.25, acceleration_time_ms = 3",
            "R005", 11, "acceleration_time_ms", "state the acceleration once", "",
        ),
        ("payload_kg", 'kind = "crane"\npayload_kg', "R005", 5, "kind", "kind must be one of", ""),
        ('"Own Works"', "5", "R005", 2, "maker", "maker must be text in quotes", ""),
        ('settling_time = "measured"', "", "R006", 26, "sources", "no source is stated for: settling_time", "="),
        ("[sources]", "[sources]\nlimit = 'x'", "R003", 27, "limit", "no key 'limit'", "limits"),
        ("payload_kg", 'inferred = ["chain"]\npayload_kg', "R005", 5, "inferred", "inferred names 'chain'", ""),
        ("[links]", "[chain]\njoints = []\n[links]", "R005", 18, "chain", "links or chain", ""),
        ("base_height_mm", "signs = [1, 1, 1, 1, 1, 2]\nbase_height_mm", "R005", 24, "signs", "1 or -1", ""),
    ],
)  # fmt: skip
def test_a_mistake_is_shown_at_its_word(tmp_path, old, new, code, row, word, message, help_):
    assert OWN.count(old) == 1
    text = OWN.replace(old, new)
    found = [d for d in problems(tmp_path, text) if d.code == code and message in d.message]
    assert len(found) == 1
    line = text.split("\n")[row - 1]
    assert (found[0].line, found[0].source_line) == (row, line)
    assert line[found[0].column - 1 : found[0].end_column - 1] == word
    assert help_ in found[0].help
    assert found[0].file.endswith("own.toml")


def test_all_mistakes_are_reported_at_once(tmp_path):
    text = OWN.replace("payload_kg", "paylod_kg").replace("= 404", "= -4").replace("a3_mm", "a3")
    assert {d.code for d in problems(tmp_path, text)} == {"R003", "R004", "R005"}


def test_broken_toml_is_one_error_with_its_line(tmp_path):
    found = problems(tmp_path, OWN.replace("a2_mm = 612", "a2_mm = = 612"))
    assert [(d.code, d.line) for d in found] == [("R002", 20)]


@pytest.mark.parametrize("content", [None, b'maker = "\xff\xfe"'])
def test_a_file_that_cannot_be_read_is_an_error_in_words(tmp_path, content):
    path = tmp_path / "gone.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(OlpError) as caught:
        load_robot(path)
    assert caught.value.diagnostics[0].code == "R002"


def test_a_chain_needs_a_joint_for_every_axis(tmp_path):
    head = OWN[: OWN.index("[links]")]
    tail = (
        OWN[OWN.index("[sources]") :]
        .replace("links =", "chain =")
        .replace('base_height = "data sheet"\n', "")
    )
    chain = '[chain]\njoints = [ { axis = "Q", direction = "up", offset_mm = [0, 0] } ]\n'
    found = [d.message for d in problems(tmp_path, head + chain + tail)]
    assert any("axis must be one of S, L, U, R, B, T, not 'Q'" in message for message in found)
    assert any("direction must be one of" in message for message in found)
    assert any("offset_mm must be 3 numbers" in message for message in found)
    lone = '[chain]\njoints = [ { axis = "S", direction = "+z" } ]\n'
    assert "one joint for each" in problems(tmp_path, head + lone + tail)[0].message


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("gp52", "yaskawa/gp50"),
        ("yaskawa/gp25x", "yaskawa/gp25"),
        ("yaskawa/xyz", "yaskawa/up20"),
        ("kuka/kr6", "kuka/kr6-r900-sixx"),
        ("kawasaki/rs010n", "kawasaki/rs020n"),
        ("comau/nj-220", "no robot of comau is known"),
        ("comau/nj-220", "abb, fanuc, kawasaki, kuka, staubli, universal-robots, yaskawa"),
        ("", "known makers: "),
    ],
)
def test_an_unknown_name_lists_close_ones_else_those_of_its_maker(name, hint):
    with pytest.raises(OlpError) as caught:
        load_robot(name)
    (only,) = caught.value.diagnostics
    assert only.code == "R001"
    assert hint in only.help
    assert "olp robots lists all" in only.help
    assert ".toml" in only.help


def test_candidates_are_those_whose_limits_hold_all_pulses_the_fullest_first():
    robot = load_robot("yaskawa/gp88")
    low, high = joints_to_pulses(robot, np.stack((robot.lower, robot.upper)) * 0.98)
    fits = candidates_for_pulses(low, high)
    names = [fit.robot.name for fit in fits]
    assert names[0] == "yaskawa/gp88"
    assert "yaskawa/ar2010" not in names
    assert fits[0].used == pytest.approx(0.98, abs=0.001)
    assert [fit.used for fit in fits] == sorted((fit.used for fit in fits), reverse=True)


def test_small_pulses_fit_every_six_axis_robot_with_known_ratios_and_no_other():
    names = {fit.robot.name for fit in candidates_for_pulses([-100] * 6, [200] * 6)}
    expected = {
        name for name in robot_names() if load_robot(name).knows_pulses and len(load_robot(name).axes) == 6
    }
    assert names == expected
    assert len(expected) >= 7
    assert {fit.robot.name for fit in candidates_for_pulses([0, 0], [9, 9])} == {"yaskawa/d500b"}
    assert candidates_for_pulses([0] * 6, [10**8] * 6) == []


def test_the_up20_reaches_the_teach_points_of_the_experiments_made_with_it():
    """Tables A.1 to A.6 of Apostolovic's thesis lie between these corners, flange forward, B clear of straight."""
    robot = load_robot("yaskawa/up20")
    corners = np.array([(x, y, z) for x in (0.71, 1.35) for y in (-0.7, 0.7) for z in (0.1, 0.74)])
    forward_looking = np.tile(rotation_from_angles(np.array([180.0, -90.0, 0.0]) * deg), (len(corners), 1, 1))
    joints = branches(robot, corners, forward_looking)[:, 0]
    assert within_limits(robot, joints).all()
    np.testing.assert_allclose(forward_looking[0][:, 2], [1, 0, 0], atol=1e-12)


def test_the_table_in_the_docs_counts_the_library():
    counted: dict[str, list[int]] = {}
    for robot in load_all(robot_names()):
        counts = counted.setdefault(robot.name.partition("/")[0], [0, 0, 0, 0])
        fast = all(axis.acceleration is not None for axis in robot.axes)
        for column, is_so in enumerate((True, robot.knows_pulses, robot.pose_verified, fast)):
            counts[column] += is_so
    rows = [f"| {maker} | {' | '.join(map(str, counts))} |" for maker, counts in counted.items()]
    assert "\n".join(rows) + "\n\n" in DOCS.read_text(encoding="utf-8")


def test_the_example_in_the_docs_is_a_robot(tmp_path):
    blocks = DOCS.read_text(encoding="utf-8").split("```toml\n")[1:]
    example, chain = (block.split("```")[0] for block in blocks)
    robot = load_robot(written(tmp_path, example))
    assert robot.knows_pulses
    assert robot.geometry.links.a2 == pytest.approx(0.612)
    axes = """
maker = "Own"
model = "Tilting rail"
axes = [
  { name = "X", lower_mm = -10, upper_mm = 20, speed_mm_s = 30 },
  { name = "C", lower_deg = -10, upper_deg = 20, speed_deg_s = 30 },
]
"""
    two = load_robot(written(tmp_path, axes + chain + '[sources]\nlimits = "a"\nspeed = "a"\nchain = "a"\n'))
    np.testing.assert_allclose(forward(two, [[0.5, 0.0]])[0], [[0.120, 0.5, 0.350 + 0.040 + 0.095]])
