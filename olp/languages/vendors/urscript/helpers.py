"""Functions that olp writes into a script where URScript has no word of its own; the reader knows them again."""

from __future__ import annotations

import re
from collections.abc import Sequence
from decimal import Decimal
from typing import Final

from olp.ir.expressions import Expression, Function, Member, Number, Quantity, Signal
from olp.ir.program import PulseOutput
from olp.languages.vendors.urscript.builtins import OUTPUT_WORDS

# Angles of a pose [deg], R = Rz(rz) Ry(ry) Rx(rx): the manual's roll, pitch and yaw.
TEXTS: Final = {
    "olp_rx": (
        "def olp_rx(pose):",
        "  local rpy = rotvec2rpy([pose[3], pose[4], pose[5]])",
        "  return r2d(rpy[0])",
        "end",
    ),
    "olp_ry": (
        "def olp_ry(pose):",
        "  local rpy = rotvec2rpy([pose[3], pose[4], pose[5]])",
        "  return r2d(rpy[1])",
        "end",
    ),
    "olp_rz": (
        "def olp_rz(pose):",
        "  local rpy = rotvec2rpy([pose[3], pose[4], pose[5]])",
        "  return r2d(rpy[2])",
        "end",
    ),
    "olp_pose": (
        "def olp_pose(x, y, z, rx, ry, rz):",
        "  local turn = rpy2rotvec([d2r(rx), d2r(ry), d2r(rz)])",
        "  return p[x * 0.001, y * 0.001, z * 0.001, turn[0], turn[1], turn[2]]",
        "end",
    ),
    "olp_trunc": (
        "def olp_trunc(x):",
        "  if (x < 0):",
        "    return ceil(x)",
        "  end",
        "  return floor(x)",
        "end",
    ),
    "olp_round": (
        "def olp_round(x):",
        "  if (x < 0):",
        "    return ceil(x - 0.5)",
        "  end",
        "  return floor(x + 0.5)",
        "end",
    ),
    "olp_min": ("def olp_min(a, b):", "  if (a < b):", "    return a", "  end", "  return b", "end"),
    "olp_max": ("def olp_max(a, b):", "  if (a > b):", "    return a", "  end", "  return b", "end"),
    # Of the 18 digital signals that other languages count by one number: those of the box, then the tool's two.
    **{
        f"olp_digital_{way}": (
            f"def olp_digital_{way}(n):",
            "  if (n < 8):",
            f"    return get_standard_digital_{way}(n)",
            "  elif (n < 16):",
            f"    return get_configurable_digital_{way}(n - 8)",
            "  end",
            f"  return get_tool_digital_{way}(n - 16)",
            "end",
        )
        for way in ("in", "out")
    },
    "olp_set_digital_out": (
        "def olp_set_digital_out(n, b):",
        "  if (n < 8):",
        "    set_standard_digital_out(n, b)",
        "  elif (n < 16):",
        "    set_configurable_digital_out(n - 8, b)",
        "  else:",
        "    set_tool_digital_out(n - 16, b)",
        "  end",
        "end",
    ),
    # Characters count from 0 in URScript, from 1 in olp.
    "olp_find": (
        "def olp_find(text, first, wanted):",
        "  return str_find(text, wanted, first - 1) + 1",
        "end",
    ),
    "olp_match": (
        "def olp_match(text, first, wanted):",
        "  local at = str_find(text, wanted, first - 1)",
        "  if (at < 0):",
        "    return str_len(text) + 1",
        "  end",
        "  return at + 1",
        "end",
    ),
}
_FUNCTIONS: Final = {
    "olp_pose": "pose-angles",
    "olp_trunc": "trunc",
    "olp_round": "round",
    "olp_min": "min",
    "olp_max": "max",
    "olp_find": "find-in-text",
    "olp_match": "match-in-text",
}
WORDS: Final = {neutral: name for name, neutral in _FUNCTIONS.items()}
# A pulse of an output is a thread, for nothing of URScript goes on by itself. Its name says what it does.
PULSED: Final = {"out": "do", "configurable-out": "co", "tool-out": "to", "flag": "flag"}
_PULSE: Final = re.compile(rf"olp_pulse_({'|'.join(PULSED.values())})(\d+)_(\d+(?:_\d+)?)s")
COUNTER: Final = "olp_left"  # [s] that a wait may still last


def pulse_name(signal: Signal, seconds: float) -> str:
    """The thread that switches an output with a number on for this long."""
    assert type(signal.index) is Number
    lasts = f"{Decimal(repr(float(seconds))):f}".removesuffix(".0").replace(".", "_")
    return f"olp_pulse_{PULSED[signal.bus]}{signal.index.value:g}_{lasts}s"


def is_helper(name: str, lines: Sequence[str]) -> bool:
    """Whether olp wrote this function. `lines`: its text; a pulse that a person has changed is a thread like others."""
    found = _PULSE.fullmatch(name)
    if found is None:
        return name in TEXTS
    text = " ".join(line.strip() for line in lines)
    word = OUTPUT_WORDS[_bus(found)]
    made = re.fullmatch(
        rf"thread {name}\(\): ({word})\({found[2]}, True\) sleep\(([\d.e-]+)\) \1\({found[2]}, False\) end",
        text,
    )
    return made is not None and float(made[2]) == _lasts(found)


def _bus(name: re.Match[str]) -> str:
    return next(bus for bus, word in PULSED.items() if word == name[1])


def _lasts(name: re.Match[str]) -> float:
    """How long a pulse lasts by its thread's name [s]."""
    return float(name[3].replace("_", "."))


def pulse(line: int, name: str, comment: str) -> PulseOutput | None:
    """The pulse that a thread of this name is, None of others."""
    found = _PULSE.fullmatch(name)
    if found is None:
        return None
    signal = Signal(_bus(found), Number(int(found[2])))
    return PulseOutput(line, signal, Quantity(Number(_lasts(found)), 1.0), comment=comment)


def meaning(name: str, arguments: tuple[Expression, ...]) -> Expression:
    """What a call of one of them computes."""
    if name in _FUNCTIONS:
        return Function(_FUNCTIONS[name], arguments)
    return Member(arguments[0], name.removeprefix("olp_"))
