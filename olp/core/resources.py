"""Finds the files that are no Python: grammars, templates, robots, and `codes.toml`, what each diagnostic's code means.

A wheel carries the top-level folders inside the package, a checkout (also an editable install) beside it.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from olp.core.toml import parse_toml

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable


def folder(kind: str) -> Traversable:
    """The folder `kind` ("grammars", "templates", "robots"), wherever olp is installed, also in a zip."""
    package: Traversable = Path(__file__).parent.parent
    if not package.is_dir():
        from importlib.resources import files  # loads much, and only a zip needs it

        package = files("olp")
    shipped = package / kind
    return shipped if shipped.is_dir() else package / ".." / kind


def names(kind: str, suffix: str) -> list[str]:
    """File names in the folder `kind` that end in `suffix`, sorted, without the suffix."""
    found = (entry.name for entry in folder(kind).iterdir())
    return sorted(name.removesuffix(suffix) for name in found if name.endswith(suffix))


def read_text(kind: str, name: str) -> str:
    """The text of one file, UTF-8. Raises FileNotFoundError."""
    return (folder(kind) / name).read_text(encoding="utf-8")


@cache
def code_meanings() -> Mapping[str, str]:
    """Return the meaning of each diagnostic's code as one line of Markdown. Rules of `olp lint` describe themselves."""
    return parse_toml(read_text("core", "codes.toml"))
