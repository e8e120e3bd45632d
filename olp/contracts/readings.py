"""Declared readings: programs with, under each line, what the line means, written by hand in the vendor's samples.

`samples/NAME/readings/*.reading` holds the files of one folder, and of folders in it, one after the other:

    === part.src
    S   WAIT SEC 0.35
            Dwell duration=0.35*SI
    E   GOTO
            !error P411 3:3-7 a program that cannot be read | help: …

A line that begins with `=== ` opens a file. One with a letter and three blanks is a line of its text: the letter
says what olp takes it for (Blank, Record, Point, Statement, Comment, Free text, Opaque, Error). Deeper lines are the
meaning of the line above. Quantities are `written*unit` (SI: metres, seconds, m/s); poses are x y z [mm], rx ry rz
[deg] with R = Rz Ry Rx; what has its default is left out. Files that no reader takes by themselves have ? for
letters, and so have packed ones, whose program is another text: it follows as a part (`cell.urp, as it is read`).

What else is declared of the same texts: `derived_readings.py`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from difflib import SequenceMatcher
from enum import Enum
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from olp.contracts.oracle import DEG, MM
from olp.contracts.promises import Difference
from olp.core import resources
from olp.core.diagnostic import Diagnostic
from olp.core.files import temporary_cell
from olp.core.source import load
from olp.ir import expressions as ex
from olp.ir.points import Point, PointKind
from olp.ir.program import Acceleration, Blend, Program, Routine, Speed
from olp.languages.vendor import Vendor

SUFFIX: Final = ".reading"
_KINDS: Final = "BRPSCFOE"  # a letter for each value of LineKind
_FILE: Final = "=== "
_AS_READ: Final = ", as it is read"  # behind the name of a file whose program is another text
_UNITS: Final = {MM: "mm", DEG: "deg", 0.01: "%", 1.0: "SI"}
INDENT: Final = " " * 8
LINE: Final = re.compile(rf"[{_KINDS}?](?:   (.*))?")
_KEYWORD: Final = re.compile(r'"([^\W\d]\w*)"i?')
_TERMINAL: Final = re.compile(r"^_?[A-Z_]+(?:\.\d+)?: /(?:\(\?:)?([A-Z_|]+)\)?(?:\(\?!|\\b)", re.MULTILINE)
_CONTEXT: Final = 200  # characters of a declared line that are shown


# --- what a reader makes of a text, as readings spell it ------------------------------------------------------


def reading(program: Program) -> list[str]:
    """The lines of the text, each with its letter and with what it means below it."""
    source = program.source
    meanings: dict[int, list[str]] = {}
    for at, text in _meanings(program):
        known = 0 < at <= len(source.lines)
        meanings.setdefault(at if known else 0, []).append(
            f"{INDENT}{text}{'' if known or not at else f' @{at}'}"
        )
    rows = list(meanings.get(0, ()))
    for number, line in enumerate(source.lines, 1):
        kinds = program.line_kinds[number - 1 : number]
        rows.append(f"{_KINDS[kinds[0]] if kinds else '?'}   {line}".rstrip())
        rows += meanings.get(number, ())
    return rows


def _meanings(program: Program) -> Iterator[tuple[int, str]]:
    if program.main:
        yield 0, f"main={program.main}"
    for declared in program.data:
        yield declared.line, spelled(declared)
    for routine in program.routines:
        yield routine.line, f"Routine {fields_of(routine, ('line', 'body', 'points', 'data'))}"
        yield from ((routine.line, f"beside: {spelled(one)}") for one in routine.data)
        yield from _of_body(routine)
    yield from ((d.line, finding_text(d, program.path)) for d in program.diagnostics)


def _of_body(routine: Routine) -> Iterator[tuple[int, str]]:
    yield from ((one.line, spelled(one)) for one in routine.body)
    for store, taught, point in routine.points:
        yield point.line, f"{'taught ' if taught else ''}{store} {point.number}: {_point(point)}".rstrip()


def _point(point: Point) -> str:
    values = point.values
    state = fields_of(point.state, ("kind",))
    if point.state.kind is PointKind.POSE:
        return f"{_pose(values)} {state}"
    scale = 1.0 if point.state.kind is PointKind.PULSE else DEG
    return f"{point.state.kind}({_numbers(v / scale for v in values)}) {state}"


def finding_text(found: Diagnostic, path: str) -> str:
    where = f"{found.column}-{found.end_column}"
    if found.file not in ("", path):
        where = f"{Path(found.file).name}:{found.line}:{where}"
    text = f"!{found.severity} {found.code} {where} {found.message}"
    return f"{text} | {found.help}" if found.help else text


def spelled(node: Any) -> str:
    """A statement, an expression or any other value of a program in one line of plain words."""
    return _spelling(type(node))(node)


@lru_cache(maxsize=1024)
def _spelling(kind: type) -> Callable[[Any], str]:
    return next((spell for kinds, spell in _SPELLINGS if issubclass(kind, kinds)), _other)


def _other(node: Any) -> str:
    text = f"{type(node).__name__} {fields_of(node)}".rstrip()
    return text if hasattr(node, "line") else f"<{text}>"


@lru_cache(maxsize=1024)
def _defaults(kind: type[Any]) -> Mapping[str, Any]:
    """The fields of a kind of node, each with its default; without one it has a value that no node has."""
    if is_dataclass(kind):
        return {one.name: one.default for one in fields(kind)}
    return {name: kind._field_defaults.get(name, fields_of) for name in kind._fields}


def fields_of(node: Any, but: Iterable[str] = ("line",)) -> str:
    """`name=value` of all fields that have not their default."""
    defaults = _defaults(type(node))
    given = ((name, getattr(node, name)) for name in defaults if name not in but)
    return " ".join(f"{name}={spelled(v)}" for name, v in given if not _is_default(v, defaults[name]))


def _is_default(value: Any, default: Any) -> bool:
    empty = isinstance(value, (Mapping, tuple)) and not value
    return empty or (type(value) is type(default) and value == default)


def _number(value: float) -> str:
    return repr(value) if isinstance(value, int) else repr(float(f"{value:.9g}"))


def _numbers(values: Iterable[float]) -> str:
    return " ".join("-" if math.isnan(v) else f"{round(v, 6) + 0.0:.12g}" for v in values)


def _pose(values: tuple[float, ...]) -> str:
    more = f" +{_numbers(v / DEG for v in values[6:])}" if len(values) > 6 else ""
    return f"pose({_numbers(v / MM for v in values[:3])}, {_numbers(v / DEG for v in values[3:6])}{more})"


def _position(node: ex.PositionLiteral) -> str:
    made = _pose(node.values) if node.kind == "pose" else f"joint({_numbers(v / DEG for v in node.values)})"
    more = fields_of(node, ("kind", "values"))
    return f"{made[:-1]}; {more})" if more else made


def _logic(node: ex.Logic) -> str:
    return f"({spelled(node.first)}{''.join(f' {word} {spelled(one)}' for word, one in node.rest)})"


def _called(name: str, arguments: Iterable[Any]) -> str:
    return f"{name}({', '.join(map(spelled, arguments))})"


def _with_unit(unit: str, value: ex.Quantity | None, native: str = "") -> str:
    words = [
        str(unit),
        *([spelled(value)] if value is not None else ()),
        *([f"as {native}"] if native else ()),
    ]
    return f"<{' '.join(words)}>"


def _tuple(node: Any) -> str:
    if hasattr(node, "_fields"):
        return f"<{type(node).__name__} {fields_of(node, ())}>"
    return f"[{', '.join(map(spelled, node))}]"


_SPELLINGS: Final[tuple[tuple[Any, Callable[[Any], str]], ...]] = (
    (type(None), lambda n: "none"),
    (Enum, lambda n: str(n.value)),
    (bool, lambda n: "yes" if n else "no"),
    ((int, float), _number),
    (str, lambda n: n if re.fullmatch(r"[\w.$#-]+", n) else repr(n)),
    (ex.Number, lambda n: _number(n.value)),
    (ex.Text, lambda n: repr(n.value)),
    (ex.SignalState, lambda n: "on" if n.on else "off"),
    (ex.Named, lambda n: n.name),
    (ex.Quantity, lambda n: f"{spelled(n.written)}*{_UNITS.get(n.scale) or _number(n.scale)}"),
    ((Speed, Acceleration), lambda n: _with_unit(n.unit, *n[1:])),
    (Blend, lambda n: _with_unit(n.kind, *n[1:])),
    (ex.Unary, lambda n: f"({n.operator} {spelled(n.operand)})"),
    ((ex.Binary, ex.Compare), lambda n: f"({spelled(n.left)} {n.operator} {spelled(n.right)})"),
    (ex.Logic, _logic),
    (ex.Item, lambda n: f"{spelled(n.base)}{_tuple(n.indices)}"),
    (ex.Member, lambda n: f"{spelled(n.base)}.{n.name}"),
    (ex.Signal, lambda n: f"{n.bus}[{spelled(n.index)}]{n.part}"),
    (ex.FrameRef, lambda n: f"{n.kind}#{spelled(n.number)}" if n.number is not None else f"{n.kind}#"),
    (ex.Function, lambda n: _called(n.name, n.arguments)),
    (ex.CallValue, lambda n: _called(f"call {n.routine}", n.arguments)),
    (ex.PositionLiteral, _position),
    (Mapping, lambda n: f"{{{', '.join(f'{spelled(k)}: {spelled(v)}' for k, v in n.items())}}}"),
    (tuple, _tuple),
)


# --- files of declared readings -------------------------------------------------------------------------------


def files_of(rows: Iterable[str]) -> dict[str, list[str]]:
    """The rows of each file of a declared reading, by its name."""
    found: dict[str, list[str]] = {}
    name = ""
    for row in rows:
        if row.startswith(_FILE):
            name = row.removeprefix(_FILE).strip()
            found[name] = []
        elif name:
            found[name].append(row)
    return found


def text_of(rows: Iterable[str]) -> list[str]:
    """The lines of the text in the rows of a file."""
    return [match[1] or "" for row in rows if (match := LINE.fullmatch(row))]


@contextmanager
def written_out(vendor: Vendor, files: Mapping[str, list[str]]) -> Generator[Path]:
    """A folder with the texts of these files; nothing else is in it or beside it, where languages look, too."""
    with temporary_cell() as folder:
        for name, rows in files.items():
            if name.endswith(_AS_READ):
                continue
            text = vendor.newline.join([*text_of(rows), ""]) if rows else ""
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_bytes(text.encode("utf-8"))
        yield folder


def programs_of(vendor: Vendor, files: Mapping[str, list[str]]) -> Iterator[tuple[str, Program]]:
    """What the vendor's reader makes of these texts, which stand in one folder until the last is read."""
    with written_out(vendor, files) as folder:
        for name in files:
            if Path(name).suffix.lower() in vendor.suffixes:
                yield name, vendor.read(load(folder / name))


