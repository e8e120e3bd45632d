"""Arcs: chains of points, or through a point to their end, as the target writes them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from olp.ir.expressions import Expression, FrameRef, Named, Number, PositionLiteral, SystemValue
from olp.ir.program import Assign, Blend, BlendKind, Comment, Declare, Move, Path, Program, Routine, Statement
from olp.robots.geometry import Pose, quaternion_from_rotation, rotation_from_quaternion, slerp
from olp.runtime.paths import arc_by_angle
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.current_position import HERE, systems_of
from olp.transpile.first_values import TEACH, UNDECLARED
from olp.transpile.records import literal_of, pose_of_literal
from olp.transpile.symbols import Symbols, base_of, symbols_of

Floats = NDArray[np.float64]
_Change = Callable[[Move, Move | None], tuple[list[Statement], Move | None]]
_TURNS: Final = "the tool is taken to have turned at the end of an arc by an angle as its target says"
_SAME_TURN: Final = 1e-9  # [1], of the elements of a rotation
# What the point on an arc may say otherwise than its end.
_OF_A_POINT: Final = ("line", "targets", "blend", "parts", "comment", "end_of_arc", "passes")
# What runs between two moves without leading elsewhere.
_STRAIGHT: Final = frozenset(
    {
        "Comment",
        "SetOutput",
        "PulseOutput",
        "Dwell",
        "Wait",
        "Assign",
        "Update",
        "Message",
        "Declare",
        "Begin",
    }
)


def arcs(program: Program, work: TranslationContext) -> Program:
    """Every arc in the target's form."""
    if not any(isinstance(s, Move) and s.path is Path.CIRCULAR for s in program.statements()):
        return program
    taught = set(work.asks.get(TEACH, ())) | {d.name for d in program.data if d.comment == UNDECLARED}
    own = _Arcs(work, symbols_of(program), frozenset(taught))
    own.refuse_torn(program)
    routines = tuple(own.routine(routine) for routine in program.routines)
    return replace(program, routines=routines, data=(*program.data, *own.declared))


