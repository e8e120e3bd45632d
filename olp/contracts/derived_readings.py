"""What follows from the texts of declared readings: each in a file beside the `.reading`, which it declares.

`*.damaged` declares what is read of the same texts with a word left out, a number changed, a letter or all lost in some
lines: those lines, others that are read otherwise then, and "as before" below what means the same. `*.loaded` declares
what controllers refuse of these programs (`load.py`), and of sound ones once they are damaged. `*.called` declares the
statements that other languages get of them otherwise than they are read (`Vendor.as_called`), `*.edited` what editors
are told: names (`tokens.py`; = defines, . is local, ~ shows it by no pattern), the lines laid out, and where positions,
speeds and accelerations stand (`written.py`). `*.merged` declares merges of damaged texts.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Final

from olp.checks.merge.merge import merge_bytes
from olp.contracts.promises import Difference
from olp.contracts.readings import (
    INDENT,
    LINE,
    differences,
    fields_of,
    finding_text,
    found_readings,
    load_declared,
    programs_of,
    reading,
    save,
    spelled,
    text_of,
    written_out,
)
from olp.core.diagnostic import OlpError
from olp.core.source import load
from olp.ir.program import Program, Routine
from olp.languages.literals import Token, language, speeds
from olp.languages.loading import Loading
from olp.languages.tokens import Word, Words
from olp.languages.vendor import Vendor, part_of
from olp.transpile.occurrences import with_routines, with_rows

# --- damaged lines --------------------------------------------------------------------------------------------

_DAMAGED: Final = ".damaged"
_TOKEN: Final = re.compile(r"\"[^\"]*\"|'[^']*'|\d+(?:\.\d+)?|[^\W\d][\w$]*|\S")
_LITERAL: Final = re.compile(r"(?<![\w.$])(?<!-)\d+(?:\.\d+)?(?![\w.])")
_WORD: Final = re.compile(r"[^\W\d]{4,}")
_EVERY: Final = 5  # of so many lines one is damaged, so that the others stay what they are
_OTHERS: Final = 8  # lines that are not damaged and shown, where they mean something else
_LONGEST: Final = 400  # characters of a meaning
_AS_BEFORE: Final = f"{INDENT}as before"
_HEAD: Final = "?"  # a line above all others


def _without(text: str, share: float) -> str:
    """The text without one of its tokens."""
    spans = [match.span() for match in _TOKEN.finditer(text)]
    if len(spans) < 2:
        return text
    start, end = spans[min(int(share * len(spans)), len(spans) - 1)]
    return f"{text[:start].rstrip()} {text[end:].lstrip()}".rstrip()


def _without_a_letter(text: str) -> str:
    word = _WORD.search(text)
    return text if word is None else text[: word.start() + 1] + text[word.start() + 2 :]


# (a line, the line above) -> the damaged line
_DAMAGES: Final[tuple[Callable[[str, str], str], ...]] = (
    lambda text, above: _without(text, 1.0),
    lambda text, above: _LITERAL.sub(lambda number: f"-{number[0]}", text, count=1),
    lambda text, above: _without_a_letter(text),
    lambda text, above: _without(text, 0.5),
    lambda text, above: _LITERAL.sub(lambda number: f"{number[0]}x", text, count=1),
    lambda text, above: _LITERAL.sub(lambda number: f"7{number[0]}000", text),
    lambda text, above: "",
    lambda text, above: above,
)


def _damaged(rows: Iterable[str], turn: int) -> list[str]:
    """The lines of a declared reading, some of which are damaged: in each of the turns others, and otherwise."""
    lines = [row for row in rows if LINE.fullmatch(row)]
    found, at = lines[:1], 0
    for above, row in pairwise(lines):
        text = row[4:]
        at += row[0] in "SRP"
        if row[0] in "SRP" and at % _EVERY == turn % _EVERY:
            order = ((at + turn + n) % len(_DAMAGES) for n in range(len(_DAMAGES)))
            text = next(other for n in order if (other := _DAMAGES[n](text, above[4:])) != text)
        found.append(f"{row[:4]}{text}".rstrip())
    return found


def _lines_of(rows: Iterable[str]) -> list[list[str]]:
    """Each line of a reading with what is below it; what is above the first is left out."""
    found: list[list[str]] = []
    for row in rows:
        if LINE.fullmatch(row):
            found.append([row])
        elif found:
            found[-1].append(row)
    return found


def _told_of(whole: list[list[str]], after: list[list[str]]) -> Iterator[str]:
    """The damaged lines with what they mean, some of the others that mean something else then, and how many more do."""
    others = 0
    for one, other in zip(whole, after, strict=True):
        if one == other:
            continue
        if one[0][1:] == other[0][1:]:
            others += 1
            if others > _OTHERS:
                continue
        meaning = [row[:_LONGEST] for row in other[1:] if not row.startswith(f"{INDENT}Opaque ")]
        same = one[0][1:] != other[0][1:] and (one[0][0], one[1:]) == (other[0][0], other[1:])
        yield from [other[0], _AS_BEFORE] if same else [other[0], *meaning]
    if others > _OTHERS:
        yield f"({others - _OTHERS} more lines)"


def damaged_readings(vendor: Vendor, path: Path) -> dict[str, list[str]]:
    """What is read otherwise of the texts in a `.reading` when lines of them are damaged."""
    declared = load_declared(path)
    whole = {name: _lines_of(reading(program)) for name, program in programs_of(vendor, declared)}
    parts: dict[str, list[str]] = {}
    for turn in range(2 * _EVERY):
        texts = {name: _damaged(rows, turn) for name, rows in declared.items()}
        for name, program in programs_of(vendor, texts):
            if told := list(_told_of(whole[name], _lines_of(reading(program)))):
                parts[f"{name}, {turn}"] = told
    return parts


# --- what a controller refuses to load ------------------------------------------------------------------------

_LOADED: Final = ".loaded"


def loaded(vendor: Vendor, path: Path) -> dict[str, list[str]]:
    """What a controller refuses of the programs in a `.reading`, and of a sound folder's once lines are damaged."""
    loading = part_of(vendor.name, "load")
    if loading is None:
        return {}
    declared = load_declared(path)
    found: dict[str, list[str]] = {}
    for controller in loading.controllers:
        found |= _refused(vendor, loading, declared, f", {controller}", controller)
    if not found:
        for turn in range(2 * _EVERY):
            texts = {name: _damaged(rows, turn) for name, rows in declared.items()}
            found |= _refused(vendor, loading, texts, f", {turn}", "")
    return found


