"""What the passes share: the question, the target's limits, and what was lost so far."""

from __future__ import annotations

import collections.abc
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING

from olp.core.diagnostic import Diagnostic, Span, error
from olp.core.fast_dataclass import fast_init
from olp.ir.expressions import Named, PositionLiteral
from olp.ir.program import Declare, Parameter, Program, Routine, Statement
from olp.ir.terminology import kind_of
from olp.languages.limits import Limits, limits_of
from olp.languages.vendor import Conventions, conventions_of
from olp.transpile.occurrences import Look, literals_in, names_of_data

if TYPE_CHECKING:
    from olp.robots.coordinate_systems import Cell
    from olp.robots.robot import Robot
    from olp.runtime.plan import Plan
    from olp.runtime.world import World
    from olp.transpile.abstract_walk import Walk
    from olp.transpile.symbols import Symbols


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

    @property
    def leaves_out(self) -> bool:
        """Whether nothing of the statement is left in the target but a comment."""
        return self.fate is not Fate.APPROXIMATED and self.part == "statement"


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
    `on_loss`: "error" or "comment". `flat`: the executed plan instead of the program.
    """

    robot: Robot | None = None
    target_robot: Robot | None = None
    mapping: Mapping = field(default_factory=Mapping)
    on_loss: str = "error"
    flat: bool = False


@dataclass(frozen=True, slots=True)
class Handed:
    """How a routine takes its arguments and gives its value where there are only variables of the whole program."""

    parameters: tuple[Parameter, ...]
    names: collections.abc.Mapping[str, str]  # of the variable that each parameter has become
    result: Named | None


@dataclass(frozen=True, slots=True)
class Elsewhere:
    """A tool or frame that a file declares which is not at hand. `first`: the statement that names it first.

    `wanted`: what the mapping file says that it is in the target, "" where it says nothing.
    """

    label: str
    first: Statement
    wanted: str


@dataclass(slots=True)
class TranslationContext:
    """One translation under way. `names`: (kind, name in the source, name in the target), for the receipt."""

    source: Program
    target: str
    limits: Limits
    context: Context
    losses: list[Loss] = field(default_factory=list)
    names: dict[tuple[str, str], str] = field(default_factory=dict)
    helpers: set[str] = field(default_factory=set)  # names of what only the translation needs
    registers: set[str] = field(default_factory=set)  # names that were numbered: others may set them
    systems: dict[tuple[str, int], PositionLiteral] = field(default_factory=dict)  # tools and frames set once
    elsewhere: dict[tuple[str, int], Elsewhere] = field(
        default_factory=dict
    )  # by the number that stands for it
    held: dict[tuple[str, str], PositionLiteral] = field(
        default_factory=dict
    )  # values that the target's controller is to hold, by kind and number or name there
    states: dict[str, str] = field(
        default_factory=dict
    )  # the kind of frame that a named position was written in
    handed: dict[str, Handed] = field(default_factory=dict)  # routines whose parameters have become variables
    problems: list[Diagnostic] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    remarks: list[Loss] = field(default_factory=list)  # on statements of which nothing is lost
    asks: dict[str, dict[str, None]] = field(
        default_factory=dict
    )  # what is to be done before it runs -> with what
    walk: Walk | None = None  # through the program as it is before its speeds are converted
    _cell: list[Cell] = field(default_factory=list)
    _plan: list[Plan | None] = field(default_factory=list)
    _made: set[str] = field(default_factory=set)
    _symbols: tuple[Program, Symbols] | None = None  # of the program as it was last seen
    _looks: dict[str, Look] = field(default_factory=dict)  # at each routine as it was last seen

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

    def note_at(self, statement: Statement, says: str) -> None:
        """Notes something about a statement of which nothing is lost."""
        self.remarks.append(Loss(statement.line, kind_of(statement), Fate.EXACT, "note", says))

    def ask(self, says: str, thing: str) -> None:
        """Notes what is to be done with something before the translation runs: set a tool, teach a position."""
        self.asks.setdefault(says, {})[thing] = None

    def lose(
        self,
        statement: Statement | int,
        fate: Fate,
        part: str,
        says: str,
        size: float = float("nan"),
        unit: str = "",
        help: str = "",
    ) -> None:
        """Notes a loss at a statement (or a line)."""
        line = statement if isinstance(statement, int) else statement.line
        kind = "program" if isinstance(statement, int) else kind_of(statement)
        self.losses.append(Loss(line, kind, fate, part, says, size, unit, help))

    def need_robot(self, s: Statement | None, why: str) -> None:
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

    def routine(self, name: str) -> Routine:
        """The source's routine called `name`."""
        return next(routine for routine in self.source.routines if routine.name == name)

    @property
    def conventions(self) -> Conventions:
        """What programs of the source's language mean."""
        return conventions_of(self.source.vendor)

    @property
    def target_conventions(self) -> Conventions:
        """What programs of the target's language mean."""
        return conventions_of(self.target)

    def look(self, routine: Routine) -> Look:
        """What occurs in a routine of the program as it is now."""
        known = self._looks.get(routine.name)
        if known is None or known.body is not routine.body:
            known = self._looks[routine.name] = Look(routine.body)
        return known

    def literals(self, program: Program) -> Iterator[PositionLiteral]:
        """Every position that is written out in the program as it is now."""
        data = (*program.data, *(d for routine in program.routines for d in routine.data))
        return literals_in(data, map(self.look, program.routines))

    def symbols(self, program: Program) -> Symbols:
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
        if not self._cell:
            self._cell.append(cell_of(self.source, self.robot))
        return self._cell[0]

    def helper(self, stem: str) -> str:
        """A name for something that the translation needs and the source does not have."""
        name = self.fresh(stem)
        self.helpers.add(name)
        return name

    def plan(self) -> Plan | None:
        """What the source program does, None where it cannot be run."""
        if not self._plan:
            self._plan.append(_run(self.source, self.robot))
        return self._plan[0]


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


def work_for(program: Program, target: str, context: Context) -> TranslationContext:
    """Raises OlpError (X010) for a language that cannot be written."""
    return TranslationContext(program, target, limits_of(target), context)


def _names_in(program: Program) -> set[str]:
    data = [*program.data, *(d for routine in program.routines for d in routine.data)]
    found: set[str] = {routine.name for routine in program.routines}
    for routine in program.routines:
        look = Look(routine.body)
        found |= look.names()
        data += [s for _, s in look.rare if isinstance(s, Declare)]
        found.update(p.name for p in routine.parameters)
    found.update(d.name for d in data)
    return found | names_of_data(data)


def _run(program: Program, robot: Robot | None) -> Plan | None:
    from olp.core.diagnostic import OlpError
    from olp.runtime.interpreter import run

    try:
        return run(program, robot=robot, max_steps=200_000)
    except OlpError:
        return None


def cell_of(program: Program, robot: Robot | None) -> Cell:
    """The robot with the tools and frames of olp.toml and the controller files beside a program."""
    return world_of(program, robot).cell


def world_of(program: Program, robot: Robot | None) -> World:
    """What stands around a program: olp.toml and the controller files beside it."""
    from pathlib import Path

    from olp.runtime.assumptions import Assumptions, load_assumptions, nearest_assumptions
    from olp.runtime.world import build_world

    folder = Path(program.path).parent if program.path and Path(program.path).is_file() else None
    path = nearest_assumptions(folder) if folder is not None else None
    assumptions = load_assumptions(path) if path is not None else Assumptions()
    world = build_world(robot, assumptions, folder)
    world.mechanism("RB1")
    return world
