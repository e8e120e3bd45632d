"""Text files of a controller: bounded reading, rows with their line numbers, numbers with their columns."""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import isfinite
from pathlib import Path
from typing import Final, NamedTuple

from olp.core.diagnostic import Diagnostic, Severity

# The largest controller file met was an ALL.PRM of 1 MB; 3,000 values for each of 32 groups would be 3 MB.
MAX_BYTES: Final = 16 * 1024 * 1024
MAX_ROWS: Final = 400_000  # the ALL.PRM of a YRC1000 has 100,000
MAX_ROW: Final = 2_000  # characters; a row of ten values has at most 120
MAX_FINDINGS: Final = 50

_FIELD = re.compile(r"[^,]*")
# The 24 arm flags of a position variable are one word.
_INTEGER = re.compile(r"[+-]?[0-9]{1,24}")
_INTEGER_ROW = re.compile(r"\s*[+-]?[0-9]{1,24}(?:,[+-]?[0-9]{1,24})*,?\s*")
_NUMBER = re.compile(r"[+-]?(?:[0-9]{1,18}(?:\.[0-9]{0,18})?|\.[0-9]{1,18})(?:[eE][+-]?[0-9]{1,3})?")


class BackupLine(NamedTuple):
    """One line of a file: 1-based number, text without its line end."""

    line: int
    text: str


class BackupBlock(NamedTuple):
    """The rows after `//KEYWORD number` up to the next `//` record."""

    number: int
    head: BackupLine
    rows: tuple[BackupLine, ...]


class BackupFindings:
    """Collects the problems of one file.

    Beyond `MAX_FINDINGS` they are only counted, so that a hostile file stays cheap.
    """

    def __init__(self, file: str) -> None:
        self._file = file
        self._found: list[Diagnostic] = []
        self._uncounted_errors = 0
        self._uncounted = 0

    def error(self, code: str, message: str, row: BackupLine | None = None, **more: object) -> None:
        """Add an error. `more`: start and end (0-based columns in the row's text), help."""
        self._add(Severity.ERROR, code, message, row, more)

    def warning(self, code: str, message: str, row: BackupLine | None = None, **more: object) -> None:
        """Add a warning: the file is still usable. Arguments as in `error`."""
        self._add(Severity.WARNING, code, message, row, more)

    def info(self, code: str, message: str, row: BackupLine | None = None, **more: object) -> None:
        """Add a note on an assumption. Arguments as in `error`."""
        self._add(Severity.INFO, code, message, row, more)

    def _add(
        self, severity: Severity, code: str, message: str, row: BackupLine | None, more: dict[str, object]
    ) -> None:
        if len(self._found) >= MAX_FINDINGS:
            self._uncounted += 1
            self._uncounted_errors += severity is Severity.ERROR
            return
        line, text = row or BackupLine(0, "")
        start = int(str(more.get("start", 0)))
        end = int(str(more.get("end", max(len(text), start + 1))))
        self._found.append(
            Diagnostic(
                code, message, severity, self._file, line, start + 1, end + 1, str(more.get("help", "")), text
            )
        )

    def all(self) -> tuple[Diagnostic, ...]:
        """All findings; a last one counts those that were not listed."""
        if not self._uncounted:
            return tuple(self._found)
        severity = Severity.ERROR if self._uncounted_errors else Severity.WARNING
        rest = Diagnostic("B011", f"{self._uncounted} more findings in this file", severity, self._file)
        return (*self._found, rest)


