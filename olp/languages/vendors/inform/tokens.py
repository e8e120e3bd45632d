"""INFORM: C00001 and P001, *LABEL, JOB:NAME, B000, UF#(1)."""

from __future__ import annotations

from olp.languages.tokens import Kind, Pattern, Words
from olp.languages.vendors.inform.grammar import instruction_parser

_SIGNALS = "IN|OT|IGH|OGH|IG|OG|SIN|SOUT|RIN|MREG|AI|AO"


class InformTokens(Words):
    case_sensitive = True
    # A comment of its own, one behind an instruction (records begin with // too), a text.
    passed_over = r"""^\s*'.*|(?<=\S)\s*//.*|"[^"]*\""""
    patterns = (
        Pattern(Kind.POINT, r"^\s*((?:BC|EC|C)\d{1,9})(?==)", defines=True, local=True),
        Pattern(Kind.VARIABLE, r"^\s*((?:BP|EX|P)\d{1,9})(?==)", defines=True),
        Pattern(Kind.ROUTINE, r"^//NAME (.*\S)", defines=True),
        Pattern(Kind.FRAME, r"^///USER (\d+)", key="UF#({})"),
        Pattern(Kind.TOOL, r"^///TOOL (\d+)", key="TL#({})"),
        Pattern(Kind.LABEL, r"^\s*(\*\S+)(?=\s*$)", defines=True, local=True),
        Pattern(Kind.LABEL, r"(?:JUMP|JMP)\s+(\*[^\s*]+)", local=True),
        Pattern(Kind.ROUTINE, r"JOB:([^\s()]+)"),
        Pattern(Kind.FRAME, r"MFRAME\s+(UF#\(\d+\))", defines=True, key="UF#({})"),
        Pattern(Kind.FRAME, r"(UF#\(\d+\))", key="UF#({})"),
        Pattern(Kind.TOOL, r"SETTOOL\s+(TL#\(\d+\))", defines=True, key="TL#({})"),
        Pattern(Kind.TOOL, r"(TL#\(\d+\))", key="TL#({})"),
        Pattern(Kind.SIGNAL, rf"\b((?:{_SIGNALS})#\(\d+\))"),
        Pattern(Kind.POINT, r"\b((?:BC|EC|C)\d{3,6})\b", local=True),
        Pattern(Kind.VARIABLE, r"\b(L(?:BP|EX|[BIDRSP])\d{1,6})\b", local=True),
        Pattern(Kind.VARIABLE, r"\b((?:BP|EX|PX|[BIDRSP])\d{1,6})\b"),
    )

    def vocabulary(self) -> frozenset[str]:
        return super().vocabulary() | instruction_parser().words


TOKENS = InformTokens()
