"""What the commands share: arguments, input files, output files.

Codes: C001 unknown command, C002 wrong arguments, C003 no such file, C004 a folder without such files,
C005 the operating system refused.
"""

from __future__ import annotations

import os
from argparse import ArgumentParser, Namespace
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NoReturn

from olp.diagnostic import Diagnostic, OlpError, error


class Parser(ArgumentParser):
    """An argument parser that answers wrong arguments with a diagnostic like any other bad input."""

    def __init__(self, prog: str, description: str) -> None:
        # An abbreviation that works today breaks a script on the day a longer option is added.
        super().__init__(prog=prog, description=description, allow_abbrev=False)

    def error(self, message: str) -> NoReturn:
        raise OlpError(error("C002", message, help=f"{self.prog} --help lists the arguments"))

    def parse_words(self, words: Sequence[str]) -> Namespace:
        """The arguments, in any order: options may stand between paths. Raises OlpError (C002)."""
        try:
            return self.parse_args(words)
        except OlpError as problem:
            # argparse takes paths on both sides of an option only when asked, but then loses the "--" before
            # paths that begin with "-", and says less of what is missing.
            if "--" in words:
                raise
            try:
                return self.parse_intermixed_args(words)
            except OlpError:
                raise problem from None


_ADVICE: Mapping[type[OSError], str] = {
    FileNotFoundError: "create the folder first, or name another one",
    IsADirectoryError: "name a file in this folder",
    PermissionError: "ask for the right to write there, or name another file with -o",
}


def from_os_error(problem: OSError) -> Diagnostic:
    """What the operating system refused, as a diagnostic: which file, and why in its own words."""
    file = problem.filename if problem.filename is not None else ""
    says = problem.strerror or str(problem)
    return error("C005", says, file=os.fsdecode(file), help=_ADVICE.get(type(problem), ""))


def expand_paths(paths: Iterable[str | Path], suffixes: Sequence[str]) -> list[Path]:
    """The files meant by `paths`: files as they are, folders searched for `suffixes`, patterns expanded.

    Suffixes are lower case with their dot (".jbi") and match either case. Every file comes once, folders in
    sorted order. Raises OlpError naming everything that is missing, unreadable or empty.
    """
    found: dict[str, Path] = {}
    problems: list[Diagnostic] = []
    for path in map(Path, paths):
        for file in _expand_one(path, tuple(suffixes), problems):
            found.setdefault(os.path.normcase(os.path.abspath(file)), file)
    if problems:
        raise OlpError(*problems)
    return list(found.values())


def _expand_one(path: Path, suffixes: tuple[str, ...], problems: list[Diagnostic]) -> list[Path]:
    if path.is_dir():
        return _search(path, suffixes, problems)
    if path.exists():
        return [path]
    # Shells on Windows hand patterns over as they are.
    matches = _glob(path)
    if not matches:
        problems.append(error("C003", "no such file or folder", file=str(path)))
    return [file for match in matches for file in _expand_one(match, suffixes, problems)]


def _glob(path: Path) -> list[Path]:
    from glob import glob, has_magic

    return [Path(name) for name in sorted(glob(str(path)))] if has_magic(str(path)) else []


def _search(root: Path, suffixes: tuple[str, ...], problems: list[Diagnostic]) -> list[Path]:
    refused: list[OSError] = []
    found = [
        Path(folder, name)
        for folder, _, names in os.walk(root, onerror=refused.append)
        for name in names
        if name.lower().endswith(suffixes)
    ]
    problems.extend(map(from_os_error, refused))
    if not found and not refused:
        help = f"their names end in {' '.join(suffixes)}"
        problems.append(error("C004", "no robot program in this folder", file=str(root), help=help))
    return sorted(found)
