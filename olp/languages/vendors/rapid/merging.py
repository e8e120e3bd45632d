"""What may be changed independently in a RAPID module."""

from __future__ import annotations

import re

from olp.languages.merging import MergeRules, MoveArgument, split_arguments

_MOVE = re.compile(r"Move(?:J|L|AbsJ|(C)) ", re.IGNORECASE)
_ARGUMENTS = ("place", "speed", "zone", "place")


class RapidMerging(MergeRules):
    comments = ("!",)
    has_variables = ignores_case = True
    reals = re.compile(r"(?<![\w.$])\d+(?![\w.])")
    data = re.compile(
        r"\s*(?:(?:LOCAL|TASK)\s+)?(?:PERS|CONST|VAR)\s+\w+\s+(\w+)\s*(?:\{[^}]*\})?\s*(?::=|;)",
        re.IGNORECASE,
    )
    data_ends = ";"
    scope = re.compile(
        r"\s*(?:LOCAL\s+)?(?:PROC|TRAP|FUNC\s+\w+)\s+(\w+)|\s*END(?:PROC|FUNC|TRAP)()\b", re.IGNORECASE
    )

    branch = re.compile(r"\s*CASE\s+([^:!]*):", re.IGNORECASE)
    branched = re.compile(r"\s*(?:DEFAULT|ENDTEST)\b", re.IGNORECASE)

    def arguments(self, code: str) -> list[MoveArgument]:
        move = _MOVE.match(code)
        if move is None:
            return []
        names = ("place", *_ARGUMENTS) if move[1] else _ARGUMENTS
        found = split_arguments(code, names, {})
        return found if len(found) == len(names) + 2 and not found[1].text.lstrip().startswith("\\") else []


MERGING = RapidMerging()
