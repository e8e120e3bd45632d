"""What olp says: it runs in a process of its own, and every problem it names comes back as it says it."""

from __future__ import annotations

import csv
import json
import os
import subprocess
from io import StringIO
from pathlib import Path
from typing import NamedTuple

WHERE = "Edit → Preferences → Add-ons → Robot Programs with their Times"


class OlpError(Exception):
    """olp could not answer; the text is for the user."""


class Olp(NamedTuple):
    command: str  # a name on the path, or a file
    timeout_s: float

    def time(self, program: Path, options: list[str]) -> dict:
        """The object of `olp time --format json`; raises OlpError with all errors."""
        done = self._run(["time", str(program), "--format", "json", *options], program.parent)
        try:
            (answer,) = json.loads(done.stdout)
        except ValueError:
            raise OlpError(done.stderr.strip() or f"olp ended with status {done.returncode}") from None
        if done.returncode:
            errors = [told(d) for d in answer["diagnostics"] if d["severity"] == "error"]
            raise OlpError("\n".join(errors) or done.stderr.strip())
        return answer

    def track(self, program: Path, dt_s: float, options: list[str]) -> list[dict[str, str]]:
        """The rows of `olp track`; raises OlpError, also where no tool moves."""
        done = self._run(["track", str(program), "--dt", f"{dt_s:.12f}", *options], program.parent)
        if done.returncode:
            raise OlpError(done.stderr.strip())
        rows = list(csv.DictReader(StringIO(done.stdout)))
        if not all(row["x_mm"] and row["rx_deg"] for row in rows):
            raise OlpError(f"{program.name}: olp track says no place of a tool: nothing to show")
        return rows

    def robots(self) -> list[str]:
        """The names that --robot takes; raises OlpError."""
        done = self._run(["robots", "--format", "json"], Path.home())
        if done.returncode:
            raise OlpError(done.stderr.strip())
        return [robot["robot"] for robot in json.loads(done.stdout)]

    def _run(self, words: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
        try:
            return subprocess.run(
                [os.path.expanduser(self.command), *words],
                cwd=folder if folder.is_dir() else None,
                env={**os.environ, "NO_COLOR": "1", "PYTHONUTF8": "1"},
                stdin=subprocess.DEVNULL,
                capture_output=True,
                encoding="utf-8",
                errors="replace",
                timeout=self.timeout_s,
                creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),  # Windows would show a console
            )
        except subprocess.TimeoutExpired:
            raise OlpError(f"olp did not answer within {self.timeout_s:g} s; {WHERE} has the limit") from None
        except OSError as problem:
            raise OlpError(
                f"cannot start olp as {self.command!r}: {problem.strerror}; say where it is in {WHERE}"
            ) from None


def told(diagnostic: dict) -> str:
    """One diagnostic as a line."""
    line = f":{diagnostic['line']}" if diagnostic["line"] else ""
    text = f"{diagnostic['code']}: {diagnostic['message']} ({Path(diagnostic['file']).name}{line})"
    return f"{text}; {diagnostic['help']}" if diagnostic["help"] else text
