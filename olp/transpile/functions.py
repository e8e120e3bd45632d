"""Functions that compute positions, and parameters that a caller may leave out, in what the target language has.

Positions: products, offsets and rotations by literals, which most languages have. Parameters (RAPID's `\\num x`,
`\\switch x`): every argument gets its place; before each optional one a flag says whether it is given, which is what
Present asks. A switch is its own flag.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from olp.core.units import deg
from olp.ir import expressions as ex
from olp.ir.block_structure import negated
from olp.ir.program import Assign, Call, Declare, Move, Parameter, Path, Program, Return, Routine, Statement
from olp.ir.transformer import calls_nothing, changed_by, expressions_of, mapped
from olp.languages.vendor import language_of
from olp.robots.geometry import Pose, angles_from_rotation, rotation_from_angles, rotation_from_quaternion
from olp.runtime.plan import StepKind
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.occurrences import with_routines, with_rows
from olp.transpile.records import literal_of
from olp.transpile.shared_variables import calls_of, paired
from olp.transpile.symbols import Symbols, base_of, kind_of_value
from olp.transpile.temporaries import joins_calls
from olp.transpile.typed_values import AS_TEXT, whole_decimals

_NEAR = 0.01  # [rad] by which the calibration of one arm moves the joints that reach a pose


def functions(program: Program, work: TranslationContext) -> Program:
    """pose_add, computed p[…], angles and quaternions as offsets of literals; joints beside a pose as the target."""
    registers = work.limits.registers
    if registers is not None and not registers.steps:  # the target multiplies no poses
        program = _moved(program)
    symbols = work.symbols(program)
    flagged = any(r is not None and r.geometry and r.geometry.links for r in (work.robot, work.target_robot))
    near = work.limits.near_joints
    goals: set[str] = set() if near else _goals(program)
    routines = []
    for routine in program.routines:
        rows: list[Statement] = []
        at: list[Statement] = []  # the statement that is changed

        def change(e: ex.Expression, name: str = routine.name, at: list[Statement] = at) -> ex.Expression:
            e = _shorter(e, symbols, name)
            if type(e) is ex.Function and e.name == AS_TEXT:
                _refuse_places(e, at[0], symbols, name, work)
            if type(e) is ex.Function and e.name == "inverse" and not near:
                e = _anywhere(e, at[0], work)
            if not work.limits.text_decimals and type(e) is ex.Function and e.name == AS_TEXT:
                e = _as_text(e, at[0], work)
            if work.conventions.rounds_to_decimals:
                e = whole_decimals(e)
            if type(e) is ex.Binary and e.operator in ("div", "mod") and work.limits.divides_whole:
                e = _divided(e, symbols, name)
            if type(e) is ex.Logic and not work.limits.has_xor and not joins_calls(e):
                e = _without_xor(e)
            return _with_angles(e) if work.limits.pose_functions else _plain(e)

        for s in routine.body:
            if (  # nearly every statement
                type(s) is Move
                and type(s.targets[0]) is ex.Named
                and s.until is None
                and (near or s.path is not Path.JOINT)
            ):
                rows.append(s)
                continue
            if isinstance(s, Move) and s.path is Path.JOINT and not near:
                s = _in_frame(s, goals, symbols, routine.name)
                s = replace(
                    s, targets=tuple(_joints(t, symbols, routine.name, flagged, work, s) for t in s.targets)
                )
            if work.limits.integer_type and isinstance(s, Assign):
                s = _rounded(s, symbols, routine.name)
            elif not work.limits.has_integers:
                s = _whole(s, symbols, routine)
            elif isinstance(s, Assign) and type(s.value) is ex.Number:
                s = _whole(s, symbols, routine)  # `SET D000 2.5` is refused
            at[:] = [s]
            plain = type(s) is Move and type(s.targets[0]) is ex.Named and s.until is None
            rows.append(s if plain else mapped(s, change))
        routines.append(with_rows(routine, rows))
    return with_routines(program, routines)


# --- Products with a pose that never turns ---

_ALONG: Final = ("x", "y", "z")
_TURNS: Final = ("rx", "ry", "rz")


def _moved(program: Program) -> Program:
    """`q = f : p` as p with the place of f added, where no statement lets f turn: no matrices are needed for it."""
    still = _turnless(program)

    def rows(s: Statement) -> list[Statement]:
        if not (
            isinstance(s, Assign)
            and isinstance(s.target, (ex.Named, ex.Item))
            and isinstance(s.value, ex.Function)
        ):
            return [s]
        if s.value.name != "pose-product" or len(s.value.arguments) != 2:
            return [s]
        first, second = s.value.arguments
        if type(first) is not ex.Named or first.name not in still or first == s.target:
            return [s]
        found: list[Statement] = [] if second == s.target else [replace(s, value=second)]
        for name in _ALONG:
            part = ex.Member(s.target, name)
            found.append(Assign(s.line, part, ex.Binary("+", part, ex.Member(first, name))))
        return found

    if not still:
        return program
    routines = [replace(r, body=tuple([row for s in r.body for row in rows(s)])) for r in program.routines]
    return replace(program, routines=tuple(routines))


def _turnless(program: Program) -> set[str]:
    """Names of poses that the program sets as a whole, and that nothing gives any turning."""
    declared = list(program.declarations())
    found = {d.name for d in declared if d.type in ("frame", "position") and not d.sizes}
    found -= {d.name for d in declared if d.value is not None and not _is_straight(d.value)}
    found -= {p.name for r in program.routines for p in r.parameters}
    begun: set[str] = set()
    for s in program.statements() if found else ():
        if isinstance(s, Declare):
            continue
        changed = set(changed_by(s)) & found
        if isinstance(s, Assign) and (base := base_of(s.target)) is not None and base.name in changed:
            part = s.target.name if isinstance(s.target, ex.Member) else ""
            keeps = _is_straight(s.value) if s.target == base else part in _ALONG
            begun |= {base.name} if s.target == base else set()
            if keeps or (part in _TURNS and s.value == ex.Number(0)):
                changed.discard(base.name)
        found -= changed
    return found & begun


def _is_straight(e: ex.Expression) -> bool:
    match e:
        case ex.PositionLiteral("pose", values):
            return not any(values[3:6])
        case ex.Function("pose-angles", arguments):
            return all(one == ex.Number(0) for one in arguments[3:6])
    return False


def _as_text(e: ex.Function, s: Statement, work: TranslationContext) -> ex.Function:
    """A number as a text, rounded where the target cannot say with how many decimals it is written."""
    if len(e.arguments) != 2:
        return e
    says = f"{language_of(work.target)} decides with how many decimals a number is written as a text"
    work.lose(s, Fate.APPROXIMATED, "text", says)
    return replace(e, arguments=(whole_decimals(ex.Function("round", e.arguments)),))


def _shorter(e: ex.Expression, symbols: Symbols, routine: str) -> ex.Expression:
    """A product with a pose that changes nothing is the other pose."""
    if isinstance(e, ex.Function) and e.name == "pose-product" and len(e.arguments) == 2:
        for at in (0, 1):
            value = symbols.fixed_value(routine, e.arguments[at])
            if value is not None and _is_identity(value):
                return e.arguments[1 - at]
    return e


def _rounded(s: Assign, symbols: Symbols, routine: str) -> Assign:
    """Where an assignment to an integer rounds, no function does."""
    value = s.value
    rounds = isinstance(value, ex.Function) and value.name == "round" and len(value.arguments) == 1
    if isinstance(value, ex.Function) and rounds and kind_of_value(symbols, routine, s.target) == "integer":
        return replace(s, value=value.arguments[0])
    return s


def _whole(s: Statement, symbols: Symbols, routine: Routine) -> Statement:
    """What becomes an integer in the source is rounded there: the target has one kind of numbers."""
    if isinstance(s, Assign) and kind_of_value(symbols, routine.name, s.target) == "integer":
        value = _as_integer(s.value, symbols, routine.name)
        return s if value is s.value else replace(s, value=value)
    if isinstance(s, Return) and s.value is not None and routine.returns == "integer":
        value = _as_integer(s.value, symbols, routine.name)
        return s if value is s.value else replace(s, value=value)
    if isinstance(s, Call) and s.arguments:
        return replace(s, arguments=_handed(s.routine, s.arguments, symbols, routine.name))
    return s


def _handed(
    name: str, arguments: tuple[ex.Expression, ...], symbols: Symbols, routine: str
) -> tuple[ex.Expression, ...]:
    """Arguments, rounded where the parameter is an integer of its own."""
    called = symbols.routines.get(name)
    if called is None or len(arguments) > len(called.parameters):
        return arguments
    wanted = [p.type == "integer" and not p.by_reference for p in called.parameters]
    return tuple(
        _as_integer(a, symbols, routine) if is_wanted else a
        for a, is_wanted in zip(arguments, wanted, strict=False)
    )


def _as_integer(e: ex.Expression, symbols: Symbols, routine: str) -> ex.Expression:
    if isinstance(e, ex.Number):
        return (
            e
            if float(e.value).is_integer()
            else ex.Number(math.floor(abs(e.value) + 0.5) * (1 if e.value > 0 else -1))
        )
    return ex.Function("round", (e,)) if kind_of_value(symbols, routine, e) == "real" else e


def _goals(program: Program) -> set[str]:
    """Names that moves go to: the first pose of a product is a frame where it is none of them."""
    found: set[str] = set()
    for s in program.statements():
        if type(s) is not Move:
            continue
        for e in (*s.targets, s.via):
            while type(e) is ex.Function and e.name == "inverse":
                e = e.arguments[0]
            if type(e) is ex.Named:
                found.add(e.name)
    return found


def _in_frame(s: Move, goals: set[str], symbols: Symbols, routine: str) -> Move:
    """inverse(frame : pose, near) as a move in that frame, where other languages say how the arm stands at the pose."""
    e = s.targets[0]
    if type(e) is not ex.Function or e.name != "inverse" or s.frame != ex.FrameRef("base"):
        return s
    product = e.arguments[0]
    if type(product) is not ex.Function or product.name != "pose-product" or len(product.arguments) != 2:
        return s
    frame, pose = product.arguments
    if type(frame) is not ex.Named or frame.name in goals or len(s.targets) > 1:
        return s
    if type(symbols.fixed_value(routine, frame)) is not ex.PositionLiteral:
        return s
    return replace(s, frame=frame, targets=(replace(e, arguments=(pose, *e.arguments[1:])),))


def _joints(
    e: ex.Expression, symbols: Symbols, routine: str, flagged: bool, work: TranslationContext, s: Move
) -> ex.Expression:
    """inverse(pose, near): the pose, `flagged` where the arm's flags can be told; else the joints that reach it.

    A pose that a statement may change stays: its joints are those of one value that it has.
    """
    if not isinstance(e, ex.Function) or e.name != "inverse":
        return e
    if len(e.arguments) == 1 or flagged:
        return e.arguments[0]
    near = symbols.fixed_value(routine, e.arguments[1])
    if (
        isinstance(near, ex.PositionLiteral)
        and near.kind == "joint"
        and _stays(e.arguments[0], symbols, routine)
    ):
        return _reached(e, near, work, s)
    work.lose(s, Fate.APPROXIMATED, "joints", _ANY_POSTURE)
    return e.arguments[0]


_ANY_POSTURE: Final = (
    "the joint values near which the arm stands at the pose are left out: its controller chooses them"
)
_UNCHECKED: Final = "the joint values beside the pose are written: nobody checked that they reach it"


def _anywhere(e: ex.Function, s: Statement, work: TranslationContext) -> ex.Function:
    """inverse(pose, near) without `near`."""
    if len(e.arguments) == 1 or isinstance(e.arguments[1], ex.NamedArgument):
        return e
    work.lose(s, Fate.APPROXIMATED, "joints", _ANY_POSTURE)
    return replace(e, arguments=(e.arguments[0], *e.arguments[2:]))


def _stays(e: ex.Expression, symbols: Symbols, routine: str) -> bool:
    """Whether no statement changes what a pose is computed from."""
    if isinstance(e, ex.Function):
        return all(_stays(one, symbols, routine) for one in e.arguments)
    return isinstance(symbols.fixed_value(routine, e), (ex.PositionLiteral, ex.Number, ex.Quantity))


def _reached(e: ex.Function, near: ex.PositionLiteral, work: TranslationContext, s: Move) -> ex.Expression:
    """The joints with which the plan reaches the pose of a move, the pose where they change, else those beside it."""
    plan = None if work.robot is None else work.plan()
    axes = np.empty((0, 0))
    if plan is not None and work.robot is not None:
        steps = np.flatnonzero((plan.kind == StepKind.MOVE) & (plan.source == 0) & (plan.line == s.line))
        axes = plan.positions.axes[plan.moves.target[plan.row[steps]]][:, : len(work.robot.axes)]
    if not len(axes) or np.isnan(axes).any() or len(near.values) != axes.shape[1]:
        work.lose(s, Fate.APPROXIMATED, "joints", _UNCHECKED)
        return e.arguments[1]
    if np.abs(axes - np.array(near.values)).max() < _NEAR:
        return e.arguments[1]
    if np.ptp(axes, axis=0).max() > _NEAR:
        work.lose(s, Fate.APPROXIMATED, "joints", _ANY_POSTURE)
        return e.arguments[0]
    return replace(near, values=tuple(map(float, axes[0])))


def _refuse_places(
    e: ex.Function, s: Statement, symbols: Symbols, routine: str, work: TranslationContext
) -> None:
    """Each language writes a position as a text in its own form."""
    if kind_of_value(symbols, routine, e.arguments[0]) in ("position", "joints", "tool", "frame"):
        work.lose(s, Fate.REFUSED, "text", "a position as a text")


def _divided(e: ex.Binary, symbols: Symbols, routine: str) -> ex.Expression:
    """A division with a remainder of numbers that may be fractions."""
    if all(kind_of_value(symbols, routine, one) == "integer" for one in (e.left, e.right)):
        return e
    whole = ex.Function("trunc", (ex.Binary("/", e.left, e.right),))
    return whole if e.operator == "div" else ex.Binary("-", e.left, ex.Binary("*", e.right, whole))


def _without_xor(e: ex.Logic) -> ex.Logic:
    """Conditions that an exclusive OR joins, as one of both without the other."""
    if not any(operator == "xor" for operator, _ in e.rest):
        return e
    found: ex.Expression = e.first
    for operator, right in e.rest:
        if operator == "xor":
            left = ex.Logic(found, (("and", negated(right)),))
            found = ex.Logic(left, (("or", ex.Logic(negated(found), (("and", right),))),))
        else:
            found = ex.Logic(found, ((operator, right),))
    assert isinstance(found, ex.Logic)
    return found


def _with_angles(e: ex.Expression) -> ex.Expression:
    """A pose whose quaternion is written out: three angles say it as well."""
    if not isinstance(e, ex.Function) or e.name != "pose-quaternion":
        return e
    parts = _numbers(e.arguments[3:7])
    if parts is None or not np.linalg.norm(parts) > 0:
        return e
    angles = angles_from_rotation(rotation_from_quaternion(parts))
    turn = (ex.Number(float(v) / deg + 0.0) for v in angles)
    return ex.Function("pose-angles", (*e.arguments[:3], *turn, *e.arguments[7:]))


def _plain(e: ex.Expression) -> ex.Expression:
    if not isinstance(e, ex.Function):
        return e
    arguments = e.arguments
    match e.name:
        case "pose-distance":
            return _apart(*arguments[:2])
        case "pose-add":
            return _sum(e)
        case "pose-subtract":
            return _difference(e)
        case "pose-product":
            inner = arguments[1]
            if (
                isinstance(inner, ex.Function)
                and inner.name == "pose-offset"
                and _is_identity(inner.arguments[0])
            ):
                return ex.Function(
                    "pose-relative-tool", (arguments[0], *inner.arguments[1:], *[ex.Number(0)] * 3)
                )
            return e
        case "pose-vector":
            turn = _numbers(arguments[3:6])
            return (
                e
                if turn is None
                else _offset(_turned(_from_vector(turn)), [ex.scaled(a, 1000) for a in arguments[:3]])
            )
        case "pose-angles" if len(arguments) == 6:
            angles = _numbers(arguments[3:6])
            return (
                e
                if angles is None
                else _offset(_turned(rotation_from_angles(angles * deg)), list(arguments[:3]))
            )
        case "pose-quaternion" if len(arguments) == 7:
            parts = _numbers(arguments[3:7])
            if parts is None or not np.linalg.norm(parts) > 0:
                return e
            return _offset(_turned(rotation_from_quaternion(parts)), list(arguments[:3]))
        case _:
            return e


def _sum(e: ex.Function) -> ex.Expression:
    """Positions add; a second pose that does not turn is an offset."""
    first, second = e.arguments[:2]
    if isinstance(second, ex.Function) and second.name == "pose-offset" and _is_identity(second.arguments[0]):
        return _offset(first, list(second.arguments[1:]))
    if isinstance(second, ex.PositionLiteral) and second.kind == "pose" and not any(second.values[3:6]):
        return _offset(first, [ex.Number(float(f"{v * 1000:.9g}")) for v in second.values[:3]])
    return e


def _difference(e: ex.Function) -> ex.Expression:
    """A second pose that does not turn is an offset the other way."""
    first, second = e.arguments[:2]
    if isinstance(second, ex.Function) and second.name == "pose-offset" and _is_identity(second.arguments[0]):
        return _offset(first, [ex.Binary("*", one, ex.Number(-1)) for one in second.arguments[1:]])
    if isinstance(second, ex.PositionLiteral) and second.kind == "pose" and not any(second.values[3:6]):
        return _offset(first, [ex.Number(float(f"{-v * 1000:.9g}") + 0.0) for v in second.values[:3]])
    return e


def _apart(first: ex.Expression, second: ex.Expression) -> ex.Expression:
    """The distance of two places [mm] from their components."""
    squares = []
    for one, other in zip(_place(first), _place(second), strict=True):
        difference = ex.Binary("-", one, other)
        squares.append(ex.Binary("*", difference, difference))
    x, y, z = squares
    return ex.Function("sqrt", (ex.Binary("+", ex.Binary("+", x, y), z),))


def _place(e: ex.Expression) -> tuple[ex.Expression, ...]:
    if isinstance(e, ex.Function) and e.name == "pose-angles":
        return e.arguments[:3]
    if isinstance(e, ex.Function) and e.name == "pose-offset" and _is_identity(e.arguments[0]):
        return e.arguments[1:4]
    if isinstance(e, ex.PositionLiteral):
        return tuple(ex.Number(float(f"{v * 1000:.9g}")) for v in e.values[:3])
    return tuple(ex.Member(e, axis) for axis in ("x", "y", "z"))


def _offset(start: ex.Expression, by: list[ex.Expression]) -> ex.Expression:
    if isinstance(start, ex.PositionLiteral) and all(isinstance(a, ex.Number) for a in by):
        shift = [a.value / 1000 for a in by if isinstance(a, ex.Number)]
        values = tuple(v + d for v, d in zip(start.values[:3], shift, strict=True))
        return replace(start, values=(*values, *start.values[3:]))
    return ex.Function("pose-offset", (start, *by))


def _is_identity(e: ex.Expression) -> bool:
    return isinstance(e, ex.PositionLiteral) and e.kind == "pose" and not any(e.values[:6])


def _turned(rotation: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> ex.PositionLiteral:
    literal = literal_of(Pose(np.zeros(3), rotation))
    return replace(literal, values=tuple(v + 0.0 for v in literal.values))


def _from_vector(
    vector: np.ndarray[tuple[int, ...], np.dtype[np.float64]],
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """A rotation vector [rad] as a matrix, by way of its quaternion."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    axis = vector / angle
    return rotation_from_quaternion(np.array([math.cos(angle / 2), *(math.sin(angle / 2) * axis)]))


