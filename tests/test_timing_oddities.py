"""Moves that are hardly meant: each is told with its line, and the rest of the program is timed."""

from __future__ import annotations

import numpy as np
import pytest
from interpreter_jobs import job_text, plan_of

from olp.core.diagnostic import Severity
from olp.timing.result import Timing
from olp.timing.timing import time_plan

ARM = "yaskawa/ma2010"
# Corners of a square of 40 mm within reach, the middle of its first side, and a point far out of reach.
ROWS = """
C00100=900.000,0.000,300.000,175.0000,2.0000,1.0000
C00101=940.000,0.000,300.000,175.0000,2.0000,1.0000
C00102=940.000,40.000,300.000,175.0000,2.0000,1.0000
C00103=900.000,40.000,300.000,175.0000,2.0000,1.0000
C00104=920.000,0.000,300.000,175.0000,2.0000,1.0000
C00105=5000.000,0.000,300.000,175.0000,2.0000,1.0000
C00106=900.100,40.000,300.000,175.0000,2.0000,1.0000
"""


def timed(body: str) -> Timing:
    return time_plan(plan_of(body, robot=ARM, points=0, rows=ROWS))


def told(timing: Timing, code: str) -> list[tuple[str, Severity]]:
    """(statement, severity) of the findings with that code; each has its help, its file and its place on the line."""
    found = [d for d in timing.diagnostics if d.code == code]
    for d in found:
        assert d.help
        assert d.file
        assert d.source_line[d.column - 1 : d.end_column - 1] == d.source_line.strip()
    return [(d.source_line.strip(), d.severity) for d in found]


def test_a_move_to_where_the_arm_stands_is_told_and_takes_no_time():
    timing = timed(
        "MOVL C00100 V=50.0 PL=0\nMOVL C00101 V=50.0 PL=0\nMOVL C00101 V=60.0 PL=0\nMOVL C00102 V=50.0 PL=0"
    )
    assert told(timing, "T102") == [("MOVL C00101 V=60.0 PL=0", Severity.INFO)]
    assert timing.duration_s[2] == 0.0
    assert timing.duration_s[3] == pytest.approx(timing.duration_s[1])


def test_of_a_first_move_nobody_knows_the_start_and_nothing_is_said():
    assert not told(timed("MOVJ C00100 VJ=50.00\nMOVL C00101 V=50.0"), "T102")


def test_an_arc_over_a_point_on_the_line_is_told_and_timed_as_that_line():
    timing = timed("MOVL C00100 V=50.0 PL=0\nMOVC C00100 V=50.0\nMOVC C00104 V=50.0\nMOVC C00101 V=50.0 PL=0")
    assert [text for text, _ in told(timing, "T103")] == ["MOVC C00104 V=50.0"]
    assert "more" in next(d.message for d in timing.diagnostics if d.code == "T103")
    assert timing.distance_mm[2:] == pytest.approx([20.0, 20.0])
    assert timing.untimed == 0


def test_a_circular_move_alone_is_told_and_timed_as_a_line():
    timing = timed("MOVL C00100 V=50.0 PL=0\nMOVC C00102 V=50.0 PL=0\nMOVL C00101 V=50.0 PL=0")
    assert told(timing, "T103") == [("MOVC C00102 V=50.0 PL=0", Severity.WARNING)]
    assert timing.distance_mm[1] == pytest.approx(np.hypot(40, 40))


def test_a_full_circle_is_one_and_nothing_is_told():
    timing = timed(
        "MOVL C00100 V=50.0 PL=0\nMOVC C00100 V=50.0\nMOVC C00101 V=50.0\nMOVC C00102 V=50.0\nMOVC C00100 V=50.0 PL=0"
    )
    assert not told(timing, "T103")
    assert timing.distance_mm[2:].sum() == pytest.approx(2 * np.pi * np.hypot(20, 20), rel=1e-9)


