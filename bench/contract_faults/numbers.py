"""Faults of members that are no programs: wrong numbers in robot files, careless commands, careless hosts."""

from __future__ import annotations

import contextlib
import io
import random
import re
import shutil
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

ROOT: Final = Path(__file__).resolve().parents[2]
SEED: Final = 15
_ALL: Final = tempfile.TemporaryDirectory(prefix="olp-faults-")
_PLACE: Final[dict[str, Path]] = {}  # in the fault's own process: where the faulty member is
Planted = tuple[str, Callable[[], Callable[[], bool]]]
_NUMBER: Final = re.compile(r"(?<![\w.\"])-?\d+(?:\.\d+)?(?![\w.\"])")
_PER_FILE: Final = 14


def _scratch() -> Path:
    """A new folder that is gone when the bench ends: a fault's own process ends without cleaning up."""
    return Path(tempfile.mkdtemp(dir=_ALL.name))


# --- robots -------------------------------------------------------------------------------------------------


def check(name: str) -> None:
    """The suite of a robot, of its faulty file where one was made."""
    from olp.contracts import check_robot

    check_robot(_PLACE.get("robot", name), first=True)


_OPERATIONS: Final[dict[str, Callable[[float], float]]] = {
    "the other sign": lambda x: -x,
    "a thousand times": lambda x: x * 1000,
    "a thousandth": lambda x: x / 1000,
    "in radians": lambda x: x * 0.017453292519943295,
    "ten times": lambda x: x * 10,
}


def robot_faults(name: str) -> list[Planted]:
    """Numbers of the file, drawn at random, each with one of the operations; and two numbers of a row swapped."""
    text = (ROOT / "olp" / "robots" / f"{name}.toml").read_text(encoding="utf-8")
    body = text.partition("[sources]")[0].partition("[dynamics")[0]
    places = [found for found in _NUMBER.finditer(_without_words(body)) if float(found.group()) != 0.0]
    dice = random.Random(f"{SEED}{name}")
    found: list[Planted] = []
    for place in dice.sample(places, min(_PER_FILE - 2, len(places))):
        says = dice.choice(list(_OPERATIONS))
        if abs(float(place.group())) == 180.0 and body.rfind("zero_deg", 0, place.start()) > body.rfind(
            "\n", 0, place.start()
        ):
            says = "a thousandth"  # a zero of -180 degrees is one of 180
        other = f"{_OPERATIONS[says](float(place.group())):.9g}"
        line = body.count("\n", 0, place.start()) + 1
        found.append((f"line {line}: {place.group()} {says}", _file(text, place.span(), other)))
    keys = list(re.finditer(r"(lower_deg\s*=\s*)(-?[\d.]+)(,\s*upper_deg\s*=\s*)(-?[\d.]+)", body))
    for pair in dice.sample(keys, min(2, len(keys))):
        swapped = f"{pair[1]}{pair[4]}{pair[3]}{pair[2]}"
        found.append((f"{pair.group()}: limits swapped", _file(text, pair.span(), swapped)))
    return found


def _without_words(text: str) -> str:
    """The same length with blanks for texts in quotes and for comments: what stands there is no number of the file."""
    return re.sub(r'"[^"\n]*"|#[^\n]*', lambda found: " " * len(found.group()), text)


def _file(text: str, span: tuple[int, int], other: str) -> Callable[[], Callable[[], bool]]:
    def plant() -> Callable[[], bool]:
        path = _scratch() / "robot.toml"
        path.write_text(text[: span[0]] + other + text[span[1] :], encoding="utf-8")
        _PLACE["robot"] = path
        return lambda: True

    return plant


# --- commands -----------------------------------------------------------------------------------------------


