"""The findings of `olp diagnose` as a signature: programs take the time that the diagnosis predicted."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from diagnosis_cases import ACCELERATION, program, write

import olp
from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.identification.diagnosis.diagnose import DiagnosisOutcome, diagnose_recording
from olp.identification.diagnosis.model import DurationModel, ModelPart
from olp.identification.diagnosis.result import Finding
from olp.identification.recorded_plan import case_of
from olp.identification.recording import read_recording
from olp.identification.signature import calibrate, read_signature, write_signature
from olp.identification.signature.estimator import load_estimator
from olp.identification.signature.from_diagnosis import signature_of
from olp.identification.signature.rows import predict_recording
from olp.identification.signature.term_model import NamedModel, case_for, from_parameters, to_parameters
from olp.timing.physics import MoveTerm, load_term, term_names
from olp.timing.physics._motion import Motion, MoveCorners

ROBOT = "yaskawa/ma2010"
ZONES = (0.0125, 0.025, 0.05)  # [m] of its position levels 1 to 3
JERK, SETTLING, SHARE = 15.0, 0.045, 0.3


def motion_of(made, **changes):
    """The simulation's motion: 2 m/s², corners as long as braking there takes, up to half of the shorter move."""
    count = len(made.speed)
    begins = np.concatenate([[True], made.stop[:-1]])
    before = np.concatenate([[0.0], made.blend[:-1]])
    nothing, whole = np.zeros(count), np.full(count, ACCELERATION)
    motion = Motion(
        way=made.length,
        speed=made.speed,
        accelerate=whole,
        decelerate=whole,
        jerk=np.full(count, np.inf),
        round_start=np.where(begins, 0.0, before),
        round_end=np.where(made.stop, 0.0, made.blend),
        least=nothing,
        added=nothing,
        rate=np.ones(count),
        law="braking each",
        corners=MoveCorners(
            made.length,
            made.speed,
            np.ones(count),
            np.minimum(made.length, np.append(np.inf, made.length[:-1])),
            np.minimum(made.length, np.append(made.length[1:], np.inf)),
            np.append(made.length[1:], made.length[-1]),
            np.append(made.speed[1:], made.speed[-1]),
            np.ones(count),
            nothing,
            nothing,
            nothing,
        ),
    )
    return motion.with_(**changes)


def hidden(made):
    """[s] with jerk, gravity and settling."""
    share = ACCELERATION * (1.0 - SHARE * made.rise)
    jerk = np.full(len(share), JERK)
    return motion_of(made, accelerate=share, decelerate=share, jerk=jerk).duration() + SETTLING * made.stop


def moves(seed=3, count=90, rounded=0.3):
    rng = np.random.default_rng(seed)
    made = program(rng, count, rounded)
    made.blend = np.where(made.stop, 0.0, rng.choice(ZONES, count))
    return made, rng


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made, rng = moves()
    return write(tmp_path_factory.mktemp("named"), made, hidden(made), motion_of(made).duration(), 5e-4, rng)


@pytest.fixture(scope="module")
def outcome(folder) -> DiagnosisOutcome:
    return diagnose_recording(read_recording(folder))


@pytest.fixture(scope="module")
def signature(outcome, folder):
    return signature_of(outcome, read_recording(folder))[0]


@pytest.fixture(scope="module")
def file(signature, tmp_path_factory):
    path = tmp_path_factory.mktemp("file") / "named.json"
    write_signature(signature, path)
    return path


def job_of(made, path: Path) -> Path:
    points = np.vstack([made.start[:1], made.end]) * 1000
    levels = [
        0 if stop else 1 + ZONES.index(blend) for stop, blend in zip(made.stop, made.blend, strict=True)
    ]
    places = [
        f"C{i:05d}={x:.3f},{y:.3f},{z:.3f},180.0000,0.0000,0.0000" for i, (x, y, z) in enumerate(points)
    ]
    flags = ",".join(["0"] * 24)
    head = ["/JOB", "//NAME T", "//POS", f"///NPOS {len(points)},0,0,0,0,0", "///TOOL 0", "///POSTYPE ROBOT"]
    head += ["///RECTAN", f"///RCONF {flags}", *places, "//INST", "///DATE 2026/11/20 10:00", "///ATTR SC,RW"]
    body = ["///GROUP1 RB1", "NOP", "MOVJ C00000 VJ=10.00 PL=0"]
    body += [
        f"MOVL C{i + 1:05d} V={speed * 1000:.1f} PL={level}"
        for i, (speed, level) in enumerate(zip(made.speed, levels, strict=True))
    ]
    path.write_text("\r\n".join([*head, *body, "END", ""]), encoding="ascii", newline="")
    return path


