"""Writes the nine jobs of this folder and, into moves.csv, which line of which job made each measured move.

    python samples/up20/make.py

The jobs hold nothing that is not in moves.csv: run it again after changing a speed or a header.
"""

from __future__ import annotations

import csv
import io
from pathlib import Path

HERE = Path(__file__).parent
TESTS = {"approach": "APPR", "depart": "DEPT", "downward": "DOWN"}
Row = dict[str, str]


def job_name(row: Row) -> str:
    """Test and start point in the eight characters an XRC allows: APPR-L, DOWN-2."""
    return f"{TESTS[row['test']]}-{row['start'].removeprefix('TOP_')[0]}"


def position(row: Row, end: str) -> str:
    """A point as RECTAN writes it: millimetres with three decimals, degrees with four."""
    mm = [f"{float(row[f'{axis}_{end}_mm']):.3f}" for axis in "xyz"]
    deg = [f"{float(row[f'r{axis}_deg']):.4f}" for axis in "xyz"]
    return ",".join(mm + deg)


def job_lines(name: str, rows: list[Row]) -> tuple[list[str], list[int]]:
    """A job that visits every target from the start point and back, and the lines of the measured moves."""
    start = position(rows[0], "start")
    points = [start, *(p for row in rows for p in (position(row, "end"), start))]
    lines = ["/JOB", f"//NAME {name}", "//POS", f"///NPOS {len(points)},0,0,0,0,0", "///TOOL 0"]
    lines += ["///POSTYPE ROBOT", "///RECTAN", "///RCONF " + ",".join(24 * "0")]
    lines += [f"C{i:05d}={point}" for i, point in enumerate(points)]
    lines += ["//INST", "///DATE 2026/11/20 10:00", "///COMM " + f"TABLE {rows[0]['table']}"]
    lines += ["///ATTR SC,RW", "///GROUP1 RB1", "NOP"]
    lines += [f"'{rows[0]['test']} from {rows[0]['start']}", "MOVJ C00000 VJ=12.50 PL=0"]
    measured = []
    for i, row in enumerate(rows):
        speed = f"V={float(row['speed_mm_s']):.1f} PL=0"
        measured.append(len(lines) + 1)
        lines += [f"MOVL C{2 * i + 1:05d} {speed}", f"MOVL C{2 * i + 2:05d} {speed}"]
    return [*lines, "END"], measured


def make(moves: str) -> dict[str, str]:
    """The texts of all files made from the text of moves.csv, by file name, moves.csv among them."""
    rows = list(csv.DictReader(io.StringIO(moves)))
    fans: dict[str, list[Row]] = {}
    for row in rows:
        fans.setdefault(job_name(row), []).append(row)
    files = {}
    for name, fan in fans.items():
        lines, measured = job_lines(name, fan)
        files[f"{name}.JBI"] = "".join(f"{line}\r\n" for line in lines)
        for row, line in zip(fan, measured, strict=True):
            row |= {"job": f"{name}.JBI", "line": str(line)}
    table = io.StringIO()
    writer = csv.DictWriter(table, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return files | {"moves.csv": table.getvalue()}


def main() -> None:
    """Writes the files next to this script."""
    for name, text in make((HERE / "moves.csv").read_text("utf-8")).items():
        (HERE / name).write_bytes(text.encode("ascii"))


if __name__ == "__main__":
    main()
