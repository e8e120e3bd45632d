"""Robot files, read and checked, and the library that ships with olp.

A robot file (TOML in mm, degrees, pulses, ms) becomes a `Robot` (SI); units are converted here and nowhere else.
The library finds a robot by its name or path, and robots whose limits fit given pulses.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, Final, Literal, TypeVar, cast

import numpy as np

from olp.core.diagnostic import Diagnostic, OlpError, Span, error, raise_errors
from olp.core.toml import TOMLDecodeError, is_number, is_told_enough, parse_toml, toml_text
from olp.core.units import deg, mm, ms
from olp.robots.model import (
    FLANGE_AT_ZERO,
    NO_INERTIA,
    Axis,
    Body,
    Drive,
    Dynamics,
    Geometry,
    Inertia,
    Joint,
    Kind,
    Lean,
    Lift,
    Links,
    PoseAccelerations,
    PulseFit,
    Robot,
    Swing,
    Vector,
    tensor,
)

_KINDS: Final = ("arm", "positioner", "track")
_ROOT_KEYS: Final = (
    "model", "maker", "kind", "controllers", "pose_verified", "inferred", "axes", "links", "chain",
    "dynamics", "sources", "blend_zones_mm", "linear_acceleration_mm_s2", "settling_time_s", "payload_kg",
    "acceleration_filter_s", "pose_accelerations",
)  # fmt: skip
_TURNING: Final = (
    "name", "lower_deg", "upper_deg", "speed_deg_s", "acceleration_deg_s2", "acceleration_rad_s2",
    "acceleration_time_ms", "pulses_per_deg",
)  # fmt: skip
_SLIDING: Final = (
    "name", "lower_mm", "upper_mm", "speed_mm_s", "acceleration_mm_s2", "acceleration_time_ms",
    "pulses_per_mm",
)  # fmt: skip
_LINK_KEYS: Final = ("a1_mm", "a2_mm", "a3_mm", "d4_mm", "d6_mm")
_STANCE_KEYS: Final = ("base_height_mm", "signs", "zero_deg", "origin_below_mm", "third_to_horizontal")
Rows = tuple[Vector, Vector, Vector]
_IDENTITY: Final[Rows] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_DIRECTIONS: Final[dict[str, Vector]] = {
    f"{sign}{name}": cast(Vector, tuple(value if i == j else 0.0 for j in range(3)))
    for i, name in enumerate("xyz")
    for sign, value in (("+", 1.0), ("-", -1.0))
}
# The one arm whose poses were checked; all arms given by link lengths alone are built the same way.
_STANDARD_AXES: Final = ((2, 1.0), (1, 1.0), (1, -1.0), (0, -1.0), (1, -1.0), (0, -1.0))


def read_robot(path: Path, name: str | None = None) -> Robot:
    """The robot of the file `path`, called `name` or maker/model.

    Raises OlpError with all problems: R002 unreadable, R003 unknown key, R004 missing, R005 wrong value,
    R006 numbers without a source.
    """
    document = RobotDocument(path)
    root = document.root
    document.known_keys(root, _ROOT_KEYS, "a robot file")
    maker, model = document.word(root, "maker"), document.word(root, "model")
    if maker is None or model is None:
        document.report("R004", "maker and model are needed", help='maker = "Yaskawa", model = "GP25"')
    axes = _axes(document)
    geometry = _geometry(document, axes)
    zones = document.numbers(root, "blend_zones_mm", 8)
    linear = document.number(root, "linear_acceleration_mm_s2", above=0.0)
    kind = root.get("kind", "arm")
    if kind not in _KINDS:
        document.report("R005", f"kind must be one of {', '.join(_KINDS)}, not {kind!r}", "kind")
    verified = root.get("pose_verified", False)
    if not isinstance(verified, bool):
        document.report("R005", f"pose_verified must be true or false, not {verified!r}", "pose_verified")
    robot = Robot(
        name=name or f"{maker}/{model}".lower().replace(" ", "-"),
        maker=maker or "",
        model=model or "",
        axes=axes,
        kind=cast(Kind, kind),
        controllers=document.words(root, "controllers"),
        geometry=geometry,
        dynamics=read_dynamics(document, [axis.name for axis in axes], [axis.linear for axis in axes]),
        blend_zones=None if zones is None else tuple(zone * mm for zone in zones),
        linear_acceleration=None if linear is None else linear * mm,
        settling_time=document.number(root, "settling_time_s", above=0.0),
        acceleration_filter=document.number(root, "acceleration_filter_s", above=0.0),
        pose_accelerations=_pose_accelerations(document),
        payload=document.number(root, "payload_kg", above=0.0),
        pose_verified=bool(verified),
        sources=read_sources(document),
        inferred=document.words(root, "inferred"),
    )
    check_sources(document, robot)
    raise_errors(document.problems)
    return robot


def _axes(document: RobotDocument) -> tuple[Axis, ...]:
    rows = document.tables(document.root, "axes")
    if not rows:
        document.report(
            "R004", "axes are needed", "axes", help="axes = [ { name = ..., lower_deg = ..., ... }, ... ]"
        )
    axes = tuple(_axis(document, row, document.item_start("axes", i)) for i, row in enumerate(rows))
    names = [axis.name for axis in axes]
    for name in sorted({name for name in names if name and names.count(name) > 1}):
        document.report("R005", f"two axes are called {name}", f'"{name}"', document.table_start("axes"))
    return axes


def _axis(document: RobotDocument, row: Table, start: int) -> Axis:
    linear = any(key in row for key in ("lower_mm", "upper_mm", "speed_mm_s", "pulses_per_mm"))
    unit, scale = ("mm", mm) if linear else ("deg", deg)
    document.known_keys(
        row, _SLIDING if linear else _TURNING, "a linear axis" if linear else "an axis", start
    )
    needed = ("name", f"lower_{unit}", f"upper_{unit}", f"speed_{unit}_s")
    missing = [key for key in needed if key not in row]
    if missing:
        document.report("R004", f"axis {row.get('name', '?')} needs {', '.join(missing)}", "name", start)
    lower = document.number(row, f"lower_{unit}", start)
    upper = document.number(row, f"upper_{unit}", start)
    if lower is not None and upper is not None and lower >= upper:
        document.report("R005", f"lower_{unit} must be below upper_{unit}", f"lower_{unit}", start)
    speed = document.number(row, f"speed_{unit}_s", start, above=0.0) or 1.0
    pulses = document.number(row, f"pulses_per_{unit}", start)
    if pulses == 0.0:
        document.report("R005", f"pulses_per_{unit} must not be 0", f"pulses_per_{unit}", start)
    return Axis(
        name=document.word(row, "name", start) or "",
        lower=(lower or 0.0) * scale,
        upper=(upper or 0.0) * scale,
        speed=speed * scale,
        acceleration=_acceleration(document, row, start, speed * scale, linear),
        pulses_per_unit=None if pulses is None else pulses / scale,
        linear=linear,
    )


def _acceleration(
    document: RobotDocument, row: Table, start: int, speed: float, linear: bool
) -> float | None:
    """Acceleration [rad/s² | m/s²] from one of its three keys; a time is that from rest to rated speed."""
    ways = {"acceleration_mm_s2": mm} if linear else {"acceleration_deg_s2": deg, "acceleration_rad_s2": 1.0}
    given = [key for key in (*ways, "acceleration_time_ms") if key in row]
    if len(given) > 1:
        document.report(
            "R005", f"state the acceleration once, not as {' and as '.join(given)}", given[1], start
        )
    for key in given:
        value = document.number(row, key, start, above=0.0)
        if value is not None:
            return speed / (value * ms) if key == "acceleration_time_ms" else value * ways[key]
    return None


def _geometry(document: RobotDocument, axes: tuple[Axis, ...]) -> Geometry | None:
    links, chain = document.subtable("links"), document.subtable("chain")
    if links is not None and chain is not None:
        document.report(
            "R005", "state the geometry once: links or chain", "chain", document.table_start("chain")
        )
    if links is not None:
        return _wrist_arm(document, links, len(axes))
    return None if chain is None else _chain(document, chain, [axis.name for axis in axes])


def _wrist_arm(document: RobotDocument, links: Table, count: int) -> Geometry | None:
    start = document.table_start("links")
    document.known_keys(links, (*_LINK_KEYS, *_STANCE_KEYS), "links", start)
    values = [document.number(links, key, start) for key in _LINK_KEYS]
    missing = [key for key in _LINK_KEYS if key not in links]
    if missing:
        document.report("R004", f"links needs {', '.join(missing)}", "links", start)
    if count != 6:
        document.report(
            "R005", f"links describe six axes, not {count}", "links", start, "use [chain] instead"
        )
    height = document.number(links, "base_height_mm", start)
    signs = document.numbers(links, "signs", 6, start) or (1.0,) * 6
    if any(abs(sign) != 1.0 for sign in signs):
        document.report("R005", f"signs must be 1 or -1, not {list(signs)}", "signs", start)
    zeros = tuple(value * deg for value in document.numbers(links, "zero_deg", 6, start) or (0.0,) * 6)
    below = (document.number(links, "origin_below_mm", start) or 0.0) * mm
    horizontal = links.get("third_to_horizontal", False)
    if not isinstance(horizontal, bool):
        message = f"third_to_horizontal must be true or false, not {horizontal!r}"
        document.report("R005", message, "third_to_horizontal", start)
    if any(value is None for value in values):
        return None
    a1, a2, a3, d4, d6 = (value * mm for value in values if value is not None)
    turning = tuple(int(sign) for sign in signs)
    numbers = Links(a1, a2, a3, d4, d6, turning, zeros, below, horizontal is True)
    if numbers.a2 <= 0.0 or numbers.d4 <= 0.0:
        document.report("R005", "a2_mm and d4_mm must be greater than 0", "a2_mm", start)
    return wrist_geometry(numbers, None if height is None else height * mm)


def wrist_geometry(links: Links, base_height: float | None) -> Geometry:
    """The chain of a six-axis arm with a spherical wrist; `base_height` [m]."""
    offsets = [(0.0, 0.0, links.height), (links.a1, 0.0, 0.0), (0.0, 0.0, links.a2), (0.0, 0.0, links.a3)]
    offsets += [(links.d4, 0.0, 0.0), (links.d6, 0.0, 0.0)]
    stance = _IDENTITY
    joints = []
    for i, (axis, sense) in enumerate(_STANDARD_AXES):
        column = cast(Vector, tuple(row[axis] * sense * links.signs[i] for row in stance))
        joints.append(Joint(i, column, _times(stance, offsets[i])))
        stance = _turned(stance, axis, sense * links.zeros[i])
    columns = (_times(stance, column) for column in zip(*FLANGE_AT_ZERO, strict=True))
    flange = cast(Rows, tuple(zip(*columns, strict=True)))
    return Geometry(tuple(joints), (0.0, 0.0, 0.0), flange, links, base_height)


def _turned(rows: Rows, axis: int, angle: float) -> Rows:
    """`rows` times the rotation by `angle` [rad] about its own coordinate axis `axis`."""
    # Zeros are multiples of 90 deg in practice: 6e-17 instead of 0 would make every exact test fuzzy.
    cosine, sine = (0.0 if abs(v) < 1e-15 else v for v in (math.cos(angle), math.sin(angle)))
    u, v = (axis + 1) % 3, (axis + 2) % 3
    result = [list(row) for row in rows]
    for row in result:
        row[u], row[v] = row[u] * cosine + row[v] * sine, row[v] * cosine - row[u] * sine
    return cast(Rows, tuple(tuple(row) for row in result))


def _times(rows: Rows, vector: Vector) -> Vector:
    return cast(Vector, tuple(sum(a * b for a, b in zip(row, vector, strict=True)) for row in rows))


def _chain(document: RobotDocument, chain: Table, names: list[str]) -> Geometry | None:
    start = document.table_start("chain")
    keys = ("joints", "flange_offset_mm", "flange_x", "flange_z", "base_height_mm")
    document.known_keys(chain, keys, "chain", start)
    rows = document.tables(chain, "joints")
    before = len(document.problems)
    joints = tuple(
        _joint(document, row, document.item_start("joints", i), names) for i, row in enumerate(rows)
    )
    if len(document.problems) == before and sorted(joint.axis for joint in joints) != list(range(len(names))):
        document.report("R005", f"chain needs one joint for each of {', '.join(names)}", "joints", start)
    height = document.number(chain, "base_height_mm", start)
    return Geometry(
        joints,
        _offset(document, chain, "flange_offset_mm", start),
        _flange(document, chain, start),
        None,
        None if height is None else height * mm,
    )


def _joint(document: RobotDocument, row: Table, start: int, names: list[str]) -> Joint:
    document.known_keys(row, ("axis", "direction", "offset_mm"), "a joint", start)
    axis = row.get("axis")
    if axis not in names:
        document.report("R005", f"axis must be one of {', '.join(names)}, not {axis!r}", "axis", start)
    direction = _direction(document, row, "direction", start)
    index = names.index(axis) if isinstance(axis, str) and axis in names else 0
    return Joint(index, direction or (0.0, 0.0, 1.0), _offset(document, row, "offset_mm", start))


def _direction(
    document: RobotDocument, row: Table, key: Literal["direction", "flange_x", "flange_z"], start: int
) -> Vector | None:
    value = row.get(key)
    if isinstance(value, str) and value in _DIRECTIONS:
        return _DIRECTIONS[value]
    numbers = document.numbers(row, key, 3, start) if isinstance(value, list) else None
    length = math.hypot(*numbers) if numbers else 0.0
    if numbers and length > 0.0:
        return cast(Vector, tuple(number / length for number in numbers))
    document.report(
        "R005", f"{key} must be one of {', '.join(_DIRECTIONS)} or three numbers, not {value!r}", key, start
    )
    return None


def _offset(document: RobotDocument, row: Table, key: str, start: int) -> Vector:
    numbers = document.numbers(row, key, 3, start) or (0.0, 0.0, 0.0)
    return cast(Vector, tuple(number * mm for number in numbers))


def _flange(document: RobotDocument, chain: Table, start: int) -> Rows:
    """Rows of the flange's rotation at zero, from its x and z directions."""
    if "flange_x" not in chain and "flange_z" not in chain:
        return FLANGE_AT_ZERO
    x, z = _direction(document, chain, "flange_x", start), _direction(document, chain, "flange_z", start)
    if x is None or z is None:
        return FLANGE_AT_ZERO
    if abs(sum(a * b for a, b in zip(x, z, strict=True))) > 1e-9:
        document.report("R005", "flange_x and flange_z must be perpendicular", "flange_x", start)
    y = (z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0])
    return cast(Rows, tuple(zip(x, y, z, strict=True)))


