"""What is to be done before a translation runs on a controller, as one short list."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Set
from pathlib import Path
from typing import Final

import numpy as np

from olp.ir.expressions import (
    Expression,
    FrameRef,
    Function,
    Named,
    Number,
    PositionLiteral,
    Signal,
    Taught,
    Text,
    Variable,
)
from olp.ir.points import PointKind
from olp.ir.program import Assign, DefineFrame, Move, Program, Routine, SetFrame, SetTool, StartTask, Wait
from olp.ir.program import Path as MovePath
from olp.ir.transformer import changed_by, expressions_of, note_names
from olp.languages.limits import limits_of
from olp.languages.vendor import conventions_of, find_vendor
from olp.runtime.plan import Plan, lines_of
from olp.transpile.context import Fate, Translated
from olp.transpile.link import Linked
from olp.transpile.shared_variables import called_in

_SYSTEMS: Final = {"tool": "tool", "user": "frame"}
_MOST = 12  # of a kind that are named
_MOST_FILES = 3  # that a line names
_COMPUTED: Final = "(computed)"  # the number of a signal

System = tuple[str, int]  # "tool" or "user", its number


def before_it_runs(
    linked: Linked,
    translated: Translated,
    target: str,
    plan: Plan | None,
    compared: bool,
    arm_named: bool = False,
) -> tuple[str, ...]:
    """Short sentences, the most dangerous first. `plan`: the translation's.

    `arm_named`: axis values were made for the arm that runs the translation.

    `compared`: both programs could be run, or hold nothing that runs.
    """
    found = [
        *_commented(linked, translated),
        *(() if plan is None else _beyond(plan)),
        *(f"{says}: {some(things)}" for says, things in translated.asks.items()),
        *(() if arm_named else _axes(linked, translated.program)),
        *_borrowed(linked),
        *_set_by_others(linked, target),
        *_tool_zero(linked.program, target),
        *_systems(translated),
        *_wait_setting(translated, target),
        *_handed_over(translated.program, target),
        *_routines(translated.program),
        *_signals(translated, target),
        *_arm(linked, translated),
    ]
    if not compared:
        found.append("step through it slowly: it could not be run to its end and compared here")
    return tuple(dict.fromkeys(found))


def _lines(linked: Linked, lines: Iterable[int]) -> str:
    """`a.src:3, 5-7; b.src:2`, files without their folders."""
    return places((Path(file).name, line) for file, line in map(linked.place, sorted(lines)))


def places(where: Iterable[tuple[str, int]]) -> str:
    """`a.src:3, 5-7; b.src:2`, of many files the first ones. Line 0 is the file as a whole."""
    files: dict[str, set[int]] = {}
    for file, line in where:
        files.setdefault(file, set()).add(line)
    found = [
        f"{file}:{_ranges(sorted(lines - {0}))}" if lines - {0} else file for file, lines in files.items()
    ]
    more = len(found) - _MOST_FILES
    return "; ".join(found[:_MOST_FILES]) + (f" and {more} more file{'s' * (more > 1)}" if more > 0 else "")


def _ranges(lines: list[int]) -> str:
    runs: list[list[int]] = []
    for line in lines:
        if runs and line == runs[-1][1] + 1:
            runs[-1][1] = line
        else:
            runs.append([line, line])
    return some(str(a) if a == b else f"{a}-{b}" for a, b in runs)


def some(names: Iterable[str]) -> str:
    """The first of them, and how many more there are."""
    known = list(names)
    more = len(known) - _MOST
    return ", ".join(known[:_MOST]) + (f" and {more} more" if more > 0 else "")


def _commented(linked: Linked, translated: Translated) -> Iterator[str]:
    lines = {x.line for x in translated.losses if x.leaves_out and x.fate is not Fate.EXACT}
    if lines:
        yield f"rewrite what is only a comment now: {_lines(linked, lines)}"


def _axes(linked: Linked, program: Program) -> Iterator[str]:
    """Moves to axis values, which another maker's arm counts from another pose and in other directions."""
    declared = (*program.data, *(d for r in program.routines for d in r.data))
    held = {d.name for d in declared if d.type == "joints"}
    lines = {
        s.line
        for r in program.routines
        for s in r.body
        if type(s) is Move and any(_is_joints(t, held, r) for t in s.targets)
    }
    if lines - {0}:
        says = "see that the arm counts its axes as the source's does, or say both with --robot and --target-robot"
        yield f"{says}: {_lines(linked, lines - {0})}"


def _is_joints(target: Expression, held: set[str], routine: Routine) -> bool:
    if isinstance(target, PositionLiteral):
        return target.kind == "joint"
    if isinstance(target, Taught):
        point = routine.points.find(target.store, True, target.number)
        return point is not None and point.state.kind is not PointKind.POSE
    return isinstance(target, Named) and target.name in held


