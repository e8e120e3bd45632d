"""Frozen dataclasses that are built as fast as open ones: a program of many moves has a million of them.

The `__init__` that dataclasses make for a frozen class sets each field through `object.__setattr__`, a call per field.
Here the new object belongs, until its fields are set, to a class of the same layout that lets them be set; the slots of
few fields are set themselves.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import MISSING, Field, fields
from typing import Any, Final, TypeVar

T = TypeVar("T")
_FEW: Final = 4  # fields: to set their slots one by one is faster than to change the class there and back
_OPEN: Final[dict[type, type]] = {}  # of each class: the one that lets its fields be set


def fast_init(cls: type[T]) -> type[T]:
    """`cls`, a dataclass with frozen=True and slots=True, with another `__init__` of the same arguments and effect.

    Raises TypeError for a class that this cannot be done for.
    """
    parts = fields(cls)  # type: ignore[arg-type]
    names = tuple(part.name for part in parts)
    if tuple(getattr(cls, "__slots__", ())) != names or hasattr(cls, "__post_init__"):
        raise TypeError(f"{cls.__name__} is no plain frozen dataclass with slots")
    _OPEN[cls] = type(f"_Open{cls.__name__}", (), {"__slots__": names})
    known: dict[str, Any] = {"_default": MISSING}
    known |= {f"_default_{part.name}": part.default for part in parts if part.default is not MISSING}
    known |= {f"_make_{part.name}": part.default_factory for part in parts if _is_made(part)}
    values = [
        f"_make_{part.name}() if {part.name} is _default else {part.name}" if _is_made(part) else part.name
        for part in parts
    ]
    arguments = ", ".join(["self", *map(_argument, parts)])
    if len(parts) <= _FEW:
        known |= {f"_set_{name}": getattr(cls, name).__set__ for name in names}
        rows = [f"_set_{name}(self, {value})" for name, value in zip(names, values, strict=True)]
        made = _function(cls, "__init__", arguments, rows or ["pass"], known, is_open=False)
    else:
        rows = ["_becomes(self, '__class__', _Open)"]
        rows += [f"self.{name} = {value}" for name, value in zip(names, values, strict=True)]
        made = _function(cls, "__init__", arguments, rows, known)
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
    cls: type,
    name: str,
    arguments: str,
    rows: list[str],
    known: Mapping[str, Any],
    last: str = "",
    is_open: bool = True,
) -> Any:
    """A function that ends with `self` as a `cls`, as dataclasses make theirs: all text in it is the fields' names."""
    rows = [*rows, *(["self.__class__ = _Closed"] if is_open else []), *([last] if last else [])]
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
