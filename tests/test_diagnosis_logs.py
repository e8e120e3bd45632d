"""Logs: what is planted by small time steps is named, with its number, and nothing else is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from olp.identification.diagnosis.logs import LogDiagnosis, diagnose_log, diagnose_logs
from olp.identification.diagnosis.logs.pairing import pair
from olp.identification.diagnosis.logs.select import LibraryColumn, best, gain, products
from olp.identification.diagnosis.logs.series import (
    Grid,
    Spectrum,
    autoregression,
    dropped,
    even,
    gaps,
    hermite,
    kept,
    runs,
    whiten,
)
from olp.identification.diagnosis.logs.statistics import false_discovery, student_quantile, student_tail
from olp.identification.recording import Log
from olp.identification.recording.writer import log_csv
from olp.robots.robot import load_robot
from olp.timing.physics.backlash import play
from olp.timing.physics.servo_lag import lag
from olp.timing.physics.term import LogTerm, load_term

Floats = NDArray[np.float64]
FINE, STEP = 0.001, 0.004  # [s] of the simulated physics, and of the logs
AXES = 3


def program(seed: int, moves: int = 9, axes: int = AXES) -> tuple[Floats, Floats]:
    """Times (n,) and commanded axes (n, k) every millisecond: jerk-limited moves between random points, with rests."""
    rng = np.random.default_rng(seed)
    at = np.zeros(axes)
    parts = [np.repeat(at[None], 400, axis=0)]
    for _ in range(moves):
        to = rng.uniform(-1.2, 1.2, axes)
        far, top, rise = np.abs(to - at).max(), rng.uniform(0.4, 1.5), rng.uniform(3.0, 6.0)
        top = min(top, np.sqrt(rise * far))
        ramp, whole = top / rise, far / top + top / rise
        t = np.arange(0, whole + FINE, FINE)
        way = np.clip(np.where(t < ramp, rise * t**2 / 2, rise * ramp**2 / 2 + top * (t - ramp)), 0, None)
        way = np.where(t > whole - ramp, far - rise * np.clip(whole - t, 0, None) ** 2 / 2, way)
        parts.append(at + (to - at) * np.clip(way / far, 0, 1)[:, None])
        at = to
        parts.append(np.repeat(at[None], rng.integers(60, 450), axis=0))
    ways = np.concatenate(parts)
    window = 50
    wide = np.concatenate([np.repeat(ways[:1], window, 0), ways, np.repeat(ways[-1:], window, 0)])
    even_ramp = np.ones(window) / window
    smooth = [np.convolve(wide[:, j], even_ramp, "same")[window:-window] for j in range(axes)]
    return np.arange(len(ways)) * FINE, np.stack(smooth, axis=1)


def lagging(ways: Floats, constants: tuple[float, ...]) -> Floats:
    """T q' + q = command, by the trapezoid rule."""
    found = ways.copy()
    for j, constant in enumerate(constants):
        q, before = ways[0, j], ways[0, j]
        a = FINE / 2 / constant
        for i, now in enumerate(ways[:, j].tolist()):
            q = (q * (1 - a) + a * (before + now)) / (1 + a)
            before, found[i, j] = now, q
    return found


def swinging(ways: Floats, axis: int, hertz: float, damping: float) -> Floats:
    """A mass behind a spring and a damper, in steps of an eighth of a millisecond (midpoint rule)."""
    found, w, h = ways.copy(), 2 * np.pi * hertz, FINE / 8
    motor, speed = ways[:, axis], np.gradient(ways[:, axis], FINE)
    q, v = float(motor[0]), 0.0
    for i in range(len(motor) - 1):
        for k in range(8):
            u = (k + 0.5) / 8
            m, s = motor[i] * (1 - u) + motor[i + 1] * u, speed[i] * (1 - u) + speed[i + 1] * u
            middle, rate = q + v * h / 2, v + (w * w * (m - q) + 2 * damping * w * (s - v)) * h / 2
            q, v = q + rate * h, v + (w * w * (m - middle) + 2 * damping * w * (s - rate)) * h
        found[i + 1, axis] = q
    return found


def loose(ways: Floats, axis: int, width: float) -> Floats:
    """The axis moves only when a flank of the play pushes it."""
    found, at = ways.copy(), float(ways[0, axis])
    for i, motor in enumerate(ways[:, axis].tolist()):
        at = min(max(at, motor - width / 2), motor + width / 2)
        found[i, axis] = at
    return found


def sampled(time: Floats, ways: Floats, late: float = 0.0) -> Floats:
    """(n, k) every fourth instant, `late` [s]."""
    at = time[::4] - late
    return np.stack([np.interp(at, time, column) for column in ways.T], axis=1)


