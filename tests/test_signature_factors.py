"""The thesis' own method: tables, interpolation, combination in inclined planes, all six influential parameters."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from olp.core.units import deg, mm
from olp.identification.recording import read_recording
from olp.identification.signature import MoveSet, moves_of_recording
from olp.identification.signature.estimator import load_estimator
from olp.identification.signature.learn import fit_moves
from olp.robots.geometry import rotation_from_angles

UP20 = Path(__file__).parent.parent / "samples" / "up20"
# Times that are means of two readings, rounded when they were printed (docs/thesis.md, erratum 30).
MEANS_OF_TWO = {17: 2.705, 44: 2.715, 94: 2.865, 130: 3.515, 136: 2.965}
RNG = np.random.default_rng(4)


@pytest.fixture(scope="module")
def recorded():
    recording = read_recording(UP20)
    moves, rows = moves_of_recording(recording)
    numbers = recording.moves.move[rows].tolist()
    duration = [MEANS_OF_TWO.get(n, t) for n, t in zip(numbers, moves.duration.tolist(), strict=True)]
    return replace(moves, duration=np.array(duration))


def fitted(moves, name="factors"):
    estimator = load_estimator(name)
    return estimator, estimator.fit(moves, None)


def factor_at(moves, start_mm, way_mm, name="factors"):
    estimator, parameters = fitted(moves, name)
    start = np.array([start_mm]) * mm
    one = synthetic(start, start + np.array([way_mm]) * mm)
    slowness = estimator.estimate(parameters, one, None).slowness
    return float(1.0 / slowness[0] / 0.4)


def synthetic(start, end, factor=1.0, **columns):
    """Moves at 0.3 m/s whose times are those of 0.4 m/s² times `factor`."""
    count = len(start)
    length = np.linalg.norm(end - start, axis=1)
    duration = length / 0.3 + 0.3 / (0.4 * np.broadcast_to(factor, count))
    given = {
        "rotation": np.broadcast_to(np.eye(3), (count, 3, 3)),
        "payload": np.full(count, np.nan),
        "configuration": ("",) * count,
    } | columns
    return MoveSet(
        start=start,
        end=end,
        speed=np.full(count, 0.3),
        nominal=np.full(count, 0.4),
        duration=duration,
        program=("",) * count,
        **given,
    )


def fan(start_mm=(1000.0, 300.0, 500.0), plane="horizontal", count=9):
    angles = np.linspace(-0.7, 0.7, count)
    along = np.stack([np.cos(angles), np.sin(angles)], axis=1) * 0.7
    step = np.zeros((count, 3))
    step[:, [0, 1] if plane == "horizontal" else [2, 1]] = -along
    start = np.repeat(np.array([start_mm]) * mm, count, axis=0)
    return start, start + step


def test_table_a16_comes_out_to_the_printed_digits(recorded):
    _, parameters = fitted(recorded)
    with (UP20 / "printed.csv").open(encoding="utf-8") as file:
        printed = {int(row["move"]): row["factor"] for row in csv.DictReader(file)}
    tables = [t for t in parameters["tables"].value if t["plane"] == "horizontal" and t["sense"] == -1]
    found = {}
    with (UP20 / "moves.csv").open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if row["test"] != "approach":
                continue
            place = [float(row[f"{axis}_start_mm"]) for axis in "xyz"]
            table = next(t for t in tables if np.allclose(t["start_mm"], place))
            index = int(np.argmin(np.abs(np.array(table["angle_deg"]) - float(row["angle_deg"]))))
            found[int(row["move"])] = table["factor"][index]
    assert len(found) == 62
    wrong = {n: (round(f, 4), printed[n]) for n, f in found.items() if abs(f - float(printed[n])) > 0.00501}
    assert not wrong


def test_the_printed_example_of_interpolation_comes_out(recorded):
    way = [-640.0, -640.0 * np.tan(7 * deg), 0.0]
    assert factor_at(recorded, (1350.0, 700.0, 100.0), way) == pytest.approx(1.411, abs=1.5e-3)


def test_the_adjusted_acceleration_of_the_first_move_is_the_printed_one(recorded):
    estimator, parameters = fitted(recorded)
    slowness = estimator.estimate(parameters, recorded.take(np.arange(1)), None).slowness
    assert 1.0 / slowness[0] / mm == pytest.approx(592.11, abs=5e-3)


def test_learnt_moves_get_their_own_time_back(recorded):
    estimator, parameters = fitted(recorded)
    said = estimator.estimate(parameters, recorded, None)
    beyond = recorded.duration - recorded.length / recorded.speed
    assert np.allclose(recorded.speed * said.slowness, beyond, atol=1e-9)
    assert said.inside.all()


def test_a_start_point_between_two_radii_lies_between_their_tables():
    near, far = fan((800.0, 0.0, 500.0)), fan((1600.0, 0.0, 500.0))
    start, end = (np.concatenate(pair) for pair in zip(near, far, strict=True))
    moves = synthetic(start, end, np.repeat([1.2, 2.0], 9))
    radii = np.hypot([800.0, 1600.0], 500.0)
    share = (np.hypot(1200.0, 500.0) - radii[0]) / (radii[1] - radii[0])
    assert factor_at(moves, (1200.0, 0.0, 500.0), (-700.0, 0.0, 0.0)) == pytest.approx(1.2 + 0.8 * share)


def test_a_start_point_and_an_angle_that_were_not_measured_are_said_to_be_outside(recorded):
    estimator, parameters = fitted(recorded)
    start = np.array([[2000.0, 0.0, 100.0], [1350.0, 700.0, 100.0]]) * mm
    step = np.array([[-700.0, 0.0, 0.0], [-200.0, 600.0, 0.0]]) * mm
    assert not estimator.estimate(parameters, synthetic(start, start + step), None).inside.any()


def inclined(name, horizontal, vertical, way):
    start, end = (np.concatenate(p) for p in zip(fan(), fan(plane="vertical"), strict=True))
    moves = synthetic(start, end, np.repeat([horizontal, vertical], 9))
    return factor_at(moves, (1000.0, 300.0, 500.0), way, name)


@pytest.mark.parametrize("way", [(-500.0, 100.0, -400.0), (-300.0, -200.0, -600.0), (-500.0, 0.0, -500.0)])
def test_equal_factors_in_both_planes_give_that_factor(way):
    assert inclined("factors", 1.48, 1.48, way) == pytest.approx(1.48)


def test_the_printed_combination_counts_y_twice_and_is_there_by_its_name():
    x, y, z = unit = np.array([-500.0, 300.0, -400.0]) / np.linalg.norm([500.0, 300.0, 400.0])
    ch, cv = 1.5, 1.2
    expected = np.sqrt(ch**2 * x**2 + (ch**2 + cv**2 - 1) * y**2 + cv**2 * z**2)
    assert inclined("factors_printed", ch, cv, tuple(unit * 700)) == pytest.approx(expected)


def test_without_a_part_along_y_all_forms_of_6_18_agree():
    way = (-500.0, 0.0, -400.0)
    share = 500.0**2 / (500.0**2 + 400.0**2)
    expected = np.sqrt(share * 1.5**2 + (1 - share) * 1.2**2)
    assert inclined("factors", 1.5, 1.2, way) == pytest.approx(expected)
    assert inclined("factors_printed", 1.5, 1.2, way) == pytest.approx(expected)


def test_the_product_form_multiplies_the_factors_of_both_planes():
    assert inclined("factors_product", 1.5, 1.2, (-500.0, 100.0, -400.0)) == pytest.approx(1.8)


def twice(**second):
    """A fan at the reference, and again with another level that makes it a quarter quicker."""
    start, end = fan()
    start, end = np.tile(start, (3, 1)), np.tile(end, (3, 1))
    factor = np.repeat([1.2, 1.2, 1.5], 9)
    return synthetic(start, end, factor, **second)


def says(moves, **columns):
    estimator, parameters = fitted(moves)
    start, end = fan(count=3)
    asked = synthetic(start, end, **columns)
    found = estimator.estimate(parameters, asked, None)
    return 1.0 / found.slowness / 0.4, found.inside


def test_carried_mass_is_a_factor_of_its_own_and_interpolated():
    moves = twice(payload=np.repeat([2.0, 2.0, 10.0], 9))
    factor, inside = says(moves, payload=np.array([2.0, 10.0, 6.0]))
    assert factor == pytest.approx([1.2, 1.5, 1.35])
    assert inside.all()
    assert not says(moves, payload=np.full(3, 20.0))[1].any()


def test_tool_orientation_is_a_factor_of_its_own():
    tilted = rotation_from_angles(np.array([0.0, 40 * deg, 0.0]))
    turns = np.repeat(np.stack([np.eye(3), np.eye(3), tilted]), 9, axis=0)
    moves = twice(rotation=turns)
    strange = rotation_from_angles(np.array([0.0, -60 * deg, 0.0]))
    factor, inside = says(moves, rotation=np.stack([np.eye(3), tilted, strange]))
    assert factor[:2] == pytest.approx([1.2, 1.5])
    assert inside.tolist() == [True, True, False]


def test_configuration_is_a_factor_of_its_own():
    moves = twice(configuration=("up",) * 18 + ("down",) * 9)
    factor, inside = says(moves, configuration=("up", "down", "behind"))
    assert factor[:2] == pytest.approx([1.2, 1.5])
    assert inside.tolist() == [True, True, False]


def test_two_readings_of_one_move_count_by_their_mean_time():
    start, end = fan(count=3)
    moves = synthetic(np.tile(start, (2, 1)), np.tile(end, (2, 1)))
    apart = replace(moves, duration=moves.duration + np.repeat([-0.01, 0.01], 3))
    factor, _ = says(apart)
    assert factor == pytest.approx(1.0)


@pytest.mark.parametrize(("share", "suits"), [(0.4, False), (0.6, True)])
def test_tables_are_no_choice_where_most_moves_lie_in_no_plane(share, suits):
    """Tables hold level and upright moves alone: where most are neither, they know nothing of most."""
    rng = np.random.default_rng(20)
    starts = rng.uniform([0.5, -0.5, 0.2], [1.1, 0.5, 0.9], (50, 3))
    ways = rng.uniform(-0.4, 0.4, (50, 3))
    ways[: round(50 * share), 2] = 0.0
    moves = synthetic(starts, starts + ways)
    assert load_estimator("factors").suits(moves) is suits
    assert load_estimator("factors").needs(moves, None) == ""
    assert ("factors" in fit_moves(moves, None).compared) is suits
