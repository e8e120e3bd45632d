"""The program lines that the moves came from, with what each costs and why."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from olp.identification.diagnosis import phrasing
from olp.reports.diagnosis.rows import MoveRows

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
    """A line of a listing; `number` 0: lines were left out here."""

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


def listings(
    rows: MoveRows, text: str | Mapping[str, str] | None, found: list[ProgramLine]
) -> list[ProgramListing]:
    """The programs' texts around the lines that moved; a single text belongs to the only job or to the one it names."""
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