def against_command(
    seed: int, change=lambda ways: ways, late: float = 0.0, noise: float = 2e-5, moves: int = 9
) -> Log:  # type: ignore[no-untyped-def]
    time, ways = program(seed, moves)
    rng = np.random.default_rng(seed + 1000)
    q = sampled(time, change(ways), late)
    return Log(
        time[::4],
        q + noise * rng.normal(size=q.shape),
        (False,) * AXES,
        command=sampled(time, ways),
    )


def against_simulation(log: Log) -> tuple[Log, Log]:
    """The same as a log without commands and a simulated log."""
    assert log.command is not None
    return replace(log, command=None), Log(log.time, log.command, log.slides)


def names(found: LogDiagnosis) -> set[str]:
    return {finding.term for finding in found.findings}


def number(found: LogDiagnosis, term: str, name: str) -> tuple[float, float, float]:
    finding = found.finding(term)
    assert finding is not None
    p = finding.parameters[name]
    return p.value, p.low, p.high


# Nothing planted


@pytest.mark.slow("1")
@pytest.mark.parametrize("seed", range(2))
def test_nothing_planted_nothing_named(seed: int) -> None:
    log = against_command(seed)
    for found in (diagnose_log(log), diagnose_log(*against_simulation(log))):
        assert names(found) == set()
        assert found.verdict == "no-mismatch"


def recorded(seed: int, kind: str) -> Log:
    """A log as a recorder of some kind writes it."""
    rng = np.random.default_rng(seed)
    time, ways = program(seed)
    at = time[::4]
    if kind == "jitter":
        at = at + rng.uniform(-3e-4, 3e-4, len(at))
    q = np.stack([np.interp(at, time, column) for column in ways.T], axis=1)
    if kind != "exact":
        q = q + 2e-5 * rng.normal(size=q.shape)
    if kind == "digits":
        q = np.round(np.degrees(q), 2) / 57.29577951308232
    log = Log(at, q, (False,) * AXES)
    if kind == "torques":
        rise = np.gradient(np.gradient(q, STEP, axis=0), STEP, axis=0)
        log = replace(log, torque=40.0 * rise + 30.0 * np.cos(q) + 0.1 * rng.normal(size=q.shape))
    if kind == "encoders":
        links = {f"q{j + 1}_link_deg": np.degrees(np.interp(at - 0.003, at, q[:, j])) for j in range(AXES)}
        log = replace(log, covariates=links)
    if kind == "gaps":
        keep = rng.random(len(at)) > 0.03
        log = Log(at[keep], q[keep], log.slides)
    return log


@pytest.mark.slow("noise", "jitter", "torques", "gaps")
@pytest.mark.parametrize("kind", ["exact", "noise", "jitter", "digits", "torques", "encoders", "gaps"])
def test_a_log_against_itself_is_no_mismatch(kind: str) -> None:
    log = recorded(30, kind)
    found = diagnose_log(log, log)
    assert (found.verdict, names(found)) == ("no-mismatch", set())
    assert not any("inertia or gravity" in note for note in found.notes)


def test_simulated_torques_are_used_of_the_axes_that_have_them() -> None:
    log = recorded(31, "torques")
    assert log.torque is not None
    planned, measured = log.torque.copy(), log.torque + 3.0 * np.sign(np.gradient(log.q, axis=0))
    planned[:, 2] = np.nan
    measured[:, 1] = np.nan
    found = diagnose_log(replace(log, torque=measured), replace(log, torque=planned))
    assert "axis 2 has no torque in the log" in found.notes
    assert any("no simulated torques of axes 3" in note for note in found.notes)
    assert {e.axis for e in found.evidence if e.term == "coulomb-friction"} >= {1}
    told = next(e for e in found.evidence if e.axis == 1)
    assert told.heldout_after < 0.5 * told.heldout_before


def test_noise_whose_neighbours_go_together_is_not_named() -> None:
    log = against_command(7, noise=0.0)
    rng = np.random.default_rng(1)
    noise = np.zeros_like(log.q)
    for i in range(1, len(noise)):
        noise[i] = 0.97 * noise[i - 1] + 5e-6 * rng.normal(size=AXES)
    assert names(diagnose_log(replace(log, q=log.q + noise))) == set()


def test_other_clocks_alone_are_no_fault_when_they_never_meant_to_agree() -> None:
    log, sim = against_simulation(against_command(2))
    found = diagnose_log(replace(log, time=log.time + 1.7e9), sim)
    assert names(found) == set()


