"""What belongs to the source's language alone, as comments."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from typing import Any, Final

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.ir.text_lengths import text_lengths
from olp.ir.transformer import (
    calls_nothing,
    expressions_of,
    gather,
    mapped,
    note_names,
)
from olp.languages.limits import limits_of, writable
from olp.languages.vendor import (
    ACKNOWLEDGED,
    ENDS_CYCLE,
    ENDS_PROGRAM,
    ON_THE_WAY,
    ONCE,
    SHOWN,
    WATCH,
    MoveOptions,
    find_vendor,
    language_of,
    vendor_names,
)
from olp.transpile.clocks import is_clock
from olp.transpile.context import PROCESS, Fate, TranslationContext
from olp.transpile.occurrences import Look
from olp.transpile.symbols import base_of

_ACKNOWLEDGES: Final = (
    "what waited for an acknowledgement waits there until the operator starts the program again"
)
_PLACES: Final = ("pose-", "joints")  # functions that put a position together
NOT_CONNECTED: Final = 9e9  # of an axis beside the arm
_EXTERNAL: Final = "extjoint"  # the type of what holds them
_AXES: Final = "extax"  # the axes beside the arm, of a position
_EACH_AXIS: Final = frozenset(f"e{n}" for n in range(1, 7))
_NAMED_VALUES: Final = "messages there are fixed texts: the name of a value stands in its place"
_HANDLER = "a handler: what the program does where something fails"
_CLOCK = "a clock, which each controller starts, stops and counts in its own way"
_MODAL = frozenset({st.SetSpeed, st.SetBlend})
_FOREIGN = (st.Opaque, st.Process, st.Reference)
_READING = (
    st.Assign,
    st.If,
    st.ElseIf,
    st.While,
    st.Until,
    st.Wait,
    st.Dwell,
    st.Switch,
    st.Call,
    st.Return,
    st.SetOutput,
    st.Jump,
    st.Message,
    st.For,
)


def foreign_word(source: str, target: str) -> str:
    """Why a statement goes that olp keeps as its text. Two vendors."""
    return f"a word of {language_of(source)} that means nothing in {language_of(target)}"


def foreign_words(program: st.Program, work: TranslationContext) -> st.Program:
    """Process instructions and statements that olp keeps without understanding: comments, or refused."""
    words = _ForeignWords.of(program, work)
    vendor = find_vendor(program.vendor) if program.vendor in vendor_names() else None
    resolved, settings = work.conventions.resolved_variables, work.conventions.told_settings
    routines = []
    for routine in program.routines:
        unresolved = _read_records(work.look(routine)) if resolved else set[str]()
        halts = words.halts(routine)
        rows: list[st.Statement] = []
        for s in vendor.without_editor_comments(routine.body) if vendor else routine.body:
            if _may_name_arm(s):
                s = words.without_arm(s)
            if type(s) in _MODAL or (type(s) is st.Move and not s.other):
                rows.append(s)
            elif isinstance(s, st.Process) and s.line in halts:
                rows += words.halted(s)
            elif isinstance(s, st.Process) and s.name.casefold() in ENDS_PROGRAM:
                rows += words.program_end(s, routine)
            elif not (isinstance(s, st.Assign) and _is_resolved(s.target, resolved, unresolved)):
                rows += words.translated(words.answered(s))
            elif isinstance(s.target, ex.Named) and (told := settings.get(s.target.name.upper())):
                work.note_at(s, f"{told}: see that the target's own is the one meant")
        routines.append(replace(routine, body=tuple(words.switched_off(routine, rows))))
    own = (s for r in routines for s in r.body if isinstance(s, st.Declare))
    for d in (*program.data, *own):
        if d.native.casefold() in work.conventions.wide_numbers:
            says = f"{d.name} holds numbers of 15 digits: {language_of(work.target)} may keep 7 of them"
            work.lose(d, Fate.APPROXIMATED, "value", says)
        if taken := work.conventions.operator_sets.get(d.native):
            work.lose(d, Fate.APPROXIMATED, "value", taken)
    kept = [d for d in program.data if not (words.axes_stand and d.name in words.held)]
    return set_elsewhere(replace(program, routines=tuple(routines), data=tuple(kept)), words.lost, work)


@dataclass(frozen=True, slots=True)
class _ForeignWords:
    """What becomes of the statements of one program. `lost` gets those of which no more is known than their text."""

    program: st.Program
    work: TranslationContext
    started: Set[str]  # tasks
    shifts: bool  # whether any shift is switched on
    manner: Set[str]  # options of moves that change how a move is made
    defined: Set[str]  # routines
    called: Set[str]  # names, case folded
    settings: Mapping[int, str]  # lines that set what moves nothing, and what that is
    axes_stand: bool  # whether no position of the program says anything of an axis beside the arm
    held: Set[str]  # variables that hold where axes beside the arm stand
    watched: Mapping[
        int, tuple[ex.CallValue, bool]
    ]  # by number: what a condition calls, and whether once only
    lost: list[st.Statement] = field(default_factory=list)

    @classmethod
    def of(cls, program: st.Program, work: TranslationContext) -> _ForeignWords:
        options = work.conventions.move_options
        stands = _tables_stand(program, work)
        rare = [s for r in program.routines for _, s in work.look(r).rare]
        declared = (*program.data, *(s for s in rare if isinstance(s, st.Declare)))
        held = frozenset(d.name for d in declared if d.type == _EXTERNAL)
        return cls(
            program,
            work,
            {s.task for s in rare if isinstance(s, st.StartTask)},
            any(isinstance(s, st.ShiftOn) for s in rare),
            options.manner | options.together if stands else options.manner,
            {routine.name.casefold() for routine in program.routines},
            {s.routine.casefold() for s in rare if isinstance(s, st.Call)},
            _idle_settings(program, rare, work),
            stands and not any(_sets_axes(s, held) for s in rare),
            held,
            dict(_watched(rare)),
        )

    @property
    def _fate(self) -> Fate:
        return Fate.COMMENTED if self.work.context.on_loss == "comment" else Fate.REFUSED

    def answered(self, s: st.Statement) -> st.Statement:
        """The statement with what functions of the controller's own answer in the target."""
        answers = self.work.conventions.answers
        if not answers or not isinstance(s, _READING):
            return s

        def change(e: ex.Expression) -> ex.Expression:
            if not isinstance(e, ex.CallValue) or e.routine.casefold() in self.defined:
                return e
            answer = answers.get(e.routine.casefold())
            if answer is None:
                return e
            self.work.lose(s, Fate.APPROXIMATED, "value", answer[1])
            return ex.SignalState(answer[0])

        return mapped(s, change)

    def without_arm(self, s: st.Statement) -> st.Statement:
        """The statement with computed positions that name no arm configuration, nor axes where all stand."""
        gone = {"conf", "axes"} if self.axes_stand else {"conf"}
        dropped: set[str] = set()

        def change(e: ex.Expression) -> ex.Expression:
            if type(e) is not ex.Function or not e.name.startswith(_PLACES):
                return e
            kept = [a for a in e.arguments if not (type(a) is ex.NamedArgument and a.name in gone)]
            dropped.update(a.name for a in e.arguments if type(a) is ex.NamedArgument and a.name in gone)
            return e if len(kept) == len(e.arguments) else replace(e, arguments=tuple(kept))

        s = mapped(s, change)
        if "conf" in dropped:
            says = "the arm configuration of a computed position: the arm takes the nearest one"
            self.work.lose(s, Fate.APPROXIMATED, "configuration", says)
        if not self.axes_stand and not self.work.limits.computed_axes and _names_axes(s, frozenset()):
            self.work.lose(s, Fate.REFUSED, "external", "external axes of a computed position")
        return s

    def translated(self, s: st.Statement) -> list[st.Statement]:
        """The rows that stand for a statement."""
        work = self.work
        if isinstance(s, st.ObeyFlags) and not work.limits.watches_flags:
            return []  # the flags that its moves end with are written
        if isinstance(s, st.Disabled):
            if s.handler:
                work.lose(s, self._fate, "statement", _HANDLER)
            elif s.beside:
                part = PROCESS if s.acts else "option"
                work.lose(s, Fate.APPROXIMATED, part, f"left out: {s.beside}")
            return [st.Comment(s.line, s.text.strip())]
        if isinstance(s, st.Wait) and s.timeout is not None and work.limits.wait_poll:
            poll = work.limits.wait_poll
            says = (
                f"{language_of(work.target)} has no wait with a limit: a loop asks every {poll * 1000:g} ms"
            )
            work.lose(s, Fate.APPROXIMATED, "wait", says, poll, "s")
            return [s]
        if isinstance(s, st.Move) and s.other:
            return [_without_options(s, work, self.manner)]
        if not work.limits.clocks and isinstance(s, _READING) and any(map(is_clock, expressions_of(s))):
            work.lose(s, Fate.REFUSED, "statement", _CLOCK)
            return [s]
        if isinstance(s, st.Pause) and s.spelling == ACKNOWLEDGED:
            work.lose(s, Fate.APPROXIMATED, "option", _ACKNOWLEDGES)
            return [s]
        if isinstance(s, st.WaitTask) and s.task not in self.started:
            says = f"the end of a task that nothing here starts: {s.task}"
            work.lose(s, Fate.REFUSED, "statement", says)
            return [s]
        if (
            isinstance(s, st.Process)
            and work.limits.traps is not None
            and s.name in work.limits.traps.words()
        ):
            return [s]
        if isinstance(s, st.Process) and (rows := self._process(s)) is not None:
            return rows
        if isinstance(s, st.Message) and work.limits.fixed_messages and not isinstance(s.text, ex.Text):
            work.lose(s, Fate.APPROXIMATED, "message", _NAMED_VALUES)
            return [replace(s, text=ex.Text(_with_names(s.text)))]
        if isinstance(s, st.Message) and (parts := _long_head(s, work)):
            return parts
        if isinstance(s, st.Assign) and (manner := self._manner_setting(s)) is not None:
            return [self._manner(s, manner)]
        if (why := self._idle_because(s)) is not None:
            return [_idle(s, why, self.program, work)]
        return [self._foreign(s)] if isinstance(s, _FOREIGN) else [s]

    def program_end(self, s: st.Process, routine: st.Routine) -> list[st.Statement]:
        """What ends the program as a whole: the target's word, in the main routine its return, else stops for good."""
        if s.name.casefold() == ENDS_CYCLE:
            says = f"{language_of(self.program.vendor)} begins its next cycle by itself, the translation ends"
            self.work.lose(s, Fate.APPROXIMATED, "option", says)
        if self.work.limits.program_end:
            return [replace(s, name=self.work.limits.program_end)]
        main = self.program.main or self.program.routines[0].name
        language = language_of(self.work.target)
        if routine.name == main and main.casefold() not in self.called:
            source = limits_of(self.program.vendor) if self.program.vendor in writable() else None
            if source is None or source.started != main.casefold():
                says = f"where another program calls {main}, {language} goes on there: only {main} ends"
                self.work.lose(s, Fate.APPROXIMATED, "order", says)
            return [st.Return(s.line, comment=s.comment)]
        says = f"{language} ends no program from within a called routine: it stops there, and again at each start"
        self.work.lose(s, Fate.APPROXIMATED, "order", says)
        return [
            st.While(s.line, ex.SignalState(True)),
            st.Pause(s.line, comment=s.comment),
            st.EndWhile(s.line),
        ]

    def _process(self, s: st.Process) -> list[st.Statement] | None:
        """Of an instruction that leaves nothing behind, or that the target has, too; None for any other."""
        if self.work.limits.watches and (how := dict(s.arguments).get(WATCH)) is not None:
            return self._watched(s, how)
        if s.name == self.work.conventions.window_process and not any(
            tag == "blocking" for tag, _ in s.arguments
        ):
            self.work.note_at(s, "the title and the look of the message's window are left out")
            return []
        if (weld := self._weld(s)) is not None:
            return [weld]
        manner = self.work.conventions.manner_processes.get(s.name.casefold())
        if manner is not None:
            return [self._manner(s, manner)]
        shown = dict(s.arguments).get(SHOWN)
        if shown is not None:
            self.work.lose(s, Fate.APPROXIMATED, "option", f"what {s.name} keeps in a log is a message there")
            return [st.Message(s.line, shown, s.comment)]
        if s.name.casefold() in self.work.conventions.standing_processes:
            says = f"{s.name} waits until the arm stands: the move before it stops exactly"
            self.work.lose(s, Fate.EXACT, "statement", says)
            return [st.Comment(s.line, s.comment)] if s.comment else []
        silent = self.work.conventions.silent_processes.get(s.name.casefold())
        if silent is None:
            return None
        why = dict(s.arguments).get(ON_THE_WAY)
        if isinstance(why, ex.Text):
            self.work.lose(s, Fate.APPROXIMATED, "order", why.value)
        else:
            says = f"{silent} means nothing to another controller: it is left out"
            self.work.lose(s, Fate.EXACT, "statement", says)
        return [st.Comment(s.line, s.comment)] if s.comment else []

    def _weld(self, s: st.Process) -> st.Process | None:
        """What begins or ends a weld under numbered conditions, where the target has such, too."""
        own, others = self.work.conventions.welds, self.work.target_conventions.welds
        for one, other in zip(own or (), others or (), strict=False):
            if (number := one.number(s)) is not None:
                says = f"{other.process} takes conditions of the same number: their values are its controller's own"
                self.work.lose(s, Fate.APPROXIMATED, "conditions", says)
                self.work.ask(
                    "give these welding conditions the values of the source's controller",
                    f"{other.process} {number}",
                )
                return replace(other.written(number), line=s.line, comment=s.comment)
        return None

    def _watched(self, s: st.Process, how: ex.Expression) -> list[st.Statement]:
        """What says that a routine runs as soon as a condition comes true."""
        call = dict(s.arguments).get("call")
        if isinstance(call, ex.CallValue):
            target = language_of(self.work.target)
            says = (
                f"{target} calls {call.routine} between its instructions, and no run here lets it happen: "
                "see that it does what it should"
            )
            self.work.lose(s, Fate.APPROXIMATED, "order", says)
            self.work.ask("see that what a signal starts at any time does what it should", call.routine)
        if how == ex.Text("named"):
            return [st.Comment(s.line, s.comment)] if s.comment else []
        return [s]

    def halts(self, routine: st.Routine) -> set[int]:
        """Lines that stop the arm and let it go on within a routine that a condition calls, where the target can."""
        known, watched = self.work.conventions, {call.routine.casefold() for call, _ in self.watched.values()}
        if not self.work.limits.watches or routine.name.casefold() not in watched:
            return set()
        words = (known.halting_process, known.starting_process)
        found = [s for s in routine.body if isinstance(s, st.Process) and s.name.casefold() in words]
        pairs = [s.name.casefold() for s in found] == list(words)
        return {s.line for s in found} if pairs else set()

    def halted(self, s: st.Process) -> list[st.Statement]:
        if s.name.casefold() == self.work.conventions.halting_process:
            return [st.Process(s.line, "BRAKE", (), s.comment)]
        says = f"{language_of(self.work.target)} lets the arm go on where the routine ends"
        self.work.lose(s, Fate.APPROXIMATED, "order", says)
        return [st.Comment(s.line, s.comment)] if s.comment else []

    def switched_off(self, routine: st.Routine, rows: list[st.Statement]) -> list[st.Statement]:
        """A routine that a condition calls once only, behind what switches that off."""
        for number, (call, once) in self.watched.items() if self.work.limits.watches else ():
            if once and call.routine.casefold() == routine.name.casefold():
                off = (("", ex.Text("")), (WATCH, ex.Text("off")), ("number", ex.Number(number)))
                at = next(
                    (n for n, s in enumerate(rows) if not isinstance(s, (st.Begin, st.Declare))), len(rows)
                )
                return [*rows[:at], st.Process(0, "interrupt", off), *rows[at:]]
        return rows

    def _manner_setting(self, s: st.Assign) -> str | None:
        """What a system variable says of how moves are made; None for another one, or where they end elsewhere."""
        known, base = self.work.conventions, base_of(s.target)
        manner = None if base is None else known.manner_settings.get(base.name.casefold())
        elsewhere = (
            isinstance(s.value, ex.Text) and s.value.value.upper() in known.move_options.ends_elsewhere
        )
        return None if elsewhere else manner

    def _manner(self, s: st.Statement, manner: str) -> st.Comment:
        says = f"{manner} is the controller's own there: a comment says what was set"
        self.work.lose(s, Fate.APPROXIMATED, "statement", says)
        return st.Comment(s.line, untranslated(self.program, s))

    def _idle_because(self, s: st.Statement) -> str | None:
        """Why a statement does nothing; None where it does something, or nobody knows."""
        known = self.work.conventions
        if isinstance(s, st.Call):
            name = s.routine.casefold()
            idle = known.idle_routines.get(name) if name not in self.defined else None
        elif isinstance(s, st.Process):
            idle = known.idle_processes.get(s.name.casefold())
        else:
            return self._idle_setting(s)
        return None if idle is None else f"{idle} takes no time and moves nothing"

    def _idle_setting(self, s: st.Statement) -> str | None:
        target = s.target if isinstance(s, st.Assign) else None
        base = base_of(s.target) if isinstance(s, st.Assign) else s if isinstance(s, st.Declare) else None
        is_held = base is not None and base.name in self.held
        if self.axes_stand and (
            is_held or (isinstance(target, ex.Member) and target.name.casefold() == _AXES)
        ):
            return "no axis beside the arm moves in this program: setting their values"
        if isinstance(s, st.Assign) and (what := self.settings.get(s.line)) is not None:
            return f"{what} moves nothing"
        if (
            isinstance(s, st.Opaque)
            and (s.text.split() or [""])[0].casefold() in self.work.conventions.idle_words
        ):
            return "a declaration of what is elsewhere does nothing"
        if isinstance(s, st.ShiftOff) and not self.shifts:
            return "no shift is on that could end here"
        return None

    def _foreign(self, s: st.Statement) -> st.Comment:
        self.work.lose(s, self._fate, "statement", foreign_word(self.program.vendor, self.work.target))
        self.lost.append(s)
        return st.Comment(s.line, untranslated(self.program, s))


