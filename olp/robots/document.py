"""A TOML document that remembers where its keys stand, so that every problem can be shown with its line."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from olp.core.diagnostic import Diagnostic, OlpError, Span, error
from olp.core.toml import TOMLDecodeError, is_told_enough, parse_toml, toml_text

Table = Mapping[str, Any]


class RobotDocument:
    """The parsed file, its text, and the problems found so far."""

    def __init__(self, path: Path) -> None:
        """Raises OlpError (R002) when the file cannot be read or is not TOML."""
        self.file = str(path)
        try:
            self.text = toml_text(path)
            self.root: Table = parse_toml(self.text)
        except OSError as problem:
            reason = problem.strerror or "cannot be read"
            raise OlpError(error("R002", f"robot file: {reason}", file=self.file)) from None
        except UnicodeDecodeError:
            raise OlpError(error("R002", "robot file is not UTF-8 text", file=self.file)) from None
        except TOMLDecodeError as problem:
            raise OlpError(self._syntax(str(problem))) from None
        self.problems: list[Diagnostic] = []

    def report(self, code: str, message: str, key: str = "", after: int = 0, help: str = "") -> None:
        """Notes a problem at the first place of `key` at or after character `after`."""
        if is_told_enough(self.problems, code, self.file):
            return
        line, column, end = self._span(key, after)
        span, row = (Span(line, column, end), self._row(line)) if line else (None, "")
        self.problems.append(error(code, message, span, file=self.file, help=help, source_line=row))

    def table_start(self, key: str) -> int:
        """Character where the table `[key]` or the value of `key` starts."""
        match = re.search(
            rf"^\s*(\[+\s*{re.escape(key)}\s*\]+|{re.escape(key)}\s*=)", self.text, re.MULTILINE
        )
        return match.start() if match else 0

    def item_start(self, key: str, index: int) -> int:
        """Character where entry `index` (from 0) of the array of tables `key` starts."""
        begin = self.table_start(key)
        starts = [
            m.start()
            for m in re.finditer(rf"\{{|^\s*\[\[\s*{re.escape(key)}", self.text[begin:], re.MULTILINE)
        ]
        return begin + (starts[index] if index < len(starts) else 0)

    def known_keys(self, table: Table, known: Collection[str], what: str, after: int = 0) -> None:
        """Reports keys of `table` that mean nothing (R003), with the closest that do."""
        for key in table:
            if key not in known and not is_told_enough(self.problems, "R003", self.file):
                close = difflib.get_close_matches(key, known, n=1, cutoff=0.6)
                advice = f"did you mean {close[0]}?" if close else f"known: {', '.join(known)}"
                self.report("R003", f"{what} has no key {key!r}", key, after, advice)

    def number(self, table: Table, key: str, after: int = 0, above: float = -math.inf) -> float | None:
        """The finite number under `key`, None when it is not there or not one (R005)."""
        if key not in table:
            return None
        value = table[key]
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            self.report("R005", f"{key} must be a number, not {value!r}", key, after)
            return None
        if value <= above:
            self.report("R005", f"{key} must be greater than {above:g}, not {value!r}", key, after)
            return None
        return float(value)

    def numbers(self, table: Table, key: str, count: int, after: int = 0) -> tuple[float, ...] | None:
        """`count` finite numbers under `key`, None when it is not there or not that (R005)."""
        if key not in table:
            return None
        value = table[key]
        good = isinstance(value, list) and len(value) == count
        if not good or not all(_is_finite(v) for v in value):
            self.report("R005", f"{key} must be {count} numbers in brackets, not {value!r}", key, after)
            return None
        return tuple(float(v) for v in value)

    def word(self, table: Table, key: str, after: int = 0) -> str | None:
        """The text under `key`, None when it is not there or not text (R005)."""
        value = table.get(key)
        if value is None or (isinstance(value, str) and value.strip()):
            return value
        self.report("R005", f"{key} must be text in quotes, not {value!r}", key, after)
        return None

    def words(self, table: Table, key: str) -> tuple[str, ...]:
        value = table.get(key, [])
        if isinstance(value, list) and all(isinstance(v, str) for v in value):
            return tuple(value)
        self.report("R005", f"{key} must be a list of texts, not {value!r}", key)
        return ()

    def subtable(self, key: str) -> Table | None:
        value = self.root.get(key)
        if value is None or isinstance(value, dict):
            return value
        self.report("R005", f"{key} must be a table, not {value!r}", key)
        return None

    def tables(self, table: Table, key: str) -> Sequence[Table]:
        value = table.get(key, [])
        if isinstance(value, list) and all(isinstance(v, dict) for v in value):
            return value
        self.report("R005", f"{key} must be a list of tables in braces", key)
        return []

    def _span(self, key: str, after: int) -> tuple[int, int, int]:
        if not key:
            return 0, 1, 1
        match = re.compile(rf"(?<![\w\-]){re.escape(key)}(?![\w\-])").search(self.text, after)
        if match is None:
            return 0, 1, 1
        start = self.text.rfind("\n", 0, match.start()) + 1
        return self.text.count("\n", 0, match.start()) + 1, match.start() - start + 1, match.end() - start + 1

    def _row(self, line: int) -> str:
        return self.text.split("\n")[line - 1]

    def _syntax(self, message: str) -> Diagnostic:
        place = re.search(r"\s*\(at line (\d+), column (\d+)\)", message)
        if place is None:
            return error("R002", f"not TOML: {message}", file=self.file)
        line, column = int(place[1]), int(place[2])
        words = message[: place.start()]
        span = Span(line, column, column + 1)
        return error("R002", f"not TOML: {words}", span, file=self.file, source_line=self._row(line))


def _is_finite(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
