"""Diagnoses written cases and compares the answers with the truth beside them; and how long that takes."""

import json
import resource
import subprocess
import sys
from argparse import ArgumentParser, Namespace
from collections import defaultdict
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from bench.third_author.cases import write_case
from olp.core.diagnostic import OlpError
from olp.identification.diagnosis.diagnose import diagnose_recording
from olp.identification.recording import read_recording

SAME = {"override": {"speed-scale"}}  # the contract's name of what this author calls otherwise
VERDICTS = {"nothing": {"no-mismatch"}, "outside": {"unexplained"}}
SCATTER = {"turning-back", "taught-elsewhere"}  # outside effects that columns cannot tell from scatter


def answer(case: Path, out: Path) -> dict:
    """The answer that `olp diagnose --json` writes, by the code as it is, also left in `out`; a recording that is
    refused has an answer without names."""
    try:
        said = diagnose_recording(read_recording(case)).diagnosis.to_json()
    except OlpError as refused:
        said = {"findings": [], "verdict": "refused", "says": str(refused)}
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(json.dumps(said))
    return json.loads(out.read_text())


def judge(truth: dict, said: dict) -> dict:
    """One case's row: names, verdict, numbers and moves, each right, wrong or not asked."""
    outside = truth["family"] == "outside"
    hidden = [] if outside else [effect["term"] for effect in truth["effects"]]
    optional = set(truth["optional"])
    groups = [set(group) for group in said.get("indistinguishable", [])]
    stated = [finding["term"] for finding in said["findings"]]

    def means(term: str) -> set[str]:
        """The hidden names that a stated one may stand for."""
        words = {term}.union(*(group for group in groups if term in group))
        return {
            h for h in hidden if words & ({h} | SAME.get(h, set()) | set(truth["equivalents"].get(h, ())))
        }

    met: dict[str, dict] = {}
    false = []
    for finding in said["findings"]:
        fits = means(finding["term"]) - set(met)
        exact = [h for h in fits if h == finding["term"]] or sorted(fits)
        if exact:
            met[exact[0]] = finding
        elif finding["term"] not in optional and not (truth["condition"] and means(finding["term"])):
            false.append(finding["term"])
    row = {
        "family": truth["family"], "hidden": hidden or [e["term"] for e in truth["effects"]], "stated": stated,
        "first": bool(stated and means(stated[0])) if hidden else None,
        "exact": set(hidden) - optional <= set(met) and not false,
        "false": false, "verdict": said["verdict"],
        "right": said["verdict"] in _verdicts(truth),
        "noise_ms": 1000 * truth["noise_s"], "recorder": truth["recorder"], "condition": truth["condition"],
        "ratio": None, "f1": None, "intervals": [],
    }  # fmt: skip
    after = (said.get("fit") or {}).get("heldout_after") or {}
    if hidden and after.get("rmse_s") is not None:
        row["ratio"] = after["rmse_s"] / truth["noise_s"]
    for effect in truth["effects"] if not outside else []:
        found = met.get(effect["term"])
        if found is None:
            continue
        if found["term"] == effect["term"]:
            row["intervals"] += list(_intervals(effect, found))
        if truth["condition"]:
            same = [f for f in said["findings"] if f["term"] == found["term"]]
            row["f1"] = _f1(set(effect["moves"]), set().union(*(f["moves"] for f in same)))
    return row


def _verdicts(truth: dict) -> set[str]:
    """Those that are right."""
    right = VERDICTS.get(truth["family"], {"explained"})
    if SCATTER & {effect["term"] for effect in truth["effects"]}:
        right = right | {"no-mismatch"}
    # An error that lasts for some moves is a pattern that no column tells from a cause.
    slow = {"unexplained"} if truth["family"] == "nothing" else {"partly-explained"}
    return right | slow if truth["recorder"] == "slow" else right


def _intervals(effect: dict, found: dict):
    for name, number in effect["numbers"].items():
        given = found["parameters"].get(name)
        if given and given.get("ci95") and None not in given["ci95"]:
            low, high = given["ci95"]
            yield bool(low <= number <= high)


def _f1(truth: set[int], said: set[int]) -> float:
    return 2 * len(truth & said) / max(len(truth) + len(said), 1)


