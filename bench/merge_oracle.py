"""What a merge has to be, from the lines alone: no code of the merge, no reader.

`facts` and `wrong` compare how often each statement and position stands in base, ours, theirs and merge. `both_changed`
says what both sides changed differently, from git's own differences: there a person has to choose. `touched_up` and
`cut_in_two` make two sides of one change that happened, so that what must come out is known to the byte.
"""

from __future__ import annotations

import itertools
import random
import re
import subprocess
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple


def facts(language: str, text: str) -> tuple[Counter[str], Counter[str]]:
    """Statements without the numbers of their positions, and positions as statements use them or as data have them."""
    lines = _lines(text)
    if language == "inform":
        return _inform(lines)
    if language == "tp":
        return _tp(lines)
    lines = [_spelt_alike(language, line) for line in lines if line and not line.startswith("&")]
    return _words(lines, _MARKS[language])


def _spelt_alike(language: str, line: str) -> str:
    """One text for numbers that are the same and, where the language takes them for one, for all letters."""
    if language in ("krl", "rapid", "pdl2") and '"' not in line:
        line = re.sub(r"([{,][xyzabce]\d?) (-?\d+)(?=[,}])", r"\1 \2.", line.casefold())
        line = re.sub(r"(\breal [\w.]+=-?\d+)$", r"\1.", line)
        line = re.sub(
            r"(?<![\w.])(\d+\.?\d*)e([-+]?\d+)", lambda one: f"{float(one[1]):g}e{int(one[2])}", line
        )
    line = re.sub(r"(?<![\w.])(\d+\.\d*?)0+(?![\w.])", r"\1", line)
    return re.sub(r"(?<=[ ,=({\[])-(?=0\.?(?![\w.]))", "", line)


def alike(language: str, one: str, other: str) -> bool:
    """Whether two texts say the same: all statements and data in one order, and all remarks.

    A remark or a blank line between two statements may stand on either side of another.
    """
    if one == other:
        return True
    mark = _MARKS.get(language)
    if mark is None:
        return False
    split = [[line.partition(mark) for line in _lines(text)] for text in (one, other)]
    code = [[words.strip() for words, _, _ in lines if words.strip()] for lines in split]
    said = [Counter(remark.strip() for _, _, remark in lines if remark.strip()) for lines in split]
    return code[0] == code[1] and said[0] == said[1]


def _lines(text: str) -> list[str]:
    """Blanks are no words, but in quotes."""
    text = text.removeprefix("\xef\xbb\xbf")
    lines = (" ".join(line.split()) for line in re.split(r"\r\n|\n|\r", text))
    lines = (line if '"' in line else re.sub(r" ?([=,(){}\[\]:;<>]) ?", r"\1", line) for line in lines)
    return [_SAYS_NOTHING.sub(r"\1", line) for line in lines]


# KRL's DECL, the numbers of PolyScope's nodes and the tails of the names that it makes.
_TAIL = r"(?<=_)[0-9a-f]{8}(?:_[0-9a-f]{4}){3}_[0-9a-f]{12}\b"
_SAYS_NOTHING = re.compile(rf"^(GLOBAL )?DECL |^\$ \d+(?= )|{_TAIL}")


_MARKS = {"krl": ";", "rapid": "!", "urscript": "#", "as": ";", "pdl2": "--", "val3": "//"}


def _words(lines: list[str], mark: str) -> tuple[Counter[str], Counter[str]]:
    """Words and remarks: one side may change the words of a line and the other what is remarked on them."""
    split = [line.partition(mark) for line in lines]
    return Counter(s[0].strip() for s in split if s[0].strip()), Counter(
        s[2].strip() for s in split if s[2].strip()
    )


