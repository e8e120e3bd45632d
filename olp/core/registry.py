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
    """The modules beside that of `base`, or in `folder` beside it, sorted, without loading them; none with _ first."""
    return member_names(_package(base, folder), base.__module__.rpartition(".")[2])


def member_names(package: str, besides: str = "") -> tuple[str, ...]:
    """The modules of `package`, sorted, without loading them; none with _ first, and not `besides`, its base.

    By the package's name: for those below it, which must not import it.
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
    """An instance, made with `values`, of the class that the module `name` derives from `base` (see `file_names`).

    Raises OlpError (`code`) for a name that is none, listing `others` and those there are; `kind` says what it is in
    words.
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
