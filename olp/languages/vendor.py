"""A vendor's language as the rest of olp sees it, how the vendors are found, and how a file of any of them is read.

Of a file that is no program the reader says what it is: a picture, an archive, a log, something encrypted.
"""

from __future__ import annotations

import os
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import lru_cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Final, NamedTuple

from olp.core.diagnostic import OlpError, error
from olp.core.files import expand_paths, parse_json
from olp.core.registry import file_names
from olp.core.source import Source, load
from olp.ir.expressions import Number, Text
from olp.ir.program import Process, Program, Routine, Statement

if TYPE_CHECKING:
    from olp.ir.program import Program

ACKNOWLEDGED: Final = "acknowledge"  # spelling of a Pause that ends when the operator acknowledges a message
SHOWN: Final = "shown"  # argument of a Process that tells people something, and does nothing else: the text
ON_THE_WAY: Final = (
    "on the way"  # argument of a Process that keeps the arm going: why what follows is not exact
)
# Argument of a Process about what runs as soon as a condition comes true: a text, "declared" (with the arguments
# "number", "when", "call"), "on" or "off" (with "number", 0: all of them).
WATCH: Final = "watch"
BEGINS, ONCE = (
    "begins",
    "once",
)  # further arguments of a "declared" one: it is on at once; its routine switches it off
TRAP: Final = "trap"  # of Routine.details: what is watched calls it, nothing else
# Names of a Process, case folded, that end the program as a whole, whoever called the routine.
ENDS_CYCLE: Final = "exitcycle"  # the next one begins by itself
ENDS_PROGRAM: Final = frozenset({"abort", "exit", "halt", ENDS_CYCLE})
_VENDORS: Final = "olp.languages.vendors"
_USUAL: Final = (
    "Move_joint Move_linear Move_circular Assign SetOutput Dwell Wait Call Return If Else EndIf Message "
    "Comment"
)


def statements(more: str) -> frozenset[str]:
    """Kinds of statements: those that every language so far has, and `more`, names with blanks between them.

    >>> "Move spline" in statements("Move_spline While EndWhile")
    True
    """
    return frozenset(name.replace("_", " ") for name in f"{_USUAL} {more}".split())


class ArmFlags(Enum):
    """How a language says, beside a pose, in which of its postures the arm reaches it."""

    NONE = "not at all"
    FLAGS = "flags for wrist, elbow and front; of each wrist axis whether it is beyond half a turn"
    COUNTED = "the same three flags; the wrist's turns counted with their sign"
    SIGNS = "bits for wrist, elbow and front; bits for the signs of all axes"
    QUARTERS = "the quarter turn in which axes 1, 4 and 6 stand"


@dataclass(frozen=True, slots=True)
class MoveOptions:
    """What the options of a move mean that olp keeps as written (`Move.other`) and other languages do not have.

    Names are case folded, without what stands before a backslash. A move with any other option is refused.

    `harmless`: change nothing where they are left out. `harmless_values`: option -> its values, case folded, with which
    it is harmless. `processes`: first words of moves that do something besides -> what that is, `process_options`: what
    belongs to it. `manner`: change how a move is made, neither where it ends nor what happens on the way. `together`:
    keep step with a table, and are `manner` as long as every table stands. `ends_elsewhere`: values, in capitals, of
    whatever option, with which the move ends elsewhere than its target says. `silent`: what options begin with that
    say nothing to a reader.
    """

    harmless: frozenset[str] = frozenset()
    harmless_values: Mapping[str, frozenset[str]] = field(default_factory=dict)
    processes: Mapping[str, str] = field(default_factory=dict)
    process_options: frozenset[str] = frozenset()
    manner: frozenset[str] = frozenset()
    together: frozenset[str] = frozenset()
    ends_elsewhere: frozenset[str] = frozenset()
    silent: str = ""


