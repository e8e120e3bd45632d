"""Joint values for another robot: those that give it the same posture as the source's robot.

With `--robot` alone joint values and poses in the base are copied, because one robot counts its joints in one way,
whatever the language. With `--target-robot` each robot's file says how its joints count.
"""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass, field, replace
from typing import Final, TypeGuard

import numpy as np
from numpy.typing import NDArray

from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir.points import PointKind, PointState
from olp.ir.program import Assign, Call, Declare, Move, Path, Program, Return, Statement
from olp.ir.transformer import calls_nothing, edited, expressions_of, mapped
from olp.robots.coordinate_systems import Cell
from olp.robots.geometry import Pose
from olp.robots.kinematics.configuration import readings_of_joints, same_posture
from olp.robots.model import Robot
from olp.runtime.plan import StepKind
from olp.transpile.context import Fate, TranslationContext, cell_of
from olp.transpile.move_lowering import tell_zeros
from olp.transpile.shared_variables import paired
from olp.transpile.symbols import Symbols, base_of, kind_of_value, symbols_of

Floats = NDArray[np.float64]
_SAME = 1e-7  # [m]
_SIX = 6


def postures(program: Program, work: TranslationContext) -> Program:
    """The program with the joint values of the target robot; poses stay, and the receipt tells what that means."""
    robot, other = work.robot, work.target_robot
    note = work.limits.joint_values_note
    if note and robot is not None and _has_joints(program) and not _couples(other):
        work.notes.append(note)
    if robot is None or other is None or robot == other or robot.geometry is None or other.geometry is None:
        return program
    if len(robot.axes) != _SIX or len(other.axes) != _SIX:
        if _has_joints(program):
            work.notes.append(f"joint values are those of {robot.name}, carried as written to {other.name}")
        return program
    alike = robot.geometry.links is not None and other.geometry.links is not None
    own = _Postures(work, robot, other) if alike else _Places(work, robot, other)
    if not alike and _has_joints(program):
        says = f"{other.name} is built differently from {robot.name}: joint moves take another path"
        work.notes.append(says)
    above = _above(robot, other)
    if abs(above) > _SAME:
        where = "higher" if above > 0 else "lower"
        says = f"{other.name} counts poses from an origin that is {where}: those in the base are carried as written"
        work.lose(0, Fate.APPROXIMATED, "base", says, abs(above) / mm, "mm")
        moved = (
            "frames and poses of the base lie elsewhere in the cell: shift them, or mount the arm otherwise"
        )
        work.ask(moved, f"{abs(above) / mm:g} mm {where}")
    return own.program(program)


