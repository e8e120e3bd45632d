"""What every physics term promises: `check_term`."""

from __future__ import annotations

import csv
import tempfile
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from olp.contracts.promises import Difference, Promise, hold
from olp.contracts.term_oracles import COARSE, FOUND, NEAR, ORACLES, Oracle
from olp.core.units import deg, mm
from olp.identification.diagnosis.model import DurationModel, ModelPart
from olp.identification.diagnosis.result import PHASES
from olp.identification.recorded_plan import case_of
from olp.identification.recording.reader import read_recording
from olp.reports.diagnosis.mathml import mathml
from olp.robots import EXAMPLE_ROBOT
from olp.robots.geometry import angles_from_rotation, rotation_from_angles
from olp.robots.kinematics.inverse import inverse
from olp.robots.robot import load_robot
from olp.timing.physics import Form, LogTerm, MoveTerm, Stage, Term, TermParameter, load_term, term_names
from olp.timing.physics._case import MeasuredMoves

Array = NDArray[np.float64]
ROBOT: Final = EXAMPLE_ROBOT
CYCLE: Final = 0.012  # [s]
_SPEEDS: Final = (0.05, 0.15, 0.4, 0.9)  # [m/s]
_ACCELERATION: Final = 2.5  # [m/s²]
_SEEN: Final = frozenset({"command", "speed", "torque", "current", "sim"})


# --- a recording that tells everything ----------------------------------------------------------------------


@lru_cache(maxsize=4)
def rich_case(
    moves: int = 60, joint_moves: int = 8, seed: int = 5, speeds: Sequence[float] = _SPEEDS
) -> MeasuredMoves:
    """A case in which every term has all its forms; nothing is planted in it but the cycle and 30 ms per move."""
    rng = np.random.default_rng(seed)
    rows = _programmed(rng, moves, joint_moves, speeds)
    began = 0.0
    for row in rows:
        row["duration_s"] = f"{np.ceil((float(str(row['sim_s'])) + 0.03) / CYCLE) * CYCLE:.3f}"
        row["t_start_s"] = f"{began:.3f}"
        began += float(str(row["duration_s"])) + 0.2
    with tempfile.TemporaryDirectory() as folder:
        with (Path(folder) / "moves.csv").open("w", encoding="utf-8", newline="") as file:
            names = list(dict.fromkeys(name for row in rows for name in row))
            table = csv.DictWriter(file, names, restval="")
            table.writeheader()
            table.writerows(rows)
        settings = f'robot = "{ROBOT}"\ntime_resolution_s = 0.001\ntool = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]\n'
        (Path(folder) / "recording.toml").write_text(settings, encoding="utf-8")
        return case_of(read_recording(folder)).case


def _programmed(
    rng: np.random.Generator, moves: int, joint_moves: int, speeds: Sequence[float]
) -> list[dict[str, object]]:
    """Straight moves, joint moves and two waits, each from where the last one ended, with what a simulation says."""
    total, robot = moves + joint_moves, load_robot(ROBOT)
    places, angles, joints = _points(rng, total + 1)
    rows: list[dict[str, object]] = []
    for k in range(total):
        straight = k < moves
        turned = np.abs(joints[k + 1] - joints[k])
        lead = int(np.argmax(turned / robot.speeds))
        share = float(rng.choice([0.2, 0.5, 1.0]))
        way = float(np.linalg.norm(places[k + 1] - places[k])) if straight else float(turned[lead])
        top = float(rng.choice(np.asarray(speeds))) if straight else share * float(robot.speeds[lead])
        slow = _ACCELERATION if straight else float(robot.accelerations[lead])
        load = float(rng.choice([0.0, 6.0, 12.0]))
        row: dict[str, object] = {
            "move": k + 1,
            "type": "linear" if straight else "joint",
            "sim_s": way / top + top / slow if way >= top**2 / slow else 2 * np.sqrt(way / slow),
            "payload_kg": load,
            "payload_inertia_kg_m2": 0.03 * load,
        }
        if straight:
            row |= {"speed_mm_s": top / mm, "accel_mm_s2": slow / mm}
            row["blend_mm"] = float(rng.choice([0.0, 0.0, 5.0, 10.0, 25.0])) if k < moves - 1 else 0.0
        else:
            row["speed_pct"] = 100 * share
        for end, at in (("start", k), ("end", k + 1)):
            row |= {f"{c}_{end}_mm": v / mm for c, v in zip("xyz", places[at], strict=True)}
            row |= {f"r{c}_{end}_deg": v / deg for c, v in zip("xyz", angles[at], strict=True)}
            row |= {f"q{c}_{end}_deg": v / deg for c, v in enumerate(joints[at], 1)}
        rows.append(row)
    return [*rows, *({"move": total + k, "type": "wait", "sim_s": 0.5} for k in (1, 2))]


