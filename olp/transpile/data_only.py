"""Files that hold data and nothing that runs: RAPID modules without a routine, KRL's lists.

Codes: X014 a language that has no file for data alone.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import PureWindowsPath
from typing import Final

from olp.core.diagnostic import OlpError, error
from olp.ir.program import Program, Routine
from olp.languages.limits import limits_of
from olp.languages.vendor import language_of

DATA_ALONE: Final = "X014"
_NO_LETTER: Final = re.compile(r"[^A-Za-z0-9_]+")
_HELP: Final = "convert the program that uses it, which lies in the same folder: the data come with it"


def holds_data_only(program: Program) -> bool:
    return not any(map(_runs, program.routines))


def _runs(routine: Routine) -> bool:
    """Whether it is a routine, and no list of data that KRL's reader keeps as one."""
    return "list" not in routine.details or bool(routine.body)


def data_alone(program: Program, target: str, flat: bool = False) -> Program:
    """The data of a file that holds nothing else, under the name of that file; other programs as they are.

    Raises OlpError (X014) for a language whose data stand in programs only, and for what a run shows (`flat`).
    """
    if not holds_data_only(program):
        return program
    if flat or not limits_of(target).has_data_files:
        message = (
            f"this file holds data and nothing that runs: {language_of(target)} has no file for data alone"
        )
        if flat:
            message = "this file holds data and nothing that runs"
        raise OlpError(error(DATA_ALONE, message, file=program.path, help=_HELP))
    return program if program.vendor == target else replace(program, routines=(), main=name_of(program))


def name_of(program: Program) -> str:
    """What a file of data is called: as the source's list, else as its file."""
    stem = PureWindowsPath(program.path.replace("/", "\\")).stem if program.path else ""
    return program.main or _NO_LETTER.sub("_", stem).strip("_") or "DATA"