def found_readings(vendor: Vendor, files: Mapping[str, list[str]]) -> dict[str, list[str]]:
    """The rows of each file as the vendor reads it; files that no reader takes by themselves as they are."""
    found = dict(files)
    for name, program in programs_of(vendor, files):
        own = [row.rstrip() for row in program.source.lines] == text_of(files[name])
        found[name if own else f"{name}{_AS_READ}"] = reading(program)
    return found


def load_declared(path: Path) -> dict[str, list[str]]:
    """The rows of each part of a file of declarations."""
    return files_of(path.read_text(encoding="utf-8").splitlines())


def save(path: Path, parts: Mapping[str, list[str]]) -> None:
    """Writes a file of declarations."""
    rows = [row for name, part in parts.items() for row in (f"{_FILE}{name}", *part)]
    path.write_text("\n".join([*rows, ""]), encoding="utf-8", newline="\n")


def readings_of(folder: Path) -> list[Path]:
    """The declared readings among a vendor's samples."""
    return sorted((folder / "readings").glob(f"*{SUFFIX}"))


def unlike(vendor: Vendor, path: Path) -> Iterator[Difference]:
    """Where a declared reading and what is read differ: the line of the text, and both meanings."""
    declared = load_declared(path)
    found = found_readings(vendor, declared)
    for name, wanted in declared.items():
        for at, a, b in differences(wanted, found[name]):
            line = next((row for row in reversed(wanted[:at]) if LINE.fullmatch(row)), "")
            yield f"{path.name}, {name}: {line[4:].strip()}", f"declared: {a}; read: {b}"


