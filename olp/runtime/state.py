"""What a running program is made of: its call stack, its variables, what was reported so far."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from olp.core.diagnostic import Diagnostic, Severity, Span
from olp.ir.expressions import Expression, FrameRef, Store
from olp.ir.program import BlendKind, Move
from olp.languages.vendor import Conventions
from olp.runtime.assumptions import Assumptions, SignalKey
from olp.runtime.folder import KIND_PREFIX, World, group_names, mechanism_name
from olp.runtime.jobs import Jobs, RunnableRoutine
from olp.runtime.made_up import MadeUp
from olp.runtime.memory import Changes, Key, Memory, PositionValue, Scope, Slot, Value
from olp.runtime.plan import ASSUMABLE, USUAL_LAW, CallSpan
from olp.runtime.recorder import NOWHERE, Recorder

# Codes of findings that a value is not known: the statement is left out.
VALUE_IS_UNKNOWN = frozenset({"I203", "I209"})

# Statements of a cycle, and for each that is read: no cell has come near, and what never ends is over in a second.
STEPS, _TIMES = 200_000, 10
# What a handler returns: nothing (go on), the index of the next statement, or this: the call stack changed.
OTHER_FRAME = -1


class StatementError(Exception):
    """A statement that cannot be executed. Caught by the machine, which reports it and goes on behind it."""

    def __init__(
        self,
        code: str,
        message: str,
        help: str = "",
        severity: Severity = Severity.ERROR,
        certain: bool = False,  # no file can say it: nothing is assumed instead
    ) -> None:
        self.code, self.message, self.help, self.severity = code, message, help, severity
        self.certain = certain
        super().__init__(message)


class EndedError(StatementError):
    """The run ended inside the statement, for a reason that was told there."""

    def __init__(self) -> None:
        super().__init__("", "")


# What variables and signals held: each with its value, in a form that later changes do not reach.
Held = tuple[tuple[tuple[str, int | None, bool], object], ...]
_COMPARED_PASSES = 64  # of a loop: as many numbered steps may one program have that asks in turn


class LoopEntry(NamedTuple):
    """What had happened when the head of a loop was passed: changes, moves and signal reads so far.

    `number` tells apart how often the loop was reached from outside. `held`: what the variables held that decide about
    the loops with this head. `steps`: of the plan.
    """

    stamp: int
    moves: int
    reads: int
    number: int
    held: Held = ()
    steps: int = 0


class Shift(NamedTuple):
    """What every taught target is moved by, along the axes of `frame`."""

    offset: PositionValue
    frame: FrameRef


_PLAIN = Conventions(taught_frames=True, known_functions=True)  # of programs that are made, and not read


@dataclass(slots=True)
class Loop:
    """One way back to an earlier statement, since the loop was reached from outside (entry number `entry`)."""

    entry: int
    passes: int = 0
    idle: int = 0  # passes in a row without a move
    flipped: set[SignalKey] = field(default_factory=set)  # inputs turned over to end it
    past: deque[LoopEntry] = field(default_factory=lambda: deque(maxlen=_COMPARED_PASSES))
    held: deque[Held] = field(
        default_factory=lambda: deque(maxlen=_COMPARED_PASSES)
    )  # of each entry in `past`


@dataclass(slots=True)
class CallFrame:
    """A routine that runs: `pc` is the index of the statement after the current one."""

    job: RunnableRoutine
    arguments: tuple[Value, ...] = ()
    pc: int = 0
    locals: dict[Key, Value] = field(default_factory=dict)
    loops: dict[int, Loop] = field(default_factory=dict)  # by the statement that leads back
    entered: dict[int, LoopEntry] = field(default_factory=dict)  # by the loop's head
    # FOR at index -> stop, step, and the variable that its counter hides
    counters: dict[int, tuple[float, float, Slot | None]] = field(default_factory=dict)
    names: Scope = field(default_factory=dict)  # named variables of this run of the routine
    lent: dict[str, str] = field(default_factory=dict)  # parameter -> the caller's variable that it is
    changed: Changes = field(default_factory=dict)  # as `Memory.changed`, of what is the routine's own
    outs: list[tuple[str, Expression]] = field(
        default_factory=list
    )  # parameter -> where its value goes back to
    result: Expression | None = None  # where the returned value goes


class Operations(NamedTuple):
    """What parts of the interpreter ask of one another; interpreter.py puts them together, so that none imports all."""

    evaluators: Mapping[type, Callable[[Machine, Any], Value]]  # by the class of the expression
    declare: Callable[[Machine, RunnableRoutine], None]  # the named variables of a routine's file
    store: Callable[[Machine, Expression, Value], None]  # a value wherever a program can store one
    run_until: Callable[[Machine, int], None]  # until no more than so many callers wait
    act: Callable[[Machine, Move, bool], None]  # what a move does on its way, near its start or near its end


@dataclass(slots=True)
class Machine:
    """The whole state of a run."""

    operations: Operations

    recorder: Recorder
    world: World
    memory: Memory
    jobs: Jobs
    assumptions: Assumptions
    cycles: int
    frame: CallFrame
    frames: list[CallFrame] = field(default_factory=list)  # the callers, outermost first
    plain: bool = True  # taught points are where they were taught: no shift, no redefined tool or frame
    shift: Shift | None = None
    returned: Value | None = None
    ended: bool = False
    stop_reason: str = ""
    moves: int = 0
    reads: int = 0  # signals read so far
    entries: int = 0  # loops reached so far
    listed: int = 0  # stamp of the last step through a list of inputs from olp.toml
    first_job: int = 0
    jumped: dict[int, int] = field(default_factory=dict)  # routine -> how often it was jumped to
    modal: dict[int, float] = field(default_factory=dict)  # speed unit -> SI value set by SPEED
    last: dict[int, float] = field(default_factory=dict)  # speed unit -> SI value of the last move
    tool_now: dict[int, int] = field(
        default_factory=dict
    )  # tool -> its number in the cell since it was redefined
    user_now: dict[int, int] = field(default_factory=dict)  # user frame -> likewise
    visits: dict[SignalKey, int] = field(default_factory=dict)  # how often a listed input was read
    inputs_read: dict[SignalKey, int] = field(default_factory=dict)  # -> value of `reads` at its last read
    signals_made_up: dict[SignalKey, int] = field(default_factory=dict)  # as they were first read
    spans: list[CallSpan] = field(default_factory=list)
    nested: int = 0  # calls within expressions under way
    allowed: int = 0  # statements of the run
    left: int = 0  # of those
    allows_more: bool = False  # the more, the longer the routines are that are run
    modules: dict[int, Scope] = field(default_factory=dict)  # file -> its named variables
    known_routines: Mapping[str, str] = field(
        default_factory=dict
    )  # of the language's controllers, see `Vendor`
    case_sensitive: bool = False
    advance_stops: bool = False  # see `Vendor`
    continued: tuple[CallFrame, int] | None = None  # the statement before which a CONTINUE stands
    law: str = USUAL_LAW  # blending law of the maker whose language runs
    conventions: Conventions = _PLAIN  # of the language that runs
    obeys_flags: bool = True  # joint moves go to the arm flags of their targets
    active_tool: int = 0  # that holds for moves that name none
    active_frame: tuple[str, int | None] = (
        "base",
        None,
    )  # likewise: base, or user and its number in the cell
    placed: dict[tuple[str, tuple[float, ...]], int] = field(
        default_factory=dict
    )  # tools and frames by value
    # Tools and frames that variables hold, by the id of the variable, which is kept; with `Memory.stamp` then
    tools_named: dict[int, tuple[Slot, int, int]] = field(default_factory=dict)
    frames_named: dict[int, tuple[Slot, int, tuple[str, int | None]]] = field(default_factory=dict)
    # (pose, axes nearby, tool, frame) -> the axes that reach it
    solved: dict[tuple[PositionValue, PositionValue, int, tuple[str, int | None]], PositionValue] = field(
        default_factory=dict
    )
    ahead: dict[int, int] = field(
        default_factory=dict
    )  # by the id of a routine's body: up to where that is done
    rates: dict[tuple[bool, int], float] = field(
        default_factory=dict
    )  # (joint move, unit) -> modal acceleration
    blends: dict[BlendKind, float] = field(default_factory=dict)  # modal sizes
    turn: float = math.nan  # [rad/s] modal bound of the tool's turning
    override: float = 1.0
    fastest: float = math.inf  # [m/s] of the tool, whatever moves say
    declaring: bool = False  # data are made ready
    unsure: bool = False  # a value was assumed: what is wrong from here on may only follow from it
    timed_out: bool = False  # whether the last wait ended by its limit
    made_up: MadeUp | None = None  # values for what no file tells
    seeks_move: bool = False  # the run is over when it reaches a move
    reached_move: bool = False  # to another place than where the arm is, whether its target is known or not
    _topics: dict[str, tuple[int, int]] = field(default_factory=dict)
    _assumed: dict[tuple[int, int, str], int] = field(default_factory=dict)
    _found: dict[tuple[str, str, int, str], Diagnostic] = field(default_factory=dict)

    @property
    def line(self) -> int:
        """The line of the statement under way."""
        frame = self.frame
        return (
            frame.job.body[frame.pc - 1].line
            if 0 < frame.pc <= len(frame.job.body)
            else frame.job.routine.line
        )

    def stop_advance(self) -> None:
        """The statement under way waits until the arm stands: the move before ends exactly."""
        if not self.advance_stops:
            return
        frame = self.frame
        if self.continued is None or self.continued[0] is not frame or self.continued[1] != frame.pc - 1:
            self.recorder.end_exactly()

    def assume(self, says: str, line: int | None = None) -> None:
        """Reports something taken for granted at the current line, counted when it repeats."""
        key = (self.frame.job.source, self.line if line is None else line, says)
        self._assumed[key] = self._assumed.get(key, 0) + 1

    def assume_once(self, topic: str, says: str) -> None:
        """Reports something at the first line that needs it, whatever the number of further lines."""
        first = self._topics.setdefault(topic, (self.frame.job.source, self.line))
        key = (*first, says)
        self._assumed[key] = self._assumed.get(key, 0) + 1

    def report(self, finding: Diagnostic) -> None:
        """Keeps a finding, once per place."""
        self._found.setdefault((finding.code, finding.file, finding.line, finding.message), finding)

    def may_assume(self, fault: StatementError) -> bool:
        """Whether what no file says is assumed, and no error."""
        key = None if fault.certain else ASSUMABLE.get(fault.code)
        return key is not None and key not in self.assumptions.strict and not self.declaring

    def fault(self, fault: StatementError, taken: str = "") -> None:
        """Keeps what went wrong in the current statement. `taken`: what is assumed for it."""
        if self.seeks_move:  # a try, of which nobody reads what is found
            self.unsure = self.unsure or self.may_assume(fault)
            return
        source, line = self.frame.job.program.source, self.line
        severity, message = fault.severity, fault.message
        if self.may_assume(fault):
            severity = Severity.WARNING
            message += taken and f": {taken}"
            self.unsure = True
        elif self.unsure and fault.code.startswith(("I2", "I3")) and fault.code not in ASSUMABLE:
            severity = Severity.WARNING
        if fault.code in VALUE_IS_UNKNOWN and self.recorder.unknown < 0:
            self.recorder.unknown = len(self.recorder)
        place = (fault.code, source.path, line, message)
        if place in self._found:
            return
        text = source.line(line)
        span = Span(line, len(text) - len(text.lstrip()) + 1, len(text.rstrip()) + 1)
        self._found[place] = Diagnostic(fault.code, message, severity, source.path, *span, fault.help, text)

    def add_mechanism(self, name: str) -> int:
        """The index of the mechanism called `name`, new or not."""
        index = self.world.mechanism(name)
        while len(self.recorder.at) < len(self.world.mechanisms):
            self.recorder.at.append(NOWHERE)
        return index

    def allow(self, statements: int) -> None:
        """Lets the run go on for so many more."""
        self.allowed += statements
        self.left += statements

    def load(self, job: RunnableRoutine) -> None:
        """Makes a routine ready: its mechanisms, and the global positions that its header sets."""
        if job.loaded:
            return
        job.loaded = True
        if self.allows_more:
            self.allow(_TIMES * len(job.body))
        self.operations.declare(self, job)
        self.recorder.sources = tuple(self.jobs.sources)
        names = group_names([group.mechanisms for group in job.routine.groups])
        job.groups = tuple(tuple(self.add_mechanism(name) for name in group) for group in names)
        for (store, taught), block in job.points.blocks.items():
            if taught:
                continue
            for index in block.rows:
                point = job.points.find(store, False, index)
                key = (store, index)
                # A routine is loaded before the program starts: what ran since then counts more.
                told = key in self.memory.changed or key in self.assumptions.variables
                if point is not None and not told:
                    self.memory.values[key] = PositionValue(point.state, point.values)

    def diagnostics(self) -> tuple[Diagnostic, ...]:
        return tuple(self._found.values())

    def hand_over_assumptions(self) -> None:
        """Gives what was assumed to the recorder, each with how often it was needed."""
        for (source, line, says), count in self._assumed.items():
            self.recorder.assume(source, line, says if count == 1 else f"{says} ({count} times)")

    def stop(self, reason: str) -> None:
        """Ends the run after the current statement."""
        self.stop_reason = reason


def role(m: Machine, part: int, store: Store) -> int:
    """The mechanism that a position of kind `store` moves in part `part` of a move (0: the leading one)."""
    job = m.frame.job
    index = job.roles.get((part, store))
    if index is None:
        index = job.roles[(part, store)] = _find_role(m, part, store)
    return index


def _find_role(m: Machine, part: int, store: Store) -> int:
    mechanisms, prefix = m.world.mechanisms, KIND_PREFIX[store]
    name = mechanism_name(
        [[mechanisms[at].name for at in group] for group in m.frame.job.groups], part, store
    )
    if name:
        return m.add_mechanism(name)
    m.assume(f"the routine names no {prefix} mechanism for its {store.value} positions: {prefix}1 is taken")
    return m.add_mechanism(f"{prefix}1")