def _with_names(e: ex.Expression) -> str:
    """A text that is put together with the names of what it shows."""
    if isinstance(e, ex.Text):
        return e.value
    if isinstance(e, ex.Function) and e.name == "joined-text":
        return "".join(map(_with_names, e.arguments))
    if (
        isinstance(e, ex.Binary)
        and e.operator == "+"
        and any(type(one) is ex.Text for one in expressions_of(e))
    ):
        return _with_names(e.left) + _with_names(e.right)
    if isinstance(e, ex.Function) and e.arguments:
        return _with_names(e.arguments[0])
    if isinstance(e, ex.Compare) and e.right == ex.SignalState(True):
        return _with_names(e.left)
    if isinstance(e, ex.Signal) and isinstance(e.index, ex.Number | ex.Text):
        return f"<{e.bus} {e.index.value}>"
    names: set[str] = set()
    note_names(st.Assign(0, ex.Named(""), e), names)
    if isinstance(e, ex.Number):
        return f"{e.value:g}"
    return f"<{' '.join(sorted(names - {''})) or '...'}>"


def _is_resolved(target: ex.Expression, resolved: Set[str], unresolved: Set[str]) -> bool:
    """Whether the reader has used what is assigned: one of `resolved`.

    `unresolved`: records, in capitals, whose members are read.
    """
    if isinstance(target, ex.Member) and isinstance(target.base, ex.Named):
        return target.base.name.upper() in resolved - unresolved
    return isinstance(target, ex.Named) and target.name.upper() in resolved - unresolved


