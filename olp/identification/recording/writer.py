"""Writes recordings as the contract wants them: what `read_recording` gives can be written and read again."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from olp.core.files import write_output
from olp.core.terminal import csv_text, to_cell
from olp.core.units import deg, mm, percent
from olp.identification.recording.columns import LOG_POINT, LOG_TURN, POINTS, TURNS, move_axis
from olp.identification.recording.log import Log
from olp.identification.recording.moves import KINDS, Floats, RecordedMoves
from olp.identification.recording.settings import FILE_NAME, RecordingSettings

_REQUIRED = ("move", "duration_s")


def write_recording(
    folder: str | Path,
    moves: RecordedMoves,
    settings: RecordingSettings | None = None,
    log: Log | None = None,
    comment: str = "",
) -> None:
    """Writes moves.csv, recording.toml and, with `log`, log.csv into `folder`, which is made. Raises OSError.

    `comment`: put above recording.toml, one `#` per line.
    """
    target = Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    write_output(target / "moves.csv", moves_csv(moves))
    write_output(target / FILE_NAME, settings_toml(settings or RecordingSettings(), comment))
    if log is not None:
        write_output(target / "log.csv", log_csv(log))


def moves_csv(moves: RecordedMoves) -> str:
    """The text of moves.csv: the columns that say something, in the contract's order."""
    columns = dict(_columns(moves))
    said = {_group(name) for name, cells in columns.items() if name in _REQUIRED or any(cells)}
    columns = {name: cells for name, cells in columns.items() if _group(name) in said}
    return csv_text([list(columns), *zip(*columns.values(), strict=True)])


def _group(name: str) -> str:
    """What has to be written together: a point is there with all its numbers, a way with both its ends."""
    if name in (*POINTS["start"], *POINTS["end"]):
        return "points"
    if move_axis(name):
        return "joints"
    return next((group[0] for group in (POINTS["via"], *TURNS.values()) if name in group), name)


def _columns(moves: RecordedMoves) -> Iterable[tuple[str, list[str]]]:
    yield "move", [str(number) for number in moves.move.tolist()]
    yield "duration_s", _cells(moves.duration)
    yield "sim_s", _cells(moves.sim)
    yield "type", [KINDS[code] for code in moves.kind.tolist()]
    for end, values in (("start", moves.start), ("end", moves.end), ("via", moves.via)):
        yield from _spread(POINTS[end], values / mm)
    for end, values in (("start", moves.start_angles), ("end", moves.end_angles)):
        yield from _spread(TURNS[end], values / deg)
    for end, values in (("start", moves.joints_start), ("end", moves.joints_end)):
        for axis, slides in enumerate(moves.slides):
            unit, factor = ("mm", mm) if slides else ("deg", deg)
            yield f"q{axis + 1}_{end}_{unit}", _cells(values[:, axis] / factor)
    yield "speed_mm_s", _cells(moves.speed / mm)
    yield "speed_pct", _cells(moves.speed_fraction / percent)
    yield "accel_mm_s2", _cells(moves.acceleration / mm)
    yield "accel_pct", _cells(moves.acceleration_fraction / percent)
    yield (
        "blend_mm",
        [
            "" if blend == 0 else cell
            for blend, cell in zip(moves.blend, _cells(moves.blend / mm), strict=True)
        ],
    )
    yield "pl", _whole(moves.level, -1)
    yield "t_start_s", _cells(moves.t_start)
    yield "cycle", _whole(moves.cycle, -1)
    yield "job", list(moves.job)
    yield "line", _whole(moves.line, 0)
    yield "payload_kg", _cells(moves.payload)
    yield "payload_inertia_kg_m2", _cells(moves.payload_inertia)
    yield "sim_payload_kg", _cells(moves.sim_payload)
    yield "sim_payload_inertia_kg_m2", _cells(moves.sim_payload_inertia)
    yield "override_pct", _cells(moves.override / percent)
    yield "sim_override_pct", _cells(moves.sim_override / percent)
    for name, values in moves.covariates.items():
        yield name, _cells(values)
    for name, words in moves.texts.items():
        yield name, list(words)


def _spread(names: tuple[str, ...], values: Floats) -> Iterable[tuple[str, list[str]]]:
    return [(name, _cells(values[:, i])) for i, name in enumerate(names)]


def _cells(values: Floats) -> list[str]:
    """Fifteen digits: all that decimal units and back leave of a double. Adding zero drops the sign of -0."""
    return ["" if value != value else f"{value + 0.0:.15g}" for value in values.tolist()]


def _whole(values: NDArray[Any], missing: int) -> list[str]:
    return ["" if value == missing else str(value) for value in values.tolist()]


def settings_toml(settings: RecordingSettings, comment: str = "") -> str:
    """Return the text of recording.toml, with the keys that are set. `comment` stands above them."""
    lines = [f"# {line}".rstrip() for line in comment.splitlines()]
    lines += [
        f"{key} = {_quoted(value)}"
        for key, value in (("robot", settings.robot), ("controller", settings.controller))
        if value
    ]
    if settings.time_resolution is not None:
        lines.append(f"time_resolution_s = {settings.time_resolution!r}")
    if settings.tool is not None:
        units = (mm, mm, mm, deg, deg, deg)
        numbers = (round(v / unit, 9) + 0.0 for v, unit in zip(settings.tool, units, strict=True))
        lines.append(f"tool = [{', '.join(map(repr, numbers))}]  # x y z [mm], rx ry rz [deg] on the flange")
    if settings.job:
        lines.append(f"job = {_quoted(settings.job)}")
    return "".join(f"{line}\n" for line in lines)


def _quoted(text: str) -> str:
    import json

    # A JSON string is a TOML string, except that JSON lets DEL stand and pairs surrogates.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def log_csv(log: Log) -> bytes:
    """The bytes of log.csv."""
    import pandas

    columns: dict[str, object] = {"t_s": log.time}
    if log.move is not None:
        columns["move"] = log.move
    for values, turning, sliding in (
        (log.q, "q{}_deg", "q{}_mm"),
        (log.command, "q{}_cmd_deg", "q{}_cmd_mm"),
        (log.speed, "qd{}_deg_s", "qd{}_mm_s"),
        (log.torque, "tau{}_nm", "tau{}_n"),
        (log.current, "i{}_a", "i{}_a"),
    ):
        if values is None:
            continue
        angular = "deg" in turning
        for axis, slides in enumerate(log.slides):
            factor = (mm if slides else deg) if angular else 1.0
            columns[(sliding if slides else turning).format(axis + 1)] = np.round(values[:, axis] / factor, 9)
    for group, values, factor in ((LOG_POINT, log.position, mm), (LOG_TURN, log.angles, deg)):
        if values is not None:
            columns.update(zip(group, np.round(values / factor, 9).T, strict=True))
    columns.update(log.covariates)
    columns.update((name, [to_cell(word) for word in words]) for name, words in log.texts.items())
    return (
        pandas.DataFrame({to_cell(name): values for name, values in columns.items()})
        .to_csv(index=False, lineterminator="\n")
        .encode()
    )
