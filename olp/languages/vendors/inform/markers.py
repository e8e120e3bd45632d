"""Stand-ins for broken lines that open, continue or close a block.

They pair with the rest of the job's blocks, so that one broken IFTHEN is not told again as an ENDIF without IFTHEN.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from olp.ir.expressions import Number, Store, Unknown, Variable
from olp.ir.program import (
    Case,
    Default,
    Else,
    ElseIf,
    EndIf,
    EndSwitch,
    EndWhile,
    For,
    If,
    Next,
    Statement,
    Switch,
    While,
)

_UNKNOWN = Unknown("")
MARKERS: Final[dict[str, Callable[[int], Statement]]] = {
    "IFTHEN": lambda line: If(line, _UNKNOWN),
    "IFTHENEXP": lambda line: If(line, _UNKNOWN),
    "ELSEIF": lambda line: ElseIf(line, _UNKNOWN),
    "ELSEIFEXP": lambda line: ElseIf(line, _UNKNOWN),
    "ELSE": lambda line: Else(line),
    "ENDIF": lambda line: EndIf(line),
    "WHILE": lambda line: While(line, _UNKNOWN),
    "WHILEEXP": lambda line: While(line, _UNKNOWN),
    "ENDWHILE": lambda line: EndWhile(line),
    "FOR": lambda line: For(line, Variable(Store.BYTE, Number(0)), _UNKNOWN, _UNKNOWN),
    "NEXT": lambda line: Next(line, None),
    "SWITCH": lambda line: Switch(line, _UNKNOWN),
    "CASE": lambda line: Case(line, ()),
    "DEFAULT": lambda line: Default(line),
    "ENDSWITCH": lambda line: EndSwitch(line),
}
