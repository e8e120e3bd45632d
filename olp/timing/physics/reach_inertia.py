"""`reach-inertia`: acceleration falls as the load is farther from the first axis."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from olp.timing.physics._case import Floats, Mask, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics._ramps import forced
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter

_LEAST = 0.1  # of the inertia that any reach leaves
_SPREAD = 0.05  # [m] of the distances from the first axis that has to be there
_LED = 8  # joint moves that other axes lead, or moves along which an arm is known: fewer tell nothing of them
_PLACES = 21  # along each path
_ARMS = (
    "whole arm",
    "three bodies",
    "any arm",
)  # forms of where the arm is along the path, not only at its ends
_ANY = "any axis"  # form of controllers that slow the whole arm, whichever axis leads a joint move
_ALL = "any axis, all of it"  # the same beside a simulation that knows of no reach


class ReachInertia(MoveTerm):
    summary = "acceleration falls as the load is farther from the first axis"
    does = "ramps far out are longer than ramps near the base, with the square of the distance"
    source = "Steiner's theorem: inertia about the first axis is I0 + m r²; Apostolovic, equation 6.3 (radial distance)"
    confusable = ("gravity", "joint-acceleration-limit", "payload")
    stage = Stage.SCALES
    phase = "accelerate"

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        near, far = _reaches(case)
        swings = _known(case) if _limited(case) else _swings(case) & np.isfinite(near + far)
        both = np.concatenate([near, far])[np.tile(swings, 2)]
        if len(both) < 8 or not np.isfinite(both).all() or np.ptp(both) < _SPREAD:
            return ()
        top = 8.0 / float(np.max(both)) ** 2
        one = TermParameter(
            "growth", "1/m^2", 0.0, top, 0.0, False, "of the inertia with the distance squared"
        )
        first = TermParameter(
            "growth", "1/m", 0.0, 8.0 / float(np.max(both)), 0.0, False, "of the inertia with distance"
        )
        simulated = TermParameter(
            "simulated", "m", float(np.min(both)), float(np.max(both)), np.nan, False, "reach as simulated"
        )
        place = TermParameter(
            "simulated",
            "1",
            -0.5,
            1.0,
            np.nan,
            False,
            "reach as simulated, from the least (0) to the most (1)",
        )
        if case.bodies_known:
            bodies = tuple(
                TermParameter(
                    name, "1/m^2", 0.0, top, 0.0, False, f"of the inertia with the {name}'s distance squared"
                )
                for name in ("wrist", "elbow", "forearm")
            )
            law = r"a = a_0 / (1 + k_w (r_w^2 - r_{w0}^2) + k_e (r_e^2 - r_{e0}^2)"
            arms = (
                Form(_ARMS[0], (*bodies[:2], place), law + ")"),
                Form(_ARMS[1], (*bodies, place), law + r" + k_f (r_f^2 - r_{f0}^2))"),
            )
        else:
            high = 4.0 / max(float(np.abs(_height(case)).max()), 1e-3)
            higher, farther = (
                TermParameter(name, unit, -most, most, 0.0, False, f"of the inertia with height{power}")
                for name, unit, most, power in (
                    ("height", "1/m", high, ""),
                    ("square", "1/m^2", high**2, " squared"),
                )
            )
            law = r"a = a_0 / (1 + k (r^2 - r_0^2) + k_h z + k_s (z^2 - z_0^2))"
            arms = (Form(_ARMS[2], (one, higher, farther, place), law),)
        led: tuple[Form, ...] = ()
        if int((_known(case) & ~_swings(case)).sum()) >= _LED:
            led = (
                Form(_ANY, (one, simulated), r"a(r) = a / (1 + k (r^2 - r_0^2))"),
                Form(_ALL, (one,), r"a(r) = a / (1 + k r^2)"),
            )
        return (
            *(arms if _placed(case).sum() >= _LED else ()),
            *led,
            Form("", (one,), r"a(r) = a / (1 + k r^2)"),
            Form("from a reach", (one, simulated), r"a(r) = a / (1 + k (r^2 - r_0^2))"),
            Form("middle", (one,), r"a(r) = a / (1 + k r_m^2)"),
            Form("linear", (first,), r"a(r) = a / (1 + k r)"),
            Form("across", (one,), r"a(r) = a / (1 + k r^2 \cos^2\varphi)"),
        )

    def lacks(self, case: MeasuredMoves) -> str:
        return "" if self.forms(case) else "moves with points at several distances from the first axis"

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        if form.key in _ARMS:
            most, more = form.parameters[0].high, len(form.parameters) - 2
            rest = [0.0 if form.key == "any arm" else 0.05 * most] * more
            return np.array([[0.1 * most, *rest, at] for at in (0.0, 0.5)])
        growth = np.array([[0.02], [0.12]]) * form.parameters[0].high
        if len(form.parameters) == 1:
            return growth
        reaches = 0.5 * (form.parameters[1].low + form.parameters[1].high)
        return np.array([[k[0], reaches] for k in growth])

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        if form.key in _ARMS:
            force = _left_of(case, _heavier(case, values))
            return forced(motion, force, force)
        start = case.once(f"reach {form.key} 0", lambda: _weight(case, form.key, 0))
        end = case.once(f"reach {form.key} 1", lambda: _weight(case, form.key, 1))
        if len(values) > 1:
            start, end = (np.where(at > 0, at - values[1] ** 2, 0.0) for at in (start, end))
        start, end = (np.maximum(1.0 + values[0] * at, _LEAST) for at in (start, end))
        if form.key not in (_ANY, _ALL) and _limited(case):
            start, end = _of_first_axis(case, start), _of_first_axis(case, end)
        return motion.with_(accelerate=motion.accelerate / start, decelerate=motion.decelerate / end)

    def beside_acceleration(
        self, form: Form, values: Floats, case: MeasuredMoves
    ) -> tuple[Floats, float] | None:
        """1 + k (r² - r₀²) = c (1 + k/c r²) with c = 1 - k r₀²: where the simulation is right at a reach, it is not at
        the first axis, by 1/c."""
        if form.parameters[-1].name != "simulated":
            return None
        if form.key not in _ARMS:
            growth, at_axis = values[:1], 1.0 - float(values[0] * values[1] ** 2)
            return None if at_axis < _LEAST else (np.append(growth / at_axis, 0.0), 1.0 / at_axis)
        growth = values[:-1]
        least, most = np.transpose([_ends(case, k) for k in range(len(growth) if case.bodies_known else 1)])
        near, apart = (float(growth[: len(least)] @ of) for of in (least, most - least))
        at_axis = 1.0 - near - float(values[-1]) * apart
        if apart <= 0 or at_axis < _LEAST:
            return None
        return np.append(growth / at_axis, -near / apart), 1.0 / at_axis

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        start, end = _reaches(case)
        if form.key in _ARMS:
            heavy = np.maximum(_heavier(case, values)[_placed(case)], _LEAST)
            less = 1.0 - float(heavy.min() / heavy.max())
            far = "where the arm is stretched out from the first axis"
            return f"{far} there is up to {less:.0%} less acceleration than near it"
        low, high = float(np.nanmin([start, end])), float(np.nanmax([start, end]))
        power = 1 if form.key == "linear" else 2
        base = 1.0 - values[0] * values[1] ** 2 if len(values) > 1 else 1.0
        ends = [max(base + values[0] * at**power, _LEAST) for at in (low, high)]
        less = 1.0 - ends[0] / ends[1]
        far = f"at {high * 1000:.0f} mm from the first axis"
        return f"{far} there is {less:.0%} less acceleration than at {low * 1000:.0f} mm"


def _reaches(case: MeasuredMoves) -> tuple[Floats, Floats]:
    """Distance from the first axis at start and at end, (n,) [m] each."""
    return np.hypot(case.start[:, 0], case.start[:, 1]), np.hypot(case.end[:, 0], case.end[:, 1])


def _weight(case: MeasuredMoves, key: str, end: int) -> Floats:
    """Growth (n,) [m² or m] of the inertia; 0 for joint moves and waits, whose points need not be known."""
    reach = _reaches(case)[end]
    if key == "middle":
        # A controller may ask once per move.
        middle = 0.5 * (case.start + case.end)
        reach = np.hypot(middle[:, 0], middle[:, 1])
    weight = reach if key == "linear" else reach**2
    if key == "across":
        weight = weight * _across(case, end) ** 2
    swings = _known(case) if key in (_ANY, _ALL) or _limited(case) else _swings(case)
    return np.where(swings, np.nan_to_num(weight), 0.0)


def _known(case: MeasuredMoves) -> Mask:
    """Moves (n,) whose points are known, whatever axis leads them."""
    return np.asarray(case.moving & np.isfinite(np.add(*_reaches(case))))


def _swings(case: MeasuredMoves) -> Mask:
    """Moves (n,) whose ramps the first axis' load may stretch: straight ones, and joint moves that this axis leads."""
    first = case.rates.names[0] if case.rates is not None else ""
    led = np.array([name == first != "" for name in case.leading], dtype=bool)
    return np.asarray(case.moving & (~case.joint | led))


