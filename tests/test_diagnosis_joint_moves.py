"""What slows joint moves: recordings of `bench/joint_moves.py`, without the search."""

import re
from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest

from bench.fourth_author.robots import all_arms
from bench.joint_moves import case, write
from olp.identification.diagnosis.diagnose import diagnose_recording
from olp.identification.diagnosis.evidence import CUT, clipped_cut, confirmed, cut, gain_of
from olp.identification.diagnosis.findings import _nulls, _says
from olp.identification.diagnosis.fitting import Noise, evaluate, fit
from olp.identification.diagnosis.folds import Folds, interleaved
from olp.identification.diagnosis.model import DurationModel, ModelPart
from olp.identification.diagnosis.next_candidates import joined
from olp.identification.diagnosis.result import Evidence, Finding, FittedParameter
from olp.identification.diagnosis.search import (
    _promising,
    in_its_place,
    move_terms,
    of_all_axes,
    price,
    shelf_of,
    swaps,
)
from olp.identification.diagnosis.simulation_laws import SimulatedRamps
from olp.identification.recorded_plan import case_of
from olp.identification.recording import read_recording
from olp.robots import EXAMPLE_ROBOT
from olp.robots.kinematics.configuration import forward
from olp.robots.robot import load_robot
from olp.timing.physics import load_term

NOISE = Noise(1e-4)


def made(folder, law, number=0):
    """The moves of a recording, and its scatter [s]."""
    rows, scatter = case(np.random.default_rng([1, number]), law)
    write(folder, rows)
    return case_of(read_recording(folder)).case, scatter


def best_forms(name, moves):
    """The best fit with each form of a term, by the form's key."""
    term, found = load_term(name), {}
    for form in term.forms(moves):
        tried = [
            fit(DurationModel((ModelPart(term, form, v),)), moves, NOISE) for v in term.guesses(form, moves)
        ]
        found[form.key] = min(tried, key=lambda f: f.scale)
    return found


def test_reach_slows_joint_moves_whichever_axis_leads_them(tmp_path):
    moves, scatter = made(tmp_path, "reach")
    left = {key: found.scale for key, found in best_forms("reach-inertia", moves).items()}
    assert min(left, key=lambda key: left[key]) == "any axis"
    assert left["any axis"] < 2.0 * scatter < 0.2 * evaluate(DurationModel(), moves, NOISE).scale
    assert left["from a reach"] > 5.0 * left["any axis"]


def test_beside_a_simulation_that_knows_of_no_reach_all_of_it_slows_joint_moves(tmp_path):
    """An inertia that grows from the reach of some move on would need another acceleration beside it."""
    moves, _ = made(tmp_path, "reach")
    form = next(f for f in load_term("reach-inertia").forms(moves) if f.key == "any axis, all of it")
    real = DurationModel((ModelPart(load_term("reach-inertia"), form, np.array([0.5])),)).seconds(moves)
    scatter = 0.003 * np.random.default_rng(2).normal(size=len(moves))
    left = best_forms("reach-inertia", replace(moves, measured=real + scatter, derived={}))
    assert left[form.key].scale < 0.0035
    assert left["any axis"].scale > 1.5 * left[form.key].scale
    assert left[form.key].model.parts[0].values == pytest.approx([0.5], rel=0.02)


def test_each_axis_builds_up_its_own_acceleration_in_the_same_time(tmp_path):
    moves, scatter = made(tmp_path, "jerk limit", 4)
    left = {key: found.scale for key, found in best_forms("jerk", moves).items()}
    assert left["each axis"] < 2.0 * scatter < 0.5 * left[""]


@pytest.mark.parametrize("number", [3, 5])
def test_a_term_that_makes_up_for_the_form_of_another_takes_away_less_than_it_leaves(tmp_path, number):
    """Each axis has its own inertia, which the best form of the term is not."""
    moves, scatter = made(tmp_path, "reach of each axis", number)
    reach = best_forms("reach-inertia", moves)["any axis"].model.parts[0]
    added = [found.model.parts[0] for found in best_forms("acceleration", moves).values()]
    both = [fit(DurationModel((reach, part)), moves, NOISE) for part in added]
    best, folds = min(both, key=lambda f: f.bic), Folds("", interleaved(np.arange(len(moves))))
    rests = [fit(best.model.without(k), moves, NOISE).model for k in (0, 1)]
    true, false = (gain_of(best, (k,), rests[k], moves, NOISE, folds, scatter) for k in (0, 1))
    assert true.cut > 2.0 * CUT > 2.0 * false.cut
    assert false.after < false.before
    assert false.loglik > 10.0  # which is why likelihood alone would name it


def test_the_cut_is_of_what_is_beyond_the_noise():
    left, rng = np.full(50, 3.0), np.random.default_rng(1)
    assert cut(np.full(50, 5.0), left, 1.0) == pytest.approx((25.0 - 1.0) / (9.0 - 1.0))
    assert cut(np.full(50, 5.0), left, 3.0) == np.inf
    assert cut(np.full(50, 3.1), left, 1.0) == 0.0  # hardly less
    noise = rng.normal(size=400)
    odd = noise + np.where(np.arange(400) == 7, 500.0, 0.0)
    assert clipped_cut(2.0 * noise, odd - odd[7] * (np.arange(400) == 7), 0.9) > CUT
    assert clipped_cut(noise + odd, noise, 0.9) < 1.5 * cut(
        2.0 * noise, noise, 0.9
    )  # one move decides nothing


def test_motors_that_fade_make_short_moves_slower_as_far_as_they_get_quick(tmp_path):
    """Ways that are too short for both ramps, against small steps of the speed."""
    way, speeds = np.linspace(0.05, 2.0, 24), (np.arange(20000) + 0.5) / 20000
    force = np.minimum(1.0, (1.1 - speeds) / (1.1 - 0.2)) * 2.0 * 20000
    ramp, behind = np.cumsum(1 / force), np.cumsum(speeds / force)
    last = np.minimum(np.searchsorted(2 * behind, way), 19999)
    true = 2 * ramp[last] + np.maximum(way - 2 * behind[last], 0.0) / speeds[last]
    table = (
        "move,duration_s,speed_mm_s,accel_mm_s2,x_start_mm,y_start_mm,z_start_mm,x_end_mm,y_end_mm,z_end_mm\n"
    )
    rows = [
        f"{i + 1},1,{(0.5, 1)[i > 0] * 1000},2000,0,{i},0,{1000 * one},{i},0\n" for i, one in enumerate(way)
    ]
    (tmp_path / "moves.csv").write_text(table + "".join(rows))
    moves = case_of(read_recording(tmp_path)).case
    term = load_term("torque-speed")
    form = next(form for form in term.forms(moves) if form.key == "path knee")
    slower = term.act(moves.base, form, np.array([1.1, 0.2 / 1.1]), moves).duration()
    assert 8 < np.sum(last < 19999) < 20
    np.testing.assert_allclose(slower[1:], true[1:], rtol=4e-3)


