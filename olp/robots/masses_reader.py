"""The table `[dynamics]` of a robot file -> `Dynamics`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final, TypeVar, cast

import numpy as np

from olp.core.units import mm
from olp.robots.document import RobotDocument, Table
from olp.robots.masses import NO_INERTIA, Body, Drive, Dynamics, Inertia, Vector

T = TypeVar("T")
_BODY_KEYS: Final = ("axis", "mass_kg", "centre_mm", "inertia_kg_m2")
_TURNING: Final = ("torque_nm", "rotor_inertia_kg_m2", "viscous_nm_s_rad", "coulomb_nm")
_SLIDING: Final = ("force_n", "rotor_mass_kg", "viscous_n_s_m", "coulomb_n")
# Published inertias are rounded to four digits, which can make the smallest principal moment negative.
_ROUNDING: Final = 5e-5  # [kg m²]


def read_dynamics(document: RobotDocument, names: Sequence[str], linear: Sequence[bool]) -> Dynamics | None:
    """The masses and drives of a machine whose axes have these names, None when the file states none.

    Problems go to the document: R003 unknown key, R004 missing, R005 wrong value.
    """
    table = document.subtable("dynamics")
    if table is None:
        return None
    start = document.table_start("dynamics")
    document.known_keys(table, ("bodies", "drives"), "dynamics", start)

    def body(row: Table, at: int, _: bool) -> Body:
        return _body(document, row, at)

    def drive(row: Table, at: int, slides: bool) -> Drive:
        return _drive(document, row, at, slides)

    bodies = _rows(document, table, "bodies", names, linear, body)
    drives = _rows(document, table, "drives", names, linear, drive)
    missing = [name for name in names if name not in bodies]
    if missing:
        document.report("R004", f"dynamics needs a body for {', '.join(missing)}", "bodies", start)
        return None
    points = tuple(name for name in names if bodies[name].mass > 0.0 and bodies[name].inertia == NO_INERTIA)
    return Dynamics(
        tuple(bodies[name] for name in names), tuple(drives.get(name, Drive()) for name in names), points
    )


def _rows(
    document: RobotDocument,
    table: Table,
    key: str,
    names: Sequence[str],
    linear: Sequence[bool],
    read: Callable[[Table, int, bool], T],
) -> dict[str, T]:
    found: dict[str, T] = {}
    for i, row in enumerate(document.tables(table, key)):
        start = document.item_start(key, i)
        name = row.get("axis")
        if name not in names:
            document.report("R005", f"axis must be one of {', '.join(names)}, not {name!r}", "axis", start)
        elif name in found:
            document.report("R005", f"{key} names axis {name} twice", "axis", start)
        else:
            found[cast(str, name)] = read(row, start, linear[names.index(cast(str, name))])
    return found


def _body(document: RobotDocument, row: Table, start: int) -> Body:
    document.known_keys(row, _BODY_KEYS, "a body", start)
    if "mass_kg" not in row:
        document.report("R004", f"the body of axis {row['axis']} needs mass_kg", "axis", start)
    centre = document.numbers(row, "centre_mm", 3, start) or (0.0, 0.0, 0.0)
    inertia = cast(Inertia, document.numbers(row, "inertia_kg_m2", 6, start) or NO_INERTIA)
    if np.linalg.eigvalsh(tensor(inertia))[0] < -_ROUNDING:
        message = f"inertia_kg_m2 is xx, yy, zz, xy, xz, yz of a tensor without negative moments, not {list(inertia)}"
        document.report("R005", message, "inertia_kg_m2", start)
    mass = _not_negative(document, row, "mass_kg", start) or 0.0
    return Body(mass, cast(Vector, tuple(value * mm for value in centre)), inertia)


def _drive(document: RobotDocument, row: Table, start: int, slides: bool) -> Drive:
    keys = _SLIDING if slides else _TURNING
    document.known_keys(row, ("axis", *keys), "the drive of a sliding axis" if slides else "a drive", start)
    limit, rotor, viscous, coulomb = (_not_negative(document, row, key, start) for key in keys)
    return Drive(limit, rotor or 0.0, viscous or 0.0, coulomb or 0.0)


def _not_negative(document: RobotDocument, row: Table, key: str, start: int) -> float | None:
    value = document.number(row, key, start)
    if value is not None and value < 0.0:
        document.report("R005", f"{key} must not be negative, not {value!r}", key, start)
    return value


def tensor(inertia: Inertia) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """(3, 3) [kg m²] of xx, yy, zz, xy, xz, yz."""
    xx, yy, zz, xy, xz, yz = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
