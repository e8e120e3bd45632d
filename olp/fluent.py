"""The public way through olp: read, plan, time, export, each a method of what the step before gave.

`olp.read(path).plan(robot=…).time()`. `FluentProgram` and `FluentPlan` (`olp.Program`, `olp.Plan` for users) are the
classes of `olp.ir.program` and `olp.runtime.plan` with the methods that need packages above theirs; everything inside
olp calls those packages' functions.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import wraps
from html import escape
from typing import TYPE_CHECKING, Any, Literal, ParamSpec

from olp.core.diagnostic import OlpError
from olp.ir import program as ir
from olp.languages import vendor as languages
from olp.runtime import plan as runtime

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

    from olp.core.diagnostic import Diagnostic
    from olp.identification.signature.document import Signature
    from olp.robots.model import Robot
    from olp.runtime.assumptions import Assumptions
    from olp.timing.result import Timing

Arguments = ParamSpec("Arguments")


@dataclass(frozen=True, slots=True, repr=False)
class FluentPlan(runtime.Plan):
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
        from olp.drawings import draw_speed

        return draw_speed(self._timing(model, None, None, None, None, {}), axes)

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

        learnt = None
        if signature is not None:
            from olp.identification.signature.correction import SignatureCorrection
            from olp.identification.signature.file import read_signature

            if isinstance(signature, (str, os.PathLike)):
                signature = read_signature(os.fspath(signature))
            learnt = SignatureCorrection(signature)
        return time_plan(self, model, acceleration, override, law, learnt, **parameters)

    def __repr__(self) -> str:
        robot = self.robot.name if self.robot else "robot not known"
        moves = int((self.kind == runtime.StepKind.MOVE).sum())
        return f"<Plan of {self.path or 'a text'}: {len(self)} steps, {moves} of them moves, {robot}>"

    def _repr_html_(self) -> str:
        return as_html(repr(self), self.diagnostics)


@dataclass(frozen=True, slots=True, repr=False)
class FluentProgram(ir.Program):
    """All routines of one file, with the text they came from; see `olp.ir.program.Program` for the fields."""

    def plan(
        self,
        robot: str | Robot | None = None,
        *,
        assumptions: Assumptions | None = None,
        folder: str | os.PathLike[str] | None = None,
        max_steps: int | None = None,
        cycles: int = 1,
    ) -> FluentPlan:
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
        """The program in `vendor`'s language; see `olp.transpile.convert.export` for the options."""
        from olp.transpile.convert import export

        return export(self, vendor, output, template=template, encoding=encoding, date=date)

    def __repr__(self) -> str:
        wrong = sum(found.is_error for found in self.diagnostics)
        told = f", {wrong} error{'' if wrong == 1 else 's'}" if wrong else ""
        names = ", ".join(routine.name for routine in self.routines[:3])
        more = ", …" if len(self.routines) > 3 else ""
        lines = len(self.source.lines)
        return f"<Program {self.path or 'of a text'} ({self.vendor}): {names}{more}, {lines} lines{told}>"

    def _repr_html_(self) -> str:
        return as_html(repr(self), self.diagnostics)


def run(
    program: ir.Program,
    robot: str | Robot | None = None,
    *,
    assumptions: Assumptions | None = None,
    folder: str | os.PathLike[str] | None = None,
    max_steps: int | None = None,
    cycles: int = 1,
) -> FluentPlan:
    """The plan of `program`: see `FluentProgram.plan`."""
    from olp.runtime import interpreter

    made = interpreter.run(
        program,
        robot,
        assumptions=assumptions,
        folder=folder,
        max_steps=max_steps,
        cycles=cycles,
        first_move=True,
    )
    return FluentPlan(**fields_of(made))


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

    Example:
        >>> import olp
        >>> table = olp.time("samples/inform/generations/dx200.jbi", robot="yaskawa/ma2010")
        >>> table[["line", "kind", "duration_s"]].round(3).head(2)  # a row per executed step
           line    kind  duration_s
        0    26   joint       0.000
        1    27  linear       0.146
    """
    return read(path).plan(robot, cycles=cycles).time(model, signature, override=override)


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

    Example:
        >>> import olp
        >>> files = olp.convert("samples/krl/handling.src", to="rapid", robot="yaskawa/gp25")
        >>> sorted(files)
        ['handling.mod']
    """
    from olp.languages.vendor import read as read_plainly
    from olp.transpile.context import Context
    from olp.transpile.convert import convert as translate
    from olp.transpile.link import link, with_starts

    context = Context(as_robot(robot), as_robot(target_robot), on_loss=on_loss, forms=not plain, entry=True)
    linked = link(read_plainly(path, encoding=encoding), to)
    try:
        return translate(with_starts(linked.program), to, context).files
    except OlpError as refused:
        raise OlpError(*map(linked.located, refused.diagnostics)) from None


def as_robot(robot: str | Robot | None) -> Robot | None:
    """The robot of that name or file."""
    from olp.robots.robot import load_robot

    return load_robot(robot) if isinstance(robot, str) else robot


def as_html(sentence: str, diagnostics: tuple[Diagnostic, ...]) -> str:
    """A notebook's line for an object, with the first of what there is to tell."""
    rows = "".join(
        f"<li>{escape(str(d.severity))} {d.code}: {escape(d.message)}</li>" for d in diagnostics[:10]
    )
    return f"<p>{escape(sentence.strip('<>'))}</p>" + (f"<ul>{rows}</ul>" if rows else "")


def fluent(program: ir.Program) -> FluentProgram:
    """`program` with the methods."""
    return FluentProgram(**fields_of(program))


def fields_of(one: Any) -> dict[str, Any]:
    """What a dataclass is made of, for one with more methods."""
    return {field.name: getattr(one, field.name) for field in fields(one)}


def _fluent(reads: Callable[Arguments, ir.Program]) -> Callable[Arguments, FluentProgram]:
    @wraps(reads)
    def read(*args: Arguments.args, **options: Arguments.kwargs) -> FluentProgram:
        return fluent(reads(*args, **options))

    return read


read = _fluent(languages.read)
read_source = _fluent(languages.read_source)

# What users import.
Plan = FluentPlan
Program = FluentProgram
