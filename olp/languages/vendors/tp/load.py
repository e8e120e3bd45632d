"""What a FANUC controller rejects when it loads a listing (ASCII program loader, alarms ASBN).

Tried on controllers or in ROBOGUIDE by public projects: a group output set from a group input, a negative constant
without parentheses as an argument, an argument register as a speed or CNT (ASBN-092), a `"` in the header's COMMENT.
From the operator's manual (R-30iB, branch instructions): AND and OR do not stand in one condition, as it is without
parentheses; (register instructions, from memory) + and - do not stand beside * and /, and five operators are the most;
(program detail) a program's comment has up to 16 characters.
From the field's reference: up to 36 characters in a program's name, 8 before the R-30iA; labels from 1 to 32766.
From memory: labels and positions are unique, what names consist of, 10 arguments, numbers from 1, CNT and joint speeds
up to 100, moves need a motion group, what speeds moves take, what signals are compared with, where `!` and THEN need
parentheses. In 456 listings of public cells none breaks one of the rules of `_WRONG`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final, NamedTuple

from olp.core.diagnostic import Diagnostic, Span
from olp.core.source import Source
from olp.languages.loading import LoadedCell, LoadFindings, Loading, WrongForm
from olp.languages.vendors.tp.limits import LARGEST_LABEL, MOST_ARGUMENTS, ROUTINE_LENGTH

_OLDER: Final = ("r-j3",)
_SHORT: Final = 8  # characters of a program's name, on older controllers
_LONGEST_COMMENT: Final = 16  # characters, of the header
_MOST_OPERATORS: Final = 5  # of one instruction without parentheses
_MOST_SHARE: Final = 100  # CNT and speeds of joint moves

_PROGRAM: Final = re.compile(r"\s*/PROG\s+([^\s;]+)")
_SECTION: Final = re.compile(r"\s*/(PROG|ATTR|APPL|MN|POS|END)\b")
_NAMES: Final = re.compile(r"(\[\s*\d+):[^\]]*(?=\])")
_COMMENT: Final = re.compile(r'\s*COMMENT\s*=\s*"(.*)"\s*;?\s*$')
_GROUP: Final = re.compile(r"\s*DEFAULT_GROUP\s*=\s*([^;]*)")
_LINE: Final = re.compile(r"\s*\d*\s*:")
_REMARK: Final = re.compile(r"\s*\d*\s*:\s*(?:!|//|--)")
_LABEL: Final = re.compile(r"\s*\d*\s*:\s*LBL\[\s*(\d+)")
_POSITION: Final = re.compile(r"\s*P\[\s*(\d+)[^\]]*\]\s*\{")
_NUMBERED: Final = re.compile(r"\b(R|PR|SR|AR|P|LBL|DI|DO|RI|RO|GI|GO|AI|AO|F|M|TIMER)\[\s*(0+)\s*[\]:]")
_MOVE: Final = re.compile(r"\s*\d*\s*:\s*([JLCAS])\s+P(?:R)?\[")
_SHARE: Final = re.compile(r"\bCNT\s*(\d+)|(?<=[\s\]])(\d+)%")
_BY_ARGUMENT: Final = re.compile(
    r"\bCNT\s*AR\[|(?<=\s)AR\[[^\]]*\]\s*(?:%|mm/sec|cm/min|sec\b|deg/sec|inch/min)"
)
_HANDED_ON: Final = re.compile(r"\bGO\[[^\]]*\]\s*=\s*GI\[[^\]]*\]\s*;")
_COMPUTED: Final = re.compile(r"\s*\d*\s*:\s*(?:R|AO|GO)\[[^\]]*\]\s*=([^;]*);")
_CALL: Final = re.compile(r"\b(?:CALL|RUN)\s+([A-Za-z_]\w*)\s*(?:\(([^()]*(?:\([^()]*\)[^()]*)*)\))?")


_SIGNAL: Final = r"\b(?:[DRSUW][IO]|F|M)\[[^\]]*\]\s*(?:=|<>)\s*[\d.]+"
_WRONG: Final = (
    WrongForm(
        re.compile(r"(?<=:)\s*J\s+PR?\[[^\]]*\]\s+\S+?(?:mm/sec|cm/min|inch/min|deg/sec)"),
        "K108",
        "a joint move with the speed of a line",
        "J P[1] 50% FINE, or a time in sec",
    ),
    WrongForm(
        re.compile(r"(?<=:)\s*[LAS]\s+PR?\[[^\]]*\]\s+(?:\d+|R\[[^\]]*\])\s*%"),
        "K108",
        "a line with the speed of a joint move",
        "L P[1] 500mm/sec FINE",
    ),
    WrongForm(re.compile(_SIGNAL), "K108", "a signal is a number here", "ON or OFF"),
    WrongForm(
        re.compile(r"\bOVERRIDE\s*=\s*(?!0*100%)\d{3,}\s*%"),
        "K109",
        "the override is out of range",
        "100 at most",
    ),
    WrongForm(
        re.compile(r"\bPR\[\s*\d+\s*,\s*(?:0|\d{2,})\s*\]"),
        "K109",
        "a position has no such element",
        "1 to 9",
    ),
    WrongForm(
        re.compile(r"(?<=:)\s*IF\s+[^(\s].*\bTHEN\b"), "K114", "IF … THEN without parentheses", "IF (…) THEN"
    ),
    WrongForm(
        re.compile(r"(?<=:)\s*(?:IF|WAIT)\s+[^(\s][^(]*!"),
        "K114",
        "! stands without parentheses",
        "IF (!DI[1]),…",
    ),
    WrongForm(
        re.compile(r"(?<=:)\s*(?:IF|WAIT)\s+(?=[^(\s])(?=[^(]*\bAND\b)(?=[^(]*\bOR\b)[^,(;]*"),
        "K114",
        "AND and OR in one condition without parentheses",
        "IF (… AND … OR …),…",
    ),
)


class Listing(NamedTuple):
    """One program of a file: its name and the lines (from 1) of its sections' texts."""

    name: str
    line: int
    lines: dict[str, list[int]]


