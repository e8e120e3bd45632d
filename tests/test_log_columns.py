"""Logs whose columns are called as a controller or its client calls them; formats as their makers document them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.core.units import deg, mm
from olp.identification.recording import read_recording
from olp.identification.recording.log_reader import read_log
from olp.robots.kinematics import forward
from olp.robots.robot import load_robot

_AXES = np.linspace([0.1, -1.3, 1.2, -1.4, -1.5, 0.2], [0.5, -1.1, 1.0, -1.2, -1.4, 0.4], 11)


def rtde(blank: str, axes: np.ndarray = _AXES) -> str:
    """As the RTDE client of Universal Robots writes a recording: vectors spread over columns, values as Python's."""
    place, turn = forward(load_robot("universal-robots/ur10e"), axes)
    vector = Rotation.from_matrix(turn).as_rotvec()
    names = ["timestamp", *(f"target_q_{i}" for i in range(6)), *(f"actual_q_{i}" for i in range(6))]
    names += [*(f"actual_TCP_pose_{i}" for i in range(6)), "speed_scaling", "output_int_register_0"]
    rows = [
        [100 + 0.002 * n, *(q + 0.001), *q, *p, *v, 1.0, 7]
        for n, (q, p, v) in enumerate(zip(axes.tolist(), place.tolist(), vector.tolist(), strict=True))
        for q in [np.array(q)]
    ]
    return "\n".join([blank.join(names), *(blank.join(map(repr, map(float, row))) for row in rows)]) + "\n"


@pytest.mark.parametrize("blank", [" ", ","])
def test_an_rtde_recording_is_read_in_its_own_words(tmp_path: Path, blank: str) -> None:
    path = tmp_path / "run.csv"
    path.write_text(rtde(blank), encoding="utf-8")
    log, told, _ = read_log(path)
    assert log.time[:3].tolist() == pytest.approx([100.0, 100.002, 100.004])
    assert log.q == pytest.approx(_AXES, abs=1e-12)
    assert log.command == pytest.approx(_AXES + 0.001, abs=1e-12)
    place, turn = forward(load_robot("universal-robots/ur10e"), _AXES)
    assert log.position is not None
    assert log.angles is not None
    assert log.position / mm == pytest.approx(place / mm, abs=1e-6)
    # The contract's angles: R = Rz Ry Rx about fixed axes, told by another library.
    assert log.angles / deg == pytest.approx(
        Rotation.from_matrix(turn).as_euler("xyz", degrees=True), abs=1e-9
    )
    assert log.covariates["speed_scaling"].tolist() == [1.0] * 11
    assert log.covariates["output_int_register_0"].tolist() == [7.0] * 11
    assert [d.code for d in told] == ["D026"]


def test_no_turn_is_no_angle(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text(rtde(" "), encoding="utf-8")
    lines = (tmp_path / "run.csv").read_text("utf-8").splitlines()
    names = lines[0].split()
    cells = [line.split() for line in lines[1:]]
    for row in cells:
        for i in range(3, 6):
            row[names.index(f"actual_TCP_pose_{i}")] = "0.0"
    (tmp_path / "run.csv").write_text("\n".join([lines[0], *map(" ".join, cells)]), encoding="utf-8")
    log, _, _ = read_log(tmp_path / "run.csv")
    assert log.angles is not None
    assert (log.angles == 0.0).all()


def test_a_motion_program_log_is_read_in_its_own_words(tmp_path: Path) -> None:
    rows = [f"{0.004 * n},{n // 4},{10 + n},20,30,-40,50,60" for n in range(8)]
    (tmp_path / "log.csv").write_text(
        "\n".join(["timestamp,cmdnum,J1,J2,J3,J4,J5,J6", *rows]), encoding="utf-8"
    )
    log, told, _ = read_log(tmp_path / "log.csv")
    assert (log.q[:, 0] / deg).tolist() == pytest.approx([10.0 + n for n in range(8)])
    assert (log.q[0, 1:] / deg).tolist() == pytest.approx([20, 30, -40, 50, 60])
    assert log.move is None  # commands count waits, moves do not
    assert log.covariates["cmdnum"].tolist() == [0.0] * 4 + [1.0] * 4
    assert [d.code for d in told] == ["D026"]


def test_other_names_are_told_as_before(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("timestamp,J1,J2\n0,1,2\n", encoding="utf-8")
    with pytest.raises(OlpError, match="the column t_s is missing"):
        read_log(tmp_path / "log.csv")
    (tmp_path / "log.csv").write_text(rtde(" ").replace("100.004 ", "99.0 "), encoding="utf-8")
    with pytest.raises(OlpError, match="row 3: t_s runs backwards"):
        read_log(tmp_path / "log.csv")


def test_moves_of_an_rtde_recording_and_the_program_that_ran(tmp_path: Path) -> None:
    """From a robot's own file to a recording: 0.5 rad of one axis there and back, at rest for 0.2 s between."""
    ease = (1 - np.cos(np.linspace(0, np.pi, 251))) / 2  # 0.5 s at 500 Hz
    path = np.concatenate([np.zeros(100), ease, np.ones(100), 1 - ease, np.zeros(100)])
    home = np.array([0.0, -1.5, 1.5, -1.5, -1.5, 0.0])
    axes = home + np.outer(path, [0.5, 0, 0, 0, 0, 0])
    (tmp_path / "run.csv").write_text(rtde(" ", axes), encoding="utf-8")
    poses = [", ".join(map(str, q)) for q in (home, home + np.array([0.5, 0, 0, 0, 0, 0]))]
    job = "\n".join(
        [
            "def pick():",
            *(f"  movej([{poses[i]}], a=4, v=2)\n  sleep(0.2)" for i in (0, 1, 0)),
            "end",
            "pick()",
        ]
    )
    (tmp_path / "pick.script").write_text(job + "\n", encoding="utf-8")
    words = ["recording", "from-log", str(tmp_path / "run.csv"), str(tmp_path / "pick.script")]
    assert main([*words, "--robot", "universal-robots/ur10e", "-o", str(tmp_path / "made")]) == 0
    moves = read_recording(tmp_path / "made").moves
    moved = [t for t, kind in zip(moves.duration.tolist(), moves.kinds, strict=True) if kind == "joint"]
    assert moved == pytest.approx([0.5, 0.5], abs=0.03)


def test_a_cell_too_many_in_the_first_row_and_one_too_few_below_are_told(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(
        "t_s,q1_deg,q2_deg\n0,0,0,9\n0.01,1,2\n0.02,4\n0.03,5,6\n", encoding="utf-8"
    )
    with pytest.raises(OlpError, match=r"(?s)row has 4 cells, the header 3.*row has 2 cells"):
        read_log(tmp_path / "log.csv")
