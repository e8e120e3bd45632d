"""A whole file: its routines, the lists that belong to it, and everything that is wrong with them."""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import replace

from olp.core.diagnostic import Diagnostic, Severity
from olp.core.garbage_collection import no_garbage_collection
from olp.core.source import Source
from olp.ir.expressions import Unknown
from olp.ir.points import PointTable
from olp.ir.program import Comment, Declare, LineKind, Parameter, Program, Routine, Statement
from olp.languages.findings import Findings
from olp.languages.vendors.krl import checks, parsing
from olp.languages.vendors.krl.body import BodyReader
from olp.languages.vendors.krl.declarations import Head
from olp.languages.vendors.krl.lists import ListReader
from olp.languages.vendors.krl.neighbours import HEAD, NAME, TAIL, read_neighbours, stem
from olp.languages.vendors.krl.parsing import KrlLineReader
from olp.languages.vendors.krl.scope import NEUTRAL_TYPES, Scope
from olp.languages.vendors.krl.triggers import with_switches

_OF_HEADS = frozenset("DdEeGg")  # what heads and tails begin with


def read_program(source: Source, given: tuple[Source, ...] | None = None) -> Program:
    """The program in a text. `given`: the .dat and $config.dat (None: looked for on the disk). Never raises."""
    findings = Findings(source)
    routines: tuple[Routine, ...] = ()
    found: tuple[Source, ...] = ()
    data: tuple[Declare, ...] = ()
    told: tuple[Diagnostic, ...] = ()
    if checks.check_readable(findings):
        with no_garbage_collection():
            scope = Scope()
            beside = read_neighbours(source, scope, findings, given)
            reader = _FileReader(findings, scope)
            routines = _with_details(reader.read(), beside.details, source.path)
            data = (*beside.data, *reader.data, *beside.config)
            checks.check_targets(findings, scope, routines, bool(beside.data) or not source.path)
            found, told = beside.files, beside.diagnostics
    main = _main(routines, source.path)
    kinds = bytes(findings.kinds)
    guessed = main.upper() != stem(source.path)
    return Program(
        "krl",
        source,
        routines,
        (*findings.result(), *told),
        kinds,
        data,
        main,
        found,
        main_is_guessed=guessed,
    )


def _main(routines: tuple[Routine, ...], path: str) -> str:
    own = stem(path)
    named = next((one.name for one in routines if one.name.upper() == own), "")
    return named or (routines[0].name if routines else "")


def _with_details(routines: list[Routine], details: dict[str, str], path: str) -> tuple[Routine, ...]:
    """What stands in the .dat beside its data belongs to the routine with the file's name."""
    main = _main(tuple(routines), path) if details else ""
    return tuple(
        replace(one, details={**one.details, **details}) if one.name == main and details else one
        for one in routines
    )


# --- the program -----------------------------------------------------------------------------------------


