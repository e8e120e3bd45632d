"""Programs and their measured totals: a table of totals, and what the plans say of each program.

The table is a CSV with the columns `job` (a file, from the table's folder) and `total_s`; rows of one job are repeated
cycles, whose mean counts. Codes: H030, H031 (see partial_totals).
"""

from __future__ import annotations

import csv
import hashlib
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, Span, error, warning
from olp.core.files import read_input
from olp.core.version import __version__
from olp.identification.signature.coefficients import Parameters
from olp.identification.signature.document import Learnt, Signature
from olp.identification.signature.domain import domain_of
from olp.identification.signature.errors import ErrorModel, Spread
from olp.identification.signature.estimator import duration_of, load_estimator
from olp.identification.signature.estimators.averaged_process import parameters_of, views_of
from olp.identification.signature.mixture import Observations, answer, ruler_of
from olp.identification.signature.moveset import MoveSet
from olp.ir.program import Path as Shape
from olp.robots.geometry import Pose, rotation_from_quaternion
from olp.robots.kinematics.configuration import forward
from olp.robots.model import Robot
from olp.runtime.plan import PATHS, BlendCode, StepKind
from olp.timing.result import Timing

Floats = NDArray[np.float64]
_STRAIGHT = PATHS.index(Shape.LINEAR)
# [m] Tools nearer than this are one tool.
_SAME_TOOL = 1e-4
# Straight moves of all programs together: the covariance of every pair is held in memory.
_MOST_MOVES = 2000
_MOST_BYTES = 50_000_000


class TotalsTable(NamedTuple):
    """`totals`: per job file the measured totals [s], in the order of the rows."""

    path: str
    totals: dict[Path, list[float]]
    sha256: str


class Programs(NamedTuple):
    totals: Totals
    robot: Robot
    tool: Pose | None
    scatter: float  # [s] between cycles of one program, nan where nothing was repeated
    told: tuple[Diagnostic, ...]


def read_totals(path: str | Path) -> TotalsTable:
    """Raises OlpError (H030) with everything that is wrong."""
    file = str(path)
    try:
        data = read_input(path, _MOST_BYTES)
    except OSError as problem:
        raise OlpError(error("H030", problem.strerror or "cannot be read", file=file)) from None
    try:
        rows = list(csv.reader(data.decode("utf-8-sig").splitlines()))
    except (UnicodeDecodeError, csv.Error) as problem:
        raise OlpError(error("H030", f"not a CSV: {problem}", file=file)) from None
    head = [name.strip() for name in rows[0]] if rows else []
    missing = [name for name in ("job", "total_s") if name not in head]
    if missing:
        says = f"no column {' and no column '.join(missing)}"
        raise OlpError(error("H030", says, file=file, help="the columns are job and total_s"))
    job, total = head.index("job"), head.index("total_s")
    found: dict[Path, list[float]] = {}
    problems: list[Diagnostic] = []
    for number, row in enumerate(rows[1:], 2):
        if not any(cell.strip() for cell in row):
            continue
        cells = [*row, *[""] * len(head)]
        try:
            value = float(cells[total])
        except ValueError:
            value = math.nan
        if not cells[job].strip() or not (math.isfinite(value) and value > 0):
            says = (
                f"job {cells[job]!r} with total_s {cells[total]!r}: a file and seconds above zero are needed"
            )
            problems.append(error("H030", says, Span(number), file=file))
            continue
        found.setdefault(Path(path).parent / cells[job].strip(), []).append(value)
    if problems or not found:
        raise OlpError(*(problems or [error("H030", "the table has no rows", file=file)]))
    return TotalsTable(file, found, hashlib.sha256(data).hexdigest())


def programs_of(table: TotalsTable, robot: str | None = None) -> Programs:
    """Plans every program. Raises OlpError: what a program cannot be read for, H031 when none can be used."""
    from olp.identification.timing_job import TimingJob, plan_and_time

    sets: list[tuple[MoveSet, float]] = []
    measured: list[list[float]] = []
    told: list[Diagnostic] = []
    found: Robot | None = None
    for file, values in table.totals.items():
        timing = plan_and_time(str(file), TimingJob(robot=robot))
        arm = timing.plan.robot
        why = _unusable(timing, found)
        moves, rest = stops_of(timing)
        if not why and not len(moves):
            why = "no straight move from stop to stop"
        if not why and sets and _differs(moves.tool, sets[0][0].tool):
            why = "it moves another tool than the others"
        if not why and sum(len(known) for known, _ in sets) + len(moves) > _MOST_MOVES:
            why = f"the programs before it have {_MOST_MOVES} moves already"
        if why or arm is None:
            told.append(warning("H031", f"left out: {why}", file=str(file)))
            continue
        found = arm
        sets.append((moves, rest))
        measured.append(values)
    if found is None:
        raise OlpError(*(error("H031", d.message, file=d.file) for d in told))
    totals = gather(sets, np.array([float(np.mean(values)) for values in measured]))
    return Programs(totals, found, sets[0][0].tool, _scatter(measured), tuple(told))


