"""A whole file: its functions as routines, the one that runs, the data they share, and what is wrong with it."""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterator
from pathlib import PurePath
from typing import Final
from xml.etree import ElementTree

from olp.core.diagnostic import Diagnostic, Severity, Span
from olp.core.garbage_collection import no_garbage_collection
from olp.core.source import Source
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.points import PointTable
from olp.languages.findings import Findings
from olp.languages.vendors.urscript import builtins, helpers
from olp.languages.vendors.urscript.calls import CallRules, Waits
from olp.languages.vendors.urscript.expressions import Expressions
from olp.languages.vendors.urscript.lines import Broken, Mark, UrscriptLine, UrscriptLineReader
from olp.languages.vendors.urscript.moves import UrscriptMoveRules
from olp.languages.vendors.urscript.scopes import Outliner, UrscriptNames, UrscriptPart
from olp.languages.vendors.urscript.syntax import (
    Assignment,
    Closing,
    Evaluation,
    Invocation,
    ListOf,
    Node,
    Opening,
    PlainPose,
    Running,
    Simple,
    UrscriptKeyword,
    UrscriptName,
    fold,
)

_GZIP = b"\x1f\x8b"


def read_program(source: Source) -> st.Program:
    """The program in a text. Never raises on bad text."""
    if source.raw.startswith((_GZIP, b"<", b"\xef\xbb\xbf<")):
        return read_polyscope(source)
    return read_lines(source)


def read_lines(source: Source) -> st.Program:
    """The program in the lines of a text."""
    findings = Findings(source)
    if not _is_readable(findings):
        return st.Program("urscript", source, (), findings.result(), bytes(findings.kinds))
    with no_garbage_collection():
        root = Outliner(findings).read(UrscriptLineReader(findings).read())
        _forget_helpers(root, source)
        main = _main(root, source)
        names = UrscriptNames(root, main, _starts(root, main))
        bodies = Bodies(findings, names)
        # The main program says which data holds before anything runs.
        routines = [bodies.routine(main, main.unique)]
        routines += [
            bodies.routine(part, part.unique) for part in root.all() if part is not main and part is not root
        ]
        data = [*bodies.data.values(), *bodies.late_data()]
    routines[0] = _without(routines[0], data)
    return st.Program(
        "urscript",
        source,
        tuple(routines),
        findings.result(),
        bytes(findings.kinds),
        tuple(data),
        main.unique,
    )


def _forget_helpers(root: UrscriptPart, source: Source) -> None:
    """Functions that olp wrote into the script stand for what they compute."""
    for part in list(root.all()):
        for name, one in list(part.parts.items()):
            if helpers.is_helper(name, source.lines[one.line - 1 : one.last_line]):
                del part.parts[name]


def _without(main: st.Routine, data: list[st.Declare]) -> st.Routine:
    """The main program without the declarations that hold before it runs."""
    from dataclasses import replace

    taken = {id(one) for one in data}
    return replace(main, body=tuple(one for one in main.body if id(one) not in taken))


def _is_readable(findings: Findings) -> bool:
    source = findings.source
    if source.encoding.startswith("utf-16") or any("\0" in line for line in source.lines):
        findings.error(
            "P001",
            "this is binary or UTF-16, not program text",
            Span(0),
            "save it as plain text: Notepad calls it ANSI or UTF-8",
        )
        return _refused(findings)
    if not any(line.strip() for line in source.lines):
        findings.error("P564", "the file is empty", Span(0), "")
        return False
    return True


def _refused(findings: Findings) -> bool:
    for number, line in enumerate(findings.source.lines):
        findings.kinds[number] = st.LineKind.ERROR if line.strip() else st.LineKind.BLANK
    return False


