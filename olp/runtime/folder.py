"""What stands in the folder of a job, read once for all jobs of the folder as long as nothing there changes.

It gives a program its world: mechanisms with their robots, tools, frames, blend zones, start values. Which arm the
programs are for is said by a robot file, a controller's backup, or a program's head.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from olp.core import source
from olp.core.diagnostic import Diagnostic, OlpError, Severity
from olp.core.files import read_input
from olp.ir.expressions import Store
from olp.languages.vendor import find_vendor, read
from olp.robots.coordinate_systems import Cell, Mechanism
from olp.robots.geometry import Pose
from olp.robots.kinematics.configuration import Tool
from olp.robots.robot import library_name, load_robot, robot_names
from olp.runtime.assumptions import Assumptions

if TYPE_CHECKING:
    from olp.ir.program import Program
    from olp.robots.backup.backup import Backup
    from olp.robots.model import Robot


# A name record stands in the first lines; whole files of 800 kB would take seconds in a large folder.
_HEAD = 4096
_NAME_RECORD = "//NAME "
_CONTROLLER_SUFFIXES = (".cnd", ".dat", ".prm", ".sys")


def files_by_stem(folder: Path, suffix: str) -> Mapping[str, Path]:
    """The files ending in `suffix` (whatever the case) by their stem in upper case."""
    return _by_stem(folder, _modified(folder), suffix.lower())


def files_by_name_record(folder: Path, suffix: str) -> Mapping[str, Path]:
    """The same files by the routine names in their heads."""
    return _by_name_record(folder, _modified(folder), suffix.lower())


def backup_of(folder: Path) -> Backup | None:
    """The controller files in `folder`, None when there are none."""
    names = [n for n in _names(folder, _modified(folder)) if n.lower().endswith(_CONTROLLER_SUFFIXES)]
    if not names:
        return None
    return _backup(folder, tuple((name, *_stamp(folder / name)) for name in names))


def robot_of_backup(backup: Backup, mechanism: str) -> Robot | None:
    """The robot of a mechanism from the controller's parameters, None when they do not hold it.

    Raises OlpError when they are implausible.
    """
    from olp.robots.backup.robot_file import robot_toml

    group = mechanism.replace("RB", "R").replace("BS", "B").replace("ST", "S")
    known = backup.system.groups if backup.system is not None else ()
    if group != "R1" and not any(g.name == group for g in known):
        return None
    return _parsed(robot_toml(backup, group, "" if known else "backup/r1"))


def read_cached(path: Path) -> Program:
    """`olp.read(path)`, once per state of the file. Raises OlpError like it."""
    return _read(path, _stamp(path))


@lru_cache(maxsize=256)
def _read(path: Path, _: tuple[int, int]) -> Program:
    return read(path)


def lower_case_cached(paths: tuple[Path, ...]) -> bytes:
    """The texts of files together, in lower case, read once per state of the files. Raises OSError."""
    return _lower_case(paths, tuple(map(_stamp, paths)))


@lru_cache(maxsize=256)
def _lower_case(paths: tuple[Path, ...], _: tuple[tuple[int, int], ...]) -> bytes:
    return b" ".join(source.load(path).raw.lower() for path in paths)


@lru_cache(maxsize=16)
def _backup(folder: Path, _: tuple[tuple[str, int, int], ...]) -> Backup:
    from olp.robots.backup.backup import read_backup

    return read_backup(folder)


@lru_cache(maxsize=16)
def _parsed(text: str) -> Robot:
    import tempfile

    from olp.robots.robot import read_robot

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "robot.toml"
        path.write_text(text, encoding="utf-8")
        return read_robot(path)


def _modified(folder: Path) -> int:
    return _stamp(folder)[0]


def _stamp(path: Path) -> tuple[int, int]:
    """(time of the last change [ns], size [bytes]); zeros where there is nothing. A text in an editor has its own."""
    edited = source.stamp(path)
    if edited is not None:
        return edited
    try:
        status = os.stat(path)
    except OSError:
        return 0, 0
    return status.st_mtime_ns, status.st_size


@lru_cache(maxsize=16)
def _names(folder: Path, _: int) -> tuple[str, ...]:
    try:
        with os.scandir(folder) as entries:
            return tuple(sorted(entry.name for entry in entries if entry.is_file()))
    except OSError:
        return ()


@lru_cache(maxsize=16)
def _by_stem(folder: Path, modified: int, suffix: str) -> Mapping[str, Path]:
    found: dict[str, Path] = {}
    for name in _names(folder, modified):
        stem, dot, end = name.rpartition(".")
        if (dot + end).lower() == suffix:
            found.setdefault(stem.strip().upper(), folder / name)
    return found


@lru_cache(maxsize=16)
def _by_name_record(folder: Path, modified: int, suffix: str) -> Mapping[str, Path]:
    found: dict[str, Path] = {}
    for path in _by_stem(folder, modified, suffix).values():
        try:
            head = read_input(path, first=_HEAD)
        except OSError:
            continue
        for line in head.decode("latin-1").splitlines():
            if line.startswith(_NAME_RECORD):
                found.setdefault(line[len(_NAME_RECORD) :].strip().upper(), path)
    return found


_HEAD_LINES = 60  # lines of a program in which whoever wrote it says what it is for
_MOST_FILES = 200  # that are looked at in a folder
_WORDS = 4  # that a model's name may be spelt in: LR Mate 200iD 7L
_LEAST = 4  # letters and digits of a name that stands in no other word by chance


class ArmSource(NamedTuple):
    """An arm and what says so.

    `name`: of the library, the path of a robot file, or "" for a backup whose parameters are the arm: runs read them.
    """

    name: str
    why: str


def find_arms(folder: Path, programs: Sequence[str]) -> list[ArmSource]:
    """The arms that something in `folder` names, each once: robot files before backups before heads of programs."""
    found: dict[str, ArmSource] = {}
    folders = list(dict.fromkeys([folder, *(Path(program).parent for program in programs)]))[:_MOST_FILES]
    for search in (_robot_files(folders), _backups(folders), _heads(programs)):
        for arm in search:
            found.setdefault(arm.name, arm)
        if found:
            break
    return list(found.values())


def _robot_files(folders: Iterable[Path]) -> Iterator[ArmSource]:
    for folder in folders:
        for file in sorted(folder.glob("*.toml"))[:_MOST_FILES]:
            try:
                robot = load_robot(file)
            except OlpError:
                continue  # another TOML file
            if robot.kind == "arm":
                yield ArmSource(str(file), f"the robot file of {robot.name}")


def _backups(folders: Iterable[Path]) -> Iterator[ArmSource]:
    from olp.robots.backup.machine_dat import find_machine_data, model_in, read_machine_data
    from olp.robots.backup.robot_file import model_of

    for folder in folders:
        backup = backup_of(folder)
        if backup is not None:
            name = library_name(model_of(backup, "R1"))
            if name or backup.groups:
                yield ArmSource(name, f"the backup in {folder.as_posix()}")
        data = find_machine_data(folder)
        if data is not None and (name := library_name(model_in(read_machine_data(data)))):
            yield ArmSource(name, f"the machine data {data.as_posix()}")


def _heads(programs: Sequence[str]) -> Iterator[ArmSource]:
    for path in programs[:_MOST_FILES]:
        try:
            program = read(path)
        except OlpError:
            continue
        sign = find_vendor(program.vendor).comment_prefix.strip(" :")
        for number, line in enumerate(program.source.lines[:_HEAD_LINES], 1):
            for name in models_in(line.partition(sign)[2]):
                yield ArmSource(name, f"the comment in {Path(path).as_posix()}:{number}")


def models_in(text: str) -> list[str]:
    """The library's names of the models that stand in `text` as words, the longest where they overlap."""
    # A name ends where its word does: GP25-12 is another arm than GP25.
    words = [plain for word in re.split(r"[\s,;:()\"']+", text.lower()) if (plain := _plain(word.strip(".")))]
    models = {_plain(name.partition("/")[2]): name for name in robot_names()}
    found, at = [], 0
    while at < len(words):
        spans = range(min(_WORDS, len(words) - at), 0, -1)
        size = next(
            (n for n in spans if len(said := "".join(words[at : at + n])) >= _LEAST and said in models), 0
        )
        if size:
            found.append(models["".join(words[at : at + size])])
        at += max(size, 1)
    return found


