"""What every language promises that olp writes: `check_writer`."""

from __future__ import annotations

import math
import re
from collections.abc import Generator, Iterator, Mapping
from dataclasses import replace
from functools import cached_property, lru_cache
from itertools import groupby, zip_longest
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from olp.contracts import handling, readings
from olp.contracts.events import OracleEvent, differences, events_of, robot_of, stopped_by_advance
from olp.contracts.oracle import PoseSpelling, is_written, numbers_of, spelling_of
from olp.contracts.programs import (
    BRANCHES,
    COMMENT,
    POINTS,
    Contract,
    contract_program,
    edge_statements,
    fields_that_count,
    literal,
    two_of_a_name,
)
from olp.contracts.promises import Difference, Promise, chosen, hold
from olp.core.diagnostic import OlpError, Severity
from olp.core.files import temporary_cell
from olp.core.source import decode, load
from olp.core.units import mm
from olp.ir.expressions import Compare, Number, Quantity, Signal, SignalState
from olp.ir.program import Comment, Declare, Move, Opaque, PathTrigger, Program, SetOutput, Wait
from olp.languages.limits import limits_of, writable
from olp.languages.vendor import Vendor, find_vendor, part_of, vendor_names
from olp.runtime.end_actions import shown_at_ends
from olp.runtime.interpreter import run
from olp.transpile import Context, Loss
from olp.transpile.context import Fate, Translated
from olp.transpile.convert import Converted, convert, export, first_routine, starting
from olp.transpile.helper_routines import COMPUTED
from olp.transpile.link import link
from olp.transpile.statement_programs import probes, program_with

_DATE: Final = "2026/04/23 17:39"
_ROBOT: Final = "X012"  # the code of what a translation cannot know without a robot


class Sample(NamedTuple):
    """A language's handling program with the files that it calls, and the kind of speed that its joint moves have.

    `blends`: the kinds of moves whose blends are lengths; others are shares, or say only that a corner is rounded.
    """

    program: Program
    joint: str
    blends: frozenset[str]


@lru_cache(maxsize=32)
def handling_sample(name: str) -> Sample | None:
    """The handling program of a vendor in the checkout's `samples`; None where it has none."""
    vendor = find_vendor(name)
    main = handling.main_of(vendor, handling.samples_folder(vendor))
    return None if main is None else sample_of(handling.HandlingSample(vendor, None))


def sample_of(it: handling.HandlingSample) -> Sample:
    """A vendor's handling program as translations take it."""
    program = link(it.vendor.read(load(it.main))).program
    found = events_of(program, run(program, robot_of(), folder=it.main.parent), it.vendor)
    lengths = frozenset(e.kind for e in found if e.blend > 0.0)
    return Sample(program, handling.joint_speeds_of(found), lengths)


class WriterUnderTest(handling.HandlingSample):
    """A vendor whose language is written, with what its suite makes once."""

    @cached_property
    def spelling(self) -> tuple[str, PoseSpelling]:
        """How the hand-written sample spells poses, found without any reader."""
        found = spelling_of(handling.text_of(self.vendor, self.folder), handling.POINTS)
        assert found is not None, (
            f"no pose of the handling cell is found in {self.folder}, in whatever convention"
        )
        return found

    @cached_property
    def contracts(self) -> Mapping[int, tuple[Contract, Converted]]:
        """The contract program for each start that takes another branch, and its files in this language."""
        made = {n: contract_program(n) for n in BRANCHES}
        return {n: (one, self.written(one.program)) for n, one in made.items()}

    @cached_property
    def foreign(self) -> list[tuple[str, str, Converted | OlpError]]:
        """(language, file, what is made of it) of the programs with declared readings of all other languages."""
        languages = [name for name in vendor_names() if name != self.vendor.name]
        return [(one, name, _made(self.vendor, p)) for one in languages for name, p in _declared(one)]

    def written(self, program: Program, on_loss: str = "error") -> Converted:
        return convert(program, self.vendor.name, Context(robot=robot_of(), on_loss=on_loss), date=_DATE)

    def undeclared(self, kind: str, refused: OlpError) -> Iterator[str]:
        """What a refusal says and `Limits.refuses` does not. `kind`: of the refused statement, "" for other things."""
        declared = limits_of(self.vendor.name).refuses
        for found in refused.diagnostics:
            if kind not in declared and not any(words in found.message for words in declared):
                says = f"refused, and `refuses` of {self.vendor.name}'s limits names nothing of it: {found.message}"
                yield (
                    f"{says} (line {found.line}: {found.source_line.strip()})" if found.source_line else says
                )
            if not found.code or not found.message.strip():
                yield "refused without a reason"

    def unlike(self, given: str, program: Program, wanted: list[OracleEvent]) -> Iterator[Difference]:
        """What changes when a program that was read is written in its own language again, and that once more."""
        made = self.written(program)
        again, found = self.events(made)
        yield from ((f"{given}, read and written again", d) for d in differences(wanted, found))
        twice = self.written(again).files
        yield from (
            (f"{given}, read and written again", f"{name}: {unlike_text(data, twice.get(name, b''))}")
            for name, data in made.files.items()
            if twice.get(name) != data
        )

    def events(self, made: Converted) -> tuple[Program, list[OracleEvent]]:
        return read_again(made, self.vendor)


