"""Writes predicted times into a program as comments, and removes them again without a trace.

Every comment carries a mark and a seal, three characters computed from its text: `'olp 0.533s 592mm/s2 ~K3Q`. Only
a comment with the right seal is ever replaced or removed, so a comment that a user wrote or changed stays. All
other bytes of the file stay unchanged.

Codes: A001 comments that start like annotations and are kept, A002 a comment that the controller would reject, A003
a text that cannot be annotated, A004 the assumptions of the times.
"""

from __future__ import annotations

import math
import os
import re
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from olp.core.diagnostic import Diagnostic, OlpError, Span, error, info, raise_errors
from olp.core.source import Source, decode
from olp.ir.program import Begin, Program

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from olp.languages.templating import Renderer
    from olp.languages.vendor import Vendor
    from olp.runtime.plan import CallSpan
    from olp.timing.result import Timing


MARK: Final = "olp "
_MARK: Final = MARK.encode("ascii")
SEAL_LENGTH: Final = 3
_LETTERS = "0123456789ABCDEFGHJKMNPQRSTVWXYZ"  # without I, L, O and U, which are misread
_LINE = re.compile(rb"[^\r\n]*(?:\r\n|\n|\r)|[^\r\n]+")
_END = re.compile(rb"[\r\n]*\Z")


class Annotated(NamedTuple):
    """The annotated text, the number of comments written into it and the number of older ones removed."""

    source: Source
    written: int
    removed: int
    diagnostics: tuple[Diagnostic, ...] = ()


def annotate(program: Program, timing: Timing, template: str | os.PathLike[str] | None = None) -> Annotated:
    """The program's text with a comment above each timed statement; its old annotations are replaced.

    `timing`: of a plan of this program. `template`: a jinja2 file instead of the vendor's own. Raises OlpError for
    errors of the program or its timing, for a template that fails (J…) or whose comments the controller rejects
    (A002), and for a text that cannot carry comments (A003).
    """
    from olp.languages.templating import given, shipped
    from olp.languages.vendor import find_vendor

    found = [one.at(program.path) for one in (*program.diagnostics, *timing.diagnostics)]
    raise_errors(list(dict.fromkeys(found)))
    vendor = find_vendor(program.vendor)
    _refuse_wide(program.source)
    renderer = shipped(f"{vendor.name}_annotation") if template is None else given(template)
    comments = _comments(rows(program, timing), renderer, vendor, _places(program))
    pieces = _LINE.findall(program.source.raw)
    result, removed, end = [], 0, b""
    for number, piece in enumerate(pieces, 1):
        # The end of the line before is the only one that can be neither missing nor half of another.
        result += [comment + end for comment in comments.get(number, ())]
        if _is_ours(piece, vendor):
            removed += 1
            continue
        result.append(piece)
        end = piece[_END.search(piece).start() :]  # type: ignore[union-attr]
    written = len(result) - (len(pieces) - removed)
    source = decode(b"".join(result), program.source.path, program.source.encoding)
    return Annotated(source, written, removed, _foreign(program.source, vendor))


def remove(source: Source, vendor: str) -> Annotated:
    """The text without the annotations that `annotate` wrote. Raises OlpError (A003, P003)."""
    from olp.languages.vendor import find_vendor

    language = find_vendor(vendor)
    _refuse_wide(source)
    pieces = _LINE.findall(source.raw)
    kept = [piece for piece in pieces if not _is_ours(piece, language)]
    plain = decode(b"".join(kept), source.path, source.encoding)
    return Annotated(plain, 0, len(pieces) - len(kept), _foreign(source, language))


def seal(text: str) -> str:
    """Checksum of `text` (ASCII) as three characters."""
    value = zlib.crc32(text.encode("ascii"))
    return "".join(_LETTERS[(value >> shift) & 31] for shift in (0, 5, 10))


def room(vendor: Vendor) -> int:
    """Number of characters that a template can use for an annotation. The prefix counts as one of the comment's."""
    return vendor.comment_length - len(vendor.comment_prefix) - len(MARK) - len(" ~") - SEAL_LENGTH


