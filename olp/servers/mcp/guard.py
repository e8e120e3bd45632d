"""Closes a process in: from then on nothing outside one folder is opened, whoever asks.

What an assistant names is checked before (`folder.py`). This holds for the rest: called jobs, `olp.toml`, robot files
and recordings that a file of the folder names, links among them. Python's audit hooks see every file that it opens;
they stop mistakes and hostile data, not hostile code, and none is run here.
"""

from __future__ import annotations

import errno
import os
import stat
import sys
import sysconfig
from pathlib import Path
from typing import NamedTuple

_SAYS = "outside the folder that olp mcp was started with"
_SYSTEM = ("/usr/share/zoneinfo", "/etc/localtime", "/dev/null", "/dev/urandom")
_FORBIDDEN = (
    "socket.connect",
    "socket.bind",
    "os.system",
    "os.exec",
    "os.posix_spawn",
    "pty.spawn",
)
# Event -> how many of its first arguments are paths.
_CHANGES = {"os.remove": 1, "os.rename": 2, "os.mkdir": 1, "os.rmdir": 1, "os.link": 2, "os.symlink": 2}
_CHANGES |= {"os.chmod": 1, "os.chown": 1, "os.truncate": 1, "os.utime": 1}
_WRITE_FLAGS = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND


class Guard(NamedTuple):
    """`root` is read, and written when `write`; `temporary` is written, `libraries` are read. Absolute, no links."""

    root: Path
    temporary: Path
    write: bool
    largest: int  # [bytes] of a file below the root
    libraries: tuple[Path, ...]

    def __call__(self, event: str, arguments: tuple[object, ...]) -> None:
        """What Python asks before it does something. Raises PermissionError."""
        if event == "open":
            self._open(*arguments[:3])
        elif event in _CHANGES:
            for path in arguments[: _CHANGES[event]]:
                self._check(path, True)
        elif event == "subprocess.Popen":
            if os.path.basename(os.fsdecode(str(arguments[0]))) not in ("git", "git.exe"):
                raise PermissionError(errno.EACCES, "olp mcp starts no other program")
        elif event in _FORBIDDEN:
            raise PermissionError(errno.EACCES, f"olp mcp does not allow {event}")

    def _open(self, path: object, mode: object = None, flags: object = 0) -> None:
        if isinstance(mode, str):
            writes = any(sign in mode for sign in "wax+")
        else:
            writes = isinstance(flags, int) and bool(flags & _WRITE_FLAGS)
        self._check(path, writes)

    def _check(self, path: object, writes: bool) -> None:
        if not isinstance(path, str | bytes | os.PathLike):
            return  # a file that is open already
        real = Path(os.path.realpath(os.fsdecode(path)))
        if real.is_relative_to(self.temporary):
            return
        if real.is_relative_to(self.root) and not (writes and not self.write):
            self._ordinary(real)
            return
        if not writes and (real.as_posix().startswith(_SYSTEM) or self._library(real)):
            return
        says = "olp mcp was started without --write" if real.is_relative_to(self.root) else _SAYS
        raise PermissionError(errno.EACCES, says, os.fsdecode(path))

    def _library(self, real: Path) -> bool:
        return any(real.is_relative_to(folder) for folder in self.libraries)

    def _ordinary(self, real: Path) -> None:
        try:
            status = os.stat(real)
        except OSError:
            return
        if not (stat.S_ISREG(status.st_mode) or stat.S_ISDIR(status.st_mode)):
            raise PermissionError(errno.EACCES, "a device or a pipe, no file", str(real))
        if status.st_size > self.largest:
            raise OSError(
                errno.EFBIG, f"larger than the {self.largest / 1e6:g} MB that olp mcp reads", str(real)
            )


def close_in(root: Path, temporary: Path, write: bool, largest: int) -> None:
    """For the rest of this process. `largest`: bytes of a file."""
    import olp

    package = Path(olp.__file__).resolve().parent
    known = [sys.prefix, sys.base_prefix, sys.exec_prefix, *sysconfig.get_paths().values(), *sys.path]
    folders = [Path(os.path.realpath(folder)) for folder in known if folder]
    # A checkout has its grammars and templates beside the package; what else is there is no library.
    parent = [package.parent / kind for kind in ("grammars", "templates")]
    libraries = [folder for folder in folders if folder != package.parent or folder.name == "site-packages"]
    sys.dont_write_bytecode = True
    guard = Guard(root, temporary, write, largest, (*libraries, package, *parent))
    sys.addaudithook(lambda event, arguments: guard(event, arguments))
