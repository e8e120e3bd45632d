"""Tools and frames as the target names them: by number with the statements that set their values, by name, or folded.

Languages number them, name them, or have one tool and the base.
"""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import dataclass, field, replace
from typing import Any, Final, TypeVar

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.ir.points import PointKind
from olp.ir.transformer import calls_nothing, edited, expressions_of, mapped, note_names, sets_numbers
from olp.robots.geometry import Pose
from olp.runtime.assumptions import WrittenPosition
from olp.transpile.constant_frames import Key, system_of
from olp.transpile.context import Elsewhere, Fate, TranslationContext, world_of
from olp.transpile.current_position import HERE, keeps_systems, seen_in, systems_of
from olp.transpile.first_values import UNDECLARED
from olp.transpile.frame_names import BASE, SystemNames, system_label, system_words
from olp.transpile.occurrences import Look, with_rows
from olp.transpile.records import literal_of, pose_of_literal
from olp.transpile.symbols import Symbols, base_of, kind_of_value

T = TypeVar("T")
_FLANGE: Final = ex.FrameRef("tool", ex.Number(0))
_ZERO: Final = ex.PositionLiteral("pose", (0.0,) * 6)
_FAR: Final = (
    10.0  # [m] from a frame's origin to the points that define it: rounding them turns it by nothing
)


