"""Recordings with sealed causes: `generate FOLDER --seed S --cases N` writes them, `score FOLDER` judges answers.

`speed --seed S --moves 100 300 600` prints the CPU of `olp diagnose` for none, one and two effects.
"""

import argparse
import os
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from bench.third_author.cases import generate
from bench.third_author.scoring import score, speed

parser = argparse.ArgumentParser(prog="third_author", description=__doc__)
commands = parser.add_subparsers(dest="command", required=True)
making = commands.add_parser("generate", help="write recordings, and the truth beside them")
making.add_argument("folder", type=Path)
making.add_argument("--seed", type=int, required=True)
making.add_argument("--cases", type=int, default=80)
judging = commands.add_parser("score", help="run olp diagnose on them and print what it got right")
judging.add_argument("folder", type=Path)
timing = commands.add_parser("speed", help="print the CPU seconds of olp diagnose")
timing.add_argument("--seed", type=int, required=True)
timing.add_argument("--moves", type=int, nargs="+", default=[100, 300, 600])
args = parser.parse_args()
if args.command == "generate":
    generate(args.folder, args.seed, args.cases)
elif args.command == "speed":
    speed(args.seed, args.moves)
else:
    print(score(args.folder))
