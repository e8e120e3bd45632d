"""A process that works in one folder: what it may open, how much memory it takes, and the command line in it.

What is asked for by name is checked before (`folder.py`). The guard holds for the rest: called jobs, `olp.toml`, robot
files and recordings that a file of the folder names, links among them.

Such a process imports no file of the served folder, and what it starts ends with it.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import io
import os
import signal
import stat
import sys
import sysconfig
from asyncio.subprocess import PIPE, Process
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any, NamedTuple

from olp.core.diagnostic import Diagnostic, OlpError
from olp.core.files import from_os_error

_PACKAGE = Path(__file__).resolve().parents[1]
CommandLine = Callable[[list[str]], int]  # runs `olp WORD…` and gives its exit status


class Ran(NamedTuple):
    """Result of one command line."""

    status: int
    printed: bytes
    told: str


def captured(command_line: CommandLine, words: Sequence[str]) -> Ran:
    """Runs `olp WORD…` in this process. Raises OlpError for bad input."""
    out = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", errors="replace", newline="\n")
    told = io.StringIO()
    with redirect_stdout(out), redirect_stderr(told):
        try:
            status = command_line(list(words))
        except OSError as problem:
            raise OlpError(from_os_error(problem)) from None
        out.flush()
    printed = out.buffer.getvalue() if isinstance(out.buffer, io.BytesIO) else b""
    return Ran(status, printed, told.getvalue().strip())


def as_json(diagnostic: Diagnostic) -> dict[str, Any]:
    """The keys of `olp time --format json`."""
    names = ("code", "severity", "file", "line", "column", "message", "help")
    return {name: getattr(diagnostic, name) for name in names}


def limit_memory(size: int, seconds: float | None = None) -> None:
    """`size` [bytes] of address space and a little more than `seconds` [s] of the processor, where the system can."""
    try:
        import resource
    except ImportError:  # Windows has none: there only the clock counts
        return
    limits = [(resource.RLIMIT_AS, size)]
    if seconds is not None:
        limits.append((resource.RLIMIT_CPU, int(seconds) + 5))
    for kind, most in limits:
        hard = resource.getrlimit(kind)[1]
        resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def prepare(root: Path, temporary: Path) -> None:
    """Make the folder the current one, and remove environment settings that lead git or tempfile elsewhere."""
    import tempfile

    for name in [name for name in os.environ if name.startswith("GIT_") or name in ("BASE", "MERGED")]:
        del os.environ[name]
    os.environ |= {
        "GIT_OPTIONAL_LOCKS": "0",
        "GIT_TERMINAL_PROMPT": "0",
        "OPENBLAS_NUM_THREADS": "1",
        "TMPDIR": str(temporary),
    }
    tempfile.tempdir = str(temporary)
    os.chdir(root)


# --- Guard ---
# Closes a process in: from then on nothing outside one folder is opened, whoever asks.
#
# Python's audit hooks see every file that it opens; they stop mistakes and hostile data, not hostile code, and none is
# run here.

_SAYS = "outside the folder that is served"
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
        """Audit hook, which Python calls before an operation. Raises PermissionError for a forbidden one."""
        if event == "open":
            self._open(*arguments[:3])
        elif event in _CHANGES:
            for path in arguments[: _CHANGES[event]]:
                self._check(path, True)
        elif event == "subprocess.Popen":
            if os.path.basename(os.fsdecode(str(arguments[0]))) not in ("git", "git.exe"):
                raise PermissionError(errno.EACCES, "this server starts no other program")
        elif event in _FORBIDDEN:
            raise PermissionError(errno.EACCES, f"this server does not allow {event}")

    def _open(self, path: object, mode: object = None, flags: object = 0) -> None:
        if isinstance(mode, str):
            writes = any(sign in mode for sign in "wax+")
        else:
            writes = isinstance(flags, int) and bool(flags & _WRITE_FLAGS)
        self._check(path, writes)

    def _check(self, path: object, writes: bool) -> None:
        if not isinstance(path, (str, bytes, os.PathLike)):
            return  # a file that is open already
        real = Path(os.path.realpath(os.fsdecode(path)))
        if real.is_relative_to(self.temporary):
            return
        if real.is_relative_to(self.root) and not (writes and not self.write):
            self._ordinary(real)
            return
        if not writes and (real.as_posix().startswith(_SYSTEM) or self._library(real)):
            return
        says = "this server only reads" if real.is_relative_to(self.root) else _SAYS
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
            raise OSError(errno.EFBIG, f"larger than the {self.largest / 1e6:g} MB that are read", str(real))


def close_in(root: Path, temporary: Path, write: bool, largest: int, also: Sequence[Path] = ()) -> None:
    """Install the guard for the rest of this process. `largest`: bytes of a file; `also`: readable files outside,
    absolute.
    """
    package = _PACKAGE
    known = [sys.prefix, sys.base_prefix, sys.exec_prefix, *sysconfig.get_paths().values(), *sys.path]
    folders = [Path(os.path.realpath(folder)) for folder in known if folder]
    # A checkout has its grammars and templates beside the package; what else is there is no library.
    parent = [package.parent / kind for kind in ("grammars", "templates")]
    libraries = [folder for folder in folders if folder != package.parent or folder.name == "site-packages"]
    sys.dont_write_bytecode = True
    guard = Guard(root, temporary, write, largest, (*libraries, package, *parent, *also))
    sys.addaudithook(lambda event, arguments: guard(event, arguments))


async def start_worker(script: str) -> Process:
    """A Python that runs `script`, a file of the package olp, with pipes to its standard input and output."""
    # -P and an absolute path: nothing that lies in the served folder is ever imported.
    return await asyncio.create_subprocess_exec(
        sys.executable,
        "-P",
        str(_PACKAGE / script),
        stdin=PIPE,
        stdout=PIPE,
        cwd=_PACKAGE / "servers",
        env=_environment(),
        start_new_session=os.name != "nt",
    )


async def end_worker(worker: Process) -> None:
    """End the worker and every process that it started."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        if os.name == "nt":
            worker.kill()
        else:
            os.killpg(worker.pid, signal.SIGKILL)
    await worker.wait()


def _environment() -> dict[str, str]:
    """The server's, with this olp first on the path; relative folders would be looked for in another place."""
    given = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    path = os.pathsep.join([str(_PACKAGE.parent), *(folder for folder in given if os.path.isabs(folder))])
    return {**os.environ, "PYTHONPATH": path, "PYTHONUTF8": "1"}
