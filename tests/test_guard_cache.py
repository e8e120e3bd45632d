"""The cache of `olp check`: what did not change is not timed again, and whatever decides a time makes it anew."""

from __future__ import annotations

import copy
import json
import shutil
import sqlite3
import subprocess
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from guard_cells import CELL, cell, check
from interpreter_jobs import job_text

from olp.__main__ import main
from olp.reports.outcome.model import Status

SAMPLES = Path(__file__).parent.parent / "samples"
BUDGET = "\n[[budget]]\nname = 'b'\njob = 'MAIN'\nlimit_s = 1000\n"


@pytest.fixture
def pallet(tmp_path) -> Path:
    """A cell with everything that times depend on: jobs, tools, frames, variables, settings, a robot file elsewhere."""
    home = tmp_path / "cell"
    shutil.copytree(SAMPLES / "inform" / "palletising", home)
    (tmp_path / "robots").mkdir()
    library = Path(__file__).parent.parent / "olp" / "robots" / "yaskawa" / "ar2010.toml"
    shutil.copy(library, tmp_path / "robots" / "own.toml")
    settings = (home / "olp.toml").read_text().replace('"yaskawa/ar2010"', '"../robots/own.toml"')
    (home / "olp.toml").write_text(settings + BUDGET)
    return home


def replace(path: Path, old: str, new: str) -> None:
    raw = path.read_bytes()
    assert old.encode() in raw, path
    path.write_bytes(raw.replace(old.encode(), new.encode(), 1))


def test_an_unchanged_cell_is_not_timed_again_and_says_the_same(pallet, tmp_path, monkeypatch):
    first = check(pallet, monkeypatch, tmp_path / "cache")
    again = check(pallet, monkeypatch, tmp_path / "cache")
    assert len(first.timed) == 5
    assert again.timed == []
    assert again.results == first.results


CHANGES = {
    "the job itself": (lambda p: replace(p / "MAIN.JBI", "T=0.40", "T=0.41"), {"MAIN.JBI"}),
    "a called job": (lambda p: replace(p / "PICK.JBI", "V=120.0", "V=110.0"), {"MAIN.JBI", "PICK.JBI"}),
    "a tool": (lambda p: replace(p / "TOOL.CND", ".", "1."), {"MAIN.JBI", "PICK.JBI", "PLACE.JBI"}),
    "a frame": (lambda p: replace(p / "UFRAME.CND", ".", "1."), {"MAIN.JBI", "PLACE.JBI"}),
    "a variable": (
        lambda p: (p / "VAR.DAT").write_bytes((p / "VAR.DAT").read_bytes() + b"\r\n"),
        {"MAIN.JBI"},
    ),
    "the settings": (lambda p: replace(p / "olp.toml", "= 1.2 ", "= 2.2 "), {"MAIN.JBI"}),
    "a budget": (lambda p: replace(p / "olp.toml", "limit_s = 1000", "limit_s = 1001"), {"MAIN.JBI"}),
    "the robot's file": (
        lambda p: replace(p.parent / "robots" / "own.toml", "[", "# changed\n["),
        {"MAIN.JBI", "PICK.JBI", "PLACE.JBI"},
    ),
}


@pytest.mark.parametrize("what", CHANGES)
def test_whatever_decides_a_time_makes_it_anew(pallet, tmp_path, monkeypatch, what):
    change, concerned = CHANGES[what]
    check(pallet, monkeypatch, tmp_path / "cache")
    change(pallet)
    found = check(pallet, monkeypatch, tmp_path / "cache")
    assert concerned <= set(found.timed)
    assert found.results == check(pallet, monkeypatch).results


def test_only_what_depends_on_a_change_is_timed_again(pallet, tmp_path, monkeypatch):
    check(pallet, monkeypatch, tmp_path / "cache")
    replace(pallet / "PICK.JBI", "V=120.0", "V=110.0")
    assert sorted(check(pallet, monkeypatch, tmp_path / "cache").timed) == ["MAIN.JBI", "PICK.JBI"]


def test_a_called_job_that_appears_is_found(tmp_path, monkeypatch):
    home = tmp_path / "cell"
    cell(home, BUDGET, {"MAIN": CELL["MAIN"]})
    assert check(home, monkeypatch, tmp_path / "cache").items == {"b": "unknown"}
    assert check(home, monkeypatch, tmp_path / "cache").timed == []
    cell(home, BUDGET)
    assert check(home, monkeypatch, tmp_path / "cache").items == {"b": "held"}


