"""Terms against what they claim, worked out another way: in time steps, by an independent solver, by fine sweeps."""

from __future__ import annotations

from dataclasses import replace

import diagnosis_cases as planted
import numpy as np
import pytest
import ruckig

from olp.contracts.terms import rich_case
from olp.identification.diagnosis.fitting import Noise, fit
from olp.identification.diagnosis.model import DurationModel, ModelPart
from olp.timing.physics import cycle_quantisation, load_term
from olp.timing.physics._motion import LAWS, Motion, MoveCorners, last_part, stacked

N = 60
CASE = rich_case(moves=150, joint_moves=0, seed=11)
STRAIGHT = np.nonzero(CASE.moving & ~CASE.joint)[0]
FAST = rich_case(moves=150, joint_moves=0, seed=11, speeds=(0.5, 1.0, 2.0))  # the same ways


def motions(seed=3, unequal=True, jerk=True, n=N):
    """Random moves between stops, half of them too short for their speed."""
    rng = np.random.default_rng(seed)
    speed, up = 10 ** rng.uniform(-1.5, 0.3, n), 10 ** rng.uniform(-0.3, 1.0, n)
    down = up * 10 ** rng.uniform(-0.5, 0.5, n) if unequal else up
    way = speed * speed / up * 10 ** rng.uniform(-1.5, 1.5, n)
    zero = np.zeros(n)
    jerks = up / 10 ** rng.uniform(-2.0, 0.0, n) if jerk else np.full(n, np.inf)
    return Motion(way, speed, up, down, jerks, zero, zero, zero, zero, np.ones(n))


# --- the time law -----------------------------------------------------------------------------------------------------


def test_ramps_without_jerk_take_what_a_time_stepped_drive_takes():
    """That drive brakes when it must, and is good to a few steps."""
    motion = motions(jerk=False)
    played = planted.play(motion.way, motion.speed, motion.accelerate, motion.decelerate)
    assert motion.duration() == pytest.approx(played, abs=8 * planted.STEP)


@pytest.mark.parametrize("unequal", [False, True])
def test_jerk_limited_moves_take_what_ruckig_takes(unequal):
    motion = motions(seed=4, unequal=unequal)
    expected = []
    for k in range(N):
        task = ruckig.InputParameter(1)
        task.target_position = [float(motion.way[k])]
        task.max_velocity = [float(motion.speed[k])]
        task.max_acceleration, task.min_acceleration = (
            [float(motion.accelerate[k])],
            [-float(motion.decelerate[k])],
        )
        task.max_jerk = [float(motion.jerk[k])]
        trajectory = ruckig.Trajectory(1)
        assert ruckig.Ruckig(1).calculate(task, trajectory) in (ruckig.Result.Working, ruckig.Result.Finished)
        expected.append(trajectory.duration)
    short = motion.duration() < motion.way / motion.speed * 1.5
    assert 5 < short.sum() < N - 5
    assert motion.duration() == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("filtered", [0.0, 0.05])
def test_ramps_of_short_moves_cover_their_way_exactly(filtered):
    """Where no cruising is left, the way is half of what both ramps would cover at the highest speed."""
    motion = motions(seed=6, n=400)
    motion = motion.with_(filtered=np.full(400, filtered))
    seconds, speed = motion._travel()
    ramps = np.full(400, 2.0 * filtered)
    for most in (motion.accelerate, motion.decelerate):
        reached = speed * motion.jerk >= most**2
        ramps += np.where(reached, speed / most + most / motion.jerk, 2.0 * np.sqrt(speed / motion.jerk))
    short = speed < motion.speed
    assert 100 < short.sum() < 300
    assert (0.5 * speed * ramps)[short] == pytest.approx(motion.way[short], rel=1e-11)
    assert seconds[short] == pytest.approx(ramps[short], rel=1e-11)


def test_an_acceleration_that_builds_up_in_a_time_has_the_jerk_that_gives_it():
    motion = motions(seed=4, unequal=False)
    built = motion.with_(build=motion.accelerate / motion.jerk, jerk=np.full(N, np.inf))
    assert built.duration() == pytest.approx(motion.duration(), rel=1e-9)
    unequal = motions(seed=6, unequal=True, n=400)
    unequal = unequal.with_(build=np.full(400, 0.1), jerk=np.full(400, np.inf))
    seconds, speed = unequal._travel()
    ramps = np.zeros(400)
    for most in (unequal.accelerate, unequal.decelerate):
        ramps += np.where(speed >= 0.1 * most, speed / most + 0.1, 2.0 * np.sqrt(0.1 * speed / most))
    short = speed < unequal.speed
    assert 50 < short.sum() < 350
    assert (0.5 * speed * ramps)[short] == pytest.approx(unequal.way[short], rel=1e-9)
    assert seconds[short] == pytest.approx(ramps[short], rel=1e-9)


