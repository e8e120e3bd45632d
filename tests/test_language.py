"""The language service without a protocol: texts that change, and what is known of them."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from olp.checks.lint.run import lint
from olp.core.result_cache import SupersededError
from olp.core.source import decode
from olp.reports.batch import Job, plan_and_time
from olp.servers.language.actions import hints
from olp.servers.language.document import OpenDocument, Place, TextChange
from olp.servers.language.service import Analysis, ProgramService, complete, marks, settings_of

SAMPLES = Path(__file__).parent.parent / "samples"
PROGRAMS = [
    "inform/generations/dx200.jbi",
    "inform/handling/HANDLING.JBI",
    "krl/handling.src",
    "rapid/handling.mod",
    "tp/handling.ls",
    "urscript/handling.script",
]
WORDS = ["", "x", "\n", "\r\n", "\r", "MOVL C00001 V=100.0\r\n", "ü", "😀", "  ", "\n\n\n", "a\rb\nc\r\nd"]


@pytest.fixture
def service():
    made = ProgramService()
    yield made
    for path in list(made.documents):
        made.close(path)


def known(service: ProgramService, path: str) -> Analysis:
    """What is known of a text that can be timed."""
    analysis = service.current(path)
    assert analysis is not None
    assert analysis.timing is not None
    return analysis


def opened(service: ProgramService, name: str) -> str:
    path = str(SAMPLES / name)
    service.open(path, Path(path).read_bytes().decode("utf-8"))
    return path


def test_any_edits_leave_the_text_that_the_same_edits_leave_in_a_string() -> None:
    chance = random.Random(11)
    for _ in range(60):
        text = "".join(chance.choice(WORDS) for _ in range(chance.randrange(8)))
        document = OpenDocument("", text)
        for _ in range(12):
            begin, end = sorted(chance.randrange(len(text) + 1) for _ in range(2))
            word = chance.choice(WORDS)
            places = [place_of(text, offset) for offset in (begin, end)]
            begin, end = (offset_of(text, place) for place in places)
            text = text[:begin] + word + text[end:]
            document.change(TextChange(*places, word))
            assert document.text == text
            whole = OpenDocument("", text)
            assert [document.line(n) for n in range(1, len(document) + 1)] == [
                whole.line(n) for n in range(1, len(whole) + 1)
            ]
            assert document.source().lines == decode(text.encode()).lines


def place_of(text: str, offset: int) -> Place:
    """Of an offset; inside of a line end there is no place, so the one before it is meant."""
    if text[offset - 1 : offset + 1] == "\r\n":
        offset -= 1
    before = text[:offset].replace("\r\n", "\n").replace("\r", "\n").split("\n")
    return Place(len(before), len(before[-1]) + 1)


def offset_of(text: str, place: Place) -> int:
    offset = 0
    for _ in range(place.line - 1):
        ends = [text.find(end, offset) for end in "\r\n" if end in text[offset:]]
        offset = min(ends)
        offset += 2 if text[offset : offset + 2] == "\r\n" else 1
    return offset + place.column - 1


def test_splices_say_where_every_untouched_line_is_now() -> None:
    chance = random.Random(5)
    for _ in range(40):
        lines = [f"line {n}" for n in range(20)]
        document = OpenDocument("", "\n".join(lines))
        for _ in range(4):
            start = Place(chance.randrange(1, len(document) + 1), chance.randrange(1, 9))
            stop = Place(chance.randrange(1, len(document) + 1), chance.randrange(1, 9))
            document.change(TextChange(start, stop, chance.choice(["", "new", "new\n", "\nnew\nnewer\n"])))
        for number, text in enumerate(lines, 1):
            where: int | None = number
            for splice in document.splices:
                where = splice.moved(where) if where else None
            if where:
                assert document.line(where) == text


@pytest.mark.parametrize("name", PROGRAMS)
def test_findings_and_times_are_those_of_the_command_line(service: ProgramService, name: str) -> None:
    path = opened(service, name)
    analysis = complete(service, path)
    assert analysis is not None
    assert analysis.timing is not None
    timing = plan_and_time(path, Job())
    told = {(m.code, m.line, m.message.partition("\n")[0]) for m in marks(analysis)}
    for found in timing.diagnostics:
        assert (found.code, found.line, found.message) in told
    for finding in lint(path, Job()).findings:
        assert (finding.line, finding.message) in {(line, says) for _, line, says in told}
    assert analysis.timing.total_s == timing.total_s
    moves = {int(line) for line in timing.plan.line[timing.plan.source == 0][_moves(timing)]}
    assert moves <= {hint.line for hint in hints(analysis)}


def _moves(timing):
    return (timing.plan.kind == 0)[timing.plan.source == 0]


def test_hints_of_a_range_are_those_of_the_whole_that_lie_in_it(service: ProgramService) -> None:
    analysis = service.current(opened(service, PROGRAMS[0]))
    assert analysis is not None
    whole = hints(analysis)
    assert [h.line for h in whole] == sorted({h.line for h in whole})
    for first in range(1, 45, 7):
        assert hints(analysis, first, first + 9) == [h for h in whole if first <= h.line <= first + 9]


def test_a_line_in_a_loop_shows_its_sum_and_how_often_it_runs(service: ProgramService) -> None:
    analysis = known(service, opened(service, PROGRAMS[0]))
    line = next(n for n, text in enumerate(analysis.source.lines, 1) if "MOVL C00002" in text)
    (hint,) = hints(analysis, line, line)
    steps = analysis.steps(line)
    assert hint.times == len(steps) == 2
    assert hint.seconds == pytest.approx(sum(analysis.timing.duration_s[steps]))
    assert hint.text.startswith("2 × = ")
    assert f"{hint.seconds:.3f} s" in hint.text


def test_an_open_text_is_read_in_place_of_the_file_by_those_who_call_it(
    service: ProgramService, tmp_path: Path
) -> None:
    job = (SAMPLES / "inform/generations/dx200.jbi").read_text()
    main = tmp_path / "MAIN.JBI"
    called = tmp_path / "SUB.JBI"
    called.write_text(job.replace("//NAME DX200", "//NAME SUB"))
    main.write_text("/JOB\n//NAME MAIN\n//INST\n///GROUP1 RB1\nNOP\nCALL JOB:SUB\nEND\n")
    service.open(str(main), main.read_text())
    before = known(service, str(main))
    assert str(called) in before.needs
    service.open(str(called), called.read_text().replace("T=0.61", "T=5.61"))
    assert str(main) in service.dependents(str(called))
    service.forget(str(main))
    after = known(service, str(main))
    assert after.timing.wait_s == pytest.approx(before.timing.wait_s + 10.0)
    (hint,) = hints(after)
    assert (hint.line, hint.times) == (6, 1)
    assert hint.seconds == pytest.approx(after.timing.total_s)
    service.close(str(called))
    service.forget(str(main))
    again = known(service, str(main))
    assert again.timing.wait_s == before.timing.wait_s


def test_settings_are_those_of_the_command_line_and_wrong_ones_are_told(service: ProgramService) -> None:
    path = opened(service, PROGRAMS[0])
    service.configure(settings_of({"olp": {"override": 50, "robot": "yaskawa/gp25"}}))
    analysis = known(service, path)
    wanted = plan_and_time(path, Job(robot="yaskawa/gp25", override=0.5))
    assert analysis.timing.total_s == wanted.total_s
    service.configure(settings_of({"override": "fast", "robot": 7, "model": ""}))
    analysis = service.current(path)
    assert analysis is not None
    assert [d.code for d in analysis.diagnostics][:2] == ["C013", "C013"]
    service.configure(settings_of({"robot": "yaskawa/nobody"}))
    analysis = service.current(path)
    assert analysis is not None
    assert analysis.timing is None
    assert analysis.diagnostics


ENDLESS = """\
def a():
  n = 0
  while True:
    movel(p[0.5, 0.1, 0.3, 0, 3.14, 0], v=0.1)
    movel(p[0.5, 0.2, 0.3, 0, 3.14, 0], v=0.1)
    n = n + 1
  end