def test_a_called_job_that_goes_away_is_missed(tmp_path, monkeypatch):
    home = tmp_path / "cell"
    cell(home, BUDGET)
    assert check(home, monkeypatch, tmp_path / "cache").items == {"b": "held"}
    (home / "GRIP.JBI").unlink()
    assert check(home, monkeypatch, tmp_path / "cache").items == {"b": "unknown"}


def test_a_file_that_takes_the_place_of_a_called_job_is_seen(tmp_path, monkeypatch):
    home = tmp_path / "cell"
    cell(home, BUDGET)
    (home / "GRIP.JBI").rename(home / "OTHER.JBI")  # its head still says GRIP
    assert check(home, monkeypatch, tmp_path / "cache").items == {"b": "held"}
    (home / "GRIP.JBI").write_bytes(job_text("TIMER T=9.00", name="GRIP").encode())
    found = check(home, monkeypatch, tmp_path / "cache")
    assert "MAIN.JBI" in found.timed
    assert found.results == check(home, monkeypatch).results


def test_an_olp_toml_that_appears_above_is_seen(tmp_path, monkeypatch):
    home = tmp_path / "a" / "cell"
    cell(home, BUDGET)
    (home / "olp.toml").rename(tmp_path / "a" / "olp.toml")
    assert len(check(home, monkeypatch, tmp_path / "cache").timed) == 2
    (home / "olp.toml").write_text("[motion]\noverride_pct = 50\n" + BUDGET)
    assert len(check(home, monkeypatch, tmp_path / "cache").timed) == 2


@pytest.mark.parametrize(
    "setting", [{"override": 0.5}, {"model": "linear"}, {"robot": "yaskawa/gp25"}, {"cycles": 2}]
)
def test_other_settings_are_other_results(tmp_path, monkeypatch, setting):
    home = tmp_path / "cell"
    cell(home, BUDGET)
    check(home, monkeypatch, tmp_path / "cache")
    assert len(check(home, monkeypatch, tmp_path / "cache", **setting).timed) == 2


def test_a_signature_with_other_content_is_another_setting(tmp_path, monkeypatch):
    from olp.identification.recording import read_recording
    from olp.identification.signature import calibrate, write_signature

    home, file = tmp_path / "cell", tmp_path / "robot.json"
    shutil.copytree(SAMPLES / "up20", home)
    signature = calibrate(read_recording(SAMPLES / "up20"), "factors")[0]
    write_signature(signature, file)
    count = len(check(home, monkeypatch, tmp_path / "cache", signature=str(file)).timed)
    assert check(home, monkeypatch, tmp_path / "cache", signature=str(file)).timed == []
    file.write_text(file.read_text() + "\n")
    assert len(check(home, monkeypatch, tmp_path / "cache", signature=str(file)).timed) == count


def test_a_cache_goes_along_to_another_folder(tmp_path, monkeypatch):
    (tmp_path / "one").mkdir()
    cell(tmp_path / "one" / "cell", BUDGET)
    monkeypatch.chdir(tmp_path / "one")
    assert len(check(Path("cell"), monkeypatch, Path("cache")).timed) == 2
    shutil.copytree(tmp_path / "one", tmp_path / "two")
    monkeypatch.chdir(tmp_path / "two")
    assert check(Path("cell"), monkeypatch, Path("cache")).timed == []


def test_a_cache_that_cannot_be_used_is_done_without(tmp_path, monkeypatch):
    home = tmp_path / "cell"
    cell(home, BUDGET)
    nowhere = tmp_path / "no" / "folder" / "cache"
    assert len(check(home, monkeypatch, nowhere).timed) == 2
    assert len(check(home, monkeypatch, nowhere).timed) == 2


def test_a_damaged_row_is_timed_again(tmp_path, monkeypatch):
    import sqlite3
    from contextlib import closing

    home, cache = tmp_path / "cell", tmp_path / "cache"
    cell(home, BUDGET)
    first = check(home, monkeypatch, cache)
    with closing(sqlite3.connect(cache)) as store:
        store.execute("update result set value = '{\"items\": 3}'")
        store.commit()
    found = check(home, monkeypatch, cache)
    assert len(found.timed) == 2
    assert found.results == first.results


