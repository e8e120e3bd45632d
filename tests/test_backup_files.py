"""Controller files: what is read from the synthetic backups, and what is said of broken ones."""

import math
import os
import runpy
import shutil
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import pytest

from olp.core.diagnostic import Diagnostic, Severity
from olp.robots.backup import Backup, read_backup
from olp.robots.backup.parameters import model_name

SAMPLES = Path(__file__).parent.parent / "samples" / "backup"
CELLS = ("dx200", "yrc1000")


def backup_of(folder: Path, **files: str) -> Backup:
    """The backup in `folder` after writing `files`: TOOL_CND="text" becomes TOOL.CND with CRLF."""
    for name, text in files.items():
        data = text.replace("\n", "\r\n").encode("cp1252")
        (folder / name.replace("_", ".")).write_bytes(data)
    return read_backup(folder)


def errors(backup: Backup) -> list[Diagnostic]:
    return [finding for finding in backup.diagnostics if finding.is_error]


def without_places(backup: Backup) -> dict[str, Any]:
    return asdict(replace(backup, folder="", files=(), diagnostics=()))


def test_the_samples_are_what_their_script_writes(tmp_path: Path) -> None:
    runpy.run_path(str(SAMPLES / "make.py"))["main"](tmp_path)
    for cell in CELLS:
        written = {path.name: path.read_bytes() for path in (tmp_path / cell).iterdir()}
        assert written == {path.name: path.read_bytes() for path in (SAMPLES / cell).iterdir()}


@pytest.mark.parametrize("cell", CELLS)
def test_a_whole_backup_reads_without_a_warning(cell: str) -> None:
    backup = read_backup(SAMPLES / cell)
    assert backup
    assert {d.severity for d in backup.diagnostics} <= {Severity.INFO}
    assert set(backup.files) == {path.name for path in (SAMPLES / cell).iterdir()}


def test_tools_come_in_metres_radians_and_kilograms() -> None:
    tools = read_backup(SAMPLES / "dx200").tools
    assert sorted(tools) == list(range(8))
    torch = tools[0]
    assert torch.name == "TORCH 35"
    assert torch.position == pytest.approx((-0.071345, 0.002118, 0.403907), abs=1e-12)
    assert [math.degrees(a) for a in torch.angles] == pytest.approx((1.7312, -38.4409, -5.2076), abs=1e-10)
    assert torch.pose == (*torch.position, *torch.angles)
    assert torch.mass == 2.915
    assert torch.centre == pytest.approx((-0.0214, 0.0037, 0.1782), abs=1e-12)
    assert torch.inertia == (0.013, 0.017, 0.011)
    assert tools[3].name == "TASTKOPF GRÜN"


def test_the_checksum_rows_of_a_yrc1000_change_nothing() -> None:
    assert read_backup(SAMPLES / "yrc1000").tools == read_backup(SAMPLES / "dx200").tools


def test_a_tool_of_an_old_controller_is_its_pose_alone(tmp_path: Path) -> None:
    backup = backup_of(tmp_path, TOOL_CND="//TOOL 2\n///NAME GUN\n11.5,-7.25,301.0,3.0,-44.0,9.5\n")
    assert not backup.diagnostics
    assert backup.tools[2].mass is None
    assert backup.tools[2].position == pytest.approx((0.0115, -0.00725, 0.301))


def test_user_frames_come_with_what_they_were_taught_with() -> None:
    frames = read_backup(SAMPLES / "dx200").user_frames
    assert sorted(frames) == [1, 7]
    frame = frames[7]
    assert (frame.name, frame.tool, frame.groups) == ("FIXTURE B", 3, (1,))
    assert frame.position == pytest.approx((0.998652, 0.935601, 0.239712), abs=1e-12)
    assert [math.degrees(a) for a in frame.angles] == pytest.approx((179.1026, -2.1413, 126.4986), abs=1e-9)
    assert frame.taught["RXX"][:6] == (80313, 21117, -22904, -9930, -41777, 15001)


def test_variables_come_by_number() -> None:
    variables = read_backup(SAMPLES / "dx200").variables
    assert variables is not None
    assert (variables.B[1], variables.B[9], len(variables.B)) == (17, 255, 20)
    assert (variables.I[1], variables.I[19]) == (-1207, 411)
    assert (variables.D[2], variables.D[16]) == (731904, -22817)
    assert (variables.R[1], variables.R[18]) == (1.734, -0.0025)
    assert variables.S == {0: "", 1: "TEIL 17", 2: "", 3: "", 4: "mm/s", 5: ""}
    assert sorted(variables.P) == [1, 3]
    assert variables.P[1].values == (-1203, 20417, -33120, 512, -41877, 902)
    assert variables.P[3].values[:3] == pytest.approx((0.41231, -0.087045, 0.03312))
    assert [math.degrees(a) for a in variables.P[3].values[3:]] == pytest.approx((178.441, -12.0071, 91.33))
    assert (variables.P[3].frame, variables.P[3].flags) == ("BASE", (16, 0))
    assert variables.BP[1].values == (87611,)
    assert variables.EX[0].values == (-1746, 8820)


