"""The handling cell: one task whose program every language brings as a sample, in numbers that come from no reader.

The arm picks a part from a table, lifts it in three steps, hands it over at a rack by an arc and goes home. A vendor's
sample says exactly this by hand (CONTRIBUTING, "A new vendor"), so it is the anchor for units, for the order of angles
and for the words of its language: reader and writer cannot agree on a wrong one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np

from olp.contracts.events import OracleEvent
from olp.contracts.oracle import DEG, MM, Array, frame
from olp.ir.expressions import Number
from olp.ir.program import Assign, Declare, Program
from olp.languages.vendor import Vendor

GRIPPER: Final = frame(12.5, -8.25, 187.4, 0, 15, 30)
PROBE: Final = frame(-31, 4.5, 220.75, 10, -5, 62)
TABLE: Final = frame(850.5, -210.25, 305.75, 1.5, -2.25, 33)
RACK: Final = frame(420, 640.5, 512, 0, 0, 90.5)
ABOVE: Final = frame(110.5, 45.25, 160, 178.5, 3.25, -21.5)
PICK: Final = frame(110.5, 45.25, 20.125, 178.5, 3.25, -21.5)
MIDDLE: Final = frame(180, 120.5, 95.75, 175, 1, 5)
EDGE: Final = frame(260.25, 60, 40.5, 170.5, -4, 18)
SHELF: Final = frame(55.5, -20.25, 88, 160, 12.5, -75)
POINTS: Final = (ABOVE, PICK, EDGE, SHELF)  # MIDDLE may be turned as one likes
HOME: Final = tuple(value * DEG for value in (5.5, -12.25, 18.75, 3.5, -47.25, 21.0))
SPEEDS: Final = (0.25, 0.1205, 0.15, 0.3)  # [m/s] of straight moves and the arc
# What the three joint moves are told, in the kind that the language has.
JOINT_SPEEDS: Final = {"share": (0.4, 0.55, 0.4), "axis": (1.1, 1.5, 1.1), "speed": (1.5, 2.0, 1.5)}
OUTPUT: Final = 3
INPUT: Final = 7
PARTS: Final = 2  # that are left when the program starts


def events(parts: int = PARTS, joint: str = "share") -> list[OracleEvent]:
    """What happens with so many parts left. `joint`: the kind of speed that joint moves have."""
    home, over, back = ({joint: value} for value in JOINT_SPEEDS[joint])
    first = OracleEvent("joint", axes=HOME, blend=0.0, **home)  # type: ignore[arg-type]
    last = OracleEvent("joint", axes=HOME, blend=0.0, **back)  # type: ignore[arg-type]
    found = [
        first,
        _output(False),
        _move("joint", TABLE @ ABOVE, GRIPPER, blend=25 * MM, **over),
        _move("linear", TABLE @ PICK, GRIPPER, speed=0.25, blend=0.0),
        _output(True),
        OracleEvent("wait", seconds=0.35),
    ]
    for step in (1, 2, 3):
        lifted = PICK.copy()
        lifted[2, 3] += 40 * MM * step
        found.append(_move("linear", TABLE @ lifted, GRIPPER, speed=0.1205, blend=5 * MM))
    found.append(OracleEvent("input", signal=INPUT, on=True))
    if parts > 1:
        via = (TABLE @ MIDDLE)[:3, 3]
        found += [
            _move("arc", TABLE @ EDGE, GRIPPER, speed=0.15, blend=10 * MM, via=via),
            _move("linear", RACK @ SHELF, PROBE, speed=0.3, blend=0.0),
            _output(False),
        ]
        parts -= 1
    else:
        found.append(_move("linear", TABLE @ PICK, GRIPPER, speed=0.25))
    return [*found, *[OracleEvent("wait", seconds=0.1)] * parts, last]


def _output(on: bool) -> OracleEvent:
    return OracleEvent("output", signal=OUTPUT, on=on)


def _move(kind: str, place: Array, tool: Array, **more: Any) -> OracleEvent:
    return OracleEvent(kind, place, place @ np.linalg.inv(tool), **more)


def joint_speeds_of(found: list[OracleEvent]) -> str:
    """The kind of speed that the joint moves of a plan have: a key of JOINT_SPEEDS."""
    first = next((one for one in found if one.kind == "joint"), None)
    kinds = [kind for kind in JOINT_SPEEDS if first is not None and not math.isnan(getattr(first, kind))]
    return kinds[0] if kinds else "share"


def with_parts(program: Program, parts: int) -> Program:
    """The program with another number of parts where it begins: what it takes the other branch for."""

    def changed(statement: Any) -> Any:
        starts = isinstance(statement, Assign | Declare) and statement.value == Number(PARTS)
        return replace(statement, value=Number(parts)) if starts else statement

    routines = tuple(
        replace(r, body=tuple(map(changed, r.body)), data=tuple(map(changed, r.data)))
        for r in program.routines
    )
    return replace(program, routines=routines, data=tuple(map(changed, program.data)))


# --- samples --------------------------------------------------------------------------------------------------


def samples_folder(vendor: Vendor, samples: Path | None = None) -> Path:
    """Where the vendor's samples are: `samples`, or the checkout's `samples/NAME`."""
    return samples or Path(__file__).resolve().parents[2] / "samples" / vendor.name


def files_of(vendor: Vendor, folder: Path) -> Iterator[Path]:
    """All files of the language in a folder, sorted; none of a folder called `broken`."""
    for path in sorted(folder.rglob("*")):
        if path.suffix.lower() in vendor.suffixes and "broken" not in path.relative_to(folder).parts:
            yield path


def main_of(vendor: Vendor, folder: Path) -> Path | None:
    """The handling program: `handling.*`, or `start.*` where a program is a folder of files."""
    found = [path for path in files_of(vendor, folder) if path.suffix.lower() not in vendor.data_suffixes]
    for stem in ("handling", "start"):
        named = [path for path in found if path.stem.lower() == stem]
        if named:
            return min(named, key=lambda path: vendor.suffixes.index(path.suffix.lower()))
    return None


class HandlingSample:
    """A vendor and its handling program, found once."""

    def __init__(self, vendor: Vendor, samples: Path | None) -> None:
        self.vendor = vendor
        self.folder = samples_folder(vendor, samples)

    @cached_property
    def main(self) -> Path:
        found = main_of(self.vendor, self.folder)
        assert found is not None, f"{self.folder} has no handling program (handling{self.vendor.suffixes[0]})"
        return found


def text_of(vendor: Vendor, folder: Path) -> str:
    """The text of the handling program and of all files beside it."""
    main = main_of(vendor, folder)
    if main is None:
        return ""
    beside = sorted(path for path in main.parent.iterdir() if path.is_file() and path.suffix != ".md")
    return "\n".join(path.read_bytes().decode("utf-8", "replace") for path in beside)