def _marked(piece: bytes, vendor: Vendor) -> bytes | None:
    """The text after olp's mark, None in a line without it."""
    text = vendor.comment_of(piece) if _MARK in piece else None
    return text[len(_MARK) :] if text is not None and text.startswith(_MARK) else None


def _is_ours(piece: bytes, vendor: Vendor) -> bool:
    said = _marked(piece, vendor)
    if said is None:
        return False
    # A controller or an editor may have added blanks at the end.
    text, separator, found = said.rstrip(b" \t\r\n").rpartition(b" ~")
    return bool(separator) and text.isascii() and found == seal(text.decode("ascii")).encode("ascii")


def _foreign(source: Source, vendor: Vendor) -> tuple[Diagnostic, ...]:
    """A note about comments with olp's mark but a wrong seal, if there are any."""
    if _MARK not in source.raw:
        return ()
    lines = enumerate(_LINE.findall(source.raw), 1)
    found = [
        number
        for number, piece in lines
        if _marked(piece, vendor) is not None and not _is_ours(piece, vendor)
    ]
    if not found:
        return ()
    text = source.line(found[0])
    count = "this comment starts" if len(found) == 1 else f"{len(found)} comments start"
    return (
        info(
            "A001",
            f"{count} like an annotation of olp but was written or changed by someone else: kept",
            Span(found[0], 1, len(text) + 1),
            file=source.path,
            source_line=text,
        ),
    )


def _refuse_wide(source: Source) -> None:
    if source.encoding.startswith(("utf-16", "utf-32")):
        raise OlpError(
            error(
                "A003",
                f"a file in {source.encoding} cannot be annotated",
                file=source.path,
                help="no controller reads it; save it as cp1252, Shift-JIS or UTF-8",
            )
        )
    if source.raw.startswith(b"\x1f\x8b"):
        raise OlpError(
            error(
                "A003",
                "a compressed file cannot be annotated",
                file=source.path,
                help="export it as text (PolyScope: .script)",
            )
        )


def _places(program: Program) -> dict[int, int]:
    """Line of the first statement of each routine with a head -> the line after it."""
    return {
        statement.line: statement.line + 1
        for routine in program.routines
        for statement in routine.body
        if isinstance(statement, Begin)
    }


def _comments(
    rows: list[AnnotationRow], renderer: Renderer, vendor: Vendor, begins: Mapping[int, int]
) -> dict[int, list[bytes]]:
    """The comments above each line, in bytes, sealed."""
    comments: dict[int, list[bytes]] = {}
    problems: list[Diagnostic] = []
    available = room(vendor)
    for row in rows:
        text = renderer.render({"row": row, "room": available}).strip("\r\n")
        if not text:
            continue
        wrong = _objection(text, available)
        if wrong:
            problems.append(
                error("A002", f"the comment for line {row.line} {wrong}: {text!r}", file=renderer.path)
            )
            continue
        sealed = f"{vendor.comment_prefix}{MARK}{text} ~{seal(text)}{vendor.comment_suffix}".encode("ascii")
        comments.setdefault(begins.get(row.line, row.line), []).append(sealed)
    if problems:
        # One template, one mistake: a hundred thousand lines of the same would bury it.
        raise OlpError(*problems[:10])
    return comments


def _objection(text: str, available: int) -> str:
    if len(text) > available:
        return f"is {len(text)} characters long, {available} fit"
    if "\n" in text or "\r" in text:
        return "is more than one line"
    if not (text.isascii() and text.isprintable()) or text != text.strip():
        return "is not printable ASCII without blanks at its ends"
    return ""


# --- Annotation rows ---
# What there is to say about each line: its executions counted and summed, and what the jobs it calls took.

_AVERAGED = ("distance_mm", "speed_mm_s", "reached_mm_s", "accel_mm_s2")


