"""Reading a program file of any vendor: the library's entry point."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from olp.core.diagnostic import OlpError, error
from olp.core.file_kinds import binary_kind, text_kind
from olp.core.source import Source, load

if TYPE_CHECKING:
    from olp.ir.program import Program


def read(path: str | os.PathLike[str], *, vendor: str | None = None, encoding: str | None = None) -> Program:
    """The program in the file `path`.

    `vendor`: its language; recognised by suffix and text when None. `encoding`: a Python codec name; guessed when
    None. Mistakes in the text do not raise: they are in `Program.diagnostics`, and the rest is usable.
    Raises OlpError when the file cannot be read (P004), its encoding is unknown (P005) or nobody knows its
    language (P002, P003), and for a file of another kind (P044).

    Example:
        >>> import olp
        >>> program = olp.read("samples/inform/generations/dx200.jbi")
        >>> program.vendor, len(program.diagnostics)
        ('inform', 0)
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
    _refuse_other_kinds(source, vendor)
    return read_source(source, vendor=vendor)


def _refuse_other_kinds(source: Source, vendor: str | None) -> None:
    """Raises OlpError (P044) for a file that is no program but something that is known."""
    from olp.languages.vendor import find_vendor, recognise

    found = find_vendor(vendor) if vendor else recognise(source)
    kind = binary_kind(source.raw) or ("" if found and found.sniff(source) else text_kind(source.raw))
    if kind:
        known = f"a program of {found.title}" if found else "a robot program"
        raise OlpError(
            error(
                "P044",
                f"this is {kind}",
                file=source.path,
                help=f"give {known} as text, as the controller saves it",
            )
        )


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
                "this is not a robot program that olp knows",
                file=source.path,
                help=f"olp reads {known}",
            )
        )
    return found.read(source)
