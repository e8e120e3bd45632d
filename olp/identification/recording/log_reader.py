"""Reads log.csv and sim_log.csv into SI.

Codes: D010 a required column is missing, D012 a column that looks misspelt, D015 a value that cannot be, D020 time runs
backwards, D022 samples left out, D026 a controller's own column names.
"""

from __future__ import annotations

import csv
import io
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, Severity, Span, error, info
from olp.core.terminal import from_cell
from olp.core.units import deg, mm
from olp.identification.recording.column_naming import NamedColumn, meant_by, named_cells
from olp.identification.recording.columns import (
    LOG_POINT,
    LOG_TURN,
    MOST_SECONDS,
    NUMBER,
    ColumnRule,
    Problems,
    log_axis,
    log_names,
    nearest,
    numbers,
    tell_bad,
)
from olp.identification.recording.log import Log
from olp.identification.recording.table import (
    MOST_BYTES,
    SHOWN,
    Floats,
    RecordingTable,
    TableColumn,
    cell_extent,
    check_header,
    decode,
    is_parquet,
    left_out_rows,
    load_parquet,
    parquet_column,
    read_bytes,
    read_table,
)

if TYPE_CHECKING:
    from olp.robots.model import Robot


def read_log(
    path: Path, naming: Sequence[NamedColumn] = (), robot: Robot | None = None
) -> tuple[Log, list[Diagnostic], LogTable]:
    """The log, what there is to tell, and the cells it was made of. Raises OlpError.

    `naming`: what columns of the file are in a recording; `robot`: whose axes and pulses they are.
    """
    found = _in_our_columns(read_log_table(path), naming, robot)
    problems = Problems(found.table)
    _required(problems, found.table.names, robot.axis_names if robot is not None else ())
    _misspelt(problems, found.table.names)
    if any(d.is_error for d in problems.found):
        raise OlpError(*problems.all())
    found = found.only(~np.isnan(found.cells["t_s"]), "they have no time")
    _check_sizes(found)
    _check_samples(found)
    return _log(found), [*found.diagnostics, *problems.all()], found


def _in_our_columns(found: LogTable, naming: Sequence[NamedColumn], robot: Robot | None) -> LogTable:
    """A log with a controller's own column names, as a recording's. One that has a column t_s is taken as it is."""
    from olp.languages.recorders import controller_logs

    names = found.table.names
    kind = None if "t_s" in names else next((log for log in controller_logs() if log.knows(names)), None)
    if kind is None and not naming:
        return found
    texts = {name: values for name, values in found.cells.items() if isinstance(values, tuple)}
    numbers = {name: values for name, values in found.cells.items() if name not in texts}
    if naming:
        cells: Cells = {**named_cells(numbers, naming, robot, found.table.file), **texts}
        says = "columns are as --column names them"
    elif kind is not None:
        cells, says = {**kind.columns(numbers), **texts}, f"read as {kind.files}"
    help = "" if naming else "units and axes are those of this format"
    told = info("D026", says, file=found.table.file, help=help)
    # Columns stand elsewhere in the file: problems are told by their rows.
    rows = np.zeros_like(found.table.line)
    return LogTable(replace(found.table, names=tuple(cells), line=rows), cells, (*found.diagnostics, told))


def _check_sizes(found: LogTable) -> None:
    """No recorder writes such numbers, and no square of them is one. Raises OlpError (D015)."""
    problems = None
    for name, values in found.cells.items():
        if isinstance(values, tuple):
            continue
        rule = ColumnRule(lowest=-MOST_SECONDS, highest=MOST_SECONDS)
        for row in np.nonzero(~rule.fits(values))[0].tolist():
            problems = problems or Problems(found.located())
            problems.cell("D015", f"{name} cannot be {values[row]:g}", row, name, rule.told(values[row]))
    if problems is not None:
        raise OlpError(*problems.all())


def _check_samples(found: LogTable) -> None:
    """Time may stand still (a recorder quicker than its clock) but never run backwards (D020). Raises OlpError."""
    time, counter = found.cells["t_s"], _counter(found)
    back = np.nonzero(np.diff(time) < 0)[0] + 1
    wrong = np.nonzero((counter % 1 != 0) | (counter < -1) | (counter > 1e9))[0]
    if not len(back) and not len(wrong):
        return
    problems = Problems(found.located())
    for row in back.tolist():
        says = f"t_s runs backwards from {time[row - 1]:.15g} to {time[row]:.15g} s"
        problems.cell("D020", says, row, "t_s", "two recordings in one file? cut them apart")
    for row in wrong.tolist():
        problems.cell("D015", f"move is a move's number or -1, not {counter[row]:g}", row, "move")
    raise OlpError(*problems.all())


