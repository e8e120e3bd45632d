"""The blind proof in one command: python bench/concealed/run.py --seed-set dev --cases 400 --jobs 2

Generates the cases (once; they are kept), diagnoses every one of them, opens the answers and prints the tables.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT))
sys.path = [p for p in sys.path if Path(p).resolve() != Path(__file__).resolve().parent]

from bench.concealed.batch import SEEDS, generate_all  # noqa: E402
from bench.concealed.score import run  # noqa: E402


def main() -> int:
    parser = argparse.ArgumentParser(prog="bench/concealed/run.py", description=__doc__)
    parser.add_argument("--seed-set", choices=SEEDS, default="dev")
    parser.add_argument("--cases", type=int, default=400)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--families", nargs="*", default=())
    parser.add_argument("--limit", type=int, default=0, help="diagnose only the first of them")
    parser.add_argument("--folder", type=Path, default=None, help="where the cases are kept")
    parser.add_argument("--fake", default="", help="oracle, jerk or nothing in place of olp diagnose")
    parser.add_argument("--again", action="store_true", help="score the diagnoses that are there")
    parser.add_argument("--no-baselines", dest="baselines", action="store_false")
    parser.add_argument("--table", type=Path, help="write the tables as Markdown")
    args = parser.parse_args()
    args.folder = args.folder or Path(tempfile.gettempdir()) / f"olp-concealed-{args.seed_set}-{args.cases}"
    seed = SEEDS[args.seed_set]
    if not (args.folder / "sealed").is_dir():
        generate_all(seed, args.cases, args.folder, args.jobs, tuple(args.families))
    print(f"seed set {args.seed_set} ({seed}), {args.cases} cases, {args.folder}\n")
    return run(args)


if __name__ == "__main__":
    sys.exit(main())
