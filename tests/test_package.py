"""The wheel: built, listed, installed into an empty environment and used from an empty folder."""

import os
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from olp import cli
from olp.core import resources

ROOT = Path(__file__).parent.parent

Run = Callable[..., subprocess.CompletedProcess[str]]


def call(*command: str | Path, cwd: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    return subprocess.run(
        command, cwd=cwd, env={**clean, **environment}, capture_output=True, text=True, encoding="utf-8"
    )


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built with the tools that are installed: nothing is downloaded."""
    folder = tmp_path_factory.mktemp("wheel")
    done = call(
        sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", folder, ROOT, cwd=folder
    )
    assert done.returncode == 0, done.stdout + done.stderr
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def olp(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Runs the installed `olp` in an empty folder."""
    environment = tmp_path_factory.mktemp("environment")
    empty = tmp_path_factory.mktemp("empty")
    bin_folder = environment / ("Scripts" if os.name == "nt" else "bin")
    steps = [
        [sys.executable, "-m", "venv", "--without-pip", environment],
        # What runs is compiled when it runs: a part of it.
        [sys.executable, "-m", "pip", "--python", environment, "install", "--quiet", "--no-compile", wheel],
    ]
    for step in steps:
        done = call(*step, cwd=empty)
        assert done.returncode == 0, done.stdout + done.stderr

    def run(*words: str | Path, **environment: str) -> subprocess.CompletedProcess[str]:
        return call(bin_folder / "olp", *words, cwd=empty, **environment)

    return run


def in_checkout(*patterns: str) -> set[str]:
    found = (file for pattern in patterns for file in ROOT.glob(pattern))
    return {file.relative_to(ROOT).as_posix() for file in found if file.is_file()}


def test_the_wheel_holds_the_package_its_grammars_templates_and_robots_and_nothing_else(wheel: Path) -> None:
    code = in_checkout("olp/**/*.py", "olp/**/*.toml", "olp/robots/*.csv", "olp/py.typed")
    data = {f"olp/{name}" for name in in_checkout("grammars/*", "templates/**/*")}
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if ".dist-info/" not in name}
        licences = [name for name in archive.namelist() if name.endswith(".dist-info/licenses/LICENSE")]
    assert names == code | data
    assert len(licences) == 1


def test_grammars_and_templates_and_robots_are_all_there() -> None:
    for pattern in ("grammars/inform.lark", "templates/*", "olp/robots/yaskawa/*.toml", "olp/py.typed"):
        assert in_checkout(pattern), pattern


def test_the_installed_command_answers_from_an_empty_folder(olp: Run) -> None:
    assert olp("--version").stdout.startswith("olp ")
    listing = olp("robots")
    assert listing.returncode == 0, listing.stderr
    assert "yaskawa/ma2010" in listing.stdout
    assert olp("--help").stdout == call(sys.executable, "-m", "olp", "--help", cwd=ROOT).stdout


def test_the_installed_command_times_a_sample(olp: Run) -> None:
    sample = ROOT / "samples" / "inform" / "generations" / "dx200.jbi"
    installed, checkout = (
        olp("time", sample, "--format", "json"),
        call(sys.executable, "-m", "olp", "time", str(sample), "--format", "json", cwd=ROOT),
    )
    assert installed.returncode == 0, installed.stderr
    assert installed.stdout == checkout.stdout


@pytest.mark.parametrize("kind", ["zip", "checkout"])
def test_grammars_and_templates_are_found_however_olp_is_installed(
    kind: str, wheel: Path, tmp_path: Path
) -> None:
    script = (
        "import olp.core.resources as r; from olp.cli import names;"
        "print(r.__file__, names(), r.names('grammars', '.lark'), r.names('templates', '.j2'),"
        " r.read_text('grammars', 'inform.lark') != '')"
    )
    path = wheel if kind == "zip" else ROOT
    done = call(sys.executable, "-S", "-c", script, cwd=tmp_path, PYTHONPATH=str(path))
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(str(path))
    listings = (cli.names(), resources.names("grammars", ".lark"), resources.names("templates", ".j2"))
    assert done.stdout.rstrip().endswith(f"{' '.join(map(str, listings))} True")
