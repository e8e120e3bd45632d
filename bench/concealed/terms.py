"""What each term needs of a program, how strong it can be, and what its true parameter is."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bench.concealed.effects import G, Hidden, World
from bench.concealed.programs import Plan


class Kind(NamedTuple):
    """`low`, `high`: strengths, in the units of effects.py. `robot`: the recording must name a robot."""

    low: float
    high: float
    robot: bool = False


KINDS = {
    "acceleration": Kind(0.004, 1.2),
    "jerk": Kind(0.002, 0.3),
    "gravity": Kind(0.003, 1.0),
    "reach-inertia": Kind(0.005, 1.5),
    "payload": Kind(1e-4, 0.12),
    "payload-inertia": Kind(0.05, 20.0, True),
    "joint-acceleration-limit": Kind(0.25, 5.0, True),
    "joint-speed-limit": Kind(0.4, 4.0, True),
    "torque-speed": Kind(0.2, 1.6, True),
    "speed-clamp": Kind(0.02, 3.0),
    "orientation-limit": Kind(0.4, 12.0),
    "speed-scale": Kind(5e-4, 0.4),
    "settling": Kind(3e-4, 0.5),
    "dispatch": Kind(3e-4, 0.5),
    "blending": Kind(1.0, 1.0),
    "cycle-quantisation": Kind(1e-3, 0.12),
    "warm-up": Kind(5e-4, 0.3),
    "external-wait": Kind(1e-3, 3.0),
    "viscous-friction": Kind(0.01, 3.0),
    "coulomb-friction": Kind(0.02, 0.6),
    "clock": Kind(0.001, 0.02),
    "outside": Kind(1e-3, 0.3),
}
SINGLE = [t for t in KINDS if t not in ("outside", "clock", "viscous-friction", "coulomb-friction")]


def plan_for(dice: np.random.Generator, terms: list[str], moves: int, rich: bool = True) -> Plan:
    """A program that an engineer would run to see these effects; `rich` False: a poor one, all alike."""
    top = dice.choice([0.5, 1.0, 1.5, 2.0])
    speeds = tuple(np.round(top * np.array([0.1, 0.25, 0.5, 0.75, 1.0])[dice.integers(0, 3) :], 3).tolist())
    plan = Plan(moves, (0.02, 1.2), speeds, float(dice.choice([0.5, 1.0, 2.0, 3.0, 5.0])))
    wanted = set(terms)
    plan = replace(
        plan, blended=float(dice.choice([0.0, 0.0, 0.3])), waits=float(dice.choice([0.0, 0.0, 0.04]))
    )
    if wanted & {"settling", "dispatch", "blending"}:
        plan = replace(plan, blended=float(dice.uniform(0.35, 0.65)))
    if wanted & {"gravity"}:
        plan = replace(plan, acceleration=float(dice.choice([0.8, 1.5, 3.0, 5.0])))
    if wanted & {"payload"} or dice.random() < 0.15:
        plan = replace(
            plan, loads=((0.0, 5.0, 10.0, 20.0), (0.0, 12.0), (0.0, 2.0, 3.5, 8.0))[dice.integers(3)]
        )
    if wanted & {"payload-inertia"}:
        plan = replace(plan, inertias=(0.0, 0.1, 0.3, 0.8), joint_moves=0.4, turning=0.5)
    elif not wanted & {"jerk", "gravity", "blending"} and dice.random() < 0.15:
        plan = replace(plan, joint_moves=0.2)
    if wanted & {"orientation-limit"} or dice.random() < 0.2:
        plan = replace(plan, turning=0.45)
    if wanted & {"joint-acceleration-limit"}:
        plan = replace(
            plan, acceleration=float(dice.choice([4.0, 6.0, 9.0])), speeds=(0.25, 0.5, 1.0, 1.5, 2.0)
        )
    if wanted & {"joint-speed-limit"}:
        plan = replace(
            plan, wrist_forward=True, speeds=(0.25, 0.5, 1.0, 1.5), acceleration=4.0, joint_moves=0.0
        )
    if wanted & {"torque-speed"}:
        plan = replace(
            plan, speeds=(0.3, 0.6, 1.0, 1.5, 2.0, 2.5), acceleration=float(dice.choice([3.0, 5.0]))
        )
    if not rich:
        plan = replace(
            plan, speeds=plan.speeds[-1:], blended=0.0, waits=0.0, lengths=(0.25, 0.5), loads=plan.loads[:0]
        )
    repeats = int(dice.choice([1, 1, 2, 3, 5]))
    if repeats > 1 and moves // repeats >= 30 and "warm-up" not in wanted:
        plan = replace(plan, cycles=repeats)
    elif "warm-up" in wanted and moves >= 120:
        plan = replace(plan, cycles=int(dice.choice([1, 4])))
    return plan


def hidden_for(dice: np.random.Generator, term: str, world: World) -> Hidden:
    """The effect with its fixed choices; its strength is set later."""
    n = len(world.moves)
    body = bool(dice.random() < 0.5) and term in ("gravity", "reach-inertia", "payload")
    choice, draw = 1.0, None
    if term in ("acceleration", "speed-scale"):
        choice = float(dice.choice([1.0, 1.0, -1.0]))
    elif term == "torque-speed":
        choice = float(dice.choice([0.3, 0.4, 0.5]))
    elif term == "orientation-limit":
        choice = float(dice.choice([0.1, 0.2, 0.3]))  # s to the speed of reorientation
    elif term == "warm-up":
        total = float(np.sum(world.moves.length / np.maximum(world.moves.speed, 0.1)) + n)
        choice = total * float(dice.choice([0.1, 0.2, 0.35]))
    elif term == "external-wait":
        draw = waits(dice, world, 0.08)
    elif term == "clock":
        choice = float(dice.choice([1.0, -1.0]))
    return Hidden(term, 0.0, body, draw, choice)


def waits(dice: np.random.Generator, world: World, share: float) -> np.ndarray:
    """(n,) time lost, in units of its mean: at a few program lines, in every cycle another time."""
    lines = np.unique(world.moves.line)
    few = dice.choice(lines, max(2, round(share * len(lines))), replace=False)
    return np.isin(world.moves.line, few) * dice.uniform(0.6, 1.6, len(world.moves))


def parameter(term: str, hidden: Hidden, world: World, retuned: bool = False) -> dict[str, dict[str, object]]:
    """The true value where there is one, by name with its unit; nothing where the body has no such number."""
    h, a = hidden.strength, world.acceleration
    if hidden.body or (retuned and term in ("gravity", "jerk")):
        return {}
    if term == "acceleration":
        return {"acceleration": {"value": a / (1 + h) if hidden.choice > 0 else a * (1 + h), "unit": "m/s^2"}}
    if term == "speed-scale":
        return {"scale": {"value": 1 / (1 + h) if hidden.choice > 0 else 1 + h, "unit": "1"}}
    if term == "speed-clamp":
        top = float(world.moves.speed[world.moves.kind == 0].max())
        return {"speed": {"value": top / (1 + h), "unit": "m/s"}}
    if term in ("settling", "dispatch"):
        return {"time": {"value": h, "unit": "s"}}
    if term == "cycle-quantisation":
        return {"cycle": {"value": h, "unit": "s"}}
    if term == "orientation-limit":
        return {"angular_speed": {"value": 3.0 / h, "unit": "rad/s"}}
    if term == "payload":
        return {"growth": {"value": h, "unit": "1/kg"}}
    if term == "payload-inertia":
        return {"growth": {"value": h, "unit": "1/(kg m^2)"}}
    if term == "warm-up":
        return {"share": {"value": h, "unit": "1"}, "time_constant": {"value": hidden.choice, "unit": "s"}}
    if term == "gravity":
        return {"share": {"value": h * G / a, "unit": "1"}}  # of the acceleration, straight up
    if term == "jerk":
        return {"jerk": {"value": a / h, "unit": "m/s^3"}}
    if term in ("joint-speed-limit", "joint-acceleration-limit"):
        return {"share": {"value": 1 / h, "unit": "1"}}  # of the robot file's limits
    if term == "clock":
        return {"rate": {"value": 1 + h * hidden.choice, "unit": "1"}}
    return {}
