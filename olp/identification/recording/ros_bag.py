"""Reads logs out of ROS recordings: MCAP files, rosbag2 folders and files (`.mcap`, `.db3`), bags of ROS 1.

Axes are those of sensor_msgs/JointState, control_msgs/JointTrajectoryControllerState or
trajectory_msgs/JointTrajectory, in SI as these messages define them. Codes: D002 unreadable, D003 too large, D004 no
rosbags, D026 what was read, D058 no topic, or not which, D059 no such joint.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Generator, Iterable, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, error, info, warning
from olp.identification.recording.log import Log
from olp.languages.recorders import controller_logs

Floats = NDArray[np.float64]
_STATE: Final = "sensor_msgs/msg/JointState"
_CONTROLLER: Final = "control_msgs/msg/JointTrajectoryControllerState"
_TRAJECTORY: Final = "trajectory_msgs/msg/JointTrajectory"
_KINDS: Final = (_STATE, _CONTROLLER, _TRAJECTORY)
_SUFFIXES: Final = (".mcap", ".db3", ".bag")
_MOST_MESSAGES: Final = 2_000_000
_MOST_BYTES: Final = 8_000_000_000
_MOST_MEMORY: Final = 6_000_000_000  # [bytes] for one recording: a few of them can unpack to anything
_NS: Final = 1e-9  # [s]


class Trajectory(NamedTuple):
    """A commanded trajectory: when each of its points is due (p,) [s] and where they are (p, k) [rad]."""

    time: Floats
    points: Floats


class Bag(NamedTuple):
    """`trajectories`: those of a topic that has nothing else; their points are the samples of `log` then."""

    log: Log
    joints: tuple[str, ...]
    trajectories: tuple[Trajectory, ...]
    diagnostics: tuple[Diagnostic, ...]


class _Sample(NamedTuple):
    time: float
    names: tuple[str, ...]
    position: Floats
    velocity: Floats
    effort: Floats
    command: Floats


def is_bag(path: Path) -> bool:
    """Whether this is a bag, by its name: nothing is opened."""
    return (path / "metadata.yaml").is_file() if path.is_dir() else path.suffix.lower() in _SUFFIXES


def read_bag(path: Path, topic: str = "", joints: Sequence[str] = ()) -> Bag:
    """The axes that a bag recorded. Raises OlpError.

    `topic`: whose messages (default: the only one that has joints). `joints`: their order on the arm (default: that of
    a trajectory, of the numbers in their names, or of a driver that a vendor knows).
    """
    file = str(path)
    _check_size(path)
    reader = _open(path)
    # The library raises whatever a broken file leads it to: key, value, index and struct errors, and its parts' own.
    try:
        with _bounded_memory(_MOST_MEMORY), reader:
            return _read(reader, file, topic, joints)
    except OlpError:
        raise
    except MemoryError:
        says = f"unpacked it takes more than {_MOST_MEMORY / 1e9:g} GB of memory"
        raise OlpError(error("D003", says, file=file, help="record the topic of the joints alone")) from None
    except Exception as problem:
        says = f"not a whole ROS recording: {problem or type(problem).__name__}"
        help = "a recorder that was cut off left it open: mcap recover, or ros2 bag reindex"
        raise OlpError(error("D002", says[:300], file=file, help=help)) from None


@contextmanager
def _bounded_memory(size: int) -> Generator[None]:
    """At most `size` [bytes] more while it lasts, where the system can (Linux); beyond that: MemoryError."""
    try:
        import resource

        used = int(Path("/proc/self/statm").read_bytes().split()[0]) * resource.getpagesize()
    except (ImportError, OSError):
        yield
        return
    before = resource.getrlimit(resource.RLIMIT_AS)
    most = min((one for one in before if one != resource.RLIM_INFINITY), default=used + size)
    resource.setrlimit(resource.RLIMIT_AS, (min(most, used + size), before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


def _open(path: Path) -> Any:
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        help = 'install it: pip install "olp[ros]"'
        raise OlpError(
            error("D004", "reading ROS recordings needs rosbags", file=str(path), help=help)
        ) from None
    try:
        # Bags of Humble and before do not hold the definitions of their messages.
        return AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE))
    except Exception as problem:
        says = f"not a ROS recording: {problem or type(problem).__name__}"
        raise OlpError(error("D002", says[:300], file=str(path))) from None


def _check_size(path: Path) -> None:
    files = list(path.iterdir()) if path.is_dir() else [path]
    if sum(file.stat().st_size for file in files if file.is_file()) > _MOST_BYTES:
        says = f"the recording has more than {_MOST_BYTES // 1_000_000_000} GB"
        raise OlpError(error("D003", says, file=str(path), help="record the topic of the joints alone"))


def _read(reader: Any, file: str, topic: str, joints: Sequence[str]) -> Bag:
    kinds = {c.topic: str(c.msgtype) for c in reader.connections}
    chosen = _topic(kinds, topic, file)
    if kinds[chosen] == _TRAJECTORY:
        return _planned(reader, file, chosen, joints)
    samples = list(_samples(reader, chosen, file))
    planned = [name for name, kind in kinds.items() if kind == _TRAJECTORY]
    trajectories = list(_trajectory_messages(reader, planned[0])) if len(planned) == 1 else []
    told_order = trajectories[0][0] if trajectories else ()
    names, left_out = _names(samples, joints, file)
    order, why = _order(names, told_order, joints)
    log = _log(samples, names, order, file)
    if log.command is None and trajectories:
        log = _with_commands(log, order, trajectories)
    says = f"{chosen} ({kinds[chosen].rsplit('/', 1)[1]}): {len(log):,} samples of {', '.join(order)}, {why}"
    told = [info("D026", says, file=file, help="--joints A,B,… says another order; all are taken to turn")]
    if left_out:
        told.append(info("D026", f"{left_out:,} messages of other joints were left out", file=file))
    return Bag(log, order, (), tuple(told))


def _topic(kinds: dict[str, str], topic: str, file: str) -> str:
    """The topic to be read. Raises OlpError (D058)."""
    fitting = {kind: [name for name, other in kinds.items() if other == kind] for kind in _KINDS}
    known = [name for names in fitting.values() for name in names]
    if topic:
        if topic in known:
            return topic
        near = get_close_matches(topic, known, 1)
        listed = f"topics with joints: {', '.join(known) or 'none'}"
        says = f"topic {topic} is {kinds[topic]}" if topic in kinds else f"there is no topic {topic}"
        raise OlpError(
            error("D058", says, file=file, help=f"did you mean {near[0]}? {listed}" if near else listed)
        )
    for names in fitting.values():
        if len(names) == 1:
            return names[0]
        if names:
            says = f"several topics have joints: {', '.join(names)}"
            raise OlpError(error("D058", says, file=file, help=f"name one: --topic {names[0]}"))
    listed = ", ".join(f"{name} ({kind})" for name, kind in list(kinds.items())[:10]) or "none"
    help = f"record a topic of type {', '.join(_KINDS)}; its topics are {listed}"
    raise OlpError(error("D058", "no topic has joints", file=file, help=help))


def _messages(reader: Any, topic: str) -> Iterable[tuple[float, Any]]:
    """(time [s], message): the time that the sender gave it, where it gave none the recorder's."""
    connections = [c for c in reader.connections if c.topic == topic]
    for count, (connection, stamp, raw) in enumerate(reader.messages(connections=connections)):
        if count >= _MOST_MESSAGES:
            says = f"{topic} has more than {_MOST_MESSAGES:,} messages"
            raise OlpError(error("D003", says, help="cut the recording in pieces"))
        message = reader.deserialize(raw, connection.msgtype)
        sent = message.header.stamp
        seconds = sent.sec + sent.nanosec * _NS
        yield (seconds if seconds > 0 else stamp * _NS), message


