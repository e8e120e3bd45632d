"""Rules: motion mistakes that cost time or safety. One file per rule in `rules/`."""

from olp.checks.lint.case import LintCase, case_of
from olp.checks.lint.rule import Rule, all_rules

__all__ = ["LintCase", "Rule", "all_rules", "case_of"]
