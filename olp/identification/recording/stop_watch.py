"""Makes the moves of a recording out of a table of times and the program they were taken of.

A person with a stop watch, or a controller's cycle log, writes `line,duration_s` (and `job`, `cycle`); where each
line begins and ends is in the program.

Codes: D055 a line or a job that the program does not execute, D056 rows that are no whole rounds of the program.
"""

from __future__ import annotations

import os
from collections import Counter, defaultdict
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, Severity, error, warning
from olp.identification.recording.columns import (
    MOVE_NUMBERS,
    Problems,
    checked,
    move_names,
    nearest,
    numbers,
    texts,
)
from olp.identification.recording.from_log import recorded_steps, unsayable
from olp.identification.recording.moves import RecordedMoves
from olp.identification.recording.table import Floats, RecordingTable
from olp.runtime.plan import Plan, StepKind

if TYPE_CHECKING:
    from olp.timing.result import Timing

_REQUIRED = ("line", "duration_s")
_OWN = (*_REQUIRED, "job", "cycle", "move")
# What a table may say of the run beside its times, and the field of RecordedMoves that holds it.
_TOLD = {
    "sim_s": "sim",
    "t_start_s": "t_start",
    "payload_kg": "payload",
    "payload_inertia_kg_m2": "payload_inertia",
    "override_pct": "override",
    "sim_payload_kg": "sim_payload",
    "sim_payload_inertia_kg_m2": "sim_payload_inertia",
    "sim_override_pct": "sim_override",
}
_LISTED = 12


def moves_from_times(
    table: RecordingTable, timing: Timing, override: float | None = None
) -> tuple[RecordedMoves, Floats, tuple[Diagnostic, ...]]:
    """The timed lines in the order the program executes them, what the plan gives each [s], and what is to tell.

    A line that the program executes k times has its rows in that order: the first k are the first round. Columns that
    mean nothing here are kept: numbers as possible explanations, texts as groups. `override` [1]: the program override
    under which the robot ran.
    Raises OlpError with everything that is wrong: D010, D012, D014, D015, D055.
    """
    if not len(timing.plan.moves):
        raise OlpError(error("D041", "this program moves nothing", file=timing.plan.path))
    problems = Problems(table)
    columns = dict(zip(table.names, table.columns, strict=True))
    for name in _REQUIRED:
        if name not in columns:
            meant = nearest_of(name, table.names)
            if meant.startswith("duration_"):
                help = f"is it column {meant}? --column {meant}={meant} says so"
            elif meant:
                help = f"is it column {meant}? --column {name}={meant} says so"
            else:
                there = ", ".join(table.names)
                help = f"--column {name}=COLUMN says which one it is; there are {there}"
            problems.whole("D010", f"column {name} is missing", help)
    if any(name not in columns for name in _REQUIRED):
        raise OlpError(*problems.all())
    mine = [name for name in (*_REQUIRED, "cycle", *_TOLD) if name in columns]
    value = {name: checked(problems, name, columns[name], MOVE_NUMBERS[name]) for name in mine}
    jobs = texts(columns["job"]) if "job" in columns else ("",) * len(table)
    for name in (n for n in (*_REQUIRED, "cycle") if n in columns):
        for row in np.flatnonzero(columns[name].missing).tolist():
            problems.cell("D014", f"{name} is empty", row, name)
    step, round_ = _steps(table, timing.plan, value["line"], jobs, problems)
    if any(found.is_error for found in problems.all()):
        raise OlpError(*table.diagnostics, *problems.all())
    cycle = value["cycle"].astype(np.int64) if "cycle" in value else round_
    order = np.lexsort((step, cycle))
    step = step[order]
    made = replace(
        _recorded(timing, step),
        duration=value["duration_s"][order],
        override=np.full(len(step), np.nan if override is None else override),
    )
    if len(set(cycle.tolist())) > 1:
        made = replace(made, cycle=cycle[order])
    said: dict[str, Any] = {field: value[name][order] for name, field in _TOLD.items() if name in value}
    made = replace(made, **said)
    made = _with_others(made, table, order, problems)
    told = [*table.diagnostics, *problems.all(), *unsayable(made, timing)]
    return made, np.asarray(timing.duration_s[step], dtype=np.float64), tuple(told)


