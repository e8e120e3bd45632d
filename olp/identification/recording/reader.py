"""Reads a recording: a folder with moves, logs and recording.toml, or one file of moves.

Codes: D001 no moves, D005 several files for one role, D025 a recording.toml that was not asked for.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from olp.core.diagnostic import Diagnostic, OlpError, error, info
from olp.identification.recording.cells import numbers, texts
from olp.identification.recording.fit import fit_together, logs_fit
from olp.identification.recording.log import Log
from olp.identification.recording.log_reader import read_log
from olp.identification.recording.moves import no_moves
from olp.identification.recording.moves_reader import read_moves
from olp.identification.recording.recording import Recording
from olp.identification.recording.settings import FILE_NAME, RecordingSettings, read_settings
from olp.identification.recording.table import SUFFIXES, RecordingTable, read_table, role_of
from olp.robots.geometry import Pose

if TYPE_CHECKING:
    from olp.robots.robot import Robot

ROLES = ("moves", "log", "sim_log")


def read_recording(path: str | os.PathLike[str], *, logs_alone: bool = False) -> Recording:
    """The recording at `path`, a folder or a single file of moves.

    `logs_alone`: a folder may hold logs and no moves, where these tell something: the recording then has 0 moves.
    Raises OlpError with everything that is wrong in any of its files: a recording is used whole or not at all.
    """
    found: list[Diagnostic] = []
    files = _files(Path(path), logs_alone)
    settings = RecordingSettings()
    if FILE_NAME in files:
        settings, told = read_settings(files[FILE_NAME])
        found += told
    robot = _robot(settings, found)
    digest = hashlib.sha256(_settings_key(settings))
    table = _attempt(lambda: read_table(files["moves"]), found) if "moves" in files else None
    moves, left_out = None, 0
    if table is not None:
        left_out += table.left_out
        moves, told = read_moves(table)
        found += told
        _digest_table(digest, table)
    logs: dict[str, Log | None] = {"log": None, "sim_log": None}
    for role in ("log", "sim_log"):
        if role in files:
            answer = _attempt(lambda file=files[role]: read_log(file), found)
            if answer is not None:
                logs[role], told, cells = answer
                found += told
                left_out += cells.table.left_out
                _digest_cells(digest, role, cells.cells)
    if moves is not None and table is not None and not any(d.is_error for d in found):
        found += fit_together(table, moves, logs, robot)
    if "moves" not in files:
        moves = no_moves()
        found += _alone(Path(path), files["log"], logs, robot)
    found += _beside(Path(path), files)
    found = _by_place(found)
    if moves is None or any(d.is_error for d in found):
        raise OlpError(*found)
    tool = None if settings.tool is None else Pose.from_xyz_angles(settings.tool)
    return Recording(
        os.fspath(path),
        moves,
        logs["log"],
        logs["sim_log"],
        settings,
        robot,
        tool,
        digest.hexdigest(),
        tuple(found),
        left_out,
    )


def _alone(path: Path, file: Path, logs: dict[str, Log | None], robot: Robot | None) -> list[Diagnostic]:
    """What is wrong with logs that have no moves beside them."""
    log, planned = logs["log"], logs["sim_log"]
    if log is None:
        return []
    told = (log.command, log.torque, log.current, planned)
    if all(part is None for part in told) and not any("_link_" in name for name in log.covariates):
        return [_no_moves(path, file)]
    return logs_fit(logs, robot)


def _files(path: Path, logs_alone: bool) -> dict[str, Path]:
    """Role (and FILE_NAME) -> file. Raises OlpError (D001, D005)."""
    if path.is_file():
        if not role_of(path):
            known = ", ".join(SUFFIXES)
            raise OlpError(error("D001", "this is no table of moves", file=str(path), help=f"one of {known}"))
        return {"moves": path}
    if not path.is_dir():
        raise OlpError(error("D001", "no such file or folder", file=str(path)))
    candidates: dict[str, list[Path]] = {role: [] for role in ROLES}
    for file in sorted(path.iterdir()):
        if role_of(file) in candidates and file.is_file():
            candidates[role_of(file)].append(file)
    problems = [
        error("D005", f"{role} stands in several files: {', '.join(f.name for f in files)}", file=str(path))
        for role, files in candidates.items()
        if len(files) > 1
    ]
    if not candidates["moves"] and not (logs_alone and candidates["log"]):
        problems.append(_no_moves(path, *candidates["log"][:1]))
    if problems:
        raise OlpError(*problems)
    found = {role: files[0] for role, files in candidates.items() if files}
    if (path / FILE_NAME).is_file():
        found[FILE_NAME] = path / FILE_NAME
    return found


def _no_moves(path: Path, log: Path | None = None) -> Diagnostic:
    help = "moves.csv, moves.csv.gz or moves.parquet"
    if log is not None:
        help = f"olp recording from-log {log} JOB -o FOLDER makes moves.csv"
    return error("D001", "this folder has no moves", file=str(path), help=help)


def _beside(path: Path, files: dict[str, Path]) -> list[Diagnostic]:
    if not path.is_file() or not (path.parent / FILE_NAME).is_file() or FILE_NAME in files:
        return []
    says = f"{FILE_NAME} beside it was not read"
    return [info("D025", says, file=str(path), help=f"name the folder {path.parent} to read both")]


def _by_place(found: list[Diagnostic]) -> list[Diagnostic]:
    """File by file, line by line; what has no line comes after the lines."""
    files = list(dict.fromkeys(d.file for d in found))
    return sorted(found, key=lambda d: (files.index(d.file), d.line == 0, d.line, d.column))


def _attempt(work: Any, found: list[Diagnostic]) -> Any:
    """What `work` gives, or None and its problems among `found`."""
    try:
        return work()
    except OlpError as problem:
        found.extend(problem.diagnostics)
        return None


def _robot(settings: RecordingSettings, found: list[Diagnostic]) -> Robot | None:
    """The robot that recording.toml names; a path is seen from the file's folder."""
    if not settings.robot:
        return None
    from olp.robots.robot import load_robot

    name: str | Path = settings.robot
    if settings.robot.lower().endswith(".toml"):
        name = Path(settings.file).parent / settings.robot
    answer: Robot | None = _attempt(lambda: load_robot(name), found)
    return answer


def _settings_key(settings: RecordingSettings) -> bytes:
    said = [settings.robot, settings.controller, settings.time_resolution, settings.tool, settings.job]
    return json.dumps(said, ensure_ascii=False).encode()


def _digest_table(digest: Any, table: RecordingTable) -> None:
    """Adds the values of the table, whatever its columns' order and its format: CSV and Parquet hash alike."""
    cells: dict[str, Any] = {}
    for name, column in zip(table.names, table.columns, strict=True):
        values, bad = numbers(column)
        cells[name] = texts(column) if len(bad) else values
    _digest_cells(digest, "moves", cells)


def _digest_cells(digest: Any, role: str, cells: dict[str, Any]) -> None:
    for name in sorted(cells):
        values = cells[name]
        digest.update(f"\n{role}\n{name}\n".encode())
        if isinstance(values, tuple):
            digest.update("\0".join(values).encode("utf-8", "surrogatepass"))
        else:
            # Adding zero makes -0.0 and 0.0 one value; nan has many bit patterns.
            plain = np.where(np.isnan(values), np.nan, values + 0.0)
            digest.update(np.ascontiguousarray(plain).tobytes())
