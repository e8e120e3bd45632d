"""The folders that RoboDK has on its path."""

import sys
import warnings
from pathlib import Path

HOST = Path(__file__).parent.parent
sys.path[:0] = [str(HOST / "Posts"), str(HOST / "Scripts"), str(HOST / "tests")]

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import robodk  # noqa: F401  (announces a change of its own whenever it is loaded)