def straight(frame):
    return frame[frame.kind == "linear"]


# --- programs and rows take the time that was diagnosed ---------------------------------------------------------------


def test_a_program_of_the_recorded_moves_takes_the_diagnosed_times(outcome, file, tmp_path):
    assert {f.term for f in outcome.diagnosis.findings} == {"jerk", "gravity", "settling"}
    timed = straight(olp.read(job_of(moves()[0], tmp_path / "T.JBI")).plan(robot=ROBOT).time(signature=file))
    assert len(timed) == len(outcome.predicted)
    np.testing.assert_allclose(timed.duration_s, outcome.predicted, atol=1e-3)


def test_another_program_takes_what_the_hidden_physics_says(signature, tmp_path):
    made, _ = moves(seed=8, count=60, rounded=0.5)
    timed = straight(olp.read(job_of(made, tmp_path / "U.JBI")).plan(robot=ROBOT).time(signature=signature))
    np.testing.assert_allclose(timed.duration_s, hidden(made), atol=3e-3)
    plain = straight(olp.read(tmp_path / "U.JBI").plan(robot=ROBOT).time())
    assert np.abs(plain.duration_s - hidden(made)).mean() > 0.05


def test_rows_of_a_recording_take_the_diagnosed_times_measured_or_not(outcome, signature, folder):
    recording = read_recording(folder)
    blind = replace(recording.moves, duration=np.full(len(recording.moves), np.nan))
    for asked in (recording, replace(recording, moves=blind)):
        rows, told = predict_recording(signature, asked)
        np.testing.assert_allclose(rows.predicted, outcome.predicted, atol=1e-5)
        assert not [d for d in told if d.code in ("H012", "H020")]


def test_nineteen_of_twenty_moves_of_another_recording_are_inside_their_intervals(signature, tmp_path):
    made, rng = moves(seed=8, count=150)
    folder = write(tmp_path / "r", made, hidden(made), motion_of(made).duration(), 5e-4, rng)
    recording = read_recording(folder)
    rows, _ = predict_recording(signature, recording)
    measured = recording.moves.duration
    assert 0.88 <= np.mean((rows.low <= measured) & (measured <= rows.high)) <= 1.0
    # One of five folds does not find gravity by itself, and the spread of unseen moves says so.
    assert np.median(rows.high - rows.low) < 0.1


def test_the_interval_of_the_total_holds_the_sum_and_knows_that_repeats_err_alike(signature, tmp_path):
    made, _ = moves()
    from olp.identification.signature.correction import SignatureCorrection
    from olp.timing.timing import time_plan

    plan = olp.read(job_of(made, tmp_path / "T.JBI")).plan(robot=ROBOT)
    timing = time_plan(plan, learnt=SignatureCorrection(signature))
    assert timing.low_s < hidden(made).sum() < timing.high_s
    lines = (tmp_path / "T.JBI").read_text("ascii").splitlines()
    again = [*lines[:-1], *(line for line in lines if line.startswith("MOVL")), "END", ""]
    (tmp_path / "W.JBI").write_text("\r\n".join(again), encoding="ascii", newline="")
    twice = time_plan(olp.read(tmp_path / "W.JBI").plan(robot=ROBOT), learnt=SignatureCorrection(signature))
    once, both = timing.high_s - timing.total_s, twice.high_s - twice.total_s
    assert both > 1.5 * once


def test_seconds_of_the_controller_that_were_learnt_are_not_added_again(signature, tmp_path):
    made, _ = moves()
    path = job_of(made, tmp_path / "T.JBI")
    alone = straight(olp.read(path).plan(robot=ROBOT).time(signature=signature))
    (tmp_path / "olp.toml").write_text(
        "[motion]\ndispatch_s = 0.1\nservo_lag_s = 0.1\ncycle_s = 0.05\n", "utf-8"
    )
    beside = straight(olp.read(path).plan(robot=ROBOT).time(signature=signature))
    np.testing.assert_allclose(alone.duration_s, beside.duration_s)


