"""FANUC TP, the teach pendant's language: `.ls` listings of the R-J2 to the R-30iB Plus generation."""

from __future__ import annotations

from olp.program import Program
from olp.source import Source
from olp.vendors.vendor import Vendor


class Tp(Vendor):
    """FANUC TP. Speeds %, mm/sec, cm/min, inch/min and deg/sec; lengths mm; angles deg; all converted while reading."""

    name = "tp"
    title = "FANUC TP"
    suffixes = (".ls",)
    comment_prefix = "!"
    trailing_comment_prefix = ""
    comment_length = 32
    blending = "fanuc"

    def sniff(self, source: Source) -> bool:
        return any(line.lstrip().upper().startswith("/PROG") for line in source.lines[:50])

    def read(self, source: Source) -> Program:
        from olp.vendors.tp.reader import read_program

        return read_program(source)


VENDOR = Tp()
