"""What a program cannot tell about itself: `olp.toml` beside the jobs. `docs/assumptions.md` describes the file.

Inputs, how long a wait lasts, what an operator types, which robot it is. Whatever the file does not say, the
interpreter assumes in one documented way and reports.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Final, NamedTuple

from olp.core.diagnostic import Diagnostic
from olp.ir.expressions import Store
from olp.ir.points import PointState

FILE_NAME: Final = "olp.toml"
_FOLDERS_ABOVE = 5  # that are searched for the file

# How signals and variables are called in olp.toml and in messages, whatever the program's language.
SIGNAL_WORDS: Final[Mapping[str, str]] = {
    "in": "IN",
    "out": "OT",
    "in-group": "IG",
    "out-group": "OG",
    "in-half-group": "IGH",
    "out-half-group": "OGH",
    "system-in": "SIN",
    "system-out": "SOUT",
    "direct-in": "RIN",
    "analog-in": "AI",
    "analog-out": "AO",
    "register": "MREG",
    "robot-in": "RI",
    "robot-out": "RO",
    "tool-in": "TI",
    "tool-out": "TO",
    "configurable-in": "CI",
    "configurable-out": "CO",
    "panel-in": "UI",
    "panel-out": "UO",
    "weld-in": "WI",
    "weld-out": "WO",
    "weld-stick-in": "WSI",
    "weld-stick-out": "WSO",
    "marker": "MARKER",
    "flag": "FLAG",
    "cyclic-flag": "CYCFLAG",
    "timer-flag": "TFLAG",
}
# What no file at hand may say, and what is assumed then; a key of [unknown] in olp.toml makes it an error.
UNKNOWN: Final[Mapping[str, str]] = {
    "routines": "a called routine that is not here does nothing",
    "values": "a name without a value is 0, false or an empty text",
    "positions": "a move to a position without a value is left out",
    "start": "the arm begins in front of its base, the flange pointing down",
}
NAMED_SIGNAL: Final = "signal"  # the bus of a signal that has a name and no number
VARIABLE_LETTERS: Final[Mapping[Store, str]] = {
    Store.BYTE: "B",
    Store.INTEGER: "I",
    Store.DOUBLE: "D",
    Store.REAL: "R",
    Store.STRING: "S",
    Store.ROBOT: "P",
    Store.BASE: "BP",
    Store.STATION: "EX",
    Store.SYSTEM: "PX",
}
_BUSES = {word: bus for bus, word in SIGNAL_WORDS.items()}
_STORES = {letters: store for store, letters in VARIABLE_LETTERS.items() if store is not Store.SYSTEM}
_SIGNAL = re.compile(r"([A-Z]+)\s*#?\s*[(\[]?\s*(\d{1,6})\s*[)\]]?")
_NAMED = re.compile(r"SIGNAL\s*#?\s*[(\[]\s*([^\W\d]\w*)\s*[)\]]", re.IGNORECASE)
_VARIABLE = re.compile(r"([A-Z]+)\s*(\d{1,6})")


class SignalKey(NamedTuple):
    """A signal however it was written: bus as in `olp.ir.expressions.Signal` and number, or "signal" and its name."""

    bus: str
    number: int | str


class WrittenPosition(NamedTuple):
    """A position from the file: `values` in pulses, or metres and radians, as `state` says."""

    state: PointState
    values: tuple[float, ...]


Given = int | float | str | WrittenPosition


@dataclass(frozen=True, slots=True)
class Assumptions:
    """The file's content in SI. Every mapping is empty where the file says nothing."""

    path: str = ""
    robot: str = ""  # library name or file, for the first robot
    robots: Mapping[str, str] = field(default_factory=dict)  # mechanism (RB1, BS1, ST1) -> robot
    inputs: Mapping[SignalKey, tuple[int, ...]] = field(
        default_factory=dict
    )  # one value per read, the last holds
    variables: Mapping[tuple[Store, int], Given] = field(default_factory=dict)
    names: Mapping[str, Given] = field(default_factory=dict)  # variables of languages with names, lower case
    tools: Mapping[int, tuple[float, ...]] = field(
        default_factory=dict
    )  # x y z [m], rx ry rz [rad] on the flange
    frames: Mapping[int, tuple[float, ...]] = field(default_factory=dict)  # likewise in the base
    waits: Mapping[SignalKey, float] = field(default_factory=dict)  # [s] until that signal comes
    default_wait: float | None = None  # [s] for all other waits
    pause: float | None = None  # [s] until the operator starts again
    process: Mapping[str, float] = field(default_factory=dict)  # [s] per process instruction, lower case
    motion: Mapping[str, str | float] = field(default_factory=dict)  # model, accel_mm_s2, as written
    start: Mapping[str, WrittenPosition] = field(
        default_factory=dict
    )  # mechanism -> where it stands at first
    routines: Mapping[str, float] = field(
        default_factory=dict
    )  # [s] of called ones that are not here, lower case
    strict: frozenset[str] = frozenset()  # of UNKNOWN: what ends in an error where no file says it
    diagnostics: tuple[Diagnostic, ...] = ()


def signal_name(key: SignalKey) -> str:
    """The signal as olp.toml spells it: IN#(12)."""
    if isinstance(key.number, str):
        return f"SIGNAL#({key.number})"
    return f"{SIGNAL_WORDS.get(key.bus, key.bus)}#({key.number})"


def signal_key(text: str) -> SignalKey | None:
    """The signal that a text names (`IN#(12)`, `IN 12`, `in[12]`, `SIGNAL#(diGripClosed)`), None when it names none."""
    match = _SIGNAL.fullmatch(text.strip().upper())
    bus = _BUSES.get(match[1]) if match else None
    if match and bus:
        return SignalKey(bus, int(match[2]))
    named = _NAMED.fullmatch(text.strip())
    return SignalKey(NAMED_SIGNAL, named[1].casefold()) if named else None


def variable_key(text: str) -> tuple[Store, int] | None:
    """The variable that a text names (`B010`, `P7`), None when it names none."""
    match = _VARIABLE.fullmatch(text.strip().upper())
    store = _STORES.get(match[1]) if match else None
    return (store, int(match[2])) if match and store else None


def nearest_assumptions(folder: str | os.PathLike[str]) -> Path | None:
    """The `olp.toml` that holds for jobs in `folder`: there, or up to five folders above, not beyond a repository."""
    current = Path(folder).resolve()
    for _ in range(_FOLDERS_ABOVE + 1):
        candidate = current / FILE_NAME
        if candidate.is_file():
            return candidate
        if current.parent == current or (current / ".git").exists():
            return None
        current = current.parent
    return None


def load_assumptions(path: str | os.PathLike[str]) -> Assumptions:
    """The content of an olp.toml. Never raises: what is wrong is in `diagnostics`, and the rest holds."""
    try:
        status = os.stat(path)
        stamp = (status.st_mtime_ns, status.st_size)
    except OSError:
        stamp = (0, 0)
    return _load(Path(path), stamp)


@lru_cache(maxsize=64)
def _load(path: Path, _: tuple[int, int]) -> Assumptions:
    from olp.runtime.assumptions_reader import read_assumptions

    return read_assumptions(path)
