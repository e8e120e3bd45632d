"""The one reader of TOML: what the library parses, within bounds that no file of a person comes near.

Every refusal is a `TOMLDecodeError`, so whoever reads a file has one thing to catch.

The other way it writes values as a robot file has them.
"""

from __future__ import annotations

import json
import math
import os
import re
import tomllib
from tomllib import TOMLDecodeError
from typing import Any, Final, TypeGuard

from olp.core.diagnostic import Diagnostic, error
from olp.core.files import read_input

__all__ = ["TOMLDecodeError", "is_number", "is_told_enough", "parse_toml", "toml_text"]

_MOST_BYTES = 2_000_000  # of a file; the largest of the library's robots has 20 kB
_MOST_VALUES = 20_000
_MOST_DEPTH = 32
_MOST_TOLD = 100
_PART = r"""(?>[\w-]+|"[^"\n]*"|'[^'\n]*')"""
_LONG_KEY = re.compile(rf"{_PART}(?:[ \t]*\.[ \t]*{_PART}){{{_MOST_DEPTH},}}")
_INTEGER = 2**63  # TOML's own bound


def toml_text(path: str | os.PathLike[str], errors: str = "strict") -> str:
    """Return the text of a file without a byte-order mark, with LF as line ends.

    Raises OSError and, unless `errors` says otherwise, UnicodeDecodeError.
    """
    return read_input(path, _MOST_BYTES).decode("utf-8-sig", errors).replace("\r\n", "\n")


def parse_toml(text: str) -> dict[str, Any]:
    """Return the document as a dictionary. Raises TOMLDecodeError, also for a document beyond the bounds of size
    and depth.
    """
    if len(text) > _MOST_BYTES:
        raise TOMLDecodeError(f"more than {_MOST_BYTES // 1_000_000} MB")
    # The library makes a table for each part of a key, and remembers all keys above each.
    found = _LONG_KEY.search(text)
    if found is not None:
        raise TOMLDecodeError(f"a key of more than {_MOST_DEPTH} parts (at {_place(text, found.start())})")
    try:
        document = tomllib.loads(text)
    except RecursionError:
        raise TOMLDecodeError("brackets within brackets without an end") from None
    except TOMLDecodeError:
        raise
    except ValueError as problem:  # a number with more digits than Python takes
        raise TOMLDecodeError(str(problem).partition(";")[0]) from None
    _check(document)
    return document


def is_number(value: object) -> TypeGuard[float]:
    """Whether a value of a document is a finite number."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def is_told_enough(problems: list[Diagnostic], code: str, file: str) -> bool:
    """Return whether the limit of reported problems of one file is reached; adds a last one that says so."""
    if len(problems) == _MOST_TOLD:
        problems.append(error(code, "this file has more problems than are listed here", file=file))
    return len(problems) > _MOST_TOLD


def _check(document: dict[str, Any]) -> None:
    """Raise TOMLDecodeError where the document exceeds the bounds: the number of values, their depth, numbers and
    texts.
    """
    count = 0
    level: list[Any] = [document]
    for _ in range(_MOST_DEPTH):
        count += len(level)
        if count > _MOST_VALUES:
            raise TOMLDecodeError(f"more than {_MOST_VALUES} values")
        below: list[Any] = []
        for value in level:
            if isinstance(value, dict):
                for key in value:
                    _check_value(key)
                below += value.values()
            elif isinstance(value, list):
                below += value
            else:
                _check_value(value)
        if not below:
            return
        level = below
    raise TOMLDecodeError(f"tables and lists within one another, {_MOST_DEPTH} deep")


def _check_value(value: object) -> None:
    if isinstance(value, str) and "\0" in value:
        raise TOMLDecodeError("a text holds a NUL character")
    if isinstance(value, int) and not -_INTEGER <= value < _INTEGER:
        raise TOMLDecodeError("an integer of more than 64 bits")


def _place(text: str, at: int) -> str:
    line = text.count("\n", 0, at) + 1
    return f"line {line}, column {at - text.rfind(chr(10), 0, at)}"


ROBOT_NAME: Final = re.compile(r"[a-z0-9][a-z0-9._-]{0,40}/[a-z0-9][a-z0-9._-]{0,60}")


def shown(value: float) -> str:
    """Return a number without trailing zeros, at most nine decimals; a whole number becomes a TOML integer."""
    return f"{value + 0.0:.9f}".rstrip("0").rstrip(".")


def quoted(text: str) -> str:
    """A TOML basic string; JSON's escapes are among TOML's, and DEL is the one character that JSON leaves."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def plain(text: str) -> str:
    """Return `text` for a comment, with "?" for each control character, which TOML forbids there."""
    return "".join(c if c.isprintable() else "?" for c in text)
