"""Asks olp, which runs in a Python of its own: FreeCAD's Python needs no further library and no certain version."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

PARAMETERS = "User parameter:BaseApp/Preferences/Mod/olp"
BRIDGE = Path(__file__).with_name("bridge.py")
# What FreeCAD sets for its own Python would break any other one.
_OURS = ("PYTHONHOME", "PYTHONPATH", "PYTHONEXECUTABLE", "LD_LIBRARY_PATH", "QT_PLUGIN_PATH", "VIRTUAL_ENV")
_NO_WINDOW = getattr(subprocess, "CREATE_NO_WINDOW", 0)
_MINUTES = 10
_found: dict[str, tuple[str, str]] = {}


class OlpError(Exception):
    """Everything that olp says against a question; `problems` are the sentences."""

    def __init__(self, problems: list[str]) -> None:
        super().__init__("\n".join(problems))
        self.problems = problems


def ask(request: dict) -> dict:
    """The answer of bridge.py. Raises OlpError."""
    python, root = python_with_olp()
    done = _run([python, str(BRIDGE)], root, json.dumps(request))
    try:
        answer = json.loads(done.stdout)
    except ValueError:
        raise OlpError([f"olp did not answer: {(done.stderr or done.stdout).strip()[-2000:]}"]) from None
    if "problems" in answer:
        raise OlpError([one["text"] for one in answer["problems"]])
    return answer


def command(*words: str) -> str:
    """What `olp WORDS` prints. Raises OlpError when it ends with status 2."""
    python, root = python_with_olp()
    done = _run([python, "-m", "olp", *words], root)
    if done.returncode > 1:
        raise OlpError([done.stderr.strip() or done.stdout.strip()])
    return done.stdout


def python_with_olp() -> tuple[str, str]:
    """A Python that can import olp, and the folder to look for olp in ("" where it is installed).

    The olp of the checkout that this folder stands in comes before an installed one: it fits.
    Pythons in this order: the environment's OLP_PYTHON, the setting of the workbench, that of the checkout, of the
    command `olp`, any on the path. Raises OlpError that says what to do.
    """
    chosen = os.environ.get("OLP_PYTHON") or setting("Python")
    if chosen not in _found:
        for python, root in _candidates(chosen):
            if _has_olp(python, root):
                _found[chosen] = (python, root)
                break
        else:
            where = f"{chosen} has no olp" if chosen else "no Python with olp was found"
            what_to_do = (
                "install olp (Python 3.11 or newer) and name its Python in olp → Settings, or in OLP_PYTHON"
            )
            raise OlpError([f"{where}: {what_to_do}"])
    return _found[chosen]


def setting(name: str) -> str:
    """A setting of the workbench; empty where there is none."""
    import FreeCAD

    return FreeCAD.ParamGet(PARAMETERS).GetString(name, "")


def set_setting(name: str, value: str) -> None:
    import FreeCAD

    FreeCAD.ParamGet(PARAMETERS).SetString(name, value)
    _found.clear()


def _candidates(chosen: str) -> list[tuple[str, str]]:
    root = BRIDGE.resolve().parents[3]
    checkout = str(root) if (root / "olp" / "__main__.py").is_file() else ""
    if chosen:
        return [(chosen, checkout), (chosen, "")]
    found = []
    if checkout:
        for inside in (".venv/bin/python", ".venv/Scripts/python.exe"):
            if (root / inside).is_file():
                found.append((str(root / inside), checkout))
    olp = shutil.which("olp")
    if olp:
        folder = Path(olp).resolve().parent
        for one in (folder / "python", folder / "python.exe", folder.parent / "python.exe"):
            if one.is_file():
                found.append((str(one), ""))
    pythons = [shutil.which(name) for name in ("python3", "python")]
    return found + [(one, folder) for one in pythons if one for folder in (checkout, "")]


def _has_olp(python: str, root: str) -> bool:
    try:
        return _run([python, "-c", "import olp, olp.checks.edit, numpy, pandas"], root).returncode == 0
    except (OSError, OlpError):
        return False


def _run(words: list[str], root: str, text: str | None = None) -> subprocess.CompletedProcess:
    environment = {key: value for key, value in os.environ.items() if key not in _OURS}
    environment["PYTHONIOENCODING"] = "utf-8"
    if root:
        environment["PYTHONPATH"] = root
    try:
        return subprocess.run(
            words,
            input=text,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            env=environment,
            timeout=60 * _MINUTES,
            creationflags=_NO_WINDOW,
        )
    except subprocess.TimeoutExpired:
        raise OlpError([f"olp was still at work after {_MINUTES} minutes"]) from None
