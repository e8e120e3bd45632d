"""The blind proof's own machinery: the same seed makes the same cases, olp reads them, and the scorer can tell."""

import json
from pathlib import Path

import numpy as np
import pytest

from bench.concealed import fake
from bench.concealed.arms import forward, inverse, random_arm
from bench.concealed.cases import Case, make, schedule
from bench.concealed.effects import Hidden, _warming
from bench.concealed.families import FAMILIES
from bench.concealed.files import write
from bench.concealed.judge import judge
from bench.concealed.logs import make_log, write_log
from bench.concealed.player import Drive
from bench.concealed.programs import GRID
from bench.concealed.tables import figures
from olp.identification.recording import read_recording
from olp.robots.kinematics import forward as library_forward
from olp.robots.robot import load_robot

pytestmark = pytest.mark.slow

SAMPLE = [
    ("one", 4),
    ("none", 0),
    ("cancelled", 1),
    ("rare", 2),
    ("confounded", 0),
    ("outside", 1),
    ("noise", 2),
]


@pytest.fixture(scope="module")
def cases() -> list[Case]:
    return [make(11, 0, family, turn) for family, turn in SAMPLE]


def test_the_same_seed_makes_the_same_case(cases: list[Case]) -> None:
    again = make(11, 0, *SAMPLE[0])
    assert again.answer == cases[0].answer
    np.testing.assert_array_equal(again.measured, cases[0].measured)
    other = make(12, 0, *SAMPLE[0])
    assert len(other.measured) != len(again.measured) or (other.measured != again.measured).any()


def test_every_recording_is_read_without_a_complaint(cases: list[Case], tmp_path: Path) -> None:
    for case in cases:
        recording = read_recording(write(case, tmp_path / case.name))
        assert not recording.diagnostics, (case.name, recording.diagnostics)
        np.testing.assert_allclose(recording.moves.duration, case.measured, atol=1e-4)
        assert np.isfinite(recording.moves.sim).all()


def test_the_answer_is_outside_the_recording(cases: list[Case], tmp_path: Path) -> None:
    place = write(cases[0], tmp_path)
    assert {p.name for p in place.iterdir()} <= {"moves.csv", "recording.toml", "robot.toml"}
    header = (place / "moves.csv").read_text().splitlines()[0].split(",")
    assert "real_s" not in header
    assert json.loads((tmp_path / "sealed" / f"{cases[0].name}.json").read_text())["required"] == ["payload"]


def test_nothing_hidden_leaves_nothing_but_noise(cases: list[Case]) -> None:
    none = cases[1]
    gap = none.measured - none.simulated
    assert abs(gap).max() < 6 * none.noise


def test_a_tuned_simulation_is_right_on_the_mean_only(cases: list[Case]) -> None:
    tuned = cases[2]
    gap = tuned.real - tuned.simulated
    assert abs(gap.mean()) < 0.02 * np.abs(gap).mean()
    assert np.sqrt(np.mean(gap**2)) > tuned.noise
    assert {"acceleration", "gravity"} <= set(tuned.answer["hidden"])


def test_a_rare_effect_leaves_most_moves_alone(cases: list[Case]) -> None:
    rare = cases[3]
    acts = rare.answer["moves"][rare.answer["required"][0]]["acts"]
    assert 4 <= len(acts) < 0.3 * len(rare.real)


def test_stepped_moves_take_the_time_that_mechanics_says() -> None:
    length, speed = np.array([0.5, 0.02, 1.0]), np.array([0.5, 1.0, 0.2])
    most, one, flat = 2.0, np.ones((3, GRID)), np.zeros((3, GRID, 6))
    free = np.full(6, np.inf)
    drive = Drive(
        length,
        speed,
        most * one,
        most * one,
        np.full(3, np.inf),
        0 * one,
        1.0,
        np.zeros(3),
        flat,
        flat,
        free,
        free,
    )
    cruising = length * most > speed**2
    expected = np.where(cruising, length / speed + speed / most, 2 * np.sqrt(length / most))
    np.testing.assert_allclose(drive.times(), expected, atol=1e-9)
    drive.fastest = np.full(6, 1e3)  # the sweep along the path in place of legs in time
    np.testing.assert_allclose(drive.times(), expected, atol=2e-3)
    drive.fastest, drive.jerk = free, np.full(3, 20.0)
    ramped = length / speed + speed / most + most / 20.0
    np.testing.assert_allclose(drive.times()[[0, 2]][0], ramped[0], atol=1e-9)


