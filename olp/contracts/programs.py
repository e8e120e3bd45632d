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
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.points import PointTable

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

    def say(self, *statements: st.Statement) -> None:
        self.rows += statements


@dataclass(frozen=True, slots=True)
class Contract:
    """A program and what it does."""

    program: st.Program
    events: tuple[OracleEvent, ...]
    poses: dict[str, Array]  # of its points, as written: in their frames


def number(value: float, scale: float) -> ex.Quantity:
    return ex.Quantity(ex.Number(value), scale)


def literal(values: Six) -> ex.PositionLiteral:
    x, y, z, *turn = values
    return ex.PositionLiteral("pose", (x * MM, y * MM, z * MM, *(angle * DEG for angle in turn)))


def move(
    path: st.Path,
    target: ex.Expression,
    speed: float,
    blend: float,
    tool: str = "grip",
    base: str = "table",
    via: ex.Expression | None = None,
) -> st.Move:
    """`speed` [% of joint moves, mm/s], `blend` [mm]."""
    unit, scale = (st.SpeedUnit.FRACTION, PERCENT) if path is st.Path.JOINT else (st.SpeedUnit.TRAVEL, MM)
    return st.Move(
        0,
        path,
        (target,),
        st.Speed(unit, number(speed, scale)),
        st.Blend(st.BlendKind.RADIUS, number(blend, MM)),
        tool=ex.Named(tool),
        frame=ex.Named(base),
        via=via,
    )


