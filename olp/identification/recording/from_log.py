"""Makes the moves of a recording out of a joint log and the program that ran.

Codes: D042 moves that the log does not show, D043 stretches of the log that the program does not explain, D044 the
log's clock, D045 how far the log's points lie off, D046 what the contract's columns cannot say.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, Span, error, info, warning
from olp.core.units import deg, mm
from olp.identification.recording.log import Log
from olp.identification.recording.moves import CIRCULAR, JOINT, LINEAR, WAIT, RecordedMoves
from olp.identification.recording.programmed import Moved, moved, tool_of, way_of
from olp.identification.recording.segments import Segments, by_counter, by_dwell, by_points
from olp.ir.program import Path
from olp.robots.geometry import angles_from_rotation, rotation_from_quaternion
from olp.runtime.plan import PATHS, BlendCode

if TYPE_CHECKING:
    from olp.timing.result import Timing


Floats = NDArray[np.float64]
By = Literal["auto", "points", "counter", "dwell"]
_KINDS = {Path.JOINT: JOINT, Path.LINEAR: LINEAR}
_CORNERS = {
    BlendCode.EXACT: "stop",
    BlendCode.ZONE: "zone",
    BlendCode.UNTAGGED: "untagged",
    BlendCode.RADIUS: "zone",
}
_OFF = 1.0 * mm
_TURNED = 5.0 * deg
_LISTED = 12


@dataclass(frozen=True, slots=True)
class FromLog:
    """What came out: `planned` (n,) [s] beside each of the `moves`; `clock` None for fewer than three instants."""

    moves: RecordedMoves
    planned: Floats
    by: str
    tool: (
        tuple[float, ...] | None
    )  # x, y, z [m], Rx, Ry, Rz [rad] on the flange, if one tool was used throughout
    clock: ClockAlignment | None
    diagnostics: tuple[Diagnostic, ...]


def moves_from_log(log: Log, timing: Timing, by: By = "auto") -> FromLog:
    """The measured moves of the program behind `timing`, in the order it executed them.

    `by`: "counter" when the log has the column `move`, else "points" when the robot is known, else "dwell" (auto).
    Moves that the log does not show are left out and told. Raises OlpError: D040, D041, or when the plan cannot be
    timed or followed.
    """
    if len(log) < 2:
        raise OlpError(error("D041", "the log has fewer than two samples", file=log.file))
    moves = moved(timing)
    if not len(moves):
        raise OlpError(error("D041", "this program moves nothing", file=timing.plan.path))
    chosen = by if by != "auto" else _choose(log, timing)
    if chosen == "counter":
        found = by_counter(moves, log)
    elif chosen == "points":
        found = by_points(moves, way_of(moves), log)
    else:
        found = by_dwell(moves, log)
    clock = fit_clock(np.append(moves.begin, moves.end), np.append(found.begin, found.end))
    told = _told(moves, found, clock, log)
    recorded, planned = _recorded(moves, found, log)
    told += unsayable(recorded, timing)
    return FromLog(recorded, planned, chosen, tool_of(moves), clock, tuple(told))


def _choose(log: Log, timing: Timing) -> str:
    if log.move is not None and (log.move >= 0).any():
        return "counter"
    robot = timing.plan.robot
    return "points" if robot is not None and robot.geometry is not None else "dwell"


def _recorded(moves: Moved, found: Segments, log: Log) -> tuple[RecordedMoves, Floats]:
    """Seen moves with their waits, in order, and what the plan gives each."""
    plan, timing = moves.timing.plan, moves.timing
    seen = np.nonzero(found.seen & np.isfinite(found.begin))[0]
    rests = np.nonzero(found.seen & np.isfinite(found.until))[0]
    owner = np.concatenate([seen, rests])
    waits = np.concatenate([np.zeros(len(seen), dtype=bool), np.ones(len(rests), dtype=bool)])
    order = np.lexsort((waits, owner))
    owner, waits = owner[order], waits[order]
    begin = np.where(waits, found.end[owner], found.begin[owner])
    end = np.where(waits, found.until[owner], found.end[owner])
    follows = np.append(moves.begin[1:], timing.total_s)
    planned = np.where(waits, follows[owner] - moves.end[owner], moves.end[owner] - moves.begin[owner])
    rows = plan.row[moves.step[owner]]
    step = np.where(waits, np.minimum(moves.step[owner] + 1, len(plan) - 1), moves.step[owner])
    axes, width = plan.positions.axes, len(log.slides)
    joints = [
        _joints(axes[chosen[rows]], log, instants, width)
        for chosen, instants in ((plan.moves.start, begin), (plan.moves.target, end))
    ]
    recorded = recorded_steps(timing, rows, step, waits, (joints[0], joints[1]), log.slides)
    return replace(recorded, duration=end - begin, t_start=begin), planned


def recorded_steps(
    timing: Timing,
    rows: NDArray[np.int32],
    step: NDArray[np.intp],
    waits: NDArray[np.bool_],
    joints: tuple[Floats, Floats],
    slides: tuple[bool, ...],
) -> RecordedMoves:
    """Steps of a plan as rows of a recording, without their times.

    `rows` (n,) of its moves, `step` (n,) whose line counts, `waits` (n,) which of them are waits behind the move;
    `joints` (n, k) [rad | m] where each begins and ends, `slides` (k,) which axes are lengths.
    """
    plan = timing.plan
    asked, positions = plan.moves, plan.positions
    nothing = np.where(waits, np.nan, 0.0)
    start, target = asked.start[rows], asked.target[rows]
    kind = np.array([_KINDS.get(PATHS[code], CIRCULAR) for code in asked.path[rows].tolist()], dtype=np.int8)
    kind[waits] = WAIT
    via = np.where((kind == CIRCULAR)[:, None], _middles(timing, rows), np.nan)
    angles = [
        angles_from_rotation(rotation_from_quaternion(positions.quaternion[chosen])) + nothing[:, None]
        for chosen in (start, target)
    ]
    corner = [_CORNERS[BlendCode(code)] for code in asked.blend_code[rows].tolist()]
    zone = np.isin(asked.blend_code[rows], (BlendCode.ZONE, BlendCode.RADIUS))
    full = np.abs(asked.acceleration[rows] - 1.0) < 1e-9
    turn = asked.turn[rows] / deg + nothing
    sources = plan.source[step].tolist()
    return RecordedMoves(
        move=np.arange(1, len(rows) + 1),
        kind=kind,
        duration=np.full(len(rows), np.nan),
        sim=np.full(len(rows), np.nan),
        start=positions.position[start] + nothing[:, None],
        end=positions.position[target] + nothing[:, None],
        via=via,
        start_angles=angles[0],
        end_angles=angles[1],
        joints_start=joints[0] + nothing[:, None],
        joints_end=joints[1] + nothing[:, None],
        slides=slides,
        speed=asked.travel[rows] + nothing,
        speed_fraction=asked.fraction[rows] + nothing,
        acceleration=np.full(len(rows), np.nan),
        acceleration_fraction=np.where(full, np.nan, asked.acceleration[rows]) + nothing,
        blend=np.where(zone, asked.blend[rows], 0.0),
        level=np.full(len(rows), -1, dtype=np.int8),
        t_start=np.full(len(rows), np.nan),
        cycle=np.full(len(rows), -1),
        line=plan.line[step].astype(np.int64),
        job=tuple(os.path.basename(plan.sources[s].path) for s in sources),
        payload=np.full(len(rows), np.nan),
        payload_inertia=np.full(len(rows), np.nan),
        covariates={} if np.isnan(turn).all() else {"speed_deg_s": turn},
        texts={
            "corner": tuple("" if wait else word for word, wait in zip(corner, waits.tolist(), strict=True))
        },
    )


def _joints(axes: Floats, log: Log, instants: Floats, width: int) -> Floats:
    """(n, k) programmed axes; the log's where they are not known or the arm stood in another configuration."""
    from olp.identification.recording.fit import interpolate

    there = interpolate(log.time, log.q, instants)
    asked = np.full_like(there, np.nan)
    asked[:, : min(width, axes.shape[1])] = axes[:, :width]
    same = np.asarray((np.abs(asked - there) < _TURNED).all(axis=1))
    chosen: Floats = np.where(same[:, None], asked, there)
    return chosen


