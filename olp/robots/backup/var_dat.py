"""VAR.DAT: the values of a controller's variables when the backup was made.

Layout, as seen in backups: `///PFNUM` (axes of robot, base and station), `///SHARE` (how many variables of
each kind), then `///B ///I ///D ///R` with ten values a row, `///S` with one text a row, `///P ///BP ///EX`
with one variable a row: a quoted kind, flags, then up to eight values; `"UNUSED"` when nothing was stored.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from olp.core.units import deg, mm
from olp.robots.backup.controller_text import BackupFindings, BackupLine, fields, integers, numbers, record

_ORDER: Final = ("B", "I", "D", "R", "S", "P", "BP", "EX")
_LIMITS: Final = {"B": (0, 255), "I": (-32768, 32767), "D": (-(2**31), 2**31 - 1)}
_CARTESIAN: Final = ("RECTAN", "BASE", "ROBOT", "USER", "TOOL", "MTOOL")
_MOST_VALUES: Final = 8
# Rows of newer controllers: three marks, the 24 arm flags as one word, a mark and the tool, then the values.
_ARM_FLAGS: Final = re.compile(r"[01]{24}")
_FLAGS_WITH_ARM: Final = 6


@dataclass(frozen=True, slots=True)
class PositionVariable:
    """One P, BP or EX variable. `values` in pulses for PULSE, in rad for ANGLE, else x, y, z [m] and angles
    [rad] (BP: slide positions [m]).
    """

    kind: str  # PULSE, ANGLE, or a Cartesian kind
    values: tuple[float, ...]
    flags: tuple[int, ...] = ()  # as stored; what each one means is not published
    line: int = 0

    @property
    def frame(self) -> str:
        """The frame that the file names for Cartesian values; BASE where it only says RECTAN (an assumption, B008)."""
        return self.kind if self.kind in _CARTESIAN[1:] else "BASE" if self.kind == "RECTAN" else ""


@dataclass(frozen=True, slots=True)
class Variables:
    """The global variables by number. Positions without a value are absent."""

    B: dict[int, int] = field(default_factory=dict)
    I: dict[int, int] = field(default_factory=dict)  # noqa: E741 the language's own name
    D: dict[int, int] = field(default_factory=dict)
    R: dict[int, float] = field(default_factory=dict)
    S: dict[int, str] = field(default_factory=dict)
    P: dict[int, PositionVariable] = field(default_factory=dict)
    BP: dict[int, PositionVariable] = field(default_factory=dict)
    EX: dict[int, PositionVariable] = field(default_factory=dict)


class _Used(NamedTuple):
    """A row of ///P, ///BP or ///EX with a value: its quoted kind, and the numbers with their columns."""

    number: int
    row: BackupLine
    word: str
    parts: list[tuple[int, str]]


def read_var_dat(rows: tuple[BackupLine, ...], findings: BackupFindings) -> Variables:
    """The variables; unreadable values are omitted, each with an error finding."""
    heads, sections = _sections(rows)
    share = _counts("SHARE", heads, findings)
    axes = _counts("PFNUM", heads, findings)
    variables = Variables()
    for index, kind in enumerate(_ORDER):
        allowed = share[index] if index < len(share) else None
        if kind not in sections:
            if allowed and sections:
                message = f"///{kind} is missing: ///SHARE announces {allowed} variables"
                findings.error("B002", message, heads["SHARE"])
            continue
        if kind in _LIMITS:
            _integer_table(kind, sections[kind], getattr(variables, kind), findings)
        elif kind == "R":
            _real_table(sections[kind], variables.R, findings)
        elif kind == "S":
            variables.S.update(enumerate(row.text.strip('"') for row in sections[kind][:allowed]))
        else:
            width = axes[index - 5] if index - 5 < len(axes) else 0
            _position_table(kind, sections[kind], width, getattr(variables, kind), findings)
        _check_count(kind, heads[kind], sections[kind], allowed, findings)
    if rows and not sections:
        findings.error("B004", "none of ///B ///I ///D ///R ///S ///P ///BP ///EX is in this file")
    return variables


def _sections(rows: tuple[BackupLine, ...]) -> tuple[dict[str, BackupLine], dict[str, list[BackupLine]]]:
    """The record rows by keyword, and the rows below each kind of variable."""
    heads: dict[str, BackupLine] = {}
    sections: dict[str, list[BackupLine]] = {}
    current: list[BackupLine] | None = None
    for row in rows:
        slashes, keyword, _ = record(row)
        if slashes == "///" and keyword in (*_ORDER, "SHARE", "PFNUM"):
            heads[keyword] = row
            current = sections.setdefault(keyword, []) if keyword in _ORDER else None
        elif current is not None:
            current.append(row)
    return heads, sections


def _counts(keyword: str, heads: dict[str, BackupLine], findings: BackupFindings) -> tuple[int, ...]:
    row = heads.get(keyword)
    if row is None:
        return ()
    return integers(row, findings, row.text.find(keyword) + len(keyword)) or ()