# --- Accelerations by pose ---
# The table `[pose_accelerations]` of a robot file -> `PoseAccelerations`: its keys are the fields with their units.

_SWING_KEYS: Final = (
    "fixed_s2_rad", "elbow_s2_rad_m2", "forearm_s2_rad_m2", "ahead_m", "above_m", "cap_rad_s2",
)  # fmt: skip
_LEAN_KEYS: Final = ("fixed_s2_rad", "cosine_s2_rad", "sine_s2_rad", "gravity", "both")
_LIFT_KEYS: Final = (
    "offset_rad", "start", "width", "high_rad_s2", "drop_rad_s2", "lever_rad_s2", "eased_rad_s2",
)  # fmt: skip
_VECTORS: Final = ("gravity", "both")  # four parts each
_RANGE_KEYS: Final = ("lowest_rad_s2", "highest_rad_s2")


def _pose_accelerations(document: RobotDocument) -> PoseAccelerations | None:
    table = document.subtable("pose_accelerations")
    if table is None:
        return None
    start, before = document.table_start("pose_accelerations"), len(document.problems)
    document.known_keys(table, ("swing", "lean", "lift", *_RANGE_KEYS), "pose_accelerations", start)
    swing, lean, lift = (
        _law_of_axis(document, table, key, keys)
        for key, keys in (("swing", _SWING_KEYS), ("lean", _LEAN_KEYS), ("lift", _LIFT_KEYS))
    )
    lowest, highest = (document.numbers(table, key, 3, start) for key in _RANGE_KEYS)
    for key in _RANGE_KEYS:
        if key not in table:
            document.report("R004", f"pose_accelerations needs {key}", "pose_accelerations", start)
    if len(document.problems) > before or lowest is None or highest is None:
        return None
    ranges = tuple(zip(lowest, highest, strict=True))
    if any(not 0.0 < low < high for low, high in ranges) or lift[2] <= 0.0:
        says = "each of lowest_rad_s2 must be above 0 and below that of highest_rad_s2, and width above 0"
        document.report("R005", says, "pose_accelerations", start)
    return PoseAccelerations(Swing(*swing), Lean(*lean), Lift(*lift), (ranges[0], ranges[1], ranges[2]))