@dataclass(slots=True)
class _Postures:
    work: TranslationContext
    robot: Robot
    other: Robot
    apart: dict[ex.PositionLiteral, float] = field(
        default_factory=dict
    )  # [m] of the flange, by what became of a posture
    turned: set[ex.PositionLiteral] = field(default_factory=set)  # with an axis whole turns elsewhere
    held: dict[str, bool] = field(
        default_factory=dict
    )  # variables of joint values: whether it is an array of them

    def program(self, program: Program) -> Program:
        self.held = {d.name: bool(d.sizes) for d in program.declarations() if d.type == "joints"}
        routines = tuple(
            replace(
                r,
                body=tuple(self._statement(s) for s in r.body),
                data=tuple(mapped(one, self._change) for one in r.data),
            )
            for r in program.routines
        )
        changed = replace(
            program, routines=routines, data=tuple(mapped(one, self._change) for one in program.data)
        )
        self._tell(changed)
        return changed

    def _statement(self, s: Statement) -> Statement:
        if isinstance(s, Move) and s.relative is not None and any(map(_is_joints, s.targets)):
            return replace(s, targets=tuple(self._step(t) for t in s.targets))
        if self._computes(s):
            says = "joint values that are computed are carried as written"
            self.work.lose(s, Fate.APPROXIMATED, "joints", says)
        return mapped(s, self._change)

    def _computes(self, s: Statement) -> bool:
        """Whether a statement puts joint values together, or sets one of them."""
        if isinstance(s, Assign) and isinstance(s.target, (ex.Item, ex.Member)):
            base = base_of(s.target)
            if base is not None and base.name in self.held:
                return not (self.held[base.name] and s.target.base is base)
        return any(isinstance(e, ex.Function) and e.name == "joints" for e in expressions_of(s))

    def _change(self, e: ex.Expression) -> ex.Expression:
        if not isinstance(e, ex.PositionLiteral) or not _is_joints(e):
            return e
        from olp.robots.kinematics.configuration import forward, turned_back

        joints = self._joints(e)
        if joints is None:
            self.work.notes.append("joint values of which some are left out are carried as written")
            return e
        there = self._there(joints)
        made = replace(e, values=tuple(_clean(v) for v in self._read(there)[0]))
        apart = forward(self.other, there)[0][0] - forward(self.robot, joints)[0][0]
        apart[2] += _above(self.robot, self.other)
        self.apart[made] = float(np.linalg.norm(apart))
        if turned_back(self.robot, self.other, joints, there)[0]:
            self.turned.add(made)
        return made

    def _step(self, e: ex.Expression) -> ex.Expression:
        """A relative target: how much each joint turns."""
        if not isinstance(e, ex.PositionLiteral) or not _is_joints(e):
            return e
        joints = self._joints(replace(e, values=tuple(0.0 if v != v else v for v in e.values)))
        if joints is None:
            return e
        none = np.zeros_like(joints)
        turned = self._read(self._there(joints)) - self._read(self._there(none))
        turned -= 2 * np.pi * np.rint(turned / (2 * np.pi)) * (np.abs(joints) < np.pi)
        return replace(e, values=tuple(_clean(v) for v in turned[0]))

    def _joints(self, e: ex.PositionLiteral) -> Floats | None:
        from olp.robots.kinematics.configuration import joints_of_readings

        if len(e.values) != 6 or any(v != v for v in e.values):
            return None
        return joints_of_readings(self.robot, np.array([e.values]))

    def _there(self, joints: Floats) -> Floats:
        found = same_posture(self.robot, self.other, joints)
        assert found is not None
        return found

    def _read(self, joints: Floats) -> Floats:
        return readings_of_joints(self.other, joints)

    def _tell(self, program: Program) -> None:
        """Moves to postures in which the other arm's flange is elsewhere, because its links are of other lengths."""
        symbols = symbols_of(program)
        for routine in program.routines:
            for s in routine.body:
                if not isinstance(s, Move) or s.relative is not None:
                    continue
                value = symbols.fixed_value(routine.name, s.targets[0])
                apart = self.apart.get(value, 0.0) if isinstance(value, ex.PositionLiteral) else 0.0
                if apart > _SAME:
                    says = f"{self.other.name} stands as {self.robot.name} does, its flange elsewhere"
                    self.work.lose(s, Fate.APPROXIMATED, "joints", says, apart / mm, "mm")
                if value in self.turned:
                    says = (
                        f"an axis of {self.other.name} stands whole turns elsewhere, where its limits let it"
                    )
                    self.work.lose(s, Fate.APPROXIMATED, "joints", says, 360.0, "deg")


def _above(robot: Robot, other: Robot) -> float:
    """[m] by which the other's base lies higher, both on one floor; where that is not known, with axes L level."""
    assert robot.geometry is not None
    assert other.geometry is not None
    one, two = robot.geometry.base_height, other.geometry.base_height
    if one is not None and two is not None:
        return two - one
    return _height(robot) - _height(other)


