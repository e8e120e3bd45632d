"""Every example in the documentation is run, and its output must be the one that is shown.

An example is a fenced block marked `console`. Its lines that start with `$ olp ` or `$ scripts/olp ` are run,
in order, in one empty folder per page that has the repository's `samples`; `$ echo $?` shows the status of
the last one. What follows each is compared with what it prints. "…" stands for any text in a line, and alone
on a line for any lines.
"""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parent.parent
PAGES = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", *ROOT.glob("docs/**/*.md")])
FENCE = re.compile(r"^(?P<fence>```+|~~~+) *(?P<kind>\w*)[^\n]*\n(?P<body>.*?)^(?P=fence) *$", re.M | re.S)
ANYTHING = "…"


class Example(NamedTuple):
    line: int  # of the page, 1-based
    command: str
    output: str


def examples(page: str) -> list[Example]:
    """The commands of a page's console blocks, each with the output shown below it."""
    found: list[Example] = []
    for block in FENCE.finditer(page):
        if block["kind"] != "console":
            continue
        start = page.count("\n", 0, block.start("body")) + 1
        for number, line in enumerate(block["body"].splitlines(), start):
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


def run(command: str, folder: Path) -> tuple[str, int]:
    """What a command prints, both streams in one, and its status."""
    words = shlex.split(command, comments=True)
    done = subprocess.run(
        [sys.executable, "-m", "olp", *words[1:]],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT), "COLUMNS": "100", "NO_COLOR": "1", "PYTHONUTF8": "1"},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
    )
    return done.stdout, done.returncode


def differences(page: str, folder: Path) -> list[str]:
    """Every example of a page whose output is another, with both."""
    (folder / "samples").symlink_to(ROOT / "samples")
    wrong, status = [], 0
    for line, command, shown in examples(page):
        if command == "echo $?":
            printed = f"{status}\n"
        elif command.startswith(("olp ", "scripts/olp ")):
            printed, status = run(command, folder)
        else:
            continue
        if not matches(shown, printed):
            wrong.append(f"line {line}: $ {command}\nshown:\n{shown}printed:\n{printed}")
    return wrong


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_the_examples_print_what_the_page_shows(page: Path, tmp_path: Path) -> None:
    wrong = differences(page.read_text(encoding="utf-8"), tmp_path)
    assert not wrong, "\n\n".join(wrong)


def test_the_first_screen_of_the_readme_holds_a_run() -> None:
    found = examples((ROOT / "README.md").read_text(encoding="utf-8"))
    assert any(example.line <= 40 and example.output.strip() for example in found)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_inside_the_repository_lead_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^)\s#]+)[^)]*\)", page.read_text(encoding="utf-8"))
    local = [link for link in links if not re.match("[a-z]+:", link)]
    assert [link for link in local if not (page.parent / link).exists()] == []


# The mechanism itself: a check that finds nothing wrong proves nothing until it has found something.

PAGE = """\
```console
$ git clone somewhere
$ olp --version
olp …
$ olp no-such-command
…
help: olp --help lists the commands
$ echo $?
2
```
"""


def test_a_right_page_passes_and_every_wrong_line_of_a_wrong_one_is_found(tmp_path: Path) -> None:
    for number, page in enumerate((PAGE, PAGE.replace("olp …", "olp 99"), PAGE.replace("\n2\n", "\n0\n"))):
        (tmp_path / str(number)).mkdir()
        assert len(differences(page, tmp_path / str(number))) == (number > 0)


@pytest.mark.parametrize(
    ("shown", "printed", "same"),
    [
        ("a  1\nb\n", "a  1\nb\n\n", True),
        ("a  1\n", "a 1\n", False),
        ("a … c\n", "a b b c\n", True),
        ("a … c\n", "a b\nc\n", False),
        ("a\n…\nd\n", "a\nb\nc\nd\n", True),
        ("a\n…\nd\n", "a\nd\n", True),
        ("a\n…\nd\n", "a\nb\n", False),
        ("a.c\n", "abc\n", False),
        ("", "unexpected\n", False),
    ],
)
def test_output_is_compared_exactly_except_where_the_page_leaves_out(
    shown: str, printed: str, same: bool
) -> None:
    assert matches(shown, printed) is same