def test_a_backup_without_variables_has_none() -> None:
    assert read_backup(SAMPLES / "yrc1000").variables is None


def test_what_was_assumed_of_position_variables_is_reported_with_its_line() -> None:
    assumed = [d for d in read_backup(SAMPLES / "dx200").diagnostics if d.code == "B008"]
    assert [(d.line, d.source_line.split(",")[0]) for d in assumed] == [
        (25, '"PULSE"'),
        (27, '"RECTAN"'),
        (31, '"PULSE"'),
        (34, '"PULSE"'),
    ]


def test_macros_map_to_jobs() -> None:
    assert read_backup(SAMPLES / "dx200").macros == {0: "ARC-START", 4: "CLEAN TIP"}


def test_the_system_names_controller_and_groups_robots_first() -> None:
    system = read_backup(SAMPLES / "dx200").system
    assert system is not None
    assert (system.controller, system.software) == ("DX200", "DN2.27.00A(US/PL)-00")
    assert [(g.name, g.model, len(g.axes)) for g in system.groups] == [
        ("R1", "OX1840", 6),
        ("B1", "RECT-X", 1),
        ("S1", "TURN-2", 2),
    ]
    assert [system.parameter_group(name) for name in ("R1", "B1", "S1", "S2")] == [1, 2, 3, None]


def test_groups_are_ordered_by_kind_before_number(tmp_path: Path) -> None:
    rows = [f"{name} : TURN-1          0000_0001" for name in ("S2", "S1", "R2", "B1", "R1", "S10")]
    backup = backup_of(tmp_path, SYSTEM_SYS="/SYSTEM 8\n//ROBOT NAME\n" + "\n".join(rows) + "\n")
    assert backup.system is not None
    assert [group.name for group in backup.system.groups] == ["R1", "R2", "B1", "S1", "S2", "S10"]


@pytest.mark.parametrize(
    ("text", "model"),
    [
        ("1-06VX88-A0*(GP88)", "GP88"),
        ("1-06VXO18-A0*(OX1790) STANDARD", "OX1790"),
        ("MA02010-A0*", "MA2010"),
        ("ES0165RD-A0", "ES165RD"),
        ("TURN-1", "TURN-1"),
    ],
)
def test_a_model_is_named_as_in_catalogues(text: str, model: str) -> None:
    assert model_name(text) == model


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("line_end", [b"\n", b"\r"])
def test_line_ends_and_case_of_names_do_not_matter(cell: str, line_end: bytes, tmp_path: Path) -> None:
    for path in (SAMPLES / cell).iterdir():
        data = path.read_bytes().replace(b"\r\n", line_end) + b"\x1a"
        (tmp_path / path.name.swapcase()).write_bytes(data)
    changed, original = read_backup(tmp_path), read_backup(SAMPLES / cell)
    assert without_places(changed) == without_places(original)
    assert [(d.code, d.line) for d in changed.diagnostics] == [(d.code, d.line) for d in original.diagnostics]


def test_a_comma_at_the_end_of_a_row_opens_no_value(tmp_path: Path) -> None:
    backup = backup_of(tmp_path, VAR_DAT="//VAR\n///SHARE 0,2,2,2\n///I\n3,4,\n///D\n5,6 ,\n///R\n0.5,1.5,\n")
    assert backup.variables is not None
    assert (backup.variables.I, backup.variables.D) == ({0: 3, 1: 4}, {0: 5, 1: 6})
    assert backup.variables.R == {0: 0.5, 1: 1.5}
    assert not backup.diagnostics


def test_the_encoding_can_be_chosen(tmp_path: Path) -> None:
    rows = "//TOOL 1\r\n///NAME 溶接\r\n1.0,2.0,3.0,4.0,5.0,6.0\r\n"
    (tmp_path / "TOOL.CND").write_bytes(rows.encode("shift_jis"))
    assert read_backup(tmp_path, encoding="shift_jis").tools[1].name == "溶接"


