"""The public way through olp: read, plan, time, export, each a method of what the step before gave.

`olp.read(path).plan(robot=…).time()`. The classes are those of `olp.ir.program` and `olp.runtime.plan` with the methods
that reach into packages above theirs; everything inside olp calls those packages' functions.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import wraps
from html import escape
from typing import TYPE_CHECKING, Any, Literal, ParamSpec

from olp.core.diagnostic import OlpError, error
from olp.ir import program as ir
from olp.languages import read as languages
from olp.runtime import plan as runtime

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

    from olp.core.diagnostic import Diagnostic
    from olp.identification.diagnosis.diagnose import DiagnosisOutcome
    from olp.identification.recording import Recording
    from olp.identification.signature import Signature
    from olp.robots.robot import Robot
    from olp.runtime.assumptions import Assumptions
    from olp.timing.timing import Timing

Arguments = ParamSpec("Arguments")


@dataclass(frozen=True, slots=True, repr=False)
class Plan(runtime.Plan):
    """Executed steps in order; see `olp.runtime.plan.Plan` for the columns."""

    def time(
        self,
        model: str | None = None,
        signature: Signature | str | os.PathLike[str] | None = None,
        acceleration_law: str | None = None,
        *,
        acceleration: float | None = None,
        override: float | None = None,
        **parameters: float,
    ) -> pandas.DataFrame:
        """Seconds per step: one row per segment, wait or signal, with the column names of `olp time --format json`.

        `signature`: one that was read, or its file. `acceleration` [m/s²] of linear moves, speed `override` [1];
        `parameters` of the motion model (SI). Raises OlpError for an unknown model, law or parameter, and for a
        signature that is none or of another robot.
        """
        return self._timing(model, signature, acceleration_law, acceleration, override, parameters).frame()

    def plot(self, axes: Axes | None = None, *, model: str | None = None) -> Axes:
        """The speed of the tool's point [mm/s] over time [s], drawn with matplotlib, which has to be installed.

        `axes`: where to draw (None: a new figure). Raises OlpError (Y003) without matplotlib, or where a step has no
        time.
        """
        import numpy as np

        from olp.core.units import mm
        from olp.timing.track import tool_speed

        timing = self._timing(model, None, None, None, None, {})
        if timing.untimed or not timing.total_s > 0:
            raise OlpError(error("Y003", "nothing can be drawn: not every step has a time", file=self.path))
        axes = axes or _new_axes()
        instants = np.linspace(0.0, timing.total_s, 2000)
        axes.plot(instants, tool_speed(timing, instants) / mm)
        axes.set(xlabel="time s", ylabel="speed of the tool mm/s", title=f"{timing.total_s:.3f} s")
        return axes

    def _timing(
        self,
        model: str | None,
        signature: Signature | str | os.PathLike[str] | None,
        law: str | None,
        acceleration: float | None,
        override: float | None,
        parameters: dict[str, float],
    ) -> Timing:
        from olp.timing.timing import time_plan

        if isinstance(signature, str | os.PathLike):
            from olp.identification.signature import read_signature

            signature = read_signature(os.fspath(signature))
        return time_plan(self, model, acceleration, override, law, signature, **parameters)

    def __repr__(self) -> str:
        robot = self.robot.name if self.robot else "robot not known"
        moves = int((self.kind == runtime.StepKind.MOVE).sum())
        return f"<Plan of {self.path or 'a text'}: {len(self)} steps, {moves} of them moves, {robot}>"

    def _repr_html_(self) -> str:
        return _as_html(repr(self), self.diagnostics)


@dataclass(frozen=True, slots=True, repr=False)
class Program(ir.Program):
    """All routines of one file, with the text they came from; see `olp.ir.program.Program` for the fields."""

    def plan(
        self,
        robot: str | Robot | None = None,
        *,
        assumptions: Assumptions | None = None,
        folder: str | os.PathLike[str] | None = None,
        max_steps: int | None = None,
        cycles: int = 1,
    ) -> Plan:
        """Executes the program, its first routine to the end.

        `robot`: name of the library, robot file or Robot; else olp.toml or the controller's backup decide.
        `assumptions`: what the program cannot tell (None: the nearest olp.toml). `folder`: where called routines are
        (None: beside the program). `cycles`: passes of an endless main loop. Raises OlpError for a robot that does not
        exist.
        """
        return run(self, robot, assumptions=assumptions, folder=folder, max_steps=max_steps, cycles=cycles)

    def export(
        self,
        vendor: str,
        output: str | os.PathLike[str] | None = None,
        *,
        template: str | os.PathLike[str] | None = None,
        encoding: str | None = None,
        date: str | None = None,
    ) -> bytes:
        """The program in `vendor`'s language; see `olp.transpile.export.export` for the options."""
        from olp.transpile.export import export

        return export(self, vendor, output, template=template, encoding=encoding, date=date)

    def __repr__(self) -> str:
        wrong = sum(found.is_error for found in self.diagnostics)
        told = f", {wrong} error{'' if wrong == 1 else 's'}" if wrong else ""
        names = ", ".join(routine.name for routine in self.routines[:3])
        more = ", …" if len(self.routines) > 3 else ""
        lines = len(self.source.lines)
        return f"<Program {self.path or 'of a text'} ({self.vendor}): {names}{more}, {lines} lines{told}>"

    def _repr_html_(self) -> str:
        return _as_html(repr(self), self.diagnostics)