def _limited(case: MeasuredMoves) -> bool:
    """Whether the acceleration of each axis is known, so that joint moves are slowed only as far as the first axis
    is.
    """
    return case.rates is not None and case.rates.rated_acceleration is not None


def _of_first_axis(case: MeasuredMoves, heavy: Floats) -> Floats:
    """Factor (n,) on the ramps where the first axis' inertia is `heavy` (n,) [1] times the simulated one.

    In joint moves it counts only as far as this axis then is the slowest.
    """
    first, others = _rooms(case)
    longer = np.minimum(first, others) / np.minimum(first / heavy, others)
    return np.where(case.joint, longer, heavy)


def _rooms(case: MeasuredMoves) -> tuple[Floats, Floats]:
    """Accelerations (n,) along the path that the first axis allows, and all others."""

    def room(axes: slice) -> Floats:
        assert case.rates is not None
        assert case.rates.rated_acceleration is not None
        asked = np.abs(case.rates.path[:, 0, axes]) / case.rates.rated_acceleration[axes]
        return np.asarray(1.0 / np.maximum(asked.max(axis=1), 1e-9))

    first, others = (case.once(f"room {k}", lambda k=k: room(k)) for k in (slice(0, 1), slice(1, None)))  # type: ignore[misc]
    return first, others


