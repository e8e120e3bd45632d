"""The one way in which olp asks git: objects are read as they are stored, and nothing that a repository says is run.

A repository's own configuration may name programs: filters, text conversions, hooks, file-system monitors, pagers and
transports. Only commands that run none of them are used (`rev-parse`, `ls-tree`, `cat-file --batch`, `merge-file`, and
`config` to install olp), and the transports by which git would fetch a missing object are closed. The settings of the
user and of the system hold.

Codes: U002 git refused, or cannot be run.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path, PurePosixPath

from olp.core.diagnostic import OlpError, error

_PATIENCE = 120  # [s]
_CLOSED = (
    "-c",
    f"core.hooksPath={os.devnull}",
    "-c",
    "core.fsmonitor=false",
    "-c",
    f"core.attributesFile={os.devnull}",
    "-c",
    "core.pager=",
    "--no-pager",
    "--no-optional-locks",
    "--literal-pathspecs",
)
# An empty list of protocols has to name one that does not exist; it beats whatever the repository allows.
_ENVIRONMENT = {"GIT_ALLOW_PROTOCOL": "none", "GIT_NO_LAZY_FETCH": "1", "GIT_TERMINAL_PROMPT": "0"}
_FILE, _LINK = ("100644", "100755", "100664"), "120000"


def git(*arguments: str, cwd: str | Path | None = None, given: bytes = b"") -> bytes | None:
    """Run one of the commands above and return its output; None where git fails. Raises OlpError (U002) without git."""
    asked = _run(arguments, cwd, given)
    return asked.stdout if asked.returncode == 0 else None


def asked_of_git(*arguments: str, cwd: str | Path | None = None, given: bytes = b"") -> bytes:
    """Run one of the commands above and return its output. Raises OlpError (U002) where git fails."""
    asked = _run(arguments, cwd, given)
    if asked.returncode:
        raise OlpError(error("U002", f"git: {asked.stderr.decode(errors='replace').strip()[:200]}"))
    return asked.stdout


def merged_text(ours: str, base: str, theirs: str, size: int) -> tuple[bytes, bool]:
    """Merge three text files with `git merge-file`: (merged text, whether it has no conflict). Raises OlpError
    (U002).

    `ours`, `base`, `theirs`: paths. `size`: the number of characters of a conflict marker.
    """
    labels = ("-L", "ours", "-L", "base", "-L", "theirs")
    asked = _run(("merge-file", "-p", "-q", f"--marker-size={size}", *labels, ours, base, theirs), None, b"")
    if not 0 <= asked.returncode < 128:
        raise OlpError(
            error("U002", f"git: {asked.stderr.decode(errors='replace').strip()[:200]}", file=ours)
        )
    return asked.stdout, asked.returncode == 0


def files_of(revision: str, cwd: str | Path | None = None) -> dict[PurePosixPath, tuple[str, str]]:
    """Return the (mode, object) of each file and link of a revision, by path. Raises OlpError (U002)."""
    listed = asked_of_git("ls-tree", "-r", "-z", "--full-tree", revision, cwd=cwd)
    found = {}
    for row in os.fsdecode(listed).split("\0"):
        kind, _, name = row.partition("\t")
        mode, _, rest = kind.partition(" ")
        if mode in _FILE or mode == _LINK:
            found[PurePosixPath(name)] = (mode, rest.partition(" ")[2])
    return found


def lay_out(
    files: dict[PurePosixPath, tuple[str, str]],
    wanted: Sequence[PurePosixPath],
    folder: Path,
    cwd: str | Path | None = None,
) -> None:
    """Write below `folder` the files that `wanted` names, or that are in a folder that it names; all files where it
    is empty.

    A link is replaced by the file of the same revision that it points to, and is left out where it points
    elsewhere. Raises OlpError (U002).
    """
    names = [name for name in files if not wanted or any(name.is_relative_to(path) for path in wanted)]
    for name, data in _contents(files, names, cwd):
        if name.is_absolute() or ".." in name.parts or ".git" in (part.casefold() for part in name.parts):
            continue  # git refuses to make such trees; a repository from elsewhere may hold one
        target = folder.joinpath(*name.parts)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(data)


def _contents(
    files: dict[PurePosixPath, tuple[str, str]], names: Sequence[PurePosixPath], cwd: str | Path | None
) -> Iterator[tuple[PurePosixPath, bytes]]:
    links = [name for name in names if files[name][0] == _LINK]
    held = dict(zip(links, _blobs([files[name][1] for name in links], cwd), strict=True))
    led = {name: _led_to(name, os.fsdecode(target), files) for name, target in held.items()}
    kept = [name for name in names if led.get(name, name) is not None]
    objects = [files[led.get(name) or name][1] for name in kept]
    yield from zip(kept, _blobs(objects, cwd), strict=True)


def _led_to(
    name: PurePosixPath, target: str, files: dict[PurePosixPath, tuple[str, str]]
) -> PurePosixPath | None:
    """Return the plain file of the revision that a link points to; None where there is none."""
    path = PurePosixPath(os.path.normpath(name.parent / target).replace("\\", "/"))
    return path if path in files and files[path][0] != _LINK else None


def _blobs(objects: Sequence[str], cwd: str | Path | None) -> Iterator[bytes]:
    """Yield the stored bytes of each object. `cat-file --batch` runs no filter and no text conversion."""
    if not objects:
        return
    answer = asked_of_git("cat-file", "--batch", cwd=cwd, given="\n".join(objects).encode() + b"\n")
    at = 0
    for asked in objects:
        head, _, _ = answer[at : at + 200].partition(b"\n")
        words = head.split()
        if len(words) != 3:
            raise OlpError(error("U002", f"git: the object {asked} is missing"))
        at += len(head) + 1
        size = int(words[2])
        yield answer[at : at + size]
        at += size + 1


def _run(
    arguments: Sequence[str], cwd: str | Path | None, given: bytes
) -> subprocess.CompletedProcess[bytes]:
    command = ["git", *_CLOSED, *arguments]
    try:
        return subprocess.run(
            command,
            cwd=cwd,
            input=given,
            capture_output=True,
            timeout=_PATIENCE,
            check=False,
            env=os.environ | _ENVIRONMENT,
        )
    except (OSError, subprocess.SubprocessError) as problem:
        raise OlpError(
            error("U002", f"git cannot be run: {problem}", help="install git, or name two folders")
        ) from None