def travel(limit, top, brake=None):
    """[s] from rest to rest over a way of 1, whose acceleration is at most `limit` (m,) in each of m even steps, and at
    most `brake` (m,), where that is another one, to slow down."""
    step, brake = 1.0 / len(limit), limit if brake is None else brake
    up, down = (np.concatenate([[0.0], np.cumsum(2.0 * step * one)]) for one in (limit, brake[::-1]))
    speed = np.minimum(np.sqrt(np.minimum(up, down[::-1])), top)
    return float(np.sum(2.0 * step / (speed[:-1] + speed[1:])))


def elbow_and_wrist(q):
    """(…) [m] each: how far out they are."""
    elbow = 0.25 + 1.1 * np.sin(q[..., 1])
    return elbow, elbow + 1.3 * np.cos(q[..., 2])


def of_an_arm(folder, law, scatter=0.001):
    """Joint moves of an arm of three axes that no file tells. `law` says from joints (m, 3) of a move, from what each
    axis allows (3,) and from the load [kg] what the move speeds up and slows down by (m,) each [1/s²]."""
    rng = np.random.default_rng(3)
    limits, speeds = np.radians([230.0, 205.0, 240.0]), np.radians([130.0, 120.0, 125.0])
    joints = np.radians(rng.uniform([-90, 5, -30], [90, 65, 40], (121, 3)))

    def place(q):
        out, up = elbow_and_wrist(q)[1], 0.8 + 1.1 * np.cos(q[1]) + 1.3 * np.sin(q[2])
        return [1000 * out * np.cos(q[0]), 1000 * out * np.sin(q[0]), 1000 * up, *np.degrees(q)]

    columns = [f"{c}_{end}" for end in ("start", "end") for c in "xyz"]
    names = [f"{c}_mm" for c in columns[:3]] + [f"q{k}_start_deg" for k in (1, 2, 3)]
    names += [f"{c}_mm" for c in columns[3:]] + [f"q{k}_end_deg" for k in (1, 2, 3)]
    lines = [",".join(["move,type,duration_s,sim_s,speed_pct,accel_pct,payload_kg", *names])]
    for k in range(120):
        way, load = np.abs(joints[k + 1] - joints[k]), (0.0, 20.0, 45.0)[k % 3]
        at = (np.arange(4000)[:, None] + 0.5) / 4000
        along = joints[k] + at * (joints[k + 1] - joints[k])
        slow, top = (limits / way), float((0.6 * speeds / way).min())
        up, down = law(along, slow, load)
        real = travel(up, top, down) + rng.normal(0.0, scatter)
        sim = travel(np.full(4000, slow.min()), top)
        ends = (*place(joints[k]), *place(joints[k + 1]))
        lines.append(",".join(map(str, (k + 1, "joint", real, sim, 60, 100, load, *ends))))
    (folder / "moves.csv").write_text("\n".join(lines) + "\n")
    return case_of(read_recording(folder)).case


def test_three_bodies_slow_the_joint_moves_of_an_arm_that_nobody_named(tmp_path):
    """Upper arm, forearm and load about the first axis, each at its own distance along the way."""

    def law(q, slow, load):
        elbow, wrist = elbow_and_wrist(q)
        upper_arm, forearm = 0.5 * (0.25 + elbow), elbow + (wrist - elbow) / 3.0
        heavy = 0.45 + 0.12 * upper_arm**2 + 0.2 * forearm**2 + 0.15 * wrist**2
        limit = np.minimum(slow[0] / heavy, slow[1:].min())
        return limit, limit

    forms = best_forms("reach-inertia", of_an_arm(tmp_path, law))
    left = {key: found.scale for key, found in forms.items()}
    assert left.pop("three bodies") < 0.0012
    best = left.pop("whole arm")
    assert best < 0.002 < 0.5 * min(left.values())


def test_a_heavy_forearm_is_no_pair_of_masses_at_its_ends(tmp_path):
    """A rod whose mass is spread from elbow to wrist, about the first axis."""
    rod = (np.arange(50) + 0.5) / 50

    def law(q, slow, load):
        elbow, wrist = (at[:, None] for at in elbow_and_wrist(q))
        heavy = 0.25 + 0.8 * np.mean((elbow + rod * (wrist - elbow)) ** 2, axis=1)
        limit = np.minimum(slow[0] / heavy, slow[1:].min())
        return limit, limit

    forms = best_forms("reach-inertia", of_an_arm(tmp_path, law, scatter=0.0001))
    left = {key: found.scale for key, found in forms.items()}
    assert left.pop("three bodies") < 0.0004 < 0.5 * min(left.values())


def test_a_cause_that_no_term_describes_and_one_axis_has_is_not_called_by_what_half_of_it_looks_like(
    tmp_path,
):
    """Gears of one axis have play: a move is later where the axis turns back."""
    of_an_arm(tmp_path, lambda q, slow, load: (np.full(len(q), slow.min()),) * 2)
    head, *rows = [line.split(",") for line in (tmp_path / "moves.csv").read_text().splitlines()]
    turns = np.sign(
        [float(row[head.index("q2_end_deg")]) - float(row[head.index("q2_start_deg")]) for row in rows]
    )
    back = turns != np.append(turns[0], turns[:-1])
    for row, late in zip(rows, 0.04 * back, strict=True):
        row[head.index("duration_s")] = str(float(row[head.index("duration_s")]) + late)
    (tmp_path / "moves.csv").write_text("\n".join(map(",".join, [head, *rows])) + "\n")
    found = diagnose_recording(read_recording(tmp_path)).diagnosis
    assert (found.verdict, found.findings) == ("unexplained", ())
    assert [c.column for c in found.remainder.correlates if "axis" in c.column] == ["axis 2 turning back"]