def test_ramps_of_a_shortest_time_take_what_a_bisection_of_the_peak_speed_gives():
    """Whatever both accelerations are: a stronger one changes nothing where the shortest time is the longer."""
    motion = motions(seed=6, jerk=False, n=400)
    shortest = np.random.default_rng(3).choice([0.0, 0.05, 0.2], 400)
    ways = (motion.accelerate, motion.decelerate)

    def ramps(speed):
        return sum(np.maximum(speed / each, shortest) for each in ways)

    low, high = np.zeros(400), motion.speed
    for _ in range(60):
        middle = (low + high) / 2
        fits = middle * ramps(middle) / 2 <= motion.way
        low, high = np.where(fits, middle, low), np.where(fits, high, middle)
    held_up, held_down = (low / each < shortest for each in ways)
    assert min((held_up != held_down).sum(), (held_up & held_down).sum()) > 20
    expected = ramps(low) + (motion.way - low * ramps(low) / 2) / low
    held = motion.with_(shortest=shortest)
    assert held.duration() == pytest.approx(expected, rel=1e-9)
    assert held.top() == pytest.approx(low, rel=1e-9)


def test_motions_that_stand_below_each_other_take_what_each_takes_alone():
    plain, other = motions(seed=7), motions(seed=8)
    rounded = np.where(np.arange(N) % 2, 0.01, 0.0)
    columns = np.random.default_rng(9).uniform(0.1, 2.0, (11, N))
    corners = MoveCorners(*columns)
    tried = [plain, motions(seed=7, jerk=False), other]
    for law in (*LAWS, "braking each", "share shorter"):
        cornered = [m.with_(law=law, round_start=rounded, round_end=rounded) for m in (plain, other)]
        tried += [*cornered, *(m.with_(corners=corners, overlap=0.5) for m in cornered)]
    alike: dict[object, list[Motion]] = {}
    for motion in tried:
        alike.setdefault((motion.manner, motion.corners is None), []).append(motion)
    assert sum(len(each) == 1 for each in alike.values()) == 1  # the one without jerk
    for each in alike.values():
        whole = each[0].repeated(len(each))
        together = stacked(each, each[:1] * len(each), whole).duration().reshape(len(each), -1)
        np.testing.assert_array_equal(together, [motion.duration() for motion in each])


def test_jerk_limited_moves_take_what_stepping_through_time_takes():
    """Ramps to many speeds are stepped; the right one is the one whose two ramps cover the way."""
    motion = motions(seed=5, n=10)
    peaks = motion.speed * np.linspace(0.01, 1.0, 150)[:, None]
    up, there = _stepped_ramp(peaks, motion.accelerate, motion.jerk)
    down, back = _stepped_ramp(peaks, motion.decelerate, motion.jerk)
    for k in range(10):
        covered, took = (there + back)[:, k], (up + down)[:, k]
        if covered[-1] > motion.way[k]:
            expected = np.interp(motion.way[k], covered, took)
        else:
            expected = took[-1] + (motion.way[k] - covered[-1]) / motion.speed[k]
        assert motion.duration()[k] == pytest.approx(expected, rel=1e-2, abs=2e-3)


def _stepped_ramp(peaks, acceleration, jerk, step=4e-4):
    """Time and way from rest to `peaks`, in steps: more acceleration as long as it can be taken back in time."""
    fast, push, way, time = (np.zeros_like(peaks) for _ in range(4))
    on = np.ones(peaks.shape, dtype=bool)
    while on.any():
        build = on & (fast + push * push / (2 * jerk) < peaks)
        push = np.where(
            build, np.minimum(push + jerk * step, acceleration), np.maximum(push - jerk * step, 0.0)
        )
        faster = fast + push * step
        way += np.where(on, 0.5 * (fast + np.minimum(faster, peaks)) * step, 0.0)
        time += np.where(on, step, 0.0)
        fast = np.where(on, np.minimum(faster, peaks), fast)
        on &= (fast < peaks - 1e-9) & (build | (push > 0))
    return time, way


def test_a_slower_ramp_never_makes_a_move_shorter():
    motion = motions(seed=6)
    for name in ("accelerate", "decelerate", "jerk", "speed"):
        slower = motion.with_(**{name: 0.8 * getattr(motion, name)})
        assert (slower.duration() >= motion.duration() - 1e-7).all()


# --- corners ----------------------------------------------------------------------------------------------------------


def corner(law, rounding, way=1.0, speed=0.5, slow=2.0, overlap=1.0, **changes):
    """[s] that one corner saves of two moves."""
    one, zero = np.ones(2), np.zeros(2)
    start, end = np.array([0.0, rounding]), np.array([rounding, 0.0])
    stop = Motion(way * one, speed * one, slow * one, slow * one, np.inf * one, start, end, zero, zero, one)
    return float(stop.duration().sum() - stop.with_(law=law, overlap=overlap, **changes).duration().sum())