def happens(
    path: st.Path,
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
    kind = {st.Path.JOINT: "joint", st.Path.LINEAR: "linear", st.Path.CIRCULAR: "arc"}[path]
    through = (frame(*FRAMES[base]) @ frame(*POINTS[via]))[:3, 3] if via else None
    more: dict[str, Any] = {"share": speed * PERCENT} if path is st.Path.JOINT else {"speed": speed * MM}
    return OracleEvent(
        kind, place, place @ np.linalg.inv(frame(*TOOLS[tool])), via=through, blend=blend * MM, **more
    )


def declarations(n: int) -> tuple[st.Declare, ...]:
    rows = [st.Declare(0, name, "tool", literal(v), storage="persistent") for name, v in TOOLS.items()]
    rows += [st.Declare(0, name, "frame", literal(v), storage="persistent") for name, v in FRAMES.items()]
    rows += [st.Declare(0, name, "position", literal(v), storage="constant") for name, v in POINTS.items()]
    for name, joints in (("home", HOME), ("away", AWAY)):
        value = ex.PositionLiteral("joint", tuple(angle * DEG for angle in joints))
        rows.append(st.Declare(0, name, "joints", value, storage="constant"))
    counters = {"n": n, "left": 3, "step": 8, "count": 6}
    rows += [st.Declare(0, name, "integer", ex.Number(value)) for name, value in counters.items()]
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
    program = st.Program("neutral", source, routines, data=declarations(n), main="MAINJOB")
    return Contract(program, tuple(main.events), {name: frame(*v) for name, v in POINTS.items()})


def _routine(name: str, rows: Sequence[Any], line: int) -> st.Routine:
    return st.Routine(
        name, line, tuple(replace(row, line=at) for at, row in enumerate(rows, line)), PointTable()
    )


def _joint(script: _Script, name: str, values: Six, speed: float) -> None:
    script.say(move(st.Path.JOINT, ex.Named(name), speed, 0))
    axes = tuple(angle * DEG for angle in values)
    script.events.append(OracleEvent("joint", axes=axes, share=speed * PERCENT, blend=0.0))


def _go(script: _Script, path: st.Path, point: str, speed: float, blend: float, **more: Any) -> None:
    named: dict[str, Any] = {key: ex.Named(value) if key == "via" else value for key, value in more.items()}
    script.say(move(path, ex.Named(point), speed, blend, **named))
    script.events.append(happens(path, point, speed, blend, **more))


def _output(script: _Script, signal: int, on: bool) -> None:
    script.say(st.SetOutput(0, ex.Signal("out", ex.Number(signal)), ex.SignalState(on)))
    script.events.append(OracleEvent("output", signal=signal, on=on))


def _input(script: _Script, signal: int, on: bool) -> None:
    script.say(st.Wait(0, ex.Compare("=", ex.Signal("in", ex.Number(signal)), ex.SignalState(on))))
    script.events.append(OracleEvent("input", signal=signal, on=on))


def _dwell(seconds: float) -> tuple[st.Dwell, OracleEvent]:
    return st.Dwell(0, number(seconds, 1.0)), OracleEvent("wait", seconds=seconds)


def _wait(script: _Script, seconds: float) -> None:
    statement, event = _dwell(seconds)
    script.say(statement)
    script.events.append(event)


def _approach(script: _Script) -> None:
    script.say(st.Comment(0, COMMENT))
    _joint(script, "home", HOME, 37)
    _output(script, 3, False)
    _joint(script, "away", AWAY, 62)
    _go(script, st.Path.JOINT, "over", 43, 25)
    _go(script, st.Path.LINEAR, "part", 237.5, 0)
    _output(script, 5, True)
    _wait(script, 0.65)
    _input(script, 4, True)


def _shapes(script: _Script) -> None:
    """Every path, with two tools, two frames, blends and exact stops."""
    _go(script, st.Path.LINEAR, "over", 141.2, 6)
    _go(script, st.Path.LINEAR, "edge", 313.4, 11, tool="probe")
    _go(script, st.Path.LINEAR, "shelf", 176.8, 0, base="rack")
    _go(script, st.Path.LINEAR, "last", 94.6, 4, tool="probe", base="rack")
    _output(script, 6, True)
    _output(script, 2, False)
    _go(script, st.Path.LINEAR, "part", 262.3, 0)
    _go(script, st.Path.CIRCULAR, "edge", 183.9, 7, via="middle")
    _go(script, st.Path.LINEAR, "last", 121.7, 0)
    counter = ex.Named("count")
    by = (ex.Binary("*", counter, ex.Number(7)), ex.Number(-13.5), ex.Binary("+", counter, ex.Number(17)))
    shifted = ex.Function("pose-offset", (ex.Named("part"), *by))
    script.say(st.For(0, counter, ex.Number(2), ex.Number(4)), move(st.Path.LINEAR, shifted, 158.6, 3))
    statement, event = _dwell(0.23)
    script.say(statement, st.Next(0, counter))
    for count in (2, 3, 4):
        shift = (count * 7.0, -13.5, count + 17.0)
        script.events += [happens(st.Path.LINEAR, "part", 158.6, 3, shift=shift), event]


def _branches(script: _Script, n: int) -> None:
    """If, else if, else: a call, a wait, a move."""
    wait, waited = _dwell(0.27)
    script.say(
        st.If(0, ex.Compare(">", ex.Named("n"), ex.Number(2))), st.Comment(0, "many"), st.Call(0, "SUBJOB")
    )
    script.say(st.ElseIf(0, ex.Compare("=", ex.Named("n"), ex.Number(2))), wait)
    script.say(st.Else(0), move(st.Path.LINEAR, ex.Named("over"), 207.1, 0), st.EndIf(0))
    if n == 2:
        script.events.append(waited)
    elif n < 2:
        script.events.append(happens(st.Path.LINEAR, "over", 207.1, 0))


def _called(script: _Script) -> list[OracleEvent]:
    _go(script, st.Path.LINEAR, "middle", 271.4, 5)
    _input(script, 8, False)
    _output(script, 7, True)
    script.say(st.Return(0))
    return script.events


def _after_branches(script: _Script, n: int) -> list[OracleEvent]:
    """Loops, a choice between values, a jump and logic, each of which takes a time of its own."""
    events: list[OracleEvent] = []
    left, number_ = ex.Named("left"), ex.Named("n")
    one, first = _dwell(0.33)
    script.say(
        st.While(0, ex.Compare(">", left, ex.Number(0))),
        st.Assign(0, left, ex.Binary("-", left, ex.Number(1))),
    )
    script.say(one, st.EndWhile(0))
    events += [first] * 3
    times = {1: 0.41, 5: 0.43, 0: 0.47}
    script.say(st.Switch(0, number_))
    for value, seconds in times.items():
        script.say(st.Case(0, (ex.Number(value),)) if value else st.Default(0), _dwell(seconds)[0])
    script.say(st.EndSwitch(0))
    events.append(_dwell(times.get(n, 0.47))[1])
    both = ex.Logic(
        ex.Compare("<", number_, ex.Number(5)),
        (("and", ex.Compare("<>", number_, ex.Number(1))),),
    )
    script.say(st.Jump(0, "SKIP", both), _dwell(0.58)[0], st.Label(0, "SKIP"))
    events += [] if n == 2 else [_dwell(0.58)[1]]
    either = ex.Logic(
        ex.Compare("<=", number_, ex.Number(1)),
        (("or", ex.Compare(">=", number_, ex.Number(5))),),
    )
    script.say(st.If(0, either), _dwell(0.71)[0], st.EndIf(0))
    events += [] if n == 2 else [_dwell(0.71)[1]]
    computed = ex.Binary(
        "-", ex.Binary("*", ex.Binary("+", ex.Named("step"), number_), ex.Number(3)), ex.Number(20)
    )
    script.say(st.Assign(0, ex.Named("step"), computed))
    for limit, seconds in ((5, 0.83), (8, 0.87), (15, 0.91)):
        script.say(
            st.If(0, ex.Compare(">", ex.Named("step"), ex.Number(limit))), _dwell(seconds)[0], st.EndIf(0)
        )
        events += [_dwell(seconds)[1]] if (8 + n) * 3 - 20 > limit else []
    end = _Script()
    _go(end, st.Path.JOINT, "last", 48, 0)
    _joint(end, "home", HOME, 29)
    script.rows += end.rows
    return [*events, *end.events]


# --- at the edges of what languages take --------------------------------------------------------------------------

_FAR: Final = (1.7e-7, 0.0123456, 0.618034, 3.14159, 2.34e5)
_MEASURES: Final = tuple(ex.Quantity(ex.Number(value), 1.0) for value in _FAR)  # in SI, of whatever
_NUMBERS: Final = tuple(map(ex.Number, (0, 1, 15, 64, 1000)))
_LONG: Final = "a_name_that_is_longer_than_any_controller_of_robots_takes_it_as_one_part"
_WORDS: Final = ("if", "MOVE", "_tail", "x-y", "2nd", "größe", _LONG, f"{_LONG}_2")
_TEXT: Final = "says 'this', \"that\"; 100 % of it {all} | and so on, " * 6


def _travels(path: st.Path, **more: Any) -> st.Move:
    """A move to the middle place of `program_with` that says all that languages ask for."""
    speed = st.Speed(
        st.SpeedUnit.FRACTION if path is st.Path.JOINT else st.SpeedUnit.TRAVEL,
        ex.Quantity(ex.Number(0.4), 1.0),
    )
    stop = st.Blend(st.BlendKind.RADIUS, ex.Quantity(ex.Number(0), MM))
    whole = st.Move(
        0,
        path,
        (ex.Named("p2"),),
        speed,
        stop,
        tool=ex.FrameRef("tool", ex.Number(0)),
        frame=ex.FrameRef("base"),
    )
    return replace(whole, **more)


def edge_statements() -> dict[str, tuple[st.Statement, ...]]:
    """Programs, for `program_with`, whose numbers, words and shapes no language, or not every one, can say."""
    return {**_edges_of_moves(), **_edges_of_signals(), **_edges_of_words(), **_edges_of_values()}


def _edges_of_moves() -> dict[str, tuple[st.Statement, ...]]:
    paths = (st.Path.JOINT, st.Path.LINEAR)
    rates = [st.Acceleration(unit, value) for unit in st.AccelerationUnit for value in _MEASURES]
    return {
        "speeds": tuple(
            _travels(p, speed=st.Speed(u, v)) for p in paths for u in st.SpeedUnit for v in _MEASURES
        ),
        "blends": tuple(
            _travels(p, blend=st.Blend(k, v)) for p in paths for k in st.BlendKind for v in _MEASURES
        ),
        "passes": tuple(_travels(p, blend=st.Blend(k)) for p in paths for k in st.BlendKind),
        "accelerations": (
            *(_travels(p, acceleration=v, deceleration=_MEASURES[2]) for p in paths for v in _MEASURES),
            *(_travels(p, rate=rate) for p in paths for rate in rates),
            *(one for rate in rates for one in (st.SetAcceleration(0, (rate,)), _travels(st.Path.LINEAR))),
        ),
        "turns": tuple(_travels(st.Path.LINEAR, turn=value) for value in _MEASURES),
        "overrides": tuple(st.SetOverride(0, value) for value in _MEASURES),
        "tools": tuple(_travels(st.Path.LINEAR, tool=ex.FrameRef("tool", n)) for n in _NUMBERS),
        "frames": tuple(_travels(st.Path.LINEAR, frame=ex.FrameRef("user", n)) for n in _NUMBERS),
    }


def _edges_of_signals() -> dict[str, tuple[st.Statement, ...]]:
    on, out = ex.SignalState(True), ex.Signal("out", ex.Number(3))
    far = ((0.0, 0.0123), (-0.4, 0.0), (-1.7, 0.03), (-3.9, -1.2), (0.0, 3.1), (0.0, -70.0), (0.9, -0.2))
    ways = [
        (start, ex.Quantity(ex.Number(m), 1.0), ex.Quantity(ex.Number(t), 1.0))
        for start in (True, False)
        for m, t in far
    ]
    switched = tuple(st.PathTrigger(out, on, *way) for way in ways)
    return {
        "times": (*(st.Dwell(0, v) for v in _MEASURES), *(st.PulseOutput(0, out, v) for v in _MEASURES)),
        "outputs": (
            *(st.SetOutput(0, ex.Signal(bus, n), on) for bus in ("out", "flag") for n in _NUMBERS),
            *(st.SetOutput(0, ex.Signal("analog-out", n), ex.Number(0.5)) for n in _NUMBERS),
            *(st.SetOutput(0, ex.Signal("out-group", n), ex.Number(5)) for n in _NUMBERS),
        ),
        "waits": tuple(
            st.Wait(0, ex.Compare("=", ex.Signal(bus, n), on), _MEASURES[2])
            for bus in ("in", "flag")
            for n in _NUMBERS
        ),
        "on the way": tuple(_travels(p, triggers=(one,)) for p in st.Path for one in switched),
        "many on the way": (_travels(st.Path.LINEAR, triggers=switched),),
    }


def _edges_of_words() -> dict[str, tuple[st.Statement, ...]]:
    n = ex.Named("n")
    return {
        "names": (
            *(st.Declare(0, word, "real", ex.Number(at), shared=True) for at, word in enumerate(_WORDS)),
            *(
                st.Assign(0, ex.Named(word), ex.Binary("+", ex.Named(word), ex.Number(0.25)))
                for word in _WORDS
            ),
            *(
                one
                for w in _WORDS
                for one in (st.Label(0, w), st.Jump(0, w, ex.Compare(">", n, ex.Number(1))))
            ),
            *(st.Call(0, word) for word in _WORDS),
        ),
        "texts": (
            *(one for text in (_TEXT, "") for one in (st.Comment(0, text), st.Message(0, ex.Text(text)))),
            _travels(st.Path.LINEAR, comment=_TEXT),
        ),
        "many": (
            *(st.Declare(0, f"many{at}", "real", ex.Number(at), shared=True) for at in range(310)),
            *(st.Update(0, "+", ex.Named(f"many{at}"), ex.Number(1)) for at in range(310)),
        ),
    }


def _edges_of_values() -> dict[str, tuple[st.Statement, ...]]:
    n, x = ex.Named("n"), ex.Named("x")
    words, signs = ("and", "or", "xor"), ("+", "-", "*", "/", "mod", "div")
    hits = [ex.Compare(">", n, ex.Number(value)) for value in (1, 2, 3)]
    read = st.ReadInput(0, n, ex.Signal("in-group", ex.Number(1)))
    logic = [ex.Logic(hits[0], ((a, ex.Logic(hits[1], ((b, hits[2]),))),)) for a in words for b in words]
    one, two = (
        ("sqrt", "abs", "sin", "cos", "tan", "atan", "round", "trunc"),
        ("atan2", "power", "min", "max"),
    )
    return {
        "numbers": (
            *(st.Assign(0, x, ex.Binary("*", ex.Number(sign * v), x)) for sign in (1, -1) for v in _FAR),
            *(st.Assign(0, n, ex.Number(value)) for value in (2**40, -(2**40))),
        ),
        "conditions": (
            read,
            *(part for c in logic for part in (st.If(0, c), st.Assign(0, x, n), st.EndIf(0))),
        ),
        "functions": (
            read,
            *(st.Assign(0, x, ex.Function(name, (x,))) for name in one),
            *(st.Assign(0, x, ex.Function(name, (x, n))) for name in two),
        ),
        "sums": (
            read,
            *(
                st.Assign(0, x, ex.Binary(a, ex.Binary("+", x, ex.Number(1)), ex.Binary(b, x, n)))
                for a in signs
                for b in ("-", "/", "mod")
            ),
        ),
        "loops": (
            read,
            *(
                part
                for step in (None, *map(ex.Number, (1, -1, 3, -2)), n)
                for part in (
                    st.For(0, ex.Named("i"), ex.Number(9), ex.Number(1), step),
                    st.Dwell(0, _MEASURES[2]),
                    st.Next(0, ex.Named("i")),
                )
            ),
        ),
    }


def two_of_a_name() -> Iterator[tuple[str, tuple[st.Statement, ...], tuple[st.Statement, ...]]]:
    """(what it shows, main routine and "OTHER" for `program_with`): variables of one name, each routine's own.

    How long a routine waits tells which value its variable has: 0.31 and 0.41 s if it is still its own.
    """
    call = st.Call(0, "OTHER")
    for kind in ("integer", "real"):
        for shown, name in (("two routines' own", "held"), ("a routine's own and the program's", "n")):
            held = ex.Named(name)
            mine, its = (st.Declare(0, name, kind, ex.Number(value)) for value in (3, 8))
            begin = (mine,) if name == "held" else (st.Assign(0, held, ex.Number(3)),)
            looks, others = _told_by_waits(held, 0.31, 0.37), _told_by_waits(held, 0.47, 0.41)
            yield f"variables named {name}, {kind}: {shown}", (*begin, call, *looks), (its, *others)
            late = replace(its, value=None), st.Assign(0, held, ex.Number(8))
            yield (
                f"variables named {name}, {kind}, set later: {shown}",
                (*begin, call, *looks),
                (*late, *others),
            )


def _told_by_waits(held: ex.Named, three: float, eight: float) -> tuple[st.Statement, ...]:
    """A wait [s] for each of the two values that a variable may have."""
    return tuple(
        one
        for value, seconds in ((3, three), (8, eight))
        for one in (
            st.If(0, ex.Compare("=", held, ex.Number(value))),
            st.Dwell(0, ex.Quantity(ex.Number(seconds), 1.0)),
            st.EndIf(0),
        )
    )


def fields_that_count() -> Iterator[tuple[str, tuple[st.Statement, ...], tuple[st.Statement, ...]]]:
    """(statement and field, programs for `program_with` without and with it): what changes what a statement does."""
    half, slow = ex.Quantity(ex.Number(0.5), 1.0), ex.Quantity(ex.Number(0.25), 1.0)
    asked = ex.Compare("=", ex.Signal("in", ex.Number(2)), ex.SignalState(True))
    place = ex.PositionLiteral("pose", (0.0, 0.01, 0.02, 0.0, 0.0, 0.0))
    turned = ex.PositionLiteral("pose", (0.9, 0.0, 0.5, 3.0, 0.1, 1.4))
    moves: dict[str, Any] = {
        "acceleration": half, "deceleration": half, "until": asked, "no_wait": True, "offset": place,
        "search": st.Search(ex.Signal("in", ex.Number(2)), True), "tool_offset": place, "coordinated": True,
        "other": (("XWORD", ex.Number(1)),), "relative": ex.FrameRef("tool"),
        "triggers": (
            st.PathTrigger(
                ex.Signal("out", ex.Number(3)), ex.SignalState(True), True, ex.Quantity(ex.Number(0.02), 1.0)
            ),
        ),
    }  # fmt: skip
    lines = {"rate": st.Acceleration(st.AccelerationUnit.TRAVEL, slow), "turn": half}
    for path in (st.Path.JOINT, st.Path.LINEAR):
        for name, value in {**moves, **(lines if path is st.Path.LINEAR else {})}.items():
            start, plain = _travels(path, targets=(turned,)), _travels(path)
            changed: dict[str, Any] = {name: value}
            yield f"Move {path.value} with {name}", (start, plain), (start, replace(plain, **changed))
    places = [
        ex.PositionLiteral("pose", (0.9, 0.06, 0.5, 3.0, 0.1, 0.2), external) for external in ((), (120.0,))
    ]
    bare, tracked = ((_travels(st.Path.LINEAR, targets=(place,)),) for place in places)
    yield "Move linear to a position with an external axis", bare, tracked
    others: tuple[tuple[st.Statement, dict[str, Any]], ...] = (
        (st.Wait(0, asked), {"timeout": half}),
        (st.PulseOutput(0, ex.Signal("out", ex.Number(3)), half), {"condition": asked}),
        (st.Call(0, "OTHER"), {"condition": asked, "result": ex.Named("n"), "macro": ex.Number(7)}),
        (st.Return(0), {"condition": asked}),
        (st.Pause(0), {"condition": asked}),
        (st.StartTask(0, "OTHER", "SUB1"), {"condition": asked, "synchronised": True}),
        (st.SetOverride(0, half), {"fastest": ex.Quantity(ex.Number(0.1), 1.0)}),
    )
    for s, values in others:
        end = (_travels(st.Path.LINEAR, speed=st.Speed(st.SpeedUnit.TRAVEL, half)),)
        for name, value in values.items():
            yield f"{type(s).__name__} with {name}", (s, *end), (replace(s, **{name: value}), *end)
