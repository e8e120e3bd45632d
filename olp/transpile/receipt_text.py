"""The receipt of a translation for people: first what matters, then the details, each said once."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from olp.core.units import deg, mm
from olp.ir.terminology import STATEMENTS
from olp.languages.vendor import language_of
from olp.transpile.compare import Comparison, PlanDifference, Tolerances
from olp.transpile.context import Fate, Loss
from olp.transpile.preflight import places, some
from olp.transpile.receipt import Receipt

_FATES = tuple(Fate)
_DIFFERENCES = 20  # that are shown
_LARGEST = 4
_KINDS = {
    "difference": "the runs differ",
    "named": "the runs differ as is named below",
    "left-out": "left out of the translation",
    "uncompared": "the runs could not be compared to their end",
}
_TINY = 1e-6  # what is smaller is the rounding of a computer

_NAME = "\0"

Group = list[Loss]
_Where = tuple[int, int, str]  # the lines of a difference in both programs, and what it says


def as_text(receipt: Receipt) -> str:
    """How much is exact, what differs most, what is to be done; behind that each difference, names and notes."""
    parts = [
        [
            f"{receipt.source} ({receipt.source_vendor}) as {receipt.target_vendor}: {', '.join(receipt.files)}",
            *_summary(receipt),
        ],
        _listed("before it runs", receipt.before_run),
        list(_table(receipt)),
        [_told(receipt, group) for group in _groups(receipt.losses)],
        list(_names(receipt)),
        [
            *(f"note: {note}" for note in receipt.notes),
            *(f"note: {_place(receipt, group)}: {group[0].says}" for group in _groups(receipt.remarks)),
        ],
    ]
    return "\n\n".join("\n".join(lines) for lines in parts if lines) + "\n"


def _listed(title: str, rows: Iterable[str]) -> list[str]:
    lines = [f"- {row}" for row in rows]
    return [f"{title}:", *lines] if lines else []


# --- the first screen -----------------------------------------------------------------------------------


def _summary(receipt: Receipt) -> Iterator[str]:
    totals = receipt.totals
    count = sum(totals.values())
    others = [f"{n} {fate}" for fate, n in totals.items() if n and fate != Fate.EXACT]
    exact = totals[Fate.EXACT.value]
    if any(one.kind == "difference" for one in receipt.verdict.objections):
        # Nothing that was counted can stand above a difference that nobody named.
        told = [f"{n} {fate}" for fate, n in totals.items() if n and fate != Fate.EXACT]
        said = ["the runs differ", *([", ".join(told)] if told else [])]
        yield f"{count} statement{'s' * (count != 1)}: {', '.join(said)}"
    else:
        said = [f"{exact} exact" if others else "all exact", *others]
        yield f"{count} statement{'s' * (count != 1)}: {', '.join(said)}"
    yield from _verdict(receipt)
    yield from _compared(receipt)
    if largest := _largest(receipt):
        yield f"largest differences: {'; '.join(largest)}"


def _verdict(receipt: Receipt) -> Iterator[str]:
    """Whether the translation is proven; the first line that differs in both programs, and why."""
    objections = receipt.verdict.objections
    c = receipt.comparison
    if not objections:
        if c is not None and c.steps:
            yield f"proven: every step of both runs agrees within {_within(c.tolerances)}"
        return
    kinds = dict.fromkeys(one.kind for one in objections)
    for kind in kinds:
        some = [one for one in objections if one.kind == kind]
        file, line = receipt.places.get(some[0].line, (receipt.source, some[0].line))
        place = f"{file}:{line}" if line else file
        others = len({one.line for one in some}) - 1
        more = f" (and {others} more lines)" if others > 1 else " (and another line)" if others else ""
        yield f"not proven: {_KINDS[kind]}, first at {place}: {some[0].says}{more}"


def _within(t: Tolerances) -> str:
    return (
        f"{_number(t.position / mm)} mm, {_number(t.angle / deg)} deg, speeds {_number(100 * t.speed)} %,"
        f" blends {_number(t.blend / mm)} mm, waits {_number(t.wait)} s"
    )


def _compared(receipt: Receipt) -> Iterator[str]:
    c = receipt.comparison
    if receipt.data_only:
        yield "nothing in it runs: it holds data, for the programs beside it"
        return
    if c is None:
        yield "the two programs could not be run and compared"
        return
    if c.until:
        file, line = receipt.places[c.until]
        yield f"compared only until {file}:{line}, where what runs depends on a value that is not known here"
    elif receipt.unknown:
        yield f"left out of both runs, for their values are not known here: {receipt.unknown}"
    if receipt.unreached:
        yield f"no run comes to these moves, so they were not compared: {receipt.unreached}"
    others = (*receipt.again, *receipt.starts.values(), *receipt.made_up)
    further = any(one.steps or one.differences for one in others)
    if not (c.steps or c.differences or further):
        yield "neither program moves or waits here: there was nothing to compare"
        return
    yield (
        f"both run: {c.steps} steps, at most {_number(c.worst_position / mm)} mm and {_number(c.worst_angle / deg)} deg"
        f" apart, speeds {_number(100 * c.worst_speed)} %, blends {_number(c.worst_blend / mm)} mm,"
        f" waits {_number(c.worst_wait)} s"
    )
    told: set[_Where] = set()
    yield from _few(_each_once([c], told))
    for again in receipt.again:
        new = _each_once([again], told)
        yield f"with the inputs on: {again.steps} steps, {len(new) or 'no'} further differences"
        yield from _few(new)
    for name, start in receipt.starts.items():
        own = _each_once([start], set())
        yield f"from {name}: {start.steps} steps, {len(own) or 'no'} differences"
        yield from _few(own)
    if receipt.made_up:
        new = _each_once(receipt.made_up, told)
        steps = sum(one.steps for one in receipt.made_up)
        yield (
            f"with other values for what no file tells, {len(receipt.made_up)} times: {steps} steps,"
            f" {len(new) or 'no'} further differences"
        )
        yield from _few(new)
    if receipt.times:
        source, target = (_total([row[at] for row in receipt.times]) for at in (1, 3))
        names = " and ".join(dict.fromkeys(name for name in receipt.robots if name)) or "no robot named"
        yield f"predicted ({names}): {source} before, {target} after"


def _each_once(runs: Iterable[Comparison], told: set[_Where]) -> list[str]:
    """What differs, once for each pair of lines, with the number of steps. Without what is in `told`, which grows."""
    found: dict[_Where, list[PlanDifference]] = {}
    for run in runs:
        for one in run.found:
            found.setdefault((one.line, one.other, one.text), []).append(one)
    new = [
        f"{each[0].where}, step {each[0].step}{f' and {len(each) - 1} later' * (len(each) > 1)}: {each[0].text}"
        for where, each in found.items()
        if where not in told
    ]
    told.update(found)
    return new


def _few(differences: list[str]) -> Iterator[str]:
    yield from (f"  {says}" for says in differences[:_DIFFERENCES])
    if len(differences) > _DIFFERENCES:
        yield f"  and {len(differences) - _DIFFERENCES} more differences"


def _total(seconds: list[float]) -> str:
    """The sum of the times that are known."""
    known = [one for one in seconds if not math.isnan(one)]
    return f"{'' if len(known) == len(seconds) else 'at least '}{sum(known):.3f} s"


def _number(value: float) -> str:
    return "0" if abs(value) < _TINY else f"{value:.2g}"


def _largest(receipt: Receipt) -> list[str]:
    """The largest difference of each part and unit, with its place."""
    worst: dict[tuple[str, str], Loss] = {}
    for loss in receipt.losses:
        key = (loss.part, loss.unit)
        if loss.size > _TINY and (key not in worst or loss.size > worst[key].size):
            worst[key] = loss
    found = [
        f"{part} {loss.size:.3g} {unit} at {places([receipt.place(loss)])}"
        for (part, unit), loss in worst.items()
    ]
    return found[:_LARGEST]


def _table(receipt: Receipt) -> Iterator[str]:
    """What is not exact of each kind of statement."""
    rows = {STATEMENTS[kind]: row for kind, row in receipt.counts.items() if set(row) - {Fate.EXACT.value}}
    if not rows:
        return
    width = max(map(len, [*rows, "statement"]))
    yield f"{'statement':<{width}}" + "".join(f"{fate.value:>14}" for fate in _FATES)
    for called, row in rows.items():
        cells = "".join(f"{row.get(fate.value, 0) or '':>14}" for fate in _FATES)
        yield f"{called:<{width}}{cells}".rstrip()


# --- the details ----------------------------------------------------------------------------------------


def _groups(losses: Iterable[Loss]) -> list[Group]:
    """What says the same, the worst fates first."""
    found: dict[tuple[bool, Fate, str, str, str], Group] = {}
    for loss in losses:
        says = loss.says.replace(loss.name, _NAME, 1) if loss.name else loss.says
        key = (not loss.line, loss.fate, loss.part, says, loss.unit)
        found.setdefault(key, []).append(loss)
    return sorted(found.values(), key=lambda group: -_FATES.index(group[0].fate))


def _place(receipt: Receipt, group: Group) -> str:
    lines = len({loss.line for loss in group})
    return places(map(receipt.place, group)) + (f" ({lines} lines)" if lines > 1 else "")


def _told(receipt: Receipt, group: Group) -> str:
    first = group[0]
    part = "" if first.part == "statement" else f" {first.part}"
    sizes = [loss.size for loss in group if not math.isnan(loss.size)]
    size = f", {'at most ' if len(set(sizes)) > 1 else ''}{max(sizes):.4g} {first.unit}" if sizes else ""
    kinds = ", ".join(dict.fromkeys(STATEMENTS[loss.statement] for loss in group))
    what = f"{kinds}:{part}" if part and "," in kinds else f"{kinds}{part}" if first.line else first.part
    # What a writer cannot say is told by its kind alone: once is enough.
    says = f"{language_of(receipt.target_vendor)} has none" if first.says == what else first.says
    if len(names := list(dict.fromkeys(loss.name for loss in group))) > 1:
        says = f"{says.replace(first.name, f'each of {len(names)} names', 1)}: {some(names)}"
    return f"{_place(receipt, group)}: {what} {first.fate.value}: {says}{size}"


def _names(receipt: Receipt) -> Iterator[str]:
    """Which name is which, in one line for each kind; the receipt for scripts has all of them."""
    kinds: dict[str, list[str]] = {}
    for (kind, name), to in receipt.mapping.items():
        if name != to:
            kinds.setdefault(kind, []).append(f"{name} is {to}")
    for kind, names in kinds.items():
        yield f"{kind}{'s' * (len(names) > 1)}: {some(names)}"