@dataclass(frozen=True, slots=True)
class Weld:
    """An instruction that begins or ends a weld as conditions say that have a number in the controller.

    `process`: its name; `tag`: of the number; `form`: how the number is written, "": it is a number of its own.
    """

    process: str
    tag: str = ""
    form: str = ""

    def written(self, number: int) -> Process:
        """The instruction with these conditions."""
        value = Text(self.form.format(number)) if self.form else Number(number)
        return Process(0, self.process, ((self.tag, value),))

    def number(self, s: Process) -> int | None:
        """Of the conditions that `s` names; None where it is another instruction, or says anything else."""
        if s.name.casefold() != self.process.casefold() or len(s.arguments) != 1:
            return None
        ((tag, value),) = s.arguments
        if isinstance(value, Text) and self.form:
            found = re.fullmatch(re.escape(self.form).replace(r"\{\}", r"(\d+)"), value.value)
            return int(found[1]) if found else None
        return int(value.value) if tag == self.tag and isinstance(value, Number) and not self.form else None


@dataclass(frozen=True, slots=True)
class ErrorHandling:
    """How a language recovers from errors: a handler of the routine, or of a caller, runs where a statement fails.

    `number`: the variable that holds the error, `names`: of errors, `wait`: of that of a wait at its limit, `foreign`:
    of those that only statements raise which no other language has; all case folded. `again`, `onward`: processes that
    run the failed statement again, or go on behind it. `raises`: the process that makes an error, which its text names.
    """

    number: str
    names: re.Pattern[str]
    wait: str
    again: str
    onward: str
    raises: str
    foreign: re.Pattern[str]


