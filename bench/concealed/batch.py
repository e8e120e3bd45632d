"""Makes many cases in several processes. The seeds of all sets are fixed here."""

from __future__ import annotations

import multiprocessing
import sys
from pathlib import Path

from bench.concealed.cases import make, schedule
from bench.concealed.files import write

SEEDS = {"dev": 20_261, "final": 86_420, "final2": 53_197, "final3": 71_905}


def _one(task: tuple[int, int, str, int, str, int]) -> str:
    seed, index, family, turn, folder, moves = task
    if family.startswith("log-"):
        from bench.concealed.logs import make_log, write_log

        log = make_log(seed, index, family, turn)
        write_log(log, Path(folder))
        return log.name
    try:
        case = make(seed, index, family, turn, moves)
    except RuntimeError as problem:
        print(f"\n{problem}", file=sys.stderr)
        return ""
    write(case, Path(folder))
    return case.name


def generate_all(
    seed: int, count: int, folder: Path, jobs: int, families: tuple[str, ...] = (), moves: int = 0
) -> list[str]:
    """The names of the cases written under `folder`: the first `count` of this seed, those of `families`; `moves`: of
    every case that is no log, 0 for as many as it draws.

    A case that no draw can make (its effect cannot be as large as the family asks) is told and left out.
    """
    folder.mkdir(parents=True, exist_ok=True)
    tasks = [
        (seed, i, f, t, str(folder), moves) for i, (f, t) in schedule(count) if not families or f in families
    ]
    with multiprocessing.get_context("spawn").Pool(jobs) as pool:
        names = []
        for name in pool.imap_unordered(_one, tasks):
            names += [name] if name else []
            print(f"\r{len(names)} of {len(tasks)}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return sorted(names)
