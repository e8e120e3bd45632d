"""The argument parser that the commands share. Codes: C001 unknown command, C002 wrong arguments."""

from __future__ import annotations

import re
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from typing import NoReturn

from olp.core.diagnostic import OlpError, error


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
