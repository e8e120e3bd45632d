"""Positions that are computed: KRL aggregates hold numbers, so a variable is filled component by component first."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

from olp.expression import Expression, Function, Number, PositionLiteral, Unary
from olp.moves import Move, SetFrame, SetTool
from olp.program import Assign, Statement
from olp.vendors.krl.write_values import Words

_POSE: Final = (("X", 0), ("Y", 1), ("Z", 2), ("A", 5), ("B", 4), ("C", 3))
_AXES: Final = ("A1", "A2", "A3", "A4", "A5", "A6")
_ZERO: Final = Number(0)


def computed_first(it: Any, words: Words, temporaries: dict[str, str]) -> tuple[list[str], Any]:
    """The lines that fill variables, and the statement that uses them. KRL's own programs come back as they are."""
    if words.own or not isinstance(it, (Move, Assign, SetTool, SetFrame)):
        return [], it
    filler = _Filler(words, temporaries)
    changed: Statement
    if isinstance(it, Move):
        if Function not in map(type, (*it.targets, it.via, it.tool, it.frame)):
            return [], it
        changed = replace(
            it,
            targets=tuple(map(filler.plain, it.targets)),
            via=it.via and filler.plain(it.via),
            tool=it.tool and filler.plain(it.tool),
            frame=it.frame and filler.plain(it.frame),
        )
    elif isinstance(it, Assign):
        changed = replace(it, value=filler.plain(it.value))
    elif isinstance(it, SetTool):
        changed = replace(it, tool=filler.plain(it.tool))
    else:
        changed = replace(it, frame=filler.plain(it.frame))
    return filler.lines, changed


class _Filler:
    def __init__(self, words: Words, temporaries: dict[str, str]) -> None:
        self.words = words
        self.temporaries = temporaries
        self.lines: list[str] = []
        self._filled = 0

    def plain(self, it: Expression) -> Expression:
        """The expression with variables for its computed positions."""
        if not isinstance(it, Function):
            return it
        arguments = tuple(map(self.plain, it.arguments))
        if it.name == "pose-offset":
            return Function(
                "pose-product", (self._pose((*arguments[1:4], _ZERO, _ZERO, _ZERO)), arguments[0])
            )
        if it.name == "pose-relative-tool":
            return self._relative(arguments)
        if it.name == "pose-angles":
            return self._pose(arguments)
        if it.name == "joints":
            return self._fill("E6AXIS", list(zip(_AXES, arguments, strict=False)))
        return Function(it.name, arguments)

    def _relative(self, arguments: tuple[Expression, ...]) -> Expression:
        """p · shift · Rx · Ry · Rz, one factor for each angle that is not 0."""
        padded = [*arguments, *[_ZERO] * (7 - len(arguments))]
        pose, x, y, z, *angles = padded
        factors = [self._pose((x, y, z, angles[0], _ZERO, _ZERO))]
        for place, angle in enumerate(angles[1:], 4):
            if angle not in (_ZERO, Number(0.0)):
                parts: list[Expression] = [_ZERO] * 6
                parts[place] = angle
                factors.append(self._pose(tuple(parts)))
        for factor in factors:
            pose = Function("pose-product", (pose, factor))
        return pose

    def _pose(self, parts: tuple[Expression, ...]) -> Expression:
        """x y z [mm], rx ry rz [deg]."""
        numbers = [_constant(one) for one in parts]
        if all(one is not None for one in numbers):
            from olp.vendors.krl.values import POSE_SCALES

            values = tuple((one or 0.0) * scale for one, scale in zip(numbers, POSE_SCALES, strict=True))
            return PositionLiteral("pose", values)
        return self._fill("FRAME", [(word, parts[place]) for word, place in _POSE])

    def _fill(self, word: str, parts: list[tuple[str, Expression]]) -> Expression:
        from olp.expression import Named

        self._filled += 1
        name = f"COMPUTED_{'POSE' if word == 'FRAME' else 'AXES'}_{self._filled}"
        while self.words.scope.known(name):
            name += "_"
        self.temporaries[name] = word
        self.lines.append(f"{name}={{{','.join(f'{key} 0' for key, _ in parts)}}}")
        for key, value in parts:
            if value not in (_ZERO, Number(0.0)):
                self.lines.append(f"{name}.{key}={self.words.expression(value)}")
        return Named(name)


def _constant(it: Expression) -> float | None:
    if type(it) is Number:
        return float(it.value)
    if isinstance(it, Unary) and type(it.operand) is Number and it.operator == "-":
        return -float(it.operand.value)
    return None
