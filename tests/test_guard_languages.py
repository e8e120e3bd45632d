"""`olp check`, `diff`, `lint`, `report` and `trend` over a program of every language: the same promises for each."""

from __future__ import annotations

import json
import re
import shutil
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from typing import NamedTuple

import pytest

from olp.__main__ import main
from olp.contracts import handling
from olp.contracts.events import events_of
from olp.fluent import read
from olp.ir.program import Call, Label
from olp.languages.vendor import find_vendor, vendor_names

SAMPLES = Path(__file__).parent.parent / "samples"
ROBOT = "yaskawa/gp25"


class Sample(NamedTuple):
    """`pause`: a line that waits 0.35 s, and the same with 3.5 s. `wait`: a line that waits for a signal.

    `label`: how a label is written on a line of its own; None: the language has none. `drop`: the routine that is
    called, in the spelling of the language; `budget`: how a label is written there besides.
    """

    main: str
    pause: tuple[str, str]
    wait: str
    drop: str
    label: str | None = None


LABELS = {"inform": "*{}", "krl": "{}:", "rapid": "{}:", "tp": "LBL[{}]", "as": "{}", "pdl2": "{}::"}


@cache
def sample_of(name: str) -> Sample:
    """The handling sample of a language, whose lines are found by what happens on them."""
    vendor = find_vendor(name)
    main = handling.main_of(vendor, handling.samples_folder(vendor))
    assert main is not None, f"{name} has no handling sample"
    program = read(main, vendor=name)
    events = events_of(program, program.plan(ROBOT), vendor)
    line = {e.kind: program.source.line(e.line).strip() for e in events[::-1] if e.kind in ("wait", "input")}
    short = re.search(r"0?\.35|350", line["wait"])[0]
    pause = line["wait"][: line["wait"].index(short) + len(short)]
    longer = {"350": "3500", "0.35": "3.50", ".35": "3.50"}[short]
    called = {
        one.routine for one in program.statements() if isinstance(one, Call) and one.routine.lower() == "drop"
    }
    return Sample(
        str(main.relative_to(SAMPLES)),
        (pause, pause.replace(short, longer)),
        line["input"],
        called.pop(),
        LABELS.get(name),
    )


NAMES = vendor_names()


@pytest.fixture(params=NAMES)
def name(request) -> str:
    return request.param


@pytest.fixture
def path(name, tmp_path, monkeypatch) -> Path:
    """A copy of the sample's folder, with its main program seen from there."""
    source = SAMPLES / sample_of(name).main
    shutil.copytree(source.parent, tmp_path / "cell")
    monkeypatch.chdir(tmp_path / "cell")
    return Path(source.name)


def lines_of(path: Path) -> list[bytes]:
    return path.read_bytes().split(b"\n")


def line_with(path: Path, text: str) -> int:
    return next(n for n, line in enumerate(lines_of(path), 1) if text.encode() in line)


def told(capsys, *words: str) -> tuple[int, dict]:
    status = main([*words, "--format", "json"])
    return status, json.loads(capsys.readouterr().out)


def check(capsys, path: Path, budgets: str) -> tuple[int, dict]:
    Path("budgets.toml").write_text(budgets, encoding="utf-8")
    return told(capsys, "check", str(path), "--robot", ROBOT, "--no-cache", "--budgets", "budgets.toml")


def seconds(capsys, path: Path) -> tuple[float, list[dict]]:
    assert main(["time", str(path), "--robot", ROBOT, "--format", "json"]) == 0
    (whole,) = json.loads(capsys.readouterr().out)
    return whole["total_s"], whole["segments"]


def test_a_budget_of_the_whole_and_of_its_parts_is_judged_at_a_line(path, capsys):
    total, segments = seconds(capsys, path)
    kinds = "".join(
        f"[[budget]]\nname='{kind}'\nof='{kind}'\nlimit_s=99\n" for kind in ("motion", "wait", "io")
    )
    status, found = check(
        capsys,
        path,
        f"[[budget]]\nname='over'\nlimit_s={total * 0.9}\n[[budget]]\nlimit_s=99\nname='held'\n{kinds}",
    )
    assert status == 1
    items = {item["name"]: item for item in found["items"]}
    assert [item["status"] for item in items.values()].count("failed") == 1
    assert items["over"]["status"] == "failed"
    assert items["over"]["line"] > 0
    assert items["held"]["seconds"] == pytest.approx(total)
    assert sum(items[kind]["seconds"] for kind in ("motion", "wait", "io")) == pytest.approx(total)
    worst = [f for f in found["findings"] if f["code"] == "M011"]
    assert len(worst) == 3
    own = [s for s in segments if s["line"] == worst[0]["line"]]
    assert Path(worst[0]["file"]).name != path.name or sum(s["duration_s"] or 0 for s in own) > 0


def test_a_routine_has_a_budget_wherever_its_file_is(name, path, capsys):
    status, found = check(capsys, path, f"[[budget]]\nroutine='{sample_of(name).drop.upper()}'\nlimit_s=3\n")
    (item,) = found["items"]
    assert (status, item["status"]) == (1, "failed")
    assert 4.0 < item["seconds"] < 5.5  # much the same motion in every language


