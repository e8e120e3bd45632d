"""Cases with a log: a servo loop at 2 ms around rigid bodies in MuJoCo, logged every 4 ms: robot and simulation."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.concealed.arms import Arm, Joints, mjcf, random_arm, robot_file
from bench.concealed.programs import GRID, Moves, Plan, random_moves

Floats = NDArray[np.float64]
TICK, EVERY = 0.002, 2  # s of the servo, ticks per sample
EFFECTS = ("viscous-friction", "coulomb-friction", "servo-lag", "joint-compliance", "backlash", "clock")
LONG = 600.0  # s of the one long log


@dataclass(slots=True)
class Setpoints:
    """`q` (k, 6) [rad] at every tick; `move` (k,) or -1; `start`, `duration` (n,) [s]."""

    q: Floats
    move: NDArray[np.int64]
    start: Floats
    duration: Floats


@dataclass(slots=True)
class LogCase:
    """Columns of both logs by name; `t` of the robot's is on the recorder's clock."""

    name: str
    moves: Moves
    acceleration: float
    measured: Floats
    simulated: Floats
    start: Floats
    real_log: dict[str, Floats]
    sim_log: dict[str, Floats]
    resolution: float
    answer: dict[str, Any]


def make_log(seed: int, index: int, family: str, turn: int) -> LogCase:
    """One case; the same numbers make the same case."""
    dice = np.random.default_rng([seed, index, 77])
    arm = random_arm(dice)
    count = int(dice.integers(30, 60))
    long = family == "log-one" and turn == 3
    plan = Plan(
        400 if long else count, (0.05, 0.8), (0.15, 0.3, 0.6, 1.0), float(dice.choice([1.0, 2.0, 3.0]))
    )
    moves = random_moves(dice, arm, plan)
    points = _setpoints(dice, moves, plan.acceleration, LONG if long else 0.0)
    term = (
        {"log-none": "", "log-clock": "clock"}.get(family) or EFFECTS[turn % 5]
        if family != "log-none"
        else ""
    )
    simulated, torque = _servo(arm, points.q, None)
    peak = np.abs(torque).max(axis=0)
    noise_q, noise_tau = np.radians(dice.uniform(0.0005, 0.003)), dice.uniform(0.002, 0.01) * peak
    size = float(np.exp(dice.uniform(np.log(2.0), np.log(10.0))))
    real, real_torque, truth = _real(dice, arm, points, term, size, (simulated, torque, noise_q, noise_tau))
    fast = 1.0
    if term == "clock":
        fast = 1 + float(dice.choice([-1, 1])) * float(np.exp(dice.uniform(np.log(0.002), np.log(0.02))))
        truth = {"rate": {"value": fast, "unit": "1"}}
    resolution = 0.004
    duration = points.duration * fast
    measured = np.round((duration + dice.normal(0, 2e-4, len(duration))) / resolution) * resolution
    offset = float(dice.uniform(-2, 2)) if term == "clock" else 0.0
    rows = np.arange(0, len(points.q), EVERY)
    t = rows * TICK
    sim_log = _log(t, points.q[rows], simulated[rows], torque[rows], points.move[rows])
    noisy = real[rows] + dice.normal(0, noise_q, (len(rows), 6))
    noisy_torque = real_torque[rows] + dice.normal(0, 1, (len(rows), 6)) * noise_tau
    real_log = _log(t * fast + offset + 10.0, points.q[rows], noisy, noisy_torque, points.move[rows])
    if family == "log-clock" or dice.random() < 0.2:
        real_log = _dropped(dice, real_log)
    floor = float(np.hypot(2e-4, resolution / np.sqrt(12)))
    answer = _answer(family, term, size, floor, truth, len(moves), long)
    start = points.start * fast + offset + 10.0
    return LogCase(
        f"{index:04d}-{family}", moves, plan.acceleration, measured, points.duration, start, real_log, sim_log,
        resolution, answer,
    )  # fmt: skip


def _answer(
    family: str, term: str, size: float, floor: float, truth: dict[str, Any], n: int, long: bool
) -> dict[str, Any]:
    terms = [term] if term else []
    # A recorder's fault may be named or not; it must not be called anything else.
    required = [] if family == "log-clock" else terms
    return {
        "family": family, "count": n, "hidden": terms, "required": required,
        "allowed": [t for t in terms if t not in required],
        "same": {t: [] for t in terms}, "near": {t: [] for t in terms}, "unseen": [],
        "size": dict.fromkeys(terms, size), "rms_s": {}, "noise_floor_s": floor, "poor": False,
        "confounded_with": "", "body": dict.fromkeys(terms, True), "strength": {}, "choice": {},
        "parameters": dict.fromkeys(terms, truth), "moves": {t: {"acts": list(range(n)), "little": []} for t in terms},
        "simulation": {"log_s": LONG if long else None},
    }  # fmt: skip


def _setpoints(dice: np.random.Generator, moves: Moves, most: float, at_least: float) -> Setpoints:
    """Constant acceleration along each move in steps of a tick, a rest after each."""
    from scipy.interpolate import CubicSpline

    chunks, labels, starts, durations, now = [], [], [], [], 0
    share = np.linspace(0, 1, GRID)
    for i in range(len(moves)):
        length, top = float(moves.length[i]), float(min(moves.speed[i], np.sqrt(moves.length[i] * most)))
        ramp = top / most
        total = length / top + ramp
        t = np.arange(1, int(np.ceil(total / TICK)) + 1) * TICK
        t = np.minimum(t, total)
        up = np.minimum(t, ramp)
        down = np.maximum(t - (total - ramp), 0.0)
        s = 0.5 * most * up**2 + top * np.maximum(t - ramp, 0) - 0.5 * most * down**2
        spline = CubicSpline(share, moves.path[i], axis=0)
        chunks.append(spline(np.clip(s / length, 0, 1)))
        rest = int(dice.uniform(0.15, 0.4) / TICK)
        if at_least and len(moves) > 1:
            rest += int(max(0.0, at_least / len(moves) - total - 0.3) / TICK)
        chunks.append(np.repeat(chunks[-1][-1:], rest, axis=0))
        labels += [i] * len(t) + [-1] * rest
        starts.append(now * TICK)
        durations.append(total)
        now += len(t) + rest
    return Setpoints(np.concatenate(chunks), np.array(labels), np.array(starts), np.array(durations))


def _servo(arm: Arm, q: Floats, joints: Joints | None) -> tuple[Floats, Floats]:
    """Motor angles (k, 6) [rad], or links' where joints are soft, and motor torques (k, 6) [N m]."""
    import mujoco

    plain: Any = mujoco.MjModel.from_xml_string(mjcf(arm, TICK))
    ahead: Any = mujoco.MjData(plain)
    model: Any = plain if joints is None else mujoco.MjModel.from_xml_string(mjcf(arm, TICK, joints=joints))
    data: Any = mujoco.MjData(model)
    motors = np.array([model.jnt_qposadr[model.actuator_trnid[i, 0]] for i in range(6)])
    springs = [
        [a for a in range(model.nq) if a not in motors and motors[i] < a < [*motors[1:], model.nq][i]]
        for i in range(6)
    ]
    speed = np.gradient(q, TICK, axis=0)
    rate = np.gradient(speed, TICK, axis=0)
    inertia = _inertia(mujoco, plain, q)
    stiff, damp = inertia * (2 * np.pi * 12) ** 2, inertia * 2 * 0.8 * (2 * np.pi * 12)
    data.qpos[motors] = q[0]
    if joints is not None:
        _sag(mujoco, model, data, motors, springs, plain, ahead, q[0], joints)
    out, torque = np.empty_like(q), np.empty_like(q)
    integral = np.zeros(6)
    for k in range(len(q)):
        ahead.qpos[:], ahead.qvel[:], ahead.qacc[:] = q[k], speed[k], rate[k]
        mujoco.mj_inverse(plain, ahead)
        gap = q[k] - data.qpos[motors]
        integral += gap * TICK
        data.ctrl[:] = (
            ahead.qfrc_inverse + stiff * (gap + 4.0 * integral) + damp * (speed[k] - data.qvel[motors])
        )
        torque[k] = data.ctrl
        mujoco.mj_step(model, data)
        out[k] = data.qpos[motors]
        for i, more in enumerate(springs):
            for a in more:
                out[k, i] += data.qpos[a]
    return out, torque


