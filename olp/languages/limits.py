"""What a language can express and how long its names may be, one `Limits` per language; and which can be written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from math import inf
from typing import Final

from olp.core import resources
from olp.core.diagnostic import OlpError, error
from olp.ir.expressions import Store
from olp.ir.program import AccelerationUnit, BlendKind, Path, PathTrigger, SpeedUnit

Range = tuple[float, float]
SPARE_SIGNALS: Final = 100  # numbers for each kind, from `Limits.spare_signals` on
_SAME: Final = 1e-6  # relative: so far outside, a number is still within


def within(value: float, bounds: Range) -> float:
    """The nearest number that `bounds` hold; `value` itself where they hold it."""
    low, high = bounds
    if low * (1.0 - _SAME) <= value <= high * (1.0 + _SAME):
        return value
    return low if value < low else high


def range_text(bounds: Range, scale: float, unit: str) -> str:
    """The bounds as text, in `unit` (SI per unit: `scale`): the reason why a number differs from the source's."""
    low, high = (float(f"{bound / scale:.6g}") for bound in bounds)
    return f"only {low:g} to {high:g} {unit} can be said"


@dataclass(frozen=True, slots=True)
class Registers:
    """Variables and points that have numbers and no names.

    `stores`: the kind of variable that holds a type; `letters`: what the kinds are called. `variable`, `point`: how
    a variable (of its letter and number) and a taught point are spelt in the receipt. `first_point`: the number of a
    file's first taught point.
    `steps`: positions are computed by statements, element by element, from variables whose beginning the file holds;
    else within expressions, from registers. `comments`: comments say which name is which variable; else points have
    names. `joint_elements`: the loss where one joint value is asked for, "" where it can be had. `real_index`: a
    fraction may number a variable. `elements`: the elements of a position are numbered integers in 0.001 mm and
    0.0001 deg. `framed`: a routine begins and ends with words of its own, and states its control group.
    `routines_own`: kinds that a routine may have for itself, as many as it says.
    """

    stores: Mapping[str, Store]
    letters: Mapping[Store, str]
    variable: str
    point: str
    first_point: int
    steps: bool = False
    comments: bool = False
    joint_elements: str = ""
    real_index: bool = True
    elements: bool = False
    framed: bool = False
    routines_own: frozenset[Store] = frozenset()


@dataclass(frozen=True, slots=True)
class ValueTypes:
    """Types of a language that converts no value into another type.

    `signals_are_states`: a signal in an expression is a state, else a number. `persistent_systems`: tools and frames
    are data of a module. `results_are_used`: a function that returns a value cannot be called as a statement.
    """

    signals_are_states: bool
    persistent_systems: bool = False
    results_are_used: bool = True


@dataclass(frozen=True, slots=True)
class TrapWords:
    """Instructions of a language for routines that run as soon as a digital signal changes.

    `data_type`: of what connects signal and routine; `signals`: bus -> what calls at which edge (0, 1, 2: both);
    `end`: of an earlier connection; `stop`, `keep`, `restore`, `start`: the arm stops, its move is kept, and goes on.
    """

    data_type: str
    connect: str
    signals: Mapping[str, str]
    on: str
    off: str
    end: str
    stop: str
    keep: str
    restore: str
    start: str

    def words(self) -> frozenset[str]:
        """All instruction words of the traps."""
        own = (self.connect, self.on, self.off, self.end, self.stop, self.keep, self.restore, self.start)
        return frozenset((*own, *self.signals.values()))


@dataclass(frozen=True, slots=True)
class PathTriggerForms:
    """Outputs that moves of a language can switch while they are under way.

    Ranges [s] or [m]: behind the end that is named, negative before it; one whose end is below its begin: none at all.

    `most`: of one move. `paths`: whose moves can have some, `metres_on`: whose moves can name a distance. `delayed`:
    what acts at a distance can do so earlier or later, too.
    """

    most: int
    paths: frozenset[Path]
    metres_on: frozenset[Path]
    seconds_at_start: Range
    seconds_at_end: Range
    metres_at_start: Range
    metres_at_end: Range
    delayed: bool

    def say(self, trigger: PathTrigger, path: Path) -> bool:
        """Whether a move on such a path can name a trigger: one whose shift is written out."""
        far = trigger.metres, trigger.seconds
        if path not in self.paths or any(one is not None and one.literal is None for one in far):
            return False
        metres, seconds = (0.0 if one is None else one.literal or 0.0 for one in far)
        if metres and (path not in self.metres_on or (seconds and not self.delayed)):
            return False
        at_start = trigger.at_start
        low, high = self.metres_at_start if at_start else self.metres_at_end
        first, last = self.seconds_at_start if at_start else self.seconds_at_end
        return low <= metres <= high and (first <= seconds <= last or bool(metres))


