"""A whole VAL3 file: a program, data or a project; and everything that is wrong with it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from html import unescape
from typing import Any, Final, NamedTuple

from olp.core.diagnostic import Severity
from olp.core.source import Source
from olp.core.units import deg, mm, percent
from olp.ir.expressions import (
    Binary,
    CallValue,
    Compare,
    Expression,
    FrameRef,
    Function,
    Item,
    Member,
    Named,
    NamedArgument,
    Number,
    PositionLiteral,
    Quantity,
    Signal,
    SignalState,
    SystemValue,
    Text,
    Unary,
)
from olp.ir.points import PointTable
from olp.ir.program import (
    Assign,
    Blend,
    BlendKind,
    Break,
    Call,
    Case,
    Comment,
    Declare,
    Default,
    Dwell,
    EndSwitch,
    EndWhile,
    For,
    If,
    LineKind,
    Message,
    Move,
    Next,
    Parameter,
    Path,
    Process,
    Program,
    Repeat,
    Routine,
    SetOutput,
    SetOverride,
    Speed,
    SpeedUnit,
    StartTask,
    Statement,
    Switch,
    Until,
    Wait,
    While,
)
from olp.languages.findings import Findings
from olp.languages.lark_host import BrokenLineError
from olp.languages.short_reader import (
    Codes,
    LineParser,
    NotModelledError,
    check_blocks,
    constants,
    from_zero,
    is_readable,
    joints,
    unreadable,
    with_comment,
    words,
    xyz_pose,
)
from olp.languages.statement_rules import BlockRules
from olp.languages.vendors.val3.data import (
    JOINTS,
    MIXED,
    POSES,
    SIGNALS,
    WORLD,
    Val3Declarations,
    XmlTag,
    beside,
    declarations,
    named,
    read_data,
    tags,
)

_CODES: Final = Codes("P570", "P571", "P572", "P573", "P574", "P575")
_MARK = re.compile(r"<(?:Programs|programList|Database|dataList|Project)\b", re.IGNORECASE)
_DATA = re.compile(r"<(?:Database|dataList)\b", re.IGNORECASE)
_PROJECT = re.compile(r"<Project\b", re.IGNORECASE)
_OPEN = re.compile(r"<(?:Code|code)\b[^<>]*>\s*(<!\[CDATA\[)?")
_CLOSE = re.compile(r"(?:\]\]>\s*)?</(?:Code|code)>|\]\]>")
_KNOWN: Final = words(
    "IF ELSEIF ELSE ENDIF WHILE ENDWHILE FOR ENDFOR DO UNTIL SWITCH CASE DEFAULT ENDSWITCH BREAK MOVEJ MOVEL MOVEC CALL"
)
_MOVES: Final = words("MOVEJ MOVEL MOVEC MOVEJF ALTER ALTERMOVEJ ALTERMOVEL ALTERMOVEC")
_TYPES: Final = {"num": "real", "bool": "boolean", "string": "string"}


def read_program(source: Source) -> Program:
    """What is in a file. Never raises on bad text."""
    findings = Findings(source)
    if not is_readable(findings, _CODES, _MARK, "VAL3"):
        return unreadable("val3", source, findings)
    for number, line in enumerate(source.lines):
        findings.kinds[number] = LineKind.RECORD if line.strip() else LineKind.BLANK
    if any(_DATA.search(line) for line in source.lines[:50]):
        data = read_data(source)
        for one in data:
            findings.kinds[one.line - 1] = LineKind.POINT
        return Program(
            "val3", source, (), findings.result(), bytes(findings.kinds), tuple(declarations(data))
        )
    routines = _Val3File(findings).read()
    return Program("val3", source, tuple(routines), findings.result(), bytes(findings.kinds))


class _Val3File:
    def __init__(self, findings: Findings) -> None:
        self.findings, self.kinds = findings, findings.kinds
        self.known = beside(findings.source.path)
        self.tags: dict[int, list[XmlTag]] = {}
        for tag in tags(findings.source):
            self.tags.setdefault(tag.line, []).append(tag)

    def read(self) -> list[Routine]:
        routines: list[Routine] = []
        lines, number = self.findings.source.lines, 1
        head: list[XmlTag] = []
        while number <= len(lines):
            line = lines[number - 1]
            opened = _OPEN.search(line)
            head += [tag for tag in self.tags.get(number, ()) if not tag.closes]
            if opened is None:
                number += 1
                continue
            body = _Val3Body(self.findings, self._names(head))
            stop = self._code(body, opened, number)
            routines.append(self._routine(head, body, stop))
            head, number = [], stop + 1
        programs = [tag for found in self.tags.values() for tag in found if tag.name.lower() == "program"]
        if not routines and programs and not any(_PROJECT.search(line) for line in lines[:20]):
            self._tell_unclosed(programs[0].line, "a program without <Code>")
        return routines

    def _names(self, head: list[XmlTag]) -> Val3Declarations:
        """What holds in one program: its parameters and local variables hide the data of the same name."""
        known = Val3Declarations(dict(self.known.types), set(self.known.arrays), dict(self.known.fathers))
        for tag in _variables(head):
            name = tag.attributes["name"]
            known.types[name] = tag.attributes.get("type", "")
            known.fathers.pop(name, None)
            known.arrays.discard(name)
            if _size(tag) > 1 or (
                tag.name.lower() == "parameter" and tag.attributes.get("xsi:type") == "array"
            ):
                known.arrays.add(name)
        return known

    def _code(self, body: _Val3Body, opened: re.Match[str], number: int) -> int:
        """Reads the lines of the code; the number of the last one."""
        lines, start = self.findings.source.lines, number
        plain = opened[1] is not None
        text = lines[number - 1][opened.end() :]
        while True:
            closed = _CLOSE.search(text)
            code = text[: closed.start()] if closed else text
            if code.strip():
                body.line((code if plain else unescape(code)).strip(), number)
            elif not closed and number > start:
                self.kinds[number - 1] = LineKind.BLANK
            if closed:
                return number
            if number >= len(lines):
                self._tell_unclosed(start, "the code is never closed")
                return number
            number += 1
            text = lines[number - 1]

    def _tell_unclosed(self, number: int, message: str) -> None:
        span = self.findings.whole_line(number)
        self.findings.error("P573", message, span, "<Code><![CDATA[begin … end]]></Code>")

    def _routine(self, head: list[XmlTag], body: _Val3Body, last: int) -> Routine:
        program = next((tag for tag in reversed(head) if tag.name.lower() == "program"), None)
        name = program.attributes.get("name", "") if program else ""
        statements = body.finish()
        check_blocks(self.findings, statements, "P573")
        parameters, local = [], []
        for tag in _variables(head):
            if tag.name.lower() == "parameter":
                by_reference = tag.attributes.get("use", "") == "reference"
                type_ = _TYPES.get(tag.attributes.get("type", ""), "")
                parameters.append(Parameter(tag.attributes["name"], type_, by_reference=by_reference))
            else:
                local.append(_declared(tag))
        line = program.line if program else 1
        return Routine(
            name or "program",
            line,
            (*local, *statements),
            PointTable(),
            parameters=tuple(parameters),
            last_line=last,
        )


class _Val3Body:
    """The instructions of one program."""

    def __init__(self, findings: Findings, known: Val3Declarations) -> None:
        self.findings, self.kinds = findings, findings.kinds
        self.rules = Val3Rules(known)
        self.parser = LineParser(findings, "val3", self.rules, _CODES, _KNOWN, _MOVES)
        self.body: list[Statement] = []
        self.open: list[type] = []

    def line(self, text: str, number: int) -> None:
        code, comment = _parted(text)
        if not code or code in ("begin", "end"):
            record = LineKind.COMMENT if not code else LineKind.RECORD
            self.kinds[number - 1] = record
            if comment is not None:
                self.body.append(Comment(number, comment))
            return
        before = len(self.body)
        for one in self.parser.parse(code, number):
            self._add(one, number)
        if comment and len(self.body) > before:
            self.body[-1] = with_comment(self.body[-1], comment)

    def _add(self, one: Any, number: int) -> None:
        if isinstance(one, Leave):
            if self.open[-1:] != [Switch]:  # of a switch it ends the case, which the next one does anyway
                self.body.append(Break(number))
            return
        if isinstance(one, (While, For, Repeat, Switch)):
            self.open.append(type(one))
        elif isinstance(one, (EndWhile, Next, Until, EndSwitch)) and self.open:
            self.open.pop()
        if isinstance(one, Move):
            self._tell_queue(number)
            if self.rules.frameless:
                self._tell_frame(number)
        self.body.append(one)

    def _tell_queue(self, number: int) -> None:
        message = "moves are queued: what stands behind one is read as done after it"
        help = "waitEndMove() makes the program wait for it"
        self.findings.once(Severity.INFO, "P576", "", message, self.findings.whole_line(number), help)

    def _tell_frame(self, number: int) -> None:
        self.rules.frameless = False
        message = (
            "no data beside the program says in which frame the point of this move stands: the world is taken"
        )
        help = "put the project's .dtx file beside it"
        self.findings.once(Severity.WARNING, "P577", "", message, self.findings.whole_line(number), help)

    def finish(self) -> list[Statement]:
        """Without what stands between `switch` and its first `case`, which is nothing but comments."""
        kept: list[Statement] = []
        for one in self.body:
            if isinstance(one, Comment) and kept and isinstance(kept[-1], Switch):
                continue
            kept.append(one)
        return kept


def _variables(head: list[XmlTag]) -> Iterator[XmlTag]:
    for tag in head:
        if tag.name.lower() in ("parameter", "local") and tag.attributes.get("name"):
            yield tag


def _size(tag: XmlTag) -> int:
    text = tag.attributes.get("size", "1")
    return min(int(text), 5000) if text.isdigit() and len(text) < 7 else 1


def _declared(tag: XmlTag) -> Declare:
    """A local variable: numbers are 0, poses and joints are all zeros."""
    kind = tag.attributes.get("type", "")
    value: Expression | None = None
    type_ = _TYPES.get(kind, "position" if kind in POSES else "joints" if kind in JOINTS else kind)
    sizes = (Number(_size(tag)),) if _size(tag) > 1 else ()
    if kind in POSES and not sizes:
        value = xyz_pose((0.0,) * 6)
    return Declare(tag.line, tag.attributes["name"], type_, value, sizes, native=kind)


def _parted(text: str) -> tuple[str, str | None]:
    """The instruction and its comment; slashes in a text are part of the text."""
    quoted = False
    for at, char in enumerate(text):
        if char == '"' and text[at - 1 : at] != "\\":
            quoted = not quoted
        elif char == "/" and not quoted and text.startswith("//", at):
            return text[:at].rstrip(), text[at + 2 :]
    return text, None


# --- One instruction: a short method per rule of grammars/val3.lark ---


_PATHS: Final = {"movej": Path.JOINT, "movel": Path.LINEAR, "movec": Path.CIRCULAR}
_FUNCTIONS: Final = {
    "sqrt": "sqrt", "abs": "abs", "sin": "sin", "cos": "cos", "tan": "tan", "asin": "asin", "acos": "acos",
    "atan": "atan", "round": "round", "roundUp": "ceil", "roundDown": "floor", "min": "min", "max": "max",
    "power": "power", "exp": "exp", "ln": "log", "distance": "pose-distance", "len": "length-of-text",
}  # fmt: skip
_WORDS: Final[dict[str, Expression]] = {"off": Number(0), "joint": Number(1), "cartesian": Number(1)}
_MESSAGES: Final = frozenset(("popUpMsg", "logMsg", "put", "putln"))
_ACTS: Final = frozenset(("open", "close", "stopMove", "restartMove"))  # what they do has no word elsewhere
_TIMED_OUT: Final = SystemValue("timed-out")
_POSE_FUNCTIONS: Final = frozenset(("pose-product", "pose-inverse", "pose-angles", "forward"))


_ANGLES: Final = ("rx", "ry", "rz")


def _angle(pose: Expression, name: str) -> Unary:
    """An angle of R = Rx Ry Rz: that of the inverse, Rz(-rz) Ry(-ry) Rx(-rx), by the angles of all other languages."""
    return Unary("-", Member(Function("pose-inverse", (pose,)), name))


def _turned(target: Expression, value: Expression) -> Assign | None:
    """The assignment of the whole pose where one of its angles is set; None for any other target."""
    read = target.operand if isinstance(target, Unary) and target.operator == "-" else None
    if not isinstance(read, Member) or not isinstance(read.base, Function):
        return None
    pose = read.base.arguments[0]
    angles = [value if name == read.name else _angle(pose, name) for name in _ANGLES]
    return Assign(0, pose, _computed_pose([*(Member(pose, axis) for axis in "xyz"), *angles]))


def _computed_pose(values: Sequence[Expression]) -> Expression:
    """x, y, z [mm] and R = Rx(rx) Ry(ry) Rz(rz) [deg]."""
    x, y, z, rx, ry, rz = values
    zero = Number(0)
    pose: Expression = Function("pose-angles", (x, y, z, rx, zero, zero))
    for turn in ((zero, ry, zero), (zero, zero, rz)):
        pose = Function("pose-product", (pose, Function("pose-angles", (zero, zero, zero, *turn))))
    return pose


class Leave(NamedTuple):
    """break: leaves a loop, or ends a case."""


class Val3Rules(BlockRules):
    """All of VAL3. `known`: what is known of names; indices count from 0 there, from 1 here."""

    def __init__(self, known: Val3Declarations) -> None:
        super().__init__(fold=False)
        self.known = known
        self.frameless = False  # a move went to a point of which nobody says the frame

    # --- values -----------------------------------------------------------------------------------------

    def text(self, children: list[Any]) -> Text:
        return Text(re.sub(r"\\(.)", r"\1", str(children[0])[1:-1]))

    def value(self, children: list[Any]) -> Expression:
        return self.conjunction(children)

    def name(self, children: list[Any]) -> Expression:
        word = str(children[0])
        if word in _WORDS and word not in self.known.types:
            return _WORDS[word]
        if word == "flange" and word not in self.known.types:
            return FrameRef("tool", Number(0))
        if word == "world" and word not in self.known.types:
            return FrameRef("base")
        if self.known.types.get(word) in SIGNALS:
            return self._signal(word)
        return Item(Named(word), (Number(1),)) if word in self.known.arrays else Named(word)

    def item(self, children: list[Any]) -> Expression:
        word, indices = str(children[0]), children[1]
        zero = indices == [Number(0)]
        if zero and word not in self.known.arrays:
            return self.name(children[:1])
        if self.known.types.get(word) in SIGNALS:
            raise NotModelledError(word)
        return Item(Named(word), tuple(map(from_zero, indices)))

    def _signal(self, word: str) -> Signal:
        return Signal("analog-in" if self.known.types[word] == "aio" else "in", Text(word))

    def member(self, children: list[Any]) -> Expression:
        base, name = children[0], str(children[1])
        if name in _ANGLES:
            return _angle(base, name)
        return base if name == "trsf" else Member(base, name)

    def member_item(self, children: list[Any]) -> Expression:
        base, name, indices = children
        return Item(Member(base, str(name)), tuple(map(from_zero, indices)))

    def braces(self, children: list[Expression]) -> Expression:
        if len(children) in (3, 8):
            raise NotModelledError(children)  # a configuration, a motion descriptor
        if len(children) != 6:
            raise BrokenLineError(
                f"{len(children)} values in braces", wanted="six: x, y, z, rx, ry, rz, or six joint values"
            )
        numbers = constants(children)
        if numbers is not None:
            return xyz_pose(numbers, tuple((f"j{n}", repr(v)) for n, v in enumerate(numbers, 1)))
        return _computed_pose(children)

    def not_(self, children: list[Any]) -> Any:
        if self._is_pose(children[0]):
            return Function("pose-inverse", (children[0],))
        return Unary("not", children[0])

    def product(self, children: list[Any]) -> Expression:
        value: Expression = children[0]
        for word, right in zip(children[1::2], children[2::2], strict=True):
            if word == "*" and (self._is_pose(value) or self._is_pose(right)):
                value = Function("pose-product", (value, right))
            else:
                value = Binary("mod" if word == "%" else str(word), value, right)
        return value

    def _type(self, value: Expression) -> str:
        base = value.base if isinstance(value, Item) else value
        return self.known.types.get(base.name, "") if isinstance(base, Named) else ""

    def _is_pose(self, value: Expression) -> bool:
        if isinstance(value, Function):
            return value.name in _POSE_FUNCTIONS
        return isinstance(value, PositionLiteral) or self._type(value) in POSES

    def function(self, children: list[Any]) -> Any:
        name, arguments = str(children[0]), tuple(children[1] or ())
        if name in ("dioGet", "aioGet") and len(arguments) == 1:
            return self._port(name, arguments[0], "in")
        if name == "appro" and len(arguments) == 2:
            return Function("pose-product", arguments)
        if name == "here" and len(arguments) == 2:
            tool, frame = arguments
            return Function("current-pose", (NamedArgument("Tool", tool), NamedArgument("WObj", frame)))
        if name == "here":
            return SystemValue("current-pose")
        if name == "herej":
            return SystemValue("current-joints")
        if name == "jointToPoint" and len(arguments) == 3:
            return Function("forward", arguments[2:])
        return Function(_FUNCTIONS[name], arguments) if name in _FUNCTIONS else CallValue(name, arguments)

    def _port(self, name: str, value: Expression, direction: str) -> Signal:
        bus = f"analog-{direction}" if name.startswith("aio") else direction
        if isinstance(value, Signal):
            return Signal(bus, value.index)
        if not isinstance(value, Named):
            raise NotModelledError(value)
        return Signal(bus, Text(value.name))

    # --- moves ------------------------------------------------------------------------------------------

    def _move(self, name: str, arguments: tuple[Expression, ...]) -> Move:
        count = 4 if name == "movec" else 3
        if len(arguments) != count:
            wanted = "via, end" if count == 4 else "target"
            raise BrokenLineError(
                f"{name} with {len(arguments)} arguments", wanted=f"{wanted}, tool and mdesc"
            )
        *points, tool, mdesc = arguments
        path = _PATHS[name]
        if path is Path.JOINT:
            points[-1] = _as_joints(points[-1])
            speed = Speed(SpeedUnit.FRACTION, Quantity(Member(mdesc, "vel"), percent))
        else:
            speed = Speed(SpeedUnit.TRAVEL, Quantity(Member(mdesc, "tmax"), mm))
        corner = Binary("*", Member(mdesc, "blend"), Member(mdesc, "leave"))
        return Move(
            0,
            path,
            (points[-1],),
            speed,
            Blend(BlendKind.RADIUS, Quantity(corner, mm)),
            acceleration=Quantity(Member(mdesc, "accel"), percent),
            deceleration=Quantity(Member(mdesc, "decel"), percent),
            via=points[0] if count == 4 else None,
            turn=None if path is Path.JOINT else Quantity(Member(mdesc, "rmax"), deg),
            tool=tool,
            frame=self._frame(points[-1]),
        )

    def _father(self, point: Expression) -> str:
        """The frame of a point: that of its data, or of the point that it was made from; empty where nobody says."""
        while isinstance(point, Function) and point.arguments:
            point = point.arguments[0]
        if isinstance(point, Item) and isinstance(point.base, Named):
            name, index = point.base.name, point.indices[0]
            if isinstance(index, Number) and (own := self.known.fathers.get(f"{name}[{index.value - 1}]")):
                return own
            return self.known.fathers.get(name, "")
        return self.known.fathers.get(point.name, "") if isinstance(point, Named) else ""

    def _frame(self, point: Expression) -> Expression:
        if isinstance(point, Function) and point.name == "forward":
            return FrameRef("base")
        if isinstance(point, PositionLiteral) or self._type(point) in JOINTS:
            return FrameRef("base")
        father = self._father(point)
        if father == MIXED:
            raise NotModelledError(father)
        if not father and not isinstance(point, SystemValue):
            self.frameless = True
        return FrameRef("base") if father in ("", WORLD) else named(father)

    # --- instructions -----------------------------------------------------------------------------------

    def assign(self, children: list[Any]) -> Any:
        target, value = children
        if isinstance(value, CallValue) and value.routine in _PATHS:
            return self._move(value.routine, value.arguments)
        if wait := _watched(value):
            return [wait, Assign(0, target, Unary("not", _TIMED_OUT))]
        if isinstance(target, Signal):
            bus = target.bus.replace("in", "out")
            return SetOutput(0, Signal(bus, target.index), value)
        if (turned := _turned(target, value)) is not None:
            return turned
        if not isinstance(target, (Named, Item, Member)):
            raise BrokenLineError("nothing can be stored here", wanted="a variable")
        kind = self._type(target)
        if kind in JOINTS:
            value = _as_joints(value)
        if isinstance(target, Named) and kind.startswith("point"):
            self._inherit(target.name, value)
        return Assign(0, target, value)

    def _inherit(self, name: str, value: Expression) -> None:
        if father := self._father(value):
            self.known.fathers[name] = father

    def call(self, children: list[Any]) -> Call:
        return Call(0, str(children[0]), tuple(children[1] or ()))

    def task(self, children: list[Any]) -> StartTask:
        task = children[0].value if isinstance(children[0], Text) else ""
        return StartTask(0, str(children[-2]), task)

    def builtin(self, children: list[Any]) -> Any:
        name, arguments = str(children[0]), tuple(children[1] or ())
        if name in _PATHS:
            return self._move(name, arguments)
        if name == "delay" and len(arguments) == 1:
            return Dwell(0, Quantity(arguments[0], 1.0))
        if name in ("wait", "watch") and arguments:
            return Wait(0, arguments[0], Quantity(arguments[1], 1.0) if len(arguments) > 1 else None)
        stop = Dwell(0, Quantity(Number(0), 1.0))
        if name == "waitEndMove":
            return stop
        if name in _ACTS:
            return [stop, Process(0, name, tuple(("", one) for one in arguments))]
        if name in _MESSAGES:
            return Message(0, arguments[-1] if arguments else Text(""))
        if name in ("dioSet", "aioSet") and len(arguments) == 2:
            return SetOutput(0, self._port(name, arguments[0], "out"), arguments[1])
        if name == "setMonitorSpeed" and len(arguments) == 1:
            return SetOverride(0, Quantity(arguments[0], percent))
        raise NotModelledError(name)

    def if_(self, children: list[Any]) -> Any:
        """Before one that watches for a signal, the wait."""
        value, wanted = _wanted(children[0])
        if wait := _watched(value):
            return [wait, If(0, Unary("not", _TIMED_OUT) if wanted else _TIMED_OUT)]
        return If(0, children[0])

    def for_(self, children: list[Any]) -> For:
        variable, start, stop, step = children
        if not isinstance(variable, Named):
            raise BrokenLineError("a loop that counts in an array", wanted="a variable, as in for i=1 to 3")
        return For(0, variable, start, stop, step)

    def switch(self, children: list[Any]) -> Switch:
        return Switch(0, children[0])

    def case(self, children: list[Any]) -> Case:
        return Case(0, tuple(children[0]))

    def default(self, _: list[Any]) -> Default:
        return Default(0)

    def end_switch(self, _: list[Any]) -> EndSwitch:
        return EndSwitch(0)

    def break_(self, _: list[Any]) -> Leave:
        return Leave()


def _as_joints(value: Expression) -> Expression:
    """Six numbers in braces where joint values are wanted: degrees of the axes, and no pose."""
    if isinstance(value, PositionLiteral) and value.native[:1] and value.native[0][0] == "j1":
        return joints(float(v) for _, v in value.native)
    return value


def _wanted(value: Expression) -> tuple[Expression, bool]:
    """x of `x`, `x==true`, `!x` and `x==false`, and whether it is wanted true."""
    if isinstance(value, Unary) and value.operator == "not":
        return value.operand, False
    if isinstance(value, Compare) and value.operator == "=" and isinstance(value.right, SignalState):
        return value.left, value.right.on
    return value, True


def _watched(value: Expression) -> Wait | None:
    """watch(condition, time): waits, and says whether the condition came."""
    if isinstance(value, CallValue) and value.routine == "watch" and len(value.arguments) == 2:
        return Wait(0, value.arguments[0], Quantity(value.arguments[1], 1.0))
    return None