def _inform(lines: list[str]) -> tuple[Counter[str], Counter[str]]:
    rows, state = {}, {}
    said: Counter[str] = Counter()
    used: Counter[str] = Counter()
    for line in lines:
        row = re.match(r"(BC|EC|BP|EX|C|P|E)(\d+)=(.*)", line)
        record = re.match(r"///(TOOL|USER|POSTYPE|RECTAN|PULSE|ANGLE|RCONF)\b(.*)", line)
        if row:
            if state.get("kind") == "PULSE":  # where the arm goes, and the tool that it holds there
                rows[row[1] + row[2]] = row[3] + "|PULSE"
                used[f"a tool: {state.get('TOOL', '')}"] += 1
                continue
            keys = ("TOOL", "kind", "POSTYPE", "RCONF")
            user = state.get("USER", "") if "USER" in state.get("POSTYPE", "") else ""
            rows[row[1] + row[2]] = row[3] + "|".join(state.get(key, "") for key in keys) + user
        elif record:
            if record[1] in ("RECTAN", "PULSE", "ANGLE"):
                state["kind"] = record[1]
            else:
                state[record[1]] = record[2].strip()
        elif line.startswith(("///DATE", "///NPOS")):
            continue
        elif line:
            code = (
                line
                if line.startswith("'")
                else line.partition("//")[0]
                if not line.startswith("/")
                else line
            )
            found = [] if line.startswith("'") else re.findall(r"(?<![A-Z0-9#])(?:BC|EC|C)\d{3,}", code)
            for name in found:
                used[rows.get(name, name)] += 1
                line = line.replace(name, "@", 1)
            said[line] += 1
    # A position that nothing uses is there all the same.
    for name, row in rows.items():
        if name[0] in "PX" or name.startswith(("BP", "EX")):
            used[f"{name} {row}"] += 1
    return said, used


def _tp(lines: list[str]) -> tuple[Counter[str], Counter[str]]:
    text = "\n".join(lines)
    blocks = dict(re.findall(r"^P ?\[ ?(\d+)[^\]\n]*\] ?\{([^}]*)\}", text, re.MULTILINE))
    said: Counter[str] = Counter()
    used: Counter[str] = Counter()
    head = text.partition("\n/POS")[0]
    for line in head.split("\n"):
        if (
            re.match(r"(MODIFIED|CREATE|LINE_COUNT|PROG_SIZE|MEMORY_SIZE|VERSION|OWNER|FILE_NAME)\b", line)
            or not line
        ):
            continue
        line = re.sub(r"^\d+:", "", line).strip()
        for number in re.findall(r"(?<![\w$])P\[ ?(\d+)", line) if not line.startswith("!") else ():
            place, tool = _axes_and_tool(blocks.get(number, number))
            used[place] += 1
            used[f"a tool: {tool}"] += bool(tool)
        said[re.sub(r"(?<![\w$])P\[ ?\d+", "P[@", line)] += 1
    return said, used


def _axes_and_tool(block: str) -> tuple[str, str]:
    """A position of TP: where it is, and, where angles of joints say that, with which tool and frame."""
    frames = re.search(r"UF ?:[^,]*,\s*UT ?:[^,]*", block)
    if frames is None or re.search(r"\bX ?=", block) or not re.search(r"\bJ1 ?=", block):
        return block, ""
    return block.replace(frames[0], ""), frames[0]


def wrong(language: str, base: str, ours: str, theirs: str, merged: str) -> list[str]:
    """What a merge without conflicts lost, doubled, made up or put into another order."""
    found = []
    kinds = zip(*(facts(language, text) for text in (base, ours, theirs, merged)), strict=True)
    for kind, (b, o, t, m) in enumerate(kinds):
        for fact in b.keys() | o.keys() | t.keys() | m.keys():
            low, high = _allowed(b[fact], o[fact], t[fact])
            if kind == 1 and language in _MARKS:
                high = max(
                    high, o[fact], t[fact]
                )  # a remark that one side took out and the other changed stays
            if not low <= m[fact] <= high and not _is_joined(fact, b, o, t, m):
                found.append(f"{b[fact]} {o[fact]} {t[fact]} -> {m[fact]}: {fact[:90]}")
    return [*found, *_order(language, base, ours, theirs, merged)]


