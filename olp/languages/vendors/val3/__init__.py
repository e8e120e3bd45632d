"""Stäubli VAL3: programs (.pgx), data (.dtx) and projects (.pjx) of the CS8 and CS9 controllers."""

from __future__ import annotations

import re
from typing import Final

from olp.core.source import Source
from olp.ir.program import Program
from olp.languages.vendor import Conventions, Vendor, statements
from olp.languages.vendors.val3.known_functions import FILLING, MEMBER_TYPES, REPLACEABLE, RESULT_TYPES

_MARK: Final = re.compile(r"<(?:Programs|programList|Database|dataList|Project)\b", re.IGNORECASE)


class Val3(Vendor):
    """VAL3. Lengths mm, angles deg, turns Rx Ry Rz, speeds % and mm/s, times s; all converted while reading."""

    name = "val3"
    title = "Staubli VAL3"
    suffixes = (".pgx", ".dtx", ".pjx")
    reads = statements(
        "ElseIf While EndWhile For Next Switch Case Default EndSwitch StartTask Repeat Until Break Process "
        "Declare SetOverride Opaque"
    )
    data_suffixes = (".dtx", ".pjx")
    conventions = Conventions(
        first_element=0,
        longest_text=128,  # VAL3 reference, type string
        names_read_frames=True,
        sums_of_texts=True,
        assumed_codes=frozenset({"P576", "P577", "P578"}),
        member_types=MEMBER_TYPES,
        replaceable_routines=REPLACEABLE,
        filling_words=FILLING,
        result_types=RESULT_TYPES,
    )
    comment_prefix = "//"
    trailing_comment_prefix = " //"
    comment_length = 200
    case_sensitive = True

    def sniff(self, source: Source) -> bool:
        head = "\n".join(source.lines[:10])
        return "<" in head and _MARK.search(head) is not None

    def read(self, source: Source) -> Program:
        from olp.languages.vendors.val3.reader import read_program

        return read_program(source)


VENDOR = Val3()