def test_a_log_that_is_too_short_says_so() -> None:
    log = against_command(0)
    short = replace(log, time=log.time[:100], q=log.q[:100], command=None)
    found = diagnose_log(short)
    assert not found.findings
    assert "100 samples" in found.notes[0]


# One thing planted


@pytest.mark.slow("constants0", "constants2")
@pytest.mark.parametrize("constants", [(0.02, 0.035, 0.012), (0.003, 0.002, 0.004), (0.015, 0.015, 0.015)])
def test_a_servo_lag_is_named_with_its_time_constants(constants: tuple[float, ...]) -> None:
    log = against_command(3, lambda ways: lagging(ways, constants))
    for found in (diagnose_log(log), diagnose_log(*against_simulation(log))):
        assert names(found) == {"servo-lag"}
        assert found.verdict == "explained"
        for axis, constant in enumerate(constants, 1):
            value, low, high = number(found, "servo-lag", f"time constant of axis {axis}")
            assert value == pytest.approx(constant, rel=0.01)
            assert low < high


@pytest.mark.slow("9.0-0.05")
@pytest.mark.parametrize(("hertz", "damping"), [(9.0, 0.05), (17.0, 0.02)])
def test_an_oscillation_is_named_with_frequency_and_damping_on_its_axis_alone(
    hertz: float, damping: float
) -> None:
    log = against_command(4, lambda ways: swinging(ways, 1, hertz, damping))
    for found in (diagnose_log(log), diagnose_log(*against_simulation(log))):
        assert names(found) == {"joint-compliance"}
        assert {e.axis for e in found.evidence} == {2}
        assert number(found, "joint-compliance", "frequency of axis 2")[0] == pytest.approx(hertz, rel=0.01)
        assert number(found, "joint-compliance", "damping of axis 2")[0] == pytest.approx(damping, rel=0.1)


def test_play_is_named_with_its_width() -> None:
    log = against_command(5, lambda ways: loose(ways, 2, 4e-4))
    for found in (diagnose_log(log), diagnose_log(*against_simulation(log))):
        assert names(found) == {"backlash"}
        assert number(found, "backlash", "play of axis 3")[0] == pytest.approx(4e-4, rel=0.03)


# Clocks


def test_channels_of_different_instants_are_a_clock_and_no_lag() -> None:
    found = diagnose_log(against_command(6, late=0.003))
    assert names(found) == {"clock"}
    assert found.verdict == "explained"
    value, low, high = number(found, "clock", "q behind q_cmd")
    assert low < 0.003 < high
    assert value == pytest.approx(0.003, abs=1e-5)


def test_an_offset_of_the_recorder_is_a_clock() -> None:
    log, sim = against_simulation(against_command(8))
    found = diagnose_log(replace(log, time=log.time + 0.0213), sim)
    assert names(found) == {"clock"}
    assert number(found, "clock", "log behind simulation")[0] == pytest.approx(0.0213, abs=2e-5)


def test_a_recorder_that_starts_long_before_the_simulation_is_a_clock_and_no_lag() -> None:
    log, sim = against_simulation(against_command(8))
    found = diagnose_log(replace(log, time=log.time + 0.31), sim)
    assert names(found) == {"clock"}
    assert number(found, "clock", "log behind simulation")[0] == pytest.approx(0.31, abs=2e-5)


def test_the_noise_of_an_axis_that_stands_still_does_not_hide_where_the_others_move_alike() -> None:
    log, sim = against_simulation(against_command(8))
    rest = np.zeros((len(sim), 1))
    noise = 5e-5 * np.random.default_rng(3).normal(size=rest.shape)
    slides = (*log.slides, False)
    late = replace(log, time=log.time + 0.0213, q=np.hstack([log.q, rest + noise]), slides=slides)
    found = diagnose_log(late, replace(sim, q=np.hstack([sim.q, rest]), slides=slides))
    assert names(found) == {"clock"}
    assert number(found, "clock", "log behind simulation")[0] == pytest.approx(0.0213, abs=2e-5)


@pytest.mark.slow("0.99", "1.00004")
@pytest.mark.parametrize("rate", [1.0005, 0.99, 1.00004])
def test_a_recorder_that_runs_at_another_rate_is_a_clock_and_nothing_else(rate: float) -> None:
    log, sim = against_simulation(against_command(9))
    found = diagnose_log(replace(log, time=log.time * rate), sim)
    assert names(found) == {"clock"}
    assert found.clocks[0].rate_significant
    value, low, high = number(found, "clock", "rate")
    assert value == pytest.approx(rate, abs=2e-6)
    assert low < rate < high


