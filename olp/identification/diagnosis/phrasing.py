"""Sentences and numbers of a diagnosis as people read them; the text and the HTML report share them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING

from olp.identification.diagnosis.result import Alternative, Diagnosis, Errors, Finding, FittedParameter

if TYPE_CHECKING:
    from olp.timing.physics._case import MeasuredMoves

MINUS = "−"
GLUE = "\u00a0"  # between a number and its unit: no line ends there
UNKNOWN = "not known"
Place = tuple[str | None, int | None]  # job, 1-based line

_NUMBER = re.compile(r"(?<![\w.^])[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?%?(?![\w])")
_LARGEST_FEW = 3  # moves named in a sentence


def seconds(value: float, sign: bool = False) -> str:
    """[s] as "38 ms" or "1.24 s", three digits; `sign`: with a plus."""
    if not math.isfinite(value):
        return UNKNOWN
    size, unit = (abs(value), "s") if abs(value) >= 0.9995 else (abs(value) * 1000.0, "ms")
    if unit == "s":
        text = f"{size:.2f}" if size < 9.995 else f"{size:.1f}" if size < 99.95 else f"{size:.0f}"
    else:
        text = f"{size:.2f}" if size < 0.995 else f"{size:.1f}" if size < 99.95 else f"{size:.0f}"
    if float(text) == 0.0:
        return f"0{GLUE}ms"
    return f"{_sign(value, sign)}{text}{GLUE}{unit}"


def percent(value: float) -> str:
    """[%] with two digits of sense."""
    if not math.isfinite(value):
        return UNKNOWN
    text = f"{abs(value):.2f}" if abs(value) < 0.995 else f"{abs(value):.1f}"
    return f"{_sign(value) if float(text) else ''}{text}{GLUE}%"


def figure(value: float, digits: int = 4) -> str:
    """A number of any size, `digits` significant; infinite is ∞."""
    if math.isnan(value):
        return UNKNOWN
    if math.isinf(value):
        return f"{_sign(value)}∞"
    text = f"{abs(value):.{digits}g}"
    if "e" in text:
        mantissa, _, power = text.partition("e")
        text = f"{mantissa}·10^{int(power)}".replace("-", MINUS)
    return _sign(value) + text


def ranged(best: str, low: str, high: str, open_low: bool = False, open_high: bool = False) -> str:
    """One clause of those for the best value and for both ends of its interval: their numbers are said as "between 2
    and 3" or, where nothing tells one end, as "at least 2". Clauses of other words are put side by side."""
    numbers = [_NUMBER.findall(text) for text in (low, high)]
    if open_low and open_high:
        return f"{best}, or any other size"
    if low == high:
        return best
    if _NUMBER.split(low) != _NUMBER.split(high):
        return f"{best} (by the ends of the interval: {low}, or {high})"
    words = _NUMBER.split(low)
    told = [_span(a, b, open_low, open_high) for a, b in zip(*numbers, strict=True)]
    return "".join(map("".join, zip_longest(words, told, fillvalue="")))


def _span(a: str, b: str, open_low: bool, open_high: bool) -> str:
    """From the number at the low end to the one at the high end of what it is told by."""
    first, last = (float(text.rstrip("%")) for text in (a, b))
    if first == last:
        return a
    if open_low or open_high:
        known, unknown, text = (last, first, b) if open_low else (first, last, a)
        return f"{'at least' if known < unknown else 'at most'} {text}"
    return f"between {a} and {b}" if first < last else f"between {b} and {a}"


def chance(p_value: float) -> str:
    """A p-value in words."""
    if not math.isfinite(p_value):
        return "chance not known"
    if p_value < 0.001:
        return "by chance in less than 1 of 1000 cases"
    if p_value < 0.01:
        return f"by chance in {p_value * 1000:.0f} of 1000 cases"
    return f"by chance in {p_value * 100:.0f} of 100 cases"


def p_value(value: float) -> str:
    """A p-value for a table."""
    if not math.isfinite(value):
        return ""
    return "< 0.001" if value < 0.001 else f"{value:.3f}"


def listed(words: Sequence[str], last: str = "and") -> str:
    """As in "a, b and c"."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} {last} {words[-1]}"


def counted(number: int, noun: str) -> str:
    """ "1 move", "7 moves"."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def term_title(name: str) -> str:
    """A term as words: "joint speed limit"."""
    return name.replace("-", " ")


def alternative(other: Alternative) -> str:
    """In the place of a finding, or beside a plainer law of its name."""
    title = term_title(other.term)
    return f"a plainer law of this name beside {title}" if other.beside else title


def term_summary(name: str) -> str:
    """What a term means, in its own words; "" for a name that the library does not have."""
    from olp.core.diagnostic import OlpError
    from olp.timing.physics import load_term

    try:
        return load_term(name).summary
    except OlpError:
        return ""


def labels(findings: Sequence[Finding]) -> tuple[str, ...]:
    """One name per finding; several of one term are numbered."""
    names = [term_title(finding.term) for finding in findings]
    seen: dict[str, int] = {}
    out = []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        out.append(name if names.count(name) == 1 else f"{name} {seen[name]}")
    return tuple(out)


