"""Runs the rules over files: the selected ones, without findings excused by the baseline or by comments in the
program.

The command line selects rules; the nearest olp.toml can exclude some:

```toml
[lint]
select = ["W0"]        # codes or their beginnings; missing: all rules
ignore = ["W012"]
```

A baseline is a file of known findings that are excused, so that only new ones break the build.

Codes: W901 a baseline that cannot be read, W902 an invalid selection of rules.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from olp.checks.lint.rule import LintCase, Rule, RunRule, all_rules
from olp.core.diagnostic import Diagnostic, OlpError, error
from olp.core.files import parse_json, read_input
from olp.core.source import Source
from olp.core.toml import TOMLDecodeError, parse_toml, toml_text
from olp.identification.timing_job import TimingJob, time_program
from olp.reports.outcome.model import OutcomeFinding, of_diagnostic
from olp.runtime.assumptions import nearest_assumptions

_KEYS = ("select", "ignore")


class RuleChoice(NamedTuple):
    """Selected and ignored rules: codes or their beginnings. `select` empty: all."""

    select: tuple[str, ...] = ()
    ignore: tuple[str, ...] = ()

    def holds(self, rule: Rule) -> bool:
        wanted = not self.select or rule.code.startswith(self.select)
        return wanted and not rule.code.startswith(self.ignore)


def choice(select: Sequence[str], ignore: Sequence[str], file: str = "") -> RuleChoice:
    """The selection. Raises OlpError (W902) for a code that no rule begins with."""
    found = RuleChoice(tuple(c.upper() for c in select), tuple(c.upper() for c in ignore))
    codes = [rule.code for rule in all_rules()]
    problems = [
        error("W902", f"no rule is called {word[:40]!r}", file=file, help="olp lint --rules lists them")
        for word in (*found.select, *found.ignore)
        if not any(code.startswith(word) for code in codes)
    ]
    if problems:
        raise OlpError(*problems)
    return found


def rules_for(path: str, asked: RuleChoice) -> list[Rule]:
    """The rules for the file `path`; the requested selection takes precedence over that of its olp.toml.

    Raises OlpError (W902).
    """
    nearest = nearest_assumptions(Path(path).resolve().parent)
    own = _read(str(nearest), nearest.stat().st_mtime_ns) if nearest is not None else RuleChoice()
    both = RuleChoice(asked.select or own.select, (*asked.ignore, *(() if asked.select else own.ignore)))
    return [rule for rule in all_rules() if both.holds(rule)]


@lru_cache(maxsize=64)
def _read(path: str, _: int) -> RuleChoice:
    try:
        table = parse_toml(toml_text(path, "replace")).get("lint", {})
    except (TOMLDecodeError, OSError):
        return RuleChoice()  # told where the file is read for its assumptions
    problems: list[Diagnostic] = []
    if not isinstance(table, dict):
        raise OlpError(error("W902", "lint is a table", file=path, help='[lint]\nignore = ["W012"]'))
    for key, value in table.items():
        if key not in _KEYS:
            says, advice = f"[lint] knows no {key[:40]!r}", f"known: {', '.join(_KEYS)}"
            problems.append(error("W902", says, file=path, help=advice))
        elif not isinstance(value, list) or not all(isinstance(code, str) for code in value):
            problems.append(error("W902", f"{key} is a list of codes", file=path, help=f'{key} = ["W012"]'))
    if problems:
        raise OlpError(*problems)
    return choice(table.get("select", ()), table.get("ignore", ()), path)


_EXCUSE = re.compile(r"olp:\s*ignore(?:\s+((?:[A-Z]\d{3}[\s,]*)+))?", re.IGNORECASE)
_NUMBER = re.compile(r"^\s*\d*\s*:?\s*")  # of the line, which TP writes in front
_CODE = re.compile(r"[A-Z]\d{3}")


@dataclass(frozen=True, slots=True)
class Linted:
    """Result of one file. `excused`: number of findings that a comment in the program excuses."""

    path: str
    findings: tuple[OutcomeFinding, ...]
    excused: int = 0
    unreadable: bool = False


def lint(path: str, job: TimingJob, asked: RuleChoice | None = None) -> Linted:
    """All findings of one file. Never raises for a bad program: its problems are findings."""
    from olp.languages.vendor import read
    from olp.runtime.dispatch import NoSuchRoutineError

    try:
        program = read(path, encoding=job.encoding)
        rules = rules_for(path, asked or RuleChoice())
        told = {code for rule in all_rules() if isinstance(rule, RunRule) for code in rule.codes}
        broken = [of_diagnostic(d, path) for d in program.diagnostics if d.is_error and d.code not in told]
        if broken and not program.routines:
            return Linted(path, tuple(broken), unreadable=True)
        case = LintCase(program, time_program(program, job))
    except OlpError as problem:
        # Data alone: nothing runs.
        alone = isinstance(problem, NoSuchRoutineError) and not program.routines and bool(program.data)
        problems = () if alone else problem.diagnostics
        return Linted(path, tuple(of_diagnostic(d, path) for d in problems), unreadable=not alone)
    found = sorted((f for rule in rules for f in rule.find(case)), key=lambda f: (f.line, f.code))
    kept = [f for f in found if not is_excused(case, f)]
    return Linted(path, (*broken, *kept), len(found) - len(kept))


def lint_load(path: str, job: TimingJob, controller: str) -> Linted:
    """Findings that a controller reports when it loads one file. Never raises for a bad program.

    Raises OlpError (W903) for a controller that the file's language does not have.
    """
    from olp.core.source import load
    from olp.languages.vendor import part_of, read, recognise

    try:
        source = load(path, job.encoding)
        program = read(path, encoding=job.encoding)
    except OlpError as problem:
        return Linted(path, tuple(of_diagnostic(d, path) for d in problem.diagnostics), unreadable=True)
    vendor = recognise(source)
    loading = None if vendor is None else part_of(vendor.name, "load")
    found = [d for d in program.diagnostics if d.is_error]
    if vendor is not None and loading is not None:
        if controller and controller not in loading.controllers:
            known = ", ".join(loading.controllers)
            raise OlpError(
                error("W903", f"no controller {controller[:40]} runs {vendor.title}", help=f"one of {known}")
            )
        broken = {d.line for d in found}
        told = loading.refused(source, vendor, controller)
        found += [d for d in told if d.line not in broken]
    findings = [of_diagnostic(d, path) for d in sorted(found, key=lambda d: (d.line, d.code))]
    kept = [f for f in findings if not _excused_above(source, f)]
    return Linted(path, tuple(kept), len(findings) - len(kept))


def _excused_above(source: Source, found: OutcomeFinding) -> bool:
    lines = (
        (source.line(found.line), source.line(found.line - 1))
        if found.line > 1
        else (source.line(found.line),)
    )
    return bool(found.line) and any(_excuses(text, found.code) for text in lines)


def is_excused(case: LintCase, found: OutcomeFinding) -> bool:
    """Whether a comment on the line, or alone on the line above, excuses the finding."""
    if not found.line:
        return False
    above = case.text(found.line - 1) if found.line > 1 else ""
    return any(
        _excuses(text, found.code)
        for text in (case.text(found.line), above if _is_comment(case, above) else "")
    )


def _is_comment(case: LintCase, text: str) -> bool:
    from olp.languages.vendor import find_vendor, vendor_names

    if case.program.vendor not in vendor_names():
        return False
    prefix = find_vendor(case.program.vendor).comment_prefix
    return _NUMBER.sub("", text).startswith(_NUMBER.sub("", prefix))


def _excuses(text: str, code: str) -> bool:
    match = _EXCUSE.search(text)
    return match is not None and (not match[1] or code in _CODE.findall(match[1].upper()))


def without_known(findings: Iterable[OutcomeFinding], known: dict[str, int]) -> list[OutcomeFinding]:
    """The findings beyond the baseline `known`, which counts the known ones of each kind."""
    left = dict(known)
    fresh = []
    for found in findings:
        if left.get(found.fingerprint, 0) > 0:
            left[found.fingerprint] -= 1
        else:
            fresh.append(found)
    return fresh


_VERSION = 1


def read_baseline(path: Path) -> dict[str, int]:
    """Number of known findings by fingerprint. Raises OlpError (W901)."""
    try:
        whole = parse_json(read_input(path))
        rows = whole["findings"] if whole["version"] == _VERSION else []
        return {str(row["fingerprint"]): int(row["count"]) for row in rows}
    except OSError as problem:
        why = problem.strerror or "it cannot be read"
    except (ValueError, KeyError, TypeError, OverflowError):
        why = "it is not a baseline of olp lint"
    raise OlpError(
        error("W901", f"the baseline: {why}", file=str(path), help="olp lint --write-baseline FILE makes one")
    )


def baseline_text(findings: Iterable[OutcomeFinding]) -> str:
    """The text of a baseline that excuses `findings`, sorted, so that two versions can be compared."""
    found = list(findings)
    counts = Counter(f.fingerprint for f in found)
    first = {f.fingerprint: f for f in reversed(found)}
    order = sorted(counts, key=lambda mark: (first[mark].file, first[mark].code, mark))
    rows = [{"fingerprint": mark, "count": counts[mark], **_told(first[mark])} for mark in order]
    return json.dumps({"version": _VERSION, "findings": rows}, indent=1, ensure_ascii=False) + "\n"


def _told(finding: OutcomeFinding) -> dict[str, str]:
    """Description of a finding for readers of the file; it is not parsed."""
    return {"code": finding.code, "file": finding.file, "says": finding.message}
