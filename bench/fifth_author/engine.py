"""A controller: limits sampled along each move, a look-ahead over chains of moves, ramps that build up.

Speed over path is integrated forward and backward under the sampled limits, exactly within each cell; the
coordinate of a line is its length [mm], of a joint move the share of it. A `Controller` states all that acts on
a move; the judged simulation and the robot are the same engine with two of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .arm import Floats, WristedArm, forward, orientation
from .cells import NODES, ProgramMove


@dataclass(frozen=True)
class Controller:
    """Numbers of a controller and its drives; mm, rad, s, kg. Defaults do nothing."""

    acceleration: float
    axis_speeds: tuple[float, ...]
    axis_accelerations: tuple[float, ...]
    limits_on_lines: tuple[float, ...] = (np.inf,) * 6  # axis accelerations that also hold on lines [rad/s^2]
    speeds_on_lines: tuple[float, ...] = (np.inf,) * 6  # axis speeds that also hold on lines [rad/s]
    ramp_time: float = 0.0  # moving average over the set points [s]
    s_curve: bool = False  # jerk so that a ramp takes `ramp_time` longer, at the full acceleration
    settle: float = 0.0
    dispatch: float = 0.0
    zone: float = 1.0  # real over programmed corner
    lateral: float = 1.0  # lateral over path acceleration in corners
    overlap: bool = False  # corners overlap ramps instead of limiting the speed
    clamp: float = np.inf
    cruise: float = 1.0
    stretch: float = 1.0
    turn_rate: float = np.inf
    payload_growth: float = 0.0
    payload_loss: float = 0.0
    inertia_growth: float = 0.0
    reach_growth: float = 0.0  # [1/mm^2]
    reach_zero: float = 0.0
    gravity: float = 0.0
    gravity_law: str = "both ramps"
    arm_gravity: tuple[float, float] = (
        0.0,
        0.0,
    )  # share of L's and U's torque that holds the arm, stretched out
    fade_speed: float = np.inf  # speed, or share of rated axis speed, at which no torque is left
    fade_knee: float = 0.0
    viscous: float = 0.0  # [1/s]
    coulomb: float = 0.0
    warm_share: float = 0.0
    warm_seconds: float = 0.0
    warm_friction: float = 0.0  # share of acceleration that cold grease takes
    warm_tau: float = 600.0
    cycle: float = 0.0
    cycle_up: bool = True
    clock: float = 1.0


@dataclass(frozen=True)
class SampledMove:
    """What the planner sees of a move, per cell of its path."""

    step: Floats
    speed: Floats
    up: Floats  # acceleration when speeding up
    down: Floats
    fade: float
    knee: float
    viscous: float = 0.0


def _axis_laws(move: ProgramMove, c: Controller, q: Floats, arm: WristedArm) -> tuple[Floats, Floats]:
    """Axis accelerations (cells, 6) when speeding up and when braking, of a joint move."""
    base = np.tile(np.array(c.axis_accelerations), (len(q), 1))
    wrist = forward(arm, q)[1]
    base[:, 0] /= 1 + c.reach_growth * (np.sum(wrist[:, :2] ** 2, axis=1) - c.reach_zero**2)
    base[:, 3:] /= 1 + c.inertia_growth * move.inertia
    way = np.sign(move.q[-1] - move.q[0])
    r, elbow = np.hypot(wrist[:, 0], wrist[:, 1]), c.arm_gravity
    hold = np.zeros_like(base)
    hold[:, 1] = -elbow[0] * r / arm.reach  # leaning forward is helped
    hold[:, 2] = elbow[1] * np.cos(q[:, 2] - q[:, 1])
    return base * (1 - hold * way), base * (1 + hold * way)


def turn_of(move: ProgramMove) -> float:
    """Angle between the orientations at both ends [rad]."""
    one, two = orientation(np.stack([move.start[3:], move.end[3:]]))
    return float(np.arccos(np.clip((np.trace(one.T @ two) - 1) / 2, -1, 1)))


def sample(move: ProgramMove, c: Controller, arm: WristedArm, now: float) -> SampledMove:
    """Limits of one move at `now` [s] after the start."""
    q = (move.q[1:] + move.q[:-1]) / 2
    a = 1 / (1 + c.payload_growth * move.payload) * (1 - c.payload_loss * move.payload)
    a *= 1 - c.warm_friction * np.exp(-now / c.warm_tau)
    if move.kind == "joint":
        turn = np.maximum(np.abs(move.q[-1] - move.q[0]), 1e-9)
        up, down = _axis_laws(move, c, q, arm)
        rated = float(np.min(np.array(c.axis_speeds) / turn))
        speed = np.full(len(q), rated * move.speed * move.override * c.cruise)
        up, down = (a * np.min(ramps / turn, axis=1) for ramps in (up, down))
        return SampledMove(np.diff(NODES), speed, up, down, c.fade_speed * rated, c.fade_knee)
    up, down = _line_ramps(move, c, q)
    fade = c.fade_speed * 1000  # rated axis speed of joint moves, 1 m/s of lines
    step = np.diff(NODES) * move.length
    return SampledMove(step, _line_speeds(move, c), a * up, a * down, fade, c.fade_knee, c.viscous)


def _line_speeds(move: ProgramMove, c: Controller) -> Floats:
    """Speed limits (cells) of a line [mm/s]."""
    speed = np.full(len(move.slopes), min(move.speed * move.override * c.cruise, c.clamp))
    with np.errstate(divide="ignore", invalid="ignore"):
        speed = np.minimum(speed, np.min(np.array(c.speeds_on_lines) / move.slopes, axis=1))
    turned = turn_of(move)
    return np.minimum(speed, c.turn_rate * move.length / turned) if turned > 1e-6 else speed


def _line_ramps(move: ProgramMove, c: Controller, q: Floats) -> tuple[Floats, Floats]:
    """Accelerations (cells) of a line [mm/s^2] when speeding up and when braking."""
    ramp = np.full(len(q), c.acceleration / (1 + c.inertia_growth * move.inertia))
    if c.reach_growth:
        wrist = move.start[:3] + (NODES[1:, None] + NODES[:-1, None]) / 2 * (move.end[:3] - move.start[:3])
        ramp /= 1 + c.reach_growth * (np.sum(wrist[:, :2] ** 2, axis=1) - c.reach_zero**2)
    with np.errstate(divide="ignore", invalid="ignore"):
        ramp = np.minimum(ramp, np.min(np.array(c.limits_on_lines) / move.slopes, axis=1))
    sine = float(move.end[2] - move.start[2]) / move.length
    lost = c.gravity * (abs(sine) if c.gravity_law == "steep" else sine)
    gained = lost if c.gravity_law == "against and with" else -lost
    return ramp * (1 - lost - c.coulomb), ramp * (1 + gained + c.coulomb)


def _at_speed(a: float, v: float, m: SampledMove, braking: bool) -> float:
    """Acceleration that is left at a speed: torque fades, viscous friction brakes."""
    share = (1 - v / m.fade) / (1 - m.knee) if np.isfinite(m.fade) else 1.0
    lost = -m.viscous * v if braking else m.viscous * v
    return max(a * min(1.0, share) - lost, 0.02 * a)


def _pass(moves: Sequence[SampledMove], corners: Sequence[float], forward_pass: bool) -> list[float]:
    """Largest reachable speeds at all nodes, from rest, in one direction."""
    order = list(moves) if forward_pass else [*reversed(moves)]
    caps = list(corners) if forward_pass else [*reversed(corners)]
    v, nodes = 0.0, [0.0]
    for k, m in enumerate(order):
        cells = range(len(m.speed)) if forward_pass else range(len(m.speed) - 1, -1, -1)
        for i in cells:
            a, step = float((m.up if forward_pass else m.down)[i]), float(m.step[i])
            half = min((v * v + _at_speed(a, v, m, not forward_pass) * step) ** 0.5, float(m.speed[i]))
            v = min((v * v + 2 * _at_speed(a, half, m, not forward_pass) * step) ** 0.5, float(m.speed[i]))
            nodes.append(v)
        v = min(v, caps[k]) if k < len(caps) else 0.0
        if k + 1 < len(order):
            v = min(v, float(order[k + 1].speed[0 if forward_pass else -1]))
        nodes[-1] = v
    return nodes


def _cell_seconds(v0: float, v1: float, m: SampledMove, i: int) -> float:
    """Time over a cell: up to a peak, along the limit, down; exact for constant limits."""
    step, top = float(m.step[i]), max(float(m.speed[i]), v0, v1)
    mean = max((v0 + v1) / 2, 0.0)
    a = max(_at_speed(float(m.up[i]), mean, m, False), (v1 * v1 - v0 * v0) / (2 * step))
    d = max(_at_speed(float(m.down[i]), mean, m, True), (v0 * v0 - v1 * v1) / (2 * step))
    peak = min(((2 * a * d * step + d * v0 * v0 + a * v1 * v1) / (a + d)) ** 0.5, top)
    peak = max(peak, v0, v1)
    rest = step - (peak**2 - v0**2) / (2 * a) - (peak**2 - v1**2) / (2 * d)
    return (peak - v0) / a + (peak - v1) / d + max(rest, 0.0) / peak


def chain_seconds(moves: Sequence[SampledMove], corners: Sequence[float]) -> list[float]:
    """Durations of moves that follow each other without a stop; corners are speeds in the first move's unit."""
    ahead = _pass(moves, corners, True)
    back = _pass(moves, corners, False)[::-1]
    v = [min(x, y) for x, y in zip(ahead, back, strict=True)]
    seconds, k = [], 0
    for m in moves:
        total = 0.0
        for i in range(len(m.speed)):
            total += _cell_seconds(v[k], v[k + 1], m, i)
            k += 1
        seconds.append(total)
    return seconds