@pytest.mark.slow("0.036-True")
@pytest.mark.parametrize(("effect", "named"), [(0.008, False), (0.016, True), (0.036, True)])
def test_where_nothing_else_tells_the_noise_names_explain_more_than_they_leave(effect, named, tmp_path):
    """Points taught elsewhere look like a noise of 12 ms, and as if a small effect explained all but that."""
    of_an_arm(tmp_path, lambda q, slow, load: (np.full(len(q), slow.min()),) * 2)
    head, *rows = [line.split(",") for line in (tmp_path / "moves.csv").read_text().splitlines()]
    off = effect + np.random.default_rng(5).normal(0.0, 0.012, len(rows))
    for row, late in zip(rows, off, strict=True):
        row[head.index("duration_s")] = str(float(row[head.index("duration_s")]) + late)
    (tmp_path / "moves.csv").write_text("\n".join(map(",".join, [head, *rows])) + "\n")
    found = diagnose_recording(read_recording(tmp_path)).diagnosis
    assert (found.verdict, bool(found.findings)) == (("explained", True) if named else ("unexplained", False))
    assert named or any("not named for want of evidence" in note for note in found.notes)


@pytest.mark.parametrize("helped", [True, False])
def test_axes_that_hold_the_arm_have_less_torque_left_upwards_and_more_downwards(tmp_path, helped):
    """Each axis by what it holds of the arm and of the load; whichever has least left sets the move. A controller that
    plans by the written acceleration takes no more than that where the weight helps."""

    def law(q, slow, load):
        carried, turn = 1.0 + 0.01 * load, np.sign(q[-1] - q[0])
        # Rods keep the forearm's angle: the second axis lifts elbow and wrist alike.
        second = -(0.15 + 0.15 * carried) * np.sin(q[:, 1])
        held = np.stack([0.0 * second, second, 0.25 * carried * np.cos(q[:, 2])], axis=1)
        ramps = (np.min(slow * (1.0 - way * turn * held), axis=1) for way in (1.0, -1.0))
        return tuple(ramp if helped else np.minimum(ramp, slow.min()) for ramp in ramps)

    moves = of_an_arm(tmp_path, law)
    forms = best_forms("gravity", moves)
    best = min(forms, key=lambda key: forms[key].scale)
    assert best == ("each axis" if helped else "each axis against alone")
    assert forms[best].scale < 0.002 < 0.2 * evaluate(DurationModel(), moves, NOISE).scale
    (part,) = forms[best].model.parts
    told = dict(zip((p.name for p in part.form.parameters), part.values, strict=True))
    assert told["wrist_axis_3"] == pytest.approx(0.25, rel=0.1)
    assert told["load"] == pytest.approx(0.01, rel=0.2)
    more = joined(moves, moves.take(np.arange(3)))  # as where an experiment is designed
    assert forms[best].model.seconds(more.take(np.arange(120))) == pytest.approx(
        forms[best].model.seconds(moves)
    )


def incline_of(q):
    """Sine (m,) of the incline of the tool's way along the joints (m, 3) of `of_an_arm`."""
    out, up = elbow_and_wrist(q)[1], 0.8 + 1.1 * np.cos(q[:, 1]) + 1.3 * np.sin(q[:, 2])
    step = np.gradient(np.stack([out * np.cos(q[:, 0]), out * np.sin(q[:, 0]), up], axis=1), axis=0)
    return step[:, 2] / np.linalg.norm(step, axis=1)


@pytest.mark.slow("0.2", "0.0")
@pytest.mark.parametrize("braking", [0.0, 0.2, 0.4])
def test_joint_moves_that_lift_the_tool_start_more_slowly_whatever_their_axes_hold(tmp_path, braking):
    """A controller lowers ramps by how steeply the tool goes; its braking may be as written, or gain."""

    def law(q, slow, load):
        sine = incline_of(q)
        return slow.min() * (1.0 - 0.4 * sine), slow.min() * (1.0 + braking * sine)

    moves = of_an_arm(tmp_path, law)
    forms = best_forms("gravity", moves)
    assert min(forms, key=lambda key: forms[key].bic) == "incline of the tool"
    (part,) = forms["incline of the tool"].model.parts
    assert part.values == pytest.approx([0.4, braking], abs=0.03)
    assert forms["incline of the tool"].scale < 0.0015
    found = diagnose_recording(read_recording(tmp_path)).diagnosis
    assert ([f.term for f in found.findings], found.verdict) == (["gravity"], "explained")


def test_how_steeply_the_tool_goes_is_read_off_joints_and_points_of_an_arm_that_nobody_named(tmp_path):
    moves = of_an_arm(tmp_path, lambda q, slow, load: (np.full(len(q), slow.min()),) * 2)
    assert moves.rates.climb is not None
    head, *rows = [line.split(",") for line in (tmp_path / "moves.csv").read_text().splitlines()]
    for k in (0, 7, 50):
        told = dict(zip(head, rows[k], strict=True))
        first, last = (
            np.radians([float(told[f"q{j}_{end}_deg"]) for j in (1, 2, 3)]) for end in ("start", "end")
        )
        along = first + np.linspace(0, 1, 2001)[:, None] * (last - first)
        assert moves.rates.climb[k] == pytest.approx(incline_of(along)[::100], abs=0.02)


@pytest.mark.parametrize("points", [True, False])
def test_how_steeply_the_tool_of_a_robot_goes_is_that_of_its_flange_with_the_tool_on_it(tmp_path, points):
    """With or without tool points: the robot tells them."""
    robot = load_robot(EXAMPLE_ROBOT)
    joints = np.random.default_rng(6).uniform(-0.6, 0.6, (13, 6))

    def place(q):
        flange, rotation = forward(robot, q)
        return flange + rotation @ np.array([0.1, 0.0, 0.3])

    names = [f"q{j}_{end}_deg" for end in ("start", "end") for j in range(1, 7)]
    names += [f"{c}_{end}_mm" for end in ("start", "end") for c in "xyz"] if points else []
    lines = [",".join(["move,type,speed_pct,duration_s,sim_s", *names])]
    for k in range(12):
        ends = joints[k : k + 2]
        cells = [*np.degrees(ends).ravel(), *(1000 * place(ends).ravel() if points else ())]
        lines.append(",".join(map(str, (k, "joint", 50, 1.0, 1.0, *cells))))
    (tmp_path / "moves.csv").write_text("\n".join(lines) + "\n")
    settings = f'robot = "{EXAMPLE_ROBOT}"\ntool = [100.0, 0.0, 300.0, 0.0, 0.0, 0.0]\n'
    (tmp_path / "recording.toml").write_text(settings)
    rates = case_of(read_recording(tmp_path)).case.rates
    for k in range(12):
        step = np.gradient(
            place(joints[k] + np.linspace(0, 1, 2001)[:, None] * np.diff(joints[k : k + 2], axis=0)), axis=0
        )
        sine = (step[:, 2] / np.linalg.norm(step, axis=1))[::100]
        assert rates.climb[k] == pytest.approx(sine, abs=0.03)


