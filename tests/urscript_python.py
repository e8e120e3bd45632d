"""URScript run as Python: an oracle that shares nothing with olp.

Blocks become indents, `p[…]` a list, functions of the controller stand-ins that record. Rotations are scipy's.
"""

from __future__ import annotations

import contextlib
import math
import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

BLOCK = re.compile(r"(def|thread|if|elif|else|while)\b")
GLOBAL = re.compile(r"^global\s+")


class Pose(list):
    """x y z [m] and a rotation vector [rad]."""

    def matrix(self) -> np.ndarray:
        result = np.eye(4)
        result[:3, :3] = Rotation.from_rotvec(self[3:6]).as_matrix()
        result[:3, 3] = self[:3]
        return result


def pose_of(matrix: np.ndarray) -> Pose:
    return Pose([*matrix[:3, 3], *Rotation.from_matrix(matrix[:3, :3]).as_rotvec()])


@dataclass
class Robot:
    """What the script did: ("movej", place, how), ("sleep", s), ("out", n, on) … ; `inputs`: answers, cyclically."""

    done: list[tuple[Any, ...]] = field(default_factory=list)
    tool: Pose = field(default_factory=lambda: Pose([0.0] * 6))
    syncs: int = 0
    inputs: dict[int, bool] = field(default_factory=dict)

    def moves(self) -> list[tuple[Any, ...]]:
        return [one for one in self.done if one[0].startswith(("move", "optimove"))]


class HaltedError(Exception):
    pass


def run(text: str) -> Robot:
    """What the script does. An input turns on at the fifth cycle that is waited."""
    robot = Robot()
    names: dict[str, Any] = {**_stand_ins(robot)}
    exec(compile(to_python(text), "script", "exec"), names)
    main = re.search(r"^def\s+(\w+)\s*\(\)\s*:", text, re.M)
    assert main is not None
    with contextlib.suppress(HaltedError):
        names[main[1]]()
    return robot


def to_python(text: str) -> str:
    """The script as Python: every function on the level of the file, shared names declared in each."""
    lines = [_code(line) for line in text.splitlines()]
    lines = [line for line in lines if line]
    shared = {match[1] for line in lines if (match := re.match(r"global\s+(\w+)\s*=", line))}
    functions: list[list[str]] = []
    stack: list[str] = []
    open_functions: list[tuple[list[str], int]] = []
    for line in lines:
        word = BLOCK.match(line)
        if line == "end":
            if stack.pop() == "def":
                open_functions.pop()
            continue
        if word and word[1] in ("def", "thread"):
            body = [f"def {line.split(None, 1)[1]}"]
            functions.append(body)
            parameters = set(re.findall(r"(\w+)\s*[=,)]", line.split("(", 1)[1]))
            used = sorted(shared - parameters)
            body.append(f"  global {', '.join(used)}" if used else "  pass")
            # Arguments are passed by their values, those of lists too.
            body += [
                f"  {name} = own({name})"
                for name in re.findall(r"(\w+)\s*(?:=[^,)]*)?[,)]", line.split("(", 1)[1])
            ]
            stack.append("def")
            open_functions.append((body, len(stack)))
            continue
        body, base = open_functions[-1]
        depth = len(stack) - base + 1 - (bool(word) and word[1] in ("elif", "else"))
        line = re.sub(r"^(?:global|local)\s+", "", line)
        line = re.sub(r"^(\w+)\s*=\s*(?!=)(.*)$", r"\1 = own(\2)", line)
        body.append(f"{'  ' * depth}{_poses(line)}")
        if word and word[1] in ("if", "while"):
            stack.append(word[1])
        if word:
            body.append(f"{'  ' * (depth + 1)}pass")
    return "\n".join(line for body in functions for line in body) + "\n"


def _code(line: str) -> str:
    line = re.sub(r"\brun (?=\w+\()", "", line.strip())  # a thread runs to its end at once
    if line.startswith(("$", "join ", "kill ")):
        return ""
    return re.sub(r'("[^"]*")|#.*', lambda m: m[1] or "", line).strip().replace("halt", "halt_()") or ""


