"""What Comau's translator rejects when it makes a program of a PDL2 text, or the controller when it loads it.

From memory of the "PDL2 Programming Language Manual": names have up to 32 characters and are unique, reserved words
name nothing, declarations stand before BEGIN, what is assigned is declared, a constant is not assigned, and a routine
is called with as many arguments as it has parameters.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Final

from olp.core.diagnostic import Diagnostic
from olp.core.source import Source
from olp.languages.loading import LoadedCell, LoadFindings, Loading, given_arguments

_LONGEST: Final = 32  # characters of a name
_TEXT_WORDS: Final = """
    and array begin boolean by call case const cycle delay div do else elsif end endfor endif endmove endselect endwhile
    exit exported for from goto if import integer jointpos mod move movefly not of or position program pulse real repeat
    return routine select string then to type until var wait while with xor xtndpos
"""
_WORDS: Final = frozenset(_TEXT_WORDS.split())
_PROGRAM: Final = re.compile(r"\s*PROGRAM\s+([A-Z_]\w*)", re.IGNORECASE)
_ROUTINE: Final = re.compile(r"\s*ROUTINE\s+([A-Z_]\w*)\s*(?:\((.*?)\))?\s*(.*)$", re.IGNORECASE)
_SECTION: Final = re.compile(r"\s*(VAR|CONST|TYPE|BEGIN|CYCLE|IMPORT)\b(.*)$", re.IGNORECASE)
_ENDED: Final = re.compile(r"\s*END(?:\s+[A-Z_]\w*)?\s*$", re.IGNORECASE)
_VARIABLES: Final = re.compile(r"\s*([A-Z_]\w*(?:\s*,\s*[A-Z_]\w*)*)\s*:(?![=:])", re.IGNORECASE)
_CONSTANT: Final = re.compile(r"\s*([A-Z_]\w*)\s*=", re.IGNORECASE)
_ASSIGNED: Final = re.compile(
    r"\s*(?:(?:FOR|IF\b.*\bTHEN|ELSE|CASE\s*\([^)]*\)\s*:)\s+)?([A-Z_]\w*)\s*(?:\[[^\]]*\]|\.\w+)*\s*:=",
    re.IGNORECASE,
)
_LABEL: Final = re.compile(r"\s*([A-Z_]\w*)\s*::", re.IGNORECASE)
_CALLED: Final = re.compile(r"(?<![\w$.])([A-Z_]\w*)\s*\(", re.IGNORECASE)
_FROM: Final = re.compile(r"\b(?:FROM|EXTERNAL)\b", re.IGNORECASE)
_PARAMETERS: Final = re.compile(r"\bVAR\b", re.IGNORECASE)


@dataclass(slots=True)
class Pdl2Part:
    """The program (the last part of a file) or a routine. `names`: what it declares, with lines; `least`, `most`:
    arguments; `late`: declarations behind its BEGIN; `announced`: whether its body stands further down."""

    name: str
    line: int
    least: int = 0
    most: int = 0
    names: list[tuple[str, int]] = field(default_factory=list)
    constants: set[str] = field(default_factory=set)
    body: list[tuple[int, str]] = field(default_factory=list)
    late: list[int] = field(default_factory=list)
    announced: bool = False


@dataclass(slots=True)
class Pdl2Text:
    """`program`: what is not in a routine. `imports`: whether names come from another program."""

    program: Pdl2Part
    routines: list[Pdl2Part] = field(default_factory=list)
    imports: bool = False


def check(source: Source, cell: LoadedCell) -> list[Diagnostic]:
    """What the translator rejects in one program."""
    found = LoadFindings(source)
    text = text_of(source)
    program = text.program
    shared = [*program.names, *((one.name, one.line) for one in text.routines if not one.announced)]
    routines = {one.name.casefold(): one for one in text.routines if not one.announced}
    for part in (program, *text.routines):
        names = sorted(shared if part is program else part.names, key=lambda one: one[1])
        found.doubles((name.casefold(), name, found.place_of(number, name)) for name, number in names)
        for name, number in [*part.names, (part.name, part.line)]:
            _name(found, name, number)
        for number in part.late:
            help = "declare it above BEGIN"
            found.tell("K106", "a declaration behind BEGIN", found.whole_line(number), help)
        local = {name.casefold() for name, _ in (*shared, *part.names)}
        constants = part.constants | (program.constants - {name.casefold() for name, _ in part.names})
        _labels(found, part)
        for number, code in part.body:
            _instruction(found, number, code, local, constants, routines)
    if text.imports:
        found.unknown.clear()
    return found.finish((name for name, _ in shared), whole=True, shared=True)


@lru_cache(maxsize=64)
def text_of(source: Source) -> Pdl2Text:
    """The parts of a program, as far as they can be told."""
    text = Pdl2Text(Pdl2Part("", 1))
    part, section, in_type = text.program, "", False
    lines = [(number, _code(line)) for number, line in _joined(source)]
    written = {
        head[1].casefold()
        for _, code in lines
        if (head := _ROUTINE.match(code)) and not _FROM.search(head[3])
    }
    for number, code in lines:
        if not code.strip():
            continue
        word = code.split(None, 1)[0].upper()
        if word == "PROGRAM" and (head := _PROGRAM.match(code)) and not text.program.name:
            text.program.name, text.program.line, section = head[1], number, "VAR"
        elif word == "ROUTINE" and (routine := _ROUTINE.match(code)):
            part = _routine(text, routine, number, routine[1].casefold() in written)
            section = "VAR"
        elif opened := _SECTION.match(code):
            late = section == "BEGIN" and word in ("VAR", "CONST", "TYPE")
            if late:
                part.late.append(number)
            section = "VAR" if word == "IMPORT" else "BEGIN" if word == "CYCLE" else word
            text.imports |= word == "IMPORT"
            _declared(part, section, opened[2], number)
        elif _ENDED.match(code) and section == "BEGIN":
            part, section = text.program, "VAR"
        elif section == "TYPE":
            in_type = word != "ENDTYPE"
            section = section if in_type else "VAR"
        elif section == "BEGIN":
            part.body.append((number, code))
        else:
            _declared(part, section, code, number)
    return text


def _joined(source: Source) -> list[tuple[int, str]]:
    """Lines, with those that go on behind & as one."""
    found: list[tuple[int, str]] = []
    goes_on = False
    for number, line in enumerate(source.lines, 1):
        bare = _code(line).rstrip()
        if goes_on:
            found[-1] = (found[-1][0], f"{found[-1][1].rstrip()[:-1]} {line}")
        else:
            found.append((number, line))
        goes_on = bare.endswith("&")
    return found


def _code(line: str) -> str:
    """A line without texts and its comment; columns stay."""
    bare = re.sub(r"'[^']*'?", lambda match: "'" + " " * max(len(match[0]) - 2, 0) + "'", line)
    return bare.partition("--")[0].rstrip(" \t;\x1a")


def _routine(text: Pdl2Text, head: re.Match[str], number: int, written: bool) -> Pdl2Part:
    """Adds a routine; gives what the next lines belong to. `written`: whether a head without FROM names it, too, as
    where a program exports its own routine."""
    part = Pdl2Part(head[1], number)
    for group in (head[2] or "").split(";"):
        names, _, kind = group.partition(":")
        given = [one.strip() for one in _PARAMETERS.sub("", names).split(",") if one.strip()]
        part.names += [(name, number) for name in given]
        part.most += len(given)
        part.least += 0 if "(" in kind or "=" in kind else len(given)
    text.routines.append(part)
    elsewhere = _FROM.search(head[3]) is not None
    part.announced = elsewhere and written
    return text.program if elsewhere else part


def _declared(part: Pdl2Part, section: str, code: str, number: int) -> None:
    variables = _VARIABLES.match(code)
    constant = _CONSTANT.match(code)
    if section == "VAR" and variables:
        part.names += [(name.strip(), number) for name in variables[1].split(",")]
    elif section == "CONST" and constant:
        part.names.append((constant[1], number))
        part.constants.add(constant[1].casefold())


def _name(found: LoadFindings, name: str, number: int) -> None:
    span = found.place_of(number, name)
    found.too_long("name", name, span, _LONGEST)
    if name.casefold() in _WORDS:
        found.tell("K104", f"{name} is a word of PDL2 and no name", span, "call it otherwise")


def _labels(found: LoadFindings, part: Pdl2Part) -> None:
    labels = ((match[1], number) for number, code in part.body if (match := _LABEL.match(code)))
    found.doubles(
        (name.casefold(), f"the label {name}", found.place_of(number, name)) for name, number in labels
    )


def _instruction(
    found: LoadFindings,
    number: int,
    code: str,
    local: set[str],
    constants: set[str],
    routines: dict[str, Pdl2Part],
) -> None:
    assigned = _ASSIGNED.match(code)
    if assigned is not None:
        name, key = assigned[1], assigned[1].casefold()
        if key in constants:
            found.tell("K111", f"{name} is a constant", found.place_of(number, name), "declare it in VAR")
        elif key not in local:
            found.unknown.append((name, found.place_of(number, name), "the variable"))
    for match in _CALLED.finditer(code):
        routine = routines.get(match[1].casefold())
        if routine is not None:
            span, given = found.place_of(number, match[1]), given_arguments(code, match.end() - 1)
            found.arguments(routine.name, span, (routine.least, routine.most), given)


LOAD: Final = Loading(("c5g", "c4g"), check)
