"""`olp diff`: what a new version costs."""

from __future__ import annotations

import json
import os
import re
from typing import Any, ClassVar

from pydantic import Field

from olp.core.diagnostic import OlpError, error
from olp.servers.folder import Folder
from olp.servers.mcp.tool import AnswerRow, AssistantTool, JudgedAnswer, Timed, ToolCall

_REVISION = re.compile(r"[A-Za-z0-9@][\w./@{}^~-]*")
_PATH = "a program or a folder below the server's folder, or a git revision such as HEAD~1"


class DiffGiven(Timed):
    """The two versions to compare: two programs, two folders, or two git revisions."""

    old: str = Field(max_length=1024, description=_PATH)
    new: str = Field(max_length=1024, description=f"{_PATH}; '.' is the working copy when old is a revision")
    paths: list[str] = Field([], max_length=200, description="of two revisions: only these files and folders")
    allow_s: float | None = Field(
        None, gt=0, description="exit_status 1 when a program takes this much longer than before"
    )


class ChangedLine(AnswerRow):
    """A line whose predicted time [s] differs between the versions, with the cause; null where one version lacks
    the line.
    """

    file: str
    old_line: int | None
    new_line: int | None
    statement: str
    old_s: float
    new_s: float
    change_s: float
    cause: str


class Compared(AnswerRow):
    """The predicted times [s] of one program in both versions; null in the version that lacks the program."""

    file: str
    old_s: float | None
    new_s: float | None
    change_s: float | None
    changes: list[ChangedLine]


class DiffAnswer(JudgedAnswer):
    """The programs that were compared, with the lines whose time changed."""

    programs: list[Compared]


class Diff(AssistantTool[DiffGiven]):
    """Runs `olp diff`. Revisions are those of a git repository whose root is the server's folder."""

    title: ClassVar[str] = "What a new version of a program costs"
    description: ClassVar[str] = (
        "Compares the predicted times of two versions of robot programs, line by line with the cause "
        "(another speed, another point, a longer wait …): two files, two folders, or two git revisions of "
        "the server's folder."
    )
    given = DiffGiven
    answer = DiffAnswer

    def ask(self, given: DiffGiven, call: ToolCall) -> dict[str, Any]:
        words = list(given.words(call.folder))
        if given.allow_s is not None:
            words.append(f"--allow={given.allow_s!r}")
        versions = [_version(text, call.folder) for text in (given.old, given.new)]
        paths = call.folder.all_inside(given.paths)
        ran = call.run("diff", "--format=json", "--all", *words, "--", *versions, *paths)
        whole = json.loads(ran.printed)
        whole.pop("tables", None)  # the same as `programs`, for people
        return {**whole, "exit_status": ran.status, "told": ran.told}


def _version(text: str, folder: Folder) -> str:
    """A path or a revision. Raises OlpError (Z001 and those of a path)."""
    from olp.languages.vendor import vendor_suffixes

    word = folder.inside(text)
    if os.path.exists(folder.root / word):
        return word if word == "." else folder.programs([word], vendor_suffixes())[0]
    git = folder.root / ".git"
    if not _REVISION.fullmatch(text):
        says = f"{text[:60]!r} is not a file, a folder or a git revision"
        raise OlpError(
            error("Z001", says, help="name two programs, two folders, or revisions such as HEAD~1")
        )
    if git.is_symlink() or not git.is_dir():
        says = (
            f"{text[:60]!r} is no file here, and revisions are those of a git repository in the folder itself"
        )
        raise OlpError(
            error("Z001", says, help="start olp mcp with --root and the folder that has .git in it")
        )
    return text
