"""The program in a text of an editor: the language is what the editor says, else what the file looks like."""

from __future__ import annotations

from olp.program import Program
from olp.reading import read_source
from olp.source import Source
from olp.vendors.vendor import find_vendor, recognise, vendor_names

# What editors call languages besides the names that olp has for them.
_OTHER_NAMES = {
    "yaskawa": "inform",
    "motoman": "inform",
    "kuka": "krl",
    "abb": "rapid",
    "fanuc": "tp",
    "ur": "urscript",
}


def vendor_of(source: Source, language: str) -> str | None:
    """The vendor's name: by the file's suffix, else as the editor says, else by the text. None: nobody knows it."""
    said = _OTHER_NAMES.get(language.casefold(), language.casefold())
    known = vendor_names()
    by_suffix = [name for name in known if source.path.lower().endswith(find_vendor(name).suffixes)]
    if said in known and (not by_suffix or said in by_suffix):
        return said
    found = recognise(source)
    return found.name if found is not None else None


def read_document(source: Source, language: str) -> Program:
    """The program. Raises OlpError (P002) where nobody knows its language."""
    return read_source(source, vendor=vendor_of(source, language))
