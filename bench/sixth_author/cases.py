"""Draws cells and what is hidden in them, and writes recordings with their sealed truth."""

import math
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from bench.sixth_author.arm import RedrawError, draw_arm
from bench.sixth_author.effects import (
    TERMS,
    Cell,
    Changes,
    Hidden,
    drawn,
    likeness,
    number,
    outside,
    shown_by,
)
from bench.sixth_author.files import Case, Effect, rms, write_case
from bench.sixth_author.motion import Controller, Engine
from bench.sixth_author.programs import PROGRAMS, Rng

FAMILIES = {
    "one": 0.40,
    "two": 0.20,
    "cancelled": 0.05,
    "fudged": 0.05,
    "rare": 0.10,
    "nothing": 0.08,
    "clock": 0.04,
    "outside": 0.08,
}
_CANCELLED = (
    ("speed-scale", "settling"), ("acceleration", "dispatch"), ("acceleration", "jerk"), ("acceleration", "gravity"),
    ("speed-scale", "acceleration"), ("acceleration", "speed-clamp"), ("acceleration", "settling"),
    ("speed-scale", "dispatch"), ("acceleration", "payload"), ("acceleration", "reach-inertia"),
    ("speed-scale", "warm-up"), ("blending", "settling"),
)  # fmt: skip
_FUDGED = (
    "jerk", "gravity", "reach-inertia", "payload", "settling", "dispatch", "speed-clamp", "orientation-limit",
    "warm-up", "speed-scale", "joint-speed-limit",
)  # fmt: skip
_RARE = (
    "speed-clamp", "acceleration", "settling", "speed-scale", "dispatch", "joint-speed-limit", "external-wait",
    "jerk", "orientation-limit",
)  # fmt: skip
_BY_AXES = {"joint-acceleration-limit", "joint-speed-limit", "torque-speed"}
_ALONG_PATHS = {"gravity", "reach-inertia", "speed-clamp", "orientation-limit"}  # not shown by joint moves
_GIVE_UP = 60  # draws


@dataclass
class _Bag:
    """What has been hidden so far, so that every cause has its turn."""

    rng: Rng
    used: dict[str, int] = field(default_factory=lambda: dict.fromkeys(TERMS, 0))

    def least(self) -> str:
        """A cause that was hidden least often."""
        return TERMS[int(np.argmin([self.used[term] + self.rng.random() * 0.9 for term in TERMS]))]

    def rarest(self, terms: tuple[str, ...], rng: Rng) -> str:
        """One of some causes that was hidden least often, or nearly so."""
        return terms[int(np.argmin([self.used[term] + 1.3 * rng.random() for term in terms]))]

    def beside(self, term: str, rng: Rng) -> list[str]:
        """The cause and one more, which some program shows with it."""
        shown = set(shown_by(term))
        others = [t for t in TERMS if t not in (term, "cycle-quantisation") and set(shown_by(t)) & shown]
        weights = np.array([1 / (1 + self.used[t]) for t in others])
        other = str(rng.choice(others, p=weights / weights.sum()))
        return [other, term] if term == "cycle-quantisation" else [term, other]


def generate(folder: Path, seed: int, count: int) -> None:
    """Writes `count` cases: FOLDER/cases/NAME with the recording and FOLDER/truth/NAME.json."""
    rng = np.random.default_rng(seed)
    families = _families(rng, count)
    bag = _Bag(rng)
    for i, family in enumerate(families):
        main = bag.least() if family in ("one", "two") else ""
        tries = 0
        while True:
            tries += 1
            own = np.random.default_rng([seed, i, tries])
            terms = _terms(own, family, main, bag)
            try:
                write_case(own, folder, f"{i:03d}", _case(own, family, terms))
                break
            except RedrawError:
                if tries > 400:
                    raise
            if tries % _GIVE_UP == 0 and main:
                bag.used[main] += 1
                main = bag.least()
        for term in terms:
            bag.used[term] += 1


def _families(rng: Rng, count: int) -> list[str]:
    """The family of each case, in their shares and shuffled."""
    places = (np.arange(count) + rng.random()) / count
    names = list(FAMILIES)
    ends = np.cumsum(list(FAMILIES.values()))
    families = [names[min(int(np.searchsorted(ends, place)), len(names) - 1)] for place in places]
    rng.shuffle(families)
    return families


