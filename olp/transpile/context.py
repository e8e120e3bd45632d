"""What the passes share: the question, the mapping file, the target's limits, and what was lost so far.

A mapping file says what tools, frames, signals, variables and routines of the source are in the target. Code: X013 one
that cannot be read, or has a key that nothing uses.
"""

from __future__ import annotations

import collections.abc
import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from math import inf, nan
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from olp.core.diagnostic import Diagnostic, OlpError, Span, error
from olp.core.fast_dataclass import fast_init
from olp.core.toml import TOMLDecodeError, is_told_enough, parse_toml, toml_text
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.terminology import kind_of
from olp.ir.transformer import calls_nothing, expressions_of, is_usual
from olp.languages.limits import Limits
from olp.languages.vendor import Conventions, conventions_of
from olp.robots.geometry import Array, rotation_angle, rotation_from_angles
from olp.transpile.occurrences import Look, literals_in, names_of_data
from olp.transpile.symbols import Symbols

if TYPE_CHECKING:
    from olp.robots.coordinate_systems import Cell
    from olp.robots.model import Robot
    from olp.runtime.folder import World
    from olp.runtime.plan import Plan

Planned: TypeAlias = "Callable[[bool], Plan | None]"
PROCESS: Final = (
    "process"  # part of a loss: what a move does besides moving, without which the work is not done
)
BESIDE: Final = (
    "beside"  # part of a loss: where axes beside the arm go, in a language whose positions have none
)
SET_BACK: Final = (
    "set these back before each start, as they keep their values from run to run"  # to be asked for
)
LOST: Final = (
    "lost"  # the kind of a tool or frame whose choice is left out; its number is the line of that choice
)


class Fate(StrEnum):
    """What became of a statement, the worst last."""

    EXACT = "exact"
    APPROXIMATED = "approximated"
    COMMENTED = "commented"
    REFUSED = "refused"


@fast_init
@dataclass(frozen=True, slots=True)
class Loss:
    """Something that the target says in another way, or not at all.

    `line`: of the source, 0 for the program as a whole. `statement`: the kind of statement, `part` what of it.
    `size` in `unit` (mm, deg, mm/s, % …): how far the target's way is from the source's; nan where nobody can say.
    A statement with the fate EXACT takes no time and moves nothing: it is a comment, and nothing is lost.
    """

    line: int
    statement: str
    fate: Fate
    part: str
    says: str
    size: float = float("nan")
    unit: str = ""
    help: str = ""  # what would have worked, where that is more than a comment
    name: str = ""  # in `says`: losses that differ in it alone are told together

    @property
    def leaves_out(self) -> bool:
        """Whether nothing of the statement is left in the target but a comment."""
        return self.fate is not Fate.APPROXIMATED and self.part == "statement"


def partly_left_out(program: st.Program, losses: Sequence[Loss]) -> set[int]:
    """Lines that hold several statements, of which some are left out and others are not: losses tell their kinds."""
    lost = {(loss.line, loss.statement) for loss in losses}
    lines = {loss.line for loss in losses if loss.line}
    left: set[int] = set()
    kept: set[int] = set()
    for s in program.statements() if lines else ():
        if s.line in lines:
            (left if (s.line, kind_of(s)) in lost else kept).add(s.line)
    return left & kept


@dataclass(frozen=True, slots=True)
class Mapping:
    """What a mapping file says: names or numbers of the source, and what they are in the target.

    Keys are as written ("tGripper", "3"); signals as bus and number ("in 7"), each to the target's own.
    `set_values`: the program sets the values of the tools and frames that it numbers; else the controller holds them.
    """

    tools: collections.abc.Mapping[str, str] = field(default_factory=dict)
    frames: collections.abc.Mapping[str, str] = field(default_factory=dict)
    signals: collections.abc.Mapping[str, str] = field(default_factory=dict)
    variables: collections.abc.Mapping[str, str] = field(default_factory=dict)
    routines: collections.abc.Mapping[str, str] = field(default_factory=dict)
    set_values: bool = True


@dataclass(frozen=True, slots=True)
class Context:
    """The question: which robots stand where, what is mapped, and what becomes of what cannot be said.

    `robot`: that the program was written for; `target_robot`: that it is written for (None: the same one).
    `on_loss`: "error" or "comment". `flat`: the executed plan instead of the program. `forms`: moves as the pendant's
    editor writes them, where the language has such forms. `entry`: the controller starts this program, not another that
    calls it.
    """

    robot: Robot | None = None
    target_robot: Robot | None = None
    mapping: Mapping = field(default_factory=Mapping)
    on_loss: str = "error"
    flat: bool = False
    forms: bool = False
    entry: bool = False


