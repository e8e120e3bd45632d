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

`*.damaged` beside them declares what is read of the same texts with a word left out, a number changed, a letter or
all lost in some lines: those lines, others that are read otherwise then, and "as before" below what means the same.
`*.loaded` declares what controllers refuse of these programs (`load.py`), and of sound ones once they are damaged.
`*.called` declares the statements that other languages get of them otherwise than they are read (`Vendor.as_called`),
`*.edited` what editors are told: names (`tokens.py`; = defines, . is local, ~ shows it by no pattern), the lines laid
out, and where positions, speeds and accelerations stand (`written.py`). `*.merged` declares merges of damaged texts.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from difflib import SequenceMatcher
from enum import Enum
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

from olp.checks.merge.merge import merge_bytes
from olp.contracts.oracle import DEG, MM
from olp.contracts.promises import Difference
from olp.core import resources
from olp.core.diagnostic import Diagnostic, OlpError
from olp.core.files import temporary_cell
from olp.core.source import load
from olp.ir.expressions import (
    Binary,
    CallValue,
    Compare,
    FrameRef,
    Function,
    Item,
    Logic,
    Member,
    Named,
    Number,
    PositionLiteral,
    Quantity,
    Signal,
    SignalState,
    Text,
    Unary,
)
from olp.ir.points import Point, PointKind
from olp.ir.program import Program, Routine
from olp.ir.statements import Acceleration, Blend, Speed
from olp.languages.literals import Token, language, speeds
from olp.languages.loading import Loading, cell_of
from olp.languages.tokens import Word, Words
from olp.languages.vendor import Vendor, part_of
from olp.transpile.occurrences import with_routines, with_rows

SUFFIX: Final = ".reading"
_KINDS: Final = "BRPSCFOE"  # a letter for each value of LineKind
_FILE: Final = "=== "
_AS_READ: Final = ", as it is read"  # behind the name of a file whose program is another text
_UNITS: Final = {MM: "mm", DEG: "deg", 0.01: "%", 1.0: "SI"}
_INDENT: Final = " " * 8
_LINE: Final = re.compile(rf"[{_KINDS}?](?:   (.*))?")
_KEYWORD: Final = re.compile(r'"([^\W\d]\w*)"i?')
_TERMINAL: Final = re.compile(r"^_?[A-Z_]+(?:\.\d+)?: /(?:\(\?:)?([A-Z_|]+)\)?(?:\(\?!|\\b)", re.MULTILINE)
_HEAD: Final = "?"  # a line above all others
_CONTEXT: Final = 200  # characters of a declared line that are shown


# --- what a reader makes of a text, as readings spell it ------------------------------------------------------