def _terms(rng: Rng, family: str, main: str, bag: _Bag) -> list[str]:
    """What is hidden in a case."""
    if family == "one":
        return [main]
    if family == "two":
        return bag.beside(main, rng)
    if family == "cancelled":
        return list(_CANCELLED[rng.integers(len(_CANCELLED))])
    if family in ("fudged", "rare"):
        return [bag.rarest(_FUDGED if family == "fudged" else _RARE, rng)]
    return []


def draw_cell(rng: Rng, term: str, terms: list[str], count: int | None = None) -> Cell:
    """A cell whose program shows some causes, `term` among them."""
    programs = [p for p in shown_by(term) if all(p in shown_by(t) for t in terms)]
    if not programs:
        raise RedrawError("no program")
    program = programs[rng.integers(len(programs))]
    size = count or int(np.clip(np.exp(rng.uniform(np.log(28), np.log(250))), 25, 250))
    if {"payload-inertia", "torque-speed"} & set(terms):
        size = max(size, 64)
    by_axes = bool(_BY_AXES & set(terms))
    by_joints = rng.random() < (0.5 if by_axes else 0.2) and not _ALONG_PATHS & set(terms)
    turning = "orientation-limit" in terms or rng.random() < 0.35 or (by_axes and program != "joints")
    arm = draw_arm(rng)
    moves = PROGRAMS[program](rng, size, by_joints, turning)
    base = _controller(rng, program, terms, any(move.blend > 0 for move in moves), turning)
    fixed = {"reach-inertia", "joint-acceleration-limit", "joint-speed-limit"} & set(terms)
    straight = all(move.kind != "joint" for move in moves)
    gantry = bool(program != "joints" and straight and not fixed and rng.random() < 0.18)
    if gantry:
        base = replace(base, slides=rng.uniform(0.6, 1.5, 3))
    engine = Engine(moves, arm, base)
    whole = float(engine.run().sum())
    reach = float(np.round(np.quantile(engine.way(1.0).reach, rng.choice([0.1, 0.5])), -1))
    return Cell(engine, program, gantry, reach, whole)


def _controller(rng: Rng, program: str, terms: list[str], rounded: bool, turning: bool) -> Controller:
    """What the simulation takes for the controller."""
    acceleration = float(np.round(rng.uniform(1200, 6000), -1 if rng.random() < 0.5 else -2))
    across = acceleration * rng.uniform(0.5, 1)
    if program in ("weld", "glue", "inspect"):
        acceleration = across = float(np.round(rng.uniform(500, 3000), -1))
    if "jerk" in terms:
        if rounded:
            raise RedrawError("corners")
        law = "dS"
    elif rounded or {"torque-speed", "viscous-friction"} & set(terms):
        law = str(rng.choice(["trap", "fir"]))
    else:
        short = {"acceleration", "gravity", "payload", "reach-inertia"} & set(
            terms
        )  # a shortest ramp hides them
        law = str(rng.choice(["trap", "fir", "dS", "sin2"] + ([] if short else ["ramp"])))
    told = Controller(acceleration, across, law=law, ramp_time=float(rng.uniform(0.04, 0.16)))
    if law == "dS" and "jerk" not in terms:
        told = replace(told, jerk=acceleration / rng.uniform(0.04, 0.15))
    if "orientation-limit" not in terms and turning:
        rate = math.radians(rng.uniform(120, 260))
        told = replace(told, turn_speed=rate, turn_acceleration=rate / 0.2)
    return told


def _case(rng: Rng, family: str, terms: list[str]) -> Case:
    """A case of a family before it is recorded; a draw that nobody could solve is drawn again."""
    ratio = float(np.exp(rng.uniform(np.log(1.5), np.log(12))))  # of the effect over the noise
    if terms:
        return _hidden_case(rng, family, terms, ratio)
    term = str(rng.choice(["acceleration", "settling", "speed-scale", "warm-up"]))
    cell = draw_cell(rng, term, [term])
    if family == "nothing":
        times = cell.engine.run()
        return Case(family, cell, times, times, [], float(np.exp(rng.uniform(np.log(0.002), np.log(0.03)))))
    return _clock_case(rng, cell, ratio) if family == "clock" else _outside_case(rng, cell, ratio)


