"""One call, in a process of its own: python assistant_worker.py < request > answer.

The request is a JSON object: `tool`, its `arguments` (checked), `root`, `temporary`, `write`, `limits`. The answer is
one, too: {"answer": …} or {"diagnostics": […]}. Codes: Z005 out of memory, Z008 unexpected.
"""

from __future__ import annotations

import json
import os
import sys
import traceback
from pathlib import Path
from typing import Any

from olp.core.diagnostic import OlpError, error
from olp.servers.confinement import CommandLine, Ran, as_json, captured, close_in, limit_memory, prepare
from olp.servers.folder import Folder, ServerLimits
from olp.servers.mcp.tool import load_tool

_TOLD = 8_000  # characters of notes


class OneCall:
    """The environment of one call, as `ToolCall` describes it."""

    def __init__(self, folder: Folder, temporary: Path, write: bool, command_line: CommandLine) -> None:
        self.folder = folder
        self.temporary = temporary
        self.write = write
        self._command_line = command_line

    def run(self, *words: str) -> Ran:
        """Run `olp WORD…` in the folder. Raises OlpError (Z008) where the command ends with status 2 and prints no
        answer.
        """
        ran = captured(self._command_line, words)
        if ran.status == 2 and not ran.printed:
            raise OlpError(error("Z008", "there is no answer", help=_short(ran.told)))
        return ran._replace(told=_short(ran.told))


def _short(text: str) -> str:
    return text if len(text) <= _TOLD else f"{text[:_TOLD]}\n… and {len(text) - _TOLD} more characters"


def answer(request: dict[str, Any], command_line: CommandLine) -> dict[str, Any]:
    """Run one request and return {"answer": …} or {"diagnostics": […]}. Never raises."""
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
    # An assistant sees the repository of its folder, and none above it.
    os.environ["GIT_CEILING_DIRECTORIES"] = str(root.parent)
    close_in(root, temporary, request["write"], int(limits.file))
    call = OneCall(Folder(root, limits), temporary, request["write"], command_line)
    return fit(tool.ask(given, call), given.rows, int(limits.answer))


def main(command_line: CommandLine) -> None:
    """Read one request from standard input and write its answer to standard output; other prints go to standard
    error.
    """
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
    """Return `whole` with at most `rows` rows per list and at most `most` characters, and name the lists that were
    cut.

    The key `truncated` of the result lists them. The files of a program are never cut. Raises OlpError (Z010) where
    one row per list is still too long.
    """
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
