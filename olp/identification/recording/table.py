"""A table of a recording before anything is made of it: names, cells, and where each cell stands in its file.

CSV (UTF-8, comma and decimal point, or semicolon and decimal comma), the same gzipped, Parquet, or the first sheet of
an Excel workbook. Codes: D002 unreadable, D003 too large, D004 no library for Parquet or Excel, D011 a header that
names a column twice or not at all, D013 a row of another width, D022 rows left out.
"""

from __future__ import annotations

import contextlib
import csv
import gzip
import io
import re
import zipfile
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, Span, error, warning
from olp.core.files import read_input
from olp.core.terminal import from_cell

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

MOST_BYTES = 2_000_000_000  # of a file, unpacked
MOST_ROWS = 1_000_000  # of moves
MOST_COLUMNS = 1_000
_LONGEST_LINE = 1_000_000  # [bytes]
_CHUNK = 1_000_000  # [bytes] that are unpacked at once
_PACKED = 200  # times smaller at best: numbers that change pack to a tenth
_SMALL = 50_000_000  # [bytes] that may be unpacked to whatever they were packed from
SHOWN = 20  # findings of one kind that are told one by one
SUFFIXES = (".csv", ".csv.gz", ".parquet", ".pq", ".xlsx")


class TableColumn(NamedTuple):
    """The cells of one column: `values` of a typed file, else their `text`; `missing` where nothing is written."""

    missing: Flags
    text: tuple[str, ...] | None = None
    values: Floats | None = None


