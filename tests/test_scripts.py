"""How scripts/olp and scripts/test get their environment (once, whole, for this folder), and what CI starts."""

import importlib.util
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parent.parent


@pytest.fixture
def environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """scripts/environment.py in another folder, where installing is slow and only noted in `calls`."""
    spec = importlib.util.spec_from_file_location("environment", ROOT / "scripts" / "environment.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    (tmp_path / "pyproject.toml").write_bytes((ROOT / "pyproject.toml").read_bytes())
    monkeypatch.setattr(module, "ROOT", tmp_path)
    monkeypatch.setattr(module, "VENV", tmp_path / ".venv")
    monkeypatch.setattr(module, "PYTHON", tmp_path / ".venv" / "python")
    monkeypatch.setattr(module, "PROJECT", tmp_path / "pyproject.toml")
    calls: list[tuple[str, ...]] = []

    def call(*command: str) -> None:
        calls.append(command)
        time.sleep(0.05)
        if command[1:3] == ("-m", "venv"):
            module.PYTHON.symlink_to(sys.executable)

    monkeypatch.setattr(module, "call", call)
    monkeypatch.setattr(module, "calls", calls, raising=False)
    return module


def test_two_first_runs_at_once_install_once(environment: ModuleType) -> None:
    runs = [threading.Thread(target=environment.main, args=("run",)) for _ in range(4)]
    for run in runs:
        run.start()
    for run in runs:
        run.join()
    assert [command[1:3] for command in environment.calls] == [("-m", "venv"), ("-m", "pip")]


def test_running_olp_installs_no_tools_and_the_tools_also_run_olp(environment: ModuleType) -> None:
    environment.main("run")
    assert not any(word.startswith("pytest") for word in environment.calls[-1])
    assert environment.is_ready("run")
    assert not environment.is_ready("dev")
    environment.main("dev")
    assert any(word.startswith("pytest>=") for word in environment.calls[-1])
    (environment.VENV / "olp-run.stamp").unlink()
    assert environment.is_ready("run")


def test_other_requirements_or_another_place_install_again(
    environment: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    environment.main("run")
    with environment.PROJECT.open("a") as project:
        project.write("# changed\n")
    assert not environment.is_ready("run")
    environment.main("run")
    assert environment.is_ready("run")
    monkeypatch.setattr(environment, "ROOT", tmp_path / "moved")
    assert not environment.is_ready("run")


def test_an_installation_that_fails_says_why_and_is_not_taken_for_whole(
    environment: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(*command: str) -> None:
        if command[1:3] == ("-m", "pip"):
            print("no network", file=sys.stderr)
            sys.exit(2)
        environment.PYTHON.symlink_to(sys.executable)

    monkeypatch.setattr(environment, "call", refuse)
    with pytest.raises(SystemExit):
        environment.main("run")
    assert "no network" in capsys.readouterr().err
    assert not environment.is_ready("run")


@pytest.mark.parametrize(
    ("runs", "wanted"),
    [
        ("run", ["test", "test-hosts --ci"]),
        ("nightly", ["test --all", "test-hosts", "docs"]),
    ],
)
@pytest.mark.parametrize("fails", ["", "test", "test-hosts"])
def test_ci_starts_each_part_and_one_that_fails_fails_the_whole(
    runs: str, wanted: list[str], fails: str, tmp_path: Path
) -> None:
    """With scripts in place of the repository's that only note how they were started."""
    (tmp_path / ".ci").mkdir()
    (tmp_path / "scripts").mkdir()
    started = tmp_path / "started"
    copy = tmp_path / ".ci" / runs
    copy.write_bytes((ROOT / ".ci" / runs).read_bytes())
    for name in ("test", "test-hosts", "docs"):
        script = tmp_path / "scripts" / name
        script.write_text(f'#!/bin/sh\necho "{name} $*" >>"{started}"\n[ "{fails}" != {name} ]\n')
        script.chmod(0o755)
    done = subprocess.run(["sh", str(copy)], cwd="/", stdin=subprocess.DEVNULL)
    assert [row.strip() for row in started.read_text().splitlines()] == wanted
    assert done.returncode == (1 if fails else 0)