def _clock_case(rng: Rng, cell: Cell, ratio: float) -> Case:
    """The recorder's clock runs fast or slow, or drifts."""
    simulated = cell.engine.run()
    off = rng.uniform(0.01, 0.05) * rng.choice([-1, 1])
    drifts = rng.random() < 0.35
    real = simulated * (1 + off * (np.cumsum(simulated) / simulated.sum() if drifts else 1))
    told = {} if drifts else {"rate": float(1 + off)}
    hidden = Hidden({}, {}, {"rate": number(1 + off, "1"), "drifting": drifts}, told)
    noise = max(rms(real - simulated) / ratio, 0.001)
    alike = [["clock", "warm-up"]] if drifts else []
    return Case(
        "clock", cell, real, simulated, [Effect("clock", hidden, None, real - simulated)], noise,
        alike=[*alike, ["clock", "speed-scale"]],
        note=f"recorder's clock {'drifts to' if drifts else 'runs at'} 1{off:+.4f}",
    )  # fmt: skip


def _outside_case(rng: Rng, cell: Cell, ratio: float) -> Case:
    """A law of no list, which no term of the list explains."""
    law = outside(rng, cell)
    simulated = cell.engine.run()
    late = law.seconds - simulated
    noise = rms(late) / max(ratio, 3.0)
    if not 0.001 < noise < 0.08:
        raise RedrawError("size")
    like = likeness(cell, {}, late, [], noise, None)
    share = like.left * noise**2 / (late @ late)
    if share < 0.55:
        raise RedrawError("explained")
    note = f"{law.note}; best term of the list: {like.nearest} leaves {100 * share:.0f} % of the squares"
    return Case("outside", cell, law.seconds, simulated, [], noise, note=note, columns=law.columns)


@dataclass
class _Where:
    """The moves of an effect under a condition (n,)."""

    mask: np.ndarray
    condition: str


def _hidden_case(rng: Rng, family: str, terms: list[str], ratio: float) -> Case:
    """One or two causes of the list."""
    cell = draw_cell(rng, terms[0], terms)
    causes = [drawn(term, cell, rng) for term in terms]
    changes: Changes = {}
    simulation: Changes = {}
    for cause in causes:
        changes |= cause.real
        simulation |= cause.simulated
    plain = cell.engine.run(**simulation)
    where = None
    if family == "rare" and terms[0] not in ("joint-speed-limit", "external-wait"):
        where = _condition(rng, cell)
    real = cell.engine.run(**(simulation | changes))
    if where:
        real = np.where(where.mask, real, plain)
    effects = _effects(cell, terms, causes, where, real, plain, simulation)
    if family == "cancelled":
        first, second = (effect.seconds.mean() for effect in effects)
        if first * second >= 0 or not 0.6 < -first / second < 1.67:
            raise RedrawError("does not cancel")
    case = Case(family, cell, real, plain, effects, 0.0)
    if family == "fudged":
        case = _fudged(case, simulation)
    case.noise = _noise(case, changes, ratio)
    _judge_likeness(case, simulation)
    if changes.get("cycle") and changes["rounds_up"]:
        case.tolerated += ["dispatch", "settling"]
    if where:
        case.shows = where.condition.split()[0]
    return case


def _condition(rng: Rng, cell: Cell) -> _Where:
    """A part of the space, of the loads or of the jobs."""
    kind = str(rng.choice(["x", "y", "z", "payload", "job"]))
    part = rng.uniform(0.08, 0.35)
    if kind in ("x", "y", "z"):
        if cell.by_joints:
            raise RedrawError("no points")
        ends = np.array([move.end for move in cell.moves])[:, "xyz".index(kind)]
        limit = float(np.round(np.quantile(ends, 1 - part)))
        found = _Where(ends > limit, f"{kind}_end > {limit:g} mm")
    elif kind == "payload":
        loads = np.array([move.payload for move in cell.moves])
        limit = loads.max() * 0.7
        found = _Where(loads > limit, f"payload > {limit:g} kg")
    else:
        jobs = np.array([move.job for move in cell.moves])
        names = np.unique(jobs)
        job = names[rng.integers(len(names))]
        found = _Where(jobs == job, f"job = {job}")
    if not 4 <= found.mask.sum() <= 0.45 * len(cell.moves):
        raise RedrawError("share")
    return found


