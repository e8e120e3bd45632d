"""A budget as `olp.toml` writes it, and the budgets that hold for a file.

```toml
[[budget]]
name = "cell 4"            # what reports call it
files = "cell4/*.jbi"      # one pattern or a list, seen from this file; missing: every program below it
limit_s = 42.0
tolerance_s = 0.2          # or tolerance_pct
warn_s = 41.0              # or warn_pct of the limit: from here on it is close
level = "fail"             # or "warn": never more than a warning
of = "total"               # or motion, wait, io
on = "prediction"          # or upper, lower: an end of the 95 % interval, which needs signature = "FILE"
routine = "WELD"           # one execution of it, the longest; or
from = "START"             # from one label
to = "END"                 # to another
```

A pattern without a slash holds in every folder below; in others * and ? stop at a slash, and ** does not. A budget
for a routine or labels without `files` and `job` holds wherever they are.

Codes: M001 a budget that cannot be used, M002 a key that nobody reads, M007 a budget that holds for no program.
"""

from __future__ import annotations

import difflib
import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from olp.core.diagnostic import Diagnostic, OlpError, Span, error
from olp.core.toml import TOMLDecodeError, is_told_enough, parse_toml, toml_text
from olp.runtime.assumptions import nearest_assumptions

PARTS = ("total", "motion", "wait", "io")
ENDS = ("prediction", "upper", "lower")
_KEYS = (
    "name", "files", "routine", "from", "to", "limit_s", "tolerance_s", "tolerance_pct", "warn_s", "warn_pct",
    "level", "of", "on", "signature", "job",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Budget:
    """Allowed time [s] of a program or a part of it. `line`: of its entry in olp.toml; `home`: the folder of that
    file.

    `job`: the stem of a program's file. `warn_s`: inf without a warning level. `signature`: a path, "" for none.
    """

    name: str
    home: str
    line: int
    limit_s: float
    tolerance_s: float = 0.0
    warn_s: float = math.inf
    files: tuple[str, ...] = ()
    job: str = ""
    routine: str = ""
    start: str = ""
    stop: str = ""
    fails: bool = True
    of: str = "total"
    on: str = ENDS[0]
    signature: str = ""

    def covers(self, path: str) -> bool:
        """Whether the budget holds for the program in the file `path`, even through a symbolic link."""
        file = Path(os.path.realpath(os.path.dirname(path)), os.path.basename(path))
        try:
            relative = file.relative_to(self.home).as_posix()
        except ValueError:
            return False
        if self.job and file.stem.casefold() != self.job.casefold():
            return False
        return not self.files or any(_pattern(pattern).fullmatch(relative) for pattern in self.files)

    @property
    def anywhere(self) -> bool:
        """Whether it limits a part of a program and names no program."""
        return bool(self.routine or self.start) and not self.files and not self.job


def label_name(written: str) -> str:
    """Name of a budget's label without the signs that its language puts around it: *A, A:, LBL[7:home]."""
    name = written.strip().casefold()
    found = re.fullmatch(r"lbl\[\s*(\w+).*\]", name)
    return found[1] if found else name.lstrip("*").rstrip(":")


@lru_cache(maxsize=256)
def _pattern(pattern: str) -> re.Pattern[str]:
    """Regular expression of the paths that a pattern matches, with slashes and relative to the olp.toml, ignoring
    case.
    """
    text = pattern.replace("\\", "/").removeprefix("./")
    text = text + "**" if text.endswith("/") else text
    text = text if "/" in text else f"**/{text}"
    words = {"**/": "(?:.*/)?", "**": ".*", "*": "[^/]*", "?": "[^/]"}
    parts = re.split(r"(\*\*/|\*\*|\*|\?)", text)
    return re.compile("".join(words.get(part, re.escape(part)) for part in parts), re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Budgets:
    """All budgets of one olp.toml. `diagnostics`: problems of invalid ones, which are left out."""

    path: str
    budgets: tuple[Budget, ...]
    diagnostics: tuple[Diagnostic, ...] = ()


def budgets_for(path: str, given: str | None = None) -> list[Budgets]:
    """The budgets of `given`, else of every olp.toml that holds for the file: beside it and above, nearest first.

    Raises OlpError (M001) if `given` is not a file.
    """
    if given is not None and not Path(given).is_file():
        raise OlpError(error("M001", "no such file of budgets", file=given, help="check the path"))
    files = [Path(given)] if given is not None else _files_above(os.path.realpath(os.path.dirname(path)))
    return [_read(str(file.resolve()), file.stat().st_mtime_ns) for file in files if file.is_file()]


def _files_above(folder: str) -> tuple[Path, ...]:
    found = []
    nearest = nearest_assumptions(folder)
    while nearest is not None:
        found.append(nearest)
        home = nearest.parent
        nearest = (
            None if (home / ".git").exists() or home.parent == home else nearest_assumptions(home.parent)
        )
    return tuple(found)


@lru_cache(maxsize=64)
def _read(path: str, _: int) -> Budgets:
    text = toml_text(path, "replace")
    try:
        tables = parse_toml(text).get("budget", [])
    except TOMLDecodeError as problem:
        return Budgets(path, (), (_broken(str(problem), path),))
    if not isinstance(tables, list):
        says = error(
            "M001", "budgets are tables in a list", file=path, help="write [[budget]], with two brackets"
        )
        return Budgets(path, (), (says,))
    lines = [number for number, row in enumerate(text.split("\n"), 1) if row.strip().startswith("[[budget]]")]
    reader = _BudgetReader(path)
    found = [reader.budget(table, lines[i] if i < len(lines) else 0) for i, table in enumerate(tables)]
    return Budgets(path, tuple(b for b in found if b is not None), tuple(reader.problems))


def _broken(message: str, path: str) -> Diagnostic:
    place = re.search(r"\s*\(at line (\d+), column (\d+)\)", message)
    where = Span(int(place[1]), int(place[2])) if place else None
    says = f"not TOML: {message[: place.start()] if place else message}"
    return error("M001", says, where, file=path, help="no budget of this file can be judged")


def _name(words: Mapping[str, str], patterns: tuple[str, ...]) -> str:
    span = f"{words['from']} to {words['to']}" if words["from"] else ""
    return words["routine"] or span or words["job"] or " ".join(patterns) or "budget"


class _BudgetReader:
    def __init__(self, path: str) -> None:
        self.path = path
        self.problems: list[Diagnostic] = []
        self.line = 0

    def budget(self, table: Mapping[str, Any], line: int) -> Budget | None:
        self.line = line
        before = len(self.problems)
        self._known(table)
        limit = self._seconds(table, "limit_s", None)
        tolerance = self._share(table, "tolerance", limit, 0.0)
        warn = self._share(table, "warn", limit, math.inf)
        patterns = self._patterns(table)
        words = {key: self._word(table, key) for key in ("name", "job", "routine", "from", "to", "signature")}
        level = self._choice(table, "level", ("fail", "warn"))
        of, on = self._choice(table, "of", PARTS), self._choice(table, "on", ENDS)
        if bool(words["from"]) != bool(words["to"]):
            self._report("from and to belong together", 'from = "START"\nto = "END"')
        if on != ENDS[0] and of != "total":
            self._report(f'on = "{on}" judges the total', 'leave out of, or write of = "total"')
        if limit is None or len(self.problems) > before:
            return None
        home = Path(self.path).parent
        return Budget(
            name=words["name"] or _name(words, patterns),
            home=str(home),
            line=line,
            limit_s=limit,
            tolerance_s=tolerance,
            warn_s=warn,
            files=patterns,
            job=words["job"],
            routine=words["routine"],
            start=words["from"],
            stop=words["to"],
            fails=level == "fail",
            of=of,
            on=on,
            signature=str(home / words["signature"]) if words["signature"] else "",
        )

    def _patterns(self, table: Mapping[str, Any]) -> tuple[str, ...]:
        files = table.get("files", [])
        found = (files,) if isinstance(files, str) else tuple(files) if isinstance(files, list) else ()
        if ("files" in table and not found) or not all(isinstance(pattern, str) for pattern in found):
            self._report("files is a pattern or a list of patterns", 'files = "cell4/*.jbi"')
            return ()
        return found

    def _known(self, table: Mapping[str, Any]) -> None:
        for key in table:
            if key not in _KEYS and not is_told_enough(self.problems, "M002", self.path):
                close = difflib.get_close_matches(key, _KEYS, n=1, cutoff=0.6)
                advice = f"did you mean {close[0]}?" if close else f"known: {', '.join(_KEYS)}"
                self.problems.append(self._at("M002", f"[[budget]] knows no {key[:40]!r}", advice))

    def _seconds(self, table: Mapping[str, Any], key: str, missing: float | None) -> float | None:
        value = table.get(key, missing)
        if isinstance(value, (int, float)) and not isinstance(value, bool) and 0 <= value < math.inf:
            return float(value)
        if key not in table and missing is not None:
            return missing
        self._report(f"{key} must be seconds, zero or more", f"{key} = 42.0")
        return None

    def _share(self, table: Mapping[str, Any], key: str, limit: float | None, missing: float) -> float:
        """Value [s] of `key`_s, or of `key`_pct of the limit."""
        seconds, percent = f"{key}_s", f"{key}_pct"
        if seconds in table and percent in table:
            self._report(f"{seconds} and {percent} are two of one thing", f"keep {seconds}")
        if seconds in table:
            found = self._seconds(table, seconds, None)
            return missing if found is None else found
        if percent not in table:
            return missing
        share = self._seconds(table, percent, None)
        return missing if share is None or limit is None else limit * share / 100

    def _word(self, table: Mapping[str, Any], key: str) -> str:
        value = table.get(key, "")
        if isinstance(value, str):
            return value
        self._report(f"{key} must be a text", f'{key} = "…"')
        return ""

    def _choice(self, table: Mapping[str, Any], key: str, known: tuple[str, ...]) -> str:
        value = table.get(key, known[0])
        if value not in known:
            self._report(f"{key} is one of {', '.join(known)}", f'{key} = "{known[0]}"')
            return known[0]
        return str(value)

    def _report(self, message: str, example: str) -> None:
        self.problems.append(self._at("M001", message, f"for example {example}"))

    def _at(self, code: str, message: str, advice: str) -> Diagnostic:
        return error(code, message, Span(self.line) if self.line else None, file=self.path, help=advice)
