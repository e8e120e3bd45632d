"""olp reads robot programs, says how long every line takes and why, and writes them back unharmed.

import olp

program = olp.read("job.jbi")       # Program; program.diagnostics, program.to_bytes()
plan = program.plan()               # Plan: executed steps in order
plan.time()                         # pandas DataFrame, one row per segment, wait or signal

olp.time("job.jbi"), olp.calibrate, olp.predict, olp.diagnose, olp.convert: what the commands of these names do.
olp.Recording.read("folder"), olp.Signature.read("file"): what they learn from, and what they have learnt.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from olp.core.documented_names import install
from olp.core.version import __version__

if TYPE_CHECKING:
    from olp.core.diagnostic import Diagnostic, OlpError
    from olp.fluent import Plan, Program, convert, read, time
    from olp.recorded import Recording, Signature, calibrate, diagnose, predict
    from olp.robots.model import Robot
    from olp.robots.robot import load_robot, robot_names

install()

# Loaded when first asked for: `olp --help` must not wait for numpy.
_HOME = {
    "Diagnostic": "olp.core.diagnostic",
    "OlpError": "olp.core.diagnostic",
    "Plan": "olp.fluent",
    "Program": "olp.fluent",
    "Recording": "olp.recorded",
    "Robot": "olp.robots.robot",
    "Signature": "olp.recorded",
    "calibrate": "olp.recorded",
    "convert": "olp.fluent",
    "diagnose": "olp.recorded",
    "load_robot": "olp.robots.robot",
    "predict": "olp.recorded",
    "read": "olp.fluent",
    "robot_names": "olp.robots.robot",
    "time": "olp.fluent",
}

__all__ = [
    "Diagnostic",
    "OlpError",
    "Plan",
    "Program",
    "Recording",
    "Robot",
    "Signature",
    "__version__",
    "calibrate",
    "convert",
    "diagnose",
    "load_robot",
    "predict",
    "read",
    "robot_names",
    "time",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'olp' has no attribute {name!r}; it has {', '.join(__all__)}")
    from importlib import import_module

    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