def _main(root: UrscriptPart, source: Source) -> UrscriptPart:
    """The part that runs: the file's own instructions, else the function they call, else the one that nobody calls."""
    called = _started(root)
    if _own_lines(root) and called is None:
        root.unique = _identifier(PurePath(source.path).stem, {part.unique for part in root.all()})
        return root
    main = called or _uncalled(root)
    if main is None:
        root.unique = _identifier(PurePath(source.path).stem, set())
        return root
    main.lines = [*((line, 0) for line in _remarks(root)), *main.lines]
    return main


def _remarks(root: UrscriptPart) -> Iterator[UrscriptLine]:
    """Comments outside of all functions, that of the call which starts the program among them."""
    for line, _ in root.lines:
        if type(line.content) is Mark:
            yield line
        elif line.comment:
            yield UrscriptLine(line.number, line.last, Mark(f" {line.comment}"))


def _starts(root: UrscriptPart, main: UrscriptPart) -> bool:
    """Whether the file is a program, of which `main` runs once, and no library that others call."""
    return main is root or _started(root) is main or (len(root.parts) == 1 and not main.parameters)


def _own_lines(root: UrscriptPart) -> list[UrscriptLine]:
    """The file's own instructions, outside of all functions."""
    return [line for line, _ in root.lines if type(line.content) is not Mark]


def _started(root: UrscriptPart) -> UrscriptPart | None:
    """The function that the file's only instruction calls."""
    own = _own_lines(root)
    if len(own) != 1 or type(own[0].content) is not Evaluation:
        return None
    call = own[0].content.value
    if type(call) is not Invocation or type(call.function) is not UrscriptName or call.arguments:
        return None
    part = root.parts.get(call.function.text)
    return part if part is not None and part.kind == "def" and not part.parameters else None


def _uncalled(root: UrscriptPart) -> UrscriptPart | None:
    """The only function, else the first one that needs no arguments and that no other one calls."""
    parts = [part for part in root.parts.values() if part.kind == "def"]
    if len(parts) < 2:
        return parts[0] if parts else next(iter(root.parts.values()), None)
    called = {
        node.function.text
        for part in root.all()
        for line, _ in part.lines
        for node in _calls_in(line)
        if type(node.function) is UrscriptName
    }
    free = [part for part in parts if all(default is not None for _, default in part.parameters)]
    return next((part for part in free if part.name not in called), free[0] if free else parts[0])


def _calls_in(line: UrscriptLine) -> Iterator[Invocation]:
    from olp.languages.vendors.urscript.syntax import expressions, walk

    content = line.content
    if not isinstance(content, tuple) or type(content).__name__ in ("Mark", "Broken"):
        return
    for expression in expressions(content):  # type: ignore[arg-type]
        for node in walk(expression):
            if type(node) is Invocation:
                yield node


def _identifier(stem: str, taken: set[str]) -> str:
    """A name for the file's own instructions."""
    name = re.sub(r"\W+", "_", stem, flags=re.ASCII).strip("_") or "program"
    if name[0].isdigit():
        name = f"program_{name}"
    while name in taken:
        name += "_main"
    return name


# --- Polyscope ---
# PolyScope's own files (.urp): compressed XML of program nodes, told as the script that those nodes mean.
#
# The lines of the source are that script; its bytes stay those of the file. Waypoints are joint positions, as taught.
#
# Codes: P562 a file that cannot be read, P563 a node that is kept by its name only.

_LARGEST = 50_000_000  # bytes that are unpacked; the largest programs have a tenth


def read_polyscope(source: Source) -> st.Program:
    """The program in a .urp file. Never raises."""
    from dataclasses import replace

    from olp.languages.vendors.urscript.polyscope_nodes import Script

    try:
        root = ElementTree.fromstring(_unpacked(source.raw))
    except (ElementTree.ParseError, zlib.error, ValueError) as problem:
        return _polyscope_refused(source, f"this PolyScope program cannot be read: {problem}")
    if root.tag != "URProgram":
        return _polyscope_refused(source, f"this is no PolyScope program: its first node is {root.tag[:40]}")
    script = Script(root, PurePath(source.path).stem)
    view = replace(source, encoding="utf-8", lines=tuple(script.lines))
    program = read_lines(view)
    unknown = [
        Diagnostic(
            "P563",
            f"the node {name} is kept by its name only ({count} of them)",
            Severity.WARNING,
            source.path,
            help="export the program as .script, which holds what the node does",
        )
        for name, count in sorted(script.unknown.items())
    ]
    return replace(program, diagnostics=(*unknown, *program.diagnostics))


