"""What every language promises that olp reads: `check_vendor`."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from random import Random
from typing import Final

from olp.checks.merge.merge import merge_bytes
from olp.contracts import derived_readings, handling, readings
from olp.contracts.events import OracleEvent, differences, events_of, robot_of, stopped_by_advance
from olp.contracts.promises import Difference, Promise, chosen, hold
from olp.contracts.writers import (
    WriterUnderTest,
    does_what_the_program_does,
    sample_of,
    translated,
    unlike_text,
    writes_each_kind_of_statement,
)
from olp.core import resources
from olp.core.diagnostic import Diagnostic
from olp.core.source import Source, decode, load
from olp.ir.program import Comment, LineKind, Opaque, Program
from olp.ir.terminology import kind_of
from olp.languages.limits import writable
from olp.languages.vendor import Vendor, find_vendor, language_of, recognise, vendor_names
from olp.reports.annotate import annotate, remove
from olp.runtime.interpreter import run
from olp.timing.blending.law import law_names
from olp.timing.timing import time_plan

_CODE: Final = re.compile(r"[A-Z]\d{3}")
_KINDS: Final = frozenset(value for name, value in vars(LineKind).items() if name.isupper())
# Fields of `Conventions` whose words are looked for case folded.
_FOLDED: Final = (
    "interrupted_places", "returning_places", "idle_processes", "silent_processes", "standing_processes",
    "manner_processes", "idle_routines", "replaceable_routines", "filling_routines", "filling_words", "result_types",
    "answers", "idle_settings", "manner_settings", "idle_words",
)  # fmt: skip
_SECONDS: Final = 6.0  # of CPU for all bad texts of a language
_DECIMAL: Final = re.compile(r"(?<![\w.\[(\-+$#:])\d*\.\d+(?![\w.])")  # of no name, no index and no comment
_PAUSE: Final = 0.35  # [s] that the handling sample waits, for the line that a comment is put behind


class VendorUnderTest(handling.HandlingSample):
    """A vendor and its handling sample, read once."""

    @cached_property
    def source(self) -> Source:
        return load(self.main)

    @cached_property
    def program(self) -> Program:
        return self.vendor.read(self.source)

    @property
    def has_errors(self) -> bool:
        """Whether the sample is read with errors, which each promise would tell again."""
        try:
            return any(found.is_error for found in self.program.diagnostics)
        except Exception:  # a reader that raises is told by the promises
            return False

    def events(self, program: Program) -> list[OracleEvent]:
        """What a program does that has the handling sample's files beside it."""
        plan = run(program, robot_of(), folder=self.main.parent, max_steps=2000)
        return events_of(program, plan, self.vendor)

    @cached_property
    def found(self) -> list[OracleEvent]:
        return self.events(self.program)

    @cached_property
    def pause(self) -> int:
        """The line that waits, which is like no other."""
        found = next((e.line for e in self.found if abs(e.seconds - _PAUSE) < 1e-6), 0)
        assert found, f"{self.main.name} waits {_PAUSE} s nowhere, as the handling program does"
        return found

    def read(self, raw: bytes, encoding: str | None = None) -> Program:
        """Other bytes under the name of the sample."""
        return self.vendor.read(decode(raw, self.source.path, encoding or self.source.encoding))


def check_vendor(vendor: Vendor, *, samples: Path | None = None, first: bool = False, only: str = "") -> None:
    """Raises ContractError with every promise of a reader that `vendor` breaks.

    `samples`: the folder with its handling program and other programs; None: `samples/NAME` of a checkout.
    `first`: stops at the first broken promise. `only`: tries the one promise of this name, as the error names it;
    raises ValueError, which lists all of them, for a name of none.

        from olp.contracts import check_vendor
        check_vendor(VENDOR, samples=Path("my_samples"))
    """
    member = VendorUnderTest(vendor, samples)
    promises = chosen(PROMISES, only) if only or not member.has_errors else [keeps_every_byte]
    hold(f"vendor {vendor.name}", member, promises, first=first)


