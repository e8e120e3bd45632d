"""A whole AS file: its programs as routines, its tables as data, and everything that is wrong with it."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, TypeGuard

from olp.core.diagnostic import Severity, Span
from olp.core.result_cache import shelf
from olp.core.source import Source
from olp.core.units import mm, percent
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.points import PointTable
from olp.ir.transformer import expressions_of, mapped
from olp.languages.findings import Findings
from olp.languages.lark_host import BrokenLineError, changed
from olp.languages.short_reader import (
    Codes,
    LineParser,
    array,
    check_blocks,
    is_readable,
    joints,
    unreadable,
    with_comment,
    words,
    zyz_pose,
)
from olp.languages.vendor import ENDS_CYCLE

from .block_steps import LEVELS, Levels, TaughtStep, step_of
from .rules import (
    FIRST_OF,
    HOMES,
    Arc,
    AsRules,
    BlockEnd,
    BlockStep,
    ContinuousPath,
    NextMoveFields,
    PercentOfPath,
    bus_of,
)
from .truths import with_truths

_CODES: Final = Codes("P580", "P581", "P582", "P583", "P584", "P585")
_MARK = re.compile(
    r"^\s*\.(?:PROGRAM|TRANS|JOINTS|REALS|STRINGS|INTEGER|AUXDATA|SYSDATA|ROBOTDATA\d|NETCONF\d?|\w+_INFO\d?)\b",
    re.IGNORECASE,
)
_POINT = re.compile(r"\s*POINT\b", re.IGNORECASE)
_HEAD = re.compile(r"\s*\.PROGRAM\s+([A-Z_][\w.]*)\s*(?:\(([^)]*)\))?", re.IGNORECASE)
_LABEL = re.compile(r"(\d+)(?:\s*:|\s+|$)\s*|([A-Z_][\w.]*)\s*:(?!=)\s*", re.IGNORECASE)
_ROW = re.compile(r"([#$@]?[A-Z_][\w.]*)\s*(?:\[([\d,\s]+)\])?\s*=?\s*(.*)", re.IGNORECASE)
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:E[-+]?\d+)?", re.IGNORECASE)
_TABLES: Final = (".TRANS", ".JOINTS", ".REALS", ".STRINGS", ".INTEGER")
_KNOWN: Final = words(
    "JMOVE LMOVE HMOVE C1MOVE C2MOVE XMOVE LAPPRO JAPPRO LDEPART JDEPART DRAW TDRAW TWAIT STABLE DELAY BREAK CALL GOTO "
    "IF ELSE ELSEIF END WHILE DO UNTIL FOR CASE SCASE VALUE SVALUE ANY RETURN SIGNAL SWAIT WAIT POINT TOOL BASE"
)
_MOVES: Final = words(
    "JMOVE LMOVE HMOVE XMOVE LAPPRO JAPPRO LDEPART JDEPART C1MOVE C2MOVE DRAW TDRAW DRIVE ALIGN JOINT "
    "LINEAR LIN2 CIR1 CIR2"
)
_UNTAUGHT: Final = {kind: ex.PositionLiteral(kind, (float("nan"),) * 6) for kind in ("pose", "joint")}
_MOST_ELEMENTS: Final = 5000  # per index of an array
_DEEP: Final = 4  # variables that are set to variables
_MOST_ROOM: Final = 500_000  # elements of all arrays together
_FIRST_ACCURACY: Final = st.Blend(st.BlendKind.RADIUS, ex.Quantity(ex.Number(1), mm))
_FULL: Final = ex.Quantity(ex.Number(100), percent)  # the braking of moves without DECEL
_STOP: Final = st.Blend(st.BlendKind.RADIUS, ex.Quantity(ex.Number(0), mm))
_NUMERIC: Final = words(
    "power sqrt abs sin cos tan atan2 trunc min max length-of-text value-of-text pose-distance"
)
_HOME_ROWS: Final = ("1HOME", "2HOME")  # of .AUXDATA
_SYSTEM_ROWS: Final = ("TOOL", "BASE")  # of .SYSDATA
_SIZES: Final = {1: 1000, 2: 100}  # of an array that only the program fills, by its number of indices


def read_program(source: Source) -> st.Program:
    """The programs and the data of a file. Never raises on bad text."""
    findings = Findings(source)
    if not is_readable(findings, _CODES, _MARK, "AS"):
        return unreadable("as", source, findings)
    return _AsFile(findings).read()


class _AsFile:
    def __init__(self, findings: Findings) -> None:
        self.findings, self.kinds = findings, findings.kinds
        self.rules = AsRules()
        self.parser = LineParser(findings, "as", self.rules, _CODES, _KNOWN, _MOVES)
        self.data: dict[str, st.Declare] = {}
        self.room = _MOST_ROOM
        self.elements: dict[str, dict[tuple[int, ...], ex.Expression]] = {}
        self._values = shelf("as rows")
        self.levels = LEVELS | _levels(findings.source.lines)
        self.saved = _places(findings.source.lines, ".SYSDATA", _SYSTEM_ROWS)
        self.saved |= _places(findings.source.lines, ".AUXDATA", _HOME_ROWS)
        self.logical: set[str] = set()  # folded names of variables that only ever hold true or false
        self.outside: list[st.Statement] = []  # comments between programs, which the next one takes along

    def read(self) -> st.Program:
        source = self.findings.source
        lines, number = source.lines, 1
        routines: list[st.Routine] = []
        while number <= len(lines):
            text = lines[number - 1].strip()
            head = _HEAD.match(text)
            word = text.split(None, 1)[0].upper() if text else ""
            if head:
                routine, number = self._routine(head, number)
                routines.append(routine)
            elif word in _TABLES:
                number = self._table(word, number)
            else:
                self.kinds[number - 1] = st.LineKind.RECORD if text else st.LineKind.BLANK
                if text.startswith(";"):
                    self.kinds[number - 1] = st.LineKind.COMMENT
                    self.outside.append(st.Comment(number, text[1:]))
                number += 1
        if routines and self.outside:
            routines[-1] = replace(routines[-1], body=(*routines[-1].body, *self.outside))
        self._close_arrays()
        self._declare_homes()
        routines = _SignalNumbers(self.findings, routines, self.data).known()
        self._declare_groups(routines)
        routines, self.logical = with_truths(routines, self.data)
        found = _Sizes(routines, lines)
        sizes = found.known()
        self._widen_arrays(sizes, found.set_at)
        routines = [self._with_arrays(one, sizes) for one in routines]
        routines = self._with_results(routines)
        main = _main(routines)
        if main:
            at = next(i for i, one in enumerate(routines) if one.name == main)
            routines[at] = self._with_defaults(routines[at])
        started = _started(routines)
        routines = [self._with_saved(one) if one.name in started else one for one in routines]
        return st.Program(
            "as",
            source,
            tuple(routines),
            self.findings.result(),
            bytes(self.kinds),
            tuple(self.data.values()),
            main,
            main_is_guessed=True,
        )

    # --- tables -----------------------------------------------------------------------------------------

    def _table(self, word: str, number: int) -> int:
        """The rows of .TRANS, .JOINTS, .REALS or .STRINGS; the number of the line behind it."""
        lines = self.findings.source.lines
        self.kinds[number - 1] = st.LineKind.RECORD
        number += 1
        while number <= len(lines):
            text = lines[number - 1].strip()
            if text.upper().startswith(".END"):
                self.kinds[number - 1] = st.LineKind.RECORD
                return number + 1
            if text.startswith(".") and not text.startswith(".*"):
                break
            self.kinds[number - 1] = st.LineKind.POINT if text else st.LineKind.BLANK
            if text and not text.startswith((".*", ";")):
                self._row(word, text, number)
            number += 1
        span = self.findings.whole_line(number - 1)
        self.findings.warning("P583", f"{word} is never closed", span, "add .END behind its last row")
        return number

    def _row(self, word: str, text: str, number: int) -> None:
        match = _ROW.fullmatch(text)
        value = None if match is None else self._value(word, match[3])
        if match is None or value is None:
            wanted = "a name and its values, as in p1 450.5 -10 300 0 180 45"
            self.findings.error("P586", "this is no row of a table", self.findings.whole_line(number), wanted)
            return
        name, type_ = self.rules.spelled(match[1]), _TYPES[word]
        if match[2] is None:
            self.data[name.casefold()] = st.Declare(number, name, type_, value, shared=True)
            return
        index = tuple(int(part) for part in match[2].split(",") if part.strip())
        if not index or max(index) > _MOST_ELEMENTS:
            wanted = f"indices from 0 to {_MOST_ELEMENTS}"
            self.findings.error("P586", "an index out of range", self.findings.whole_line(number), wanted)
            return
        self.elements.setdefault(name, {})[index] = value

    def _value(self, word: str, text: str) -> ex.Expression | None:
        """What the columns of a row say; where somebody remembers, worked out once."""
        found: ex.Expression | None = None if self._values is None else self._values.get((word, text))
        if found is None:
            found = _value(word, text)
            if self._values is not None and found is not None:
                self._values.put((word, text), found)
        return found

    def _close_arrays(self) -> None:
        for name, elements in self.elements.items():
            widths = Counter(map(len, elements))
            width = widths.most_common(1)[0][0]
            kept = {index: value for index, value in elements.items() if len(index) == width}
            first = next(iter(kept.values()))
            type_, missing = _gap(first)
            sizes = tuple(ex.Number(max(index[at] for index in kept) + 1) for at in range(width))
            if not self._takes(sizes):
                message, help = (
                    f"{name} makes the arrays too large",
                    f"at most {_MOST_ROOM:,} elements in all",
                )
                self.findings.once(Severity.ERROR, "P586", "room", message, Span(0), help)
                continue
            self.data[name.casefold()] = st.Declare(
                0, name, type_, array(type_, kept, missing), sizes, shared=True
            )

    def _widen_arrays(self, sizes: Mapping[str, tuple[ex.Number, ...]], set_at: Mapping[str, int]) -> None:
        """Arrays of tables grow where the program sets elements beyond; `set_at`: the first line that sets one."""
        for name, elements in self.elements.items():
            key = name.casefold()
            declared = self.data.get(key)
            if declared is None or declared.name != name:
                continue
            now = tuple(one for one in declared.sizes if isinstance(one, ex.Number))
            if key in set_at and key not in sizes:
                self._tell_sizes(name, now, set_at[key])
            wanted = sizes.get(key, ())
            if len(wanted) != len(now):
                continue
            new = tuple(
                ex.Number(max(one.value, other.value)) for one, other in zip(wanted, now, strict=True)
            )
            if new == now or not self._takes(new):
                continue
            kept = {index: value for index, value in elements.items() if len(index) == len(now)}
            type_, missing = _gap(next(iter(kept.values())))
            kept.setdefault(tuple(int(one.value) - 1 for one in new), missing)
            self.data[key] = replace(declared, value=array(type_, kept, missing), sizes=new)

    def _takes(self, sizes: tuple[ex.Number, ...]) -> bool:
        """Whether there is room for one more array of these sizes."""
        self.room -= math.prod(int(size.value) for size in sizes)
        return self.room >= 0

    # --- programs ---------------------------------------------------------------------------------------

    def _routine(self, head: re.Match[str], number: int) -> tuple[st.Routine, int]:
        lines, start = self.findings.source.lines, number
        self.kinds[number - 1] = st.LineKind.RECORD
        body = _AsBody(self.findings, self.parser, self.levels)
        body.body, self.outside = self.outside, []
        if behind := _parted(lines[number - 1])[1]:
            body.body.append(st.Comment(number, behind))
        number += 1
        closed = False
        while number <= len(lines) and not closed:
            text = lines[number - 1].strip()
            if text.upper().startswith(".END"):
                self.kinds[number - 1], closed = st.LineKind.RECORD, True
            elif text.startswith(".") and (_HEAD.match(text) or text.upper().startswith(_TABLES)):
                break
            else:
                body.line(text, number)
            number += 1
        if not closed:
            span = self.findings.whole_line(start)
            self.findings.error(
                "P583", "the program is never closed", span, "add .END behind its last instruction"
            )
        statements = body.finish()
        check_blocks(self.findings, statements, "P583")
        parameters = tuple(_parameters(head[2] or "", self.rules))
        name = self.rules.spelled(head[1])
        routine = st.Routine(
            name, start, tuple(statements), PointTable(), parameters=parameters, last_line=number - 1
        )
        return routine, number

    def _with_arrays(self, routine: st.Routine, indexed: Mapping[str, tuple[ex.Number, ...]]) -> st.Routine:
        """Variables come into being when they are given a value: those of the program (.name) here, others for all."""
        own: dict[str, st.Declare] = {}
        given = {p.name.casefold() for p in routine.parameters}
        types = {p.name.casefold(): p for p in routine.parameters}
        for one in routine.body:
            target = (
                one.target
                if isinstance(one, st.Assign)
                else one.variable
                if isinstance(one, st.For)
                else None
            )
            base = target.base if isinstance(target, ex.Item) else target
            if not isinstance(base, ex.Named) or base.name.casefold() in given:
                continue
            count = len(target.indices) if isinstance(target, ex.Item) else 0
            sizes = indexed.get(base.name.casefold(), (ex.Number(_SIZES.get(count, 20)),) * count)
            if base.name.casefold() not in self.data.keys() | own.keys() and not self._takes(sizes):
                sizes = (ex.Number(1),) * count
            local = _is_own(base.name)
            place = own if local else self.data
            type_ = self._type(one.value, {**types, **own}) if isinstance(one, st.Assign) else _counter(one)
            if type_ == "variable" and _POINT.match(self.findings.source.line(one.line)):
                type_ = "joints" if base.name.lstrip(".").startswith("#") else "position"
            if base.name.startswith("$"):
                type_ = "string"
            elif base.name.casefold() in self.logical:
                type_ = "boolean"
            line = routine.line if local else 0
            if count and base.name.casefold() not in indexed.keys() | place.keys():
                self._tell_sizes(base.name, sizes, one.line)
            place.setdefault(base.name.casefold(), st.Declare(line, base.name, type_, None, sizes))
        return replace(routine, body=(*own.values(), *routine.body)) if own else routine

    def _with_results(self, routines: list[st.Routine]) -> list[st.Routine]:
        """Variables that come into being where a program is called that gives them their value."""
        changed = _changed_parameters(routines)
        parameters = {r.name.casefold(): r.parameters for r in routines}
        found: list[st.Routine] = []
        for r in routines:
            known = {p.name.casefold() for p in r.parameters}
            known |= {one.name.casefold() for one in r.body if isinstance(one, st.Declare)}
            own: list[st.Statement] = []
            for called, at, e in _handed(r):
                if (called, at) not in changed or not isinstance(e, ex.Named):
                    continue
                name, given = e.name.casefold(), parameters[called][at]
                if name in known or name in self.data or given.sizes:
                    continue
                type_ = "string" if e.name.lstrip(".").startswith("$") else given.type
                if _is_own(e.name):
                    known.add(name)
                    own.append(st.Declare(r.line, e.name, type_, None))
                else:
                    self.data[name] = st.Declare(0, e.name, type_, None)
            found.append(replace(r, body=(*own, *r.body)) if own else r)
        return found

    def _tell_sizes(self, name: str, sizes: tuple[ex.Number, ...], line: int) -> None:
        """An array that only computed indices fill."""
        taken = " x ".join(str(size.value) for size in sizes)
        message = f"nothing here tells how many elements {name} has: {taken} are taken"
        help = "write the indices out, or its values in a table"
        self.findings.once(Severity.INFO, "P589", name, message, self.findings.whole_line(line), help)

    def _type(self, value: ex.Expression, own: Mapping[str, st.Declare | st.Parameter]) -> str:
        """Of a variable that gets this value; `own`: what the program takes and has for itself."""
        base = value.base if isinstance(value, ex.Item) else value
        if isinstance(base, ex.Named):
            known = own.get(base.name.casefold()) or self.data.get(base.name.casefold())
            return known.type if known else "variable"
        if isinstance(value, ex.Member):  # DX, DY, DZ
            return "real"
        if isinstance(value, ex.PositionLiteral):
            return "position" if value.kind == "pose" else "joints"
        if isinstance(value, ex.Function) and value.name in _NUMERIC:
            return "real"
        if isinstance(value, ex.Function) and value.name.startswith(("pose-", "forward")):
            return "position"
        if isinstance(value, ex.SystemValue) and value.name.startswith("current-"):
            return "position" if value.name == "current-pose" else "joints"
        numeric = isinstance(value, ex.Signal) and value.bus.endswith("-group")
        numeric = numeric or (isinstance(value, ex.SystemValue) and value.name == "timer")
        return "real" if numeric or isinstance(value, (ex.Number, ex.Binary, ex.Unary)) else "variable"

    def _declare_groups(self, routines: list[st.Routine]) -> None:
        """The signals that BITS names, as groups of the program."""
        for e in (e for r in routines for s in r.body for e in expressions_of(s)):
            if (
                not isinstance(e, ex.Signal)
                or not e.bus.endswith("-group")
                or not isinstance(e.index, ex.Text)
            ):
                continue
            bus = e.bus.removesuffix("-group")
            first, last = (ex.Signal(bus, ex.Number(int(part))) for part in e.index.value.split("_")[-2:])
            signals = ex.RecordLiteral("SIGNAL", (("", first), ("", last)))
            name = e.index.value
            self.data.setdefault(name.casefold(), st.Declare(0, name, "signal", signals, native="SIGNAL"))

    def _with_saved(self, routine: st.Routine) -> st.Routine:
        """With the tool and the base that a saved controller held, for a program that nothing calls."""
        held = (("TOOL", st.SetTool), ("BASE", st.SetFrame))
        first = tuple(
            kind(routine.line, zyz_pose(self.saved[word][:6])) for word, kind in held if word in self.saved
        )
        return replace(routine, body=(*first, *routine.body))

    def _declare_homes(self) -> None:
        """The places of HOME, as the controller's tables have them: `1HOME` and six or more axes."""
        for word, name in zip(_HOME_ROWS, HOMES, strict=True):
            if word in self.saved:
                place = joints(self.saved[word][: self._axes()])
                self.data.setdefault(name.casefold(), st.Declare(0, name, "joints", place, shared=True))

    def _axes(self) -> int:
        """How many axes the joint values of this file have; six where it has none."""
        known = [len(d.value.values) for d in self.data.values() if _is_joints(d.value)]
        return max(set(known), key=known.count) if known else 6

    def _with_defaults(self, routine: st.Routine) -> st.Routine:
        """What a controller holds before any instruction: corners of 1 mm."""
        first = st.SetBlend(routine.line, (_FIRST_ACCURACY,))
        return replace(routine, body=(first, *routine.body))


