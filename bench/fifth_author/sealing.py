"""Draw a case: cell, arm, controller, effects that can be seen, a recorder; write the recording and the answer."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .arm import Floats, WristedArm
from .cells import CELLS, ProgramMove, Rng, make_program
from .effects import ALONG_THE_PATH, EFFECTS, Numbers, Site, outside, possible
from .engine import Controller, run
from .recorders import Recorder, draw_dress, draw_recorder, record, write_head, write_table

FAMILIES = ("one", "two", "region", "nothing", "outside")
_SHARES = (0.5, 0.18, 0.1, 0.11, 0.11)


@dataclass(frozen=True)
class Sealed:
    """A case before it is recorded: durations with and without what is sealed, and the answer."""

    moves: list[ProgramMove]
    judged: Floats
    real: Floats
    answer: dict[str, object]


def draw_arm(rng: Rng) -> WristedArm:
    """An arm of 5 to 50 kg with a tool along the flange's axis."""
    s = float(rng.uniform(0.75, 1.4))
    links = tuple(float(round(s * v * rng.uniform(0.93, 1.07))) for v in (150, 600, 120, 640, 100))
    speeds = tuple(np.radians(rng.uniform(0.85, 1.15) * v / s**0.5) for v in (180, 170, 185, 350, 340, 500))
    accelerations = tuple(v / t for v, t in zip(speeds, rng.uniform(0.18, 0.4, 6), strict=True))
    links5 = (links[0], links[1], links[2], links[3], links[4])
    return WristedArm(f"A{int(s * 100)}", links5, speeds, accelerations, float(rng.choice([0, 80, 150])))


def draw_controller(rng: Rng, arm: WristedArm) -> Controller:
    """A controller as the judged simulation knows it."""
    law = str(rng.choice(["trapezoid", "trapezoid", "s-curve", "filter"]))
    return Controller(
        acceleration=float(rng.choice([1500, 2000, 2500, 3500, 5000])),
        axis_speeds=arm.speeds,
        axis_accelerations=arm.accelerations,
        ramp_time=0.0 if law == "trapezoid" else float(rng.choice([0.04, 0.06, 0.1])),
        s_curve=law == "s-curve",
        settle=float(rng.choice([0.0, 0.0, 0.05])),
        overlap=bool(rng.random() < 0.5),
    )


def _conditions(rng: Rng, moves: list[ProgramMove]) -> tuple[str, Floats]:
    """A condition that holds for 15 to 60 % of the moves."""
    columns = {
        "y": np.array([m.end[1] for m in moves]),
        "z": np.array([m.end[2] for m in moves]),
        "length": np.array([m.length for m in moves]),
        "speed": np.array([m.speed * (1 if m.kind == "linear" else 1e-3) for m in moves]),
        "payload": np.array([m.payload for m in moves]),
    }
    for _ in range(40):
        name = str(rng.choice(list(columns)))
        bound = float(np.quantile(columns[name], rng.uniform(0.4, 0.85)))
        mask = columns[name] > bound
        if 0.15 * len(moves) < mask.sum() < 0.6 * len(moves):
            return f"{name} > {bound:.4g}", mask.astype(float)
    mask = np.arange(len(moves)) % 2 == 0
    return "all", np.ones(len(mask))


def _waits(rng: Rng, moves: list[ProgramMove]) -> Floats:
    """Waits of their own at 6 to 15 % of the moves."""
    late = (rng.random(len(moves)) < rng.uniform(0.06, 0.15)) & np.array([m.kind != "wait" for m in moves])
    return late * (0.05 + rng.exponential(0.4, len(moves)))


def _apply(moves: list[ProgramMove], arm: WristedArm, layers: list[tuple[Controller, Floats]]) -> Floats:
    """Durations where each layer's controller acts on its moves."""
    controllers = [layers[0][0]] * len(moves)
    for controller, mask in layers[1:]:
        controllers = [controller if on else c for c, on in zip(controllers, mask, strict=True)]
    return run(moves, controllers, arm)


