"""Components of quaternions, read and written, for languages that write a rotation as three angles (R = Rz Ry Rx).

A component that is read is computed from half the angles. Components that are written one after the other are kept,
and the angles follow from the last one on, whatever the quaternion's length is (`_angles`). Other components of
positions, tools and frames that only the source's language has are refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce
from typing import Final

from olp.ir import expressions as ex
from olp.ir.program import Assign, Call, Declare, Else, EndIf, If, Move, Program, ReadInput, Statement, Update
from olp.ir.transformer import calls_nothing, expressions_of, mapped, sets_numbers
from olp.languages.vendor import language_of
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.occurrences import with_rows
from olp.transpile.symbols import Symbols

_SHARED: Final = frozenset({"x", "y", "z", "rx", "ry", "rz", "e1", "e2", "e3", "e4", "e5", "e6"})
_AXES: Final = frozenset(f"{letter}{number}" for letter in "aj" for number in range(1, 7))
_POSITIONS: Final = frozenset({"position", "joints"})
_SYSTEMS: Final = frozenset({"tool", "frame"})


def own_components(program: Program, work: TranslationContext) -> Program:
    """Rejects components that other languages lack: quaternions, loads of tools, parts of frames, arm flags.

    Where tools and frames have numbers, no component of them is a variable.
    """
    symbols = work.symbols(program)
    held = _POSITIONS if work.limits.numbered else _POSITIONS | _SYSTEMS
    for routine in program.routines:
        for _, s in work.look(routine).rare:
            if isinstance(s, Declare) or (isinstance(s, Move) and not s.has_signals):
                continue
            for e in expressions_of(s):
                kind = system_or_position(e.base, symbols, routine.name) if isinstance(e, ex.Member) else ""
                if isinstance(e, ex.Member) and kind and not (kind in held and _is_shared(e.name, kind)):
                    other = language_of(work.target)
                    says = f"the component {e.name} of a position, tool or frame, which {other} lacks"
                    work.lose(s, Fate.REFUSED, "component", says)
    return program


def _is_shared(component: str, kind: str) -> bool:
    """Whether other languages have the component, too: places, angles, external axes, axes of joint values."""
    return component in _SHARED or (kind == "joints" and component.lower() in _AXES)


def system_or_position(base: ex.Expression, symbols: Symbols, routine: str) -> str:
    """What a component belongs to: position, joints, tool or frame; "" for records."""
    while isinstance(base, ex.Item):
        base = base.base
    symbol = symbols.find(routine, base.name) if isinstance(base, ex.Named) else None
    return symbol.type if symbol is not None and symbol.type in _POSITIONS | _SYSTEMS else ""


_PLACE: Final = ("x", "y", "z")
_TURN: Final = ("rx", "ry", "rz")


def own_parts(program: Program, work: TranslationContext) -> Program:
    """A pose that is set to its own place with another turn, or to its own turn at another place: each component of the
    other part is set, and what stays is not touched.

    Not for a target whose poses are lists: the elements of those are no angles.
    """
    if work.target_conventions.pose_lists:
        return program
    symbols = work.symbols(program)
    routines = []
    for routine in program.routines:
        rows = [row for s in routine.body for row in _parts(s, symbols, routine.name)]
        routines.append(with_rows(routine, rows) if len(rows) != len(routine.body) else routine)
    return replace(program, routines=tuple(routines))


def _parts(s: Statement, symbols: Symbols, routine: str) -> list[Statement]:
    """The statement, or those that set the components that it changes, if none is computed from another."""
    if type(s) is not Assign or type(s.value) is not ex.Function or s.value.name != "pose-angles":
        return [s]
    if system_or_position(s.target, symbols, routine) != "position" or len(s.value.arguments) != 6:
        return [s]
    own = tuple(ex.Member(s.target, name) for name in (*_PLACE, *_TURN))
    for kept, names, values in (
        (slice(0, 3), _TURN, s.value.arguments[3:]),
        (slice(3, 6), _PLACE, s.value.arguments[:3]),
    ):
        asked = [e for value in values for e in expressions_of(value)]
        if s.value.arguments[kept] == own[kept] and not any(
            e == s.target or type(e) is ex.CallValue for e in asked
        ):
            comments = (s.comment, "", "")
            return [
                Assign(s.line, ex.Member(s.target, name), value, comment)
                for name, value, comment in zip(names, values, comments, strict=True)
            ]
    return [s]


_NUMBERS: Final = ("q1", "q2", "q3", "q4")
_READ: Final = "computed from the angles: the four numbers may have the other sign, which is the same turn"
_WRITTEN: Final = "the angles are computed from the quaternion, within 0.02 deg where ry is near 90 deg"
# cos(ry) below which rx and rz are one turn: single precision knows each of them no better than 1E-7 over this [rad].
_UPRIGHT: Final = ex.Number(0.0003)
_STEMS: Final = ("turn_q1", "turn_q2", "turn_q3", "turn_q4", "turn_across", "turn_along", "turn_cosine")


def quaternions(program: Program, work: TranslationContext) -> Program:
    """Quaternions' numbers of positions, tools and frames as angles; what can be none stays, and is refused later."""
    if not work.conventions.has_records:
        return program
    symbols = work.symbols(program)
    routines, declared = [], []
    for routine in program.routines:
        own = _Turns(work, symbols, routine.name)
        named = any(own.is_number(e) for _, s in work.look(routine).rare for e in expressions_of(s))
        rows = own.rows(routine.body) if named else []
        routines.append(with_rows(routine, rows) if own.changed else routine)
        declared += [Declare(0, name.name, "real", ex.Number(0), shared=True) for name in own.held]
    if all(new is old for new, old in zip(routines, program.routines, strict=True)):
        return program
    return replace(program, routines=tuple(routines), data=(*program.data, *declared))


