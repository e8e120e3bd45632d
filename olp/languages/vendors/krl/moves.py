"""Lowers motion lines: PTP, LIN, CIRC, their relative and spline forms, WITH lists and spline blocks."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final, NamedTuple

from lark import Token

from olp.core.units import deg, mm, percent
from olp.ir import expressions as ex
from olp.ir.program import (
    Acceleration,
    AccelerationUnit,
    Blend,
    BlendKind,
    Move,
    Path,
    Process,
    Speed,
    SpeedUnit,
)
from olp.languages.lark_host import BrokenLineError
from olp.languages.vendors.krl import values
from olp.languages.vendors.krl.expressions import KrlExpressionRules
from olp.languages.vendors.krl.motion_data import MotionData
from olp.languages.vendors.krl.scope import KrlReference

PATHS: Final = {"P": Path.JOINT, "L": Path.LINEAR, "C": Path.CIRCULAR}
BLENDS: Final = {
    "C_DIS": BlendKind.RADIUS,
    "C_SPL": BlendKind.RADIUS,
    "C_PTP": BlendKind.SHARE,
    "C_VEL": BlendKind.SPEED,
    "C_ORI": BlendKind.TURN,
}
SPLINE_STOP: Final = values.STOP._replace(native="S")  # an exact stop of an S move
SPLINE_PASS: Final = Blend(BlendKind.CONTINUOUS, None, "SPL")  # within a spline block
_APPROXIMATION: Final = {
    "CDIS": (BlendKind.RADIUS, mm),
    "CPTP": (BlendKind.SHARE, percent),
    "CVEL": (BlendKind.SPEED, percent),
    "CORI": (BlendKind.TURN, deg),
}
_MOST_BLENDS = 2
# The function of a form, the member of its data that it takes, and what moves do where nothing else is said.
_RECORDS: Final = ("$VEL", "$ACC", "$APO")
_BY_FORM: Final = {
    "$IPO_MODE": ("SIPO_MODE", "IPO_FRAME", "#BASE"),
    "$ORI_TYPE": ("SORI_TYP", "ORI_TYP", "#VAR"),
}


class Setting(NamedTuple):
    """One `$NAME=value` of a WITH list."""

    target: KrlReference
    value: ex.Expression


class SplineBlock(NamedTuple):
    """SPLINE or PTP_SPLINE; `settings` hold for the block's moves that say nothing else."""

    word: str
    fields: dict[str, Any]


class SplineEnd(NamedTuple):
    """ENDSPLINE with its blend words."""

    blend: Blend


class _Frame(NamedTuple):
    word: str


class _Words(NamedTuple):
    """The blend words of a move, capitals."""

    words: tuple[str, ...]


