"""What may follow while somebody writes: the language's words, and the names of the text and its folder."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from olp.languages.tokens import TokenKind
from olp.languages.vendor import find_vendor
from olp.runtime.folder import files_by_name_record, files_by_stem
from olp.servers.language.analysis import Analysis
from olp.servers.language.document import vendor_of
from olp.servers.language.symbols import names, words_of

_MOST = 500  # names of a kind: a list of 10,000 points helps nobody
_TOKEN = re.compile(r"[^\s,;(){}=\[]*$")


class Proposal(NamedTuple):
    """`text` in place of what stands between `column` and the cursor. `kind` None: a word of the language."""

    text: str
    column: int
    kind: TokenKind | None
    detail: str = ""


def completion(analysis: Analysis, line: str, number: int, column: int) -> list[Proposal]:
    """Proposals for a cursor before `column` of `line` (number `number`), which may be newer than the analysis."""
    before = line[: column - 1]
    match = _TOKEN.search(before)
    start = match.start() + 1 if match else column
    typed = before[start - 1 :].casefold()
    vendor = analysis.program.vendor if analysis.program is not None else vendor_of(analysis.source, "") or ""
    words = words_of(vendor)
    if words is None:
        return []
    found = [Proposal(word, start, None) for word in sorted(words.vocabulary())]
    found += _names(analysis, number, start)
    found += _jobs(analysis, vendor, before[: start - 1], start, typed)
    return [one for one in found if one.text.casefold().startswith(typed)]


def _names(analysis: Analysis, number: int, start: int) -> Iterator[Proposal]:
    """Each name of the text once, spelt as where it comes into being, else as where it stands first."""
    spelt: dict[tuple[str, str], Proposal] = {}
    counts: dict[TokenKind, int] = {}
    for name in sorted(names(analysis), key=lambda one: not one.defines):
        key = (name.scope, name.key)
        if key in spelt or name.line == number or counts.get(name.kind, 0) >= _MOST:
            continue
        counts[name.kind] = counts.get(name.kind, 0) + 1
        text = analysis.source.line(name.line)
        word = text[name.column - 1 : name.end_column - 1]
        if not word[:1].isdigit():  # the number of a frame alone
            spelt[key] = Proposal(word, start, name.kind, text.strip()[:80])
    yield from spelt.values()


def _jobs(analysis: Analysis, vendor: str, before: str, start: int, typed: str) -> Iterator[Proposal]:
    """The other programs of the folder, where one can be called."""
    path = Path(analysis.path)
    if not path.is_absolute() or not path.parent.is_dir():
        return
    own = find_vendor(vendor)
    mark = own.call_mark
    if mark and not (typed.startswith(mark.casefold()) or re.search(own.call_words, before)):
        return
    files = files_by_stem(path.parent, path.suffix)
    heads = files_by_name_record(path.parent, path.suffix) if mark else {}
    for name in sorted({*files, *heads} - {path.stem.upper()}):
        yield Proposal(f"{mark}{name}", start, TokenKind.ROUTINE, f"{name} in this folder")
