"""The contract of moves.csv and recording.toml: every column, every error, with the place it stands."""

from __future__ import annotations

import gzip
import re
from pathlib import Path

import numpy as np
import pytest
from recordings import LINEAR, POINTS, moves, places, read, refused, table, write

from olp.core.units import deg, mm, percent
from olp.identification.recording import KINDS, read_recording

ROOT = Path(__file__).parent.parent
VECTORS = {
    "start": ("x_start_mm", "y_start_mm", "z_start_mm", mm),
    "end": ("x_end_mm", "y_end_mm", "z_end_mm", mm),
    "via": ("x_via_mm", "y_via_mm", "z_via_mm", mm),
    "start_angles": ("rx_start_deg", "ry_start_deg", "rz_start_deg", deg),
    "end_angles": ("rx_end_deg", "ry_end_deg", "rz_end_deg", deg),
}
SCALARS = {
    "duration": ("duration_s", 1.0), "sim": ("sim_s", 1.0), "speed": ("speed_mm_s", mm),
    "speed_fraction": ("speed_pct", percent), "acceleration": ("accel_mm_s2", mm),
    "acceleration_fraction": ("accel_pct", percent), "blend": ("blend_mm", mm), "t_start": ("t_start_s", 1.0),
    "payload": ("payload_kg", 1.0), "payload_inertia": ("payload_inertia_kg_m2", 1.0),
    "sim_payload": ("sim_payload_kg", 1.0), "sim_payload_inertia": ("sim_payload_inertia_kg_m2", 1.0),
    "override": ("override_pct", percent), "sim_override": ("sim_override_pct", percent),
    "level": ("pl", 1.0), "cycle": ("cycle", 1.0), "line": ("line", 1.0), "move": ("move", 1.0),
}  # fmt: skip


@pytest.mark.parametrize("field", SCALARS)
def test_each_number_is_read_into_si(field, tmp_path):
    name, factor = SCALARS[field]
    found = read(tmp_path, table(LINEAR)).moves
    assert getattr(found, field)[0] == pytest.approx(float(LINEAR[name]) * factor, rel=1e-15)


@pytest.mark.parametrize("field", VECTORS)
def test_each_point_and_orientation_is_read_into_si(field, tmp_path):
    *names, factor = VECTORS[field]
    found = getattr(read(tmp_path, table(LINEAR)).moves, field)[0]
    assert found == pytest.approx([float(LINEAR[name]) * factor for name in names], rel=1e-15)


def test_joint_points_texts_and_covariates_are_read(tmp_path):
    found = read(tmp_path, table(LINEAR)).moves
    assert found.joints_start[0] / deg == pytest.approx([11.5, -22.5])
    assert found.joints_end[0] / deg == pytest.approx([-33.5, 44.5])
    assert found.job == ("FAN.JBI",)
    assert found.kinds == ("linear",)
    assert {name: values[0] for name, values in found.covariates.items()} == {
        "temperature_c": 31.5,
        "humidity": 55.5,
    }
    assert found.texts == {"operator": ("night",)}


@pytest.mark.parametrize(
    "name",
    [n for n in LINEAR if n not in ("move", "duration_s") and not n.startswith(("x_", "y_", "z_", "r", "q"))],
)
def test_every_other_column_may_be_absent(name, tmp_path):
    row = {n: cell for n, cell in LINEAR.items() if n != name}
    assert len(read(tmp_path, table(row)).moves) == 1


def test_an_absent_column_and_an_empty_cell_mean_the_same(tmp_path):
    bare = {name: LINEAR[name] for name in POINTS}
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    one = read(tmp_path / "a", table(bare)).moves
    other = read(tmp_path / "b", table(bare, names=tuple(LINEAR))).moves
    for field in (*SCALARS, *VECTORS, "kind"):
        np.testing.assert_array_equal(getattr(one, field), getattr(other, field), err_msg=field)


def test_what_is_not_written_has_the_default_of_the_contract(tmp_path):
    found = read(tmp_path, table({name: LINEAR[name] for name in POINTS})).moves
    assert found.kinds == ("linear",)
    assert found.blend[0] == 0.0
    assert found.stops[0]
    assert np.isnan(found.speed[0])
    (tmp_path / "j").mkdir()
    joints = {"move": "1", "duration_s": "1", "q1_start_deg": "0.5", "q1_end_deg": "1.5"}
    assert read(tmp_path / "j", table(joints)).moves.kinds == ("joint",)


