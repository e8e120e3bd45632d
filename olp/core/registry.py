"""Models, laws, formats and methods are files of a folder, that of their base class or one in it."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any, TypeVar, cast

from olp.core.diagnostic import OlpError, error

Base = TypeVar("Base")


@lru_cache(maxsize=64)
def file_names(base: type, folder: str = "") -> tuple[str, ...]:
    """Return the names of the modules beside that of `base`, or in `folder` beside it, sorted, without importing
    them.

    Modules whose name starts with _ and that of `base` are left out.
    """
    return member_names(_package(base, folder), base.__module__.rpartition(".")[2])


def member_names(package: str, besides: str = "") -> tuple[str, ...]:
    """Return the names of the modules of `package`, sorted, without importing them.

    Modules whose name starts with _ and the module `besides` are left out. `package` is a name because packages
    below it must not import it.
    """
    names = (module.name for module in pkgutil.iter_modules(importlib.import_module(package).__path__))
    return tuple(sorted(name for name in names if name != besides and not name.startswith("_")))


def load_from(
    base: Callable[..., Base],
    name: str,
    kind: str,
    code: str,
    *,
    folder: str = "",
    others: tuple[str, ...] = (),
    values: Mapping[str, Any] | None = None,
) -> Base:
    """Return an instance of the subclass of `base` that the module `name` defines, made with the arguments
    `values`.

    `kind`: the word for such a member in messages. Raises OlpError (`code`) for an unknown name, with a list of
    `others` and the known ones, and for a module without such a class.
    """
    assert isinstance(base, type)
    known = file_names(base, folder)
    if name not in known:
        listed = ", ".join((*others, *known))
        raise OlpError(error(code, f"there is no {kind} {name!r}", help=f"available: {listed}"))
    package = _package(base, folder)
    module = importlib.import_module(f"{package}.{name}")
    for thing in vars(module).values():
        if isinstance(thing, type) and issubclass(thing, base) and thing.__module__ == module.__name__:
            return cast(Base, thing(**(values or {})))
    raise OlpError(error(code, f"{package.replace('.', '/')}/{name}.py defines no {kind}"))


def _package(base: type, folder: str) -> str:
    package = base.__module__.rpartition(".")[0]
    return f"{package}.{folder}" if folder else package