def read_again(
    made: Converted, vendor: Vendor, beside: Path | None = None, *, runs: bool = True
) -> tuple[Program, list[OracleEvent]]:
    """The files, read again and run beside each other, and the events, none where it does not run.

    `beside`: a folder with data that they need.
    """
    with temporary_cell() as folder:
        for path in beside.iterdir() if beside is not None else ():
            if path.is_file() and path.suffix.lower() not in vendor.suffixes:
                (folder / path.name).write_bytes(path.read_bytes())
        for name, data in made.files.items():
            (folder / name).write_bytes(data)
        program = vendor.read(load(folder / made.main))
        told = [found.render() for found in program.diagnostics if found.severity != Severity.INFO]
        if told:
            raise AssertionError(f"{vendor.name} does not read what was written without a word: {told[0]}")
        first = first_routine(program, made, vendor.name)
        program = starting([program], made.translated.mapping.get(("routine", first), first))
        linked = link(program).program
        if not runs:
            return linked, []
        shown = shown_at_ends(program)
        return linked, events_of(shown, run(shown, robot_of(), folder=folder, max_steps=5000), vendor)


def check_writer(vendor: Vendor, *, samples: Path | None = None, first: bool = False, only: str = "") -> None:
    """Raises ContractError with every promise of a writer that `vendor` breaks.

    `samples`: the folder with its handling program; None: `samples/NAME` of a checkout. `first`: stops at the first.
    `only`: tries the one promise of this name, as in `check_vendor`.

        from olp.contracts import check_writer
        check_writer(VENDOR)
    """
    hold(f"writer {vendor.name}", WriterUnderTest(vendor, samples), chosen(PROMISES, only), first=first)


# --- the text ----------------------------------------------------------------------------------------------


_TRIGGERS: Final = tuple(
    PathTrigger(
        Signal("out", Number(3)),
        SignalState(on),
        at_start,
        None if metres is None else Quantity(Number(metres), mm),
        None if seconds is None else Quantity(Number(seconds), 1.0),
    )
    for on, at_start, metres, seconds in (
        (True, False, None, -0.13),
        (False, False, None, 0.07),
        (True, False, -17.5, None),
        (False, False, -17.5, -0.04),
        (True, True, 23.5, None),
        (False, True, None, 0.11),
        (True, True, 23.5, 0.06),
    )
)


def is_found(it: WriterUnderTest) -> Iterator[Difference]:
    """A language with a writer and a template is one of those that can be written"""
    if it.vendor.name not in writable():
        yield it.vendor.name, f"olp writes {', '.join(writable())}"


def lacks_what_a_routine_computes(it: WriterUnderTest) -> Iterator[Difference]:
    """What its limits lack is computed by a routine of the translation; the writer spells or refuses all else"""
    for name in sorted(limits_of(it.vendor.name).lacks - COMPUTED.keys()):
        yield f"lacks {name!r}", f"a routine computes {', '.join(sorted(COMPUTED))}"


def spells_poses_as_the_sample(it: WriterUnderTest) -> Iterator[Difference]:
    """Every point of a program is in the written text: in the units and angles of the hand-written sample"""
    name, spelling = it.spelling
    for n, (contract, made) in it.contracts.items():
        numbers = numbers_of(_text(made))
        for point, pose in contract.poses.items():
            if not is_written(numbers, pose, spelling):
                yield (
                    f"the point {point} {POINTS[point]} of contract_program({n})",
                    f"not in the text as {name}",
                )