def _check_count(
    kind: str, head: BackupLine, rows: list[BackupLine], allowed: int | None, findings: BackupFindings
) -> None:
    """Reports a section with fewer variables than ///SHARE states (it was cut) or with more (it was edited)."""
    if allowed is None:
        return
    given = (
        len(rows) if kind not in ("B", "I", "D", "R") else sum(len(fields(r)) for r in rows if r.text.strip())
    )
    if given < allowed:
        message = f"///{kind} is cut: ///SHARE announces {allowed} variables, {given} are here"
        findings.error("B002", message, head, help="save VAR.DAT from the controller again")
    elif given > allowed:
        findings.warning("B004", f"///{kind} holds {given} variables, ///SHARE announces {allowed}", head)


def _integer_table(
    kind: str, rows: list[BackupLine], table: dict[int, int], findings: BackupFindings
) -> None:
    low, high = _LIMITS[kind]
    number = 0
    for row in rows:
        if not row.text.strip():
            continue
        values = integers(row, findings)
        for offset, value in enumerate(values or ()):
            if low <= value <= high:
                table[number + offset] = value
            else:
                column, part = fields(row)[offset]
                message = f"{part} is outside {low} .. {high}, the range of {kind} variables"
                findings.error("B003", message, row, start=column, end=column + len(part))
        number += len(fields(row))


def _real_table(rows: list[BackupLine], table: dict[int, float], findings: BackupFindings) -> None:
    number = 0
    for row in rows:
        if row.text.strip():
            values = numbers(row, findings)
            table.update(enumerate(values or (), start=number))
            number += len(fields(row))


def _position_table(
    kind: str, rows: list[BackupLine], axes: int, table: dict[int, PositionVariable], findings: BackupFindings
) -> None:
    """Fill `table` from the rows. `axes`: the number of values that ///PFNUM announces for this kind; 0 if it does
    not.
    """
    used: list[_Used] = []
    for number, row in enumerate(rows):
        parts = _split_kind(fields(row))
        word = parts[0][1]
        if not (len(word) > 2 and word[0] == word[-1] == '"'):
            findings.error(
                "B003", f'{kind}{number:03d} does not begin with a quoted kind such as "PULSE"', row
            )
        elif word != '"UNUSED"':
            used.append(_Used(number, row, word.strip('"'), parts[1:]))
    flags = _flag_count(kind, used, axes, findings)
    for number, row, word, parts in used:
        if word not in ("PULSE", "ANGLE", *_CARTESIAN):
            findings.warning("B006", f"{kind}{number:03d} has the kind {word!r} and is left out", row)
            continue
        variable = _position(word, row, parts, flags, findings)
        if variable is not None:
            table[number] = variable


def _split_kind(parts: list[tuple[int, str]]) -> list[tuple[int, str]]:
    """The row's fields with the quoted kind as a field of its own: controllers write `"PULSE"0,0,1` without a comma."""
    column, first = parts[0]
    end = first.find('"', 1) + 1
    if not (first.startswith('"') and 0 < end < len(first)):
        return parts
    return [(column, first[:end]), (column + end, first[end:]), *parts[1:]]


def _flag_count(kind: str, used: list[_Used], axes: int, findings: BackupFindings) -> int:
    """How many numbers between the kind and the values are flags.

    In Cartesian rows those before the first decimal point, else the numbers in excess of ///PFNUM. No manual
    documents this, so the assumption is reported.
    """
    if not used:
        return 0
    cartesian = [entry for entry in used if entry.word in _CARTESIAN]
    leading = (
        next((index for index, (_, part) in enumerate(entry.parts) if "." in part), None)
        for entry in cartesian
    )
    known = [count for count in leading if count is not None]
    shortest = min(len(entry.parts) for entry in used)
    width = axes if 0 < axes <= _MOST_VALUES else min(shortest, _MOST_VALUES)
    flagged = all(len(entry.parts) > 3 and _ARM_FLAGS.fullmatch(entry.parts[3][1]) for entry in used)
    count = _FLAGS_WITH_ARM if flagged else min(known) if known else max(0, shortest - width)
    if count:
        message = (
            f"the first {count} numbers of {kind} variables are taken as flags, the others as the values"
        )
        findings.info("B008", message, used[0].row)
    if any(entry.word == "RECTAN" for entry in cartesian):
        message = f"which frame {kind} variables are in is not known: they are taken as base coordinates"
        findings.info("B008", message, cartesian[0].row)
    return count


def _position(
    word: str, row: BackupLine, parts: list[tuple[int, str]], flags: int, findings: BackupFindings
) -> PositionVariable | None:
    if not flags < len(parts) <= flags + _MOST_VALUES:
        findings.error("B004", f"{len(parts)} numbers are not {flags} flags and up to 8 values", row)
        return None
    split = parts[flags][0]
    head = BackupLine(row.line, row.text[:split].rstrip().rstrip(","))
    marks = integers(head, findings, parts[0][0]) if flags else ()
    values = numbers(row, findings, split)
    if marks is None or values is None:
        return None
    if word == "ANGLE":
        values = tuple(value * deg for value in values)
    elif word in _CARTESIAN:
        # Three lengths, then angles; a base has one to three lengths and no angles.
        values = tuple(value * (mm if axis < 3 else deg) for axis, value in enumerate(values))
    return PositionVariable(word, values, marks, row.line)
