"""The passes in their order: a program of any language in the form that a language's writer takes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

from olp.core.diagnostic import Diagnostic, Span, error
from olp.ir.expressions import PositionLiteral
from olp.ir.points import PointTable
from olp.ir.program import Begin, Call, End, Program, Routine
from olp.languages.vendor import language_of
from olp.transpile.advance import continued, stopped_advance
from olp.transpile.arcs import arcs
from olp.transpile.arm_flags import with_flags
from olp.transpile.arrays import array_bounds, array_sizes, array_values, single_rows, sums, texts, vectors
from olp.transpile.blends import blends
from olp.transpile.clocks import clocks
from olp.transpile.commented_out import LeftOut, leave_out
from olp.transpile.constant_folding import fold_constants, share_variables
from olp.transpile.constant_frames import held_systems, known_systems
from olp.transpile.context import Context, Fate, Loss, Planned, TranslationContext
from olp.transpile.control_flow import flow
from olp.transpile.current_position import here, relative, standing
from olp.transpile.dead_code import data_alone, holds_data_only, prune
from olp.transpile.expression_lowering import lift
from olp.transpile.first_values import begun, begun_anew, first_values, lasting
from olp.transpile.flat_records import flat_records
from olp.transpile.frames import elsewhere, frames, written_systems
from olp.transpile.functions import arguments, functions
from olp.transpile.handlers import handlers
from olp.transpile.implicit_declarations import undeclared
from olp.transpile.integer_inference import whole_numbers
from olp.transpile.modal_state import modal
from olp.transpile.name_mangling import names, spelling, tasks
from olp.transpile.name_types import references
from olp.transpile.optional_parameters import optional_parameters
from olp.transpile.own_components import own_components
from olp.transpile.partial_positions import computed_axes, externals, partial, turned_together
from olp.transpile.postures import configurations, postures
from olp.transpile.quaternions import quaternions
from olp.transpile.records import records
from olp.transpile.register_allocation import number
from olp.transpile.signal_aliases import signal_aliases
from olp.transpile.signal_variables import signal_variables
from olp.transpile.signals import at_ends, pulses, signals
from olp.transpile.source_only import comment_texts, foreign_words, plain_texts
from olp.transpile.source_plans import plans_of, work_for
from olp.transpile.speeds import accelerations, schedules, speeds
from olp.transpile.temporaries import hoist, texts_by_statement
from olp.transpile.triggers import on_the_way, triggers
from olp.transpile.typed_values import enumerations, exclusive, manual_modes, powers, states, typed_values
from olp.transpile.unroll import executed

if TYPE_CHECKING:
    pass

Pass = Callable[[Program, TranslationContext], Program]
_ROUNDS = 12  # of commenting out what the passes refuse


@dataclass(frozen=True, slots=True)
class Translated:
    """`mapping`: (kind, name in the source) -> name in the target.

    Kinds: point, variable, tool, frame, routine, signal, task, label. `problems`: what no comment can stand for (X012).
    `remarks`: on statements of which nothing is lost. `asks`: what is to be done before it runs, with what.
    `held`: values of tools ("tool") and frames ("user") that the target's controller is to hold, by number or name.
    `types`: of the source's names that no file declares, as `Declare.type` says it.
    """

    program: Program
    losses: tuple[Loss, ...]
    mapping: dict[tuple[str, str], str]
    notes: tuple[str, ...] = ()
    problems: tuple[Diagnostic, ...] = ()
    remarks: tuple[Loss, ...] = ()
    asks: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    held: Mapping[tuple[str, str], PositionLiteral] = field(default_factory=dict)
    types: Mapping[str, str] = field(default_factory=dict)


def started(program: Program, work: TranslationContext) -> Program:
    """With the routine that the controller starts, which calls the program's own first one, where it lacks such."""
    name = work.limits.started
    if not (name and work.context.entry and program.routines):
        return program
    first = next((r for r in program.routines if r.name == program.main), program.routines[0])
    taken = {routine.name.casefold() for routine in program.routines}
    taken |= {declare.name.casefold() for declare in program.data}
    if name.casefold() in taken or first.parameters or first.returns or holds_data_only(program):
        return program
    own = Routine(name, 0, (Begin(0), Call(0, first.name), End(0)), PointTable())
    return replace(program, routines=(*program.routines, own))


# The last passes, to languages whose variables have numbers, and to those with names.
_TO_NUMBERS: Final[tuple[Pass, ...]] = (
    tasks,
    signals,
    begun_anew,
    share_variables,
    fold_constants,
    hoist,
    share_variables,
    flow,
    names,
    number,
    comment_texts,
)
_TO_NAMES: Final[tuple[Pass, ...]] = (
    turned_together,
    texts_by_statement,
    flow,
    whole_numbers,
    begun,
    signal_aliases,
    signals,
    names,
    continued,
    comment_texts,
    started,
)


def passes(work: TranslationContext) -> tuple[Pass, ...]:
    """All passes towards the target, in order; with `flat` what the program does takes the place of the program."""
    first: tuple[Pass, ...] = (
        handlers,
        spelling,
        stopped_advance,
        triggers,
        on_the_way,
        at_ends,
        clocks,
        foreign_words,
        plain_texts,
        held_systems,
        signal_variables,
        optional_parameters,
        array_sizes,
        flat_records,
        enumerations,
        powers,
        exclusive,
        states,
        manual_modes,
        texts,
        array_values,
        single_rows,
        schedules,
        partial,
        computed_axes,
        elsewhere,
        written_systems,
        pulses,
        records,
        quaternions,
        vectors,
        lift,
        sums,
        lasting,
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
        typed_values,
        standing,
        relative,
        arcs,
        frames,
        with_flags,
        speeds,
        blends,
        accelerations,
        prune,
        own_components,
    )
    return (*first, *(_TO_NUMBERS if work.limits.numbered else _TO_NAMES))


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
    planned = plans_of(program, context.robot)
    for _ in range(_ROUNDS):
        result, work = _translated(program, target, context, out, planned)
        refused: dict[int, str] = {}
        for loss in work.losses:
            if loss.fate is Fate.REFUSED and loss.line:
                refused.setdefault(loss.line, loss.says)  # the first reason has the source's own names
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
        dict(work.undeclared),
    )


def _translated(
    program: Program, target: str, context: Context, out: LeftOut, planned: Planned
) -> tuple[Program, TranslationContext]:
    work = work_for(program, target, context, planned)
    result = leave_out(program, out, work)
    for step in passes(work):
        result = step(result, work)
    return result, work


def refusals(program: Program, vendor: str, translated: Translated) -> list[Diagnostic]:
    """An error (X011) for every statement that the passes refuse."""
    found = []
    for loss in translated.losses:
        if loss.fate is Fate.REFUSED:
            text = program.source.line(loss.line)
            span = (
                Span(loss.line, len(text) - len(text.lstrip()) + 1, len(text.rstrip()) + 1)
                if loss.line
                else None
            )
            message = f"{language_of(vendor)} cannot express this: {loss.says}"
            help = loss.help or "--on-loss comment writes it as a comment"
            found.append(error("X011", message, span, file=program.path, source_line=text, help=help))
    return found
