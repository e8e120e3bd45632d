"""Goes through the clauses of a file: modules, their data, routines with their bodies and handlers."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Final

from olp.core.diagnostic import Severity, Span
from olp.ir import program as st
from olp.ir.block_structure import LAST_BRANCHES
from olp.ir.points import PointTable
from olp.languages.findings import Findings
from olp.languages.vendors.rapid.clauses import Clause, RapidRemark
from olp.languages.vendors.rapid.fast import PlainClauses
from olp.languages.vendors.rapid.names import RapidNames
from olp.languages.vendors.rapid.parsing import Parsing, mark, span_of
from olp.languages.vendors.rapid.predefined_data import TYPES
from olp.languages.vendors.rapid.statements import FramingClause, at_line

_HANDLER: Final = re.compile(r"\b(?:ERROR|UNDO|BACKWARD)\b", re.IGNORECASE)
_ENDS: Final = {"PROC": "ENDPROC", "FUNC": "ENDFUNC", "TRAP": "ENDTRAP"}
_SILENT: Final = (st.Disabled, st.Opaque)  # have no room for a comment but their text
_UNTURNED_HELP: Final = "teach it before a move goes to it"
_POSITIONS: Final = frozenset({"position", "joints"})


class ModuleReader:
    """`routines` and `data` grow while reading. `names` was gathered from the same clauses."""

    def __init__(self, findings: Findings, names: RapidNames) -> None:
        self._findings = findings
        self._names = names
        self._plain = PlainClauses(names)
        self._parsing = Parsing(findings, names)
        self._module = ""  # the open module's name
        self._record = False
        self._before: list[str] = []  # what stands between routines, for RAPID's own writer
        self._lead: list[st.Comment] = []  # comments just above a routine
        self._passed: list[
            st.Comment
        ] = []  # those in `_before`: other languages have them in the next routine
        self._head: FramingClause | None = None  # of the open routine
        self._line = 0
        self._outside = 0  # how many comments at the head of its body `_before` has, too
        self._handler = 0  # its first line
        self._handlers: dict[int, str] = {}  # first line of each -> ERROR, LISTED, UNDO or BACKWARD
        self._handled: dict[int, list[st.Statement]] = {}  # line -> the handlers' statements
        self._body: list[st.Statement] = []
        self._blocks = OpenBlocks(findings)
        self.routines: list[st.Routine] = []
        self.data: list[st.Declare] = []

    def read(self, clauses: Sequence[Clause | RapidRemark]) -> None:
        """Reads all clauses of the file."""
        move, point, kinds = self._plain.move, self._plain.point, self._findings.kinds
        for clause in clauses:
            if type(clause) is RapidRemark:
                self._remark(clause)
                continue
            assert type(clause) is Clause
            if clause.word.startswith("MOVE") and self._head is not None and not self._handler:
                found = move(clause.text, clause.line, (clause.comment or "").rstrip())
                if found is not None:
                    self._body.append(found)
                    for line in range(clause.line - 1, clause.last):
                        kinds[line] = st.LineKind.STATEMENT
                    if self._names.uneven:
                        self._tell_uneven(clause)
                    continue
            elif not clause.word and self._head is None and not self._record and clause.comment is None:
                declared = point(clause.text, clause.line, "")
                if declared is not None:
                    if self._names.uneven:
                        self._tell_uneven(clause)
                    self._kind(
                        clause, st.LineKind.POINT if declared.type in _POSITIONS else st.LineKind.STATEMENT
                    )
                    self._declare(declared)
                    continue
            self._clause(clause)
        self._end_of_file()

    # --- comments ---------------------------------------------------------------------------------------------

    def _remark(self, remark: RapidRemark) -> None:
        if not self._findings.kinds[remark.line - 1]:
            self._findings.kinds[remark.line - 1] = st.LineKind.COMMENT
        text = remark.text.rstrip()
        if self._head is None:
            self._lead.append(st.Comment(remark.line, text))
        elif not self._handler:
            self._body.append(st.Comment(remark.line, text))

    def _flush(self, *items: str) -> None:
        """Module text that belongs to no routine, in order."""
        self._passed += self._written_lead()
        self._before += items

    def _written_lead(self) -> list[st.Comment]:
        """The comments so far, which are part of the module's text from here on."""
        lead, self._lead = self._lead, []
        self._before += [f"! {one.text}" for one in lead]
        return lead

    def _declare(self, it: st.Declare) -> None:
        """Data of the module, which take the comments above them along."""
        above = tuple(one.text for one in self._written_lead())
        self._before.append(f"D {it.name}")
        self.data.append(replace(it, above=above) if above else it)

    def _leave_module(self) -> None:
        """Comments behind the last routine stand in it for other languages, behind its end."""
        if self.routines and self._passed:
            last_one = self.routines[-1]
            self.routines[-1] = replace(last_one, body=(*last_one.body, *self._passed))
            self._passed = []

    # --- clauses ----------------------------------------------------------------------------------------------

    def _clause(self, clause: Clause) -> None:
        if clause.word == "%%%":
            self._kind(clause, st.LineKind.RECORD)
            self._flush(*(f"H {line}" for line in clause.text.split("\n")))
            return
        if self._record and clause.word not in ("ENDRECORD", "ENDMODULE", "PROC", "FUNC", "TRAP"):
            self._parsing.read(clause, component=True)
            self._kind(clause, st.LineKind.RECORD)
            self._flush(f"T   {_one_line(clause)}")
            return
        declared = self._plain.point(clause.text, clause.line, clause.comment or "")
        if declared is None and self._parsing.too_much(clause):
            return
        if declared is not None:
            found: FramingClause | list[st.Statement] | None = [declared]
        else:
            found, rest = self._parsing.read(clause, self._head)
        if self._names.uneven:
            self._tell_uneven(clause)
        if self._names.unturned:
            self._names.unturned = False
            message = "a quaternion of zeros is no rotation: it is taken as one that turns nothing"
            self._findings.once(Severity.WARNING, "P465", "", message, span_of(clause), _UNTURNED_HELP)
        if found is None:
            self._stand_in(clause)
        elif isinstance(found, FramingClause):
            self._kind(clause, st.LineKind.RECORD)
            self._frame(found, clause)
        else:
            if declared is None and rest is None and clause.word.startswith("MOVE"):
                self._plain.learn(clause.text, found)
            self._statements(found, clause)
        if declared is None and rest is not None:
            self._clause(rest)

    def _kind(self, clause: Clause, kind: int) -> None:
        mark(self._findings, clause, kind)

    def _stand_in(self, clause: Clause) -> None:
        """A broken clause that opens or closes something: what follows is read as if it were right."""
        if clause.word in _ENDS:
            words = re.findall(r"\w+", clause.text.partition("(")[0])
            self._frame(FramingClause(clause.word, words[-1] if len(words) > 1 else "?"), clause)
        elif clause.word == "MODULE":
            words = re.findall(r"\w+", clause.text)
            self._frame(FramingClause("MODULE", words[1] if len(words) > 1 else "?"), clause)
        else:
            self._blocks.stand_in(clause)

    def _statements(self, found: list[st.Statement], clause: Clause) -> None:
        statements = found if found and found[0].line == clause.line else at_line(found, clause.line)
        if clause.comment is not None and statements:
            last = len(statements) - 1
            place = next((n for n in range(last, -1, -1) if not isinstance(statements[n], _SILENT)), last)
            statements = list(statements)
            statements[place] = _commented(statements[place], clause.comment.rstrip())
        first = statements[0]
        if isinstance(first, st.Declare):
            self._kind(clause, st.LineKind.POINT if first.type in _POSITIONS else st.LineKind.STATEMENT)
            if self._head is None:
                self._declare(first)
                return
            if first.storage != "persistent":  # it is the routine's own, and begins anew with each call
                statements = [replace(first, shared=False), *statements[1:]]
        else:
            self._kind(
                clause,
                st.LineKind.OPAQUE if isinstance(first, (st.Opaque, st.Process)) else st.LineKind.STATEMENT,
            )
        if self._head is None:
            message = "an instruction outside of a routine"
            self._findings.error("P457", message, span_of(clause), "move it between PROC and ENDPROC")
            return
        self._blocks.note(statements)
        if self._handler:
            self._handled.setdefault(clause.line, []).extend(statements)
        else:
            self._body += statements

    def _tell_uneven(self, clause: Clause) -> None:
        self._names.uneven = False
        message = "a quaternion that is not of unit length is brought to it"
        self._findings.once(
            Severity.INFO, "P463", "", message, span_of(clause), "the controller does the same"
        )

    # --- frames -----------------------------------------------------------------------------------------------

    def _frame(self, frame: FramingClause, clause: Clause) -> None:
        match frame.word:
            case "MODULE":
                if self._head is not None:
                    self._cut(clause.line - 1, "a module begins before its end")
                if self._module:
                    message = f"MODULE {frame.name} begins before ENDMODULE of {self._module}"
                    self._findings.error("P453", message, span_of(clause), "add ENDMODULE before this line")
                attributes = f"({','.join(frame.attributes)})" if frame.attributes else ""
                self._module = frame.name
                self._flush(f"M {frame.name}{attributes}")
                self._trailing(clause)
            case "ENDMODULE":
                if self._head is not None:
                    self._cut(clause.line - 1, "the module ends before")
                self._record = False
                if not self._module:
                    self._findings.error("P454", "ENDMODULE without MODULE", span_of(clause), "remove it")
                self._module = ""
                self._flush("E")
                self._leave_module()
                self._trailing(clause)
            case "RECORD":
                self._record = True
                self.data += self._names.layouts(frame.name, clause.line)
                self._flush(f"T {_one_line(clause)}")
            case "ENDRECORD":
                self._record = False
                self._flush(f"T {_one_line(clause)}")
            case "ALIAS":
                self._flush(f"T {_one_line(clause)}")
            case "HANDLER":
                self._handle(frame, clause)
            case "PROC" | "FUNC" | "TRAP":
                self._open_routine(frame, clause)
            case _:
                self._end_routine(frame, clause)

    def _trailing(self, clause: Clause) -> None:
        if clause.comment is not None:
            self._lead.append(st.Comment(clause.line, clause.comment.rstrip()))
            self._flush()

    def _open_routine(self, frame: FramingClause, clause: Clause) -> None:
        if self._head is not None:
            self._cut(clause.line - 1, f"{frame.word} {frame.name} begins before its end")
        if not self._module:
            message = f"{frame.word} outside of a module"
            self._findings.once(
                Severity.ERROR, "P456", "", message, span_of(clause), "put it between MODULE and ENDMODULE"
            )
        self._record = False
        self._head, self._line = frame, clause.line
        self._outside = len(self._passed)
        self._body = [*self._passed, *self._lead]
        self._passed, self._lead = [], []
        if clause.comment is not None:
            self._body.append(st.Comment(clause.line, clause.comment.rstrip()))
        self._handler = 0
        self._blocks = OpenBlocks(self._findings)
        self._names.local = self._names.inside.get(clause.line, {})
        self._plain.forget()
        self._parsing.forget()

    def _handle(self, frame: FramingClause, clause: Clause) -> None:
        """An ERROR, UNDO or BACKWARD handler: kept word for word with what it means, for it runs in no plan."""
        if self._head is None:
            message = "a handler outside of a routine"
            self._findings.error("P457", message, span_of(clause), "move it into a routine")
            return
        if not self._handler:
            self._handler = clause.line
            self._blocks.close()
            if self._body and type(self._body[-1]) is st.Comment and self._body[-1].line == clause.line:
                self._body.pop()  # it is part of the line, which is kept word for word
        self._handlers[clause.line] = "LISTED" if "(" in clause.text else frame.name
        message = "a handler is kept and not modelled: in a plan nothing fails"
        self._findings.once(Severity.INFO, "P461", "", message, span_of(clause))

    def _end_routine(self, frame: FramingClause, clause: Clause) -> None:
        if self._head is None:
            self._findings.error(
                "P454", f"{frame.word} without {frame.word[3:]}", span_of(clause), "remove it"
            )
            return
        wanted = _ENDS[self._head.word]
        if frame.word != wanted:
            message = f"{frame.word} ends a {self._head.word}"
            self._findings.error("P454", message, span_of(clause), f"write {wanted}")
        self._close_routine(clause.line, (clause.comment or "").rstrip())

    def _close_routine(self, last: int, comment: str = "", ended: bool = True) -> None:
        """`ended`: line `last` holds the word that ends it; otherwise its last line is `last`, which is told."""
        head = self._head
        if head is None:
            return
        if self._handler:
            self._keep_handler(last - 1 if ended else last)
        if ended:
            self._blocks.close()
        details = {"before": "\n".join(self._before)}
        if head.word != "PROC":
            details["kind"] = head.word
        if self._outside:
            details["outside"] = str(self._outside)
        if head.returns:
            details["returns"] = head.returns
        if comment:
            self._body.append(st.Comment(last, comment))
        self.routines.append(
            st.Routine(
                head.name,
                self._line,
                tuple(self._body),
                PointTable(),
                details=details,
                last_line=last,
                parameters=head.parameters,
                returns=TYPES.get(self._names.resolved(head.returns), head.returns),
                shared=not head.local,
            )
        )
        self._before, self._body, self._head, self._handler = [], [], None, 0
        self._handlers, self._handled = {}, {}
        self._names.local = {}
        self._parsing.forget()
        self._plain.forget()

    def _keep_handler(self, last: int) -> None:
        """The lines of the handlers, word for word."""
        kinds, lines = self._findings.kinds, self._findings.source.lines
        handler = ""
        for number in range(self._handler, last + 1):
            handler = self._handlers.get(number, handler)
            text = lines[number - 1].strip()
            word = _HANDLER.search(text) if number == self._handler else None
            if text:
                means = tuple(self._handled.get(number, ()))
                kept = text[word.start() :] if word else text
                self._body.append(st.Disabled(number, kept, handler=handler, means=means))
                if kinds[number - 1] != st.LineKind.ERROR:
                    kinds[number - 1] = st.LineKind.OPAQUE

    def _end_of_file(self) -> None:
        last = len(self._findings.source.lines)
        if self._head is not None:
            self._cut(last, "is the file cut off?")
        if self._module:
            message = f"MODULE {self._module} is never closed"
            self._findings.error(
                "P453", message, self._findings.whole_line(last), "add ENDMODULE; is the file cut off?"
            )
        self._flush()
        self._leave_module()
        if self.routines and self._before:
            last_one = self.routines[-1]
            details = {**last_one.details, "after": "\n".join(self._before)}
            self.routines[-1] = replace(last_one, details=details)

    def _cut(self, last: int, hint: str) -> None:
        """The open routine has no end."""
        assert self._head is not None
        message = f"{self._head.word} {self._head.name} is never closed"
        help = f"add {_ENDS[self._head.word]}; {hint}"
        self._findings.error("P453", message, self._findings.whole_line(self._line), help)
        self._close_routine(last, ended=False)


