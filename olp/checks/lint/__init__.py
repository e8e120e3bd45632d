"""Rules: motion mistakes that cost time or safety. One file per rule in `rules/`."""

from olp.checks.lint.rule import LintCase, Rule, all_rules, case_of

__all__ = ["LintCase", "Rule", "all_rules", "case_of"]