def _refused(
    vendor: Vendor, loading: Loading, texts: Mapping[str, list[str]], how: str, controller: str
) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    with written_out(vendor, texts) as folder:
        for name in texts:
            if Path(name).suffix.lower() in vendor.suffixes:
                source = load(folder / name)
                told = loading.refused(source, vendor, controller)
                rows = [(one.source_line, f"{one.line}: {finding_text(one, source.path)}") for one in told]
                if rows:
                    found[f"{name}{how}"] = [
                        row for text, said in rows for row in (f"?   {text}", f"{INDENT}{said}")
                    ]
    return found


# --- what other languages get ---------------------------------------------------------------------------------


def called(vendor: Vendor, path: Path) -> dict[str, list[str]]:
    """The lines of the texts in a `.reading` that mean something else to other languages."""
    parts: dict[str, list[str]] = {}
    for name, program in programs_of(vendor, load_declared(path)):
        routines = {one.name.casefold(): one for one in program.routines}

        def find(name: str, routines: Mapping[str, Routine] = routines) -> Routine | None:
            return routines.get(name.casefold())

        spelt = (
            with_rows(one, vendor.without_editor_comments(vendor.spelled_out(one.body, find)))
            for one in program.routines
        )
        whole, after = (reading(one) for one in (program, vendor.as_called(with_routines(program, spelt))))
        if whole != after:
            rows = zip(_lines_of([_HEAD, *whole]), _lines_of([_HEAD, *after]), strict=True)
            parts[name] = [row for one, other in rows if one != other for row in other]
    return parts


# --- what editors are told ------------------------------------------------------------------------------------


def edited(vendor: Vendor, path: Path) -> dict[str, list[str]]:
    """The lines of the texts in a `.reading` with what editors are told of them."""
    words: Words | None = part_of(vendor.name, "tokens")
    parts: dict[str, list[str]] = {}
    for name, program in programs_of(vendor, load_declared(path)):
        lines = program.source.lines
        layout = words.layout.lines(lines, "  ") if words is not None and words.layout is not None else lines
        places: dict[int, list[str]] = {}
        for at, text in _places(program):
            places.setdefault(at, []).append(text)
        rows: list[str] = []
        for number, (line, laid) in enumerate(zip(lines, layout, strict=True), 1):
            said = " ".join(map(_word, words.words(line))) if words is not None else ""
            told = [said] if said else []
            told += [f"laid out: {laid}"] if laid != line else []
            told += places.get(number, ())
            if told:
                rows += [f"?   {line}", *(f"{INDENT}{one}" for one in told)]
        if rows:
            parts[name] = rows
    return parts


def _word(word: Word) -> str:
    marks = "".join(
        mark for mark, holds in (("=", word.defines), (".", word.local), ("~", word.plain)) if holds
    )
    kind = "" if word.kind is None else f" {word.kind.value}"
    return f"[{word.column}-{word.end_column} {word.key}{kind}{marks}]"


