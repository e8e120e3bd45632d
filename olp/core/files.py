"""Files that a user names: found as inputs and read, if they are plain files; written whole or not at all.

No output replaces an input unless asked.

Codes: C003 no such file, C004 a folder without such files, C005 the operating system refused, C006 an input would be
overwritten.
"""

from __future__ import annotations

import errno
import json
import os
import stat
import sys
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

from olp.core.diagnostic import Diagnostic, OlpError, error, visible_styled


def write_output(
    path: str | Path | None, data: bytes | str, *, inputs: Iterable[str | Path] = (), in_place: bool = False
) -> None:
    """Writes `data` to `path`, whole or not at all; None or "-" is standard output.

    The data are written beside the target and moved into place, so a full disk or a lost connection never
    leaves half a program. Text becomes UTF-8. A target that is one of `inputs` is refused with OlpError unless
    `in_place`.
    Raises OSError.
    """
    if isinstance(data, str):
        data = shown(data) if path is None or str(path) == "-" else utf8(data)
    if path is None or str(path) == "-":
        sys.stdout.flush()
        sys.stdout.buffer.write(data)
        sys.stdout.buffer.flush()
        return
    if not in_place:
        refuse_inputs(path, inputs)
    # Replacing a link would leave the file it names as it was.
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_file():
        try:
            _into_device(target, data)  # a device or a pipe cannot be replaced, a folder says so
        except OSError as problem:
            raise type(problem)(problem.errno, problem.strerror, str(path)) from None
    else:
        _replace(target, data)


def named_like(path: str, other: str) -> str:
    """A file below the working directory as people name `other`: relative where that is relative."""
    # Asked for each finding of a run, which may be one per move; most paths are known by their first letter.
    if not os.path.isabs(path) or not other or os.path.isabs(other):
        return path
    return _below(path, os.getcwd())


@lru_cache(maxsize=256)
def _below(path: str, folder: str) -> str:
    """`path` as seen from a folder that it is in; as it is where it is elsewhere."""
    file = Path(path)
    return str(file.relative_to(folder)) if file.is_relative_to(folder) else path


def refuse_inputs(path: str | Path, inputs: Iterable[str | Path]) -> None:
    """Raises OlpError when `path` is one of `inputs` under whatever name (link, other case, relative)."""
    for source in map(Path, inputs):
        if os.path.exists(path) and source.exists() and os.path.samefile(path, source):
            raise OlpError(
                error(
                    "C006",
                    "this output would overwrite its input",
                    file=str(path),
                    help="name another file with -o, or say --in-place where the command has it",
                )
            )


def write_together(files: Mapping[Path, bytes]) -> None:
    """Write all files, or none of them when one cannot be written. Raises OSError.

    Each file is written beside its target first; the targets are replaced when all of them are written.
    """
    parts = {_beside(target): target for target in files}
    try:
        for part, target in parts.items():
            part.write_bytes(files[target])
        for part, target in parts.items():
            os.replace(part, target)
    finally:
        for part in parts:
            part.unlink(missing_ok=True)


def _beside(target: Path) -> Path:
    """Return the path of a new hidden file in the target's folder; its random name cannot clash with a file left by
    a killed run.
    """
    return target.with_name(f".olp-{os.urandom(8).hex()}.part")


def _into_device(target: Path, data: bytes) -> None:
    """Write `data` to a device or pipe. Raises OSError, also for a pipe without a reader, instead of waiting for
    one.
    """
    descriptor = os.open(target, os.O_WRONLY | getattr(os, "O_BINARY", 0) | getattr(os, "O_NONBLOCK", 0))
    with open(descriptor, "wb") as file:
        if hasattr(os, "set_blocking"):
            os.set_blocking(descriptor, True)
        file.write(data)


def _replace(target: Path, data: bytes) -> None:
    beside = _beside(target)
    try:
        with open(beside, "xb") as file:
            file.write(data)
            if target.exists():
                # What is about to be lost must not be replaced by data that are still on their way.
                file.flush()
                os.fsync(file.fileno())
                os.chmod(beside, stat.S_IMODE(target.stat().st_mode))
        os.replace(beside, target)
    except FileNotFoundError as problem:
        raise FileNotFoundError(problem.errno, problem.strerror, str(target.parent)) from None
    finally:
        beside.unlink(missing_ok=True)


_ADVICE: Mapping[type[OSError], str] = {
    FileNotFoundError: "create the folder first, or name another one",
    FileExistsError: "a file is where a folder has to be: name another folder",
    IsADirectoryError: "name a file in this folder",
    PermissionError: "ask for the right to write there, or name another file with -o",
}


MOST_BYTES = 500_000_000  # of an input that has no bound of its own


def read_input(path: str | os.PathLike[str], most: int = MOST_BYTES, first: int | None = None) -> bytes:
    """Return the bytes of a plain file of at most `most` bytes; with `first`, only its first `first` bytes.

    Raises OSError for a larger file and for anything else than a plain file: reading a pipe or a device may never
    end.
    """
    # Without blocking, for what was a file may be a pipe when it is opened.
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_BINARY", 0) | getattr(os, "O_NONBLOCK", 0))
    kind = os.fstat(descriptor)
    if not stat.S_ISREG(kind.st_mode):
        os.close(descriptor)
        raise OSError(errno.EINVAL, "this is not a plain file", os.fspath(path))
    with open(descriptor, "rb") as file:
        data = file.read(most + 1 if first is None else first) if kind.st_size <= most else b""
    if kind.st_size > most or len(data) > most:
        raise OSError(errno.EFBIG, f"this file has more than {most / 1e6:g} MB", os.fspath(path))
    return data


