"""What holds for every term and every form of it, whatever it is; found by listing, so that a new one is tested too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.physics_page import DETAILS, PAGE, all_details, page
from olp.contracts.terms import CYCLE, rich_case
from olp.core import compiled_loops
from olp.identification.diagnosis.fitting import Noise, fit
from olp.identification.diagnosis.model import Condition, DurationModel, ModelPart, Statement
from olp.timing.physics import MoveTerm, _limits, _motion, _ramps, load_term, term_names

CONTRACT = term_names()

CASE = rich_case()
LADEN = replace(CASE, payload=CASE.payload + 2.0, derived={})  # no move without a load
FORMS = [
    (term, form, case)
    for case in (CASE, LADEN)
    for term in map(load_term, term_names())
    if isinstance(term, MoveTerm) and (case is CASE or term.name == "payload")
    for form in term.forms(case)
]
IDS = [f"{term.name} {form.key}".strip() + ("" if case is CASE else ", laden") for term, form, case in FORMS]
ROUNDED = (CASE.base.round_start > 0) | (CASE.base.round_end > 0)
STRAIGHT = CASE.moving & ~CASE.joint
COULOMB = load_term("coulomb-friction").forms(CASE)[0]
EVERYTHING = np.ones(len(CASE), dtype=bool)
WRIST = CASE.rates is not None and (np.abs(CASE.rates.path[:, :, 3:]).max(axis=(1, 2)) > 1e-9)


def seconds(term, form, values, case=CASE):
    """(n,) [s] without the jumps of rounding to a cycle."""
    return DurationModel((ModelPart(term, form, np.asarray(values, dtype=float)),)).smooth(case)


def plain(case=CASE):
    return DurationModel().smooth(case)


def nulls(form):
    """Values at which a form does nothing; a huge one stands for infinity, none of the corner for a corner's share."""
    return [0.0 if np.isnan(p.null) else 1e12 if np.isinf(p.null) else p.null for p in form.parameters]


def strong(term, form, case):
    """The guess that does most."""
    return max(
        term.guesses(form, case), key=lambda v: np.abs(seconds(term, form, v, case) - plain(case)).sum()
    )


# --- what is known of each --------------------------------------------------------------------------------------------


def test_the_page_is_what_the_terms_say():
    assert PAGE.read_text(encoding="utf-8") == page(), "python bench/physics_page.py writes it again"


def test_the_details_of_the_terms_are_those_that_were_written_down():
    assert DETAILS.read_text(encoding="utf-8") == all_details(), (
        "python bench/physics_page.py writes them again"
    )


def test_every_term_of_moves_but_waits_has_a_form_in_a_recording_that_tells_everything():
    assert {term.name for term, _, _ in FORMS} == {
        n for n in CONTRACT if isinstance(load_term(n), MoveTerm) and n != "external-wait"
    }


@pytest.mark.parametrize("name", [n for n in CONTRACT if isinstance(load_term(n), MoveTerm)])
def test_a_term_that_cannot_be_told_says_what_is_missing(name):
    term = load_term(name)
    silent = replace(
        CASE,
        start=np.full((len(CASE), 3), np.nan),
        end=np.full((len(CASE), 3), np.nan),
        turn=np.full(len(CASE), np.nan),
        payload=np.full(len(CASE), np.nan),
        payload_inertia=np.full(len(CASE), np.nan),
        t_start=np.full(len(CASE), np.nan),
        base=CASE.base.with_(
            speed=np.ones(len(CASE)),
            accelerate=np.ones(len(CASE)),
            round_start=np.zeros(len(CASE)),
            round_end=np.zeros(len(CASE)),
        ),
        rates=None,
        derived={},
    )
    told = bool(term.forms(silent))
    assert not (told and term.lacks(silent))
    needs = {"gravity", "reach-inertia", "payload", "payload-inertia", "joint-acceleration-limit"}
    needs |= {"joint-speed-limit", "orientation-limit", "blending", "warm-up"}
    assert name == "torque-speed" or (name in needs) == bool(term.lacks(silent))


# --- forms ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("term", "form", "case"), FORMS, ids=IDS)
def test_a_term_at_its_null_changes_nothing(term, form, case):
    # The wrist's rated acceleration is a limit without any load, too: only what the load adds is nothing at 0.
    rates = replace(case.rates, rated_acceleration=np.full(6, 1e9)) if form.key == "limit" else case.rates
    weak = replace(case, rates=rates, derived={})
    assert seconds(term, form, nulls(form), weak) == pytest.approx(plain(weak), abs=1e-6)


