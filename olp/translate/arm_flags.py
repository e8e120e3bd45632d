"""Arm flags of positions whose source names none, or names them in a way that its robot explains: those of the plan."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from olp.expression import Expression, Function, Named, PositionLiteral
from olp.plan import StepKind
from olp.program import Move, Path, Program
from olp.robot import Robot
from olp.translate.rewrite import edited, mapped
from olp.translate.symbols import Symbols, symbols_of
from olp.translate.work import Work

Flags = tuple[int, ...]
_PLAIN = 3  # flags that all makers have: wrist, elbow, front or back; behind them turns are counted
_TURN = 2.0 * math.pi


def with_flags(program: Program, work: Work) -> Program:
    """Poses with the arm flags with which the plan reaches them, in the target's way of counting turns.

    Only a program whose joint moves can choose asks for it: along lines the arm stays as it stands.
    """
    robot = work.robot
    if not work.limits.has_configuration:
        return program
    if robot is None or robot.geometry is None or robot.geometry.links is None:
        return program
    moves = [s for s in program.statements() if type(s) is Move]
    if not any(s.path is Path.JOINT for s in moves):
        return program
    own = _Literals(work.target, symbols_of(program))
    for routine in program.routines:
        for s in routine.body:
            if type(s) is Move:
                own.note(s, routine.name)
    if not own.used:
        return program
    plan = work.plan()
    if plan is None:
        return program
    steps = np.nonzero((plan.kind == StepKind.MOVE) & (plan.source == 0))[0]
    axes = plan.positions.axes[plan.moves.target[plan.row[steps]]][:, : len(robot.axes)]
    known = ~np.isnan(axes).any(axis=1)
    flags = flags_of(robot, axes[known], work.target)
    for line, found in zip(plan.line[steps[known]].tolist(), flags, strict=True):
        own.at_line.setdefault(line, Counter())[found] += 1
    return own.written(program)


def flags_of(robot: Robot, axes: NDArray[np.float64], target: str) -> list[Flags]:
    """Flags of axes (n, 6) [rad]: RCONF's, for FANUC with the turns of J4, J6 and J5 counted with their sign."""
    from olp.kinematics import configuration_of

    flags = configuration_of(robot, axes)
    if target == "tp":
        turns = np.trunc((np.abs(axes) + math.pi) / _TURN + 1e-9) * np.sign(axes)
        flags = np.column_stack([flags[:, :_PLAIN], turns[:, (3, 5)], np.zeros(len(axes)), turns[:, 4]])
    rows = [tuple(map(int, row)) for row in flags.tolist()]
    return [row if len(row) == 6 or row[6] else row[:6] for row in rows]


@dataclass(slots=True)
class _Literals:
    """`used`: by the id of a literal, that literal and the lines of the moves that lead to it."""

    target: str
    symbols: Symbols
    used: dict[int, tuple[PositionLiteral, list[int]]] = field(default_factory=dict)
    at_line: dict[int, Counter[Flags]] = field(default_factory=dict)

    def note(self, s: Move, routine: str) -> None:
        for target in (*s.targets, *(() if s.via is None else (s.via,))):
            for literal in self._of(target, routine):
                self.used.setdefault(id(literal), (literal, []))[1].append(s.line)

    def _of(self, e: Expression, routine: str) -> Iterator[PositionLiteral]:
        """The literal that a target is, or is computed from, where its flags are open."""
        while type(e) is Function and e.name in ("pose-offset", "pose-relative-tool", "pose-product"):
            e = e.arguments[1 if e.name == "pose-product" else 0]
        value = self.symbols.fixed_value(routine, e)
        if type(value) is PositionLiteral and value.kind == "pose" and self._is_open(value):
            yield value

    def _is_open(self, literal: PositionLiteral) -> bool:
        return not literal.configuration or any(literal.configuration[_PLAIN:])

    def written(self, program: Program) -> Program:
        """The program with flags in its literals; a move that reaches one otherwise has its own."""
        chosen: dict[int, PositionLiteral] = {}
        for key, (literal, lines) in self.used.items():
            counts = sum((self.at_line.get(line, Counter()) for line in lines), Counter[Flags]())
            if counts:
                chosen[key] = replace(literal, configuration=counts.most_common(1)[0][0])

        def change(e: Expression) -> Expression:
            return chosen.get(id(e), e) if type(e) is PositionLiteral else e

        routines = []
        for routine in program.routines:
            rows = [self._move(s, routine.name, chosen) if type(s) is Move else s for s in routine.body]
            body = tuple(s if type(s) is Move and _is_named(s) else mapped(s, change) for s in rows)
            routines.append(
                replace(routine, body=body, data=tuple(mapped(one, change) for one in routine.data))
            )
        data = tuple(mapped(one, change) for one in program.data)
        return replace(program, data=data, routines=tuple(routines))

    def _move(self, s: Move, routine: str, chosen: dict[int, PositionLiteral]) -> Move:
        """A joint move whose target it reaches in another way than most others do: with a target of its own."""
        counts = self.at_line.get(s.line)
        if s.path is not Path.JOINT or not counts or len(s.targets) != 1:
            return s
        value = self.symbols.fixed_value(routine, s.targets[0])
        common = chosen.get(id(value))
        flags = counts.most_common(1)[0][0]
        if common is None or common.configuration == flags or type(value) is not PositionLiteral:
            return s
        return edited(s, {"targets": (replace(value, configuration=flags),)})


def _is_named(s: Move) -> bool:
    return type(s.targets[0]) is Named and s.via is None
