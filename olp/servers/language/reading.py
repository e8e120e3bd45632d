"""The program in a text of an editor: the language is what the editor says, else what the file looks like."""

from __future__ import annotations

from olp.core.source import Source
from olp.ir.program import Program
from olp.languages.read import read_source
from olp.languages.vendor import find_vendor, recognise, vendor_names


def vendor_of(source: Source, language: str) -> str | None:
    """The vendor's name: by the file's suffix, else as the editor says, else by the text. None: nobody knows it."""
    said, known = language.casefold(), vendor_names()
    said = next((name for name in known if said in find_vendor(name).editor_names), said)
    by_suffix = [name for name in known if source.path.lower().endswith(find_vendor(name).suffixes)]
    if said in known and (not by_suffix or said in by_suffix):
        return said
    found = recognise(source)
    return found.name if found is not None else None


def read_document(source: Source, language: str) -> Program:
    """The program. Raises OlpError (P002) where nobody knows its language."""
    return read_source(source, vendor=vendor_of(source, language))
