"""The tables of a score, in Markdown: the figures that were asked, what was named instead of what, the failed cases."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence

from bench.concealed.judge import Judgement

Test = Callable[[Judgement], bool]


def figures(all_: Sequence[Judgement]) -> list[tuple[str, str, str, str]]:
    """(figure, asked, measured, of how many cases)."""
    clear = [
        j for j in all_ if j.family in ("one", "log-one", "friction") and j.answer["required"] and j.size >= 2
    ]
    many = _of(all_, "overlapped")
    rows = [
        _row("one effect, size ≥ 2: right name first", "≥ 96 %", clear, lambda j: j.first),
        _row("one effect, size ≥ 2: no other name", "≥ 90 %", clear, lambda j: not j.wrong),
        _row("one effect, size ≥ 2: exact", "-", clear, lambda j: j.exact),
        _row("two or three effects: exact set", "≥ 88 %", many, lambda j: j.exact),
        *(_row(f"{f}: right", "≥ 85 %", _of(all_, f), lambda j: j.exact) for f in _CONCEALED),
        _row("poor programs: right, as a group", "-", _of(all_, "poor"), lambda j: j.exact),
        _row("nothing hidden: a false name", "≤ 3 %", _of(all_, "none", "log-none"), lambda j: bool(j.named)),
        _row("nothing hidden: verdict no-mismatch", "-", _of(all_, "none", "log-none"), _calm),
        _row("recorder's fault: clock or nothing", "≥ 95 %", _of(all_, "clock", "log-clock"), _clock_or_nothing),
        _row("outside the list: unexplained, no name", "≥ 90 %", _of(all_, "outside"), _unexplained),
        _row("below the noise: a wrong name", "≤ 3 %", _of(all_, "noise"), lambda j: bool(j.wrong)),
        _mean("rare: F1 of the moves (mean)", "≥ 0.9", [j.f1 for j in all_ if j.f1 is not None]),
        _row("rare: F1 ≥ 0.9", "-", [j for j in all_ if j.f1 is not None], lambda j: (j.f1 or 0) >= 0.9),
        _row("explained: held-out ≤ 1.2 × noise floor", "≥ 90 %", _explained(all_), lambda j: (j.heldout or 9) <= 1.2),
        _coverage(all_),
        _row("any case: groups wider than the data", "-", list(all_), lambda j: bool(j.wide)),
        _row("any case: an answer that contradicts itself", "0 %", list(all_), lambda j: bool(j.contradictions)),
        _row("any case: error or no answer", "-", list(all_), lambda j: bool(j.error)),
        _most("largest CPU time, up to 600 moves [s]", "≤ 8 s", [j.cpu for j in all_ if not _has_log(j)]),
        _most("largest CPU time, other logs [s]", "-", [j.cpu for j in all_ if _has_log(j) and not _long(j)]),
        _most("CPU time, log of 10 minutes [s]", "≤ 12 s", [j.cpu for j in all_ if _long(j)]),
    ]  # fmt: skip
    return [r for r in rows if r[3] != "0"]


_CONCEALED = ("cancelled", "confounded", "rare", "fudged")


def _of(all_: Iterable[Judgement], *families: str) -> list[Judgement]:
    return [j for j in all_ if j.family in families]


def _has_log(j: Judgement) -> bool:
    return j.family.startswith("log-")


def _long(j: Judgement) -> bool:
    return bool(j.answer["simulation"].get("log_s"))


def _calm(j: Judgement) -> bool:
    return j.verdict == "no-mismatch"


def _clock_or_nothing(j: Judgement) -> bool:
    return not j.wrong and not j.error


def _unexplained(j: Judgement) -> bool:
    return not j.wrong and (bool(j.named) or j.verdict == "unexplained")


def _explained(all_: Iterable[Judgement]) -> list[Judgement]:
    return [j for j in all_ if j.verdict == "explained" and j.heldout is not None]


def _row(what: str, asked: str, cases: list[Judgement], test: Test) -> tuple[str, str, str, str]:
    hits = sum(test(j) for j in cases)
    return what, asked, f"{100 * hits / max(len(cases), 1):.1f} % ({hits})", str(len(cases))


def _mean(what: str, asked: str, values: list[float]) -> tuple[str, str, str, str]:
    return what, asked, f"{sum(values) / max(len(values), 1):.2f}", str(len(values))


def _most(what: str, asked: str, values: list[float]) -> tuple[str, str, str, str]:
    return what, asked, f"{max(values, default=0.0):.1f}", str(len(values))


def _coverage(all_: Iterable[Judgement]) -> tuple[str, str, str, str]:
    inside = [c[2] for j in all_ for c in j.covered]
    share = 100 * sum(inside) / max(len(inside), 1)
    return (
        "95 % intervals that hold the truth",
        "92 to 98 %",
        f"{share:.1f} % ({sum(inside)})",
        str(len(inside)),
    )


def coverage_by_term(all_: Iterable[Judgement]) -> list[tuple[str, str, str]]:
    """(term and parameter, intervals, that hold the truth)."""
    by: dict[str, list[bool]] = defaultdict(list)
    for j in all_:
        for term, name, inside, _, _ in j.covered:
            by[f"{term} {name}"].append(inside)
    return [(k, str(len(v)), f"{100 * sum(v) / len(v):.0f} %") for k, v in sorted(by.items())]


def confusion(all_: Iterable[Judgement]) -> list[tuple[str, str, str]]:
    """(hidden, cases, first named), of cases in which one effect can be seen."""
    by: dict[str, Counter[str]] = defaultdict(Counter)
    for j in all_:
        if len(j.answer["required"]) == 1 and j.size >= 2:
            by[j.answer["required"][0]][j.named[0] if j.named else "nothing"] += 1
    return [
        (t, str(sum(c.values())), ", ".join(f"{n} {k}" for n, k in c.most_common()))
        for t, c in sorted(by.items())
    ]


def failures(all_: Iterable[Judgement]) -> list[tuple[str, ...]]:
    """Cases that are not right: (case, hidden with size, named, verdict, what is wrong)."""
    rows = []
    for j in all_:
        right = _unexplained(j) if j.family == "outside" else j.exact
        if right:
            continue
        hidden = ", ".join(f"{t} {j.answer['size'].get(t, 0):.1f}" for t in j.answer["hidden"]) or "-"
        why = j.error or " ".join([*(f"wrong:{t}" for t in j.wrong), *(f"missed:{t}" for t in j.missed)])
        if j.undeclared:
            why += f" (could not be told from the hidden one: {', '.join(j.undeclared)})"
        rows.append((j.name, hidden, ", ".join(j.named) or "-", j.verdict, why or "verdict"))
    return rows


def markdown(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """One table."""
    lines = [f"| {' | '.join(header)} |", f"|{'---|' * len(header)}"]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in rows)])
