"""The noise floor: what scatters, not what has a pattern; and which of the two remains."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from olp.contracts.terms import rich_case
from olp.identification.diagnosis.model import DurationModel
from olp.identification.diagnosis.naming import _order
from olp.identification.diagnosis.residuals import rank_correlation
from olp.identification.diagnosis.scatter import (
    DIGITS,
    NEIGHBOURS,
    REMAINS,
    REPEATS,
    beyond_digits,
    neighbours,
    scatter_of,
)

SIGMA = 0.001


class Moves(SimpleNamespace):
    def __len__(self):
        return len(self.start)

    def once(self, _name, make):
        return make()


def moves(count=150, repeats=1, seed=3):
    """Moves between random points; every one `repeats` times, cycle by cycle."""
    rng = np.random.default_rng(seed)
    start, end = (np.tile(rng.uniform(-1, 1, (count, 3)), (repeats, 1)) for _ in range(2))
    way = np.linalg.norm(end - start, axis=1)
    speed = np.tile(rng.choice([0.1, 0.2, 0.5], count), repeats)
    case = Moves(
        start=start,
        end=end,
        base=SimpleNamespace(way=way, speed=speed),
        moving=np.ones(count * repeats, bool),
        repeats=np.tile(np.arange(count), repeats),
        resolution=0.0,
    )
    return case, rng


PATTERNS = {
    "a side": lambda case: np.where(case.end[:, 1] > case.start[:, 1], 0.006, -0.006),
    "a drift": lambda case: 0.01 * np.arange(len(case)) / len(case),
    "a step": lambda case: np.where(np.arange(len(case)) > len(case) / 2, 0.008, 0.0),
    "lengths": lambda case: 0.01 * np.exp(-(((case.base.way - 1) / 0.3) ** 2)),
}


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize("repeats", [1, 4])
def test_a_pattern_is_not_taken_for_noise(pattern, repeats):
    case, rng = moves(repeats=repeats)
    left = PATTERNS[pattern](case) + SIGMA * rng.normal(size=len(case))
    found = scatter_of(left, case, 1e-5, True)
    assert found.value == pytest.approx(SIGMA, rel=0.6)
    assert found.source == (REPEATS if repeats > 1 else NEIGHBOURS)
    assert left.std() > 1.8 * SIGMA


def test_what_alternates_from_move_to_move_is_neither_the_scatter_of_repeats_nor_shared_stamps():
    """Two tasks of a controller take turns: repeats of a cycle with an odd number of moves meet either."""
    case, rng = moves(count=51, repeats=4)
    turns = 0.006 * (-1.0) ** np.arange(len(case))
    found = scatter_of(turns + SIGMA * rng.normal(size=len(case)), case, 1e-5, True)
    assert found.source == REPEATS
    assert found.value == pytest.approx(SIGMA, rel=0.2)
    rich = rich_case(moves=120, joint_moves=0, seed=1)
    events = 0.006 * rng.normal(size=len(rich) + 1)
    named = SimpleNamespace(model=DurationModel())
    for off, alternates in ((0.006 * (-1.0) ** np.arange(len(rich)), True), (np.diff(events), False)):
        order = _order(named, replace(rich, measured=rich.simulated + off, derived={}))
        assert (order == 0.0) is alternates
        assert alternates or order < -0.3


@pytest.mark.parametrize("repeats", [1, 4])
def test_plain_scatter_is_what_it_is(repeats):
    for seed in range(5):
        case, rng = moves(repeats=repeats, seed=seed)
        found = scatter_of(SIGMA * rng.normal(size=len(case)), case, 1e-5, False)
        assert found.value == pytest.approx(SIGMA, rel=0.15)
        assert found.source == REMAINS


def test_a_dozen_repeats_of_one_move_do_not_outvote_all_others():
    """Ten values scatter by a quarter of their scatter: a floor from them alone calls a whole law a part of it."""
    found = []
    for seed in range(20):
        case, rng = moves(seed=seed)
        case.repeats[::14] = 0
        found.append(scatter_of(SIGMA * rng.normal(size=len(case)), case, 1e-5, False).value)
    assert found == pytest.approx([SIGMA] * 20, rel=0.2)


def test_repeats_that_scatter_less_than_what_remains_are_the_floor():
    case, rng = moves(repeats=4)
    left = np.tile(5 * SIGMA * rng.normal(size=150), 4) + SIGMA * rng.normal(size=600)
    found = scatter_of(left, case, 1e-5, False)
    assert found.value == pytest.approx(SIGMA, rel=0.1)
    assert found.source == REPEATS


def test_few_repeats_of_a_heavy_tailed_scatter_are_no_smaller_scatter():
    """Variances of heavy tails differ by more than Fisher's test expects of normal values."""
    case, _ = moves(210)
    case.repeats[:72] = np.arange(72) % 4 + 1000
    left = SIGMA * np.random.default_rng(990).standard_t(2.5, size=len(case))
    assert scatter_of(left, case, 1e-5, False).source == REMAINS