def reach_of_lines(tmp_path):
    """Lines of an arm without joints in the table, slowed by what its elbow and wrist are from the first axis."""
    rng, at = np.random.default_rng(4), (np.arange(4000)[:, None] + 0.5) / 4000
    points = rng.uniform([0.9, -0.8, 0.1], [1.7, 0.8, 1.2], (121, 3))
    lines = [
        "move,duration_s,sim_s,speed_mm_s,accel_mm_s2,"
        + ",".join(f"{c}_{end}_mm" for end in ("start", "end") for c in "xyz")
    ]
    for k in range(120):
        place = points[k] + at * (points[k + 1] - points[k])
        out, up = np.hypot(place[:, 0], place[:, 1]), place[:, 2] - 0.8
        span = np.hypot(out, up)
        lean = np.arctan2(up, out) + np.arccos((1.1**2 + span**2 - 1.3**2) / (2.2 * span))
        heavy = 0.3 + 0.3 * (1.1 * np.cos(lean)) ** 2 + 0.25 * out**2
        way, speed = float(np.linalg.norm(points[k + 1] - points[k])), float(rng.choice([0.3, 0.6, 1.0]))
        real = travel(3.0 / heavy / way, speed / way) + rng.normal(0.0, 0.001)
        sim = travel(np.full(4000, 3.0 / way), speed / way)
        cells = (k + 1, real, sim, 1000 * speed, 3000, *(1000 * points[k]), *(1000 * points[k + 1]))
        lines.append(",".join(map(str, cells)))
    (tmp_path / "moves.csv").write_text("\n".join(lines) + "\n")
    return case_of(read_recording(tmp_path)).case


def test_an_arm_in_one_posture_slows_lines_by_reach_and_height_of_the_tool(tmp_path):
    moves = reach_of_lines(tmp_path)
    forms = best_forms("reach-inertia", moves)
    left = {key: found.scale for key, found in forms.items()}
    best = left.pop("any arm")
    assert best < 0.0025 < 0.3 * min(left.values())
    rows = np.arange(len(moves))[moves.end[:, 2] > 0.8]
    model = forms["any arm"].model
    assert model.seconds(moves.take(rows)) == pytest.approx(
        model.seconds(moves)[rows]
    )  # heights are those of all


def test_some_of_the_moves_take_by_every_term_what_they_take_among_all(tmp_path):
    """What a form counts from, a middle height or a scale of joint moves, is that of the moves it was fitted to."""
    moves = reach_of_lines(tmp_path)
    rows = np.arange(len(moves))[moves.end[:, 2] > 0.8]
    parts = list(shelf_of(moves, move_terms()).parts)
    parts += [part._replace(values=np.full(5, 0.1)) for part in parts if len(part.values) == 5]
    assert {part.term.name for part in parts if part.form.key == "any arm"} == {"gravity", "reach-inertia"}
    some = moves.take(rows)
    for part in parts:
        model = DurationModel((part,))
        np.testing.assert_allclose(
            model.seconds(some), model.seconds(moves)[rows], atol=1e-9, err_msg=part.label
        )


def test_a_cut_in_few_moves_is_one_where_all_others_agree():
    """Most moves are as simulated, to the digit: the typical error says nothing of what is far off."""
    without = np.where(np.arange(100) < 12, 0.05, 0.0)
    assert CUT < clipped_cut(without, 0.2 * without, 0.003) < 100.0
    assert clipped_cut(without, 0.9 * without, 0.003) < CUT
    assert clipped_cut(without, without, 0.003) == 0.0
    odd = np.where(np.arange(100) == 7, 0.5, 0.003)
    assert clipped_cut(odd, np.full(100, 0.003), 0.001) < CUT


def test_the_axes_of_one_term_are_held_against_unseen_moves_together(tmp_path):
    """Three of four axes are slower than simulated, some moves of the first are off for no reason: what one axis'
    number takes away is less than that, what all three take away is more."""
    rng, rows = np.random.default_rng(5), list[str]()
    for k, (way, share, axis) in enumerate(product((0.5, 0.9, 1.4, 2.0, 2.6), (0.4, 0.7, 1.0), range(4))):
        sim = way / (3.0 * share) + 3.0 * share / 20.0
        took = way / (3.0 * share * (0.9 if axis else 1.0)) + 3.0 * share * (0.9 if axis else 1.0) / 20.0
        off = 0.2 * rng.choice([-1.0, 1.0]) if axis == 0 and k % 5 < 2 else rng.normal(0.0, 0.002)
        ends = ",".join(f"{np.degrees(way) * (axis == k):.6f}" for k in range(4))
        rows.append(f"{k},joint,{100 * share:.0f},{took + off:.4f},{sim:.6f},0,0,0,0,{ends}")
    names = [f"q{k}_{end}_deg" for end in ("start", "end") for k in range(1, 5)]
    table = [",".join(["move", "type", "speed_pct", "duration_s", "sim_s", *names]), *rows]
    (tmp_path / "moves.csv").write_text("\n".join(table) + "\n")
    moves, term = case_of(read_recording(tmp_path)).case, load_term("speed-scale")
    slower = [ModelPart(term, form, np.array([0.9])) for form in term.forms(moves) if form.axis > 0]
    best, folds = (
        fit(DurationModel(tuple(slower)), moves, NOISE, 30),
        Folds("", interleaved(np.arange(len(moves)))),
    )
    kept, gains, _ = confirmed(best, moves, NOISE, folds, shelf_of(moves, [term]))
    assert [part.form.axis for part in kept.model.parts] == [1, 2, 3]
    alone = fit(best.model.without(0), moves, NOISE, 30).model
    assert gain_of(best, (0,), alone, moves, NOISE, folds, 0.002).cut < CUT < gains[0].cut
    every = next(form for form in term.forms(moves) if form.key == "")
    both = [slower[0], ModelPart(term, every, np.array([0.95]))]
    told = [
        {one.form.parameters[0].name: FittedParameter(v, "1", v - 0.001, v + 0.001)}
        for one, v in zip(both, (0.9, 0.95), strict=True)
    ]
    assert _says(list(zip(both, told, strict=True)), moves) == (
        "moves cruise at 95.00% of the simulated speed; "
        "beside that, where axis 2 leads, moves cruise at 90.00% of the simulated speed"
    )