def _numbers(
    arguments: tuple[ex.Expression, ...],
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]] | None:
    values = [float(a.value) for a in arguments if isinstance(a, ex.Number)]
    return np.array(values) if len(values) == len(arguments) else None


# --- Arguments ---
# Arguments by name and arguments that may be left out, for languages whose calls give all of them in order.


def arguments(program: Program, work: TranslationContext) -> Program:
    """Every call with all arguments, those left out with their defaults. A switch, or one without a default, stays.

    What a routine is given and never reads is left out.
    """
    if work.conventions.surplus_arguments:
        program = _without_surplus(program, work)
    program = _filled_up(program, work)
    if not work.limits.ordered_arguments:
        return program
    known = {r.name.casefold(): r.parameters for r in program.routines if _is_filled(r.parameters)}
    if not any(p.optional for parameters in known.values() for p in parameters) and not _by_name(
        program, work
    ):
        return program

    def change(e: ex.Expression) -> ex.Expression:
        if type(e) is ex.CallValue and e.routine.casefold() in known:
            return replace(e, arguments=_in_order(known[e.routine.casefold()], e.arguments))
        return e

    def row(s: Statement) -> Statement:
        if calls_nothing(s):
            return s
        s = mapped(s, change)
        if isinstance(s, Call) and s.routine.casefold() in known:
            return replace(s, arguments=_in_order(known[s.routine.casefold()], s.arguments))
        return s

    routines = []
    for routine in program.routines:
        parameters = routine.parameters
        if routine.name.casefold() in known:
            parameters = tuple(replace(p, optional=False, default=None) for p in parameters)
        routines.append(replace(routine, body=tuple(map(row, routine.body)), parameters=parameters))
    return replace(program, routines=tuple(routines))