@dataclass(frozen=True, slots=True)
class Limits:
    """One language, as its manual bounds it. Lengths in characters, 0: no bound.

    `numbered`: how many variables of a kind there are where they have numbers and no names ({}: variables have
    names), `enlarged`: how many the controller can be set up to have. `points`: how many taught points a file holds.
    `joint_speeds`, `path_speeds`, `blends`, `accelerations`: kinds that a single move can name.
    `tool_and_frame`: "move" (named by each), "modal" (a statement or variable before), "point" (taught with it),
    "tool" (a statement before for the tool; targets are in the base).
    """

    routine_name: int
    variable_name: int
    label_name: int
    line: int
    comment: int
    points: int
    statements: int
    joint_speeds: frozenset[SpeedUnit]
    path_speeds: frozenset[SpeedUnit]
    blends: frozenset[BlendKind]
    accelerations: frozenset[AccelerationUnit]
    tool_and_frame: str
    names: str = r"[A-Za-z_][A-Za-z0-9_]*"  # pattern of routine and variable names
    case_sensitive: bool = False
    numbered: Mapping[Store, int] = field(default_factory=dict)
    enlarged: Mapping[Store, int] = field(default_factory=dict)
    has_goto: bool = True
    has_while: bool = True
    has_repeat: bool = True
    has_for: bool = True
    has_break: bool = True
    has_continue: bool = False
    has_switch: bool = True
    one_routine_per_file: bool = False
    started: str = ""  # the routine that the controller starts; "": any
    has_data_files: bool = False  # files of data alone, which programs beside them use
    reserved: frozenset[str] = frozenset()  # words that no name may be, upper case
    external_axes: int = 6
    joint_blends: frozenset[BlendKind] | None = None  # of joint moves, where they differ
    zero_blend_passes: bool = (
        False  # a corner whose computed size is 0 is no stop: what follows may be done earlier
    )
    has_override: bool = True  # a statement that scales all speeds
    has_elseif: bool = True
    deepest_if: int = 99  # IF blocks within one another
    has_endless: bool = True  # a WHILE whose condition always holds
    joint_lines: bool = True  # lines and arcs may lead to joint values
    nested_logic: bool = True  # AND and OR in parentheses
    most_items: int = 0  # values and operators of one expression; 0: no bound
    # Signals whose numbers stand in conditions alone: elsewhere they are read into and set from variables of a type.
    signal_variables: Mapping[str, str] = field(default_factory=dict)  # bus -> type
    for_step_is_one: bool = False  # FOR counts up or down by one and by nothing else
    for_counts_whole: bool = False  # FOR counts with integers alone
    for_bounds_whole: bool = False  # its bounds are integers, also those in variables
    has_configuration: bool = True  # a pose can say how the arm stands
    products_forget_flags: bool = False  # a product of poses has the arm flags of its last factor
    speed_steps: Mapping[SpeedUnit, float] = field(default_factory=dict)  # the finest that is written, SI
    speed_ranges: Mapping[SpeedUnit, Range] = field(default_factory=dict)  # what is taken, SI
    largest_turning: float = inf  # that a move can bound its turning to [rad/s]
    acceleration_range: Range = (0.0, inf)  # of a share of the rated acceleration
    largest_rates: Mapping[AccelerationUnit, float] = field(default_factory=dict)  # [m/s², rad/s²]
    blend_ranges: Mapping[BlendKind, Range] = field(
        default_factory=dict
    )  # of those that are no exact stop, SI
    acceleration_step: float = 0.0  # of a share of the rated acceleration; 0: any
    unprogrammed_acceleration: str = ""  # the note where the language's own default is not the rated one
    radius_step: float = 0.0  # of a blend [m]; 0: any
    bounds_turning: bool = False  # a move can bound how fast the tool turns
    longest_pulse: float = 0.0  # [s]; 0: no bound
    shortest_pulse: float = 0.0  # [s]
    pulse_note: str = ""  # what a translated pulse needs there that the source's does not
    wait_step: float = 0.0  # [s] of waits, also the shortest one; 0: any
    longest_wait: float = 0.0  # [s] that a wait lasts, or waits for its condition; 0: no bound
    blends_may_overlap: bool = True  # the controller cuts two that meet; else it leaves a point out
    comment_swaps: Mapping[str, str] = field(
        default_factory=dict
    )  # what no comment or message holds -> what does
    registers: Registers | None = None  # of a language with numbered variables
    # Moves
    separate_deceleration: bool = False  # a move can brake otherwise than it speeds up
    arcs_by_angle: bool = False  # an arc may turn by an angle instead of ending at its target
    path_triggers: PathTriggerForms | None = None  # outputs that switch while a move is under way
    chained_arcs: bool = False  # an arc is a chain of moves, each to one of its points
    native_offsets: frozenset[str] = (
        frozenset()
    )  # "relative" (to where the arm stands), "relative-tool" (the same along the tool), "offset" (to the target)
    joint_offsets: bool = True  # joint moves are among them
    watches: bool = False  # a statement says what runs as soon as a condition comes true
    has_xor: bool = False  # conditions may be joined by an exclusive OR
    computed_turns: bool = True  # an offset may turn by a computed angle
    near_joints: bool = False  # a pose can be given with joint values near which it is reached
    watches_flags: bool = False  # a statement says whether joint moves obey the arm flags
    computed_axes: bool = False  # a computed position says where external axes stand
    external_units: int = 0  # how many external axes a position has, each with a unit
    no_external_axes: str = ""  # why positions have no external axes, "" where they have
    joint_values_note: str = ""  # to joint values of another maker's robot that does not couple axes 2 and 3
    # Tools, frames, signals
    named_frames: bool = True  # variables hold tools and frames
    frame_numbers: Mapping[str, int] = field(
        default_factory=dict
    )  # the largest of "tool" and "user"; {}: none
    frame_functions: bool = False  # tools and frames are set by functions of their number
    first_signal: int = 0
    spare_signals: int = 0  # where a robot's own signals, a tool's and configurable ones go; 0: nowhere
    own_signals: frozenset[str] = frozenset()  # those of these kinds that it has itself
    last_signals: Mapping[str, int] = field(
        default_factory=dict
    )  # bus -> number of the last one; of others there are as many as are named
    further_signals: Mapping[str, tuple[tuple[int, str], ...]] = field(
        default_factory=dict
    )  # bus -> (number, bus): from this number on signals are those of the other bus, from its 0 on; largest first
    declared_groups: bool = False  # a declaration makes a group of signals that follow each other
    speeds_needed: bool = False  # each move says its speed
    angles_together: bool = (
        False  # a position holds its turn as one value: an angle of it is set with the others
    )
    position_read_in: str = (
        "named"  # a reading of the position names tool and frame; "base", "move": what counts else
    )
    # Values and routines
    dimensions: str = "any"  # of arrays; "one", or "numbers" where only those of numbers have several
    array_literals: bool = False  # [1, 2, 3] is a value
    pose_functions: bool = False  # poses are added, turned and inverted within expressions, and do for frames
    multiplies_poses: bool = True  # a variable is set to a product of two poses, or to an inverse
    untaught_points: bool = False  # a position may be without values: a move to it stops the program
    pose_sums: bool = False  # places of poses are added and their turns composed within an expression
    value_types: ValueTypes | None = None  # None: types need not fit
    text_quote: str = ""  # what no text holds, nor a control character; "": texts hold all
    message: int = 0  # characters of a message; 0: any number
    longest_text: int = 0  # characters of a variable of texts; 0: as many as its declaration says
    fixed_messages: bool = False  # a message shows no value of a variable
    has_exclusive_or: bool = True  # of conditions
    has_power: bool = False  # a function raises a number to a power
    form_points: str = ""  # what a pendant's form puts before the name of the point that it moves to
    lacks: frozenset[str] = frozenset()  # functions and operators that a routine of the translation computes
    has_integers: bool = False  # numbers that are whole by their type
    divides_whole: bool = False  # division with a remainder takes whole numbers alone
    keeps_data: bool = False  # data beside a program live on from run to run
    unset_variables: bool = False  # a variable has no value until it is set, and reading it stops the program
    integer_type: str = (
        ""  # the only type that loops count and index with, to which an assignment rounds; "": any
    )
    # Functions that are the whole right side of an assignment, of variables alone
    lone_functions: frozenset[str] = frozenset()
    texts_by_statement: bool = False  # a text is put together by statements, in a variable
    register_arguments: bool = False  # functions take variables only, and no sign stands before one
    variable_scales: Mapping[float, float] = field(
        default_factory=dict
    )  # of speeds and times: SI per unit of a literal -> of a variable
    ordered_arguments: bool = False  # arguments have their place and nothing else: all must be there
    reference_parameters: bool = False  # a routine may change what it is handed
    text_decimals: bool = True  # a number becomes a text with as many decimals as the program says
    traps: TrapWords | None = None  # routines that run as soon as a digital signal changes
    returned_parameters: bool = False  # what a routine changes can come back as its value
    conditional_statements: bool = False  # jumps and calls may have a condition of their own
    tasks: int = 0  # how many parallel tasks there are where they have fixed names; 0: any name
    task_name: str = ""  # of such a task, of its number
    manual_signal: tuple[str, int] | None = (
        None  # bus and number of what is on while programs run in a manual mode, whatever its speed
    )
    # Clocks: how many, how one is spelt in the receipt ("": by a name that is declared), seconds of its unit
    clocks: int = 0
    clock_form: str = ""
    clock_unit: float = 1.0
    zeroing_stops: bool = True  # a clock that is set to 0 stops, or nothing tells whether it does
    states: frozenset[str] = (
        frozenset()
    )  # of the controller, that a condition asks for by a word of the language
    # State of the controller, as `terminology.STATES` names it -> bus and number or name of what is on in it, and what
    # makes it so
    state_signals: Mapping[str, tuple[str, int | str, str]] = field(default_factory=dict)
    wait_poll: float = (
        0.0  # [s] between two looks where a wait with a limit is a loop; 0: the language has one
    )
    # How a program learns that a wait has reached its limit: it is "asked", a "jump", or "": the condition tells.
    wait_setting: str = ""  # what the controller keeps the limit of waits in, for all programs
    timed_out: str = "asked"
    shares_programs: bool = True  # a controller's programs call one another, and share their data
    # The Process that waits until the arm stands, where waits for a time begin while it is on its way; "": it stands
    stand: str = ""
    program_end: str = ""  # the Process that ends the program as a whole, whoever called the routine
    data_beside: bool = False  # data go into a file beside the program: the writer takes `pair`
    # Moves as the pendant's own editor writes them, which numbers tools and frames: the writer takes `forms`
    forms: bool = False
    # What is refused: kinds of statements, as `Vendor.reads` names them, and words of the refusals of other things
    refuses: frozenset[str] = frozenset()

    def most_numbered(self, store: Store) -> int:
        """How many variables of a kind the controller can be set up to have."""
        return self.enlarged.get(store, self.numbered.get(store, 0))