def test_a_zone_longer_than_a_move_is_told_once_and_cut_to_half_of_it():
    points = (("C00106", 8), ("C00101", 8), ("C00100", 8), ("C00101", 0))
    body = "MOVL C00103 V=50.0 PL=0\n" + "\n".join(
        f"MOVL {point} V=50.0 PL={level}" for point, level in points
    )
    timing = timed(body)
    assert told(timing, "T104") == [("MOVL C00106 V=50.0 PL=8", Severity.WARNING)]
    message = next(d.message for d in timing.diagnostics if d.code == "T104")
    assert "0.05 mm are used" in message
    assert "in 2 more lines" in message


def test_a_zone_that_is_only_cut_to_half_is_nothing_to_tell():
    assert not told(
        timed("MOVL C00100 V=50.0 PL=0\nMOVL C00101 V=50.0 PL=2\nMOVL C00102 V=50.0 PL=0"), "T104"
    )


@pytest.mark.parametrize(
    ("first", "second", "told_lines"),
    [
        (0.05, 0.0, []),
        (0.05, 0.0499, []),
        (0.05, 0.05, [3, 4]),  # URScript: the zones of two points meet
        (0.12, 0.0, [3]),  # reaches over the next point, which has none
        (0.0, 0.101, [4]),  # and over the one before
    ],
)
def test_blends_of_urscript_that_overlap_are_told_as_points_that_the_robot_skips(
    tmp_path, first, second, told_lines
):
    import olp

    script = tmp_path / "a.script"
    rows = [(0.2, 0.0, 0.0), (0.4, 0.0, first), (0.4, 0.1, second), (0.1, 0.1, 0.0)]
    moves = [f"  movel(p[{x},{y},0.3,0,3.14,0], v=0.2, r={r})" for x, y, r in rows]
    script.write_text("\n".join(["def f():", *moves, "end", ""]))
    found = [d for d in time_plan(olp.read(script).plan()).diagnostics if d.code == "T104"]
    assert [d.line for d in found] == told_lines[:1]
    assert all("skips" in d.message for d in found)
    assert ["once more" in d.message for d in found] == [len(told_lines) == 2][: len(found)]


@pytest.mark.parametrize("way", ["MOVL C00105 V=50.0", "MOVJ C00105 VJ=5.00"])
def test_a_point_out_of_reach_is_told_and_the_moves_behind_it_are_timed(way):
    timing = timed(f"MOVL C00100 V=50.0 PL=0\n{way}\nMOVL C00101 V=50.0 PL=0\nMOVL C00102 V=50.0 PL=0")
    assert [text for text, _ in told(timing, "I004")] == [way]
    assert timing.duration_s[3] > 40 / 50


def test_a_speed_of_zero_is_told_and_the_rest_is_timed(tmp_path):
    import olp

    job = tmp_path / "ZERO.JBI"
    body = "MOVL C00100 V=50.0 PL=0\nMOVL C00101 V=0.0 PL=0\nMOVL C00103 V=50.0 PL=0\nMOVL C00102 V=50.0 PL=0"
    job.write_bytes(job_text(body, points=0, rows=ROWS).encode())
    program = olp.read(job)
    assert [d.source_line.strip() for d in program.diagnostics if d.code == "P020"] == [
        "MOVL C00101 V=0.0 PL=0"
    ]
    assert program.plan(robot=ARM).time()["duration_s"].iloc[-1] > 40 / 50


@pytest.mark.parametrize("arm", [None, ARM])
def test_a_rate_of_turning_for_a_move_that_does_not_turn_does_not_end_the_timing(arm):
    """Nowhere it takes no time; elsewhere only the axes say how fast, and without a robot nobody does."""
    body = (
        "MOVL C00100 V=50.0 PL=0\nMOVL C00100 VR=30.0 PL=0\nMOVL C00101 VR=30.0 PL=0\nMOVL C00102 V=50.0 PL=0"
    )
    timing = time_plan(plan_of(body, robot=arm, points=0, rows=ROWS))
    assert timing.duration_s[1] == 0.0
    assert np.isnan(timing.duration_s[2]) == (arm is None)
    assert timing.duration_s[3] > 40 / 50
