"""`olp time`, `olp annotate` and `Plan.time` with a signature."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import olp
from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.identification.recording import read_recording
from olp.identification.signature import calibrate, write_signature

UP20 = Path(__file__).parent.parent / "samples" / "up20"
JOB = UP20 / "APPR-L.JBI"


@pytest.fixture(scope="module")
def factors(tmp_path_factory):
    path = tmp_path_factory.mktemp("signature") / "up20.json"
    signature, _ = calibrate(read_recording(UP20), "factors")
    write_signature(signature, path)
    return path


def measured():
    with (UP20 / "moves.csv").open(encoding="utf-8") as file:
        return {int(r["line"]): float(r["duration_s"]) for r in csv.DictReader(file) if r["job"] == JOB.name}


def answer(capsys, *arguments):
    assert main([str(a) for a in arguments]) == 0
    return capsys.readouterr().out


def test_learnt_moves_of_a_job_take_their_measured_time(factors, capsys):
    told = json.loads(answer(capsys, "time", JOB, "--signature", factors, "--format", "json"))[0]
    segments = {s["line"]: s for s in told["segments"]}
    for line, seconds in measured().items():
        own = segments[line]
        assert own["duration_s"] == pytest.approx(seconds, abs=1e-6)
        assert own["low_s"] < seconds < own["high_s"]
        assert own["accel_mm_s2"] == pytest.approx(300 / (seconds - own["distance_mm"] / 300), rel=1e-6)


def test_the_total_has_an_interval_wider_than_independent_errors_would_give(factors, capsys):
    told = json.loads(answer(capsys, "time", JOB, "--signature", factors, "--format", "json"))[0]
    assert told["low_s"] < told["total_s"] < told["high_s"]
    halves = [s["high_s"] - s["duration_s"] for s in told["segments"] if s["high_s"] is not None]
    independent = np.sqrt(np.sum(np.square(halves)))
    assert told["total_s"] - told["low_s"] < np.sum(halves)
    assert told["high_s"] - told["total_s"] > 0.5 * independent


def test_without_a_signature_the_interval_is_null(capsys):
    told = json.loads(answer(capsys, "time", JOB, "--format", "json"))[0]
    assert told["low_s"] is None
    assert told["high_s"] is None
    assert "low_s" not in told["segments"][0]


def test_csv_has_the_ends_of_the_interval_as_columns(factors, capsys):
    rows = list(
        csv.DictReader(answer(capsys, "time", JOB, "--signature", factors, "--format", "csv").splitlines())
    )
    assert float(rows[1]["low_s"]) < float(rows[1]["duration_s"]) < float(rows[1]["high_s"])


def test_python_takes_a_signature_or_its_file(factors):
    plan = olp.read(JOB).plan(robot="yaskawa/up20")
    from olp.identification.signature import read_signature

    by_file, by_object = plan.time(signature=factors), plan.time(signature=read_signature(factors))
    assert by_file["duration_s"].tolist() == by_object["duration_s"].tolist()
    assert by_file["high_s"].notna().sum() == 30


def test_annotations_hold_the_corrected_acceleration(factors, capsys):
    text = answer(capsys, "annotate", JOB, "--signature", factors)
    assert "592mm/s2" in text
    assert "592mm/s2" not in answer(capsys, "annotate", JOB)


def test_a_model_that_a_signature_does_not_hold_for_is_refused(factors):
    from olp.identification.signature import read_signature

    plan = olp.read(JOB).plan(robot="yaskawa/up20")
    with pytest.raises(OlpError) as caught:
        plan.time(model="linear", signature=read_signature(factors))
    assert caught.value.diagnostics[0].code == "H013"


def test_a_signature_of_another_robot_is_refused(factors):
    plan = olp.read(JOB).plan(robot="yaskawa/ma2010")
    with pytest.raises(OlpError) as caught:
        plan.time(signature=factors)
    assert caught.value.diagnostics[0].code == "H009"
