"""Arm flags of positions whose source names none, or names them as another maker does: those of the plan."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from olp.core.fast_dataclass import changer
from olp.ir.expressions import Expression, Function, Named, PositionLiteral
from olp.ir.points import sectors_of_turns
from olp.ir.program import Begin, Comment, Declare, Move, ObeyFlags, Path, Program, Routine, Statement
from olp.ir.transformer import edited, mapped
from olp.languages.vendor import ArmFlags, maker_of
from olp.robots.kinematics.configuration import TURN_AXES, same_posture
from olp.robots.model import Robot
from olp.runtime.plan import StepKind
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.postures import NEAREST, carriers_of_flags, takes_flags
from olp.transpile.symbols import Symbols

Sectors = tuple[tuple[int, float, float], ...]
Flags = tuple[tuple[int, ...], Sectors]
_ARM = 3  # flags that all makers have: wrist, elbow, front or back; behind them turns are counted
_TURN = 2.0 * math.pi
_SIX = 6
_SAME = 1e-3  # [rad]
_changed_literal: Final = changer(PositionLiteral)


def with_flags(program: Program, work: TranslationContext) -> Program:
    """Poses with the arm flags with which the plan reaches them, in the target's way of counting turns.

    Only a program whose joint moves can choose asks for it: along lines the arm stays as it stands.
    """
    if not work.limits.has_configuration:
        return program
    moves = [s for s in program.statements() if type(s) is Move]
    if not any(s.path is Path.JOINT for s in moves):
        return program
    own = _Literals(work, work.symbols(program))
    for routine in program.routines:
        for s in routine.body:
            if type(s) is Move:
                own.note(s, routine.name)
    if own.used:
        own.run()
        if not own.at_line:
            own.tell_turns(moves)
        program = own.written(program)
    return _left_open(program, work) if work.limits.watches_flags else program


def flags_of(robot: Robot, axes: NDArray[np.float64], style: ArmFlags) -> list[Flags]:
    """Flags and sectors of axes (n, 6) [rad], as the target tells them (see `ArmFlags`)."""
    from olp.robots.kinematics.configuration import QUARTER, configuration_of, quarters_of

    flags = configuration_of(robot, axes)
    if style is ArmFlags.FLAGS:
        # Beyond a whole turn the two angles that a flag tells apart are both wrong: the nearer one.
        turned = axes[:, TURN_AXES]
        short = (np.trunc(np.abs(turned) / math.pi + 1e-9) % 2).astype(np.int64)
        flags[:, _ARM:] = np.where(np.abs(turned) > _TURN, short, flags[:, _ARM:])
    turns = np.trunc((np.abs(axes) + math.pi) / _TURN + 1e-9) * np.sign(axes)
    if style is ArmFlags.COUNTED:
        flags = np.column_stack([flags[:, :_ARM], turns[:, (3, 5)], np.zeros(len(axes)), turns[:, 4]])
    rows = [tuple(map(int, row)) for row in flags.tolist()]
    rows = [row if len(row) == _SIX or row[_SIX] else row[:_SIX] for row in rows]
    sectors: list[Sectors] = [()] * len(rows)
    if style is ArmFlags.SIGNS:
        signs = (axes < 0.0).tolist()
        sectors = [
            tuple((n, -math.inf, 0.0) if below else (n, 0.0, math.inf) for n, below in enumerate(row))
            for row in signs
        ]
    elif style is ArmFlags.COUNTED:
        counts = turns.astype(np.int64).tolist()
        sectors = [sectors_of_turns((axis, row[axis]) for axis in (3, 4, 5)) for row in counts]
    elif style is ArmFlags.QUARTERS:
        quarters = (quarters_of(axes) * QUARTER).tolist()
        sectors = [
            tuple((n, low, low + QUARTER) for n, low in zip((0, 3, 5), row, strict=True)) for row in quarters
        ]
    return list(zip(rows, sectors, strict=True))


@dataclass(slots=True)
class _Literals:
    """`used`: by the id of a literal, that literal and the lines of the moves that lead to it."""

    work: TranslationContext
    symbols: Symbols
    used: dict[int, tuple[PositionLiteral, list[int]]] = field(default_factory=dict)
    at_line: dict[int, dict[Flags, int]] = field(default_factory=dict)  # how often they end with which
    # By the line: where an axis ends that has turned further than flags can say, and where they say it ends [rad].
    wound: dict[int, tuple[float, float]] = field(default_factory=dict)

    @property
    def style(self) -> ArmFlags:
        """How the target says in which posture the arm reaches a pose."""
        return self.work.target_conventions.arm_flags

    def note(self, s: Move, routine: str) -> None:
        if s.relative is not None:
            return  # an offset has no posture
        for target in (*s.targets, *(() if s.via is None else (s.via,))):
            value = literal_of_target(target, self.symbols, routine)
            if value is not None and self._is_open(value):
                self.used.setdefault(id(value), (value, []))[1].append(s.line)

    def _is_open(self, literal: PositionLiteral) -> bool:
        """Whether the target counts otherwise than the source; the three flags that all have need no robot."""
        turns = bool(literal.sectors) or any(literal.configuration[_ARM:])
        return not literal.configuration or turns or self.style in (ArmFlags.SIGNS, ArmFlags.QUARTERS)

    def run(self) -> None:
        """What the plan's axes say at each line."""
        robot, work = self.work.robot, self.work
        other = work.target_robot or robot
        if robot is None or other is None or not (_has_flags(robot) or _has_flags(other)):
            return
        plan = work.plan()
        if plan is None:
            return
        steps = np.nonzero((plan.kind == StepKind.MOVE) & (plan.source == 0))[0]
        axes = plan.positions.axes[plan.moves.target[plan.row[steps]]][:, : len(robot.axes)]
        known = ~np.isnan(axes).any(axis=1)
        stands = same_posture(robot, other, axes[known])
        if stands is None and _has_flags(other):
            stands = _otherwise(robot, other, axes[known])
        elif stands is None:
            other, stands = robot, axes[known]
        reached = ~np.isnan(stands).any(axis=1)
        steps, stands = steps[known][reached], stands[reached]
        flags = flags_of(other, stands, self.style)
        lines = plan.line[steps].tolist()
        for line, found in zip(lines, flags, strict=True):
            counts = self.at_line.setdefault(line, {})
            counts[found] = counts.get(found, 0) + 1
        self._note_wound(other, stands, lines, flags)

    def _note_wound(
        self, robot: Robot, axes: NDArray[np.float64], lines: list[int], flags: list[Flags]
    ) -> None:
        """Which of the axes (n, 6) [rad] at the ends of `lines` a reader of `flags` takes for others."""
        from olp.robots.kinematics.configuration import said_of, turn_centres

        rows = np.flatnonzero((np.abs(axes - turn_centres(robot)) > math.pi).any(axis=1)).tolist()
        if not rows:
            return
        turns = self.style is not ArmFlags.SIGNS  # whose bits for the arm tell nothing else
        told = [(*flags[row][0][: _SIX if turns else _ARM], *[0] * _ARM)[:_SIX] for row in rows]
        said = said_of(robot, axes[rows], np.array(told), [flags[row][1] for row in rows])
        for row, own in zip(rows, said, strict=True):
            at = int(np.abs(axes[row] - own).argmax())
            stands, read = float(axes[row, at]), float(own[at])
            before = self.wound.get(lines[row], (0.0, 0.0))
            if abs(stands - read) > max(_SAME, abs(before[0] - before[1])):
                self.wound[lines[row]] = (stands, read)

    def tell_turns(self, moves: list[Move]) -> None:
        """Without a robot: joint moves whose axes have turned further than half a turn, as far as the source says."""
        source, target = self.work.conventions.arm_flags, self.style
        joint = {s.line: s for s in moves if s.path is Path.JOINT}
        signs = False
        for literal, lines in self.used.values():
            ends = [joint[line] for line in lines if line in joint]
            signs = signs or (bool(ends) and bool(literal.sectors) and source is ArmFlags.SIGNS)
            if target is ArmFlags.SIGNS or (target is ArmFlags.COUNTED and source is ArmFlags.FLAGS):
                says = "how far and in which sense its axes have turned needs the robot: taken as less than half a turn"
                if target is ArmFlags.COUNTED:
                    says = "in which sense its axes have turned by more than half a turn needs the robot: forward"
                for s in ends if any(literal.configuration[_ARM:]) else ():
                    self.work.lose(s, Fate.APPROXIMATED, "configuration", says)
        if signs and target is not ArmFlags.QUARTERS:
            maker = maker_of(self.work.source.vendor)
            self.work.notes.append(
                f"without a robot {maker}'s T says nothing: turns are taken as less than half a turn"
            )

    def written(self, program: Program) -> Program:
        """The program with flags in its literals; a move that reaches one otherwise has its own."""
        chosen: dict[int, PositionLiteral] = {}
        for key, (literal, lines) in self.used.items():
            counts: dict[Flags, int] = {}
            for line in lines:
                for flags, times in self.at_line.get(line, {}).items():
                    counts[flags] = counts.get(flags, 0) + times
            if counts:
                chosen[key] = _flagged(literal, _most_frequent(counts))
            elif literal.sectors:
                chosen[key] = replace(literal, sectors=())  # of another maker, and no robot explains them

        def change(e: Expression) -> Expression:
            return chosen.get(id(e), e) if type(e) is PositionLiteral else e

        if not chosen:
            return program
        routines = []
        for routine in program.routines:
            rows = [self._move(s, routine.name, chosen) if type(s) is Move else s for s in routine.body]
            body = tuple(s if type(s) is Move and _is_named(s) else mapped(s, change) for s in rows)
            routines.append(
                replace(routine, body=body, data=tuple([mapped(one, change) for one in routine.data]))
            )
        data = tuple([mapped(one, change) for one in program.data])
        return replace(program, data=data, routines=tuple(routines))

    def _move(self, s: Move, routine: str, chosen: dict[int, PositionLiteral]) -> Move:
        """A joint move whose target it reaches in another way than most others do: with a target of its own."""
        counts = self.at_line.get(s.line)
        if s.path is not Path.JOINT or not counts or len(s.targets) != 1:
            return s
        if s.line in self.wound and literal_of_target(s.targets[0], self.symbols, routine) is not None:
            stands, said = (math.degrees(angle) for angle in self.wound[s.line])
            says = f"an axis is at {stands:.0f} deg, of which flags can only express {said:.0f} deg"
            self.work.lose(s, Fate.APPROXIMATED, "configuration", says, round(abs(stands - said), 3), "deg")
        if len(counts) > 1:
            says = "the move ends in several arm configurations: the most frequent one is written"
            self.work.lose(s, Fate.APPROXIMATED, "configuration", says)
        value = self.symbols.fixed_value(routine, s.targets[0])
        common = chosen.get(id(value))
        if common is None or type(value) is not PositionLiteral:
            return s
        flags = _most_frequent(counts)
        if flags == (common.configuration, common.sectors):
            return s
        return edited(s, {"targets": (_flagged(value, flags),)})


