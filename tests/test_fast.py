"""The compiled extra is optional: found when it is there, missed politely when it is not."""

from __future__ import annotations

import subprocess
import sys

import pytest

from olp.core import compiled_loops
from olp.core.diagnostic import OlpError

WITHOUT = """
import sys
sys.modules["numba"] = None          # what an import finds where it is not installed
import importlib.util as util
found = util.find_spec
util.find_spec = lambda name, *rest: None if name == "numba" else found(name, *rest)
import numpy as np
from olp.timing.motion import durations
from olp.core.diagnostic import OlpError
print(durations(np.full((3, 6), 0.4), 1.0, 4.0, 40.0)[0])
try:
    durations(np.full((3, 6), 0.4), 1.0, 4.0, 40.0, compiled=True)
except OlpError as problem:
    print(problem.diagnostics[0].code, problem.diagnostics[0].help)
"""


@compiled_loops.Kernel
def total(values: list[float]) -> float:
    result = 0.0
    for value in values:
        result += value
    return result


def test_a_kernel_gives_what_its_function_gives():
    assert total((1.5, 2.25)) == total.plain((1.5, 2.25)) == 3.75
    assert total.__name__ == "total"


def test_without_the_extra_everything_works_and_asking_for_it_says_what_to_install():
    done = subprocess.run([sys.executable, "-c", WITHOUT], capture_output=True, text=True, check=True)
    time, problem = done.stdout.splitlines()
    assert float(time) == pytest.approx(0.75)
    assert problem == "F001 pip install olp[fast]"


def test_a_small_task_does_not_load_it():
    code = "import sys, olp.timing.motion as m; m.durations([[1.0]], 1.0, 4.0, 40.0); print('numba' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_it_is_used_as_told(monkeypatch):
    assert compiled_loops.use(False, 1e9) is False
    assert compiled_loops.use(True, 0.0) is True
    monkeypatch.setattr(compiled_loops, "available", lambda: False)
    assert compiled_loops.use(None, 1e9) is False
    with pytest.raises(OlpError, match="not installed"):
        compiled_loops.use(True, 0.0)
