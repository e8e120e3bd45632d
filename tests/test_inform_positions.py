"""The position section: the state machine, units, widths, and the bulk path against the single one."""

from __future__ import annotations

from math import isnan, radians

import numpy as np
import pytest
from cpu_time import cpu_time_below
from hypothesis import given, settings
from hypothesis import strategies as st
from inform_jobs import job, read_lines

from olp.ir.expressions import Store
from olp.ir.points import PointKind, PointState, PointTable
from olp.languages.vendors.inform import positions

ROBOT, BASE, STATION = Store.ROBOT, Store.BASE, Store.STATION


def table(*rows: str, groups: str = "RB1") -> PointTable:
    program = read_lines(job(points=rows, header=("///DATE 2026/01/01 10:00", f"///GROUP1 {groups}")))
    assert not [d.render() for d in program.diagnostics if d.code != "P019"]  # decimals in pulses
    return program.routines[0].points


def state(points: PointTable, number: int, store: Store = ROBOT, taught: bool = True) -> PointState:
    point = points.find(store, taught, number)
    assert point is not None
    return point.state


def test_a_state_holds_until_it_is_changed_and_each_record_changes_one_thing() -> None:
    points = table(
        "///TOOL 3",
        "///POSTYPE PULSE",
        "///PULSE",
        "C00000=1,2,3,4,5,6",
        "///USER 7",
        "///POSTYPE USER",
        "///RECTAN",
        "///RCONF 1,0,1,0,0,0,0,0",
        "C00001=1.5,2.5,3.5,4.5,5.5,6.5",
        "///POSTYPE BASE",
        "C00002=1.5,2.5,3.5,4.5,5.5,6.5",
        "///LIMIT ON",
        "///POSTYPE TOOL",
        "C00003=1.5,2.5,3.5,4.5,5.5,6.5",
        "///LIMIT OFF",
        "///TOOL 5",
        "///POSTYPE MTOOL",
        "C00004=1.5,2.5,3.5,4.5,5.5,6.5",
        "///POSTYPE ROBOT",
        "C00005=1.5,2.5,3.5,4.5,5.5,6.5",
        "///POSTYPE ANGLE",
        "///ANGLE",
        "C00006=1.5,2.5,3.5,4.5,5.5,6.5",
        "///POSTYPE PULSE",
        "///PULSE",
        "C00007=1,2,3,4,5,6",
    )
    flags = (1, 0, 1, 0, 0, 0, 0, 0)
    pose, pulse = PointKind.POSE, PointKind.PULSE
    assert [state(points, n) for n in range(8)] == [
        PointState(pulse, "pulse", None, 3),
        PointState(pose, "user", 7, 3, flags),
        PointState(pose, "base", None, 3, flags),
        PointState(pose, "tool", None, 3, flags, outside_limits=True),
        PointState(pose, "master-tool", None, 5, flags),
        PointState(pose, "robot", None, 5, flags),
        PointState(PointKind.JOINT, "joint", None, 5),
        PointState(pulse, "pulse", None, 5),
    ]


def test_rows_without_any_record_are_pulses_of_tool_0() -> None:
    points = table("C00003=11,-22,33,-44,55,-66")
    point = points.find(ROBOT, True, 3)
    assert point is not None
    assert point.values == (11, -22, 33, -44, 55, -66)
    assert point.state == PointState(PointKind.PULSE)


def test_coordinates_become_metres_and_radians_once() -> None:
    points = table(
        "///POSTYPE BASE",
        "///RECTAN",
        "P00007=412.310,-87.045,33.120,178.4410,-12.0071,91.3300",
        "BP00040=750.250",
        "EX00002=12.5,-7.5",
        groups="RB1,BS1",
    )
    pose, track, station = (points.find(s, False, n) for s, n in ((ROBOT, 7), (BASE, 40), (STATION, 2)))
    assert pose is not None
    assert track is not None
    assert station is not None
    wanted = (0.41231, -0.087045, 0.03312, *(radians(a) for a in (178.441, -12.0071, 91.33)))
    assert pose.values == pytest.approx(wanted, abs=1e-15)
    assert track.values == pytest.approx((0.75025,), abs=1e-15)
    assert station.values == pytest.approx((radians(12.5), radians(-7.5)), abs=1e-15)


def test_a_seventh_axis_is_an_angle_and_a_joint_track_a_length() -> None:
    points = table(
        "///POSTYPE BASE",
        "///RECTAN",
        "C00000=1.0,2.0,3.0,4.0,5.0,6.0,77.0",
        "///POSTYPE ANGLE",
        "///ANGLE",
        "BC00000=1500.5",
        "EC00000=45.5,30.5",
        groups="RB1,BS1",
    )
    arm, track, station = (points.find(s, True, 0) for s in (ROBOT, BASE, STATION))
    assert arm is not None
    assert track is not None
    assert station is not None
    assert arm.values[6] == pytest.approx(radians(77))
    assert track.values == pytest.approx((1.5005,))
    assert station.values == pytest.approx((radians(45.5), radians(30.5)))


