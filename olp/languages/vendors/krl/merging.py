"""What may be changed independently in a KRL program and in the list of data beside it."""

from __future__ import annotations

import re

from olp.languages.merging import Cut, Known, MergeRules, RecordRule

_WORDS = "FOR|IF|ELSE|WHILE|UNTIL|WAIT|SWITCH|CASE|RETURN|GOTO|INTERRUPT|TRIGGER|SIGNAL|PTP|LIN|CIRC|EXT|ENUM|STRUC"
_DECL = re.compile(r"(?:(?<=^GLOBAL )|(?<=^PUBLIC )|^)DECL ", re.IGNORECASE)
_LIST = re.compile(r"^\s*DEFDAT\b", re.IGNORECASE | re.MULTILINE)


class KrlMerging(MergeRules):
    comments = (";",)
    structure = re.compile(r"\s*;\s*(?:FOLD|ENDFOLD)\b", re.IGNORECASE)
    data = re.compile(
        rf"\s*(?:(?:DECL|GLOBAL|CONST|PUBLIC)\s+)*(?!(?:{_WORDS})\b)\w+\s+(\$?\w+(?:\[[\d, ]*\])?)\s*=(?!=)",
        re.IGNORECASE,
    )
    scope = re.compile(r"\s*(?:GLOBAL\s+)?(?:DEFFCT\s+\w+(?:\[\s*\])?|DEF|DEFDAT)\s+([\w$]+)", re.IGNORECASE)
    heads = (
        (re.compile(r"&REL\b", re.IGNORECASE), RecordRule.GREATEST),
        (re.compile(r"&PARAM\s+\w+|&\w+", re.IGNORECASE), RecordRule.SAVED_LAST),
    )

    def code(self, line: str) -> str:
        """DECL says nothing."""
        return _DECL.sub("", super().code(line))

    def cut(self, text: str, known: Known) -> Cut:
        rules = _DATA_LIST if _LIST.search(text) else self
        return super(KrlMerging, rules).cut(text, known)


class KrlListMerging(KrlMerging):
    """A .dat: every line that gives something a value or declares one name is data."""

    data = re.compile(
        r"\s*(?:(?:DECL|GLOBAL|CONST|PUBLIC)\s+)*(?:"
        r"(?:\w+\s+)?(\$?\w[\w.]*(?:\[[\d, ]*\])?(?:\.\w+)*)\s*=(?!=)"
        r"|(?!(?:DEFDAT|ENDDAT|STRUC|ENUM|EXT|EXTFCT|IMPORT)\b)\w+\s+(\w+(?:\[[\d, ]*\])?)\s*(?:;.*)?$)",
        re.IGNORECASE,
    )


_DATA_LIST = KrlListMerging()
MERGING = KrlMerging()