def asks(axis, rates, per_metre):
    """(n,) the most of an axis (-1: of the fastest by `rates`) times what the path does per metre of it."""
    path = np.abs(CASE.rates.path)
    share = path[:, :, axis] if axis >= 0 else (path / rates).max(axis=2)
    return share.max(axis=1) * per_metre


def may_act(term, form, values):
    """(n,) the moves that a form is about; all else has to stay as it was."""
    base, v = CASE.base, values[0]
    match term.name:
        case "settling":
            return CASE.moving & CASE.stop_end
        case "payload" if len(values) == 1:
            return CASE.moving & (CASE.payload > 0)
        case "payload-inertia":
            return CASE.moving & WRIST & ((CASE.payload_inertia > 0) | (form.key == "limit"))
        case "gravity" if form.key == "incline of the tool":
            return CASE.moving
        case "gravity":
            return STRAIGHT & (np.abs(CASE.end - CASE.start)[:, 2] > 0)
        case "payload":
            return CASE.moving & (CASE.payload != values[1])
        case "reach-inertia" if form.key in ("whole arm", "three bodies") or form.key.startswith("any a"):
            return CASE.moving & np.isfinite(CASE.length)
        case "reach-inertia":
            assert CASE.rates is not None
            return STRAIGHT | (CASE.moving & np.array([a == CASE.rates.names[0] for a in CASE.leading]))
        case "speed-clamp":
            return CASE.moving & (base.speed > v * CASE.ratio)
        case "orientation-limit":
            return STRAIGHT & (CASE.turn > 0)
        case "blending":
            return ROUNDED
        case "joint-speed-limit":
            return asks(form.axis, CASE.rates.rated, base.speed) > v
        case "joint-acceleration-limit":
            return asks(form.axis, CASE.rates.rated_acceleration, base.accelerate) > v
        case "torque-speed" if form.key == "path power":
            return base.speed / CASE.ratio > v
        case "clock" | "cycle-quantisation":
            return EVERYTHING
        case "dispatch" if form.key == "waits too":
            return EVERYTHING
    return CASE.moving


@pytest.mark.parametrize(("term", "form", "case"), FORMS, ids=IDS)
def test_a_form_acts_on_the_moves_that_it_is_about_and_on_no_others(term, form, case):
    for values in (strong(term, form, case), term.guesses(form, case)[-1]):
        changed = np.abs(seconds(term, form, values, case) - plain(case)) > 1e-9
        about = CASE.moving if case is LADEN else may_act(term, form, values)
        assert not (changed & ~about).any()
    simulated = case is LADEN and form.key == "from the simulated load"
    assert not simulated or not changed[LADEN.payload == term.guesses(form, case)[-1][1]].any()


@pytest.mark.parametrize("name", ["settling", "dispatch", "clock", "acceleration", "jerk"])
def test_terms_of_all_moves_leave_out_none_of_them(name):
    term = load_term(name)
    form, *_ = term.forms(CASE)
    changed = np.abs(seconds(term, form, strong(term, form, CASE)) - plain()) > 1e-6
    assert changed[may_act(term, form, strong(term, form, CASE))].all()


def test_take_of_a_case_gives_the_same_durations_as_the_whole():
    """What a term works out once per case belongs to that case: halves must not see the whole's columns."""
    half = np.arange(0, len(CASE), 2)
    for term, form, case in FORMS:
        if case is CASE and term.name not in ("warm-up", "cycle-quantisation"):
            values = strong(term, form, case)
            motion = term.act(case.take(half).base, form, values, case.take(half))
            whole = term.act(case.base, form, values, case)
            same = motion.duration() * motion.rate - (whole.duration() * whole.rate)[half]
            assert np.abs(same).max() < 1e-9, f"{term.name} {form.key}"


def test_a_number_that_stands_for_an_acceleration_is_the_same_law_beside_one():
    """Of an inertia that the simulation has at one reach: from the first axis on, with another acceleration."""
    acceleration, checked = load_term("acceleration"), 0
    whole = acceleration.forms(CASE)[0]
    for term, form, case in FORMS:
        values = np.asarray(strong(term, form, case), dtype=float)
        if case is not CASE or (told := term.beside_acceleration(form, values, case)) is None:
            continue
        scale = ModelPart(acceleration, whole, told[1] * np.array([whole.parameters[0].null]))
        beside = DurationModel((ModelPart(term, form, told[0]), scale)).smooth(CASE)
        assert beside[STRAIGHT] == pytest.approx(seconds(term, form, values)[STRAIGHT], rel=2e-3)
        without = seconds(term, form, told[0])[STRAIGHT]
        assert (np.abs(beside[STRAIGHT] / without - 1.0) > 0.01).any()
        checked += 1
    assert checked >= 2