def test_an_arc_takes_what_a_line_of_its_length_takes_and_flows_into_the_next(signature, tmp_path):
    # A half circle of 100 mm radius in two quarters, then a line as long as one of them.
    places = ("1000,0,600", "1100,100,600", "1200,0,600", f"1200,{-50 * np.pi:.4f},600")
    head = ["/JOB", "//NAME C", "//POS", "///NPOS 4,0,0,0,0,0", "///TOOL 0", "///POSTYPE ROBOT", "///RECTAN"]
    head += ["///RCONF " + ",".join(["0"] * 24), *(f"C{i:05d}={p},180,-60,0" for i, p in enumerate(places))]
    head += ["//INST", "///DATE 2026/11/20 10:00", "///ATTR SC,RW", "///GROUP1 RB1", "NOP"]
    body = [
        "MOVJ C00000 VJ=10.00 PL=0",
        "MOVC C00000 V=200.0",
        "MOVC C00001 V=200.0 PL=0",
        "MOVC C00002 V=200.0 PL=0",
    ]
    flowing = [line.removesuffix(" PL=0") if line.startswith("MOVC C00001") else line for line in body]
    seconds = []
    for lines in (body, flowing):
        text = "\r\n".join([*head, *lines, "MOVL C00003 V=200.0 PL=0", "END", ""])
        (tmp_path / "C.JBI").write_text(text, encoding="ascii", newline="")
        timed = olp.read(tmp_path / "C.JBI").plan(robot=ROBOT).time(signature=signature)
        seconds.append(timed[timed.distance_mm > 1].duration_s.to_numpy())
    np.testing.assert_allclose(seconds[0], seconds[0][2], atol=1e-4)
    ramp = 0.2 / ACCELERATION
    assert seconds[0][0] - seconds[1][0] == pytest.approx(SETTLING + ramp / 2, abs=0.02)


# --- the file ---------------------------------------------------------------------------------------------------------


def test_the_file_holds_each_parameter_with_unit_and_deviation(file):
    told = json.loads(file.read_text("utf-8"))
    assert told["method"] == "named_terms"
    jerk = told["parameters"]["jerk: jerk"]
    assert jerk["value"] == pytest.approx(JERK, abs=4 * jerk["sd"])
    assert jerk["unit"] == "m/s^3"
    assert told["parameters"]["settling: time"]["value"] == pytest.approx(SETTLING, abs=1e-3)
    assert told["parameters"]["simulation: linear acceleration"]["value"] == ACCELERATION
    held = told["parts"]["terms"]["held_out_percent"]
    assert held["learnt"] < 0.1 * held["unlearnt"]


def test_read_again_it_predicts_the_same(signature, file, folder):
    recording = read_recording(folder)
    one = predict_recording(signature, recording)[0]
    two = predict_recording(read_signature(file), recording)[0]
    np.testing.assert_allclose(one.high, two.high, rtol=1e-9)


@pytest.mark.parametrize("harm", ["terms", "nulls", "jerk: jerk", "simulation: corner law"])
def test_a_file_without_what_a_term_needs_is_refused(file, folder, tmp_path, harm):
    told = json.loads(file.read_text("utf-8"))
    del told["parameters"][harm]
    (tmp_path / "harmed.json").write_text(json.dumps(told), "utf-8")
    with pytest.raises(OlpError) as caught:
        predict_recording(read_signature(tmp_path / "harmed.json"), read_recording(folder))
    assert caught.value.diagnostics[0].code == "H008"


@pytest.mark.parametrize(
    ("name", "value"),
    [("terms", ["jerk", "gravity", "warm"]), ("terms", 3), ("forms", ["a"]), ("nulls", [[], [], []])],
)
def test_a_file_with_other_terms_than_there_are_is_refused(file, tmp_path, name, value, capsys):
    told = json.loads(file.read_text("utf-8"))
    told["parameters"][name]["value"] = value
    (tmp_path / "harmed.json").write_text(json.dumps(told), "utf-8")
    job = str(joint_job(tmp_path / "J.JBI", 1))
    assert main(["time", job, "--robot", ROBOT, "--signature", str(tmp_path / "harmed.json")]) != 0
    says = "".join(capsys.readouterr())
    assert "H008" in says or "N001" in says


