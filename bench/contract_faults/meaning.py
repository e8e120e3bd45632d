"""Faults of meaning: what a careless reader or writer does to every program, as a change of the program itself."""

from __future__ import annotations

import functools
import importlib
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any, Final

from olp.ir.expressions import (
    Binary,
    Compare,
    Logic,
    Named,
    Number,
    PositionLiteral,
    Quantity,
    Signal,
    SignalState,
    Text,
)
from olp.ir.points import PointBlock, PointKind, PointState, PointTable
from olp.ir.program import (
    Assign,
    Blend,
    BlendKind,
    Call,
    Comment,
    Declare,
    Dwell,
    Else,
    ElseIf,
    EndIf,
    For,
    If,
    Jump,
    Move,
    Path,
    Program,
    SetFrame,
    SetOutput,
    SetTool,
    Speed,
    SpeedUnit,
    Wait,
    While,
)

Change = Callable[[Any], Any]
MM: Final = 0.001


def rewritten(node: Any, change: Change) -> Any:
    """A value with every part of it changed, innermost first; a part changed to None is dropped from its row."""
    if is_dataclass(node) and not isinstance(node, type):
        if type(node).__name__ in ("Source", "Diagnostic"):
            return node
        parts = {f.name: (getattr(node, f.name)) for f in fields(node)}
        made = {name: rewritten(value, change) for name, value in parts.items()}
        other = {name: value for name, value in made.items() if value is not parts[name]}
        return change(replace(node, **other) if other else node)
    if isinstance(node, tuple):
        rows = [rewritten(one, change) for one in node]
        if hasattr(node, "_fields"):
            same = all(a is b for a, b in zip(rows, node, strict=True))
            return change(node if same else type(node)(*rows))
        kept = [new for new, old in zip(rows, node, strict=True) if new is not None or old is None]
        same = len(kept) == len(node) and all(a is b for a, b in zip(kept, node, strict=True))
        return node if same else tuple(kept)
    if isinstance(node, Mapping):
        made = {key: rewritten(value, change) for key, value in node.items()}
        return node if all(made[key] is node[key] for key in node) else made
    return node


def _poses(change: Callable[[tuple[float, ...]], tuple[float, ...]]) -> Change:
    """A change of poses, whether written out or in a table of points."""

    def changed(node: Any) -> Any:
        if isinstance(node, PositionLiteral) and node.kind == "pose":
            return replace(node, values=(*change(node.values[:6]), *node.values[6:]))
        if isinstance(node, PointTable) and node.blocks:
            return replace(node, blocks={k: block(b, node.states) for k, b in node.blocks.items()})
        return node

    def block(it: PointBlock, states: Sequence[PointState]) -> PointBlock:
        values = it.values.copy()
        for row in range(len(values)):
            if states[int(it.state[row])].kind is PointKind.POSE:
                values[row, :6] = change(tuple(values[row, :6]))
        return replace(it, values=values)

    return changed


def _joints(node: Any) -> Any:
    if isinstance(node, PositionLiteral) and node.kind == "joint":
        return replace(node, values=tuple(-v for v in node.values))
    if isinstance(node, PointTable) and node.blocks:
        blocks = {}
        for key, block in node.blocks.items():
            values = block.values.copy()
            for row in range(len(values)):
                if node.states[int(block.state[row])].kind is not PointKind.POSE:
                    values[row] = -values[row]
            blocks[key] = replace(block, values=values)
        return replace(node, blocks=blocks)
    return node


def _of(kind: Any, change: Callable[[Any], Any]) -> Change:
    return lambda node: change(node) if isinstance(node, kind) else node


def _moves(**more: Any) -> Change:
    return _of(Move, lambda m: replace(m, **more))


def _scaled(factor: float, *units: SpeedUnit) -> Change:
    return _of(Speed, lambda s: s._replace(value=_times(s.value, factor)) if s.unit in units else s)


def _times(quantity: Quantity, factor: float) -> Quantity:
    return quantity._replace(scale=quantity.scale * factor)


def _bodies(change: Callable[[list[Any]], list[Any]]) -> Change:
    """A change of the statements of a routine as a row."""
    from olp.ir.program import Routine

    return _of(Routine, lambda r: replace(r, body=tuple(change(list(r.body)))))


def _later(body: list[Any]) -> list[Any]:
    """Every output after the statement that follows it."""
    found, at = [], 0
    while at < len(body):
        if isinstance(body[at], SetOutput) and at + 1 < len(body):
            found += [body[at + 1], body[at]]
            at += 2
        else:
            found.append(body[at])
            at += 1
    return found


