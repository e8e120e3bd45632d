"""What `.plot()` of the public objects draws, with matplotlib.

Code: Y003 it is not installed, or nothing can be drawn.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from olp.core.diagnostic import OlpError, error
from olp.core.units import deg, mm, ms

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from olp.identification.diagnosis.diagnose import DiagnosisOutcome
    from olp.identification.recording.recording import Recording
    from olp.identification.signature.document import Signature
    from olp.timing.result import Timing

_MOST_SAMPLES = 5_000  # of a log: a screen shows no more


def new_axes() -> Axes:
    """An empty figure's. Raises OlpError (Y003)."""
    try:
        from matplotlib import pyplot
    except ImportError:
        says = "plots are drawn by matplotlib, which is not installed"
        raise OlpError(error("Y003", says, help="pip install matplotlib")) from None
    return pyplot.subplots()[1]


def draw_speed(timing: Timing, axes: Axes | None) -> Axes:
    """The speed of the tool's point over time. Raises OlpError (Y003)."""
    from olp.timing.track import tool_speed

    if timing.untimed or not timing.total_s > 0:
        says = "nothing can be drawn: not every step has a time"
        raise OlpError(error("Y003", says, file=timing.plan.path))
    axes = axes or new_axes()
    instants = np.linspace(0.0, timing.total_s, 2000)
    axes.plot(instants, tool_speed(timing, instants) / mm)
    axes.set(xlabel="time s", ylabel="tool speed mm/s", title=f"{timing.total_s:.3f} s")
    return axes


def draw_durations(recording: Recording, axes: Axes | None) -> Axes:
    """Measured and simulated seconds of each move; of logs alone the axes over time. Raises OlpError (Y003)."""
    moves, log = recording.moves, recording.log
    if not len(moves) and log is None:
        raise OlpError(error("Y003", "nothing can be drawn: no moves and no log", file=recording.path))
    axes = axes or new_axes()
    if not len(moves) and log is not None:
        shown = slice(None, None, 1 + len(log) // _MOST_SAMPLES)
        for number in range(len(log.slides)):
            unit, word = (mm, "mm") if log.slides[number] else (deg, "deg")
            axes.plot(log.time[shown], log.q[shown, number] / unit, label=f"q{number + 1} {word}")
        axes.set(xlabel="time s", ylabel="axis", title=recording.path)
    else:
        axes.plot(moves.move, moves.duration, ".", label="measured")
        if not np.isnan(moves.sim).all():
            axes.plot(moves.move, moves.sim, "_", label="simulated")
        axes.set(xlabel="move", ylabel="duration s", title=recording.path)
    axes.legend()
    return axes


def draw_signature(signature: Signature, axes: Axes | None) -> Axes:
    """The corrected acceleration of the moves that were learnt from, over their direction. Raises OlpError (Y003)."""
    from olp.reports.signature_picture import learnt_accelerations

    shown = learnt_accelerations(signature)
    if not len(shown.angle):
        raise OlpError(error("Y003", "nothing can be drawn: the signature learnt no straight move"))
    axes = axes or new_axes()
    for number in range(int(shown.start.max()) + 1):
        own = shown.start == number
        ends = np.abs(np.stack([shown.low, shown.high])[:, own] - shown.value[own])
        axes.errorbar(shown.angle[own] / deg, shown.value[own] / mm, ends / mm, fmt=".", elinewidth=0.7)
    axes.set(
        xlabel="bearing or incline deg",
        ylabel="corrected acceleration mm/s²",
        title=f"{signature.robot or 'a robot'}, method {signature.method}, 95 %",
    )
    return axes


def draw_residuals(outcome: DiagnosisOutcome, axes: Axes | None) -> Axes:
    """What the simulation is off per move, as it is and with the findings. Raises OlpError (Y003)."""
    case = outcome.case
    if not len(case.measured):
        raise OlpError(error("Y003", "nothing can be drawn: the recording has no moves"))
    axes = axes or new_axes()
    before, after = case.residual, case.measured - outcome.predicted
    axes.axhline(0.0, color="0.7", linewidth=0.8)
    axes.plot(case.move, before / ms, ".", label="simulation as it is")
    axes.plot(case.move, after / ms, ".", label="with the findings")
    axes.set(xlabel="move", ylabel="measured − simulated ms", title=outcome.diagnosis.verdict)
    axes.legend()
    return axes
