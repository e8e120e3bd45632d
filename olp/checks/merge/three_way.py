"""Three-way merge of texts: positions by their identity, statements by their place and words.

A statement that one side changed is taken from that side, whatever its neighbours. If both sides changed it, it
becomes a hunk. Positions that a controller renumbers are identified by the moves that use them, and numbered at the
end.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from typing import NamedTuple

from olp.checks.merge.align import Words, align, likeness, words_of
from olp.checks.merge.compatible import (
    MORE,
    JoinedChange,
    by_arguments,
    by_names,
    changes_words,
    containing,
    with_new_names,
)
from olp.checks.merge.model import Hunk, MergedText, SharedStatement, TakenChanges, TextLine
from olp.languages.merging import (
    COUNTER,
    NUMBER,
    Choice,
    Cut,
    Known,
    MergeRules,
    NumberedUse,
    Piece,
    RecordRule,
    Row,
    TableText,
    later,
    lines_of,
)

_FLOAT = re.compile(r"[-+]?\d*\.?\d+(?:[eE][-+]?\d+)?")
_WORD = re.compile(r"\w+")
_DIGIT = re.compile(r"\d")  # what says no value is like any other
_MARK = "\xef\xbb\xbf"  # that a text is UTF-8, in front of its first line
_TOUCHED = 0.3  # of the likeness of two moves: how much their points say


class MergeItem(NamedTuple):
    """A piece in a merge: `ids` of its positions instead of their numbers. `at`: its index."""

    piece: Piece
    ids: tuple[str, ...] = ()
    at: int = -1
    joined: JoinedChange | None = None  # both changed it

    def same(self, other: MergeItem) -> bool:
        return self.piece.lines == other.piece.lines and self.ids == other.ids

    @property
    def says(self) -> tuple[str, tuple[str, ...]]:
        """Executable content: code and positions."""
        return self.piece.code, self.ids

    @property
    def words(self) -> tuple[str, tuple[str, ...]]:
        """Executable content and comment."""
        return " ".join(" ".join(self.piece.lines).split()), self.ids


class Clash(NamedTuple):
    """Items in conflict."""

    what: str
    name: str
    why: str
    base: tuple[MergeItem, ...]
    ours: tuple[MergeItem, ...]
    theirs: tuple[MergeItem, ...]


class TableHere(NamedTuple):
    name: str


Settled = MergeItem | Clash | TableHere


def merge_texts(rules: MergeRules, base: str, ours: str, theirs: str) -> MergedText:
    """The merge of three texts of one language, with the conflicts as hunks.

    The sides are processed in the order of their texts, whichever of them is called ours: swapped, they give the
    same result.
    """
    if theirs < ours:
        return merge_texts(rules, base, theirs, ours).swapped()
    base, ours, theirs = _in_one_order(rules, rules.renamed(base, ours, theirs))
    marks = [text.startswith(_MARK) for text in (base, ours, theirs)]
    texts = with_new_names(rules, *(text.removeprefix(_MARK) for text in (base, ours, theirs)))
    merged = _merged_in_order(rules, texts.base, texts.ours, texts.theirs)
    if texts.by_ours or texts.by_theirs:
        merged = replace(merged, renamed={"ours": texts.by_ours, "theirs": texts.by_theirs})
    if marks[2] if marks[0] == marks[1] else marks[1]:
        return replace(merged, parts=(TextLine(_MARK, None), *merged.parts))
    return merged


def _merged_in_order(rules: MergeRules, base: str, ours: str, theirs: str) -> MergedText:
    known: Known = {}
    cuts = _unscoped([rules.cut(text, known) for text in (base, ours, theirs)])
    if not all(cut.pieces for cut in cuts) or len({frozenset(cut.rows) for cut in cuts}) > 1:
        return _whole(ours, theirs, _newline((base, ours, theirs))[0])
    twice = _written_twice(cuts)
    versions = [_Version(cut, twice) for cut in cuts]
    first, *sides = versions
    pairs = [_aligned(first, side) for side in sides]
    fixed = frozenset(chain.from_iterable(cut.fixed for cut in cuts))
    first.identify({})
    for side, found in zip(sides, pairs, strict=True):
        side.identify(_followed(first, side, found, fixed))
    work = _Merge(rules, first, sides[0], sides[1])
    settled = work.settled(*pairs)
    return _MergeWriter(work, fixed, (base, ours, theirs)).written(settled)


def _in_one_order(rules: MergeRules, texts: tuple[str, str, str]) -> tuple[str, str, str]:
    """The three texts with their routines in the order of the one side that changed it."""
    first, *others = map(rules.routine_names, texts)
    if all(names == first for names in others):
        return texts
    cuts = [rules.by_routines(text) for text in texts]
    base, ours, theirs = ([name for name, _ in parts if name] for parts in cuts)
    if any(len(set(names)) < len(names) for names in (base, ours, theirs)):
        return texts
    moved = [[n for n in side if n in base] != [n for n in base if n in side] for side in (ours, theirs)]
    if moved[0] == moved[1]:
        return texts  # neither, or each side has an order of its own
    order = ours if moved[0] else theirs
    found = []
    for parts in cuts:
        routines = dict(parts)
        rest = (name for name in order if name in routines)
        found.append("".join(routines[next(rest)] if name in order else text for name, text in parts))
    return found[0], found[1], found[2]


def _unscoped(cuts: Sequence[Cut]) -> list[Cut]:
    """Cuts in which names that occur once in every version lose their routine, because the routine may be renamed."""
    often: list[Counter[str]] = []
    whole: dict[str, set[str]] = {}
    for cut in cuts:
        names = [piece.name for piece in cut.pieces if "/" in piece.name]
        often.append(Counter(name.rpartition("/")[2] for name in names))
        for name in names:
            whole.setdefault(name.rpartition("/")[2], set()).add(name)
    alone = {name for name, of in whole.items() if len(of) > 1 and all(one[name] <= 1 for one in often)}
    if not alone:
        return list(cuts)

    def named(piece: Piece) -> Piece:
        head, slash, name = piece.name.rpartition("/")
        return replace(piece, name=f"/{name}") if slash and head and name in alone else piece

    return [
        replace(cut, pieces=[named(piece) if piece.name else piece for piece in cut.pieces]) for cut in cuts
    ]


def _whole(ours: str, theirs: str, newline: str) -> MergedText:
    """Merge without a base: all that differs between the common beginning and the common end is one hunk."""
    mine, other = ([TextLine(*line) for line in lines_of(text)] for text in (ours, theirs))
    most = min(len(mine), len(other))
    start = next((k for k in range(most) if mine[k] != other[k]), most)
    most -= start
    stop = next((k for k in range(most) if mine[-1 - k] != other[-1 - k]), most)
    a, b = mine[start : len(mine) - stop], other[start : len(other) - stop]
    why = "there is no common version that it could be held against"
    lines = tuple(range(start + 1, start + len(a) + 1)), tuple(range(start + 1, start + len(b) + 1))
    middle = (Hunk("file", "", why, tuple(a), tuple(b), (), *lines),) if a or b else ()
    return MergedText((*mine[:start], *middle, *mine[len(mine) - stop :]), newline)


def _written_twice(cuts: Iterable[Cut]) -> frozenset[str]:
    """Names of several pieces, which therefore identify none."""
    found: set[str] = set()
    for cut in cuts:
        count = Counter(piece.name for piece in cut.pieces if piece.name)
        found.update(name for name, often in count.items() if often > 1)
    return frozenset(found)


class _Version:
    """One text with its pieces, positions and names."""

    def __init__(self, cut: Cut, twice: frozenset[str]) -> None:
        self.cut, self.pieces = cut, cut.pieces
        self.names = ["" if piece.name in twice else piece.name for piece in cut.pieces]
        self.rows: dict[tuple[str, int], Row] = {
            (row.use.family, row.use.number): row for rows in cut.rows.values() for row in rows
        }
        self.table = {
            (row.use.family, row.use.number): name for name, rows in cut.rows.items() for row in rows
        }
        self.content = {key: _content(row) for key, row in self.rows.items()}
        self.codes = [
            f"\4{name}" if name else self._code(piece)
            for name, piece in zip(self.names, self.pieces, strict=True)
        ]
        self.items: list[MergeItem] = []
        self.by_name: dict[str, MergeItem] = {}
        self.by_id: dict[str, Row] = {}
        self.content_of: dict[str, str] = {}
        self.table_of: dict[str, str] = {}

    def _code(self, piece: Piece) -> str:
        if not piece.uses:
            return piece.code
        return f"{piece.code}\5{'|'.join(self._content(use) for use in piece.uses)}"

    def _content(self, use: NumberedUse) -> str:
        return self.content.get((use.family, use.number), f"{use.family} {use.number}")

    def identify(self, known: Mapping[tuple[str, int], str]) -> None:
        """Give every position its identity: that of `known`, else its own number."""

        def name(family: str, number: int) -> str:
            return known.get((family, number)) or f"{family} {number}"

        self.items = [
            MergeItem(
                piece, tuple(name(use.family, use.number) for use in piece.uses) if piece.uses else (), at
            )
            for at, piece in enumerate(self.pieces)
        ]
        self.by_name = {name: self.items[at] for at, name in enumerate(self.names) if name}
        self.by_id = {name(*key): row for key, row in self.rows.items()}
        self.content_of = {name(*key): content for key, content in self.content.items()}
        self.table_of = {name(*key): table for key, table in self.table.items()}

    def counts(self, name: str, rules: MergeRules) -> bool:
        """Whether the record of this name has the correct count."""
        item = self.by_name.get(name)
        totals = Counter(family for family, _ in self.rows)
        lines = sum(text.startswith(COUNTER) for piece in self.pieces for text in piece.lines[:1])
        return item is not None and rules.counted(item.piece, totals, lines) == item.piece.lines[0]

    def once(self, keys: Iterable[tuple[str, int]], whole: bool) -> dict[str, tuple[str, int]]:
        """Those of these positions whose row is unique, with the records before it (`whole`) or alone; by its text."""
        says = {key: self.content[key] for key in keys}
        if not whole:
            says = {
                key: "".join(text.split("\6", len(self.rows[key].means))[-1:]) for key, text in says.items()
            }
        often = Counter(says.values())
        return {text: key for key, text in says.items() if often[text] == 1}

    @cached_property
    def often(self) -> Counter[tuple[str, tuple[str, ...]]]:
        """Number of occurrences of each statement."""
        return Counter(item.says for item in self.items)

    @cached_property
    def words(self) -> set[str]:
        """Every word of its statements, lower case."""
        found: set[str] = set()
        pieces = zip(self.pieces, self.names, strict=True)
        for code in {piece.code for piece, name in pieces if not name and not piece.says_nothing}:
            found.update(word.casefold() for word in _WORD.findall(code))
        return found

    @cached_property
    def words_of_data(self) -> set[str]:
        """Every word of its data, lower case: a value may refer to other data."""
        named = {
            line for piece, name in zip(self.pieces, self.names, strict=True) if name for line in piece.lines
        }
        return {word.casefold() for line in named for word in _WORD.findall(line)}

    @cached_property
    def lines_at(self) -> list[int]:
        """The first line of each piece, from 1."""
        found, line = [], 1
        for piece in self.pieces:
            found.append(line)
            line += len(piece.lines)
            rows = self.cut.rows.get(piece.name, ()) if not piece.lines else ()
            line += sum(len(row.lead) + len(row.lines) for row in rows)
            line += len(self.cut.tails.get(piece.name, ())) if not piece.lines else 0
        return found


def _content(row: Row) -> str:
    return "\6".join((*row.means, *(" ".join(line.split()) for line in row.lines)))


# --- Which piece is which ---


def _aligned(base: _Version, side: _Version) -> list[tuple[int, int]]:
    known: dict[str, Words] = {}

    def kind(version: _Version, at: int) -> tuple[Words, int, bool] | None:
        """Properties that two pieces must share to be similar at all; None for a named piece, which its name
        identifies.
        """
        piece = version.pieces[at]
        if version.names[at] or not piece.code:
            return None
        words = known.get(piece.code)
        if words is None:
            words = known[piece.code] = words_of(piece.code)
        return words, len(piece.uses), piece.says_nothing

    here: dict[int, tuple[Words, int, bool] | None] = {}
    there: dict[int, tuple[Words, int, bool] | None] = {}

    def alike(i: int, j: int) -> float:
        one = here[i] if i in here else here.setdefault(i, kind(base, i))
        other = there[j] if j in there else there.setdefault(j, kind(side, j))
        if one is None or other is None or one[1:] != other[1:]:
            return 0.0
        common = likeness(one[0], other[0])
        if not one[1]:
            return common
        moved = _moved(base, side, base.pieces[i], side.pieces[j])
        # Where the arm goes says more than how: a straight move that became a joint move is still the same.
        return common - _TOUCHED * moved if moved else 0.5 + 0.5 * common

    return align(base.codes, side.codes, alike)


def _moved(base: _Version, side: _Version, a: Piece, b: Piece) -> float:
    """Difference of the positions of two moves, 0 to 1 [1]."""
    parts = []
    for one, other in zip(a.uses, b.uses, strict=True):
        here, there = base.content.get(one[:2], ""), side.content.get(other[:2], "")
        if here == there:
            parts.append(0.0)
            continue
        far = _apart(here, there)
        parts.append(far if one[:2] == other[:2] else 0.5 + 0.5 * far)
    return sum(parts) / len(parts)


def _apart(here: str, there: str) -> float:
    a = [float(text) for text in _FLOAT.findall(here.rpartition("=")[2])]
    b = [float(text) for text in _FLOAT.findall(there.rpartition("=")[2])]
    if len(a) != len(b) or not a:
        return 1.0
    whole = sum(abs(x) + abs(y) for x, y in zip(a, b, strict=True))
    return min(1.0, 2.0 * sum(abs(x - y) for x, y in zip(a, b, strict=True)) / whole) if whole else 0.0


def _followed(
    base: _Version, side: _Version, pairs: Sequence[tuple[int, int]], fixed: frozenset[str]
) -> dict[tuple[str, int], str]:
    """Identity of each position of a side: that of the base's position which the same moves use, or a new one."""
    found: dict[tuple[str, int], str] = {}
    claimed: set[tuple[str, int]] = set()

    def claim(one: tuple[str, int], other: tuple[str, int]) -> None:
        if one[0] == other[0] and one not in claimed and other not in found:
            claimed.add(one)
            found[other] = f"{one[0]} {one[1]}"

    keys = set(side.rows) | {use[:2] for piece in side.pieces for use in piece.uses}
    for key in keys:
        if key[0] in fixed or (key not in side.rows and key not in base.rows):
            found[key] = f"{key[0]} {key[1]}"
    used = [
        (one[:2], other[:2])
        for i, j in pairs
        if base.pieces[i].uses and len(base.pieces[i].uses) == len(side.pieces[j].uses)
        for one, other in zip(base.pieces[i].uses, side.pieces[j].uses, strict=True)
    ]
    same = [pair for pair in used if base.content.get(pair[0]) == side.content.get(pair[1])]

    def found_again() -> Iterator[tuple[tuple[str, int], tuple[str, int]]]:
        """Pairs of positions with a content that is unique on both sides, whatever became of their moves."""
        for whole in (True, False):
            before = base.once(base.rows.keys() - claimed, whole)
            now = side.once(side.rows.keys() - found.keys(), whole)
            yield from ((before[text], now[text]) for text in sorted(before.keys() & now.keys()))

    for one, other in chain(
        (p for p in same if p[0] == p[1]), same, found_again(), (p for p in used if p[0] == p[1])
    ):
        claim(one, other)
    for key in sorted(keys & set(base.rows)):
        if base.content[key] == side.content.get(key):
            claim(key, key)
    for one, other in used:
        claim(one, other)
    # A position that no move uses on either side has nothing but its number.
    busy = {use[:2] for version in (base, side) for piece in version.pieces for use in piece.uses}
    for key in sorted((keys & set(base.rows)) - busy):
        claim(key, key)
    often: Counter[str] = Counter()
    for key in sorted(keys - set(found)):
        content = f"new {key[0]} {side.content.get(key, key[1])}"
        often[content] += 1
        found[key] = f"{content} {often[content]}"
    return found


