"""What KUKA's own functions do: those of the message library (`MsgLib.src` of the System folder), and VARSTATE.

MsgNotify shows a message, and so does MsgLoop. MsgState shows one until Clear_KrlMsg takes its handle, a number above
zero, and returns TRUE. MsgQuit shows one and waits until the operator has acknowledged it: its loop asks
`Exists_KrlMsg`. What is assigned to $LOOP_MSG[] is shown while the program goes on. Texts may be keys of the
controller's message database; `%1` stands for the number, else the text, that is handed over.

Set_KrlMsg shows the text of a record of the type KRLMSG_T, with `%1` to `%3` replaced by records of KRLMSGPAR_T, and
returns a handle; Exists_KrlMsg tells whether the message still stands ("User messages", KSS 8, programming
instructions for system integrators).
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

from olp.ir.expressions import (
    CallValue,
    Compare,
    Expression,
    Function,
    Item,
    Logic,
    Member,
    Named,
    Number,
    RecordLiteral,
    Signal,
    SignalState,
    SystemValue,
    Text,
    Unary,
    Unknown,
)
from olp.ir.program import Program, Routine
from olp.ir.statements import (
    Assign,
    Call,
    Case,
    Comment,
    Declare,
    Default,
    Dwell,
    Else,
    ElseIf,
    EndIf,
    EndSwitch,
    EndWhile,
    If,
    Message,
    Pause,
    Process,
    SetOutput,
    Statement,
    Switch,
    Wait,
    While,
)
from olp.ir.transformer import calls_nothing, expressions_of, mapped, sets_numbers
from olp.languages.vendor import ACKNOWLEDGED
from olp.languages.vendors.krl.scope import MODES, NEUTRAL_TYPES

_SHOWS: Final = frozenset({"msgnotify", "msgquit", "msgloop", "msgstate"})
_CLEARS: Final = "clear_krlmsg"
_WINDOW: Final = "$LOOP_MSG"
_PLACE: Final = "%1"
_OMITTED: Final = Unknown("")
_NOTHING: Final = Text(" ")  # what the window shows when its text is cleared


def without_library(
    body: Sequence[Statement], find: Callable[[str], Routine | None]
) -> tuple[Statement, ...]:
    """The statements with those of the message library as messages and pauses.

    `find`: a routine of the program by its name, None for one that is not here or is KUKA's.
    """
    return tuple([one for s in body for one in _plain(s, find)])


def _plain(s: Statement, find: Callable[[str], Routine | None]) -> tuple[Statement, ...]:
    if type(s) is Call and s.routine.casefold() in _SHOWS and s.condition is None and find(s.routine) is None:
        word = s.routine.casefold()
        handle = s.arguments[0] if word == "msgstate" and s.arguments else None
        text = _shown(s.arguments[1:] if word == "msgstate" else s.arguments)
        if text is None:
            return (s,)
        shown = Message(s.line, text, s.comment)
        if word == "msgquit":
            return (shown, Pause(s.line, spelling=ACKNOWLEDGED))
        return (shown,) if handle is None else (shown, Assign(s.line, handle, Number(1)))
    if type(s) is Call and _starts_option(s) and find(s.routine) is None:
        return (Process(s.line, "option-start", (), s.comment),)
    if type(s) is Assign and _takes_handle(s.value) and find(_CLEARS) is None:
        return (Message(s.line, _NOTHING, s.comment), Assign(s.line, s.target, SignalState(True)))
    if type(s) is Wait and _takes_handle(_without_true(s.condition)) and find(_CLEARS) is None:
        return (Message(s.line, _NOTHING, s.comment),)
    if type(s) is Assign and _is_window(s.target):
        return (Message(s.line, s.value, s.comment),)
    if type(s) is Wait and _clears(s.condition):
        return (Message(s.line, _NOTHING, s.comment),)
    return (s,)


def _starts_option(s: Call) -> bool:
    """What the INI fold of each program calls: `USER_GRP(0,…)`, `USERSPOT(#INIT)`, `A20_INI()`."""
    match s.routine.casefold(), s.arguments:
        case ("user_grp", (Number(0), *_)) | ("userspot", (Text("#INIT"), *_)):
            return True
        case (("a10_ini" | "a20_ini"), ()):
            return True
    return False


def _shown(arguments: tuple[Expression, ...]) -> Expression | None:
    """The text with what it names filled in, None where that is not written out."""
    text, _, number, words = (*arguments, *[_OMITTED] * 4)[:4]
    if type(text) is not Text or _PLACE not in text.value:
        return None if text == _OMITTED else text
    if number == words == _OMITTED:
        return None
    before, _, behind = text.value.partition(_PLACE)
    value = words if number == _OMITTED else Function("text-of-value", (number,))
    parts = (*([Text(before)] if before else []), value, *([Text(behind)] if behind else []))
    return Function("joined-text", parts)


def _is_window(e: Expression) -> bool:
    """`$LOOP_MSG[]`"""
    return type(e) is Item and type(e.base) is Named and e.base.name.upper() == _WINDOW


def _without_true(e: Expression) -> Expression:
    """What `e OR TRUE` asks beside what it does: a wait for it calls the function and goes on."""
    if type(e) is Logic and e.rest == (("or", SignalState(True)),):
        return e.first
    return e


def _takes_handle(e: Expression) -> bool:
    """`Clear_KrlMsg(handle)`"""
    return type(e) is CallValue and e.routine.casefold() == _CLEARS and len(e.arguments) == 1


def _clears(condition: Expression) -> bool:
    """`StrClear($LOOP_MSG[])`, which is always true."""
    return (
        isinstance(condition, CallValue)
        and condition.routine.casefold() == "strclear"
        and len(condition.arguments) == 1
        and _is_window(condition.arguments[0])
    )


# --- Handed parameters ---
# `VARSTATE("P") == #INITIALIZED`: whether a routine was handed a parameter, as the calls of the program tell it.
#
# VARSTATE tells #DECLARED, #INITIALIZED or #UNKNOWN of a variable; a parameter that a call leaves out is not
# initialized until the routine sets it (KSS 8, programming instructions for system integrators, "VARSTATE()").


_ASKS: Final = "varstate"
_GIVEN: Final = "#INITIALIZED"


def with_given_parameters(program: Program) -> Program:
    """The program with what all its calls decide alike as TRUE or FALSE."""
    if not any(map(_is_asked, program.statements())):
        return program
    calls: dict[str, list[tuple[Expression, ...]]] = {}
    for s in program.statements():
        for routine, arguments in _calls(s):
            calls.setdefault(routine.casefold(), []).append(arguments)
    valued = {d.name.casefold() for d in program.data if d.value is not None}
    routines = tuple(_decided(r, calls.get(r.name.casefold(), []), valued) for r in program.routines)
    return replace(program, routines=routines)


def _decided(routine: Routine, calls: list[tuple[Expression, ...]], valued: set[str]) -> Routine:
    """`valued`: data of the program that a list gives a value; a routine that nothing calls is handed all."""
    if not any(map(_is_asked, routine.body)):
        return routine
    given: dict[str, set[bool]] = {name: {True} for name in valued}
    for at, p in enumerate(routine.parameters):
        given[p.name.casefold()] = {at < len(one) and type(one[at]) is not Unknown for one in calls} or {True}

    def change(e: Expression) -> Expression:
        if type(e) is Unary and e.operator == "not" and type(e.operand) is SignalState:
            return SignalState(not e.operand.on)
        if not (type(e) is Compare and e.operator in ("=", "<>")):
            return e
        match e.left, e.right:
            case CallValue(name, (Text(of),)), Text(state) if name.casefold() == _ASKS:
                known = {True} if of.startswith("$") else given.get(of.casefold(), set())
                if state.upper() == _GIVEN and len(known) == 1:
                    return SignalState((True in known) == (e.operator == "="))
        return e

    rows: list[Statement] = []
    for s in routine.body:
        rows.append(mapped(s, change) if _is_asked(s) else s)
        if isinstance(s, Assign) and isinstance(s.target, Named) and s.target.name.casefold() in given:
            given[s.target.name.casefold()].add(True)  # from here on some way may have set it
    return replace(routine, body=tuple(rows))


def _is_asked(s: Statement) -> bool:
    return not (calls_nothing(s) or sets_numbers(s)) and any(
        type(e) is CallValue and e.routine.casefold() == _ASKS for e in expressions_of(s)
    )


def _calls(s: Statement) -> list[tuple[str, tuple[Expression, ...]]]:
    if calls_nothing(s) or sets_numbers(s):
        return []
    own = [(s.routine, s.arguments)] if isinstance(s, Call) else []
    return own + [(e.routine, e.arguments) for e in expressions_of(s) if type(e) is CallValue]


# --- Messages as records ---
# `M={MODUL[] "CELL",NR 1,MSG_TXT[] "part %1 is missing"}`, `P[1]={PAR_TYPE #VALUE,PAR_INT N}`,
# `H=Set_KrlMsg(#NOTIFY,M,P[],O)`: the record is its text. Module, number and options tell how it looks and who may
# clear it.

_RECORDS: Final = {
    "krlmsg_t": "message",
    "krlmsgpar_t": "parameter",
    "krlmsgopt_t": "option",
    "krlmsgdlgsk_t": "option",
}
_DETAIL: Final = Process(0, "message-detail")
_SHOWN_AS: Final = "message-window"
_SETS: Final = "set_krlmsg"
_ASKED: Final = "set_krldlg"
_STANDS: Final = "exists_krlmsg"
_LOOKED_BACK: Final = 40  # statements, for the parameters of a message
_VALUES: Final = ("par_int", "par_real", "par_bool", "par_txt")


def with_record_messages(program: Program) -> Program:
    """The program with its messages' records as texts, and what shows them as messages."""
    handed = dict(_handed_messages(program))
    if not handed and not any(d.type.casefold() in _RECORDS for d in _declared(program)):
        return program
    own = {r.name.casefold() for r in program.routines}
    if own & {_SETS, _STANDS}:
        return program
    declared = {d.name.casefold() for d in _declared(program)}
    shared = {name: kind for name, kind in handed.items() if name not in declared} | _kinds(program.data)
    routines = []
    for r in program.routines:
        given = {p.name: p.type for p in r.parameters}
        kinds = {**shared, **_kinds([*r.data, *(s for s in r.body if type(s) is Declare)])}
        kinds.update({name.casefold(): "" for name, kind in given.items() if kind.casefold() not in _RECORDS})
        routines.append(replace(r, body=_records_as_texts(r.body, kinds), data=_without_records(r.data)))
    return replace(program, routines=tuple(routines), data=_without_records(program.data))


