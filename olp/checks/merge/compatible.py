"""Changes of both sides that do not conflict: renamed names, and different parts of one statement.

A side that renames a variable changes each of its statements without conflicting with the other side's changes of
them. Keywords, targets of moves and names that differ only in digits do not count as renamed: `LIN P1` that became
`LIN P5` has another target.

Within one statement both changes are kept where the sides changed different arguments of one move, added names to
one declaration, or one side's change contains the other's. Anything else is a conflict for the user. The target of
a move with its tool and frame is one argument: together they define a position.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Hashable, Iterable, Mapping, Sequence, Set
from difflib import SequenceMatcher
from itertools import chain
from typing import NamedTuple

from olp.checks.merge.align import align
from olp.languages.merging import MergeRules, MoveArgument, lines_of

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
    """Three texts with the names of the merge, and the names that each side changed: (before, now)."""

    base: str
    ours: str
    theirs: str
    by_ours: tuple[tuple[str, str], ...] = ()
    by_theirs: tuple[tuple[str, str], ...] = ()


def with_new_names(rules: MergeRules, base: str, ours: str, theirs: str) -> NewNames:
    """The three texts, with the renamings of either side applied to all of them."""
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
    """Quick check, from the changed lines, whether a name vanished and a new one may replace it."""
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
    """Indentation, code and comment of a line, and the names in its code, as keys and as spelled."""

    slots: tuple[str, str, str]
    names: tuple[str, ...]
    spelt: tuple[str, ...]


class _SpokenNames:
    """The names of a text. `often`: count of each; `spelt`: its first spelling.

    `read`: lines of other versions that are split already; the lines of this text are added.
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
        """Names that are certainly variables."""
        found: set[str] = set()
        for code in {line.slots[1] for line, _ in self._lines}:
            found.update(map(self._key, _OWNED.findall(code)))
            found.update(map(self._key, _ASSIGNED.findall(code.partition("(")[0])))
            for inside in _INDEX.findall(code):
                found.update(map(self._key, _TOKEN.findall(inside)))
        return {name for name in found if _may_be_renamed(name)}

    def saying(self, names: Set[str]) -> list[tuple[str, tuple[str, ...]]]:
        """The statements with one of these names: their text without the names, and the names."""
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
    """The renamings of a side: old name -> new name."""
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
    """The renamings of one side that the other side made too, or whose name it uses as often as before.

    If it uses a name less often, it deleted what the first side changed; if more often, it may mean the old name.
    """
    return {
        old: new
        for old, new in given.items()
        if also.get(old) == new
        or (old not in also and new not in against.often and against.often[old] == before.often[old])
    }


MORE = "more"  # what a side changed besides what the other did, too
_WORD = re.compile(r"\d*\.?\d+(?:[eE][-+]?\d+)?(?!\w)|\w+|\S")
_LONGEST = 400  # words of a statement: what is longer, a person compares


class JoinedChange(NamedTuple):
    """A statement with the changes of both sides. `ours`, `theirs`: names of the arguments that each changed.

    `place`: the side that sets the target: 1 ours, 2 theirs.
    """

    text: str
    ours: tuple[str, ...]
    theirs: tuple[str, ...]
    place: int


def by_arguments(
    rules: MergeRules, texts: tuple[str, str, str], places: Sequence[Hashable] = ("", "", "")
) -> JoinedChange | None:
    """One move of three versions; None if it is not a move, or if both changed one argument. `places`: of their
    positions.
    """
    found = [rules.arguments(text) for text in texts]
    if not all(found):
        return None
    orders = [[one.name for one in parts] for parts in found]
    if orders[1] == orders[2] or orders[0] == orders[2]:
        order = orders[1]
    elif orders[0] == orders[1]:
        order = orders[2]
    else:
        return None
    chosen: dict[str, int] = {}
    by: tuple[list[str], list[str]] = ([], [])
    for name in dict.fromkeys([*order, *orders[0]]):
        said = [(_said_by(rules, parts, name), place if name == "place" else "") for parts, place in
                zip(found, places, strict=True)]  # fmt: skip
        base, ours, theirs = said
        if (name == "motion" and len(set(said)) > 1) or base != ours != theirs != base:
            return None
        chosen[name] = 2 if ours == base else 1
        for side, one in zip(by, (ours, theirs), strict=True):
            if one != base:
                side.append(name)
    parts = [[one.text for one in found[chosen[name]] if one.name == name] for name in chosen]
    texts_of = dict(zip(chosen, map(iter, parts), strict=True))
    if [order.count(name) for name in chosen] != [len(one) for one in parts]:
        return None
    line = "".join(next(texts_of[name]) for name in order)
    return JoinedChange(line, tuple(by[0]), tuple(by[1]), chosen.get("place", 1))


def _said_by(rules: MergeRules, parts: Sequence[MoveArgument], name: str) -> tuple[str, ...]:
    return tuple(rules.code(one.text).strip() for one in parts if one.name == name)


def by_names(rules: MergeRules, texts: tuple[str, str, str]) -> JoinedChange | None:
    """One declaration to which both sides added different names; None for any other change."""
    (head, names, tail), mine, other = map(rules.declared, texts)
    if not names or (head, tail) != mine[::2] or (head, tail) != other[::2]:
        return None
    if (
        not names.items() <= mine[1].items() & other[1].items()
        or mine[1].keys() & other[1].keys() != names.keys()
    ):
        return None
    comma = ", " if ", " in "".join(texts) else ","
    line = head + comma.join({**mine[1], **other[1]}.values()) + tail
    return JoinedChange(line, ("names",), ("names",), 1)


def containing(base: str, ours: str, theirs: str) -> int:
    """The side whose change contains the other's: 1 ours, 2 theirs, 0 neither."""
    words = [_WORD.findall(text) for text in (base, ours, theirs)]
    if max(map(len, words)) > _LONGEST:
        return 0
    mine, other = (_changes(words[0], side) for side in words[1:])
    return 2 if mine < other else 1 if other < mine else 0


def changes_words(old: str, new: str) -> bool:
    """Whether anything but blanks changed."""
    return _WORD.findall(old) != _WORD.findall(new)


def _changes(old: list[str], new: list[str]) -> set[tuple[int, int, tuple[str, ...]]]:
    found = SequenceMatcher(None, old, new, autojunk=False).get_opcodes()
    return {(i, j, tuple(new[k:m])) for kind, i, j, k, m in found if kind != "equal"}
