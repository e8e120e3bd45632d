"""INFORM, the language of Yaskawa (Motoman) jobs: `.JBI` files of the ERC to the YRC1000 generation."""

from __future__ import annotations

from olp.program import Program
from olp.source import Source
from olp.vendors.vendor import Vendor


class Inform(Vendor):
    """Yaskawa INFORM. Speeds mm/s, % and deg/s; lengths mm; angles deg; all converted while reading."""

    name = "inform"
    title = "Yaskawa INFORM"
    suffixes = (".jbi",)
    comment_prefix = "'"
    trailing_comment_prefix = "  //"
    comment_length = 32
    shares_names = False
    blending = "yaskawa"

    def sniff(self, source: Source) -> bool:
        head = source.lines[:50]
        return any(line.startswith(("/JOB", "//NAME ", "//INST")) for line in head)

    def read(self, source: Source) -> Program:
        from olp.vendors.inform.reader import read_program

        return read_program(source)


VENDOR = Inform()
