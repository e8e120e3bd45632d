"""What `olp help CODE` prints."""

from __future__ import annotations

import re

_CODE = re.compile(r"[A-Za-z]\d{3}")


def explained_code(word: str) -> str:
    """What a code of a diagnostic means; "" for a word that is not one. Case does not matter."""
    if not _CODE.fullmatch(word):
        return ""
    from olp.core.codes import code_meanings

    code = word.upper()
    if meaning := code_meanings().get(code, ""):
        return f"{code}: {meaning}"
    from olp.checks.lint import all_rules

    rules = (rule for rule in all_rules() if rule.code == code)
    return next((rule.explained() for rule in rules), "")
