"""Writes tests/data/command_effects.json: which option of which command changes an answer, and how.

    python bench/command_effects.py [COMMAND…]

`check_command` then asks that it still does. An option without a row only has to be asked for.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

from olp import cli
from olp.contracts.commands import EFFECTS, CommandUnderTest, effect_of


def effects_of(name: str) -> dict[str, tuple[int, str]]:
    """Of each option that has one."""
    it = CommandUnderTest(name)
    options = [action for action in it.options if it.first and action.dest != "watch"]
    found = {action.option_strings[-1]: effect_of(it, action) for action in options}
    return {option: effect for option, effect in found.items() if effect is not None}


if __name__ == "__main__":
    known = json.loads(EFFECTS.read_text(encoding="utf-8")) if EFFECTS.exists() else {}
    known |= {name: effects_of(name) for name in sys.argv[1:] or cli.names()}
    rows = [f"{json.dumps(name)}: {json.dumps(known[name], ensure_ascii=False)}" for name in sorted(known)]
    EFFECTS.write_text("{\n" + ",\n".join(rows) + "\n}\n", encoding="utf-8", newline="\n")
