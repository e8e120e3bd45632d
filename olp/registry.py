"""Models, laws and formats are files of the folder that their base class lives in: its listing is the list of them."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable
from functools import cache
from typing import Any, TypeVar, cast

from olp.diagnostic import OlpError, error

Base = TypeVar("Base")


@cache
def file_names(base: type) -> tuple[str, ...]:
    """The modules beside that of `base`, sorted, without loading them; not those that begin with _."""
    package, _, home = base.__module__.rpartition(".")
    names = (module.name for module in pkgutil.iter_modules(importlib.import_module(package).__path__))
    return tuple(sorted(name for name in names if name != home and not name.startswith("_")))


def load_from(base: Callable[..., Base], name: str, kind: str, code: str, **values: Any) -> Base:
    """An instance, made with `values`, of the class that the module `name` beside that of `base` derives from it.

    Raises OlpError (`code`) for a name that is none, listing those there are; `kind` says what it is in words.
    """
    assert isinstance(base, type)
    known = file_names(base)
    if name not in known:
        raise OlpError(error(code, f"there is no {kind} {name!r}", help=f"available: {', '.join(known)}"))
    package = base.__module__.rpartition(".")[0]
    module = importlib.import_module(f"{package}.{name}")
    for thing in vars(module).values():
        if isinstance(thing, type) and issubclass(thing, base) and thing.__module__ == module.__name__:
            return cast(Base, thing(**values))
    raise OlpError(error(code, f"{package.replace('.', '/')}/{name}.py defines no {kind}"))
