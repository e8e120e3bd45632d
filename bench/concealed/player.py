"""The controller and its drives, played in time steps: how long each move takes under the limits it is given.

A leg starts at rest and is stepped in time until the speed is reached and the acceleration has gone; the end of a step
in which that happens is found inside it, so no time is a multiple of the step. A move is a leg forwards, a leg
backwards from its end, and the cruise between; where the two legs would meet, the speed is lowered until they just do.
Where the path itself limits the speed, the move is swept along the path forwards and backwards instead.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
STEP = 0.001  # s
SWEEP = 1200  # steps along a path
_LEAST = 0.05  # share of the nominal acceleration that is always there


@dataclass(slots=True)
class Drive:
    """What the drives can do in each of n moves, at G points along each.

    speed (n,) [m/s]; up, down (n, G) [m/s^2]; jerk (n,) [m/s^3], inf; per_speed (n, G) [s/m] the fastest axis' share of
    its no-load speed per path speed; knee: the share of that speed above which torque falls linearly to nothing;
    viscous (n,) [1/s]; first, second (n, G, 6) slopes of the axes; most (6,) [rad/s^2]; fastest (6,) [rad/s].
    """

    length: Floats
    speed: Floats
    up: Floats
    down: Floats
    jerk: Floats
    per_speed: Floats
    knee: float
    viscous: Floats
    first: Floats
    second: Floats
    most: Floats
    fastest: Floats
    step: float = STEP

    def times(self) -> Floats:
        """(n,) [s]"""
        path_limited = bool(np.isfinite(self.most).any() or np.isfinite(self.fastest).any())
        if path_limited:
            return _sweep_all(
                self.length, self.speed, self.up, self.down, self.per_speed, self.knee, self.viscous,
                self.first, self.second, self.most, self.fastest, max(200, round(SWEEP * STEP / self.step)),
            )  # fmt: skip
        return _step_all(
            self.length, self.speed, self.up, self.down, self.jerk, self.per_speed, self.knee, self.viscous, self.step
        )  # fmt: skip


@numba.njit(cache=True, error_model="numpy")
def _at(row, share):
    place = share * (len(row) - 1)
    if place <= 0:
        return row[0]
    k = int(place)
    if k >= len(row) - 1:
        return row[len(row) - 1]
    return row[k] + (place - k) * (row[k + 1] - row[k])


@numba.njit(cache=True, error_model="numpy")
def _available(row, w, share, v, knee, viscous):
    """Acceleration that is left at a place and a speed; `viscous` < 0 helps (braking)."""
    full = _at(row, share)
    used = _at(w, share) * v
    torque = 1.0
    if used > knee:
        torque = max(0.0, (1.0 - used) / (1.0 - knee))
    return max(full * torque - viscous * v, _LEAST * full)


@numba.njit(cache=True, error_model="numpy")
def _leg(peak, row, w, length, jerk, knee, viscous, dt):
    """(time, way) from rest to `peak` with no acceleration left, in steps of dt."""
    t, s, v, a = 0.0, 0.0, 0.0, 0.0
    rigid = not np.isfinite(jerk)
    for _ in range(400_000):
        most = _available(row, w, min(s / length, 1.0), v, knee, viscous)
        if rigid:
            a = most
            middle = _available(row, w, min((s + v * dt / 2) / length, 1.0), v + a * dt / 2, knee, viscous)
            a = middle
            if v + a * dt >= peak:
                part = (peak - v) / a
                return t + part, s + (v + peak) / 2 * part
            s += v * dt + a * dt * dt / 2
            v += a * dt
            t += dt
            continue
        # The ramp down from acceleration a gains a^2 / 2j: it begins where that just reaches the peak.
        rate = jerk if a < most else -jerk
        step = dt
        if rate > 0 and a + jerk * dt > most:
            step = max((most - a) / jerk, 1e-9)
        elif rate < 0 and a - jerk * dt < most:
            rate, a = 0.0, most
        after_a = a + rate * step
        after_v = v + a * step + rate * step * step / 2
        if after_v + after_a * after_a / (2 * jerk) >= peak:
            low, high = 0.0, step
            for _ in range(40):
                mid = (low + high) / 2
                am = a + rate * mid
                if v + a * mid + rate * mid * mid / 2 + am * am / (2 * jerk) < peak:
                    low = mid
                else:
                    high = mid
            s += v * low + a * low * low / 2 + rate * low**3 / 6
            v += a * low + rate * low * low / 2
            a += rate * low
            t += low
            break
        s += v * step + a * step * step / 2 + rate * step**3 / 6
        v, a, t = after_v, after_a, t + step
    while a > 0.0:
        step = min(dt, a / jerk)
        s += v * step + a * step * step / 2 - jerk * step**3 / 6
        v += a * step - jerk * step * step / 2
        a -= jerk * step
        t += step
        if step < dt:
            break
    return t, s


@numba.njit(cache=True, error_model="numpy")
def _step_all(length, speed, up, down, jerk, w, knee, viscous, dt):
    n = len(length)
    times = np.zeros(n)
    for i in range(n):
        if length[i] <= 0:
            continue
        back, back_w = down[i, ::-1].copy(), w[i, ::-1].copy()
        # A motor that loses its torque at a speed cannot pass it.
        fast = max(w[i].max(), 1e-12)
        top = min(speed[i], 0.98 / fast)
        t1, s1 = _leg(top, up[i], w[i], length[i], jerk[i], knee, viscous[i], dt)
        t2, s2 = _leg(top, back, back_w, length[i], jerk[i], knee, -viscous[i], dt)
        if s1 + s2 <= length[i]:
            times[i] = t1 + t2 + (length[i] - s1 - s2) / top
            continue
        # The way grows nearly as the square of the speed; what is left in the end goes at that speed.
        mid, way = top, s1 + s2
        for _ in range(30):
            mid = min(mid * np.sqrt(length[i] / way), top)
            t1, s1 = _leg(mid, up[i], w[i], length[i], jerk[i], knee, viscous[i], dt)
            t2, s2 = _leg(mid, back, back_w, length[i], jerk[i], knee, -viscous[i], dt)
            way = s1 + s2
            if abs(way - length[i]) < 1e-6 * length[i]:
                break
        times[i] = t1 + t2 + (length[i] - s1 - s2) / max(mid, 1e-9)
    return times


@numba.njit(cache=True, error_model="numpy")
def _limit(full, used, v, knee, viscous, slope, bend, most, side):
    """Acceleration left at a place and a speed, also by the axes' own limits; `side` -1 when braking."""
    torque = 1.0
    if used * v > knee:
        torque = max(0.0, (1.0 - used * v) / (1.0 - knee))
    best = max(full * torque - viscous * v, _LEAST * full)
    for j in range(6):
        if most[j] < 1e8 and abs(slope[j]) > 1e-9:
            turned = side * bend[j] * v * v * (1.0 if slope[j] >= 0 else -1.0)
            best = min(best, max((most[j] - turned) / abs(slope[j]), _LEAST * best))
    return best


