"""What every estimator of signatures promises: `check_estimator`."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from olp.contracts.models import trapezoid
from olp.contracts.promises import Difference, Promise, hold
from olp.core.diagnostic import OlpError
from olp.core.units import deg
from olp.identification.recording.reader import read_recording
from olp.identification.signature.coefficients import LearntParameter, Parameters
from olp.identification.signature.estimator import (
    Estimate,
    Estimator,
    duration_of,
    estimator_names,
    load_estimator,
)
from olp.identification.signature.moveset import MoveSet, moves_of_recording
from olp.robots import RECORDED_ROBOT
from olp.robots.geometry import rotation_from_angles
from olp.robots.kinematics.inverse import inverse
from olp.robots.model import Robot
from olp.robots.robot import load_robot

Array = NDArray[np.float64]
RECORDING: Final = Path(__file__).resolve().parents[2] / "samples" / "up20"
ROBOT: Final = RECORDED_ROBOT
ANSWERS: Final = RECORDING.parents[1] / "tests" / "data" / "estimator_answers.json"
_EXACT: Final = 0.012  # relative error of a duration that one acceleration made
_FAIR: Final = 0.04  # median relative error on moves of the sample that were not learnt
_SCATTER: Final = 0.03  # of the slowness of moves, standard deviation
_RECORDINGS: Final = 24
_TRUE: Final = 1.5  # by which a stated standard deviation may be off: that of 24 samples is good to 15 %
_MANY: Final = 500  # recordings for a method that learns one number: its spread is then good to 3 %
_TRUE_OF_MANY: Final = 1.15
_SURE: Final = 4.0  # standard deviations that a planted number may be off
_SAME: Final = 1e-3  # relative change of an answer where nothing that counts changed
_FEW: Final = 12  # numbers of a parameter that are written down
_FOLLOWED: Final = 0.97  # of the variance of moves that were learnt, where a method follows a law at all
_ANYWHERE: Final = 0.12  # relative error of a slowness where no move was learnt
_SMALL: Final = 48  # moves, for methods that are for few


@lru_cache(maxsize=2)
def sample_moves(folder: Path = RECORDING) -> MoveSet:
    """Every second straight move of a published recording: as much as the slowest estimator learns in a second."""
    moves = moves_of_recording(read_recording(folder))[0]
    return moves.take(np.arange(0, len(moves), 2))


class EstimatorUnderTest:
    """`moves`: of a recording, that the estimator learns from; as many as it takes."""

    def __init__(self, estimator: Estimator, moves: MoveSet, robot: Robot) -> None:
        self.estimator, self.robot = estimator, robot
        self.why = estimator.needs(moves, robot)
        if self.why:
            few = moves.take(np.arange(0, len(moves), -(-len(moves) // _SMALL)))
            moves = few if not estimator.needs(few, robot) else moves
        self.moves = moves
        self.learns = not estimator.needs(moves, robot)

    @property
    def planted(self) -> MoveSet:
        """The same moves, as one acceleration makes them."""
        return made_by(self.moves, np.full(len(self.moves), SLOWNESS))

    def scattered(self, seed: int, scatter: float) -> MoveSet:
        """The same, each with an acceleration of its own. `scatter`: standard deviation over the slowness."""
        dice = np.random.default_rng(seed).standard_normal(len(self.moves))
        return made_by(self.moves, SLOWNESS * (1.0 + scatter * dice))

    @cached_property
    def parameters(self) -> Parameters:
        return self.estimator.fit(self.moves, self.robot)

    def estimate(self, moves: MoveSet, parameters: Parameters | None = None) -> Estimate:
        return self.estimator.estimate(parameters or self.parameters, moves, self.robot)

    @cached_property
    def found(self) -> Estimate:
        return self.estimate(self.moves)


def check_estimator(
    estimator: Estimator, *, moves: MoveSet | None = None, robot: Robot | None = None, first: bool = False
) -> None:
    """Raises ContractError with every promise of an estimator that `estimator` breaks.

    `moves`, `robot`: what it learns from; None: the recording `samples/up20` of a checkout. An estimator that cannot
    learn from them is only asked to say why.

        from olp.contracts import check_estimator
        check_estimator(MyEstimator())
    """
    arm = robot if robot is not None else load_robot(ROBOT)
    it = EstimatorUnderTest(estimator, moves if moves is not None else sample_moves(), arm)
    hold(f"estimator {type(estimator).__name__}", it, PROMISES if it.learns else PROMISES[:2], first=first)


def says_what_it_is(it: EstimatorUnderTest) -> Iterator[Difference]:
    """An estimator says what it is, and in words what it lacks where it cannot learn"""
    summary = it.estimator.summary
    if not 10 < len(summary) < 160 or "\n" in summary or summary != summary.strip(" ."):
        yield "summary", repr(summary)
    if it.why and not (15 < len(it.why) < 250 and "\n" not in it.why):
        yield "needs", repr(it.why)
    if type(it.estimator).__module__.startswith("olp."):
        name = it.estimator.name
        if name not in estimator_names() or type(load_estimator(name)) is not type(it.estimator):
            yield name, "the registry of estimators does not find it under the name of its file"
    none = it.moves.take(np.zeros(len(it.moves), dtype=bool))
    if it.learns and it.estimator.needs_robot and not it.estimator.needs(it.moves, None):
        yield "no robot", "it needs one, and says that it can learn without"
    told: object = it.estimator.needs(none, it.robot) if it.learns else ""
    if not isinstance(told, str):
        yield "no moves at all", f"needs says {told!r}"


def says_what_it_needs(it: EstimatorUnderTest) -> Iterator[Difference]:
    """Numbers in what it says that it lacks are where learning begins or ends; without a robot it learns or says so"""
    if not it.learns:
        try:
            it.estimator.fit(it.moves, it.robot)
            yield "a recording that it says it cannot learn from", "it learns"
        except OlpError as refused:
            if it.why not in str(refused):
                yield "a recording that it cannot learn from", f"needs: {it.why!r}, fit: {refused}"
        return
    bare = replace(it.robot, geometry=None)
    for given, robot in (("no robot", None), ("a robot without kinematics", bare)):
        lacks = it.estimator.needs(it.moves, robot)
        if bool(lacks) != it.estimator.needs_robot:
            yield given, f"needs says {lacks!r}, and needs_robot is {it.estimator.needs_robot}"
        elif not lacks:
            other = it.estimator.estimate(it.estimator.fit(it.moves, robot), it.moves, robot)
            if not _same(other, it.found):
                yield given, "another estimate, though it needs none"
    said = {it.estimator.needs(it.moves.take(np.arange(k)), it.robot) for k in range(len(it.moves))} | {
        it.why
    }
    for fewest, most in re.findall(r"fewer than (\d+)|at most (\d+)", " ".join(sorted(said))):
        edge = int(fewest or most)
        few, many = (_repeated(it.moves, edge + k) for k in ((-1, 0) if fewest else (1, 0)))
        if not it.estimator.needs(few, it.robot) or it.estimator.needs(many, it.robot):
            yield f"{len(few)} and {len(many)} moves", f"it speaks of {edge}"
        elif edge < 100 and not np.isfinite(_answer(it, many, it.moves).slowness).all():
            yield f"{edge} moves", "it can learn from them and has no answer"


def _repeated(moves: MoveSet, count: int) -> MoveSet:
    return moves.take(np.arange(count) % len(moves))


def _answer(it: EstimatorUnderTest, learnt: MoveSet, asked: MoveSet) -> Estimate:
    return it.estimator.estimate(it.estimator.fit(learnt, it.robot), asked, it.robot)


def learns_plain_numbers(it: EstimatorUnderTest) -> Iterator[Difference]:
    """What it learns are numbers and names with units, which a file keeps to the last digit"""
    if not it.parameters:
        yield "the sample", "nothing is learnt"
    for name, one in it.parameters.items():
        numbers = [x for x in _leaves(one.value) if isinstance(x, float)]
        if (
            not isinstance(one, LearntParameter)
            or not isinstance(one.unit, str)
            or (numbers and not one.unit)
        ):
            yield name, f"{one!r:.80} has no unit"
            continue
        for what in (one.value, one.sd):
            bad = [x for x in _leaves(what) if isinstance(x, float) and math.isinf(x)]
            strange = [x for x in _leaves(what) if not isinstance(x, str | int | float | bool | None)]
            if bad or strange:
                yield name, f"{(bad or strange)[0]!r} is in it"
        if any(isinstance(x, float) and x < 0 for x in _leaves(one.sd)):
            yield name, "a standard deviation below zero"
    back = {
        name: LearntParameter(json.loads(json.dumps(one.value)), one.unit, json.loads(json.dumps(one.sd)))
        for name, one in it.parameters.items()
    }
    if not _same(it.estimate(it.moves, back), it.found):
        yield "parameters written as JSON and read again", "another estimate"


def _leaves(value: Any) -> Iterator[Any]:
    if isinstance(value, (list, tuple)):
        for one in value:
            yield from _leaves(one)
    elif isinstance(value, dict):
        for one in value.values():
            yield from _leaves(one)
    else:
        yield value


def _same(one: Estimate, other: Estimate, tolerance: float = 1e-9) -> bool:
    pairs = ((one.slowness, other.slowness), (one.sd, other.sd), (one.inside * 1.0, other.inside * 1.0))
    return all(np.allclose(a, b, rtol=tolerance, atol=1e-12, equal_nan=True) for a, b in pairs)


def estimates_every_move(it: EstimatorUnderTest) -> Iterator[Difference]:
    """Every move that it is asked for has a slowness, a doubt and whether it was learnt nearby"""
    n, found = len(it.moves), it.found
    for name, column in (("slowness", found.slowness), ("sd", found.sd), ("inside", found.inside)):
        if np.shape(column) != (n,):
            yield name, f"{np.shape(column)} for {n} moves"
    if found.seconds is not None and np.shape(found.seconds) != (n,):
        yield "seconds", f"{np.shape(found.seconds)} for {n} moves"
    if not np.isfinite(found.slowness).all() or not (found.slowness > 0).all():
        yield "slowness", "not finite, or below zero"
    if not np.isfinite(found.sd).all() or (found.sd < 0).any() or (found.sd > 5 * found.slowness).any():
        yield "sd", "not finite, below zero, or many times the slowness"
    if np.asarray(found.inside).dtype != np.bool_ or found.inside.mean() < 0.5:
        yield "inside", "most moves that were learnt are said to be outside"


def finds_one_acceleration(it: EstimatorUnderTest) -> Iterator[Difference]:
    """Of moves that one acceleration made it finds that acceleration again, for moves that it did not learn as well"""
    planted = it.planted
    even = np.arange(len(planted)) % 4 != 1
    for name, learnt in (("all moves", np.ones(len(planted), dtype=bool)), ("three of four moves", even)):
        parameters = it.estimator.fit(planted.take(learnt), it.robot)
        found = it.estimate(planted, parameters)
        error = np.abs(duration_of(found.slowness, planted) - planted.duration) / planted.duration
        if not np.median(error) < 0.5 * _EXACT or not error.max() < 2.5 * _EXACT:
            yield f"1.2 m/s² made them, {name} learnt", f"durations {error.max():.2%} off at most"
        ratio = float(np.median(found.slowness)) / SLOWNESS
        if not 0.97 < ratio < 1.03:
            yield f"1.2 m/s² made them, {name} learnt", f"a slowness {ratio:.3f} times the right one"


def finds_one_acceleration_everywhere(it: EstimatorUnderTest) -> Iterator[Difference]:
    """What one acceleration made has that acceleration in every direction, also in those that no move had"""
    planted = replace(it.planted, nominal=np.full(len(it.planted), 1.0 / SLOWNESS))
    parameters = it.estimator.fit(planted, it.robot)
    level = (planted.end - planted.start) * np.array([1.0, 1.0, 0.0])
    size = np.linalg.norm(level, axis=1)[:, None]
    flat = size[:, 0] > 0.2 * planted.length
    for tilt in (-0.9, -0.35, 0.35, 0.9):
        way = level / np.maximum(size, 1e-9) * math.cos(tilt) + np.array([0.0, 0.0, math.sin(tilt)])
        moves = replace(planted, end=planted.start + way * planted.length[:, None]).take(flat)
        ratio = np.nan_to_num(it.estimate(moves, parameters).slowness / SLOWNESS, nan=9.0)
        if not (np.abs(ratio - 1.0) < _ANYWHERE).all():
            worst = float(ratio[np.argmax(np.abs(ratio - 1.0))])
            yield (
                f"moves that rise at {math.degrees(tilt):.0f} deg",
                f"a slowness {worst:.3f} times the right one",
            )


def learns_from_every_move(it: EstimatorUnderTest) -> Iterator[Difference]:
    """Which moves are slow counts wherever they stand in the recording: early or late, upwards or downwards"""
    late = np.arange(len(it.moves)) >= len(it.moves) // 2
    slower = made_by(it.moves, SLOWNESS * np.where(late, 1.2, 1.0))
    found = it.estimate(it.moves, it.estimator.fit(slower, it.robot)).slowness
    ratio = float(np.median(found[late])) / SLOWNESS
    if not 1.04 < ratio < 1.25:
        yield (
            "the second half 20 % slower",
            f"the slowness of that half is {ratio:.3f} times that of the first",
        )
    up = it.moves.direction[:, 2]
    steep = made_by(it.moves, SLOWNESS * (1.0 + 0.15 * up))
    found = it.estimate(it.moves, it.estimator.fit(steep, it.robot)).slowness
    slope = float(np.polyfit(up, found / SLOWNESS, 1)[0])
    if slope < -0.02:
        yield "moves upwards 15 % slower", f"estimated as {-slope:.0%} faster"


def knows_what_does_not_count(it: EstimatorUnderTest) -> Iterator[Difference]:
    """Order, names, side of the arm, simulation, a load that never changes and unmeasured moves teach nothing"""
    moves = it.moves
    order = np.random.default_rng(2).permutation(len(moves))
    unmeasured = np.arange(len(moves)) % 7 == 3
    holes = replace(moves, duration=np.where(unmeasured, np.nan, moves.duration))
    loaded = replace(moves, payload=np.full(len(moves), 7.0))
    named = replace(moves, program=tuple(f"{k % 5}" for k in range(len(moves))))
    other_side = mirrored(moves)
    unsimulated = replace(moves, nominal=np.full(len(moves), np.nan))
    for given, one, other in (
        ("the moves in another order", _answer(it, moves.take(order), moves), it.found),
        ("programs of other names", _answer(it, named, named), it.found),
        ("moves that nobody simulated", _answer(it, unsimulated, unsimulated), it.found),
        ("7 kg all the time", _answer(it, loaded, loaded), it.found),
        ("the other side of the arm", _answer(it, other_side, other_side), it.found),
        (
            "moves that were not measured",
            _answer(it, holes, moves),
            _answer(it, moves.take(~unmeasured), moves),
        ),
    ):
        if not _same(one, other, _SAME):
            off = float(np.abs(one.slowness / other.slowness - 1.0).max())
            yield given, f"a slowness is {off:.2%} off, or a doubt or `inside` is another"


def follows_what_moves_do(it: EstimatorUnderTest) -> Iterator[Difference]:
    """Moves that it learnt are never told worse than by one acceleration for all, and one law at least is followed"""
    shares = {}
    for name, slowness in laws(it.moves, it.robot).items():
        found = _answer(it, made_by(it.moves, slowness), it.moves)
        left = float(np.mean((found.slowness - slowness) ** 2))
        shares[name] = 1.0 - left / float(np.mean((slowness - np.median(slowness)) ** 2))
        if shares[name] < -0.15:
            yield f"moves that are slower {name}", f"{left**0.5:.3g} s²/m off, more than one number for all"
    if np.ptp(it.found.slowness) > 0.0 and max(shares.values()) < _FOLLOWED:
        yield (
            f"moves that are slower {', '.join(shares)}",
            f"of their variance it follows {max(shares.values()):.0%}",
        )


def finds_planted_axes(it: EstimatorUnderTest) -> Iterator[Difference]:
    """Accelerations of axes that were planted are within their stated doubt"""
    rates = {name for name, one in it.parameters.items() if one.unit == "rad/s²" and one.sd is not None}
    if not rates:
        return
    parameters = it.estimator.fit(made_by(it.moves, slowest_axis(it.moves, it.robot)), it.robot)
    for name in rates:
        found, doubt = (np.array(x) for x in (parameters[name].value, parameters[name].sd))
        off = np.abs(found - np.array(AXES)) / doubt
        if not (off < _SURE).all() or not (doubt > 0).all():
            yield name, f"{off.max():.1f} standard deviations from what was planted"
        if not (doubt < 0.25 * found).any():
            yield name, "of no axis anything is known"


def knows_its_spread(it: EstimatorUnderTest) -> Iterator[Difference]:
    """A number differs from recording to recording by no more than it says, and by no less where only data tell it"""
    names = [name for name, one in it.parameters.items() if one.sd is not None and _flat(one.sd).size]
    if not names:
        return
    alone = len(it.parameters) == 1
    count, near = (_MANY, _TRUE_OF_MANY) if alone else (_RECORDINGS, _TRUE)
    few, many = (
        [it.estimator.fit(it.scattered(seed, scatter), it.robot) for seed in range(count)]
        for scatter, count in ((0.2 * _SCATTER, max(5, count // 5)), (_SCATTER, count))
    )
    for name in names:
        spread = np.std([_flat(row[name].value) for row in many], axis=0, ddof=1)
        stated, before = (np.median([_flat(row[name].sd) for row in rows], axis=0) for rows in (many, few))
        told = stated > 3.0 * before  # it follows the scatter: no belief of its own is in it
        wrong = (stated < spread / near) | (told & (stated > spread * near))
        if wrong.any():
            k = int(np.argmax(wrong))
            yield (
                f"{name}, {count} recordings",
                f"it says ± {stated[k]:.3g} and they differ by {spread[k]:.3g}",
            )


def _flat(value: Any) -> Array:
    return np.array([x for x in _leaves(value) if isinstance(x, float)])


def doubts_as_much_as_moves_scatter(it: EstimatorUnderTest) -> Iterator[Difference]:
    """Where it has doubts, they grow with the scatter of what it learnt, and fall where it learnt more"""
    out = np.arange(len(it.moves)) % 3 == 0
    doubts, held = [], []
    for scatter in (0.01, 0.05):
        for seed in (1, 2, 3):
            moves = it.scattered(seed, scatter)
            found = it.estimate(moves.take(out), it.estimator.fit(moves.take(~out), it.robot))
            doubts.append(float(np.median(found.sd)) / scatter)
            right = SLOWNESS * (1.0 + scatter * np.random.default_rng(seed).standard_normal(len(moves)))[out]
            held.append(np.abs(right - found.slowness) < 1.96 * found.sd)
    if not max(doubts) > 0.0:
        return
    small, large = float(np.median(doubts[:3])), float(np.median(doubts[3:]))
    if not 0.6 < large / max(small, 1e-12) < 1.7:
        yield (
            "scatter of 1 % and of 5 %",
            f"doubts of {small / SLOWNESS:.3g} and {large / SLOWNESS:.3g} of it",
        )
    if small > 0.4 * SLOWNESS and not 0.6 < float(np.mean(np.concatenate(held))) < 1.0:
        yield "95 % bounds of moves that were held out", f"they hold {np.mean(np.concatenate(held)):.0%}"
    if large > 1.6 * SLOWNESS:
        yield "scatter of 5 %", f"a doubt of {large / SLOWNESS:.2f} times the scatter"


def learns_from_a_recording(it: EstimatorUnderTest) -> Iterator[Difference]:
    """Moves of a published recording that it did not learn are predicted to a few per cent, and no worse with more"""
    out = np.arange(len(it.moves)) % 3 == 0
    asked = it.moves.take(out)
    parameters = it.estimator.fit(it.moves.take(~out), it.robot)
    found = it.estimate(asked, parameters)
    error = np.abs(duration_of(found.slowness, asked) - asked.duration) / asked.duration
    if not np.median(error) < _FAIR:
        yield "every third move of the recording", f"predicted {np.median(error):.2%} off"
    whole = duration_of(it.found.slowness, it.moves)
    seen = np.abs(whole - it.moves.duration) / it.moves.duration
    if not np.median(seen) < _FAIR:
        yield "the moves that were learnt", f"predicted {np.median(seen):.2%} off"


def knows_no_unit_of_time(it: EstimatorUnderTest) -> Iterator[Difference]:
    """A robot that does everything in the time of twice its slowness is learnt as one with twice the slowness"""
    slow = replace(it.planted, duration=it.planted.duration * 1.0)
    a = np.full(len(slow), 0.5 / SLOWNESS)
    half = replace(slow, duration=trapezoid(slow.length, slow.speed, a, a))
    found = it.estimate(half, it.estimator.fit(half, it.robot))
    ratio = float(np.median(found.slowness)) / SLOWNESS
    if not 1.94 < ratio < 2.06:
        yield "0.6 m/s² made the moves", f"a slowness {ratio:.3f} times that of 1.2 m/s²"


def looks_at_no_answer(it: EstimatorUnderTest) -> Iterator[Difference]:
    """It does not look at the durations that it is asked for, and neither order nor neighbours change an answer"""
    blind = replace(it.moves, duration=np.full(len(it.moves), np.nan))
    if not _same(it.estimate(blind), it.found):
        yield "moves without durations", "another estimate"
    order = np.random.default_rng(1).permutation(len(it.moves))
    mixed = it.estimate(it.moves.take(order))
    if not np.allclose(mixed.slowness, it.found.slowness[order], rtol=1e-7):
        yield "the moves in another order", "another estimate"
    alone = it.estimate(it.moves.take(np.arange(5)))
    if not np.allclose(alone.slowness, it.found.slowness[:5], rtol=1e-7):
        yield "five moves alone", "another estimate than among all"
    if not np.allclose(alone.sd, it.found.sd[:5], rtol=1e-6, atol=1e-12):
        yield "five moves alone", "another doubt than among all"


def learns_the_same_again(it: EstimatorUnderTest) -> Iterator[Difference]:
    """The same moves teach the same, and what was given stays as it was"""
    before = it.moves.duration.copy(), it.moves.start.copy(), it.moves.speed.copy()
    again = it.estimate(it.moves, it.estimator.fit(it.moves, it.robot))
    if not _same(again, it.found):
        yield "the same moves", "another estimate the second time"
    after = it.moves.duration, it.moves.start, it.moves.speed
    if not all(np.array_equal(a, b, equal_nan=True) for a, b in zip(before, after, strict=True)):
        yield "the moves that it learnt from", "they are changed"


def stands_moves_elsewhere(it: EstimatorUnderTest) -> Iterator[Difference]:
    """Moves far from all that it learnt have a positive, finite time, and no less doubt"""
    far = replace(it.moves, start=it.moves.start * 1.15, end=it.moves.end * 1.15, speed=it.moves.speed * 1.6)
    found = it.estimate(far)
    known = np.isfinite(found.slowness)
    time = duration_of(found.slowness[known], far.take(known))
    if not known.all() or not (time > 0).all() or (time > 60).any():
        yield "moves 15 % further out, 60 % faster", "no time, or an absurd one"
    if np.median(found.sd) < 0.8 * np.median(it.found.sd):
        yield "moves 15 % further out, 60 % faster", "less doubt than among those that were learnt"


def answers_of(estimator: Estimator, robot: Robot) -> dict[str, Any]:
    """What an estimator says of itself and of moves of all kinds, with five digits: what `ANSWERS` holds of it."""
    asked, learnt = replace(all_kinds(robot, 40, 3), duration=np.full(40, np.nan)), all_kinds(robot)
    few = [f"{k}: {estimator.needs(learnt.take(np.arange(k)), robot)}" for k in range(20)]
    said: dict[str, Any] = {"summary": estimator.summary, "needs": few, "preferred": estimator.preferred}
    if estimator.needs(learnt, robot):
        return said | {"needs": [estimator.needs(learnt, robot)]}
    parameters = estimator.fit(learnt, robot)
    found = estimator.estimate(parameters, asked, robot)
    flat = {name: [*_flat(one.value), *_flat(one.sd)] for name, one in sorted(parameters.items())}
    return said | {
        "parameters": {name: one.unit for name, one in sorted(parameters.items())},
        "numbers": _digits(x for own in flat.values() if len(own) <= _FEW for x in own),
        "slowness": _digits(found.slowness.tolist()),
        "sd": _digits(found.sd.tolist()),
        "inside": "".join("01"[bool(x)] for x in found.inside.tolist()),
    }


def _digits(numbers: Iterable[float]) -> list[float]:
    return [float(f"{x:.5g}") for x in numbers]


def is_as_it_was_written_down(it: EstimatorUnderTest) -> Iterator[Difference]:
    """Moves of all kinds are estimated as was written down: a signature says the same in every version"""
    if not type(it.estimator).__module__.startswith("olp.") or not ANSWERS.exists():
        return
    said = json.loads(ANSWERS.read_text(encoding="utf-8")).get(it.estimator.name, {})
    own = answers_of(it.estimator, it.robot)
    for key in sorted(said.keys() | own.keys()):
        one, other = said.get(key, ()), own.get(key, ())
        numbers = key in ("numbers", "slowness", "sd") and len(one) == len(other)
        if not (np.allclose(one, other, rtol=_SAME, atol=1e-5) if numbers else one == other):
            yield f"{ANSWERS.name}, {key} of {it.estimator.name}", f"{other}"[:200]


PROMISES: Final[tuple[Promise[EstimatorUnderTest], ...]] = (
    says_what_it_is,
    says_what_it_needs,
    finds_one_acceleration,
    finds_one_acceleration_everywhere,
    learns_from_every_move,
    follows_what_moves_do,
    knows_what_does_not_count,
    finds_planted_axes,
    is_as_it_was_written_down,
    knows_its_spread,
    doubts_as_much_as_moves_scatter,
    learns_from_a_recording,
    estimates_every_move,
    learns_plain_numbers,
    looks_at_no_answer,
    knows_no_unit_of_time,
    learns_the_same_again,
    stands_moves_elsewhere,
)


# --- Moves whose slowness is known because it was planted ---


SLOWNESS: Final = 0.83  # [s²/m] of the planted recording: an acceleration of 1.2 m/s²
AXES: Final = (3.0, 2.5, 3.5, 6.0, 6.0, 7.0)  # [rad/s²] of the arm whose axes decide
_STEP: Final = 1e-4  # [m] of the differences
_MIRROR: Final = np.diag([1.0, -1.0, 1.0])


def made_by(moves: MoveSet, slowness: Array) -> MoveSet:
    """The moves as constant accelerations, one over `slowness` (n,) [s²/m], make them."""
    return replace(moves, duration=trapezoid(moves.length, moves.speed, 1.0 / slowness, 1.0 / slowness))


def mirrored(moves: MoveSet) -> MoveSet:
    """The same on the other side of the arm's plane of symmetry."""
    return replace(
        moves,
        start=moves.start @ _MIRROR,
        end=moves.end @ _MIRROR,
        rotation=_MIRROR @ moves.rotation @ _MIRROR,
    )