def spells_speeds_as_the_sample(it: WriterUnderTest) -> Iterator[Difference]:
    """Every speed of a straight move and every waiting time is in the written text, in the units of the sample"""
    sample = numbers_of(handling.text_of(it.vendor, it.folder))
    contract, made = it.contracts[BRANCHES[0]]
    numbers = [*numbers_of(_text(made)), *_glued(_text(made))]
    sample += _glued(handling.text_of(it.vendor, it.folder))
    speeds = {e.speed for e in contract.events if e.kind in ("linear", "arc")}
    waits = {e.seconds for e in contract.events if e.kind == "wait"}
    for what, anchors, values in (("a speed", handling.SPEEDS, speeds), ("a wait", (0.35, 0.1), waits)):
        unit = next((u for u in (1.0, 0.001) if all(_holds(sample, a / u) for a in anchors)), None)
        if unit is None:
            yield str(it.folder), f"{what} of the handling cell is in no unit in the sample"
            continue
        missing = [value for value in sorted(values) if not _holds(numbers, value / unit)]
        if missing:
            yield (
                f"{what} of contract_program({BRANCHES[0]}) in units of {unit:g}",
                f"not in the text: {missing}",
            )


def _glued(text: str) -> list[float]:
    """Numbers that a unit or a letter touches (250mm/sec, V=250.0, v1500)."""
    return [float(found) for found in re.findall(r"\d+\.\d+|\.\d+|\d+", text)]


def _holds(numbers: list[float], value: float) -> bool:
    return any(abs(one - value) <= 1e-6 * max(abs(value), 1.0) for one in numbers)


def _text(made: Converted) -> str:
    return "\n".join(data.decode("cp1252", "replace") for data in made.files.values())


def writes_as_declared(it: WriterUnderTest) -> Iterator[Difference]:
    """The contract program, programs at the edges, and those with declared readings are written as declared"""
    yield from other_texts(it)


def keeps_words(it: WriterUnderTest) -> Iterator[Difference]:
    """Comments and the names of routines are in the written text, which has the vendor's line ends"""
    _, made = it.contracts[BRANCHES[0]]
    text = _text(made)
    for word in (COMMENT, "many", "MAINJOB", "SUBJOB"):
        if word.lower() not in text.lower() and word.lower() not in " ".join(made.files).lower():
            yield f"{word!r} of the contract program", "not in the text"
    end = it.vendor.newline.encode()
    for name, data in made.files.items():
        if data.replace(end, b"").count(b"\n") or data.replace(end, b"").count(b"\r"):
            yield name, f"it has other line ends than {it.vendor.newline!r}"
        if not data.endswith(end):
            yield name, "its last line has no end"


def writes_the_same_again(it: WriterUnderTest) -> Iterator[Difference]:
    """The same program is the same text, however often it is written"""
    contract, made = it.contracts[BRANCHES[0]]
    if it.written(contract.program).files != made.files:
        yield f"contract_program({BRANCHES[0]})", "another text the second time"


def writes_what_controllers_load(it: WriterUnderTest) -> Iterator[Difference]:
    """A controller loads the contract program and other languages' programs as they are written; names that only these
    have may be declared elsewhere"""
    loading = part_of(it.vendor.name, "load")
    if loading is None:
        return
    contracts = [(f"contract_program({n})", made) for n, (_, made) in it.contracts.items()]
    others = [(f"{n} of {v}", made) for v, n, made in it.foreign if isinstance(made, Converted)]
    for given, made in (*contracts, *others):
        with temporary_cell() as folder:
            for name, data in made.files.items():
                (folder / name).write_bytes(data)
            for path in sorted(folder.iterdir()):
                if path.suffix.lower() not in it.vendor.suffixes:
                    continue
                source = load(path)
                for found in loading.refused(source, it.vendor):
                    if found.code != _ELSEWHERE or given.startswith("contract_program"):
                        yield f"{given}, {path.name}:{found.line}: {found.source_line.strip()}", found.message


# --- what the text does ------------------------------------------------------------------------------------


