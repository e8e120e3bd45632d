"""The diagnosis as people read it: text in a terminal, one HTML file for the customer."""

from __future__ import annotations

import base64
import hashlib
import json
import math
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from diagnosis_reports import NOISE, UP20, case_of, diagnosis_of, up20

from olp.identification.diagnosis import phrasing
from olp.identification.diagnosis.diagnose import DiagnosisOutcome
from olp.identification.diagnosis.model import DurationModel
from olp.identification.diagnosis.report_text import text_report
from olp.identification.diagnosis.result import Diagnosis, Errors, Mismatch, MoveResidual
from olp.reports.diagnosis import diagnosis_page, html_report
from olp.reports.diagnosis.mathml import mathml
from olp.reports.diagnosis.page import tables_of
from olp.timing.physics import LogTerm, MoveTerm, load_term, term_names

VOID = {"meta", "input", "br", "link", "hr", "img"}
HOSTILE = "<script>alert(1)</script>\"'&</td></svg>{{ 7*7 }}\x1b[31m"


class Page(HTMLParser):
    """What a browser would find: elements with their attributes, texts of cells, and whether all is closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.parents: list[tuple[str, ...]] = []
        self.texts: dict[int, str] = {}
        self._stack: list[int] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        self.parents.append(tuple(self.open))
        if tag not in VOID and not (self.get_starttag_text() or "").endswith("/>"):
            self.open.append(tag)
            self._stack.append(len(self.elements) - 1)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        self.parents.append(tuple(self.open))

    def handle_endtag(self, tag: str) -> None:
        assert self.open, f"</{tag}> without a beginning"
        assert self.open.pop() == tag
        self._stack.pop()

    def handle_data(self, data: str) -> None:
        for element in self._stack:
            self.texts[element] = self.texts.get(element, "") + data

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attrs for name, attrs in self.elements if name == tag]

    def text_of(self, tag: str) -> list[str]:
        return [self.texts.get(i, "") for i, (name, _) in enumerate(self.elements) if name == tag]


@pytest.fixture(scope="module")
def recording():
    return up20()


@pytest.fixture(scope="module")
def case(recording):
    return case_of(recording)


@pytest.fixture(scope="module")
def diagnosis(case) -> Diagnosis:
    return diagnosis_of(case)


@pytest.fixture(scope="module")
def predicted(case, diagnosis):
    return case.simulated + np.sum([list(f.contribution.values()) for f in diagnosis.findings], axis=0)


@pytest.fixture(scope="module")
def html(recording, case, diagnosis, predicted) -> str:
    ladder = (("", -700.0, 0.275), ("settling", -900.0, 0.09), ("gravity", -930.0, 0.08))
    jobs = {name: (UP20 / name).read_text() for name in set(case.job)}
    return html_report(DiagnosisOutcome(diagnosis, case, DurationModel(), predicted, ladder), recording, jobs)


@pytest.fixture(scope="module")
def page(html) -> Page:
    return Page(html)


def empty(verdict: str) -> Diagnosis:
    """Nothing but a verdict."""
    nothing = Errors(math.nan, math.nan, math.nan)
    return Diagnosis(verdict, 0, "", math.nan, Mismatch(math.nan, nothing, ()))


# --- text ---------------------------------------------------------------------------------------------------


def test_the_text_begins_with_the_verdict_and_names_every_cause(diagnosis, case):
    lines = text_report(diagnosis, case).splitlines()
    assert lines[0] == "PARTLY EXPLAINED"
    assert lines[1].startswith("Part of the difference comes from “reach inertia”, “gravity” and “settling”")
    assert "(or “dispatch”)" in " ".join(lines[1:3])


def test_every_finding_has_its_sentence_its_line_and_its_size_with_an_interval(diagnosis, case):
    text = text_report(diagnosis, case, width=0)
    for finding in diagnosis.findings:
        assert f"{finding.term.replace('-', ' ')}: {finding.says}" in text
        worst = max(finding.moves, key=lambda m: abs(finding.contribution[m]))
        index = case.move.tolist().index(worst)
        assert f"{case.job[index]}:{case.line[index]} (" in text
    assert "95 % interval" in text
    assert "at the bound of its range" in text


def test_a_place_at_the_level_of_the_base_has_no_sign(diagnosis, case):
    first = diagnosis.next_experiment.moves[0]
    level = first._replace(start=(1.35, -1e-5, -1e-5))
    found = replace(diagnosis, next_experiment=replace(diagnosis.next_experiment, moves=(level,)))
    assert "(1350, 0, 0) → " in text_report(found, case, width=0)


def test_the_text_says_what_is_open(diagnosis, case):
    text = text_report(diagnosis, case, width=0)
    for part in (
        "settling and dispatch",
        "(1350, 700, 100) → (710, 700, 100) mm at 300 mm/s, 5 times",
        "unexplained residual: 71.3 ms",
        "angle_deg",
        "no payload is written",
        "the program has no such line",
        "2 % of searches",
    ):
        assert part in text


@pytest.mark.parametrize("width", [40, 72, 100])
def test_no_line_is_wider_than_the_terminal(diagnosis, case, width):
    wide = [line for line in text_report(diagnosis, case, width).splitlines() if len(line) > width]
    assert wide == []


def test_colour_changes_nothing_but_colour(diagnosis, case):
    painted = text_report(diagnosis, case, 80, colour=True)
    assert "\x1b[" in painted
    assert re.sub(r"\x1b\[[0-9;]*m", "", painted) == text_report(diagnosis, case, 80)


def test_names_from_a_file_cannot_steer_the_terminal(diagnosis, case):
    text = text_report(replace(diagnosis, notes=(HOSTILE,)), case, 0)
    assert "\x1b" not in text
    assert "alert(1)" in text


def test_a_difference_without_a_name_shows_where_it_is(diagnosis):
    told = MoveResidual(31, "A.JBI", 12, "whole", 0.25, True)
    unknown = replace(empty("unexplained"), moves=1, mismatch=Mismatch(0.25, Errors(0.25, 9.0, 9.0), (told,)))
    text = text_report(unknown, None, 0)
    assert "A.JBI:12, move 31: +250 ms" in text
    assert "no known effect holds" in text


@pytest.mark.parametrize("verdict", ["explained", "partly-explained", "unexplained", "no-mismatch"])
def test_every_verdict_can_be_told_with_nothing_else_known(verdict):
    text, page = text_report(empty(verdict)), diagnosis_page(empty(verdict))
    assert verdict.replace("unex", "not ex").replace("-", " ").upper() in text
    assert "nan" not in text.lower()
    assert Page(page).open == []
    assert "nan" not in re.sub(r"<(script|style).*?</\1>", "", page, flags=re.S).lower()


def test_nothing_is_promised_where_nothing_was_named(diagnosis, case, recording):
    none = replace(diagnosis, verdict="no-mismatch", findings=(), indistinguishable=())
    for told in (text_report(none, case, 0), diagnosis_page(none, case, recording)):
        assert "never saw" not in told
        assert "after" not in re.findall(r"Typical error \w*", told)


# --- numbers ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0384, "38.4 ms"),
        (-0.26, "−260 ms"),
        (1.236, "1.24 s"),
        (2e-5, "0.02 ms"),
        (1e-9, "0 ms"),
        (0.9999, "1.00 s"),
    ],
)
def test_seconds_have_about_three_digits(value, text):
    assert phrasing.seconds(value) == text.replace(" ", phrasing.GLUE)


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.64912, "0.6491"), (-2.5e-7, "−2.5·10^−7"), (math.inf, "∞"), (123456.0, "1.235·10^5")],
)
def test_figures_keep_four_digits(value, text):
    assert phrasing.figure(value) == text


# --- HTML: one file that holds everything --------------------------------------------------------------------------


def test_the_page_asks_nobody_for_anything(html, page):
    assert not re.search(r"https?:|//[a-z]|url\(|@import", html)
    for _, attrs in page.elements:
        assert "src" not in attrs
        assert not [name for name in attrs if name.startswith("on")]
        assert (attrs.get("href") or "#").startswith("#")


def test_the_policy_lets_only_olps_own_script_run(html, page):
    policy = next(m["content"] for m in page.all("meta") if m.get("http-equiv") == "Content-Security-Policy")
    script = html[html.rindex("<script>") + 8 : html.rindex("</script>")]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert "default-src 'none'" in policy
    assert f"script-src 'sha256-{digest}'" in policy


def test_every_element_is_closed_and_every_link_leads_somewhere(page):
    assert page.open == []
    ids = [attrs["id"] for _, attrs in page.elements if "id" in attrs]
    assert len(ids) == len(set(ids))
    links = {attrs["href"] for attrs in page.all("a")}
    assert {link[1:] for link in links} <= set(ids)
    assert "#findings" in links


def test_those_who_cannot_see_the_page_hear_what_it_shows(page):
    assert page.all("html")[0]["lang"] == "en"
    assert len(page.all("table")) == len(page.all("caption"))
    assert all(svg.get("role") == "img" and svg.get("aria-label") for svg in page.all("svg"))
    assert page.all("canvas")[0]["aria-label"]
    assert page.all("canvas")[0]["tabindex"] == "0"
    sections = [attrs["aria-labelledby"] for attrs in page.all("section")]
    assert set(sections) <= {attrs.get("id") for attrs in page.all("h2")}
    assert all("scope" in th for th in page.all("th"))


def test_all_parts_are_there(html):
    for title in (
        "What the simulation leaves out",
        "Before and after",
        "Where they differ",
        "Why these causes",
        "Program lines",
        "What remains",
        "Ledger",
        "Assumptions and data",
        "From above, after",
        "From the side, before",
        "By direction of travel",
        "By start point (table)",
        "yaskawa/up20",
    ):
        assert title in html


def test_hostile_names_stay_text(case, diagnosis):
    n = len(case)
    bad_case = replace(case, job=(HOSTILE,) * n)
    parameters = {HOSTILE: diagnosis.findings[0].parameters["size"]}
    finding = replace(
        diagnosis.findings[0], term=HOSTILE, says=HOSTILE, equation=HOSTILE, parameters=parameters
    )
    bad = replace(
        diagnosis,
        findings=(finding, *diagnosis.findings[1:]),
        indistinguishable=((HOSTILE, HOSTILE),),
        notes=(HOSTILE,),
        unpaired=(HOSTILE,),
        held_out_by=HOSTILE,
        verdict=HOSTILE,
    )
    text = diagnosis_page(
        bad, bad_case, None, {HOSTILE: HOSTILE * 3}, log_summary={HOSTILE: [{HOSTILE: HOSTILE}]}
    )
    page = Page(text)
    assert page.open == []
    assert len(page.all("script")) == 2
    assert "<script>alert" not in text
    assert "49" not in [cell.strip() for cell in page.text_of("li")]
    assert json.loads(page.text_of("script")[0])["names"][0].count("alert") == 1


def test_control_characters_do_not_reach_the_page(case, diagnosis):
    turned = "A\u202eB\x1bC\x00.JBI"
    text = diagnosis_page(replace(diagnosis, notes=(turned,)), replace(case, job=(turned,) * len(case)))
    assert not set(text) & set("\u202e\x1b\x00")
    assert "A\ufffdB\ufffdC\ufffd.JBI" in text


def test_six_hundred_moves_fit_in_a_megabyte(case, diagnosis):
    rows = np.resize(np.arange(len(case)), 600)
    many = replace(case.take(rows), move=np.arange(1, 601))
    text = diagnosis_page(replace(diagnosis_of(many), moves=600), many)
    assert len(text.encode()) <= 1_000_000
    assert text.count('<tr id="move-') == 600


def test_a_log_alone_is_shown_as_tables():
    summary = {"rate": 1.00021, "joints": {"S": {"viscous": 12.5, "held": True}, "L": {"viscous": 3.25}}}
    tables = tables_of(summary)
    assert tables[0].rows == (("rate", "1.00021"),)
    assert tables[1].header == ("name", "viscous", "held")
    assert tables[1].rows == (("S", "12.5", "yes"), ("L", "3.25", ""))
    assert "What the log shows" in diagnosis_page(empty("explained"), log_summary=summary)


# --- HTML: the numbers ---------------------------------------------------------------------------------------------


def ledger_of(page: Page) -> list[list[float]]:
    """Numbers of the ledger's rows: robot, simulation, difference, causes …, remains."""
    start = next(i for i, (_, attrs) in enumerate(page.elements) if attrs.get("id") == "book")
    rows: list[list[str]] = []
    for i in range(start, len(page.elements)):
        tag, attrs = page.elements[i]
        if tag == "tr" and str(attrs.get("id", "")).startswith("move-"):
            rows.append([])
        if tag == "tfoot":
            break
        if tag == "td" and rows:
            rows[-1].append(page.texts.get(i, ""))
    return [[float(cell.replace("−", "-")) for cell in row[1:-1]] for row in rows]