def _read_records(look: Look) -> set[str]:
    """Those of the forms' records, in capitals, whose members a statement reads: the reader could not resolve them."""
    found: list[ex.Expression] = list(look.values)
    for _, s in look.rare:
        if type(s) is not st.Comment:
            gather(s.value if isinstance(s, st.Assign) else s, found)
    members = (e.base for e in found if type(e) is ex.Member)
    return {base.name.upper() for base in members if isinstance(base, ex.Named)}


def _idle_settings(
    program: st.Program, rare: Sequence[st.Statement], work: TranslationContext
) -> dict[int, str]:
    """Lines that set what moves nothing, and what that is: settings that nobody reads, to a number that does nothing.

    Less than the least number matters to blended moves alone.
    """
    known = work.conventions.idle_settings
    found: dict[str, dict[int, str]] = {}
    names: set[str] = set()  # of what is read
    for s in rare if known else ():
        name = s.target.name.casefold() if isinstance(s, st.Assign) and isinstance(s.target, ex.Named) else ""
        if isinstance(s, st.Assign) and name in known:
            what, least = known[name]
            value = s.value.on if isinstance(s.value, ex.SignalState) else getattr(s.value, "value", None)
            if isinstance(value, (int, float)) and (value >= least or not _blends(program)):
                found.setdefault(name, {})[s.line] = what
        else:
            note_names(s, names)
    for name in names:
        found.pop(name.casefold(), None)
    return {line: what for lines in found.values() for line, what in lines.items()}