def has_a_true_reader(it: WriterUnderTest) -> Iterator[Difference]:
    """The reader that reads written programs is right: it finds the handling cell in the hand-written sample"""
    program = it.vendor.read(load(it.main))
    for parts in (handling.PARTS, 1):
        started = handling.with_parts(program, parts)
        plan = run(started, robot_of(), folder=it.main.parent, max_steps=2000)
        found = events_of(started, plan, it.vendor)
        wanted = stopped_by_advance(handling.events(parts, handling.joint_speeds_of(found)), it.vendor)
        yield from ((f"{it.main.name} with {parts} parts", d) for d in differences(wanted, found))


def does_what_the_program_does(it: WriterUnderTest) -> Iterator[Difference]:
    """The written contract program does what the neutral one does: every move, speed, blend, signal, wait and branch"""
    for n, (contract, made) in it.contracts.items():
        _, found = it.events(made)
        wanted = loosened(stopped_by_advance(contract.events, it.vendor), made.translated.losses)
        yield from ((f"contract_program({n})", d) for d in differences(wanted, found))


def does_the_same_in_one_file(it: WriterUnderTest) -> Iterator[Difference]:
    """Exported as one file, where no robot is needed for that, the contract program does the same"""
    for n, (contract, made) in it.contracts.items():
        try:
            data = export(contract.program, it.vendor.name, date=_DATE)
        except OlpError as refused:
            yield from (
                (f"contract_program({n})", one.render()) for one in refused.diagnostics if one.code != _ROBOT
            )
            continue
        _, found = it.events(replace(made, files={made.main: data}))
        wanted = loosened(stopped_by_advance(contract.events, it.vendor), made.translated.losses)
        yield from ((f"contract_program({n}) in one file", d) for d in differences(wanted, found))


def loosened(events: Any, losses: tuple[Loss, ...]) -> list[OracleEvent]:
    """The events without what a receipt names of joint moves: their speed within `_LOOSE`, the size of their blend."""
    parts = frozenset(loss.part for loss in losses if loss.part in ("speed", "blend"))
    return [replace(e, loose=e.loose | parts) if parts and e.kind == "joint" else e for e in events]


def loses_nothing_else(it: WriterUnderTest) -> Iterator[Difference]:
    """The receipt of the contract program names nothing but speeds and blends of joint moves, and what comes early"""
    for n, (_, made) in it.contracts.items():
        for loss in made.translated.losses:
            joint = loss.part in ("speed", "blend") and loss.statement.startswith("Move joint")
            if not joint and loss.part != "order":
                yield (
                    f"contract_program({n})",
                    f"line {loss.line}, {loss.statement}: {loss.part}: {loss.says}",
                )


def writes_each_kind_of_statement(it: WriterUnderTest) -> Iterator[Difference]:
    """Each kind of statement does the same when it is written and read again, or its limits declare it as refused"""
    declared = limits_of(it.vendor.name).refuses
    for kind, statements in probes().items():
        program = program_with(statements, it.vendor.name)
        try:
            made = it.written(program)
        except OlpError as refused:
            yield from ((kind, told) for told in it.undeclared(kind, refused))
            continue
        if kind in declared:
            yield kind, "its limits say that it is refused, and it is written"
        plan = run(program, robot_of(), max_steps=5000)
        wanted = [
            replace(e, axes=e.axes if e.kind == "joint" else ()) for e in events_of(program, plan, it.vendor)
        ]
        again, found = it.events(made)
        wanted = stopped_by_advance(loosened(wanted, made.translated.losses), it.vendor)
        yield from ((f"a program with {kind}", d) for d in differences(wanted, found))
        yield from it.unlike(f"a program with {kind}", again, found)


def keeps_inputs_and_outputs_apart(it: WriterUnderTest) -> Iterator[Difference]:
    """An input and an output of one number stay two signals, or such a program is refused"""
    inside, outside = (Signal(bus, Number(3)) for bus in ("in", "out"))
    for state in (True, False):
        wait = Wait(0, Compare("=", inside, SignalState(state)))
        program = program_with((SetOutput(0, outside, SignalState(True)), wait), it.vendor.name)
        try:
            _, found = it.events(it.written(program))
        except OlpError:
            continue
        wanted = events_of(program, run(program, robot_of()), it.vendor)
        yield from (
            (f"output 3 on, then a wait for input 3 = {state}", d) for d in differences(wanted, found)
        )


