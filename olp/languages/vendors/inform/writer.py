"""Writes programs as INFORM jobs: what `templates/inform.j2` puts together.

Codes: X002 what INFORM cannot say.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic
from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.ir.points import PointBlock, PointKind, PointState, PointTable
from olp.languages.generator import CannotSayError, Joined, Lines, as_text
from olp.languages.vendors.inform import WELDS, values
from olp.languages.vendors.inform.limits import MOST_ARGUMENTS
from olp.languages.vendors.inform.statements import FUNCTIONS
from olp.languages.vendors.inform.write_values import COUNTED, LETTERS, InformValues, decimal, is_simple

# --- Write moves ---
# Writes motion: MOVx, IMOV, SMOVx, REFP and SPEED with their tags and second parts.

_LETTERS: Final = {st.Path.JOINT: "J", st.Path.LINEAR: "L", st.Path.CIRCULAR: "C", st.Path.SPLINE: "S"}
_TAGS: Final = {st.SpeedUnit.TRAVEL: ("V", 1), st.SpeedUnit.FRACTION: ("VJ", 2), st.SpeedUnit.TURN: ("VR", 1)}


class InformMoves(InformValues):
    """Writes motion."""

    def _speed(self, speed: st.Speed) -> str:
        """`V=187.0`."""
        if speed.unit not in _TAGS:
            raise CannotSayError("a speed of this unit", "INFORM has V= in mm/s, VR= in °/s and VJ= in %")
        tag, decimals = _TAGS[speed.unit]
        _, literal, counted = values.SPEEDS[tag]
        return f"{tag}={self.amount(speed.value, (literal, counted), decimals)}"

    def write_move(self, s: st.Move) -> Lines:
        words = [self._word(s), *map(self.single, s.targets)]
        if s.passes:
            words.append(s.passes)
        if s.speed is not None:
            words.append(self.once(s.speed, self._speed))
        if s.blend is not None:
            words.append(self._blend(s.blend))
        if not _is_plain(s):
            words += self._tags(s)
        text = " ".join(words)
        return text + "".join(map(self._part, s.parts)) if s.parts else text

    def _word(self, s: st.Move) -> str:
        if s.relative is None:
            return f"{'S' if s.coordinated else ''}MOV{_LETTERS[s.path]}"
        joint = s.speed is not None and s.speed.unit is st.SpeedUnit.FRACTION
        if s.coordinated or s.path is not (st.Path.JOINT if joint else st.Path.LINEAR):
            raise CannotSayError(
                "a relative move of this shape", "IMOV moves linearly with V=, or by axes with VJ="
            )
        return "IMOV"

    def _blend(self, blend: st.Blend) -> str:
        kind, value = blend.kind, blend.value
        if kind is st.BlendKind.CONTINUOUS or value is None:
            return "CONT"
        if kind is st.BlendKind.LEVEL:
            return f"PL={self.amount(value, values.LEVEL, 0)}"
        return f"CR={self.amount(value, (mm, mm), 1)}"

    def _tags(self, s: st.Move) -> list[str]:
        """The rarer ones, in the order that controllers write them in."""
        quantity = self.amount
        found = [f"{tag}={self.single(value)}" for tag, value in s.other]
        if s.acceleration is not None:
            found.append(f"ACC={quantity(s.acceleration, values.RATE, 0)}")
        braking = s.acceleration if s.deceleration is None else s.deceleration
        if braking is not None and (s.acceleration is None or braking.literal != 1.0):
            found.append(f"DEC={quantity(braking, values.RATE, 0)}")
        if s.end_of_arc:
            found.append("FPT")
        if s.relative is not None and s.relative.kind != "own":
            found.append(self.value(s.relative))
        if s.search is not None:
            found.append(self._search(s))
        if s.no_wait:
            found.append("NWAIT")
        if s.until is not None:
            found.append(f"UNTIL {self.joined(s.until, express=False)}")
        return found

    def _search(self, s: st.Move) -> str:
        assert s.search is not None
        signal, on, time, distance = s.search
        text = f"SRCH {self.signal(signal)}={'ON' if on else 'OFF'}"
        if time is not None:
            text += f" T={self.amount(time, values.TIME, 2)}"
        if distance is not None:
            text += f" DIS={self.amount(distance, values.DISTANCE, 1)}"
        return text

    def _part(self, part: st.MovePart) -> str:
        word = "REFP" if part.path is None else f"MOV{_LETTERS[part.path]}"
        speed = "" if part.speed is None else f" {self._speed(part.speed)}"
        blend = "" if part.blend is None else f" {self._blend(part.blend)}"
        return f"  +{word} {' '.join(map(self.single, part.targets))}{speed}{blend}"

    def write_reference(self, s: st.Reference) -> Lines:
        targets = " ".join(map(self.single, s.targets))
        word = "SREFP" if s.coordinated else "REFP"
        return f"{word} {self.single(s.number)} {targets}{''.join(map(self._part, s.parts))}"

    def write_set_speed(self, s: st.SetSpeed) -> Lines:
        return " ".join(["SPEED", *map(self._speed, s.speeds)])


def _is_plain(s: st.Move) -> bool:
    return (
        s.relative is None
        and s.search is None
        and s.until is None
        and s.acceleration is None
        and s.deceleration is None
        and not (s.end_of_arc or s.no_wait or s.other)
    )


# --- Writer ---

_NUMBERED = tuple(store for store in LETTERS if store is not ex.Store.SYSTEM)
_COMMENT_ROWS = 8
_FUNCTION_WORDS: Final = {name: word for word, name in FUNCTIONS.items()}
_UPDATES: Final = {
    "+": "ADD",
    "-": "SUB",
    "*": "MUL",
    "/": "DIV",
    "and": "AND",
    "or": "OR",
    "xor": "XOR",
    "not": "NOT",
}
_STEPS = {"+": "INC", "-": "DEC"}


@dataclass(frozen=True, slots=True)
class InformJob:
    """One job as the template sees it. Texts of several lines end with a line end."""

    name: str
    folder: str
    counts: str  # ///NPOS
    positions: str
    global_counts: str  # of the named variables, like local_counts; empty: none is named
    global_names: str
    local_counts: str
    local_names: str
    argument_types: str
    argument_comments: str | None  # None: no ///COMMENT
    has_arguments: bool
    date: str
    comment: str
    attributes: str
    frame: str
    frame_record: str
    groups: tuple[str, ...]
    locals: str  # ///LVARS: the allocated ones; empty: none
    instructions: str


def write(program: st.Program, date: str) -> tuple[dict[str, object], list[Diagnostic]]:
    """The values for the template, and everything that INFORM cannot say.

    `date`: YYYY/MM/DD HH:MM, for jobs that have none.
    """
    return InformWriter(program, date).written()


class InformWriter(InformMoves):
    """Writes statements and jobs."""

    fields: ClassVar = {"*": "single"}
    templates: ClassVar = {
        st.Begin: "NOP",
        st.End: "END",
        st.ReadInput: "DIN {target} {signal}",
        st.PulseOutput: "PULSE {signal}{duration: T={}}",
        st.Label: "*{name}",
        st.Return: "RET{value: {}}",
        st.Else: "ELSE",
        st.EndIf: "ENDIF",
        st.EndWhile: "ENDWHILE",
        st.For: "FOR {variable} START= {start} TO {stop}{step: STEP= {}}",
        st.Next: "NEXT{variable: {}}",
        st.Case: "CASE {values}",
        st.Default: "DEFAULT",
        st.EndSwitch: "ENDSWITCH",
        st.Pause: "PAUSE",
        st.WaitTask: "PWAIT {task}",
        st.Synchronise: "TSYNC {number}{tasks: SNUM={}}",
        st.Message: "MSG {text}",
        st.Comment: "'{text}",
        st.Disabled: "COMM {text}",
    }
    _foreign = "a word of {self.source_language} that means nothing in INFORM"
    own_only: ClassVar = {st.Process: _foreign, st.Disabled: _foreign, st.Opaque: _foreign}
    welds: ClassVar = WELDS
    comment_form = "  //{}"
    joins = frozenset({st.Switch})

    def under(self, condition: ex.Expression, lines: list[str], s: st.Statement) -> list[str]:
        """` IF …`, or ` IFEXPRESS …` behind the line where several are joined."""
        express = self._express(s, type(condition) is ex.Logic or not is_simple(condition))
        return [f"{lines[0]} {'IFEXPRESS' if express else 'IF'} {self.joined(condition, express)}"]

    def _express(self, s: st.Statement, wanted: bool) -> bool:
        """Whether a condition takes the words for expressions: where INFORM wrote them, else where it is `wanted`."""
        spelling = getattr(s, "spelling", "") if self.own else ""
        return spelling.endswith(("EXP", "EXPRESS")) if spelling else wanted

    def _block(self, word: str, s: st.If | st.ElseIf | st.While) -> str:
        """IFTHEN, ELSEIF and WHILE, each with a form for expressions."""
        express = self._express(s, not is_simple(s.condition))
        return f"{word}{'EXP' if express else ''} {self.joined(s.condition, express)}"

    def write_if(self, s: st.If) -> Lines:
        return self._block("IFTHEN", s)

    def write_else_if(self, s: st.ElseIf) -> Lines:
        return self._block("ELSEIF", s)

    def write_while(self, s: st.While) -> Lines:
        return self._block("WHILE", s)

    def write_switch(self, s: st.Switch) -> Lines:
        return f"SWITCH {self.value(s.value)}"

    # --- values -------------------------------------------------------------------------------------

    def write_assign(self, s: st.Assign) -> Lines:
        if type(s.value) in (ex.Text, ex.Function):
            self.with_room(s.value)
        if type(s.target) is ex.Element:
            element = f"{self.single(s.target.variable)} ({self.single(s.target.index)})"
            return f"SETE {element} {self.single(s.value)}"
        if type(s.target) is ex.Function:
            return f"SETTOOL TL#({self.single(_only(s.target, 'tool-data'))}) {self.single(s.value)}"
        if type(s.target) is ex.FrameRef:
            raise CannotSayError(
                "a tool or frame that is assigned", "set it with MFRAME or on the controller"
            )
        target = self.single(s.target)
        if not self.own and (rows := self._by_steps(target, s.value)):
            return rows
        match s.value:
            case ex.Element(variable, index):
                return f"GETE {target} {self.single(variable)} ({self.single(index)})"
            case ex.SystemValue():
                return f"GETS {target} {self.system(s.value)}"
            case ex.Argument(number):
                self.at_most_arguments(number, MOST_ARGUMENTS)
                return f"GETARG {target} IARG#({number})"
            case ex.Signal() if s.value.bus == "register":
                return f"GETREG {target} {self._register(s.value)}"
            case ex.Function():
                return self._function(target, s.value)
            case ex.Binary() | ex.Unary() | ex.Signal():
                return f"SET {target}  EXPRESS {self.value(s.value)}"
            case _:
                return f"SET {target} {self.single(s.value)}"

    def _by_steps(self, target: str, value: ex.Expression) -> list[str]:
        """Sums of positions and texts of several parts, which published jobs put together one by one."""
        match value:
            case ex.Function("joined-text", (first, second, *more)) if more:
                parts = [self.single(part) for part in more]
                rows = [f"CAT$ {target} {self.single(first)} {self.single(second)}"]
                return (
                    [] if target in parts else [*rows, *(f"CAT$ {target} {target} {part}" for part in parts)]
                )
            case ex.Binary("+" | "-" as sign, ex.Variable(ex.Store.ROBOT), ex.Variable(ex.Store.ROBOT)):
                left, right = self.single(value.left), self.single(value.right)
                if right == target and sign == "+":
                    left, right = right, left
                copy = [] if left == target else [f"SET {target} {left}"]
                return [] if right == target != left else [*copy, f"{_UPDATES[sign]} {target} {right}"]
        return []

    def _function(self, target: str, function: ex.Function) -> str:
        name, arguments = function.name, function.arguments
        if name == "tool-data":
            return f"GETTOOL {target} TL#({self.single(_only(function, name))})"
        if name == "step-position":
            return f"GETPOS {target} STEP#({self.single(_only(function, name))})"
        if name == "parameter" and len(arguments) == 2:
            return f"GETPRM {target} KIND={self.single(arguments[0])} PRMNO={self.single(arguments[1])}"
        if name not in _FUNCTION_WORDS:
            raise CannotSayError(terminology.function(name))
        return " ".join([_FUNCTION_WORDS[name], target, *map(self.single, arguments)])

    def _register(self, signal: ex.Signal) -> str:
        return f"{self.signal(signal)}{f' {signal.part.upper()}' if signal.part else ''}"

    def write_update(self, s: st.Update) -> Lines:
        target = self.single(s.target)
        if s.operator in _STEPS and s.operand == ex.Number(1) and _is_counter(s.target):
            return f"{_STEPS[s.operator]} {target}"
        if s.operator not in _UPDATES or s.operand is None:
            raise CannotSayError(terminology.operation(s.operator))
        return f"{_UPDATES[s.operator]} {target} {self.single(s.operand)}"

    def write_clear(self, s: st.Clear) -> Lines:
        if s.target is None:
            return "CLEAR STACK"
        return f"CLEAR {self.single(s.target)} {'ALL' if s.count is None else self.single(s.count)}"

    # --- frames -------------------------------------------------------------------------------------

    def write_define_frame(self, s: st.DefineFrame) -> Lines:
        points = map(self.single, s.points)
        return " ".join(["MFRAME", self.value(s.frame), *points, *(["MTOOL"] if s.master_tool else [])])

    def write_shift_on(self, s: st.ShiftOn) -> Lines:
        frame = "" if s.frame is None else f" {self.value(s.frame)}"
        return f"{'S' if s.coordinated else ''}SFTON {self.single(s.offset)}{frame}"

    def write_shift_off(self, s: st.ShiftOff) -> Lines:
        return "SSFTOF" if s.coordinated else "SFTOF"

    def write_external_tool(self, s: st.ExternalTool) -> Lines:
        return "TCPOF" if s.tool is None else f"TCPON TL#({self.single(s.tool)})"

    # --- signals and time ---------------------------------------------------------------------------

    def write_set_output(self, s: st.SetOutput) -> Lines:
        if s.signal.bus == "register":
            return f"SETREG {self._register(s.signal)} {self.single(s.value)}"
        word = "AOUT" if s.signal.bus == "analog-out" else "DOUT"
        return f"{word} {self.signal(s.signal)} {self.single(s.value)}"

    def write_dwell(self, s: st.Dwell) -> Lines:
        """TIMER lasts 0.01 s at least: one of no time, which only stopped the arm, is no line."""
        if not self.own and s.duration.literal == 0.0:
            return []
        return f"TIMER T={self.seconds(s.duration)}"

    def write_wait(self, s: st.Wait) -> Lines:
        express = self._express(s, type(s.condition) is ex.Logic)
        time = "" if s.timeout is None else f" T={self.seconds(s.timeout)}"
        return f"WAIT {'FOREXPRESS ' if express else ''}{self.joined(s.condition, express)}{time}"

    # --- control flow -------------------------------------------------------------------------------

    def write_jump(self, s: st.Jump) -> Lines:
        target = f"*{s.target}" if isinstance(s.target, str) else f"LABEL: {self.single(s.target)}"
        return f"JUMP {target}"

    def write_call(self, s: st.Call) -> Lines:
        if s.macro is not None:
            text = f"MACRO1 MJ#({self.single(s.macro)})"
        else:
            text = f"{'JUMP' if s.jump else 'CALL'} JOB:{s.routine}"
        given = s.arguments if s.result is None else (*s.arguments, self.number_of(s.result))
        if not self.own:  # a state is a number in a variable, which the job gets
            given = [ex.Number(int(e.on)) if isinstance(e, ex.SignalState) else e for e in given]
        self.at_most_arguments(len(given), MOST_ARGUMENTS)
        arguments = "".join(f" ARGF{self.single(argument)}" for argument in given)
        return f"{text}{arguments}"

    # --- operator, tasks, process -------------------------------------------------------------------

    def write_start_task(self, s: st.StartTask) -> Lines:
        if not s.task:
            raise CannotSayError("a parallel task without a number", "INFORM has the tasks SUB1 and further")
        sync = " SYNC" if s.synchronised else ""
        return f"PSTART JOB:{s.routine} {s.task}{sync}"

    def write_process(self, s: st.Process) -> Lines:
        return " ".join([s.name, *(self._argument(tag, value) for tag, value in s.arguments)])

    def _argument(self, tag: str, value: ex.Expression) -> str:
        if tag.endswith("#"):
            return f"{tag}({self.single(value)})"
        if tag == "T" and type(value) is ex.Number:
            return f"T={decimal(float(value.value), 2)}"
        return f"{tag}={self.single(value)}" if tag else self.single(value)

    def together(self, body: Sequence[st.Statement], place: int) -> Joined | None:
        """SWITCH and its first CASE may share a line."""
        one, case = body[place], body[place + 1] if place + 1 < len(body) else None
        if not isinstance(one, st.Switch) or not isinstance(case, st.Case):
            return None
        if case.line != one.line or one.comment:
            return None
        return Joined([f"{self.lines(one)[0]} {self.lines(case)[0]}"], 2, case.comment)

    # --- jobs -------------------------------------------------------------------------------------------

    def template_values(self) -> dict[str, object]:
        return {"jobs": tuple(map(self._job, self.program.routines))}

    def _job(self, routine: st.Routine) -> InformJob:
        details = routine.details if self.own else {}
        attributes = details.get("ATTR", "")
        old = attributes[:1].isdigit()  # ERC writes flags, all later generations words
        self.aliases = routine.aliases
        self.point_digits, self.station_letter = (3, "E") if old else (5, "EC")
        positions = InformPositionWriter(routine.points, exact=self.own, old=old)
        counts = rows = ""
        try:
            counts, rows = positions.counts(), as_text(positions.lines())
        except CannotSayError as problem:
            self.lose(problem, routine.line)
        types = details.get("ARGTYPE") or _types(routine)
        remarks = details.get("COMMENT")
        global_counts, global_names = _names(routine, local=False)
        local_counts, local_names = _names(routine, local=True)
        frame = self._frame(routine.relative_to, old)
        self.begin()
        self.body(routine.body)
        return InformJob(
            name=routine.name,
            folder=details.get("FOLDERNAME", ""),
            counts=counts,
            positions=rows,
            global_counts=global_counts,
            global_names=global_names,
            local_counts=local_counts,
            local_names=local_names,
            argument_types=types,
            argument_comments=None if remarks is None else as_text(remarks.split("\n")),
            has_arguments=bool(types) or remarks is not None,
            date=details.get("DATE") or self.date,
            comment=routine.comment,
            attributes=attributes or ("SC,RW,RJ" if routine.relative_to else "SC,RW"),
            frame=frame,
            frame_record="///FRAME" if old else "////FRAME",
            groups=tuple(",".join(group.mechanisms) for group in routine.groups),
            locals=_counts(routine.locals) if routine.locals else "",
            instructions=as_text(self.rows),
        )

    def _frame(self, frame: ex.FrameRef | None, old: bool) -> str:
        if frame is None:
            return ""
        if frame.number is None:
            return frame.kind.upper()
        number = self.single(frame.number)
        return number if old else f"USER {number}"


def _names(routine: st.Routine, local: bool) -> tuple[str, str]:
    """The counts and rows of //ALIAS for the named local or global variables."""
    found = [(name, it) for name, it in routine.aliases.items() if it.local == local]
    order: list[ex.Store] = list(_NUMBERED)
    found.sort(key=lambda pair: (order.index(pair[1].store), _index(pair[1])))
    sizes = {store: sum(it.store is store for _, it in found) for store in order}
    letter = "L" if local else ""
    rows = as_text(f"{letter}{LETTERS[it.store]}{_index(it):03d} {name}" for name, it in found)
    return (_counts(sizes) if found else ""), rows


