"""A PolyScope program (.urp: compressed XML) as lines that can be merged, and back.

What is used in several places stands at the first, and the others name it by its path (`../../Move[2]/feature`), which
any node in between changes. As lines, all of these say a key (`reference="#Base"`), and what they mean stands at the
end, sorted by key. Text in an element stands in lines of its own, behind `|`. Packed again, the XML is the same.
"""

from __future__ import annotations

import gzip
import re
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from olp.languages.merging import Known, MoveArgument, PackedRules, Piece, RecordRule

_LARGEST: Final = 50_000_000  # bytes that are unpacked; the largest programs have a tenth
_DEEPEST: Final = 200  # elements in one another
_TAG: Final = re.compile(r'<(/?)([A-Za-z_][\w.:-]*)((?:\s+[\w.:-]+="[^"<]*")*)\s*(/?)>')
_ATTRIBUTE: Final = re.compile(r'([\w.:-]+)="([^"]*)"')
_HEAD: Final = re.compile(r'@([\w.:-]+)="([^"<]*)"')
_STEP: Final = re.compile(r"([\w.:-]+)(?:\[(\d+)\])?")
_NAMES: Final = ("name", "featureName", "referencedName")
# What PolyScope refers to where it stands a second time.
_SHARED: Final = frozenset(
    {"feature", "pin", "tcp", "variable", "ProgramVariable", "InstallationVariable", "GeomFeatureVariable"}
)
_OBJECTS: Final = "olp-shared"

Path = tuple[tuple[str, int], ...]


@dataclass(slots=True, eq=False)
class PolyscopeNode:
    """An element. `text` None: it has none, but children or nothing."""

    tag: str
    attributes: dict[str, str]
    children: list[PolyscopeNode] = field(default_factory=list)
    text: str | None = None


def unpacked(data: bytes) -> bytes:
    """The lines of a .urp file. Raises ValueError and zlib.error for what PolyScope does not write."""
    raw = data
    if not is_plain(data):
        unpacker = zlib.decompressobj(31)
        raw = unpacker.decompress(data, _LARGEST)
        if unpacker.unconsumed_tail or not unpacker.eof:
            raise ValueError("it is cut, or larger than 50 MB")
    root = _tree(raw.decode("utf-8"))
    if root.tag != "URProgram":
        raise ValueError(f"its first node is {root.tag[:40]}")
    parents = {child: node for node in _all(root) for child in node.children}
    keys, meant = _keys(root, parents)
    lines = [f"<{root.tag}>", *(f'@{name}="{value}"' for name, value in root.attributes.items())]
    for child in root.children:
        lines += _lines(child, 1, keys)
    lines += [f"</{root.tag}>", f"<{_OBJECTS}>"]
    for key, node in sorted(meant.items()):
        attributes = {"key": key, **{k: v for k, v in node.attributes.items() if k != "class"}}
        lines += _lines(PolyscopeNode("object", attributes, node.children, node.text), 1, keys)
    return "\n".join([*lines, f"</{_OBJECTS}>", ""]).encode()


def is_plain(data: bytes) -> bool:
    """Whether it is the XML itself, as some tools save it."""
    return data.lstrip().startswith(b"<")


def packed(lines: bytes, plain: bool = False) -> bytes:
    """The file that these lines tell. Raises ValueError where they tell none, as without the end of a node."""
    nodes = _nodes(lines.decode("utf-8").split("\n"))
    if len(nodes) != 2 or nodes[1].tag != _OBJECTS:
        raise ValueError("a node has no end")
    writer = _XmlWriter({node.attributes.get("key", ""): node for node in nodes[1].children})
    writer.write(nodes[0], (), (nodes[0].tag, 1))
    raw = "\n".join(writer.lines).encode()
    return raw if plain else gzip.compress(raw, mtime=0)


# --- XML ---


def _tree(text: str) -> PolyscopeNode:
    """The elements of a text as XStream writes it: nothing but elements, and text in those without children."""
    top = PolyscopeNode("", {})
    within, at = [top], 0
    for match in _TAG.finditer(text):
        between, at = text[at : match.start()], match.end()
        ends, tag, attributes, empty = match.groups()
        node = within[-1]
        if ends:
            if node.tag != tag or len(within) == 1:
                raise ValueError(f"</{tag[:40]}> ends nothing")
            if not node.children:
                node.text = _plain(between)
            elif between.strip():
                raise ValueError(f"there is text between the nodes of {tag[:40]}")
            within.pop()
            continue
        if between.strip() or len(within) > _DEEPEST:
            raise ValueError(f"there is text in front of {tag[:40]}, or it is too deep")
        new = PolyscopeNode(tag, dict(_ATTRIBUTE.findall(attributes)))
        node.children.append(new)
        if not empty:
            within.append(new)
    if len(within) > 1 or text[at:].strip() or len(top.children) != 1:
        raise ValueError("a node has no end")
    return top.children[0]


