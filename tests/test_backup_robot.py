"""`olp robot import`: a robot file says what the backup says, and is refused where the backup cannot be true."""

import math
import re
import runpy
import shutil
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.robots.backup import read_backup, robot_toml
from olp.robots.backup.robot_file import check_import, shortest_degrees
from olp.robots.robot import Robot, load_robot

SAMPLES = Path(__file__).parent.parent / "samples" / "backup"
MAKE = runpy.run_path(str(SAMPLES / "make.py"))
ARMS = {"dx200": MAKE["DX200"], "yrc1000": MAKE["YRC1000"]}


def imported(folder: Path, group: str = "R1", name: str = "", into: Path | None = None) -> Robot:
    """The robot of a backup, by way of its file."""
    file = (into or folder) / "robot.toml"
    file.write_text(robot_toml(read_backup(folder), group, name), encoding="utf-8")
    return load_robot(file)


def codes(folder: Path, group: str = "R1") -> list[tuple[str, bool]]:
    return [(d.code, d.is_error) for d in check_import(read_backup(folder), group)]


@pytest.fixture
def cell(tmp_path: Path) -> Path:
    """A YRC1000 backup to spoil."""
    shutil.copytree(SAMPLES / "yrc1000", tmp_path / "cell")
    return tmp_path / "cell"


def change(file: Path, edit: Callable[[str], str]) -> None:
    before = file.read_bytes().decode("cp1252")
    after = edit(before)
    assert after != before
    file.write_bytes(after.encode("cp1252"))


def set_slot(folder: Path, slot: int, value: int, group: int = 1) -> None:
    """Writes one value of ///RCnG of RC.PRM."""
    rows = (folder / "RC.PRM").read_bytes().decode().split("\r\n")
    row = rows.index(f"///RC{group}G") + 1 + slot // 10
    values = rows[row].split(",")
    values[slot % 10] = str(value)
    rows[row] = ",".join(values)
    (folder / "RC.PRM").write_bytes("\r\n".join(rows).encode())


@pytest.mark.parametrize("name", ARMS)
def test_the_numbers_come_out_as_the_round_ones_that_went_in(name: str) -> None:
    arm = ARMS[name]
    file = tomllib.loads(robot_toml(read_backup(SAMPLES / name)))
    axes = file["axes"]
    assert [axis["name"] for axis in axes] == ["S", "L", "U", "R", "B", "T"]
    assert tuple(axis["upper_deg"] for axis in axes) == arm["upper"]
    assert tuple(axis["lower_deg"] for axis in axes) == arm["lower"]
    assert tuple(axis["speed_deg_s"] for axis in axes) == arm["speed"]
    assert tuple(axis["acceleration_time_ms"] for axis in axes) == arm["times"]
    assert tuple(1000 * file["links"][f"{key}_mm"] for key in ("a1", "a2", "a3", "d4", "d6")) == arm["links"]
    assert tuple(1000 * zone for zone in file["blend_zones_mm"]) == arm["zones"]
    for axis, (above, below) in zip(axes, arm["ratios"], strict=True):
        assert axis["pulses_per_deg"] == pytest.approx(4096 * above / abs(below) / 360, rel=1e-15)


@pytest.mark.parametrize("name", ARMS)
def test_the_file_loads_as_a_robot_with_the_same_numbers(name: str, tmp_path: Path) -> None:
    arm = ARMS[name]
    robot = imported(SAMPLES / name, into=tmp_path)
    assert (robot.kind, robot.controllers) == ("arm", (name.upper(),))
    assert [math.degrees(a) for a in robot.upper] == pytest.approx(arm["upper"])
    assert [math.degrees(a) for a in robot.lower] == pytest.approx(arm["lower"])
    assert [math.degrees(a) for a in robot.speeds] == pytest.approx(arm["speed"])
    assert [v / a * 1000 for v, a in zip(robot.speeds, robot.accelerations, strict=True)] == pytest.approx(
        arm["times"]
    )
    assert robot.blend_zones == pytest.approx([zone / 1e6 for zone in arm["zones"]])
    assert robot.geometry is not None
    assert robot.geometry.links is not None
    assert robot.geometry.links[:5] == pytest.approx([link / 1e6 for link in arm["links"]])
    assert robot.inferred == ("acceleration",)


def test_the_motors_sense_is_not_applied_to_the_pulses(tmp_path: Path) -> None:
    parameters = read_backup(SAMPLES / "dx200").groups[1]
    assert [below < 0 for below in parameters.denominators] == [False, True, False, True, False, True]
    assert min(parameters.pulses_per_degree) > 0.0
    # L goes to +147 and -98 deg: with the sign applied twice the two would change places.
    assert [round(math.degrees(a)) for a in parameters.radians(parameters.upper)][1] == 147