@dataclass(slots=True)
class _SignalNumbers:
    """Which signals the numbers in variables are: outputs, inputs and internal signals share one count.

    `values`: what each variable is set to, by the routine of its own or "" and its name; None: nobody knows.
    """

    findings: Findings
    routines: list[st.Routine]
    data: dict[str, st.Declare]
    values: dict[tuple[str, str], list[ex.Expression | None]] = field(default_factory=dict)

    def known(self) -> list[st.Routine]:
        """The routines with each signal where it belongs; a condition on one of which nobody knows is not modelled."""
        if not any(
            type(e) is ex.Signal and _is_computed(e)
            for r in self.routines
            for s in r.body
            for e in expressions_of(s)
        ):
            return self.routines
        for d in self.data.values():
            held = [one for _, one in d.value.members] if isinstance(d.value, ex.RecordLiteral) else [d.value]
            self.values["", d.name.casefold()] = list(_leaves(held))
        for r in self.routines:
            for p in r.parameters:
                self.values.setdefault((r.name, p.name.casefold()), []).append(None)
            for s in r.body:
                target = (
                    s.target if isinstance(s, st.Assign) else s.variable if isinstance(s, st.For) else None
                )
                if target is not None:
                    value = s.value if isinstance(s, st.Assign) else None
                    self.values.setdefault(self._key(r, target), []).append(value)
        changed = _changed_parameters(self.routines)
        for r in self.routines:
            for called, at, handed in _handed(r):
                if (called, at) in changed:
                    self.values.setdefault(self._key(r, handed), []).append(None)
        return [replace(r, body=tuple([self._statement(r, s) for s in r.body])) for r in self.routines]

    def _key(self, r: st.Routine, e: ex.Expression) -> tuple[str, str]:
        base = e.base if isinstance(e, ex.Item) else e
        name = base.name.casefold() if isinstance(base, ex.Named) else ""
        own = _is_own(name) or (r.name, name) in self.values
        return (r.name if own else ""), name

    def _statement(self, r: st.Routine, s: st.Statement) -> st.Statement:
        def change(e: ex.Expression) -> ex.Expression:
            if type(e) is not ex.Signal or not _is_computed(e):
                return e
            buses = self._buses(r, e.index, 0)
            if len(buses) == 1 and None not in buses:
                bus = next(iter(buses))
                return ex.Signal(str(bus), self._shifted(r, e.index, FIRST_OF[str(bus)]))
            if isinstance(s, (st.SetOutput, st.PulseOutput)) and "in" not in buses:
                self._tell(s.line, "is taken as an output")
                return e
            self._tell(s.line, "is not modelled")
            return ex.CallValue("SIG", (e.index,))

        if isinstance(s, (st.SetOutput, st.PulseOutput)):
            signal = mapped(s.signal, change)
            return replace(s, signal=signal) if isinstance(signal, ex.Signal) else s
        return mapped(s, change)

    def _tell(self, line: int, what: str) -> None:
        message = f"a signal whose number nothing here tells {what}: outputs, inputs and internal ones share one count"
        help = "write the number, or set the variable to it in this file"
        self.findings.once(Severity.WARNING, "P589", what, message, self.findings.whole_line(line), help)

    def _buses(self, r: st.Routine, e: ex.Expression | None, depth: int) -> set[str | None]:
        """The kinds of signals that a number may be; None among them: nobody knows."""
        if isinstance(e, ex.Number):
            return {bus_of(int(e.value))}
        if isinstance(e, ex.Binary) and e.operator == "+" and depth < _DEEP:
            first = next((one for one in (e.left, e.right) if isinstance(one, ex.Number)), None)
            if first is not None and first.value >= min(one for one in FIRST_OF.values() if one):
                return {bus_of(int(first.value) + 1)}  # the first of them, and which one
        if isinstance(e, (ex.Named, ex.Item)) and depth < _DEEP:
            values = self.values.get(self._key(r, e), [None])
            return set().union(*(self._buses(r, one, depth + 1) for one in values)) if values else {None}
        return {None}

    def _shifted(self, r: st.Routine, e: ex.Expression, first: int) -> ex.Expression:
        """The number within its kind; written out where the variable has one value."""
        if isinstance(e, ex.Named):
            values = {one.value for one in self.values.get(self._key(r, e), []) if isinstance(one, ex.Number)}
            if len(values) == 1 and all(isinstance(v, ex.Number) for v in self.values[self._key(r, e)]):
                return ex.Number(int(values.pop()) - first)
        return ex.Binary("-", e, ex.Number(first)) if first else e


