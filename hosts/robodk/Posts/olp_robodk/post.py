"""A post-processor of RoboDK that writes through olp: every target language has this one."""

# ruff: noqa: N802  (the methods have the names that RoboDK calls)

from __future__ import annotations

import os
import re
from pathlib import Path as File
from typing import Any, ClassVar

from olp.core.diagnostic import Diagnostic, OlpError, error
from olp.identification.signature import read_signature
from olp.identification.signature.correction import SignatureCorrection
from olp.ir.program import Move, Path, Program
from olp.robots.robot import Robot
from olp.timing.timing import time_plan
from olp.transpile.context import Context
from olp.transpile.convert import Converted, convert, run_converted
from olp_robodk.calls import CODE, Calls
from olp_robodk.robots import robot_named


class Post:
    """The methods are RoboDK's, in its units: mm, deg, ms."""

    VENDOR: ClassVar[str]
    PROG_EXT: ClassVar[str]
    ROBOT: ClassVar[str] = ""
    SIGNATURE: ClassVar[str] = ""
    AXIS_SPEED_DEG_S: ClassVar[float] = 0.0

    def __init__(
        self, robotpost: str | None = None, robotname: str | None = None, robot_axes: int = 6, **more: Any
    ) -> None:
        self.ROBOT_POST, self.ROBOT_NAME, self.nAxes = robotpost, robotname, robot_axes
        self.calls = Calls()
        if robot_named(self.ROBOT or os.environ.get("OLP_ROBOT", ""), robotname or "") is None:
            self.calls.rated = self.AXIS_SPEED_DEG_S * 0.017453292519943295
        self.calls.arm_axes = sum(kind in ("R", "L") for kind in more.get("axes_type", ()))
        self.LOG = ""
        self.PROG: list[str] = []
        self.PROG_FILES: list[str] = []

    # Programs

    def ProgStart(self, progname: str) -> None:
        self.calls.begin(progname)

    def ProgFinish(self, progname: str) -> None:
        self.calls.said("ProgFinish", progname)

    def ProgSave(self, folder: str, progname: str, ask_user: Any = False, show_result: Any = False) -> None:
        """Writes all files into `folder`, and says how long the program will take."""
        target = File(self._asked(folder, progname) if ask_user or not os.path.isdir(folder) else folder)
        try:
            files = self.write(str(target / progname))
        except OlpError as refused:
            self.tell(refused.diagnostics)
            self.addlog("nothing was written")
            self.show(show_result)
            return
        for name, data in files.items():
            (target / name).write_bytes(data)
            self.PROG_FILES.append(str(target / name))
            print(f"SAVED: {target / name}")
        self.show(show_result)

    def ProgSendRobot(self, robot_ip: str, remote_path: str, ftp_user: str, ftp_pass: str) -> None:
        """By RoboDK's own means."""
        from robodk.robofileio import UploadFTP

        UploadFTP(self.PROG_FILES, robot_ip, remote_path, ftp_user, ftp_pass)

    # Motion

    def MoveJ(self, pose: Any, joints: Any, conf_RLF: Any = None) -> None:
        self.calls.move(Path.JOINT, pose, joints)

    def MoveL(self, pose: Any, joints: Any, conf_RLF: Any = None) -> None:
        self.calls.move(Path.LINEAR, pose, joints)

    def MoveC(
        self,
        pose1: Any,
        joints1: Any,
        pose2: Any,
        joints2: Any,
        conf_RLF_1: Any = None,
        conf_RLF_2: Any = None,
    ) -> None:
        self.calls.move(Path.CIRCULAR, pose2, joints2, via=pose1)

    def setFrame(self, pose: Any, frame_id: Any = None, frame_name: Any = None) -> None:
        self.calls.set_system("user", pose, frame_id, frame_name)

    def setTool(self, pose: Any, tool_id: Any = None, tool_name: Any = None) -> None:
        self.calls.set_system("tool", pose, tool_id, tool_name)

    def setSpeed(self, speed_mms: float) -> None:
        self.calls.said("setSpeed", speed_mms)
        self.calls.speed = speed_mms * 1e-3

    def setAcceleration(self, accel_mmss: float) -> None:
        self.calls.said("setAcceleration", accel_mmss)
        self.calls.acceleration = accel_mmss * 1e-3

    def setSpeedJoints(self, speed_degs: float) -> None:
        self.calls.said("setSpeedJoints", speed_degs)
        self.calls.axis_speed = speed_degs * 0.017453292519943295

    def setAccelerationJoints(self, accel_degss: float) -> None:
        self.calls.said("setAccelerationJoints", accel_degss)
        self.calls.axis_acceleration = accel_degss * 0.017453292519943295

    def setZoneData(self, zone_mm: float) -> None:
        self.calls.said("setZoneData", zone_mm)
        self.calls.blend = zone_mm * 1e-3

    # Everything else

    def Pause(self, time_ms: float) -> None:
        self.calls.pause(time_ms)

    def setDO(self, io_var: Any, io_value: Any) -> None:
        self.calls.output("setDO", io_var, io_value)

    def setAO(self, io_var: Any, io_value: Any) -> None:
        self.calls.output("setAO", io_var, io_value)

    def waitDI(self, io_var: Any, io_value: Any, timeout_ms: float = -1) -> None:
        self.calls.wait(io_var, io_value, timeout_ms)

    def RunCode(self, code: str, is_function_call: bool = False) -> None:
        self.calls.code(code, is_function_call)

    def RunMessage(self, message: str, iscomment: bool = False) -> None:
        self.calls.message(message, iscomment)

    def addline(self, newline: str) -> None:
        self.calls.code(newline, False)

    def addlog(self, newline: str) -> None:
        """What RoboDK shows when the program has been generated."""
        self.LOG += newline + "\n"

    # With olp

    def write(self, path: str) -> dict[str, bytes]:
        """The files by name; what there is to tell goes to the log. Raises OlpError when nothing can be written."""
        self.tell(self.calls.problems)
        robot = self._robot()
        self._told_numbers()
        program = self.calls.program(path)
        converted = convert(program, self.VENDOR, Context(robot, on_loss="comment"))
        for loss in converted.translated.losses:
            if loss.fate != "exact":
                self.addlog(f"{loss.fate}: {self._call(loss.line)}: {loss.says}")
        if robot is None:
            self._refuse_lost_moves(converted, program)
        for (kind, old), new in converted.translated.mapping.items():
            if kind in ("signal", "routine") and old.split()[-1] != new.split()[-1]:
                self.addlog(f"{kind}: {old} is {new} in the program")
        self._time(converted, robot, program)
        return {name: self._with_code(data) for name, data in converted.files.items()}

    def tell(self, diagnostics: Any) -> None:
        """Problems as the command line shows them."""
        for diagnostic in diagnostics:
            assert isinstance(diagnostic, Diagnostic)
            self.addlog(diagnostic.render())

    def show(self, show_result: Any) -> None:
        """In the editor that RoboDK names, with the log."""
        self.PROG = [File(name).read_text(errors="replace") for name in self.PROG_FILES]
        print(self.LOG)
        if not show_result:
            return
        editor = (
            [show_result]
            if isinstance(show_result, str)
            else list(show_result)
            if show_result is not True
            else []
        )
        if editor and self.PROG_FILES:
            import subprocess

            subprocess.Popen([*editor, self.PROG_FILES[0]])
        if self.LOG:
            from robodk.robodialogs import ShowMessage

            ShowMessage(self.LOG, "olp")

    def _call(self, line: int) -> str:
        return f"call {line}, {self.calls.lines[line - 1]}" if line else "the program"

    def _told_numbers(self) -> None:
        for line, text in enumerate(self.calls.lines, 1):
            if line in self.calls.numbered:
                self.addlog(f"call {line}, {text}: the program gives the controller this value")

    def _robot(self) -> Robot | None:
        robot = robot_named(self.ROBOT or os.environ.get("OLP_ROBOT", ""), self.ROBOT_NAME or "")
        if robot is None:
            self.addlog(
                f"olp does not know the robot {self.ROBOT_NAME!r}: no times. Name one in this post: ROBOT is a name of "
                "`olp robots` or a robot file; or AXIS_SPEED_DEG_S, the rated speed of its axes"
            )
        if self.calls.rated > 0:
            self.addlog(
                "the accelerations of joint moves are left out: what share of the rated ones they are is not known"
            )
        return robot

    def _refuse_lost_moves(self, converted: Converted, program: Program) -> None:
        """Without its robot a program is written whole, or not at all. Raises OlpError."""
        moves = {s.line for s in program.statements() if isinstance(s, Move)}
        lost = sum(loss.leaves_out and loss.line in moves for loss in converted.translated.losses)
        if lost:
            says = f"{lost} moves of this program cannot be written without knowing the robot"
            raise OlpError(error("X012", says, None, help="name the robot in this post: ROBOT"))

    def _time(self, converted: Converted, robot: Robot | None, program: Program) -> None:
        """The predicted time of each line of the new program."""
        if robot is None:
            return
        try:
            plan = run_converted(converted, self.VENDOR, robot, program)
            learnt = SignatureCorrection(read_signature(self.SIGNATURE)) if self.SIGNATURE else None
            table = time_plan(plan, learnt=learnt).frame()
        except OlpError as refused:
            self.tell(refused.diagnostics)
            return
        for row in table.itertuples():
            if row.duration_s:
                limit = f", limited by {row.limited_by}" if row.limited_by else ""
                self.addlog(f"line {row.line}: {row.duration_s:.3f} s{limit}: {row.statement}")
        self.addlog(f"predicted: {table['duration_s'].sum():.3f} s, {robot.name}")

    def _with_code(self, data: bytes) -> bytes:
        """With the user's own lines where their places were kept."""
        for number, text in enumerate(self.calls.codes):
            code = text.encode("utf-8", "replace")
            pattern = rb"[';!#]+\s*%s%d(?!\d)" % (CODE.encode(), number)
            data = re.sub(pattern, lambda found, code=code: code, data)
        return data

    def _asked(self, folder: str, progname: str) -> str:
        from robodk.robodialogs import getSaveFolder

        return str(getSaveFolder(folder) or ".")
