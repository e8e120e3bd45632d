"""What may be changed independently in a KRL program and in the list of data beside it."""

from __future__ import annotations

import re

from olp.languages.merging import Cut, MergeRules, RecordRule

_WORDS = "FOR|IF|ELSE|WHILE|UNTIL|WAIT|SWITCH|CASE|RETURN|GOTO|INTERRUPT|TRIGGER|SIGNAL|PTP|LIN|CIRC|EXT|ENUM|STRUC"
_LIST = re.compile(r"^\s*DEFDAT\b", re.IGNORECASE | re.MULTILINE)


class KrlMerging(MergeRules):
    comments = (";",)
    data = re.compile(
        rf"\s*(?:(?:DECL|GLOBAL|CONST|PUBLIC)\s+)*(?!(?:{_WORDS})\b)\w+\s+(\$?\w+(?:\[[\d, ]*\])?)\s*=(?!=)",
        re.IGNORECASE,
    )
    scope = re.compile(r"\s*(?:GLOBAL\s+)?(?:DEFFCT\s+\w+(?:\[\s*\])?|DEF|DEFDAT)\s+([\w$]+)", re.IGNORECASE)
    heads = (
        (re.compile(r"&REL\b", re.IGNORECASE), RecordRule.GREATEST),
        (re.compile(r"&PARAM\s+\w+|&\w+", re.IGNORECASE), RecordRule.ASK),
    )

    def cut(self, text: str) -> Cut:
        rules = _DATA_LIST if _LIST.search(text) else self
        return super(KrlMerging, rules).cut(text)


class KrlListMerging(KrlMerging):
    """A .dat: every line that gives something a value is data."""

    data = re.compile(
        r"\s*(?:(?:DECL|GLOBAL|CONST|PUBLIC)\s+)*(?:\w+\s+)?(\$?\w[\w.]*(?:\[[\d, ]*\])?(?:\.\w+)*)\s*=(?!=)",
        re.IGNORECASE,
    )


_DATA_LIST = KrlListMerging()
MERGING = KrlMerging()