def _handed(r: st.Routine) -> Iterator[tuple[str, int, ex.Expression]]:
    """The variables that a program hands to others: the folded name of the other one, the place, the variable."""
    for s in r.body:
        if not isinstance(s, st.Call):
            continue
        for at, one in enumerate(s.arguments):
            if isinstance(one, (ex.Named, ex.Item)):
                yield s.routine.casefold(), at, one


def _changed_parameters(routines: Sequence[st.Routine]) -> set[tuple[str, int]]:
    """The parameters that programs of this file change, by their folded name and place, also through other programs."""
    places = {
        (r.name.casefold(), p.name.casefold()): (r.name.casefold(), at)
        for r in routines
        for at, p in enumerate(r.parameters)
    }
    found: set[tuple[str, int]] = set()
    handed: list[tuple[tuple[str, int], tuple[str, int]]] = []
    for r in routines:
        own = r.name.casefold()
        for s in r.body:
            target = s.target if isinstance(s, st.Assign) else s.variable if isinstance(s, st.For) else None
            base = target.base if isinstance(target, ex.Item) else target
            if isinstance(base, ex.Named) and (own, base.name.casefold()) in places:
                found.add(places[own, base.name.casefold()])
        for called, at, one in _handed(r):
            base = one.base if isinstance(one, ex.Item) else one
            if isinstance(base, ex.Named) and (own, base.name.casefold()) in places:
                handed.append((places[own, base.name.casefold()], (called, at)))
    for _ in handed:
        found.update(outer for outer, inner in handed if inner in found)
    return found


