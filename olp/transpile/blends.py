"""How the ends of moves are passed, in the target's kinds: levels, radii, shares of the way, shares of the speed."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Final

from olp.core.units import mm, percent
from olp.ir import terminology
from olp.ir.expressions import Binary, Expression, Number, Quantity
from olp.ir.program import Blend, BlendKind, Move, Path, Program, Statement
from olp.ir.transformer import edited
from olp.languages.limits import range_text, within
from olp.runtime.folder import DEFAULT_ZONES
from olp.transpile.context import Fate, TranslationContext, walk_through
from olp.transpile.line_executions import LineExecutions, MoveExecution, moves_at_all

STOP: Final = Blend(BlendKind.RADIUS, Quantity(Number(0), mm))
_LEVEL_STOP: Final = Blend(BlendKind.LEVEL, Quantity(Number(0), 1.0))
_ORDER: Final = (BlendKind.RADIUS, BlendKind.LEVEL, BlendKind.SHARE, BlendKind.SPEED)
_SIZED: Final = frozenset({BlendKind.RADIUS, BlendKind.LEVEL})
_NOTHING: Final = 1e-6  # [m] below this two blends are one
_GRAIN: Final = 1e-5  # [m] by which a blend that is cut stays apart from its neighbour
_ACCELERATION: Final = 5.0  # [m/s²] where no robot says; only to bring shares of speed and lengths together
_LEAST_TIME: Final = 0.1  # [s] of braking, as olp.timing.blending.fanuc assumes it


def blends(program: Program, work: TranslationContext) -> Program:
    """Every move's blend in a kind that the target has; what differs is in the losses, in mm."""
    own = _Blends(work, program)
    routines = tuple(
        replace(r, body=tuple([own.move(s, r.name) if type(s) is Move else s for s in r.body]))
        for r in program.routines
    )
    return replace(program, routines=routines)