def _is_joined(fact: str, b: Counter[str], o: Counter[str], t: Counter[str], m: Counter[str]) -> bool:
    """Whether a statement is part of one that both sides changed, and that now has the words of both changes."""
    news = [[fact] if fact in of - b else list(of - b) for of in (o, t, m)]
    words = {
        one: Counter(re.findall(r'"[^"]*"|[\w.]+|\S', one))
        for one in (*b, *(new for some in news for new in some))
    }
    for base, ours, theirs, came in itertools.product(list((b - o) & (b - t)), *news):
        if fact in (ours, theirs, came) and all(
            low <= words[came][word] <= high
            for word in {*words[base], *words[ours], *words[theirs], *words[came]}
            for low, high in [_allowed(words[base][word], words[ours][word], words[theirs][word])]
        ):
            return True
    return False


def _allowed(b: int, o: int, t: int) -> tuple[int, int]:
    if o == t:
        return (o, o) if o == b else (min(o, 2 * o - b), max(o, 2 * o - b))
    if o == b or t == b:
        only = t if o == b else o
        return only, only
    both = o + t - b
    return max(0, min(o, t, both)), max(o, t, both)


def _order(language: str, base: str, ours: str, theirs: str, merged: str) -> Iterator[str]:
    """Statements that come once in all and stand in one order on both sides keep it."""
    if language == "inform":
        places = [
            _places(
                re.sub(r"(?m)^(?:C|BC|EC|P|BP|EX)\d+=.*$|^///.*$|(?<![A-Z0-9#])(?:BC|EC|C)\d{3,}", "", text)
            )
            for text in (ours, theirs, merged)
        ]
    elif language == "tp":
        places = [
            _places(re.sub(r"(?m)^\s*\d+:|(?<![\w$])P\[ ?\d+", "", text.partition("/POS")[0]))
            for text in (ours, theirs, merged)
        ]
    else:
        places = [_places(text) for text in (ours, theirs, merged)]
    o, t, m = places
    if any(word in merged for word in ("DEFDAT", "<Data", ".TRANS")):
        return  # lists of data have no order
    both = sorted((line for line in m if line in o and line in t and len(line) > 3), key=lambda line: m[line])
    for one, other in itertools.pairwise(both):
        if o[one] > o[other] and t[one] > t[other]:
            yield f"order: {one[:50]} before {other[:50]}"


def _places(text: str) -> dict[str, int]:
    lines = _lines(text)
    often = Counter(lines)
    return {line: at for at, line in enumerate(lines) if line and often[line] == 1}


def lost(language: str, ours: str, theirs: str, base: str, merged: str) -> list[str]:
    """Lines new on a side that a merge with conflicts does not show anywhere."""
    b, o, t, m = (facts(language, text)[0] for text in (base, ours, theirs, merged))
    missing = [line for line in (o - b) | (t - b) if not m[line]]
    return [f"not shown: {line[:90]}" for line in missing if not _is_joined(line, b, o, t, m)]


# --- Where a person has to choose ---


class Change(NamedTuple):
    """Lines `start` to `stop` of the old text became `new`."""

    start: int
    stop: int
    new: tuple[str, ...]


def changes(folder: Path, old: Sequence[str], new: Sequence[str]) -> list[Change]:
    """The differences of two lists of lines, as git has them."""
    for name, lines in (("old", old), ("new", new)):
        (folder / name).write_bytes("".join(f"{line}\n" for line in lines).encode("latin-1", "replace"))
    command = ["git", "diff", "--no-index", "--no-color", "--no-ext-diff", "--minimal", "-U0", "old", "new"]
    done = subprocess.run(command, cwd=folder, capture_output=True, check=False).stdout.decode("latin-1")
    found = []
    for match in re.finditer(r"(?m)^@@ -(\d+)(?:,(\d+))? \+(\d+)(?:,(\d+))? @@", done):
        a, n, c, m = (int(one) if one is not None else 1 for one in match.groups())
        start, first = a - (n > 0), c - (m > 0)
        found.append(Change(start, start + n, tuple(new[first : first + m])))
    return found


class Shared(NamedTuple):
    """Where two sides meet: `same` statements, points and data that both changed; `places` where both put something, or
    one puts something into what the other took out.
    """

    same: list[str]
    places: list[str]