@dataclass(frozen=True, slots=True, repr=False)
class DiagnosisAnswer:
    """What `olp.diagnose` found; `outcome` holds all of it, the objects of `olp.identification.diagnosis`."""

    outcome: DiagnosisOutcome
    recording: Recording

    @property
    def verdict(self) -> str:
        """explained, partly-explained, unexplained, no-mismatch … as in docs/diagnose.md."""
        return self.outcome.diagnosis.verdict

    @property
    def findings(self) -> tuple[str, ...]:
        """The names of the physics that the simulation left out."""
        return tuple(finding.term for finding in self.outcome.diagnosis.findings)

    def to_json(self) -> dict[str, Any]:
        """The whole answer, schema olp.diagnosis/1."""
        return self.outcome.diagnosis.to_json()

    def text(self) -> str:
        """What `olp diagnose` prints."""
        from olp.identification.diagnosis.report_text import text_report

        return text_report(self.outcome.diagnosis, self.outcome.case, 100, False)

    def html(self) -> str:
        """The page of `olp diagnose --html`."""
        from olp.reports.diagnosis import html_report

        log = self.outcome.log.to_json() if self.outcome.log is not None else None
        return html_report(self.outcome, self.recording, None, log_summary=log)

    def __repr__(self) -> str:
        names = ", ".join(self.findings) or "nothing named"
        return f"<Diagnosis of {self.recording.path}: {self.verdict}, {names}>"

    def _repr_html_(self) -> str:
        return f"<pre>{escape(self.text())}</pre>"


def run(
    program: ir.Program,
    robot: str | Robot | None = None,
    *,
    assumptions: Assumptions | None = None,
    folder: str | os.PathLike[str] | None = None,
    max_steps: int | None = None,
    cycles: int = 1,
) -> Plan:
    """The plan of `program`: see `Program.plan`."""
    from olp.runtime import interpreter

    made = interpreter.run(
        program, robot, assumptions=assumptions, folder=folder, max_steps=max_steps, cycles=cycles
    )
    return Plan(**_fields(made))


def time(
    path: str | os.PathLike[str],
    *,
    robot: str | Robot | None = None,
    model: str | None = None,
    signature: Signature | str | os.PathLike[str] | None = None,
    override: float | None = None,
    cycles: int = 1,
) -> pandas.DataFrame:
    """How long every line of the program in `path` takes: a row per executed step, `duration_s` and `end_s` in seconds.

    Speed `override` [1]; `cycles`: passes of an endless main loop. Raises OlpError for a file that is no program and
    for a robot, model or signature that is none.

        import olp
        table = olp.time("samples/inform/generations/dx200.jbi", robot="yaskawa/ma2010")
    """
    return read(path).plan(robot, cycles=cycles).time(model, signature, override=override)


def calibrate(
    recording: Recording | str | os.PathLike[str], *, method: str = "auto", robot: str | Robot | None = None
) -> Signature:
    """The timing signature of a robot, learnt from recorded moves.

    `recording`: one that was read, or its folder. `method`: auto, or a name of docs/signature.md. Raises OlpError for a
    recording that cannot teach one.
    """
    from olp.identification.signature import calibrate as learn

    return learn(_recording(recording), method, _robot(robot))[0]


