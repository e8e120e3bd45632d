"""Dataclasses whose classes, and whose frozen objects, are made sooner.

`dataclass` is that of the standard library with less work per class: it compiles up to six methods one by
one, a quarter of the time that a command needs to start. Here those that have to be quick are compiled, at once.

`fast_init` is for frozen classes of which there are many objects: a program of many moves has a million. The
`__init__` that dataclasses make for a frozen class sets each field through `object.__setattr__`, a call per field.
Here the new object belongs, until its fields are set, to a class of the same layout that lets them be set.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import MISSING, Field, FrozenInstanceError, fields
from reprlib import recursive_repr
from typing import TYPE_CHECKING, Any, Final, TypeVar

if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:

    def dataclass(*, frozen=False, eq=True, repr=True, slots=False):
        """`dataclasses.dataclass` with these arguments, for classes that derive from no other dataclass.

        Fields are in `__init__` and have their place there: `kw_only` and `InitVar` are those of the library.
        """
        return lambda cls: _made_dataclass(cls, frozen, eq, repr, slots)


T = TypeVar("T")
_OPEN: Final[dict[type, type]] = {}  # of each class: the one that lets its fields be set


def _made_dataclass(whole: type[T], frozen: bool, eq: bool, repr: bool, slots: bool) -> type[T]:
    if any("__dataclass_fields__" in vars(base) for base in whole.__mro__[1:]):
        raise TypeError(f"{whole.__name__} derives from a dataclass: make it with that of the library")
    given = set(vars(whole))
    whole.__doc__ = whole.__doc__ or whole.__name__  # else one is made of the signature
    # What compiles is left out, and added below. Without `frozen` no hash is made either.
    cls: Any = dataclasses.dataclass(init=False, repr=False, eq=False, slots=slots)(whole)
    told = cls.__dataclass_params__
    told.init, told.repr, told.eq, told.frozen = True, repr, eq, frozen
    parts = fields(cls)
    if any(part.kw_only or not part.init for part in parts):
        raise TypeError(f"{whole.__name__} has fields that its __init__ does not take in their place")
    made = _compiled(cls, parts, frozen, eq and "__eq__" not in given)
    if repr:
        made["__repr__"] = _repr_of(tuple(part.name for part in parts if part.repr))
    if frozen:
        names = frozenset(part.name for part in parts)
        made |= {
            "__setattr__": _refusing(cls, names, "assign to"),
            "__delattr__": _refusing(cls, names, "delete"),
        }
        if slots:
            cls.__getstate__ = vars(whole).get("__getstate__", _state)
            cls.__setstate__ = vars(whole).get("__setstate__", _set_state)
    made_hash = made.pop("__hash__")
    for name, function in made.items():
        if name not in given:
            function.__name__ = name
            function.__qualname__ = f"{cls.__qualname__}.{name}"
            setattr(cls, name, function)
    own_hash = "__hash__" in given and vars(whole)["__hash__"] is not None
    if eq and not own_hash:
        cls.__hash__ = made_hash if frozen else None
    return cls  # type: ignore[no-any-return]


def _compiled(cls: type, parts: tuple[Field[Any], ...], frozen: bool, eq: bool) -> dict[str, Any]:
    """`__init__`, `__eq__` and `__hash__` as dataclasses write them, compiled as one text: they have to be quick."""
    rows = [f"def __init__({', '.join(['self', *map(_argument, parts)])}):"]
    for part in parts:
        value = (
            f"_make_{part.name}() if {part.name} is _default else {part.name}"
            if _is_made(part)
            else part.name
        )
        rows.append(
            f"    _set(self, {part.name!r}, {value})" if frozen else f"    self.{part.name} = {value}"
        )
    rows.append("    self.__post_init__()" if hasattr(cls, "__post_init__") else "    pass")
    if eq:
        compared = [part.name for part in parts if part.compare]
        rows += [
            "def __eq__(self, other):",
            "    if other.__class__ is self.__class__:",
            f"        return {_values('self', compared)} == {_values('other', compared)}",
            "    return NotImplemented",
        ]
    if frozen:
        hashed = [part.name for part in parts if (part.compare if part.hash is None else part.hash)]
        rows += ["def __hash__(self):", f"    return hash({_values('self', hashed)})"]
    made: dict[str, Any] = {"__hash__": None}
    exec("\n".join(rows), {"_set": object.__setattr__, "__name__": cls.__module__, **_defaults(parts)}, made)
    made["__init__"].__annotations__ = {part.name: part.type for part in parts} | {"return": None}
    return made


def _values(of: str, names: list[str]) -> str:
    """A tuple of the values of an object's fields, as text."""
    return f"({''.join(f'{of}.{name}, ' for name in names)})"