def _with_others(
    made: RecordedMoves, table: RecordingTable, order: NDArray[np.intp], problems: Problems
) -> RecordedMoves:
    """Columns without a meaning of their own; those that the program answers are left out and told."""
    covariates, groups = dict(made.covariates), dict(made.texts)
    programmed = set(move_names()) - {"temperature_c"}
    for name, column in zip(table.names, table.columns, strict=True):
        if name in _OWN or name in _TOLD:
            continue
        if name in programmed:
            problems.whole(
                "D012", f"column {name} is not used: the program says it", severity=Severity.WARNING
            )
            continue
        cells = numbers(column)
        if len(cells.bad):
            groups[name] = tuple(texts(column)[i] for i in order.tolist())
        else:
            covariates[name] = cells.values[order]
    return replace(made, covariates=covariates, texts=groups)


def nearest_of(name: str, there: tuple[str, ...]) -> str:
    """The column that was probably meant by `name`, "" where none is near."""
    return next((other for other in there if nearest(other, (name,)) == name), "")


def _steps(
    table: RecordingTable, plan: Plan, line: Floats, jobs: tuple[str, ...], problems: Problems
) -> tuple[NDArray[np.intp], NDArray[np.int64]]:
    """(n,) the step of the plan that each row is, and (n,) its round; what is no step is a problem of its row."""
    executed = _executed(plan)
    names = {_stem(source.path): number for number, source in reversed(list(enumerate(plan.sources)))}
    lines = defaultdict(list)
    for source, number in executed:
        lines[source].append(number)
    seen: Counter[tuple[int, int]] = Counter()
    step, rounds = np.zeros(len(table), dtype=np.intp), np.zeros(len(table), dtype=np.int64)
    for row in range(len(table)):
        job = _stem(jobs[row]) if jobs[row] else _stem(plan.sources[0].path)
        if job not in names:
            known = ", ".join(os.path.basename(source.path) for source in plan.sources)
            problems.cell("D055", f"the program does not run {jobs[row]}", row, "job", f"it runs {known}")
            continue
        if not np.isfinite(line[row]):
            continue
        key = (names[job], int(line[row]))
        if key not in executed:
            near = sorted(lines[names[job]], key=lambda number: abs(number - key[1]))[:3]
            help = f"lines near it that do: {', '.join(map(str, sorted(near)))}" if near else ""
            problems.cell("D055", f"line {key[1]} neither moves nor waits in this run", row, "line", help)
            continue
        turns = executed[key]
        step[row], rounds[row] = turns[seen[key] % len(turns)], seen[key] // len(turns) + 1
        seen[key] += 1
    odd = [key for key, count in seen.items() if count % len(executed[key])]
    if odd:
        listed = ", ".join(str(number) for _, number in sorted(odd)[:_LISTED]) + (
            " …" if len(odd) > _LISTED else ""
        )
        says = f"lines whose rows are no whole rounds of the program: {listed}"
        help = "a line that is executed k times has k rows for each round, in the order of the run"
        problems.found.append(warning("D056", says, file=table.file, help=help))
    return step, rounds


def _executed(plan: Plan) -> dict[tuple[int, int], list[int]]:
    """(source, line) -> its steps in the order of the run: its moves, where it has none its waits."""
    moves: dict[tuple[int, int], list[int]] = defaultdict(list)
    waits: dict[tuple[int, int], list[int]] = defaultdict(list)
    kinds = plan.kind.tolist()
    for step, key in enumerate(zip(plan.source.tolist(), plan.line.tolist(), strict=True)):
        if kinds[step] == StepKind.MOVE:
            moves[key].append(step)
        elif kinds[step] == StepKind.WAIT:
            waits[key].append(step)
    return {**waits, **moves}


def _recorded(timing: Timing, step: NDArray[np.intp]) -> RecordedMoves:
    plan = timing.plan
    waits = plan.kind[step] != StepKind.MOVE
    rows = np.where(waits, 0, plan.row[step]).astype(np.int32)
    robot, axes = plan.robot, plan.positions.axes
    slides = tuple(axis.linear for axis in robot.axes) if robot is not None else ()
    width = min(len(slides), axes.shape[1])
    joints = [axes[chosen[rows], :width] for chosen in (plan.moves.start, plan.moves.target)]
    return recorded_steps(timing, rows, step, waits, (joints[0], joints[1]), slides[:width])


def _stem(path: str) -> str:
    """How a table names a program: its file without folders and suffix, capitals and small letters alike."""
    return Path(path.replace("\\", "/")).stem.casefold()
