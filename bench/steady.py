"""Whether an answer of `olp diagnose` hangs on the last bit: `python bench/steady.py FOLDER…`.

Durations get relative noise far below what any recorder tells, as another processor or library would round them.
Prints a row per recording and size of noise; the last column counts answers with other names or another verdict.
"""

from __future__ import annotations

import argparse
import os
from dataclasses import replace
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from olp.identification.diagnosis.diagnose import diagnose_recording
from olp.identification.diagnosis.result import Diagnosis
from olp.identification.recording import read_recording
from olp.identification.recording.recording import Recording

SIZES = (1e-15, 1e-13, 1e-12)  # [1] of a duration
SEEDS = 2  # for each size


def shaken(recording: Recording, size: float, seed: int) -> Recording:
    """The recording with durations that differ by `size` [1] of each."""
    moves = recording.moves
    noise = np.random.default_rng(seed).standard_normal(len(moves.duration))
    return replace(recording, moves=replace(moves, duration=moves.duration * (1.0 + size * noise)))


def said(answer: Diagnosis) -> tuple[str, ...]:
    """Verdict and names with their conditions, in order."""
    return (
        answer.verdict,
        *(f"{f.term} where {f.condition}" if f.condition else f.term for f in answer.findings),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--sizes", type=float, nargs="+", default=SIZES)
    parser.add_argument("--seeds", type=int, default=SEEDS)
    args = parser.parse_args()
    print("| recording | noise | answer | unseen ms | others |\n|---|---|---|---|---|")
    for folder in args.folders:
        recording = read_recording(folder)
        plain = diagnose_recording(recording).diagnosis
        for size in args.sizes:
            answers = [
                diagnose_recording(shaken(recording, size, seed)).diagnosis for seed in range(args.seeds)
            ]
            unseen = [1000.0 * one.heldout_after.rmse for one in (plain, *answers)]
            others = sum(said(one) != said(plain) for one in answers)
            row = (folder, f"{size:.0e}", ", ".join(said(plain)), f"{min(unseen):.2f} to {max(unseen):.2f}")
            print(f"| {' | '.join(map(str, row))} | {others} of {len(answers)} |", flush=True)


if __name__ == "__main__":
    main()