def _places(program: Program) -> Iterator[tuple[int, str]]:
    """(line, what stands there) of all that can be changed in the text."""
    try:
        places = language(program)
    except OlpError:
        return
    for point in places.points(program):
        of = "" if point.source is program.source else f" in {Path(point.source.path).name}"
        target = "" if point.target is None else f" {spelled(point.target)}"
        yield point.line, f"position {point.name}{target} {point.kind}{of}: {_spans(point.numbers)}"
    for line, speed, written, place in speeds(program):
        more = fields_of(place, ("line", "source", "tokens"))
        yield line, f"speed {spelled(speed)} on line {written}: {_spans(place.tokens)} {more}".rstrip()
    for number in range(1, len(program.source.lines) + 1):
        if where := _spans(places.accelerations(program.source, number)):
            yield number, f"acceleration: {where}"


def _spans(tokens: Iterable[Token]) -> str:
    return " ".join(f"{one.line}:{one.start}-{one.stop}{'|' if one.padded else ''}" for one in tokens)


# --- merges ---------------------------------------------------------------------------------------------------

_SIDES: Final = ((0, 1), (2, 2 + _EVERY))  # the turns of damage of two sides: in other lines, and in the same


def merged(vendor: Vendor, path: Path) -> dict[str, list[str]]:
    """What merges make of the texts in a `.reading` when both sides damage lines of them."""
    declared = load_declared(path)
    parts: dict[str, list[str]] = {}
    for turns in _SIDES:
        sides = [{name: _damaged(rows, turn) for name, rows in declared.items()} for turn in turns]
        for name, rows in declared.items():
            if Path(name).suffix.lower() in (*vendor.suffixes, *vendor.list_suffixes):
                texts = ("\n".join([*text_of(one), ""]).encode() for one in (rows, *(s[name] for s in sides)))
                if told := list(_merge(vendor, *texts)):
                    parts[f"{name}, {turns[0]} and {turns[1]}"] = told
    return parts


def _merge(vendor: Vendor, base: bytes, ours: bytes, theirs: bytes) -> Iterator[str]:
    try:
        found = merge_bytes(vendor.name, base, ours, theirs)
    except OlpError as refused:
        yield from (f"refused: {one.message}" for one in refused.diagnostics)
        return
    made = [row.rstrip() for row in found.to_bytes().decode("utf-8", "replace").splitlines()]
    for at, one, other in differences([row.rstrip() for row in base.decode().splitlines()], made):
        yield f"{at}: {one} -> {other}"
    for side, taken in found.taken.items():
        if taken.points or taken.statements:
            yield f"taken from {side}: {', '.join((*taken.points, f'{taken.statements} statements'))}"
    if found.renamed:
        yield f"renamed: {spelled(found.renamed)}"
    for shared in found.shared:
        changed = (
            (side, words) for side, words in (("ours", shared.ours), ("theirs", shared.theirs)) if words
        )
        yield f"shared: line {shared.line}, {', '.join(f'{side} {spelled(words)}' for side, words in changed)}"
    yield from (f"conflict: {one.what} {one.name}".rstrip() for one in found.hunks)


# --- all that follows from a text -----------------------------------------------------------------------------

# Suffix of a file beside a `.reading` -> what stands in it; none where nothing does.
DERIVED: Final[Mapping[str, Callable[[Vendor, Path], dict[str, list[str]]]]] = {
    _DAMAGED: damaged_readings,
    _LOADED: loaded,
    ".called": called,
    ".edited": edited,
    ".merged": merged,
}


def declare(vendor: Vendor, path: Path) -> None:
    """Writes below each line of the texts in a `.reading` what the reader takes it for, for its author to check.

    A line that was just added may have ? for its letter.
    """
    save(path, found_readings(vendor, load_declared(path)))
    for suffix, derive in DERIVED.items():
        if found := derive(vendor, path):
            save(path.with_suffix(suffix), found)
        else:
            path.with_suffix(suffix).unlink(missing_ok=True)


def unlike_derived(vendor: Vendor, path: Path, suffix: str) -> Iterator[Difference]:
    """Where what is declared in the file of this suffix beside a `.reading` and what is found differ."""
    path, parts = path.with_suffix(suffix), DERIVED[suffix](vendor, path)
    declared = load_declared(path) if path.exists() else {}
    for name in dict.fromkeys((*parts, *declared)):
        for at, a, b in differences(declared.get(name, []), parts.get(name, [])):
            yield f"{path.name}, {name}, line {at}", f"declared: {a}; found: {b}"
