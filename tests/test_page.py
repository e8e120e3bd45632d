"""The page of `olp report`: whole, small, and nothing in it but what olp wrote."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import re
import shutil
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from olp.__main__ import main
from olp.fluent import read
from olp.identification.timing_job import TimingJob, time_program
from olp.languages.vendor import read as read_program
from olp.reports.page import PageShare, program_data, shares
from olp.robots.kinematics import forward
from olp.timing.track import states

SAMPLES = Path(__file__).parent.parent / "samples" / "inform"


class Page(HTMLParser):
    """What a browser would find: ids, links, references to elsewhere, unbalanced elements."""

    VOID = frozenset({"meta", "input", "br", "link", "img"})

    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids: list[str] = []
        self.links: list[str] = []
        self.elsewhere: list[str] = []
        self.open: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.ids += [given["id"]] if "id" in given else []
        self.links += [given["href"]] if tag == "a" else []
        self.elsewhere += [given[name] for name in ("src", "data", "action") if name in given]
        if tag == "link":
            self.elsewhere.append(given.get("href", ""))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


@pytest.fixture
def jobs(tmp_path):
    shutil.copytree(SAMPLES / "palletising", tmp_path / "jobs")
    return tmp_path / "jobs"


def page_of(*paths, out):
    status = main(["report", *map(str, paths), "-o", str(out)])
    return status, out.read_text(encoding="utf-8")


def data_of(text, index):
    found = re.search(rf'<script type="application/gzip" id="d{index}">(.*?)</script>', text, re.DOTALL)
    return json.loads(gzip.decompress(base64.b64decode(found[1])))


def test_the_page_is_whole_and_asks_for_nothing_from_elsewhere(jobs, tmp_path):
    status, text = page_of(jobs, out=tmp_path / "r.html")
    page = Page(text)
    assert status == 0
    assert page.open == []
    assert page.elsewhere == []
    assert len(page.ids) == len(set(page.ids))
    assert {link[1:] for link in page.links} <= set(page.ids)
    assert "default-src 'none'" in text
    namespace = "http://www.w3.org/1999/xhtml"  # a name of the libraries, which nobody fetches
    assert set(re.findall(r"https?://[^\"'` ]*", text)) <= {namespace}


def test_the_numbers_are_those_of_olp_time(jobs, tmp_path):
    _, text = page_of(jobs / "PICK.JBI", out=tmp_path / "r.html")
    data = data_of(text, 0)
    timed = read(jobs / "PICK.JBI").plan().time()
    assert data["seconds"] == pytest.approx(timed["duration_s"].tolist(), abs=1e-6)
    assert data["line"] == timed["line"].tolist()
    assert [data["kinds"][k] for k in data["kind"]] == timed["kind"].tolist()
    path = data["path"]
    assert len(path["x"]) == len(path["step"]) == len(path["z"])


def test_the_second_page_shows_what_changed_since_the_first(jobs, tmp_path):
    page_of(jobs, out=tmp_path / "r.html")
    job = jobs / "PICK.JBI"
    job.write_bytes(job.read_bytes().replace(b"V=120.0", b"V=60.0"))
    _, text = page_of(jobs, out=tmp_path / "r.html")
    assert "since the last report" in text
    assert re.search(r'class="r worse">\+\d', text)


def test_budgets_stand_in_the_page(jobs, tmp_path):
    (tmp_path / "olp.toml").write_text('[[budget]]\nname = "pallet"\nfiles = "*.JBI"\nlimit_s = 1\n')
    _, text = page_of(jobs, out=tmp_path / "r.html")
    assert "pallet: over" in text


def test_a_broken_budget_in_the_page_says_what_would_hold_it(tmp_path):
    sample = Path(__file__).parent.parent / "samples/inform/touch-up/before/TOUCH-UP.JBI"
    job = tmp_path / "TOUCH-UP.JBI"
    job.write_bytes(sample.read_bytes())
    for limit, says in ((3.6, r"make it 3\.6 s: \d edits? \(line \d+ "), (0.1, "no edits of speeds and acc")):
        (tmp_path / "olp.toml").write_text(
            f'robot = "yaskawa/ma2010"\n[[budget]]\nname = "a"\nlimit_s = {limit}\n'
        )
        _, text = page_of(job, out=tmp_path / "r.html")
        assert re.search(says, text)


def test_a_total_that_leaves_moves_out_says_at_least(jobs, tmp_path):
    job = jobs / "PICK.JBI"
    status, text = page_of(job, out=tmp_path / "r.html")
    assert (status, "at least" in text.partition("<script")[0], "<dd>3.257 s</dd>" in text) == (
        0,
        False,
        True,
    )
    job.write_bytes(re.sub(rb"END\s*$", b"MOVL P099 V=100.0\r\nEND\r\n", job.read_bytes()))
    status, text = page_of(job, out=tmp_path / "r.html")
    assert (status, "<dd>at least 3.257 s</dd>" in text) == (0, True)
    settings = jobs / "olp.toml"
    settings.write_text(settings.read_text() + '\n[unknown]\nvalues = "error"\n')
    status, text = page_of(job, out=tmp_path / "r.html")
    assert (status, "<dd>at least 3.257 s</dd>" in text) == (2, True)


def test_text_of_a_program_becomes_no_markup(tmp_path):
    sample = (SAMPLES / "palletising" / "PICK.JBI").read_bytes()
    evil = b"'</script><script>alert(1)</script><img src=x onerror=alert(2)>"
    job = tmp_path / "EVIL.JBI"
    job.write_bytes(re.sub(rb"\r?\nNOP\r?\n", lambda m: m[0] + evil + b"\r\n", sample))
    _, text = page_of(job, out=tmp_path / "r.html")
    page = Page(text)
    assert page.elsewhere == []
    assert text.count("<script") == 4
    assert any("alert(1)" in line for file in data_of(text, 0)["files"] for line in file["lines"])


def test_two_thousand_segments_stay_below_a_megabyte(tmp_path):
    _, text = page_of(SAMPLES / "cam" / "FINISH.JBI", out=tmp_path / "r.html")
    segments = len(data_of(text, 0)["seconds"])
    assert len(text.encode()) * 2000 / segments < 1_000_000


def test_a_page_of_nothing_that_can_be_shown_is_refused(tmp_path, capsys):
    job = tmp_path / "A.JBI"
    job.write_bytes(b"nothing of a job\r\n")
    assert main(["report", str(job), "-o", str(tmp_path / "r.html")]) == 2
    assert not (tmp_path / "r.html").exists()
    assert "error[" in capsys.readouterr().err


def test_the_arm_of_the_page_stands_where_olp_track_says(tmp_path):
    """The page's own kinematics: each joint's offset, then its turn, from the base to the flange."""
    job = SAMPLES / "generations" / "dx200.jbi"
    _, text = page_of(job, out=tmp_path / "r.html")
    arm, path = (data_of(text, 0)[name] for name in ("arm", "path"))
    timing = time_program(read_program(str(job)), TimingJob())
    assert arm["floor"] is None or arm["floor"] < 0
    for n in range(0, len(arm["t"]), 7):
        place, turn = np.zeros(3), Rotation.identity()
        for joint in arm["joints"]:
            place = place + turn.apply(joint["offset"])
            turn = turn * Rotation.from_rotvec(
                np.radians(arm["axes"][joint["axis"]][n]) * np.array(joint["direction"])
            )
        place = place + turn.apply(arm["flange"])
        position, _, axes = states(timing, np.array([arm["t"][n]]))
        assert np.degrees(axes[0]) == pytest.approx([axis[n] for axis in arm["axes"]], abs=0.1)
        flange, _ = forward(timing.plan.robot, axes)
        assert place == pytest.approx(flange[0] * 1000, abs=2)
        assert [path[k][path["t"].index(arm["t"][n])] for k in "xyz"] == pytest.approx(
            position[0] * 1000, abs=0.06
        )


def test_the_causes_of_a_cell_sum_to_its_time(jobs, tmp_path):
    _, text = page_of(jobs, out=tmp_path / "r.html")
    cell = text[: text.index("The lines that cost most")]
    causes = [float(seconds) for seconds in re.findall(r"% \(([\d.]+) s\)</span>", cell)]
    assert len(causes) >= 3
    assert sum(causes) == pytest.approx(float(re.search(r"<dd>([\d.]+) s", cell)[1]), abs=0.005)


def test_a_page_holds_the_first_segments_and_says_how_many_there_are():
    held = shares([100, 100_000, 30_000])
    assert sum(share.segments for share in held) == PageShare().segments
    assert held[0].segments == 100
    timing = time_program(read_program(str(SAMPLES / "cam" / "FINISH.JBI")), TimingJob())
    data = program_data(timing, PageShare(segments=50, samples=40, points=30, poses=20))
    assert (len(data["seconds"]), data["of"]) == (50, len(timing.plan))
    assert len(data["path"]["t"]) <= 30
    assert data["path"]["t"][-1] <= timing.end_s[49] + 1e-3
    assert data["arm"] is None or len(data["arm"]["t"]) <= 20


def test_the_vendored_libraries_are_those_that_were_fetched():
    folder = Path(__file__).parent.parent / "templates" / "vendored"
    for line in (folder / "SHA256SUMS").read_text().splitlines():
        found, name = line.split()
        assert hashlib.sha256((folder / name).read_bytes().replace(b"\r\n", b"\n")).hexdigest() == found
    code = (folder / "libraries.js").read_text(encoding="utf-8")
    assert (folder / "LICENCES.txt").read_text(encoding="utf-8") in code
    for asks in ("</script", "fetch(", "XMLHttpRequest", "eval(", "new Function", "importScripts"):
        assert asks not in code
