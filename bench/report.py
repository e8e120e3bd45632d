"""The report in headless Chromium: `python bench/report.py [--pictures FOLDER]`.

Writes the reports of 5,000 segments, of 1,000,000 (a loop) and of 120 jobs, and uses them as a reader would: pointer,
zoom, playback, keyboard, 400 px, dark, paper. Prints what it took; exit status 1 when a figure is missed or something
on the page does not work.
"""

from __future__ import annotations

import argparse
import base64
import math
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from browser import Browser

from olp.__main__ import main as olp

ASKED_MS, ASKED_CELL_S, ASKED_CELL_BYTES, ASKED_BYTES = 2000, 15.0, 3_000_000, 1_000_000
SEGMENTS, MILLION, JOBS = 5000, 1_000_000, 120
HEAD = """/JOB
//NAME BIG
//POS
///NPOS {n},0,0,0,0,0
///TOOL 0
///POSTYPE BASE
///RECTAN
///RCONF 0,0,0,0,0,0,0,0
"""
TAIL = "//INST\n///DATE 2026/11/20 12:00\n///ATTR SC,RW\n///GROUP1 RB1\nNOP\n"
ROBOT = "yaskawa/gp25"


def job(segments: int, rounds: int = 1) -> str:
    """A job whose path winds up a cone, `rounds` times."""
    points, moves = [], []
    for i in range(segments):
        angle, radius = i / 40, 300 + 100 * math.sin(i / 500)
        x, y, z = 900 + radius * math.cos(angle), radius * math.sin(angle), 400 + i / 20
        points.append(
            f"C{i:05d}={x:.3f},{y:.3f},{z:.3f},180.00,{3 * math.sin(i / 70):.2f},{(i / 9) % 360 - 180:.2f}"
        )
        moves.append(f"MOVL C{i:05d} V={100 + 10 * (i % 30):.1f} PL={i % 4}")
    if rounds > 1:
        moves = [f"FOR I000 START= 0 TO {rounds - 1}", *moves, "NEXT I000"]
    return HEAD.format(n=segments) + "\n".join(points) + "\n" + TAIL + "\n".join(moves) + "\nEND\n"


def written(folder: Path, name: str, texts: list[str], *words: str) -> tuple[Path, float]:
    """The report of such jobs, and how long it took [s]."""
    jobs, page = folder / name, folder / f"{name}.html"
    jobs.mkdir()
    for number, text in enumerate(texts):
        (jobs / f"J{number:03d}.JBI").write_text(text, newline="\r\n")
    begin = time.perf_counter()
    olp(["report", str(jobs), "-o", str(page), "--robot", ROBOT, *words])
    return page, time.perf_counter() - begin


def opened(browser: Browser, page: Path) -> int:
    """[ms] until the page answers."""
    browser.open("about:blank")
    browser.until("document.URL === 'about:blank'")
    browser.open(page.as_uri())
    return int(browser.until("document.documentElement.dataset.ready"))


class Reader:
    """What a reader does with a page, and what is seen then."""

    def __init__(self, browser: Browser) -> None:
        self.browser = browser

    def point(self, name: str, x: float, y: float) -> tuple[float, float]:
        """A place on the page [px] by shares of an element, which is brought into sight."""
        box = self.browser.run(
            f"(() => {{ const e = document.querySelector('{name}'); e.scrollIntoView({{ block: 'center' }});"
            " const b = e.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()"
        )
        return box[0] + x * box[2], box[1] + y * box[3]

    def mouse(self, kind: str, place: tuple[float, float], **more: object) -> None:
        self.browser.call("Input.dispatchMouseEvent", type=kind, x=place[0], y=place[1], **more)

    def told(self, name: str, x: float = 0.4, y: float = 0.5) -> str:
        """What the page says beside a pointer on the element."""
        self.mouse("mouseMoved", (2, 2))
        self.mouse("mouseMoved", self.point(name, x, y))
        time.sleep(0.1)
        return str(
            self.browser.run(
                "document.getElementById('tip').hidden ? '' : document.getElementById('tip').innerText"
            )
        )

    def clicked(self, name: str, x: float = 0.4, y: float = 0.3) -> str:
        """The statement that is chosen after a click."""
        place = self.point(name, x, y)
        for kind in ("mouseMoved", "mousePressed", "mouseReleased"):
            self.mouse(kind, place, button="left", clickCount=1)
        return str(self.browser.run("document.getElementById('facts').innerText"))

    def drawn(self) -> str:
        return str(self.browser.run("document.querySelector('#space canvas').toDataURL()"))

    def widest(self) -> float:
        """[px] where the last of the columns with times ends."""
        second = ", ".join(f"{table} th:nth-child(2)" for table in ("#index", ".lines", "#segments"))
        ends = f"[...document.querySelectorAll('{second}')].map((e) => e.getBoundingClientRect().right)"
        return float(self.browser.run(f"Math.max(...{ends})"))


