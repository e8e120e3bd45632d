"""The //POS section: a state machine of records, and position rows that take the current state.

Rows of one family and width that follow each other are validated by one regular expression and converted by numpy
in one go: a CAM job has 100,000 of them.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Severity, Span
from olp.core.units import deg, mm
from olp.ir.expressions import Store
from olp.ir.points import PointBlock, PointKind, PointState, PointTable
from olp.ir.program import LineKind
from olp.languages.findings import Findings

FAMILIES: Final = {
    "C": (Store.ROBOT, True),
    "BC": (Store.BASE, True),
    "EC": (Store.STATION, True),
    "P": (Store.ROBOT, False),
    "BP": (Store.BASE, False),
    "EX": (Store.STATION, False),
}
_SAME_AS: Final = {"E": "EC"}  # the ERC generation's external axes
KINDS: Final = {"PULSE": PointKind.PULSE, "RECTAN": PointKind.POSE, "ANGLE": PointKind.JOINT}
POSTYPES: Final = ("PULSE", "ANGLE", "BASE", "ROBOT", "USER", "TOOL", "MTOOL")
_FRAMES = {"BASE": "base", "ROBOT": "robot", "USER": "user", "TOOL": "tool", "MTOOL": "master-tool"}

ROW = re.compile(r"\s*(BC|BP|EC|EX|C|P|E)(\d{1,9})=(.*)", re.ASCII)
_ROW_NAME = re.compile(r"\s*(BC|BP|EC|EX|C|P|E)(\d{1,9})", re.ASCII)
_NUMBER = r"-?\d{1,15}+(?:\.\d{0,15}+)?"
_FIELD = re.compile(r"\s*(?:[+-]?(?:\d{1,15}\.?\d{0,15}|\.\d{1,15}))?\s*", re.ASCII)
_WHOLE = re.compile(r"-?\d{1,9}", re.ASCII)
_BULK = 4  # rows: below, numpy costs more than it saves
_MOST_FIELDS = 12  # three stations of two axes, and room


@lru_cache(maxsize=128)
def _run(family: str, width: int) -> re.Pattern[str]:
    """Consecutive plain rows. Possessive, so that a broken row costs no backtracking."""
    more = rf"(?:,{_NUMBER}){{{width - 1}}}"
    return re.compile(rf"(?:{family}\d{{1,6}}+={_NUMBER}{more}\n)*+", re.ASCII)


@dataclass(slots=True)
class _Family:
    """The rows of one family while they are read: whole runs, and single rows until they are packed."""

    runs: list[tuple[NDArray[np.float64], NDArray[np.int32], int]] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    values: list[list[float]] = field(default_factory=list)
    states: list[int] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)


class InformPositionReader:
    """Reads the rows of one job. `record` changes the state, `rows` takes lines."""

    def __init__(self, findings: Findings) -> None:
        self.findings = findings
        self.npos: tuple[int, ...] | None = None
        self.npos_line = 0
        self.broken: set[tuple[Store, bool, int]] = set()  # rows that have an error of their own
        self._tool = 0
        self._user: int | None = None
        self._postype = ""
        self._kind = PointKind.PULSE
        self._configuration: tuple[int, ...] = ()
        self._outside = False
        self._states: dict[PointState, int] = {}
        self._families: dict[str, _Family] = {}

    # --- state ------------------------------------------------------------------------------------------

    def record(self, word: str, value: str, line: int) -> bool:
        """Takes one `///` record of the section. False when the word is none of its."""
        if word in KINDS:
            self._kind = KINDS[word]
        elif word == "POSTYPE":
            if value not in POSTYPES:
                self._bad(line, value, f"no position type '{value}'", f"one of {', '.join(POSTYPES)}")
            else:
                self._postype = value
        elif word in ("TOOL", "USER"):
            number = self._whole(word, value, line)
            if number is not None and word == "TOOL":
                self._tool = number
            elif number is not None:
                self._user = number
        elif word == "RCONF":
            self._configuration = self._wholes(word, value, line) or ()
        elif word == "LIMIT":
            self._outside = value == "ON"
            if value not in ("ON", "OFF"):
                self._bad(line, value, f"///LIMIT is ON or OFF, not '{value}'", "///LIMIT ON")
        elif word == "NPOS":
            self.npos, self.npos_line = self._wholes(word, value, line), line
        else:
            return False
        return True

    def _whole(self, word: str, value: str, line: int) -> int | None:
        if _WHOLE.fullmatch(value) and int(value) >= 0:
            return int(value)
        self._bad(line, value, f"///{word} needs a number", f"///{word} 1")
        return None

    def _wholes(self, word: str, value: str, line: int) -> tuple[int, ...] | None:
        parts = [part.strip() for part in value.split(",")]
        if all(_WHOLE.fullmatch(part) for part in parts):
            return tuple(int(part) for part in parts)
        self._bad(line, value, f"///{word} needs whole numbers with commas", f"///{word} 1,0,0,0,0,0")
        return None

    def _bad(self, line: int, value: str, message: str, example: str) -> None:
        text = self.findings.source.line(line).rstrip()
        end = len(text) + 1
        column = end - len(value)
        if not value:
            column, end = end, end + 1
        self.findings.error("P011", message, Span(line, column, end), help=f"expected {example}")

    def _state(self, line: int) -> int:
        frame, user = {PointKind.PULSE: "pulse", PointKind.JOINT: "joint"}.get(self._kind, ""), None
        if not frame:
            frame = _FRAMES.get(self._postype, "base")
            if self._postype not in _FRAMES and self._postype:
                message = f"rows in coordinates, but ///POSTYPE {self._postype}: taken as BASE"
                self.findings.once(Severity.WARNING, "P018", "kind", message, self.findings.whole_line(line))
            user = self._user if frame == "user" else None
        if frame == "user" and user is None:
            message = "no ///USER before this row: taken as 0"
            self.findings.once(Severity.WARNING, "P018", "user", message, self.findings.whole_line(line))
            user = 0
        configuration = self._configuration if self._kind is PointKind.POSE else ()
        state = PointState(self._kind, frame, user, self._tool, configuration, self._outside)
        return self._states.setdefault(state, len(self._states))

    # --- rows -------------------------------------------------------------------------------------------

    def rows(self, lines: Sequence[str], first: int) -> None:
        """Position rows from line `first` on; all in the current state."""
        text = "\n".join(lines) + "\n"
        at = index = 0
        state = self._state(first)
        while index < len(lines):
            line = lines[index]
            match = ROW.match(line)
            count = 1
            stop = at + len(line) + 1
            if match is None:
                self._broken(line, first + index)
            else:
                width = min(match[3].count(",") + 1, _MOST_FIELDS + 1)
                run_stop = _run(match[1], width).match(text, at).end()  # type: ignore[union-attr]
                rows = text.count("\n", at, run_stop)
                if rows >= _BULK:
                    count, stop = rows, run_stop
                    self._bulk(match[1], width, text[at:stop], first + index, state, rows)
                else:
                    self._single(match, first + index, state)
            at, index = stop, index + count

    def _bulk(self, family: str, width: int, text: str, line: int, state: int, rows: int) -> None:
        self._doubt_pulses(text, line)
        plain = text.replace(family, "").replace("=", ",").replace("\n", ",")
        table = np.fromstring(plain[:-1], dtype=np.float64, sep=",").reshape(rows, width + 1)
        lines = np.arange(line, line + rows, dtype=np.int32)
        self._family(family).runs.append((table, lines, state))
        self.findings.kinds[line - 1 : line - 1 + rows] = bytes([LineKind.POINT]) * rows

    def _single(self, match: re.Match[str], line: int, state: int) -> None:
        values, column = [], match.start(3) + 1
        texts = match[3].rstrip("\x1a").split(",")
        # The ERC generation leaves the fields of axes that it does not have empty, at the end.
        empty_from = len(match[3].rstrip("\x1a, \t").split(",")) if match[1] not in ("C", "P") else len(texts)
        for index, text in enumerate(texts):
            if _FIELD.fullmatch(text) is None or (index < empty_from and not text.strip()):
                message = f"'{text.strip()[:40]}' is no number" if text.strip() else "a value is missing"
                span = Span(line, column, column + max(len(text), 1))
                self._refuse("P010", message, span, "expected a number", match)
                return
            values.append(float(text) if text.strip() else float("nan"))
            column += len(text) + 1
        if len(values) > _MOST_FIELDS:
            span = Span(line, match.start(3) + 1, match.end(3) + 1)
            message = f"a position of {len(values)} values"
            self._refuse("P012", message, span, "expected 1 to 8 numbers with commas", match)
            return
        self._doubt_pulses(match[3], line)
        family = self._family(match[1])
        family.numbers.append(int(match[2]))
        family.values.append(values)
        family.states.append(state)
        family.lines.append(line)
        self.findings.kinds[line - 1] = LineKind.POINT

    def _family(self, name: str) -> _Family:
        return self._families.setdefault(_SAME_AS.get(name, name), _Family())

    def _doubt_pulses(self, text: str, line: int) -> None:
        """Pulses are whole numbers: decimals mean that a record such as ///RECTAN got lost."""
        if "." in text and self._kind is PointKind.PULSE:
            message = "pulses with decimals: is ///RECTAN missing before this row?"
            self.findings.once(
                Severity.WARNING, "P019", "", message, self.findings.whole_line(line), "read as pulses"
            )

    def _refuse(self, code: str, message: str, span: Span, help: str, match: re.Match[str] | None) -> None:
        """Tells a broken row, and remembers its number, so that nobody complains that the point is missing."""
        self.findings.error(code, message, span, help)
        store, taught = FAMILIES[_SAME_AS.get(match[1], match[1])] if match else (Store.ROBOT, True)
        self.broken.add((store, taught, int(match[2]) if match else -1))

    def _broken(self, line: str, number: int) -> None:
        if not line.strip():
            return
        if line.lstrip().startswith("'"):
            self.findings.kinds[number - 1] = LineKind.COMMENT
            return
        example = "C00001=412.310,-87.045,33.120,178.4410,-12.0071,91.3300"
        span = self.findings.whole_line(number)
        help = f"expected a row such as {example}"
        self._refuse("P010", "this is no position row", span, help, _ROW_NAME.match(line))

    # --- result -----------------------------------------------------------------------------------------

    def table(self) -> PointTable:
        """All rows in SI."""
        states = tuple(self._states)
        blocks = {}
        for name, family in self._families.items():
            store, taught = FAMILIES[name]
            blocks[store, taught] = self._block(name, store, taught, family, states)
        return PointTable(states, blocks)

    def _block(
        self, name: str, store: Store, taught: bool, family: _Family, states: tuple[PointState, ...]
    ) -> PointBlock:
        table, state, lines = _pack(family)
        numbers, values = table[:, 0].astype(np.int64), np.ascontiguousarray(table[:, 1:])
        for index in sorted(set(state.tolist())):
            _to_si(values, state == index, states[index].kind, store)
        rows = dict(zip(numbers.tolist(), range(len(numbers)), strict=True))
        if len(rows) != len(numbers):
            self._duplicates(name, numbers, lines)
        return PointBlock(store, taught, numbers, values, state, lines, rows)

    def _duplicates(self, name: str, numbers: NDArray[np.int64], lines: NDArray[np.int32]) -> None:
        seen: dict[int, int] = {}
        for number, line in zip(numbers.tolist(), lines.tolist(), strict=True):
            if number in seen:
                self.findings.warning(
                    "P013",
                    f"{name}{number:05} stands twice",
                    Span(line, 1, self.findings.source.line(line).find("=") + 1),
                    help=f"the first one is in line {seen[number]}; the last one counts",
                )
            seen.setdefault(number, line)