@dataclass(frozen=True, slots=True)
class Handed:
    """How a routine takes its arguments and gives its value where there are only variables of the whole program."""

    parameters: tuple[st.Parameter, ...]
    names: collections.abc.Mapping[str, str]  # of the variable that each parameter has become
    result: ex.Named | None


@dataclass(frozen=True, slots=True)
class Elsewhere:
    """A tool or frame that a file declares which is not at hand. `first`: the statement that names it first.

    `wanted`: what the mapping file says that it is in the target, "" where it says nothing.
    """

    label: str
    first: st.Statement
    wanted: str


@dataclass(slots=True)
class TranslationContext:
    """One translation under way. `names`: (kind, name in the source, name in the target), for the receipt.

    `planned`: the source's plan, None where it cannot be run; True: with the inputs on that it decides by.
    """

    source: st.Program
    target: str
    limits: Limits
    context: Context
    planned: Planned
    losses: list[Loss] = field(default_factory=list)
    names: dict[tuple[str, str], str] = field(default_factory=dict)
    helpers: set[str] = field(default_factory=set)  # names of what only the translation needs
    undeclared: dict[str, str] = field(default_factory=dict)  # name that no file declares -> its type
    row_sizes: dict[str, int] = field(
        default_factory=dict
    )  # of undeclared arrays of several dimensions in one row
    missing: set[str] = field(
        default_factory=set
    )  # routines that no file has, and no controller of the source
    registers: set[str] = field(default_factory=set)  # names that were numbered: others may set them
    named_systems: dict[str, int] = field(
        default_factory=dict
    )  # variables of tools and frames -> their numbers
    external_units: tuple[tuple[str, str], ...] = ()  # of external axes, in order: name in the target, unit
    systems: dict[tuple[str, int], ex.PositionLiteral] = field(
        default_factory=dict
    )  # tools and frames set once
    elsewhere: dict[tuple[str, int], Elsewhere] = field(
        default_factory=dict
    )  # by the number that stands for it
    held: dict[tuple[str, str], ex.PositionLiteral] = field(
        default_factory=dict
    )  # values that the target's controller is to hold, by kind and number or name there
    states: dict[str, str] = field(
        default_factory=dict
    )  # the kind of frame that a named position was written in
    handed: dict[str, Handed] = field(default_factory=dict)  # routines whose parameters have become variables
    declared_at: dict[str, int] = field(
        default_factory=dict
    )  # locals, parameters and results that have become the program's -> the line that falls where they cannot be said
    problems: list[Diagnostic] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    remarks: list[Loss] = field(default_factory=list)  # on statements of which nothing is lost
    asks: dict[str, dict[str, None]] = field(
        default_factory=dict
    )  # what is to be done before it runs -> with what
    walk: Walk | None = None  # through the program as it is before its speeds are converted
    conventions: Conventions = field(init=False)  # what programs of the source's language mean
    target_conventions: Conventions = field(init=False)  # and those of the target's
    _world: list[World] = field(default_factory=list)
    _made: set[str] = field(default_factory=set)
    _symbols: tuple[st.Program, Symbols] | None = None  # of the program as it was last seen
    _looks: dict[str, Look] = field(default_factory=dict)  # at each routine as it was last seen

    def __post_init__(self) -> None:
        self.conventions = conventions_of(self.source.vendor)
        self.target_conventions = conventions_of(self.target)

    @property
    def robot(self) -> Robot | None:
        return self.context.robot

    @property
    def target_robot(self) -> Robot | None:
        return self.context.target_robot or self.context.robot

    @property
    def has_flags(self) -> bool:
        """Whether arm flags mean something: not to a robot whose wrist is none."""
        robot = self.context.robot
        return robot is None or robot.geometry is None or robot.geometry.links is not None

    def note_once(self, says: str) -> None:
        if says not in self.notes:
            self.notes.append(says)

    def note_at(self, statement: st.Statement, says: str) -> None:
        """Notes something about a statement of which nothing is lost."""
        self.remarks.append(Loss(statement.line, kind_of(statement), Fate.EXACT, "note", says))

    def ask(self, says: str, thing: str) -> None:
        """Notes what is to be done with something before the translation runs: set a tool, teach a position."""
        self.asks.setdefault(says, {})[thing] = None

    def lose(
        self,
        statement: st.Statement | int,
        fate: Fate,
        part: str,
        says: str,
        size: float = float("nan"),
        unit: str = "",
        help: str = "",
        name: str = "",
    ) -> None:
        """Notes a loss at a statement (or a line)."""
        line = statement if isinstance(statement, int) else statement.line
        kind = "program" if isinstance(statement, int) else kind_of(statement)
        self.losses.append(Loss(line, kind, fate, part, says, size, unit, help, name))

    def need_robot(self, s: st.Statement | None, why: str) -> None:
        """Notes that a statement (None: a point) cannot be translated without a robot that makes the moves.

        Once (X012), or as a comment.
        """
        if self.context.on_loss == "comment":
            if s is None:
                self.note_once(why)
            else:
                self.lose(s, Fate.REFUSED, "robot", f"{why}: say --robot" if self.robot is None else why)
            return
        if any(found.code == "X012" for found in self.problems):
            return
        line = 0 if s is None else s.line
        text = self.source.source.line(line) if line else ""
        span = Span(line, len(text) - len(text.lstrip()) + 1, len(text.rstrip()) + 1) if line else None
        self.problems.append(
            error("X012", why, span, file=self.source.path, source_line=text, help=_say_robot(self.robot))
        )

    def mapped_system(self, kind: str, *labels: str) -> str:
        """What the mapping file says that a tool or a frame ("user") is in the target, "" where it says nothing."""
        table = self.context.mapping.tools if kind == "tool" else self.context.mapping.frames
        exact = next((table[label] for label in labels if label in table), None)
        if exact is not None:
            return exact
        plain = {_plain(key): value for key, value in table.items()}
        return next((plain[_plain(label)] for label in labels if _plain(label) in plain), "")

    def routine(self, name: str) -> st.Routine:
        """The source's routine called `name`."""
        return next(routine for routine in self.source.routines if routine.name == name)

    def look(self, routine: st.Routine) -> Look:
        """What occurs in a routine of the program as it is now."""
        known = self._looks.get(routine.name)
        if known is None or known.body is not routine.body:
            known = self._looks[routine.name] = Look(routine.body)
        return known

    def rare(self, program: st.Program) -> Iterator[st.Statement]:
        """The statements of the program as it is now that are not plain."""
        for routine in program.routines:
            for _, s in self.look(routine).rare:
                yield s

    def literals(self, program: st.Program) -> Iterator[ex.PositionLiteral]:
        """Every position that is written out in the program as it is now."""
        data = (*program.data, *(d for routine in program.routines for d in routine.data))
        return literals_in(data, map(self.look, program.routines))

    def symbols(self, program: st.Program) -> Symbols:
        """The names of the program as it is now, for passes that only look them up."""
        from olp.transpile.symbols import symbols_of

        if self._symbols is None or self._symbols[0] is not program:
            self._symbols = program, symbols_of(program)
        return self._symbols[1]

    def fresh(self, stem: str, taken: Iterable[str] = ()) -> str:
        """A name that neither the program nor the translation uses yet."""
        if not self._made:
            self._made.update(name.lower() for name in _names_in(self.source))
        known = {name.lower() for name in taken} if taken else ()
        count, name, low = 1, stem, stem.lower()
        if low not in self._made and low not in known:
            self._made.add(low)
            return name
        while name.lower() in self._made or name.lower() in known:
            count += 1
            name = f"{stem}{count}"
        self._made.add(name.lower())
        return name

    def cell(self) -> Cell:
        """The robot with the tools and frames of the controller files beside the program."""
        return self.world().cell

    def world(self) -> World:
        """What stands around the program."""
        if not self._world:
            self._world.append(world_of(self.source, self.robot))
        return self._world[0]

    def helper(self, stem: str) -> str:
        """A name for something that the translation needs and the source does not have."""
        name = self.fresh(stem)
        self.helpers.add(name)
        return name

    def plan(self) -> Plan | None:
        """What the source program does, None where it cannot be run."""
        return self.planned(False)

    def plan_with_inputs(self) -> Plan | None:
        """What it does with the inputs on that it decides by, None where it asks for none."""
        return self.planned(True)