@pytest.mark.parametrize("rounding", [0.001, 0.01, 0.03, 0.06, 0.1, 0.2])
def test_braking_overlaps_for_as_long_as_the_last_millimetres_take(rounding):
    """The next move begins when the first one, stepped through time, is within the rounding."""
    step, speed, slow = 1e-5, 0.5, 2.0
    left, fast, late = speed**2 / (2 * slow) + 0.3, speed, 0.0
    while left > 0 and fast > 0:
        fast = min(speed, np.sqrt(2 * slow * left))
        late += step * (left <= rounding)
        left -= fast * step
        if left < 1e-9:
            break
    assert corner("braking", rounding) == pytest.approx(late, abs=2e-3)


def test_full_overlap_saves_a_ramp_and_distance_the_time_at_full_speed_but_no_more():
    ramp = 0.5 / 2.0
    assert corner("full", 0.01) == pytest.approx(ramp)
    assert corner("full", 0.01, overlap=0.4) == pytest.approx(0.4 * ramp)
    assert corner("distance", 0.01) == pytest.approx(2 * 0.01 / 0.5)
    assert corner("distance", 0.2) == pytest.approx(ramp)
    assert corner("stop", 0.2) == 0.0


def test_a_corner_passed_at_full_speed_is_one_long_move():
    """Two collinear moves with a full overlap take the time of both as one."""
    one = Motion(*(np.array([v]) for v in (2.0, 0.5, 2.0, 2.0, np.inf, 0.0, 0.0, 0.0, 0.0, 1.0)))
    two = one.with_(way=np.array([1.0]))
    assert 2 * two.duration()[0] - corner("full", 0.05) == pytest.approx(one.duration()[0])


@pytest.mark.parametrize("law", [law for law in LAWS if law != "stop"])
@pytest.mark.parametrize("split", [0.0, 0.3, 1.0])
def test_what_a_corner_saves_does_not_depend_on_the_move_it_is_booked_on(law, split):
    assert corner(law, 0.02, split=split, overlap=0.1) == pytest.approx(corner(law, 0.02, overlap=0.1))


def test_the_move_after_a_corner_is_booked_what_the_braking_before_it_takes():
    """A quick move before a slow one: the corner is worth the quick one's braking, wherever it is booked."""
    one, zero = np.ones(2), np.zeros(2)
    way, speed, slow = one, np.array([0.8, 0.1]), np.array([2.0, 4.0])
    corners = MoveCorners(
        one,
        np.array([0.8, 0.8]),
        np.array([1.0, 0.5]),
        one,
        one,
        one,
        speed[1] * one,
        2.0 * one,
        zero,
        zero,
        zero,
    )
    start, end = np.array([0.0, 0.01]), np.array([0.01, 0.0])
    stop = Motion(way, speed, slow, slow, np.inf * one, start, end, zero, zero, one, corners=corners)
    for split in (0.0, 0.5, 1.0):
        saved = stop.duration() - stop.with_(law="braking", split=split).duration()
        assert saved == pytest.approx(np.array([split, 1 - split]) * np.sqrt(2 * 0.01 / 2.0))


def test_ramps_that_overlap_by_the_shorter_one_save_what_the_stronger_of_both_takes():
    """The second move speeds up twice as strongly as the first one brakes, or half as strongly."""
    one, zero, start, end = np.ones(2), np.zeros(2), np.array([0.0, 0.01]), np.array([0.01, 0.0])
    for slow in (np.array([2.0, 4.0]), np.array([4.0, 2.0])):
        ratio = slow[1] / slow[0]
        corners = MoveCorners(
            one, one, np.array([1.0, 1 / ratio]), one, one, one, one, np.array([ratio, 1.0]), zero, zero, zero
        )
        stop = Motion(one, one, slow, slow, np.inf * one, start, end, zero, zero, one, corners=corners)
        for split in (0.0, 0.5, 1.0):
            saved = stop.duration() - stop.with_(law="share shorter", split=split).duration()
            assert saved == pytest.approx(np.array([split, 1 - split]) * np.sqrt(2 * 0.01 / 4.0))


def test_a_corner_passed_at_the_speed_of_its_radius_saves_what_the_rest_of_both_ramps_need():
    """v²/2a less what is not stopped for: ramps from 0.5 to √(a r) and back instead of to rest and back."""
    speed, slow, radius = 0.5, 2.0, 0.02
    passed = np.sqrt(slow * radius)
    stopped = 2 * (1.0 / speed + speed / (2 * slow))
    flown = 2 * (1.0 / speed + (speed - passed) ** 2 / (2 * slow * speed))
    assert corner("radius each", radius) == pytest.approx(stopped - flown)


def test_through_an_arc_a_move_begins_and_ends_at_its_speed():
    """From 0.2 to √(a R) = 0.3 m/s at up to 0.5 m/s; stepped through time."""
    one, zero, slow, step = np.ones(1), np.zeros(1), 2.0, 1e-5
    rounds = np.array([0.01]), np.array([0.02])
    motion = Motion(
        0.4 * one, 0.5 * one, slow * one, slow * one, np.inf * one, *rounds, zero, zero, one, law="arc"
    )
    motion = motion.with_(open_start=np.array([4.0]), open_end=np.array([4.5]))
    place, fast, took = 0.0, 0.2, 0.0
    while place < 0.4:
        brakes = fast**2 - 0.3**2 >= 2 * slow * (0.4 - place)
        fast = max(fast - slow * step, 0.3) if brakes else min(fast + slow * step, 0.5)
        place, took = place + fast * step, took + step
    assert motion.duration() == pytest.approx(took, abs=1e-3)
    filtered = motion.with_(round_start=zero, filtered=0.1 * one).duration()
    assert filtered == pytest.approx(motion.with_(round_start=zero).duration() + 0.05)