@dataclass(slots=True)
class _Arcs:
    work: TranslationContext
    symbols: Symbols
    taught: frozenset[str]  # positions that hold zeros until somebody teaches them
    declared: list[Declare] = field(default_factory=list)
    name: str = ""

    def routine(self, routine: Routine) -> Routine:
        self.name = routine.name
        limits = self.work.limits
        body = list(routine.body) if limits.arcs_by_angle else self._walked(routine.body, self._by_angle)
        body = self._walked(body, self._chained) if limits.chained_arcs else self._whole(body)
        return replace(routine, body=tuple(body))

    def refuse_torn(self, program: Program) -> None:
        """The points of a chain of which one is left out: the others alone would be lines, or another arc."""
        if self.work.limits.chained_arcs:
            return
        there = {s.line for s in program.statements() if isinstance(s, Move) and s.path is Path.CIRCULAR}
        by_line = {s.line: s for s in program.statements() if isinstance(s, Move)}
        for routine in self.work.source.routines:
            body = list(routine.body)
            for chain in self._chains(body):
                lines = [body[index].line for index in chain]
                lost = [line for line in lines if line not in there]
                for line in lines if lost and len(chain) > 2 else ():
                    if line in there:
                        says = "a point of its chain of arcs is left out, which is a line or another arc without it"
                        self.work.lose(by_line[line], Fate.REFUSED, "arc", says)

    def _chains(self, body: list[Statement]) -> Iterator[list[int]]:
        at = 0
        while at < len(body):
            s = body[at]
            if isinstance(s, Move) and s.path is Path.CIRCULAR and s.via is None:
                chain = self._collect(body, at)
                yield chain
                at = chain[-1] if len(chain) > 1 and self._ends(body, chain[-1]) else chain[-1] + 1
                continue
            at += 1

    def _fixed(self, e: Expression | None) -> PositionLiteral | None:
        """A position that the text tells, and that nobody teaches later."""
        base = None if e is None else base_of(e)
        if base is not None and base.name in self.taught:
            return None
        return self.symbols.fixed_position(self.name, e)

    def _walked(self, body: Sequence[Statement], change: _Change) -> list[Statement]:
        """Each move as `change` makes it of the one before, which ends where the arm is known to be."""
        rows: list[Statement] = []
        before: Move | None = None
        for s in body:
            if isinstance(s, Move):
                made, before = change(s, before)
                rows += made
                continue
            if type(s).__name__ not in _STRAIGHT:
                before = None
            rows.append(s)
        return rows

    # --- arcs by their angle ----------------------------------------------------------------------------

    def _by_angle(self, s: Move, before: Move | None) -> tuple[list[Statement], Move | None]:
        """An arc that turns by an angle as arcs through points, and the move that ends where the arm is then."""
        made: list[Statement] = [s] if s.arc is None else self._turned(s, before)
        return made, made[-1] if isinstance(made[-1], Move) else None

    def _turned(self, s: Move, before: Move | None) -> list[Statement]:
        assert s.arc is not None
        assert s.via is not None
        start = None if before is None else self._seen(before, s)
        points = [None if e is None else self._known(e) for e in (start, s.via, s.targets[0])]
        angle = s.arc.literal
        if angle is None or s.relative is not None or any(point is None for point in points):
            says = "an arc that is given by its angle, from or over a place that the text does not tell"
            self.work.lose(s, Fate.REFUSED, "arc", says)
            return [s]
        first, via, end = (pose_of_literal(point) for point in points if point is not None)
        if np.abs(end.rotation - first.rotation).max() > _SAME_TURN:
            self.work.lose(s, Fate.APPROXIMATED, "arc", _TURNS)
        arcs = arc_by_angle(first, via.position, end, angle)
        if not arcs:
            return [replace(s, arc=None)]
        moves = [
            replace(
                s,
                arc=None,
                via=literal_of(Pose(point, pose.rotation)),
                targets=(literal_of(pose),),
                blend=Blend(BlendKind.CONTINUOUS),
                comment="",
            )
            for point, pose in arcs
        ]
        return [*moves[:-1], replace(moves[-1], blend=s.blend, comment=s.comment)]

    def _known(self, e: Expression) -> PositionLiteral | None:
        """A pose of which the text tells all six components."""
        literal = self._fixed(e)
        whole = literal is not None and literal.kind == "pose" and not any(v != v for v in literal.values[:6])
        return literal if whole else None

    # --- chains -----------------------------------------------------------------------------------------

    def _chained(self, s: Move, before: Move | None) -> tuple[list[Statement], Move | None]:
        """INFORM: an arc begins with a circular move to where the arm stands."""
        return self._chain(s, before) if s.path is Path.CIRCULAR and s.via is not None else [s], s

    def _chain(self, s: Move, before: Move | None) -> list[Statement]:
        assert s.via is not None
        through = replace(s, targets=(s.via,), via=None, blend=None, comment="")
        end = replace(s, via=None, end_of_arc=True)
        start = None if before is None else self._seen(before, s)
        if before is None or start is None:
            # Where the arm stands is asked of the controller: the chain's first point is that one.
            entry = replace(s, targets=(SystemValue("current-pose"),), via=None, blend=None, comment="")
            return [entry, through, end]
        if before.path is Path.CIRCULAR and before.via is not None and start == before.targets[0]:
            return [through, end]
        return [replace(s, targets=(start,), via=None, blend=before.blend, comment=""), through, end]

    def _seen(self, before: Move, s: Move) -> Expression | None:
        """The target of the move before, in this move's frame and with its tool; None where it is not known."""
        target = before.targets[0]
        if before.relative is not None or before.offset is not None or before.tool_offset is not None:
            return None
        same = before.tool == s.tool and before.frame == s.frame
        literal = self._fixed(target)
        if literal is not None and literal.kind == "joint":
            return None
        if same:
            return target
        poses = [self._pose(e) for e in (before.frame, before.tool, s.frame, s.tool)]
        if literal is None or any(pose is None for pose in poses):
            return None
        frame, tool, new_frame, new_tool = (pose for pose in poses if pose is not None)
        seen = new_frame.inverse() @ frame @ pose_of_literal(literal) @ tool.inverse() @ new_tool
        return self._declared("arc_start", literal_of(seen))

    def _pose(self, e: Expression | None) -> Pose | None:
        if e is None or (isinstance(e, FrameRef) and (e.kind == "base" or e.number == Number(0))):
            return Pose.identity()
        literal = self.symbols.fixed_position(self.name, e)
        return None if literal is None else pose_of_literal(literal)

    def _declared(self, stem: str, literal: PositionLiteral) -> Named:
        name = Named(self.work.helper(stem))
        declare = Declare(0, name.name, "position", literal, storage="constant", shared=True)
        self.declared.append(declare)
        from olp.transpile.symbols import Symbol

        self.symbols.table[("", name.name)] = Symbol(name.name, "position", value=literal)
        return name

    # --- whole arcs -------------------------------------------------------------------------------------

    def _whole(self, body: list[Statement]) -> list[Statement]:
        rows: list[Statement | None] = list(body)
        for chain in self._chains(body):
            self._replace(rows, body, chain)
        return [row for row in rows if row is not None]

    def _ends(self, body: list[Statement], at: int) -> bool:
        """Whether this point ends an arc and begins the next one."""
        s = body[at]
        if not isinstance(s, Move) or not s.end_of_arc:
            return False
        following = next((x for x in body[at + 1 :] if type(x).__name__ not in _STRAIGHT), None)
        return isinstance(following, Move) and following.path is Path.CIRCULAR and following.via is None

    def _collect(self, body: list[Statement], at: int) -> list[int]:
        """The moves of one chain: to a point marked as its end, or up to another kind of move."""
        chain = [at]
        for index in range(at + 1, len(body)):
            s = body[index]
            if isinstance(s, Move):
                if s.path is not Path.CIRCULAR or s.via is not None:
                    break
                chain.append(index)
                if s.end_of_arc:
                    break
            elif type(s).__name__ not in _STRAIGHT:
                break
        return chain

    def _replace(self, rows: list[Statement | None], body: list[Statement], chain: list[int]) -> None:
        moves = [body[index] for index in chain]
        assert all(isinstance(move, Move) for move in moves)
        points: list[Any] = [move.targets[0] for move in moves]  # type: ignore[union-attr]
        first = moves[0]
        assert isinstance(first, Move)
        entered = rows[chain[0]] is not body[chain[0]]  # the end of the chain before
        whole = len(chain) >= 3 and self._pairs(body, chain)
        asked = _asked_for(body, chain[0], points[0])
        if asked is not None and whole and len(chain) == 3:
            rows[asked] = rows[chain[0]] = None  # the chain's first point is where the arm stands anyway
        elif not entered:
            rows[chain[0]] = replace(first, path=Path.LINEAR, end_of_arc=False)
        if len(chain) == 2:
            second: Any = moves[1]
            rows[chain[1]] = replace(second, path=Path.LINEAR, end_of_arc=False)
        if len(chain) < 3:
            return
        last = len(chain) - 1
        for k in range(1, last - 1 if whole else last + 1):
            third = points[k + 1] if k < last else points[k - 2]
            move: Any = moves[k]
            via = self._middle(points[k - 1], points[k], third, move)
            rows[chain[k]] = replace(move, via=via, end_of_arc=False)
        if whole:
            rows[chain[last - 1]] = None
            end: Any = moves[last]
            rows[chain[last]] = replace(end, via=points[last - 1], end_of_arc=False)

    def _pairs(self, body: list[Statement], chain: list[int]) -> bool:
        """Whether the chain's last two moves are one arc: they say the same, and nothing happens between them."""
        one, two = body[chain[-2]], body[chain[-1]]
        assert isinstance(one, Move)
        assert isinstance(two, Move)
        between = body[chain[-2] + 1 : chain[-1]]
        here = {name: getattr(two, name) for name in _OF_A_POINT}
        return replace(one, **here) == two and all(isinstance(s, Comment) for s in between)

    def _middle(self, start: Any, end: Any, third: Any, s: Move) -> Expression:
        """A point half-way on the arc from `start` to `end` of the circle through `third`, which lies beyond it."""
        literals = [self._fixed(e) for e in (start, end, third)]
        if any(literal is None or literal.kind == "joint" for literal in literals):
            self.work.lose(
                s,
                Fate.REFUSED,
                "arc",
                "a chain of arcs over positions that are computed, or taught on the controller",
            )
            return end  # type: ignore[no-any-return]
        a, b, c = (pose_of_literal(literal) for literal in literals if literal is not None)
        where = half_way(a.position, b.position, c.position)
        turn = slerp(quaternion_from_rotation(a.rotation), quaternion_from_rotation(b.rotation), 0.5)
        return self._declared("arc_point", literal_of(Pose(where, rotation_from_quaternion(turn))))