def test_the_arm_of_a_case_is_the_arm_of_its_robot_file(cases: list[Case], tmp_path: Path) -> None:
    case = next(c for c in cases if (write(c, tmp_path) / "robot.toml").is_file())
    arm = case.world.moves.arm
    q = np.array([[0.3, 0.2, -0.1, 0.4, -1.0, 0.7], [-1.0, 0.5, 0.2, -0.4, -0.5, 0.1]])
    place, turn = forward(arm, q)
    ours = place - arm.tool * turn[..., 2]
    theirs, frame = library_forward(load_robot(str(tmp_path / "cases" / case.name / "robot.toml")), q)
    np.testing.assert_allclose(ours, theirs, atol=1e-8)
    np.testing.assert_allclose(turn, frame, atol=1e-8)
    np.testing.assert_allclose(inverse(arm, place, turn), q, atol=1e-9)


def test_links_and_mass_matrix_agree_on_the_weight_of_the_load() -> None:
    from bench.concealed.arms import mass_and_gravity

    arm = random_arm(np.random.default_rng(3))
    q = np.array([[0.2, 0.4, 0.1, 0.3, -1.2, 0.2]])
    _, bare = mass_and_gravity(arm, q)
    _, laden = mass_and_gravity(arm, q, payload=10.0)
    step = 1e-6
    rise = np.array(
        [(forward(arm, q + step * row)[0] - forward(arm, q)[0])[0, 2] / step for row in np.eye(6)]
    )
    np.testing.assert_allclose((laden - bare)[0], 10.0 * 9.81 * rise, atol=1e-2)


def test_a_log_shows_the_friction_that_was_hidden(tmp_path: Path) -> None:
    case = make_log(11, 5, "log-one", 0)
    recording = read_recording(write_log(case, tmp_path))
    assert recording.log is not None
    n = min(len(case.real_log["t_s"]), len(case.sim_log["t_s"]))
    if len(case.real_log["t_s"]) == len(case.sim_log["t_s"]):
        gap = case.real_log["tau1_nm"][:n] - case.sim_log["tau1_nm"][:n]
        speed = np.radians(case.sim_log["qd1_deg_s"][:n])
        slope = gap @ speed / (speed @ speed)
        truth = case.answer["parameters"]["viscous-friction"]["viscous_1"]["value"]
        assert slope == pytest.approx(truth, rel=0.1)


def _scores(kind: str, cases: list[Case]) -> dict[str, str]:
    judged = [judge(c.name, fake.diagnosis(kind, c.answer), c.answer, 0.0, "") for c in cases]
    return {what: measured for what, _, measured, _ in figures(judged)}


def test_who_knows_the_answers_scores_all_and_who_guesses_does_not(cases: list[Case]) -> None:
    oracle, jerk, nothing = (_scores(kind, cases) for kind in ("oracle", "jerk", "nothing"))
    for figure in ("cancelled: right", "confounded: right", "rare: right", "one effect, size ≥ 2: exact"):
        assert oracle[figure].startswith("100.0")
        assert jerk[figure].startswith("0.0")
        assert nothing[figure].startswith("0.0")
    assert oracle["nothing hidden: a false name"].startswith("0.0")
    assert jerk["nothing hidden: a false name"].startswith("100.0")
    assert oracle["outside the list: unexplained, no name"].startswith("100.0")
    assert nothing["outside the list: unexplained, no name"].startswith("0.0")


