"""The notebooks of docs/notebooks and the examples of the library's docstrings run as they stand."""

from __future__ import annotations

import ast
import doctest
import json
import re
import shutil
from pathlib import Path
from typing import Any

import matplotlib
import pandas
import pytest

import olp

ROOT = Path(__file__).resolve().parents[1]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))


def executed(path: Path) -> list[Any]:
    """What the last expression of each code cell is, in the notebook's folder and one namespace."""
    space: dict[str, Any] = {}
    values = []
    for cell in json.loads(path.read_text("utf-8"))["cells"]:
        if cell["cell_type"] == "code":
            assert cell["outputs"] == []
            assert cell["execution_count"] is None
            *body, last = ast.parse("".join(cell["source"])).body
            exec(compile(ast.Module(body, []), path.name, "exec"), space)
            if isinstance(last, ast.Expr):
                values.append(eval(compile(ast.Expression(last.value), path.name, "eval"), space))
            else:
                exec(compile(ast.Module([last], []), path.name, "exec"), space)
    return values


@pytest.mark.slow("diagnose")
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_and_shows_something_in_each_cell(
    path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    matplotlib.use("Agg")
    monkeypatch.chdir(path.parent)
    values = executed(path)
    told = capsys.readouterr().out
    shown = [value for value in values if value is not None]
    assert any(isinstance(value, matplotlib.axes.Axes) for value in shown)
    for value in shown:
        rich = value._repr_html_() if hasattr(value, "_repr_html_") else repr(value)
        assert 0 < len(rich) < 30_000
    if path.stem == "calibrate":
        before, after = (float(x) for x in re.findall(r"mean error ([\d.]+) %", told))
        assert after < before / 4
    if path.stem == "diagnose":
        assert "acceleration builds up at" in told
    if path.stem == "time":
        table = next(value for value in values if isinstance(value, pandas.DataFrame))
        assert table["duration_s"].sum() == pytest.approx(3.8, abs=0.1)


def test_there_are_three() -> None:
    assert [path.stem for path in NOTEBOOKS] == ["calibrate", "diagnose", "time"]


@pytest.fixture(scope="module")
def samples(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("examples")
    for name in ("up20", "recordings/tuned", "inform/generations", "krl"):
        shutil.copytree(ROOT / "samples" / name, folder / "samples" / name)
    return folder


@pytest.mark.parametrize("name", [name for name in olp.__all__ if callable(getattr(olp, name))])
def test_examples_of_docstrings_print_what_they_say(
    name: str, monkeypatch: pytest.MonkeyPatch, samples: Path
) -> None:
    monkeypatch.chdir(samples)
    found = doctest.DocTestFinder(recurse=False).find(getattr(olp, name), name, globs={})
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    examples = sum(len(test.examples) for test in found)
    told: list[str] = []
    for test in found:
        runner.run(test, out=told.append)
    assert not runner.failures, "".join(told)
    assert examples or name in ("Diagnostic", "OlpError", "Plan", "Program", "Robot", "robot_names"), (
        "no example"
    )
