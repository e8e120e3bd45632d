"""Reads a recording: a folder with moves, logs and recording.toml, or one file of moves.

Codes: D001 no moves, D005 several files for one role, D025 a recording.toml that was not asked for.
"""

from __future__ import annotations

import difflib
import hashlib
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, Severity, error, info
from olp.core.units import deg, mm
from olp.identification.recording.columns import (
    MOST_SECONDS,
    MOVE_NUMBERS,
    MOVE_TEXTS,
    POINTS,
    TURNS,
    ColumnRule,
    Problems,
    checked,
    move_axis,
    move_names,
    nearest,
    numbers,
    texts,
    unit_of,
)
from olp.identification.recording.fit import fit_together, logs_fit, units_fit
from olp.identification.recording.log import Log
from olp.identification.recording.log_reader import read_log
from olp.identification.recording.moves import CIRCULAR, JOINT, KINDS, LINEAR, WAIT, RecordedMoves, no_moves
from olp.identification.recording.recording import Recording
from olp.identification.recording.settings import FILE_NAME, RecordingSettings, read_settings
from olp.identification.recording.table import (
    SUFFIXES,
    Floats,
    RecordingTable,
    TableColumn,
    read_table,
    role_of,
)
from olp.robots.geometry import Pose

if TYPE_CHECKING:
    from olp.robots.model import Robot


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
        found += units_fit(table, moves)
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
        error("D005", f"{role} is in several files: {', '.join(f.name for f in files)}", file=str(path))
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


# --- Moves reader ---
# From a table to the moves of a recording, with all that is wrong at once.
#
# Codes: D010 a required column is missing, D012 a column that looks misspelt, D016 a move twice, D017 no such type,
# D018 a point without one of its numbers, D019 columns that contradict each other, D023 a column that is nearly all
# numbers, D024 starts that run backwards.

_MOSTLY = 0.9  # from this share of numbers on, a text column was probably meant to be numbers


def read_moves(table: RecordingTable) -> tuple[RecordedMoves, list[Diagnostic]]:
    """The moves and what there is to tell. Whether they can be used: no error among the diagnostics."""
    reader = _MovesReader(table)
    return reader.moves(), [*table.diagnostics, *reader.problems.all()]


