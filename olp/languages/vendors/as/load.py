"""What a Kawasaki controller rejects when it loads a file of programs, or finds missing when one of them starts.

From memory of the "AS Language Reference Manual" (C to F series): names have up to 15 characters, labels and programs
are unique, and how many arguments functions take. That a program is missing
which another one calls is no obstacle, as a saved controller shows: it is told where the name is nearly a known one.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Final

from olp.core.diagnostic import Diagnostic
from olp.core.source import Source
from olp.languages.loading import LoadedCell, LoadFindings, Loading, given_arguments, is_near

_LONGEST: Final = 15  # characters of a name, without the sign of its type
_TEXT_ONE_ARGUMENT: Final = "$chr abs acos asin cos dx dy dz int len sin sqrt"
_TEXT_TWO_ARGUMENTS: Final = "$left $right atan2 distance"
# At least and at most; the last argument of some may be left out.
_ARGUMENTS: Final = {
    name: (count, count)
    for count, text in enumerate((_TEXT_ONE_ARGUMENT, _TEXT_TWO_ARGUMENTS), 1)
    for name in text.split()
} | dict.fromkeys(("$decode", "$mid"), (2, 3))
_TEXT_WORDS: Final = """
    abort above accel accuracy align always any aport base below bits bits32 brake break c1move c2move call case
    clampon close closei cp cproc decel decompose defsig delay do dout draw drive else elseif end
    extcall for force goto halt here hmove home hold if ignore ifpwprint ifpend int_en japlane jappro jdepart jmove
    joint lappro ldepart lefty linear lmove lock mc ml_on ml_off mod mvwait next not off on one open openi or
    pause pcabort pcend pcexecute point print prompt pulse relax relaxi repeat reset return returne righty runmask scall
    scase signal sigdel slow speed stable step stop svalue swait tdraw then timer to tool tool_on twait type until
    uwrist dwrist value wait weight weld while wend xmove xor
"""
_WORDS: Final = frozenset(_TEXT_WORDS.split())
_HEAD: Final = re.compile(r"\s*\.PROGRAM\s+([A-Z_][\w.]*)\s*(?:\((.*?)\))?\s*(?:#|;|$)", re.IGNORECASE)
_TABLE: Final = re.compile(r"\s*\.(TRANS|JOINTS|REALS|STRINGS|INTEGER)\b", re.IGNORECASE)
_END: Final = re.compile(r"\s*\.END\b", re.IGNORECASE)
_LABEL: Final = re.compile(r"\s*(?:(\d+)(?=\s|:|$)|([A-Z_][\w.]*)\s*:(?!=))", re.IGNORECASE)
_CALL: Final = re.compile(r"\bCALL\s+([A-Z_][\w.]*)\s*(\()?", re.IGNORECASE)
_FUNCTION: Final = re.compile(r"(?<![\w.#])(\$?[A-Z]\w*)\s*\(", re.IGNORECASE)
_ASSIGNED: Final = re.compile(
    r"\s*(?:POINT\s+|HERE\s+)?([#$]?\.?[A-Z_][\w.]*)\s*(?:\[[^\]]*\])?\s*=(?!=)", re.IGNORECASE
)
_WORD: Final = re.compile(r"\s*([A-Z]\w+)(?=\s|$)", re.IGNORECASE)
_TEXT: Final = re.compile(r'"[^"]*"?')


@dataclass(slots=True)
class AsProgram:
    """`parameters`: how many. `body`: instructions without comments and texts, with their lines."""

    name: str
    line: int
    parameters: int = 0
    body: list[tuple[int, str]] = field(default_factory=list)


def check(source: Source, cell: LoadedCell) -> list[Diagnostic]:
    """What a controller rejects in one file of programs."""
    found = LoadFindings(source)
    programs = {one.name.casefold(): one for file in cell.sources[1:] for one in programs_of(file)}
    own: dict[str, AsProgram] = {}
    for program in programs_of(source):
        own.setdefault(program.name.casefold(), program)
        found.too_long("name", program.name, found.place_of(program.line, program.name), _LONGEST)
    found.doubles(
        (one.name.casefold(), f"the program {one.name}", found.place_of(one.line, one.name))
        for one in programs_of(source)
    )
    programs |= own
    for program in own.values():
        _labels(found, program)
        for number, code in program.body:
            _instruction(found, number, code, programs)
    return sorted(found.diagnostics, key=lambda one: (one.line, one.column))


@lru_cache(maxsize=64)
def programs_of(source: Source) -> list[AsProgram]:
    found: list[AsProgram] = []
    is_open = False
    for number, line in enumerate(source.lines, 1):
        head = _HEAD.match(line)
        if head is not None:
            parameters = [one for one in (head[2] or "").split(",") if one.strip(" []")]
            found.append(AsProgram(head[1], number, len(parameters)))
            is_open = True
        elif _END.match(line) or _TABLE.match(line):
            is_open = False
        elif is_open:
            code = _TEXT.sub(lambda match: " " * len(match[0]), line).partition(";")[0]
            if code.strip():
                found[-1].body.append((number, code))
    return found


def _labels(found: LoadFindings, program: AsProgram) -> None:
    found.doubles(
        (name.casefold(), f"the label {name}", found.place_of(number, name))
        for number, code in program.body
        if (label := _LABEL.match(code)) and (name := label[1] or label[2]).casefold() != "any"
    )


def _instruction(found: LoadFindings, number: int, code: str, programs: dict[str, AsProgram]) -> None:
    assigned = _ASSIGNED.match(code)
    if assigned is not None:
        found.too_long("name", assigned[1], found.place_of(number, assigned[1]), _LONGEST)
    for call in _CALL.finditer(code):
        name, span = call[1], found.place_of(number, call[1])
        program = programs.get(name.casefold())
        if program is not None:
            given = given_arguments(code, call.end() - 1) if call[2] else 0
            found.arguments(name, span, (0, program.parameters), given)
        elif meant := next((one.name for one in programs.values() if _is_meant(name, one.name)), ""):
            found.undeclared(
                f"the program {name[:40]} is declared nowhere", span, f"did you mean {meant}?", False
            )
    for match in _FUNCTION.finditer(code):
        takes = _ARGUMENTS.get(match[1].casefold())
        if takes is not None:
            span, given = found.place_of(number, match[1]), given_arguments(code, match.end() - 1)
            found.arguments(match[1], span, takes, given)
    _word(found, number, code)


def _is_meant(name: str, other: str) -> bool:
    """Whether both have as many parts between points, of which one is mistyped: pick.upper.l is not pick.upper.r."""
    pairs = list(zip(name.casefold().split("."), other.casefold().split("."), strict=False))
    differ = [pair for pair in pairs if pair[0] != pair[1]]
    return name.count(".") == other.count(".") and len(differ) == 1 and is_near(*differ[0])


def _word(found: LoadFindings, number: int, code: str) -> None:
    """An instruction that is not known is told where it is nearly one that is."""
    word = _WORD.match(code)
    if word is None or word[1].casefold() in _WORDS or re.match(r"\s*[=:(\[]", code[word.end() :]):
        return
    near = next((one for one in sorted(_WORDS) if is_near(one, word[1].casefold())), "")
    if near:
        says = f"the instruction {word[1][:40]} is not known"
        found.undeclared(says, found.place_of(number, word[1]), f"did you mean {near.upper()}?", whole=False)


LOAD: Final = Loading(("kawasaki-f", "kawasaki-e", "kawasaki-d"), check)
