"""The public way through olp: read, plan, time, export, each a method of what the step before gave.

`olp.read(path).plan(robot=…).time()`. The classes are those of `olp.ir.program` and `olp.runtime.plan` with the methods
that reach into packages above theirs; everything inside olp calls those packages' functions.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec

from olp.ir import program as ir
from olp.languages import read as languages
from olp.runtime import plan as runtime

if TYPE_CHECKING:
    import pandas

    from olp.identification.signature import Signature

Arguments = ParamSpec("Arguments")


@dataclass(frozen=True, slots=True)
class Plan(runtime.Plan):
    """Executed steps in order; see `olp.runtime.plan.Plan` for the columns."""

    def time(
        self,
        model: str | None = None,
        signature: Signature | str | os.PathLike[str] | None = None,
        acceleration_law: str | None = None,
        **options: float,
    ) -> pandas.DataFrame:
        """Seconds per step: one row per segment, wait or signal, with the column names of `olp time --format json`.

        `signature`: one that was read, or its file. Raises OlpError for an unknown model or law, and for a signature
        that is none or of another robot.
        """
        from olp.timing.timing import time_plan

        if isinstance(signature, str | os.PathLike):
            from olp.identification.signature import read_signature

            signature = read_signature(os.fspath(signature))
        law = acceleration_law
        return time_plan(self, model=model, acceleration_law=law, signature=signature, **options).frame()


@dataclass(frozen=True, slots=True)
class Program(ir.Program):
    """All routines of one file, with the text they came from; see `olp.ir.program.Program` for the fields."""

    def plan(self, robot: object = None, **options: object) -> Plan:
        """Executes the program: see `olp.runtime.interpreter.run` for the options."""
        return run(self, robot, **options)

    def export(
        self, vendor: str, output: str | os.PathLike[str] | None = None, **options: str | None
    ) -> bytes:
        """The program in `vendor`'s language; see `olp.transpile.export.export` for the options."""
        from olp.transpile.export import export

        return export(self, vendor, output, **options)


def run(program: ir.Program, robot: object = None, **options: object) -> Plan:
    """The plan of `program`: see `olp.runtime.interpreter.run` for the options."""
    from olp.runtime import interpreter

    return Plan(**_fields(interpreter.run(program, robot, **options)))  # type: ignore[arg-type]


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