# --- Which side holds ---


class _MergedRow(NamedTuple):
    """Merged state of a position: `row` None: deleted. `clash`: ours and theirs. `side`: name of the side that
    changed it.
    """

    row: Row | None
    clash: tuple[Row | None, Row | None] | None = None
    side: str = ""


@dataclass(slots=True)
class _Taken:
    points: list[str] = field(default_factory=list)
    statements: int = 0


class _Merge:
    """The three versions of one text while they are merged."""

    def __init__(self, rules: MergeRules, base: _Version, ours: _Version, theirs: _Version) -> None:
        self.rules, self.base, self.ours, self.theirs = rules, base, ours, theirs
        self.taken = {"ours": _Taken(), "theirs": _Taken(), "both": _Taken()}
        self._emitted: set[str] = set()
        self._disputed: dict[int, str] = {}
        self._new: dict[int, set[str]] = {}

    def settled(self, ours: Sequence[tuple[int, int]], theirs: Sequence[tuple[int, int]]) -> list[Settled]:
        """The merged pieces in order."""
        a, b = _Matched(self.base, self.ours, ours), _Matched(self.base, self.theirs, theirs)
        self._disputed = self._kept_whole("ours", a, b) | self._kept_whole("theirs", b, a)
        found: list[Settled] = []
        for at in range(len(self.base.items) + 1):
            found += self._between(a, b, at)
            if at < len(self.base.items):
                found += self._piece(a, b, at)
        return list(_joined(found))

    def _kept_whole(self, word: str, gone: _Matched, other: _Matched) -> dict[int, str]:
        """Runs that one side deleted together with something that the other changes or calls: they become one
        conflict.

        Reasons by index in the base.
        """
        found: dict[int, str] = {}
        run: list[int] = []
        for at in range(len(self.base.items) + 1):
            if at < len(self.base.items) and gone.gone(at):
                run += [] if self.base.names[at] else [at]
                continue
            why = next(filter(None, (self._disputes(k, gone, other) for k in run)), "")
            if why:
                by = "theirs" if word == "ours" else "ours"
                found |= dict.fromkeys(run, f"{word} takes it out, {by} {why}")
            run = []
        return found

    def _disputes(self, at: int, gone: _Matched, other: _Matched) -> str:
        """What the other side does with a piece that one side deleted, "" if nothing."""
        base, kept = self.base.items[at], other.of[at]
        if kept is None:
            return ""
        if not self._as_it_was(base, kept) and not (self._remark(base) and self._remark(kept)):
            return "changes it"
        new = other.inserted.get(at)
        if new and at not in gone.inserted and _context(other, gone, new, at):
            return "changes it"
        edge = self.rules.scope.match(base.piece.lines[0])
        name = (edge[1] or "").casefold() if edge is not None else ""
        if name and name not in gone.version.words and name in self._new_words(other.version):
            return "calls it"
        return ""

    # --- what stands between two pieces of the base

    def _between(self, a: _Matched, b: _Matched, at: int) -> Iterator[Settled]:
        ours, theirs = a.inserted.get(at, ()), b.inserted.get(at, ())
        if not ours and not theirs:
            return
        if [one.words for one in ours] == [one.words for one in theirs]:
            self.taken["both"].statements += len(ours)
            yield from self._each(_nicer(ours, theirs))
        elif not ours or not theirs:
            mine, other, word = (a, b, "ours") if ours else (b, a, "theirs")
            new = ours or theirs
            why = _context(mine, other, new, at)
            if why:
                yield from self._clash(why, ours, theirs)
                return
            self.taken[word].statements += len(new)
            yield from self._each(new)
        else:
            yield from self._both(ours, theirs, at)

    def _both(self, ours: Sequence[MergeItem], theirs: Sequence[MergeItem], at: int) -> Iterator[Settled]:
        """Items where both sides inserted something before piece `at` of the base."""
        if self._independent(ours, theirs, at):
            self._count(ours, theirs)
            yield from self._each((*ours, *theirs))
            return
        if all(one.piece.loose or not one.piece.code for one in (*ours, *theirs)):
            self._count(ours, theirs)
            yield from self._each(_by_groups(ours, theirs))
            return
        for silent, other in ((ours, theirs), (theirs, ours)):
            # A remark stands above what it may be about.
            if all(one.piece.says_nothing for one in silent) and not all(
                one.piece.says_nothing for one in other
            ):
                self._count(ours, theirs)
                yield from self._each((*silent, *other))
                return
        start = 0
        most = min(len(ours), len(theirs))
        while start < most and self._both_said(ours[start], theirs[start]):
            start += 1
        stop = 0
        while stop < most - start and self._both_said(ours[-1 - stop], theirs[-1 - stop]):
            stop += 1
        mine, other = ours[start : len(ours) - stop], theirs[start : len(theirs) - stop]
        yield from self._each(filter(None, map(self._both_said, ours[:start], theirs[:start])))
        if not mine or not other:
            # What one side put there is part of what the other did.
            self._count(mine, other)
            yield from self._each((*mine, *other))
        elif all(self._remark(one) for one in (*mine, *other)):
            # Nothing runs otherwise: every remark is kept, and the blank lines of one side.
            self._count(mine, other)
            said = [one for one in other if one.piece.lines[0].strip()]
            told = any(one.piece.lines[0].strip() for one in mine)
            yield from self._each((*mine, *(said if told else other)))
        elif all(self._remark(one) or _is_named(one) for one in (*mine, *other)):
            self._count(mine, other)
            yield from self._each((*mine, *other))
        else:
            yield from self._clash("both put something here", mine, other)
        yield from self._each(
            filter(None, map(self._both_said, ours[len(ours) - stop :], theirs[len(theirs) - stop :]))
        )

    def _both_said(self, ours: MergeItem, theirs: MergeItem) -> MergeItem | None:
        """The same statement, with the comment of one of them; None: they are two statements."""
        if ours.words == theirs.words:
            return _nicer([ours], [theirs])[0]
        if ours.says != theirs.says or len(ours.piece.lines) != 1 or len(theirs.piece.lines) != 1:
            return None
        remarks = [self.rules.split(one.piece.lines[0])[2].strip() for one in (ours, theirs)]
        if remarks[0] == remarks[1]:
            return _nicer([ours], [theirs])[0]
        return None if all(remarks) else ours if remarks[0] else theirs

    def _independent(self, ours: Sequence[MergeItem], theirs: Sequence[MergeItem], at: int) -> bool:
        """Whether both sides consist of routines, branches for constants or declarations, and share none."""
        behind = (one for one in self.base.pieces[at:] if one.lines and not one.says_nothing)
        after = next((one.lines[0] for one in behind), "")
        sides = [[line for one in items for line in one.piece.lines] for items in (ours, theirs)]
        for kind in (self.rules.routines, lambda lines: self.rules.branches(lines, after), self._declared):
            mine, other = map(kind, sides)
            if mine and other and not set(mine) & set(other):
                return True
        return False

    def _declared(self, lines: Sequence[str]) -> list[str]:
        """The names that these lines declare, if they contain nothing else."""
        found: list[str] = []
        for line in lines:
            names = self.rules.declared(self.rules.split(line)[1])[1]
            if not names and not self.rules.is_silent(line):
                return []
            found += names
        return found

    def _remark(self, item: MergeItem) -> bool:
        """Whether the item is a plain comment: no statement, and no comment that carries structure."""
        return item.piece.says_nothing and not self.rules.structure.match(item.piece.lines[0])

    def _clash(self, why: str, ours: Sequence[MergeItem], theirs: Sequence[MergeItem]) -> Iterator[Settled]:
        """A conflict of statements, and after it the data among them, merged separately."""
        after: list[Settled] = []

        def side(items: Sequence[MergeItem]) -> Iterator[MergeItem]:
            for item in items:
                name = self._name(item)
                found = list(self._named(name)) if name else [item]
                if len(found) == 1 and isinstance(found[0], MergeItem):
                    yield found[0]
                else:
                    after.extend(found)

        yield Clash("statement", "", why, (), tuple(side(ours)), tuple(side(theirs)))
        yield from after

    def _count(self, ours: Sequence[MergeItem], theirs: Sequence[MergeItem]) -> None:
        self.taken["ours"].statements += len(ours)
        self.taken["theirs"].statements += len(theirs)

    def _each(self, items: Iterable[MergeItem]) -> Iterator[Settled]:
        for item in items:
            name = self._name(item)
            if not name:
                yield item
            elif not item.piece.lines:
                yield TableHere(name)
            else:
                yield from self._named(name)

    def _name(self, item: MergeItem) -> str:
        name = item.piece.name
        known = (self.base.by_name, self.ours.by_name, self.theirs.by_name)
        return name if any(name in one for one in known) else ""

    # --- one piece of the base

    def _piece(self, a: _Matched, b: _Matched, at: int) -> Iterator[Settled]:
        base, name = self.base.items[at], self.base.names[at]
        ours, theirs = a.of[at], b.of[at]
        if name:
            # What one side has put elsewhere is written there.
            moved = (ours is None and name in self.ours.by_name) or (
                theirs is None and name in self.theirs.by_name
            )
            if not base.piece.lines:
                yield TableHere(name)
            elif not moved or (ours is None and theirs is None):
                yield from self._named(name)
        elif ours is None and theirs is None:
            elsewhere = self._elsewhere(base)
            if elsewhere:
                # Neither side has it here: the name says what it is about.
                yield Clash("statement", base.piece.code.replace(NUMBER, "#"), elsewhere, (base,), (), ())
            else:
                self.taken["both"].statements += 1
        elif ours is None or theirs is None:
            kept = ours or theirs
            assert kept is not None
            word, other = ("ours", "theirs") if ours is None else ("theirs", "ours")
            why = self._disputed.get(at, "")
            if not why and self._as_it_was(base, kept):
                self.taken[word].statements += 1
                return
            if not why and self._remark(base) and self._remark(kept):
                yield kept
                return
            why = why or f"{word} takes it out, {other} changes it"
            yield Clash("statement", "", why, (base,), _tuple(ours), _tuple(theirs))
        else:
            merged = self._merged(base, ours, theirs)
            if merged is None and all(self._remark(one) for one in (base, ours, theirs)):
                self._count((ours,), (theirs,))
                yield from (ours, theirs)
            elif merged is None:
                yield Clash("statement", "", "both change it", (base,), (ours,), (theirs,))
            else:
                yield merged

    def _as_it_was(self, base: MergeItem, kept: MergeItem) -> bool:
        """Whether nothing but blanks changed."""
        if kept.words == base.words:
            return True
        if kept.says != base.says or len(kept.piece.lines) != 1 or len(base.piece.lines) != 1:
            return False
        remarks = [self.rules.split(one.piece.lines[0])[2].split() for one in (base, kept)]
        return remarks[0] == remarks[1]

    def _elsewhere(self, base: MergeItem) -> str:
        """Reason for a conflict where one side deleted what the other moved; "" if that is not the case."""
        if base.piece.says_nothing:
            return ""
        b, o, t = (one.often[base.says] for one in (self.base, self.ours, self.theirs))
        if (o < b) == (t < b):
            return ""
        gone, moved = ("ours", "theirs") if o < b else ("theirs", "ours")
        return f"{gone} takes it out, {moved} has it elsewhere"

    def _merged(self, base: MergeItem, ours: MergeItem, theirs: MergeItem) -> MergeItem | None:
        """The merged item; None: both sides changed the same part of it."""
        if ours.same(theirs):
            self.taken["both"].statements += not ours.same(base)
            ends = base.piece.ends, ours.piece.ends, theirs.piece.ends
            return theirs if ends[0] == ends[1] or (ends[0] != ends[2] and ends[2] > ends[1]) else ours
        if ours.same(base) or theirs.same(base):
            self.taken["theirs" if ours.same(base) else "ours"].statements += 1
            return theirs if ours.same(base) else ours
        versions = (base, ours, theirs)
        if all(len(one.piece.lines) == 1 for one in versions):
            return self._by_slots(base, ours, theirs)
        if ours.words == theirs.words:
            return _nicer([ours], [theirs])[0]
        return ours if theirs.words == base.words else theirs if ours.words == base.words else None

    def _by_slots(self, base: MergeItem, ours: MergeItem, theirs: MergeItem) -> MergeItem | None:
        """Merge indentation, code and comment of a line independently."""
        slots = [self.rules.split(one.piece.lines[0]) for one in (base, ours, theirs)]
        texts: list[str] = []
        chosen = ours
        joined: JoinedChange | None = None
        for number, (b, o, t) in enumerate(zip(*slots, strict=True)):
            if number != 1:
                text = _slot((b, o, t), [tuple(one.split()) for one in (b, o, t)])
            else:
                text = _slot((b, o, t), [(one.piece.code, one.ids) for one in (base, ours, theirs)])
                chosen = theirs if text == t else ours
                if text is None and base.ids == ours.ids == theirs.ids:
                    text = t if b == o == t else self._by_value((b, o, t))
            if text is None and joined is None:
                joined = self._joined((b, o, t), (base, ours, theirs) if number == 1 else None)
                if joined is not None:
                    text = joined.text
                    chosen = (base, ours, theirs)[joined.place] if number == 1 else chosen
            if text is None:
                return None
            texts.append(text)
        for word in ("ours", "theirs"):
            self.taken[word].statements += 1
        line = "".join(texts)
        piece = Piece(
            (line,), chosen.piece.ends, chosen.piece.code, chosen.piece.name, chosen.piece.loose,
            chosen.piece.rule, chosen.piece.uses,
        )  # fmt: skip
        return MergeItem(piece, chosen.ids, chosen.at, joined)

    def _joined(
        self, texts: tuple[str, str, str], items: tuple[MergeItem, MergeItem, MergeItem] | None
    ) -> JoinedChange | None:
        """Combine both changes of the code of a line, or of its comment (`items` None)."""
        base, ours, theirs = ids = [one.ids for one in items] if items is not None else [(), (), ()]
        found = by_arguments(self.rules, texts, ids) or by_names(self.rules, texts)
        if found is not None:
            return found
        side = containing(*map(self.rules.code, texts) if items is not None else texts)
        less, more = (ours, theirs) if side == 2 else (theirs, ours)
        if not side or less not in (base, more):
            return None
        told = (MORE,) if changes_words(texts[0], texts[3 - side]) else ()  # else it is but spelled otherwise
        return JoinedChange(texts[side], told if side == 1 else (), told if side == 2 else (), side)

    def _by_value(self, codes: tuple[str, str, str]) -> str | None:
        """Merge declaration and value of a definition separately."""
        parts = [code.partition("=") for code in codes]
        if any(not sign for _, sign, _ in parts) or not all(map(self.rules.data_name, codes)):
            return None
        found = [
            _slot((b, o, t), [self.rules.code(one) for one in (b, o, t)])
            for b, o, t in zip(*((head, value) for head, _, value in parts), strict=True)
        ]
        return None if found[0] is None or found[1] is None else f"{found[0]}={found[1]}"

    # --- what has a name

    def _named(self, name: str) -> Iterator[Settled]:
        if name in self._emitted:
            return
        self._emitted.add(name)
        whole = self._whole_data.get(name)
        if whole is not None:
            self._emitted.update(item.piece.name for item in chain(whole.base, whole.ours, whole.theirs))
            yield whole
            return
        base, ours, theirs = (one.by_name.get(name) for one in (self.base, self.ours, self.theirs))
        shown = name.rpartition("/")[2].removeprefix("head ")
        what = "record" if "head " in name else "data"
        if ours is None or theirs is None:
            kept, gone = (theirs, self.ours) if ours is None else (ours, self.theirs)
            if base is None and kept is not None:
                if what == "data":
                    self._note("theirs" if ours is None else "ours", shown)
                yield kept
            elif kept is not None and base is not None and not self._gone(shown, base, kept, gone):
                if self._as_it_was(base, kept) or kept.piece.rule is not RecordRule.ASK:
                    yield kept
                else:
                    word, other = ("ours", "theirs") if ours is None else ("theirs", "ours")
                    why = f"{word} takes it out, {other} changes it"
                    yield Clash(what, shown, why, _tuple(base), _tuple(ours), _tuple(theirs))
            return
        rule = ours.piece.rule
        if rule in (RecordRule.NEWEST, RecordRule.GREATEST) and not ours.same(theirs):
            yield ours if later(ours.piece.code, theirs.piece.code) == ours.piece.code else theirs
            return
        if base is None:
            merged = _nicer([ours], [theirs])[0] if ours.words == theirs.words else None
        else:
            merged = self._merged(base, ours, theirs)
            if merged is not None and not merged.same(base) and what == "data":
                self._note(_who(base.says, ours.says, theirs.says), shown)
        if rule is RecordRule.COUNTED:
            yield merged or ours
        elif merged is None and rule is RecordRule.SAVED_LAST:
            yield theirs if self._theirs_last else ours
        elif merged is None:
            yield Clash(what, shown, "both change it", _tuple(base), (ours,), (theirs,))
        else:
            yield merged

    @cached_property
    def _theirs_last(self) -> bool:
        """Whether theirs was saved after ours, by their date records; without any, the order of texts decides."""
        rules = (RecordRule.NEWEST, RecordRule.GREATEST)
        for name, item in self.ours.by_name.items():
            other = self.theirs.by_name.get(name)
            if item.piece.rule in rules and other is not None and item.piece.code != other.piece.code:
                return later(item.piece.code, other.piece.code) == other.piece.code
        return True

    @cached_property
    def _whole_data(self) -> dict[str, Clash]:
        """Conflicts of whole data, by the names of all their items."""
        base, ours, theirs = (_grouped(one) for one in (self.base, self.ours, self.theirs))
        found: dict[str, Clash] = {}
        for clash in (
            *_named_twice(base, ours, theirs),
            *_changed_and_gone(base, ours, theirs, "ours"),
            *_changed_and_gone(base, ours, theirs, "theirs"),
        ):
            found.update({item.piece.name: clash for item in chain(clash.base, clash.ours, clash.theirs)})
        return found

    def _note(self, word: str, name: str) -> None:
        if word:
            self.taken[word].points.append(name)

    def _gone(self, name: str, base: MergeItem, kept: MergeItem, gone: _Version) -> bool:
        """Whether what one side deleted may go: the other neither changed it nor has begun to use it."""
        if not self._as_it_was(base, kept):
            return False
        word = next(iter(_WORD.findall(name)), "").casefold()
        kept_by = self.theirs if gone is self.ours else self.ours
        if word in gone.words or word not in kept_by.words or word not in self._new_words(kept_by):
            return True
        return word in gone.words_of_data

    def _new_words(self, side: _Version) -> set[str]:
        """Words of statements that the base does not have."""
        found = self._new.get(id(side))
        if found is None:
            same = {id(piece) for piece in self.base.pieces}  # a line is one piece in all versions
            found = self._new[id(side)] = set()
            for item in side.items:
                if (id(item.piece) in same and not item.ids) or item.piece.says_nothing:
                    continue
                if self._is_new(item):
                    found.update(word.casefold() for word in _WORD.findall(item.piece.code))
        return found

    def _is_new(self, item: MergeItem) -> bool:
        """Whether the base has no such piece."""
        name = item.piece.name
        if not name:
            return item.says not in self._said
        known = self.base.by_name.get(name)
        if known is not None:
            return known.says != item.says
        own = name.rpartition("/")[2]
        return own not in self._own_names or item.says not in self.base.often

    @cached_property
    def _said(self) -> set[tuple[str, tuple[str, ...]]]:
        """Contents of the base's unnamed pieces."""
        return {item.says for item in self.base.items if not item.piece.name}

    @cached_property
    def _own_names(self) -> set[str]:
        """Names in the base, without their routine."""
        return {item.piece.name.rpartition("/")[2] for item in self.base.items}

    # --- positions with numbers

    def row(self, name: str, used: bool) -> _MergedRow:
        """Merged state of a position, `used` by a statement of the merge."""
        ours, theirs = self.ours.by_id.get(name), self.theirs.by_id.get(name)
        b, o, t = (one.content_of.get(name) for one in (self.base, self.ours, self.theirs))
        if o == t:
            return _MergedRow(_nicer_row(ours, theirs), side="both" if o != b else "")
        if o == b or t == b:
            # What one side took out stays where the other has begun to use it.
            kept, word = (theirs, "theirs") if o == b else (ours, "ours")
            if kept is None and used:
                return _MergedRow(ours or theirs)
            return _MergedRow(kept, side=word)
        base = self.base.by_id.get(name)
        joined = self.rules.joined_row(base, ours, theirs) if base and ours and theirs else None
        if joined is not None:
            return _MergedRow(joined, side="ours theirs")
        return _MergedRow(None, (ours, theirs))


