"""The rules over files: what is asked for, less what the baseline and comments in the program excuse."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

from olp.checks.lint.case import LintCase
from olp.checks.lint.rule import RunRule, all_rules
from olp.checks.lint.settings import RuleChoice, rules_for
from olp.core.diagnostic import OlpError, error
from olp.core.source import Source
from olp.reports.batch import Job, time_program
from olp.reports.outcome.model import OutcomeFinding, of_diagnostic

_EXCUSE = re.compile(r"olp:\s*ignore(?:\s+((?:[A-Z]\d{3}[\s,]*)+))?", re.IGNORECASE)
_NUMBER = re.compile(r"^\s*\d*\s*:?\s*")  # of the line, which TP writes in front
_CODE = re.compile(r"[A-Z]\d{3}")


@dataclass(frozen=True, slots=True)
class Linted:
    """One file. `excused`: findings that a comment in the program excuses."""

    path: str
    findings: tuple[OutcomeFinding, ...]
    excused: int = 0
    unreadable: bool = False


def lint(path: str, job: Job, asked: RuleChoice | None = None) -> Linted:
    """All findings of one file. Never raises for a bad program: what is wrong with it is a finding."""
    from olp.languages.read import read

    try:
        program = read(path, encoding=job.encoding)
        rules = rules_for(path, asked or RuleChoice())
        told = {code for rule in all_rules() if isinstance(rule, RunRule) for code in rule.codes}
        broken = [of_diagnostic(d, path) for d in program.diagnostics if d.is_error and d.code not in told]
        if broken and not program.routines:
            return Linted(path, tuple(broken), unreadable=True)
        case = LintCase(program, time_program(program, job))
    except OlpError as problem:
        return Linted(path, tuple(of_diagnostic(d, path) for d in problem.diagnostics), unreadable=True)
    found = sorted((f for rule in rules for f in rule.find(case)), key=lambda f: (f.line, f.code))
    kept = [f for f in found if not is_excused(case, f)]
    return Linted(path, (*broken, *kept), len(found) - len(kept))


def lint_load(path: str, job: Job, controller: str) -> Linted:
    """What a controller refuses when it loads one file. Never raises for a bad program.

    Raises OlpError (W903) for a controller that the file's language does not have.
    """
    from olp.core.source import load
    from olp.languages.loading import cell_of
    from olp.languages.read import read
    from olp.languages.vendor import part_of, recognise

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
        told = loading.check(source, cell_of(source, vendor, loading, controller))
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
    """Whether a comment on the line, or alone on the line above, says so."""
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
    """The findings that a baseline does not hold; it counts how many of each kind there were."""
    left = dict(known)
    fresh = []
    for found in findings:
        if left.get(found.fingerprint, 0) > 0:
            left[found.fingerprint] -= 1
        else:
            fresh.append(found)
    return fresh
