"""Compares two versions of a program: which lines take longer or shorter, and why. The line changes add up to the
total change.
"""

from olp.checks.difference.compare import LineChange, ProgramDifference, compare

__all__ = ["LineChange", "ProgramDifference", "compare"]