def test_a_lucky_guess_among_equals_counts_only_when_it_says_so() -> None:
    answer = {
        "family": "poor", "required": ["settling"], "allowed": [], "hidden": ["settling"], "noise_floor_s": 1e-3,
        "same": {"settling": ["dispatch"]}, "near": {}, "size": {"settling": 4.0}, "parameters": {},
        "moves": {"settling": {"acts": [1], "little": []}},
    }  # fmt: skip
    said = {"findings": [{"term": "dispatch", "parameters": {}, "moves": [1]}], "indistinguishable": []}
    silent = judge("x", said, answer, 0.0, "")
    assert silent.wrong == ["dispatch"]
    assert silent.undeclared == ["dispatch"]
    told = judge("x", said | {"indistinguishable": [["settling", "dispatch"]]}, answer, 0.0, "")
    assert told.exact
    assert told.first
    everything = judge(
        "x", said | {"indistinguishable": [["settling", "dispatch", "gravity"]]}, answer, 0.0, ""
    )
    assert everything.wide == ["dispatch"]


def test_one_name_stands_for_two_where_it_is_declared_the_same_law_as_a_plainer_one_beside_the_other() -> (
    None
):
    answer = {
        "family": "fudged", "required": ["acceleration", "payload"], "allowed": [], "hidden": [],
        "noise_floor_s": 1e-3, "same": {}, "near": {}, "size": {"acceleration": 4.0, "payload": 4.0}, "parameters": {},
        "moves": {},
    }  # fmt: skip
    finding = {"term": "payload", "parameters": {}, "moves": [1]}
    for beside, exact in ((True, True), (False, False)):
        other = {"term": "acceleration", "delta_bic": 0.0, "beside": beside}
        said = {
            "findings": [finding | {"alternatives": [other]}],
            "indistinguishable": [["payload", "acceleration"]],
        }
        assert judge("x", said, answer, 0.0, "").exact == exact


def test_a_step_of_all_durations_is_a_scale_from_a_time_on_and_nothing_else() -> None:
    answer = {
        "family": "outside", "required": [], "allowed": [], "hidden": [], "noise_floor_s": 1e-3, "same": {}, "near": {},
        "size": {"outside": 4.0}, "parameters": {}, "moves": {}, "confounded_with": "step", "simulation": {},
    }  # fmt: skip
    for note, term, condition, right in (
        ("step", "speed-scale", "time > 40 s", True), ("step", "speed-scale", None, False),
        ("step", "acceleration", "time > 40 s", False), ("walk", "speed-scale", "time > 40 s", False),
    ):  # fmt: skip
        said = {"findings": [{"term": term, "condition": condition, "moves": [1]}], "verdict": "explained"}
        (row,) = (
            r
            for r in figures([judge("x", said, answer | {"confounded_with": note}, 0.0, "")])
            if "outside" in r[0]
        )
        assert row[2].startswith("100.0" if right else "0.0")


def test_an_answer_that_contradicts_its_own_numbers_is_counted() -> None:
    answer = {
        "family": "none", "required": [], "allowed": [], "hidden": [], "noise_floor_s": 1e-3, "same": {}, "near": {},
        "size": {}, "parameters": {}, "moves": {}, "simulation": {},
    }  # fmt: skip
    evidence = {"heldout_rmse_before_s": 0.002, "heldout_rmse_after_s": 0.002}
    idle = {"term": "jerk", "moves": [1], "evidence": evidence}
    for verdict, left, findings, count in (
        ("no-mismatch", 0.0019, [], 0), ("no-mismatch", 0.0021, [], 1), ("explained", 0.0016, [idle], 2),
        ("unexplained", 0.1, [], 0), ("not-judged", 0.0, [idle], 2),
    ):  # fmt: skip
        said = {
            "verdict": verdict,
            "findings": findings,
            "data": {"noise_floor_s": 0.001},
            "unexplained": {"rmse_s": left},
        }
        assert len(judge("x", said, answer, 0.0, "").contradictions) == count


def test_a_timer_is_not_slower_cold() -> None:
    times = _warming(np.array([1.0, 1.0]), np.array([True, False]), Hidden("warm-up", 0.1, choice=100.0))
    assert times.tolist() == [1.1, 1.0]


def test_any_first_part_of_the_schedule_has_all_families_in_their_shares() -> None:
    for count in (136, 400):
        families = [family for _, (family, _) in schedule(count)]
        for family, share in FAMILIES.items():
            assert abs(families.count(family) - count * share / sum(FAMILIES.values())) < 2
