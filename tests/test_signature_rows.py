"""Joint and circular moves, corners and waits with a signature, against a made-up robot whose times are known."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import olp
from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.identification.recording import read_recording
from olp.identification.signature import calibrate, moves_of_recording, read_signature, write_signature
from olp.identification.signature.coefficients import choose, solve
from olp.identification.signature.correction import SignatureCorrection
from olp.identification.signature.file import from_json, to_json, to_text
from olp.identification.signature.rows import predict_recording
from olp.identification.signature.stretch_times import arc_length
from olp.robots.robot import load_robot
from olp.timing.timing import time_plan

ROBOT = load_robot("yaskawa/ma2010")
SLOW, STOP = 0.4, 0.12  # [s²/m], [s] of the made-up robot's straight moves
SCALE, SETTLES = 1.4, 0.08  # of its joint moves
SAVES, LATE = 1.3, 0.05  # what its corners save of the law's time, and what a stretch takes more [s]
HEAD = [
    "move", "duration_s", "type", "x_start_mm", "y_start_mm", "z_start_mm", "x_end_mm", "y_end_mm", "z_end_mm",
    "x_via_mm", "y_via_mm", "z_via_mm", *(f"q{i}_start_deg" for i in range(1, 7)),
    *(f"q{i}_end_deg" for i in range(1, 7)), "rx_deg", "ry_deg", "rz_deg",
    "speed_mm_s", "speed_pct", "pl", "job", "sim_s", "wait_s",
]  # fmt: skip


def recorded(tmp_path, rows, robot=ROBOT.name):
    """A recording of these rows, each a mapping of columns."""
    tmp_path.mkdir(exist_ok=True)
    lines = [",".join(HEAD)]
    for number, row in enumerate(rows, 1):
        cells = {"move": number, **row}
        lines.append(",".join(str(cells.get(name, "")) for name in HEAD))
    (tmp_path / "moves.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    if robot:
        (tmp_path / "recording.toml").write_text(f'robot = "{robot}"\n', encoding="utf-8")
    return read_recording(tmp_path)


def line(start, end, speed, seconds="", level=0, job="A.JBI", kind="linear"):
    names = HEAD[3:9]
    return {
        "type": kind, "duration_s": seconds, "speed_mm_s": speed, "pl": level, "job": job,
        "rx_deg": 180, "ry_deg": 0, "rz_deg": 0, **dict(zip(names, (*start, *end), strict=True)),
    }  # fmt: skip


def straight_time(way, speed, stop=0.0):
    """[s] of a straight move from stop to stop, in mm and mm/s."""
    v, length = speed / 1000, way / 1000
    return length / v + v * SLOW + stop if v * v * SLOW <= length else 2 * math.sqrt(length * SLOW) + stop


def straights(speeds=(250,), stop=0.0, count=12):
    rows = []
    for i in range(count):
        start, way = (1000 + 20 * (i % 4), 300 - 30 * (i % 3), 200), 200 + 25 * i
        speed = speeds[i % len(speeds)]
        taken = straight_time(way, speed, stop)
        rows.append(line(start, (start[0], start[1] - way, 200), speed, taken, job=f"S{i % 3}.JBI"))
    return rows


def joint_time(start, end, percent, scale=SCALE, settles=SETTLES):
    """[s] the slowest axis: one trapezoid or triangle each, axes taken one by one."""
    slowest = 0.0
    for axis, here, there in zip(ROBOT.axes, start, end, strict=True):
        way, speed = abs(math.radians(there - here)), axis.speed * percent / 100
        push = axis.acceleration if axis.acceleration is not None else axis.speed / 0.3
        push /= scale
        cruises = way * push >= speed * speed
        slowest = max(slowest, way / speed + speed / push if cruises else 2 * math.sqrt(way / push))
    return slowest + settles


def turn(start, end, percent, seconds="", job="A.JBI"):
    row = {"type": "joint", "duration_s": seconds, "speed_pct": percent, "pl": 0, "job": job}
    row |= {f"q{i + 1}_start_deg": v for i, v in enumerate(start)}
    return row | {f"q{i + 1}_end_deg": v for i, v in enumerate(end)}


def turns(count=24, seed=1, noise=0.0):
    dice, rows = np.random.default_rng(seed), []
    for i in range(count):
        start, end = (
            np.round(dice.uniform([-60, -20, -30, -40, -60, -90], [60, 30, 30, 40, 0, 90]), 3) for _ in "ab"
        )
        percent = float(dice.choice([20, 50, 100]))
        taken = joint_time(start, end, percent) + noise * dice.normal()
        rows.append(turn(start.tolist(), end.tolist(), percent, taken, f"J{i % 4}.JBI"))
    return rows


def corner_runs(count=10, seconds=True):
    """Pairs of lines with a corner between them; every second one at another level."""
    rows = []
    for i in range(count):
        level, way = (2, 5)[i % 2], 150 + 20 * i
        speed, job = (100, 250)[i % 3 == 0], f"C{i}.JBI"
        at = (1000, 200 - 10 * i, 200 + 5 * i)
        middle, end = (1000, at[1] - way, at[2]), (1000 + way, at[1] - way, at[2])
        zone = min(ROBOT.blend_zones[level - 1] * 1000, way / 2)
        v = speed / 1000
        first = way / speed + v * SLOW / 2 - SAVES * zone / (2 * speed)
        second = way / speed + v * SLOW / 2 + LATE
        rows.append(line(at, middle, speed, first if seconds else "", level, job))
        rows.append(line(middle, end, speed, second if seconds else "", 0, job))
    return rows


def told(diagnostics):
    return {d.code for d in diagnostics}


def test_joint_moves_are_learnt_beside_straight_ones(tmp_path):
    made, says = calibrate(recorded(tmp_path / "a", [*straights(), *turns()]), "constant")
    assert made.arm is not None
    assert made.arm.rows == len(turns())
    assert "H052" in told(says)
    new = turns(20, seed=9)
    asked = recorded(tmp_path / "b", [row | {"duration_s": ""} for row in new])
    rows, notes = predict_recording(made, asked)
    error = np.abs(rows.predicted / [row["duration_s"] for row in new] - 1)
    assert np.median(error) < 0.01
    assert np.max(error) < 0.08
    assert not told(notes) & {"H012", "H020"}


@pytest.mark.slow
def test_held_out_errors_of_joint_moves_make_intervals_that_hold(tmp_path):
    held = {10: [], 38: []}
    asked = turns(100, seed=77, noise=0.03)
    true = np.array([row["duration_s"] for row in asked])
    for count, found in held.items():
        for seed in range(3):
            learnt = [*straights(), *turns(count, seed, noise=0.03)]
            made, _ = calibrate(recorded(tmp_path / "a", learnt), "constant")
            rows, _ = predict_recording(made, recorded(tmp_path / "b", asked))
            found.append(np.mean((rows.low <= true) & (true <= rows.high)))
    assert 0.90 <= np.mean(held[38]) <= 1.0
    assert np.mean(held[10]) >= 0.85


def test_joint_moves_that_were_not_learnt_take_what_olp_time_says_with_a_wide_interval(tmp_path):
    made, _ = calibrate(recorded(tmp_path / "a", straights()), "constant")
    assert not made.parts
    job = tmp_path / "J.JBI"
    job.write_text(joint_job(), encoding="ascii", newline="")
    plan = olp.read(job).plan(ROBOT.name)
    by_time = time_plan(plan)
    axes = np.degrees(plan.positions.axes[plan.moves.target])
    rows = [turn(axes[i].tolist(), axes[i + 1].tolist(), p) for i, p in enumerate((50, 10))]
    said, notes = predict_recording(made, recorded(tmp_path / "b", rows))
    assert said.predicted == pytest.approx(by_time.duration_s[1:], abs=1e-6)
    assert "H020" in told(notes)
    assert "H012" not in told(notes)
    # As wide as the guess: nothing is faster than without acceleration, nothing slower than three times it.
    bare = [joint_time(axes[i], axes[i + 1], p, 1e-9, 0.0) for i, p in enumerate((50, 10))]
    assert said.low == pytest.approx(bare, abs=1e-3)
    assert (said.high - said.predicted >= 2 * (said.predicted - said.low) - 0.4).all()


def joint_job():
    points = ["0,0,0,0,0,0", "20000,15000,-10000,3000,5000,0", "-30000,5000,8000,0,-9000,4000"]
    lines = ["/JOB", "//NAME J", "//POS", "///NPOS 3,0,0,0,0,0", "///TOOL 0", "///POSTYPE PULSE", "///PULSE"]
    lines += [f"C{i:05d}={p}" for i, p in enumerate(points)]
    lines += ["//INST", "///DATE 2026/11/20 10:00", "///ATTR SC,RW", "///GROUP1 RB1", "NOP"]
    lines += ["MOVJ C00000 VJ=5.00 PL=0", "MOVJ C00001 VJ=50.00 PL=0", "MOVJ C00002 VJ=10.00 PL=0", "END", ""]
    return "\r\n".join(lines)


def test_olp_time_uses_the_learnt_joint_moves(tmp_path):
    made, _ = calibrate(recorded(tmp_path / "a", [*straights(), *turns()]), "constant")
    job = tmp_path / "J.JBI"
    job.write_text(joint_job(), encoding="ascii", newline="")
    plan = olp.read(job).plan(ROBOT.name)
    axes = np.degrees(plan.positions.axes[plan.moves.target])
    timing = time_plan(plan, learnt=SignatureCorrection(made))
    wanted = [joint_time(axes[0], axes[1], 50), joint_time(axes[1], axes[2], 10)]
    assert timing.duration_s[1:] == pytest.approx(wanted, rel=0.03)
    assert timing.interval.low[1] < wanted[0] < timing.interval.high[1]
    assert timing.interval.total_high - timing.interval.total_low < 0.3
    unlearnt = time_plan(plan, learnt=SignatureCorrection(replace(made, arm=None)))
    assert unlearnt.interval.total_high - unlearnt.interval.total_low > 0.3


def test_half_the_override_is_half_the_speed(tmp_path):
    signature, _ = calibrate(recorded(tmp_path / "a", straights()), "constant")
    asked, rows = recorded(tmp_path / "b", straights()[:4]), np.full(4, 0.5)
    slower = replace(asked.moves, speed=asked.moves.speed * rows), replace(asked.moves, override=rows)
    slow, same = (predict_recording(signature, replace(asked, moves=moves))[0] for moves in slower)
    assert same.predicted == pytest.approx(slow.predicted, rel=1e-12)
    assert same.high == pytest.approx(slow.high, rel=1e-12)


def test_corners_are_learnt_and_the_next_stretch_takes_what_they_say(tmp_path):
    everything = [*straights(), *corner_runs()]
    made, _ = calibrate(recorded(tmp_path / "a", everything), "constant")
    part = made.parts["corner"]
    assert part.value("saving_scale") == pytest.approx(SAVES, abs=1e-3)
    assert part.value("stretch_time") == pytest.approx(LATE, abs=1e-3)
    assert part.law == "yaskawa"
    new = corner_runs(16)[20:]
    rows, notes = predict_recording(made, recorded(tmp_path / "b", new))
    true = np.array([row["duration_s"] for row in new])
    assert rows.predicted == pytest.approx(true, abs=1e-3)
    assert ((rows.low <= true) & (true <= rows.high)).all()
    assert "H020" not in told(notes)


def test_olp_time_and_olp_predict_say_the_same_of_a_corner(tmp_path):
    made, _ = calibrate(recorded(tmp_path / "a", [*straights(), *corner_runs()]), "constant")
    points = [(1000, 100, 200), (1000, -60, 200), (1180, -60, 200), (1180, 120, 200)]
    speed, level = 200, 3
    ends = zip(points[:-1], points[1:], (level, level, 0), strict=True)
    rows = recorded(tmp_path / "b", [line(a, b, speed, "", pl) for a, b, pl in ends])
    said, _ = predict_recording(made, rows)
    lines = ["/JOB", "//NAME C", "//POS", "///NPOS 4,0,0,0,0,0", "///TOOL 0", "///POSTYPE ROBOT"]
    lines += ["///RECTAN", "///RCONF 0,0,0,0,0,0,0,0"]
    lines += [
        f"C{i:05d}={x:.3f},{y:.3f},{z:.3f},180.0000,0.0000,0.0000" for i, (x, y, z) in enumerate(points)
    ]
    lines += ["//INST", "///DATE 2026/11/20 10:00", "///ATTR SC,RW", "///GROUP1 RB1", "NOP"]
    lines += [
        "MOVJ C00000 VJ=5.00 PL=0",
        f"MOVL C00001 V={speed}.0 PL={level}",
        f"MOVL C00002 V={speed}.0 PL={level}",
    ]
    lines += [f"MOVL C00003 V={speed}.0 PL=0", "END", ""]
    (tmp_path / "C.JBI").write_text("\r\n".join(lines), encoding="ascii", newline="")
    timing = time_plan(olp.read(tmp_path / "C.JBI").plan(ROBOT.name), learnt=SignatureCorrection(made))
    assert timing.duration_s[1:] == pytest.approx(said.predicted, abs=1e-6)
    assert timing.interval.low[1:] == pytest.approx(said.low, abs=1e-6)
    assert timing.interval.high[1:] == pytest.approx(said.high, abs=1e-6)
    assert timing.interval.total_low <= timing.total_s <= timing.interval.total_high


def test_corners_that_were_not_learnt_follow_the_law_with_a_wide_interval(tmp_path):
    made, _ = calibrate(recorded(tmp_path / "a", straights()), "constant")
    rows = corner_runs(1, seconds=False)
    said, notes = predict_recording(made, recorded(tmp_path / "b", rows))
    way, v = 150, 0.25
    zone = min(ROBOT.blend_zones[1] * 1000, way / 2)
    assert said.predicted[0] == pytest.approx(way / 250 + v * SLOW / 2 - zone / 500, abs=1e-4)
    assert said.predicted[1] == pytest.approx(way / 250 + v * SLOW / 2, abs=1e-4)
    assert said.low[0] <= said.predicted[0] - v * SLOW / 2
    assert "H020" in told(notes)


def test_a_move_that_begins_in_a_corner_is_not_learnt_as_from_stop_to_stop(tmp_path):
    recording = recorded(tmp_path / "a", [*straights(), *corner_runs(6)])
    _, rows = moves_of_recording(recording)
    assert rows.tolist() == list(range(12))
    apart = [
        row | {"x_start_mm": row["x_start_mm"] + 5} if i % 2 else row for i, row in enumerate(corner_runs(4))
    ]
    _, rows = moves_of_recording(recorded(tmp_path / "b", apart))
    assert rows.tolist() == [1, 3, 5, 7]


def test_circular_moves_take_their_arc_with_the_acceleration_of_the_signature(tmp_path):
    made, _ = calibrate(recorded(tmp_path / "a", straights()), "constant")
    radius, speed = 150, 200
    arc = line((1000, 150, 200), (1000, -150, 200), speed, kind="circular")
    arc |= {"x_via_mm": 1150, "y_via_mm": 0, "z_via_mm": 200}
    said, notes = predict_recording(made, recorded(tmp_path / "b", [arc]))
    assert said.predicted[0] == pytest.approx(straight_time(math.pi * radius, speed), abs=1e-4)
    assert said.low[0] < said.predicted[0] < said.high[0]
    assert said.high[0] - said.predicted[0] >= speed / 1000 * SLOW - 1e-6
    assert "H020" in told(notes)


def test_circular_moves_that_were_recorded_correct_the_next(tmp_path):
    def arc(radius, speed, job):
        row = line((1000, radius, 200), (1000, -radius, 200), speed, kind="circular", job=job)
        taken = straight_time(math.pi * radius, speed) + 0.2
        return row | {"x_via_mm": 1000 + radius, "y_via_mm": 0, "z_via_mm": 200, "duration_s": taken}

    arcs = [arc(100 + 15 * i, 250, f"K{i % 3}.JBI") for i in range(8)]
    made, _ = calibrate(recorded(tmp_path / "a", [*straights(), *arcs]), "constant")
    new = arc(137, 250, "N.JBI")
    said, notes = predict_recording(made, recorded(tmp_path / "b", [new | {"duration_s": ""}]))
    assert said.predicted[0] == pytest.approx(new["duration_s"], abs=2e-3)
    assert said.high[0] - said.low[0] < 0.1
    assert "H020" not in told(notes)


def test_the_length_of_an_arc_is_that_of_many_short_chords():
    dice = np.random.default_rng(2)
    for _ in range(20):
        centre, first, second = dice.normal(size=(3, 3))
        u = first / np.linalg.norm(first)
        w = second - u * (second @ u)
        w /= np.linalg.norm(w)
        swept, radius = dice.uniform(0.2, 6.0), dice.uniform(0.05, 2.0)
        angles = np.linspace(0, swept, 20001)[:, None]
        way = centre + radius * (np.cos(angles) * u + np.sin(angles) * w)
        walked = np.linalg.norm(np.diff(way, axis=0), axis=1).sum()
        assert arc_length(way[:1], way[[6000]], way[-1:])[0] == pytest.approx(walked, rel=1e-6)


def test_waits_take_their_programmed_time_and_never_their_measured_one(tmp_path):
    made, _ = calibrate(recorded(tmp_path / "a", straights()), "constant")
    rows = [
        {"type": "wait", "duration_s": 9, "wait_s": 1.5},
        {"type": "wait", "duration_s": 9, "sim_s": 0.75},
    ]
    rows.append({"type": "wait", "duration_s": 9})
    said, notes = predict_recording(made, recorded(tmp_path / "b", rows))
    assert said.predicted[:2].tolist() == [1.5, 0.75]
    assert np.isnan(said.predicted[2])
    assert "H012" in told(notes)


def test_a_cell_is_empty_only_where_nothing_can_be_said(tmp_path, capsys):
    made, _ = calibrate(recorded(tmp_path / "a", straights(), robot=""), "constant")
    write_signature(made, tmp_path / "s.json")
    speedless = line((1000, 0, 200), (1000, 100, 200), "")
    pose = [0, 10, -10, 0, -40, 0]
    rows = [speedless, turn(pose, [10, 10, -10, 0, -40, 0], 50), turn(pose, [20, 0, 0, 0, 0, 0], "")]
    recorded(tmp_path / "b", rows, robot="")
    out = tmp_path / "o.csv"
    assert (
        main(["predict", str(tmp_path / "b"), "--signature", str(tmp_path / "s.json"), "-o", str(out)]) == 0
    )
    assert out.read_text(encoding="utf-8").splitlines()[1:] == ["1,,,", "2,,,", "3,,,"]
    assert "H012" in capsys.readouterr().err
    recorded(tmp_path / "b", rows)
    assert (
        main(["predict", str(tmp_path / "b"), "--signature", str(tmp_path / "s.json"), "-o", str(out)]) == 0
    )
    filled = [bool(text.split(",")[1]) for text in out.read_text(encoding="utf-8").splitlines()[1:]]
    assert filled == [False, True, False]


def test_points_and_joints_of_a_row_tell_each_other(tmp_path):
    from olp.robots.geometry import angles_from_rotation
    from olp.robots.kinematics import forward, inverse

    made, _ = calibrate(recorded(tmp_path / "a", [*straights(), *turns()]), "constant")
    ends = np.radians([[5, 10, -10, 3, -40, 8], [25, -10, 5, -6, -60, 4]])
    place, rotation = forward(ROBOT, ends)
    ends = inverse(ROBOT, place, rotation)[0]  # the posture that a pose without one is read as
    angles = np.degrees(angles_from_rotation(rotation))
    joints = turn(*np.degrees(ends).tolist(), 50)
    names = [f"{a}_{e}" for e in ("start", "end") for a in ("x", "y", "z")]
    cells = {f"{n}_mm": v for n, v in zip(names, (place * 1000).reshape(-1), strict=True)}
    turned = {f"r{n}_deg": v for n, v in zip(names, angles.reshape(-1), strict=True)}
    header = [*HEAD[:-6], *turned, "speed_mm_s", "speed_pct", "pl"]
    posed = {k: v for k, v in joints.items() if not k.startswith("q")} | cells | turned
    text = [",".join(["move", *header[1:]])]
    text.append(",".join(str({"move": 1, **joints}.get(n, "")) for n in header))
    text.append(",".join(str({"move": 2, **posed}.get(n, "")) for n in header))
    text[0] = ",".join(header)
    straight = {k: v for k, v in joints.items() if k != "speed_pct"} | {"type": "linear", "speed_mm_s": 250}
    text.append(",".join(str({"move": 3, **straight}.get(n, "")) for n in header))
    (tmp_path / "moves.csv").write_text("\n".join(text) + "\n", encoding="utf-8")
    (tmp_path / "recording.toml").write_text(f'robot = "{ROBOT.name}"\n', encoding="utf-8")
    said, _ = predict_recording(made, read_recording(tmp_path))
    assert said.predicted[1] == pytest.approx(said.predicted[0], abs=1e-6)
    way = np.linalg.norm(place[1] - place[0]) * 1000
    assert said.predicted[2] == pytest.approx(straight_time(way, 250), abs=1e-4)


def test_several_speeds_tell_what_a_stop_costs_at_any_speed(tmp_path):
    made, _ = calibrate(recorded(tmp_path / "a", straights((50, 150, 450), STOP, 18)), "constant")
    assert made.parts["stop"].value("fixed_time") == pytest.approx(STOP, abs=2e-3)
    asked = line((1000, 100, 200), (1000, -200, 200), 300)
    said, _ = predict_recording(made, recorded(tmp_path / "b", [asked]))
    assert said.predicted[0] == pytest.approx(straight_time(300, 300, STOP), abs=3e-3)
    alone, _ = calibrate(recorded(tmp_path / "c", straights((250,), STOP, 18)), "constant")
    assert not alone.parts


def test_a_file_with_parts_says_the_same_again_and_an_older_olp_refuses_it(tmp_path):
    made, _ = calibrate(recorded(tmp_path / "a", [*straights(), *turns(), *corner_runs()]), "constant")
    write_signature(made, tmp_path / "s.json")
    again = read_signature(tmp_path / "s.json")
    assert to_text(again) == to_text(made)
    rows = recorded(tmp_path / "b", [*turns(3, seed=4), *corner_runs(3)])
    assert predict_recording(again, rows)[0].high == pytest.approx(
        predict_recording(made, rows)[0].high, abs=1e-6
    )
    assert to_json(made)["version"] == 7
    assert to_json(replace(made, arm=None, paths=None))["version"] == 2
    assert to_json(replace(made, arm=None, paths=None, parts={}))["version"] == 1


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("corner", "quantities", "saving_scale", "value"), -1),
        (("corner", "quantities", "saving_scale", "value"), None),
        (("corner", "quantities"), {}),
        (("corner", "longest_s"), 0),
        (("spline",), {}),
        (("corner", "errors_s", "own"), -2),
    ],
)
def test_parts_that_cannot_be_are_refused(tmp_path, path, value):
    made, _ = calibrate(recorded(tmp_path / "a", [*straights(), *corner_runs()]), "constant")
    content = json.loads(to_text(made))
    place = content["parts"]
    for name in path[:-1]:
        place = place[name]
    place[path[-1]] = value
    with pytest.raises(OlpError) as caught:
        from_json(content)
    assert caught.value.diagnostics[0].code == "H008"


def test_what_a_controller_adds_to_a_stop_is_not_added_to_a_measured_time(tmp_path):
    made, _ = calibrate(recorded(tmp_path / "a", [*straights(), *turns()]), "constant")
    job = tmp_path / "J.JBI"
    job.write_text(joint_job(), encoding="ascii", newline="")
    plan = olp.read(job).plan(ROBOT.name)
    settings = {"servo_lag_s": 0.5, "dispatch_s": 0.3, "cycle_s": 0.7}
    slow = replace(plan, settings={**plan.settings, **settings})
    assert time_plan(slow, learnt=SignatureCorrection(made)).duration_s[1:] == pytest.approx(
        time_plan(plan, learnt=SignatureCorrection(made)).duration_s[1:], abs=1e-9
    )
    assert time_plan(slow).total_s > time_plan(plan).total_s + 1


def test_one_wrong_reading_does_not_move_the_fit_and_nothing_is_learnt_from_nothing():
    x = np.linspace(1, 3, 30)
    measured = 2 * x + 0.5
    measured[7] += 40
    start, lowest = np.array([1.0, 0.0]), np.array([0.0, -9.0])
    found = solve(lambda q: q[0] * x + q[1], start, (0, 1), measured, lowest)
    assert found.values == pytest.approx([2, 0.5], abs=1e-3)
    plain = x + 0.01 * np.random.default_rng(0).normal(size=30)
    forms = ((), (0,), (1,), (0, 1))
    assert choose(lambda q: q[0] * x + q[1], start, forms, plain, np.arange(30) % 10, lowest).form == ()
    assert choose(lambda q: q[0] * x + q[1], start, forms, plain + 1, np.arange(30) % 10, lowest).form == (1,)


def test_errors_of_held_out_rows_do_not_see_their_own_row():
    x = np.ones(10)
    measured = np.arange(10.0)
    lowest = np.array([-9.0])
    found = choose(lambda q: q[0] * x, np.zeros(1), ((0,),), measured, np.arange(10), lowest)
    for row in range(10):
        rest = np.delete(np.arange(10), row)
        alone = solve(lambda q, r=rest: q[0] * x[r], np.zeros(1), (0,), measured[rest], lowest)
        assert found.errors[row] == pytest.approx(measured[row] - alone.values[0], abs=1e-9)


@pytest.mark.slow
def test_a_total_of_joint_moves_is_as_unsure_as_their_held_out_errors_add_up(tmp_path):
    made, _ = calibrate(recorded(tmp_path / "a", [*straights(), *turns(40, noise=0.05)]), "constant")
    job = tmp_path / "J.JBI"
    there, back = "MOVJ C00001 VJ=50.00 PL=0", "MOVJ C00000 VJ=50.00 PL=0"
    halves = []
    for times in (1, 4):
        text = joint_job().replace(
            "MOVJ C00002 VJ=10.00 PL=0", "\r\n".join([back, *[there, back] * (times - 1)])
        )
        job.write_text(text, encoding="ascii", newline="")
        found = time_plan(olp.read(job).plan(ROBOT.name), learnt=SignatureCorrection(made)).interval
        halves.append((found.total_high - found.total_low) / 2)
    # Two moves, each with an error of its own; run four times, both errors come four times.
    assert 0.5 * 0.05 < halves[0] < 6 * 0.05
    assert halves[1] == pytest.approx(4 * halves[0], rel=1e-6)


def test_a_path_that_mostly_turns_the_tool_takes_the_time_of_the_wrist(tmp_path):
    made, _ = calibrate(recorded(tmp_path / "a", straights()), "constant")
    text = "move,duration_s,type,x_start_mm,y_start_mm,z_start_mm,x_end_mm,y_end_mm,z_end_mm,rx_start_deg,ry_start_deg,"
    text += "rz_start_deg,rx_end_deg,ry_end_deg,rz_end_deg,speed_mm_s,pl\n"
    text += "1,,linear,1000,0,200,1000,20,200,180,0,0,180,0,90,500,0\n"
    text += "2,,linear,1000,0,200,1000,0,200,180,0,0,180,0,90,500,0\n"
    text += "3,,linear,1000,0,200,1000,0,200,180,0,0,180,0,0,500,0\n"
    text += "4,,linear,1000,0,200,1000,200,200,180,0,0,180,0,1,500,0\n"
    (tmp_path / "moves.csv").write_text(text, encoding="utf-8")
    (tmp_path / "recording.toml").write_text(f'robot = "{ROBOT.name}"\n', encoding="utf-8")
    said, notes = predict_recording(made, read_recording(tmp_path))
    rated = min(axis.speed for axis in ROBOT.axes[3:6])
    known = [axis.acceleration for axis in ROBOT.axes[3:6] if axis.acceleration is not None]
    push = min(known, default=rated / 0.3)
    way = math.pi / 2
    cruises = way * push >= rated**2
    turned = way / rated + rated / push if cruises else 2 * math.sqrt(way / push)
    assert said.predicted == pytest.approx([turned, turned, 0.0, straight_time(200, 500)], abs=1e-4)
    assert (said.low <= said.predicted).all()
    assert (said.high[:2] > said.predicted[:2] + 0.3).all()
    assert "H020" in told(notes)