# --- what the language is -----------------------------------------------------------------------------------


def states_its_conventions(it: VendorUnderTest) -> Iterator[Difference]:
    """A vendor states its name, title, suffixes, comments, line end and law of blending"""
    vendor = it.vendor
    title = vendor.title.split()
    wanted = {
        "name": re.fullmatch(r"[a-z][a-z0-9_]*", vendor.name) is not None,
        "title": len(title) >= 2 and vendor.title.isprintable(),
        "suffixes": bool(vendor.suffixes) and all(re.fullmatch(r"\.[a-z0-9]+", s) for s in vendor.suffixes),
        "data_suffixes": set(vendor.data_suffixes) < set(vendor.suffixes),
        "shared_suffixes": set(vendor.shared_suffixes) < set(vendor.suffixes),
        "list_suffixes": all(re.fullmatch(r"\.[a-z0-9]+", s) for s in vendor.list_suffixes),
        "comment_prefix": bool(vendor.comment_prefix.strip()) and vendor.comment_prefix.isascii(),
        "comment_suffix": vendor.comment_suffix.isascii(),
        "comment_length": 20 <= vendor.comment_length <= 1000,
        "newline": vendor.newline in ("\r\n", "\n"),
        "blending": vendor.blending in law_names(),
    }
    for name, holds in wanted.items():
        if not holds:
            yield name, f"{getattr(vendor, name)!r}"
    if vendor.name not in vendor_names() or find_vendor(vendor.name) is not vendor:
        yield vendor.name, "the registry of vendors does not find it under its name"
    for name in _FOLDED:
        for word in getattr(vendor.conventions, name):
            if word != word.casefold():
                yield f"conventions.{name}", f"{word!r} is looked for as {word.casefold()!r}"


def knows_its_own_text(it: VendorUnderTest) -> Iterator[Difference]:
    """The text of a language is recognised without a suffix, and that of no other language is"""
    unnamed = replace(it.source, path="unnamed")
    found = recognise(unnamed)
    if found is None or found.name != it.vendor.name:
        yield it.main.name, f"recognised as {found.name if found else 'nothing'} without its suffix"
    if not it.vendor.sniff(unnamed):
        yield it.main.name, "sniff says that it is another language"
    for text in (b"", b"hello\n", b"\x00\x01\x02", b"{}", b"a,b,c\n1,2,3\n"):
        if it.vendor.sniff(decode(text, "unnamed")):
            yield repr(text), "sniff says that it is this language"
    for name in vendor_names():
        other = find_vendor(name)
        main = None if name == it.vendor.name else handling.main_of(other, handling.samples_folder(other))
        if main is not None and it.vendor.sniff(replace(load(main), path="unnamed")):
            yield str(main), "sniff says that it is this language"
        if main is not None and other.sniff(unnamed):
            yield (
                it.main.name,
                f"the sniff of {name} takes it for {language_of(name)}, which has to ask for more",
            )


# --- whole programs -----------------------------------------------------------------------------------------


def keeps_every_byte(it: VendorUnderTest) -> Iterator[Difference]:
    """A sample reads without an error, comes back with its bytes, and each of its lines is accounted for"""
    count = 0
    for path in handling.files_of(it.vendor, it.folder):
        count += 1
        source = load(path)
        program = it.vendor.read(source)
        if program.vendor != it.vendor.name:
            yield path.name, f"the program says that it is {program.vendor}"
        if program.to_bytes() != path.read_bytes():
            yield path.name, "its bytes changed"
        # A list of files is a program whose lines are those of all.
        yield from ((path.name, text) for text in _unaccounted(program, program.source))
        yield from ((path.name, d.render()) for d in program.diagnostics if d.is_error)
    if not count:
        yield str(it.folder), "there are no samples"
    kinds = set(it.program.line_kinds)
    if kinds & {LineKind.ERROR, LineKind.OPAQUE} or any(
        isinstance(s, Opaque) for s in it.program.statements()
    ):
        yield it.main.name, "some of its lines are not understood"
    if LineKind.STATEMENT not in kinds:
        yield it.main.name, "no line of it is a statement"


