"""What olp draws is a motion that a robot can make: no jump in position or speed, within the limits it was made with.

Over all samples of all vendors and all motion models. Each row's path coordinate is looked at by differences, without
the formulas that made it, and the tool's point where lines meet.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from olp.core.diagnostic import OlpError
from olp.fluent import read
from olp.ir.program import Path as Kind
from olp.languages.vendor import vendor_suffixes
from olp.runtime.plan import PATHS, BlendCode, StepKind
from olp.timing.motion import model_names
from olp.timing.result import Timing
from olp.timing.timing import time_plan
from olp.timing.track import states, tool_position, track

SAMPLES = [
    path
    for path in sorted(Path("samples").rglob("*"))
    if path.name.lower().endswith(vendor_suffixes())
    and not {"broken", "backup", "recordings"} & set(path.parts)
]
_MOST = 60  # rows of a sample that are looked at
_INSTANTS = (
    40  # per row: fine enough that a jump of speed is many times what the acceleration makes of a step
)
_STRAIGHTNESS = 1.02  # of an acceleration between two instants over that at one of them


@cache
def timed(path: Path, model: str) -> Timing | None:
    """None where there is nothing to move or to time: broken inputs have tests of their own."""
    try:
        timing = time_plan(read(path).plan(), model)
    except OlpError:
        return None
    moves = timing.plan.moves
    if any(d.is_error for d in timing.diagnostics) or not len(moves) or not (timing.rows.length > 0).any():
        return None
    return timing


def moving(path: Path, model: str) -> Timing:
    timing = timed(path, model)
    if timing is None:
        pytest.skip("nothing moves, or not all of it can be timed")
    return timing


EVERY_SAMPLE = pytest.mark.parametrize("path", SAMPLES, ids=lambda path: "/".join(path.parts[1:]))
EVERY_MODEL = pytest.mark.parametrize("model", model_names())


def leading(timing: Timing) -> np.ndarray:
    """The first row of every move."""
    return timing.plan.row[timing.plan.kind == StepKind.MOVE].astype(int)


def clock(timing: Timing, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """[s] when each row begins and ends, corners included."""
    times = timing.rows
    lasting = (times.entry + times.profile.duration + times.corners.span)[rows]
    return times.start[rows], times.start[rows] + lasting / times.rate[rows]


@EVERY_SAMPLE
@EVERY_MODEL
def test_every_row_goes_its_way_without_a_jump_of_speed_and_within_its_acceleration(path, model):
    timing = moving(path, model)
    times, asked = timing.rows, timing.rows.profile.moves
    rows = np.flatnonzero((times.length > 1e-6) & np.isfinite(times.profile.duration) & (times.rate <= 1.0))[
        :_MOST
    ]
    begin, end = clock(timing, rows)
    instants = begin + (end - begin) * np.linspace(-0.02, 1.02, _INSTANTS)[:, None]
    shares = np.stack([times.fraction(rows, at) for at in instants])
    assert shares[0] == pytest.approx(0.0, abs=1e-12)
    assert shares[-1] == pytest.approx(1.0, abs=1e-9)
    assert np.diff(shares, axis=0).min() > -1e-9, "a row never goes back"
    body = times.start[rows] + times.entry[rows] / times.rate[rows]
    lasting = times.profile.duration[rows] / times.rate[rows]
    instants = body + lasting * np.linspace(0.0, 1.0, _INSTANTS)[:, None]
    step = np.maximum(instants[1] - instants[0], 1e-9)
    way = np.stack([times.fraction(rows, at) for at in instants]) * times.length[rows]
    speeds = np.diff(way, axis=0) / step
    changes = np.abs(np.diff(speeds, axis=0)) / step
    limit = np.maximum(asked.acceleration, asked.deceleration)[rows]
    long = lasting > 1e-3  # below that rounding is all that differences show
    assert (changes.max(axis=0) <= limit * _STRAIGHTNESS + 1e-12 / step**2)[long].all()
    assert (speeds.max(axis=0) <= np.maximum(asked.speed, asked.start_speed)[rows] * (1 + 1e-6) + 1e-9)[
        long
    ].all()


@EVERY_SAMPLE
@EVERY_MODEL
def test_the_tool_has_one_place_and_one_speed_at_every_instant(path, model):
    """Where a row begins, enters its corner, leaves it or ends, and nowhere else, could either jump."""
    timing = moving(path, model)
    times, rows = timing.rows, leading(timing)[:_MOST]
    begin, end = clock(timing, rows)
    edges = np.concatenate(
        (
            begin,
            begin + times.entry[rows] / times.rate[rows],
            end - times.corners.span[rows] / times.rate[rows],
            end,
        )
    )
    edges = np.unique(np.clip(edges[np.isfinite(edges)], 1e-4, timing.total_s - 1e-4))
    tiny = 1e-5
    at = (edges[:, None] + tiny * np.array([-2.0, -1.0, 1.0, 2.0])).ravel()
    place = tool_position(timing, at).reshape(-1, 4, 3)
    place = place[same_tool(timing, edges) & np.isfinite(place).all(axis=(1, 2))]
    before, across, after = (np.diff(place, axis=1)[:, i] for i in range(3))
    # Twice the step for the middle one; 60 m/s² is far above any limit here and far below what a jump makes.
    slack = 1e-9 + 60.0 * 4 * tiny**2
    assert np.linalg.norm(across - before - after, axis=1).max(initial=0.0) <= slack
    assert np.linalg.norm(after - before, axis=1).max(initial=0.0) <= slack


def same_tool(timing: Timing, edges: np.ndarray) -> np.ndarray:
    """Where the tool's point is not another one from this instant on."""
    plan, rows = timing.plan, leading(timing)
    here, there = plan.moves.target[rows[:-1]], plan.moves.start[rows[1:]]
    jump = np.linalg.norm(plan.positions.position[there] - plan.positions.position[here], axis=1) > 1e-9
    changes = timing.rows.start[rows[1:]][jump]
    near = np.abs(edges[:, None] - changes[None, :]) < 1e-4
    return ~near.any(axis=1)


