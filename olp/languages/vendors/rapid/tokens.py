"""RAPID: names that are declared, in the routine, the module or another one.

Layout: modules, routines and blocks indented.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from olp.languages.tokens import BlockLayout, Pattern, TokenKind, Words, listed
from olp.languages.vendors.rapid.instructions import RULES
from olp.languages.vendors.rapid.moves import LAYOUTS
from olp.languages.vendors.rapid.predefined_data import FUNCTIONS, RECORDS, SPEEDS, TYPES, ZONES

_KINDS = {
    **dict.fromkeys(("ROBTARGET", "JOINTTARGET", "POSE", "POS"), TokenKind.POINT),
    "WOBJDATA": TokenKind.FRAME,
    "TOOLDATA": TokenKind.TOOL,
    **dict.fromkeys(
        ("SIGNALDI", "SIGNALDO", "SIGNALGI", "SIGNALGO", "SIGNALAI", "SIGNALAO"), TokenKind.SIGNAL
    ),
}
_TYPES = frozenset(name.upper() for name in (*TYPES, *RECORDS))
_DATA = re.compile(r"\s*(?:(?:LOCAL|TASK)\s+)?(?:CONST|PERS|VAR)\s+(\w+)\s+(\w+)", re.IGNORECASE)
_FOR = re.compile(r"\s*FOR\s+(\w+)\s+FROM\b", re.IGNORECASE)
_HEAD = re.compile(r"\s*(?:LOCAL\s+)?(?:PROC|FUNC\s+\w+)\s+\w+\s*\(", re.IGNORECASE)
_PARAMETER = re.compile(r"[(,|]\s*\\?\s*(?:(?:INOUT|VAR|PERS)\s+)?(\w+)\s+(\w+)", re.IGNORECASE)


_CODE = re.compile(r'(?:[^!"]|"(?:[^"]|"")*"?)*')


class RapidLayout(BlockLayout):
    opens = re.compile(
        r"(?:MODULE\b|(?:LOCAL\s+)?(?:PROC|FUNC|TRAP|RECORD)\b|IF\b.*\bTHEN\s*(?:!.*)?$|FOR\b|WHILE\b|TEST\b)",
        re.IGNORECASE,
    )
    closes = re.compile(r"END(?:MODULE|PROC|FUNC|TRAP|RECORD|IF|FOR|WHILE|TEST)\b", re.IGNORECASE)
    between = re.compile(r"(?:ELSEIF|ELSE|CASE|DEFAULT|ERROR|UNDO|BACKWARD)\b", re.IGNORECASE)
    # An instruction without its semicolon goes on, unless the line is the head or the end of a block.
    open_end = re.compile(
        r"^(?!(?:MODULE|(?:LOCAL\s+)?(?:PROC|FUNC|TRAP|RECORD)|END\w+|ELSE|ERROR|UNDO|BACKWARD)\b)"
        r"(?!.*(?:;|:|\b(?:THEN|DO|FROM|TEST.*))\s*$).*\S\s*$",
        re.IGNORECASE,
    )
    kept = re.compile(r"%%%|VERSION:|LANGUAGE:")

    def bare(self, text: str) -> str:
        match = _CODE.match(text)
        return match[0].rstrip() if match else text


class RapidTokens(Words):
    layout = RapidLayout()
    passed_over = r"""!.*|"(?:[^"]|"")*\""""
    identifier = r"(?<![\w\\.])([A-Z_]\w*)"
    keywords = _TYPES | listed(
        "MODULE ENDMODULE PROC ENDPROC FUNC ENDFUNC TRAP ENDTRAP RECORD ENDRECORD ALIAS LOCAL TASK CONST PERS VAR IF "
        "THEN ELSEIF ELSE ENDIF FOR FROM TO STEP DO ENDFOR WHILE ENDWHILE TEST CASE DEFAULT ENDTEST GOTO RETURN EXIT "
        "RAISE RETRY TRYNEXT CONNECT WITH ERROR UNDO BACKWARD AND OR XOR NOT DIV MOD TRUE FALSE INOUT"
    )
    patterns = (
        Pattern(TokenKind.ROUTINE, r"^\s*(?:LOCAL\s+)?(?:PROC|TRAP|FUNC\s+\w+)\s+([A-Z_]\w*)", defines=True),
        Pattern(
            TokenKind.LABEL,
            r"^\s*(?!DEFAULT\b|ERROR\b)([A-Z_]\w*)(?=\s*:\s*(?:!|$))",
            defines=True,
            local=True,
        ),
        Pattern(TokenKind.LABEL, r"\bGOTO\s+([A-Z_]\w*)", local=True),
    )

    def declared(self, line: str) -> Iterator[tuple[int, TokenKind]]:
        data = _DATA.match(line)
        if data is not None:
            yield data.start(2), _KINDS.get(data[1].upper(), TokenKind.VARIABLE)
            return
        counted = _FOR.match(line)
        if counted is not None:
            yield counted.start(1), TokenKind.VARIABLE
        head = _HEAD.match(line)
        if head is not None:
            for parameter in _PARAMETER.finditer(line, head.end() - 1):
                yield parameter.start(2), _KINDS.get(parameter[1].upper(), TokenKind.VARIABLE)

    def vocabulary(self) -> frozenset[str]:
        names = {_SPELT.get(name, name) for name in (*RULES, *LAYOUTS, *FUNCTIONS)}
        return super().vocabulary() | names | frozenset((*TYPES, *RECORDS, *SPEEDS, *ZONES))


# How the manual spells instructions and functions; case does not count, but people read it.
_SPELT = {
    name.lower(): name
    for name in listed(
        "MoveJ MoveL MoveC MoveAbsJ MoveExtJ TriggJ TriggL TriggC SearchL SearchC ArcL ArcC ArcLStart ArcLEnd "
        "ArcCStart ArcCEnd SetDO SetGO SetAO Set Reset InvertDO PulseDO WaitTime WaitDI WaitDO WaitGI WaitGO "
        "WaitAI WaitAO WaitUntil Incr Decr Add Clear TPWrite Stop Break AccSet VelSet PDispSet PDispOn "
        "PDispOff Abs Sqrt Sin Cos Tan ASin ACos ATan ATan2 Exp Pow Round Trunc Max Min StrLen StrPart "
        "PoseMult PoseInv Offs"
    )
}


TOKENS = RapidTokens()
