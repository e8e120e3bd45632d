"""The cases of `bench/third_author`: the same for a seed, read by olp, and scored by their truth alone."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from bench.third_author.arms import ARMS
from bench.third_author.cases import generate
from bench.third_author.cells import make_moves
from bench.third_author.effects import EFFECTS, World
from bench.third_author.plant import seconds
from bench.third_author.scoring import judge, score
from olp.identification.recording import read_recording

pytestmark = pytest.mark.slow


def test_a_seed_gives_the_same_recordings_and_their_answers_are_scored(tmp_path: Path) -> None:
    generate(tmp_path / "one", 5, 2)
    generate(tmp_path / "two", 5, 1)
    first = (tmp_path / "one" / "cases" / "000" / "moves.csv").read_bytes()
    assert first == (tmp_path / "two" / "cases" / "000" / "moves.csv").read_bytes()
    for number in ("000", "001"):
        truth = json.loads((tmp_path / "one" / "truth" / f"{number}.json").read_text())
        assert len(read_recording(tmp_path / "one" / "cases" / number).moves) == truth["moves"]
    table = score(tmp_path / "two")
    assert (tmp_path / "two" / "answers" / "000.json").exists()
    assert table.splitlines()[-1].split()[:2] == ["all", "1"]


def test_a_name_counts_once_and_a_declared_equivalent_counts_as_hidden() -> None:
    truth = {
        "family": "two", "recorder": "white", "noise_s": 0.001, "condition": None, "optional": [],
        "equivalents": {"settling": [], "jerk": []},
        "effects": [{"term": "settling", "numbers": {"time": 0.02}}, {"term": "jerk", "numbers": {}}],
    }  # fmt: skip
    settling = {"term": "dispatch", "parameters": {}, "moves": []}
    jerk = {"term": "jerk", "parameters": {}, "moves": []}
    said = {"verdict": "explained", "findings": [jerk, settling], "fit": {}, "indistinguishable": []}
    assert judge(truth, said)["false"] == ["dispatch"]
    said["indistinguishable"] = [["dispatch", "settling"]]
    row = judge(truth, said)
    assert row["exact"]
    assert row["first"]
    said["findings"] = [settling, settling]
    assert not judge(truth, said)["exact"]


def test_the_command_line_tells_what_it_needs() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "bench.third_author", "generate", "x"], capture_output=True, text=True
    )
    assert done.returncode == 2
    assert "--seed" in done.stderr


def test_dry_friction_makes_no_move_quicker_where_acceleration_builds_up() -> None:
    """What the first ramp loses the last one wins; where neither reaches its acceleration, nothing changes."""
    rng = np.random.default_rng(3)
    world = World(make_moves(rng, ARMS[0], "handling", 100), {}, np.zeros(100))
    slow, _, _ = EFFECTS["jerk"](world, 0.9, world.drive)
    rubbed, _, _ = EFFECTS["coulomb-friction"](world, 0.7, slow)
    late = seconds(rubbed) - seconds(slow)
    assert late.min() > -1e-6
    jerk = slow.rated / np.maximum(slow.build_up, 1e-9)
    least = slow.acceleration * rubbed.up.min(1)
    never = ~world.waits & (slow.speed * jerk < least**2)
    assert never.any()
    assert np.abs(late[never]).max() < 1e-6


def test_no_axis_brakes_harder_because_another_one_holds_less() -> None:
    """Each ramp of a joint move is set by the axis that has least left for it: an axis without weight gains nothing."""
    rng = np.random.default_rng(3)
    moves = make_moves(rng, ARMS[1], "tending", 100)
    world = World(moves, {"planned": 0.0}, np.zeros(100))
    pulled, _, _ = EFFECTS["gravity"](world, 0.7, world.drive)
    column = world.limits[:, 0] / world.limits.min(1)  # what the first axis, which holds nothing, allows
    allowed = column[world.joint, None]
    assert world.joint.any()
    assert (np.concatenate([pulled.up, pulled.down], axis=1)[world.joint] <= allowed + 1e-9).all()