_ZEROS: Final[Mapping[str, ex.Expression]] = {
    "integer": ex.Number(0),
    "real": ex.Number(0.0),
    "boolean": ex.SignalState(False),
    "string": ex.Text(""),
}


def _filled_up(program: Program, work: TranslationContext) -> Program:
    """Every call with all that its routine takes: zeros for what the source leaves out."""
    taken = {r.name.casefold(): r.parameters for r in program.routines if _is_positional(r.parameters)}
    stand: dict[str, Declare] = {}  # by type: what parameters that are changed are handed

    def stand_in(p: Parameter) -> ex.Expression:
        if not p.by_reference and p.type in _ZEROS:
            return _ZEROS[p.type]
        if p.type not in stand:
            stand[p.type] = Declare(0, work.helper("left_out"), p.type, None, shared=True)
        return ex.Named(stand[p.type].name)

    def filled(name: str, given: tuple[ex.Expression, ...], s: Statement) -> tuple[ex.Expression, ...]:
        parameters = taken.get(name.casefold(), ())
        gone = [p for i, p in enumerate(parameters) if i >= len(given) or given[i] == ex.Unknown("")]
        if not gone:
            return given
        if any(not p.type or p.native.endswith("[]") for p in gone):
            work.lose(s, Fate.REFUSED, "argument", f"{name} is called without {gone[0].name}")
            return given
        names = ", ".join(p.name for p in gone)
        work.lose(s, Fate.APPROXIMATED, "argument", f"{name} is called without {names}: zeros are handed")
        return tuple(stand_in(p) if p in gone else given[i] for i, p in enumerate(parameters))

    def row(s: Statement) -> Statement:
        if calls_nothing(s):
            return s

        def change(e: ex.Expression) -> ex.Expression:
            return replace(e, arguments=filled(e.routine, e.arguments, s)) if type(e) is ex.CallValue else e

        s = mapped(s, change)
        return replace(s, arguments=filled(s.routine, s.arguments, s)) if isinstance(s, Call) else s

    if not any(taken.values()):
        return program
    routines = tuple(replace(r, body=tuple(map(row, r.body))) for r in program.routines)
    return replace(program, routines=routines, data=(*program.data, *stand.values()))