def _unpacked(raw: bytes) -> bytes:
    """The XML. Raises zlib.error, and ValueError for what no controller wrote."""
    unpacker = zlib.decompressobj(31)
    plain = raw.removeprefix(b"\xef\xbb\xbf").lstrip().startswith(b"<")
    data = raw if plain else unpacker.decompress(raw, _LARGEST)
    if unpacker.unconsumed_tail:
        raise ValueError(f"it is larger than {_LARGEST} bytes")
    if b"\0" in data:
        raise ValueError("it is not UTF-8")
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        raise ValueError("it defines entities")
    return data


def _polyscope_refused(source: Source, message: str) -> st.Program:
    findings = Findings(source)
    findings.error("P562", message, Span(0), "save it again on the controller, or export it as .script")
    findings.kinds[:] = bytes([st.LineKind.ERROR]) * len(findings.kinds)
    return st.Program("urscript", source, (), findings.result(), bytes(findings.kinds))


# --- Bodies ---
# Lowers the parts of a file into routines: blocks, assignments, threads, and data that holds before anything runs.

_SEVERITIES: Final = {
    "P555": Severity.INFO,
    "P560": Severity.INFO,
    "P558": Severity.ERROR,
    "P559": Severity.ERROR,
}
# What may stand before data that holds from the beginning on: it neither moves nor asks for a value.
_BEFORE_DATA: Final = (st.Comment, st.Process, st.SetTool, st.SetOutput, st.StartTask, st.Declare)


class Bodies:
    """Lowers all parts of one file; `data` grows with what they share."""

    def __init__(self, findings: Findings, names: UrscriptNames) -> None:
        self._findings = findings
        self._names = names
        self.data: dict[str, st.Declare] = {}

    def routine(self, part: UrscriptPart, name: str) -> st.Routine:
        body = _UrscriptBody(self._findings, self._names, part, self.data)
        statements = body.lower()
        details = {} if part.kind in ("def", "file") else {"kind": part.kind}
        return st.Routine(
            name,
            part.line,
            tuple(statements),
            PointTable(),
            comment=part.comment,
            details=details,
            last_line=part.last_line,
            parameters=body.parameters(),
            returns=_plain(self._names.of(part).result),
        )

    def late_data(self) -> list[st.Declare]:
        """Shared names that get their value while the program runs."""
        found = []
        for facts in self._names.facts.values():
            for name, index in facts.first.items():
                if name not in self.data and self._names.is_shared(facts.part, name):
                    line = facts.part.lines[index][0].number
                    self.data[name] = st.Declare(
                        line, name, _plain(self._names.types.get(name, "")), shared=True
                    )
                    found.append(self.data[name])
        return found