def _unaccounted(program: Program, source: Source) -> Iterator[str]:
    """What is wrong with how a program accounts for the lines of its text."""
    if len(program.line_kinds) != len(source.lines):
        yield f"{len(source.lines)} lines have {len(program.line_kinds)} kinds"
    if not set(program.line_kinds) <= _KINDS:
        yield f"kinds of lines that there are none of: {sorted(set(program.line_kinds) - _KINDS)}"
    last = len(source.lines)
    for statement in program.statements():
        if not 0 <= statement.line <= last:
            yield f"{type(statement).__name__} on line {statement.line} of {last}"
    for found in program.diagnostics:
        yield from _unsound(found, source)


def _unsound(found: Diagnostic, source: Source) -> Iterator[str]:
    """What is wrong with a diagnostic."""
    where = f"{found.code} on line {found.line}"
    if not _CODE.fullmatch(found.code) or not found.message or "\n" in found.message:
        yield f"{where}: its code or its message is none: {found.message!r}"
    if found.file not in ("", source.path):
        return  # of a file beside it
    text = source.line(found.line)
    if not 0 <= found.line <= max(len(source.lines), 1) or not 1 <= found.column <= len(text) + 2:
        yield f"{where}, column {found.column}: not in a text of {len(source.lines)} lines"
    if found.end_column < found.column:
        yield f"{where}: ends in column {found.end_column}, before it begins in {found.column}"


def is_the_handling_cell(it: VendorUnderTest) -> Iterator[Difference]:
    """The handling sample does what the handling cell does: places, tools, speeds, blends, signals, waits, branches"""
    errors = [d.render() for d in it.program.diagnostics if d.is_error]
    yield from ((it.main.name, text) for text in errors)
    joint = handling.joint_speeds_of(it.found)
    for parts in (handling.PARTS, 1, 3):
        program = handling.with_parts(it.program, parts)
        found = it.events(program)
        wanted = stopped_by_advance(handling.events(parts, joint), it.vendor)
        yield from ((f"{it.main.name} with {parts} parts", d) for d in differences(wanted, found))


def states_what_it_reads(it: VendorUnderTest) -> Iterator[Difference]:
    """The kinds of statements in `reads` are those that its samples and declared readings are read as"""
    found = {
        kind
        for path in handling.files_of(it.vendor, it.folder)
        for kind in _kinds(it.vendor.read(load(path)))
    }
    for path in readings.readings_of(it.folder):
        for _, program in readings.programs_of(it.vendor, readings.load_declared(path)):
            found |= _kinds(program)
    yield from ((kind, "is read, and `reads` does not name it") for kind in sorted(found - it.vendor.reads))
    missing = sorted(it.vendor.reads - found)
    yield from ((kind, f"is in `reads`, and no line in {it.folder} is read as one") for kind in missing)


def _kinds(program: Program) -> set[str]:
    declared = (*program.data, *(one for routine in program.routines for one in routine.data))
    return {kind_of(one) for one in (*program.statements(), *declared)}


def reads_as_declared(it: VendorUnderTest) -> Iterator[Difference]:
    """The programs of `readings` among the samples mean, line by line, what their author declared"""
    for path in readings.readings_of(it.folder):
        yield from readings.unlike(it.vendor, path)


def reads_damage_as_declared(it: VendorUnderTest) -> Iterator[Difference]:
    """A word left out, a number changed or a letter lost there means something else, or is told, as declared"""
    yield from _derived(it, ".damaged")


def refuses_as_declared(it: VendorUnderTest) -> Iterator[Difference]:
    """What a controller refuses to load of these programs, and of sound ones once they are damaged, is as declared"""
    yield from _derived(it, ".loaded")