def _grouped(version: _Version) -> dict[str, list[MergeItem]]:
    """Data by their names, with the values of an array as one group."""
    found: dict[str, list[MergeItem]] = {}
    for name, item in version.by_name.items():
        if item.piece.loose and item.piece.lines:
            found.setdefault(name.partition("[")[0], []).append(item)
    return found


_Groups = Mapping[str, Sequence[MergeItem]]


def _named_twice(base: _Groups, ours: _Groups, theirs: _Groups) -> Iterator[Clash]:
    """Conflicts of data that both sides renamed differently."""
    gone = base.keys() - ours.keys() - theirs.keys()
    if not gone:
        return
    mine = _by_words(ours, ours.keys() - base.keys() - theirs.keys())
    other = _by_words(theirs, theirs.keys() - base.keys() - ours.keys())
    for words, name in _by_words(base, gone).items():
        if _DIGIT.search(words) and words in mine and words in other:
            sides = tuple(ours[mine[words]]), tuple(theirs[other[words]])
            shown = name.rpartition("/")[2]
            yield Clash("data", shown, "both give it another name", tuple(base[name]), *sides)


def _changed_and_gone(base: _Groups, ours: _Groups, theirs: _Groups, word: str) -> Iterator[Clash]:
    """Conflicts of data of several parts that the side `word` deleted or renamed, and the other one changed."""
    gone, kept = (ours, theirs) if word == "ours" else (theirs, ours)
    names = sorted(name for name in (base.keys() - gone.keys()) & kept.keys() if len(base[name]) > 1)
    new = _by_words(gone, gone.keys() - base.keys() - kept.keys()) if names else {}
    for name in names:
        was, now = ({item.piece.name: item.says for item in of[name]} for of in (base, kept))
        other = new.get(_words_without(name, base[name]), "")
        if not (now.items() - was.items() or (other and was.keys() != now.keys())):
            continue
        did = "calls it otherwise" if other else "takes it out"
        by = "theirs" if word == "ours" else "ours"
        sides = [tuple(gone[other]) if other else (), tuple(kept[name])]
        mine, others = sides if word == "ours" else sides[::-1]
        why = f"{word} {did}, {by} changes it"
        yield Clash("data", name.rpartition("/")[2], why, tuple(base[name]), mine, others)


