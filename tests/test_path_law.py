"""The law of lines, arcs and corners: what it says in cases with an answer, and what recorded pieces make of it."""

from __future__ import annotations

import csv
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError
from olp.identification.recording import read_recording
from olp.identification.signature import calibrate, read_signature, write_signature
from olp.identification.signature.document import LearntPaths, learn_paths, pieces_of
from olp.identification.signature.file import from_json, to_json
from olp.identification.signature.rows import predict_recording
from olp.identification.signature.stretches import stretches_of
from olp.timing.arm_prior import LineAcceleration
from olp.timing.path_law import NUMBERS, PathPieces, path_durations, prior_numbers

Floats = NDArray[np.float64]
LINES = LineAcceleration(3.0, 0.7, "a guess", False)
PLAIN = prior_numbers(LINES)[0]
NAMES = [number.name for number in NUMBERS]


def pieces(
    length: float, speed: float, rolling: tuple[bool, bool] = (False, False), zone: float = 0.0
) -> PathPieces:
    ends, one = np.array([rolling]), np.ones(1)
    return PathPieces(
        length=one * length,
        speed=one * speed,
        acceleration=one * np.nan,
        share=one,
        arc=np.zeros(1, dtype=bool),
        curvature=np.zeros(1),
        override=one,
        rolling=ends,
        zone=np.where(ends, zone, 0.0),
        turn=np.where(ends, 0.8, 0.0),
        tilt=np.zeros((1, 2)),
        axis=np.zeros(1),
        first=np.zeros(1, dtype=bool),
    )


def with_number(**values: float) -> Floats:
    numbers = PLAIN.copy()
    for name, value in values.items():
        numbers[NAMES.index(name.replace("_", " "))] = value
    return numbers


def test_a_long_line_is_a_trapezoid_and_a_short_one_a_triangle() -> None:
    numbers = with_number(stop=0.0, acceleration=np.log(2.0), highest_speed=np.log(50.0))
    assert path_durations(numbers, pieces(3.0, 0.5))[0] == pytest.approx(3.0 / 0.5 + 0.5 / 2.0, rel=1e-3)
    assert path_durations(numbers, pieces(0.02, 5.0))[0] == pytest.approx(2 * np.sqrt(0.02 / 2.0), rel=1e-3)


def test_a_larger_zone_costs_less_and_a_stop_costs_most() -> None:
    small, large = (path_durations(PLAIN, pieces(0.4, 0.8, (True, True), zone))[0] for zone in (0.001, 0.05))
    assert large < small < path_durations(PLAIN, pieces(0.4, 0.8))[0]


def test_a_corner_costs_what_braking_to_its_speed_costs() -> None:
    acceleration, across, zone, speed = 2.0, 0.7, 0.02, 0.9
    numbers = with_number(
        acceleration=np.log(acceleration),
        corner_acceleration=np.log(across),
        corner_zone=np.log(1e-9),
        corner_convention=0.0,
        highest_speed=np.log(50.0),
    )
    radius = zone / (1.0 - np.cos(0.8))
    passed = (speed**-2.0 + 1.0 / (across * acceleration * radius)) ** -0.5
    ramp = np.linspace(passed, speed, 100001)  # braking, as time and way at each speed
    took = (speed - passed) / acceleration
    way = np.trapezoid(ramp, dx=took / 100000)
    found = path_durations(numbers, pieces(50.0, speed, (True, True), zone))[0]
    assert found - 50.0 / speed == pytest.approx(2.0 * (took - way / speed), rel=1e-4)


def test_an_axis_that_cannot_follow_slows_the_piece() -> None:
    slowed = replace(pieces(0.4, 0.8), axis=np.array([1.2]))
    assert path_durations(PLAIN, slowed)[0] > 1.2