def laws(moves: MoveSet, robot: Robot) -> Mapping[str, Array]:
    """(n,) [s²/m] of what makes some moves slower than others, each by itself; nan where an axis is not known."""
    high = moves.start[:, 2] - moves.start[:, 2].mean()
    return {
        "upwards": SLOWNESS * (1.0 + 0.2 * moves.direction[:, 2]),
        "high up": SLOWNESS * (1.0 + 0.5 * high),
        "where an axis is slow": slowest_axis(moves, robot),
    }


def slowest_axis(moves: MoveSet, robot: Robot) -> Array:
    """(n,) [s²/m] where at each end of a move the axis that needs longest decides, of `AXES`; by small steps."""
    way = moves.direction * _STEP
    needed = [
        np.abs(_joints(moves, place + way, robot) - _joints(moves, place - way, robot)) / (2 * _STEP)
        for place in (moves.start, moves.end)
    ]
    first, last = ((rate / np.array(AXES[: rate.shape[1]])).max(axis=1) for rate in needed)
    return np.asarray(0.25 * SLOWNESS + 0.5 * (first + last))


def _joints(moves: MoveSet, places: Array, robot: Robot) -> Array:
    joints, reached = inverse(robot, places, moves.rotation)
    return np.asarray(np.where(reached[:, None], joints, np.nan))


