"""`python -m bench.fifth_author generate FOLDER --seed S --cases N`, `… score FOLDER [CASE…]`."""

import argparse
from pathlib import Path

from .score import score
from .sealing import generate


def main() -> None:
    """Parse the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("action", choices=["generate", "score"])
    parser.add_argument("folder", type=Path)
    parser.add_argument("only", nargs="*")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cases", type=int, default=40)
    told = parser.parse_args()
    if told.action == "generate":
        generate(told.folder, told.seed, told.cases)
    else:
        score(told.folder, told.only)


if __name__ == "__main__":
    main()
