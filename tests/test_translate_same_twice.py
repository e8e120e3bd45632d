"""One program has one translation and one receipt, whatever order Python keeps a set in."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
SCRIPT = """
import sys
from olp.fluent import read_source
from olp.core.source import decode
from olp.transpile import Context
from olp.transpile.convert import convert
text = open(sys.argv[1], encoding="ascii").read()
for target in ("inform", "rapid", "tp", "urscript"):
    made = convert(read_source(decode(text.encode(), "part.src"), vendor="krl"), target,
                   Context(on_loss="comment"), date="2026/01/01 00:00")
    print(sorted(made.files.items()), made.translated.losses, made.translated.notes)
"""
PROGRAM = """DEF PART ( )
DECL E6POS A1P, A2P, A3P
A1P=XONE:XTWO:XTHREE
A2P=XTHREE:XONE
A3P=A1P:A2P:XFOUR
LIN A3P
LIN A2P:A1P
nOut=nA+nB+nC
WAIT SEC nOut
END
"""


def test_receipts_do_not_depend_on_the_seed_of_hashes(tmp_path):
    path = tmp_path / "part.src"
    path.write_text(PROGRAM)
    told = set()
    for seed in ("0", "1", "2", "3"):
        environment = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": str(ROOT)}
        command = [sys.executable, "-c", SCRIPT, str(path)]
        done = subprocess.run(command, capture_output=True, text=True, env=environment, check=True)
        told.add(done.stdout)
    assert len(told) == 1
