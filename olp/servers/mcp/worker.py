"""One call, in a process of its own: python assistant_worker.py < request > answer.

The request is a JSON object: `tool`, its `arguments` (checked), `root`, `temporary`, `write`, `limits`. The answer is
one, too: {"answer": …} or {"diagnostics": […]}. Codes: Z005 out of memory, Z008 unexpected.
"""

from __future__ import annotations

import errno
import io
import json
import os
import stat
import sys
import sysconfig
import traceback
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any, NamedTuple

from olp.core.diagnostic import Diagnostic, OlpError, error
from olp.core.files import from_os_error
from olp.servers.mcp.folder import Folder, ServerLimits
from olp.servers.mcp.tool import Ran, load_tool

CommandLine = Callable[[list[str]], int]  # runs `olp WORD…` and gives its exit status
_TOLD = 8_000  # characters of notes


class OneCall:
    """What the tool may use."""

    def __init__(self, folder: Folder, temporary: Path, write: bool, command_line: CommandLine) -> None:
        self.folder = folder
        self.temporary = temporary
        self.write = write
        self._command_line = command_line

    def run(self, *words: str) -> Ran:
        """Runs `olp WORD…` in the folder. Raises OlpError for bad input."""
        out = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", errors="replace", newline="\n")
        told = io.StringIO()
        with redirect_stdout(out), redirect_stderr(told):
            try:
                status = self._command_line(list(words))
            except OSError as problem:
                raise OlpError(from_os_error(problem)) from None
            out.flush()
        printed = out.buffer.getvalue() if isinstance(out.buffer, io.BytesIO) else b""
        if status == 2 and not printed:
            raise OlpError(error("Z008", "there is no answer", help=_short(told.getvalue())))
        return Ran(status, printed, _short(told.getvalue()))


def _short(text: str) -> str:
    text = text.strip()
    return text if len(text) <= _TOLD else f"{text[:_TOLD]}\n… and {len(text) - _TOLD} more characters"


def limit_memory(size: int, seconds: float) -> None:
    """`size` [bytes] of address space and a little more than `seconds` [s] of the processor, where the system can."""
    try:
        import resource
    except ImportError:  # Windows has none: there only the clock counts
        return
    for kind, most in ((resource.RLIMIT_AS, size), (resource.RLIMIT_CPU, int(seconds) + 5)):
        hard = resource.getrlimit(kind)[1]
        resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def prepare(root: Path, temporary: Path) -> None:
    """The folder is the current one, and nothing of the environment leads git or tempfile elsewhere."""
    import tempfile

    for name in [name for name in os.environ if name.startswith("GIT_") or name in ("BASE", "MERGED")]:
        del os.environ[name]
    os.environ |= {
        "GIT_CEILING_DIRECTORIES": str(root.parent),
        "GIT_OPTIONAL_LOCKS": "0",
        "GIT_TERMINAL_PROMPT": "0",
        "OPENBLAS_NUM_THREADS": "1",
        "TMPDIR": str(temporary),
    }
    tempfile.tempdir = str(temporary)
    os.chdir(root)


def answer(request: dict[str, Any], command_line: CommandLine) -> dict[str, Any]:
    """Never raises."""
    try:
        return {"answer": _answer(request, command_line)}
    except OlpError as refused:
        return {"diagnostics": [as_json(d) for d in refused.diagnostics]}
    except (MemoryError, RecursionError):
        says = "this is too large: memory is at its end"
        return {"diagnostics": [as_json(error("Z005", says, help="ask about fewer or smaller programs"))]}
    except Exception as problem:
        traceback.print_exc()
        says = f"olp failed in a way that it does not know ({type(problem).__name__})"
        return {"diagnostics": [as_json(error("Z008", says, help="the server's log has the details"))]}


def _answer(request: dict[str, Any], command_line: CommandLine) -> dict[str, Any]:
    tool = load_tool(request["tool"])
    limits = ServerLimits(**request["limits"])
    root, temporary = Path(request["root"]), Path(request["temporary"])
    given = tool.given.model_validate(request["arguments"])
    limit_memory(int(limits.memory), limits.seconds)
    prepare(root, temporary)
    close_in(root, temporary, request["write"], int(limits.file))
    call = OneCall(Folder(root, limits), temporary, request["write"], command_line)
    return fit(tool.ask(given, call), given.rows, int(limits.answer))


def as_json(diagnostic: Diagnostic) -> dict[str, Any]:
    """The keys of `olp time --format json`."""
    names = ("code", "severity", "file", "line", "column", "message", "help")
    return {name: getattr(diagnostic, name) for name in names}


def main(command_line: CommandLine) -> None:
    """Standard input to standard output; whatever else is printed goes to the error stream."""
    out = os.dup(1)
    os.dup2(2, 1)
    told = answer(json.load(sys.stdin.buffer), command_line)
    with os.fdopen(out, "wb") as stream:
        stream.write(json.dumps(told, allow_nan=False).encode("utf-8", "replace"))


# --- Truncate ---
# An answer that an assistant can hold: long lists are cut, and it is said which. Texts are never cut.
#
# Code: Z010 too much to say.


def fit(whole: dict[str, Any], rows: int, most: int) -> dict[str, Any]:
    """`whole` with at most `rows` rows per list and `most` characters, and `truncated`. Raises OlpError (Z010)."""
    while True:
        cut: list[str] = []
        shown = {key: _cut(value, key, rows, cut) for key, value in whole.items()}
        shown["truncated"] = cut
        size = len(json.dumps(shown, ensure_ascii=False))
        if size <= most:
            return shown
        if rows <= 1:
            says = f"the answer has {size} characters, {most} are given"
            raise OlpError(
                error("Z010", says, help="ask about one program, with summary=true, or use the command line")
            )
        rows //= 2


def _cut(value: Any, name: str, rows: int, cut: list[str]) -> Any:
    if isinstance(value, dict):
        return {key: _cut(item, f"{name}.{key}", rows, cut) for key, item in value.items()}
    if isinstance(value, list):
        if len(value) > rows and name.rpartition(".")[2] != "files":  # programs are whole or not there
            cut.append(f"{name}: {rows} of {len(value)}")
            value = value[:rows]
        return [_cut(item, f"{name}[{index}]", rows, cut) for index, item in enumerate(value)]
    return value


# --- Guard ---
# Closes a process in: from then on nothing outside one folder is opened, whoever asks.
#
# What an assistant names is checked before (`folder.py`). This holds for the rest: called jobs, `olp.toml`, robot files
# and recordings that a file of the folder names, links among them. Python's audit hooks see every file that it opens;
# they stop mistakes and hostile data, not hostile code, and none is run here.

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