def test_every_row_of_the_ledger_adds_up_as_printed(page, case):
    rows = np.array(ledger_of(page))
    assert rows.shape == (146, 3 + 3 + 1)
    np.testing.assert_allclose(rows[:, 0], case.measured, atol=5e-4)
    np.testing.assert_allclose((rows[:, 0] - rows[:, 1]) * 1000, rows[:, 2], atol=1.05)
    np.testing.assert_allclose(rows[:, 3:].sum(axis=1), rows[:, 2], atol=0.05 * 5)


def test_the_check_compares_the_causes_with_the_model_and_can_fail(html, case, diagnosis, predicted):
    assert "Adds up." in html
    good = case.simulated + (predicted - case.simulated) * 1.019
    bad = case.simulated + (predicted - case.simulated) * 1.03
    assert "Adds up." in diagnosis_page(diagnosis, case, predicted=good)
    assert "Does not add up." in diagnosis_page(diagnosis, case, predicted=bad)
    assert "add up" not in diagnosis_page(diagnosis, case)


def test_the_pages_data_are_the_residuals_before_and_after(page, case, predicted):
    data = json.loads(page.text_of("script")[0])
    np.testing.assert_allclose(data["before"], case.residual * 1000, atol=0.01)
    np.testing.assert_allclose(data["after"], (case.measured - predicted) * 1000, atol=0.01)
    assert len(data["ways"]) == 146
    first = data["ways"][0]
    np.testing.assert_allclose(first[1:], [*case.start[0] * 1000, *case.end[0] * 1000], atol=0.05)


