"""A vendor as CONTRIBUTING has it written, in a copy of olp: it is found by being there, and keeps both contracts."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
TOY = ROOT / "tests" / "toy_vendor"
NOT_COPIED = shutil.ignore_patterns("__pycache__")


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("copy")
    for name in ("olp", "grammars", "templates", "samples"):
        shutil.copytree(ROOT / name, folder / name)  # with its bytecode, which holds for a copy
    shutil.copytree(TOY, folder, dirs_exist_ok=True, ignore=NOT_COPIED)
    return folder


CHECK = "from olp.contracts import {0}; from olp.languages.vendor import find_vendor; {0}(find_vendor('toy'))"


def run_in(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(folder)}
    return subprocess.run(
        [sys.executable, *arguments], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize("suite", ["check_vendor", "check_writer"])
def test_the_toy_vendor_keeps_its_contract(copy: Path, suite: str) -> None:
    done = run_in(copy, "-c", CHECK.format(suite))
    assert not done.returncode, done.stderr[-4000:]


def test_the_toy_vendor_is_timed_and_translated_without_an_edit_elsewhere(copy: Path) -> None:
    timed = run_in(copy, "-m", "olp", "time", "samples/toy/handling.toy", "--robot", "gp25")
    assert not timed.returncode, timed.stderr
    source = ["samples/krl/handling.src", "--robot", "gp25"]
    made = run_in(copy, "-m", "olp", "convert", *source, "--to", "toy", "-o", "made")
    assert made.returncode in (0, 1), made.stderr
    (written,) = (copy / "made").glob("*.toy")
    assert " SPEED 40 % BLEND 0 " in written.read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_rule_of_a_grammar_that_has_no_method_is_named(copy: Path) -> None:
    path = copy / "olp/languages/vendors/toy/reader.py"
    whole = path.read_text(encoding="utf-8")
    path.write_text(whole.replace("    def dwell(", "    def dwells("), encoding="utf-8")
    try:
        done = run_in(copy, "-c", CHECK.format("check_vendor"))
    finally:
        path.write_text(whole, encoding="utf-8")
    assert "the rule 'dwell' of the grammar has no method in ToyRules" in done.stderr


@pytest.mark.slow
def test_the_recipe_for_a_new_vendor_makes_one_that_keeps_both_contracts(tmp_path: Path) -> None:
    """With a suffix that is not the name, and words of another length."""
    for name in ("olp", "grammars", "templates", "samples", "bench"):
        shutil.copytree(ROOT / name, tmp_path / name)
    shutil.copytree(TOY, tmp_path / "tests" / "toy_vendor", ignore=NOT_COPIED)
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    recipe = page.split("```text\n", 2)[2].split("```")[0]
    for word, own in (
        ("NAME", "robolang"),
        ("SUFFIX", "rbl"),
        ("LANGUAGE", "ROBOLANG"),
        ("Class", "Robolang"),
    ):
        recipe = recipe.replace(word, own)
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    environment["PATH"] = os.pathsep.join((str(Path(sys.executable).parent), environment["PATH"]))
    done = subprocess.run(
        ["bash", "-e", "-c", recipe],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert not done.returncode, done.stderr[-4000:]
