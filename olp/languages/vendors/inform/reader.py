"""A whole file: its jobs, each with header and instructions, and everything that is wrong with it."""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

from olp.core.diagnostic import Severity, Span
from olp.core.garbage_collection import no_garbage_collection
from olp.core.source import Source
from olp.ir import program as st
from olp.ir.block_structure import pair
from olp.ir.expressions import Element, FrameRef, Store, Taught, Variable
from olp.ir.points import PointBlock, PointKind, PointState, PointTable
from olp.languages.findings import Findings
from olp.languages.vendors.inform.instructions import InformInstructionReader, InformMoveLines, move_lines
from olp.languages.vendors.inform.positions import KINDS, ROW, InformPositionReader
from olp.languages.vendors.inform.values import STORES, number


def read_program(source: Source) -> st.Program:
    """The program in a text of one or more jobs. Never raises on bad text."""
    findings = Findings(source)
    routines: tuple[st.Routine, ...] = ()
    if is_readable(findings):
        with no_garbage_collection():
            routines = tuple(_routines(findings))
        check_names(findings, routines)
        check_text(findings)
    return st.Program("inform", source, routines, findings.result(), bytes(findings.kinds))


def _routines(findings: Findings) -> Iterator[st.Routine]:
    lines = findings.source.lines
    starts = [number for number, line in enumerate(lines) if line[:4] == "/JOB" and line.strip() == "/JOB"]
    first = starts[0] if starts else len(lines)
    early = next((number for number in range(first) if lines[number].strip()), None)
    if early is not None and _before_job(findings, early, first):
        starts.insert(0, early)
    moves = move_lines()
    for start, stop in zip(starts, [*starts[1:], len(lines)], strict=False):
        yield _routine(findings, moves, start, stop)


def _before_job(findings: Findings, start: int, stop: int) -> bool:
    """Tells what stands before the first /JOB. True when it is a job of its own."""
    lines = findings.source.lines
    is_job = any(line.startswith("//") for line in lines[start:stop])
    help = "add the line /JOB before this one" if is_job else "remove it, or move it behind NOP"
    findings.error("P015", "a job begins with /JOB", findings.whole_line(start + 1), help)
    if not is_job:
        for number in range(start, stop):
            findings.kinds[number] = st.LineKind.ERROR if lines[number].strip() else st.LineKind.BLANK
    return is_job


def _routine(findings: Findings, moves: InformMoveLines, start: int, stop: int) -> st.Routine:
    header = HeaderReader(findings, start, stop).read()
    instructions = InformInstructionReader(findings, moves, header.aliases)
    body = instructions.read(findings.source.lines[header.body : stop], header.body + 1)
    routine = st.Routine(
        header.name,
        start + 1,
        tuple(body),
        header.points,
        tuple(header.groups),
        header.comment,
        header.relative_to,
        header.locals,
        header.arguments,
        header.aliases,
        header.details,
        stop,
    )
    check_routine(findings, header, routine, instructions.markers)
    return routine


# --- Checks ---
# What can be wrong with a job whose lines are all fine: points, labels, blocks, ends, line ends.

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
        return _refuse(
            findings,
            "P001",
            "this is no job text but binary or UTF-16",
            "save it as plain text: Notepad calls it ANSI or UTF-8",
        )
    if not any(line.lstrip().startswith(_RECORDS) for line in source.lines if "/" in line):
        what = "the file is empty" if not source.raw.strip() else "this is no job: it has no header"
        return _refuse(findings, "P006", what, "a job begins with /JOB, //NAME, //POS and //INST")
    return True


def _refuse(findings: Findings, code: str, message: str, help: str) -> bool:
    findings.error(code, message, Span(0), help=help)
    for at, line in enumerate(findings.source.lines):
        findings.kinds[at] = st.LineKind.ERROR if line.strip() else st.LineKind.BLANK
    return False


def check_routine(
    findings: Findings, header: Header, routine: st.Routine, markers: Sequence[st.Statement]
) -> None:
    """Everything that holds for one job. `markers`: stand for broken lines that open or continue a block."""
    if _is_complete(findings, header, routine):
        _check_npos(findings, header)
        _check_points(findings, header, routine)
        flow = [one for one in routine.body if type(one) is not st.Move]
        if markers:
            flow = sorted([*flow, *markers], key=lambda one: one.line)
        findings.extend(pair(flow).problems)
        _check_lengths(findings, routine)
    _check_widths(findings, routine)


