"""VAL3 data: what a .dtx file declares, and what a program must know of the .dtx files beside it.

All data of VAL3 are arrays. One element is read as a plain variable, more as an array.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from html import unescape
from pathlib import Path
from typing import Final, NamedTuple

from olp.core.source import Source, load
from olp.ir.expressions import Expression, Function, Item, Named, Number, RecordLiteral, SignalState, Text
from olp.ir.program import Declare
from olp.languages.short_reader import array, joints, xyz_pose
from olp.languages.vendors.val3.known_functions import JOINTS, MEMBER_TYPES, POSES

WORLD, MIXED = "world[0]", "?"
SIGNALS: Final = frozenset(("dio", "aio"))
_TYPES: Final = {"num": "real", "bool": "boolean", "string": "string", "mdesc": "mdesc"}
_TAG = re.compile(r"<(/?)([\w:]+)((?:\s+[\w:.\-]+\s*=\s*\"[^\"<]*\")*)\s*(/?)>")
_ATTRIBUTE = re.compile(r"([\w:.\-]+)\s*=\s*\"([^\"]*)\"")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
# A new motion descriptor, so also what a file leaves out. `blend` is 0 for off: it multiplies `leave`.
MDESC: Final = {"accel": 100.0, "vel": 100.0, "decel": 100.0, "tmax": 99999.0, "rmax": 99999.0}
_NO_BOUND: Final = "99999"
_MOST: Final = 5000  # elements of an array
_MOST_ROOM: Final = 500_000  # elements of all data together
_MOST_FILES, _MOST_BYTES = 8, 4_000_000
_MOST_TYPES: Final = 40  # of a project


class XmlTag(NamedTuple):
    """`closes`: </name>. `line` counts from 1."""

    name: str
    attributes: Mapping[str, str]
    closes: bool
    line: int


@dataclass(frozen=True, slots=True)
class Val3Declarations:
    """What a program must know of data: `types` of names, `arrays` with more than one element, `fathers`: the frame
    of a point or of one element of it, `outputs`: signals that the program may set, `unbounded`: motion descriptors
    that bound no path (tmax 99999)."""

    types: dict[str, str] = field(default_factory=dict)
    arrays: set[str] = field(default_factory=set)
    fathers: dict[str, str] = field(default_factory=dict)
    outputs: set[str] = field(default_factory=set)
    unbounded: set[str] = field(default_factory=set)
    path: str = ""  # of the program


def tags(source: Source) -> Iterator[XmlTag]:
    """All tags that stand on one line, in order."""
    for number, line in enumerate(source.lines, 1):
        if "<" not in line:
            continue
        for match in _TAG.finditer(line):
            attributes = {name: unescape(value) for name, value in _ATTRIBUTE.findall(match[3])}
            yield XmlTag(match[2], attributes, bool(match[1]), number)


@dataclass(slots=True)
class Datum:
    """One <Data> with the attributes of its values by key."""

    name: str
    type: str
    size: int
    line: int
    values: dict[int, Mapping[str, str]] = field(default_factory=dict)


def read_data(source: Source) -> list[Datum]:
    """The data of a .dtx file, of either schema."""
    found: list[Datum] = []
    for tag in tags(source):
        name = tag.name.lower()
        if tag.closes:
            continue
        if name == "data" and "name" in tag.attributes:
            size = re.match(r"\d{1,6}", tag.attributes.get("size", "1"))
            count = min(int(size[0]), _MOST) if size else 1
            found.append(Datum(tag.attributes["name"], tag.attributes.get("type", ""), count, tag.line))
        elif name.endswith("value") and found:
            key = tag.attributes.get("key", "0")
            last = found[-1]
            if key.isdigit() and int(key) < _MOST and (len(tag.attributes) > 1 or name == "value"):
                last.values[int(key)] = tag.attributes
    return found


def declarations(data: list[Datum]) -> list[Declare]:
    """The data as declarations, frames behind those that they stand in."""
    made: list[Declare] = []
    room = _MOST_ROOM
    for one in sorted(data, key=_depth(data)):
        type_ = (
            "position" if one.type in POSES else "joints" if one.type in JOINTS else _TYPES.get(one.type, "")
        )
        if not type_:
            continue
        values = {
            key: _value(one.type, attributes) for key, attributes in one.values.items() if key < one.size
        }
        plain = _value(one.type, {})
        if one.size <= 1:
            made.append(
                Declare(one.line, one.name, type_, values.get(0, plain), shared=True, native=one.type)
            )
            continue
        room -= one.size
        if room < 0:  # larger than any controller's memory: what has no value is left out
            one = Datum(one.name, one.type, max(values, default=0) + 1 if room > -_MOST_ROOM else 1, one.line)
        filled: dict[tuple[int, ...], Expression] = {(k,): v for k, v in values.items() if k < one.size}
        filled.setdefault((one.size - 1,), plain)
        sizes = (Number(one.size),)
        made.append(
            Declare(
                one.line, one.name, type_, array(one.type, filled, plain), sizes, shared=True, native=one.type
            )
        )
    return made


def _depth(data: list[Datum]) -> Callable[[Datum], int]:
    """How many frames a frame stands in; 0 for everything else."""
    fathers = {one.name: father_of(one) for one in data if one.type == "frame"}

    def depth(one: Datum) -> int:
        name, steps = one.name, 0
        while name in fathers and steps < len(fathers):
            name, steps = fathers[name].partition("[")[0], steps + 1
        return steps

    return depth


def father_of(one: Datum) -> str:
    """The frame that all values of a datum stand in; WORLD, or MIXED where they differ."""
    found = {_frame(attributes) for attributes in one.values.values()} or {WORLD}
    return next(iter(found)) if len(found) == 1 else MIXED


def _frame(attributes: Mapping[str, str]) -> str:
    father = attributes.get("fatherId", "")
    return WORLD if father.partition("[")[0] in ("world", "flange", "") else father


def named(father: str) -> Expression:
    """fPart[0] is fPart itself, fPart[2] its third element."""
    name, _, index = father.partition("[")
    number = index.rstrip("]")
    return (
        Item(Named(name), (Number(int(number) + 1),)) if number.isdigit() and number != "0" else Named(name)
    )


def _value(type_: str, attributes: Mapping[str, str]) -> Expression:
    def number(name: str, default: float = 0.0) -> float:
        text = attributes.get(name, "")
        value = float(text) if _NUMBER.fullmatch(text) and len(text) < 40 else default
        return value if math.isfinite(value) else default

    if type_ in POSES:
        native = tuple((n, attributes[n]) for n in ("shoulder", "elbow", "wrist") if n in attributes)
        pose: Expression = xyz_pose([number(n) for n in ("x", "y", "z", "rx", "ry", "rz")], native)
        father = attributes.get("fatherId", "")
        if type_ == "frame" and father.partition("[")[0] not in ("world", ""):
            return Function("pose-product", (named(father), pose))
        return pose
    if type_ in JOINTS:
        return joints(number(f"j{n}") for n in range(1, 7))
    if type_ == "mdesc":
        blend = attributes.get("blend", "off").lower() not in ("off", "")
        values = [(name, number(name, default)) for name, default in MDESC.items()]
        values += [
            ("leave", number("leave", 50.0)),
            ("reach", number("reach", 50.0)),
            ("blend", float(blend)),
        ]
        return RecordLiteral("mdesc", tuple((name, Number(value)) for name, value in values))
    text = attributes.get("value", "")
    if type_ == "bool":
        return SignalState(text.lower() == "true")
    return Text(text) if type_ == "string" else Number(number("value"))


def know(known: Val3Declarations, data: list[Datum]) -> None:
    for one in data:
        known.types.setdefault(one.name, one.type)
        if one.size > 1:
            known.arrays.add(one.name)
        if one.type in SIGNALS and any(
            "%Q" in attributes.get("link", "") for attributes in one.values.values()
        ):
            known.outputs.add(one.name)
        if one.type == "mdesc" and all(
            attributes.get("tmax", _NO_BOUND) == _NO_BOUND for attributes in one.values.values()
        ):
            known.unbounded.add(one.name)
        if one.type.startswith("point"):
            known.fathers.setdefault(one.name, father_of(one))
            for key, attributes in one.values.items() if one.size > 1 else ():
                known.fathers.setdefault(f"{one.name}[{key}]", _frame(attributes))


def beside(path: str) -> Val3Declarations:
    """What the .dtx files in a program's folder say; nothing where there is no folder."""
    known = Val3Declarations(path=path)
    if not path:
        return known
    try:
        files = sorted(one for one in Path(path).parent.glob("*.dtx") if one.is_file())[:_MOST_FILES]
        for file in files:
            status = file.stat()
            if status.st_size <= _MOST_BYTES:
                know(known, list(_cached(str(file), status.st_mtime_ns, status.st_size)))
    except OSError:
        return known
    return known