def test_a_span_between_labels_is_what_runs_between_them(name, path, capsys):
    sample = sample_of(name)
    if sample.label is None:
        assert not any(isinstance(s, Label) for s in read(path).statements())
        status, found = check(capsys, path, "[[budget]]\nfrom='a'\nto='b'\nlimit_s=3\n")
        assert (status, [item["status"] for item in found["items"]]) == (2, ["unknown"])
        return
    at = line_with(path, sample.pause[0]) - 1
    lines = lines_of(path)
    end = b"\r" if lines[at].endswith(b"\r") else b""
    # TP numbers its lines; what numbers these are is nothing to the run.
    marks = [sample.label.format(n).encode() for n in (7701, 7702)]
    if name not in ("tp", "as"):
        marks = [sample.label.format(word).encode() for word in ("begin", "done")]
    rows = [b"   1:  " + mark + b" ;" if name == "tp" else mark for mark in marks]
    lines[at : at + 1] = [rows[0] + end, lines[at], rows[1] + end]
    path.write_bytes(b"\n".join(lines))
    first, last = ("7701", "7702") if name in ("tp", "as") else ("begin", "done")
    for start, stop in ((first, last), (marks[0].decode(), marks[1].decode())):
        status, found = check(capsys, path, f"[[budget]]\nfrom='{start}'\nto='{stop}'\nlimit_s=0.2\n")
        assert (status, found["items"][0]["seconds"]) == (1, pytest.approx(0.35)), found


def test_a_difference_names_the_line_and_the_cause(name, path, capsys):
    old = Path("..", "old", path.name)
    shutil.copytree(".", old.parent)
    before, after = sample_of(name).pause
    path.write_bytes(path.read_bytes().replace(before.encode(), after.encode()))
    status, found = told(capsys, "diff", str(old), str(path), "--robot", ROBOT)
    (program,) = found["programs"]
    assert status == 0
    assert program["change_s"] == pytest.approx(3.15, abs=1e-6)
    (change,) = program["changes"]
    assert (change["cause"], change["new_line"]) == ("wait", line_with(path, after))
    assert change["change_s"] == pytest.approx(3.15, abs=1e-6)


def test_a_wait_without_limit_is_found_and_a_comment_of_the_language_excuses_it(name, path, capsys):
    vendor = find_vendor(name)
    status, found = told(capsys, "lint", str(path), "--robot", ROBOT, "--select", "W012")
    (finding,) = found["findings"]
    assert status == 0
    assert sample_of(name).wait in lines_of(path)[finding["line"] - 1].decode("latin-1")
    lines = lines_of(path)
    at = finding["line"] - 1
    for code, excused in (("W012", True), ("W001", False)):
        above = f"{vendor.comment_prefix}olp: ignore {code}{vendor.comment_suffix}".encode()
        on = lines[at].rstrip(b"\r") + f"{vendor.trailing_comment_prefix}olp: ignore {code}".encode()
        for rows in ([above, lines[at]], [on]):
            if name == "tp" and rows == [on]:
                continue  # a line of TP has no room for a comment
            path.write_bytes(b"\n".join([*lines[:at], *rows, *lines[at + 1 :]]))
            _, found = told(capsys, "lint", str(path), "--robot", ROBOT, "--select", "W012")
            assert bool(found["findings"]) is not excused, rows
            assert ("1 excused" in found["summary"][0]) is excused


def test_rules_speak_of_things_by_their_names(name, path, capsys):
    _, found = told(capsys, "lint", ".", "--robot", ROBOT)
    assert found["findings"]
    assert not any(re.search(r"\w\(\w+=|<.*object|None", f["message"]) for f in found["findings"])
    assert not any(item["status"] == "unknown" for item in found["items"]), found["items"]


def test_a_folder_of_the_language_is_judged_program_by_program(name, path, capsys):
    # DROP of INFORM needs a position that only its caller sets.
    files = "files='HANDLING.*'\n" if name == "inform" else ""
    _, found = check(capsys, Path("."), f"[[budget]]\nname='b'\nlimit_s=99\n{files}")
    assert {item["status"] for item in found["items"]} == {"held"}, found["items"]
    assert str(path) in {item["file"] for item in found["items"]}


class Page(HTMLParser):
    """The text of a page, and what it would load from elsewhere."""

    def __init__(self) -> None:
        super().__init__()
        self.text: list[str] = []
        self.loads: list[str] = []

    def handle_data(self, data: str) -> None:
        self.text.append(data)

    def handle_starttag(self, tag, attrs) -> None:
        self.loads += [v for k, v in attrs if k in ("src", "href") and v and not v.startswith(("#", "data:"))]


def test_the_report_is_one_page_with_the_program_in_it(name, path, capsys, tmp_path):
    out = tmp_path / "report.html"
    assert main(["report", str(path), "--robot", ROBOT, "-o", str(out)]) == 0
    page = Page()
    page.feed(out.read_text(encoding="utf-8"))
    assert page.loads == []
    words = " ".join(page.text)
    assert sample_of(name).pause[0] in words
    assert path.name in words


def test_runs_are_kept_and_their_trend_shown(name, path, capsys):
    totals = []
    for text in sample_of(name).pause:
        path.write_bytes(path.read_bytes().replace(sample_of(name).pause[0].encode(), text.encode()))
        Path("olp.toml").write_text(f"robot = '{ROBOT}'\n[[budget]]\nlimit_s = 99\nfiles = '{path}'\n")
        main(["check", str(path), "--store", "olp.db", "--no-cache"])
        capsys.readouterr()
        totals.append(seconds(capsys, path)[0])
    for word in (str(path), path.stem):
        assert main(["trend", word, "--format", "json"]) == 0
        assert [p["total_s"] for p in json.loads(capsys.readouterr().out)] == pytest.approx(totals)
    assert totals[1] - totals[0] == pytest.approx(3.15, abs=1e-6)
