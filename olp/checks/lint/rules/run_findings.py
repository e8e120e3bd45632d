"""Lint rules for problems that the run and its timing report: W003, W005, W006, W009, W011."""

from __future__ import annotations

from collections.abc import Iterator

from olp.checks.lint.rule import RunRule, Suggestion
from olp.checks.lint.zones import smaller
from olp.ir.program import Move, Program
from olp.reports.outcome.model import Level, OutcomeFinding


class LongZone(RunRule):
    """A zone longer than one of its moves."""

    code = "W003"
    title = "zone longer than the move"
    codes = ("T104",)
    why = (
        "Controllers cut a zone to half of the shorter move, so the corner depends on points that were not meant to "
        "shape it. A Universal Robot skips a point whose blend overlaps its neighbour's: there the two radii together "
        "must be less than the distance between the points."
    )
    example = "MOVL C00001 V=300.0 PL=8\nMOVL C00002 V=300.0   20 mm further"
    better = "MOVL C00001 V=300.0 PL=1"
    suggests = True

    def suggest(self, program: Program, found: OutcomeFinding) -> Iterator[Suggestion]:
        moves = [s.line for s in program.statements() if isinstance(s, Move) and s.line <= found.line]
        # The corner is told at the line whose zone it is, or at the short move behind it.
        for line in sorted(set(moves), reverse=True)[:2]:
            for text in smaller(program.vendor, program.source.line(line)):
                yield line, line, text, "make the zone smaller"


class OutsideLimits(RunRule):
    """A point that the arm cannot reach, or only beyond its soft limits."""

    code = "W005"
    title = "point outside limits"
    level = Level.ERROR
    codes = ("I004", "L103", "L104")
    why = (
        "The arm does not reach the point, or an axis leaves its soft limits on the path: the controller stops with an "
        "alarm in the middle of the cycle."
    )
    example = "MOVL C00001 V=300.0   with C00001 beyond the reach"
    better = "teach C00001 within reach"


class SingularPath(RunRule):
    """A path that passes a singularity."""

    code = "W006"
    title = "singularity passed"
    codes = ("L105",)
    why = (
        "Near a singularity even a slow move of the tool needs axis speeds beyond their limits. Controllers slow down, "
        "leave the path or stop with an alarm: the time of the line cannot be predicted."
    )
    example = "MOVL C00001 V=300.0   with B passing 0 deg"
    better = "turn the tool a few degrees, or pass the place with MOVJ"


class UndefinedPoint(RunRule):
    """A move to a point that was never taught."""

    code = "W009"
    title = "undefined point"
    level = Level.ERROR
    codes = ("I206", "I209", "P030")
    maybe = ("I203",)  # a position variable, which another program may set before it calls this one
    why = (
        "The controller stops with an alarm when it reaches this line. For a position variable that no program here "
        "sets it is only a note, because a caller may set it."
    )
    example = "MOVL C00009 V=300.0   without C00009"
    better = "teach C00009, or correct its number"


class MissingJob(RunRule):
    """A call of a routine that does not exist."""

    code = "W011"
    title = "missing routine"
    level = Level.ERROR
    codes = ("I102",)
    why = "The routine is in no file at hand: its time is missing, and the controller stops there."
    example = "CALL JOB:WELD-4   without WELD-4.JBI"
    better = "put WELD-4.JBI in the folder"
