"""Spells every statement that is no motion: one short method per type, the way back of `statements`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from olp import called
from olp.expression import (
    Compare,
    Expression,
    Function,
    Logic,
    Member,
    Named,
    Number,
    PositionLiteral,
    RecordLiteral,
    Signal,
    State,
    SystemValue,
    Text,
    Unary,
)
from olp.program import (
    AccelerationUnit,
    Assign,
    Call,
    Case,
    Clear,
    Comment,
    Declare,
    Default,
    Disabled,
    Dwell,
    Else,
    ElseIf,
    EndIf,
    EndSwitch,
    EndWhile,
    For,
    If,
    Jump,
    Label,
    Message,
    Next,
    ObeyFlags,
    Opaque,
    Pause,
    Process,
    PulseOutput,
    ReadInput,
    Return,
    SetAcceleration,
    SetOutput,
    SetOverride,
    ShiftOff,
    ShiftOn,
    Statement,
    Switch,
    Update,
    Wait,
    While,
)
from olp.units import percent
from olp.vendors.rapid.literals import zero
from olp.vendors.rapid.texts import quoted
from olp.vendors.rapid.write_functions import place_text, robjoint_text, turn_text
from olp.vendors.rapid.write_positions import CannotSayError
from olp.vendors.rapid.write_values import TIMED_OUT, Words

_NATIVE: Final = {
    "real": "num", "integer": "num", "boolean": "bool", "string": "string", "character": "string",
    "position": "robtarget", "joints": "jointtarget", "tool": "tooldata", "frame": "wobjdata", "speed": "speeddata",
    "zone": "zonedata", "signal": "signaldo",
}  # fmt: skip
_STORAGE: Final = {"constant": "CONST", "persistent": "PERS", "variable": "VAR"}
_SIGNAL_WORDS: Final = {
    "in": "WaitDI", "out": "WaitDO", "in-group": "WaitGI", "out-group": "WaitGO", "analog-in": "WaitAI",
    "analog-out": "WaitAO",
}  # fmt: skip
_COMPARED: Final = {"=": "", "<": "\\LT,", ">": "\\GT,", "<>": "\\NotEq,"}
_RADII: Final = ("x", "y", "z")
_ANGLES: Final = ("rx", "ry", "rz")


def native_type(s: Declare, own: bool) -> str:
    """RAPID's type of a declaration, lower case; of another language's (`own` False) the one that fits."""
    word = (s.native.split() or [""])[-1].lower()
    return word if own and word else _NATIVE.get(s.type, s.type)


class StatementWriter:
    """`words` spells the values. `own`: the program was read from RAPID."""

    def __init__(self, words: Words) -> None:
        self.words = words
        self.own = words.own

    def lines(self, s: Statement) -> list[str]:
        """The instructions of one statement. Raises CannotSayError."""
        spell = _SPELLINGS.get(type(s))
        if spell is None:
            raise CannotSayError(called.statement(s))
        found = spell(self, s)
        return found if isinstance(found, list) else [found]

    # --- data -------------------------------------------------------------------------------------------------

    def declare(self, s: Declare, *, module: bool = False) -> str:
        """`CONST robtarget p:=…;`"""
        written = native_type(s, self.own) if self.own else self.words.types[s.name.lower()]
        if not written:
            raise CannotSayError(f"a variable whose type nothing tells ({s.name})")
        kind = self.words.names.resolved(written)
        storage = _STORAGE.get(s.storage, "VAR")
        if kind in ("tooldata", "wobjdata") and not self.own:
            storage = "PERS"
        if s.value is None and storage == "CONST":
            storage = "VAR"
        task = self.own and s.native.upper().startswith("TASK ")
        scope = "TASK " if task else "LOCAL " if module and not s.shared else ""
        word = s.native.split()[-1] if self.own and s.native else written
        sizes = f"{{{','.join(map(self.words.value, s.sizes))}}}" if s.sizes else ""
        unset = storage == "VAR" and self.own and s.value == zero(kind, self.words.names, s.sizes)
        value = "" if s.value is None or unset else f":={self._initial(s.value, kind)}"
        return f"{scope}{storage} {word} {s.name}{sizes}{value};"

    def _initial(self, value: Expression, kind: str) -> str:
        if kind in ("num", "string") and isinstance(value, State):
            return "1" if value.on else "0"
        return self.words.value(value, kind)

    def _declare(self, s: Declare) -> str:
        return self.declare(s)

    def assign(self, s: Assign) -> str:
        target, value = s.target, s.value
        if isinstance(target, Member) and target.name in _ANGLES:
            return self._turned(target, value)
        if isinstance(target, Signal):
            raise CannotSayError("a signal that is assigned to")
        kind = self.words.type_of(target)
        if kind in ("tooldata", "wobjdata") and isinstance(value, (Function, SystemValue)):
            part = "tframe" if kind == "tooldata" else "uframe"
            return f"{self.words.value(target)}.{part}:={self.words.as_pose(value)};"
        partly = self._partly(target, value, kind)
        if partly is not None:
            return partly
        name = self.words.value(target)
        if kind == "robtarget":
            return f"{name}:={self.words.as_robtarget(value)};"
        return f"{name}:={self.words.value(value, kind if _is_structure(value) else '')};"

    def _partly(self, target: Expression, value: Expression, kind: str) -> str | None:
        """A pose that keeps its place or its turn is assigned in part."""
        if kind == "jointtarget" and isinstance(value, Function) and value.name == "joints":
            return f"{self.words.value(target)}.robax:={robjoint_text(self.words, value.arguments)};"
        if not isinstance(value, Function) or kind not in ("robtarget", "pose", ""):
            return None
        place = tuple(Member(target, name) for name in _RADII)
        turn = tuple(Member(target, name) for name in _ANGLES)
        name = self.words.value(target)
        if value.name == "pose-angles" and value.arguments[:3] == place:
            return f"{name}.rot:={turn_text(self.words, value.arguments[3:6])};"
        if value.name == "pose-angles" and value.arguments[3:6] == turn:
            return f"{name}.trans:={place_text(self.words, value.arguments[:3])};"
        if value.name == "pose-quaternion" and value.arguments[:3] == place:
            return f"{name}.rot:=[{','.join(map(self.words.value, value.arguments[3:7]))}];"
        return None

    def _turned(self, target: Member, value: Expression) -> str:
        """One angle of a position: the quaternion is made anew of all three."""
        angles = {name: self.words.value(Member(target.base, name)) for name in _ANGLES}
        angles[target.name] = self.words.value(value)
        base = self.words.value(target.base)
        turned = base if self.words.type_of(target.base) == "orient" else f"{base}.rot"
        return f"{turned}:=OrientZYX({angles['rz']},{angles['ry']},{angles['rx']});"

    def update(self, s: Update) -> str:
        target = self.words.value(s.target)
        if s.operand is None:
            return f"{target}:=NOT {target};"
        if s.operator in "+-" and s.operand == Number(1):
            return f"{'Incr' if s.operator == '+' else 'Decr'} {target};"
        operand = self.words.value(s.operand, "", 6)
        if s.operator == "+":
            return f"Add {target},{self.words.value(s.operand)};"
        word = s.operator.upper() if s.operator.isalpha() else s.operator
        return f"{target}:={target} {word} {operand};"

    def clear(self, s: Clear) -> str:
        if s.target is None or s.count not in (None, Number(1)):
            raise CannotSayError("many variables that are cleared at once")
        return f"{self.words.value(s.target)}:=0;"

    # --- signals ----------------------------------------------------------------------------------------------

    def output(self, s: SetOutput) -> str | list[str]:
        words, signal = self.words, self.words.signal(s.signal)
        if not words.is_digital(s.signal):
            word = "SetAO" if s.signal.bus.startswith("analog") else "SetGO"
            return f"{word} {signal},{words.value(s.value)};"
        match s.value:
            case State(on):
                return f"SetDO {signal},{int(on)};"
            case Unary("not", operand) if operand == s.signal:
                return f"InvertDO {signal};"
            case Compare() | Logic() | Unary("not", _):
                pass
            case Named(name) if words.types.get(name.lower()) == "bool":
                pass
            case _:
                return f"SetDO {signal},{words.value(s.value)};"
        condition = words.condition(s.value)
        return [f"IF {condition} THEN", f"SetDO {signal},1;", "ELSE", f"SetDO {signal},0;", "ENDIF"]

    def pulse(self, s: PulseOutput) -> str:
        high = "\\High" if s.spelling == "High" or not self.own else ""
        length = "" if s.duration is None else f"\\PLength:={self.words.scaled(s.duration, 1.0)}"
        comma = "," if high or length else ""
        return self._if(s.condition, f"PulseDO {high}{length}{comma}{self.words.signal(s.signal)};")

    def read_input(self, s: ReadInput) -> str:
        return f"{self.words.value(s.target)}:={self.words.value(s.signal)};"

    # --- waits ------------------------------------------------------------------------------------------------

    def dwell(self, s: Dwell) -> str:
        return f"WaitTime {self.words.scaled(s.duration, 1.0)};"

    def wait(self, s: Wait, flag: Expression | None = None) -> str:
        """`flag`: the variable that says whether the time was out."""
        limit = ""
        if s.timeout is not None:
            limit = f"\\MaxTime:={self.words.scaled(s.timeout, 1.0)}"
            if flag is not None:
                limit += f"\\TimeFlag:={self.words.value(flag)}"
            elif not self.own:
                self.words.timed_out = True
                limit += f"\\TimeFlag:={TIMED_OUT}"
        match s.condition:
            case Compare(operator, Signal(bus, _) as signal, value) if self._waits_for(
                bus, operator, s.spelling
            ):
                wanted = str(int(value.on)) if isinstance(value, State) else self.words.value(value)
                name = self.words.signal(signal)
                return f"{_SIGNAL_WORDS[bus]} {name},{_COMPARED[operator]}{wanted}{limit};"
            case Signal(bus, _) as signal if bus in ("in", "out"):
                return f"{_SIGNAL_WORDS[bus]} {self.words.signal(signal)},1{limit};"
        return f"WaitUntil {self.words.condition(s.condition)}{limit};"

    def _waits_for(self, bus: str, operator: str, spelling: str) -> bool:
        analog = bus.startswith("analog")
        fits = bus in _SIGNAL_WORDS and (
            operator in ("<", ">") if analog else operator == "=" or bus.endswith("group")
        )
        return fits and operator in _COMPARED and spelling != "WaitUntil"

    # --- flow -------------------------------------------------------------------------------------------------

    def _if(self, condition: Expression | None, text: str) -> str:
        return text if condition is None else f"IF {self.words.condition(condition)} {text}"

    def if_(self, s: If) -> str:
        return f"IF {self.words.condition(s.condition)} THEN"

    def else_if(self, s: ElseIf) -> str:
        return f"ELSEIF {self.words.condition(s.condition)} THEN"

    def while_(self, s: While) -> str:
        return f"WHILE {self.words.condition(s.condition)} DO"

    def for_(self, s: For) -> str:
        if not isinstance(s.variable, Named):
            raise CannotSayError("a loop over a numbered variable")
        words = self.words
        step = "" if s.step is None else f" STEP {words.value(s.step)}"
        return f"FOR {s.variable.name} FROM {words.value(s.start)} TO {words.value(s.stop)}{step} DO"

    def case(self, s: Case) -> str:
        return f"CASE {','.join(map(self.words.value, s.values))}:"

    def jump(self, s: Jump) -> str:
        if not isinstance(s.target, str):
            raise CannotSayError("a jump to a computed label")
        return self._if(s.condition, f"GOTO {s.target};")

    def call(self, s: Call) -> str:
        if s.macro is not None or s.jump or not s.routine:
            raise CannotSayError("a call that does not come back, or of a macro")
        arguments = self.words.arguments(s.arguments)
        if s.result is not None:
            return self._if(s.condition, f"{self.words.value(s.result)}:={s.routine}({arguments});")
        name = f"%{quoted(s.routine)}%" if s.spelling == "%" and self.own else s.routine
        return self._if(s.condition, f"{name} {arguments};" if arguments else f"{name};")

    def return_(self, s: Return) -> str:
        if s.spelling == "EXIT" and self.own:
            return self._if(s.condition, "EXIT;")
        value = "" if s.value is None else f" {self.words.value(s.value, self.returns)}"
        return self._if(s.condition, f"RETURN{value};")

    returns = ""  # the type of the function that is written

    def pause(self, s: Pause) -> str:
        return self._if(s.condition, "Break;" if s.spelling == "Break" and self.own else "Stop;")

    # --- settings, messages, the rest ---------------------------------------------------------------------------

    def acceleration(self, s: SetAcceleration) -> str:
        if len(s.rates) != 1 or s.rates[0].unit is not AccelerationUnit.FRACTION or s.path is not None:
            raise CannotSayError("accelerations other than a share of the rated one")
        return f"AccSet {self.words.scaled(s.rates[0].value, percent)},100;"

    def override(self, s: SetOverride) -> str:
        return f"VelSet {self.words.scaled(s.share, percent)},5000;"

    def shift(self, s: ShiftOn) -> str:
        if s.frame is not None or s.coordinated:
            raise CannotSayError("a shift in a frame of its own")
        return f"PDispSet {self.words.as_pose(s.offset)};"

    def message(self, s: Message) -> str:
        match s.text:
            case Function("joined-text", (Text() as text, Function("text-of-value", (value,)))):
                return f"TPWrite {self.words.value(text)}\\Num:={self.words.value(value)};"
        return f"TPWrite {self.words.value(s.text)};"

    def process(self, s: Process) -> str:
        if not self.own:
            raise CannotSayError(f"{s.name}, an instruction of another language")
        texts = [value.value for _, value in s.arguments if isinstance(value, Text)]
        raw = texts[0] if texts else ""
        if s.name in ("interrupt", "call"):
            return f"{raw};"
        return f"{s.name} {raw};" if raw else f"{s.name};"

    def disabled(self, s: Disabled) -> str:
        return s.text if self.own else f"! {s.text.strip()}"

    def opaque(self, s: Opaque) -> str:
        if not self.own:
            raise CannotSayError("an instruction of another language that olp does not know")
        return s.text


def _is_structure(value: Expression) -> bool:
    return isinstance(value, (PositionLiteral, RecordLiteral, Function))


Spelling = Callable[[StatementWriter, Any], str | list[str]]
_SPELLINGS: Final[dict[type, Spelling]] = {
    Declare: StatementWriter._declare,
    Assign: StatementWriter.assign,
    Update: StatementWriter.update,
    Clear: StatementWriter.clear,
    SetOutput: StatementWriter.output,
    PulseOutput: StatementWriter.pulse,
    ReadInput: StatementWriter.read_input,
    Dwell: StatementWriter.dwell,
    Wait: StatementWriter.wait,
    If: StatementWriter.if_,
    ElseIf: StatementWriter.else_if,
    Else: lambda writer, s: "ELSE",
    EndIf: lambda writer, s: "ENDIF",
    While: StatementWriter.while_,
    EndWhile: lambda writer, s: "ENDWHILE",
    For: StatementWriter.for_,
    Next: lambda writer, s: "ENDFOR",
    Switch: lambda writer, s: f"TEST {writer.words.value(s.value)}",
    Case: StatementWriter.case,
    Default: lambda writer, s: "DEFAULT:",
    EndSwitch: lambda writer, s: "ENDTEST",
    Label: lambda writer, s: f"{s.name}:",
    Jump: StatementWriter.jump,
    Call: StatementWriter.call,
    Return: StatementWriter.return_,
    Pause: StatementWriter.pause,
    SetAcceleration: StatementWriter.acceleration,
    SetOverride: StatementWriter.override,
    ObeyFlags: lambda writer, s: "ConfJ \\On;" if s.on else "ConfJ \\Off;",
    ShiftOn: StatementWriter.shift,
    ShiftOff: lambda writer, s: "PDispOff;",
    Message: StatementWriter.message,
    Process: StatementWriter.process,
    Comment: lambda writer, s: f"!{s.text}" if writer.own or s.text[:1] == " " else f"! {s.text}",
    Disabled: StatementWriter.disabled,
    Opaque: StatementWriter.opaque,
}
