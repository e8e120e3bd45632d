"""The text of a program file: bytes in, lines out, and back without losing one of them.

Robot controllers write cp1252, Shift-JIS or plain ASCII with CRLF; files edited elsewhere come as UTF-8, with LF,
bare CR or a mixture. The bytes are kept, the text is a view on them, and an edit touches only the edited lines.
"""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import count

from olp.core.files import read_input

_LINE_END = re.compile(r"\r\n|\n|\r")
_LINE_END_BYTES = re.compile(rb"\r\n|\n|\r")
_BOMS = ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16-le"), (b"\xfe\xff", "utf-16-be"))
_KANA_OR_KANJI = re.compile("[\u3040-\u30ff\u4e00-\u9fff\uff61-\uff9f]")

# Five times what any controller holds; a file beyond them would fill the memory before anything was known of it.
_MOST_BYTES, _MOST_LINES = 100_000_000, 1_000_000

# Undecodable bytes become lone surrogates and turn back into the same bytes.
_ERRORS = "surrogateescape"


@dataclass(frozen=True, slots=True)
class Source:
    """A file's bytes and its lines. `lines` are without their ends; line n of the file is `lines[n - 1]`."""

    path: str
    raw: bytes
    encoding: str
    lines: tuple[str, ...]

    def line(self, number: int) -> str:
        """Line `number`, counted from 1; empty outside the text."""
        return self.lines[number - 1] if 0 < number <= len(self.lines) else ""

    @property
    def newline(self) -> str:
        """The most frequent line end; CRLF, which controllers insist on, when there is none."""
        crlf = self.raw.count(b"\r\n")
        counts = {"\r\n": crlf, "\n": self.raw.count(b"\n") - crlf, "\r": self.raw.count(b"\r") - crlf}
        best = max(counts, key=lambda end: counts[end])
        return best if counts[best] else "\r\n"

    def encode(self, text: str) -> bytes:
        """`text` in the file's encoding. Raises UnicodeEncodeError for a character that it does not have."""
        return text.encode("utf-8" if self.encoding == "utf-8-sig" else self.encoding, _ERRORS)

    def edited(self, edits: Mapping[int, Sequence[str]]) -> Source:
        """The text with each line number in `edits` replaced by the given lines (none: the line is removed).

        All other lines keep their bytes, line ends included. A replacement takes the end of the line it
        replaces; further lines take the same, or the file's usual one where the old line had none.
        """
        pieces, position = [], 0
        for number, (start, stop, end) in enumerate(self._extents(), 1):
            if number not in edits:
                continue
            pieces.append(self.raw[position:start])
            pieces.append(self._joined(edits[number], self.raw[stop:end]))
            position = end
        pieces.append(self.raw[position:])
        return decode(b"".join(pieces), self.path, self.encoding)

    def _joined(self, lines: Sequence[str], end: bytes) -> bytes:
        usual = end or self.encode(self.newline)
        return usual.join(self.encode(line) for line in lines) + (end if lines else b"")

    def _extents(self) -> list[tuple[int, int, int]]:
        """(start, end of text, end with line end) of each line, in bytes."""
        extents, start = [], 0
        for match in _LINE_END_BYTES.finditer(self.raw):
            extents.append((start, match.start(), match.end()))
            start = match.end()
        if start < len(self.raw):
            extents.append((start, len(self.raw), len(self.raw)))
        return extents


def load(path: str | os.PathLike[str], encoding: str | None = None) -> Source:
    """Reads a file, or what an editor holds of it. Raises OSError when it cannot be read, or is no program's size."""
    edited = text(path)
    if edited is not None:
        return decode(edited, os.fspath(path), "utf-8")
    raw = read_input(path, _MOST_BYTES)
    if raw.count(b"\n") > _MOST_LINES or raw.count(b"\r") > _MOST_LINES:
        raise OSError(errno.EFBIG, f"this file has more than {_MOST_LINES:,} lines", os.fspath(path))
    return decode(raw, os.fspath(path), encoding)


def decode(raw: bytes, path: str = "", encoding: str | None = None) -> Source:
    """The text of `raw`; the encoding is guessed unless it is given."""
    encoding = encoding or guess_encoding(raw)
    try:
        text = raw.decode(encoding, _ERRORS)
    except UnicodeDecodeError:
        text = raw.decode(encoding, "replace")  # half a character of UTF-16, which no surrogate stands for
    return Source(path, raw, encoding, _split(text))


def file_name(path: str) -> str:
    """Return the last part of a path with the separators of any system."""
    return path.replace("\\", "/").rpartition("/")[2]


def file_stem(path: str) -> str:
    """Return `file_name` without its suffix; a name that is only a suffix stays as it is."""
    name = file_name(path)
    return name.rpartition(".")[0] or name


def _split(text: str) -> tuple[str, ...]:
    returns = text.count("\r")
    if not returns:
        lines = text.split("\n")
    elif returns == text.count("\n") == text.count("\r\n"):
        lines = text.split("\r\n")
    else:
        lines = _LINE_END.split(text)
    if lines and not lines[-1]:
        lines.pop()
    return tuple(lines)


def guess_encoding(raw: bytes) -> str:
    """UTF-8 when the bytes are valid UTF-8, Shift-JIS when they read as Japanese, else cp1252."""
    for mark, name in _BOMS:
        if raw.startswith(mark):
            return name
    if raw.isascii():
        return "ascii"
    for name in ("utf-8", "shift_jis"):
        try:
            text = raw.decode(name)
        except UnicodeDecodeError:
            continue
        # Two cp1252 umlauts in a row can pass for Shift-JIS: ask for real Japanese letters.
        if name == "utf-8" or _japanese(raw, text):
            return name
    return "cp1252"


def _japanese(raw: bytes, text: str) -> bool:
    letters = len(_KANA_OR_KANJI.findall(text))
    eight_bit = sum(byte > 0x7F for byte in raw)
    # German text puts an umlaut before an ordinary letter, which decodes to a rare kanji or half-width kana:
    # true Japanese comes in runs, so most eight-bit bytes stand beside another.
    runs = sum(len(run) for run in re.findall(rb"[\x80-\xff][\x40-\xff]?(?:[\x80-\xff][\x40-\xff]?)+", raw))
    return letters > 0 and runs >= 0.5 * eight_bit


# --- Open buffers ---
# Texts that stand in an editor: they are read in place of the files on the disk.

_texts: dict[str, tuple[int, bytes]] = {}
_serial = count(1)


def put(path: str | os.PathLike[str], raw: bytes) -> None:
    """Make `raw` the content of the file `path` for this process, as an editor with unsaved changes needs."""
    _texts[_key(path)] = (next(_serial), raw)


def drop(path: str | os.PathLike[str]) -> None:
    """Undo `put`: the content on the disk counts again."""
    _texts.pop(_key(path), None)


def text(path: str | os.PathLike[str]) -> bytes | None:
    """Return the content that `put` set; None where there is none."""
    known = _texts.get(_key(path)) if _texts else None
    return None if known is None else known[1]


def stamp(path: str | os.PathLike[str]) -> tuple[int, int] | None:
    """Return a version of the content that `put` set: (a new negative number per `put`, size [bytes]); None where
    there is none.
    """
    known = _texts.get(_key(path)) if _texts else None
    return None if known is None else (-known[0], len(known[1]))


def _key(path: str | os.PathLike[str]) -> str:
    return os.path.normcase(os.path.abspath(path))
