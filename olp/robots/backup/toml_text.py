"""Values as a robot file writes them, and what may be a robot's name."""

from __future__ import annotations

import json
import re
from typing import Final

ROBOT_NAME: Final = re.compile(r"[a-z0-9][a-z0-9._-]{0,40}/[a-z0-9][a-z0-9._-]{0,60}")


def shown(value: float) -> str:
    """A number without needless zeros: a TOML integer where it is whole."""
    return f"{value + 0.0:.9f}".rstrip("0").rstrip(".")


def quoted(text: str) -> str:
    """A TOML basic string; JSON's escapes are among TOML's, and DEL is the one character that JSON leaves."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def plain(text: str) -> str:
    """Text for a comment: TOML allows no control characters there."""
    return "".join(c if c.isprintable() else "?" for c in text)