def _borrowed(linked: Linked) -> Iterator[str]:
    """Routines that the source's controller does not find where they are called."""
    if linked.borrowed:
        named = some(f"{name} ({Path(path).name})" for name, path in linked.borrowed)
        yield f"see that these routines are meant, as their files share them with no other: {named}"


def _beyond(plan: Plan) -> Iterator[str]:
    """Moves that the arm of the translation cannot make: poses out of reach, and joints beyond the limits."""
    from olp.robots.kinematics.configuration import within_limits

    for index, robot in enumerate(plan.robots):
        if robot is None:
            continue
        rows = np.flatnonzero(plan.moves.mechanism == index)
        target = plan.moves.target[rows]
        axes = plan.positions.axes[target, : len(robot.axes)]
        unknown = np.isnan(axes).any(axis=1)
        away = unknown & ~np.isnan(plan.positions.position[target, 0]) & (robot.geometry is not None)
        outside = ~unknown & ~within_limits(robot, axes).all(axis=1)
        for lost, says in ((away, "does not reach"), (outside, "does not have the joint range for")):
            lines = lines_of(plan, rows[lost])
            where = places(
                (Path(plan.sources[i].path).name, line) for i, found in lines.items() for line in found
            )
            if where:
                yield f"move the base, the frames or the points, as {robot.name} {says} these targets: {where}"


def _tool_zero(program: Program, target: str) -> Iterator[str]:
    """Where the source's tool 0 may be another than the flange, which it is in the translation."""
    if program.vendor == target or not conventions_of(program.vendor).sets_tool_zero:
        return
    for r in program.routines:
        for s in r.body:
            place = s.targets[0] if isinstance(s, Move) else None
            number = place.number if isinstance(place, Taught) else _written(place)
            if number is None or not isinstance(place, (Taught, Variable)) or not isinstance(s, Move):
                continue
            point = r.points.find(place.store, isinstance(place, Taught), number)
            if point is None or point.state.tool != 0:
                continue
            if point.state.kind is PointKind.POSE or s.path is not MovePath.JOINT:
                yield "see that tool 0 of the source's controller is all zeros: the flange is written in its place"
                return


def _written(e: Expression | None) -> int | None:
    """The number of a variable that is written out."""
    return int(e.index.value) if isinstance(e, Variable) and isinstance(e.index, Number) else None


_MOST_READ: Final = 4_000_000  # bytes of programs beside one


def _set_by_others(linked: Linked, target: str) -> Iterator[str]:
    """Data that the program reads and never sets, and that programs beside it, which are no part of it, do set.

    Other languages share no data between files: the translation has the values that these were saved with.
    """
    program = linked.program
    path = Path(program.path) if program.path else None
    if program.vendor == target or path is None or not path.is_file():
        return
    vendor = find_vendor(program.vendor)
    used: set[str] = set()
    changed: set[str] = set()
    for s in program.statements():
        note_names(s, used)
        changed.update(name.casefold() for name in changed_by(s))
    shared = (d for d in program.data if d.shared and d.storage != "constant" and d.name in used)
    names = {d.name.casefold(): d.name for d in shared if d.name.casefold() not in changed}
    if not (vendor.shares_names and names):
        return
    words = "|".join(map(re.escape, sorted(names, key=len, reverse=True)))
    # A name at the begin of a line, its elements and members, and what it is set to.
    sets = re.compile(
        rf"^[ \t]*({words})(?![\w$])(?:\[[^\]\n]*\]|\{{[^}}\n]*\}}|\.\w+)*+[ \t]*(?::=|=(?!=))",
        re.IGNORECASE | re.MULTILINE,
    )
    found: dict[str, str] = {}
    unread: list[str] = []
    for file, text in _beside(path, vendor.suffixes, {Path(part.path).name for part in linked.parts}):
        if text is None:
            unread.append(file)
        for name in sets.findall(text or ""):
            found.setdefault(names[name.casefold()], file)
    if found:
        things = some(f"{name} ({file})" for name, file in sorted(found.items()))
        yield f"set these as other programs of the folder do, which are no part of this translation: {things}"
    if unread:
        yield f"see whether these set data of this program, too: they are too large, or may not be read: {some(unread)}"


def _beside(path: Path, suffixes: Collection[str], parts: Set[str]) -> Iterator[tuple[str, str | None]]:
    """The programs in the folder of `path` that are none of its `parts`: name and text, None of what is not read."""
    left = _MOST_READ
    try:
        others = sorted(path.parent.iterdir())
    except OSError:  # a folder may be entered and not listed
        yield f"all of {path.parent.name}", None
        return
    for other in others:
        if other.suffix.lower() not in suffixes or other.name in parts or not other.is_file():
            continue
        try:
            left -= other.stat().st_size
            yield other.name, other.read_bytes().decode("latin-1") if left >= 0 else None
        except OSError:
            yield other.name, None