@dataclass(slots=True)
class _Systems(SystemNames):
    """Statements with the target's tools and frames. `known`: what moves' references became."""

    known: dict[tuple[object, ...], ex.Expression] = field(default_factory=dict)
    same: dict[int, tuple[ex.Expression, str, ex.Expression]] = field(
        default_factory=dict
    )  # by the id of the first
    reading: set[int] = field(default_factory=set)  # ids of the moves that may read where the arm stands
    held: dict[ex.Named, ex.Named] = field(
        default_factory=dict
    )  # of those with a number whose components are set: the position that is copied into it
    # Of those: where nothing tells the values
    taught: dict[tuple[str, int], ex.Named] = field(default_factory=dict)

    def move(self, s: st.Move) -> st.Move:
        changes: dict[str, Any] = {}
        if s.tool is not None and (tool := self._said("tool", s.tool, s)) is not s.tool:
            changes["tool"] = tool
        frame = s.frame
        base = type(frame) is ex.FrameRef and frame.kind == "base" and frame.number is None
        if frame is not None and not base and (frame := self._said("user", frame, s)) is not s.frame:
            changes["frame"] = frame
        if id(s) in self.reading:
            for name in ("targets", "via"):
                placed = self._placed(s, getattr(s, name))
                if placed is not getattr(s, name):
                    changes[name] = placed
        if self.work.limits.pose_functions:
            self._folded(s, frame, changes)
        return edited(s, changes) if changes else s

    def _said(self, kind: str, e: ex.Expression, s: st.Statement) -> ex.Expression:
        """A tool or frame as the target says it; moves name few of them, over and over."""
        same = self.same.get(id(e))
        if same is not None and same[0] is e and same[1] == kind:
            return same[2]
        key: tuple[object, ...] | None = None
        if type(e) is ex.Named:
            key = (kind, self.routine, e.name)
        elif type(e) is ex.FrameRef and type(e.number) is ex.Number:
            key = (kind, e.kind, e.number.value)
        known = None if key is None else self.known.get(key)
        if known is not None:
            said = e if known == e else known
            self.same[id(e)] = (e, kind, said)
            return said
        losses = len(self.work.losses)
        numbered = not self.work.limits.named_frames or (self.work.limits.forms and self.is_numbered(kind, e))
        said = self.numbered(kind, e, s) if numbered else self.named(kind, e, s)
        if key is not None and len(self.work.losses) == losses:
            self.known[key] = said
        return e if said == e else said

    def _folded(self, s: st.Move, frame: ex.Expression | None, changes: dict[str, Any]) -> None:
        """URScript: the target seen from the base."""
        tool = changes.get("tool", s.tool)
        if type(tool) is ex.FrameRef and tool == _FLANGE:
            changes["tool"] = _ZERO
        if frame is None or (isinstance(frame, ex.FrameRef) and frame.kind in ("base", "robot")):
            return
        if isinstance(frame, ex.FrameRef):
            self.work.lose(s, Fate.REFUSED, "frame", "a frame whose values are not known here")
            return
        changes["frame"] = BASE
        targets = changes.get("targets", s.targets)
        changes["targets"] = tuple([self._in_base(frame, target) for target in targets])
        if s.via is not None:
            changes["via"] = self._in_base(frame, s.via)

    def _in_base(self, frame: ex.Expression, target: ex.Expression) -> ex.Expression:
        if type(target) is ex.Function and target.name == "inverse" and len(target.arguments) == 2:
            return replace(target, arguments=(self._in_base(frame, target.arguments[0]), target.arguments[1]))
        if kind_of_value(self.symbols, self.routine, target) == "joints":
            return target
        return ex.Function("pose-product", (frame, target))

    def _chosen(
        self, s: st.Statement, held: list[ex.Expression | None]
    ) -> tuple[list[st.Statement], st.Statement]:
        """What chooses the tool and the frame that a statement reads the position with, and that statement."""
        limits = self.work.limits
        asked = next((found for e in expressions_of(s) if (found := systems_of(e)) is not None), None)
        if asked is None:
            return [], s
        placed = self._placed(s, s)
        if limits.tool_and_frame != "modal":
            return [], placed
        rows: list[st.Statement] = []
        for at, (kind, value) in enumerate(zip(("tool", "user"), asked, strict=True)):
            said = None if value is None else self._said(kind, value, s)
            if said is None or said == held[at] or (kind == "user" and limits.pose_functions):
                continue
            rows.append(st.SetTool(s.line, said) if kind == "tool" else st.SetFrame(s.line, said))
            held[at] = said
        return rows, placed

    def _placed(self, s: st.Statement, node: T) -> T:
        """Readings of the position as the target says them: RAPID names tool and frame, URScript has the base."""

        def change(e: ex.Expression) -> ex.Expression:
            asked = systems_of(e)
            if asked is None:
                return e
            tool, frame = asked
            tool = None if tool is None else self._said("tool", tool, s)
            frame = None if frame is None else self._said("user", frame, s)
            if self.work.limits.position_read_in == "move":
                return HERE
            if not self.work.limits.pose_functions:
                return seen_in(tool, frame)
            if frame is None or frame == BASE:
                return HERE
            return ex.Function("pose-product", (ex.Function("pose-inverse", (frame,)), HERE))

        return mapped(node, change)

    def assigned(self, s: st.Assign) -> list[st.Statement]:
        """An assignment to a name that stands for a numbered tool or frame sets that one's values."""
        if (
            self.work.limits.named_frames
            and isinstance(s.value, ex.FrameRef)
            and s.value.kind in ("tool", "user")
        ):
            s = replace(s, value=self._said(s.value.kind, s.value, s))
        key = system_of(s.target)
        if key is not None and not self.work.limits.named_frames:
            ref = self.numbered(key[0], ex.FrameRef(key[0], ex.Number(key[1])), s)
            if isinstance(ref, ex.FrameRef) and isinstance(ref.number, ex.Number):
                return self.setting(key[0], int(ref.number.value), s.value, s.line, s.comment)
        if key is not None:
            target = self.named(key[0], ex.FrameRef(key[0], ex.Number(key[1])), s)
            return [replace(s, target=target)]
        member = s.target if isinstance(s.target, ex.Member) else None
        name = s.target if member is None else member.base
        if not isinstance(name, ex.Named):
            return [s]
        for kind in ("tool", "user"):
            number = self.numbers.get((kind, name))
            if number is None:
                continue
            held = self.held.get(name)
            if held is None and member is None:
                return self.setting(kind, number, s.value, s.line, s.comment)
            if held is None:
                says = f"the component of a {system_words(kind)} of a routine's own, which has a number"
                self.work.lose(s, Fate.REFUSED, "component", says)
                return [s]
            target = held if member is None else replace(member, base=held)
            return [replace(s, target=target), *self.setting(kind, number, held, s.line)]
        return [s]

    def note_components(self, routine: st.Routine, shared: Set[str]) -> None:
        """Positions for the tools and frames with numbers of which a routine sets components.

        `shared`: the names of the program's own data. Those of a routine begin anew with each call.
        """
        for _, s in self.work.look(routine).rare:
            base = s.target.base if isinstance(s, st.Assign) and isinstance(s.target, ex.Member) else None
            if not isinstance(base, ex.Named) or base in self.held or base.name not in shared:
                continue
            symbol = self.symbols.find(routine.name, base.name)
            for kind in ("tool", "user"):
                if symbol is not None and not symbol.scope and (kind, base) in self.numbers:
                    value = symbol.value if isinstance(symbol.value, ex.PositionLiteral) else None
                    held = self.held[base] = self._made("position", base, f"{base.name}_value", value)
                    if value is None:  # what is taught is its value, from the start
                        self.taught[kind, self.numbers[kind, base]] = held

    def setting(
        self, kind: str, number: int, value: ex.Expression, line: int, comment: str = ""
    ) -> list[st.Statement]:
        """The statements that set the values of a numbered tool or frame."""
        if (
            isinstance(value, ex.FrameRef)
            and value.number is not None
            and not isinstance(value.number, ex.Number)
        ):
            says = f"the {system_words(kind)}'s number is computed while the program runs"
            self.work.lose(line, Fate.REFUSED, system_words(kind), says)
            return []
        if not self.work.limits.frame_functions:
            return [
                st.Assign(
                    line, ex.FrameRef(kind, ex.Number(number)), self._position(kind, number, value), comment
                )
            ]
        if kind == "tool":
            target = ex.Function("tool-data", (ex.Number(number),))
            return [st.Assign(line, target, self._position(kind, number, value), comment)]
        literal = self.symbols.fixed_value(self.routine, value)
        if not isinstance(literal, ex.PositionLiteral):
            self.work.lose(line, Fate.REFUSED, "frame", "a frame that is computed while the program runs")
            return []
        pose = pose_of_literal(literal)
        corners = [
            pose,
            *(Pose(pose.apply(point), pose.rotation) for point in ((_FAR, 0, 0), (_FAR, _FAR, 0))),
        ]
        points = []
        for corner, suffix in zip(corners, ("o", "x", "xy"), strict=True):
            points.append(
                self._made("position", literal_of(corner), f"frame{number}_{suffix}", literal_of(corner))
            )
        return [st.DefineFrame(line, ex.FrameRef(kind, ex.Number(number)), tuple(points), comment=comment)]  # type: ignore[arg-type]

    def _position(self, kind: str, number: int, value: ex.Expression) -> ex.Expression:
        literal = self.symbols.fixed_value(self.routine, value)
        if isinstance(literal, ex.PositionLiteral):
            if self.work.limits.forms:
                return literal
            return self._made("position", literal, f"{system_words(kind)}{number}_value", literal)
        return value

    def routine_of(self, routine: st.Routine) -> st.Routine:
        self.routine = routine.name
        self.same.clear()
        if self.work.limits.position_read_in != "base":
            self.reading = {id(s) for _, s in self.work.look(routine).rare}
        return with_rows(routine, [self.move(s) if type(s) is st.Move else s for s in routine.body])

    def routine_with_values(self, routine: st.Routine, main: bool) -> st.Routine:
        self.routine = routine.name
        rows: list[st.Statement] = []
        reads = self.work.limits.position_read_in != "base"
        held: list[ex.Expression | None] = [None, None]  # tool and frame, where the text tells them
        for s in routine.body:
            if type(s) is st.Move:
                held = [s.tool, s.frame]
                rows.append(s)
                continue
            if reads:
                before, s = self._chosen(s, held)
                rows += before
                if not keeps_systems(s):
                    held = [None, None]
            if self.held:
                s = self._with_held(s)
            if isinstance(s, st.Assign):
                rows += self.assigned(s)
            elif not (
                isinstance(s, st.Declare)
                and s.type in ("tool", "frame")
                and not self.work.limits.named_frames
            ):
                rows.append(s)
        if main and (self.values or self.taught):
            rows[_place(rows) : _place(rows)] = self._all_values()
        return with_rows(routine, rows)

    def _with_held(self, s: st.Statement) -> st.Statement:
        """A statement that reads components of the positions that hold tools and frames with numbers."""

        def change(e: ex.Expression) -> ex.Expression:
            held = self.held.get(e.base) if type(e) is ex.Member and type(e.base) is ex.Named else None
            return e if held is None or type(e) is not ex.Member else replace(e, base=held)

        if isinstance(s, st.Assign):
            value = mapped(s.value, change)
            return s if value is s.value else replace(s, value=value)
        return mapped(s, change)

    def _all_values(self) -> list[st.Statement]:
        rows: list[st.Statement] = []
        labels = {(kind, number): system_label(key) for (kind, key), number in self.numbers.items()}
        for (kind, number), value in self.values.items():
            label = labels.get((kind, number), "") if self.work.limits.forms else ""
            rows += self.setting(kind, number, self.taught.get((kind, number), value), 0, label)
        for (kind, number), held in self.taught.items():
            rows += self.setting(kind, number, held, 0) if (kind, number) not in self.values else []
        return [st.Comment(0, terminology.SYSTEMS_ARE_SET), *rows] if rows else []