def _points(rng: np.random.Generator, count: int) -> tuple[Array, Array, Array]:
    """Places (n, 3) [m] in front of the robot, orientations (n, 3) [rad] about tool down, and their joints [rad]."""
    low, high = np.array([0.7, -0.5, 0.1]), np.array([1.25, 0.5, 0.8])
    places = rng.uniform(low, high, (count, 3))
    angles = np.array([180.0, 0.0, 0.0]) * deg + rng.uniform(-0.4, 0.4, (count, 3))
    for k in range(1, count, 3):  # short ways
        places[k] = places[k - 1] + rng.uniform(0.02, 0.08) * np.array([0.6, -0.5, 0.4])
    angles[2::5] = angles[1::5][: len(angles[2::5])]  # some moves turn nothing
    rotations = rotation_from_angles(angles)
    joints, reached = inverse(load_robot(ROBOT), places, rotations)
    assert reached.all()
    return places, angles_from_rotation(rotations), joints


# --- the suite ----------------------------------------------------------------------------------------------


@lru_cache(maxsize=1)
def other_cases() -> tuple[tuple[str, MeasuredMoves], ...]:
    """Recordings that tell other things: one acceleration, joint moves alone, no ratings, another load than told."""
    rich, turning = rich_case(), rich_case(moves=20, joint_moves=60)
    rng, n = np.random.default_rng(2), len(rich)
    plain = rich.take(np.nonzero(~rich.joint)[0])
    even = np.full(len(plain), _ACCELERATION)
    joints = turning.take(np.nonzero(turning.joint | ~turning.moving)[0])
    rates = turning.rates
    assert rates is not None
    return (
        (
            "where every stop is written and the bodies are not known",
            replace(
                turning,
                blend=np.where(turning.moving & turning.stop_end, 0.0, turning.blend),
                rates=replace(rates, bodies=None),
                derived={},
            ),
        ),
        (
            "with one acceleration, no robot, whose simulation looks ahead at corners",
            replace(
                plain,
                base=plain.base.with_(
                    accelerate=even,
                    decelerate=even,
                    law="parabola",
                    open_start=0.6 * even,
                    open_end=0.8 * even,
                ),
                rates=None,
                derived={},
            ),
        ),
        ("of joint moves alone", joints),
        (
            "of axes without ratings",
            replace(
                turning, rates=replace(rates, rated=None, rated_acceleration=None, bodies=None), derived={}
            ),
        ),
        (
            "of another load and override than simulated",
            replace(
                rich,
                override=rng.choice([0.5, 0.8, 1.0], n),
                sim_payload=rng.choice([0.0, 5.0, 11.0], n),
                sim_payload_inertia=rng.choice([0.0, 0.1, 0.3], n),
                derived={},
            ),
        ),
    )