def _is_positional(parameters: tuple[Parameter, ...]) -> bool:
    return not any(p.optional or p.switch for p in parameters)


def _without_surplus(program: Program, work: TranslationContext) -> Program:
    taken = {r.name: len(r.parameters) for r in program.routines}

    def row(s: Statement) -> Statement:
        if not isinstance(s, Call) or len(s.arguments) <= taken.get(s.routine, len(s.arguments)):
            return s
        count = taken[s.routine]
        says = f"{s.routine} takes {count} of its {len(s.arguments)} arguments: nothing translated reads the others"
        work.note_at(s, says)
        return replace(s, arguments=s.arguments[:count])

    routines = tuple(replace(r, body=tuple(map(row, r.body))) for r in program.routines)
    return replace(program, routines=routines)


def _is_filled(parameters: tuple[Parameter, ...]) -> bool:
    return all(not p.switch and (not p.optional or p.default is not None) for p in parameters)


def _by_name(program: Program, work: TranslationContext) -> bool:
    return any(
        type(e) is ex.NamedArgument for routine in program.routines for e in work.look(routine).expressions
    )


def _in_order(
    parameters: tuple[Parameter, ...], given: tuple[ex.Expression, ...]
) -> tuple[ex.Expression, ...]:
    values = dict(paired(parameters, given))
    found = [values.get(p.name) or p.default for p in parameters]
    if any(value is None for value in found):
        return given
    return tuple(value for value in found if value is not None)