def _is_computed(e: ex.Signal) -> bool:
    return not isinstance(e.index, (ex.Number, ex.Text))


def _leaves(values: Iterable[ex.Expression | None]) -> Iterator[ex.Expression | None]:
    for one in values:
        if isinstance(one, ex.RecordLiteral):
            yield from _leaves(inner for _, inner in one.members)
        elif one is not None:
            yield one


@dataclass(slots=True)
class NextOnWays:
    """What the next move takes where a block begins, and where its ways end: a place in the body, and the fields.

    `complete`: one of its ways is always gone.
    """

    before: dict[str, Any]
    complete: bool = False
    ends: list[tuple[int, dict[str, Any]]] = field(default_factory=list)

    def leave(self, body: Sequence[st.Statement], fields: dict[str, Any]) -> None:
        last = body[-1] if body else None
        ended = isinstance(last, st.Process) and last.name in ("HALT", ENDS_CYCLE)
        ended = ended or (isinstance(last, st.Jump) and last.condition is None)
        if ended or isinstance(last, (st.Switch, st.Return)):
            return
        self.ends.append((len(body), fields))

    def outcomes(self) -> list[tuple[int | None, dict[str, Any]]]:
        """Those that nothing can be written for have no place."""
        ends: list[tuple[int | None, dict[str, Any]]] = [*self.ends]
        return ends if self.complete and ends else [*ends, (None, self.before)]


