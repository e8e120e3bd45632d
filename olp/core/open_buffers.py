"""Texts that stand in an editor: they are read in place of the files on the disk."""

from __future__ import annotations

import os
from itertools import count

_texts: dict[str, tuple[int, bytes]] = {}
_serial = count(1)


def put(path: str | os.PathLike[str], raw: bytes) -> None:
    """From now on the file `path` holds `raw` for everybody in this process."""
    _texts[_key(path)] = (next(_serial), raw)


def drop(path: str | os.PathLike[str]) -> None:
    """The file on the disk counts again."""
    _texts.pop(_key(path), None)


def text(path: str | os.PathLike[str]) -> bytes | None:
    """What stands in the editor, None where the file is not open."""
    known = _texts.get(_key(path)) if _texts else None
    return None if known is None else known[1]


def stamp(path: str | os.PathLike[str]) -> tuple[int, int] | None:
    """Another one for every text that was put: (a negative number, size [bytes]); None where the file is not open."""
    known = _texts.get(_key(path)) if _texts else None
    return None if known is None else (-known[0], len(known[1]))


def _key(path: str | os.PathLike[str]) -> str:
    return os.path.normcase(os.path.abspath(path))