@numba.njit(cache=True, error_model="numpy")
def _sweep_all(length, speed, up, down, w, knee, viscous, first, second, most, fastest, steps):
    n, grid = up.shape
    times = np.zeros(n)
    v = np.zeros(steps + 1)
    slope, bend = np.zeros((steps, 6)), np.zeros((steps, 6))
    rise, fall, used = np.zeros(steps), np.zeros(steps), np.zeros(steps)
    cap = np.zeros(steps)
    for i in range(n):
        if length[i] <= 0:
            continue
        ds = length[i] / steps
        for k in range(steps):
            place = (k + 0.5) / steps * (grid - 1)
            g = min(int(place), grid - 2)
            part = place - g
            rise[k] = up[i, g] + part * (up[i, g + 1] - up[i, g])
            fall[k] = down[i, g] + part * (down[i, g + 1] - down[i, g])
            used[k] = w[i, g] + part * (w[i, g + 1] - w[i, g])
            cap[k] = min(speed[i], 0.98 / max(used[k], 1e-12))
            for j in range(6):
                slope[k, j] = first[i, g, j] + part * (first[i, g + 1, j] - first[i, g, j])
                bend[k, j] = second[i, g, j] + part * (second[i, g + 1, j] - second[i, g, j])
                if abs(slope[k, j]) > 1e-9:
                    cap[k] = min(cap[k], fastest[j] / abs(slope[k, j]))
                if most[j] < 1e8 and abs(bend[k, j]) > 1e-9:
                    cap[k] = min(cap[k], np.sqrt(most[j] / abs(bend[k, j])))
        v[0] = 0.0
        for k in range(steps):
            a = _limit(rise[k], used[k], v[k], knee, viscous[i], slope[k], bend[k], most, 1.0)
            v[k + 1] = min(cap[k], np.sqrt(v[k] * v[k] + 2 * a * ds))
        v[steps] = 0.0
        for k in range(steps - 1, -1, -1):
            a = _limit(fall[k], used[k], v[k + 1], knee, -viscous[i], slope[k], bend[k], most, -1.0)
            v[k] = min(v[k], cap[k], np.sqrt(v[k + 1] * v[k + 1] + 2 * a * ds))
        total = 0.0
        for k in range(steps):
            total += 2 * ds / max(v[k] + v[k + 1], 1e-9)
        times[i] = total
    return times


@numba.njit(cache=True, error_model="numpy")
def _tails(length, speed, down, way, fly, dt):
    n = len(length)
    times = np.zeros(n)
    for i in range(n):
        if length[i] <= 0:
            continue
        back = down[i, ::-1].copy()
        t, s, v = 0.0, 0.0, 0.0
        asked = min(way[i], 0.5 * length[i])
        while s < asked and v < speed[i]:
            a = _at(back, min(s / length[i], 1.0))
            step = dt
            if v + a * dt > speed[i]:
                step = (speed[i] - v) / a
            gone = v * step + a * step * step / 2
            if s + gone > asked:
                part = (-v + np.sqrt(v * v + 2 * a * (asked - s))) / a
                t += part
                v += a * part
                s = asked
                break
            s += gone
            v += a * step
            t += step
            if step < dt:
                v = speed[i]
                break
        if fly:
            times[i] = t - s / max(v, 1e-9)
        else:
            times[i] = t + (asked - s) / max(v, 1e-9)
    return times


def tails(drive: Drive, way: Floats, fly: bool) -> Floats:
    """(n,) [s] of the last `way` (n,) [m] of the moves; `fly`: what is saved by not braking at all."""
    return _tails(drive.length, drive.speed, drive.down, way, fly, drive.step)
