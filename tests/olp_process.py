"""`olp WORD…` as a process of its own, without the second that its imports take.

Where the system forks, one Python imports olp and its libraries once, and each command is a child of it: nothing that a
command leaves behind reaches the next one, as with `python -m olp`. Elsewhere each command starts a Python.
"""

from __future__ import annotations

import atexit
import functools
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO

ROOT = Path(__file__).parent.parent

# Each line of its input is a command as JSON, each line of its answer the command's status. Nothing is read or timed
# before the fork, so that a command finds what it finds in a new process.
_PARENT = """
import atexit, json, os, sys, traceback
from importlib import import_module
from olp import cli
from olp.__main__ import main
from olp.languages.vendor import vendor_names
for name in cli.names():
    cli.load(name)
for name in vendor_names():
    import_module(f"olp.languages.vendors.{name}.reader")
vendors = "olp.languages.vendors"
for parser in (
    "inform.statements:instruction_parser", "krl.grammar:line_parser", "rapid.parsing:clause_parser",
    "tp.grammar:instruction_parser", "urscript.grammar:instruction_parser",
):
    module, _, function = parser.partition(":")
    getattr(import_module(f"{vendors}.{module}"), function)()  # a tenth of a second each
for name in ("olp.fluent", "olp.reports.batch", "olp.transpile.convert", "olp.checks.guard.run", "pandas"):
    import_module(name)
for line in sys.stdin:
    words, folder, environment, out, err = json.loads(line)
    child = os.fork()
    if child:
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
        continue
    status = 70
    try:
        for number, (path, flags) in enumerate(((os.devnull, os.O_RDONLY), (out, os.O_WRONLY), (err, os.O_WRONLY))):
            os.dup2(os.open(path, flags | (os.O_APPEND if number else 0)), number)
        sys.stdin = open(0, encoding="utf-8", closefd=False)
        os.chdir(folder)
        os.environ.clear()
        os.environ.update(environment)
        sys.argv[1:] = words
        status = main(words)
    except BaseException:
        traceback.print_exc()
        status = 1
    finally:
        atexit._run_exitfuncs()
        for stream in (sys.stdout, sys.stderr):
            try:
                stream.flush()
            except OSError:
                pass
        os._exit(status)
"""


@functools.cache
def _parent() -> subprocess.Popen[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUTF8": "1", "OPENBLAS_NUM_THREADS": "1"}
    started = subprocess.Popen(
        [sys.executable, "-c", _PARENT],
        cwd=ROOT,
        env=environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        encoding="utf-8",
    )
    atexit.register(started.communicate)
    return started


def run_olp(
    words: Sequence[str], folder: Path, environment: Mapping[str, str], merged: bool = False
) -> subprocess.CompletedProcess[bytes]:
    """What `olp WORD…` prints in a folder, and its status. `merged`: both streams as one, in `stdout`."""
    if not hasattr(os, "fork"):
        return subprocess.run(
            [sys.executable, "-m", "olp", *words],
            cwd=folder,
            env={**environment},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT if merged else subprocess.PIPE,
        )
    with tempfile.NamedTemporaryFile() as out, tempfile.NamedTemporaryFile() as err:
        names = out.name, (out if merged else err).name
        parent = _parent()
        _file(parent.stdin).write(json.dumps([list(words), str(folder), {**environment}, *names]) + "\n")
        _file(parent.stdin).flush()
        status = int(_file(parent.stdout).readline())
        return subprocess.CompletedProcess(list(words), status, out.read(), err.read())


def _file(stream: IO[str] | None) -> IO[str]:
    assert stream is not None
    return stream