class KrlMoveRules(KrlExpressionRules):
    def blend(self, children: list[Token]) -> _Words:
        return _Words((str(children[0].upper()),))

    def relative_frame(self, children: list[Token]) -> _Frame:
        word = children[0][1:].strip().upper()
        if word not in ("BASE", "TOOL"):
            raise BrokenLineError(
                f"a relative move has no frame '{children[0]}'",
                word=str(children[0]),
                wanted="#BASE or #TOOL",
            )
        return _Frame(word)

    def setting(self, children: list[Any]) -> Setting:
        return Setting(children[0], self.plain(children[1]))

    def with_list(self, children: list[Setting]) -> list[Setting]:
        return children

    def move(self, children: list[Any]) -> Move:
        word, target, *details = children
        return self._move(word.upper(), self.plain(target), None, None, details)

    def arc(self, children: list[Any]) -> Move:
        word, via, target, angle, *details = children
        return self._move(word.upper(), self.plain(target), self.plain(via), angle, details)

    def relative_move(self, children: list[Any]) -> Move:
        word, target, *details = children
        return self._move(word.upper(), _whole(self.plain(target)), None, None, details)

    def relative_arc(self, children: list[Any]) -> Move:
        word, via, target, angle, *details = children
        return self._move(word.upper(), _whole(self.plain(target)), _whole(self.plain(via)), angle, details)

    def _move(
        self,
        word: str,
        target: ex.Expression,
        via: ex.Expression | None,
        angle: ex.Expression | None,
        details: list[Any],
    ) -> Move:
        plain, _, relative = word.partition("_")
        spline = plain[0] == "S"
        path = Path.SPLINE if plain == "SPL" else PATHS[plain[1 if spline else 0]]
        words = [one for detail in details if type(detail) is _Words for one in detail.words]
        fields = self.fields_of([one for detail in details if type(detail) is list for one in detail])
        sizes: list[Blend] = fields.pop("sizes", [])
        fields["blend"] = _blend(words, spline, sizes)
        if fields["blend"] in (values.STOP, SPLINE_STOP) and "other" in fields:
            fields["other"] = tuple(one for one in fields["other"] if one[0] != "$APO")  # no corner, no size
        frames = [one.word for one in details if type(one) is _Frame]
        if relative:
            fields["relative"] = ex.FrameRef("tool") if frames[:1] == ["TOOL"] else ex.FrameRef("own")
        elif frames:
            raise BrokenLineError(
                f"#{frames[0]} belongs to relative moves", word="#" + frames[0], wanted="no frame"
            )
        if angle is not None:
            fields["arc"] = ex.Quantity(self.plain(angle), deg)
        return Move(0, path, (target,), via=via, **fields)

    # --- WITH -------------------------------------------------------------------------------------------

    def fields_of(self, settings: list[Setting]) -> dict[str, Any]:
        """The fields of Move that a WITH list sets; `sizes`: blends with their sizes."""
        fields: dict[str, Any] = {}
        other: list[tuple[str, ex.Expression]] = []
        data = MotionData(self.scope)
        first: dict[str, ex.Expression] = {}
        for target, value in _single(settings):
            axis = _axis_of(target)
            if _is_second_turn(target, value, fields.get("turn")):
                continue
            if axis > 1 and first.get(target.key) == value:
                continue
            if axis == 1:
                first[target.key] = value
            found = None if axis > 1 else _setting(data, target, value)
            if found is None:
                other.append((reference_text(target), value))
            elif "other" in found:
                other += found["other"]
            elif "sizes" in found:
                fields.setdefault("sizes", []).extend(found["sizes"])
            else:
                fields.update(found)
        if other:
            fields["other"] = tuple(other)
        return fields

    def spline_block(self, children: list[Any]) -> SplineBlock:
        word, *lists = children
        return SplineBlock(str(word.upper()), self.fields_of([one for each in lists for one in each]))

    def end_spline(self, children: list[Token]) -> SplineEnd:
        words = [str(one.upper()) for one in children]
        return SplineEnd(_blend(words, True, []))

    def time_block(self, children: list[Any]) -> Process:
        word, value = children
        arguments = (("", ex.Unknown(str(word.upper()))),)
        return Process(
            0, "TIME_BLOCK", arguments if value is None else (*arguments, ("=", self.plain(value)))
        )


def _blend(words: list[str], spline: bool, sizes: list[Blend]) -> Blend:
    if not words:
        return SPLINE_STOP if spline else values.STOP
    if len(words) > _MOST_BLENDS:
        raise BrokenLineError(
            "more than two ways to pass a point", word=words[-1], wanted="one, or C_PTP and another"
        )
    kind = BLENDS[words[0]]
    native = " ".join(words) if len(words) > 1 or words[0] == "C_SPL" else ""
    if spline and words[0] != "C_SPL":
        native = "S " + " ".join(words)
    size = next((one.value for one in sizes if one.kind is kind), None)
    if size is None and words[0] == "C_SPL" and sizes:
        kind, size, _ = sizes[0]  # an SPTP form gives its size as a share
    return Blend(kind, size, native)