def _blends(program: st.Program) -> bool:
    """Whether any move passes its end without a stop."""
    return any(
        type(s) is st.Move and (s.blend is None or s.blend.value is None or s.blend.value.literal != 0.0)
        for s in program.statements()
    )


def _idle(s: st.Statement, why: str, program: st.Program, work: TranslationContext) -> st.Comment:
    """A statement that does nothing, as a comment."""
    work.lose(s, Fate.EXACT, "statement", f"{why}: it is a comment there")
    return st.Comment(s.line, untranslated(program, s))


def data_comments(program: st.Program, work: TranslationContext, source: st.Program) -> st.Program:
    """Comments of data of `source` that no data of the translation carries become rows: at the head of the routine
    that has the data, of the main one for those of the file. What has a number has no line of its own; tools, frames,
    speeds and loads may be numbers, settings or nothing in the target.
    """
    carried = set() if work.limits.numbered else {_said(d) for d in program.declarations()}
    main = program.main or (program.routines[0].name if program.routines else "")
    heads: dict[str, list[st.Comment]] = {main: _lost_rows(source.data, carried)}
    inside: dict[str, list[st.Comment]] = {}
    names = {r.name for r in program.routines}
    for r in source.routines:
        home = r.name if r.name in names else main
        heads.setdefault(home, []).extend(_lost_rows(r.data, carried))
        inside.setdefault(home, []).extend(_lost_rows((s for s in r.body if type(s) is st.Declare), carried))
    if not any(heads.values()) and not any(inside.values()):
        return program
    routines = [
        replace(r, body=tuple(_with_rows(r, heads.get(r.name, []), inside.get(r.name, []))))
        for r in program.routines
    ]
    return replace(program, routines=tuple(routines))