def test_models_changed_together_predict_what_each_predicts_alone():
    """The search's differences: one part of several in other places, everything else as it was."""
    for term, form, case in FORMS:
        beside = ModelPart(load_term("dispatch"), load_term("dispatch").forms(case)[0], np.array([0.03]))
        part = ModelPart(term, form, np.asarray(strong(term, form, case), dtype=float))
        model = DurationModel((beside, part) if term.name != "dispatch" else (part,))
        last = len(model.parts) - 1
        others = [part._replace(values=part.values * f) for f in (1.0, 0.99, 0.9)]
        together = model.smooth_with([(last, other) for other in others], case)
        for other, seconds_ in zip(others, together, strict=True):
            alone = DurationModel((*model.parts[:last], other)).smooth(case)
            np.testing.assert_array_equal(seconds_, alone, err_msg=f"{term.name} {form.key}")


def test_parts_before_and_behind_the_one_that_is_changed_act_on_all_changes_as_on_each():
    """Under a condition, too: what changes made of the moves goes through the other parts in one go."""
    told = load_term("dispatch")
    for term, form, case in FORMS:
        if term.name in ("dispatch", "external-wait"):
            continue
        part = ModelPart(term, form, np.asarray(strong(term, form, case), dtype=float))
        late = Condition((Statement("time", above=float(np.median(case.t_start - case.began))),))
        parts = (
            ModelPart(load_term("coulomb-friction"), COULOMB, np.array([0.1]), late),
            part._replace(condition=late if part.conditionable else None),
            ModelPart(told, told.forms(case)[0], np.array([0.03])),
        )
        changes = [(k, p._replace(values=f * p.values)) for k, p in enumerate(parts) for f in (0.99, 0.9)]
        for (k, other), both in zip(changes, DurationModel(parts).both_with(changes, case), strict=True):
            alone = DurationModel((*parts[:k], other, *parts[k + 1 :])).both(case)
            np.testing.assert_allclose(both, alone, rtol=1e-12, err_msg=f"{term.name} {form.key} {k}")


def test_what_was_fitted_to_the_same_moves_before_is_not_fitted_again():
    rows = np.arange(0, len(CASE), 2)
    some = CASE.fold(rows)
    assert CASE.fold(rows.copy()) is some
    np.testing.assert_array_equal(some.measured, CASE.measured[rows])
    model = DurationModel((ModelPart(load_term("coulomb-friction"), COULOMB, np.array([0.1])),))
    first, other = (fit(model, some, noise, 6) for noise in (Noise(1e-3), Noise(2e-3)))
    assert fit(model, some, Noise(1e-3), 6) is first
    assert other is not first


def test_who_allows_more_steps_than_were_worth_it_gets_the_same_fit():
    """Steps are many or few by another rule; what came of too few says nothing of more."""
    term = load_term("acceleration")
    form = term.forms(CASE)[0]
    part = ModelPart(term, form, term.guesses(form, CASE)[0])
    measured = DurationModel((part._replace(values=1.3 * part.values),)).seconds(CASE)
    case = replace(CASE, measured=measured, derived={})
    tried = {steps: fit(DurationModel((part,)), case, Noise(1e-3), steps) for steps in (20, 30, 10, 1)}
    assert tried[20] is tried[30]
    assert tried[20] is not tried[10]
    fresh = replace(case, derived={})
    for steps in (1, 10, 30, 20):
        alone = fit(DurationModel((part,)), fresh, Noise(1e-3), steps)
        assert (alone.loss, alone.model.parts[0].values) == (
            tried[steps].loss,
            tried[steps].model.parts[0].values,
        )


@pytest.mark.parametrize("places", [2, 9, 21])
def test_compiled_loops_along_ramps_say_the_same_to_the_last_bit(places, monkeypatch):
    rng = np.random.default_rng(places)
    force, ramp = rng.uniform(0.05, 2.0, (40, places)), 10 ** rng.uniform(-3, 2, (40, 1))
    force[0, 1], ramp[1:4, 0] = np.nan, (np.nan, np.inf, 0.0)
    said = []
    for worth in (False, True):
        monkeypatch.setattr(compiled_loops.Loops, "worth", lambda *_, worth=worth: worth)
        with np.errstate(invalid="ignore"):
            said.append(_ramps._passing(force, ramp))
    np.testing.assert_array_equal(*said)