@pytest.mark.parametrize(
    ("sim", "told"), [(0.5, []), (4.0, ["no speed_pct of 3 joint moves: taken as 100 %"])]
)
def test_joint_moves_without_a_speed_that_are_simulated_slower_are_told(tmp_path, sim, told):
    names = [f"q{k}_{end}_deg" for end in ("start", "end") for k in range(1, 7)]
    rows = [f"{k},joint,{sim},{sim},0,0,0,0,0,0,60,0,0,0,0,0" for k in range(3)]
    (tmp_path / "moves.csv").write_text(
        "\n".join([",".join(["move", "type", "duration_s", "sim_s", *names]), *rows]) + "\n"
    )
    (tmp_path / "recording.toml").write_text('robot = "yaskawa/gp25"\n')
    notes = case_of(read_recording(tmp_path)).notes
    assert [note.partition(", but")[0] for note in notes if "speed_pct" in note] == told


SPEEDS, RAMPS = np.array([3.0, 2.5, 4.0, 5.0]), np.array([12.0, 10.0, 16.0, 20.0])  # of the simulation's axes


def together(turned, share, speeds, ramps):
    """(n,) [s] of joint moves by (n, 4) [rad], all axes from rest to rest at the same time."""
    top = (share[:, None] * speeds / np.maximum(turned, 1e-12)).min(axis=1)
    slow = (ramps / np.maximum(turned, 1e-12)).min(axis=1)
    return np.where(top**2 <= slow, 1.0 / top + top / slow, 2.0 / np.sqrt(slow))


def slowest(turned, share, speeds, ramps):
    """(n,) [s] likewise, where each axis alone would have its own ramps: the slowest one tells how long it takes."""
    each = [
        together(turned[:, [k]], share, speeds[..., [k]], ramps[..., [k]]) for k in range(turned.shape[1])
    ]
    return np.max(each, axis=0)


def of_four_axes(folder, turned, share, speeds, ramps, scatter=0.0, law=together, rated=RAMPS, **more):
    """The moves of a recording whose axes have other `speeds` and `ramps` than simulated; `more` columns."""
    noise = np.random.default_rng(5).normal(0.0, scatter, len(turned))
    took, sim = law(turned, share, speeds, ramps) + noise, law(turned, share, SPEEDS, rated)
    names = [f"q{k}_{end}_deg" for end in ("start", "end") for k in range(1, 5)]
    table = [",".join(["move", "type", "speed_pct", "duration_s", "sim_s", *names, *more])]
    for k, way in enumerate(np.degrees(turned)):
        ends = ",".join(f"{q:.9f}" for q in (*way, *(column[k] for column in more.values())))
        table.append(f"{k},joint,{100 * share[k]:.9f},{took[k]:.9f},{sim[k]:.9f},0,0,0,0,{ends}")
    (folder / "moves.csv").write_text("\n".join(table) + "\n")
    return case_of(read_recording(folder)).case


def of_axes(name, moves, axes, value):
    term = load_term(name)
    return [ModelPart(term, form, np.array([value])) for form in term.forms(moves) if form.axis in axes]


@pytest.mark.parametrize(
    ("name", "value"),
    [("speed-scale", 0.6), ("speed-scale", 1.7), ("acceleration", 2.5), ("acceleration", 0.4)],
)
def test_another_axis_leads_where_the_first_one_is_slower_or_quicker_than_simulated(tmp_path, name, value):
    """A joint move takes as long as its slowest axis needs, whichever that is then."""
    rng = np.random.default_rng(8)
    turned = rng.uniform(0.1, 2.0, (80, 4)) * np.where(rng.random((80, 4)) < 0.3, 0.0, 1.0)
    turned[np.arange(80), np.arange(80) % 4] += 1.5
    share = rng.choice([0.3, 0.6, 1.0], 80)
    changed = np.where(np.arange(4) == 1, value, 1.0)
    speeds = SPEEDS * (changed if name == "speed-scale" else 1.0)
    ramps = RAMPS * (changed if name == "acceleration" else 1.0)
    moves = of_four_axes(tmp_path, turned, share, speeds, ramps)
    model = DurationModel(tuple(of_axes(name, moves, (1,), value)))
    np.testing.assert_allclose(model.seconds(moves), moves.measured, atol=2e-4)
    alone = np.where(moves.led(1), 1.0, 0.0)
    assert np.abs(moves.measured - moves.simulated)[alone == (value > 1)].max() > 0.05
    some = np.arange(80)[::-3].copy()
    np.testing.assert_allclose(model.seconds(moves.take(some)), model.seconds(moves)[some], atol=1e-12)
    (many,) = model.smooth_with([(0, model.parts[0])], moves)
    np.testing.assert_allclose(many, model.seconds(moves), atol=1e-12)


@pytest.mark.slow("slowest-60-32-names2")
@pytest.mark.parametrize(
    ("law", "count", "seed", "names"),
    [
        (together, 90, 31, {"limit_axis_1": 3.6, "limit_axis_2": 4.2}),
        (slowest, 90, 31, {"scale_axis_1": 0.6, "scale_axis_2": 0.6}),
        (slowest, 60, 32, {"scale": 0.6}),  # where axis number < 3
    ],
)
def test_axes_that_take_over_are_those_that_the_simulation_would_have(tmp_path, law, count, seed, names):
    """Both axes of the arm have 0.6 of their accelerations, those of the wrist all. By one law a slow ramp is that of
    every move, by the other of those whose slowest axis it then makes."""
    rng = np.random.default_rng(seed)
    turned = rng.uniform(0.1, 2.0, (count, 4)) * np.where(rng.random((count, 4)) < 0.3, 0.1, 1.0)
    rated = RAMPS * [0.5, 0.7, 1.5, 1.2]
    slow = rated * [0.6, 0.6, 1.0, 1.0]
    share = rng.choice([0.3, 0.6, 1.0], count)
    moves = of_four_axes(tmp_path, turned, share, SPEEDS, slow, 0.003, law, rated)
    assert moves.slowest is (law is slowest)
    slower = (law(turned, share, SPEEDS, slow) > law(turned, share, SPEEDS, rated) + 0.005)[moves.place]
    assert (slower & ~(moves.led(0) | moves.led(1))).sum() >= 3
    found = diagnose_recording(read_recording(tmp_path)).diagnosis
    [of] = found.findings
    assert found.verdict == "explained"
    assert found.heldout_after.rmse < 0.0032
    assert {name: number.value for name, number in of.parameters.items()} == pytest.approx(names, rel=0.02)
    assert (of.condition == "axis number < 3") is (len(names) == 1)