def predict(
    recording: Recording | str | os.PathLike[str], *, signature: Signature | str | os.PathLike[str]
) -> pandas.DataFrame:
    """The time of each move of a recording [s]: columns `move`, `predicted_s`, `low_s`, `high_s` (95 %).

    nan where nothing can be said. Raises OlpError for a signature or a recording that is none.
    """
    import pandas

    from olp.identification.signature import read_signature
    from olp.identification.signature.rows import predict_recording

    if isinstance(signature, str | os.PathLike):
        signature = read_signature(os.fspath(signature))
    rows, _ = predict_recording(signature, _recording(recording))
    columns = {"move": rows.move, "predicted_s": rows.predicted, "low_s": rows.low, "high_s": rows.high}
    return pandas.DataFrame(columns)


def diagnose(
    recording: Recording | str | os.PathLike[str], *, robot: str | Robot | None = None
) -> DiagnosisAnswer:
    """Where a simulation and a recording differ, and which physics was left out.

    Raises OlpError for what is no recording.
    """
    from olp.identification.diagnosis.diagnose import diagnose_recording

    known = _recording(recording)
    return DiagnosisAnswer(diagnose_recording(known, _robot(robot)), known)


def convert(
    path: str | os.PathLike[str],
    *,
    to: str,
    robot: str | Robot | None = None,
    target_robot: str | Robot | None = None,
    on_loss: Literal["error", "comment"] = "error",
    plain: bool = False,
    encoding: str | None = None,
) -> dict[str, bytes]:
    """The program in `path` in the language `to`: the bytes of each file by its name.

    `robot`: that it was written for; `target_robot`: that it is written for (None: the same). `on_loss`: what becomes
    of a statement that the target cannot say. `plain`: moves without the forms of the pendant (KRL). `olp convert` also
    writes the receipt of what was changed. Raises OlpError with all that cannot be said there.
    """
    from olp.languages.read import read as read_plainly
    from olp.transpile.context import Context
    from olp.transpile.convert import convert as translate
    from olp.transpile.link import link

    context = Context(_robot(robot), _robot(target_robot), on_loss=on_loss, forms=not plain)
    linked = link(read_plainly(path, encoding=encoding))
    try:
        return translate(linked.program, to, context).files
    except OlpError as refused:
        raise OlpError(*map(linked.located, refused.diagnostics)) from None


def _recording(recording: Recording | str | os.PathLike[str]) -> Recording:
    from olp.identification.recording import Recording, read_recording

    if isinstance(recording, Recording):
        return recording
    return read_recording(os.fspath(recording), logs_alone=True)


def _robot(robot: str | Robot | None) -> Robot | None:
    from olp.robots.robot import load_robot

    return load_robot(robot) if isinstance(robot, str) else robot


def _as_html(sentence: str, diagnostics: tuple[Diagnostic, ...]) -> str:
    rows = "".join(
        f"<li>{escape(str(d.severity))} {d.code}: {escape(d.message)}</li>" for d in diagnostics[:10]
    )
    return f"<p>{escape(sentence.strip('<>'))}</p>" + (f"<ul>{rows}</ul>" if rows else "")


def _new_axes() -> Axes:
    try:
        from matplotlib import pyplot
    except ImportError:
        help = "pip install matplotlib"
        raise OlpError(
            error("Y003", "plots are drawn by matplotlib, which is not installed", help=help)
        ) from None
    return pyplot.subplots()[1]


def fluent(program: ir.Program) -> Program:
    """`program` with the methods."""
    return Program(**_fields(program))


def _fields(one: Any) -> dict[str, Any]:
    return {field.name: getattr(one, field.name) for field in fields(one)}


def _fluent(reads: Callable[Arguments, ir.Program]) -> Callable[Arguments, Program]:
    @wraps(reads)
    def read(*args: Arguments.args, **options: Arguments.kwargs) -> Program:
        return fluent(reads(*args, **options))

    return read


read = _fluent(languages.read)
read_source = _fluent(languages.read_source)
