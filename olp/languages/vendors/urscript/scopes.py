"""Which name is seen where and what it holds: URScript declares no types, and few scopes.

A name is shared by all parts of a program when `global` stands before it anywhere, or when the main program
sets it and another part uses it; any other belongs to the part that sets it.

Definitions nest: which lines belong to which function follows from `end`, which closes whatever was opened last.

Codes: P551 a block that is never closed, P552 an end or branch without its block, P557 two functions of one name.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from olp.languages.findings import Findings
from olp.languages.vendors.urscript.builtins import JOINT_ARGUMENTS, RESULTS
from olp.languages.vendors.urscript.lines import Broken, Mark, UrscriptLine
from olp.languages.vendors.urscript.syntax import (
    Assignment,
    Closing,
    Definition,
    Evaluation,
    Invocation,
    ListOf,
    Literal,
    Node,
    Opening,
    PlainPose,
    PoseOf,
    Running,
    Sign,
    Subscript,
    UrscriptArgument,
    UrscriptKeyword,
    UrscriptName,
    UrscriptPair,
    expressions,
    simple_of,
    walk,
)

_MOST_NESTED = 100  # definitions in one another that are searched for a name


@dataclass(slots=True, eq=False)
class UrscriptPart:
    """A function, thread or secondary program, or the file itself (kind "file").

    `name` as written, `unique` as no other part of the file is called. `lines`: its own instructions with the number
    of blocks around each. `parts`: what is defined in it, by name.
    """

    kind: str
    name: str
    unique: str
    line: int
    parent: UrscriptPart | None = None
    parameters: tuple[tuple[str, Node | None], ...] = ()
    comment: str = ""
    lines: list[tuple[UrscriptLine, int]] = field(default_factory=list)
    parts: dict[str, UrscriptPart] = field(default_factory=dict)
    last_line: int = 0

    def find(self, name: str) -> UrscriptPart | None:
        """The part that `name` means here: an own one, else one of those around."""
        part: UrscriptPart | None = self
        for _ in range(_MOST_NESTED):
            if part is None:
                break
            found = part.parts.get(name)
            if found is not None:
                return found
            part = part.parent
        return None

    def all(self) -> Iterator[UrscriptPart]:
        """This part and all in it, in order of writing."""
        pending: list[UrscriptPart] = [self]
        while pending:
            part = pending.pop()
            yield part
            pending.extend(reversed(part.parts.values()))


class Outliner:
    """Sorts the lines of a file into its parts."""

    def __init__(self, findings: Findings) -> None:
        self._findings = findings
        self._root = UrscriptPart("file", "", "", 1)
        self._here = self._root
        self._open: list[tuple[str, int]] = []  # word and line of each open block, definitions among them
        self._else: set[int] = set()  # lines of the ifs that had theirs
        self._taken: set[str] = set()
        self._numbers: dict[str, int] = {}
        self._depth = 0  # blocks that are open in the current part
        self._waiting: list[UrscriptLine] = []  # comments, which belong to the definition that may follow

    def read(self, lines: Iterable[UrscriptLine]) -> UrscriptPart:
        """The file with all that is defined in it."""
        last = 0
        for line in lines:
            content = line.content
            kind = type(content)
            if kind is Mark:
                self._remark(line)
            elif (kind is Assignment or kind is Evaluation) and not self._waiting:
                self._here.lines.append((line, self._depth))
            else:
                if self._waiting and (
                    type(content) is not Definition or self._waiting[-1].last + 1 < line.number
                ):
                    self._flush()
                self._place(line)
            last = line.last
        self._flush()
        for word, number in self._open:
            self._unclosed(word, number)
        for part in self._root.all():
            part.last_line = part.last_line or last
        return self._root

    def _remark(self, line: UrscriptLine) -> None:
        assert isinstance(line.content, Mark)
        if self._waiting and self._waiting[-1].last + 1 < line.number:
            self._flush()
        if line.content.opaque or line.content.text.startswith("$"):
            self._flush()
            self._add(line)
        else:
            self._waiting.append(line)

    def _flush(self) -> None:
        for line in self._waiting:
            self._add(line)
        self._waiting.clear()

    def _add(self, line: UrscriptLine, depth: int | None = None) -> None:
        self._here.lines.append((line, self._depth if depth is None else depth))

    def _place(self, line: UrscriptLine) -> None:
        content = line.content
        if type(content) is Definition:
            self._define(line, content)
        elif type(content) is Closing:
            self._close(line)
        elif type(content) is Opening:
            self._block(line, content)
        elif type(content) is Broken and content.head:
            self._broken(line, content)
        else:
            self._add(line)

    def _define(self, line: UrscriptLine, content: Definition) -> None:
        unique = self._unique(content.name)
        part = UrscriptPart(
            content.kind, content.name, unique, line.number, self._here, content.parameters, line.comment
        )
        if content.name in self._here.parts:
            span = self._findings.whole_line(line.number)
            message = f"a second function {content.name}: calls go to the first one, this one is {unique}"
            self._findings.warning("P557", message, span, "rename one of them")
            self._here.parts[unique] = part
        else:
            self._here.parts[content.name] = part
        part.lines = [(comment, 0) for comment in self._waiting]
        self._waiting.clear()
        self._open.append(("def", line.number))
        self._here, self._depth = part, 0

    def _unique(self, name: str) -> str:
        """A name that no other part has: URScript looks names up by place, olp by name."""
        unique = name
        if unique in self._taken:
            unique = f"{self._here.unique}_{name}"
        while unique in self._taken:
            self._numbers[name] = self._numbers.get(name, 1) + 1
            unique = f"{name}_{self._numbers[name]}"
        self._taken.add(unique)
        return unique

    def _close(self, line: UrscriptLine) -> None:
        if not self._open:
            span = self._findings.whole_line(line.number)
            self._findings.error("P552", "an end without its block", span, "remove it, or is a def missing?")
            return
        word, _ = self._open.pop()
        if word != "def":
            self._depth -= 1
            self._add(line)
            return
        part = self._here
        part.last_line = line.last
        if line.comment:
            part.lines.append((line._replace(content=Mark(line.comment)), 0))
        assert part.parent is not None
        self._here = part.parent
        self._depth = self._depth_here()

    def _depth_here(self) -> int:
        depth = 0
        for word, _ in reversed(self._open):
            if word == "def":
                break
            depth += 1
        return depth

    def _block(self, line: UrscriptLine, content: Opening) -> None:
        if content.word in ("if", "while"):
            self._add(line)
            if not content.closed:
                self._open.append((content.word, line.number))
                self._depth += 1
            return
        if not self._open or self._open[-1][0] != "if":
            self._stray(line, content.word)
            return
        opener = self._open[-1][1]
        if opener in self._else:
            message = f"{content.word} behind the else of the if in line {opener}"
            span = self._findings.whole_line(line.number)
            self._findings.error("P552", message, span, "else comes last, and once")
        elif content.word == "else":
            self._else.add(opener)
        self._add(line, self._depth - 1)
        if content.closed:
            self._open.pop()
            self._depth -= 1

    def _stray(self, line: UrscriptLine, word: str) -> None:
        span = self._findings.whole_line(line.number)
        self._findings.error("P552", f"{word} without its if", span, "is an end too many above?")

    def _broken(self, line: UrscriptLine, content: Broken) -> None:
        """A line that was told already, and still opens or ends what its first word says."""
        if content.head in ("def", "thread", "sec"):
            name = content.text.split("(")[0].split()[-1]
            self._define(line, Definition(content.head, name if name.isidentifier() else "unnamed", ()))
        elif content.head == "end":
            self._close(line)
        else:
            condition = Opening(content.head, None, None, False)
            self._block(line._replace(content=condition), condition)

    def _unclosed(self, word: str, number: int) -> None:
        span = self._findings.whole_line(number)
        self._findings.error(
            "P551", f"this {word} has no end", span, "write end where it is over; is the file cut off?"
        )


_ROUNDS = 3  # a type passes from a value to a name, from a name to a parameter, and on
_NAMELESS = frozenset({Literal, PlainPose})
_NUMBERS = frozenset({"integer", "real"})
_COMPARISONS = frozenset({"==", "!=", "<", ">", "<=", ">=", "and", "or", "xor"})


@dataclass(slots=True)
class Facts:
    """What one part says about names. `given`: (name, value) of each assignment; `first`: name -> its first one."""

    part: UrscriptPart
    used: set[str] = field(default_factory=set)
    given: list[tuple[str, Node]] = field(default_factory=list)
    elements: list[tuple[str, Node]] = field(default_factory=list)  # the same of elements of a list
    first: dict[str, int] = field(default_factory=dict)  # name -> index in the part's lines
    local: set[str] = field(default_factory=set)
    shared: set[str] = field(default_factory=set)
    calls: list[tuple[UrscriptPart, tuple[UrscriptArgument, ...]]] = field(default_factory=list)
    results: list[Node] = field(default_factory=list)
    plain: set[str] = field(default_factory=set)  # functions that say nothing about their arguments
    outside: set[str] = field(default_factory=set)  # functions of which no part of the file is one
    joints: set[str] = field(default_factory=set)  # names that hold positions of the axes, if they hold lists
    tables: set[str] = field(default_factory=set)  # names whose elements do
    points: set[str] = field(default_factory=set)  # names that hold poses to move to
    types: dict[str, str] = field(default_factory=dict)  # of its parameters and own variables
    result: str = ""


class UrscriptNames:
    """All names of a file. `facts`: one for each part. `starts`: the file is a program, which runs `main` once."""

    def __init__(self, root: UrscriptPart, main: UrscriptPart, starts: bool) -> None:
        self.main = main
        self.starts = starts
        parts = [part for part in root.all() if part is not root or root is main]
        self.facts = {id(part): _gather(part) for part in parts}
        self.shared = self._find_shared()
        self._seen = {
            id(facts.part): self.shared - facts.local - {name for name, _ in facts.part.parameters}
            for facts in self.facts.values()
        }
        self.waypoints = self._find_waypoints()
        self._times: Counter[str] = Counter()
        for facts in self.facts.values():
            seen = self._seen[id(facts.part)]
            self._times.update([name for name, _ in facts.given if name in seen])
        self.types: dict[str, str] = {}
        for _ in range(_ROUNDS):
            self._mark()
        self._every = {
            which: {name for facts in self.facts.values() for name in getattr(facts, which)}
            for which in ("joints", "tables")
        }
        for _ in range(_ROUNDS):
            if not self._infer():
                break

    def of(self, part: UrscriptPart) -> Facts:
        return self.facts[id(part)]

    def is_shared(self, part: UrscriptPart, name: str) -> bool:
        """Whether the name means the variable that all parts see."""
        return name in self._seen[id(part)]

    def type_of(self, part: UrscriptPart, name: str) -> str:
        """The type as in `Declare.type`, "list" or "list:" and that of the elements; empty: not known."""
        if self.is_shared(part, name):
            return self.types.get(name, "")
        return self.of(part).types.get(name, "")

    def is_set_once(self, name: str) -> bool:
        """Whether a shared name gets its value in one place of the file only."""
        return self._times[name] == 1

    def constant(self, part: UrscriptPart, name: str) -> int | float | None:
        """The number that a name holds all the time, None where it may change or is not known."""
        if _is_parameter(part, name):
            return None
        every = self.facts.values() if self.is_shared(part, name) else [self.of(part)]
        values = [value for facts in every for given, value in facts.given if given == name]
        if len(values) != 1 or type(values[0]) is not Literal or type(values[0].value) not in (int, float):
            return None
        return values[0].value  # type: ignore[return-value]

    def holds_joints(self, part: UrscriptPart, name: str) -> bool:
        """Whether a list of six numbers under this name is a position of the axes."""
        return name.endswith("_q") or self._is_among(part, name, "joints")

    def holds_joint_lists(self, part: UrscriptPart, name: str) -> bool:
        return self._is_among(part, name, "tables")

    def _is_among(self, part: UrscriptPart, name: str, which: str) -> bool:
        if name in getattr(self.of(part), which):
            return True
        return name in self._every[which] and self.is_shared(part, name)

    def _find_shared(self) -> set[str]:
        shared: set[str] = set()
        for facts in self.facts.values():
            shared |= facts.shared
        main = self.of(self.main)
        own = {name for name, _ in main.given} - main.local - {name for name, _ in self.main.parameters}
        for facts in self.facts.values():
            if facts is not main:
                shared |= (own & facts.used) - facts.local - {name for name, _ in facts.part.parameters}
        return shared

    def _find_waypoints(self) -> set[str]:
        """Names that moves go to: what `pose_trans` turns and is no waypoint is a frame."""
        return {name for facts in self.facts.values() for name in facts.joints | facts.points}

    # --- types ------------------------------------------------------------------------------------------

    def _mark(self) -> None:
        """Names that are passed to a parameter that holds positions of the axes hold them, too."""
        for facts in self.facts.values():
            for called, arguments in facts.calls:
                target = self.of(called)
                for name, value in _bound(called, arguments):
                    if name not in target.joints:
                        continue
                    if type(value) is UrscriptName:
                        facts.joints.add(value.text)
                    elif type(value) is Subscript and type(value.base) is UrscriptName:
                        facts.tables.add(value.base.text)

    def _infer(self) -> bool:
        """One more round; whether a type became known or wider in it."""
        changed = False
        for facts in self.facts.values():
            part = facts.part
            shared = self._seen[id(part)]
            for name, value in facts.given:
                types = self.types if name in shared else facts.types
                if type(value) is PlainPose:  # a path has thousands
                    if types.get(name) != "position":
                        changed |= _widen(types, name, "position")
                    continue
                wanted, tables = self.holds_joints(part, name), self.holds_joint_lists(part, name)
                changed |= _widen(types, name, self.infer(part, value, wanted, tables))
            for name, value in facts.elements:
                types = self.types if name in shared else facts.types
                if types.get(name) == "list:integer" and self.infer(part, value) != "integer":
                    changed |= _widen(types, name, "list:real")
            for name, default in part.parameters:
                if default is not None:
                    changed |= _widen(facts.types, name, self.infer(part, default, name in facts.joints))
            for value in facts.results:
                found = self.infer(part, value)
                if _is_wider(facts.result, found) or (facts.result == "boolean" and found in _NUMBERS):
                    facts.result = found  # a number holds a state, too, as 1 or 0
                    changed = True
            for called, arguments in facts.calls:
                target = self.of(called)
                for name, value in _bound(called, arguments):
                    changed |= _widen(target.types, name, self.infer(part, value, name in target.joints))
        return changed

    def infer(self, part: UrscriptPart, node: Node, joints: bool = False, tables: bool = False) -> str:
        """The type of a value; `joints`, `tables`: of a name that holds positions of the axes, or lists of them."""
        match node:
            case Literal(value):
                return _LITERALS[type(value)]
            case PoseOf() | PlainPose():
                return "position"
            case ListOf(items):
                return self._list(part, items, joints, tables)
            case UrscriptName(text):
                return self.type_of(part, text)
            case Subscript(base, indices):
                return _element(self.infer(part, base), len(indices))
            case UrscriptPair(operator, left, right):
                return self._pair(part, operator, left, right)
            case Sign(operator, operand):
                return "boolean" if operator == "not" else self.infer(part, operand)
            case Invocation(UrscriptName(text), _):
                called = part.find(text)
                return self.of(called).result if called is not None else RESULTS.get(text, "")
            case Running():
                return "integer"
            case _:
                return ""

    def _list(self, part: UrscriptPart, items: tuple[Node, ...], joints: bool, tables: bool) -> str:
        if joints and len(items) == 6 and not any(map(_is_structure, items)):
            return "joints"
        if tables and items and all(type(one) is ListOf for one in items):
            return "list:joints"
        kinds = {self.infer(part, item) for item in items[:50]}
        if kinds == {"integer", "real"}:
            kinds = {"real"}
        return f"list:{kinds.pop()}" if len(kinds) == 1 and "" not in kinds else "list"

    def _pair(self, part: UrscriptPart, operator: str, left: Node, right: Node) -> str:
        if operator in _COMPARISONS:
            return "boolean"
        kinds = (self.infer(part, left), self.infer(part, right))
        for kind in kinds:
            if kind not in ("integer", "real", "boolean", ""):
                return kind
        if kinds == ("integer", "integer") and operator != "/":
            return "integer"
        return "real"


def _bound(called: UrscriptPart, arguments: tuple[UrscriptArgument, ...]) -> Iterator[tuple[str, Node]]:
    """(parameter, value) of each argument of a call."""
    places = iter(called.parameters)
    for argument in arguments:
        name = argument.name or next((name for name, _ in places), "")
        if name:
            yield name, argument.value


_LITERALS = {bool: "boolean", int: "integer", float: "real", str: "string"}


def _is_structure(node: Node) -> bool:
    return type(node) in (ListOf, PoseOf, PlainPose) or (
        type(node) is Literal and type(node.value) in (str, bool)
    )


def _is_parameter(part: UrscriptPart, name: str) -> bool:
    return any(name == parameter for parameter, _ in part.parameters)


def _element(base: str, indices: int) -> str:
    for _ in range(indices):
        if base.startswith("list:"):
            base = base[5:]
        elif base in ("position", "joints"):
            base = "real"
        else:
            base = "string" if base == "string" else ""
    return base


def _widen(types: dict[str, str], name: str, type_: str) -> bool:
    """A name that holds values of two types has the wider one, where one is; whether that is new."""
    if not _is_wider(types.get(name, ""), type_):
        return False
    types[name] = type_
    return True


def _is_wider(known: str, type_: str) -> bool:
    """Whether what holds values of the type `known` holds those of `type_`, too, if it has that type."""
    wider = {
        "": type_ != "",
        "integer": type_ == "real",
        "list": type_.startswith("list:"),
        "list:integer": type_ == "list:real",
    }
    return wider.get(known, False)


def _gather(part: UrscriptPart) -> Facts:
    facts = Facts(part)
    for index, (line, _) in enumerate(part.lines):
        content = line.content
        if type(content) is Evaluation:
            _use(facts, content.value)
            continue
        if type(content) is Mark or type(content) is Broken:
            continue
        if (
            type(content) is Assignment
            and type(content.value) is PlainPose
            and type(content.target) is UrscriptName
        ):
            _assigned(facts, content, index)
            facts.used.add(content.target.text)
            continue
        simple = simple_of(content)  # type: ignore[arg-type]
        if type(simple) is Assignment:
            _assigned(facts, simple, index)
        elif type(simple) is UrscriptKeyword and simple.word == "return" and simple.value is not None:
            facts.results.append(simple.value)
        for node in expressions(content):  # type: ignore[arg-type]
            _use(facts, node)
    return facts


def _assigned(facts: Facts, simple: Assignment, index: int) -> None:
    if type(simple.target) is Subscript and type(simple.target.base) is UrscriptName:
        facts.elements.append((simple.target.base.text, simple.value))
    if type(simple.target) is not UrscriptName:
        return
    name = simple.target.text
    facts.given.append((name, simple.value))
    facts.first.setdefault(name, index)
    if simple.scope == "global":
        facts.shared.add(name)
    elif simple.scope == "local":
        facts.local.add(name)


def _use(facts: Facts, expression: Node) -> None:
    kind = type(expression)
    if kind is UrscriptName:
        facts.used.add(expression.text)  # type: ignore[union-attr]
        return
    if kind is Invocation and type(expression.function) is UrscriptName:  # type: ignore[union-attr]
        # As `walk` goes, the last argument first, without its generator: every move is a call.
        name = expression.function.text  # type: ignore[union-attr]
        facts.used.add(name)
        arguments = expression.arguments  # type: ignore[union-attr]
        if name not in facts.plain:
            _called(facts, name, arguments)
        for _, value in reversed(arguments):
            if type(value) is UrscriptName:
                facts.used.add(value.text)
            elif type(value) not in _NAMELESS:
                _use(facts, value)
        return
    for node in walk(expression):
        if type(node) is UrscriptName:
            facts.used.add(node.text)
        elif type(node) is Invocation and type(node.function) is UrscriptName:
            name = node.function.text
            if name not in facts.plain:
                _called(facts, name, node.arguments)


def _called(facts: Facts, name: str, arguments: tuple[UrscriptArgument, ...]) -> None:
    if name not in facts.outside:
        called = facts.part.find(name)
        if called is not None:
            facts.calls.append((called, arguments))
            return
        facts.outside.add(name)
    if name == "get_inverse_kin" and arguments and type(arguments[0].value) is UrscriptName:
        facts.points.add(arguments[0].value.text)
    place = JOINT_ARGUMENTS.get(name)
    if place is None:
        facts.plain.add(name)
        return
    for index, argument in enumerate(arguments):
        if argument.name == place[1] or (not argument.name and index == place[0]):
            if type(argument.value) is UrscriptName:
                facts.joints.add(argument.value.text)
            elif type(argument.value) is Subscript and type(argument.value.base) is UrscriptName:
                facts.tables.add(argument.value.base.text)