@dataclass(slots=True)
class _Turns:
    """`held`: a routine's variables for the four numbers, sin(rz) cos(ry), cos(rz) cos(ry) and cos(ry)."""

    work: TranslationContext
    symbols: Symbols
    routine: str
    held: tuple[ex.Named, ...] = ()
    changed: bool = False

    def rows(self, body: Sequence[Statement]) -> list[Statement]:
        rows: list[Statement] = []
        at = 0
        while at < len(body):
            written = self._written(body[at : at + 4])
            if written:
                rows += self._angles(written)
                at += len(written)
            else:
                rows.append(self._read(body[at]))
                at += 1
        return rows

    def is_number(self, e: ex.Expression) -> bool:
        if not isinstance(e, ex.Member) or e.name not in _NUMBERS:
            return False
        return bool(system_or_position(e.base, self.symbols, self.routine))

    # --- written ----------------------------------------------------------------------------------------

    def _written(self, rows: Sequence[Statement]) -> list[Assign]:
        """Four assignments of all numbers of one quaternion, none where these statements are something else."""
        found: list[Assign] = []
        for s in rows:
            if type(s) is not Assign or type(s.target) is not ex.Member or not self.is_number(s.target):
                return []
            found.append(s)
        names = {s.target.name for s in found if type(s.target) is ex.Member}
        if len(names) < 4 or any(_base(s) != _base(found[0]) for s in found):
            return []
        values = [e for s in found for e in expressions_of(s.value)]
        base = expressions_of(_base(found[0]))
        if any(type(e) is ex.CallValue for e in (*values, *base)) or any(e in values for e in base):
            return []  # a value that depends on the turn, or on whatever a routine does to it
        return found

    def _angles(self, written: list[Assign]) -> list[Statement]:
        """The numbers as they are set, and the angles behind the last of them.

        Where ry is 90 deg, rz and rx turn about the same axis: rz is 0 there.
        """
        self.changed = True
        if not self.held:
            self.held = tuple(ex.Named(self.work.helper(stem)) for stem in _STEMS)
        w, x, y, z, across, along, cosine = self.held
        base, line = _base(written[0]), written[-1].line
        rows: list[Statement] = []
        for s in written:
            assert isinstance(s.target, ex.Member)
            self.work.lose(s, Fate.APPROXIMATED, "turn", _WRITTEN)
            rows.append(replace(s, target=self.held[_NUMBERS.index(s.target.name)]))

        def turned(name: str, value: ex.Expression) -> Assign:
            return Assign(line, ex.Member(base, name), value)

        return [
            *rows,
            Assign(line, along, _squares((w, x), (y, z))),
            Assign(line, across, _twice("+", (w, z), (x, y))),
            Assign(line, cosine, ex.Function("sqrt", (_squares((along, across)),))),
            turned("ry", _angle(_twice("-", (w, y), (x, z)), cosine)),
            If(line, ex.Compare(">", cosine, _UPRIGHT)),
            turned("rz", _angle(across, along)),
            turned("rx", _angle(_twice("+", (w, x), (y, z)), _squares((w, z), (x, y)))),
            Else(line),
            turned("rz", ex.Number(0)),
            turned("rx", _angle(_twice("-", (w, x), (y, z)), _squares((w, y), (x, z)))),
            EndIf(line),
        ]

    # --- read -------------------------------------------------------------------------------------------

    def _read(self, s: Statement) -> Statement:
        if isinstance(s, Declare) or calls_nothing(s) or sets_numbers(s):
            return s
        inner = expressions_of(s)
        if not any(self.is_number(e) for e in inner) or any(self.is_number(e) for e in _handed(s, inner)):
            return s
        if isinstance(s, (Assign, Update, ReadInput)) and self.is_number(s.target):
            return s  # one of the numbers alone
        self.changed = True
        self.work.lose(s, Fate.APPROXIMATED, "turn", _READ)
        return mapped(s, lambda e: _of_angles(e) if type(e) is ex.Member and self.is_number(e) else e)