def _asked_for(body: list[Statement], at: int, point: Expression) -> int | None:
    """The statement just before that reads where the arm stands into this position, if there is one."""
    for index in range(at - 1, -1, -1):
        s = body[index]
        if isinstance(s, Assign) and s.target == point:
            return index if s.value == HERE or systems_of(s.value) == (None, FrameRef("base")) else None
        if not isinstance(s, Comment):
            return None
    return None


def half_way(start: Floats, end: Floats, third: Floats) -> Floats:
    """The middle [m] of the arc from `start` to `end` that does not run through `third`, on the circle of all three."""
    u, v = end - start, third - start
    normal = np.cross(u, v)
    area = float(normal @ normal)
    if area < 1e-24:
        middle: Floats = (start + end) / 2
        return middle
    centre = start + (np.cross(normal, u) * (v @ v) + np.cross(v, normal) * (u @ u)) / (2 * area)
    radius = float(np.linalg.norm(start - centre))
    chord = (start + end) / 2 - centre
    size = float(np.linalg.norm(chord))
    # The third point lies on the other side of the chord than the wanted middle.
    away = -(third - (start + end) / 2)
    across = away - u * float(away @ u) / float(u @ u)
    direction = across / float(np.linalg.norm(across)) if size < 1e-12 else chord / size
    if float(direction @ across) < 0.0:
        direction = -direction
    result: Floats = centre + radius * direction
    return result
