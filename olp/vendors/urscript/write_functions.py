"""Spells neutral functions: URScript's own word, an expression of them, or one of olp's helpers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from olp import called
from olp.expression import Expression, Function, Item, NamedArgument, Number, PositionLiteral
from olp.units import deg, mm
from olp.vendors.urscript import builtins, helpers
from olp.vendors.urscript.folding import scaled
from olp.vendors.urscript.write_values import CannotSayError, Words

_WHOLE = 9
_EULER = 2.718281828459045
_ORIGIN = (Number(0.0), Number(0.0), Number(0.0))


def function(words: Words, e: Function) -> tuple[str, int]:
    """The text and how tightly it holds together. Raises CannotSayError for a function that URScript has not."""
    special = _SPECIAL.get(e.name)
    if special is not None:
        return special(words, e.arguments)
    if e.name in builtins.FUNCTION_WORDS and e.name != "joined-text":
        return f"{builtins.FUNCTION_WORDS[e.name]}({words.arguments(e.arguments)})", _WHOLE
    if e.name in helpers.WORDS:
        return words.helper(helpers.WORDS[e.name], e.arguments)
    if words.own or e.name in builtins.KNOWN:
        return f"{e.name}({words.arguments(e.arguments)})", _WHOLE
    raise CannotSayError(called.function(e.name))


def pose(words: Words, values: tuple[Expression, ...]) -> str:
    """p[…] of metres and radians."""
    return f"p[{', '.join(words.value(value) for value in values)}]"


def _angle(word: str) -> Callable[[Words, tuple[Expression, ...]], tuple[str, int]]:
    return lambda words, arguments: (f"{word}({words.radians(arguments[0])})", _WHOLE)


def _arc(word: str) -> Callable[[Words, tuple[Expression, ...]], tuple[str, int]]:
    return lambda words, arguments: (f"r2d({word}({words.arguments(arguments)}))", _WHOLE)


def _joints(words: Words, arguments: tuple[Expression, ...]) -> tuple[str, int]:
    values = [
        words.value(scaled(one, deg)) if type(one) is Number else words.radians(one) for one in arguments
    ]
    return f"[{', '.join(values)}]", _WHOLE


def _inverse(words: Words, arguments: tuple[Expression, ...]) -> tuple[str, int]:
    first, *rest = arguments
    near = [f"qnear={words.value(one)}" for one in rest[:1] if type(one) is not NamedArgument]
    more = [words.value(one) for one in rest[len(near) :]]
    return f"get_inverse_kin({', '.join([words.value(first), *near, *more])})", _WHOLE


def _vector(words: Words, arguments: tuple[Expression, ...]) -> tuple[str, int]:
    return pose(words, arguments), _WHOLE


def _element(words: Words, arguments: tuple[Expression, ...]) -> tuple[str, int]:
    base, index = arguments
    return words.element(Item(base, (index,))), _WHOLE


def _offset(words: Words, arguments: tuple[Expression, ...]) -> tuple[str, int]:
    """Positions of the two add, and the second turn is none."""
    base, *shift = arguments
    lengths = tuple(scaled(one, mm) for one in shift)
    return f"pose_add({words.value(base)}, {pose(words, (*lengths, *_ORIGIN))})", _WHOLE


def _relative(words: Words, arguments: tuple[Expression, ...]) -> tuple[str, int]:
    """Shift and turns one after the other, each about an axis that the ones before have turned."""
    base, *numbers = arguments
    shift = tuple(scaled(one, mm) for one in numbers[:3])
    text, turned = words.value(base), False
    for axis, angle in enumerate(numbers[3:6]):
        if angle in (Number(0), Number(0.0)):
            continue
        turn = list(_ORIGIN)
        turn[axis] = Number(0.0)
        written = [words.value(one) for one in turn]
        written[axis] = words.value(scaled(angle, deg)) if type(angle) is Number else words.radians(angle)
        place = ", ".join(words.value(one) for one in (_ORIGIN if turned else shift))
        text, turned = f"pose_trans({text}, p[{place}, {', '.join(written)}])", True
    if not turned:
        text = f"pose_trans({text}, {pose(words, (*shift, *_ORIGIN))})"
    return text, _WHOLE


def _joined(words: Words, arguments: tuple[Expression, ...]) -> tuple[str, int]:
    if not arguments:
        return '""', _WHOLE
    text = words.value(arguments[0])
    for one in arguments[1:]:
        text = f"str_cat({text}, {words.value(one)})"
    return text, _WHOLE


def _part(words: Words, arguments: tuple[Expression, ...]) -> tuple[str, int]:
    text, start, *count = arguments
    first = words.index(start)
    if count == [Number(1)]:
        return f"str_at({words.value(text)}, {first})", _WHOLE
    return f"str_sub({', '.join([words.value(text), first, *map(words.value, count)])})", _WHOLE


def _found(words: Words, arguments: tuple[Expression, ...]) -> tuple[str, int]:
    return f"str_find({words.arguments(arguments)}) + 1", 6


def _power_of_e(words: Words, arguments: tuple[Expression, ...]) -> tuple[str, int]:
    return f"pow({_EULER}, {words.value(arguments[0])})", _WHOLE


def _logarithm(words: Words, arguments: tuple[Expression, ...]) -> tuple[str, int]:
    return f"log({_EULER}, {words.value(arguments[0])})", _WHOLE


def _distance(words: Words, arguments: tuple[Expression, ...]) -> tuple[str, int]:
    return f"point_dist({words.arguments(arguments)}) * 1000.0", 7


def _run(words: Words, arguments: tuple[Expression, ...]) -> tuple[str, int]:
    return f"run {words.value(arguments[0])}", 8


def _absolute(words: Words, arguments: tuple[Expression, ...]) -> tuple[str, int]:
    return f"norm({words.arguments(arguments)})", _WHOLE


def _length(words: Words, arguments: tuple[Expression, ...]) -> tuple[str, int]:
    return f"str_len({words.arguments(arguments)})", _WHOLE


def _forward(words: Words, arguments: tuple[Expression, ...]) -> tuple[str, int]:
    return f"get_forward_kin({words.arguments(arguments)})", _WHOLE


def _angles(words: Words, arguments: tuple[Expression, ...]) -> tuple[str, int]:
    """pose-angles of numbers is a pose like any other."""
    if all(type(one) is Number for one in arguments) and len(arguments) == 6:
        factors = (mm, mm, mm, deg, deg, deg)
        values = tuple(
            float(one.value) * factor
            for one, factor in zip(arguments, factors, strict=True)
            if isinstance(one, Number)
        )
        return words.rated(PositionLiteral("pose", values))
    return words.helper("olp_pose", arguments)


_SPECIAL: Final[Mapping[str, Callable[[Words, tuple[Expression, ...]], tuple[str, int]]]] = {
    **{word: _angle(word) for word in builtins.FROM_ANGLE},
    **{word: _arc(word) for word in builtins.TO_ANGLE},
    "joints": _joints,
    "inverse": _inverse,
    "forward": _forward,
    "pose-vector": _vector,
    "pose-element": _element,
    "pose-offset": _offset,
    "pose-relative-tool": _relative,
    "pose-angles": _angles,
    "pose-distance": _distance,
    "joined-text": _joined,
    "part-of-text": _part,
    "position-in-text": _found,
    "length-of-text": _length,
    "exp": _power_of_e,
    "log": _logarithm,
    "abs": _absolute,
    "run": _run,
}