@dataclass(slots=True)
class _Places(_Postures):
    """Between arms that are built otherwise: joint values with which the flange is where it was."""

    last: Floats | None = None  # (k,) [rad] where the other arm stood before
    beyond: set[ex.PositionLiteral] = field(default_factory=set)  # what the other arm does not reach

    def _statement(self, s: Statement) -> Statement:
        steps = isinstance(s, Move) and s.relative is not None and any(map(_is_joints, s.targets))
        if steps or self._computes(s):
            says = (
                f"joint values that are computed mean nothing to {self.other.name}, which is built otherwise"
            )
            self.work.lose(s, Fate.REFUSED, "joints", says)
            return s
        return mapped(s, self._change)

    def _change(self, e: ex.Expression) -> ex.Expression:
        if not isinstance(e, ex.PositionLiteral) or not _is_joints(e):
            return e
        from olp.robots.kinematics.inverse import same_flange

        joints = self._joints(e)
        start = np.zeros(_SIX) if self.last is None else self.last
        there = None if joints is None else same_flange(self.robot, self.other, joints, start)
        if there is None or np.isnan(there).any():
            self.beyond.add(e)
            return e
        self.last = there[0]
        return replace(e, values=tuple(_clean(v) for v in self._read(there)[0]))

    def _tell(self, program: Program) -> None:
        """Moves to what the other arm does not reach."""
        symbols = symbols_of(program)
        for routine in program.routines:
            for s in routine.body:
                if isinstance(s, Move) and any(
                    symbols.fixed_value(routine.name, t) in self.beyond for t in s.targets
                ):
                    says = f"{self.other.name} does not reach where {self.robot.name} stands with these joint values"
                    self.work.lose(s, Fate.REFUSED, "joints", says)


def _height(robot: Robot) -> float:
    """[m] of axis 2 above the origin of the base."""
    assert robot.geometry is not None
    return sum(joint.offset[2] for joint in robot.geometry.joints[:2])


def _has_joints(program: Program) -> bool:
    data = (*program.data, *(d for r in program.routines for d in r.data))
    if any(_is_joints(d.value) for d in data if isinstance(d, Declare) and d.value is not None):
        return True
    return any(_is_joints(t) for s in program.statements() if type(s) is Move for t in s.targets)


def _couples(robot: Robot | None) -> bool:
    links = None if robot is None or robot.geometry is None else robot.geometry.links
    return links is not None and links.third_to_horizontal


def _is_joints(e: ex.Expression) -> bool:
    return isinstance(e, ex.PositionLiteral) and e.kind == "joint"


def _clean(value: float) -> float:
    """Without the noise of the conversion: to 1e-9 deg."""
    return round(value / deg, 9) * deg


# --- Lines to joint values ---
# For languages whose lines and arcs lead to poses alone: the pose that the arm reaches with the joint values.


def joint_targets_as_poses(program: Program, work: TranslationContext) -> Program:
    """Lines and arcs to joint values get the pose of the tool there as their target, where the values are known."""
    if work.limits.joint_lines or work.source.vendor == work.target:
        return program
    if not any(e.kind == "joint" for e in work.literals(program)):
        return program
    own = _Reached(work, work.symbols(program))
    routines = [replace(r, body=tuple([own.statement(r.name, s) for s in r.body])) for r in program.routines]
    return replace(program, routines=tuple(routines)) if own.found else program