@dataclass(frozen=True, slots=True)
class RecordingTable:
    """`line` (n,): where each row starts in the file, 0 when it has no lines. `text`: the file's lines."""

    file: str
    names: tuple[str, ...]
    columns: tuple[TableColumn, ...]
    line: NDArray[np.int64]
    text: tuple[str, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    left_out: int = 0

    def __len__(self) -> int:
        return len(self.line)

    def place(self, row: int, column: int) -> tuple[Span | None, str]:
        """Where the cell stands, and the text of its line; row -1 is the header."""
        number = int(self.line[row]) if row >= 0 else 1
        if not number or (not self.text and row < 0):
            return None, ""
        if not self.text:  # a row of a workbook
            return Span(number), ""
        source = self.text[number - 1].rstrip("\r\n")
        start, end = cell_extent(source, column)
        return Span(number, start, end), source


def cell_extent(line: str, column: int) -> tuple[int, int]:
    """Columns, 1-based and half open, of cell `column` (from 0) of a CSV line; its end when it has fewer."""
    start, quoted, index = 0, False, 0
    for at, letter in enumerate(line):
        if letter == '"':
            quoted = not quoted
        elif letter == "," and not quoted:
            if index == column:
                return start + 1, max(at, start + 1) + 1
            index, start = index + 1, at + 1
    return (start + 1, max(len(line), start + 1) + 1) if index == column else (len(line) + 1, len(line) + 2)


def role_of(path: Path) -> str:
    """The file's name without the suffixes a table may have, "" when it is no table."""
    for suffix in sorted(SUFFIXES, key=len, reverse=True):
        if path.name.lower().endswith(suffix):
            return path.name[: -len(suffix)]
    return ""


def is_parquet(path: Path) -> bool:
    return path.name.lower().endswith((".parquet", ".pq"))


def read_bytes(path: Path) -> bytes:
    """The file, unpacked. Raises OlpError (D002, D003)."""
    file = str(path)
    try:
        if path.stat().st_size > MOST_BYTES:
            raise OlpError(_too_large(file, MOST_BYTES))
        if not path.name.lower().endswith(".gz"):
            raw = read_input(path, MOST_BYTES)
        else:
            raw = _unpacked(read_input(path, MOST_BYTES), file)
    except (EOFError, zlib.error, gzip.BadGzipFile) as problem:
        raise OlpError(
            error("D002", f"not a whole gzip file: {problem}", file=file, help="pack it again")
        ) from None
    except OSError as problem:
        why = problem.strerror or str(problem)
        raise OlpError(error("D002", f"cannot read the file: {why}", file=file)) from None
    if _has_endless_line(raw):
        says = f"a line has more than {_LONGEST_LINE // 1_000_000} MB"
        raise OlpError(error("D003", says, file=file, help="put each row on its own line"))
    return with_commas(raw)


def _unpacked(packed: bytes, file: str) -> bytes:
    """What a gzip file holds. A few kilobytes may unpack to any size: it is refused as soon as it shows."""
    source, chunks, size = io.BytesIO(packed), [], 0
    with gzip.open(source, "rb") as unpacked:
        while chunk := unpacked.read(_CHUNK):
            chunks.append(chunk)
            size += len(chunk)
            if size > MOST_BYTES:
                raise OlpError(_too_large(file, MOST_BYTES))
            if size > max(_SMALL, _PACKED * source.tell()):
                says = f"the file unpacks to more than {_PACKED} times its size, which no table does"
                raise OlpError(error("D003", says, file=file, help="pack the recording again, or not at all"))
    return b"".join(chunks)


_DECIMAL = re.compile(rb"(?<=\d),(?=\d)")
_QUOTED = re.compile(rb'"[^"]*"')


def with_commas(raw: bytes) -> bytes:
    """A table that semicolons, tabs or single blanks separate, with commas and decimal points.

    Semicolons and decimal commas are what spreadsheets of half of Europe write, tabs and blanks what some recorders do.

    Every cell keeps its place. A table with commas in its header stays as it is.
    """
    head = _QUOTED.sub(b"", raw.partition(b"\n")[0])
    separator = next((one for one in (b";", b"\t") if one in head), b"")
    if b"," in head or (b'"' in raw and not separator):
        return raw
    if b'"' in raw:
        return _requoted(raw, separator.decode())
    if not separator:
        words = head.split(b" ")
        # Names without blanks, three or more: a recorder that separates its columns by one.
        return raw.replace(b" ", b",") if len(words) > 2 and all(words) and b"," not in raw else raw
    pointed = _DECIMAL.sub(b".", raw)
    return _requoted(raw, separator.decode()) if b"," in pointed else pointed.replace(separator, b",")


def _requoted(raw: bytes, separator: str) -> bytes:
    """The same table with commas, in quotes where need be; as it was where it is no table, which is told later."""
    try:
        rows = list(
            csv.reader(io.StringIO(raw.decode("utf-8-sig"), newline=""), delimiter=separator, strict=True)
        )
    except (UnicodeDecodeError, csv.Error):
        return raw
    out = io.StringIO(newline="")
    number = re.compile(r"([+-]?\d*),(\d+([eE][+-]?\d+)?)")
    pointed = ([number.sub(r"\1.\2", c) if number.fullmatch(c.strip()) else c for c in row] for row in rows)
    csv.writer(out, lineterminator="\n").writerows(pointed)
    return out.getvalue().encode()


def _has_endless_line(raw: bytes) -> bool:
    at = 0
    while len(raw) - at > _LONGEST_LINE:
        ends = [raw.rfind(end, at, at + _LONGEST_LINE) for end in (b"\n", b"\r")]
        if max(ends) < 0:
            return True
        at = max(ends) + 1
    return False


def _too_large(file: str, most: int) -> Diagnostic:
    return error(
        "D003",
        f"the file has more than {most // 1_000_000:,} MB",
        file=file,
        help="cut the recording in pieces, or record more slowly",
    )


def decode(raw: bytes, file: str) -> str:
    """UTF-8, with or without a byte order mark. Raises OlpError (D002)."""
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        line = raw.count(b"\n", 0, problem.start) + 1
        raise OlpError(
            error("D002", "not UTF-8 text", Span(line), file=file, help="save the table as CSV UTF-8")
        ) from None


def read_table(path: Path) -> RecordingTable:
    """The table of moves in `path`. Raises OlpError with every row that has no place in it."""
    if is_parquet(path):
        return _read_parquet(path)
    if path.name.lower().endswith(".xlsx"):
        return _read_workbook(path)
    file = str(path)
    raw = read_bytes(path)
    if raw.count(b"\n") + raw.count(b"\r") > 4 * MOST_ROWS:  # with CRLF, and every other line empty
        raise OlpError(error("D003", f"more than {MOST_ROWS:,} moves", file=file))
    lines = list(io.StringIO(decode(raw, file), newline=""))
    reader = csv.reader(lines, strict=True)
    rows: list[list[str]] = []
    starts: list[int] = []
    wrong = 0  # rows of another width
    try:
        while True:
            start = reader.line_num + 1
            row = next(reader, None)
            if row is None:
                break
            rows.append([from_cell(cell.strip()) for cell in row])
            starts.append(start)
            wrong += len(row) != len(rows[0]) and any(rows[-1])
            if wrong > SHOWN:
                break
            if len(rows) > MOST_ROWS + 1:
                raise OlpError(error("D003", f"more than {MOST_ROWS:,} moves", file=file))
    except csv.Error as problem:
        span = Span(reader.line_num)
        raise OlpError(
            error("D002", f"not CSV: {problem}", span, file=file, help="check the quotes")
        ) from None
    # Separators at the end of every line make no column, where nothing stands behind them.
    width = _width(rows[0] if rows else [])
    if rows and 0 < width < len(rows[0]):
        rows = [row if any(row[width:]) else row[:width] for row in rows]
    return _from_rows(file, tuple(lines), rows, starts)


def _width(header: Sequence[str]) -> int:
    """Columns up to the last one with a name."""
    return max((i + 1 for i, name in enumerate(header) if name), default=0)


def _read_workbook(path: Path) -> RecordingTable:
    """The first sheet, formulas as their last values. Raises OlpError: D002 unreadable, D003 too large, D004."""
    file = str(path)
    try:
        from openpyxl import load_workbook
    except ImportError:
        help = 'install it: pip install "olp[excel]"; or save the sheet as CSV'
        raise OlpError(error("D004", "reading Excel needs openpyxl", file=file, help=help)) from None
    raw = read_input(path, MOST_BYTES)
    try:
        with zipfile.ZipFile(io.BytesIO(raw)) as packed:
            unpacked = sum(part.file_size for part in packed.infolist())
        if unpacked > max(_SMALL, _PACKED * len(raw)):
            says = f"the workbook unpacks to more than {_PACKED} times its size, which no table does"
            raise OlpError(error("D003", says, file=file, help="save the sheet as CSV"))
        with contextlib.closing(load_workbook(io.BytesIO(raw), read_only=True, data_only=True)) as book:
            sheet = book.worksheets[0]
            cells = [[_cell_text(cell) for cell in row] for row in sheet.iter_rows(values_only=True)]
    except (
        zipfile.BadZipFile,
        KeyError,
        ValueError,
        TypeError,
        IndexError,
        SyntaxError,
        AttributeError,
    ) as problem:
        says = f"not an Excel workbook: {problem}"
        raise OlpError(error("D002", says, file=file, help="save the sheet as CSV UTF-8")) from None
    if len(cells) > MOST_ROWS + 1:
        raise OlpError(error("D003", f"more than {MOST_ROWS:,} moves", file=file))
    # Sheets remember cells that were once used: what lies right of the header and is empty is no column.
    width = _width(cells[0] if cells else [])
    rows = [
        [*row[:width], *([""] * (width - len(row))), *(cell for cell in row[width:] if cell)] for row in cells
    ]
    return _from_rows(file, (), rows, list(range(1, len(rows) + 1)))


def _cell_text(value: object) -> str:
    """As CSV would have it: whole numbers without a point, nothing for an empty cell."""
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:.15g}"
    return from_cell(str(value).strip())


