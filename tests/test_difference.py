"""`olp diff`: which lines take another time, why, and that the parts are the whole."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from guard_cells import CELL, cell
from hypothesis import given, settings
from hypothesis import strategies as st
from interpreter_jobs import job_text, write_jobs

from olp.__main__ import main
from olp.checks.difference.compare import Cause, ProgramDifference
from olp.checks.difference.versions import open_versions
from olp.reports.batch import Job, plan_and_time

SAMPLES = Path(__file__).parent.parent / "samples" / "inform"
BODY = [
    "MOVL C00000 V=100.0 PL=0",
    "MOVL C00001 V=200.0 PL=1",
    "MOVL C00002 V=150.0 PL=2",
    "TIMER T=0.40",
    "MOVL C00003 V=120.0 PL=0",
    "MOVL C00004 V=90.0 PL=3",
    "DOUT OT#(3) ON",
    "MOVL C00005 V=210.0 PL=0",
    "MOVL C00007 V=310.0",
    "MOVL C00009 V=80.0 PL=0",
]


def difference(
    folder: Path, old: str, new: str, before: str = "", after: str = "", **options
) -> ProgramDifference:
    """Of two versions of a job; `before` and `after` are their olp.toml."""
    for name, body, toml in (("old", old, before), ("new", new, after)):
        (folder / name).mkdir(exist_ok=True)
        (folder / name / "olp.toml").write_text(toml)
        text = job_text(body, name="PART", **options)
        (folder / name / "PART.JBI").write_bytes(text.encode("cp1252"))
    return compare(folder / "old" / "PART.JBI", folder / "new" / "PART.JBI")


def compare(old: Path, new: Path) -> ProgramDifference:
    with open_versions(str(old), str(new)) as versions:
        (pair,) = versions.pairs
        return versions.compare(pair, Job())


def own(found: ProgramDifference) -> list[tuple[Cause, str]]:
    """Causes and statements, without those that only have a changed neighbour."""
    return [(c.cause, c.statement) for c in found.changes if c.cause is not Cause.NEIGHBOUR]


def test_the_same_program_has_no_difference(tmp_path):
    found = difference(tmp_path, "\n".join(BODY), "\n".join(BODY))
    assert found.changes == ()
    assert found.change_s == 0.0


EDITS = {
    Cause.SPEED: (4, "MOVL C00003 V=60.0 PL=0"),
    Cause.STOP: (2, "MOVL C00002 V=150.0 PL=0"),
    Cause.NO_STOP: (7, "MOVL C00005 V=210.0 PL=2"),
    Cause.BLEND: (1, "MOVL C00001 V=200.0 PL=3"),
    Cause.WAIT: (3, "TIMER T=0.90"),
    Cause.ACCELERATION: (4, "MOVL C00003 V=120.0 PL=0 ACC=30 DEC=30"),
    Cause.POINT: (9, "MOVL C00010 V=80.0 PL=0"),
    Cause.SIGNAL: (6, "DOUT OT#(4) ON"),
    Cause.REMOVED: (5, None),
    Cause.ADDED: (5, "MOVL C00004 V=90.0 PL=3\nMOVL C00011 V=77.0 PL=0"),
    Cause.PATH: (9, "MOVJ C00009 VJ=20.00 PL=0"),
}


@pytest.mark.parametrize("cause", EDITS, ids=str)
def test_one_edit_is_one_named_change(tmp_path, cause):
    row, text = EDITS[cause]
    new = [*BODY[:row], *([text] if text else []), *BODY[row + 1 :]]
    found = difference(tmp_path, "\n".join(BODY), "\n".join(new))
    assert [named for named, _ in own(found)] == [cause]
    assert sum(c.change_s for c in found.changes) == pytest.approx(found.change_s, abs=1e-6)


def test_a_wait_that_comes_between_does_not_shift_what_follows(tmp_path):
    new = [*BODY[:4], "TIMER T=2.00", *BODY[4:]]
    found = difference(tmp_path, "\n".join(BODY), "\n".join(new))
    assert own(found) == [(Cause.ADDED, "TIMER T=2.00")]
    assert all(c.new_line == c.old_line + 1 for c in found.changes if c.old_line > 30)


lines = st.builds(
    "MOVL C{:05d} V={}.0 {}".format,
    st.integers(0, 11),
    st.integers(20, 400),
    st.sampled_from(["PL=0", "PL=1", "PL=3", ""]),
) | st.builds("TIMER T=0.{:02d}".format, st.integers(1, 99))
bodies = st.lists(lines, min_size=1, max_size=14)


@pytest.mark.slow
@given(data=st.data(), old=bodies)
@settings(max_examples=60, deadline=None)
def test_the_parts_add_up_to_the_whole_whatever_was_edited(tmp_path_factory, data, old):
    folder = tmp_path_factory.getbasetemp() / "parts"
    folder.mkdir(exist_ok=True)
    new = list(old)
    for _ in range(data.draw(st.integers(1, 6))):
        row = data.draw(st.integers(0, len(new)))
        stop = data.draw(st.integers(row, min(row + 3, len(new))))
        new[row:stop] = data.draw(st.lists(lines, max_size=3))
    found = difference(folder, "\n".join(old), "\n".join(new))
    before, after = (plan_and_time(str(folder / n / "PART.JBI"), Job()).total_s for n in ("old", "new"))
    assert found.old_s == pytest.approx(before, abs=1e-9)
    assert found.new_s == pytest.approx(after, abs=1e-9)
    assert sum(c.change_s for c in found.changes) == pytest.approx(after - before, abs=1e-3)


@given(old=bodies, new=bodies)
@settings(max_examples=30, deadline=None)
def test_back_again_is_the_opposite(tmp_path_factory, old, new):
    folder = tmp_path_factory.getbasetemp() / "back"
    folder.mkdir(exist_ok=True)
    there = difference(folder, "\n".join(old), "\n".join(new))
    back = difference(folder, "\n".join(new), "\n".join(old))
    assert there.change_s == pytest.approx(-back.change_s, abs=1e-9)


def test_how_far_a_point_moved_is_said_in_millimetres_and_degrees(tmp_path):
    for name in ("old", "new"):
        (tmp_path / name).mkdir()
        text = job_text("\n".join(BODY), name="PART")
        if name == "new":
            row = next(line for line in text.split("\r\n") if line.startswith("C00003="))
            x, y, z, rx, ry, rz = map(float, row.partition("=")[2].split(","))
            moved = f"C00003={x + 3:.3f},{y - 4:.3f},{z + 12:.3f},{rx:.4f},{ry:.4f},{rz + 10:.4f}"
            text = text.replace(row, moved)
        (tmp_path / name / "PART.JBI").write_bytes(text.encode())
    found = compare(tmp_path / "old" / "PART.JBI", tmp_path / "new" / "PART.JBI")
    (change,) = (c for c in found.changes if c.cause is Cause.POINT)
    assert change.statement == BODY[4]
    assert change.moved_mm == pytest.approx(13.0, abs=1e-3)
    assert change.turned_deg == pytest.approx(10.0, abs=1e-3)


def test_a_changed_line_in_a_called_job_is_found_there_with_all_its_executions(tmp_path):
    for name in ("old", "new"):
        jobs = dict(CELL)
        if name == "new":
            jobs["GRIP"] = jobs["GRIP"].replace("T=0.25", "T=0.50")
        cell(tmp_path / name, jobs=jobs)
    found = compare(tmp_path / "old" / "MAIN.JBI", tmp_path / "new" / "MAIN.JBI")
    (change,) = found.changes
    assert (change.cause, change.routine, change.file) == (Cause.WAIT, "GRIP", "GRIP.JBI")
    assert change.change_s == pytest.approx(0.5)


def test_a_call_more_is_a_line_that_runs_more_often(tmp_path):
    for name in ("old", "new"):
        jobs = dict(CELL)
        if name == "new":
            jobs["MAIN"] = jobs["MAIN"].replace("CALL JOB:GRIP", "CALL JOB:GRIP\nCALL JOB:GRIP", 1)
        cell(tmp_path / name, jobs=jobs)
    found = compare(tmp_path / "old" / "MAIN.JBI", tmp_path / "new" / "MAIN.JBI")
    assert {c.cause for c in found.changes if c.statement == "TIMER T=0.25"} == {Cause.COUNT}
    assert sum(c.change_s for c in found.changes) == pytest.approx(found.change_s, abs=1e-6)


def test_another_robot_or_other_settings_are_named_when_the_lines_are_the_same(tmp_path):
    body = "\n".join(BODY)
    found = difference(tmp_path, body, body, "", "[motion]\naccel_mm_s2 = 900\n")
    assert {cause for cause, _ in own(found)} == {Cause.SETTINGS}
    text = (SAMPLES / "generations" / "dx200.jbi").read_bytes()
    for name, robot in (("one", "ma2010"), ("two", "gp25")):
        shutil.copytree(SAMPLES / "generations", tmp_path / name)
        (tmp_path / name / "olp.toml").write_text(f'robot = "yaskawa/{robot}"\n')
        assert (tmp_path / name / "dx200.jbi").read_bytes() == text
    found = compare(tmp_path / "one" / "dx200.jbi", tmp_path / "two" / "dx200.jbi")
    assert Cause.ROBOT in {cause for cause, _ in own(found)}
    assert sum(c.change_s for c in found.changes) == pytest.approx(found.change_s, abs=1e-6)


def test_another_tool_or_frame_of_a_point_is_named(tmp_path):
    tools = "[tools]\n1 = [12.4, -7.1, 310.2, 3.1, -41.2, 7.4]\n2 = [31.0, 9.3, 262.7, -8.2, -33.1, 20.9]\n"
    for name in ("old", "new"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "olp.toml").write_text(tools)
        text = job_text("\n".join(BODY), name="PART").replace("///TOOL 0", "///TOOL 1")
        if name == "new":
            text = text.replace("C00005=", "///TOOL 2\r\nC00005=").replace("C00006=", "///TOOL 1\r\nC00006=")
        (tmp_path / name / "PART.JBI").write_bytes(text.encode())
    found = compare(tmp_path / "old" / "PART.JBI", tmp_path / "new" / "PART.JBI")
    assert [(cause, text) for cause, text in own(found) if cause is Cause.TOOL] == [(Cause.TOOL, BODY[7])]


@pytest.mark.parametrize("form", ["text", "json", "junit", "sarif", "github", "gitlab", "markdown"])
def test_every_format_tells_the_change(tmp_path, capsys, form):
    difference(tmp_path, "\n".join(BODY), "\n".join([*BODY[:3], "TIMER T=0.90", *BODY[4:]]))
    assert main(["diff", str(tmp_path / "old"), str(tmp_path / "new"), "--format", form]) == 0
    assert "0.5" in capsys.readouterr().out


def test_json_has_every_row_and_text_only_the_largest(tmp_path, capsys):
    body = [f"MOVL C{n % 12:05d} V=100.0 PL=0" for n in range(30)]
    difference(tmp_path, "\n".join(body), "\n".join(body).replace("V=100.0", "V=120.0"))
    folders = [str(tmp_path / "old"), str(tmp_path / "new")]
    assert main(["diff", *folders, "--format", "json"]) == 0
    whole = json.loads(capsys.readouterr().out)
    (program,) = whole["programs"]
    assert len(program["changes"]) >= 28
    assert sum(c["change_s"] for c in program["changes"]) == pytest.approx(program["change_s"], abs=1e-6)
    assert main(["diff", *folders]) == 0
    assert capsys.readouterr().out.count("U010") == 12
    assert main(["diff", *folders, "--all"]) == 0
    assert capsys.readouterr().out.count("U010") >= 28


def test_the_new_total_comes_with_its_interval(tmp_path, capsys):
    difference(tmp_path, "\n".join(BODY), "\n".join([*BODY, "TIMER T=0.50"]))
    folders = [str(tmp_path / "old"), str(tmp_path / "new")]
    assert main(["diff", *folders, "--format", "json"]) == 0
    (program,) = json.loads(capsys.readouterr().out)["programs"]
    timing = plan_and_time(str(next((tmp_path / "new").iterdir())), Job())
    assert program["new_interval_s"] == pytest.approx(timing.total_ends)
    assert program["new_interval_s"][0] < program["new_s"] < program["new_interval_s"][1]
    assert program["old_interval_s"][1] < program["new_interval_s"][1]
    assert main(["diff", *folders]) == 0
    assert ", 95 %: {:.3f} to {:.3f} s".format(*timing.total_ends) in capsys.readouterr().out


def test_more_seconds_than_allowed_fail(tmp_path, capsys):
    difference(tmp_path, "\n".join(BODY), "\n".join([*BODY, "TIMER T=0.50"]))
    folders = [str(tmp_path / "old"), str(tmp_path / "new")]
    assert main(["diff", *folders, "--allow", "0.6"]) == 0
    assert main(["diff", *folders, "--allow", "0.4"]) == 1
    assert "U011" in capsys.readouterr().out


def test_a_budget_that_the_new_version_breaks_is_told(tmp_path, capsys):
    budget = "[[budget]]\nname = 'promise'\nlimit_s = 9\n"
    difference(tmp_path, "\n".join(BODY), "\n".join([*BODY, "TIMER T=9.00"]), budget, budget)
    assert main(["diff", str(tmp_path / "old"), str(tmp_path / "new")]) == 1
    assert re.search(r"failed +promise", capsys.readouterr().out)


def test_a_program_that_is_new_or_gone_is_told(tmp_path, capsys):
    for name, other in (("old", "B"), ("new", "C")):
        (tmp_path / name).mkdir()
        write_jobs(tmp_path / name, {"A": "TIMER T=1.00", other: "TIMER T=2.00"})
    assert main(["diff", str(tmp_path / "old"), str(tmp_path / "new")]) == 0
    told = capsys.readouterr().out
    assert "new program" in told
    assert "program gone" in told
    assert "A.JBI" not in told


def test_a_version_that_cannot_be_read_is_no_success(tmp_path, capsys):
    write_jobs(tmp_path, {"A": "TIMER T=1.00"})
    assert main(["diff", str(tmp_path / "A.JBI"), str(SAMPLES / "broken" / "binary.jbi")]) == 2
    assert "unknown" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["cell", "cell/MAIN.JBI"], "U003"),
        (["empty", "empty"], "U003"),
        (["no-such", "HEAD"], "U001"),
        (["HEAD", "no-such"], "U001"),
        (["--", "-x", "HEAD"], "U001"),
    ],
)
def test_what_cannot_be_compared_is_told(repository, capsys, monkeypatch, arguments, code):
    (repository / "empty").mkdir()
    monkeypatch.chdir(repository)
    assert main(["diff", *arguments]) == 2
    assert code in capsys.readouterr().err


def git(folder: Path, *words: str) -> str:
    who = ["-c", "user.name=A", "-c", "user.email=a@b.example", "-c", "init.defaultBranch=main"]
    done = subprocess.run(["git", *who, *words], cwd=folder, check=True, capture_output=True, text=True)
    return done.stdout


@pytest.fixture
def repository(tmp_path) -> Path:
    """Two commits of a cell in a folder, with the settings above it."""
    root = tmp_path / "repository"
    cell(root / "cell", jobs=CELL | {"OTHER": "TIMER T=1.00"})
    (root / "cell" / "olp.toml").rename(root / "olp.toml")
    (root / "olp.toml").write_text("[motion]\naccel_mm_s2 = 700\n")
    git(root, "init", "-q")
    git(root, "add", "-A")
    git(root, "commit", "-qm", "one")
    grip = root / "cell" / "GRIP.JBI"
    grip.write_bytes(grip.read_bytes().replace(b"T=0.25", b"T=0.50"))
    git(root, "commit", "-qam", "two")
    return root


@pytest.mark.parametrize(
    ("where", "arguments"),
    [
        (".", ["HEAD~1", "HEAD"]),
        (".", ["HEAD~1", "."]),
        (".", ["HEAD~1", "HEAD", "cell"]),
        (".", ["HEAD~1", "HEAD", "cell/MAIN.JBI", "cell/GRIP.JBI"]),
        ("cell", ["HEAD~1", "HEAD"]),
        ("cell", ["HEAD~1", "."]),
        ("cell", ["HEAD~1", "HEAD", "MAIN.JBI", "GRIP.JBI"]),
    ],
)
def test_revisions_are_compared_with_the_settings_above_the_folder(
    repository, capsys, monkeypatch, where, arguments
):
    monkeypatch.chdir(repository / where)
    assert main(["diff", *arguments, "--format", "json"]) == 0
    programs = {Path(p["file"]).stem: p for p in json.loads(capsys.readouterr().out)["programs"]}
    assert programs["MAIN"]["change_s"] == pytest.approx(0.5)
    assert programs["GRIP"]["change_s"] == pytest.approx(0.25)
    real = plan_and_time(str(repository / "cell" / "MAIN.JBI"), Job()).total_s
    assert programs["MAIN"]["new_s"] == pytest.approx(real, abs=1e-9)
    assert [c["cause"] for c in programs["MAIN"]["changes"]] == ["wait"]


def test_a_file_that_a_revision_does_not_have_is_new(repository, capsys, monkeypatch):
    write_jobs(repository / "cell", {"FRESH": "TIMER T=1.00"})
    monkeypatch.chdir(repository)
    assert main(["diff", "HEAD", ".", "cell/FRESH.JBI"]) == 0
    assert "new program" in capsys.readouterr().out


def test_nothing_is_left_behind_and_the_repository_is_untouched(repository, monkeypatch, tmp_path):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    monkeypatch.chdir(repository)
    assert main(["diff", "HEAD~1", "HEAD", "-o", str(tmp_path / "out.txt")]) == 0
    assert list((tmp_path / "temporary").iterdir()) == []
    assert git(repository, "status", "--porcelain") == ""


def test_git_difftool_shows_the_difference_and_finds_called_jobs(repository):
    import sys

    root = Path(__file__).parent.parent
    main_job = repository / "cell" / "MAIN.JBI"
    main_job.write_bytes(main_job.read_bytes().replace(b"T=0.70", b"T=0.90"))
    command = f"env PYTHONPATH={root} {sys.executable} -m olp diff"
    told = git(repository, "difftool", "-y", "--extcmd", command, "HEAD", "--", "*.JBI")
    assert "+0.200 s, wait (0.700 → 0.900 s): TIMER T=0.90" in told
    write_jobs(repository / "cell", {"FRESH": "TIMER T=1.00"})
    git(repository, "add", "-A")
    told = git(repository, "difftool", "-y", "--extcmd", command, "--cached", "HEAD", "--", "cell/FRESH.JBI")
    assert "new program" in told


def test_samples_differ_from_themselves_in_nothing(tmp_path):
    for name in ("palletising/MAIN.JBI", "cam/FINISH.JBI", "welding/WELD-MAIN.JBI", "generations/dx200.jbi"):
        found = compare(SAMPLES / name, SAMPLES / name)
        assert found.changes == ()
        assert found.change_s == 0


def test_a_copy_under_another_name_is_the_same_program(tmp_path):
    write_jobs(tmp_path, {"PART": "\n".join(BODY), "PART-2": "\n".join(BODY).replace("T=0.40", "T=0.60")})
    found = compare(tmp_path / "PART.JBI", tmp_path / "PART-2.JBI")
    assert own(found) == [(Cause.WAIT, "TIMER T=0.60")]


def test_the_same_motion_written_in_another_frame_takes_no_other_time():
    for name in ("angle", "pulse", "user"):
        found = compare(SAMPLES / "twins" / "base.jbi", SAMPLES / "twins" / f"{name}.jbi")
        assert found.change_s == pytest.approx(0.0, abs=2e-3)
        assert all(c.old_line and c.new_line for c in found.changes)
