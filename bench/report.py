"""The report in headless Chromium: `python bench/report.py [SEGMENTS]`.

Makes a job of that many segments (5000), writes its report, opens it, and prints how long the page takes until it
answers, what it wrote to the console, and how large it is. Exit status 1 when a figure is missed.
"""

from __future__ import annotations

import math
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from olp.__main__ import main as olp

ASKED_MS, ASKED_BYTES = 2000, 1_000_000
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


def job(segments: int) -> str:
    """A job whose path winds up a cone."""
    points, moves = [], []
    for i in range(segments):
        angle, radius = i / 40, 300 + 100 * math.sin(i / 500)
        x, y, z = 900 + radius * math.cos(angle), radius * math.sin(angle), 400 + i / 20
        points.append(
            f"C{i:05d}={x:.3f},{y:.3f},{z:.3f},180.00,{3 * math.sin(i / 70):.2f},{(i / 9) % 360 - 180:.2f}"
        )
        moves.append(f"MOVL C{i:05d} V={100 + 10 * (i % 30):.1f} PL={i % 4}")
    return HEAD.format(n=segments) + "\n".join(points) + "\n" + TAIL + "\n".join(moves) + "\nEND\n"


def main(arguments: list[str]) -> int:
    segments = int(arguments[0]) if arguments else 5000
    browser = next(
        (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))),
        None,
    )
    if browser is None:
        print("no Chromium on this machine", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory() as folder:
        source, page = Path(folder, "BIG.JBI"), Path(folder, "report.html")
        source.write_text(job(segments), newline="\r\n")
        olp(["report", str(source), "-o", str(page)])
        size = page.stat().st_size
        words = "--headless=new --no-sandbox --disable-gpu --enable-logging=stderr --log-level=0 --dump-dom"
        words += f" --user-data-dir={folder}/profile --virtual-time-budget=10000"
        command = [browser, *words.split(), page.as_uri()]
        opened = subprocess.run(command, capture_output=True, text=True, timeout=180, check=False)
    ready = re.search(r'data-ready="(\d+)"', opened.stdout)
    told = re.findall(r"CONSOLE.*", opened.stderr)
    milliseconds = int(ready[1]) if ready else None
    rows = [
        ("segments", "-", str(segments)),
        ("until it answers", f"≤ {ASKED_MS} ms", "never" if milliseconds is None else f"{milliseconds} ms"),
        ("lines on the console", "0", str(len(told))),
        ("size for 2,000 segments", f"≤ {ASKED_BYTES:,} bytes", f"{round(size * 2000 / segments):,}"),
    ]
    print("| figure | asked | measured |\n|---|---|---|")
    for row in rows:
        print("| " + " | ".join(row) + " |")
    for line in told:
        print(line)
    held = (
        milliseconds is not None
        and milliseconds <= ASKED_MS
        and not told
        and size * 2000 / segments <= ASKED_BYTES
    )
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
