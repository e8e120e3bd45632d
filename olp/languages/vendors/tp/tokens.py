"""TP: P[1], PR[2:pick], R[3], LBL[4], CALL NAME, UFRAME[1].

Layout: lines numbered one after the other, in four columns, as the controller writes them.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from olp.languages.tokens import Layout, Pattern, TokenKind, Words

_BRACKET = r"\[\d+[^\]]*\]"


_NUMBERED = re.compile(r"\s*\d+:(.*)")
_MAIN, _ENDS = re.compile(r"\s*/MN\b"), re.compile(r"\s*/(?:POS|END)\b")


class TpLayout(Layout):
    def lines(self, lines: Sequence[str], indent: str) -> list[str]:
        found: list[str] = []
        number = 0
        inside = False
        for line in lines:
            inside = _MAIN.match(line) is not None or (inside and _ENDS.match(line) is None)
            match = _NUMBERED.fullmatch(line) if inside else None
            if match is not None:
                number += 1
                line = f"{number:4d}:{match[1].rstrip()}"
            found.append(line)
        return found


class TpTokens(Words):
    layout = TpLayout()
    passed_over = r"""^\s*\d+:\s*(?://|!|--eg:).*|'[^']*'"""
    patterns = (
        Pattern(TokenKind.POINT, rf"^(P{_BRACKET})(?=\s*\{{)", defines=True, local=True),
        Pattern(TokenKind.ROUTINE, r"^/PROG\s+([\w-]+)", defines=True),
        Pattern(TokenKind.ROUTINE, r"\b(?:CALL|RUN)\s+([A-Z_][\w-]*)"),
        Pattern(TokenKind.LABEL, rf"^\s*\d+:\s*(LBL{_BRACKET})(?=\s*;)", defines=True, local=True),
        Pattern(TokenKind.LABEL, rf"\b(LBL{_BRACKET})", local=True),
        Pattern(TokenKind.FRAME, rf"\b(UFRAME{_BRACKET})(?=\s*=)", defines=True, key="UFRAME[{}]"),
        Pattern(TokenKind.TOOL, rf"\b(UTOOL{_BRACKET})(?=\s*=)", defines=True, key="UTOOL[{}]"),
        Pattern(TokenKind.FRAME, rf"\b(UFRAME{_BRACKET})", key="UFRAME[{}]"),
        Pattern(TokenKind.TOOL, rf"\b(UTOOL{_BRACKET})", key="UTOOL[{}]"),
        Pattern(TokenKind.FRAME, r"\bUFRAME_NUM\s*=\s*(\d+)", key="UFRAME[{}]"),
        Pattern(TokenKind.TOOL, r"\bUTOOL_NUM\s*=\s*(\d+)", key="UTOOL[{}]"),
        Pattern(TokenKind.FRAME, r"\bUF\s*:\s*(\d+)", key="UFRAME[{}]"),
        Pattern(TokenKind.TOOL, r"\bUT\s*:\s*(\d+)", key="UTOOL[{}]"),
        Pattern(TokenKind.POINT, rf"\b(P{_BRACKET})", local=True),
        Pattern(TokenKind.VARIABLE, rf"\b((?:PR|SR|AR|R){_BRACKET})"),
        Pattern(TokenKind.SIGNAL, rf"\b((?:DI|DO|RI|RO|GI|GO|AI|AO|UI|UO|SI|SO|WI|WO|F){_BRACKET})"),
    )


TOKENS = TpTokens()
