"""What may be changed independently in an INFORM job: records, rows of positions, instructions.

A controller numbers the positions of a job anew whenever a step comes or goes, so a number is followed by the moves
that use it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import ClassVar, Final

from olp.languages.merging import (
    NUMBER,
    Choice,
    Cut,
    Known,
    MergeRules,
    MoveArgument,
    NumberedUse,
    Piece,
    RecordRule,
    Row,
    Side,
    TableText,
    holds,
    lines_of,
)

_ROW: Final = re.compile(r"\s*(BC|BP|EC|EX|C|P|E)(\d{1,9})=(.*)", re.ASCII)
_USED: Final = re.compile(r"(?<![A-Z0-9#])(BC|EC|C|E)(\d{3,9})(?![\w(])", re.ASCII)
_RECORD: Final = re.compile(r"///(\w+)\s*(.*)")
_STATE: Final = ("USER", "TOOL", "POSTYPE", "KIND", "RCONF", "LIMIT")
_KINDS: Final = ("RECTAN", "PULSE", "ANGLE")
_COUNTS: Final = re.compile(r"\d+(?:,\d+)*")
_FAMILIES: Final = ("C", "BC", "EC", "P", "BP", "EX")
_SAVED: Final = re.compile(r"\s*//(VAR|TOOL|UFRAME|MACRO\d*)\b")
_MOVE: Final = re.compile(r"(I?MOV[JLCS])(?= )")
_ARGUMENT: Final = re.compile(r"\s+(?:(V|VJ|VR|VE|PL|CR|ACC|DEC)=)?\S+")
_ARGUMENTS: Final = {
    "V": "speed", "VJ": "speed", "VR": "speed", "VE": "speed", "PL": "zone", "CR": "zone", "ACC": "acceleration",
    "DEC": "deceleration",
}  # fmt: skip
_TAUGHT: Final = ("C", "BC", "EC", "E")


class InformMerging(MergeRules):
    comments = ("//",)
    whole_comments = ("'",)
    heads: ClassVar[tuple[tuple[re.Pattern[str], RecordRule], ...]] = (
        (re.compile(r"///DATE\b"), RecordRule.NEWEST),
        (re.compile(r"///NPOS\b"), RecordRule.COUNTED),
        (re.compile(r"//(?:NAME|INST)\b|/{3,4}[A-Z]+\d*"), RecordRule.ASK),
    )

    saved_suffixes = (".dat", ".cnd")

    def of_saved(self, text: str) -> MergeRules | None:
        head = _SAVED.match(text)
        return None if head is None else _VARIABLES if head[1] == "VAR" else _CONDITIONS

    def cut(self, text: str, known: Known) -> Cut:
        pieces: list[Piece] = []
        tables: dict[str, _Table] = {}
        job, table = "", None
        lines = lines_of(text)
        several = sum(line[0].startswith("//NAME") for line in lines) > 1  # else a job may get another name
        for line in lines:
            words = line[0].strip() if line[0].lstrip().startswith("/") else ""
            if several and words.startswith("//NAME"):
                job = words[6:].strip()
            if words.startswith("///NPOS"):
                at = len(pieces) - 1 if table is not None else len(pieces)
                pieces.insert(at, self._line(line, job))
                continue
            if table is not None and (not words or words.startswith("///")):
                table.take(line)
                continue
            table = None
            if words == "//POS":
                table = tables[f"table {job}"] = _Table(job)
                here = Piece((line[0],), (line[1],), words, f"{job}:head //POS")
                pieces += [here, Piece((), (), "", f"table {job}")]
                continue
            key = (*line, job)  # numbers are those of a job
            piece = known.get(key)
            if piece is None:
                piece = known[key] = self._line(line, job)
            pieces.append(piece)
        rows = {name: one.rows for name, one in tables.items()}
        fixed = {row.use.family for some in rows.values() for row in some} - {
            f"{one.job}:{family}" for one in tables.values() for family in _TAUGHT
        }
        return Cut(pieces, rows, {name: tuple(one.lead) for name, one in tables.items()}, frozenset(fixed))

    def _line(self, line: tuple[str, str], job: str) -> Piece:
        text, end = line
        if text.lstrip().startswith("/"):
            piece, _ = self._piece([line], 0, "")
            return replace(piece, name=f"{job}:{piece.name}") if piece.name else piece
        stop = len(text) if text.startswith("'") else self._comment(text)
        quote = text.find('"')
        stop = stop if quote < 0 else min(stop, quote)
        head, uses = text[:stop], []
        if not text.startswith("'"):
            for found in _USED.finditer(head):
                uses.append((found.span(2), NumberedUse(f"{job}:{found[1]}", int(found[2]), len(found[2]))))
        for (start, last), _ in reversed(uses):
            text = text[:start] + NUMBER + text[last:]
        return Piece((text,), (end,), self.code(text), uses=tuple(use for _, use in uses))

    def arguments(self, code: str) -> list[MoveArgument]:
        move = _MOVE.match(code)
        if move is None or "+" in code or "UNTIL" in code:
            return []
        rest = _ARGUMENT.finditer(code, move.end())
        return [
            MoveArgument("motion", move[0]),
            *(MoveArgument(_ARGUMENTS.get(one[1], "place"), one[0]) for one in rest),
        ]

    def rows(self, rows: Sequence[Choice]) -> Iterator[TableText]:
        now: tuple[str, ...] | None = _NOTHING
        for choice in rows:
            if isinstance(choice, Row):
                yield from _told(choice, now)
                now = choice.state
                continue
            # Only what the two sides differ in stands in a conflict.
            holds = all(row is None or (now is not None and _means(now) == row.means) for row in choice)
            for side, row in zip(Side, choice, strict=True):
                for told in () if row is None else _told(row, row.state if holds else None):
                    yield told._replace(side=side, row=row)
            now = now if holds else None

    def joined_row(self, base: Row, ours: Row, theirs: Row) -> Row | None:
        """Pulses say where the arm goes whatever tool it holds."""
        if any(_means(row.state)[1] != "///PULSE" for row in (base, ours, theirs)):
            return None
        axes = holds(*(row.lines[0].split() for row in (base, ours, theirs)))
        tool = holds(base.means, ours.means, theirs.means)
        if axes is None or tool is None:
            return None
        moved, held = ((ours, theirs)[side.value] for side in (axes, tool))
        return replace(held, lines=moved.lines, ends=moved.ends)

    def counted(self, piece: Piece, totals: Mapping[str, int], lines: int) -> str:
        job = piece.name.partition(":")[0]
        told = ",".join(str(totals.get(f"{job}:{family}", 0)) for family in _FAMILIES)
        return _COUNTS.sub(told, piece.lines[0], 1)

    def spelled(self, use: NumberedUse, number: int) -> str:
        return f"{number:0{use.width}d}"


_NOTHING: Final = ("",) * len(_STATE)


class _Table:
    """The records and rows of one //POS."""

    def __init__(self, job: str) -> None:
        self.job = job
        self.rows: list[Row] = []
        self.lead: list[tuple[str, str]] = []
        self.state = self.before = _NOTHING

    def take(self, line: tuple[str, str]) -> None:
        match = _ROW.match(line[0])
        if match is None:
            self.lead.append(line)
            self._record(line[0])
            return
        use = NumberedUse(f"{self.job}:{match[1]}", int(match[2]), len(match[2]))
        text = f"{line[0][: match.start(2)]}{NUMBER}={match[3]}"
        means = _means(self.state)
        self.rows.append(Row(use, (text,), (line[1],), self.state, tuple(self.lead), self.before, means))
        self.lead, self.before = [], self.state

    def _record(self, text: str) -> None:
        word = _is_state(text)
        if word:
            at = _STATE.index(word)
            self.state = (*self.state[:at], " ".join(text.split()), *self.state[at + 1 :])