def hands_on_as_declared(it: VendorUnderTest) -> Iterator[Difference]:
    """Other languages get the statements that are declared of these programs"""
    yield from _derived(it, ".called")


def tells_editors_as_declared(it: VendorUnderTest) -> Iterator[Difference]:
    """Editors are told the names, the layout, and the places of positions and speeds that are declared"""
    yield from _derived(it, ".edited")


def merges_as_declared(it: VendorUnderTest) -> Iterator[Difference]:
    """Merges of these programs, damaged on both sides, give the declared texts and conflicts"""
    yield from _derived(it, ".merged")


def _derived(it: VendorUnderTest, suffix: str) -> Iterator[Difference]:
    for path in readings.readings_of(it.folder):
        yield from derived_readings.unlike_derived(it.vendor, path, suffix)


def declares_every_word(it: VendorUnderTest) -> Iterator[Difference]:
    """Every keyword of the grammar stands in a program whose reading is declared"""
    texts = [path.read_text(encoding="utf-8") for path in readings.readings_of(it.folder)]
    for word in readings.unspoken(it.vendor, texts):
        yield word, f"no program in {it.folder / 'readings'} has it"


def names_each_line(it: VendorUnderTest) -> Iterator[Difference]:
    """Each event of the handling sample is on the line that says it"""
    kinds = it.program.line_kinds
    own = [e for e in it.found if kinds[e.line - 1 : e.line] == bytes([LineKind.STATEMENT])]
    if len(own) < len(it.found) // 2:
        yield it.main.name, f"only {len(own)} of {len(it.found)} events are on a line with a statement"
    text = it.source.line(it.pause)
    if "35" not in text:
        yield it.main.name, f"a wait of {_PAUSE} s on line {it.pause}, which says {text.strip()!r}"


def keeps_comments(it: VendorUnderTest) -> Iterator[Difference]:
    """A comment on a line of its own is a comment of the program, with its text"""
    said = {one.line: one.text for one in it.program.statements() if isinstance(one, Comment)}
    prefix = it.vendor.comment_prefix
    for number, line in enumerate(it.source.lines, 1):
        text = line.strip()
        if it.program.line_kinds[number - 1] == LineKind.COMMENT and number in said:
            body = text.removeprefix(prefix.strip()).removesuffix(it.vendor.comment_suffix).strip()
            if said[number].strip() not in text or not body:
                yield line, f"the comment {said[number]!r}"
    if not said:
        yield it.main.name, "none of its comments is one of the program"


# --- texts in other shapes ----------------------------------------------------------------------------------


def takes_any_line_end(it: VendorUnderTest) -> Iterator[Difference]:
    """Line ends, and whether the last line has one, do not change what a program does"""
    plain = b"\n".join(re.split(rb"\r\n|\n|\r", it.source.raw)).rstrip(b"\n")
    for name, raw in (
        ("LF", plain + b"\n"),
        ("CRLF", plain.replace(b"\n", b"\r\n") + b"\r\n"),
        ("CR", plain.replace(b"\n", b"\r")),
        ("no end of the last line", plain.replace(b"\n", b"\r\n")),
    ):
        program = it.read(raw)
        if program.to_bytes() != raw:
            yield name, "its bytes changed"
        yield from ((name, text) for text in differences(it.found, it.events(program)))