def both_changed(language: str, folder: Path, base: str, ours: str, theirs: str) -> Shared:
    """What both sides changed, and not into the same. Numbers that are the same in other digits are no change."""
    parts = [_parts(language, text) for text in (base, ours, theirs)]
    (b, points, data), (o, o_points, o_data), (t, t_points, t_data) = parts
    same = [
        f"data {name}"
        for name in _names(data, o_data, t_data)
        if len({data.get(name), o_data.get(name), t_data.get(name)}) == 3
    ]
    places = []
    mine, other = changes(folder, b, o), changes(folder, b, t)
    for one, another in itertools.product(mine, other):
        if _same_place(one, another) and _differ(one, another, b):
            put = one.start == one.stop or another.start == another.stop
            (places if put else same).append(
                f"statement {one.start + 1}: {(*b[one.start : one.stop], *one.new)[:1]}"
            )
    held = [Points(one.used, one.tools, {}) for one in (points, o_points, t_points)]
    for what, (of, in_ours, in_theirs) in (
        ("point", (points, o_points, t_points)),
        ("tool of point", held),
    ):
        moved = [_followed(of, side, diff) for side, diff in ((in_ours, mine), (in_theirs, other))]
        for name in moved[0].keys() & moved[1].keys():
            if moved[0][name] != moved[1][name]:
                same.append(f"{what} {name}")
    return Shared(same, places)


# --- Names that one side gave another name ---

_WORD = re.compile(r"[A-Za-z_$][\w$]*")


def renamed(language: str, base: str, ours: str, theirs: str, merged: str) -> tuple[str, str, str]:
    """Base, ours and theirs with the names of the merge: those that a side gave to what the base calls otherwise.

    A name counts as renamed where at least two lines of the side are lines of the base with the one for the other, and
    the merge has the new name alone.
    """
    mark = _MARKS.get(language)
    if mark is None:
        return base, ours, theirs
    new: dict[str, str] = {}
    words = [
        set(map(str.casefold, _WORD.findall(_code(text, mark)))) for text in (base, ours, theirs, merged)
    ]
    for text, known in ((ours, words[1]), (theirs, words[2])):
        gone, came = words[0] - known, known - words[0]
        for old, now in _votes(_code(base, mark), _code(text, mark), gone, came).items():
            if old not in words[3] and now.casefold() in words[3]:
                new.setdefault(old, now)
    if not new:
        return base, ours, theirs
    return tuple(_with(text, mark, new) for text in (base, ours, theirs))  # type: ignore[return-value]


def _code(text: str, mark: str) -> str:
    return "\n".join(line.partition(mark)[0] for line in text.splitlines())


def _with(text: str, mark: str, new: dict[str, str]) -> str:
    parts = [line.partition(mark) for line in text.splitlines(keepends=True)]
    return "".join(
        _WORD.sub(lambda match: new.get(match[0].casefold(), match[0]), code) + sign + rest
        for code, sign, rest in parts
    )


def _votes(base: str, side: str, gone: set[str], came: set[str]) -> dict[str, str]:
    """What stands for each name that is gone in lines that are otherwise the same, in two of them or more."""
    tables = [_by_words(base, gone), _by_words(side, came)]
    votes: dict[str, Counter[str]] = {}
    for key in tables[0].keys() & tables[1].keys():
        for before, now in zip(tables[0][key], tables[1][key], strict=False):
            for old, other in zip(before, now, strict=False):
                votes.setdefault(old.casefold(), Counter())[other] += 1
    best = {old: found.most_common(1)[0] for old, found in votes.items()}
    return {old: now for old, (now, often) in best.items() if often > 1}


def _by_words(text: str, names: set[str]) -> dict[str, list[list[str]]]:
    """The lines that say one of these names, by their other words."""
    found: dict[str, list[list[str]]] = {}
    for line in text.splitlines():
        said = [word for word in _WORD.findall(line) if word.casefold() in names]
        if said:
            key = _WORD.sub(lambda match: "@" if match[0].casefold() in names else match[0].casefold(), line)
            found.setdefault("".join(key.split()), []).append(said)
    return found


