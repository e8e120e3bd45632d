"""Writes docs/physics.md, the list of all terms, from the terms themselves, and their details for the tests.

    python bench/physics_page.py

tests/test_physics.py compares both. The page has the forms of every recording of `olp/contracts/terms.py`. Details in
tests/data/physics_terms.txt are those of one recording that has every effect: a GP25 at random places, with corners,
loads, joint moves, turns of the tool and waits, in multiples of 12 ms. What other recordings differ in follows.
"""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from olp.contracts.terms import DETAILS, PAGE, details, other_cases, rich_case, section  # noqa: E402  # noqa: E402
from olp.timing.physics import Term, load_term, term_names  # noqa: E402

# --- the page ---------------------------------------------------------------------------------------------------------

_HEAD = """\
# The physics that a simulation may leave out

Written by `python bench/physics_page.py` from `olp/timing/physics/`: edit the terms, not this page.
[Diagnose](diagnose.md) chooses among them.

A term is a forward model: it changes the motion of all moves together, and the change in a duration is added to the
judged simulation's. Of several forms a diagnosis takes at most one (of axis limits, one per axis).

Sections give the trace to look for, the equation of each form (seen in durations unless "in logs") and the parameters.
Bounds depend on the recording. Where all moves are joint moves, read rad for m.

Pictures (`python bench/physics_pictures.py`) show one effect in 160 straight moves: each dot is a move, up is later
than simulated, over the column that orders the dots best; colours split a second column.
"""


def page() -> str:
    """docs/physics.md."""
    cases = [rich_case(), *(case for _, case in other_cases())]
    return _HEAD + "".join(section(t, cases) for t in _terms())


def all_details() -> str:
    """tests/data/physics_terms.txt."""
    return "".join(details(t, rich_case(), other_cases()) for t in _terms())


def _terms() -> list[Term]:
    return [load_term(name) for name in term_names()]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    DETAILS.write_text(all_details(), encoding="utf-8")
