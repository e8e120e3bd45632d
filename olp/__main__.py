"""The command line: finds the command, runs it, and turns whatever went wrong into diagnostics.

Only the command that was asked for is imported, so `olp --help` and small jobs answer at once.
"""

from __future__ import annotations

import atexit
import gc
import io
import os
import re
import sys
from collections.abc import Sequence
from typing import TextIO

from olp import cli
from olp.cli.command import Parser
from olp.core.diagnostic import Diagnostic, OlpError, error
from olp.core.files import from_os_error
from olp.core.terminal import Screen
from olp.core.version import __version__

_CODE = re.compile(r"[A-Za-z]\d{3}")


def explained_code(word: str) -> str:
    """What a code of a diagnostic means; "" for a word that is not one. Case does not matter."""
    if not _CODE.fullmatch(word):
        return ""
    from olp.core.resources import code_meanings

    code = word.upper()
    if meaning := code_meanings().get(code, ""):
        return f"{code}: {meaning}"
    from olp.checks.lint.rule import all_rules

    rules = (rule for rule in all_rules() if rule.code == code)
    return next((rule.explained() for rule in rules), "")


DONE, NO_ANSWER = 0, 2
INTERRUPTED, CLOSED_PIPE = 130, 141  # as a shell reports SIGINT and SIGPIPE

HELP = """\
usage: olp COMMAND [ARGUMENT …]

Reads robot programs, says how long every line takes and why, and writes them back unharmed.

commands:
{commands}

olp help COMMAND explains one command, olp help CODE a code such as P020; olp --version prints the version.
Exit status: 0 done and held, 1 a finding, 2 the question could not be answered."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command line (without the leading "olp") and returns its exit status."""
    make_streams_robust()
    # The matrices here are small: further threads of numpy's OpenBLAS, not loaded yet, would only burn time in waiting.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # At its exit Python looks for cycles once more, among objects that the end of the process frees anyway: frozen
    # ones it passes over.
    atexit.register(gc.freeze)
    try:
        status = dispatch(list(sys.argv[1:] if arguments is None else arguments))
        sys.stdout.flush()
    except OlpError as problem:
        return report(problem.diagnostics)
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        # Python would flush once more on its way out and complain.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return CLOSED_PIPE
    except OSError as problem:
        return report([from_os_error(problem)])
    return status


def dispatch(words: list[str]) -> int:
    """Finds the command that `words` name and runs it."""
    if not words:
        print(help_text(), file=sys.stderr)
        return NO_ANSWER
    if words[0] in ("-h", "--help"):
        print(help_text())
        return DONE
    if words[0] in ("-V", "--version"):
        print("olp", __version__)
        return DONE
    asked = words[0] == "help"
    if asked and len(words) == 1:
        print(help_text())
        return DONE
    if asked and (explained := explained_code(words[1])):
        print(explained)
        return DONE
    name, rest = cli.split(words[asked:])
    if not name:
        raise OlpError(unknown(words[asked:]))
    return run(name, ["--help"] if asked else rest)


def run(name: str, words: list[str]) -> int:
    """Parses `words` for the command `name` and runs it."""
    command = cli.load(name)
    parser = Parser(f"olp {name}", command.SUMMARY)
    command.add_arguments(parser)
    try:
        args = parser.parse_words(words)
    except SystemExit:  # --help: said all there is to say
        return DONE
    if getattr(args, "watch", False):
        from olp.cli._watching import watching

        return watching(command.run, args)
    return command.run(args)


def help_text() -> str:
    """What `olp --help` prints."""
    names = cli.names()
    width = max(map(len, names), default=0)
    rows = (f"  {name:{width}}  {cli.load(name).SUMMARY}" for name in names)
    return HELP.format(commands="\n".join(rows))


def unknown(words: list[str]) -> Diagnostic:
    """The diagnostic for a command that does not exist, with the nearest that does."""
    from difflib import get_close_matches

    names = cli.names()
    group = [name for name in names if name.startswith(words[0] + " ")]
    near = group or get_close_matches(" ".join(words[:2]), names, 1) or get_close_matches(words[0], names, 1)
    hint = f"did you mean: {', '.join(f'olp {name}' for name in near)}?" if near else ""
    listed = "olp --help lists the commands"
    return error("C001", f"there is no command {words[0]!r}", help=f"{hint} {listed}".strip())


def report(diagnostics: Sequence[Diagnostic]) -> int:
    """Prints what made the question unanswerable."""
    print("\n\n".join(diagnostic.render() for diagnostic in diagnostics), file=sys.stderr)
    return NO_ANSWER


def make_streams_robust() -> None:
    """No name or comment of a program may stop the answer because the terminal cannot show it, or is closed."""
    if sys.stdout is None:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, as long as the process lives
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # Output that goes to a file on Windows would take the machine's code page.
            stream.reconfigure(encoding="utf-8" if os.name == "nt" else None, errors="replace")
    sys.stdout, sys.stderr = _for_people(sys.stdout), _for_people(sys.stderr)


def _for_people(stream: TextIO) -> TextIO:
    """The stream, and if it is a terminal one that nothing in a program can steer."""
    if type(stream) is not io.TextIOWrapper or not stream.isatty():
        return stream
    encoding, errors = stream.encoding, stream.errors
    return Screen(stream.detach(), encoding, errors, line_buffering=True)


if __name__ == "__main__":
    raise SystemExit(main())