@pytest.mark.parametrize("build", [0.0, 0.04, 0.5])
def test_between_corners_a_ramp_whose_acceleration_builds_up_takes_longer_by_its_own_change_of_speed(build):
    """From √(a R) = 0.2 over 0.8 to 0.3 m/s: each ramp covers its mean speed while it lasts. At the longest time none
    reaches its acceleration."""
    one, zero, slow = np.ones(1), np.zeros(1), 2.0
    rounds = np.array([0.01]), np.array([0.02])
    motion = Motion(
        3.0 * one, 0.8 * one, slow * one, slow * one, np.inf * one, *rounds, zero, zero, one, law="arc"
    )
    motion = motion.with_(open_start=np.array([4.0]), open_end=np.array([4.5]), build=build * one)
    took, left = 0.0, 3.0
    for corner_speed in (0.2, 0.3):
        change = 0.8 - corner_speed
        reached = change >= slow * build
        ramp = change / slow + build if reached else 2.0 * np.sqrt(change * build / slow)
        took, left = took + ramp, left - 0.5 * (0.8 + corner_speed) * ramp
    assert motion.duration() == pytest.approx(took + left / 0.8)


def test_of_moves_of_which_some_build_up_accelerations_the_others_are_as_without():
    """In the same array: without a build-up the jerk is infinite, also over no way and between equal speeds."""
    way = np.array([3.0, 0.05, 0.02, 0.002, 0.05, 0.02, 0.002])
    builds = np.array([0.04, 0.04, 0.5, 0.04, 0.0, 0.0, 0.0])
    one = np.ones(len(way))
    zero, rounds = 0.0 * one, 0.001 * one
    plain = Motion(way, 0.8 * one, one, one, np.inf * one, rounds, rounds, zero, zero, one, law="arc")
    plain = plain.with_(open_start=40.0 * one, open_end=45.0 * one)
    took = plain.with_(build=builds).duration()
    assert took[builds == 0] == pytest.approx(plain.duration()[builds == 0], abs=1e-9)
    assert (took[:3] > plain.duration()[:3]).all()


def averaged(speed, slow, average, pieces=2000):
    """Times before the stop [s] and what is left then [m] of braking whose speed passes a moving average, in steps."""
    step = average / pieces
    time = step * np.arange(int((speed / slow + average + 0.3) / step) + 2)
    left = np.where(slow * time < speed, 0.5 * slow * time**2, speed * time - 0.5 * speed**2 / slow)
    summed = np.concatenate([[0.0], np.cumsum(0.5 * step * (left[1:] + left[:-1]))])
    return time, (summed - summed[np.maximum(np.arange(len(time)) - pieces, 0)]) / average


@pytest.mark.parametrize("average", [0.01, 0.08, 0.24, 0.4])
def test_the_last_part_of_an_averaged_ramp_takes_what_small_steps_of_it_take(average):
    """Within its end, its middle, its beginning and before it, also where the average is longer than the ramp."""
    speed, slow = 0.5, 2.0
    time, left = averaged(speed, slow, average)
    rest = np.array([0.0001, 0.002, 0.01, 0.03, 0.06, 0.09, 0.12, 0.2])
    one = np.ones(len(rest))
    took = last_part(rest, speed * one, slow * one, average * one)
    np.testing.assert_allclose(took, np.interp(rest, left, time), atol=2e-6)


@pytest.mark.parametrize("average", [0.04, 0.2])
@pytest.mark.parametrize("rounding", [0.003, 0.02, 0.04])
def test_an_average_behind_the_planner_is_waited_for_until_the_arm_is_within_the_rounding(average, rounding):
    """Two moves with a corner: the second begins when the first, averaged, is that near to its end."""
    speed, slow, one, zero = 0.5, 2.0, np.ones(2), np.zeros(2)
    start, end = np.array([0.0, rounding]), np.array([rounding, 0.0])
    stop = Motion(one, speed * one, slow * one, slow * one, np.inf * one, start, end, zero, zero, one)
    time, left = averaged(speed, slow, average)
    whole = 1.0 / speed + speed / slow + average
    wanted = np.array([whole - np.interp(rounding, left, time), whole])
    for law, overlap in (("braking", 1.0), ("share", 1.0)):
        moves = stop.with_(law=law, overlap=overlap, split=1.0, delayed=average * one)
        assert moves.duration() == pytest.approx(wanted, abs=2e-6)
    # What other laws know of no ramp's shape is half of the average.
    for law in ("stop", "full", "distance"):
        moves = stop.with_(law=law, split=1.0)
        late = moves.with_(delayed=average * one).duration() - moves.duration()
        assert late == pytest.approx(average * np.array([0.5, 1.0]))


