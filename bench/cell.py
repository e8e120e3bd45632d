"""How long a cell of real programs takes: `olp time` and `olp report` on a folder, the page's size, and both totals.

python bench/cell.py FOLDER [--robot R]
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path


def measured(*words: str) -> tuple[float, str]:
    """Wall time [s] of a command of olp, and what it printed. Status 2 is an answer with something left open."""
    begin = time.perf_counter()
    done = subprocess.run([sys.executable, "-m", "olp", *words], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 2):
        sys.exit(done.stderr)
    return time.perf_counter() - begin, done.stdout


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder")
    parser.add_argument("--robot")
    args = parser.parse_args()
    robot = ["--robot", args.robot] if args.robot else []
    seconds, text = measured("time", args.folder, *robot)
    programs = json.loads(measured("time", args.folder, "--summary", "--format", "json", *robot)[1])
    total = sum(one["total_s"] or 0.0 for one in programs if one["started"])
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "page.html"
        drawn, _ = measured("report", args.folder, "-o", str(page), *robot)
        html = page.read_text("utf-8")
    said = re.search(r"controller starts</dt><dd>(?:at least )?([\d.]+) s", html)
    rows = [
        ("programs", f"{len(programs)}, {sum(one['started'] for one in programs)} of them started"),
        ("olp time", f"{seconds:.1f} s, {len(text):,} characters"),
        ("olp report", f"{drawn:.1f} s, {len(html.encode()) / 1e6:.2f} MB"),
        ("total of time; of the report", f"{total:.3f}; {said[1] if said else 'not found'} s"),
    ]
    for name, value in rows:
        print(f"| {name} | {value} |")
    return 0 if said and abs(float(said[1]) - total) < 1e-3 else 1


if __name__ == "__main__":
    sys.exit(main())
