"""FANUC TP, the teach pendant's language: `.ls` listings of the R-J2 to the R-30iB Plus generation."""

from __future__ import annotations

import re
from typing import Final

from olp.program import Program
from olp.source import Source
from olp.vendors.vendor import Vendor

_COMMENT: Final = re.compile(rb"\s*\d*\s*:\s*!(.*?)\s*;?\s*", re.DOTALL)


class Tp(Vendor):
    """FANUC TP. Speeds %, mm/sec, cm/min, inch/min and deg/sec; lengths mm; angles deg; all converted while reading."""

    name = "tp"
    title = "FANUC TP"
    suffixes = (".ls",)
    # A line without a number: controllers count anew when they load a listing.
    comment_prefix = " : !"
    comment_suffix = " ;"
    trailing_comment_prefix = ""
    comment_length = 32
    blending = "fanuc"

    def comment_of(self, line: bytes) -> bytes | None:
        """Also of lines that a controller has numbered."""
        match = _COMMENT.fullmatch(line)
        return match[1] if match else None

    def sniff(self, source: Source) -> bool:
        return any(line.lstrip().upper().startswith("/PROG") for line in source.lines[:50])

    def read(self, source: Source) -> Program:
        from olp.vendors.tp.reader import read_program

        return read_program(source)


VENDOR = Tp()