def frames(program: st.Program, work: TranslationContext) -> st.Program:
    """Every move's tool and frame as the target says them, and their values where it has none yet."""
    systems = _Systems(work, work.symbols(program))
    systems.note_numbers(program)
    routines = tuple(systems.routine_of(routine) for routine in program.routines)
    if not work.limits.named_frames:
        shared = _names_of_data(work.source) | work.named_systems.keys()
        for routine in routines:
            systems.note_components(routine, shared)
    data = program.data if work.limits.named_frames else _with_copied(program, systems)
    main = program.main or (routines[0].name if routines else "")
    routines = tuple(
        systems.routine_with_values(routine, routine.name == main or _begins_moving(routine))
        for routine in routines
    )
    if not work.limits.named_frames:
        data = tuple(declare for declare in data if declare.type not in ("tool", "frame"))
        routines = tuple(
            replace(r, data=tuple(d for d in r.data if d.type not in ("tool", "frame"))) for r in routines
        )
    return replace(program, routines=routines, data=(*data, *systems.declared))


def _begins_moving(routine: st.Routine) -> bool:
    return routine.starts and any(isinstance(s, (st.Call, st.Move)) for s in routine.body)


def _with_copied(program: st.Program, systems: _Systems) -> tuple[st.Declare, ...]:
    """The data of a program: tools and frames that have no number, and are computed or copied, as positions."""
    numbered = {base.name for _, key in systems.numbers if (base := base_of(key)) is not None}
    used: set[str] = set()
    for routine in program.routines:
        for _, s in systems.work.look(routine).rare:
            if type(s) is st.Assign:
                note_names(s, used)
    used -= numbered

    def change(d: st.Declare) -> st.Declare:
        known = d.value is None or isinstance(d.value, ex.PositionLiteral)
        kept = d.type in ("tool", "frame") and d.name in used and known and not d.sizes
        return replace(d, type="position") if kept else d

    return tuple(map(change, program.data))