def _sag(
    mujoco: Any, model: Any, data: Any, motors: NDArray[np.int64], springs: list[list[int]], plain: Any, ahead: Any,
    q: Floats, joints: Joints,
) -> None:  # fmt: skip
    """Springs start where gravity has drawn them."""
    ahead.qpos[:], ahead.qvel[:], ahead.qacc[:] = q, 0, 0
    mujoco.mj_inverse(plain, ahead)
    for i, more in enumerate(springs):
        for a in more:
            data.qpos[a] = -ahead.qfrc_inverse[i] / joints.stiffness[i]
    mujoco.mj_forward(model, data)


def _inertia(mujoco: Any, model: Any, q: Floats) -> Floats:
    """(6,) about each axis at the mean pose, which is what the servo is tuned to."""
    data: Any = mujoco.MjData(model)
    data.qpos[:] = q.mean(axis=0)
    mujoco.mj_forward(model, data)
    zero = np.zeros(6)
    columns = []
    for i in range(6):
        data.qvel[:], data.qacc[:] = zero, np.eye(6)[i]
        mujoco.mj_inverse(model, data)
        columns.append(data.qfrc_inverse.copy() - data.qfrc_bias)
    return np.diag(np.array(columns)).copy()


def _real(
    dice: np.random.Generator, arm: Arm, points: Setpoints, term: str, size: float,
    plain: tuple[Floats, Floats, float, Floats],
) -> tuple[Floats, Floats, dict[str, Any]]:  # fmt: skip
    """The robot's axes, torques, and the true parameters; `size` is of the noise in what the effect shows."""
    simulated, torque, noise_q, noise_tau = plain
    speed = np.abs(np.gradient(points.q, TICK, axis=0))
    moving = np.sqrt(np.mean(speed**2, axis=0)) + 1e-6
    none = Joints(np.zeros(6), np.zeros(6), np.full(6, np.inf))
    if term == "viscous-friction":
        viscous = size * noise_tau / moving * dice.uniform(0.7, 1.4, 6)
        q, tau = _servo(arm, points.q, Joints(viscous, none.coulomb, none.stiffness))
        return (
            q,
            tau,
            {f"viscous_{i + 1}": {"value": float(v), "unit": "N m s/rad"} for i, v in enumerate(viscous)},
        )
    if term == "coulomb-friction":
        coulomb = size * noise_tau * dice.uniform(0.7, 1.4, 6)
        q, tau = _servo(arm, points.q, Joints(none.viscous, coulomb, none.stiffness))
        return q, tau, {f"coulomb_{i + 1}": {"value": float(v), "unit": "N m"} for i, v in enumerate(coulomb)}
    if term == "servo-lag":
        lag = max(size * noise_q / float(np.median(moving)), 0.004) * 3
        lag = min(lag, 0.08)
        late = points.q.copy()
        for k in range(1, len(late)):
            late[k] = late[k - 1] + (points.q[k] - late[k - 1]) * (1 - np.exp(-TICK / lag))
        q, tau = _servo(arm, late, None)
        return q, tau, {"time_constant": {"value": lag, "unit": "s"}}
    if term == "joint-compliance":
        stiffness = np.full(6, np.inf)
        soft = dice.choice(3, int(dice.integers(1, 3)), replace=False)
        heavy = np.array([60.0, 120.0, 25.0]) * arm.reach**2
        stiffness[soft] = heavy[soft] * (2 * np.pi * dice.uniform(5, 11, len(soft))) ** 2
        q, tau = _servo(arm, points.q, Joints(none.viscous, none.coulomb, stiffness))
        return (
            q,
            tau,
            {f"stiffness_{i + 1}": {"value": float(stiffness[i]), "unit": "N m/rad"} for i in sorted(soft)},
        )
    if term == "backlash":
        width = np.where(
            np.arange(6) < dice.integers(2, 6), size * 2 * noise_q * dice.uniform(0.8, 1.3, 6), 0.0
        )
        return (
            _play(simulated, width), torque,
            {f"width_{i + 1}": {"value": float(w), "unit": "rad"} for i, w in enumerate(width) if w > 0},
        )  # fmt: skip
    return simulated, torque, {}


