"""What may be changed independently in a RAPID module."""

from __future__ import annotations

import re

from olp.languages.merging import MergeRules


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


MERGING = RapidMerging()
