"""Shared by olp's own HTML pages: templates that escape every value, and JSON inside a page."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
from typing import Any

from markupsafe import Markup

from olp.core import resources

FOLDER = "templates"


def render_page(template: str, values: dict[str, Any]) -> str:
    """Render one of olp's own templates. Text of programs and recordings cannot become markup."""
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    # Not olp.languages.templating: that renders strangers' templates as plain text; these are olp's own and escape.
    environment = Environment(
        loader=FunctionLoader(lambda name: resources.read_text(FOLDER, name)),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=_clean,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render(values)


def script_of(*names: str) -> tuple[Markup, str]:
    """Scripts that come with olp, joined to one, and the hash with which the page's policy allows it."""
    script = Markup("\n".join(resources.read_text(FOLDER, name) for name in names))
    return script, base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()


def json_in_page(value: Any) -> Markup:
    """JSON for a <script> element: no character in it can end the element."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    for sign in "<>&":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return Markup(text)


def packed_in_page(value: Any) -> Markup:
    """JSON that a script unpacks: gzip in base64, an eighth of the text."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    return Markup(base64.b64encode(gzip.compress(text.encode(), 6, mtime=0)).decode())


_KEPT = "\t\n\u00a0\u202f"  # besides printable characters: also the blanks that keep a number and its unit together


def printable(text: str) -> str:
    """The text with a replacement character for what a page must not contain: control characters and direction
    marks.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in _KEPT else "\ufffd" for c in text)


def _clean(value: Any) -> Any:
    """Values that a page may contain: olp's own markup, or printable text."""
    return printable(value) if isinstance(value, str) and not isinstance(value, Markup) else value
