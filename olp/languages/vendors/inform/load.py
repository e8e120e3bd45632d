"""What a Yaskawa controller rejects when it loads a job, or finds missing when the job starts.

From the survey of published jobs and manuals that the readers are made from: the length of names, 8 characters before
the DX100; the eight arguments of a job; ///LVARS, which counts the local variables; `'`, which begins a comment only on
a line of its own below NOP; tools and user frames up to 63; that jobs without ///GROUP1 do not move.
From memory of the INFORM manuals: labels are unique, the ranges of B, I and D, VJ up to 100 %, and `_WRONG`: none of 95
public jobs breaks one of its rules; the speeds of a second group's move were repaired in a real history.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from olp.core.diagnostic import Diagnostic, Span
from olp.core.source import Source
from olp.languages.loading import LoadedCell, LoadFindings, Loading, WrongForm, is_near
from olp.languages.vendors.inform.limits import MOST_ARGUMENTS

_OLDER: Final = ("nx100",)
_LONGEST_JOB: Final = {True: 8, False: 32}  # characters, by whether the controller is an older one
_LONGEST_LABEL: Final = 8  # characters, on older controllers
_LARGEST_FRAME: Final = 63
_LARGEST_SHARE: Final = 100.0  # VJ in percent
_RANGES: Final[Mapping[str, tuple[int, int]]] = {
    "B": (0, 255),
    "I": (-32768, 32767),
    "D": (-2147483648, 2147483647),
}
_LOCALS: Final = ("LB", "LI", "LD", "LR", "LS", "LP", "LBP", "LEX")  # in the order of ///LVARS
_BACKUP: Final = frozenset(("system.sys", "all.prm"))  # stand beside all jobs of a controller

_ROW: Final = re.compile(r"\s*((?:BC|EC|C|BP|EX|P)\d+)\s*=")
_LABEL: Final = re.compile(r"\s*(\*[^\s'/]+)")
_WORD: Final = re.compile(r"\s*([A-Z][A-Z0-9]+)(?=\s|$)")
_TEXT: Final = re.compile(r'"[^"]*"?')
_CALLED: Final = re.compile(r"\b(?:CALL|PSTART|JUMP)\b[^'\"]*?\bJOB:([^\s\"']+)")
_ARGUMENT: Final = re.compile(r"\bARGF")
_TAKEN: Final = re.compile(r"\bIARG#\((\d+)\)")
_LOCAL: Final = re.compile(r"\b(L(?:BP|EX|[BIDRSP]))(\d+)\b")
_SET: Final = re.compile(r"\s*SET\s+L?([BID])\d+\s+(-?\d+)\s*$")
_SHARE: Final = re.compile(r"\bVJ=(\d+(?:\.\d*)?)(?![\w.])")
_WRONG: Final = (
    WrongForm(
        re.compile(r"(?:^|\+)\s*S?MOVJ\b[^+]*?\sV[RE]?=\S*"),
        "K108",
        "a joint move with the speed of a line",
        "VJ= in percent",
    ),
    WrongForm(
        re.compile(r"(?:^|\+)\s*S?MOV[LCS]\b[^+]*?\sVJ=\S*"),
        "K108",
        "a line with the speed of a joint move",
        "V= in mm/s",
    ),
    WrongForm(
        re.compile(r"\b(?:ACC|DEC)=(?!0*100(?:\.0*)?(?![\w.]))\d{3,}(?:\.\d*)?"),
        "K109",
        "ACC or DEC is out of range",
        "100 at most",
    ),
    WrongForm(
        re.compile(r"\bTIMER\s+T=(?:\d{4,}|6[6-9]\d|65[6-9]|[7-9]\d\d)(?:\.\d*)?"),
        "K109",
        "a wait of more than 655.35 s",
        "use several TIMER instructions",
    ),
    WrongForm(re.compile(r"\bDOUT\s+(?:IN|SIN|IG|IGH)#"), "K108", "an input is set", "DOUT OT#(1) ON"),
    WrongForm(re.compile(r"\bDOUT\s+OT#\([^)]*\)\s+\d+"), "K108", "an output is a number here", "ON or OFF"),
    WrongForm(
        re.compile(r"\b(?:INC|DEC)\s+L?(?:P|BP|EX|S|R)\d"), "K108", "INC and DEC count only B, I and D", "ADD"
    ),
)
_MOVES: Final = re.compile(r"\s*S?MOV[JLCS]\s+(?:C|BC|EC|P)\d")


@dataclass(slots=True)
class JobText:
    """One job of a file: its records, rows and instructions with their line numbers."""

    name: str = ""
    line: int = 0
    records: list[tuple[int, str, str]] = field(default_factory=list)  # line, word, value
    rows: list[tuple[int, str]] = field(default_factory=list)
    body: list[tuple[int, str]] = field(default_factory=list)

    def values(self, word: str) -> list[tuple[int, str]]:
        return [(number, value) for number, one, value in self.records if one == word]


def check(source: Source, cell: LoadedCell) -> list[Diagnostic]:
    """What a controller rejects in one file of jobs."""
    found = LoadFindings(source)
    jobs = _jobs(source)
    older = cell.controller in _OLDER
    names = {job.name for one in cell.sources[1:] if _is_job(one) for job in _jobs(one)}
    names.update(job.name for job in jobs)
    for job in jobs:
        _header(found, job, older)
        _labels(found, job, older)
        _locals(found, job)
        for number, line in job.body:
            found.wrong_forms(_WRONG, number, _code(line))
            _instruction(found, number, line)
            called = _CALLED.search(_code(line))
            if called and called[1] not in names:
                found.unknown.append((called[1], _at(number, called, 1), "the job"))
            elif called:
                found.known.add(called[1])
    whole = any(re.split(r"[\\/]", one.path)[-1].casefold() in _BACKUP for one in cell.sources)
    return found.finish(names, whole, shared=True)


def _is_job(source: Source) -> bool:
    return source.path.lower().endswith(".jbi")


def _at(number: int, match: re.Match[str], group: int = 0) -> Span:
    return Span(number, match.start(group) + 1, match.end(group) + 1)


def _jobs(source: Source) -> list[JobText]:
    found: list[JobText] = []
    in_body = False
    for number, line in enumerate(source.lines, 1):
        text = line.strip()
        if text == "/JOB" or not found:
            found.append(JobText(line=number))
            in_body = False
        job = found[-1]
        if in_body:
            job.body.append((number, line))
        elif text.startswith("//"):
            word, _, value = text.lstrip("/").partition(" ")
            job.records.append((number, word, value.strip()))
            if word == "NAME":
                job.name, job.line = value.strip(), number
        elif text.startswith("NOP"):
            in_body = True
        elif row := _ROW.match(line):
            job.rows.append((number, row[1]))
    return found


def _code(line: str) -> str:
    """A line without texts and comments; every column stays."""
    bare = _TEXT.sub(lambda match: " " * len(match[0]), line)
    return bare.partition("//")[0]


def _header(found: LoadFindings, job: JobText, older: bool) -> None:
    found.too_long("name", job.name, found.place_of(job.line, job.name), _LONGEST_JOB[older])
    rows = (
        (number, re.sub(r"\d+", lambda match: str(int(match[0])), name), name) for number, name in job.rows
    )
    found.doubles((key, f"the position {name}", found.whole_line(number)) for number, key, name in rows)
    for word in ("TOOL", "USER"):
        for number, value in job.values(word):
            if value.isdigit() and int(value) > _LARGEST_FRAME:
                found.tell("K109", f"///{word} {value}", found.whole_line(number), f"0 to {_LARGEST_FRAME}")
    attributes = " ".join(value for _, value in job.values("ATTR"))
    moves = next((number for number, line in job.body if _MOVES.match(line)), 0)
    if moves and attributes[:1] == "S" and not job.values("GROUP1"):
        says = "the job moves, and its header names no control group"
        found.tell("K114", says, found.whole_line(moves), "add ///GROUP1 RB1 behind ///ATTR")


def _labels(found: LoadFindings, job: JobText, older: bool) -> None:
    labels = [(number, match) for number, line in job.body if (match := _LABEL.match(line))]
    found.doubles((match[1], f"the label {match[1]}", _at(number, match, 1)) for number, match in labels)
    for number, match in labels if older else ():
        found.too_long("label", match[1], _at(number, match, 1), _LONGEST_LABEL)


def _locals(found: LoadFindings, job: JobText) -> None:
    """Whether ///LVARS of the instructions, the last one, allocates the local variables."""
    counts: list[int] = []
    rows = job.values("LVARS")
    if rows and re.fullmatch(r"[\d,\s]+", rows[-1][1]):
        counts = [int(one) if one.strip() else 0 for one in rows[-1][1].split(",")]
    known = dict(zip(_LOCALS, [*counts, *([0] * len(_LOCALS))], strict=False))
    told: set[str] = set()
    for number, line in job.body:
        for match in _LOCAL.finditer(_code(line)):
            if int(match[2]) < known[match[1]] or match[0] in told:
                continue
            told.add(match[0])
            says = (
                f"///LVARS allocates {known[match[1]]} variables {match[1]}, and {match[0]} is none of them"
            )
            found.tell("K109", says, _at(number, match), "count it in ///LVARS: B,I,D,R,S,P,BP,EX")