def _said(d: st.Declare) -> tuple[int, tuple[str, ...], str]:
    return d.line, d.above, d.comment


def _lost_rows(
    given: Iterable[st.Declare], carried: set[tuple[int, tuple[str, ...], str]]
) -> list[st.Comment]:
    """A comment behind data has lost what it stood behind: the name goes before it."""
    rows = []
    for d in given:
        if _said(d) not in carried:
            rows += [st.Comment(d.line, text) for text in d.above]
            rows += [st.Comment(d.line, f" {d.name}: {d.comment.strip()}")] if d.comment else []
    return rows


def _with_rows(
    routine: st.Routine, head: list[st.Comment], inside: list[st.Comment]
) -> Iterator[st.Statement]:
    """`head` behind the routine's beginning, each of `inside` before the first statement of its line or behind it."""
    waiting = [*inside]
    if not any(type(s) is st.Begin for s in routine.body):
        yield from head
        head = []
    for s in routine.body:
        while waiting and s.line >= waiting[0].line:
            yield waiting.pop(0)
        if type(s) is st.End:
            yield from waiting
            waiting = []
        yield s
        if type(s) is st.Begin:
            yield from head
            head = []
    yield from waiting


def comment_texts(program: st.Program, work: TranslationContext) -> st.Program:
    """Comments and messages in characters that the target takes, comments in lines that it keeps whole."""
    if not work.limits.comment and not work.limits.comment_swaps and not work.limits.message:
        return program
    routines = []
    for routine in program.routines:
        rows: list[st.Statement] = []
        for s in routine.body:
            if isinstance(s, st.Comment):
                rows += [replace(s, text=part) for part in _lines(s.text, work)]
            else:
                rows += _with_legal_texts(s, work)
        routines.append(replace(routine, body=tuple(rows)))
    return replace(program, routines=tuple(routines))