def _samples(reader: Any, topic: str, file: str) -> Iterable[_Sample]:
    none = np.zeros(0)
    for time, message in _messages(reader, topic):
        if hasattr(message, "position"):
            names, parts = message.name, (message.position, message.velocity, message.effort, none)
        else:
            actual = message.feedback if hasattr(message, "feedback") else message.actual
            asked = message.reference if hasattr(message, "reference") else message.desired
            names, parts = message.joint_names, (actual.positions, actual.velocities, none, asked.positions)
        position, *rest = (np.asarray(part, dtype=np.float64) for part in parts)
        if len(position) != len(names) or not np.isfinite(position).all():
            says = f"the message at {time:.6f} s on {topic} has {len(names)} joints and not as many positions"
            raise OlpError(error("D015", says, file=file))
        velocity, effort, command = (part if len(part) == len(names) else none for part in rest)
        yield _Sample(time, tuple(names), position, velocity, effort, command)


def _names(samples: Sequence[_Sample], joints: Sequence[str], file: str) -> tuple[frozenset[str], int]:
    """The joints to be read, and how many messages do not have them all. Raises OlpError (D059)."""
    sets = Counter(frozenset(sample.names) for sample in samples)
    if not sets:
        raise OlpError(error("D058", "the topic has no messages", file=file))
    there = sorted(frozenset().union(*sets))
    if gone := [name for name in joints if name not in there]:
        raise OlpError(*(_no_joint(name, there, file) for name in gone))
    # A gripper may tell its fingers on the same topic: the arm has more joints.
    chosen = frozenset(joints) or max(sets, key=lambda names: (len(names), sets[names]))
    return chosen, sum(count for names, count in sets.items() if not chosen <= names)


def _no_joint(name: str, there: Sequence[str], file: str) -> Diagnostic:
    near = get_close_matches(name, there, 1)
    listed = f"joints: {', '.join(there)}"
    help = f"did you mean {near[0]}? {listed}" if near else listed
    return error("D059", f"there is no joint {name}", file=file, help=help)


