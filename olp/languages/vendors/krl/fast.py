"""Plain lines without the grammar: a generated program has 100,000 of them.

`literal` understands aggregates of numbers, `KrlMoveLines.read` moves to them or to names, `declared` a position among
the statements, and `row` the rows of a data list; each gives exactly what the grammar gives (a test compares the two).
Whatever else a line holds, they decline.
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Final

from olp.core.units import deg, mm
from olp.ir.expressions import Expression, Named, PositionLiteral
from olp.ir.points import Sector
from olp.ir.program import Blend, Declare, Move, Path
from olp.languages.vendors.krl import values
from olp.languages.vendors.krl.moves import BLENDS
from olp.languages.vendors.krl.scope import AXES, NEUTRAL_TYPES, POSES, Scope

_NUMBER = r"[+-]?\d{1,9}(?:\.\d{0,15})?"
_PART = rf"[A-Z]\d?\s+{_NUMBER}"
_TAG = r"(?:(?:E6POS|POS|FRAME|E6AXIS|AXIS)\s*:\s*)?"
MOVE_LINE: Final = re.compile(
    r"(PTP|LIN)\s*(?:(\{[^{}]*\})|(?<=\s)([A-Z]\w*))(?:\s+(C_(?:PTP|DIS|VEL|ORI)(?:\s+C_DIS)?))?",
    re.IGNORECASE | re.ASCII,
)
ROW: Final = re.compile(
    r"(?:DECL\s+)?(GLOBAL\s+)?(?:DECL\s+)?(E6POS|POS|FRAME|E6AXIS|AXIS)\s+([A-Z_]\w*)\s*=\s*(\{[^{}]*\})",
    re.IGNORECASE | re.ASCII,
)
_AGGREGATE = re.compile(
    rf"\{{\s*{_TAG}{_PART}(?:\s*,\s*{_PART})*\s*\}}", re.IGNORECASE | re.ASCII
)  # any that is plain
RECORD_ROW: Final = re.compile(
    r"(?:DECL\s+)?(GLOBAL\s+)?(?:DECL\s+)?(FDAT|PDAT|LDAT)\s+([A-Z_]\w*)\s*=\s*(\{[^{}]*\})",
    re.IGNORECASE | re.ASCII,
)
NUMBER_ROW: Final = re.compile(
    r"([A-Z_$][\w$]*(?:\[\d{1,4}\])?(?:\.[A-Z_]\w*)?)\s*=\s*(\d{1,9}(?:\.\d{0,15})?)",
    re.IGNORECASE | re.ASCII,
)  # a number to a variable
ACTUAL: Final = re.compile(r"([PLF]DAT_ACT)\s*=\s*([A-Z_]\w*)", re.IGNORECASE | re.ASCII)
_PAIR = re.compile(rf"([A-Za-z]\d?)\s+({_NUMBER})")
_POSE = re.compile(
    rf"\{{X ({_NUMBER}), ?Y ({_NUMBER}), ?Z ({_NUMBER}), ?A ({_NUMBER}), ?B ({_NUMBER}), ?C ({_NUMBER})"
    r"(?:, ?S (\d{1,3}))?(?:, ?T (\d{1,3}))?\}",
    re.ASCII,
)
_POSE_KEYS = frozenset("XYZABCST") | frozenset(values.EXTERNALS)
_AXIS_KEYS = frozenset(f"A{n}" for n in range(1, 7)) | frozenset(values.EXTERNALS)
_PATHS: Final = {"P": Path.JOINT, "p": Path.JOINT, "L": Path.LINEAR, "l": Path.LINEAR}
POSITIONS: Final = POSES | AXES
_LONGEST: Final = 400  # characters; no line within them has more than the grammar is given
_KEYWORD = re.compile(r"C_\w+|TRUE|FALSE", re.IGNORECASE)


def literal(text: str, kind: str = "") -> PositionLiteral | None:
    """`{X 1, Y 2 …}` as a value of the type `kind` (capitals), or None when it is not plain."""
    match = _POSE.fullmatch(text)
    if match is not None and kind not in AXES:
        *numbers, status, turn = match.groups()
        x, y, z, a, b, c = map(float, numbers)
        pose = (x * mm, y * mm, z * mm, c * deg, b * deg, a * deg)
        if status is None and turn is None:
            return PositionLiteral("pose", pose)
        flags, native, sectors = _arm(status, turn)
        return PositionLiteral("pose", pose, (), flags, native, sectors)
    if _AGGREGATE.fullmatch(text) is None:
        return None
    colon = text.find(":")
    if colon > 0:
        kind = text[1:colon].strip().upper()
        text = text[colon:]
    given: dict[str, float] = {}
    for key, number in _PAIR.findall(text):
        given[key.upper()] = float(number)
    keys = given.keys()
    if kind in POSES or (kind not in AXES and keys <= _POSE_KEYS):
        return _pose(given) if keys <= _POSE_KEYS else None
    return _axes(given) if keys <= _AXIS_KEYS else None


@lru_cache(maxsize=1000)
def _arm(
    status: str | None, turn: str | None
) -> tuple[tuple[int, ...], tuple[tuple[str, str], ...], tuple[Sector, ...]]:
    """The configuration that S says, S and T as they are written, and the signs that T says."""
    native = tuple((key, str(int(one))) for key, one in (("S", status), ("T", turn)) if one is not None)
    if status is None:
        return (), native, ()
    return values.flags(int(status)), native, () if turn is None else values.signs(int(turn))


def _pose(given: dict[str, float]) -> PositionLiteral | None:
    nan = values.NOTHING
    pose = tuple(
        given[key] * scale if key in given else nan
        for key, scale in zip(values.POSE_ORDER, values.POSE_SCALES, strict=True)
    )
    native = tuple((key, str(int(given[key]))) for key in ("S", "T") if key in given)
    configuration = values.flags(int(given["S"])) if "S" in given else ()
    sectors = values.signs(int(given["T"])) if "S" in given and "T" in given else ()
    return PositionLiteral("pose", pose, _external(given), configuration, native, sectors)


def _axes(given: dict[str, float]) -> PositionLiteral:
    nan = values.NOTHING
    axes = tuple(given[key] * deg if key in given else nan for key in ("A1", "A2", "A3", "A4", "A5", "A6"))
    return PositionLiteral("joint", axes, _external(given))


def _external(given: dict[str, float]) -> tuple[float, ...]:
    if "E1" not in given and not any(key in given for key in values.EXTERNALS):
        return ()
    last = max(place for place, key in enumerate(values.EXTERNALS, 1) if key in given)
    return tuple(given.get(key, values.NOTHING) for key in values.EXTERNALS[:last])


def declared(code: str, scope: Scope) -> Declare | None:
    """The position that `code` declares and gives a value, known to `scope` from then on; None: it is not plain."""
    match = ROW.fullmatch(code) if len(code) <= _LONGEST else None
    if match is None:
        return None
    shared, word, name, aggregate = match.groups()
    kind = word.upper()
    value = literal(aggregate, kind)
    if value is None:
        return None
    scope.declare(name, kind)
    scope.values[name.upper()] = value
    return Declare(0, scope.spell(name), NEUTRAL_TYPES[kind], value, (), "variable", bool(shared), kind)


class KrlMoveLines:
    """Reads plain PTP and LIN lines of one routine; equal words share one object."""

    def __init__(self, scope: Scope) -> None:
        self._scope = scope
        self._blends: dict[str | None, Blend] = {None: values.STOP}

    def read(self, code: str, number: int, comment: str) -> Move | None:
        """The move in `code`, or None when it is not plain."""
        match = MOVE_LINE.fullmatch(code)
        if match is None:
            return None
        word, aggregate, name, passed = match.groups()
        target: Expression | None
        if aggregate is not None:
            target = literal(aggregate)
            if target is None:
                return None
        else:
            if name[0] in "CcTtFf" and _KEYWORD.fullmatch(name):
                return None
            if self._scope.signals_at_all and self._scope.signal(name.upper()) is not None:
                return None
            target = Named(self._scope.spell(name))
        blend = self._blends.get(passed) or self._blend(passed)
        return Move(number, _PATHS[word[0]], (target,), None, blend, (), comment)

    def _blend(self, word: str | None) -> Blend:
        assert word is not None
        words = word.upper().split()
        found = Blend(BLENDS[words[0]], native=" ".join(words) if len(words) > 1 else "")
        self._blends[word] = found
        return found
