"""Lowers clauses: one short method per rule of grammars/rapid.lark; statements, or what frames them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final, NamedTuple

from lark import Token

from olp.ir import program as st
from olp.ir.expressions import CallValue, Expression, FrameRef, Function, Member, Named, Text, Unknown
from olp.languages.lark_host import BrokenLineError
from olp.languages.statement_rules import BlockWords
from olp.languages.vendor import ENDS_CYCLE
from olp.languages.vendors.rapid import interrupts, literals
from olp.languages.vendors.rapid.expressions import RapidExpressionRules
from olp.languages.vendors.rapid.instructions import ACTS, BESIDE, RULES
from olp.languages.vendors.rapid.known_routines import CALLED, REPLACEABLE
from olp.languages.vendors.rapid.literals import RapidAggregate
from olp.languages.vendors.rapid.moves import LAYOUTS, lower_move
from olp.languages.vendors.rapid.predefined_data import INTERRUPTS, PROCESS, TYPES


class FramingClause(NamedTuple):
    """A clause that frames others: module, routine, record, handler and their ends. `word`: MODULE, ENDPROC …"""

    word: str
    name: str = ""
    attributes: tuple[str, ...] = ()
    local: bool = False
    returns: str = ""
    parameters: tuple[st.Parameter, ...] = ()


# Whether the arm's configuration is watched; along lines it is kept either way.
_WATCHES: Final = ("confj", "confl")
_ON: Final = re.compile(r"\\\s*On\b", re.IGNORECASE)
_OFF: Final = re.compile(r"\\\s*Off\b", re.IGNORECASE)
COMPACT: Final = "compact"  # spelling of `IF c instruction;`
_CONDITIONAL: Final = (st.Jump, st.Call, st.Return, st.Pause)


class ClauseRules(RapidExpressionRules, BlockWords):
    """`raw` is the clause that is read; `main`: whether it stands in the PROC main; `starred`: a `*` was a target."""

    def __init__(self) -> None:
        super().__init__()
        self.raw = ""
        self.main = False

    def clause(self, children: list[Any]) -> FramingClause | list[st.Statement]:
        found: FramingClause | list[st.Statement] | st.Statement = children[0]
        return found if isinstance(found, (FramingClause, list)) else [found]

    # --- frames -----------------------------------------------------------------------------------------------

    def module(self, children: list[Any]) -> FramingClause:
        return FramingClause(
            "MODULE", str(children[1]), tuple(str(one) for one in children[2:] if one is not None)
        )

    def attribute(self, children: list[Token]) -> str:
        return children[0].upper()

    def end_module(self, children: list[Any]) -> FramingClause:
        return FramingClause("ENDMODULE")

    def data(self, children: list[Any]) -> st.Declare:
        scope = children[0].upper() if children[0].type == "SCOPE" else ""
        storage, kind, name, sizes, value = children[1:] if scope else children
        native = str(kind).lower()
        stored = None
        if value is not None:
            stored = self.coerce(value, native, len(sizes or ()))
        elif storage.upper() == "VAR":
            stored = literals.zero(native, self.names, tuple(sizes or ()))
        resolved = self.names.resolved(native)
        return st.Declare(
            0,
            self.names.spelled(str(name)),
            TYPES.get(resolved, native),
            stored,
            tuple(sizes or ()),
            _STORAGE[storage.upper()],
            scope != "LOCAL",
            f"{'TASK ' if scope == 'TASK' else ''}{kind}",
        )

    def alias(self, children: list[Token]) -> FramingClause:
        return FramingClause("ALIAS", str(children[-1]))

    def record(self, children: list[Token]) -> FramingClause:
        return FramingClause("RECORD", str(children[-1]))

    def end_record(self, children: list[Any]) -> FramingClause:
        return FramingClause("ENDRECORD")

    def component(self, children: list[Token]) -> FramingClause:
        return FramingClause("COMPONENT", str(children[1]))

    def proc(self, children: list[Any]) -> FramingClause:
        return self._routine("PROC", children)

    def func(self, children: list[Any]) -> FramingClause:
        return self._routine("FUNC", children)

    def trap(self, children: list[Any]) -> FramingClause:
        return self._routine("TRAP", [*children, None])

    def _routine(self, word: str, children: list[Any]) -> FramingClause:
        local = children[0].type == "SCOPE"
        *names, parameters = children[1:] if local else children
        returns = str(names[0]).lower() if len(names) > 1 else ""
        name = self.names.spelled(str(names[-1]))
        return FramingClause(word, name, (), local, returns, tuple(parameters or ()))

    def parameters(self, children: list[Any]) -> list[st.Parameter]:
        """What stands behind | takes the place of the one before, so it is optional as well."""
        found: list[st.Parameter] = []
        for place, child in enumerate(children):
            if isinstance(child, st.Parameter):
                instead = place > 0 and isinstance(children[place - 1], Token)
                native = f"| {child.native}" if instead else child.native
                found.append(replace(child, optional=child.optional or instead, native=native))
        return found

    def parameter(self, children: list[Any]) -> st.Parameter:
        tokens = [child for child in children if isinstance(child, Token)]
        kinds = [token.type for token in tokens]
        words = [str(token) for token in tokens if token.type == "NAME"]
        passing = next((token.upper() for token in tokens if token.type == "PASSING"), "")
        kind, name = words[0], words[1]
        stars = kinds.count("STAR")
        optional = "BACKSLASH" in kinds
        usual = FrameRef("base") if optional and kind.lower() == "wobjdata" and not stars else None
        native = f"{passing} {kind}".strip() + ("{" + ",".join("*" * stars) + "}" if stars else "")
        return st.Parameter(
            self.names.spelled(name),
            TYPES.get(self.names.resolved(kind.lower()), kind.lower()),
            passing in ("INOUT", "VAR", "PERS", "REF"),
            optional,
            kind.lower() == "switch",
            usual,  # \WObj?WObj hands on wobj0 where it is not given
            native,
            (Unknown(""),) * stars,
        )

    def end_routine(self, children: list[Token]) -> FramingClause:
        return FramingClause(children[0].upper())

    def handler(self, children: list[Any]) -> FramingClause:
        return FramingClause("HANDLER", self.raw.split("(")[0].strip().upper())

    def placeholder(self, children: list[Token]) -> st.Opaque:
        return st.Opaque(0, str(children[0]))

    # --- blocks -----------------------------------------------------------------------------------------------

    def for_(self, children: list[Any]) -> st.For:
        name, start, stop, step = children
        counted = Named(self.names.spelled(str(name)))
        return st.For(
            0, counted, self.plain(start), self.plain(stop), None if step is None else self.plain(step)
        )

    def label(self, children: list[Token]) -> st.Label:
        return st.Label(0, self.names.spelled(str(children[0])))

    # --- instructions -----------------------------------------------------------------------------------------

    def compact_if(self, children: list[Any]) -> list[st.Statement]:
        condition, found = self.plain(children[0]), children[1]
        inner: list[st.Statement] = found if isinstance(found, list) else [found]
        if len(inner) == 1 and isinstance(inner[0], _CONDITIONAL):
            return [replace(inner[0], condition=condition)]
        return [st.If(0, condition, spelling=COMPACT), *inner, st.EndIf(0)]

    def target(self, children: list[Any]) -> tuple[str, list[Any]]:
        return str(children[0]), children[1:]

    def assign(self, children: list[Any]) -> st.Assign | st.Process:
        (name, postfixes), value = children
        base: Expression = Named(self.names.spelled(name))
        last = postfixes[-1].lower() if postfixes and isinstance(postfixes[-1], str) else ""
        if any(isinstance(one, str) and one.lower() == "robconf" for one in postfixes):
            return self._process("robconf", " ".join(self.raw.removesuffix(";").split()))
        if last in ("trans", "rot"):
            place = self.parts(base, postfixes[:-1])
            if literals.type_of(place, self.names) in ("robtarget", "pose", ""):
                return st.Assign(0, place, self._partly(place, last, value))
        if last == "robax":
            whole = self.parts(base, postfixes[:-1])
            if literals.type_of(whole, self.names) == "jointtarget":
                return st.Assign(0, whole, self._axes(value))
        if last == "extax":
            return st.Assign(
                0, Member(self.parts(base, postfixes[:-1]), postfixes[-1]), self.coerce(value, "extjoint")
            )
        target = self.parts(base, postfixes)
        kind = literals.type_of(target, self.names)
        sizes = self.names.arrays.get(name.lower(), 0) if isinstance(target, Named) else 0
        return st.Assign(0, target, self.coerce(value, kind, sizes))

    def _axes(self, value: Expression | RapidAggregate) -> Function:
        """`j.robax := …` as whole new joint values."""
        try:
            return Function("joints", literals.joint_parts(value))
        except literals.ShapeError as wrong:
            raise BrokenLineError(str(wrong), word="[") from None

    def _partly(self, place: Expression, part: str, value: Expression | RapidAggregate) -> Function:
        """`p.trans := …` and `p.rot := …` as a whole new pose; the other part stays."""
        try:
            if part == "trans":
                return Function("pose-angles", (*literals.place_parts(value), *literals.turn_parts(place)))
            if isinstance(value, RapidAggregate) and literals.numbers(value, 4) is None:
                found = (*literals.place_parts(place), *literals.plain_items(value))
                return Function("pose-quaternion", found)
            return Function("pose-angles", (*literals.place_parts(place), *literals.turn_parts(value)))
        except literals.ShapeError as wrong:
            raise BrokenLineError(str(wrong), word="[") from None

    def instruction(self, children: list[Any]) -> list[st.Statement] | st.Statement:
        token, given = children[0], children[1] or []
        name, key = str(token), token.lower()
        if key not in self.names.routines:
            if key == ENDS_CYCLE and self.main:
                return st.Return(0, spelling=name)
            if key in LAYOUTS:
                return lower_move(self, name, given)
            raw = self._behind(token)
            if key in RULES:
                found = RULES[key](self, name, given)
                return (
                    self._process(name, raw)
                    if found is None
                    else [self._exact(one, name, raw) for one in found]
                )
            if key in _WATCHES:
                kept = st.Disabled(0, f"{name} {raw};")
                on = _ON.search(raw)
                if key != "confj" or (on is None and _OFF.search(raw) is None):
                    return kept
                obeyed: list[st.Statement] = [st.ObeyFlags(0, on is not None), kept]
                return obeyed
            if key in INTERRUPTS:
                return interrupts.ordered(f"{name} {raw}".strip(), key, given)
            if key in PROCESS:
                process = self._process(name, raw)
                if key not in REPLACEABLE:
                    return process
                called = CallValue(name, self.passed(name, given))
                return replace(process, arguments=(*process.arguments, (CALLED, called)))
        return st.Call(0, self.names.spelled(name), self.passed(name, given))

    def _process(self, name: str, raw: str) -> st.Process:
        return st.Process(0, name, (("", Text(raw)),) if raw else ())

    def _exact(self, statement: st.Statement, name: str, raw: str) -> st.Statement:
        if isinstance(statement, st.Process) and statement.name == BESIDE:
            what = [value.value for _, value in statement.arguments if isinstance(value, Text)]
            acts = any(key == ACTS for key, _ in statement.arguments)
            return st.Disabled(0, f"{name} {raw};", beside="".join(what), acts=acts)
        if isinstance(statement, st.Process) and statement.name == name and statement.arguments:
            return replace(statement, arguments=(("", Text(raw)), *statement.arguments))
        return statement

    def _behind(self, token: Token) -> str:
        """The arguments of an instruction as written, in one line."""
        text = self.raw[token.end_pos or 0 :].strip()
        return " ".join(text.removesuffix(";").split("\n")).strip()

    def late_binding(self, children: list[Any]) -> st.Statement:
        value, given = children
        if isinstance(value, Text) and value.value.isidentifier():
            name = self.names.spelled(value.value)
            return st.Call(0, name, self.passed(name, given or []), spelling="%")
        text = self.raw[self.raw.index("%") :].removesuffix(";").strip()
        return st.Process(0, "call", (("", Text(text)),))

    def goto(self, children: list[Token]) -> st.Jump:
        return st.Jump(0, self.names.spelled(str(children[0])))

    def return_(self, children: list[Any]) -> st.Return:
        return st.Return(0, None if children[0] is None else self.coerce(children[0], self.returns))

    returns = ""  # the type of the function that is read

    def raise_(self, children: list[Any]) -> st.Process:
        return self._word("RAISE")

    def exit_(self, children: list[Any]) -> st.Statement:
        return st.Return(0, spelling="EXIT") if self.main else st.Process(0, "EXIT")

    def retry(self, children: list[Any]) -> st.Process:
        return st.Process(0, "RETRY")

    def trynext(self, children: list[Any]) -> st.Process:
        return st.Process(0, "TRYNEXT")

    def connect(self, children: list[Any]) -> st.Process:
        kept = self._word("CONNECT", interrupts.NAME)
        (name, postfixes), trap = children[0], children[-1]
        text = kept.arguments[0][1]
        assert isinstance(text, Text)
        return kept if postfixes else interrupts.connected(text.value, name, str(trap))

    def _word(self, word: str, name: str = "") -> st.Process:
        """An instruction kept as written from its word on."""
        start = self.raw.upper().index(word)
        text = " ".join(self.raw[start:].removesuffix(";").split())
        return self._process(name, text) if name else self._process(word, text[len(word) :].strip())


_STORAGE: Final = {"CONST": "constant", "PERS": "persistent", "VAR": "variable"}


def at_line(statements: Sequence[st.Statement], line: int) -> list[st.Statement]:
    """Copies of statements that were read in another line."""
    return [replace(one, line=line) for one in statements]