def _is_state(text: str) -> str:
    """What a record says of the rows behind it, "" for any other line."""
    match = _RECORD.match(text.strip())
    word = "" if match is None else "KIND" if match[1] in _KINDS else match[1]
    return word if word in _STATE else ""


def _means(state: tuple[str, ...]) -> tuple[str, ...]:
    user, tool, kind, measure, flags, limit = state
    if measure in ("", "///PULSE"):
        return (tool, measure, limit)
    return (tool, kind, measure, flags, limit, user if kind.endswith("USER") else "")


def _told(row: Row, now: tuple[str, ...] | None) -> Iterator[TableText]:
    """The row with the records that it needs where `now` holds."""
    if now is not None and now == row.before and row.lead:
        for text, end in row.lead:
            yield TableText(text, end)
    elif now is None or _means(now) != row.means:
        for text, end in row.lead:
            if not _is_state(text):
                yield TableText(text, end)
        for at, record in enumerate(row.state):
            if record and (now is None or now[at] != record):
                yield TableText(record, row.ends[0])
    yield TableText(row.lines[0], row.ends[0], row=row)


class ConditionMerging(MergeRules):
    """Tools, user frames and macros: each row by its place below its record."""

    def _pieces(self, lines: Sequence[tuple[str, str]], known: Known) -> Iterator[Piece]:
        section = record = ""
        row = 0
        for text, end in lines:
            words = text.strip()
            if words.startswith("//"):
                section, record = (record_of(words), "") if words[2:3] != "/" else (section, record_of(words))
                row = 0
            elif words:
                row += 1
            name = f"{section} {record} {row}".strip() if words else ""
            yield Piece((text,), (end,), self.code(text), name and f"/{name}")


class VariableMerging(ConditionMerging):
    """VAR.DAT: each value of a row; a position is one."""

    def arguments(self, code: str) -> list[MoveArgument]:
        if code.startswith('"'):
            return []
        values = re.findall(r"[^,]*,?", code)[:-1]
        return [MoveArgument(f"value {number}", value) for number, value in enumerate(values, 1)]


def record_of(words: str) -> str:
    """The name of a record, with what is behind `//`: `//TOOL 3`; of `///` the name alone."""
    return words[2:] if words[2:3] != "/" else words.strip("/").partition(" ")[0]


_CONDITIONS: Final = ConditionMerging()
_VARIABLES: Final = VariableMerging()
MERGING = InformMerging()
