"""Plants deliberate faults into readers, writers and the translation, one at a time: the tests catch every one.

    python bench/faults.py [--vendor V] [--only TEXT] [--jobs N] [--learn]
    python bench/faults.py --contracts [KIND] [--only MEMBER] [--count N] [--seed S] [--code]

The project is copied into a temporary folder, and nothing else is touched. Each row of `fault_rows` replaces one text
of the copy, tests run up to the first failure, and the text is put back. The test that caught the fault last time
(`fault_rows/caught_by.json`, written by --learn) comes first; where it passes, the fast tests of that language follow,
and then those of the translation. Exit status 1 when a fault survives; 2 when a row no longer fits the code, when its
fault is a mere crash that any run would show, or when the tests fail without any fault.

With --contracts faults are planted in each member of each kind (languages, writers, terms, models, estimators, robots,
commands, hosts, reports; or of one KIND), and the contract suite of that kind alone has to notice.
Exit status 1 when less than 98 % are caught.
"""

from __future__ import annotations

import argparse
import json
import os
import queue
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Final, NamedTuple

import contract_faults
from fault_rows import Fault, inform, krl, rapid, tp, translate, urscript

ROOT: Final = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
COPIED: Final = ("olp", "grammars", "templates", "samples", "tests", "docs", "pyproject.toml")
LIMIT: Final = 300  # [s] for the tests of one fault
KNOWN: Final = (
    ROOT / "bench" / "fault_rows" / "caught_by.json"
)  # part/file: what breaks -> the test that said so
# A failing example is enough: making it small takes minutes.
_CONFTEST: Final = """from hypothesis import Phase, settings

settings.register_profile("faults", phases=(Phase.explicit, Phase.generate), database=None)
settings.load_profile("faults")
"""
_SUMMARY: Final = re.compile(r"^(?:FAILED|ERROR) tests/(\S+?\.py)(?:::(.*?))?(?: - (.*))?$", re.MULTILINE)
_CRASH: Final = re.compile(r"(?:Name|Syntax|Indentation|Import|UnboundLocal)Error\b|ModuleNotFound")


class Part(NamedTuple):
    """What faults are planted in. `tests`: by what fails soonest for a reader's fault, and for a writer's."""

    folder: str
    faults: tuple[Fault, ...]
    reader_tests: tuple[str, ...]
    writer_tests: tuple[str, ...]


class Outcome(NamedTuple):
    """`state`: caught, survived, unsound. `by`: the first test that failed, or what is wrong with the row."""

    part: str
    fault: Fault
    state: str
    by: str
    seconds: float


_TRANSLATION: Final = ("translate_flow", "translate_faults", "translate")
PARTS: Final = {
    "inform": Part(
        "olp/languages/vendors/inform",
        inform.FAULTS,
        (
            "inform_statements",
            "inform_positions",
            "inform_faults",
            "inform_fast",
            "interpreter_moves",
            "inform_jobs",
            "export",
        ),
        ("inform_faults", "export", "inform_jobs"),
    ),
    "krl": Part(
        "olp/languages/vendors/krl",
        krl.FAULTS,
        ("krl_statements", "krl_plan", "krl_faults", "krl_files", "krl_robust", "krl_writer"),
        ("krl_faults", "krl_writer"),
    ),
    "rapid": Part(
        "olp/languages/vendors/rapid",
        rapid.FAULTS,
        ("rapid_statements", "rapid_positions", "rapid_faults", "interpreter_poses", "rapid_writer"),
        ("rapid_faults", "rapid_writer"),
    ),
    "tp": Part(
        "olp/languages/vendors/tp",
        tp.FAULTS,
        (
            "tp_statements",
            "tp_positions",
            "tp_turns",
            "tp_external",
            "tp_plans",
            "tp_faults",
            "tp_robust",
            "tp_writer",
        ),
        ("tp_faults", "tp_writer"),
    ),
    "urscript": Part(
        "olp/languages/vendors/urscript",
        urscript.FAULTS,
        ("urscript", "urscript_faults", "urscript_polyscope", "urscript_writing"),
        ("urscript_faults", "urscript_writing"),
    ),
    "translate": Part(
        "olp/transpile",
        translate.FAULTS,
        (
            "translate_faults",
            "translate_places",
            "translate_values",
            "translate_left_out",
            "translate_names",
            "translate_systems",
            "translate_straight",
        ),
        ("translate_faults", "translate_places"),
    ),
}