def _law_of_axis(document: RobotDocument, table: Table, name: str, keys: Sequence[str]) -> list[Any]:
    """The values of one axis' inline table, in the order of `keys`; problems go to the document."""
    row, start = table.get(name), document.table_start(name)
    if not isinstance(row, dict):
        document.report("R004", f"pose_accelerations needs {name} = {{ ... }}", "pose_accelerations")
        return []
    document.known_keys(row, keys, name, start)
    missing = [key for key in keys if key not in row]
    if missing:
        document.report("R004", f"{name} needs {', '.join(missing)}", name, start)
    return [
        document.numbers(row, key, 4, start) if key in _VECTORS else document.number(row, key, start)
        for key in keys
    ]


# --- Masses reader ---
# The table `[dynamics]` of a robot file -> `Dynamics`.

T = TypeVar("T")
_BODY_KEYS: Final = ("axis", "mass_kg", "centre_mm", "inertia_kg_m2")
_MASSES_READER_TURNING: Final = ("torque_nm", "rotor_inertia_kg_m2", "viscous_nm_s_rad", "coulomb_nm")
_MASSES_READER_SLIDING: Final = ("force_n", "rotor_mass_kg", "viscous_n_s_m", "coulomb_n")
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
    keys = _MASSES_READER_SLIDING if slides else _MASSES_READER_TURNING
    document.known_keys(row, ("axis", *keys), "the drive of a sliding axis" if slides else "a drive", start)
    limit, rotor, viscous, coulomb = (_not_negative(document, row, key, start) for key in keys)
    return Drive(limit, rotor or 0.0, viscous or 0.0, coulomb or 0.0)


