"""What can be wrong with a job whose lines are all fine: points, labels, blocks, ends, line ends."""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Iterable, Sequence

from olp.core.diagnostic import Severity, Span
from olp.ir.block_structure import pair
from olp.ir.expressions import Element, Store, Taught
from olp.ir.points import PointBlock, PointKind, PointState
from olp.ir.program import Assign, Begin, Comment, End, Label, LineKind, Move, Reference, Routine, Statement
from olp.languages.findings import Findings
from olp.languages.vendors.inform.header import Header

_FAMILY = {Store.ROBOT: "C", Store.BASE: "BC", Store.STATION: "EC"}
_POSITION = re.compile(r"(?<![A-Z])(BC|EC|C|E)([0-9]{1,9})(?![0-9])")
_LABEL_LENGTH = 8
_COMMENT_LENGTH = 32
_MOST_STATION_AXES, _ARM_AXES, _POSE_VALUES = 3, 6, 6
_RECORDS = ("/JOB", "//NAME", "//POS", "//INST")


def is_readable(findings: Findings) -> bool:
    """Whether the file is text with at least one record of a job; if not, one error says so."""
    source = findings.source
    if source.encoding.startswith("utf-16") or b"\0" in source.raw:
        return _refuse(findings, "P001", "this is no job text but binary or UTF-16", "save it as plain text")
    if not any(line.lstrip().startswith(_RECORDS) for line in source.lines if "/" in line):
        what = "the file is empty" if not source.raw.strip() else "this is no job: it has no header"
        return _refuse(findings, "P006", what, "a job begins with /JOB, //NAME, //POS and //INST")
    return True


def _refuse(findings: Findings, code: str, message: str, help: str) -> bool:
    findings.error(code, message, Span(0), help=help)
    for number, line in enumerate(findings.source.lines):
        findings.kinds[number] = LineKind.ERROR if line.strip() else LineKind.BLANK
    return False


def check_routine(findings: Findings, header: Header, routine: Routine, markers: Sequence[Statement]) -> None:
    """Everything that holds for one job. `markers`: stand for broken lines that open or continue a block."""
    if _is_complete(findings, header, routine):
        _check_npos(findings, header)
        _check_points(findings, header, routine)
        flow = [one for one in routine.body if type(one) is not Move]
        if markers:
            flow = sorted([*flow, *markers], key=lambda one: one.line)
        findings.extend(pair(flow).problems)
        _check_lengths(findings, routine)
    _check_widths(findings, routine)


def _is_complete(findings: Findings, header: Header, routine: Routine) -> bool:
    last = findings.whole_line(routine.last_line)
    for section in ("NAME", "POS", "INST"):
        if section not in header.sections:
            cut = section == "INST"
            span = last if cut else findings.whole_line(routine.line)
            hint = "is the file cut off?" if cut else f"add //{section} to the header that begins here"
            findings.error("P007", f"the job has no //{section}", span, help=hint)
            if cut:
                return False
    first = next((one for one in routine.body if type(one) is not Comment), None)
    if type(first) is not Begin:
        span = findings.whole_line(first.line if first else routine.last_line)
        findings.error(
            "P008", "the instructions do not begin with NOP", span, help="add NOP before this line"
        )
    _check_end(findings, routine, last)
    return True


def _check_end(findings: Findings, routine: Routine, last: Span) -> None:
    ends = [one.line for one in routine.body if type(one) is End]
    if not ends:
        findings.error(
            "P009", "the job has no END", last, help="is the file cut off? add END as the last line"
        )
        return
    after = next((one for one in routine.body if one.line > ends[0] and type(one) is not Comment), None)
    if after is not None:
        message = "an instruction behind END is never executed"
        span = findings.whole_line(after.line)
        findings.error("P022", message, span, help=f"END stands in line {ends[0]}")


def _check_npos(findings: Findings, header: Header) -> None:
    if header.npos is None or header.broken_rows:
        return
    order = [(s, t) for t in (True, False) for s in (Store.ROBOT, Store.BASE, Store.STATION)]
    counts = tuple(len(header.points.blocks.get(key, ())) for key in order)
    if len(header.npos) == 4:  # ERC: robot and external axes, taught and variable
        counts = (counts[0], counts[1] + counts[2], counts[3], counts[4] + counts[5])
    if header.npos == counts:
        return
    text = findings.source.line(header.npos_line)
    shown = ",".join(map(str, counts))
    findings.error(
        "P017",
        f"///NPOS {','.join(map(str, header.npos))} does not fit the rows",
        Span(header.npos_line, text.find("NPOS") + 6, len(text.rstrip()) + 1),
        help=f"counted {shown}; is the file cut off?",
    )


def _check_points(findings: Findings, header: Header, routine: Routine) -> None:
    blocks = routine.points.blocks
    known = {store: blocks[store, True].rows if (store, True) in blocks else {} for store in _FAMILY}
    robot = known[Store.ROBOT]
    missing: list[tuple[int, Taught]] = []
    for statement in routine.body:
        targets: Iterable[object]
        if type(statement) is Move or type(statement) is Reference:
            targets = statement.targets
            if statement.parts:
                targets = [*targets, *(t for part in statement.parts for t in part.targets)]
        elif type(statement) is Assign:
            value = statement.value
            targets = (value.variable if type(value) is Element else value,)
        else:
            continue
        for target in targets:
            if type(target) is not Taught:
                continue
            rows = robot if target.store is Store.ROBOT else known[target.store]
            if target.number not in rows:
                missing.append((statement.line, target))
    numbers = {store: sorted(rows) for store, rows in known.items()} if missing else {}
    for line, target in missing:
        if (target.store, True, target.number) not in header.broken_rows:
            _report_missing(findings, line, target, numbers[target.store])


