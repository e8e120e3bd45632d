"""Reads a mapping file: what tools, frames, signals, variables and routines of the source are in the target.

Codes: X013 a mapping file that cannot be read, or says what nobody asks for.
"""

from __future__ import annotations

from pathlib import Path

from olp.core.diagnostic import Diagnostic, OlpError, error
from olp.core.toml import TOMLDecodeError, is_told_enough, parse_toml, toml_text
from olp.transpile.context import Mapping

_TABLES = ("tools", "frames", "signals", "variables", "routines")
_KEYS = (*_TABLES, "set_values")


def read_mapping(path: str | Path) -> Mapping:
    """The mapping in a TOML file. Raises OlpError (X013) with all that is wrong with it."""
    try:
        document = parse_toml(toml_text(path))
    except (OSError, UnicodeDecodeError, TOMLDecodeError) as problem:
        raise OlpError(error("X013", f"the mapping cannot be read: {problem}", file=str(path))) from None
    problems: list[Diagnostic] = []
    for key in document:
        if key not in _KEYS and not is_told_enough(problems, "X013", str(path)):
            help = f"it takes {', '.join(_KEYS)}"
            problems.append(error("X013", f"nothing uses '{key}'", file=str(path), help=help))
    tables = {name: _table(document.get(name, {}), name, path, problems) for name in _TABLES}
    set_values = document.get("set_values", True)
    if not isinstance(set_values, bool):
        problems.append(error("X013", "set_values is true or false", file=str(path)))
    if problems:
        raise OlpError(*problems)
    return Mapping(**tables, set_values=set_values)


def _table(found: object, name: str, path: str | Path, problems: list[Diagnostic]) -> dict[str, str]:
    if not isinstance(found, dict):
        problems.append(error("X013", f"[{name}] is a table of names", file=str(path)))
        return {}
    result: dict[str, str] = {}
    for key, value in found.items():
        if isinstance(value, bool) or not isinstance(value, (str, int)):
            problems.append(error("X013", f"[{name}] {key} is a name or a number", file=str(path)))
        else:
            result[key] = str(value)
    return result
