"""A text laid out anew. It is read again, and where the program is not the same one to the letter, nothing changes."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from olp.core.diagnostic import OlpError
from olp.core.source import Source
from olp.ir.program import Program
from olp.languages.layout import Layout
from olp.languages.read import read_source
from olp.languages.vendor import part_of
from olp.servers.language.analysis import Analysis
from olp.servers.language.document import TextEdit


def formatting(analysis: Analysis, first: int = 1, last: int = 1 << 30, indent: str = "  ") -> list[TextEdit]:
    """The edits that lay out lines `first` to `last`; none where the program would mean anything else."""
    program = analysis.program
    layout: Layout | None = None if program is None else part_of(program.vendor, "layout")
    if program is None or layout is None:
        return []
    old = analysis.source.lines
    new = [
        after if first <= number <= last else before
        for number, (before, after) in enumerate(zip(old, layout.lines(old, indent), strict=True), 1)
    ]
    if new == list(old) or not _same(program, analysis.source, new):
        return []
    return [
        TextEdit(number, 1, number, len(before) + 1, after)
        for number, (before, after) in enumerate(zip(old, new, strict=True), 1)
        if before != after
    ]


def _same(program: Program, source: Source, lines: list[str]) -> bool:
    """Whether the text still says what it said: same statements on the same lines, same findings."""
    raw = "\r\n".join([*lines, ""]).encode("utf-8", "surrogatepass")
    try:
        again = read_source(Source(source.path, raw, source.encoding, tuple(lines)), vendor=program.vendor)
    except OlpError:
        return False
    parts = ("routines", "data", "main")
    said = [(d.code, d.line, d.message) for d in program.diagnostics if d.line]
    still = [(d.code, d.line, d.message) for d in again.diagnostics if d.line]
    return said == still and all(equal(getattr(program, part), getattr(again, part)) for part in parts)


def equal(first: Any, second: Any) -> bool:
    """Whether two parts of programs are the same, whatever they hold; nan is equal to itself."""
    if type(first) is not type(second):
        return False
    if isinstance(first, np.ndarray):
        return bool(first.shape == second.shape and first.tobytes() == second.tobytes())
    if isinstance(first, (list, tuple)):
        return len(first) == len(second) and all(map(equal, first, second))
    if isinstance(first, dict):
        return list(first) == list(second) and all(equal(first[key], second[key]) for key in first)
    if is_dataclass(first):
        return all(equal(getattr(first, f.name), getattr(second, f.name)) for f in fields(first))
    return bool(first == second or (first != first and second != second))
