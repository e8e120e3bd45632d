"""Deliberate faults for `bench/faults.py`: one module per language, and one for what lies between the languages."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault: `old` stands exactly once in `file` (inside the part's own folder) and becomes `new`."""

    file: str
    old: str
    new: str
    breaks: str  # what is wrong then
