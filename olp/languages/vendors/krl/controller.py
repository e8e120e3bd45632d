"""What KUKA's controllers declare and keep themselves, as data and calls that a program of another language can have.

Types of records (`DECL PDAT P`), settings that a program reads back (`OLD=$VEL.CP`), and channels to other devices
(`CREAD(…)`), "System variables" and "CREAD/CWRITE", KSS 8.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from operator import is_
from typing import Any, Final

from lark.exceptions import UnexpectedInput

from olp.core.units import deg, mm, percent
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.transformer import expressions_of, is_written_out, mapped, sets_numbers
from olp.languages.lark_host import BrokenLineError
from olp.languages.vendors.krl.grammar import clock_set, line_parser
from olp.languages.vendors.krl.scope import Scope

# --- Types of records ---

_LAYOUTS: Final[Mapping[str, Mapping[str, str]]] = {
    "FDAT": {"TOOL_NO": "INT", "BASE_NO": "INT", "IPO_FRAME": "CHAR"},
    "PDAT": {"VEL": "REAL", "ACC": "REAL", "APO_DIST": "REAL", "APO_MODE": "CHAR", "GEAR_JERK": "REAL"},
    "LDAT": {
        **{"VEL": "REAL", "ACC": "REAL", "APO_DIST": "REAL", "APO_FAC": "REAL", "AXIS_VEL": "REAL"},
        **{
            "AXIS_ACC": "REAL",
            "ORI_TYP": "CHAR",
            "CIRC_TYP": "CHAR",
            "JERK_FAC": "REAL",
            "GEAR_JERK": "REAL",
        },
    },
    "APO": {"CPTP": "INT", "CDIS": "REAL", "CORI": "REAL", "CVEL": "INT"},
    "CP": {"CP": "REAL", "ORI1": "REAL", "ORI2": "REAL"},
    "LOAD": {"M": "REAL", "CM": "FRAME", "J": "INERTIA"},
    "INERTIA": {"X": "REAL", "Y": "REAL", "Z": "REAL"},
    "STATE_T": {"RET1": "CHAR", "MSG_NO": "INT", "HITS": "INT", "LENGTH": "INT"},
}
_ACTUAL: Final = {"PDAT_ACT": "PDAT", "LDAT_ACT": "LDAT", "FDAT_ACT": "FDAT"}
_STATE: Final = "STATE_T"


def with_own_layouts(program: st.Program, reading: Sequence[st.Statement]) -> st.Program:
    """The program with the layouts of the controller's own types, where a statement takes a record of them apart."""
    taken = {_root(e).upper() for s in reading for e in expressions_of(s) if type(e) is ex.Member}
    taken |= {_root(s.target).upper() for s in reading if isinstance(s, st.Assign) and _is_record(s)}
    if not taken:
        return program
    taken |= {
        e.name.upper() for s in _copies(program, taken) for e in expressions_of(s) if type(e) is ex.Named
    }
    rows = list(program.declarations())
    known = {d.name.upper() for d in rows}
    extra = [
        st.Declare(0, name, kind, None, shared=True, native=kind)
        for name, kind in _ACTUAL.items()
        if name in taken and name not in known
    ]
    wanted = {d.type.upper() for d in (*rows, *extra) if d.name.upper() in taken} & _LAYOUTS.keys()
    wanted -= known
    if not wanted:
        return program
    if "LOAD" in wanted:
        wanted.add("INERTIA")
    layouts = [_layout(name) for name in sorted(wanted)]
    return replace(program, data=(*program.data, *extra, *layouts))


def _layout(name: str) -> st.Declare:
    members = tuple((member, ex.RecordLiteral(kind, ())) for member, kind in _LAYOUTS[name].items())
    return st.Declare(0, name, "structure", ex.RecordLiteral("STRUC", members), native="STRUC")


def reading_of(program: st.Program) -> list[st.Statement]:
    """The statements that may read a record, a setting or a place of the controller's, or call a function."""
    return [s for s in program.statements() if _is_read(s)]


def _is_read(s: st.Statement) -> bool:
    kind = type(s)
    if kind is st.Move:
        return not is_written_out(s) or _is_place(s.targets[0])  # type: ignore[arg-type, union-attr]
    return not (kind is st.Declare or sets_numbers(s))


def _copies(program: st.Program, taken: set[str]) -> Iterator[st.Assign]:
    """Assignments of whole records to those that are taken apart."""
    for s in program.statements():
        if isinstance(s, st.Assign) and type(s.target) is ex.Named and s.target.name.upper() in taken:
            yield s