@pytest.mark.parametrize("simulated", [None, 0.0, 0.5])
def test_a_load_slows_the_wrist_alone_which_then_sets_the_pace_of_more_moves(tmp_path, simulated):
    """`simulated` [kg m²]: the load's inertia that the simulation knows of."""
    rng, growth = np.random.default_rng(8), 1.2
    turned = rng.uniform(0.1, 2.0, (80, 4))
    turned[np.arange(80), np.arange(80) % 4] += 0.5
    inertia = rng.choice([0.0, 0.8, 2.0], 80)
    told = {"payload_inertia_kg_m2": inertia}
    if simulated is not None:
        told["sim_payload_inertia_kg_m2"] = np.full(80, simulated)
    lighter = (1.0 + growth * (simulated or 0.0)) / (1.0 + growth * inertia)
    ramps = RAMPS * np.stack([np.ones(80)] * 3 + [lighter], axis=1)
    moves = of_four_axes(tmp_path, turned, rng.choice([0.3, 0.6, 1.0], 80), SPEEDS, ramps, 0.001, **told)
    found = best_forms("payload-inertia", moves)
    of_all = "" if simulated is None else "real over simulated"
    (led,) = (form for key, form in found.items() if key.endswith("leading axis"))
    assert led.scale < 0.0015 < 0.2 * found[of_all].scale
    assert led.model.parts[0].values == pytest.approx([growth], rel=0.02)


def one_by_one(shares):
    """Moves of one axis each, of each at every share of its speed."""
    told = list(product((0.5, 0.9, 1.4, 2.0), shares, range(4)))
    turned = np.array([[way * (axis == k) for k in range(4)] for way, _, axis in told])
    return turned, np.array([share for _, share, _ in told])


def test_all_axes_of_the_terms_that_some_have_are_found_where_each_alone_is_worth_little(tmp_path):
    """Axes are slower and accelerate more: at some speeds the one makes up for the other."""
    turned, share = one_by_one((0.1, 0.5, 0.7, 1.0))
    off = np.array([1.0, 0.9, 0.94, 0.96])
    ramps = RAMPS * np.array([1.0, 2.4, 1.7, 1.4])
    moves = of_four_axes(tmp_path, turned, share, SPEEDS * off, ramps, 0.002)
    first = of_axes("speed-scale", moves, (1,), 0.9) + of_axes("acceleration", moves, (1,), 2.0)
    shelf, best = shelf_of(moves, move_terms()), fit(DurationModel(tuple(first)), moves, NOISE, 20)
    full = of_all_axes(best, shelf, moves, NOISE)
    found = {(p.term.name, p.form.axis): float(p.values[0]) for p in full.model.parts}
    assert set(found) == set(product(("speed-scale", "acceleration"), (1, 2, 3)))
    for axis in (1, 2, 3):
        assert found["speed-scale", axis] == pytest.approx(off[axis], abs=0.01)
        assert found["acceleration", axis] == pytest.approx(ramps[axis] / RAMPS[axis], rel=0.1)


def test_where_a_name_of_an_axis_falls_those_that_stay_act_on_that_axis(tmp_path):
    turned, share = one_by_one((0.4, 0.7, 1.0))
    moves = of_four_axes(tmp_path, turned, share, SPEEDS * np.array([1.0, 0.9, 0.9, 0.9]), RAMPS, 0.002)
    shelf, slower = shelf_of(moves, move_terms()), of_axes("speed-scale", moves, (1, 2), 0.9)
    bare, (gone,) = fit(DurationModel(tuple(slower)), moves, NOISE), of_axes("acceleration", moves, (3,), 0.8)
    found = in_its_place(bare, gone, shelf, moves, NOISE, set())
    assert [(p.term.name, p.form.axis) for p in found.model.parts] == [("speed-scale", k) for k in (1, 2, 3)]
    assert in_its_place(bare, gone, shelf, moves, NOISE, {"speed-scale/3"}) is bare


def test_what_stands_in_the_place_of_a_part_is_sought_among_what_that_part_explains(tmp_path):
    """A limit that few moves reach is far out beside no part at all, and its nearest guess seemed worth nothing: it
    touches other moves, which are as simulated."""
    turned, share = one_by_one((0.1, 0.2, 0.4, 1.0))
    kept = (share < 1.0) | (turned[:, 0] > 0.6)
    turned, share = turned[kept], share[kept]
    moves = of_four_axes(tmp_path, turned, share, SPEEDS, RAMPS)
    scatter = 0.002 * np.random.default_rng(5).normal(size=len(share))
    real = together(turned, np.minimum(share, 0.4), SPEEDS, RAMPS) + scatter
    moves, noise = replace(moves, measured=real, derived={}), Noise(1e-3)
    shelf, weak = shelf_of(moves, move_terms()), load_term("torque-speed")
    knee = next(form for form in weak.forms(moves) if form.key == "axes knee")
    best = fit(DurationModel((ModelPart(weak, knee, np.array([0.41, 0.95])),)), moves, noise, 30)
    near = ("joint-speed-limit", 0, round(0.97 * 0.4 * SPEEDS[0], 9))
    for whole, found in ((None, False), (best, True)):
        ranked = _promising(shelf, evaluate(DurationModel(), moves, noise), moves, noise, whole)[:4]
        told = {(part.term.name, part.form.axis, round(float(part.values[0]), 9)) for part in ranked}
        assert (near in told) == found
    first = swaps(best, 0, shelf, moves, noise)[0]
    assert first.names == ("joint-speed-limit",)
    assert price(first) < price(best)