def _left_of(case: MeasuredMoves, heavy: Floats) -> Floats:
    """Share (n, m) of the acceleration along the path where the first axis' inertia is `heavy` (n, m) [1] times the
    simulated one; 1 where elbow and wrist are not known, and in joint moves that other axes lead.
    """
    share = 1.0 / np.maximum(heavy, _LEAST)
    if _limited(case):
        first, others = (room[:, None] for room in _rooms(case))
        turned = np.minimum(first * share, others) / np.minimum(first, others)
        share = np.where(case.joint[:, None], turned, share)
    return np.where((_placed(case) & (_limited(case) | _swings(case)))[:, None], share, 1.0)


def _placed(case: MeasuredMoves) -> Mask:
    """Moves (n,) along which elbow and wrist are known; without these, lines between points."""
    if not case.bodies_known:
        return np.asarray(_known(case) & ~case.joint & np.isfinite(case.start + case.end).all(axis=1))
    assert case.rates is not None
    assert case.rates.bodies is not None
    bodies = case.rates.bodies
    known = case.once("bodies", lambda: np.isfinite(bodies).all(axis=(1, 2, 3)).astype(float))
    return np.asarray(case.moving & (known > 0))


def _across(case: MeasuredMoves, end: int) -> Floats:
    """Share (n,) of the path that turns the first axis, per reach."""
    place = case.end if end else case.start
    way = case.end - case.start
    unit = way / np.maximum(np.linalg.norm(way, axis=1), 1e-9)[:, None]
    reach = np.maximum(np.hypot(place[:, 0], place[:, 1]), 1e-9)
    return np.asarray((place[:, 0] * unit[:, 1] - place[:, 1] * unit[:, 0]) / reach)


def _shape(case: MeasuredMoves) -> Floats:
    """What the parameters of an arm's form multiply along the path (n, m, p): squared distances of wrist, elbow and the
    forearm's middle from the first axis [m²] (a rod between two points has the inertia of masses at its ends and in its
    middle); where these are not known that of the tool, its height and that squared, a quadratic function that
    approximates any arm in one posture.
    """
    return case.once("shape", lambda: _of_bodies(case) if case.bodies_known else _of_tool(case))


def _heavier(case: MeasuredMoves, values: Floats) -> Floats:
    """(n, m) [1] the inertia along the path over the simulated one, which is right at the last value's reach."""
    shape, place = _shape(case), float(values[-1])
    heavy = np.ones(shape.shape[:2])
    for column, growth in enumerate(values[:-1].tolist()):
        if column and not case.bodies_known:
            right = _number_of(case, "mean", np.mean, column)
        else:
            least, most = _ends(case, column)
            right = least + place * (most - least)
        heavy += growth * (shape[..., column] - right)
    return heavy


def _ends(case: MeasuredMoves, column: int) -> tuple[float, float]:
    """[m²] The least and the most of a column of `_shape`."""
    return _number_of(case, "least", np.min, column), _number_of(case, "most", np.max, column)


def _number_of(case: MeasuredMoves, name: str, of: Callable[[Floats], float], column: int) -> float:
    def work_out() -> float:
        placed = _placed(case)
        return float(of(_shape(case)[placed, :, column])) if placed.any() else 0.0

    return case.number(f"reach {name} {column}", work_out)


def _of_bodies(case: MeasuredMoves) -> Floats:
    assert case.rates is not None
    assert case.rates.bodies is not None
    elbow, wrist = np.moveaxis(case.rates.bodies[..., :2], 2, 0)
    places = np.stack([wrist, elbow, 0.5 * (elbow + wrist)], axis=2)
    return np.asarray(np.nan_to_num((places**2).sum(axis=3)))


def _of_tool(case: MeasuredMoves) -> Floats:
    share = np.linspace(0.0, 1.0, _PLACES)[None, :, None]
    place = case.start[:, None, :] + share * (case.end - case.start)[:, None, :]
    up = place[..., 2] - _middle(case)
    return np.asarray(np.nan_to_num(np.stack([(place[..., :2] ** 2).sum(axis=2), up, up**2], axis=2)))


def _height(case: MeasuredMoves) -> Floats:
    """Of the ends of lines above their mean [m]."""
    ends = np.concatenate([at[_placed(case), 2] for at in (case.start, case.end)])
    return ends - _middle(case) if len(ends) else np.zeros(1)


def _middle(case: MeasuredMoves) -> float:
    """[m] mean height of the lines' ends."""
    lines = _placed(case)
    return case.number(
        "reach middle",
        lambda: float(np.mean([case.start[lines, 2], case.end[lines, 2]])) if lines.any() else 0.0,
    )
