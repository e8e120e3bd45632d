"""What every sample promises, and what single samples were written for."""

from __future__ import annotations

import re
import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

import olp
from olp.timing.timing import time_plan

SAMPLES = Path(__file__).resolve().parent.parent / "samples" / "inform"
JOBS = sorted(path for path in SAMPLES.rglob("*") if path.suffix.lower() == ".jbi")
BROKEN = [path for path in JOBS if path.parent.name == "broken"]
WHOLE = [path for path in JOBS if path.parent.name != "broken"]
# Points for a seven-axis arm, whose pulses nobody has published.
SAYS_WHY_NOT = {
    "seven-axis.jbi",
    "DROP.JBI",
}  # an arm nobody knows; an arc that begins where the caller stood


def name(path: Path) -> str:
    return str(path.relative_to(SAMPLES))


def expected_lines() -> dict[str, set[int]]:
    """The table of samples/inform/broken/README.md."""
    rows = re.findall(
        r"^\| `([^`]+)` \| .* \| ([\d, ]+) \|$", (SAMPLES / "broken/README.md").read_text(), re.M
    )
    return {job: {int(line) for line in lines.split(",")} for job, lines in rows}


@pytest.mark.parametrize("path", WHOLE, ids=name)
def test_a_complete_job_reads_without_an_error(path: Path) -> None:
    problems = [d.render() for d in olp.read(path).diagnostics if d.severity == "error"]
    assert not problems, "\n\n".join(problems)


@pytest.mark.parametrize("path", WHOLE, ids=name)
def test_a_job_comes_back_with_the_same_bytes(path: Path) -> None:
    assert olp.read(path).to_bytes() == path.read_bytes()


@pytest.mark.parametrize("path", WHOLE, ids=name)
def test_every_step_of_a_complete_job_has_a_time(path: Path) -> None:
    timing = time_plan(olp.read(path).plan())
    errors = [d.render() for d in timing.diagnostics if d.severity == "error"]
    if path.name in SAYS_WHY_NOT:
        assert errors
        return
    assert not errors, "\n\n".join(errors)
    assert np.isfinite(timing.duration_s).all()


@pytest.mark.parametrize("path", BROKEN, ids=name)
def test_a_broken_job_says_where_it_is_broken(path: Path) -> None:
    try:
        diagnostics = olp.read(path).diagnostics
    except olp.OlpError as refusal:
        diagnostics = refusal.diagnostics
    told = {d.line for d in diagnostics if d.severity != "info"}
    assert expected_lines()[path.name] <= told


def test_the_table_of_broken_jobs_lists_all_of_them() -> None:
    assert set(expected_lines()) == {path.name for path in BROKEN}


def test_the_table_of_pitfalls_lists_all_of_them() -> None:
    listed = set(re.findall(r"^\| `([^`]+)`", (SAMPLES / "pitfalls/README.md").read_text(), re.M))
    assert listed == {path.name for path in WHOLE if path.parent.name == "pitfalls"}


def test_one_path_in_four_ways_of_writing_takes_one_time() -> None:
    timings = {
        path.stem: time_plan(olp.read(path).plan()) for path in sorted((SAMPLES / "twins").glob("*.jbi"))
    }
    assert set(timings) == {"angle", "base", "pulse", "user"}
    reference = timings["pulse"].plan
    moves = reference.moves
    for timing in timings.values():
        plan = timing.plan
        here = plan.positions.position[plan.moves.target]
        np.testing.assert_allclose(here, reference.positions.position[moves.target], atol=2e-6)
        axes = plan.positions.axes[plan.moves.target]
        np.testing.assert_allclose(axes, reference.positions.axes[moves.target], atol=2e-5)
        # Where a program begins is assumed, and each of them begins at the same pose.
        np.testing.assert_allclose(timing.duration_s, timings["pulse"].duration_s, atol=2e-3)


def test_the_pallet_gets_all_its_cartons_each_in_its_own_place() -> None:
    plan = olp.read(SAMPLES / "palletising/MAIN.JBI").plan()
    placed = [step for step in plan.steps() if step.statement == "MOVL C00002 V=95.0 PL=0"]
    places = np.array([step.target for step in placed])
    assert len(places) == 24
    # Two layers of three rows of four: the pitches in the frame of the pallet, whatever its turn.
    gaps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    np.testing.assert_allclose(gaps[:3], 0.1187, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(places[4] - places[0]), 0.1424, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(places[12] - places[0]), 0.0973, atol=1e-6)


def test_the_computed_jump_of_the_pallet_takes_the_branch_of_the_recipe() -> None:
    plan = olp.read(SAMPLES / "palletising/MAIN.JBI").plan()
    said = [step.statement for step in plan.steps() if step.statement.startswith("MSG")]
    assert "MSG \"PALLET 'FULL' // WRAP IT\"" in said
    assert 'MSG "SHORT PALLET"' not in said


def test_the_welding_cell_waits_as_its_assumptions_say() -> None:
    timing = time_plan(olp.read(SAMPLES / "welding/WELD-MAIN.JBI").plan())
    table = timing.frame()
    waits = table[table["statement"].str.startswith("WAIT")].set_index("statement")["duration_s"]
    assert waits["WAIT IN#(12)=ON"] == pytest.approx(0.35)
    assert waits["WAIT IN#(3)=ON T=5.00"] == pytest.approx(0.8)
    assert {"RB1", "BS1", "ST1"} <= set(timing.plan.mechanisms)


def test_the_script_of_the_cam_path_writes_the_job_that_is_there(monkeypatch: pytest.MonkeyPatch) -> None:
    script = SAMPLES / "cam/make_path.py"
    monkeypatch.setattr(sys, "argv", [str(script)])
    made = runpy.run_path(str(script))
    text = made["job"](made["path"]())
    assert text.replace("\n", "\r\n").encode("ascii") == (SAMPLES / "cam/FINISH.JBI").read_bytes()


def test_complete_jobs_keep_the_line_ends_of_the_controller() -> None:
    odd = {"bare-cr.jbi", "lf-only.jbi", "mixed-ends.jbi"}
    for path in WHOLE:
        raw = path.read_bytes()
        if path.name not in odd:
            assert raw.count(b"\n") == raw.count(b"\r\n") == raw.count(b"\r"), name(path)