def _words_without(name: str, items: Sequence[MergeItem]) -> str:
    """Content of data without their name."""
    own = name.rpartition("/")[2]
    pattern = re.compile(rf"(?<!\w){re.escape(own)}(?!\w)", re.IGNORECASE)
    return "\4".join(pattern.sub("\5", item.piece.code) for item in items)


def _by_words(groups: Mapping[str, Sequence[MergeItem]], names: Iterable[str]) -> dict[str, str]:
    """Those of the names whose data have unique content, by that content."""
    found: dict[str, list[str]] = {}
    for name in names:
        found.setdefault(_words_without(name, groups[name]), []).append(name)
    return {words: alike[0] for words, alike in found.items() if len(alike) == 1}


def _slot(texts: tuple[str, str, str], says: Sequence[object]) -> str | None:
    """Merge of one part of a line from its content in each version: the side that changed it; None if both did,
    differently.

    With equal content the spelling decides, and of two new spellings the first in order.
    """
    for of in (says, texts):
        base, ours, theirs = of
        if ours != theirs:
            return (
                texts[2]
                if ours == base
                else texts[1]
                if theirs == base
                else (min(texts[1:]) if of is texts else None)
            )
    return texts[1]


def _tuple(item: MergeItem | None) -> tuple[MergeItem, ...]:
    return () if item is None else (item,)


