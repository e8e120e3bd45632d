"""The passes in their order: a program of any language in the form that a language's writer takes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from olp.diagnostic import Diagnostic
from olp.expression import PositionLiteral
from olp.program import Program
from olp.translate.accelerations import accelerations
from olp.translate.arcs import arcs
from olp.translate.arguments import arguments
from olp.translate.arm_flags import with_flags
from olp.translate.array_values import array_values
from olp.translate.arrays import array_bounds
from olp.translate.at_ends import at_ends
from olp.translate.blends import blends
from olp.translate.configurations import configurations
from olp.translate.data_only import data_alone
from olp.translate.elsewhere import elsewhere
from olp.translate.externals import externals
from olp.translate.first_values import first_values
from olp.translate.flat import executed
from olp.translate.flow import flow
from olp.translate.frames import frames
from olp.translate.functions import functions
from olp.translate.globals import fold_constants, share_variables
from olp.translate.here import here
from olp.translate.hoist import hoist
from olp.translate.known import known_systems
from olp.translate.left_out import LeftOut, leave_out
from olp.translate.lift import lift
from olp.translate.modal import modal
from olp.translate.names import names
from olp.translate.numbers import number
from olp.translate.partial import partial
from olp.translate.postures import postures
from olp.translate.prune import prune
from olp.translate.pulses import pulses
from olp.translate.records import records
from olp.translate.references import references
from olp.translate.relative import relative
from olp.translate.schedules import schedules
from olp.translate.signals import signals
from olp.translate.speeds import speeds
from olp.translate.standing import standing
from olp.translate.tasks import tasks
from olp.translate.texts import texts
from olp.translate.undeclared import undeclared
from olp.translate.vectors import vectors
from olp.translate.whole import whole_numbers
from olp.translate.words import comment_texts, foreign_words
from olp.translate.work import Context, Fate, Loss, Work, work_for
from olp.translate.written_systems import written_systems

Pass = Callable[[Program, Work], Program]
_ROUNDS = 12  # of commenting out what the passes refuse


@dataclass(frozen=True, slots=True)
class Translated:
    """`mapping`: (kind, name in the source) -> name in the target.

    Kinds: point, variable, tool, frame, routine, signal, task, label. `problems`: what no comment can stand for (X012).
    `remarks`: on statements of which nothing is lost. `asks`: what is to be done before it runs, with what.
    `held`: values of tools ("tool") and frames ("user") that the target's controller is to hold, by number or name.
    """

    program: Program
    losses: tuple[Loss, ...]
    mapping: dict[tuple[str, str], str]
    notes: tuple[str, ...] = ()
    problems: tuple[Diagnostic, ...] = ()
    remarks: tuple[Loss, ...] = ()
    asks: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    held: Mapping[tuple[str, str], PositionLiteral] = field(default_factory=dict)


def passes(work: Work) -> tuple[Pass, ...]:
    """All passes towards the target, in order; with `flat` what the program does takes the place of the program."""
    first: tuple[Pass, ...] = (
        at_ends,
        foreign_words,
        texts,
        array_values,
        schedules,
        partial,
        elsewhere,
        written_systems,
        pulses,
        records,
        vectors,
        lift,
        undeclared,
        first_values,
        array_bounds,
        known_systems,
        postures,
        modal,
        here,
        externals,
        *((executed,) if work.context.flat else ()),
        configurations,
        references,
        arguments,
        functions,
        standing,
        relative,
        arcs,
        frames,
        with_flags,
        speeds,
        blends,
        accelerations,
        prune,
    )
    if work.limits.numbered:
        return (
            *first,
            tasks,
            signals,
            share_variables,
            fold_constants,
            hoist,
            share_variables,
            flow,
            names,
            number,
            comment_texts,
        )
    return (*first, flow, whole_numbers, signals, names, comment_texts)


def canonical(
    program: Program, target: str, context: Context | None = None, left_out: LeftOut | None = None
) -> Translated:
    """`program` as the writer of the language `target` takes it.

    Raises OlpError (X010) for a language that cannot be written, (X014) for data alone where it has no file for them.
    A program of the same language stays as it is. `left_out`: what becomes a comment, and why. With `on_loss`
    "comment" so does every line that a pass refuses, which is added there.
    """
    context = context or Context()
    program = data_alone(program, target, context.flat)
    if program.vendor == target and not context.flat:
        return Translated(program, (), {})
    out = LeftOut() if left_out is None else left_out
    for _ in range(_ROUNDS):
        result, work = _translated(program, target, context, out)
        refused = {x.line: x.says for x in work.losses if x.fate is Fate.REFUSED and x.line}
        if context.on_loss != "comment" or not out.add(refused):
            break
    return Translated(
        result,
        tuple(dict.fromkeys(work.losses)),
        {
            key: name
            for key, name in work.names.items()
            if key[1] not in work.helpers and key[0] != "position"
        },
        tuple(dict.fromkeys(work.notes)),
        tuple(work.problems),
        tuple(dict.fromkeys(work.remarks)),
        {says: tuple(things) for says, things in work.asks.items()},
        dict(work.held),
    )


def _translated(program: Program, target: str, context: Context, out: LeftOut) -> tuple[Program, Work]:
    work = work_for(program, target, context)
    result = leave_out(program, out, work)
    for step in passes(work):
        result = step(result, work)
    return result, work
