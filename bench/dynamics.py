"""How right and how fast rigid-body dynamics is: `python bench/dynamics.py`. Exit status 1 when a figure is missed.

The independent library is pinocchio (`pip install pin`), in the same run on the same machine and samples. Both get the
same chain: the UR10e with its published masses and a load of 6 kg, and a chain without anything regular: six
joints along random directions, one of them sliding, full inertias. Times are process CPU time, the median of
seven runs; pinocchio is called once per sample from Python, its `rneaInParallel` (one thread) once for all.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable

import numpy as np
import pinocchio
from numpy.typing import NDArray
from tables import print_table

from olp.robots.dynamics import (
    Body,
    DynamicModel,
    bias_forces,
    dynamic_model,
    gravity_torques,
    inverse_dynamics,
    mass_matrix,
    move_acceleration,
    path_acceleration,
)
from olp.robots.model import tensor
from olp.robots.robot import Axis, Drive, Dynamics, Geometry, Joint, Robot, load_robot

Array = NDArray[np.float64]

SAMPLES = 100_000
COMPARED = 5_000
RUNS = 7
ASKED_RATE = 500_000.0  # [samples/s]
ASKED_AGREEMENT = 1e-9  # relative to the largest torque of the axis
LOAD = Body(6.0, (0.02, -0.03, 0.1), (0.03, 0.02, 0.01, 0.001, 0.002, 0.003))
MOVES = 2_000


def main() -> int:
    robots = {"UR10e": load_robot("ur10e"), "irregular chain": irregular_robot()}
    figures, speeds, held = [], [], True
    for name, robot in robots.items():
        model = dynamic_model(robot)
        peer = pinocchio_model(model)
        q, qd, qdd = samples(len(robot.axes))
        worst = disagreements(model, peer, q, qd, qdd)
        rate = per_second(lambda m=model, x=(q, qd, qdd): inverse_dynamics(m, *x, LOAD))
        held &= rate >= ASKED_RATE and max(worst.values()) <= ASKED_AGREEMENT
        figures += [
            (f"{name}: {what} against pinocchio", "1e-09", f"{value:.1e}") for what, value in worst.items()
        ]
        figures.append((f"{name}: inverse dynamics", f">= {ASKED_RATE:,.0f}/s", f"{rate:,.0f}/s"))
        speeds += comparisons(name, model, peer, (q, qd, qdd))
    print_table(("figure", "asked", "measured"), figures)
    print("\nfor comparison, same samples:\n")
    print_table(("what", "samples/s"), [(what, f"{rate:,.0f}") for what, rate in speeds])
    return 0 if held else 1


def irregular_robot() -> Robot:
    rng = np.random.default_rng(5)
    directions = rng.normal(size=(6, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    joints = [
        Joint(i, tuple(direction.tolist()), tuple((rng.normal(size=3) * 0.4).tolist()))
        for i, direction in enumerate(directions)
    ]
    bodies = []
    for _ in joints:
        points = rng.normal(size=(6, 3)) * 0.1
        points -= points.mean(axis=0)
        moments = np.trace(points.T @ points) * np.eye(3) - points.T @ points
        entries = [moments[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        bodies.append(
            Body(rng.uniform(2, 20), tuple((rng.normal(size=3) * 0.2).tolist()), tuple(map(float, entries)))
        )
    axes = tuple(Axis(f"A{i}", -3.0, 3.0, 2.0, linear=i == 2) for i in range(6))
    dynamics = Dynamics(tuple(bodies), tuple(Drive(100.0) for _ in axes))
    return Robot(
        "bench/irregular",
        "bench",
        "irregular",
        axes,
        geometry=Geometry(tuple(joints), (0.1, 0.2, 0.3)),
        dynamics=dynamics,
    )


def pinocchio_model(model: DynamicModel) -> pinocchio.Model:
    """The same chain, with the load on the last link."""
    robot = model.robot
    assert robot.geometry is not None
    assert robot.dynamics is not None
    peer, parent = pinocchio.Model(), 0
    peer.gravity.linear = np.array(model.gravity)
    for joint in robot.geometry.joints:
        direction = np.array(joint.direction)
        slides = robot.axes[joint.axis].linear
        kind = pinocchio.JointModelPrismaticUnaligned if slides else pinocchio.JointModelRevoluteUnaligned
        place = pinocchio.SE3(np.eye(3), np.array(joint.offset))
        parent = peer.addJoint(parent, kind(direction), place, robot.axes[joint.axis].name)
        append(peer, parent, robot.dynamics.bodies[joint.axis], pinocchio.SE3.Identity())
    flange = pinocchio.SE3(np.array(robot.geometry.flange_rotation), np.array(robot.geometry.flange_offset))
    append(peer, parent, LOAD, flange)
    return peer


def append(peer: pinocchio.Model, parent: int, body: Body, place: pinocchio.SE3) -> None:
    inertia = pinocchio.Inertia(body.mass, np.array(body.centre), tensor(body.inertia))
    peer.appendBodyToJoint(parent, inertia, place)


def samples(axes: int) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(1)
    return (
        rng.uniform(-3, 3, (SAMPLES, axes)),
        rng.normal(size=(SAMPLES, axes)),
        rng.normal(size=(SAMPLES, axes)) * 5,
    )


def disagreements(model: DynamicModel, peer: pinocchio.Model, *motion: Array) -> dict[str, float]:
    """Largest difference of each quantity, relative to the largest value of the same axis (of the matrix)."""
    q, qd, qdd = (part[:COMPARED] for part in motion)
    data = peer.createData()
    torques = [pinocchio.rnea(peer, data, *row) for row in zip(q, qd, qdd, strict=True)]
    biases = [pinocchio.rnea(peer, data, *row, np.zeros(len(q[0]))) for row in zip(q, qd, strict=True)]
    weights = [pinocchio.computeGeneralizedGravity(peer, data, row) for row in q]
    matrices = []
    for row in q:
        upper = np.triu(pinocchio.crba(peer, data, row))
        matrices.append(upper + np.triu(upper, 1).T)
    return {
        "torques": relative(inverse_dynamics(model, q, qd, qdd, LOAD), torques),
        "bias forces": relative(bias_forces(model, q, qd, LOAD), biases),
        "gravity": relative(gravity_torques(model, q, LOAD), weights),
        "mass matrix": relative(
            mass_matrix(model, q, LOAD).reshape(len(q), -1), np.reshape(matrices, (len(q), -1))
        ),
    }


def relative(ours: Array, theirs: list[Array] | Array) -> float:
    scale = np.abs(theirs).max(axis=0)
    # The torque of gravity on an upright axis is rounding alone: it is compared with the largest of all.
    scale = np.maximum(scale, 1e-3 * scale.max())
    return float((np.abs(ours - theirs) / scale).max())


def comparisons(
    name: str, model: DynamicModel, peer: pinocchio.Model, motion: tuple[Array, Array, Array]
) -> list[tuple[str, float]]:
    q, qd, qdd = motion
    limits = np.abs(qd).max(axis=1)[:MOVES]
    work: dict[str, Callable[[], object]] = {
        "inverse_dynamics": lambda: inverse_dynamics(model, q, qd, qdd, LOAD),
        "bias_forces": lambda: bias_forces(model, q, qd, LOAD),
        "gravity_torques": lambda: gravity_torques(model, q, LOAD),
        "mass_matrix": lambda: mass_matrix(model, q, LOAD),
        "path_acceleration": lambda: path_acceleration(model, q, qd, qdd, 0.5, LOAD),
    }
    rates = [(f"{name}: {what}", per_second(call)) for what, call in work.items()]
    moves = (
        per_second(lambda: move_acceleration(model, q[:MOVES], q[-MOVES:], limits, LOAD)) * MOVES / SAMPLES
    )
    rates.append((f"{name}: move_acceleration (moves/s)", moves))
    return rates + peers(name, peer, motion)


def peers(name: str, peer: pinocchio.Model, motion: tuple[Array, Array, Array]) -> list[tuple[str, float]]:
    data = peer.createData()
    rows = list(zip(*motion, strict=True))

    def one_by_one() -> None:
        for row in rows:
            pinocchio.rnea(peer, data, *row)

    rates = [(f"{name}: pinocchio rnea", per_second(one_by_one, 3))]
    if hasattr(pinocchio, "rneaInParallel"):
        pool = pinocchio.ModelPool(peer, 1)
        columns = [np.asfortranarray(part.T) for part in motion]
        out = np.zeros_like(columns[0])
        rates.append(
            (
                f"{name}: pinocchio rneaInParallel, 1 thread",
                per_second(lambda: pinocchio.rneaInParallel(1, pool, *columns, out)),
            )
        )
    return rates


def per_second(work: Callable[[], object], runs: int = RUNS) -> float:
    work()
    times = []
    for _ in range(runs):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return SAMPLES / statistics.median(times)


if __name__ == "__main__":
    sys.exit(main())