def _whole(it: ex.Expression) -> ex.Expression:
    """Of a relative target: what is not written is 0."""
    if isinstance(it, ex.Function):
        parts = (ex.Number(0) if type(a) is ex.Number and a.value != a.value else a for a in it.arguments)
        return ex.Function(it.name, tuple(parts))
    if not isinstance(it, ex.PositionLiteral):
        return it
    numbers = tuple(0.0 if value != value else value for value in it.values)
    return ex.PositionLiteral(it.kind, numbers, it.external, it.configuration, it.native, it.sectors)


def reference_text(it: KrlReference) -> str:
    """The name as it stands in a text; indices are plain numbers there."""
    text = it.key
    for name, indices in it.parts:
        shown = ",".join(str(one.value) if type(one) is ex.Number else "" for one in indices)
        text += f".{name.upper()}" if name else f"[{shown}]"
    return text


def _setting(data: MotionData, target: KrlReference, value: ex.Expression) -> dict[str, Any] | None:
    key, member = target.key, target.parts[0][0].upper() if target.parts else ""
    call = value if isinstance(value, ex.CallValue) else ex.CallValue("")
    routine, arguments = call.routine.upper(), call.arguments
    if key == "$VEL_AXIS":
        written = arguments[0] if routine == "SVEL_JOINT" and arguments else value
        return (
            None if type(written) is ex.CallValue else {"speed": _speed(SpeedUnit.FRACTION, written, percent)}
        )
    if key == "$VEL":
        return _path_speed(data, member, value, routine, arguments)
    if key == "$ACC_AXIS":
        return _joint_acceleration(data, value, routine, arguments)
    if key == "$ACC":
        return _path_acceleration(data, member, value, routine, arguments)
    if key == "$TOOL" and not member:
        return {"tool": _by_form(data, value, routine, arguments, "TOOL_NO", ("STOOL", "STOOL2"))}
    if key == "$BASE" and not member:
        return {"frame": _by_form(data, value, routine, arguments, "BASE_NO", ("SBASE",))}
    if key == "$APO":
        return _sizes(data, member, value, routine, arguments)
    if key in _BY_FORM:
        return _as_usual(data, key, value, routine, arguments)
    return None


def _single(settings: list[Setting]) -> Iterator[Setting]:
    """`$VEL={CP 0.3,ORI1 100}` as the settings of its members."""
    for it in settings:
        if it.target.key in _RECORDS and not it.target.parts and isinstance(it.value, ex.RecordLiteral):
            for name, value in it.value.members:
                yield Setting(it.target._replace(parts=((name.upper(), ()),)), value)
        else:
            yield it


def _is_second_turn(target: KrlReference, value: ex.Expression, turn: ex.Quantity | None) -> bool:
    """Whether `$VEL.ORI2` says again what `$VEL.ORI1` says: about its own axis the tool turns as fast."""
    member = target.parts[0][0].upper() if target.parts else ""
    return target.key == "$VEL" and member == "ORI2" and turn is not None and turn.written == value


def _axis_of(target: KrlReference) -> int:
    """Which axis `$VEL_AXIS[n]` sets; 0 of other names."""
    if target.key not in ("$VEL_AXIS", "$ACC_AXIS") or not target.parts or not target.parts[0][1]:
        return 0
    index = target.parts[0][1][0]
    return int(index.value) if type(index) is ex.Number else 0


def _as_usual(
    data: MotionData, key: str, value: ex.Expression, routine: str, arguments: tuple[ex.Expression, ...]
) -> dict[str, Any] | None:
    """SIPO_MODE(FP1.IPO_FRAME), SORI_TYP(LCPDAT1), or a word: nothing, where it is what moves do anyhow."""
    form, member, usual = _BY_FORM[key]
    said: ex.Expression | None = value
    if routine == form and arguments:
        it = arguments[0]
        said = data.constant(_name(it.base if isinstance(it, ex.Member) else it), member)
        if said is None and isinstance(it, ex.Member):
            return {}  # without its list the tool stands on the flange, as for the forms of BAS
    if type(said) is not ex.Text:
        return None
    return {} if said.value.upper() == usual else {"other": ((key, said),)}


