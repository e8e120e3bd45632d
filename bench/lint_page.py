"""Writes the rules' part of docs/lint.md from the rules themselves; tests/test_lint.py holds the page to it.

python bench/lint_page.py
"""

from __future__ import annotations

import sys
import textwrap
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from olp.checks.lint import Rule, all_rules  # noqa: E402

PAGE = ROOT / "docs" / "lint.md"
BEGIN = "## The rules\n"


def rules_part() -> str:
    """From the heading on to the end of the page."""
    rows = ["| code | level | what | `--fix` |", "|---|---|---|---|"]
    rows += [
        f"| [{rule.code}](#{rule.code.lower()}) | {rule.level} | {rule.title} | {fix(rule)} |"
        for rule in all_rules()
    ]
    return "\n".join([BEGIN, *rows, "", *(section(rule) for rule in all_rules())])


def fix(rule: Rule) -> str:
    return "yes" if rule.fixable else "unsafe" if rule.suggests else ""


def section(rule: Rule) -> str:
    """One rule: what it is, why, an example, what is better."""
    is_code = rule.better[:1].isupper()
    shown = f"{rule.example}\n\nbetter:\n{rule.better}" if is_code else rule.example
    better = "" if is_code else f"Better: {rule.better}."
    why = textwrap.fill(f"**{rule.title[:1].upper()}{rule.title[1:]}.** {rule.why}", 118)
    head = f"### {rule.code}\n\n{why}"
    return "\n\n".join(filter(None, (head, f"```text\n{shown}\n```", better))) + "\n"


def page() -> str:
    """The page with its rules' part written anew."""
    return PAGE.read_text(encoding="utf-8").partition(BEGIN)[0] + rules_part()


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
