"""A sixth author's recordings: `generate FOLDER --seed S --cases N` writes them, and the truth beside them.

`score FOLDER` judges the answers to them as `bench.third_author` does.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from bench.sixth_author.cases import generate
from bench.third_author.scoring import commands, run

parser, _ = commands("sixth_author", __doc__, cases=40)
run(parser.parse_args(), generate)