def keeps_variables_apart(it: WriterUnderTest) -> Iterator[Difference]:
    """A variable of a routine is another than one of the same name that another routine or the program has"""
    for name, statements, other in two_of_a_name():
        program = program_with(statements, it.vendor.name, other)
        try:
            _, found = it.events(it.written(program))
        except OlpError as refused:
            yield from ((name, told) for told in it.undeclared("", refused))
            continue
        wanted = events_of(program, run(program, robot_of()), it.vendor)
        yield from ((name, d) for d in differences(wanted, found))


def leaves_out_nothing_in_silence(it: WriterUnderTest) -> Iterator[Difference]:
    """What changes what a statement does is written, told in the receipt, or refused, never left out"""
    for name, without, having in fields_that_count():
        try:
            plain, full = (it.written(program_with(one, it.vendor.name)) for one in (without, having))
        except OlpError:
            continue
        told = [(x.translated.losses, x.translated.remarks, x.translated.notes) for x in (plain, full)]
        if plain.files == full.files and told[0] == told[1]:
            yield name, "the same text as without it, and nothing is told"


def switches_on_the_way(it: WriterUnderTest) -> Iterator[Difference]:
    """An output that a move switches on its way does so at the same place when it is written and read again"""
    forms = limits_of(it.vendor.name).path_triggers
    *before, last = probes()["Move linear"]
    assert isinstance(last, Move)
    for trigger in _TRIGGERS if forms is not None else ():
        if forms is None or not forms.say(trigger, last.path):
            continue
        program = program_with((*before, replace(last, triggers=(trigger,))), it.vendor.name)
        made = it.written(program)
        again, _ = read_again(made, it.vendor, runs=False)
        wanted, found = (list(run(one, robot_of()).events.values()) for one in (program, again))
        given = (
            f"{trigger.metres and trigger.metres.literal} m, {trigger.seconds and trigger.seconds.literal} s"
        )
        if len(found) != len(wanted):
            yield given, f"it switches {len(found)} outputs, not {len(wanted)}"
            continue
        for one, other in zip(wanted, found, strict=True):
            far = (one.value, one.metres, one.seconds), (other.value, other.metres, other.seconds)
            if not np.allclose(*far, rtol=0.0, atol=1e-6):
                yield given, f"value, metres and seconds behind the end: {far[1]}, not {far[0]}"


def writes_back_its_own(it: WriterUnderTest) -> Iterator[Difference]:
    """A program that is exported in its own language and read again does the same, with the same comments"""
    program = link(it.vendor.read(load(it.main))).program
    for parts in (handling.PARTS, 1):
        made = it.written(handling.with_parts(program, parts))
        again, found = read_again(made, it.vendor, it.main.parent)
        wanted = stopped_by_advance(handling.events(parts, handling.joint_speeds_of(found)), it.vendor)
        yield from ((f"{it.main.name}, written, {parts} parts", d) for d in differences(wanted, found))
        if _comments(again) != _comments(program):
            gone = [text for text in _comments(program) if text not in _comments(again)]
            yield it.main.name, f"comments are not the same, without {gone}"
        twice = it.written(again).files
        if twice != made.files:
            changed = [name for name in made.files if twice.get(name) != made.files[name]]
            yield from (
                (
                    f"{name}, written, read and written again",
                    unlike_text(made.files[name], twice.get(name, b"")),
                )
                for name in changed
            )


def unlike_text(wanted: bytes, found: bytes) -> str:
    """The first line where two texts differ."""
    rows = zip_longest(*(data.decode("cp1252", "replace").splitlines() for data in (wanted, found)))
    pairs = ((at, one, other) for at, (one, other) in enumerate(rows, 1) if one != other)
    at, one, other = next(pairs, (0, "other line ends", None))
    said, was = ("no line" if row is None else repr(row.strip()) for row in (one, other))
    return f"another text, line {at}: {said} is wanted, and there is {was}"


def _comments(program: Program) -> list[str]:
    found = [s.text if isinstance(s, Comment) else getattr(s, "comment", "") for s in program.statements()]
    return [text.strip() for text in found if text.strip()]


