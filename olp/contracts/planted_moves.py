"""Moves whose slowness is known because it was planted: what `check_estimator` teaches and asks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from olp.contracts.models import trapezoid
from olp.core.units import deg
from olp.identification.signature import MoveSet
from olp.robots.geometry import rotation_from_angles
from olp.robots.kinematics import inverse
from olp.robots.robot import Robot

Array = NDArray[np.float64]
SLOWNESS: Final = 0.83  # [s²/m] of the planted recording: an acceleration of 1.2 m/s²
AXES: Final = (3.0, 2.5, 3.5, 6.0, 6.0, 7.0)  # [rad/s²] of the arm whose axes decide
_STEP: Final = 1e-4  # [m] of the differences
_MIRROR: Final = np.diag([1.0, -1.0, 1.0])


def made_by(moves: MoveSet, slowness: Array) -> MoveSet:
    """The moves as constant accelerations, one over `slowness` (n,) [s²/m], make them."""
    return replace(moves, duration=trapezoid(moves.length, moves.speed, 1.0 / slowness, 1.0 / slowness))


def mirrored(moves: MoveSet) -> MoveSet:
    """The same on the other side of the arm's plane of symmetry."""
    return replace(
        moves,
        start=moves.start @ _MIRROR,
        end=moves.end @ _MIRROR,
        rotation=_MIRROR @ moves.rotation @ _MIRROR,
    )


def laws(moves: MoveSet, robot: Robot) -> Mapping[str, Array]:
    """(n,) [s²/m] of what makes some moves slower than others, each by itself; nan where an axis is not known."""
    high = moves.start[:, 2] - moves.start[:, 2].mean()
    return {
        "upwards": SLOWNESS * (1.0 + 0.2 * moves.direction[:, 2]),
        "high up": SLOWNESS * (1.0 + 0.5 * high),
        "where an axis is slow": slowest_axis(moves, robot),
    }


def slowest_axis(moves: MoveSet, robot: Robot) -> Array:
    """(n,) [s²/m] where at each end of a move the axis that needs longest decides, of `AXES`; by small steps."""
    way = moves.direction * _STEP
    needed = [
        np.abs(_joints(moves, place + way, robot) - _joints(moves, place - way, robot)) / (2 * _STEP)
        for place in (moves.start, moves.end)
    ]
    first, last = ((rate / np.array(AXES[: rate.shape[1]])).max(axis=1) for rate in needed)
    return np.asarray(0.25 * SLOWNESS + 0.5 * (first + last))


def _joints(moves: MoveSet, places: Array, robot: Robot) -> Array:
    joints, reached = inverse(robot, places, moves.rotation)
    return np.asarray(np.where(reached[:, None], joints, np.nan))


@lru_cache(maxsize=2)
def all_kinds(robot: Robot, count: int = 56, seed: int = 15) -> MoveSet:
    """Moves in every plane, of two loads, two tool orientations and two postures, from six start points.

    Among them are some that tell nothing: not measured, faster than their speed allows, of unknown orientation.
    """
    rng, rows = np.random.default_rng(seed), np.arange(count)
    starts = np.array(
        [
            [0.8, 0.0, 0.5],
            [0.8, 0.3, 0.5],
            [0.9, -0.2, 0.8],
            [1.1, 0.1, 0.4],
            [1.0, 0.0, 0.9],
            [0.7, -0.4, 0.6],
        ]
    )
    way = rng.normal(size=(count, 3))
    way[rows % 3 == 0, 2] = 0.0  # level
    way[rows % 3 == 1, 0] = 0.0  # upright
    way *= (rng.uniform(0.05, 0.35, count) / np.linalg.norm(way, axis=1))[:, None]
    start = starts[rows % len(starts)]
    tilted = rows % 7 == 2
    angles = np.where(tilted[:, None], [165.0, 10.0, 0.0], [180.0, 0.0, 0.0]) * deg
    rotation = rotation_from_angles(angles)
    rotation[rows % 19 == 5] = np.nan
    moves = MoveSet(
        start=start,
        end=start + way,
        rotation=rotation,
        speed=rng.choice([0.2, 0.5, 1.0], count),
        nominal=np.full(count, 1.0 / SLOWNESS),
        duration=np.full(count, np.nan),
        payload=np.where(rows % 5 == 3, 20.0, 6.0),
        configuration=tuple("000100" if k % 11 == 4 else "000000" for k in rows),
        program=tuple(f"P{k % 4}" for k in rows),
    )
    slow = SLOWNESS * (1.0 + 0.15 * moves.direction[:, 2] + 0.1 * tilted + 0.1 * (moves.payload > 10.0))
    slow = slow * (1.0 + 0.01 * rng.standard_normal(count)) + 0.1 * np.linalg.norm(start[:, :2], axis=1)
    moves = made_by(moves, slow)
    moves.duration[rows % 23 == 7] = np.nan
    moves.duration[rows % 29 == 11] *= 0.5
    return moves