class TermUnderTest:
    """A term, the recording that tells everything, and an oracle of what it does (`olp.contracts.term_oracles`)."""

    def __init__(self, term: Term, oracle: Oracle | None = None) -> None:
        self.term, self.case = term, rich_case()
        self.oracle = oracle or (ORACLES.get(term.name) if self.is_shipped else None)

    @property
    def is_shipped(self) -> bool:
        return type(self.term).__module__.startswith("olp.")

    @cached_property
    def forms(self) -> list[tuple[MoveTerm, Form]]:
        """The forms of a term of moves; none of a term of logs."""
        term = self.term
        return [(term, form) for form in term.forms(self.case)] if isinstance(term, MoveTerm) else []

    def smooth(self, term: MoveTerm, form: Form, values: object, case: MeasuredMoves | None = None) -> Array:
        """(n,) [s] with the form in it, without the jumps of rounding to a cycle."""
        return DurationModel((ModelPart(term, form, np.asarray(values, dtype=float)),)).smooth(
            case or self.case
        )

    @cached_property
    def plain(self) -> Array:
        return DurationModel().smooth(self.case)

    def strong(self, term: MoveTerm, form: Form) -> Array:
        """The guess that does most."""
        guesses = np.asarray(term.guesses(form, self.case), dtype=float)
        size = [np.abs(self.smooth(term, form, v) - self.plain).sum() for v in guesses]
        found: Array = guesses[int(np.argmax(size))]
        return found


def check_term(term: Term, *, oracle: Oracle | None = None, first: bool = False) -> None:
    """Raises ContractError with every promise of a physics term that `term` breaks, in recordings of many kinds.

    `oracle`: what each form does to each move, worked out anew from its equation, as in `olp.contracts.term_oracles`;
    without one, nobody can know that a formula is the right one. Terms of olp have theirs there.

        from olp.contracts import check_term
        check_term(MyTerm(), oracle=my_term)
    """
    hold(f"term {term.name}", TermUnderTest(term, oracle), PROMISES, first=first)


def says_what_it_is(it: TermUnderTest) -> Iterator[Difference]:
    """A term says what it means, which trace it leaves, its source, and what it may be taken for"""
    for name in ("summary", "does", "source"):
        words = getattr(it.term, name, "")
        if not 10 < len(words) < 250 or "\n" in words or words != words.strip(" ."):
            yield name, f"{words!r}: one line of 11 to 249 characters without a full stop is wanted"
    if not it.term.confusable or not set(it.term.confusable) <= set(term_names()) - {it.term.name}:
        yield (
            "confusable",
            f"{it.term.confusable}: wanted are names of other terms: {', '.join(term_names())}",
        )
    if not isinstance(it.term, MoveTerm | LogTerm):
        yield it.term.name, "neither a term of moves nor of logs"
    if it.is_shipped and (
        it.term.name not in term_names() or type(load_term(it.term.name)) is not type(it.term)
    ):
        yield it.term.name, "the registry of terms does not find it under the name of its file"
    if isinstance(it.term, MoveTerm) and (it.term.phase not in PHASES or it.term.stage not in set(Stage)):
        stages = ", ".join(f"Stage.{stage.name}" for stage in Stage)
        yield (
            "phase and stage",
            f"{it.term.phase}, {it.term.stage}: there are {', '.join(PHASES)}, and {stages}",
        )


def does_what_its_equation_says(it: TermUnderTest) -> Iterator[Difference]:
    """Each form changes each move as an oracle works it out anew from the equation, in every kind of recording"""
    if it.oracle is None:
        if it.is_shipped and it.forms:
            yield (
                it.term.name,
                f"no `{it.term.name.replace('-', '_')}` in olp/contracts/term_oracles.py, and none given as `oracle`",
            )
        return
    assert isinstance(it.term, MoveTerm)
    for name, case in (("a recording that tells everything", it.case), *other_cases()):
        for form in it.term.forms(case):
            guesses = np.asarray(it.term.guesses(form, case), dtype=float)
            for values in (guesses[0], guesses[-1]):
                motion = it.term.act(case.base, form, values, case)
                wanted = it.oracle(case, form, values)
                key = f"{it.term.name} {form.key}"
                near = NEAR.get(key, NEAR.get(it.term.name, 1e-9))
                for column in _COLUMNS:
                    one, other = getattr(motion, column), wanted.get(column, getattr(case.base, column))
                    if not _agree(one, other, near, COARSE.get(it.term.name, 2e-3 if near > 1e-6 else 1e-9)):
                        yield f"form {form.key!r} at {values.tolist()}, {name}", f"another {column}"