def translates_there_and_back(it: WriterUnderTest) -> Iterator[Difference]:
    """Other languages' handling programs do the same in this one and when translated back, or a refusal is declared"""
    refusals = []
    for name in vendor_names():
        sample = handling_sample(name) if name != it.vendor.name else None
        if sample is not None and (yield from translated(it, find_vendor(name), sample)):
            refusals.append(name)
    if 2 * len(refusals) > len(vendor_names()):
        yield f"handling programs of {', '.join(refusals)}", "refused: a writer takes those of most languages"


def translated(it: WriterUnderTest, source: Vendor, sample: Sample) -> Generator[Difference, None, bool]:
    """What differs where a handling program is written in `it`'s language and translated back; True: it is refused."""
    given = f"{source.name} to {it.vendor.name}"
    try:
        there = it.written(sample.program)
    except OlpError as refused:
        yield from ((given, told) for told in it.undeclared("", refused))
        return True
    read, found = it.events(there)
    wanted = stopped_by_advance(_wanted(sample, there), it.vendor, source)
    yield from ((given, d) for d in differences(wanted, found))
    yield from it.unlike(given, read, found)
    if source.name in writable():
        back = convert(read, source.name, Context(robot=robot_of(), on_loss="comment"), date=_DATE)
        commented = [loss for loss in back.translated.losses if loss.fate is Fate.COMMENTED]
        if any(words in loss.says for loss in commented for words in limits_of(source.name).refuses):
            return False  # what the language says it cannot take back
        _, found = read_again(back, source)
        twice = loosened(wanted, back.translated.losses)
        kept = [replace(e, loose=e.loose | {"blend"}) if e.kind == "joint" else e for e in twice]
        # How long the way to the first point is, nobody can say, so no speed of another kind comes back from it.
        kept[0] = replace(kept[0], share=math.nan, axis=math.nan, speed=math.nan)
        if differ := [(f"{given} and back", d) for d in differences(kept, found)]:
            # What is no statement any more explains them.
            for loss in commented:
                says = (
                    f"line {loss.line} in {it.vendor.name} is a comment in {source.name}, "
                    f"and `refuses` of {source.name}'s limits names nothing of it: {loss.says}"
                )
                yield f"{given} and back", says
            yield from differ
    return False


def takes_what_others_read(it: WriterUnderTest) -> Iterator[Difference]:
    """The programs with declared readings of other languages are written, or refused with a code and a line, or help
    where data without a line are refused; what is written is read without a word"""
    for name, _, made in it.foreign:
        if isinstance(made, Converted):
            read_again(made, it.vendor, runs=False)
            continue
        for found in made.diagnostics:
            if not found.code:
                yield name, f"refused without a code: {found.message}"
            elif not (found.line or found.help):
                yield (
                    name,
                    f"refused without a line, as data are, and without a help in its place: {found.message}",
                )


def _declared(language: str) -> tuple[tuple[str, Program], ...]:
    """(file, program) of the declared readings of a language."""
    vendor = find_vendor(language)
    paths = readings.readings_of(handling.samples_folder(vendor))
    return _programs(vendor, tuple(path.read_text(encoding="utf-8") for path in paths if path.stem != _WORDS))


@lru_cache
def _programs(vendor: Vendor, texts: tuple[str, ...]) -> tuple[tuple[str, Program], ...]:
    parts = (readings.files_of(text.splitlines()) for text in texts)
    found = (row for files in parts for row in readings.programs_of(vendor, files))
    return tuple((name, program) for name, program in found if _is_whole(program))


def _is_whole(program: Program) -> bool:
    return bool(program.routines) and not any(found.is_error for found in program.diagnostics)


def _made(vendor: Vendor, program: Program, *, forms: bool = False) -> Converted | OlpError:
    """The files of a program, or why there are none. `forms`: moves as the pendant writes them."""
    try:
        context = Context(robot=robot_of(), on_loss="comment", forms=forms)
        return convert(program, vendor.name, context, date=_DATE)
    except OlpError as refused:
        return refused


def _wanted(sample: Sample, made: Converted) -> list[OracleEvent]:
    events = _numbered(loosened(handling.events(joint=sample.joint), made.translated.losses), made)
    return [
        replace(e, loose=e.loose | {"blend"})
        if e.kind not in sample.blends and (e.kind == "joint" or e.blend > 0.0)
        else e
        for e in events
    ]