def _handed_messages(program: Program) -> Iterator[tuple[str, str]]:
    """The records that a message is shown with, whoever declares them, each with what it is."""
    for s in program.statements():
        for routine, arguments in _calls(s):
            if routine.casefold() in (_SETS, _ASKED):
                first = 1 if routine.casefold() == _SETS else 0
                kinds = (
                    ("message", "parameter", "option")
                    if first
                    else ("message", "parameter", "option", "option")
                )
                for kind, e in zip(kinds, arguments[first:], strict=False):
                    name = _base(e)[0]
                    if name:
                        yield name.casefold(), kind


def _declared(program: Program) -> Iterator[Declare]:
    yield from program.data
    for r in program.routines:
        yield from r.data
        yield from (s for s in r.body if type(s) is Declare)


def _kinds(data: Sequence[Declare]) -> dict[str, str]:
    return {d.name.casefold(): _RECORDS.get(d.type.casefold(), "") for d in data}


def _without_records(data: Sequence[Declare]) -> tuple[Declare, ...]:
    """The declarations with messages as texts, without what only tells how they look."""
    rows: list[Declare] = []
    for d in data:
        kind = _RECORDS.get(d.type.casefold())
        if kind is None:
            rows.append(d)
        elif kind == "message" and not d.sizes:
            text = _text_in(d.value) if isinstance(d.value, RecordLiteral) else None
            rows.append(replace(d, name=_text_name(d.name), type="string", native="CHAR", value=text))
    return tuple(rows)