def is_told_by_what_it_did(it: TermUnderTest) -> Iterator[Difference]:
    """Where the forms hang on the measured durations, they are those of what was planted, and none of what was not"""
    look = FOUND.get(it.term.name) if it.is_shipped else None
    if look is not None:
        assert isinstance(it.term, MoveTerm)
        yield from look(it.term, rich_case(moves=150, joint_moves=0, seed=11))


_COLUMNS: Final = (
    *(
        "way",
        "speed",
        "accelerate",
        "decelerate",
        "jerk",
        "round_start",
        "round_end",
        "least",
        "added",
        "rate",
    ),
    *("cycle", "early", "timed", "law", "overlap", "split", "reach", "open_start", "open_end"),
)


def _agree(one: object, other: object, near: float, least: float) -> bool:
    if isinstance(one, str):
        return one == str(other)
    a, b = np.asarray(one, dtype=float), np.asarray(other, dtype=float)
    return bool(np.allclose(a, b, rtol=near, atol=least, equal_nan=True))


def is_as_it_was_written_down(it: TermUnderTest) -> Iterator[Difference]:
    """Its forms, equations, units, bounds, nulls, starts and sentences are those that were written down"""
    if not it.is_shipped or not DETAILS.exists():
        return
    text = DETAILS.read_text(encoding="utf-8")
    begin = text.find(f"\n## {it.term.name}\n")
    said = text[begin : text.find("\n## ", begin + 1) % (len(text) + 1)] if begin >= 0 else ""
    own = details(it.term, it.case, other_cases())
    for line in set(own.strip().split("\n")) ^ set(said.strip().split("\n")):
        where = f"{DETAILS.name}, section {it.term.name} (python bench/physics_page.py writes it)"
        yield where, f"only one of file and term says {line.strip()!r}"


def is_seen_in_logs(it: TermUnderTest) -> Iterator[Difference]:
    """A term of logs has parameters and columns that it is seen in, and none where there are no columns"""
    if not isinstance(it.term, LogTerm):
        return
    if not getattr(it.term, "parameters", ()):
        yield "parameters", "none"
    if it.term.seen_in(frozenset()) or not it.term.seen_in(_SEEN):
        yield "no columns, and all", f"seen in {it.term.seen_in(frozenset())} and {it.term.seen_in(_SEEN)}"


def sets_its_equation(it: TermUnderTest) -> Iterator[Difference]:
    """Every form and every term of logs has an equation that the report can set"""
    equations = [form.equation for _, form in it.forms]
    if isinstance(it.term, LogTerm):
        equations.append(getattr(it.term, "equation", ""))
    if it.forms and len({form.key + str(form.axis) for _, form in it.forms}) != len(it.forms):
        yield "forms", "two of them have one key"
    for one in equations:
        if not one or not mathml(one).startswith("<math"):
            yield "an equation", repr(one)


def bounds_its_parameters(it: TermUnderTest) -> Iterator[Difference]:
    """Parameters have a unit, a meaning, bounds and a null; guesses are within them and do something"""
    for term, form in it.forms:
        given = f"form {form.key!r}"
        for p in form.parameters:
            if not p.unit or not p.meaning or not p.name:
                yield given, f"{p.name} has no unit or no meaning"
            if not p.low < p.high or (p.log and p.low <= 0):
                yield given, f"{p.name} is between {p.low:g} and {p.high:g}"
            known = np.isnan(p.null) or np.isinf(p.null) or p.null == 0 or p.low <= p.null <= p.high
            if not known:
                yield given, f"the null of {p.name} is {p.null:g}"
        guesses = np.asarray(term.guesses(form, it.case), dtype=float)
        low, high = np.array([(p.low, p.high) for p in form.parameters]).T
        if guesses.ndim != 2 or not len(guesses) or guesses.shape[1] != len(form.parameters):
            yield given, f"guesses of the shape {guesses.shape}"
            continue
        if (guesses < low * (1 - 1e-12)).any() or (guesses > high * (1 + 1e-12)).any():
            yield given, "a guess is outside the bounds"
        whole = DurationModel((ModelPart(term, form, it.strong(term, form)),)).seconds(it.case)
        if np.abs(whole - it.plain).max() <= 1e-3 and not _asks_for_load(form):
            yield given, "its strongest guess changes nothing"


