"""Small cells for the tests of budgets, differences and rules: jobs in a folder, with an olp.toml."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from interpreter_jobs import write_jobs

from olp.checks.guard.run import GuardSettings, JudgedFile, run, tasks
from olp.reports.batch import Job

# A cell whose main job calls a routine several times, in a loop and one after the other.
CELL = {
    "MAIN": """
        MOVL C00000 V=100.0
        *START
        MOVL C00001 V=200.0 PL=0
        CALL JOB:GRIP
        CALL JOB:GRIP
        MOVL C00002 V=150.0 PL=0
        *FINISH
        TIMER T=0.70
        MOVL C00005 V=300.0 PL=0
        """,
    "GRIP": """
        MOVL C00003 V=120.0 PL=0
        TIMER T=0.25
        DOUT OT#(1) ON
        MOVL C00004 V=90.0 PL=0
        """,
}


def cell(folder: Path, budgets: str = "", jobs: dict[str, str] | None = None) -> Path:
    """Writes a cell; the path of its main job."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "olp.toml").write_text(budgets, encoding="utf-8")
    return write_jobs(folder, CELL if jobs is None else jobs)


class Run(NamedTuple):
    """What a run over a cell found, and which programs it timed anew."""

    results: list[JudgedFile]
    timed: list[str]

    @property
    def items(self) -> dict[str, str]:
        return {item.name: str(item.status) for result in self.results for item in result.items}


def check(folder: Path, monkeypatch, cache: Path | None = None, **settings: object) -> Run:
    """`olp check FOLDER` in this process."""
    import olp.checks.guard.run as module

    timed: list[str] = []

    def watched(path, budgets, job):
        timed.append(Path(path).name)
        return judge(path, budgets, job)

    judge = module.judge
    with monkeypatch.context() as patch:
        patch.setattr(module, "judge", watched)
        paths = [str(path) for path in sorted(folder.rglob("*.JBI"))]
        found = run(tasks(paths).tasks, GuardSettings(Job(**settings), 1, cache))
    return Run(found, timed)
