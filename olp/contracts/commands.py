"""What every command promises: `check_command`."""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import subprocess
import sys
import tempfile
import zlib
from argparse import Action, Namespace
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property, lru_cache
from itertools import product
from pathlib import Path
from typing import Any, Final, NamedTuple

from olp import cli
from olp.__main__ import main
from olp.cli.command import Parser
from olp.contracts.arguments import Given, files, given
from olp.contracts.promises import Difference, Promise, hold
from olp.core.diagnostic import OlpError

_HEAVY: Final = ("numpy", "pandas", "lark", "rich", "jinja2", "scipy", "pyarrow", "multiprocessing")
EFFECTS: Final = Path(__file__).resolve().parents[2] / "tests" / "data" / "command_effects.json"
_MANY: Final = 8  # commands that have an option: it is a shared one
_GARBAGE: Final = b"\x00\xff??; {[(\r\n\x1b[31m" * 3


def check_command(name: str, *, first: bool = False, options: int | None = None) -> None:
    """Raises ContractError with every promise of a command line that the command `name` ("robot import") breaks.

    Arguments are given what their names ask for (`olp.contracts.arguments`). What it computes is not judged here.
    `options`: of its own, how many are tried (None: all, and the whole run twice).

        from olp.contracts import check_command
        check_command("time")
    """
    hold(f"command {name}", CommandUnderTest(name, options), PROMISES, first=first)


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
    for action in it.parser()._actions:
        if not action.help or not action.help.strip():
            yield str(action.option_strings or action.dest), "it has no help"


def names_options_alike(it: CommandUnderTest) -> Iterator[Difference]:
    """Options are words with hyphens, short ones are one letter, and no option changes another's default"""
    for action in it.parser()._actions:
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
    """All required arguments, with `path` for those that accept any text; None if no argument does."""
    words: list[str] = []
    free = False
    for action in it.parser()._actions:
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
    heavy = _imported().get(it.name, "[]")
    if heavy != "[]":
        yield f"import of {it.module.__name__}", heavy