def _one_line(clause: Clause) -> str:
    """The clause with its comment."""
    text = " ".join(clause.text.split())
    return text if clause.comment is None else f"{text} !{clause.comment.rstrip()}"


def _commented(statement: st.Statement, comment: str) -> st.Statement:
    if isinstance(statement, (st.Comment, st.Disabled, st.Opaque)):
        return replace(statement, text=f"{statement.text} !{comment}")
    return replace(statement, comment=comment)


# --- Blocks ---
# Pairs IF, WHILE, FOR and TEST of one routine in RAPID's words.

_OPENERS: Final = {st.If: "IF", st.While: "WHILE", st.For: "FOR", st.Switch: "TEST"}
_CLOSERS: Final = {st.EndIf: "IF", st.EndWhile: "WHILE", st.Next: "FOR", st.EndSwitch: "TEST"}
_BRANCHES: Final = {st.ElseIf: "IF", st.Else: "IF", st.Case: "TEST", st.Default: "TEST"}
_BRANCH_WORDS: Final = {st.ElseIf: "ELSEIF", st.Else: "ELSE", st.Case: "CASE", st.Default: "DEFAULT"}
_MARKERS: Final = {
    **{word: ("open", word) for word in ("IF", "WHILE", "FOR", "TEST")},
    **{f"END{word}": ("close", word) for word in ("IF", "WHILE", "FOR", "TEST")},
}


