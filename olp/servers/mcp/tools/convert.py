"""`olp convert`: a program in another robot's language."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, ClassVar, Literal

from pydantic import Field

from olp.core.diagnostic import OlpError, error
from olp.languages.limits import writable
from olp.languages.vendor import find_vendor
from olp.servers.mcp.tool import AnswerRow, AssistantTool, ToolAnswer, ToolArguments, ToolCall, robot_word

*_FIRST, _LAST = writable()
_LANGUAGES = f"{', '.join(_FIRST)} or {_LAST}"


class ConvertGiven(ToolArguments):
    """The program to translate, the target language, and where the translation is written."""

    job: str = Field(max_length=1024, description="the program, a path below the server's folder")
    to: str = Field(max_length=20, description=f"the language: {_LANGUAGES}")
    robot: str | None = Field(None, max_length=200, description="the robot that the program was written for")
    target_robot: str | None = Field(
        None, max_length=200, description="the robot that it is written for; default: the same"
    )
    map: str | None = Field(
        None,
        max_length=1024,
        description="a TOML file: which tools, frames and signals of the target the source's are",
    )
    on_loss: Literal["error", "comment"] = Field(
        "error", description="what becomes of a statement that the target cannot say"
    )
    flat: bool = Field(
        False, description="write what the program does, move after move, instead of the program"
    )
    output: str | None = Field(
        None,
        max_length=1024,
        description="a folder to write the files to, which needs a server with --write; default: the text comes back",
    )
    force: bool = Field(False, description="write over files of that folder")


class ConvertedText(AnswerRow):
    """One file of the translated program; `text` is null where the file was written into the folder `output`."""

    name: str
    text: str | None


class ConvertAnswer(ToolAnswer):
    """The files of the translated program, and the receipt of what is exact, approximated, commented out or
    rejected.
    """

    files: list[ConvertedText]
    receipt: dict[str, Any] = Field(
        description="totals and losses per statement with reasons, differences of both plans in mm, deg, %, and s"
    )


class Convert(AssistantTool[ConvertGiven]):
    """Runs `olp convert`. Without `output`, the text is returned and no file is written into the user's folder."""

    title: ClassVar[str] = "A robot program in another robot's language"
    description: ClassVar[str] = (
        f"Translates a robot program between {', '.join(find_vendor(name).title for name in writable())}. "
        "Answers with the text of the new program and a receipt: every statement exact, approximated, "
        "commented or refused and why, and how far the moves of both programs differ when they are run. "
        "Show the losses to the user: robots move by this text."
    )
    given = ConvertGiven
    answer = ConvertAnswer

    def ask(self, given: ConvertGiven, call: ToolCall) -> dict[str, Any]:
        from olp.languages.vendor import vendor_suffixes

        (job,) = call.folder.programs([given.job], vendor_suffixes())
        folder = _target(given, call)
        receipt = call.temporary / "receipt.json"
        words = list(_words(given, call, kept=folder is not None))
        target = folder if folder is not None else str(call.temporary / "new")
        ran = call.run("convert", f"--output={target}", f"--receipt={receipt}", *words, "--", job)
        if not receipt.exists():
            raise OlpError(
                error("Z008", "this program was not translated", file=given.job, help=ran.told[:2000])
            )
        document = json.loads(receipt.read_bytes())
        files = [
            {"name": name, "text": None if folder is not None else _text(Path(target) / name)}
            for name in _names(Path(target), document)
        ]
        return {"exit_status": ran.status, "told": ran.told, "files": files, "receipt": document}


def _target(given: ConvertGiven, call: ToolCall) -> str | None:
    """The folder to write to. Raises OlpError (Z007)."""
    if given.output is None:
        return None
    if not call.write:
        raise OlpError(
            error(
                "Z007",
                "this server only reads",
                help="leave output away, and the text comes back; or have the user start olp mcp with --write",
            )
        )
    return call.folder.new(given.output)


def _words(given: ConvertGiven, call: ToolCall, kept: bool) -> list[str]:
    words = [f"--to={given.to}", f"--on-loss={given.on_loss}"]
    words += [
        f"--{option}={robot_word(robot, call.folder)}"
        for option, robot in (("robot", given.robot), ("target-robot", given.target_robot))
        if robot is not None
    ]
    words += [f"--map={call.folder.inside(given.map)}"] if given.map is not None else []
    words += ["--flat"] if given.flat else []
    # What comes back as text is read as UTF-8; a file keeps the encoding of its source.
    words += (["--force"] if given.force else []) if kept else ["--to-encoding=utf-8"]
    return words


def _names(folder: Path, document: dict[str, Any]) -> list[str]:
    """The files of this program, as the receipt names them, and what else a fresh folder holds (a KRL .dat)."""
    named = [str(name) for name in document["target"]["files"]]
    stems = {Path(name).stem for name in named}
    more = sorted(path.name for path in folder.iterdir() if path.stem in stems and path.name not in named)
    return [*named, *more]


def _text(path: Path) -> str:
    return path.read_bytes().decode("utf-8", "replace")
