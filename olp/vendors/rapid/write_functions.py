"""Spells functions: of positions, which need their parts in RAPID's order, and of numbers with options."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Final

from olp.expression import (
    Expression,
    Function,
    Item,
    Member,
    NamedArgument,
    Number,
    PositionLiteral,
)

if TYPE_CHECKING:
    from olp.vendors.rapid.write_values import Words

NO_AXES: Final = "[9E9,9E9,9E9,9E9,9E9,9E9]"
NO_CONFIGURATION: Final = "[0,0,0,0]"
_POSES: Final = {"pose-product": "PoseMult", "pose-inverse": "PoseInv"}
_XYZ: Final = ("x", "y", "z")
_ANGLES: Final = ("rx", "ry", "rz")
_ZEROS: Final = (Number(0), Number(0), Number(0))


def _pose_call(word: str) -> Callable[[Words, tuple[Expression, ...], str], str]:
    def spelled(words: Words, arguments: tuple[Expression, ...], kind: str) -> str:
        text = f"{word}({','.join(map(words.as_pose, arguments))})"
        if kind != "robtarget":
            return text
        name = words.temporary_name("pose")
        words.before.append(f"{name}:={text};")
        return f"[{name}.trans,{name}.rot,{NO_CONFIGURATION},{NO_AXES}]"

    return spelled


def _offset(words: Words, arguments: tuple[Expression, ...], kind: str) -> str:
    return f"Offs({words.as_robtarget(arguments[0])},{','.join(map(words.value, arguments[1:4]))})"


def _relative(words: Words, arguments: tuple[Expression, ...], kind: str) -> str:
    angles = "".join(
        f"\\{name}:={words.value(value)}"
        for name, value in zip(("Rx", "Ry", "Rz"), arguments[4:7], strict=False)
        if value != Number(0)
    )
    moved = ",".join(map(words.value, arguments[1:4]))
    return f"RelTool({words.as_robtarget(arguments[0])},{moved}{angles})"


def common_base(values: tuple[Expression, ...], names: tuple[str, ...]) -> Expression | None:
    """The position whose members these are, None when they are not all of one."""
    bases = [
        one.base
        for one, name in zip(values, names, strict=True)
        if isinstance(one, Member) and one.name == name
    ]
    return bases[0] if len(bases) == len(names) and all(base == bases[0] for base in bases) else None


def place_text(words: Words, values: tuple[Expression, ...]) -> str:
    """`p.trans`, or `[x,y,z]`."""
    base = common_base(values, _XYZ)
    return words.place(base) if base is not None else f"[{','.join(map(words.value, values))}]"


def turn_text(words: Words, values: tuple[Expression, ...]) -> str:
    """`p.rot`, or `OrientZYX(z,y,x)`."""
    base = common_base(values, _ANGLES)
    if base is not None:
        return words.turn(base)
    return f"OrientZYX({','.join(words.value(value) for value in reversed(values))})"


def _of_angles(words: Words, arguments: tuple[Expression, ...], kind: str) -> str:
    place, turn, rest = arguments[:3], arguments[3:6], arguments[6:]
    if kind == "pos" or (not kind and turn == _ZEROS and place != _ZEROS):
        return place_text(words, place)
    if kind == "orient" or (not kind and place == _ZEROS):
        return turn_text(words, turn)
    turned = "[1,0,0,0]" if turn == _ZEROS else turn_text(words, turn)
    return _assembled(words, place_text(words, place), turned, rest, kind)


def _of_quaternion(words: Words, arguments: tuple[Expression, ...], kind: str) -> str:
    turn = f"[{','.join(map(words.value, arguments[3:7]))}]"
    if kind == "orient" or (not kind and arguments[:3] == _ZEROS):
        return turn
    return _assembled(words, place_text(words, arguments[:3]), turn, arguments[7:], kind)


def _assembled(words: Words, place: str, turn: str, rest: tuple[Expression, ...], kind: str) -> str:
    if kind == "pose":
        return f"[{place},{turn}]"
    given = {one.name: one.value for one in rest if isinstance(one, NamedArgument) and one.value is not None}
    arm = words.value(given["conf"]) if "conf" in given else NO_CONFIGURATION
    axes = words.value(given["axes"]) if "axes" in given else NO_AXES
    return f"[{place},{turn},{arm},{axes}]"


def _added(words: Words, arguments: tuple[Expression, ...], kind: str) -> str:
    first, second = (words.stored(one, "robtarget").name for one in arguments)
    name = words.temporary_name("pose")
    words.before.append(f"{name}:=PoseMult([[0,0,0],{first}.rot],[[0,0,0],{second}.rot]);")
    place = ",".join(f"{first}.trans.{c}+{second}.trans.{c}" for c in _XYZ)
    return _assembled(words, f"[{place}]", f"{name}.rot", (), kind)


def robjoint_text(words: Words, values: tuple[Expression, ...]) -> str:
    """`j.robax`, a robjoint, or `[…]`."""
    if len(values) == 6:
        items = [one for one in values if isinstance(one, Item)]
        if [one.indices for one in items] == [(Number(n),) for n in range(1, 7)] and len(
            {one.base for one in items}
        ) == 1:
            return f"{words.value(items[0].base)}.robax"
        base = common_base(values, tuple(f"rax_{n}" for n in range(1, 7)))
        if base is not None:
            return words.value(base)
    return f"[{words.joints(Function('joints', values))}]"


def _joints(words: Words, arguments: tuple[Expression, ...], kind: str) -> str:
    return f"[{robjoint_text(words, arguments)},{NO_AXES}]"


def _solved(word: str, inner: str) -> Callable[[Words, tuple[Expression, ...], str], str]:
    def spelled(words: Words, arguments: tuple[Expression, ...], kind: str) -> str:
        first = words.as_robtarget(arguments[0]) if inner == "robtarget" else words.value(arguments[0], inner)
        tool = words.value(arguments[1]) if len(arguments) > 1 and words.own else "tool0"
        frame = f"\\WObj:={words.value(arguments[2])}" if len(arguments) > 2 and words.own else ""
        return f"{word}({first},{tool}{frame})"

    return spelled


def _distance(words: Words, arguments: tuple[Expression, ...], kind: str) -> str:
    def pos(it: Expression) -> str:
        return words.value(it, "pos") if isinstance(it, (Function, PositionLiteral)) else words.place(it)

    return f"Distance({pos(arguments[0])},{pos(arguments[1])})"


def _text(words: Words, arguments: tuple[Expression, ...], kind: str) -> str:
    word = "NumToStr" if len(arguments) > 1 else "ValToStr"
    return f"{word}({','.join(map(words.value, arguments))})"


def _round(words: Words, arguments: tuple[Expression, ...], kind: str) -> str:
    digits = f"\\Dec:={words.value(arguments[1])}" if len(arguments) > 1 else ""
    return f"Round({words.value(arguments[0])}{digits})"


FUNCTIONS: Final[dict[str, Callable[[Words, tuple[Expression, ...], str], str]]] = {
    **{name: _pose_call(word) for name, word in _POSES.items()},
    "pose-offset": _offset,
    "pose-relative-tool": _relative,
    "pose-angles": _of_angles,
    "pose-quaternion": _of_quaternion,
    "pose-add": _added,
    "joints": _joints,
    "forward": _solved("CalcRobT", "jointtarget"),
    "inverse": _solved("CalcJointT", "robtarget"),
    "pose-distance": _distance,
    "text-of-value": _text,
    "round": _round,
    "given": lambda words, arguments, kind: f"Present({words.value(arguments[0])})",
    "current-pose": lambda words, arguments, kind: f"CRobT({words.arguments(arguments)})",
    "current-joints": lambda words, arguments, kind: f"CJointT({words.arguments(arguments)})",
}
