"""URScript: a name comes into being where it is first assigned.

Layout: everything between a head and its `end` indented.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from olp.languages.tokens import BlockLayout, Pattern, TokenKind, Words, listed
from olp.languages.vendors.urscript.builtins import KNOWN

_ASSIGNED = re.compile(r"\s*(?:(?:global|local)\s+)?([A-Za-z_]\w*)\s*=(?!=)\s*(p?\[)?")
_HEAD = re.compile(r"\s*(?:def|thread|sec)\s+\w+\s*\(")
_PARAMETER = re.compile(r"[(,]\s*([A-Za-z_]\w*)")


class UrscriptLayout(BlockLayout):
    opens = re.compile(r"(?:def|thread|sec|if|while)\b.*:\s*(?:#.*)?$")
    closes = re.compile(r"end\b")
    between = re.compile(r"(?:elif|else)\b")
    open_end = re.compile(r"[-+*/%=<>,(\[]\s*$")
    kept = re.compile(r"\$|\{\{|\{%")

    def bare(self, text: str) -> str:
        return text.partition("#")[0].rstrip() if '"' not in text else text


class UrscriptTokens(Words):
    layout = UrscriptLayout()
    case_sensitive = True
    one_scope = True
    first_counts = True
    # Comments, marks of PolyScope, texts, and the names of arguments.
    passed_over = r"""#.*|^\s*\$.*|"[^"]*\"|(?<=[(,])\s*[A-Za-z_]\w*\s*=(?!=)"""
    identifier = r"(?<![\w.])([A-Za-z_]\w*)"
    keywords = listed(
        "def thread sec end if elif else while return break continue join kill run and or xor not True False global "
        "local p"
    )
    patterns = (Pattern(TokenKind.ROUTINE, r"^\s*(?:def|thread|sec)\s+([A-Za-z_]\w*)", defines=True),)

    def declared(self, line: str) -> Iterator[tuple[int, TokenKind]]:
        assigned = _ASSIGNED.match(line)
        if assigned is not None:
            yield assigned.start(1), TokenKind.POINT if assigned[2] else TokenKind.VARIABLE
        head = _HEAD.match(line)
        if head is not None:
            for parameter in _PARAMETER.finditer(line, head.end() - 1):
                yield parameter.start(1), TokenKind.VARIABLE

    def vocabulary(self) -> frozenset[str]:
        return super().vocabulary() | KNOWN


TOKENS = UrscriptTokens()