def held(reader: Reader) -> Iterator[tuple[str, bool]]:
    """What is asked of the page, and whether it does it."""
    browser = reader.browser
    yield (
        "the segments say what is under the pointer",
        "limited by" in reader.told("#gantt .u-over", 0.4, 0.5),
    )
    yield "the speed, too", "mm/s" in reader.told("#speed .u-over")
    yield "the axes, too", "°" in reader.told("#axes .u-over")
    reader.point("#space", 0.5, 0.5)
    browser.until("document.documentElement.dataset.space")
    time.sleep(0.5)
    spots = ((x / 20, y / 20) for y in range(6, 16) for x in range(4, 18))
    yield "the path, too", any("line" in reader.told("#space canvas", x, y) for x, y in spots)
    before = reader.drawn()
    yield "a click in the segments chooses one", "takes" in reader.clicked("#gantt .u-over", 0.4, 0.5)
    time.sleep(0.3)
    yield "in space, too", reader.drawn() != before
    yield (
        "in the table, too",
        bool(browser.run("document.querySelector('#segments tr.on, #text .on') !== null")),
    )
    place = reader.point("#speed .u-over", 0.5, 0.5)
    axis = "document.querySelector('#gantt canvas').toDataURL()"
    whole = browser.run(axis)
    reader.mouse("mouseWheel", place, deltaX=0, deltaY=-300)
    time.sleep(0.3)
    yield "the wheel over one curve zooms all", browser.run(axis) != whole
    before, begun = reader.drawn(), float(browser.run("+document.getElementById('time').value"))
    browser.run("document.getElementById('play').focus()")
    browser.key(" ")
    began = time.perf_counter()
    time.sleep(2)
    browser.key(" ")
    share = (float(browser.run("+document.getElementById('time').value")) - begun) / (
        time.perf_counter() - began
    )
    yield "the arm moves, as fast as the clock", reader.drawn() != before and 0.7 < share < 1.3
    browser.run("document.getElementById('gantt').focus()")
    chosen = browser.run("document.getElementById('facts').innerText")
    browser.key("ArrowRight")
    yield (
        "an arrow key goes to the next segment",
        browser.run("document.getElementById('facts').innerText") != chosen,
    )
    browser.size(400, 800)
    time.sleep(0.4)
    yield (
        "400 px: the times are in sight, and nothing is wider",
        reader.widest() <= 400 and bool(browser.run("document.documentElement.scrollWidth <= 400")),
    )
    browser.size(1280, 900)
    browser.medium("screen", "dark")
    yield (
        "dark where the system is",
        browser.run("getComputedStyle(document.body).backgroundColor") != "rgb(255, 255, 255)",
    )
    browser.medium("screen", "light")


def paper(browser: Browser, file: Path) -> bool:
    """Prints the page; whether all findings and assumptions are on it."""
    browser.run(
        "addEventListener('beforeprint', () => { window.printed = [...document.querySelectorAll('.program li')]"
        ".every((e) => e.checkVisibility({ contentVisibilityAuto: true })) })"
    )
    file.write_bytes(base64.b64decode(browser.call("Page.printToPDF", printBackground=True)["data"]))
    return bool(browser.run("window.printed"))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pictures", type=Path, help="where pictures of the page are left")
    pictures: Path | None = parser.parse_args().pictures
    rows: list[tuple[str, str, str, bool]] = []
    with tempfile.TemporaryDirectory() as name, Browser() as browser:
        folder = Path(name)
        browser.size(1280, 900)
        size = written(folder, "small", [job(2000)])[0].stat().st_size
        page, _ = written(folder, "big", [job(SEGMENTS)])
        spent = opened(browser, page)
        rows.append(
            (
                f"{SEGMENTS:,} segments until the page answers",
                f"{ASKED_MS:,} ms",
                f"{spent:,} ms",
                spent <= ASKED_MS,
            )
        )
        rows.append(
            (
                "size for 2,000 segments",
                f"{ASKED_BYTES / 1e6:g} MB",
                f"{size / 1e6:.2f} MB",
                size <= ASKED_BYTES,
            )
        )
        does = list(held(Reader(browser)))
        does.append(("paper has the findings and assumptions", paper(browser, folder / "page.pdf")))
        if pictures:
            pictures.mkdir(parents=True, exist_ok=True)
            (pictures / "report.pdf").write_bytes((folder / "page.pdf").read_bytes())
            browser.picture(pictures / "report.png", whole=True)
        page, spent_s = written(folder, "cell", [job(100 + n) for n in range(JOBS)])
        size = page.stat().st_size
        rows.append(
            (f"a report of {JOBS} jobs", f"{ASKED_CELL_S:g} s", f"{spent_s:.1f} s", spent_s <= ASKED_CELL_S)
        )
        rows.append(
            ("its size", f"{ASKED_CELL_BYTES / 1e6:g} MB", f"{size / 1e6:.2f} MB", size <= ASKED_CELL_BYTES)
        )
        spent = opened(browser, page)
        rows.append(("until it answers", f"{ASKED_MS:,} ms", f"{spent:,} ms", spent <= ASKED_MS))
        page, _ = written(folder, "million", [job(200, MILLION // 200)], "--max-steps", str(2 * MILLION))
        size, spent = page.stat().st_size, opened(browser, page)
        rows.append(
            (
                f"{MILLION:,} segments until the page answers",
                f"{ASKED_MS:,} ms",
                f"{spent:,} ms, {size / 1e6:.2f} MB",
                spent <= ASKED_MS,
            )
        )
        done = sum(ok for _, ok in does)
        rows.append(
            (
                "what a reader does (pointer, zoom, playback, keys, 400 px, dark, paper)",
                f"all {len(does)}",
                str(done),
                done == len(does),
            )
        )
        asked = [one for one in browser.requests if not one.startswith(("file:", "about:"))]
        rows.append(
            (
                "lines on the console; requests",
                "0; 0",
                f"{len(browser.console)}; {len(asked)}",
                not browser.console and not asked,
            )
        )
    print("| figure | asked | measured |\n|---|---|---|")
    for what, wanted, found, _ in rows:
        print(f"| {what} | {wanted} | {found} |")
    for line in [*(what for what, ok in does if not ok), *browser.console, *asked]:
        print(line)
    return 0 if all(ok for *_, ok in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