def _say_robot(robot: Robot | None) -> str:
    from olp.robots.robot import robot_names

    if robot is not None:
        reach = f"{robot.name} does not reach every point of the program, or some are not known"
        return f"{reach}: olp time with this robot says which"
    names = robot_names()
    library = f"`olp robots` lists {len(names)}, such as {names[0]}, and docs/robots.md says how to describe another"
    return (
        f"name the arm with --robot (and --target-robot where it is another one): {library}; "
        "--on-loss comment writes such statements as comments"
    )


def _plain(label: str) -> str:
    """Whatever the case, the blanks and the brackets."""
    return label.casefold().replace(" ", "").replace("{", "[").replace("}", "]")


def _names_in(program: st.Program) -> set[str]:
    data = [*program.data, *(d for routine in program.routines for d in routine.data)]
    found: set[str] = {routine.name for routine in program.routines}
    for routine in program.routines:
        look = Look(routine.body)
        found |= look.names()
        data += [s for _, s in look.rare if isinstance(s, st.Declare)]
        found.update(p.name for p in routine.parameters)
    found.update(d.name for d in data)
    return found | names_of_data(data)


def cell_of(program: st.Program, robot: Robot | None) -> Cell:
    """The robot with the tools and frames of olp.toml and the controller files beside a program."""
    return world_of(program, robot).cell


