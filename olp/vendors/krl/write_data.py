"""Spells declarations, data lists and the values that variables begin with."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

from olp.expression import Expression, RecordLiteral, Signal, Text, Unknown
from olp.program import Declare, Parameter
from olp.vendors.krl.neighbours import CONFIG_MARK
from olp.vendors.krl.write_values import CannotSayError, Words

_TYPES: Final = {
    "integer": "INT",
    "real": "REAL",
    "boolean": "BOOL",
    "string": "CHAR",
    "position": "E6POS",
    "joints": "E6AXIS",
    "frame": "FRAME",
    "tool": "FRAME",
    "": "REAL",
}
_TEXT_LENGTH = 80
_STRUCTURES: Final = ("ENUM", "STRUC", "SIGNAL")


def is_of_config(it: Declare) -> bool:
    """Whether the controller's own list declares it."""
    return it.native.endswith(CONFIG_MARK)


def type_word(type: str, native: str, own: bool) -> str:
    """The KRL type of a neutral one, or of KRL's own program the one that was written."""
    if own:
        return native if type in _TYPES and native else type
    if type in _TYPES:
        return _TYPES[type]
    raise CannotSayError(f"data of the type '{type}'")


def declared(words: Words, it: Declare, with_value: bool, public: bool = False) -> str:
    """`DECL E6POS XP1={…}`: one declaration, with its value where the place takes one.

    `public`: other programs use what is shared, as those of KRL itself say on their own.
    """
    shared = "GLOBAL " if it.shared and (words.own or public) else ""
    if it.native in _STRUCTURES and isinstance(it.value, (RecordLiteral, Signal)):
        return f"{shared}{_structure(words, it)}"
    constant = "CONST " if it.storage == "constant" and words.own else ""
    word = type_word(it.type, it.native, words.own)
    value = ""
    if with_value and it.value is not None and not _is_array(it):
        value = f"={words.expression(it.value)}"
    return f"DECL {shared}{constant}{word} {it.name}{_sizes(words, it)}{value}"


def _sizes(words: Words, it: Declare) -> str:
    if it.sizes:
        shown = (("" if type(one) is Unknown else words.expression(one)) for one in it.sizes)
        return f"[{','.join(shown)}]"
    return f"[{_TEXT_LENGTH}]" if it.type == "string" and not words.own else ""


def _is_array(it: Declare) -> bool:
    """Values of arrays and texts stand on lines of their own."""
    return bool(it.sizes) or it.type == "string"


def _structure(words: Words, it: Declare) -> str:
    value = it.value
    if isinstance(value, Signal):
        return f"SIGNAL {it.name} {words.signal(value)}"
    assert isinstance(value, RecordLiteral)
    if it.native == "SIGNAL":
        first, last = (words.expression(one) for _, one in value.members)
        return f"SIGNAL {it.name} {first} TO {last}"
    if it.native == "ENUM":
        names = ",".join(one.value[1:] for _, one in value.members if isinstance(one, Text))
        return f"ENUM {it.name} {names}"
    return f"STRUC {it.name} {','.join(_member(words, name, one) for name, one in value.members)}"


def _member(words: Words, name: str, it: Expression) -> str:
    assert isinstance(it, RecordLiteral)
    sizes = ",".join("" if type(one) is Unknown else words.expression(one) for _, one in it.members)
    return f"{it.type} {name}{f'[{sizes}]' if it.members else ''}"


def elements(words: Words, it: Declare) -> Iterator[str]:
    """`NAME[1]={…}`: the values of an array or a text, one line each."""
    if it.value is None or not _is_array(it):
        return
    if isinstance(it.value, RecordLiteral) and all(not name for name, _ in it.value.members):
        yield from _rows(words, it.name, "", it.value, len(it.sizes))
    elif isinstance(it.value, Text):
        yield f"{it.name}[]={words.expression(it.value)}"
    else:
        raise CannotSayError(f"the value that {it.name} begins with")


def _rows(words: Words, name: str, before: str, it: RecordLiteral, left: int) -> Iterator[str]:
    for place, (_, value) in enumerate(it.members, 1):
        if type(value) is Unknown:
            continue
        index = f"{before}{place}"
        if isinstance(value, RecordLiteral) and left > 1 and all(not one for one, _ in value.members):
            yield from _rows(words, name, f"{index},", value, left - 1)
        else:
            yield f"{name}[{index}{',' * (left - 1)}]={words.expression(value)}"


def rows(words: Words, given: Iterable[Declare], public: bool = False) -> Iterator[str]:
    """What stands between DEFDAT and ENDDAT."""
    for it in given:
        yield declared(words, it, with_value=True, public=public) + (f" ;{it.comment}" if it.comment else "")
        yield from elements(words, it)


def _is_row(it: Parameter, own: bool) -> bool:
    """Arrays, and texts of other languages, which are arrays of CHAR."""
    return it.native.endswith("[]") or (it.type == "string" and not own)


def parameters_text(given: tuple[Parameter, ...], own: bool) -> str:
    """`a :IN,b :OUT`."""
    parts = []
    for one in given:
        if one.optional or one.switch:
            raise CannotSayError(f"the optional parameter {one.name}")
        brackets = "[]" if _is_row(one, own) else ""
        parts.append(f"{one.name}{brackets} :{'OUT' if one.by_reference else 'IN'}")
    return ",".join(parts)


def parameter_rows(words: Words, given: tuple[Parameter, ...]) -> list[str]:
    """The declarations of parameters at the head of a routine."""
    rows = []
    for one in given:
        array = _is_row(one, words.own)
        if words.own and not one.type:
            continue
        word = type_word(one.type, one.native.removesuffix("[]"), words.own)
        rows.append(f"DECL {word} {one.name}{'[]' if array else ''}")
    return rows
