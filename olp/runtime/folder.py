"""What stands in the folder of a job, read once for all jobs of the folder as long as nothing there changes."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from olp.core import source
from olp.core.files import read_input

if TYPE_CHECKING:
    from olp.ir.program import Program
    from olp.robots.backup import Backup
    from olp.robots.robot import Robot

# A name record stands in the first lines; whole files of 800 kB would take seconds in a large folder.
_HEAD = 4096
_NAME_RECORD = "//NAME "
_CONTROLLER_SUFFIXES = (".cnd", ".dat", ".prm", ".sys")


def files_by_stem(folder: Path, suffix: str) -> Mapping[str, Path]:
    """The files ending in `suffix` (whatever the case) by their stem in upper case."""
    return _by_stem(folder, _modified(folder), suffix.lower())


def files_by_name_record(folder: Path, suffix: str) -> Mapping[str, Path]:
    """The same files by the routine names in their heads."""
    return _by_name_record(folder, _modified(folder), suffix.lower())


def backup_of(folder: Path) -> Backup | None:
    """The controller files in `folder`, None when there are none."""
    names = [n for n in _names(folder, _modified(folder)) if n.lower().endswith(_CONTROLLER_SUFFIXES)]
    if not names:
        return None
    return _backup(folder, tuple((name, *_stamp(folder / name)) for name in names))


def robot_of_backup(backup: Backup, mechanism: str) -> Robot | None:
    """The robot of a mechanism from the controller's parameters, None when they do not hold it.

    Raises OlpError when they are implausible.
    """
    from olp.robots.backup import robot_toml

    group = mechanism.replace("RB", "R").replace("BS", "B").replace("ST", "S")
    known = backup.system.groups if backup.system is not None else ()
    if group != "R1" and not any(g.name == group for g in known):
        return None
    return _parsed(robot_toml(backup, group, "" if known else "backup/r1"))


def read_cached(path: Path) -> Program:
    """`olp.read(path)`, once per state of the file. Raises OlpError like it."""
    return _read(path, _stamp(path))


@lru_cache(maxsize=256)
def _read(path: Path, _: tuple[int, int]) -> Program:
    from olp.languages.read import read

    return read(path)


@lru_cache(maxsize=16)
def _backup(folder: Path, _: tuple[tuple[str, int, int], ...]) -> Backup:
    from olp.robots.backup import read_backup

    return read_backup(folder)


@lru_cache(maxsize=16)
def _parsed(text: str) -> Robot:
    import tempfile

    from olp.robots.reader import read_robot

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "robot.toml"
        path.write_text(text, encoding="utf-8")
        return read_robot(path)


def _modified(folder: Path) -> int:
    return _stamp(folder)[0]


def _stamp(path: Path) -> tuple[int, int]:
    """(time of the last change [ns], size [bytes]); zeros where there is nothing. A text in an editor has its own."""
    edited = source.stamp(path)
    if edited is not None:
        return edited
    try:
        status = os.stat(path)
    except OSError:
        return 0, 0
    return status.st_mtime_ns, status.st_size


@lru_cache(maxsize=16)
def _names(folder: Path, _: int) -> tuple[str, ...]:
    try:
        with os.scandir(folder) as entries:
            return tuple(sorted(entry.name for entry in entries if entry.is_file()))
    except OSError:
        return ()


@lru_cache(maxsize=16)
def _by_stem(folder: Path, modified: int, suffix: str) -> Mapping[str, Path]:
    found: dict[str, Path] = {}
    for name in _names(folder, modified):
        stem, dot, end = name.rpartition(".")
        if (dot + end).lower() == suffix:
            found.setdefault(stem.strip().upper(), folder / name)
    return found


@lru_cache(maxsize=16)
def _by_name_record(folder: Path, modified: int, suffix: str) -> Mapping[str, Path]:
    found: dict[str, Path] = {}
    for path in _by_stem(folder, modified, suffix).values():
        try:
            head = read_input(path, first=_HEAD)
        except OSError:
            continue
        for line in head.decode("latin-1").splitlines():
            if line.startswith(_NAME_RECORD):
                found.setdefault(line[len(_NAME_RECORD) :].strip().upper(), path)
    return found
