"""One call, in a process of its own: python assistant_worker.py < request > answer.

The request is a JSON object: `tool`, its `arguments` (checked), `root`, `temporary`, `write`, `limits`. The answer is
one, too: {"answer": …} or {"diagnostics": […]}. Codes: Z005 out of memory, Z008 unexpected.
"""

from __future__ import annotations

import io
import json
import os
import sys
import traceback
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

from olp.core.diagnostic import Diagnostic, OlpError, error
from olp.core.files import from_os_error
from olp.servers.mcp.folder import Folder
from olp.servers.mcp.guard import close_in
from olp.servers.mcp.limits import ServerLimits
from olp.servers.mcp.tool import Ran, load_tool
from olp.servers.mcp.truncate import fit

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
