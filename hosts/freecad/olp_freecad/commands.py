"""Commands of olp on the program of a document: convert and report."""

from __future__ import annotations

from olp_freecad import ask


def options(program: object) -> list:
    """The words of the command line that say how this program is timed."""
    words = []
    for word, value in (
        ("--robot", program.Robot),
        ("--signature", program.Signature),
        ("--model", program.Model),
    ):
        if value:
            words += [word, value]
    return words


def convert(program: object, language: str, folder: str, robot: str = "") -> str:
    """Translates the program's file into `folder`; what olp says of it. Raises OlpError."""
    robot = robot or program.Robot
    words = ["convert", program.File, "--to", language, "-o", folder]
    return ask.command(*words, *(["--robot", robot] if robot else []))


def report(program: object, output: str) -> str:
    """Writes olp's HTML page of the program's file to `output`. Raises OlpError."""
    return ask.command("report", program.File, "-o", output, *options(program))