_USES_FRAMES = re.compile(r"\b(?:move[jlc]|compose)\s*\(|\bcall\b")


def frame_of(point: str) -> str:
    """The parameter that says in which frame a point stands that a program is handed: it comes from its caller."""
    return f"{point}_frame"


def handed_points(source: Source) -> tuple[tuple[int, str], ...]:
    """The places, from 0, and names of the parameters that are points, in a program that moves to any."""
    if not any(_USES_FRAMES.search(line) for line in source.lines):
        return ()
    names = [(one.attributes["name"], one) for one in tags(source) if is_parameter(one)]
    return tuple((at, name) for at, (name, one) in enumerate(names) if is_handed_point(one))


def is_parameter(tag: XmlTag) -> bool:
    return tag.name.lower() == "parameter" and not tag.closes and bool(tag.attributes.get("name"))


def is_handed_point(tag: XmlTag) -> bool:
    """Whether a parameter is one point; the points of an array may stand in different frames."""
    kind = tag.attributes.get("type", "")
    return kind.startswith("point") and tag.attributes.get("xsi:type") != "array"


def points_of_call(known: Val3Declarations, routine: str) -> tuple[int, ...]:
    """The places of the arguments whose frames a program takes besides, by its file beside the calling one."""
    if not known.path or not re.fullmatch(r"\w{1,80}", routine):
        return ()
    file = Path(known.path).parent / f"{routine}.pgx"
    try:
        status = file.stat()
        if status.st_size > _MOST_BYTES:
            return ()
        return tuple(at for at, _ in _cached_points(str(file), status.st_mtime_ns, status.st_size))
    except OSError:
        return ()


