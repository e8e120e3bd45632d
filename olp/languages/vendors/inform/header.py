"""A job's header: everything from /JOB to the first instruction, record by record."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from olp.core.diagnostic import Severity, Span
from olp.ir.expressions import FrameRef, Store, Variable
from olp.ir.points import PointTable
from olp.ir.program import ControlGroup, LineKind
from olp.languages.findings import Findings
from olp.languages.vendors.inform.positions import KINDS, ROW, InformPositionReader
from olp.languages.vendors.inform.values import STORES, number

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
    groups: list[ControlGroup] = field(default_factory=list)
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
                    self.findings.kinds[self.index] = LineKind.RECORD
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
        self.header.groups.append(ControlGroup(tuple(mechanisms)))

    def _free_text(self, _: str) -> None:
        """///COMMENT announces rows of any text, one per argument, up to the next `//` record."""
        rows = []
        while self.index + 1 < self.stop and not self.lines[self.index + 1].startswith("//"):
            self.findings.kinds[self.index] = self.findings.kinds[self.index] or LineKind.RECORD
            self.index += 1
            rows.append(self.lines[self.index])
            self.findings.kinds[self.index] = LineKind.FREE_TEXT
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
            self.findings.kinds[self.index] = LineKind.COMMENT
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
        self.findings.kinds[self.index] = LineKind.RECORD
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
