"""How well a timing signature predicts moves of the UP20 that it has not seen.

    python bench/signature.py            the figures of docs/signature.md, about five minutes

Every line holds rows out, and everything else happens without them: the choice of the method, of its terms, lengths
and weights, the fit, and the width of the intervals. Rows that are held out are only ever compared with.
"""

from __future__ import annotations

import os
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command line does

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from olp.identification.recording import read_recording  # noqa: E402
from olp.identification.signature import MoveSet, moves_of_recording  # noqa: E402
from olp.identification.signature.document import Learnt, Signature  # noqa: E402
from olp.identification.signature.domain import domain_of  # noqa: E402
from olp.identification.signature.estimator import duration_of, estimator_names, load_estimator  # noqa: E402
from olp.identification.signature.learn import fit_moves  # noqa: E402
from olp.identification.signature.predict import Prediction, predict  # noqa: E402

Floats = NDArray[np.float64]
Labels = NDArray[np.int64]

RECORDING = read_recording(ROOT / "samples" / "up20")
MOVES = moves_of_recording(RECORDING)[0]
ROBOT = RECORDING.robot
SINGLY, TESTS = "one move at a time", "a whole test"


class Outcome(NamedTuple):
    """Held-out moves, all folds together."""

    percent: Floats  # [%] absolute error per move
    rows: NDArray[np.int64]
    inside: NDArray[np.bool_]  # measured within the 95 % interval of the move
    totals: list[
        tuple[float, float, bool]
    ]  # per fold: measured, predicted [s], whether the interval holds it
    methods: list[str]  # per fold, as chosen


def learnt(moves: MoveSet, method: str) -> Signature:
    """A signature of these moves alone."""
    fit = fit_moves(moves, ROBOT, method)
    facts = Learnt("fold", "", len(moves), 0.01)
    return Signature(
        ROBOT.name,
        "XRC",
        None,
        None,
        facts,
        fit.method,
        fit.parameters,
        fit.errors,
        domain_of(moves),
        fit.compared,
        "",
    )


def held_out(folds: list[NDArray[np.bool_]], method: str = "auto") -> Outcome:
    """Each mask of `folds` is predicted by a signature of all moves outside it."""
    percent, rows, inside, totals, methods = [], [], [], [], []
    for out in folds:
        signature = learnt(MOVES.take(~out), method)
        asked = MOVES.take(out)
        said: Prediction = predict(signature, asked, ROBOT)
        percent.append(100 * np.abs(said.duration - asked.duration) / asked.duration)
        rows.append(np.nonzero(out)[0])
        inside.append((asked.duration >= said.low) & (asked.duration <= said.high))
        measured, total = float(asked.duration.sum()), float(said.duration.sum())
        totals.append((measured, total, abs(total - measured) <= said.total_half(signature)))
        methods.append(signature.method)
    return Outcome(np.concatenate(percent), np.concatenate(rows), np.concatenate(inside), totals, methods)


def singly(method: str = "auto") -> Outcome:
    """Each move by a signature of all others; method and error model are those of the moves outside its twelfth."""
    parts = np.arange(len(MOVES)) % 12
    percent, rows, inside, methods = [], [], [], []
    for part in range(12):
        base = learnt(MOVES.take(parts != part), method)
        estimator = load_estimator(base.method)
        for row in np.nonzero(parts == part)[0].tolist():
            out = np.arange(len(MOVES)) == row
            rest, asked = MOVES.take(~out), MOVES.take(out)
            signature = replace(base, parameters=estimator.fit(rest, ROBOT), domain=domain_of(rest))
            said = predict(signature, asked, ROBOT)
            percent.append(100 * np.abs(said.duration - asked.duration) / asked.duration)
            inside.append((asked.duration >= said.low) & (asked.duration <= said.high))
            rows.append(row)
        methods.append(base.method)
    return Outcome(np.concatenate(percent), np.array(rows), np.concatenate(inside), [], methods)


def masks(labels: Labels) -> list[NDArray[np.bool_]]:
    return [labels == label for label in np.unique(labels).tolist()]


def folds() -> dict[str, tuple[list[NDArray[np.bool_]], float, float]]:
    """Name -> masks held out, asked mean [%], asked worst [%] (0: not asked)."""
    count = np.arange(len(MOVES), dtype=np.int64)
    tests = np.unique(RECORDING.moves.texts["test"], return_inverse=True)[1].astype(np.int64)
    return {
        SINGLY: (masks(count % 12), 0.20, 0.0),
        "two thirds": ([count % 3 != 0], 0.22, 0.0),
        "four fifths": ([count % 5 != 0], 0.35, 0.0),
        "a whole start point": (masks(MOVES.start_labels), 0.80, 3.5),
        TESTS: (masks(tests), 1.50, 0.0),
    }