def _without_else(body: list[Any]) -> list[Any]:
    """What is between ELSE and the end of its IF is gone."""
    found: list[Any] = []
    depth, dropping = 0, -1
    for one in body:
        if isinstance(one, If):
            depth += 1
        if isinstance(one, EndIf):
            if dropping == depth:
                dropping = -1
            depth -= 1
        if dropping < 0 and isinstance(one, Else):
            dropping = depth
        elif dropping < 0:
            found.append(one)
    return found


def _first_of(kind: type, name: str) -> Change:
    """Everybody gets the tool or frame that came first."""
    seen: list[Any] = []

    def changed(node: Any) -> Any:
        if isinstance(node, Move) and getattr(node, name) is not None:
            seen.append(getattr(node, name))
            return replace(node, **{name: seen[0]})
        if isinstance(node, kind) and getattr(node, name) is not None:
            seen.append(getattr(node, name))
            return replace(node, **{name: seen[0]})
        return node

    return changed


_OPPOSITE: Final = {"=": "<>", "<>": "=", "<": ">=", ">=": "<", ">": "<=", "<=": ">"}


def _negated(node: Any) -> Any:
    if isinstance(node, If | ElseIf | While | Jump) and isinstance(node.condition, Compare):
        return replace(node, condition=replace(node.condition, operator=_OPPOSITE[node.condition.operator]))
    return node


def _one_less(node: Any) -> Any:
    if isinstance(node, For) and isinstance(node.stop, Number):
        return replace(node, stop=Number(node.stop.value - 1))
    if isinstance(node, While | Jump) and isinstance(node.condition, Compare):
        right = node.condition.right
        if isinstance(right, Number):
            return replace(node, condition=replace(node.condition, right=Number(right.value + 1)))
    return node


CHANGES: Final[Mapping[str, Callable[[], Change]]] = {
    "angles of poses in the other order": lambda: _poses(lambda v: (*v[:3], v[5], v[4], v[3])),
    "an angle of poses with the other sign": lambda: _poses(lambda v: (*v[:4], -v[4], v[5])),
    "metres as millimetres": lambda: _poses(lambda v: (*(x * 1000 for x in v[:3]), *v[3:])),
    "y and z change places": lambda: _poses(lambda v: (v[0], v[2], v[1], *v[3:])),
    "radians as degrees": lambda: _poses(lambda v: (*v[:3], *(math.degrees(a) for a in v[3:]))),
    "places rounded to whole millimetres": lambda: _poses(lambda v: (*(round(x, 3) for x in v[:3]), *v[3:])),
    "axes with the other sign": lambda: _joints,
    "every move a joint move": lambda: _of(
        Move, lambda m: replace(m, path=Path.JOINT) if m.via is None else m
    ),
    "every joint move a straight one": lambda: _of(
        Move, lambda m: replace(m, path=Path.LINEAR) if m.path is Path.JOINT else m
    ),
    "arcs as straight lines": lambda: _of(
        Move, lambda m: replace(m, path=Path.LINEAR, via=None) if m.path is Path.CIRCULAR else m
    ),
    "arcs through their end": lambda: _of(
        Move, lambda m: replace(m, via=m.targets[0]) if m.via is not None else m
    ),
    "blends dropped": lambda: _of(Blend, lambda b: Blend(BlendKind.RADIUS, Quantity(Number(0), MM))),
    "blends of half the size": lambda: _of(
        Blend, lambda b: b._replace(value=_times(b.value, 0.5)) if b.value is not None else b
    ),
    "speeds of straight moves in other units": lambda: _scaled(0.001, SpeedUnit.TRAVEL),
    "speeds of straight moves too fast by 4 %": lambda: _scaled(1.04, SpeedUnit.TRAVEL),
    "speeds of joint moves halved": lambda: _scaled(
        0.5, SpeedUnit.FRACTION, SpeedUnit.AXIS, SpeedUnit.TRAVEL
    ),
    "outputs of the other state": lambda: _of(SetOutput, _flipped),
    "outputs of the next number": lambda: _of(Signal, _next_signal),
    "outputs after the next statement": lambda: _bodies(_later),
    "outputs dropped": lambda: _of(SetOutput, lambda s: None),
    "waits in milliseconds": lambda: _of(Dwell, lambda d: replace(d, duration=_times(d.duration, 0.001))),
    "waits dropped": lambda: _of(Dwell, lambda d: None),
    "waits for inputs dropped": lambda: _of(Wait, lambda w: None),
    "waits for the other state": lambda: _of(Wait, _other_state),
    "comments dropped": lambda: _of(Comment, lambda c: None),
    "the first tool for all": lambda: _first_of(SetTool, "tool"),
    "the first frame for all": lambda: _first_of(SetFrame, "frame"),
    "tools of points dropped": lambda: _of(PointState, lambda s: replace(s, tool=1) if s.tool else s),
    "frames of points dropped": lambda: _of(PointState, lambda s: replace(s, user=1) if s.user else s),
    "else branches dropped": lambda: _bodies(_without_else),
    "conditions negated": lambda: _negated,
    "loops that end one pass early": lambda: _one_less,
    "calls dropped": lambda: _of(Call, lambda c: None),
    "differences as sums": lambda: _of(
        Binary, lambda b: replace(b, operator={"-": "+"}.get(b.operator, b.operator))
    ),
    "products as sums": lambda: _of(
        Binary, lambda b: replace(b, operator={"*": "+"}.get(b.operator, b.operator))
    ),
    "and as or": lambda: _of(
        Logic, lambda e: replace(e, rest=tuple(("or" if op == "and" else "and", x) for op, x in e.rest))
    ),
}


