"""The TP parser: built once per process from grammars/tp.lark, shared by all reads."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple, cast

from lark import Token

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.languages.lark_host import BrokenLineError, Grammar
from olp.languages.statement_rules import BlockWords
from olp.languages.vendors.tp import values
from olp.languages.vendors.tp.moves import TpMoveRules


def _is_bound(value: float) -> bool:
    """Whether a number may be written out in FOR (FANUC's operator's manual, FOR/ENDFOR instructions)."""
    return float(value).is_integer() and -32767 <= value <= 32766


class TpParser(Grammar):
    """Parses one instruction at a time."""

    def __init__(self) -> None:
        super().__init__("tp", TpInstructionRules())

    def statements(self, text: str) -> tuple[st.Statement, ...]:
        """All statements of one line, with line 0. Raises lark's UnexpectedInput, or BrokenLineError."""
        parsed: Any = self.parse(text)
        return parsed.all if isinstance(parsed, Statements) else (parsed,)


@cache
def instruction_parser() -> TpParser:
    """The one parser of this process."""
    return TpParser()


# --- Statements ---
# Lowers every instruction that is no move: one short method per rule of the grammar.
#
# A line may stand for several statements; each comes with line 0, and the reader stamps the true one on it.

TIMED_OUT = ex.SystemValue("timed-out")
BASE = ex.FrameRef("base")
_CONDITIONAL = (
    st.Jump,
    st.Call,
    st.Return,
    st.Pause,
    st.PulseOutput,
    st.StartTask,
)  # have a condition of their own


class Statements(NamedTuple):
    """All that one line says."""

    all: tuple[st.Statement, ...]


