"""Comau PDL2, the language of the C3G, C4G and C5G controllers."""

from __future__ import annotations

import re
from typing import Final

from olp.core.source import Source
from olp.ir.program import Program
from olp.languages.vendor import Conventions, MoveOptions, Vendor, statements
from olp.languages.vendors.pdl2.manners import MANNERS

_MARK: Final = re.compile(
    r"^\s*PROGRAM\s+[A-Z_]\w*\s*(?:&|,|--|$|EZ\b|HOLD|NOHOLD|PROG_ARM|PRIORITY)", re.IGNORECASE
)
_BODY: Final = re.compile(r"^\s*BEGIN\b", re.IGNORECASE)  # other languages have a PROGRAM, too


class Pdl2(Vendor):
    """PDL2. Lengths mm, angles deg, turns ZYZ, $LIN_SPD m/s, times ms; all converted while reading."""

    name = "pdl2"
    title = "Comau PDL2"
    suffixes = (".pdl",)
    reads = statements(
        "SetSpeed PulseOutput Label Jump ElseIf While EndWhile For Next Switch Case Default EndSwitch "
        "Pause StartTask Repeat Until Break Declare SetAcceleration SetBlend SetTool SetFrame "
        "SetOverride Opaque"
    )
    conventions = Conventions(
        own_sign="$",
        clocks_run=True,
        data_set_elsewhere=True,
        sums_of_texts=True,
        manner_settings=MANNERS,
        move_options=MoveOptions(manner=frozenset(MANNERS)),
    )
    comment_prefix = "--"
    trailing_comment_prefix = " --"
    comment_length = 200

    def sniff(self, source: Source) -> bool:
        return any(map(_MARK.match, source.lines[:200])) and any(map(_BODY.match, source.lines))

    def read(self, source: Source) -> Program:
        from olp.languages.vendors.pdl2.reader import read_program

        return read_program(source)


VENDOR = Pdl2()
