"""python -m bench.concealed generate | score: see docs/concealed.md."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from bench.concealed.batch import SEEDS, generate_all


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m bench.concealed")
    commands = parser.add_subparsers(dest="command", required=True)
    make = commands.add_parser("generate", help="write cases and sealed answers")
    make.add_argument("--seed", type=int)
    make.add_argument("--seed-set", choices=SEEDS, default="dev")
    make.add_argument("--cases", type=int, default=400)
    make.add_argument("--families", nargs="*", default=())
    make.add_argument("--moves", type=int, default=0, help="of every case; 0: as many as the case draws")
    make.add_argument("--jobs", type=int, default=2)
    make.add_argument("-o", "--output", type=Path, required=True)
    score = commands.add_parser("score", help="diagnose the cases of a folder and open the answers")
    score.add_argument("folder", type=Path)
    score.add_argument("--jobs", type=int, default=2)
    score.add_argument("--limit", type=int, default=0)
    score.add_argument("--families", nargs="*", default=())
    score.add_argument("--fake", default="", help="oracle, jerk or nothing in place of olp diagnose")
    score.add_argument("--again", action="store_true", help="score the diagnoses that are there")
    score.add_argument("--baselines", action="store_true")
    score.add_argument("--table", type=Path, help="write the tables as Markdown")
    args = parser.parse_args()
    if args.command == "generate":
        seed = SEEDS[args.seed_set] if args.seed is None else args.seed
        names = generate_all(seed, args.cases, args.output, args.jobs, tuple(args.families), args.moves)
        print(f"seed {seed}: {len(names)} cases in {args.output}")
        return 0
    from bench.concealed.score import run

    return run(args)


if __name__ == "__main__":
    sys.exit(main())
