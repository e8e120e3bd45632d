"""The /POS section: taught positions of one or more motion groups.

Plain positions of an arm, alone or with a table of two axes, are read by one regular expression each and converted by
numpy together: a CAM program has 100,000 of them. Whatever differs from the plain forms goes through the slower reader
below.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Severity, Span
from olp.core.units import deg, mm
from olp.ir.expressions import Store
from olp.ir.points import PointBlock, PointKind, PointState, PointTable, sectors_of_turns
from olp.ir.program import LineKind
from olp.languages.findings import Findings
from olp.languages.vendors.tp.values import GROUP_STORES

MODAL: Final = -1  # UT : F, the tool that is selected when the point is used
SELECTED: Final = "active"  # UF : F, the frame that is selected then (`PointState.frame`)
_N = r"([-+]?(?:\d{1,9}\.?\d{0,9}|\.\d{1,9}))"
_FRAMES: Final = r"\s*UF\s*:\s*(\d{1,3}|F)\s*,\s*UT\s*:\s*(\d{1,3}|F)\s*,\s*"


def _pose(gap: str) -> str:
    """The pattern of an arm's pose; `gap`: what stands between a number and its unit."""
    flags = r"(?:CONFIG|KONFIG)\s*:\s*'([^'\n]*)'"
    units = {"X": "mm", "Y": "mm", "Z": "mm", "W": "deg", "P": "deg", "R": "deg"}
    rows = (rf"{name}\s*=\s*{_N}{gap}{unit}\s*" for name, unit in units.items())
    return rf"{_FRAMES}{flags}\s*,\s*" + r",\s*".join(rows)


_POSE, _SPACED_POSE = _pose(r"\s*"), _pose(r"\s+")
_PLAIN: Final = re.compile(
    rf"\s*P\[(\d{{1,6}})(?::\s*\"([^\"\n]*)\")?\s*\]\s*\{{\s*GP1\s*:{_POSE}\}}\s*;?[ \t]*(?:\n|$)"
)
_WITH_TABLE: Final = re.compile(
    rf"[ \t]*P\[(\d{{1,6}})\]\s*\{{\s*(?P<GP1>GP1\s*:){_SPACED_POSE}(?P<GP2>GP2\s*:){_FRAMES}"
    rf"J1\s*=\s*{_N}\s+deg\s*,\s*J2\s*=\s*{_N}\s+deg\s*\}}[ \t]*;?[ \t]*(?:\n|$)"
)
_HEAD = re.compile(r"\s*P\s*\[\s*(\d{1,6})\s*(?::\s*(?:\"([^\"]*)\"|([^\]]*)))?\s*\]\s*\{?\s*(.*)", re.DOTALL)
_GROUP = re.compile(r"GP(\d)\s*:")
_FRAME = re.compile(r"\b(UF|UT)\s*:\s*(\d{1,3}|F)\b")
_CONFIGURATION = re.compile(r"\b[CK]ONFIG\s*:\s*'([^']*)'")
_VALUE = re.compile(r"\b(X|Y|Z|W|P|R|J\d|E\d)\s*=\s*([^\s,}=]+)\s*(mm|deg)?")
_NUMBER = re.compile(r"[-+]?(?:\d{1,15}\.?\d{0,15}|\.\d{1,15})(?:[eE][-+]?\d{1,2})?")
_POSE_NAMES: Final = ("X", "Y", "Z", "W", "P", "R")
_SIX: Final = 6  # axes of an arm, numbers of a pose
_MOST_LINES = 60  # of one position
_LARGEST = 1e6  # mm or deg

_WRIST: Final = {"F": 0, "N": 1}
_ELBOW: Final = {"U": 0, "D": 1}
_FRONT: Final = {"T": 0, "B": 1}


@dataclass(slots=True)
class _Group:
    """Rows of one motion group while they are read."""

    numbers: list[int] = field(default_factory=list)
    values: list[tuple[float, ...] | list[float]] = field(default_factory=list)  # mm and deg
    states: list[int] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)