def _next_signal(signal: Signal) -> Signal:
    """The signal with the next number, which languages with named signals have in the name: do3 becomes do4."""
    match signal.index:
        case Number(number):
            return replace(signal, index=Number(number + 1))
        case Text(name) if found := re.search(r"\d+$", name):
            return replace(signal, index=Text(f"{name[: found.start()]}{int(found[0]) + 1}"))
    return signal


def _flipped(one: SetOutput) -> SetOutput:
    value = one.value
    if isinstance(value, SignalState):
        return replace(one, value=SignalState(not value.on))
    return replace(one, value=Number(1 - value.value)) if isinstance(value, Number) else one


def _other_state(one: Wait) -> Wait:
    condition = one.condition
    if isinstance(condition, Compare) and isinstance(condition.right, SignalState):
        return replace(one, condition=replace(condition, right=SignalState(not condition.right.on)))
    if isinstance(condition, Signal):
        return replace(one, condition=Compare("=", condition, SignalState(False)))
    return one


# What a reader alone can do wrong.
READER_CHANGES: Final[Mapping[str, Callable[[Program], Program]]] = {
    "bytes without blanks at the end": lambda p: replace(
        p, source=replace(p.source, raw=p.source.raw.rstrip())
    ),
    "line ends made one": lambda p: replace(
        p, source=replace(p.source, raw=p.source.raw.replace(b"\r\n", b"\n").replace(b"\r", b"\n"))
    ),
    "the last line is not accounted for": lambda p: replace(p, line_kinds=p.line_kinds[:-1]),
    "nothing is said of mistakes": lambda p: replace(
        p, diagnostics=(), line_kinds=p.line_kinds.replace(b"\x07", b"\x03").replace(b"\x06", b"\x03")
    ),
    "every statement is on the line before": lambda p: rewritten(
        p, lambda n: replace(n, line=n.line - 1) if hasattr(n, "line") and hasattr(n, "comment") else n
    ),
    "mistakes behind the end of the text": lambda p: replace(
        p, diagnostics=tuple(replace(d, line=d.line + 5000) for d in p.diagnostics)
    ),
}
# What a writer alone can do wrong, to the text.
TEXT_CHANGES: Final[Mapping[str, Callable[[str], str]]] = {
    "a comma for the decimal point": lambda t: re.sub(r"(\d)\.(\d)", r"\1,\2", t),
    "minus signs dropped": lambda t: re.sub(r"-(\d)", r"\1", t),
    "one decimal only": lambda t: re.sub(r"(\d\.\d)\d+", r"\1", t),
    "the last line dropped": lambda t: t.rstrip("\n").rpartition("\n")[0] + "\n",
    "a date of its own": lambda t: t + f"\n{id(object())}",
    "lines that end with CR": lambda t: t.replace("\n", "\r"),
}


def reader_faults(vendor: Any) -> list[tuple[str, Callable[[], Callable[[], bool]]]]:
    """(name, plant) for a vendor's `read`; `vendor`: how to get it, once the process is the fault's own."""
    found = [(name, _plant_read(vendor, _program_change(make))) for name, make in CHANGES.items()]
    found += [
        (name, _plant_read(vendor, lambda change=change: change)) for name, change in READER_CHANGES.items()
    ]
    found += [("raises for a byte that is no text", _plant_raising(vendor))]
    return found


def writer_faults(vendor: Any) -> list[tuple[str, Callable[[], Callable[[], bool]]]]:
    """(name, plant) for a vendor's writer, some of them in its reader as well, so that the two agree."""
    found = [(name, _plant_write(vendor, make)) for name, make in CHANGES.items()]
    found += [(name, _plant_text(vendor, change)) for name, change in TEXT_CHANGES.items()]
    shared = {
        "metres as millimetres": lambda: _poses(lambda v: (*(x / 1000 for x in v[:3]), *v[3:])),
        "angles of poses in the other order": CHANGES["angles of poses in the other order"],
        "speeds of straight moves too fast by 4 %": lambda: _scaled(1 / 1.04, SpeedUnit.TRAVEL),
        "waits in milliseconds": lambda: _of(Dwell, lambda d: replace(d, duration=_times(d.duration, 1000))),
        "outputs of the other state": CHANGES["outputs of the other state"],
        "an angle of poses with the other sign": CHANGES["an angle of poses with the other sign"],
    }
    for name, back in shared.items():
        both = _both(_plant_write(vendor, CHANGES[name]), _plant_read(vendor, _program_change(back)))
        found.append((f"{name}, in the reader too", both))
    found.append(("what it cannot say is left out in silence", _plant_silence(vendor)))
    one = _both(_plant_write(vendor, lambda: _of(Program, _without_own)), _plant_shared_names())
    found.append(("two routines' own variables of one name are one", one))
    return found