def test_a_level_without_a_radius_leaves_the_radius_unknown(tmp_path):
    rows = moves(4)
    for row, (pl, blend) in zip(rows, (("3", ""), ("0", ""), ("", "7.5"), ("", "")), strict=True):
        row |= {"pl": pl, "blend_mm": blend}
    found = read(tmp_path, table(*rows)).moves
    np.testing.assert_array_equal(found.blend, [np.nan, 0.0, 7.5 * mm, 0.0])
    np.testing.assert_array_equal(found.stops, [False, True, False, True])


def test_a_constant_orientation_is_that_of_start_and_end(tmp_path):
    found = read(tmp_path, table(*moves(2, rx_deg="179.5", ry_deg="-89.5", rz_deg="3.5"))).moves
    np.testing.assert_array_equal(found.start_angles, found.end_angles)
    assert found.start_angles[1] / deg == pytest.approx([179.5, -89.5, 3.5])


def test_a_move_without_duration_is_there_to_be_predicted(tmp_path):
    rows = moves(3)
    rows[1]["duration_s"] = ""
    np.testing.assert_array_equal(read(tmp_path, table(*rows)).moves.measured, [True, False, True])


@pytest.mark.parametrize("kind", KINDS)
def test_every_type_of_the_contract_is_known(kind, tmp_path):
    row = moves(1, type=kind, x_via_mm="1.5", y_via_mm="2.5", z_via_mm="3.5")[0]
    assert read(tmp_path, table(row)).moves.kinds == (kind,)


def test_a_wait_needs_no_points(tmp_path):
    rows = moves(2, type="linear")
    rows[1] = {"move": "2", "duration_s": "0.5", "type": "wait"}
    assert read(tmp_path, table(*rows)).moves.kinds == ("linear", "wait")


