"""Recordings with sealed causes: `generate FOLDER --seed S --cases N` writes them, `score FOLDER` judges answers.

`speed --seed S --moves 100 300 600` prints the CPU of `olp diagnose` for none, one and two effects.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from bench.third_author.cases import generate
from bench.third_author.scoring import commands, run, speed

parser, choices = commands("third_author", __doc__, cases=80)
timing = choices.add_parser("speed", help="print the CPU seconds of olp diagnose")
timing.add_argument("--seed", type=int, required=True)
timing.add_argument("--moves", type=int, nargs="+", default=[100, 300, 600])
args = parser.parse_args()
if args.command == "speed":
    speed(args.seed, args.moves)
else:
    run(args, generate)
