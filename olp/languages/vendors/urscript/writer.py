"""Writes programs as URScript: what `templates/urscript.j2` puts together.

One function holds the whole program: its data, the other functions inside it, and its instructions.

Codes: X002 what URScript cannot say.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field
from typing import ClassVar, Final

from olp.core.diagnostic import Diagnostic
from olp.core.units import deg
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.ir.transformer import expressions_of
from olp.languages.generator import BRANCHES, CLOSES, OPENS, CannotSayError, Joined, Lines, as_text
from olp.languages.vendors.urscript import builtins, helpers
from olp.languages.vendors.urscript.calls import inverted
from olp.languages.vendors.urscript.write_values import PLACES, UrscriptValues

# --- Write moves ---
# Writes moves: the word and its arguments, the frame by `pose_trans`, the tool by `set_tcp` where it changes.

_JOINT = {st.SpeedUnit.AXIS: "movej", st.SpeedUnit.TIME: "movej", st.SpeedUnit.FRACTION: "optimovej"}
_LINEAR = {st.SpeedUnit.TRAVEL: "movel", st.SpeedUnit.TIME: "movel", st.SpeedUnit.FRACTION: "optimovel"}
_OWN_TAGS: Final = frozenset({"t", builtins.NO_TIME, "v", "mode", "process"})
_UNITS: Final = {"movej": st.AccelerationUnit.AXIS}


class UrscriptMoves(UrscriptValues):
    """Writes moves and the tools before them. Arguments that moves share are spelled once."""

    cannot: ClassVar = {
        st.Move: {
            "search": "a search",
            "until": "a move that ends early",
            "relative": "a relative move",
            "offset": "an offset of a move",
            "tool_offset": "an offset in the tool's axes",
            "turn": "a bound on the tool's turning",
            "arc": "an arc by its angle",
            "parts": "what another group does meanwhile",
            "coordinated": "a move in another group's frame",
            "deceleration": "a deceleration of its own",
            "no_wait": "a move that is not waited for",
        }
    }

    def __init__(self, program: st.Program) -> None:
        super().__init__(program)
        self._manners: dict[tuple[object, ...], tuple[str, str]] = {}
        self._kept: list[st.Move] = []  # whose parts some of the keys name

    def forget(self) -> None:
        self._tool: str | None = None  # what set_tcp holds as far as the text tells, None: unknown
        self._given: ex.Expression | None = None  # the tool of the last move, which the next one shares

    def known(self) -> dict[str, object]:
        return {"tool": self._tool}

    def know(self, known: Mapping[str, object]) -> None:
        self.forget()
        tool = known.get("tool")
        self._tool = tool if isinstance(tool, str) else None

    def forget_from(self, name: str) -> None:
        if self._tool is not None and name in self._tool:
            self.forget()

    def write_move(self, s: st.Move) -> Lines:
        """set_tcp where the tool changes, and the move."""
        lines = []
        if s.tool is not None and (s.tool is not self._given or self._tool is None):
            wanted = self.tool(s.tool)
            self._given = s.tool
            if wanted != self._tool:
                lines.append(f"set_tcp({wanted})")
                self._tool = wanted
        lines.append(self._move(s))
        return lines

    def tool(self, e: ex.Expression) -> str:
        """The arguments of set_tcp."""
        text = self.value(e)
        name = dict(e.native).get("name", "") if self.own and type(e) is ex.PositionLiteral else ""
        return f'{text}, "{name}"' if name else text

    def _move(self, s: st.Move) -> str:
        key = _key(s)
        found = self._manners.get(key)
        if found is None:
            found = self._manners[key] = self._manner(s)
            self._kept.append(s)
        if len(s.targets) != 1:
            raise CannotSayError("a move of more than one mechanism")
        word, arguments = found
        target = self.place(s.targets[0], s.frame)
        if s.via is not None:
            target = f"{self.place(s.via, s.frame)}, {target}"
        return f"{word}({target}{arguments})"

    def place(self, e: ex.Expression, frame: ex.Expression | None) -> str:
        """A target, seen from the base. Raises CannotSayError."""
        if frame is None or (type(frame) is ex.FrameRef and frame.kind == "base") or self.kind(e) == "joints":
            if (
                type(e) is not ex.Function
                or e.name != "inverse"
                or frame is None
                or type(frame) is ex.FrameRef
            ):
                return self.value(e)
            pose, *rest = e.arguments
            return self.value(ex.Function("inverse", (ex.Function("pose-product", (frame, pose)), *rest)))
        return f"pose_trans({self.value(frame)}, {self.value(e)})"

    def _manner(self, s: st.Move) -> tuple[str, str]:
        word = self._word(s)
        other = dict(s.other)
        unknown = other.keys() - _OWN_TAGS if self.own else other.keys()
        if unknown:
            raise CannotSayError(f"{', '.join(sorted(unknown))} of a move")
        arguments = [*self._rate(s, word), *self._speed(s, other), *self._blend(s.blend)]
        if "mode" in other:
            arguments.append(f"mode={self.value(other['mode'])}")
        return word, "".join(f", {one}" for one in arguments)

    def _word(self, s: st.Move) -> str:
        if s.speed is None:
            raise CannotSayError("a move without a speed", "name one")
        if s.path is st.Path.CIRCULAR and s.via is None:
            raise CannotSayError("an arc through points of several moves")
        words = {
            st.Path.JOINT: _JOINT,
            st.Path.LINEAR: _LINEAR,
            st.Path.CIRCULAR: {st.SpeedUnit.TRAVEL: "movec"},
        }.get(s.path)
        if words is None:
            raise CannotSayError("a spline")
        word = words.get(s.speed.unit)
        if word is None:
            raise CannotSayError(f"a {s.path} move with {terminology.SPEEDS[s.speed.unit]}")
        return "movep" if ("process", ex.SignalState(True)) in s.other and word == "movel" else word

    def _rate(self, s: st.Move, word: str) -> list[str]:
        if word.startswith("optimove"):
            return [] if s.acceleration is None else [f"a={self.quantity(s.acceleration)}"]
        if s.acceleration is not None:
            raise CannotSayError("an acceleration as a share of the rated one")
        if s.rate is None:
            return []
        if s.rate.unit is not _UNITS.get(word, st.AccelerationUnit.TRAVEL):
            raise CannotSayError(f"{terminology.ACCELERATIONS[s.rate.unit]} of a {s.path} move")
        return [f"a={self.quantity(s.rate.value)}"]

    def _speed(self, s: st.Move, other: dict[str, ex.Expression]) -> list[str]:
        assert s.speed is not None  # `_word` has looked
        value = self.quantity(s.speed.value)
        if s.speed.unit is st.SpeedUnit.TIME:
            speed = [f"v={self.value(other['v'])}"] if "v" in other else []
            return [*speed, f"t={value}"]
        time = [f"t={self.value(value)}" for name, value in other.items() if name in ("t", builtins.NO_TIME)]
        return [f"v={value}", *time]

    def _blend(self, blend: st.Blend | None) -> list[str]:
        if blend is None or blend.kind is not st.BlendKind.RADIUS or blend.value is None:
            raise CannotSayError("a blend that is no radius")
        if blend.value.written in (ex.Number(0), ex.Number(0.0)):
            return []
        return [f"r={self.quantity(blend.value)}"]


def _key(s: st.Move) -> tuple[object, ...]:
    """Equal for moves that go the same way: numbers where all are written out, else the parts themselves."""
    speed, blend, rate = s.speed, s.blend, s.rate
    if speed is not None and blend is not None and blend.value is not None and not s.other:
        numbers = (speed.value.literal, blend.value.literal, 0.0 if rate is None else rate.value.literal)
        if s.acceleration is None and None not in numbers:
            unit = None if rate is None else rate.unit
            return (s.path, speed.unit, blend.kind, unit, s.via is None, speed.value.scale, *numbers)
    parts = (speed, blend, rate, s.acceleration, s.other)
    return (s.path, s.via is None, *map(id, parts))


# --- Writer ---

_DEFAULTS: Final = {
    "integer": "0",
    "boolean": "False",
    "string": '""',
    "position": "p[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]",
    "frame": "p[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]",
    "tool": "p[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]",
    "joints": "[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]",
    "list": "[]",
}
_MOST_ITEMS = 1000
_TYPES: Final = {"frame": "position", "tool": "position"}
_NO_RETURN: Final = "a call that does not come back, or a macro"


@dataclass(frozen=True, slots=True)
class UrscriptFunction:
    """One function as the template sees it: `head` without its colon; `body` of whole lines, indented."""

    head: str
    comment: str
    body: str


def write(program: st.Program, date: str) -> tuple[dict[str, object], list[Diagnostic]]:
    """The values for the template, and everything that URScript cannot say. `date`: scripts hold none."""
    return UrscriptWriter(program).written()


_TAKES_NO_TIME: Final = (
    BRANCHES
    | {st.If, st.Switch, st.EndIf, st.EndSwitch, st.Break, st.Continue}
    | {st.Assign, st.SetOutput, st.Comment, st.Disabled, st.Label, st.Declare, st.SetTool}
)


def _idle_loops(statements: Sequence[st.Statement]) -> Iterator[int]:
    """The `id` of each loop in which nothing takes time, and that asks signals or only what it does not change."""
    loops: list[list[st.Statement]] = []
    for s in statements:
        for held in loops:
            held.append(s)
        if isinstance(s, st.While):
            loops.append([s])
        elif isinstance(s, st.EndWhile) and loops:
            head, *inside, _ = loops.pop()
            asked = [e for one in (head, *inside) for e in _asked(one)]
            timeless = all(type(one) in _TAKES_NO_TIME for one in inside)
            calls = any(type(e) is ex.CallValue for e in asked)
            named = [e for one in (head, *inside) for e in expressions_of(getattr(one, "condition", None))]
            changed = [e for one in inside if isinstance(one, st.Assign) for e in expressions_of(one.target)]
            outside = not {*filter(_is_name, named)} & {*filter(_is_name, changed)}
            if timeless and not calls and (outside or any(type(e) is ex.Signal for e in asked)):
                yield id(head)


def _is_name(e: ex.Expression) -> bool:
    return type(e) is ex.Named


def _idle_steps(statements: Sequence[st.Statement]) -> Iterator[int]:
    """The `id` of steps of a loop over numbered steps (`machine`) that must take time.

    Each way around through steps that take none and ask signals passes one of them.
    """
    for at, s in enumerate(statements):
        if isinstance(s, st.While) and (counter := _counter(s)) is not None:
            steps = _steps_of(statements[at + 1 :], counter)
            quick = {number for number, step in steps.items() if step.takes_no_time}
            for number in quick:
                back = {to for to in steps[number].leads if to in quick and to <= number}
                around = {one for to in back for one in _round(steps, quick, to, number)}
                if any(steps[one].asks for one in around):
                    yield id(steps[number].head)


def _counter(s: st.While) -> ex.Expression | None:
    match s.condition:
        case ex.Compare(">=", ex.Named() as counter, ex.Number(0)):
            return counter
    return None


@dataclass(slots=True)
class _NumberedStep:
    head: st.Statement
    takes_no_time: bool = True
    asks: bool = False
    leads: set[float] = field(default_factory=set)


def _steps_of(statements: Sequence[st.Statement], counter: ex.Expression) -> dict[float, _NumberedStep]:
    """The steps of such a loop by their numbers, nothing of another loop. `statements`: within it and behind."""
    steps: dict[float, _NumberedStep] = {}
    depth = 0
    for s in statements:
        if type(s) in CLOSES:
            depth -= 1
            if depth <= 0:
                return steps
        if isinstance(s, (st.If, st.ElseIf)) and depth <= isinstance(s, st.ElseIf):
            match s.condition:
                case ex.Compare("=", one, ex.Number(number)) if one == counter:
                    steps[number] = step = _NumberedStep(s)
                case _:
                    return {}
        elif not steps:
            return {}
        else:
            step.takes_no_time &= type(s) in _TAKES_NO_TIME
            asked = _asked(s)
            step.takes_no_time &= not any(type(e) is ex.CallValue for e in asked)
            step.asks |= any(type(e) is ex.Signal for e in asked)
            if isinstance(s, st.Assign) and s.target == counter and isinstance(s.value, ex.Number):
                step.leads.add(s.value.value)
        depth += type(s) in OPENS
    return {}


def _round(steps: Mapping[float, _NumberedStep], quick: Set[float], first: float, last: float) -> set[float]:
    """The steps between `first` and `last` on ways through `quick` ones; nothing where none leads there."""
    onward = _reached(first, quick, lambda one: steps[one].leads)
    back = _reached(last, quick, lambda one: {n for n in quick if one in steps[n].leads})
    return onward & back


def _reached(start: float, among: Set[float], leads: Callable[[float], Set[float]]) -> set[float]:
    found, rows = {start}, [start]
    while rows:
        new = {to for to in leads(rows.pop()) if to in among} - found
        found |= new
        rows += new
    return found


def _asked(s: st.Statement) -> list[ex.Expression]:
    return [*expressions_of(getattr(s, "condition", None)), *expressions_of(getattr(s, "value", None))]


class UrscriptWriter(UrscriptMoves):
    """Writes statements and functions."""

    templates: ClassVar = {
        st.Else: "else:",
        st.EndIf: "end",
        st.EndWhile: "end",
        st.Break: "break",
        st.Continue: "continue",
        st.Dwell: "sleep({duration})",
        st.WaitTask: "join {task}",
        st.SetTool: "set_tcp({tool})",
        st.Disabled: "# {text}",
    }
    fields: ClassVar = {"tool": "tool"}
    cannot: ClassVar = {
        st.Call: dict.fromkeys(("jump", "macro", "condition"), _NO_RETURN),
        st.Return: {"condition": "a return under a condition"},
        st.Pause: {"condition": "a pause under a condition"},
        st.StartTask: dict.fromkeys(("condition", "synchronised"), "a task that keeps step with this one"),
    }
    own_only: ClassVar = {
        st.Process: "the instruction {s.name}",
        st.Opaque: "a line that only its own language understands",
    }
    step = "  "
    least_depth = 1
    comment_form = "  # {}"
    comment_row = 0
    follows_branches = True
    forgets = OPENS | BRANCHES | CLOSES | {st.Call}
    joins = frozenset({st.Process, st.Message})

    def __init__(self, program: st.Program) -> None:
        super().__init__(program)
        for declare in program.data:
            _note(self.types, declare)
        self.pulses: dict[str, tuple[str, ...]] = {}  # thread -> its lines
        self.returns = {routine.name: routine.returns for routine in program.routines}
        self.started = set() if self.own else self._started()
        self.idle: set[int] = set()  # loops that take no time
        self.late = {one.name for one in program.data if one.value is None} if self.own else set()

    # --- values -------------------------------------------------------------------------------------

    def stored(self, target: ex.Expression, value: ex.Expression) -> str:
        """target = value, both in URScript's units."""
        match target:
            case ex.Named(name):
                return f"{name} = {self.value(value)}"
            case ex.Item(base, _) if self.kind(base) == "joints":
                return f"{self.element(target)} = {self.value(ex.scaled(value, deg))}"
            case ex.Item():
                return f"{self.element(target)} = {self.value(value)}"
            case ex.Member(base, name) if name in PLACES and self.kind(base) in ("", "position"):
                place = PLACES[name]
                written = self.value(self.metres(value) if place < 3 else value)
                return f"{self.value(base)}[{place}] = {written}"
            case ex.Member(base, "rx" | "ry" | "rz" as name) if self.kind(base) in ("", "position"):
                return self._angle_stored(base, name, value)
            case ex.Member(base, name) if self.kind(base) not in ("joints", "list"):
                return f"{self.value(base)}.{name} = {self.value(value)}"
            case ex.Function("pose-element"):
                return f"{self.value(target)} = {self.value(value)}"
        raise CannotSayError("storing a value there")

    def _angle_stored(self, base: ex.Expression, name: str, value: ex.Expression) -> str:
        """One angle of a pose changed: all six components anew."""
        parts = [ex.Member(base, part) for part in ("x", "y", "z")]
        angles = [value if part == name else ex.Member(base, part) for part in ("rx", "ry", "rz")]
        return f"{self.value(base)} = {self.helper('olp_pose', (*parts, *angles))}"

    def write_assign(self, s: st.Assign) -> Lines:
        return [self.stored(s.target, s.value)]

    def write_declare(self, s: st.Declare) -> Lines:
        if self.own:
            return [] if s.value is None else [self.declared(s, "local " if s.native == "local" else "")]
        return [self.declared(s, "local ")]

    # --- blocks -------------------------------------------------------------------------------------

    def body(self, statements: Sequence[st.Statement]) -> list[str]:
        if not self.own:
            self.idle.update((*_idle_loops(statements), *_idle_steps(statements)))
        return super().body(statements)

    def write_while(self, s: st.While) -> Lines:
        """A loop that asks signals and takes no time waits a step each time: the controller takes it for endless."""
        return [f"while ({self.value(s.condition)}):", *self._waited(s)]

    def write_if(self, s: st.If) -> Lines:
        """As `write_while`, where it is a step of a loop over numbered steps."""
        return [f"if ({self.value(s.condition)}):", *self._waited(s)]

    def write_else_if(self, s: st.ElseIf) -> Lines:
        return [f"elif ({self.value(s.condition)}):", *self._waited(s)]

    def _waited(self, s: st.Statement) -> list[str]:
        return ["  sync()"] if id(s) in self.idle else []

    def write_wait(self, s: st.Wait) -> Lines:
        condition = self.value(inverted(s.condition), 4)
        idle = "sleep(get_steptime())" if self.own and s.spelling == "sleep" else "sync()"
        if s.timeout is None:
            return [f"while ({condition}):", f"  {idle}", "end"]
        left = helpers.COUNTER
        return [
            f"{left} = {self.quantity(s.timeout)}",
            f"while ({left} > 0 and {condition}):",
            f"  {idle}",
            f"  {left} = {left} - get_steptime()",
            "end",
        ]

    # --- signals, time, messages --------------------------------------------------------------------

    def write_set_output(self, s: st.SetOutput) -> Lines:
        word = self.signal_function(builtins.OUTPUT_WORDS, s.signal)
        value = s.value
        if s.signal.bus != "analog-out" and value in (ex.Number(0), ex.Number(1)):
            value = ex.SignalState(value == ex.Number(1))
        return [f"{word}({self.value(s.signal.index)}, {self.value(value)})"]

    def write_pulse_output(self, s: st.PulseOutput) -> Lines:
        """A thread switches the output on and off again, for nothing here goes on by itself."""
        if s.condition is not None:
            raise CannotSayError("a pulse under a condition")
        switch = self.signal_function(builtins.OUTPUT_WORDS, s.signal)
        seconds = None if s.duration is None else s.duration.literal
        if s.signal.bus not in helpers.PULSED or type(s.signal.index) is not ex.Number or not seconds:
            raise CannotSayError("a pulse of a computed output, or of a time that is not known")
        name = helpers.pulse_name(s.signal, seconds)
        set_to = f"{switch}({self.value(s.signal.index)}"
        self.pulses[name] = (
            f"thread {name}():",
            f"  {set_to}, True)",
            f"  sleep({self.value(ex.Number(seconds))})",
            f"  {set_to}, False)",
            "end",
        )
        return [f"run {name}()"]

    def write_message(self, s: st.Message) -> Lines:
        text = s.text
        if self.own and type(text) is ex.Function and text.name == "joined-text" and len(text.arguments) == 2:
            return [f"textmsg({self.arguments(text.arguments)})"]
        return [f"textmsg({self.value(text)})"]

    def popup(self, options: st.Process | None, message: st.Message, blocking: bool) -> str:
        """popup(text, options …): of one or two statements that belong to it."""
        given = (
            [] if options is None else [f"{name}={self.value(value)}" for name, value in options.arguments]
        )
        more = ["blocking=True"] if blocking else []
        return f"popup({', '.join([self.value(message.text), *given, *more])})"

    def write_pause(self, s: st.Pause) -> Lines:
        return ['popup("", blocking=True)']

    # --- calls and threads --------------------------------------------------------------------------

    def write_call(self, s: st.Call) -> Lines:
        text = f"{s.routine}({self.arguments(s.arguments)})"
        if s.result is None:
            return [text]
        match s.result:
            case ex.Named(name):
                return [f"{name} = {text}"]
            case ex.Item(base, _) if self.kind(base) != "joints":
                return [f"{self.element(s.result)} = {text}"]
            case ex.Member(base, name) if self.kind(base) not in ("", "position"):
                return [f"{self.value(base)}.{name} = {text}"]
            case ex.Member(base, name) if name.startswith("rotation"):
                return [f"{self.value(base)}[{PLACES[name]}] = {text}"]
        raise CannotSayError("storing the result of a call there")

    def write_return(self, s: st.Return) -> Lines:
        if self.own and s.spelling == "halt":
            return ["halt"]
        return ["return" if s.value is None else f"return {self.value(s.value)}"]

    def write_start_task(self, s: st.StartTask) -> Lines:
        named = s.task.casefold() != s.routine.casefold()  # no variable is called as the thread is
        handle = f"{s.task} = " if s.task and (self.own or (named and s.task.isidentifier())) else ""
        return [f"{handle}run {s.routine}()"]

    def write_process(self, s: st.Process) -> Lines:
        match s.name:
            case "kill" | "run":
                return [f"{s.name} {self.value(s.arguments[0][1])}"]
            case "halt" | "enter_critical" | "exit_critical":
                return [s.name]
            case "sync" if s.arguments:
                return ["sleep(get_steptime())"]
        given = [f"{name}={self.value(value)}" if name else self.value(value) for name, value in s.arguments]
        return [f"{s.name}({', '.join(given)})"]

    def write_comment(self, s: st.Comment) -> Lines:
        """A comment on a line of its own, or a mark of PolyScope."""
        text = " ".join(s.text.splitlines())
        if self.own:
            return [text if text.startswith("$") else f"#{text}"]
        return [f"# {text.strip()}".rstrip()]

    def declared(self, s: st.Declare, scope: str) -> str:
        """`scope name = value`; what has no value gets the zero of its type."""
        value = _default(s) if s.value is None else self.value(s.value)
        return f"{scope}{s.name} = {value}"

    # --- bodies -----------------------------------------------------------------------------------------

    def _routine_rows(self, routine: st.Routine, depth: int) -> None:
        self.begin()
        self.depth, self._routine = depth, routine
        data = {one.name for one in self.program.data}
        # A name of the routine's own that the program has as well is its own wherever it gets a value.
        self._shadows = {
            one.name
            for one in routine.body
            if isinstance(one, st.Declare) and one.value is None and one.name in data
        }
        if not self.own:
            self.body(routine.data)
        self.body(routine.body)

    def add(self, s: st.Statement, lines: list[str]) -> None:
        if isinstance(s, st.Move):
            self.put(lines[:-1])
            self.put(lines[-1:], s.comment)
            return
        comment = getattr(s, "comment", "")
        if not lines and comment and not isinstance(s, st.Declare):
            lines, s = [f"# {_one_line(comment)}"], st.Comment(s.line, comment)
        super().add(s, [self._scoped(s, line) for line in lines])
        if isinstance(s, st.SetTool):
            self._tool, self._given = self.tool(s.tool), None

    def put(self, lines: list[str], comment: str = "") -> None:
        super().put(lines, _one_line(comment) if comment else "")

    def _scoped(self, s: st.Statement, line: str) -> str:
        """`global` or `local` before a name that gets its value here and nowhere above."""
        name = _stored_name(s)
        if name in self._shadows:
            return f"local {line}"
        return f"global {line}" if name in self.late and not self._is_own(name) else line

    def _is_own(self, name: str) -> bool:
        own = any(isinstance(one, st.Declare) and one.name == name for one in self._routine.body)
        return own or any(one.name == name for one in self._routine.parameters)

    def together(self, body: Sequence[st.Statement], place: int) -> Joined | None:
        """One popup, of an instruction, its message and a pause."""
        options, at = body[place], place
        if isinstance(options, st.Process):
            if options.name != "popup" or not self.own:
                return None
            at += 1
        message = body[at] if at < len(body) else None
        if not isinstance(message, st.Message):
            return None
        last = body[at + 1] if at + 1 < len(body) else None
        blocking = isinstance(last, st.Pause) and last.condition is None
        if not isinstance(options, st.Process) and not blocking:
            return None
        given = options if isinstance(options, st.Process) else None
        return Joined([self.popup(given, message, blocking)], at + 1 + blocking - place, message.comment)

    # --- the whole program ------------------------------------------------------------------------------

    def template_values(self) -> dict[str, object]:
        routines = self.program.routines
        main = next(
            (one for one in routines if one.name == self.program.main), routines[0] if routines else None
        )
        data = self._data()
        others = [one for one in routines if one is not main]
        functions = [self._function(one, 1) for one in others if one.details.get("kind") != "sec"]
        secondary = [self._function(one, 0) for one in others if one.details.get("kind") == "sec"]
        whole = UrscriptFunction("def program()", "", "") if main is None else self._function(main, 0)
        texts = [helpers.TEXTS[name] for name in helpers.TEXTS if name in self.used] + [*self.pulses.values()]
        return {
            "secondary": secondary,
            "program": whole,
            "data": data,
            "helpers": "".join(f"{self.step}{line}\n" for text in texts for line in text),
            "functions": functions,
        }

    def _data(self) -> str:
        lines = []
        for one in self.program.data:
            if self.own and one.value is None:
                continue
            try:
                declared = _noted(f"{self.step}{self.declared(one, 'global ')}", one.comment)
                lines += [*(f"{self.step}# {_one_line(text)}" for text in one.above), declared]
            except CannotSayError as problem:
                self.lose(problem, one.line)
        return as_text(lines)

    def _function(self, routine: st.Routine, depth: int) -> UrscriptFunction:
        kind = routine.details.get("kind", "def") if self.own else self._kind(routine)
        types = self.types
        self.types = {**types, **{one.name: one.type for one in routine.parameters}}
        for declare in routine.data:
            _note(self.types, declare)
        for statement in routine.body:
            if isinstance(statement, st.Declare):
                _note(self.types, statement)
        try:
            head = f"{kind} {routine.name}({self._parameters(routine)})"
            self._routine_rows(routine, depth + 1)
        finally:
            self.types = types
        return UrscriptFunction(head, _remark(routine.comment), as_text(self.rows))

    def _started(self) -> set[str]:
        """The routines that run beside the one that starts them."""
        found = (s.routine for one in self.program.routines for s in one.body if isinstance(s, st.StartTask))
        return {name.casefold() for name in found}

    def _kind(self, routine: st.Routine) -> str:
        """`run` takes a thread only, and a thread can neither be called nor be handed anything."""
        if routine.name.casefold() not in self.started:
            return "def"
        called = (s.routine for one in self.program.routines for s in one.body if isinstance(s, st.Call))
        if routine.name == self.program.main or any(
            name.casefold() == routine.name.casefold() for name in called
        ):
            problem = CannotSayError("a routine that is both called and started", "give it under two names")
            self.lose(problem, routine.line)
        if routine.parameters:
            self.lose(CannotSayError("a task that is handed something", "store it before"), routine.line)
        return "thread"

    def _parameters(self, routine: st.Routine) -> str:
        texts = []
        for one in routine.parameters:
            try:
                if one.by_reference:
                    raise CannotSayError(f"a parameter that is handed back ({one.name})", "return its value")
                if one.switch:
                    raise CannotSayError(f"a switch as a parameter ({one.name})")
                texts.append(one.name if one.default is None else f"{one.name}={self.value(one.default)}")
            except CannotSayError as problem:
                self.lose(problem, routine.line)
        return ", ".join(texts)