def table(rows: list[dict]) -> str:
    """The figures by family, one line each; `ratio`: unseen error over noise, mean of those called explained."""
    by = defaultdict(list)
    for row in rows:
        by[row["family"]].append(row)
    by["all"] = rows
    lines = [_line("family", "cases", "first", "exact", "false", "verdict", "ratio", "F1", "intervals")]
    for family, group in by.items():
        firsts = [row["first"] for row in group if row["first"] is not None]
        ratios = [row["ratio"] for row in group if row["ratio"] is not None and row["verdict"] == "explained"]
        f1 = [row["f1"] or 0.0 for row in group if row["condition"]]
        inside = [held for row in group for held in row["intervals"]]
        exact, right = [row["exact"] for row in group], [row["right"] for row in group]
        false = sum(bool(row["false"]) for row in group)
        means = [f"{np.mean(values):.2f}" if values else "-" for values in (ratios, f1)]
        lines.append(
            _line(family, len(group), _of(firsts), _of(exact), false, _of(right), *means, _of(inside))
        )
    return "\n".join(lines)


def _line(*cells: object) -> str:
    return " ".join(f"{cell!s:>9}" for cell in cells)


def _of(hits: list[bool]) -> str:
    return f"{sum(hits)}/{len(hits)}"


def score(folder: Path, verbose: bool = True) -> str:
    """Diagnoses and judges all cases of a folder; FOLDER/answers holds the answers of the last time."""
    rows = []
    for path in sorted((folder / "truth").glob("*.json")):
        truth = json.loads(path.read_text())
        said = answer(folder / "cases" / path.stem, folder / "answers" / path.name)
        row = judge(truth, said) | {"case": path.stem}
        rows.append(row)
        if verbose and not (row["exact"] and row["right"]):
            ratio = f"{row['ratio']:.2f}" if row["ratio"] else ""
            where = row["condition"] or ""
            print(
                path.stem,
                *(row[k] for k in ("family", "recorder", "hidden", "stated", "verdict")),
                ratio,
                where,
            )
    (folder / "rows.json").write_text(json.dumps(rows, indent=1))
    return table(rows)


# --- The command line of an author's cases ---


def commands(name: str, says: str | None, cases: int) -> tuple[ArgumentParser, Any]:
    """The parser with `generate` and `score`, and what further commands are added to. `cases`: how many by default."""
    parser = ArgumentParser(prog=name, description=says)
    choices = parser.add_subparsers(dest="command", required=True)
    making = choices.add_parser("generate", help="write recordings, and the truth beside them")
    making.add_argument("folder", type=Path)
    making.add_argument("--seed", type=int, required=True)
    making.add_argument("--cases", type=int, default=cases)
    judging = choices.add_parser("score", help="run olp diagnose on them and print what it got right")
    judging.add_argument("folder", type=Path)
    return parser, choices


def run(args: Namespace, generate: Callable[[Path, int, int], object]) -> None:
    """Does what `generate` or `score` asks."""
    if args.command == "generate":
        generate(args.folder, args.seed, args.cases)
    else:
        print(score(args.folder))


# --- Speed ---
# CPU seconds of `olp diagnose`, each in a process of its own, start and imports included.

_HIDDEN = ("nothing", "one", "two")  # families


def speed(seed: int, counts: Sequence[int]) -> None:
    """Prints a row per number of moves and family."""
    print("| moves | hidden | named | CPU s |\n|---|---|---|---|")
    for count in counts:
        for turn, family in enumerate(_HIDDEN):
            with TemporaryDirectory() as folder:
                case, out = Path(folder) / "case", Path(folder) / "answer.json"
                truth = write_case(case, np.random.default_rng([seed, count, turn]), family, count)
                before = _used()
                command = (sys.executable, "-m", "olp", "diagnose", case, "--json", out)
                subprocess.run(command, check=True, capture_output=True)
                took = _used() - before
                named = [finding["term"] for finding in json.loads(out.read_text())["findings"]]
            hidden = [effect["term"] for effect in truth["effects"]]
            print(f"| {truth['moves']} | {_words(hidden)} | {_words(named)} | {took:.1f} |", flush=True)


def _words(names: Sequence[str]) -> str:
    return ", ".join(names) or "none"


def _used() -> float:
    """[s] CPU of all processes that were started and have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