def _speed(unit: SpeedUnit, value: ex.Expression, scale: float) -> Speed:
    return Speed(unit, ex.Quantity(value, scale))


def _name(it: ex.Expression) -> str:
    return getattr(it, "name", "")


def _path_speed(
    data: MotionData, member: str, value: ex.Expression, routine: str, arguments: tuple[ex.Expression, ...]
) -> dict[str, Any] | None:
    if member == "CP":
        return {"speed": _speed(SpeedUnit.TRAVEL, value, 1.0)}
    if member == "ORI1":
        return {"turn": ex.Quantity(value, deg)}
    if routine == "SVEL_CP" and arguments:
        given = arguments[0]
        if type(given) is ex.Unknown and len(arguments) > 2:
            given = data.member(_name(arguments[2]), "VEL")
        return {"speed": _speed(SpeedUnit.TRAVEL, given, 1.0)}
    return None


def _joint_acceleration(
    data: MotionData, value: ex.Expression, routine: str, arguments: tuple[ex.Expression, ...]
) -> dict[str, Any] | None:
    if routine == "SACC_JOINT" and arguments:
        found = data.constant(_name(arguments[0]), "ACC")
        return None if found is None else {"acceleration": ex.Quantity(found, values.ACC_SPTP)}
    return None if type(value) is ex.CallValue else {"acceleration": ex.Quantity(value, percent)}


def _path_acceleration(
    data: MotionData, member: str, value: ex.Expression, routine: str, arguments: tuple[ex.Expression, ...]
) -> dict[str, Any] | None:
    if member == "CP":
        return {"rate": Acceleration(AccelerationUnit.TRAVEL, ex.Quantity(value, 1.0))}
    if routine == "SACC_CP" and arguments:
        found = data.constant(_name(arguments[0]), "ACC")
        if type(found) is ex.Number:
            rate = ex.Number(float(f"{found.value * values.ACC_CP:.12g}"))
            return {"rate": Acceleration(AccelerationUnit.TRAVEL, ex.Quantity(rate, 1.0))}
    return None


def _by_form(
    data: MotionData,
    value: ex.Expression,
    routine: str,
    arguments: tuple[ex.Expression, ...],
    member: str,
    words: tuple[str, ...],
) -> ex.Expression:
    """STOOL2(FP1), SBASE(FP1.BASE_NO), or a value."""
    by_number = data.numbered_tool if member == "TOOL_NO" else data.numbered_frame
    if routine not in words or not arguments:
        return data.tool(value) if member == "TOOL_NO" else data.frame(value)
    it = arguments[0]
    if isinstance(it, ex.Member):
        return by_number(data.constant(_name(it.base), it.name.upper()) or it)
    if routine == "STOOL2":
        return by_number(data.member(_name(it), member) if _name(it) else it)
    return by_number(it)


def _sizes(
    data: MotionData, member: str, value: ex.Expression, routine: str, arguments: tuple[ex.Expression, ...]
) -> dict[str, Any] | None:
    if member in _APPROXIMATION:
        kind, scale = _APPROXIMATION[member]
        return {"sizes": [Blend(kind, ex.Quantity(value, scale))]}
    if routine == "SAPO" and arguments:
        distance = data.constant(_name(arguments[0]), "APO_DIST")
        return None if distance is None else {"sizes": [Blend(BlendKind.RADIUS, ex.Quantity(distance, mm))]}
    if routine == "SAPO_PTP" and arguments:
        known = data.constant(_name(arguments[0]), "APO_DIST") is not None
        return {"sizes": list(data.joint_blends(_name(arguments[0])))} if known else None
    return None
