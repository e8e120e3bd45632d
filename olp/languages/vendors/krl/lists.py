"""Reads data lists: DEFDAT … ENDDAT with their declarations and the values of array elements."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import replace
from math import prod
from typing import Final

from olp.ir.expressions import Expression, Item, Member, Named, Number, RecordLiteral, Unknown
from olp.ir.program import Assign, Declare, LineKind
from olp.languages.findings import Findings
from olp.languages.vendors.krl import fast, parsing
from olp.languages.vendors.krl.declarations import Head, Tail
from olp.languages.vendors.krl.parsing import KrlLineReader
from olp.languages.vendors.krl.scope import NEUTRAL_TYPES, Scope

_NAME = re.compile(r"[$A-Za-z_][\w$]*")
_MODIFIERS = frozenset({"DECL", "GLOBAL", "CONST"})
_MOST_ELEMENTS = 20_000  # of one array that have a value
_MOST_PLACES = 200_000


class ListReader:
    """Reads the rows of one list. `only`: names in capitals whose rows are wanted; None: all.

    `placed`: whether they stand in the program's own text, so that they have its lines.
    """

    def __init__(
        self,
        findings: Findings,
        scope: Scope,
        reader: KrlLineReader,
        only: Collection[str] | None = None,
        placed: bool = True,
    ) -> None:
        self._findings = findings
        self._scope = scope
        self._reader = reader
        self._only = only
        self._placed = placed
        self.declared: dict[str, Declare] = {}
        self._comment = ""
        self._above: list[str] = []  # comments, for the next declaration
        self._records: dict[tuple[str, str], Expression] = {}
        self._elements: dict[str, dict[tuple[int, ...], Expression]] = {}

    def comment(self, text: str) -> None:
        """A comment alone on its line."""
        self._above.append(text)

    def row(self, code: str, number: int, comment: str = "") -> Head | Tail | None:
        """One line and the comment behind it. Heads and tails are given back."""
        self._comment = comment
        plain = fast.ROW.fullmatch(code)
        if plain is not None and self._plain(plain, number):
            return None
        record = fast.RECORD_ROW.fullmatch(code)
        if record is not None and self._record(record, number):
            return None
        if self._only is not None and not self._wanted(code):
            return None
        if parsing.kept(code) is not None:
            self._findings.kinds[number - 1] = LineKind.OPAQUE
            return None
        result = self._reader.parse(code, number)
        if isinstance(result, (Head, Tail)):
            return result
        if isinstance(result, tuple):
            for one in result:
                self._add(replace(one, line=self._line(number), comment=comment), number)
        elif isinstance(result, Assign):
            self._element(result, number)
        elif result is not None:
            self._refuse(number)
        return None

    def _plain(self, match: re.Match[str], number: int) -> bool:
        shared, word, name, aggregate = match.groups()
        kind, key = word.upper(), name.upper()
        if self._only is not None and key not in self._only:
            return True
        value = fast.literal(aggregate, kind)
        if value is None:
            return False
        name = self._scope.spell(name)
        it = Declare(
            number if self._placed else 0,
            name,
            NEUTRAL_TYPES[kind],
            value,
            (),
            "variable",
            bool(shared),
            kind,
            self._comment,
        )
        self._declare(it, key, value, number)
        return True

    def _record(self, match: re.Match[str], number: int) -> bool:
        """Motion data: many rows have the same values, which the grammar reads once."""
        shared, word, name, aggregate = match.groups()
        kind = word.upper()
        if self._only is not None and name.upper() not in self._only:
            return True
        value = self._records.get((kind, aggregate))
        if value is None:
            result = self._reader.parse(match[0], number)
            if not isinstance(result, tuple):
                return result is None
            value = self._records[kind, aggregate] = result[0].value
        self._declare(
            Declare(
                self._line(number),
                self._scope.spell(name),
                kind,
                value,
                (),
                "variable",
                bool(shared),
                kind,
                self._comment,
            ),
            name.upper(),
            value,
            number,
        )
        return True

    def _line(self, number: int) -> int:
        return number if self._placed else 0

    def _declare(self, it: Declare, key: str, value: Expression, number: int) -> None:
        """`key`: its name in capitals."""
        self._scope.declare(key, it.native)
        self._scope.values[key] = value
        if key in self.declared:
            self._add(it, number)
            return
        self.declared[key] = self._below(it)
        position = it.native in fast.POSITIONS
        self._findings.kinds[number - 1] = LineKind.POINT if position else LineKind.STATEMENT

    def _wanted(self, code: str) -> bool:
        assert self._only is not None
        names = _NAME.findall(code.partition("=")[0])
        upper = [one for one in map(str.upper, names) if one not in _MODIFIERS]
        declared = upper[1:] if len(upper) > 1 else upper  # the first is the type, or an array alone
        return upper[:1] in (["STRUC"], ["ENUM"]) or any(name in self._only for name in declared)

    def _add(self, it: Declare, number: int) -> None:
        key = it.name.upper()
        if key in self.declared:
            span = self._findings.whole_line(number)
            self._findings.warning(
                "P415", f"{it.name} is declared twice; the last one counts", span, "remove one"
            )
        self.declared[key] = self._below(it)
        position = it.type in ("position", "joints", "frame")
        self._findings.kinds[number - 1] = LineKind.POINT if position else LineKind.STATEMENT

    def _below(self, it: Declare) -> Declare:
        """The declaration with the comments above it."""
        if self._above:
            it = replace(it, above=tuple(self._above))
            self._above.clear()
        return it

    def _element(self, it: Assign, number: int) -> None:
        """`NAME[3]={…}` or `NAME[]="…"`; `NAME.X=5` changes a component of a value that stands before."""
        target = it.target
        self._findings.kinds[number - 1] = LineKind.STATEMENT
        if isinstance(target, Member) and type(target.base) is Named:
            self._component(target.base.name.upper(), target.name, it.value, number)
            return
        whole = isinstance(target, Named) or (isinstance(target, Item) and not target.indices)
        base = target if isinstance(target, Named) else getattr(target, "base", None)
        declared = self.declared.get(base.name.upper()) if type(base) is Named else None
        if declared is None:
            if self._only is None:
                self._refuse(number)
            return
        if whole:
            self._set(declared, it.value)
            return
        assert isinstance(target, Item)
        place = tuple(int(one.value) for one in target.indices if type(one) is Number)
        known = sum(type(one) is not Unknown for one in target.indices)
        found = self._elements.setdefault(declared.name.upper(), {})
        fits = (
            0 < len(place) <= max(len(declared.sizes), 1) and min(place) > 0 and prod(place) <= _MOST_PLACES
        )
        if len(place) != known or not fits:
            self._refuse(number)
        elif len(found) < _MOST_ELEMENTS:
            found[place] = it.value

    def _component(self, key: str, name: str, value: Expression, number: int) -> None:
        declared = self.declared.get(key)
        if declared is None or not isinstance(declared.value, RecordLiteral):
            if self._only is None:
                self._refuse(number)
            return
        members = tuple((it, value if it == name else old) for it, old in declared.value.members)
        self._set(declared, RecordLiteral(declared.value.type, members))

    def _set(self, declared: Declare, value: Expression) -> None:
        key = declared.name.upper()
        self.declared[key] = replace(declared, value=value)
        self._scope.values[key] = value

    def _refuse(self, number: int) -> None:
        span = self._findings.whole_line(number)
        help = "a list holds declarations and values of what it has declared"
        self._findings.error("P403", "this does not belong in a data list", span, help)

    def finish(self) -> tuple[Declare, ...]:
        """All declarations; arrays have the values of their elements."""
        for key, elements in self._elements.items():
            if not elements:
                continue
            declared = self.declared[key]
            self._set(declared, _array(declared.native, elements))
        only = self._only
        if only is None:
            return tuple(self.declared.values())
        kinds = self._kinds({one.native.upper() for key, one in self.declared.items() if key in only})
        return tuple(
            one
            for key, one in self.declared.items()
            if key in only or (one.type in ("enumeration", "structure") and key in kinds)
        )

    def _kinds(self, kinds: set[str]) -> set[str]:
        """These types and those of their members."""
        todo = list(kinds)
        while todo:
            layout = self.declared.get(todo.pop())
            members = layout.value.members if layout and isinstance(layout.value, RecordLiteral) else ()
            inner = {one.type.upper() for _, one in members if isinstance(one, RecordLiteral)} - kinds
            kinds |= inner
            todo += inner
        return kinds


def _array(kind: str, elements: dict[tuple[int, ...], Expression]) -> Expression:
    """Nested literals, `Unknown("")` where no value was given."""
    if max(map(len, elements)) > 1:
        rows: dict[tuple[int, ...], dict[tuple[int, ...], Expression]] = {}
        for place, value in elements.items():
            rows.setdefault(place[:1], {})[place[1:]] = value
        return _filled(
            kind, {row: _array(kind, rest) if () not in rest else rest[()] for row, rest in rows.items()}
        )
    return _filled(kind, elements)


def _filled(kind: str, elements: dict[tuple[int, ...], Expression]) -> RecordLiteral:
    last = max(place[0] for place in elements)
    return RecordLiteral(kind, tuple(("", elements.get((n,), _EMPTY)) for n in range(1, last + 1)))


_EMPTY: Final = Unknown("")
