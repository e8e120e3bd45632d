"""What every command promises: `check_command`."""

from __future__ import annotations

import contextlib
import io
import os
import re
import subprocess
import sys
import tempfile
from argparse import Action, ArgumentParser
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

from olp import cli
from olp.__main__ import main
from olp.cli.command import Parser
from olp.contracts.promises import Difference, Promise, hold
from olp.core.diagnostic import OlpError

_HEAVY: Final = ("numpy", "pandas", "lark", "rich", "jinja2", "scipy", "pyarrow", "multiprocessing")
_GARBAGE: Final = b"\x00\xff??; {[(\r\n\x1b[31m" * 3


class CommandUnderTest:
    def __init__(self, name: str) -> None:
        self.name = name
        self.module: Any = cli.load(name)

    def parser(self) -> Parser:
        made = Parser(f"olp {self.name}", self.module.SUMMARY)
        self.module.add_arguments(made)
        return made

    def run(self, *words: str) -> tuple[int, str, str]:
        """Status, standard output and standard error."""
        out = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", write_through=True)
        told = io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(told):
            status = main([*self.name.split(), *words])
        out.flush()
        return status, out.buffer.getvalue().decode("utf-8", "replace"), told.getvalue()


def check_command(name: str, *, first: bool = False) -> None:
    """Raises ContractError with every promise of a command line that the command `name` ("robot import") breaks.

    What it computes is not judged here.

        from olp.contracts import check_command
        check_command("time")
    """
    hold(f"command {name}", CommandUnderTest(name), PROMISES, first=first)


def is_explained(it: CommandUnderTest) -> Iterator[Difference]:
    """A command says in one line what it does, and its help explains every argument"""
    summary = it.module.SUMMARY
    if "\n" in summary or not 10 < len(summary) <= 80 or summary != summary.strip(" ."):
        yield "SUMMARY", repr(summary)
    status, out, told = it.run("--help")
    if status != 0 or f"usage: olp {it.name}" not in out or told:
        yield "--help", f"status {status}, {out[:60]!r}"
    if summary.split()[0].lower() not in out.lower():
        yield "--help", "it does not say the summary"
    for action in _actions(it.parser()):
        if not action.help or not action.help.strip():
            yield str(action.option_strings or action.dest), "it has no help"


def _actions(parser: ArgumentParser) -> list[Action]:
    return list(parser._actions)


def names_options_alike(it: CommandUnderTest) -> Iterator[Difference]:
    """Options are words with hyphens, short ones are one letter, and no option changes another's default"""
    for action in _actions(it.parser()):
        for option in action.option_strings:
            if not re.fullmatch(r"-[a-zA-Z0-9]|--[a-z][a-z0-9]*(-[a-z0-9]+)*", option):
                yield option, "not a word with hyphens"
    if it.parser().allow_abbrev:
        yield "--h", "abbreviations are taken, which a longer option would break"


def answers_wrong_arguments(it: CommandUnderTest) -> Iterator[Difference]:
    """An option that there is none of is a diagnostic with status 2, on the error stream alone"""
    for words in (("--no-such-option",), ("--no-such-option=3", "x")):
        status, out, told = it.run(*words)
        if status != 2 or not told.startswith("error[C002]: ") or out:
            yield " ".join(words), f"status {status}, {told[:80]!r}, {len(out)} characters of output"


def _words(it: CommandUnderTest, path: str) -> list[str] | None:
    """Every argument that has to be given, with `path` for those that are free; None: there is none of these."""
    words: list[str] = []
    free = False
    for action in _actions(it.parser()):
        if action.option_strings and not action.required:
            continue
        if not action.option_strings and action.nargs in ("*", "?"):
            free = True
            words.append(path)
            continue
        value = str(next(iter(action.choices))) if action.choices else path
        free = free or not action.choices
        count = action.nargs if isinstance(action.nargs, int) else 1
        words += [*action.option_strings[:1], *[value] * count]
    return words if free else None


def _outcomes(it: CommandUnderTest) -> Iterator[tuple[str, int, str, str, bool]]:
    """(input, status, output, what was told, whether a file changed) for files that are none or no programs."""
    with tempfile.TemporaryDirectory() as folder:
        there = Path(folder)
        bad = {"nonsense.xyz": _GARBAGE, "nothing.csv": b"", "broken.toml": b"[[[\n= 3"}
        for name, data in bad.items():
            (there / name).write_bytes(data)
        before = os.getcwd()
        os.chdir(folder)
        try:
            for name in ("gone/no-such-file.xyz", *bad):
                words = _words(it, name)
                if words is None:
                    return
                status, out, told = it.run(*words)
                left = {name: (there / name).read_bytes() for name in bad}
                yield name, status, out, told, left != bad
        finally:
            os.chdir(before)


def answers_bad_files(it: CommandUnderTest) -> Iterator[Difference]:
    """A missing file is answered with status 2 and a reason; whatever a file holds, no traceback, no input changed"""
    for name, status, out, told, changed in _outcomes(it):
        if status not in (0, 1, 2):
            yield name, f"status {status}"
        if "Traceback" in told or "Traceback" in out:
            yield name, f"a traceback: {told[-120:]!r}"
        if status == 2 and not (told + out).strip():
            yield name, "status 2, and nothing is said"
        if changed:
            yield name, "an input was changed"
        if name.startswith("gone") and status != 2:
            yield name, f"status {status} for a file that does not exist"


def imports_late(it: CommandUnderTest) -> Iterator[Difference]:
    """Asking for help imports nothing that takes time"""
    code = (
        f"import sys; from olp import cli; cli.load({it.name!r}); "
        f"print([m for m in {_HEAVY!r} if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    if done.stdout.strip() != "[]":
        yield f"import of {it.module.__name__}", done.stdout.strip() or done.stderr[-200:]


def runs_again(it: CommandUnderTest) -> Iterator[Difference]:
    """A command keeps nothing between runs: its arguments are the same each time, and bad ones raise"""
    one, other = it.parser().format_help(), it.parser().format_help()
    if one != other:
        yield "add_arguments twice", "another help"
    try:
        it.parser().parse_words(["--no-such-option"])
        yield "--no-such-option", "parsed"
    except OlpError:
        pass


PROMISES: Final[tuple[Promise[CommandUnderTest], ...]] = (
    is_explained,
    names_options_alike,
    answers_wrong_arguments,
    answers_bad_files,
    runs_again,
    imports_late,
)
