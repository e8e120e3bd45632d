"""An answer does not hang on the last bit: what is equal but for rounding is decided by a stated order."""

from pathlib import Path

import numpy as np
import pytest

from olp.identification.diagnosis import conditions
from olp.identification.diagnosis.fitting import Noise, evaluate, largest, ranks
from olp.identification.diagnosis.model import Condition, DurationModel, Statement
from olp.identification.diagnosis.search import additions, move_terms, shelf_of
from olp.identification.recorded_plan import case_of
from olp.identification.recording import read_recording

UP20 = Path(__file__).parents[1] / "samples" / "up20"
LAST_BITS = 1e-14


@pytest.fixture(scope="module")
def case():
    return case_of(read_recording(UP20)).case


def shaken(values, seed):
    return values * (1.0 + LAST_BITS * np.random.default_rng(seed).standard_normal(np.shape(values)))


def test_values_that_rounding_alone_parts_have_one_rank_and_the_first_is_the_largest():
    values = np.array([3.0, 1.0, 3.0 + 1e-15, -np.inf, 2.0, 3.0 - 1e-15])
    assert ranks(values).tolist() == [3, 1, 3, 0, 2, 3]
    assert largest(values) == 0


def test_the_last_bits_of_what_terms_do_do_not_choose_where_fits_start(case):
    shelf, noise = shelf_of(case, move_terms()), Noise(0.004)
    empty = evaluate(DurationModel(), case, noise)

    def starts(columns):
        parts = additions(shelf._replace(columns=columns), empty, case, noise, 40)
        return [(part.label, part.form.key, part.values.tolist()) for part in parts]

    as_it_is = starts(shelf.columns)
    assert all(starts(shaken(shelf.columns, seed)) == as_it_is for seed in range(8))


def test_of_conditions_that_hold_in_the_same_moves_that_of_the_known_column_is_taken(case):
    said = conditions._said(case)
    alike = {}
    for statement, mask in zip(said.statements, said.masks.T, strict=True):
        alike.setdefault(mask.tobytes(), []).append(statement)
    several = [group for group in alike.values() if len({s.column for s in group}) > 1]
    assert several
    for one in several[0]:
        better = np.where(one.mask(case), 5.0, -5.0)
        for seed in range(4):
            found = said.best(shaken(better, seed), known=Condition((Statement(one.column, above=0.0),)))[1]
            assert [s.column for s in found.statements] == [one.column]