class TpInstructionRules(TpMoveRules, BlockWords):
    """The whole instruction."""

    # --- values and signals -----------------------------------------------------------------------------

    def assign(self, children: list[Any]) -> st.Statement:
        target, value = children
        if isinstance(target, ex.Signal):
            return st.SetOutput(0, target, value)
        if isinstance(target, ex.Named) and target.name.upper() == values.OVERRIDE:
            return st.SetOverride(0, ex.Quantity(value, values.PERCENT))
        return st.Assign(0, target, value)

    def pulse(self, children: list[Any]) -> st.PulseOutput:
        if not isinstance(children[0], ex.Signal):
            raise BrokenLineError(
                "a pulse on something that is no output", wanted="an output, as in DO[1]=PULSE,0.5sec"
            )
        _, time, unit = children
        if unit is not None and unit != "sec":
            raise BrokenLineError(f"a pulse in {unit}", wanted="a time in seconds, as in DO[1]=PULSE,0.5sec")
        duration = None if time is None else ex.Quantity(time, 1.0)
        return st.PulseOutput(0, children[0], duration)

    def timer(self, children: list[Any]) -> st.Process | st.Assign:
        timer, word = children[0], str(children[1])
        if isinstance(timer, ex.SystemValue):
            if word == "RESET":
                return st.Assign(0, timer, ex.Number(0))
            runs = ex.SystemValue("timer-running", timer.index, timer.comment)
            return st.Assign(0, runs, ex.SignalState(word == "START"))
        if isinstance(timer, ex.Function) and timer.name == "timer":
            index = timer.arguments[0]
        else:
            raise BrokenLineError(
                "START, STOP or RESET of something that is no timer", wanted="a timer, as in TIMER[1]=START"
            )
        return st.Process(0, "TIMER", (("", index), ("", ex.Text(word))))

    def override(self, children: list[Any]) -> st.SetOverride:
        if len(children) > 1 and children[1] != "%":
            raise BrokenLineError(f"an override in {children[1]}", wanted="a percentage, as in OVERRIDE=50%")
        return st.SetOverride(0, ex.Quantity(children[0], values.PERCENT))

    def select_frame(self, children: list[Any]) -> st.Statement:
        word, number = children
        if word.startswith("UTOOL_NUM"):
            return st.SetTool(0, ex.FrameRef("tool", number))
        return st.SetFrame(0, BASE if number == ex.Number(0) else ex.FrameRef("user", number))

    def skip_condition(self, children: list[Any]) -> st.Process:
        return st.Process(0, "SKIP CONDITION", (("", children[-1]),))

    def offset_condition(self, children: list[Any]) -> st.Process:
        return st.Process(0, "OFFSET CONDITION", (("", children[-1]),))

    def tool_offset_condition(self, children: list[Any]) -> st.Process:
        return st.Process(0, "TOOL_OFFSET CONDITION", (("", children[-1]),))

    # --- waiting ----------------------------------------------------------------------------------------

    def dwell(self, children: list[Any]) -> st.Dwell:
        return st.Dwell(0, ex.Quantity(children[0], 1.0))

    def wait(self, children: list[Any]) -> st.Statement | Statements:
        condition, label = children[0], children[1] if len(children) > 1 else None
        if type(condition) in (ex.Number, ex.Variable, ex.Argument) and label is None:
            return st.Dwell(0, ex.Quantity(condition, 1.0))
        if label is None:
            return st.Wait(0, condition)
        limit = ex.Quantity(ex.Named(values.TIMEOUT), values.TICK)
        return Statements((st.Wait(0, condition, limit), st.Jump(0, label, TIMED_OUT)))

    def timeout(self, children: list[Any]) -> str | ex.Expression:
        return _label(children[1])

    # --- control flow -----------------------------------------------------------------------------------

    def label(self, children: list[Any]) -> st.Label:
        name = _label(children[1])
        if not isinstance(name, str):
            raise BrokenLineError("a label without a fixed number", wanted="a number, as in LBL[1]")
        return st.Label(0, name, children[2])

    def jump(self, children: list[Any]) -> st.Jump:
        return st.Jump(0, _label(children[1]))

    def arguments(self, children: list[Any]) -> tuple[ex.Expression, ...]:
        return tuple(one for one in children if one is not None)

    def call(self, children: list[Any]) -> st.Call:
        return st.Call(0, str(children[0]), children[1] or ())

    def call_computed(self, children: list[Any]) -> st.Process:
        return st.Process(0, "CALL", tuple(("", one) for one in (children[0], *(children[1] or ()))))

    def run(self, children: list[Any]) -> st.StartTask:
        return st.StartTask(0, str(children[0]), str(children[0]))

    def end(self, _: list[Any]) -> st.Return:
        return st.Return(0)

    def abort(self, _: list[Any]) -> st.Process:
        return st.Process(0, "ABORT")

    def if_then_do(self, children: list[Any]) -> st.Statement | Statements:
        condition, action = children
        if isinstance(action, _CONDITIONAL) and action.condition is None:
            return cast(st.Statement, replace(action, condition=condition))
        inside = action.all if isinstance(action, Statements) else (action,)
        return Statements((st.If(0, condition, spelling="one line"), *inside, st.EndIf(0)))

    def select(self, children: list[Any]) -> Statements:
        value, first, action = children
        return Statements((st.Switch(0, value), st.Case(0, (first,)), *_all(action)))

    def case(self, children: list[Any]) -> Statements:
        value, action = children
        return Statements((st.Case(0, (value,)), *_all(action)))

    def otherwise(self, children: list[Any]) -> Statements:
        return Statements((st.Default(0), *_all(children[0])))

    def for_(self, children: list[Any]) -> st.For:
        variable, start, word, stop = children
        if not isinstance(variable, ex.Variable):
            raise BrokenLineError(
                "FOR counts something that is no register", wanted="a register, as in FOR R[1]=1 TO 5"
            )
        for bound in (start, stop):
            if isinstance(bound, ex.Number) and not _is_bound(bound.value):
                raise BrokenLineError(
                    f"FOR counts from or to {bound.value}",
                    wanted="a whole number from -32767 to 32766, or a register that holds the other number",
                )
        return st.For(0, variable, start, stop, ex.Number(-1) if word == "DOWNTO" else None)

    # --- the rest ---------------------------------------------------------------------------------------

    def message(self, children: list[Token]) -> st.Message:
        text = str(children[0])
        return st.Message(0, ex.Text(text[text.index("[") + 1 : text.rindex("]")]))

    def process(self, children: list[Token]) -> st.Process:
        rest = str(children[1]).strip() if len(children) > 1 and children[1] is not None else ""
        name = " ".join(str(children[0]).split())
        if name.endswith("["):
            name, rest = name[:-1].strip(), f"[{rest}"
        return st.Process(0, name, (("", ex.Text(rest)),) if rest else ())


def _label(index: ex.Expression) -> str | ex.Expression:
    """The name of a label: its number; an expression where it is computed."""
    return str(int(index.value)) if isinstance(index, ex.Number) else index


def _all(action: Any) -> tuple[Any, ...]:
    return action.all if isinstance(action, Statements) else (action,)