@EVERY_SAMPLE
def test_lines_that_fade_into_each_other_keep_the_acceleration_of_lines(path):
    """Seen from outside: second differences of the tool's point while only lines run."""
    timing = moving(path, "constant")
    plan, times, rows = timing.plan, timing.rows, leading(timing)
    lines = (
        (plan.moves.path[rows] == PATHS.index(Kind.LINEAR))
        & (times.length[rows] > 1e-6)
        & (times.rate[rows] <= 1)
    )
    pairs = np.flatnonzero(lines[:-1] & lines[1:] & (times.previous[rows[1:]] == rows[:-1]))[:20]
    ours = plan.moves.blend_code[rows[pairs]] != BlendCode.RADIUS
    if plan.zone_law != "yaskawa":
        ours &= plan.moves.blend_code[rows[pairs]] == BlendCode.UNTAGGED
    asked = times.profile.moves
    for pair in pairs[ours]:
        one, two = rows[pair], rows[pair + 1]
        start, span = times.start[two], float(times.corners.span[one])
        if start + span > timing.total_s or span < 1e-4:
            continue
        instants = np.linspace(start, start + span, 80)
        place = tool_position(timing, instants)
        pushes = np.linalg.norm(np.diff(place, 2, axis=0), axis=1) / (instants[1] - instants[0]) ** 2
        limit = max(asked.deceleration[one], asked.acceleration[two])
        assert np.nanmax(pushes, initial=0.0) <= limit * _STRAIGHTNESS + 1e-6


@EVERY_SAMPLE
@EVERY_MODEL
def test_the_track_ends_every_segment_when_the_table_does_and_stands_at_exact_stops(path, model):
    timing = moving(path, model)
    plan, rows = timing.plan, leading(timing)
    steps = np.flatnonzero(plan.kind == StepKind.MOVE)
    stops = (plan.moves.blend_code[rows] == BlendCode.EXACT) & (timing.rows.length[rows] > 1e-6)
    stops = stops[:_MOST]
    ends, rows = timing.end_s[steps[: len(stops)]][stops], rows[: len(stops)][stops]
    if len(rows):
        at = np.stack((np.maximum(ends - 1e-6, 0.0), ends), axis=1).ravel()
        place = tool_position(timing, at).reshape(-1, 2, 3)
        wanted = plan.positions.position[plan.moves.target[rows]]
        assert np.nan_to_num(np.abs(place[:, 1] - wanted)).max() < 1e-7
        assert np.nan_to_num(np.linalg.norm(place[:, 1] - place[:, 0], axis=1)).max() / 1e-6 < 1e-3
    total = timing.total_s
    if total / 200 > 0:
        way = track(timing, max(total / 30, 1e-3))
        assert way.time[-1] == pytest.approx(total, abs=1e-9)
        table = np.searchsorted(timing.end_s, way.time, side="left")
        assert (way.segment == np.minimum(table, len(plan) - 1)).all()
        last = states(timing, np.array([total]))[0][0]
        where = plan.positions.position[plan.moves.target[leading(timing)[-1]]]
        assert np.nan_to_num(np.abs(last - where)).max() < 1e-7