def _names_of_data(program: st.Program) -> set[str]:
    """The names of the program's data that no routine has, too."""
    names = {declare.name for declare in program.data}
    for routine in program.routines:
        names -= {declare.name for declare in routine.data} | {p.name for p in routine.parameters}
        names -= {s.name for s in routine.body if isinstance(s, st.Declare)}
    return names


def _place(rows: list[st.Statement]) -> int:
    return next((at for at, s in enumerate(rows) if not isinstance(s, (st.Begin, st.Declare))), len(rows))


# --- External frames ---
# Tools and frames that a file declares which is not at hand: a number stands for each until the target names them.
#
# olp.toml beside the program may give their values under [names]; then they are declared with these.

_FIELDS: Final[dict[type, tuple[str, ...]]] = {
    st.Move: ("tool", "frame"),
    st.SetTool: ("tool",),
    st.SetFrame: ("frame",),
}
_KINDS = {"tool": "tool", "frame": "user"}


def external_frames(program: st.Program, work: TranslationContext) -> st.Program:
    """Tools and frames that no file declares get a number; `work.elsewhere` keeps their names."""
    symbols = work.symbols(program)
    if not any(_names_undeclared(symbols, routine, work.look(routine)) for routine in program.routines):
        return program
    named = [
        (routine, s, kind, e)
        for routine in program.routines
        for s in routine.body
        for kind, e in _systems(s)
        if _is_undeclared(symbols, routine, e)
    ]
    own = _Elsewhere(work, program)
    for _, s, kind, e in named:
        own.note(kind, e, s)
    routines = tuple(
        replace(r, body=tuple([own.statement(s, r, symbols) for s in r.body])) for r in program.routines
    )
    return replace(program, routines=routines, data=(*program.data, *own.declared.values()))


