"""Commands of olp on the program of a document: convert and report."""

from __future__ import annotations

from olp_freecad import ask
from olp_freecad.program import options


def _words(program: object) -> list:
    """What the command line is told of how this program is timed."""
    return [word for name, value in options(program).items() if value for word in (f"--{name}", value)]


def convert(program: object, language: str, folder: str, robot: str = "") -> str:
    """Translates the program's file into `folder`; what olp says of it. Raises OlpError."""
    robot = robot or program.Robot
    words = ["convert", program.File, "--to", language, "-o", folder]
    return ask.command(*words, *(["--robot", robot] if robot else []))


def report(program: object, output: str) -> str:
    """Writes olp's HTML page of the program's file to `output`. Raises OlpError."""
    return ask.command("report", program.File, "-o", output, *_words(program))