@dataclass(slots=True)
class _Reached:
    work: TranslationContext
    symbols: Symbols
    found: bool = False
    cell: Cell | None = None

    def statement(self, routine: str, s: Statement) -> Statement:
        if type(s) is not Move or s.path is Path.JOINT or s.relative is not None:
            return s
        changes: dict[str, object] = {}
        targets = [self._literal(routine, e) for e in s.targets]
        via = None if s.via is None else self._literal(routine, s.via)
        if via is None and not any(targets):
            return s
        robot = self.work.target_robot or self.work.robot
        if robot is None or robot.geometry is None:
            self.work.need_robot(s, "a straight move to joint values is known by its robot only")
            return s
        if self.cell is None:
            self.cell = cell_of(self.work.source, robot)
        place = self._place(routine, s)
        poses = [e if at is None else self._pose(at, place) for e, at in zip(s.targets, targets, strict=True)]
        changes["targets"] = tuple(poses)
        if via is not None:
            changes["via"] = self._pose(via, place)
        self.found = True
        return edited(s, changes)

    def _literal(self, routine: str, e: ex.Expression) -> ex.PositionLiteral | None:
        value = self.symbols.fixed_value(routine, e)
        return value if isinstance(value, ex.PositionLiteral) and value.kind == "joint" else None

    def _place(self, routine: str, s: Move) -> tuple[Pose, Pose]:
        """The move's tool on the flange and its frame in the base; what no file tells is the flange and the base."""
        poses = []
        for kind, e in (("tool", s.tool), ("user", s.frame)):
            value = self.symbols.fixed_value(routine, e)
            number = e.number if isinstance(e, ex.FrameRef) else None
            if isinstance(number, ex.Number):
                value = self.work.systems.get((kind, int(number.value)))
            if isinstance(value, ex.PositionLiteral) and value.kind == "pose":
                poses.append(Pose.from_xyz_angles(value.values[:6]))
                continue
            poses.append(Pose.identity())
            if (
                e is not None
                and number != ex.Number(0)
                and not (isinstance(e, ex.FrameRef) and number is None)
            ):
                label = str(number.value) if isinstance(number, ex.Number) else "(computed)"
                tell_zeros(self.work, s, _NAMED[kind], f"{_NAMED[kind]} {label}")
        return poses[0], poses[1]

    def _pose(self, at: ex.PositionLiteral, place: tuple[Pose, Pose]) -> ex.Expression:
        assert self.cell is not None
        tool, frame = place
        flange = self.cell.pose(0, PointState(PointKind.JOINT, "joint"), at.values)
        if flange is None:
            return at
        pose = frame.inverse() @ flange @ tool
        return ex.PositionLiteral("pose", tuple(float(v) for v in pose.xyz_angles()), at.external)


_NAMED: Final = {"tool": "tool", "user": "frame"}


# --- Configurations ---
# Arm configurations: kept where the target says them; where it does not, told.

NEAREST: Final = "the arm configuration is left to the controller: it takes the nearest"
_CONFIGURATIONS_SAME = 1e-6  # [rad] below this two ends are one


def carriers_of_flags(program: Program, work: TranslationContext) -> frozenset[str]:
    """Names of variables, parameters and functions that may hold a pose whose arm flags somebody wrote."""
    found: set[str] = set()
    flows: dict[str, set[str]] = {}  # from a name to those that take its value over

    def note(to: str, value: ex.Expression | None) -> None:
        for e in () if value is None else expressions_of(value):
            if type(e) is ex.PositionLiteral and e.configuration:
                found.add(to)
            elif isinstance(e, (ex.Named, ex.CallValue)):
                flows.setdefault(e.name if isinstance(e, ex.Named) else e.routine, set()).add(to)

    taken = {r.name.casefold(): r.parameters for r in program.routines}
    for d in program.data:
        note(d.name, d.value)
    for r in program.routines:
        for s in (*r.data, *(s for _, s in work.look(r).rare)):
            base = base_of(s.target) if isinstance(s, Assign) and type(s.target) is not ex.Member else None
            if isinstance(s, Declare):
                note(s.name, s.value)
            elif isinstance(s, Assign) and base is not None:
                note(base.name, s.value)
            elif isinstance(s, Return):
                note(r.name, s.value)
            for call in () if calls_nothing(s) else (s, *expressions_of(s)):
                if isinstance(call, (Call, ex.CallValue)):
                    for name, value in paired(taken.get(call.routine.casefold(), ()), call.arguments):
                        note(name, value)
    todo = list(found)
    while todo:
        new = flows.get(todo.pop(), set()) - found
        found |= new
        todo += new
    return frozenset(found)


def takes_flags(s: Move, routine: str, symbols: Symbols, carriers: Set[str]) -> bool:
    """Whether a move leads to a pose that takes arm flags over from one that is written out."""
    target = s.targets[0]
    if kind_of_value(symbols, routine, target) == "joints":
        return False
    return any(isinstance(e, ex.Named) and e.name in carriers for e in expressions_of(target))