def _systems(s: st.Statement) -> Iterator[tuple[str, ex.Expression]]:
    """The tools and frames that a statement names."""
    for name in _FIELDS.get(type(s), ()):
        e = getattr(s, name)
        if e is not None and type(e) is not ex.FrameRef:
            yield _KINDS[name], e
    if not calls_nothing(s) and not sets_numbers(s):
        for e in expressions_of(s):
            for kind, part in zip(("tool", "user"), systems_of(e) or (), strict=False):
                if part is not None:
                    yield kind, part


def _names_undeclared(symbols: Symbols, routine: st.Routine, look: Look) -> bool:
    systems = [e for _, e in look.systems if type(e) is not ex.FrameRef]
    systems += [e for _, s in look.rare for _, e in _systems(s)]
    return any(_is_undeclared(symbols, routine, e) for e in systems)


def _is_undeclared(symbols: Symbols, routine: st.Routine, e: ex.Expression) -> bool:
    name = e.base if isinstance(e, ex.Item) and all(isinstance(i, ex.Number) for i in e.indices) else e
    return isinstance(name, ex.Named) and symbols.find(routine.name, name.name) is None


@dataclass(slots=True)
class _Elsewhere:
    """`numbers`: by kind and label; `declared`: what olp.toml gives a value."""

    work: TranslationContext
    program: st.Program
    numbers: dict[tuple[str, str], int] = field(default_factory=dict)
    declared: dict[str, st.Declare] = field(default_factory=dict)
    taken: dict[str, set[int]] = field(default_factory=lambda: {"tool": {0}, "user": {0}})

    def __post_init__(self) -> None:
        mapping = self.work.context.mapping
        for kind, table in (("tool", mapping.tools), ("user", mapping.frames)):
            self.taken[kind].update(int(n) for n in table.values() if n.isdecimal())
        for s in self.program.statements():
            for name in _FIELDS.get(type(s), ()):
                e = getattr(s, name)
                number = e.number if type(e) is ex.FrameRef else e.indices[0] if type(e) is ex.Item else None
                if type(number) is ex.Number:
                    self.taken[_KINDS[name]].add(int(number.value))

    def note(self, kind: str, e: ex.Expression, s: st.Statement) -> None:
        label = system_label(e)
        if (kind, label) in self.numbers or label in self.declared:
            return
        if isinstance(e, ex.Named) and (value := self._given(e.name)) is not None:
            type_ = "tool" if kind == "tool" else "frame"
            self.declared[label] = st.Declare(0, e.name, type_, value, storage="constant", shared=True)
            return
        wanted = self.work.mapped_system(kind, label)
        if not wanted and self.work.target_conventions.controller_names:
            return  # which names them as the source does
        number = int(wanted) if wanted.isdecimal() else self._free(kind)
        self.numbers[(kind, label)] = number
        self.work.elsewhere[(kind, number)] = Elsewhere(label, s, wanted)

    def _free(self, kind: str) -> int:
        number = next(n for n in range(1, 1000) if n not in self.taken[kind])
        self.taken[kind].add(number)
        return number

    def _given(self, name: str) -> ex.PositionLiteral | None:
        given = world_of(self.work.source, self.work.robot).assumptions.names.get(name.casefold())
        if not isinstance(given, WrittenPosition) or given.state.kind is not PointKind.POSE:
            return None
        return ex.PositionLiteral("pose", given.values[:6])

    def statement(self, s: st.Statement, routine: st.Routine, symbols: Symbols) -> st.Statement:
        changes: dict[str, Any] = {}
        for name in _FIELDS.get(type(s), ()):
            e = getattr(s, name)
            if e is not None and (new := self._numbered(_KINDS[name], e, routine, symbols)) is not e:
                changes[name] = new
        if changes:
            s = edited(s, changes) if isinstance(s, st.Move) else replace(s, **changes)
        return s if calls_nothing(s) else mapped(s, lambda e: self._reading(e, routine, symbols))

    def _reading(self, e: ex.Expression, routine: st.Routine, symbols: Symbols) -> ex.Expression:
        """A reading of the position that names such a tool or frame."""
        if not isinstance(e, ex.Function) or systems_of(e) is None:
            return e
        arguments: list[ex.Expression] = []
        for a in e.arguments:
            if isinstance(a, ex.NamedArgument) and a.value is not None:
                kind = "tool" if a.name.casefold() == "tool" else "user"
                a = replace(a, value=self._numbered(kind, a.value, routine, symbols))
            arguments.append(a)
        return replace(e, arguments=tuple(arguments))

    def _numbered(self, kind: str, e: ex.Expression, routine: st.Routine, symbols: Symbols) -> ex.Expression:
        if type(e) is ex.FrameRef or not _is_undeclared(symbols, routine, e):
            return e
        number = self.numbers.get((kind, system_label(e)))
        return e if number is None else ex.FrameRef(kind, ex.Number(number))


