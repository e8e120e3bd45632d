"""Cuts a module into clauses: instructions and declarations with their semicolon, and words of blocks.

Comments are taken out and kept apart. A clause that goes over several lines keeps its line breaks, so that a place in
it is a place in the file.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from typing import Final, NamedTuple

from olp.core import result_cache

_ALONE = "ELSE ENDIF ENDFOR ENDWHILE ENDTEST ENDPROC ENDFUNC ENDTRAP ENDRECORD ENDMODULE UNDO BACKWARD"
_SINGLE: Final = frozenset(_ALONE.split())
# How a clause that begins with one of these words ends.
_MODES: Final = {
    "IF": "then",
    "ELSEIF": "then",
    "FOR": "do",
    "WHILE": "do",
    "TEST": "test",
    "CASE": "colon",
    "DEFAULT": "colon",
    "PROC": "routine",
    "FUNC": "routine",
    "MODULE": "module",
    "TRAP": "name",
    "RECORD": "name",
    "ERROR": "error",
}
# Words that stand at the beginning of a clause only: inside another one they show that its end is missing.
_OPENING: Final = (_SINGLE | set(_MODES)) - {"IF"}
_NOT_PLAIN: Final = _SINGLE | set(_MODES) | {"LOCAL", "TASK"}
_PLAIN: Final = re.compile(
    r'\s*+(([A-Z_a-z]\w*+)(?!\s*+:(?!=))[^;!"<]*+;)\s*+(?:!(.*+))?', re.DOTALL
)  # no label; and the comment behind it
_TOKEN: Final = re.compile(r'"(?:[^"]|"")*"?|!|;|:(?!=)|:=|[()]|[\\.]?[^\W\d]\w*|<[A-Z]{2,3}>|%+|\S')


class Clause(NamedTuple):
    """`text` begins in `line` at `column` (1-based); `word`: its first one, upper case, behind LOCAL and TASK.

    `comment` None: no comment behind it. `complete`: its end was found.
    """

    word: str
    text: str
    line: int
    column: int
    last: int
    comment: str | None = None
    complete: bool = True


class RapidRemark(NamedTuple):
    """A comment on a line of its own, or between the parts of a clause."""

    line: int
    text: str


class Cutter:
    """Goes through the lines once. A clause is handed out when what follows it in its line is known."""

    def __init__(self, lines: Sequence[str]) -> None:
        self._lines = lines
        self._parts: list[str] = []
        self._done: list[Clause | RapidRemark] = []
        self._reset()

    def _reset(self) -> None:
        self._word = self._mode = ""
        self._parts.clear()
        self._line = self._column = self._depth = self._tokens = 0
        self._open = self._named = False

    def cut(self) -> Iterator[Clause | RapidRemark]:
        """All clauses and comments in the order of the text."""
        plain = _PLAIN.fullmatch
        new: Callable[..., Clause] = tuple.__new__  # as the constructor does, in half the time
        shelf = result_cache.shelf("rapid lines")
        for number, line in enumerate(self._lines, 1):
            if not self._open:
                known = None if shelf is None else shelf.get(line)
                if known is None:
                    match = plain(line)
                    if match is not None and match[2].upper() not in _NOT_PLAIN:
                        text = match[1]
                        known = (
                            text[:4].upper() if text[0] in "mM" else "",
                            text,
                            match.start(1) + 1,
                            match[3],
                        )
                        if shelf is not None:
                            shelf.put(line, known)
                if known is not None:
                    yield new(Clause, (known[0], known[1], number, known[2], number, known[3], True))
                    continue
                if not line or line.isspace():
                    continue
            self._cut_line(line, number)
            if self._done:
                yield from self._done
                self._done.clear()
        if self._open:
            self._finish(len(self._lines), complete=self._mode == "test" or self._ends_by_itself())
            yield from self._done
            self._done.clear()

    def _ends_by_itself(self) -> bool:
        return self._mode in ("error", "name", "module") and (self._named or self._mode == "error")

    def _cut_line(self, line: str, number: int) -> None:
        begin = 0  # of the open clause's part in this line
        position = 0
        if self._open and self._mode in ("error", "module") and self._depth == 0 and self._named:
            rest = line.lstrip()
            if not rest.startswith("(") and rest:
                self._finish(number - 1)
        while True:
            match = _TOKEN.search(line, position)
            if match is None:
                break
            token, position = match[0], match.end()
            if token == "!":
                self._remark(line, match.start(), begin, number)
                return
            if not self._open:
                begin = match.start()
                if token == ";":
                    continue  # an empty instruction
                self._begin(token, number, begin)
            elif self._opens_another(token):
                self._parts.append(line[begin : match.start()])
                self._finish(number, complete=self._mode == "test" or self._ends_by_itself())
                begin = match.start()
                self._begin(token, number, begin)
            else:
                self._tokens += 1
            if self._ends(token, line, position):
                self._parts.append(line[begin:position])
                self._finish(number)
        if self._open:
            self._parts.append(line[begin:])

    def _begin(self, token: str, number: int, start: int) -> None:
        self._open, self._line, self._column, self._tokens = True, number, start + 1, 1
        self._set_mode(token)

    def _set_mode(self, token: str) -> None:
        word = token.upper()
        if word in ("LOCAL", "TASK"):
            self._word, self._mode = "", "scope"
        elif word in _SINGLE:
            self._word, self._mode = word, "word"
        else:
            self._word, self._mode = word, _MODES.get(word, "header" if token == "%%%" else "semicolon")
        if self._mode == "error":
            self._named = True

    def _opens_another(self, token: str) -> bool:
        """Whether a token inside an open clause begins the next one."""
        if self._mode in ("scope", "header"):
            return False
        word = token.upper()
        if self._mode == "error":
            return self._depth == 0 and token != "("
        if self._mode == "module" and self._named and self._depth == 0:
            return token != "("
        return word in _OPENING and self._tokens > 0

    def _ends(self, token: str, line: str, position: int) -> bool:
        """Whether the open clause ends with this token. Keeps its state."""
        mode = self._mode
        if mode == "scope":
            if self._tokens > 1:
                self._set_mode(token)
                self._tokens = 1
            return self._mode == "word"
        if token == "(":
            self._depth += 1
        elif token == ")":
            self._depth -= 1
        if mode == "semicolon":
            return (
                token == ";"
                or (token == ":" and self._tokens == 2)
                or self._is_placeholder(token, line, position)
            )
        if mode == "word":
            return True
        if mode == "then":
            return token == ";" or token.upper() == "THEN"
        if mode == "do":
            return token.upper() == "DO" or token == ";"
        if mode == "colon":
            return token in (":", ";")
        if mode == "test":
            return token == ";"
        if mode == "header":
            return token == "%%%" and self._tokens > 1
        return self._head_ends(mode, token)

    def _is_placeholder(self, token: str, line: str, position: int) -> bool:
        """`<SMT>`, with or without a semicolon."""
        alone = token[0] == "<" and token[-1] == ">" and len(token) > 2 and self._tokens == 1
        return alone and not line[position:].lstrip().startswith(";")

    def _head_ends(self, mode: str, token: str) -> bool:
        """Heads of modules, routines and handlers, which end with a name or a closing bracket."""
        if mode == "name":
            self._named = self._tokens == 2
            return self._named
        if mode == "module" and self._tokens == 2:
            self._named = True
        return token == ";" or (token == ")" and self._depth <= 0)

    def _remark(self, line: str, start: int, begin: int, number: int) -> None:
        text = line[start + 1 :]
        if self._open:
            self._parts.append(line[begin:start])
            self._done.append(RapidRemark(number, text))
            return
        last = self._done[-1] if self._done else None
        if isinstance(last, Clause) and last.last == number and last.comment is None:
            self._done[-1] = last._replace(comment=text)
        else:
            self._done.append(RapidRemark(number, text))

    def _finish(self, number: int, complete: bool = True) -> None:
        text = "\n".join(self._parts).rstrip()
        last = self._line + text.count("\n")
        self._done.append(
            Clause(self._word, text, self._line, self._column, min(last, number), None, complete)
        )
        self._reset()