@pytest.mark.parametrize("law", ["braking", "distance", "full", "share", "flight", "radius each"])
def test_no_corner_saves_more_than_a_move_takes(law):
    for way in (0.001, 0.01, 0.1):
        assert 0 <= corner(law, 0.2, way=way) < 2 * 0.9 * 2 * np.sqrt(way / 2.0) + 1e-9


# --- forces that fall with speed --------------------------------------------------------------------------------------


def long_case():
    """Straight moves that reach their speeds."""
    rows = STRAIGHT[
        CASE.base.way[STRAIGHT] > 1.5 * CASE.base.speed[STRAIGHT] ** 2 / CASE.base.accelerate[STRAIGHT]
    ]
    assert len(rows) > 20
    return replace(CASE.take(rows), rates=None, derived={})


def ramp_cost(force, speed, steps=20000):
    """[s] of a ramp beyond its way at full speed and [m] that way: time by dt = dv/a, way by ds = v dt."""
    v = (np.arange(steps) + 0.5) * speed / steps
    took = speed / steps / force(v)
    way = float((v * took).sum())
    return float(took.sum()) - way / speed, way


@pytest.mark.parametrize("law", ["line", "knee", "power"])
def test_ramps_of_torque_speed_cost_what_integrating_the_force_costs(law):
    case, term = long_case(), load_term("torque-speed")
    form = next(f for f in term.forms(case) if f.key == f"path {law}")
    seen = 0
    for values in term.guesses(form, case):
        moved = term.act(case.base, form, values, case)
        for k in range(0, len(case), 3):
            speed, a, v0 = case.base.speed[k], case.base.accelerate[k], values[0]
            if law != "power" and speed > 0.9 * v0:
                continue
            shares = {
                "line": lambda v, v0=v0: 1 - v / v0,
                "knee": lambda v, v0=v0, w=values[-1]: np.minimum(1, (1 - v / v0) / (1 - w)),
                "power": lambda v, v0=v0: np.minimum(1, v0 / v),
            }
            expected, way = ramp_cost(lambda v, a=a, share=shares[law]: a * share(v), speed)
            if 2.0 * way > case.base.way[k]:
                continue  # with so little force left it never gets to its speed
            assert 0.5 * speed / moved.accelerate[k] == pytest.approx(expected, rel=0.015)
            seen += expected > 1.02 * 0.5 * speed / a
    assert seen >= 3


@pytest.mark.parametrize("law", ["line", "power"])
def test_durations_of_short_moves_follow_torque_speed_without_steps(law):
    """A fit takes slopes over far less than a thousandth of the idle speed."""
    case, term = CASE.take(STRAIGHT), load_term("torque-speed")
    form = next(f for f in term.forms(case) if f.key == f"path {law}")
    middle = term.guesses(form, case)[0] * 1.01
    near = middle * (1.0 + 1e-5 * np.arange(40))
    seconds = np.stack([term.act(case.base, form, np.array([v]), case).duration() for v in near])
    assert np.abs(np.diff(seconds, n=2, axis=0)).max() < 2e-8


def test_no_move_passes_the_speed_at_which_no_torque_is_left():
    case, term = long_case(), load_term("torque-speed")
    form = next(f for f in term.forms(case) if f.key == "path line")
    idle = 0.8 * case.base.speed.max()
    assert term.act(case.base, form, np.array([idle]), case).speed.max() < idle


@pytest.mark.parametrize(("key", "braked"), [("", 1), ("speeding up", 0)])
def test_ramps_of_viscous_friction_cost_what_integrating_the_force_costs(key, braked):
    """Both ramps together, where friction takes up to half of the force, and helps to brake or not."""
    case, term = long_case(), load_term("viscous-friction")
    (form,) = (form for form in term.forms(case) if form.key == key)
    loss = 0.5 * form.parameters[0].high
    moved = term.act(case.base, form, np.array([loss]), case)
    for k in range(0, len(case), 3):
        speed, a = case.base.speed[k], case.base.accelerate[k]
        expected = sum(ramp_cost(lambda v, a=a, s=sign: a + s * loss * v, speed)[0] for sign in (-1, braked))
        cost = 0.5 * speed / moved.accelerate[k] + 0.5 * speed / moved.decelerate[k]
        assert cost == pytest.approx(expected, rel=0.06)


def played_against_friction(way, speed, up, down, steps=4000):
    """[s] from rest to rest over `way`, speeding up with `up`(v) and braking with `down`(v), no faster than `speed`."""

    def ramps(peak):
        v = (np.arange(steps) + 0.5) * peak / steps
        took = [peak / steps / force(v) for force in (up, down)]
        return sum(float(t.sum()) for t in took), sum(float((v * t).sum()) for t in took)

    low, high = 0.0, speed
    if ramps(speed)[1] <= way:
        low = speed
    else:
        for _ in range(40):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if ramps(middle)[1] > way else (middle, high)
    seconds, covered = ramps(low)
    return seconds + (way - covered) / low