@dataclass(slots=True)
class _Blends:
    work: TranslationContext
    program: Program
    rows: LineExecutions = field(init=False)
    shown: dict[int, float] | None = None
    known: dict[tuple[object, ...], Blend] = field(default_factory=dict)
    plain: dict[Blend, Blend] = field(default_factory=dict)  # without the source's names

    def __post_init__(self) -> None:
        self.rows = LineExecutions(self.work)

    def move(self, s: Statement, routine: str) -> Statement:
        assert isinstance(s, Move)
        new = self._blend(s, routine)
        if new is not None and not self.work.limits.blends_may_overlap:
            new = self._apart(s, new)
        if new is not None:
            new = self._within(s, new)
        return s if new is s.blend else edited(s, {"blend": new})

    def _blend(self, s: Move, routine: str) -> Blend | None:
        blend, limits = s.blend, self.work.limits
        allowed = (
            limits.joint_blends if s.path is Path.JOINT and limits.joint_blends is not None else limits.blends
        )
        stop = _LEVEL_STOP if BlendKind.LEVEL in limits.blends else STOP
        if blend is None or blend.kind is BlendKind.CONTINUOUS:
            return self._unsized(s, allowed)
        size = None if blend.value is None else blend.value.literal
        if size is None and blend.value is not None:
            if self._is_zero(blend.value.written, routine):
                size = 0.0
            elif limits.zero_blend_passes and blend.kind in allowed:
                says = "where the size of its corner is 0 the arm stops, and here what follows may be done before"
                self.work.lose(s, Fate.APPROXIMATED, "blend", says)
        if (
            size is not None
            and size <= 0.0
            and not (blend.kind is BlendKind.SPEED and BlendKind.SPEED in allowed)
        ):
            return stop
        if blend.kind in allowed and blend.kind is not BlendKind.LEVEL:
            if not blend.native:
                return blend
            plain = self.plain.get(blend)
            if plain is None:
                plain = self.plain[blend] = blend._replace(native="")
            return plain
        if size is None:
            says = (
                "the size of a blend is in a variable, in a kind that the target does not have: an exact stop"
            )
            self.work.lose(s, Fate.APPROXIMATED, "blend", says)
            return stop
        if blend.kind in _SIZED and next((k for k in _ORDER if k in allowed), None) in _SIZED:
            # What a level or a length becomes does not depend on the move.
            key = (blend.kind, size, allowed)
            known = self.known.get(key)
            if known is not None:
                return known
            losses = len(self.work.losses)
            made = self._converted(s, blend.kind, size, allowed) or stop
            if len(self.work.losses) == losses:
                self.known[key] = made
            return made
        return self._converted(s, blend.kind, size, allowed) or stop

    def _is_zero(self, e: Expression, routine: str) -> bool:
        """Whether a size is 0 whatever happens: of a variable that nothing changes, or a product with one."""
        if isinstance(e, Binary) and e.operator == "*":
            return self._is_zero(e.left, routine) or self._is_zero(e.right, routine)
        value = self.work.symbols(self.program).fixed_value(routine, e)
        return isinstance(value, Number) and value.value == 0

    def _within(self, s: Move, blend: Blend) -> Blend:
        """The nearest size that the target takes; an exact stop is none."""
        bounds = self.work.limits.blend_ranges.get(blend.kind)
        size = None if bounds is None or blend.value is None else blend.value.literal
        if bounds is None or size is None or size <= 0.0:
            return blend
        scale, unit = (mm, "mm") if blend.kind is BlendKind.RADIUS else (percent, "%")
        near, says = within(size, bounds), range_text(bounds, scale, unit)
        step = self.work.limits.radius_step if blend.kind is BlendKind.RADIUS else 0.0
        if step and abs(near - round(near / step) * step) > _NOTHING:
            near, says = max(round(near / step), 1) * step, f"rounded to {step / mm:g} mm"
        if near == size:
            return blend
        self.work.lose(s, Fate.APPROXIMATED, "blend", says, abs(near - size) / scale, unit)
        return Blend(blend.kind, Quantity(Number(_clean(near / scale)), scale))

    def _apart(self, s: Move, blend: Blend) -> Blend:
        """A radius that leaves the other half of both its ways to the neighbours' blends."""
        size = None if blend.value is None else blend.value.literal
        if size is None or size <= 0.0 or blend.kind is not BlendKind.RADIUS:
            return blend
        room = self._room(s)
        if size < room:
            return blend
        cut = max(math.ceil(room / _GRAIN) - 1, 0) * _GRAIN
        says = "longer than half of the path, where two blends overlap and the robot would skip the point: reduced"
        self.work.lose(s, Fate.APPROXIMATED, "blend", says, (size - cut) / mm, "mm")
        return Blend(BlendKind.RADIUS, Quantity(Number(_clean(cut / mm)), mm))

    def _room(self, s: Move) -> float:
        """[m] half of the shorter way at a move's point: from the text where it shows both, else from the plan."""
        if self.shown is None:
            # That of a pass before will do: it changed no place, and no line.
            self.shown = (self.work.walk or walk_through(self.program, self.work)).rooms()
        known = self.shown.get(s.line)
        return self.rows.room(s) if known is None else known

    def _unsized(self, s: Move, allowed: frozenset[BlendKind]) -> Blend | None:
        """Passed without a stop, however near: the smallest zone is the nearest that can be said."""
        if BlendKind.LEVEL in allowed:
            return None
        zone = self._zones()[0]
        says = "passed without a stop and without a size: the smallest zone of the source is written"
        self.work.lose(s, Fate.APPROXIMATED, "blend", says, zone / mm, "mm")
        return self._of_size(s, zone, allowed)[0]

    def _converted(
        self, s: Move, kind: BlendKind, value: float, allowed: frozenset[BlendKind]
    ) -> Blend | None:
        size = self._size(s, kind, value)
        shown = size is not None
        if size is None:
            says = "its size depends on a move that this run does not show: the smallest zone is used"
            self.work.lose(s, Fate.APPROXIMATED, "blend", says)
            if BlendKind.LEVEL in allowed:
                return Blend(BlendKind.LEVEL, Quantity(Number(1), 1.0))
            size = self._zones()[0]
        blend, off = self._of_size(s, size, allowed)
        if blend is None:
            self.work.lose(
                s, Fate.APPROXIMATED, "blend", "no blend that the target has: an exact stop", size / mm, "mm"
            )
        elif not off <= _NOTHING:
            says = f"{terminology.BLENDS[kind]} written as {terminology.BLENDS[blend.kind]}"
            self.work.lose(s, Fate.APPROXIMATED, "blend", says, off / mm, "mm")
        elif shown and not {kind, blend.kind} <= _SIZED:
            # Shares of a way or a speed are lengths in one run alone, with a braking that is assumed.
            says = f"{terminology.BLENDS[kind]} written as {terminology.BLENDS[blend.kind]}, as it is in this run"
            self.work.lose(s, Fate.APPROXIMATED, "blend", says)
        return blend

    # --- sizes ------------------------------------------------------------------------------------------

    def _zones(self) -> tuple[float, ...]:
        robot = self.work.robot if self.work.conventions.blend_levels else self.work.target_robot
        return robot.blend_zones if robot is not None and robot.blend_zones else DEFAULT_ZONES

    def _size(self, s: Move, kind: BlendKind, value: float) -> float | None:
        """[m] from the corner, None where the plan does not show the move."""
        if kind is BlendKind.RADIUS:
            return value
        if kind is BlendKind.LEVEL:
            zones = self._zones()
            return zones[min(round(value), len(zones)) - 1]
        found = [row for row in self.rows.of(s) if row.length == row.length and moves_at_all(row)]
        if not found:
            return None
        row = found[0]
        if kind is BlendKind.SHARE:
            return 0.5 * value * row.length
        if kind is BlendKind.SPEED:
            return value**2 * self._braking(row)
        return row.length * min(value / row.angle, 1.0) if row.angle > 0 else 0.5 * row.length

    def _of_size(self, s: Move, size: float, allowed: frozenset[BlendKind]) -> tuple[Blend | None, float]:
        """A blend of the target that begins `size` [m] from the corner, and how far off it is [m]."""
        kind = next((kind for kind in _ORDER if kind in allowed), None)
        if kind is None:
            return None, size
        if kind is BlendKind.RADIUS:
            radius = size
            if step := self.work.limits.radius_step:
                radius = round(radius / step) * step
            return Blend(kind, Quantity(Number(_clean(radius / mm)), mm)), abs(size - radius)
        if kind is BlendKind.LEVEL:
            zones = self._zones()
            level = min(range(len(zones)), key=lambda at: abs(zones[at] - size))
            return Blend(kind, Quantity(Number(level + 1), 1.0)), abs(zones[level] - size)
        found = [row for row in self.rows.of(s) if row.length == row.length and row.length > 0]
        most = (
            0.5 * found[0].length
            if found and kind is BlendKind.SHARE
            else self._braking(found[0])
            if found
            else 0.0
        )
        if not most:
            return Blend(kind, Quantity(Number(50), percent)), math.nan
        share = size / most if kind is BlendKind.SHARE else math.sqrt(size / most)
        written = max(1, min(100, round(100 * share)))
        back = most * (written / 100 if kind is BlendKind.SHARE else (written / 100) ** 2)
        return Blend(kind, Quantity(Number(written), percent)), abs(back - size)

    def _braking(self, row: MoveExecution) -> float:
        """[m] that braking from the programmed speed takes: where a passage at full speed (CNT100) begins."""
        speed = row.travel
        if math.isnan(speed):
            robot = self.work.robot
            known = (
                [a / w for a, w in zip(row.axes, robot.speeds.tolist(), strict=False)]
                if robot is not None
                else []
            )
            time = max(known, default=math.nan) / (row.fraction if row.fraction == row.fraction else 1.0)
            speed = row.length / time if time > 0 else 1.0
        robot = self.work.robot
        push = robot.linear_acceleration if robot is not None and robot.linear_acceleration else _ACCELERATION
        return speed * max(speed / push, _LEAST_TIME) / 2


def _clean(value: float) -> float:
    return float(f"{value:.9g}")