def main(arguments: Sequence[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--vendor", choices=PARTS, help="the faults of one part only")
    parser.add_argument(
        "--only", default="", metavar="TEXT", help="rows whose file or description holds TEXT"
    )
    parser.add_argument("--jobs", type=int, default=1, help="copies that are tested side by side (1)")
    parser.add_argument("--learn", action="store_true", help="note which test catches what, to be run first")
    parser.add_argument(
        "--contracts", nargs="?", const="all", metavar="KIND", help="the contract suites instead of the tests"
    )
    parser.add_argument(
        "--count",
        type=int,
        default=12,
        metavar="N",
        help="mutations of code per member, with --contracts (12)",
    )
    parser.add_argument(
        "--seed", type=int, default=15, metavar="S", help="which mutations are drawn, with --contracts (15)"
    )
    parser.add_argument("--code", action="store_true", help="mutations of code alone, with --contracts")
    args = parser.parse_args(arguments)
    if args.contracts:
        if args.contracts not in ("all", *contract_faults.KINDS):
            parser.error(f"no kind '{args.contracts}'; there are {', '.join(contract_faults.KINDS)}")
        kinds = list(contract_faults.KINDS) if args.contracts == "all" else [args.contracts]
        return contract_faults.run(kinds, args.only, args.count, args.seed, meant=not args.code)
    chosen = [
        (name, fault)
        for name, part in PARTS.items()
        for fault in part.faults
        if args.vendor in (None, name) and args.only.lower() in f"{fault.file} {fault.breaks}".lower()
    ]
    if not chosen:
        parser.error(f"no row holds '{args.only}'")
    wrong = [
        f"{name}/{fault.file}: {problem}" for name, fault in chosen if (problem := misfit(name, fault, ROOT))
    ]
    if wrong:
        print("rows that do not fit the code:", *wrong, sep="\n  ")
        return 2
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="olp-faults-") as folder:
        copies = [make_copy(Path(folder) / f"copy{n}") for n in range(max(args.jobs, 1))]
        failing = without_faults(copies[0], [key_of(*row) for row in chosen])
        if failing:
            print(f"the tests fail without any fault:\n{failing}")
            return 2
        outcomes = try_all(chosen, copies)
    if args.learn:
        learn(outcomes)
    return report(outcomes, time.monotonic() - began)


# --- one copy -----------------------------------------------------------------------------------------------


def make_copy(folder: Path) -> Path:
    """The project, compiled so that a changed text is always noticed, however little time and size tell."""
    folder.mkdir()
    for name in COPIED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, folder / name)
    (folder / "conftest.py").write_text(_CONFTEST, encoding="utf-8")
    compiling = [sys.executable, "-m", "compileall", "-q", "--invalidation-mode", "checked-hash", "olp"]
    subprocess.run(compiling, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return folder


def files_of(folder: Path, names: Sequence[str]) -> list[str]:
    return [f"tests/test_{name}.py" for name in names if (folder / f"tests/test_{name}.py").exists()]


def run_tests(folder: Path, tests: Sequence[str]) -> subprocess.CompletedProcess[str]:
    """These tests or files of tests up to the first failure. Raises subprocess.TimeoutExpired."""
    options = ["-x", "-q", "--tb=no", "--hypothesis-seed=0", "-p", "no:cacheprovider"]
    environment = {
        **os.environ,
        "PYTHONPATH": str(folder),
        "OPENBLAS_NUM_THREADS": "1",
        "COLUMNS": "250",
    }
    command = [sys.executable, "-m", "pytest", *options, *tests]
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=LIMIT, check=False
    )


def without_faults(folder: Path, keys: Sequence[str]) -> str:
    """What fails in the untouched copy, of the tests that are known to catch these faults; "" for nothing."""
    environment = {**os.environ, "PYTHONPATH": str(folder)}
    asked = [sys.executable, "-c", "import olp; print(olp.__file__)"]
    found = subprocess.run(
        asked, cwd=folder, env=environment, capture_output=True, text=True, check=True
    ).stdout
    if not Path(found.strip()).is_relative_to(folder.resolve()):
        return f"olp is imported from {found.strip()}, not from the copy"
    tests = dict.fromkeys(f"tests/{test}" for key, test in known().items() if key in set(keys))
    while tests:
        done = run_tests(folder, tuple(tests))
        gone = [test for test in tests if f"{test}\n" in done.stderr] if done.returncode == 4 else []
        if not gone:
            return f"{done.stdout}{done.stderr}"[-2000:] if done.returncode else ""
        for test in gone:  # renamed since
            del tests[test]
    return ""


# --- one fault ----------------------------------------------------------------------------------------------


def place_of(part: str, fault: Fault, root: Path) -> Path:
    return root / PARTS[part].folder / fault.file


def misfit(part: str, fault: Fault, root: Path) -> str:
    """Why a row cannot be planted; "" when it can."""
    path = place_of(part, fault, root)
    if not path.exists():
        return "no such file"
    text = path.read_text(encoding="utf-8")
    count = text.count(fault.old)
    if count != 1:
        return f"stands {count} times, not once: {fault.old!r}"
    try:
        compile(text.replace(fault.old, fault.new), str(path), "exec")
    except SyntaxError as problem:
        return f"no Python any more ({problem.msg}): {fault.new!r}"
    return ""