@dataclass(frozen=True, slots=True)
class Conventions:
    """What programs of one language mean, where languages differ: the translation reads nothing else of a vendor.

    The defaults are what most languages do. What a language can be written with is in its `Limits`.
    """

    arm_flags: ArmFlags = ArmFlags.NONE
    frame_spelling: Mapping[str, str] = field(
        default_factory=dict
    )  # of numbered tools ("tool") and frames ("user")
    frame_files: Mapping[str, str] = field(
        default_factory=dict
    )  # the controller's file beside a program that gives the numbered tools ("tool") and frames ("user") their values
    first_variable: int = 1  # number of the first one, where variables have numbers
    whole_turns: bool = False  # a position holds its turn as one value, from which its angles are computed
    # Moves
    taught_frames: bool = False  # a point was taught with a tool and a frame, and moves name neither
    points_of_groups: bool = (
        False  # a point holds a position of each control group, and a move takes them all there
    )
    speed_persists: bool = False  # a move that names no speed takes that of the last one that does
    blend_levels: bool = False  # zones are levels; how large they are, the robot's file says
    partial_targets: bool = False  # a target may leave components out: they stay as they are
    actions_at_ends: bool = False  # a move may set an output or call a routine at its end
    joint_target_word: str = (
        ""  # the instruction, lower case, whose targets are joint values; the others' are poses
    )
    wrist_target_axes: bool = False  # joint values beyond six are external axes
    move_options: MoveOptions = MoveOptions()
    resolved_variables: frozenset[str] = (
        frozenset()
    )  # in capitals: what is assigned to them, the reader has made speeds, blends, tools and frames of
    told_settings: Mapping[str, str] = field(
        default_factory=dict
    )  # those of them that also set something of the controller's own -> what to say of it
    halting_process: str = ""  # stops the arm while the routine of a condition that is watched runs
    starting_process: str = ""  # lets it go on; "": the end of the routine does
    interrupted_places: Mapping[str, str] = field(
        default_factory=dict
    )  # system variable, case folded -> of the system's values that which it held when the condition came true
    returning_places: frozenset[str] = (
        frozenset()
    )  # system variables, case folded: where the arm left its path
    leaving_process: str = ""  # ends that routine and all up to the one that began to watch
    name_signs: Mapping[str, str] = field(
        default_factory=dict
    )  # the sign that begins the names of a type -> the type
    assumed_codes: frozenset[str] = (
        frozenset()
    )  # of findings of the reader that tell what it has assumed: the statement there is no exact translation
    # Values
    pose_lists: bool = False  # a pose is a list of numbers, whose elements can be read and set
    text_arrays: bool = False  # a text is declared and named as an array of characters: NAME[]
    has_records: bool = True  # values may be records, tools and frames among them
    ramps_in_time: bool = False  # a move's time is that of all of it; else it stands for the speed of its way
    stops_early: bool = False  # AND and OR leave out what stands right of them where the left side decides
    records_in_statements: bool = True  # not in declarations alone
    member_types: Mapping[str, str] = field(
        default_factory=dict
    )  # of a type of the program's own: word, in capitals -> type
    frame_records: bool = False  # a frame of several parts is a record of them
    numbered_frame_values: bool = (
        False  # a file beside the program gives the numbered tools and frames their values
    )
    sums_of_texts: bool = False  # + joins texts, and a text and a number
    sums_of_positions: bool = False  # registers of positions are added and subtracted element by element
    saved_variables: bool = False  # a backup beside the program holds the values of its variables
    own_names: re.Pattern[str] | None = (
        None  # of the controller's own variables and constants, beside those with `own_sign`
    )
    own_sign: str = ""  # begins the names of variables and files that are the controller's own
    file_points: re.Pattern[str] | None = None  # of the names of points that each file has for itself
    controller_names: bool = (
        False  # the controller holds tools, frames and signals by names that no file declares
    )
    clocks_run: bool = False  # clocks count from the controller's start on and do not stop
    zeroed_clock: str = ""  # what is taken, unconfirmed, of a running clock that is set to 0
    numeric_booleans: bool = False  # digital signals are numbers, 0 and 1
    names_read_frames: bool = (
        False  # reading the position may name a tool and a frame; else those that hold count
    )
    waits_before_reading: bool = False  # the controller ends all motion before it reads the position
    sets_tool_zero: bool = False  # tool 0 has values of its own like any other, and need not be the flange
    # Control flow
    arguments_are_values: bool = False  # no routine can change a variable that it is handed
    # Words by which others, too, call what stands inside the main routine, which else it alone calls; None: others may.
    opened_by: frozenset[str] | None = None
    first_element: int = 1  # the number of an array's first element
    surplus_arguments: bool = False  # a call may hand over more than the routine takes
    returns_by_register: bool = False  # what a routine returns is in a variable that it names itself
    for_declares: bool = False  # FOR declares its variable, which ends with the loop
    for_turns: bool = False  # FOR without a step counts down where it ends below its begin
    for_keeps_last: bool = False  # FOR ends with its variable at the last value, and not one step beyond it
    rounds_to_decimals: bool = False  # functions that round take a number of decimals
    idle_processes: Mapping[str, str] = field(
        default_factory=dict
    )  # process, case folded -> display name, where it does nothing
    silent_processes: Mapping[str, str] = field(
        default_factory=dict
    )  # likewise, where nobody would write a comment in its place
    standing_processes: frozenset[str] = (
        frozenset()
    )  # case folded: what waits until the arm stands, so that the move before ends exactly
    manner_processes: Mapping[str, str] = field(
        default_factory=dict
    )  # process, case folded -> what it says of how moves are made, which every controller does in a way of its own
    welds: tuple[Weld, Weld] | None = None  # what begins a weld and what ends it
    window_process: str = ""  # how the window of the message behind it looks
    idle_routines: Mapping[str, str] = field(
        default_factory=dict
    )  # routine of the maker's own, case folded -> what it is, where it moves nothing
    replaceable_routines: frozenset[str] = (
        frozenset()
    )  # of the controller's own, case folded: they move nothing, and another controller can be taught them
    filling_routines: frozenset[str] = (
        frozenset()
    )  # of these, case folded: they put values into the list that is their last argument
    filling_words: Mapping[str, tuple[int, ...]] = field(
        default_factory=dict
    )  # first word of what no statement says, case folded -> which of its arguments it gives values, from 0 on
    result_types: Mapping[str, str] = field(
        default_factory=dict
    )  # function of the controller's own, case folded -> type of its value, as `Declare.type` says it
    answers: Mapping[str, tuple[bool, str]] = field(
        default_factory=dict
    )  # function of the controller's own, case folded -> what it answers elsewhere, and why
    idle_settings: Mapping[str, tuple[str, float]] = field(
        default_factory=dict
    )  # system variable, case folded -> what it is, and the least number from which on it moves nothing
    manner_settings: Mapping[str, str] = field(
        default_factory=dict
    )  # system variable, case folded -> what it says of how moves are made
    wide_numbers: frozenset[str] = frozenset()  # types, case folded, of numbers with more than 7 digits
    operator_sets: Mapping[str, str] = field(
        default_factory=dict
    )  # `Declare.native` of what is set at the pendant, too -> what is taken for it
    idle_words: frozenset[str] = (
        frozenset()
    )  # first words, case folded, of declarations that olp keeps as text
    errors: ErrorHandling | None = None  # None: no statement fails in a way that a program can handle
    wait_limit_prefix: str = ""  # of system variables that only bound waits
    known_functions: bool = False  # its functions are all known: another one is an error, and no assumption
    share_zones: bool = False  # zones are shares of the speed, corner radii are lengths; else all are lengths
    data_last: bool = False  # data of a list keep their last values when the program ends
    data_set_elsewhere: bool = (
        False  # the controller keeps what other programs and runs set; else nothing is set
    )
    data_begin_anew: bool = False  # variables of a module have their first values again in each run
    systems_stay: bool = (
        False  # positions are read with the tool and in the frame of the last move, which names both
    )
    override_begins_anew: bool = False  # each run begins at 100 %, whatever override the last one left
    data_set_by_run: bool = False  # the first value of a variable is a statement, which each run executes
    whole_numbers: bool = True  # numbers may be of a type that holds whole ones alone
    group_sizes: Mapping[str, int] = field(
        default_factory=dict
    )  # bus of groups -> signals in each, numbered one group after the other from 1
    longest_text: int = 0  # characters of a variable of texts; 0: more than programs use
    counted_signals: Mapping[str, tuple[tuple[int, str], ...]] = field(
        default_factory=dict
    )  # bus of signals that one number counts -> (number, bus): from this number on those of a bus, largest first
    on_from_one: bool = False  # a number switches a signal on from 1 on, and not above 0
    analog_values: str = "the unit of its controller"  # what the value of an analog signal counts in
    # Pulses of outputs
    off_pulse: str = ""  # how a pulse is spelt that switches off
    on_pulse: str = ""  # how one is spelt that switches on, where any other inverts
    inverting_pulse: str = ""  # what the other does
    usual_pulse: float = 0.0  # [s] of a pulse that names no time; 0: each names one
    pulse_setting: str = ""  # the loss where a pulse names no time and a setting of the controller holds it

    def is_controllers(self, name: str) -> bool:
        """Whether a variable or file is by its name the controller's own."""
        return bool(self.own_sign) and name.startswith(self.own_sign)