def world_of(program: st.Program, robot: Robot | None) -> World:
    """What stands around a program: olp.toml and the controller files beside it."""
    from pathlib import Path

    from olp.runtime.assumptions import Assumptions, load_assumptions, nearest_assumptions
    from olp.runtime.folder import build_world

    folder = Path(program.path).parent if program.path and Path(program.path).is_file() else None
    path = nearest_assumptions(folder) if folder is not None else None
    assumptions = load_assumptions(path) if path is not None else Assumptions()
    world = build_world(robot, assumptions, folder)
    world.mechanism("RB1")
    return world


# --- Abstract walk ---
# Lengths and turns of moves that the text alone shows: from one written pose straight to the next.

# What runs between two moves without leading elsewhere; nothing jumps there either.
BETWEEN: Final = frozenset(
    {"Comment", "SetOutput", "PulseOutput", "Dwell", "Wait", "Message", "Declare", "Begin"}
)
SETTING: Final = frozenset({"Assign", "Update", "DefineFrame"})
_PLAIN: Final = (ex.Number, ex.Text, ex.SignalState)
_HOLDERS: Final = frozenset({ex.Named, ex.Variable})  # no component of a tool or of a frame
_NOTHING: Final = 1e-9  # [m]
Segment = tuple[float, float]  # [m] and [rad]


@dataclass(slots=True)
class Walk:
    """Pairs of moves that run one after the other, with the rows of their poses; the program's first and last move."""

    program: st.Program  # which keeps the moves' ids
    pairs: list[tuple[st.Move, st.Move, int, int]] = field(default_factory=list)
    poses: list[tuple[float, ...]] = field(default_factory=list)
    first: list[st.Move] = field(default_factory=list)
    last: list[st.Move] = field(default_factory=list)
    _segments: dict[int, Segment] | None = None
    _rooms: dict[int, float] | None = None

    def segments(self) -> dict[int, Segment]:
        """By the id of a move of `program`: its length and its turn, for all whose start and end the text shows.

        The program's first move starts where it ends, as the interpreter takes it, unless something calls its routine.
        """
        if self._segments is None:
            found: dict[int, Segment] = {id(s): (0.0, 0.0) for s in self.first}
            self._segments = found
            if self.pairs:
                _, moves, start, end = zip(*self.pairs, strict=True)
                lengths, turns = _between(np.array(self.poses), list(start), list(end))
                for s, length, turn in zip(moves, lengths, turns, strict=True):
                    if length == length and turn == turn:  # all components are written
                        found[id(s)] = (length, turn)
        return self._segments

    def rooms(self) -> dict[int, float]:
        """By the line of moves: half of the shortest way to or from their points [m], where the text shows all ways.

        A way that goes nowhere bounds nothing, and neither does one that is not there: before the first and behind the
        last move of the program.
        """
        if self._rooms is None:
            ways = {
                s: 0.5 * length if length > _NOTHING else inf for s, (length, _) in self.segments().items()
            }
            behind = {id(before): ways.get(id(s), nan) for before, s, _, _ in self.pairs}
            behind |= dict.fromkeys(map(id, self.last), inf)
            found: dict[int, float] = {}
            self._rooms = found
            for move in self.program.statements():
                if type(move) is st.Move:
                    room = _least(ways.get(id(move), nan), behind.get(id(move), nan))
                    found[move.line] = _least(room, found.get(move.line, inf))
            for line in [line for line, room in found.items() if room != room]:
                del found[line]
        return self._rooms