def test_many_programs_on_several_processes_give_the_same_as_one_after_the_other(tmp_path, monkeypatch):
    from olp.checks.guard.run import GuardSettings, run, tasks
    from olp.reports.batch import Job

    home = tmp_path / "cell"
    cell(
        home,
        BUDGET,
        {f"J{n:03d}": f"MOVL C00000 V=100.0\nMOVL C000{n % 10 + 1:02d} V=150.0" for n in range(60)},
    )
    paths = [str(path) for path in sorted(home.glob("*.JBI"))]
    seen: list[int] = []
    many = run(tasks(paths).tasks, GuardSettings(Job(), 2, None), seen.append)
    assert many == run(tasks(paths).tasks, GuardSettings(Job(), 1, None))
    assert [result.path for result in many] == paths
    assert sum(seen) == 60


def stored(cache: Path, change: Callable[[dict[str, Any]], None]) -> None:
    """Writes other results into a cache, with the key that belongs to them."""
    with closing(sqlite3.connect(cache)) as store:
        for name, value in store.execute("select path, value from result").fetchall():
            result = json.loads(value)
            change(result)
            store.execute("update result set value = ? where path = ?", (json.dumps(result), name))
        store.commit()


FORGERIES = {
    "a status": lambda r: [item.update(status="held") for item in r["items"]],
    "a status and words": lambda r: [item.update(status="held", message="all well") for item in r["items"]],
    "no items": lambda r: r.update(items=[item for item in r["items"] if item["name"] == "PICK"]),
    "another limit": lambda r: [item.update(status="held", limit_s=9e9) for item in r["items"]],
    "no seconds": lambda r: [item.update(status="held", seconds=None) for item in r["items"]],
    "text for a number": lambda r: [item.update(seconds="1") for item in r["items"]],
    "not a number": lambda r: [item.update(seconds=float("nan")) for item in r["items"]],
    "an item that is none": lambda r: r.update(items=[7]),
    "fields that nobody knows": lambda r: r.update(evil=1),
    "nothing read": lambda r: r.update(read=[]),
    "text that is read": lambda r: r.update(read="MAIN.JBI"),
    "a NUL in a name": lambda r: r["read"].append("a\0b"),
    "half a character in a name": lambda r: r["read"].append("\ud800"),
    "more files than there are": lambda r: r["read"].extend(["/"] * 20_000),
}


@pytest.mark.parametrize("forgery", FORGERIES)
def test_a_verdict_that_somebody_wrote_into_the_cache_is_not_believed(forgery, pallet, tmp_path, monkeypatch):
    replace(pallet / "olp.toml", "limit_s = 1000", "limit_s = 1")
    first = check(pallet, monkeypatch, tmp_path / "cache")
    stored(tmp_path / "cache", FORGERIES[forgery])
    again = check(pallet, monkeypatch, tmp_path / "cache")
    assert again.results == first.results
    assert any(item.status is Status.FAILED for result in again.results for item in result.items)


@pytest.mark.parametrize("part", ["routine = 'GRIP'", "from = '*START'\nto = 'FINISH'"])
def test_a_budget_of_a_part_that_is_left_out_of_the_cache_is_judged_anew(part, tmp_path, monkeypatch):
    home, cache = tmp_path / "cell", tmp_path / "cache"
    cell(home, f"[[budget]]\nname = 'b'\n{part}\nlimit_s = 0.01\n")
    first = check(home, monkeypatch, cache)
    stored(cache, lambda r: r.update(items=[], findings=[]))
    again = check(home, monkeypatch, cache)
    assert first.items == again.items == {"b": "failed"}
    # What no file names is not looked for again.
    cell(home, "[[budget]]\nname = 'b'\nroutine = 'GRI'\nlimit_s = 0.01\n")
    check(home, monkeypatch, cache)
    assert check(home, monkeypatch, cache).timed == []


ODD = (None, True, -1, 1.5, 10**400, 1e300, "", "\ud800", "\0", [], {}, [[]], {"a": 1}, "x" * 100_000)


