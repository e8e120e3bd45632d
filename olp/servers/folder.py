"""The one folder that a server shows. What it names is a path below it, or is refused with a reason.

Codes: Z001 outside the folder, Z002 no ordinary file, Z003 too large, Z004 too many, Z009 exists already.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import NamedTuple

from olp.core.diagnostic import Diagnostic, OlpError, error

# --- Limits ---
# How much one call may read, compute and say.


@dataclass(frozen=True, slots=True)
class ServerLimits:
    """Limits of one call, sufficient for a cell of a few hundred jobs. A call beyond them is rejected, or says what
    was cut.
    """

    seconds: float = 60.0  # [s] of the clock, then the worker is ended
    memory: int = 4_000_000_000  # [bytes] of address space of the worker
    file: int = 8_000_000  # [bytes] of one file that is read
    files: int = 500  # programs of one call
    answer: int = 200_000  # characters of one answer

    def as_json(self) -> dict[str, float]:
        """Return the limits for the request of a worker."""
        return asdict(self)


# --- Folder ---

_HELP = "name it by its path below the folder that is served, such as cells/MAIN.JBI"
_LONGEST = 1024  # characters of a path
_DRIVE = re.compile(r"[A-Za-z]:[\\/]")
_CONTROL = re.compile(r"[\x00-\x1f\x7f]")


class Folder(NamedTuple):
    """The folder that a server may use. `root`: its absolute path without links, also the worker's current folder."""

    root: Path
    limits: ServerLimits = ServerLimits()

    def inside(self, text: str) -> str:
        """Return `text` as a path relative to the root, for the command line. Raises OlpError (Z001, Z002)."""
        plain = self._plain(text)
        real = Path(os.path.realpath(self.root / plain))
        if not real.is_relative_to(self.root):
            raise _refused("Z001", "this path is a link that leads outside", text)
        try:
            kind = os.stat(real).st_mode
        except (OSError, ValueError):
            return plain  # missing, or a pattern: the command line says so, or expands it
        if not (stat.S_ISREG(kind) or stat.S_ISDIR(kind)):
            raise _refused("Z002", "this is a device or a pipe, no file", text)
        return plain

    def programs(self, texts: Sequence[str], suffixes: Sequence[str]) -> list[str]:
        """Return the paths of programs, or of folders with programs. Raises OlpError with every path that is
        outside, missing or too large.
        """
        from olp.core.files import absent, expand_paths

        words = self.all_inside(texts)
        found = expand_paths(words, suffixes)
        if gone := absent(found):
            raise OlpError(*gone)
        if len(found) > self.limits.files:
            says = f"{len(found)} programs in one call, {self.limits.files} are allowed"
            raise OlpError(error("Z004", says, help="name fewer of them, or a smaller folder"))
        self.all_inside([str(path) for path in found])
        problems = [problem for path in found if (problem := self._size(path)) is not None]
        if problems:
            raise OlpError(*problems)
        return words

    def all_inside(self, texts: Sequence[str]) -> list[str]:
        """Return `inside` of each text. Raises OlpError with all paths that are rejected."""
        words: list[str] = []
        problems: list[Diagnostic] = []
        for text in texts:
            try:
                words.append(self.inside(text))
            except OlpError as refused:
                problems += refused.diagnostics
        if problems:
            raise OlpError(*problems)
        return words

    def new(self, text: str, suffixes: Sequence[str] = (), *, force: bool = False) -> str:
        """Return a path below the root that may be written; `suffixes`: those allowed, any where empty.

        Raises OlpError: Z001, Z002, Z006 for another suffix, Z009 for an existing file without `force`.
        """
        plain = self.inside(text)
        if suffixes and not plain.lower().endswith(tuple(suffixes)):
            raise OlpError(error("Z006", f"output: this must end in {' or '.join(suffixes)}", file=plain))
        if (self.root / plain).is_file() and not force:
            raise OlpError(
                error("Z009", "this file exists already", file=plain, help="another output, or force=true")
            )
        if any(part.startswith(".") for part in PurePosixPath(plain.replace("\\", "/")).parts):
            raise _refused("Z001", "hidden files and folders are not written", text)
        return plain

    def _plain(self, text: str) -> str:
        if not text or len(text) > _LONGEST or _CONTROL.search(text):
            raise _refused("Z001", "this is no path: empty, too long, or with control characters", text)
        try:
            os.fsencode(text)
        except UnicodeEncodeError:
            raise _refused("Z001", "this path has a character that no file name has", text) from None
        if text.startswith(("\\\\", "//")):
            raise _refused("Z001", "paths of the network and of devices are not read", text)
        if ".." in re.split(r"[\\/]", text):
            raise _refused("Z001", "this path goes up with ..", text)
        if os.path.isabs(text):
            real = Path(os.path.realpath(text))
            if real.is_relative_to(self.root):
                return _word(os.path.relpath(real, self.root))
            raise _refused("Z001", "this path is outside the folder", text)
        if _DRIVE.match(text) or text.startswith("\\"):
            raise _refused("Z001", "this path is outside the folder", text)
        if os.name == "nt" and PureWindowsPath(text).is_reserved():
            raise _refused("Z002", "this is a device, no file", text)
        return _word(text)

    def _size(self, path: Path) -> Diagnostic | None:
        size = os.stat(path).st_size
        if size <= self.limits.file:
            return None
        return too_large(str(path), size, self.limits.file)


def too_large(file: str, size: int, most: int) -> Diagnostic:
    """Return the error Z003 for a file of `size` bytes where `most` bytes are read."""
    says = f"this file has {size / 1e6:.1f} MB, {most / 1e6:g} MB are read"
    return error("Z003", says, file=file, help="split the program, or ask the command line")


def _word(path: str) -> str:
    """Return the path in a form that an argument parser does not take for an option."""
    return f"./{path}" if path.startswith("-") else path


def _refused(code: str, says: str, text: str) -> OlpError:
    shown = _CONTROL.sub("?", text[:80]) + ("…" if len(text) > 80 else "")
    return OlpError(error(code, f"{says}: {shown!r}", help=_HELP))