def test_all_broken_rows_are_told_at_once_with_their_columns(tmp_path: Path) -> None:
    good = "//TOOL 0\n///NAME A\n1.0,2.0,3.0,4.0,5.0,6.0\n0,0,1\n2.5\n0,0,0\n0,0,1\n"
    first = "//TOOL 1\n///NAME B\n1.0,2.O,3.0,4.0,5.0,6.0\n0,0,1\n2.5\n0,0,0\n0,0,1\n"
    second = "//TOOL 2\n///NAME C\n1.0,2.0,3.0,4.0,5.0\n0,0,1\n2,5\n0,0,0\n0,0,1\n"
    backup = backup_of(tmp_path, TOOL_CND=good + first + second)
    assert list(backup.tools) == [0]
    found = [(d.code, d.line, d.column, d.end_column) for d in errors(backup)]
    assert found == [("B003", 10, 5, 8), ("B004", 17, 1, 20), ("B004", 19, 1, 4)]
    assert errors(backup)[0].message == "'2.O' is not a number"
    assert errors(backup)[0].file == str(tmp_path / "TOOL.CND")
    assert errors(backup)[0].source_line == "1.0,2.O,3.0,4.0,5.0,6.0"


@pytest.mark.parametrize("rows", [2, 3])
def test_a_cut_tool_is_an_error_and_not_half_a_tool(rows: int, tmp_path: Path) -> None:
    text = "//TOOL 5\n///NAME A\n1.0,2.0,3.0,4.0,5.0,6.0\n0,0,1\n2.5\n0,0,0\n"
    cut = "\n".join(text.split("\n")[: 2 + rows]) + "\n"
    backup = backup_of(tmp_path, TOOL_CND=cut)
    assert not backup.tools
    assert [(d.code, d.line) for d in errors(backup)] == [("B002", 1)]


def test_a_frame_without_its_result_is_an_error_and_an_untaught_one_a_note(tmp_path: Path) -> None:
    text = "//UFRAME 3\n///NAME A\n///TOOL 0\n//UFRAME 4\n///TOOL 0\n////RORG C000=1,2,3,4,5,6\n"
    backup = backup_of(tmp_path, UFRAME_CND=text)
    assert not backup.user_frames
    assert [(d.code, d.line) for d in backup.diagnostics] == [("B002", 4), ("B008", 0)]


def test_values_out_of_a_variables_range_are_left_out(tmp_path: Path) -> None:
    backup = backup_of(tmp_path, VAR_DAT="//VAR\n///SHARE 3,2\n///B\n7,256,9\n///I\n-32769,5\n")
    assert backup.variables is not None
    assert (backup.variables.B, backup.variables.I) == ({0: 7, 2: 9}, {1: 5})
    assert [(d.line, d.column, d.end_column) for d in errors(backup)] == [(4, 3, 6), (6, 1, 7)]


def test_an_unreadable_value_does_not_renumber_those_after_its_row(tmp_path: Path) -> None:
    rows = "0,1,2,3,4,5,6,7,8,x\n10,11,12,13,14,15,16,17,18,19\n"
    backup = backup_of(tmp_path, VAR_DAT=f"//VAR\n///D\n{rows}")
    assert backup.variables is not None
    assert {number: number for number in range(10, 20)} == backup.variables.D
    assert [(d.line, d.column) for d in errors(backup)] == [(3, 19)]


@pytest.mark.parametrize("lost", range(1, 31))
def test_cut_variables_are_never_silent(lost: int, tmp_path: Path) -> None:
    rows = (SAMPLES / "dx200" / "VAR.DAT").read_bytes().split(b"\r\n")[:-1]
    (tmp_path / "VAR.DAT").write_bytes(b"\r\n".join(rows[:-lost]) + b"\r\n")
    found = read_backup(tmp_path).diagnostics
    assert any(d.code == "B002" for d in found), [d.render() for d in found]


def test_other_kinds_of_positions_keep_their_units(tmp_path: Path) -> None:
    rows = '"ANGLE",10.0,20.0,30.0,40.0,50.0,60.0\n"USER",5,412.5,-87.25,33.0,1.0,2.0,3.0,4.0\n"WHAT",1\nP3\n'
    backup = backup_of(tmp_path, VAR_DAT=f"//VAR\n///PFNUM 6,0,0,1\n///P\n{rows}")
    assert backup.variables is not None
    assert sorted(backup.variables.P) == [1]
    user = backup.variables.P[1]
    assert (user.frame, user.flags) == ("USER", (5,))
    assert user.values[:3] == pytest.approx((0.4125, -0.08725, 0.033))
    assert [math.degrees(a) for a in user.values[3:]] == pytest.approx((1.0, 2.0, 3.0, 4.0))
    assert [(d.code, d.line) for d in backup.diagnostics if d.code != "B008"] == [
        ("B003", 7),
        ("B003", 4),
        ("B006", 6),
    ]