end
a()
"""


def test_a_program_that_goes_on_and_on_is_partial_for_who_types_and_whole_later(
    service: ProgramService,
) -> None:
    service.open("a.script", ENDLESS.replace("True", "n < 9000"), "urscript")
    some = service.current("a.script", whole=False)
    assert some is not None
    assert some.partial
    assert "I108" not in {d.code for d in some.diagnostics}
    assert service.current("a.script", whole=False) is some
    whole = known(service, "a.script")
    assert not whole.partial
    assert len(whole.timing.plan) == 18_000
    assert len(some.timing.plan) < 6_000


def test_work_on_a_program_ends_as_soon_as_nobody_wants_it(service: ProgramService) -> None:
    service.open("a.script", ENDLESS.replace("True", "n < 9000"), "urscript")
    asked: list[bool] = []

    def wanted() -> bool:
        asked.append(len(asked) < 20)
        return asked[-1]

    with pytest.raises(SupersededError):
        service.current("a.script", wanted)
    assert len(asked) == 21
    assert known(service, "a.script").timing is not None


def test_a_mistake_in_olp_is_a_finding_of_the_text_and_ends_nothing(
    service: ProgramService, monkeypatch
) -> None:
    monkeypatch.setattr("olp.servers.language.service.run", lambda *a, **k: 1 / 0)
    path = opened(service, PROGRAMS[0])
    analysis = service.current(path)
    assert analysis is not None
    assert [d.code for d in analysis.diagnostics] == ["C016"]
    assert marks(analysis)[0].message.startswith("olp made a mistake with this text (ZeroDivisionError")
    assert analysis.timing is None
    assert not hints(analysis)


def test_a_point_with_a_number_too_much_stops_nothing(service: ProgramService) -> None:
    path = opened(service, "inform/handling/HANDLING.JBI")
    line = next(
        n for n, text in enumerate(service.documents[path].text.splitlines(), 1) if text.startswith("C00001")
    )
    service.change(path, [TextChange(Place(line, 12), Place(line, 12), "\n")], 2)
    analysis = service.current(path)
    assert analysis is not None
    assert "C016" not in {d.code for d in analysis.diagnostics}


def test_a_rule_that_fails_is_told_and_the_others_run(service: ProgramService, monkeypatch) -> None:
    from olp.checks.lint.rule import all_rules

    broken = next(type(rule) for rule in all_rules() if rule.code == "W001")
    monkeypatch.setattr(broken, "find", lambda self, case: iter([1 / 0]))
    analysis = complete(service, opened(service, "inform/pitfalls/labels.jbi"))
    assert analysis is not None
    assert {"C016", "W014"} <= {finding.code for finding in analysis.lint}