def _pack(family: _Family) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]:
    """One table (number, values…) in order of writing, nan where a row is shorter; its states; its lines."""
    pieces = list(family.runs)
    width = max([table.shape[1] for table, _, _ in pieces] + [len(row) + 1 for row in family.values])
    nan = float("nan")
    single = [
        [number, *row, *[nan] * (width - 1 - len(row))]
        for number, row in zip(family.numbers, family.values, strict=True)
    ]
    tables, states, lines = [], [], []
    if single:
        tables.append(np.array(single, dtype=np.float64))
        states.append(np.array(family.states, dtype=np.int32))
        lines.append(np.array(family.lines, dtype=np.int32))
    for table, at, state in pieces:
        if table.shape[1] < width:
            table = np.pad(table, ((0, 0), (0, width - table.shape[1])), constant_values=nan)
        tables.append(table)
        lines.append(at)
        states.append(np.full(len(at), state, dtype=np.int32))
    if len(tables) == 1:
        return tables[0], states[0], lines[0]
    order = np.argsort(np.concatenate(lines), kind="stable")
    return np.concatenate(tables)[order], np.concatenate(states)[order], np.concatenate(lines)[order]


def _to_si(values: NDArray[np.float64], rows: NDArray[np.bool_], kind: PointKind, store: Store) -> None:
    """In place: pulses stay, coordinates and slides become metres, angles radians."""
    if kind is PointKind.PULSE:
        return
    scale = np.full(values.shape[1], mm if store is Store.BASE else deg)
    if kind is PointKind.POSE and store is Store.ROBOT:
        scale[:3] = mm
    if rows.all():
        values *= scale
    else:
        values[rows] *= scale