class OpenBlocks:
    """The open blocks of a routine: words and lines."""

    def __init__(self, findings: Findings) -> None:
        self._findings = findings
        self._open: list[tuple[str, int]] = []
        self._last: dict[int, str] = {}  # depth of a block that had its ELSE or DEFAULT

    def note(self, statements: Iterable[st.Statement]) -> None:
        """Statements of one clause; what does not pair is told."""
        for one in statements:
            kind = type(one)
            if kind in _OPENERS:
                self._begin(_OPENERS[kind], one.line)
            elif kind in _CLOSERS:
                self._close(_CLOSERS[kind], one.line, f"END{_CLOSERS[kind]}")
            elif kind in _BRANCHES:
                if not any(word == _BRANCHES[kind] for word, _ in self._open[-1:]):
                    self._branch(_BRANCHES[kind], _BRANCH_WORDS[kind], one.line)
                if self._open:
                    self._order(_BRANCH_WORDS[kind], one)

    def stand_in(self, clause: Clause) -> None:
        """A broken clause that opens or closes a block does so all the same."""
        does, word = _MARKERS.get(clause.word, ("", ""))
        if does == "open" and (word != "IF" or clause.text.rstrip()[-4:].upper() == "THEN"):
            self._begin(word, clause.line)
        elif does == "close":
            self._close(word, clause.line, f"END{word}")

    def _begin(self, word: str, line: int) -> None:
        self._open.append((word, line))
        self._last.pop(len(self._open), None)

    def _close(self, word: str, line: int, closer: str) -> None:
        depth = next((d for d in range(len(self._open) - 1, -1, -1) if self._open[d][0] == word), None)
        if depth is None:
            message = f"{closer} without {word}"
            self._findings.error(
                "P454", message, self._findings.whole_line(line), "remove it, or open the block"
            )
            return
        for inner, at in self._open[depth + 1 :]:
            self._never(inner, at)
        del self._open[depth:]

    def _branch(self, word: str, branch: str, line: int) -> None:
        if any(opened == word for opened, _ in self._open):
            while self._open[-1][0] != word:
                self._never(*self._open.pop())
            return
        message = f"{branch} without {word}"
        self._findings.error("P454", message, self._findings.whole_line(line), "remove it, or open the block")

    def _order(self, branch: str, one: st.Statement) -> None:
        """A branch of the innermost block, behind which no other may stand if it is for all other cases."""
        before = self._last.get(len(self._open))
        if before is not None:
            span, help = self._findings.whole_line(one.line), f"{before} comes last in its block, and once"
            self._findings.error("P454", f"{branch} behind {before}", span, help)
        elif type(one) in LAST_BRANCHES:
            self._last[len(self._open)] = branch

    def close(self) -> None:
        """The routine, or what stands before its handlers, ends."""
        for word, line in self._open:
            self._never(word, line)
        self._open.clear()

    def _never(self, word: str, line: int) -> None:
        span = self._findings.whole_line(line) if line else Span(0)
        self._findings.error(
            "P453", f"{word} is never closed", span, f"add END{word} behind its last instruction"
        )