def _instruction(found: LoadFindings, number: int, line: str) -> None:
    text = line.strip()
    if not text or text[0] in "'*" or text.startswith("//"):
        return
    code = _code(line)
    quote = code.find("'")
    if quote >= 0:
        says = "a ' comment behind an instruction"
        found.tell("K105", says, Span(number, quote + 1, len(line.rstrip()) + 1), "give it a line of its own")
        code = code[:quote]
    for match in _SHARE.finditer(code):
        if float(match[1]) > _LARGEST_SHARE:
            found.tell(
                "K109", f"{match[0]} is out of range", _at(number, match), f"{_LARGEST_SHARE:g} at most"
            )
    given = len(_ARGUMENT.findall(code))
    found.arguments("a job", found.whole_line(number), (0, MOST_ARGUMENTS), given)
    for match in _TAKEN.finditer(code):
        if not 1 <= int(match[1]) <= MOST_ARGUMENTS:
            found.tell("K109", f"there is no argument {match[0]}", _at(number, match), "1 to 8")
    value = _SET.match(code)
    if value is not None:
        least, greatest = _RANGES[value[1]]
        if not least <= int(value[2]) <= greatest:
            says = f"{value[2]} does not fit into a variable {value[1]}"
            found.tell("K108", says, _at(number, value, 2), f"{least} to {greatest}")
    _word(found, number, code)


def _word(found: LoadFindings, number: int, code: str) -> None:
    """An instruction that olp does not know is told where it is nearly one that it knows."""
    word = _WORD.match(code)
    if word is None or word[1] in _words():
        return
    near = next((one for one in sorted(_words()) if is_near(one, word[1])), "")
    if near:
        says = f"the instruction {word[1]} is not known"
        found.undeclared(says, _at(number, word, 1), f"did you mean {near}?", whole=False)


def _words() -> frozenset[str]:
    from olp.languages.vendors.inform.statements import instruction_parser

    return instruction_parser().words


LOAD: Final = Loading(("yrc1000", "dx200", "dx100", "nx100"), check, (".sys", ".prm"))
