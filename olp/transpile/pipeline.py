"""The passes in their order: they bring a program of any language into the form that a language's writer takes.

Passes that need the plan of the source program share it: as it runs, and with the inputs on that it asks for.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Final

from olp.core.diagnostic import Diagnostic, OlpError, Span, error
from olp.ir.expressions import (
    CallValue,
    Compare,
    Expression,
    Logic,
    Named,
    Number,
    Signal,
    SignalState,
    Text,
    Unary,
)
from olp.ir.points import PointTable
from olp.ir.program import Begin, Call, End, Move, Program, Routine, StartTask, Statement, Wait
from olp.ir.transformer import calls_nothing, expressions_of, sets_numbers
from olp.languages.limits import limits_of
from olp.languages.vendor import language_of
from olp.robots.model import Robot
from olp.runtime.assumptions import (
    NAMED_SIGNAL,
    Assumptions,
    SignalKey,
    load_assumptions,
    nearest_assumptions,
)
from olp.runtime.interpreter import run
from olp.runtime.made_up import MadeUp
from olp.runtime.plan import Plan
from olp.transpile.advance import (
    continue_statements,
    needless_stands,
    overrides_ahead,
    overrides_read_ahead,
    stopped_advance,
)
from olp.transpile.arcs import arcs
from olp.transpile.arm_flags import with_flags
from olp.transpile.arrays import (
    array_bounds,
    array_parameters,
    array_sizes,
    array_values,
    composed_poses,
    handed_arrays,
    passing_arrays,
    single_rows,
    sums,
    texts,
    vectors,
)
from olp.transpile.blends import blends
from olp.transpile.clocks import clocks
from olp.transpile.commented_out import LeftOut, leave_out
from olp.transpile.constant_folding import fold_constants
from olp.transpile.constant_frames import active_systems, constant_systems
from olp.transpile.context import Context, Fate, Planned, Translated, TranslationContext
from olp.transpile.control_flow import calls_without_return, flow
from olp.transpile.current_position import position_readings, relative, shifts, stops_before_readings
from olp.transpile.dead_code import data_alone, drop_unused_records, holds_data_only, unnamed_speeds
from olp.transpile.expression_lowering import named_data
from olp.transpile.first_values import (
    default_values,
    filled_arrays,
    first_values,
    persistent_variables,
    reset_own_variables,
    shared_default_values,
    taught_frames,
    unset_data,
)
from olp.transpile.flat_records import flat_records
from olp.transpile.frames import external_frames, frames, written_systems
from olp.transpile.functions import arguments, functions, handed_systems, optional_parameters
from olp.transpile.handlers import handlers
from olp.transpile.helper_routines import helper_routines, pose_products
from olp.transpile.implicit_declarations import declarations
from olp.transpile.integer_inference import remainders, switching_fractions, whole_numbers
from olp.transpile.modal_state import modal_settings
from olp.transpile.move_lowering import relative_tools
from olp.transpile.name_mangling import names, spelling, tasks
from olp.transpile.name_types import references
from olp.transpile.occurrences import with_same_parts
from olp.transpile.partial_positions import combined_turns, computed_axes, externals, partial_targets
from olp.transpile.postures import configurations, joint_targets_as_poses, postures
from olp.transpile.quaternions import own_components, own_parts, quaternions
from olp.transpile.records import records
from olp.transpile.register_allocation import allocate_registers
from olp.transpile.shared_variables import share_variables
from olp.transpile.signal_variables import signal_variables
from olp.transpile.signals import long_waits, move_end_actions, pulses, signal_aliases, signal_names, signals
from olp.transpile.source_only import comment_texts, data_comments, foreign_words, long_texts, plain_texts
from olp.transpile.speeds import accelerations, schedules, speeds
from olp.transpile.temporaries import hoist, short_circuit_calls, texts_by_statement
from olp.transpile.triggers import on_the_way, triggers
from olp.transpile.typed_values import (
    assumed_states,
    controller_states,
    digital_states,
    displayed_values,
    enumerations,
    exclusive_or,
    manual_modes,
    powers,
    typed_values,
)
from olp.transpile.unroll import executed
from olp.transpile.watches import watches

MOST_AGAIN: Final = 20_000  # statements of a run with the inputs on, in which loops may have no end
_CIRCLES: Final = 40_000  # statements of a run after which a program in circles has come by all that it will


def work_for(
    program: Program, target: str, context: Context, planned: Planned | None = None
) -> TranslationContext:
    """`planned`: of the same program, where it was translated before. Raises OlpError (X010) for a language that cannot
    be written."""
    planned = planned or plans_of(program, context.robot)
    return TranslationContext(program, target, limits_of(target, context.forms), context, planned)


def plans_of(program: Program, robot: Robot | None) -> Planned:
    """What makes the plan of a program when it is first asked for."""

    @lru_cache(maxsize=2)  # without and with inputs
    def planned(with_inputs: bool) -> Plan | None:
        if not with_inputs:
            # A program that is passed once is run to its end.
            rows = sum(len(r.body) for r in program.routines)
            return plan_of(program, robot, None, min(200_000, max(_CIRCLES, 2 * rows)))
        inputs = asked_inputs(program)
        return plan_of(program, robot, inputs, MOST_AGAIN) if inputs else None

    return planned


def plan_of(
    program: Program,
    robot: Robot | None,
    inputs: Mapping[SignalKey, tuple[int, ...]] | None,
    most: int | None,
    made_up: MadeUp | None = None,
) -> Plan | None:
    """The plan of `most` statements (None: as usual), None where the program cannot be run.

    `inputs`: what olp.toml says counts more.
    """
    try:
        if inputs is None:
            return run(program, robot=robot, max_steps=most, made_up=made_up)
        folder = Path(program.path).parent if program.path and Path(program.path).is_file() else None
        path = nearest_assumptions(folder) if folder is not None else None
        given = load_assumptions(path) if path is not None else Assumptions()
        on = replace(given, inputs={**inputs, **given.inputs})
        return run(program, robot=robot, assumptions=on, max_steps=most, made_up=made_up)
    except OlpError:
        return None


def asked_inputs(program: Program) -> dict[SignalKey, tuple[int, ...]]:
    """The inputs that a program decides by, each on.

    What is waited for without a limit comes anyway; with one, the wait ends in time where these inputs end it.
    """
    found: dict[SignalKey, tuple[int, ...]] = {}
    for s in program.statements():
        if isinstance(s, Wait) and (s.timeout is None or not _holds_when_on(s.condition)):
            continue
        if not calls_nothing(s) and not sets_numbers(s):
            found |= dict.fromkeys(_inputs(s), (1,))
    return found


def _holds_when_on(e: Expression) -> bool:
    """Whether a condition holds, as far as the text shows, where all inputs are on."""
    match e:
        case Logic(first, rest):
            found = _holds_when_on(first)
            for operator, operand in rest:
                one = _holds_when_on(operand)
                found = {"and": found and one, "or": found or one}.get(operator, found != one)
            return found
        case Unary("not", operand):
            return not _holds_when_on(operand)
        case Compare(operator, Signal(), SignalState(on)):
            return on is (operator == "=")
        case Compare(operator, Signal(), Number(value)):
            return (value == 1) is (operator == "=")
    return True


def _inputs(s: Statement) -> set[SignalKey]:
    signals = [] if isinstance(s, Move) else [e for e in expressions_of(s) if isinstance(e, Signal)]
    found = set()
    for signal in signals:
        if signal.bus.rpartition("-")[2] != "in" or "analog" in signal.bus:
            continue
        if isinstance(signal.index, Text):
            found.add(SignalKey(NAMED_SIGNAL, signal.index.value.casefold()))
        elif isinstance(signal.index, Number):
            found.add(SignalKey(signal.bus, int(signal.index.value)))
    return found


Pass = Callable[[Program, TranslationContext], Program]
_ROUNDS = 12  # of commenting out what the passes refuse


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
    pose_products,
    reset_own_variables,
    share_variables,
    fold_constants,
    digital_states,
    hoist,
    share_variables,
    flow,
    shared_default_values,
    names,
    allocate_registers,
    comment_texts,
)
_TO_NAMES: Final[tuple[Pass, ...]] = (
    combined_turns,
    texts_by_statement,
    flow,
    whole_numbers,
    default_values,
    signal_aliases,
    signals,
    names,
    continue_statements,
    overrides_ahead,
)


def _called(program: Program, work: TranslationContext) -> set[str]:
    """The routines that statements call, case folded."""
    looks = [work.look(r) for r in program.routines]
    found = {s.routine.casefold() for look in looks for s in look.of_kind(Call, StartTask)}
    return found | {
        e.routine.casefold() for look in looks for e in look.expressions if isinstance(e, CallValue)
    }


_STARTED_APART: Final = (
    "start this in the place of the program that others call, too: it sets the first values once"
)


def separate_start(program: Program, work: TranslationContext) -> Program:
    """The program with a start routine of its own where other routines call the first one, too.

    A target that keeps no data beside the program sets their first values in its first routine: each of these calls
    would set them again.
    """
    if work.limits.keeps_data or not program.routines:
        return program
    first = next((r for r in program.routines if r.name == program.main), program.routines[0])
    has_data = program.data or any(r.data or r.parameters for r in program.routines)
    if first.returns or not has_data or first.name.casefold() not in _called(program, work):
        return program
    name = work.fresh(f"{first.name}_start")
    work.ask(_STARTED_APART, name)
    given = tuple(Named(p.name) for p in first.parameters if not (p.optional or p.switch))
    own = replace(
        first,
        name=name,
        body=(Begin(0), Call(0, first.name, given), End(0)),
        data=(),
        parameters=tuple(p for p in first.parameters if not (p.optional or p.switch)),
        points=PointTable(),
    )
    return replace(program, routines=(own, *program.routines), main=name)


# What the source's controller does, in statements and values that the target has.
_TO_MEANING: Final[tuple[Pass, ...]] = (
    calls_without_return,
    separate_start,
    unnamed_speeds,
    signal_names,
    handlers,
    spelling,
    stopped_advance,
    overrides_read_ahead,
    triggers,
    on_the_way,
    move_end_actions,
    clocks,
    watches,
    foreign_words,
    plain_texts,
    active_systems,
    signal_variables,
    optional_parameters,
    handed_systems,
    array_parameters,
    array_sizes,
    handed_arrays,
    passing_arrays,
    flat_records,
    enumerations,
    powers,
    short_circuit_calls,
    exclusive_or,
    displayed_values,
    helper_routines,
    controller_states,
    manual_modes,
    assumed_states,
    texts,
    array_values,
    single_rows,
    schedules,
    partial_targets,
    computed_axes,
    external_frames,
    written_systems,
    pulses,
    long_waits,
    records,
    quaternions,
    own_parts,
    vectors,
    named_data,
    relative_tools,
    composed_poses,
    sums,
    persistent_variables,
    unset_data,
    declarations,
    first_values,
    filled_arrays,
    array_bounds,
    constant_systems,
    postures,
    modal_settings,
    position_readings,
    joint_targets_as_poses,
    externals,
)
# Points, frames, speeds and what else moves need as the target takes them.
_TO_MOVES: Final[tuple[Pass, ...]] = (
    configurations,
    references,
    remainders,
    switching_fractions,
    long_texts,
    arguments,
    functions,
    typed_values,
    stops_before_readings,
    shifts,
    relative,
    arcs,
    frames,
    with_flags,
    speeds,
    blends,
    needless_stands,
    accelerations,
    drop_unused_records,
    own_components,
    taught_frames,
)


def passes(work: TranslationContext, source: Program) -> tuple[Pass, ...]:
    """All passes of `source` towards the target, in order; with `flat` what it does takes the place of it."""
    first = (*_TO_MEANING, *((executed,) if work.context.flat else ()), *_TO_MOVES)

    def remarks(program: Program, work: TranslationContext) -> Program:
        return data_comments(program, work, source)

    if work.limits.numbered:
        return (remarks, *first, *_TO_NUMBERS)
    return (*first, *_TO_NAMES, remarks, comment_texts, started)


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
        if not out.add(refused, program, context.on_loss):
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
    for step in passes(work, program):
        result = with_same_parts(step(result, work), result)
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
