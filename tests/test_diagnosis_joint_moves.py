"""What slows joint moves: recordings of `bench/joint_moves.py`, without the search."""

import numpy as np

from bench.joint_moves import case, write
from olp.identification.diagnosis.fitting import Noise, evaluate, fit
from olp.identification.diagnosis.judged import case_of
from olp.identification.diagnosis.model import DurationModel, ModelPart
from olp.identification.recording import read_recording
from olp.timing.physics import load_term


def test_reach_slows_joint_moves_whichever_axis_leads_them(tmp_path):
    rows, scatter = case(np.random.default_rng([1, 0]), "reach")
    write(tmp_path, rows)
    moves, noise = case_of(read_recording(tmp_path)).case, Noise(1e-4)
    term, left = load_term("reach-inertia"), {}
    for form in term.forms(moves):
        tried = [
            fit(DurationModel((ModelPart(term, form, v),)), moves, noise) for v in term.guesses(form, moves)
        ]
        left[form.key] = min(f.scale for f in tried)
    assert min(left, key=lambda key: left[key]) == "any axis"
    assert left["any axis"] < 2.0 * scatter < 0.2 * evaluate(DurationModel(), moves, noise).scale
    assert left["from a reach"] > 5.0 * left["any axis"]