def _is_complete(findings: Findings, header: Header, routine: st.Routine) -> bool:
    last = findings.whole_line(routine.last_line)
    for section in ("NAME", "POS", "INST"):
        if section not in header.sections:
            cut = section == "INST"
            span = last if cut else findings.whole_line(routine.line)
            hint = "is the file cut off?" if cut else f"add //{section} to the header that begins here"
            findings.error("P007", f"the job has no //{section}", span, help=hint)
            if cut:
                return False
    first = next((one for one in routine.body if type(one) is not st.Comment), None)
    if type(first) is not st.Begin:
        span = findings.whole_line(first.line if first else routine.last_line)
        findings.error(
            "P008", "the instructions do not begin with NOP", span, help="add NOP before this line"
        )
    _check_end(findings, routine, last)
    return True


def _check_end(findings: Findings, routine: st.Routine, last: Span) -> None:
    ends = [one.line for one in routine.body if type(one) is st.End]
    if not ends:
        findings.error(
            "P009", "the job has no END", last, help="is the file cut off? add END as the last line"
        )
        return
    after = next((one for one in routine.body if one.line > ends[0] and type(one) is not st.Comment), None)
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


def _check_points(findings: Findings, header: Header, routine: st.Routine) -> None:
    blocks = routine.points.blocks
    known = {store: blocks[store, True].rows if (store, True) in blocks else {} for store in _FAMILY}
    robot = known[Store.ROBOT]
    missing: list[tuple[int, Taught]] = []
    for statement in routine.body:
        targets: Iterable[object]
        if type(statement) is st.Move or type(statement) is st.Reference:
            targets = statement.targets
            if statement.parts:
                targets = [*targets, *(t for part in statement.parts for t in part.targets)]
        elif type(statement) is st.Assign:
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


def _check_lengths(findings: Findings, routine: st.Routine) -> None:
    """Labels and comments beyond what controllers show."""
    for statement in routine.body:
        if type(statement) is st.Move:
            text = statement.comment
        elif type(statement) is st.Comment:
            text = statement.text
        elif type(statement) is st.Label and len(statement.name) > _LABEL_LENGTH:
            _too_long(findings, "P032", "label", statement.line, _LABEL_LENGTH, "older controllers refuse it")
            continue
        else:
            continue
        if len(text) > _COMMENT_LENGTH:
            _too_long(findings, "P037", "comment", statement.line, _COMMENT_LENGTH, "the pendant cuts it off")


def _too_long(findings: Findings, code: str, what: str, line: int, most: int, help: str) -> None:
    message = f"a {what} of more than {most} characters"
    findings.once(Severity.INFO, code, "", message, findings.whole_line(line), help)


def _check_widths(findings: Findings, routine: st.Routine) -> None:
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


def check_names(findings: Findings, routines: Sequence[st.Routine]) -> None:
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


# --- Header ---
# A job's header: everything from /JOB to the first instruction, record by record.

_RECORD = re.compile(r"\s*(/{1,4})([A-Z]+\d?)(?:\s+(.*?))?\s*")
_SYMBOL = re.compile(r"\s*(L?)(BP|EX|[BIDRSP])(\d{1,9})\s+(.*?)\s*", re.ASCII)
_COUNT = re.compile(r"\d{1,9}", re.ASCII)
_MECHANISM = re.compile(r"(?:RB|BS|ST)[0-9]{1,2}")

# The order of every list of counts or types in a header.
_ORDER: Final = ("B", "I", "D", "R", "S", "P", "BP", "EX")
_SECTIONS: Final = ("NAME", "POS", "ALIAS", "ARGINFO", "INST")
_NAME_LENGTH = 32


@dataclass(slots=True)
class Header:
    """What the header says. `body`: index of the first line after it."""

    name: str = ""
    comment: str = ""
    points: PointTable = field(default_factory=PointTable)
    groups: list[st.ControlGroup] = field(default_factory=list)
    relative_to: FrameRef | None = None
    locals: dict[Store, int] = field(default_factory=dict)
    arguments: tuple[Store | None, ...] = ()
    aliases: dict[str, Variable] = field(default_factory=dict)
    details: dict[str, str] = field(default_factory=dict)
    sections: set[str] = field(default_factory=set)
    body: int = 0
    npos: tuple[int, ...] | None = None
    npos_line: int = 0
    broken_rows: set[tuple[Store, bool, int]] = field(default_factory=set)


