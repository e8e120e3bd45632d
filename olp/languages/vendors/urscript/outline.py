"""Which lines belong to which function: definitions nest, and `end` closes whatever was opened last.

Codes: P551 a block that is never closed, P552 an end or branch without its block, P557 two functions of one name.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from olp.languages.findings import Findings
from olp.languages.vendors.urscript.lines import Broken, Mark, UrscriptLine
from olp.languages.vendors.urscript.syntax import Assignment, Closing, Definition, Evaluation, Node, Opening

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
        pending = [self]
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
