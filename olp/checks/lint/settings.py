"""Which rules hold for a file: what the command line asks for, less what the nearest olp.toml leaves out.

```toml
[lint]
select = ["W0"]        # codes or their beginnings; missing: all rules
ignore = ["W012"]
```

Codes: W902 rules that cannot be chosen so.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from olp.checks.lint.rule import Rule, all_rules
from olp.core.diagnostic import Diagnostic, OlpError, error
from olp.core.toml import TOMLDecodeError, parse_toml, toml_text
from olp.runtime.assumptions import nearest_assumptions

_KEYS = ("select", "ignore")


class RuleChoice(NamedTuple):
    """Codes or their beginnings. `select` empty: all."""

    select: tuple[str, ...] = ()
    ignore: tuple[str, ...] = ()

    def holds(self, rule: Rule) -> bool:
        wanted = not self.select or rule.code.startswith(self.select)
        return wanted and not rule.code.startswith(self.ignore)


def choice(select: Sequence[str], ignore: Sequence[str], file: str = "") -> RuleChoice:
    """Raises OlpError (W902) for a code that no rule begins with."""
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
    """The rules for the file `path`; a selection that is asked for wins over that of its olp.toml.

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