def _defaults(parts: tuple[Field[Any], ...]) -> dict[str, Any]:
    """What the text of an `__init__` names: `_default` stands for what is made anew each time."""
    known: dict[str, Any] = {"_default": MISSING}
    known |= {f"_default_{part.name}": part.default for part in parts if part.default is not MISSING}
    return known | {f"_make_{part.name}": part.default_factory for part in parts if _is_made(part)}


def _repr_of(names: tuple[str, ...]) -> Any:
    @recursive_repr()
    def shown_fields(self: Any) -> str:
        shown = ", ".join([f"{name}={getattr(self, name)!r}" for name in names])
        return f"{self.__class__.__qualname__}({shown})"

    return shown_fields


def _refusing(cls: Any, names: frozenset[str], does: str) -> Any:
    """`__setattr__` or `__delattr__` of a frozen class; a class that derives from it may have fields of its own."""
    plain = "__setattr__" if does == "assign to" else "__delattr__"

    def refused(self: Any, field: str, *value: Any) -> None:
        if type(self) is cls or field in names:
            raise FrozenInstanceError(f"cannot {does} field {field!r}")
        getattr(super(cls, self), plain)(field, *value)

    return refused


def _state(self: Any) -> list[Any]:
    """What is pickled of a frozen object without a dictionary."""
    return [getattr(self, part.name) for part in fields(self)]


def _set_state(self: Any, state: list[Any]) -> None:
    for part, value in zip(fields(self), state, strict=True):
        object.__setattr__(self, part.name, value)


def fast_init(cls: type[T]) -> type[T]:
    """`cls`, a dataclass with frozen=True and slots=True, with another `__init__` of the same arguments and effect.

    Raises TypeError for a class that this cannot be done for.
    """
    parts = fields(cls)  # type: ignore[arg-type]
    names = tuple(part.name for part in parts)
    if tuple(getattr(cls, "__slots__", ())) != names or hasattr(cls, "__post_init__"):
        raise TypeError(f"{cls.__name__} is no plain frozen dataclass with slots")
    _OPEN[cls] = type(f"_Open{cls.__name__}", (), {"__slots__": names})
    known = _defaults(parts)
    rows = ["_becomes(self, '__class__', _Open)"]
    for part in parts:
        value = f"_make_{part.name}() if {part.name} is _default else {part.name}"
        rows.append(f"self.{part.name} = {value if _is_made(part) else part.name}")
    made = _function(cls, "__init__", ", ".join(["self", *map(_argument, parts)]), rows, known)
    made.__annotations__ = dict(cls.__init__.__annotations__)
    cls.__init__ = made  # type: ignore[method-assign]
    return cls


def changer(cls: type[T]) -> Callable[[T, Mapping[str, Any]], T]:
    """`dataclasses.replace` for a class of `fast_init`: (object, fields that change) -> a copy with them.

    Fields must be those of the class: none other is noticed, or told.
    """
    rows = ["self = _new(_Open)"]
    rows += [f"self.{part.name} = old.{part.name}" for part in fields(cls)]  # type: ignore[arg-type]
    rows += ["for name in changes:", "    _becomes(self, name, changes[name])"]
    made: Callable[[T, Mapping[str, Any]], T] = _function(
        cls, "changed", "old, changes", rows, {"_new": object.__new__}, "return self"
    )
    return made


def _function(
    cls: type, name: str, arguments: str, rows: list[str], known: Mapping[str, Any], last: str = ""
) -> Any:
    """A function that ends with `self` as a `cls`, as dataclasses make theirs: all text in it is the fields' names."""
    rows = [*rows, "self.__class__ = _Closed", *([last] if last else [])]
    text = f"def {name}({arguments}):\n" + "".join(f"    {row}\n" for row in rows)
    made: dict[str, Any] = {}
    exec(text, {"_becomes": object.__setattr__, "_Open": _OPEN[cls], "_Closed": cls, **known}, made)
    made[name].__qualname__ = f"{cls.__qualname__}.{name}"
    return made[name]


def _is_made(part: Field[Any]) -> bool:
    return part.default_factory is not MISSING


def _argument(part: Field[Any]) -> str:
    if part.default is not MISSING:
        return f"{part.name}=_default_{part.name}"
    return f"{part.name}=_default" if _is_made(part) else part.name