def _poses(line: str) -> str:
    """p[a, b] as Pose([a, b])."""
    out, closing, depth, at = "", [], 0, 0
    while at < len(line):
        if line.startswith("p[", at) and not (at and (line[at - 1].isalnum() or line[at - 1] == "_")):
            out += "Pose(["
            depth += 1
            closing.append(depth)
            at += 2
            continue
        if line[at] == "[":
            depth += 1
        if line[at] == "]":
            if closing and closing[-1] == depth:
                closing.pop()
                out += "])"
                depth -= 1
                at += 1
                continue
            depth -= 1
        out += line[at]
        at += 1
    return out


def _stand_ins(robot: Robot) -> dict[str, Any]:
    def move(word: str, joint: bool) -> Any:
        a, v = (1.4, 1.05) if joint else (1.2, 0.25)

        def stand_in(q: Any, a: float = a, v: float = v, t: float = 0, r: float = 0) -> None:
            robot.done.append((word, _place(q), {"a": a, "v": v, "t": t, "r": r}, Pose(robot.tool)))

        return stand_in

    def movec(via: Pose, to: Pose, a: float = 1.2, v: float = 0.25, r: float = 0, mode: int = 0) -> None:
        robot.done.append(
            ("movec", _place(to), {"a": a, "v": v, "r": r, "via": _place(via), "t": 0}, Pose(robot.tool))
        )

    def sync() -> None:
        robot.syncs += 1
        if robot.syncs > 10_000:
            raise RuntimeError("waits for ever")

    def read(n: int) -> bool:
        return robot.syncs >= 5

    def set_tcp(tool: Pose, name: str = "") -> None:
        robot.tool = Pose(tool)

    def halt_() -> None:
        raise HaltedError

    def pose_add(a: Pose, b: Pose) -> Pose:
        turn = Rotation.from_rotvec(a[3:6]) * Rotation.from_rotvec(b[3:6])
        return Pose([*(x + y for x, y in zip(a[:3], b[:3], strict=True)), *turn.as_rotvec()])

    def rpy2rotvec(rpy: list[float]) -> list[float]:
        return list(Rotation.from_euler("xyz", rpy).as_rotvec())

    def rotvec2rpy(vector: list[float]) -> list[float]:
        return list(Rotation.from_rotvec(vector).as_euler("xyz"))

    def ignore(*_: Any, **__: Any) -> int:
        return 0

    return {
        "Pose": Pose,
        "own": lambda value: type(value)(value) if isinstance(value, list) else value,
        "movej": move("movej", True),
        "movel": move("movel", False),
        "movep": move("movep", False),
        "optimovej": move("optimovej", True),
        "optimovel": move("optimovel", False),
        "movec": movec,
        "sync": sync,
        "halt_": halt_,
        "set_tcp": set_tcp,
        "sleep": lambda t: robot.done.append(("sleep", t)),
        "set_standard_digital_out": lambda n, on: robot.done.append(("out", n, bool(on))),
        "set_standard_analog_out": lambda n, value: robot.done.append(("analog out", n, value)),
        "get_actual_tcp_pose": lambda: Pose([0.0] * 6),
        "set_digital_out": lambda n, on: robot.done.append(("out", n, bool(on))),
        "get_standard_digital_in": read,
        "get_digital_in": read,
        "get_steptime": lambda: 0.002,
        "get_inverse_kin": lambda x, qnear=None: Pose(x),
        "pose_trans": lambda a, b: pose_of(a.matrix() @ b.matrix()),
        "pose_inv": lambda a: pose_of(np.linalg.inv(a.matrix())),
        "pose_add": pose_add,
        "point_dist": lambda a, b: math.dist(a[:3], b[:3]),
        "rpy2rotvec": rpy2rotvec,
        "rotvec2rpy": rotvec2rpy,
        "d2r": math.radians,
        "r2d": math.degrees,
        "norm": abs,
        "floor": math.floor,
        "ceil": math.ceil,
        "pow": pow,
        "sqrt": math.sqrt,
        "sin": math.sin,
        "cos": math.cos,
        "tan": math.tan,
        "asin": math.asin,
        "acos": math.acos,
        "atan": math.atan,
        "atan2": math.atan2,
        "str_cat": lambda a, b: f"{a}{b}",
        "to_str": str,
        "textmsg": ignore,
        "popup": ignore,
        "log": lambda base, x: math.log(x, base),
    }


def _place(q: Any) -> Any:
    return Pose(q) if isinstance(q, Pose) else list(q)