def test_dots_of_a_chart_lie_where_the_axis_says():
    from olp.reports.diagnosis.svg import Chart

    chart = Chart((0.0, 10.0), (-1.0, 1.0))
    x, y = chart.x([0.0, 10.0]), chart.y([-1.0, 1.0])
    assert x[0] == chart.left
    assert y[0] == chart.top + chart.inner_height
    assert (x[1] - x[0], y[0] - y[1]) == (chart.inner_width, chart.inner_height)
    chart.dots([5.0, math.nan], [0.0, 0.0], "after", [3, 4])
    middle = f"M{(x[0] + x[1]) / 2:.1f} {(y[0] + y[1]) / 2:.1f}".replace(".0", "")
    assert middle in chart.parts[-1]
    assert 'data-rows="3"' in chart.parts[-1]


def test_both_axes_of_a_map_have_one_scale():
    from olp.reports.diagnosis.svg import Chart

    chart = Chart((0.0, 1000.0), (0.0, 10.0), equal=True)
    right = float(chart.x(100.0) - chart.x(0.0))
    assert right == pytest.approx(float(chart.y(0.0) - chart.y(100.0)))


def test_the_colour_tells_slower_from_faster_and_neither():
    from olp.reports.diagnosis.svg import step_of

    assert step_of(np.array([-0.5, -0.1, 0.0, 0.1, 0.5, math.nan]), 0.1).tolist() == [0, 0, 4, 8, 8, 4]