# What stands for an argument that is left out, by its type: nothing reads it.
_UNREAD: Final[Mapping[str, ex.Expression]] = {
    "real": ex.Number(0),
    "integer": ex.Number(0),
    "boolean": ex.SignalState(False),
    "string": ex.Text(""),
}
_PASSED_ON: Final = "?"  # behind the name of an argument that is given where the caller's own one is
_GIVEN: Final = "given"


@dataclass(frozen=True, slots=True)
class _Head:
    """A routine's parameters and their flags: name, case folded -> the flag's name; a switch's is its own, "": none."""

    parameters: tuple[Parameter, ...]
    flags: Mapping[str, str] = field(default_factory=dict)


def optional_parameters(program: Program, work: TranslationContext) -> Program:
    """Every routine with required parameters alone. Options of other types, or by reference, stay as they are."""
    heads = {
        routine.name.casefold(): _head(routine, work) for routine in program.routines if _is_plain(routine)
    }
    if not heads:
        return program
    return replace(program, routines=tuple(_routine(routine, heads) for routine in program.routines))


def _is_optional(p: Parameter) -> bool:
    return p.switch or (p.optional and (p.default is None or _is_system(p)))


def _is_system(p: Parameter) -> bool:
    """A frame that is the base where none is given: moves that it is handed on to need not know whether it is."""
    return isinstance(p.default, ex.FrameRef)