@lru_cache(maxsize=2)
def all_kinds(robot: Robot, count: int = 56, seed: int = 15) -> MoveSet:
    """Moves in every plane, of two loads, two tool orientations and two postures, from six start points.

    Among them are some that tell nothing: not measured, faster than their speed allows, of unknown orientation.
    """
    rng, rows = np.random.default_rng(seed), np.arange(count)
    starts = np.array(
        [
            [0.8, 0.0, 0.5],
            [0.8, 0.3, 0.5],
            [0.9, -0.2, 0.8],
            [1.1, 0.1, 0.4],
            [1.0, 0.0, 0.9],
            [0.7, -0.4, 0.6],
        ]
    )
    way = rng.normal(size=(count, 3))
    way[rows % 3 == 0, 2] = 0.0  # level
    way[rows % 3 == 1, 0] = 0.0  # upright
    way *= (rng.uniform(0.05, 0.35, count) / np.linalg.norm(way, axis=1))[:, None]
    start = starts[rows % len(starts)]
    tilted = rows % 7 == 2
    angles = np.where(tilted[:, None], [165.0, 10.0, 0.0], [180.0, 0.0, 0.0]) * deg
    rotation = rotation_from_angles(angles)
    rotation[rows % 19 == 5] = np.nan
    moves = MoveSet(
        start=start,
        end=start + way,
        rotation=rotation,
        speed=rng.choice([0.2, 0.5, 1.0], count),
        nominal=np.full(count, 1.0 / SLOWNESS),
        duration=np.full(count, np.nan),
        payload=np.where(rows % 5 == 3, 20.0, 6.0),
        configuration=tuple("000100" if k % 11 == 4 else "000000" for k in rows),
        program=tuple(f"P{k % 4}" for k in rows),
    )
    slow = SLOWNESS * (1.0 + 0.15 * moves.direction[:, 2] + 0.1 * tilted + 0.1 * (moves.payload > 10.0))
    slow = slow * (1.0 + 0.01 * rng.standard_normal(count)) + 0.1 * np.linalg.norm(start[:, :2], axis=1)
    moves = made_by(moves, slow)
    moves.duration[rows % 23 == 7] = np.nan
    moves.duration[rows % 29 == 11] *= 0.5
    return moves