def chosen(outcome: Outcome) -> str:
    """Which methods the folds chose, and how often."""
    names, count = np.unique(outcome.methods, return_counts=True)
    return ", ".join(f"{n} {c}x" for n, c in zip(names.tolist(), count.tolist(), strict=True))


def per_fold(outcome: Outcome, masks_: list[NDArray[np.bool_]]) -> list[float]:
    """[%] mean error of each fold."""
    return [float(outcome.percent[np.isin(outcome.rows, np.nonzero(m)[0])].mean()) for m in masks_]


def figures() -> bool:
    """Prints the table; returns whether all asked figures hold."""
    print("held out                mean %  asked  worst %  asked  95 % covers  totals  method")
    good = True
    for name, (out, asked, worst) in folds().items():
        found = singly() if name == SINGLY else held_out(out)
        mean, most = float(found.percent.mean()), float(found.percent.max())
        cover = 100 * float(found.inside.mean())
        held = sum(ok for *_, ok in found.totals)
        totals = f"{held}/{len(found.totals)}" if found.totals else "-"
        top = f"{worst:6.1f}" if worst else "     -"
        print(
            f"{name:22s} {mean:7.3f} {asked:6.2f} {most:8.2f} {top} {cover:11.1f}%  {totals:6s}  {chosen(found)}",
            flush=True,
        )
        if len(found.totals) > 1:
            print(f"{'':22s} " + " ".join(f"{m:.2f}" for m in per_fold(found, out)))
        # Of tests each is asked, of start points the mean.
        mean = max(per_fold(found, out)) if name == TESTS else mean
        good &= mean <= asked and (not worst or most <= worst)
    return good


def methods() -> None:
    """Every estimator by itself: what the choice chooses from."""
    print("\nmean % / worst % of each method by itself, nothing chosen; whole tests one by one")
    kinds = folds()
    shown = ["a twelfth" if name == SINGLY else name for name in kinds]
    print(f"{'':20s} " + " ".join(f"{name:>20s}" for name in shown))
    for method in estimator_names():
        cells = [alone(out, method) for out, *_ in kinds.values()]
        if any(cells):
            said = [
                f"{np.mean(np.concatenate(c)):13.2f} /{np.max(np.concatenate(c)):5.1f}" if c else 20 * " "
                for c in cells
            ]
            tests = " ".join(f"{np.mean(fold):.2f}" for fold in cells[-1])
            print(f"{method:20s} " + " ".join(said) + f"  ({tests})", flush=True)


def alone(folds_: list[NDArray[np.bool_]], method: str) -> list[Floats]:
    """[%] absolute errors of each fold by what one method learns outside it; none where it cannot."""
    estimator, percent = load_estimator(method), []
    for out in folds_:
        rest, asked = MOVES.take(~out), MOVES.take(out)
        if estimator.needs(rest, ROBOT):
            return []
        said = duration_of(estimator.estimate(estimator.fit(rest, ROBOT), asked, ROBOT).slowness, asked)
        percent.append(100 * np.abs(said - asked.duration) / asked.duration)
    return percent


def long_recording() -> None:
    """5,000 moves made up from the UP20's signature, with its noise."""
    rng = np.random.default_rng(0)
    count = 5000
    source = rng.integers(0, len(MOVES), count)
    many = MOVES.take(source.astype(np.int64))
    shift = rng.uniform(-0.15, 0.15, (2, count, 3))
    start, end = many.start + shift[0], many.end + shift[1]
    made = MoveSet(
        start,
        end,
        many.rotation,
        many.speed,
        many.nominal,
        many.duration,
        many.payload,
        many.configuration,
        many.program,
    )
    said = predict(learnt(MOVES, "axis_terms_gp"), made, ROBOT)
    noisy = MoveSet(
        start, end, many.rotation, many.speed, many.nominal, said.duration + rng.normal(0, 0.005, count), many.payload,
        many.configuration, many.program,
    )  # fmt: skip
    begin = time.process_time()
    signature = learnt(noisy, "auto")
    spent = time.process_time() - begin
    print(f"\ncalibrating on 5,000 moves: {spent:.1f} s CPU (asked: 10), method {signature.method}")


def main() -> int:
    good = figures()
    methods()
    long_recording()
    return 0 if good else 1


if __name__ == "__main__":
    raise SystemExit(main())