def check(source: Source, cell: LoadedCell) -> list[Diagnostic]:
    """What a controller rejects in one listing."""
    found = LoadFindings(source)
    for listing in _listings(source):
        _head(found, listing, cell.controller in _OLDER)
        _numbers(found, listing)
        for number in listing.lines["MN"]:
            line = source.line(number)
            if _LINE.match(line) and not _REMARK.match(line):
                _instruction(found, number, line)
    names = {listing.name for one in cell.sources for listing in _listings(one)}
    # A program of Karel, which no listing shows, is often called like its listing but for a _: ROS_STATE, ROSSTATE.
    known = {_without_lines(name) for name in names}
    found.unknown = [one for one in found.unknown if _without_lines(one[0]) not in known]
    return found.finish(names, whole=False, shared=True)


def _without_lines(name: str) -> str:
    return name.upper().replace("_", "")


def _listings(source: Source) -> Iterator[Listing]:
    current, section = Listing("", 1, {}), ""
    for number, line in enumerate(source.lines, 1):
        opened = _SECTION.match(line) if "/" in line[:8] else None
        if opened is not None:
            section = opened[1]
            if section == "PROG":
                if current.name:
                    yield current
                name = _PROGRAM.match(line)
                current = Listing(name[1] if name else "", number, {one: [] for one in ("ATTR", "MN", "POS")})
        elif section in current.lines:
            current.lines[section].append(number)
    if current.name:
        yield current


def _at(number: int, match: re.Match[str], group: int = 0) -> Span:
    return Span(number, match.start(group) + 1, match.end(group) + 1)


def _head(found: LoadFindings, listing: Listing, older: bool) -> None:
    name, line = listing.name, found.source.line(listing.line)
    at = line.find(name, line.find("/PROG") + 5) + 1
    span = Span(listing.line, at, at + len(name))
    found.too_long("name", name, span, _SHORT if older else ROUTINE_LENGTH)
    if not re.fullmatch(r"-?[^\W\d]\w*-?", name):
        says = f"the name {name[:40]} has other characters than letters, digits and _, or begins with a digit"
        found.tell("K105", says, span, "PICK_2")
    group = "1"
    for number in listing.lines["ATTR"]:
        text = found.source.line(number)
        comment, mask = _COMMENT.match(text), _GROUP.match(text)
        if comment and len(comment[1].rstrip()) > _LONGEST_COMMENT:
            says = f"the comment of the header has {len(comment[1].rstrip())} characters"
            found.tell("K103", says, _at(number, comment, 1), f"{_LONGEST_COMMENT} at most")
        if comment and '"' in comment[1]:
            found.tell("K105", 'a " within the comment of the header', _at(number, comment, 1), "write '")
        group = mask[1] if mask else group
    moves = (number for number in listing.lines["MN"] if _MOVE.match(found.source.line(number)))
    if "1" not in group and (first := next(moves, 0)):
        says = "the program moves, and DEFAULT_GROUP names no motion group"
        found.tell("K114", says, found.whole_line(first), "DEFAULT_GROUP = 1,*,*,*,*;")


