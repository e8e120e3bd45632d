"""Translations between all languages: the sample program in all directions, and random programs there and back.

    python bench/translate.py [--count N] [--first SEED] [--between LANGUAGE LANGUAGE] [--moves N]

Prints three tables: for the sample each direction's worst difference of position, orientation, speed and blend, and
what its receipt names; for N random programs of each language and target how many come back with an equal plan, but
for what the receipts name; and moves per CPU second for reading, converting and writing a program of many moves.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from translate_programs import round_trip, written  # noqa: E402
from translated_texts import VENDORS  # noqa: E402

import olp  # noqa: E402
from olp.core.diagnostic import OlpError  # noqa: E402
from olp.robots.robot import load_robot  # noqa: E402
from olp.transpile import Context  # noqa: E402
from olp.transpile.compare import compare_plans  # noqa: E402
from olp.transpile.convert import convert, run_converted  # noqa: E402
from olp.transpile.link import link  # noqa: E402

SAMPLES = {
    "inform": "inform/handling/HANDLING.JBI",
    "krl": "krl/handling.src",
    "rapid": "rapid/handling.mod",
    "tp": "tp/handling.ls",
    "urscript": "urscript/handling.script",
}
ROBOT = "yaskawa/gp25"


def directions() -> None:
    robot = load_robot(ROBOT)
    print(
        f"{'direction':<20}{'mm':>10}{'deg':>10}{'speed':>10}{'blend mm':>10}  differs, named by the receipt"
    )
    for source, path in SAMPLES.items():
        program = link(olp.read(ROOT / "samples" / path)).program
        plan = program.plan(robot=robot)
        for target in VENDORS:
            if target == source:
                continue
            made = convert(program, target, Context(robot=robot, on_loss="comment"))
            left_out = {loss.line for loss in made.translated.losses if loss.leaves_out}
            found = compare_plans(plan, run_converted(made, target, robot, program), without=left_out)
            parts = sorted({loss.part for loss in made.translated.losses if not loss.leaves_out})
            print(
                f"{source + ' ' + target:<20}{found.worst_position * 1e3:>10.1e}{found.worst_angle * 57.3:>10.1e}"
                f"{found.worst_speed:>10.1e}{found.worst_blend * 1e3:>10.2g}  "
                f"{'; '.join(found.differences[:2]) or 'nothing'}; {', '.join(parts) or 'exact'}"
            )


def round_trips(seeds: range, between: set[str]) -> int:
    robot = load_robot(ROBOT)
    print(f"\n{'there and back':<20}{'equal':>12}")
    bad = 0
    for source in VENDORS:
        for target in VENDORS:
            if target == source or not {source, target} <= between:
                continue
            failed = [seed for seed in seeds if _differs(seed, source, target, robot)]
            bad += len(failed)
            equal = len(seeds) - len(failed)
            print(f"{source + ' ' + target:<20}{equal:>6}/{len(seeds):<5}{failed[:6] or ''}", flush=True)
    return bad


def _differs(seed: int, source: str, target: str, robot: object) -> bool:
    try:
        return bool(round_trip(seed, source, target, robot))
    except (OlpError, AssertionError):
        return True


def speed(moves: int) -> None:
    robot = load_robot(ROBOT)
    context = Context(robot=robot)
    job = _long_job(moves)
    print(f"\n{moves:,} moves read, converted and written, moves per CPU second")
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        texts = {}
        (place / "LONG.JBI").write_bytes(job)
        texts["inform"] = place / "LONG.JBI"
        program = olp.read(texts["inform"])
        for vendor in VENDORS[1:]:
            made = convert(program, vendor, context)
            written(made, vendor, place / vendor)
            texts[vendor] = place / vendor / made.main
        for source in VENDORS:
            for target in VENDORS:
                start = time.process_time()
                convert(olp.read(texts[source], vendor=source), target, context)
                print(f"{source + ' ' + target:<20}{moves / (time.process_time() - start):>10,.0f}")


def _long_job(moves: int) -> bytes:
    rows = [
        "/JOB", "//NAME LONG", "//POS", f"///NPOS {moves},0,0,0,0,0", "///USER 1", "///TOOL 1", "///POSTYPE USER",
        "///RECTAN", "///RCONF 1,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0",
    ]  # fmt: skip
    for n in range(moves):
        x, y, z = 100 + n % 173 * 0.731, -50 + n % 97 * 1.117, 20 + n % 31 * 0.913
        rows.append(f"C{n:05d}={x:.3f},{y:.3f},{z:.3f},178.{n % 997:04d},3.2500,-21.5000")
    rows += ["//INST", "///DATE 2026/03/02 14:07", "///ATTR SC,RW", "///GROUP1 RB1", "NOP"]
    rows += [f"MOVL C{n:05d} V={50 + n % 400}.0 PL={n % 3}" for n in range(moves)]
    return "".join(f"{row}\r\n" for row in [*rows, "END"]).encode()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=20, help="random programs per pair")
    parser.add_argument("--first", type=int, default=0, help="the first program's seed")
    parser.add_argument(
        "--between", nargs=2, choices=VENDORS, default=VENDORS, help="these two languages alone"
    )
    parser.add_argument("--moves", type=int, default=0, help="length of the program for the speed table")
    arguments = parser.parse_args()
    directions()
    seeds = range(arguments.first, arguments.first + arguments.count)
    wrong = round_trips(seeds, set(arguments.between))
    if arguments.moves:
        speed(arguments.moves)
    sys.exit(1 if wrong else 0)
