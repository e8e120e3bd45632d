"""Pages of the documentation as programs: their fenced blocks, and how each kind is executed.

    console   lines that start with `$ `: olp (also as scripts/olp), `echo $?`, git, cp and mkdir are run in order in
              one folder per page that has the repository's `samples`; what follows is what they print. "…" stands
              for any text in a line, and alone on a line for any lines
    python    is run in the same folder, after the blocks of the page before it
    sh        commands with names of the reader's own: command and options must exist
    toml, yaml, json, jinja, sql    must be what they say they are
    lua, elisp    settings of an editor: its brackets pair, and its host's own test runs it, word for word
    text      is no code

A block with title="NAME" is written into the folder as that file first, so that the next command finds it.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import sqlite3
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import yaml
from olp_process import run_olp

from olp import cli
from olp.cli.command import Parser
from olp.core.diagnostic import OlpError
from olp.languages.templating import Sandbox

ROOT = Path(__file__).parent.parent
ANYTHING = "…"
FENCE = re.compile(
    r"^(?P<fence>```+|~~~+) *(?P<kind>\w*)(?P<more>[^\n]*)\n(?P<body>.*?)^(?P=fence) *$", re.M | re.S
)
OTHERS = ("git", "cp", "mkdir")


class Block(NamedTuple):
    line: int  # of the page where the body begins, 1-based
    kind: str
    title: str
    body: str


class Example(NamedTuple):
    line: int  # of the page, 1-based
    command: str
    output: str


def blocks(page: str) -> Iterator[Block]:
    """The fenced blocks of a page."""
    for block in FENCE.finditer(page):
        title = re.search(r'title="([^"]+)"', block["more"])
        line = page.count("\n", 0, block.start("body")) + 1
        yield Block(line, block["kind"], title[1] if title else "", block["body"])


def examples(block: Block) -> list[Example]:
    """The commands of a console block, each with the output shown below it."""
    found: list[Example] = []
    for number, line in enumerate(block.body.splitlines(), block.line):
        if line.startswith("$ "):
            found.append(Example(number, line[2:].strip(), ""))
        elif found:
            found[-1] = found[-1]._replace(output=f"{found[-1].output}{line}\n")
    return found


def matches(shown: str, printed: str) -> bool:
    """Whether the output is the one shown; blanks at line ends and blank lines at the end do not count."""
    pattern = "".join(
        r"(?:.*\n)*?"
        if line.strip() == ANYTHING
        else f"{'.*'.join(map(re.escape, line.rstrip().split(ANYTHING)))}\n"
        for line in shown.rstrip().splitlines()
    )
    text = "".join(f"{line.rstrip()}\n" for line in printed.rstrip().splitlines())
    return re.fullmatch(pattern, text) is not None


def differences(page: str, folder: Path) -> list[str]:
    """Every block of a page that does not do what the page shows, with both."""
    (folder / "samples").symlink_to(ROOT / "samples")
    with PythonSession(folder) as python:
        return list(_wrong(page, folder, python))


def _wrong(page: str, folder: Path, python: PythonSession) -> Iterator[str]:
    status = 0
    for block in blocks(page):
        if block.title:
            file = folder / block.title
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(block.body, encoding="utf-8")
        if block.kind == "console":
            for line, command, shown in examples(block):
                printed, status = (f"{status}\n", status) if command == "echo $?" else run(command, folder)
                if not matches(shown, printed):
                    yield f"line {line}: $ {command}\nshown:\n{shown}printed:\n{printed}"
            continue
        says = (
            python.run(block.body) if block.kind == "python" else KINDS.get(block.kind, _unknown)(block.body)
        )
        if says:
            yield f"line {block.line}: {block.kind or 'a block without a kind'}: {says}"


def run(command: str, folder: Path) -> tuple[str, int]:
    """What a command prints, both streams in one, and its status."""
    words = shlex.split(command, comments=True)
    if words[0] in ("olp", "scripts/olp"):
        ran = run_olp(words[1:], folder, _environment(), merged=True)
        return ran.stdout.decode("utf-8"), ran.returncode
    if words[0] not in OTHERS:
        return f"a page may run olp, {', '.join(OTHERS)}, not {words[0]}\n", 2
    return _execute(words, folder)


# What a PythonSession runs: each line of its input is a block as JSON, and each line of its answer what went wrong.
_INTERPRETER = """
import contextlib, io, json, sys, traceback
names = {"__name__": "__main__"}
answers, sys.stdout = sys.stdout, io.StringIO()
for line in sys.stdin:
    says, printed = "", io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
        try:
            exec(compile(json.loads(line), "<page>", "exec"), names)
        except BaseException:
            traceback.print_exc()
            says = printed.getvalue()
    print(json.dumps(says), file=answers, flush=True)