def _is_record(s: st.Assign) -> bool:
    return isinstance(s.value, ex.RecordLiteral) and type(s.target) in (ex.Named, ex.Item)


def _root(e: ex.Expression) -> str:
    while isinstance(e, (ex.Member, ex.Item)):
        e = e.base
    return e.name if type(e) is ex.Named else ""


# --- Settings that are read back ---
# `OLD=$VEL.CP`, `$VEL.CP=0.1`, …, `$VEL.CP=OLD`: a variable of the program holds what its statements have set.

_SETTINGS: Final = {
    "$VEL.CP": st.SpeedUnit.TRAVEL,
    "$VEL.ORI1": st.SpeedUnit.TURN,
    "$VEL_AXIS": st.SpeedUnit.FRACTION,
    "$ACC.CP": st.AccelerationUnit.TRAVEL,
    "$ACC_AXIS": st.AccelerationUnit.FRACTION,
    "$APO.CDIS": st.BlendKind.RADIUS,
    "$APO.CPTP": st.BlendKind.SHARE,
    "$APO.CVEL": st.BlendKind.SPEED,
    "$APO.CORI": st.BlendKind.TURN,
    "$OV_PRO": None,
    "$ADVANCE": None,
}
# One unit of each setting in SI.
_UNITS: Final = {
    "$VEL.ORI1": deg,
    "$VEL_AXIS": percent,
    "$ACC_AXIS": percent,
    "$APO.CDIS": mm,
    "$APO.CPTP": percent,
    "$APO.CVEL": percent,
    "$APO.CORI": deg,
    "$OV_PRO": percent,
}
_WHOLE: Final = frozenset({"$OV_PRO", "$ADVANCE"})
# Places that forms set and machine data hold: data of the program, where a statement names them.
_PLACES: Final = {"$H_POS": "H_POS", "$AXIS_HOME": "AXIS_HOME"}


def with_kept_settings(program: st.Program, reading: Sequence[st.Statement]) -> st.Program:
    """The program with variables for the settings that it reads."""
    read = {key for s in reading for e in _values(s) if (key := _setting(e))}
    # Of single axes, where one variable for all would be another value.
    read -= {_setting(s.target) for s in reading if isinstance(s, st.Assign)} - _WHOLE
    places = {
        e.name.upper()
        for s in reading
        for e in (_values(s) if not isinstance(s, st.Assign) else expressions_of(s.value))
        if type(e) is ex.Named and _is_place(e)
    }
    if not read and not places:
        return program
    taken = {d.name.casefold() for d in program.declarations()}
    names: dict[str, str] = {}
    for key in sorted(read):
        name = key.strip("$").replace(".", "_")
        while name.casefold() in taken:
            name += "_1"
        names[key] = name
    kept: set[str] = set()

    def change(e: ex.Expression) -> ex.Expression:
        if type(e) is ex.Named and e.name.upper() in places:
            return ex.Named(_PLACES[e.name.upper()])
        key = _setting(e)
        return ex.Named(names[key]) if key in names else e

    def rows(s: st.Statement) -> list[st.Statement]:
        if not _is_read(s):
            found = s
        elif isinstance(s, st.Assign) and _setting(s.target) == "$ADVANCE":
            found = replace(s, value=mapped(s.value, change))
        else:
            found = mapped(s, change)
        given = [(names[key], value) for key, value in _set(found) if key in names]
        kept.update(name for name, _ in given)
        return [found, *(st.Assign(s.line, ex.Named(name), value) for name, value in given)]

    routines = tuple(replace(r, body=tuple(one for s in r.body for one in rows(s))) for r in program.routines)
    data = [
        st.Declare(0, name, "real", None, shared=True)
        for key, name in names.items()
        if name in kept and key != "$OV_PRO"
    ]
    if "$OV_PRO" in names:  # what the program has not set yet is the whole speed
        whole = ex.Number(100)
        data.append(st.Declare(0, names["$OV_PRO"], "integer", whole, shared=True, native="$OV_PRO"))
    return replace(program, routines=routines, data=(*program.data, *data))


def _values(s: st.Statement) -> list[ex.Expression]:
    """Expressions whose values a statement takes."""
    if isinstance(s, st.Assign) and _setting(s.target):
        return expressions_of(s.value)
    return expressions_of(s)