def _least(one: float, other: float) -> float:
    """The smaller one, nan where one of them is."""
    return min(one, other) if one == one and other == other else nan


def walk_through(program: st.Program, work: TranslationContext) -> Walk:
    """The walk through a program, which passes that ask about the same one share."""
    if work.walk is None or work.walk.program is not program:
        work.walk = _walked(program, work.symbols(program))
    return work.walk


def _walked(program: st.Program, symbols: Symbols) -> Walk:
    main = program.main or (program.routines[0].name if program.routines else "")
    counts = Counter(
        s.routine.casefold() for s in program.statements() if isinstance(s, (st.Call, st.StartTask))
    )
    once = {r.name.casefold(): r for r in program.routines if counts[r.name.casefold()] == 1}
    others = [s for s in program.statements() if not calls_nothing(s)] if once else []
    values = {e.routine.casefold() for s in others for e in expressions_of(s) if type(e) is ex.CallValue}
    inner = {name: r for name, r in once.items() if name not in values and _runs_through(r)}
    walker = _Walker(Walk(program), symbols, inner)
    for routine in sorted(program.routines, key=lambda one: one.name != main):
        if routine.name not in walker.done:
            walker.begin(routine.name == main and not counts[main.casefold()])
            walker.through(routine)
            walker.end()
    return walker.walk


def _runs_through(routine: st.Routine) -> bool:
    """Whether a routine runs from its first to its last statement."""
    kinds = {type(s) for s in routine.body[:-1]} | {
        type(s) for s in routine.body[-1:] if type(s) is not st.End
    }
    return all(
        kind in (st.Move, st.Call) or kind.__name__ in BETWEEN or kind.__name__ in SETTING for kind in kinds
    )


@dataclass(slots=True)
class _Walker:
    """Follows a program as far as the text shows where it runs; `inner`: routines that one call leads into and out of.

    `before`: the last move, whose pose is the last one, None where that is not known; `first`: no move came before;
    `whole`: nothing branched so far; `latest`: the last move.
    """

    walk: Walk
    symbols: Symbols
    inner: dict[str, st.Routine]
    done: set[str] = field(default_factory=set)
    before: st.Move | None = None
    latest: st.Move | None = None
    first: bool = False
    whole: bool = False

    def begin(self, main: bool) -> None:
        self.whole = self.first = main
        self.before = self.latest = None

    def end(self) -> None:
        if self.whole and self.latest is not None:
            self.walk.last.append(self.latest)

    def through(self, routine: st.Routine) -> None:
        self.done.add(routine.name)
        for s in routine.body:
            if type(s) is st.Move:
                self._move(s, routine.name)
            elif type(s).__name__ not in BETWEEN and not (type(s) is st.End and s is routine.body[-1]):
                self._other(s)

    def _other(self, s: st.Statement) -> None:
        if type(s).__name__ in SETTING and not any(type(e) is ex.CallValue for e in expressions_of(s)):
            self.before = self.before if _keeps_systems(s) else None
            return
        called = self.inner.get(s.routine.casefold()) if type(s) is st.Call else None
        if (
            type(s) is st.Call
            and called is not None
            and called.name not in self.done
            and not (s.jump or s.condition is not None)
            and not any(type(e) is ex.CallValue for e in expressions_of(s))
        ):
            self.through(called)
            return
        self.before, self.first, self.whole = None, False, False

    def _move(self, s: st.Move, routine: str) -> None:
        walk, before = self.walk, self.before
        pose = _pose(s, routine, self.symbols)
        if pose is not None and before is not None and _same_place(before, s):
            walk.pairs.append((before, s, len(walk.poses) - 1, len(walk.poses)))
        elif self.first:
            walk.first.append(s)
        if pose is not None:
            walk.poses.append(pose)
        self.before, self.latest, self.first = (None if pose is None else s), s, False


def _between(poses: Array, start: list[int], end: list[int]) -> tuple[list[float], list[float]]:
    """Lengths [m] and turns [rad] from rows of `poses` (n, 6) to others, nan where a component is."""
    places, turned = poses[:, :3], rotation_from_angles(poses[:, 3:])
    lengths = np.linalg.norm(places[end] - places[start], axis=1)
    return lengths.tolist(), rotation_angle(turned[start], turned[end]).tolist()