def _who(base: object, ours: object, theirs: object) -> str:
    if ours == theirs:
        return "both" if ours != base else ""
    return "theirs" if ours == base else "ours" if theirs == base else "both"


def _nicer(ours: Sequence[MergeItem], theirs: Sequence[MergeItem]) -> list[MergeItem]:
    """Of pieces with equal content one spelling, independent of which side is called ours."""
    return [min(pair, key=lambda one: one.piece.lines) for pair in zip(ours, theirs, strict=True)]


def _nicer_row(ours: Row | None, theirs: Row | None) -> Row | None:
    if ours is None or theirs is None:
        return None
    return min(ours, theirs, key=lambda row: (row.lines, row.lead, row.before))


def _by_groups(ours: Sequence[MergeItem], theirs: Sequence[MergeItem]) -> list[MergeItem]:
    """Data of both sides in an order that does not depend on which side is which."""
    groups: dict[str, dict[str, MergeItem]] = {}
    for item in (*ours, *theirs):
        group = item.piece.name.partition("[")[0]
        groups.setdefault(group, {}).setdefault(item.piece.name, item)
    return [
        one
        for name in sorted(groups)
        for one in sorted(groups[name].values(), key=lambda i: _closing_last(i))
    ]


def _closing_last(item: MergeItem) -> tuple[bool, int, str]:
    name = item.piece.name
    digits = re.findall(r"\d+", name.partition("[")[2])
    return name.endswith("["), int(digits[0]) if digits else -1, name


