"""`olp init`: what it writes is read, timed and held without a word."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

import olp
from olp.__main__ import main
from olp.checks.guard.budget import Budget, budgets_for
from olp.runtime.assumptions import read_assumptions
from olp.runtime.folder import models_in

SAMPLES = Path(__file__).parent.parent / "samples"


def budgets(program: Path) -> list[Budget]:
    found = budgets_for(str(program))
    assert not [d for one in found for d in one.diagnostics]
    return [budget for one in found for budget in one.budgets]


@pytest.fixture
def cell(tmp_path: Path) -> Path:
    folder = tmp_path / "cell"
    shutil.copytree(SAMPLES / "inform" / "handling", folder)
    (folder / "olp.toml").unlink()
    return folder


def test_the_file_holds_the_arm_and_a_budget_that_today_holds(
    cell: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["init", str(cell), "--robot", "yaskawa/gp25"]) == 0
    assert "that a controller starts, 1 with a budget" in capsys.readouterr().out
    text = (cell / "olp.toml").read_text("utf-8")
    given = read_assumptions(cell / "olp.toml")
    assert given.diagnostics == ()
    assert given.robot == "yaskawa/gp25"
    # DROP is called: it has no budget of its own. What was assumed stands there as a comment.
    assert text.count("[[budget]]") == 1
    assert "#   line 51: the wait for IN#(7) lasts 0 s" in text
    total = olp.read(cell / "HANDLING.JBI").plan().time()["duration_s"].sum()
    (budget,) = budgets(cell / "HANDLING.JBI")
    assert total < budget.limit_s < 1.1 * total
    assert main(["check", str(cell), "--no-cache"]) == 0
    out = capsys.readouterr().out
    assert "held    HANDLING" in out
    assert "0 unknown" not in out


def test_without_an_arm_it_asks_for_one_and_writes_what_is_read(
    cell: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["init", str(cell)]) == 0
    out = capsys.readouterr().out
    assert "2 programs, 1 that a controller starts, 0 with a budget" in out
    assert "name the arm in it" in out
    assert read_assumptions(cell / "olp.toml").diagnostics == ()
    assert '# robot = "' in (cell / "olp.toml").read_text("utf-8")


def named(cell: Path, capsys: pytest.CaptureFixture[str]) -> tuple[str, str]:
    """The arm that olp init wrote, and what it said of it."""
    (cell / "olp.toml").unlink(missing_ok=True)
    assert main(["init", str(cell)]) == 0
    return read_assumptions(cell / "olp.toml").robot, capsys.readouterr().out


def test_the_arm_is_found_in_a_head_a_backup_or_a_robot_file(
    cell: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = cell / "HANDLING.JBI"
    text = job.read_bytes()
    job.write_bytes(text.replace(b"\r\nNOP\r\n", b"\r\nNOP\r\n'cell 4, Motoman GP 25, gripper G180\r\n"))
    robot, out = named(cell, capsys)
    assert robot == "yaskawa/gp25"
    assert "arm: yaskawa/gp25, by the comment in " in out
    assert main(["check", str(cell), "--no-cache"]) == 0
    # The arm's own controller knows better than a comment.
    system = (SAMPLES / "backup" / "dx200" / "SYSTEM.SYS").read_bytes().replace(b"OX01840", b"MA02010")
    (cell / "SYSTEM.SYS").write_bytes(system)
    robot, out = named(cell, capsys)
    assert robot == "yaskawa/ma2010"
    assert "by the backup in" in out
    arm = Path(olp.__file__).parent / "robots" / "yaskawa" / "gp7.toml"
    shutil.copy(arm, cell / "our-arm.toml")
    assert named(cell, capsys)[0] == "our-arm.toml"
    shutil.copy(Path(olp.__file__).parent / "robots" / "yaskawa" / "gp8.toml", cell / "other.toml")
    robot, out = named(cell, capsys)
    assert robot == ""
    assert "our-arm.toml, by the robot file of yaskawa/gp7?" in out


def test_an_arm_that_somebody_named_is_kept(cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (cell / "olp.toml").write_text('robot = "yaskawa/gp25"\n')
    assert main(["init", str(cell), "--force"]) == 0
    assert "by the olp.toml that was replaced" in capsys.readouterr().out
    assert read_assumptions(cell / "olp.toml").robot == "yaskawa/gp25"


@pytest.mark.parametrize(
    ("said", "names"),
    [
        ("for KR 3 R540, tool 2", ["kuka/kr3-r540"]),
        ("FANUC LR Mate 200iD/7L", ["fanuc/lr-mate-200id-7l"]),
        ("station gp250 GP25-12", []),
        ("ur5e ends", ["universal-robots/ur5e"]),
        ("25 mm", []),
    ],
)
def test_models_are_found_as_words(said: str, names: list[str]) -> None:
    assert models_in(said) == names


def test_nothing_is_replaced_unasked(cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (cell / "olp.toml").write_text("# mine\n")
    assert main(["init", str(cell)]) == 2
    assert "error[C009]" in capsys.readouterr().err
    assert (cell / "olp.toml").read_text() == "# mine\n"
    assert main(["init", str(cell), "--force"]) == 0
    assert (cell / "olp.toml").read_text() != "# mine\n"


def test_a_folder_that_is_none_and_one_without_programs_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["init", str(tmp_path / "gone")]) == 2
    assert "no such folder" in capsys.readouterr().err
    (tmp_path / "a.jbi").write_text("/JOB\n")
    assert main(["init", str(tmp_path / "a.jbi")]) == 2
    assert "this is a file" in capsys.readouterr().err
    (tmp_path / "empty").mkdir()
    assert main(["init", str(tmp_path / "empty")]) == 2
    assert not (tmp_path / "empty" / "olp.toml").exists()


def test_programs_of_one_name_in_several_folders_have_a_budget_each(tmp_path: Path) -> None:
    for place in ("a", "b"):
        shutil.copytree(SAMPLES / "inform" / "handling", tmp_path / place)
        (tmp_path / place / "olp.toml").unlink()
    assert main(["init", str(tmp_path), "--robot", "yaskawa/gp25"]) == 0
    assert {b.name for b in budgets(tmp_path / "a" / "HANDLING.JBI")} == {"a/HANDLING.JBI", "b/HANDLING.JBI"}
