"""The diagnosis on the recordings of Apostolovic's thesis: 146 straight moves of a Yaskawa UP20.

    python bench/real_up20.py [FOLDER]

FOLDER, by default samples/up20, holds the recording. What is named, what is refused, the fit before and after on whole
start points and whole tests, the ledger, which causes go together, the experiment that would part them, and how
the held-out errors compare with those of the thesis' factors. docs/real/up20.md explains.
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from real_tables import print_findings  # noqa: E402
from tables import print_table  # noqa: E402

from olp.identification.diagnosis.diagnose import DiagnosisOutcome, diagnose_recording, errors_of  # noqa: E402
from olp.identification.diagnosis.evidence import foreseen  # noqa: E402
from olp.identification.diagnosis.fitting import Noise, fit  # noqa: E402
from olp.identification.diagnosis.folds import folds_of  # noqa: E402
from olp.identification.diagnosis.naming import name  # noqa: E402
from olp.identification.diagnosis.search import move_terms, shelf_of, swaps  # noqa: E402
from olp.identification.recording import Recording, read_recording  # noqa: E402
from olp.timing.physics._case import MeasuredMoves  # noqa: E402

Floats = NDArray[np.float64]

_CLOCK = 0.01 / np.sqrt(12.0)  # [s] the teach pendant shows hundredths
_ALIKE = 0.7  # correlation from which two causes are said to go together


def main() -> int:
    folder = Path(sys.argv[1]) if len(sys.argv) == 2 else ROOT / "samples" / "up20"
    recording = read_recording(folder)
    outcome = diagnose_recording(recording)
    told = outcome.diagnosis
    print(f"verdict: {told.verdict}; {told.moves} moves; noise floor {1000 * told.noise_floor:.1f} ms\n")
    print_findings(outcome)
    print("\nHeld out: the whole choice of names repeated without the moves that are predicted")
    held_out(recording, outcome)
    print("\nLedger, mean over the moves of each test [ms]")
    ledger(recording, outcome)
    print("\nCauses that go together in these moves (correlation above 0.7)")
    confounded(outcome.case)
    print("\nThe experiment that would separate the nearest rivals")
    experiment(recording, outcome)
    return 0


def held_out(recording: Recording, outcome: DiagnosisOutcome) -> None:
    """Whole start points, whole tests, single moves: errors before and after, and what was named without each."""
    case = outcome.case
    rows = np.searchsorted(recording.moves.move, case.move)
    groups = {name: labels[rows] for name, labels in recording.groups().items()}
    ways = {
        "start": groups["start"],
        "test": groups["test"],
        "every fifth move": np.arange(len(case)) % 5,
    }
    simulated = errors_of(case.residual, case.measured)
    table = [("the simulation as it is", *_errors(simulated), "nothing fitted")]
    for way, labels in ways.items():
        (left, same), counted, kept = np.empty((2, len(case))), Counter[str](), 0
        for label in np.unique(labels).tolist():
            held = labels == label
            seen = np.nonzero(~held)[0]
            train = case.take(seen)
            folds = folds_of(recording, rows[seen], train.residual)
            some = {kind: of[seen] for kind, of in groups.items()}
            named = name(train, Noise(_CLOCK), folds, some)
            predicted, beyond = foreseen(named.fit, named.clean, case.take(np.nonzero(held)[0]), named.noise)
            left[held] = case.measured[held] - predicted
            counted.update({part.term.name for part in named.fit.model.parts})
            kept += int(beyond.sum())
            values = fit(outcome.model, train, Noise(_CLOCK), 20).model
            same[held] = (case.measured - values.seconds(case))[held]
        names = ", ".join(f"{n} {count}" for n, count in counted.most_common())
        names += f"; {kept} moves beyond what was seen" if kept else ""
        row = f"held out by {way} ({len(np.unique(labels))} folds)"
        table.append((row, *_errors(errors_of(left, case.measured)), names or "nothing"))
        row = f"names of all moves, values held out by {way}"
        table.append((row, *_errors(errors_of(same, case.measured)), "these"))
        one = _constant(case, labels)
        table.append(
            (f"one overhead, held out by {way}", *_errors(errors_of(one, case.measured)), "one number")
        )
    print_table(("prediction", "rms ms", "mean %", "worst %", "chosen in how many folds"), table)


def _constant(case: MeasuredMoves, labels: NDArray[np.int64]) -> Floats:
    """(n,) [s] residuals of one constant overhead T - L/v, from the other groups: the thesis' equation 6.1."""
    over = case.measured - case.length / case.base.speed
    left = np.empty(len(case))
    for label in np.unique(labels).tolist():
        held = labels == label
        left[held] = over[held] - over[~held].mean()
    return left