def _is_plain(routine: Routine) -> bool:
    options = [p for p in routine.parameters if _is_optional(p)]
    return bool(options) and all(
        p.switch or _is_system(p) or (p.type in _UNREAD and not p.by_reference and "{" not in p.native)
        for p in options
    )


def _head(routine: Routine, work: TranslationContext) -> _Head:
    asked = {
        e.arguments[0].name.casefold()
        for s in routine.body
        if not calls_nothing(s)
        for e in expressions_of(s)
        if isinstance(e, ex.Function) and e.name == _GIVEN and isinstance(e.arguments[0], ex.Named)
    }
    flags = {}
    for p in routine.parameters:
        key = p.name.casefold()
        if _is_optional(p):
            plain = _is_system(p) and key not in asked
            flags[key] = "" if plain else p.name if p.switch else work.fresh(f"{p.name}_given")
    return _Head(routine.parameters, flags)


def _routine(routine: Routine, heads: Mapping[str, _Head]) -> Routine:
    own = heads.get(routine.name.casefold(), _Head(routine.parameters))
    names = {p.name.casefold() for p in routine.parameters}

    def change(e: ex.Expression) -> ex.Expression:
        if type(e) is ex.CallValue and e.routine.casefold() in heads:
            return replace(e, arguments=_arguments(e.arguments, heads[e.routine.casefold()], own))
        if type(e) is ex.Function and e.name == _GIVEN and type(e.arguments[0]) is ex.Named:
            asked = e.arguments[0].name.casefold()
            if own.flags.get(asked):
                return ex.Named(own.flags[asked])
            return ex.SignalState(True) if asked in names else e
        return e

    def row(s: Statement) -> Statement:
        s = mapped(s, change)
        if isinstance(s, Call) and s.routine.casefold() in heads:
            return replace(s, arguments=_arguments(s.arguments, heads[s.routine.casefold()], own))
        return s

    parameters: list[Parameter] = []
    for p in routine.parameters:
        flag = own.flags.get(p.name.casefold())
        if flag is None:
            parameters.append(p)
            continue
        parameters += [Parameter(flag, "boolean")] if flag else []
        if not p.switch:
            parameters.append(replace(p, optional=False, default=None))
    return replace(routine, body=tuple(map(row, routine.body)), parameters=tuple(parameters))


