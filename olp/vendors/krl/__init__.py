"""KRL, the language of KUKA robots: `.src` and `.sub` programs with the `.dat` lists beside them."""

from __future__ import annotations

import re

from olp.program import Program
from olp.source import Source
from olp.vendors.vendor import Vendor

_SIGNS = re.compile(
    r"\s*(?:&ACCESS|&REL\s|&PARAM\s|(?:GLOBAL\s+)?DEF(?:FCT|DAT)?\s+[\w$](?!.*:\s*$)|;FOLD\s)", re.IGNORECASE
)
_LOOKED_AT = 60  # lines


class Krl(Vendor):
    """KUKA KRL. Lengths mm, angles deg, path speeds m/s, joint speeds %; all converted while reading.

    A `.dat` is known by its text, because other makers use that suffix for other things.
    """

    name = "krl"
    title = "KUKA KRL"
    suffixes = (".src", ".sub")
    list_suffixes = (".dat",)
    comment_prefix = ";"
    trailing_comment_prefix = " ;"
    comment_length = 200
    blending = "kuka"

    def sniff(self, source: Source) -> bool:
        return any(_SIGNS.match(line) for line in source.lines[:_LOOKED_AT])

    def read(self, source: Source) -> Program:
        from olp.vendors.krl.reader import read_program

        return read_program(source)


VENDOR = Krl()
