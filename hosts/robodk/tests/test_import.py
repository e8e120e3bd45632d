"""The import script: the real client of RoboDK talks to a station that speaks its protocol, and keeps its own clock."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import olp_import
import pytest
from olp_station.steps import executed, reached
from station import Server, integrated

import olp

ROOT = Path(__file__).parents[3]
SAMPLES = [
    "inform/handling/HANDLING.JBI",
    "inform/generations/dx200.jbi",
    "krl/handling.src",
    "rapid/handling.mod",
    "tp/handling.ls",
    "urscript/handling.script",
]
ROBOT = "yaskawa/gp25"


def imported(file: str, *options: str) -> tuple[Any, dict[str, Any]]:
    """The station after the script has run as RoboDK runs it, and its one program."""
    path = ROOT / "samples" / file
    with Server() as server:
        done = subprocess.run(
            [sys.executable, olp_import.__file__, str(path), "--robot", ROBOT, *options],
            env={**os.environ, "PYTHONPATH": str(ROOT), "ROBODK_API_PORT": str(server.port)},
            capture_output=True,
            text=True,
        )
    assert done.returncode == 0, done.stderr
    assert "predicted" in done.stdout
    (program,) = server.station.of("program").values()
    return server.station, program


@pytest.mark.parametrize("file", SAMPLES)
def test_the_hosts_own_cycle_time_is_the_predicted_one(file):
    station, program = imported(file)
    predicted = olp.read(ROOT / "samples" / file).plan(robot=ROBOT).time()["duration_s"].sum()
    assert station.cycle_time(program) == pytest.approx(predicted, rel=0.001)
    kept = json.loads(program["params"]["olp"])
    assert kept["total_s"] == pytest.approx(predicted, abs=1e-5)
    assert kept["robot"] == ROBOT


@pytest.mark.parametrize("file", SAMPLES)
def test_targets_stand_where_the_plan_ends_its_moves(file):
    station, program = imported(file)
    plan = olp.read(ROOT / "samples" / file).plan(robot=ROBOT)
    ends = [1000 * step.target for step in plan.steps() if hasattr(step, "target")]
    moves = [
        station.items[words[1]]
        for words in program["instructions"]
        if words[0] in ("joint", "linear", "circular")
    ]
    assert len(moves) == len(ends)
    for target, end in zip(moves, ends, strict=True):
        assert station.placed(target)[:3, 3].tolist() == pytest.approx(end.tolist(), abs=1e-6)


def test_frames_and_tools_have_the_programs_names_and_values():
    station, _ = imported("rapid/handling.mod")
    frames, tools = station.of("frame"), station.of("tool")
    assert {"wTable", "wRack"} <= set(frames)
    assert frames["wTable"]["pose"][:3, 3].tolist() == pytest.approx([850.5, -210.25, 305.75])
    assert tools["tGripper"]["pose"][:3, 3].tolist() == pytest.approx([12.5, -8.25, 187.4], abs=1e-6)
    # R = Rz(30 deg) Ry(15 deg), written out.
    c, s = np.cos(np.radians([15, 30])), np.sin(np.radians([15, 30]))
    turn = [[c[1] * c[0], -s[1], c[1] * s[0]], [s[1] * c[0], c[1], s[1] * s[0]], [-s[0], 0, c[0]]]
    assert np.allclose(tools["tGripper"]["pose"][:3, :3], turn, atol=1e-6)


def test_signals_waits_and_statements_are_in_the_program():
    _, program = imported("krl/handling.src")
    said = program["instructions"]
    assert ("output", "3", "1") in said
    assert ("pause", 0.35) in said
    assert any(words[0] == "comment" and words[1].startswith("38 LIN XP2: 0.") for words in said)
    assert [words for words in said if words[0] == "rounding"] == [("rounding", -1.0)]


def test_corner_radii_are_written_when_asked_for():
    _, program = imported("krl/handling.src", "--rounding")
    assert {"rounding"} < {words[0] for words in program["instructions"]}
    assert ("rounding", 25.0) in program["instructions"]


def test_the_speed_that_was_programmed_is_kept_where_it_can_be():
    run = executed(str(ROOT / "samples" / "inform" / "generations" / "dx200.jbi"))
    kept = [step.motion.speed for step in run.steps if step.motion is not None and step.line == 27]
    assert kept == [pytest.approx(0.27, rel=0.3)]
    for duration, length, speed in (
        (2.0, 1.0, 1.0),
        (5.0, 1.0, 1.0),
        (1.0, 1.0, 1.0),
        (0.5, 1.0, float("nan")),
    ):
        top, acceleration = reached(duration, length, speed)
        assert integrated(length, top, acceleration) == pytest.approx(duration, rel=1e-3)
    assert reached(2.0, 1.0, 1.0)[0] == 1.0


@pytest.mark.parametrize(
    ("file", "says"), [("missing.src", "cannot read"), ("../README.md", "error"), ("krl/broken", "error")]
)
def test_what_cannot_be_read_is_told_and_the_station_is_left_alone(file, says, capsys):
    assert olp_import.main([str(ROOT / "samples" / file)]) == 2
    assert says in capsys.readouterr().err


def test_a_station_without_a_robot_is_told(capsys, monkeypatch):
    with Server() as server:
        del server.station.items[101]
        monkeypatch.setenv("ROBODK_API_PORT", str(server.port))
        assert olp_import.main([str(ROOT / "samples" / SAMPLES[0]), "--robot", ROBOT]) == 2
    assert "no robot in this station" in capsys.readouterr().err
    assert "Add_PROG" not in server.station.commands


def test_further_mechanisms_are_told():
    run = executed(str(ROOT / "samples" / "inform" / "pitfalls" / "two-robots.jbi"))
    assert run.assumptions[0].startswith("only RB1 is imported, without RB2")