def test_what_a_fit_tries_beside_a_model_is_what_the_model_would_say_there(tmp_path):
    """Parts that stay are kept, moves of all trials are timed in one go, and axes that take over are looked up."""
    moves, _ = made(tmp_path, "jerk limit", 4)
    assert moves.rivals is not None
    moves = replace(moves, measured=0.012 * np.ceil(moves.measured / 0.012), derived={})
    parts = shelf_of(moves, move_terms()).parts
    wanted = {"joint-acceleration-limit": 1, "settling": -1, "cycle-quantisation": -1}
    model = DurationModel(
        tuple(next(p for p in parts if (p.term.name, p.form.axis) == one) for one in wanted.items())
    )
    changes = [(k, part._replace(values=1.1 * part.values)) for k, part in enumerate(model.parts)]
    for (k, part), told in zip(changes, model.both_with(changes, moves), strict=True):
        alone = DurationModel((*model.parts[:k], part, *model.parts[k + 1 :])).both(moves)
        np.testing.assert_allclose(told, alone, rtol=1e-14)
        assert np.abs(told[0] - told[1]).max() > 0.0


def test_what_takes_force_from_an_axis_takes_it_from_the_drive_that_limits_it_too(tmp_path):
    """A drive that gives 40 % of the torque gives it to whatever the arm weighs just then: the limit of an axis, told
    of a light arm, is no cap on what a heavy one has left."""
    rng = np.random.default_rng(11)
    turned, share, left = rng.uniform(0.1, 2.0, (60, 4)), rng.choice([0.3, 0.6, 1.0], 60), 0.7
    weak = np.where(np.arange(4) == 1, 0.4, 1.0) * RAMPS
    moves = of_four_axes(tmp_path, turned, share, SPEEDS, left * weak)
    (limit,) = of_axes("joint-acceleration-limit", moves, (1,), 0.4 * RAMPS[1])
    (heavy,) = of_axes("acceleration", moves, (-1,), left)
    for parts in ((limit, heavy), (heavy, limit)):
        np.testing.assert_allclose(DurationModel(parts).seconds(moves), moves.measured, atol=2e-6)


@pytest.mark.parametrize("name", ["joint-speed-limit", "joint-acceleration-limit"])
def test_a_limit_whose_interval_reaches_what_no_move_asks_for_may_do_nothing(tmp_path, name):
    """An unlisted cause that made axis 5 late was called a limit of "between 14 and 488 deg/s"."""
    rng = np.random.default_rng(6)
    turned = rng.uniform(0.1, 2.0, (40, 4))
    moves = of_four_axes(tmp_path, turned, rng.choice([0.3, 0.6, 1.0], 40), SPEEDS, RAMPS)
    part = of_axes(name, moves, (1,), 1.0)[0]
    nulls = _nulls([part])
    (parameter,) = part.form.parameters
    idle = DurationModel((part._replace(values=np.array([nulls[parameter.name]])),))
    np.testing.assert_allclose(idle.seconds(moves), moves.simulated, atol=1e-9)
    evidence = Evidence(9.0, 0.001, 0.1, 0.05)
    for high, holds in ((2.0 * parameter.high, True), (0.9 * parameter.high, False)):
        fitted = {parameter.name: FittedParameter(1.0, parameter.unit, 0.5, high)}
        assert Finding(name, "", "", fitted, (), {}, evidence, nulls=nulls).holds_null == holds


def test_an_axis_may_turn_far_slower_than_its_drive_could(tmp_path):
    """A controller may be set to a tenth of the rated speed; what no limit was thought to be was called another one."""
    rng = np.random.default_rng(7)
    turned, share = rng.uniform(0.1, 2.0, (60, 4)), rng.choice([0.3, 0.6, 1.0], (60, 1))
    limited = np.where(np.arange(4) == 1, 0.1 / share, 1.0) * SPEEDS
    moves = of_four_axes(tmp_path, turned, share[:, 0], limited, RAMPS, 0.001)
    (part,) = of_axes("joint-speed-limit", moves, (1,), 1.0)
    assert part.form.parameters[0].name == "limit_axis_2"
    assert (
        part.term.doubt(part.form, np.array([0.2 * SPEEDS[1]]))
        > 0.0
        == part.term.doubt(part.form, SPEEDS[1:2])
    )
    tried = [part._replace(values=values) for values in part.term.guesses(part.form, moves)]
    best = min((fit(DurationModel((one,)), moves, NOISE) for one in tried), key=lambda found: found.scale)
    assert best.model.parts[0].values == pytest.approx([0.1 * SPEEDS[1]], rel=0.01)


def write_joint_moves(folder, robot, joints, share, blend, sim):
    """A recording of one joint move after the other, `blend` (n,) [m] rounded, that take the simulated times."""
    names = [f"q{k}_{end}_deg" for end in ("start", "end") for k in range(1, 7)]
    table = [",".join(["move", "type", "speed_pct", "blend_mm", "duration_s", "sim_s", *names])]
    for k, (start, end) in enumerate(pairwise(np.degrees(joints).tolist())):
        row = (k, "joint", 100 * share[k], 1000 * blend[k], sim[k], round(sim[k], 4), *start, *end)
        table.append(",".join(map(str, row)))
    (folder / "moves.csv").write_text("\n".join(table) + "\n")
    (folder / "arm.toml").write_text(robot)
    (folder / "recording.toml").write_text('robot = "arm.toml"\n')


@pytest.mark.parametrize("synchronous", [True, False])
def test_joint_moves_of_a_simulation_with_jerk_tell_a_share_of_the_robots_accelerations(
    tmp_path, synchronous
):
    """Without it each move had an acceleration of its own, and what slows them all was called by several names."""
    arm, rng = all_arms()[2], np.random.default_rng(9)
    joints = rng.uniform(-0.3, 0.3, (61, 6)) * np.array([3.0, 1.0, 1.0, 1.0, 1.0, 2.0])
    turned, share = np.abs(np.diff(joints, axis=0)), rng.choice([0.1, 0.3, 1.0], 60)
    lead, at = np.argmax(turned / arm.speeds, axis=1), np.arange(60)
    way, slow = turned[at, lead], arm.accelerations[lead]
    if synchronous:
        slow = (arm.accelerations / turned).min(axis=1) * way
    sim = SimulatedRamps(build=0.08, stop=0.05).seconds(way, share * arm.speeds[lead], 0.5 * slow)
    write_joint_moves(tmp_path, arm.toml(), joints, share, np.zeros(60), sim)
    making = case_of(read_recording(tmp_path))
    assert any("builds up accelerations" in note and "at each stop" in note for note in making.notes)
    assert making.case.base.build == pytest.approx(0.08, abs=5e-4)
    assert making.case.base.added == pytest.approx(0.05, abs=5e-4)
    assert np.quantile(np.abs(making.case.base.accelerate / (0.5 * slow) - 1.0), 0.8) < 0.02


