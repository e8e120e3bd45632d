"""Frozen classes with a faster constructor are what dataclasses make of them; what is quicker finds the same."""

from __future__ import annotations

import copy
import inspect
import math
import pickle
import random
from dataclasses import FrozenInstanceError, dataclass, field, fields, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from olp.core.fast_dataclass import changer, fast_init
from olp.ir.expressions import (
    Binary,
    FrameRef,
    Function,
    Named,
    Number,
    PositionLiteral,
    Quantity,
    RecordLiteral,
)
from olp.ir.program import Assign, Blend, BlendKind, Declare, Move, Path, Speed, SpeedUnit
from olp.ir.transformer import expressions_of, note_names
from olp.languages.literals import all_trimmed, trimmed


@dataclass(frozen=True, slots=True)
class Plain:
    first: int
    second: str = "two"
    third: list[int] = field(default_factory=list)
    hidden: int = field(default=0, compare=False)


@fast_init
@dataclass(frozen=True, slots=True)
class Fast:
    first: int
    second: str = "two"
    third: list[int] = field(default_factory=list)
    hidden: int = field(default=0, compare=False)


def test_arguments_are_taken_as_by_any_dataclass() -> None:
    assert str(inspect.signature(Fast)).count(",") == str(inspect.signature(Plain)).count(",")
    one = Fast(1)
    assert (one.first, one.second, one.third, one.hidden) == (1, "two", [], 0)
    assert Fast(1).third is not one.third
    assert Fast(1, third=[2], hidden=5) == Fast(1, "two", [2])
    for wrong in ((), (1, 2, 3, 4, 5)):
        with pytest.raises(TypeError):
            Fast(*wrong)
    with pytest.raises(TypeError):
        Fast(1, fourth=4)


def test_what_is_built_is_frozen_equal_hashed_copied_and_kept_as_any_dataclass() -> None:
    move = Move(3, Path.LINEAR, (Named("p"),), comment="c")
    assert type(move) is Move
    with pytest.raises(FrozenInstanceError):
        move.line = 4  # type: ignore[misc]
    with pytest.raises((FrozenInstanceError, AttributeError, TypeError)):
        del move.line  # type: ignore[misc]
    assert not hasattr(move, "__dict__")
    assert copy.deepcopy(move) == pickle.loads(pickle.dumps(move)) == move
    assert hash(copy.copy(move)) == hash(move)
    assert replace(move, line=4) == Move(4, Path.LINEAR, (Named("p"),), comment="c")


def test_a_changed_copy_is_that_of_replace_and_leaves_the_first_alone() -> None:
    move = Move(3, Path.LINEAR, (Named("p"),), comment="c")
    changed = changer(Move)(move, {"line": 4, "tool": Named("t")})
    assert changed == replace(move, line=4, tool=Named("t"))
    assert type(changed) is Move
    assert (move.line, move.tool) == (3, None)
    assert [getattr(changed, f.name) for f in fields(Move)][3:] == [
        getattr(replace(move, tool=Named("t")), f.name) for f in fields(Move)
    ][3:]


def test_classes_that_do_more_when_they_are_built_are_refused() -> None:
    @dataclass(frozen=True, slots=True)
    class Checked:
        value: int

        def __post_init__(self) -> None:
            assert self.value

    @dataclass(frozen=True)
    class Open:
        value: int

    for wrong in (Checked, Open):
        with pytest.raises(TypeError, match="plain frozen dataclass"):
            fast_init(wrong)


@given(st.floats(-2e4, 2e4) | st.floats(-1e-3, 1e-3) | st.decimals(-999, 999, places=9).map(float))
def test_trimmed_decimals_are_those_of_round(value: float) -> None:
    for decimals in (9, 10):
        text = trimmed(value, decimals)
        if abs(value) >= 1e4:
            assert text is None
            continue
        assert text is not None
        assert float(text) == round(value, decimals)
        assert len(text.partition(".")[2]) <= decimals
        assert not text.partition(".")[2].endswith("0")
        assert text != "-0."


def test_trimmed_decimals_know_no_other_values() -> None:
    assert trimmed(math.nan, 9) is trimmed(math.inf, 9) is trimmed(1e4, 9) is None
    assert [trimmed(value, 9) for value in (0.0, -0.0, -1e-12, 3.0, -2.5)] == ["0.", "0.", "0.", "3.", "-2.5"]


@given(st.lists(st.floats() | st.floats(-1e4, 1e4) | st.floats(-1e-9, 1e-9), min_size=1, max_size=6))
def test_decimals_that_are_trimmed_together_are_those_of_each(values: list[float]) -> None:
    for decimals in (9, 10):
        texts = [trimmed(value, decimals) for value in values]
        assert all_trimmed(tuple(values), decimals) == (None if None in texts else texts)


def test_names_that_are_noted_are_those_of_all_expressions() -> None:
    chance = random.Random(2)
    names = [Named(f"n{at}") for at in range(9)]

    def some() -> object:
        return chance.choice([
            *names, Number(1), None, PositionLiteral("pose", (0.0,) * 6), FrameRef("tool", Number(2)),
            FrameRef("user", chance.choice(names)), Function("pose-product", (chance.choice(names), Number(1))),
            Binary("+", chance.choice(names), Function("abs", (chance.choice(names),))),
        ])  # fmt: skip

    for _ in range(300):
        speed = Speed(SpeedUnit.TRAVEL, Quantity(some() or Number(1), 0.001))  # type: ignore[arg-type]
        blend = Blend(BlendKind.RADIUS, Quantity(some() or Number(1), 0.001))  # type: ignore[arg-type]
        via = some() if chance.random() < 0.3 else None
        move = Move(1, Path.LINEAR, (some() or Number(0),), speed, blend, tool=some(), frame=some(), via=via)  # type: ignore[arg-type]
        record = RecordLiteral("data", (("a", some() or Number(1)), ("b", some() or Number(2))))  # type: ignore[arg-type]
        declared = [Declare(1, "d", "real", some()), Declare(1, "d", "data", record)]  # type: ignore[arg-type]
        for s in (move, Assign(1, names[0], some() or Number(2)), *declared):  # type: ignore[arg-type]
            found: set[str] = set()
            note_names(s, found)
            assert found == {e.name for e in expressions_of(s) if type(e) is Named}