@lru_cache(maxsize=1)
def _imported() -> Mapping[str, str]:
    """What each command's module has imported that takes time, those before it left out."""
    code = (
        "import sys; from olp import cli; seen = set()\n"
        "for name in cli.names():\n"
        "    cli.load(name)\n"
        f"    print(name, [m for m in {_HEAVY!r} if m in sys.modules and m not in seen], sep='\\t')\n"
        "    seen |= set(sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return {name: said for name, _, said in (line.partition("\t") for line in done.stdout.splitlines())}


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


# --- at work --------------------------------------------------------------------------------------------------


def does_its_work(it: CommandUnderTest) -> Iterator[Difference]:
    """On good words for all that it requires a command ends with 0 or 1, and says the same the second time"""
    if getattr(it.module, "SERVES", False):
        return
    for action in it.actions:
        if given(action) is None:
            yield f"{action.dest} {action.metavar}", "olp/contracts/arguments.py knows no word for it"
    if not it.first:
        last = next(reversed(it.tried.values()), None)
        yield it.name, f"no words do: {last.told[:200] if last else 'none were tried'}"
        return
    for words in it.first:
        yield from _leaves_alone(it, words)
    if it.most is not None:
        return
    one = it.tried.pop(tuple(it.first[0]))
    other = it.work(*it.first[0])
    if not one.same(other):
        yield " ".join(it.first[0]), "another answer the second time"


def heeds_every_option(it: CommandUnderTest) -> Iterator[Difference]:
    """Every option changes what is said or written where it was seen to, or is refused or at least asked for"""
    known = effects().get(it.name, {})
    for action in _judged(it) if it.first else ():
        option = action.option_strings[-1]
        if option in known and known[option][0] >= 0:
            base, value = known[option]
            words = it.first[base]
            if it.work(*it.with_option(words, action, value)).same(it.work(*words)):
                yield f"{' '.join(words)} {option} {value}", "nothing changes any more"
        elif not _is_asked_for(it, action) and effect_of(it, action) is None:
            yield option, "nothing changes, and nothing asks for it"


def _judged(it: CommandUnderTest) -> list[Action]:
    """Its own options, and one of those that many commands have: they go the same way."""
    options = [action for action in it.options if action.dest != "watch"]
    shared = [action for action in options if action.option_strings[-1] in _shared()]
    drawn = shared[zlib.crc32(it.name.encode()) % len(shared) :][:1] if shared else []
    own = sorted(
        (action for action in options if action not in shared),
        key=lambda action: zlib.crc32(f"{it.name} {action.dest}".encode()),
    )
    return [*own[: it.most], *drawn]


@lru_cache(maxsize=1)
def effects() -> Mapping[str, Mapping[str, tuple[int, str]]]:
    """Which option of which command changes an answer, by which first words and value; none outside a checkout."""
    return json.loads(EFFECTS.read_text(encoding="utf-8")) if EFFECTS.exists() else {}


def _leaves_alone(it: CommandUnderTest, words: Sequence[str]) -> Iterator[Difference]:
    done, (_, page, _) = it.work(*words), it.run("--help")
    if not (done.out or done.told or done.files):
        yield " ".join(words), "nothing is said and nothing written"
    usual = [str(action.default) for action in it.options if action.default]
    for name in done.files:
        if name in usual or Path(name).name in page:
            continue
        if not any(name == word or name.startswith(f"{word}/") for word in words):
            yield " ".join(words), f"writes {name}, which nothing names"
        elif name in done.changed:
            yield " ".join(words), f"changes {name}, an input"


@lru_cache(maxsize=1)
def _shared() -> frozenset[str]:
    """Options that many commands have."""
    names = Counter(
        action.option_strings[-1] for name in cli.names() for action in CommandUnderTest(name).options
    )
    return frozenset(name for name, count in names.items() if count > _MANY) - {"--output"}


def _is_asked_for(it: CommandUnderTest, action: Action) -> bool:
    """Whether the command looks at what was said, before it says something else itself."""
    known = given(action)
    if known is None or not known.good:
        return True
    done = it.work(*it.with_option(it.first[0], action, known.good[0]))
    return done.status == 2 or action.dest in done.read


def effect_of(it: CommandUnderTest, action: Action) -> tuple[int, str] | None:
    """The first words (their index) and the value that change an answer; None where none is known."""
    known = given(action)
    good = known.good if known else ()
    for base, words in enumerate(it.first):
        for value in good:
            done = it.work(*it.with_option(words, action, value))
            if done.status != 2 and not done.same(it.work(*words)):
                return base, value
    words, there = _writing(it)
    if there and good:
        again = it.work(*it.with_option(words, action, good[0]), beside=there)
        if not again.same(it.work(*words, beside=there)):
            return -1, good[0]
    return None


def _writing(it: CommandUnderTest) -> tuple[list[str], Mapping[str, bytes]]:
    """Words with which it writes files, and those; none where it never does."""
    ways = [it.first[0]]
    for action in it.options:
        known = given(action)
        if action.dest == "output" and known is not None:
            ways += [it.with_option(it.first[0], action, value) for value in known.good]
    for words in ways:
        done = it.work(*words)
        if done.files and done.status != 2:
            return words, done.files
    return [], {}


def refuses_bad_words(it: CommandUnderTest) -> Iterator[Difference]:
    """A bad value of any argument ends with 2 and an error that names it, and nothing is written"""
    for action in it.actions:
        known = given(action)
        for bad in known.bad if known and it.first else ():
            put = it.with_option if action.option_strings else it.with_positional
            words = put(it.first[-1], action, bad)
            done = it.work(*words) if words else None
            if done is None:
                continue
            if done.status != 2 or "error[" not in done.told + done.text:
                yield " ".join(words), f"status {done.status}, {done.told[:80]!r}"
            elif not _names(done, action, bad):
                yield " ".join(words), f"the refusal names neither: {done.told[:80]!r}"
            elif done.files.keys() - it.work(*it.first[-1]).files.keys():
                yield " ".join(words), f"writes {', '.join(done.files)}"


def _names(done: CommandOutcome, action: Action, bad: str) -> bool:
    told = (done.told + done.text).lower()
    words = [*re.split("[=,/]", bad.lower()), *action.option_strings[-1:], str(action.metavar).lower()]
    return any(word and word in told for word in words)


def ends_as_it_says(it: CommandUnderTest) -> Iterator[Difference]:
    """Status 2 comes with an error, an error that is told comes with 2, and 0 and 1 are the other two"""
    for words, done in list(it.tried.items()):
        wrong = "error[" in done.told
        if done.status not in (0, 1, 2) or (done.status == 2 and not (done.told or done.out).strip()):
            yield " ".join(words), f"status {done.status}, {done.told[:80]!r}"
        if wrong and done.status != 2:
            yield " ".join(words), f"status {done.status} and {done.told[:80]!r}"
        if "Traceback" in done.told + done.text or "\x1b[" in done.text:
            yield " ".join(words), "a traceback, or colours in a file"
        if any(name.endswith(".part") for name in done.files):
            yield " ".join(words), "half a file is left"


def says_the_same_as_data(it: CommandUnderTest) -> Iterator[Difference]:
    """JSON is JSON, ends with the same status as text, and holds every number that the text says"""
    for action in it.options:
        known = given(action)
        if not it.first or action.dest not in ("format", "json") or known is None:
            continue
        flag = action.nargs == 0
        if not flag and "json" not in known.good:
            continue
        words, value = it.first[-1], "-" if action.dest == "json" else "json"
        plain, done = it.work(*words), it.work(*it.with_option(words, action, value))
        try:
            values = [abs(x) for x in _numbers(json.loads(done.text))]
        except ValueError:
            yield action.option_strings[-1], f"no JSON: {done.text[:80]!r}"
            continue
        if done.status != plain.status:
            yield action.option_strings[-1], f"status {done.status}, as text {plain.status}"
        lost = [
            text
            for text in re.findall(r"(?<![\w.])\d+\.\d+(?![\w.])", plain.text)
            if not _holds(values, text)
        ]
        if lost:
            yield action.option_strings[-1], f"the text says {', '.join(lost[:6])}, the data do not"


def _numbers(value: Any) -> Iterator[float]:
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for one in value:
            yield from _numbers(one)
    elif isinstance(value, str):
        yield from (float(x) for x in re.findall(r"\d+(?:\.\d+)?", value))
    elif isinstance(value, int | float):
        yield float(value)


def _holds(values: Sequence[float], text: str) -> bool:
    number, least = float(text), 0.51 * 10.0 ** -len(text.partition(".")[2])
    return any(abs(value * unit - number) <= least for value in values for unit in (1.0, 100.0, 1e3, 1e-3))


def writes_what_it_says(it: CommandUnderTest) -> Iterator[Difference]:
    """What -o writes is what standard output shows; a file is whole or absent, and never an input"""
    output = next((action for action in it.options if action.dest == "output" and not action.required), None)
    if output is None or not it.first or set(output.option_strings) & set(it.first[0]):
        return
    plain, words = it.work(*it.first[0]), it.with_option(it.first[0], output, "made.txt")
    done = it.work(*words)
    if done.status == 2 and done.files.keys() - plain.files.keys():
        yield " ".join(words), f"refused, and {', '.join(done.files)} written"
    elif done.status != 2 and done.files.get("made.txt") != plain.out:
        yield " ".join(words), "the file is not there, or holds another text than standard output"
    for word in it.first[0]:
        if "." in word and not word.startswith("-"):
            done = it.work(*it.with_option(it.first[0], output, word))
            if done.status != 2 or word in done.files:
                yield f"-o {word}, an input", f"status {done.status}"


PROMISES: Final[tuple[Promise[CommandUnderTest], ...]] = (
    is_explained,
    names_options_alike,
    answers_wrong_arguments,
    answers_bad_files,
    runs_again,
    imports_late,
    does_its_work,
    heeds_every_option,
    refuses_bad_words,
    says_the_same_as_data,
    writes_what_it_says,
    ends_as_it_says,
)


# --- Runs of one command line, in a folder that has all that arguments name ---


_ASKED_AGAIN: Final = 4  # times that a refusal may name an option that is wanted as well
_FIRST: Final = 2  # different runs that options are tried on
_DATES: Final = re.compile(rb"\d{4}[-/]\d\d[-/]\d\d([T ]\d\d:\d\d(:\d\d)?)?|\b\d\d:\d\d(:\d\d)?\b")
_PREPARED: Final = (
    "calibrate recording --method constant -o one.signature.json",
    "calibrate recording --method factors -o other.signature.json",
    "check cell --no-cache --store olp.db",
    "check cell --no-cache --store olp.db",
    "lint cell --write-baseline known.json",
)


class CommandOutcome(NamedTuple):
    """What one run did. `files`: those that it made or changed. `changed`: those that were there.

    `read`: the arguments that it asked for.
    """

    status: int
    out: bytes
    told: str
    files: Mapping[str, bytes]
    read: frozenset[str] = frozenset()
    changed: frozenset[str] = frozenset()

    @property
    def text(self) -> str:
        return self.out.decode("utf-8", "replace")

    def same(self, other: CommandOutcome) -> bool:
        """Whether it said and wrote the same, dates apart."""
        return _undated(self) == _undated(other)


def _undated(done: CommandOutcome) -> tuple[object, ...]:
    files = {name: _DATES.sub(b"~", data) for name, data in done.files.items()}
    return done.status, _DATES.sub(b"~", done.out), _DATES.sub(b"~", done.told.encode()), files


@lru_cache(maxsize=1)
def _place() -> tuple[tempfile.TemporaryDirectory[str], dict[str, bytes]]:
    """The folder that has everything, and what lies in it; every run leaves it so."""
    folder = tempfile.TemporaryDirectory(prefix="olp-commands-")
    for name, data in files().items():
        path = Path(folder.name, name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    with contextlib.chdir(folder.name):
        for words in _PREPARED:
            said(words.split())
    return folder, _files(Path(folder.name))


def said(words: Sequence[str]) -> tuple[int, bytes, str]:
    """Status, standard output and standard error of a command line, here."""
    out = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", write_through=True)
    told = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(told):
        status = main(list(words))
    out.flush()
    return status, out.buffer.getvalue(), told.getvalue()


class _WatchedArguments(Namespace):
    """The arguments of a run, which note what is asked of them before the run sets it itself."""

    def __init__(self, arguments: Mapping[str, Any], read: set[str]) -> None:
        self._read, self._set = read, set[str]()
        super().__init__(**arguments)
        self._set.clear()

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_") and hasattr(self, "_set"):
            self._set.add(name)
        super().__setattr__(name, value)

    def __getattribute__(self, name: str) -> Any:
        if not name.startswith("_") and name not in super().__getattribute__("_set"):
            super().__getattribute__("_read").add(name)
        return super().__getattribute__(name)


class CommandUnderTest:
    """A command, and what it did on the first good words of its arguments."""

    def __init__(self, name: str, most: int | None = None) -> None:
        self.name, self.most = name, most  # `most`: options of its own that are tried
        self.module: Any = cli.load(name)
        self.tried: dict[tuple[str, ...], CommandOutcome] = {}

    def parser(self) -> Parser:
        made = Parser(f"olp {self.name}", self.module.SUMMARY)
        self.module.add_arguments(made)
        return made

    @cached_property
    def actions(self) -> list[Action]:
        return [action for action in self.parser()._actions if action.dest != "help"]

    @property
    def options(self) -> list[Action]:
        return [action for action in self.actions if action.option_strings]

    @property
    def positionals(self) -> list[Action]:
        return [action for action in self.actions if not action.option_strings]

    def run(self, *words: str) -> tuple[int, str, str]:
        """Status, standard output and standard error."""
        status, out, told = said([*self.name.split(), *words])
        return status, out.decode("utf-8", "replace"), told

    def work(self, *words: str, beside: Mapping[str, bytes] | None = None) -> CommandOutcome:
        """What it does in the folder that has everything, and `beside`; the folder is put back."""
        if words not in self.tried or beside:
            (place, before), read = _place(), set[str]()
            folder, whole = Path(place.name), self.module.run
            for name, data in (beside or {}).items():
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                (folder / name).write_bytes(data)
            self.module.run = lambda args: whole(_WatchedArguments(vars(args), read))
            try:
                with contextlib.chdir(folder):
                    status, out, told = said([*self.name.split(), *words])
            finally:
                self.module.run = whole
                made = _put_back(folder, before)
            done = CommandOutcome(
                status, out, told, made, frozenset(read), frozenset(made.keys() & before.keys())
            )
            if beside:
                return done
            self.tried[words] = done
        return self.tried[words]

    @cached_property
    def first(self) -> list[list[str]]:
        """Words with which it does its work, at most two: what its parser requires, and what it then asks for."""
        if getattr(self.module, "SERVES", False):
            return []
        alone = all(action.nargs in ("*", "?") for action in self.positionals)
        needed = [a for a in self.positionals if alone or a.nargs not in ("*", "?")]
        needed += [a for a in self.options if a.required]
        found: list[list[str]] = []
        for chosen in product(*[[(a, word) for word in _known(a).good] for a in needed]):
            words = self._accepted([word for a, value in chosen for word in (*a.option_strings[:1], value)])
            found += [words] if words is not None else []
            if len(found) == _FIRST:
                break
        return found

    def _accepted(self, words: list[str]) -> list[str] | None:
        for _ in range(_ASKED_AGAIN):
            done = self.work(*words)
            if done.status in (0, 1):
                return words
            more = [word for action in self.options for word in _named(action, done.told, words)]
            if not more:
                return None
            words = [*words, *more]
        return None

    def with_option(self, words: Sequence[str], action: Action, value: str) -> list[str]:
        """The words with another value of an option."""
        name = action.option_strings[-1]
        if action.nargs == 0:
            return [*words, name]
        kept = list(words)
        for there in set(action.option_strings) & set(words):
            at = kept.index(there)
            kept[at : at + 2] = []
        return [*kept, f"{name}={value}"]

    def with_positional(self, words: Sequence[str], action: Action, value: str) -> list[str]:
        """The words with another value of an argument that has no name; [] where none is given."""
        at = self.positionals.index(action)
        given_ones = [k for k, word in enumerate(words) if not word.startswith("-")]
        return [*words[:at], value, *words[at + 1 :]] if at < len(given_ones) else []


def _known(action: Action) -> Given:
    return given(action) or Given(())


def _named(action: Action, told: str, words: Sequence[str]) -> Iterator[str]:
    """An option with its first good word, where a refusal names it and it was not said."""
    named = set(re.findall(r"(?<![\w-])--?[a-z][\w-]*", told)) & set(action.option_strings)
    if named and not set(words) & set(action.option_strings):
        yield action.option_strings[0]
        yield from _known(action).good[:1] if action.nargs != 0 else ()


def _files(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()
    }


def _put_back(folder: Path, before: Mapping[str, bytes]) -> dict[str, bytes]:
    """What a run made or changed; the folder is as before."""
    after = _files(folder)
    made = {name: data for name, data in after.items() if before.get(name) != data}
    for name in after.keys() - before.keys():
        (folder / name).unlink()
    for name in (before.keys() & made.keys()) | (before.keys() - after.keys()):
        (folder / name).write_bytes(before[name])
    for root, folders, _ in os.walk(folder, topdown=False):
        for name in folders:
            with contextlib.suppress(OSError):
                (Path(root) / name).rmdir()
    return made
