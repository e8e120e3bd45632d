"""What a worker answers with: the files of the folder, and the command line.

The server and its workers exchange JSON objects, each behind its length, over pipes. Recordings that were dropped on
the page, files or a zip of them, become what `olp diagnose` reads.

Codes: Z012 a name or an archive that is not taken, Z013 no recording among the files.
"""

from __future__ import annotations

import io
import json
import os
import re
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import TYPE_CHECKING, Any, BinaryIO

from olp.core.diagnostic import OlpError, error
from olp.core.files import parse_json, read_input
from olp.identification.timing_job import TimingJob
from olp.servers.confinement import CommandLine, captured
from olp.servers.folder import Folder, too_large

if TYPE_CHECKING:
    from olp.ir.program import Program
    from olp.timing.result import Timing


HEAD = 8  # [bytes] that say how long a message is
DROPPED = "recording"  # the folder of an upload, in a worker's temporary one


@dataclass(frozen=True, slots=True)
class WorkerSetting:
    """What a worker begins with. `root`: the folder, absolute, without links; `temporary`: its own, empty.

    `job`: how programs are timed; `words`: the same as options of the command line. `also`: files outside of the
    folder that these name. `memory`, `file` [bytes]: of the process, and of one file that is read.
    """

    root: str
    temporary: str
    job: TimingJob
    words: tuple[str, ...] = ()
    also: tuple[str, ...] = ()
    memory: int = 4_000_000_000
    file: int = 100_000_000

    def as_json(self) -> dict[str, Any]:
        return asdict(self)

    @classmethod
    def from_json(cls, told: dict[str, Any]) -> WorkerSetting:
        lists: dict[str, Any] = {name: tuple(told[name]) for name in ("words", "also")}
        return cls(**(told | lists | {"job": TimingJob(**told["job"])}))

    @property
    def folder(self) -> Path:
        return Path(self.root)


def packed(message: Any) -> bytes:
    """Return a message as bytes: its length in `HEAD` bytes, then its JSON text."""
    data = json.dumps(message, allow_nan=False).encode("utf-8", "replace")
    return len(data).to_bytes(HEAD, "big") + data


def received(stream: BinaryIO) -> Any:
    """Return the next message of the stream; None at its end."""
    head = stream.read(HEAD)
    if len(head) < HEAD:
        return None
    return parse_json(stream.read(int.from_bytes(head, "big")))


@dataclass
class Desk:
    """What answers are made with. `timed`: the program that was asked about last, as it stands on the disk."""

    setting: WorkerSetting
    temporary: Path
    command_line: CommandLine
    timed: tuple[tuple[str, str], Program, Timing] | None = None

    def file(self, given: Mapping[str, Any], name: str = "file") -> str:
        """Return the path of a file of the folder that the request names. Raises OlpError (Z001, Z002, Z006)."""
        path = given.get(name)
        if not isinstance(path, str):
            raise OlpError(error("Z006", f"{name}: must be a text, the path of a file"))
        plain = Folder(self.setting.folder).inside(path)
        if os.path.isdir(plain):
            raise OlpError(error("Z002", "this is a folder, not a file", file=plain))
        return plain

    def ran(self, *words: str) -> bytes:
        """Return what `olp WORD…` printed. Raises OlpError for bad input."""
        return captured(self.command_line, words).printed

    def page(self, *words: str) -> str:
        """Run `olp WORD… FILE` and return the text that it wrote to FILE. Raises OlpError for bad input."""
        target = self.temporary / "page.html"
        try:
            captured(self.command_line, [*words, str(target)])
            return read_input(target).decode("utf-8")
        finally:
            target.unlink(missing_ok=True)


MOST_FILES = 500
MOST_BYTES = 200_000_000  # of all files together, unpacked
_DEEPEST = 8  # folders
_PART = re.compile(r'[^\x00-\x1f\x7f<>:"/\\|?*]{1,200}')


def plain_path(name: str) -> PurePosixPath:
    """Return the relative path that an upload or an archive names. Raises OlpError (Z012) for one that is not
    allowed.
    """
    parts = name.split("/")
    plain = len(parts) <= _DEEPEST and all(
        _PART.fullmatch(part) and not part.endswith((".", " ")) for part in parts
    )
    if not plain or (os.name == "nt" and any(PureWindowsPath(part).is_reserved() for part in parts)):
        help = "a plain name, such as recording/moves.csv"
        raise OlpError(error("Z012", f"this is no name for a file: {name[:80]!r}", help=help))
    return PurePosixPath(*parts)


def diagnosed(desk: Desk, folder: Path, job: str) -> dict[str, Any]:
    """Return the diagnosis of the recording in `folder`. `job`: the program that ran, "" for none. Raises OlpError."""
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
    """Extract an archive beside it. Raises OlpError (Z003, Z012) before any file is written."""
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
    except (zipfile.BadZipFile, RuntimeError, OSError, EOFError) as problem:
        says = f"this archive cannot be read: {problem}"
        raise OlpError(error("Z012", says, file=archive.name, help="drop its files, unpacked")) from None
