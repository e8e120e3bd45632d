"""Runs of one command line in a folder that has all that arguments name: what `check_command` compares."""

from __future__ import annotations

import contextlib
import io
import os
import re
import tempfile
from argparse import Action, Namespace
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property, lru_cache
from itertools import product
from pathlib import Path
from typing import Any, Final, NamedTuple

from olp import cli
from olp.__main__ import main
from olp.cli.command import Parser
from olp.contracts.arguments import Given, files, given

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
def _place() -> tempfile.TemporaryDirectory[str]:
    folder = tempfile.TemporaryDirectory(prefix="olp-commands-")
    for name, data in files().items():
        path = Path(folder.name, name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    with contextlib.chdir(folder.name):
        for words in _PREPARED:
            said(words.split())
    return folder


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
            folder, read = Path(_place().name), set[str]()
            before, whole = _files(folder), self.module.run
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