def _without_own(program: Program) -> Program:
    """Every variable is the program's; where a routine had one of its own, it is only set there."""
    known = {declare.name.casefold() for declare in program.data}
    data = list(program.data)
    for declare in program.statements():
        if isinstance(declare, Declare) and declare.name.casefold() not in known:
            known.add(declare.name.casefold())
            data.append(replace(declare, shared=True))

    def body(rows: list[Any]) -> list[Any]:
        valued = (s for s in rows if not isinstance(s, Declare) or s.value is not None)
        return [
            Assign(s.line, Named(s.name), s.value) if isinstance(s, Declare) and s.value is not None else s
            for s in valued
        ]

    routines = tuple(replace(r, body=tuple(body(list(r.body)))) for r in program.routines)
    return replace(program, routines=routines, data=tuple(data))


def _plant_shared_names() -> Callable[[], Callable[[], bool]]:
    """The same where variables have numbers, which the translation gives them by their names."""

    def plant() -> Callable[[], bool]:
        from olp.transpile.shared_variables import _Shared

        whole, changed = _Shared.__post_init__, []

        def post_init(self: Any) -> None:
            whole(self)
            own = {key: key[1] for key in self.names}
            changed.append(own != self.names)
            self.names = own

        _Shared.__post_init__ = post_init
        return lambda: any(changed)

    return plant


def _program_change(make: Callable[[], Change]) -> Callable[[], Callable[[Program], Program]]:
    return lambda: lambda program: rewritten(program, make())


def _both(*plants: Callable[[], Callable[[], bool]]) -> Callable[[], Callable[[], bool]]:
    def plant() -> Callable[[], bool]:
        changed = [one() for one in plants]
        return lambda: any(one() for one in changed)

    return plant


def _plant_read(
    vendor: Any, make: Callable[[], Callable[[Program], Program]]
) -> Callable[[], Callable[[], bool]]:
    def plant() -> Callable[[], bool]:
        kind, change, changed = type(vendor()), make(), []
        whole = kind.read

        def read(self: Any, source: Any) -> Program:
            program = whole(self, source)
            other = change(program)
            changed.append(other != program)
            return other

        kind.read = read
        return lambda: any(changed)

    return plant


def _plant_raising(vendor: Any) -> Callable[[], Callable[[], bool]]:
    def plant() -> Callable[[], bool]:
        kind = type(vendor())
        whole = kind.read

        def read(self: Any, source: Any) -> Program:
            if b"\0" in source.raw:
                raise ValueError("a zero")
            return whole(self, source)  # type: ignore[no-any-return]

        kind.read = read
        return lambda: True

    return plant


def _writer_of(vendor: Any) -> Any:
    return importlib.import_module(f"{type(vendor()).__module__}.writer")


def _plant_write(vendor: Any, make: Callable[[], Change]) -> Callable[[], Callable[[], bool]]:
    def plant() -> Callable[[], bool]:
        module, changed = _writer_of(vendor), []
        whole = module.write

        @functools.wraps(whole)
        def write(program: Program, date: str, *rest: Any, **more: Any) -> Any:
            other = rewritten(program, make())
            changed.append(other != program)
            return whole(other, date, *rest, **more)

        module.write = write
        return lambda: any(changed)

    return plant


def _plant_text(vendor: Any, change: Callable[[str], str]) -> Callable[[], Callable[[], bool]]:
    def plant() -> Callable[[], bool]:
        from olp.transpile import convert

        whole, changed, name = convert.rendered, [], vendor().name

        def rendered(values: Any, language: str, *rest: Any) -> str:
            text = whole(values, language, *rest)
            other = change(text) if language == name else text
            changed.append(other != text)
            return other

        convert.rendered = rendered
        return lambda: any(changed)

    return plant


def _plant_silence(vendor: Any) -> Callable[[], Callable[[], bool]]:
    def plant() -> Callable[[], bool]:
        module, changed = _writer_of(vendor), []
        whole = module.write

        @functools.wraps(whole)
        def write(program: Program, date: str, *rest: Any, **more: Any) -> Any:
            values, problems = whole(program, date, *rest, **more)
            changed.append(bool(problems))
            return values, []

        module.write = write
        return lambda: any(changed)

    return plant
