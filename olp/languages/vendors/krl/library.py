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

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.transformer import expressions_of, is_plain, mapped
from olp.languages.vendor import ACKNOWLEDGED
from olp.languages.vendors.krl.scope import MODES, NEUTRAL_TYPES

_LIBRARY: Final = frozenset({st.Call, st.Assign, st.Wait})  # what may be of the message library
_SHOWS: Final = frozenset({"msgnotify", "msgquit", "msgloop", "msgstate"})
_CLEARS: Final = "clear_krlmsg"
_WINDOW: Final = "$LOOP_MSG"
_PLACE: Final = "%1"
_OMITTED: Final = ex.Unknown("")
_NOTHING: Final = ex.Text(" ")  # what the window shows when its text is cleared


def without_library(
    body: Sequence[st.Statement], find: Callable[[str], st.Routine | None]
) -> tuple[st.Statement, ...]:
    """The statements with those of the message library as messages and pauses.

    `find`: a routine of the program by its name, None for one that is not here or is KUKA's.
    """
    if _LIBRARY.isdisjoint(map(type, body)):
        return tuple(body)
    return tuple([one for s in body for one in (_plain(s, find) if type(s) in _LIBRARY else (s,))])


def _plain(s: st.Statement, find: Callable[[str], st.Routine | None]) -> tuple[st.Statement, ...]:
    if (
        type(s) is st.Call
        and s.routine.casefold() in _SHOWS
        and s.condition is None
        and find(s.routine) is None
    ):
        word = s.routine.casefold()
        handle = s.arguments[0] if word == "msgstate" and s.arguments else None
        text = _shown(s.arguments[1:] if word == "msgstate" else s.arguments)
        if text is None:
            return (s,)
        shown = st.Message(s.line, text, s.comment)
        if word == "msgquit":
            return (shown, st.Pause(s.line, spelling=ACKNOWLEDGED))
        return (shown,) if handle is None else (shown, st.Assign(s.line, handle, ex.Number(1)))
    if type(s) is st.Call and _starts_option(s) and find(s.routine) is None:
        return (st.Process(s.line, "option-start", (), s.comment),)
    if type(s) is st.Assign and _takes_handle(s.value) and find(_CLEARS) is None:
        return (st.Message(s.line, _NOTHING, s.comment), st.Assign(s.line, s.target, ex.SignalState(True)))
    if type(s) is st.Wait and _takes_handle(_without_true(s.condition)) and find(_CLEARS) is None:
        return (st.Message(s.line, _NOTHING, s.comment),)
    if type(s) is st.Assign and _is_window(s.target):
        return (st.Message(s.line, s.value, s.comment),)
    if type(s) is st.Wait and _clears(s.condition):
        return (st.Message(s.line, _NOTHING, s.comment),)
    return (s,)


def _starts_option(s: st.Call) -> bool:
    """What the INI fold of each program calls: `USER_GRP(0,…)`, `USERSPOT(#INIT)`, `A20_INI()`."""
    match s.routine.casefold(), s.arguments:
        case ("user_grp", (ex.Number(0), *_)) | ("userspot", (ex.Text("#INIT"), *_)):
            return True
        case (("a10_ini" | "a20_ini"), ()):
            return True
    return False


def _shown(arguments: tuple[ex.Expression, ...]) -> ex.Expression | None:
    """The text with what it names filled in, None where that is not written out."""
    text, _, number, words = (*arguments, *[_OMITTED] * 4)[:4]
    if type(text) is not ex.Text or _PLACE not in text.value:
        return None if text == _OMITTED else text
    if number == words == _OMITTED:
        return None
    before, _, behind = text.value.partition(_PLACE)
    value = words if number == _OMITTED else ex.Function("text-of-value", (number,))
    parts = (*([ex.Text(before)] if before else []), value, *([ex.Text(behind)] if behind else []))
    return ex.Function("joined-text", parts)


def _is_window(e: ex.Expression) -> bool:
    """`$LOOP_MSG[]`"""
    return type(e) is ex.Item and type(e.base) is ex.Named and e.base.name.upper() == _WINDOW