class _AsBody:
    """The instructions of one program, with what the next move takes and which block is open."""

    def __init__(self, findings: Findings, parser: LineParser, levels: Levels) -> None:
        self.levels = levels
        self.clamps: dict[str, str] = {}  # the state of each that a step has set
        self.findings, self.parser, self.kinds = findings, parser, findings.kinds
        self.body: list[st.Statement] = []
        self.open: list[type] = []
        self.next: dict[str, Any] = {}
        self.always: dict[str, Any] = {}  # what all moves take from here on
        self.passes = True  # CP
        self.rated = False  # behind ACCEL … ALWAYS
        self.accuracy: tuple[st.Blend, ...] = (_FIRST_ACCURACY,)
        self.via: tuple[ex.Expression, int] | None = None
        self.ways: list[NextOnWays] = []
        self.speed: st.SetSpeed | None = None  # of SPEED … ALWAYS, where it holds on all ways
        self.knows_accuracy = False
        self.restored: list[st.Statement] = []  # what holds again behind the next move

    def line(self, text: str, number: int) -> None:
        code, comment = _parted(text)
        if not code:
            self.kinds[number - 1] = st.LineKind.COMMENT if comment is not None else st.LineKind.BLANK
            if comment is not None:
                self.body.append(st.Comment(number, comment))
            return
        self.kinds[number - 1] = st.LineKind.STATEMENT
        label = _LABEL.match(code)
        if label and not re.match(r"ANY\s*:", code, re.IGNORECASE):
            self._pass_on(number)
            self.body.append(st.Label(number, (label[1] or label[2]).casefold()))
            code = code[label.end() :]
            if not code:
                return
        before = len(self.body)
        for one in self.parser.parse(code, number):
            self._add(one, number)
        if comment and len(self.body) > before:
            self.body[-1] = with_comment(self.body[-1], comment)

    def _add(self, one: Any, number: int) -> None:
        if isinstance(one, NextMoveFields):
            (self.always if one.always else self.next).update(one.fields)
        elif isinstance(one, (ContinuousPath, st.SetBlend)):
            self._pass(one, number)
        elif isinstance(one, PercentOfPath):
            self._tell_percent(number)
        elif isinstance(one, Arc):
            self._arc(one, number)
        elif isinstance(one, BlockStep):
            try:
                self._step(step_of(one, self.levels, number), number)
            except BrokenLineError as broken:
                self.findings.error("P580", str(broken), self.findings.whole_line(number), broken.wanted)
        elif isinstance(one, BlockEnd):
            self._follow_next(one, number)
            self._end(number)
        elif isinstance(one, st.Move):
            self.body.append(self._taken(one))
            self._put_back()
        else:
            self._follow_next(one, number)
            self.rated = self.rated or isinstance(one, st.SetAcceleration)
            self._block(one)
            self.body.append(one)

    def _step(self, step: TaughtStep, number: int) -> None:
        """A step that was taught: its move, then what it does at its end."""
        for kind, message in step.assumed:
            help = "see that the controller does so; the tables are in the .AUXDATA of a saved controller"
            self.findings.once(Severity.INFO, "P589", kind, message, self.findings.whole_line(number), help)
        if step.move.speed is not None and step.move.speed.native:
            self._tell_percent(number)
        move = step.move
        if not self.passes:
            move = changed(move, blend=_STOP)
        if step.arc is None:
            self.body.append(move)
        else:
            self._arc(Arc(move.targets[0], step.arc), number, move)
        for clamp, state in step.clamps:
            if self.clamps.get(clamp, "OFF") != state:
                self.body.append(st.Process(number, "CLAMP", ((clamp, ex.Text(state)),)))
            self.clamps[clamp] = state
        self.body += step.at_end

    def _pass(self, one: ContinuousPath | st.SetBlend, number: int) -> None:
        """The accuracy holds while moves pass their targets, and again when they do so again."""
        if isinstance(one, ContinuousPath):
            self.passes = one.on
            if self.open:
                message = "whether moves stop at their ends is that of the CP that stands last in the text"
                help = "write CP outside of IF, CASE and loops"
                span = self.findings.whole_line(number)
                self.findings.once(Severity.WARNING, "P589", "CP", message, span, help)
        else:
            self.accuracy = one.blends
            self.knows_accuracy = not self.open
            if not self.passes:
                return
        self.body.append(st.SetBlend(number, self.accuracy if self.passes else (_STOP,)))

    def _taken(self, move: st.Move) -> st.Move:
        """The move with what SPEED, ACCURACY and ACCEL before it said."""
        fields, self.next = self.always | self.next, {}
        if self.rated or "acceleration" in fields:
            fields.setdefault("deceleration", _FULL)  # ACCEL says nothing of braking
        if not self.passes:
            fields.pop("blend", None)
        speeds = fields.pop("speeds", ())
        wanted = st.SpeedUnit.FRACTION if move.path is st.Path.JOINT else st.SpeedUnit.TRAVEL
        speed = next((s for s in speeds if s.unit in (wanted, st.SpeedUnit.TIME)), None)
        if speed is not None and speed.native:
            self._tell_percent(move.line)
        return changed(move, speed=speed, **fields)  # type: ignore[no-any-return]

    def _arc(self, arc: Arc, number: int, taught: st.Move | None = None) -> None:
        """`taught`: the move of a step that was taught, with speed and accuracy of its own."""
        span = self.findings.whole_line(number)
        if not arc.end:
            if self.via is not None:  # a chain of arcs: only the last two points make one here
                one = self.via[1]
                self.body.append(self.parser.opaque(self.findings.source.line(one).strip(), one))
            self.via = (arc.target, number)
        elif self.via is None:
            self.findings.error(
                "P587", "C2MOVE without C1MOVE", span, "C1MOVE with the point on the arc before it"
            )
        else:
            via, self.via = self.via[0], None
            if taught is not None:
                self.body.append(changed(taught, via=via))
                return
            blend = st.Blend(st.BlendKind.RADIUS)
            self.body.append(
                self._taken(st.Move(number, st.Path.CIRCULAR, (arc.target,), blend=blend, via=via))
            )
            self._put_back()

    # --- what SPEED and ACCURACY without ALWAYS give the next move, on whatever way the program gets to it ---------

    def _follow_next(self, one: Any, number: int) -> None:
        """`one`: a statement, or the end of a block."""
        if isinstance(one, (st.If, st.Switch)):
            self._leave_to_next(number)
            self.ways.append(NextOnWays(dict(self.next)))
        elif isinstance(one, (st.ElseIf, st.Else, st.Case, st.Default)) and self.ways:
            self._leave_to_next(number)
            self.ways[-1].leave(self.body, self.next)
            self.ways[-1].complete |= isinstance(one, (st.Else, st.Default))
            self.next = dict(self.ways[-1].before)
        elif isinstance(one, BlockEnd) and self.ways and self.open[-1:] in ([st.If], [st.Switch]):
            self._leave_to_next(number)
            way = self.ways.pop()
            way.leave(self.body, self.next)
            self._join(way, number)
        elif isinstance(one, (BlockEnd, st.While, st.For, st.Repeat, st.Until, st.Call, st.Jump, st.Return)):
            self._pass_on(number)
        if isinstance(one, st.SetSpeed):
            self.speed = None if self.open else one
        elif isinstance(one, st.Call):  # it may set others
            self.speed, self.knows_accuracy = None, False

    def _pass_on(self, number: int) -> None:
        """A place that other ways lead to or from: what the next move there takes is not known."""
        self._leave_to_next(number)
        if self.next:
            self._tell_next(number)

    def _leave_to_next(self, number: int) -> None:
        if self.restored:
            self._tell_next(number)
            self._put_back()

    def _put_back(self) -> None:
        self.body += self.restored
        self.restored = []

    def _join(self, way: NextOnWays, number: int) -> None:
        """Behind a block: where its ways give the next move different speeds, each sets its own, until that move."""
        ends = way.outcomes()
        names = {name for _, fields in ends for name in fields}
        differing = {n for n in names if any(fields.get(n) != ends[0][1].get(n) for _, fields in ends)}
        if not differing:
            self.next = dict(ends[0][1])
            return
        speeds = bool(differing & {"speeds", "turn"})
        known = not speeds or self.speed is not None
        known = known and ("blend" not in differing or (self.knows_accuracy and self.passes))
        placed = all(at is not None or not differing & fields.keys() for at, fields in ends)
        if not known or not placed or differing - {"speeds", "turn", "blend"}:
            self._tell_next(number)
            return
        for at, fields in reversed(ends):
            rows: list[st.Statement] = []
            line = self.body[at - 1].line if at else number
            if speeds and "speeds" in fields:
                rows.append(st.SetSpeed(line, fields["speeds"], turn=fields.get("turn")))
            if "blend" in differing and "blend" in fields:
                rows.append(st.SetBlend(line, (fields["blend"],)))
            if rows:
                self.body[at:at] = rows
        self.restored = [replace(self.speed, line=number)] if speeds and self.speed is not None else []
        if "blend" in differing:
            self.restored.append(st.SetBlend(number, self.accuracy))
        kept = {
            name for name in names if name not in differing and not (speeds and name in ("speeds", "turn"))
        }
        self.next = {name: ends[0][1][name] for name in kept}

    def _tell_next(self, number: int) -> None:
        message = (
            "SPEED, ACCURACY or ACCEL for the next move, whichever that is: the next one in the text is taken"
        )
        help = "write it right before the move, or with ALWAYS"
        span = self.findings.whole_line(number)
        self.findings.add(Severity.WARNING, "P589", message, span, help)

    def _block(self, one: st.Statement) -> None:
        if isinstance(one, (st.If, st.While, st.For, st.Switch, st.Repeat)):
            self.open.append(type(one))
        elif isinstance(one, st.Until) and self.open[-1:] == [st.Repeat]:
            self.open.pop()

    def _end(self, number: int) -> None:
        """END closes the innermost block, whatever it is."""
        if not self.open or self.open[-1] is st.Repeat:
            span = self.findings.whole_line(number)
            self.findings.warning("P583", "END without a block", span, "remove it, or open a block above")
            return
        opener = self.open.pop()
        if opener is st.For:
            self.body.append(st.Next(number, None))
        elif opener is st.If:
            self.body.append(st.EndIf(number))
        else:
            self.body.append(st.EndWhile(number) if opener is st.While else st.EndSwitch(number))

    def _tell_percent(self, number: int) -> None:
        message = "100 % of a path is taken as 1 m/s: no program says what its controller's full speed is"
        help = "write the speed of paths in MM/S, that of joint moves in percent"
        self.findings.once(Severity.INFO, "P588", "", message, self.findings.whole_line(number), help)

    def finish(self) -> list[st.Statement]:
        if (self.next or self.restored) and self.body:
            self._pass_on(self.body[-1].line)
        if self.via is not None:
            span = self.findings.whole_line(self.via[1])
            self.findings.error("P587", "C1MOVE without C2MOVE", span, "C2MOVE with the arc's end behind it")
        return self.body


