"""A counter-example for every erratum of docs/thesis.md; the numbers in the names are the page's."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from olp.identification.apostolovic import adjusted_acceleration, bearing, interpolated_factor
from olp.timing.motion import load_model

CONSTANT, LINEAR = load_model("constant"), load_model("linear")
PAGE = Path(__file__).parent.parent / "docs" / "thesis.md"


def shortest_with_a_max(a: float, k1: float, k2: float) -> float:
    """Length [m] from which the highest acceleration is held for a while: twice the bracket of 4.56."""
    return 2 * a**3 * (1 / (6 * k1**2) + 1 / (2 * k1 * k2) + 1 / (3 * k2**2))


def discriminant(a: float, k1: float, k2: float, length: float) -> float:
    """C2² - 4 C1 C3 of 4.56, term by term as defined there."""
    c1, c2 = a / 2, a**2 / (2 * k1) + a**2 / k2
    c3 = a**3 / (6 * k1**2) + a**3 / (2 * k1 * k2) + a**3 / (3 * k2**2) - length / 2
    return c2**2 - 4 * c1 * c3


def test_every_erratum_of_the_page_has_a_test_and_every_test_an_erratum() -> None:
    rows = [int(number) for number in re.findall(r"^\| (\d+) \|.*\|$", PAGE.read_text("utf-8"), re.M)]
    assert rows == list(range(1, len(rows) + 1))
    tests = Path(__file__).parent
    names = [
        name
        for file in ("test_thesis_errata.py", "test_thesis_samples.py")
        for name in re.findall(r"^def test_e(\d\d)_", (tests / file).read_text("utf-8"), re.M)
    ]
    assert {int(name) for name in names} == set(rows)


# Section 4.2


def test_e01_a_start_speed_of_zero_is_as_good_as_a_positive_one() -> None:
    rest = CONSTANT.profile(0.9, 0.5, 0.8, 1.3, 0.0)
    assert rest.feasible.all()
    assert rest.durations[0, 0] == pytest.approx(0.5 / 0.8)


def test_e01_a_start_speed_above_the_highest_one_is_what_has_to_be_excluded() -> None:
    v0, v_max, a1 = 0.7, 0.5, 0.8
    assert (v_max - v0) / a1 < 0  # 4.5
    assert (v_max**2 - v0**2) / (2 * a1) < 0  # 4.7


def test_e02_the_deceleration_is_a_magnitude_and_the_acceleration_its_negative() -> None:
    profile = CONSTANT.profile(0.9, 0.5, 0.8, 1.3)
    braking = float(profile.starts[0, 2]) + 0.01
    assert profile.acceleration(braking) == pytest.approx(-1.3)


def test_e03_without_room_to_brake_the_triangle_has_a_negative_acceleration_stage() -> None:
    v0, a1, a3, length = 0.5, 0.8, 1.3, 0.07
    assert length < v0**2 / (2 * a3)
    v = np.sqrt((2 * length * a1 * a3 + v0**2 * a3) / (a1 + a3))  # 4.19
    assert v < v0
    assert (v**2 - v0**2) / (2 * a1) < 0  # 4.7
    assert not CONSTANT.profile(length, 5.0, a1, a3, v0).feasible.any()


def test_e04_table_4_1_needs_the_reached_speed_in_its_triangular_column() -> None:
    v_max, a1, a3, length = 0.5, 0.8, 1.3, 0.09
    assert v_max**2 / (2 * a1) + v_max**2 / (2 * a3) > 2 * length  # the table's s1 + s3 with v_max
    v = np.sqrt(2 * length * a1 * a3 / (a1 + a3))
    assert v**2 / (2 * a1) + v**2 / (2 * a3) == pytest.approx(length)
    assert CONSTANT.profile(length, v_max, a1, a3).durations[0] == pytest.approx([v / a1, 0.0, v / a3])


def test_e05_where_acceleration_and_braking_just_fill_the_way_both_columns_agree() -> None:
    v_max, a1, a3 = 0.5, 0.8, 1.3
    length = v_max**2 / (2 * a1) + v_max**2 / (2 * a3)
    assert np.sqrt(2 * length * a1 * a3 / (a1 + a3)) == pytest.approx(v_max)  # 4.19
    assert CONSTANT.profile(length, v_max, a1, a3).durations[0, 1] == pytest.approx(0.0, abs=1e-12)


def test_e06_the_constant_speed_stage_of_section_4_3_is_the_fourth_of_seven() -> None:
    profile = LINEAR.profile(6.0, 0.7, 3.1, k1=11.0, k2=29.0)
    second, fourth = np.diff(profile.positions[0])[[1, 3]]
    assert profile.durations[0, 3] == pytest.approx(fourth / 0.7)
    assert profile.durations[0, 1] != pytest.approx(second / 0.7)  # 4.48 with the s2 of 4.47


# Section 4.3


def test_e07_equation_4_45_still_holds_v2_and_the_summary_is_what_its_text_announces() -> None:
    v_max, a, k2 = 0.7, 3.1, 29.0
    v2 = v_max - a**2 / (2 * k2)  # 4.42
    assert v2 * a / k2 + a**3 / (3 * k2**2) == pytest.approx(v_max * a / k2 - a**3 / (6 * k2**2))


def test_e08_braking_mirrors_acceleration_only_if_it_sets_in_at_k2() -> None:
    a, k1, k2 = 3.1, 11.0, 29.0
    profile = LINEAR.profile(6.0, 0.7, a, k1=k1, k2=k2)
    first, last = profile.positions[0, 3], 6.0 - profile.positions[0, 4]
    assert first == pytest.approx(last)
    assert profile.jerks[0, [4, 6]].tolist() == [-k2, k1]
    # Setting in at k1 it is the acceleration with time running forwards and the speed falling from v_max.
    forwards = 0.7 * profile.durations[0, :3].sum() - first
    assert abs(forwards - last) > 0.01 * last


def test_e08_braking_mirrors_acceleration_only_with_equal_limits() -> None:
    positions = LINEAR.profile(6.0, 0.7, 3.1, 1.7, k1=11.0, k2=29.0).positions[0]
    assert abs(positions[3] - (6.0 - positions[4])) > 0.03


def test_e09_the_highest_speed_can_be_reached_without_the_highest_acceleration() -> None:
    v_max, a_max, k1, k2, length = 0.1, 4.0, 20.0, 30.0, 2.0
    assert v_max / a_max - a_max / 2 * (1 / k1 + 1 / k2) < 0  # 4.46: a negative time
    profile = LINEAR.profile(length, v_max, a_max, k1=k1, k2=k2)
    a = np.sqrt(2 * v_max / (1 / k1 + 1 / k2))  # 4.64 with v2 = v_max
    assert a < a_max
    assert profile.reached.all()
    s12 = a**3 / (6 * k1**2) + a**3 / k2 * (1 / (2 * k1) + 1 / (3 * k2))  # 4.62 + 4.65
    cruise = (length - 2 * s12) / v_max
    assert profile.durations[0] == pytest.approx([a / k1, 0, a / k2, cruise, a / k2, 0, a / k1])


def test_e10_case_2_ends_where_the_constant_sub_stage_vanishes() -> None:
    a, k1, k2 = 3.1, 11.0, 29.0
    lengths = shortest_with_a_max(a, k1, k2) * np.array([0.9, 1.1])
    below, above = LINEAR.profile(lengths, 100.0, a, k1=k1, k2=k2).durations[:, 1]
    assert below == 0.0
    assert above > 0.0
    # Below it the quadratic equation still has real roots, but both are negative times.
    assert discriminant(a, k1, k2, lengths[0]) > 0
    c2 = a**2 / (2 * k1) + a**2 / k2
    assert -c2 + np.sqrt(discriminant(a, k1, k2, lengths[0])) < 0


def test_e11_case_2_needs_the_constant_sub_stage_from_4_35_not_from_4_47() -> None:
    v_max, a, k1, k2 = 100.0, 3.1, 11.0, 29.0
    length = 1.4 * shortest_with_a_max(a, k1, k2)
    profile = LINEAR.profile(length, v_max, a, k1=k1, k2=k2)
    s2 = float(np.diff(profile.positions[0])[1])
    t2 = float(profile.durations[0, 1])
    assert s2 == pytest.approx(a**2 / (2 * k1) * t2 + a * t2**2 / 2)  # 4.35
    s = 1 / k1 + 1 / k2
    full = v_max**2 / (2 * a) - v_max * a / (2 * k2) - a**3 / (4 * k1) * s + a**3 / 8 * s**2  # 4.47
    assert full > 1000 * length


def test_e12_only_the_root_with_the_plus_sign_is_a_time() -> None:
    a, k1, k2 = 3.1, 11.0, 29.0
    c2 = a**2 / (2 * k1) + a**2 / k2
    for factor in (1.001, 1.4, 50.0):
        root = np.sqrt(discriminant(a, k1, k2, factor * shortest_with_a_max(a, k1, k2)))
        assert (-c2 - root) / a < 0 < (-c2 + root) / a


def test_e13_the_length_enters_the_discriminant_with_a_plus() -> None:
    a, k1, k2, length = 3.1, 11.0, 29.0, 0.8
    ks = -1 / (12 * k1**2) + 1 / (3 * k2**2)
    assert discriminant(a, k1, k2, length) == pytest.approx(a**4 * ks + a * length)
    assert discriminant(a, k1, k2, length) != pytest.approx(a**4 * ks - a * length)  # 4.57 as printed


def test_e14_dividing_4_57_by_the_length_does_not_lose_it() -> None:
    a, k1, k2, length = 3.1, 29.0, 11.0, 0.8
    ks = (4 * k1**2 - k2**2) / (12 * k1**2 * k2**2)
    assert a**3 / length * ks > 0  # the line after 4.57 says that it holds ...
    assert a**4 * ks - a * length < 0  # ... where 4.57 as printed does not


def test_e15_case_2_exists_where_k1_is_less_than_half_of_k2() -> None:
    a, k1, k2 = 3.1, 4.0, 40.0
    assert not k1 > k2 / 2  # 4.58 and section 4.3.4.5 forbid it
    length = 1.4 * shortest_with_a_max(a, k1, k2)
    profile = LINEAR.profile(length, 100.0, a, k1=k1, k2=k2)
    assert profile.durations[0, 1] > 0
    t = np.linspace(0, 1, 200001) * profile.duration[0]
    speed = profile.speed(t[None, :])[0]
    assert np.trapezoid(speed, t) == pytest.approx(length, rel=1e-8)
    assert profile.acceleration(t[None, :]).max() == pytest.approx(a)


def test_e15_the_discriminant_is_positive_for_every_pair_of_rates() -> None:
    rng = np.random.default_rng(3)
    for a, k1, k2, more in 10 ** rng.uniform(-2, 2, (500, 4)):
        length = shortest_with_a_max(a, k1, k2) * (1 + more)
        assert discriminant(a, k1, k2, length) > (a**2 / (2 * k1) + a**2 / k2) ** 2 * (1 - 1e-9)


def test_e16_the_denominator_of_4_66_is_positive_for_every_pair_of_positive_rates() -> None:
    rng = np.random.default_rng(4)
    k1, k2 = 10 ** rng.uniform(-3, 3, (2, 1000))
    assert ((2 * k1 + k2) * (k1 + k2) > 0).all()
    assert not ((2 * k1 + k2 < 0) & (k1 + k2 < 0)).any()  # the second alternative of 4.68
    assert not ((2 * k1 - k2 < 0) & (2 * k1 + k2 < 0)).any()  # the second alternative of 4.59
    assert np.isfinite(LINEAR.profile(1e-6, 9.0, 9.0, k1=k1, k2=k2).duration).all()


def test_e17_rising_speed_of_case_3_comes_from_4_61() -> None:
    a, k1, k2 = 0.6, 11.0, 29.0
    v1 = a**2 / (2 * k1)  # 4.61; 4.59 is a condition on k1 and k2 and gives no speed
    assert v1 + a**2 / (2 * k2) == pytest.approx(a**2 / 2 * (1 / k1 + 1 / k2))  # 4.64


def test_e18_in_special_case_1_acceleration_is_constant_in_the_second_and_fifth_sub_stage() -> None:
    v_max, a, k1, k2 = 0.7, 3.1, 11.0, 29.0
    length = 2 * float(LINEAR.profile(99.0, v_max, a, k1=k1, k2=k2).positions[0, 3])
    profile = LINEAR.profile(length, v_max, a, k1=k1, k2=k2)
    lasting = [i for i, t in enumerate(profile.durations[0]) if t > 1e-9]
    assert len(lasting) == 6
    assert [n for n, i in enumerate(lasting, 1) if profile.jerks[0, i] == 0] == [2, 5]
    assert profile.durations[0, 1] == pytest.approx(v_max / a - a / 2 * (1 / k1 + 1 / k2))  # 4.46: known


# Section 4.4


def tracked(dt: float, speed_first: bool) -> tuple[list[float], list[float]]:
    """Step 3 of the tracking for 0.75 s at 0.4 m/s²: times [s] and positions [m]."""
    v = q = t = 0.0
    times, positions = [0.0], [0.0]
    while t < 0.75 - dt / 2:
        if speed_first:
            v += 0.4 * dt
        q += v * dt + 0.4 * dt**2 / 2
        if not speed_first:
            v += 0.4 * dt
        t += dt
        times.append(t)
        positions.append(q)
    return times, positions


def test_e19_tracking_has_to_move_before_it_changes_the_speed() -> None:
    dt, profile = 0.004, CONSTANT.profile(0.64, 0.3, 0.4)
    times, right = tracked(0.75 / 188, speed_first=False)
    assert right == pytest.approx(profile.position([times])[0], abs=1e-12)
    times, wrong = tracked(0.75 / 188, speed_first=True)
    # In the printed order the tracked robot is ahead by v_max times the step: 1.2 mm at 4 ms and 300 mm/s.
    assert wrong[-1] - right[-1] == pytest.approx(0.3 * dt, rel=0.01)


def test_e20_the_constant_speed_step_has_to_add_to_the_position() -> None:
    profile, dt = CONSTANT.profile(0.64, 0.3, 0.4), 0.004
    before, after = profile.position([[1.0, 1.0 + dt]])[0]
    assert after == pytest.approx(before + 0.3 * dt)
    assert 0.3 * dt < 0.01 * after  # q = v Δt, as printed, throws the robot back to its start


def test_e21_the_braking_step_needs_the_acceleration() -> None:
    profile, dt = CONSTANT.profile(0.64, 0.3, 0.4), 0.004
    t = float(profile.starts[0, 2]) + 0.1
    (before, after), (speed, _) = profile.position([[t, t + dt]])[0], profile.speed([[t, t + dt]])[0]
    assert after == pytest.approx(before + speed * dt - 0.4 * dt**2 / 2, abs=1e-14)
    # Without it the equation changes with the unit of length, so it cannot be one: in millimetres it is right by
    # luck at 1 mm/s² and 400 times too small here.
    assert after != pytest.approx(before + speed * dt - dt**2 / 2, abs=1e-6)


def test_e22_each_coordinate_moves_at_its_share_of_the_speed() -> None:
    way = np.array([-0.640, -0.560, 0.0])
    shares = way / np.linalg.norm(way)
    assert np.linalg.norm(0.3 * shares) == pytest.approx(0.3)
    assert np.linalg.norm(0.3 * np.ones(3)) == pytest.approx(0.3 * np.sqrt(3))  # v_i = v_max, as printed


# Chapter 5


def torque_1_at_rest(t1: float, t2: float, *, as_printed: bool) -> float:
    """Torque [Nm] that holds joint 1 of the two-link arm: the gravity terms of section 5.2.1."""
    m1, m2, l1, lg1, lg2, g = 3.1, 2.3, 0.71, 0.33, 0.27, 9.81
    last = lg1 if as_printed else lg2
    return m1 * g * lg1 * np.cos(t1) + m2 * g * (l1 * np.cos(t1) + last * np.cos(t1 + t2))


def height_energy(t1: float, t2: float) -> float:
    """Potential energy [J] of the same arm."""
    m1, m2, l1, lg1, lg2, g = 3.1, 2.3, 0.71, 0.33, 0.27, 9.81
    return g * (m1 * lg1 * np.sin(t1) + m2 * (l1 * np.sin(t1) + lg2 * np.sin(t1 + t2)))


def test_e23_the_second_link_is_lifted_by_its_own_lever() -> None:
    t1, t2, h = 0.4, 0.9, 1e-6
    slope = (height_energy(t1 + h, t2) - height_energy(t1 - h, t2)) / (2 * h)
    assert torque_1_at_rest(t1, t2, as_printed=False) == pytest.approx(slope, rel=1e-8)
    assert abs(torque_1_at_rest(t1, t2, as_printed=True) - slope) > 0.1


def two_link_torques(q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
    """Both torques of section 5.2.1 with the corrected lever, without gravity [Nm]."""
    m1, m2, l1, lg1, lg2, i1, i2 = 3.1, 2.3, 0.71, 0.33, 0.27, 0.05, 0.04
    c, s = np.cos(q[1]), np.sin(q[1])
    m12 = m2 * (lg2**2 + l1 * lg2 * c) + i2
    m11 = m1 * lg1**2 + i1 + m2 * (l1**2 + lg2**2 + 2 * l1 * lg2 * c) + i2
    h = m2 * l1 * lg2 * s
    first = m11 * qdd[0] + m12 * qdd[1] - h * (2 * qd[0] * qd[1] + qd[1] ** 2)
    return np.array([first, m12 * qdd[0] + (m2 * lg2**2 + i2) * qdd[1] + h * qd[0] ** 2])


def two_link_energy(q: np.ndarray, qd: np.ndarray) -> float:
    """Kinetic energy [J] of the two-link arm, from the speeds of the links' centres."""
    m1, m2, l1, lg1, lg2, i1, i2 = 3.1, 2.3, 0.71, 0.33, 0.27, 0.05, 0.04
    both = q[0] + q[1]
    x = -l1 * np.sin(q[0]) * qd[0] - lg2 * np.sin(both) * qd.sum()
    y = l1 * np.cos(q[0]) * qd[0] + lg2 * np.cos(both) * qd.sum()
    first = m1 * (lg1 * qd[0]) ** 2 + i1 * qd[0] ** 2
    return float(first + m2 * (x**2 + y**2) + i2 * qd.sum() ** 2) / 2