def _arguments(given: tuple[ex.Expression, ...], head: _Head, caller: _Head) -> tuple[ex.Expression, ...]:
    """The arguments of a call, each in its place."""
    by_name = {a.name.casefold(): a for a in given if isinstance(a, ex.NamedArgument)}
    positional = iter([a for a in given if not isinstance(a, ex.NamedArgument)])
    found: list[ex.Expression] = []
    for p in head.parameters:
        key = p.name.casefold()
        if key not in head.flags:
            found += [a for a in (next(positional, None),) if a is not None]
            continue
        named, passed = by_name.get(key), by_name.get(key + _PASSED_ON)
        if passed is not None and type(passed.value) is ex.Named:
            flag: ex.Expression = ex.Named(
                caller.flags.get(passed.value.name.casefold()) or passed.value.name
            )
            value: ex.Expression = passed.value
        else:
            flag = ex.SignalState(named is not None)
            usual = p.default if p.default is not None else _UNREAD.get(p.type, flag)
            value = usual if named is None or named.value is None else named.value
        found += [flag] if p.switch else [flag, value] if head.flags[key] else [value]
    return tuple(found)


# --- Tools and frames that are handed over ---
# Where tools and frames have numbers and no names, a routine that gets one is written once for each that it gets.

_SYSTEMS: Final = frozenset({"tool", "frame"})
_MOST_COPIES: Final = 8  # of one routine