_TYPES: Final = {
    ".TRANS": "position",
    ".JOINTS": "joints",
    ".REALS": "real",
    ".INTEGER": "integer",
    ".STRINGS": "string",
}


def _levels(lines: Sequence[str]) -> dict[str, tuple[float, ...]]:
    """What the tables of a saved controller say of the levels of steps that were taught."""
    rows = _rows(lines, ".AUXDATA", tuple(LEVELS))
    found = {word: values for word, values in rows.items() if len(values) >= len(LEVELS[word])}
    return found | {"saved": (1.0,)} if found else found


def _rows(lines: Sequence[str], section: str, wanted: tuple[str, ...]) -> dict[str, tuple[float, ...]]:
    """The first rows of these words, with nothing but numbers behind them, in a section of a saved controller."""
    found: dict[str, tuple[float, ...]] = {}
    inside = False
    mark = section.casefold()
    for line in lines if any(line[:20].lstrip().casefold().startswith(mark) for line in lines) else ():
        parts = line.split()
        if line.lstrip().startswith("."):
            inside = line.lstrip().casefold().startswith(mark) or (inside and line.lstrip().startswith(".*"))
        elif (
            inside
            and len(parts) > 1
            and parts[0].upper() in wanted
            and all(map(_NUMBER.fullmatch, parts[1:]))
        ):
            values = tuple(map(float, parts[1:]))
            if all(map(math.isfinite, values)):
                found.setdefault(parts[0].upper(), values)
    return found