def _names(*tables: dict[str, str]) -> Iterator[str]:
    return iter(dict.fromkeys(itertools.chain(*tables)))


def _same_place(one: Change, other: Change) -> bool:
    if one.start == one.stop or other.start == other.stop:
        gap, around = (one, other) if one.start == one.stop else (other, one)
        if around.start == around.stop:
            return gap.start == around.start
        return around.start < gap.start < around.stop
    return max(one.start, other.start) < min(one.stop, other.stop)


def _differ(one: Change, other: Change, base: Sequence[str]) -> bool:
    """Line by line where no line came or went."""
    if one == other:
        return False
    if any(len(side.new) != side.stop - side.start for side in (one, other)):
        return True
    lines = range(max(one.start, other.start), min(one.stop, other.stop))
    return any(
        one.new[at - one.start] != other.new[at - other.start]
        and base[at] not in (one.new[at - one.start], other.new[at - other.start])
        for at in lines
    )


class Points(NamedTuple):
    """The positions of numbered moves: of each line their numbers, and what each number says.

    `tools`: of those that say where the axes are, whatever the arm holds.
    """

    used: list[tuple[str, ...]]
    says: dict[str, str]
    tools: dict[str, str]


def _followed(base: Points, side: Points, diff: Sequence[Change]) -> dict[str, str]:
    """What a side made of the positions of the base that it changed, by their numbers in the base; "": it is gone."""
    found: dict[str, str] = {}
    there = set(side.says.values())
    shift = 0
    edges = [*diff, Change(len(base.used), len(base.used), ())]
    at = 0
    for one in edges:
        for line in range(at, one.start):
            for old, new in zip(base.used[line], side.used[line + shift], strict=False):
                if base.says.get(old) != side.says.get(new):
                    found[old] = side.says.get(new, "")
        if one.stop - one.start == len(one.new):
            for line in range(one.start, one.stop):
                for old, new in zip(base.used[line], side.used[line + shift], strict=False):
                    if old == new and base.says.get(old) != side.says.get(new):
                        found[old] = side.says.get(new, "")
        for line in range(one.start, one.stop):
            for old in base.used[line]:
                if base.says.get(old) not in there:
                    found.setdefault(old, "")
        at, shift = one.stop, shift + len(one.new) - (one.stop - one.start)
    return found


_DATUM = {
    "krl": re.compile(r"(?:DECL |GLOBAL )*(?:E6POS|E6AXIS|FRAME|POS|AXIS|FDAT|PDAT|LDAT|LOAD|INT|REAL|BOOL)? ?"
                      r"(\$?\w+(?:\[[\d, ]*\])?) ?=(.*)", re.IGNORECASE),
    "rapid": re.compile(r"(?:LOCAL |TASK )*(?:PERS|CONST|VAR) \w+ (\w+(?: ?\{[^}]*\})?) ?:=(.*)", re.IGNORECASE),
    "val3": re.compile(r'<Data .*name="(\w+)"(.*)', re.IGNORECASE),
}  # fmt: skip


def _parts(language: str, text: str) -> tuple[list[str], Points, dict[str, str]]:
    """Statements in order with @ for their positions' numbers, positions, and data by name: those given once."""
    lines = _lines(text)
    if language == "inform":
        return _inform_parts(lines)
    if language == "tp":
        return _tp_parts(lines)
    lines = [_spelt_alike(language, line) for line in lines if line and not line.startswith("&")]
    pattern = _DATUM.get(language)
    is_list = language != "krl" or any(re.match(r"DEFDAT\b", line, re.IGNORECASE) for line in lines)
    if pattern is None or not is_list:
        return lines, Points([()] * len(lines), {}, {}), {}
    matches = [pattern.match(line) for line in lines]
    often = Counter(match[1] for match in matches if match)
    data = {match[1]: match[2] for match in matches if match and often[match[1]] == 1}
    rest = [line for line, m in zip(lines, matches, strict=True) if m is None or often[m[1]] > 1]
    return rest, Points([()] * len(rest), {}, {}), data


