"""`olp completion`: what a shell needs to complete commands, options, robots and files.

Code: C019 shtab is not installed.
"""

from __future__ import annotations

from argparse import Action, ArgumentParser, Namespace
from typing import Any

SUMMARY = "print what bash, zsh or fish needs to complete olp's commands"
_SHELLS = ("bash", "zsh", "fish")
_FILES = (
    "BACKUP",
    "DIR",
    "FILE",
    "FOLDER",
    "JOB",
    "LOG",
    "NEW",
    "OLD",
    "OUT",
    "PATH",
    "RECORDING",
    "SIGNATURE",
)


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "shell",
        choices=_SHELLS,
        help='bash: put eval "$(olp completion bash)" into ~/.bashrc; zsh: write it to a file _olp in $fpath; '
        "fish: write it to ~/.config/fish/completions/olp.fish",
    )


def run(args: Namespace) -> int:
    from olp.core.diagnostic import OlpError, error

    try:
        import shtab
    except ImportError:
        help = 'install it: pip install "olp[completion]"'
        raise OlpError(
            error("C019", "olp completion needs shtab, which is not installed", help=help)
        ) from None
    print(shtab.complete(_whole_parser(shtab.FILE), args.shell))
    return 0


def _whole_parser(files: Any) -> ArgumentParser:
    """One parser of all commands, which nothing is parsed with. `files`: how shtab marks what completes to files."""
    from olp import cli

    whole = ArgumentParser("olp", allow_abbrev=False)
    groups: dict[tuple[str, ...], Any] = {(): whole.add_subparsers()}
    first = sorted({name.partition(" ")[0] for name in cli.names()})
    groups[()].add_parser("help", help="explain a command").add_argument("command", choices=first)
    for name in cli.names():
        *above, last = name.split(" ")
        path = tuple(above)
        if path not in groups:
            group = groups[()].add_parser(path[0], help=f"olp {path[0]} …")
            groups[path] = group.add_subparsers()
        command = cli.load(name)
        parser = groups[path].add_parser(last, help=command.SUMMARY)
        command.add_arguments(parser)
        for action in parser._actions:
            _mark(action, files)
    return whole


def _mark(action: Action, files: Any) -> None:
    from olp.reports.outcome.model import format_names
    from olp.robots.robot import robot_names

    metavar = str(action.metavar or "").partition(".")[0]
    if action.dest in ("robot", "target_robot"):
        action.choices = robot_names()
    elif action.dest == "format" and action.choices is None:
        action.choices = format_names()
    elif action.choices is None and action.nargs != 0 and (not action.option_strings or metavar in _FILES):
        action.complete = files  # type: ignore[attr-defined]
