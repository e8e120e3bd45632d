"""`olp check --scheduler`: the same results on a Dask cluster, also when a worker is killed in the middle."""

from __future__ import annotations

import os
import signal
import warnings
from pathlib import Path

import pytest
from guard_cells import cell

from olp.__main__ import main
from olp.checks.guard.run import GuardSettings, run, tasks
from olp.reports.batch import Job

pytestmark = pytest.mark.slow

BODY = "MOVL C00000 V=100.0\nMOVL C000{:02d} V=150.0\nTIMER T=0.{:02d}"


@pytest.fixture(scope="module")
def cluster():
    """Two workers, each a process of its own."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from distributed import LocalCluster

        with LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
        ) as found:
            yield found


@pytest.fixture
def jobs(tmp_path) -> list[str]:
    cell(
        tmp_path,
        "[[budget]]\nname = 'b'\nlimit_s = 1.0\n",
        {f"J{n:04d}": BODY.format(n % 10 + 1, n % 90 + 5) for n in range(240)},
    )
    return [str(path) for path in sorted(tmp_path.glob("*.JBI"))]


@pytest.mark.filterwarnings("ignore")
def test_a_killed_worker_loses_nothing_and_counts_nothing_twice(cluster, jobs):
    work = tasks(jobs).tasks
    expected = run(work, GuardSettings(Job(), 2))
    victims = [worker.pid for worker in cluster.workers.values()]
    seen: list[int] = []

    def kill(count: int) -> None:
        seen.append(count)
        if sum(seen) >= 40 and victims:
            os.kill(victims.pop(), signal.SIGKILL)
            victims.clear()

    found = run(work, GuardSettings(Job(), scheduler=cluster.scheduler_address), kill)
    assert not victims, "no worker was killed"
    assert [result.path for result in found] == jobs
    assert found == expected
    assert sum(seen) == len(jobs)


@pytest.mark.filterwarnings("ignore")
def test_paths_seen_from_here_mean_the_same_files_to_the_workers(cluster, jobs, monkeypatch, capsys):
    home = Path(jobs[0]).parent
    monkeypatch.chdir(home)
    names = [Path(job).name for job in jobs[:40]]
    assert main(["check", "--scheduler", cluster.scheduler_address, *names]) == 1
    found = capsys.readouterr().out
    assert main(["check", "--no-cache", *names]) == 1
    assert found == capsys.readouterr().out


@pytest.mark.filterwarnings("ignore")
def test_a_cluster_that_is_not_there_is_told(jobs, capsys, monkeypatch):
    import olp.checks.guard.run as module

    monkeypatch.setattr(module, "_PATIENCE", "1s")
    assert main(["check", "--scheduler", "tcp://127.0.0.1:9", jobs[0]]) == 2
    assert "M003" in capsys.readouterr().err


def test_without_the_extra_the_command_says_what_to_install(jobs, capsys, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "distributed", None)
    assert main(["check", "--scheduler", "tcp://127.0.0.1:9", jobs[0]]) == 2
    assert 'pip install "olp[cluster]"' in capsys.readouterr().err
