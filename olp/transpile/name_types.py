"""What the uses of a name say of its type: the kinds that functions take, and what was seen of one name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from olp.ir.program import Statement

PLACES: Final = ("joints", "tool", "frame", "position")
TARGET: Final = "target"  # of a joint move, which goes to axis values or to a pose
# What a name is when its uses say several things: the first of these.
KINDS: Final = (*PLACES, "string", "boolean", "integer", "real")
COMPONENTS: Final = frozenset({"x", "y", "z", "rx", "ry", "rz", *(f"e{n}" for n in range(1, 7))})
AXES: Final = frozenset(f"a{n}" for n in range(1, 7))
NUMERIC: Final = ("integer", "real")
# What functions take, the last one repeated.
_TAKES: Final[Mapping[str, tuple[str, ...]]] = {
    "pose-offset": ("position", "real"),
    "pose-relative-tool": ("position", "real"),
    "pose-product": ("position",),
    "pose-inverse": ("position",),
    "pose-distance": ("position",),
    "pose-element": ("position", "integer"),
    "pose-interpolate": ("position", "position", "real"),
    "pose-add": ("position",),
    "pose-subtract": ("position",),
    "pose-angles": ("real",),
    "pose-quaternion": ("real",),
    "pose-vector": ("real",),
    "inverse": ("position",),
    "forward": ("joints",),
    "joints": ("real",),
    "length-of-text": ("string",),
    "joined-text": ("string",),
    "part-of-text": ("string", "integer"),
    "position-in-text": ("string",),
    "code-of-character": ("string",),
    "text-of-value": ("",),
}
_NUMBERS: Final = frozenset(
    {"sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "abs", "round", "trunc", "floor", "ceil"}
)


def taken(function: str, count: int) -> tuple[str, ...]:
    """What a function takes its `count` arguments for, "" where that tells nothing."""
    takes = _TAKES.get(function, ("real",) if function in _NUMBERS else ("",))
    return tuple(takes[min(at, len(takes) - 1)] for at in range(count))


@dataclass(slots=True)
class Use:
    """One name. `kinds`: what its uses, or those of its elements, take it for. `lines`: the first statement with it.

    `indices`: each use as an array; an index that is computed is None, one that a loop counts its largest value.
    `records`: members that no position has. `whole`: it is used without an index, too.
    """

    name: str
    first: Statement
    kinds: set[str] = field(default_factory=set)
    indices: list[tuple[int | None, ...]] = field(default_factory=list)
    computed: set[int] = field(default_factory=set)  # lines with an index that nothing bounds
    records: set[str] = field(default_factory=set)
    whole: bool = False
    assigned: bool = False

    @property
    def kind(self) -> str:
        """Its type, as `Declare.type` says it; a name of which nothing can be told is a number."""
        return next(
            (kind for kind in KINDS if kind in self.kinds), "position" if TARGET in self.kinds else "real"
        )

    @property
    def sizes(self) -> tuple[int, ...]:
        """The largest index of each dimension, 0 where none is known; () of what is no array."""
        if not self.indices or (self.kind == "joints" and self.whole):
            return ()
        count = max(map(len, self.indices))
        known = [[row[at] or 0 for row in self.indices if at < len(row)] for at in range(count)]
        return tuple(max(column, default=0) for column in known)
