"""The diagnosis in a terminal: the verdict, a sentence per finding with its program line, and what stays open."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from textwrap import wrap
from typing import TYPE_CHECKING

from olp.core.terminal import BOLD, DIM, RED, YELLOW, paint
from olp.identification.diagnosis import phrasing
from olp.identification.diagnosis.result import Diagnosis, Errors, Finding, NextMove

if TYPE_CHECKING:
    from olp.timing.physics._case import MeasuredMoves

GREEN = "32"
_STYLE = {
    "explained": GREEN,
    "no-mismatch": GREEN,
    "partly-explained": YELLOW,
    "unexplained": RED,
    "not-judged": YELLOW,
}
_TITLE = {
    "no-mismatch": "no mismatch",
    "not-judged": "not judged",
    "partly-explained": "partly explained",
    "unexplained": "not explained",
}
_NARROWEST = 40  # characters
_MOST = 8  # lines of a list that may be long
_MM = 1000.0


def text_report(
    diagnosis: Diagnosis, case: MeasuredMoves | None = None, width: int = 100, colour: bool = False
) -> str:
    """The report for people; `width` [characters], 0: lines are not broken; `colour`: ANSI codes."""
    page = _Page(width, colour)
    _verdict(page, diagnosis)
    known = phrasing.places(diagnosis, case)
    for number, (label, finding) in enumerate(
        zip(phrasing.labels(diagnosis.findings), diagnosis.findings, strict=True), 1
    ):
        _finding(page, f"{number}. {label}", finding, known, diagnosis.moves)
    if not diagnosis.findings and diagnosis.verdict != "no-mismatch":
        _worst(page, diagnosis, known)
    _apart(page, diagnosis)
    _remainder(page, diagnosis)
    page.section("not paired", diagnosis.unpaired)
    page.section("assumed and noted", diagnosis.notes)
    return "\n".join(page.lines).replace(phrasing.GLUE, " ") + "\n"


class _Page:
    """Lines, broken at the width, with headings."""

    def __init__(self, width: int, colour: bool) -> None:
        self.lines: list[str] = []
        self._width = max(width, _NARROWEST) if width else 0
        self._colour = colour

    def paint(self, text: str, style: str) -> str:
        return paint(text, style) if self._colour else text

    def head(self, text: str, style: str = BOLD) -> None:
        if self.lines:
            self.lines.append("")
        self.say(text, style=style)

    def say(self, text: str, indent: int = 0, style: str = "", hang: int = 0) -> None:
        """One paragraph; the lines after the first stand `hang` further in."""
        text = phrasing.plain(text)
        first, rest = " " * indent, " " * (indent + hang)
        broken = (
            wrap(text, self._width, initial_indent=first, subsequent_indent=rest, break_on_hyphens=False)
            if self._width
            else [first + text]
        )
        self.lines += [self.paint(line, style) if style else line for line in broken]

    def section(self, title: str, items: Sequence[str]) -> None:
        """A list under a heading; nothing where there is nothing to say."""
        if not items:
            return
        self.head(f"{title}:")
        for item in items[:_MOST]:
            self.say(f"- {item}", 2, hang=2)
        if len(items) > _MOST:
            self.say(f"… and {len(items) - _MOST} more", 2, DIM)


def _verdict(page: _Page, diagnosis: Diagnosis) -> None:
    title = _TITLE.get(diagnosis.verdict, diagnosis.verdict)
    page.head(title.upper(), f"{BOLD};{_STYLE.get(diagnosis.verdict, '0')}")
    page.say(phrasing.headline(diagnosis))
    page.lines.append("")
    for row in _errors(diagnosis):
        page.say(row, hang=2)


def _errors(diagnosis: Diagnosis) -> Iterator[str]:
    """The table of errors; rows that are not known are left out."""
    unseen = (
        f"moves the fit never saw (by {diagnosis.held_out_by})" if diagnosis.held_out_by else "unseen moves"
    )
    whole = f"all {phrasing.counted(diagnosis.moves, 'move')}"
    if not diagnosis.moves:  # positions of axes, as seconds at their usual speed
        unseen, whole = "unseen blocks of the log", "positions in the log"
    rows = [
        (f"{whole}, simulation as it is", diagnosis.before),
        (f"{unseen}, before", diagnosis.heldout_before),
        (f"{unseen}, after", diagnosis.heldout_after),
    ][: 3 if diagnosis.findings else 1]
    known = [(name, errors) for name, errors in rows if math.isfinite(errors.rmse)]
    size = max((len(name) for name, _ in known), default=0)
    for name, errors in known:
        yield f"{name.ljust(size)}  {_error(errors)}"
    how = f" (from {diagnosis.noise_from})" if diagnosis.noise_from else ""
    yield f"{'noise floor'.ljust(size)}  {phrasing.seconds(diagnosis.noise_floor)}{how}"
    if math.isfinite(diagnosis.placebo):
        share = f"{diagnosis.placebo * 100:.0f} % of searches"
        yield f"{'names found in shuffled data'.ljust(size)}  {share}"


def _error(errors: Errors) -> str:
    return (
        f"typically {phrasing.seconds(errors.rmse)}, mean {phrasing.percent(errors.mape)}, "
        f"worst {phrasing.percent(errors.worst)}"
    )


def _finding(page: _Page, title: str, finding: Finding, known: dict[int, phrasing.Place], moves: int) -> None:
    page.head(f"{title}: {phrasing.units(finding.says)}")
    where = phrasing.few(phrasing.largest(finding, known))
    if where:
        costs = phrasing.listed([f"{name} ({phrasing.seconds(cost, sign=True)})" for name, _, cost in where])
        page.say(f"in {len(finding.moves)} of {phrasing.counted(moves, 'move')}; most at {costs}", 3)
    for name, value in finding.parameters.items():
        page.say(phrasing.parameter(name, value), 3, YELLOW if phrasing.doubts(value) else "", hang=2)
    evidence = finding.evidence
    if math.isfinite(evidence.heldout_before) and math.isfinite(evidence.heldout_after):
        page.say(
            f"without it the error on unseen moves is {phrasing.seconds(evidence.heldout_before)}, with it "
            f"{phrasing.seconds(evidence.heldout_after)}; {phrasing.chance(evidence.p_value)}",
            3,
            hang=2,
        )
    if finding.alternatives:
        others = [
            f"{phrasing.alternative(a)} (Δ BIC {phrasing.figure(a.delta_bic, 2)})"
            for a in finding.alternatives
        ]
        page.say(
            f"could also be {phrasing.listed(others, 'or')}; the larger Δ BIC, the less likely",
            3,
            DIM,
            hang=2,
        )


def _worst(page: _Page, diagnosis: Diagnosis, known: dict[int, phrasing.Place]) -> None:
    """Where the difference is, when nobody can say why."""
    ranked = sorted((m for m in diagnosis.mismatch.moves if m.significant), key=lambda m: -abs(m.residual))
    rows = [
        f"{phrasing.place(*known.get(m.move, (None, None))) or 'program line not known'}, move {m.move}: "
        f"{phrasing.seconds(m.residual, sign=True)}"
        for m in ranked
    ]
    page.section("where robot and simulation differ beyond the noise", rows)


def _apart(page: _Page, diagnosis: Diagnosis) -> None:
    groups = [
        phrasing.listed([phrasing.term_title(n) for n in group]) for group in diagnosis.indistinguishable
    ]
    page.section("these moves cannot separate", groups)
    experiment = diagnosis.next_experiment
    if experiment.why:
        page.head(f"to find out: {experiment.why}")
    elif experiment.moves:
        page.head("to find out, run these moves:")
    for number, move in enumerate(experiment.moves[:_MOST], 1):
        page.say(f"{number}. {_next_move(move)}", 2, hang=3)
    if len(experiment.moves) > _MOST:
        page.say(f"… and {len(experiment.moves) - _MOST} more", 2, DIM)
    for timer in experiment.timers:
        times = f", {timer.times} times" if timer.times != 1 else ""
        page.say(f"- a timer of {timer.duration:g} s{times}: {timer.why}", 2, hang=2)


def _next_move(move: NextMove) -> str:
    points = " → ".join(f"({', '.join(f'{c * _MM:z.0f}' for c in p)})" for p in (move.start, move.end))
    load = "" if move.payload is None else f", {phrasing.figure(move.payload)} kg"
    blend = f", rounded by {move.blend * _MM:.0f} mm" if move.blend else ""
    times = f", {move.times} times" if move.times != 1 else ""
    why = f": {move.why}" if move.why else ""
    return f"{points} mm at {move.speed * _MM:.0f} mm/s{load}{blend}{times}{why}"


def _remainder(page: _Page, diagnosis: Diagnosis) -> None:
    remainder = diagnosis.remainder
    if not math.isfinite(remainder.rmse):
        return
    page.head(f"unexplained residual: {phrasing.seconds(remainder.rmse)}")
    for c in remainder.correlates[:_MOST]:
        how = f"{phrasing.figure(c.statistic, 2)}, {phrasing.chance(c.p_value)}"
        page.say(f"- correlates with {c.column} ({how})", 2, hang=2)
    if len(remainder.correlates) > _MOST:
        page.say(f"… and {len(remainder.correlates) - _MOST} more", 2, DIM)
    if remainder.correction:
        page.say(f"- {remainder.correction}", 2, hang=2)
