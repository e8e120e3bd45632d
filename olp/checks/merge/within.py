"""Two changes of one statement: where both can stand.

The sides changed different arguments of one move, added names to one declaration, or one side's change has the other's
in it. Anything else is for a
person to decide. Where the arm goes, its target with tool and frame, is one argument: together they say a place.
"""

from __future__ import annotations

import re
from collections.abc import Hashable, Sequence
from difflib import SequenceMatcher
from typing import NamedTuple

from olp.languages.merging import MergeRules, MoveArgument

MORE = "more"  # what a side changed besides what the other did, too
_WORD = re.compile(r"\d*\.?\d+(?:[eE][-+]?\d+)?(?!\w)|\w+|\S")
_LONGEST = 400  # words of a statement: what is longer, a person compares


class JoinedChange(NamedTuple):
    """A statement with the changes of both sides. `ours`, `theirs`: names of the arguments that each changed.

    `place`: which side says where the arm goes: 1 ours, 2 theirs.
    """

    text: str
    ours: tuple[str, ...]
    theirs: tuple[str, ...]
    place: int


def by_arguments(
    rules: MergeRules, texts: tuple[str, str, str], places: Sequence[Hashable] = ("", "", "")
) -> JoinedChange | None:
    """One move of three versions; None where it is none, or both changed one argument. `places`: of their positions."""
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
        said = [(_said(rules, parts, name), place if name == "place" else "") for parts, place in
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


def _said(rules: MergeRules, parts: Sequence[MoveArgument], name: str) -> tuple[str, ...]:
    return tuple(rules.code(one.text).strip() for one in parts if one.name == name)


def by_names(rules: MergeRules, texts: tuple[str, str, str]) -> JoinedChange | None:
    """One declaration to which both sides added names, each its own; None where they did anything else."""
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
    """Which side changed all that the other changed, and more: 1 ours, 2 theirs, 0 neither."""
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
