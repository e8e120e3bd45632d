"""What a RAPID module declares, as far as it can be told without running it: for the checks of `load.py`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Final, NamedTuple

from olp.core.diagnostic import Span
from olp.core.source import Source

_TOKEN: Final = re.compile(
    r"(?P<text>\"(?:[^\"]|\"\")*\"?)|(?P<number>\d+(?:\.\d*)?(?:[eE][+-]?\d+)?|\.\d+)|(?P<word>[^\W\d]\w*)"
    r"|(?P<sign>:=|<>|<=|>=|[-+*/=<>(){}\[\],;:.\\|%?])|(?P<odd>\S)"
)
_KINDS: Final = frozenset(("var", "pers", "const"))
_MODES: Final = frozenset(("inout", "var", "pers"))
_ROUTINES: Final = {"proc": "endproc", "func": "endfunc", "trap": "endtrap"}


class RapidToken(NamedTuple):
    kind: str
    text: str
    line: int
    column: int

    @property
    def span(self) -> Span:
        return Span(self.line, self.column, self.column + len(self.text))

    @property
    def key(self) -> str:
        return self.text.casefold()


@dataclass(slots=True)
class Data:
    """A declaration. `kind`: var, pers, const, or parameter and loop; `sizes`: one text for each index of an array,
    `*` where a parameter leaves it open; `mode`: inout, var or pers of a parameter. `task`: other tasks do not see it.
    """

    name: RapidToken
    type: str
    kind: str
    local: bool = False
    sizes: tuple[str, ...] = ()
    mode: str = ""
    task: bool = False

    @property
    def array(self) -> bool:
        return bool(self.sizes)


@dataclass(slots=True)
class RapidRoutine:
    """What is declared of a routine. `type`: of what a function returns."""

    name: RapidToken
    kind: str
    type: str
    local: bool
    parameters: list[Data] = field(default_factory=list)
    takes: list[str] = field(default_factory=list)  # the types of what is no option
    modes: list[str] = field(default_factory=list)  # and inout, var or pers, "" of values
    options: set[str] = field(default_factory=set)
    data: list[Data] = field(default_factory=list)
    body: list[RapidToken] = field(default_factory=list)
    late: list[RapidToken] = field(default_factory=list)  # declarations behind the first statement


@dataclass(slots=True)
class Module:
    name: str = ""
    title: RapidToken | None = None  # the name where it stands
    tokens: list[RapidToken] = field(default_factory=list)
    data: list[Data] = field(default_factory=list)
    routines: list[RapidRoutine] = field(default_factory=list)
    types: dict[str, RapidToken] = field(default_factory=dict)
    components: dict[str, dict[str, str]] = field(default_factory=dict)  # of records, each with its type
    values: list[tuple[Data, list[RapidToken]]] = field(default_factory=list)  # what declarations begin with
    late: list[RapidToken] = field(
        default_factory=list
    )  # declarations of data behind a routine, of types behind data


def tokens_of(source: Source) -> Iterator[RapidToken]:
    """The tokens without comments; RAPID's texts end with their line."""
    for number, line in enumerate(source.lines, 1):
        for match in _TOKEN.finditer(line):
            if match[0] == "!":
                break
            yield RapidToken(match.lastgroup or "", match[0], number, match.start() + 1)


@lru_cache(maxsize=512)
def module_of(source: Source) -> Module:
    """The declarations of a module, as far as they can be told."""
    if source.path.lower().endswith(".pgf"):
        return Module()
    return _Reader(source).read()


