"""Reading a program file of any vendor: the library's entry point."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from olp.core.diagnostic import OlpError, error
from olp.core.source import Source, load

if TYPE_CHECKING:
    from olp.ir.program import Program


def read(path: str | os.PathLike[str], *, vendor: str | None = None, encoding: str | None = None) -> Program:
    """The program in the file `path`.

    `vendor`: its language; recognised by suffix and text when None. `encoding`: a Python codec name; guessed when
    None. Mistakes in the text do not raise: they are in `Program.diagnostics`, and the rest is usable.
    Raises OlpError when the file cannot be read (P004), its encoding is unknown (P005) or nobody knows its
    language (P002, P003).
    """
    try:
        source = load(path, encoding)
    except OSError as problem:
        why = problem.strerror or str(problem)
        raise OlpError(
            error("P004", f"cannot read the file: {why}", file=os.fspath(path), help="check the path")
        ) from None
    except LookupError:
        raise _unknown_encoding(encoding) from None
    return read_source(source, vendor=vendor)


def check_encoding(encoding: str) -> None:
    """Raises OlpError (P005) when no text can be read with it."""
    try:
        b" ".decode(encoding, "replace")
    except LookupError:
        raise _unknown_encoding(encoding) from None


def _unknown_encoding(encoding: str | None) -> OlpError:
    return OlpError(error("P005", f"unknown encoding '{encoding}'", help="try cp1252, shift_jis or utf-8"))


def read_source(source: Source, *, vendor: str | None = None) -> Program:
    """The program in a text that is already here. Raises OlpError like `read`."""
    from olp.languages.vendor import find_vendor, recognise, vendor_names

    found = find_vendor(vendor) if vendor else recognise(source)
    if found is None:
        known = ", ".join(f"{v.title} ({' '.join(v.suffixes)})" for v in map(find_vendor, vendor_names()))
        raise OlpError(
            error(
                "P002",
                "this is no robot program that olp knows",
                file=source.path,
                help=f"olp reads {known}",
            )
        )
    return found.read(source)
