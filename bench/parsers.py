"""Reads programs of one language with a parser that is not olp's own, and counts what it accepts.

    python bench/parsers.py --make DIR [--count N]
    python bench/parsers.py LANGUAGE PARSER FOLDER…

The first form writes into DIR what `olp convert` makes of all samples and of N random programs, a folder per
language. The second reads the files of the FOLDERs with a public parser. PARSER is, for

    krl       the folder of a lexer and parser that ANTLR 4 generated for Python from the grammar krl.g4
    rapid     a command that is given files and prints a row for each: accepted, TAB, file; or rejected, TAB, file,
              TAB, what was wrong
    tp        such a command
    inform    a JSON file whose keys are the instructions of the language
    urscript  the word python: blocks become indents, and Python runs it with stand-ins for the controller

A file that is rejected is read once more with the spellings replaced that the parser is known to lack (`_LACKING`,
with the reason); both counts are printed, then every file that was rejected twice, with the parser's first message.
"""

from __future__ import annotations

import argparse
import importlib
import json
import re
import shlex
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

SAMPLES = {
    "inform": ("inform/**/*.[jJ][bB][iI]", "up20/*.JBI"),
    "krl": ("krl/*.src",),
    "rapid": ("rapid/*.mod", "rapid/*.prg"),
    "tp": ("tp/*.ls",),
    "urscript": ("urscript/*.script",),
}
ENDINGS = {
    "inform": (".jbi",),
    "krl": (".src", ".dat"),
    "rapid": (".mod", ".prg", ".sys"),
    "tp": (".ls",),
    "urscript": (".script",),
}
# Spellings that a parser does not know although controllers write or take them: pattern, replacement, reason.
_LACKING: dict[str, tuple[tuple[str, str, str], ...]] = {
    "krl": ((r"(?mi)^([ \t]*PTP[ \t]+\S+)[ \t]+C_DIS\b", r"\1 C_PTP C_DIS", "PTP … C_DIS"),),
    "inform": ((r"(?m)^(\s*)SETTOOL\b", r"\1SET", "the instruction SETTOOL"),),
    "rapid": ((r"\A\s*%%%[^%]*%%%", "", "the header between %%%"),),
    "tp": (
        (r"\bCR(\d+(\.\d+)?)\b", "CNT50", "corner regions CR"),
        (
            r"\b(R|J6)([ \t]*=[ \t]*[-.\d*]+[ \t]+deg)\s*\n\};",
            "\\1\\2,\n\tE1 = 0.000 mm\n};",
            "positions without an external axis",
        ),
    ),
}  # fmt: skip
_SECONDS = 5  # that one script may run

Rejections = dict[Path, str]  # file -> the parser's first message


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--make", type=Path, metavar="DIR", help="write the programs to read into DIR")
    parser.add_argument("--count", type=int, default=100, help="how many random programs (default: 100)")
    parser.add_argument("language", nargs="?", choices=ENDINGS)
    parser.add_argument("parser", nargs="?")
    parser.add_argument("folders", nargs="*", type=Path)
    given = parser.parse_args()
    if given.make is not None:
        make(given.make, given.count)
        return 0
    if not given.folders:
        parser.error("a language, a parser and a folder are asked for, or --make DIR")
    return check(given.language, given.parser, list(files_of(given.language, given.folders)))


# --- the programs ---------------------------------------------------------------------------------------


def make(place: Path, count: int) -> None:
    """Writes `place`/LANGUAGE/PROGRAM/… for all samples and `count` random programs; prints what was refused."""
    from translate_programs import Maker
    from translated_texts import VENDORS

    import olp
    from olp.core.diagnostic import OlpError
    from olp.robots.robot import load_robot
    from olp.transpile import Context
    from olp.transpile.convert import convert
    from olp.transpile.link import link

    context = Context(robot=load_robot("yaskawa/gp25"), on_loss="comment")
    programs: list[tuple[str, str, Any]] = []
    for source, patterns in SAMPLES.items():
        for path in sorted(one for pattern in patterns for one in (ROOT / "samples").glob(pattern)):
            if "broken" not in path.parts:
                name = f"{source}-{path.parent.name}-{path.stem}"
                programs.append((source, name, link(olp.read(path, vendor=source)).program))
    programs += [("", f"random-{seed:03d}", Maker(seed).program()) for seed in range(count)]
    for source, name, program in programs:
        for target in VENDORS:
            if target == source:
                continue
            try:
                made = convert(program, target, context, date="2026/01/01 00:00")
            except OlpError as problem:
                print(f"refused: {name} as {target}: {problem.diagnostics[0].message}")
                continue
            folder = place / target / name
            folder.mkdir(parents=True, exist_ok=True)
            for file, data in made.files.items():
                (folder / file).write_bytes(data)


def files_of(language: str, folders: list[Path]) -> Iterator[Path]:
    for folder in folders:
        for path in [folder] if folder.is_file() else sorted(folder.rglob("*")):
            if path.suffix.lower() in ENDINGS[language] and "broken" not in path.parts:
                yield path


# --- the count ------------------------------------------------------------------------------------------


