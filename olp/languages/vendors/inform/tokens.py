"""INFORM: C00001 and P001, *LABEL, JOB:NAME, B000, UF#(1).

Layout: the controller writes the lines; only blanks at their ends go.
"""

from __future__ import annotations

from olp.languages.tokens import Layout, Pattern, TokenKind, Words
from olp.languages.vendors.inform.statements import instruction_parser

_SIGNALS = "IN|OT|IGH|OGH|IG|OG|SIN|SOUT|RIN|MREG|AI|AO"


class InformLayout(Layout):
    """Indentation is the controller's: a blank and a tab per step."""


class InformTokens(Words):
    layout = InformLayout()
    case_sensitive = True
    # A comment of its own, one behind an instruction (records begin with // too), a text.
    passed_over = r"""^\s*'.*|(?<=\S)\s*//.*|"[^"]*\""""
    patterns = (
        Pattern(TokenKind.POINT, r"^\s*((?:BC|EC|C)\d{1,9})(?==)", defines=True, local=True),
        Pattern(TokenKind.VARIABLE, r"^\s*((?:BP|EX|P)\d{1,9})(?==)", defines=True),
        Pattern(TokenKind.ROUTINE, r"^//NAME (.*\S)", defines=True),
        Pattern(TokenKind.FRAME, r"^///USER (\d+)", key="UF#({})"),
        Pattern(TokenKind.TOOL, r"^///TOOL (\d+)", key="TL#({})"),
        Pattern(TokenKind.LABEL, r"^\s*(\*\S+)(?=\s*$)", defines=True, local=True),
        Pattern(TokenKind.LABEL, r"(?:JUMP|JMP)\s+(\*[^\s*]+)", local=True),
        Pattern(TokenKind.ROUTINE, r"JOB:([^\s()]+)"),
        Pattern(TokenKind.FRAME, r"MFRAME\s+(UF#\(\d+\))", defines=True, key="UF#({})"),
        Pattern(TokenKind.FRAME, r"(UF#\(\d+\))", key="UF#({})"),
        Pattern(TokenKind.TOOL, r"SETTOOL\s+(TL#\(\d+\))", defines=True, key="TL#({})"),
        Pattern(TokenKind.TOOL, r"(TL#\(\d+\))", key="TL#({})"),
        Pattern(TokenKind.SIGNAL, rf"\b((?:{_SIGNALS})#\(\d+\))"),
        Pattern(TokenKind.POINT, r"\b((?:BC|EC|C)\d{3,6})\b", local=True),
        Pattern(TokenKind.VARIABLE, r"\b(L(?:BP|EX|[BIDRSP])\d{1,6})\b", local=True),
        Pattern(TokenKind.VARIABLE, r"\b((?:BP|EX|PX|[BIDRSP])\d{1,6})\b"),
    )

    def vocabulary(self) -> frozenset[str]:
        return super().vocabulary() | instruction_parser().words


TOKENS = InformTokens()