@pytest.mark.parametrize("key", ["", "axes", "speeding up", "axes, speeding up"])
def test_moves_against_viscous_friction_take_what_integrating_it_takes(key):
    """Long and short ones; by the speed of the path, or by the share of its rated speed that the fastest axis has."""
    case = rich_case(moves=150, joint_moves=80, seed=12)
    rows = np.nonzero(case.joint)[0]
    case, term = case.take(rows), load_term("viscous-friction")
    form = next(f for f in term.forms(case) if f.key == key)
    loss = 0.7 * form.parameters[0].high
    fastest = (np.abs(case.rates.path).mean(axis=1) / case.rates.rated).max(axis=1)
    base = case.base.with_(law="stop", added=np.zeros(len(rows)), least=np.zeros(len(rows)))
    seconds = term.act(base, form, np.array([loss]), case).duration()
    grown = 0
    for k in range(len(rows)):
        a = base.accelerate[k]
        share = loss * fastest[k] if key.startswith("axes") else loss / a
        helped = 0.0 if key.endswith("speeding up") else share
        expected = played_against_friction(
            base.way[k],
            base.speed[k],
            lambda v, a=a, share=share: a * np.maximum(1 - share * v, 0.05),
            lambda v, a=a, share=helped: a * (1 + share * v),
        )
        assert seconds[k] == pytest.approx(expected, rel=2e-3)
        grown += expected > 1.01 * base.duration()[k]
    assert grown > 5


def rounded_case(law, rounding, passed=0.0):
    """Long lines with both ends rounded by `rounding` (n,) [m], and what arcs there are passed with."""
    case = long_case()
    ends = {"round_start": rounding, "round_end": rounding, "open_start": passed, "open_end": passed}
    none = np.zeros(len(case))
    return case, case.base.with_(
        law=law, overlap=1.0, split=1.0, corners=None, added=none, least=none, **ends
    )


def acting(name, case, base, share):
    """A motion whose force changes by the `share` up to the highest speed, and the force (n,) of each ramp."""
    term = load_term(name)
    form = next(f for f in term.forms(case) if f.key in ("", "path line"))
    a, most = base.accelerate, base.speed.max()
    value = share * float((a / base.speed).min()) if name == "viscous-friction" else most / share
    if name == "viscous-friction":
        forces = (lambda v: a - value * v, lambda v: a + value * v)
    else:
        forces = (lambda v: a * (1 - v / value),) * 2
    return term.act(base, form, np.array([value]), case), forces


@pytest.mark.parametrize("name", ["viscous-friction", "torque-speed"])
def test_near_rest_a_corner_is_rounded_with_the_whole_force(name):
    """The last 4 % of braking, which begin at a fifth of the speed: forces that go by speed are hardly felt there."""
    case = long_case()
    ramp = case.base.speed**2 / (2 * case.base.decelerate)
    case, base = rounded_case("braking", 0.04 * ramp)
    moved, (_, brake) = acting(name, case, base, 0.6)
    saved = moved.with_(law="stop").duration() - moved.duration()
    steps, covered, expected = 4000, np.zeros(len(case)), np.zeros(len(case))
    for k in range(steps):  # speeding up from rest with the force of the brake is braking, played backwards
        v = (k + 0.5) / steps * base.speed
        took = base.speed / steps / brake(v)
        expected += np.where(covered < base.round_end, took, 0.0)
        covered += v * took
    assert saved == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("name", ["viscous-friction", "torque-speed"])
def test_between_arcs_ramps_are_those_above_the_speed_of_the_arc(name):
    """They begin and end at 60 % of the speed, where such forces are stronger than over the whole ramp."""
    case = long_case()
    rounding = np.full(len(case), 0.001)
    case, base = rounded_case("arc", rounding, (0.6 * case.base.speed) ** 2 / 0.001)
    moved, forces = acting(name, case, base, 0.3)
    steps, seconds, way, felt = 4000, np.zeros(len(case)), np.zeros(len(case)), np.zeros(len(case))
    for k in range(steps):
        v = base.speed * (0.6 + 0.4 * (k + 0.5) / steps)
        for force in forces:
            took = 0.4 * base.speed / steps / force(v)
            seconds, way = seconds + took, way + v * took
            felt += (1 - v / base.speed) * np.abs(took - 0.4 * base.speed / steps / base.accelerate)
    long = 1.5 * base.speed**2 / base.accelerate < base.way  # also from rest to rest
    expected = (seconds + (base.way - way) / base.speed)[long]
    assert long.sum() > 5
    assert (np.abs(moved.duration()[long] - expected) < 0.1 * felt[long]).all()


# --- limits of axes ---------------------------------------------------------------------------------------------------