def _numbered(events: list[OracleEvent], made: Converted) -> list[OracleEvent]:
    """With the free numbers that signals got whose names in the source hold none."""
    given = {
        "input" if name.startswith("in ") else "output": int(number)
        for (kind, name), number in made.translated.mapping.items()
        if kind == "signal" and number.isdigit() and not re.search(r"\d", name)
    }
    return [replace(e, signal=given.get(e.kind, e.signal)) if e.signal != "" else e for e in events]


# --- what cannot be said -----------------------------------------------------------------------------------


def refuses_what_it_cannot_say(it: WriterUnderTest) -> Iterator[Difference]:
    """What the language cannot say is refused with its line before a character is written, never left out"""
    contract, _ = it.contracts[BRANCHES[0]]
    main = contract.program.routines[0]
    foreign = Opaque(main.body[3].line, "DoWhatNobodyKnows 17, \\Fast")
    nowhere = replace(literal(POINTS["part"]), values=(math.nan, 0.1, 0.2, 0.3, 0.4, 0.5))
    program = contract.program
    bad = {
        "a word of another language": replace(
            program,
            routines=(replace(main, body=(*main.body[:3], foreign, *main.body[3:])), *program.routines[1:]),
        ),
        "a point without x": replace(
            program,
            data=tuple(
                replace(d, value=nowhere) if isinstance(d, Declare) and d.name == "over" else d
                for d in program.data
            ),
        ),
    }
    for name, one in bad.items():
        try:
            made = it.written(one)
        except OlpError as refused:
            if not all(found.code and found.message for found in refused.diagnostics):
                yield name, "refused without a reason"
            continue
        if name.startswith("a word") and not made.translated.losses:
            yield name, "written without a word in the receipt"
        if "nan" in _text(made).lower():
            yield name, "the text has a number that is none"
    yield from _refuses_an_unknown_signal(it)


def _refuses_an_unknown_signal(it: WriterUnderTest) -> Iterator[Difference]:
    """The passes do not look at a program of the language itself: its writer alone can refuse."""
    program = link(it.vendor.read(load(it.main))).program
    first = program.routines[0]
    at = len(first.body) // 2
    unknown = SetOutput(first.body[at].line, Signal("nobody-knows", Number(3)), SignalState(True))
    body = (*first.body[:at], unknown, *first.body[at:])
    try:
        it.written(replace(program, routines=(replace(first, body=body), *program.routines[1:])))
    except OlpError as refused:
        if not any(found.line == unknown.line for found in refused.diagnostics):
            yield "an output of a kind that nobody knows", "refused without its line"
        return
    yield "an output of a kind that nobody knows", "written, or left out in silence"


PROMISES: Final[tuple[Promise[WriterUnderTest], ...]] = (
    is_found,
    lacks_what_a_routine_computes,
    writes_as_declared,
    does_what_the_program_does,
    does_the_same_in_one_file,
    spells_poses_as_the_sample,
    spells_speeds_as_the_sample,
    keeps_words,
    writes_what_controllers_load,
    loses_nothing_else,
    writes_each_kind_of_statement,
    keeps_inputs_and_outputs_apart,
    keeps_variables_apart,
    leaves_out_nothing_in_silence,
    switches_on_the_way,
    has_a_true_reader,
    writes_back_its_own,
    writes_the_same_again,
    refuses_what_it_cannot_say,
    translates_there_and_back,
    takes_what_others_read,
)


# --- Declared texts: what a writer makes of programs, for the vendor's author to check once ---
# `samples/NAME/readings/*.written` holds parts as a declared reading does, each a file that olp wrote: of the contract
# program, of programs at the edges of what languages take (`edge_statements`), and of the programs with declared
# readings that have no error, in their own language and in all others. What cannot be said stands as a comment in it,
# and what the receipt tells of it, new names included, is a part of its own.


_ELSEWHERE: Final = "K101"  # a name that no file of the cell declares
_WRITTEN: Final = ".written"
_CONTRACT: Final = "contract"
_EDGES: Final = "edges"
_OTHERS: Final = "others"
_WORDS: Final = "words"  # a reading of all words of a language, which is not translated
_SHOWN: Final = 3
_MANY: Final = 40
_NUMBERS: Final = re.compile(r"\d+(?:\.\d+)?")


