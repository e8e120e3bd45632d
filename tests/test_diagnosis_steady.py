"""An answer does not hang on the last bit: what is equal but for rounding is decided by a stated order."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from olp.identification.diagnosis import conditions, fitting
from olp.identification.diagnosis.fitting import Noise, evaluate, fit, largest, ranks, whiten
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


@pytest.mark.parametrize("order", [-0.49, -0.3, 0.5])
def test_whitened_residuals_have_variance_one_and_nothing_in_common(case, order):
    count, apart = len(case), np.abs(np.subtract.outer(range(len(case)), range(len(case))))
    parted = count // 2  # from here on the moves do not follow the ones before
    moves = replace(case, place=np.arange(count) + (np.arange(count) >= parted))
    scatter = np.where(apart < 2, np.where(apart, order, 1.0), 0.0) if order < 0 else order**apart
    scatter[:parted, parted:] = scatter[parted:, :parted] = 0.0
    rows = whiten(np.eye(count), Noise(1e-4, order), moves)
    np.testing.assert_allclose(rows @ scatter @ rows.T, np.eye(count), atol=1e-12)
    np.testing.assert_allclose(whiten(case.measured, Noise(1e-4, order), moves), rows @ case.measured)


def test_a_fit_that_gets_nowhere_near_what_is_asked_is_given_up_and_another_is_not_touched(case, monkeypatch):
    noise, asked = Noise(0.004), []
    model = DurationModel(
        tuple(one for one in shelf_of(case, move_terms()).parts if one.term.name == "gravity")[:1]
    )
    whole = fit(model, replace(case), noise, 20)
    start = evaluate(model, case, noise)
    assert whole.bic < start.bic - 1.0
    slopes = fitting._slopes
    monkeypatch.setattr(fitting, "_slopes", lambda *args: asked.append(1) or slopes(*args))

    def steps_of(below):
        asked.clear()
        found = fit(model, replace(case), noise, 20, below=below)
        return len(asked), found

    full, same = steps_of(whole.bic + 1.0)
    few, given_up = steps_of(whole.bic - 1e6)
    assert same.bic == whole.bic < given_up.bic
    assert few == 1 < full