def _text_name(name: str) -> str:
    return f"{name}_TEXT"


def _text_in(record: RecordLiteral) -> Expression | None:
    """The text of a message, or the value of a parameter."""
    for name, value in record.members:
        if name.strip("[]").casefold() in ("msg_txt", *_VALUES):
            return value
    return None


def _base(e: Expression) -> tuple[str, str]:
    """The variable that an expression names as a whole or by one member, and the member."""
    plain = e.base if isinstance(e, Item) else e
    member = ""
    if isinstance(plain, Member):
        member, plain = plain.name.casefold(), plain.base
        plain = plain.base if isinstance(plain, Item) else plain
    return (plain.name, member) if isinstance(plain, Named) else ("", "")


def _records_as_texts(body: Sequence[Statement], kinds: dict[str, str]) -> tuple[Statement, ...]:
    rows: list[Statement] = []
    end = -1  # of the last loop that waits for the operator
    for at, s in enumerate(body):
        if at <= end:
            continue
        if type(s) is Declare and s.type.casefold() in _RECORDS:
            rows += _without_records([s])
        elif type(s) is Assign:
            rows += _assigned(s, body, at, kinds)
        elif type(s) is While and _asks_whether_it_stands(s.condition):
            end = _end_of_waits(body, at)
            rows.append(s if end < 0 else Pause(s.line, comment=s.comment, spelling=ACKNOWLEDGED))
        else:
            rows.append(s)
    return tuple(rows)


