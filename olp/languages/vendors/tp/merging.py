"""What may be changed independently in a TP listing: attributes, numbered instructions, positions.

Lines are numbered anew when the merged program is written, as far as the base counts them. Positions keep their
numbers, but two new ones of one number become two.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

from olp.languages.merging import (
    COUNTER,
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

_SECTION: Final = re.compile(r"/[A-Z]+\b")
_NUMBERED: Final = re.compile(r"\s*\d+:")
_ANY_NUMBER: Final = re.compile(r"^[ \t]*(\d+):", re.MULTILINE)
_USED: Final = re.compile(r"(?<![\w$])P\[\s*(\d+)")
_INDIRECT: Final = re.compile(r"(?<![\w$])P\[\s*[A-Z]")
_MOVE: Final = re.compile(
    rf"""({COUNTER}*(?:\s*\d+:)?\s*[JL])(\s+PR?\[[^\]]*\])
    (\s+(?:\d+(?:\.\d+)?|R\[[^\]]*\])\s*(?:mm/sec|cm/min|inch/min|deg/sec|m?sec|%)|\s+max_speed)
    (\s+(?:FINE|CNT\s*(?:\d+|R\[[^\]]*\])|CD\d+|CR\d+))(\s+ACC\s*\d+)?([^;"]*)(;.*)""",
    re.VERBOSE,
)
_PARTS: Final = ("motion", "place", "speed", "zone", "acceleration", "place", "motion")
_HEAD: Final = re.compile(r"\s*P\s*\[\s*(\d+)")
_AXES: Final = re.compile(r"\b[JE]\d+\s*=")
_POSE: Final = re.compile(r"\bX\s*=")
_TABLE: Final = "table positions"
_FAMILY: Final = "P"


class TpMerging(MergeRules):
    whole_comments = ("!",)
    heads = (
        (re.compile(r"(?:CREATE|MODIFIED)\b"), RecordRule.NEWEST),
        (re.compile(r"LINE_COUNT\b"), RecordRule.COUNTED),
        (re.compile(r"(?:PROG_SIZE|MEMORY_SIZE|VERSION)\b"), RecordRule.GREATEST),
        (re.compile(r"(?:OWNER|FILE_NAME)\b"), RecordRule.SAVED_LAST),
        (re.compile(r"/PROG\b|[A-Z_]+(?=\s*=)"), RecordRule.ASK),
    )

    def renamed(self, base: str, ours: str, theirs: str) -> tuple[str, str, str]:
        """What the base counts is counted anew; other numbers (… 41:, 100:, 9999:) stay as they stand."""
        texts = (base, ours, theirs)
        numbers = [_numbers(text) for text in texts]
        most = max(map(len, numbers))
        counted = numbers[0] == list(range(1, len(numbers[0]) + 1))
        if counted and all(number <= most for some in numbers for number in some):
            return base, ours, theirs
        base, ours, theirs = (_with_counters(text, most if counted else 0) for text in texts)
        return base, ours, theirs

    def cut(self, text: str, known: Known) -> Cut:
        lines = lines_of(text)
        anew = COUNTER not in text
        pieces: list[Piece] = []
        rows: list[Row] = []
        section, at, indirect = "", 0, False
        while at < len(lines):
            line = lines[at]
            opened = _SECTION.match(line[0])
            section = opened[0] if opened is not None else section
            if section == "/POS" and opened is None:
                row, stop = _row(lines, at)
                if row is not None:
                    rows.append(row)
                elif rows:  # a line between two positions belongs to the first
                    before = rows[-1]
                    rows[-1] = replace(before, lines=(*before.lines, line[0]), ends=(*before.ends, line[1]))
                else:
                    pieces.insert(-1, self._piece(lines, at, "")[0])
                at = stop
            elif section == "/MN" and opened is None:
                stop = _last(lines, at)
                body = _body(line[0]) if anew else line[0]
                key = (body, line[1], "")
                piece = known.get(key) if stop == at else None
                if piece is None:
                    piece = self._instruction([(body, line[1]), *lines[at + 1 : stop + 1]])
                    indirect = indirect or any(_INDIRECT.search(one) for one in piece.lines)
                    if stop == at:
                        known[key] = piece
                pieces.append(piece)
                at = stop
            else:
                piece = self._piece(lines, at, "")[0]
                # Sections hold the two sides together.
                pieces.append(replace(piece, name=f"head {section}") if opened is not None else piece)
                if section == "/POS":
                    pieces.append(Piece((), (), "", _TABLE))
            at += 1
        tables = {_TABLE: rows} if any(piece.name == _TABLE for piece in pieces) else {}
        return Cut(pieces, tables, {}, frozenset({_FAMILY} if indirect else ()))

    def _instruction(self, lines: Sequence[tuple[str, str]]) -> Piece:
        uses: list[NumberedUse] = []

        def numbered(match: re.Match[str]) -> str:
            uses.append(NumberedUse(_FAMILY, int(match[1]), 1))
            return match[0][: match.start(1) - match.start()] + NUMBER

        texts = tuple(
            text if text.lstrip(COUNTER + " ").startswith("!") else _USED.sub(numbered, text)
            for text, _ in lines
        )
        bare = (_NUMBERED.sub("", text, count=1).replace(COUNTER, "") for text in texts)
        code = " ".join(" ".join(text.split()) for text in bare)
        silent = code.startswith("!") or code == ";"
        return Piece(
            texts, tuple(end for _, end in lines), self.silent(code) if silent else code, uses=tuple(uses)
        )

    def arguments(self, code: str) -> list[MoveArgument]:
        move = _MOVE.fullmatch(code)
        return [] if move is None else list(map(MoveArgument, _PARTS, move.groups("")))

    def rows(self, rows: Sequence[Choice]) -> Iterator[TableText]:
        for choice in rows:
            pair = (choice,) if isinstance(choice, Row) else choice
            for row, side in zip(pair, Side, strict=False):
                for text, end in () if row is None else zip(row.lines, row.ends, strict=True):
                    yield TableText(text, end, None if isinstance(choice, Row) else side, row)

    def joined_row(self, base: Row, ours: Row, theirs: Row) -> Row | None:
        """Angles of joints say where the arm goes whatever tool it holds."""
        rows = base, ours, theirs
        said = [tuple(bool(_AXES.search(text)) for text in row.lines) for row in rows]
        if any(_POSE.search(text) for row in rows for text in row.lines) or len(set(said)) > 1:
            return None
        parts = [
            [
                [text.split() for text, axes in zip(row.lines, said[0], strict=True) if axes is of]
                for row in rows
            ]
            for of in (True, False)
        ]
        axes, tool = (holds(*part) for part in parts)
        if not any(said[0]) or axes is None or tool is None:
            return None
        moved, held = ((ours, theirs)[side.value] for side in (axes, tool))
        lines = zip(said[0], moved.lines, held.lines, strict=True)
        return replace(held, lines=tuple(m if axes else h for axes, m, h in lines))

    def counted(self, piece: Piece, totals: Mapping[str, int], lines: int) -> str:
        return re.sub(r"\d+", str(lines), piece.lines[0], count=1)

    def split(self, line: str) -> tuple[str, str, str]:
        return "", line.rstrip(" \t"), line[len(line.rstrip(" \t")) :]


def _body(text: str) -> str:
    match = _NUMBERED.match(text)
    return text if match is None else COUNTER * (match.end() - 1) + text[match.end() :]


def _numbers(text: str) -> list[int]:
    return [int(one) for one in _ANY_NUMBER.findall(text.partition("\n/POS")[0])]


def _with_counters(text: str, most: int) -> str:
    """Counters for the numbers of its lines, up to the first that is beyond `most` and not the next one."""
    head, pos, rest = text.partition("\n/POS")
    count = 0

    def counter(match: re.Match[str]) -> str:
        nonlocal count
        if int(match[1]) > most and int(match[1]) != count + 1:
            count = -1
        if count < 0:
            return match[0]
        count += 1
        return COUNTER * (len(match[0]) - 1)

    return f"{_ANY_NUMBER.sub(counter, head)}{pos}{rest}"


def _last(lines: Sequence[tuple[str, str]], at: int) -> int:
    """The last line of the instruction that begins at `at`: a further line of it has no number."""
    stop = at
    while (
        not lines[stop][0].rstrip().endswith(";")
        and stop + 1 < len(lines)
        and lines[stop + 1][0].lstrip().startswith(":")
    ):
        stop += 1
    return stop


def _row(lines: Sequence[tuple[str, str]], at: int) -> tuple[Row | None, int]:
    """The position that begins at `at`, and its last line."""
    head = _HEAD.match(lines[at][0])
    stop = at
    while stop + 1 < len(lines) and "}" not in lines[stop][0] and not _HEAD.match(lines[stop + 1][0]):
        if _SECTION.match(lines[stop + 1][0]):
            break
        stop += 1
    if head is None:
        return None, at
    texts = [text for text, _ in lines[at : stop + 1]]
    texts[0] = texts[0][: head.start(1)] + NUMBER + texts[0][head.end(1) :]
    return Row(
        NumberedUse(_FAMILY, int(head[1]), 1), tuple(texts), tuple(end for _, end in lines[at : stop + 1])
    ), stop


MERGING = TpMerging()