def _counter(found: LogTable) -> Floats:
    counter = found.cells.get("move", np.zeros(0))
    filled: Floats = np.where(np.isnan(counter), -1.0, counter)
    return filled


def _required(problems: Problems, names: tuple[str, ...], axis_names: Sequence[str]) -> None:
    missing = [] if "t_s" in names else ["t_s"]
    axes = [axis for name in names if (axis := log_axis(name))]
    last = max((axis.number for axis in axes), default=1)
    measured = {axis.number for axis in axes if axis.what == "q"}
    missing += [f"q{i}_deg" for i in range(1, last + 1) if i not in measured]
    for group in (LOG_POINT, LOG_TURN):
        if any(name in names for name in group):
            missing += [name for name in group if name not in names]
    for name in missing:
        unknown = [other for other in names if other not in log_names()]
        option = meant_by(name, unknown, axis_names)
        near = option.partition("=")[2] or nearest(name, unknown)
        help = f"is it the column {near}?" if near else ""
        help += f" olp recording import {option} says so" if option else ""
        problems.cell("D010", f"the column {name} is missing", -1, name, help)


def _misspelt(problems: Problems, names: tuple[str, ...]) -> None:
    for name in names:
        if name in log_names() or log_axis(name):
            continue
        near = nearest(name, log_names(), names)
        if near:
            says = f"olp does not know the column {name} and keeps it unchanged"
            problems.cell("D012", says, -1, name, f"did you mean {near}?", Severity.WARNING)


def _log(found: LogTable) -> Log:
    names, cells = found.table.names, found.cells
    axes = {(axis.what, axis.number): (name, axis.slides) for name in names if (axis := log_axis(name))}
    width = max((number for what, number in axes if what == "q"), default=0)

    def of_axes(what: str) -> Floats | None:
        if not any(part == what for part, _ in axes):
            return None
        values = np.full((len(found.table), width), np.nan)
        for number in range(1, width + 1):
            if (what, number) in axes:
                name, slides = axes[what, number]
                turns = what in ("q", "command", "speed")
                values[:, number - 1] = cells[name] * ((mm if slides else deg) if turns else 1.0)
        return values

    def vector(group: tuple[str, ...], factor: float) -> Floats | None:
        return np.stack([cells[name] for name in group], axis=1) * factor if group[0] in names else None

    rest: Cells = {name: values for name, values in cells.items() if not is_known(name)}
    q = of_axes("q")
    assert q is not None
    return Log(
        time=cells["t_s"],
        q=q,
        slides=tuple(axes["q", i][1] for i in range(1, width + 1)),
        command=of_axes("command"),
        speed=of_axes("speed"),
        torque=of_axes("torque"),
        current=of_axes("current"),
        position=vector(LOG_POINT, mm),
        angles=vector(LOG_TURN, deg),
        move=_counter(found).astype(np.int64) if "move" in cells else None,
        covariates={name: values for name, values in rest.items() if not isinstance(values, tuple)},
        texts={name: values for name, values in rest.items() if isinstance(values, tuple)},
        file=found.table.file,
    )


# --- Log table ---
# The cells of log.csv and sim_log.csv: a million samples in a second, and still every bad cell by line and column.
#
# The quick path lets pandas convert whole columns and proves by counting commas that no row was short or long. Only
# a file that fails it is read again slowly, to say where.

_PROBE = 200  # rows that decide which unknown columns are text
Cells = dict[str, Any]  # name -> floats (n,), or a tuple of texts


