"""Random programs of a language: made neutral, then written and read again, so that they are that language's own."""

from __future__ import annotations

import math
import random
import tempfile
from dataclasses import replace
from pathlib import Path as FilePath

import olp
from olp.core.source import decode
from olp.fluent import Program
from olp.ir.expressions import (
    Binary,
    Compare,
    Function,
    Logic,
    Named,
    Number,
    PositionLiteral,
    Quantity,
    Signal,
    SignalState,
)
from olp.ir.points import PointTable
from olp.ir.program import (
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
    Move,
    Next,
    Path,
    Return,
    Routine,
    SetOutput,
    Speed,
    SpeedUnit,
    Switch,
    Wait,
    While,
)
from olp.runtime.plan import Plan
from olp.transpile import Context
from olp.transpile.compare import compare_plans, steps_of
from olp.transpile.convert import convert
from olp.transpile.link import link

MM, PERCENT = 0.001, 0.01
STOP = Blend(BlendKind.RADIUS, Quantity(Number(0), MM))


class Maker:
    """One random program from a seed."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.points: list[str] = []
        self.data: list[Declare] = []
        self.labels = 0

    def number(self, low: float, high: float, decimals: int = 2) -> float:
        return round(self.random.uniform(low, high), decimals)

    def pose(
        self, low: tuple[float, ...], high: tuple[float, ...], turns: tuple[float, ...]
    ) -> PositionLiteral:
        place = [self.number(a, b, 3) * MM for a, b in zip(low, high, strict=True)]
        angles = [math.radians(self.number(-a, a, 4)) for a in turns]
        return PositionLiteral("pose", (*place, *angles))

    def declare(self, name: str, kind: str, value: object, storage: str = "constant") -> Named:
        self.data.append(Declare(0, name, kind, value, storage=storage, shared=True))  # type: ignore[arg-type]
        return Named(name)

    def point(self) -> Named:
        place = self.pose((-60, -60, -40), (60, 60, 40), (8, 8, 20))
        turned = (*place.values[:3], place.values[3] + math.pi * 0.97, *place.values[4:])
        return self.declare(f"pt{len(self.data)}", "position", replace(place, values=turned))

    def program(self) -> Program:
        self.tools = [
            self.declare(
                f"tl{n}", "tool", self.pose((-40, -40, 120), (40, 40, 220), (15, 15, 60)), "persistent"
            )
            for n in (1, 2)
        ]
        self.frames = [
            self.declare(
                f"fr{n}", "frame", self.pose((700, -250, 200), (950, 250, 450), (3, 3, 90)), "persistent"
            )
            for n in (1, 2)
        ]
        self.n = self.declare("n", "integer", Number(self.random.randint(1, 4)), "variable")
        self.i = self.declare("i", "integer", Number(0), "variable")
        home = [math.radians(self.number(-40, 40)) for _ in range(4)] + [math.radians(-60.0), 0.3]
        home_at = self.declare("home", "joints", PositionLiteral("joint", tuple(home)))
        rows = [self.move(Path.JOINT, home_at), *self.block(2)]
        calls = self.random.random() < 0.6
        if calls:
            rows += [Call(0, "SUBJOB"), *self.block(1)]
        routines = [self.routine("MAINJOB", [*rows, self.move(Path.JOINT, home_at)], 1)]
        if calls:
            routines.append(self.routine("SUBJOB", [*self.block(1), Return(0)], 500))
        return Program(
            "neutral",
            decode(b"\n" * 1000, "random", "cp1252"),
            tuple(routines),
            data=tuple(self.data),
            main="MAINJOB",
        )

    def routine(self, name: str, rows: list[object], line: int) -> Routine:
        body = tuple(replace(s, line=at) for at, s in enumerate(rows, line))  # type: ignore[type-var]
        return Routine(name, line, body, PointTable())  # type: ignore[arg-type]

    # --- statements -------------------------------------------------------------------------------------

    def block(self, depth: int) -> list[object]:
        rows: list[object] = []
        for _ in range(self.random.randint(2, 5)):
            rows += self.one(depth)
        return rows

    def one(self, depth: int) -> list[object]:
        simple = [
            self.moves,
            self.moves,
            self.moves,
            self.arc,
            self.signal,
            self.dwell,
            self.wait,
            self.count,
            self.offset,
        ]
        nested = [self.branch, self.loop, self.endless, self.choice, self.skip] if depth else []
        chosen = self.random.choice([*simple, *nested])
        return chosen(depth - 1) if chosen in nested else chosen()

    def move(self, path: Path, target: object, **more: object) -> Move:
        joint = path is Path.JOINT
        unit = SpeedUnit.FRACTION if joint else SpeedUnit.TRAVEL
        speed = Speed(unit, Quantity(Number(self.random.randint(5, 100)), PERCENT))
        if not joint:
            speed = Speed(unit, Quantity(Number(self.number(20, 600, 1)), MM))
        blend = STOP
        if not joint and self.random.random() < 0.5:
            blend = Blend(BlendKind.RADIUS, Quantity(Number(self.random.randint(1, 15)), MM))
        return Move(
            0,
            path,
            (target,),
            speed,
            blend,
            tool=self.random.choice(self.tools),
            frame=self.random.choice(self.frames),
            **more,
        )  # type: ignore[arg-type]

    def moves(self) -> list[object]:
        path = self.random.choice([Path.JOINT, Path.LINEAR, Path.LINEAR])
        return [self.move(path, self.point())]

    def offset(self) -> list[object]:
        by = [
            Binary("*", Named("n"), Number(self.random.randint(2, 9))),
            Number(0),
            Number(self.number(-20, 20, 1)),
        ]
        self.random.shuffle(by)
        return [self.move(Path.LINEAR, Function("pose-offset", (self.point(), *by)))]

    def arc(self) -> list[object]:
        start = self.move(Path.LINEAR, self.point())
        end = replace(
            self.move(Path.CIRCULAR, self.point()), via=self.point(), tool=start.tool, frame=start.frame
        )
        return [start, end]

    def signal(self) -> list[object]:
        return [
            SetOutput(
                0, Signal("out", Number(self.random.randint(1, 7))), SignalState(self.random.random() < 0.5)
            )
        ]

    def dwell(self) -> list[object]:
        return [Dwell(0, Quantity(Number(self.number(0.05, 2)), 1.0)), Comment(0, "a while")]

    def wait(self) -> list[object]:
        return [
            Wait(
                0,
                Compare(
                    "=",
                    Signal("in", Number(self.random.randint(1, 7))),
                    SignalState(self.random.random() < 0.5),
                ),
            )
        ]

    def count(self) -> list[object]:
        return [
            Assign(0, self.n, Binary(self.random.choice("+-"), self.n, Number(self.random.randint(1, 3))))
        ]

    def test(self) -> object:
        first = Compare(
            self.random.choice(["=", "<>", "<", ">", "<=", ">="]), self.n, Number(self.random.randint(-2, 6))
        )
        if self.random.random() < 0.3:
            return Logic(
                first,
                (
                    (
                        self.random.choice(["and", "or"]),
                        Compare(">", self.n, Number(self.random.randint(-2, 4))),
                    ),
                ),
            )
        return first

    def branch(self, depth: int) -> list[object]:
        rows = [If(0, self.test()), *self.block(depth)]  # type: ignore[arg-type]
        if self.random.random() < 0.4:
            rows += [ElseIf(0, self.test()), *self.block(depth)]  # type: ignore[arg-type]
        if self.random.random() < 0.5:
            rows += [Else(0), *self.block(depth)]
        return [*rows, EndIf(0)]

    def loop(self, depth: int) -> list[object]:
        counter = self.declare(f"k{len(self.data)}", "integer", Number(0), "variable")
        return [
            For(0, counter, Number(1), Number(self.random.randint(1, 3))),
            *self.block(depth),
            Next(0, counter),
        ]

    def endless(self, depth: int) -> list[object]:
        left = self.declare(f"w{len(self.data)}", "integer", Number(0), "variable")
        start = Assign(0, left, Number(self.random.randint(0, 3)))
        down = Assign(0, left, Binary("-", left, Number(1)))
        return [start, While(0, Compare(">", left, Number(0))), down, *self.block(depth), EndWhile(0)]

    def choice(self, depth: int) -> list[object]:
        rows: list[object] = [Switch(0, self.n)]
        for value in self.random.sample(range(-1, 6), 2):
            rows += [Case(0, (Number(value),)), *self.block(depth)]
        return [*rows, Default(0), *self.block(depth), EndSwitch(0)]

    def skip(self, depth: int) -> list[object]:
        self.labels += 1
        name = f"L{self.labels}"
        return [Jump(0, name, self.test()), *self.block(depth), Label(0, name)]  # type: ignore[arg-type]


def own_program(seed: int, vendor: str, folder: FilePath, robot: object) -> Program:
    """A random program as text of a language, read again with the routines beside it."""
    made = convert(Maker(seed).program(), vendor, Context(robot=robot), date="2026/01/01 00:00")  # type: ignore[arg-type]
    return written(made, vendor, folder)


def written(made: object, vendor: str, folder: FilePath) -> Program:
    folder.mkdir(parents=True, exist_ok=True)
    for name, data in made.files.items():  # type: ignore[attr-defined]
        (folder / name).write_bytes(data)
    program = olp.read(folder / made.main, vendor=vendor)  # type: ignore[attr-defined]
    told = [d.render() for d in program.diagnostics if d.is_error]
    assert not told, told
    return link(program).program


def round_trip(seed: int, first: str, second: str, robot: object) -> list[str]:
    """What differs between a program and its translation there and back, but for what the receipts name."""
    with tempfile.TemporaryDirectory() as place:
        folder = FilePath(place)
        one = own_program(seed, first, folder / "a", robot)
        context = Context(robot=robot)  # type: ignore[arg-type]
        there = convert(one, second, context, date="2026/01/01 00:00")
        two = written(there, second, folder / "b")
        back = convert(two, first, context, date="2026/01/01 00:00")
        three = written(back, first, folder / "c")
        plans = [p.plan(robot=robot, max_steps=50_000) for p in (one, two, three)]
        wrong = [d.message for p in plans for d in p.diagnostics if d.is_error and d.code[0] == "I"]
        found = compare_plans(plans[0], plans[1], loose=named(there, plans[0]))
        again = compare_plans(plans[1], plans[2], loose=named(back, plans[1]))
        ends = compare_plans(plans[0], plans[2], speeds=False, blends=False)
        return [*wrong, *found.differences, *again.differences, *ends.differences]


def named(made: object, plan: Plan) -> dict[str, set[int]]:
    """The lines whose speed or blend the receipt names.

    Where it names the arm's configuration, the joint move that leads there and the one that leads on turn otherwise.
    """
    found: dict[str, set[int]] = {"speed": set(), "blend": set()}
    for loss in made.translated.losses:  # type: ignore[attr-defined]
        found.setdefault(loss.part, set()).add(loss.line)
    otherwise = False
    for step in steps_of(plan):
        if step.path is Path.JOINT:
            begins = step.line in found.get("configuration", set())
            if begins or otherwise:
                found["speed"].add(step.line)
            otherwise = begins
    return found
