"""Writes a program in a vendor's language: from what was understood, not from the text that was read.

Every vendor that can be written has a template `templates/<vendor>.j2`, which holds the shape of a file, and a
module `olp.languages.vendors.<vendor>.writer`, which spells the words. Whatever the language cannot say is found before
anything is written.

Codes: X001 a language that cannot be written, X002 something that the language cannot say, X003 a character
that the encoding does not have.
"""

from __future__ import annotations

import codecs
import os
from importlib import import_module
from typing import Protocol, cast

from olp.core import resources
from olp.core.diagnostic import Diagnostic, OlpError, Span, error, raise_errors
from olp.ir.program import Program

_ERRORS = "surrogateescape"  # bytes that could not be read are written as they were, see `source`
_WITH_ASCII = frozenset({"cp1252", "iso8859-1", "utf-8"})  # of which ASCII is a part
_ROW = 1_000  # characters that a statement, a point or a declaration may take, twice what any was seen to
_FALLBACK = "cp1252"  # what controllers sold in Europe and America write


class Writer(Protocol):
    """The module `olp.languages.vendors.<vendor>.writer`."""

    def write(self, program: Program, date: str) -> tuple[dict[str, object], list[Diagnostic]]:
        """The values for the vendor's template, and an error for everything that the language cannot say."""


def writable() -> tuple[str, ...]:
    """The vendors whose language can be written, sorted."""
    from olp.languages.vendor import vendor_names

    templates = set(resources.names("templates", ".j2"))
    return tuple(name for name in vendor_names() if name in templates)


def refuse_unwritable(vendor: str) -> None:
    """Raises OlpError (X001), which lists the languages that can be written."""
    if vendor not in writable():
        from olp.languages.vendor import find_vendor

        known = ", ".join(f"{name} ({find_vendor(name).title})" for name in writable())
        raise OlpError(error("X001", f"olp cannot write '{vendor}'", help=f"it writes: {known}"))


def export(
    program: Program,
    vendor: str,
    output: str | os.PathLike[str] | None = None,
    *,
    template: str | os.PathLike[str] | None = None,
    encoding: str | None = None,
    date: str | None = None,
) -> bytes:
    """The program in `vendor`'s language, also written to the file `output` if that is given.

    `template`: a jinja2 file instead of the vendor's own. `encoding`: a Python codec (None: the program's own).
    `date`: YYYY/MM/DD HH:MM for files that hold one (None: the program's own, or now).
    Raises OlpError with all errors of the program, all that the language cannot say (X…), or the template's (J…).
    """
    refuse_unwritable(vendor)
    raise_errors([found.at(program.path) for found in program.diagnostics])
    if program.vendor != vendor:
        program = _translated(program, vendor)
    text = _text(program, vendor, template, date or now())
    data = encoded(text, program, vendor, encoding or encoding_of(program, vendor))
    if output is not None:
        from olp.core.files import write_output

        write_output(os.fspath(output), data, inputs=[program.path] if program.path else [])
    return data


def _translated(program: Program, vendor: str) -> Program:
    """A program of another language in the form that the writer takes; `olp convert` says what changed."""
    from olp.transpile.pipeline import canonical, refusals

    translated = canonical(program, vendor)
    raise_errors([*translated.problems, *refusals(program, vendor, translated)])
    return translated.program


def _text(program: Program, vendor: str, template: str | os.PathLike[str] | None, date: str) -> str:
    writer = cast(Writer, import_module(f"olp.languages.vendors.{vendor}.writer"))
    values, problems = writer.write(program, date)
    raise_errors(problems)
    return rendered(values, vendor, program, template)


def rendered(
    values: dict[str, object],
    vendor: str,
    program: Program,
    template: str | os.PathLike[str] | None = None,
) -> str:
    """What the vendor's template, or another one, makes of a writer's values. Raises OlpError (J…)."""
    from olp.languages.templating import RenderingLimits, given, shipped

    renderer = shipped(vendor) if template is None else given(template)
    # What was read from several files has little text of its own.
    rows = len(program.data) + sum(len(r.body) + len(r.points) for r in program.routines)
    size = len(program.source.raw) + rows
    characters = 1_000_000 + 100 * size + _ROW * rows
    limits = RenderingLimits(steps=100_000 + 10 * size, characters=characters, seconds=60.0)
    return renderer.render(values, limits)


def now() -> str:
    """YYYY/MM/DD HH:MM."""
    from datetime import datetime

    return datetime.now().strftime("%Y/%m/%d %H:%M")


def encoding_of(program: Program, vendor: str) -> str:
    """What the program was read in; a mark of the byte order, which controllers refuse, is left out."""
    encoding = program.source.encoding
    if encoding == "ascii" or encoding.startswith(("utf-16", "utf-32")):
        return _FALLBACK
    return "utf-8" if encoding == "utf-8-sig" else encoding


def encoded(text: str, program: Program, vendor: str, encoding: str) -> bytes:
    """The text with the vendor's line ends. Raises OlpError (X003)."""
    from olp.languages.vendor import find_vendor

    ended = text.replace("\n", find_vendor(vendor).newline)
    try:
        # A table of characters takes twenty times as long as ASCII, which nearly all programs are.
        ascii_too = text.isascii() and codecs.lookup(encoding).name in _WITH_ASCII
        return ended.encode("ascii" if ascii_too else encoding, _ERRORS)
    except LookupError:
        raise OlpError(
            error("X003", f"unknown encoding '{encoding}'", help="try cp1252, shift_jis or utf-8")
        ) from None
    except UnicodeEncodeError:
        raise OlpError(*_unencodable(text, program, encoding)) from None


def _unencodable(text: str, program: Program, encoding: str) -> list[Diagnostic]:
    """One error per line of the new text that the encoding cannot hold."""
    problems = []
    for number, line in enumerate(text.split("\n"), 1):
        try:
            line.encode(encoding, _ERRORS)
        except UnicodeEncodeError as problem:
            span = Span(number, problem.start + 1, problem.end + 1)
            message = f"{encoding} has no '{line[problem.start : problem.end]}'"
            more = {
                "file": program.path,
                "source_line": line,
                "help": "choose another --encoding, such as utf-8",
            }
            problems.append(error("X003", f"{message} (line of the new text)", span, **more))
    return problems
