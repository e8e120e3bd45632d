"""Writes the rules' part of docs/lint.md from the rules themselves; tests/test_lint.py holds the page to it.

python bench/lint_page.py
"""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from olp.checks.lint import Rule, all_rules  # noqa: E402

PAGE = ROOT / "docs" / "lint.md"
BEGIN = "## The rules\n"


def rules_part() -> str:
    """From the heading on to the end of the page."""
    rows = ["| code | level | `--fix` | what and why | instead of | better |", "|---|---|---|---|---|---|"]
    rows += [row(rule) for rule in all_rules()]
    return "\n".join([BEGIN, *rows, ""])


def row(rule: Rule) -> str:
    """One rule: what it is, why, an example, what is better."""
    fix = "yes" if rule.fixable else "unsafe" if rule.suggests else ""
    what = f"**{rule.title}**: {rule.why}"
    better = code(rule.better) if rule.better[:1].isupper() else rule.better
    return f"| {rule.code} | {rule.level} | {fix} | {what} | {code(rule.example)} | {better} |"


def code(lines: str) -> str:
    """Lines of a program in a cell of a table."""
    return "<br>".join(f"`{line}`" for line in lines.splitlines())


def page() -> str:
    """The page with its rules' part written anew."""
    return PAGE.read_text(encoding="utf-8").partition(BEGIN)[0] + rules_part()


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