# --- Written systems ---
# KRL writes the values of its numbered tools and frames, TOOL_DATA[n] and BASE_DATA[n], or one element of them.
#
# A whole one is set in the target by its number. All else is refused: it is no variable like others.

_ARRAYS: Final = {"TOOL_DATA": "tool", "BASE_DATA": "user"}
_SIZES: Final = {"tool": 16, "user": 32}  # as delivered


def written_systems(program: st.Program, work: TranslationContext) -> st.Program:
    """Values in $config.dat of the numbered tools and frames that the program sets go into `work.systems`."""
    if not work.conventions.numbered_frame_values:
        return program
    program = _named_systems(_as_arrays(program, work), work)
    assigned = [s for r in program.routines for _, s in work.look(r).rare if isinstance(s, st.Assign)]
    written = {key for s in assigned if (key := _set(s.target))}
    _refuse(assigned, written, work)
    if not written:
        return program
    for declare in program.data:
        kind = _ARRAYS.get(declare.name.upper())
        if kind is not None and isinstance(declare.value, ex.RecordLiteral):
            for number, (_, value) in enumerate(declare.value.members, 1):
                if (kind, number) in written and isinstance(value, ex.PositionLiteral):
                    work.systems[(kind, number)] = value
    routines = tuple(
        replace(r, body=tuple([_statement(s, written) for s in r.body])) for r in program.routines
    )
    return replace(program, routines=routines)


