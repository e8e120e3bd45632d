"""What an editor may set: the same words as on the command line. What is left out stands in olp.toml.

Code: C013.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from olp.core.diagnostic import Diagnostic, error
from olp.reports.batch import Job

_TEXTS = ("robot", "signature", "model")


@dataclass(frozen=True, slots=True)
class EditorSettings:
    """`job`: how programs are timed. `diagnostics`: what of the settings cannot be used, and is left out."""

    job: Job = Job()  # noqa: RUF009, a frozen one
    diagnostics: tuple[Diagnostic, ...] = ()


def settings_of(given: object) -> EditorSettings:
    """From `{"robot": …, "signature": …, "override": …, "model": …}`, or that under the key `olp`; override in %."""
    if isinstance(given, Mapping) and isinstance(given.get("olp"), Mapping):
        given = given["olp"]
    if not isinstance(given, Mapping):
        return EditorSettings()
    problems: list[Diagnostic] = []
    values: dict[str, Any] = {}
    for name in _TEXTS:
        value = given.get(name)
        if isinstance(value, str):
            values[name] = value.strip() or None
        elif value is not None:
            problems.append(_wrong(name, value, f"olp.{name} is a text"))
    override = given.get("override")
    if isinstance(override, (int, float)) and not isinstance(override, bool) and 0 < override < float("inf"):
        values["override"] = override / 100.0
    elif override not in (None, 0, ""):
        problems.append(_wrong("override", override, "olp.override is a number of % above zero"))
    return EditorSettings(Job(**values), tuple(problems))


def _wrong(name: str, value: object, says: str) -> Diagnostic:
    return error("C013", f"the setting olp.{name} cannot be {str(value)[:40]!r}", help=says)