def swept(row, axis, speed_limit=np.inf, acceleration_limit=np.inf, fine=4000):
    """[s] of the fastest motion along a move: forward and backward over the way, the axis' rate known everywhere."""
    base, path = CASE.base, np.abs(CASE.rates.path[row, :, axis])
    place = np.linspace(0.0, 1.0, fine + 1)
    rate = np.interp(place, np.linspace(0.0, 1.0, len(path)), path)
    top = np.minimum(base.speed[row], speed_limit / np.maximum(rate, 1e-12))
    slow = np.minimum(base.accelerate[row], acceleration_limit / np.maximum(rate, 1e-12))
    step = base.way[row] / fine
    square = top**2
    square[0] = square[-1] = 0.0
    for k in range(fine):
        square[k + 1] = min(square[k + 1], square[k] + 2 * slow[k] * step)
    for k in range(fine, 0, -1):
        square[k - 1] = min(square[k - 1], square[k] + 2 * slow[k] * step)
    fast = np.sqrt(square)
    return float((2 * step / (fast[1:] + fast[:-1])).sum())


def costs(name, value, axis):
    """(m, 2) [s] what a limit costs moves from stop to stop: by the term, and by the sweep."""
    term = load_term(name)
    form = next(f for f in term.forms(CASE) if f.axis == axis)
    stop = (CASE.base.round_start == 0) & (CASE.base.round_end == 0)
    extra = term.act(CASE.base, form, np.array([value]), CASE).duration() - CASE.base.duration()
    limit = {"speed_limit": value} if name == "joint-speed-limit" else {"acceleration_limit": value}
    rows = [k for k in STRAIGHT.tolist() if stop[k] and extra[k] > 5e-3][:6]
    return [(extra[k], swept(k, axis, **limit) - swept(k, axis)) for k in rows]


@pytest.mark.parametrize("axis", [0, 2, 4])
def test_speed_limits_of_axes_cost_what_a_fine_sweep_over_the_way_says(axis):
    asked = np.abs(CASE.rates.path[STRAIGHT, :, axis]).max(axis=1) * CASE.base.speed[STRAIGHT]
    found = [
        pair
        for value in np.quantile(asked, [0.3, 0.5, 0.8])
        for pair in costs("joint-speed-limit", value, axis)
    ]
    assert len(found) >= 3
    for cost, expected in found:
        assert cost == pytest.approx(expected, rel=0.12, abs=4e-3)


@pytest.mark.parametrize("axis", [0, 2, 4])
def test_acceleration_limits_of_axes_cost_what_a_fine_sweep_over_the_way_says(axis):
    """A ramp that the limit makes longer passes other places: at the simulation's it cost up to 1.3 times."""
    asked = np.abs(CASE.rates.path[STRAIGHT, :, axis]).max(axis=1) * CASE.base.accelerate[STRAIGHT]
    found = [
        pair
        for value in np.quantile(asked, [0.3, 0.5, 0.8])
        for pair in costs("joint-acceleration-limit", value, axis)
    ]
    assert len(found) >= 3
    ratio = np.array([cost / expected for cost, expected in found])
    assert ratio == pytest.approx(1.0, abs=0.015)


def swept_along_curves(row, share, fine=3000):
    """[s] of the fastest motion along a fast move where no axis' q'' = q' a + q'' v² is more than a share of its rated
    acceleration: forward and backward over the way."""
    base, rates = FAST.base, FAST.rates
    path = rates.path[row] / rates.rated_acceleration
    place, known = np.linspace(0.0, 1.0, fine + 1), np.linspace(0.0, 1.0, len(path))
    bends = np.sign(path) * np.gradient(path, known, axis=0) / base.way[row]
    turn, bend = (
        np.stack([np.interp(place, known, one) for one in columns.T], axis=1)
        for columns in (abs(path), bends)
    )
    step = base.way[row] / fine
    square = np.minimum(base.speed[row] ** 2, share / np.maximum(np.abs(bend).max(axis=1), 1e-12))
    square[0] = square[-1] = 0.0

    def gained(k, side):
        room = np.maximum(share - side * bend[k] * square[k], 0.1 * share) / np.maximum(turn[k], 1e-12)
        return 2 * step * min(base.accelerate[row], room.min())

    for k in range(fine):
        square[k + 1] = min(square[k + 1], square[k] + gained(k, 1.0))
    for k in range(fine, 0, -1):
        square[k - 1] = min(square[k - 1], square[k] + gained(k, -1.0))
    fast = np.sqrt(square)
    return float((2 * step / (fast[1:] + fast[:-1])).sum())