def test_compiled_loops_along_limits_say_the_same_to_the_last_bit(monkeypatch):
    rng, count = np.random.default_rng(4), 60
    speed, up, down = rng.uniform(0.1, 1.0, count), rng.uniform(0.0, 0.1, count), rng.uniform(0.0, 0.1, count)
    motion = replace(CASE.base.take(np.zeros(count, dtype=int)), way=rng.uniform(0.0, 1.0, count))
    motion = motion.with_(speed=speed, accelerate=20.0 * up, decelerate=20.0 * down)
    limit, said = rng.uniform(0.05, 1.5, (count, 81)), []
    for worth in (False, True):
        monkeypatch.setattr(compiled_loops.Loops, "worth", lambda *_, worth=worth: worth)
        said.append(_limits.slowed_below(motion, np.arange(1, count), limit[1:]))
    assert (said[0] > 0).any()
    np.testing.assert_array_equal(*said)


@pytest.mark.parametrize("law", [law for law in _motion.LAWS if law in _motion._IN_LOOPS])
def test_compiled_loops_of_overlapping_ramps_say_the_same_to_the_last_bit(law, monkeypatch):
    rng, count = np.random.default_rng(8), 90
    motion = CASE.base.take(np.arange(count) % len(CASE)).with_(law=f"{law}{_motion.SHORTER}")
    columns = {name: rng.uniform(0.1, 2.0, count) for name in _motion._TRAVEL if name != "jerk"}
    corners = _motion.MoveCorners(*rng.uniform(0.1, 2.0, (11, count)).round(1))
    rounds = {f"round_{end}": rng.uniform(-0.2, 0.4, count).clip(0.0) for end in ("start", "end")}
    motion = motion.with_(**columns, **rounds, corners=corners, jerk=np.full(count, np.inf))
    motion.way[:9], motion.round_end[9], motion.speed[10] = 0.0, np.nan, np.nan
    for split, portion in ((1.0, 0.0), (0.5, 0.0), (0.3, 0.8)):
        said = []
        for worth in (False, True):
            monkeypatch.setattr(compiled_loops.Loops, "worth", lambda *_, worth=worth: worth)
            said.append(motion.with_(split=split, portion=portion, overlap=0.7).duration())
        assert (said[0] < motion.with_(law="stop").duration()).any()
        np.testing.assert_array_equal(*said)


@pytest.mark.parametrize("law", ["stop", "share"])
def test_compiled_loops_of_the_way_alone_say_the_same_to_the_last_bit(law, monkeypatch):
    rng, count, said = np.random.default_rng(9), 90, []
    motion = CASE.base.take(np.arange(count) % len(CASE)).with_(law=law, jerk=np.full(count, np.inf))
    columns = {name: rng.uniform(0.1, 2.0, count) for name in _motion._TRAVEL if name != "jerk"}
    columns |= {"round_end": rng.uniform(-0.2, 0.4, count).clip(0.0), "least": rng.uniform(0.0, 3.0, count)}
    motion = motion.with_(**columns, added=rng.uniform(0.0, 0.2, count))
    motion.way[:9], motion.speed[10], motion.filtered[20:50] = 0.0, np.nan, 0.0
    for worth in (False, True):
        monkeypatch.setattr(compiled_loops.Loops, "worth", lambda *_, worth=worth: worth)
        said += [motion.duration(), motion.durations((0.3, 0.9))]
    np.testing.assert_array_equal(said[0], said[2])
    np.testing.assert_array_equal(said[1], said[3])


@pytest.mark.parametrize("shape", ["plain", "filtered", "build", "jerk", "delayed"])
@pytest.mark.parametrize("law", [law for law in _motion.LAWS if law != "stop"])
def test_with_several_overlaps_at_once_motions_take_what_each_takes_alone(law, shape):
    """A parabola's way hangs on the overlap: for ramps that are filtered, the moves were then as many as overlaps."""
    rng, count = np.random.default_rng(9), 90
    motion = CASE.base.take(np.arange(count) % len(CASE)).with_(law=law, jerk=np.full(count, np.inf))
    columns = {name: rng.uniform(0.01, 0.1, count) for name in ("round_start", "round_end")}
    columns |= {name: rng.uniform(0.1, 2.0, count) for name in ("bend_start", "bend_end")}
    if shape != "plain":
        columns[shape] = rng.uniform(5.0, 50.0, count) if shape == "jerk" else rng.uniform(0.02, 0.1, count)
    motion = motion.with_(**columns)
    overlaps = (0.0, 0.03, 0.3, 0.9)
    alone = [motion.with_(overlap=overlap).duration() for overlap in overlaps]
    np.testing.assert_allclose(motion.durations(overlaps), alone, rtol=1e-12)


