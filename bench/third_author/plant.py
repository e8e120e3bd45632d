"""The simulation and the real arm of this author: each move's speed is integrated along its path.

A path is s from 0 to its length (of joint moves from 0 to 1). The real arm's ramps may be limited elsewhere at
every point of the path and at every speed; effects change a `Drive`, which `seconds` integrates in the plane of
s and its speed. Nothing here is a closed form of `olp`.
"""

from dataclasses import dataclass, fields, replace

import numpy as np

from bench.third_author.cells import GRID, SAMPLES, Moves


@dataclass(frozen=True)
class Drive:
    """What an arm can do in each move; rows are moves, columns (where there are any) the points of the path."""

    length: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray
    up: np.ndarray  # (n, SAMPLES) multiplies the acceleration of the first ramp
    down: np.ndarray  # and of the last ramp
    cap: np.ndarray  # (n, SAMPLES) the most speed
    relative: np.ndarray  # x = speed * relative: share of the quickest that any move may be
    drag: np.ndarray  # lost by the first ramp and won by the last per speed [1/s]
    knee: np.ndarray  # x at which the acceleration begins to fall (inf: never)
    idle: np.ndarray  # x at which nothing is left
    brake: np.ndarray  # whether the last ramp falls too
    build_up: np.ndarray  # time in which the rated acceleration builds up [s]
    rated: np.ndarray  # acceleration that builds up in that time

    def only(self, where: np.ndarray, other: "Drive") -> "Drive":
        """This drive in some moves, the other one elsewhere."""
        mixed = {}
        for name in (f.name for f in fields(self)):
            mine, theirs = getattr(self, name), getattr(other, name)
            mixed[name] = np.where(where[:, None] if mine.ndim == 2 else where, mine, theirs)
        return Drive(**mixed)

    def with_share(self, up: np.ndarray, down: np.ndarray | None = None) -> "Drive":
        return replace(self, up=self.up * up, down=self.down * (up if down is None else down))


def axis_limit(span: np.ndarray, limits: np.ndarray) -> np.ndarray:
    """The most of s' or s'' that the axes' limits allow; span is |dq| of each axis."""
    return np.min(limits / np.maximum(span, 1e-9), axis=-1)


def drive_of(moves: Moves) -> Drive:
    """The arm as the simulation has it."""
    arm, n = moves.arm, len(moves)
    kind = moves.column("kind")
    joint, lines = kind == "joint", (kind != "joint") & (kind != "wait")
    span = np.abs(moves.q[:, -1] - moves.q[:, 0])
    speed = np.where(joint, axis_limit(span, arm.speeds), 1.0) * moves.column("speed")
    rated = np.where(joint, axis_limit(span, arm.accelerations), 1.0)
    acceleration = rated * moves.column("acceleration")
    rated = np.where(joint, rated, acceleration.max(initial=0, where=lines))
    relative = np.where(
        joint, np.max(span / arm.speeds, axis=-1), 1 / max(speed.max(initial=0, where=lines), 1e-9)
    )
    ones, zeros = np.ones((n, SAMPLES)), np.zeros(n)
    infinite = np.full(n, np.inf)
    return Drive(
        np.where(joint, 1.0, moves.length), speed, acceleration, ones, ones, np.full((n, SAMPLES), np.inf),
        relative, zeros, infinite, infinite, zeros, zeros, rated,
    )  # fmt: skip


def runs(drive: Drive) -> np.ndarray:
    """Which rows have a path to run."""
    return (drive.length > 1e-9) & (drive.speed > 0)


def trapezoid(drive: Drive) -> np.ndarray:
    """Durations with constant acceleration, from rest to rest [s]."""
    rate = drive.acceleration
    return np.where(runs(drive), double_s(drive.length, drive.speed, rate, rate, np.inf), 0.0)