class _Matched:
    """One side aligned to the base. `of`: its item for each piece of the base; `inserted`: its items before one."""

    def __init__(self, base: _Version, side: _Version, pairs: Sequence[tuple[int, int]]) -> None:
        self.version, self.base = side, base.pieces
        self.of: list[MergeItem | None] = [None] * len(base.items)
        self.names = base.names
        self.inserted: dict[int, list[MergeItem]] = {}
        last = 0
        gap = 0
        for i, j in (*pairs, (len(base.items), len(side.items))):
            if j > last:
                # After what went: a new text takes the place of the old one.
                self.inserted[i if self._went(gap, i) else gap] = list(side.items[last:j])
            if i < len(base.items):
                self.of[i] = side.items[j]
            last, gap = j + 1, i + 1

    def _went(self, start: int, stop: int) -> bool:
        return stop > start

    def gone(self, at: int) -> bool:
        """Whether the side deleted a piece of the base without moving it elsewhere."""
        return self.of[at] is None and not (self.names[at] and self.names[at] in self.version.by_name)

    def statement(self, at: int, step: int) -> int:
        """Index in the base, from `at` on, of the next piece that is not a comment; out of range if there is none."""
        while 0 <= at < len(self.of) and self.base[at].says_nothing:
            at += step
        return at


