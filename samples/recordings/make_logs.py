"""Writes logs/: one made-up run of four motions whose durations are known, as other recorders write it.

python samples/recordings/make_logs.py
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from mcap_ros2.writer import Writer as McapWriter
from numpy.typing import NDArray

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent.parent))

from olp.core.units import deg  # noqa: E402
from olp.robots.robot import load_robot  # noqa: E402

Floats = NDArray[np.float64]
DURATIONS = (0.5, 0.8, 0.3, 1.2)  # [s] of the motions
REST = 0.4  # [s] before, between and behind them
PERIOD = 0.008  # [s]
UR_JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
START = np.array([0.2, -1.4, 1.6, -0.3, 0.9, 0.1])  # [rad]
TURN = np.array([0.5, -0.2, 0.3, 0.4, -0.6, 0.25])  # [rad] of each motion, there and back

_HEADER = """
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
_STATE = (
    "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort"
    + _HEADER
)
TRAJECTORY = (
    "std_msgs/Header header\nstring[] joint_names\ntrajectory_msgs/JointTrajectoryPoint[] points"
    + _HEADER
    + """================================================================================
MSG: trajectory_msgs/JointTrajectoryPoint
float64[] positions
float64[] velocities
float64[] accelerations
float64[] effort
builtin_interfaces/Duration time_from_start
================================================================================
MSG: builtin_interfaces/Duration
int32 sec
uint32 nanosec
"""
)


def motions(
    durations: tuple[float, ...] = DURATIONS, period: float = PERIOD
) -> tuple[Floats, Floats, list[float]]:
    """Times (n,) [s], axes (n, 6) [rad], and when each motion begins [s]."""
    begins, at = [], REST
    for duration in durations:
        begins.append(at)
        at += duration + REST
    time = np.arange(0.0, at, period)
    share = np.zeros(len(time))
    for number, (begin, duration) in enumerate(zip(begins, durations, strict=True)):
        part = np.clip((time - begin) / duration, 0.0, 1.0)
        # Constant acceleration and deceleration: half the time each.
        way = np.where(part < 0.5, 2 * part**2, 1 - 2 * (1 - part) ** 2)
        share += way * (1 if number % 2 == 0 else -1)
    return time, START + share[:, None] * TURN, begins


def write_mcap(
    path: Path, time: Floats, axes: Floats, topic: str = "/joint_states", gripper: bool = True
) -> None:
    """As a driver of Universal Robots publishes: joints in the order of the alphabet, a gripper between them."""
    names = [f"ur5e_{name}_joint" for name in UR_JOINTS]
    order = sorted(range(6), key=lambda i: names[i])
    with path.open("wb") as file:
        writer = McapWriter(file)
        schema = writer.register_msgdef("sensor_msgs/msg/JointState", _STATE)
        for number, (t, row) in enumerate(zip(time.tolist(), axes.tolist(), strict=True)):
            stamp = 1_700_000_000_000_000_000 + round(t * 1e9)
            said = _state(stamp, [names[i] for i in order], [row[i] for i in order])
            writer.write_message(topic, schema, said, stamp + 250_000, stamp, number)
            if gripper and number % 10 == 0:
                writer.write_message(
                    topic, schema, _state(stamp, ["finger_joint"], [0.1]), stamp, stamp, number
                )
        writer.finish()


def _state(stamp: int, names: list[str], position: list[float]) -> dict[str, object]:
    return {"header": _header(stamp), "name": names, "position": position, "velocity": [], "effort": []}


def _header(stamp: int) -> dict[str, object]:
    return {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}, "frame_id": ""}


def write_trajectories(path: Path, durations: tuple[float, ...], begins: list[float]) -> None:
    """The planned motions, a trajectory each, on a controller's topic."""
    names = [f"ur5e_{name}_joint" for name in UR_JOINTS]
    with path.open("wb") as file:
        writer = McapWriter(file)
        schema = writer.register_msgdef("trajectory_msgs/msg/JointTrajectory", TRAJECTORY)
        for number, (begin, duration) in enumerate(zip(begins, durations, strict=True)):
            stamp = 1_700_000_000_000_000_000 + round(begin * 1e9)
            ends = [START, START + TURN] if number % 2 == 0 else [START + TURN, START]
            points = [
                {
                    "positions": end.tolist(),
                    "velocities": [],
                    "accelerations": [],
                    "effort": [],
                    "time_from_start": {"sec": int(t), "nanosec": round(t % 1 * 1e9)},
                }
                for t, end in zip((0.0, duration), ends, strict=True)
            ]
            said = {"header": _header(stamp), "joint_names": names, "points": points}
            writer.write_message("/arm_controller/joint_trajectory", schema, said, stamp, stamp, number)
        writer.finish()


def write_rosbag2(path: Path, time: Floats, axes: Floats, joints: tuple[str, ...]) -> None:
    """A folder with metadata.yaml and an SQLite file, by the library that others read and write them with."""
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    state = store.types["sensor_msgs/msg/JointState"]
    header, clock = store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"]
    none = np.zeros(0)
    with Writer(path, version=9) as writer:
        channel = writer.add_connection("/joint_states", state.__msgtype__, typestore=store)
        for t, row in zip(time.tolist(), axes, strict=True):
            stamp = round(t * 1e9) + 10**9
            told = header(clock(stamp // 10**9, stamp % 10**9), "")
            raw = store.serialize_cdr(state(told, list(joints), row, none, none), state.__msgtype__)
            writer.write(channel, stamp, raw)


def fanuc_csv(time: Floats, axes: Floats) -> str:
    """As the KAREL program of fanuc_motion_program_exec writes it: whole milliseconds, four decimals, blanks before."""
    rows = [
        f" {round(t * 1000)}," + ",".join(f"{q:9.4f}" for q in row)
        for t, row in zip(time, axes / deg, strict=True)
    ]
    return "\n".join(["timestamp,J1,J2,J3,J4,J5,J6", *rows]) + "\n"


def abb_csv(time: Floats, axes: Floats, begins: list[float]) -> str:
    """As abb_motion_program_exec hands it on: seconds, the number of the command."""
    number = np.searchsorted(np.array(begins), time, side="right")
    rows = [
        f"{t:.3f},{n}," + ",".join(f"{q:.6f}" for q in row)
        for t, n, row in zip(time, number, axes / deg, strict=True)
    ]
    return "\n".join(["timestamp,cmdnum,J1,J2,J3,J4,J5,J6", *rows]) + "\n"


def pulse_csv(time: Floats, axes: Floats, robot: str = "yaskawa/gp25") -> str:
    """As a program on a Yaskawa controller would: its own axes, in pulses."""
    pulses = np.rint(axes * load_robot(robot).pulses_per_unit).astype(int)
    rows = [
        f"{round(t * 1000)}," + ",".join(map(str, row)) for t, row in zip(time, pulses.tolist(), strict=True)
    ]
    return "\n".join(["Time_ms,S_pulse,L_pulse,U_pulse,R_pulse,B_pulse,T_pulse", *rows]) + "\n"


def main() -> None:
    folder = HERE / "logs"
    folder.mkdir(exist_ok=True)
    time, axes, begins = motions()
    write_mcap(folder / "run.mcap", time, axes)
    write_trajectories(folder / "plan.mcap", tuple(d - 0.05 for d in DURATIONS), begins)
    for name, text in (
        ("fanuc.csv", fanuc_csv(time, axes)),
        ("abb.csv", abb_csv(time, axes, begins)),
        ("yaskawa.csv", pulse_csv(time, axes)),
    ):
        (folder / name).write_text(text, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