def try_fault(part: str, fault: Fault, folder: Path) -> Outcome:
    """Plants one fault, runs the tests, and takes it out again."""
    path = place_of(part, fault, folder)
    text = path.read_text(encoding="utf-8")
    writes = fault.file.startswith("write")
    tests = PARTS[part].writer_tests if writes else PARTS[part].reader_tests
    began = time.monotonic()
    path.write_text(text.replace(fault.old, fault.new), encoding="utf-8")
    try:
        done = run_until_caught(folder, key_of(part, fault), (*tests, *_TRANSLATION))
    except subprocess.TimeoutExpired:
        return Outcome(part, fault, "unsound", f"no end within {LIMIT} s", time.monotonic() - began)
    finally:
        path.write_text(text, encoding="utf-8")
    state, by = judged(done)
    new = state == "caught" and by != known().get(key_of(part, fault))
    if new and run_tests(folder, [f"tests/{by}"]).returncode:
        state, by = "unsound", f"it fails without the fault too: {by}"
    return Outcome(part, fault, state, by, time.monotonic() - began)


def key_of(part: str, fault: Fault) -> str:
    return f"{part}/{fault.file}: {fault.breaks}"


def known() -> dict[str, str]:
    found: dict[str, str] = json.loads(KNOWN.read_text("utf-8")) if KNOWN.exists() else {}
    return found


def run_until_caught(folder: Path, key: str, names: Sequence[str]) -> subprocess.CompletedProcess[str]:
    """The test that is known to catch this fault, then all of these files. Raises subprocess.TimeoutExpired."""
    first = known().get(key)
    if first is not None:
        done = run_tests(folder, [f"tests/{first}"])
        if done.returncode == 1:
            return done
    return run_tests(folder, files_of(folder, names))


def learn(outcomes: Sequence[Outcome]) -> None:
    """Notes which test caught each fault; of faults that are planted no more, nothing is kept."""
    planted = {key_of(name, fault) for name, part in PARTS.items() for fault in part.faults}
    found = known() | {key_of(one.part, one.fault): one.by for one in outcomes if one.state == "caught"}
    kept = {key: found[key] for key in sorted(found) if key in planted}
    KNOWN.write_text(json.dumps(kept, indent=0, ensure_ascii=False) + "\n", encoding="utf-8")


def judged(done: subprocess.CompletedProcess[str]) -> tuple[str, str]:
    """State and first failing test of a run."""
    if done.returncode == 0:
        return "survived", "no test failed"
    first = _SUMMARY.search(done.stdout)
    if done.returncode != 1 or first is None:
        return "unsound", f"the tests did not run: {done.stdout.strip()[-200:]} {done.stderr.strip()[-200:]}"
    file, test, reason = first.groups()
    if _CRASH.match(reason or ""):
        return "unsound", f"a mere crash: {reason}"
    return "caught", f"{file}::{test}" if test else file  # a file whose cases are made when it is read


def try_all(chosen: Sequence[tuple[str, Fault]], copies: Sequence[Path]) -> list[Outcome]:
    """All faults, each in whichever copy is free."""
    free: queue.Queue[Path] = queue.Queue()
    for copy in copies:
        free.put(copy)

    def one(row: tuple[str, Fault]) -> Outcome:
        copy = free.get()
        try:
            outcome = try_fault(*row, copy)
        finally:
            free.put(copy)
        name, fault = row
        print(
            f"{name:<10}{outcome.state:<10}{outcome.seconds:>6.1f} s  {fault.breaks:<52}  {outcome.by}",
            flush=True,
        )
        return outcome

    with ThreadPoolExecutor(len(copies)) as pool:
        return list(pool.map(one, chosen))


def report(outcomes: Sequence[Outcome], seconds: float) -> int:
    """Prints the counts; returns the exit status."""
    states = Counter((one.part, one.state) for one in outcomes)
    print(f"\n{'part':<12}{'planted':>8}{'caught':>8}{'survived':>10}{'unsound':>9}")
    for part in dict.fromkeys(one.part for one in outcomes):
        counts = [states[part, state] for state in ("caught", "survived", "unsound")]
        print(f"{part:<12}{sum(counts):>8}{counts[0]:>8}{counts[1]:>10}{counts[2]:>9}")
    total = Counter(one.state for one in outcomes)
    print(f"{'all':<12}{len(outcomes):>8}{total['caught']:>8}{total['survived']:>10}{total['unsound']:>9}")
    print(f"{seconds:.0f} s")
    return 2 if total["unsound"] else 1 if total["survived"] else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