_LOOKS: Final = ("match-in-text", "find-in-text", "position-in-text", "code-of-character")
_TELLS: Final = (st.Assign, st.Message, st.Call, st.Return, st.Declare)


def plain_texts(program: st.Program, work: TranslationContext) -> st.Program:
    """Texts without the quotes and control characters that the target has none for, where nothing asks for them."""
    quote = work.limits.text_quote
    if not quote:
        return program
    odd = any(
        isinstance(e, ex.Text) and _is_odd(e.value, quote)
        for r in program.routines
        for e in work.look(r).expressions
    ) or any(
        isinstance(e, ex.Text) and _is_odd(e.value, quote) for d in program.data for e in expressions_of(d)
    )
    if not odd and not any(r.data for r in program.routines):
        return program
    asked: set[str] = set()
    for s in program.statements():
        for e in () if calls_nothing(s) else expressions_of(s):
            if isinstance(e, ex.Compare) or (isinstance(e, ex.Function) and e.name in _LOOKS):
                note_names(st.Assign(0, ex.Named(""), e), asked)
        if isinstance(s, st.Switch):
            note_names(s, asked)

    def row(s: Any) -> Any:
        base = base_of(s.target) if isinstance(s, st.Assign) else s if isinstance(s, st.Declare) else None
        if not isinstance(s, _TELLS) or calls_nothing(s) or (base is not None and base.name in asked):
            return s
        found = list(expressions_of(s))
        if not any(isinstance(e, ex.Text) and _is_odd(e.value, quote) for e in found) or any(
            isinstance(e, ex.Compare) or (isinstance(e, ex.Function) and e.name in _LOOKS) for e in found
        ):
            return s
        says = f"a text without line ends and other control characters, and with other quotes than {quote}"
        work.lose(s, Fate.APPROXIMATED, "text", says)
        return mapped(s, lambda e: ex.Text(_plain_text(e.value, quote)) if isinstance(e, ex.Text) else e)

    routines = tuple(
        replace(r, body=tuple(map(row, r.body)), data=tuple(map(row, r.data))) for r in program.routines
    )
    return replace(program, routines=routines, data=tuple(map(row, program.data)))


def _is_odd(text: str, quote: str) -> bool:
    return quote in text or not text.isprintable()


def _plain_text(text: str, quote: str) -> str:
    other = "'" if quote == '"' else '"'
    return "".join(c for c in text.replace(quote, other) if c.isprintable())


def _long_head(s: st.Message, work: TranslationContext) -> list[st.Statement]:
    """A message whose first text is longer than the target's are, as several; none where it is not."""
    from textwrap import wrap

    room, said = work.limits.message, s.text
    if not (room and isinstance(said, ex.Function) and said.name == "joined-text"):
        return []
    head, *more = said.arguments
    if not isinstance(head, ex.Text) or len(head.value) <= room or head.value.isspace():
        return []
    work.note_at(s, f"a message of more than {room} characters: several are written")
    *firsts, last = wrap(head.value, room - 1)
    last += head.value[len(head.value.rstrip()) :][:1]
    parts: list[st.Statement] = [replace(s, text=ex.Text(part), comment="") for part in firsts]
    return [*parts, replace(s, text=ex.Function(said.name, (ex.Text(last), *more)))]


def long_texts(program: st.Program, work: TranslationContext) -> st.Program:
    """Tells where a text that the program joins may have more characters than the target's variables hold."""
    room, declared = work.limits.longest_text, work.limits.texts_by_statement
    most = work.conventions.longest_text or math.inf
    if work.source.vendor == work.target or not (declared or 0 < room < most):
        return program
    told: set[int] = set()
    for s, length in text_lengths(program):
        length = min(length, most)
        fits = not math.isinf(length) if declared else length <= room
        if fits or s.line in told or type(s) is not st.Assign or type(s.value) is not ex.Function:
            continue
        told.add(s.line)
        may = "more characters with each pass" if math.isinf(length) else f"up to {length:g} characters"
        has = "as many as their declaration says" if declared else f"{room} at most"
        says = f"the text may have {may}: {language_of(work.target)}'s variables hold {has}"
        work.lose(s, Fate.APPROXIMATED, "text", says)
    return program


def _with_legal_texts(s: st.Statement, work: TranslationContext) -> list[st.Statement]:
    """The statement; before it its comment, where that is too long to stand behind it."""
    said: Any = s
    if isinstance(s, st.Message) and isinstance(s.text, ex.Text):
        legal, room = _legal(s.text.value, work), work.limits.message
        if room and len(legal) > room and not legal.isspace():
            from textwrap import wrap

            work.note_at(s, f"a message of more than {room} characters: several are written")
            parts: list[st.Statement] = [
                replace(s, text=ex.Text(part), comment="") for part in wrap(legal, room)
            ]
            return [*parts[:-1], *_with_legal_texts(replace(s, text=ex.Text(wrap(legal, room)[-1])), work)]
        said = replace(s, text=ex.Text(legal[:room] if room else legal))
    comment = getattr(s, "comment", "")
    if not comment or isinstance(s, st.Case):
        return [said]
    lines = _lines(comment, work)
    if len(lines) == 1:
        return [said if lines[0] == comment else replace(said, comment=lines[0])]
    return [*(st.Comment(s.line, part) for part in lines), replace(said, comment="")]


