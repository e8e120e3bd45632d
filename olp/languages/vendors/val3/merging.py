"""What may be changed independently in a VAL3 program, and in the file of its data."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from olp.languages.merging import Known, MergeRules, MoveArgument, Piece, split_arguments

_DATA = re.compile(r'\s*<data\b[^>]*\bname="([^"]*)"', re.IGNORECASE)
_VALUE = re.compile(r'\s*<value\b[^>]*\bkey="([^"]*)"', re.IGNORECASE)
_MOVE = re.compile(r"move(?:j|l|(c))\s*\(")
_DESCRIPTOR = re.compile(r"<value\b(?=.*\bvel=)(?=.*\bblend=)", re.IGNORECASE)
_ATTRIBUTE = re.compile(r'\s+(\w+)="[^"]*"')
_ATTRIBUTES = {
    "accel": "acceleration", "decel": "deceleration", "vel": "speed", "tvel": "speed", "rvel": "speed", "tmax": "speed",
    "rmax": "speed", "blend": "zone", "leave": "zone", "reach": "zone",
}  # fmt: skip
_END = re.compile(r"\s*</data>", re.IGNORECASE)


class Val3Merging(MergeRules):
    comments = ("//",)
    has_variables = True

    branch = re.compile(r"\s*case\s+([^/]*)")
    branched = re.compile(r"\s*(?:default|endSwitch)\b")

    def _pieces(self, lines: Sequence[tuple[str, str]], known: Known) -> Iterator[Piece]:
        """Each datum by its name, each value of an array by its place in it."""
        inside = ""
        for number, piece in enumerate(super()._pieces(lines, known)):
            text, end = lines[number]
            opened, value = _DATA.match(text), _VALUE.match(text) if inside else None
            name = opened[1] if opened else f"{inside}[{value[1]}]" if value else ""
            if opened is not None:
                inside = opened[1]
            elif inside and _END.match(text):
                name, inside = f"{inside}[", ""
            yield self._named_row((text, end, name), known) if name else piece

    def _named_row(self, key: tuple[str, str, str], known: Known) -> Piece:
        found = known.get(key)
        if found is None:
            text, end, name = key
            found = known[key] = Piece((text,), (end,), lambda line: " ".join(line.split()), name, True)
        return found

    def arguments(self, code: str) -> list[MoveArgument]:
        move = _MOVE.match(code)
        if move is not None:
            return split_arguments(code, (*(("place",) if move[1] else ()), "place", "place", "speed"), {})
        if _DESCRIPTOR.match(code) is None:
            return []
        found, at = [], 0
        for match in _ATTRIBUTE.finditer(code):
            if match.start() > at:
                found.append(MoveArgument("motion", code[at : match.start()]))
            found.append(MoveArgument(_ATTRIBUTES.get(match[1].casefold(), "motion"), match[0]))
            at = match.end()
        return [*found, MoveArgument("motion", code[at:])]

    def _comment(self, line: str) -> int:
        return len(line) if line.lstrip().startswith("<") else super()._comment(line)


MERGING = Val3Merging()