def test_the_ladder_goes_down_in_the_order_of_its_steps(page):
    rows = [text for text in page.text_of("tr") if text.strip().startswith(("simulation as it is", "+ "))]
    assert [re.search(r"[\d.]+\sms", row)[0].replace(phrasing.GLUE, " ") for row in rows] == [
        "275 ms",
        "90.0 ms",
        "80.0 ms",
    ]  # type: ignore[index]


def test_program_lines_show_their_text_and_their_cost(html, case):
    index = 0
    line = (UP20 / case.job[index]).read_text().splitlines()[case.line[index] - 1]
    assert line in html
    assert f"{case.job[index]}:{case.line[index]}" in html


def test_a_single_text_is_shown_as_the_job_that_it_names_and_no_other(case, diagnosis):
    text = (UP20 / "APPR-1.JBI").read_text()
    assert re.findall("<summary>(.*?)</summary>", diagnosis_page(diagnosis, case, None, text)) == [
        "APPR-1.JBI"
    ]
    assert "<summary>" not in diagnosis_page(diagnosis, case, None, text.replace("APPR-1", "OTHER"))
    one = replace(case, job=("CELL",) * len(case))
    assert "<summary>CELL</summary>" in diagnosis_page(diagnosis, one, None, text)
    shown = diagnosis_page(diagnosis, case, None, {"jobs/appr-1": text})
    assert re.findall("<summary>(.*?)</summary>", shown) == ["APPR-1.JBI"]