def test_the_floor_is_never_below_the_clocks_digits():
    case, _ = moves()
    assert scatter_of(np.zeros(len(case)), case, 2e-4, False) == (2e-4, DIGITS)


def test_what_lies_in_two_heaps_is_no_scatter_but_an_effect_that_some_moves_have():
    """Gears have play: every second move is later by 40 times what moves scatter by. An even scatter is one heap."""
    case, rng = moves()
    late = 0.04 * rng.choice([0.0, 1.0], len(case))
    found = scatter_of(late + SIGMA * rng.normal(size=len(case)), case, 1e-5, False)
    assert found.source == REMAINS
    assert found.value == pytest.approx(SIGMA, rel=0.2)
    even = rng.uniform(-1.0, 1.0, len(case))
    assert scatter_of(even, case, 1e-5, False).value == pytest.approx(even.std(), rel=0.05)
    case.resolution = 0.04  # two neighbouring digits of a clock
    assert scatter_of(late, case, 1e-5, False).value == pytest.approx(0.02, rel=0.5)


def test_no_move_is_its_own_neighbour_nor_are_its_repeats():
    case, _ = moves(60, 3)
    for near in neighbours(case).values():
        assert (near >= 0).all()
        assert (case.repeats[near] != case.repeats).all()


def test_what_depends_on_where_moves_end_is_a_pattern():
    case, rng = moves(130)
    waves = 0.03 * np.sin(3 * np.arctan2(case.end[:, 1], case.end[:, 0]))
    left = waves + SIGMA * rng.normal(size=len(case))
    assert rank_correlation(left, left[neighbours(case)["end"]]) > 0.6
    assert scatter_of(left, case, 1e-5, True).value < 0.7 * left.std()


@pytest.mark.parametrize("structured", [False, True])
def test_repeats_that_are_mostly_equal_in_the_digits_of_the_clock_do_not_hide_the_scatter(structured):
    """A tick of 10 ms and a scatter of 3: most values are the same, the others a whole tick away."""
    case, rng = moves(repeats=4)
    case.resolution = 0.01
    left = np.round(0.003 * rng.normal(size=len(case)) / case.resolution) * case.resolution
    assert np.median(np.abs(left)) == 0.0
    found = scatter_of(left, case, 1e-5, structured)
    assert found.value == pytest.approx(left.std(), rel=0.15)


def is_beyond_digits(left, case, order=0.0):
    """Of durations that are `left` [s] longer than the simulated ones."""
    case.measured = case.simulated + left
    return beyond_digits(left, case, order)


def test_rounding_that_repeats_give_again_is_not_beyond_the_digits():
    """Repeats are rounded by the same: their residuals go together, and it is the clock's doing."""
    larger = []
    for seed in range(40):
        case, rng = moves(20, 8, seed)
        case.resolution, case.simulated = 0.01, np.tile(rng.uniform(1.0, 3.0, 20), 8)
        left = np.round(case.simulated, 2) - case.simulated
        larger.append(np.sqrt(np.mean(left**2)) > 0.01 / np.sqrt(12.0))
        assert not is_beyond_digits(left, case)
        assert is_beyond_digits(left + np.where(case.repeats < 10, 0.006, -0.006), case)
    assert np.mean(larger) > 0.3  # than the mean square of rounding, by chance
    case.resolution = 0.0
    assert is_beyond_digits(left, case)


def test_rounding_of_moves_that_take_one_time_at_many_places_is_not_beyond_the_digits():
    """Lines to the places of a pallet are no repeats, and are rounded as if they were: few durations are foretold."""
    for seed in range(40):
        case, rng = moves(80, 1, seed)
        case.resolution, case.simulated = 0.01, rng.choice(rng.uniform(1.0, 3.0, 4), 80)
        left = np.round(case.simulated, 2) - case.simulated
        assert not is_beyond_digits(left, case)
        assert is_beyond_digits(
            left + np.where(case.simulated < np.median(case.simulated), 0.015, -0.015), case
        )


def test_stamps_on_a_grid_leave_two_roundings_in_a_duration_and_these_are_not_beyond_the_digits():
    """A cycle of nearly the same length moves along the grid: what its stamps lose has a period, by rounding alone."""
    by_one = []
    for seed in range(40):
        case, rng = moves(20, 8, seed)
        case.resolution, case.simulated = 0.01, np.tile(rng.uniform(1.0, 3.0, 20), 8)
        ends = rng.uniform(0.0, 0.01) + np.concatenate([[0.0], np.cumsum(case.simulated)])
        left = np.diff(np.round(ends, 2)) - case.simulated
        order = float(left[1:] @ left[:-1] / (left @ left))
        by_one.append(is_beyond_digits(left, case))
        assert not is_beyond_digits(left, case, order)
        more = left + np.where(case.repeats < 10, 0.006, -0.006)
        assert is_beyond_digits(more, case, float(more[1:] @ more[:-1] / (more @ more)))
    assert np.mean(by_one) > 0.5