def _systems(translated: Translated) -> Iterator[str]:
    """Tools and frames by number: those that the program sets, and those that the controller must hold."""
    used: set[System] = set()
    written: set[System] = set()
    for routine in translated.program.routines:  # INFORM names them with its points
        for state in routine.points.states:
            used |= {("tool", state.tool)} if state.tool > 0 else set()
            used |= (
                {("user", state.user)} if state.frame == "user" and state.user and state.user > 0 else set()
            )
    for s in translated.program.statements():
        if isinstance(s, Move):
            used |= _numbered(s.tool) | _numbered(s.frame)
        elif isinstance(s, (SetTool, SetFrame)):
            used |= _numbered(s.tool if isinstance(s, SetTool) else s.frame)
        elif isinstance(s, DefineFrame):
            written |= _numbered(s.frame)
        elif isinstance(s, Assign):
            written |= _numbered(_tool_data(s.target))
    if missing := _listed(used - written):
        yield f"set {missing} on the controller: the program does not"
    if here := _listed(written):
        yield f"see that no other program needs other values of {here}: this one sets them"
    named = any(isinstance(s, Move) and isinstance(s.tool, Named) for s in translated.program.statements())
    if named or any(kind == "tool" for kind, _ in (*used, *written, *translated.mapping)):
        yield "enter the loads of the tools (mass, centre of gravity): they are not translated"


def _wait_setting(translated: Translated, target: str) -> Iterator[str]:
    setting = limits_of(target).wait_setting
    waits = (s for s in translated.program.statements() if isinstance(s, Wait) and s.timeout is not None)
    if setting and translated.program.vendor != target and any(waits):
        yield f"see that no other program needs another {setting}: this one sets it"


def _handed_over(program: Program, target: str) -> Iterator[str]:
    """What the first routine takes, where a controller's programs do not call one another: nothing gives it."""
    if program.vendor == target or limits_of(target).shares_programs:
        return
    for first in [r for r in program.routines if r.name == program.main] or program.routines[:1]:
        if names := [p.name for p in first.parameters if p.default is None]:
            yield f"call {first.name} with values for what it takes, which nothing here does: {some(names)}"


def _tool_data(e: Expression) -> Expression:
    """The tool whose values SETTOOL sets."""
    if isinstance(e, Function) and e.name == "tool-data" and e.arguments:
        return FrameRef("tool", e.arguments[0])
    return e


def _numbered(e: object) -> set[System]:
    """Number 0 is the flange or the base."""
    if isinstance(e, FrameRef) and e.kind in _SYSTEMS and isinstance(e.number, Number) and e.number.value:
        return {(e.kind, int(e.number.value))}
    return set()


def _listed(systems: set[System]) -> str:
    groups = []
    for kind, word in _SYSTEMS.items():
        numbers = sorted(number for own, number in systems if own == kind)
        if numbers:
            groups.append(f"{word}{'s' * (len(numbers) > 1)} {_ranges(numbers)}")
    return " and ".join(groups)


def _routines(program: Program) -> Iterator[str]:
    known = {routine.name.casefold() for routine in program.routines}
    called = (
        name
        for s in program.statements()
        for name in ([s.routine] if isinstance(s, StartTask) else called_in(s))
        if name
    )
    missing = dict.fromkeys(name for name in called if name.casefold() not in known)
    if missing:
        yield f"load what it calls and this translation does not hold: {some(missing)}"


def _signals(translated: Translated, target: str) -> Iterator[str]:
    renamed = {name: to for (kind, name), to in translated.mapping.items() if kind == "signal" and name != to}
    asked = {thing for things in translated.asks.values() for thing in things}
    if told := [row for name, to in renamed.items() if (row := f"{name} is {to}") not in asked]:
        does = (
            "configure the signals"
            if conventions_of(target).controller_names
            else "connect the signals as they are called now"
        )
        yield f"{does}: {some(told)}"
    new = {to if " " in to else f"{name.split(' ')[0]} {to}" for name, to in renamed.items()}
    kept: dict[str, None] = {}
    for s in translated.program.statements():
        if not isinstance(s, Move) or s.has_signals:
            kept |= {_signal(e): None for e in expressions_of(s) if isinstance(e, Signal)}
    if conventions_of(target).controller_names:
        made = {*renamed.values(), _COMPUTED}
        kept = {name: None for name in kept if name.partition(" ")[2] not in made}
    if same := [name for name in kept if name not in new]:
        yield f"see that these signals are wired as in the source, or map them under [signals]: {some(same)}"


def _signal(e: Signal) -> str:
    if isinstance(e.index, Number):
        return f"{e.bus} {int(e.index.value)}"
    return f"{e.bus} {e.index.value if isinstance(e.index, Text) else _COMPUTED}"


def _arm(linked: Linked, translated: Translated) -> Iterator[str]:
    lines = {x.line for x in translated.losses if x.part == "configuration"}
    if lines:
        yield f"step through the joint moves whose arm configuration may be another: {_lines(linked, lines)}"
