"""What the benches on real robots share: a recording with what is expected of it, diagnosed and printed."""

from __future__ import annotations

import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from tables import print_table

from olp.identification.diagnosis.diagnose import DiagnosisOutcome, diagnose_recording
from olp.identification.recording import read_recording


class Case(NamedTuple):
    """`expected`: names of which at least one has to be said, and no other; empty: none may be said."""

    title: str
    path: Path
    expected: frozenset[str]


def print_cases(cases: list[Case]) -> None:
    rows, outcomes = [], []
    for case in cases:
        begin = time.process_time()
        outcome = diagnose_recording(read_recording(case.path))
        outcomes.append(outcome)
        rows.append((case.title, *_row(case, outcome), f"{time.process_time() - begin:.1f}"))
    header = (
        "recording",
        "moves",
        "verdict",
        "named",
        "asked",
        "before ms",
        "held out ms",
        "after ms",
        "CPU s",
    )
    print_table(header, rows)
    for case, outcome in zip(cases, outcomes, strict=True):
        print(f"\n{case.title}")
        print_findings(outcome)


def _row(case: Case, outcome: DiagnosisOutcome) -> tuple[str, ...]:
    told = outcome.diagnosis
    names = [finding.term for finding in told.findings]
    wrong = [name for name in names if name not in case.expected]
    right = bool(set(names) & case.expected) if case.expected else not names
    verdict = (
        "right" if right and not wrong else "right, and more" if right else "wrong" if wrong else "not named"
    )
    return (
        str(told.moves),
        told.verdict,
        ", ".join(names) or "none",
        f"{' or '.join(sorted(case.expected)) or 'none'}: {verdict}",
        f"{1000 * told.before.rmse:.1f}",
        f"{1000 * told.heldout_after.rmse:.1f} (by {told.held_out_by})",
        f"{1000 * float(np.sqrt(np.mean((outcome.case.measured - outcome.predicted) ** 2))):.1f}",
    )


def print_findings(outcome: DiagnosisOutcome) -> None:
    """The sentences of a diagnosis, its numbers and its ledger."""
    told = outcome.diagnosis
    for finding in told.findings:
        moves = f"{len(finding.moves)} of {told.moves} moves"
        print(f"  {finding.term}: {finding.says} ({moves})")
        for name, p in finding.parameters.items():
            bound = ", at its bound" if p.at_bound else "" if p.identified else ", not identified"
            print(f"    {name} {p.value:.4g} {p.unit}, 95 % {p.low:.4g} to {p.high:.4g}{bound}")
        others = ", ".join(f"{a.term} {a.delta_bic:+.1f}" for a in finding.alternatives)
        print(
            f"    delta BIC {finding.evidence.delta_bic:.1f}; instead of it: {others or 'nothing comes near'}"
        )
    alike = "; ".join(", ".join(group) for group in told.indistinguishable) or "none"
    print(f"  alike: {alike}; placebo {told.placebo:.2f}; noise floor {1000 * told.noise_floor:.1f} ms")
    for column in told.remainder.correlates[:4]:
        print(f"  the residual correlates with {column.column} ({column.statistic:+.2f})")
    ledger = (
        sum(np.array(list(f.contribution.values())) for f in told.findings) if told.findings else np.zeros(1)
    )
    whole = outcome.predicted - outcome.case.simulated
    if told.findings:
        print(f"  ledger adds up within {1000 * float(np.abs(ledger - whole).max()):.3f} ms")