# --- every term, alone ------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def mixed(tmp_path_factory):
    """Straight moves, joint moves and loads on a robot that is known."""
    made, rng = moves(seed=5, count=60)
    made.start[:, 2] += 0.3
    made.end[:, 2] += 0.3
    count = len(made.speed)
    more = {
        name: np.full(count, angle)
        for name, angle in (("rx_deg", 180.0), ("ry_deg", -60.0), ("rz_deg", 20.0))
    }
    more |= {
        f"{name}_{end}_deg": more[f"{name}_deg"] + (rng.uniform(-30, 30, count) if end == "end" else 0.0)
        for name in ("rx", "ry", "rz")
        for end in ("start", "end")
    }
    for name in ("rx_deg", "ry_deg", "rz_deg"):
        del more[name]
    more["payload_inertia_kg_m2"] = rng.choice([0.1, 0.5, 2.0], count)
    made.payload = rng.choice([3.0, 5.0, 20.0], count)
    made.more = more
    sim = motion_of(made).duration()
    folder = tmp_path_factory.mktemp("mixed")
    write(folder, made, 1.02 * sim, sim, 5e-4, rng)
    (folder / "recording.toml").write_text(f'robot = "{ROBOT}"\ntime_resolution_s = 0.0001\n', "utf-8")
    return read_recording(folder)


def parts_of(case):
    for name in term_names():
        term = load_term(name)
        if isinstance(term, MoveTerm) and name not in ("clock", "warm-up"):
            for form in term.forms(case):
                yield ModelPart(term, form, np.asarray(term.guesses(form, case)[0]))


def test_every_term_does_in_a_signature_what_it_does_in_a_diagnosis(mixed):
    case = case_of(mixed).case
    base, seen = case.base, set()
    for part in parts_of(case):
        model = DurationModel((part,))
        wanted = model.seconds(case) - (
            0.0 if part.term.name == "cycle-quantisation" else case.simulated - base.duration()
        )
        named = NamedModel(
            model, ACCELERATION, np.nan, base.law, base.overlap, base.split, numbers=case.numbers_used
        )
        again = from_parameters(to_parameters(named, {}))
        assert again.model.parts[0].values.tolist() == part.values.tolist()
        # The first moves alone: what a form refers to is still that of all moves.
        few = 12
        some = replace(mixed, moves=first_of(mixed.moves, few))
        made, rows = case_for(again, some)
        assert rows.tolist() == list(range(few))
        keep = slice(0, few - 1)  # where the last one leads to is not known any more
        np.testing.assert_allclose(
            again.model.seconds(made)[keep], wanted[:few][keep], atol=2e-5, err_msg=part.label
        )
        seen.add(part.term.name)
    assert {
        "payload",
        "payload-inertia",
        "reach-inertia",
        "joint-speed-limit",
        "blending",
        "torque-speed",
    } <= seen


def test_a_term_of_the_axes_is_refused_where_the_axes_are_not_known(mixed, folder, signature):
    case, told = case_of(mixed).case, set()
    plain = read_recording(folder)
    for part in parts_of(case):
        named = NamedModel(DurationModel((part,)), ACCELERATION, np.nan, numbers=case.numbers_used)
        own = replace(signature, parameters=to_parameters(named, {}))
        try:
            predict_recording(own, plain)
        except OlpError as problem:
            told.add((part.term.name, problem.diagnostics[0].code))
    assert {code for _, code in told} == {"H011"}
    names = {name for name, _ in told}
    assert {"joint-speed-limit", "joint-acceleration-limit"} <= names
    assert not names & {"jerk", "settling", "payload", "speed-scale"}


def first_of(moves, count):
    changes = {}
    for name in moves.__slots__:
        value = getattr(moves, name)
        if name not in ("slides", "given", "covariates", "texts") and len(value) == len(moves):
            changes[name] = value[:count]
    changes["covariates"] = {k: v[:count] for k, v in moves.covariates.items()}
    changes["texts"] = {k: v[:count] for k, v in moves.texts.items()}
    return replace(moves, **changes)


# --- joint moves ------------------------------------------------------------------------------------------------------


SHARES, RAMP, STOP = (20.0, 50.0, 100.0), 0.25, 0.08


def joint_job(path: Path, seed: int, count: int = 40) -> Path:
    """Joint moves and straight ones in turn."""
    rng = np.random.default_rng(seed)
    points = np.stack(
        [rng.uniform(900, 1300, count), rng.uniform(-500, 500, count), rng.uniform(300, 800, count)], 1
    )
    turns = np.stack([np.full(count, 180.0), np.full(count, -60.0), np.zeros(count)], 1)
    places = [
        ",".join(f"{v:.3f}" for v in (*point, *turn)) for point, turn in zip(points, turns, strict=True)
    ]
    places = [f"C{i:05d}={place}" for i, place in enumerate(places)]
    head = [
        "/JOB",
        "//NAME J",
        "//POS",
        f"///NPOS {count},0,0,0,0,0",
        "///TOOL 0",
        "///POSTYPE ROBOT",
        "///RECTAN",
    ]
    head += [
        "///RCONF " + ",".join(["0"] * 24),
        *places,
        "//INST",
        "///DATE 2026/11/20 10:00",
        "///ATTR SC,RW",
    ]
    body = ["///GROUP1 RB1", "NOP", "MOVJ C00000 VJ=10.00 PL=0"]
    for k in range(1, count):
        joint = f"VJ={rng.choice(SHARES):.2f}"
        body.append(f"MOVJ C{k:05d} {joint} PL=0" if k % 2 else f"MOVL C{k:05d} V=300.0 PL=0")
    path.write_text("\r\n".join([*head, *body, "END", ""]), encoding="ascii", newline="")
    return path


