"""The contract program: one neutral program with generic numbers, and what happens when it runs.

Program and events are built side by side from the same numbers, by different code: the events come from `oracle`, so
they do not pass through any reader, writer, pass or interpreter. No number is zero, round or used twice, and no angle
is right, so that a swapped, dropped or wrongly scaled one shows.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from olp.contracts.events import OracleEvent
from olp.contracts.oracle import DEG, MM, Array, frame
from olp.core.source import decode
from olp.ir.expressions import (
    Binary,
    Compare,
    Expression,
    FrameRef,
    Function,
    Logic,
    Named,
    Number,
    PositionLiteral,
    Quantity,
    Signal,
    SignalState,
    Text,
)
from olp.ir.points import PointTable
from olp.ir.program import (
    Acceleration,
    AccelerationUnit,
    Assign,
    Blend,
    BlendKind,
    Call,
    Case,
    Comment,
    Declare,
    Default,
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
    Move,
    Next,
    Path,
    PathTrigger,
    Pause,
    Program,
    PulseOutput,
    ReadInput,
    Return,
    Routine,
    Search,
    SetAcceleration,
    SetOutput,
    SetOverride,
    Speed,
    SpeedUnit,
    StartTask,
    Statement,
    Switch,
    Update,
    Wait,
    While,
)

PERCENT: Final = 0.01
COMMENT: Final = "hands over"  # short, and of letters that every controller has
BRANCHES: Final = (1, 2, 5)  # values of `n` that between them take every branch

Six = tuple[float, float, float, float, float, float]
TOOLS: Final[dict[str, Six]] = {
    "grip": (13.2, -7.6, 171.9, 11.3, 6.7, 28.4),
    "probe": (-28.3, 5.9, 208.6, -8.2, 12.6, -41.7),
}
FRAMES: Final[dict[str, Six]] = {
    "table": (841.3, -163.7, 287.4, 1.7, -2.3, 34.6),
    "rack": (769.8, 182.6, 341.2, -2.6, 1.4, -57.3),
}
HOME: Final[Six] = (7.3, -13.6, 19.4, 4.7, -52.8, 23.9)  # [deg]
AWAY: Final[Six] = (-21.7, 8.9, -11.2, -6.4, -43.1, 57.6)  # [deg]
POINTS: Final[dict[str, Six]] = {
    "over": (31.746, -22.513, 48.392, 174.371, 3.918, -21.637),
    "part": (31.284, -23.857, 12.619, 173.526, 4.683, -19.248),
    "edge": (-37.158, 26.493, 18.736, -175.294, -5.172, 16.859),
    "middle": (-12.647, 43.921, 37.285, 176.183, 2.746, 9.531),
    "shelf": (19.362, 31.748, 24.517, 172.648, -6.291, 38.127),
    "last": (-24.835, -17.269, 33.854, -174.762, 5.829, -27.413),
}


@dataclass(slots=True)
class _Script:
    """Statements and the events that they make, in order."""

    rows: list[Any] = field(default_factory=list)
    events: list[OracleEvent] = field(default_factory=list)

    def say(self, *statements: Statement) -> None:
        self.rows += statements


@dataclass(frozen=True, slots=True)
class Contract:
    """A program and what it does."""

    program: Program
    events: tuple[OracleEvent, ...]
    poses: dict[str, Array]  # of its points, as written: in their frames


def number(value: float, scale: float) -> Quantity:
    return Quantity(Number(value), scale)


def literal(values: Six) -> PositionLiteral:
    x, y, z, *turn = values
    return PositionLiteral("pose", (x * MM, y * MM, z * MM, *(angle * DEG for angle in turn)))


def move(
    path: Path,
    target: Expression,
    speed: float,
    blend: float,
    tool: str = "grip",
    base: str = "table",
    via: Expression | None = None,
) -> Move:
    """`speed` [% of joint moves, mm/s], `blend` [mm]."""
    unit, scale = (SpeedUnit.FRACTION, PERCENT) if path is Path.JOINT else (SpeedUnit.TRAVEL, MM)
    return Move(
        0,
        path,
        (target,),
        Speed(unit, number(speed, scale)),
        Blend(BlendKind.RADIUS, number(blend, MM)),
        tool=Named(tool),
        frame=Named(base),
        via=via,
    )


def happens(
    path: Path,
    point: str,
    speed: float,
    blend: float,
    tool: str = "grip",
    base: str = "table",
    via: str = "",
    shift: Sequence[float] = (0.0, 0.0, 0.0),
) -> OracleEvent:
    """The event of `move`, from the same numbers by other code. `shift` [mm]: added in the frame."""
    there = frame(*POINTS[point])
    there[:3, 3] += np.array(shift) * MM
    place = frame(*FRAMES[base]) @ there
    kind = {Path.JOINT: "joint", Path.LINEAR: "linear", Path.CIRCULAR: "arc"}[path]
    through = (frame(*FRAMES[base]) @ frame(*POINTS[via]))[:3, 3] if via else None
    more: dict[str, Any] = {"share": speed * PERCENT} if path is Path.JOINT else {"speed": speed * MM}
    return OracleEvent(
        kind, place, place @ np.linalg.inv(frame(*TOOLS[tool])), via=through, blend=blend * MM, **more
    )


def declarations(n: int) -> tuple[Declare, ...]:
    rows = [Declare(0, name, "tool", literal(v), storage="persistent") for name, v in TOOLS.items()]
    rows += [Declare(0, name, "frame", literal(v), storage="persistent") for name, v in FRAMES.items()]
    rows += [Declare(0, name, "position", literal(v), storage="constant") for name, v in POINTS.items()]
    for name, joints in (("home", HOME), ("away", AWAY)):
        value = PositionLiteral("joint", tuple(angle * DEG for angle in joints))
        rows.append(Declare(0, name, "joints", value, storage="constant"))
    counters = {"n": n, "left": 3, "step": 8, "count": 6}
    rows += [Declare(0, name, "integer", Number(value)) for name, value in counters.items()]
    return tuple(replace(row, shared=True) for row in rows)


def contract_program(n: int) -> Contract:
    """The program that starts with `n`, one of BRANCHES."""
    main, sub = _Script(), _Script()
    _approach(main)
    _shapes(main)
    _branches(main, n)
    if n > 2:
        main.events += _called(sub)
    else:
        _called(sub)
    main.events += _after_branches(main, n)
    source = decode(b"\n" * 1000, "", "cp1252")
    routines = (_routine("MAINJOB", main.rows, 1), _routine("SUBJOB", sub.rows, 500))
    program = Program("neutral", source, routines, data=declarations(n), main="MAINJOB")
    return Contract(program, tuple(main.events), {name: frame(*v) for name, v in POINTS.items()})


def _routine(name: str, rows: Sequence[Any], line: int) -> Routine:
    return Routine(
        name, line, tuple(replace(row, line=at) for at, row in enumerate(rows, line)), PointTable()
    )


def _joint(script: _Script, name: str, values: Six, speed: float) -> None:
    script.say(move(Path.JOINT, Named(name), speed, 0))
    axes = tuple(angle * DEG for angle in values)
    script.events.append(OracleEvent("joint", axes=axes, share=speed * PERCENT, blend=0.0))


def _go(script: _Script, path: Path, point: str, speed: float, blend: float, **more: Any) -> None:
    named: dict[str, Any] = {key: Named(value) if key == "via" else value for key, value in more.items()}
    script.say(move(path, Named(point), speed, blend, **named))
    script.events.append(happens(path, point, speed, blend, **more))


def _output(script: _Script, signal: int, on: bool) -> None:
    script.say(SetOutput(0, Signal("out", Number(signal)), SignalState(on)))
    script.events.append(OracleEvent("output", signal=signal, on=on))


def _input(script: _Script, signal: int, on: bool) -> None:
    script.say(Wait(0, Compare("=", Signal("in", Number(signal)), SignalState(on))))
    script.events.append(OracleEvent("input", signal=signal, on=on))


def _dwell(seconds: float) -> tuple[Dwell, OracleEvent]:
    return Dwell(0, number(seconds, 1.0)), OracleEvent("wait", seconds=seconds)


def _wait(script: _Script, seconds: float) -> None:
    statement, event = _dwell(seconds)
    script.say(statement)
    script.events.append(event)


def _approach(script: _Script) -> None:
    script.say(Comment(0, COMMENT))
    _joint(script, "home", HOME, 37)
    _output(script, 3, False)
    _joint(script, "away", AWAY, 62)
    _go(script, Path.JOINT, "over", 43, 25)
    _go(script, Path.LINEAR, "part", 237.5, 0)
    _output(script, 5, True)
    _wait(script, 0.65)
    _input(script, 4, True)


def _shapes(script: _Script) -> None:
    """Every path, with two tools, two frames, blends and exact stops."""
    _go(script, Path.LINEAR, "over", 141.2, 6)
    _go(script, Path.LINEAR, "edge", 313.4, 11, tool="probe")
    _go(script, Path.LINEAR, "shelf", 176.8, 0, base="rack")
    _go(script, Path.LINEAR, "last", 94.6, 4, tool="probe", base="rack")
    _output(script, 6, True)
    _output(script, 2, False)
    _go(script, Path.LINEAR, "part", 262.3, 0)
    _go(script, Path.CIRCULAR, "edge", 183.9, 7, via="middle")
    _go(script, Path.LINEAR, "last", 121.7, 0)
    counter = Named("count")
    by = (Binary("*", counter, Number(7)), Number(-13.5), Binary("+", counter, Number(17)))
    shifted = Function("pose-offset", (Named("part"), *by))
    script.say(For(0, counter, Number(2), Number(4)), move(Path.LINEAR, shifted, 158.6, 3))
    statement, event = _dwell(0.23)
    script.say(statement, Next(0, counter))
    for count in (2, 3, 4):
        shift = (count * 7.0, -13.5, count + 17.0)
        script.events += [happens(Path.LINEAR, "part", 158.6, 3, shift=shift), event]


def _branches(script: _Script, n: int) -> None:
    """If, else if, else: a call, a wait, a move."""
    wait, waited = _dwell(0.27)
    script.say(If(0, Compare(">", Named("n"), Number(2))), Comment(0, "many"), Call(0, "SUBJOB"))
    script.say(ElseIf(0, Compare("=", Named("n"), Number(2))), wait)
    script.say(Else(0), move(Path.LINEAR, Named("over"), 207.1, 0), EndIf(0))
    if n == 2:
        script.events.append(waited)
    elif n < 2:
        script.events.append(happens(Path.LINEAR, "over", 207.1, 0))


def _called(script: _Script) -> list[OracleEvent]:
    _go(script, Path.LINEAR, "middle", 271.4, 5)
    _input(script, 8, False)
    _output(script, 7, True)
    script.say(Return(0))
    return script.events


def _after_branches(script: _Script, n: int) -> list[OracleEvent]:
    """Loops, a choice between values, a jump and logic, each of which takes a time of its own."""
    events: list[OracleEvent] = []
    left, number_ = Named("left"), Named("n")
    one, first = _dwell(0.33)
    script.say(While(0, Compare(">", left, Number(0))), Assign(0, left, Binary("-", left, Number(1))))
    script.say(one, EndWhile(0))
    events += [first] * 3
    times = {1: 0.41, 5: 0.43, 0: 0.47}
    script.say(Switch(0, number_))
    for value, seconds in times.items():
        script.say(Case(0, (Number(value),)) if value else Default(0), _dwell(seconds)[0])
    script.say(EndSwitch(0))
    events.append(_dwell(times.get(n, 0.47))[1])
    both = Logic(
        Compare("<", number_, Number(5)),
        (("and", Compare("<>", number_, Number(1))),),
    )
    script.say(Jump(0, "SKIP", both), _dwell(0.58)[0], Label(0, "SKIP"))
    events += [] if n == 2 else [_dwell(0.58)[1]]
    either = Logic(
        Compare("<=", number_, Number(1)),
        (("or", Compare(">=", number_, Number(5))),),
    )
    script.say(If(0, either), _dwell(0.71)[0], EndIf(0))
    events += [] if n == 2 else [_dwell(0.71)[1]]
    computed = Binary("-", Binary("*", Binary("+", Named("step"), number_), Number(3)), Number(20))
    script.say(Assign(0, Named("step"), computed))
    for limit, seconds in ((5, 0.83), (8, 0.87), (15, 0.91)):
        script.say(If(0, Compare(">", Named("step"), Number(limit))), _dwell(seconds)[0], EndIf(0))
        events += [_dwell(seconds)[1]] if (8 + n) * 3 - 20 > limit else []
    end = _Script()
    _go(end, Path.JOINT, "last", 48, 0)
    _joint(end, "home", HOME, 29)
    script.rows += end.rows
    return [*events, *end.events]


# --- at the edges of what languages take --------------------------------------------------------------------------

_FAR: Final = (1.7e-7, 0.0123456, 0.618034, 3.14159, 2.34e5)
_MEASURES: Final = tuple(Quantity(Number(value), 1.0) for value in _FAR)  # in SI, of whatever
_NUMBERS: Final = tuple(map(Number, (0, 1, 15, 64, 1000)))
_LONG: Final = "a_name_that_is_longer_than_any_controller_of_robots_takes_it_as_one_part"
_WORDS: Final = ("if", "MOVE", "_tail", "x-y", "2nd", "größe", _LONG, f"{_LONG}_2")
_TEXT: Final = "says 'this', \"that\"; 100 % of it {all} | and so on, " * 6


def _travels(path: Path, **more: Any) -> Move:
    """A move to the middle place of `program_with` that says all that languages ask for."""
    speed = Speed(SpeedUnit.FRACTION if path is Path.JOINT else SpeedUnit.TRAVEL, Quantity(Number(0.4), 1.0))
    stop = Blend(BlendKind.RADIUS, Quantity(Number(0), MM))
    whole = Move(
        0, path, (Named("p2"),), speed, stop, tool=FrameRef("tool", Number(0)), frame=FrameRef("base")
    )
    return replace(whole, **more)


def edge_statements() -> dict[str, tuple[Statement, ...]]:
    """Programs, for `program_with`, whose numbers, words and shapes no language, or not every one, can say."""
    return {**_edges_of_moves(), **_edges_of_signals(), **_edges_of_words(), **_edges_of_values()}


def _edges_of_moves() -> dict[str, tuple[Statement, ...]]:
    paths = (Path.JOINT, Path.LINEAR)
    rates = [Acceleration(unit, value) for unit in AccelerationUnit for value in _MEASURES]
    return {
        "speeds": tuple(_travels(p, speed=Speed(u, v)) for p in paths for u in SpeedUnit for v in _MEASURES),
        "blends": tuple(_travels(p, blend=Blend(k, v)) for p in paths for k in BlendKind for v in _MEASURES),
        "passes": tuple(_travels(p, blend=Blend(k)) for p in paths for k in BlendKind),
        "accelerations": (
            *(_travels(p, acceleration=v, deceleration=_MEASURES[2]) for p in paths for v in _MEASURES),
            *(_travels(p, rate=rate) for p in paths for rate in rates),
            *(one for rate in rates for one in (SetAcceleration(0, (rate,)), _travels(Path.LINEAR))),
        ),
        "turns": tuple(_travels(Path.LINEAR, turn=value) for value in _MEASURES),
        "overrides": tuple(SetOverride(0, value) for value in _MEASURES),
        "tools": tuple(_travels(Path.LINEAR, tool=FrameRef("tool", n)) for n in _NUMBERS),
        "frames": tuple(_travels(Path.LINEAR, frame=FrameRef("user", n)) for n in _NUMBERS),
    }


def _edges_of_signals() -> dict[str, tuple[Statement, ...]]:
    on, out = SignalState(True), Signal("out", Number(3))
    far = ((0.0, 0.0123), (-0.4, 0.0), (-1.7, 0.03), (-3.9, -1.2), (0.0, 3.1), (0.0, -70.0), (0.9, -0.2))
    ways = [
        (start, Quantity(Number(m), 1.0), Quantity(Number(t), 1.0)) for start in (True, False) for m, t in far
    ]
    switched = tuple(PathTrigger(out, on, *way) for way in ways)
    return {
        "times": (*(Dwell(0, v) for v in _MEASURES), *(PulseOutput(0, out, v) for v in _MEASURES)),
        "outputs": (
            *(SetOutput(0, Signal(bus, n), on) for bus in ("out", "flag") for n in _NUMBERS),
            *(SetOutput(0, Signal("analog-out", n), Number(0.5)) for n in _NUMBERS),
            *(SetOutput(0, Signal("out-group", n), Number(5)) for n in _NUMBERS),
        ),
        "waits": tuple(
            Wait(0, Compare("=", Signal(bus, n), on), _MEASURES[2])
            for bus in ("in", "flag")
            for n in _NUMBERS
        ),
        "on the way": tuple(_travels(p, triggers=(one,)) for p in Path for one in switched),
        "many on the way": (_travels(Path.LINEAR, triggers=switched),),
    }


def _edges_of_words() -> dict[str, tuple[Statement, ...]]:
    n = Named("n")
    return {
        "names": (
            *(Declare(0, word, "real", Number(at), shared=True) for at, word in enumerate(_WORDS)),
            *(Assign(0, Named(word), Binary("+", Named(word), Number(0.25))) for word in _WORDS),
            *(one for w in _WORDS for one in (Label(0, w), Jump(0, w, Compare(">", n, Number(1))))),
            *(Call(0, word) for word in _WORDS),
        ),
        "texts": (
            *(one for text in (_TEXT, "") for one in (Comment(0, text), Message(0, Text(text)))),
            _travels(Path.LINEAR, comment=_TEXT),
        ),
        "many": (
            *(Declare(0, f"many{at}", "real", Number(at), shared=True) for at in range(310)),
            *(Update(0, "+", Named(f"many{at}"), Number(1)) for at in range(310)),
        ),
    }


def _edges_of_values() -> dict[str, tuple[Statement, ...]]:
    n, x = Named("n"), Named("x")
    words, signs = ("and", "or", "xor"), ("+", "-", "*", "/", "mod", "div")
    hits = [Compare(">", n, Number(value)) for value in (1, 2, 3)]
    read = ReadInput(0, n, Signal("in-group", Number(1)))
    logic = [Logic(hits[0], ((a, Logic(hits[1], ((b, hits[2]),))),)) for a in words for b in words]
    one, two = (
        ("sqrt", "abs", "sin", "cos", "tan", "atan", "round", "trunc"),
        ("atan2", "power", "min", "max"),
    )
    return {
        "numbers": (
            *(Assign(0, x, Binary("*", Number(sign * v), x)) for sign in (1, -1) for v in _FAR),
            *(Assign(0, n, Number(value)) for value in (2**40, -(2**40))),
        ),
        "conditions": (read, *(part for c in logic for part in (If(0, c), Assign(0, x, n), EndIf(0)))),
        "functions": (
            read,
            *(Assign(0, x, Function(name, (x,))) for name in one),
            *(Assign(0, x, Function(name, (x, n))) for name in two),
        ),
        "sums": (
            read,
            *(
                Assign(0, x, Binary(a, Binary("+", x, Number(1)), Binary(b, x, n)))
                for a in signs
                for b in ("-", "/", "mod")
            ),
        ),
        "loops": (
            read,
            *(
                part
                for step in (None, *map(Number, (1, -1, 3, -2)), n)
                for part in (
                    For(0, Named("i"), Number(9), Number(1), step),
                    Dwell(0, _MEASURES[2]),
                    Next(0, Named("i")),
                )
            ),
        ),
    }


def fields_that_count() -> Iterator[tuple[str, tuple[Statement, ...], tuple[Statement, ...]]]:
    """(statement and field, programs for `program_with` without and with it): what changes what a statement does."""
    half, slow = Quantity(Number(0.5), 1.0), Quantity(Number(0.25), 1.0)
    asked = Compare("=", Signal("in", Number(2)), SignalState(True))
    place = PositionLiteral("pose", (0.0, 0.01, 0.02, 0.0, 0.0, 0.0))
    turned = PositionLiteral("pose", (0.9, 0.0, 0.5, 3.0, 0.1, 1.4))
    moves: dict[str, Any] = {
        "acceleration": half, "deceleration": half, "until": asked, "no_wait": True, "offset": place,
        "search": Search(Signal("in", Number(2)), True), "tool_offset": place, "coordinated": True,
        "other": (("XWORD", Number(1)),), "relative": FrameRef("tool"),
        "triggers": (PathTrigger(Signal("out", Number(3)), SignalState(True), True, Quantity(Number(0.02), 1.0)),),
    }  # fmt: skip
    lines = {"rate": Acceleration(AccelerationUnit.TRAVEL, slow), "turn": half}
    for path in (Path.JOINT, Path.LINEAR):
        for name, value in {**moves, **(lines if path is Path.LINEAR else {})}.items():
            start, plain = _travels(path, targets=(turned,)), _travels(path)
            yield f"Move {path.value} with {name}", (start, plain), (start, replace(plain, **{name: value}))
    places = [
        PositionLiteral("pose", (0.9, 0.06, 0.5, 3.0, 0.1, 0.2), external) for external in ((), (120.0,))
    ]
    bare, tracked = ((_travels(Path.LINEAR, targets=(place,)),) for place in places)
    yield "Move linear to a position with an external axis", bare, tracked
    others: tuple[tuple[Statement, dict[str, Any]], ...] = (
        (Wait(0, asked), {"timeout": half}),
        (PulseOutput(0, Signal("out", Number(3)), half), {"condition": asked}),
        (Call(0, "OTHER"), {"condition": asked, "result": Named("n"), "macro": Number(7)}),
        (Return(0), {"condition": asked}),
        (Pause(0), {"condition": asked}),
        (StartTask(0, "OTHER", "SUB1"), {"condition": asked, "synchronised": True}),
        (SetOverride(0, half), {"fastest": Quantity(Number(0.1), 1.0)}),
    )
    for s, values in others:
        end = (_travels(Path.LINEAR, speed=Speed(SpeedUnit.TRAVEL, half)),)
        for name, value in values.items():
            yield f"{type(s).__name__} with {name}", (s, *end), (replace(s, **{name: value}), *end)