def headline(diagnosis: Diagnosis) -> str:
    """The verdict as one sentence."""
    causes = listed(_causes(diagnosis))
    match diagnosis.verdict:
        case "explained":
            return f"The robot differs from the simulation because of {causes or 'the effects below'}."
        case "partly-explained":
            return (
                f"Part of the difference comes from {causes or 'the effects below'}; the rest is unexplained."
            )
        case "no-mismatch":
            return "Simulation and robot agree: no difference exceeds the noise of the recording."
        case "not-judged":
            return "Nothing was judged: there was nothing to compare, or too little."
    return "The difference is real, but no known effect holds on moves that the fit never saw."


def _causes(diagnosis: Diagnosis) -> list[str]:
    """Every named term, with those that the data cannot tell from it."""
    named = dict.fromkeys(finding.term for finding in diagnosis.findings)
    out = []
    for term in named:
        groups = [group for group in diagnosis.indistinguishable if term in group]
        like = [
            other for other in dict.fromkeys(name for group in groups for name in group) if other not in named
        ]
        also = f" (or {listed([_quoted(other) for other in like], 'or')})" if like else ""
        out.append(_quoted(term) + also)
    return out


def _quoted(term: str) -> str:
    return f"“{term_title(term)}”"


def promise(diagnosis: Diagnosis) -> str:
    """What naming the effects is worth, on moves that neither search nor fit saw; "" where nothing is known."""
    before, after = diagnosis.heldout_before, diagnosis.heldout_after
    if not diagnosis.moves and math.isfinite(before.rmse):
        late = f"axes are typically off by as much as {seconds(before.rmse)} at their usual speed"
        left = f", and by {seconds(after.rmse)} with the findings" if diagnosis.findings else ""
        return f"In parts of the log that the fit never saw, {late}{left}; {floor(diagnosis)}."
    if not diagnosis.findings:
        told = math.isfinite(diagnosis.before.rmse)
        return f"The typical error is {errors(diagnosis.before)}; {floor(diagnosis)}." if told else ""
    if not (math.isfinite(before.rmse) and math.isfinite(after.rmse)):
        return ""
    return (
        f"On moves that the fit never saw, the typical error goes from {errors(before)} to {errors(after)}; "
        f"{floor(diagnosis)}."
    )


def floor(diagnosis: Diagnosis) -> str:
    """The noise floor as a clause."""
    if not math.isfinite(diagnosis.noise_floor):
        return "the noise floor is not known"
    return f"the noise floor is {seconds(diagnosis.noise_floor)}"


def errors(found: Errors) -> str:
    """As in "121 ms (4.1 % of the duration)"."""
    share = f" ({percent(found.mape)} of the duration)" if math.isfinite(found.mape) else ""
    return f"{seconds(found.rmse)}{share}"


def parameter(name: str, value: FittedParameter) -> str:
    """ "time 0.038 s (95 % interval 0.036 to 0.040)" and what is wrong with it."""
    unit = f"{GLUE}{units(value.unit)}" if units(value.unit) else ""
    text = f"{name.replace('_', ' ')} {figure(value.value)}{unit}"
    if math.isfinite(value.low) and math.isfinite(value.high):
        text += f" (95 % interval {figure(value.low)} to {figure(value.high)})"
    return "; ".join([text, *doubts(value)])


def plain(text: str) -> str:
    """Text from a file without what could steer a terminal or turn the reading direction."""
    return "".join(c if c.isprintable() or c in (GLUE, "\t") else "\ufffd" for c in text)


def units(text: str) -> str:
    """A unit, or a sentence with units, as it is printed: m/s² for m/s^2; nothing for a ratio."""
    return "" if text == "1" else text.replace("^2", "²").replace("^3", "³")


def doubts(value: FittedParameter) -> list[str]:
    """What keeps a fitted number from being a result."""
    found = (
        ["at the bound of its range: the effect is there, its size is not known"] if value.at_bound else []
    )
    if not value.identified:
        found.append("these moves do not determine its size")
    return found


def place(job: str | None, line: int | None) -> str:
    """ "CELL-7.JBI:31", or as much of it as is known."""
    return f"{job}:{line}" if job and line else f"line {line}" if line else job or ""


def places(diagnosis: Diagnosis, case: MeasuredMoves | None) -> dict[int, Place]:
    """Job and line of every move that has them."""
    found: dict[int, Place] = {}
    if case is not None:
        for move, job, line in zip(case.move.tolist(), case.job, case.line.tolist(), strict=True):
            if job or line:
                found[move] = (job or None, line or None)
    for told in diagnosis.mismatch.moves:
        if told.job or told.line:
            found.setdefault(told.move, (told.job, told.line))
    return found


def largest(finding: Finding, known: dict[int, Place]) -> Iterator[tuple[str, int, float]]:
    """Where a finding costs most: place (or "move 12"), move and [s]; one of each place, the largest first."""
    acting = set(finding.moves) or set(finding.contribution)
    ranked = sorted(
        ((m, s) for m, s in finding.contribution.items() if m in acting and math.isfinite(s)),
        key=lambda item: -abs(item[1]),
    )
    seen: set[str] = set()
    for move, cost in ranked:
        where = place(*known.get(move, (None, None))) or f"move {move}"
        if where not in seen:
            seen.add(where)
            yield where, move, cost


def few(items: Iterable[tuple[str, int, float]], most: int = _LARGEST_FEW) -> list[tuple[str, int, float]]:
    """The first of them."""
    return [item for item, _ in zip(items, range(most), strict=False)]


def _sign(value: float, plus: bool = False) -> str:
    return MINUS if value < 0 else "+" if plus and value > 0 else ""
