"""Writing files: whole or not at all, and never over an input unless asked. C006: an input would be overwritten."""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Iterable
from pathlib import Path

from olp.diagnostic import OlpError, error


def write_output(
    path: str | Path | None, data: bytes, *, inputs: Iterable[str | Path] = (), in_place: bool = False
) -> None:
    """Writes `data` to `path`, whole or not at all; None or "-" is standard output.

    The data are written beside the target and moved into place, so a full disk or a lost connection never
    leaves half a program. A target that is one of `inputs` is refused with OlpError unless `in_place`.
    Raises OSError.
    """
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
        target.write_bytes(data)  # a device or a pipe cannot be replaced, a folder says so
    else:
        _replace(target, data)


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


def _replace(target: Path, data: bytes) -> None:
    beside = target.with_name(f".{target.name}.{os.getpid()}.part")
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
