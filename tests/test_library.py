"""The library as a researcher uses it: six verbs, explicit keywords, short names in a notebook."""

from __future__ import annotations

import inspect
from pathlib import Path

import matplotlib
import pytest

import olp
from olp.recorded import DiagnosisAnswer

SAMPLES = Path(__file__).resolve().parents[1] / "samples"
JOB = SAMPLES / "inform" / "generations" / "dx200.jbi"
TUNED = SAMPLES / "recordings" / "tuned"


def test_time_is_what_read_plan_and_time_say() -> None:
    table = olp.time(JOB, robot="yaskawa/ma2010")
    assert table.equals(olp.read(JOB).plan("yaskawa/ma2010").time())
    assert olp.time(JOB, robot="yaskawa/ma2010", override=0.5)["duration_s"].sum() > table["duration_s"].sum()


@pytest.mark.parametrize("verb", ["time", "calibrate", "predict", "diagnose", "convert"])
def test_a_misspelt_keyword_is_refused_at_once(verb: str) -> None:
    with pytest.raises(TypeError, match="overide"):
        getattr(olp, verb)(JOB, overide=50)
    kinds = {p.kind for p in inspect.signature(getattr(olp, verb)).parameters.values()}
    assert inspect.Parameter.VAR_KEYWORD not in kinds


def test_a_plan_takes_no_keyword_that_means_nothing() -> None:
    with pytest.raises(TypeError, match="overide"):
        olp.read(JOB).plan(overide=50)  # type: ignore[call-arg]
    with pytest.raises(olp.OlpError):
        olp.read(JOB).plan().time(overide=50)


def test_calibrate_and_predict_are_those_of_the_commands() -> None:
    signature = olp.calibrate(SAMPLES / "up20", method="constant")
    table = olp.predict(SAMPLES / "up20", signature=signature)
    assert list(table.columns) == ["move", "predicted_s", "low_s", "high_s"]
    assert len(table) == 146
    assert (table["low_s"] <= table["predicted_s"]).all()


@pytest.fixture(scope="module")
def answer() -> DiagnosisAnswer:
    return olp.diagnose(TUNED)


def test_diagnose_answers_with_a_verdict_and_names(answer: DiagnosisAnswer) -> None:
    assert answer.verdict == answer.to_json()["verdict"]
    assert answer.findings == tuple(found["term"] for found in answer.to_json()["findings"])
    assert repr(answer) == f"<Diagnosis of {TUNED}: {answer.verdict}, {', '.join(answer.findings)}>"
    assert answer.text() in answer._repr_html_().replace("&lt;", "<").replace("&gt;", ">").replace(
        "&#x27;", "'"
    ).replace("&quot;", '"').replace("&amp;", "&")


def test_convert_gives_the_files_of_the_other_language() -> None:
    files = olp.convert(SAMPLES / "krl" / "handling.src", to="rapid", robot="yaskawa/gp25")
    assert any(b"MoveL" in data for data in files.values())


def test_objects_say_in_one_line_what_they_are(answer: DiagnosisAnswer) -> None:
    program = olp.read(JOB)
    plan = program.plan("yaskawa/ma2010")
    recording = answer.recording
    assert isinstance(recording, olp.Recording)
    assert repr(program).startswith(f"<Program {JOB} (inform): ")
    assert repr(plan) == f"<Plan of {JOB}: 11 steps, 9 of them moves, yaskawa/ma2010>"
    assert repr(recording).startswith(f"<Recording {TUNED}: 80 moves, ")
    assert all(len(repr(one)) < 200 for one in (program, plan, recording))
    assert plan._repr_html_().startswith("<p>Plan of ")


def test_a_plan_is_drawn_as_speed_over_time() -> None:
    matplotlib.use("Agg")
    plan = olp.read(JOB).plan("yaskawa/ma2010")
    axes = plan.plot()
    (line,) = axes.get_lines()
    assert line.get_xdata()[-1] == pytest.approx(plan.time()["end_s"].iloc[-1])
    assert 400 < line.get_ydata().max() < 600


def test_recordings_signatures_and_diagnoses_are_drawn_and_show_themselves(
    tmp_path: Path, answer: DiagnosisAnswer
) -> None:
    matplotlib.use("Agg")
    recording = olp.Recording.read(TUNED)
    measured, simulated = recording.plot().get_lines()
    assert measured.get_ydata() == pytest.approx(recording.moves.duration)
    assert simulated.get_ydata() == pytest.approx(recording.moves.sim)
    assert recording.frame()["duration_s"].to_numpy() == pytest.approx(recording.moves.duration)
    assert "moves      80, 80 measured" in recording._repr_html_()
    _, before, after = answer.plot().get_lines()
    off = [float((line.get_ydata() ** 2).mean()) ** 0.5 / 1e3 for line in (before, after)]
    assert off[0] == pytest.approx(answer.to_json()["fit"]["before"]["rmse_s"], rel=0.02)
    assert off[1] < off[0] / 5
    signature = olp.calibrate(SAMPLES / "up20", method="constant")
    signature.save(tmp_path / "s.json")
    again = olp.Signature.read(tmp_path / "s.json")
    assert repr(again) == repr(signature)
    assert len(signature.plot().containers) == 9  # start points
    assert "method constant" in signature._repr_html_()


def test_a_log_alone_is_drawn_as_axes_over_time(tmp_path: Path) -> None:
    matplotlib.use("Agg")
    rows = [f"{0.01 * n},{n},{2 * n},{n},0" for n in range(5)]
    (tmp_path / "log.csv").write_text("\n".join(["t_s,q1_deg,q2_deg,q1_cmd_deg,q2_cmd_deg", *rows]))
    first, second = olp.Recording.read(tmp_path).plot().get_lines()
    assert first.get_ydata().tolist() == pytest.approx([0, 1, 2, 3, 4])
    assert second.get_ydata().tolist() == pytest.approx([0, 2, 4, 6, 8])


def test_a_robot_is_said_in_a_line_and_shown_as_a_table() -> None:
    robot = olp.load_robot("yaskawa/gp25")
    assert repr(robot) == "<Robot yaskawa/gp25: arm, axes S L U R B T>"
    assert robot._repr_html_().count("<tr>") == 7
