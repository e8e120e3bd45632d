"""Diagnoses every case of a folder in worker processes, then opens the sealed answers and prints the tables."""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import multiprocessing
import signal
import sys
import time
from pathlib import Path
from typing import Any, NamedTuple

from bench.concealed import fake, tables
from bench.concealed.judge import Judgement, judge

LONGEST = 600  # s after which a case counts as unanswered


class Outcome(NamedTuple):
    """`cpu` [s] of the process; `said`: the error's text."""

    name: str
    cpu: float
    said: str


def run(args: argparse.Namespace) -> int:
    """`score` on the command line."""
    folder: Path = args.folder
    names = case_names(folder, args.families, args.limit)
    answers = {n: json.loads((folder / "sealed" / f"{n}.json").read_text()) for n in names}
    if args.fake:
        judged = [judge(n, fake.diagnosis(args.fake, answers[n]), answers[n], 0.0, "") for n in names]
    else:
        outcomes = _kept(folder, names) if args.again else diagnose_all(folder, names, args.jobs)
        judged = [judge_file(folder, o, answers[o.name]) for o in outcomes]
    text = report(judged)
    if args.baselines:
        from bench.concealed.baselines import table

        text += "\n\n" + table(folder, names, answers)
    print(text)
    if args.table:
        args.table.write_text(text + "\n", encoding="utf-8")
    return 0


def case_names(folder: Path, families: list[str], limit: int) -> list[str]:
    """The cases of a folder, of these families, the first of them."""
    names = sorted(p.stem for p in (folder / "sealed").glob("*.json"))
    names = [n for n in names if not families or n.split("-", 1)[1] in families]
    return names[:limit] if limit else names


def diagnose_all(folder: Path, names: list[str], jobs: int) -> list[Outcome]:
    """Runs `olp diagnose` on every case; the answers are written under `folder`/diagnoses."""
    (folder / "diagnoses").mkdir(exist_ok=True)
    outcomes = []
    kept = {o.name: o._asdict() for o in _kept(folder, [])}
    with multiprocessing.get_context("spawn").Pool(jobs) as pool:
        for outcome in pool.imap_unordered(_diagnose, [(str(folder), n) for n in names]):
            outcomes.append(outcome)
            kept[outcome.name] = outcome._asdict()
            # A run that is broken off can be scored as far as it came: --again.
            (folder / "diagnoses" / "outcomes.json").write_text(json.dumps(kept, indent=1))
            print(f"\r{len(outcomes)} of {len(names)}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return sorted(outcomes)


def _kept(folder: Path, names: list[str]) -> list[Outcome]:
    file = folder / "diagnoses" / "outcomes.json"
    stored = json.loads(file.read_text()) if file.is_file() else {}
    return [Outcome(**v) for k, v in stored.items() if not names or k in names]


def _diagnose(task: tuple[str, str]) -> Outcome:
    from olp.__main__ import main

    folder, name = Path(task[0]), task[1]
    out = folder / "diagnoses" / f"{name}.json"
    out.unlink(missing_ok=True)
    said = io.StringIO()
    signal.signal(signal.SIGALRM, _too_long)
    signal.alarm(LONGEST)
    start = time.process_time()
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
            status = main(["diagnose", str(folder / "cases" / name), "--json", str(out)])
        problem = said.getvalue()[-300:] if status == 2 else ""
    except Exception as raised:
        problem = f"{type(raised).__name__}: {raised}"[:300]
    finally:
        signal.alarm(0)
    return Outcome(name, time.process_time() - start, problem.replace("\n", " "))


def _too_long(*_: object) -> None:
    raise TimeoutError(f"no answer within {LONGEST} s")


def judge_file(folder: Path, outcome: Outcome, answer: dict[str, Any]) -> Judgement:
    """Opens the diagnosis of a case."""
    file = folder / "diagnoses" / f"{outcome.name}.json"
    diagnosis = json.loads(file.read_text()) if file.is_file() else None
    return judge(outcome.name, diagnosis, answer, outcome.cpu, outcome.said)


def report(judged: list[Judgement]) -> str:
    """All tables."""
    parts = [
        tables.markdown(("figure", "asked", "measured", "cases"), tables.figures(judged)),
        tables.markdown(("hidden", "cases", "named first"), tables.confusion(judged)),
        tables.markdown(("parameter", "intervals", "hold the truth"), tables.coverage_by_term(judged)),
        tables.markdown(("case", "hidden, size", "named", "verdict", "why"), tables.failures(judged)),
    ]
    return "\n\n".join(parts)
