"""Applies the fixes that findings carry: only such as cannot alter where the robot goes, or when."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from olp.files import write_output
from olp.outcome.model import Finding
from olp.source import load


def apply(path: str, findings: Sequence[Finding], encoding: str | None = None) -> int:
    """Changes the file and returns how many findings are gone; all other bytes stay. Raises OSError."""
    edits: dict[int, tuple[str, ...]] = {}
    done = 0
    for found in findings:
        for first, last, text in found.fixes:
            if any(line in edits for line in range(first, last + 1)):
                continue
            edits.update(dict.fromkeys(range(first, last + 1), ()))
            edits[first] = tuple(text.split("\n")) if text else ()
            done += 1
    if edits:
        changed = load(path, encoding).edited(edits)
        write_output(Path(path), changed.raw, inputs=[path], in_place=True)
    return done