def command_faults(name: str) -> list[Planted]:
    """What a careless command does, whatever it is for."""
    from olp import cli

    def patched(**names: Any) -> Callable[[], Callable[[], bool]]:
        def plant() -> Callable[[], bool]:
            module = cli.load(name)
            for key, make in names.items():
                setattr(module, key, make(getattr(module, key)))
            return lambda: True

        return plant

    def arguments(change: Callable[[Any], object]) -> Callable[[Any], Any]:
        def make(whole: Any) -> Any:
            def add_arguments(parser: Any) -> None:
                whole(parser)
                change(parser)

            return add_arguments

        return make

    def running(run: Callable[[Any], int]) -> Callable[[Any], Any]:
        return lambda whole: run

    def around(change: Callable[[Any, _Whole], tuple[int, bool]]) -> Callable[[], Callable[[], bool]]:
        """A run that does something else; whether it ever did is told at the end."""

        def plant() -> Callable[[], bool]:
            module, changed = cli.load(name), [False]
            whole = module.run

            def run(args: Any) -> int:
                status, differs = change(args, whole)
                changed[0] |= differs
                return status

            module.run = run  # type: ignore[method-assign]
            return lambda: changed[0]

        return plant

    def ignored(dest: str, usual: Any) -> Callable[[], Callable[[], bool]]:
        def run(args: Any, whole: _Whole) -> tuple[int, bool]:
            differs = vars(args)[dest] != usual  # unseen: the suite notes what a run asks for
            setattr(args, dest, usual)
            return whole(args), differs

        return around(run)

    counts = iter(range(100))
    return [
        *((f"{option} is ignored", ignored(dest, usual)) for option, dest, usual in _some_options(name)),
        ("status 0 whatever is wrong", around(_forgiving)),
        ("a finding is status 2", around(_strict)),
        ("nothing is said", around(_silent)),
        ("another answer each time", around(lambda args, whole: (print(next(counts)) or whole(args), True))),
        ("a file is left behind", around(_leaving)),
        ("an input is touched", around(_touching)),
        ("half of each output file", around(_halving)),
        ("numbers of JSON a thousandth too large", around(_inexact)),
        ("a summary of two lines", patched(SUMMARY=lambda s: f"{s}\nand more")),
        ("a summary of three words", patched(SUMMARY=lambda s: "do it")),
        ("a summary that fills the screen", patched(SUMMARY=lambda s: s * 4)),
        ("a summary with a full stop", patched(SUMMARY=lambda s: f"{s}.")),
        ("an option without help", patched(add_arguments=arguments(lambda p: p.add_argument("--mute")))),
        (
            "an option in capitals",
            patched(add_arguments=arguments(lambda p: p.add_argument("--LOUD", help="x"))),
        ),
        ("an option with _", patched(add_arguments=arguments(lambda p: p.add_argument("--so_so", help="x")))),
        (
            "options that change",
            patched(add_arguments=arguments(lambda p: p.add_argument(f"--n{next(counts)}", help="x"))),
        ),
        ("arguments that fail", patched(add_arguments=arguments(lambda p: 1 / 0))),
        ("abbreviations", patched(add_arguments=arguments(lambda p: setattr(p, "allow_abbrev", True)))),
        (
            "unknown options taken",
            patched(add_arguments=arguments(lambda p: setattr(p, "error", lambda message: None))),
        ),
        ("a traceback for a missing file", patched(run=running(lambda args: [][1]))),
        ("status 0 for a missing file", patched(run=running(lambda args: 0))),
        ("status 3", patched(run=running(lambda args: 3))),
        ("status 2 in silence", patched(run=running(lambda args: 2))),
    ]


_PER_COMMAND: Final = 6  # options that are ignored, one at a time


def _some_options(name: str) -> list[tuple[str, str, Any]]:
    """Option, destination and default of some options of a command, drawn at random."""
    from olp import cli
    from olp.cli.command import Parser

    parser = Parser(name, "")
    cli.load(name).add_arguments(parser)
    options = [
        a for a in parser._actions if a.option_strings and not a.required and a.dest not in ("help", "watch")
    ]
    chosen = random.Random(f"{SEED}{name}").sample(options, min(_PER_COMMAND, len(options)))
    return [(a.option_strings[-1], a.dest, a.default) for a in chosen]


_Whole = Callable[[Any], int]  # the run of a command as it is


def _forgiving(args: Any, whole: _Whole) -> tuple[int, bool]:
    from olp.core.diagnostic import OlpError

    try:
        status = whole(args)
        return min(status, 1), status == 2
    except OlpError as problem:
        print(problem, file=sys.stderr)
        return 0, True


def _strict(args: Any, whole: _Whole) -> tuple[int, bool]:
    status = whole(args)
    return 2 if status else 0, status == 1


def _said(args: Any, whole: _Whole) -> tuple[int, bytes]:
    out = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", write_through=True)
    with contextlib.redirect_stdout(out):
        status = whole(args)
    out.flush()
    return status, out.buffer.getvalue()  # type: ignore[attr-defined]


def _silent(args: Any, whole: _Whole) -> tuple[int, bool]:
    status, out = _said(args, whole)
    return status, bool(out)


