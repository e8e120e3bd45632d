"""The report of a fit, as text and as data, and the picture of the totals for more and fewer edits."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from olp.checks.fit.choices import Choice
from olp.checks.fit.fit import Fit
from olp.reports.plot.figure import Axes, Dot, Figure, TextLabel
from olp.reports.plot.output import picture, refuse_unknown


def as_text(fit: Fit) -> str:
    """A table of the edits, their uncertainty, and the front."""
    total = fit.timing.total_s
    head = f"{fit.before_s:.3f} → {total:.3f} s"
    if fit.reached:
        rows = [f"{head}: {_edits(len(fit.edits))} for {fit.to_s:g} s"]
    else:
        best = f"{head} is the best that {_edits(len(fit.edits))} can do"
        rows = [f"{fit.to_s:g} s cannot be reached: {best}; nothing is written"]
    rows += _table(fit)
    if fit.limits:
        rows.append("what stops it:")
        rows += [f"  {one}" for one in fit.limits]
    rows += [
        f"{Path(path).name} is called by {', '.join(names)} as well: they become faster, too"
        for path, names in fit.shared.items()
        if names
    ]
    if not fit.reached:
        rows.append(
            "what may help: a higher --max-speed or --max-acceleration, a larger --within, --free or --order; "
            "with -o FOLDER/ the programs that it calls are changed as well"
        )
    ends, needed = fit.timing.total_ends, fit.needed_s
    if ends is not None and needed is not None:
        rows.append(
            f"in 95 % of cases {ends[0]:.3f} to {ends[1]:.3f} s: {fit.to_s:g} s holds in them from {needed:.3f} s on"
        )
    rows.append("best totals:")
    rows += [
        f"  {_edits(one.edits):>10}, corners within {one.within_mm:g} mm: {one.total_s:.3f} s"
        for one in fit.front
    ]
    return "\n".join(rows)


def _edits(count: int) -> str:
    return f"{count} edit{'s' * (count != 1)}"


def _table(fit: Fit) -> list[str]:
    if not fit.edits:
        return []
    cells = [("line", "edit", "gained s", "mm", "limited now by")]
    cells += [
        (
            f"{Path(one.choice.path).name + ' ' if one.choice.path else ''}{_line(one.choice)}",
            one.choice.says,
            f"{one.gained_s:.3f}",
            f"{one.deviation_mm:.3f}" if one.choice.zone >= 0 or one.choice.joint > 0.0 else "",
            one.limit,
        )
        for one in fit.edits
    ]
    widths = [max(len(row[k]) for row in cells) for k in range(5)]
    return [
        f"  {a:>{widths[0]}}  {b:{widths[1]}}  {c:>{widths[2]}}  {d:>{widths[3]}}  {e}".rstrip()
        for a, b, c, d, e in cells
    ]


def _line(choice: Choice) -> int:
    """The line number of the move, or of the setting that changes for it."""
    return choice.line if choice.line in choice.lines else min(choice.lines)


def as_json(fit: Fit) -> dict[str, object]:
    """The report as data."""
    ends = fit.timing.total_ends
    return {
        "file": fit.program.path,
        "reached": fit.reached,
        "to_s": fit.to_s,
        "before_s": fit.before_s,
        "total_s": fit.timing.total_s,
        "low_s": None if ends is None else ends[0],
        "high_s": None if ends is None else ends[1],
        "needed_s": fit.needed_s,
        "edits": [
            {
                "kind": one.choice.kind,
                "file": one.choice.path or fit.program.path,
                "line": one.choice.line,
                "changes": sorted(one.choice.lines),
                "says": one.choice.says,
                "gained_s": one.gained_s,
                "deviation_mm": one.deviation_mm,
                "limited_by": one.limit,
            }
            for one in fit.edits
        ],
        "limits": list(fit.limits),
        "shared": {path: list(names) for path, names in fit.shared.items()},
        "front": [one._asdict() for one in fit.front],
    }


def refuse_front(path: str) -> None:
    """Raises OlpError (E003) for a file name that is neither JSON nor a picture."""
    if not path.lower().endswith(".json"):
        refuse_unknown(path)


def front_file(fit: Fit, path: str | None) -> bytes | None:
    """The front in the format of the suffix of `path`: JSON, or a picture."""
    if path is None:
        return None
    if path.lower().endswith(".json"):
        return (json.dumps([one._asdict() for one in fit.front], indent=2) + "\n").encode()
    return picture(front_figure(fit), path)


def front_figure(fit: Fit) -> Figure:
    """Totals over the number of edits and, where corners are passed, over the distance from them; and the requested
    time.
    """
    edits = [(float(one.edits), one.total_s) for one in fit.front]
    passed = [(one.within_mm, one.total_s) for one in fit.front]
    rounds = any(mm > 0.0 for mm, _ in passed)
    figure = Figure(640, 775 if rounds else 400, "best totals by number of edits")
    _panel(figure, 40, edits, fit.to_s, "edits", "what so many edits can do at best")
    if rounds:
        _panel(figure, 415, passed, fit.to_s, "mm", "what corners passed by so much can do at best")
    return figure


def _panel(
    figure: Figure, top: float, points: Sequence[tuple[float, float]], to_s: float, unit: str, title: str
) -> None:
    """Plot the best total up to each number."""
    best: dict[float, float] = {}
    for x, y in sorted(points):
        best[x] = min(y, best.get(x, y))
    most = 1.05 * (max(best, default=1.0) or 1.0)
    seconds = [*best.values(), to_s]
    room = 0.05 * (max(seconds) - min(seconds) or 1.0)
    axes = Axes(figure, 70, top, 540, 290, (0.0, most), (min(seconds) - room, max(seconds) + room))
    axes.frame(unit, "s", title)
    axes.line([0.0, most], [to_s, to_s], "orange", dash=(5, 4))
    figure.add(TextLabel(axes.left + axes.width - 4, axes.y(to_s) - 5, f"{to_s:g} s", "orange", anchor="end"))
    axes.line(list(best), list(best.values()), "blue")
    figure.add(*(Dot(axes.x(x), axes.y(y), 3.5, "blue") for x, y in best.items()))
