"""A signature from the totals of programs, when no single move was measured.

The plan says which moves a program runs and olp times what the signature does not speak of; what is left of the
total is a sum over its straight moves. Such sums tell a Gaussian process as single values do, only less (method
`averaged_process`).

Codes: H030 a file of totals that cannot be, H031 programs that were left out, H032 too few programs.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError, error
from olp.core.version import __version__
from olp.identification.signature.document import Learnt, Signature
from olp.identification.signature.domain import domain_of
from olp.identification.signature.errors import ErrorModel, Spread
from olp.identification.signature.estimator import Parameters, duration_of, load_estimator
from olp.identification.signature.estimators.averaged_process import parameters_of, views_of
from olp.identification.signature.mixture import Observations, answer, ruler_of
from olp.identification.signature.moveset import MoveSet

if TYPE_CHECKING:
    from olp.robots.robot import Robot

Floats = NDArray[np.float64]
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
