"""The moves that tell most, against others: python bench/probe.py

20 of the UP20's 146 measured moves are chosen from their coordinates alone, the other 126 are predicted. Nothing of the
126 is used for fitting or for a method's own numbers; the method was developed on this robot, see docs/probe.md.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command line does

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from olp.identification.probe.experiment import most_telling  # noqa: E402
from olp.identification.recording import read_recording  # noqa: E402
from olp.identification.signature import MoveSet, moves_of_recording  # noqa: E402
from olp.identification.signature.domain import points, spread_out  # noqa: E402
from olp.identification.signature.estimator import duration_of, load_estimator  # noqa: E402
from olp.identification.signature.estimators.averaged_process import views_of  # noqa: E402
from olp.identification.signature.learn import fit_moves  # noqa: E402
from olp.identification.signature.mixture import average_covariance, ruler_of  # noqa: E402
from olp.robots.robot import load_robot  # noqa: E402

ROBOT = load_robot("yaskawa/up20")
METHODS = ("averaged_process", "terms_and_places", "axis_terms_gp", "axis_terms", "gaussian_process")
COUNT, RANDOM = 20, 100
ASKED = 0.55
Labels = NDArray[np.int64]


def designed(moves: MoveSet, count: int, known: Labels | None = None) -> Labels:
    """As `olp probe` does it, from coordinates alone; with `known` rows as `olp probe --next` does it."""
    blind = MoveSet(
        moves.start,
        moves.end,
        moves.rotation,
        moves.speed,
        np.full(len(moves), np.nan),
        np.full(len(moves), np.nan),
        moves.payload,
        moves.configuration,
        moves.program,
        moves.tool,
    )
    views = views_of(blind, ROBOT)
    covariance = average_covariance(views, views, ruler_of(views))
    measured = np.zeros(len(moves), dtype=bool)
    if known is not None:
        measured[known] = True
    more = most_telling(covariance, count, measured, ~measured)
    return np.sort(np.concatenate([np.nonzero(measured)[0], more]))


def errors(moves: MoveSet, rows: Labels, method: str) -> tuple[float, float]:
    """Mean and worst percentage error of the moves that are not among `rows`."""
    estimator = load_estimator(method)
    rest = moves.take(np.setdiff1d(np.arange(len(moves)), rows))
    learnt = estimator.fit(moves.take(rows), ROBOT)
    said = duration_of(estimator.estimate(learnt, rest, ROBOT).slowness, rest)
    percent = 100 * np.abs(said - rest.duration) / rest.duration
    return float(percent.mean()), float(percent.max())


def main() -> int:
    moves, _ = moves_of_recording(read_recording(ROOT / "samples" / "up20"))
    chosen, spread = designed(moves, COUNT), spread_out(points(moves), COUNT)
    dice = np.random.default_rng(20)
    thrown = [np.sort(dice.choice(len(moves), COUNT, replace=False)) for _ in range(RANDOM)]
    print(f"{COUNT} of {len(moves)} moves, the others predicted: mean error % (worst)")
    print(f"{'method':<20}{'chosen by olp probe':>21}{'spread out':>16}{f'random, mean of {RANDOM}':>23}")
    for method in METHODS:
        ours, far = errors(moves, chosen, method), errors(moves, spread, method)
        mean, worst = np.mean([errors(moves, rows, method) for rows in thrown], axis=0)
        print(
            f"{method:<20}{ours[0]:>13.2f} ({ours[1]:4.1f} ){far[0]:>8.2f} ({far[1]:4.1f} )"
            f"{mean:>15.2f} ({worst:4.1f} )"
        )
    picked = fit_moves(moves.take(chosen), ROBOT).method
    print(
        f"auto, by what the {COUNT} hold out of themselves: {picked}, {errors(moves, chosen, picked)[0]:.2f} %"
    )
    print(
        "moves chosen  "
        + "  ".join(
            f"{n}: {errors(moves, designed(moves, n), METHODS[0])[0]:.2f} %" for n in (10, 15, 20, 25, 30, 40)
        )
    )
    later = designed(moves, 10, designed(moves, 10))
    print(f"10, then 10 more by --next: {errors(moves, later, METHODS[0])[0]:.2f} %")
    found = errors(moves, chosen, picked)[0]
    print(f"asked: {ASKED:.2f} %, found: {found:.2f} % ({picked}, by auto)")
    return 0 if found <= ASKED else 1


if __name__ == "__main__":
    raise SystemExit(main())
