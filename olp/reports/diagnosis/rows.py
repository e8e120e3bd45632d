"""Per-move data of the report in columns: measured time, the contribution of each cause, the unexplained residual.

In addition the program lines of the moves, with the cost and the cause of each.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis import phrasing
from olp.identification.diagnosis.result import Diagnosis

if TYPE_CHECKING:
    from olp.identification.recording.recording import Recording
    from olp.timing.physics._case import MeasuredMoves


Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class MoveRows:
    """n moves in order of execution; nan where unknown."""

    move: NDArray[np.int64]
    measured: Floats  # [s]
    simulated: Floats  # [s]
    before: Floats  # [s] measured less simulated
    causes: Mapping[str, Floats]  # [s] that each finding adds to the simulation
    start: Floats  # (n, 3) [m]
    end: Floats  # (n, 3) [m]
    speed: Floats  # [m/s] programmed, nan for joint moves
    time: Floats  # [s] at which the move began; nan: not recorded
    place: tuple[str, ...]  # job:line, "" where it is not known
    job: tuple[str, ...]
    line: NDArray[np.int64]  # 0: not known
    significant: Mask
    phase: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.move)

    @property
    def after(self) -> Floats:
        """Residual [s] after all causes."""
        return self.before - sum(self.causes.values(), np.zeros(len(self)))

    @property
    def modelled(self) -> Floats:
        """The simulation with the causes added [s]."""
        return self.measured - self.after

    @property
    def on_path(self) -> Mask:
        """Moves with both points and a length above zero."""
        whole = np.isfinite(self.start).all(axis=1) & np.isfinite(self.end).all(axis=1)
        return np.asarray(whole & (np.linalg.norm(np.nan_to_num(self.end - self.start), axis=1) > 1e-9))

    def name(self, index: int) -> str:
        """Name of a move: "move 12, CELL-7.JBI:31"."""
        return f"move {self.move[index]}" + (f", {self.place[index]}" if self.place[index] else "")


def rows_of(diagnosis: Diagnosis, case: MeasuredMoves | None, recording: Recording | None) -> MoveRows:
    """The moves of the case, or without a case those of the diagnosis."""
    told = {m.move: m for m in reversed(diagnosis.mismatch.moves)}
    move = np.array(list(dict.fromkeys(m.move for m in diagnosis.mismatch.moves)), dtype=np.int64)
    move = case.move if case is not None else move
    n = len(move)
    unknown, nowhere = np.full(n, np.nan), np.full((n, 3), np.nan)
    before = (
        case.residual
        if case is not None
        else np.array([told[m].residual for m in move.tolist()], dtype=np.float64)
    )
    known = phrasing.places(diagnosis, case)
    at = [known.get(m, (None, None)) for m in move.tolist()]
    return MoveRows(
        move=move,
        measured=case.measured if case is not None else unknown,
        simulated=case.simulated if case is not None else unknown,
        before=before,
        causes=_causes(diagnosis, move),
        start=case.start if case is not None else nowhere,
        end=case.end if case is not None else nowhere,
        speed=_speed(case, recording, move),
        time=case.t_start if case is not None else unknown,
        place=tuple(phrasing.place(*where) for where in at),
        job=tuple(job or "" for job, _ in at),
        line=np.array([line or 0 for _, line in at], dtype=np.int64),
        significant=np.array([m in told and told[m].significant for m in move.tolist()], dtype=bool),
        phase=tuple(told[m].phase if m in told else "" for m in move.tolist()),
    )


def _causes(diagnosis: Diagnosis, move: NDArray[np.int64]) -> dict[str, Floats]:
    """Contribution [s] of each finding to each move; 0 for moves that the finding does not name."""
    return {
        label: np.array([finding.contribution.get(m, 0.0) for m in move.tolist()], dtype=np.float64)
        for label, finding in zip(phrasing.labels(diagnosis.findings), diagnosis.findings, strict=True)
    }


def _speed(case: MeasuredMoves | None, recording: Recording | None, move: NDArray[np.int64]) -> Floats:
    """Programmed speed [m/s]."""
    if recording is not None:
        written = dict(zip(recording.moves.move.tolist(), recording.moves.speed.tolist(), strict=True))
        return np.array([written.get(m, np.nan) for m in move.tolist()], dtype=np.float64)
    if case is None:
        return np.full(len(move), np.nan)
    return np.where(case.moving & ~case.joint, case.base.speed, np.nan)


def groups_of(rows: MoveRows, recording: Recording | None) -> dict[str, list[str]]:
    """Groupings of the moves: name -> label per move, "" where a move belongs to no group."""
    speeds = [f"{v * 1000:.6g} mm/s" if np.isfinite(v) else "" for v in rows.speed.tolist()]
    found = {"start point": [_point(p) for p in rows.start], "programmed speed": speeds}
    for name, labels in _written(rows, recording).items():
        same = next((known for known, other in found.items() if _same(labels, other)), "")
        if same == "start point":
            # A name that the user gave says more than three coordinates.
            found = {f"{same} ({name})": labels} | {k: v for k, v in found.items() if k != same}
        elif not same:
            found[name] = labels
    return {name: labels for name, labels in found.items() if 2 <= len(set(labels) - {""}) < len(labels)}


def _written(rows: MoveRows, recording: Recording | None) -> dict[str, list[str]]:
    """The text columns of the recording, and the job."""
    if recording is None:
        return {"job": list(rows.job)}
    index = {m: i for i, m in enumerate(recording.moves.move.tolist())}
    at = [index.get(m, -1) for m in rows.move.tolist()]
    texts = recording.moves.texts.items()
    return {name: [column[i] if i >= 0 else "" for i in at] for name, column in texts} | {
        "job": list(rows.job)
    }


def _point(point: Floats) -> str:
    """Label of a start point, to the millimetre."""
    return (
        "({})".format(", ".join(f"{c * 1000:.0f}" for c in point.tolist()))
        if np.isfinite(point).all()
        else ""
    )


def _same(one: list[str], other: list[str]) -> bool:
    """Whether two groupings are equal."""
    pairs = set(zip(one, other, strict=True))
    return len(pairs) == len(set(one)) == len(set(other))


_CONTEXT = 1  # lines shown around those that moved
_HEAD = 12  # lines in which a program says its name
_MOST = 600  # lines of one listing


class ProgramLine(NamedTuple):
    """A line that was executed as at least one move."""

    place: str
    anchor: str
    moves: str
    before: str
    after: str
    cause: str
    significant: bool
    listed: bool = False  # a listing shows it, and carries its anchor


class ListedLine(NamedTuple):
    """A line of a listing; `number` 0: a gap where lines were omitted."""

    number: int
    text: str
    anchor: str
    note: str
    significant: bool


class ProgramListing(NamedTuple):
    job: str
    lines: tuple[ListedLine, ...]


def program_lines(rows: MoveRows) -> list[ProgramLine]:
    """One per job and line, the largest mean difference first."""
    found = []
    for number, (place, index) in enumerate(_by_place(rows).items(), 1):
        before, after = rows.before[index], rows.after[index]
        costs = {name: float(np.nanmean(values[index])) for name, values in rows.causes.items()}
        main = max(costs, key=lambda name: abs(costs[name]), default="")
        cause = (
            f"{main} ({phrasing.seconds(costs[main], sign=True)})"
            if main and abs(costs[main]) >= 5e-4
            else ""
        )
        line = ProgramLine(
            place,
            f"line-{number}",
            phrasing.counted(len(index), "move"),
            phrasing.seconds(_mean(before), sign=True),
            phrasing.seconds(_mean(after), sign=True),
            cause,
            bool(rows.significant[index].any()),
        )
        found.append((abs(_mean(before)), line))
    return [line for _, line in sorted(found, key=lambda item: -np.nan_to_num(item[0]))]


def _by_place(rows: MoveRows) -> dict[str, list[int]]:
    places: dict[str, list[int]] = {}
    for i, place in enumerate(rows.place):
        if place and rows.line[i] > 0:
            places.setdefault(place, []).append(i)
    return places


def _mean(values: np.ndarray) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else float("nan")


def program_listings(
    rows: MoveRows, text: str | Mapping[str, str] | None, found: list[ProgramLine]
) -> list[ProgramListing]:
    """The programs' texts around the lines with moves; a single text belongs to the only job, or to the job that it
    names.
    """
    jobs = [job for job in dict.fromkeys(rows.job) if job] or [""]
    if text is None:
        return []
    if isinstance(text, str):
        head = "\n".join(text.splitlines()[:_HEAD]).casefold()
        named = [
            job
            for job in jobs
            if len(jobs) == 1 or re.search(rf"(?<![\w-]){re.escape(_stem(job))}(?![\w-])", head)
        ]
        text = dict.fromkeys(named[:1], text)
    texts = {_stem(name): written for name, written in text.items()}
    by_place = {line.place: line for line in found}
    return [_listing(job, texts[_stem(job)], by_place) for job in jobs if _stem(job) in texts]


def _stem(job: str) -> str:
    """A program's name without folder and suffix: controllers write it in many ways."""
    return re.split(r"[/\\]", job)[-1].rsplit(".", 1)[0].casefold()


def _listing(job: str, text: str, found: Mapping[str, ProgramLine]) -> ProgramListing:
    written = text.splitlines()
    told = {
        i: found[phrasing.place(job, i)]
        for i in range(1, len(written) + 1)
        if phrasing.place(job, i) in found
    }
    near = sorted({j for i in told for j in range(i - _CONTEXT, i + _CONTEXT + 1) if 0 < j <= len(written)})
    out: list[ListedLine] = []
    for number in near[:_MOST]:
        if number > (out[-1].number if out else 0) + 1:
            out.append(ListedLine(0, "⋯", "", "", False))
        line = told.get(number)
        note = f"{line.before} → {line.after} {line.cause}".strip() if line else ""
        out.append(
            ListedLine(
                number,
                written[number - 1],
                line.anchor if line else "",
                note,
                line is not None and line.significant,
            )
        )
    return ProgramListing(job, tuple(out))
