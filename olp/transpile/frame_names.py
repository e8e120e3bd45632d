"""Which number or name each tool and frame has in the target: as mapped, as in the source, or a free one.

Languages number them, name them, or do both; some have one tool and the base alone (`Limits`).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from olp.ir.expressions import Expression, FrameRef, Item, Named, Number, PositionLiteral
from olp.ir.program import Assign, Declare, DefineFrame, Move, Program, Statement
from olp.languages.vendor import language_of
from olp.robots.geometry import Pose
from olp.transpile.constant_frames import system_of
from olp.transpile.context import Elsewhere, Fate, TranslationContext
from olp.transpile.first_values import UNDECLARED
from olp.transpile.records import literal_of
from olp.transpile.symbols import Symbols

BASE: Final = FrameRef("base")
_ZEROS: Final = "set these values, which are zeros now"
_SET_HERE: Final = "see that nothing moves with these before the program sets them: they begin with zeros"
_DEPENDS: Final = "it depends on {}, which is not declared here"
_NOTHING: Final = literal_of(Pose.identity())
_UNKNOWN: Final = {"tool": FrameRef("tool", Number(0)), "user": BASE}  # in the place of what is refused


@dataclass(slots=True)
class SystemNames:
    """Tools ("tool") and frames ("user"). `numbers`: of a name or value; `values`: to be set, by kind and number."""

    work: TranslationContext
    symbols: Symbols
    routine: str = ""
    numbers: dict[tuple[str, Expression], int] = field(default_factory=dict)
    taken: dict[str, set[int]] = field(default_factory=lambda: {"tool": {0}, "user": {0}})
    values: dict[tuple[str, int], PositionLiteral] = field(default_factory=dict)
    made: dict[tuple[str, Expression], Named] = field(default_factory=dict)
    declared: list[Declare] = field(default_factory=list)
    reserved: dict[str, set[int]] = field(default_factory=lambda: {"tool": set(), "user": set()})
    told: set[tuple[str, int]] = field(
        default_factory=set
    )  # whose values the program sets, or the receipt asks for

    @property
    def language(self) -> str:
        """How people call the target's language."""
        return language_of(self.work.target)

    # --- numbers ----------------------------------------------------------------------------------------

    def note_numbers(self, program: Program) -> None:
        """Which numbers the program itself uses: nothing else may have them."""
        looks = [self.work.look(routine) for routine in program.routines]
        for kind, e in [system for look in looks for system in look.systems]:
            self._note(kind, e)
        for s in [s for look in looks for _, s in look.rare]:
            if type(s) is Move:
                self._note("tool", s.tool)
                self._note("user", s.frame)
            elif isinstance(s, (Assign, DefineFrame)):
                key = system_of(s.target if isinstance(s, Assign) else s.frame)
                if key is not None:
                    self.taken[key[0]].add(key[1])
                    self.told.add(key)

    def _note(self, kind: str, e: Expression | None) -> None:
        if type(e) is FrameRef and e.kind == kind and type(e.number) is Number:
            wanted = self._wanted(kind, int(e.number.value))
            self.taken[kind].add(int(wanted) if wanted.isdecimal() else int(e.number.value))
        elif type(e) is Item:
            self.reserved[kind].add(_own_number(e))

    def numbered(self, kind: str, e: Expression, s: Statement) -> Expression:
        """A tool or frame by number."""
        if isinstance(e, FrameRef):
            return e if e.kind != kind or e.number is None else self._renumbered(kind, e, s)
        if isinstance(e, Named):
            symbol = self.symbols.find(self.routine, e.name)
            if symbol is not None and symbol.type in ("integer", "real"):
                return FrameRef(kind, e)
            if (
                symbol is not None
                and not symbol.is_fixed
                and symbol.type in ("tool", "frame")
                and symbol.assigned
            ):
                return self._varying(kind, e, s)
        value = self.symbols.fixed_value(self.routine, e)
        if not isinstance(value, PositionLiteral):
            self.work.lose(s, Fate.REFUSED, kind, "the tool or frame is computed while the program runs")
            return FrameRef(kind, Number(0))
        if kind == "user" and not any(value.values):
            return BASE
        return FrameRef(
            kind, Number(self._number(kind, e if isinstance(e, (Named, Item)) else value, value, s))
        )

    def _renumbered(self, kind: str, e: FrameRef, s: Statement) -> FrameRef:
        """A number of the source in the target: as mapped, else the same."""
        if not isinstance(e.number, Number):
            return e
        old = int(e.number.value)
        wanted = self._wanted(kind, old)
        if wanted and not wanted.isdecimal():
            says = f"the mapping calls it {wanted}, and {self.language} has numbers for {system_words(kind)}s"
            self.work.lose(s, Fate.REFUSED, system_words(kind), says)
            return e
        number = int(wanted) if wanted else old
        if number > (largest := self.work.limits.frame_numbers[kind]):
            says = f"number {number}: there are {largest} {system_words(kind)}s; the mapping file may give it another"
            self.work.lose(s, Fate.REFUSED, system_words(kind), says)
        known = self.work.systems.get((kind, old))
        if wanted or (kind, old) in self.work.elsewhere:
            self.work.names[(system_words(kind), self._label(kind, old))] = str(number)
        if known is not None and self.work.context.mapping.set_values:
            self.values.setdefault((kind, number), known)
        elif known is not None:
            self.work.held[(kind, str(number))] = known
        elif number:
            self._tell(kind, old, str(number), wanted, s)
        return FrameRef(kind, Number(number)) if wanted else e

    def _number(self, kind: str, key: Expression, value: PositionLiteral | None, s: Statement) -> int:
        number = self.numbers.get((kind, key))
        if number is None:
            shown = system_label(key)
            own = self.work.named_systems.get(key.name, 0) if type(key) is Named else _own_number(key)
            wanted = self.work.mapped_system(kind, shown, *([str(own)] if own else []))
            number = int(wanted) if wanted.isdecimal() else own
            largest = self.work.limits.frame_numbers[kind]
            if (number in self.taken[kind] or number > largest) and not wanted.isdecimal():
                number = next(n for n in range(1, 1000) if n not in self.taken[kind] | self.reserved[kind])
            if number > largest:
                says = f"more than {largest} {system_words(kind)}s"
                self.work.lose(s, Fate.REFUSED, system_words(kind), says)
                return number
            self.numbers[(kind, key)] = number
            self.taken[kind].add(number)
            self.work.names[(system_words(kind), shown)] = str(number)
            if value is not None and self.work.context.mapping.set_values:
                self.values[(kind, number)] = value
            elif value is not None:
                self.work.held[(kind, str(number))] = value
        return number

    def _varying(self, kind: str, e: Named, s: Statement) -> Expression:
        """A name whose value changes: a number of its own, which is set anew, or a variable that holds a number."""
        symbol = self.symbols.find(self.routine, e.name)
        assert symbol is not None
        if symbol.storage == "modal" and self.work.limits.tool_and_frame == "point":
            says = f"which {system_words(kind)} holds depends on the path to this move"
            self.work.lose(s, Fate.REFUSED, system_words(kind), says)
            return FrameRef(kind, Number(0))
        value = symbol.value if isinstance(symbol.value, PositionLiteral) else None
        return FrameRef(kind, Number(self._number(kind, e, value, s)))

    def is_numbered(self, kind: str, e: Expression) -> bool:
        """Of a language that has both: whether the tool or frame is constant, and a number is left for it."""
        if isinstance(e, FrameRef):
            if e.kind != kind or not isinstance(e.number, Number):
                return False
            wanted = self._wanted(kind, int(e.number.value))
            return _may_be_number(wanted) and e.number.value <= self.work.limits.frame_numbers[kind]
        if not _may_be_number(self.work.mapped_system(kind, system_label(e))):
            return False
        if isinstance(e, Named):
            symbol = self.symbols.find(self.routine, e.name)
            if symbol is None or symbol.assigned:
                return False
        left = len(self.taken[kind] | self.reserved[kind]) <= self.work.limits.frame_numbers[kind]
        known = (kind, e) in self.numbers or left
        return known and isinstance(self.symbols.fixed_value(self.routine, e), PositionLiteral)

    # --- names ------------------------------------------------------------------------------------------

    def named(self, kind: str, e: Expression, s: Statement) -> Expression:
        """A tool or frame by name, or by number where the target has both."""
        if isinstance(e, PositionLiteral):
            if kind == "user" and not any(e.values):
                return BASE
            return self._made(kind, e, "tool" if kind == "tool" else "frame", e)
        if isinstance(e, Item):
            literal = self.symbols.fixed_value(self.routine, e)
            if isinstance(literal, PositionLiteral):
                return self._made(kind, e, f"{system_words(kind)}_{_own_number(e)}", literal)
        if not isinstance(e, FrameRef) or e.kind != kind or e.number is None:
            return e
        if not isinstance(e.number, Number):
            if not self.work.limits.frame_numbers:
                says = f"the {system_words(kind)}'s number is computed while the program runs"
                self.work.lose(s, Fate.REFUSED, system_words(kind), says)
            return e
        return self._named_number(kind, e, int(e.number.value), s)

    def _named_number(self, kind: str, e: FrameRef, number: int, s: Statement) -> Expression:
        """A tool or frame that has a number in the source, or is declared elsewhere."""
        wanted = self._wanted(kind, number)
        known = self.work.systems.get((kind, number))
        if wanted:
            return self._as_mapped(kind, number, wanted, known, s)
        other = self.work.elsewhere.get((kind, number))
        if known is not None:
            return self._made(kind, e, f"{system_words(kind)}_{number}", known)
        if self.work.limits.frame_numbers:
            return self._renumbered(kind, e, s)
        if number == 0:
            return BASE if kind == "user" else e
        if other is not None:
            return self._without_values(kind, e, other, s)
        if (made := self.made.get((kind, e))) is not None:
            return made
        return self._made(kind, e, f"{system_words(kind)}_{number}", literal_of(self._known(kind, number)))

    def _as_mapped(
        self, kind: str, number: int, wanted: str, known: PositionLiteral | None, s: Statement
    ) -> Expression:
        if wanted.isdecimal() and not self.work.limits.frame_numbers:
            word = system_words(kind)
            says = f"the mapping gives it the number {wanted}, and {self.language} has names for {word}s"
            self.work.lose(s, Fate.REFUSED, word, says)
            return _UNKNOWN[kind]
        self.work.names[(system_words(kind), self._label(kind, number))] = wanted
        if known is not None:
            self.work.held[(kind, wanted)] = known
        else:
            self._tell(kind, number, wanted, wanted, s)
        if wanted.isdecimal():
            return FrameRef(kind, Number(int(wanted)))
        self.work.ask(
            "see that the controller has these, with their values", f"{system_words(kind)} {wanted}"
        )
        return Named(wanted)

    def _known(self, kind: str, number: int) -> Pose:
        cell = self.work.cell()
        if kind == "tool":
            found = cell.tools.get(number)
            if found is not None:
                return found.pose
        elif number in cell.user_frames:
            return cell.user_frames[number]
        word = system_words(kind)
        says = f"the values of {word} {number} are not in the program: zeros are written"
        if (kind, number) in self.told:
            self.work.ask(_SET_HERE, f"{word} {number}")
            return Pose.identity()
        self.work.lose(0, Fate.APPROXIMATED, word, says)
        self.work.ask(_ZEROS, f"{word} {number}")
        return Pose.identity()

    def _made(self, kind: str, key: Expression, stem: str, value: PositionLiteral | None) -> Named:
        name = self.made.get((kind, key))
        if name is None:
            name = self.made[(kind, key)] = Named(
                self.work.helper(stem) if kind == "position" else self.work.fresh(stem)
            )
            self._declare(kind, name.name, value)
            self.work.names[(system_words(kind), system_label(key))] = name.name
        return name

    def _declare(self, kind: str, name: str, value: PositionLiteral | None) -> None:
        says = "" if value is not None else UNDECLARED
        kept = Declare(0, name, system_words(kind), value, storage="persistent", shared=True, comment=says)
        self.declared.append(kept)

    # --- what is not known ------------------------------------------------------------------------------

    def _wanted(self, kind: str, number: int) -> str:
        """What the mapping file says of a number of the source, or of the name that it stands for."""
        other = self.work.elsewhere.get((kind, number))
        if other is not None:
            return other.wanted
        spelt = self.work.conventions.frame_spelling.get(kind, "{}")
        return self.work.mapped_system(kind, str(number), spelt.format(number))

    def _label(self, kind: str, number: int) -> str:
        other = self.work.elsewhere.get((kind, number))
        return str(number) if other is None else other.label

    def _tell(self, kind: str, old: int, new: str, wanted: str, s: Statement) -> None:
        """That the target's controller has to hold the values of what is declared elsewhere."""
        other = self.work.elsewhere.get((kind, old))
        if other is None:
            return
        word, label = system_words(kind), other.label
        if (kind, old) not in self.told:
            self.told.add((kind, old))
            taken = "flange" if kind == "tool" else "base"
            self.work.note_once(f"both runs take the {taken} for {label}, whose values are not at hand")
            if not wanted:
                spelt = self.work.target_conventions.frame_spelling.get(kind, "{}").format(new)
                says = f"{label} is not declared here: taken for a {word}, {spelt}"
                says += "; its values have to be set on the controller"
                self.work.lose(other.first, Fate.APPROXIMATED, "name", says)
        if not wanted and s is not other.first and s.line != other.first.line:
            self.work.lose(s, Fate.APPROXIMATED, "name", _DEPENDS.format(label))

    def _without_values(self, kind: str, e: FrameRef, other: Elsewhere, s: Statement) -> Named:
        """What is declared elsewhere, for a target that needs its values: declared with zeros under its name."""
        word, label = system_words(kind), other.label
        if (kind, e) in self.made:
            if s.line != other.first.line:
                self.work.lose(s, Fate.APPROXIMATED, word, _DEPENDS.format(label))
            return self.made[(kind, e)]
        if label.isidentifier():
            self.made[(kind, e)] = Named(label)
            self._declare(kind, label, _NOTHING)
            self.work.names[(word, label)] = label
        taken = "flange" if kind == "tool" else "base"
        self.work.note_once(f"both runs take the {taken} for {label}, whose values are not at hand")
        says = f"{label} is not declared here, and {self.language} needs the values of this {word}: zeros are written"
        here = "put the file that declares it beside the program, or its values under [names] of olp.toml"
        help = f"{here}; or say under [{word}s] of the mapping file which variable of the target it is"
        self.work.lose(other.first, Fate.APPROXIMATED, word, says, help=help)
        self.work.ask(_ZEROS, f"{word} {label}")
        return self._made(kind, e, word, _NOTHING)


def _may_be_number(wanted: str) -> bool:
    """Whether the mapping file leaves it a number: it gives one, or nothing."""
    return not wanted or wanted.isdecimal()


def _own_number(e: Expression) -> int:
    """The number that an element of an array of tools or frames has; 0 for all else, which nothing may have."""
    index = e.indices[0] if isinstance(e, Item) and len(e.indices) == 1 else None
    return int(index.value) if isinstance(index, Number) else 0


def system_words(kind: str) -> str:
    return {"user": "frame"}.get(kind, kind)


def system_label(e: Expression) -> str:
    """How a tool or frame is called in mapping files and receipts."""
    if isinstance(e, Named):
        return e.name
    if isinstance(e, FrameRef) and isinstance(e.number, Number):
        return str(int(e.number.value))
    if isinstance(e, Item):
        return f"{system_label(e.base)}[{_own_number(e)}]"
    if isinstance(e, PositionLiteral):
        return " ".join(f"{v:g}" for v in e.values)
    return str(e)
