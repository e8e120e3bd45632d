"""A process that answers one request after the other: python web_worker.py < requests > answers.

The first message is a `WorkerSetting`; each further one names what is asked and its arguments. An answer is
{"answer": …} or {"diagnostics": […]}. Codes: Z005 out of memory, Z006 wrong arguments, Z008 unexpected.
"""

from __future__ import annotations

import os
import sys
import traceback
from pathlib import Path
from typing import Any

from olp.core.diagnostic import OlpError, error
from olp.core.files import from_os_error
from olp.servers.confinement import CommandLine, as_json, close_in, limit_memory, prepare
from olp.servers.web.answers import ANSWERS
from olp.servers.web.desk import Desk
from olp.servers.web.messages import WorkerSetting, packed, received


def answered(desk: Desk, request: dict[str, Any]) -> bytes:
    """The answer as a message. Never raises."""
    try:
        return packed({"answer": ANSWERS[request["ask"]](desk, request["given"])})
    except OlpError as refused:
        found = list(refused.diagnostics)
    except OSError as problem:
        found = [from_os_error(problem)]
    except (MemoryError, RecursionError):
        says = "this is too large: memory is at its end"
        found = [error("Z005", says, help="ask about fewer or smaller programs")]
    except Exception as problem:
        traceback.print_exc()
        says = f"olp failed in a way that it does not know ({type(problem).__name__})"
        found = [error("Z008", says, help="the terminal of olp serve has the details")]
    return packed({"diagnostics": [as_json(d) for d in found]})


def main(command_line: CommandLine) -> None:
    """Until standard input ends. Whatever is printed besides answers goes to the error stream."""
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    setting = WorkerSetting.from_json(received(sys.stdin.buffer))
    root, temporary = Path(setting.root), Path(setting.temporary)
    limit_memory(setting.memory)
    prepare(root, temporary)
    close_in(root, temporary, False, setting.file, [Path(path) for path in setting.also])
    desk = Desk(setting, temporary, command_line)
    while (request := received(sys.stdin.buffer)) is not None:
        out.write(answered(desk, request))
        out.flush()
