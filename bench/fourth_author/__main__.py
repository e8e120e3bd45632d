"""A fourth author's recordings: `generate FOLDER --seed S --cases N` writes them, and the truth beside them.

`score FOLDER` judges the answers to them as `bench.third_author` does.
"""

import argparse
import os
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from bench.fourth_author.cases import generate
from bench.third_author.scoring import score

parser = argparse.ArgumentParser(prog="fourth_author", description=__doc__)
commands = parser.add_subparsers(dest="command", required=True)
making = commands.add_parser("generate", help="write recordings, and the truth beside them")
making.add_argument("folder", type=Path)
making.add_argument("--seed", type=int, required=True)
making.add_argument("--cases", type=int, default=60)
judging = commands.add_parser("score", help="run olp diagnose on them and print what it got right")
judging.add_argument("folder", type=Path)
args = parser.parse_args()
if args.command == "generate":
    generate(args.folder, args.seed, args.cases)
else:
    print(score(args.folder))
