"""Processes that work for a server: no file of the served folder is imported, and what they start ends with them."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import sys
from asyncio.subprocess import PIPE, Process
from pathlib import Path

import olp

_PACKAGE = Path(olp.__file__).resolve().parent


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
    """Also what the worker started, whether its work was done, late or taken back."""
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
