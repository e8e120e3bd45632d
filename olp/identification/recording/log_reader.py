"""Reads log.csv and sim_log.csv into SI.

Codes: D010 a required column is missing, D012 a column that looks misspelt, D020 time runs backwards, D022 samples
left out.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from olp.core.diagnostic import Diagnostic, OlpError, Severity
from olp.core.units import deg, mm
from olp.identification.recording.cells import Problems
from olp.identification.recording.columns import LOG_POINT, LOG_TURN, log_axis, log_names, nearest
from olp.identification.recording.log import Log
from olp.identification.recording.log_table import Cells, LogTable, is_known, read_log_table
from olp.identification.recording.table import Floats


def read_log(path: Path) -> tuple[Log, list[Diagnostic], LogTable]:
    """The log, what there is to tell, and the cells it was made of. Raises OlpError."""
    found = read_log_table(path)
    problems = Problems(found.table)
    _required(problems, found.table.names)
    _misspelt(problems, found.table.names)
    if any(d.is_error for d in problems.found):
        raise OlpError(*problems.all())
    found = found.only(~np.isnan(found.cells["t_s"]), "they have no time")
    _check_samples(found)
    return _log(found), [*found.diagnostics, *problems.all()], found


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


def _required(problems: Problems, names: tuple[str, ...]) -> None:
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
        near = nearest(name, unknown)
        problems.cell(
            "D010", f"the column {name} is missing", -1, name, f"is it the column {near}?" if near else ""
        )


def _misspelt(problems: Problems, names: tuple[str, ...]) -> None:
    for name in names:
        if name in log_names() or log_axis(name):
            continue
        near = nearest(name, log_names(), names)
        if near:
            says = f"the column {name} means nothing to olp and is kept as it is"
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