def _assigned(s: Assign, body: Sequence[Statement], at: int, kinds: dict[str, str]) -> Sequence[Statement]:
    name, member = _base(s.target)
    kind = kinds.get(name.casefold(), "")
    detail = replace(_DETAIL, line=s.line, comment=s.comment)
    if kind == "message":
        value = _text_in(s.value) if isinstance(s.value, RecordLiteral) else None
        value = s.value if member == "msg_txt" else value
        return [
            detail if value is None else Assign(s.line, Item(Named(_text_name(name)), ()), value, s.comment)
        ]
    if kind:
        return [detail]
    if type(s.value) is CallValue and s.value.routine.casefold() == _ASKED:
        asked = _base(s.value.arguments[0])[0] if s.value.arguments else ""
        if kinds.get(asked.casefold()) == "message":
            text = Item(Named(_text_name(asked)), ())
            return [replace(s, value=replace(s.value, arguments=(text,)))]
    if type(s.value) is CallValue and s.value.routine.casefold() == _SETS and len(s.value.arguments) > 1:
        record, handed = s.value.arguments[1], s.value.arguments[2:3]
        name = _base(record)[0]
        if kinds.get(name.casefold()) == "message":
            shown = _filled(name, _base(handed[0])[0] if handed else "", body, at)
            return [
                Process(s.line, _SHOWN_AS),
                Message(s.line, shown, s.comment),
                Assign(s.line, s.target, Number(1)),
            ]
    return [s]


def _filled(message: str, parameters: str, body: Sequence[Statement], at: int) -> Expression:
    """The text of a message; with its parameters where both are written out in the statements just before."""
    text: Expression | None = None
    given: dict[int, Expression] = {}
    for s in reversed(body[max(at - _LOOKED_BACK, 0) : at]):
        if type(s) is not Assign:
            if type(s) in (Comment, Declare):
                continue
            break
        name, member = _base(s.target)
        if name == message and text is None:
            text = s.value if member == "msg_txt" else None
            text = _text_in(s.value) if isinstance(s.value, RecordLiteral) else text
        if name == parameters and isinstance(s.value, RecordLiteral) and type(s.target) is Item:
            (place,) = s.target.indices or (Unknown(""),)
            value = _text_in(s.value)
            if type(place) is Number and value is not None:
                given.setdefault(int(place.value), value)
    if type(text) is not Text or not any(f"%{n}" in text.value for n in given):
        return Item(Named(_text_name(message)), ())
    parts: list[Expression] = []
    for n, part in enumerate(re.split(r"%(\d)", text.value)):
        if n % 2 == 0:
            parts += [Text(part)] if part else []
        else:
            value = given.get(int(part), Text(f"%{part}"))
            is_text = type(value) is Text or (type(value) is Item and not value.indices)
            parts.append(value if is_text else Function("text-of-value", (value,)))
    return Function("joined-text", tuple(parts))


def _asks_whether_it_stands(e: Expression) -> bool:
    return type(e) is CallValue and e.routine.casefold() == _STANDS


def _end_of_waits(body: Sequence[Statement], at: int) -> int:
    """Where a loop ends that does nothing but wait, -1 for any other."""
    for place in range(at + 1, len(body)):
        if type(body[place]) is EndWhile:
            return place
        if type(body[place]) not in (Comment, Dwell):
            return -1
    return -1


# --- Cyclic flags ---
# `$CYCFLAG[2]=$IN[1] AND NOT $IN[2]` is computed anew all the time: whoever reads the flag asks this condition.

_CYCLIC: Final = "cyclic-flag"
_KNOWN_CONDITION: Final = "cyclic-condition"