def test_the_curvature_of_the_axes_ways_costs_what_a_fine_sweep_over_the_way_says():
    """Where an axis turns round, the places at which rates are known are far apart: up to 2 ms."""
    term = load_term("joint-acceleration-limit")
    forms = {form.key: form for form in term.forms(FAST)}
    stop = (FAST.base.round_start == 0) & (FAST.base.round_end == 0)
    found = []
    for share in (0.4, 0.7):
        extra, plain = (
            term.act(FAST.base, forms[key], np.array([share]), FAST).duration() - FAST.base.duration()
            for key in ("all with curvature", "all")
        )
        differ = np.abs(extra - plain)
        rows = [k for k in STRAIGHT[np.argsort(-differ[STRAIGHT])].tolist() if stop[k]][:6]
        found += [
            (extra[k], plain[k], swept_along_curves(k, share) - swept_along_curves(k, 1e6)) for k in rows
        ]
    whole, plain, expected = np.array(found).T
    assert np.abs(whole - expected).sum() < 0.15 * np.abs(plain - expected).sum()


# --- the lattice of a controller's cycle ------------------------------------------------------------------------------


def lattice(measured, resolution=1e-4):
    case = replace(CASE, measured=measured, resolution=resolution, derived={})
    term = load_term("cycle-quantisation")
    forms = term.forms(case)
    return float(term.guesses(forms[0], case)[0, 0]) if forms else None


@pytest.mark.parametrize("cycle", [0.004, 0.008, 0.010, 0.012, 0.016, 0.032])
def test_the_cycle_that_durations_are_multiples_of_is_found_and_no_part_of_it(cycle):
    rng = np.random.default_rng(int(cycle * 1e4))
    measured = np.round(rng.uniform(0.2, 2.5, len(CASE)) / cycle) * cycle + rng.normal(
        0, 0.03 * cycle, len(CASE)
    )
    assert lattice(measured) == pytest.approx(cycle, rel=1e-3)


def test_a_simulated_time_that_its_digits_put_on_a_multiple_is_rounded_as_it_was():
    """Two of 97 are printed as whole cycles, and were a little more: each was off by one, and led to another cycle."""
    rng, cycle = np.random.default_rng(5), 0.064
    own = rng.uniform(0.1, 2.0, 97)
    own[[20, 70]] = 2 * cycle + 3e-5, 9 * cycle + 2e-5
    moves = CASE.take(np.arange(97))
    measured = np.ceil(own / cycle) * cycle + rng.normal(0.0, 0.002, 97)
    case = replace(moves, simulated=np.round(own, 4), measured=measured, moving=np.ones(97, bool), derived={})
    term = load_term("cycle-quantisation")
    form = term.forms(case)[0]
    part = ModelPart(term, form, np.array([cycle]))
    assert np.abs(DurationModel((part,)).seconds(case) - measured).max() < 0.01
    tried = (
        fit(DurationModel((part._replace(values=one),)), case, Noise(1e-4), 30)
        for one in term.guesses(form, case)
    )
    best = min(tried, key=lambda one: one.bic)
    assert best.model.parts[0].values == pytest.approx([cycle], rel=1e-3)


def test_how_well_durations_fit_a_cycle_is_the_mean_of_their_turns():
    times = np.random.default_rng(3).uniform(0.2, 8.0, 40)
    for frequencies in (np.arange(4.0, 50.0, 0.04), np.linspace(10.0, 11.0, 81), np.array([3.0])):
        turns = [abs(np.exp(2j * np.pi * one * times).mean()) for one in frequencies]
        np.testing.assert_allclose(
            cycle_quantisation._coherence(times, frequencies, np.ones(len(times))), turns, atol=1e-10
        )


def test_no_cycle_is_found_in_durations_that_are_no_multiples():
    found = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        found.append(lattice(rng.uniform(0.2, 2.5, len(CASE))))
    assert found == [None] * 40


def test_the_clocks_own_digits_are_no_cycle():
    rng = np.random.default_rng(8)
    assert lattice(np.round(rng.uniform(0.2, 2.5, len(CASE)), 2), resolution=0.01) is None


@pytest.mark.parametrize(
    ("way", "speed", "slow", "time"), [(0.6, 0.5, 2.0, 0.1), (0.05, 0.8, 2.0, 0.15), (0.02, 0.1, 3.0, 0.2)]
)
def test_a_ramp_behind_a_moving_average_takes_its_length_longer_and_covers_half_of_its_speed(
    way, speed, slow, time
):
    """Ramps sampled finely and averaged; the peak of short moves is searched for, and the rest of the way cruised."""
    step = 1e-5

    def ramp(peak):
        plain = np.clip(np.arange(0.0, peak / slow + 2 * time, step) * slow, 0.0, peak)
        window = round(time / step)
        total = np.cumsum(np.concatenate([np.zeros(window), plain]))
        seen = (total[window:] - total[:-window]) / window
        until = int(np.argmax(seen > peak * (1.0 - 1e-9)))
        return until * step, float(seen[:until].sum() * step)

    low, high = 0.0, speed
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if 2.0 * ramp(middle)[1] > way else (middle, high)
    lasts, covers = ramp(high)
    expected = 2.0 * lasts + (way - 2.0 * covers) / high
    one = Motion(*(np.array([v]) for v in (way, speed, slow, slow, np.inf, 0.0, 0.0, 0.0, 0.0, 1.0)))
    assert one.with_(filtered=np.array([time])).duration()[0] == pytest.approx(expected, abs=2e-3 * expected)