def test_rows_of_another_order_of_columns_are_the_same_recording(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    one = read(tmp_path / "a", table(LINEAR))
    other = read(tmp_path / "b", table(LINEAR, names=tuple(reversed(LINEAR))))
    assert one.sha256 == other.sha256


@pytest.mark.parametrize("name", [n for n in LINEAR if n not in ("type", "job", "operator")])
def test_the_hash_knows_every_number(name, tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    changed = LINEAR | {name: str(int(float(LINEAR[name])) + 2)}
    assert read(tmp_path / "a", table(LINEAR)).sha256 != read(tmp_path / "b", table(changed)).sha256


def test_csv_gzip_and_parquet_are_one_recording(tmp_path):
    import pandas

    rows = moves(5, job="A.JBI", humidity="44.5")
    rows[2]["duration_s"] = ""
    text = table(*rows)
    for name in ("csv", "gz", "parquet"):
        (tmp_path / name).mkdir()
    write(tmp_path / "csv", text)
    (tmp_path / "gz/moves.csv.gz").write_bytes(gzip.compress(text.encode()))
    pandas.read_csv(tmp_path / "csv/moves.csv").to_parquet(tmp_path / "parquet/moves.parquet", index=False)
    found = [read_recording(tmp_path / name) for name in ("csv", "gz", "parquet")]
    assert len({recording.sha256 for recording in found}) == 1
    for recording in found:
        np.testing.assert_array_equal(recording.moves.start, found[0].moves.start)
        assert recording.moves.job == ("A.JBI",) * 5


def test_a_byte_order_mark_carriage_returns_quotes_and_blanks_do_no_harm(tmp_path):
    row = moves(1)[0] | {"operator": '"Müller, Anna"'}
    text = table(row).replace("\n", "\r\n").replace(",", " , ", 3)
    (tmp_path / "moves.csv").write_bytes(b"\xef\xbb\xbf" + text.encode())
    found = read_recording(tmp_path).moves
    assert found.texts["operator"] == ("Müller, Anna",)
    assert found.move[0] == 1


def test_a_single_file_is_a_recording_and_says_what_it_did_not_read(tmp_path):
    write(tmp_path, table(*moves(2)))
    write(tmp_path, 'controller = "XRC"\n', "recording.toml")
    alone, whole = read_recording(tmp_path / "moves.csv"), read_recording(tmp_path)
    assert [d.code for d in alone.diagnostics] == ["D025"]
    assert (alone.settings.controller, whole.settings.controller) == ("", "XRC")


# --- what is wrong, and where -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", POINTS)
def test_a_missing_required_column_is_named(name, tmp_path):
    rows = moves(2)
    found = refused(write(tmp_path, table(*rows, names=tuple(n for n in rows[0] if n != name))))
    assert [(d.code, d.line) for d in found] == [("D010", 1)]
    assert name in found[0].message


def test_a_table_without_any_points_says_which_columns_there_are(tmp_path):
    found = refused(write(tmp_path, "move,duration_s\n1,2.5\n"))
    assert [d.code for d in found] == ["D010"]
    assert "q1_start_deg" in found[0].help


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("Duration", "duration_s"),
        ("duration_ms", "duration_s"),
        ("duration_ticks", "duration_s"),
        ("duration", "duration_s"),
        ("xstart_mm", "x_start_mm"),
        ("x_start_m", "x_start_mm"),
        ("Move", "move"),
    ],
)
def test_a_missing_column_suggests_the_one_that_was_meant(written, meant, tmp_path):
    rows = moves(1)
    names = tuple(written if n == meant else n for n in rows[0])
    row = {written if n == meant else n: cell for n, cell in rows[0].items()}
    found = refused(write(tmp_path, table(row, names=names)))
    assert any(d.code == "D010" and written in d.help for d in found), [d.help for d in found]
    if written in ("duration_ms", "duration_ticks", "x_start_m"):
        assert any("convert it" in d.help for d in found), "renamed, its numbers would be wrong"


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("speed_mms", "speed_mm_s"),
        ("blend_m", "blend_mm"),
        ("typ", "type"),
        ("PL", "pl"),
        ("temperatur_c", "temperature_c"),
    ],
)
def test_an_optional_column_that_looks_misspelt_is_kept_and_told(written, meant, tmp_path):
    row = {n: c for n, c in moves(1)[0].items() if n != meant} | {written: "3"}
    found = read(tmp_path, table(row))
    assert [(d.code, d.help) for d in found.diagnostics] == [("D012", f"did you mean {meant}?")]
    assert written in found.moves.covariates


@pytest.mark.parametrize(
    ("name", "cell"),
    [("duration_s", "-0.5"), ("sim_s", "-1"), ("speed_mm_s", "0"), ("speed_mm_s", "-3"), ("speed_pct", "0"),
     ("accel_mm_s2", "0"), ("accel_pct", "-1"), ("blend_mm", "-1"), ("pl", "9"), ("pl", "1.5"), ("cycle", "0.5"),
     ("line", "0"), ("payload_kg", "-2"), ("payload_inertia_kg_m2", "-1"), ("temperature_c", "-300"),
     ("move", "1.5"), ("move", "-1"), ("move", ""), ("x_start_mm", "nan"), ("z_end_mm", "NaN"), ("q1_start_deg", "inf"),
     ("duration_s", "nan"), ("rx_start_deg", "-inf"), ("duration_s", "1e999")],
)  # fmt: skip
def test_a_value_that_cannot_be_is_refused_at_its_row_and_column(name, cell, tmp_path):
    rows = [LINEAR, LINEAR | {"move": "2", name: cell}]
    text = table(*rows)
    found = refused(write(tmp_path, text))
    line = text.splitlines()[2]
    cells = line.split(",")
    before = ",".join(cells[: list(LINEAR).index(name)])
    assert places(found) == [("D015", 3, len(before) + 2 if before else 1)]
    assert found[0].file.endswith("moves.csv")


@pytest.mark.parametrize(
    ("cell", "help"), [("fast", ""), ("1_000", ""), ('"1,5"', "the decimal mark is a point"), ("0x10", "")]
)
def test_a_cell_that_is_no_number_is_refused_at_its_row_and_column(cell, help, tmp_path):
    rows = moves(3)
    rows[1]["speed_mm_s"] = cell
    found = refused(write(tmp_path, table(*rows)))
    start = len(",".join(list(rows[1].values())[:8])) + 2
    assert places(found) == [("D014", 3, start)]
    assert found[0].help == help


