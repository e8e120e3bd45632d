"""Writes docs/physics.md, the list of all terms, from the terms themselves; tests/test_physics.py holds the page to it.

    python bench/physics_page.py

What forms a term has hangs on what a recording tells, so the page is that of a recording that tells everything: a GP25
at random places, with roundings, loads, joint moves, turns of the tool and waits, in multiples of 12 ms.
"""

from __future__ import annotations

import csv
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from olp.diagnosis.case_making import case_of  # noqa: E402
from olp.geometry import angles_from_rotation, rotation_from_angles  # noqa: E402
from olp.kinematics import inverse  # noqa: E402
from olp.physics import LogTerm, MoveTerm, Parameter, Term, load_term, term_names  # noqa: E402
from olp.physics._case import Case  # noqa: E402
from olp.recording import read_recording  # noqa: E402
from olp.robots.library import load_robot  # noqa: E402
from olp.units import deg, mm  # noqa: E402

PAGE = ROOT / "docs/physics.md"
ROBOT = "yaskawa/gp25"
CYCLE = 0.012  # [s]
_SPEEDS = (0.05, 0.15, 0.4, 0.9)  # [m/s]
_ACCELERATION = 2.5  # [m/s²]


def rich_case(
    moves: int = 60, joint_moves: int = 8, seed: int = 5, speeds: Sequence[float] = _SPEEDS
) -> Case:
    """A case in which every term has all its forms; nothing is planted in it but the cycle and 30 ms per move."""
    rng = np.random.default_rng(seed)
    rows = _programmed(rng, moves, joint_moves, speeds)
    began = 0.0
    for row in rows:
        row["duration_s"] = f"{np.ceil((float(str(row['sim_s'])) + 0.03) / CYCLE) * CYCLE:.3f}"
        row["t_start_s"] = f"{began:.3f}"
        began += float(row["duration_s"]) + 0.2
    with tempfile.TemporaryDirectory() as folder:
        with (Path(folder) / "moves.csv").open("w", encoding="utf-8", newline="") as file:
            names = list(dict.fromkeys(name for row in rows for name in row))
            table = csv.DictWriter(file, names, restval="")
            table.writeheader()
            table.writerows(rows)
        settings = f'robot = "{ROBOT}"\ntime_resolution_s = 0.001\ntool = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]\n'
        (Path(folder) / "recording.toml").write_text(settings, encoding="utf-8")
        return case_of(read_recording(folder)).case


def _programmed(
    rng: np.random.Generator, moves: int, joint_moves: int, speeds: Sequence[float]
) -> list[dict[str, object]]:
    """Straight moves, joint moves and two waits, each from where the last one ended, with what a simulation says."""
    total, robot = moves + joint_moves, load_robot(ROBOT)
    places, angles, joints = _points(rng, total + 1)
    rows: list[dict[str, object]] = []
    for k in range(total):
        straight = k < moves
        turned = np.abs(joints[k + 1] - joints[k])
        lead = int(np.argmax(turned / robot.speeds))
        share = float(rng.choice([0.2, 0.5, 1.0]))
        way = float(np.linalg.norm(places[k + 1] - places[k])) if straight else float(turned[lead])
        top = float(rng.choice(speeds)) if straight else share * float(robot.speeds[lead])
        slow = _ACCELERATION if straight else float(robot.accelerations[lead])
        load = float(rng.choice([0.0, 6.0, 12.0]))
        row: dict[str, object] = {
            "move": k + 1,
            "type": "linear" if straight else "joint",
            "sim_s": way / top + top / slow if way >= top**2 / slow else 2 * np.sqrt(way / slow),
            "payload_kg": load,
            "payload_inertia_kg_m2": 0.03 * load,
        }
        if straight:
            row |= {"speed_mm_s": top / mm, "accel_mm_s2": slow / mm}
            row["blend_mm"] = float(rng.choice([0.0, 0.0, 5.0, 10.0, 25.0])) if k < moves - 1 else 0.0
        else:
            row["speed_pct"] = 100 * share
        for end, at in (("start", k), ("end", k + 1)):
            row |= {f"{c}_{end}_mm": v / mm for c, v in zip("xyz", places[at], strict=True)}
            row |= {f"r{c}_{end}_deg": v / deg for c, v in zip("xyz", angles[at], strict=True)}
            row |= {f"q{c}_{end}_deg": v / deg for c, v in enumerate(joints[at], 1)}
        rows.append(row)
    return [*rows, *({"move": total + k, "type": "wait", "sim_s": 0.5} for k in (1, 2))]