class _FileReader:
    """A state machine over the lines: outside, in a routine, in a list."""

    def __init__(self, findings: Findings, scope: Scope) -> None:
        self._findings = findings
        self._kinds = findings.kinds
        self._scope = scope
        self._lines = KrlLineReader(findings, scope)
        self._routines: list[Routine] = []
        self.data: tuple[Declare, ...] = ()
        self._above: list[str] = []  # what stands before a head: &ACCESS; in and before a list comments, too
        self._lead: list[Comment] = []  # comments before a routine, and behind its head
        self._head: Head | None = None
        self._start = 0
        self._body: BodyReader | None = None
        self._list: ListReader | None = None
        self._outside = False
        self._folds: list[int] = []

    def read(self) -> list[Routine]:
        for number, line in enumerate(self._findings.source.lines, 1):
            if ";" in line:
                code, comment = parsing.split(line)
                if comment is not None:
                    self._fold(comment, number)
            else:
                code, comment = line.strip(parsing.BLANKS), None
            if not code:
                self._without_code(comment, number)
            elif code[0] in _OF_HEADS:
                self._word(code, comment or "", number)
            elif self._body is not None and code[0] != "&":
                self._body.read(code, comment or "", number)
            else:
                self._code(code, comment or "", number)
        self._end_of_file()
        return self._routines

    def _fold(self, comment: str, number: int) -> None:
        match = parsing.FOLD.match(comment)
        if match is None:
            return
        if match[1] is None:
            self._folds.append(number)
        elif self._folds:
            self._folds.pop()
        else:
            self._findings.once(Severity.WARNING, "P417", "", "ENDFOLD without FOLD", number, "remove it")

    def _without_code(self, comment: str | None, number: int) -> None:
        if comment is None:
            return
        if self._body is not None:
            self._body.comment(comment, number)
            return
        self._kinds[number - 1] = LineKind.COMMENT
        if self._list is not None:
            self._above.append(f";{comment}")
            self._list.comment(comment)
        else:
            self._lead.append(Comment(number, comment))

    def _word(self, code: str, comment: str, number: int) -> None:
        """A line that may be a head or a tail."""
        if HEAD.match(code):
            self._begin(code, comment, number)
        elif TAIL.fullmatch(code):
            self._kinds[number - 1] = LineKind.STATEMENT
            if self._body is None and self._list is None:
                self._findings.error(
                    "P402", f"{code} without DEF", number, "remove it, or add the line with DEF"
                )
            if comment and self._body is not None:
                self._body.body.append(Comment(number, comment))
            self._finish(number)
        else:
            self._code(code, comment, number)

    def _code(self, code: str, comment: str, number: int) -> None:
        if code[0] == "&":
            self._kinds[number - 1] = LineKind.RECORD
            self._above.append(code)
        elif self._body is not None:
            self._body.read(code, comment, number)
        elif self._list is not None:
            self._list.row(code, number, comment)
        elif not self._outside:
            self._outside = True
            self._findings.error(
                "P401", "this stands outside of any routine", number, "put it between DEF and END"
            )
        else:
            self._kinds[number - 1] = LineKind.ERROR

    def _begin(self, code: str, comment: str, number: int) -> None:
        if self._body is not None or self._list is not None:
            self._findings.error(
                "P402", "a routine begins before the last one has ended", number, "add END above"
            )
            self._finish(number - 1)
        self._kinds[number - 1] = LineKind.STATEMENT
        head = self._lines.parse(code, number)
        if not isinstance(head, Head):
            words = NAME.findall(code)
            head = Head(
                "list" if "DAT" in words[0].upper() else "routine", words[1] if len(words) > 1 else ""
            )
        self._head, self._start, self._outside = head, number, False
        if comment:
            self._lead.append(Comment(number, comment))
        lead, self._lead = self._lead, []
        if head.kind == "list":
            self._above += [f";{one.text}" for one in lead]
            self._list = ListReader(self._findings, self._scope, self._lines)
            return
        self._scope.enter()
        self._body = BodyReader(self._findings, self._scope, self._lines)
        self._body.body += lead

    def _finish(self, number: int) -> None:
        head, above = self._head, tuple(self._above)
        self._above = []
        if self._list is not None and head is not None:
            self._finish_list(head, above, number)
        elif self._body is not None and head is not None:
            self._body.finish(number)
            checks.check_body(self._findings, self._body.body, self._body.markers)
            self._add(self._routine(head, above, number))
        self._scope.leave()
        self._head = self._body = self._list = None

    def _finish_list(self, head: Head, above: tuple[str, ...], number: int) -> None:
        """A list in the program's own text, or a file of its own: that is a routine without statements."""
        assert self._list is not None
        self.data += self._list.finish()
        if not self._routines:
            details = {"list": "PUBLIC" if head.shared else "DEFDAT", "above": "\n".join(above)}
            shared = head.shared
            self._add(
                Routine(
                    head.name, self._start, (), PointTable(), details=details, last_line=number, shared=shared
                )
            )

    def _routine(self, head: Head, above: tuple[str, ...], number: int) -> Routine:
        assert self._body is not None
        body, parameters = _typed(with_switches(self._body.body), head.parameters)
        details = {"above": "\n".join(above)} if above else {}
        if head.shared:
            details["GLOBAL"] = "GLOBAL"
        if head.array:
            details["array"] = head.array
        return Routine(
            head.name,
            self._start,
            body,
            PointTable(),
            comment=next((row[9:].strip() for row in above if row[:9].upper() == "&COMMENT "), ""),
            details=details,
            last_line=number,
            parameters=parameters,
            returns=(NEUTRAL_TYPES.get(head.type) or head.type) if head.kind == "function" else "",
            shared=head.shared or not self._routines,
        )

    def _add(self, it: Routine) -> None:
        if any(one.name.upper() == it.name.upper() for one in self._routines):
            self._findings.error("P408", f"a second routine {it.name}", it.line, "rename one")
        self._routines.append(it)

    def _end_of_file(self) -> None:
        last = len(self._findings.source.lines)
        if self._body is not None or self._list is not None:
            self._findings.error(
                "P402", f"{self._head.name if self._head else ''} has no END", self._start, "add END"
            )
            self._finish(last)
        elif not self._routines and not self._outside:
            self._findings.error(
                "P400", "there is no routine and no list in this file", 1, "DEF NAME ( ) … END"
            )
        for number in self._folds[:1]:
            message = f"{len(self._folds)} FOLD without ENDFOLD"
            self._findings.once(Severity.WARNING, "P417", "", message, number, "close it: ;ENDFOLD")
        if self._lead and self._routines and "list" not in self._routines[-1].details:
            whole = self._routines[-1]
            self._routines[-1] = replace(whole, body=(*whole.body, *self._lead))


def _typed(
    body: tuple[Statement, ...], parameters: tuple[Parameter, ...]
) -> tuple[tuple[Statement, ...], tuple[Parameter, ...]]:
    """Parameters get the types that the body declares them with; those declarations are no variables."""
    if not parameters:
        return body, parameters
    names = {one.name.upper() for one in parameters}
    declared = {
        one.name.upper(): one for one in body if isinstance(one, Declare) and one.name.upper() in names
    }
    typed = tuple(
        one if (found := declared.get(one.name.upper())) is None else _declared_parameter(one, found)
        for one in parameters
    )
    return tuple(_without_parameters(body, names)), typed


def _without_parameters(body: tuple[Statement, ...], names: Set[str]) -> Iterator[Statement]:
    """Statements without declarations of parameters, whose comments stay."""
    for one in body:
        if not (isinstance(one, Declare) and one.name.upper() in names):
            yield one
        elif one.comment:
            yield Comment(one.line, one.comment)


def _declared_parameter(it: Parameter, found: Declare) -> Parameter:
    """A parameter with its type; how many elements an array has is the caller's, and a row of CHAR is one text."""
    open_sizes = tuple(Unknown("") for _ in found.sizes) or it.sizes
    return replace(
        it,
        type=found.type,
        native=found.native + (it.native or ("[]" if found.sizes else "")),
        sizes=open_sizes[:-1] if found.type == "string" else open_sizes,
    )