def seconds(drive: Drive) -> np.ndarray:
    """Duration of each move from rest to rest [s]; waits and moves without a path take 0."""
    step = np.diff(drive.length[:, None] * GRID, axis=1)
    top = np.minimum(drive.speed, drive.cap.min(axis=1)) ** 2
    rise, gain = _ramp(drive, step, top, drive.up, +1)
    fall, loss = _ramp(drive, step[:, ::-1], top, drive.down[:, ::-1], -1)
    total = _within(step, top[:, None], rise[:, :-1], gain, fall[:, ::-1][:, 1:], loss[:, ::-1]).sum(axis=1)
    if drive.build_up.any():
        jerk = drive.rated / np.maximum(drive.build_up, 1e-12)
        rates = (drive.acceleration * drive.up.mean(1), drive.acceleration * drive.down.mean(1))
        plain = double_s(drive.length, drive.speed, *rates, np.inf)
        total += np.where(drive.build_up > 0, double_s(drive.length, drive.speed, *rates, jerk) - plain, 0.0)
    return np.where(runs(drive), total, 0.0)


def _within(step, top, rise, gain, fall, loss) -> np.ndarray:
    """Time in each step, at the least of three squares of the speed: one that rises from its start by `gain`, `top`,
    and one that falls to its end by `loss`."""
    gain, loss = 2 * np.maximum(gain, 1e-12), 2 * np.maximum(loss, 1e-12)
    up = np.clip((top - rise) / gain, 0, step)  # until here it rises
    down = step - np.clip((top - fall) / loss, 0, step)  # from here on it falls
    cross = np.clip((fall + loss * step - rise) / (gain + loss), 0, step)
    up, down = np.where(up > down, cross, up), np.where(up > down, cross, down)
    first, last = rise + gain * up, fall + loss * (step - down)
    time = 2 * up / np.maximum(np.sqrt(rise) + np.sqrt(first), 1e-12)
    time += (down - up) / np.sqrt(np.maximum(top, 1e-12))
    return time + 2 * (step - down) / np.maximum(np.sqrt(last) + np.sqrt(fall), 1e-12)


def _ramp(
    drive: Drive, step: np.ndarray, top: np.ndarray, share: np.ndarray, sign: int
) -> tuple[np.ndarray, np.ndarray]:
    """Square of the speed that a ramp from rest reaches at each point, and its acceleration in each step."""
    square, rate = np.zeros((len(step), SAMPLES)), np.zeros_like(step)
    fades = np.isfinite(drive.knee) & ((sign > 0) | (drive.brake > 0))
    knee, idle = np.where(fades, drive.knee, 0.0), np.where(fades, drive.idle, 1.0)
    for k in range(SAMPLES - 1):
        here = drive.acceleration * (share[:, k] + share[:, k + 1]) / 2
        v = np.sqrt(np.minimum(square[:, k] + here * step[:, k], top))  # in the middle of the step
        fade = np.where(fades, np.clip((idle - v * drive.relative) / (idle - knee), 0.02, 1.0), 1.0)
        rate[:, k] = np.maximum(here * fade - sign * drive.drag * v, 0.05 * drive.acceleration)
        square[:, k + 1] = np.minimum(square[:, k] + 2 * rate[:, k] * step[:, k], top)
    return square, rate


def double_s(length, speed, acceleration, deceleration, jerk) -> np.ndarray:
    """Duration of a profile whose acceleration rises and falls at a finite rate (jerk inf: a trapezoid) [s]."""

    def ramp(v):
        """Mean time of the ramps from rest to v and back."""
        first, last = (
            np.where(v * jerk >= rate**2, v / rate + rate / jerk, 2 * np.sqrt(v / jerk))
            for rate in (acceleration, deceleration)
        )
        return (first + last) / 2

    with np.errstate(invalid="ignore", divide="ignore"):
        low, high = np.zeros_like(length), np.array(speed, float)
        for _ in range(45):  # the peak speed of a short move
            middle = (low + high) / 2
            fits = middle * ramp(middle) <= length
            low, high = np.where(fits, middle, low), np.where(fits, high, middle)
        peak = np.where(speed * ramp(speed) <= length, speed, low)
        return length / peak + ramp(peak)