def _plain(text: str) -> str:
    if "<" in text or "\r" in text:
        raise ValueError("its text has characters that PolyScope does not write")
    return text


def _all(node: PolyscopeNode) -> Iterator[PolyscopeNode]:
    yield node
    for child in node.children:
        yield from _all(child)


def _keys(
    root: PolyscopeNode, parents: Mapping[PolyscopeNode, PolyscopeNode]
) -> tuple[dict[PolyscopeNode, str], dict[str, PolyscopeNode]]:
    """The key of each place that something shared stands in, and what each key means."""
    places = {node: _meant(node, parents) for node in _all(root) if "reference" in node.attributes}
    wanted = set(places.values())
    often: Counter[str] = Counter()
    keys: dict[PolyscopeNode, str] = {}
    meant: dict[str, PolyscopeNode] = {}
    for node in _all(root):
        if node in places or not (node in wanted or (node.tag in _SHARED and not node.children)):
            continue
        name = next((node.attributes[one] for one in _NAMES if node.attributes.get(one)), node.tag)
        often[name] += 1
        keys[node] = f"#{name}" if often[name] == 1 else f"#{name} {often[name]}"
        meant[keys[node]] = node
    keys.update({place: keys[node] for place, node in places.items()})
    return keys, meant


def _meant(node: PolyscopeNode, parents: Mapping[PolyscopeNode, PolyscopeNode]) -> PolyscopeNode:
    """What a node refers to."""
    place: PolyscopeNode | None = node
    for step in node.attributes["reference"].split("/"):
        match = _STEP.fullmatch(step)
        if place is not None and step == "..":
            place = parents.get(place)
        elif place is not None and match is not None:
            alike = [child for child in place.children if child.tag == match[1]]
            index = int(match[2] or 1) - 1
            place = alike[index] if index < len(alike) else None
    if place is None or "reference" in place.attributes:
        raise ValueError(f"{node.attributes['reference'][:80]} is no node")
    return place


# --- Lines ---


def _lines(node: PolyscopeNode, depth: int, keys: Mapping[PolyscopeNode, str]) -> Iterator[str]:
    indent = "  " * depth
    if node in keys:
        kind = {"class": node.attributes["class"]} if "class" in node.attributes else {}
        yield f"{indent}{_opened(node.tag, {**kind, 'reference': keys[node]})[:-1]}/>"
        return
    head = _opened(node.tag, node.attributes)
    if node.text is not None:
        yield f"{indent}{head}"
        yield from (f"|{line}" for line in node.text.split("\n"))
        yield f"{indent}</{node.tag}>"
    elif node.children:
        yield f"{indent}{head}"
        for child in node.children:
            yield from _lines(child, depth + 1, keys)
        yield f"{indent}</{node.tag}>"
    else:
        yield f"{indent}{head[:-1]}/>"


def _opened(tag: str, attributes: Mapping[str, str]) -> str:
    told = "".join(f' {name}="{value}"' for name, value in attributes.items())
    return f"<{tag}{told}>"


def _nodes(rows: Sequence[str]) -> list[PolyscopeNode]:
    top = PolyscopeNode("", {})
    within = [top]
    for row in rows:
        node = within[-1]
        head, tag = _HEAD.fullmatch(row.strip()), _TAG.fullmatch(row.strip())
        if row.startswith("|"):
            node.text = row[1:] if node.text is None else f"{node.text}\n{row[1:]}"
        elif head is not None:
            node.attributes[head[1]] = head[2]
        elif tag is None and row.strip():
            raise ValueError(f"{row.strip()[:40]} is no node")
        elif tag is not None and tag[1]:
            if node.tag != tag[2] or (node.text is not None and node.children):
                raise ValueError(f"{row.strip()[:40]} ends nothing")
            within.pop()
        elif tag is not None:
            node.children.append(PolyscopeNode(tag[2], dict(_ATTRIBUTE.findall(tag[3]))))
            within += node.children[-1:] if not tag[4] else []
    if len(within) > 1:
        raise ValueError(f"{within[-1].tag} has no end")
    return top.children


