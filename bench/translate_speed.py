"""How fast programs are read, converted and written: all pairs of languages, and each language into itself.

    python bench/translate_speed.py [--moves N] [--varied] [--from VENDOR] [--to VENDOR] [--profile]

One program of N straight moves, each to a point of its own, in all five languages. Prints moves per CPU second of
reading, converting and writing together, the best of three; the plans are not compared (bench/translate.py does that).
With --varied every move has a speed of its own, the blends change, and every seventh is a joint move, whose speed is
converted with the run of the program.
"""

from __future__ import annotations

import argparse
import gc
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "bench"), str(ROOT / "tests")]

from translate import ROBOT, _long_job  # noqa: E402
from translate_programs import written  # noqa: E402
from translated_texts import VENDORS  # noqa: E402

import olp  # noqa: E402
from olp.robots.robot import Robot, load_robot  # noqa: E402
from olp.transpile import Context  # noqa: E402
from olp.transpile.convert import convert  # noqa: E402
from olp.transpile.link import link  # noqa: E402

ASKED, ASKED_OWN = 15_000, 40_000  # moves/s: between languages, and INFORM alone


def varied(job: bytes) -> bytes:
    """The job with a speed of its own for every move, all levels, and joint moves among the straight ones."""
    rows, n = job.decode().split("\r\n"), 0
    for at, row in enumerate(rows):
        if row.startswith("MOVL "):
            point = row.split()[1]
            joint = f"MOVJ {point} VJ={1 + n % 9000 / 100:.2f} PL={n % 9}"
            rows[at] = joint if n % 7 == 0 else f"MOVL {point} V={20 + n * 0.05:.2f} PL={n % 9}"
            n += 1
    return "\r\n".join(rows).encode()


def programs(moves: int, folder: Path, robot: Robot, vary: bool = False) -> dict[str, Path]:
    """The same program in every language: the file that runs."""
    job = folder / "LONG.JBI"
    job.write_bytes(varied(_long_job(moves)) if vary else _long_job(moves))
    files = {"inform": job}
    program = olp.read(job)
    for vendor in VENDORS:
        if vendor != "inform":
            made = convert(program, vendor, Context(robot=robot))
            written(made, vendor, folder / vendor)
            files[vendor] = folder / vendor / made.main
    return files


def seconds(file: Path, source: str, target: str, robot: Robot) -> float:
    """CPU time of one reading, converting and writing."""
    gc.collect()
    start = time.process_time()
    # A language whose files hold fewer moves has them in several, which are read and translated together.
    convert(link(olp.read(file, vendor=source)).program, target, Context(robot=robot))
    return time.process_time() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--moves", type=int, default=20_000)
    parser.add_argument("--varied", action="store_true", help="every move with a speed of its own")
    parser.add_argument("--from", dest="source", choices=VENDORS)
    parser.add_argument("--to", dest="target", choices=VENDORS)
    parser.add_argument("--repeat", type=int, default=3, help="the best of so many")
    parser.add_argument("--profile", action="store_true", help="where the time goes, by function")
    chosen = parser.parse_args()
    robot = load_robot(ROBOT)
    with tempfile.TemporaryDirectory() as folder:
        files = programs(chosen.moves, Path(folder), robot, chosen.varied)
        print(f"{chosen.moves:,} moves: moves per CPU second of read + convert + write\n")
        print(f"{'from':<10}{'to':<10}{'moves/s':>10}{'asked':>10}")
        for source in VENDORS if chosen.source is None else (chosen.source,):
            for target in VENDORS if chosen.target is None else (chosen.target,):
                if chosen.profile:
                    _profile(files[source], source, target, robot)
                    continue
                best = min(seconds(files[source], source, target, robot) for _ in range(chosen.repeat))
                asked = ASKED_OWN if source == target == "inform" else ASKED
                print(f"{source:<10}{target:<10}{chosen.moves / best:>10,.0f}{asked:>10,}", flush=True)


def _profile(file: Path, source: str, target: str, robot: Robot) -> None:
    import cProfile
    import pstats

    seconds(file, source, target, robot)
    with cProfile.Profile() as profile:
        seconds(file, source, target, robot)
    print(f"\n{source} {target}")
    pstats.Stats(profile).sort_stats("tottime").print_stats(45)


if __name__ == "__main__":
    main()