def _asks_for_load(form: Form) -> bool:
    return "load" in form.key


def does_nothing_at_its_null(it: TermUnderTest) -> Iterator[Difference]:
    """At its null a form changes nothing"""
    for term, form in it.forms:
        nulls = [0.0 if np.isnan(p.null) else 1e12 if np.isinf(p.null) else p.null for p in form.parameters]
        case = it.case
        if form.key == "limit" and case.rates is not None:
            # The wrist's rated acceleration is a limit without any load, too.
            case = replace(case, rates=replace(case.rates, rated_acceleration=np.full(6, 1e9)), derived={})
        off = np.abs(it.smooth(term, form, nulls, case) - DurationModel().smooth(case)).max()
        if not off <= 1e-6:
            yield f"form {form.key!r} at {nulls}", f"a duration changes by {off:.3g} s"


def acts_on_moves(it: TermUnderTest) -> Iterator[Difference]:
    """A form acts on moves and leaves waits alone, unless it is about clocks; durations stay finite and positive"""
    for term, form in it.forms:
        given = f"form {form.key!r}"
        for values in np.asarray(term.guesses(form, it.case), dtype=float):
            seconds = it.smooth(term, form, values)
            if not np.isfinite(seconds).all() or not (seconds[it.case.moving] > 0).all():
                yield given, f"a duration that is none, at {values.tolist()}"
            changed = np.abs(seconds - it.plain) > 1e-9
            if (
                term.stage is not Stage.CLOCKS
                and form.key != "waits too"
                and (changed & ~it.case.moving).any()
            ):
                yield given, "a wait changes"
            again = it.smooth(term, form, values)
            if not np.array_equal(seconds, again):
                yield given, "another duration the second time"


def keeps_what_it_is_given(it: TermUnderTest) -> Iterator[Difference]:
    """It changes neither the motion nor the case that it is given, and a part of a case is as in the whole"""
    half = np.arange(0, len(it.case), 2)
    columns = ("way", "speed", "accelerate", "decelerate", "jerk", "round_start", "round_end")
    for term, form in it.forms:
        values = it.strong(term, form)
        before = {name: np.array(getattr(it.case.base, name)) for name in columns}
        whole = term.act(it.case.base, form, values, it.case)
        for name, column in before.items():
            if not np.array_equal(getattr(it.case.base, name), column):
                yield f"form {form.key!r}", f"the motion's {name} is changed in place"
        if term.name in ("warm-up", "cycle-quantisation"):
            continue  # of the recording as a whole
        part = it.case.take(half)
        motion = term.act(part.base, form, values, part)
        same = motion.duration() * motion.rate - (whole.duration() * whole.rate)[half]
        if not np.abs(same).max() < 1e-9:
            yield f"form {form.key!r}, every second move alone", f"{np.abs(same).max():.3g} s of difference"


def never_jumps(it: TermUnderTest) -> Iterator[Difference]:
    """A duration never jumps as a value changes: halving where it changes most ends in no step"""
    for term, form in it.forms:
        for index, p in enumerate(form.parameters):
            guess = np.array(term.guesses(form, it.case)[0], dtype=float)

            def at(place: float, guess: Array = guess, index: int = index, log: bool = p.log) -> Array:
                values = guess.copy()
                values[index] = np.exp(place) if log else place
                return it.smooth(term, form, values)  # noqa: B023

            low, high = np.log([p.low, p.high]) if p.log else (p.low, p.high)
            grid = np.linspace(low, high, 13)
            durations = np.array([at(place) for place in grid])
            if not np.isfinite(durations).all():
                yield f"form {form.key!r}, {p.name} within its bounds", "a duration that is none"
                continue
            steps = np.abs(np.diff(durations, axis=0))
            k, move = np.unravel_index(steps.argmax(), steps.shape)
            a, b = float(grid[k]), float(grid[k + 1])
            for _ in range(40):  # of durations of an hour, too, no slope is left
                middle = 0.5 * (a + b)
                one, two, three = (at(x)[move] for x in (a, middle, b))
                a, b = (a, middle) if abs(two - one) > abs(three - two) else (middle, b)
            if not abs(at(b)[move] - at(a)[move]) < 1e-4:
                yield f"form {form.key!r}", f"a duration jumps at {p.name} = {np.exp(a) if p.log else a:g}"


