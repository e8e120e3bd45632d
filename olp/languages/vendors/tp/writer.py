"""Writes programs as TP listings: what `templates/tp.j2` puts together.

Codes: X002 what TP cannot say.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import PureWindowsPath
from typing import ClassVar, Final

from olp.core.diagnostic import Diagnostic
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.ir.transformer import expressions_of
from olp.languages.generator import CannotSayError, Joined, Lines, as_text
from olp.languages.vendors.tp import WELDS, values
from olp.languages.vendors.tp.instructions import BLOCK
from olp.languages.vendors.tp.limits import COMMENT_LENGTH, LARGEST_LABEL, MOST_ARGUMENTS, NAME_LENGTH
from olp.languages.vendors.tp.write_moves import TpMoves, components, is_position, shift_of
from olp.languages.vendors.tp.write_positions import TpPositionWriter

_BLOCK_END: Final = "------"
_MOTIONS: Final = ("J ", "L ", "C ", "A ", "S ")
_DATE = re.compile(r"(\d\d)?(\d\d)/(\d\d)/(\d\d) (\d\d:\d\d)")
_BOOLEAN = (ex.Compare, ex.Logic, ex.Unary)
_LINE_ENDS: Final = frozenset("\r\n")
_FLANGE: Final = ex.FrameRef("tool", ex.Number(0))
_BASE: Final = ex.FrameRef("base")
_NOTHING: Final = ex.PositionLiteral("pose", (0.0,) * 6)
_TIMED_OUT: Final = ex.SystemValue("timed-out")
_FIRST_ADDED = 901  # label that the text needs and the program has not


@dataclass(frozen=True, slots=True)
class TpListingText:
    """One program as the template sees it. Texts of several lines end with a line end."""

    name: str
    kind: str
    owner: str
    comment: str
    created: str
    modified: str
    file_name: str
    version: str
    protect: str
    stack_size: str
    task_priority: str
    time_slice: str
    busy_lamp_off: str
    abort_request: str
    pause_request: str
    default_group: str
    control_code: str
    local_registers: str
    application: str
    line_count: int
    instructions: str
    positions: str


_COMPONENTS: Final = ("x", "y", "z", "rx", "ry", "rz")


def _component_of(e: ex.Expression, register: ex.Variable) -> int | None:
    """Which component of a register is asked for, from 0 on; None for anything else."""
    if isinstance(e, ex.Member) and e.base == register and e.name in _COMPONENTS:
        return _COMPONENTS.index(e.name)
    if isinstance(e, ex.Element) and e.variable == register:
        return int(e.index.value) - 1 if isinstance(e.index, ex.Number) else -1
    return None


def write(program: st.Program, date: str) -> tuple[dict[str, object], list[Diagnostic]]:
    """The values for the template, and everything that TP cannot say.

    `date`: YYYY/MM/DD HH:MM, for programs that have none.
    """
    return TpWriter(program, date).written()


class TpWriter(TpMoves):
    """Writes statements and listings."""

    templates: ClassVar = {
        st.Else: "ELSE",
        st.EndIf: "ENDIF",
        st.Next: "ENDFOR",
        st.Wait: "WAIT {condition}",
        st.Return: "END",
        st.Pause: "PAUSE",
        st.Disabled: "//{text}",
    }
    cannot: ClassVar = {
        st.Call: {"macro": "a macro by its number"},
        st.Return: {"value": "a value that a routine returns"},
        st.StartTask: {"synchronised": "a task that keeps step with this one"},
    }
    _foreign = "a word of another language: {called}"
    own_only: ClassVar = {st.Process: _foreign, st.Disabled: _foreign, st.Opaque: _foreign}
    welds: ClassVar = WELDS
    forgets = frozenset({st.Label, st.Call, st.Else, st.EndIf, st.For, st.Next, st.Switch})
    joins = frozenset({st.Wait, st.If, st.Switch})

    # --- values -----------------------------------------------------------------------------------------

    def write_assign(self, s: st.Assign) -> Lines:
        target, value = s.target, s.value
        if isinstance(target, ex.SystemValue) and target.name in ("timer", "timer-running"):
            return self._clock(target, value)
        if isinstance(target, ex.FrameRef):
            return self._frame(target, value)
        if (
            isinstance(target, ex.Variable)
            and target.store is ex.Store.ROBOT
            and isinstance(value, ex.PositionLiteral)
        ):
            return self._stored(target, value)
        if (
            isinstance(target, ex.Variable)
            and target.store is ex.Store.ROBOT
            and isinstance(value, ex.Function)
        ):
            return self._computed(target, value)
        text = self.single(target)
        if isinstance(target, ex.Variable) and target.store is ex.Store.REAL:
            if isinstance(value, ex.SignalState):
                return f"{text}={int(value.on)}"
            if isinstance(value, _BOOLEAN) and not (isinstance(value, ex.Unary) and value.operator == "-"):
                return [
                    f"IF ({self.value(value)}) THEN",
                    f"{text}=1",
                    "ELSE",
                    f"{text}=0",
                    "ENDIF",
                ]
        if isinstance(target, ex.Named) and not isinstance(value, (ex.Number, ex.Variable)):
            return f"{text}=({self.value(value)})"
        return f"{text}={self.assigned(value)}"

    def _frame(self, target: ex.FrameRef, value: ex.Expression) -> Lines:
        text = self.value(target)
        if isinstance(value, ex.Variable):
            return f"{text}={self.value(value)}"
        if value in (_FLANGE, _BASE):
            value = _NOTHING
        if isinstance(value, ex.PositionLiteral):
            register = self.scratch.register()
            return [*self.literal_lines(register, value), f"{text}=PR[{register}]"]
        raise CannotSayError("a computed frame", "compute it into a position register first")

    def _stored(self, target: ex.Variable, value: ex.PositionLiteral) -> Lines:
        plain = value.kind == "pose" and not value.configuration and not value.external
        if plain and not any(component != component for component in value.values):
            return self.literal_lines(self.index(target.index), value)
        number = self.positions.literal(value, None, None)
        return f"{self.value(target)}=P[{number}]"

    def _computed(self, target: ex.Variable, value: ex.Function) -> Lines:
        """A position register that is computed: component by component, elsewhere if these are asked for meanwhile."""
        if self._crosses(target, value):
            register = self.scratch.register()
            elsewhere = ex.Variable(ex.Store.ROBOT, ex.Number(int(register)))
            return [*self._lines_of(elsewhere, value), f"{self.value(target)}=PR[{register}]"]
        return self._lines_of(target, value)

    def _crosses(self, target: ex.Variable, value: ex.Function) -> bool:
        """Whether a component is computed from components of the register that are written before it."""
        parts = components(value)
        if parts is not None:
            return any(
                _component_of(e, target) not in (None, place)
                for place, part in enumerate(parts)
                for e in expressions_of(part)
            )
        shift = shift_of(value)
        if shift is None:
            return False
        own = [_component_of(e, target) is not None for part in shift[1] for e in expressions_of(part)]
        return any(own)

    def _lines_of(self, target: ex.Variable, value: ex.Function) -> Lines:
        index = self.index(target.index)
        parts = components(value)
        if parts is not None:
            return self.component_lines(index, parts)
        shift = shift_of(value)
        if shift is None or not is_position(shift[0]):
            raise CannotSayError(terminology.function(value.name))
        start, by = shift
        first = self.lines(st.Assign(0, target, start)) if start != target else []
        return [*first, *self.added_lines(index, by)]

    def _clock(self, clock: ex.SystemValue, value: ex.Expression) -> str:
        shown = self.named("TIMER", ex.Number(clock.index))
        if clock.name == "timer-running" and isinstance(value, (ex.SignalState, ex.Number)):
            starts = value in (ex.SignalState(True), ex.Number(1))
            return f"{shown}={'START' if starts else 'STOP'}"
        if value != ex.Number(0) or clock.name != "timer":
            raise CannotSayError("a clock that is set to another time than 0")
        return f"{shown}=RESET"

    def write_clear(self, s: st.Clear) -> Lines:
        if (
            isinstance(s.target, ex.Variable)
            and s.target.store is ex.Store.REAL
            and s.count in (None, ex.Number(1))
        ):
            return f"{self.value(s.target)}=0"
        raise CannotSayError("clearing several variables at once")

    def write_declare(self, s: st.Declare) -> Lines:
        if s.name == values.TIMEOUT:
            return []
        raise CannotSayError(f"the variable {s.name} by its name", "give it a register")

    # --- signals and time -------------------------------------------------------------------------------

    def write_set_output(self, s: st.SetOutput) -> Lines:
        text, value = self.signal(s.signal), s.value
        if s.signal.bus in ("flag", "marker"):
            return f"{text}=({self.value(value)})"
        if isinstance(value, (ex.SignalState, ex.Number, ex.Variable)):
            return f"{text}={self.single(value)}"
        return f"{text}=({self.value(value)})"

    def write_pulse_output(self, s: st.PulseOutput) -> Lines:
        time = "" if s.duration is None else f",{self.quantity(s.duration, 1.0)}sec"
        return f"{self.signal(s.signal)}=PULSE{time}"

    def write_dwell(self, s: st.Dwell) -> Lines:
        text = self.quantity(s.duration, 1.0)
        return f"WAIT {text}(sec)" if isinstance(s.duration.written, ex.Number) else f"WAIT {text}"

    # --- control flow -----------------------------------------------------------------------------------

    def write_jump(self, s: st.Jump) -> Lines:
        target = self.labels.number(s.target) if isinstance(s.target, str) else self.index(s.target)
        return f"JMP LBL[{target}]"

    def write_call(self, s: st.Call) -> Lines:
        given = s.arguments if s.result is None else (*s.arguments, self.number_of(s.result))
        self.at_most_arguments(len(given), MOST_ARGUMENTS)
        arguments = ",".join(map(self._call_argument, given))
        routine = s.routine if self.own else s.routine.upper()
        word = routine if s.spelling == "macro" and self.own else f"CALL {routine}"
        call = f"{word}({arguments})" if given else word
        return [call, "END"] if s.jump else call

    def _call_argument(self, it: ex.Expression) -> str:
        if isinstance(it, ex.SignalState):
            return str(int(it.on))
        if isinstance(it, ex.SystemValue) and not self.own:
            raise CannotSayError(f"{terminology.value(it.name)} in a call")
        return self.single(it)

    def write_if(self, s: st.If) -> str:
        return f"IF {self.condition(s.condition, 1)} THEN"

    def write_for(self, s: st.For) -> Lines:
        step = s.step.value if isinstance(s.step, ex.Number) else None
        if s.step is not None and step not in (1, -1):
            raise CannotSayError("a loop whose step is not 1 or -1")
        if not isinstance(s.variable, ex.Variable) or s.variable.store is not ex.Store.REAL:
            raise CannotSayError("a loop that counts something else than a register")
        word = "DOWNTO" if step == -1 else "TO"
        return [f"FOR {self.single(s.variable)}={self.single(s.start)} {word} {self.single(s.stop)}"]

    def write_label(self, s: st.Label) -> Lines:
        return self.labels.line(s)

    def under(self, condition: ex.Expression, lines: list[str], s: st.Statement) -> list[str]:
        if len(lines) > 1:
            return [f"IF {self.condition(condition, 1)} THEN", *lines, "ENDIF"]
        return [f"IF {self.condition(condition)},{lines[0]}"]

    def write_start_task(self, s: st.StartTask) -> Lines:
        return f"RUN {s.routine if self.own else s.routine.upper()}"

    # --- frames, process, text --------------------------------------------------------------------------

    def write_set_tool(self, s: st.SetTool) -> Lines:
        return [self.select_tool(s.tool)]

    def write_set_frame(self, s: st.SetFrame) -> Lines:
        return [self.select_frame(s.frame)]

    def write_set_override(self, s: st.SetOverride) -> Lines:
        text = self.quantity(s.share, values.PERCENT)
        return f"OVERRIDE={text}%" if isinstance(s.share.written, ex.Number) else f"OVERRIDE={text}"

    def write_message(self, s: st.Message) -> Lines:
        if not isinstance(s.text, ex.Text):
            raise CannotSayError("a message that is computed")
        if not _LINE_ENDS.isdisjoint(s.text.value):
            raise CannotSayError("a message of several lines")
        return f"MESSAGE[{s.text.value}]"

    def write_process(self, s: st.Process) -> Lines:
        if s.name == f"{BLOCK} END":
            return _BLOCK_END
        arguments = [value for _, value in s.arguments]
        if s.name == "TIMER":
            timer, word = arguments
            assert isinstance(word, ex.Text)
            return f"{self.named('TIMER', timer)}={word.value}"
        if s.name == "CALL":
            routine, *rest = map(self.value, arguments)
            return f"CALL {routine}({','.join(rest)})" if rest else f"CALL {routine}"
        if s.name.endswith("CONDITION"):
            condition = arguments[0]
            value = (
                self.single(condition) if isinstance(condition, ex.Variable) else self.condition(condition)
            )
            return f"{s.name} {value}"
        text = "".join(value.value for value in arguments if isinstance(value, ex.Text))
        return [f"{s.name}{'' if text[:1] in '[=' else ' '}{text}".rstrip()]

    def write_comment(self, s: st.Comment) -> Lines:
        if self.own:
            return [s.text if s.text.startswith("--eg:") else f"!{s.text}"]
        return _comment_lines(s.text)

    # --- instructions of several statements -------------------------------------------------------------

    def together(self, body: Sequence[st.Statement], place: int) -> Joined | None:
        one, following = body[place], body[place + 1 : place + 3]
        if isinstance(one, st.Wait) and one.timeout is not None:
            lines, taken = self._timed_wait(one, following[0] if following else None)
        elif isinstance(one, st.Switch):
            lines, taken = self._cases(body, place)
        elif isinstance(one, st.If) and one.spelling == "one line" and len(following) == 2:
            if type(following[1]) is not st.EndIf:
                return None
            lines, taken = self._one_line(one, following[0]), 3
        else:
            return None
        return Joined(lines, taken, one.comment)

    def _one_line(self, condition: st.If, action: st.Statement) -> list[str]:
        (text,) = self.lines(action)
        if not isinstance(action, (st.Assign, st.SetOutput)) and not text.startswith(
            ("JMP", "CALL", "RUN", "WAIT")
        ):
            return [self.write_if(condition), text, "ENDIF"]
        return [f"IF {self.condition(condition.condition, 1)},{text}"]

    def _timed_wait(self, wait: st.Wait, following: st.Statement | None) -> tuple[list[str], int]:
        """WAIT … TIMEOUT,LBL[n]: goes to the label that the jump behind it names, or to one that comes next."""
        assert wait.timeout is not None
        lines = self._timeout(wait.timeout)
        text = f"WAIT {self.condition(wait.condition)} TIMEOUT,"
        if (
            isinstance(following, st.Jump)
            and following.condition == _TIMED_OUT
            and isinstance(following.target, str)
        ):
            return [*lines, f"{text}LBL[{self.labels.number(following.target)}]"], 2
        label = self.labels.added()
        return [*lines, f"{text}LBL[{label}]", f"LBL[{label}]"], 1

    def _timeout(self, timeout: ex.Quantity) -> list[str]:
        """The line that sets $WAITTMOUT, where it does not hold already."""
        if not isinstance(timeout.written, ex.Number):
            named = getattr(timeout.written, "name", "")
            if named == values.TIMEOUT:
                return []
            scale = timeout.scale / values.TICK
            return [f"{values.TIMEOUT}=({self.value(timeout.written, 5)}*{scale:g})"]
        ticks = round(timeout.written.value * timeout.scale / values.TICK)
        return [f"{values.TIMEOUT}={ticks}"]

    def _cases(self, body: Sequence[st.Statement], at: int) -> tuple[list[str], int]:
        """SELECT at index `at`, whose cases jump or call. Raises CannotSayError for cases that do more."""
        switch = body[at]
        assert isinstance(switch, st.Switch)
        end = next((n for n in range(at, len(body)) if type(body[n]) is st.EndSwitch), len(body) - 1)
        lines: list[str] = []
        part = at + 1
        while part < end:
            case = body[part]
            action = body[part + 1]
            (text,) = self.lines(action) if isinstance(action, (st.Jump, st.Call)) else ("",)
            if not text or not isinstance(case, (st.Case, st.Default)) or text.startswith("IF"):
                raise CannotSayError("a SELECT whose cases do more than a jump or a call", "use IF blocks")
            lines.extend(self._case_lines(switch, case, text, not lines))
            part += 2
        return lines, end - at + 1

    def _case_lines(
        self, switch: st.Switch, case: st.Case | st.Default, action: str, first: bool
    ) -> Iterator[str]:
        if isinstance(case, st.Default):
            yield f"       ELSE,{action}"
            return
        for value in case.values:
            head = f"SELECT {self.single(switch.value)}" if first else "      "
            yield f"{head}={self.single(value)},{action}"
            first = False

    # --- bodies -----------------------------------------------------------------------------------------

    def add(self, s: st.Statement, lines: list[str]) -> None:
        if self.own and isinstance(s, st.Label):
            self.rows += lines  # its comment is its name
        else:
            super().add(s, lines)

    def put(self, lines: list[str], comment: str = "") -> None:
        """Comments stand before what they belong to."""
        if comment:
            self.rows += _comment_lines(comment)
        self.rows += lines

    def template_values(self) -> dict[str, object]:
        return {"listings": tuple(map(self._listing, self.program.routines))}

    def _listing(self, routine: st.Routine) -> TpListingText:
        self.details = routine.details if self.own else _point_names(routine)
        self.positions = TpPositionWriter(routine.points, self.details, self.own)
        self.names, self.points = self.details, routine.points
        self.labels = Labels(routine, self.own)
        self.begin()
        if not self.own and len(routine.comment) > NAME_LENGTH:  # the header holds its beginning
            self.put(_comment_lines(routine.comment))
        self.body(routine.body)
        instructions, count = _numbered_lines(self.rows)
        positions: list[str] = []
        try:
            positions = list(self.positions.lines())
        except CannotSayError as problem:
            self.lose(problem, routine.line)
        get = self._attribute
        made = _dated(self.date)
        return TpListingText(
            name=routine.name if self.own else routine.name.upper(),
            kind=self.details.get("/PROG", ""),
            owner=get("OWNER", "MNEDITOR"),
            comment=f'"{self._header_comment(routine)}"',
            created=get("CREATE", made),
            modified=get("MODIFIED", made),
            file_name=get("FILE_NAME", ""),
            version=get("VERSION", "0"),
            protect=get("PROTECT", "READ_WRITE"),
            stack_size=get("STACK_SIZE", "0"),
            task_priority=get("TASK_PRIORITY", "50"),
            time_slice=get("TIME_SLICE", "0"),
            busy_lamp_off=get("BUSY_LAMP_OFF", "0"),
            abort_request=get("ABORT_REQUEST", "0"),
            pause_request=get("PAUSE_REQUEST", "0"),
            default_group=get("DEFAULT_GROUP", "1,*,*,*,*"),
            control_code=get("CONTROL_CODE", "00000000 00000000"),
            local_registers=get("LOCAL_REGISTERS", ""),
            application=as_text(filter(None, self.details.get("/APPL", "").split("\n"))),
            line_count=count,
            instructions=as_text(instructions),
            positions=as_text(positions),
        )

    def _header_comment(self, routine: st.Routine) -> str:
        comment = routine.comment or self._origin()
        return comment if self.own else comment[:NAME_LENGTH].rstrip()

    def _origin(self) -> str:
        """What the program was called that a translation was made from, where its routine has no comment."""
        name = PureWindowsPath(self.program.path.replace("/", "\\")).stem
        return "" if self.own or not name.isascii() else name[:NAME_LENGTH]

    def _attribute(self, name: str, usual: str) -> str:
        return self.details.get(f"/ATTR {name}", usual)


def _numbered_lines(rows: list[str]) -> tuple[list[str], int]:
    """The instructions with their numbers, and how many they are; those of a P-SPS block count on their own."""
    lines: list[str] = []
    count = inside = 0
    for text in rows:
        if text == _BLOCK_END:
            inside = 0
            lines.append("       ------ ;")
            continue
        if inside:
            head, inside = f"   {inside:4}:  ", inside + 1
        else:
            count += 1
            head = f"{count:4}:" if text[:2] in _MOTIONS else f"{count:4}:  "
        first, _, second = text.partition("\n")
        lines.append(f"{head}{first}" if second else f"{head}{first} ;")
        if second:
            lines.append(f"    :  {second} ;")
        if BLOCK in text and text[:2] in _MOTIONS:
            inside = 1
    return lines, count


class Labels:
    """A number for every label of a routine; those that are numbers keep theirs."""

    def __init__(self, routine: st.Routine, own: bool) -> None:
        self._own = own
        self._numbers = _numbered(routine)

    def number(self, name: str) -> str:
        """As JMP LBL[…] names it."""
        number = self._numbers.get(name)
        return name.split("/")[0] if number is None else str(number)

    def line(self, label: st.Label) -> str:
        """LBL[3:name]: a name of another language becomes the comment."""
        name = label.comment if self._own else "" if label.name.isdigit() else label.name[:NAME_LENGTH]
        return f"LBL[{self.number(label.name)}{f':{name}' if name else ''}]"

    def added(self) -> str:
        """The number of a further label."""
        taken = set(self._numbers.values())
        number = next(n for n in range(_FIRST_ADDED, LARGEST_LABEL) if n not in taken)
        self._numbers[f"added {number}"] = number
        return str(number)


def _numbered(routine: st.Routine) -> dict[str, int]:
    """A number for every label of the routine; those that are numbers keep theirs."""
    names = [one.name for one in routine.body if type(one) is st.Label]
    numbers = {name: int(name.split("/")[0]) for name in names if name.split("/")[0].isdigit()}
    taken = set(numbers.values())
    following = 1
    for name in names:
        if name not in numbers:
            while following in taken:
                following += 1
            numbers[name] = following
            taken.add(following)
    return numbers


def _point_names(routine: st.Routine) -> dict[str, str]:
    """What another language calls the points, as far as a comment holds it; and the units of external axes."""
    units = {key: unit for key, unit in routine.details.items() if key.startswith("unit ")}
    names = {p: name[:NAME_LENGTH] for p, name in routine.details.items() if p.startswith("P[")}
    return {**names, **units}


def _comment_lines(text: str) -> list[str]:
    """A comment in lines that the controller keeps whole."""
    if len(text) <= COMMENT_LENGTH:
        return [f"!{text}"]
    from textwrap import wrap

    return [f"!{part}" for part in wrap(text, COMMENT_LENGTH)]


def _dated(date: str) -> str:
    """YYYY/MM/DD HH:MM as a listing writes it."""
    match = _DATE.fullmatch(date)
    return (
        f"DATE {match[2]}-{match[3]}-{match[4]}  TIME {match[5]}:00"
        if match
        else "DATE 00-01-01  TIME 00:00:00"
    )