def _play(q: Floats, width: Floats) -> Floats:
    """Links that follow their motors only at the ends of a gap."""
    out = np.empty_like(q)
    here = q[0] - width / 2
    for k in range(len(q)):
        here = np.clip(here, q[k] - width / 2, q[k] + width / 2)
        out[k] = here
    return out


def _log(t: Floats, command: Floats, q: Floats, torque: Floats, move: NDArray[np.int64]) -> dict[str, Floats]:
    speed = np.gradient(q, EVERY * TICK, axis=0)
    log = {"t_s": t}
    for name, values, factor in (("q{}_deg", q, 1), ("q{}_cmd_deg", command, 1), ("qd{}_deg_s", speed, 1)):
        log |= {name.format(i + 1): np.degrees(values[:, i]) * factor for i in range(6)}
    log |= {f"tau{i + 1}_nm": torque[:, i] for i in range(6)}
    log["move"] = move.astype(float)
    return log


def _dropped(dice: np.random.Generator, log: dict[str, Floats]) -> dict[str, Floats]:
    """Samples the recorder lost: single ones, and a few stretches of up to 0.1 s."""
    n = len(log["t_s"])
    keep = dice.random(n) > 0.01
    for first in dice.integers(0, n, max(2, n // 4000)):
        keep[first : first + int(dice.integers(3, 25))] = False
    keep[0] = keep[-1] = True
    return {name: values[keep] for name, values in log.items()}


def write_log(case: LogCase, folder: Path) -> Path:
    """As files.write does for cases without logs."""
    import pandas as pd

    from bench.concealed.files import _axes, _cells, _points, _table, _turns

    place, sealed = folder / "cases" / case.name, folder / "sealed"
    place.mkdir(parents=True, exist_ok=True)
    sealed.mkdir(parents=True, exist_ok=True)
    moves, n = case.moves, len(case.moves)
    columns = {"move": [str(i) for i in range(n)], "duration_s": _cells(case.measured, 4)}
    columns |= {"sim_s": _cells(case.simulated, 5), "type": ["linear"] * n}
    columns |= _points(moves) | _turns(moves) | _axes(moves)
    columns["speed_mm_s"] = _cells(1000 * moves.speed, 3)
    columns["accel_mm_s2"] = _cells(np.full(n, 1000 * case.acceleration), 3)
    columns["t_start_s"] = _cells(case.start, 4)
    _table(place / "moves.csv", columns)
    for name, log in (("log", case.real_log), ("sim_log", case.sim_log)):
        frame = pd.DataFrame(log)
        frame["move"] = frame["move"].astype(int)
        frame.to_csv(place / f"{name}.csv", index=False, float_format="%.5f")
    (place / "robot.toml").write_text(robot_file(moves.arm, "Arm", True))
    (place / "recording.toml").write_text(
        f'robot = "robot.toml"\ncontroller = "concealed"\ntime_resolution_s = {case.resolution:g}\n'
        f"tool = [0.0, 0.0, {1000 * moves.arm.tool:.6f}, 0.0, 0.0, 0.0]\n"
    )
    (sealed / f"{case.name}.json").write_text(json.dumps(case.answer, indent=1))
    return place
