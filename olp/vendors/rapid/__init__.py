"""RAPID, the language of ABB robots: modules `.mod`, `.modx`, `.prg`, `.sys`, and the list `.pgf` of a program."""

from __future__ import annotations

import re

from olp.program import Program
from olp.source import Source
from olp.vendors.vendor import Vendor

_MODULE = re.compile(r"\s*MODULE\s+\w+\s*(?:\(|!|$)", re.IGNORECASE)
_HEADER = re.compile(r"\s*%%%")
_LISTED = re.compile(r"\s*<Program\b")


class Rapid(Vendor):
    """ABB RAPID. Speeds mm/s and deg/s, lengths mm, turns as quaternions; all converted while reading."""

    name = "rapid"
    title = "ABB RAPID"
    suffixes = (".mod", ".modx", ".prg", ".sys", ".pgf")
    folders_beside = ("../PROGMOD", "../SYSMOD")  # of a task in a backup
    comment_prefix = "!"
    trailing_comment_prefix = " !"
    comment_length = 80
    blending = "abb"

    def sniff(self, source: Source) -> bool:
        if source.path.lower().endswith(".pgf"):
            return any(_LISTED.match(line) for line in source.lines[:5])
        head = source.lines[:400]
        if any(_MODULE.match(line) for line in head):
            return True
        return any(_HEADER.match(line) for line in head[:5]) and any("VERSION" in line for line in head[:6])

    def read(self, source: Source) -> Program:
        from olp.vendors.rapid.reader import read_program

        return read_program(source)


VENDOR = Rapid()