def with_cyclic_flags(program: Program) -> Program:
    """The program with the conditions of cyclic flags where these are read, each where one statement gives it."""
    given: dict[float, list[tuple[str, SetOutput]]] = {}
    for r in program.routines:
        for s in r.body:
            if type(s) is SetOutput and s.signal.bus == _CYCLIC and type(s.signal.index) is Number:
                given.setdefault(s.signal.index.value, []).append((r.name, s))
    changing = {n for n, rows in given.items() if any(type(s.value) is not SignalState for _, s in rows)}
    if not changing:
        return program
    known = {n: given[n][0] for n in changing if len(given[n]) == 1}
    routines = []
    for r in program.routines:
        here = {
            n: s.value
            for n, (routine, s) in known.items()
            if routine == r.name or not _locals(program, routine, s)
        }
        routines.append(replace(r, body=tuple([_with_conditions(s, here, changing) for s in r.body])))
    return replace(program, routines=tuple(routines))


def _locals(program: Program, name: str, s: SetOutput) -> bool:
    """Whether a condition names data of its routine alone."""
    shared = {d.name.casefold() for d in program.data}
    names = {e.name.casefold() for e in expressions_of(s.value) if type(e) is Named}
    return not names <= shared


def _with_conditions(s: Statement, here: dict[float, Expression], changing: set[float]) -> Statement:
    if type(s) is SetOutput and s.signal.bus == _CYCLIC and type(s.signal.index) is Number:
        if s.signal.index.value in here:
            return Process(s.line, _KNOWN_CONDITION, (), s.comment)
        return Process(s.line, _CYCLIC, (), s.comment) if s.signal.index.value in changing else s
    if calls_nothing(s) or sets_numbers(s):
        return s

    def change(e: Expression) -> Expression:
        if type(e) is Signal and e.bus == _CYCLIC and type(e.index) is Number:
            return here.get(e.index.value, e)
        return e

    return mapped(s, change)


# --- Results of EthernetKRL ---
# `RET=EKI_Open("CELL")`: each function of KUKA.EthernetKRL returns a record of the type EKI_STATUS, which the option
# declares ("KUKA.EthernetKRL", EKI_STATUS). Where a program reads none of its members, the call alone is left; else the
# call hands the members over to be set.

_STATUS: Final = "EKI_STATUS"
_STATUS_MEMBERS: Final = {
    "Buff": "INT",
    "Read": "INT",
    "Msg_No": "INT",
    "Connected": "BOOL",
    "Counter": "INT",
}
_RETURNS_STATUS: Final = "eki_"


def with_status_members(program: Program) -> Program:
    """The program with calls in the place of assignments of what EthernetKRL's functions return."""
    rows = [d for d in _declared(program) if d.type.upper() == _STATUS]
    if not rows or any(r.name.casefold().startswith(_RETURNS_STATUS) for r in program.routines):
        return program
    names = {d.name for d in rows}
    taken = any(map(names.__contains__, _taken_names(program)))

    def row(s: Statement) -> Statement:
        if not (isinstance(s, Assign) and _is_status(s, names)):
            return s
        assert isinstance(s.value, CallValue)
        members = [Member(s.target, name) for name in _STATUS_MEMBERS] if taken else []
        return Call(s.line, s.value.routine, (*s.value.arguments, *members), comment=s.comment)

    routines = tuple(replace(r, body=tuple(map(row, r.body))) for r in program.routines)
    if not taken:
        routines = tuple(
            replace(r, body=_without(r.body, names), data=_without(r.data, names)) for r in routines
        )
        return replace(program, routines=routines, data=_without(program.data, names))
    members = tuple((name, RecordLiteral(kind, ())) for name, kind in _STATUS_MEMBERS.items())
    layout = Declare(0, _STATUS, "structure", RecordLiteral("STRUC", members), native="STRUC")
    return replace(program, routines=routines, data=(*program.data, layout))


def _is_status(s: Assign, names: set[str]) -> bool:
    return (
        isinstance(s.target, Named)
        and s.target.name in names
        and isinstance(s.value, CallValue)
        and s.value.routine.casefold().startswith(_RETURNS_STATUS)
    )


def _taken_names(program: Program) -> Iterator[str]:
    """What statements read, and what they set in another way than by such a function."""
    for s in program.statements():
        if isinstance(s, Declare) or calls_nothing(s) or sets_numbers(s):
            continue
        found = s.value if isinstance(s, Assign) else None
        sets = isinstance(found, CallValue) and found.routine.casefold().startswith(_RETURNS_STATUS)
        for e in expressions_of(s):
            if isinstance(e, Named) and not (sets and isinstance(s, Assign) and e is s.target):
                yield e.name