def test_e23_the_other_terms_of_the_two_link_arm_are_right() -> None:
    q, qd, qdd, h = np.array([0.4, 0.9]), np.array([1.1, -0.7]), np.array([2.0, 3.0]), 1e-5
    after = two_link_energy(q + h * qd + h**2 * qdd / 2, qd + h * qdd)
    before = two_link_energy(q - h * qd + h**2 * qdd / 2, qd - h * qdd)
    assert (after - before) / (2 * h) == pytest.approx(two_link_torques(q, qd, qdd) @ qd, rel=1e-7)


def test_e24_a_move_and_its_way_back_have_the_same_bearing() -> None:
    assert bearing(-0.640, -0.050) == bearing(0.640, 0.050)


def test_e24_the_same_direction_has_another_sign_in_approach_and_depart() -> None:
    towards_minus_y = -0.050
    assert bearing(-0.640, towards_minus_y) > 0 > bearing(0.640, towards_minus_y)


def test_e25_the_incline_cannot_be_had_from_equation_5_2_as_it_stands() -> None:
    start, end = np.array([1.350, 0.700, 0.740]), np.array([1.350, 0.650, 0.100])  # table A.14, TP1
    step = end - start
    assert step[0] == 0  # the divisor of 5.2
    assert np.degrees(bearing(step[2], step[1])) == pytest.approx(
        4.47, abs=0.005
    )  # measured from the vertical