def _is_place(e: ex.Expression) -> bool:
    return type(e) is ex.Named and e.name.startswith("$") and e.name.upper() in _PLACES


def _setting(e: ex.Expression) -> str:
    """The setting that an expression is, "" of any other."""
    if type(e) is ex.Item and type(e.base) is ex.Named and e.base.name.upper() in ("$VEL_AXIS", "$ACC_AXIS"):
        return e.base.name.upper()
    if type(e) is ex.Named and e.name.upper() in _WHOLE:
        return e.name.upper()
    if type(e) is ex.Member and type(e.base) is ex.Named:
        key = f"{e.base.name}.{e.name}".upper()
        return key if key in _SETTINGS else ""
    return ""


def _set(s: st.Statement) -> Iterator[tuple[str, ex.Expression]]:
    """The settings that a statement makes, in the units of KRL."""
    found: list[tuple[object, ex.Quantity]] = []
    match s:
        case st.SetOverride():
            yield "$OV_PRO", _in_units(s.share, percent)
        case st.Assign(_, target) if _setting(target) == "$ADVANCE":
            yield "$ADVANCE", s.value
        case st.SetSpeed():
            found = [(one.unit, one.value) for one in s.speeds if one.value is not None]
            found += [(st.SpeedUnit.TURN, s.turn)] if s.turn is not None else []
        case st.SetAcceleration():
            found = [(one.unit, one.value) for one in s.rates]
        case st.SetBlend():
            found = [(one.kind, one.value) for one in s.blends if one.value is not None]
    for unit, value in found:
        for key, of in _SETTINGS.items():
            if of is not None and of is unit:
                yield key, _in_units(value, _UNITS.get(key, 1.0))


def _in_units(value: ex.Quantity, unit: float) -> ex.Expression:
    factor = float(f"{value.scale / unit:.12g}")
    if factor == 1.0:
        return value.written
    if type(value.written) is ex.Number:
        return ex.Number(float(f"{value.written.value * factor:.12g}"))
    return ex.Binary("*", value.written, ex.Number(factor))


# --- Channels ---
# `CREAD(HANDLE,SR,MR,TIMEOUT,OFFSET,"%d",N)` is a call; of a record of the type STATE_T it gets the members that the
# program reads.

_CALLS: Final = frozenset({"copen", "cclose", "cread", "cwrite", "sread", "swrite", "cast_to", "cast_from"})
_CHANNEL: Final = re.compile(r"\(\s*:\s*(\w+)")


def with_channel_calls(program: st.Program) -> st.Program:
    """The program with calls in the place of the instructions for channels and their texts."""
    if not any(isinstance(s, st.Process) and s.name in _CALLS for s in program.statements()):
        return program
    states = {d.name.upper() for d in program.declarations() if d.type.upper() == _STATE}
    members: dict[str, dict[str, None]] = {name: {} for name in states}
    for s in reading_of(program):
        for e in expressions_of(s):
            if type(e) is ex.Member and (root := _root(e).upper()) in states:
                members[root][e.name.upper()] = None

    def row(s: st.Statement) -> st.Statement:
        if not (isinstance(s, st.Process) and s.name in _CALLS):
            return s
        call = _call(s)
        if call is None:
            return s
        handed: list[ex.Expression] = []
        for e in call.arguments:
            root = e.name.upper() if type(e) is ex.Named else ""
            handed += [ex.Member(e, name) for name in members[root]] if root in states else [e]
        return replace(call, arguments=tuple(handed))

    routines = [replace(r, body=tuple(map(row, r.body))) for r in program.routines]
    unread = {name for name, read in members.items() if not read}
    routines = [replace(r, body=_without(r.body, unread), data=_without(r.data, unread)) for r in routines]
    return replace(program, routines=tuple(routines), data=_without(program.data, unread))


_COMPUTED: Final = frozenset({"bit-not", "same-text"})


def with_plain_functions(program: st.Program) -> st.Program:
    """The program with comparisons in the place of `StrComp(A[],B[],#CASE_SENS)`, and `B_NOT N` as -N - 1."""

    def change(e: ex.Expression) -> ex.Expression:
        if type(e) is ex.Function and e.name == "bit-not":
            return ex.Binary("-", ex.Unary("-", e.arguments[0]), ex.Number(1))
        return ex.Compare("=", *e.arguments) if type(e) is ex.Function and e.name == "same-text" else e

    def row(s: st.Statement) -> st.Statement:
        return mapped(s, change) if _is_read(s) else s

    if not any(
        type(e) is ex.Function and e.name in _COMPUTED for s in reading_of(program) for e in expressions_of(s)
    ):
        return program
    return replace(
        program, routines=tuple(replace(r, body=tuple(map(row, r.body))) for r in program.routines)
    )


