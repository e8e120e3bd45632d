"""Indentation, blanks and letters of a text, line by line: no line comes, goes or moves."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import ClassVar


class Layout:
    """One language. Without more, blanks at the ends of lines go."""

    def lines(self, lines: Sequence[str], indent: str) -> list[str]:
        """The same lines as they should be; `indent`: one step of indentation."""
        return [line.rstrip(" \t") for line in lines]


class BlockLayout(Layout):
    """A language whose blocks are indented. Each pattern is matched at the first word of a line.

    `opens`: what follows stands one step further; `closes`: from here on one step less; `between`: this line only.
    `free_outside`: a line outside of all blocks stands where it stands, and a block begins there.
    """

    opens: ClassVar[re.Pattern[str]]
    closes: ClassVar[re.Pattern[str]]
    between: ClassVar[re.Pattern[str]]
    open_end: ClassVar[re.Pattern[str]] = re.compile(r"(?!)")  # a line that goes on in the next one
    kept: ClassVar[re.Pattern[str]] = re.compile(r"(?!)")  # lines that stay as they are
    free_outside: ClassVar[bool] = False

    def lines(self, lines: Sequence[str], indent: str) -> list[str]:
        found: list[str] = []
        depth, shift, goes_on, base = 0, 0, False, ""
        for line in lines:
            text = line.strip(" \t")
            if not text or self.kept.match(text):
                found.append(text and line)
                continue
            old = line[: len(line) - len(line.lstrip(" \t"))]
            if goes_on:
                # The rest of an instruction keeps its place below the first line.
                found.append(" " * max(0, len(old) + shift) + text)
            else:
                if self.closes.match(text):
                    depth = max(0, depth - 1)
                level = max(0, depth - 1) if self.between.match(text) else depth
                if self.free_outside and not depth:
                    base = old
                found.append(base + indent * level + text)
                shift = len(base + indent * level) - len(old)
                depth += self.opens.match(text) is not None
            goes_on = self.open_end.search(self.bare(text)) is not None
        return found

    def bare(self, text: str) -> str:
        """The line without its comment."""
        return text
