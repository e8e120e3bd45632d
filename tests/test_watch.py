"""`--watch`, `olp help` and options that are nearly right."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from argparse import Namespace
from pathlib import Path

import pytest

from olp import cli
from olp.__main__ import main
from olp.cli._watching import watching

ROOT = Path(__file__).parent.parent


@pytest.mark.skipif(os.name == "nt", reason="an interrupt of one process is a POSIX signal")
def test_a_changed_program_is_timed_again_until_it_is_interrupted(tmp_path: Path) -> None:
    job = tmp_path / "DROP.JBI"
    shutil.copy(ROOT / "samples/inform/handling/DROP.JBI", job)
    more = ("--summary", "-o", str(tmp_path / "times.csv"))
    process = subprocess.Popen(
        [
            *(sys.executable, "-u", "-m", "olp", "time", str(tmp_path), "--robot", "yaskawa/gp25", "--watch"),
            *more,
        ],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
        # In the background of a script an interrupt is ignored, and so it would be in what is started there.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    killer = threading.Timer(60, process.kill)
    killer.start()
    try:
        table = tmp_path / "times.csv"
        until(lambda: table.exists() and table.stat().st_size > 0)
        first = table.read_bytes()
        assert process.stdout is not None
        time.sleep(1.0)  # until the folder is watched
        other = tmp_path / "new"  # editors write beside and replace
        other.write_bytes(job.read_bytes().replace(b"V=300.0", b"V=150.0"))
        other.replace(job)
        until(lambda: table.read_bytes() not in (first, b""))
        second = table.read_bytes()
        job.write_text("no program any more")
        until(lambda: table.read_bytes() not in (second, b""))
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=20)[0]
    finally:
        killer.cancel()
        process.kill()
    assert "changed: " in said
    assert "times.csv" not in said.replace("changed: ", "\0").partition("\0")[2].split("\n")[0]
    assert "Traceback" not in said
    assert process.returncode == 2  # of the last run
    # What a run writes is no change: as many runs as changes, or one more for a change seen in two parts.
    assert said.count("changed: ") in (2, 3, 4)


def test_what_changes_while_the_first_run_lasts_is_seen(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = tmp_path / "DROP.JBI"
    job.write_text("/JOB")
    runs = []

    def run(args: Namespace) -> int:
        runs.append(args)
        if len(runs) == 1:
            job.write_text("/JOB changed")
            return 0
        raise KeyboardInterrupt

    assert watching(run, Namespace(paths=[str(tmp_path)], watched="paths")) == 0
    assert len(runs) == 2
    assert "changed: " in capsys.readouterr().out


def until(true: object, seconds: float = 25.0) -> None:
    end = time.monotonic() + seconds
    while not true():  # type: ignore[operator]
        assert time.monotonic() < end, "nothing happened"
        time.sleep(0.05)


def test_without_the_library_it_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "watchfiles", None)
    assert main(["lint", str(ROOT / "samples/inform/handling"), "--watch"]) == 2
    assert 'pip install "olp[watch]"' in capsys.readouterr().err


@pytest.mark.parametrize("name", cli.names())
def test_help_of_a_command_is_its_help(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["help", *name.split()]) == 0
    asked = capsys.readouterr().out
    assert main([*name.split(), "--help"]) == 0
    assert capsys.readouterr().out == asked


def test_help_alone_lists_and_of_no_command_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["help"]) == 0
    assert "usage: olp COMMAND" in capsys.readouterr().out
    assert main(["help", "tiem"]) == 2
    assert "did you mean: olp time?" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("typed", "meant"), [("--robott", "--robot"), ("--sumary", "--summary"), ("--zzz", "")]
)
def test_an_option_that_is_nearly_right_is_named(
    typed: str, meant: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["time", "a.jbi", typed]) == 2
    told = capsys.readouterr().err
    assert (f"did you mean {meant}?" in told) == bool(meant)
    assert "olp time --help lists the arguments" in told
