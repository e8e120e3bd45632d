"""Every member that the registries find keeps the promises of its kind, and a member that breaks one is caught."""

from __future__ import annotations

import functools
import re
import shutil
from collections.abc import Iterator
from dataclasses import replace
from importlib import import_module
from pathlib import Path as FilePath

import faults
import pytest
from contract_faults import KINDS, meaning
from contract_faults.code import EQUIVALENT, source_of

from olp import cli
from olp.contracts import (
    ContractError,
    check_command,
    check_estimator,
    check_host,
    check_model,
    check_report,
    check_robot,
    check_term,
    check_vendor,
    check_writer,
    derived_readings,
    vendors,
    writers,
)
from olp.contracts.__main__ import main as contracts_command
from olp.contracts.derived_readings import unlike_derived
from olp.contracts.events import OracleEvent, differences
from olp.contracts.handling import samples_folder
from olp.contracts.promises import hold
from olp.contracts.readings import readings_of, unlike
from olp.contracts.writers import WriterUnderTest, other_texts
from olp.core.diagnostic import error
from olp.core.source import decode
from olp.identification.signature.estimator import estimator_names, load_estimator
from olp.ir.program import Blend, BlendKind, Dwell, Message, Move, Path
from olp.languages.limits import limits_of, writable
from olp.languages.loading import Loading
from olp.languages.vendor import Vendor, find_vendor, part_of, vendor_names
from olp.reports.formats import report_names
from olp.robots import robot as robot_module
from olp.robots.robot import robot_names
from olp.timing.motion import load_model, model_names
from olp.timing.physics import load_term, term_names
from olp.transpile.convert import Converted
from olp.transpile.shared_variables import _Shared

HOSTS = FilePath(__file__).parent.parent / "hosts"
MAKERS = sorted({name.partition("/")[0] for name in robot_names()})


# Promises of a vendor that the contracts of the writers hold for every pair of languages; once in a session is enough.
HELD_BY_WRITERS = (vendors.reads_what_is_written, vendors.is_written_in_other_languages)


@pytest.mark.parametrize("name", vendor_names())
def test_a_vendor_keeps_its_contract(name: str) -> None:
    member = vendors.VendorUnderTest(find_vendor(name), None)
    assert not member.has_errors
    hold(f"vendor {name}", member, [one for one in vendors.PROMISES if one not in HELD_BY_WRITERS])


def test_the_writers_hold_what_is_left_out_of_the_vendors_tests() -> None:
    assert set(HELD_BY_WRITERS) < set(vendors.PROMISES)
    held = {writers.does_what_the_program_does, writers.writes_each_kind_of_statement}
    assert held | {writers.translates_there_and_back} < set(writers.PROMISES)
    # The writers translate the handling program of each vendor that has one.
    assert all(writers.handling_sample(name) is not None for name in vendor_names())


@pytest.mark.parametrize("name", writable())
def test_a_writer_keeps_its_contract(name: str) -> None:
    check_writer(find_vendor(name))


@pytest.mark.parametrize("name", term_names())
def test_a_term_keeps_its_contract(name: str) -> None:
    check_term(load_term(name))


@pytest.mark.parametrize("name", estimator_names())
def test_an_estimator_keeps_its_contract(name: str) -> None:
    check_estimator(load_estimator(name))


def test_an_exception_within_a_library_names_the_line_that_called_it() -> None:
    def raises_in_a_library(subject: object) -> Iterator[tuple[str, str]]:
        """A promise"""
        yield "", str(replace(subject))

    with pytest.raises(ContractError, match=r"dataclasses\.py:\d+, called from .*test_contracts\.py:\d+"):
        hold("a member", object(), [raises_in_a_library])


def test_what_one_mistake_raises_in_many_promises_is_told_in_full_once() -> None:
    def first_promise(subject: object) -> Iterator[tuple[str, str]]:
        """One"""
        yield "", _fails()

    def second_promise(subject: object) -> Iterator[tuple[str, str]]:
        """Two"""
        yield "", _fails()

    with pytest.raises(ContractError) as caught:
        hold("a member", object(), [first_promise, second_promise])
    first, second = (one.differs for one in caught.value.broken)
    assert "raised ValueError" in first
    assert second == "raised what first_promise tells"


