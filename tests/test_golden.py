"""The golden run (`bench/golden.py`): the same twice, and a changed output is found."""

from __future__ import annotations

from pathlib import Path

import pytest

from bench import golden


def test_two_runs_are_equal_and_a_changed_output_is_shown(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("old", "new"):
        assert golden.main(["run", name, "--sample", "200", "--only", "export"]) == 0
        monkeypatch.chdir(tmp_path)
    assert golden.main(["compare", "old", "new"]) == 0
    index = tmp_path / "new" / golden.INDEX
    program, operation, _data, problems = index.read_text(encoding="utf-8").splitlines()[0].split("\t")
    changed = golden.keep(tmp_path / "new", b"MOVJ VJ=12.5\n")
    index.write_text("\t".join([program, operation, changed, problems]) + "\n", encoding="utf-8")
    capsys.readouterr()
    assert golden.main(["compare", "old", "new"]) == 1
    shown = capsys.readouterr().out
    assert f"old {program}: {operation}: output" in shown
    assert "+MOVJ VJ=12.5" in shown
    assert "outputs only in old" in shown
    assert "1 outputs compared, 1 differ" in shown
