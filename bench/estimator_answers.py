"""Writes tests/data/estimator_answers.json: what every estimator of signatures says of moves of all kinds.

    python bench/estimator_answers.py

`check_estimator` compares with it. Write it again only when a method is meant to answer otherwise: whoever has a
signature then gets other times from it.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

from olp.contracts.estimators import ANSWERS, ROBOT, answers_of
from olp.identification.signature.estimator import estimator_names, load_estimator
from olp.robots.robot import load_robot

if __name__ == "__main__":
    robot = load_robot(ROBOT)
    answers = {name: answers_of(load_estimator(name), robot) for name in estimator_names()}
    rows = [f"{json.dumps(name)}: {json.dumps(one, ensure_ascii=False)}" for name, one in answers.items()]
    ANSWERS.write_text("{\n" + ",\n".join(rows) + "\n}\n", encoding="utf-8", newline="\n")
