"""One model: `olp predict` and `olp time --signature` say the same of the same move."""

from __future__ import annotations

import csv
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from numpy.typing import NDArray

from olp.fluent import read
from olp.identification.recording import read_recording
from olp.identification.signature import calibrate
from olp.identification.signature.document import Signature
from olp.identification.signature.rows import predict_recording
from olp.ir import program as ir
from olp.robots.robot import load_robot
from olp.runtime.paths import point_on_arc
from olp.runtime.plan import PATHS, Plan, StepKind
from olp.timing.timing import time_plan

Floats = NDArray[np.float64]
ROBOT = "abb/irb6640-235-2.55"
LINEAR, CIRCULAR, JOINT = (PATHS.index(p) for p in (ir.Path.LINEAR, ir.Path.CIRCULAR, ir.Path.JOINT))
_QUATERNION = "[0.043,0.723,0.086,0.684]"


def program(seed: int, kinds: str) -> str:
    """`kinds`: a letter per move: j joint, l line, a arc, L and A the same into a corner."""
    draw = np.random.default_rng(seed)
    lines, place = [], np.array([1420.0, -310.0, 1050.0])

    def target(at: Floats) -> str:
        numbers = ",".join(f"{v:.2f}" for v in at)
        return f"[[{numbers}],{_QUATERNION},[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"

    lines.append(f"    MoveJ {target(place)},v500,fine,tool0;")
    for kind in kinds:
        speed = draw.choice([100, 200, 300, 500])
        zone = "z10" if kind.isupper() else "fine"
        step = draw.uniform(60, 180, 3) * draw.choice([-1, 1], 3)
        step -= 0.3 * (place - np.array([1420.0, -310.0, 1050.0]))
        if kind in "lL":
            lines.append(f"    MoveL {target(place + step)},v{speed},{zone},tool0;")
        elif kind in "aA":
            middle = place + step / 2 + np.cross(step, draw.normal(size=3)) * 0.2 / 1.5
            lines.append(f"    MoveC {target(middle)},{target(place + step)},v{speed},{zone},tool0;")
        else:
            lines.append(f"    MoveJ {target(place + step)},v{speed},fine,tool0;")
        place = place + step
    body = "\n".join(lines)
    return f"MODULE Made\n  PROC main()\n{body}\n  ENDPROC\nENDMODULE\n"


def planned(folder: Path, name: str, text: str) -> Plan:
    path = folder / f"{name}.mod"
    path.write_text(text, encoding="utf-8")
    return read(path).plan(robot=ROBOT)


def rows_of(plan: Plan, name: str, driven: bool) -> list[dict[str, object]]:
    """The moves of the plan behind its first one as rows of a recording."""
    steps = plan.row[plan.kind == StepKind.MOVE][1:]
    moves, at = plan.moves, plan.positions
    found = []
    for row in steps.tolist():
        kind = moves.path[row]
        told: dict[str, object] = {
            "type": {LINEAR: "linear", CIRCULAR: "circular", JOINT: "joint"}[kind],
            "program": name,
        }
        for end, index in (("start", moves.start[row]), ("end", moves.target[row])):
            told |= {
                f"{a}_{end}_mm": 1000 * v for a, v in zip("xyz", at.position[index].tolist(), strict=True)
            }
            told |= {
                f"q{i + 1}_{end}_deg": float(np.degrees(v)) for i, v in enumerate(at.axes[index][:6].tolist())
            }
        if kind == CIRCULAR:
            ends = (at.position[[index]] for index in (moves.start[row], moves.target[row], moves.via[row]))
            (middle,) = point_on_arc(*ends, moves.before[[row]], np.array([0.5])).tolist()
            told |= {f"{a}_via_mm": 1000 * v for a, v in zip("xyz", middle, strict=True)}
        if kind == JOINT:
            turned = np.abs(at.axes[moves.target[row]] - at.axes[moves.start[row]])[:6]
            share = float(np.max(turned / load_robot(ROBOT).speeds) / (moves.length[row] / moves.travel[row]))
            told["speed_pct"] = 100 * min(share, 1.0)
            told["duration_s"] = (
                0.07 + float(np.max(turned / load_robot(ROBOT).speeds)) / min(share, 1.0) + 0.2
            )
        else:
            told["speed_mm_s"] = 1000 * moves.travel[row]
            told["blend_mm"] = 1000 * moves.blend[row] if np.nan_to_num(moves.blend[row]) > 0 else 0.0
            length = moves.length[row]
            told["duration_s"] = length / moves.travel[row] + moves.travel[row] / 2.1 + 0.04
        if not driven:
            told["duration_s"] = ""
        found.append(told)
    return found


def recorded(folder: Path, name: str, rows: list[dict[str, object]]) -> Path:
    place = folder / name
    place.mkdir()
    columns = ["move", *dict.fromkeys(key for row in rows for key in row)]
    with (place / "moves.csv").open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, columns)
        table.writeheader()
        table.writerows({"move": number, **row} for number, row in enumerate(rows, 1))
    (place / "recording.toml").write_text(f'robot = "{ROBOT}"\n', encoding="utf-8")
    return place


@cache
def learnt_from(kinds: str) -> Signature:
    with TemporaryDirectory() as folder:
        plan = planned(Path(folder), "learnt", program(1, kinds))
        place = recorded(Path(folder), "r", rows_of(plan, "learnt", driven=True))
        return calibrate(read_recording(place))[0]


@pytest.mark.parametrize(
    "learnt", ["llllllllll", "lLLlaaAlLAlalLl", "aaaaaaaa", "jjjjjjjj", "jlaLAljlLaljlLAlajlLl"]
)
@pytest.mark.parametrize("asked", ["l", "a", "j", "llaj", "LLl", "LAl", "lLlaj"])
def test_predict_and_time_say_the_same(tmp_path: Path, learnt: str, asked: str) -> None:
    signature = learnt_from(learnt)
    new = planned(tmp_path, "asked", program(2, asked))
    rows = rows_of(new, "asked", driven=False)
    told, _ = predict_recording(signature, read_recording(recorded(tmp_path, "p", rows)))
    timing = time_plan(new, signature=signature)
    steps = np.flatnonzero(new.kind == StepKind.MOVE)[1:]
    assert np.isfinite(told.predicted).all()
    # Where a stretch with corners is parted is a convention of the recorder until corners were learnt.
    begins = np.flatnonzero([True, *(letter.islower() for letter in asked[:-1])])
    by_time, by_prediction = (np.add.reduceat(v, begins) for v in (timing.duration_s[steps], told.predicted))
    corners = "corner" in signature.parts or (signature.paths is not None and signature.paths.corners)
    guessed = (
        not corners and asked != asked.lower()
    )  # both guess what such a corner saves, with a wide interval
    assert by_time == pytest.approx(by_prediction, rel=1e-2 if guessed else 2e-3)
    if signature.paths is not None and signature.paths.corners:
        assert timing.duration_s[steps] == pytest.approx(told.predicted, rel=2e-3)