def differences(wanted: list[str], found: list[str]) -> Iterator[tuple[int, str, str]]:
    """Where rows differ: the row at which one looks for the place, and both texts."""
    if wanted == found:
        return
    for word, a, b, c, d in SequenceMatcher(None, wanted, found, autojunk=False).get_opcodes():
        if word != "equal":
            one, other = (" / ".join(map(str.strip, part))[:_CONTEXT] for part in (wanted[a:b], found[c:d]))
            yield a + (word != "insert"), one, other


# --- the words of a grammar ------------------------------------------------------------------------------------


def unspoken(vendor: Vendor, readings: Iterable[str]) -> list[str]:
    """The keywords of the vendor's grammar that stand in none of the declared readings, sorted."""
    if vendor.name not in resources.names("grammars", ".lark"):
        return []
    grammar = resources.read_text("grammars", f"{vendor.name}.lark")
    grammar = re.sub(r"^\s*//.*$", "", grammar, flags=re.MULTILINE)
    words = set(_KEYWORD.findall(grammar))
    words |= {word for found in _TERMINAL.findall(grammar) for word in found.split("|") if word}
    rows = (
        row for text in readings for rows in files_of(text.splitlines()).values() for row in text_of(rows)
    )
    said = {word.casefold() for row in rows for word in re.findall(r"\w+", row)}
    return sorted(word for word in words if word.casefold() not in said)
