"""Installs olp as git's merge driver and as its filter for diffs, in one repository.

The driver and the filter are in the repository's configuration, which git never fetches; the patterns of their
files are in `.gitattributes`, which is committed.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

from olp.core.diagnostic import OlpError
from olp.core.files import from_os_error, read_input, write_output
from olp.core.git import asked_of_git, git
from olp.core.source import decode
from olp.languages.merging import COUNTER, NUMBER, MergeRules, PackedRules, RecordRule, Row
from olp.languages.vendor import find_vendor, part_of, recognise, vendor_names

_FIRST, _LAST = "# olp git install: robot programs", "# olp git install: end"
_OURS = re.compile(rf"(?:^|(?<=\n)){re.escape(_FIRST)}\n.*?{re.escape(_LAST)}\n", re.DOTALL)


def install() -> list[str]:
    """Configure this repository; sentences on what was done. Raises OlpError (U002, C005)."""
    top = _top()
    # In full: what a desktop starts git in may have another PATH.
    found = shutil.which("olp")
    command = shlex.quote(os.path.abspath(found)) if found else f"{shlex.quote(sys.executable)} -m olp"
    for key, value in _settings(command).items():
        asked_of_git("config", "--local", key, value)
    attributes = top / ".gitattributes"
    old = _OURS.sub("", _text(attributes))
    old += "" if not old or old.endswith("\n") else "\n"
    rows = [f"{pattern} merge=olp diff=olp" for pattern in _patterns()]
    write_output(attributes, old + "\n".join([_FIRST, *rows, _LAST, ""]), in_place=True)
    return [
        f"merge and diff of {len(rows)} kinds of files: {command}",
        f"commit {attributes.name}, and run this once per clone",
    ]


def remove() -> list[str]:
    """Undo `install`; sentences on what was done. Raises OlpError (U002, C005)."""
    top = _top()
    for section in ("merge.olp", "diff.olp"):
        git("config", "--local", "--remove-section", section)
    attributes = top / ".gitattributes"
    old = _text(attributes)
    new = _OURS.sub("", old)
    if new != old and not new.strip():
        attributes.unlink()
    elif new != old:
        write_output(attributes, new, in_place=True)
    return ["git merges and shows robot programs by itself again"]


def _top() -> Path:
    return Path(os.fsdecode(asked_of_git("rev-parse", "--show-toplevel")).rstrip("\n"))


def _text(path: Path) -> str:
    try:
        return read_input(path).decode("utf-8", "surrogateescape") if path.exists() else ""
    except OSError as problem:
        raise OlpError(from_os_error(problem)) from None


def _settings(command: str) -> dict[str, str]:
    merge = f"{command} merge --driver %P --marker-size %L %O %A %B"
    # Where olp is gone git would leave ours there, without a mark, and show no difference at all.
    texts = "git merge-file --marker-size %L -L ours -L base -L theirs %A %O %B"
    return {
        "merge.olp.name": "robot programs: points by identity, logic by statement",
        "merge.olp.driver": f"{merge}; s=$?; case $s in 126|127) {texts};; *) exit $s;; esac",
        "diff.olp.textconv": f'show() {{ {command} git text "$1" || cat "$1"; }}; show',
    }


def _patterns() -> Iterator[str]:
    """Patterns of all files that olp merges, for upper and lower case."""
    vendors = [find_vendor(name) for name in vendor_names()]
    suffixes = {s for one in vendors for s in (*one.suffixes, *one.data_suffixes, *one.list_suffixes)}
    for one in vendors:
        rules: MergeRules | None = part_of(one.name, "merging")
        suffixes.update(() if rules is None else rules.saved_suffixes)
    for suffix in sorted(suffixes):
        yield "*" + "".join(f"[{c}{c.upper()}]" if c.isalpha() else c for c in suffix)


def shown_text(path: str) -> bytes:
    """The program for a diff: positions are shown in the moves that use them, without line numbers, dates and
    counts.

    A file that is not a program is shown unchanged. Raises OlpError (C005).
    """
    try:
        data = read_input(path)
    except OSError as problem:
        raise OlpError(from_os_error(problem)) from None
    source = decode(data, path)
    vendor = recognise(source)
    rules = part_of(vendor.name, "merging") if vendor is not None and vendor.sniff(source) else None
    packing: PackedRules | None = None if rules is None else rules.packing(data)
    if packing is not None:
        try:
            return packing.unpack(data)
        except ValueError:
            return data
    return data if rules is None else "".join(_shown(rules, data.decode("latin-1"))).encode("latin-1")


def _shown(rules: MergeRules, text: str) -> Iterator[str]:
    cut = rules.cut(text, {})
    rows = {row.use[:2]: row for some in cut.rows.values() for row in some}
    used = {use[:2] for piece in cut.pieces for use in piece.uses}
    for piece in cut.pieces:
        if piece.rule not in (RecordRule.ASK, RecordRule.SAVED_LAST):
            continue
        if not piece.lines:
            # What no move uses.
            for row in cut.rows.get(piece.name, ()):
                if row.use[:2] not in used:
                    yield "".join(
                        line.replace(NUMBER, rules.spelled(row.use, row.use.number)) + "\n"
                        for line in row.lines
                    )
            continue
        uses = iter(piece.uses)
        for line in piece.lines:
            head, *rest = line.lstrip(COUNTER).split(NUMBER)
            shown = [head]
            for part in rest:
                use = next(uses)
                shown.append(_place(rows.get(use[:2]), str(use.number)) + part)
            yield "".join(shown) + "\n"


def _place(row: Row | None, number: str) -> str:
    """A position in a move: the content of its row instead of its number."""
    if row is None:
        return number
    told = " ".join(" ".join(line.split()) for line in row.lines)
    return f"<{told.partition(NUMBER)[2].lstrip(']={ ').rstrip('}; ')}>"