@dataclass(frozen=True, slots=True)
class AnnotationRow:
    """One line as a template gets it; templates/inform_annotation.j2 lists the kinds.

    Numbers other than `seconds` are the mean of the `count` executions, nan where they do not apply.
    """

    line: int
    kind: str
    statement: str
    count: int
    seconds: float  # [s], all executions together
    end_s: float  # [s] from the program's start to the end of the last execution
    distance_mm: float = math.nan
    speed_mm_s: float = math.nan  # as programmed
    reached_mm_s: float = math.nan  # the highest
    accel_mm_s2: float = math.nan
    limited_by: str = ""
    motion_s: float = math.nan  # [s], of the total only, like the next two
    wait_s: float = math.nan
    io_s: float = math.nan

    @property
    def mean_s(self) -> float:
        """Time [s] of one execution."""
        return self.seconds / self.count if self.count else 0.0


def rows(program: Program, timing: Timing) -> list[AnnotationRow]:
    """The rows of `program`'s file in the order of its lines, the total first."""
    found = [*_own(program, timing), *_calls(program, timing)]
    found.sort(key=lambda row: row.line)
    return [*_total(program, timing), *found]


def _total(program: Program, timing: Timing) -> Iterator[AnnotationRow]:
    body = program.routines[0].body if program.routines else ()
    begin = next((statement for statement in body if isinstance(statement, Begin)), None)
    if begin is not None:
        text = program.source.line(begin.line).strip()
        total = timing.total_s
        yield AnnotationRow(
            begin.line,
            "total",
            text,
            1,
            total,
            total,
            motion_s=timing.motion_s,
            wait_s=timing.wait_s,
            io_s=timing.io_s,
        )


def _own(program: Program, timing: Timing) -> Iterator[AnnotationRow]:
    """One row per executed line of this file that takes time or moves."""
    plan = timing.plan
    here = [index for index, source in enumerate(plan.sources) if source.path == program.source.path]
    steps = np.nonzero(np.isin(plan.source, here))[0]
    lines, first, group, counts = np.unique(
        plan.line[steps], return_index=True, return_inverse=True, return_counts=True
    )
    seconds = np.bincount(group, timing.duration_s[steps], len(lines))
    ends = np.zeros(len(lines))
    np.maximum.at(ends, group, timing.end_s[steps])
    means = [_mean(getattr(timing, name)[steps], group, len(lines)) for name in _AVERAGED]
    columns = zip(
        lines.tolist(),
        steps[first].tolist(),
        counts.tolist(),
        seconds.tolist(),
        ends.tolist(),
        *(mean.tolist() for mean in means),
        strict=True,
    )
    for line, step, count, total, end, *numbers in columns:
        text = program.source.line(line).strip()
        distance, speed, reached, acceleration = numbers
        yield AnnotationRow(
            line,
            timing.kind[step],
            text,
            count,
            total,
            end,
            distance,
            speed,
            reached,
            acceleration,
            timing.limited_by[step],
        )


def _mean(values: NDArray[np.float64], group: NDArray[np.intp], size: int) -> NDArray[np.float64]:
    """The mean of each group's known values, nan for a group without any."""
    is_known = ~np.isnan(values)
    count = np.bincount(group[is_known], minlength=size)
    total = np.bincount(group[is_known], values[is_known], size)
    with np.errstate(invalid="ignore"):
        mean: NDArray[np.float64] = np.where(count > 0, total / count, np.nan)
    return mean


def _calls(program: Program, timing: Timing) -> Iterator[AnnotationRow]:
    """One row per call of the main routine, with the time of all its executions in other files."""
    plan = timing.plan
    if not plan.sources or plan.sources[0].path != program.source.path:
        return
    spent = np.concatenate(
        [[0.0], np.cumsum(np.where(plan.source > 0, np.nan_to_num(timing.duration_s), 0.0))]
    )
    ends = np.concatenate([[0.0], timing.end_s])
    spans: dict[int, list[CallSpan]] = {line: [] for line in sorted({span.line for span in plan.calls})}
    for span in plan.calls:
        spans[span.line].append(span)
    for line, found in spans.items():
        seconds = sum(float(spent[span.stop] - spent[span.start]) for span in found)
        if seconds > 0.0:
            text = program.source.line(line).strip()
            yield AnnotationRow(line, "call", text, len(found), seconds, float(ends[found[-1].stop]))