def reading(program: Program) -> list[str]:
    """The lines of the text, each with its letter and with what it means below it."""
    source = program.source
    meanings: dict[int, list[str]] = {}
    for at, text in _meanings(program):
        known = 0 < at <= len(source.lines)
        meanings.setdefault(at if known else 0, []).append(
            f"{_INDENT}{text}{'' if known or not at else f' @{at}'}"
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
        yield routine.line, f"Routine {_fields(routine, ('line', 'body', 'points', 'data'))}"
        yield from ((routine.line, f"beside: {spelled(one)}") for one in routine.data)
        yield from _of_body(routine)
    yield from ((d.line, _finding(d, program.path)) for d in program.diagnostics)


def _of_body(routine: Routine) -> Iterator[tuple[int, str]]:
    yield from ((one.line, spelled(one)) for one in routine.body)
    for store, taught, point in routine.points:
        yield point.line, f"{'taught ' if taught else ''}{store} {point.number}: {_point(point)}".rstrip()


def _point(point: Point) -> str:
    values = point.values
    state = _fields(point.state, ("kind",))
    if point.state.kind is PointKind.POSE:
        return f"{_pose(values)} {state}"
    scale = 1.0 if point.state.kind is PointKind.PULSE else DEG
    return f"{point.state.kind}({_numbers(v / scale for v in values)}) {state}"


def _finding(found: Diagnostic, path: str) -> str:
    where = f"{found.column}-{found.end_column}"
    if found.file not in ("", path):
        where = f"{Path(found.file).name}:{found.line}:{where}"
    text = f"!{found.severity} {found.code} {where} {found.message}"
    return f"{text} | {found.help}" if found.help else text


def spelled(node: Any) -> str:
    """A statement, an expression or any other value of a program in one line of plain words."""
    for kinds, spell in _SPELLINGS:
        if isinstance(node, kinds):
            return spell(node)
    text = f"{type(node).__name__} {_fields(node)}".rstrip()
    return text if hasattr(node, "line") else f"<{text}>"


def _fields(node: Any, but: Iterable[str] = ("line",)) -> str:
    """`name=value` of all fields that have not their default."""
    if is_dataclass(node):
        defaults = {one.name: one.default for one in fields(node)}
    else:
        defaults = {name: node._field_defaults.get(name, _fields) for name in node._fields}
    given = ((name, getattr(node, name)) for name in defaults if name not in but)
    return " ".join(f"{name}={spelled(v)}" for name, v in given if not _is_default(v, defaults[name]))


def _is_default(value: Any, default: Any) -> bool:
    empty = isinstance(value, Mapping | tuple) and not value
    return empty or (type(value) is type(default) and value == default)


def _number(value: float) -> str:
    return repr(value) if isinstance(value, int) else repr(float(f"{value:.9g}"))


def _numbers(values: Iterable[float]) -> str:
    return " ".join("-" if math.isnan(v) else f"{round(v, 6) + 0.0:.12g}" for v in values)


def _pose(values: tuple[float, ...]) -> str:
    more = f" +{_numbers(v / DEG for v in values[6:])}" if len(values) > 6 else ""
    return f"pose({_numbers(v / MM for v in values[:3])}, {_numbers(v / DEG for v in values[3:6])}{more})"


def _position(node: PositionLiteral) -> str:
    made = _pose(node.values) if node.kind == "pose" else f"joint({_numbers(v / DEG for v in node.values)})"
    more = _fields(node, ("kind", "values"))
    return f"{made[:-1]}; {more})" if more else made


def _logic(node: Logic) -> str:
    return f"({spelled(node.first)}{''.join(f' {word} {spelled(one)}' for word, one in node.rest)})"


def _called(name: str, arguments: Iterable[Any]) -> str:
    return f"{name}({', '.join(map(spelled, arguments))})"


def _with_unit(unit: str, value: Quantity | None, native: str = "") -> str:
    words = [
        str(unit),
        *([spelled(value)] if value is not None else ()),
        *([f"as {native}"] if native else ()),
    ]
    return f"<{' '.join(words)}>"


def _tuple(node: Any) -> str:
    if hasattr(node, "_fields"):
        return f"<{type(node).__name__} {_fields(node, ())}>"
    return f"[{', '.join(map(spelled, node))}]"


_SPELLINGS: Final[tuple[tuple[Any, Callable[[Any], str]], ...]] = (
    (type(None), lambda n: "none"),
    (Enum, lambda n: str(n.value)),
    (bool, lambda n: "yes" if n else "no"),
    ((int, float), _number),
    (str, lambda n: n if re.fullmatch(r"[\w.$#-]+", n) else repr(n)),
    (Number, lambda n: _number(n.value)),
    (Text, lambda n: repr(n.value)),
    (SignalState, lambda n: "on" if n.on else "off"),
    (Named, lambda n: n.name),
    (Quantity, lambda n: f"{spelled(n.written)}*{_UNITS.get(n.scale) or _number(n.scale)}"),
    ((Speed, Acceleration), lambda n: _with_unit(n.unit, *n[1:])),
    (Blend, lambda n: _with_unit(n.kind, *n[1:])),
    (Unary, lambda n: f"({n.operator} {spelled(n.operand)})"),
    ((Binary, Compare), lambda n: f"({spelled(n.left)} {n.operator} {spelled(n.right)})"),
    (Logic, _logic),
    (Item, lambda n: f"{spelled(n.base)}{_tuple(n.indices)}"),
    (Member, lambda n: f"{spelled(n.base)}.{n.name}"),
    (Signal, lambda n: f"{n.bus}[{spelled(n.index)}]{n.part}"),
    (FrameRef, lambda n: f"{n.kind}#{spelled(n.number)}" if n.number is not None else f"{n.kind}#"),
    (Function, lambda n: _called(n.name, n.arguments)),
    (CallValue, lambda n: _called(f"call {n.routine}", n.arguments)),
    (PositionLiteral, _position),
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
    return [match[1] or "" for row in rows if (match := _LINE.fullmatch(row))]


@contextmanager
def _written_out(vendor: Vendor, files: Mapping[str, list[str]]) -> Iterator[Path]:
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
    with _written_out(vendor, files) as folder:
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


def declare(vendor: Vendor, path: Path) -> None:
    """Writes below each line of the texts in a `.reading` what the reader takes it for, for its author to check.

    A line that was just added may have ? for its letter.
    """
    save(path, found_readings(vendor, load_declared(path)))
    for suffix, derive in DERIVED.items():
        if found := derive(vendor, path):
            save(path.with_suffix(suffix), found)
        else:
            path.with_suffix(suffix).unlink(missing_ok=True)


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
            line = next((row for row in reversed(wanted[:at]) if _LINE.fullmatch(row)), "")
            yield f"{path.name}, {name}: {line[4:].strip()}", f"declared: {a}; read: {b}"


def differences(wanted: list[str], found: list[str]) -> Iterator[tuple[int, str, str]]:
    """Where rows differ: the row at which one looks for the place, and both texts."""
    if wanted == found:
        return
    for word, a, b, c, d in SequenceMatcher(None, wanted, found, autojunk=False).get_opcodes():
        if word != "equal":
            one, other = (" / ".join(map(str.strip, part))[:_CONTEXT] for part in (wanted[a:b], found[c:d]))
            yield a + (word != "insert"), one, other


# --- damaged lines --------------------------------------------------------------------------------------------

_DAMAGED: Final = ".damaged"
_TOKEN: Final = re.compile(r"\"[^\"]*\"|'[^']*'|\d+(?:\.\d+)?|[^\W\d][\w$]*|\S")
_LITERAL: Final = re.compile(r"(?<![\w.$])(?<!-)\d+(?:\.\d+)?(?![\w.])")
_WORD: Final = re.compile(r"[^\W\d]{4,}")
_EVERY: Final = 5  # of so many lines one is damaged, so that the others stay what they are
_OTHERS: Final = 8  # lines that are not damaged and shown, where they mean something else
_LONGEST: Final = 400  # characters of a meaning
_AS_BEFORE: Final = f"{_INDENT}as before"


def _without(text: str, share: float) -> str:
    """The text without one of its tokens."""
    spans = [match.span() for match in _TOKEN.finditer(text)]
    if len(spans) < 2:
        return text
    start, end = spans[min(int(share * len(spans)), len(spans) - 1)]
    return f"{text[:start].rstrip()} {text[end:].lstrip()}".rstrip()


def _without_a_letter(text: str) -> str:
    word = _WORD.search(text)
    return text if word is None else text[: word.start() + 1] + text[word.start() + 2 :]


# (a line, the line above) -> the damaged line
_DAMAGES: Final[tuple[Callable[[str, str], str], ...]] = (
    lambda text, above: _without(text, 1.0),
    lambda text, above: _LITERAL.sub(lambda number: f"-{number[0]}", text, count=1),
    lambda text, above: _without_a_letter(text),
    lambda text, above: _without(text, 0.5),
    lambda text, above: _LITERAL.sub(lambda number: f"{number[0]}x", text, count=1),
    lambda text, above: _LITERAL.sub(lambda number: f"7{number[0]}000", text),
    lambda text, above: "",
    lambda text, above: above,
)


def _damaged(rows: Iterable[str], turn: int) -> list[str]:
    """The lines of a declared reading, some of which are damaged: in each of the turns others, and otherwise."""
    lines = [row for row in rows if _LINE.fullmatch(row)]
    found, at = lines[:1], 0
    for above, row in pairwise(lines):
        text = row[4:]
        at += row[0] in "SRP"
        if row[0] in "SRP" and at % _EVERY == turn % _EVERY:
            order = ((at + turn + n) % len(_DAMAGES) for n in range(len(_DAMAGES)))
            text = next(other for n in order if (other := _DAMAGES[n](text, above[4:])) != text)
        found.append(f"{row[:4]}{text}".rstrip())
    return found


def _lines_of(rows: Iterable[str]) -> list[list[str]]:
    """Each line of a reading with what is below it; what is above the first is left out."""
    found: list[list[str]] = []
    for row in rows:
        if _LINE.fullmatch(row):
            found.append([row])
        elif found:
            found[-1].append(row)
    return found


def _told_of(whole: list[list[str]], after: list[list[str]]) -> Iterator[str]:
    """The damaged lines with what they mean, some of the others that mean something else then, and how many more do."""
    others = 0
    for one, other in zip(whole, after, strict=True):
        if one == other:
            continue
        if one[0][1:] == other[0][1:]:
            others += 1
            if others > _OTHERS:
                continue
        meaning = [row[:_LONGEST] for row in other[1:] if not row.startswith(f"{_INDENT}Opaque ")]
        same = one[0][1:] != other[0][1:] and (one[0][0], one[1:]) == (other[0][0], other[1:])
        yield from [other[0], _AS_BEFORE] if same else [other[0], *meaning]
    if others > _OTHERS:
        yield f"({others - _OTHERS} more lines)"


def damaged_readings(vendor: Vendor, path: Path) -> dict[str, list[str]]:
    """What is read otherwise of the texts in a `.reading` when lines of them are damaged."""
    declared = load_declared(path)
    whole = {name: _lines_of(reading(program)) for name, program in programs_of(vendor, declared)}
    parts: dict[str, list[str]] = {}
    for turn in range(2 * _EVERY):
        texts = {name: _damaged(rows, turn) for name, rows in declared.items()}
        for name, program in programs_of(vendor, texts):
            if told := list(_told_of(whole[name], _lines_of(reading(program)))):
                parts[f"{name}, {turn}"] = told
    return parts


# --- what a controller refuses to load ------------------------------------------------------------------------

_LOADED: Final = ".loaded"


def loaded(vendor: Vendor, path: Path) -> dict[str, list[str]]:
    """What a controller refuses of the programs in a `.reading`, and of a sound folder's once lines are damaged."""
    loading = part_of(vendor.name, "load")
    if loading is None:
        return {}
    declared = load_declared(path)
    found: dict[str, list[str]] = {}
    for controller in loading.controllers:
        found |= _refused(vendor, loading, declared, f", {controller}", controller)
    if not found:
        for turn in range(2 * _EVERY):
            texts = {name: _damaged(rows, turn) for name, rows in declared.items()}
            found |= _refused(vendor, loading, texts, f", {turn}", "")
    return found


def _refused(
    vendor: Vendor, loading: Loading, texts: Mapping[str, list[str]], how: str, controller: str
) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    with _written_out(vendor, texts) as folder:
        for name in texts:
            if Path(name).suffix.lower() in vendor.suffixes:
                source = load(folder / name)
                told = loading.check(source, cell_of(source, vendor, loading, controller))
                rows = [(one.source_line, f"{one.line}: {_finding(one, source.path)}") for one in told]
                if rows:
                    found[f"{name}{how}"] = [
                        row for text, said in rows for row in (f"?   {text}", f"{_INDENT}{said}")
                    ]
    return found


# --- what other languages get ---------------------------------------------------------------------------------


def called(vendor: Vendor, path: Path) -> dict[str, list[str]]:
    """The lines of the texts in a `.reading` that mean something else to other languages."""
    parts: dict[str, list[str]] = {}
    for name, program in programs_of(vendor, load_declared(path)):
        routines = {one.name.casefold(): one for one in program.routines}

        def find(name: str, routines: Mapping[str, Routine] = routines) -> Routine | None:
            return routines.get(name.casefold())

        spelt = (
            with_rows(one, vendor.without_editor_comments(vendor.spelled_out(one.body, find)))
            for one in program.routines
        )
        whole, after = (reading(one) for one in (program, vendor.as_called(with_routines(program, spelt))))
        if whole != after:
            rows = zip(_lines_of([_HEAD, *whole]), _lines_of([_HEAD, *after]), strict=True)
            parts[name] = [row for one, other in rows if one != other for row in other]
    return parts


# --- what editors are told ------------------------------------------------------------------------------------


def edited(vendor: Vendor, path: Path) -> dict[str, list[str]]:
    """The lines of the texts in a `.reading` with what editors are told of them."""
    words: Words | None = part_of(vendor.name, "tokens")
    parts: dict[str, list[str]] = {}
    for name, program in programs_of(vendor, load_declared(path)):
        lines = program.source.lines
        layout = words.layout.lines(lines, "  ") if words is not None and words.layout is not None else lines
        places: dict[int, list[str]] = {}
        for at, text in _places(program):
            places.setdefault(at, []).append(text)
        rows: list[str] = []
        for number, (line, laid) in enumerate(zip(lines, layout, strict=True), 1):
            said = " ".join(map(_word, words.words(line))) if words is not None else ""
            told = [said] if said else []
            told += [f"laid out: {laid}"] if laid != line else []
            told += places.get(number, ())
            if told:
                rows += [f"?   {line}", *(f"{_INDENT}{one}" for one in told)]
        if rows:
            parts[name] = rows
    return parts


def _word(word: Word) -> str:
    marks = "".join(
        mark for mark, holds in (("=", word.defines), (".", word.local), ("~", word.plain)) if holds
    )
    kind = "" if word.kind is None else f" {word.kind.value}"
    return f"[{word.column}-{word.end_column} {word.key}{kind}{marks}]"


def _places(program: Program) -> Iterator[tuple[int, str]]:
    """(line, what stands there) of all that can be changed in the text."""
    try:
        places = language(program)
    except OlpError:
        return
    for point in places.points(program):
        of = "" if point.source is program.source else f" in {Path(point.source.path).name}"
        target = "" if point.target is None else f" {spelled(point.target)}"
        yield point.line, f"position {point.name}{target} {point.kind}{of}: {_spans(point.numbers)}"
    for line, speed, written, place in speeds(program):
        more = _fields(place, ("line", "source", "tokens"))
        yield line, f"speed {spelled(speed)} on line {written}: {_spans(place.tokens)} {more}".rstrip()
    for number in range(1, len(program.source.lines) + 1):
        if where := _spans(places.accelerations(program.source, number)):
            yield number, f"acceleration: {where}"


def _spans(tokens: Iterable[Token]) -> str:
    return " ".join(f"{one.line}:{one.start}-{one.stop}{'|' if one.padded else ''}" for one in tokens)


# --- merges ---------------------------------------------------------------------------------------------------

_SIDES: Final = ((0, 1), (2, 2 + _EVERY))  # the turns of damage of two sides: in other lines, and in the same


def merged(vendor: Vendor, path: Path) -> dict[str, list[str]]:
    """What merges make of the texts in a `.reading` when both sides damage lines of them."""
    declared = load_declared(path)
    parts: dict[str, list[str]] = {}
    for turns in _SIDES:
        sides = [{name: _damaged(rows, turn) for name, rows in declared.items()} for turn in turns]
        for name, rows in declared.items():
            if Path(name).suffix.lower() in (*vendor.suffixes, *vendor.list_suffixes):
                texts = ("\n".join([*text_of(one), ""]).encode() for one in (rows, *(s[name] for s in sides)))
                if told := list(_merge(vendor, *texts)):
                    parts[f"{name}, {turns[0]} and {turns[1]}"] = told
    return parts


def _merge(vendor: Vendor, base: bytes, ours: bytes, theirs: bytes) -> Iterator[str]:
    try:
        found = merge_bytes(vendor.name, base, ours, theirs)
    except OlpError as refused:
        yield from (f"refused: {one.message}" for one in refused.diagnostics)
        return
    made = [row.rstrip() for row in found.to_bytes().decode("utf-8", "replace").splitlines()]
    for at, one, other in differences([row.rstrip() for row in base.decode().splitlines()], made):
        yield f"{at}: {one} -> {other}"
    for what, value in (("taken", found.taken), ("renamed", found.renamed), ("shared", found.shared)):
        if value:
            yield f"{what}: {spelled(value)}"
    yield from (f"conflict: {one.what} {one.name}".rstrip() for one in found.hunks)


# --- all that follows from a text -----------------------------------------------------------------------------

# Suffix of a file beside a `.reading` -> what stands in it; none where nothing does.
DERIVED: Final[Mapping[str, Callable[[Vendor, Path], dict[str, list[str]]]]] = {
    _DAMAGED: damaged_readings,
    _LOADED: loaded,
    ".called": called,
    ".edited": edited,
    ".merged": merged,
}


def unlike_derived(vendor: Vendor, path: Path, suffix: str) -> Iterator[Difference]:
    """Where what is declared in the file of this suffix beside a `.reading` and what is found differ."""
    path, parts = path.with_suffix(suffix), DERIVED[suffix](vendor, path)
    declared = load_declared(path) if path.exists() else {}
    for name in dict.fromkeys((*parts, *declared)):
        for at, a, b in differences(declared.get(name, []), parts.get(name, [])):
            yield f"{path.name}, {name}, line {at}", f"declared: {a}; found: {b}"


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