def _points(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places (n, 3) [m] in front of the robot, orientations (n, 3) [rad] about tool down, and their joints [rad]."""
    low, high = np.array([0.7, -0.5, 0.1]), np.array([1.25, 0.5, 0.8])
    places = rng.uniform(low, high, (count, 3))
    angles = np.array([180.0, 0.0, 0.0]) * deg + rng.uniform(-0.4, 0.4, (count, 3))
    for k in range(1, count, 3):  # short ways
        places[k] = places[k - 1] + rng.uniform(0.02, 0.08) * np.array([0.6, -0.5, 0.4])
    angles[2::5] = angles[1::5][: len(angles[2::5])]  # some moves turn nothing
    rotations = rotation_from_angles(angles)
    joints, reached = inverse(load_robot(ROBOT), places, rotations)
    assert reached.all()
    return places, angles_from_rotation(rotations), joints


# --- the page ---------------------------------------------------------------------------------------------------------

_HEAD = """\
# The physics that a simulation may leave out

Written by `python bench/physics_page.py` from `olp/physics/`, one file per term; edit the terms, not this page. How
`olp diagnose` chooses among them is in [diagnose](diagnose.md).

A term is a forward model: it changes the motion of all moves together (a slower speed also needs a shorter ramp), and
what it changes in a duration is added to what the judged simulation said. A term may have several forms, of which a
diagnosis takes at most one (limits of axes: one per axis). Its value where it does nothing is its null.

| term | what it means | told by | may look like |
|---|---|---|---|
"""
_PICTURES = """
The pictures show each effect alone in 160 straight moves (`python bench/physics_pictures.py`): a dot is a move, up is
later than simulated, over the column that orders the dots best. Where a second column parts what the first leaves, blue
dots are the lower half of it and orange ones the upper. It is what to look at in a recording of one's own.
"""
_BOUNDS = """
Bounds are those of a recording of a GP25 with everything in it (`rich_case` in `bench/physics_page.py`); those that
hang on speeds, accelerations, loads or distances of the recording are others elsewhere. Where all moves are joint
moves, rad stands for m.
"""


def page() -> str:
    """docs/physics.md."""
    case = rich_case()
    terms = [load_term(name) for name in term_names()]
    table = "".join(
        f"| [`{t.name}`](#{t.name}) | {t.summary} | {_told_by(t)} | {', '.join(f'`{c}`' for c in t.confusable)} |\n"
        for t in terms
    )
    return _HEAD + table + _PICTURES + _BOUNDS + "".join(_section(t, case) for t in terms)


def _told_by(term: Term) -> str:
    told = [("durations", isinstance(term, MoveTerm)), ("logs", isinstance(term, LogTerm))]
    return " and ".join(name for name, so in told if so)


def _section(term: Term, case: Case) -> str:
    lines = [f"\n## {term.name}\n", f"{_sentence(term.summary)} Trace: {term.does}.\n"]
    if (PAGE.parent / _picture(term)).exists():
        lines.append(f"![How much later moves are by {term.name}]({_picture(term)})\n")
    lines += _forms(term, case) if isinstance(term, MoveTerm) else []
    if isinstance(term, LogTerm):
        lines.append(f"- in logs: ${term.equation}$")  # type: ignore[attr-defined]
        lines += [_parameter(p) for p in term.parameters]  # type: ignore[attr-defined]
    return "\n".join([*lines, f"\nSource: {_sentence(term.source)}\n"])


def _picture(term: Term) -> str:
    """Seen from the page."""
    return f"images/physics/{term.name}.svg"


def _forms(term: MoveTerm, case: Case) -> Iterator[str]:
    """A list of forms with their parameters; axes of one limit share a line."""
    forms = term.forms(case)
    if not forms:
        yield f"- ${term.equation}$, what remains late beside all other terms"  # type: ignore[attr-defined]
    axes = [form.key for form in forms if form.axis >= 0]
    first = next((form for form in forms if form.axis >= 0), None)
    for form in forms:
        if form.axis >= 0 and form is not first:
            continue
        key = f"each of {', '.join(axes)}" if form.axis >= 0 else form.key
        yield f"- {key + ': ' if key else ''}${form.equation}$"
        yield from (_parameter(p) for p in form.parameters)


def _parameter(p: Parameter) -> str:
    null = "" if np.isnan(p.null) else f"; null {_number(p.null)}"
    unit = "" if p.unit == "1" else f" {p.unit}"
    return f"    - `{p.name}`, {p.meaning}: {_number(p.low)} to {_number(p.high)}{unit}{null}"


def _number(value: float) -> str:
    return "∞" if np.isinf(value) else f"{value:.3g}"


def _sentence(text: str) -> str:
    return text[0].upper() + text[1:] + "."


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
