"""What to say when a robot is missing."""

from __future__ import annotations

from olp.diagnostic import Diagnostic
from olp.interpreter.state import Machine


def missing_robots(m: Machine) -> list[Diagnostic]:
    """One finding when positions could not be known for want of a robot."""
    return []