@lru_cache(maxsize=256)
def _cached_points(path: str, _time: int, _size: int) -> tuple[tuple[int, str], ...]:
    return handed_points(load(path))


def structures(path: str, wanted: set[str]) -> list[Declare]:
    """The layouts of a project's own types, and of those of their members: what .dtx files of libraries declare.

    The project beside the program says where each is: `Disk://ros_libs/Body/Body.pjx`, from the folder that holds the
    project's own.
    """
    folder = Path(path).parent
    try:
        files = _types_of(folder) if path and wanted else {}
    except OSError:
        return []
    made: dict[str, Declare] = {}
    todo = sorted(wanted)
    while todo and len(made) < _MOST_TYPES:
        name = todo.pop(0)
        if name in made:
            continue
        data = None if name == "mdesc" else _type_data(files.get(name))
        if data is None and name != "mdesc":
            continue
        members = [(one.name, one.type, one.size) for one in data or ()] or [
            (word, "num", 1) for word in (*MDESC, "leave", "reach", "blend")
        ]
        rows = tuple(
            (word, RecordLiteral(kind, (("", Number(size)),) if size > 1 else ()))
            for word, kind, size in members
        )
        made[name] = Declare(0, name, "structure", RecordLiteral("type", rows), shared=True, native="type")
        todo += sorted({kind for _, kind, _ in members if kind not in MEMBER_TYPES})
    return list(made.values())


def _types_of(folder: Path) -> dict[str, Path]:
    """Where the data of each type are that the projects in a folder name."""
    found: dict[str, Path] = {}
    for file in sorted(one for one in folder.glob("*.pjx") if one.is_file())[:_MOST_FILES]:
        if file.stat().st_size > _MOST_BYTES:
            continue
        for tag in tags(load(file)):
            place = tag.attributes.get("path", "").partition("://")[2].split("/")
            if tag.name.lower() == "type" and "name" in tag.attributes and ".." not in place:
                found.setdefault(tag.attributes["name"], folder.parent.joinpath(*place).with_suffix(".dtx"))
    return found


def _type_data(file: Path | None) -> tuple[Datum, ...] | None:
    """What the file of a type declares, None where there is no such file."""
    try:
        if file is None or not file.is_file() or file.stat().st_size > _MOST_BYTES:
            return None
        status = file.stat()
        return _cached(str(file), status.st_mtime_ns, status.st_size)
    except OSError:
        return None


@lru_cache(maxsize=32)
def _cached(path: str, _time: int, _size: int) -> tuple[Datum, ...]:
    return tuple(read_data(load(path)))