def _as_arrays(program: st.Program, work: TranslationContext) -> st.Program:
    """Tools and frames by computed numbers as elements of an array, where the target has names for them and no numbers.

    Those by other numbers are elements of it, too.
    """
    limits = work.limits
    if not limits.named_frames or limits.frame_numbers or limits.pose_functions:
        return program
    users: dict[str, st.Statement] = {}  # the first with a computed number
    for s in program.statements() if _any_computed(program, work) else ():
        for e in _numbered_in(s):
            if not isinstance(e.number, ex.Number):
                users.setdefault(e.kind, s)
    if not users:
        return program
    names = {kind: work.fresh(f"numbered_{system_words(kind)}s") for kind in users}

    def change(e: ex.Expression) -> ex.Expression:
        found = _system(e) if isinstance(e, (ex.FrameRef, ex.Item)) else None
        if found is None or found.kind not in names or found.number is None or found.number == ex.Number(0):
            return e  # 0: the flange, the base
        return ex.Item(ex.Named(names[found.kind]), (found.number,))

    listed = {_ARRAYS.get(d.name.upper(), ""): d for d in program.data}
    rows = [d for d in program.data if _ARRAYS.get(d.name.upper()) not in names]
    for kind, name in names.items():
        if kind in listed:
            values = _filled(listed[kind], users[kind], work)
            rows.append(replace(listed[kind], name=name, type=system_words(kind), value=values, shared=False))
            continue
        word = system_words(kind)
        rows.append(
            st.Declare(
                0, name, word, None, (ex.Number(_SIZES[kind]),), "persistent", shared=True, comment=UNDECLARED
            )
        )
        says = (
            f"{name} is not declared here: taken for {_SIZES[kind]} {word}s; their values have to be taught"
        )
        work.lose(users[kind], Fate.APPROXIMATED, "name", says)

    def changed(s: st.Statement) -> list[st.Statement]:
        """An array has no element 0: a number below 1 is the flange or the base."""
        made = mapped(s, change)
        chosen = s.tool if isinstance(s, st.SetTool) else s.frame if isinstance(s, st.SetFrame) else None
        if made is s or not isinstance(chosen, ex.FrameRef) or isinstance(chosen.number, ex.Number):
            return [made]
        assert chosen.number is not None
        below = st.If(s.line, ex.Compare("<=", chosen.number, ex.Number(0)))
        none = (
            replace(s, tool=ex.FrameRef("tool", ex.Number(0)))
            if isinstance(s, st.SetTool)
            else st.SetFrame(s.line, ex.FrameRef("base"))
        )
        return [below, replace(none, comment=""), st.Else(s.line), made, st.EndIf(s.line)]

    routines = tuple(
        replace(r, body=tuple([one for s in r.body for one in changed(s)])) for r in program.routines
    )
    return replace(program, routines=routines, data=tuple(rows))


def _filled(listed: st.Declare, user: st.Statement, work: TranslationContext) -> ex.Expression | None:
    """The first values of all tools or frames of a list: zeros, which is told, for those that it leaves open."""
    value, size = listed.value, listed.sizes[0] if listed.sizes else None
    if not isinstance(value, ex.RecordLiteral) or not isinstance(size, ex.Number):
        return value
    members = [*value.members, *[("", ex.Unknown(""))] * (int(size.value) - len(value.members))]
    open_ = [at for at, (_, member) in enumerate(members, 1) if isinstance(member, ex.Unknown)]
    if not open_:
        return value
    which = ", ".join(f"{listed.name}[{at}]" for at in open_[:8]) + (" …" if len(open_) > 8 else "")
    work.lose(user, Fate.APPROXIMATED, "name", f"no file has values for {which}: zeros are written")
    filled = [
        ("", ex.PositionLiteral("pose", (0.0,) * 6)) if at in open_ else one
        for at, one in enumerate(members, 1)
    ]
    return replace(value, members=tuple(filled))


def _any_computed(program: st.Program, work: TranslationContext) -> bool:
    """Whether any statement takes a tool or a frame by a computed number."""
    looks = [work.look(r) for r in program.routines]
    plain = (e for look in looks for _, e in look.systems)
    systems = (_system(e) for e in plain if isinstance(e, (ex.FrameRef, ex.Item)))
    if any(e is not None and not isinstance(e.number, ex.Number) for e in systems):
        return True
    return any(
        not isinstance(e.number, ex.Number) for look in looks for _, s in look.rare for e in _numbered_in(s)
    )


def _numbered_in(s: st.Statement) -> Iterator[ex.FrameRef]:
    """The tools and frames of a statement by their numbers in the arrays."""
    systems = [e for name in _FIELDS.get(type(s), ()) if (e := getattr(s, name)) is not None]
    for e in (*systems, *(() if calls_nothing(s) or sets_numbers(s) else expressions_of(s))):
        found = _system(e) if isinstance(e, (ex.FrameRef, ex.Item)) else None
        if found is not None:
            yield found


