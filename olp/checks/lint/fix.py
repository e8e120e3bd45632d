"""Changes of a program that fix findings: safe ones that alter neither path nor time, and suggested ones that do.

Each change is verified: after a safe change the program must run step by step as before, after a suggested one the
finding must be gone and nothing new may be wrong. A change that fails this is not applied.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.checks.lint.rule import LintCase, all_rules
from olp.core.diagnostic import OlpError
from olp.reports.outcome.model import OutcomeFinding

if TYPE_CHECKING:
    from olp.ir.program import Program
    from olp.runtime.plan import Positions
    from olp.timing.result import Timing

Run = Callable[["Program"], "Timing"]  # may raise OlpError


@dataclass(frozen=True, slots=True)
class Edit:
    """Replaces lines `first` to `last` of the program's own file by `text`, one entry a line; (): they are deleted.

    `code` and `line`: the finding that it fixes. `says`: short description. `safe`: the robot does the same in the
    same time.
    """

    code: str
    line: int
    first: int
    last: int
    text: tuple[str, ...]
    says: str
    safe: bool


class Fixed(NamedTuple):
    """The program with the verified edits, and the edits that failed the check."""

    program: Program
    done: tuple[Edit, ...]
    refused: tuple[Edit, ...]


def fixes(program: Program, findings: Iterable[OutcomeFinding]) -> list[Edit]:
    """Every change that would fix one of `findings`, in their order; for one finding the safe ones come first."""
    rules = {rule.code: rule for rule in all_rules()}
    found: list[Edit] = []
    for one in findings:
        if one.code not in rules or one.file != program.path:
            continue
        for first, last, text in one.fixes:
            lines = tuple(text.split("\n")) if text else ()
            found.append(Edit(one.code, one.line, first, last, lines, one.help, True))
        for first, last, text, says in rules[one.code].suggest(program, one):
            lines = tuple(text.split("\n")) if text else ()
            found.append(Edit(one.code, one.line, first, last, lines, says, False))
    return found


def fixed(program: Program, edits: Sequence[Edit], run: Run) -> Fixed:
    """The program with those of `edits` that pass the check; of several for one line, the first that does.

    `run` times a program as for the findings. Raises OlpError when the unchanged program cannot be timed.
    """
    before = LintCase(program, run(program))
    together = [e for n, e in enumerate(edits) if e.safe and not _overlaps(e, edits[:n])]
    done: list[Edit] = []
    if len(together) > 1:
        after = _judged(before, together, run)
        if after is not None:
            before, done = after, list(together)
    refused: list[Edit] = []
    for edit in edits:
        if edit in done or any(edit.line == d.line and edit.code == d.code for d in done):
            continue
        after = None if _overlaps(edit, done) else _judged(before, [_moved(edit, done)], run)
        if after is None:
            refused.append(edit)
        else:
            before = after
            done.append(edit)
    return Fixed(before.program, tuple(done), tuple(refused))


def _judged(before: LintCase, edits: Sequence[Edit], run: Run) -> LintCase | None:
    """The case after `edits`; None if the check fails."""
    from olp.languages.vendor import read_source

    program = before.program
    lines: dict[int, tuple[str, ...]] = {
        line: () for edit in edits for line in range(edit.first, edit.last + 1)
    }
    lines |= {edit.first: edit.text for edit in edits}
    try:
        new = read_source(program.source.edited(lines), vendor=program.vendor)
        after = LintCase(new, run(new))
    except (OlpError, UnicodeEncodeError):
        return None
    if _told(after) - _told(before):
        return None
    for code in {edit.code for edit in edits}:
        (rule,) = (rule for rule in all_rules() if rule.code == code)
        if sum(1 for _ in rule.find(after)) >= sum(1 for _ in rule.find(before)):
            return None
    if all(edit.safe for edit in edits) and not same_run(before.timing, after.timing):
        return None
    return after


def same_run(first: Timing, second: Timing) -> bool:
    """Whether two timings have the same steps: equal paths, speeds, stops, waits and times, whatever their lines."""
    a, b = first.plan, second.plan
    if len(a) != len(b) or len(a.moves) != len(b.moves) or a.stop_reason != b.stop_reason:
        return False
    pairs: list[tuple[NDArray[Any], NDArray[Any]]] = [
        (a.kind, b.kind),
        (a.row, b.row),
        (a.source, b.source),
        (a.durations, b.durations),
        (first.duration_s, second.duration_s),
    ]
    for name in a.moves.__dataclass_fields__:
        own, other = getattr(a.moves, name), getattr(b.moves, name)
        if name not in ("start", "target", "via"):
            pairs.append((own, other))
            continue
        # Rows of Positions may be numbered anew.
        pairs.append((own < 0, other < 0))
        for values, others in zip(_places(a.positions), _places(b.positions), strict=True):
            pairs.append((values[own], others[other]))
    return all(np.array_equal(x, y, equal_nan=x.dtype.kind == "f") for x, y in pairs)


def _places(positions: Positions) -> tuple[NDArray[np.float64], ...]:
    return positions.position, positions.quaternion, positions.axes


def _told(case: LintCase) -> Counter[str]:
    """Number of diagnostics by code, of the text, its run and its timing, without assumptions."""
    told = (*case.program.diagnostics, *case.timing.diagnostics)
    return Counter(found.code for found in told)


def _overlaps(edit: Edit, others: Iterable[Edit]) -> bool:
    return any(edit.first <= other.last and other.first <= edit.last for other in others)


def _moved(edit: Edit, done: Iterable[Edit]) -> Edit:
    """The edit with line numbers shifted by the edits in `done` above it."""
    more = sum(len(d.text) - (d.last - d.first + 1) for d in done if d.first < edit.first)
    return replace(edit, line=edit.line + more, first=edit.first + more, last=edit.last + more)


def fix_file(
    path: str,
    findings: Sequence[OutcomeFinding],
    run: Run,
    *,
    unsafe: bool = False,
    encoding: str | None = None,
) -> Fixed | None:
    """Fix the file in place; all other bytes stay. None: there is nothing to do. Raises OlpError and OSError."""
    from olp.core.files import write_output
    from olp.languages.vendor import read

    program = read(path, encoding=encoding)
    edits = [edit for edit in fixes(program, findings) if edit.safe or unsafe]
    if not edits:
        return None
    result = fixed(program, edits, run)
    if result.done:
        write_output(Path(path), result.program.source.raw, inputs=[path], in_place=True)
    return result