def limits_of(vendor: str, forms: bool = False) -> Limits:
    """The limits of a language; `forms`: of its editor's forms where it has such. Raises OlpError (X010) for one that
    cannot be written."""
    name = f"olp.languages.vendors.{vendor}.limits"
    try:
        module = import_module(name)
    except ModuleNotFoundError as missing:
        if not f"{name}.".startswith(f"{missing.name}."):
            raise  # what that module itself asks for
        raise OlpError(error("X010", f"olp cannot write '{vendor}'")) from None
    limits = getattr(module, "FORMS", module.LIMITS) if forms else module.LIMITS
    assert isinstance(limits, Limits)
    return limits


@cache
def writable() -> tuple[str, ...]:
    """The vendors whose language can be written, sorted."""
    from olp.languages.vendor import vendor_names

    templates = set(resources.names("templates", ".j2"))
    return tuple(name for name in vendor_names() if name in templates)


def refuse_unwritable(vendor: str) -> None:
    """Raises OlpError (X001), which lists the languages that can be written."""
    if vendor not in writable():
        from olp.languages.vendor import find_vendor

        known = ", ".join(f"{name} ({find_vendor(name).title})" for name in writable())
        raise OlpError(error("X001", f"olp cannot write '{vendor}'", help=f"it writes: {known}"))