def says_its_numbers(it: TermUnderTest) -> Iterator[Difference]:
    """What it says of its values is one clause with numbers, and its doubt of them is none below zero"""
    for term, form in it.forms:
        for values in np.asarray(term.guesses(form, it.case), dtype=float):
            says = term.says(form, values, it.case)
            words = {"nan", "inf"} & set(says.replace("%", " ").split())
            if not 10 < len(says) < 160 or says != says.strip(" .") or "\n" in says or words:
                yield f"form {form.key!r} at {values.tolist()}", repr(says)
            if not any(c.isdigit() for c in says) and "no time" not in says:
                yield f"form {form.key!r} at {values.tolist()}", f"no number: {says!r}"
            if not term.doubt(form, values) >= 0:
                yield f"form {form.key!r} at {values.tolist()}", f"a doubt of {term.doubt(form, values):g}"


def says_what_it_lacks(it: TermUnderTest) -> Iterator[Difference]:
    """Where a recording cannot tell it, it has no forms; a term with forms lacks nothing"""
    if not isinstance(it.term, MoveTerm):
        return
    if it.forms and it.term.lacks(it.case):
        yield "a recording that tells everything", f"it lacks {it.term.lacks(it.case)!r}"
    n = len(it.case)
    unknown = np.full(n, np.nan)
    silent = replace(
        it.case,
        start=np.full((n, 3), np.nan),
        end=np.full((n, 3), np.nan),
        turn=unknown,
        payload=unknown,
        payload_inertia=unknown,
        t_start=unknown,
        base=it.case.base.with_(
            speed=np.ones(n), accelerate=np.ones(n), round_start=np.zeros(n), round_end=np.zeros(n)
        ),
        rates=None,
        derived={},
    )
    lacks = it.term.lacks(silent)
    if it.term.forms(silent) and lacks:
        yield "a recording that tells little", f"it has forms and lacks {lacks!r}"
    if lacks and not (5 < len(lacks) < 250 and "\n" not in lacks):
        yield "a recording that tells little", repr(lacks)


PROMISES: Final[tuple[Promise[TermUnderTest], ...]] = (
    says_what_it_is,
    is_seen_in_logs,
    sets_its_equation,
    is_as_it_was_written_down,
    does_what_its_equation_says,
    is_told_by_what_it_did,
    bounds_its_parameters,
    does_nothing_at_its_null,
    acts_on_moves,
    keeps_what_it_is_given,
    says_its_numbers,
    says_what_it_lacks,
    never_jumps,
)


# --- What is written of a term, from the term itself ---
# Its section of `docs/physics.md`, and all its details for the tests. Readers need the trace, the equations and the
# source. Bounds, starting values and sentences hang on the recording and change with the code: they are kept beside the
# tests, where a change of any of them is seen.


_ROOT: Final = Path(__file__).resolve().parents[2]  # of a checkout
PAGE: Final = _ROOT / "docs" / "physics.md"
_ORDERS: Final = 3  # of the moves of a recording: how few tell a term hangs on which come first
_FOLLOWS: Final = ("of", "at", "that", "above")  # a meaning that goes on after the name without a comma
DETAILS: Final = _ROOT / "tests" / "data" / "physics_terms.txt"


