"""recording.toml: what the tables of a recording cannot say themselves. Everything in it is optional.

Codes: D030 a value that means nothing, D031 a key that means nothing, D032 a file that is not there.
"""

from __future__ import annotations

import difflib
import re
from dataclasses import dataclass
from os.path import isfile
from pathlib import Path
from typing import Any

from olp.core.diagnostic import Diagnostic, Severity, Span, error
from olp.core.toml import TOMLDecodeError, is_number, is_told_enough, parse_toml, toml_text
from olp.core.units import deg, mm

FILE_NAME = "recording.toml"
KEYS = ("robot", "controller", "time_resolution_s", "tool", "job")


@dataclass(frozen=True, slots=True)
class RecordingSettings:
    """The file's content in SI, empty or None where it says nothing."""

    robot: str = ""  # name in the library, or path of a robot file
    controller: str = ""
    time_resolution: float | None = None  # [s] of the measured durations
    tool: tuple[float, ...] | None = None  # x, y, z [m], Rx, Ry, Rz [rad] on the flange
    job: str = ""  # path of the program that ran, as written
    file: str = ""


def read_settings(path: Path) -> tuple[RecordingSettings, list[Diagnostic]]:
    """The settings in `path` and all that is wrong with them. Never raises for what is in the file."""
    file = str(path)
    try:
        text = toml_text(path)
        values = parse_toml(text)
    except OSError as problem:
        return RecordingSettings(file=file), [error("D002", problem.strerror or "cannot be read", file=file)]
    except UnicodeDecodeError:
        return RecordingSettings(file=file), [error("D002", "not UTF-8 text", file=file)]
    except TOMLDecodeError as problem:
        return RecordingSettings(file=file), [_syntax(file, text, str(problem))]
    return _SettingsReader(file, text, values).settings()


class _SettingsReader:
    def __init__(self, file: str, text: str, values: dict[str, Any]) -> None:
        self.file, self.lines, self.values = file, text.splitlines(), values
        self.found: list[Diagnostic] = []

    def settings(self) -> tuple[RecordingSettings, list[Diagnostic]]:
        for key in self.values:
            if key not in KEYS and not is_told_enough(self.found, "D031", self.file):
                near = difflib.get_close_matches(key, KEYS, n=1, cutoff=0.6)
                help = f"did you mean {near[0]}?" if near else f"known: {', '.join(KEYS)}"
                self._tell("D031", key, f"olp does not know the key {key}", help, Severity.WARNING)
        job = self._word("job")
        if job and not isfile(Path(self.file).parent / job):  # a name too long for a file is none
            self._tell("D032", "job", f"there is no file {job}", "", Severity.WARNING)
        found = RecordingSettings(
            self._word("robot"), self._word("controller"), self._resolution(), self._tool(), job, self.file
        )
        return found, self.found

    def _word(self, key: str) -> str:
        value = self.values.get(key, "")
        if isinstance(value, str):
            return value
        self._tell("D030", key, f"{key} must be text in quotes, not {value!r}")
        return ""

    def _resolution(self) -> float | None:
        value = self.values.get("time_resolution_s")
        if value is None:
            return None
        if is_number(value) and 0 < value < 3600:
            return float(value)
        self._tell(
            "D030", "time_resolution_s", f"time_resolution_s cannot be {value!r}", "seconds, above zero"
        )
        return None

    def _tool(self) -> tuple[float, ...] | None:
        value = self.values.get("tool")
        if value is None:
            return None
        if isinstance(value, list) and len(value) == 6 and all(map(is_number, value)):
            return tuple(float(v) * (mm if i < 3 else deg) for i, v in enumerate(value))
        self._tell("D030", "tool", f"tool cannot be {value!r}", "six numbers: x y z [mm], rx ry rz [deg]")
        return None

    def _tell(
        self, code: str, key: str, message: str, help: str = "", severity: Severity = Severity.ERROR
    ) -> None:
        for number, line in enumerate(self.lines, 1):
            match = re.match(rf"""\s*\[*\s*["']?{re.escape(key)}\b""", line)
            if match:
                column = len(line) - len(line.lstrip()) + 1
                place = number, column, match.end() + 1
                self.found.append(Diagnostic(code, message, severity, self.file, *place, help, line))
                return
        self.found.append(Diagnostic(code, message, severity, self.file, help=help))


def _syntax(file: str, text: str, message: str) -> Diagnostic:
    place = re.search(r"\s*\(at line (\d+), column (\d+)\)", message)
    if place is None:
        return error("D002", f"not TOML: {message}", file=file)
    line, column = int(place[1]), int(place[2])
    rows = text.split("\n")
    source = rows[line - 1].rstrip("\r") if line <= len(rows) else ""
    return error(
        "D002",
        f"not TOML: {message[: place.start()]}",
        Span(line, column, column + 1),
        file=file,
        source_line=source,
    )