def _errors(errors: tuple[float, float, float]) -> tuple[str, ...]:
    rmse, mean, worst = errors
    return f"{1000 * rmse:.0f}", f"{mean:.2f}", f"{worst:.1f}"


def ledger(recording: Recording, outcome: DiagnosisOutcome) -> None:
    case, told = outcome.case, outcome.diagnosis
    rows = np.searchsorted(recording.moves.move, case.move)
    words = np.array(recording.moves.texts["test"])[rows]
    names = [finding.term for finding in told.findings]
    shares = [np.array([f.contribution[m] for m in case.move.tolist()]) for f in told.findings]
    left = case.measured - outcome.predicted
    table = []
    for test in dict.fromkeys(words.tolist()):
        here = words == test
        cells = [1000 * float(v[here].mean()) for v in (case.residual, *shares, left)]
        table.append((test, str(int(here.sum())), *(f"{cell:+.0f}" for cell in cells)))
    print_table(("test", "moves", "robot minus simulation", *names, "what remains"), table)


def confounded(case: MeasuredMoves) -> None:
    """Which innocent columns stand for each other: no diagnosis of these moves alone can part them."""
    way = case.end - case.start
    length = np.linalg.norm(way, axis=1)
    columns = {
        "length": length,
        "bearing": np.abs(np.arctan2(way[:, 1], np.abs(way[:, 0]))),
        "incline": case.rise,
        "reach of the start": np.hypot(*case.start[:, :2].T),
        "reach of the end": np.hypot(*case.end[:, :2].T),
        "height of the end": case.end[:, 2],
    }
    if case.rates is not None:
        columns |= {
            f"turn of {name}": np.abs(case.rates.path[:, :, k]).mean(axis=1) * length
            for k, name in enumerate(case.rates.names)
        }
    names = [name for name, values in columns.items() if np.ptp(values) > 1e-9]
    matrix = np.corrcoef([columns[name] for name in names])
    pairs = [
        (matrix[i, j], names[i], names[j])
        for i in range(len(names))
        for j in range(i)
        if abs(matrix[i, j]) >= _ALIKE
    ]
    for value, first, second in sorted(pairs, key=lambda p: -abs(p[0])):
        print(f"  {first} and {second}: {value:+.2f}")
    print(f"  with the residual: {', '.join(_with_residual(case, columns))}")


def _with_residual(case: MeasuredMoves, columns: dict[str, Floats]) -> list[str]:
    return [
        f"{name} {np.corrcoef(values, case.residual)[0, 1]:+.2f}"
        for name, values in columns.items()
        if np.ptp(values) > 1e-9
    ]


def experiment(recording: Recording, outcome: DiagnosisOutcome) -> None:
    """For the finding whose place others would take best."""
    from olp.identification.diagnosis.fitting import evaluate
    from olp.identification.diagnosis.next_experiment import design_experiment

    if not outcome.model.parts:
        print("  nothing is named")
        return
    case, noise = outcome.case, Noise(_CLOCK)
    best = evaluate(outcome.model, case, noise)
    shelf = shelf_of(case, move_terms())
    near = [swaps(best, k, shelf, case, noise)[:1] for k in range(len(best.model.parts))]
    rival = min((fits[0] for fits in near if fits), key=lambda f: f.bic)
    print(f"  rival: {', '.join(rival.names)}, BIC {rival.bic - best.bic:+.1f}")
    found = design_experiment(case, [outcome.model, rival.model], outcome.diagnosis.noise_floor, recording)
    print(f"  {found.why}")
    for move in found.moves:
        ends = " to ".join(str(tuple(round(1000 * c) for c in p)) for p in (move.start, move.end))
        print(f"  {ends} mm at {1000 * move.speed:.0f} mm/s, {move.times} times {move.why}")


if __name__ == "__main__":
    raise SystemExit(main())
