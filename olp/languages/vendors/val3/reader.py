"""A whole VAL3 file: a program, data or a project; and everything that is wrong with it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from html import unescape
from typing import Any, Final, NamedTuple

from olp.core.diagnostic import Severity
from olp.core.source import Source
from olp.core.units import deg, mm, percent
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.points import PointTable
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
    MIXED,
    SIGNALS,
    WORLD,
    Val3Declarations,
    XmlTag,
    beside,
    declarations,
    frame_of,
    handed_points,
    named,
    points_of_call,
    read_data,
    structures,
    tags,
)
from olp.languages.vendors.val3.known_functions import JOINTS, POSES

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
_BUILT_IN: Final = words(
    "dio aio sio mdesc tool frame trsf config configRx configRs point pointRx pointRs joint jointRx jointRs screen"
)
_TYPED: Final = (st.Parameter, st.Declare)
_PLAIN: Final = frozenset(("real", "boolean", "string", "position", "joints", "", *_BUILT_IN))
_TYPES: Final = {"num": "real", "bool": "boolean", "string": "string"}


def read_program(source: Source) -> st.Program:
    """What is in a file. Never raises on bad text."""
    findings = Findings(source)
    if not is_readable(findings, _CODES, _MARK, "VAL3"):
        return unreadable("val3", source, findings)
    for number, line in enumerate(source.lines):
        findings.kinds[number] = st.LineKind.RECORD if line.strip() else st.LineKind.BLANK
    if any(_DATA.search(line) for line in source.lines[:50]):
        data = read_data(source)
        for one in data:
            findings.kinds[one.line - 1] = st.LineKind.POINT
        return st.Program(
            "val3", source, (), findings.result(), bytes(findings.kinds), tuple(declarations(data))
        )
    routines = _Val3File(findings).read()
    kinds = {one.type for r in routines for one in (*r.parameters, *r.body) if isinstance(one, _TYPED)}
    own = structures(source.path, kinds - _PLAIN)
    return st.Program("val3", source, tuple(routines), findings.result(), bytes(findings.kinds), tuple(own))


class _Val3File:
    def __init__(self, findings: Findings) -> None:
        self.findings, self.kinds = findings, findings.kinds
        self.known = beside(findings.source.path)
        self.handed = [
            name for _, name in handed_points(findings.source)
        ]  # points that come with their frames
        for line in findings.source.lines:
            self.known.outputs.update(_SET_SIGNAL.findall(line))
            self.known.unbounded.difference_update(_SET_SPEED.findall(line))
        self.tags: dict[int, list[XmlTag]] = {}
        for tag in tags(findings.source):
            self.tags.setdefault(tag.line, []).append(tag)

    def read(self) -> list[st.Routine]:
        routines: list[st.Routine] = []
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
        known = Val3Declarations(
            dict(self.known.types),
            set(self.known.arrays),
            dict(self.known.fathers),
            self.known.outputs,
            set(self.known.unbounded),
            self.known.path,
        )
        for tag in _variables(head):
            name = tag.attributes["name"]
            known.types[name] = tag.attributes.get("type", "")
            known.fathers.pop(name, None)
            known.unbounded.discard(name)
            known.arrays.discard(name)
            if _size(tag) > 1 or (
                tag.name.lower() == "parameter" and tag.attributes.get("xsi:type") == "array"
            ):
                known.arrays.add(name)
            if name in self.handed and tag.name.lower() == "parameter":
                known.fathers[name] = f"{frame_of(name)}[0]"
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
                self.kinds[number - 1] = st.LineKind.BLANK
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

    def _routine(self, head: list[XmlTag], body: _Val3Body, last: int) -> st.Routine:
        program = next((tag for tag in reversed(head) if tag.name.lower() == "program"), None)
        name = program.attributes.get("name", "") if program else ""
        statements = body.body
        check_blocks(self.findings, statements, "P573")
        parameters, local = [], []
        for tag in _variables(head):
            if tag.name.lower() == "parameter":
                by_reference = tag.attributes.get("use", "") == "reference"
                kind = tag.attributes.get("type", "")
                type_ = _TYPES.get(
                    kind, "" if kind in _BUILT_IN else kind
                )  # what is left open, its use tells
                parameters.append(st.Parameter(tag.attributes["name"], type_, by_reference=by_reference))
            else:
                local.append(_declared(tag))
        parameters += [
            st.Parameter(frame_of(one.name), "frame") for one in parameters if one.name in self.handed
        ]
        line = program.line if program else 1
        return st.Routine(
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
        self.body: list[st.Statement] = []
        self.open: list[type] = []
        self.blocks: list[FramesOfBlock] = []

    def line(self, text: str, number: int) -> None:
        code, comment = _parted(text)
        if not code or code in ("begin", "end"):
            record = st.LineKind.COMMENT if not code else st.LineKind.RECORD
            self.kinds[number - 1] = record
            if comment is not None:
                self.body.append(st.Comment(number, comment))
            return
        before = len(self.body)
        for one in self.parser.parse(code, number):
            self._add(one, number)
        if comment and len(self.body) > before:
            self.body[-1] = with_comment(self.body[-1], comment)
        elif comment:  # behind the `break` of a case
            self.body.append(st.Comment(number, comment))

    def _add(self, one: Any, number: int) -> None:
        if isinstance(one, Leave):
            if self.open[-1:] != [st.Switch]:  # of a switch it ends the case, which the next one does anyway
                self.body.append(st.Break(number))
            return
        if isinstance(one, (st.While, st.For, st.Repeat, st.Switch)):
            self.open.append(type(one))
        elif isinstance(one, (st.EndWhile, st.Next, st.Until, st.EndSwitch)) and self.open:
            self.open.pop()
        self._follow_frames(one, number)
        if isinstance(one, st.Move):
            self._tell_queue(number)
            if self.rules.frameless:
                self._tell_frame(number)
            if self.rules.unbounded:
                self._tell_unbounded(number)
        self.body.append(one)

    def _follow_frames(self, one: Any, number: int) -> None:
        """Where ways join, a point stands in the frame that it has on all of them, or in one of several."""
        fathers = self.rules.known.fathers
        if isinstance(one, _OPENS):
            loop = not isinstance(one, (st.If, st.Switch))
            self.blocks.append(FramesOfBlock(dict(fathers), loop, len(self.rules.framed)))
        elif self.blocks and isinstance(one, (st.ElseIf, st.Else, st.Case, st.Default)):
            self.blocks[-1].leave(fathers, self.body)
            self.blocks[-1].complete |= isinstance(one, (st.Else, st.Default))
            fathers.clear()
            fathers.update(self.blocks[-1].before)
        elif self.blocks and isinstance(one, _CLOSES):
            block = self.blocks.pop()
            block.leave(fathers, self.body)
            joined = block.joined()
            changed = {name for name in joined if joined[name] != block.before.get(name, joined[name])}
            if block.loop and changed & set(self.rules.framed[block.asked :]):
                message = "a point stands in another frame when the loop comes round: that of the first round is taken"
                help = "give each frame a point of its own"
                self.findings.once(
                    Severity.WARNING, "P577", "loop", message, self.findings.whole_line(number), help
                )
            fathers.clear()
            fathers.update(joined)

    def _tell_queue(self, number: int) -> None:
        message = "moves are queued: what stands behind one is read as done after it"
        help = "waitEndMove() makes the program wait for it"
        self.findings.once(Severity.INFO, "P576", "", message, self.findings.whole_line(number), help)

    def _tell_unbounded(self, number: int) -> None:
        self.rules.unbounded = False
        message = "a path with tmax 99999 is bounded by vel alone, of which 100 % are taken as 1 m/s"
        help = "give the motion descriptor a tmax"
        self.findings.once(Severity.INFO, "P578", "", message, self.findings.whole_line(number), help)

    def _tell_frame(self, number: int) -> None:
        self.rules.frameless = False
        message = (
            "no data beside the program says in which frame the point of this move stands: the world is taken"
        )
        help = "put the project's .dtx file beside it"
        self.findings.once(Severity.WARNING, "P577", "", message, self.findings.whole_line(number), help)


def _variables(head: list[XmlTag]) -> Iterator[XmlTag]:
    for tag in head:
        if tag.name.lower() in ("parameter", "local") and tag.attributes.get("name"):
            yield tag


def _size(tag: XmlTag) -> int:
    text = tag.attributes.get("size", "1")
    return min(int(text), 5000) if text.isdigit() and len(text) < 7 else 1


def _declared(tag: XmlTag) -> st.Declare:
    """A local variable: numbers are 0, poses and joints are all zeros."""
    kind = tag.attributes.get("type", "")
    value: ex.Expression | None = None
    type_ = _TYPES.get(kind, "position" if kind in POSES else "joints" if kind in JOINTS else kind)
    sizes = (ex.Number(_size(tag)),) if _size(tag) > 1 else ()
    if kind in POSES and not sizes:
        value = xyz_pose((0.0,) * 6)
    return st.Declare(tag.line, tag.attributes["name"], type_, value, sizes, native=kind)


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


_SET_SIGNAL: Final = re.compile(r"(?:^\s*(?=\w+(?:\[0\])?\s*=(?!=))|\b[ad]ioSet\(\s*)(\w+)")
_SET_SPEED: Final = re.compile(
    r"\b(\w+)(?:\[[^\][]{0,80}\])?(?:\.tmax)?\s*=(?!=)"
)  # a descriptor, or its bound
_DECIMALS: Final = re.compile(r"(?:\.(\d))?")  # the form of toString
_FULL_SPEED: Final = 1.0  # [m/s] of 100 % along a path, as no program says how fast its arm is
_PATHS: Final = {"movej": st.Path.JOINT, "movel": st.Path.LINEAR, "movec": st.Path.CIRCULAR}
_FUNCTIONS: Final = {
    "sqrt": "sqrt", "abs": "abs", "sin": "sin", "cos": "cos", "tan": "tan", "asin": "asin", "acos": "acos",
    "atan": "atan", "round": "round", "roundUp": "ceil", "roundDown": "floor", "min": "min", "max": "max",
    "power": "power", "exp": "exp", "ln": "log", "distance": "pose-distance", "len": "length-of-text",
}  # fmt: skip
_WORDS: Final[dict[str, ex.Expression]] = {
    "off": ex.Number(0),
    "joint": ex.Number(1),
    "cartesian": ex.Number(1),
}
_MESSAGES: Final = frozenset(("popUpMsg", "logMsg", "put", "putln"))
_ACTS: Final = frozenset(("open", "close", "stopMove", "restartMove"))  # what they do has no word elsewhere
_TIMED_OUT: Final = ex.SystemValue("timed-out")
_POSE_FUNCTIONS: Final = frozenset(
    ("pose-product", "pose-inverse", "pose-angles", "pose-offset", "current-pose", "forward")
)


def _of_text(name: str, arguments: tuple[ex.Expression, ...]) -> ex.Expression | None:
    """A function of texts, whose characters are counted from 0."""
    one = ex.Number(1)
    if name == "toString" and len(arguments) == 2 and isinstance(arguments[0], ex.Text):
        # Of the form ".3" the decimals; one with a width fills up with blanks, which no other language does.
        form = _DECIMALS.fullmatch(arguments[0].value)
        decimals = (ex.Number(int(form[1])),) if form and form[1] else ()
        return None if form is None else ex.Function("text-of-value", (arguments[1], *decimals))
    if name == "chr" and len(arguments) == 1:
        return ex.Function("character-of-code", arguments)
    if name == "left" and len(arguments) == 2:
        return ex.Function("part-of-text", (arguments[0], one, arguments[1]))
    if name == "mid" and len(arguments) == 3:
        text, size, first = arguments
        return ex.Function("part-of-text", (text, from_zero(first), size))
    if name == "asc" and len(arguments) == 2:
        return ex.Function(
            "code-of-character", (ex.Function("part-of-text", (arguments[0], from_zero(arguments[1]), one)),)
        )
    return None


_ANGLES: Final = ("rx", "ry", "rz")
_AXES: Final = tuple(f"j{n}" for n in range(1, 7))


def _angle(pose: ex.Expression, name: str) -> ex.Unary:
    """An angle of R = Rx Ry Rz: that of the inverse, Rz(-rz) Ry(-ry) Rx(-rx), by the angles of all other languages."""
    return ex.Unary("-", ex.Member(ex.Function("pose-inverse", (pose,)), name))


def _turned(target: ex.Expression, value: ex.Expression) -> st.Assign | None:
    """The assignment of the whole pose where one of its angles is set; None for any other target."""
    read = target.operand if isinstance(target, ex.Unary) and target.operator == "-" else None
    if not isinstance(read, ex.Member) or not isinstance(read.base, ex.Function):
        return None
    pose = read.base.arguments[0]
    angles = [value if name == read.name else _angle(pose, name) for name in _ANGLES]
    return st.Assign(0, pose, _computed_pose([*(ex.Member(pose, axis) for axis in "xyz"), *angles]))


def _computed_pose(values: Sequence[ex.Expression]) -> ex.Expression:
    """x, y, z [mm] and R = Rx(rx) Ry(ry) Rz(rz) [deg]; turns by nothing are left out."""
    x, y, z, rx, ry, rz = values
    zero = ex.Number(0)
    if (rx, ry, rz).count(zero) > 1:
        return ex.Function("pose-angles", tuple(values))
    pose: ex.Expression = ex.Function("pose-angles", (x, y, z, rx, zero, zero))
    for turn in ((zero, ry, zero), (zero, zero, rz)):
        if turn == (zero, zero, zero):
            continue
        pose = ex.Function("pose-product", (pose, ex.Function("pose-angles", (zero, zero, zero, *turn))))
    return pose


def _moved_by(by: ex.Expression, point: ex.Expression) -> ex.Expression:
    """A transformation, then the pose; one that turns nothing adds its x, y, z [mm]."""
    if isinstance(by, ex.PositionLiteral) and not any(by.values[3:]):
        offset: tuple[ex.Expression, ...] = tuple(ex.Number(round(v / mm, 6)) for v in by.values[:3])
        return ex.Function("pose-offset", (point, *offset))
    if isinstance(by, ex.Function) and by.name == "pose-angles" and not any(map(_turns, by.arguments[3:])):
        return ex.Function("pose-offset", (point, *by.arguments[:3]))
    return ex.Function("pose-product", (by, point))


def _turns(angle: ex.Expression) -> bool:
    return angle != ex.Number(0)


_OPENS: Final = (st.If, st.While, st.For, st.Repeat, st.Switch)
_CLOSES: Final = (st.EndIf, st.EndWhile, st.Next, st.Until, st.EndSwitch)


@dataclass(slots=True)
class FramesOfBlock:
    """In which frames points stand where a block begins, and where its ways end: `outcomes`.

    `asked`: how many points had been asked for their frame before it; `complete`: one of its ways is always gone.
    """

    before: dict[str, str]
    loop: bool
    asked: int
    complete: bool = False
    outcomes: list[dict[str, str]] = field(default_factory=list)

    def leave(self, fathers: Mapping[str, str], body: Sequence[st.Statement]) -> None:
        if body and isinstance(body[-1], st.Switch):  # nothing stands before the first case
            return
        if not (body and isinstance(body[-1], st.Return)):
            self.outcomes.append(dict(fathers))

    def joined(self) -> dict[str, str]:
        """A point that some ways leave without a frame has not been given a place there: the others count."""
        ways = self.outcomes if self.complete and self.outcomes else [*self.outcomes, self.before]
        names = {name for way in ways for name in way}
        found = {name: {way[name] for way in ways if way.get(name)} or {""} for name in names}
        return {name: next(iter(one)) if len(one) == 1 else MIXED for name, one in found.items()}


class Leave(NamedTuple):
    """break: leaves a loop, or ends a case."""


class Val3Rules(BlockRules):
    """All of VAL3. `known`: what is known of names; indices count from 0 there, from 1 here."""

    def __init__(self, known: Val3Declarations) -> None:
        super().__init__(fold=False)
        self.known = known
        self.unbounded = False  # a path was bounded by nothing but a share of the axes' speeds
        self.frameless = False  # a move went to a point of which nobody says the frame
        self.framed: list[str] = []  # points that moves and calls go by, in their order
        self.made: dict[
            ex.Expression, str
        ] = {}  # points that functions return -> the frame that they stand in

    # --- values -----------------------------------------------------------------------------------------

    def text(self, children: list[Any]) -> ex.Text:
        return ex.Text(re.sub(r"\\(.)", r"\1", str(children[0])[1:-1]))

    def value(self, children: list[Any]) -> ex.Expression:
        return self.conjunction(children)

    def name(self, children: list[Any]) -> ex.Expression:
        word = str(children[0])
        if word in _WORDS and word not in self.known.types:
            return _WORDS[word]
        if word == "flange" and word not in self.known.types:
            return ex.FrameRef("tool", ex.Number(0))
        if word == "world" and word not in self.known.types:
            return ex.FrameRef("base")
        if self.known.types.get(word) in SIGNALS:
            return self._signal(word)
        return ex.Item(ex.Named(word), (ex.Number(1),)) if word in self.known.arrays else ex.Named(word)

    def item(self, children: list[Any]) -> ex.Expression:
        word, indices = str(children[0]), children[1]
        zero = indices == [ex.Number(0)]
        if zero and word not in self.known.arrays:
            return self.name(children[:1])
        if self.known.types.get(word) in SIGNALS:
            raise NotModelledError("it names a signal by its place in an array")
        return ex.Item(ex.Named(word), tuple(map(from_zero, indices)))

    def _signal(self, word: str) -> ex.Signal:
        """An output where it is wired as one or set: its state is read by the same name."""
        direction = "out" if word in self.known.outputs else "in"
        return ex.Signal(
            f"analog-{direction}" if self.known.types[word] == "aio" else direction, ex.Text(word)
        )

    def member(self, children: list[Any]) -> ex.Expression:
        base, name = children[0], str(children[1])
        if name in _ANGLES:
            return _angle(base, name)
        if name in _AXES and self._type(base) in JOINTS:
            return ex.Item(base, (ex.Number(_AXES.index(name) + 1),))
        return base if name == "trsf" else ex.Member(base, name)

    def member_item(self, children: list[Any]) -> ex.Expression:
        base, name, indices = children
        return ex.Item(ex.Member(base, str(name)), tuple(map(from_zero, indices)))

    def braces(self, children: list[ex.Expression]) -> ex.Expression:
        if len(children) in (3, 8):
            what = "a configuration" if len(children) == 3 else "a motion descriptor"
            raise NotModelledError(f"it writes out {what}")
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
            return ex.Function("pose-inverse", (children[0],))
        return ex.Unary("not", children[0])

    def product(self, children: list[Any]) -> ex.Expression:
        value: ex.Expression = children[0]
        for word, right in zip(children[1::2], children[2::2], strict=True):
            if word == "*" and (self._is_pose(value) or self._is_pose(right)):
                value = ex.Function("pose-product", (value, right))
            else:
                value = ex.Binary("mod" if word == "%" else str(word), value, right)
        return value

    def _type(self, value: ex.Expression) -> str:
        base = value.base if isinstance(value, ex.Item) else value
        return self.known.types.get(base.name, "") if isinstance(base, ex.Named) else ""

    def _is_pose(self, value: ex.Expression) -> bool:
        if isinstance(value, ex.Function):
            return value.name in _POSE_FUNCTIONS
        return isinstance(value, ex.PositionLiteral) or self._type(value) in POSES

    def function(self, children: list[Any]) -> Any:
        name, arguments = str(children[0]), tuple(children[1] or ())
        if name in ("dioGet", "aioGet") and len(arguments) == 1:
            return (
                arguments[0] if isinstance(arguments[0], ex.Signal) else self._port(name, arguments[0], "in")
            )
        if name == "appro" and len(arguments) == 2:
            return ex.Function("pose-product", arguments)
        if name == "compose" and len(arguments) == 3:
            return self._composed(*arguments)
        if name == "here" and len(arguments) == 2:
            tool, frame = arguments
            read = ex.Function(
                "current-pose", (ex.NamedArgument("Tool", tool), ex.NamedArgument("WObj", frame))
            )
            self.made[read] = _frame_name(frame)
            return read
        if name == "here":
            return ex.SystemValue("current-pose")
        if name == "herej":
            return ex.SystemValue("current-joints")
        if name == "jointToPoint" and len(arguments) == 3:
            return ex.Function("forward", arguments[2:])
        return (
            ex.Function(_FUNCTIONS[name], arguments)
            if name in _FUNCTIONS
            else _of_text(name, arguments) or ex.CallValue(name, arguments)
        )

    def _composed(self, point: ex.Expression, frame: ex.Expression, by: ex.Expression) -> ex.Expression:
        """compose(point, frame, trsf): the point moved as `frame` sees it. It stays in the frame that it stood in."""
        father, reference = self._father(point) or WORLD, _frame_name(frame)
        if father == MIXED or not reference:
            raise NotModelledError("it is computed in which frame a point is moved")
        seen = point
        if father != reference:
            seen = point if father == WORLD else ex.Function("pose-product", (named(father), point))
            if reference != WORLD:
                seen = ex.Function("pose-product", (ex.Function("pose-inverse", (frame,)), seen))
        moved = _moved_by(by, seen)
        if father != reference:
            moved = moved if reference == WORLD else ex.Function("pose-product", (frame, moved))
            if father != WORLD:
                moved = ex.Function("pose-product", (ex.Function("pose-inverse", (named(father),)), moved))
        self.made[moved] = self._father(point)
        return moved

    def _port(self, name: str, value: ex.Expression, direction: str) -> ex.Signal:
        bus = f"analog-{direction}" if name.startswith("aio") else direction
        if isinstance(value, ex.Signal):
            return ex.Signal(bus, value.index)
        if not isinstance(value, ex.Named):
            raise NotModelledError("it computes which signal it means")
        return ex.Signal(bus, ex.Text(value.name))

    # --- moves ------------------------------------------------------------------------------------------

    def _move(self, name: str, arguments: tuple[ex.Expression, ...]) -> st.Move:
        count = 4 if name == "movec" else 3
        if len(arguments) != count:
            wanted = "via, end" if count == 4 else "target"
            raise BrokenLineError(
                f"{name} with {len(arguments)} arguments", wanted=f"{wanted}, tool and mdesc"
            )
        *points, tool, mdesc = arguments
        path = _PATHS[name]
        if path is st.Path.JOINT:
            points[-1] = _as_joints(points[-1])
            speed = st.Speed(st.SpeedUnit.FRACTION, ex.Quantity(ex.Member(mdesc, "vel"), percent))
        else:
            base = mdesc.base if isinstance(mdesc, ex.Item) else mdesc
            free = isinstance(base, ex.Named) and base.name in self.known.unbounded
            self.unbounded |= free
            share = ex.Quantity(ex.Member(mdesc, "vel"), _FULL_SPEED * percent)
            bound = ex.Quantity(ex.Member(mdesc, "tmax"), mm)
            speed = st.Speed(st.SpeedUnit.TRAVEL, share if free else bound)
        corner = ex.Binary("*", ex.Member(mdesc, "blend"), ex.Member(mdesc, "leave"))
        return st.Move(
            0,
            path,
            (points[-1],),
            speed,
            st.Blend(st.BlendKind.RADIUS, ex.Quantity(corner, mm)),
            acceleration=ex.Quantity(ex.Member(mdesc, "accel"), percent),
            deceleration=ex.Quantity(ex.Member(mdesc, "decel"), percent),
            via=points[0] if count == 4 else None,
            turn=None if path is st.Path.JOINT else ex.Quantity(ex.Member(mdesc, "rmax"), deg),
            tool=tool,
            frame=self._frame(points[-1]),
        )

    def _father(self, point: ex.Expression) -> str:
        """The frame of a point: that of its data, or of the point that it was made from; empty where nobody says."""
        while isinstance(point, ex.Function) and point.arguments:
            if point in self.made:
                return self.made[point]
            point = point.arguments[0]
        if isinstance(point, ex.Item) and isinstance(point.base, ex.Named):
            name, index = point.base.name, point.indices[0]
            if isinstance(index, ex.Number) and (own := self.known.fathers.get(f"{name}[{index.value - 1}]")):
                return own
            return self.known.fathers.get(name, "")
        if not isinstance(point, ex.Named):
            return ""
        self.framed.append(point.name)
        return self.known.fathers.get(point.name, "")

    def _frame(self, point: ex.Expression) -> ex.Expression:
        if isinstance(point, ex.Function) and point.name == "forward":
            return ex.FrameRef("base")
        if isinstance(point, ex.PositionLiteral) or self._type(point) in JOINTS:
            return ex.FrameRef("base")
        father = self._father(point)
        if father == MIXED:
            raise NotModelledError("it goes to a point that may stand in one of several frames")
        if not father and not isinstance(point, ex.SystemValue):
            self.frameless = True
        return ex.FrameRef("base") if father in ("", WORLD) else named(father)

    # --- instructions -----------------------------------------------------------------------------------

    def assign(self, children: list[Any]) -> Any:
        target, value = children
        if isinstance(value, ex.CallValue) and value.routine in _PATHS:
            return self._move(value.routine, value.arguments)
        if wait := _watched(value):
            return [wait, st.Assign(0, target, ex.Unary("not", _TIMED_OUT))]
        if isinstance(target, ex.Signal):
            bus = target.bus.replace("in", "out")
            return st.SetOutput(0, ex.Signal(bus, target.index), value)
        if (turned := _turned(target, value)) is not None:
            return turned
        if not isinstance(target, (ex.Named, ex.Item, ex.Member)):
            raise BrokenLineError("nothing can be stored here", wanted="a variable")
        kind = self._type(target)
        if kind in JOINTS:
            value = _as_joints(value)
        if type(value) is ex.FrameRef:  # flange and world as values of a variable: nothing is turned or moved
            value = ex.PositionLiteral("pose", (0.0,) * 6)
        if isinstance(target, ex.Named) and kind.startswith("point"):
            self._inherit(target.name, value)
        elif isinstance(target, ex.Item) and kind.startswith("point"):
            self._inherit_element(target, value)
        return st.Assign(0, target, value)

    def _inherit_element(self, target: ex.Item, value: ex.Expression) -> None:
        """One point of an array gets the frame of another one; where it is computed which, all are asked."""
        father = self._father(value)
        if not father or not isinstance(target.base, ex.Named):
            return
        name, index, fathers = target.base.name, target.indices[0], self.known.fathers
        if isinstance(index, ex.Number):
            fathers[f"{name}[{index.value - 1}]"] = father
        elif any(key.startswith(f"{name}[") and own != father for key, own in fathers.items()):
            father = MIXED
        fathers[name] = father if fathers.get(name, father) == father else MIXED

    def _inherit(self, name: str, value: ex.Expression) -> None:
        if father := self._father(value):
            self.known.fathers[name] = father

    def call(self, children: list[Any]) -> st.Call:
        """A program takes the frame of each point that it is handed behind its arguments."""
        name, arguments = str(children[0]), tuple(children[1] or ())
        points = [arguments[at] for at in points_of_call(self.known, name) if at < len(arguments)]
        return st.Call(0, name, (*arguments, *map(self._frame, points)))

    def task(self, children: list[Any]) -> st.StartTask:
        task = children[0].value if isinstance(children[0], ex.Text) else ""
        return st.StartTask(0, str(children[-2]), task)

    def builtin(self, children: list[Any]) -> Any:
        name, arguments = str(children[0]), tuple(children[1] or ())
        if name in _PATHS:
            return self._move(name, arguments)
        if name == "delay" and len(arguments) == 1:
            return st.Dwell(0, ex.Quantity(arguments[0], 1.0))
        if name in ("wait", "watch") and arguments:
            return st.Wait(0, arguments[0], ex.Quantity(arguments[1], 1.0) if len(arguments) > 1 else None)
        stop = st.Dwell(0, ex.Quantity(ex.Number(0), 1.0))
        if name == "waitEndMove":
            return stop
        if name in _ACTS:
            return [stop, st.Process(0, name, tuple(("", one) for one in arguments))]
        if name in _MESSAGES:
            return st.Message(0, arguments[-1] if arguments else ex.Text(""))
        if name in ("dioSet", "aioSet") and len(arguments) == 2:
            return st.SetOutput(0, self._port(name, arguments[0], "out"), arguments[1])
        if name == "setMonitorSpeed" and len(arguments) == 1:
            return st.SetOverride(0, ex.Quantity(arguments[0], percent))
        raise NotModelledError("olp knows no instruction of this form")

    def if_(self, children: list[Any]) -> Any:
        """Before one that watches for a signal, the wait."""
        value, wanted = _wanted(children[0])
        if wait := _watched(value):
            return [wait, st.If(0, ex.Unary("not", _TIMED_OUT) if wanted else _TIMED_OUT)]
        return st.If(0, children[0])

    def for_(self, children: list[Any]) -> st.For:
        variable, start, stop, step = children
        if not isinstance(variable, ex.Named):
            raise BrokenLineError("a loop that counts in an array", wanted="a variable, as in for i=1 to 3")
        return st.For(0, variable, start, stop, step)

    def break_(self, _: list[Any]) -> Leave:
        return Leave()


def _frame_name(frame: ex.Expression) -> str:
    """A frame as data name it, `fPart` or `fPart[2]`; empty for one that is computed."""
    if isinstance(frame, ex.FrameRef):
        return WORLD
    if isinstance(frame, ex.Named):
        return f"{frame.name}[0]"
    if isinstance(frame, ex.Item) and isinstance(frame.base, ex.Named):
        index = frame.indices[0]
        return f"{frame.base.name}[{int(index.value) - 1}]" if isinstance(index, ex.Number) else ""
    return ""


def _as_joints(value: ex.Expression) -> ex.Expression:
    """Six numbers in braces where joint values are wanted: degrees of the axes, and no pose."""
    if isinstance(value, ex.PositionLiteral) and value.native[:1] and value.native[0][0] == "j1":
        return joints(float(v) for _, v in value.native)
    return value


def _wanted(value: ex.Expression) -> tuple[ex.Expression, bool]:
    """x of `x`, `x==true`, `!x` and `x==false`, and whether it is wanted true."""
    if isinstance(value, ex.Unary) and value.operator == "not":
        return value.operand, False
    if isinstance(value, ex.Compare) and value.operator == "=" and isinstance(value.right, ex.SignalState):
        return value.left, value.right.on
    return value, True


def _watched(value: ex.Expression) -> st.Wait | None:
    """watch(condition, time): waits, and says whether the condition came."""
    if isinstance(value, ex.CallValue) and value.routine == "watch" and len(value.arguments) == 2:
        return st.Wait(0, value.arguments[0], ex.Quantity(value.arguments[1], 1.0))
    return None
