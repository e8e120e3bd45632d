"""What is sealed: each effect changes the controller of the moves on which it acts.

`draw` gives the changed controller and the numbers that the answer may be asked for, SI, under the terms' names.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .arm import Floats, WristedArm
from .cells import ProgramMove, Rng
from .engine import Controller, turn_of

Numbers = dict[str, float]
Drawn = tuple[Controller, Numbers]


@dataclass(frozen=True)
class Site:
    """What an effect may look at when its size is drawn."""

    moves: Sequence[ProgramMove]
    arm: WristedArm
    base: Controller

    def has(self, kind: str) -> bool:
        """Whether the program has moves of a kind."""
        return any(m.kind == kind for m in self.moves)

    @property
    def joints_only(self) -> bool:
        """Whether all motion is joint motion."""
        return not self.has("linear")


def _acceleration(rng: Rng, c: Controller, _: Site) -> Drawn:
    f = float(rng.choice([rng.uniform(0.55, 0.9), rng.uniform(1.12, 1.4)]))
    return replace(
        c, acceleration=c.acceleration * f, axis_accelerations=tuple(f * a for a in c.axis_accelerations)
    ), {"scale": f}


def _jerk(rng: Rng, c: Controller, _: Site) -> Drawn:
    return replace(c, ramp_time=c.ramp_time + float(rng.uniform(0.03, 0.14))), {}


def _gravity(rng: Rng, c: Controller, site: Site) -> Drawn:
    k = float(rng.uniform(0.15, 0.5))
    law = str(rng.choice(["both ramps", "both ramps", "against and with", "steep"]))
    shares = (
        (float(rng.uniform(0.3, 0.6)), float(rng.uniform(0.2, 0.5))) if not site.has("linear") else (0.0, 0.0)
    )
    return replace(c, gravity=k, gravity_law=law, arm_gravity=shares), (
        {} if site.joints_only else {"share": k}
    )


def _reach(rng: Rng, c: Controller, site: Site) -> Drawn:
    far = site.arm.reach
    zero = float(rng.choice([0.0, 0.45 * far]))
    k = float(rng.uniform(0.6, 2.5)) / far**2
    return replace(c, reach_growth=k, reach_zero=zero), {}


def _payload(rng: Rng, c: Controller, _: Site) -> Drawn:
    if rng.random() < 0.7:
        k = float(rng.uniform(0.02, 0.08))
        return replace(c, payload_growth=k), {"growth": k}
    k = float(rng.uniform(0.015, 0.035))
    return replace(c, payload_loss=k), {"loss": k}


def _payload_inertia(rng: Rng, c: Controller, _: Site) -> Drawn:
    k = float(rng.uniform(2, 8))
    return replace(c, inertia_growth=k), {"growth": k}


def _axis_acceleration(rng: Rng, c: Controller, site: Site) -> Drawn:
    axis = int(rng.choice([0, 3, 4, 5]))
    rates = [np.max(m.slopes[:, axis]) for m in site.moves if m.kind == "linear"]
    limit = c.acceleration * float(np.quantile(rates, rng.uniform(0.5, 0.85)))
    limits = tuple(limit if k == axis else np.inf for k in range(6))
    return replace(c, limits_on_lines=limits), {f"limit_{'slurbt'[axis]}": limit}


def _axis_speed(rng: Rng, c: Controller, site: Site) -> Drawn:
    axis = int(rng.choice([0, 3, 5]))
    rates = [np.max(m.slopes[:, axis]) * m.speed for m in site.moves if m.kind == "linear"]
    limit = float(np.quantile(rates, rng.uniform(0.5, 0.85)))
    return replace(c, speeds_on_lines=tuple(limit if k == axis else np.inf for k in range(6))), {
        f"limit_{'slurbt'[axis]}": limit
    }


def _torque_speed(rng: Rng, c: Controller, site: Site) -> Drawn:
    knee = float(rng.choice([0.0, 0.0, 0.5]))
    top = max(m.speed for m in site.moves if m.kind != "wait")
    idle = float(rng.uniform(1.2, 2.2)) * (1.0 if site.joints_only else top / 1000)
    return replace(c, fade_speed=idle, fade_knee=knee), {}


def _clamp(rng: Rng, c: Controller, site: Site) -> Drawn:
    speeds = [m.speed for m in site.moves if m.kind == "linear"]
    clamp = float(np.round(max(speeds) * rng.uniform(0.45, 0.85), 0))
    return replace(c, clamp=clamp), {"clamp": clamp / 1000}


def _turning(rng: Rng, c: Controller, site: Site) -> Drawn:
    rates = [turn_of(m) / m.length * m.speed for m in site.moves if m.kind == "linear"]
    rates = [r for r in rates if r > 1e-3]
    if len(rates) < 4:
        return c, {}
    rate = float(np.quantile(rates, rng.uniform(0.3, 0.8)))
    return replace(c, turn_rate=rate), {"rate": rate}


def _speed_scale(rng: Rng, c: Controller, _: Site) -> Drawn:
    k = float(rng.choice([rng.uniform(0.8, 0.96), rng.uniform(1.04, 1.12)]))
    return (replace(c, cruise=k) if rng.random() < 0.65 else replace(c, stretch=k)), {"scale": k}


def _settling(rng: Rng, c: Controller, _: Site) -> Drawn:
    t = float(rng.uniform(0.03, 0.2))
    return replace(c, settle=c.settle + t), {"time": t}


def _dispatch(rng: Rng, c: Controller, _: Site) -> Drawn:
    t = float(rng.uniform(0.012, 0.08))
    return replace(c, dispatch=t), {"time": t}


def _blending(rng: Rng, c: Controller, _: Site) -> Drawn:
    return replace(c, zone=float(rng.choice([0.0, 0.25, 0.5, 2.0]))), {}


def _cycle(rng: Rng, c: Controller, _: Site) -> Drawn:
    cycle = float(rng.choice([0.012, 0.016, 0.024, 0.032, 0.048]))
    return replace(c, cycle=cycle, cycle_up=bool(rng.random() < 0.7)), {"cycle": cycle}


def _warm(rng: Rng, c: Controller, site: Site) -> Drawn:
    tau = float(rng.uniform(0.15, 0.45)) * 2.0 * len(site.moves)
    size, kind = float(rng.uniform(0.05, 0.15)), rng.random()
    if kind < 0.5:
        return replace(c, warm_share=size, warm_tau=tau), {"share": size, "tau": tau}
    if kind < 0.7:
        return replace(c, warm_seconds=size, warm_tau=tau), {"time": size, "tau": tau}
    return replace(c, warm_friction=3 * size, warm_tau=tau), {}


def _viscous(rng: Rng, c: Controller, site: Site) -> Drawn:
    top = max(m.speed for m in site.moves if m.kind == "linear")
    k = float(rng.uniform(0.3, 0.8)) * c.acceleration / top
    return replace(c, viscous=k), {"loss": k}


def _coulomb(rng: Rng, c: Controller, _: Site) -> Drawn:
    k = float(rng.uniform(0.2, 0.45))
    return replace(c, coulomb=k), {"share": k}


def _clock(rng: Rng, c: Controller, _: Site) -> Drawn:
    rate = 1 + float(rng.choice([-1, 1])) * float(rng.uniform(0.01, 0.05))
    return replace(c, clock=rate), {"rate": rate}


EFFECTS: dict[str, Callable[[Rng, Controller, Site], Drawn]] = {
    "acceleration": _acceleration,
    "jerk": _jerk,
    "gravity": _gravity,
    "reach-inertia": _reach,
    "payload": _payload,
    "payload-inertia": _payload_inertia,
    "joint-acceleration-limit": _axis_acceleration,
    "joint-speed-limit": _axis_speed,
    "torque-speed": _torque_speed,
    "speed-clamp": _clamp,
    "orientation-limit": _turning,
    "speed-scale": _speed_scale,
    "settling": _settling,
    "dispatch": _dispatch,
    "blending": _blending,
    "cycle-quantisation": _cycle,
    "warm-up": _warm,
    "viscous-friction": _viscous,
    "coulomb-friction": _coulomb,
    "clock": _clock,
}
ON_LINES = (
    "joint-acceleration-limit",
    "joint-speed-limit",
    "speed-clamp",
    "orientation-limit",
    "viscous-friction",
    "coulomb-friction",
)

# Limits that change along a path: ramps of constant jerk have no closed form under them.
ALONG_THE_PATH = (
    "reach-inertia",
    "gravity",
    "joint-acceleration-limit",
    "joint-speed-limit",
    "torque-speed",
    "viscous-friction",
)


def possible(name: str, site: Site) -> bool:
    """Whether an effect can be seen, and told, in a program."""
    waits, rounded = site.has("wait"), sum(m.blend > 0 for m in site.moves)
    mixed = site.has("joint") and site.has("linear")
    if name in ON_LINES:
        return site.has("linear") and not site.has("joint")
    if name in ("gravity", "reach-inertia", "torque-speed", "payload-inertia"):
        return not mixed
    return {"blending": rounded >= 8, "clock": waits, "external-wait": True, "settling": True}.get(name, True)


def outside(rng: Rng, site: Site, seconds: Floats) -> tuple[str, Floats]:
    """A law of no list: its name and the seconds it adds to each move."""
    n, now = len(seconds), np.cumsum(seconds)
    moving = np.array([m.kind != "wait" for m in site.moves], dtype=float)
    size = float(rng.uniform(0.02, 0.08))
    name = str(rng.choice(["network", "wave", "walk", "parity", "turning-back", "supply"]))
    if name == "network":  # a fieldbus that is polled: late by how the run's time meets the poll
        return name, moving * size * 2 * ((now / 0.37) % 1)
    if name == "wave":  # an air conditioner
        return name, moving * seconds * size * 1.5 * np.sin(
            2 * np.pi * now / (now[-1] / 5.3) + rng.uniform(0, 6)
        )
    if name == "walk":
        return name, moving * seconds * np.cumsum(rng.normal(size=n)) * size / n**0.5 * 2
    if name == "parity":  # two interpreter tasks in turn
        return name, moving * size * (np.arange(n) % 2)
    if name == "supply":  # mains voltage: three shifts between two levels
        return name, moving * seconds * size * 1.5 * np.sign(np.sin(2 * np.pi * np.arange(n) / (n / 3.4)))
    way = np.array([m.end[:3] - m.start[:3] for m in site.moves])
    cosine = np.sum(way[1:] * way[:-1], axis=1) / (
        np.linalg.norm(way[1:], axis=1) * np.linalg.norm(way[:-1], axis=1) + 1e-9
    )
    return name, moving * size * 1.5 * np.concatenate([[0.0], np.clip(-cosine, 0, 1)])
