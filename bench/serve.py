"""`olp serve` in headless Chromium: `python bench/serve.py [--pictures FOLDER]`.

Makes a cell of 120 jobs in a git repository, serves it, and uses the page as a person would: the cell, a program and
its page, what-if, two versions, a dropped recording, keyboard, 400 px, dark. Prints what it took; exit status 1 when a
figure is missed or something on the page does not work.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable
from pathlib import Path
from urllib.request import Request, urlopen

from browser import Browser
from report import job

ROOT = Path(__file__).resolve().parent.parent
JOBS, LINES = 120, 200
ROBOT = "yaskawa/gp25"


def make_cell(root: Path) -> None:
    """Folders of the samples until there are 120 jobs, one of them with 200 lines; its version before is in git."""
    samples = ROOT / "samples" / "inform"
    shutil.copytree(samples / "handling", root / "handling")
    (root / "LONG.JBI").write_text(job(LINES - 20), newline="\r\n")
    number = 0
    while (left := JOBS - len(list(root.rglob("*.JBI")))) > 0:
        number += 1
        folder = root / f"station{number}"
        folder.mkdir()
        for file in sorted((samples / "palletising").glob("*.JBI"))[:left]:
            shutil.copy(file, folder)
    for words in (
        ["init", "-q"],
        ["add", "-A"],
        ["-c", "user.name=a", "-c", "user.email=a@b.example", "commit", "-qm", "1"],
    ):
        subprocess.run(["git", *words], cwd=root, check=True)
    file = root / "handling" / "HANDLING.JBI"
    file.write_bytes(file.read_bytes().replace(b"V=250.0", b"V=125.0"))


def zipped(folder: Path, file: Path) -> Path:
    with zipfile.ZipFile(file, "w") as archive:
        for one in folder.iterdir():
            archive.write(one, f"{folder.name}/{one.name}")
    return file


_DIAGNOSED = "document.getElementById('diagnosis').contentDocument?.body?.textContent"
_PROBLEMS = "document.getElementById('problems').textContent"


class Walk:
    """What is done on the page, and what it took. `rows`: figure, asked, found, whether it held."""

    def __init__(self, browser: Browser, address: str, root: Path, pictures: Path | None) -> None:
        self.browser, self.address, self.root, self.pictures = browser, address, root, pictures
        self.rows: list[tuple[str, str, str, bool]] = []

    def row(self, name: str, asked: str, found: object, held: bool) -> None:
        self.rows.append((name, asked, str(found), held))

    def picture(self, name: str) -> None:
        if self.pictures is not None:
            self.browser.picture(self.pictures / f"{name}.png")

    def cell(self) -> None:
        began = time.perf_counter()
        self.browser.open(self.address)
        self.browser.until("document.documentElement.dataset.ready")
        seconds = time.perf_counter() - began
        count = self.browser.run("document.querySelectorAll('#programs tbody tr').length")
        self.row("programs in the table", str(JOBS), count, count == JOBS)
        self.row(f"cell of {JOBS} jobs, first time", "≤ 8 s", f"{seconds:.2f} s", seconds <= 8)
        self.picture("cell")
        shown = self.browser.run(
            "document.querySelector('#tiles div:nth-child(2) dd').firstChild.textContent"
        )
        words = ["time", ".", "--robot", ROBOT, "--summary", "--format", "json"]
        began = time.perf_counter()
        done = subprocess.run(
            [sys.executable, "-m", "olp", *words], cwd=self.root, capture_output=True, check=False
        )
        self.row("olp time on it, the same minute", "–", f"{time.perf_counter() - began:.2f} s", True)
        total = sum(one["total_s"] or 0.0 for one in json.loads(done.stdout) if one["started"])
        number = float(re.sub(r"[^\d.]", "", shown))
        self.row("total as olp time says", f"{total:.3f} s", shown, abs(number - total) < 1e-3)
        began = time.perf_counter()
        self.browser.open(self.address)
        self.browser.run("1")
        self.browser.until("document.documentElement.dataset.ready")
        self.row("the same again, nothing changed", "–", f"{time.perf_counter() - began:.2f} s", True)

    def program(self) -> None:
        self.browser.run(
            "[...document.querySelectorAll('#programs a')].find((a) => a.textContent === 'LONG.JBI').click()"
        )
        rows = self.browser.until("document.querySelectorAll('#lines tbody tr').length")
        self.row("lines that can be changed", f"{LINES - 20}", rows, rows == LINES - 20)
        inner = "document.getElementById('report').contentDocument"
        self.browser.until(f"{inner}?.documentElement.dataset.ready")
        title = self.browser.run(f"{inner}.title")
        self.row("page of the program", "LONG.JBI", title, "LONG.JBI" in title)
        row = f"{inner}.querySelectorAll('#segments tr[data-step]')[9]"
        self.browser.run(f"{row}.click()")
        line = self.browser.run(f"{row}.cells[0].textContent")
        met = self.browser.until("document.querySelector('#lines .met')?.cells[0].textContent")
        self.row("a segment clicked there, its line in what-if", line, met, line == met)
        self.picture("program")
        self.browser.run("document.getElementById('report').scrollIntoView()")
        self.browser.run(f"{inner}.getElementById('view').scrollIntoView()")
        time.sleep(0.5)
        self.picture("program-page")

    def what_if(self) -> None:
        trips = []
        for number in range(12):
            script = f"""(() => {{
                delete document.documentElement.dataset.answered;
                const input = document.querySelectorAll('#lines input')[{5 + number}];
                input.value = 77; input.dispatchEvent(new Event('input'));
            }})()"""
            self.browser.run(script)
            trips.append(1e-3 * float(self.browser.until("document.documentElement.dataset.answered")))
        trip = statistics.median(trips)
        self.row(
            f"what-if, {LINES} lines, there and back",
            "≤ 0.2 s",
            f"{trip:.3f} s (worst {max(trips):.3f})",
            trip <= 0.2,
        )
        zones = "document.querySelector('#lines select')"
        self.browser.run(f"{zones}.value = '2'; {zones}.dispatchEvent(new Event('change'))")
        self.browser.until("document.querySelectorAll('#what-if-tiles .tile').length === 3")
        self.picture("what-if")
        self.browser.run("document.getElementById('draw').click()")
        self.browser.until("document.getElementById('report').contentDocument?.title.includes('what if')")
        before = (self.root / "LONG.JBI").read_bytes()
        time.sleep(0.2)
        second = "document.querySelector('#what-if-tiles .tile:nth-child(2) dd')?.textContent"
        then = self.browser.run(second)
        text = self.browser.run(
            "fetch(document.getElementById('alone').href.replace('/page?', '/download?')).then((r) => r.text())"
        )
        edited = self.root.parent / "edited" / "LONG.JBI"
        edited.parent.mkdir()
        edited.write_text(text, newline="")
        words = ["time", str(edited), "--robot", ROBOT, "--summary", "--format", "json"]
        done = subprocess.run([sys.executable, "-m", "olp", *words], capture_output=True, check=False)
        total = json.loads(done.stdout)[0]["total_s"]
        self.row("the download, as olp time says", then, f"{total:.3f} s", f"{total:.3f} s" == then)
        same = (self.root / "LONG.JBI").read_bytes() == before and b"V=77" not in before
        self.row("the file", "unchanged", "unchanged" if same else "changed", same)
        field = "document.getElementById('override')"
        self.browser.run(f"{field}.value = 50; {field}.dispatchEvent(new Event('input'))")
        slower = self.browser.until(f"{second} !== {json.dumps(then)} && {second}")
        self.row("override 50 %", f"more than {then}", slower, float(slower.split()[0]) > total)
        self.browser.run(
            "const one = document.querySelector('#lines input'); one.value = -3; one.dispatchEvent(new Event('input'))"
        )
        told = self.browser.until("document.getElementById('refused').textContent")
        self.row("a speed of -3", "O006", told[:60], "O006" in told)

    def versions(self) -> None:
        self.browser.run("location.hash = 'compare'")
        self.browser.run(
            "document.getElementById('new').value = 'handling/HANDLING.JBI'; document.getElementById('compare').click()"
        )
        told = self.browser.until("document.getElementById('compared').textContent")
        rows = self.browser.run("document.querySelectorAll('#changes tbody tr').length")
        self.row("against git's HEAD", "1 line", f"{rows} line: {told[:45]}", rows == 1)
        self.picture("compare")
        self.browser.run(
            "document.getElementById('old').value = 'handling/DROP.JBI'; document.getElementById('compare').click()"
        )
        rows = self.browser.until(
            "!document.getElementById('changes').hidden && document.querySelectorAll('#changes tbody tr').length"
        )
        self.row("two files of the folder", "> 2 lines", f"{rows} lines", rows > 2)

    def recording(self) -> None:
        samples = ROOT / "samples" / "recordings"
        archive = zipped(samples / "tuned", self.root.parent / "tuned.zip")
        for dropped, wanted in (
            (archive, "EXPLAINED"),
            (samples / "trace", "Diagnosis of"),
            (samples / "logs" / "run.mcap", "Diagnosis of"),
        ):
            began = time.perf_counter()
            self.drop(dropped)
            meanwhile = self.meanwhile()
            text = self.browser.until(f"{_DIAGNOSED} || {_PROBLEMS}", 120)
            seconds = time.perf_counter() - began
            held = wanted.lower() in text.lower() and not self.browser.run(_PROBLEMS) and meanwhile < 1
            self.row(
                f"{dropped.name}, dropped",
                wanted,
                f"{seconds:.1f} s, meanwhile a page in {meanwhile:.3f} s",
                held,
            )
            self.picture(f"recording-{dropped.stem}")
        bad = self.root.parent / "bad.csv"
        bad.write_bytes(b"\0\1\2;;;")
        self.drop(bad)
        told = " ".join(self.browser.until(_PROBLEMS).split())
        self.row("a file that is no recording", "told", told[:70], "error" in told)
        self.picture("refused")

    def drop(self, file: Path) -> None:
        self.browser.run("document.getElementById('diagnosis').src = 'about:blank'")
        self.browser.until(f"{_DIAGNOSED} === '' || !{_DIAGNOSED}")
        self.browser.drop([file])

    def meanwhile(self) -> float:
        """How long another question takes while a recording is diagnosed [s]."""
        began = time.perf_counter()
        asked = Request(f"{self.address}api/what_if_lines", b'{"file": "LONG.JBI"}', method="POST")
        with urlopen(asked) as reply:
            reply.read()
        return time.perf_counter() - began

    def looks(self) -> None:
        self.browser.run("location.hash = 'cell'")
        for width, scheme in ((400, "light"), (400, "dark"), (1280, "dark")):
            self.browser.size(width, 900)
            self.browser.medium(scheme=scheme)
            for view in ("cell", "program=handling%2FHANDLING.JBI", "compare", "recording"):
                self.browser.run(f"location.hash = {view!r}")
                time.sleep(0.5)
                wide = self.browser.run("document.documentElement.scrollWidth")
                name = view.partition("=")[0]
                if wide > width:
                    self.row(f"{name} at {width} px", "fits", f"{wide} px wide", False)
                self.picture(f"{name}-{width}-{scheme}")
        self.row("400 px and dark, four views", "fits", "fits", True)
        self.browser.size(1280, 900)

    def keyboard(self) -> None:
        self.browser.run("location.hash = 'cell'; document.activeElement.blur()")
        met = []
        for _ in range(40):
            self.browser.key("Tab")
            met.append(self.browser.run("document.activeElement.textContent || document.activeElement.id"))
            if met[-1].endswith(".JBI"):
                break
        self.browser.key("Enter")
        at = self.browser.until("location.hash.startsWith('#program=') && location.hash")
        self.row("keyboard: Tab to a program, Enter", "its page", at, at.startswith("#program="))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pictures", type=Path, help="a folder for screenshots")
    args = parser.parse_args()
    if args.pictures is not None:
        args.pictures.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        root = Path(os.path.realpath(folder)) / "cell"
        root.mkdir()
        make_cell(root)
        words = ["serve", str(root), "--no-browser", "--robot", ROBOT]
        server = subprocess.Popen([sys.executable, "-m", "olp", *words], stdout=subprocess.PIPE, text=True)
        assert server.stdout is not None
        found = re.search(r"http://\S+", server.stdout.readline())
        assert found is not None
        with Browser() as browser:
            browser.size(1280, 900)
            walk = Walk(browser, found[0], root, args.pictures)
            steps: list[Callable[[], None]] = [
                walk.cell,
                walk.program,
                walk.what_if,
                walk.versions,
                walk.recording,
                walk.looks,
                walk.keyboard,
            ]
            for step in steps:
                try:
                    step()
                except (RuntimeError, TimeoutError) as problem:
                    walk.row(step.__name__, "works", f"{type(problem).__name__}: {problem}"[:200], False)
            outside = [
                one for one in browser.requests if not one.startswith((found[0], "data:", "blob:", "about:"))
            ]
            expected = re.compile("status of 422")  # what the walk asks for to see it refused
            console = [one for one in browser.console if not expected.search(one)]
        walk.row("requests elsewhere", "none", outside or "none", not outside)
        walk.row("errors on the console", "none", console or "none", not console)
        server.send_signal(signal.SIGINT)
        status = server.wait(20)
        walk.row("Ctrl+C", "status 0", f"status {status}", status == 0)
    print("| figure | asked | measured |\n|---|---|---|")
    for name, asked, measured, held in walk.rows:
        print(f"| {name} | {asked} | {measured}{'' if held else ' **missed**'} |")
    return 0 if all(held for *_, held in walk.rows) else 1


if __name__ == "__main__":
    sys.exit(main())
