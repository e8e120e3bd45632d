"""Functions of RAPID with options, or whose neutral form is another: positions, texts, clocks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Final

from olp.ir.expressions import (
    Expression,
    FrameRef,
    Function,
    Named,
    NamedArgument,
    Number,
    SignalState,
    SystemValue,
)
from olp.languages.lark_host import BrokenLineError
from olp.languages.vendors.rapid import literals
from olp.languages.vendors.rapid.syntax import RapidArgument

if TYPE_CHECKING:
    from olp.languages.vendors.rapid.expressions import RapidExpressionRules

_USUAL: Final[Mapping[tuple[str, str], Expression]] = {
    ("tool", "tool0"): FrameRef("tool", Number(0)),
    ("wobj", "wobj0"): FrameRef("base"),
}
_EULER: Final = ("x", "y", "z")
_ZEROS: Final = (Number(0), Number(0), Number(0))


def _value(rules: RapidExpressionRules, given: list[RapidArgument], place: int, kind: str = "") -> Expression:
    values = [one.value for one in given if one.value is not None]
    if place >= len(values) or values[place] is None:
        raise BrokenLineError(f"argument {place + 1} of a function is missing", word="(")
    return rules.coerce(values[place], kind)


def _options(rules: RapidExpressionRules, given: list[RapidArgument]) -> dict[str, Expression]:
    found = {}
    for one in given:
        for option in one.options:
            found[option.name.lower()] = (
                SignalState(True) if option.value is None else rules.coerce(option.value, "")
            )
    return found


def _rel_tool(rules: RapidExpressionRules, given: list[RapidArgument]) -> Expression:
    options = _options(rules, given)
    angles = tuple(options.get(name, Number(0)) for name in ("rx", "ry", "rz"))
    return Function(
        "pose-relative-tool",
        (
            _value(rules, given, 0, "robtarget"),
            *(_value(rules, given, n) for n in (1, 2, 3)),
            *angles,
        ),
    )


def _euler(rules: RapidExpressionRules, given: list[RapidArgument]) -> Expression | None:
    letter = next((name for name in _options(rules, given) if name in _EULER), None)
    if letter is None:
        return None
    return literals.turn_parts(_value(rules, given, 0, "orient"))["xyz".index(letter)]


def _orient(rules: RapidExpressionRules, given: list[RapidArgument]) -> Expression:
    z, y, x = (_value(rules, given, n) for n in range(3))
    return Function("pose-angles", (*_ZEROS, x, y, z))


def _distance(rules: RapidExpressionRules, given: list[RapidArgument]) -> Expression:
    return Function("pose-distance", (_value(rules, given, 0, "pos"), _value(rules, given, 1, "pos")))


def _place_now(rules: RapidExpressionRules, given: list[RapidArgument]) -> Expression:
    """CRobT and its like; in which frame and with which tool is kept where it is written."""
    options = _options(rules, given)
    if not options:
        return SystemValue("current-pose")
    return Function("current-pose", tuple(NamedArgument(name, value) for name, value in _kept(rules, given)))


def _joints_now(rules: RapidExpressionRules, given: list[RapidArgument]) -> Expression:
    options = tuple(NamedArgument(name, value) for name, value in _kept(rules, given))
    return Function("current-joints", options) if options else SystemValue("current-joints")


def _kept(rules: RapidExpressionRules, given: list[RapidArgument]) -> list[tuple[str, Expression | None]]:
    return [
        (option.name, None if option.value is None else _system(rules, option.name, option.value))
        for one in given
        for option in one.options
    ]


def _system(
    rules: RapidExpressionRules, name: str, value: Expression | literals.RapidAggregate
) -> Expression:
    """tool0 and wobj0 are the flange and the base."""
    key = (name.lower(), value.name.lower()) if isinstance(value, Named) else ("", "")
    return _USUAL.get(key) or rules.coerce(value, "")


def _solved(name: str, kind: str) -> Callable[[RapidExpressionRules, list[RapidArgument]], Expression]:
    """CalcRobT, CalcJointT: the tool and the work object behind the position."""

    def lowered(rules: RapidExpressionRules, given: list[RapidArgument]) -> Expression:
        values = rules.plain_arguments(given, (kind,))
        return Function(name, values)

    return lowered


def _text(rules: RapidExpressionRules, given: list[RapidArgument]) -> Expression:
    return Function("text-of-value", rules.plain_arguments(given))


def _timer(rules: RapidExpressionRules, given: list[RapidArgument]) -> Expression | None:
    value = given[0].value if given else None
    number = rules.names.clocks.get(value.name.lower()) if isinstance(value, Named) else None
    return None if number is None else SystemValue("timer", number)


def _present(rules: RapidExpressionRules, given: list[RapidArgument]) -> Expression:
    return Function("given", (_value(rules, given, 0),))


Special = Callable[["RapidExpressionRules", list[RapidArgument]], Expression | None]
# None: the function is called as it is written.
SPECIAL: Final[Mapping[str, Special]] = {
    "reltool": _rel_tool,
    "eulerzyx": _euler,
    "orientzyx": _orient,
    "distance": _distance,
    "crobt": _place_now,
    "cjointt": _joints_now,
    "cpos": lambda rules, given: (
        None if _options(rules, given) else literals.place_of(SystemValue("current-pose"))
    ),
    "calcrobt": _solved("forward", "jointtarget"),
    "calcjointt": _solved("inverse", "robtarget"),
    "numtostr": _text,
    "valtostr": _text,
    "clkread": _timer,
    "present": _present,
}
