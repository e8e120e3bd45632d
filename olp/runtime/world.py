"""What stands around a program: mechanisms with their robots, tools, frames, blend zones, start values."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from olp.core.diagnostic import Diagnostic, OlpError, Severity
from olp.ir.expressions import Store
from olp.robots.coordinate_systems import Cell, Mechanism, Tool
from olp.robots.geometry import Pose
from olp.robots.robot import load_robot
from olp.runtime.assumptions import Assumptions
from olp.runtime.folder import backup_of, robot_of_backup

if TYPE_CHECKING:
    from olp.robots.backup import Backup
    from olp.robots.robot import Robot

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