def _from_rows(file: str, lines: tuple[str, ...], rows: list[list[str]], starts: list[int]) -> RecordingTable:
    names = check_header(rows[0] if rows else [], file, lines[0] if lines else "")
    width = len(names)
    blank = [not any(row) for row in rows]
    wrong = [i for i in range(1, len(rows)) if not blank[i] and len(rows[i]) != width]
    if wrong:
        raise OlpError(*(_wrong_width(file, lines, starts[i], len(rows[i]), width) for i in wrong[:SHOWN]))
    kept = [i for i in range(1, len(rows)) if not blank[i]]
    empty = [starts[i] for i in range(1, len(rows)) if blank[i]]
    cells = list(zip(*(rows[i] for i in kept), strict=True)) if kept else [()] * width
    return RecordingTable(
        file,
        names,
        tuple(
            TableColumn(np.array([not cell for cell in column], dtype=bool), tuple(column))
            for column in cells
        ),
        np.array([starts[i] for i in kept], dtype=np.int64),
        lines,
        left_out_rows(file, empty, "nothing is written in them"),
        len(empty),
    )


def left_out_rows(file: str, lines: Sequence[int], why: str) -> tuple[Diagnostic, ...]:
    """The warning (D022) that counts and lists rows left out, none when there is none."""
    if not len(lines):
        return ()
    listed = ", ".join(str(line) for line in lines[:SHOWN]) + (" …" if len(lines) > SHOWN else "")
    rows = "1 row was" if len(lines) == 1 else f"{len(lines):,} rows were"
    says = f"{rows} left out, {why}: line{'s' if len(lines) > 1 else ''} {listed}"
    return (warning("D022", says, Span(int(lines[0])), file=file),)