def test_a_move_twice_is_refused_and_says_where_the_other_stands(tmp_path):
    rows = moves(4)
    rows[3]["move"] = "2"
    found = refused(write(tmp_path, table(*rows)))
    assert places(found) == [("D016", 5, 1)]
    assert "line 3" in found[0].message


def test_an_unknown_type_suggests_the_nearest(tmp_path):
    found = refused(write(tmp_path, table(moves(1, type="linaer")[0])))
    assert [d.code for d in found] == ["D017"]
    assert found[0].help == "did you mean linear?"


@pytest.mark.parametrize("name", ["x_start_mm", "z_end_mm"])
def test_a_point_without_one_of_its_numbers_is_refused(name, tmp_path):
    rows = moves(2)
    rows[0][name] = ""
    found = refused(write(tmp_path, table(*rows)))
    assert [(d.code, d.line) for d in found] == [("D018", 2)]
    assert name in found[0].message


def test_a_move_that_goes_nowhere_known_is_refused(tmp_path):
    rows = moves(3)
    for name in POINTS[2:]:
        rows[1][name] = ""
    assert [(d.code, d.line) for d in refused(write(tmp_path, table(*rows)))] == [("D018", 3)]


def test_a_circular_move_needs_its_middle_point(tmp_path):
    assert [d.code for d in refused(write(tmp_path, table(moves(1, type="circular")[0])))] == ["D018"]


def test_orientations_that_contradict_each_other_are_refused(tmp_path):
    row = LINEAR | {"rx_deg": "179.5", "ry_deg": "-89.25", "rz_deg": "1.5"}
    assert {d.code for d in refused(write(tmp_path, table(row)))} == {"D019"}


def test_joint_points_of_one_end_only_are_refused(tmp_path):
    found = refused(write(tmp_path, "move,duration_s,q1_start_deg,q3_end_deg\n1,2.5,3.5,4.5\n"))
    named = {d.message.split()[2] for d in found}
    assert named == {"q1_end_deg", "q2_start_deg", "q2_end_deg", "q3_start_deg"}


def test_everything_wrong_is_told_at_once(tmp_path):
    rows = moves(5)
    rows[0]["duration_s"] = "-1"
    rows[1]["x_end_mm"] = "nan"
    rows[2]["speed_mm_s"] = "quick"
    rows[4]["move"] = "4"
    write(tmp_path, "time_resolution_s = -1\n", "recording.toml")
    write(tmp_path, "t_s,q1_deg\n0,1\n2,1\n1,1\n", "log.csv")
    found = refused(write(tmp_path, table(*rows)))
    assert {(d.code, Path(d.file).name, d.line) for d in found if d.is_error} == {
        ("D015", "moves.csv", 2), ("D015", "moves.csv", 3), ("D014", "moves.csv", 4), ("D016", "moves.csv", 6),
        ("D030", "recording.toml", 1), ("D020", "log.csv", 4),
    }  # fmt: skip


def test_ten_thousand_bad_cells_are_counted_not_listed(tmp_path):
    found = refused(write(tmp_path, table(*moves(10_000, duration_s="-1"))))
    assert len(found) == 21
    assert "9,980 more" in found[-1].message


@pytest.mark.parametrize(("row", "cells"), [("2,1.5,3", 3), ("2,1.5,1,2,3,4,5,6,7,8,9", 11)])
def test_a_row_of_another_width_is_refused_not_filled_up(row, cells, tmp_path):
    found = refused(write(tmp_path, table(*moves(1)) + row + "\n"))
    assert [(d.code, d.line) for d in found] == [("D013", 3)]
    assert f"{cells} cells" in found[0].message


def test_blank_rows_are_left_out_counted_and_listed(tmp_path):
    rows = table(*moves(3)).splitlines()
    found = read(tmp_path, "\n".join([rows[0], rows[1], "", rows[2], ",,,,,,,,", rows[3], ""]))
    assert (found.left_out, len(found.moves)) == (2, 3)
    assert [d.code for d in found.diagnostics] == ["D022"]
    assert found.diagnostics[0].message.endswith("lines 3, 5")
    np.testing.assert_array_equal(found.moves.row, [2, 4, 6])


