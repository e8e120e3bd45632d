"""An answer that an assistant can hold: long lists are cut, and it is said which. Texts are never cut.

Code: Z010 too much to say.
"""

from __future__ import annotations

import json
from typing import Any

from olp.core.diagnostic import OlpError, error


def fit(whole: dict[str, Any], rows: int, most: int) -> dict[str, Any]:
    """`whole` with at most `rows` rows per list and `most` characters, and `truncated`. Raises OlpError (Z010)."""
    while True:
        cut: list[str] = []
        shown = {key: _cut(value, key, rows, cut) for key, value in whole.items()}
        shown["truncated"] = cut
        size = len(json.dumps(shown, ensure_ascii=False))
        if size <= most:
            return shown
        if rows <= 1:
            says = f"the answer has {size} characters, {most} are given"
            raise OlpError(
                error("Z010", says, help="ask about one program, with summary=true, or use the command line")
            )
        rows //= 2


def _cut(value: Any, name: str, rows: int, cut: list[str]) -> Any:
    if isinstance(value, dict):
        return {key: _cut(item, f"{name}.{key}", rows, cut) for key, item in value.items()}
    if isinstance(value, list):
        if len(value) > rows and name.rpartition(".")[2] != "files":  # programs are whole or not there
            cut.append(f"{name}: {rows} of {len(value)}")
            value = value[:rows]
        return [_cut(item, f"{name}[{index}]", rows, cut) for index, item in enumerate(value)]
    return value
