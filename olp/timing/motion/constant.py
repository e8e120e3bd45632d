"""Constant acceleration: the speed over time is a trapezoid or a triangle."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from olp.timing.motion._profile import ROUNDING, Floats, Problem, Profile, RequestedMoves
from olp.timing.motion.model import MotionModel, Values


class ConstantAcceleration(MotionModel):
    """Accelerate at a1, cruise at v_max, brake at a3 (Apostolovic's thesis, section 4.2).

    s1 = (v² - v0²) / 2a1   (4.7)     s3 = (v² - v1²) / 2a3   (4.14, here with an end speed v1)
    s2 = L - s1 - s3        (4.16)    T = (v - v0) / a1 + s2 / v + (v - v1) / a3   (4.5, 4.17, 4.12)
    v = v_max, or where s2 would be negative the peak of the triangle,
    v² = (2 L a1 a3 + v0² a3 + v1² a1) / (a1 + a3)   (4.19, here with an end speed v1).

    A move that starts faster than its programmed speed first brakes to it, at a3.
    """

    summary = "constant acceleration and deceleration: trapezoid or triangle of speed"
    source = "Apostolovic's thesis, section 4.2; start and end speeds added"

    phases: ClassVar[tuple[str, ...]] = ("acceleration", "cruise", "deceleration")

    def solve(self, moves: RequestedMoves, values: Values) -> Profile:
        """Three phases of constant acceleration; see the class for the formulas."""
        length, v0 = moves.length, moves.start_speed
        a, d = moves.acceleration, moves.deceleration
        v1, problem = _end_speeds(moves)
        # Lengths first and times from them: between nearly equal speeds their difference is mostly rounding.
        peak = np.sqrt((2 * length * a * d + v0**2 * d + v1**2 * a) / (a + d))
        triangle = peak < moves.speed
        top = np.where(triangle, np.maximum(peak, np.maximum(v0, v1)), np.maximum(moves.speed, v1))
        all_brakes = (problem == Problem.CANNOT_BRAKE) & (top == v1)
        rate = np.where((top < v0) | all_brakes, -d, a)
        gained = (v1 - v0) * (v1 + v0) / 2
        s1 = np.minimum((top - v0) * (top + v0) / (2 * rate), length)
        s1 = np.where(all_brakes, length, s1)
        s1 = np.where(triangle, np.clip((length * d + gained) / (a + d), 0.0, length), s1)
        s3 = np.minimum((top - v1) * (top + v1) / (2 * d), length - s1)
        s3 = np.where(triangle, np.clip((length * a - gained) / (a + d), 0.0, length), s3)
        s2 = np.where(triangle, 0.0, np.maximum(length - s1 - s3, 0.0))
        times = [_time(s1, top + v0), _time(s2, 2 * top), _time(s3, top + v1)]
        accelerations = np.stack([rate, np.zeros_like(rate), -d], axis=1)
        durations = np.stack(times, axis=1)
        return Profile.build(moves, self.phases, durations, accelerations, np.zeros_like(durations), problem)


def _time(length: Floats, speeds: Floats) -> Floats:
    """Time [s] for a length [m] at constant acceleration between two speeds of the given sum [m/s]."""
    return 2 * np.divide(length, speeds, out=np.zeros_like(length), where=speeds > 0)


def _end_speeds(moves: RequestedMoves) -> tuple[Floats, NDArray[np.int8]]:
    """The end speeds [m/s] that are possible, (n,), and the Problem where they differ from the requested ones, (n,)."""
    v0 = moves.start_speed
    v1 = np.minimum(moves.end_speed, moves.speed)
    problem = np.where(v1 < moves.end_speed, np.int8(Problem.CANNOT_REACH), np.int8(Problem.NONE))
    rate = np.where(v1 < v0, -moves.deceleration, moves.acceleration)
    short = (v1 - v0) * (v1 + v0) / (2 * rate) > moves.length * (1 + ROUNDING)
    problem[short] = np.where(v1 < v0, Problem.CANNOT_BRAKE, Problem.CANNOT_REACH)[short]
    nearest = np.sqrt(np.maximum(v0**2 + 2 * rate * moves.length, 0.0))
    return np.where(short, nearest, v1), problem