def read_rows(
    path: Path, findings: BackupFindings, encoding: str = "cp1252", last: str = ""
) -> tuple[BackupLine, ...]:
    """All lines of a controller file; () with an error finding when it cannot be read or is beyond
    `MAX_BYTES`.

    Accepts CRLF, LF and bare CR, a final 0x1A and a missing last line end (reported: its last row may be
    cut, unless it is `last`).
    """
    try:
        with path.open("rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except OSError as problem:
        findings.error("B001", f"this file cannot be read: {problem.strerror or problem}")
        return ()
    ends = data.count(b"\n") or data.count(b"\r")
    if len(data) > MAX_BYTES or ends > MAX_ROWS:
        limit = f"{MAX_BYTES // 1024**2} MiB" if len(data) > MAX_BYTES else f"{MAX_ROWS} rows"
        says = "a controller file is at most a few MB: save the backup again"
        findings.error("B001", f"this file has more than {limit} and was not read", help=says)
        return ()
    text = data.rstrip(b"\x1a").decode(encoding, errors="replace").replace("\r\n", "\n").replace("\r", "\n")
    lines = text.split("\n")
    complete = not lines[-1] or lines[-1].strip().upper() == last
    if not lines[-1]:
        lines.pop()
    rows = tuple(
        BackupLine(number, line) if len(line) <= MAX_ROW else _left_out(number, line, findings)
        for number, line in enumerate(lines, start=1)
    )
    if not complete:
        message = "the file ends without a line end: its last row may be cut"
        findings.warning("B002", message, rows[-1], start=len(rows[-1].text))
    return rows


def _left_out(number: int, line: str, findings: BackupFindings) -> BackupLine:
    """An empty row in place of one that is too long for a controller's file."""
    shown = BackupLine(number, line[:80] + "…")
    findings.error("B003", f"this row has {len(line)} characters and was left out", shown)
    return BackupLine(number, "")


def record(row: BackupLine) -> tuple[str, str, str]:
    """A row as (slashes, keyword, rest): `///NAME TORCH` is ("///", "NAME", "TORCH").

    A row that is not a record: ("", "", text).
    """
    text = row.text.strip()
    body = text.lstrip("/")
    slashes = text[: len(text) - len(body)]
    if not slashes:
        return "", "", text
    keyword, _, rest = body.partition(" ")
    return slashes, keyword, rest.strip()


def blocks(rows: tuple[BackupLine, ...], keyword: str, findings: BackupFindings) -> Iterator[BackupBlock]:
    """The blocks `//keyword number` of a file, in order; other blocks are skipped."""
    head: BackupLine | None = None
    number = -1
    inside: list[BackupLine] = []
    for row in rows:
        if not row.text.startswith("//") or row.text.startswith("///"):
            inside.append(row)
            continue
        if head is not None:
            yield BackupBlock(number, head, tuple(inside))
        inside = []
        _, word, rest = record(row)
        head = None
        if word != keyword:
            continue
        if re.fullmatch("[0-9]{1,5}", rest):
            head, number = row, int(rest)
        else:
            findings.error("B003", f"//{keyword} is not followed by its number", row)
    if head is not None:
        yield BackupBlock(number, head, tuple(inside))


def fields(row: BackupLine, start: int = 0) -> list[tuple[int, str]]:
    """The comma-separated parts of a row from column `start` (0-based) on, each with its column.

    A comma at the end of the row closes the last part and opens none.
    """
    parts: list[tuple[int, str]] = []
    position = start
    while position <= len(row.text):
        match = _FIELD.match(row.text, position)
        assert match is not None  # the pattern matches the empty text, so it matches anywhere
        raw = match.group()
        parts.append((position + len(raw) - len(raw.lstrip()), raw.strip()))
        position = match.end() + 1
    if len(parts) > 1 and not parts[-1][1]:
        parts.pop()
    return parts


def integers(row: BackupLine, findings: BackupFindings, start: int = 0) -> tuple[int, ...] | None:
    """The integers of a row; None, with an error finding, at the first part that is not an integer."""
    if not start and _INTEGER_ROW.fullmatch(row.text):
        return tuple(int(part) for part in row.text.split(",") if part.strip())
    values: list[int] = []
    for column, part in fields(row, start):
        if not _INTEGER.fullmatch(part):
            _not_a_number(row, column, part, "a whole number", findings)
            return None
        values.append(int(part))
    return tuple(values)


def numbers(row: BackupLine, findings: BackupFindings, start: int = 0) -> tuple[float, ...] | None:
    """The decimal numbers of a row; None, with an error finding, at the first part that is not a number."""
    values: list[float] = []
    for column, part in fields(row, start):
        value = float(part) if _NUMBER.fullmatch(part) else float("nan")
        if not isfinite(value):
            _not_a_number(row, column, part, "a number", findings)
            return None
        values.append(value)
    return tuple(values)


def _not_a_number(row: BackupLine, column: int, part: str, wanted: str, findings: BackupFindings) -> None:
    shown = part if len(part) <= 30 else part[:30] + "…"
    message = f"{shown!r} is not {wanted}" if part else f"{wanted} is missing here"
    findings.error("B003", message, row, start=column, end=column + max(1, len(part)))
