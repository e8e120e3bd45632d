"""Frozen dataclasses that are built as fast as open ones: a program of many moves has a million of them.

The `__init__` that dataclasses make for a frozen class sets each field through `object.__setattr__`, a call per field.
Here the new object belongs, until its fields are set, to a class of the same layout that lets them be set.
"""

from __future__ import annotations

from dataclasses import MISSING, Field, fields
from typing import Any, TypeVar

T = TypeVar("T")


def fast_init(cls: type[T]) -> type[T]:
    """`cls`, a dataclass with frozen=True and slots=True, with another `__init__` of the same arguments and effect.

    Raises TypeError for a class that this cannot be done for.
    """
    parts = fields(cls)  # type: ignore[arg-type]
    names = tuple(part.name for part in parts)
    if tuple(getattr(cls, "__slots__", ())) != names or hasattr(cls, "__post_init__"):
        raise TypeError(f"{cls.__name__} is no plain frozen dataclass with slots")
    open_class = type(f"_Open{cls.__name__}", (), {"__slots__": names})
    known: dict[str, Any] = {"_becomes": object.__setattr__, "_Open": open_class, "_Closed": cls}
    known |= {f"_default_{part.name}": part.default for part in parts if part.default is not MISSING}
    known |= {
        f"_make_{part.name}": part.default_factory for part in parts if part.default_factory is not MISSING
    }
    arguments = ", ".join(["self", *map(_argument, parts)])
    rows = [f"def __init__({arguments}):", "    _becomes(self, '__class__', _Open)"]
    for part in parts:
        value = part.name
        if part.default_factory is not MISSING:
            value = f"_make_{value}() if {value} is _default else {value}"
            known["_default"] = MISSING
        rows.append(f"    self.{part.name} = {value}")
    rows.append("    self.__class__ = _Closed")
    made: dict[str, Any] = {}
    # As dataclasses do it themselves; all text in it is the class' own field names.
    exec("\n".join(rows), known, made)
    made["__init__"].__qualname__ = f"{cls.__qualname__}.__init__"
    made["__init__"].__annotations__ = dict(cls.__init__.__annotations__)
    cls.__init__ = made["__init__"]  # type: ignore[misc]
    return cls


def _argument(part: Field[Any]) -> str:
    if part.default is not MISSING:
        return f"{part.name}=_default_{part.name}"
    return f"{part.name}=_default" if part.default_factory is not MISSING else part.name