def test_a_wait_of_the_robot_is_dwell_and_no_clock() -> None:
    log, sim = against_simulation(against_command(10, noise=1e-5))
    speed = np.abs(np.gradient(sim.q, axis=0)).max(axis=1)
    still = np.nonzero(speed[1500:] < 1e-9)[0][10] + 1500
    wait = 400
    rows = np.concatenate([np.arange(still), np.full(wait, still), np.arange(still, len(log))])
    found = diagnose_log(replace(log, time=np.arange(len(rows)) * STEP, q=log.q[rows]), sim)
    assert names(found) == set()
    assert [d.extra for d in found.dwell] == [pytest.approx(wait * STEP, abs=0.002)]


@pytest.mark.slow
def test_missing_samples_are_counted_and_a_jittering_log_still_tells_its_lag() -> None:
    time, ways = program(11)
    lagged = lagging(ways, (0.02, 0.03, 0.012))
    rng = np.random.default_rng(2)
    at = time[::4] + rng.uniform(-4e-4, 4e-4, len(time[::4]))
    keep = rng.random(len(at)) > 0.02
    keep[1000:1060] = False
    q, command = (np.stack([np.interp(at, time, c) for c in x.T], axis=1)[keep] for x in (lagged, ways))
    log = Log(at[keep], q + 2e-5 * rng.normal(size=q.shape), (False,) * AXES, command=command)
    found = diagnose_log(log)
    assert names(found) == {"servo-lag"}
    assert found.dropped == pytest.approx((~keep).sum(), abs=2)
    assert any(end - begin == pytest.approx(61 * STEP, abs=0.01) for begin, end in found.gaps)


@pytest.mark.parametrize("simulated", [False, True])
def test_a_recorder_that_drops_samples_so_often_that_none_has_eight_neighbours_still_tells_the_lag(
    simulated: bool,
) -> None:
    log = against_command(11, lambda ways: lagging(ways, (0.02, 0.03, 0.012)))
    assert log.command is not None
    keep = np.arange(len(log.time)) % 7 < 5
    few = replace(log, time=log.time[keep], q=log.q[keep], command=log.command[keep])
    whole = Log(log.time, log.command, log.slides)
    found = diagnose_log(replace(few, command=None), whole) if simulated else diagnose_log(few)
    assert names(found) == {"servo-lag"}


# Several at once


def test_lag_and_clock_are_told_apart() -> None:
    found = diagnose_log(against_command(12, lambda ways: lagging(ways, (0.02, 0.035, 0.012)), late=0.003))
    assert names(found) == {"servo-lag", "clock"}
    assert number(found, "clock", "q behind q_cmd")[0] == pytest.approx(0.003, abs=1e-4)
    assert number(found, "servo-lag", "time constant of axis 2")[0] == pytest.approx(0.035, abs=1e-4)


@pytest.mark.slow
def test_lag_oscillation_and_play_on_different_axes_are_all_named() -> None:
    def change(ways: Floats) -> Floats:
        return loose(swinging(lagging(ways, (0.02, 0.035, 0.012)), 1, 9.0, 0.05), 0, 4e-4)

    found = diagnose_log(against_command(13, change))
    assert names(found) == {"servo-lag", "joint-compliance", "backlash"}
    assert {(e.term, e.axis) for e in found.evidence} == {
        *(("servo-lag", axis) for axis in (1, 2, 3)),
        ("joint-compliance", 2),
        ("backlash", 1),
    }


def test_something_outside_the_list_is_unexplained_and_says_what_it_goes_with() -> None:
    log = against_command(14)
    ripple = 3e-4 * np.sin(40 * log.q)
    found = diagnose_log(replace(log, q=log.q + ripple))
    assert not names(found)
    assert found.verdict == "unexplained"


def test_moves_that_take_longer_are_neither_a_clock_nor_a_lag() -> None:
    time, ways = program(22)
    moving = np.abs(np.gradient(ways, axis=0)).max(axis=1) > 1e-9
    rng = np.random.default_rng(22)
    longer = np.ones(len(time))
    change = np.diff(moving.astype(int))
    for begin, end in zip(np.nonzero(change > 0)[0], np.nonzero(change < 0)[0], strict=True):
        longer[begin:end] = rng.uniform(1.02, 1.12)
    real = np.concatenate([[0.0], np.cumsum(longer[1:] * FINE)])
    at = np.arange(0, real[-1], STEP)
    q = np.stack([np.interp(at, real, column) for column in ways.T], axis=1)
    log = Log(at, q + 2e-5 * rng.normal(size=q.shape), (False,) * AXES)
    found = diagnose_log(log, Log(time[::4], ways[::4], (False,) * AXES))
    assert names(found) == set()
    assert found.verdict == "unexplained"
    assert any("different times" in note for note in found.notes)


