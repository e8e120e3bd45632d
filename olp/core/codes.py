"""What each code of a diagnostic means: `codes.toml` beside this file, which `olp help CODE` and the site print."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from olp.core import resources
from olp.core.toml import parse_toml


@cache
def code_meanings() -> Mapping[str, str]:
    """Code -> one line of Markdown. Rules of `olp lint` are not among them: they explain themselves."""
    return parse_toml(resources.read_text("core", "codes.toml"))