"""


class PythonSession:
    """The Python blocks of a page, one after the other in one interpreter, which begins with the first of them."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.process: subprocess.Popen[str] | None = None

    def __enter__(self) -> PythonSession:
        return self

    def __exit__(self, *problem: object) -> None:
        if self.process is not None:
            self.process.communicate()

    def run(self, body: str) -> str:
        """What went wrong in a block ("": nothing)."""
        if self.process is None:
            words = [sys.executable, "-W", "error", "-c", _INTERPRETER]
            self.process = subprocess.Popen(
                words,
                cwd=self.folder,
                env=_environment(),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                encoding="utf-8",
            )
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(json.dumps(body) + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline()
        return str(json.loads(answer)) if answer else "the interpreter ended"


def _environment() -> dict[str, str]:
    somebody = {
        f"GIT_{who}_{what}": "a@b.example" for who in ("AUTHOR", "COMMITTER") for what in ("NAME", "EMAIL")
    }
    return {
        **os.environ,
        **somebody,
        "PYTHONPATH": str(ROOT),
        "COLUMNS": "100",
        "NO_COLOR": "1",
        "PYTHONUTF8": "1",
        "GIT_CONFIG_GLOBAL": os.devnull,
    }


def _execute(words: list[str], folder: Path) -> tuple[str, int]:
    done = subprocess.run(
        words,
        cwd=folder,
        env=_environment(),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
    )
    return done.stdout, done.returncode


def _sh(body: str) -> str:
    """Lines of olp must be commands with options that there are; scripts must exist."""
    return "\n".join(filter(None, map(_line, body.replace("\\\n", " ").splitlines())))


def _line(line: str) -> str:
    words = shlex.split(line, comments=True)
    if "&&" in words:
        return "\n".join(filter(None, map(_line, line.split("&&"))))
    if not words:
        return ""
    if words[0] in ("olp", "scripts/olp"):
        return _arguments(words[1:])
    if words[0] == "python":
        script = f"{words[2].replace('.', '/')}/__main__.py" if words[1] == "-m" else words[1]
        return "" if (ROOT / script).exists() or words[1:3] == ["-m", "pip"] else f"no {script}"
    if words[0].startswith("scripts/") and not (ROOT / words[0]).exists():
        return f"no {words[0]}"
    return ""


def _arguments(words: list[str]) -> str:
    if words in (["--version"], ["--help"]):
        return ""
    name, rest = cli.split(words)
    if not name:
        return f"no command {words}"
    command = cli.load(name)
    parser = Parser(f"olp {name}", command.SUMMARY)
    command.add_arguments(parser)
    try:
        parser.parse_intermixed_args(rest)
    except OlpError as problem:
        return str(problem)
    return ""


def _tried(load: Callable[[str], object]) -> Callable[[str], str]:
    def check(body: str) -> str:
        try:
            load(body)
        except Exception as problem:
            return f"{type(problem).__name__}: {problem}"
        return ""

    return check


def _unknown(body: str) -> str:
    return f"no kind of block that is known ({', '.join(['console', 'python', *KINDS])}): {body[:60]!r}"


def _sql(body: str) -> None:
    from olp.checks.guard.store import _SCHEMA

    store = sqlite3.connect(":memory:")
    store.executescript(_SCHEMA)
    store.execute(body)


def _paired(body: str) -> str:
    """Brackets outside of comments and texts."""
    bare = re.sub(r"""(?:--|;).*|'(?:\\.|[^'\n])*'(?!\w)|"(?:\\.|[^"\\])*\"""", "", body)
    opened: list[str] = []
    for letter in re.findall(r"[()\[\]{}]", bare):
        if letter in "([{":
            opened.append(letter)
        elif not opened or opened.pop() + letter not in ("()", "[]", "{}"):
            return f"a {letter} without its beginning"
    return f"{len(opened)} brackets are not closed" if opened else ""


KINDS: dict[str, Callable[[str], str]] = {
    "sh": _sh,
    "toml": _tried(tomllib.loads),
    "yaml": _tried(yaml.safe_load),
    "json": _tried(json.loads),
    "jinja": _tried(lambda body: Sandbox(None).from_string(body)),
    "sql": _tried(_sql),
    "lua": _paired,
    "elisp": _paired,
    "text": lambda body: "",
}
