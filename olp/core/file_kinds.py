"""What a file is that is no program: a picture, an archive, a log, something encrypted."""

from __future__ import annotations

import re
from typing import Final

from olp.core.files import parse_json

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
