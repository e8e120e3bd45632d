"""Programs in the files that the target takes: one routine each, and no more statements or points than it holds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from olp.ir.expressions import Store, Taught
from olp.ir.points import PointBlock, PointTable
from olp.ir.program import Begin, Call, End, Move, Program, Routine, Statement
from olp.ir.transformer import expressions_of
from olp.languages.limits import Limits

_STRAIGHT = frozenset(
    {"Move", "SetOutput", "PulseOutput", "Dwell", "Wait", "Comment", "Assign", "Update", "Message", "Call"}
)


def split(program: Program, limits: Limits) -> Iterator[Program]:
    """The programs of the single files, the one that runs first."""
    if not limits.one_routine_per_file:
        yield program
        return
    main = program.main or (program.routines[0].name if program.routines else "")
    ordered = sorted(program.routines, key=lambda routine: routine.name != main)
    taken = {routine.name for routine in program.routines}
    for routine in ordered:
        for part in _parts(routine, limits, taken):
            yield replace(program, routines=(part,), main=part.name)


def _parts(routine: Routine, limits: Limits, taken: set[str]) -> Iterator[Routine]:
    """A straight routine that is too long as several, called in order; others stay whole."""
    points = sum(len(block) for key, block in routine.points.blocks.items() if key[1])
    room = min(limits.statements or len(routine.body), limits.points or len(routine.body))
    fits = len(routine.body) <= room and (not limits.points or points <= limits.points)
    if fits or any(
        type(s).__name__ not in _STRAIGHT for s in routine.body if not isinstance(s, (Begin, End))
    ):
        yield routine
        return
    rows: list[Statement] = [s for s in routine.body if not isinstance(s, (Begin, End))]
    pieces = list(_pieces(rows, room - 2))
    names = []
    for number in range(1, len(pieces) + 1):
        names.append(_name(routine.name, number, limits, taken))
    calls: list[Statement] = [Call(0, name) for name in names]
    yield replace(routine, body=(Begin(0), *calls, End(0)), points=_only(routine.points, set()))
    for name, piece in zip(names, pieces, strict=True):
        used = {e.number for s in piece for e in expressions_of(s) if type(e) is Taught}
        held = replace(routine.points, blocks={k: b for k, b in routine.points.blocks.items() if k[1]})
        yield replace(routine, name=name, body=(Begin(0), *piece, End(0)), points=_only(held, used))


def _pieces(rows: list[Statement], room: int) -> Iterator[list[Statement]]:
    """Runs of statements; an arc stays in one of them."""
    start = 0
    while start < len(rows):
        stop = min(start + room, len(rows))
        while stop < len(rows) and stop > start + 1 and _within_arc(rows, stop):
            stop -= 1
        yield rows[start:stop]
        start = stop


def _within_arc(rows: list[Statement], at: int) -> bool:
    s = rows[at]
    return isinstance(s, Move) and s.path.value == "circular" and s.via is None


def _name(stem: str, number: int, limits: Limits, taken: set[str]) -> str:
    tail = f"_{number}"
    room = limits.routine_name
    while True:
        name = (stem[: room - len(tail)] if room else stem) + tail
        if name not in taken:
            taken.add(name)
            return name
        tail += "A"


def _only(table: PointTable, numbers: set[int]) -> PointTable:
    """The taught points of these numbers, and all others."""
    blocks: dict[tuple[Store, bool], PointBlock] = {}
    for key, block in table.blocks.items():
        if not key[1]:
            blocks[key] = block
            continue
        rows = [row for row, number in enumerate(block.numbers.tolist()) if number in numbers]
        if rows:
            kept = {int(block.numbers[row]): at for at, row in enumerate(rows)}
            blocks[key] = PointBlock(
                block.store,
                block.taught,
                block.numbers[rows],
                block.values[rows],
                block.state[rows],
                block.lines[rows],
                kept,
            )
    return replace(table, blocks=blocks)