def _not_negative(document: RobotDocument, row: Table, key: str, start: int) -> float | None:
    value = document.number(row, key, start)
    if value is not None and value < 0.0:
        document.report("R005", f"{key} must not be negative, not {value!r}", key, start)
    return value


# --- Sources ---
# Every group of numbers in a robot file names its source: which groups there are, and the check.

SOURCE_GROUPS: Final = (
    "limits", "speed", "acceleration", "pulses", "links", "chain", "base_height", "blend_zones",
    "linear_acceleration", "settling_time", "acceleration_filter", "pose_accelerations", "payload", "pose",
    "masses", "inertias", "torque_limits", "rotors", "friction",
)  # fmt: skip


def number_groups(robot: Robot) -> tuple[str, ...]:
    """The groups of numbers in `robot`, each of which needs an entry in its `sources`."""
    geometry = robot.geometry
    bodies = robot.dynamics.bodies if robot.dynamics else ()
    drives = robot.dynamics.drives if robot.dynamics else ()
    held = {
        "limits": True,
        "speed": True,
        "acceleration": any(axis.acceleration is not None for axis in robot.axes),
        "pulses": any(axis.pulses_per_unit is not None for axis in robot.axes),
        "links": geometry is not None and geometry.links is not None,
        "chain": geometry is not None and geometry.links is None,
        "base_height": geometry is not None and geometry.base_height is not None,
        "blend_zones": robot.blend_zones is not None,
        "linear_acceleration": robot.linear_acceleration is not None,
        "settling_time": robot.settling_time is not None,
        "acceleration_filter": robot.acceleration_filter is not None,
        "pose_accelerations": robot.pose_accelerations is not None,
        "payload": robot.payload is not None,
        "pose": robot.pose_verified,
        "masses": bool(bodies),
        "inertias": any(any(body.inertia) for body in bodies),
        "torque_limits": any(drive.limit is not None for drive in drives),
        "rotors": any(drive.rotor for drive in drives),
        "friction": any(drive.viscous or drive.coulomb for drive in drives),
    }
    return tuple(group for group in SOURCE_GROUPS if held[group])


