"""What every motion model promises: `check_model`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from olp.contracts.promises import Difference, Promise, hold
from olp.core.diagnostic import OlpError
from olp.timing.motion._profile import Problem, Profile
from olp.timing.motion.model import MotionModel, load_model, model_names

Array = NDArray[np.float64]
_STEPS: Final = 4000  # of time that a profile is driven in
_PLAIN: Final = (0.8, 1.1, 2.0, 3.0)  # length [m], speed [m/s], acceleration and deceleration [m/s²]


def check_model(model: MotionModel, *, first: bool = False) -> None:
    """Raises ContractError with every promise of a motion model that `model` breaks.

    from olp.contracts import check_model
    check_model(MyModel())
    """
    hold(f"motion model {type(model).__name__}", model, PROMISES, first=first)


def random_moves(seed: int, n: int = 300) -> dict[str, Array]:
    """Moves of all kinds: long and short, braking and gaining speed, possible and impossible. SI."""
    rng = np.random.default_rng(seed)
    speed = 10 ** rng.uniform(-2, 0.5, n)
    return {
        "length": 10 ** rng.uniform(-4, 1, n),
        "speed": speed,
        "acceleration": 10 ** rng.uniform(-1, 1, n),
        "deceleration": 10 ** rng.uniform(-1, 1, n),
        "start_speed": speed * rng.uniform(0, 1.4, n) * (rng.random(n) < 0.7),
        "end_speed": speed * rng.uniform(0, 1.4, n) * (rng.random(n) < 0.7),
    }


def ramps_of(model: MotionModel) -> dict[str, Any]:
    """Every parameter that a model derives by itself, given: gentle, so that it shows."""
    return {p.name: 30.0 for p in model.parameters if p.default is None}


def trapezoid(length: Array, speed: Array, up: Array, down: Array) -> Array:
    """[s] from rest to rest with constant accelerations: what no motion within these limits can beat."""
    ramps = 0.5 * speed * speed * (1.0 / up + 1.0 / down)
    peak = np.sqrt(2.0 * length / (1.0 / up + 1.0 / down))
    whole = speed / up + speed / down + (length - ramps) / speed
    found: Array = np.where(ramps <= length, whole, peak * (1.0 / up + 1.0 / down))
    return found


def _differ(given: str, wrong: NDArray[np.bool_], what: str) -> Iterator[Difference]:
    if wrong.any():
        yield given, f"{what} for {int(wrong.sum())} of {wrong.size}"


# --- what it says of itself ---------------------------------------------------------------------------------


def says_what_it_is(model: MotionModel) -> Iterator[Difference]:
    """A model says what it is, where it comes from, and the unit, default and source of each parameter"""
    for name in ("summary", "source"):
        if not 5 < len(getattr(model, name, "")) < 300:
            yield name, repr(getattr(model, name, ""))
    for p in model.parameters:
        if not p.unit or not p.source or not p.name.isidentifier():
            yield f"parameter {p.name}", "it has no unit or no source"
        if p.default is not None and not (np.isfinite(p.default) and p.default > 0.0):
            yield f"parameter {p.name}", f"its default is {p.default}"
    home = type(model).__module__
    if home.startswith("olp.") and (
        model.name not in model_names() or type(load_model(model.name)) is not type(model)
    ):
        yield model.name, "the registry of models does not find it under the name of its file"


def refuses_nonsense(model: MotionModel) -> Iterator[Difference]:
    """Numbers that no move has are refused, all at once and by name, and so are parameters that it does not know"""
    for bad in (-1.0, np.nan, np.inf):
        try:
            model.profile([1.0, bad], 0.5, [bad, 1.0])
            yield f"length and acceleration {bad}", "a profile"
        except OlpError as refused:
            named = [d.message.split()[0] for d in refused.diagnostics]
            if named != ["length", "acceleration"]:
                yield f"length and acceleration {bad}", f"complaints about {named}"
    try:
        model.profile(1.0, 0.5, 2.0, snap_of_nobody=4.0)
        yield "the parameter snap_of_nobody", "a profile"
    except OlpError:
        pass
    for p in model.parameters:
        try:
            model.profile(1.0, 0.5, 2.0, **{p.name: -1.0})
            yield f"{p.name} = -1", "a profile"
        except OlpError:
            pass


# --- the profile is a motion --------------------------------------------------------------------------------


def _driven(profile: Profile) -> tuple[Array, Array]:
    """Distance and speed at the end when only the acceleration is known, added up in small steps."""
    dt = profile.duration / _STEPS
    instants = (np.arange(_STEPS) + 0.5)[None, :] * dt[:, None]
    a = profile.acceleration(instants)
    v = profile.moves.start_speed[:, None] + np.cumsum(a, axis=1) * dt[:, None]
    return (v - a * dt[:, None] / 2).sum(axis=1) * dt, v[:, -1]


def arrives(model: MotionModel) -> Iterator[Difference]:
    """Driving the acceleration in small steps covers the length and ends with the speed that the profile says"""
    profile = model.profile(**random_moves(1, 150))
    distance, speed = _driven(profile)
    moves = profile.moves
    # A step of the acceleration is seen at most one small step too early or too late.
    steep = np.maximum(moves.acceleration, moves.deceleration)
    coarse = len(profile.phases) * steep * profile.duration / _STEPS
    yield from _differ("random moves", np.abs(speed - profile.end_speed) > coarse, "another speed at the end")
    off = np.abs(distance - moves.length)
    yield from _differ("random moves", off > coarse * profile.duration, "another length")
    if np.median(off / moves.length) > 2e-4:
        yield "random moves", f"half of them miss their length by {np.median(off / moves.length):.2g}"


def has_true_derivatives(model: MotionModel) -> Iterator[Difference]:
    """Speed and acceleration are the derivatives of the position, and the time at a position is its inverse"""
    profile = model.profile(**random_moves(2, 60))
    t = np.linspace(0.03, 0.97, 40)[None, :] * profile.duration[:, None]
    h = 1e-6 * profile.duration[:, None]
    slope = (profile.position(t + h) - profile.position(t - h)) / (2 * h)
    off = np.abs(slope - profile.speed(t)) / profile.peak_speed[:, None]
    yield from _differ("random moves at 40 instants", off > 1e-4, "another speed")
    rate = (profile.speed(t + h) - profile.speed(t - h)) / (2 * h)
    steep = np.maximum(profile.moves.acceleration, profile.moves.deceleration)[:, None]
    if np.mean(np.abs(rate - profile.acceleration(t)) / steep < 1e-3) < 0.99:
        yield "random moves at 40 instants", "the acceleration is not the slope of the speed"
    s = np.linspace(0, 1, 23)[None, :] * profile.moves.length[:, None]
    back = profile.position(profile.time_at(s))
    yield from _differ(
        "random moves at 23 places", ~np.isclose(back, s, rtol=1e-9, atol=1e-13), "another place"
    )


def breaks_no_limit(model: MotionModel) -> Iterator[Difference]:
    """No speed, acceleration or deceleration is beyond its limit at any instant, and no phase is shorter than none"""
    for name, more in (("as it is", {}), ("with its ramps given", ramps_of(model))):
        profile = model.profile(**random_moves(3), **more)
        t = np.linspace(0, 1, 201)[None, :] * profile.duration[:, None]
        m, v, a = profile.moves, profile.speed(t), profile.acceleration(t)
        top = np.maximum(m.speed, m.start_speed)[:, None]
        yield from _differ(name, v > top * (1 + 1e-12), "too fast")
        yield from _differ(name, v < -1e-12, "backwards")
        yield from _differ(name, a > m.acceleration[:, None] * (1 + 1e-12), "too much acceleration")
        yield from _differ(name, a < -m.deceleration[:, None] * (1 + 1e-12), "too much deceleration")
        yield from _differ(name, profile.durations < 0, "a phase of less than no time")


def stands_any_size(model: MotionModel) -> Iterator[Difference]:
    """Very large and very small numbers together are no trouble: a move from rest to rest is always possible"""
    rng = np.random.default_rng(9)
    length, speed, a, d, k = 10 ** rng.uniform(-6, 6, (5, 1500))
    v0, v1 = speed * rng.choice([0, 0, 1e-9, 0.3, 1, 1, 1.3], (2, 1500))
    rates = dict.fromkeys(ramps_of(model), k)
    still = model.profile(length, speed, a, **rates)
    yield from _differ("moves from rest to rest, of all sizes", ~still.feasible, "impossible")
    share = float(model.profile(length, speed, a, d, v0, v1, **rates).feasible.mean())
    if not 0.1 < share < 0.9:
        yield "moves of all sizes with speeds at their ends", f"{share:.0%} of them are possible"


# --- durations ----------------------------------------------------------------------------------------------


def is_never_faster_than_the_limits(model: MotionModel) -> Iterator[Difference]:
    """No move is faster than with constant acceleration at its limits, which nothing can beat, nor much slower"""
    moves = random_moves(6)
    given = tuple(moves[name] for name in ("length", "speed", "acceleration", "deceleration"))
    for name, more in (("as it is", {}), ("with its ramps given", ramps_of(model))):
        ratio = model.profile(*given, **more).duration / trapezoid(*given)
        yield from _differ(f"moves from rest to rest, {name}", ratio < 1.0 - 1e-9, "faster than possible")
    speed = np.linspace(0.05, 1.5, 30)
    long = 4.0 * speed * speed / 2.5
    ratio = model.profile(long, speed, 2.5).duration / trapezoid(long, speed, *np.full((2, 30), 2.5))
    yield from _differ("moves that are mostly at speed", ratio > 2.0, "much slower than the limits ask for")


def knows_no_unit(model: MotionModel) -> Iterator[Difference]:
    """The same motion in another unit of length takes the same time"""
    length, speed, up, down = (np.array([x, x * 0.3, x * 1.7]) for x in _PLAIN)
    metres = model.profile(length, speed, up, down, 0.3 * speed, 0.1 * speed)
    for unit in (1000.0, 25.4, 0.3048):
        other = model.profile(*(unit * x for x in (length, speed, up, down, 0.3 * speed, 0.1 * speed)))
        same = np.isclose(other.duration, metres.duration, rtol=1e-9)
        yield from _differ(f"lengths times {unit:g}", ~same, "another duration")
        same = np.isclose(other.peak_speed, unit * metres.peak_speed, rtol=1e-9)
        yield from _differ(f"lengths times {unit:g}", ~same, "another top speed")


def is_the_same_backwards(model: MotionModel) -> Iterator[Difference]:
    """A move seen backwards in time takes as long"""
    moves = random_moves(7)
    v0, v1 = np.minimum(moves["start_speed"], moves["speed"]), np.minimum(moves["end_speed"], moves["speed"])
    given = moves["length"], moves["speed"]
    up, down = moves["acceleration"], moves["deceleration"]
    there = model.profile(*given, up, down, v0, v1, **ramps_of(model))
    back = model.profile(*given, down, up, v1, v0, **ramps_of(model))
    both = there.feasible & back.feasible
    if both.mean() < 0.3:
        yield "random moves", f"only {both.mean():.0%} are possible"
    same = np.isclose(there.duration, back.duration, rtol=1e-7)
    yield from _differ("random moves", both & ~same, "another duration backwards")


def grows_with_its_length(model: MotionModel) -> Iterator[Difference]:
    """A longer move takes longer, a faster limit never makes one slower, and a stop in between costs time"""
    longer = model.profile(np.linspace(0.001, 4.0, 400), 0.6, 2.1, 1.3)
    yield from _differ("lengths from 1 mm to 4 m", np.diff(longer.duration) <= 0, "no longer duration")
    faster = np.linspace(0.05, 3.0, 200)
    for name, one in (
        ("speeds", model.profile(0.8, faster, 2.0, 3.0, **ramps_of(model))),
        ("accelerations", model.profile(0.8, 1.1, 4 * faster, 3.0, **ramps_of(model))),
        ("decelerations", model.profile(0.8, 1.1, 2.0, 4 * faster, **ramps_of(model))),
    ):
        yield from _differ(f"{name} from 0.05 on", np.diff(one.duration) > 1e-12, "a longer duration")
    whole = model.profile(1.7, 0.6, 2.1).duration
    cut = np.linspace(0.05, 1.65, 9)
    parts = model.profile(cut, 0.6, 2.1).duration + model.profile(1.7 - cut, 0.6, 2.1).duration
    yield from _differ("1.7 m in two parts", parts <= whole + 0.1, "no longer duration")


# --- what cannot be done ------------------------------------------------------------------------------------


def stands_still(model: MotionModel) -> Iterator[Difference]:
    """A move of no length takes no time, and one without speed never ends and says so"""
    nowhere = model.profile([0.0, 0.0], [0.4, 0.0], 2.0)
    if nowhere.duration.tolist() != [0.0, 0.0] or not nowhere.feasible.all() or nowhere.position(1.0).any():
        yield "a length of 0", f"durations of {nowhere.duration.tolist()} s"
    stuck = model.profile([0.5, 0.5, 0.5], [0.0, 0.2, 0.2], [1.0, 0.0, 1.0])
    if stuck.problem.tolist() != [Problem.NO_SPEED, Problem.NO_SPEED, Problem.NONE]:
        yield "no speed, no acceleration, both", f"problems {stuck.problem.tolist()}"
    if np.isinf(stuck.duration).tolist() != [True, True, False] or stuck.reached[:2].any():
        yield "no speed, no acceleration, both", f"durations {stuck.duration.tolist()}"


def says_what_it_cannot_do(model: MotionModel) -> Iterator[Difference]:
    """An end speed out of reach becomes the nearest one, too fast a start is braked, and `reached` is true"""
    profile = model.profile(0.02, 0.9, 1.0, 1.0, [0.8, 0.1, 0.3], [0.1, 0.8, 0.3])
    if profile.problem.tolist() != [Problem.CANNOT_BRAKE, Problem.CANNOT_REACH, Problem.NONE]:
        yield "20 mm from 0.8 to 0.1, 0.1 to 0.8, 0.3 to 0.3 m/s", f"problems {profile.problem.tolist()}"
    if not ((profile.end_speed[:2] > 0.1) & (profile.end_speed[:2] < 0.8)).all():
        yield "20 mm from 0.8 to 0.1 and 0.1 to 0.8 m/s", f"end speeds {profile.end_speed[:2].tolist()}"
    if not np.isclose(profile.end_speed[2], 0.3) or not np.allclose(profile.positions[:, -1], 0.02):
        yield "20 mm from 0.3 to 0.3 m/s", f"ends with {profile.end_speed[2]:g} m/s"
    quick = model.profile(2.0, 0.3, 1.5, 2.5, 0.7, 0.2)
    if not quick.feasible.all() or not np.isclose(quick.peak_speed, 0.7).all():
        yield "2 m at 0.3 m/s, entered with 0.7 m/s", f"a top speed of {quick.peak_speed.tolist()}"
    if not np.isclose(quick.speed(quick.time_at(1.5)), 0.3).all():
        yield "2 m at 0.3 m/s, entered with 0.7 m/s", "after 1.5 m it is not at its programmed speed"
    short = model.profile([2.0, 0.01], 0.5, 2.0)
    if short.reached.tolist() != [True, False] or not np.isclose(short.peak_speed[0], 0.5):
        yield "2 m and 10 mm at 0.5 m/s", f"reached {short.reached.tolist()}"


PROMISES: Final[tuple[Promise[MotionModel], ...]] = (
    says_what_it_is,
    arrives,
    is_never_faster_than_the_limits,
    breaks_no_limit,
    has_true_derivatives,
    grows_with_its_length,
    is_the_same_backwards,
    knows_no_unit,
    stands_still,
    says_what_it_cannot_do,
    refuses_nonsense,
    stands_any_size,
)