def _report_missing(findings: Findings, line: int, target: Taught, numbers: Sequence[int]) -> None:
    family = _FAMILY[target.store]
    place = bisect_left(numbers, target.number)
    near = numbers[max(place - 1, 0) : place + 1]
    nearest = min(near, key=lambda number: abs(number - target.number), default=None)
    help = "the job has none" if nearest is None else f"the nearest one is {family}{nearest:05}"
    message = f"there is no position {family}{target.number:05}"
    findings.error("P030", message, _span_of(findings, line, family, target.number), help=help)


def _span_of(findings: Findings, line: int, family: str, number: int) -> Span:
    """Where a position is named in the line; the whole line when it is not found."""
    for match in _POSITION.finditer(findings.source.line(line)):
        if match[1] in (family, "E") and int(match[2]) == number:
            return Span(line, match.start() + 1, match.end() + 1)
    return findings.whole_line(line)


def _check_lengths(findings: Findings, routine: Routine) -> None:
    """Labels and comments beyond what controllers show."""
    for statement in routine.body:
        if type(statement) is Move:
            text = statement.comment
        elif type(statement) is Comment:
            text = statement.text
        elif type(statement) is Label and len(statement.name) > _LABEL_LENGTH:
            _too_long(findings, "P032", "label", statement.line, _LABEL_LENGTH, "older controllers refuse it")
            continue
        else:
            continue
        if len(text) > _COMMENT_LENGTH:
            _too_long(findings, "P037", "comment", statement.line, _COMMENT_LENGTH, "the pendant cuts it off")


def _too_long(findings: Findings, code: str, what: str, line: int, most: int, help: str) -> None:
    message = f"a {what} of more than {most} characters"
    findings.once(Severity.INFO, code, "", message, findings.whole_line(line), help)


def _check_widths(findings: Findings, routine: Routine) -> None:
    """Rows of one family have one width: another one is a row that lost or won a value."""
    import numpy as np

    for (store, _), block in routine.points.blocks.items():
        # Where several groups share the C points, a station's rows are shorter than a robot's.
        mixed = store is Store.ROBOT and len(routine.groups) > 1
        if len(block) < 2 or not np.isnan(block.values[:, -1]).any():
            if store is Store.ROBOT and not mixed and block.values.shape[1] < _POSE_VALUES:
                _check_poses(findings, routine.points.states, block)
            continue
        lines = findings.source.lines
        widths = np.array([lines[line - 1].count(",") + 1 for line in block.lines.tolist()])
        for part in (widths < 6, widths >= 6) if mixed else (widths > 0,):
            _check_equal(findings, block.lines[part].tolist(), widths[part].tolist())


def _check_poses(findings: Findings, states: Sequence[PointState], block: PointBlock) -> None:
    """Coordinates that are all too short to be a pose; joint values may be few, of a small arm."""
    for line, state in zip(block.lines.tolist(), block.state.tolist(), strict=True):
        if states[state].kind is PointKind.POSE:
            message = f"{block.values.shape[1]} values, where a pose has {_POSE_VALUES}"
            text = findings.source.line(line)
            span = Span(line, text.find("=") + 2, len(text.rstrip()) + 1)
            findings.error("P012", message, span, help="expected X, Y, Z in mm and Rx, Ry, Rz in degrees")


def _check_equal(findings: Findings, lines: list[int], widths: list[int]) -> None:
    usual = max(sorted(set(widths), reverse=True), key=widths.count, default=0)
    for line, width in zip(lines, widths, strict=True):
        if width == usual:
            continue
        text = findings.source.line(line)
        span = Span(line, text.find("=") + 2, len(text.rstrip()) + 1)
        message = f"{width} values, where the other rows have {usual}"
        if width <= _MOST_STATION_AXES and usual >= _ARM_AXES:
            # Generators write a station's positions among the robot's; nothing is lost by keeping them.
            help = f"kept as a position of {width} axes; a station's positions are called EC, a robot's have {usual}"
            findings.warning("P012", message, span, help=help)
        else:
            findings.error("P012", message, span, help=f"expected {usual} numbers with commas")


def check_names(findings: Findings, routines: Sequence[Routine]) -> None:
    """Two jobs of one name: CALL can mean the first one only."""
    first: dict[str, int] = {}
    for routine in routines:
        if routine.name and first.setdefault(routine.name, routine.line) != routine.line:
            message = f"a second job called {routine.name[:40]}"
            help = f"the first one begins in line {first[routine.name]}; calls go to it"
            findings.warning("P043", message, findings.whole_line(routine.line), help=help)


def check_text(findings: Findings) -> None:
    """Tabs and line ends, told once for the file. Controllers themselves indent with blanks and a tab."""
    source = findings.source
    lines = enumerate(source.lines, 1) if b"\t" in source.raw else ()
    place = next(((n, line) for n, line in lines if "\t" in line.strip()), None)
    if place is not None:
        number, line = place
        column = line.index("\t", len(line) - len(line.lstrip())) + 1
        message, span = "a tab between words", Span(number, column, column + 1)
        findings.info("P034", message, span, help="controllers write blanks")
    if source.raw.count(b"\r\n") != source.raw.count(b"\n") or source.raw.count(b"\r") != source.raw.count(
        b"\r\n"
    ):
        findings.info(
            "P035",
            "not all lines end in CR LF, which the controller insists on",
            Span(0),
            help="olp writes CR LF",
        )
