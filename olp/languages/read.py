"""Reading a program file of any vendor: the library's entry point.

Of a file that is no program it says what it is: a picture, an archive, a log, something encrypted.
"""

from __future__ import annotations

import os
import re
from typing import TYPE_CHECKING, Final

from olp.core.diagnostic import OlpError, error
from olp.core.files import parse_json
from olp.core.source import Source, load

if TYPE_CHECKING:
    from olp.ir.program import Program


_MAGIC: Final = (
    (b"\x89PNG\r\n", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF8", "a GIF picture"),
    (b"II*\x00", "a TIFF picture"),
    (b"MM\x00*", "a TIFF picture"),
    (b"%PDF-", "a PDF document"),
    (b"PK\x03\x04", "a ZIP archive"),
    (b"7z\xbc\xaf", "a 7-Zip archive"),
    (b"Rar!", "a RAR archive"),
    (b"\x7fELF", "a program for Linux"),
    (b"MZ\x90", "a program for Windows"),
    (b"SQLite format 3", "a database"),
    (b"\xd0\xcf\x11\xe0", "an Office document"),
    (b"<!DOCTYPE html", "a web page"),
    (b"<html", "a web page"),
    (b"{\\rtf", "an RTF document"),
)
_STAMP: Final = re.compile(
    rb"\s*[\[(]?(?:\d{4}[-/.]\d\d?[-/.]\d\d?|\d\d?[-/.]\d\d?[-/.]\d{4})[T ,;]+\d\d?:\d\d(?::\d\d)?"
)
_LOOKED_AT: Final = 4096  # bytes
_FEW: Final = 256  # bytes that say nothing of a file
_STAMPED: Final = 0.6  # share of a log's lines
_ODD: Final = 0.3  # share of bytes that no text has
_PRINTED: Final = frozenset((*range(32, 127), 9, 10, 13, 26))


def binary_kind(raw: bytes) -> str:
    """What the first bytes say that a file is, "" for what may be a text."""
    head = raw[:_LOOKED_AT].lstrip(b"\xef\xbb\xbf")
    return next((kind for magic, kind in _MAGIC if head[: len(magic)].lower() == magic.lower()), "")


def text_kind(raw: bytes) -> str:
    """What a file is that no language recognises, "" where it cannot be told."""
    head = raw[:_LOOKED_AT]
    lines = [line for line in head.splitlines() if line.strip()]
    if len(lines) > 1 and sum(_STAMP.match(line) is not None for line in lines) >= _STAMPED * len(lines):
        return "a log: its lines begin with a time"
    if head[:1] in (b"{", b"[") and len(raw) < 16 * _LOOKED_AT:
        try:
            parse_json(raw)
        except ValueError:
            return ""
        return "JSON"
    odd = sum(byte not in _PRINTED for byte in head)
    wide = head[:2] in (b"\xff\xfe", b"\xfe\xff") or head.count(0) > 0.4 * len(head)  # UTF-16
    if len(head) >= _FEW and odd > _ODD * len(head) and not wide and head.count(b"\n") < len(head) / 80:
        return "no text: it is encrypted or compressed"
    return ""


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
