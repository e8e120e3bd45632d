"""What a file declares: spellings, types, structures, constants and signals, gathered before it is read in detail."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from olp.ir.expressions import RecordLiteral
from olp.ir.program import Declare
from olp.languages.vendors.rapid.clauses import Clause
from olp.languages.vendors.rapid.predefined_data import (
    RECORDS,
    SIGNAL_TYPES,
    SIGNAL_USERS,
    SPEEDS,
    TYPES,
    ZONES,
)

_DATA: Final = re.compile(
    r"(?:(?:LOCAL|TASK)\s+)?(CONST|PERS|VAR)\s+(\w+)\s+(\w+)\s*(\{[^}]{0,500}\}\s*)?(?::=(.*))?;?\Z",
    re.IGNORECASE | re.DOTALL,
)
# Most of a file are points: of them, and of all data but speeds and zones, the value says nothing here.
_BEGIN: Final = re.compile(
    r"(?:(?:LOCAL|TASK)\s++)?(?:CONST|PERS|VAR)\s++(\w++)\s++(\w++)\s*+:=", re.IGNORECASE
)
_OF_VALUE: Final = frozenset({"speeddata", "zonedata", "welddata"})
# The weld speed of a welddata whose electrical data are a list; older ones begin with the number of a schedule.
_FIRST: Final = re.compile(r"\s*\[\s*([0-9.]+(?:E[-+]?[0-9]{1,2})?)\s*,[^][]*\[", re.IGNORECASE)
_HEAD: Final = re.compile(
    r"(?:LOCAL\s+)?(PROC|FUNC|TRAP)\s+(?:(\w+)\s+)??(\w+)\s*(?:\((.*)\)\s*)?\Z", re.IGNORECASE | re.DOTALL
)
_PARAMETER: Final = re.compile(
    r"(\\)?\s*(?:(INOUT|VAR|PERS|REF)\s+)?(\w+)\s+(\w+)\s*(\{[^}]{0,200}\})?\s*(?=[,|\\]|\Z)", re.IGNORECASE
)
_ASSIGNED: Final = re.compile(r"(?<!\\)\b(\w+)\s*(?:\{[^}{]{0,200}\}\s*)?(?:\.\s*\w+\s*){0,16}:=")
_STOPS: Final = re.compile(r"\b(\w+)\s*(?:\{[^}{]{0,200}\}\s*)?\.\s*finep\s*:=", re.IGNORECASE)
_USED: Final = re.compile(
    rf"\b({'|'.join(sorted(SIGNAL_USERS, key=len, reverse=True))})\b"
    r"\s*(?:\(\s*)?(?:\\\w+\s*(?::=\s*[\w.]+\s*)?(?:,\s*)?)*(\w+)",
    re.IGNORECASE,
)
_ALIASED: Final = re.compile(r"\bAliasIO\b[^;]*,\s*(\w+)\s*;?\s*\Z", re.IGNORECASE)
_NUMBERS: Final = re.compile(r"\[\s*([^\[\]\"]*)\]\Z")
_COMPONENT: Final = re.compile(r"(\w+)\s+(\w+)\s*;?\Z")
_SIGNAL_LIKE: Final = re.compile(r"(?:di|do|gi|go|ai|ao)(?=[_0-9A-Z])|(?:DI|DO|GI|GO|AI|AO)(?=[_0-9])")
_LONG: Final = 120
STRUCTURE: Final = "structure"  # the type of a declaration that lists the members of a structure
_WHOLE: Final = ("tool", "frame")  # neutral types that every language has, each in its own form
_BUSES: Final = {
    "di": "in", "do": "out", "gi": "in-group", "go": "out-group", "ai": "analog-in", "ao": "analog-out",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class RoutineHead:
    """The signature of a routine of the file: types of its parameters in order, and of its value."""

    name: str
    kind: str
    parameters: tuple[tuple[str, str, bool], ...]  # name, type, optional
    returns: str


@dataclass(slots=True)
class RapidNames:
    """The symbol table of a file; keys are lower case.

    `types`: of data outside routines; `inside`: types of local data by the line of their routine.
    """

    spelling: dict[str, str] = field(default_factory=dict)
    types: dict[str, str] = field(default_factory=dict)
    inside: dict[int, dict[str, str]] = field(default_factory=dict)
    records: dict[str, tuple[tuple[str, str], ...]] = field(default_factory=dict)
    aliases: dict[str, str] = field(default_factory=dict)
    routines: dict[str, RoutineHead] = field(default_factory=dict)
    constants: dict[str, tuple[str, tuple[str, ...]]] = field(default_factory=dict)  # type, numbers
    assigned: set[str] = field(default_factory=set)
    stopping: set[str] = field(default_factory=set)  # zones with an assignment to their finep
    signals: dict[str, str] = field(default_factory=dict)  # name -> bus
    aliased: set[str] = field(default_factory=set)  # data that AliasIO connects to a signal
    local: dict[str, str] = field(default_factory=dict)  # types of the routine that is read
    arrays: dict[str, int] = field(default_factory=dict)  # name -> number of dimensions
    uneven: bool = False  # a quaternion that is not of unit length was read
    unturned: bool = False  # a quaternion of zeros was read

    def spelled(self, name: str) -> str:
        """The name in the spelling of its first declaration, or of its first use."""
        return self.spelling.setdefault(name.lower(), name)

    def type_of(self, name: str) -> str:
        """RAPID's type of a name, lower case, aliases resolved; empty where nothing declares it."""
        key = name.lower()
        return self.resolved(self.local.get(key) or self.types.get(key, ""))

    def resolved(self, kind: str) -> str:
        for _ in range(8):
            if kind not in self.aliases:
                break
            kind = self.aliases[kind]
        return kind

    def members(self, kind: str) -> tuple[tuple[str, str], ...] | None:
        """Members of a structure with their types; None for a type that is no structure."""
        return self.records.get(kind) or RECORDS.get(kind)

    def layouts(self, kind: str, line: int) -> list[Declare]:
        """Declarations of a structure that the program defines, and of predefined structures among its members."""
        members = self.records.get(kind.lower(), ())
        found = [_layout(kind, line, members)]
        for word in dict.fromkeys(word for _, word in members):
            if word in RECORDS and TYPES.get(word) not in _WHOLE:
                found.append(_layout(word, line, RECORDS[word]))
        return found

    def knows(self, name: str) -> bool:
        key = name.lower()
        return key in self.local or key in self.types

    def bus_of(self, name: str) -> str | None:
        """The bus of an undeclared name, by its use or its prefix; None for a name that is no signal."""
        key = name.lower()
        if key in self.signals:
            return self.signals[key]
        return None if key in self.routines else signal_like(name)

    def signal_variable(self, name: str) -> str | None:
        """The bus of a parameter of a signal type, or of data that AliasIO connects; None for others."""
        key = name.lower()
        if key not in self.local and key not in self.aliased:
            return None
        return SIGNAL_TYPES.get(self.type_of(name))

    def steady(self, name: str, kind: str) -> tuple[str, ...] | None:
        """The numbers in the declaration of a speed or zone that nothing assigns; None for all others."""
        key = name.lower()
        if key in self.local or key in self.assigned:
            return None
        found = self.constants.get(key)
        return found[1] if found is not None and found[0] == kind else None


