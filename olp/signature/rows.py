"""Predictions for every row of a moves.csv, measured or not.

Codes: H010 moves outside what was learnt, H012 rows whose time a signature cannot say.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.diagnostic import Diagnostic, info, warning
from olp.signature.document import Signature
from olp.signature.moveset import moves_of_recording
from olp.signature.predict import predict

if TYPE_CHECKING:
    from olp.recording import Recording

Floats = NDArray[np.float64]


class Rows(NamedTuple):
    """One entry per row of the recording; nan where nothing can be said. Times in s."""

    move: NDArray[np.int64]
    predicted: Floats
    low: Floats
    high: Floats

    def csv(self) -> str:
        """The columns of `olp predict`; cells of rows that cannot be predicted are empty."""
        lines = ["move,predicted_s,low_s,high_s"]
        numbers = zip(self.predicted.tolist(), self.low.tolist(), self.high.tolist(), strict=True)
        for move, row in zip(self.move.tolist(), numbers, strict=True):
            lines.append(",".join([str(move), *("" if np.isnan(v) else f"{v:.6f}" for v in row)]))
        return "\n".join(lines) + "\n"


def predict_recording(signature: Signature, recording: Recording) -> tuple[Rows, tuple[Diagnostic, ...]]:
    """Predicts each row and tells of those it cannot, or only with a wider interval. Raises OlpError (see predict)."""
    count = len(recording.moves)
    predicted, low, high = (np.full(count, np.nan) for _ in range(3))
    moves, rows = moves_of_recording(recording, stops=False)
    told: list[Diagnostic] = []
    if len(rows):
        found = predict(signature, moves, recording.robot)
        # Learnt from stop to stop: through a corner any part of what the stop costs may be saved.
        rolling = ~recording.moves.stops[rows]
        saved = np.where(rolling, found.duration - moves.length / moves.speed, 0.0)
        predicted[rows], low[rows], high[rows] = found.duration, found.low - saved, found.high
        if rolling.any():
            says = f"{int(rolling.sum())} moves end in a corner; the signature was learnt from stop to stop"
            told.append(info("H010", f"{says}: their intervals are wider", file=recording.path))
        numbers = recording.moves.move[rows].tolist()
        told += _outside(found.reasons, numbers, recording.path)
    missing = count - len(rows)
    if missing:
        known = set(rows.tolist())
        first = next(i for i in range(count) if i not in known)
        says = (
            f"{missing} of {count} rows are not straight moves with points and speed_mm_s, "
            f"the first is move {recording.moves.move[first]}: not predicted"
        )
        told.append(warning("H012", says, file=recording.path))
    return Rows(recording.moves.move, predicted, low, high), tuple(told)


def _outside(reasons: tuple[str, ...], numbers: list[int], file: str) -> list[Diagnostic]:
    """One note for all moves that are outside, with the commonest reason's first example."""
    far = [(number, reason) for number, reason in zip(numbers, reasons, strict=True) if reason]
    if not far:
        return []
    kinds = Counter(reason.split(" ")[0] for _, reason in far)
    number, reason = next(p for p in far if p[1].startswith(kinds.most_common(1)[0][0]))
    often = f"{len(far)} of {len(numbers)} moves are outside what was learnt, their intervals are wider"
    says = f"{often}: move {number}, {reason}"
    return [info("H010", says, file=file)]