def read_sources(document: RobotDocument) -> dict[str, str]:
    """The table `[sources]`; its unknown keys are reported (R003)."""
    table = document.subtable("sources") or {}
    start = document.table_start("sources")
    document.known_keys(table, SOURCE_GROUPS, "sources", start)
    return {key: document.word(table, key, start) or "" for key in table}


def check_sources(document: RobotDocument, robot: Robot) -> None:
    """Reports groups of numbers without a source (R006), and inferred groups that the robot lacks (R005)."""
    groups = number_groups(robot)
    missing = [group for group in groups if group not in robot.sources]
    if missing:
        advice = f'[sources] {missing[0]} = "data sheet of ..., page ..., or how it was measured"'
        document.report("R006", f"no source is stated for: {', '.join(missing)}", "sources", help=advice)
    for group in robot.inferred:
        if group not in groups:
            document.report("R005", f"inferred names {group!r}, which the file does not hold", "inferred")


# --- Document ---
# A TOML document that remembers where its keys stand, so that every problem can be shown with its line.

Table = Mapping[str, Any]


class RobotDocument:
    """The parsed file, its text, and the problems found so far."""

    def __init__(self, path: Path) -> None:
        """Parse the file. Raises OlpError (R002) when it cannot be read or is not TOML."""
        self.file = str(path)
        try:
            self.text = toml_text(path)
            self.root: Table = parse_toml(self.text)
        except OSError as problem:
            reason = problem.strerror or "cannot be read"
            raise OlpError(error("R002", f"robot file: {reason}", file=self.file)) from None
        except UnicodeDecodeError:
            raise OlpError(error("R002", "robot file is not UTF-8 text", file=self.file)) from None
        except TOMLDecodeError as problem:
            raise OlpError(self._syntax(str(problem))) from None
        self.problems: list[Diagnostic] = []

    def report(self, code: str, message: str, key: str = "", after: int = 0, help: str = "") -> None:
        """Add a problem, located at the first occurrence of `key` at or after character `after`."""
        if is_told_enough(self.problems, code, self.file):
            return
        line, column, end = self._span(key, after)
        span, row = (Span(line, column, end), self._row(line)) if line else (None, "")
        self.problems.append(error(code, message, span, file=self.file, help=help, source_line=row))

    def table_start(self, key: str) -> int:
        """Character at which the table `[key]` or the value of `key` starts."""
        match = re.search(
            rf"^\s*(\[+\s*{re.escape(key)}\s*\]+|{re.escape(key)}\s*=)", self.text, re.MULTILINE
        )
        return match.start() if match else 0

    def item_start(self, key: str, index: int) -> int:
        """Character at which entry `index` (from 0) of the array of tables `key` starts."""
        begin = self.table_start(key)
        starts = [
            m.start()
            for m in re.finditer(rf"\{{|^\s*\[\[\s*{re.escape(key)}", self.text[begin:], re.MULTILINE)
        ]
        return begin + (starts[index] if index < len(starts) else 0)

    def known_keys(self, table: Table, known: Collection[str], what: str, after: int = 0) -> None:
        """Reports unknown keys of `table` (R003), with the closest known ones."""
        for key in table:
            if key not in known and not is_told_enough(self.problems, "R003", self.file):
                close = difflib.get_close_matches(key, known, n=1, cutoff=0.6)
                advice = f"did you mean {close[0]}?" if close else f"known: {', '.join(known)}"
                self.report("R003", f"{what} has no key {key!r}", key, after, advice)

    def number(self, table: Table, key: str, after: int = 0, above: float = -math.inf) -> float | None:
        """The finite number under `key`; None when it is absent or not a number (R005)."""
        if key not in table:
            return None
        value = table[key]
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            self.report("R005", f"{key} must be a number, not {value!r}", key, after)
            return None
        if value <= above:
            self.report("R005", f"{key} must be greater than {above:g}, not {value!r}", key, after)
            return None
        return float(value)

    def numbers(self, table: Table, key: str, count: int, after: int = 0) -> tuple[float, ...] | None:
        """`count` finite numbers under `key`; None when they are absent or not such numbers (R005)."""
        if key not in table:
            return None
        value = table[key]
        good = isinstance(value, list) and len(value) == count
        if not good or not all(is_number(v) for v in value):
            self.report("R005", f"{key} must be {count} numbers in brackets, not {value!r}", key, after)
            return None
        return tuple(float(v) for v in value)

    def word(self, table: Table, key: str, after: int = 0) -> str | None:
        """The text under `key`; None when it is absent or not text (R005)."""
        value = table.get(key)
        if value is None or (isinstance(value, str) and value.strip()):
            return value
        self.report("R005", f"{key} must be text in quotes, not {value!r}", key, after)
        return None

    def words(self, table: Table, key: str) -> tuple[str, ...]:
        value = table.get(key, [])
        if isinstance(value, list) and all(isinstance(v, str) for v in value):
            return tuple(value)
        self.report("R005", f"{key} must be a list of texts, not {value!r}", key)
        return ()

    def subtable(self, key: str) -> Table | None:
        value = self.root.get(key)
        if value is None or isinstance(value, dict):
            return value
        self.report("R005", f"{key} must be a table, not {value!r}", key)
        return None

    def tables(self, table: Table, key: str) -> Sequence[Table]:
        value = table.get(key, [])
        if isinstance(value, list) and all(isinstance(v, dict) for v in value):
            return value
        self.report("R005", f"{key} must be a list of tables in braces", key)
        return []

    def _span(self, key: str, after: int) -> tuple[int, int, int]:
        if not key:
            return 0, 1, 1
        match = re.compile(rf"(?<![\w\-]){re.escape(key)}(?![\w\-])").search(self.text, after)
        if match is None:
            return 0, 1, 1
        start = self.text.rfind("\n", 0, match.start()) + 1
        return self.text.count("\n", 0, match.start()) + 1, match.start() - start + 1, match.end() - start + 1

    def _row(self, line: int) -> str:
        return self.text.split("\n")[line - 1]

    def _syntax(self, message: str) -> Diagnostic:
        place = re.search(r"\s*\(at line (\d+), column (\d+)\)", message)
        if place is None:
            return error("R002", f"not TOML: {message}", file=self.file)
        line, column = int(place[1]), int(place[2])
        words = message[: place.start()]
        span = Span(line, column, column + 1)
        return error("R002", f"not TOML: {words}", span, file=self.file, source_line=self._row(line))