def test_every_family_lands_in_its_own_block() -> None:
    points = table(
        "C00000=1,2,3,4,5,6",
        "BC00000=7",
        "EC00000=8,9",
        "P00000=10,11,12,13,14,15",
        "BP00000=16",
        "EX00000=17,18",
        groups="RB1,BS1",
    )
    firsts = {key: float(block.values[0, 0]) for key, block in points.blocks.items()}
    assert firsts == {
        (ROBOT, True): 1,
        (BASE, True): 7,
        (STATION, True): 8,
        (ROBOT, False): 10,
        (BASE, False): 16,
        (STATION, False): 17,
    }


def test_axes_that_a_station_lacks_are_left_empty_and_keep_the_width() -> None:
    points = table("E000=-0.37,,,,,", "EC00001=1.5,2,3,4,5,6", groups="RB1,ST1")
    point = points.find(STATION, True, 0)
    assert point is not None
    assert point.values[0] == -0.37
    assert len(point.values) == 6
    assert all(isnan(value) for value in point.values[1:])


@pytest.mark.parametrize("values", ["1,2,3,,5,6", "1,2,3,4,5,", "", ",2,3,4,5,6", "1,2,3,4,5,6,"])
def test_a_robot_position_with_a_value_missing_is_an_error(values: str) -> None:
    program = read_lines(job(points=[f"C00000={values}"]))
    assert [d.code for d in program.diagnostics] == ["P010"]
    assert len(program.routines[0].points) == 0


def test_numbers_of_three_four_and_five_digits_name_the_same_point() -> None:
    points = table("C007=1,2,3,4,5,6", "P0048=1,2,3,4,5,6", "EX00002=1,2")
    assert points.find(ROBOT, True, 7)
    assert points.find(ROBOT, False, 48)
    assert points.find(STATION, False, 2)


def test_a_point_knows_its_line_whether_read_alone_or_in_bulk() -> None:
    rows = [f"C{n:05}={n},1,2,3,4,5" for n in range(9)]
    lines = job(points=[*rows[:2], "///TOOL 4", *rows[2:]])
    program = read_lines(lines)
    for _, _, point in program.routines[0].points:
        assert program.source.line(point.line) == rows[point.number]


def test_the_last_of_two_rows_with_one_number_counts_and_is_told() -> None:
    program = read_lines(job(points=["C00000=1,2,3,4,5,6", "C00000=9,2,3,4,5,6"]))
    point = program.routines[0].points.find(ROBOT, True, 0)
    assert point is not None
    assert point.values[0] == 9
    assert [d.code for d in program.diagnostics] == ["P013"]


NUMBER = st.one_of(
    st.integers(-10_000_000, 10_000_000).map(str),
    st.decimals(-9999, 9999, places=3, allow_nan=False, allow_infinity=False).map(lambda d: f"{d:.3f}"),
    st.decimals(-180, 180, places=4, allow_nan=False, allow_infinity=False).map(lambda d: f"{d:.4f}"),
)
ROWS = st.lists(st.lists(NUMBER, min_size=6, max_size=6), min_size=1, max_size=25)


@settings(max_examples=40, deadline=None)
@given(ROWS, st.sampled_from(["///PULSE", "///RECTAN", "///ANGLE"]))
def test_bulk_rows_and_single_rows_give_the_same_bits(rows: list[list[str]], kind: str) -> None:
    lines = [f"C{number:05}={','.join(row)}" for number, row in enumerate(rows)]
    bulk = table("///POSTYPE BASE", kind, *lines).blocks[ROBOT, True]
    # A trailing blank sends a row to the single path.
    single = table("///POSTYPE BASE", kind, *(line + " " for line in lines)).blocks[ROBOT, True]
    assert np.array_equal(bulk.values, single.values)
    assert np.array_equal(bulk.numbers, single.numbers)
    assert np.array_equal(bulk.lines, single.lines)
    assert bulk.rows == single.rows


def test_a_long_run_takes_the_bulk_path(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise AssertionError("a plain row was read alone")

    monkeypatch.setattr(positions.InformPositionReader, "_single", refuse)
    table(*(f"C{n:05}={n}.125,-2.5,3,4.0000,5,-6" for n in range(50)))


def test_twenty_thousand_broken_rows_do_not_hang() -> None:

    rows = [f"C{n:05}=1,2,3,4,5,x" for n in range(20_000)] + ["C1=" + "1," * 100_000]
    with cpu_time_below(2.0):
        program = read_lines(job(points=rows))
    assert sum(d.code == "P010" for d in program.diagnostics) == 20_001
