"""What a worker answers with: the files of the folder, and the command line."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from olp.core.diagnostic import OlpError, error
from olp.core.files import read_input
from olp.servers.confinement import CommandLine, captured
from olp.servers.folder import Folder
from olp.servers.web.messages import WorkerSetting

if TYPE_CHECKING:
    from olp.ir.program import Program
    from olp.timing.timing import Timing


@dataclass
class Desk:
    """What answers are made with. `timed`: the program that was asked about last, as it stands on the disk."""

    setting: WorkerSetting
    temporary: Path
    command_line: CommandLine
    timed: tuple[tuple[str, str], Program, Timing] | None = None

    def file(self, given: Mapping[str, Any], name: str = "file") -> str:
        """A file of the folder that the request names. Raises OlpError (Z001, Z002, Z006)."""
        path = given.get(name)
        if not isinstance(path, str):
            raise OlpError(error("Z006", f"{name}: must be a text, the path of a file"))
        plain = Folder(self.setting.folder).inside(path)
        if os.path.isdir(plain):
            raise OlpError(error("Z002", "this is a folder, not a file", file=plain))
        return plain

    def ran(self, *words: str) -> bytes:
        """What `olp WORD…` printed. Raises OlpError for bad input."""
        return captured(self.command_line, words).printed

    def page(self, *words: str) -> str:
        """What `olp WORD…` wrote to the file that it gets behind its words. Raises OlpError for bad input."""
        target = self.temporary / "page.html"
        try:
            captured(self.command_line, [*words, str(target)])
            return read_input(target).decode("utf-8")
        finally:
            target.unlink(missing_ok=True)