class CornerSpelling(NamedTuple):
    """How corners are written in a line of a program, so that one can be rounded or made smaller.

    `comment`: pattern of where one begins. `exact`: of an exact stop, and what rounds it least. `zone`: of a zone, its
    size the group 1. `sizes`: the usual sizes, smallest first; empty: any, so that it is halved. `exact_is_zone`: a
    stop is a zone as well, which may be changed; else a word of its own.
    """

    comment: str
    exact: tuple[str, str]
    zone: str
    sizes: tuple[float, ...] = ()
    exact_is_zone: bool = False


class Vendor(ABC):
    """One language. A package or module `olp.languages.vendors.<name>` holds one instance, called `VENDOR`.

    `reads`: kinds of statements that its reader makes, moves by their path ("Move spline"), for `olp vendors`.
    `data_suffixes`: those of `suffixes` whose files hold data of the programs beside them and nothing that runs.
    `packed_suffixes`: those of `suffixes` whose files are GZIP archives.
    `shared_suffixes`: those of `suffixes` that other makers' files have, too: in a folder, such a file is a program
    only where its text looks like this language.
    `list_suffixes`: of files beside the programs that hold data and are known by their text alone. `folders_beside`:
    seen from a program's folder, where the files stand that the controller loads with it.
    `joint_moves`: patterns of a straight move and what makes each a joint move, `{percent}` of rated speed.
    `comment_prefix`: what opens a comment on a line of its own. `trailing_comment_prefix`: what opens one after an
    instruction, blanks included. `comment_length`: characters that the controller keeps, without the prefix.
    `shares_names`: whether a file sees the variables and routines of all others beside it. `blending`: the law in
    `olp/blending` that the maker's blends follow. `written_suffix`: of new files, where it is not the first of
    `suffixes`. `conventions`: what its programs mean. `corners`: how corners are written.
    `advance_stops`: what sets outputs or reads inputs waits for the arm, so that the move before ends exactly, unless a
    CONTINUE stands before it.

    For editors: `editor_names`: what editors call the language besides its name. `numbered_lines`: every line has a
    number, so that nobody can add one. `indented_comments`: comments may be indented. `call_mark`: what stands before
    the name of a called program, where `call_words` (a pattern) end what is before it; such languages know programs
    by the name within the file.
    `writes_probes`: olp writes the jobs that measure a robot in this language. `library_files`: stems, case folded, of
    the maker's own files whose routines `spelled_out` knows.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    suffixes: ClassVar[tuple[str, ...]]
    reads: ClassVar[frozenset[str]]
    data_suffixes: ClassVar[tuple[str, ...]] = ()
    packed_suffixes: ClassVar[tuple[str, ...]] = ()
    shared_suffixes: ClassVar[tuple[str, ...]] = ()
    list_suffixes: ClassVar[tuple[str, ...]] = ()
    folders_beside: ClassVar[tuple[str, ...]] = ()
    comment_prefix: ClassVar[str]
    trailing_comment_prefix: ClassVar[str]
    comment_length: ClassVar[int]
    comment_suffix: ClassVar[str] = ""  # what closes a comment on a line of its own
    newline: ClassVar[str] = "\r\n"
    shares_names: ClassVar[bool] = True
    case_sensitive: ClassVar[bool] = False
    blending: ClassVar[str] = "radius"
    advance_stops: ClassVar[bool] = False
    written_suffix: ClassVar[str] = ""
    conventions: ClassVar[Conventions] = Conventions()
    corners: ClassVar[CornerSpelling | None] = None
    joint_moves: ClassVar[tuple[tuple[str, str], ...]] = ()
    editor_names: ClassVar[tuple[str, ...]] = ()
    numbered_lines: ClassVar[bool] = False
    indented_comments: ClassVar[bool] = True
    call_mark: ClassVar[str] = ""
    call_words: ClassVar[str] = ""
    writes_probes: ClassVar[bool] = False
    library_files: ClassVar[frozenset[str]] = frozenset()

    def folders_with(self, folder: Path) -> list[Path]:
        """The folders whose files the controller loads together with those of `folder`, that one first."""
        others = [folder / name for name in self.folders_beside]
        return [folder, *(one for one in others if one.is_dir() and not one.samefile(folder))]

    def spelled_out(
        self, body: tuple[Statement, ...], find: Callable[[str], Routine | None]
    ) -> tuple[Statement, ...]:
        """A routine's statements with what only this maker's controllers do in one of them as plain statements.

        `find`: a routine of the program by its name, None for one that is not here or stands in `library_files`.
        """
        return body

    def without_editor_comments(self, body: tuple[Statement, ...]) -> Sequence[Statement]:
        """A routine's statements without the comments that only the maker's editor reads."""
        return body

    def as_called(self, program: Program) -> Program:
        """A whole program with what its own calls decide, such as which parameters are handed over."""
        return program

    def comment_of(self, line: bytes) -> bytes | None:
        """What a comment on a line of its own says, without what opens and closes it; None for any other line."""
        prefix, suffix = self.comment_prefix.encode("ascii"), self.comment_suffix.encode("ascii")
        if not line.startswith(prefix):
            return None
        return line[len(prefix) :].rstrip(b" \t\r\n").removesuffix(suffix)

    @abstractmethod
    def sniff(self, source: Source) -> bool:
        """Whether the text looks like this language, whatever its file is called."""

    @abstractmethod
    def read(self, source: Source) -> Program:
        """The program. Never raises on bad text: what is wrong stands in `Program.diagnostics`."""


def vendor_names() -> tuple[str, ...]:
    """The names of all vendors, sorted."""
    return file_names(Vendor, "vendors")


def vendor_suffixes() -> tuple[str, ...]:
    """The suffixes of program files of all vendors, lower case, sorted: what folders are searched for."""
    vendors = [find_vendor(name) for name in vendor_names()]
    return tuple(sorted({s for one in vendors for s in one.suffixes if s not in one.data_suffixes}))


def program_files(paths: Iterable[str | Path]) -> list[Path]:
    """The programs meant by `paths`, in any language: files as they are, those of folders. Raises OlpError."""
    return expand_paths(paths, vendor_suffixes(), _is_program)


def _is_program(path: Path) -> bool:
    """Whether a file of a folder is a program and no other maker's file with its suffix."""
    suffix = path.suffix.lower()
    vendors = [one for one in map(find_vendor, vendor_names()) if suffix in one.shared_suffixes]
    try:
        return not vendors or any(one.sniff(load(path)) for one in vendors)
    except (OlpError, OSError):
        return True  # whoever reads it tells why it cannot be read


