"""ROS recordings, written with the libraries of their formats; durations are known from how the motions are made."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from mcap_ros2.writer import Writer as McapWriter

from olp.__main__ import main
from olp.core.units import deg
from olp.identification.recording import read_recording, ros_bag
from samples.recordings import make_logs
from samples.recordings.make_logs import (
    DURATIONS,
    PERIOD,
    START,
    TRAJECTORY,
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


POINT = {"velocities": [], "accelerations": [], "effort": [], "time_from_start": {"sec": 0, "nanosec": 0}}


def write_controller_state(path: Path, feedback: str, reference: str) -> None:
    """As a joint_trajectory_controller publishes: what it asks for is 1 mrad ahead; both spellings of its fields."""
    definition = "std_msgs/Header header\nstring[] joint_names\n" + "".join(
        f"trajectory_msgs/JointTrajectoryPoint {name}\n" for name in (reference, feedback, "error")
    )
    definition += TRAJECTORY.split("points", 1)[1].lstrip("\n")
    with path.open("wb") as file:
        writer = McapWriter(file)
        schema = writer.register_msgdef("control_msgs/msg/JointTrajectoryControllerState", definition)
        for number, (t, row) in enumerate(zip(TIME.tolist(), AXES, strict=True)):
            stamp = 10**9 + round(t * 1e9)
            parts = {feedback: row, reference: row + 0.001, "error": row * 0}
            said = {name: {**POINT, "positions": values.tolist()} for name, values in parts.items()}
            header = {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}, "frame_id": ""}
            message = {"header": header, "joint_names": list(JOINTS), **said}
            writer.write_message("/arm_controller/state", schema, message, stamp, stamp, number)
        writer.finish()


@pytest.mark.parametrize("names", [("feedback", "reference"), ("actual", "desired")])
def test_a_controllers_state_has_measured_and_commanded_axes(names: tuple[str, str], tmp_path: Path) -> None:
    write_controller_state(tmp_path / "state.mcap", *names)
    made = imported(tmp_path, tmp_path / "state.mcap", "--joints", ",".join(JOINTS))
    log = read_recording(made).log
    assert log is not None
    assert log.command is not None
    assert log.q == pytest.approx(AXES, abs=1e-9)
    assert log.command - log.q == pytest.approx(0.001, abs=1e-9)


def test_trajectories_beside_joint_states_are_their_commands(tmp_path: Path) -> None:
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    types = store.types
    state, plan = types["sensor_msgs/msg/JointState"], types["trajectory_msgs/msg/JointTrajectory"]
    point, span = types["trajectory_msgs/msg/JointTrajectoryPoint"], types["builtin_interfaces/msg/Duration"]
    header, clock = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
    none, names = np.zeros(0), ["b", "a"]  # the arm's order is the trajectory's
    with Writer(tmp_path / "bag", version=9) as writer:
        states = writer.add_connection("/joint_states", state.__msgtype__, typestore=store)
        plans = writer.add_connection("/plan", plan.__msgtype__, typestore=store)
        for n in range(201):
            stamp = 10**9 + n * 10**7
            told = header(clock(stamp // 10**9, stamp % 10**9), "")
            q = min(max(n - 52, 0), 100) / 100  # 20 ms behind the plan
            raw = store.serialize_cdr(
                state(told, ["a", "b"], np.array([2 * q, q]), none, none), state.__msgtype__
            )
            writer.write(states, stamp, raw)
            if n == 50:
                points = [
                    point(np.array(ends), none, none, none, span(s, 0))
                    for s, ends in ((0, [0.0, 0]), (1, [1.0, 2]))
                ]
                raw = store.serialize_cdr(plan(told, names, points), plan.__msgtype__)
                writer.write(plans, stamp, raw)
    log = read_recording(imported(tmp_path, tmp_path / "bag")).log
    assert log is not None
    assert log.command is not None
    inside = (log.time > 1.53) & (log.time < 2.49)
    assert (log.command - log.q)[inside] == pytest.approx(
        np.tile([0.02, 0.04], (int(inside.sum()), 1)), abs=1e-6
    )


def test_several_topics_with_joints_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    with Writer(tmp_path / "bag", version=9) as writer:
        for topic in ("/left/joint_states", "/right/joint_states"):
            writer.add_connection(topic, "sensor_msgs/msg/JointState", typestore=store)
    said = told(capsys, tmp_path, tmp_path / "bag")
    assert "error[D058]: several topics have joints: /left/joint_states, /right/joint_states" in said
    assert "--topic /left/joint_states" in said
    assert "error[D058]: the topic has no messages" in told(
        capsys, tmp_path, tmp_path / "bag", "--topic", "/left/joint_states"
    )


def test_a_bag_of_ros_1_is_read(tmp_path: Path) -> None:
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    state, header = store.types["sensor_msgs/msg/JointState"], store.types["std_msgs/msg/Header"]
    clock, none = store.types["builtin_interfaces/msg/Time"], np.zeros(0)
    with Writer(tmp_path / "run.bag") as writer:
        channel = writer.add_connection("/joint_states", state.__msgtype__, typestore=store)
        for n, (t, row) in enumerate(zip(TIME.tolist(), AXES, strict=True)):
            stamp = round(t * 1e9) + 10**9
            told = header(seq=n, stamp=clock(stamp // 10**9, stamp % 10**9), frame_id="")
            raw = store.serialize_ros1(state(told, list(JOINTS), row, none, none), state.__msgtype__)
            writer.write(channel, stamp, raw)
    moves = read_recording(imported(tmp_path, tmp_path / "run.bag")).moves
    assert moves.duration.tolist() == pytest.approx(DURATIONS, abs=PERIOD)


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere the system has no bound of memory")
def test_a_small_bag_that_unpacks_to_gigabytes_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.mcap"
    with path.open("wb") as file:
        writer = McapWriter(file, chunk_size=400_000_000)
        kind = writer.register_msgdef("sensor_msgs/msg/JointState", make_logs._STATE)
        header = {"stamp": {"sec": 1, "nanosec": 0}, "frame_id": "x" * 200_000_000}
        state = {"header": header, "name": ["x"], "position": [0.0], "velocity": [], "effort": []}
        writer.write_message("/joint_states", kind, state)
        writer.finish()
    assert path.stat().st_size < 1_000_000
    resource = pytest.importorskip("resource")
    monkeypatch.setattr(ros_bag, "_MOST_MEMORY", 100_000_000)
    before = resource.getrlimit(resource.RLIMIT_AS)
    assert "D003" in told(capsys, tmp_path, path)
    assert resource.getrlimit(resource.RLIMIT_AS) == before