def _inform_parts(lines: list[str]) -> tuple[list[str], Points, dict[str, str]]:
    said, used, says, tools, state = [], [], {}, {}, {}
    for line in lines:
        row = re.match(r"((?:BC|EC|BP|EX|C|P|E)\d+)=(.*)", line)
        record = re.match(r"///(TOOL|USER|POSTYPE|RECTAN|PULSE|ANGLE|RCONF)\b(.*)", line)
        if row:
            pulse = state.get("kind") == "PULSE"
            keys = ("kind",) if pulse else ("TOOL", "kind", "POSTYPE", "RCONF")
            says[row[1]] = row[2] + "|".join(state.get(key, "") for key in keys)
            if pulse:
                tools[row[1]] = state.get("TOOL", "")
        elif record:
            kind = record[1] in ("RECTAN", "PULSE", "ANGLE")
            state["kind" if kind else record[1]] = record[1] if kind else record[2].strip()
        elif line and not line.startswith(("///DATE", "///NPOS")):
            found = [] if line.startswith("'") else re.findall(r"(?<![A-Z0-9#])(?:BC|EC|C)\d{3,}", line)
            said.append(re.sub(r"(?<![A-Z0-9#])(?:BC|EC|C)\d{3,}", "@", line) if found else line)
            used.append(tuple(found))
    return said, Points(used, says, tools), {}


def _tp_parts(lines: list[str]) -> tuple[list[str], Points, dict[str, str]]:
    text = "\n".join(lines)
    says = dict(re.findall(r"^P ?\[ ?(\d+)[^\]\n]*\] ?\{([^}]*)\}", text, re.MULTILINE))
    said, used = [], []
    for line in text.partition("\n/POS")[0].split("\n"):
        if line and not re.match(
            r"(MODIFIED|CREATE|LINE_COUNT|PROG_SIZE|MEMORY_SIZE|VERSION|OWNER|FILE_NAME)\b", line
        ):
            line = re.sub(r"^\d+:", "", line).strip()
            used.append(tuple(re.findall(r"(?<![\w$])P\[ ?(\d+)", line)))
            said.append(re.sub(r"(?<![\w$])P\[ ?\d+", "P[@", line))
    both = {number: _axes_and_tool(block) for number, block in says.items()}
    tools = {number: tool for number, (_, tool) in both.items() if tool}
    return said, Points(used, {number: place for number, (place, _) in both.items()}, tools), {}


# --- Two sides of one change ---

_PLACES = (
    rb"(?m)^C\d+=([-\d.]+)", rb"\bX\s*=\s*([-\d.]+)", rb"\{\s*X\s+([-\d.]+)", rb"\bx=\"([-\d.]+)\"",
    rb":=\s*\[\s*\[\s*([-\d.]+)", rb"=\s*p?\[\s*([-\d.]+)", rb"POS\(\s*([-\d.]+)",
)  # fmt: skip


class Sides(NamedTuple):
    """Two sides, and what must come out."""

    ours: bytes
    theirs: bytes
    merged: bytes


def touched_up(first: bytes, second: bytes, choose: random.Random) -> Sides | None:
    """A night at the robot while `first` becomes `second`: up to three positions that the change left alone are moved.

    None where there is no such position: one whose row, without its number, stands once in both.
    """
    rows = [_rows(text) for text in (first, second)]
    often = [Counter(key for _, _, key in some) for some in rows]
    there = {key: (start, stop) for start, stop, key in rows[1]}
    found = [
        (start, stop, *there[key])
        for start, stop, key in rows[0]
        if often[0][key] == 1 and often[1][key] == 1
    ]
    if not found:
        return None
    chosen = choose.sample(found, min(3, len(found)))
    news = [_moved(first[start:stop].decode(), choose) for start, stop, _, _ in chosen]
    spots = [(start, stop, new) for (start, stop, _, _), new in zip(chosen, news, strict=True)]
    ours = _replaced(first, spots)
    merged = _replaced(
        second, [(start, stop, new) for (_, _, start, stop), new in zip(chosen, news, strict=True)]
    )
    sides = _stamped(first, ours, second, merged)
    return None if sides.ours == first or sides.theirs == first else sides


