"""Recordings that were dropped on the page: files or a zip of them become what `olp diagnose` reads.

Codes: Z012 a name or an archive that is not taken, Z013 no recording among the files.
"""

from __future__ import annotations

import io
import os
import re
import zipfile
from collections.abc import Sequence
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

from olp.core.diagnostic import OlpError, error
from olp.core.files import read_input
from olp.servers.folder import too_large
from olp.servers.web.desk import Desk

MOST_FILES = 500
MOST_BYTES = 200_000_000  # of all files together, unpacked
_DEEPEST = 8  # folders
_PART = re.compile(r'[^\x00-\x1f\x7f<>:"/\\|?*]{1,200}')


def plain_path(name: str) -> PurePosixPath:
    """The path that an upload or an archive says, below a folder of its own. Raises OlpError (Z012)."""
    parts = name.split("/")
    plain = len(parts) <= _DEEPEST and all(
        _PART.fullmatch(part) and not part.endswith((".", " ")) for part in parts
    )
    if not plain or (os.name == "nt" and any(PureWindowsPath(part).is_reserved() for part in parts)):
        help = "a plain name, such as recording/moves.csv"
        raise OlpError(error("Z012", f"this is no name for a file: {name[:80]!r}", help=help))
    return PurePosixPath(*parts)


def diagnosed(desk: Desk, folder: Path, job: str) -> dict[str, Any]:
    """The report about the files in `folder`. `job`: the program that ran, "" for none. Raises OlpError."""
    for archive in [file for file in _files(folder) if file.suffix.lower() == ".zip"]:
        _unpack(archive)
        archive.unlink()
    recording = recording_of(desk, folder, job)
    words = [f"--job={job}"] if job else []
    if desk.setting.job.robot and not (recording / "recording.toml").is_file():
        words.append(f"--robot={desk.setting.job.robot}")
    return {"html": desk.page("diagnose", *words, str(recording), "--html")}


def _files(folder: Path) -> list[Path]:
    return sorted((file for file in folder.rglob("*") if file.is_file()), key=lambda file: len(file.parts))


def recording_of(desk: Desk, folder: Path, job: str) -> Path:
    """A recording among the files, or one that `olp recording import` makes of them. Raises OlpError (Z013)."""
    from olp.identification.recording.table import role_of
    from olp.languages.recorders import recorders

    files = _files(folder)
    tables = [file for file in files if role_of(file)]
    ready = next((file.parent for file in tables if role_of(file) in ("moves", "sim_log")), None)
    if ready is not None:
        return ready
    made = folder / "imported"
    traces = [file for file in files if any(one.set_of(file) is not None for one in recorders())]
    logs = [] if traces else _logs(desk, files, tables)
    if traces or logs or (job and len(tables) == 1):
        words = [f"--job={job}"] if job and not traces else []
        words += [f"--robot={desk.setting.job.robot}"] if desk.setting.job.robot else []
        sources = traces or logs or tables
        desk.ran("recording", "import", *words, f"--output={made}", *map(str, sources))
        return made
    if len(tables) == 1:
        return tables[0]
    names = ", ".join(file.name for file in files[:5])
    help = "drop a recording's folder or a zip of it, one table of moves, or a controller's traces or logs"
    raise OlpError(error("Z013", f"no recording among these files: {names}", help=help))


def _logs(desk: Desk, files: Sequence[Path], tables: Sequence[Path]) -> list[Path]:
    """ROS recordings, or tables of samples. Raises OlpError for what is no table."""
    from olp.identification.recording.importing import ImportOptions, is_log
    from olp.identification.recording.ros_bag import is_bag
    from olp.robots.robot import load_robot

    bags = [file.parent for file in files if is_bag(file.parent)] or [file for file in files if is_bag(file)]
    robot = load_robot(desk.setting.job.robot) if desk.setting.job.robot else None
    return list(dict.fromkeys(bags)) or [file for file in tables if is_log(file, ImportOptions(robot=robot))]


def _unpack(archive: Path) -> None:
    """The files of an archive, beside it. Raises OlpError (Z003, Z012) before one of them is written."""
    try:
        with zipfile.ZipFile(io.BytesIO(read_input(archive, MOST_BYTES))) as packed:
            members = [member for member in packed.infolist() if not member.is_dir()]
            if len(members) > MOST_FILES:
                raise OlpError(error("Z012", f"this archive has {len(members)} files, {MOST_FILES} are read"))
            size = sum(member.file_size for member in members)
            if size > MOST_BYTES:
                raise OlpError(too_large(archive.name, size, MOST_BYTES))
            targets = [archive.parent / plain_path(member.filename) for member in members]
            for member, target in zip(members, targets, strict=True):
                target.parent.mkdir(parents=True, exist_ok=True)
                # A header that says less than there is ends in an error of zipfile.
                target.write_bytes(packed.read(member))
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, OSError, EOFError) as problem:
        says = f"this archive cannot be read: {problem}"
        raise OlpError(error("Z012", says, file=archive.name, help="drop its files, unpacked")) from None
