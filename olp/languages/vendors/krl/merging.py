"""What may be changed independently in a KRL program and in the list of data beside it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from olp.languages.merging import Cut, Known, MergeRules, MoveArgument, Piece, RecordRule

_WORDS = "FOR|IF|ELSE|WHILE|UNTIL|WAIT|SWITCH|CASE|RETURN|GOTO|INTERRUPT|TRIGGER|SIGNAL|PTP|LIN|CIRC|EXT|ENUM|STRUC"
_TYPED = r"(?:GLOBAL\s+)?(?:DECL\s+(?:GLOBAL\s+)?\w+|INT|REAL|BOOL|CHAR|POS|E6POS|FRAME|AXIS|E6AXIS)\s+"
_DECL = re.compile(r"(?:(?<=^GLOBAL )|(?<=^PUBLIC )|^)DECL ", re.IGNORECASE)
_LIST = re.compile(r"^\s*DEFDAT\b", re.IGNORECASE | re.MULTILINE)
# A part of a list has no head; no program is without one of these.
_RUNS = re.compile(
    r"^\s*(?:DEF|DEFFCT|END|IF|FOR|SWITCH|BAS|[SP]*LIN|[SP]*CIRC|S?PTP)\b", re.IGNORECASE | re.MULTILINE
)

_MOVE = re.compile(r"(S?(?:PTP|LIN))( +[^ ;,]+)((?: +C_\w+)*)", re.IGNORECASE)
_FORM = re.compile(
    r"(\s*;\s*FOLD S?(?:PTP|LIN) )(\S+)((?: +CONT)?)( +Vel=[\d.]+ *(?:%|m/s))( +\w+)(.*?)(;%\{PE\}.*?%P 1:\w+)"
    r"(, 2:[^,]*)(, 3:[^,]*)(, 5:[^,]*)(, 7:.*)",
    re.IGNORECASE,
)
_OF_FORM = (
    "motion", "place", "zone", "speed", "motion", "place", "motion", "place", "zone", "speed", "motion",
)  # fmt: skip
_OF_MOVE = ("motion", "place", "zone")
_FIELDS = re.compile(r"((?:DECL )?[PL]DAT \w+ *= *\{)( *\w+ [^,{}]+(?:, *\w+ [^,{}]+)*)(\})", re.IGNORECASE)
_FIELD = re.compile(r",? *(\w+) [^,{}]+")
_OF_FIELD = {"vel": "speed", "acc": "acceleration", "apo_dist": "zone", "apo_mode": "zone", "apo_fac": "zone"}


class KrlMerging(MergeRules):
    comments = (";",)
    has_variables = ignores_case = True
    reals = re.compile(r"\b(?:[xyzabc]|[ae]\d) -?\d+(?=[,}])|\breal [\w.]+(?:\[[\d,]*\])?=-?\d+$")
    branch = re.compile(r"\s*CASE\s+([^;]*)", re.IGNORECASE)
    branched = re.compile(r"\s*(?:DEFAULT|ENDSWITCH)\b", re.IGNORECASE)
    declares = re.compile(
        rf"({_TYPED})"
        r"(\w+(?:\[[\d,\s]*\])?(?:\s*,\s*\w+(?:\[[\d,\s]*\])?)*)(\s*)",
        re.IGNORECASE,
    )
    structure = re.compile(r"\s*;\s*(?:FOLD|ENDFOLD)\b", re.IGNORECASE)
    data = re.compile(
        rf"\s*(?:(?:DECL|GLOBAL|CONST|PUBLIC)\s+)*(?!(?:{_WORDS})\b)\w+\s+(\$?\w+(?:\[[\d, ]*\])?)\s*=(?!=)"
        rf"|\s*{_TYPED}(\w+)(?:\[[\d,\s]*\])?(?:\s*,\s*\w+(?:\[[\d,\s]*\])?)*\s*(?:;.*)?$",
        re.IGNORECASE,
    )
    scope = re.compile(
        r"\s*(?:GLOBAL\s+)?(?:DEFFCT\s+\w+(?:\[\s*\])?|DEF|DEFDAT)\s+([\w$]+)|\s*END(?:FCT)?()\s*(?:;.*)?$",
        re.IGNORECASE,
    )
    heads = (
        (re.compile(r"&REL\b", re.IGNORECASE), RecordRule.GREATEST),
        (re.compile(r"&PARAM\s+\w+|&\w+", re.IGNORECASE), RecordRule.SAVED_LAST),
    )

    def code(self, line: str) -> str:
        """DECL says nothing."""
        return _DECL.sub("", super().code(line))

    def arguments(self, code: str) -> list[MoveArgument]:
        """Of a move, of the remark over an inline form's, and of the settings that forms keep in data."""
        for pattern, names in ((_MOVE, _OF_MOVE), (_FORM, _OF_FORM)):
            move = pattern.fullmatch(code)
            if move is not None:
                return list(map(MoveArgument, names, move.groups()))
        data = _FIELDS.fullmatch(code)
        if data is None:
            return []
        fields = (
            MoveArgument(_OF_FIELD.get(one[1].casefold(), one[1].casefold()), one[0])
            for one in _FIELD.finditer(data[2])
        )
        return [MoveArgument("motion", data[1]), *fields, MoveArgument("motion", data[3])]

    def cut(self, text: str, known: Known) -> Cut:
        rules = self if not _LIST.search(text) and _RUNS.search(text) else _DATA_LIST
        return MergeRules.cut(rules, text, known)


class KrlListMerging(KrlMerging):
    """A .dat: every line that gives something a value or declares one name is data."""

    data = re.compile(
        r"\s*(?:(?:DECL|GLOBAL|CONST|PUBLIC)\s+)*(?:"
        r"(?:\w+\s+)?(\$?\w[\w.]*(?:\[[\d, ]*\])?(?:\.\w+)*)\s*=(?!=)"
        r"|(?!(?:DEFDAT|ENDDAT|STRUC|ENUM|EXT|EXTFCT|IMPORT)\b)\w+\s+(\w+)(?:\[[\d, ]*\])?\s*(?:;.*)?$)",
        re.IGNORECASE,
    )

    def _pieces(self, lines: Sequence[tuple[str, str]], known: Known) -> Iterator[Piece]:
        """What is declared in one row and has its value in another one is two things."""
        pieces = list(super()._pieces(lines, known))
        valued = {piece.name for piece in pieces if piece.name and "=" in piece.code}
        for piece in pieces:
            declares = piece.name in valued and "=" not in piece.code
            yield replace(piece, name=f"{piece.name} declared") if declares else piece


_DATA_LIST = KrlListMerging()
MERGING = KrlMerging()