def _index(variable: ex.Variable) -> int:
    value = getattr(variable.index, "value", None)
    assert isinstance(value, int)  # a name stands for one variable, never for a computed one
    return value


def _counts(sizes: object) -> str:
    assert isinstance(sizes, dict)
    return ",".join(str(sizes.get(store, 0)) for store in _NUMBERED)


def _types(routine: st.Routine) -> str:
    """///ARGTYPE: eight letters or nothings with commas."""
    if not routine.arguments:
        return ""
    letters = ["" if store is None else LETTERS[store] for store in routine.arguments]
    return ",".join([*letters, *[""] * (_COMMENT_ROWS - len(letters))])


def _only(function: ex.Function, name: str) -> ex.Expression:
    if function.name != name or len(function.arguments) != 1:
        raise CannotSayError(f"{terminology.function(function.name)} in this place")
    return function.arguments[0]


def _is_counter(target: ex.Expression) -> bool:
    return type(target) is ex.Variable and target.store in COUNTED


# --- Write positions ---
# Writes the //POS section: rows by family, and a state record wherever the state changes.

FAMILIES: Final = {
    "C": (ex.Store.ROBOT, True),
    "BC": (ex.Store.BASE, True),
    "EC": (ex.Store.STATION, True),
    "P": (ex.Store.ROBOT, False),
    "BP": (ex.Store.BASE, False),
    "EX": (ex.Store.STATION, False),
}
_KIND_RECORDS: Final = {PointKind.PULSE: "PULSE", PointKind.POSE: "RECTAN", PointKind.JOINT: "ANGLE"}
_POSTYPES: Final = {
    "pulse": "PULSE",
    "joint": "ANGLE",
    "base": "BASE",
    "robot": "ROBOT",
    "user": "USER",
    "tool": "TOOL",
    "master-tool": "MTOOL",
}
_LENGTH_DECIMALS, _ANGLE_DECIMALS, _OLD_ANGLE_DECIMALS = 3, 4, 2
_MOST_DECIMALS = 9
_FLAGS = 24  # of ///RCONF, all generations since the NX100


