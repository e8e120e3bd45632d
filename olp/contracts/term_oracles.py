"""What each physics term does to each move, worked out anew from its equation and from nothing that the term computes.

An oracle is a function named as its term. It gets a case, the form and its values, and says the columns of the motion
(`olp.timing.physics._motion.Motion`) that the form changes, each (n,); all others have to stay as they are. Ramps that
are integrals are added up in many small steps, so that a term that takes few is compared within a tolerance.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from olp.contracts.promises import Difference
from olp.timing.physics import Form, MoveTerm
from olp.timing.physics._case import MeasuredMoves

Array = NDArray[np.float64]
Columns = dict[str, Array]
Oracle = Callable[[MeasuredMoves, Form, Array], Columns]
_FINE: Final = 400  # points of a ramp
_U: Final = (np.arange(_FINE) + 0.5) / _FINE  # speeds that a ramp passes, as shares of its full speed
NEAR: Final[Mapping[str, float]] = {
    "viscous-friction": 0.01,
    "torque-speed": 0.05,
    "joint-acceleration-limit": 0.05,
    "joint-speed-limit": 0.05,
    "payload-inertia limit": 0.12,
    "reach-inertia whole arm": 0.05,
    "reach-inertia three bodies": 0.05,
    "reach-inertia any arm": 0.05,
    "gravity whole arm": 0.06,
    "gravity any arm": 0.06,
    "gravity each axis": 0.06,
    "gravity each axis against alone": 0.06,
    "gravity incline of the tool": 0.06,
}  # relative, by term or by term and form; all others are exact
COARSE: Final[Mapping[str, float]] = {
    "joint-speed-limit": 0.1
}  # [s] more, where a term samples the path coarsely


def straight(case: MeasuredMoves) -> NDArray[np.bool_]:
    return case.moving & ~case.joint


def both(case: MeasuredMoves, up: Array, down: Array | None = None) -> Columns:
    """Ramps that are `up` and `down` (n,) times the simulated ones."""
    return {
        "accelerate": case.base.accelerate * up,
        "decelerate": case.base.decelerate * (up if down is None else down),
    }


def top_speed(case: MeasuredMoves) -> Array:
    """(n,) [m/s] that is reached: v, or on short paths the speed whose two ramps cover the whole length."""
    base = case.base
    peak = np.sqrt(2.0 * np.maximum(base.way, 1e-9) / (1.0 / base.accelerate + 1.0 / base.decelerate))
    found: Array = np.minimum(base.speed, peak)
    return found


def in_ramp(case: MeasuredMoves, values: Array, end: int, whole: bool = False) -> Array:
    """Values (n, m, …) along the path, interpolated where a ramp passes the speeds `_U`: (n, _FINE, …).

    Under a constant acceleration from rest the distance is proportional to the square of the speed. `whole`: the ramp
    goes to the programmed speed, over half of the path at most; else to the speed that is reached.
    """
    base = case.base
    slow = base.decelerate if end else base.accelerate
    full = base.speed if whole else top_speed(case)
    share = full**2 / (2.0 * slow) / np.maximum(base.way, 1e-9)
    share = np.clip(share, 0.02, 0.5) if whole else share
    grid = np.linspace(0.0, 1.0, values.shape[1])
    flat = values.reshape(len(values), values.shape[1], -1)
    out = np.empty((len(values), _FINE, flat.shape[2]))
    places = np.clip(share[:, None] * _U**2, 0.0, 1.0)
    places = 1.0 - places if end else places
    for k in range(len(values)):
        for c in range(flat.shape[2]):
            out[k, :, c] = np.interp(places[k], grid, flat[k, :, c])
    return out.reshape(len(values), _FINE, *values.shape[2:])


def longer(force: Array) -> Array:
    """(n,) time that a ramp takes longer than its distance at full speed, ∫ (1 - u) du / force; 1 for a force of 1."""
    found: Array = (2.0 * (1.0 - _U) / force).mean(axis=1)
    return found


def rates_of(case: MeasuredMoves, rated: Array | None, axis: int) -> Array:
    """(n, m) turn of an axis per path length; for -1 the largest over all axes, each divided by its rating."""
    assert case.rates is not None
    path = np.abs(case.rates.path)
    if axis >= 0:
        return np.asarray(path[:, :, axis])
    return np.asarray((path / (np.ones(path.shape[2]) if rated is None else rated)).max(axis=2))


def leads(case: MeasuredMoves, axis: int) -> NDArray[np.bool_]:
    """(n,) moves in which the axis needs the longest time at rated speeds, or turns farthest if these are unknown."""
    assert case.rates is not None
    turned = np.abs(case.rates.path).mean(axis=1)
    turned = turned / (np.ones(turned.shape[1]) if case.rates.rated is None else case.rates.rated)
    found: NDArray[np.bool_] = case.rates.known & (turned.argmax(axis=1) == axis)
    return found


# --- scales -------------------------------------------------------------------------------------------------


def acceleration(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """T = L/v + v/(k a): k times the acceleration, or the acceleration itself where all moves have one. Along the way:
    not of the planned ones at corners."""
    absolute = form.parameters[0].unit != "1"
    k = values[0] / np.median((case.base.accelerate / case.ratio)[case.moving]) if absolute else values[0]
    about = case.joint & case.moving & leads(case, form.axis) if form.axis >= 0 else np.ones(len(case), bool)
    k = np.where(about, k, 1.0)
    corners = () if form.key == "along the way" else ("open_start", "open_end")
    return {**both(case, k), **{name: getattr(case.base, name) * k for name in corners}}


def speed_scale(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """v becomes k v, or oᵖ v; stretched: the duration is divided by it; of an axis: in joint moves that it leads."""
    k = case.override ** values[0] if form.key.startswith("override") else np.full(len(case), values[0])
    if form.axis >= 0:
        k = np.where(case.joint & leads(case, form.axis), k, 1.0)
    if form.key in ("stretched", "override"):
        return {"rate": case.base.rate * np.where(case.moving, 1.0 / k, 1.0)}
    return {"speed": case.base.speed * k}


def payload(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """a / (1 + k m), a (1 - k m), or a (1 + k m₀) / (1 + k m) with one simulated mass, or that of each; at corners,
    too: likewise the acceleration across the way."""
    mass = np.nan_to_num(case.payload)
    if form.key == "real over simulated":
        return both(case, (1.0 + values[0] * np.nan_to_num(case.sim_payload)) / (1.0 + values[0] * mass))
    if form.key == "weight":
        return both(case, 1.0 - values[0] * mass)
    simulated = values[1] if len(values) > 1 else 0.0
    share = (1.0 + values[0] * simulated) / (1.0 + values[0] * mass)
    share = np.where(np.isfinite(case.payload), share, 1.0)
    corners = ("open_start", "open_end") if form.key == "at corners, too" else ()
    return {**both(case, share), **{name: getattr(case.base, name) * share for name in corners}}


def payload_inertia(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """Euler: the wrist's share of the turning is slowed by 1 + k I; or its rated acceleration is; or joint moves whose
    slowest axis is of the wrist.

    Real over simulated: of joint moves alone where there are any, as straight ones have a written acceleration.
    """
    inertia = np.nan_to_num(case.payload_inertia)
    wrist = np.zeros(len(case))
    if case.rates is not None:
        turned = np.abs(case.rates.path).mean(axis=1)
        most = turned.max(axis=1)
        wrist = np.where(most > 0, turned[:, 3:].max(axis=1) / np.where(most > 0, most, 1.0), 0.0)
    if form.key == "limit":
        assert case.rates is not None
        assert case.rates.rated_acceleration is not None
        share = (np.abs(case.rates.path[:, :, 3:]) / case.rates.rated_acceleration[3:]).max(axis=2)
        factors = []
        for end, slow in enumerate((case.base.accelerate, case.base.decelerate)):
            with np.errstate(divide="ignore"):
                limit = 1.0 / in_ramp(case, share, end, whole=True).mean(axis=1)
            slowed = np.minimum(slow, limit / (1.0 + values[0] * inertia))
            factors.append(slowed / np.minimum(slow, limit))
        return both(case, *factors)
    if form.key.endswith("leading axis"):
        set_by_wrist = np.any([leads(case, axis) for axis in (3, 4, 5)], axis=0)
        wrist = (set_by_wrist & case.joint & case.moving).astype(float)
    if form.key.startswith("real over simulated"):
        w = leads(case, form.axis).astype(float) if form.axis >= 0 else wrist
        w = w * (case.joint if (case.joint & case.moving).any() else 1.0)
        simulated = np.nan_to_num(case.sim_payload_inertia)
        known = np.isfinite(case.payload_inertia + case.sim_payload_inertia) & case.moving
        ratio = (1.0 + values[0] * w * simulated) / (1.0 + values[0] * w * inertia)
        return both(case, np.where(known, ratio, 1.0))
    w = np.ones(len(case)) if form.key == "every move" else wrist
    return both(case, 1.0 / (1.0 + values[0] * w * inertia))


def reach_inertia(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """Steiner: the inertia about the first axis is 1 + k r²; or with k r, k r² cos²φ, r₀, at the middle, of bodies."""
    if form.key in ("whole arm", "three bodies"):
        assert case.rates is not None
        assert case.rates.bodies is not None
        elbow, wrist = case.rates.bodies[:, :, 0, :2], case.rates.bodies[:, :, 1, :2]
        bodies = [wrist, elbow, (elbow + wrist) / 2.0][: len(values) - 1]
        square = np.stack([np.linalg.norm(at, axis=2) ** 2 for at in bodies], axis=2)
        told = square[case.moving & np.isfinite(square).all(axis=(1, 2))].reshape(-1, len(bodies))
        right = told.min(axis=0) + values[-1] * np.ptp(told, axis=0)
        heavy = np.maximum(1.0 + (square - right) @ values[:-1], 0.1)
        limited = case.rates.rated_acceleration is not None
        known = straight(case) | (case.moving & case.joint & (limited | leads(case, 0)))
        places = [least_axis(case, at) if limited else 1.0 / at for at in heavy.T]
        share = np.where(known[:, None], np.nan_to_num(np.stack(places, axis=1), nan=1.0), 1.0)
        return _available(case, share, share)
    if form.key == "any arm":
        lines = straight(case) & np.isfinite(case.start + case.end).all(axis=1)
        at = np.linspace(0.0, 1.0, 101)[:, None]
        middle = np.mean(np.concatenate([case.start[lines, 2], case.end[lines, 2]]))
        shape = np.zeros((len(case), 101, 3))
        for row in np.nonzero(lines)[0].tolist():
            x, y, z = (case.start[row] + at * (case.end[row] - case.start[row])).T
            shape[row] = np.stack([x**2 + y**2, z - middle, (z - middle) ** 2], axis=1)
        told = shape[lines][:, ::5].reshape(-1, 3)  # the points of the path that the term samples
        right = told.mean(axis=0)
        right[0] = told[:, 0].min() + values[3] * np.ptp(told[:, 0])
        heavy = np.maximum(1.0 + (shape - right) @ values[:3], 0.1)
        share = np.where(lines[:, None], 1.0 / heavy, 1.0)
        return _available(case, share, share)
    about = straight(case)
    if case.rates is not None:
        about = about | (case.moving & case.joint & leads(case, 0))
    whichever = form.key.startswith("any axis")  # leads
    limited = not whichever and case.rates is not None and case.rates.rated_acceleration is not None
    if whichever or limited:
        about = case.moving & np.isfinite(case.start[:, :2] + case.end[:, :2]).all(axis=1)
    unit = case.end - case.start
    unit = unit / np.maximum(np.linalg.norm(unit, axis=1), 1e-9)[:, None]
    factors = []
    for place in (case.start, case.end):
        at = 0.5 * (case.start + case.end) if form.key == "middle" else place
        r = np.hypot(at[:, 0], at[:, 1])
        grown = r if form.key == "linear" else r**2
        if form.key == "across":
            tangent = np.stack([-place[:, 1], place[:, 0]], axis=1) / np.maximum(r, 1e-9)[:, None]
            grown = grown * (tangent * unit[:, :2]).sum(axis=1) ** 2
        if form.key in ("from a reach", "any axis"):
            grown = grown - values[1] ** 2
        more: Array = np.where(about, np.maximum(1.0 + values[0] * np.nan_to_num(grown), 0.1), 1.0)
        factors.append(least_axis(case, more) if limited else 1.0 / more)
    return both(case, *factors)


def least_axis(case: MeasuredMoves, heavy: Array) -> Array:
    """(n,) share of each ramp's acceleration that remains when that of the first axis is divided by `heavy` (n,).

    In joint moves the slowest axis decides, before and after.
    """
    assert case.rates is not None
    assert case.rates.rated_acceleration is not None
    asked = np.abs(case.rates.path[:, 0]) / case.rates.rated_acceleration
    more = asked * np.stack([heavy, *[np.ones(len(case))] * (asked.shape[1] - 1)], axis=1)
    remains = np.maximum(asked.max(axis=1), 1e-9) / np.maximum(more.max(axis=1), 1e-9)
    return np.asarray(np.where(case.joint, remains, 1.0 / heavy))


def coulomb_friction(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """Friction reduces the acceleration and adds to the deceleration, by a share of the force."""
    one = np.ones(len(case))
    return both(case, (1.0 - values[0]) * one, (1.0 + values[0]) * one)


def viscous_friction(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """a - k v speeding up, a + k v braking; of the fastest axis a (1 - k v) and a (1 + k v); or braking as without."""
    if form.key.startswith("axes"):
        assert case.rates is not None
        per = rates_of(case, case.rates.rated, -1)
        used = [in_ramp(case, per, end) for end in (0, 1)]
    else:
        used = [
            np.repeat(1.0 / slow[:, None], len(_U), axis=1)
            for slow in (case.base.accelerate, case.base.decelerate)
        ]

    def slower(end: int, top: Array) -> Array:
        helped = 0.0 if form.key.endswith("speeding up") else -1.0
        against = values[0] * used[end] * top[:, None] * _U * (helped if end else 1.0)
        return np.asarray(1.0 / np.maximum(1.0 - against, 0.05))

    return both(case, *_by_speed(case, case.base.speed, slower))


def torque_speed(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """a (1 - v/v₀), the same above a knee, or a v_b/v; v of the path or of the fastest axis where the ramp passes."""
    of, law = form.key.split()
    if of == "path":
        per = np.repeat((1.0 / case.ratio)[:, None], 2, axis=1)
    else:
        assert case.rates is not None
        per = rates_of(case, case.rates.rated, -1)
    speed = case.base.speed
    if law != "power":
        speed = np.minimum(speed, 0.98 * values[0] / np.maximum(per.max(axis=1), 1e-12))
    knee = values[1] if law == "knee" else 0.0
    used = [in_ramp(case, per, end) for end in (0, 1)]

    def slower(end: int, top: Array) -> Array:
        share = used[end] * top[:, None] * _U / values[0]
        if law == "power":
            return np.asarray(np.maximum(1.0, share))
        return np.asarray(1.0 / np.clip((1.0 - share) / (1.0 - knee), 0.02, 1.0))

    return {**both(case, *_by_speed(case, speed, slower)), "speed": speed}


def _by_speed(
    case: MeasuredMoves, speed: Array, slower: Callable[[int, Array], Array]
) -> tuple[Array, Array]:
    """(n,) factors on both ramps to `speed` (n,) where `slower` (end, speed reached) says the reciprocal (n, _FINE) of
    the remaining share of the acceleration; on short paths the speed whose ramps cover the way, by bisection."""
    base = case.base
    peak = np.sqrt(2.0 * np.maximum(base.way, 1e-9) / (1.0 / base.accelerate + 1.0 / base.decelerate))

    def ramps(top: Array) -> tuple[Array, Array]:
        """(n,) distance and time from rest to a speed and back."""
        both_ways = [(slower(0, top), base.accelerate), (slower(1, top), base.decelerate)]
        way = sum(top**2 / slow * (over * _U).mean(axis=1) for over, slow in both_ways)
        return np.asarray(way), np.asarray(sum(top / slow * over.mean(axis=1) for over, slow in both_ways))

    found = [1.0 / longer(1.0 / slower(end, np.minimum(speed, peak))) for end in (0, 1)]
    short = (base.way > 0) & (ramps(np.minimum(speed, peak))[0] > (1.0 + 1e-6) * base.way)
    low, high = np.zeros(len(case)), speed
    for _ in range(30):
        fits = ramps(0.5 * (low + high))[0] <= base.way
        low, high = np.where(fits, 0.5 * (low + high), low), np.where(fits, high, 0.5 * (low + high))
    whole = ramps(low)[1]
    with np.errstate(divide="ignore", invalid="ignore"):
        even = 4.0 * base.way / whole**2
        even = np.where(
            2.0 * base.way <= speed * whole,
            even,
            speed / (whole - base.way / np.maximum(speed, 1e-12)),
        )
    up, down = (
        np.where(short, even / slow, one)
        for one, slow in zip(found, (base.accelerate, base.decelerate), strict=True)
    )
    return up, down


def gravity(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """The pull along the way takes from one ramp and gives to the other, or takes from both, by the form's equation."""
    if form.key == "whole arm":
        return _lifted(case, values)
    if form.key == "any arm":
        return _pulled_anywhere(case, values)
    if form.key.startswith("each axis"):
        return _held_up(case, form, values)
    way = case.end - case.start
    length = np.linalg.norm(way, axis=1)
    about = straight(case) & (length > 0)
    rise = np.where(about, np.nan_to_num(way[:, 2] / np.where(length > 0, length, 1.0)), 0.0)
    if form.key == "incline of the tool":
        assert case.rates is not None
        assert case.rates.climb is not None
        turning = (case.joint & case.moving & np.isfinite(case.rates.climb).all(axis=1))[:, None]
        sine = np.where(turning, case.rates.climb, rise[:, None])
        return _available(case, 1.0 - values[0] * sine, 1.0 + values[1] * sine)
    if form.key == "lift and reach":
        nearer = np.hypot(case.start[:, 0], case.start[:, 1]) - np.hypot(case.end[:, 0], case.end[:, 1])
        inward = np.where(about, np.nan_to_num(nearer / np.where(length > 0, length, 1.0)), 0.0)
        pull = values[0] * rise + values[1] * inward
        return both(case, np.maximum(1.0 - pull, 0.05), np.maximum(1.0 + pull, 0.05))
    k = values[0]
    up, down = {
        "both ramps": (1.0 - k * rise, 1.0 - k * rise),
        "steep": (1.0 - k * np.abs(rise),) * 2,
        "against and with": (1.0 - k * rise, 1.0 + k * rise),
        "against alone": (np.minimum(1.0, 1.0 - k * rise), np.minimum(1.0, 1.0 + k * rise)),
        "starting alone": (1.0 - k * rise, np.ones(len(case))),
        "starting and braking apart": (1.0 - k * rise, 1.0 + values[-1] * rise),
        "up and down apart": (1.0 - np.where(rise > 0, k * rise, -values[-1] * rise),) * 2,
    }[form.key]
    return both(case, np.maximum(up, 0.05), np.maximum(down, 0.05))


