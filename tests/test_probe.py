"""Experiments: what is chosen, that it can be run, and that what is written can be read."""

from __future__ import annotations

import numpy as np
import pytest

import olp
from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.core.units import deg, mm
from olp.identification.probe import Wanted, design_experiment, write_experiment
from olp.identification.probe.experiment import NOISE, ShortestPaths, most_telling, order, share_left
from olp.identification.probe.reach import look
from olp.identification.recording import read_recording
from olp.robots.geometry import Pose, rotation_from_angles
from olp.robots.kinematics import inverse, singularities, within_limits
from olp.robots.robot import load_robot

UP20 = load_robot("yaskawa/up20")
BOX = np.array([[710.0, 1350.0], [0.0, 700.0], [100.0, 740.0]]) * mm
ANGLES = (180 * deg, -90 * deg, 0.0)
WANTED = Wanted(UP20, BOX, 8, 0.3, ANGLES)


@pytest.fixture(scope="module")
def experiment():
    return design_experiment(WANTED)


@pytest.fixture(scope="module")
def folder(experiment, tmp_path_factory):
    place = tmp_path_factory.mktemp("probe")
    write_experiment(experiment, place, date="2026/11/20 10:00")
    return place


def random_covariance(count: int = 14, seed: int = 3) -> np.ndarray:
    root = np.random.default_rng(seed).normal(size=(count, 6))
    return root @ root.T + 1e-6 * np.eye(count)


def left(covariance: np.ndarray, rows: list[int]) -> float:
    own = covariance[np.ix_(rows, rows)] + NOISE * np.eye(len(rows))
    return float(np.trace(covariance - covariance[:, rows] @ np.linalg.solve(own, covariance[rows])))


def test_the_chosen_pair_is_the_best_of_all_pairs():
    for seed in range(5):
        covariance = random_covariance(seed=seed)
        none = np.zeros(14, dtype=bool)
        chosen = most_telling(covariance, 2, none, ~none)
        pairs = [[i, j] for i in range(14) for j in range(i)]
        # Exchanges find a best set that no single exchange betters; of two it is nearly always the best of all.
        assert left(covariance, chosen.tolist()) <= 1.02 * min(left(covariance, p) for p in pairs)


def test_no_single_exchange_makes_a_design_better():
    covariance = random_covariance(20)
    none = np.zeros(20, dtype=bool)
    chosen = most_telling(covariance, 5, none, ~none).tolist()
    best = left(covariance, chosen)
    for place in range(5):
        for row in set(range(20)) - set(chosen):
            assert left(covariance, [*chosen[:place], row, *chosen[place + 1 :]]) >= best - 1e-6


def test_what_is_known_is_not_measured_again_and_what_is_not_allowed_not_at_all():
    covariance = random_covariance()
    known = np.arange(14) < 4
    allowed = np.arange(14) % 2 == 1
    chosen = most_telling(covariance, 9, known, allowed)
    assert sorted(chosen.tolist()) == [5, 7, 9, 11, 13]


def test_measuring_more_leaves_less():
    covariance = random_covariance()
    shares = [share_left(covariance, np.arange(n)) for n in (1, 3, 6)]
    assert 1 > shares[0] > shares[1] > shares[2] > 0


def test_ways_between_points_use_allowed_lines_only():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 3, 0]])
    allowed = np.zeros((4, 4), dtype=bool)
    for a, b in ((0, 1), (1, 2), (0, 3)):
        allowed[a, b] = allowed[b, a] = True
    ways = ShortestPaths(points, allowed)
    assert ways.between(2, 3) == [1, 0, 3]
    assert ways.length[2, 3] == pytest.approx(5.0)
    assert order(np.array([2, 0, 1]), np.array([3, 1, 2]), ways) == [0, 1, 2]


def test_every_place_of_every_line_is_possible(experiment):
    robot, at = UP20, np.linspace(0, 1, 101)[:, None]
    ends = zip(experiment.starts.tolist(), experiment.ends.tolist(), strict=True)
    for start, end in ends:
        a, b = experiment.points[start], experiment.points[end]
        place = a + at * (b - a)
        assert np.all((place >= BOX[:, 0] - 1e-9) & (place <= BOX[:, 1] + 1e-9))
        joints, reached = inverse(robot, place, np.broadcast_to(rotation_from_angles(ANGLES), (101, 3, 3)))
        assert reached.all()
        assert within_limits(robot, joints).all()
        near = singularities(robot, joints, 4 * deg, 0.04)
        assert not (near.wrist | near.elbow | near.shoulder).any()


def test_moves_reach_their_speed(experiment):
    length = np.linalg.norm(experiment.points[experiment.ends] - experiment.points[experiment.starts], axis=1)
    assert length.min() >= 0.3**2 / 0.4


def test_the_job_runs_the_rows_of_moves_csv(folder):
    program, recording = olp.read(folder / "PROBE.JBI"), read_recording(folder)
    assert not program.diagnostics
    assert not [d for d in recording.diagnostics if d.is_error]
    table = program.plan(UP20).time()
    moves = recording.moves
    assert len(moves) == 8
    assert not moves.measured.any()
    assert moves.stops.all()
    for row in range(8):
        line = table[table["line"] == moves.line[row]]
        assert line["distance_mm"].item() == pytest.approx(moves.chord[row] / mm, abs=0.01)
        assert line["speed_mm_s"].item() == pytest.approx(300)