def section(term: Term, cases: Sequence[MeasuredMoves]) -> str:
    """The section of a term on the page: each equation and each parameter that it has in any of `cases` once."""
    lines = [f"\n## {term.name}\n", f"{_sentence(term.does)}\n"]
    if (PAGE.parent / _picture(term)).exists():
        lines.append(f"![{term.name}]({_picture(term)})\n")
    if isinstance(term, MoveTerm):
        forms = [form for case in cases for form in term.forms(case)]
        lines += _equations(term, forms)
        lines += _meanings(
            p for form in forms for p in form.parameters if form.axis < 0 or _alone(form, forms)
        )
    if isinstance(term, LogTerm):
        lines.append(f"- in logs: ${term.equation}$")  # type: ignore[attr-defined]
        lines += _meanings(term.parameters)  # type: ignore[attr-defined]
    return "\n".join([*lines, f"\nSource: {_sentence(term.source)}\n"])


def _alone(form: Form, forms: Sequence[Form]) -> bool:
    """Whether a form of an axis is the first one, and no form of all axes explains its parameter."""
    axes = [one for one in forms if one.axis >= 0]
    names = {p.name for one in forms if one.axis < 0 for p in one.parameters}
    return form is axes[0] and not any(p.name.rsplit("_", 1)[0] in names for p in form.parameters)


def _equations(term: MoveTerm, forms: Sequence[Form]) -> Iterator[str]:
    """Each equation with the names of the forms that have it."""
    names: dict[str, dict[str, None]] = {}
    for form in forms:
        names.setdefault(form.equation, {})["one axis" if form.axis >= 0 else form.key or "plain"] = None
    if not forms:
        yield f"- ${term.equation}$, the lateness beside all other terms"  # type: ignore[attr-defined]
    for equation, those in names.items():
        which = "" if list(those) == ["plain"] else ", ".join(f"`{name}`" for name in those) + ": "
        yield f"- {which}${equation}$"


def _meanings(parameters: Iterable[TermParameter]) -> list[str]:
    """Each parameter once, also where moves of another kind give it in another unit; [] without parameters."""
    known: dict[tuple[str, str], str] = {}
    for p in parameters:
        unit = "" if p.unit == "1" else f" [{p.unit}]"
        follows = " " if p.meaning.split()[0] in _FOLLOWS else ", "
        known.setdefault((p.name, p.meaning), f"`{p.name}`{follows}{p.meaning}{unit}")
    return [f"    - {'; '.join(known.values())}"] if known else []


def details(term: Term, case: MeasuredMoves, others: Sequence[tuple[str, MeasuredMoves]]) -> str:
    """All of a term: its forms in a recording that tells everything, `case`, and what `others` have instead."""
    lines = [f"\n## {term.name}\n", f"{_sentence(term.summary)} Trace: {term.does}.\n"]
    if isinstance(term, MoveTerm):
        lines.append(_place(term))
        lines += _forms(term, case)
        lines += _elsewhere(term, case, others)
    if isinstance(term, LogTerm):
        lines.append(f"- in logs: ${term.equation}$")  # type: ignore[attr-defined]
        lines += [_parameter(p) for p in term.parameters]  # type: ignore[attr-defined]
    return "\n".join([*lines, f"\nSource: {_sentence(term.source)}\n"])


def _place(term: MoveTerm) -> str:
    """Where in a move the term acts, among which others, and on which moves."""
    which = "on single moves too" if term.conditionable else "on all moves alone"
    grows = ", changes with the running time" if term.by_time else ""
    looks = f"; may look like {', '.join(term.confusable)}" if term.confusable else ""
    return f"- phase {term.phase}, stage {term.stage.name.lower()}, {which}{grows}{looks}"


def _picture(term: Term) -> str:
    """Seen from the page."""
    return f"images/physics/{term.name}.svg"


def _forms(term: MoveTerm, case: MeasuredMoves) -> Iterator[str]:
    """A list of forms with their parameters; axes of one limit share a line."""
    forms = term.forms(case)
    if not forms:
        yield f"- ${term.equation}$, the lateness beside all other terms"  # type: ignore[attr-defined]
    yield from _listed(term, forms, case)