def signal_like(name: str) -> str | None:
    """The bus that a name's prefix means (`di1`, `do_grip`, `goCode`); None for other names."""
    like = _SIGNAL_LIKE.match(name)
    return _BUSES[like[0].lower()] if like else None


def gather(clauses: Sequence[object]) -> RapidNames:
    """The names of a file, from its clauses in order."""
    names = RapidNames()
    inside: dict[str, str] | None = None
    record: tuple[str, list[tuple[str, str]]] | None = None
    for clause in clauses:
        if not isinstance(clause, Clause) or clause.word == "MOVE":
            continue
        word, text = clause.word, clause.text
        if not word and record is None and text[0] in "cCpPvVlLtT":
            begin = _BEGIN.match(text)
            if begin is not None and begin[1].lower() not in _OF_VALUE:
                _declared(names, begin[1], begin[2], inside)
                continue
        if len(text) > _LONG:
            text = " ".join(text.split())  # long runs of blanks take a regular expression long
        if record is not None:
            record = _component(names, record, clause)
        elif word in ("PROC", "FUNC", "TRAP"):
            inside = names.inside.setdefault(clause.line, {})
            _head(names, text, inside)
        elif word in ("ENDPROC", "ENDFUNC", "ENDTRAP", "ENDMODULE"):
            inside = None
        elif word == "RECORD":
            record = (text.split()[-1], [])
        elif text[:5].upper() == "ALIAS" and text[5:7].upper() != "IO":
            _alias(names, text)
        else:
            _other(names, text, inside)
    return names