@contextmanager
def temporary_cell() -> Generator[Path]:
    """An empty folder for the programs of a cell, deleted afterwards.

    Readers look for routines and settings in the folders around a program. Those around this one are empty, whatever
    lies in the system's folder for temporary files, and the search for an olp.toml ends there as at a repository.
    """
    import tempfile  # a hundredth of a second, for every command that reads a file

    with tempfile.TemporaryDirectory(prefix="olp-") as above:
        for name in ("cell", ".git"):
            Path(above, name).mkdir()
        yield Path(above, "cell")


def parse_json(data: str | bytes) -> Any:
    """Return the value of a JSON text. Raises ValueError, also for text that nests too deeply or is not UTF-8."""
    try:
        return json.loads(data.decode("utf-8-sig") if isinstance(data, bytes) else data)
    except UnicodeDecodeError:
        raise ValueError("this is not UTF-8 text") from None
    except RecursionError:
        raise ValueError("brackets within brackets without an end") from None


def from_os_error(problem: OSError) -> Diagnostic:
    """Return an operating system's error as a diagnostic (C005) with the file and the system's reason."""
    file = problem.filename if problem.filename is not None else ""
    says = problem.strerror or str(problem)
    return error("C005", says, file=os.fsdecode(file), help=_ADVICE.get(type(problem), ""))


def absent(paths: Iterable[str | Path]) -> list[Diagnostic]:
    """Return one diagnostic (C003) for each path that does not exist."""
    return [
        error("C003", "no such file or folder", file=str(path)) for path in paths if not Path(path).exists()
    ]


def expand_paths(
    paths: Iterable[str | Path], suffixes: Sequence[str], is_meant: Callable[[Path], bool] | None = None
) -> list[Path]:
    """The files meant by `paths`: files as they are, folders searched for `suffixes`, patterns expanded.

    Suffixes are lower case with their dot (".jbi") and match either case. `is_meant`: whether a file with such a suffix
    in a folder is one of them. Every file comes once, folders in
    sorted order. A file that is missing is one of them where there are others: whoever reads them tells of it as of
    any that cannot be read. Raises OlpError naming everything that is unreadable or empty, or missing altogether.
    """
    found: dict[str, Path] = {}
    problems: list[Diagnostic] = []
    missing = 0
    for path in map(Path, paths):
        files = _expand_one(path, tuple(suffixes), is_meant, problems)
        for file in files:
            found.setdefault(os.path.normcase(os.path.abspath(file)), file)
        if not files and not path.is_dir():
            missing += 1
            problems.append(error("C003", "no such file or folder", file=str(path)))
            found.setdefault(os.path.normcase(os.path.abspath(path)), path)
    if len(problems) > missing or (problems and len(found) == missing):
        raise OlpError(*problems)
    return list(found.values())


def _expand_one(
    path: Path,
    suffixes: tuple[str, ...],
    is_meant: Callable[[Path], bool] | None,
    problems: list[Diagnostic],
) -> list[Path]:
    """The files that one path means, none where it is missing."""
    if path.is_dir():
        return _search(path, suffixes, is_meant, problems)
    if path.exists() or path.is_symlink():
        return [path]
    # Shells on Windows hand patterns over as they are.
    return [file for match in _glob(path) for file in _expand_one(match, suffixes, is_meant, problems)]


def _glob(path: Path) -> list[Path]:
    from glob import glob, has_magic

    return [Path(name) for name in sorted(glob(str(path)))] if has_magic(str(path)) else []


def _search(
    root: Path,
    suffixes: tuple[str, ...],
    is_meant: Callable[[Path], bool] | None,
    problems: list[Diagnostic],
) -> list[Path]:
    refused: list[OSError] = []
    found = [
        Path(folder, name)
        for folder, _, names in os.walk(root, onerror=refused.append)
        for name in names
        if name.lower().endswith(suffixes) and (is_meant is None or is_meant(Path(folder, name)))
    ]
    problems.extend(map(from_os_error, refused))
    if not found and not refused:
        help = f"their names end in {' '.join(suffixes)}"
        problems.append(error("C004", "no robot program in this folder", file=str(root), help=help))
    return sorted(found)


# --- Text as bytes ---


def utf8(text: str) -> bytes:
    """Encode `text` as UTF-8; undecodable bytes of file names (surrogates) are written as escapes."""
    return text.encode("utf-8", "backslashreplace")


def shown(text: str) -> bytes:
    """Encode `text` for standard output. On a terminal, control characters other than olp's own styles are made
    visible.
    """
    if sys.stdout.isatty():
        text = visible_styled(text)
    text = text.encode("utf-8", "backslashreplace").decode("utf-8")
    return text.encode(sys.stdout.encoding or "utf-8", "replace")
