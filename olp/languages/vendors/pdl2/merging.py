"""What may be changed independently in a PDL2 program."""

from __future__ import annotations

import re

from olp.languages.merging import MergeRules, MoveArgument

_MOVE = re.compile(
    r"(MOVE(?:FLY)?)((?: +(?:LINEAR|JOINT))?(?: +TO)?)( +(?!CIRC)[\w.$]+(?:\[[^]]*\])?(?: +ADVANCE)?)( +WITH +)?",
    re.IGNORECASE,
)
_SETTING = re.compile(r"(?:, *)?(\$\w+) *=[^,]*")


class Pdl2Merging(MergeRules):
    comments = ("--",)
    has_variables = ignores_case = True
    data = re.compile(r"\s*(\w+(?:\[\d+\])?)\s*:=\s*(?:POS\s*\(|\{)", re.IGNORECASE)
    loose_data = False  # an assignment runs where it stands
    scope = re.compile(r"\s*ROUTINE\s+(\w+)|\s*END\s+\w+()\s*$", re.IGNORECASE)

    branch = re.compile(r"\s*CASE\s*\(([^)]*)\)\s*:", re.IGNORECASE)
    branched = re.compile(r"\s*(?:DEFAULT|ENDSELECT)\b", re.IGNORECASE)
    declares = re.compile(r"()(\w+(?:\s*,\s*\w+)*)(\s*:(?!=)\s*[A-Z].*)", re.IGNORECASE)

    def arguments(self, code: str) -> list[MoveArgument]:
        move = _MOVE.match(code)
        if move is None or (not move[4] and move.end() < len(code)):
            return []
        found = [
            MoveArgument("zone", move[1]),
            MoveArgument("motion", move[2]),
            MoveArgument("place", move[3]),
        ]
        settings = code[move.end() :] if move[4] else ""
        if _SETTING.sub("", settings):
            return []
        found += [MoveArgument("motion", move[4])] if move[4] else []
        return found + [MoveArgument(_name(one[1]), one[0]) for one in _SETTING.finditer(settings)]


def _name(setting: str) -> str:
    return "speed" if setting.upper().endswith(("_SPD", "_OVR")) else setting.casefold()


MERGING = Pdl2Merging()