def _other(names: RapidNames, text: str, inside: dict[str, str] | None) -> None:
    if text[0] in "cCpPvVlLtT":
        match = _DATA.match(text)
        if match is not None:
            _data(names, match, inside)
            return
    if text[:4].upper() == "FOR ":
        name = text.split()[1] if len(text.split()) > 1 else ""
        names.spelled(name)
        if inside is not None:
            inside.setdefault(name.lower(), "num")
    if ":=" in text:
        names.assigned.update(name.lower() for name in _ASSIGNED.findall(text))
        names.stopping.update(name.lower() for name in _STOPS.findall(text))
    if (alias := _ALIASED.search(text)) is not None:
        names.aliased.add(alias[1].lower())
    for user, name in _USED.findall(text):
        names.signals.setdefault(name.lower(), SIGNAL_USERS[user.lower()])


def _declared(names: RapidNames, kind: str, name: str, inside: dict[str, str] | None) -> None:
    key = name.lower()
    names.spelling.setdefault(key, name)
    (names.types if inside is None else inside).setdefault(key, kind.lower())


def _data(names: RapidNames, match: re.Match[str], inside: dict[str, str] | None) -> None:
    _, kind, name, sizes, value = match.groups()
    key, kind = name.lower(), kind.lower()
    _declared(names, kind, name, inside)
    if sizes:
        names.arrays.setdefault(key, sizes.count(",") + 1)
    if kind == "welddata" and value and not sizes:
        if (first := _FIRST.match(value)) is not None:
            names.constants.setdefault(key, (kind, (first[1],)))
    elif kind in ("speeddata", "zonedata") and value and not sizes:
        value = value.rstrip("; \t\n").lstrip()
        numbers = _NUMBERS.match(value)
        if numbers is not None:
            names.constants.setdefault(key, (kind, tuple(n.strip() for n in numbers[1].split(","))))
        elif value.lower() in (SPEEDS if kind == "speeddata" else ZONES):
            names.constants.setdefault(key, (kind, (value.lower(),)))


def _head(names: RapidNames, text: str, inside: dict[str, str]) -> None:
    match = _HEAD.match(text)
    if match is None:
        return
    kind, returns, name, listed = match.groups()
    names.spelled(name)
    parameters = []
    for optional, _, of, called, sizes in _PARAMETER.findall(listed or ""):
        names.spelled(called)
        if sizes:
            names.arrays.setdefault(called.lower(), sizes.count(",") + 1)
        inside[called.lower()] = of.lower()
        parameters.append((called, of.lower(), bool(optional)))
    head = RoutineHead(name, kind.upper(), tuple(parameters), (returns or "").lower())
    names.routines.setdefault(name.lower(), head)


def _alias(names: RapidNames, text: str) -> None:
    parts = text.rstrip("; \t\n").split()
    if len(parts) == 3:
        names.aliases[parts[2].lower()] = parts[1].lower()


def _layout(name: str, line: int, members: Sequence[tuple[str, str]]) -> Declare:
    value = RecordLiteral("RECORD", tuple((m, RecordLiteral(word.upper(), ())) for m, word in members))
    return Declare(line, name, STRUCTURE, value, shared=True, native="RECORD")


def _component(
    names: RapidNames, record: tuple[str, list[tuple[str, str]]], clause: Clause
) -> tuple[str, list[tuple[str, str]]] | None:
    if clause.word in ("ENDRECORD", "ENDMODULE", "PROC", "FUNC"):
        names.records[record[0].lower()] = tuple(record[1])
        return None
    match = _COMPONENT.match(clause.text)
    if match is not None:
        record[1].append((match[2], match[1].lower()))
    return record