# Torques


def torques(log: Log, friction: dict[int, tuple[float, float]], rng: np.random.Generator) -> Floats:
    """(n, k) of a made-up arm: inertia, gravity of axes 2 and 3, friction of some axes, noise with a memory."""
    spectrum = Spectrum(even(log.time, log.q, STEP))
    speed, rise = (np.stack([spectrum.derivative(o, j, 0.006) for j in range(AXES)], axis=1) for o in (1, 2))
    found = 40.0 * rise + 3.0 * np.roll(rise, 1, axis=1)
    for j in (1, 2):
        found[:, j] += 60.0 * np.cos(log.q[:, 1] + (j - 1) * log.q[:, 2])
    for j, (b, c) in friction.items():
        found[:, j] += b * speed[:, j] + c * np.sign(speed[:, j]) * (np.abs(speed[:, j]) > 1e-4)
    noise = np.zeros_like(found)
    for i in range(1, len(noise)):
        noise[i] = 0.9 * noise[i - 1] + rng.normal(size=AXES)
    return found + noise


@pytest.mark.slow("True-friction0-expected0", "True-friction1-expected1", "True-friction2-expected2")
@pytest.mark.parametrize(
    ("friction", "expected"),
    [
        ({}, set()),
        ({0: (25.0, 0.0)}, {("viscous-friction", 1)}),
        ({1: (0.0, 12.0)}, {("coulomb-friction", 2)}),
        (
            {0: (25.0, 12.0), 2: (20.0, 10.0)},
            {(t, a) for t in ("viscous-friction", "coulomb-friction") for a in (1, 3)},
        ),
    ],
)
@pytest.mark.parametrize("simulated", [False, True])
def test_friction_is_named_per_axis(
    friction: dict[int, tuple[float, float]], expected: set[tuple[str, int]], simulated: bool
) -> None:
    log = replace(against_command(15, noise=1e-6, moves=18), command=None)
    rng = np.random.default_rng(5)
    measured = replace(log, torque=torques(log, friction, rng))
    sim = Log(log.time, log.q, log.slides, torque=torques(log, {}, rng)) if simulated else None
    found = diagnose_log(measured, sim)
    assert {(e.term, e.axis) for e in found.evidence} == expected
    for axis, (b, c) in friction.items():
        if b:
            value, low, high = number(found, "viscous-friction", f"viscous of axis {axis + 1}")
            assert value == pytest.approx(b, rel=0.15)
            assert low < high
        if c:
            assert number(found, "coulomb-friction", f"coulomb of axis {axis + 1}")[0] == pytest.approx(
                c, rel=0.1
            )


@pytest.mark.slow
def test_a_load_is_weighed_and_not_called_friction() -> None:
    from olp.robots.dynamics import Body, dynamic_model, inverse_dynamics

    time, ways = program(16, axes=6)
    robot = load_robot("universal-robots/ur10e")
    q = sampled(time, 0.7 * ways) + np.array([0.1, -1.3, 1.1, -0.9, 0.4, 0.2])
    spectrum = Spectrum(even(time[::4], q, STEP))
    speed, rise = (np.stack([spectrum.derivative(o, j, 0.01) for j in range(6)], axis=1) for o in (1, 2))
    model = dynamic_model(robot)
    rng = np.random.default_rng(3)
    bare = inverse_dynamics(model, q, speed, rise)
    loaded = inverse_dynamics(model, q, speed, rise, Body(4.0, (0.0, 0.0, 0.1)))
    log = Log(time[::4], q, (False,) * 6, torque=loaded + rng.normal(size=q.shape))
    sim = Log(time[::4], q, (False,) * 6, torque=bare)
    for found in (diagnose_log(log, sim, robot), diagnose_log(log, None, robot)):
        assert names(found) == {"payload"}
        value, low, high = number(found, "payload", "mass")
        assert value == pytest.approx(4.0, abs=0.2)
        assert low < high


def with_links(late: float, twist: float) -> Log:
    """A log with encoders behind the gears of its three axes."""
    log = replace(against_command(17, noise=1e-6), command=None)
    rng = np.random.default_rng(6)
    log = replace(log, torque=torques(log, {}, rng))
    assert log.torque is not None
    link = (
        hermite(log.time, log.q, log.time - late) + twist * log.torque + 3e-6 * rng.normal(size=log.q.shape)
    )
    return replace(log, covariates={f"q{j + 1}_link_deg": np.degrees(link[:, j]) for j in range(AXES)})