def _middles(timing: Timing, rows: NDArray[np.int32]) -> Floats:
    """(n, 3) [m] half-way along each move's path, as the plan's tool goes it without rounded corners."""
    from olp.runtime.paths import point_on_arc, point_on_parabola

    asked, positions = timing.plan.moves, timing.plan.positions
    a, b = positions.position[asked.start[rows]], positions.position[asked.target[rows]]
    middle = (a + b) / 2
    half = np.full(len(rows), 0.5)
    for path, shape in ((Path.CIRCULAR, point_on_arc), (Path.SPLINE, point_on_parabola)):
        bent = (asked.path[rows] == PATHS.index(path)) & (asked.via[rows] >= 0)
        if bent.any():
            third = positions.position[asked.via[rows][bent]]
            middle[bent] = shape(a[bent], b[bent], third, asked.before[rows][bent], half[bent])
    return middle


def _told(moves: Moved, found: Segments, clock: ClockAlignment | None, log: Log) -> list[Diagnostic]:
    plan = moves.timing.plan
    told: list[Diagnostic] = []
    for steps, why in (
        (moves.step[~found.seen], "does not show"),
        (moves.idle, "cannot show, they go nowhere:"),
    ):
        if not len(steps):
            continue
        lines = ", ".join(str(plan.line[s]) for s in steps[:_LISTED].tolist()) + (
            " …" if len(steps) > _LISTED else ""
        )
        span = Span(int(plan.line[steps[0]]))
        says = f"{len(steps)} of {len(moves) + len(moves.idle)} moves that the log {why} line {lines}"
        make = warning if steps is not moves.idle else info
        told.append(make("D042", says, span, file=plan.sources[int(plan.source[steps[0]])].path))
    for begin, end in found.unexplained[:_LISTED]:
        says = f"from {begin:.9g} to {end:.9g} s the log moves where the program does not go"
        told.append(warning("D043", says, file=log.file))
    if len(found.unexplained) > _LISTED:
        told.append(warning("D043", f"{len(found.unexplained) - _LISTED} more such stretches", file=log.file))
    if clock is not None:
        says = (
            f"the log's clock reads {clock.offset:.9g} s (± {2 * clock.offset_error:.3g}) when the plan begins, "
            f"and runs {clock.rate:.6f} (± {2 * clock.rate_error:.6f}) times as fast; "
            f"instants scatter by {clock.scatter:.4f} s"
        )
        told.append(info("D044", says, file=log.file, help="durations are the log's own seconds"))
    if found.offset is not None and float(np.linalg.norm(found.offset)) > _OFF:
        x, y, z = (found.offset / mm).tolist()
        says = f"the flange in the log is x {x:+.1f}, y {y:+.1f}, z {z:+.1f} mm off the program's (median)"
        told.append(
            warning("D045", says, file=log.file, help="another tool, frame or robot than when it ran?")
        )
    return told