def s_curve_seconds(length: float, v: float, up: float, down: float, ramp_time: float) -> float:
    """Rest to rest with jerk up/ramp_time and down/ramp_time; the peak speed by bisection."""

    def ramp(top: float, a: float) -> float:
        j = a / ramp_time
        return top / a + ramp_time if top >= a * ramp_time else 2 * (top / j) ** 0.5

    def travel(top: float) -> float:
        return top * (ramp(top, up) + ramp(top, down)) / 2

    top = v
    if travel(v) > length:
        low, high = 0.0, v
        for _ in range(60):
            top = (low + high) / 2
            low, high = (low, top) if travel(top) > length else (top, high)
    return ramp(top, up) + ramp(top, down) + max(length - travel(top), 0.0) / top


def corner_speed(before: ProgramMove, after: ProgramMove, c: Controller) -> float:
    """Speed through a rounded corner: lateral acceleration on the circle that touches both lines [mm/s]."""
    a, b = before.end[:3] - before.start[:3], after.end[:3] - after.start[:3]
    cosine = float(a @ b) / (before.length * after.length)
    deflection = np.arccos(np.clip(cosine, -1, 1))
    tangent = min(before.blend * c.zone, before.length / 2, after.length / 2)
    if deflection < 1e-3:
        return np.inf
    radius = tangent / np.tan(deflection / 2) if deflection < 3.1 else 0.0
    return float(np.sqrt(c.lateral * c.acceleration * radius))


