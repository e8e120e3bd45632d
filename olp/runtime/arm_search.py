"""Which arm a folder of programs is for: a robot file in it, a controller's backup, or what a program's head says."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from olp.core.diagnostic import OlpError
from olp.languages.read import read
from olp.languages.vendor import find_vendor
from olp.robots.library import library_name, load_robot, robot_names
from olp.runtime.folder import backup_of

_HEAD = 60  # lines of a program in which whoever wrote it says what it is for
_MOST_FILES = 200  # that are looked at in a folder
_WORDS = 4  # that a model's name may be spelt in: LR Mate 200iD 7L
_LEAST = 4  # letters and digits of a name that stands in no other word by chance


class ArmSource(NamedTuple):
    """An arm and what says so.

    `name`: of the library, the path of a robot file, or "" for a backup whose parameters are the arm: runs read them.
    """

    name: str
    why: str


def find_arms(folder: Path, programs: Sequence[str]) -> list[ArmSource]:
    """The arms that something in `folder` names, each once: robot files before backups before heads of programs."""
    found: dict[str, ArmSource] = {}
    folders = list(dict.fromkeys([folder, *(Path(program).parent for program in programs)]))[:_MOST_FILES]
    for search in (_robot_files(folders), _backups(folders), _heads(programs)):
        for arm in search:
            found.setdefault(arm.name, arm)
        if found:
            break
    return list(found.values())


def _robot_files(folders: Iterable[Path]) -> Iterator[ArmSource]:
    for folder in folders:
        for file in sorted(folder.glob("*.toml"))[:_MOST_FILES]:
            try:
                robot = load_robot(file)
            except OlpError:
                continue  # another TOML file
            if robot.kind == "arm":
                yield ArmSource(str(file), f"the robot file of {robot.name}")


def _backups(folders: Iterable[Path]) -> Iterator[ArmSource]:
    from olp.robots.backup.import_check import model_of
    from olp.robots.backup.machine_dat import find_machine_data, model_in, read_machine_data

    for folder in folders:
        backup = backup_of(folder)
        if backup is not None:
            name = library_name(model_of(backup, "R1"))
            if name or backup.groups:
                yield ArmSource(name, f"the backup in {folder.as_posix()}")
        data = find_machine_data(folder)
        if data is not None and (name := library_name(model_in(read_machine_data(data)))):
            yield ArmSource(name, f"the machine data {data.as_posix()}")


def _heads(programs: Sequence[str]) -> Iterator[ArmSource]:
    for path in programs[:_MOST_FILES]:
        try:
            program = read(path)
        except OlpError:
            continue
        sign = find_vendor(program.vendor).comment_prefix.strip(" :")
        for number, line in enumerate(program.source.lines[:_HEAD], 1):
            for name in models_in(line.partition(sign)[2]):
                yield ArmSource(name, f"the comment in {Path(path).as_posix()}:{number}")


def models_in(text: str) -> list[str]:
    """The library's names of the models that stand in `text` as words, the longest where they overlap."""
    # A name ends where its word does: GP25-12 is another arm than GP25.
    words = [plain for word in re.split(r"[\s,;:()\"']+", text.lower()) if (plain := _plain(word.strip(".")))]
    models = {_plain(name.partition("/")[2]): name for name in robot_names()}
    found, at = [], 0
    while at < len(words):
        spans = range(min(_WORDS, len(words) - at), 0, -1)
        size = next(
            (n for n in spans if len(said := "".join(words[at : at + n])) >= _LEAST and said in models), 0
        )
        if size:
            found.append(models["".join(words[at : at + size])])
        at += max(size, 1)
    return found


def _plain(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", name)