def find_vendor(name: str) -> Vendor:
    """The vendor called `name`. Raises OlpError (P003) that lists the known ones."""
    if name not in vendor_names():
        known = ", ".join(vendor_names())
        raise OlpError(error("P003", f"unknown vendor '{name}'", help=f"known vendors: {known}"))
    vendor = import_module(f"{_VENDORS}.{name}").VENDOR
    assert isinstance(vendor, Vendor)
    return vendor


@lru_cache(maxsize=64)
def conventions_of(vendor: str) -> Conventions:
    """What programs of a language mean; of one that was made, and is in no language, what most do."""
    return find_vendor(vendor).conventions if vendor in vendor_names() else Conventions()


def part_of(vendor: str, part: str) -> Any:
    """What the module `part` of a vendor's folder calls by the same name in capitals; None where there is none."""
    if vendor not in vendor_names() or find_spec(f"{_VENDORS}.{vendor}.{part}") is None:
        return None
    return getattr(import_module(f"{_VENDORS}.{vendor}.{part}"), part.upper())


def recognise(source: Source) -> Vendor | None:
    """The vendor whose language `source` is: by the file's suffix, else by its text; None when no one knows it."""
    vendors = [find_vendor(name) for name in vendor_names()]
    path = source.path.lower()
    by_suffix = [vendor for vendor in vendors if path.endswith(vendor.suffixes)]
    if len(by_suffix) == 1:
        return by_suffix[0]
    return next((vendor for vendor in by_suffix or vendors if vendor.sniff(source)), None)


