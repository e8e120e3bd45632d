"""Kawasaki AS: programs (.pg) and saved controllers (.as) of the C, D, E and F series.

`as` is a word of Python: inside this package imports are relative, and from outside `find_vendor("as")` gets it.
"""

from __future__ import annotations

import re
from typing import Final

from olp.core.source import Source
from olp.ir.program import Program
from olp.languages.vendor import Conventions, MoveOptions, Vendor, statements

_MARK: Final = re.compile(
    r"^\s*\.(?:PROGRAM|TRANS|JOINTS|REALS|STRINGS|AUXDATA|SYSDATA|ROBOTDATA\d|NETCONF\d?)\b", re.IGNORECASE
)


_TEXT_FUNCTIONS = (
    "$chr",
    "$date",
    "$decode",
    "$encode",
    "$error",
    "$left",
    "$mid",
    "$right",
    "$space",
    "$time",
)


class As(Vendor):
    """Kawasaki AS. Lengths mm, angles deg, turns O A T = Rz Ry Rz, speeds % or mm/s; all converted while reading."""

    name = "as"
    title = "Kawasaki AS"
    suffixes = (".as", ".pg")
    reads = statements(
        "SetSpeed PulseOutput Process Label Jump ElseIf While EndWhile For Next Switch Case Default EndSwitch Pause "
        "Repeat Until Declare SetAcceleration SetBlend SetTool SetFrame Opaque"
    )
    conventions = Conventions(
        first_element=0,
        sums_of_texts=True,
        clocks_run=True,
        data_set_elsewhere=True,
        name_signs={"#": "joints", "$": "string"},
        result_types=dict.fromkeys(_TEXT_FUNCTIONS, "string"),
        move_options=MoveOptions(manner=frozenset({"hmove"})),
        assumed_codes=frozenset({"P588", "P589"}),
    )
    comment_prefix = ";"
    trailing_comment_prefix = " ;"
    comment_length = 100

    def sniff(self, source: Source) -> bool:
        return any(_MARK.match(line) for line in source.lines[:20_000] if "." in line)

    def read(self, source: Source) -> Program:
        from .reader import read_program

        return read_program(source)


VENDOR = As()