def _inexact(args: Any, whole: _Whole) -> tuple[int, bool]:
    status, out = _said(args, whole)
    if out[:1] in (b"{", b"["):
        other = re.sub(rb"\d+\.\d{3,}", lambda found: b"%.6f" % (1.001 * float(found.group())), out)
        sys.stdout.buffer.write(other)
        return status, other != out
    sys.stdout.buffer.write(out)
    return status, False


def _leaving(args: Any, whole: _Whole) -> tuple[int, bool]:
    Path("left.txt").write_text("left", encoding="utf-8")
    return whole(args), True


def _touching(args: Any, whole: _Whole) -> tuple[int, bool]:
    status = whole(args)
    words = [
        word for value in vars(args).values() for word in (value if isinstance(value, list) else [value])
    ]
    for word in words:
        if isinstance(word, str) and Path(word).is_file():
            Path(word).write_bytes(Path(word).read_bytes() + b" ")
            return status, True
    return status, False


def _halving(args: Any, whole: _Whole) -> tuple[int, bool]:
    status = whole(args)
    output = getattr(args, "output", None)
    if output and Path(output).is_file():
        data = Path(output).read_bytes()
        Path(output).write_bytes(data[: len(data) // 2])
        return status, len(data) > 1
    return status, False


# --- hosts --------------------------------------------------------------------------------------------------


def check_host_copy(name: str) -> None:
    from olp.contracts import check_host

    check_host(_PLACE.get("host", ROOT / "hosts" / name), first=True)


def host_faults(name: str) -> list[Planted]:
    """What a careless host does, in a copy of its folder."""

    def copied(change: Callable[[Path], object]) -> Callable[[], Callable[[], bool]]:
        def plant() -> Callable[[], bool]:
            root = _scratch()
            for beside in ("scripts", "tests", "docs", "olp"):
                (root / beside).symlink_to(ROOT / beside)
            (root / "hosts").mkdir()
            for other in (ROOT / "hosts").iterdir():
                if other.name != name:
                    (root / "hosts" / other.name).symlink_to(other)
            folder = root / "hosts" / name
            skipped = shutil.ignore_patterns("node_modules", "__pycache__")
            shutil.copytree(ROOT / "hosts" / name, folder, ignore=skipped)
            change(folder)
            _PLACE["host"] = folder
            return lambda: True

        return plant

    def edit(file: str, change: Callable[[str], str]) -> Callable[[], Callable[[], bool]]:
        return copied(lambda f: (f / file).write_bytes(change((f / file).read_text("utf-8")).encode()))

    return [
        ("no page", copied(lambda f: (f / "README.md").unlink())),
        ("a page without a title", edit("README.md", lambda t: t.replace("# ", "", 1))),
        ("a page that shows nothing", edit("README.md", lambda t: t.split("\n")[0] + "\n\nIt works.\n")),
        ("a link that leads nowhere", edit("README.md", lambda t: f"{t}\nSee [this](no/such/page.md).\n")),
        ("a block of code without an end", edit("README.md", lambda t: f"{t}\n```sh\nolp time x\n")),
        (
            "a command that there is none of",
            edit("README.md", lambda t: f"{t}\n```sh\nolp frobnicate x.jbi\n```\n"),
        ),
        ("no test", copied(lambda f: (f / "test").unlink())),
        ("a test of another shell", edit("test", lambda t: t.replace("#!/bin/sh", "#!/bin/bash", 1))),
        ("a test that says nothing of itself", edit("test", lambda t: t.replace("\n# ", "\n", 1))),
        ("a test that is no shell", edit("test", lambda t: f"{t}\nif then fi (\n")),
        ("a test with CRLF", edit("test", lambda t: t.replace("\n", "\r\n"))),
        (
            "a test that passes whatever happens",
            edit("test", lambda t: f'{t}\n"$OLP_PYTHON" -m pytest x || true\n'),
        ),
        (
            "a test of a file that is not there",
            edit("test", lambda t: f'{t}\n"$OLP_PYTHON" tests/test_nobody.py\n'),
        ),
        (
            "private names",
            copied(lambda f: (f / "more.py").write_text("from olp.core.source import _split\n")),
        ),
        ("broken Python", copied(lambda f: (f / "more.py").write_text("def f(:\n"))),
        ("the author's folder", copied(lambda f: (f / "more.txt").write_text("cd /home/jane/olp\n"))),
    ]