def test_the_job_is_read_back_to_the_same_bytes(folder):
    data = (folder / "PROBE.JBI").read_bytes()
    assert olp.read(folder / "PROBE.JBI").export("inform") == data


def test_a_design_is_the_same_every_time(experiment):
    again = design_experiment(WANTED)
    assert np.array_equal(again.starts, experiment.starts)
    assert np.array_equal(again.ends, experiment.ends)


def test_further_moves_are_other_moves_and_tell_more(folder, tmp_path, capsys):
    rows = (folder / "moves.csv").read_text().splitlines()
    filled = [rows[0], *(row.replace(",,linear", ",2.5,linear") for row in rows[1:])]
    (tmp_path / "moves.csv").write_text("\n".join(filled) + "\n")
    (tmp_path / "recording.toml").write_text('robot = "yaskawa/up20"\n')
    assert main(["probe", "--next", str(tmp_path), "--moves", "4", "-o", str(tmp_path / "more")]) == 0
    more, old = read_recording(tmp_path / "more").moves, read_recording(folder).moves
    assert more.move.tolist() == [9, 10, 11, 12]
    assert np.all(more.start >= old.start.min(axis=0).clip(max=old.end.min(axis=0)) - 1e-9)
    before = {(*a, *b) for a, b in zip(old.start.round(4).tolist(), old.end.round(4).tolist(), strict=True)}
    assert not before & {
        (*a, *b) for a, b in zip(more.start.round(4).tolist(), more.end.round(4).tolist(), strict=True)
    }
    assert "4 measured moves" in capsys.readouterr().out


def test_a_tool_moves_the_flange_and_is_proved_with_its_number(tmp_path):
    tool = Pose.from_xyz_angles([0.0, 0.0, 0.2, 0.0, 0.0, 0.0])
    box = BOX - np.array([[0.2], [0.0], [0.0]])
    wanted = WANTED._replace(tool=tool, tool_number=3, moves=3, box=box)
    write_experiment(design_experiment(wanted), tmp_path)
    assert b"///TOOL 3" in (tmp_path / "PROBE.JBI").read_bytes()
    assert read_recording(tmp_path).tool.position == pytest.approx((0, 0, 0.2))
    assert not (tmp_path / "TOOL.CND").exists()


def test_lines_that_cannot_be_run_say_why():
    start = np.array([[1.0, 0, 0.3], [0.9, 0, 0.3], [1.2, -0.3, 0.3]])
    end = np.array([[5.0, 0, 0.3], [-0.9, 0.01, 0.3], [1.2, 0.3, 0.3]])
    found = look(UP20, start, end, rotation_from_angles(ANGLES), None, 0.3)
    assert found.possible.tolist() == [False, False, True]
    assert found.reason[0] == "out of reach"
    fast = look(UP20, start[2:], end[2:], rotation_from_angles(ANGLES), None, 20.0)
    assert "too slow for that speed" in fast.reason[0]


@pytest.mark.parametrize(
    ("more", "code"),
    [
        (["--box", "5000,6000,0,700,100,740"], "Q002"),
        (["--box", "1350,710,0,700,100,740"], "Q001"),
        (["--box", "1,2,3"], "C002"),
        (["--box", "710,1350,0,700,100,740", "--moves", "0"], "Q001"),
        (["--box", "710,1350,0,700,100,740", "--speed", "-3"], "Q001"),
        (["--box", "710,1350,0,700,100,740", "--tool-number", "2"], "Q001"),
        ([], "C002"),
    ],
)
def test_a_wish_that_cannot_be_ends_with_2_and_a_reason(more, code, tmp_path, capsys):
    status = main(["probe", "--robot", "yaskawa/up20", *more, "-o", str(tmp_path / "out")])
    assert status == 2
    assert f"error[{code}]" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_recording_without_durations_asks_for_them(folder, tmp_path, capsys):
    assert main(["probe", "--next", str(folder), "-o", str(tmp_path / "out")]) == 2
    assert "error[Q005]" in capsys.readouterr().err


def test_what_is_there_is_not_overwritten(folder, capsys):
    box = "710,1350,0,700,100,740"
    line = ["probe", "--robot", "yaskawa/up20", "--moves", "3", "--box", box, "--orientation", "180,-90,0"]
    assert main([*line, "-o", str(folder)]) == 2
    assert "error[C009]" in capsys.readouterr().err


def test_a_design_cannot_be_given_more_moves_than_lines():
    with pytest.raises(OlpError) as raised:
        design_experiment(WANTED._replace(box=BOX + 5.0))
    assert "out of reach" in raised.value.diagnostics[0].message


def test_a_robot_that_points_its_tool_down_flips_its_wrist(tmp_path):
    box = np.array([[900.0, 1300.0], [-300.0, 300.0], [0.0, 400.0]]) * mm
    wanted = Wanted(load_robot("yaskawa/ma2010"), box, 4, 0.3, (180 * deg, 0.0, 0.0))
    experiment = design_experiment(wanted)
    write_experiment(experiment, tmp_path)
    flags = ",".join(map(str, experiment.posture))
    assert f"///RCONF {flags}".encode() in (tmp_path / "PROBE.JBI").read_bytes()
