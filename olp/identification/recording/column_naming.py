"""What a log's own columns are called in a recording: by `--column q1_rad=J1`, or as a suggestion where one is missing.

Codes: D061 a naming that means nothing, D010 a column that is named and not there, D057 numbers that look like another
unit.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, error, warning
from olp.core.units import deg, mm
from olp.identification.recording.columns import NUMBER, like_radians
from olp.identification.recording.table import RecordingTable, TableColumn

if TYPE_CHECKING:
    from olp.identification.recording.log import Log
    from olp.robots.model import Robot

Floats = NDArray[np.float64]
_TIMES: Final = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0}
_ANGLES: Final = {"deg": 1.0, "rad": 1 / deg}
_LENGTHS: Final = {"mm": 1.0, "m": 1 / mm}
_AXIS = re.compile(r"(q[1-9]\d?)(_cmd)?_(deg|rad|mm|m|pulse)")
_SPEED = re.compile(r"(qd[1-9]\d?)_(deg|rad|mm|m)_s")
_LOAD = re.compile(r"tau[1-9]\d?_nm?|i[1-9]\d?_a|r[xyz]_deg|move")
KNOWN: Final = (
    "t_s (ms, us, ns), q1_deg (rad, mm, m, pulse), q1_cmd_deg, qd1_deg_s (rad_s), tau1_nm, i1_a, "
    "x_mm (m), rx_deg, move; in a table of times line, duration_s (ms, min), sim_s, job, cycle"
)
# How other recorders call an axis or the time, a unit behind it or not.
_OTHER_AXIS = re.compile(
    r"(?:j|a|q|ax|axis|joint|axispos_act|actual_q|pos|position)[ _\[]*([1-9]\d?)\]?(?:[ _\[(].*)?",
    re.IGNORECASE,
)
_OTHER_TIME = re.compile(
    r"(?:t|time|timestamp|zeit|tick|clock|sec|seconds|stamp)(?:[ _\[(].*)?", re.IGNORECASE
)
_UNIT_WORDS: Final = {
    "ms": "ms", "msec": "ms", "us": "us", "ns": "ns", "s": "s", "sec": "s", "rad": "rad", "deg": "deg", "degree": "deg",
    "degrees": "deg", "°": "deg", "mm": "mm", "m": "m", "pulse": "pulse", "pulses": "pulse",
}  # fmt: skip


class NamedColumn(NamedTuple):
    """The recording's column `target`, of the file's column `source` times `factor`; `axis` counts pulses, 0: none."""

    target: str
    source: str
    factor: float
    axis: int = 0


def parse_naming(words: Sequence[str]) -> tuple[NamedColumn, ...]:
    """`NAME=COLUMN` each. Raises OlpError (D061) with all that mean nothing."""
    found, wrong = [], []
    for word in words:
        name, _, source = word.partition("=")
        column = _column(name.strip(), source.strip())
        if column is None or not source.strip():
            wrong.append(
                error("D061", f"--column {word} means nothing", help=f"--column q1_deg=J1; names: {KNOWN}")
            )
        else:
            found.append(column)
    targets = [column.target for column in found]
    wrong += [
        error("D061", f"--column names {name} twice", help="each column of a recording once")
        for name in dict.fromkeys(targets)
        if targets.count(name) > 1
    ]
    if wrong:
        raise OlpError(*wrong)
    return tuple(found)


def _column(name: str, source: str) -> NamedColumn | None:
    what, _, unit = name.partition("_")
    if what in ("t", "duration", "sim") and unit in _TIMES:
        return NamedColumn(f"{what}_s", source, _TIMES[unit])
    if name in ("line", "job", "cycle"):
        return NamedColumn(name, source, 1.0)
    if what in ("x", "y", "z") and unit in _LENGTHS:
        return NamedColumn(f"{what}_mm", source, _LENGTHS[unit])
    if axis := _AXIS.fullmatch(name):
        if axis[3] == "pulse":
            return NamedColumn(f"{axis[1]}{axis[2] or ''}_deg", source, 1.0, int(axis[1][1:]))
        told = "deg" if axis[3] in _ANGLES else "mm"
        return NamedColumn(f"{axis[1]}{axis[2] or ''}_{told}", source, {**_ANGLES, **_LENGTHS}[axis[3]])
    if speed := _SPEED.fullmatch(name):
        told = "deg" if speed[2] in _ANGLES else "mm"
        return NamedColumn(f"{speed[1]}_{told}_s", source, {**_ANGLES, **_LENGTHS}[speed[2]])
    return NamedColumn(name, source, 1.0) if _LOAD.fullmatch(name) else None


def named_cells(
    cells: Mapping[str, Floats], naming: Sequence[NamedColumn], robot: Robot | None, file: str
) -> dict[str, Floats]:
    """The named columns in the recording's units; all others keep their names. `robot`: for pulses.

    Raises OlpError: D010 for columns that the file does not have, D061 for pulses of a robot that is not known.
    """
    wrong = [_no_column("column of numbers", c.source, cells, file) for c in naming if c.source not in cells]
    if any(column.axis for column in naming) and (robot is None or not robot.knows_pulses):
        known = "its robot" if robot is None else f"pulses of {robot.name}"
        wrong.append(
            error("D061", f"axes in pulses need {known}", file=file, help="--robot, one of olp robots")
        )
    elif robot is not None and any(column.axis > len(robot.axes) for column in naming):
        wrong.append(error("D061", f"{robot.name} has {len(robot.axes)} axes", file=file))
    if wrong:
        raise OlpError(*wrong)
    found = {}
    for column in naming:
        factor = column.factor
        if column.axis and robot is not None:
            axis = robot.axes[column.axis - 1]
            factor = 1.0 / (float(robot.pulses_per_unit[column.axis - 1]) * (mm if axis.linear else deg))
        found[column.target] = cells[column.source] * factor
    used = {column.source for column in naming}
    return {**found, **{n: values for n, values in cells.items() if n not in used and n not in found}}


def names_times(naming: Sequence[NamedColumn]) -> bool:
    """Whether these are columns of a table of times."""
    return any(column.target in ("line", "duration_s") for column in naming)


def named_table(table: RecordingTable, naming: Sequence[NamedColumn]) -> RecordingTable:
    """A table of times with its columns named, in seconds. Raises OlpError (D010) for columns that it does not have."""
    wrong = [
        _no_column("column", c.source, table.names, table.file) for c in naming if c.source not in table.names
    ]
    if wrong:
        raise OlpError(*wrong)
    names, columns = list(table.names), list(table.columns)
    for column in naming:
        index = table.names.index(column.source)
        names[index] = column.target
        if column.factor != 1.0:
            columns[index] = _scaled(columns[index], column.factor)
    return replace(table, names=tuple(names), columns=tuple(columns))


def _scaled(column: TableColumn, factor: float) -> TableColumn:
    """Numbers times `factor`; what is none stays, and is told where it is read."""
    if column.values is not None:
        return column._replace(values=column.values * factor)
    cells = column.text or ()
    text = tuple(f"{float(cell) * factor:.15g}" if NUMBER.fullmatch(cell) else cell for cell in cells)
    return column._replace(text=text)


def _no_column(what: str, name: str, there: Iterable[str], file: str) -> Diagnostic:
    known = list(there)
    near = get_close_matches(name, known, 1)
    help = f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}"
    return error("D010", f"there is no {what} {name}", file=file, help=help)


def meant_by(name: str, columns: Sequence[str], axis_names: Sequence[str] = ()) -> str:
    """How `--column` would name the missing column `name`, "" where no column of the file looks like it.

    `axis_names`: of the robot's axes. The unit is the column's own where it says one, else the one to be checked.
    """
    for column in columns:
        if name == "t_s" and _OTHER_TIME.fullmatch(column):
            return f"--column t_{_unit_of(column, 's', tuple(_TIMES))}={column}"
        axis = re.fullmatch(r"q([1-9]\d?)_deg", name)
        if axis is None:
            continue
        other = _OTHER_AXIS.fullmatch(column)
        number = int(axis[1])
        letter = (
            number <= len(axis_names)
            and column.partition("_")[0].casefold() == axis_names[number - 1].casefold()
        )
        if letter or (other is not None and int(other[1]) == number):
            return (
                f"--column q{number}_{_unit_of(column, 'deg', ('deg', 'rad', 'mm', 'm', 'pulse'))}={column}"
            )
    return ""


def _unit_of(column: str, usual: str, possible: Sequence[str]) -> str:
    words = re.findall(r"[a-z]+|°", column.lower())[1:]
    units = [_UNIT_WORDS[word] for word in words if word in _UNIT_WORDS]
    return next((unit for unit in units if unit in possible), usual)


def doubtful_units(log: Log) -> list[Diagnostic]:
    """Numbers that another unit would explain better (D057): angles that are radians, times that are milliseconds."""
    told = []
    if like_radians(log.q, log.slides):
        says = "no axis is farther than 7 deg from 0: are these radians?"
        told.append(warning("D057", says, file=log.file, help="--column q1_rad=NAME, one for each axis"))
    if len(log) > 2 and log.period > 0.9:
        says = f"samples are {log.period:.4g} s apart: is the time in milliseconds?"
        told.append(warning("D057", says, file=log.file, help="--column t_ms=NAME"))
    return told
