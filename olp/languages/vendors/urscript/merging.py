"""What may be changed independently in a URScript program.

PolyScope writes a program anew as a whole: it numbers the nodes of its tree (`$ 12 "MoveL"`) and gives some names
another tail of hexadecimal digits. Neither is a change that anybody made.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from olp.languages.merging import Known, MergeRules, MoveArgument, PackedRules, Piece, split_arguments

_NODE = re.compile(r"(\s*\$\s*)\d+(?=\s)")
_TAIL = re.compile(r"(?<![^\W_])[0-9a-f]{8}_[0-9a-f]{4}_[0-9a-f]{4}_[0-9a-f]{4}_[0-9a-f]{12}(?![^\W_])")
_INSIDE = re.compile(r"_[0-9a-f]{4}_[0-9a-f]{4}_")  # of a tail: quick, for most programs have none
_NAME = re.compile(rf"(\w+?_){_TAIL.pattern}")
_OPENS = re.compile(r"\s*(?:(?:def|thread|sec)\s+(\w+)|(?:if|while)\b)")
_ENDS = re.compile(r"\s*end\b")
_BLOCK = re.compile(r"\s*(?:def|thread|sec|if|while|end)\b")
_MOVE = re.compile(r"(move[jlpc])\(")
_PLACES = {
    "movej": ("place", "acceleration", "speed", "speed", "zone"),
    "movel": ("place", "acceleration", "speed", "speed", "zone"),
    "movep": ("place", "acceleration", "speed", "zone"),
    "movec": ("place", "place", "acceleration", "speed", "zone", "place"),
}
_WORDS = {"a": "acceleration", "v": "speed", "t": "speed", "r": "zone", "mode": "place"}


class UrScriptMerging(MergeRules):
    comments = ("#",)
    has_variables = True
    data = re.compile(r"\s*(?:global\s+|local\s+)?(\w+)\s*=\s*p?\[")
    loose_data = False  # an assignment runs where it stands

    def packing(self, data: bytes) -> PackedRules | None:
        """The rules for PolyScope's own files, which are packed; None for scripts."""
        if not data.startswith((b"\x1f\x8b", b"<URProgram")):
            return None
        from olp.languages.vendors.urscript.polyscope_text import PolyscopeMerging

        return PolyscopeMerging(data)

    def renamed(self, base: str, ours: str, theirs: str) -> tuple[str, str, str]:
        """One tail for each name that has one in every version: that of the side that has another one."""
        tails = [_tails(text) for text in (base, ours, theirs)]
        texts = [base, ours, theirs]
        for head in tails[0].keys() & tails[1].keys() & tails[2].keys():
            b, o, t = (of[head] for of in tails)
            kept = t if o == b else o if t == b else min(o, t)
            for at, one in enumerate((b, o, t)):
                texts[at] = texts[at].replace(head + one, head + kept)
        return texts[0], texts[1], texts[2]

    def code(self, line: str) -> str:
        code = super().code(line)
        return _NODE.sub(r"\1", code) if "$" in code else code

    def arguments(self, code: str) -> list[MoveArgument]:
        move = _MOVE.match(code)
        return [] if move is None else split_arguments(code, _PLACES[move[1]], _WORDS)

    def routines(self, lines: Sequence[str]) -> list[str]:
        """The routines; blocks of all kinds end with the same word."""
        found: list[str] = []
        depth = 0
        for line in lines:
            opened = _OPENS.match(line)
            if not depth and (opened is None or not opened[1]) and not self.is_silent(line):
                return []
            if opened is not None:
                found += [opened[1]] if not depth else []
                depth += 1
            elif _ENDS.match(line):
                depth -= 1
        return [] if depth else found

    def _pieces(self, lines: Sequence[tuple[str, str]], known: Known) -> Iterator[Piece]:
        """Data by the routine that holds them; routines can be nested."""
        within: list[str] = []
        scope = ""
        for line, piece in zip(
            lines, super()._pieces(lines, known), strict=True
        ):  # no piece is longer than a line
            if _BLOCK.match(line[0]):
                words = self.split(line[0])[1]
                opened = _OPENS.match(words)
                if opened is not None:
                    within.append(opened[1] or "")
                elif _ENDS.match(words) and within:
                    within.pop()
                scope = next((one for one in reversed(within) if one), "")
            if piece.name:
                key = (*line, f"{scope}{piece.name}")
                there = known.get(key)
                if there is None:
                    there = known[key] = replace(piece, name=key[2])
                piece = there
            yield piece


def _tails(text: str) -> dict[str, str]:
    """The hexadecimal tail of each name that appears with one tail only."""
    found: dict[str, set[str]] = {}
    if _INSIDE.search(text) is None:
        return {}
    for match in _NAME.finditer(text):
        found.setdefault(match[1], set()).add(match[0].removeprefix(match[1]))
    return {head: next(iter(some)) for head, some in found.items() if len(some) == 1}


MERGING = UrScriptMerging()