def declare_texts(vendor: Vendor, folder: Path) -> None:
    """Writes what olp writes now into the `.written` files of a vendor's samples, for their author to check."""
    for stem, parts in _texts(WriterUnderTest(vendor, folder)):
        readings.save(_path(folder, stem), parts)


def other_texts(it: WriterUnderTest) -> Iterator[Difference]:
    """Where a declared text and what is written differ."""
    for stem, found in _texts(it):
        path = _path(it.folder, stem)
        declared = readings.load_declared(path) if path.exists() else {}
        # A new language, or a new edge, adds to what the others can be given, and to nothing that they declare.
        more = stem in (_EDGES, _OTHERS)
        there = [name for name in found if name in declared] if more else list(found)
        if list(declared) != there:
            yield path.name, f"declared: {', '.join(declared)}; written: {', '.join(found)}"
        for name in declared.keys() & found.keys():
            for at, one, other in readings.differences(declared[name], found[name]):
                yield f"{path.name}, {name}, line {at}", f"declared: {one}; written: {other}"


def _path(folder: Path, stem: str) -> Path:
    return folder / "readings" / f"{stem}{_WRITTEN}"


def _texts(it: WriterUnderTest) -> Iterator[tuple[str, dict[str, list[str]]]]:
    """The parts of each `.written` file as olp writes them now, by the stem of the file."""
    vendor = it.vendor
    program = contract_program(BRANCHES[0]).program
    parts = dict(_rows("program", _made(vendor, program)))
    if limits_of(vendor.name, forms=True).forms:
        parts |= dict(_rows("program in forms", _made(vendor, program, forms=True)))
    if limits_of(vendor.name).data_beside:
        data = export(program, vendor.name, date=_DATE)
        parts["program in one file"] = [line.rstrip() for line in decode(data, "").lines]
    yield _CONTRACT, parts
    edges = {kind: program_with(statements, vendor.name) for kind, statements in edge_statements().items()}
    rows = [_rows(kind, _made(vendor, program)) for kind, program in edges.items()]
    yield _EDGES, {name: list(_folded(part, _MANY)) for found in rows for name, part in found}
    for path in readings.readings_of(it.folder):
        parts = {}
        for name, program in readings.programs_of(vendor, readings.load_declared(path)):
            if _is_whole(program):
                parts |= dict(_rows(name, _made(vendor, program)))
        if parts:
            yield path.stem, parts
    others = [_rows(f"{language} {name}", made) for language, name, made in it.foreign]
    yield _OTHERS, {name: list(_folded(rows)) for parts in others for name, rows in parts}


def _folded(rows: list[str], most: int = _SHOWN) -> Iterator[str]:
    """The lines, of more than `most` that differ in numbers alone the first three and how many follow."""
    for _, group in groupby(rows, lambda row: _NUMBERS.sub("#", row)):
        run = list(group)
        if len(run) <= most:
            yield from run
            continue
        yield from run[:_SHOWN]
        yield f"({len(run) - _SHOWN} more that differ in numbers alone)"


def _rows(source: str, made: Converted | OlpError) -> Iterator[tuple[str, list[str]]]:
    """The name of a program with those of its files, and their lines."""
    if isinstance(made, OlpError):
        yield f"{source}: refused", [f"line {found.line}: {found.message}" for found in made.diagnostics]
        return
    for name, data in made.files.items():
        yield f"{source}: {name}", [line.rstrip() for line in decode(data, name).lines]
    if told := list(_told(made.translated)):
        yield f"{source}: receipt", told


def _told(translated: Translated) -> Iterator[str]:
    """What a receipt tells besides the text."""
    for what, losses in (("", translated.losses), ("remark, ", translated.remarks)):
        for one in losses:
            size = "" if math.isnan(one.size) else f" ({one.size:.4g} {one.unit})"
            more = f" | {one.help}" if one.help else ""
            yield f"{what}line {one.line}: {one.statement}, {one.part} {one.fate}{size}: {one.says}{more}"
    yield from (f"note: {text}" for text in translated.notes)
    for what, asked in translated.asks.items():
        yield f"asks: {what}: {', '.join(asked)}"
    for (kind, name), value in translated.held.items():
        yield f"held: {kind} {name}: {readings.spelled(value)}"
    for (kind, name), other in translated.mapping.items():
        if name != other:
            yield f"renamed: {kind} {name}: {other}"
