"""A signature as a picture: the corrected acceleration over the direction of the moves it was learnt from."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.units import deg, mm
from olp.identification.signature.diff import domain_moves
from olp.identification.signature.document import Signature
from olp.identification.signature.moveset import MoveSet
from olp.identification.signature.predict import predict
from olp.reports.plot.figure import SERIES, Axes, Dot, Figure, Polyline, TextLabel, room

_LEFT, _TOP, _WIDTH, _HEIGHT, _KEY = 76, 64, 620, 380, 210
_MOST_SERIES = 16
Floats = NDArray[np.float64]


class LearntAccelerations(NamedTuple):
    """n straight moves that a signature learnt: `angle` (n,) [rad]; `value` and its 95 % interval `low`, `high`
    (n,) [m/s²].

    `angle`: bearing or incline. `start`, `away` (n,): index of the start point, and whether the move leads away
    from it.
    """

    angle: Floats
    value: Floats
    low: Floats
    high: Floats
    start: NDArray[np.int64]
    away: NDArray[np.bool_]
    moves: MoveSet


def learnt_accelerations(signature: Signature) -> LearntAccelerations:
    """Acceleration of each learnt move: speed over the time beyond length over speed, at its highest speed. Raises
    OlpError (see predict).
    """
    domain = signature.domain
    moves = domain_moves(domain.moves, domain.angles, domain.speed[1])
    said = predict(signature, moves)
    pace = moves.length / moves.speed
    value = moves.speed / np.maximum(said.duration - pace, 1e-6)
    low, high = (moves.speed / np.maximum(t - pace, 1e-3) for t in (said.high, said.low))
    step = moves.end - moves.start
    upright = np.abs(step[:, 2]) > np.abs(step[:, 0])
    angle = np.arctan2(step[:, 1], np.where(upright, step[:, 2], step[:, 0]))
    angle = np.where(np.abs(angle) > np.pi / 2, angle - np.sign(angle) * np.pi, angle)
    away = np.where(upright, step[:, 2] > 0, step[:, 0] > 0)
    return LearntAccelerations(angle, value, low, high, moves.start_labels, away, moves)


def signature_figure(signature: Signature) -> Figure:
    """One line per start point; the band is the 95 % interval of a move. Raises OlpError (see predict)."""
    domain = signature.domain
    shown = learnt_accelerations(signature)
    moves, labels, away = shown.moves, shown.start, shown.away
    acceleration, low, high = shown.value / mm, shown.low / mm, shown.high / mm
    angle = shown.angle / deg
    figure = Figure(
        _LEFT + _WIDTH + _KEY, _TOP + _HEIGHT + 60, f"Timing signature of {signature.robot or 'a robot'}"
    )
    head = f"{signature.robot} {signature.controller}, method {signature.method}".strip()
    figure.add(TextLabel(_LEFT, 26, head, "ink", 15, bold=True))
    highest = float(np.quantile(high, 0.98))
    panel = Axes(
        figure, _LEFT, _TOP, _WIDTH, _HEIGHT, room(angle, 0.04, zero=False), room([highest, *acceleration])
    )
    panel.frame(
        "bearing or incline, deg", "mm/s²", f"corrected acceleration at {domain.speed[1] / mm:g} mm/s"
    )
    for number in range(min(int(labels.max()) + 1, _MOST_SERIES)):
        own = np.nonzero(labels == number)[0]
        colour = SERIES[number % len(SERIES)]
        for rows in (own[away[own]], own[~away[own]]):
            rows = rows[np.argsort(angle[rows], kind="stable")]
            panel.line(angle[rows], acceleration[rows], colour)
            for row in rows.tolist():
                x = panel.x(float(angle[row]))
                ends = (min(max(float(v[row]), 0.0), panel.y_range[1]) for v in (low, high))
                bottom, top = (panel.y(v) for v in ends)
                figure.add(
                    Polyline(((x, bottom), (x, top)), colour, 0.8),
                    Dot(x, panel.y(float(acceleration[row])), 2.2, colour),
                )
        place = ", ".join(f"{v / mm:g}" for v in moves.start[own[0]])
        y = _TOP + 10 + 20 * number
        figure.add(
            Dot(_LEFT + _WIDTH + 24, y - 4, 4, colour),
            TextLabel(_LEFT + _WIDTH + 34, y, f"from {place} mm", "muted"),
        )
    return figure