def _listed(term: MoveTerm, forms: Sequence[Form], case: MeasuredMoves) -> Iterator[str]:
    """Forms with their parameters; of those of single axes the first one whole, and the bounds of the others."""
    axes = [form.key for form in forms if form.axis >= 0]
    first = next((form for form in forms if form.axis >= 0), None)
    for form in forms:
        if form.axis >= 0 and form is not first:
            yield from (_parameter(p) for p in form.parameters)
            continue
        key = f"each of {', '.join(axes)}" if form.axis >= 0 else form.key
        yield f"- {key + ': ' if key else ''}${form.equation}$"
        yield from (_parameter(p) for p in form.parameters)
        yield from _search(term, form, case)


def _elsewhere(
    term: MoveTerm, case: MeasuredMoves, others: Sequence[tuple[str, MeasuredMoves]]
) -> Iterator[str]:
    """From how many moves on it is told, and which forms other recordings have instead."""
    forms = term.forms(case)
    fewest = next((n for n in range(1, len(case) + 1) if term.forms(case.take(np.arange(n)))), 0)
    if fewest:
        mixed = [np.random.default_rng(seed).permutation(len(case)) for seed in range(_ORDERS)]
        others_first = ", ".join(str(_fewest(term, case, order)) for order in mixed)
        yield f"- told from the first {fewest} of these moves on, in other orders from {others_first}"
    known = {_told(form) for form in forms}
    for name, other in others:
        there = term.forms(other)
        gone = [
            form.key or "the plain form" for form in forms if _told(form) not in {_told(one) for one in there}
        ]
        more = [
            form.key or "another plain form"
            for form in there
            if _told(form) not in {_told(one) for one in forms}
        ]
        if gone or more:
            less = f" without {', '.join(gone)}" if gone else ""
            and_ = f" with {', '.join(more)}" if more else ""
            yield f"- recordings {name}:{less}{';' if gone and more else ''}{and_}"
        new = [form for form in there if _told(form) not in known]
        known |= {_told(form) for form in there}
        yield from (f"    {line}" for line in _listed(term, tuple(new), other))


def _fewest(term: MoveTerm, case: MeasuredMoves, order: NDArray[np.int64]) -> int:
    """How many moves in this order tell the term: halving, as if more never told less."""
    return bisect_left(range(1, len(order)), True, key=lambda n: bool(term.forms(case.take(order[:n])))) + 1


def _told(form: Form) -> tuple[object, ...]:
    """What tells a form from others: bounds hang on the recording."""
    return form.key, form.equation, tuple((p.name, p.unit) for p in form.parameters)


def _search(term: MoveTerm, form: Form, case: MeasuredMoves) -> Iterator[str]:
    """Where the search begins, and what a diagnosis would say there; what values cost that physics does not expect."""
    guesses = np.asarray(term.guesses(form, case), dtype=float)
    starts = "; ".join(", ".join(_number(value) for value in guess) for guess in guesses.tolist())
    yield f"    - sought from {starts}"
    ends = [np.array([getattr(p, side) for p in form.parameters]) for side in ("low", "high")]
    says = dict.fromkeys(term.says(form, values, case) for values in (guesses[0], guesses[-1], ends[0]))
    yield from (f"    - “{words}”" for words in says)
    costs = [term.doubt(form, values) for values in (*ends, guesses[0])]
    if any(costs):
        when = "" if all(costs) else " where values are not expected"
        yield f"    - doubted by {_number(max(costs))} in BIC{when}"


def _parameter(p: TermParameter) -> str:
    null = "" if np.isnan(p.null) else f"; null {_number(p.null)}"
    unit = "" if p.unit == "1" else f" {p.unit}"
    how = ", by its logarithm" if p.log else ""
    return f"    - `{p.name}`, {p.meaning}: {_number(p.low)} to {_number(p.high)}{unit}{null}{how}"


def _number(value: float) -> str:
    return "∞" if np.isinf(value) else f"{value:.3g}"


def _sentence(text: str) -> str:
    first = text[0].upper() if text[1].isalpha() else text[0]
    return first + text[1:] + "."