def test_compiled_loops_are_loaded_once_they_would_have_saved_what_that_costs():
    loops = compiled_loops.Loops(1e-6)
    calls = next(k for k in range(10**6) if loops.worth(1000))
    assert compiled_loops.LOAD_TIME <= 1e-6 * 1000 * (calls + 1) <= compiled_loops.IMPORT_TIME + 1e-3


def test_loops_pay_together_for_what_all_of_them_need():
    one, other = compiled_loops.Loops(1e-6), compiled_loops.Loops(1e-6)
    rows = int(1.1e6 * compiled_loops.LOAD_TIME)
    one.worth(int(1.1e6 * compiled_loops.IMPORT_TIME))
    assert other.worth(rows)
    assert not compiled_loops.Loops(1e-6).worth(rows // 2)


def test_the_cycle_of_the_recording_is_found():
    form, *_ = load_term("cycle-quantisation").forms(CASE)
    assert load_term("cycle-quantisation").guesses(form, CASE)[0][0] == pytest.approx(CYCLE, rel=2e-4)


def test_shares_of_any_three_terms_together_add_up_to_what_they_do():
    """Of two, first and last add up by themselves; three leave something over, which is split."""
    rng = np.random.default_rng(9)
    together = 0
    for chosen in rng.integers(0, len(FORMS), (60, 3)).tolist():
        three = [FORMS[k] for k in chosen]
        if len({term.name for term, _, _ in three}) < 3:
            continue
        parts = tuple(ModelPart(t, f, np.asarray(strong(t, f, CASE), float)) for t, f, _ in three)
        model = DurationModel(parts)
        whole, shares = model.seconds(CASE) - CASE.simulated, model.contributions(CASE)
        assert np.sum(shares, axis=0) == pytest.approx(whole, abs=1e-9)
        apart = sum(DurationModel((part,)).seconds(CASE) - CASE.simulated for part in parts)
        together += np.abs(whole - apart).max() > 1e-3
    assert together > 20, "terms that act together are what the shares are for"


@pytest.mark.parametrize("key", ["both ramps", "against and with"])
def test_gravity_takes_from_a_rising_moves_start_and_gives_to_its_end_or_takes_from_both(key):
    term = load_term("gravity")
    form = next(f for f in term.forms(CASE) if f.key == key)
    moved = term.act(CASE.base, form, np.array([0.3]), CASE)
    up, down = STRAIGHT & (CASE.rise > 0.1), STRAIGHT & (CASE.rise < -0.1)
    start, end = moved.accelerate / CASE.base.accelerate, moved.decelerate / CASE.base.decelerate
    assert (start[up] < 1).all()
    assert (start[down] > 1).all()
    assert ((end < 1) == ((start < 1) == (key == "both ramps")))[up | down].all()


def test_gravity_that_a_drive_only_loses_by_slows_the_start_going_up_and_the_end_going_down():
    term = load_term("gravity")
    form = next(f for f in term.forms(CASE) if f.key == "against alone")
    moved = term.act(CASE.base, form, np.array([0.3]), CASE)
    up, down = STRAIGHT & (CASE.rise > 0.1), STRAIGHT & (CASE.rise < -0.1)
    start, end = moved.accelerate / CASE.base.accelerate, moved.decelerate / CASE.base.decelerate
    assert start[up] == pytest.approx(1 - 0.3 * CASE.rise[up])
    assert end[down] == pytest.approx(1 + 0.3 * CASE.rise[down])
    assert start[down] == pytest.approx(1)
    assert end[up] == pytest.approx(1)


@pytest.mark.parametrize(
    "name", ["acceleration", "payload", "reach-inertia", "jerk", "speed-clamp", "torque-speed"]
)
def test_what_weakens_a_drive_never_makes_a_move_shorter(name):
    term = load_term(name)
    for form in term.forms(CASE):
        if any(np.isnan(p.null) for p in form.parameters):
            continue  # real over simulated: also less than simulated
        values = np.array(term.guesses(form, CASE)[0], dtype=float)
        assert (seconds(term, form, values) >= plain() - 1e-9).all(), form.key
