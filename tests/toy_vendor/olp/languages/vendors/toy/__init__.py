"""TOY, a language that exists to be read."""

from __future__ import annotations

import re
from typing import Final

from olp.core.source import Source
from olp.ir.program import Program
from olp.languages.vendor import Vendor, statements

_MARK: Final = re.compile(r"^\s*TOYPROGRAM\b", re.IGNORECASE)


class Toy(Vendor):
    """Lengths mm, angles deg, R = Rz Ry Rx, speeds mm/s and %, times s."""

    name = "toy"
    title = "Acme TOY"
    suffixes = (".toy",)
    reads = statements("While EndWhile For Next Break Label Jump ElseIf Pause Declare Opaque")
    comment_prefix = "#"
    trailing_comment_prefix = " #"
    comment_length = 80
    newline = "\n"

    def sniff(self, source: Source) -> bool:
        return any(_MARK.match(line) for line in source.lines[:50])

    def read(self, source: Source) -> Program:
        from olp.languages.vendors.toy.reader import read_program

        return read_program(source)


VENDOR = Toy()