class HeaderReader:
    """Reads one header. Lines are indices from 0 in here, numbers from 1 in findings."""

    def __init__(self, findings: Findings, start: int, stop: int) -> None:
        self.findings = findings
        self.lines = findings.source.lines
        self.index = start
        self.stop = stop
        self.section = ""
        self.header = Header()
        self.positions = InformPositionReader(findings)

    def read(self) -> Header:
        while self.index < self.stop:
            line = self.lines[self.index]
            match = _RECORD.fullmatch(line)
            if match is not None and self._take(match[1], match[2], match[3] or ""):
                if not self.findings.kinds[self.index]:
                    self.findings.kinds[self.index] = st.LineKind.RECORD
                self.index += 1
            elif self._begins_body(line, match):
                break
            elif not self._positions_too_early(match, line):
                self._other(line, match)
        header = self.header
        header.body = self.index
        header.points = self.positions.table()
        header.broken_rows = self.positions.broken
        header.npos, header.npos_line = self.positions.npos, self.positions.npos_line
        return header

    def _begins_body(self, line: str, match: re.Match[str] | None) -> bool:
        if match is None:
            return bool(line.strip()) and (self.section == "INST" or line.strip() == "NOP")
        return self.section == "INST" and len(match[1]) == 2

    # --- records ----------------------------------------------------------------------------------------

    def _take(self, slashes: str, word: str, value: str) -> bool:
        """Takes a record. False when it is none that may stand here."""
        if slashes == "/":
            return word == "JOB" and not self.section
        if slashes == "//":
            return self._open(word, value)
        if self.section == "POS":
            if word == "NPOS":
                self.header.details[word] = value
            return self.positions.record(word, value, self.index + 1)
        return self._detail(word, value)

    def _open(self, word: str, value: str) -> bool:
        if word not in _SECTIONS:
            return False
        if word in self.header.sections:
            self._error(
                "P016", f"//{word} stands twice in one job", "remove one, or begin a new job with /JOB"
            )
        self.section = word
        self.header.sections.add(word)
        if word == "NAME":
            self._name(value)
        return True

    def _name(self, value: str) -> None:
        self.header.name = value
        if not value:
            self._error("P016", "//NAME without a name", "a name of up to 32 letters, digits or signs")
        elif len(value) > _NAME_LENGTH:
            message = f"a job name of {len(value)} characters; controllers take {_NAME_LENGTH}"
            self.findings.warning("P038", message, self._span(), help="8 on controllers before the DX100")

    def _detail(self, word: str, value: str) -> bool:
        readers: dict[str, Callable[[str], None]] = {
            "COMM": self._comm,
            "FRAME": self._frame,
            "LVARS": self._locals,
            "GVARS": self._ignore,
            "ARGTYPE": self._argument_types,
            "COMMENT": self._free_text,
        }
        if word[:-1] == "GROUP":
            self._group(value)
        elif word in readers:
            readers[word](value)
        elif word not in ("FOLDERNAME", "DATE", "ATTR"):
            return False
        if word not in ("COMM", "COMMENT", "LVARS", "GVARS", "ARGTYPE"):
            self.header.details[word] = value
        return True

    def _comm(self, value: str) -> None:
        self.header.comment = value

    def _ignore(self, _: str) -> None:
        """///GVARS counts the rows that follow it; the rows themselves tell."""

    def _frame(self, value: str) -> None:
        word, _, number_text = value.partition(" ")
        number_text = number_text.strip()
        if word in ("BASE", "ROBOT", "PULSE", "TOOL"):
            self.header.relative_to = FrameRef(word.lower())
        elif word == "USER" and _COUNT.fullmatch(number_text):
            self.header.relative_to = FrameRef("user", number(number_text))
        elif _COUNT.fullmatch(word):
            self.header.relative_to = FrameRef("user", number(word))
        else:
            self._error("P011", f"no coordinate system '{value[:40]}'", "BASE, ROBOT or USER 1")

    def _locals(self, value: str) -> None:
        counts = [part.strip() for part in value.split(",")]
        if not all(_COUNT.fullmatch(part) for part in counts):
            self._error("P011", "///LVARS needs eight numbers with commas", "///LVARS 0,0,1,0,0,0,0,0")
        elif self.section == "INST":
            pairs = zip(_ORDER, counts, strict=False)
            self.header.locals = {STORES[kind]: int(part) for kind, part in pairs if int(part)}

    def _argument_types(self, value: str) -> None:
        kinds = [part.strip() for part in value.split(",")]
        unknown = [kind for kind in kinds if kind and kind not in STORES]
        if unknown:
            self._error("P011", f"no type '{unknown[0][:40]}'", "B, I, D, R, S, P, BP or EX")
            return
        types = [STORES.get(kind) for kind in kinds]
        while types and types[-1] is None:
            types.pop()
        self.header.arguments = tuple(types)
        self.header.details["ARGTYPE"] = value

    def _group(self, value: str) -> None:
        mechanisms = [part.strip() for part in value.split(",")]
        wrong = [part for part in mechanisms if _MECHANISM.fullmatch(part) is None]
        if wrong:
            self._error("P011", f"no control group '{wrong[0][:40]}'", "RB1, BS1 or ST1, with commas")
            return
        self.header.groups.append(st.ControlGroup(tuple(mechanisms)))

    def _free_text(self, _: str) -> None:
        """///COMMENT announces rows of any text, one per argument, up to the next `//` record."""
        rows = []
        while self.index + 1 < self.stop and not self.lines[self.index + 1].startswith("//"):
            self.findings.kinds[self.index] = self.findings.kinds[self.index] or st.LineKind.RECORD
            self.index += 1
            rows.append(self.lines[self.index])
            self.findings.kinds[self.index] = st.LineKind.FREE_TEXT
        self.header.details["COMMENT"] = "\n".join(rows)

    def _positions_too_early(self, match: re.Match[str] | None, line: str) -> bool:
        """Rows or their records where //POS is missing: told once, then read as if it stood there."""
        if self.section not in ("", "NAME"):
            return False
        row = match is None and ROW.match(line)
        if not row and (
            match is None or match[2] not in ("NPOS", "POSTYPE", "TOOL", "USER", "RCONF", *KINDS)
        ):
            return False
        self._error("P014", "positions begin with //POS", "the line //POS before this one")
        self.section = "POS"
        self.header.sections.add("POS")
        return True

    # --- everything else --------------------------------------------------------------------------------

    def _other(self, line: str, match: re.Match[str] | None) -> None:
        if self.section == "POS" and not line.lstrip().startswith("/"):
            self._rows()
            return
        if self.section == "ALIAS" and match is None and self._symbol(line):
            pass
        elif line.lstrip().startswith("'"):
            self.findings.kinds[self.index] = st.LineKind.COMMENT
            message = "a comment in the header, which the controller refuses"
            self.findings.once(
                Severity.WARNING, "P033", "header", message, self._span(), "move it behind NOP"
            )
        elif line.strip():
            self._unknown(line, match)
        self.index += 1

    def _rows(self) -> None:
        start = self.index
        while self.index < self.stop:
            line = self.lines[self.index]
            if line[:1] != "C" and (line.lstrip().startswith("/") or line.strip() == "NOP"):
                break
            self.index += 1
        self.positions.rows(self.lines[start : self.index], start + 1)

    def _symbol(self, line: str) -> bool:
        match = _SYMBOL.fullmatch(line)
        if match is None or not match[4]:
            return False
        local, kind, digits, name = match.groups()
        index = number(str(int(digits)))
        if name in self.header.aliases:
            message = f"the name {name[:40]} stands twice in //ALIAS; the first one counts"
            self.findings.warning("P042", message, self._span(), help="give each variable its own name")
        self.header.aliases.setdefault(name, Variable(STORES[kind], index, bool(local), name))
        self.findings.kinds[self.index] = st.LineKind.RECORD
        return True

    def _unknown(self, line: str, match: re.Match[str] | None) -> None:
        if match is not None:
            place = f"//{self.section}" if self.section else "the header"
            self._error("P015", f"no record {match[1]}{match[2]} is known in {place}", _records(self.section))
        elif ROW.match(line):
            self._error("P014", "a position row outside //POS", "it below //POS")
        elif self.section == "ALIAS":
            self._error("P015", "this is no row of //ALIAS", "a variable and its name, such as LD000 SPEED")
        else:
            self._error("P015", "this is no header record", _records(self.section))

    def _error(self, code: str, message: str, wanted: str) -> None:
        self.findings.error(code, message, self._span(), help=f"expected {wanted}" if wanted else "")

    def _span(self) -> Span:
        line = self.lines[self.index]
        start = len(line) - len(line.lstrip()) + 1
        return Span(self.index + 1, start, max(len(line.rstrip()) + 1, start + 1))


def _records(section: str) -> str:
    return {
        "": "//NAME",
        "NAME": "///FOLDERNAME or //POS",
        "POS": "///NPOS, ///TOOL, ///USER, ///POSTYPE, ///PULSE, ///RECTAN, ///ANGLE, ///RCONF or ///LIMIT",
        "ALIAS": "///GVARS, ///LVARS or a row such as LD000 SPEED",
        "ARGINFO": "///ARGTYPE or ///COMMENT",
        "INST": "///DATE, ///COMM, ///ATTR, ////FRAME, ///GROUP1, ///LVARS or NOP",
    }[section]