@dataclass(frozen=True, slots=True)
class LogTable:
    """`cells` as written; `table` knows names and lines, and has its lines' text only after `located`."""

    table: RecordingTable
    cells: Cells
    diagnostics: tuple[Diagnostic, ...] = ()

    def located(self) -> RecordingTable:
        """The table with the text of its lines, for messages."""
        path = Path(self.table.file)
        if is_parquet(path):
            return self.table
        return replace(self.table, text=tuple(io.StringIO(decode(read_bytes(path), str(path)), newline="")))

    def only(self, good: NDArray[np.bool_], why: str) -> LogTable:
        """Without the samples that are not `good`, which are told (D022)."""
        if good.all():
            return self
        lines = self.table.line
        bad = np.nonzero(~good)[0]
        places = lines[bad].tolist() if lines.any() else (bad + 1).tolist()
        kept: Cells = {
            name: tuple(cell for cell, ok in zip(values, good, strict=True) if ok)
            if isinstance(values, tuple)
            else values[good]
            for name, values in self.cells.items()
        }
        told = left_out_rows(self.table.file, places, why)
        table = replace(self.table, line=lines[good], left_out=self.table.left_out + len(bad))
        return LogTable(table, kept, (*self.diagnostics, *told))


def column_names(path: Path) -> tuple[str, ...]:
    """The names of the columns of a table, their numbers from 1 where it begins with numbers. Raises OlpError."""
    if is_parquet(path):
        return check_header([str(name) for name in load_parquet(path).column_names], str(path), "")
    if path.name.lower().endswith(".xlsx"):
        return read_table(path).names
    raw = read_bytes(path)
    first = decode(raw[: raw.find(b"\n") + 1] or raw, str(path))
    return _names(next(csv.reader([first]), []), str(path), first)[0]


def read_log_table(path: Path) -> LogTable:
    """The cells of the log in `path`. Raises OlpError with every cell that cannot be read."""
    if is_parquet(path):
        return _parquet(path)
    if path.name.lower().endswith(".xlsx"):
        return _workbook(path)
    try:
        return _csv(path)
    except csv.Error as problem:
        raise OlpError(
            error("D002", f"not CSV: {problem}", file=str(path), help="check the quotes")
        ) from None


def is_known(name: str) -> bool:
    """Whether the contract says what stands in this column of a log."""
    return name in ("t_s", "move", *LOG_POINT, *LOG_TURN) or log_axis(name) is not None


def _csv(path: Path) -> LogTable:
    import pandas

    file, raw = str(path), read_bytes(path)
    if raw[:3] == b"\xef\xbb\xbf":
        raw = raw[3:]
    # Only without quotes and old line ends, and where each row has its commas, do rows and lines agree.
    if b'"' in raw or b"\r" in raw.replace(b"\r\n", b""):
        return _slowly(file, raw)
    first = decode(raw[: raw.find(b"\n") + 1] or raw, file)
    names, headless = _names(next(csv.reader([first]), []), file, first)
    text = _text_columns(raw, names)
    kinds = {name: str if name in text else "float64" for name in names}
    rows = raw.count(b"\n") + (not raw.endswith(b"\n")) - (not headless)
    if rows * len(names) * 8 > MOST_BYTES:
        raise OlpError(error("D003", f"{rows:,} samples of {len(names)} columns are too many", file=file))
    if raw.count(b",") != (rows + (not headless)) * (len(names) - 1):
        return _slowly(file, raw)
    try:
        with warnings.catch_warnings():
            # One row with a comma too many and one with a comma too few: pandas would drop the cell and only warn.
            warnings.simplefilter("error", pandas.errors.ParserWarning)
            frame = pandas.read_csv(
                io.BytesIO(raw),
                header=None if headless else 0,
                names=list(names),
                dtype=kinds,
                keep_default_na=False,
                na_values=[""],
                skip_blank_lines=False,
                index_col=False,
                encoding="utf-8",
            )
    except (ValueError, pandas.errors.ParserWarning):
        return _slowly(file, raw)
    cells: Cells = {
        name: tuple(map(from_cell, frame.iloc[:, i].fillna("")))
        if name in text
        else frame.iloc[:, i].to_numpy(np.float64)
        for i, name in enumerate(names)
    }
    if any(np.isinf(values).any() for name, values in cells.items() if name not in text):
        return _slowly(file, raw)
    return LogTable(
        RecordingTable(file, names, (), np.arange(len(frame)) + (1 if headless else 2), (first,)), cells
    )


def _names(row: list[str], file: str, line: str) -> tuple[tuple[str, ...], bool]:
    """The names of the columns: their numbers from 1, and True, where the file begins with numbers."""
    if row and all(NUMBER.fullmatch(cell.strip()) for cell in row):
        return tuple(str(number) for number in range(1, len(row) + 1)), True
    return check_header(row, file, line), False


