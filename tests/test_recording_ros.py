"""ROS recordings, written with the libraries of their formats; durations are known from how the motions are made."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from olp.__main__ import main
from olp.core.units import deg
from olp.identification.recording import read_recording
from samples.recordings.make_logs import (
    DURATIONS,
    PERIOD,
    START,
    TURN,
    motions,
    write_mcap,
    write_rosbag2,
    write_trajectories,
)

TIME, AXES, BEGINS = motions()
JOINTS = ("a_joint_2", "a_joint_10", "a_joint_3", "a_joint_4", "a_joint_5", "a_joint_7")


def imported(tmp_path: Path, *words: object) -> Path:
    assert main(["recording", "import", *map(str, words), "-o", str(tmp_path / "made")]) == 0
    return tmp_path / "made"


def told(capsys: pytest.CaptureFixture[str], tmp_path: Path, *words: object) -> str:
    assert main(["recording", "import", *map(str, words), "-o", str(tmp_path / "made")]) == 2
    assert not (tmp_path / "made").exists()
    return capsys.readouterr().err


@pytest.fixture(scope="module")
def mcap(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("mcap") / "run.mcap"
    write_mcap(path, TIME, AXES)
    return path


def test_motions_of_joint_states_have_their_durations(
    mcap: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recording = read_recording(imported(tmp_path, mcap, "--robot", "universal-robots/ur5e"))
    moves = recording.moves
    assert moves.duration.tolist() == pytest.approx(DURATIONS, abs=PERIOD)
    assert (moves.t_start - moves.t_start[0]).tolist() == pytest.approx(
        np.array(BEGINS) - BEGINS[0], abs=PERIOD
    )
    # In the order of the arm, not of the alphabet.
    assert moves.joints_end[0] / deg == pytest.approx((START + TURN) / deg, abs=0.01)
    assert set(moves.kinds) == {"joint"}
    assert recording.log is not None
    assert len(recording.log) == len(TIME)
    assert recording.settings.time_resolution == pytest.approx(PERIOD)
    said = capsys.readouterr()
    assert "4 motions between rests" in said.err
    assert "messages of other joints were left out" in said.err


def test_planned_trajectories_are_paired_as_the_simulation(mcap: Path, tmp_path: Path) -> None:
    planned = tuple(d - 0.05 for d in DURATIONS)
    write_trajectories(tmp_path / "plan.mcap", planned, BEGINS)
    moves = read_recording(imported(tmp_path, mcap, "--sim", tmp_path / "plan.mcap")).moves
    assert moves.sim.tolist() == pytest.approx(planned, abs=1e-6)
    assert moves.duration.tolist() == pytest.approx(DURATIONS, abs=PERIOD)


def test_a_simulated_run_of_another_program_is_refused(
    mcap: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_trajectories(tmp_path / "plan.mcap", DURATIONS[:3], BEGINS[:3])
    assert "error[D054]: 4 measured motions and 3" in told(
        capsys, tmp_path, mcap, "--sim", tmp_path / "plan.mcap"
    )


def test_a_rosbag2_folder_is_read_and_joints_come_in_the_order_of_their_numbers(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_rosbag2(tmp_path / "bag", TIME, AXES, JOINTS)
    made = imported(tmp_path, tmp_path / "bag")
    moves = read_recording(made).moves
    assert moves.duration.tolist() == pytest.approx(DURATIONS, abs=PERIOD)
    assert moves.joints_start[0] / deg == pytest.approx(START[[0, 2, 3, 4, 5, 1]] / deg, abs=1e-3)
    assert "in the order of their numbers" in capsys.readouterr().err
    # The file alone, and an order of one's own.
    (database,) = (tmp_path / "bag").glob("*.db3")
    words = [
        "recording",
        "import",
        str(database),
        "--joints",
        ",".join(JOINTS),
        "-o",
        str(tmp_path / "other"),
    ]
    assert main(words) == 0
    assert read_recording(tmp_path / "other").moves.joints_start[0] / deg == pytest.approx(
        START / deg, abs=1e-3
    )


def test_the_program_that_ran_names_the_moves(mcap: Path, tmp_path: Path) -> None:
    poses = [", ".join(map(str, q)) for q in (START, START + TURN)]
    lines = [f"  movej([{poses[i]}], a=4, v=2)\n  sleep(0.4)" for i in (0, 1, 0, 1, 0)]
    (tmp_path / "pick.script").write_text("\n".join(["def pick():", *lines, "end", "pick()"]) + "\n", "utf-8")
    words = [mcap, "--job", tmp_path / "pick.script", "--robot", "universal-robots/ur5e"]
    moves = read_recording(imported(tmp_path, *words)).moves
    moved = [t for t, kind in zip(moves.duration.tolist(), moves.kinds, strict=True) if kind == "joint"]
    assert moved == pytest.approx(DURATIONS, abs=0.03)
    assert moves.line[moves.duration > 0].min() > 1


def test_topics_and_joints_that_are_not_there_are_told(
    mcap: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = told(capsys, tmp_path, mcap, "--topic", "/joint_state")
    assert "error[D058]: there is no topic /joint_state" in said
    assert "did you mean /joint_states?" in said
    said = told(capsys, tmp_path, mcap, "--joints", "ur5e_elbow_joint,ur5e_elbo_joint")
    assert "error[D059]: there is no joint ur5e_elbo_joint" in said
    assert "did you mean ur5e_elbow_joint?" in said


@pytest.mark.parametrize("cut", [0, 7, 900, -300])
def test_a_recording_that_broke_off_is_one_error(
    mcap: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], cut: int
) -> None:
    (tmp_path / "cut.mcap").write_bytes(mcap.read_bytes()[:cut])
    said = told(capsys, tmp_path, tmp_path / "cut.mcap")
    assert said.count("error[D002]") == 1
    assert "Traceback" not in said


def test_without_the_library_it_says_what_to_install(
    mcap: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "rosbags", None)
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    assert 'pip install "olp[ros]"' in told(capsys, tmp_path, mcap)
