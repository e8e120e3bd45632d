"""TP: P[1], PR[2:pick], R[3], LBL[4], CALL NAME, UFRAME[1]."""

from __future__ import annotations

from olp.languages.tokens import Pattern, TokenKind, Words

_BRACKET = r"\[\d+[^\]]*\]"


class TpTokens(Words):
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