@pytest.mark.parametrize("count", [3, 4, 40])
def test_a_curve_on_a_grid_is_read_between_its_samples_as_any_other_curve(count: int) -> None:
    rng = np.random.default_rng(count)
    grid = Grid(0.3, 0.004, rng.normal(size=(count, 3)))
    instants = np.sort(np.append(rng.uniform(0.29, 0.31 + 0.004 * count, 100), grid.time))
    for values in (grid.values, rng.normal(size=(count, 1))):
        assert grid.at(instants, values) == pytest.approx(hermite(grid.time, values, instants), abs=1e-11)


def test_encoders_that_are_skewed_are_a_clock_and_not_a_soft_gear() -> None:
    found = diagnose_log(with_links(0.003, 0.0))
    assert names(found) == {"clock"}
    assert number(found, "clock", "link behind motor encoders")[0] == pytest.approx(0.003, rel=0.02)


def test_encoders_that_part_under_torque_are_a_soft_gear_and_no_clock() -> None:
    found = diagnose_log(with_links(0.0, -2e-6))
    assert names(found) == {"joint-compliance"}
    assert number(found, "joint-compliance", "twist of axis 1")[0] == pytest.approx(-2e-6, rel=0.1)


def hanging(
    ways: Floats, stiffness: float, inertia: float, weight: float, rotor: float
) -> tuple[Floats, Floats]:
    """A link on a spring behind the motor of the second axis, midpoint rule: where it is, and the motor's torque."""
    found, h = ways.copy(), FINE / 8
    motor, speed = ways[:, 1], np.gradient(ways[:, 1], FINE)
    torque = rotor * np.gradient(np.gradient(ways, FINE, axis=0), FINE, axis=0)
    damping, q, v = 0.0015 * stiffness, float(motor[0] - weight * np.cos(motor[0]) / stiffness), 0.0

    def pull(q: float, v: float, m: float, s: float) -> float:
        return stiffness * (m - q) + damping * (s - v)

    torque[0, 1] += pull(q, v, motor[0], 0.0)
    for i in range(len(motor) - 1):
        for k in range(8):
            u = (k + 0.5) / 8
            m, s = motor[i] * (1 - u) + motor[i + 1] * u, speed[i] * (1 - u) + speed[i + 1] * u
            first = (pull(q, v, m, s) - weight * np.cos(q)) / inertia
            middle, rate = q + v * h / 2, v + first * h / 2
            q, v = q + rate * h, v + (pull(middle, rate, m, s) - weight * np.cos(middle)) / inertia * h
        found[i + 1, 1] = q
        torque[i + 1, 1] += pull(q, v, motor[i + 1], speed[i + 1])
    return found, torque


@pytest.mark.slow
def test_a_link_that_sags_and_swings_behind_its_motor_tells_its_stiffness() -> None:
    time, ways = program(31, 12)
    stiffness = 2e5
    rng = np.random.default_rng(8)
    # The simulation's gear is a hundred times as stiff.
    (q, torque), (plain, planned) = (
        hanging(ways, k, 80.0, 300.0, 20.0) for k in (stiffness, 100 * stiffness)
    )
    measured = Log(
        time[::4], q[::4] + 1e-5 * rng.normal(size=q[::4].shape), (False,) * AXES,
        command=ways[::4], torque=torque[::4] + 2 * rng.normal(size=q[::4].shape),
    )  # fmt: skip
    sim = Log(time[::4], plain[::4], (False,) * AXES, command=ways[::4], torque=planned[::4])
    found = diagnose_log(measured, sim)
    assert names(found) == {"joint-compliance"}
    assert [e.axis for e in found.evidence] == [2]
    value, low, high = number(found, "joint-compliance", "stiffness of axis 2")
    assert value == pytest.approx(stiffness, rel=0.05)
    assert low < value < high


def held(ways: Floats, constant: float, cycle: int = 2) -> Floats:
    """A digital loop: once per `cycle` [ms] it reads its command and moves towards it."""
    found, share = ways.copy(), 1 - np.exp(-cycle * FINE / constant)
    for i in range(cycle, len(ways), cycle):
        found[i] = found[i - cycle] + (ways[i] - found[i - cycle]) * share
        between = np.linspace(0, 1, cycle + 1)[1:-1, None]
        found[i - cycle + 1 : i] = found[i - cycle] * (1 - between) + found[i] * between
    return found


