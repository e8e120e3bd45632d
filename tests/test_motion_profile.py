"""A profile as such: what the check refuses, and what is answered between and outside the phases."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from olp.timing.motion import Profile, RequestedMoves, load_model

PHASES = ("up", "on", "down")


def profile(
    durations: list[float],
    accelerations: list[float],
    jerks: list[float] | None = None,
    **asked: float,
) -> Profile:
    """One move of three phases, asked for with limits that [0.5, 1, 0.5] s at ±1 m/s² just keep."""
    wanted = {
        "length": 0.75,
        "speed": 0.5,
        "acceleration": 1.0,
        "deceleration": 1.0,
        "start_speed": 0.0,
        "end_speed": 0.0,
    } | asked
    rows = (np.array([x]) for x in (durations, accelerations, jerks or [0.0, 0.0, 0.0]))
    moves = RequestedMoves(**{name: np.array([value]) for name, value in wanted.items()})
    return Profile.build(moves, PHASES, *rows, np.zeros(1, dtype=np.int8))


GOOD = ([0.5, 1.0, 0.5], [1.0, 0.0, -1.0])


def test_a_sound_profile_has_no_defect() -> None:
    assert not profile(*GOOD).defects().any()


@pytest.mark.parametrize(
    ("durations", "accelerations", "asked"),
    [
        pytest.param(*GOOD, {"length": 0.75001}, id="misses its length"),
        pytest.param([0.5, 1.2, 0.3], [1.0, 0.0, -1.0], {"length": 0.83}, id="misses its end speed"),
        pytest.param(*GOOD, {"speed": 0.4999}, id="too fast"),
        pytest.param(*GOOD, {"acceleration": 0.999}, id="accelerates too hard"),
        pytest.param(*GOOD, {"deceleration": 0.999}, id="brakes too hard"),
        pytest.param(
            [0.2, 0.7, 0.6],
            [-1.0, 1.0, -1.0],
            {"start_speed": 0.1, "length": 0.355, "speed": 0.6},
            id="drives backwards",
        ),
        pytest.param([0.6, -0.1, 0.6], [1.0, 0.0, -1.0], {"length": 0.3, "speed": 0.6}, id="negative time"),
        pytest.param([np.nan, 1.0, 0.5], [1.0, 0.0, -1.0], {}, id="no time at all"),
    ],
)
def test_each_defect_is_found(
    durations: list[float], accelerations: list[float], asked: dict[str, float]
) -> None:
    assert profile(durations, accelerations, **asked).defects().all()


def test_an_acceleration_that_changes_its_sign_inside_a_phase_is_a_defect() -> None:
    # Speed 0.5 at both ends of the second phase, 0.6 in its middle, which the phases' ends do not show.
    turning = profile([0.5, 1.0, 0.5], [1.0, 0.4, -1.0], [0.0, -0.8, 0.0])
    bulge = replace(turning.moves, length=turning.positions[:, -1])
    assert turning.speed(1.0) == pytest.approx(0.6)
    assert replace(turning, moves=bulge).defects().all()


def test_at_the_instant_between_two_phases_the_later_one_holds() -> None:
    acceleration = profile(*GOOD).acceleration([[0.0, 0.5, 1.5]])
    assert acceleration.tolist() == [[1.0, 0.0, -1.0]]


def test_before_the_start_and_after_the_end_the_move_stays_where_it_is() -> None:
    one = profile(*GOOD)
    assert one.position([[-1.0, 9.0]]).tolist() == [[0.0, 0.75]]
    assert one.speed([[-1.0, 9.0]]).tolist() == [[0.0, 0.0]]
    assert one.time_at([[-1.0, 9.0]])[0] == pytest.approx([0.0, 2.0])


def test_one_instant_per_move_and_many_instants_per_move_agree() -> None:
    moves = load_model("linear").profile([0.3, 0.7, 2.0], 0.4, 2.0)
    t = np.array([0.2, 0.5, 1.3])
    assert moves.position(t).shape == (3,)
    for ask in (moves.position, moves.speed, moves.acceleration, moves.jerk, moves.time_at):
        assert ask(t / 10).tolist() == np.diag(ask(np.tile(t / 10, (3, 1)))).tolist()


def test_picked_rows_are_the_same_motions_in_the_order_asked_for() -> None:
    moves = load_model("linear").profile([0.3, 0.7, 2.0], [0.4, 0.5, 0.6], 2.0)
    rows = np.array([2, 0, 0])
    picked = moves.take(rows)
    t = np.array([0.6, 0.2, 0.9])
    assert picked.duration.tolist() == moves.duration[rows].tolist()
    assert picked.position(t).tolist() == [moves.position(x)[row] for x, row in zip(t, rows, strict=True)]
    assert picked.moves.speed.tolist() == [0.6, 0.4, 0.4]
    assert not picked.defects().any()