# Chapter 6


def test_e26_equation_6_1_holds_only_up_to_twice_the_time_at_full_speed() -> None:
    length, v = 0.640, 0.3
    slow = np.array([1.2, 2.0, 2.5]) * length / v
    printed = v**2 / (slow * v - length)
    got = CONSTANT.profile(length, v, printed)
    assert got.reached.tolist() == [True, True, False]
    assert got.duration[:2] == pytest.approx(slow[:2])
    assert abs(got.duration[2] - slow[2]) > 0.1
    right = adjusted_acceleration(slow, length, v)
    assert CONSTANT.profile(length, v, right).duration == pytest.approx(slow)


def test_e26_no_acceleration_makes_a_move_in_less_than_length_over_speed() -> None:
    assert np.isnan(adjusted_acceleration([2.0, 0.640 / 0.3], 0.640, 0.3)).all()


def test_e27_the_third_decimal_of_the_example_comes_from_rounded_factors() -> None:
    a = adjusted_acceleration([2.66, 2.70], np.hypot(0.640, [0.05, 0.10]), 0.3)  # table A.7, TP1 and TP2
    angles = [4.47, 8.88]
    assert interpolated_factor(7.0, angles, [1.44, 1.39]) == pytest.approx(1.411, abs=5e-4)
    assert interpolated_factor(7.0, angles, a / 0.4) == pytest.approx(1.4103, abs=5e-5)