_FOLDER = Path(__file__).parent

# Soft limits are set in whole pulses and a taught point may stand on one: 0.1 deg of slack per axis.
_LIMIT_SLACK = 0.00175  # [rad | m]


@cache
def robot_names() -> tuple[str, ...]:
    """All library names, "maker/model", sorted."""
    return tuple(sorted(f"{path.parent.name}/{path.stem}" for path in _FOLDER.glob("*/*.toml")))


def library_name(called: str) -> str:
    """The library's name for a controller's robot name: the longest model that it starts with (letters and digits);
    "" if none.
    """
    said = re.sub(r"[^a-z0-9]", "", called.lower())
    models = {name: re.sub(r"[^a-z0-9]", "", name.partition("/")[2]) for name in robot_names()}
    fitting = [name for name, model in models.items() if model and said.startswith(model)]
    return max(fitting, key=lambda name: len(models[name]), default="")


def load_robot(name_or_path: str | Path) -> Robot:
    """The robot of a library name ("yaskawa/gp25", or "gp25" when only one maker has it) or of a file.

    Raises OlpError: R001 no such robot or file, R002 to R006 the file's problems, all at once.

    Example:
        >>> import olp
        >>> olp.load_robot("yaskawa/gp25")
        <Robot yaskawa/gp25: arm, axes S L U R B T>
    """
    text = str(name_or_path)
    if text.lower().endswith(".toml") or isinstance(name_or_path, Path):
        return read_robot(Path(name_or_path))
    return _library_robot(_full_name(text))