def _default(s: st.Declare) -> str:
    """The zero of a declaration's type. Raises CannotSayError for one of unknown size."""
    zero = _DEFAULTS.get(s.type, "0.0")
    for size in reversed(s.sizes):
        if type(size) is not ex.Number or not 0 <= size.value <= _MOST_ITEMS:
            raise CannotSayError(f"an array of unknown size ({s.name})")
        zero = f"[{', '.join([zero] * int(size.value))}]"
    return zero


def _stored_name(s: st.Statement) -> str:
    if isinstance(s, st.Assign) and isinstance(s.target, ex.Named):
        return s.target.name
    if isinstance(s, st.Call) and isinstance(s.result, ex.Named):
        return s.result.name
    return s.task if isinstance(s, st.StartTask) else ""


def _note(types: dict[str, str], declare: st.Declare) -> None:
    """What a name holds, and what its elements do."""
    array = bool(declare.sizes) or (_is_list(declare.value) and declare.type != "joints")
    types[declare.name] = "list" if array else _TYPES.get(declare.type, declare.type)
    if array:
        types[f"{declare.name}[]"] = _TYPES.get(declare.type, declare.type)


def _is_list(value: ex.Expression | None) -> bool:
    return isinstance(value, ex.RecordLiteral) and all(not name for name, _ in value.members)


def _noted(line: str, comment: str) -> str:
    return f"{line}{_remark(comment)}"


def _remark(comment: str) -> str:
    return f"  # {_one_line(comment)}" if comment else ""


def _one_line(text: str) -> str:
    return " ".join(text.splitlines()).strip()
