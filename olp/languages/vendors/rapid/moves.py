"""Lowers instructions that move: which argument is what, speeds and zones, and what is kept beside them."""

from __future__ import annotations

import re
from typing import Final, NamedTuple

from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir.program import Blend, BlendKind, Move, Path, Search, Speed, SpeedUnit
from olp.languages.lark_host import BrokenLineError
from olp.languages.vendors.rapid.expressions import RapidExpressionRules
from olp.languages.vendors.rapid.literals import RapidAggregate, number_text, numbers
from olp.languages.vendors.rapid.names import RapidNames
from olp.languages.vendors.rapid.predefined_data import SPEEDS, ZONES, as_number
from olp.languages.vendors.rapid.syntax import RapidArgument, RapidOption

OWN: Final = "\\"  # marks an option in `Move.other`: the letter of its argument, this, its name


class ArgumentLayout(NamedTuple):
    """Roles of the first and the last arguments: t target, j axes, v via, s speed, z zone, o tool, x of the process."""

    path: Path
    head: str
    tail: str = ""


_J, _L, _C = Path.JOINT, Path.LINEAR, Path.CIRCULAR
LAYOUTS: Final[dict[str, ArgumentLayout]] = {
    "movej": ArgumentLayout(_J, "tszo"),
    "movel": ArgumentLayout(_L, "tszo"),
    "movec": ArgumentLayout(_C, "vtszo"),
    "moveabsj": ArgumentLayout(_J, "jszo"),
    **{f"move{c}{s}": ArgumentLayout(p, h) for c, p, h in (("j", _J, "tszo"), ("l", _L, "tszo"), ("c", _C, "vtszo"))
       for s in ("do", "ao", "go", "sync")},
    **{f"{w}j{s}": ArgumentLayout(_J, "ts", "zo") for w, s in (("trigg", ""), ("paint", ""), ("arc", ""))},
    "triggabsj": ArgumentLayout(_J, "js", "zo"),
    "triggjios": ArgumentLayout(_J, "tszo"),
    "trigglios": ArgumentLayout(_L, "tszo"),
    **{w: ArgumentLayout(_L, "ts", "zo") for w in (
        "triggl", "paintl", "arcl", "arcl1", "arcl2", "arclstart", "arclend", "arcl1start", "arcl1end",
        "arcl2start", "arcl2end", "arclistart", "displ", "laserl", "cutl", "capl", "glul", "dispensel",
        "arcmovel", "arcrefill", "fricwavel")},
    **{w: ArgumentLayout(_C, "vts", "zo") for w in (
        "triggc", "paintc", "arcc", "arcc1", "arcc2", "arccstart", "arccend", "arcc1start", "arcc1end",
        "arcc2start", "arcc2end", "dispc", "laserc", "cutc", "capc", "arcmovec")},
    **{w: ArgumentLayout(_J, "ts", "zo") for w in ("arcmovej", "arcmoveabsj", "arcjstart")},
    "searchl": ArgumentLayout(_L, "xxts", "o"),
    "searchc": ArgumentLayout(_C, "xxvts", "o"),
    **{w: ArgumentLayout(p, "ts", "o") for w, p in (
        ("spotl", _L), ("spotj", _J), ("spotml", _L), ("spotmj", _J), ("swingl", _L), ("nutl", _L), ("nutj", _J),
        ("calibl", _L), ("calibj", _J))},
}  # fmt: skip
PLAIN: Final = frozenset({"movej", "movel", "movec", "moveabsj"})
# Those that weld all the way: ArcLStart strikes the arc at its end.
_WELDS: Final = re.compile(r"arc[lc][12]?(?:end)?", re.IGNORECASE)
_KINDS: Final = {"t": "robtarget", "v": "robtarget", "j": "jointtarget", "o": "tooldata"}
_ROLE_WORDS: Final = {"t": "target", "v": "via point", "j": "target", "s": "speed", "z": "zone", "o": "tool"}