def _rows(text: bytes) -> list[tuple[int, int, bytes]]:
    """Of each position where its first number stands, and its row without the number of the position."""
    found = []
    for pattern in _PLACES:
        for match in re.finditer(pattern, text):
            start = text.rfind(b"\n", 0, match.start()) + 1
            stop = text.find(b"\n", match.end())
            row = text[start : stop if stop >= 0 else len(text)]
            values = re.sub(rb"^C\d+=", b"", row)
            if values != row and not re.search(rb"[1-9]", values):
                continue  # a number and nothing but zeros: it cannot be said which position that is
            # Where the position is, its frame says as well.
            frame = b"".join(re.findall(rb"(?m)^///(?:TOOL|USER|POSTYPE|RECTAN|PULSE).*", text[:start])[-4:])
            frame += b"".join(re.findall(rb"UF : .*|P\[\d+", text[max(0, start - 120) : start])[-2:])
            if b"END" not in row and re.fullmatch(rb"-?\d+\.?\d*|-?\.\d+", match[1]):
                found.append((match.start(1), match.end(1), values + frame))
    return found


def _moved(number: str, choose: random.Random) -> bytes:
    decimals = len(number.partition(".")[2])
    step = 3.0 * choose.choice((1, -1, 2)) * 10.0 ** -min(decimals, 1)
    return f"{float(number) + step:.{decimals}f}".encode()


def _replaced(text: bytes, spots: Sequence[tuple[int, int, bytes]]) -> bytes:
    for start, stop, new in sorted(spots, reverse=True):
        text = text[:start] + new + text[stop:]
    return text


_STAMP = re.compile(
    rb"(?m)^(&REL +)(\d+)|^(///DATE )(\d{4}/\d\d/\d\d \d\d:\d\d)|^(MODIFIED\s*= DATE )(\d\d-\d\d-\d\d)"
)


def _stamped(base: bytes, ours: bytes, theirs: bytes, merged: bytes) -> Sides:
    """Controllers count and date what they save: ours does so where theirs did, and is the newer one."""
    b, o, t = (_STAMP.search(text) for text in (base, ours, theirs))
    if b is None or o is None or t is None or b[0] == t[0]:
        return Sides(ours, theirs, merged)
    head = next(one for one in (o[1], o[3], o[5]) if one is not None)
    if o[2] is not None:
        stamp = head + str(max(int(b[2]), int(t[2])) + 1).encode()
    else:
        stamp = head + (b"2039/12/31 03:12" if o[4] is not None else b"39-12-31")
    return Sides(_STAMP.sub(stamp, ours, count=1), theirs, _STAMP.sub(stamp, merged, count=1))


def cut_in_two(folder: Path, first: bytes, second: bytes, choose: random.Random) -> Sides | None:
    """The places where `first` became `second`, each given to one of two sides. None for fewer than two places.

    Places that have a line in common, in whatever version, are one: what a person moves, one person moves.
    """
    old, new = (text.decode("latin-1").split("\n") for text in (first, second))
    found = changes(folder, [_unstamped(line) for line in old], [_unstamped(line) for line in new])
    shift, places = 0, []
    for one in found:
        places.append((one.start, one.stop, new[one.start + shift : one.start + shift + len(one.new)]))
        shift += len(one.new) - (one.stop - one.start)
    groups = _in_common([{*old[start:stop], *put} for start, stop, put in places])
    if len(set(groups)) < 2:
        return None
    whose_group = {one: choose.random() < 0.5 for one in sorted(set(groups))}
    if len(set(whose_group.values())) < 2:
        whose_group[groups[0]] = not whose_group[groups[0]]
    owner = [whose_group[one] for one in groups]
    sides = []
    for side in (True, False):
        lines = list(old)
        for (start, stop, put), whose in reversed(list(zip(places, owner, strict=True))):
            if whose is side:
                lines[start:stop] = put
        sides.append("\n".join(lines).encode("latin-1"))
    stamp = _STAMP.search(second)
    if stamp is not None:
        sides[1] = _STAMP.sub(stamp[0], sides[1], count=1)
    return _stamped(first, sides[0], sides[1], second)


