"""What may be changed independently in an AS file: programs by their statements, tables by their names."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from olp.languages.merging import Known, MergeRules, Piece

_SECTION = re.compile(r"\s*\.(\w+)")
_TABLES = frozenset({"TRANS", "JOINTS", "REALS", "STRINGS", "INTEGER"})
_ROW = re.compile(r"\s*([^\s=]+)[\s=]+\S")


class AsMerging(MergeRules):
    comments = (";",)
    has_variables = True
    scope = re.compile(r"\s*\.PROGRAM\s+([\w.]+)|\s*\.END()\s*$", re.IGNORECASE)
    branch = re.compile(r"\s*VALUE\s+([^:;]*):", re.IGNORECASE)
    branched = re.compile(r"\s*(?:ANY\s*:|END\s*$)", re.IGNORECASE)

    def _pieces(self, lines: Sequence[tuple[str, str]], known: Known) -> Iterator[Piece]:
        section = ""
        for number, piece in enumerate(super()._pieces(lines, known)):
            text, _ = lines[number]  # no piece of AS is longer than a line
            opened = _SECTION.match(text)
            row = _ROW.match(text) if section in _TABLES and opened is None else None
            section = opened[1].upper() if opened is not None else section
            yield self._named_row(piece, f"{section}/{row[1].casefold()}", known) if row else piece

    def _named_row(self, piece: Piece, name: str, known: Known) -> Piece:
        """A line of a table, known by its name wherever it stands."""
        key = (piece.lines[0], piece.ends[0], name)
        found = known.get(key)
        if found is None:
            found = known[key] = replace(piece, name=name, loose=True)
        return found


MERGING = AsMerging()