def takes_its_comments(it: VendorUnderTest) -> Iterator[Difference]:
    """A comment in the form that the vendor states, on a line of its own or behind a statement, changes nothing"""
    line = it.pause
    text = it.source.line(line)
    above = f"{it.vendor.comment_prefix}parts 9 8 7{it.vendor.comment_suffix}"
    variants = {"a comment above": [above, text]}
    if not it.vendor.comment_suffix:
        # Where a comment is closed, a line has no room for one behind the statement.
        variants["a comment behind"] = [f"{text.rstrip()}{it.vendor.trailing_comment_prefix}parts 9 8 7"]
    for name, rows in variants.items():
        source = it.source.edited({line: rows})
        program = it.vendor.read(source)
        yield from ((f"{name}: {rows[0]}", d.render()) for d in program.diagnostics if d.is_error)
        yield from ((f"{name}: {rows[0]}", d) for d in differences(it.found, it.events(program)))
        said = [str(getattr(s, "text", "")) + str(getattr(s, "comment", "")) for s in program.statements()]
        if not any("parts 9 8 7" in one for one in said):
            yield f"{name}: {rows[0]}", "the comment is not in the program"
    if it.vendor.comment_of(above.encode() + b"\r\n") != b"parts 9 8 7":
        yield above, f"comment_of says {it.vendor.comment_of(above.encode())!r}"
    if it.vendor.comment_of(text.encode("utf-8", "surrogateescape")) is not None:
        yield text, "comment_of says that a statement is a comment"


def hears_every_number(it: VendorUnderTest) -> Iterator[Difference]:
    """Another number on a line that moves, waits or switches is another event, or a finding"""
    tried = 0
    for line in sorted({e.line for e in it.found if e.kind in ("wait", "linear", "joint", "arc")}):
        if it.program.line_kinds[line - 1 : line] != bytes([LineKind.STATEMENT]):
            continue
        text = it.source.line(line)
        for number in _DECIMAL.finditer(text):
            value = number.group()
            other = f"{float(value) * 0.5:.{len(value.partition('.')[2])}f}"
            if other == value or tried >= 6:
                continue
            tried += 1
            edited = text[: number.start()] + other + text[number.end() :]
            program = it.vendor.read(it.source.edited({line: [edited]}))
            new = len(program.diagnostics) > len(it.program.diagnostics)
            same = (program.routines, program.data) == (it.program.routines, it.program.data)
            if not new and same:
                yield edited, f"the same as with {value}"


# --- bad texts ----------------------------------------------------------------------------------------------