def candidates_for_pulses(min_pulses: Sequence[float], max_pulses: Sequence[float]) -> list[PulseFit]:
    """Library robots whose limits include all of the pulses, those with the most used range first.

    `min_pulses` and `max_pulses` hold the smallest and largest pulse of each axis of one control group.
    """
    low, high = np.asarray(min_pulses, dtype=np.float64), np.asarray(max_pulses, dtype=np.float64)
    fits = []
    for name in _with_pulses():
        robot = _library_robot(name)
        if len(robot.axes) != len(low) or not robot.knows_pulses:
            continue
        start, end = low / robot.pulses_per_unit, high / robot.pulses_per_unit
        if np.all(start >= robot.lower - _LIMIT_SLACK) and np.all(end <= robot.upper + _LIMIT_SLACK):
            used = float(np.mean((end - start) / (robot.upper - robot.lower)))
            fits.append(PulseFit(robot, used))
    return sorted(fits, key=lambda fit: (-fit.used, fit.robot.name))


@cache
def _with_pulses() -> tuple[str, ...]:
    """Names of the robots whose files state pulses; reading all robot files would cost a small job more than its
    run.
    """
    return tuple(name for name in robot_names() if b"pulses_per_" in (_FOLDER / f"{name}.toml").read_bytes())


@lru_cache(maxsize=256)
def _library_robot(name: str) -> Robot:
    return read_robot(_FOLDER / f"{name}.toml", name)