def handed_systems(program: Program, work: TranslationContext) -> Program:
    """A routine with tools or frames among its parameters becomes one for each combination that calls pass."""
    if work.limits.named_frames:
        return program
    for _ in range(_MOST_COPIES):  # routines that hand on what they got come after their callers
        ready = next((r for r in program.routines if _handed_to(r, program) is not None), None)
        if ready is None:
            return program
        program = _one_for_each(ready, program, work)
    return program


def _places(routine: Routine) -> list[int]:
    return [at for at, p in enumerate(routine.parameters) if p.type in _SYSTEMS]


def _handed_to(routine: Routine, program: Program) -> list[tuple[ex.Expression, ...]] | None:
    """The combinations of tools and frames that calls hand over; None where one is not that of the whole program."""
    places = _places(routine)
    if not places or any(p.optional or p.switch for p in routine.parameters):
        return None
    names = {routine.parameters[at].name for at in places}
    if any(
        isinstance(s, Assign)
        and {e.name for e in expressions_of(s.target) if isinstance(e, ex.Named)} & names
        for s in routine.body
    ):
        return None
    shared = {d.name for d in program.data}
    found: list[tuple[ex.Expression, ...]] = []
    for _, call in calls_of(routine, program):
        if len(call.arguments) != len(routine.parameters):
            return None
        given = tuple(call.arguments[at] for at in places)
        if not all(
            isinstance(e, ex.FrameRef) or (isinstance(e, ex.Named) and e.name in shared) for e in given
        ):
            return None
        found += [] if given in found else [given]
    return found if 0 < len(found) <= _MOST_COPIES else None


def _one_for_each(routine: Routine, program: Program, work: TranslationContext) -> Program:
    combinations = _handed_to(routine, program) or []
    places = _places(routine)
    names = [routine.name, *(work.fresh(f"{routine.name}_{n}") for n in range(2, len(combinations) + 1))]
    copies: list[Routine] = []
    for name, given in zip(names, combinations, strict=True):
        values = {routine.parameters[at].name: e for at, e in zip(places, given, strict=True)}

        def change(e: ex.Expression, values: dict[str, ex.Expression] = values) -> ex.Expression:
            return values.get(e.name, e) if type(e) is ex.Named else e

        parameters = tuple(p for at, p in enumerate(routine.parameters) if at not in places)
        body = tuple(mapped(s, change) for s in routine.body)
        copies.append(replace(routine, name=name, parameters=parameters, body=body))

    def called(e: ex.Expression | Statement) -> Any:
        if not isinstance(e, (Call, ex.CallValue)) or e.routine.casefold() != routine.name.casefold():
            return e
        given = tuple(e.arguments[at] for at in places)
        kept = tuple(a for at, a in enumerate(e.arguments) if at not in places)
        return replace(e, routine=names[combinations.index(given)], arguments=kept)

    routines: list[Routine] = []
    for r in program.routines:
        for one in copies if r is routine else [r]:
            routines.append(replace(one, body=tuple(called(mapped(s, called)) for s in one.body)))
    return replace(program, routines=tuple(routines))
