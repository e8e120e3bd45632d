"""What every language's handling sample does, in numbers that come from no reader."""

from __future__ import annotations

import random
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from cpu_time import cpu_time_below
from scipy.spatial.transform import Rotation

import olp
from olp.core.source import decode
from olp.fluent import read_source
from olp.ir.program import LineKind, Opaque
from olp.runtime.plan import Plan

SAMPLES = Path(__file__).parent.parent / "samples"


def frame(*values: float) -> np.ndarray:
    """(4, 4) of x y z [mm], rx ry rz [deg] with R = Rz Ry Rx."""
    made = np.eye(4)
    made[:3, :3] = Rotation.from_euler("xyz", values[3:], degrees=True).as_matrix()
    made[:3, 3] = np.array(values[:3]) / 1000
    return made


def poses(plan: Plan) -> list[np.ndarray]:
    """(4, 4) of each move's target in the base."""
    found = []
    for target in plan.moves.target:
        made = np.eye(4)
        w, *xyz = plan.positions.quaternion[target]
        made[:3, 3] = plan.positions.position[target]
        if np.isfinite(w):
            made[:3, :3] = Rotation.from_quat([*xyz, w]).as_matrix()
        found.append(made)
    return found


def check_plan(plan: Plan) -> None:
    """Places, speeds, blends and waits of the common sample."""
    table, rack = frame(850.5, -210.25, 305.75, 1.5, -2.25, 33), frame(420, 640.5, 512, 0, 0, 90.5)
    turn = (178.5, 3.25, -21.5)
    wanted = [
        table @ frame(110.5, 45.25, 160, *turn),
        *[table @ frame(110.5, 45.25, 20.125 + 40 * n, *turn) for n in range(4)],
        table @ frame(260.25, 60, 40.5, 170.5, -4, 18),
        rack @ frame(55.5, -20.25, 88, 160, 12.5, -75),
    ]
    home = [5.5, -12.25, 18.75, 3.5, -47.25, 21.0]
    for move in (0, -1):
        axes = plan.positions.axes[plan.moves.target[move], :6]
        np.testing.assert_allclose(np.degrees(axes), home, atol=1e-9)
    for pose, expected in zip(poses(plan)[1:-1], wanted, strict=True):
        np.testing.assert_allclose(pose, expected, atol=1e-7)
    # The axes show which tool held.
    other = olp.read(SAMPLES / "krl/handling.src").plan("yaskawa/gp25")
    ours, theirs = (one.positions.axes[one.moves.target, :6] for one in (plan, other))
    np.testing.assert_allclose(ours, theirs, atol=1e-6)
    rounds = [one.positions.position[one.moves.via[one.moves.via >= 0]] for one in (plan, other)]
    assert len(rounds[0]) == 1
    np.testing.assert_allclose(rounds[0], rounds[1], atol=1e-7)
    assert list(plan.moves.fraction[[0, 1, -1]]) == pytest.approx([0.4, 0.55, 0.4])
    assert list(plan.moves.travel[2:8]) == pytest.approx([0.25, 0.1205, 0.1205, 0.1205, 0.15, 0.3])
    assert list(plan.moves.blend[[1, 3, 4, 5, 6]]) == pytest.approx([0.025, 0.005, 0.005, 0.005, 0.010])
    waits = [step.duration for step in plan.steps() if type(step).__name__ == "WaitStep"]  # type: ignore[union-attr]
    assert [one for one in waits if one] == pytest.approx([0.35, 0.1])


def check_whole(paths: Sequence[Path], told: frozenset[str] = frozenset()) -> None:
    """Files without a finding but those `told`, each line accounted for, which come back as they are."""
    for path in paths:
        found = olp.read(path)
        assert [d.render() for d in found.diagnostics if d.code not in told] == []
        assert found.to_bytes() == path.read_bytes()
        assert len(found.line_kinds) == len(found.source.lines)
        assert LineKind.ERROR not in found.line_kinds
        assert LineKind.OPAQUE not in found.line_kinds
        assert not any(isinstance(one, Opaque) for one in found.statements())


def check_damage(path: Path, seed: int) -> None:
    """Bytes flipped, put in and taken out: the reader neither raises nor hangs, and no byte is lost."""
    raw, dice = path.read_bytes(), random.Random(seed)
    with cpu_time_below(20):
        for _ in range(150):
            damaged = bytearray(raw)
            for _ in range(dice.randrange(1, 12)):
                at = dice.randrange(len(damaged))
                damaged[at : at + dice.randrange(4)] = bytes(
                    dice.randrange(256) for _ in range(dice.randrange(4))
                )
            if dice.random() < 0.2:
                del damaged[dice.randrange(len(damaged)) :]
            found = read_source(decode(bytes(damaged), path.name))
            assert found.to_bytes() == bytes(damaged)
            assert len(found.line_kinds) == len(found.source.lines)