def check(language: str, parser: str, files: list[Path]) -> int:
    rejected = PARSERS[language](parser, files)
    print(f"{language}: accepted as written {len(files) - len(rejected)} of {len(files)}")
    again = _with_spellings_replaced(language, parser, list(rejected)) if rejected else {}
    for reason, number in again.pop("reasons", Counter()).items():  # type: ignore[call-overload]
        print(f"  {number} files hold {reason}, which the parser does not know")
    if len(again) < len(rejected):
        print(f"{language}: accepted with that replaced {len(files) - len(again)} of {len(files)}")
    for path, message in again.items():
        print(f"  {path}: {message}")
    return 1 if again else 0


def _with_spellings_replaced(language: str, parser: str, files: list[Path]) -> dict[Any, Any]:
    """The rejections of the second reading; under "reasons", how many files each replacement changed."""
    reasons: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as place:
        copies = {}
        for number, path in enumerate(files):
            text = path.read_bytes().decode("latin-1").replace("\r\n", "\n")
            for pattern, replacement, reason in _LACKING.get(language, ()):
                text, changed = re.subn(pattern, replacement, text)
                reasons[reason] += bool(changed)
            copy = Path(place) / f"{number}" / path.name
            copy.parent.mkdir()
            copy.write_bytes(text.encode("latin-1"))
            copies[copy] = path
        found = PARSERS[language](parser, list(copies))
        return {"reasons": +reasons, **{copies[copy]: message for copy, message in found.items()}}


# --- the parsers ----------------------------------------------------------------------------------------


def antlr(folder: str, files: list[Path]) -> Rejections:
    """krlLexer and krlParser as ANTLR generates them, with its Python runtime."""
    sys.path.insert(0, folder)
    runtime = importlib.import_module("antlr4")
    listener = importlib.import_module("antlr4.error.ErrorListener").ErrorListener
    lexer_type = importlib.import_module("krlLexer").krlLexer
    parser_type = importlib.import_module("krlParser").krlParser
    rejected: Rejections = {}
    for path in files:
        told: list[str] = []

        class Listener(listener):  # type: ignore[misc, valid-type]
            def syntaxError(self, _r: Any, _s: Any, line: int, column: int, message: str, _e: Any) -> None:  # noqa: N802
                told.append(f"{line}:{column + 1} {message}")  # noqa: B023

        lexer = lexer_type(runtime.InputStream(path.read_bytes().decode("latin-1")))
        parser = parser_type(runtime.CommonTokenStream(lexer))
        for one in (lexer, parser):
            one.removeErrorListeners()
            one.addErrorListener(Listener())
        parser.module()
        if told:
            rejected[path] = told[0]
    return rejected


def command(text: str, files: list[Path]) -> Rejections:
    done = subprocess.run(
        [*shlex.split(text), *map(str, files)], capture_output=True, text=True, encoding="utf-8", check=False
    )
    rows = {}
    for line in done.stdout.splitlines():
        word, _, rest = line.partition("\t")
        path, _, message = rest.partition("\t")
        if word in ("accepted", "rejected"):
            rows[path] = (word, message)
    missing = ("rejected", f"the parser said nothing: {done.stderr.strip()[-200:]}")
    told = {path: rows.get(str(path), missing) for path in files}
    return {path: message for path, (word, message) in told.items() if word != "accepted"}


def words(file: str, files: list[Path]) -> Rejections:
    """Whether the first word of every instruction is one, and every timer is one that the controller takes."""
    known = set(json.loads(Path(file).read_text("utf-8")))
    rejected: Rejections = {}
    for path in files:
        section = ""
        for number, line in enumerate(path.read_bytes().decode("latin-1").splitlines(), 1):
            if line.startswith("/"):
                section = section if line.startswith("///") else line[2:6]
                continue
            word = re.match(r"\s*([A-Z0-9]+\$?)(?:\s|$)", line)
            timer = re.search(r"(?<=\s)T=(-?[0-9]+(?:\.[0-9]+)?)\b", line)
            if section == "INST" and word and word[1] not in known:
                rejected.setdefault(path, f"{number}: the instruction {word[1]} is not known")
            if section == "INST" and timer and not 0 <= float(timer[1]) <= 655.35:
                rejected.setdefault(path, f"{number}: the time {timer[1]} is out of range")
    return rejected


def python(_: str, files: list[Path]) -> Rejections:
    """Runs the scripts; one that waits for ever was accepted. One that is handed something is compiled only."""
    from urscript_python import run, to_python

    def stop(*_: object) -> None:
        raise TimeoutError

    signal.signal(signal.SIGALRM, stop)
    rejected: Rejections = {}
    for path in files:
        signal.alarm(_SECONDS)
        text = path.read_bytes().decode("utf-8", "replace")
        try:
            compile(to_python(text), str(path), "exec")
            if re.search(r"^def\s+\w+\s*\(\)\s*:", text, re.MULTILINE):
                run(text)
        except TimeoutError:
            pass
        except Exception as problem:
            if str(problem) != "waits for ever":
                rejected[path] = f"{type(problem).__name__}: {problem}"
        finally:
            signal.alarm(0)
    return rejected


PARSERS: dict[str, Callable[[str, list[Path]], Rejections]] = {
    "krl": antlr,
    "rapid": command,
    "tp": command,
    "inform": words,
    "urscript": python,
}

if __name__ == "__main__":
    sys.exit(main())