def _is_named(item: MergeItem) -> bool:
    """Whether the item is data or a record, which does not depend on its neighbours."""
    return item.piece.loose or "head " in item.piece.name


def _context(mine: _Matched, other: _Matched, new: Sequence[MergeItem], at: int) -> str:
    """Why the items that `mine` inserted before piece `at` of the base conflict with the other side; "" if they do
    not.
    """
    if all(one.piece.says_nothing or _is_named(one) for one in new):
        return ""
    last = len(mine.of) - 1
    before, after = mine.statement(at - 1, -1), mine.statement(at, 1)
    if before >= 0 and after <= last and other.gone(before) and other.gone(after):
        return "what stood around it is gone on the other side"
    while before >= 0 and mine.gone(before):
        if other.gone(before):
            return "it takes the place of what the other side took out"
        before = mine.statement(before - 1, -1)
    return ""


def _joined(found: Sequence[Settled]) -> Iterator[Settled]:
    """Neighbouring conflicts of statements joined to one."""
    held: Clash | None = None
    for one in found:
        if isinstance(one, Clash) and one.what == "statement":
            if held is None:
                held = one
            else:
                held = Clash(
                    held.what, held.name, held.why, held.base + one.base, held.ours + one.ours,
                    held.theirs + one.theirs,
                )  # fmt: skip
            continue
        if held is not None:
            yield held
            held = None
        yield one
    if held is not None:
        yield held


# --- The text ---


class _MergeWriter:
    """Numbers the positions and lines of a merge and writes its text."""

    def __init__(self, work: _Merge, fixed: frozenset[str], texts: tuple[str, str, str]) -> None:
        self.work, self.rules, self.fixed = work, work.rules, fixed
        self.versions = (work.base, work.ours, work.theirs)
        self.newline, self._alike = _newline(texts)
        base, ours, theirs = (text.endswith(("\n", "\r")) for text in texts)
        self.ended = theirs if ours == base else ours
        self.numbers: dict[str, int] = {}
        self.widths: dict[str, int] = {}
        self.counter = 0
        self.shared: list[SharedStatement] = []
        self.totals: Counter[str] = Counter()

    def written(self, settled: Sequence[Settled]) -> MergedText:
        used = list(dict.fromkeys(chain.from_iterable(_ids(one) for one in settled)))
        tables = self._tables(set(used))
        self._number(used, tables)
        for rows in tables.values():
            for name in rows:
                self.totals[_family(self.versions, name)] += 1
        lines = sum(_counted(one) for one in settled)
        parts: list[TextLine | Hunk] = []
        line, counted = 1, 0
        for one in settled:
            joined = one.joined if isinstance(one, MergeItem) else None
            if joined is not None and (joined.ours or joined.theirs):
                line += sum(1 if isinstance(part, TextLine) else part.height for part in parts[counted:])
                counted = len(parts)
                self.shared.append(SharedStatement(line, joined.ours, joined.theirs))
            if isinstance(one, TableHere):
                parts += self._table(one.name, tables.get(one.name, {}))
            elif isinstance(one, Clash):
                parts.append(self._hunk(one))
            else:
                parts += self._lines(one, lines)
        taken = {
            word: TakenChanges(tuple(one.points), one.statements) for word, one in self.work.taken.items()
        }
        return MergedText(tuple(parts), self.newline, self.ended, taken, shared=tuple(self.shared))

    def _tables(self, used: set[str]) -> dict[str, dict[str, _MergedRow]]:
        found: dict[str, dict[str, _MergedRow]] = {}
        seen: set[str] = set()
        for version in self.versions:
            for name, table in version.table_of.items():
                if name in seen:
                    continue
                seen.add(name)
                row = self.work.row(name, name in used)
                if row.row is not None or row.clash is not None:
                    found.setdefault(table, {})[name] = row
        return found

    # --- numbers

    def _number(self, used: Sequence[str], tables: Mapping[str, Mapping[str, _MergedRow]]) -> None:
        rest = set(chain.from_iterable(tables.values())) - set(used)
        names = [*used, *sorted(rest, key=lambda one: (self._wish(one), one))]
        families: dict[str, list[str]] = {}
        for name in names:
            families.setdefault(_family(self.versions, name), []).append(name)
        for family, members in families.items():
            self.widths[family] = max(_widths(self.versions, family), default=1)
            if family in self.fixed:
                self.numbers.update({name: int(name.rpartition(" ")[2]) for name in members})
            elif (first := _counted_from(self.versions, family)) is not None:
                self.numbers.update({name: first + k for k, name in enumerate(members)})
            else:
                self._by_wishes(members)

    def _by_wishes(self, members: Sequence[str]) -> None:
        wishes = {name: self._wish(name) for name in members}
        taken: set[int] = set()
        last = max(wishes.values(), default=0)
        for name in sorted(members, key=lambda one: one.startswith("new ")):
            number = wishes[name]
            if number in taken:
                last += 1
                number = last
            taken.add(number)
            self.numbers[name] = number

    def _wish(self, name: str) -> int:
        base, ours, theirs = (_number_in(version, name) for version in self.versions)
        if ours is None and theirs is None and base is None:
            return int(name.rpartition(" ")[2])  # the text has no such position
        if ours is None or theirs is None:
            found = [one for one in (ours, theirs, base) if one is not None]
            return found[0]
        return theirs if ours == base else ours if theirs == base else min(ours, theirs)

    # --- lines

    def _lines(self, item: MergeItem, total: int) -> Iterator[TextLine]:
        if item.piece.rule is RecordRule.COUNTED and any(
            version.counts(item.piece.name, self.rules) for version in self.versions
        ):
            yield TextLine(self.rules.counted(item.piece, self.totals, total), self._end(item.piece.ends[0]))
            return
        names = iter(item.ids)
        uses = iter(item.piece.uses)
        for text, end in zip(item.piece.lines, item.piece.ends, strict=True):
            if text.startswith(COUNTER):
                width = len(text) - len(text.lstrip(COUNTER))
                self.counter += 1
                text = f"{self.counter:{width}d}:{text[width:]}"
            if NUMBER in text:
                head, *rest = text.split(NUMBER)
                text = head + "".join(self._spelt(next(uses), next(names)) + part for part in rest)
            yield TextLine(text, self._end(end))

    def _spelt(self, use: NumberedUse, name: str) -> str:
        return self.rules.spelled(use._replace(width=self.widths[use.family]), self.numbers[name])

    def _end(self, end: str) -> str:
        return self.newline if end and self._alike else end

    def _table(self, table: str, rows: Mapping[str, _MergedRow]) -> Iterator[TextLine | Hunk]:
        order = list(rows)
        if all(_ascending(version, table) for version in self.versions):
            rank = self._ranks(table)
            order.sort(key=lambda name: (rank.get(_family(self.versions, name), 0), self.numbers[name]))
        choices: list[Choice] = []
        for name in order:
            row = rows[name]
            for word in row.side.split() if row.clash is None else ():
                self.work.taken[word].points.append(self._shown(name))
            choices.append(row.row if row.row is not None else row.clash or (None, None))
        told = self.rules.rows(choices)
        keys = {id(one): name for name in order for one in _rows_of(rows[name])}
        yield from self._told(list(told), keys)
        for text, end in self._tail(table):
            yield TextLine(text, self._end(end))

    def _told(self, lines: Sequence[TableText], keys: Mapping[int, str]) -> Iterator[TextLine | Hunk]:
        at = 0
        while at < len(lines):
            if lines[at].side is None:
                yield self._row_line(lines[at], keys)
                at += 1
                continue
            sides: tuple[list[TextLine], list[TextLine]] = ([], [])
            first = lines[at].row
            assert first is not None
            name = keys[id(first)]
            while at < len(lines) and (side := lines[at].side) is not None:
                row = lines[at].row
                if row is None or keys[id(row)] != name:
                    break
                sides[side.value].append(self._row_line(lines[at], keys))
                at += 1
            yield self._point_hunk(name, *sides)

    def _row_line(self, line: TableText, keys: Mapping[int, str]) -> TextLine:
        text = line.text
        if line.row is not None and NUMBER in text:
            text = text.replace(NUMBER, self._spelt(line.row.use, keys[id(line.row)]), 1)
        return TextLine(text, self._end(line.end))

    def _point_hunk(self, name: str, ours: list[TextLine], theirs: list[TextLine]) -> Hunk:
        base = self.work.base.by_id.get(name)
        why = "both change it"
        if not ours or not theirs:
            word, other = ("ours", "theirs") if not ours else ("theirs", "ours")
            why = f"{word} takes it out, {other} changes it"
        users = [self._users(version, name) for version in self.versions[1:]]
        told = () if base is None else base.lines
        return Hunk("point", self._shown(name), why, tuple(ours), tuple(theirs), told, *users)

    def _users(self, version: _Version, name: str) -> tuple[int, ...]:
        starts = version.lines_at
        return tuple(starts[item.at] for item in version.items if name in item.ids)

    def _shown(self, name: str) -> str:
        family = _family(self.versions, name)
        row = next(one.by_id[name] for one in self.versions if name in one.by_id)
        spelt = self._spelt(row.use, name)
        text = row.lines[0].lstrip().partition(NUMBER)
        return f"{text[0]}{spelt}{']' if text[0].endswith('[') else ''}" or family

    def _ranks(self, table: str) -> dict[str, int]:
        """Rank of each family of positions in the order of the tables."""
        found: dict[str, int] = {}
        for version in self.versions:
            families = dict.fromkeys(row.use.family for row in version.cut.rows.get(table, ()))
            for rank, family in enumerate(families):
                found[family] = max(rank, found.get(family, 0))
        return found

    def _tail(self, table: str) -> tuple[tuple[str, str], ...]:
        base, ours, theirs = (version.cut.tails.get(table, ()) for version in self.versions)
        return theirs if ours == base else ours

    def _hunk(self, clash: Clash) -> Hunk:
        start = self.counter
        ours = tuple(line for one in clash.ours for line in self._lines(one, 0))
        most, self.counter = self.counter, start
        theirs = tuple(line for one in clash.theirs for line in self._lines(one, 0))
        self.counter = max(most, self.counter)
        base = tuple(
            line.replace(NUMBER, "#").lstrip(COUNTER) for one in clash.base for line in one.piece.lines
        )
        at = (
            self._lines_of(self.work.ours, clash, clash.ours),
            self._lines_of(self.work.theirs, clash, clash.theirs),
        )
        return Hunk(clash.what, clash.name, clash.why, ours, theirs, base, *at)

    def _lines_of(self, version: _Version, clash: Clash, items: Sequence[MergeItem]) -> tuple[int, ...]:
        starts = version.lines_at
        if clash.what == "statement":
            return tuple(
                starts[one.at] + k for one in items if one.at >= 0 for k in range(len(one.piece.lines))
            )
        word = next(iter(_WORD.findall(clash.name)), "")
        pattern = re.compile(rf"(?<!\w){re.escape(word)}(?!\w)", re.IGNORECASE)
        return tuple(starts[one.at] for one in version.items if word and pattern.search(one.piece.code))