_NUMBERS = re.compile(rb"(?m)^ *\d+:|\b(?:BC|EC|C)\d{3,}|P\[ *\d+")


def on_its_own(folder: Path, first: bytes, second: bytes, third: bytes) -> Sides | None:
    """Two people who each began with `first`: one made of it `second`, the other did in it what `third` changed next.

    That is what a rebase or a cherry-pick of the second change has to do. What `third` changed in lines that `second`
    has written cannot be done without them, and what it put elsewhere is not another's: both are left out. None where
    nothing is left, and where positions or lines got other numbers.
    """
    if len({tuple(_NUMBERS.findall(text)) for text in (first, second, third)}) > 1:
        return None
    base, ours, after = (text.decode("latin-1").split("\n") for text in (first, second, third))
    old, new, last = ([_unstamped(line) for line in lines] for lines in (base, ours, after))
    often = [Counter(_named_lines("\n".join(lines))) for lines in (old, new, last)]
    alone = {one for of in often for one in of if max(some[one] for some in often) == 1}
    here: set[str] = set()
    shift, written = 0, []  # lines of `second`, and by how many lines what is behind them has moved
    for one in changes(folder, old, new):
        start, shift = one.start + shift, shift + len(one.new) - (one.stop - one.start)
        written.append((start, start + len(one.new), shift))
        here.update(_named_lines("\n".join([*old[one.start : one.stop], *one.new])))
    shift, spots = 0, []
    for one in changes(folder, new, last):
        put = after[one.start + shift : one.start + shift + len(one.new)]
        shift += len(one.new) - (one.stop - one.start)
        said = _named_lines("\n".join([*new[one.start : one.stop], *one.new]))
        moved = alone.intersection(here, said)
        if not moved and not any(_meets(one, start, stop) for start, stop, _ in written):
            back = [by for _, stop, by in written if stop <= one.start]
            spots.append((one.start, one.stop, put, back[-1] if back else 0))
    theirs, merged = list(base), list(ours)
    for start, stop, put, back in reversed(spots):
        theirs[start - back : stop - back] = put
        merged[start:stop] = put
    stamps = [_STAMP.search(text) for text in (second, third)]
    told = ["\n".join(lines).encode("latin-1") for lines in (theirs, merged)]
    if spots and stamps[0] and stamps[1]:
        newest = max(
            (one[0] for one in stamps if one), key=lambda text: list(map(int, re.findall(rb"\d+", text)))
        )
        told = [
            _STAMP.sub(one, text, count=1) for one, text in zip((stamps[1][0], newest), told, strict=True)
        ]
    return Sides(second, *told) if spots else None


def _meets(change: Change, start: int, stop: int) -> bool:
    """Whether a change of lines `start` to `stop` and another one share a line, or it cannot be said which is first."""
    if change.start == change.stop or start == stop:
        return change.start <= stop and start <= change.stop
    return change.start < stop and start < change.stop


_DECLARED = re.compile(r"(?:GLOBAL )?(?:INT|REAL|BOOL|POS|E6POS|FRAME|AXIS|E6AXIS|num|robtarget) (\w+)")


def _named_lines(text: str) -> list[str]:
    """The lines that have a word, and the names that they declare."""
    said = [line for line in _lines(text) if re.search(r"\w", line)]
    return [*said, *(f"name {match[1]}" for match in map(_DECLARED.match, said) if match)]


def _in_common(places: Sequence[set[str]]) -> list[int]:
    """A number for each place: the same for those that have a line of a word in common, through others as well."""
    found = list(range(len(places)))
    known: dict[str, int] = {}
    for at, lines in enumerate(places):
        for line in sorted(set(_named_lines("\n".join(lines)))):
            other = found[known.setdefault(line, at)]
            mine = found[at]
            found = [other if one == mine else one for one in found]
    return found


def _unstamped(line: str) -> str:
    return "stamp" if _STAMP.match(line.encode("latin-1", "replace")) else line
