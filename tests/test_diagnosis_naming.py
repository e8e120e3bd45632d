"""What decides between names: sets with fewer names, and where a search for limits begins."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from olp.identification.diagnosis import evidence
from olp.identification.diagnosis.conditions import _said
from olp.identification.diagnosis.evidence import chosen, clipped_cut, matters
from olp.identification.diagnosis.findings import _as_waits, _condition, _in_quick_moves, _says, findings_of
from olp.identification.diagnosis.fitting import Noise, evaluate, fit
from olp.identification.diagnosis.folds import EACH_FIFTH, Folds, blocks, interleaved, kinds_of
from olp.identification.diagnosis.model import Condition, DurationModel, ModelPart, Statement
from olp.identification.diagnosis.naming import NamingResult, name
from olp.identification.diagnosis.result import FittedParameter
from olp.identification.diagnosis.search import WIDE, move_terms, reformed, search, shelf_of
from olp.identification.diagnosis.waits import late_moves, waiting_moves
from olp.identification.recorded_plan import case_of
from olp.identification.recording import read_recording
from olp.timing.physics import load_term
from olp.timing.physics._case import MeasuredMoves
from olp.timing.physics._limits import limits_reached
from olp.timing.physics._motion import Motion

MOVES, NOISE = 90, 0.001
ACCELERATION = 2.0


def trapezoids(way, speed, slow):
    ramp = speed / slow
    return np.where(way >= speed * ramp, way / speed + ramp, 2.0 * np.sqrt(way / slow))


def programmed(seed=3):
    rng = np.random.default_rng(seed)
    way = np.exp(rng.uniform(np.log(0.02), np.log(0.9), MOVES))
    speed = rng.choice([0.1, 0.4, 0.8, 1.2], MOVES)
    way[40], speed[40] = 2.0, 2.4  # one that is faster than all others
    return way, speed


def case(measured=None, payload=None, repeats=None, resolution=0.0):
    """Straight moves between stops at random places; measured as simulated where nothing is said."""
    way, speed = programmed()
    rng, n = np.random.default_rng(4), MOVES
    sim, nan = trapezoids(way, speed, ACCELERATION), np.full(MOVES, np.nan)
    start = rng.uniform([0.5, -0.8, 0.0], [1.4, 0.8, 1.0], (n, 3))
    towards = rng.normal(size=(n, 3))
    slow, zero = np.full(n, ACCELERATION), np.zeros(n)
    base = Motion(way, speed, slow, slow, np.full(n, np.inf), zero, zero, zero, zero, np.ones(n))
    return MeasuredMoves(
        move=np.arange(n), measured=sim if measured is None else measured, simulated=sim, base=base,
        moving=np.ones(n, bool), joint=np.zeros(n, bool), start=start,
        end=start + way[:, None] * towards / np.linalg.norm(towards, axis=1)[:, None], turn=nan,
        stop_start=np.ones(n, bool), stop_end=np.ones(n, bool), blend=zero, blend_start=zero, corner=nan,
        payload=nan if payload is None else payload, payload_inertia=nan, t_start=nan,
        cycle=np.full(n, -1), job=("",) * n, line=np.zeros(n, np.int64), resolution=resolution,
        repeats=np.arange(n) if repeats is None else repeats,
    )  # fmt: skip


def scatter(seed=7):
    return np.random.default_rng(seed).normal(0.0, NOISE, MOVES)


def test_a_search_for_a_limit_begins_below_what_the_fastest_few_reach():
    asked = np.linspace(1.0, 2.0, 101)
    limits = limits_reached(asked)
    reached = [(asked > limit).sum() for limit in limits]
    assert min(reached) <= 8
    assert max(reached) >= 40
    assert not len(limits_reached(np.zeros(5)))


def test_a_limit_that_acts_in_three_moves_is_found():
    way, speed = programmed()
    made = case()
    top = np.sort(made.base.top())[-4]
    real = case(measured=trapezoids(way, np.minimum(speed, top), ACCELERATION) + scatter())
    found = search(real, Noise(NOISE / 2), shelf_of(real, [load_term("speed-clamp")]), WIDE)[0]
    assert [part.term.name for part in found.model.parts] == ["speed-clamp"]
    assert found.model.parts[0].values[0] == pytest.approx(top, rel=0.03)


def lattice(cycle, resolution):
    way, speed = programmed()
    late = np.ceil(trapezoids(way, speed, ACCELERATION) / cycle) * cycle
    late = np.round((late + scatter() * 0.3) / resolution) * resolution
    return case(measured=late, resolution=resolution)


def _middle(form):
    """The cycle that was found [s], between the bounds of what the fit may make of it."""
    return 0.5 * (form.parameters[0].low + form.parameters[0].high)


@pytest.mark.slow
def test_a_cycle_shorter_than_two_digits_of_the_recorder_is_among_the_candidates():
    made = lattice(0.00336, 0.002)
    term = load_term("cycle-quantisation")
    cycles = [_middle(form) for form in term.forms(made)]
    assert min(abs(c - 0.00336) for c in cycles) < 1e-5
    best = search(made, Noise(0.0006), shelf_of(made, move_terms()), WIDE)[0]
    assert best.names == ("cycle-quantisation",)
    assert best.model.parts[0].values[0] == pytest.approx(0.00336, rel=1e-3)


def test_a_round_cycle_is_guessed_to_the_last_digit():
    """A timer that is a whole number of cycles takes one more with a cycle that is short by its last digit."""
    form, *_ = load_term("cycle-quantisation").forms(made := lattice(0.016, 0.0001))
    assert 0.016 in np.round(load_term("cycle-quantisation").guesses(form, made)[:, 0], 12)


@pytest.mark.parametrize("cycle", [0.024, None])
def test_a_cycle_that_scatter_hides_shows_in_what_moves_are_late_by(cycle):
    """Durations that scatter by a quarter of the cycle are on no lattice that stands out."""
    simulated, digits = case().simulated, 0.01
    real = np.ceil(simulated / cycle) * cycle if cycle else simulated + 0.012
    real = np.round((real + 5.0 * scatter(9)) / digits) * digits
    forms = load_term("cycle-quantisation").forms(case(measured=real, resolution=digits))
    assert [form.key for form in forms] == (["", "nearest"] if cycle else [])
    assert all(_middle(form) == pytest.approx(cycle, rel=1e-3) for form in forms)


def test_few_moves_tell_a_cycle_nearly_as_often_as_chance_allows_and_scatter_none():
    """74 moves that scatter by a fifth of the cycle, beside digits of a quarter of it: 10 of 20 showed it."""
    rows, digits, cycle = np.arange(74), 0.01, 0.04
    made = case().take(rows)

    def cycles(ends, seed):
        late = ends + 0.0085 * np.random.default_rng(seed).standard_normal(len(rows))
        real = replace(made, measured=np.round(late / digits) * digits, resolution=digits, derived={})
        return [_middle(form) for form in load_term("cycle-quantisation").forms(real)][:1]

    rounded = np.ceil(made.simulated / cycle) * cycle
    assert (
        sum(found == pytest.approx([cycle], rel=0.005) for found in (cycles(rounded, s) for s in range(20)))
        >= 17
    )
    assert not any(cycles(made.simulated + 0.02, seed) for seed in range(100))


@pytest.mark.parametrize("cycle", [0.04, None])
def test_moves_that_a_pallet_repeats_are_on_no_lattice_by_themselves(cycle):
    """Half of all moves take one of three times, which lie near multiples of 257 ms: that was the cycle, and what
    rounding up to 40 ms added was called a gravity."""
    rng, digits, order = np.random.default_rng(2), 0.012, np.arange(MOVES)
    sim = np.array([0.767, 0.775, 1.029, 0.0, 0.0, 0.0])[order % 6]
    sim = np.where(sim > 0.0, sim, np.round(rng.uniform(1.4, 3.1, MOVES), 3))
    real = np.ceil(sim / cycle - 1e-9) * cycle if cycle else sim + 0.02
    real = np.round((real + 0.004 * rng.standard_normal(MOVES)) / digits) * digits
    made = replace(case(measured=real, resolution=digits), simulated=sim)
    found = [_middle(form) for form in load_term("cycle-quantisation").forms(made)][:1]
    assert found == (pytest.approx([cycle], rel=2e-3) if cycle else [])


@pytest.mark.parametrize("start", [0.001, 0.009])
def test_what_is_added_before_rounding_to_a_cycle_is_found_without_a_slope(start):
    time, cycle = 0.0053, 0.008
    rng, stops = np.random.default_rng(5), np.arange(MOVES) % 2
    real = np.ceil((case().simulated + time * stops) / cycle) * cycle + 0.0003 * rng.normal(size=MOVES)
    made = replace(case(measured=real), stop_end=stops > 0, blend=np.where(stops, 0.0, 0.01))
    both = DurationModel((part("cycle-quantisation", made, cycle), part("settling", made, start)))
    found = fit(both, made, Noise(1e-4), 20).model.parts[1].values[0]
    assert found == pytest.approx(time, abs=0.0003)


def test_short_durations_alone_are_no_lattice():
    assert load_term("cycle-quantisation").forms(case(measured=case().simulated + scatter())) == ()


def part(term_name, made, *values, key=None):
    term = load_term(term_name)
    form = next(f for f in term.forms(made) if key in (None, f.key))
    return ModelPart(term, form, np.array(values, dtype=float))


@pytest.mark.parametrize("name", ["settling", "dispatch"])
def test_a_simulation_that_only_moves_has_no_fixed_time_that_could_be_shorter(name):
    """It has where it takes longer than its motion, and it may where each duration has an acceleration of its own."""
    plain = case()
    stopped = replace(plain, simulated=plain.simulated + 0.05, derived={})
    own = plain.base.with_(accelerate=plain.base.accelerate * np.linspace(0.9, 1.1, MOVES))
    read = replace(plain, base=own, derived={})
    for made, least in ((plain, -0.001), (stopped, -0.05), (read, -1.0)):
        (form,) = load_term(name).forms(made)
        assert form.parameters[0].low == pytest.approx(least, abs=1e-12)
        quick = replace(made, measured=made.simulated - 0.2, derived={})
        guess = load_term(name).guesses(form, quick).min()
        assert guess >= form.parameters[0].low
        assert guess != 0.0  # where nothing happens, a search sees nothing


def test_of_sets_that_do_nearly_as_well_the_one_with_fewer_names_is_taken():
    way, speed = programmed()
    made = case(measured=trapezoids(way, speed, 0.8 * ACCELERATION) + scatter())
    noise = Noise(NOISE / 2)
    one = evaluate(DurationModel((part("acceleration", made, 0.8 * ACCELERATION),)), made, noise)
    two = evaluate(DurationModel((*one.model.parts, part("settling", made, 0.0001))), made, noise)
    better = two._replace(bic=one.bic - 7.0)  # as a form that does not quite fit would make it
    none = evaluate(DurationModel(), made, noise)
    assert chosen([better, one, none], made, noise, 2, 5).names == ("acceleration",)


def test_both_names_stay_where_each_is_worth_it():
    way, speed = programmed()
    made = case(measured=trapezoids(way, speed, 0.8 * ACCELERATION) + 0.03 + scatter())
    noise = Noise(NOISE / 2)
    found = search(made, noise, shelf_of(made, [load_term("acceleration"), load_term("dispatch")]), WIDE)
    assert chosen(found, made, noise, 3, 20).names == ("acceleration", "dispatch")


def test_a_second_name_matters_where_without_it_clearly_more_is_left():
    """Beside a large effect a small one is little of the mean square, and still several times the scatter."""
    real = case()
    both = DurationModel((part("acceleration", real, 1.0), part("dispatch", real, 0.004, key="")))
    one = DurationModel(both.parts[:1])
    quiet = replace(real, measured=both.seconds(real) + scatter(), derived={})
    noise = Noise(NOISE / 10)
    fewer, more = (evaluate(m, quiet, noise) for m in (one, both))
    explained = np.mean((both.seconds(quiet) - quiet.simulated) ** 2)
    assert np.mean((both.seconds(quiet) - one.seconds(quiet)) ** 2) < 0.01 * explained
    assert matters(fewer, more, quiet, 0.01)
    assert not matters(more._replace(scale=1.1 * more.scale), more, quiet, 0.01)


def test_late_moves_that_all_carry_what_a_term_acts_on_are_no_waits():
    carried = np.where(np.arange(MOVES) % 11 == 0, 40.0, 0.0)
    real = case(payload=carried)
    one = part("payload", real, 0.02, key="")
    played = DurationModel((one,)).seconds(real)
    late = np.nonzero(carried > 0)[0][:5]
    measured = played + scatter()
    measured[late] += 0.02
    real = replace(real, measured=measured, derived={})
    fitted = evaluate(DurationModel((one,)), real, Noise(NOISE / 2))
    assert not late_moves(fitted, real, NOISE / 2).any()
    elsewhere = played + scatter()
    elsewhere[late + 1] += np.array([0.02, 0.031, 0.045, 0.024, 0.038])
    real = replace(real, measured=elsewhere, derived={})
    fitted = evaluate(DurationModel((one,)), real, Noise(NOISE / 2))
    assert np.nonzero(late_moves(fitted, real, NOISE / 2))[0].tolist() == (late + 1).tolist()


def test_late_moves_that_a_limit_nearly_reaches_are_no_waits():
    """A clamp that is a little too high leaves moves late whose speed it hardly touches."""
    real = case()
    one = part("speed-clamp", real, 0.78, key="")
    hardly = np.nonzero((real.base.speed == 0.8) & (real.base.top() >= 0.8))[0]
    measured = DurationModel((one,)).seconds(real) + scatter()
    measured[hardly] += 0.05 * real.base.way[hardly]
    real = replace(real, measured=measured, derived={})
    fitted = evaluate(DurationModel((one,)), real, Noise(NOISE / 2))
    residual = real.measured - DurationModel((one,)).seconds(real)
    assert (residual[hardly] > 8 * NOISE).sum() >= 3
    assert not late_moves(fitted, real, NOISE / 2).any()


def test_where_some_wait_shorter_waits_are_found_too_and_hardly_any_scatter():
    rng = np.random.default_rng(11)
    residual = rng.normal(0.0, NOISE, 600)
    waits = np.linspace(2.8, 8.0, 30) * NOISE
    residual[:30] = waits
    late = np.arange(600) < 0
    assert not waiting_moves(late, residual, NOISE, 0.0).any()
    late[18:30] = True
    waiting = waiting_moves(late, residual, NOISE, 0.0)
    assert waiting[:30].sum() >= 27
    assert waiting[30:].sum() <= 3
    far = np.where(np.arange(600) < 12, 400 * NOISE, rng.normal(0.0, NOISE, 600))
    assert waiting_moves(far > NOISE * 100, far, NOISE, 0.0).sum() == 12  # such waits are seldom so short


@pytest.mark.slow("0.9-True")
@pytest.mark.parametrize(("limit", "named"), [(1.3, False), (0.9, True)])
def test_a_limit_is_named_where_other_moves_can_confirm_it(limit, named):
    """Only one move is faster than 1.3 m/s."""
    way, speed = programmed()
    real = case(measured=trapezoids(way, np.minimum(speed, limit), ACCELERATION) + scatter())
    found = name(real, Noise(NOISE / 2), Folds("block", blocks(MOVES)), {})
    told = findings_of(found, real, NOISE)
    assert ("speed-clamp" in {finding.term for finding in told.findings}) == named


def test_groups_held_out_are_predicted_by_what_the_seen_moves_choose(monkeypatch):
    """Also where the narrow search of a fold comes to nothing."""
    made = case()
    made = case(measured=made.simulated + 0.03 + scatter())
    noise, labels = Noise(NOISE / 3), np.arange(MOVES) % 5
    monkeypatch.setattr(evidence, "found_in", lambda train, noise, shelf: fit(DurationModel(), train, noise))
    shelf = shelf_of(made, [load_term("settling")])
    for time, error in ((0.02, NOISE), (0.0, 0.03)):
        named = DurationModel((part("settling", made, time),) if time else ())
        seen = evidence.selection(made, noise, Folds("", labels), shelf, named)
        assert np.std(made.measured - seen.predicted) < 1.2 * NOISE
        assert np.sqrt(np.mean((made.measured - seen.predicted) ** 2)) == pytest.approx(error, rel=0.2)


def test_inside_a_fold_no_name_is_doubted_again_that_all_moves_showed(monkeypatch):
    """A joint limit that is unusually low had true numbers, and was nothing in a fold without two of its moves."""
    made = case()
    made = case(measured=made.simulated - 0.006 + scatter())
    noise, labels = Noise(NOISE / 3), np.arange(MOVES) % 5
    less = part("dispatch", made, -0.006)
    monkeypatch.setattr(type(less.term), "doubt", lambda *_: 1e6)
    monkeypatch.setattr(evidence, "found_in", lambda train, noise, shelf: fit(DurationModel(), train, noise))
    shelf = shelf_of(made, [load_term("dispatch")])
    seen = evidence.selection(made, noise, Folds("", labels), shelf, DurationModel((less,)))
    assert seen.sets == (frozenset({"dispatch"}),) * 5


def test_a_fold_that_holds_most_of_what_a_name_does_is_dealt_among_all():
    """Nobody could know it from the others. Repeats of a programmed move stay together, unless there are too few."""
    for kinds in (30, 15):
        programmed = np.arange(MOVES) % kinds
        made = case(repeats=programmed)
        quick = made.base.top() > 0.6
        acting = evaluate(DurationModel((part("speed-clamp", made, 0.6),)), made, Noise(NOISE / 9))
        by_speed = Folds("speed", np.where(quick, 0, 1 + np.arange(MOVES) % 4))
        dealt = evidence.folds_for(acting, (0,), made, by_speed)
        assert dealt.by == EACH_FIFTH
        where = evidence.acts(acting, (0,), made)
        assert {k for k, w in zip(dealt.labels.tolist(), where.tolist(), strict=True) if w} == set(range(5))
        for one in np.unique(programmed[where]).tolist():
            assert len(np.unique(dealt.labels[where & (programmed == one)])) == 1
        every = evaluate(DurationModel((part("dispatch", made, 0.03),)), made, Noise(NOISE / 9))
        assert evidence.folds_for(every, (0,), made, by_speed) is by_speed
    assert interleaved(np.zeros(10, dtype=int)).tolist() == [0, 1, 2, 3, 4] * 2


@pytest.mark.slow
def test_a_fold_that_holds_all_that_a_condition_leaves_out_is_dealt_among_all():
    """By the others the name acts everywhere: nobody could know its condition from them."""
    made = case()
    high = made.end[:, 2] > 0.3
    own = part("acceleration", made, 1.5)._replace(condition=Condition((Statement("z", above=0.3),)))
    slow = replace(made, measured=DurationModel((own,)).seconds(made) + scatter(), derived={})
    fitted = evaluate(DurationModel((own,)), slow, Noise(NOISE / 2))
    first = Folds("cycle", np.where(high, 1 + np.arange(MOVES) % 4, 0))
    dealt = evidence.folds_for(fitted, (0,), slow, first)
    assert dealt.by == EACH_FIFTH
    for side in (high, ~high):
        assert set(dealt.labels[side].tolist()) == set(range(5))
    found = name(slow, Noise(NOISE / 2), first, {})
    assert found.fit.names == ("acceleration",)
    unseen = slow.measured - found.selection.predicted
    assert np.sqrt(np.mean(unseen**2)) < 1.5 * NOISE
    some = Folds("cycle", np.where(high | (np.arange(MOVES) % 3 > 0), 1 + np.arange(MOVES) % 4, 0))
    assert evidence.folds_for(fitted, (0,), slow, some) is some


def test_a_law_with_more_numbers_than_programmed_moves_to_act_in_is_not_named():
    """Two numbers for one move that is always late by the same: that is a list."""
    programmed = np.arange(MOVES) % 9
    made = case(repeats=programmed)
    turned = replace(made, turn=np.where(programmed == 4, 1.0, 0.0), derived={})
    own = part("orientation-limit", turned, 1.0, 9.0, key="of its own")
    late = replace(turned, measured=DurationModel((own,)).seconds(turned) + scatter(), derived={})
    fitted = evaluate(DurationModel((own,)), late, Noise(NOISE / 2))
    assert set(programmed[evidence.acts(fitted, (0,), late)].tolist()) == {4}
    folds, shelf = Folds("", np.arange(MOVES) % 5), shelf_of(late, [load_term("orientation-limit")])
    kept, _, fallen = evidence.confirmed(fitted, late, Noise(NOISE / 2), folds, shelf)
    assert (kept.names, list(fallen)) == ((), ["orientation-limit"])
    one = part("orientation-limit", turned, 1.0, key="slows the path")
    late = replace(turned, measured=DurationModel((one,)).seconds(turned) + scatter(), derived={})
    alone = evaluate(DurationModel((one,)), late, Noise(NOISE / 2))
    assert evidence.confirmed(alone, late, Noise(NOISE / 2), folds, shelf)[0].names == ("orientation-limit",)


@pytest.mark.parametrize(
    ("rate", "ramp", "key"), [(60.0, 6.0, "of its own, in two ramps"), (0.5, 4000.0, "of its own, at once")]
)
def test_a_turn_of_which_one_number_tells_nothing_has_the_form_without_it(rate, ramp, key):
    made = case()
    turn = np.where(np.arange(MOVES) % 9 == 4, np.random.default_rng(3).uniform(0.8, 1.6, MOVES), 0.02)
    turned = replace(made, turn=turn, derived={})
    own = part("orientation-limit", turned, rate, ramp, key="of its own")
    late = replace(turned, measured=DurationModel((own,)).seconds(turned) + scatter(), derived={})
    (told,) = name(late, Noise(NOISE / 2), Folds("", np.arange(MOVES) % 5), {}).fit.model.parts
    assert (told.term.name, told.form.key) == ("orientation-limit", key)
    assert told.values == pytest.approx([ramp if "ramps" in key else rate], rel=0.02)


def test_the_form_that_explains_most_stands_in_the_place_of_one_that_promised_more():
    """A screening to first order: a limit of which all guesses are far off promised nothing, and was never tried."""
    made = case()
    turned = replace(made, turn=np.random.default_rng(3).uniform(0.1, 1.6, MOVES), derived={})
    slowed = part("orientation-limit", turned, 1.3, key="slows the path")
    late = replace(turned, measured=DurationModel((slowed,)).seconds(turned) + scatter(), derived={})
    shelf, noise = shelf_of(late, [load_term("orientation-limit")]), Noise(NOISE / 2)
    other = fit(
        DurationModel((part("orientation-limit", late, 1.0, key="of its own, at once"),)), late, noise, 20
    )
    (told,) = reformed(other, shelf, late, noise).model.parts
    assert told.form.key == "slows the path"
    assert told.values == pytest.approx([1.3], rel=0.02)


def _as_step(height, way):
    return 0.05 * (height > 1 / 3)


def _evenly(height, way):
    return 0.05 * height


def _more_or_less(height, way):
    """Of both signs, and more in longer moves: no column tells which."""
    sign = np.random.default_rng(6).choice([-1, 1], len(way))
    return 0.05 * (height > 1 / 3) * (1 + np.clip(2 * way, 0, 1) * sign)


@pytest.mark.parametrize(("law", "named"), [(_as_step, True), (_evenly, False), (_more_or_less, False)])
def test_a_law_that_is_cut_into_steps_is_not_named(law, named):
    """The best step leaves a ninth of what grows evenly from nought, with a pattern in it; or what is larger in moves
    of some kind, where no scatter is."""
    programmed = np.arange(MOVES) // (1 if law is _more_or_less else 2)
    made, folds = case(repeats=programmed), Folds("", programmed % 5)
    height = np.random.default_rng(5).permutation(np.linspace(0, 1, programmed.max() + 1))[programmed]
    made = replace(made, end=np.column_stack([made.end[:, :2], height]), derived={})
    real = replace(made, measured=made.simulated + law(height, made.base.way) + scatter(), derived={})
    step = part("settling", made, 0.03)._replace(condition=Condition((Statement("z", above=1 / 3),)))
    noise, shelf = Noise(NOISE / 2), shelf_of(real, [load_term("settling")])
    best = fit(DurationModel((step,)), real, noise, 30)
    left = real.measured - best.model.seconds(real)
    assert evidence.cut(real.residual, left, NOISE) > evidence.CUT
    kept, _, fallen = evidence.confirmed(best, real, noise, folds, shelf)
    assert (kept.names, list(fallen)) == ((("settling",), []) if named else ((), ["settling"]))
    assert evidence.patterned(best, real, noise) == (law is _evenly)


@pytest.mark.parametrize(
    ("late", "names"),
    [((0, 50, 0, 50, 50), ("payload",)), ((30, 40, 50, 60, 70), ("dispatch", "payload"))],
)
def test_names_predict_whole_groups_of_every_kind_no_worse_than_one_of_them_alone(late, names):
    """Every start point has a payload of its own, and is late for a reason of its own, or by its payload."""
    start, noise = np.arange(MOVES) % 5, Noise(NOISE / 3)
    made = case(payload=np.array([0.0, 5.0, 10.0, 15.0, 20.0])[start])
    made = replace(made, measured=made.simulated + 1e-3 * np.array(late)[start] + scatter(), derived={})
    shelf = shelf_of(made, [load_term("dispatch"), load_term("payload")])
    carried = next(part for part in shelf.parts if part.term.name == "payload")
    best = fit(DurationModel((part("dispatch", made, 0.03), carried)), made, noise, 30)
    folds, kinds = (
        Folds(EACH_FIFTH, np.arange(MOVES) // 5 % 5),
        kinds_of({"start": start}, np.arange(MOVES) < 0),
    )
    assert evidence.confirmed(best, made, noise, folds, shelf)[0].names == ("dispatch", "payload")
    assert kinds_of({"speed": start, "type": start}, np.arange(MOVES) < 0) == []
    kept, _, fallen = evidence.confirmed(best, made, noise, folds, shelf, kinds)
    assert kept.names == names
    assert set(fallen) == {"dispatch", "payload"} - set(names)
    assert all("whole groups" in why for why in fallen.values())


@pytest.mark.parametrize(
    ("together", "pattern", "names"),
    [
        (4.7, True, ("acceleration", "dispatch", "settling")),
        (1.9, True, ("acceleration",)),
        (4.7, False, ("acceleration",)),
    ],
)
def test_names_that_together_take_away_more_than_they_leave_stay(together, pattern, names, monkeypatch):
    """Of three names one takes away a little less than it leaves, and beside one of the others the third does. In the
    order of the errors without them; the likelihood would drop the third first."""
    made, noise = case(), Noise(NOISE)
    every = ("acceleration", "dispatch", "settling")
    told = {  # set and what is left out of it: gain in likelihood, error without it, cut
        (every, every[:1]): (300.0, 104.0, 6.0),
        (every, every[1:2]): (80.0, 58.0, 1.9),
        (every, every[2:]): (60.0, 62.0, 1.9),
        (("acceleration", "settling"), every[:1]): (300.0, 104.0, 6.0),
        (("acceleration", "settling"), every[2:]): (60.0, 80.0, 1.9),
        (("acceleration",), every[:1]): (700.0, 270.0, 10.0),
        (every, every[1:]): (200.0, 80.0, together),
    }

    def gain_of(fitted, parts, *_):
        gone = tuple(sorted(fitted.model.parts[k].term.name for k in parts))
        loglik, before, cut = told[fitted.names, gone]
        return evidence.Gain(loglik, 10.0, before, 40.0, cut)

    monkeypatch.setattr(evidence, "gain_of", gain_of)
    monkeypatch.setattr(evidence, "patterned", lambda *_: pattern)
    monkeypatch.setattr(evidence, "_against", lambda *_: "")
    best = DurationModel(
        (
            part("acceleration", made, ACCELERATION),
            part("dispatch", made, 0.01),
            part("settling", made, 0.01),
        )
    )
    shelf = shelf_of(made, [load_term(name) for name in every])
    kept, gains, fell = evidence.confirmed(
        evaluate(best, made, noise), made, noise, Folds("", np.arange(MOVES) % 5), shelf
    )
    assert kept.names == names
    assert len(gains) == len(names)
    assert set(fell) == set(every) - set(names)


@pytest.mark.parametrize(("many", "late"), [(1, 0.1), (2, 0.1), (8, 0.1), (1, 8.0 * NOISE)])
def test_one_move_or_two_that_are_far_off_whatever_is_named_say_nothing_of_the_name(many, late):
    """A single late move left "not explained" what all other moves showed."""
    left = scatter()
    far = np.arange(MOVES) % (MOVES // many) == 5
    assert far.sum() == many
    told = clipped_cut(left + 0.012 + late * far, left + late * far, NOISE)
    alone = clipped_cut(left[~far] + 0.012, left[~far], NOISE)
    assert told == pytest.approx(alone) if many < 3 else told < 0.2 * alone


@pytest.mark.parametrize(("late", "out"), [(4, True), (8, False)])
def test_few_moves_far_off_on_both_sides_say_nothing_of_the_name(late, out):
    """A recorder that misses stamps: six of 288 moves left "unseen moves do not confirm it" of what all others showed.
    Eight that are all late are more than that."""
    rng = np.random.default_rng(5)
    left, far = NOISE * rng.normal(size=200), np.zeros(200)
    far[rng.permutation(200)[:8]] = np.where(np.arange(8) < late, 0.1, -0.1)
    told = clipped_cut(left + 0.012 + far, left + far, NOISE)
    alone = clipped_cut((left + 0.012)[far == 0], left[far == 0], NOISE)
    assert told == pytest.approx(alone) if out else told < 0.2 * alone


def test_what_a_name_brings_is_against_the_others_at_their_best():
    """Beside a friction and a weight the ramps of the UP20 are twice as steep as without the friction."""
    recording = read_recording(Path("samples/up20"))
    up20, start = case_of(recording).case, recording.groups()["start"]
    up20, start = up20.take(np.nonzero(start != 8)[0]), start[start != 8]
    noise, folds = Noise(0.003), kinds_of({"start": start}, start < 0)[0]
    parts = [
        part("acceleration", up20, 1.47),
        part("gravity", up20, 0.54, 0.55),
        part("coulomb-friction", up20, 0.7),
    ]
    best = fit(DurationModel(tuple(parts)), up20, noise, 30)
    rest = fit(best.model.without(2), up20, noise, 30).model
    gain = evidence.gain_of(best, (2,), rest, up20, noise, folds, 0.01)
    assert gain.before == pytest.approx(evidence.held_out_error(rest, up20, noise, folds), rel=1e-6)
    hasty = evidence.gain_of(best, (2,), best.model.without(2), up20, noise, folds, 0.01)
    assert hasty.before > 1.3 * gain.before


def test_an_error_that_some_groups_show_to_be_no_smaller_is_not_worked_out_to_the_end(monkeypatch):
    made = case(measured=trapezoids(*programmed(), 0.8 * ACCELERATION) + scatter())
    model, noise = DurationModel((part("acceleration", made, ACCELERATION),)), Noise(NOISE)
    folds, fitted, fit_anew = Folds("", np.arange(MOVES) % 5), [], evidence.fit_anew
    monkeypatch.setattr(evidence, "fit_anew", lambda *given: fitted.append(1) or fit_anew(*given))
    whole = evidence.held_out_error(model, made, noise, folds)
    assert evidence.held_out_error(model, made, noise, folds, 1.001 * whole) == whole
    assert len(fitted) == 10
    assert evidence.held_out_error(model, made, noise, folds, 0.1 * whole) == np.inf
    assert len(fitted) == 11


def test_what_can_be_said_of_moves_is_worked_out_once():
    made = case()
    assert _said(made) is _said(made)
    assert _said(made, 4) is not _said(made)


@pytest.mark.parametrize(
    ("apart", "least", "gone"), [(False, 1.0, [1]), (True, 1.0, [0]), (False, 2.9, []), (False, 2.8, [1])]
)
def test_a_name_is_not_held_against_a_group_with_all_moves_that_its_condition_leaves_out(
    apart, least, gone, monkeypatch
):
    """By the other groups it acts everywhere. All groups here are predicted best without it, if clearly better."""
    made = case()
    quick = Condition((Statement("speed", above=0.4),))
    waits = part("settling", made, 0.05)._replace(condition=quick)
    best = evaluate(
        DurationModel((part("acceleration", made, 0.8 * ACCELERATION), waits)), made, Noise(NOISE)
    )
    rests = {(k,): best.model.without(k) for k in range(2)}
    errors = {
        ("acceleration", "settling"): 3.0,
        ("settling",): 2.0 if least < 2.0 else 3.0,
        ("acceleration",): least,
    }
    monkeypatch.setattr(
        evidence, "held_out_error", lambda model, *_: errors[tuple(p.term.name for p in model.parts)]
    )
    labels = np.arange(MOVES) % 5
    if apart:
        labels = np.where(quick.mask(made), 1 + np.arange(MOVES) % 4, 0)
    assert evidence._misleading(best, rests, made, Noise(NOISE), [Folds("job", labels)]) == gone


def test_inside_a_fold_names_are_held_against_unseen_moves_too(monkeypatch):
    """The seen moves end at a speed that a clamp seems to set; the unseen ones are faster."""
    way, speed = programmed()
    made = case(measured=trapezoids(way, speed, 0.8 * ACCELERATION) + scatter())
    slower, noise = part("acceleration", made, 0.8 * ACCELERATION), Noise(NOISE / 3)
    found = DurationModel((slower, part("speed-clamp", made, 1.19)))
    monkeypatch.setattr(
        evidence,
        "found_in",
        lambda train, noise, shelf: evaluate(found, train, noise)._replace(bic=-1e9),
    )
    shelf, labels = (
        shelf_of(made, [load_term("acceleration"), load_term("speed-clamp")]),
        np.arange(MOVES) % 5,
    )
    labels[40] = 0
    seen = evidence.selection(made, noise, Folds("", labels), shelf, DurationModel((slower,)))
    assert seen.sets == (frozenset({"acceleration"}),) * 5
    assert np.abs(made.measured - seen.predicted).max() < 5 * NOISE


@pytest.mark.parametrize("pattern", [0.0, 0.008, 0.02])
def test_a_law_that_leaves_a_pattern_changes_unseen_moves_by_no_more_than_seen_ones(pattern):
    """The seen moves are programmed at 0.4 m/s at most, the unseen one at 2.4 m/s over 2 m; a pattern of 8 ms is less
    than a fiftieth of what the law explains, in the mean square."""
    way, speed = programmed()
    real = trapezoids(way, np.minimum(speed, 0.35), ACCELERATION)
    made = case(measured=real + scatter() + pattern * np.sin(np.arange(MOVES) / 6.0))
    rows, noise = np.nonzero(speed <= 0.4)[0], Noise(NOISE / 3)
    seen, unseen = made.take(rows), made.take(np.array([40]))
    fitted = fit(DurationModel((part("speed-clamp", made, 0.35),)), seen, noise)
    predicted, held = evidence.foreseen(fitted, seen, unseen, noise)
    assert evidence.patterned(fitted, seen, noise) == (pattern > 0)
    if pattern < 0.01:
        assert predicted == pytest.approx(real[[40]], abs=0.05)
        assert not held.any()
        return
    change = fitted.model.seconds(seen) - seen.simulated
    most = max(change.max(), (change / seen.simulated).max() * unseen.simulated[0])
    assert predicted == pytest.approx(unseen.simulated + most)
    assert held.all()
    assert evidence.foreseen(fitted, seen, seen, noise)[0] == pytest.approx(fitted.model.seconds(seen))


def test_parts_of_a_name_under_different_conditions_are_told_with_their_own():
    made = case()
    low = Condition((Statement("z", below=0.4),))
    for conditions, where in (
        ((None, low), ("", "where z < 400 mm: ")),
        ((low, low), ("where z < 400 mm: ", "")),
    ):
        parts = [part("settling", made, 0.03)._replace(condition=c) for c in conditions]
        told = [{parts[0].form.parameters[0].name: FittedParameter(0.03, "s", 0.029, 0.031)}] * 2
        clause = "every exact stop takes 30.0 ms longer until the axes are in position"
        assert _says(list(zip(parts, told, strict=True)), made) == "; ".join(w + clause for w in where)
        assert _condition(parts) == (None if None in conditions else "z < 400 mm")


@pytest.mark.parametrize(
    ("low", "high", "says"),
    [
        (2.4, 2.6, "is 2.5 m/s^2, 125.0% of the simulated one"),
        (2.1, 3.0, "is between 2.1 and 3 m/s^2, between 105.0% and 150.0% of the simulated one"),
        (2.1, 900.0, "is at least 2.1 m/s^2, at least 105.0% of the simulated one"),
        (0.0001, 2.6, "is at most 2.6 m/s^2, at most 130.0% of the simulated one"),
        (0.0001, 900.0, "is 2.5 m/s^2, 125.0% of the simulated one, or any other size"),
    ],
)
def test_a_clause_has_the_number_only_where_its_interval_is_narrow(low, high, says):
    made = case()
    one = part("acceleration", made, 2.5)
    told = {"acceleration": FittedParameter(2.5, "m/s^2", low, high)}
    assert _says([(one, told)], made) == f"the real acceleration {says}"


@pytest.mark.parametrize(("few", "alike"), [(2, True), (12, False)])
def test_a_fixed_time_in_a_region_of_few_programmed_moves_may_as_well_be_waits(few, alike):
    programmed, noise = np.arange(MOVES) % 15, Noise(NOISE / 2)
    made = case(repeats=programmed)
    below = np.where(programmed < few, -1.0, 1.0) * (0.1 + made.start[:, 2])
    start = np.stack([*made.start.T[:2], below], axis=1)
    late = made.simulated + 0.03 * (programmed < few) + scatter()
    made = replace(made, start=start, measured=late, derived={})
    region = Condition((Statement("start z", below=0.0), Statement("x", above=-9.0)))
    time = part("dispatch", made, 0.03, key="")._replace(condition=region)
    best = fit(DurationModel((time,)), made, noise)
    named = NamingResult(best, *(None,) * 2, made, noise, *(None,) * 3, (), None, {}, {})
    assert [other.term for other in _as_waits(best, 0, named)] == (["external-wait"] if alike else [])


@pytest.mark.parametrize("alike", [True, False])
def test_a_clamp_of_moves_of_one_length_and_speed_is_whatever_acts_in_quick_moves(alike):
    """How its time goes with the way, or with the speed, nobody sees: the moves hold one number."""
    made, noise = case(), Noise(NOISE / 2)
    quick = made.base.speed > 1.0
    way, speed = np.where(quick & alike, 1.2, made.base.way), np.where(quick, 1.2, made.base.speed)
    sim = trapezoids(way, speed, ACCELERATION)
    late = sim + 0.03 * quick + scatter()
    base = made.base.with_(way=way, speed=speed)
    made = replace(made, base=base, simulated=sim, measured=late, derived={})
    best = fit(DurationModel((part("speed-clamp", made, 1.0),)), made, noise)
    shelf = shelf_of(made, move_terms())
    named = NamingResult(best, *(None,) * 2, made, noise, shelf, *(None,) * 2, (), None, {}, {})
    found = {other.term for other in _in_quick_moves(best, 0, named)}
    assert {"dispatch", "settling", "acceleration"} <= found if alike else not found


def test_where_one_name_more_gains_nothing_no_set_of_two_more_is_fitted():
    way, speed = programmed()
    made = case(measured=trapezoids(way, speed, 0.8 * ACCELERATION) + scatter())
    fits = search(made, Noise(NOISE / 3), shelf_of(made, move_terms()), WIDE)
    assert fits[0].names == ("acceleration",)
    assert max(len(fitted.model.parts) for fitted in fits) == 3