def _without(rows: Sequence[Statement], names: set[str]) -> tuple[Any, ...]:
    return tuple(s for s in rows if not (isinstance(s, Declare) and s.name in names))


# --- Modes ---
# `SWITCH $MODE_OP`: which mode the controller is in, as a chain of IF.


def with_modes(body: Sequence[Statement]) -> tuple[Statement, ...]:
    """The statements with IF in the place of SWITCH where the mode chooses."""
    rows: list[Statement] = []
    open_: list[bool | None] = []  # of each SWITCH: whether it is one of modes, and no case has come yet
    for s in body:
        if isinstance(s, Switch):
            open_.append(True if _is_mode(s.value) and _knows_all(body, s) else None)
            if open_[-1] is None:
                rows.append(s)
            elif s.comment:
                rows.append(Comment(s.line, s.comment))
        elif not open_ or open_[-1] is None or not isinstance(s, (Case, Default, EndSwitch)):
            rows.append(s)
            if isinstance(s, EndSwitch) and open_:
                open_.pop()
        elif isinstance(s, Case):
            condition = _in_modes(s.values)
            rows.append(
                If(s.line, condition, s.comment) if open_[-1] else ElseIf(s.line, condition, s.comment)
            )
            open_[-1] = False
        elif isinstance(s, Default):
            rows.append(Else(s.line, s.comment))
        else:
            open_.pop()
            rows.append(EndIf(s.line, s.comment))
    return tuple(rows)


def _is_mode(e: Expression) -> bool:
    return isinstance(e, Named) and e.name.upper() == "$MODE_OP"


def _knows_all(body: Sequence[Statement], opener: Switch) -> bool:
    """Whether a SWITCH has a case first, and all its cases are modes."""
    depth, first = 0, True
    for s in body[next(at for at, one in enumerate(body) if one is opener) + 1 :]:
        if depth == 0 and isinstance(s, (Case, Default, EndSwitch)):
            if isinstance(s, EndSwitch):
                return not first
            if isinstance(s, Default):
                if first:
                    return False
            elif not all(isinstance(v, Text) and v.value.upper() in MODES for v in s.values):
                return False
            first = False
        depth += isinstance(s, Switch) - isinstance(s, EndSwitch)
    return False


def _in_modes(values: Sequence[Expression]) -> Expression:
    names = dict.fromkeys(MODES[v.value.upper()] for v in values if isinstance(v, Text))
    first, *others = map(SystemValue, names)
    return Logic(first, tuple(("or", one) for one in others)) if others else first


# --- Types that no file declares ---
# `DECL PART_T P`, where the list with STRUC or ENUM PART_T is not at hand: P is like a name that nothing declares.

_OWN_TYPES: Final = frozenset(
    {*NEUTRAL_TYPES.values(), "tool", "signal", "enumeration", "structure", "clock"}
)


def without_unknown_types(program: Program) -> Program:
    """The program without variables of types that nobody knows: what they hold, their uses tell."""
    known = {d.name.casefold() for d in _declared(program) if d.type in ("enumeration", "structure")}
    counts = Counter(d.name.casefold() for d in _declared(program) if not _is_unknown(d, known))
    handed = {p.name.casefold() for r in program.routines for p in r.parameters}

    def kept(rows: Sequence[Any]) -> tuple[Any, ...]:
        return tuple(
            _as_text(s, known) if isinstance(s, Declare) else s
            for s in rows
            if not (isinstance(s, Declare) and _is_unknown(s, known))
            or counts[s.name.casefold()]
            or s.name.casefold() in handed
        )

    routines = tuple(replace(r, body=kept(r.body), data=kept(r.data)) for r in program.routines)
    return replace(program, routines=routines, data=kept(program.data))


def _as_text(d: Declare, known: set[str]) -> Declare:
    """A variable that begins with a constant of such a type (`#FAST`): the constant is a text."""
    if isinstance(d.value, Text) and _has_unknown_type(d, known):
        return replace(d, type="string", native="CHAR")
    return d


def _is_unknown(d: Declare, known: set[str]) -> bool:
    return d.value is None and _has_unknown_type(d, known)


def _has_unknown_type(d: Declare, known: set[str]) -> bool:
    return d.type not in _OWN_TYPES and d.type.casefold() not in known