class _XmlWriter:
    """Writes XML as XStream does. `objects`: what is shared, by key; it is written where it stands first."""

    def __init__(self, objects: Mapping[str, PolyscopeNode]) -> None:
        self.lines: list[str] = []
        self._objects = objects
        self._places: dict[str, Path] = {}

    def write(self, node: PolyscopeNode, around: Path, step: tuple[str, int]) -> None:
        path = (*around, step)
        if len(path) > _DEEPEST:
            raise ValueError("nodes too deep")
        attributes, children, text = node.attributes, node.children, node.text
        key = attributes.get("reference", "")
        if key.startswith("#"):
            kind = {"class": attributes["class"]} if "class" in attributes else {}
            if key in self._places:
                attributes = {**kind, "reference": _way(path, self._places[key])}
            elif key in self._objects:
                self._places[key] = path
                meant = self._objects[key]
                own = {name: value for name, value in meant.attributes.items() if name != "key"}
                attributes, children, text = {**kind, **own}, meant.children, meant.text
            else:
                raise ValueError(f"{key[1:]} is used, and nothing says what it is")
        indent, head = "  " * len(around), _opened(node.tag, attributes)
        if text is not None:
            self.lines.append(f"{indent}{head}{text}</{node.tag}>")
            return
        if not children:
            self.lines.append(f"{indent}{head[:-1]}/>")
            return
        self.lines.append(indent + head)
        often: Counter[str] = Counter()
        for child in children:
            often[child.tag] += 1
            self.write(child, path, (child.tag, often[child.tag]))
        self.lines.append(f"{indent}</{node.tag}>")


def _way(start: Path, stop: Path) -> str:
    """From one element to another as XStream names it."""
    common = 0
    while common < min(len(start), len(stop)) and start[common] == stop[common]:
        common += 1
    down = [tag if number == 1 else f"{tag}[{number}]" for tag, number in stop[common:]]
    return "/".join([".."] * (len(start) - common) + down)


# --- Merging ---
# What may be changed independently: nodes, what they share, and each value of a node. A taught point, an expression or
# a pin is one thing, however many lines it has.


_VALUE = re.compile(r"( *)<([a-z][\w.:-]*)(?: [^>]*)?(?<!/)>$")
_NODES = frozenset({"children", "variables", "suppressedNode", "object"})
_POINT = re.compile(r" *</position>$")
_FEATURE = re.compile(r" *<BaseToFeature ")
_NAMED_VALUE = re.compile(r' ([\w.:-]+)="[^"]*"')
_INDEPENDENT = {
    "speed": "speed",
    "acceleration": "acceleration",
    "blendRadius": "zone",
    "motionType": "motion",
}


class PolyscopeMerging(PackedRules):
    """For a file like `data`: compressed, or the XML itself as some tools save it."""

    data = re.compile(r' *<object key="([^"]*)"')
    heads = (
        (
            re.compile(
                r"@(?:createdIn|lastSavedIn|directory|installationRelativePath|robotSerialNumber|crcValue)="
            ),
            RecordRule.SAVED_LAST,
        ),
        (re.compile(r"@[\w.:-]+="), RecordRule.ASK),
    )

    def __init__(self, data: bytes) -> None:
        self._is_plain = is_plain(data)

    def unpack(self, data: bytes) -> bytes:
        try:
            return unpacked(data)
        except UnicodeDecodeError:
            raise ValueError("it is not UTF-8") from None
        except zlib.error as problem:
            raise ValueError(str(problem)) from None

    def pack(self, text: bytes) -> bytes:
        return packed(text, self._is_plain)

    def code(self, line: str) -> str:
        words = " ".join(line.removeprefix("|").split())
        return words if words or not line.startswith("|") else self.silent("|")

    def arguments(self, code: str) -> list[MoveArgument]:
        if not code.startswith("<"):
            return []
        found, at = [], 0
        for match in _NAMED_VALUE.finditer(code):
            if match.start() > at:
                found.append(MoveArgument("motion", code[at : match.start()]))
            found.append(MoveArgument(_INDEPENDENT.get(match[1], "motion"), match[0]))
            at = match.end()
        return [*found, MoveArgument("motion", code[at:])]

    def _pieces(self, lines: Sequence[tuple[str, str]], known: Known) -> Iterator[Piece]:
        at = 0
        while at < len(lines):
            stop = self._last(lines, at)
            if stop == at:
                piece, _ = self._piece(lines, at, "")
            else:
                texts, ends = zip(*lines[at : stop + 1], strict=True)
                name = self.data_name(texts[0])
                piece = Piece(texts, ends, "\n".join(map(self.code, texts)), name and f"/{name}", bool(name))
            yield piece
            at = stop + 1

    def _last(self, lines: Sequence[tuple[str, str]], at: int) -> int:
        """The last line of what begins at `at`: of a value its end, of a node the same line."""
        value = _VALUE.match(lines[at][0])
        if value is None or value[2] in _NODES:
            return at
        end = f"{value[1]}</{value[2]}>"
        for stop in range(at + 1, len(lines)):
            text = lines[stop][0]
            if text == end:
                follows = _POINT.match(text) and stop + 1 < len(lines) and _FEATURE.match(lines[stop + 1][0])
                return stop + 1 if follows and "/>" in lines[stop + 1][0] else stop
            if text.strip() == "<children>" or (text.startswith("|") and stop > at + 1):
                break  # nodes and lines of script are changed for themselves
        return at
