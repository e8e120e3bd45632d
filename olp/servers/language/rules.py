"""The rules of `olp lint` over open texts, one at a time, so that whoever waits can be let in between."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from olp.core.diagnostic import OlpError
from olp.servers.language.analysis import Analysis, mistake

if TYPE_CHECKING:
    from olp.reports.outcome.model import OutcomeFinding
    from olp.servers.language.service import ProgramService


def rule_runs(service: ProgramService) -> Iterator[str]:
    """Runs every rule over every open text: the path of one whose findings are complete, "" after each step before."""
    for path in list(service.analyses):
        yield from _over(service, path)


def _over(service: ProgramService, path: str) -> Iterator[str]:
    from olp.checks.lint.case import LintCase
    from olp.checks.lint.run import is_excused
    from olp.checks.lint.settings import RuleChoice, rules_for
    from olp.reports.outcome.model import of_diagnostic

    analysis = service.analyses.get(path)
    if analysis is None or analysis.program is None or analysis.timing is None or analysis.linted:
        return
    case = LintCase(analysis.program, analysis.timing)
    found: list[OutcomeFinding] = []
    try:
        rules = rules_for(path, RuleChoice())
    except OlpError as problem:
        rules, found = [], [of_diagnostic(d, path) for d in problem.diagnostics]
    for rule in rules:
        try:
            found.extend(one for one in rule.find(case) if not is_excused(case, one))
        except Exception as problem:
            found.append(of_diagnostic(mistake(problem), path))
        yield ""
    if service.analyses.get(path) is analysis:
        ordered = tuple(sorted(found, key=lambda one: (one.line, one.code)))
        service.analyses[path] = replace(analysis, lint=ordered, linted=True)
        yield path


def complete(service: ProgramService, path: str) -> Analysis | None:
    """What is known of the newest text, rules included: for whoever cannot wait for the next pause."""
    if service.current(path) is None:
        return None
    for _ in _over(service, path):
        pass
    return service.analyses[path]
