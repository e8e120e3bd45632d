"""log.csv and sim_log.csv: every column, every error with its place, and whether moves and log fit together."""

from __future__ import annotations

import gzip

import numpy as np
import pytest
from cpu_time import cpu_time_below
from recordings import moves, places, read, refused, table, write

from olp.core.units import deg, mm
from olp.identification.recording import Log, read_recording
from olp.identification.recording.writer import log_csv

HEADER = "t_s,q1_deg,q2_deg"
ROWS = ["0.5,10,20", "0.75,11,21", "1.0,12,22", "1.25,13,23"]


def with_log(folder, rows, header=HEADER, name="log.csv", table_rows=None):
    write(folder, table(*(table_rows or moves(2))))
    return write(folder, "\n".join([header, *rows, ""]), name)


def test_every_column_of_a_log_is_read_into_si(tmp_path):
    header = "t_s,q1_deg,q2_mm,q1_cmd_deg,q2_cmd_mm,qd1_deg_s,qd2_mm_s,tau1_nm,tau2_n,i1_a,i2_a"
    header += ",x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg,move,fan_rpm,mode"
    log = read_recording(
        with_log(tmp_path, ["1.5,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17,-1,19,auto"], header)
    ).log
    assert log is not None
    assert log.time[0] == 1.5
    assert log.slides == (False, True)
    for values, expected in (
        (log.q, [2 * deg, 3 * mm]), (log.command, [4 * deg, 5 * mm]), (log.speed, [6 * deg, 7 * mm]),
        (log.torque, [8, 9]), (log.current, [10, 11]), (log.position, [12 * mm, 13 * mm, 14 * mm]),
        (log.angles, [15 * deg, 16 * deg, 17 * deg]),
    ):  # fmt: skip
        assert values[0] == pytest.approx(expected, rel=1e-14)
    assert (log.move[0], log.covariates["fan_rpm"][0], log.texts["mode"]) == (-1, 19.0, ("auto",))


def test_what_a_log_does_not_have_is_none_and_what_is_empty_is_nan(tmp_path):
    log = read_recording(with_log(tmp_path, ["0,1,2,", "1,1,2,5"], HEADER + ",i2_a")).log
    assert log.command is None
    assert log.position is None
    assert log.move is None
    np.testing.assert_array_equal(log.current, [[np.nan, np.nan], [np.nan, 5.0]])


def test_both_logs_are_read_and_hashed(tmp_path):
    first = read_recording(with_log(tmp_path, ROWS))
    second = read_recording(with_log(tmp_path, ROWS, name="sim_log.csv"))
    assert len(first.log) == len(second.sim_log) == 4
    assert first.sha256 != second.sha256
    (tmp_path / "log.csv.gz").write_bytes(gzip.compress((tmp_path / "log.csv").read_bytes()))
    (tmp_path / "log.csv").unlink()
    assert read_recording(tmp_path).sha256 == second.sha256


def test_a_log_in_parquet_is_the_same_log(tmp_path):
    import pandas

    first = read_recording(with_log(tmp_path, ROWS))
    pandas.read_csv(tmp_path / "log.csv").to_parquet(tmp_path / "log.parquet", index=False)
    (tmp_path / "log.csv").unlink()
    assert read_recording(tmp_path).sha256 == first.sha256


def test_time_that_runs_backwards_is_refused_where_it_does(tmp_path):
    found = refused(with_log(tmp_path, [*ROWS, "1.125,1,2", "2,1,2"]))
    assert places(found) == [("D020", 6, 1)]
    assert "from 1.25 to 1.125 s" in found[0].message


def test_time_that_stands_still_is_no_error(tmp_path):
    assert len(read_recording(with_log(tmp_path, ["0,1,2", "0,1,2", "1,1,2"])).log) == 3


@pytest.mark.parametrize(
    ("row", "place"),
    [("2,x,5", ("D014", 6, 3)), ("2,4,nan", ("D015", 6, 5)), ("inf,4,5", ("D015", 6, 1)), ("2,4,5,6", ("D013", 6, 7)),
     ('2,"4,5",6', ("D014", 6, 3))],
)  # fmt: skip
def test_a_bad_cell_is_refused_at_its_row_and_column(row, place, tmp_path):
    assert places(refused(with_log(tmp_path, [*ROWS, row, "3,1,2"]))) == [place]


def test_a_short_row_is_refused_inside_and_left_out_at_the_end(tmp_path):
    assert places(refused(with_log(tmp_path, [*ROWS, "2,4", "3,1,2"])))[0][:2] == ("D013", 6)
    found = read_recording(with_log(tmp_path, [*ROWS, "2,4"]))
    assert (len(found.log), found.left_out) == (4, 1)
    assert [(d.code, d.line) for d in found.diagnostics] == [("D022", 6)]


def test_samples_without_time_and_blank_rows_are_left_out_and_counted(tmp_path):
    found = read_recording(with_log(tmp_path, [ROWS[0], ",11,21", "", ROWS[2]]))
    assert (len(found.log), found.left_out) == (2, 2)
    assert {(d.code, d.line) for d in found.diagnostics} == {("D022", 3), ("D022", 4)}


@pytest.mark.parametrize(
    ("header", "missing"),
    [("time_s,q1_deg,q2_deg", "t_s"), ("t_s,q1_deg,q3_deg", "q2_deg"), ("t_s,x,y", "q1_deg")],
)
def test_a_missing_column_is_named(header, missing, tmp_path):
    found = refused(with_log(tmp_path, ROWS, header))
    assert [d.code for d in found] == ["D010"]
    assert missing in found[0].message


