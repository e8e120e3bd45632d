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
    noise, asked, slopes = Noise(0.004), [], fitting._slopes
    monkeypatch.setattr(fitting, "_slopes", lambda *args: asked.append(1) or slopes(*args))
    parts = [part for part in shelf_of(case, move_terms()).parts if part.form.key == "both ramps"]
    whole = fit(DurationModel((parts[0],)), replace(case), noise, 20)

    def steps_below(least):
        asked.clear()
        found = fit(DurationModel((parts[0],)), replace(case), noise, 20, below=least)
        return len(asked), found.bic

    full, same = steps_below(whole.bic + 1.0)
    few, given_up = steps_below(whole.bic - 100.0)
    assert same == whole.bic < given_up
    assert few < full


def test_a_fit_that_closes_in_is_not_given_up(case):
    """Far from the best values the log-likelihood hardly grows, and the faster the nearer a fit comes."""
    parts = [part for part in shelf_of(case, move_terms()).parts if part.term.name == "acceleration"]
    real = DurationModel((parts[0]._replace(values=np.array([0.25])),)).seconds(case)
    scatter = 1e-5 * np.random.default_rng(3).standard_normal(len(case))
    moves, start = (
        replace(case, measured=real + scatter),
        DurationModel((parts[0]._replace(values=np.array([1.6])),)),
    )
    whole = fit(start, replace(moves), Noise(1e-6), 20)
    first = fit(start, replace(moves), Noise(1e-6), 1)
    assert first.bic - whole.bic > 2.0 * 20 * (evaluate(start, moves, Noise(1e-6)).bic - first.bic)
    assert fit(start, replace(moves), Noise(1e-6), 20, below=whole.bic + 1.0).bic == whole.bic