def _keeps_systems(s: st.Statement) -> bool:
    """Whether an assignment changes no tool and no frame: it sets a number, a text or a state."""
    if not isinstance(s, (st.Assign, st.Update)) or type(s.target) not in _HOLDERS:
        return False
    return isinstance(s.value if isinstance(s, st.Assign) else s.operand, _PLAIN)


def _pose(s: st.Move, routine: str, symbols: Symbols) -> tuple[float, ...] | None:
    if s.via is not None or s.path is st.Path.CIRCULAR or len(s.targets) != 1 or not _is_whole(s):
        return None
    target = s.targets[0]
    if type(target) is ex.Function and target.name == "pose-product" and _outer(s) is not None:
        target = target.arguments[1]  # seen from the frame that both ends stand in
    value = symbols.fixed_value(routine, target)
    if type(value) is not ex.PositionLiteral or value.kind != "pose":
        return None
    values = value.values[:6]
    return values if len(values) == 6 else None


def _is_whole(s: st.Move) -> bool:
    """Whether the move ends where its target is."""
    if is_usual(s):
        return True
    return not s.parts and all(
        e is None for e in (s.relative, s.search, s.until, s.offset, s.tool_offset, s.via, s.arc)
    )


def _same_place(one: st.Move, other: st.Move) -> bool:
    tools = one.tool is other.tool or one.tool == other.tool
    frames = one.frame is other.frame or one.frame == other.frame
    return tools and frames and _outer(one) == _outer(other)


def _outer(s: st.Move) -> ex.Named | None:
    """The named frame that a target is multiplied with."""
    target = s.targets[0]
    first = target.arguments[0] if type(target) is ex.Function and target.name == "pose-product" else None
    return first if type(first) is ex.Named else None


@dataclass(frozen=True, slots=True)
class Translated:
    """`mapping`: (kind, name in the source) -> name in the target.

    Kinds: point, variable, tool, frame, routine, signal, task, label. `problems`: what no comment can stand for (X012).
    `remarks`: on statements of which nothing is lost. `asks`: what is to be done before it runs, with what.
    `held`: values of tools ("tool") and frames ("user") that the target's controller is to hold, by number or name.
    `types`: of the source's names that no file declares, as `Declare.type` says it.
    """

    program: st.Program
    losses: tuple[Loss, ...]
    mapping: dict[tuple[str, str], str]
    notes: tuple[str, ...] = ()
    problems: tuple[Diagnostic, ...] = ()
    remarks: tuple[Loss, ...] = ()
    asks: collections.abc.Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    held: collections.abc.Mapping[tuple[str, str], ex.PositionLiteral] = field(default_factory=dict)
    types: collections.abc.Mapping[str, str] = field(default_factory=dict)


_TABLES = ("tools", "frames", "signals", "variables", "routines")
_KEYS = (*_TABLES, "set_values")


def read_mapping(path: str | os.PathLike[str]) -> Mapping:
    """The mapping in a TOML file. Raises OlpError (X013) with all that is wrong with it."""
    try:
        document = parse_toml(toml_text(path))
    except (OSError, UnicodeDecodeError, TOMLDecodeError) as problem:
        raise OlpError(
            error("X013", f"the mapping cannot be read: {problem}", file=os.fspath(path))
        ) from None
    problems: list[Diagnostic] = []
    for key in document:
        if key not in _KEYS and not is_told_enough(problems, "X013", os.fspath(path)):
            help = f"it takes {', '.join(_KEYS)}"
            problems.append(error("X013", f"nothing uses '{key}'", file=os.fspath(path), help=help))
    tables = {name: _table(document.get(name, {}), name, path, problems) for name in _TABLES}
    set_values = document.get("set_values", True)
    if not isinstance(set_values, bool):
        problems.append(error("X013", "set_values is true or false", file=os.fspath(path)))
    if problems:
        raise OlpError(*problems)
    return Mapping(**tables, set_values=set_values)


def _table(
    found: object, name: str, path: str | os.PathLike[str], problems: list[Diagnostic]
) -> dict[str, str]:
    if not isinstance(found, dict):
        problems.append(error("X013", f"[{name}] is a table of names", file=os.fspath(path)))
        return {}
    result: dict[str, str] = {}
    for key, value in found.items():
        if isinstance(value, bool) or not isinstance(value, (str, int)):
            problems.append(error("X013", f"[{name}] {key} is a name or a number", file=os.fspath(path)))
        else:
            result[key] = str(value)
    return result