def _named_systems(program: st.Program, work: TranslationContext) -> st.Program:
    """Numbered tools and frames of which the program sets components, or that it sets and reads, as variables."""
    written: set[Key] = set()
    changing: set[Key] = set()
    for s in (s for r in program.routines for _, s in work.look(r).rare if isinstance(s, st.Assign)):
        target: ex.Expression = s.target
        while isinstance(target, ex.Member):
            target = target.base
        if (key := _set(target)) is not None:
            (written if target is s.target else changing).add(key)
    read = {
        key
        for r in program.routines
        for _, s in work.look(r).rare
        if isinstance(s, st.Assign)
        for e in expressions_of(s.value)
        if (key := _set(e)) is not None
    }
    known = {_ARRAYS[d.name.upper()] for d in program.data if d.name.upper() in _ARRAYS}
    changing |= {key for key in read if key in written or key[0] not in known}
    if not changing:
        return program
    names = {key: work.fresh(f"{system_words(key[0])}_{key[1]}") for key in sorted(changing)}
    if work.limits.frame_numbers and work.source.vendor != work.target:
        _tell_copies(program, work, names.keys())
    work.named_systems.update({given: at for (_, at), given in names.items()})
    for (group, at), given in names.items():
        work.names["tool" if group == "tool" else "frame", str(at)] = given

    def change(e: ex.Expression) -> ex.Expression:
        name = names.get(_set(e) or ("", 0))
        return e if name is None else ex.Named(name)

    values = {
        (kind, number): value
        for d in program.data
        if (kind := _ARRAYS.get(d.name.upper())) is not None and isinstance(d.value, ex.RecordLiteral)
        for number, (_, value) in enumerate(d.value.members, 1)
        if isinstance(value, ex.PositionLiteral)
    }
    declared = [
        st.Declare(
            0,
            name,
            "tool" if kind == "tool" else "frame",
            values[kind, number],
            (),
            "persistent",
            shared=True,
        )
        for (kind, number), name in names.items()
        if (kind, number) in values
    ]
    routines = tuple(replace(r, body=tuple([mapped(s, change) for s in r.body])) for r in program.routines)
    return replace(program, routines=routines, data=(*program.data, *declared))


def _tell_copies(program: st.Program, work: TranslationContext, named: Set[Key]) -> None:
    """Tells where the program sets tools and frames that become variables: other programs take the controller's."""
    for r in program.routines:
        for _, s in work.look(r).rare:
            target: ex.Expression | None = s.target if isinstance(s, st.Assign) else None
            while isinstance(target, ex.Member):
                target = target.base
            key = None if target is None else _set(target)
            if key is not None and key in named:
                says = f"{system_words(key[0])} {key[1]} of the controller keeps its value: what is set is a copy"
                work.lose(s, Fate.APPROXIMATED, "scope", says)


def _system(e: ex.Expression) -> ex.FrameRef | None:
    """A tool or frame of the arrays by its number, which may be computed."""
    if isinstance(e, ex.FrameRef) and e.kind in _ARRAYS.values() and e.number is not None:
        return e
    if isinstance(e, ex.Item) and isinstance(e.base, ex.Named) and e.base.name.upper() in _ARRAYS:
        return ex.FrameRef(_ARRAYS[e.base.name.upper()], e.indices[0])
    return None


def _set(target: ex.Expression) -> Key | None:
    """The tool or frame that an assignment sets as a whole."""
    found = _system(target)
    if found is None or not isinstance(found.number, ex.Number):
        return None
    return found.kind, int(found.number.value)


def _refuse(assigned: list[st.Assign], written: set[Key], work: TranslationContext) -> None:
    for s in assigned:
        word = ""
        target: ex.Expression = s.target
        while isinstance(target, ex.Member):
            target = target.base
        found = _system(target)
        if found is not None:
            word = "tool" if found.kind == "tool" else "frame"
            if not isinstance(found.number, ex.Number):
                says = f"which {word} it sets is computed while the program runs"
                work.lose(s, Fate.REFUSED, word, says)
        if any(_set(e) in written for e in expressions_of(s.value)):
            work.lose(s, Fate.REFUSED, word or "value", "it reads a tool or frame that the program sets")


def _statement(s: st.Statement, written: set[Key]) -> st.Statement:
    if isinstance(s, st.Assign) and _set(s.target) in written and (system := _system(s.target)) is not None:
        return replace(s, target=system)
    changes: dict[str, Any] = {}
    for name in _FIELDS.get(type(s), ()):
        e = getattr(s, name)
        if isinstance(e, ex.Item) and _set(e) in written:
            changes[name] = _system(e)
    if not changes:
        return s
    return edited(s, changes) if isinstance(s, st.Move) else replace(s, **changes)