def test_e27_equation_6_3_has_nothing_to_say_outside_its_table() -> None:
    assert np.isnan(interpolated_factor([-1.0, 50.0], [0.0, 47.56], [1.48, 0.92])).all()


def corrected(a: np.ndarray, c_h: float, c_v: float) -> float:
    """The square of 6.18 as printed."""
    return float(c_h**2 * a[0] ** 2 + (c_h**2 + c_v**2 - 1) * a[1] ** 2 + c_v**2 * a[2] ** 2)


def test_e28_equal_factors_in_both_planes_do_not_correct_by_that_factor() -> None:
    along_y = np.array([0.0, 0.4, 0.0])
    c = 1.48
    assert np.sqrt(corrected(along_y, c, c)) / 0.4 == pytest.approx(np.sqrt(2 * c**2 - 1))
    assert np.sqrt(2 * c**2 - 1) == pytest.approx(1.8387, abs=1e-4)  # instead of 1.48
    for share in pairwise([0.0, 0.3, 0.6, 1.0]):
        less, more = (0.4 * np.array([np.sqrt(1 - s**2), s, 0.0]) for s in share)
        assert corrected(less, c, c) < corrected(more, c, c)  # the same in every direction would be right


def test_e28_a_vector_without_a_y_component_is_corrected_as_announced() -> None:
    assert np.sqrt(corrected(np.array([0.4, 0.0, 0.0]), 1.48, 1.2)) == pytest.approx(1.48 * 0.4)
    assert np.sqrt(corrected(np.array([0.0, 0.0, 0.4]), 1.48, 1.2)) == pytest.approx(1.2 * 0.4)


def test_e28_small_factors_give_the_root_of_a_negative_number() -> None:
    assert corrected(np.array([0.0, 0.4, 0.0]), 0.7, 0.7) < 0


def test_e29_a_product_of_factors_corrects_the_same_motion_twice() -> None:
    # A move along Y lies in the horizontal and in the vertical test plane: 6.1 gives one C for both.
    length, v, measured = 0.640, 0.3, 2.64
    c = float(adjusted_acceleration(measured, length, v)) / 0.4
    assert CONSTANT.profile(length, v, 0.4 * c).duration == pytest.approx(measured)
    assert CONSTANT.profile(length, v, 0.4 * c * c).duration < measured - 0.1  # 6.19 with C_H = C_V = C
