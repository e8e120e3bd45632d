"""Run `olp diagnose` on sealed cases and compare its answers with what is sealed."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

Answer = dict[str, object]


def run_case(folder: Path, out: Path) -> tuple[dict[str, object], str, float]:
    """The answer, the last line of errors, and the seconds."""
    begun = time.monotonic()
    command = [sys.executable, "-m", "olp", "diagnose", str(folder), "--json", str(out)]
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, env={**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    )
    spent = time.monotonic() - begun
    errors = done.stderr.strip().splitlines()
    if "Traceback" in done.stderr or not out.exists():
        return {}, errors[-1] if errors else f"status {done.returncode}", spent
    return json.loads(out.read_text()), "", spent


def judge(truth: dict, answer: dict, error: str) -> dict:
    """First name, exact set, false names, verdict, error over noise, intervals."""
    hidden = set(truth["names"])
    found = [f["term"] for f in answer.get("findings", [])]
    alike = [set(pair) for pair in answer.get("indistinguishable", [])]
    stands = {}
    for name in found:
        declared = [h for h in hidden if h not in found and any({name, h} <= a for a in alike)]
        stands[name] = name if name in hidden else declared[0] if declared else None
    false = [n for n in found if stands[n] is None]
    covered = {v for v in stands.values() if v}
    exact = covered == hidden and not false
    verdict = answer.get("verdict", error or "none")
    wanted = {"nothing": ["no-mismatch"], "outside": ["unexplained"]}.get(truth["family"], ["explained"])
    held = (answer.get("fit") or {}).get("heldout_after") or {}
    result = {
        "found": found,
        "false": false,
        "exact": exact,
        "verdict": verdict,
        "verdict_right": verdict in wanted,
    }
    result["first"] = bool(found) and stands[found[0]] is not None
    result["unseen"] = (
        held.get("rmse_s", float("nan")) / truth["sigma"] if held.get("rmse_s") is not None else float("nan")
    )
    result["intervals"] = _intervals(truth, answer)
    result["error"] = error
    return result


def _intervals(truth: dict, answer: dict) -> list[tuple[str, float, list[float], bool]]:
    told = []
    for finding in answer.get("findings", []):
        for key, value in truth["numbers"].get(finding["term"], {}).items():
            number = finding["parameters"].get(key)
            if number and number.get("ci95") and None not in number["ci95"]:
                low, high = number["ci95"]
                told.append((f"{finding['term']}.{key}", value, [low, high], low <= value <= high))
    return told


def score(folder: Path, only: list[str]) -> None:
    """Print a line per case, and the totals."""
    truths = json.loads((folder / "answers.json").read_text())
    results = {}
    for name, truth in truths.items():
        if only and name not in only:
            continue
        answer, error, spent = run_case(folder / name, folder / f"{name}.answer.json")
        r = results[name] = judge(truth, answer, error)
        print(_line(name, truth, r, spent), flush=True)
    totals(truths, results)


def _line(name: str, truth: dict, r: dict, spent: float) -> str:
    """A case and its answer in one line; X where the names are wrong, v where only the verdict is."""
    mark = "X" if not r["exact"] else " " if r["verdict_right"] else "v"
    hidden, told = ",".join(truth["numbers"]) or "-", ",".join(r["found"]) or "-"
    missed = [f"{key}={v:.4g} not in {ci[0]:.4g}..{ci[1]:.4g}" for key, v, ci, ok in r["intervals"] if not ok]
    where = f"{truth['family']:8s}{truth['cell']:10s}{truth['moves']:4d}"
    sizes = f"size {truth['rms'] / truth['sigma']:.1f} unseen {r['unseen']:.2f}"
    cause = f"{hidden} [{truth.get('condition') or ''}]"
    return " ".join(
        [mark, name, where, cause, "->", told, r["verdict"], sizes, f"{spent:.0f}s", *missed, r["error"]]
    )


def totals(truths: dict, results: dict) -> None:
    """Print the figures of the table."""
    named = [n for n in results if truths[n]["names"]]
    held = [ok for r in results.values() for *_, ok in r["intervals"]]
    explained = sorted(
        r["unseen"] for r in results.values() if r["verdict"] == "explained" and r["unseen"] == r["unseen"]
    )
    print("first name", sum(results[n]["first"] for n in named), "of", len(named))
    print("exact set", sum(r["exact"] for r in results.values()), "of", len(results))
    print("false names", sum(len(r["false"]) for r in results.values()))
    print("verdict", sum(r["verdict_right"] for r in results.values()), "of", len(results))
    print(
        "unseen error / noise, median",
        f"{explained[len(explained) // 2]:.2f}" if explained else "-",
        "above 1.2:",
        sum(u > 1.2 for u in explained),
        "of",
        len(explained),
    )
    print("intervals", sum(held), "of", len(held))
    print("errors", sum(bool(r["error"]) for r in results.values()))