class _UrscriptBody:
    """`_loops`: words of the open blocks."""

    def __init__(
        self, findings: Findings, names: UrscriptNames, part: UrscriptPart, data: dict[str, st.Declare]
    ) -> None:
        self._findings = findings
        self._names = names
        self._facts = names.of(part)
        self._part = part
        self._data = data
        self._is_main = part is names.main
        # Another file may call a library's function, and each time its values are set anew.
        self._preamble = self._is_main and names.starts
        self._expressions = Expressions(names, part, self._tell)
        self._moves = UrscriptMoveRules(self._expressions, self._tell)
        self._calls = CallRules(self._expressions, self._tell)
        self._waits = Waits(part, self._expressions)
        self._open: list[str] = []
        self._number = 0
        self._comment = ""
        self._index = 0
        self._depth = 0

    def _tell(self, code: str, message: str, help: str) -> None:
        severity = _SEVERITIES.get(code, Severity.WARNING)
        span = self._findings.whole_line(self._number)
        if severity is Severity.ERROR:
            self._findings.error(code, message, span, help)
        else:
            self._findings.once(severity, code, message, message, span, help)

    def parameters(self) -> tuple[st.Parameter, ...]:
        found = []
        for name, default in self._part.parameters:
            type_ = _plain(self._names.type_of(self._part, name))
            value = None if default is None else self._expressions.lower(default, name in self._facts.joints)
            found.append(st.Parameter(name, type_, optional=default is not None, default=value))
        return tuple(found)

    def lower(self) -> list[st.Statement]:
        body: list[st.Statement] = []
        lines, index, count = self._part.lines, 0, len(self._part.lines)
        shadowed = {word for word in builtins.MOVES if self._part.find(word) is not None}
        while index < count:
            line, self._depth = lines[index]
            content = line.content
            self._number, self._comment, self._index = line.number, line.comment, index
            if type(content) is Evaluation and type(content.value) is Invocation:
                function = content.value.function
                if (
                    type(function) is UrscriptName
                    and function.text in builtins.MOVES
                    and function.text not in shadowed
                ):
                    move = self._moves.move(function.text, content.value.arguments, line.number, line.comment)
                    if move is not None:
                        body.append(move)
                        self._preamble = False
                    index += 1
                    continue
            if (
                type(content) is Assignment
                and type(content.value) is PlainPose
                and type(content.target) is UrscriptName
                and content.target.text != helpers.COUNTER
            ):
                assigned = self._point(content.target.text, content, content.value)
                body.append(assigned)
                self._preamble = self._preamble and isinstance(assigned, _BEFORE_DATA)
                index += 1
                continue
            waited = self._waits.at(index, line)
            if waited is not None:
                body.append(waited[0])
                self._preamble = False
                index += waited[1]
                continue
            found = self._lowered(line)
            self._preamble = self._preamble and all(isinstance(one, _BEFORE_DATA) for one in found)
            body.extend(found)
            index += 1
        return self._own_names() + body

    def _own_names(self) -> list[st.Statement]:
        """Names of this part that first get a value inside a block, which no declaration stands for."""
        found: list[st.Statement] = []
        parameters = {name for name, _ in self._part.parameters}
        for name, index in self._facts.first.items():
            if name == helpers.COUNTER:
                continue
            inside = self._part.lines[index][1] > 0 or type(self._part.lines[index][0].content) is Opening
            if inside and name not in parameters and not self._names.is_shared(self._part, name):
                type_ = _plain(self._names.type_of(self._part, name))
                found.append(st.Declare(self._part.line, name, type_))
        return found

    # --- lines ------------------------------------------------------------------------------------------

    def _lowered(self, line: UrscriptLine) -> list[st.Statement]:
        content = line.content
        if type(content) is Mark:
            if content.opaque:
                return [st.Opaque(line.number, content.text)]
            return [st.Comment(line.number, content.text)]
        if type(content) is Broken:
            return [st.Opaque(line.number, content.text)]
        if type(content) is Opening:
            return self._opening(content)
        if type(content) is Closing:
            word = self._open.pop() if self._open else "if"
            return [
                st.EndIf(line.number, line.comment)
                if word == "if"
                else st.EndWhile(line.number, line.comment)
            ]
        assert isinstance(content, (UrscriptKeyword, Assignment, Evaluation))
        return self._simple(content)

    def _opening(self, content: Opening) -> list[st.Statement]:
        number, comment, word = self._number, self._comment, content.word
        condition: ex.Expression = ex.Unknown(word)
        if content.condition is not None:
            condition = self._expressions.lower(content.condition)
        found: list[st.Statement] = []
        match word:
            case "if":
                found.append(st.If(number, condition, comment))
            case "elif":
                found.append(st.ElseIf(number, condition, comment))
            case "else":
                found.append(st.Else(number, comment))
            case _:
                found.append(st.While(number, condition, comment))
        if word in ("if", "while"):
            self._open.append(word)
        if content.rest is not None:
            self._comment = ""
            self._depth += 1
            found += self._simple(content.rest)
            self._depth -= 1
        if content.closed:
            opened = self._open.pop() if self._open else "if"
            found.append(st.EndWhile(number) if opened == "while" else st.EndIf(number))
        return found

    def _simple(self, content: Simple) -> list[st.Statement]:
        if type(content) is Assignment:
            return [self._assignment(content)]
        if type(content) is UrscriptKeyword:
            return [self._word(content)]
        assert type(content) is Evaluation
        value = content.value
        if type(value) is Invocation:
            if type(value.function) is UrscriptName and value.function.text in builtins.MOVES:
                word = value.function.text
                if self._part.find(word) is None:
                    move = self._moves.move(word, value.arguments, self._number, self._comment)
                    return [] if move is None else [move]
            return self._calls.statements(value, self._number, self._comment)
        if type(value) is Running:
            return [self._start(value, "")]
        if type(value) is UrscriptName:
            return [self._bare(value.text)]
        return [self._no_statement()]

    def _bare(self, name: str) -> st.Statement:
        """A word without brackets: halt, enter_critical, exit_critical."""
        if name == "halt" and self._is_main:
            return st.Return(self._number, comment=self._comment, spelling="halt")
        if name in ("halt", "enter_critical", "exit_critical"):
            return st.Process(self._number, name, (), self._comment)
        return self._no_statement()

    def _no_statement(self) -> st.Statement:
        self._tell("P566", "a value that nothing is done with: the line is kept", "is () or = missing?")
        return st.Opaque(self._number, self._findings.source.line(self._number).strip())

    def _word(self, content: UrscriptKeyword) -> st.Statement:
        number, comment, value = self._number, self._comment, content.value
        match content.word:
            case "return":
                result = None if value is None else self._expressions.lower(value)
                return st.Return(number, result, comment=comment)
            case "join":
                assert value is not None
                return st.WaitTask(number, self._text_of(value), comment)
            case "kill":
                assert value is not None
                return st.Process(number, "kill", (("", self._expressions.lower(value)),), comment)
        if "while" not in self._open:
            self._findings.error(
                "P565",
                f"{content.word} outside of a loop",
                self._findings.whole_line(number),
                "remove it, or is an end too many above?",
            )
        return st.Break(number, comment) if content.word == "break" else st.Continue(number, comment)

    # --- assignments ------------------------------------------------------------------------------------

    def _assignment(self, content: Assignment) -> st.Statement:
        target, value = content.target, content.value
        if type(value) is Running and content.operator == "=":
            return self._start(value, self._text_of(target))
        if type(target) is UrscriptName:
            return self._named(target.text, content)
        lowered, place = self._expressions.lower(value), self._expressions.lower(target)
        if type(place) is ex.Binary and type(place.right) is ex.Number:
            lowered, place = ex.scaled(lowered, 1.0 / place.right.value), place.left
        elif type(place) in (ex.CallValue, ex.Number, ex.Text, ex.SignalState):
            self._tell("P558", "this cannot be assigned to", "a name stands left of =")
        if content.operator != "=":
            lowered = ex.Binary(content.operator[0], place, lowered)
        return self._stored(place, lowered)

    def _point(self, name: str, content: Assignment, pose: PlainPose) -> st.Statement:
        """A pose that gets a name, of which a path has thousands; as `_named`, which takes the rarer ones."""
        value = self._expressions.plain_pose(pose)
        names = self._names
        if (
            type(value) is ex.PositionLiteral
            and content.operator == "="
            and self._is_main
            and self._depth == 0
            and self._facts.first.get(name) == self._index
            and names.is_shared(self._part, name)
            and (self._preamble or names.is_set_once(name))
            and name not in self._data
        ):
            type_ = _plain(names.types.get(name, ""))
            declared = st.Declare(self._number, name, type_, value, (), "variable", True, "", self._comment)
            self._data[name] = declared
            return declared
        return self._named(name, content, value)

    def _named(self, name: str, content: Assignment, value: ex.Expression | None = None) -> st.Statement:
        """`value`: what is assigned, where that is a pose."""
        names, part = self._names, self._part
        pose = value is not None
        if value is None:
            wanted = names.holds_joints(part, name) or names.holds_joint_lists(part, name)
            value = self._expressions.lower(content.value, wanted)
        if content.operator != "=":
            value = ex.Binary(content.operator[0], ex.Named(name), value)
            return st.Assign(self._number, ex.Named(name), value, self._comment)
        first = self._facts.first.get(name) == self._index and self._depth == 0
        sizes = () if pose else _sizes(content.value)
        type_ = _plain(names.type_of(part, name), bool(sizes))
        if sizes and type_ in ("joints", "list", "") and not names.holds_joint_lists(part, name):
            sizes = ()
        if names.is_shared(part, name):
            value_ = fold(value)
            # What is set once cannot be read before: it holds from the beginning on.
            early = self._is_main and first and (self._preamble or names.is_set_once(name))
            if early and name not in self._data and _is_constant(value_):
                declared = st.Declare(
                    self._number, name, type_, value_, sizes, shared=True, comment=self._comment
                )
                self._data[name] = declared
                return declared
        elif first and not any(name == parameter for parameter, _ in part.parameters):
            return st.Declare(
                self._number, name, type_, value, sizes, native=content.scope, comment=self._comment
            )
        return self._stored(ex.Named(name), value)

    def _stored(self, target: ex.Expression, value: ex.Expression) -> st.Statement:
        if type(value) is ex.CallValue:
            return st.Call(self._number, value.routine, value.arguments, comment=self._comment, result=target)
        return st.Assign(self._number, target, value, self._comment)

    def _start(self, value: Running, task: str) -> st.Statement:
        call = value.call
        if type(call) is not Invocation or type(call.function) is not UrscriptName or call.arguments:
            return st.Process(self._number, "run", (("", self._expressions.lower(call)),), self._comment)
        called = self._part.find(call.function.text)
        pulse = (
            None
            if called is not None or task
            else helpers.pulse(self._number, call.function.text, self._comment)
        )
        if pulse is not None:
            return pulse
        name = call.function.text if called is None else called.unique
        return st.StartTask(self._number, name, task, comment=self._comment)

    def _text_of(self, node: Node) -> str:
        """A thread's handle as it is written."""
        if type(node) is UrscriptName:
            return node.text
        text = self._findings.source.line(self._number).strip().removeprefix("join ")
        return text.split("= run")[0].split("=run")[0].strip()


def _is_constant(e: ex.Expression) -> bool:
    if type(e) is ex.PositionLiteral:
        return True
    if type(e) is ex.RecordLiteral:
        return all(_is_constant(value) for _, value in e.members)
    if type(e) is ex.Function and e.name in ("joints", "pose-vector"):
        return all(map(_is_constant, e.arguments))
    return type(e) in (ex.Number, ex.Text, ex.SignalState)


def _plain(type_: str, sized: bool = False) -> str:
    """A type as `Declare` says it: that of the elements of a list of known length, where they have one."""
    if type_.startswith("list:"):
        element = type_[5:]
        return element if sized and not element.startswith("list") else "list"
    return type_


def _sizes(value: Node) -> tuple[ex.Expression, ...]:
    if type(value) is ListOf and value.items:
        return (ex.Number(len(value.items)),)
    return ()
