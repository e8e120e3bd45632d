"""What slows joint moves: recordings of `bench/joint_moves.py`, without the search."""

import numpy as np
import pytest

from bench.joint_moves import case, write
from olp.identification.diagnosis.evidence import CUT, clipped_cut, cut, gain_of
from olp.identification.diagnosis.fitting import Noise, evaluate, fit
from olp.identification.diagnosis.folds import Folds, interleaved
from olp.identification.diagnosis.model import DurationModel, ModelPart
from olp.identification.recorded_plan import case_of
from olp.identification.recording import read_recording
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
    true, false = (gain_of(best, k, rests[k], moves, NOISE, folds, scatter) for k in (0, 1))
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