def test_parameters_in_two_files_must_agree(tmp_path: Path) -> None:
    shutil.copy(SAMPLES / "dx200" / "ALL.PRM", tmp_path / "ALL.PRM")
    data = (tmp_path / "ALL.PRM").read_bytes()
    (tmp_path / "RC.PRM").write_bytes(data.replace(b"837000", b"838000"))
    backup = read_backup(tmp_path)
    assert backup.groups[1].file == "RC.PRM"
    assert backup.groups[1].links["a2"] == pytest.approx(0.838)
    assert [(d.code, d.severity) for d in backup.diagnostics] == [("B005", Severity.WARNING)]


@pytest.mark.parametrize("lost", [1, 17, 80, 160])
def test_cut_parameters_are_an_error_and_no_robot(lost: int, tmp_path: Path) -> None:
    rows = (SAMPLES / "dx200" / "ALL.PRM").read_bytes().split(b"\r\n")
    first = next(index for index, row in enumerate(rows) if row == b"///RC1G")
    kept = rows[: first + 171 - lost]
    (tmp_path / "ALL.PRM").write_bytes(b"\r\n".join([*kept, b""]))
    backup = read_backup(tmp_path)
    assert not backup.groups
    assert [(d.code, d.line) for d in errors(backup)] == [("B006", first + 1)]


def test_a_bad_value_spoils_its_section_only(tmp_path: Path) -> None:
    data = (SAMPLES / "dx200" / "ALL.PRM").read_bytes().replace(b"837000", b"8370o0")
    (tmp_path / "ALL.PRM").write_bytes(data)
    backup = read_backup(tmp_path)
    assert sorted(backup.groups) == [2, 3]
    assert [(d.code, d.source_line[d.column - 1 : d.end_column - 1]) for d in errors(backup)] == [
        ("B003", "8370o0")
    ]


def test_a_section_of_unknown_size_needs_a_known_controller(tmp_path: Path) -> None:
    rows = (SAMPLES / "dx200" / "ALL.PRM").read_bytes().split(b"\r\n")
    first = next(index for index, row in enumerate(rows) if row == b"///RC1G")
    (tmp_path / "RC.PRM").write_bytes(b"\r\n".join([*rows[: first + 121], b""]))
    assert [d.code for d in errors(read_backup(tmp_path))] == ["B006"]
    shutil.copy(SAMPLES / "dx200" / "SYSTEM.SYS", tmp_path)
    backup = read_backup(tmp_path)
    assert [(d.code, d.severity) for d in backup.diagnostics] == [("B006", Severity.WARNING)]
    assert backup.groups[1].links == read_backup(SAMPLES / "dx200").groups[1].links


def test_zones_that_shrink_are_refused(tmp_path: Path) -> None:
    data = (SAMPLES / "dx200" / "ALL.PRM").read_bytes()
    assert data.count(b"100000,200000,") == 1
    (tmp_path / "ALL.PRM").write_bytes(data.replace(b"100000,200000,", b"200000,100000,"))
    backup = read_backup(tmp_path)
    assert not backup.zones
    assert [d.code for d in errors(backup)] == ["B007"]


def test_a_folder_without_controller_files_is_an_empty_backup(tmp_path: Path) -> None:
    (tmp_path / "A.JBI").write_text("/JOB\n")
    backup = read_backup(tmp_path)
    assert not backup
    assert backup.diagnostics == ()


def test_no_folder_is_one_error(tmp_path: Path) -> None:
    assert [d.code for d in errors(read_backup(tmp_path / "nowhere"))] == ["B001"]


def test_two_names_that_differ_by_case_are_an_error(tmp_path: Path) -> None:
    for name in ("TOOL.CND", "tool.cnd"):
        (tmp_path / name).write_bytes((SAMPLES / "dx200" / "TOOL.CND").read_bytes())
    if len(list(tmp_path.iterdir())) == 2:  # not on Windows and macOS
        assert [d.code for d in errors(read_backup(tmp_path))] == ["B005"]


def test_what_is_no_regular_file_is_not_opened(tmp_path: Path) -> None:
    (tmp_path / "TOOL.CND").mkdir()
    expected = ["B001"]
    if os.name == "posix":
        (tmp_path / "VAR.DAT").symlink_to(os.devnull)
        expected.append("B001")
    assert [d.code for d in errors(read_backup(tmp_path))] == expected