def _has_flags(robot: Robot) -> bool:
    return robot.geometry is not None and robot.geometry.links is not None


def _otherwise(robot: Robot, other: Robot, axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """How an arm that is built otherwise stands at axes (n, k) [rad], one after the other; nan where it cannot."""
    from olp.robots.kinematics.inverse import same_flange

    if robot.geometry is None or len(robot.axes) != _SIX:
        return np.full((len(axes), _SIX), np.nan)
    return same_flange(robot, other, axes, np.zeros(_SIX))


def literal_of_target(e: Expression, symbols: Symbols, routine: str) -> PositionLiteral | None:
    """The pose that a target is, or whose flags it takes over."""
    while type(e) is Function and e.name in ("pose-offset", "pose-relative-tool", "pose-product"):
        e = e.arguments[1 if e.name == "pose-product" else 0]
    value = symbols.fixed_value(routine, e)
    return value if type(value) is PositionLiteral and value.kind == "pose" else None


def _flagged(literal: PositionLiteral, flags: Flags) -> PositionLiteral:
    return _changed_literal(literal, {"configuration": flags[0], "sectors": flags[1]})


def _most_frequent(counts: dict[Flags, int]) -> Flags:
    return max(counts, key=counts.__getitem__)


def _left_open(program: Program, work: TranslationContext) -> Program:
    """The program does not watch the flags of joint moves where they are not known."""
    symbols, carriers = work.symbols(program), carriers_of_flags(program, work)
    open_moves: set[int] = set()
    known = False
    for routine in program.routines:
        for s in routine.body:
            if type(s) is not Move or s.path is not Path.JOINT:
                continue
            value = literal_of_target(s.targets[0], symbols, routine.name)
            if value is not None and value.sectors and not _is_product(s.targets[0]):
                known = True
            elif value is not None or not _is_joints(s, symbols, routine.name):
                open_moves.add(id(s))
                flags = (
                    value.configuration
                    if value is not None
                    else takes_flags(s, routine.name, symbols, carriers)
                )
                if flags and work.has_flags:
                    work.lose(s, Fate.APPROXIMATED, "configuration", NEAREST)
    if not open_moves:
        return program
    main = program.main or program.routines[0].name
    routines = [
        _unwatched(r, open_moves) if known else _never(r) if r.name == main or r.starts else r
        for r in program.routines
    ]
    return replace(program, routines=tuple(routines))


def _is_product(e: Expression) -> bool:
    """Whether a target comes out of PoseMult, which gives a place and a turn, and no flags."""
    while type(e) is Function and e.name in ("pose-offset", "pose-relative-tool"):
        e = e.arguments[0]
    return type(e) is Function and e.name == "pose-product"


def _is_joints(s: Move, symbols: Symbols, routine: str) -> bool:
    from olp.transpile.symbols import kind_of_value

    return kind_of_value(symbols, routine, s.targets[0]) == "joints"


def _never(routine: Routine) -> Routine:
    at = next((n for n, s in enumerate(routine.body) if not isinstance(s, (Begin, Comment, Declare))), 0)
    return replace(routine, body=(*routine.body[:at], ObeyFlags(0, False), *routine.body[at:]))


def _unwatched(routine: Routine, open_moves: set[int]) -> Routine:
    rows: list[Statement] = []
    for s in routine.body:
        if id(s) not in open_moves:
            rows.append(s)
        elif rows and rows[-1] == ObeyFlags(0, True):
            rows[-1:] = [s, ObeyFlags(0, True)]
        else:
            rows += [ObeyFlags(0, False), s, ObeyFlags(0, True)]
    return replace(routine, body=tuple(rows))


def _is_named(s: Move) -> bool:
    return type(s.targets[0]) is Named and s.via is None