def _braking(m: SampledMove, distance: float) -> float:
    """Time from `distance` before the end to the end, braking to rest."""
    d, top = float(m.down[-1]), float(m.speed[-1])
    ramp = top * top / (2 * d)
    return (2 * distance / d) ** 0.5 if distance < ramp else top / d + (distance - ramp) / top


def run(moves: Sequence[ProgramMove], controllers: Sequence[Controller], arm: WristedArm) -> Floats:
    """Durations [s] of all moves, each under its own controller."""
    seconds = np.zeros(len(moves))
    k, now = 0, 0.0
    while k < len(moves):
        if moves[k].kind == "wait":
            seconds[k] = moves[k].wait
            now, k = now + seconds[k], k + 1
            continue
        last = k
        while last + 1 < len(moves) and _joined(moves[last], moves[last + 1]):
            last += 1
        group = range(k, last + 1)
        times = _group(moves, controllers, arm, group, now)
        for i, t in zip(group, times, strict=True):
            seconds[i] = t
        now, k = now + sum(times), last + 1
    return _whole_moves(seconds, moves, controllers)


def _joined(a: ProgramMove, b: ProgramMove) -> bool:
    return a.blend > 0 and a.kind == b.kind and b.kind != "wait"


def _group(
    moves: Sequence[ProgramMove], cs: Sequence[Controller], arm: WristedArm, group: range, now: float
) -> list[float]:
    sampled = [sample(moves[i], cs[i], arm, now) for i in group]
    first = cs[group[0]]
    apart = first.overlap or moves[group[0]].kind == "joint"
    if len(sampled) > 1 and not apart:
        corners = [corner_speed(moves[i], moves[i + 1], cs[i]) for i in group[:-1]]
        times = chain_seconds(sampled, corners)
        times[0] += first.ramp_time / 2
        times[-1] += cs[group[-1]].ramp_time / 2
    else:
        times = [_alone(m, cs[i]) for m, i in zip(sampled, group, strict=True)]
        for n in range(len(times) - 1):
            here, after = moves[group[n]], moves[group[n + 1]]
            share = 1.0 if here.kind == "linear" else 1 / max(here.length, 1e-6)
            cut = min(here.blend * cs[group[n]].zone, here.length / 2, after.length / 2)
            times[n] -= 0.5 * _braking(sampled[n], cut * share)
            times[n + 1] -= 0.5 * _braking(sampled[n], cut * share)
    times[-1] += cs[group[-1]].settle
    return times


def _alone(m: SampledMove, c: Controller) -> float:
    if (
        c.s_curve
        and c.ramp_time
        and np.ptp(m.up) < 1e-9 * m.up[0]
        and np.ptp(m.speed) < 1e-9 * m.speed[0]
        and not np.isfinite(m.fade)
    ):
        return s_curve_seconds(
            float(m.step.sum()), float(m.speed[0]), float(m.up[0]), float(m.down[0]), c.ramp_time
        )
    return chain_seconds([m], [])[0] + c.ramp_time


def _whole_moves(seconds: Floats, moves: Sequence[ProgramMove], cs: Sequence[Controller]) -> Floats:
    """What acts on whole durations: dispatch, warm-up, stretch, the cycle, the recorder's clock."""
    result, now = seconds.copy(), 0.0
    for i, (m, c) in enumerate(zip(moves, cs, strict=True)):
        t = result[i]
        cold = np.exp(-now / c.warm_tau)
        if m.kind != "wait":
            t = t / c.stretch * (1 + c.warm_share * cold) + c.warm_seconds * cold + c.dispatch
            if c.cycle:
                t = c.cycle * (np.ceil(t / c.cycle - 1e-9) if c.cycle_up else np.round(t / c.cycle))
        now += t
        result[i] = t * c.clock
    return result
