"""Finds the files that belong to a program: the list of the same name, and the controller's $config.dat."""

from __future__ import annotations

import os
import re
from functools import lru_cache
from pathlib import Path

from olp.core.source import Source, load

_SYSTEM_FOLDERS = ("", "System", "R1/System", "KRC/R1/System")
_TREES = ("R1", "KRC")
_MOST_FOLDERS, _DEEPEST = 200, 6
_CONFIG = "$config.dat"
_MOST_BYTES = 8 * 1024 * 1024  # bytes
_GLOBAL = re.compile(r"\s*(?:DECL\s+)?GLOBAL\s", re.IGNORECASE)


def find(path: str) -> tuple[Source | None, Source | None]:
    """The .dat beside `path` and the $config.dat near it, in any case of letters; None where there is none."""
    if not path:
        return None, None
    file = Path(path)
    try:
        if not file.is_file():
            return None, None
        beside = None if file.suffix.lower() == ".dat" else _in_folder(file.parent, file.stem + ".dat")
        config = None if file.name.lower() == _CONFIG else _config(file.parent)
        return _load(beside), _load(config)
    except OSError:
        return None, None


def _in_folder(folder: Path, name: str) -> Path | None:
    wanted = name.lower()
    exact = folder / name
    if exact.is_file():
        return exact
    with os.scandir(folder) as entries:
        return next(
            (folder / one.name for one in entries if one.name.lower() == wanted and one.is_file()), None
        )


def tree_of(folder: Path) -> list[Path]:
    """All folders of the robot's tree that `folder` stands in, for routines are global."""
    return _below(_root(folder.resolve()))


def _root(here: Path) -> Path:
    """KRC/R1 where a folder above has that name, else the highest of those that themselves hold programs."""
    root = next((one for one in (here, *here.parents) if one.name.upper() in _TREES), here)
    while root.name.upper() not in _TREES and _holds_programs(root.parent):
        root = root.parent
    return root


@lru_cache(maxsize=64)
def _below(root: Path) -> list[Path]:
    found = [root]
    for one in found:  # grows
        if len(found) > _MOST_FOLDERS or len(one.parts) - len(root.parts) >= _DEEPEST:
            break
        found += sorted(p for p in one.iterdir() if p.is_dir() and not p.is_symlink() and p.name[:1] != ".")
    return found


def lists_around(path: str) -> list[Path]:
    """The lists of the robot's tree but those that `find` finds: any of them may hold what is GLOBAL."""
    if not path:
        return []
    file = Path(path)
    try:
        if not file.is_file():
            return []
        own = file.stem.lower() + ".dat"
        found = [p for folder in tree_of(file.parent) for p in _lists_in(folder, folder.stat().st_mtime_ns)]
    except OSError:
        return []
    here = file.parent.resolve()
    return [
        p for p in found if p.name.lower() != _CONFIG and not (p.parent == here and p.name.lower() == own)
    ]


@lru_cache(maxsize=512)
def _lists_in(folder: Path, _: int) -> tuple[Path, ...]:
    """The lists of a folder, read again when it has changed."""
    with os.scandir(folder) as entries:
        return tuple(sorted(folder / one.name for one in entries if one.name.lower().endswith(".dat")))


def shared_rows(path: Path) -> tuple[Source, tuple[int, ...]] | None:
    """A list and the numbers of its lines that say GLOBAL; None for one that cannot be read."""
    try:
        status = path.stat()
        return _shared_rows(path, (status.st_mtime_ns, status.st_size))
    except OSError:
        return None


@lru_cache(maxsize=512)
def _shared_rows(path: Path, _: tuple[int, int]) -> tuple[Source, tuple[int, ...]] | None:
    source = _load(path)
    if source is None:
        return None
    return source, tuple(n for n, line in enumerate(source.lines, 1) if _GLOBAL.match(line))


def _holds_programs(folder: Path) -> bool:
    try:
        with os.scandir(folder) as entries:
            return any(one.name.lower().endswith(".src") or one.name.lower() == _CONFIG for one in entries)
    except OSError:
        return False


def _config(folder: Path) -> Path | None:
    """In the folder itself, in System beside or above it, or in a folder of the robot's tree it stands in."""
    here = folder.resolve()
    root = _root(here)
    above = [one for one in here.parents if one.name.upper() in _TREES or one.is_relative_to(root)]
    for place in dict.fromkeys((here, here.parent, *above)):
        for system in _SYSTEM_FOLDERS:
            if (place / system).is_dir():
                found = _in_folder(place / system, _CONFIG)
                if found is not None:
                    return found
    return None


def _load(path: Path | None) -> Source | None:
    if path is None or path.stat().st_size > _MOST_BYTES:
        return None
    return load(path)
