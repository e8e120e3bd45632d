"""The equations of Apostolovic's thesis, chapter 4, that are right, against integration and the motion models."""

from __future__ import annotations

import numpy as np
import pytest

from olp.timing.motion import load_model

CONSTANT, LINEAR = load_model("constant"), load_model("linear")
SETTINGS = [(0.7, 3.1, 11.0, 29.0), (0.5, 2.2, 31.0, 9.0), (1.3, 0.9, 4.0, 3.7)]  # v_max, a_max, k1, k2
each_setting = pytest.mark.parametrize(("v_max", "a", "k1", "k2"), SETTINGS)


def driven(
    jerks: list[float], times: list[float], a0: float = 0.0, v0: float = 0.0
) -> list[tuple[float, float]]:
    """Speed and distance after each phase of constant jerk, added up in small steps (midpoint rule)."""
    a, v, s, n, states = a0, v0, 0.0, 2000, []
    for jerk, time in zip(jerks, times, strict=True):
        dt = time / n
        for _ in range(n):
            s += dt * (v + dt / 2 * (a + jerk * dt / 3))
            v += dt * (a + jerk * dt / 2)
            a += jerk * dt
        states.append((v, s))
    return states


def test_stages_of_constant_acceleration_with_a_start_speed() -> None:
    v0, v_max, a1, a3, length = 0.12, 0.5, 0.8, 1.3, 0.9
    t1, t3 = (v_max - v0) / a1, v_max / a3  # 4.5, 4.12
    s1, s3 = (v_max**2 - v0**2) / (2 * a1), v_max**2 / (2 * a3)  # 4.7, 4.14
    s2 = length - (v_max**2 - v0**2) / (2 * a1) - v_max**2 / (2 * a3)  # 4.16
    profile = CONSTANT.profile(length, v_max, a1, a3, v0)
    assert profile.durations[0] == pytest.approx([t1, s2 / v_max, t3])
    assert np.diff(profile.positions[0]) == pytest.approx([s1, s2, s3])


def test_peak_of_the_triangle_with_a_start_speed() -> None:
    v0, a1, a3, length = 0.12, 0.8, 1.3, 0.09
    v = np.sqrt((2 * length * a1 * a3 + v0**2 * a3) / (a1 + a3))  # 4.19
    assert CONSTANT.profile(length, 5.0, a1, a3, v0).peak_speed == pytest.approx(v)


@each_setting
def test_sub_stages_of_the_acceleration(v_max: float, a: float, k1: float, k2: float) -> None:
    t1, t3 = a / k1, a / k2  # 4.23, 4.39
    t2 = v_max / a - a / 2 * (1 / k1 + 1 / k2)  # 4.46
    assert t2 > 0
    v1 = a**2 / (2 * k1)  # 4.26
    v2 = v_max - a**2 / (2 * k2)  # 4.42
    s1 = a**3 / (6 * k1**2)  # 4.29
    s2 = v1 * t2 + a * t2**2 / 2  # 4.35
    s3 = v2 * t3 + a * t3**2 / 2 - k2 * t3**3 / 6  # 4.44
    states = driven([k1, 0.0, -k2], [t1, t2, t3])
    assert [v for v, _ in states] == pytest.approx([v1, v2, v_max])
    assert [s for _, s in states] == pytest.approx([s1, s1 + s2, s1 + s2 + s3])
    profile = LINEAR.profile(50.0, v_max, a, k1=k1, k2=k2)
    assert profile.durations[0, :3] == pytest.approx([t1, t2, t3])
    assert np.diff(profile.positions[0, :4]) == pytest.approx([s1, s2, s3])


@each_setting
def test_length_of_the_constant_sub_stage_is_right_as_printed(
    v_max: float, a: float, k1: float, k2: float
) -> None:
    s = 1 / k1 + 1 / k2
    t2 = v_max / a - a / 2 * s
    by_time = a**2 / (2 * k1) * t2 + a * t2**2 / 2  # 4.35 with 4.26
    printed = v_max**2 / (2 * a) - v_max * a / (2 * k2) - a**3 / (4 * k1) * s + a**3 / 8 * s**2  # 4.47
    assert printed == pytest.approx(by_time)


