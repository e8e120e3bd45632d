"""What a program cannot tell about itself: `olp.toml` beside the jobs. `docs/assumptions.md` describes the file.

Inputs, how long a wait lasts, what an operator types, which robot it is. Whatever the file does not say, the
interpreter assumes in one documented way and reports.
"""

from __future__ import annotations

import difflib
import os
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, Final, NamedTuple, TypeVar

from olp.core.diagnostic import Diagnostic, Span, error
from olp.core.registry import member_names
from olp.core.toml import TOMLDecodeError, is_number, is_told_enough, parse_toml, toml_text
from olp.core.units import deg, mm, percent
from olp.ir.expressions import POSITION_STORES, Store
from olp.ir.points import PointKind, PointState
from olp.robots import EXAMPLE_ROBOT
from olp.robots.controller_effects import HIGHEST_OVERRIDE, SETTINGS

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
    "values": "a name without a value is 0, false or an empty text; a move to a position without one is left out",
    "first-move": "a program that would end before its first move has inputs and values with which it makes it",
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


@lru_cache(maxsize=64)  # every read of a signal asks
def holds_number(bus: str) -> bool:
    """Whether the signals of a bus are numbers; what one with a name alone is, is not known."""
    return any(word in bus for word in ("group", "analog", "register"))


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
    return read_assumptions(path)


# --- Assumptions reader ---
# Reads `olp.toml`: every key checked, every problem told with its line and what would have worked.

_SECTIONS: Final = (
    "robot",
    "robots",
    "inputs",
    "variables",
    "names",
    "tools",
    "frames",
    "waits",
    "process",
    "start",
    "motion",
    "known-routines",
    "unknown",
    "budget",  # read by olp check
    "lint",  # read by olp lint
)
_MOST_FRAMES: Final = 255  # that a controller numbers
_WAIT_KEYS: Final = ("default_s", "pause_s")
_POSITION_KEYS: Final = ("pulse", "joint_deg", "pose_mm_deg", "tool", "user", "frame")
_FRAMES: Final = ("base", "robot", "user")
# Kinds whose members olp.toml names: the package of the members and the module of their base.
_MOTION_WORDS: Final = {
    "model": ("olp.timing.motion", "model"),
    "acceleration_law": ("olp.timing.acceleration", "law"),
}
_MOTION_KEYS: Final = (*_MOTION_WORDS, "accel_mm_s2", *SETTINGS)
_MOTION_EXAMPLES: Final = {
    "model": 'model = "constant"',
    "acceleration_law": 'acceleration_law = "by_pose"',
    "accel_mm_s2": "accel_mm_s2 = 3050",
    "override_pct": "override_pct = 50, at most 150",
}
_CHOICES: Final = ("assume", "error")
_MECHANISM = re.compile(r"(RB|BS|ST)\d{1,2}")
_RANGES: Final = {
    Store.BYTE: (0, 255),
    Store.INTEGER: (-(2**15), 2**15 - 1),
    Store.DOUBLE: (-(2**31), 2**31 - 1),
}
_SECONDS = "_s"
UNREADABLE: Final = ("V001", "V002")  # nothing of an olp.toml holds; where one value is wrong, the rest does
T = TypeVar("T")
K = TypeVar("K")
Table = Mapping[str, Any]


def read_assumptions(path: Path) -> Assumptions:
    """The content of the file. Never raises: what is wrong is in `Assumptions.diagnostics`."""
    file = str(path)
    try:
        text = toml_text(path)
    except OSError as problem:
        why = problem.strerror or "cannot be read"
        return Assumptions(
            file, diagnostics=(error("V001", f"olp.toml: {why}", file=file, help="check the path"),)
        )
    except UnicodeDecodeError:
        return Assumptions(file, diagnostics=(error("V001", "olp.toml is not UTF-8 text", file=file),))
    try:
        root = parse_toml(text)
    except TOMLDecodeError as problem:
        return Assumptions(file, diagnostics=(_syntax(str(problem), file, text),))
    return _AssumptionsReader(file, text, root).read()


