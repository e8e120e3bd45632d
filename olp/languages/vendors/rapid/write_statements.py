"""Writes statements and bodies of routines: the way back of `statements`."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from textwrap import wrap
from typing import ClassVar, Final

from olp.core.units import mm, percent
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.transformer import changed_by
from olp.languages.generator import BRANCHES, CLOSES, CannotSayError, Joined, Lines
from olp.languages.vendors.rapid.limits import LIMITS, LONGEST_TEXT
from olp.languages.vendors.rapid.literals import quoted, zero
from olp.languages.vendors.rapid.names import RapidNames
from olp.languages.vendors.rapid.predefined_data import SIGNAL_TYPES
from olp.languages.vendors.rapid.statements import COMPACT
from olp.languages.vendors.rapid.write_moves import RapidMoves
from olp.languages.vendors.rapid.write_values import FRAMES, TIMED_OUT

_NATIVE: Final = {
    "real": "num", "integer": "num", "boolean": "bool", "string": "string", "character": "string",
    "position": "robtarget", "joints": "jointtarget", "tool": "tooldata", "frame": "wobjdata", "speed": "speeddata",
    "zone": "zonedata", "signal": "signaldo", **{f"signal {bus}": word for word, bus in SIGNAL_TYPES.items()},
}  # fmt: skip
_STORAGE: Final = {"constant": "CONST", "persistent": "PERS", "variable": "VAR"}
_SWITCHING: Final = ("MoveL", "MoveJ", "MoveC")  # and then DO
_SIGNAL_WORDS: Final = {
    "in": "WaitDI", "out": "WaitDO", "in-group": "WaitGI", "out-group": "WaitGO", "analog-in": "WaitAI",
    "analog-out": "WaitAO",
}  # fmt: skip
_COMPARED: Final = {"=": "", "<": "\\LT,", ">": "\\GT,", "<>": "\\NotEq,"}
_POSES: Final = ("robtarget", "pose")
_RADII: Final = ("x", "y", "z")
_ANGLES: Final = ("rx", "ry", "rz")
_LESS_EXACT: Final = (
    st.SetAcceleration,
    st.SetOverride,
    st.ObeyFlags,
    st.ShiftOn,
)  # a Disabled beside them says all
_HANDLER: Final = re.compile(r"(ERROR|UNDO|BACKWARD)\b", re.IGNORECASE)
_HANDLER_OPENS: Final = re.compile(
    r"(?:(?:ELSE)?IF\b.*\bTHEN|ELSE|(?:FOR|WHILE)\b.*\bDO|TEST\b.*)\s*(?:!.*)?", re.IGNORECASE
)
_HANDLER_CLOSES: Final = re.compile(r"(?:ELSE(?:IF)?|END(?:IF|FOR|WHILE|TEST))\b", re.IGNORECASE)
_FULL: Final = 1.0  # the acceleration of moves that name none
_NO_RETURN: Final = "a call that does not come back, or of a macro"


def native_type(s: st.Declare, own: bool) -> str:
    """RAPID's type of a declaration, lower case; of another language's (`own` False) the one that fits."""
    word = (s.native.split() or [""])[-1].lower()
    return word if own and word else _NATIVE.get(s.type, s.type)


class RapidStatements(RapidMoves):
    """Writes statements. `returns`: the type of the function that is written."""

    templates: ClassVar = {
        st.Dwell: "WaitTime {duration};",
        st.If: "IF {condition} THEN",
        st.ElseIf: "ELSEIF {condition} THEN",
        st.Else: "ELSE",
        st.EndIf: "ENDIF",
        st.While: "WHILE {condition} DO",
        st.EndWhile: "ENDWHILE",
        st.Next: "ENDFOR",
        st.Switch: "TEST {value}",
        st.Case: "CASE {values}:",
        st.Default: "DEFAULT:",
        st.EndSwitch: "ENDTEST",
        st.Label: "{name}:",
        st.ShiftOff: "PDispOff;",
    }
    fields: ClassVar = {"signal": "value"}
    cannot: ClassVar = {
        st.Call: {"macro": _NO_RETURN, "jump": _NO_RETURN},
        st.ShiftOn: dict.fromkeys(("frame", "coordinated"), "a shift in a frame of its own"),
    }
    own_only: ClassVar = {
        st.Opaque: "an instruction of another language that olp does not know",
    }
    step = "  "
    first_depth = 2
    least_depth = 1
    comment_form = " !{}"
    forgets = CLOSES | BRANCHES | {st.If, st.While, st.For, st.Label, st.Call}
    joins = frozenset(
        {st.Move, st.If, st.Wait, st.Assign, st.SetAcceleration, st.SetOverride, st.ObeyFlags, st.ShiftOn}
    )

    def __init__(self, program: st.Program, types: Mapping[str, str], names: RapidNames) -> None:
        super().__init__(program, types, names)
        self.returns = ""
        self._changed: set[str] | None = None  # names that a statement may give another value, lower case
        self._rate: float | None = None  # what AccSet has set, None: not known here
        # Where no move names an acceleration, none is ever set.
        self._rated = any(isinstance(s, st.Move) and s.acceleration is not None for s in program.statements())

    # --- data -------------------------------------------------------------------------------------------------

    def declared_as(self, s: st.Declare, *, module: bool = False) -> str:
        """`CONST robtarget p:=…;`"""
        written = native_type(s, self.own) if self.own else self.types[s.name.lower()]
        if not written:
            raise CannotSayError(f"a variable whose type nothing tells ({s.name})")
        kind = self.names.resolved(written)
        storage = _STORAGE.get(s.storage, "VAR")
        if storage == "VAR" and not self.own and self._is_taught(s):
            storage = "CONST"
        if kind in ("tooldata", "wobjdata") and not self.own:
            storage = "PERS"
        if s.value is None and storage == "CONST":
            storage = "VAR"
        task = self.own and s.native.upper().startswith("TASK ")
        scope = "TASK " if task else "LOCAL " if module and not s.shared else ""
        word = s.native.split()[-1] if self.own and s.native else written
        sizes = f"{{{','.join(map(self.value, s.sizes))}}}" if s.sizes else ""
        begins = s.value
        if begins is None and not self.own and not s.comment and (storage == "PERS" or s.sizes):
            # A PERS has a value; positions that begin without one have no turning, and no move takes them. What the
            # source does not declare has none on purpose, and a comment that says so.
            # Of a tool or a frame that is its place: all members zero would be a tool that the robot does not hold.
            shape = "pose" if kind in FRAMES else kind
            begins = zero(shape, self.names, s.sizes, plain=storage == "PERS")
        unset = storage == "VAR" and self.own and s.value == zero(kind, self.names, s.sizes)
        value = "" if begins is None or unset else f":={self._initial(begins, kind)}"
        return f"{scope}{storage} {word} {s.name}{sizes}{value};"

    def _is_taught(self, s: st.Declare) -> bool:
        """A point that no statement changes: what ModPos makes of a VAR is lost with the next start."""
        if s.type not in ("position", "joints") or type(s.value) is not ex.PositionLiteral or s.sizes:
            return False
        if self._changed is None:
            self._changed = {name.lower() for one in self.program.statements() for name in changed_by(one)}
        return s.name.lower() not in self._changed

    def _initial(self, value: ex.Expression, kind: str) -> str:
        if kind in ("num", "string") and isinstance(value, ex.SignalState):
            return "1" if value.on else "0"
        return self.typed(value, kind)

    def write_assign(self, s: st.Assign) -> Lines:
        target, value = s.target, s.value
        if isinstance(target, ex.Member) and target.name in _ANGLES:
            return self._turned(target, value)
        if isinstance(target, ex.Signal):
            raise CannotSayError("a signal that is assigned to")
        if isinstance(target, ex.Function) and target.name in ("timer", "timer-running"):
            return self._clock(target, value)
        kind = self.type_of(target)
        if kind.startswith("signal"):
            return f"AliasIO {self.value(value)},{self.value(target)};"
        partly = self._partly(target, value, kind)
        if partly is not None:
            return partly
        given = self.type_of(value)
        if kind in FRAMES and (
            isinstance(value, (ex.Function, ex.SystemValue))
            or given in _POSES
            or (given in FRAMES and given != kind)
        ):
            return f"{self.value(target)}.{FRAMES[kind]}:={self.as_pose(value)};"
        name = self.value(target)
        if kind == "robtarget":
            return f"{name}:={self.as_robtarget(value)};"
        return f"{name}:={self.typed(value, kind if _is_structure(value) or kind == 'orient' else '')};"

    def _clock(self, clock: ex.Function, value: ex.Expression) -> str:
        if clock.name == "timer-running" and isinstance(value, ex.SignalState):
            return f"{'ClkStart' if value.on else 'ClkStop'} {self.arguments(clock.arguments)};"
        if clock.name == "timer-running" or value != ex.Number(0):
            raise CannotSayError("a clock that is set to another time than 0")
        return f"ClkReset {self.arguments(clock.arguments)};"

    def _partly(self, target: ex.Expression, value: ex.Expression, kind: str) -> str | None:
        """A pose that keeps its place or its turn is assigned in part."""
        if (
            kind == "jointtarget"
            and isinstance(value, ex.Function)
            and value.name == "joints"
            and len(value.arguments) <= 6
        ):
            return f"{self.value(target)}.robax:={self.robjoint_text(value.arguments)};"
        if not isinstance(value, ex.Function) or kind not in (*_POSES, *FRAMES, ""):
            return None
        place = tuple(ex.Member(target, name) for name in _RADII)
        turn = tuple(ex.Member(target, name) for name in _ANGLES)
        if value.name == "pose-angles" and value.arguments[:3] == place:
            return f"{self.turn(target)}:={self.turn_text(value.arguments[3:6])};"
        if value.name == "pose-angles" and value.arguments[3:6] == turn:
            return f"{self.place(target)}:={self.place_text(value.arguments[:3])};"
        if value.name == "pose-quaternion" and value.arguments[:3] == place:
            return f"{self.turn(target)}:=[{','.join(map(self.value, value.arguments[3:7]))}];"
        return None

    def _turned(self, target: ex.Member, value: ex.Expression) -> str:
        """One angle of a position: the quaternion is made anew of all three."""
        angles = {name: self.value(ex.Member(target.base, name)) for name in _ANGLES}
        angles[target.name] = self.value(value)
        return f"{self.turn(target.base)}:=OrientZYX({angles['rz']},{angles['ry']},{angles['rx']});"

    def write_update(self, s: st.Update) -> Lines:
        """RAPID's own alone: of other languages they are assignments."""
        assert s.operand is not None
        target = self.value(s.target)
        if s.operand == ex.Number(1):
            return f"{'Incr' if s.operator == '+' else 'Decr'} {target};"
        return f"Add {target},{self.value(s.operand)};"

    def write_clear(self, s: st.Clear) -> Lines:
        if s.target is None or s.count not in (None, ex.Number(1)):
            raise CannotSayError("many variables that are cleared at once")
        return f"{self.value(s.target)}:=0;"

    # --- signals ----------------------------------------------------------------------------------------------

    def write_set_output(self, s: st.SetOutput) -> Lines:
        signal = self.signal(s.signal)
        if not self.is_digital(s.signal):
            word = "SetAO" if s.signal.bus.startswith("analog") else "SetGO"
            return f"{word} {signal},{self.value(s.value)};"
        match s.value:
            case ex.SignalState(on):
                return f"SetDO {signal},{int(on)};"
            case ex.Unary("not", operand) if operand == s.signal:
                return f"InvertDO {signal};"
            case ex.Compare() | ex.Logic() | ex.Unary("not", _):
                pass
            case ex.Named(name) if self.types.get(name.lower()) == "bool":
                pass
            case ex.CallValue(name) if not self.own and self._is_boolean(name):
                pass
            case _:
                return f"SetDO {signal},{self.value(s.value)};"
        condition = self.condition(s.value)
        return [
            f"IF {condition} THEN",
            f"{self.step}SetDO {signal},1;",
            "ELSE",
            f"{self.step}SetDO {signal},0;",
            "ENDIF",
        ]

    def _is_boolean(self, name: str) -> bool:
        """Whether a routine of the program returns TRUE or FALSE."""
        return any(r.returns == "boolean" and r.name.lower() == name.lower() for r in self.program.routines)

    def write_pulse_output(self, s: st.PulseOutput) -> Lines:
        high = "\\High" if s.spelling == "High" or not self.own else ""
        length = "" if s.duration is None else f"\\PLength:={self.seconds(s.duration)}"
        comma = "," if high or length else ""
        return f"PulseDO {high}{length}{comma}{self.signal(s.signal)};"

    # --- waits ------------------------------------------------------------------------------------------------

    def write_wait(self, s: st.Wait) -> Lines:
        return self._wait(s)

    def _wait(self, s: st.Wait, flag: ex.Expression | None = None) -> str:
        """`flag`: the variable that says whether the time was out."""
        limit = ""
        if s.timeout is not None:
            limit = f"\\MaxTime:={self.seconds(s.timeout)}"
            if flag is not None:
                limit += f"\\TimeFlag:={self.value(flag)}"
            elif not self.own:
                self.timed_out = True
                limit += f"\\TimeFlag:={TIMED_OUT}"
        match s.condition:
            case ex.Compare(operator, ex.Signal(bus, _) as signal, value) if self._waits_for(
                bus, operator, s.spelling
            ):
                wanted = str(int(value.on)) if isinstance(value, ex.SignalState) else self.value(value)
                name = self.signal(signal)
                return f"{_SIGNAL_WORDS[bus]} {name},{_COMPARED[operator]}{wanted}{limit};"
            case ex.Signal(bus, _) as signal if bus in ("in", "out"):
                return f"{_SIGNAL_WORDS[bus]} {self.signal(signal)},1{limit};"
        return f"WaitUntil {self.condition(s.condition)}{limit};"

    def _waits_for(self, bus: str, operator: str, spelling: str) -> bool:
        analog = bus.startswith("analog")
        fits = bus in _SIGNAL_WORDS and (
            operator in ("<", ">") if analog else operator == "=" or bus.endswith("group")
        )
        return fits and operator in _COMPARED and spelling != "WaitUntil"

    # --- flow -------------------------------------------------------------------------------------------------

    def write_for(self, s: st.For) -> Lines:
        if not isinstance(s.variable, ex.Named):
            raise CannotSayError("a loop over a numbered variable")
        step = "" if s.step is None else f" STEP {self.value(s.step)}"
        if s.step is None and not self.own and not _counts_up(s):
            step = " STEP 1"  # without it the loop counts down where it ends below its begin
        return f"FOR {s.variable.name} FROM {self.value(s.start)} TO {self.value(s.stop)}{step} DO"

    def under(self, condition: ex.Expression, lines: list[str], s: st.Statement) -> list[str]:
        return [f"IF {self.condition(condition)} {lines[0]}"]

    def write_jump(self, s: st.Jump) -> Lines:
        if not isinstance(s.target, str):
            raise CannotSayError("a jump to a computed label")
        return f"GOTO {s.target};"

    def write_call(self, s: st.Call) -> Lines:
        if not s.routine:
            raise CannotSayError(_NO_RETURN)
        arguments = self.arguments(s.arguments)
        if s.result is not None:
            return f"{self.value(s.result)}:={s.routine}({arguments});"
        name = f"%{quoted(s.routine)}%" if s.spelling == "%" and self.own else s.routine
        return f"{name} {arguments};" if arguments else f"{name};"

    def write_return(self, s: st.Return) -> Lines:
        if s.spelling == "EXIT" and self.own:
            return "EXIT;"
        if s.value is None:
            return "RETURN;"
        if self.returns == "robtarget" and not self.own:
            return f"RETURN {self.as_robtarget(s.value)};"
        return f"RETURN {self.typed(s.value, self.returns)};"

    def write_pause(self, s: st.Pause) -> Lines:
        return "Break;" if s.spelling == "Break" and self.own else "Stop;"

    # --- settings, messages, the rest ---------------------------------------------------------------------------

    def write_set_acceleration(self, s: st.SetAcceleration) -> Lines:
        if len(s.rates) != 1 or s.rates[0].unit is not st.AccelerationUnit.FRACTION or s.path is not None:
            raise CannotSayError("accelerations other than a share of the rated one")
        return f"AccSet {self.quantity(s.rates[0].value, percent)},100;"

    def write_set_override(self, s: st.SetOverride) -> Lines:
        fastest = "5000" if s.fastest is None else self.quantity(s.fastest, mm)
        return f"VelSet {self.quantity(s.share, percent)},{fastest};"

    def write_shift_on(self, s: st.ShiftOn) -> Lines:
        return f"PDispSet {self.as_pose(s.offset)};"

    def write_message(self, s: st.Message) -> Lines:
        match s.text:
            case ex.Function("joined-text", (ex.Text() as text, ex.Function("text-of-value", (value,)))) if (
                option := self._shown_as(value)
            ):
                return f"TPWrite {self.value(text)}\\{option}:={self.value(value)};"
            case ex.Text(text) if len(text) > LONGEST_TEXT and not self.own:
                return [f"TPWrite {quoted(part)};" for part in wrap(text, LONGEST_TEXT)]
        return f"TPWrite {self.value(s.text)};"

    def _shown_as(self, value: ex.Expression) -> str:
        """The option of TPWrite that shows a value, "" where only its text can be shown."""
        if isinstance(value, (ex.Compare, ex.Logic)) or self.type_of(value) == "bool":
            return "Bool"
        return "Num" if type(value) is not ex.Named or self.own or self.type_of(value) == "num" else ""

    def write_process(self, s: st.Process) -> Lines:
        if not self.own and s.name == LIMITS.stand:
            return f"{s.name}\\InPos;"
        if not self.own and s.name != LIMITS.program_end:
            return self._trap_word(s)
        texts = [value.value for _, value in s.arguments if isinstance(value, ex.Text)]
        raw = texts[0] if texts else ""
        if s.name in ("interrupt", "call", "robconf"):
            return f"{raw};"
        return f"{s.name} {raw};" if raw else f"{s.name};"

    def _trap_word(self, s: st.Process) -> Lines:
        """`ISignalDI di5,1,watch_20;`: what connects a routine with a signal, and the arm's stop in it."""
        if LIMITS.traps is None or s.name not in LIMITS.traps.words():
            raise CannotSayError(f"{s.name}, an instruction of another language")
        trap = dict(s.arguments).get("trap")
        given = ",".join(self.value(value) for tag, value in s.arguments if not tag)
        behind = f" WITH {trap.value}" if isinstance(trap, ex.Text) else ""
        return f"{s.name} {given}{behind};" if given else f"{s.name};"

    def write_disabled(self, s: st.Disabled) -> Lines:
        return s.text if self.own else f"! {s.text.strip()}"

    def write_declare(self, s: st.Declare) -> Lines:
        return self.declared_as(s)

    def write_obey_flags(self, s: st.ObeyFlags) -> Lines:
        return "ConfJ \\On;" if s.on else "ConfJ \\Off;"

    def write_comment(self, s: st.Comment) -> Lines:
        return f"!{s.text}" if self.own or s.text[:1] == " " else f"! {s.text}"

    # --- bodies -----------------------------------------------------------------------------------------------

    def routine_rows(
        self, body: Sequence[st.Statement], routine: st.Routine, opening: list[str]
    ) -> list[str]:
        """The body's lines with their indent; `opening`: instructions that stand behind its declarations."""
        self.begin()
        self._rate = _FULL if routine.name == self.program.main else None
        place = "robtarget" if routine.returns == "position" else ""
        self.returns = routine.details.get("returns", "") if self.own else place
        if not self.own:
            body = self._declarations_first(body)
        declared = _declarations(body)
        self.body(body[:declared])
        if declared < len(body):
            self.put(opening)
        self.body(body[declared:])
        return self.rows

    def forget(self) -> None:
        self._rate = None

    def write_move(self, s: st.Move) -> Lines:
        return [*self._accelerated(s), self.move(s)]

    def _accelerated(self, move: st.Move) -> list[str]:
        """AccSet before a move of another language whose acceleration differs from what holds."""
        if self.own:
            return []
        rate = _FULL if move.acceleration is None else move.acceleration.literal
        if rate is None:
            self._rate = None
            assert move.acceleration is not None
            return [f"AccSet {self.quantity(move.acceleration, percent)},100;"]
        if rate == self._rate or not self._rated:
            return []
        self._rate = rate
        return [f"AccSet {self.quantity(ex.Quantity(ex.Number(rate), 1.0), percent)},100;"]

    def _declarations_first(self, body: Sequence[st.Statement]) -> list[st.Statement]:
        """RAPID declares before the first instruction: later ones become a declaration there and an assignment."""
        first = next(
            (n for n, one in enumerate(body) if not isinstance(one, (st.Declare, st.Comment, st.Begin))),
            len(body),
        )
        declared: list[st.Statement] = []
        rest: list[st.Statement] = []
        for one in body[first:]:
            if not isinstance(one, st.Declare):
                rest.append(one)
                continue
            declared.append(replace(one, value=None, storage="variable", comment=""))
            if one.value is not None:
                rest.append(st.Assign(one.line, ex.Named(one.name), one.value, one.comment))
        return [*body[:first], *declared, *rest]

    def together(self, body: Sequence[st.Statement], place: int) -> Joined | None:
        one, last = body[place], place
        if isinstance(one, st.Move):
            return self._switching(one, body[place + 1]) if place + 1 < len(body) and not self.own else None
        if isinstance(one, st.If):
            if one.spelling == COMPACT and self.own:
                last = _end_of_compact(body, place)
            lines = self._compact(one, body[place + 1 : last]) if last > place else None
        else:
            lines, last = self._paired(body, place), place + 1
        if lines is None:
            return None
        comment = getattr(body[last], "comment", "") or getattr(one, "comment", "")
        return Joined(lines, last - place + 1, comment)

    def _switching(self, move: st.Move, following: st.Statement) -> Joined | None:
        """MoveLDO: an output that is set in the corner at the move's end, which nothing may stop."""
        if type(following) is not st.SetOutput or following.signal.bus != "out" or move.no_wait:
            return None
        size = None if move.blend is None or move.blend.value is None else move.blend.value.literal
        if not size or not isinstance(following.value, ex.SignalState):
            return None
        *before, text = self.lines(move)
        word, _, arguments = text.partition(" ")
        if word not in _SWITCHING:
            return None
        comments = ", ".join(one.strip() for one in (move.comment, following.comment) if one)
        said = f"{arguments.removesuffix(';')},{self.signal(following.signal)},{int(following.value.on)};"
        return Joined([*before, f"{word}DO {said}"], 2, f" {comments}" if comments else "")

    def _paired(self, body: Sequence[st.Statement], place: int) -> list[str] | None:
        """The instruction that two statements of one line are."""
        one, following = body[place], body[place + 1] if place + 1 < len(body) else None
        if following is None or following.line != one.line:
            return None
        if self.own and isinstance(one, _LESS_EXACT) and isinstance(following, st.Disabled):
            return self.lines(following)
        if isinstance(one, st.Assign) and isinstance(following, st.Assign):
            return self._reset(one, following)
        timed = isinstance(following, st.Assign) and following.value == ex.SystemValue("timed-out")
        if isinstance(one, st.Wait) and isinstance(following, st.Assign) and timed:
            return [self._wait(one, following.target)]
        return None

    def _reset(self, stopped: st.Assign, zeroed: st.Assign) -> list[str] | None:
        """ClkReset: a clock that stops and is set to 0."""
        match stopped.target, stopped.value, zeroed.target, zeroed.value:
            case (
                ex.Function("timer-running", clock),
                ex.SignalState(False),
                ex.Function("timer", same),
                ex.Number(0),
            ) if clock == same:
                return [f"ClkReset {self.arguments(clock)};"]
        return None

    def _compact(self, opener: st.If, inner: Sequence[st.Statement]) -> list[str]:
        """IF without THEN."""
        paired = self._paired(inner, 0) if len(inner) == 2 else None
        found = paired or (self.lines(inner[0]) if len(inner) == 1 else [])
        if len(found) != 1:
            # Two statements of one instruction, such as WaitTime \\InPos: written as a block.
            rest = [row for one in inner for row in self.lines(one)]
            return [f"IF {self.condition(opener.condition)} THEN", *rest, "ENDIF"]
        return [f"IF {self.condition(opener.condition)} {found[0]}"]

    def add(self, s: st.Statement, lines: list[str]) -> None:
        if isinstance(s, st.Disabled) and self.own:
            self._kept(s)
            return
        out = isinstance(s, st.Label) and self.depth > self.least_depth
        self.depth -= out
        super().add(s, lines)
        self.depth += out

    def put(self, lines: list[str], comment: str = "") -> None:
        """Behind what has to stand before it."""
        start = len(self.rows)
        super().put([*self.before, *lines], comment)
        self.rows[start:] = [row.rstrip() for row in self.rows[start:]]
        self.before.clear()
        self.under_way.clear()

    def lose(self, problem: CannotSayError, line: int) -> None:
        self.before.clear()
        self.under_way.clear()
        super().lose(problem, line)

    def _kept(self, one: st.Disabled) -> None:
        """A line of a handler, or an instruction without effect."""
        handler = _HANDLER.match(one.text)
        if handler is not None:
            self.depth = 2
        if _HANDLER_CLOSES.match(one.text):
            self.depth -= 1
        self.rows.append(f"{self.step * max(self.depth - (handler is not None), 1)}{one.text}")
        if _HANDLER_OPENS.fullmatch(one.text):
            self.depth += 1


def _is_structure(value: ex.Expression) -> bool:
    return isinstance(value, (ex.PositionLiteral, ex.RecordLiteral, ex.Function))


def _declarations(body: Sequence[st.Statement]) -> int:
    """Where the declarations at a body's beginning end."""
    last = 0
    for place, one in enumerate(body):
        if isinstance(one, st.Declare):
            last = place + 1
        elif not isinstance(one, (st.Comment, st.Begin)):
            break
    return last


def _counts_up(s: st.For) -> bool:
    """Whether a loop is written out that ends at its begin or above it."""
    return isinstance(s.start, ex.Number) and isinstance(s.stop, ex.Number) and s.start.value <= s.stop.value


def _end_of_compact(body: Sequence[st.Statement], place: int) -> int:
    """The EndIf of an IF without THEN: in the same line."""
    line = body[place].line
    for index in range(place + 1, min(place + 6, len(body))):
        if body[index].line != line:
            break
        if isinstance(body[index], st.EndIf):
            return index
    return place