def draw_case(rng: Rng, family: str) -> Sealed:
    """A case of a family whose effects are 2.5 to 40 times the recorder's noise, and unlike each other."""
    while True:
        arm, cell = draw_arm(rng), str(rng.choice(list(CELLS)))
        moves = make_program(rng, arm, cell, int(rng.integers(30, 250)))
        base = draw_controller(rng, arm)
        sealed = _seal(rng, family, moves, arm, base)
        if sealed is not None:
            real, numbers, recorder, more = sealed
            judged = run(moves, [base] * len(moves), arm)
            answer = {
                "family": family,
                "cell": cell,
                "numbers": numbers,
                "sigma": recorder.sigma,
                "recorder": [recorder.kind, recorder.size],
            }
            names = [] if family == "outside" else list(numbers)
            answer |= {
                "names": names,
                "rms": float(np.sqrt(np.mean((real - judged) ** 2))),
                "acceleration": base.acceleration,
            } | more
            answer |= {
                "law": "s" if base.s_curve else "filter" if base.ramp_time else "trapezoid",
                "ramp_time": base.ramp_time,
                "overlap": base.overlap,
            }
            return Sealed(moves, judged, real, answer | {"arm": arm, "recorder_object": recorder})


def _seal(
    rng: Rng, family: str, moves: list[ProgramMove], arm: WristedArm, base: Controller
) -> tuple[Floats, dict[str, Numbers], Recorder, dict[str, object]] | None:
    """Real durations, the numbers per name, the recorder; none where the draw cannot be seen."""
    site = Site(moves, arm, base)
    judged = run(moves, [base] * len(moves), arm)
    if family == "nothing":
        return judged, {}, draw_recorder(rng, fine=False), {}
    if family == "outside":
        recorder = draw_recorder(rng, fine=False)
        name, added = outside(rng, site, judged)
        good = 2.5 < np.sqrt(np.mean(added**2)) / recorder.sigma < 40
        return (judged + added, {name: {}}, recorder, {}) if good else None
    names = [
        str(n) for n in rng.choice([*EFFECTS, "external-wait"], 2 if family == "two" else 1, replace=False)
    ]
    if not all(possible(n, site) for n in names) or (
        family == "region"
        and names[0] in ("clock", "blending", "warm-up", "cycle-quantisation", "external-wait", "speed-clamp")
    ):
        return None
    if base.s_curve and set(names) & set(ALONG_THE_PATH):
        return None
    recorder = draw_recorder(rng, fine="cycle-quantisation" in names)
    where, mask = _conditions(rng, moves) if family == "region" else ("", np.ones(len(moves)))
    if where == "all":
        return None
    controller, numbers, deltas, late = base, dict[str, Numbers](), [], np.zeros(len(moves))
    for name in names:
        if name == "external-wait":
            late = _waits(rng, moves)
            numbers[name] = {}
            deltas.append(late)
            continue
        alone, numbers[name] = EFFECTS[name](rng, base, site)
        deltas.append(_apply(moves, arm, [(base, mask), (alone, mask)]) - judged)
        changed = {k: v for k, v in vars(alone).items() if v != vars(base)[k]}
        controller = Controller(**{**vars(controller), **changed})
    if not all(_seen(d, recorder.sigma) for d in deltas) or _alike(deltas):
        return None
    real = _apply(moves, arm, [(base, mask), (controller, mask)]) + late
    acts = np.flatnonzero(np.abs(real - judged) > 2 * recorder.sigma).tolist()
    return real, numbers, recorder, {"condition": where, "acts": acts}


def _seen(delta: Floats, sigma: float) -> bool:
    return bool(2.5 < np.sqrt(np.mean(delta**2)) / sigma < 40 and np.sum(np.abs(delta) > 2 * sigma) >= 6)


def _alike(deltas: list[Floats]) -> bool:
    return len(deltas) > 1 and abs(float(np.corrcoef(*deltas)[0, 1])) > 0.9


def generate(folder: Path, seed: int, cases: int) -> None:
    """Write the recordings, and the answers beside them."""
    folder.mkdir(parents=True, exist_ok=True)
    answers = {}
    for k in range(cases):
        rng = np.random.default_rng([seed, k])
        family = str(rng.choice(FAMILIES, p=_SHARES))
        case = draw_case(rng, family)
        name = f"{k:03d}"
        home = folder / name
        home.mkdir(exist_ok=True)
        answer = dict(case.answer)
        arm, recorder = answer.pop("arm"), answer.pop("recorder_object")
        assert isinstance(arm, WristedArm)
        assert isinstance(recorder, Recorder)
        dress = draw_dress(rng, case.moves, set(case.answer["names"]))  # pyrefly: ignore
        write_table(
            rng,
            home,
            case.moves,
            record(rng, recorder, case.real),
            case.judged,
            dress,
            float(case.answer["acceleration"]),
        )  # pyrefly: ignore
        write_head(home, recorder, dress, arm, rng)
        answers[name] = answer | {"moves": len(case.moves), "dress": vars(dress)}
    (folder / "answers.json").write_text(json.dumps(answers, indent=1))