def _handed(s: Statement, inner: list[ex.Expression]) -> list[ex.Expression]:
    """Variables that are handed to routines, which may change them."""
    calls = [e.arguments for e in inner if isinstance(e, ex.CallValue)]
    given = [one for arguments in calls for one in arguments]
    if isinstance(s, Call):
        given += [*s.arguments, *([] if s.result is None else [s.result])]
    plain = [one.value if isinstance(one, ex.NamedArgument) else one for one in given]
    return [one for one in plain if one is not None]


def _base(s: Assign) -> ex.Expression:
    assert isinstance(s.target, ex.Member)
    return s.target.base


def _of_angles(e: ex.Member) -> ex.Expression:
    """One number of the quaternion of Rz Ry Rx."""
    halves = [ex.Binary("/", ex.Member(e.base, name), ex.Number(2)) for name in ("rx", "ry", "rz")]
    at = _NUMBERS.index(e.name)
    own = [ex.Function("sin" if at == k else "cos", (half,)) for k, half in enumerate(halves, 1)]
    other = [ex.Function("cos" if at == k else "sin", (half,)) for k, half in enumerate(halves, 1)]
    return ex.Binary("-" if at in (1, 3) else "+", _product(own), _product(other))


def _product(parts: Sequence[ex.Expression]) -> ex.Expression:
    return reduce(partial(ex.Binary, "*"), parts)


def _squares(plus: Sequence[ex.Expression], minus: Sequence[ex.Expression] = ()) -> ex.Expression:
    """The sum of the squares of some, less those of others."""
    first = reduce(partial(ex.Binary, "+"), [_product((one, one)) for one in plus])
    return reduce(partial(ex.Binary, "-"), [_product((one, one)) for one in minus], first)


def _twice(operator: str, left: Sequence[ex.Expression], right: Sequence[ex.Expression]) -> ex.Expression:
    """Twice the sum, or the difference, of two products."""
    return ex.Binary("*", ex.Number(2), ex.Binary(operator, _product(left), _product(right)))


def _angle(sine: ex.Expression, cosine: ex.Expression) -> ex.Function:
    """[deg]"""
    return ex.Function("atan2", (sine, cosine))