def _without(rows: Sequence[Any], names: set[str]) -> tuple[Any, ...]:
    return tuple(s for s in rows if not (isinstance(s, st.Declare) and s.name.upper() in names))


def _call(s: st.Process) -> st.Call | None:
    text = dict(s.arguments).get("")
    if not isinstance(text, ex.Text):
        return None
    try:
        found = line_parser().parse_line(_CHANNEL.sub(r'("\1"', text.value), Scope()).result
    except (UnexpectedInput, BrokenLineError):
        return None
    return replace(found, line=s.line, comment=s.comment) if isinstance(found, st.Call) else None


# --- Clocks and flags whose number has a name ---
# `CONST INT CYCLE=2`, `$TIMER[CYCLE]=-2000`: the constant may stand in a list that the program's file does not see.

_OF_CLOCKS: Final = frozenset({"$TIMER", "$TIMER_STOP"})
_FLAGS: Final = frozenset({"timer-flag", "cyclic-flag"})
_MILLISECONDS: Final = ex.Number(1000)


def with_numbered_clocks(program: st.Program) -> st.Program:
    """The program with clocks and flags by their numbers where these are constants."""
    shared = _constants(program.data)
    return replace(program, routines=tuple(_with_numbered_clocks(r, shared) for r in program.routines))


def _constants(data: Sequence[Any]) -> dict[str, ex.Number | None]:
    """The whole numbers that constants hold; None for every other name that is declared."""
    return {
        d.name.casefold(): d.value if d.storage == "constant" and isinstance(d.value, ex.Number) else None
        for d in data
        if isinstance(d, st.Declare)
    }


def _with_numbered_clocks(r: st.Routine, shared: Mapping[str, ex.Number | None]) -> st.Routine:
    inner = r.body if st.Declare in set(map(type, r.body)) else ()
    own = {**_constants((*r.data, *inner)), **{p.name.casefold(): None for p in r.parameters}}

    def number(indices: Sequence[ex.Expression]) -> int | None:
        """What constant the one index is, None for any other."""
        name = indices[0].name.casefold() if len(indices) == 1 and isinstance(indices[0], ex.Named) else ""
        found = own.get(name, shared.get(name) if name not in own else None)
        return int(found.value) if found is not None and float(found.value).is_integer() else None

    def change(e: ex.Expression) -> ex.Expression:
        if isinstance(e, ex.Signal) and e.bus in _FLAGS and (at := number((e.index,))) is not None:
            if e.bus == "timer-flag":
                return ex.Compare(">=", ex.SystemValue("timer", at), ex.Number(0))
            return replace(e, index=ex.Number(at))
        if not (isinstance(e, ex.Item) and isinstance(e.base, ex.Named)):
            return e
        if e.base.name.upper() not in _OF_CLOCKS or (at := number(e.indices)) is None:
            return e
        if e.base.name.upper() == "$TIMER":
            return ex.Binary("*", ex.SystemValue("timer", at), _MILLISECONDS)
        return ex.Unary("not", ex.SystemValue("timer-running", at))

    def changed(s: st.Statement) -> st.Statement:
        if is_written_out(s) if type(s) is st.Move else sets_numbers(s):
            return s
        if isinstance(s, st.SetOutput) and s.signal.bus in _FLAGS:
            at = number((s.signal.index,))
            index = s.signal.index if at is None else ex.Number(at)
            value = mapped(s.value, change)
            if s.signal.bus == "timer-flag" and isinstance(index, ex.Number):
                # Whoever reads the flag asks the clock, and what setting it does to that no manual at hand says.
                return st.Assign(s.line, ex.Item(ex.Named("$TIMER_FLAG"), (index,)), value, s.comment)
            return replace(s, signal=replace(s.signal, index=index), value=value)
        if isinstance(s, st.Assign) and isinstance(s.target, ex.Item):
            target = change(s.target)
            if isinstance(target, (ex.Binary, ex.Unary)):
                set_ = clock_set(target, mapped(s.value, change))
                return replace(set_, line=s.line, comment=s.comment)
        return mapped(s, change)

    body = tuple([changed(s) for s in r.body])
    return r if all(map(is_, body, r.body)) else replace(r, body=body)
