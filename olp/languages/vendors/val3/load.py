"""What a Staubli controller, or Stäubli Robotics Suite, rejects when it loads a VAL3 application: names that neither
the program nor the application's data declare, programs that the application does not have, wrong numbers of
arguments, names declared twice.

From memory of the "VAL3 reference manual" (versions 5 to 8): the words, constants and functions of the language, and
how many arguments its functions take, in any of these versions. From projects for the CS8 and the CS9: functions of
the user page take a screen first; a program may have a function's name, for only `call` and `taskCreate` mean it.
A function that is not listed here is told only where it is nearly a known one.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from html import unescape
from typing import Final, NamedTuple

from olp.core.diagnostic import Diagnostic
from olp.core.source import Source
from olp.languages.loading import LoadedCell, LoadFindings, Loading, given_arguments
from olp.languages.vendors.val3.data import XmlTag, tags
from olp.languages.vendors.val3.known_functions import ARGUMENTS, FUNCTIONS

_TEXT_WORDS: Final = """
    and begin break bitAnd bitNot bitOr bitXor call case default do else elseIf end endFor endIf endSwitch endWhile
    every for if mod or return step switch taskCreate taskCreateSync to until while xor
"""
_WORDS: Final = frozenset(_TEXT_WORDS.split())
_TEXT_CONSTANTS: Final = """
    cartesian efree enegative epositive esame false flange free joint lefty off righty same sfree ssame true wfree
    wnegative world wpositive wsame
"""
_CONSTANTS: Final = frozenset(_TEXT_CONSTANTS.split())
_TOKEN: Final = re.compile(
    r'"(?:\\.|[^"\\])*"?|//.*|\$?[A-Za-z_]\w*|\d+(?:\.\d+)?(?:[eE][-+]?\d+)?|&\w+|\S', re.ASCII
)
_FILE: Final = re.compile(r'\bfile\s*=\s*"([^"]*)"', re.IGNORECASE)
_PROJECT: Final = ".pjx"


@dataclass(slots=True)
class Val3Program:
    """`variables`: parameters and locals with their lines; `parameters`: how many of them are parameters."""

    name: str
    line: int
    parameters: int = 0
    variables: list[tuple[str, int]] = field(default_factory=list)
    body: list[tuple[int, str]] = field(default_factory=list)


class Val3File(NamedTuple):
    """`data`: names with their lines. `files`: what a project lists, with lines."""

    programs: list[Val3Program]
    data: list[tuple[str, int]]
    files: list[tuple[str, int]]


def check(source: Source, cell: LoadedCell) -> list[Diagnostic]:
    """What a controller rejects in one file of an application."""
    found, functions = LoadFindings(source), LoadFindings(source)
    files = [_file(one) for one in cell.sources]
    own = files[0]
    present = {re.split(r"[\\/]", one.path)[-1].casefold() for one in cell.sources}
    listed = [name.casefold() for file in files for name, _ in file.files if not re.search(r"[\\/:$]", name)]
    whole = any(name.endswith(_PROJECT) for name in present) and all(name in present for name in listed)
    for name, number in own.files:
        if not re.search(r"[\\/:$]", name) and name.casefold() not in present:
            found.undeclared(
                f"the file {name} is not in the project's folder", found.place_of(number, name), "", True
            )
    found.doubles((name, name, found.place_of(number, name)) for name, number in own.data)
    programs = {one.name: one for file in reversed(files) for one in file.programs}
    data = {name for file in files for name, _ in file.data}
    for program in own.programs:
        found.doubles((name, name, found.place_of(number, name)) for name, number in program.variables)
        for name, number in program.variables:
            if name in _WORDS:
                says = f"{name} is a word of VAL3 and no name"
                found.tell("K104", says, found.place_of(number, name), "call it otherwise")
        known = data | {name for name, _ in program.variables} | _CONSTANTS
        for number, line in program.body:
            _line(found, functions, number, line, known, programs)
    told = found.finish(data | programs.keys() | _CONSTANTS, whole, shared=True)
    told += functions.finish(FUNCTIONS, whole=False, shared=True)
    return sorted(told, key=lambda one: (one.line, one.column))


@lru_cache(maxsize=1024)
def _file(source: Source) -> Val3File:
    programs: list[Val3Program] = []
    data: list[tuple[str, int]] = []
    files: list[tuple[str, int]] = []
    by_line: dict[int, list[XmlTag]] = {}
    for tag in tags(source):
        by_line.setdefault(tag.line, []).append(tag)
    in_code = False
    plain = b"CDATA" in source.raw
    for number, line in enumerate(source.lines, 1):
        for tag in by_line.get(number, ()) if not in_code or "</" in line else ():
            word = tag.name.lower()
            if word == "code":
                in_code = not tag.closes
            elif tag.closes:
                continue
            elif word == "program" and "name" in tag.attributes:
                programs.append(Val3Program(tag.attributes["name"], number))
            elif word in ("parameter", "local") and programs and "name" in tag.attributes:
                programs[-1].variables.append((tag.attributes["name"], number))
                programs[-1].parameters += word == "parameter"
            elif word == "data" and "name" in tag.attributes:
                data.append((tag.attributes["name"], number))
        files += [(name, number) for name in _FILE.findall(line) if source.path.lower().endswith(_PROJECT)]
        if programs and (in_code or "</Code" in line or "</code" in line):
            text = re.sub(r".*<[Cc]ode\b[^>]*>|<!\[CDATA\[|\]\]>.*|</[Cc]ode>.*", "", line)
            programs[-1].body.append((number, text if plain else unescape(text)))
    return Val3File(programs, data, files)


def _line(
    found: LoadFindings,
    functions: LoadFindings,
    number: int,
    line: str,
    known: set[str],
    programs: Mapping[str, Val3Program],
) -> None:
    tokens = [one for one in _TOKEN.findall(line) if not one.startswith("//")]
    called = 1 if tokens[:1] == ["call"] else -1
    if tokens[:1] in (["taskCreate"], ["taskCreateSync"]):
        called = _last_call(tokens)
    for i, name in enumerate(tokens):
        before, after = (tokens[i - 1] if i else ""), (tokens[i + 1] if i + 1 < len(tokens) else "")
        if not re.match(r"[A-Za-z_]", name) or before in (".", ":") or after == ":" or name in _WORDS:
            continue
        span = found.place_of(number, name)
        if after != "(":
            if name in known:
                found.known.add(name)
            else:
                found.unknown.append((name, span, "the variable"))
        elif i == called and name in programs:
            found.known.add(name)
            takes = programs[name].parameters
            found.arguments(name, span, (takes, takes), given_arguments(tokens, i + 1))
        elif i == called:
            found.unknown.append((name, span, "the program"))
        elif name in ARGUMENTS:
            found.arguments(name, span, ARGUMENTS[name], given_arguments(tokens, i + 1))
        elif name not in FUNCTIONS and name not in programs and name not in known:
            functions.unknown.append((name, span, "the function"))


def _last_call(tokens: list[str]) -> int:
    """Where the program of `taskCreate "name",10,program(…)` stands: the first call behind the last comma outside."""
    return next((i for i in range(1, len(tokens) - 1) if tokens[i + 1] == "(" and tokens[i - 1] == ","), -1)


LOAD: Final = Loading(("cs8", "cs9"), check)
