"""Changes of a text that an editor is offered."""

from __future__ import annotations

from typing import NamedTuple


class TextEdit(NamedTuple):
    """The text from (line, column) to (end_line, end_column) becomes `text`."""

    line: int
    column: int
    end_line: int
    end_column: int
    text: str


class Action(NamedTuple):
    """A quick fix: `code` of the finding it is for; `preferred` where it is what most people want."""

    title: str
    code: str
    edits: tuple[TextEdit, ...]
    preferred: bool = False