def _fails() -> str:
    raise ValueError("once")


def test_a_vendor_that_states_other_statements_than_it_reads_breaks_its_contract(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    vendor = find_vendor("pdl2")
    monkeypatch.setattr(type(vendor), "reads", vendor.reads - {"Dwell"} | {"Synchronise"})
    with pytest.raises(ContractError) as caught:
        check_vendor(vendor, only="states_what_it_reads")
    assert [(one.given, one.differs.split(",")[0]) for one in caught.value.broken] == [
        ("Dwell", "is read"),
        ("Synchronise", "is in `reads`"),
    ]


@pytest.mark.parametrize("name", model_names())
def test_a_motion_model_keeps_its_contract(name: str) -> None:
    check_model(load_model(name))


@pytest.mark.parametrize("maker", MAKERS)
def test_the_robots_of_a_maker_keep_their_contract(maker: str) -> None:
    broken = []
    for name in robot_names():
        if name.startswith(f"{maker}/"):
            try:
                check_robot(name)
            except ContractError as problem:
                broken.append(str(problem))
    assert not broken, "\n".join(broken)


@pytest.mark.parametrize("name", cli.names())
def test_a_command_keeps_its_contract(name: str) -> None:
    check_command(name, options=1)


@pytest.mark.parametrize("name", report_names())
def test_a_report_format_keeps_its_contract(name: str) -> None:
    check_report(name)


@pytest.mark.parametrize("name", sorted(path.name for path in HOSTS.iterdir() if path.is_dir()))
def test_a_host_keeps_its_contract(name: str) -> None:
    check_host(HOSTS / name)


def test_a_broken_reader_is_told_by_promise_input_and_difference(monkeypatch: pytest.MonkeyPatch) -> None:
    vendor = find_vendor(vendor_names()[0])
    read = type(vendor).read

    def straight(self, source):
        program = read(self, source)
        routines = [
            replace(r, body=tuple(replace(s, path=Path.LINEAR) if isinstance(s, Move) else s for s in r.body))
            for r in program.routines
        ]
        return replace(program, routines=tuple(routines))

    monkeypatch.setattr(type(vendor), "read", straight)
    with pytest.raises(ContractError) as caught:
        check_vendor(vendor)
    broken = {one.promise for one in caught.value.broken}
    assert any("does what the handling cell does" in promise for promise in broken)
    assert "joint move is wanted and linear move found" in str(caught.value)
    with pytest.raises(ContractError) as caught:
        check_vendor(vendor, first=True)
    assert len(caught.value.broken) == 1
    (only,) = caught.value.broken
    assert f"    promise  {only.name}\n" in str(only)
    with pytest.raises(ContractError) as again:
        check_vendor(vendor, only=only.name)
    assert {one.name for one in again.value.broken} == {only.name}
    check_vendor(vendor, only="states_its_conventions")
    with pytest.raises(ValueError, match=r"has\n.*\nis_the_handling_cell: The handling"):
        check_vendor(vendor, only="no_such_promise")
    with pytest.raises(ValueError, match=r"\nwrites_as_declared: "):
        check_writer(vendor, only="no_such_promise")


def test_a_line_that_means_something_else_than_declared_is_told_with_both_meanings(
    tmp_path: FilePath,
) -> None:
    vendor = find_vendor(vendor_names()[0])
    declared = next(path for path in readings_of(samples_folder(vendor)) if "IF n>1" in path.read_text())
    text = declared.read_text(encoding="utf-8")
    assert not list(unlike(vendor, declared))
    changed = tmp_path / declared.name
    changed.write_text(text.replace("If condition=(n > 1)", "If condition=(n > 2)", 1), encoding="utf-8")
    ((given, differs),) = unlike(vendor, changed)
    assert given.endswith("IF n>1 THEN")
    assert differs == "declared: If condition=(n > 2); read: If condition=(n > 1)"


def test_a_reader_that_takes_no_notice_of_a_word_breaks_its_contract(
    tmp_path: FilePath, monkeypatch: pytest.MonkeyPatch
) -> None:
    vendor = find_vendor("pdl2")
    declared = samples_folder(vendor) / "readings" / "pdl2.reading"
    assert not list(unlike_derived(vendor, declared, ".damaged"))
    read = type(vendor).read

    def careless(self, source):
        lines = [f"{line} p" if line.endswith("MOVE LINEAR TO") else line for line in source.lines]
        return read(self, decode("\n".join([*lines, ""]).encode(), source.path))

    monkeypatch.setattr(type(vendor), "read", careless)
    told = [differs for _, differs in unlike_derived(vendor, declared, ".damaged")]
    assert any("E     MOVE LINEAR TO / !error P590" in one for one in told)


@pytest.mark.parametrize("side", [2, 3])
def test_a_merge_that_takes_one_side_breaks_the_contract(side: int, monkeypatch: pytest.MonkeyPatch) -> None:
    vendor = find_vendor("as")
    whole = vendors.merge_bytes
    monkeypatch.setattr(vendors, "merge_bytes", lambda *texts: whole(*texts[:2], texts[side], texts[side]))
    with pytest.raises(ContractError, match="never takes one side's change") as caught:
        check_vendor(vendor, only="merges_what_both_changed")
    assert "no conflict with both in it" in str(caught.value)


def test_a_rule_of_loading_that_is_lost_breaks_the_contract(monkeypatch: pytest.MonkeyPatch) -> None:
    vendor = find_vendor("as")
    declared = samples_folder(vendor) / "readings" / "load.reading"
    assert not list(unlike_derived(vendor, declared, ".loaded"))
    lost = Loading(part_of("as", "load").controllers, lambda source, cell: [])
    monkeypatch.setattr(import_module("olp.languages.vendors.as.load"), "LOAD", lost)
    told = [differs for _, differs in unlike_derived(vendor, declared, ".loaded")]
    assert "!error K102 10-20" in told[0]


@pytest.mark.parametrize(
    ("suffix", "of", "careless"),
    [
        (".called", "spelled_out", lambda self, body, find: body),
        (".called", "without_editor_comments", lambda self, body: body),
        (".called", "as_called", lambda self, program: program),
    ],
)
def test_a_vendor_that_hands_on_what_others_do_not_have_breaks_its_contract(
    suffix: str, of: str, careless, monkeypatch: pytest.MonkeyPatch
) -> None:
    vendor = find_vendor("krl")
    paths = readings_of(samples_folder(vendor))
    assert not [told for path in paths for told in unlike_derived(vendor, path, suffix)]
    monkeypatch.setattr(type(vendor), of, careless)
    assert [told for path in paths for told in unlike_derived(vendor, path, suffix)]


@pytest.mark.parametrize(
    ("language", "was", "becomes"),
    [
        ("rapid", rb"(?m)^(.*VAR num .*\n)", rb"\1\1"),
        ("krl", rb"\$OUT\[", rb"$IN["),
    ],
)
def test_a_writer_whose_text_no_controller_loads_breaks_its_contract(
    language: str, was: bytes, becomes: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = writers.convert

    def careless(*given, **how):
        made = whole(*given, **how)
        return replace(made, files={n: re.sub(was, becomes, data) for n, data in made.files.items()})

    monkeypatch.setattr(writers, "convert", careless)
    monkeypatch.setattr(writers, "vendor_names", lambda: [])  # the contract program shows it
    under = WriterUnderTest(find_vendor(language), None)
    told = [given for given, _ in writers.writes_what_controllers_load(under)]
    assert any(given.startswith("contract_program") for given in told)


def test_a_name_that_editors_are_not_told_breaks_the_contract(monkeypatch: pytest.MonkeyPatch) -> None:
    vendor = find_vendor("tp")
    declared = samples_folder(vendor) / "readings" / "moves.reading"
    assert not list(unlike_derived(vendor, declared, ".edited"))
    words = type(part_of("tp", "tokens"))
    whole = words.words
    monkeypatch.setattr(words, "words", lambda self, line: list(whole(self, line))[1:])
    assert any("variable" in differs for _, differs in unlike_derived(vendor, declared, ".edited"))


def test_a_position_whose_place_is_another_breaks_the_contract(monkeypatch: pytest.MonkeyPatch) -> None:
    vendor = find_vendor("inform")
    declared = samples_folder(vendor) / "readings" / "moves.reading"
    assert not list(unlike_derived(vendor, declared, ".edited"))
    written = import_module("olp.languages.vendors.inform.written")
    whole = written.points
    monkeypatch.setattr(
        written, "points", lambda program: (replace(p, numbers=p.numbers[1:]) for p in whole(program))
    )
    assert any("position" in differs for _, differs in unlike_derived(vendor, declared, ".edited"))


def test_a_merge_that_swaps_its_sides_is_not_the_declared_one(monkeypatch: pytest.MonkeyPatch) -> None:
    vendor = find_vendor("val3")
    declared = samples_folder(vendor) / "readings" / "val3.reading"
    assert not list(unlike_derived(vendor, declared, ".merged"))
    whole = derived_readings.merge_bytes
    monkeypatch.setattr(derived_readings, "merge_bytes", lambda name, base, a, b: whole(name, base, b, a))
    assert any("ours" in differs for _, differs in unlike_derived(vendor, declared, ".merged"))


@pytest.fixture
def contract_written(tmp_path: FilePath, monkeypatch: pytest.MonkeyPatch) -> FilePath:
    """The declared text of the contract program in a folder of samples of its own; other texts are left out."""
    made = writers._texts
    monkeypatch.setattr(writers, "_texts", lambda it: [next(made(it))])
    path = tmp_path / "readings" / "contract.written"
    path.parent.mkdir()
    shutil.copy(samples_folder(find_vendor(writable()[0])) / "readings" / path.name, path)
    return path


def test_a_line_that_is_written_otherwise_than_declared_is_told_with_both_texts(
    contract_written: FilePath, tmp_path: FilePath
) -> None:
    vendor = find_vendor(writable()[0])
    assert not list(other_texts(WriterUnderTest(vendor, tmp_path)))
    rows = contract_written.read_text(encoding="utf-8").splitlines()
    at = next(at for at, row in enumerate(rows) if "hands over" in row)
    contract_written.write_text("\n".join([*rows[:at], "other", *rows[at + 1 :]]), encoding="utf-8")
    ((given, differs),) = other_texts(WriterUnderTest(vendor, tmp_path))
    assert given.endswith(f"line {at}")
    assert differs == f"declared: other; written: {rows[at]}"


def test_a_receipt_that_says_something_else_than_declared_is_told_with_both_texts(
    contract_written: FilePath, tmp_path: FilePath
) -> None:
    vendor = find_vendor(writable()[0])
    text = contract_written.read_text(encoding="utf-8")
    said = text.partition("=== program: receipt\n")[2].partition("\n")[0]
    assert said
    contract_written.write_text(text.replace(said, "other"), encoding="utf-8")
    ((_, differs),) = other_texts(WriterUnderTest(vendor, tmp_path))
    assert differs == f"declared: other; written: {said}"


def test_a_writer_that_changed_since_it_was_checked_is_asked_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(writers, "vendor_names", lambda: ["pdl2", "krl"])
    vendor = find_vendor("krl")
    assert all(isinstance(made, Converted) for *_, made in WriterUnderTest(vendor, None).foreign)

    def write(program, *rest, **more):
        return {}, [error("X002", "nothing", (1, 1, 1))]

    monkeypatch.setattr(import_module(f"{type(vendor).__module__}.writer"), "write", write)
    assert not any(isinstance(made, Converted) for *_, made in WriterUnderTest(vendor, None).foreign)


@pytest.mark.parametrize(
    ("was", "becomes", "says"),
    [
        ("signs = [-1, 1, -1, 1, -1, 1]", "signs = [-1, 1, 1, 1, -1, 1]", "signs"),
        ("zero_deg = [0, 90, 90, 0, 0, 180]", "zero_deg = [0, 90, 0, 0, 0, 180]", "zero_deg"),
        ("upper_deg =  45", "upper_deg = 0.785398163", "a range that ends at"),
        ("upper_deg =  45", "upper_deg = 450", "from the standard stance"),
        ("a1_mm = 25", "a1_mm = 0.025", "a length of 0.025 mm"),
        ("origin_below_mm = 400", "origin_below_mm = -400", "origin_below_mm"),
    ],
)
def test_a_robot_that_counts_or_measures_otherwise_breaks_its_contract(
    was: str, becomes: str, says: str, tmp_path: FilePath
) -> None:
    text = (FilePath(robot_module.__file__).parent / "kuka" / "kr10-r1100-2.toml").read_text(encoding="utf-8")
    assert was in text
    (tmp_path / "robot.toml").write_text(text.replace(was, becomes), encoding="utf-8")
    with pytest.raises(ContractError, match=says):
        check_robot(tmp_path / "robot.toml")


def test_an_arm_with_a_link_on_the_other_side_than_its_makers_others_breaks_its_contract(
    tmp_path: FilePath,
) -> None:
    text = (FilePath(robot_module.__file__).parent / "universal-robots" / "ur5.toml").read_text(
        encoding="utf-8"
    )
    (tmp_path / "robot.toml").write_text(text.replace("-109.15", "109.15"), encoding="utf-8")
    with pytest.raises(ContractError, match="as no other arm of Universal Robots"):
        check_robot(tmp_path / "robot.toml")


def test_faults_are_planted_in_the_source_of_every_member_that_has_one() -> None:
    for kind in ("vendor", "writer", "term", "model", "estimator", "report"):
        for member in KINDS[kind].members():
            modules = KINDS[kind].modules(member)
            assert modules, (kind, member)
            assert all(FilePath(source_of(name)).exists() for name in modules), (kind, member)


def test_each_fault_that_is_planted_fits_the_code():
    rows = [(part, fault) for part, it in faults.PARTS.items() for fault in it.faults]
    assert not [found for part, fault in rows if (found := faults.misfit(part, fault, faults.ROOT))]


def test_mutants_that_are_no_faults_stand_in_the_code_as_they_are_listed() -> None:
    for file, text, _ in EQUIVALENT:
        (path,) = FilePath(cli.__file__).parents[1].rglob(file)
        assert [row.strip() for row in path.read_text(encoding="utf-8").splitlines()].count(text) == 1, (
            file,
            text,
        )


@pytest.mark.parametrize("name", writable())
def test_a_writer_that_refuses_what_its_limits_do_not_declare_breaks_its_contract(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A message is in no contract program, so that nothing else notices."""
    vendor = find_vendor(name)
    _refusing(vendor, Message, monkeypatch)
    told = [differs for _, differs in writers.writes_each_kind_of_statement(WriterUnderTest(vendor, None))]
    assert any("limits names nothing of it: not this" in differs for differs in told)


def _refusing(vendor: Vendor, kind: type, monkeypatch: pytest.MonkeyPatch) -> None:
    """The vendor's writer refuses this kind of statement from here on."""
    module = import_module(f"{type(vendor).__module__}.writer")
    whole = module.write

    @functools.wraps(whole)
    def write(program, *rest, **more):
        values, problems = whole(program, *rest, **more)
        refused = [s for s in program.statements() if isinstance(s, kind)]
        lines = [(s.line, program.source.line(s.line)) for s in refused]
        return values, [*problems, *(error("X002", "not this", (n, 1, 1), source_line=t) for n, t in lines)]

    monkeypatch.setattr(module, "write", write)


def test_a_vendor_is_told_what_other_languages_cannot_say_of_its_program_and_what_becomes_a_comment(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A new language finds this in its own suite, not in those of the others."""
    _refusing(find_vendor("urscript"), Dwell, monkeypatch)
    told = _told(find_vendor("as"), "is_written_in_other_languages", "as to urscript")
    assert told
    assert all("not this (line" in one and "TWAIT" in one for one in told)
    monkeypatch.undo()
    _refusing(find_vendor("rapid"), Dwell, monkeypatch)
    told = _told(find_vendor("rapid"), "is_written_in_other_languages", "rapid to krl and back")
    assert any("is a comment in " in one for one in told)


def _told(vendor: Vendor, promise: str, given: str) -> list[str]:
    """What the vendor's suite tells of one promise and input."""
    with pytest.raises(ContractError) as caught:
        check_vendor(vendor, only=promise)
    return [one.differs for one in caught.value.broken if one.given == given]


def test_a_vendor_is_told_of_words_that_nothing_finds_and_of_a_sniff_that_takes_its_text(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    vendor = find_vendor("krl")
    monkeypatch.setattr(
        type(vendor), "conventions", replace(vendor.conventions, silent_processes={"CONTINUE": "CONTINUE"})
    )
    told = _told(vendor, "states_its_conventions", "conventions.silent_processes")
    assert told == ["'CONTINUE' is looked for as 'continue'"]
    monkeypatch.setattr(type(find_vendor("pdl2")), "sniff", lambda self, source: True)
    (told,) = _told(vendor, "knows_its_own_text", "handling.src")
    assert "the sniff of pdl2 takes it for PDL2" in told


def test_a_sample_without_decimal_numbers_is_told_that_merges_cannot_be_tried(tmp_path: FilePath) -> None:
    vendor = find_vendor("pdl2")
    main = samples_folder(vendor) / "handling.pdl"
    text = re.sub(r"(\d+)\.(\d+)", r"\1\2", main.read_text(encoding="utf-8"))
    (tmp_path / main.name).write_text(text, encoding="utf-8")
    with pytest.raises(ContractError, match="too few of its statements have a decimal number"):
        check_vendor(vendor, samples=tmp_path, only="merges_what_both_changed")


def test_the_command_of_contracts_runs_a_promise_of_either_suite_and_lists_all(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert contracts_command(["krl", "is_found"]) == contracts_command(["krl", "knows_its_own_text"]) == 0
    assert not capsys.readouterr().out
    assert contracts_command(["krl", "?"]) == contracts_command(["nobody"]) == 2
    listed = capsys.readouterr().out
    assert "\nkeeps_every_byte: A sample reads" in listed
    assert "\nis_found: A language with a writer" in listed
    assert "known vendors: as" in listed
    monkeypatch.setattr(type(find_vendor("krl")), "sniff", lambda self, source: False)
    assert contracts_command(["krl", "knows_its_own_text"]) == 1
    assert "sniff says that it is another language" in capsys.readouterr().out


def test_a_sample_with_errors_is_told_by_one_promise(tmp_path: FilePath) -> None:
    vendor = find_vendor("pdl2")
    main = samples_folder(vendor) / "handling.pdl"
    text = main.read_text(encoding="utf-8").replace("BEGIN\n", "BEGIN\n  DELAY\n", 1)
    (tmp_path / main.name).write_text(text, encoding="utf-8")
    with pytest.raises(ContractError) as caught:
        check_vendor(vendor, samples=tmp_path)
    assert {one.name for one in caught.value.broken} == {"keeps_every_byte"}


def test_a_language_that_only_says_whether_a_corner_is_rounded_is_written_in_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    vendor = find_vendor("as")
    read = type(vendor).read

    def rounded(s):
        sized = isinstance(s, Move) and s.blend and s.blend.value and s.blend.value.literal
        return replace(s, blend=Blend(BlendKind.CONTINUOUS)) if sized else s

    def without_sizes(self, source):
        program = read(self, source)
        routines = [replace(r, body=tuple(map(rounded, r.body))) for r in program.routines]
        return replace(program, routines=tuple(routines))

    monkeypatch.setattr(type(vendor), "read", without_sizes)
    check_vendor(vendor, only="is_written_in_other_languages")


def test_texts_that_differ_are_told_by_their_first_line() -> None:
    told = writers.unlike_text(b"one\r\ntwo\r\n", b"one\r\nthree\r\n")
    assert told == "another text, line 2: 'two' is wanted, and there is 'three'"
    assert "there is no line" in writers.unlike_text(b"one\ntwo\n", b"one\n")


@pytest.mark.parametrize("name", ["krl", "tp"])
def test_a_writer_that_takes_an_input_for_an_output_breaks_its_contract(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = import_module(f"{type(find_vendor(name)).__module__}.writer")
    writer = next(one for key, one in vars(module).items() if key.lower() == f"{name}writer")
    monkeypatch.setattr(writer, "signals", {**writer.signals, "in": writer.signals["out"]})
    found = list(writers.keeps_inputs_and_outputs_apart(WriterUnderTest(find_vendor(name), None)))
    assert any("input 3 on is wanted and own output 3 on found" in differs for _, differs in found)


def test_a_signal_whose_name_has_another_number_is_told() -> None:
    def output(signal: int | str) -> OracleEvent:
        return OracleEvent("output", signal=signal, on=True)

    assert list(differences([output(3)], [output("do3")])) == []
    assert list(differences([output(3)], [output("doGrip")])) == []
    (told,) = differences([output(3)], [output("do4")])
    assert told.endswith("signal 3 is wanted and do4 found")


@pytest.mark.parametrize("name", writable())
def test_a_writer_that_makes_one_of_two_routines_own_variables_breaks_its_contract(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    vendor = find_vendor(name)
    assert not list(writers.keeps_variables_apart(WriterUnderTest(vendor, None)))
    # What the fault replaces is put back behind the test.
    for home, what in (
        (import_module(f"{type(vendor).__module__}.writer"), "write"),
        (_Shared, "__post_init__"),
    ):
        monkeypatch.setattr(home, what, getattr(home, what))
    planted = dict(meaning.writer_faults(lambda: vendor))["two routines' own variables of one name are one"]()
    told = {given for given, _ in writers.keeps_variables_apart(WriterUnderTest(vendor, None))}
    assert planted()
    assert any("two routines' own" in given for given in told)
    assert any("the program's" in given for given in told)


def test_limits_that_lack_what_no_routine_computes_break_the_contract(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    name = writable()[0]
    module = import_module(f"{type(find_vendor(name)).__module__}.limits")
    monkeypatch.setattr(module, "LIMITS", replace(limits_of(name), lacks=frozenset({"round", "floor"})))
    found = list(writers.lacks_what_a_routine_computes(WriterUnderTest(find_vendor(name), None)))
    assert [given for given, _ in found] == ["lacks 'round'"]


def test_a_writer_that_writes_what_its_limits_declare_as_refused_breaks_its_contract(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    name = writable()[0]
    limits = limits_of(name)
    module = import_module(f"{type(find_vendor(name)).__module__}.limits")
    monkeypatch.setattr(module, "LIMITS", replace(limits, refuses=limits.refuses | {"Message"}))
    found = writers.writes_each_kind_of_statement(WriterUnderTest(find_vendor(name), None))
    assert any("its limits say that it is refused, and it is written" in differs for _, differs in found)


def test_a_term_that_is_not_what_its_equation_says_breaks_its_contract(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    term = load_term("settling")
    act = type(term).act
    monkeypatch.setattr(type(term), "act", lambda self, m, f, v, c: act(self, m, f, 1.1 * v, c))
    with pytest.raises(ContractError, match="changes each move as an oracle works it out anew") as caught:
        check_term(term)
    assert "another added" in str(caught.value)


def test_a_term_whose_page_says_other_bounds_breaks_its_contract(monkeypatch: pytest.MonkeyPatch) -> None:
    term = load_term("settling")
    forms = type(term).forms

    def wider(self, case):
        return tuple(
            f._replace(parameters=tuple(p._replace(high=4.0) for p in f.parameters))
            for f in forms(self, case)
        )

    monkeypatch.setattr(type(term), "forms", wider)
    with pytest.raises(ContractError, match="only one of file and term says"):
        check_term(term)


def test_an_estimator_that_is_too_sure_of_its_number_breaks_its_contract(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    estimator = load_estimator("constant")
    fit = type(estimator).fit

    def sure(self, moves, robot):
        return {name: p._replace(sd=p.sd / 3) for name, p in fit(self, moves, robot).items()}

    monkeypatch.setattr(type(estimator), "fit", sure)
    with pytest.raises(ContractError, match="differs from recording to recording by no more than it says"):
        check_estimator(estimator)


@pytest.mark.parametrize(
    ("name", "careless", "says"),
    [
        ("robots", lambda args, run: [setattr(args, "verbose", False), run(args)][1], "--verbose"),
        (
            "robots",
            lambda args, run: min(run(args), 1) if args.robots != ["nobody/no-such-robot"] else 0,
            "status 0",
        ),
        ("signature show", lambda args, run: print(id(args)) or run(args), "another answer the second time"),
    ],
)
def test_a_careless_command_breaks_its_contract(
    name: str, careless, says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = cli.load(name)
    run = module.run
    monkeypatch.setattr(module, "run", lambda args: careless(args, run))
    with pytest.raises(ContractError, match=says):
        check_command(name)
