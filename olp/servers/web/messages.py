"""What the server and its workers tell each other: JSON objects, each behind its length, over pipes."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, BinaryIO

from olp.core.files import parse_json
from olp.identification.timing_job import TimingJob

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
        listed = {name: tuple(told[name]) for name in ("words", "also")}
        return cls(**{**told, **listed, "job": TimingJob(**told["job"])})

    @property
    def folder(self) -> Path:
        return Path(self.root)


def packed(message: Any) -> bytes:
    """The bytes of a message."""
    data = json.dumps(message, allow_nan=False).encode("utf-8", "replace")
    return len(data).to_bytes(HEAD, "big") + data


def received(stream: BinaryIO) -> Any:
    """The next message; None at the end."""
    head = stream.read(HEAD)
    if len(head) < HEAD:
        return None
    return parse_json(stream.read(int.from_bytes(head, "big")))