def test_a_fast_arc_gains_speed_more_slowly_than_a_line_and_a_slow_one_does_not() -> None:
    def over(speed: float) -> float:
        line = pieces(2.0, speed)
        arc = replace(line, arc=np.ones(1, dtype=bool), curvature=np.ones(1) / 0.2)
        stop = with_number(stop=0.0, highest_speed=np.log(50.0))
        ramps = [path_durations(stop, p)[0] - 2.0 / speed for p in (arc, line)]
        return float(ramps[0] / ramps[1])

    assert over(0.02) == pytest.approx(1.0, abs=0.01)
    assert 1.1 < over(0.8) < np.exp(0.35)


def test_a_programmed_acceleration_is_held_whatever_is_usual_and_a_percent_lowers_it() -> None:
    line = pieces(20.0, 0.5)
    told = replace(line, acceleration=np.array([1.0]))
    for usual in (0.5, 8.0):
        numbers = with_number(acceleration=np.log(usual), stop=0.0)
        assert path_durations(numbers, told)[0] == pytest.approx(40.0 + 0.5, rel=1e-4)
        half = replace(line, share=np.array([0.5]))
        assert path_durations(numbers, half)[0] == pytest.approx(40.0 + 0.5 / (0.5 * usual), rel=1e-4)


# --- from recordings --------------------------------------------------------------------------------------------------

POINTS = tuple(f"{axis}_{end}_mm" for end in ("start", "via", "end") for axis in "xyz")
HEAD = ["move", "type", "duration_s", "speed_mm_s", "blend_mm", "job", *POINTS]
TRUE = with_number(
    acceleration=np.log(9.0),
    stop=0.08,
    corner_acceleration=np.log(0.5),
    corner_convention=0.02,
    first_piece=0.03,
)


def runs(kinds: str, count: int, seed: int) -> list[dict[str, object]]:
    """Runs of two pieces each, "l"ine or "a"rc, with a corner or a stop between them; no durations yet."""
    draw, rows = np.random.default_rng(seed), []
    for run in range(count):
        speed, zone = float(draw.choice([50, 200, 600, 1500])), float(draw.choice([0, 1, 10, 30]))
        point, angle = draw.uniform(-200, 200, 2), draw.uniform(0, 6)
        for part in range(2):
            kind = kinds[(run + part) % len(kinds)]
            length, angle = draw.uniform(150, 600), angle + (0.5 if part else 0.0)
            way = np.array([np.cos(angle), np.sin(angle)])
            end = point + length * way
            via = point + length / 2 * way + 0.2 * length * np.array([-way[1], way[0]])
            row: dict[str, object] = {
                "move": 0,
                "type": "linear" if kind == "l" else "circular",
                "speed_mm_s": speed,
            }
            row |= {"blend_mm": zone if part == 0 else 0, "job": f"J{run}"}
            row |= dict(zip(HEAD[6:9], (*point, 0.0), strict=True)) | dict(
                zip(HEAD[12:15], (*end, 0.0), strict=True)
            )
            if kind == "a":
                row |= dict(zip(HEAD[9:12], (*via, 0.0), strict=True))
            rows.append(row)
            point = end
    return rows


def recorded(folder: Path, rows: list[dict[str, object]], seconds: bool = True) -> tuple[Path, Floats]:
    """Writes the recording, with what the law with the numbers TRUE says and a scatter of 0.5 %."""
    folder.mkdir()
    for number, row in enumerate(rows):
        row["move"] = number + 1
    table = folder / "moves.csv"

    def write(durations: Floats | None) -> None:
        with table.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, HEAD)
            writer.writeheader()
            for number, row in enumerate(rows):
                writer.writerow(row | {"duration_s": "" if durations is None else f"{durations[number]:.5f}"})

    write(None)
    moves = read_recording(folder).moves
    found, at = pieces_of(moves, None, stretches_of(moves))
    assert len(at) == len(rows)
    true = path_durations(TRUE, found) * np.exp(np.random.default_rng(1).normal(0, 0.005, len(rows)))
    if seconds:
        write(true)
    return folder, true