def _places(lines: Sequence[str], section: str, wanted: tuple[str, ...]) -> dict[str, tuple[float, ...]]:
    """The rows of these words that hold a place: six values or more."""
    return {word: values for word, values in _rows(lines, section, wanted).items() if len(values) >= 6}


def _counter(s: st.Statement) -> str:
    """The type of what counts a loop: an integer, but where the loop counts fractions."""
    counted = (s.start, s.step) if isinstance(s, st.For) else ()
    fractions = [e for e in counted if isinstance(e, ex.Number) and not float(e.value).is_integer()]
    return "real" if fractions else "integer"


def _is_own(name: str) -> bool:
    """Whether a variable is its program's own: `.x`, `#.x`, `$.x`; `p.offset` is everybody's."""
    return name.lstrip("#$").startswith(".")


_ONLY_READ: Final = (
    st.Move, st.If, st.ElseIf, st.While, st.Until, st.Switch, st.Case, st.Wait, st.Dwell, st.SetOutput, st.Message,
)  # fmt: skip
_NAME: Final = re.compile(r"[.$A-Za-z][.$\w]*")
_CHAIN: Final = 50  # sums and variables of which a value is made


class _Largest:
    """The largest values that variables have where the programs of a file set them; None where that is open.

    A table's value takes no part: it is what a variable had when the file was saved. Names are case folded; those of
    one program (.name) go with it.
    """

    def __init__(self, routines: Iterable[st.Routine], lines: Sequence[str]) -> None:
        self._lines = lines
        self._set: dict[tuple[str, str], list[tuple[str, ex.Expression]] | None] = {}
        self._counted: set[tuple[str, str]] = set()  # what else than a loop sets as well
        self._known: dict[tuple[str, str], float | None] = {}
        for r in routines:
            self._open(r.name, (p.name for p in r.parameters))  # callers decide
            for s in r.body:
                self._note(r.name, s)

    def _note(self, routine: str, s: st.Statement) -> None:
        if isinstance(s, st.Assign):
            base = s.target.base if isinstance(s.target, ex.Item) else s.target
            if isinstance(base, ex.Named):
                self._add(self._key(routine, base.name), routine, s.value)
                self._counted.add(self._key(routine, base.name))
        elif isinstance(s, st.For) and isinstance(s.variable, ex.Named):
            behind = ex.Binary("+", s.stop, s.step or ex.Number(1))
            for value in (s.start, s.stop, behind):
                self._add(self._key(routine, s.variable.name), routine, value)
        elif isinstance(s, (st.Opaque, st.Process)):
            self._open(routine, _NAME.findall(self._lines[s.line - 1]))
        elif not isinstance(s, _ONLY_READ):
            self._open(routine, (e.name for e in expressions_of(s) if isinstance(e, ex.Named)))

    def _add(self, key: tuple[str, str], routine: str, value: ex.Expression) -> None:
        values = self._set.setdefault(key, [])
        if values is not None:
            values.append((routine, value))

    def _open(self, routine: str, names: Iterable[str]) -> None:
        for name in names:
            self._set[self._key(routine, name)] = None
            self._counted.add(self._key(routine, name))

    def _key(self, routine: str, name: str) -> tuple[str, str]:
        return (routine if _is_own(name) else "", name.casefold())

    def of(
        self, routine: str, e: ex.Expression, loops: Mapping[str, ex.Expression], deep: int = 0
    ) -> float | None:
        """`loops`: case folded counters of the loops around it -> their ends. `deep`: how far inside another value."""
        e = e.base if isinstance(e, ex.Item) else e
        if isinstance(e, ex.Number) or deep > _CHAIN:
            return e.value if isinstance(e, ex.Number) else None
        if isinstance(e, ex.Named):
            key, stop = self._key(routine, e.name), loops.get(e.name.casefold())
            if stop is None or key in self._counted:
                return self._variable(key, deep + 1)
            return self.of(routine, stop, {}, deep + 1)
        if not isinstance(e, ex.Binary) or e.operator not in ("+", "-"):
            return None
        if e.operator == "-" and not isinstance(e.right, ex.Number):
            return None
        parts = [self.of(routine, one, loops, deep + 1) for one in (e.left, e.right)]
        if parts[0] is None or parts[1] is None:
            return None
        return parts[0] + parts[1] if e.operator == "+" else parts[0] - parts[1]

    def _variable(self, key: tuple[str, str], deep: int) -> float | None:
        if key not in self._known:
            self._known[key] = None  # what counts itself has no end that the text tells
            found = [self.of(routine, value, {}, deep) for routine, value in self._set.get(key) or ()]
            told = [one for one in found if one is not None]
            self._known[key] = max(told) if told and len(told) == len(found) else None
        return self._known[key]