def configurations(program: Program, work: TranslationContext) -> Program:
    """Poses with the arm flags of the plan, or without any for languages that have none; URScript is told joint values.

    Each other joint move that led to a pose with flags is a loss.
    """
    limits = work.limits
    kept = limits.has_configuration and not limits.products_forget_flags
    if kept or not any(e.configuration for e in work.literals(program)):
        return program
    symbols = work.symbols(program)
    carriers = carriers_of_flags(program, work)
    if limits.has_configuration:
        for routine in program.routines:
            for s in routine.body:
                if _forgets_flags(s, carriers) and takes_flags(s, routine.name, symbols, carriers):
                    work.lose(s, Fate.APPROXIMATED, "configuration", NEAREST)
        return program
    routines = []
    for routine in program.routines:
        rows: list[Statement] = []
        for s in routine.body:
            row = _row(s)
            if isinstance(s, Move) and s.path is Path.JOINT:
                literal = symbols.fixed_value(routine.name, s.targets[0])
                if isinstance(literal, ex.PositionLiteral) and literal.configuration:
                    assert isinstance(row, Move)
                    row = _near(row, work)
                elif literal is None and takes_flags(s, routine.name, symbols, carriers) and work.has_flags:
                    work.lose(s, Fate.APPROXIMATED, "configuration", NEAREST)
            rows.append(row)
        routines.append(
            replace(routine, body=tuple(rows), data=tuple(mapped(d, _without) for d in routine.data))
        )
    data = tuple(mapped(d, _without) for d in program.data)
    return replace(program, data=data, routines=tuple(routines))


def _forgets_flags(s: Statement, carriers: Set[str]) -> TypeGuard[Move]:
    """Whether a joint move leads to a product of poses, whose last factor has no flags."""
    if type(s) is not Move or s.path is not Path.JOINT:
        return False
    target = s.targets[0]
    if type(target) is not ex.Function or target.name not in ("pose-product", "pose-relative-tool"):
        return False
    last = target.arguments[-1]
    return not any(
        (isinstance(e, ex.Named) and e.name in carriers)
        or (isinstance(e, ex.PositionLiteral) and bool(e.configuration))
        for e in expressions_of(last)
    )


def _near(s: Move, work: TranslationContext) -> Move:
    """The move to the joint values near which the pose is reached, where each run of it ends in the same ones."""
    axes = _ends(s.line, work) if work.limits.near_joints else None
    if axes is None and not work.has_flags:
        return s
    if axes is None:
        work.lose(s, Fate.APPROXIMATED, "configuration", NEAREST)
        return s
    near = ex.PositionLiteral("joint", axes)
    return edited(s, {"targets": (ex.Function("inverse", (s.targets[0], near)),)})


def _ends(line: int, work: TranslationContext) -> tuple[float, ...] | None:
    """[rad] Where the source's plan has the arm at the end of a line; None where that is not known."""
    robot, plan = work.robot, work.plan()
    if robot is None or plan is None or work.target_robot is None:
        return None
    steps = np.nonzero((plan.kind == StepKind.MOVE) & (plan.source == 0) & (plan.line == line))[0]
    rows = plan.positions.axes[plan.moves.target[plan.row[steps]]][:, : len(robot.axes)]
    if not len(rows) or np.isnan(rows).any() or np.ptp(rows, axis=0).max() > _CONFIGURATIONS_SAME:
        return None
    if work.target_robot.name != robot.name:
        stands = same_posture(robot, work.target_robot, rows[:1])
        if stands is None:
            return None
        rows = stands
    return tuple(float(f"{value:.9g}") for value in readings_of_joints(work.target_robot, rows[:1])[0])


def _row(s: Statement) -> Statement:
    plain = type(s) is Move and type(s.targets[0]) is ex.Named and (s.via is None or type(s.via) is ex.Named)
    return s if plain else mapped(s, _without)


def _without(e: ex.Expression) -> ex.Expression:
    if type(e) is not ex.PositionLiteral or not e.configuration:
        return e
    return ex.PositionLiteral(e.kind, e.values, e.external, native=e.native)
