"""What may be changed independently in a PolyScope program: its nodes, what they share, and each value of a node.

A taught point, an expression or a pin is one thing, however many lines it has.
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterator, Sequence

from olp.languages.merging import Known, MoveArgument, PackedRules, Piece, RecordRule
from olp.languages.vendors.urscript.polyscope_text import is_plain, packed, unpacked

_VALUE = re.compile(r"( *)<([a-z][\w.:-]*)(?: [^>]*)?(?<!/)>$")
_NODES = frozenset({"children", "variables", "suppressedNode", "object"})
_POINT = re.compile(r" *</position>$")
_FEATURE = re.compile(r" *<BaseToFeature ")
_ATTRIBUTE = re.compile(r' ([\w.:-]+)="[^"]*"')
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
        for match in _ATTRIBUTE.finditer(code):
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