@pytest.mark.slow("True")
@pytest.mark.parametrize("simulated", [False, True])
def test_the_cycle_of_a_lagging_servo_is_no_clock_and_late_inertia_is_no_friction(simulated: bool) -> None:
    time, ways = program(32, 14)
    late = held(ways, 0.012)
    rng = np.random.default_rng(9)
    slides = (False,) * AXES
    plan = Log(time[::4], ways[::4], slides, command=ways[::4])
    moved = Log(time[::4], late[::4], slides, command=ways[::4])
    measured = replace(
        moved, q=moved.q + 2e-5 * rng.normal(size=moved.q.shape), torque=torques(moved, {}, rng)
    )
    sim = replace(plan, torque=torques(plan, {}, rng)) if simulated else None
    found = diagnose_log(measured, sim)
    assert names(found) == {"servo-lag"}
    for axis in range(1, AXES + 1):
        assert number(found, "servo-lag", f"time constant of axis {axis}")[0] == pytest.approx(
            0.012, rel=0.02
        )


@pytest.mark.slow
def test_friction_of_one_axis_that_leaks_into_another_is_named_of_the_first_alone() -> None:
    log = replace(against_command(15, noise=1e-6, moves=18), command=None)
    rng = np.random.default_rng(11)
    own = torques(log, {0: (0.0, 40.0)}, rng)
    # Far below the noise, and yet significant in 8,000 samples.
    own[:, 1] += 3.0 * np.gradient(log.q[:, 1], STEP)
    sim = Log(log.time, log.q, log.slides, torque=torques(log, {}, rng))
    found = diagnose_log(replace(log, torque=own), sim)
    assert {(e.term, e.axis) for e in found.evidence} == {("coulomb-friction", 1)}


@pytest.mark.slow
def test_intervals_of_friction_hold_what_was_planted() -> None:
    friction = {0: (25.0, 12.0), 2: (20.0, 10.0)}
    count = 0
    for seed in range(102, 108):
        log = replace(against_command(seed, noise=1e-6, moves=18), command=None)
        found = diagnose_log(replace(log, torque=torques(log, friction, np.random.default_rng(seed))))
        for axis, (viscous, coulomb) in friction.items():
            for name, truth in (("viscous", viscous), ("coulomb", coulomb)):
                _, low, high = number(found, f"{name}-friction", f"{name} of axis {axis + 1}")
                count += low < truth < high
    assert count >= 22  # of 24


# A recording from disk, and moves