def _wrong_width(file: str, lines: Sequence[str], line: int, found: int, width: int) -> Diagnostic:
    source = lines[line - 1].rstrip("\r\n") if lines else ""
    column = cell_extent(source, min(found, width))[0] if lines else 0
    help = (
        "a decimal comma? the decimal mark is a point" if found > width else "empty cells keep their commas"
    )
    return error(
        "D013",
        f"row has {found} cells, the header {width}",
        Span(line, column, column + 1) if lines else Span(line),
        file=file,
        source_line=source,
        help=help,
    )


def _is_number(text: str) -> bool:
    with contextlib.suppress(ValueError):
        return bool(np.isfinite(float(text)))
    return False


def check_header(header: Sequence[str], file: str, line: str) -> tuple[str, ...]:
    """The names of the columns. Raises OlpError: D002 no table, D003 too wide, D011 no name or one name twice."""
    names = tuple(from_cell(name.strip()) for name in header)
    line = line.rstrip("\r\n")
    if not any(names):
        raise OlpError(error("D002", "no header row", file=file, help="the first line names the columns"))
    if len(names) == 1 and (";" in names[0] or "\t" in names[0]):
        says = "the columns are not separated by commas"
        help = "save it as CSV with commas and decimal points, or with semicolons and decimal commas"
        raise OlpError(error("D002", says, Span(1), file=file, source_line=line, help=help))
    if all(map(_is_number, names)):
        says = "the first row has numbers alone, no names of columns"
        help = "write the names of the columns above it"
        raise OlpError(error("D002", says, Span(1), file=file, source_line=line, help=help))
    if len(names) > MOST_COLUMNS:
        raise OlpError(error("D003", f"more than {MOST_COLUMNS:,} columns", file=file))
    problems = []
    for index, name in enumerate(names):
        if not name or name in names[:index]:
            says = f"column {name!r} is there twice" if name else f"column {index + 1} has no name"
            span = Span(1, *cell_extent(line, index)) if line else None
            problems.append(
                error("D011", says, span, file=file, source_line=line, help="name each column once")
            )
    if problems:
        raise OlpError(*problems)
    return names


def _read_parquet(path: Path) -> RecordingTable:
    frame = load_parquet(path)
    names = check_header([str(name) for name in frame.column_names], str(path), "")
    if frame.num_rows > MOST_ROWS:
        raise OlpError(error("D003", f"more than {MOST_ROWS:,} moves", file=str(path)))
    columns = tuple(parquet_column(frame.column(i)) for i in range(len(names)))
    return RecordingTable(str(path), names, columns, np.zeros(frame.num_rows, dtype=np.int64))


def load_parquet(path: Path):  # type: ignore[no-untyped-def]
    """The file as a pyarrow.Table. Raises OlpError: D002 unreadable, D003 too large, D004 no library."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise OlpError(
            error(
                "D004",
                "reading Parquet needs pyarrow",
                file=str(path),
                help='install it: pip install "olp[parquet]"; or save the table as CSV',
            )
        ) from None
    try:
        found = parquet.ParquetFile(path)
        rows, width = found.metadata.num_rows, found.metadata.num_columns
        if rows * width * 8 > MOST_BYTES:
            raise OlpError(_too_large(str(path), MOST_BYTES))
        return found.read()
    except (pyarrow.ArrowException, OSError) as problem:
        raise OlpError(error("D002", f"not a Parquet file: {problem}", file=str(path))) from None


def parquet_column(chunks) -> TableColumn:  # type: ignore[no-untyped-def]
    """A null is missing; a NaN that was written as a number stays one."""
    import pyarrow

    missing = np.asarray(chunks.is_null().to_numpy(), dtype=bool)
    kind = chunks.type
    if pyarrow.types.is_integer(kind) or pyarrow.types.is_floating(kind):
        values = np.asarray(chunks.cast(pyarrow.float64(), safe=False).to_numpy(), dtype=np.float64)
        return TableColumn(missing, values=values)
    text = tuple("" if cell is None else str(cell).strip() for cell in chunks.to_pylist())
    return TableColumn(np.array([not cell for cell in text], dtype=bool), text)