def test_without_points_the_page_does_without_maps(case, diagnosis):
    nowhere = np.full((len(case), 3), math.nan)
    text = diagnosis_page(
        diagnosis, replace(case, start=nowhere, end=nowhere, joint=np.ones(len(case), dtype=bool))
    )
    assert "<canvas" not in text
    assert Page(text).open == []


def test_without_a_case_the_differences_are_still_there(diagnosis):
    page = Page(diagnosis_page(diagnosis))
    assert "canvas" not in [tag for tag, _ in page.elements]
    assert sum(str(attrs.get("id", "")).startswith("move-") for attrs in page.all("tr")) == 146


def test_a_noise_floor_that_the_recording_does_not_show_is_called_what_it_is(case, diagnosis, recording):
    assert "from the clock’s resolution" in diagnosis_page(
        replace(diagnosis, noise_floor=NOISE), case, recording
    )
    assert "scatter of the residual" in diagnosis_page(replace(diagnosis, noise_floor=0.06), case, recording)


# --- equations -----------------------------------------------------------------------------------------------------


def equations(case) -> dict[str, str]:
    """Every equation that a term of the library may answer with."""
    found = {}
    for name in term_names():
        term = load_term(name)
        if isinstance(term, MoveTerm):
            found |= {f"{name} {form.key}": form.equation for form in term.forms(case)}
        if isinstance(term, LogTerm):
            found[f"{name} in a log"] = getattr(term, "equation", "")
    return found


def test_every_equation_of_the_library_is_set(case):
    found = equations(case)
    assert len(found) > 10
    assert [name for name, latex in found.items() if "<code>" in mathml(latex)] == []


@pytest.mark.parametrize(
    ("latex", "part"),
    [
        (r"\frac{v}{a}", "<mfrac><mrow><mi>v</mi></mrow><mrow><mi>a</mi></mrow></mfrac>"),
        (r"a_{max}", "<msub><mi>a</mi><mtext>max</mtext></msub>"),
        (r"x_i^2", "<msubsup><mi>x</mi><mi>i</mi><mn>2</mn></msubsup>"),
        (r"\left\lceil t \right\rceil", "<mo>⌈</mo><mi>t</mi><mo>⌉</mo>"),
        (r"q_j'", "<msubsup><mi>q</mi><mi>j</mi><mo>′</mo></msubsup>"),
        ("a<b", "<mo>&lt;</mo>"),
    ],
)
def test_equations_become_mathml(latex, part):
    assert part in mathml(latex)


@pytest.mark.parametrize("latex", ["{{", r"\begin{x}", "x_a_b", "}", "^", "{" * 5000, r"\left", "&"])
def test_what_cannot_be_set_is_shown_as_it_was_written(latex):
    assert mathml(latex).startswith("<code>")
    assert "<math" not in mathml(latex)