def _text_columns(raw: bytes, names: tuple[str, ...]) -> set[str]:
    """Unknown columns whose first cells are no numbers."""
    unknown = [i for i, name in enumerate(names) if not is_known(name)]
    if not unknown:
        return set()
    head = raw[: 400 * _PROBE].decode("utf-8", "replace").splitlines()[1 : _PROBE + 1]
    rows = list(csv.reader(head[:-1] or head))
    return {
        names[i]
        for i in unknown
        if any(len(row) > i and row[i] and not NUMBER.fullmatch(row[i].strip()) for row in rows)
    }


def _slowly(file: str, raw: bytes) -> LogTable:
    """Row by row. A last row that breaks off is left out (the recorder was stopped); any other bad row is an error."""
    lines = tuple(io.StringIO(decode(raw, file), newline=""))
    reader = csv.reader(lines)
    names, headless = _names(next(reader, []), file, lines[0] if lines else "")
    if headless:
        reader = csv.reader(lines)
    text = _text_columns(raw, names)
    kept: list[list[str]] = []
    starts: list[int] = []
    blank: list[int] = []
    wrong: list[tuple[int, list[str]]] = []
    while True:
        start = reader.line_num + 1
        row = next(reader, None)
        if row is None:
            break
        if not any(cell.strip() for cell in row):
            blank.append(start)
        elif len(row) != len(names):
            wrong.append((start, row))
        else:
            kept.append(row)
            starts.append(start)
    told = list(left_out_rows(file, blank, "nothing is written in them"))
    left_out = len(blank)
    if wrong and wrong[-1][0] > (starts[-1] if starts else 0) and len(wrong[-1][1]) < len(names):
        told += left_out_rows(file, [wrong.pop()[0]], "the file breaks off there")
        left_out += 1
    table = RecordingTable(file, names, (), np.array(starts, dtype=np.int64), lines, left_out=left_out)
    problems = Problems(table)
    problems.found += [_ragged(file, lines, line, len(row), len(names)) for line, row in wrong[:SHOWN]]
    cells: Cells = {}
    for i, name in enumerate(names):
        column = tuple(from_cell(row[i].strip()) for row in kept)
        cells[name] = column if name in text else _numbers(problems, name, column)
    if problems.found:
        raise OlpError(*problems.all())
    return LogTable(replace(table, text=lines[:1]), cells, tuple(told))


def _numbers(problems: Problems, name: str, column: tuple[str, ...]) -> Floats:
    values, bad = numbers(TableColumn(np.zeros(len(column), dtype=bool), column))
    for row in bad.tolist():
        tell_bad(problems, name, column[row], row)
    return values


def _ragged(file: str, lines: tuple[str, ...], line: int, found: int, width: int) -> Diagnostic:
    source = lines[line - 1].rstrip("\r\n")
    column = cell_extent(source, min(found, width))[0]
    span = Span(line, column, column + 1)
    return error("D013", f"row has {found} cells, the header {width}", span, file=file, source_line=source)


def _workbook(path: Path) -> LogTable:
    table = read_table(path)
    problems = Problems(table)
    cells: Cells = {}
    for name, column in zip(table.names, table.columns, strict=True):
        values, bad = numbers(column)
        if len(bad) and not is_known(name):
            cells[name] = column.text
            continue
        cells[name] = values
        for row in bad.tolist():
            tell_bad(problems, name, column.text[row] if column.text else "nan", row)
    if problems.found:
        raise OlpError(*problems.all())
    return LogTable(table, cells, table.diagnostics)


def _parquet(path: Path) -> LogTable:
    frame = load_parquet(path)
    names = check_header([str(name) for name in frame.column_names], str(path), "")
    table = RecordingTable(str(path), names, (), np.zeros(frame.num_rows, dtype=np.int64))
    problems = Problems(table)
    cells: Cells = {}
    for i, name in enumerate(names):
        column: TableColumn = parquet_column(frame.column(i))
        if column.values is None and not is_known(name):
            cells[name] = column.text
            continue
        cells[name], bad = numbers(column)
        for row in bad.tolist():
            tell_bad(problems, name, "nan" if column.text is None else column.text[row], row)
    if problems.found:
        raise OlpError(*problems.all())
    return LogTable(table, cells)
