"""What every host promises, an editor, a CAD program or an assistant that shows what olp knows: `check_host`."""

from __future__ import annotations

import ast
import re
import subprocess
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import Final

from olp import cli
from olp.contracts.promises import Difference, Promise, hold

_MOST: Final = 400_000  # bytes of a file that is looked through
_SKIPPED: Final = {"node_modules", "__pycache__", "build", "dist", "out"}
_SECRETS: Final = re.compile(r"/(?:home|Users)/(?!me\b|you\b|user\b)\w+|(?<![\w.])/(?:work|root)/\w")
_PRIVATE: Final = re.compile(r"^\s*from olp[.\w]* import .*\b_\w+|^\s*import olp[.\w]*\._", re.MULTILINE)


class HostUnderTest:
    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @cached_property
    def files(self) -> list[Path]:
        found = []
        for path in sorted(self.folder.rglob("*")):
            inside = set(path.relative_to(self.folder).parts) & _SKIPPED
            if path.is_file() and not inside and path.stat().st_size < _MOST:
                found.append(path)
        return found

    def text(self, path: Path) -> str:
        data = path.read_bytes()
        return "" if b"\0" in data else data.decode("utf-8", "replace")

    @property
    def readme(self) -> str:
        path = self.folder / "README.md"
        return self.text(path) if path.exists() else ""

    @property
    def test(self) -> str:
        path = self.folder / "test"
        return self.text(path) if path.exists() else ""


def check_host(folder: str | Path, *, first: bool = False) -> None:
    """Raises ContractError with every promise of a host that the one in `folder` (hosts/NAME) breaks.

    What the host shows is proven by its own `test`, which drives the real host.

        from olp.contracts import check_host
        check_host("hosts/neovim")
    """
    path = Path(folder)
    hold(f"host {path.name}", HostUnderTest(path), PROMISES, first=first)


def has_a_page(it: HostUnderTest) -> Iterator[Difference]:
    """README.md says how its user installs it, and shows a real run"""
    lines = it.readme.splitlines()
    if not lines or not lines[0].startswith("# ") or len(lines[0]) < 5:
        yield "README.md", "it does not begin with a title"
    if not ("```" in it.readme or "docs/" in it.readme):
        yield "README.md", "it shows no run, no lines to copy and no page of docs/ that does"
    if it.readme.count("```") % 2:
        yield "README.md", "a block of code has no end"
    for target in re.findall(r"\]\(((?!https?:|#|mailto:)[^)#\s]+)", it.readme):
        if not (it.folder / target).exists():
            yield "README.md", f"it leads to {target}, which is not there"


def uses_what_there_is(it: HostUnderTest) -> Iterator[Difference]:
    """Its page names commands of olp that there are"""
    names = {name.split()[0] for name in cli.names()}
    for line in it.readme.splitlines():
        found = re.match(r"\s*(?:\$ )?(?:\S*python\S* -m )?olp ([a-z][a-z-]*)\b", line)
        if found and found[1] not in names and "```" not in line and _in_code(it.readme, line):
            yield line.strip(), f"there is no command {found[1]}"


def _in_code(text: str, line: str) -> bool:
    before = text.partition(line)[0]
    return before.count("```") % 2 == 1


def has_a_test(it: HostUnderTest) -> Iterator[Difference]:
    """`test` is a shell script that begins with what it proves, and is sound shell"""
    lines = it.test.splitlines()
    if len(lines) < 3 or lines[0] != "#!/bin/sh" or not re.match(r"# \S.{15,}", lines[1]):
        yield "test", "its first two lines are not #!/bin/sh and a comment that says what it proves"
        return
    done = subprocess.run(
        ["/bin/sh", "-n", str(it.folder / "test")], capture_output=True, text=True, check=False
    )
    if done.returncode:
        yield "test", done.stderr.strip()[:200]
    if "\r" in it.test:
        yield "test", "lines that end with CR, which no shell takes"


def drives_what_was_given(it: HostUnderTest) -> Iterator[Difference]:
    """`test` uses the Python that it is given, drives files that there are, and skips nothing in silence"""
    if "OLP_PYTHON" not in it.test and "OLP_HOSTS" not in it.test and "olp" not in it.test:
        yield "test", "it uses neither OLP_PYTHON nor olp"
    for line in it.test.splitlines():
        if re.search(r"\|\|\s*(true|:|exit 0)\s*(#.*)?$", line) and re.search(
            r"need|pytest|OLP_PYTHON", line
        ):
            yield line.strip(), "a failure that counts as success"
        if re.match(r"\S*scripts/need\b", line) and "||" not in line and "set -e" not in it.test:
            yield line.strip(), "what cannot be set up is not a failure here"
    root = it.folder.resolve().parent.parent
    for target in re.findall(r"(?<![\w$/{}\"])((?:hosts|tests|scripts)/[\w./-]+\w)", it.test):
        if not any((place / target).exists() for place in (root, it.folder)):
            yield "test", f"it names {target}, which is not there"


def keeps_to_public_names(it: HostUnderTest) -> Iterator[Difference]:
    """Its Python is sound and uses no name of olp that starts with _"""
    for path in it.files:
        if path.suffix != ".py":
            continue
        text = it.text(path)
        try:
            ast.parse(text)
        except SyntaxError as problem:
            yield str(path.relative_to(it.folder)), f"no Python: {problem.msg} on line {problem.lineno}"
        for found in _PRIVATE.findall(text):
            yield str(path.relative_to(it.folder)), f"it imports a private name: {found.strip()}"


def stands_alone(it: HostUnderTest) -> Iterator[Difference]:
    """No file of it names a folder of the one who wrote it, and there is something in it besides page and test"""
    for path in it.files:
        found = _SECRETS.search(it.text(path))
        if found:
            yield str(path.relative_to(it.folder)), f"it names {found[0]}"
    if not it.files:
        yield str(it.folder), "there is nothing in it"


PROMISES: Final[tuple[Promise[HostUnderTest], ...]] = (
    has_a_page,
    uses_what_there_is,
    has_a_test,
    drives_what_was_given,
    keeps_to_public_names,
    stands_alone,
)