@pytest.mark.parametrize(("kinds", "asked"), [("al", "al"), ("a", "a"), ("a", "l"), ("l", "al")])
def test_lines_arcs_and_corners_are_learnt_from_each_other(tmp_path: Path, kinds: str, asked: str) -> None:
    folder, _ = recorded(tmp_path / "learnt", runs(kinds, 30, 1))
    signature, told = calibrate(read_recording(folder), "constant")
    assert "H053" in {d.code for d in told}
    write_signature(signature, tmp_path / "signature.json")
    again = read_signature(tmp_path / "signature.json")
    other, true = recorded(tmp_path / "other", runs(asked, 20, 2), seconds=False)
    rows, _ = predict_recording(again, read_recording(other))
    error = np.abs(rows.predicted / true - 1)
    assert np.median(error) < 0.02
    assert np.mean(error) < 0.04
    if kinds == asked:
        assert np.mean((rows.low <= true) & (true <= rows.high)) >= 0.85


def test_a_corner_that_no_piece_taught_is_known_less_than_a_stop() -> None:
    draw = np.random.default_rng(3)
    lines = [
        pieces(float(way), float(v))
        for way, v in zip(draw.uniform(0.2, 0.8, 12), draw.uniform(0.1, 1.0, 12), strict=True)
    ]
    known = PathPieces(*(np.concatenate([getattr(p, f.name) for p in lines]) for f in fields(PathPieces)))
    measured = path_durations(PLAIN, known) * np.exp(draw.normal(0, 0.002, 12))
    learnt = learn_paths(known, measured, np.zeros(12, dtype=np.int64), LINES, 0.001)
    stop, corner = (learnt.halves(pieces(0.5, 1.0, ends, 0.01))[0] for ends in ((False, False), (True, True)))
    assert stop < 0.03
    assert corner > 2 * stop
    again = LearntPaths.from_json(learnt.to_json())
    assert again.halves(known) == pytest.approx(learnt.halves(known))


def test_a_whole_circle_has_the_middle_point_opposite(tmp_path: Path) -> None:
    places = {"x_start_mm": 0, "y_start_mm": 0, "x_via_mm": 200, "y_via_mm": 0, "x_end_mm": 1, "y_end_mm": 1}
    row = runs("a", 1, 3)[0] | places
    folder, _ = recorded(tmp_path / "circle", [row])
    moves = read_recording(folder).moves
    assert pieces_of(moves, None, stretches_of(moves))[0].length[0] == pytest.approx(0.2 * np.pi)


def test_arcs_faster_than_programmed_are_told_and_not_learnt(tmp_path: Path) -> None:
    rows = runs("a", 8, 5)
    for row in rows:
        row["blend_mm"] = 0
    folder, _ = recorded(tmp_path / "learnt", rows)
    table = (folder / "moves.csv").read_text(encoding="utf-8").splitlines()
    at = HEAD.index("duration_s")
    for row in (2, 5):
        cells = table[row].split(",")
        table[row] = ",".join([*cells[:at], "0.01", *cells[at + 1 :]])
    (folder / "moves.csv").write_text("\n".join(table), encoding="utf-8")
    signature, told = calibrate(read_recording(folder))
    assert any(d.code == "H005" and "moves 2, 5" in d.message for d in told)
    assert signature.recording.moves == len(rows) - 2


def test_spoilt_numbers_are_no_law_of_paths(tmp_path: Path) -> None:
    folder, _ = recorded(tmp_path / "learnt", runs("al", 12, 1))
    signature, _ = calibrate(read_recording(folder), "constant")
    assert signature.paths is not None
    content = signature.paths.to_json()
    assert LearntPaths.from_json(content).numbers == pytest.approx(signature.paths.numbers)
    with pytest.raises(OlpError, match="law of lines and arcs"):
        from_json(to_json(signature) | {"version": 4})
    for key, value in (
        ("half_95", -1.0),
        ("numbers", {}),
        ("examples", {"features": []}),
        ("covariance", [[-1.0]]),
    ):
        with pytest.raises((KeyError, ValueError)):
            LearntPaths.from_json(content | {key: value})