def lower_move(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Move:
    """A move, its line 0. Raises BrokenLineError where arguments are missing or too many."""
    layout = LAYOUTS[name.lower()]
    leading = [option for one in given if one.value is None for option in one.options]
    positional = [one for one in given if one.value is not None]
    roles = _roles(name, layout, positional)
    found = {role: one for role, one in zip(roles, positional, strict=True) if role != "x"}
    other = _process(rules, name, roles, positional)
    reader = _Arguments(rules, found)
    target = reader.value("j") if "j" in found else reader.value("t")
    if rules.names.unturned:
        rules.names.unturned = False
        raise BrokenLineError("a quaternion of zeros is no rotation", word="[")
    speed, turn = reader.speed()
    if speed is not None and _WELDS.fullmatch(name) and len(extra := _extra(roles, positional)) > 1:
        speed = _weld_speed(rules, extra[1], speed)
    frame, options = reader.frame_and_options()
    search = _search(rules, positional) if name.lower().startswith("search") else None
    for option in leading:
        if option.name.lower() != "conc":
            other.append((f"{OWN}{option.name}", _switch(rules, option)))
    return Move(
        0,
        layout.path,
        (target,),
        speed,
        reader.zone(),
        no_wait=any(option.name.lower() == "conc" for option in leading),
        search=search,
        other=(*other, *options),
        via=reader.value("v") if "v" in found else None,
        turn=turn,
        tool=reader.tool(),
        frame=frame,
    )


def _extra(roles: str, positional: list[RapidArgument]) -> list[RapidArgument]:
    """The arguments of the process."""
    return [one for role, one in zip(roles, positional, strict=True) if role == "x"]


def _weld_speed(rules: RapidExpressionRules, weld: RapidArgument, speed: Speed) -> Speed:
    """While it welds, the tool moves as the weld data say and not as the speed of the instruction does."""
    native = f"{speed.native}{OWN}weld"
    if isinstance(weld.value, RapidAggregate) and weld.value.items:
        return Speed(SpeedUnit.TRAVEL, ex.Quantity(rules.coerce(weld.value.items[0], ""), mm), native)
    if not isinstance(weld.value, ex.Named):
        return speed
    found = rules.names.steady(weld.value.name, "welddata")
    number = ex.Member(weld.value, "weld_speed") if found is None else as_number(float(found[0]))
    return Speed(SpeedUnit.TRAVEL, ex.Quantity(number, mm), native)


def _roles(name: str, layout: ArgumentLayout, positional: list[RapidArgument]) -> str:
    head, tail = layout.head, layout.tail
    extra = len(positional) - len(head) - len(tail)
    if extra < 0:
        role = (head + tail)[len(positional)]
        words = ", ".join(_ROLE_WORDS.get(role, "value") for role in head + tail)
        raise BrokenLineError(
            f"{name} has no {_ROLE_WORDS.get(role, 'value')}", word=name, wanted=f"{name} {words}"
        )
    if extra and name.lower() in PLAIN:
        raise BrokenLineError(
            f"{name} has {len(positional)} arguments, which is too many",
            word=name,
            wanted="a semicolon behind the tool",
        )
    return head + "x" * extra + tail


def _process(
    rules: RapidExpressionRules, name: str, roles: str, positional: list[RapidArgument]
) -> list[tuple[str, ex.Expression]]:
    """The instruction's own word and arguments, where it is more than a move."""
    if name.lower() in PLAIN:
        return []
    found: list[tuple[str, ex.Expression]] = [(name, ex.SignalState(True))]
    for role, one in zip(roles, positional, strict=True):
        if role == "x" and one.value is not None:
            found.append(("", rules.coerce(one.value, "")))
            found += [(f"{OWN}{option.name}", _switch(rules, option)) for option in one.options]
    return found


def _switch(rules: RapidExpressionRules, option: RapidOption) -> ex.Expression:
    if option.value is None:
        return ex.NamedArgument(option.name)
    return rules.coerce(option.value, "")


def _search(rules: RapidExpressionRules, positional: list[RapidArgument]) -> Search | None:
    value = positional[0].value
    signal = rules.signal(value, "in") if isinstance(value, (ex.Named, ex.Signal)) else None
    options = {option.name.lower() for one in positional[:2] for option in one.options}
    return None if signal is None else Search(signal, "nflank" not in options and "lowlevel" not in options)


class _Arguments:
    """The arguments of one move by their roles."""

    def __init__(self, rules: RapidExpressionRules, found: dict[str, RapidArgument]) -> None:
        self.rules = rules
        self.found = found

    def value(self, role: str) -> ex.Expression:
        value = self.found[role].value
        assert value is not None
        return self._named_or(value, _KINDS[role])

    def _named_or(self, value: ex.Expression | RapidAggregate, kind: str) -> ex.Expression:
        """A name stays one, also that of data which every controller has."""
        return value if isinstance(value, ex.Named) else self.rules.coerce(value, kind)

    def _options(self, role: str) -> dict[str, ex.Expression | RapidAggregate | None]:
        one = self.found.get(role)
        return {} if one is None else {option.name.lower(): option.value for option in one.options}

    def speed(self) -> tuple[Speed | None, ex.Quantity | None]:
        one = self.found["s"]
        assert one.value is not None
        speed, turn = speed_of(one.value, self.rules.names)
        options = self._options("s")
        time, travel = options.get("t"), options.get("v")
        if time is not None:
            return Speed(SpeedUnit.TIME, ex.Quantity(self.rules.coerce(time, ""), 1.0), speed.native), turn
        if travel is not None:
            native = f"{speed.native}{OWN}V"
            return Speed(SpeedUnit.TRAVEL, ex.Quantity(self.rules.coerce(travel, ""), mm), native), turn
        return speed, turn

    def zone(self) -> Blend:
        one = self.found.get("z")
        if one is None:
            return Blend(BlendKind.RADIUS, ex.Quantity(ex.Number(0), mm))
        assert one.value is not None
        blend = blend_of(one.value, self.rules.names)
        options = self._options("z")
        if "inpos" in options:  # the stop point's data take the place of the zone
            return Blend(BlendKind.RADIUS, ex.Quantity(ex.Number(0), mm), blend.native)
        wanted = options.get("z")
        if wanted is not None:
            return Blend(blend.kind, ex.Quantity(self.rules.coerce(wanted, ""), mm), f"{blend.native}{OWN}Z")
        return blend

    def tool(self) -> ex.Expression | None:
        return tool_of(self.value("o")) if "o" in self.found else None

    def frame_and_options(self) -> tuple[ex.Expression, tuple[tuple[str, ex.Expression], ...]]:
        """The work object, and all options that are kept as written."""
        frame: ex.Expression = ex.FrameRef("base")
        kept = []
        for role, one in self.found.items():
            for option in one.options:
                key = option.name.lower()
                if (role, key) in (("s", "t"), ("s", "v")):
                    continue
                if (role, key) == ("z", "z") and "inpos" not in self._options("z"):
                    continue
                if key in ("wobj", "wobj?") and option.value is not None:
                    frame = frame_of(self._named_or(option.value, "wobjdata"))
                else:
                    kept.append((f"{role}{OWN}{option.name}", _switch(self.rules, option)))
        return frame, tuple(kept)


def tool_of(value: ex.Expression) -> ex.Expression:
    """tool0 is the flange."""
    if isinstance(value, ex.Named) and value.name.lower() == "tool0":
        return ex.FrameRef("tool", ex.Number(0))
    return value


def frame_of(value: ex.Expression) -> ex.Expression:
    """wobj0 is the world, which is the base unless the controller's configuration moves it."""
    if isinstance(value, ex.Named) and value.name.lower() == "wobj0":
        return ex.FrameRef("base")
    return value


def speed_of(value: ex.Expression | RapidAggregate, names: RapidNames) -> tuple[Speed, ex.Quantity | None]:
    """Travel speed and bound of the turn rate of a speeddata."""
    if isinstance(value, ex.Named):
        found = named_speed(value.name, names)
        if found is not None:
            return found
    written = numbers(value, 4)
    if written is not None:
        return _speed(written, f"[{','.join(map(number_text, written))}]")
    if isinstance(value, RapidAggregate):
        items = [item for item in value.items if not isinstance(item, RapidAggregate)]
        if len(items) != len(value.items) or len(items) != 4:
            raise BrokenLineError("this is no speed", word="[", wanted="[v_tcp, v_ori, v_leax, v_reax]")
        return Speed(SpeedUnit.TRAVEL, ex.Quantity(items[0], mm), ""), ex.Quantity(items[1], deg)
    native = value.name if isinstance(value, ex.Named) else ""
    turn = ex.Quantity(ex.Member(value, "v_ori"), deg)
    return Speed(SpeedUnit.TRAVEL, ex.Quantity(ex.Member(value, "v_tcp"), mm), native), turn


def named_speed(name: str, names: RapidNames) -> tuple[Speed, ex.Quantity | None] | None:
    """A predefined speed, or a user's that nobody assigns; None for all others."""
    key = name.lower()
    if not names.knows(key):
        return _speed(SPEEDS[key], key) if key in SPEEDS else None
    texts = names.steady(key, "speeddata")
    if texts is None:
        return None
    values = SPEEDS.get(texts[0]) if len(texts) == 1 else _floats(texts, 4)
    return None if values is None else _speed(values, names.spelled(name))


def _speed(values: tuple[float, ...], native: str) -> tuple[Speed, ex.Quantity]:
    travel, turn = ex.Quantity(as_number(values[0]), mm), ex.Quantity(as_number(values[1]), deg)
    return Speed(SpeedUnit.TRAVEL, travel, native), turn


def blend_of(value: ex.Expression | RapidAggregate, names: RapidNames) -> Blend:
    """The radius of a zonedata; 0 for a stop point."""
    if isinstance(value, ex.Named):
        found = named_blend(value.name, names)
        if found is not None:
            return found
    if isinstance(value, RapidAggregate):
        flag, rest = value.items[:1], numbers(RapidAggregate(value.items[1:]), 6)
        size = value.items[1] if len(value.items) == 7 else value
        if not flag or not isinstance(flag[0], ex.SignalState) or isinstance(size, RapidAggregate):
            raise BrokenLineError(
                "this is no zone", word="[", wanted="[finep, pzone_tcp, pzone_ori, pzone_eax, zone_ori, …]"
            )
        if rest is None:
            return Blend(BlendKind.RADIUS, ex.Quantity(ex.Number(0) if flag[0].on else size, mm), "")
        native = f"[{'TRUE' if flag[0].on else 'FALSE'},{','.join(map(number_text, rest))}]"
        return _blend(0.0 if flag[0].on else rest[0], native)
    native = value.name if isinstance(value, ex.Named) else ""
    radius: ex.Expression = ex.Member(value, "pzone_tcp")
    base = value.base if isinstance(value, ex.Item) else value
    if isinstance(base, ex.Named) and base.name.lower() in names.stopping:
        radius = ex.Function("zone-or-stop", (ex.Member(value, "finep"), radius))
    return Blend(BlendKind.RADIUS, ex.Quantity(radius, mm), native)


def named_blend(name: str, names: RapidNames) -> Blend | None:
    """A predefined zone, or a user's that nobody assigns; None for all others."""
    key = name.lower()
    if not names.knows(key):
        return _blend(ZONES[key].values[0], key) if key in ZONES else None
    texts = names.steady(key, "zonedata")
    if texts is None:
        return None
    if len(texts) == 1 and texts[0] in ZONES:
        return _blend(ZONES[texts[0]].values[0], names.spelled(name))
    values = _floats(texts[1:], 6)
    if values is None or texts[0].upper() not in ("TRUE", "FALSE"):
        return None
    return _blend(0.0 if texts[0].upper() == "TRUE" else values[0], names.spelled(name))


def _blend(radius: float, native: str) -> Blend:
    return Blend(BlendKind.RADIUS, ex.Quantity(as_number(radius), mm), native)


def _floats(texts: tuple[str, ...], count: int) -> tuple[float, ...] | None:
    if len(texts) != count:
        return None
    try:
        values = tuple(float(text) for text in texts)
    except ValueError:
        return None
    return values if all(abs(value) < 1e9 for value in values) else None