def _held_up(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """Each axis of a joint move loses, of what it could accelerate, what it holds of each body against its turn; the
    least that any axis has left, over the least that any had, is what remains of the ramp. Lines are lifted."""
    rates, told = case.rates, dict(zip((p.name for p in form.parameters), values.tolist(), strict=True))
    assert rates is not None
    assert rates.lifts is not None
    turns, axes = rates.path[:, 0], range(rates.path.shape[2])
    if rates.rated_acceleration is None:
        could = np.stack([np.where(leads(case, k), 1.0, np.inf) for k in axes], axis=1)
    else:
        with np.errstate(divide="ignore"):
            could = rates.rated_acceleration / np.abs(turns)
    about = case.joint & case.moving & rates.known & np.isfinite(could).any(axis=1)
    could = np.where(about[:, None], could, np.inf)
    least = np.where(about, could.min(axis=1), 1.0)[:, None]
    loads = {
        "elbow": np.ones(len(case)),
        "wrist": 1.0 + told.get("load", 0.0) * np.nan_to_num(case.payload),
    }
    left = [np.repeat(could[:, None, :], rates.lifts.shape[1], axis=1) for _ in (0, 1)]
    for k, name in enumerate(rates.names):
        pull = np.zeros(rates.lifts.shape[:2])
        for which, body in enumerate(("elbow", "wrist")):
            out = np.nan_to_num(rates.lifts[:, :, which, k])
            share = told.get(f"{body}_{name.lower().replace(' ', '_')}", 0.0)
            if share:
                out = out / np.abs(out[could[:, k] < 2.0 * least[:, 0]]).max()
            pull += share * loads[body][:, None] * out * np.sign(turns[:, k])[:, None]
        for remains, sign in zip(left, (1.0, -1.0), strict=True):
            remains[:, :, k] *= np.maximum(1.0 - sign * pull, 0.05)
    up, down = (np.where(about[:, None], one.min(axis=2) / least, 1.0) for one in left)
    if "wrist" in told:
        pull = np.where(
            straight(case)[:, None],
            np.nan_to_num(_slopes(case) @ np.array([told["elbow"], told["wrist"]])),
            0.0,
        )
        up, down = up * (1.0 - pull), down * (1.0 + pull)
    most = 1.0 if form.key.endswith("alone") else np.inf
    return _available(case, np.minimum(up, most), np.minimum(down, most))


def _slopes(case: MeasuredMoves) -> Array:
    """(n, m, 2) rise of elbow and wrist per path length."""
    assert case.rates is not None
    assert case.rates.bodies is not None
    height = np.nan_to_num(case.rates.bodies[..., 2])
    way = np.maximum(case.base.way, 1e-9)[:, None, None]
    return np.asarray(np.gradient(height, axis=1) * (height.shape[1] - 1) / way)


def _lifted(case: MeasuredMoves, values: Array) -> Columns:
    """Rise of wrist and elbow per path length, over each ramp."""
    return _against(case, _slopes(case) @ np.array([values[1], values[0]]))


def _against(case: MeasuredMoves, pull: Array) -> Columns:
    """A pull (n, m) along the way takes from the ramp at the start and gives to that at the end."""
    pull = np.where(straight(case)[:, None], np.nan_to_num(pull), 0.0)
    return _available(case, 1.0 - pull, 1.0 + pull)


def _available(case: MeasuredMoves, starting: Array, stopping: Array, least: float = 0.05) -> Columns:
    """Of each ramp's acceleration along the way (n, m), at least a share, walked in small steps of speed; how fast a
    short way gets depends on both, so the walk is repeated until that stays."""
    base, way = case.base, np.maximum(case.base.way, 1e-9)
    force = np.maximum(np.stack([starting, stopping[:, ::-1]]), least)
    slow = np.stack([base.accelerate, base.decelerate])
    top, ramps, anew = top_speed(case), np.empty_like(slow), np.ones(len(case), dtype=bool)
    for _ in range(20):
        # A move that gets as fast as before needs no other walk.
        ramp = (top**2 / (slow * way))[:, anew]
        longer = _walked(force[:, anew].reshape(ramp.size, -1), ramp.ravel()).reshape(ramp.shape)
        ramps[:, anew] = slow[:, anew] / longer
        up, down = ramps
        before, top = top, np.minimum(base.speed, np.sqrt(2.0 * way / (1.0 / up + 1.0 / down)))
        anew = before != top
        if np.allclose(before, top, rtol=1e-12, atol=0.0):
            break
    return {"accelerate": up, "decelerate": down}


def _walked(force: Array, ramp: Array) -> Array:
    """(n,) `longer` of a force (n, m) along the way from a ramp's rest on; `ramp`: V²/a over the way."""
    first, last = np.arange(len(force)) * force.shape[1], force.shape[1] - 1
    values, rises = (
        force.ravel(),
        np.append(np.diff(force, axis=1), np.zeros((len(force), 1)), axis=1).ravel(),
    )
    place, result = np.zeros(len(force)), np.zeros(len(force))
    for u in _U:
        at = np.minimum(place, 1.0) * last
        left = np.minimum(at.astype(int), last - 1)
        here = values.take(first + left) + (at - left) * rises.take(first + left)
        result += 2.0 * (1.0 - u) / here / _FINE
        place = place + ramp * u / here / _FINE
    return result


def _pulled_anywhere(case: MeasuredMoves, values: Array) -> Columns:
    """U' = (k_u + k_h ζ - k_m ρ) z' - (k_i + k_f ρ - k_m ζ) r' along the straight way."""
    about, places = straight(case), np.linspace(0.0, 1.0, 201)[None, :, None]
    points = case.start[:, None, :] + places * (case.end - case.start)[:, None, :]
    z, r = points[..., 2], np.hypot(points[..., 0], points[..., 1])
    way = np.maximum(np.linalg.norm(case.end - case.start, axis=1), 1e-9)[:, None]
    zeta, rho = (
        (one - np.nanmean(one[about][:, [0, -1]])) / max(2.0 * np.nanstd(one[about][:, [0, -1]]), 1e-3)
        for one in (z, r)
    )
    rising, farther = (np.gradient(one, axis=1) * 200 / way for one in (z, r))
    up, inward, higher, far, mixed = values
    pull = (up + higher * zeta - mixed * rho) * rising - (inward + far * rho - mixed * zeta) * farther
    return _against(case, pull)


# --- limits -------------------------------------------------------------------------------------------------


def speed_clamp(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """No straight move is faster; where there are none, no joint move."""
    about = straight(case) if straight(case).any() else case.moving & case.joint
    limit = values[0] * case.ratio
    return {"speed": np.where(about & (case.base.speed > limit), limit, case.base.speed)}


def orientation_limit(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """v ≤ ω L / θ, and a ≤ α L / θ, or not; or the turn as a motion of its own, from rest to rest, to wait for."""
    turn = np.where(straight(case), np.nan_to_num(case.turn), 0.0)
    if form.key == "slows the path":
        with np.errstate(divide="ignore", invalid="ignore"):
            limit = np.where((turn > 1e-9) & (case.base.way > 0), values[0] * case.base.way / turn, np.inf)
        return {"speed": np.minimum(case.base.speed, limit)}
    if form.key == "slows the path and its ramps":
        limited = {}
        for name, most in zip(("speed", "accelerate", "decelerate"), (*values, values[1]), strict=True):
            column = getattr(case.base, name).copy()
            for k in np.flatnonzero((turn > 1e-6) & (case.base.way > 0)).tolist():
                column[k] = min(column[k], most * case.base.way[k] / turn[k])
            limited[name] = column
        return limited
    if form.key == "of its own, at once":
        seconds = turn / values[0]
    elif form.key == "of its own, in two ramps":
        seconds = 2.0 * np.sqrt(turn / values[0])
    else:
        rate, ramp = values
        peak = np.minimum(rate, np.sqrt(turn * ramp))
        seconds = turn / np.maximum(peak, 1e-12) + peak / ramp
    seconds = np.where(turn > 1e-6, seconds, 0.0)  # angles are rounded
    return {"least": np.maximum(case.base.least, seconds)}


def joint_acceleration_limit(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """a ≤ A / |q'| where the ramp passes."""
    assert case.rates is not None
    rates = np.maximum(rates_of(case, case.rates.rated_acceleration, form.axis), 1e-12)
    up, down = (
        np.minimum(1.0, values[0] / (rates * slow[:, None]))
        for slow in (case.base.accelerate, case.base.decelerate)
    )
    return _available(case, up, down, 1e-9)


def joint_speed_limit(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """ds/dt ≤ V / |q'|: at once, or swept along the way forwards and backwards with the ramps' accelerations."""
    assert case.rates is not None
    base, fine = case.base, 8
    rates = rates_of(case, case.rates.rated, form.axis)
    grid = np.linspace(0.0, 1.0, rates.shape[1])
    added = base.added.copy()
    per = 4 * fine * (rates.shape[1] - 1)
    places = np.linspace(0.0, 1.0, per + 1)
    reached = top_speed(case)
    for k in np.nonzero(case.moving & (base.way > 0))[0].tolist():
        rate = np.interp(places, grid, rates[k])
        if form.key.endswith(" at once"):
            asked = rate * np.minimum(
                np.minimum(np.sqrt(2 * base.accelerate[k] * places * base.way[k]), base.speed[k]),
                np.sqrt(2 * base.decelerate[k] * (1.0 - places) * base.way[k]),
            )
            if asked[::fine].max() > values[0]:
                lost = np.maximum(rate / values[0] - 1.0 / reached[k], 0.0)
                added[k] += base.way[k] * 0.5 * (lost[1:] + lost[:-1]).mean()
        elif (rate * base.speed[k]).max() > values[0]:
            limit = np.minimum(base.speed[k], values[0] / np.maximum(rate, 1e-12))
            free = np.full(per + 1, base.speed[k])
            added[k] += _swept(case, k, limit) - _swept(case, k, free)
    return {"added": added}


def _swept(case: MeasuredMoves, k: int, limit: Array) -> float:
    """[s] of move k along its way below `limit`, from rest to rest."""
    base = case.base
    square, step = (limit**2).tolist(), base.way[k] / (len(limit) - 1)
    starting, braking = (float(2.0 * slow[k] * step) for slow in (base.accelerate, base.decelerate))
    square[0] = square[-1] = 0.0
    for i in range(1, len(square)):
        square[i] = min(square[i], square[i - 1] + starting)
    for i in range(len(square) - 2, -1, -1):
        square[i] = min(square[i], square[i + 1] + braking)
    fast = np.sqrt(square)
    return float((2.0 * step / np.maximum(fast[1:] + fast[:-1], 1e-9)).sum())


# --- shapes, additions, clocks ------------------------------------------------------------------------------


def jerk(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """Every ramp builds up at j, of joint moves beside straight ones at as many times their acceleration; filtered: the
    speed passes a moving average of that length, half at corners: behind the planner, which does not know of it; each
    axis: the simulated acceleration builds up in that time."""
    if form.key == "filtered":
        return {"filtered": case.base.filtered + values[0]}
    if form.key == "filtered, half at corners":
        return {"delayed": np.where(case.moving, values[0] - case.base.filtered, 0.0)}
    if form.key == "each axis":
        built = case.base.accelerate / max(values[0], 1e-9)
        return {"jerk": np.where(case.base.jerk > built, built, case.base.jerk)}
    return {"jerk": np.where(case.base.jerk > values[0] * case.ratio, values[0] * case.ratio, case.base.jerk)}


def dispatch(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """A constant to every move, and to waits where the form says so."""
    about = np.ones(len(case), bool) if form.key == "waits too" else case.moving
    return {"added": case.base.added + np.where(about, values[0], 0.0)}


def settling(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """A constant to every move that ends in an exact stop; as written: that names no rounding."""
    stops = case.moving & case.stop_end
    stops = stops & ~(case.blend > 0) & ~np.isnan(case.blend) if form.key == "as written" else stops
    return {"added": case.base.added + np.where(stops, values[0], 0.0)}


def clock(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """Every duration, times the rate of the recorder's clock."""
    return {"rate": case.base.rate * values[0]}


def warm_up(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """A e^(-t/τ) of each duration, of the simulated one, or in seconds; cold as simulated: A (1 - e^(-t/τ)). Of ramps,
    that share of the acceleration is missing, or stiff ones last that share longer."""
    began = case.began if np.isfinite(case.began) else case.t_start.min()
    cold = np.exp((began - case.t_start) / values[1])
    if form.key == "seconds":
        return {"added": case.base.added + np.where(case.moving, values[0] * cold, 0.0)}
    if form.key == "share of the simulated":
        return {"added": case.base.added + np.where(case.moving, values[0] * cold * case.simulated, 0.0)}
    if form.key in ("ramps", "stiff ramps"):
        slower, base = 1.0 / (1.0 + values[0] * cold), case.base
        left = np.maximum(1.0 - values[0] * cold, 0.05) if form.key == "ramps" else slower
        return {
            name: getattr(base, name) * left
            for name in ("accelerate", "decelerate", "open_start", "open_end")
        }
    share = 1.0 - cold if form.key.endswith("cold as simulated") else cold
    return {"rate": case.base.rate * np.where(case.moving, 1.0 + values[0] * share, 1.0)}


def cycle_quantisation(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """c ⌈T/c⌉, or the nearest multiple: the whole duration is rounded; that of waits, or not."""
    nearest, moves_alone = form.key.startswith("nearest"), form.key.endswith("but waits")
    return {
        "cycle": np.array(values[0]),
        "early": np.array(0.5 if nearest else 0.0),
        "timed": np.array(float(moves_alone)),
    }


def blending(case: MeasuredMoves, form: Form, values: Array) -> Columns:
    """The law of the corners by its name, and its numbers in the order of the parameters; a simulation that stops at
    them takes there what it takes at stops, which is saved as well. As planned: what it saves in the simulation.
    Resized: the simulation's law, at corners of another size."""
    given = dict(zip((p.name for p in form.parameters), values.tolist(), strict=True))
    if form.key.endswith(", as planned"):
        own = form._replace(key=form.key.removesuffix(", as planned"))
        law = {
            name: value if value.ndim else value.item() for name, value in blending(case, own, values).items()
        }
        stops, saved = (case.base.with_(**how).duration() for how in ({"law": "stop"}, law))
        return {"law": np.array("stop"), "added": case.base.added - (stops - saved)}
    if form.key.endswith(", resized"):
        start, end = (given["size"] * rounding for rounding in (case.base.round_start, case.base.round_end))
        return {"round_start": start, "round_end": end}
    at_corners = case.moving & (case.base.round_end > 0) & (case.base.law == "stop")
    return {
        "added": np.where(at_corners, 0.0, case.base.added),
        "law": np.array(form.key.removesuffix(", cut").removesuffix(", as a share")),
        "overlap": np.array(given.get("overlap", given.get("saving"))),
        "split": np.array(given.get("split", 0.5)),
        "reach": np.array(given.get("reach", 0.5)),
        "portion": np.array(given.get("portion", 0.0)),
    }


# --- what a recording tells -----------------------------------------------------------------------------------


def found_cycles(term: MoveTerm, case: MeasuredMoves) -> Iterator[Difference]:
    """The longest cycle that durations are multiples of is found, no part of it; none where they are of none."""
    n = len(case)

    def cycles(measured: Array, resolution: float) -> list[float]:
        forms = term.forms(replace(case, measured=measured, resolution=resolution, derived={}))
        return [0.5 * (form.parameters[0].low + form.parameters[0].high) for form in forms]

    for cycle in (0.004, 0.008, 0.010, 0.012, 0.016, 0.032):
        rng = np.random.default_rng(int(cycle * 1e4))
        measured = np.round(rng.uniform(0.2, 2.5, n) / cycle) * cycle + rng.normal(0, 0.03 * cycle, n)
        found = cycles(measured, 1e-4)
        if not found or abs(found[0] / cycle - 1.0) > 1e-3:
            yield f"multiples of {cycle * 1e3:g} ms", f"cycles of {found} s"
    for seed in range(12):
        found = cycles(np.random.default_rng(seed).uniform(0.2, 2.5, n), 1e-4)
        if found:
            yield "durations that are no multiples", f"cycles of {found} s"
    found = cycles(np.round(np.random.default_rng(8).uniform(0.2, 2.5, n), 2), 0.01)
    if found:
        yield "the clock's own digits", f"cycles of {found} s"
    # A recorder that rounds to 10 ms shows a cycle of 12 ms at 1/12 and at 1/10 - 1/12 per ms.
    rng = np.random.default_rng(12)
    found = cycles(np.round(np.round(rng.uniform(0.2, 2.5, n) / 0.044) * 0.044, 2), 0.01)
    if not any(abs(one / 0.044 - 1.0) < 1e-3 for one in found):
        yield "multiples of 44 ms, rounded to 10 ms", f"cycles of {found} s"


FOUND: Final[Mapping[str, Callable[[MoveTerm, MeasuredMoves], Iterator[Difference]]]] = {
    "cycle-quantisation": found_cycles
}
ORACLES: Final[Mapping[str, Oracle]] = {
    "acceleration": acceleration,
    "blending": blending,
    "clock": clock,
    "coulomb-friction": coulomb_friction,
    "cycle-quantisation": cycle_quantisation,
    "dispatch": dispatch,
    "gravity": gravity,
    "jerk": jerk,
    "joint-acceleration-limit": joint_acceleration_limit,
    "joint-speed-limit": joint_speed_limit,
    "orientation-limit": orientation_limit,
    "payload": payload,
    "payload-inertia": payload_inertia,
    "reach-inertia": reach_inertia,
    "settling": settling,
    "speed-clamp": speed_clamp,
    "speed-scale": speed_scale,
    "torque-speed": torque_speed,
    "viscous-friction": viscous_friction,
    "warm-up": warm_up,
}
