"""`olp diagnose` on a folder of made-up recordings whose causes are known: how often it is right, and how surely.

    python bench/made_up.py FOLDER [--jobs 2] [--only 001,002] [--modes plain,nothing] [--failures] [--recorder stamps]

FOLDER holds a recording in each of its folders and `answers.json`: by name of the folder `mode` (what kind of case),
`terms` (what is hidden), `moves` (numbers of those in which it acts, or null), `noise_s`, `resolution_s`.
Modes `nothing`, `clock` and `outside` hide no physics; all others do. A name that the diagnosis itself declares
indistinguishable from a hidden one counts as that one. A recorder adds its fault to the durations that are written
there: "stamps" shared by neighbours (what one move loses the next wins), "digits" of 10 ms, "heavy" tails, and, to
compare these with, "white" noise of the same size.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import os
import sys
import time
import zlib
from collections import defaultdict
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

CONTROLS = ("nothing", "clock", "outside")
SCATTER, DIGITS = 0.003, 0.01  # [s] that a recorder adds
ADDED = {
    "": 0.0,
    "stamps": SCATTER * 2**0.5,
    "heavy": SCATTER * 3**0.5,
    "white": SCATTER * 3**0.5,
    "digits": DIGITS / 12**0.5,
}  # [s] as RMS
EXPLAINED, AGREES = 1.5, 2.0  # times the floor: what an explanation leaves at most, and an agreement


def diagnosed(folder: Path) -> tuple[dict[str, Any], float]:
    """The JSON answer, and CPU seconds."""
    from olp.identification.diagnosis.diagnose import diagnose_recording
    from olp.identification.recording import read_recording

    begin = time.process_time()
    told = diagnose_recording(read_recording(folder)).diagnosis.to_json()
    return told, time.process_time() - begin


def recorded(folder: Path, recorder: str, into: Path) -> Path:
    """The recording as another recorder writes it; of its own seed, so that each run sees the same."""
    import numpy as np

    table = list(csv.DictReader((folder / "moves.csv").read_text(encoding="utf-8").splitlines()))
    durations = np.array([float(row["duration_s"]) for row in table])
    rng = np.random.default_rng(zlib.crc32(folder.name.encode()))
    if recorder == "stamps":
        durations = durations + np.diff(SCATTER * rng.normal(size=len(table) + 1))
    elif recorder == "heavy":
        durations = durations + SCATTER * rng.standard_t(3, len(table))
    elif recorder == "white":
        durations = durations + ADDED["white"] * rng.normal(size=len(table))
    digits = DIGITS if recorder == "digits" else 1e-6
    durations = np.maximum(np.round(durations / digits), 1.0) * digits
    with open(into / "moves.csv", "w", newline="", encoding="utf-8") as file:
        rows = csv.DictWriter(file, list(table[0]))
        rows.writeheader()
        for row, duration in zip(table, durations.tolist(), strict=True):
            rows.writerow(row | {"duration_s": f"{duration:.6f}"})
    resolution = f"time_resolution_s = {DIGITS}\n" if recorder == "digits" else ""
    (into / "recording.toml").write_text(resolution, encoding="utf-8")
    return into


def scored(answer: dict[str, Any], told: dict[str, Any]) -> dict[str, float]:
    """Figure -> 1 or 0, or a number; only those that the case has a say in."""
    mode, want = answer["mode"], answer["terms"]
    found = [f["term"] for f in told["findings"]]
    groups = [set(g) for g in told["indistinguishable"]]

    def same(one: str, other: str) -> bool:
        return one == other or any({one, other} <= g for g in groups)

    extra = [f for f in found if not any(same(f, t) for t in want)]
    all_named = all(any(same(f, t) for f in found) for t in want)
    figures: dict[str, float] = {}
    if mode == "nothing":
        figures["nothing: silent"] = not found
    elif mode == "clock":
        figures["clock: clock or nothing"] = set(found) <= {"clock"}
    elif mode == "outside":
        figures["outside: unexplained"] = not found and told["verdict"] in ("unexplained", "partly-explained")
    elif len(want) > 1:
        figures["two effects: exactly these"] = all_named and not extra and len(found) == len(want)
    else:
        figures["one effect: first name"] = bool(found) and same(found[0], want[0])
        figures["one effect: no false name"] = not extra
        figures[f"{mode}: exact"] = all_named and not extra
    if answer.get("moves"):
        true = set(answer["moves"])
        got = {m for f in told["findings"] if any(same(f["term"], t) for t in want) for m in f["moves"]}
        figures["in a part of the space: F1 of the moves"] = 2 * len(got & true) / (len(got) + len(true))
    return {k: float(v) for k, v in (figures | _contradictions(answer, told)).items()}


def _contradictions(answer: dict[str, Any], told: dict[str, Any]) -> dict[str, float]:
    """What may never be; and what is left on unseen moves over the true scatter of a measured duration."""
    noise = math.hypot(answer["noise_s"], answer["resolution_s"] / math.sqrt(12.0))
    left, floor = told["unexplained"]["rmse_s"], told["data"]["noise_floor_s"]
    idle = any(
        f["evidence"]["heldout_rmse_after_s"] >= f["evidence"]["heldout_rmse_before_s"]
        for f in told["findings"]
    )
    figures = {
        "contradiction: explained above 1.5 floors": told["verdict"] == "explained"
        and left > EXPLAINED * floor * 1.001,
        "contradiction: agreement above 2 floors": told["verdict"] == "no-mismatch" and left > AGREES * floor,
        "contradiction: a name that helps no unseen move": idle,
    }
    if told["verdict"] == "explained":
        figures["explained: unseen error over noise, mean"] = told["fit"]["heldout_after"]["rmse_s"] / noise
    return figures


def _line(answer: dict[str, Any], told: dict[str, Any]) -> str:
    """One case in words."""
    held = " -> ".join(f"{told['fit'][k]['rmse_s'] * 1e3:.1f}" for k in ("heldout_before", "heldout_after"))
    found = [f["term"] + (f" where {f['condition']}" if f["condition"] else "") for f in told["findings"]]
    floor = told["data"]["noise_floor_s"] * 1e3
    return (
        f"{answer['mode']}: hidden {answer['terms']} named {found} alike {told['indistinguishable']} {told['verdict']} "
        f"{held} ms, floor {floor:.1f}"
    )


def _one(folder: Path, recorder: str) -> tuple[dict[str, Any] | str, float]:
    try:
        if not recorder:
            return diagnosed(folder)
        with TemporaryDirectory() as temporary:
            return diagnosed(recorded(folder, recorder, Path(temporary)))
    except Exception as failure:  # a case that ends in an error is a case that is wrong
        return f"{type(failure).__name__}: {failure}", 0.0


def make_cases(
    description: str | None, make: Callable[[Path, int, np.random.Generator], dict[str, Any]]
) -> None:
    """The command line of a script that makes such a folder.

    `make`: fills the folder of the case of a number, and returns its answer.
    """
    import numpy as np

    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cases", type=int, default=24)
    args = parser.parse_args()
    answers = {}
    for number in range(args.cases):
        name = f"{number:03d}"
        folder = args.folder / name
        folder.mkdir(parents=True, exist_ok=True)
        answers[name] = make(folder, number, np.random.default_rng([args.seed, number]))
        (folder / "recording.toml").write_text("time_resolution_s = 0.001\n", encoding="utf-8")
    (args.folder / "answers.json").write_text(json.dumps(answers, indent=1), encoding="utf-8")


def main(arguments: Iterable[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", default="", help="names of folders, with commas between")
    parser.add_argument("--modes", default="", help="kinds of cases, with commas between")
    parser.add_argument("--recorder", choices=tuple(ADDED), default="")
    parser.add_argument("--failures", action="store_true", help="only the cases that are not right")
    args = parser.parse_args(None if arguments is None else list(arguments))
    answers = json.loads((args.folder / "answers.json").read_text(encoding="utf-8"))
    names = [n for n in sorted(answers) if not args.only or n in args.only.split(",")]
    names = [n for n in names if not args.modes or answers[n]["mode"] in args.modes.split(",")]
    tally, seconds = defaultdict[str, list[float]](list), list[float]()
    with ProcessPoolExecutor(args.jobs) as pool:
        results = pool.map(_one, [args.folder / n for n in names], [args.recorder] * len(names))
        for name, (told, cpu) in zip(names, results, strict=True):
            answer = answers[name]
            answer |= {"noise_s": math.hypot(answer["noise_s"], ADDED[args.recorder])}
            seconds.append(cpu)
            if isinstance(told, str):
                tally["an answer"].append(0.0)
                print(f"{name} {answer['mode']} {answer['terms']}: {told}", flush=True)
                continue
            tally["an answer"].append(1.0)
            figures = scored(answer, told)
            for figure, value in figures.items():
                tally[figure].append(value)
            right = all(
                v == 1.0
                for k, v in figures.items()
                if "contradiction" not in k and "mean" not in k and "F1" not in k
            )
            right &= not any(v for k, v in figures.items() if "contradiction" in k)
            if not (right and args.failures):
                print(
                    f"{name} {'right' if right else 'WRONG'} {_line(answer, told)}, {cpu:.1f} s", flush=True
                )
    print()
    for figure in sorted(tally):
        values = tally[figure]
        print(f"{figure:<48} {sum(values) / len(values):6.3f}  ({len(values)})")
    print(f"{'CPU, mean and most [s]':<48} {sum(seconds) / len(seconds):6.1f}  {max(seconds):.1f}")


if __name__ == "__main__":
    main()