@pytest.mark.parametrize(
    ("text", "code"),
    [(b"", "D002"), (b"\n\n", "D002"), (b"move\tduration_s\n1\t2\n", "D010"), (b"move,move\n1,2\n", "D011"),
     (b"move,,duration_s\n1,2,3\n", "D011"), (b"\xff\xfem\x00o\x00", "D002"), (b'move,duration_s\n1,"2\n', "D002"),
     (b"move,duration_s\n1,\xe4\n", "D002")],
)  # fmt: skip
def test_what_is_no_table_is_refused(text, code, tmp_path):
    (tmp_path / "moves.csv").write_bytes(text)
    assert code in [d.code for d in refused(tmp_path)]


def test_a_table_that_begins_with_its_numbers_is_told_once(tmp_path):
    (tmp_path / "moves.csv").write_bytes(b"1,0.5,-0.0000,0.0000,0.0000\n2,0.5,0.1,0.0000,0.0000\n")
    (found,) = refused(tmp_path)
    assert (found.code, found.line) == ("D002", 1)
    assert "no names of columns" in found.message


def test_a_broken_gzip_and_a_broken_parquet_are_refused(tmp_path):
    packed = gzip.compress(table(*moves(50)).encode())
    (tmp_path / "moves.csv.gz").write_bytes(packed[: len(packed) // 2])
    assert [d.code for d in refused(tmp_path)] == ["D002"]
    (tmp_path / "moves.parquet").write_bytes(b"PAR1 not really")
    assert [d.code for d in refused(tmp_path / "moves.parquet")] == ["D002"]


def test_a_bomb_is_not_unpacked(tmp_path, monkeypatch):
    monkeypatch.setattr("olp.identification.recording.table.MOST_BYTES", 100_000)
    (tmp_path / "moves.csv.gz").write_bytes(gzip.compress(b"0" * 1_000_000))
    assert [d.code for d in refused(tmp_path)] == ["D003"]


def test_parquet_without_its_library_says_what_to_install(tmp_path, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "pyarrow", None)
    (tmp_path / "moves.parquet").write_bytes(b"PAR1")
    found = refused(tmp_path)
    assert [d.code for d in found] == ["D004"]
    assert "olp[parquet]" in found[0].help


def test_a_nan_in_parquet_is_no_missing_value(tmp_path):
    import pyarrow
    from pyarrow import parquet

    columns = {name: [1.5, 2.5] for name in POINTS} | {"move": [1, 2], "x_end_mm": [1.5, float("nan")]}
    parquet.write_table(pyarrow.table(columns), tmp_path / "moves.parquet")
    found = refused(tmp_path)
    assert [d.code for d in found] == ["D015"]
    assert found[0].message == "row 2: x_end_mm cannot be nan"


def test_two_files_of_moves_in_one_folder_are_refused(tmp_path):
    write(tmp_path, table(*moves(1)))
    write(tmp_path, table(*moves(1)), "moves.csv.gz")
    assert [d.code for d in refused(tmp_path)] == ["D005"]


def test_a_folder_without_moves_points_to_from_log(tmp_path):
    found = refused(write(tmp_path, "t_s,q1_deg\n0,1\n", "log.csv"))
    assert [d.code for d in found] == ["D001"]
    assert "from-log" in found[0].help
    assert [d.code for d in refused(tmp_path / "nowhere")] == ["D001"]


def test_starts_that_run_backwards_and_texts_that_are_nearly_numbers_are_warned_of(tmp_path):
    rows = moves(20, humidity="55", t_start_s="")
    for i, row in enumerate(rows):
        row["t_start_s"] = str(100 - i if i == 9 else i)
    rows[4]["humidity"] = "55%"
    found = read(tmp_path, table(*rows))
    assert [(d.code, d.line) for d in found.diagnostics] == [("D023", 6), ("D024", 12)]


# --- recording.toml ---------------------------------------------------------------------------------------------------


def test_every_setting_is_read_into_si(tmp_path):
    write(tmp_path, table(*moves(1)))
    write(tmp_path, "NOP", "fan.jbi")
    write(
        tmp_path,
        'robot = "yaskawa/up20"\ncontroller = "XRC"\ntime_resolution_s = 0.01\n'
        'tool = [1.0, 2.0, 3.0, 4.0, 5.0, 6]\njob = "fan.jbi"\n',
        "recording.toml",
    )
    found = read_recording(tmp_path)
    assert found.robot is not None
    assert found.robot.name == "yaskawa/up20"
    assert found.settings.time_resolution == 0.01
    assert found.settings.tool == pytest.approx([1 * mm, 2 * mm, 3 * mm, 4 * deg, 5 * deg, 6 * deg])
    assert found.tool is not None
    assert (found.settings.job, found.diagnostics) == ("fan.jbi", ())


@pytest.mark.parametrize(
    ("text", "code"),
    [('time_resolution_s = "0.01"', "D030"), ("time_resolution_s = nan", "D030"), ("robot = 3", "D030"),
     ("tool = [1, 2, 3]", "D030"), ("tool = [1, 2, 3, 4, 5, true]", "D030"), ("robot = ", "D002")],
)  # fmt: skip
def test_a_setting_that_means_nothing_is_refused_with_its_line(text, code, tmp_path):
    write(tmp_path, table(*moves(1)))
    found = refused(write(tmp_path, f"# first line\n{text}\n", "recording.toml"))
    assert [(d.code, d.line) for d in found] == [(code, 2)]


def test_a_robot_nobody_knows_is_refused(tmp_path):
    from olp.core.diagnostic import OlpError

    write(tmp_path, table(*moves(1)))
    write(tmp_path, 'robot = "yaskawa/up21"\n', "recording.toml")
    with pytest.raises(OlpError, match="up20"):
        read_recording(tmp_path)


def test_an_unknown_setting_and_a_missing_job_are_warned_of(tmp_path):
    write(tmp_path, table(*moves(1)))
    write(tmp_path, 'controler = "XRC"\njob = "gone.jbi"\n', "recording.toml")
    found = read_recording(tmp_path).diagnostics
    assert [(d.code, d.line) for d in found] == [("D031", 1), ("D032", 2)]
    assert found[0].help == "did you mean controller?"


# --- what is made of it -----------------------------------------------------------------------------------------------


def test_the_published_moves_are_read_whole():
    found = read_recording(ROOT / "samples/up20")
    assert (len(found.moves), found.diagnostics, found.left_out) == (146, (), 0)
    assert found.moves.duration.sum() == pytest.approx(430.655, abs=1e-9)
    # The printed distances are to 0.01 mm.
    np.testing.assert_allclose(found.moves.chord / mm, found.moves.covariates["distance_mm"], atol=0.0101)
    groups = found.groups()
    assert {name: int(labels.max()) + 1 for name, labels in groups.items()} == {
        "start": 9, "test": 3, "start (column)": 4, "target": 18,
    }  # fmt: skip


def test_groups_part_the_moves_and_are_not_said_twice(tmp_path):
    rows = moves(6, job="A.JBI")
    for i, row in enumerate(rows):
        row |= {
            "speed_mm_s": "100" if i % 2 else "200",
            "shift": "early" if i < 3 else "late",
            "half": "a" if i < 3 else "b",
        }
        row |= dict.fromkeys(POINTS[2:5], "1.5")
    groups = read(tmp_path, table(*rows)).groups()
    assert list(groups) == ["speed", "shift"]  # one start, one job; half parts as shift does
    np.testing.assert_array_equal(groups["speed"], [0, 1, 0, 1, 0, 1])
    np.testing.assert_array_equal(groups["shift"], [0, 0, 0, 1, 1, 1])


def test_the_noise_floor_is_the_larger_of_resolution_and_repeats(tmp_path):
    # Two moves, three times each: deviations -d, 0, d and -e, 0, e pool to sqrt((d² + e²) / 2).
    rows = []
    for i, (base, by) in enumerate(
        ((2.0, -0.03), (2.0, 0.0), (2.0, 0.03), (4.0, -0.01), (4.0, 0.0), (4.0, 0.01))
    ):
        rows.append(moves(1 if base == 2.0 else 2)[-1] | {"move": str(i), "duration_s": f"{base + by:.3f}"})
    write(tmp_path, table(*rows))
    write(tmp_path, "time_resolution_s = 0.001\n", "recording.toml")
    noise = read_recording(tmp_path).noise_floor()
    assert noise.freedom == 4
    assert noise.repeats == pytest.approx(np.sqrt((2 * 0.03**2 + 2 * 0.01**2) / 4))
    assert noise.floor == noise.repeats
    write(tmp_path, "time_resolution_s = 1.2\n", "recording.toml")
    assert read_recording(tmp_path).noise_floor().floor == pytest.approx(1.2 / np.sqrt(12))


@pytest.mark.parametrize(
    ("step", "said"), [(0.01, 0.01), (0.1, 0.1), (0.05, 0.05), (0.0123456, float("nan"))]
)
def test_the_resolution_shows_in_the_durations_when_nobody_says_it(step, said, tmp_path):
    rows = moves(30)
    for i, row in enumerate(rows):
        row["duration_s"] = f"{(3 * i + 1) * step:.12g}"
    noise = read(tmp_path, table(*rows)).noise_floor()
    assert noise.inferred
    np.testing.assert_equal(noise.resolution, said)


BITS = [
    b",",
    b"\n",
    b'"',
    b"nan",
    b"-1",
    b"1e999",
    b"\x00",
    b"\xff",
    b"",
    b"9" * 25,
    b"q1_deg",
    b"t_s",
    b"\r",
    b";",
    b"=",
    b"[",
]


@pytest.mark.parametrize("name", ["moves.csv", "log.csv", "recording.toml"])
def test_whatever_is_in_a_file_is_read_or_refused(name, tmp_path):
    import random

    from olp.core.diagnostic import OlpError
    from olp.identification.recording.summary import as_dict, describe

    write(tmp_path, (ROOT / "samples/recordings/every-column/moves.csv").read_text("utf-8"))
    write(tmp_path, 'controller = "X"\ntool = [1, 2, 3, 4, 5, 6.5]\n', "recording.toml")
    write(
        tmp_path,
        "t_s,q1_deg,q2_deg,move,mode\n" + "".join(f"{i}.5,1,2,-1,a\n" for i in range(10, 30)),
        "log.csv",
    )
    whole, chance = (tmp_path / name).read_bytes(), random.Random(7)
    answers = {True: 0, False: 0}
    for _ in range(150):
        at = chance.randrange(len(whole) + 1)
        upto = min(len(whole), at + chance.choice([0, 1, 3, 40]))
        (tmp_path / name).write_bytes(whole[:at] + chance.choice(BITS) + whole[upto:])
        try:
            found = read_recording(tmp_path)
            assert describe(found)
            assert as_dict(found)["moves"] == len(found.moves)
            answers[True] += 1
        except OlpError as problem:
            answers[False] += all(d.message for d in problem.diagnostics)
    assert min(answers.values()) > 5


def test_semicolons_and_decimal_commas_are_read_as_commas_and_points(tmp_path):
    plain = (ROOT / "samples/recordings/every-column/moves.csv").read_text("utf-8")
    log = "t_s,q1_deg,q2_deg,move,mode\n" + "".join(f"{i}.5,1.25,-2.75,-1,a\n" for i in range(10, 30))
    found = []
    for change in (str, of_half_of_europe):
        write(tmp_path, change(plain))
        write(tmp_path, change(log), "log.csv")
        found.append(read_recording(tmp_path).sha256)
    assert found[0] == found[1]


def of_half_of_europe(text):
    return re.sub(r"(?<=\d)\.(?=\d)", ",", text.replace(",", ";"))


@pytest.mark.parametrize("between", [";", "\t"])
def test_commas_within_cells_and_quotes_are_kept(between, tmp_path):
    names = [f"q{n}_{end}_deg" for n in (1, 2) for end in ("start", "end")]
    cells = ["1", '"2,5"', "1,25", '"10,5"', "3", "4", '"a, ""b"""', "c, d"]
    write(
        tmp_path,
        "\n".join([between.join(["move", "duration_s", *names, "note", "other"]), between.join(cells)]),
    )
    moves = read_recording(tmp_path).moves
    assert moves.duration.tolist() == [2.5]
    assert (moves.joints_start / deg).tolist() == [pytest.approx([1.25, 3.0])]
    assert moves.texts == {"note": ('a, "b"',), "other": ("c, d",)}


@pytest.mark.parametrize(
    "text",
    ["move,duration_s,type,,\n1,2.5,wait,,\n2,3,wait\n", "move;duration_s;type;\n1;2,5;wait;\n2;3;wait;\n"],
)
def test_separators_at_the_end_of_lines_are_no_column(tmp_path, text):
    (tmp_path / "moves.csv").write_text(text)
    assert read_recording(tmp_path).moves.duration.tolist() == [2.5, 3.0]
    (tmp_path / "moves.csv").write_text("move,duration_s,\n1,2.5,7\n")
    assert [found.code for found in refused(tmp_path)] == ["D013"]


# --- units: what no motion agrees with ---

# A cell of 20 straight moves as it should be: 300 mm to 680 mm at 250 mm/s, and what a mistaken unit makes of it.
_MISTAKEN = {
    "sim_s in ms": ({"sim_s": 1000.0}, "error", "D027", "sim_s", "1,000 times duration_s"),
    "duration_s in min": ({"duration_s": 1 / 60}, "error", "D027", "sim_s", "60 times duration_s"),
    "both in ms": ({"sim_s": 1000.0, "duration_s": 1000.0}, "warning", "D057", "duration_s", "as long as"),
    "points in m": ({"x": 0.001}, "warning", "D057", "x_start_mm", "as long as"),
    "speeds in m/s": ({"speed_mm_s": 0.001}, "warning", "D057", "speed_mm_s", "need"),
    "speeds in m/min": ({"speed_mm_s": 0.06}, "warning", "D057", "speed_mm_s", "need"),
    "points in m, speeds in m/s": ({"x": 0.001, "speed_mm_s": 0.001}, "warning", "D057", "x_start_mm", "metres?"),
    "accelerations in m/s²": ({"accel_mm_s2": 0.001}, "warning", "D057", "accel_mm_s2", "m/s²?"),
    "joints in rad": ({"q": np.pi / 180}, "warning", "D057", "q1_start_deg", "radians?"),
}  # fmt: skip


def _straight_cell(factors: dict[str, float]) -> str:
    rows = []
    for i in range(20):
        way = 300.0 + 20.0 * i
        numbers = {"move": i + 1, "duration_s": way / 250.0 + 0.1, "sim_s": way / 250.0 + 0.1}
        numbers |= {"speed_mm_s": 250.0, "accel_mm_s2": 2500.0}
        numbers |= {f"{axis}_start_mm": 400.0 * factors.get("x", 1.0) for axis in "xyz"}
        numbers |= {f"{axis}_end_mm": 400.0 * factors.get("x", 1.0) for axis in "yz"}
        numbers["x_end_mm"] = (400.0 + way) * factors.get("x", 1.0)
        joints = {f"q{a}_{end}_deg": 30.0 * a + i for a in range(1, 5) for end in ("start", "end")}
        numbers |= {name: value * factors.get("q", 1.0) for name, value in joints.items()}
        rows.append({name: repr(value * factors.get(name, 1.0)) for name, value in numbers.items()})
        rows[-1]["move"] = str(i + 1)
    return table(*rows)


@pytest.mark.parametrize("mistake", _MISTAKEN)
def test_a_column_in_another_unit_is_told(mistake, tmp_path):
    factors, severity, code, name, says = _MISTAKEN[mistake]
    text = _straight_cell(factors)
    folder = write(tmp_path, text)
    found = refused(folder) if severity == "error" else read_recording(folder).diagnostics
    [told] = [d for d in found if d.code in ("D027", "D057")]
    assert (told.code, told.severity.name.lower(), told.line) == (code, severity, 1)
    assert says in told.message
    header = text.splitlines()[0]
    assert header[told.column - 1 :].startswith(name + ",") or header.endswith(name)


def test_units_of_slow_fast_and_short_moves_are_not_doubted(tmp_path):
    """5 mm at 250 mm/s in 0.1 s, and at an override of 2 %."""
    rows = moves(20, duration_s="0.1", speed_mm_s="250", override_pct="150")
    slow = moves(20, duration_s="3.2", speed_mm_s="250", override_pct="2")
    for number, those in enumerate((rows, slow)):
        folder = tmp_path / str(number)
        folder.mkdir()
        assert not read(folder, table(*those)).diagnostics