@pytest.mark.parametrize("name", ARMS)
def test_every_number_has_a_source_with_file_and_slot(name: str) -> None:
    file = tomllib.loads(robot_toml(read_backup(SAMPLES / name)))
    holder = "ALL.PRM" if name == "dx200" else "RC.PRM"
    for group in ("limits", "speed", "pulses", "acceleration", "links"):
        assert re.match(rf"{holder} ///RC1G slots \d+", file["sources"][group])
    zones = file["sources"]["blend_zones"]
    assert zones == f"{'ALL.PRM' if name == 'dx200' else 'SC.PRM'} ///S1C1G slots 33..40"
    assert "inferred" in file["sources"]["acceleration"]


@st.composite
def arms(draw: st.DrawFn) -> dict[str, Any]:
    """Arms with any gears, and limits and speeds given in tenths of a degree."""
    ratio = st.tuples(st.integers(60, 200), st.sampled_from([-1, 1])).flatmap(
        lambda pair: st.integers(1, 300).map(
            lambda below: (pair[0] * below + below // 2 + 1, pair[1] * below)
        )
    )
    tenths = st.integers(50, 4500).map(lambda tenth: tenth / 10)
    zones = sorted(draw(st.lists(st.integers(1, 900_000), min_size=8, max_size=8, unique=True)))
    return {
        "robot": "X",
        "code": 1,
        "links": tuple(draw(st.tuples(*[st.integers(1, 2_000_000)] * 5))),
        "ratios": tuple(draw(st.tuples(*[ratio] * 6))),
        "upper": tuple(draw(st.tuples(*[tenths] * 6))),
        "lower": tuple(-angle for angle in draw(st.tuples(*[tenths] * 6))),
        "speed": tuple(draw(st.tuples(*[tenths] * 6))),
        "times": tuple(draw(st.tuples(*[st.integers(1, 2000)] * 6))),
        "zones": zones,
    }


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(arm=arms(), layout=st.sampled_from(["DX", "YRC"]))
def test_any_arm_survives_the_way_through_backup_and_robot_file(
    arm: dict[str, Any], layout: str, tmp_path: Path
) -> None:
    rows = MAKE["group_section"](1, arm, MAKE[layout]) + MAKE["zone_section"](1, arm, 800)
    (tmp_path / "ALL.PRM").write_text("\r\n".join([*rows, ""]), newline="")
    robot = imported(tmp_path, name="acme/any-6")
    assert robot.name == "acme/any-6"
    assert [math.degrees(a) for a in robot.upper] == pytest.approx(arm["upper"], abs=1e-9)
    assert [math.degrees(a) for a in robot.lower] == pytest.approx(arm["lower"], abs=1e-9)
    assert [math.degrees(a) for a in robot.speeds] == pytest.approx(arm["speed"], abs=1e-9)
    ratios = [4096 * above / abs(below) / 360 for above, below in arm["ratios"]]
    assert [p * math.pi / 180 for p in robot.pulses_per_unit] == pytest.approx(ratios, rel=1e-14)
    assert robot.geometry is not None
    assert robot.geometry.links is not None
    assert robot.geometry.links[:5] == pytest.approx([link / 1e6 for link in arm["links"]], abs=1e-12)
    assert robot.blend_zones == pytest.approx([zone / 1e6 for zone in arm["zones"]], abs=1e-12)


@pytest.mark.parametrize(
    ("pulses", "per_degree", "degrees"),
    [
        (241_449, 1341.3801169590643, 180.0),  # as controllers store 180 deg: away from zero
        (-167_005, 2104.889, -79.3415),  # no round number is within a pulse
        (0, 1000.0, 0.0),
    ],
)
def test_degrees_are_as_short_as_the_pulse_allows(pulses: int, per_degree: float, degrees: float) -> None:
    assert shortest_degrees(pulses, per_degree) == degrees


@pytest.mark.parametrize("name", ARMS)
def test_user_frames_prove_the_arm(name: str, tmp_path: Path) -> None:
    robot = imported(SAMPLES / name, into=tmp_path)
    assert robot.pose_verified
    assert robot.sources["pose"].startswith(
        "user frames 1, 7 computed from their taught pulses agree to 0.000"
    )


def test_a_changed_tool_takes_the_proof_away(cell: Path) -> None:
    change(cell / "TOOL.CND", lambda text: text.replace("403.907", "404.907"))
    assert not imported(cell).pose_verified
    assert codes(cell) == [("B013", False)]
    (finding,) = check_import(read_backup(cell))
    assert re.search(r"frames 1, 7 miss the stored frames by 0\.\d+ mm and 0\.\d+ deg", finding.message)


def test_frames_taught_with_another_group_are_not_compared(cell: Path) -> None:
    change(cell / "UFRAME.CND", lambda text: text.replace("///GROUP 1,0", "///GROUP 0,1", 1))
    assert imported(cell).sources["pose"].startswith("user frames 7 computed")


def test_frames_that_cannot_tell_an_axis_sense_prove_nothing(cell: Path) -> None:
    """A tool on the flange's axis does not move when T turns."""
    arm, tip = ARMS["yrc1000"], (0.0, 0.0, 219.405)
    rows = MAKE["FRAMES"][7][2]
    result = MAKE["frame_row"](*(MAKE["tool_point"](arm, pulses, tip) for pulses in rows))
    change(cell / "TOOL.CND", lambda text: text.replace("11.237,-46.810,219.405", "0.000,0.000,219.405"))
    head, _, tail = (cell / "UFRAME.CND").read_bytes().decode("cp1252").partition("//UFRAME 7")
    assert head
    tail = re.sub(r"////BUSER .*", f"////BUSER {result}", tail)
    (cell / "UFRAME.CND").write_bytes(f"//UFRAME 7{tail}".encode("cp1252"))
    assert not imported(cell).pose_verified
    (finding,) = check_import(read_backup(cell))
    assert finding.message.endswith("would also do so if T turned the other way")


@pytest.mark.parametrize("zeros", [(0, 0, 0, 0, -90, 0), (0, 90, 0, 0, 0, 0)])
def test_user_frames_tell_how_the_arm_stands_at_zero(zeros: tuple[int, ...], cell: Path) -> None:
    arm = ARMS["yrc1000"]
    per_degree = MAKE["pulses_per_degree"](arm)

    def result(number: int) -> str:
        _, tool, points = MAKE["FRAMES"][number]
        turned = [
            tuple(p + zero * per for p, zero, per in zip(row, zeros, per_degree, strict=True))
            for row in points
        ]
        return str(
            MAKE["frame_row"](*(MAKE["tool_point"](arm, row, MAKE["TOOLS"][tool][1]) for row in turned))
        )

    results = iter([result(1), result(7)])
    change(
        cell / "UFRAME.CND",
        lambda text: re.sub("////BUSER .*", lambda _: f"////BUSER {next(results)}\r", text),
    )
    file = tomllib.loads(robot_toml(read_backup(cell)))
    assert file["pose_verified"]
    assert tuple(file["links"]["zero_deg"]) == zeros
    assert file["sources"]["links"].endswith("confirmed by the user frames")


def test_a_model_of_the_library_stands_as_there(cell: Path) -> None:
    (cell / "UFRAME.CND").unlink()
    robot = imported(cell, name="yaskawa/hp20d")
    library = load_robot("yaskawa/hp20d")
    assert robot.geometry is not None
    assert library.geometry is not None
    assert robot.geometry.links is not None
    assert library.geometry.links is not None
    assert robot.geometry.links.zeros == pytest.approx(library.geometry.links.zeros)
    assert any(library.geometry.links.zeros)
    assert robot.sources["links"].endswith("as in the library's yaskawa/hp20d")


def test_without_frames_the_poses_are_not_claimed(cell: Path) -> None:
    (cell / "UFRAME.CND").unlink()
    assert not imported(cell).pose_verified
    assert codes(cell) == [("B013", False)]


def test_a_station_becomes_a_positioner(tmp_path: Path) -> None:
    robot = imported(SAMPLES / "dx200", "S1", into=tmp_path)
    assert (robot.kind, robot.name, robot.axis_names) == ("positioner", "yaskawa/turn-2", ("1", "2"))
    assert [math.degrees(a) for a in robot.upper] == pytest.approx((123, 197))
    assert robot.geometry is None


def test_a_track_is_refused_since_its_millimetres_are_not_known() -> None:
    assert codes(SAMPLES / "dx200", "B1") == [("B012", True)]


@pytest.mark.parametrize(
    ("slot", "value", "says"),
    [
        (1100, 13, "axis S has a gear ratio of 1:1"),
        (1101, -2011, "axis L has the gear ratio -2011/-12"),
        (1092, 0, "axis U has the gear ratio 1429/0"),
        (1030, -999_999, "axis S has a lower soft limit of -276836 and an upper of -999999 pulses"),
        (1075, 0, "axis T has a rated speed of 0 pulses/s"),
        (1105, 0, "has 5 axes, SYSTEM.SYS gives R1 6"),
    ],
)
def test_what_cannot_be_true_makes_no_robot_file(slot: int, value: int, says: str, cell: Path) -> None:
    set_slot(cell, slot, value)
    wrong = [d for d in check_import(read_backup(cell)) if d.is_error]
    assert [d.code for d in wrong] == ["B007"]
    assert wrong[0].message.endswith(says)
    assert wrong[0].file == str(cell / "RC.PRM")
    with pytest.raises(OlpError):
        robot_toml(read_backup(cell))


@pytest.mark.parametrize(
    ("slot", "value", "says"),
    [
        (3, 0, "the link lengths cannot be true"),
        (1030, 999_999_999, "axis S may turn"),
        (1072, 413_719, "the rated speeds are not round degrees"),
        (1100, 100, "axis S has 87.5214 pulses per degree"),
    ],
)
def test_what_is_odd_is_said_and_the_file_is_still_made(slot: int, value: int, says: str, cell: Path) -> None:
    set_slot(cell, slot, value)
    found = check_import(read_backup(cell))
    assert not any(d.is_error for d in found)
    assert any(says in d.message for d in found)
    imported(cell)


def test_zero_links_leave_the_geometry_out(cell: Path) -> None:
    for slot in (1, 3, 5, 8, 12):
        set_slot(cell, slot, 0)
    assert imported(cell).geometry is None


def test_seven_axes_have_no_links(cell: Path) -> None:
    for first, value in ((1030, 200_000), (1040, -190_000), (1070, 150_000), (1090, 11), (1100, 1543)):
        set_slot(cell, first + 6, value)
    change(cell / "SYSTEM.SYS", lambda text: text.replace("0011_1111", "0111_1111"))
    robot = imported(cell)
    assert robot.axis_names == ("S", "L", "U", "R", "B", "T", "E")
    assert robot.geometry is None


def test_without_the_system_file_a_name_is_needed(cell: Path) -> None:
    (cell / "SYSTEM.SYS").unlink()
    assert ("B009", True) in codes(cell)
    assert imported(cell, name="yaskawa/ox1790").name == "yaskawa/ox1790"
    assert ("B009", True) in codes(cell, "S1")


def test_without_zones_the_file_has_none(cell: Path) -> None:
    (cell / "SC.PRM").unlink()
    assert codes(cell) == [("B009", False)]
    assert imported(cell).blend_zones is None


def test_a_broken_tool_does_not_stop_the_import(cell: Path) -> None:
    change(cell / "TOOL.CND", lambda text: text.replace("2.915", "2.9I5"))
    assert not any(is_error for _, is_error in codes(cell))
    imported(cell)


def test_text_of_the_controller_cannot_break_the_file(cell: Path) -> None:
    evil = '1-06"VX\\18-\x01\x7f]#(A"B)'
    change(cell / "SYSTEM.SYS", lambda text: text.replace("1-06VXO18-A0*(OX1790)", evil))
    file = tomllib.loads(robot_toml(read_backup(cell)))
    assert file["axes"][0]["upper_deg"] == 178


def test_the_command_writes_a_file_and_never_over_another(
    cell: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = cell.parent / "my.toml"
    words = ["robot", "import", str(cell), "-o", str(target)]
    assert main(words) == 0
    written = target.read_text(encoding="utf-8")
    assert load_robot(target).name == "yaskawa/ox1790"
    target.write_text("mine")
    assert main(words) == 2
    assert target.read_text() == "mine"
    assert "error[C009]" in capsys.readouterr().err
    assert main([*words, "--force"]) == 0
    assert target.read_text(encoding="utf-8") == written
    assert sorted(path.name for path in cell.parent.iterdir()) == ["cell", "my.toml"]


def test_the_command_never_writes_over_the_backup(cell: Path) -> None:
    before = (cell / "RC.PRM").read_bytes()
    assert main(["robot", "import", str(cell), "-o", str(cell / "RC.PRM"), "--force"]) == 2
    assert (cell / "RC.PRM").read_bytes() == before


def test_the_command_tells_every_problem_at_once(cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    set_slot(cell, 1100, 13)
    set_slot(cell, 1075, 0)
    words = ["robot", "import", str(cell), "-o", str(cell.parent / "my.toml"), "--name", "No Name"]
    assert main(words) == 2
    shown = capsys.readouterr().err
    assert shown.count("error[B007]") == 2
    assert shown.count("error[B010]") == 1
    assert not (cell.parent / "my.toml").exists()


def test_errors_come_before_warnings(cell: Path) -> None:
    (cell / "SC.PRM").unlink()
    set_slot(cell, 1075, 0)
    kinds = [is_error for _, is_error in codes(cell)]
    assert kinds[0]
    assert kinds == sorted(kinds, reverse=True)
    assert not kinds[-1]


@pytest.mark.parametrize(("where", "code"), [("nowhere", "B001"), (".", "B009")])
def test_a_folder_without_parameters_is_bad_input(
    where: str, code: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["robot", "import", str(tmp_path / where)]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("error[") == captured.err.count(f"error[{code}]") == 1