def unsayable(moves: RecordedMoves, timing: Timing) -> list[Diagnostic]:
    """Corners without a level, curves that are no arcs."""
    told = []
    untagged = sum(word == "untagged" for word in moves.texts["corner"])
    if untagged:
        says = f"corners without a position level: {untagged}; the column corner says untagged there"
        told.append(info("D046", says, file=timing.plan.path))
    splines = int((timing.plan.moves.path == PATHS.index(Path.SPLINE)).sum())
    if splines:
        says = f"splines: {splines}, written as circular moves through their middles"
        told.append(warning("D046", says, file=timing.plan.path))
    return told


# --- Clock ---
# How a log's clock runs against the plan's: offset and rate, robust against moves that were timed wrongly.

_ROUNDS = 30
_HUBER = 1.345  # of the scatter: 95 % efficient for normal errors (P. J. Huber, "Robust Statistics", 1981)


class ClockAlignment(NamedTuple):
    """log time = offset + rate * plan time. The rate holds the log's clock and the plan's own error alike."""

    offset: float  # [s]
    rate: float  # [1]
    offset_error: float  # [s] standard error
    rate_error: float  # [1] standard error
    scatter: float  # [s] of single instants around the line


def fit_clock(plan: Floats, log: Floats) -> ClockAlignment | None:
    """The clock from instants (n,) [s] of both; None for fewer than three that differ."""
    good = np.isfinite(plan) & np.isfinite(log)
    x, y = plan[good], log[good]
    if len(x) < 3 or np.ptp(x) <= 0:
        return None
    # Epoch seconds would cost digits.
    shift = float(y[0])
    y = y - shift
    weight = np.ones(len(x))
    for _ in range(_ROUNDS):
        columns = np.stack([np.ones(len(x)), x], axis=1)
        normal = columns.T @ (weight[:, None] * columns)
        offset, rate = np.linalg.solve(normal, columns.T @ (weight * y))
        residual = y - offset - rate * x
        scale = max(1.4826 * float(np.median(np.abs(residual))), 1e-9)
        weight = np.minimum(1.0, _HUBER * scale / np.maximum(np.abs(residual), 1e-15))
    freedom = max(weight.sum() - 2.0, 1.0)
    scatter = float(np.sqrt((weight * residual**2).sum() / freedom))
    spread = scatter * np.sqrt(np.diag(np.linalg.inv(normal)))
    return ClockAlignment(float(offset) + shift, float(rate), float(spread[0]), float(spread[1]), scatter)