class _MovesReader:
    """One table on its way; every method takes the columns it knows and notes what is wrong with them."""

    def __init__(self, table: RecordingTable) -> None:
        self.table = table
        self.columns = dict(zip(table.names, table.columns, strict=True))
        self.problems = Problems(table)
        self.count = len(table)
        self.known = set(MOVE_NUMBERS) | set(MOVE_TEXTS)
        self.known |= {name for group in (*POINTS.values(), *TURNS.values()) for name in group}
        self.known |= {name for name in table.names if move_axis(name)}

    def moves(self) -> RecordedMoves:
        self._required()
        number = {name: self._number(name, rule) for name, rule in MOVE_NUMBERS.items()}
        points = {end: self._vector(names, mm) for end, names in POINTS.items()}
        start_turn, end_turn = self._turns()
        joints_start, joints_end, slides = self._joints()
        kind = self._kinds(points["start"], points["end"])
        self._geometry(kind, points, joints_start, joints_end)
        self._duplicates(number["move"])
        covariates, groups = self._others()
        if "temperature_c" in self.columns:
            covariates = {"temperature_c": number["temperature_c"]} | covariates
        self._backwards(number["t_start_s"])
        level = _whole(number["pl"], -1)
        blend = np.where(np.isnan(number["blend_mm"]), np.where(level > 0, np.nan, 0.0), number["blend_mm"])
        return RecordedMoves(
            move=_whole(number["move"], -1),
            kind=kind,
            duration=number["duration_s"],
            sim=number["sim_s"],
            start=points["start"],
            end=points["end"],
            via=points["via"],
            start_angles=start_turn,
            end_angles=end_turn,
            joints_start=joints_start,
            joints_end=joints_end,
            slides=slides,
            speed=number["speed_mm_s"],
            speed_fraction=number["speed_pct"],
            acceleration=number["accel_mm_s2"],
            acceleration_fraction=number["accel_pct"],
            blend=blend,
            level=level.astype(np.int8),
            t_start=number["t_start_s"],
            cycle=_whole(number["cycle"], -1),
            line=_whole(number["line"], 0),
            job=self._text("job"),
            payload=number["payload_kg"],
            payload_inertia=number["payload_inertia_kg_m2"],
            sim_payload=number["sim_payload_kg"],
            sim_payload_inertia=number["sim_payload_inertia_kg_m2"],
            override=number["override_pct"],
            sim_override=number["sim_override_pct"],
            covariates=covariates,
            texts=groups,
            row=self.table.line,
            given=self.table.names,
        )

    def _required(self) -> None:
        missing = [name for name in ("move", "duration_s") if name not in self.columns]
        for end in ("start", "end"):
            if any(name in self.columns for names in (POINTS["start"], POINTS["end"]) for name in names):
                missing += [name for name in POINTS[end] if name not in self.columns]
        for group in (POINTS["via"], *TURNS.values()):
            if any(name in self.columns for name in group):
                missing += [name for name in group if name not in self.columns]
        axes = [axis for name in self.table.names if (axis := move_axis(name))]
        for number in range(1, max((axis.number for axis in axes), default=0) + 1):
            for end in ("start", "end"):
                if not any(axis.number == number and axis.what == end for axis in axes):
                    missing.append(f"q{number}_{end}_deg")
        only_waits = set(texts(self.columns["type"])) == {"wait"} if "type" in self.columns else False
        if (
            not axes
            and POINTS["start"][0] not in self.columns
            and POINTS["start"][0] not in missing
            and not only_waits
        ):
            self.problems.whole(
                "D010",
                "no columns say where the moves go",
                self._instead(POINTS["start"][0])
                or "x_start_mm … and x_end_mm …, or q1_start_deg … and q1_end_deg …",
            )
        for name in dict.fromkeys(missing):
            self.problems.cell("D010", f"the column {name} is missing", -1, name, self._instead(name))

    def _instead(self, name: str) -> str:
        unknown = [other for other in self.table.names if other not in self.known]
        near = nearest(name, unknown) or next((o for o in unknown if nearest(o, [name])), "")
        if near and unit_of(near) not in ("", unit_of(name)):
            return f"{near} names another unit: convert it, {name} is in {unit_of(name)}"
        return f"is it the column {near}?" if near else ""

    def _number(self, name: str, rule: ColumnRule) -> Floats:
        if name not in self.columns:
            return np.full(self.count, np.nan)
        column = self.columns[name]
        if name == "move":
            for row in np.nonzero(column.missing)[0].tolist():
                self.problems.cell(
                    "D015", "this row has no move number", row, name, "number the moves 1, 2, 3 …"
                )
        return checked(self.problems, name, column, rule)

    def _text(self, name: str) -> tuple[str, ...]:
        return texts(self.columns[name]) if name in self.columns else ("",) * self.count

    def _vector(self, names: tuple[str, ...], factor: float) -> Floats:
        """(n, 3) in SI. A row with one or two of the three numbers is an error (D018)."""
        present = [name for name in names if name in self.columns]
        result = np.full((self.count, 3), np.nan)
        if len(present) < 3:
            for name in present:
                checked(self.problems, name, self.columns[name], ColumnRule(factor))
            return result
        for i, name in enumerate(names):
            result[:, i] = checked(self.problems, name, self.columns[name], ColumnRule(factor))
        empty = np.stack([self.columns[name].missing for name in names], axis=1)
        self._incomplete(empty, names)
        return result

    def _incomplete(self, empty: NDArray[np.bool_], names: tuple[str, ...]) -> None:
        for row in np.nonzero(empty.any(axis=1) & ~empty.all(axis=1))[0].tolist():
            for i in np.nonzero(empty[row])[0].tolist():
                self.problems.cell(
                    "D018", f"{names[i]} is missing, the rest of the point is there", row, names[i]
                )

    def _turns(self) -> tuple[Floats, Floats]:
        constant = self._vector(TURNS["constant"], deg)
        result = []
        for end in ("start", "end"):
            own = self._vector(TURNS[end], deg)
            with np.errstate(invalid="ignore"):
                other = (np.abs(own - constant) > 1e-9).any(axis=1)
            for row in np.nonzero(other)[0].tolist():
                says = f"{TURNS[end][0]} … contradict {TURNS['constant'][0]} …"
                self.problems.cell("D019", says, row, TURNS[end][0], "give one or the other")
            result.append(np.where(np.isnan(own), constant, own))
        return result[0], result[1]

    def _joints(self) -> tuple[Floats, Floats, tuple[bool, ...]]:
        axes = {(a.what, a.number): (n, a.slides) for n in self.table.names if (a := move_axis(n))}
        width = max((number for _, number in axes), default=0)
        ends = []
        for end in ("start", "end"):
            values = np.full((self.count, width), np.nan)
            names = [axes[end, i][0] for i in range(1, width + 1) if (end, i) in axes]
            for i in range(1, width + 1):
                if (end, i) in axes:
                    name, slides = axes[end, i]
                    values[:, i - 1] = checked(
                        self.problems, name, self.columns[name], ColumnRule(mm if slides else deg)
                    )
            if names:
                empty = np.stack([self.columns[name].missing for name in names], axis=1)
                self._incomplete(empty, tuple(names))
            ends.append(values)
        kinds = [axes.get(("start", i), axes.get(("end", i), ("", False)))[1] for i in range(1, width + 1)]
        return ends[0], ends[1], tuple(kinds)

    def _kinds(self, start: Floats, end: Floats) -> NDArray[np.int8]:
        points = ~(np.isnan(start).any(axis=1) | np.isnan(end).any(axis=1))
        kind = np.where(points, LINEAR, JOINT).astype(np.int8)
        for row, word in enumerate(self._text("type")):
            if word.lower() in KINDS:
                kind[row] = KINDS.index(word.lower())
            elif word:
                near = difflib.get_close_matches(word.lower(), KINDS, n=1, cutoff=0.6)
                help = f"did you mean {near[0]}?" if near else f"one of {', '.join(KINDS)}"
                self.problems.cell("D017", f"there is no type {word[:40]!r}", row, "type", help)
        return kind

    def _geometry(
        self, kind: NDArray[np.int8], points: dict[str, Floats], joints_start: Floats, joints_end: Floats
    ) -> None:
        """Every move that is no wait needs two points, a circular one a third (D018)."""
        if any(d.is_error for d in self.problems.found):
            return  # the cells themselves are told already
        place = ~(np.isnan(points["start"]).any(axis=1) | np.isnan(points["end"]).any(axis=1))
        if joints_start.shape[1]:
            place |= ~(np.isnan(joints_start).any(axis=1) | np.isnan(joints_end).any(axis=1))
        first = POINTS["start"][0] if POINTS["start"][0] in self.columns else "move"
        for row in np.nonzero(~place & (kind != WAIT))[0].tolist():
            self.problems.cell(
                "D018", "this move has no start or no end", row, first, "only a wait needs no points"
            )
        bent = (kind == CIRCULAR) & place & np.isnan(points["via"]).any(axis=1)
        name = POINTS["via"][0] if POINTS["via"][0] in self.columns else "type"
        for row in np.nonzero(bent)[0].tolist():
            self.problems.cell("D018", "a circular move needs x_via_mm y_via_mm z_via_mm", row, name)

    def _duplicates(self, move: Floats) -> None:
        first: dict[float, int] = {}
        for row, number in enumerate(move.tolist()):
            if np.isnan(number):
                continue
            before = first.setdefault(number, row)
            if before != row:
                where = f"line {self.table.line[before]}" if self.table.line[before] else f"row {before + 1}"
                self.problems.cell("D016", f"move {number:.0f} is already in {where}", row, "move")

    def _backwards(self, start: Floats) -> None:
        known = np.nonzero(~np.isnan(start))[0]
        back = known[1:][np.diff(start[known]) < 0]
        for row in back.tolist():
            says = f"t_start_s runs backwards to {start[row]:g} s"
            help = "rows are in the order of execution; make one recording of each session with its own clock"
            self.problems.cell("D024", says, row, "t_start_s", help, Severity.WARNING)

    def _others(self) -> tuple[dict[str, Floats], dict[str, tuple[str, ...]]]:
        """Unknown columns: numbers may explain, texts may group."""
        covariates: dict[str, Floats] = {}
        groups: dict[str, tuple[str, ...]] = {}
        for name in self.table.names:
            if name in self.known:
                continue
            near = nearest(name, move_names(), self.columns)
            column = self.columns[name]
            values, bad = numbers(column)
            if near:
                says = f"olp does not know the column {name} and keeps it unchanged"
                self.problems.cell("D012", says, -1, name, f"did you mean {near}?", Severity.WARNING)
            for row in np.nonzero(~_COVARIATE.fits(values))[0].tolist():
                self.problems.cell(
                    "D015", f"{name} cannot be {values[row]:g}", row, name, _COVARIATE.told(values[row])
                )
            if not len(bad):
                covariates[name] = values
                continue
            groups[name] = texts(column)
            self._nearly_numbers(name, column, bad)
        return covariates, groups

    def _nearly_numbers(self, name: str, column: TableColumn, bad: NDArray[np.intp]) -> None:
        written = int((~column.missing).sum())
        if len(bad) > (1 - _MOSTLY) * written:
            return
        row = int(bad[0])
        says = f"{name} groups moves by its text, because {len(bad)} of {written} cells are no numbers"
        self.problems.cell("D023", says, row, name, "empty that cell to make it a number", Severity.WARNING)


_COVARIATE = ColumnRule(
    lowest=-MOST_SECONDS, highest=MOST_SECONDS
)  # numbers of unknown columns, stamps of time among them


def _whole(values: Floats, missing: int) -> NDArray[np.int64]:
    return np.where(np.isnan(values), missing, values).astype(np.int64)