def _syntax(message: str, file: str, text: str) -> Diagnostic:
    place = re.search(r"\s*\(at line (\d+), column (\d+)\)", message)
    if place is None:
        return error("V002", f"not TOML: {message}", file=file, help="the last line is cut")
    line, column = int(place[1]), int(place[2])
    row = text.split("\n")[line - 1]
    return error(
        "V002",
        f"not TOML: {message[: place.start()]}",
        Span(line, column, column + 1),
        file=file,
        help='names with brackets need quotes: "IN#(12)" = true',
        source_line=row,
    )


class _AssumptionsReader:
    def __init__(self, file: str, text: str, root: Table) -> None:
        self.file, self.text, self.root = file, text, root
        self.problems: list[Diagnostic] = []
        self.section = ""

    def read(self) -> Assumptions:
        self._known(self.root, _SECTIONS, "olp.toml")
        robot = self.root.get("robot", "")
        if not isinstance(robot, str):
            self._report("V004", "robot must be a name in quotes", "robot", f'robot = "{EXAMPLE_ROBOT}"')
            robot = ""
        waits, default, pause = self._waits()
        return Assumptions(
            path=self.file,
            robot=robot,
            robots=self._entries("robots", _mechanism, self._text, f'RB1 = "{EXAMPLE_ROBOT}"'),
            inputs=self._entries("inputs", signal_key, self._states, '"IN#(12)" = true'),
            variables=self._variables(),
            names=self._entries("names", _plain_name, self._named, "fast = 250.0"),
            tools=self._entries("tools", _frame_number, self._pose, "1 = [0, 0, 187.4, 0, 15, 30]"),
            frames=self._entries(
                "frames", _frame_number, self._pose, "1 = [850.5, -210.25, 305.75, 0, 0, 33]"
            ),
            waits=waits,
            default_wait=default,
            pause=pause,
            process=self._process(),
            motion=self._motion(),
            routines=self._entries("known-routines", str.casefold, self._seconds, "USER_GRP = 0.8"),
            strict=self._strict(),
            start=self._entries("start", _mechanism, self._position, "RB1 = { pulse = [0, 0, 0, 0, 0, 0] }"),
            diagnostics=tuple(self.problems),
        )

    def _table(self, name: str) -> Table:
        self.section = name
        value = self.root.get(name, {})
        if isinstance(value, dict):
            return value
        self._report("V004", f"{name} must be a table", name, f"[{name}]")
        return {}

    def _entries(
        self,
        name: str,
        key_of: Callable[[str], K | None],
        value_of: Callable[[str, Any], T | None],
        example: str,
    ) -> dict[K, T]:
        found: dict[K, T] = {}
        for text, raw in self._table(name).items():
            key = key_of(text)
            if key is None:
                self._report("V003", f"[{name}] knows no {text[:60]!r}", text, f"for example {example}")
                continue
            value = value_of(text, raw)
            if value is not None:
                found[key] = value
        return found

    def _text(self, key: str, value: Any) -> str | None:
        if isinstance(value, str) and value.strip():
            return value
        self._report("V004", f"{key} must be a name in quotes", key, f'{key} = "{EXAMPLE_ROBOT}"')
        return None

    def _states(self, key: str, value: Any) -> tuple[int, ...] | None:
        values = value if isinstance(value, list) else [value]
        if values and all(isinstance(v, int) for v in values):
            return tuple(int(v) for v in values)
        help_text = f'"{key}" = true, or a list with one value per read, [false, true]'
        self._report(
            "V004", f"{key} must be true, false or a whole number, or a list of them", key, help_text
        )
        return None

    def _seconds(self, key: str, value: Any) -> float | None:
        if is_number(value) and value >= 0:
            return float(value)
        self._report("V004", f"{key} must be a time in seconds, zero or more", key, f'"{key}" = 0.8')
        return None

    def _waits(self) -> tuple[dict[SignalKey, float], float | None, float | None]:
        waits: dict[SignalKey, float] = {}
        plain: dict[str, float] = {}
        for text, raw in self._table("waits").items():
            key = signal_key(text)
            if key is None and text not in _WAIT_KEYS:
                self._unknown(text, _WAIT_KEYS, "[waits]", 'signals need quotes: "IN#(5)" = 1.2')
                continue
            seconds = self._seconds(text, raw)
            if seconds is not None and key is not None:
                waits[key] = seconds
            elif seconds is not None:
                plain[text] = seconds
        return waits, plain.get("default_s"), plain.get("pause_s")

    def _process(self) -> dict[str, float]:
        found: dict[str, float] = {}
        for text, raw in self._table("process").items():
            if not text.endswith(_SECONDS):
                help_text = f"write the unit into the name: {text}{_SECONDS} = 0.35"
                self._report("V003", f"[process] knows no {text[:60]!r}", text, help_text)
                continue
            seconds = self._seconds(text, raw)
            if seconds is not None:
                found[text.removesuffix(_SECONDS).lower()] = seconds
        return found

    def _strict(self) -> frozenset[str]:
        table = self._table("unknown")
        self._known(table, tuple(UNKNOWN), "[unknown]")
        for key, value in table.items():
            if value not in _CHOICES:
                self._report("V004", f"{key} is one of {', '.join(_CHOICES)}", key, f'{key} = "error"')
        return frozenset(key for key, value in table.items() if value == _CHOICES[1])

    def _motion(self) -> dict[str, str | float]:
        table = self._table("motion")
        self._known(table, _MOTION_KEYS, "[motion]")
        found: dict[str, str | float] = {}
        for key in _MOTION_KEYS:
            value = table.get(key)
            if key in _MOTION_WORDS and isinstance(value, str):
                if self._is_there(key, value):
                    found[key] = value
            elif key not in _MOTION_WORDS and is_number(value) and _in_range(key, value):
                found[key] = float(value)
            elif value is not None:
                example = _MOTION_EXAMPLES.get(key, f"{key} = 0.004")
                self._report("V004", f"{key} has the wrong kind of value", key, example)
        return found

    def _is_there(self, key: str, name: str) -> bool:
        """Whether there is such a motion model or acceleration law; reported if not."""
        names = member_names(*_MOTION_WORDS[key])
        if name not in names:
            what = "motion model" if key == "model" else "acceleration law"
            self._report("V004", f"there is no {what} {name[:60]!r}", key, f"available: {', '.join(names)}")
        return name in names

    def _variables(self) -> dict[tuple[Store, int], Given]:
        found: dict[tuple[Store, int], Given] = {}
        for text, raw in self._table("variables").items():
            key = variable_key(text)
            if key is None:
                self._report("V003", f"[variables] knows no {text[:60]!r}", text, "for example B010 = 3")
                continue
            value = self._variable(text, key[0], raw)
            if value is not None:
                found[key] = value
        return found

    def _variable(self, key: str, store: Store, value: Any) -> Given | None:
        if store in POSITION_STORES:
            return self._position(key, value)
        if store is Store.STRING and isinstance(value, str):
            return value
        if store is Store.REAL and is_number(value):
            return float(value)
        if store in _RANGES and isinstance(value, int):
            low, high = _RANGES[store]
            if low <= value <= high:
                return int(value)
            self._report("V004", f"{value} does not fit {key}", key, f"{low} .. {high}")
            return None
        self._report("V004", f"{key} cannot hold {value!r}"[:120], key, f"a {store.value} variable")
        return None

    def _named(self, key: str, value: Any) -> Given | None:
        if isinstance(value, dict):
            return self._position(key, value)
        if isinstance(value, (bool, str)) or is_number(value):
            return value
        self._report("V004", f"{key} must be a number, a text or a position", key, f"{key} = 250.0")
        return None

    def _pose(self, key: str, value: Any) -> tuple[float, ...] | None:
        """x y z [m], rx ry rz [rad] from mm and deg."""
        if isinstance(value, list) and len(value) == 6 and all(map(is_number, value)):
            return tuple(float(n) * (mm if i < 3 else deg) for i, n in enumerate(value))
        self._report(
            "V004",
            f"{key} must be six numbers: x y z in mm, rx ry rz in deg",
            key,
            f"{key} = [0, 0, 187.4, 0, 15, 30]",
        )
        return None

    def _position(self, key: str, value: Any) -> WrittenPosition | None:
        example = f"{key} = {{ pulse = [1200, -3400, 560, 0, 780, 90] }}"
        if not isinstance(value, dict):
            self._report("V004", f"{key} must be a position", key, example)
            return None
        self._known(value, _POSITION_KEYS, key)
        kinds = [name for name in _POSITION_KEYS[:3] if name in value]
        if len(kinds) != 1:
            self._report("V004", f"{key} needs one of pulse, joint_deg, pose_mm_deg", key, example)
            return None
        numbers = value[kinds[0]]
        if (
            not isinstance(numbers, list)
            or not numbers
            or len(numbers) > 8
            or not all(map(is_number, numbers))
        ):
            self._report("V004", f"{kinds[0]} must be up to 8 numbers in brackets", key, example)
            return None
        return self._written(key, kinds[0], [float(n) for n in numbers], value)

    def _written(self, key: str, kind: str, numbers: list[float], table: Table) -> WrittenPosition | None:
        tool, user = table.get("tool", 0), table.get("user")
        frame = table.get("frame", "base" if user is None else "user")
        if not isinstance(tool, int) or not isinstance(user, int | None) or frame not in _FRAMES:
            self._report(
                "V004",
                f"{key}: tool and user are numbers, frame is base, robot or user",
                key,
                f'{key} = {{ pose_mm_deg = [812.4, -33.1, 207.5, 178.2, 1.4, -29.8], frame = "base", tool = 1 }}',
            )
            return None
        if kind == "pulse":
            return WrittenPosition(PointState(PointKind.PULSE, "pulse", None, tool), tuple(numbers))
        if kind == "joint_deg":
            return WrittenPosition(
                PointState(PointKind.JOINT, "joint", None, tool), tuple(n * deg for n in numbers)
            )
        scaled = tuple(n * (mm if i < 3 else deg) for i, n in enumerate(numbers))
        return WrittenPosition(PointState(PointKind.POSE, frame, user, tool), scaled)

    def _known(self, table: Table, known: Collection[str], where: str) -> None:
        for key in table:
            if key not in known and not is_told_enough(self.problems, "V003", self.file):
                self._unknown(key, known, where, f"known: {', '.join(known)}")

    def _unknown(self, key: str, known: Collection[str], where: str, otherwise: str) -> None:
        close = difflib.get_close_matches(key, known, n=1, cutoff=0.6)
        self._report(
            "V003", f"{where} knows no {key[:60]!r}", key, f"did you mean {close[0]}?" if close else otherwise
        )

    def _report(self, code: str, message: str, key: str, help_text: str) -> None:
        if is_told_enough(self.problems, code, self.file):
            return
        line, column = self._place(key)
        span = Span(line, column, column + len(key)) if line else None
        row = self.text.split("\n")[line - 1].rstrip("\r") if line else ""
        self.problems.append(error(code, message, span, file=self.file, help=help_text, source_line=row))

    def _place(self, key: str) -> tuple[int, int]:
        """Line and column of a key, looked for below its section's head first."""
        head = (
            re.search(rf"^\s*\[\s*{re.escape(self.section)}\b", self.text, re.MULTILINE)
            if self.section
            else None
        )
        pattern = re.compile(rf"(?<![\w\-]){re.escape(key)}(?![\w\-])")
        match = pattern.search(self.text, head.end() if head else 0) or pattern.search(self.text)
        if match is None:
            return 0, 1
        start = self.text.rfind("\n", 0, match.start()) + 1
        return self.text.count("\n", 0, match.start()) + 1, match.start() - start + 1


def _in_range(key: str, value: float) -> bool:
    """Whether a number of [motion] can be used; times of effects may be zero."""
    if key == "override_pct":
        return 0 < value <= HIGHEST_OVERRIDE / percent
    return value > 0 or (value == 0 and key in SETTINGS)


def _mechanism(text: str) -> str | None:
    name = text.strip().upper()
    return name if _MECHANISM.fullmatch(name) else None


def _plain_name(text: str) -> str | None:
    return text.strip().casefold() if re.fullmatch(r"[$A-Za-z_][\w.$]*", text.strip()) else None


def _frame_number(text: str) -> int | None:
    return int(text) if text.strip().isdecimal() and int(text) <= _MOST_FRAMES else None