class TpPositionReader:
    """Reads the positions of one program. `names`: number -> its name; `units`: `GP1 E1` -> mm, where it is not deg."""

    def __init__(self, findings: Findings) -> None:
        self.findings = findings
        self.names: dict[int, str] = {}
        self.units: dict[str, str] = {}
        self.broken: set[int] = set()
        self.uninitialised: set[int] = set()
        self.other_configuration = ""  # the text of one that is not an arm's, for the way back
        self._groups: dict[int, _Group] = {}
        self._states: dict[PointState, int] = {}
        self._known: dict[tuple[str, str, str], int] = {}
        self._known_joints: dict[tuple[str, str], int] = {}

    # --- the plain form ---------------------------------------------------------------------------------

    def read(self, first: int, stop: int) -> None:
        """Source lines `first` .. `stop` - 1 (from 1)."""
        lines = self.findings.source.lines[first - 1 : stop - 1]
        text = "\n".join(lines)
        at, number, kinds = 0, first, self.findings.kinds
        group = self._groups.setdefault(1, _Group())
        numbers, values, states, places = group.numbers, group.values, group.states, group.lines
        known, match_plain, size = self._known, _PLAIN.match, len(text)
        while at < size:
            match = match_plain(text, at)
            if match is None:
                match = _WITH_TABLE.match(text, at)
                if match is not None and self._with_table(match, number):
                    number += text.count("\n", at, match.end())
                    at = match.end()
                else:
                    at, number = self._other(text, at, number)
                continue
            point, name, user, tool, flags, *row = match.groups()
            start = number
            end = match.end()
            number += text.count("\n", at, end)
            at = end
            state = known.get((user, tool, flags))
            if state is None:
                state = self._pose_state(user, tool, flags, start)
            if name:
                self.names[int(point)] = name
            numbers.append(int(point))
            values.append([*map(float, row)])
            states.append(state)
            places.append(start)
        _mark(kinds, lines, first)

    def _with_table(self, match: re.Match[str], line: int) -> bool:
        """Keeps a position of an arm and of a table that begins in `line`; False for one that is not plain."""
        point, _, user, tool, flags, *numbers, _, table_user, table_tool, first, second = match.groups()
        arm, axes = [*map(float, numbers)], [float(first), float(second)]
        if max(map(abs, (*arm, *axes))) > _LARGEST or ":" in flags or "}" in flags:
            return False
        places = [line + match.string.count("\n", match.start(), match.end(head)) for head in ("GP1", "GP2")]
        state = self._known.get((user, tool, flags))
        if state is None:
            state = self._pose_state(user, tool, flags, places[0])
        self._keep(1, int(point), arm, state, places[0])
        self._keep(2, int(point), axes, self._joint_state(table_user, table_tool), places[1])
        return True

    def _keep(self, group: int, number: int, values: list[float], state: int, line: int) -> None:
        rows = self._groups.setdefault(group, _Group())
        rows.numbers.append(number)
        rows.values.append(values)
        rows.states.append(state)
        rows.lines.append(line)

    def _joint_state(self, user: str, tool: str, own: int = 0, units: tuple[str, ...] = ()) -> int:
        index = None if own else self._known_joints.get((user, tool))
        if index is None:
            state = PointState(
                PointKind.JOINT,
                "joint",
                None if user == "F" else int(user),
                MODAL if tool == "F" else int(tool),
                own=own,
                units=units,
            )
            index = self._states.setdefault(state, len(self._states))
            if not own:
                self._known_joints[user, tool] = index
        return index

    def _pose_state(
        self, user: str, tool: str, flags: str, line: int, own: int = 0, units: tuple[str, ...] = ()
    ) -> int:
        configuration = self._configuration(flags, line)
        fourth, sixth, fifth = (
            (*configuration[3:5], *configuration[6:], 0)[:3] if configuration else (0, 0, 0)
        )
        state = PointState(
            PointKind.POSE,
            SELECTED if user == "F" else "base" if user == "0" else "user",
            None if user in ("0", "F") else int(user),
            MODAL if tool == "F" else int(tool),
            configuration,
            sectors=sectors_of_turns(((3, fourth), (4, fifth), (5, sixth))),
            own=own,
            units=units,
        )
        index = self._states.setdefault(state, len(self._states))
        if not own:
            self._known[user, tool, flags] = index
        return index

    def _configuration(self, text: str, line: int) -> tuple[int, ...]:
        """RCONF's six flags, those of the turns with their sign, J5's turn behind them. () for an arm with others."""
        letters, *turns = (part.strip() for part in text.split(","))
        words = letters.split()
        try:
            counts = [int(turn) for turn in turns]
        except ValueError:
            counts = []
        flags = (
            [_WRIST.get(words[0]), _ELBOW.get(words[-2]), _FRONT.get(words[-1])] if len(words) > 2 else [None]
        )
        if None in flags or len(counts) != 3 or max(map(abs, counts)) > 9:
            message = f"the configuration '{text.strip()[:40]}' is not that of a six-axis arm"
            help = "expected such as 'N U T, 0, 0, 0'; the branch near the point before is taken"
            self.other_configuration = self.other_configuration or text.strip()
            self.findings.once(Severity.WARNING, "P513", text, message, self._span(line), help)
            return ()
        fourth, fifth, sixth = counts  # turns of J4, J5, J6, as $SCR_GRP.$TURN_AXIS is set when delivered
        return (*(flag for flag in flags if flag is not None), fourth, sixth, 0, *([fifth] if fifth else []))

    # --- all other forms --------------------------------------------------------------------------------

    def _other(self, text: str, at: int, number: int) -> tuple[int, int]:
        """One position that is not plain, or one line that is none. Returns where to go on."""
        end = text.find("\n", at)
        end = len(text) if end < 0 else end + 1
        line = text[at:end]
        if not line.strip():
            return end, number + 1
        if _HEAD.match(line) is None:
            if line.strip().startswith(("!", "//")):
                self.findings.kinds[number - 1] = LineKind.COMMENT
            else:
                self._refuse("P510", "this is no position", number, 'expected such as P[1]{ or P[1:"home"]{')
            return end, number + 1
        stop = end
        for _ in range(_MOST_LINES):
            if "}" in text[at:stop] or stop >= len(text):
                break
            following = text.find("\n", stop)
            following = len(text) if following < 0 else following + 1
            if _HEAD.match(text[stop:following]) is not None:
                break
            stop = following
        self._block(text[at:stop], number)
        return stop, number + max(text.count("\n", at, stop), 1)

    def _block(self, text: str, line: int) -> None:
        match = _HEAD.match(text)
        assert match is not None
        number, body = int(match[1]), match[4]
        name = (match[2] or match[3] or "").strip()
        if name:
            self.names[number] = name
        if "}" not in body:
            self._broken(
                number, "P510", f"the position P[{number}] is never closed", line, "add }; behind its values"
            )
            return
        body = body[: body.index("}")]
        heads = list(_GROUP.finditer(body))
        if not heads:
            self._broken(
                number, "P511", f"the position P[{number}] has no GP1", line, "expected GP1: and its values"
            )
            return
        for place, head in enumerate(heads):
            stop = heads[place + 1].start() if place + 1 < len(heads) else len(body)
            self._group(
                number,
                int(head[1]),
                body[head.end() : stop],
                line + text.count("\n", 0, _offset(text, body, head)),
            )

    def _group(self, number: int, group: int, text: str, line: int) -> None:
        frames = dict(_FRAME.findall(text))
        flags = _CONFIGURATION.search(text)
        # The configuration's text must not be taken for values.
        found = _VALUE.findall(text if flags is None else text[: flags.start()] + text[flags.end() :])
        values: dict[str, float] = {}
        for name, written, unit in found:
            value = self._value(number, name, written, line)
            if value is None:
                return
            values[name] = value
            if name[0] in "JE" and unit == "mm":
                self.units[f"GP{group} {name}"] = "mm"
        user, tool = frames.get("UF", "0"), frames.get("UT", "1" if group == 1 else "0")
        extra = _external(values)
        own = max(_SIX, sum(name[0] == "J" for name in values)) if extra else 0
        slides = {name for name, _, unit in found if unit == "mm"}
        units = tuple("mm" if f"E{n}" in slides else "deg" for n in range(1, len(extra) + 1))
        if "X" in values or (flags is not None and "J1" not in values):
            names: tuple[str, ...] = _POSE_NAMES
            state = self._pose_state(user, tool, flags[1] if flags else "N U T, 0, 0, 0", line, own, units)
        else:
            names = tuple(sorted(name for name in values if name[0] == "J"))
            state = self._joint_state(user, tool, own, units)
        missing = [name for name in names if name not in values]
        if missing or not names or [*names[:1]] not in (["X"], ["J1"]):
            what = missing[0] if missing else "J1"
            self._broken(
                number, "P511", f"P[{number}] has no {what}", line, "expected X Y Z W P R, or J1 and so on"
            )
            return
        if group not in GROUP_STORES:
            message = f"motion group {group} is kept in the text only"
            self.findings.once(Severity.WARNING, "P514", str(group), message, self._span(line))
            return
        row = [values[name] for name in names]
        row = [*row, *[float("nan")] * (_SIX - len(row)), *extra] if extra else row
        self._keep(group, number, row, state, line)

    def _value(self, number: int, name: str, text: str, line: int) -> float | None:
        """[mm or deg] nan for ********; None where it is no number, which is told."""
        if set(text) == {"*"}:
            self.uninitialised.add(number)
            return float("nan")
        if _NUMBER.fullmatch(text) is None or abs(float(text)) > _LARGEST:
            message = f"{name} of P[{number}]: '{text[:40]}' is no number here"
            self._broken(number, "P510", message, line, "expected a number such as -12.345")
            return None
        return float(text)

    def _broken(self, number: int, code: str, message: str, line: int, help: str) -> None:
        self.broken.add(number)
        self._refuse(code, message, line, help)

    def _refuse(self, code: str, message: str, line: int, help: str) -> None:
        self.findings.once(Severity.ERROR, code, message, message, self._span(line), help)

    def _span(self, line: int) -> Span:
        return self.findings.whole_line(line)

    # --- result -----------------------------------------------------------------------------------------

    def table(self) -> PointTable:
        """All positions in SI."""
        states = tuple(self._states)
        blocks = {}
        for place, group in enumerate(self.groups(), 1):
            store = GROUP_STORES[place]
            blocks[store, True] = self._packed(store, group, self._groups[group], states)
        return PointTable(states, blocks, self.names)

    def groups(self) -> list[int]:
        """The motion groups that have positions; the first of them is taken for the robot."""
        return sorted(group for group, rows in self._groups.items() if rows.numbers)

    def _packed(self, store: Store, group: int, rows: _Group, states: tuple[PointState, ...]) -> PointBlock:
        width = max(map(len, rows.values))
        if any(len(row) != width for row in rows.values):
            values = np.full((len(rows.values), width), np.nan)
            for at, row in enumerate(rows.values):
                values[at, : len(row)] = row
        else:
            values = np.array(rows.values, dtype=np.float64)
        state = np.array(rows.states, dtype=np.int32)
        joint = np.array([one.kind is PointKind.JOINT for one in states])[state]
        _to_si(values, joint, self._axis_units(group))
        table = dict(zip(rows.numbers, range(len(rows.numbers)), strict=True))
        if len(table) != len(rows.numbers):
            self._duplicates(rows)
        lines = np.array(rows.lines, dtype=np.int32)
        return PointBlock(store, True, np.array(rows.numbers, dtype=np.int64), values, state, lines, table)

    def _axis_units(self, group: int) -> dict[str, float]:
        prefix = f"GP{group} "
        return {name.removeprefix(prefix): mm for name in self.units if name.startswith(prefix)}

    def _duplicates(self, rows: _Group) -> None:
        seen: dict[int, int] = {}
        for number, line in zip(rows.numbers, rows.lines, strict=True):
            if number in seen:
                help = f"the first one is in line {seen[number]}; the last one counts"
                self.findings.warning("P512", f"P[{number}] stands twice", self._span(line), help)
            seen.setdefault(number, line)


