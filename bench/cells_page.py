"""Writes docs/cells.md: the handling cell of samples/ in each language, before and after it is translated.

    python bench/cells_page.py

tests/test_cells_page.py compares the page with what the writers say now: a change of theirs is read here as a diff.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Final, NamedTuple

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from olp.fluent import convert  # noqa: E402
from olp.languages.vendor import find_vendor  # noqa: E402

PAGE = ROOT / "docs" / "cells.md"

_ROBOT = "yaskawa/gp25"

_HEAD = """\
# A cell before and after

Written by `python bench/cells_page.py`: edit that, not this page. The handling cell of `samples/` in each language, and
what `olp convert … --robot yaskawa/gp25` makes of it. Each translation is proven ([how](convert.md#the-proof)): both
programs run, and each step is compared. Left out here (…): headers, positions and data, and the subprogram DROP.
"""


class Excerpt(NamedTuple):
    """The part of a program that the page shows."""

    begins: str  # pattern of its first line
    ends: str  # pattern of its last line


class Cell(NamedTuple):
    source: str  # below samples/
    target: str
    says: tuple[str, ...]  # what a person who knows the target sees


_EXCERPTS: Final = {
    "inform": Excerpt(r"SET |MOVJ ", r"END$"),
    "krl": Excerpt(r"DEF .*[Hh][Aa][Nn][Dd][Ll][Ii][Nn][Gg]|DEF main", r"END$"),
    "rapid": Excerpt(r" *PROC (handling|main)\(", r" *ENDPROC"),
    "tp": Excerpt(r" *\d+:[JL] ", r"/POS"),
    "urscript": Excerpt(r"  (set_tcp|movej)", r"end$"),
    "as": Excerpt(r"\.PROGRAM handling", r"\.END"),
    "pdl2": Excerpt(r"BEGIN$", r"END handling"),
    "val3": Excerpt(r" *<Code>", r"end\]\]>"),
}

CELLS: Final = (
    Cell(
        "inform/handling/HANDLING.JBI",
        "krl",
        (
            "Moves are inline forms, which the pendant shows and touches up. Their data stand in the `.dat`.",
            "Tools and frames are set in the fold USER INI.",
            "Behind the loop's corner the input is waited for with CONTINUE, as INFORM reads it while the arm passes.",
        ),
    ),
    Cell(
        "krl/handling.src",
        "rapid",
        (
            "`main` calls the routine; points are LOCAL CONST robtargets of the module, which ModPos changes.",
            "Speeds that RAPID does not predefine are named after their numbers.",
            "Percents of joint moves are speeds that the tool has there; 50 % of acceleration is AccSet.",
        ),
    ),
    Cell(
        "rapid/handling.mod",
        "tp",
        (
            "UFRAME_NUM and UTOOL_NUM precede the moves that need them, and are not said again where they still hold.",
            "Points keep their names as comments, and so do registers.",
            "`Offs` is a position register that the loop fills; WHILE is a pair of labels.",
        ),
    ),
    Cell(
        "tp/handling.ls",
        "urscript",
        (
            "Registers are variables with the names of their comments.",
            "Jumps forward are IF; a jump back is WHILE with the condition that leaves it.",
            "Frames are features: `pose_trans(frame, point)`.",
        ),
    ),
    Cell(
        "urscript/handling.script",
        "inform",
        (
            "The loop that asks for the input is WAIT.",
            "`pose_add` adds to the element of a position variable, in thousandths of a millimetre.",
            "The poses are C positions in the user frames that MFRAME makes of the features.",
        ),
    ),
    Cell(
        "as/handling.as",
        "krl",
        (
            "SPEED and ACCURACY hold for the next move alone.",
            "So the second LMOVE pick has the accuracy that AS has where nothing is said: a corner (CONT).",
        ),
    ),
    Cell(
        "pdl2/handling.pdl",
        "rapid",
        ("`$TOOL` and `$UFRAME` are persistent data that hold what the program sets.",),
    ),
    Cell("val3/start.pgx", "urscript", ("mdesc's speeds and blends stand in the moves.",)),
)


def page() -> str:
    """docs/cells.md."""
    return _HEAD + "".join(map(section, CELLS))


def section(cell: Cell) -> str:
    """One cell: the source, its translation, and what to see in it."""
    spoken = cell.source.partition("/")[0]
    titles = [find_vendor(name).title for name in (spoken, cell.target)]
    files = convert(ROOT / "samples" / cell.source, to=cell.target, robot=_ROBOT)
    name = next(iter(files))
    source = (ROOT / "samples" / cell.source).read_text(encoding="utf-8-sig")
    return "\n".join(
        [
            f"\n## {' to '.join(titles)}\n",
            *(f"- {line}" for line in cell.says),
            *_block(f"samples/{cell.source}", excerpt(source, spoken)),
            *_block(name, excerpt(files[name].decode("utf-8"), cell.target)),
            "",
        ]
    )


def excerpt(text: str, language: str) -> list[str]:
    """The lines of a program's statements."""
    lines = text.replace("\r\n", "\n").split("\n")
    begins = next(i for i, line in enumerate(lines) if re.match(_EXCERPTS[language].begins, line))
    ends = next(i for i in range(begins, len(lines)) if re.match(_EXCERPTS[language].ends, lines[i]))
    return [line.rstrip() for line in lines[begins : ends + 1]]


def _block(name: str, lines: list[str]) -> list[str]:
    return [f"\n`{name}`:\n", "```text", "…", *lines, "…", "```"]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
