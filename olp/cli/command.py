"""The argument parser that the commands share. Codes: C001 unknown command, C002 wrong arguments."""

from __future__ import annotations

import os
import re
from argparse import ArgumentParser, Namespace
from collections.abc import Iterable, Sequence
from typing import NoReturn

from olp.core.diagnostic import OlpError, error

# Suffixes that promise a form: text under such a name would be opened by the wrong program.
_FORMS = {
    ".csv", ".htm", ".html", ".json", ".md", ".ods", ".parquet", ".pdf", ".png", ".sarif", ".svg", ".toml", ".tsv",
    ".xls", ".xlsx", ".xml", ".yaml", ".yml",
}  # fmt: skip


def refuse_other_forms(output: str | None, known: Iterable[str], format: str | None = None) -> None:
    """Raises OlpError (C002) for an output that is called like a form that the command does not write.

    `known`: suffixes that it writes; with a `format` said, the name is the user's own business.
    """
    suffix = os.path.splitext(output or "")[1].lower()
    if format is None and suffix in _FORMS and suffix not in known:
        says = f"this command writes no {suffix}"
        help = f"it writes {', '.join(known)} and text; --format says which whatever the name"
        if suffix in (".html", ".htm"):
            help += "; olp report makes pages"
        raise OlpError(error("C002", says, file=output or "", help=help))


class Parser(ArgumentParser):
    """An argument parser that answers wrong arguments with a diagnostic like any other bad input."""

    def __init__(self, prog: str, description: str) -> None:
        # An abbreviation that works today breaks a script on the day a longer option is added.
        super().__init__(prog=prog, description=description, allow_abbrev=False)

    def error(self, message: str) -> NoReturn:
        listed = f"{self.prog} --help lists the arguments"
        near = self._meant(message)
        raise OlpError(error("C002", message, help=f"did you mean {near}? {listed}" if near else listed))

    def _meant(self, message: str) -> str:
        """The option that was probably meant by the first unknown one, "" where none is near."""
        from difflib import get_close_matches

        found = re.search(r"unrecognized arguments: .*?(--[\w-]+)", message)
        options = [option for option in self._option_string_actions if option.startswith("--")]
        return next(iter(get_close_matches(found[1], options, 1)), "") if found else ""

    def parse_words(self, words: Sequence[str]) -> Namespace:
        """The arguments, in any order: options may stand between paths. Raises OlpError (C002)."""
        try:
            return self.parse_args(words)
        except OlpError as problem:
            # argparse takes paths on both sides of an option only when asked, but then loses the "--" before
            # paths that begin with "-", and says less of what is missing.
            if "--" in words:
                raise
            try:
                return self.parse_intermixed_args(words)
            except OlpError:
                raise problem from None