def _plain(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", name)


# Position levels 1..8 of GP25, SDA20D and HP20D controllers; a DX200 with an MA2010 was measured to use the same.
DEFAULT_ZONES = (0.0125, 0.025, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5)  # [m]
KIND_PREFIX: Mapping[Store, str] = {Store.ROBOT: "RB", Store.BASE: "BS", Store.STATION: "ST"}


@dataclass(slots=True)
class World:
    """Everything around the program. `chosen`: the robot of the first arm, when the caller names one."""

    cell: Cell
    mechanisms: list[Mechanism]
    assumptions: Assumptions
    tools: dict[int, Tool]  # those of the cell
    backup: Backup | None = None
    chosen: Robot | None = None
    diagnostics: list[Diagnostic] = field(default_factory=list)
    zones: dict[int, tuple[float, ...]] = field(default_factory=dict)  # mechanism -> [m] per level
    default_zones: set[int] = field(default_factory=set)  # mechanisms whose zones are assumed

    def mechanism(self, name: str) -> int:
        """The index of the mechanism called `name`, which is added when it is new."""
        for index, known in enumerate(self.mechanisms):
            if known.name == name:
                return index
        self.mechanisms.append(Mechanism(name, self._robot(name)))
        return len(self.mechanisms) - 1

    def zone(self, mechanism: int, level: int) -> float:
        """The size [m] of the blend zone of position level `level` >= 1."""
        zones = self.zones.get(mechanism)
        if zones is None:
            zones = self.zones[mechanism] = self._zones(mechanism)
        return zones[min(level, len(zones)) - 1]

    def _zones(self, mechanism: int) -> tuple[float, ...]:
        name, robot = self.mechanisms[mechanism].name, self.mechanisms[mechanism].robot
        if self.backup is not None:
            zones = self.backup.zones.get(self._group_number(name))
            if zones and all(map(math.isfinite, zones)):
                return zones
        if robot is not None and robot.blend_zones:
            return robot.blend_zones
        self.default_zones.add(mechanism)
        return DEFAULT_ZONES

    def _robot(self, name: str) -> Robot | None:
        """Explicit robot, then olp.toml, then the backup beside the job."""
        first_arm = Mechanism(name).is_robot and not any(m.is_robot for m in self.mechanisms)
        if self.chosen is not None and first_arm:
            return self.chosen
        given = self.assumptions.robots.get(name) or (self.assumptions.robot if first_arm else "")
        if given:
            return self._load(given)
        return self._robot_of_backup(name)

    def _load(self, given: str) -> Robot | None:
        path = Path(given)
        if given.lower().endswith(".toml") and not path.is_absolute() and self.assumptions.path:
            given = str(Path(self.assumptions.path).parent / path)
        try:
            return load_robot(given)
        except OlpError as problem:
            self.diagnostics.extend(d.at(self.assumptions.path) for d in problem.diagnostics)
            return None

    def _robot_of_backup(self, name: str) -> Robot | None:
        if self.backup is None or not self.backup.groups:
            return None
        try:
            return robot_of_backup(self.backup, name)
        except OlpError as problem:
            # The run needs no robot as long as no position does: that is told where it happens.
            if Mechanism(name).is_robot:
                self.diagnostics.extend(replace(d, severity=Severity.WARNING) for d in problem.diagnostics)
            return None

    def _group_number(self, name: str) -> int:
        system = self.backup.system if self.backup else None
        if system is not None and system.groups:
            return system.parameter_group(name.replace("RB", "R").replace("BS", "B").replace("ST", "S")) or 0
        return 1 if name == "RB1" else 0


def build_world(robot: str | Robot | None, assumptions: Assumptions, folder: Path | None) -> World:
    """The world of a program whose files are in `folder`. Raises OlpError for a robot that does not exist."""
    backup = backup_of(folder) if folder is not None else None
    diagnostics = [*assumptions.diagnostics, *(backup.diagnostics if backup is not None else ())]
    mechanisms: list[Mechanism] = []
    tools: dict[int, Tool] = {}
    frames: dict[int, Pose] = {}
    if backup is not None:
        tools = {
            n: Tool(Pose.from_xyz_angles(t.pose), t.name, t.mass, t.centre, t.inertia)
            for n, t in backup.tools.items()
        }
        frames = {n: Pose.from_xyz_angles((*f.position, *f.angles)) for n, f in backup.user_frames.items()}
    tools |= {n: Tool(Pose.from_xyz_angles(values)) for n, values in assumptions.tools.items()}
    frames |= {n: Pose.from_xyz_angles(values) for n, values in assumptions.frames.items()}
    chosen = load_robot(robot) if isinstance(robot, (str, Path)) else robot
    cell = Cell(mechanisms, tools, frames)
    return World(cell, mechanisms, assumptions, tools, backup, chosen, diagnostics)


def group_names(groups: Sequence[Sequence[str]]) -> tuple[tuple[str, ...], ...]:
    """The mechanisms per control group; a single first robot when the routine names none."""
    return tuple(tuple(names) for names in groups if names) or (("RB1",),)


def mechanism_name(groups: Sequence[Sequence[str]], part: int, store: Store) -> str:
    """The mechanism that a position of kind `store` moves in part `part` of a move (0: the leading one); "": none."""
    others = [group for index, group in enumerate(groups) if index != part]
    own = [groups[part]] if part < len(groups) else []
    names = (name for group in own + others for name in group)
    return next((name for name in names if name.startswith(KIND_PREFIX[store])), "")