class _Reader:
    def __init__(self, source: Source) -> None:
        self.tokens = list(tokens_of(source))
        self.at = 0
        self.module = Module(tokens=self.tokens)

    def key(self, ahead: int = 0) -> str:
        at = self.at + ahead
        return self.tokens[at].key if at < len(self.tokens) else ""

    def until(self, sign: str) -> list[RapidToken]:
        """The tokens up to `sign`, which is passed."""
        start = self.at
        while self.at < len(self.tokens) and self.tokens[self.at].text != sign:
            self.at += 1
        self.at += 1
        return self.tokens[start : self.at - 1]

    def read(self) -> Module:
        m = self.module
        while self.at < len(self.tokens):
            local, task = self.key() == "local", self.key() == "task"
            word = self.key(1) if self.key() in ("local", "task") else self.key()
            self.at += self.key() in ("local", "task")
            if word == "module":
                m.name = self.key(1)
                m.title = self.tokens[self.at + 1] if m.name else None
                self.at += 2
            elif word in _KINDS:
                if m.routines:
                    m.late.append(self.tokens[self.at])
                m.data += self.declaration(local, task, m.values)
            elif word in _ROUTINES:
                m.routines.append(self.routine(local))
            elif word in ("record", "alias"):
                if m.data or m.routines:
                    m.late.append(self.tokens[self.at])
                self.type(word)
            else:
                self.at += 1
        return m

    def type(self, word: str) -> None:
        name = self.at + (1 if word == "record" else 2)
        if name < len(self.tokens):
            self.module.types[self.tokens[name].key] = self.tokens[name]
        if word == "alias":
            self.until(";")
            return
        start = name + 1
        while self.at < len(self.tokens) and self.key() != "endrecord":
            self.at += 1
        if name < len(self.tokens):
            members = self.module.components.setdefault(self.tokens[name].key, {})
            kind = ""
            for token in self.tokens[start : self.at]:
                if token.kind != "word":
                    kind = "" if token.text == ";" else kind
                elif not kind:
                    kind = token.key
                else:
                    members[token.key] = kind
        self.at += 1

    def declaration(self, local: bool, task: bool, values: list[tuple[Data, list[RapidToken]]]) -> list[Data]:
        row = self.until(";")
        if len(row) < 3 or row[1].kind != "word" or row[2].kind != "word":
            return []
        data = Data(row[2], row[1].key, row[0].key, local, _sizes(row[3:]), task=task)
        begins = next((i for i, t in enumerate(row) if t.text == ":="), len(row))
        values.append((data, row[begins + 1 :]))
        return [data]

    def routine(self, local: bool) -> RapidRoutine:
        kind = self.key()
        type_ = self.key(1) if kind == "func" else ""
        self.at += 2 if kind == "func" else 1
        name = self.tokens[self.at] if self.at < len(self.tokens) else self.tokens[-1]
        self.at += 1
        routine = RapidRoutine(name, kind, type_, local)
        if self.key() == "(":
            self.at += 1
            self.parameters(routine)
        end, begun = _ROUTINES[kind], False
        while self.at < len(self.tokens) and self.key() not in (end, "endmodule"):
            if self.key() in _ROUTINES and self.key(1) not in ("", ":=", "(") and self.key(-1) == ";":
                break
            if self.key() in _KINDS and self.key(2) and self.tokens[self.at + 1].kind == "word":
                if begun:
                    routine.late.append(self.tokens[self.at])
                routine.data += self.declaration(False, False, self.module.values)
                continue
            begun = True
            routine.body.append(self.tokens[self.at])
            self.at += 1
        self.at += 1
        return routine

    def parameters(self, routine: RapidRoutine) -> None:
        depth = 1
        part: list[RapidToken] = []
        parts: list[tuple[list[RapidToken], str]] = []
        while self.at < len(self.tokens) and depth:
            token = self.tokens[self.at]
            self.at += 1
            depth += (token.text in "({") - (token.text in ")}")
            if depth == 1 and token.text in (",", "|"):
                parts.append((part, token.text))
                part = []
            elif depth and token.text == "\\" and part:
                parts.append((part, ","))
                part = [token]
            elif depth:
                part.append(token)
        parts.append((part, ""))
        before = ""
        for one, sign in parts:
            optional = bool(one and one[0].text == "\\") or before == "|"
            words = [t for t in one if t.kind == "word" and t.key not in ("inout", "var", "pers", "switch")]
            if words:
                type_ = words[0].key if len(words) > 1 else "switch"
                bracket = next((i for i, t in enumerate(one) if t.text == "{"), len(one))
                mode = next((t.key for t in one if t.key in _MODES), "")
                routine.parameters.append(
                    Data(words[-1], type_, "parameter", sizes=_sizes(one[bracket:]), mode=mode)
                )
                if optional or type_ == "switch":
                    routine.options.add(words[-1].key)
                else:
                    routine.takes.append("" if routine.parameters[-1].array else type_)
                    routine.modes.append(mode)
            before = sign


def _sizes(row: list[RapidToken]) -> tuple[str, ...]:
    """What stands between the braces of a declaration that begin here, index by index."""
    if not row or row[0].text != "{":
        return ()
    end = next((i for i, token in enumerate(row) if token.text == "}"), len(row))
    parts: list[str] = [""]
    for token in row[1:end]:
        if token.text == ",":
            parts.append("")
        else:
            parts[-1] += token.text
    return tuple(parts)