def _effects(
    cell: Cell,
    terms: list[str],
    causes: list[Hidden],
    where: _Where | None,
    real: np.ndarray,
    plain: np.ndarray,
    simulation: Changes,
) -> list[Effect]:
    """What each cause adds to the others, seconds (n,)."""
    if len(terms) == 1:
        return [Effect(terms[0], causes[0], where.condition if where else None, real - plain)]
    found = []
    for term, cause in zip(terms, causes, strict=True):
        left: Changes = {}
        for other in causes:
            left |= other.simulated if other is cause else other.real
        found.append(Effect(term, cause, None, real - cell.engine.run(**(simulation | left))))
    return found


def _fudged(case: Case, simulation: Changes) -> Case:
    """The case with a simulation whose acceleration was tuned until the sum was right."""
    if (case.real - case.simulated).mean() == 0:
        raise RedrawError("nothing to tune")
    engine, own = case.cell.engine, case.cell.base.acceleration
    low, high = np.log(0.25), np.log(4)
    middle = tuned = 0.0
    for _ in range(30):
        middle = (low + high) / 2
        tuned = own * math.exp(middle)
        late = (case.real - engine.run(**(simulation | {"acceleration": tuned}))).mean()
        low, high = (low, middle) if late > 0 else (middle, high)
    if not 0.03 <= abs(middle) <= 1.2:
        raise RedrawError("tuned too far")
    simulated = engine.run(**(simulation | {"acceleration": tuned}))
    return replace(
        case,
        simulated=simulated,
        acceleration=tuned,
        tuning=case.simulated - simulated,
        fudge={"acceleration_factor_real_over_sim": own / tuned},
        tolerated=["acceleration"],
    )


def _noise(case: Case, changes: Changes, ratio: float) -> float:
    """The recorder's noise [s] at which the case is fair."""
    sizes = [rms(effect.seconds) for effect in case.effects]
    if max(sizes) > 8 * min(sizes):
        raise RedrawError("sizes")
    if case.fudge:
        noise = min(rms(case.real - case.simulated), sizes[0]) / min(ratio, 6)
    else:
        noise = min(sizes) / ratio
    cycle = changes.get("cycle")
    if cycle:
        noise = min(noise, float(cycle) / 8)
    first = np.abs(case.effects[0].seconds)
    if case.family == "rare" and np.mean(first > 0.05 * first.max()) > 0.45:
        raise RedrawError("not rare")
    if not 0.0008 < noise < 0.05:
        raise RedrawError("noise")
    if max(sizes) > 12 * noise * (1.7 if len(sizes) > 1 else 1.0) and not cycle and not case.fudge:
        raise RedrawError("too plain")
    return noise


def _judge_likeness(case: Case, simulation: Changes) -> None:
    """Writes down what each effect may be called as well; one that is a change of the others' size is no case."""
    tuning = [] if case.tuning is None else [case.tuning]
    for effect in case.effects:
        others = [other.seconds for other in case.effects if other is not effect] + tuning
        if others:
            shapes = np.stack(others, 1)
            rest = effect.seconds - shapes @ np.linalg.lstsq(shapes, effect.seconds, rcond=None)[0]
            if (rest**2).sum() / case.noise**2 < 30:
                raise RedrawError("alike")
        size = np.abs(effect.seconds)
        if (size > max(case.noise, 0.05 * size.max())).sum() < 3:
            raise RedrawError("few moves")
        if effect.term in ("external-wait", "cycle-quantisation"):
            continue
        like = likeness(case.cell, simulation, effect.seconds, others, case.noise, effect.term)
        alike = like.alike
        if effect.term == "coulomb-friction" and "acceleration" not in alike:
            alike = [*alike, "acceleration"]  # a constant friction of all axes is one, in durations
        if len(alike) > 3:
            raise RedrawError("alike")
        case.alike += [[effect.term, other] for other in alike]
        case.note += f"{effect.term}: nearest other term {like.nearest} leaves {like.left:.0f} sigma^2. "