def _without_true(e: ex.Expression) -> ex.Expression:
    """What `e OR TRUE` asks beside what it does: a wait for it calls the function and goes on."""
    if type(e) is ex.Logic and e.rest == (("or", ex.SignalState(True)),):
        return e.first
    return e


def _takes_handle(e: ex.Expression) -> bool:
    """`Clear_KrlMsg(handle)`"""
    return type(e) is ex.CallValue and e.routine.casefold() == _CLEARS and len(e.arguments) == 1


def _clears(condition: ex.Expression) -> bool:
    """`StrClear($LOOP_MSG[])`, which is always true."""
    return (
        isinstance(condition, ex.CallValue)
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


def with_given_parameters(program: st.Program) -> st.Program:
    """The program with what all its calls decide alike as TRUE or FALSE."""
    if not any(map(_is_asked, program.statements())):
        return program
    calls: dict[str, list[tuple[ex.Expression, ...]]] = {}
    for s in program.statements():
        for routine, arguments in _calls(s):
            calls.setdefault(routine.casefold(), []).append(arguments)
    valued = {d.name.casefold() for d in program.data if d.value is not None}
    routines = tuple(_decided(r, calls.get(r.name.casefold(), []), valued) for r in program.routines)
    return replace(program, routines=routines)


def _decided(routine: st.Routine, calls: list[tuple[ex.Expression, ...]], valued: set[str]) -> st.Routine:
    """`valued`: data of the program that a list gives a value; a routine that nothing calls is handed all."""
    if not any(map(_is_asked, routine.body)):
        return routine
    given: dict[str, set[bool]] = {name: {True} for name in valued}
    for at, p in enumerate(routine.parameters):
        given[p.name.casefold()] = {at < len(one) and type(one[at]) is not ex.Unknown for one in calls} or {
            True
        }

    def change(e: ex.Expression) -> ex.Expression:
        if type(e) is ex.Unary and e.operator == "not" and type(e.operand) is ex.SignalState:
            return ex.SignalState(not e.operand.on)
        if not (type(e) is ex.Compare and e.operator in ("=", "<>")):
            return e
        match e.left, e.right:
            case ex.CallValue(name, (ex.Text(of),)), ex.Text(state) if name.casefold() == _ASKS:
                known = {True} if of.startswith("$") else given.get(of.casefold(), set())
                if state.upper() == _GIVEN and len(known) == 1:
                    return ex.SignalState((True in known) == (e.operator == "="))
        return e

    rows: list[st.Statement] = []
    for s in routine.body:
        rows.append(mapped(s, change) if _is_asked(s) else s)
        if isinstance(s, st.Assign) and isinstance(s.target, ex.Named) and s.target.name.casefold() in given:
            given[s.target.name.casefold()].add(True)  # from here on some way may have set it
    return replace(routine, body=tuple(rows))


def _is_asked(s: st.Statement) -> bool:
    return not is_plain(s) and any(
        type(e) is ex.CallValue and e.routine.casefold() == _ASKS for e in expressions_of(s)
    )


def _calls(s: st.Statement) -> list[tuple[str, tuple[ex.Expression, ...]]]:
    if is_plain(s):
        return []
    own = [(s.routine, s.arguments)] if isinstance(s, st.Call) else []
    return own + [(e.routine, e.arguments) for e in expressions_of(s) if type(e) is ex.CallValue]


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
_TEXT_SIZE: Final = ex.Number(80)  # of Msg_txt[] ("User messages", KSS 8)
_DETAIL: Final = st.Process(0, "message-detail")
_SHOWN_AS: Final = "message-window"
_SETS: Final = "set_krlmsg"
_ASKED: Final = "set_krldlg"
_STANDS: Final = "exists_krlmsg"
_LOOKED_BACK: Final = 40  # statements, for the parameters of a message
_VALUES: Final = ("par_int", "par_real", "par_bool", "par_txt")


def with_record_messages(program: st.Program) -> st.Program:
    """The program with its messages' records as texts, and what shows them as messages."""
    handed = dict(_handed_messages(program))
    records = any(d.type.casefold() in _RECORDS for d in program.declarations())
    if not handed and not records and not any(map(_kinds_taken, program.routines)):
        return program
    own = {r.name.casefold() for r in program.routines}
    if own & {_SETS, _STANDS}:
        return program
    declared = {d.name.casefold() for d in program.declarations()}
    shared = {name: kind for name, kind in handed.items() if name not in declared} | _kinds(program.data)
    taken = _taken(program, shared)
    routines = []
    for r in program.routines:
        kinds = _kinds_in(r, shared, taken)
        body = _with_texts_handed(_records_as_texts(r.body, kinds), taken)
        parameters = tuple(_text_parameters(r, taken))
        routines.append(replace(r, body=body, data=_without_records(r.data), parameters=parameters))
    return replace(program, routines=tuple(routines), data=_without_records(program.data))


_Taken = dict[
    str, tuple[str, ...]
]  # by a routine's name, case folded: which record each parameter is, "": none


def _kinds_taken(r: st.Routine) -> tuple[str, ...]:
    """Which record each parameter of a routine is; empty where none is one."""
    kinds = tuple(_RECORDS.get(p.type.casefold(), "") for p in r.parameters)
    several = any(
        kind == "message" and p.native.endswith("]") for kind, p in zip(kinds, r.parameters, strict=True)
    )
    return kinds if any(kinds) and not several else ()


def _kinds_in(r: st.Routine, shared: dict[str, str], taken: _Taken) -> dict[str, str]:
    """Which record each name is in a routine."""
    kinds = {**shared, **_kinds([*r.data, *(s for s in r.body if type(s) is st.Declare)])}
    own = taken.get(r.name.casefold()) or ("",) * len(r.parameters)
    kinds.update({p.name.casefold(): kind for p, kind in zip(r.parameters, own, strict=True)})
    return kinds


def _taken(program: st.Program, shared: dict[str, str]) -> _Taken:
    """The routines that take records: those alone of which every call hands over a whole message by its name."""
    taken = {r.name.casefold(): kinds for r in program.routines if (kinds := _kinds_taken(r))}
    calls = [(r, [c for s in r.body for c in _calls(s)]) for r in program.routines] if taken else []
    while True:
        wrong = {
            name.casefold()
            for r, made in calls
            for name, arguments in made
            if name.casefold() in taken
            and not _fits(arguments, taken[name.casefold()], _kinds_in(r, shared, taken))
        }
        if not wrong:
            return taken
        taken = {name: kinds for name, kinds in taken.items() if name not in wrong}


def _fits(arguments: Sequence[ex.Expression], taken: Sequence[str], kinds: dict[str, str]) -> bool:
    if len(arguments) > len(taken):
        return False
    given = [e for e, kind in zip(arguments, taken, strict=False) if kind == "message" and e != _OMITTED]
    return all(type(e) is ex.Named and kinds.get(e.name.casefold()) == "message" for e in given)


def _text_parameters(r: st.Routine, taken: _Taken) -> Iterator[st.Parameter]:
    """A routine's parameters: of a message its text, and none for what only tells how it looks."""
    kinds = taken.get(r.name.casefold()) or ("",) * len(r.parameters)
    for p, kind in zip(r.parameters, kinds, strict=True):
        if kind == "message":
            yield replace(p, name=_text_name(p.name), type="string", native="CHAR[]")
        elif not kind:
            yield p


def _with_texts_handed(body: Sequence[st.Statement], taken: _Taken) -> tuple[st.Statement, ...]:
    def texts(routine: str, arguments: Sequence[ex.Expression]) -> tuple[ex.Expression, ...]:
        kinds = taken[routine.casefold()]
        return tuple(
            ex.Item(ex.Named(_text_name(e.name)), ()) if kind and isinstance(e, ex.Named) else e
            for e, kind in zip(arguments, kinds, strict=False)
            if kind in ("", "message")
        )

    def change(e: ex.Expression) -> ex.Expression:
        if isinstance(e, ex.CallValue) and e.routine.casefold() in taken:
            return replace(e, arguments=texts(e.routine, e.arguments))
        return e

    if not taken:
        return tuple(body)
    rows: list[st.Statement] = []
    for s in body:
        one = s if is_plain(s) else mapped(s, change)
        if isinstance(one, st.Call) and one.routine.casefold() in taken:
            one = replace(one, arguments=texts(one.routine, one.arguments))
        rows.append(one)
    return tuple(rows)


def _handed_messages(program: st.Program) -> Iterator[tuple[str, str]]:
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


def _kinds(data: Sequence[st.Declare]) -> dict[str, str]:
    return {d.name.casefold(): _RECORDS.get(d.type.casefold(), "") for d in data}


def _without_records(data: Sequence[st.Declare]) -> tuple[st.Declare, ...]:
    """The declarations with messages as texts, without what only tells how they look."""
    rows: list[st.Declare] = []
    for d in data:
        kind = _RECORDS.get(d.type.casefold())
        if kind is None:
            rows.append(d)
        elif kind == "message" and not d.sizes:
            text = _text_in(d.value) if isinstance(d.value, ex.RecordLiteral) else None
            rows.append(
                replace(
                    d, name=_text_name(d.name), type="string", native="CHAR", value=text, sizes=(_TEXT_SIZE,)
                )
            )
    return tuple(rows)


def _text_name(name: str) -> str:
    return f"{name}_TEXT"


def _text_in(record: ex.RecordLiteral) -> ex.Expression | None:
    """The text of a message, or the value of a parameter."""
    for name, value in record.members:
        if name.strip("[]").casefold() in ("msg_txt", *_VALUES):
            return value
    return None


def _base(e: ex.Expression) -> tuple[str, str]:
    """The variable that an expression names as a whole or by one member, and the member."""
    plain = e.base if isinstance(e, ex.Item) else e
    member = ""
    if isinstance(plain, ex.Member):
        member, plain = plain.name.casefold(), plain.base
        plain = plain.base if isinstance(plain, ex.Item) else plain
    return (plain.name, member) if isinstance(plain, ex.Named) else ("", "")


def _records_as_texts(body: Sequence[st.Statement], kinds: dict[str, str]) -> tuple[st.Statement, ...]:
    rows: list[st.Statement] = []
    end = -1  # of the last loop that waits for the operator
    for at, s in enumerate(body):
        if at <= end:
            continue
        if type(s) is st.Declare and s.type.casefold() in _RECORDS:
            rows += _without_records([s])
        elif type(s) is st.Assign:
            rows += _assigned(s, body, at, kinds)
        elif type(s) is st.While and _asks_whether_it_stands(s.condition):
            end = _end_of_waits(body, at)
            rows.append(s if end < 0 else st.Pause(s.line, comment=s.comment, spelling=ACKNOWLEDGED))
        else:
            rows.append(s)
    return tuple(rows)


def _assigned(
    s: st.Assign, body: Sequence[st.Statement], at: int, kinds: dict[str, str]
) -> Sequence[st.Statement]:
    name, member = _base(s.target)
    kind = kinds.get(name.casefold(), "")
    detail = replace(_DETAIL, line=s.line, comment=s.comment)
    if kind == "message":
        value = _text_in(s.value) if isinstance(s.value, ex.RecordLiteral) else None
        value = s.value if member == "msg_txt" else value
        return [
            detail
            if value is None
            else st.Assign(s.line, ex.Item(ex.Named(_text_name(name)), ()), value, s.comment)
        ]
    if kind:
        return [detail]
    if type(s.value) is ex.CallValue and s.value.routine.casefold() == _ASKED:
        asked = _base(s.value.arguments[0])[0] if s.value.arguments else ""
        if kinds.get(asked.casefold()) == "message":
            text = ex.Item(ex.Named(_text_name(asked)), ())
            return [replace(s, value=replace(s.value, arguments=(text,)))]
    if type(s.value) is ex.CallValue and s.value.routine.casefold() == _SETS and len(s.value.arguments) > 1:
        record, handed = s.value.arguments[1], s.value.arguments[2:3]
        name = _base(record)[0]
        if kinds.get(name.casefold()) == "message":
            shown = _filled(name, _base(handed[0])[0] if handed else "", body, at)
            return [
                st.Process(s.line, _SHOWN_AS),
                st.Message(s.line, shown, s.comment),
                st.Assign(s.line, s.target, ex.Number(1)),
            ]
    return [s]


def _filled(message: str, parameters: str, body: Sequence[st.Statement], at: int) -> ex.Expression:
    """The text of a message; with its parameters where both are written out in the statements just before."""
    text: ex.Expression | None = None
    given: dict[int, ex.Expression] = {}
    for s in reversed(body[max(at - _LOOKED_BACK, 0) : at]):
        if type(s) is not st.Assign:
            if type(s) in (st.Comment, st.Declare):
                continue
            break
        name, member = _base(s.target)
        if name == message and text is None:
            text = s.value if member == "msg_txt" else None
            text = _text_in(s.value) if isinstance(s.value, ex.RecordLiteral) else text
        if name == parameters and isinstance(s.value, ex.RecordLiteral) and type(s.target) is ex.Item:
            (place,) = s.target.indices or (ex.Unknown(""),)
            value = _text_in(s.value)
            if type(place) is ex.Number and value is not None:
                given.setdefault(int(place.value), value)
    if type(text) is not ex.Text or not any(f"%{n}" in text.value for n in given):
        return ex.Item(ex.Named(_text_name(message)), ())
    parts: list[ex.Expression] = []
    for n, part in enumerate(re.split(r"%(\d)", text.value)):
        if n % 2 == 0:
            parts += [ex.Text(part)] if part else []
        else:
            value = given.get(int(part), ex.Text(f"%{part}"))
            is_text = type(value) is ex.Text or (type(value) is ex.Item and not value.indices)
            parts.append(value if is_text else ex.Function("text-of-value", (value,)))
    return ex.Function("joined-text", tuple(parts))


def _asks_whether_it_stands(e: ex.Expression) -> bool:
    return type(e) is ex.CallValue and e.routine.casefold() == _STANDS


def _end_of_waits(body: Sequence[st.Statement], at: int) -> int:
    """Where a loop ends that does nothing but wait, -1 for any other."""
    for place in range(at + 1, len(body)):
        if type(body[place]) is st.EndWhile:
            return place
        if type(body[place]) not in (st.Comment, st.Dwell):
            return -1
    return -1


# --- Cyclic flags ---
# `$CYCFLAG[2]=$IN[1] AND NOT $IN[2]` is computed anew all the time: whoever reads the flag asks this condition.

_CYCLIC: Final = "cyclic-flag"
_KNOWN_CONDITION: Final = "cyclic-condition"


def with_cyclic_flags(program: st.Program) -> st.Program:
    """The program with the conditions of cyclic flags where these are read, each where one statement gives it."""
    given: dict[float, list[tuple[str, st.SetOutput]]] = {}
    for r in program.routines:
        for s in r.body:
            if type(s) is st.SetOutput and s.signal.bus == _CYCLIC and type(s.signal.index) is ex.Number:
                given.setdefault(s.signal.index.value, []).append((r.name, s))
    changing = {n for n, rows in given.items() if any(type(s.value) is not ex.SignalState for _, s in rows)}
    if not changing and not any(
        type(s) is st.SetOutput and _follows_computed(s) for s in program.statements()
    ):
        return program
    known = {n: given[n][0] for n in changing if len(given[n]) == 1}
    routines = []
    for r in program.routines:
        here = {
            n: s.value
            for n, (routine, s) in known.items()
            if routine == r.name or not _names_locals(program, s)
        }
        routines.append(replace(r, body=tuple([_with_conditions(s, here, changing) for s in r.body])))
    return replace(program, routines=tuple(routines))


def _follows_computed(s: st.SetOutput) -> bool:
    """Whether it gives a condition to a flag whose number is computed: who reads which flag is not known."""
    computed = s.signal.bus == _CYCLIC and type(s.signal.index) is not ex.Number
    return computed and type(s.value) is not ex.SignalState


def _names_locals(program: st.Program, s: st.SetOutput) -> bool:
    """Whether a condition names data that its routine has for itself."""
    shared = {d.name.casefold() for d in program.data}
    names = {e.name.casefold() for e in expressions_of(s.value) if type(e) is ex.Named}
    return not names <= shared


def _with_conditions(s: st.Statement, here: dict[float, ex.Expression], changing: set[float]) -> st.Statement:
    if type(s) is st.SetOutput and s.signal.bus == _CYCLIC and type(s.signal.index) is ex.Number:
        if s.signal.index.value in here:
            return st.Process(s.line, _KNOWN_CONDITION, (), s.comment)
        return st.Process(s.line, _CYCLIC, (), s.comment) if s.signal.index.value in changing else s
    if type(s) is st.SetOutput and _follows_computed(s):
        return st.Process(s.line, _CYCLIC, (), s.comment)
    if is_plain(s):
        return s

    def change(e: ex.Expression) -> ex.Expression:
        if type(e) is ex.Signal and e.bus == _CYCLIC and type(e.index) is ex.Number:
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


def with_status_members(program: st.Program) -> st.Program:
    """The program with calls in the place of assignments of what EthernetKRL's functions return."""
    rows = [d for d in program.declarations() if d.type.upper() == _STATUS]
    if not rows or any(r.name.casefold().startswith(_RETURNS_STATUS) for r in program.routines):
        return program
    names = {d.name for d in rows}
    taken = any(map(names.__contains__, _taken_names(program)))

    def row(s: st.Statement) -> st.Statement:
        if not (isinstance(s, st.Assign) and _is_status(s, names)):
            return s
        assert isinstance(s.value, ex.CallValue)
        members = [ex.Member(s.target, name) for name in _STATUS_MEMBERS] if taken else []
        return st.Call(s.line, s.value.routine, (*s.value.arguments, *members), comment=s.comment)

    routines = tuple(replace(r, body=tuple(map(row, r.body))) for r in program.routines)
    if not taken:
        routines = tuple(
            replace(r, body=_without(r.body, names), data=_without(r.data, names)) for r in routines
        )
        return replace(program, routines=routines, data=_without(program.data, names))
    members = tuple((name, ex.RecordLiteral(kind, ())) for name, kind in _STATUS_MEMBERS.items())
    layout = st.Declare(0, _STATUS, "structure", ex.RecordLiteral("STRUC", members), native="STRUC")
    return replace(program, routines=routines, data=(*program.data, layout))


def _is_status(s: st.Assign, names: set[str]) -> bool:
    return (
        isinstance(s.target, ex.Named)
        and s.target.name in names
        and isinstance(s.value, ex.CallValue)
        and s.value.routine.casefold().startswith(_RETURNS_STATUS)
    )


def _taken_names(program: st.Program) -> Iterator[str]:
    """What statements read, and what they set in another way than by such a function."""
    for s in program.statements():
        if isinstance(s, st.Declare) or is_plain(s):
            continue
        found = s.value if isinstance(s, st.Assign) else None
        sets = isinstance(found, ex.CallValue) and found.routine.casefold().startswith(_RETURNS_STATUS)
        for e in expressions_of(s):
            if isinstance(e, ex.Named) and not (sets and isinstance(s, st.Assign) and e is s.target):
                yield e.name


def _without(rows: Sequence[st.Statement], names: set[str]) -> tuple[Any, ...]:
    return tuple(s for s in rows if not (isinstance(s, st.Declare) and s.name in names))


# --- Modes ---
# `SWITCH $MODE_OP`: which mode the controller is in, as a chain of IF.


def with_modes(body: Sequence[st.Statement]) -> tuple[st.Statement, ...]:
    """The statements with IF in the place of SWITCH where the mode chooses."""
    if st.Switch not in set(map(type, body)):
        return tuple(body)
    rows: list[st.Statement] = []
    open_: list[bool | None] = []  # of each SWITCH: whether it is one of modes, and no case has come yet
    for s in body:
        if isinstance(s, st.Switch):
            open_.append(True if _is_mode(s.value) and _knows_all(body, s) else None)
            if open_[-1] is None:
                rows.append(s)
            elif s.comment:
                rows.append(st.Comment(s.line, s.comment))
        elif not open_ or open_[-1] is None or not isinstance(s, (st.Case, st.Default, st.EndSwitch)):
            rows.append(s)
            if isinstance(s, st.EndSwitch) and open_:
                open_.pop()
        elif isinstance(s, st.Case):
            condition = _in_modes(s.values)
            rows.append(
                st.If(s.line, condition, s.comment) if open_[-1] else st.ElseIf(s.line, condition, s.comment)
            )
            open_[-1] = False
        elif isinstance(s, st.Default):
            rows.append(st.Else(s.line, s.comment))
        else:
            open_.pop()
            rows.append(st.EndIf(s.line, s.comment))
    return tuple(rows)


def _is_mode(e: ex.Expression) -> bool:
    return isinstance(e, ex.Named) and e.name.upper() == "$MODE_OP"


def _knows_all(body: Sequence[st.Statement], opener: st.Switch) -> bool:
    """Whether a SWITCH has a case first, and all its cases are modes."""
    depth, first = 0, True
    for s in body[next(at for at, one in enumerate(body) if one is opener) + 1 :]:
        if depth == 0 and isinstance(s, (st.Case, st.Default, st.EndSwitch)):
            if isinstance(s, st.EndSwitch):
                return not first
            if isinstance(s, st.Default):
                if first:
                    return False
            elif not all(isinstance(v, ex.Text) and v.value.upper() in MODES for v in s.values):
                return False
            first = False
        depth += isinstance(s, st.Switch) - isinstance(s, st.EndSwitch)
    return False


def _in_modes(values: Sequence[ex.Expression]) -> ex.Expression:
    names = dict.fromkeys(MODES[v.value.upper()] for v in values if isinstance(v, ex.Text))
    first, *others = map(ex.SystemValue, names)
    return ex.Logic(first, tuple(("or", one) for one in others)) if others else first


# --- Types that no file declares ---
# `DECL PART_T P`, where the list with STRUC or ENUM PART_T is not at hand: P is like a name that nothing declares.

_OWN_TYPES: Final = frozenset(
    {*NEUTRAL_TYPES.values(), "tool", "signal", "enumeration", "structure", "clock"}
)


def without_unknown_types(program: st.Program) -> st.Program:
    """The program without variables of types that nobody knows: what they hold, their uses tell."""
    known = {d.name.casefold() for d in program.declarations() if d.type in ("enumeration", "structure")}
    counts = Counter(d.name.casefold() for d in program.declarations() if not _is_unknown(d, known))
    handed = {p.name.casefold() for r in program.routines for p in r.parameters}

    def kept(rows: tuple[Any, ...]) -> tuple[Any, ...]:
        if st.Declare not in set(map(type, rows)):
            return rows
        return tuple(
            _as_text(s, known) if isinstance(s, st.Declare) else s
            for s in rows
            if not (isinstance(s, st.Declare) and _is_unknown(s, known))
            or counts[s.name.casefold()]
            or s.name.casefold() in handed
        )

    routines = tuple(replace(r, body=kept(r.body), data=kept(r.data)) for r in program.routines)
    return replace(program, routines=routines, data=kept(program.data))


def _as_text(d: st.Declare, known: set[str]) -> st.Declare:
    """A variable that begins with a constant of such a type (`#FAST`): the constant is a text."""
    if isinstance(d.value, ex.Text) and _has_unknown_type(d, known):
        return replace(d, type="string", native="CHAR")
    return d


def _is_unknown(d: st.Declare, known: set[str]) -> bool:
    return d.value is None and _has_unknown_type(d, known)


def _has_unknown_type(d: st.Declare, known: set[str]) -> bool:
    return d.type not in _OWN_TYPES and d.type.casefold() not in known
