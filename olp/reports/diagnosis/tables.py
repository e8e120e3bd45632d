"""Any mapping of results as tables: what a log tells is a different thing for every robot."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from olp.identification.diagnosis import phrasing

_DEEPEST = 4
_MOST = 200  # rows


class ReportTable(NamedTuple):
    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def tables_of(summary: Mapping[str, Any], title: str = "", depth: int = 0) -> list[ReportTable]:
    """Single values as one table, a list of mappings or a mapping of mappings as one each."""
    single = [(_words(key), _text(value)) for key, value in summary.items() if not _nested(value)]
    found = [ReportTable(title, ("name", "value"), tuple(single[:_MOST]))] if single else []
    for key, value in summary.items():
        name = f"{title}: {_words(key)}" if title else _words(key)
        if isinstance(value, Mapping) and value:
            rows = list(value.items())
            if all(isinstance(row, Mapping) and not any(map(_nested, row.values())) for _, row in rows):
                found.append(_table(name, [{"name": k, **row} for k, row in rows]))
            elif depth < _DEEPEST:
                found += tables_of(value, name, depth + 1)
        elif _nested(value) and not isinstance(value, Mapping):
            found.append(_table(name, [row if isinstance(row, Mapping) else {"value": row} for row in value]))
    return found


def _nested(value: Any) -> bool:
    if isinstance(value, Mapping):
        return True
    return isinstance(value, Sequence) and not isinstance(value, str) and any(map(_nested, value))


def _table(title: str, rows: Sequence[Mapping[Any, Any]]) -> ReportTable:
    keys = list(dict.fromkeys(key for row in rows for key in row))
    body = tuple(tuple(_text(row.get(key, "")) for key in keys) for row in rows[:_MOST])
    return ReportTable(title, tuple(map(_words, keys)), body)


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float) or hasattr(value, "dtype"):
        return phrasing.figure(float(value), 6) if not math.isnan(float(value)) else ""
    if isinstance(value, (list, tuple)):
        return ", ".join(map(_text, value))
    return "" if value is None else str(value)


def _words(key: Any) -> str:
    return str(key).replace("_", " ")