def _rows_of(row: _MergedRow) -> Iterator[Row]:
    for one in (row.row, *(row.clash or ())):
        if one is not None:
            yield one


def _ids(one: Settled) -> Iterator[str]:
    if isinstance(one, MergeItem):
        yield from one.ids
    elif isinstance(one, Clash):
        for item in (*one.ours, *one.theirs):
            yield from item.ids


def _counted(one: Settled) -> int:
    if isinstance(one, MergeItem):
        return sum(text.startswith(COUNTER) for text in one.piece.lines)
    if isinstance(one, Clash):
        return max(sum(_counted(item) for item in side) for side in (one.ours, one.theirs))
    return 0


def _family(versions: Sequence[_Version], name: str) -> str:
    for version in versions:
        row = version.by_id.get(name)
        if row is not None:
            return row.use.family
    return name.removeprefix("new ").rpartition(" ")[0]


def _number_in(version: _Version, name: str) -> int | None:
    row = version.by_id.get(name)
    return None if row is None else row.use.number


def _widths(versions: Sequence[_Version], family: str) -> Iterator[int]:
    for version in versions:
        for row in version.rows.values():
            if row.use.family == family:
                yield row.use.width


def _counted_from(versions: Sequence[_Version], family: str) -> int | None:
    """First number if all versions number their positions in the order of use, as a controller does; None if not."""
    first: int | None = None
    for version in versions:
        uses = (use.number for piece in version.pieces for use in piece.uses if use.family == family)
        used = list(dict.fromkeys(uses))
        held = sorted(row.use.number for row in version.rows.values() if row.use.family == family)
        if used != held or used != list(range(used[0], used[0] + len(used)) if used else ()):
            return None
        if used and first not in (None, used[0]):
            return None
        first = used[0] if used else first
    return first


def _ascending(version: _Version, table: str) -> bool:
    by_family: dict[str, list[int]] = {}
    for row in version.cut.rows.get(table, ()):
        by_family.setdefault(row.use.family, []).append(row.use.number)
    return all(numbers == sorted(numbers) for numbers in by_family.values())


def _newline(texts: tuple[str, str, str]) -> tuple[str, bool]:
    """The line end of the merge, and whether all lines get it: each version uses a single one."""
    found, alike = [], True
    for text in texts:
        crlf = text.count("\r\n")
        counts = {"\r\n": crlf, "\n": text.count("\n") - crlf, "\r": text.count("\r") - crlf}
        alike = alike and sum(count > 0 for count in counts.values()) <= 1
        found.append(max(counts, key=lambda end: counts[end]) if any(counts.values()) else "")
    base, ours, theirs = found
    if not ours or not theirs:
        return ours or theirs or "\n", alike
    return (theirs if ours == base else ours if theirs == base else max(ours, theirs)), alike
