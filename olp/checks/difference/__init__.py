"""Two versions of a program: which lines take longer or shorter now, and why. The parts add up to the whole."""

from olp.checks.difference.compare import LineChange, ProgramDifference, compare

__all__ = ["LineChange", "ProgramDifference", "compare"]