def gather(programs: list[tuple[MoveSet, float]], total: Floats) -> Totals:
    """Programs, each with its moves and the rest [s], and their totals (m,) [s]."""
    sets = [moves for moves, _ in programs]
    owner = np.repeat(np.arange(len(sets), dtype=np.int64), [len(moves) for moves in sets])
    together = MoveSet(
        start=np.concatenate([moves.start for moves in sets]),
        end=np.concatenate([moves.end for moves in sets]),
        rotation=np.concatenate([moves.rotation for moves in sets]),
        speed=np.concatenate([moves.speed for moves in sets]),
        nominal=np.concatenate([moves.nominal for moves in sets]),
        duration=np.concatenate([moves.duration for moves in sets]),
        payload=np.concatenate([moves.payload for moves in sets]),
        configuration=tuple(c for moves in sets for c in moves.configuration),
        program=tuple(p for moves in sets for p in moves.program),
        tool=sets[0].tool,
        joints=_together([moves.joints for moves in sets], [len(moves) for moves in sets]),
    )
    return Totals(together, owner, np.asarray(total), np.array([rest for _, rest in programs]))


def _together(joints: list[Floats | None], counts: list[int]) -> Floats | None:
    """(n, 2, k) [rad] of all programs; None when any has other axes."""
    known = [values for values in joints if values is not None]
    widths = {values.shape[2] for values in known}
    if len(widths) != 1 or len(known) < len(counts):
        return None
    return np.concatenate(known)


def stops_of(timing: Timing) -> tuple[MoveSet, float]:
    """The straight moves from exact stop to exact stop of a timed plan, and the seconds of everything else."""
    plan, moves, positions = timing.plan, timing.plan.moves, timing.plan.positions
    steps = np.nonzero(plan.kind == StepKind.MOVE)[0]
    row = plan.row[steps].astype(np.int64)
    exact = moves.blend_code[row] == BlendCode.EXACT
    from_stop = np.concatenate([[True], exact[:-1]])
    arm = np.array([robot is not None and robot is plan.robot for robot in plan.robots] or [False])
    known = np.asarray(np.isfinite(positions.position).all(axis=1))
    wanted = (moves.path[row] == _STRAIGHT) & exact & from_stop & arm[moves.mechanism[row]]
    wanted &= np.isfinite(moves.travel[row]) & (np.nan_to_num(moves.length[row]) > 0)
    wanted &= known[moves.start[row]] & known[moves.target[row]]
    steps, row = steps[wanted], row[wanted]
    count = len(row)
    rotation = np.full((count, 3, 3), np.nan)
    turned = positions.quaternion[moves.start[row]]
    told = np.asarray(np.isfinite(turned).all(axis=1))
    if told.any():
        rotation[told] = rotation_from_quaternion(turned[told])
    nothing = np.full(count, np.nan)
    found = MoveSet(
        start=positions.position[moves.start[row]],
        end=positions.position[moves.target[row]],
        rotation=rotation,
        speed=moves.travel[row],
        nominal=timing.accel_mm_s2[steps] / 1000.0,
        duration=nothing,
        payload=nothing,
        configuration=("",) * count,
        program=(plan.path,) * count,
        tool=_tool_of(timing, row),
        joints=np.stack([positions.axes[moves.start[row]], positions.axes[moves.target[row]]], axis=1),
    )
    return found, float(np.nansum(timing.duration_s) - np.nansum(timing.duration_s[steps]))


def _tool_of(timing: Timing, rows: NDArray[np.int64]) -> Pose | None:
    """The tool of the first of these moves: what lies between the flange, told by the axes, and the planned point."""
    plan = timing.plan
    if plan.robot is None or plan.robot.geometry is None:
        return None
    for place in plan.moves.start[rows].tolist():
        axes, turned = plan.positions.axes[place], plan.positions.quaternion[place]
        if np.isfinite(axes).all() and np.isfinite(turned).all() and len(axes) == len(plan.robot.axes):
            flange, rotation = forward(plan.robot, axes[None])
            point = Pose(plan.positions.position[place], rotation_from_quaternion(turned[None])[0])
            return Pose(flange[0], rotation[0]).inverse() @ point
    return None


def _differs(one: Pose | None, other: Pose | None) -> bool:
    if one is None or other is None:
        return one is not other
    return float(np.abs(one.xyz_angles()[:3] - other.xyz_angles()[:3]).max()) > _SAME_TOOL


def _unusable(timing: Timing, robot: Robot | None) -> str:
    if timing.plan.robot is None:
        return "its robot is not known"
    if robot is not None and timing.plan.robot.name != robot.name:
        return f"it is for {timing.plan.robot.name}, the others are for {robot.name}"
    if timing.untimed:
        return f"{timing.untimed} of its steps cannot be timed"
    return ""


def _scatter(measured: list[list[float]]) -> float:
    off = [value - float(np.mean(values)) for values in measured for value in values]
    freedom = sum(len(values) - 1 for values in measured)
    return math.sqrt(sum(v * v for v in off) / freedom) if freedom else math.nan