def probe_language() -> str:
    """The vendor in whose language olp writes the jobs that measure a robot."""
    return next(name for name in vendor_names() if find_vendor(name).writes_probes)


def blending_of(maker: str) -> str:
    """The law that a robot maker's blends follow, "" for a maker whose language nobody reads."""
    vendors = (find_vendor(name) for name in vendor_names() if maker_of(name).casefold() == maker.casefold())
    return next((vendor.blending for vendor in vendors), "")


def maker_of(vendor: str) -> str:
    """The company of a vendor: its title without the last word, which is the language."""
    return find_vendor(vendor).title.rsplit(" ", 1)[0]


def language_of(vendor: str) -> str:
    """How people call a vendor's language: INFORM, TP."""
    return find_vendor(vendor).title.split()[-1]


_MAGIC: Final = (
    (b"\x89PNG\r\n", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF8", "a GIF picture"),
    (b"II*\x00", "a TIFF picture"),
    (b"MM\x00*", "a TIFF picture"),
    (b"%PDF-", "a PDF document"),
    (b"PK\x03\x04", "a ZIP archive"),
    (b"7z\xbc\xaf", "a 7-Zip archive"),
    (b"Rar!", "a RAR archive"),
    (b"\x7fELF", "a program for Linux"),
    (b"MZ\x90", "a program for Windows"),
    (b"SQLite format 3", "a database"),
    (b"\xd0\xcf\x11\xe0", "an Office document"),
    (b"<!DOCTYPE html", "a web page"),
    (b"<html", "a web page"),
    (b"{\\rtf", "an RTF document"),
)
_STAMP: Final = re.compile(
    rb"\s*[\[(]?(?:\d{4}[-/.]\d\d?[-/.]\d\d?|\d\d?[-/.]\d\d?[-/.]\d{4})[T ,;]+\d\d?:\d\d(?::\d\d)?"
)
_LOOKED_AT: Final = 4096  # bytes
_FEW: Final = 256  # bytes that say nothing of a file
_STAMPED: Final = 0.6  # share of a log's lines
_ODD: Final = 0.3  # share of bytes that no text has
_PRINTED: Final = frozenset((*range(32, 127), 9, 10, 13, 26))


def binary_kind(raw: bytes) -> str:
    """What the first bytes say that a file is, "" for what may be a text."""
    head = raw[:_LOOKED_AT].lstrip(b"\xef\xbb\xbf")
    return next((kind for magic, kind in _MAGIC if head[: len(magic)].lower() == magic.lower()), "")


def text_kind(raw: bytes) -> str:
    """What a file is that no language recognises, "" where it cannot be told."""
    head = raw[:_LOOKED_AT]
    if head.startswith(b"\x1f\x8b"):
        return "a GZIP archive"
    lines = [line for line in head.splitlines() if line.strip()]
    if len(lines) > 1 and sum(_STAMP.match(line) is not None for line in lines) >= _STAMPED * len(lines):
        return "a log: its lines begin with a time"
    if head[:1] in (b"{", b"[") and len(raw) < 16 * _LOOKED_AT:
        try:
            parse_json(raw)
        except ValueError:
            return ""
        return "JSON"
    odd = sum(byte not in _PRINTED for byte in head)
    wide = head[:2] in (b"\xff\xfe", b"\xfe\xff") or head.count(0) > 0.4 * len(head)  # UTF-16
    if len(head) >= _FEW and odd > _ODD * len(head) and not wide and head.count(b"\n") < len(head) / 80:
        return "no text: it is encrypted or compressed"
    return ""


def read(path: str | os.PathLike[str], *, vendor: str | None = None, encoding: str | None = None) -> Program:
    """The program in the file `path`.

    `vendor`: its language; recognised by suffix and text when None. `encoding`: a Python codec name; guessed when
    None. Mistakes in the text do not raise: they are in `Program.diagnostics`, and the rest is usable.
    Raises OlpError when the file cannot be read (P004), its encoding is unknown (P005) or nobody knows its
    language (P002, P003), and for a file of another kind (P044).

    Example:
        >>> import olp
        >>> program = olp.read("samples/inform/generations/dx200.jbi")
        >>> program.vendor, len(program.diagnostics)
        ('inform', 0)
    """
    try:
        source = load(path, encoding)
    except OSError as problem:
        why = problem.strerror or str(problem)
        raise OlpError(
            error("P004", f"cannot read the file: {why}", file=os.fspath(path), help="check the path")
        ) from None
    except LookupError:
        raise _unknown_encoding(encoding) from None
    _refuse_other_kinds(source, vendor)
    return read_source(source, vendor=vendor)


def _refuse_other_kinds(source: Source, vendor: str | None) -> None:
    """Raises OlpError (P044) for a file that is no program but something that is known."""
    found = find_vendor(vendor) if vendor else recognise(source)
    packed = found is not None and source.path.lower().endswith(found.packed_suffixes)
    kind = binary_kind(source.raw)
    if not kind and not packed and not (found and found.sniff(source)):
        kind = text_kind(source.raw)
    if kind:
        known = f"a program of {found.title}" if found else "a robot program"
        help = f"give {known} as text, as the controller saves it"
        if kind.endswith("archive"):
            help = "unpack it, and give the folder or one of the programs in it"
        raise OlpError(error("P044", f"this is {kind}", file=source.path, help=help))


def check_encoding(encoding: str) -> None:
    """Raises OlpError (P005) when no text can be read with it."""
    try:
        b" ".decode(encoding, "replace")
    except LookupError:
        raise _unknown_encoding(encoding) from None


def _unknown_encoding(encoding: str | None) -> OlpError:
    return OlpError(error("P005", f"unknown encoding '{encoding}'", help="try cp1252, shift_jis or utf-8"))


def read_source(source: Source, *, vendor: str | None = None) -> Program:
    """The program in a text that is already here. Raises OlpError like `read`."""

    found = find_vendor(vendor) if vendor else recognise(source)
    if found is None:
        known = ", ".join(f"{v.title} ({' '.join(v.suffixes)})" for v in map(find_vendor, vendor_names()))
        raise OlpError(
            error(
                "P002",
                "this is not a robot program that olp knows",
                file=source.path,
                help=f"olp reads {known}",
            )
        )
    return found.read(source)