class _Sizes:
    """Of the arrays of which every index is written out or counted up to a known number, also by who is handed them."""

    def __init__(self, routines: list[st.Routine], lines: Sequence[str]) -> None:
        self._largest = _Largest(routines, lines)
        self._takes = {r.name.casefold(): r.parameters for r in routines}
        self._found: dict[str, tuple[int, ...] | None] = {}
        self._same: dict[str, str] = {}  # an array -> one that is handed to it or that it is handed to
        self.set_at: dict[str, int] = {}  # arrays of which elements are set -> the first line that sets one
        for r in routines:
            self._read(r)

    def _read(self, r: st.Routine) -> None:
        loops: list[tuple[str, st.For]] = []
        for s in r.body:
            inside = {name: one.stop for name, one in loops if _rises(one.step)}
            for e in expressions_of(s):
                if isinstance(e, ex.Item) and isinstance(e.base, ex.Named):
                    at = [self._largest.of(r.name, index, inside) for index in e.indices]
                    told = tuple(int(one) for one in at if one is not None and one <= _MOST_ELEMENTS)
                    self._note(e.base.name.casefold(), told if len(told) == len(at) else None)
            target = s.target if isinstance(s, st.Assign) else None
            if isinstance(target, ex.Item) and isinstance(target.base, ex.Named):
                self.set_at.setdefault(target.base.name.casefold(), s.line)
            if isinstance(s, st.For):
                loops.append((s.variable.name.casefold() if isinstance(s.variable, ex.Named) else "", s))
            elif isinstance(s, st.Next) and loops:
                loops.pop()
            elif isinstance(s, st.Call):
                self._hand(s)

    def _hand(self, s: st.Call) -> None:
        takes = self._takes.get(s.routine.casefold(), ())
        for place, e in enumerate(s.arguments):
            if isinstance(e, ex.Named) and place < len(takes):
                one, other = self._root(e.name.casefold()), self._root(takes[place].name.casefold())
                if one != other:
                    self._same[other] = one
                    if other in self._found:
                        self._note(one, self._found.pop(other))
            elif isinstance(e, ex.Named):
                self._note(e.name.casefold(), None)

    def _root(self, name: str) -> str:
        root = name
        while root in self._same:
            root = self._same[root]
        if root != name:
            self._same[name] = root
        return root

    def _note(self, name: str, indices: tuple[int, ...] | None) -> None:
        name = self._root(name)
        known = self._found.get(name, indices)
        both = None if known is None or indices is None or len(known) != len(indices) else (known, indices)
        self._found[name] = None if both is None else tuple(map(max, *both))

    def known(self) -> dict[str, tuple[ex.Number, ...]]:
        names = (*self._found, *self._same)
        found = {name: self._found.get(self._root(name)) for name in names}
        return {
            name: tuple(map(ex.Number, sizes)) for name, sizes in found.items() if sizes and min(sizes) > 0
        }


def _rises(step: ex.Expression | None) -> bool:
    return step is None or (isinstance(step, ex.Number) and step.value > 0)


def _gap(element: ex.Expression) -> tuple[str, ex.Expression]:
    """The type of an array by one of its elements, and what stands where none was given."""
    if isinstance(element, ex.PositionLiteral):
        return "position" if element.kind == "pose" else "joints", _UNTAUGHT[element.kind]
    return ("string", ex.Text("")) if isinstance(element, ex.Text) else ("real", ex.Number(0))


def _value(word: str, text: str) -> ex.Expression | None:
    if word == ".STRINGS":
        return ex.Text(text.strip().strip('"'))
    words = text.split(";")[0].replace(",", " ").split()
    if not words or not all(_NUMBER.fullmatch(one) for one in words) or any(len(one) > 40 for one in words):
        return None
    numbers = [float(one) for one in words]
    if not all(map(math.isfinite, numbers)):
        return None
    if word == ".TRANS":
        return zyz_pose(numbers[:6]) if len(numbers) >= 6 else None
    if word == ".JOINTS":
        return joints(numbers) if len(numbers) >= 3 else None
    return (
        ex.Number(int(numbers[0]) if words[0].lstrip("+-").isdigit() else numbers[0])
        if len(words) == 1
        else None
    )


def _parted(text: str) -> tuple[str, str | None]:
    """The instruction and its comment; a semicolon in a text is part of the text."""
    if ";" not in text:
        return text, None
    at, quoted = 0, False
    for at, char in enumerate(text):
        if char == '"':
            quoted = not quoted
        elif char == ";" and not quoted:
            return text[:at].rstrip(), text[at + 1 :]
    return text, None


def _parameters(text: str, rules: AsRules) -> Iterator[st.Parameter]:
    """What a program takes: `&` marks a place, `#` joint values, `$` a text; all others are numbers."""
    for part in re.split(r",(?![\s,]*\])", text):
        name, _, indices = part.partition("[")
        name = name.strip()
        signs = name[:3]
        kind = (
            "position" if "&" in signs else "joints" if "#" in signs else "string" if "$" in signs else "real"
        )
        name = name.replace("&", "")
        if name:
            yield st.Parameter(
                rules.spelled(name),
                kind,
                by_reference=True,
                native="[]" if indices else "",
                sizes=(ex.Unknown(""),) * (indices.count(",") + 1) if indices else (),
            )


def _main(routines: list[st.Routine]) -> str:
    """The first program that no other one calls: a file does not say which of its programs runs."""
    free = _started(routines)
    return next((one.name for one in routines if one.name in free or not free), "")


def _started(routines: list[st.Routine]) -> frozenset[str]:
    """The programs that no other one calls."""
    called = {
        one.routine.casefold()
        for routine in routines
        for one in routine.body
        if isinstance(one, (st.Call, st.StartTask))
    }
    return frozenset(one.name for one in routines if one.name.casefold() not in called)


def _is_joints(value: ex.Expression | None) -> TypeGuard[ex.PositionLiteral]:
    return isinstance(value, ex.PositionLiteral) and value.kind == "joint"