def test_a_folder_of_logs_alone_is_diagnosed_and_no_other_command_takes_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import json

    from olp.__main__ import main

    log = against_command(19, lambda ways: lagging(ways, (0.02, 0.02, 0.02)))
    (tmp_path / "log.csv").write_bytes(log_csv(log))
    assert main(["diagnose", str(tmp_path), "--json", "-"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["verdict"], told["data"]["moves"], told["mismatch"]["moves"]) == ("explained", 0, [])
    assert [f["term"] for f in told["findings"]] == ["servo-lag"]
    assert main(["diagnose", str(tmp_path), "--html", str(tmp_path / "report.html")]) == 0
    assert "servo lag" in (tmp_path / "report.html").read_text(encoding="utf-8")
    capsys.readouterr()
    assert main(["recording", "check", str(tmp_path)]) == 2
    assert "D001" in capsys.readouterr().err


def test_a_log_alone_that_is_compared_with_nothing_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from olp.__main__ import main

    (tmp_path / "log.csv").write_bytes(log_csv(replace(against_command(19), command=None)))
    assert main(["diagnose", str(tmp_path)]) == 2
    assert "D001" in capsys.readouterr().err


def test_a_recording_with_numbered_moves_says_where_the_axes_are_late(tmp_path: Path) -> None:
    from olp.identification.recording import read_recording

    log = against_command(18, lambda ways: lagging(ways, (0.02, 0.02, 0.02)))
    move = np.repeat([1, 2], [len(log) // 2, len(log) - len(log) // 2])
    (tmp_path / "log.csv").write_bytes(log_csv(replace(log, move=move)))
    rows = "move,duration_s,type\n1,,wait\n2,,wait\n"
    (tmp_path / "moves.csv").write_text(rows, encoding="utf-8")
    found = diagnose_logs(read_recording(tmp_path))
    assert names(found) == {"servo-lag"}
    assert [(m.move, m.significant) for m in found.moves] == [(1, True), (2, True)]
    assert all(m.residual == pytest.approx(0.02, rel=0.1) for m in found.moves)
    assert found.to_json()["evidence"][0]["term"] == "servo-lag"


# The parts


def test_whitened_selection_names_no_term_of_noise_with_a_memory_where_raw_selection_does() -> None:
    rng = np.random.default_rng(4)
    wrong = {"raw": 0, "white": 0}
    for _ in range(10):
        count = 2500
        t = np.arange(count)
        library = np.stack([np.sin(t / p) for p in (60, 90, 140, 200, 310)], axis=1)
        noise = np.zeros(count)
        for i in range(1, count):
            noise[i] = 0.97 * noise[i - 1] + rng.normal()
        columns = tuple(LibraryColumn(f"term {i}") for i in range(5))
        run = runs(t.astype(float), np.ones(count, dtype=bool))
        a, keep = autoregression(noise, run), kept(run)
        wrong["raw"] += bool(best(products(library, noise, columns))[0])
        wrong["white"] += bool(best(products(whiten(library, a, keep), whiten(noise, a, keep), columns))[0])
    assert wrong["raw"] >= 8
    assert wrong["white"] <= 1


def test_a_term_that_is_there_gains_on_held_out_blocks_and_one_that_is_not_does_not() -> None:
    rng = np.random.default_rng(8)
    library = rng.normal(size=(1200, 2))
    table = products(
        library, library[:, 0] + rng.normal(size=1200), (LibraryColumn("there"), LibraryColumn("not"))
    )
    assert gain(table, ("there", "not"), "there")[1] < 1e-6
    assert gain(table, ("there", "not"), "not")[1] > 0.01


def test_the_autoregression_of_a_known_noise_is_found() -> None:
    rng = np.random.default_rng(9)
    noise = np.zeros(20_000)
    for i in range(2, len(noise)):
        noise[i] = 1.2 * noise[i - 1] - 0.5 * noise[i - 2] + rng.normal()
    a = autoregression(noise, runs(np.arange(20_000.0), np.ones(20_000, dtype=bool)))
    assert a[:2] == pytest.approx([1.2, -0.5], abs=0.03)
    assert np.abs(a[2:]).max() < 0.04


def test_student_and_false_discovery_agree_with_scipy() -> None:
    from scipy import stats

    for t, freedom in ((0.3, 3), (2.5, 11), (-1.2, 7), (9.0, 40)):
        assert student_tail(t, freedom) == pytest.approx(stats.t.sf(t, freedom), rel=1e-9)
    assert student_quantile(11) == pytest.approx(stats.t.ppf(0.975, 11), rel=1e-9)
    p = np.array([0.001, 0.2, 0.012, 0.04, 0.9])
    assert false_discovery(p, 0.05).tolist() == (stats.false_discovery_control(p) <= 0.05).tolist()


def test_the_lag_in_the_frequency_domain_is_the_lag_in_time_steps() -> None:
    time, ways = program(19, moves=4)
    there = lagging(ways, (0.02, 0.05, 0.01))
    spectrum = Spectrum(even(time, ways, FINE))
    for axis, constant in enumerate((0.02, 0.05, 0.01)):
        away = spectrum.through(lag(spectrum.omega, constant), axis)
        assert np.abs(ways[:, axis] + away - there[:, axis])[300:].max() < 2e-6


def test_play_by_stretches_is_play_by_steps() -> None:
    _, ways = program(20, moves=6)
    there = loose(ways, 0, 1e-3)[:, 0]
    rest = np.abs(ways[:, 0] + play(ways[:, 0], 1e-3) - there)
    # In the beginning nobody knows on which flank the gear lies; a hundredth of the play is no reversal.
    begun = int(np.argmax(np.abs(ways[:, 0] - ways[0, 0]) > 2e-3))
    assert rest[begun:].max() < 1.1e-5


def test_pairing_finds_offset_and_rate_to_a_hundredth_of_a_sample() -> None:
    log, sim = against_simulation(against_command(21))
    found = pair(replace(log, time=-3.2 + 1.003 * log.time), sim, log.q, sim.q)
    assert found is not None
    assert not found.retimed
    assert not found.dwell
    assert found.clock.rate == pytest.approx(1.003, abs=2e-6)
    assert found.clock.offset == pytest.approx(-3.2, abs=4e-5)


def test_gaps_and_missing_samples_are_found_in_jittering_stamps() -> None:
    rng = np.random.default_rng(12)
    time = np.arange(2000) * STEP + rng.uniform(-8e-4, 8e-4, 2000)
    keep = np.ones(2000, dtype=bool)
    keep[[100, 101, 102, 103, 900]] = False
    assert dropped(time[keep]) == 5
    assert len(gaps(time[keep])) == 1


@pytest.mark.parametrize(
    "term", ["viscous-friction", "coulomb-friction", "servo-lag", "joint-compliance", "backlash", "clock"]
)
def test_every_term_of_logs_says_what_it_is_and_which_columns_tell_it(term: str) -> None:
    found = load_term(term)
    assert isinstance(found, LogTerm)
    assert found.name == term
    assert all((found.summary, found.does, found.source))
    assert found.equation
    assert found.parameters
    assert not found.seen_in(frozenset())
    assert found.seen_in(frozenset({"torque", "command"}))