def _external(values: dict[str, float]) -> list[float]:
    """E1, E2 and so on as far as there are any; nan for one that is left out."""
    last = max((int(name[1:]) for name in values if name[0] == "E"), default=0)
    return [values.get(f"E{n}", float("nan")) for n in range(1, last + 1)]


def _to_si(values: NDArray[np.float64], joint: NDArray[np.bool_], units: dict[str, float]) -> None:
    """In place. `units`: SI per written unit of axes such as J1 or E1 that are no angles."""
    width = values.shape[1]
    pose = np.full(width, deg)
    pose[:3] = mm
    axes = np.full(width, deg)
    for name, scale in units.items():
        place = int(name[1:]) - 1
        if name[0] == "J" and place < width:
            axes[place] = scale
        elif name[0] == "E" and 6 + place < width:
            pose[6 + place] = axes[6 + place] = scale
    if not joint.any():
        values *= pose
        return
    values[~joint] *= pose
    values[joint] *= axes


def _mark(kinds: bytearray, lines: tuple[str, ...], first: int) -> None:
    """Lines of the section that nobody marked belong to a position."""
    for number, text in enumerate(lines, first):
        if kinds[number - 1] == LineKind.BLANK and text and not text.isspace():
            kinds[number - 1] = LineKind.POINT


def _offset(text: str, body: str, head: re.Match[str]) -> int:
    return text.find(body) + head.end() if body else 0