# --- Partial totals ---
# A signature from the totals of programs, when no single move was measured.
#
# The plan says which moves a program runs and olp times what the signature does not speak of; what is left of the
# total is a sum over its straight moves. Such sums tell a Gaussian process as single values do, only less (method
# `averaged_process`).
#
# Codes: H030 a file of totals that cannot be, H031 programs that were left out, H032 too few programs.

Labels = NDArray[np.int64]

METHOD = "averaged_process"
FEWEST = 4
_PARTS = 5
_ROUNDS = 3
_NORMAL = 1.96


class Totals(NamedTuple):
    """m programs with n straight moves. `owner` (n,): program of each move; `total`, `rest` (m,) [s].

    `total`: measured, the mean of its cycles. `rest`: what olp says of all other steps.
    """

    moves: MoveSet
    owner: Labels
    total: Floats
    rest: Floats

    def take(self, programs: Labels) -> Totals:
        number = np.full(len(self.total), -1, dtype=np.int64)
        number[programs] = np.arange(len(programs))
        kept = number[self.owner] >= 0
        return Totals(
            self.moves.take(kept), number[self.owner[kept]], self.total[programs], self.rest[programs]
        )


def fit_totals(totals: Totals, robot: Robot) -> Parameters:
    """What `averaged_process` learns from sums."""
    views = views_of(totals.moves, robot)
    known = np.asarray(np.isfinite(views.terms).all(axis=1))
    # A move whose axes are not known is taken as an average one.
    middle = views.terms[known].mean(axis=0)
    views = views._replace(terms=np.where(known[:, None], views.terms, middle))
    slowness = np.full(len(totals.owner), _even(totals))
    for _ in range(_ROUNDS):
        seen = _observed(totals, slowness)
        slowness = np.maximum(answer(views, seen, ruler_of(views), views).mean, 1e-3)
    return parameters_of(views, _observed(totals, slowness))


def signature_of_totals(
    totals: Totals, robot: Robot, name: str = "", sha256: str = "", tool: tuple[float, ...] | None = None
) -> Signature:
    """Raises OlpError (H032) with fewer than FEWEST programs."""
    if len(totals.total) < FEWEST:
        says = f"{len(totals.total)} programs with straight moves from stop to stop, at least {FEWEST} are needed"
        raise OlpError(error("H032", says, file=name))
    payload = totals.moves.payload[np.isfinite(totals.moves.payload)]
    return Signature(
        robot=robot.name,
        controller="",
        tool=tool,
        payload=float(np.median(payload)) if len(payload) else None,
        recording=Learnt(name, sha256, len(totals.owner), None),
        method=METHOD,
        parameters=fit_totals(totals, robot),
        errors=_errors(totals, robot),
        domain=domain_of(totals.moves),
        compared={},
        olp=__version__,
    )


def predicted_totals(parameters: Parameters, totals: Totals, robot: Robot) -> Floats:
    """(m,) [s]"""
    said = load_estimator(METHOD).estimate(parameters, totals.moves, robot)
    times = duration_of(said.slowness, totals.moves)
    return totals.rest + np.bincount(totals.owner, times, len(totals.total))


def _even(totals: Totals) -> float:
    """[s²/m] The one slowness that all programs together have."""
    moves = totals.moves
    over = float(np.sum(totals.total - totals.rest) - np.sum(moves.length / moves.speed))
    return max(over / float(np.sum(moves.speed)), 0.1)


def _observed(totals: Totals, slowness: Floats) -> Observations:
    """The sums, linear about `slowness`: where the speed is not reached a move takes 2 √(L s)."""
    moves = totals.moves
    reached = moves.speed**2 * slowness <= moves.length
    share = np.where(reached, moves.speed, np.sqrt(moves.length / slowness))
    fixed = duration_of(slowness, moves) - share * slowness
    left = totals.total - totals.rest - np.bincount(totals.owner, fixed, len(totals.total))
    return Observations(left, totals.owner, share)


def _errors(totals: Totals, robot: Robot) -> ErrorModel:
    """From programs that are held out: what all moves of one share, and what each has of its own."""
    count = len(totals.total)
    parts = np.arange(count) % min(_PARTS, count)
    shared: list[float] = []
    own: list[float] = []
    for part in np.unique(parts).tolist():
        out = totals.take(np.nonzero(parts == part)[0])
        learnt = fit_totals(totals.take(np.nonzero(parts != part)[0]), robot)
        weight = np.bincount(out.owner, out.moves.speed, len(out.total))
        shared += ((out.total - predicted_totals(learnt, out, robot)) / weight).tolist()
        own += load_estimator(METHOD).estimate(learnt, out.moves, robot).sd.tolist()
    between = math.sqrt(float(np.mean(np.square(shared))))
    single = math.sqrt(float(np.mean(np.square(own))))
    spread = Spread(_NORMAL * math.hypot(between, single), between, single, count)
    return ErrorModel(spread, spread._replace(half=1.5 * spread.half, shared=1.5 * spread.shared))