def _numbers(found: LoadFindings, listing: Listing) -> None:
    """Labels and positions stand once, and labels have numbers that a controller takes."""
    for section, pattern, shown in (("MN", _LABEL, "LBL"), ("POS", _POSITION, "P")):
        lines = ((number, pattern.match(found.source.line(number))) for number in listing.lines[section])
        places = [(f"{shown}[{int(match[1])}]", _at(number, match, 1)) for number, match in lines if match]
        found.doubles(((name, name, span) for name, span in places), "give one of them another number")
        for name, span in places if section == "MN" else ():
            if int(name[4:-1]) > LARGEST_LABEL:
                found.tell("K109", f"there is no {name}", span, f"1 to {LARGEST_LABEL}")


def _instruction(found: LoadFindings, number: int, line: str) -> None:
    # What stands behind a colon in brackets is free text.
    code = _NAMES.sub(lambda match: match[1] + " " * (len(match[0]) - len(match[1])), line)
    code = re.sub(r"'[^']*'|\"[^\"]*\"", lambda match: " " * len(match[0]), code)
    for match in _NUMBERED.finditer(code):
        found.tell("K109", f"there is no {match[1]}[0]", _at(number, match), "numbers begin at 1")
    found.wrong_forms(_WRONG, number, code)
    if handed := _HANDED_ON.search(code):
        help = "through a register: R[1]=GI[1], GO[1]=R[1] (ASBN-092)"
        found.tell("K108", "a group output takes no group input", _at(number, handed), help)
    if move := _MOVE.match(code):
        if given := _BY_ARGUMENT.search(code):
            help = "copy it into a register: R[1]=AR[1] (ASBN-092)"
            found.tell("K108", "a move takes no argument register", _at(number, given), help)
        for match in _SHARE.finditer(code):
            share = match[1] or (match[2] if move[1] == "J" else None)
            if share and int(share) > _MOST_SHARE:
                found.tell(
                    "K109", f"{match[0]} is out of range", _at(number, match), f"{_MOST_SHARE} at most"
                )
    for match in _CALL.finditer(code):
        _call(found, number, match)
    if (computed := _COMPUTED.match(code)) and "(" not in computed[1]:
        _arithmetic(found, number, computed)


def _arithmetic(found: LoadFindings, number: int, computed: re.Match[str]) -> None:
    """An instruction of a register, which is no mixed logic without parentheses."""
    bare = re.sub(r"\[[^\]]*\]", "[]", computed[1]).strip().lstrip("-")
    signs = re.findall(r"(?<=[\]\d])\s*([-+*/]|DIV|MOD)(?=[-\s\w])", bare)
    if len(signs) > _MOST_OPERATORS:
        says = f"{len(signs)} operators in one instruction"
        found.tell(
            "K114", says, _at(number, computed, 1), f"{_MOST_OPERATORS} at most, or parentheses around it"
        )
    elif {"+", "-"}.intersection(signs) and {"*", "/", "DIV", "MOD"}.intersection(signs):
        says = "+ or - beside * or / without parentheses"
        found.tell("K114", says, _at(number, computed, 1), "write R[1]=(R[2]+R[3]*R[4]), or two instructions")


def _call(found: LoadFindings, number: int, match: re.Match[str]) -> None:
    found.unknown.append((match[1], _at(number, match, 1), "the program"))
    arguments = [one.strip() for one in (match[2] or "").split(",") if one.strip()]
    found.arguments(match[1], _at(number, match, 1), (0, MOST_ARGUMENTS), len(arguments))
    for one in arguments:
        if re.fullmatch(r"-[\d.]+", one):
            says = f"{one} stands without parentheses"
            found.tell("K112", says, _at(number, match, 2), f"write ({one}) (ASBN-092)")


LOAD: Final = Loading(("r-30ib", "r-30ia", "r-j3"), check)