def test_joint_moves_of_a_simulation_that_stops_at_rounded_corners_take_what_a_stop_does(tmp_path):
    """No joint move goes from stop to stop: what each takes beside its ramps was told, and was in no move's time."""
    rng = np.random.default_rng(6)
    joints, share = np.cumsum(rng.uniform(-1.0, 1.0, (61, 4)), axis=0), rng.choice([0.3, 0.6, 1.0], 60)
    sim = together(np.abs(np.diff(joints, axis=0)), share, SPEEDS, RAMPS) + 0.05
    names = [f"q{k}_{end}_deg" for end in ("start", "end") for k in range(1, 5)]
    table = [",".join(["move", "type", "speed_pct", "blend_mm", "duration_s", "sim_s", *names])]
    for k, (start, end) in enumerate(pairwise(np.degrees(joints).tolist())):
        table.append(",".join(map(str, (k, "joint", 100 * share[k], 20.0, sim[k], sim[k], *start, *end))))
    (tmp_path / "moves.csv").write_text("\n".join(table) + "\n")
    case = case_of(read_recording(tmp_path)).case
    assert not (case.stop_start & case.stop_end).any()
    np.testing.assert_allclose(case.base.duration(), case.simulated, atol=1e-3)


def swinging(rng, count=60):
    """Joints (count + 1, 6) [rad] of an arm that swings, shares of rated speeds, and whether moves end in a stop."""
    joints = rng.uniform(-0.3, 0.3, (count + 1, 6)) * np.array([3.0, 1.0, 1.0, 1.0, 1.0, 2.0])
    return joints, rng.choice([0.1, 0.3, 1.0], count), np.arange(count) % 4 > 0


def leading(arm, joints):
    """Way [rad] of the axis that takes longest at rated speeds, its number, and its acceleration [rad/s^2]."""
    turned = np.abs(np.diff(joints, axis=0))
    lead, at = np.argmax(turned / arm.speeds, axis=1), np.arange(len(turned))
    return turned[at, lead], lead, arm.accelerations[lead]


def test_joint_moves_are_rounded_over_the_share_of_their_way_that_the_tool_goes_in_the_rounding(tmp_path):
    """A zone of millimetres is a part of the tool's path, whatever the leading axis turns there."""
    arm, rng = all_arms()[2], np.random.default_rng(9)
    joints, share, stops = swinging(rng)
    way, lead, slow = leading(arm, joints)
    blend, speed = np.where(stops, 0.0, 0.03), share * arm.speeds[lead]
    fine = joints[:-1, None] + np.linspace(0.0, 1.0, 400)[:, None] * np.diff(joints, axis=0)[:, None]
    places = arm.poses(fine.reshape(-1, 6))[0].reshape(60, 400, 3)
    tool = np.linalg.norm(np.diff(places, axis=1), axis=2).sum(axis=1)
    shorter = np.minimum(tool, np.append(tool[1:], np.inf))
    fast, left = np.minimum(speed, np.sqrt(way * slow)), np.minimum(blend, 0.5 * shorter) / tool * way
    brake = fast**2 / (2.0 * slow)
    late = np.where(left < brake, np.sqrt(2.0 * left / slow), fast / slow + (left - brake) / fast)
    sim = SimulatedRamps().seconds(way, speed, slow) - 0.5 * np.where(stops, 0.0, late)
    write_joint_moves(tmp_path, arm.toml(), joints, share, blend, sim)
    base = case_of(read_recording(tmp_path)).case.base
    assert np.abs(base.duration() - sim)[~stops].mean() < 1e-3


def test_a_simulation_that_stops_at_corners_is_told_beside_ramps_that_build_up(tmp_path):
    """Of a robot of which only speeds are known, by times of whole milliseconds: most moves have one speed, and of
    these any law would do. The first axis leads rounded moves alone."""
    arm, rng = all_arms()[2], np.random.default_rng(9)
    joints, share, stops = swinging(rng)
    share = np.where(rng.random(60) < 0.2, 0.1, 0.3)
    way, lead, slow = leading(arm, joints)
    stops |= lead > 0
    sim = np.round(SimulatedRamps(build=0.04).seconds(way, share * arm.speeds[lead], slow), 3)
    robot = re.sub(r", acceleration_deg_s2 = [\d.]+|^acceleration = .*$", "", arm.toml(), flags=re.MULTILINE)
    write_joint_moves(tmp_path, robot, joints, share, np.where(stops, 0.0, 0.03), sim)
    base = case_of(read_recording(tmp_path)).case.base
    assert np.abs(base.duration() - sim).mean() < 1e-3
    assert base.law == "stop"
    assert base.build == pytest.approx(0.04, abs=2e-3)


def test_axes_that_lead_few_joint_moves_have_accelerations_of_their_own(tmp_path):
    """One acceleration did for nine of ten moves, and the others were up to 0.7 s longer than simulated."""
    arm, rng = all_arms()[2], np.random.default_rng(9)
    joints, share, _ = swinging(rng, 80)
    joints[:, 1:] *= 0.05
    joints[13::35, 5] += 2.5
    way, lead, _ = leading(arm, joints)
    assert 0.0 < np.mean(lead != 0) < 0.1
    slow = np.where(lead == 0, 6.0, 24.0)
    sim = np.round(SimulatedRamps(build=0.04).seconds(way, share * arm.speeds[lead], slow), 3)
    robot = re.sub(r", acceleration_deg_s2 = [\d.]+|^acceleration = .*$", "", arm.toml(), flags=re.MULTILINE)
    write_joint_moves(tmp_path, robot, joints, share, np.zeros(80), sim)
    base = case_of(read_recording(tmp_path)).case.base
    assert np.abs(base.duration() - sim).max() < 2e-3