def joint_recording(folder: Path, seed: int):
    """The plan of a job, and its moves as recorded: each exact stop of a joint move takes longer than simulated."""
    from olp.robots.robot import load_robot

    folder.mkdir()
    robot, rng = load_robot(ROBOT), np.random.default_rng(4)
    plan = olp.read(joint_job(folder / "J.JBI", seed)).plan(robot=ROBOT)
    moves, places = plan.moves, plan.positions
    table = []
    for row in range(len(moves)):
        if moves.start[row] == moves.target[row]:
            continue
        start, end = (places.axes[at[row]][: len(robot.axes)] for at in (moves.start, moves.target))
        one, two = (places.position[at[row]] for at in (moves.start, moves.target))
        line = {f"{axis}_start_mm": v * 1000 for axis, v in zip("xyz", one, strict=True)}
        line |= {f"{axis}_end_mm": v * 1000 for axis, v in zip("xyz", two, strict=True)}
        line |= {f"q{k + 1}_start_deg": v for k, v in enumerate(np.degrees(start))}
        line |= {f"q{k + 1}_end_deg": v for k, v in enumerate(np.degrees(end))}
        if np.isfinite(moves.fraction[row]):
            share = moves.fraction[row]
            lead = (np.abs(end - start) / robot.speeds).max()
            time = lead / share + share * RAMP if lead >= share**2 * RAMP else 2 * np.sqrt(lead * RAMP)
            line |= {"type": "joint", "speed_pct": share * 100}
        else:
            way, speed = np.linalg.norm(two - one), moves.travel[row]
            time = way / speed + speed / ACCELERATION
            line |= {"type": "linear", "speed_mm_s": speed * 1000, "accel_mm_s2": ACCELERATION * 1000}
        real = time + STOP + 5e-4 * rng.normal()
        table.append({"move": row, "sim_s": f"{time:.6f}", "duration_s": f"{real:.4f}", "pl": 0, **line})
    names = list(dict.fromkeys(name for line in table for name in line))
    with (folder / "moves.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(table)
    (folder / "recording.toml").write_text(f'robot = "{ROBOT}"\ntime_resolution_s = 0.0001\n', "utf-8")
    return plan, read_recording(folder)


def test_joint_moves_take_the_diagnosed_times_in_rows_and_in_programs(tmp_path):
    plan, recording = joint_recording(tmp_path / "learnt", 1)
    outcome = diagnose_recording(recording)
    assert outcome.diagnosis.verdict == "explained"
    signature, _ = signature_of(outcome, recording)
    rows, told = predict_recording(signature, recording)
    np.testing.assert_allclose(rows.predicted, outcome.predicted, atol=1e-4)
    assert "H020" not in {d.code for d in told}
    timed = plan.time(signature=signature)
    timed = timed[timed.distance_mm > 0]
    np.testing.assert_allclose(timed.duration_s, outcome.predicted, atol=1e-3)
    other, recorded = joint_recording(tmp_path / "other", 2)
    timed = other.time(signature=signature)
    np.testing.assert_allclose(timed[timed.distance_mm > 0].duration_s, recorded.moves.duration, atol=5e-3)


# --- what cannot be applied -------------------------------------------------------------------------------------------


def with_term(outcome, name, values, form=0):
    """The outcome with one more term in it."""
    term = load_term(name)
    forms = term.forms(outcome.case)
    parts = (ModelPart(term, forms[form], np.array(values)),) if forms else ()
    evidence = outcome.diagnosis.findings[0].evidence
    finding = Finding(name, "", "", {}, (), {}, evidence)
    diagnosis = replace(outcome.diagnosis, findings=(*outcome.diagnosis.findings, finding))
    return outcome._replace(diagnosis=diagnosis, model=DurationModel((*outcome.model.parts, *parts)))


def test_a_clock_and_waits_are_left_out_of_predictions_and_said_so(outcome, signature, folder):
    recording = read_recording(folder)
    for name, values in (("clock", [1.03]), ("external-wait", [])):
        own, told = signature_of(with_term(outcome, name, values), recording)
        assert own.parameters == signature.parameters
        assert [d.message for d in told if d.code == "H041" and d.message.startswith(f"{name}: ")]


def test_a_warm_robot_is_predicted(outcome, signature, folder):
    recording = read_recording(folder)
    warm, told = signature_of(with_term(outcome, "warm-up", [0.1, 20.0]), recording)
    np.testing.assert_allclose(
        predict_recording(warm, recording)[0].predicted,
        predict_recording(signature, recording)[0].predicted,
        atol=1e-9,
    )
    assert any("warm robot" in d.message for d in told)
    colder, _ = signature_of(with_term(outcome, "warm-up", [0.1, 20.0], form=2), recording)
    ratio = (
        predict_recording(colder, recording)[0].predicted
        / predict_recording(signature, recording)[0].predicted
    )
    np.testing.assert_allclose(ratio, 1.1, rtol=1e-6)


@pytest.mark.parametrize("verdict", ["no-mismatch", "unexplained"])
def test_nothing_found_is_no_signature(outcome, folder, verdict):
    blank = outcome._replace(
        diagnosis=replace(outcome.diagnosis, verdict=verdict, findings=()), model=DurationModel()
    )
    with pytest.raises(OlpError) as caught:
        signature_of(blank, read_recording(folder))
    assert caught.value.diagnostics[0].code == "H040"
    assert verdict in caught.value.diagnostics[0].message


def test_a_recorders_fault_alone_is_no_signature(outcome, folder):
    only = with_term(outcome._replace(model=DurationModel()), "clock", [1.03])
    with pytest.raises(OlpError) as caught:
        signature_of(only, read_recording(folder))
    assert caught.value.diagnostics[0].code == "H040"


def test_terms_that_look_alike_are_said_so(outcome, folder):
    alike = replace(outcome.diagnosis, indistinguishable=(("settling", "dispatch"),))
    _, told = signature_of(outcome._replace(diagnosis=alike), read_recording(folder))
    assert any("settling, dispatch" in d.message for d in told)


# --- commands ---------------------------------------------------------------------------------------------------------


def test_the_command_writes_what_olp_time_annotate_and_predict_read(
    folder, outcome, tmp_path, capsys, monkeypatch
):
    monkeypatch.setattr(
        "olp.identification.diagnosis.diagnose.diagnose_recording", lambda recording, robot=None: outcome
    )
    out, made = tmp_path / "s.json", moves()[0]
    assert main(["diagnose", str(folder), "--signature", str(out)]) == 0
    assert "EXPLAINED" in capsys.readouterr().out
    job = str(job_of(made, tmp_path / "T.JBI"))
    assert main(["time", job, "--robot", ROBOT, "--signature", str(out), "--format", "json"]) == 0
    told = json.loads(capsys.readouterr().out)[0]
    assert told["total_s"] == pytest.approx(outcome.predicted.sum(), abs=1e-2)
    assert told["low_s"] < told["total_s"] < told["high_s"]
    assert main(["annotate", job, "--robot", ROBOT, "--signature", str(out)]) == 0
    assert f"{outcome.predicted[0]:.3f}s" in capsys.readouterr().out
    assert main(["predict", str(folder), "--signature", str(out), "-o", str(tmp_path / "p.csv")]) == 0
    with (tmp_path / "p.csv").open(encoding="utf-8") as file:
        rows = [float(row["predicted_s"]) for row in csv.DictReader(file)]
    np.testing.assert_allclose(rows, outcome.predicted, atol=1e-5)
    capsys.readouterr()
    assert main(["signature", "show", str(out)]) == 0
    assert "jerk: jerk" in capsys.readouterr().out


def test_calibrate_learns_the_same_by_the_methods_name(folder, outcome, signature, monkeypatch):
    monkeypatch.setattr("olp.identification.diagnosis.diagnose.diagnose_recording", lambda recording: outcome)
    assert calibrate(read_recording(folder), "named_terms")[0].parameters == signature.parameters


def test_auto_never_takes_it(folder):
    from olp.identification.signature import moves_of_recording

    assert load_estimator("named_terms").needs(moves_of_recording(read_recording(folder))[0], None)
