"""Names that one side gave another name: one change, however many statements say them.

A side that calls a variable otherwise changes each of its statements, and says nothing against what the other side
changed in them. Words of the language, targets of moves and names that differ in nothing but digits are no such names:
`LIN P1` that became `LIN P5` goes elsewhere.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Set
from itertools import chain
from typing import NamedTuple

from olp.checks.merge.align import align
from olp.languages.merging import MergeRules, lines_of

_TOKEN = re.compile(r'"[^"]*"?|(?<![\w$])[A-Za-z_$][\w$]*')
_DIGITS = re.compile(r"\d+")
_LINES = re.compile(r"\r\n|\n|\r")
# What only a variable has: a member, an index, a value that is assigned; and what stands in an index. `MoveL [[1,…` has
# none, \V:= and a=1.2 in brackets are arguments, and $VEL is the controller's.
_OWNED = re.compile(r"(?<=\.)[A-Za-z_]\w*|(?<![\w$\\])[A-Za-z_]\w*(?=[.\[])")
_ASSIGNED = re.compile(r"(?<![\w$.\\])[A-Za-z_]\w*(?=\s*:?=(?!=))")
_INDEX = re.compile(r"(?<=\w)\[([^][]*)\]")
_SHORTEST = 4  # characters: X, Y and CP are members that every pose or speed has
_VALUES = frozenset({"true", "false"})
_LEAST = 2  # statements with the new name for the old one, and otherwise the same
_SIGN = "\7"  # in place of a name


class NewNames(NamedTuple):
    """Three texts with the names of the merge, and what each side called otherwise: (before, now)."""

    base: str
    ours: str
    theirs: str
    by_ours: tuple[tuple[str, str], ...] = ()
    by_theirs: tuple[tuple[str, str], ...] = ()


def with_new_names(rules: MergeRules, base: str, ours: str, theirs: str) -> NewNames:
    """The three texts, each with the names that either side gave to what the base calls otherwise."""
    if not rules.has_variables:
        return NewNames(base, ours, theirs)
    lines = Counter(_LINES.split(base))
    if not any(_may_give_names(rules, lines, side) for side in (ours, theirs)):
        return NewNames(base, ours, theirs)
    read: dict[str, _SpokenLine] = {}
    before, mine, other = (_SpokenNames(rules, text, read) for text in (base, ours, theirs))
    given = _given(before, mine), _given(before, other)
    kept = (
        _undisputed(before, other, given[0], given[1]),
        _undisputed(before, mine, given[1], given[0]),
    )
    if not kept[0] and not kept[1]:
        return NewNames(base, ours, theirs)
    new = {old: mine.spelt[name] for old, name in kept[0].items()}
    new.update({old: other.spelt[name] for old, name in kept[1].items() if old not in new})
    base, ours, theirs = (one.renamed(new) for one in (before, mine, other))
    told = [tuple((before.spelt[old], new[old]) for old in sorted(one)) for one in kept]
    return NewNames(base, ours, theirs, told[0], told[1])


def _may_give_names(rules: MergeRules, before: Counter[str], side: str) -> bool:
    """Whether a name is in no line any more, and one that may be it is new: quick, from the lines that changed."""
    now = Counter(_LINES.split(side))
    old, new = (_said(rules, some.elements()) for some in (before - now, now - before))
    gone, given = (
        {
            _DIGITS.sub("", name)
            for name, often in one.items()
            if often >= _LEAST and name not in other and _may_be_renamed(name)
        }
        for one, other in ((old, new), (new, old))
    )
    return bool(gone) and bool(given) and len(gone | given) > 1


def _said(rules: MergeRules, lines: Iterable[str]) -> Counter[str]:
    code = "\n".join(rules.split(line)[1] for line in lines)
    return Counter(_TOKEN.findall(code.casefold() if rules.ignores_case else code))


class _SpokenLine(NamedTuple):
    """Indentation, code and comment of a line, and the names in its code, as keys and as they are spelt."""

    slots: tuple[str, str, str]
    names: tuple[str, ...]
    spelt: tuple[str, ...]


class _SpokenNames:
    """The names of a text. `often`: how often each is said; `spelt`: as it stands there first.

    `read`: the lines of other versions, to which its own are added.
    """

    def __init__(self, rules: MergeRules, text: str, read: dict[str, _SpokenLine]) -> None:
        self._folds = rules.ignores_case
        self._lines: list[tuple[_SpokenLine, str]] = []
        for line, end in lines_of(text):
            known = read.get(line)
            if known is None:
                slots = rules.split(line)
                spelt = tuple(_TOKEN.findall(slots[1]))
                known = read[line] = _SpokenLine(slots, tuple(map(self._key, spelt)), spelt)
            self._lines.append((known, end))
        self.often = Counter(chain.from_iterable(line.names for line, _ in self._lines))
        self.spelt: dict[str, str] = {}
        for one, _ in reversed(self._lines):
            self.spelt.update(zip(reversed(one.names), reversed(one.spelt), strict=True))

    def _key(self, word: str) -> str:
        return word.casefold() if self._folds else word

    def variables(self) -> set[str]:
        """Those that can be nothing else."""
        found: set[str] = set()
        for code in {line.slots[1] for line, _ in self._lines}:
            found.update(map(self._key, _OWNED.findall(code)))
            found.update(map(self._key, _ASSIGNED.findall(code.partition("(")[0])))
            for inside in _INDEX.findall(code):
                found.update(map(self._key, _TOKEN.findall(inside)))
        return {name for name in found if _may_be_renamed(name)}

    def saying(self, names: Set[str]) -> list[tuple[str, tuple[str, ...]]]:
        """The statements that say one of these names: their words without them, and which they are."""
        found = []
        for line, _ in self._lines:
            said = tuple(name for name in line.names if name in names)
            if said:
                words = _TOKEN.sub(lambda match: self._shown(match[0], names), line.slots[1])
                found.append(("".join(words.split()), said))
        return found

    def _shown(self, word: str, names: Set[str]) -> str:
        name = self._key(word)
        return _SIGN if name in names else name

    def renamed(self, new: Mapping[str, str]) -> str:
        """The text with other names."""

        def named(match: re.Match[str]) -> str:
            return new.get(self._key(match[0]), match[0])

        slots = ((*line.slots, end) for line, end in self._lines)
        return "".join(f"{indent}{_TOKEN.sub(named, code)}{rest}{end}" for indent, code, rest, end in slots)


def _may_be_renamed(name: str) -> bool:
    return len(name) >= _SHORTEST and name[0] not in '$"' and name.casefold() not in _VALUES


def _given(before: _SpokenNames, side: _SpokenNames) -> dict[str, str]:
    """What the side calls otherwise: the name of before -> the name now."""
    gone = {name for name in before.often.keys() - side.often.keys() if before.often[name] >= _LEAST}
    new = {name for name in side.often.keys() - before.often.keys() if side.often[name] >= _LEAST}
    if not gone or not new or not (gone := gone & before.variables()):
        return {}
    old_ones, new_ones = before.saying(gone), side.saying(new)
    votes: dict[str, Counter[str]] = {}
    back: dict[str, set[str]] = {}
    said: Counter[str] = Counter()
    for i, j in align([words for words, _ in old_ones], [words for words, _ in new_ones], lambda _, __: 0.0):
        pairs = list(zip(old_ones[i][1], new_ones[j][1], strict=False))
        for one, other in pairs:
            votes.setdefault(one, Counter())[other] += 1
            back.setdefault(other, set()).add(one)
        said.update({one for one, _ in pairs})
    return {
        one: other
        for one, found in votes.items()
        for other in found
        if len(found) == len(back[other]) == 1
        and said[one] >= _LEAST
        and 2 * found[other] >= before.often[one]
        and _may_be_renamed(other)
        and _DIGITS.sub("", one) != _DIGITS.sub("", other)
    }


def _undisputed(
    before: _SpokenNames, against: _SpokenNames, given: Mapping[str, str], also: Mapping[str, str]
) -> dict[str, str]:
    """Of the names that one side gave those that the other gave, too, or has left as they were.

    Where it says a name less often, it took out what the first side changed; where more often, it may mean the old one.
    """
    return {
        old: new
        for old, new in given.items()
        if also.get(old) == new
        or (old not in also and new not in against.often and against.often[old] == before.often[old])
    }
