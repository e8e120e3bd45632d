"""What was read, in words: the answer of `olp recording check`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from olp.core.units import mm, percent
from olp.identification.recording.log import Log
from olp.identification.recording.moves import WAIT
from olp.identification.recording.recording import Recording

_MOST_NAMED = 6


def describe(recording: Recording) -> str:
    """A few lines, one fact each, and below them what is missing and what it would tell."""
    facts = [f"{name:<10} {says}" for name, says in _facts(recording)]
    missing = [f"  {what}: {needed}" for what, needed in gaps(recording)]
    return "\n".join(
        [recording.path, *facts, *(["missing, and what it would reveal:", *missing] if missing else [])]
    )


def _facts(recording: Recording) -> Iterable[tuple[str, str]]:
    moves, settings = recording.moves, recording.settings
    yield "moves", _durations(recording)
    if recording.left_out:
        yield "left out", f"{recording.left_out:,} rows, listed below"
    yield "robot", recording.robot.name if recording.robot else "not named"
    if settings.controller:
        yield "controller", settings.controller
    if len(moves):
        yield "types", _counted(moves.kinds)
        yield (
            "points",
            f"tool points of {moves.has_points.sum():,}, joint points of {moves.has_joints.sum():,}",
        )
        yield "speeds", _counted(_speeds(recording))
        runs = moves.kind != WAIT
        yield "ends", f"{(moves.stops & runs).sum():,} exact stops, {(~moves.stops & runs).sum():,} rounded"
    sim = int((~np.isnan(moves.sim)).sum())
    yield "simulation", f"sim_s of {sim:,} moves" if sim else "none: olp's own prediction is judged"
    yield "noise", _noise(recording)
    groups = recording.groups()
    yield "groups", ", ".join(f"{name} ({labels.max() + 1})" for name, labels in groups.items()) or "none"
    if moves.covariates:
        yield "numbers", ", ".join(moves.covariates)
    for name, log in (("log", recording.log), ("sim_log", recording.sim_log)):
        yield name, _log(log) if log is not None else "none"
    yield "sha256", recording.sha256


def _durations(recording: Recording) -> str:
    moves = recording.moves
    known = moves.duration[moves.measured]
    if not len(known):
        return f"{len(moves):,}, none measured"
    spread = f"{known.min():g} to {known.max():g} s, together {known.sum():.3f} s"
    return f"{len(moves):,}, {len(known):,} measured ({spread})"


def _counted(words: Iterable[str]) -> str:
    counts = Counter(words).most_common()
    shown = [f"{word} ({count:,})" for word, count in counts[:_MOST_NAMED]]
    return ", ".join(shown) + (f" and {len(counts) - _MOST_NAMED} more" if len(counts) > _MOST_NAMED else "")


def _speeds(recording: Recording) -> list[str]:
    moves = recording.moves
    words = []
    rows = zip(moves.speed.tolist(), moves.speed_fraction.tolist(), moves.kind.tolist(), strict=True)
    for travel, share, kind in rows:
        if kind == WAIT:
            continue
        said = [f"{travel / mm:.6g} mm/s"] if travel == travel else []
        said += [f"{share / percent:.6g} %"] if share == share else []
        words.append(" ".join(said) or "not given")
    return words


def _noise(recording: Recording) -> str:
    noise = recording.noise_floor()
    if np.isnan(noise.floor):
        return "not known: no time_resolution_s, and no move was repeated"
    said = []
    if not np.isnan(noise.resolution):
        said.append(
            f"resolution {noise.resolution:g} s{' by the look of the durations' if noise.inferred else ''}"
        )
    said.append(
        f"repeats scatter by {noise.repeats:.4f} s ({noise.freedom} degrees of freedom)"
        if noise.freedom
        else "no move was repeated"
    )
    return f"{noise.floor:.4f} s ({', '.join(said)})"


def _log(log: Log) -> str:
    if not len(log):
        return "no samples"
    extra = {
        "commands": log.command, "speeds": log.speed, "torques": log.torque, "currents": log.current,
        "tool points": log.position, "move numbers": log.move,
    }  # fmt: skip
    also = [name for name, values in extra.items() if values is not None]
    spans = f"{len(log):,} samples of {len(log.slides)} axes over {log.time[-1] - log.time[0]:.3f} s"
    if len(log) > 1:
        spans += f", every {log.period * 1e3:.3g} ms, {len(log.gaps):,} gaps"
    return f"{spans}{'; with ' if also else ''}{', '.join(also)}"


def gaps(recording: Recording) -> list[tuple[str, str]]:
    """What the recording does not have, and what cannot be told for that."""
    moves = recording.moves
    found = []
    if recording.robot is None:
        found.append(("robot", "limits of the axes, singularities, gravity; name it in recording.toml"))
    elif recording.tool is None and moves.has_points.any() and not moves.has_joints.all():
        found.append(("tool", "the axes' path along a line: without it the tool is assumed to be the flange"))
    silent = np.isnan(moves.speed) & np.isnan(moves.speed_fraction) & (moves.kind != WAIT)
    if silent.any():
        found.append(("speed_mm_s or speed_pct", f"a prediction of {silent.sum():,} moves"))
    if not moves.measured.all():
        found.append(
            ("duration_s", f"without it a move is only there to be predicted: {(~moves.measured).sum():,}")
        )
    if np.isnan(moves.start_angles).all() and not moves.has_joints.any():
        found.append(("orientation", "whether turning the tool, not moving it, sets the time"))
    if np.isnan(moves.t_start).all():
        found.append(("t_start_s", "drift and warm-up"))
    if recording.log is None:
        found.append(("log", "friction, servo lag, compliance, backlash, the recorder's clock"))
    if not recording.noise_floor().freedom:
        found.append(("repeated moves", "how much the robot itself scatters"))
    return found


def _range_of(measured: NDArray[np.float64]) -> dict[str, float] | None:
    """[s] the least, the most and their sum; None where no move was measured."""
    if not len(measured):
        return None
    return {"least": float(measured.min()), "most": float(measured.max()), "sum": float(measured.sum())}


def as_dict(recording: Recording) -> dict[str, Any]:
    """The same for other programs."""
    moves, noise = recording.moves, recording.noise_floor()
    return {
        "path": recording.path,
        "sha256": recording.sha256,
        "robot": recording.robot.name if recording.robot else None,
        "controller": recording.settings.controller or None,
        "moves": len(moves),
        "measured": int(moves.measured.sum()),
        "duration_s": _range_of(moves.duration[moves.measured]),
        "simulated": int((~np.isnan(moves.sim)).sum()),
        "left_out": recording.left_out,
        "types": dict(Counter(moves.kinds)),
        "groups": {name: int(labels.max()) + 1 for name, labels in recording.groups().items()},
        "covariates": list(moves.covariates),
        "noise_floor_s": None if np.isnan(noise.floor) else float(noise.floor),
        "log_samples": None if recording.log is None else len(recording.log),
        "sim_log_samples": None if recording.sim_log is None else len(recording.sim_log),
        "missing": [{"what": what, "would_tell": tells} for what, tells in gaps(recording)],
    }