def _full_name(text: str) -> str:
    wanted = text.strip().lower()
    names = robot_names()
    if wanted in names:
        return wanted
    same_model = [name for name in names if name.split("/")[1] == wanted]
    if len(same_model) == 1:
        return same_model[0]
    raise OlpError(_unknown(text, wanted, names))


def _unknown(text: str, wanted: str, names: Sequence[str]) -> Diagnostic:
    maker, _, model = wanted.rpartition("/")
    known = [name for name in names if name.startswith(f"{maker}/")]
    close = [] if maker and not known else _alike(model, known or names)
    if close:
        advice = f"did you mean {', '.join(close)}? "
    elif known:
        advice = f"known of {maker}: {', '.join(known)}; "
    else:
        advice = (
            f"no robot of {maker} is known yet, but you can describe any (docs/robots.md); " if maker else ""
        )
        advice += f"known makers: {', '.join(sorted({name.split('/')[0] for name in names}))}; "
    return error(
        "R001",
        f"no robot is called {text!r}",
        help=f"{advice}olp robots lists all; a file of your own is given as a path ending in .toml",
    )


def _alike(model: str, names: Sequence[str]) -> list[str]:
    """Robots whose model starts with `model`, else those with a similar name."""
    models = {name.split("/")[1]: name for name in names}
    longer = [name for it, name in models.items() if model and it.startswith(model)]
    return longer[:8] or [models[it] for it in difflib.get_close_matches(model, models, n=3, cutoff=0.5)]


__all__ = [
    "Axis",
    "Body",
    "Drive",
    "Dynamics",
    "Geometry",
    "Joint",
    "Links",
    "PulseFit",
    "Robot",
    "candidates_for_pulses",
    "load_robot",
    "read_robot",
    "robot_names",
]