class InformPositionWriter:
    """Writes the positions of one job. `exact`: as many decimals as give the same numbers when read again."""

    def __init__(self, points: PointTable, exact: bool, old: bool) -> None:
        self.points = points
        self.exact = exact
        self.old = old  # ERC: three digits, no position types, four counts, E for stations
        self._written: dict[str, str] = {}

    def counts(self) -> str:
        """What ///NPOS says: the number of rows of each family."""
        sizes = {name: len(self.points.blocks.get(key, ())) for name, key in FAMILIES.items()}
        names = ("C", "EC", "P", "EX") if self.old else tuple(FAMILIES)
        left_out = [name for name in FAMILIES if sizes[name] and name not in names]
        if left_out:
            raise CannotSayError(f"{left_out[0]} positions in a job of the ERC generation")
        return ",".join(str(sizes[name]) for name in names)

    def lines(self) -> Iterator[str]:
        """All rows and state records."""
        for name, key in FAMILIES.items():
            block = self.points.blocks.get(key)
            if block is None or not len(block):
                continue
            starts = [0, *(np.nonzero(np.diff(block.state))[0] + 1).tolist(), len(block)]
            for start, stop in pairwise(starts):
                state = self.points.states[int(block.state[start])]
                yield from self._records(state)
                yield from self._rows(name, block, slice(start, stop), state)
        if self._written.get("LIMIT") == "ON":
            yield "///LIMIT OFF"
        unknown = [
            key for key, block in self.points.blocks.items() if len(block) and key not in FAMILIES.values()
        ]
        if unknown:
            raise CannotSayError(f"a taught position as a {terminology.STORES[unknown[0][0]]}")

    # --- state ------------------------------------------------------------------------------------------

    def _records(self, state: PointState) -> Iterator[str]:
        if state.frame not in _POSTYPES:
            raise CannotSayError(f"positions in {terminology.SYSTEMS.get(state.frame, state.frame)}")
        wanted = {"USER": str(state.user)} if state.user is not None else {}
        wanted["TOOL"] = str(state.tool)
        if not self.old or state.frame not in ("pulse", "joint", "base"):
            wanted["POSTYPE"] = _POSTYPES[state.frame]
        wanted["kind"] = _KIND_RECORDS[state.kind]
        if state.configuration:
            wanted["RCONF"] = self._configuration(state.configuration)
        elif state.kind is PointKind.POSE and "RCONF" in self._written:
            raise CannotSayError("a position without an arm configuration behind one that has it")
        wanted["LIMIT"] = "ON" if state.outside_limits else "OFF"
        for word, value in wanted.items():
            if self._written.get(word, "OFF" if word == "LIMIT" else None) != value:
                self._written[word] = value
                yield f"///{value}" if word == "kind" else f"///{word} {value}"

    def _configuration(self, flags: tuple[int, ...]) -> str:
        filled = flags
        if not self.exact:  # others count turns with their sign, and those of B behind the rest
            filled = tuple(min(abs(flag), 1) for flag in flags[:6])
            filled += flags[6:] if len(flags) == _FLAGS else (0,) * (_FLAGS - len(filled))
        return ",".join(map(str, filled))

    # --- rows -------------------------------------------------------------------------------------------

    def _rows(self, name: str, block: PointBlock, rows: slice, state: PointState) -> Iterator[str]:
        letter = "E" if self.old and name == "EC" else name
        numbers, values = block.numbers[rows].tolist(), block.values[rows]
        angle_decimals = _OLD_ANGLE_DECIMALS if self.old else _ANGLE_DECIMALS
        scale, decimals = _units(block.store, state.kind, values.shape[1], angle_decimals)
        rounded = _rounded(values / scale, decimals) + 0.0  # turns -0 into 0
        plain = np.asarray(~np.isnan(rounded).any(axis=1))
        if self.exact or state.kind is PointKind.PULSE:
            plain &= np.all(rounded * scale == values, axis=1)
        head = f"{letter}%0{3 if self.old else 5}d="
        form = head + ",".join(f"%.{count}f" for count in decimals)
        table = rounded.tolist()
        for number, row, as_it_is, original in zip(numbers, table, plain.tolist(), values, strict=True):
            if as_it_is:
                yield form % (number, *row)
            else:
                yield head % number + self._odd_row(original, scale, decimals)

    def _odd_row(self, values: NDArray[np.float64], scale: NDArray[np.float64], decimals: list[int]) -> str:
        """A row with empty fields or more decimals than usual."""
        texts = [
            "" if value != value else _field(value, unit, count)
            for value, unit, count in zip(values.tolist(), scale.tolist(), decimals, strict=True)
        ]
        while len(texts) > 1 and not texts[-1] and not self.old:
            texts.pop()
        return ",".join(texts)


def _units(
    store: ex.Store, kind: PointKind, width: int, angle_decimals: int
) -> tuple[NDArray[np.float64], list[int]]:
    """SI per written unit, and decimals, of each value of a row."""
    if kind is PointKind.PULSE:
        return np.ones(width), [0] * width
    lengths = (
        width if store is ex.Store.BASE else 3 if kind is PointKind.POSE and store is ex.Store.ROBOT else 0
    )
    scale = np.where(np.arange(width) < lengths, mm, deg)
    return scale, [_LENGTH_DECIMALS if at < lengths else angle_decimals for at in range(width)]


def _rounded(values: NDArray[np.float64], decimals: list[int]) -> NDArray[np.float64]:
    """Each column to its decimals."""
    return np.column_stack([np.round(values[:, at], count) for at, count in enumerate(decimals)])


def _field(value: float, unit: float, at_least: int) -> str:
    """The shortest decimal fraction that reads as `value` again, or the usual one when none does."""
    for count in range(at_least, _MOST_DECIMALS + 1):
        number = round(value / unit, count)
        if number * unit == value:
            return decimal(number, at_least)
    return decimal(round(value / unit, at_least), at_least)
