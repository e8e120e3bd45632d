"""Writes docs/physics.md, the list of all terms, from the terms themselves; tests/test_physics.py holds the page to it.

    python bench/physics_page.py

What forms a term has hangs on what a recording tells, so the page is that of a recording that tells everything: a GP25
at random places, with roundings, loads, joint moves, turns of the tool and waits, in multiples of 12 ms.
"""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from olp.contracts.term_page import PAGE, section  # noqa: E402
from olp.contracts.terms import other_cases, rich_case  # noqa: E402
from olp.timing.physics import LogTerm, MoveTerm, Term, load_term, term_names  # noqa: E402

# --- the page ---------------------------------------------------------------------------------------------------------

_HEAD = """\
# The physics that a simulation may leave out

Written by `python bench/physics_page.py` from `olp/timing/physics/`, one file per term; edit the terms, not this page.
How `olp diagnose` chooses among them is in [diagnose](diagnose.md).

A term is a forward model: it changes the motion of all moves together (a slower speed also needs a shorter ramp), and
what it changes in a duration is added to what the judged simulation said. A term may have several forms, of which a
diagnosis takes at most one (limits of axes: one per axis). Its value where it does nothing is its null.

| term | what it means | told by | may look like |
|---|---|---|---|
"""
_PICTURES = """
The pictures show each effect alone in 160 straight moves (`python bench/physics_pictures.py`): a dot is a move, up is
later than simulated, over the column that orders the dots best. Where a second column parts what the first leaves, blue
dots are the lower half of it and orange ones the upper. It is what to look at in a recording of one's own.
"""
_BOUNDS = """
Bounds are those of a recording of a GP25 with everything in it (`rich_case` in `olp/contracts/terms.py`); those that
hang on speeds, accelerations, loads or distances of the recording are others elsewhere. Where all moves are joint
moves, rad stands for m. Below them stands where the search for the values begins, and what `olp diagnose` would say
of the first and the last of these starts and at the lower bounds. Recordings of other kinds tell other forms; what is
otherwise there is listed behind them.
"""


def page() -> str:
    """docs/physics.md."""
    case = rich_case()
    terms = [load_term(name) for name in term_names()]
    table = "".join(
        f"| [`{t.name}`](#{t.name}) | {t.summary} | {_told_by(t)} | {', '.join(f'`{c}`' for c in t.confusable)} |\n"
        for t in terms
    )
    return _HEAD + table + _PICTURES + _BOUNDS + "".join(section(t, case, other_cases()) for t in terms)


def _told_by(term: Term) -> str:
    told = [("durations", isinstance(term, MoveTerm)), ("logs", isinstance(term, LogTerm))]
    return " and ".join(name for name, so in told if so)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