def _lines(text: str, work: TranslationContext) -> list[str]:
    """A comment in the lines of the target. Where these are short, the blank that many write behind the sign for a
    comment is left out, as people do there."""
    legal, room = _legal(text, work), work.limits.comment
    if room and legal[:1] == " " != legal[1:2]:
        legal = legal[1:]
    if not room or len(legal) <= room:
        return [legal]
    from textwrap import wrap

    return wrap(legal, room)


def _legal(text: str, work: TranslationContext) -> str:
    for old, new in work.limits.comment_swaps.items():
        if old in text:
            work.note_once(f"{old!r} ends a line there: in comments and messages it is written as {new!r}")
            text = text.replace(old, new)
    return text


def _tables_stand(program: st.Program, work: TranslationContext) -> bool:
    """Whether no position says anything of an axis beside the arm but zero."""
    if any(v == v and v not in (0.0, NOT_CONNECTED) for e in work.literals(program) for v in e.external):
        return False
    for table in (routine.points for routine in program.routines):
        for (store, taught), block in table.blocks.items():
            points = (
                [table.find(store, taught, row) for row in block.rows] if store is not ex.Store.ROBOT else []
            )
            if any(value for point in points if point is not None for value in point.values):
                return False
    return True


def _may_name_arm(s: st.Statement) -> bool:
    """Whether a computed position of a statement may say more than where the tool is."""
    if isinstance(s, st.Move):
        if len(s.targets) == 1:
            return type(s.targets[0]) is ex.Function or type(s.via) is ex.Function
        return any(type(e) is ex.Function for e in (*s.targets, s.via))
    return isinstance(s, (st.Assign, st.Call, st.Return))


def _watched(rare: Sequence[st.Statement]) -> Iterator[tuple[int, tuple[ex.CallValue, bool]]]:
    for s in rare:
        given = dict(s.arguments) if isinstance(s, st.Process) else {}
        call, number = given.get("call"), given.get("number")
        if WATCH in given and isinstance(call, ex.CallValue) and isinstance(number, ex.Number):
            yield int(number.value), (call, given.get(ONCE) == ex.SignalState(True))


def _sets_axes(s: st.Statement, held: Set[str]) -> bool:
    """Whether a statement gives axes beside the arm values of its own, or declares such."""
    if isinstance(s, st.Declare):
        return s.name in held and (bool(s.sizes) or not (s.value is None or _stands_at_zero(s.value, held)))
    base = base_of(s.target) if isinstance(s, st.Assign) else None
    if isinstance(s, st.Assign) and base is not None and base.name in held:
        return s.target is not base or not _stands_at_zero(s.value, held)
    if isinstance(s, st.Assign) and isinstance(s.target, ex.Member) and s.target.name in _EACH_AXIS:
        return True
    return _may_name_arm(s) and _names_axes(s, held)


def _names_axes(s: st.Statement, held: Set[str]) -> bool:
    """Whether a computed position says where an axis beside the arm stands, other than at zero."""
    return any(
        isinstance(e, ex.NamedArgument) and e.name == "axes" and not _stands_at_zero(e.value, held)
        for e in expressions_of(s)
    )


def _stands_at_zero(axes: ex.Expression | None, held: Set[str]) -> bool:
    """Whether axes beside the arm are given as zero, as not connected, or as those of another position.

    `held`: variables that hold such values alone.
    """
    if isinstance(axes, ex.Named):
        return axes.name in held
    if not isinstance(axes, ex.RecordLiteral):
        return isinstance(axes, ex.Member)
    return all(
        one.value in (0, NOT_CONNECTED) if isinstance(one, ex.Number) else isinstance(one, ex.Member)
        for _, one in axes.members
    )


def _without_options(s: st.Move, work: TranslationContext, manner: Set[str]) -> st.Move:
    """Options of a move that olp keeps without understanding stand in its comment."""
    options = work.conventions.move_options
    said = [name for name, value in s.other if not _is_harmless(name, value, options)]
    if not said:
        return replace(s, other=())
    named = next((name for name in said if name.casefold() in options.processes), "")
    if named and all(_word(name) in options.process_options for name in said if name and name != named):
        says = f"{named}: {options.processes[named.casefold()]} is left out, the move alone is made"
        work.lose(s, Fate.APPROXIMATED, PROCESS, says)
        text = " ".join([*([s.comment] if s.comment else []), f"[{named}]"])
        return replace(s, other=(), comment=text)
    texts = [
        f"{name} {value.value}" if isinstance(value, ex.Text) else name
        for name, value in s.other
        if name in said
    ]
    words = [name.rpartition("\\")[2] for name in said if name]
    which = f"the options {', '.join(words)} mean" if len(words) > 1 else f"the option {words[0]} means"
    says = f"{which} nothing in {language_of(work.target)}"
    ends_elsewhere = any(
        isinstance(value, ex.Text) and value.value.upper() in options.ends_elsewhere for _, value in s.other
    )
    if ends_elsewhere or not all(word.casefold() in manner for word in words):
        work.lose(s, Fate.REFUSED, "statement", f"{says}, and the move without it is another one")
        return replace(s, other=())
    work.lose(s, Fate.APPROXIMATED, "option", says)
    silent = options.silent
    shown = [text for text in texts if not (silent and text.startswith(silent))]
    return replace(s, other=(), comment=" ".join([*([s.comment] if s.comment else []), *_bracketed(shown)]))