def _bad_texts(raw: bytes) -> Iterator[tuple[str, bytes, str | None]]:
    """(name, bytes, encoding): what a reader must stand."""
    dice = Random(20)
    size = len(raw)
    yield "nothing", b"", None
    yield "one line end", b"\r\n", None
    for share in (0.02, 0.11, 0.23, 0.37, 0.52, 0.64, 0.78, 0.91, 0.99):
        yield f"the first {share:.0%}", raw[: int(size * share)], None
    yield "the last half", raw[size // 2 :], None
    for number in range(14):
        damaged = bytearray(raw)
        for _ in range(dice.randrange(1, 10)):
            at = dice.randrange(len(damaged))
            damaged[at : at + dice.randrange(4)] = dice.randbytes(dice.randrange(4))
        yield f"damage {number}", bytes(damaged), None
    yield "random bytes", dice.randbytes(3000), None
    yield "zeros", b"\0" * 500, None
    yield "zeros between", raw.replace(b" ", b"\0"), None
    text = raw.decode("utf-8", "replace")
    yield "UTF-16", text.encode("utf-16"), None
    yield "UTF-8 with a mark", b"\xef\xbb\xbf" + raw.removeprefix(b"\xef\xbb\xbf"), None
    yield "Shift-JIS", raw.replace(b" the ", "溶接".encode("shift_jis")), "shift_jis"
    yield "read as UTF-16", raw, "utf-16-le"
    yield "lines twice", b"".join(one * 2 for one in raw.splitlines(keepends=True)), None
    yield "lines backwards", b"\r\n".join(raw.splitlines()[::-1]), None
    yield "every third line", b"\n".join(raw.splitlines()[::3]), None
    lines = raw.splitlines()
    middle = len(lines) // 2
    for name, row in (
        ("a line of 60,000 letters", b"A" * 60_000),
        ("4,000 open brackets", b"x=" + b"(" * 4000 + b"1" + b")" * 4000),
        ("a number of 5,000 digits", b"x = " + b"9" * 5000),
        ("a number beyond all", b"x = 1E999"),
        ("a quote that nothing closes", b'x = "abc'),
        ("nonsense", b"?? 12 <> &&& ;; ||| end end"),
    ):
        yield name, b"\r\n".join([*lines[:middle], row, *lines[middle:]]), None


def stands_bad_text(it: VendorUnderTest) -> Iterator[Difference]:
    """Whatever the bytes: a reader does not raise, keeps them, accounts for each line, and its findings are sound"""
    start = time.process_time()
    for name, raw, encoding in _bad_texts(it.source.raw):
        source = decode(raw, it.source.path, encoding)
        try:
            program = it.vendor.read(source)
        except Exception as problem:
            yield name, f"raised {type(problem).__name__}: {str(problem)[:300]}"
            continue
        if program.to_bytes() != raw:
            yield name, "its bytes changed"
        yield from ((name, text) for text in _unaccounted(program, source))
    used = time.process_time() - start
    if used > _SECONDS:
        yield "all bad texts", f"{used:.1f} s of CPU, at most {_SECONDS:g} s are fine"


def says_what_is_wrong(it: VendorUnderTest) -> Iterator[Difference]:
    """A line that is no statement of the language has a finding on it, and the lines around it are still read"""
    at = it.pause
    text = it.source.line(at)
    for wrong in ("?? 12 <> &&& !! 34", text.replace("35", "3x5"), text[: len(text) // 2] + " )("):
        program = it.vendor.read(it.source.edited({at: [wrong]}))
        told = [d for d in program.diagnostics if abs(d.line - at) <= 1]
        kept = program.line_kinds[at - 1 : at] in (bytes([LineKind.OPAQUE]), bytes([LineKind.ERROR]))
        if not told and not kept and len(program.diagnostics) <= len(it.program.diagnostics):
            yield wrong, "nothing is said about it"
        before = sum(1 for _ in it.program.statements())
        after = sum(1 for _ in program.statements())
        if after < before * 0.6:
            yield wrong, f"of {before} statements only {after} are left"


# --- annotations --------------------------------------------------------------------------------------------


def carries_annotations(it: VendorUnderTest) -> Iterator[Difference]:
    """Annotations are comments of the language: nothing else changes, and without them the bytes are as they were"""
    if f"{it.vendor.name}_annotation" not in resources.names("templates", ".j2"):
        return  # a language may come without the template that annotates it
    raw = re.sub(rb"\r\n|\n|\r", b"\n", it.source.raw)
    for name, data in (
        ("as it is", it.source.raw),
        ("with LF", raw),
        ("with CRLF", raw.replace(b"\n", b"\r\n")),
    ):
        program = it.read(data)
        timing = time_plan(run(program, robot_of(), folder=it.main.parent))
        made = annotate(program, timing)
        if made.written < 5:
            yield name, f"only {made.written} annotations are written"
        back = remove(made.source, it.vendor.name)
        if back.source.raw != data or back.removed != made.written:
            yield name, f"removing {back.removed} of {made.written} annotations does not give the bytes back"
        again = it.vendor.read(made.source)
        yield from ((name, d.render()) for d in again.diagnostics if d.is_error)
        if name != "as it is":
            continue
        yield from ((name, text) for text in differences(it.found, it.events(again)))
        twice = annotate(again, time_plan(run(again, robot_of(), folder=it.main.parent)))
        if twice.source.raw != made.source.raw:
            yield name, "annotating twice is not annotating once"


_NUMBER: Final = re.compile(r"(?<![\w.$#:])\d+\.\d+(?![\w.])")


def _with_another(text: str, at: int, share: float) -> str:
    """The line with another decimal number in the place of one of its own."""
    number = list(_NUMBER.finditer(text))[at]
    decimals = len(number[0].partition(".")[2])
    return f"{text[: number.start()]}{float(number[0]) * share + 1.0:.{decimals}f}{text[number.end() :]}"


def merges_what_both_changed(it: VendorUnderTest) -> Iterator[Difference]:
    """`olp merge` joins what two sides changed apart, and never takes one side's change of what both changed"""
    source, name = it.source, it.vendor.name
    own = (at for at, kind in enumerate(it.program.line_kinds, 1) if kind == LineKind.STATEMENT)
    lines = [at for at in own if _NUMBER.search(source.line(at))][:6]
    if len(lines) < 2:
        yield (
            it.main.name,
            "too few of its statements have a decimal number, such as 250.0, that a side can change",
        )
        return

    def text(rows: dict[int, list[str]]) -> bytes:
        return source.edited(rows).raw

    for one, other in zip(lines, lines[1:] + lines[:1], strict=True):
        first, second, third = (
            {at: [_with_another(source.line(at), 0, share)]}
            for at, share in ((one, 0.5), (other, 0.5), (one, 2.0))
        )
        remark = {
            other: [f"{it.vendor.comment_prefix}so it is{it.vendor.comment_suffix}", source.line(other)]
        }
        joined = {
            "a change each": (first, second, {**first, **second}),
            "the same": (first, first, first),
            "ours": (first, {}, first),
            "theirs": ({}, first, first),
        }
        if not it.vendor.numbered_lines:
            joined["a comment and a change"] = (remark, first, {**remark, **first})
        for what, (ours, theirs, both) in joined.items():
            found = merge_bytes(name, source.raw, text(ours), text(theirs))
            changed = f"{what}: {source.line(one).strip()} and {source.line(other).strip()}"
            if found.hunks:
                yield changed, "a conflict"
            elif found.to_bytes() != text(both):
                yield changed, unlike_text(text(both), found.to_bytes())
        found = merge_bytes(name, source.raw, text(first), text(third))
        lost = [
            row
            for rows in (first, third)
            for row in rows[one]
            if row.strip().encode() not in found.to_bytes()
        ]
        if not found.hunks or lost:
            yield f"two changes of {source.line(one).strip()}", "no conflict with both in it"
        if len(_NUMBER.findall(source.line(one))) > 1:
            left, right = (_with_another(source.line(one), at, 0.5) for at in (0, 1))
            found = merge_bytes(name, source.raw, text({one: [left]}), text({one: [right]}))
            if not found.hunks and text({one: [_with_another(left, 1, 0.5)]}) != found.to_bytes():
                yield f"two numbers of {source.line(one).strip()}", "one of the changes is lost"


def is_written_in_other_languages(it: VendorUnderTest) -> Iterator[Difference]:
    """Its handling program does the same in each language that olp writes, and when translated back"""
    for name in writable():
        if name != it.vendor.name:
            yield from translated(WriterUnderTest(find_vendor(name), None), it.vendor, sample_of(it))


def reads_what_is_written(it: VendorUnderTest) -> Iterator[Difference]:
    """Of a language that olp writes, a written program is read as what it was written from, whatever its statements"""
    if it.vendor.name in writable():
        writer = WriterUnderTest(it.vendor, it.folder)
        yield from does_what_the_program_does(writer)
        yield from writes_each_kind_of_statement(writer)


PROMISES: Final[tuple[Promise[VendorUnderTest], ...]] = (
    states_its_conventions,
    is_the_handling_cell,
    states_what_it_reads,
    reads_as_declared,
    reads_damage_as_declared,
    refuses_as_declared,
    hands_on_as_declared,
    tells_editors_as_declared,
    merges_as_declared,
    declares_every_word,
    names_each_line,
    keeps_every_byte,
    keeps_comments,
    knows_its_own_text,
    takes_any_line_end,
    takes_its_comments,
    hears_every_number,
    says_what_is_wrong,
    carries_annotations,
    merges_what_both_changed,
    stands_bad_text,
    reads_what_is_written,
    is_written_in_other_languages,
)