def places(value: Any, way: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The way to every value in a document."""
    yield way
    if isinstance(value, (dict, list)):
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
            yield from places(inner, (*way, key))


def test_no_odd_value_anywhere_in_a_row_ends_a_run_or_turns_a_budget(tmp_path, monkeypatch):
    from olp.checks.guard.run import Cache, tasks
    from olp.cli.check import outcome_of
    from olp.reports.batch import Job
    from olp.reports.outcome import format_names, load_format

    home, file = tmp_path / "cell", tmp_path / "cache"
    cell(home, "[[budget]]\nname = 'b'\nlimit_s = 0.1\n\n[[budget]]\nroutine = 'GRIP'\nlimit_s = 100\n")
    check(home, monkeypatch, file)
    cache = Cache.open(file, Job())
    (task,) = tasks([str(home / "MAIN.JBI")]).tasks
    true = cache.find(*task)
    assert true is not None
    ((name, (key, text)),) = [row for row in cache._known.items() if "MAIN" in row[0]]
    row = json.loads(text)
    for *way, last in list(places(row))[1:]:
        for odd in ODD:
            forged = copy.deepcopy(row)
            inner = forged
            for step in way:
                inner = inner[step]
            inner[last] = odd
            cache._known[name] = (key, json.dumps(forged))
            found = cache.find(*task)
            if found is None:
                continue
            assert [(i.name, i.status) for i in found.items] == [(i.name, i.status) for i in true.items]
            for form in format_names():
                load_format(form).render(outcome_of([found])).encode("utf-8", "backslashreplace")


ROWS = {
    "deep": "[" * 100_000,
    "a list": "[]",
    "null": "null",
    "no json": "{",
    "huge": '"' + "x" * 9_000_000 + '"',
    "bytes": b"\xff\x00",
    "a number": 7,
}


@pytest.mark.parametrize("row", ROWS)
def test_rows_that_cannot_be_are_as_if_they_were_not_there(row, pallet, tmp_path, monkeypatch):
    first = check(pallet, monkeypatch, tmp_path / "cache")
    with closing(sqlite3.connect(tmp_path / "cache")) as store:
        store.execute("update result set value = ?", (ROWS[row],))
        store.commit()
    again = check(pallet, monkeypatch, tmp_path / "cache")
    assert again.results == first.results
    assert len(again.timed) == len(first.timed)


def test_a_cache_that_a_killed_run_has_begun_is_filled(tmp_path, monkeypatch):
    home, cache = tmp_path / "cell", tmp_path / "cache"
    cell(home, BUDGET)
    with closing(sqlite3.connect(cache)) as store:
        store.execute("pragma user_version = 1")
    assert cache.stat().st_size
    assert len(check(home, monkeypatch, cache).timed) == 2
    assert check(home, monkeypatch, cache).timed == []


@pytest.mark.parametrize("target", ["LINK.JBI", "/dev/zero", "no/where"])
@pytest.mark.parametrize("budget", ['files = ["*.JBI"]', 'routine = "LINK"', 'job = "LINK"'])
def test_a_link_that_is_no_program_is_one_unknown_among_the_others(target, budget, tmp_path, capsys):
    home = tmp_path / "cell"
    cell(home, f"[[budget]]\nlimit_s = 1000\n[[budget]]\n{budget}\nlimit_s = 1000\n")
    (home / "LINK.JBI").symlink_to(target)
    assert main(["check", str(home), "--no-cache", "--store", str(tmp_path / "store")]) == 2
    told = [row.split()[:3] for row in capsys.readouterr().out.splitlines()]
    assert sum(row[0] == "unknown" and row[2].endswith("LINK.JBI") for row in told if len(row) == 3) == 2


def test_a_view_without_an_end_in_place_of_the_table_does_not_hang(pallet, tmp_path, monkeypatch):
    first = check(pallet, monkeypatch, tmp_path / "cache")
    with closing(sqlite3.connect(tmp_path / "cache")) as store:
        store.execute("drop table result")
        endless = "with recursive n(i) as (select 1 union all select i + 1 from n)"
        store.execute(f"create view result(path, key, value) as {endless} select i, i, i from n")
        store.commit()
    assert check(pallet, monkeypatch, tmp_path / "cache").results == first.results


@pytest.mark.skipif(shutil.which("git") is None, reason="git is not installed")
def test_a_cache_that_git_tracks_is_refused(pallet, monkeypatch, capsys):
    assert main(["check", str(pallet), "--cache", str(pallet / ".olp-cache")]) in (0, 1)
    for words in (["init", "-q"], ["add", "-f", ".olp-cache"]):
        subprocess.run(["git", *words], cwd=pallet, check=True, capture_output=True)
    assert main(["check", str(pallet), "--cache", str(pallet / ".olp-cache")]) == 2
    assert "M008" in capsys.readouterr().err