def _word(option: str) -> str:
    return option.rpartition("\\")[2].casefold()


def _is_harmless(name: str, value: ex.Expression, options: MoveOptions) -> bool:
    """Whether an option of a move says nothing of where it ends and what happens on the way."""
    word = _word(name)
    return word in options.harmless or (
        type(value) is ex.Named and value.name.casefold() in options.harmless_values.get(word, ())
    )


def _bracketed(words: list[str]) -> list[str]:
    return [f"[{' '.join(words)}]"] if words else []


def untranslated(program: st.Program, s: st.Statement) -> str:
    """The comment that stands where a statement of the source cannot."""
    text = program.source.line(s.line).strip().rstrip("; ") if s.line else ""
    return f"not translated: {text or terminology.statement(s)}"


# --- Variables that an instruction sets which olp keeps as written ---
# RAPID's `TPReadNum answer,"Which row?"`. No more is known of it than its text. Where it becomes a comment, what it
# names is no constant all the same: the person who puts another instruction in its place sets it.


_FIRST: Final[Mapping[str, ex.Expression]] = {
    **dict.fromkeys(("real", "integer"), ex.Number(0)),
    "boolean": ex.SignalState(False),
    "string": ex.Text(""),
}
_QUOTED: Final = re.compile(r'"[^"]*"')
_WORD: Final = re.compile(r"[A-Za-z_]\w*")


def set_elsewhere(program: st.Program, lost: Iterable[st.Statement], work: TranslationContext) -> st.Program:
    """The program that has lost these instructions: what they name begins by an assignment, its users are told."""
    lines: dict[str, int] = {}
    for s in lost:
        for word in _words(s) if isinstance(s, st.Process) else ():
            lines.setdefault(word, s.line)
    if not lines:
        return program
    main = program.main or program.routines[0].name
    shared = {d.name: d for d in program.data}
    routines = []
    for r in program.routines:
        local = {s.name: s for s in r.body if isinstance(s, st.Declare)}
        given = _given({**shared, **local}, lines)
        _tell(program, r, given, work)
        begun = [d for d in given if d.name in local or r.name == main or r.starts]
        routines.append(_begun(r, begun) if begun else r)
    return replace(program, routines=tuple(routines))


def _words(s: st.Process) -> set[str]:
    texts = [value.value for _, value in s.arguments if isinstance(value, ex.Text)]
    return {word.casefold() for text in texts for word in _WORD.findall(_QUOTED.sub("", text))}


def _given(declared: Mapping[str, st.Declare], lines: Mapping[str, int]) -> dict[st.Declare, int]:
    """The variables that lost instructions name, each with the line of the first one."""
    return {
        d: lines[name.casefold()]
        for name, d in declared.items()
        if name.casefold() in lines and d.storage != "constant"
    }


def _first_value(d: st.Declare) -> ex.Expression | None:
    """What a number, a truth value or a text holds at first; None for other data."""
    value = _FIRST.get(d.type) if d.value is None and not d.sizes else d.value
    return value if isinstance(value, (ex.Number, ex.SignalState, ex.Text)) else None


def _begun(r: st.Routine, given: Iterable[st.Declare]) -> st.Routine:
    at = next((n for n, s in enumerate(r.body) if not isinstance(s, (st.Begin, st.Declare))), len(r.body))
    first = [(d, _first_value(d)) for d in given if d.storage == "variable"]
    rows = [st.Assign(d.line, ex.Named(d.name), value) for d, value in first if value is not None]
    return replace(r, body=(*r.body[:at], *rows, *r.body[at:]))


def _tell(
    program: st.Program, r: st.Routine, given: Mapping[st.Declare, int], work: TranslationContext
) -> None:
    lines = {d.name: line for d, line in given.items()}
    for s in r.body if lines else ():
        if (calls_nothing(s) and not isinstance(s, st.Move)) or isinstance(s, st.Declare):
            continue
        names: set[str] = set()
        note_names(s, names)
        for name in sorted(names & lines.keys()) if s.line not in lines.values() else ():
            setting = program.source.line(lines[name]).strip()
            says = f"it needs {name}, which '{setting}' sets in a way that the target cannot"
            work.lose(s, Fate.APPROXIMATED, "value", says)