def _order(
    names: frozenset[str], trajectory: Sequence[str], joints: Sequence[str]
) -> tuple[tuple[str, ...], str]:
    """The joints from the base to the flange, and what says so. Messages have them in any order."""
    if joints:
        return tuple(joints), "in the order of --joints"
    if names <= set(trajectory):
        return tuple(name for name in trajectory if name in names), "in the order of the trajectories"
    for known in controller_logs():
        ends = {end: name for end in known.joint_names for name in names if name.endswith(end)}
        if len(ends) == len(known.joint_names) == len(names):
            return tuple(ends[end] for end in known.joint_names), "in the order of their driver"
    numbers = {name: re.findall(r"\d+", name) for name in names}
    if all(numbers.values()) and len({int(found[-1]) for found in numbers.values()}) == len(names):
        return tuple(sorted(names, key=lambda name: int(numbers[name][-1]))), "in the order of their numbers"
    return tuple(sorted(names)), "in the order of the alphabet, for nothing else tells it"


def _log(samples: Sequence[_Sample], names: frozenset[str], order: Sequence[str], file: str) -> Log:
    used = [sample for sample in samples if names <= set(sample.names)]
    # Stamps of several senders may overtake each other by a message.
    used.sort(key=lambda sample: sample.time)
    places: dict[tuple[str, ...], list[int]] = {}

    def column(part: str) -> Floats | None:
        cells = [getattr(sample, part) for sample in used]
        if not all(len(cell) for cell in cells):
            return None
        for sample in used:
            places.setdefault(sample.names, [sample.names.index(name) for name in order])
        rows = [cell[places[sample.names]] for cell, sample in zip(cells, used, strict=True)]
        values: Floats = np.stack(rows)
        return values if np.isfinite(values).all() else None

    position = column("position")
    assert position is not None  # every sample has as many as joints
    return Log(
        time=np.array([sample.time for sample in used]),
        q=position,
        slides=(False,) * len(order),
        command=column("command"),
        speed=column("velocity"),
        torque=column("effort"),
        file=file,
    )


def _trajectory_messages(reader: Any, topic: str) -> Iterable[tuple[tuple[str, ...], Trajectory]]:
    for time, message in _messages(reader, topic):
        due = [time + p.time_from_start.sec + p.time_from_start.nanosec * _NS for p in message.points]
        points = [np.asarray(p.positions, dtype=np.float64) for p in message.points]
        if points and all(len(point) == len(message.joint_names) for point in points):
            yield tuple(message.joint_names), Trajectory(np.array(due), np.stack(points))


def _planned(reader: Any, file: str, topic: str, joints: Sequence[str]) -> Bag:
    """A topic of trajectories alone: each is one motion, from its first point to its last."""
    messages = list(_trajectory_messages(reader, topic))
    if not messages:
        raise OlpError(error("D058", f"{topic} has no trajectory of positions", file=file))
    names = messages[0][0]
    if gone := [name for name in joints if name not in names]:
        raise OlpError(*(_no_joint(name, names, file) for name in gone))
    order = tuple(joints) or names
    same = [(there, t) for there, t in messages if set(order) <= set(there) and len(t.time) > 1]
    trajectories = tuple(
        Trajectory(t.time, t.points[:, [there.index(n) for n in order]]) for there, t in same
    )
    told = [
        info(
            "D026",
            f"{topic} (JointTrajectory): {len(trajectories):,} trajectories of {', '.join(order)}",
            file=file,
        )
    ]
    if len(same) < len(messages):
        says = f"{len(messages) - len(same):,} trajectories of other joints or of one point were left out"
        told.append(warning("D060", says, file=file))
    if not trajectories:
        raise OlpError(error("D058", f"{topic} has no trajectory of several points", file=file))
    log = Log(
        time=np.concatenate([t.time for t in trajectories]),
        q=np.concatenate([t.points for t in trajectories]),
        slides=(False,) * len(order),
        file=file,
    )
    return Bag(log, order, trajectories, tuple(told))


def _with_commands(
    log: Log, order: Sequence[str], messages: Sequence[tuple[tuple[str, ...], Trajectory]]
) -> Log:
    """The same log with the commanded axes: straight between the points of a trajectory, held behind it."""
    from dataclasses import replace

    command = np.full_like(log.q, np.nan)
    for names, trajectory in messages:
        if not set(order) <= set(names):
            continue
        points = trajectory.points[:, [names.index(name) for name in order]]
        after = log.time >= trajectory.time[0]
        for axis in range(len(order)):
            command[after, axis] = np.interp(log.time[after], trajectory.time, points[:, axis])
    before = np.isnan(command[:, 0])
    if before.all():
        return log
    # Nothing was asked for yet: the arm stands where it is asked to be.
    command[before] = log.q[before]
    return replace(log, command=command)