@each_setting
def test_case_1_cruises_over_the_rest_of_the_way(v_max: float, a: float, k1: float, k2: float) -> None:
    profile = LINEAR.profile(6.0, v_max, a, k1=k1, k2=k2)
    s4 = 6.0 - 2 * profile.positions[0, 3]  # 4.51
    assert profile.durations[0, 3] == pytest.approx(s4 / v_max)  # 4.52
    assert profile.positions[0, 4] - profile.positions[0, 3] == pytest.approx(s4)


@each_setting
def test_case_2_by_the_quadratic_equation_as_printed(v_max: float, a: float, k1: float, k2: float) -> None:
    shortest = 2 * a**3 * (1 / (6 * k1**2) + 1 / (2 * k1 * k2) + 1 / (3 * k2**2))
    length = 1.4 * shortest
    c1, c2, c3 = a / 2, a**2 / (2 * k1) + a**2 / k2, shortest / 2 - length / 2  # 4.56
    t = (-c2 + np.sqrt(c2**2 - 4 * c1 * c3)) / (2 * c1)
    profile = LINEAR.profile(length, 100.0, a, k1=k1, k2=k2)
    v2 = a**2 / (2 * k1) + a * t  # 4.33
    assert profile.durations[0] == pytest.approx([a / k1, t, a / k2, 0.0, a / k2, t, a / k1])
    assert profile.peak_speed == pytest.approx(v2 + a**2 / (2 * k2))  # 4.53
    s3 = v2 * a / k2 + a**3 / (3 * k2**2)  # 4.54
    assert profile.positions[0, 3] - profile.positions[0, 2] == pytest.approx(s3)


@each_setting
def test_case_3_by_the_cube_root_as_printed(v_max: float, a: float, k1: float, k2: float) -> None:
    shortest = 2 * a**3 * (1 / (6 * k1**2) + 1 / (2 * k1 * k2) + 1 / (3 * k2**2))
    length = 0.6 * shortest
    peak = np.cbrt(3 * length * k1**2 * k2**2 / ((2 * k1 + k2) * (k1 + k2)))  # 4.66
    v1, s1 = peak**2 / (2 * k1), peak**3 / (6 * k1**2)  # 4.61, 4.62
    v2, s2 = peak**2 / 2 * (1 / k1 + 1 / k2), peak**3 / k2 * (1 / (2 * k1) + 1 / (3 * k2))  # 4.64, 4.65
    states = driven([k1, -k2, -k2, k1], [peak / k1, peak / k2, peak / k2, peak / k1])
    assert states[0] == pytest.approx((v1, s1))
    assert states[1] == pytest.approx((v2, s1 + s2))
    assert states[3] == pytest.approx((0.0, length), abs=1e-9)
    profile = LINEAR.profile(length, 100.0, a, k1=k1, k2=k2)
    assert profile.peak_speed == pytest.approx(v2)
    assert profile.duration == pytest.approx(2 * peak * (1 / k1 + 1 / k2))


@each_setting
def test_the_special_cases_are_the_borders_between_the_cases(
    v_max: float, a: float, k1: float, k2: float
) -> None:
    shortest = 2 * a**3 * (1 / (6 * k1**2) + 1 / (2 * k1 * k2) + 1 / (3 * k2**2))
    around = shortest * np.array([1 - 1e-9, 1.0, 1 + 1e-9])
    second = LINEAR.profile(around, 100.0, a, k1=k1, k2=k2)
    assert np.ptp(second.duration) < 1e-6
    assert second.durations[:, 1] == pytest.approx(0.0, abs=1e-6)
    length = 2 * LINEAR.profile(99.0, v_max, a, k1=k1, k2=k2).positions[0, 3]
    first = LINEAR.profile(length * np.array([1 - 1e-9, 1.0, 1 + 1e-9]), v_max, a, k1=k1, k2=k2)
    assert np.ptp(first.duration) < 1e-6
    assert first.durations[:, 3] == pytest.approx(0.0, abs=1e-6)