def test_columns_that_look_misspelt_are_told(tmp_path):
    found = read_recording(with_log(tmp_path, ["0,1,2,3"], HEADER + ",q1_cmd_rad"))
    assert [(d.code, d.help) for d in found.diagnostics] == [("D012", "did you mean q1_cmd_deg?")]


def test_a_counter_that_counts_no_moves_is_refused(tmp_path):
    assert places(refused(with_log(tmp_path, ["0,1,2,0.5"], HEADER + ",move"))) == [("D015", 2, 7)]


# --- together ---------------------------------------------------------------------------------------------------------


def joints(**more):
    """Three moves of two axes at 1, 2 and 3 s of the log below."""
    rows = []
    for i in range(3):
        cells = {
            "q1_start_deg": f"{10 * (i + 1)}",
            "q2_start_deg": "5",
            "q1_end_deg": f"{10 * (i + 2)}",
            "q2_end_deg": "5",
        }
        rows.append({"move": str(i + 1), "duration_s": "1", "t_start_s": str(i + 1), **cells, **more})
    return rows


def ramp(first, last, counter=False):
    """Axis 1 at 10 deg/s, so that it stands at 10 deg after 1 s."""
    times = np.arange(first, last + 1e-9, 0.1)
    rows = [f"{t:.3f},{10 * t:.4f},5" for t in times]
    return (
        [f"{row},{min(int(t + 1e-9), 3) if 1 <= t < 4 else -1}" for row, t in zip(rows, times, strict=True)]
        if counter
        else rows
    )


def test_moves_and_log_of_one_run_fit(tmp_path):
    found = read_recording(with_log(tmp_path, ramp(0, 5, True), HEADER + ",move", table_rows=joints()))
    assert found.diagnostics == ()


def test_a_log_of_other_axes_does_not_fit(tmp_path):
    found = refused(with_log(tmp_path, ["0,1", "9,1"], "t_s,q1_deg", table_rows=joints()))
    assert {d.code for d in found} == {"D021"}
    assert "1 axes" in found[0].message


def test_a_robot_of_other_axes_does_not_fit(tmp_path):
    write(tmp_path, 'robot = "yaskawa/up20"\n', "recording.toml")
    found = refused(write(tmp_path, table(*joints())))
    assert [d.code for d in found] == ["D021"]


def test_moves_outside_the_log_do_not_fit(tmp_path):
    found = refused(with_log(tmp_path, ramp(0, 2.3), table_rows=joints()))
    assert [(d.code, d.line) for d in found] == [("D021", 3), ("D021", 4)]


def test_a_log_that_speaks_of_other_moves_does_not_fit(tmp_path):
    rows = [row.replace(",3", ",7") if row.endswith(",3") else row for row in ramp(0, 5, True)]
    found = refused(with_log(tmp_path, rows, HEADER + ",move", table_rows=joints()))
    assert [d.code for d in found] == ["D021"]
    assert "move 7" in found[0].message


def test_durations_that_the_log_contradicts_do_not_fit(tmp_path):
    found = refused(
        with_log(tmp_path, ramp(0, 5, True), HEADER + ",move", table_rows=joints(duration_s="1.6"))
    )
    assert {(d.code, d.line) for d in found} == {("D021", 2), ("D021", 3), ("D021", 4)}


def test_a_log_that_stands_elsewhere_when_the_moves_start_does_not_fit(tmp_path):
    rows = joints()
    for row in rows:
        row |= {"q2_start_deg": "45", "q2_end_deg": "45"}
    found = refused(with_log(tmp_path, ramp(0, 5), table_rows=rows))
    assert [(d.code, d.line) for d in found] == [("D021", 2)]
    assert "axis 2" in found[0].message


def test_a_clock_that_runs_a_little_otherwise_fits(tmp_path):
    assert read_recording(
        with_log(tmp_path, ramp(0, 5, True), HEADER + ",move", table_rows=joints(duration_s="1.05"))
    )


def test_a_long_log_is_read_quickly_and_exactly(tmp_path):
    count = 200_000
    rng = np.random.default_rng(4)
    log = Log(
        np.arange(count) * 0.004,
        rng.normal(size=(count, 6)),
        (False,) * 6,
        current=rng.normal(size=(count, 6)),
        move=np.full(count, -1),
    )
    write(tmp_path, table(*moves(1)))
    (tmp_path / "log.csv").write_bytes(log_csv(log))
    with cpu_time_below(4.0):  # 0.25 s on a quiet machine
        found = read_recording(tmp_path).log
    np.testing.assert_allclose(found.q, log.q, atol=1e-10)
    np.testing.assert_array_equal(found.move, log.move)


def test_too_many_samples_are_refused_before_they_are_read(tmp_path, monkeypatch):
    monkeypatch.setattr("olp.identification.recording.log_reader.MOST_BYTES", 50)
    assert [d.code for d in refused(with_log(tmp_path, ROWS))] == ["D003"]


def test_gaps_and_period_of_a_log_are_told(tmp_path):
    log = read_recording(with_log(tmp_path, ["0,1,2", "0.1,1,2", "0.2,1,2", "0.7,1,2", "0.8,1,2"])).log
    assert log.period == pytest.approx(0.1)
    np.testing.assert_array_equal(log.gaps, [2])


def test_a_recording_without_a_log_has_none(tmp_path):
    assert read(tmp_path, table(*moves(1))).log is None
