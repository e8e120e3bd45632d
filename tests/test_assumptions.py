"""olp.toml: what is in it, where it is found, and what is said when it is wrong."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from olp.__main__ import main
from olp.ir.expressions import Store
from olp.ir.points import PointKind
from olp.runtime.assumptions import (
    SignalKey,
    load_assumptions,
    nearest_assumptions,
    signal_key,
    signal_name,
    variable_key,
)

SAMPLES = Path(__file__).parent.parent / "samples"
FULL = """\
robot = "yaskawa/ma2010"

[robots]
BS1 = "track.toml"
st1 = "table.toml"

[inputs]
"IN#(12)" = true
"IG#(3)" = [7, 9]
"in 4" = [false, true]

[variables]
B010 = 3
R001 = 2
S002 = "LEFT"
P020 = { pulse = [1200, -3400, 560, 0, 780, 90], tool = 1 }
P021 = { pose_mm_deg = [812.5, -33.1, 207.5, 180, 0, -30], user = 4, tool = 2 }
BP005 = { joint_deg = [90.0] }

[waits]
default_s = 0.25
pause_s = 4
"IN#(5)" = 1.2

[process]
arcon_s = 0.35
ARCOF_s = 0.5

[start]
RB1 = { pulse = [0, 0, 0, 0, -90000, 0] }

[motion]
model = "linear"
accel_mm_s2 = 2500
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "olp.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_every_key_is_read_in_si(tmp_path: Path) -> None:
    found = load_assumptions(written(tmp_path, FULL))
    assert not found.diagnostics
    assert found.robot == "yaskawa/ma2010"
    assert found.robots == {"BS1": "track.toml", "ST1": "table.toml"}
    assert found.inputs == {
        SignalKey("in", 12): (1,),
        SignalKey("in-group", 3): (7, 9),
        SignalKey("in", 4): (0, 1),
    }
    assert found.variables[(Store.BYTE, 10)] == 3
    assert found.variables[(Store.REAL, 1)] == 2.0
    assert found.variables[(Store.STRING, 2)] == "LEFT"
    assert (found.default_wait, found.pause, found.waits) == (0.25, 4.0, {SignalKey("in", 5): 1.2})
    assert found.process == {"arcon": 0.35, "arcof": 0.5}
    assert found.motion == {"model": "linear", "accel_mm_s2": 2500.0}


def test_positions_say_what_their_numbers_are(tmp_path: Path) -> None:
    found = load_assumptions(written(tmp_path, FULL))
    pulse = found.variables[(Store.ROBOT, 20)]
    assert isinstance(pulse, tuple)
    assert (pulse.state.kind, pulse.state.tool, pulse.values[1]) == (PointKind.PULSE, 1, -3400.0)
    pose = found.variables[(Store.ROBOT, 21)]
    assert isinstance(pose, tuple)
    assert (pose.state.kind, pose.state.frame, pose.state.user, pose.state.tool) == (
        PointKind.POSE,
        "user",
        4,
        2,
    )
    assert pose.values == pytest.approx((0.8125, -0.0331, 0.2075, math.pi, 0.0, -math.pi / 6))
    joint = found.variables[(Store.BASE, 5)]
    assert isinstance(joint, tuple)
    assert joint.values == pytest.approx((math.pi / 2,))
    assert found.start["RB1"].values[4] == -90000.0


def test_an_empty_file_says_nothing(tmp_path: Path) -> None:
    found = load_assumptions(written(tmp_path, ""))
    assert (found.robot, found.default_wait, found.pause, found.diagnostics) == ("", None, None, ())


@pytest.mark.parametrize(
    ("text", "code", "line", "help_text"),
    [
        ("robbot = 'x'\n", "V003", 1, "did you mean robot?"),
        ("\n[wait]\ndefault_s = 1\n", "V003", 2, "did you mean waits?"),
        ("[waits]\ndefault = 1\n", "V003", 2, "did you mean default_s?"),
        ("[waits]\ndefault_s = -1\n", "V004", 2, ""),
        ("[waits]\n'IN#(5)' = 'long'\n", "V004", 2, "0.8"),
        ("[inputs]\n'XY#(5)' = true\n", "V003", 2, "IN#(12)"),
        ("[inputs]\n'IN#(5)' = 'on'\n", "V004", 2, "true"),
        ("[inputs]\n'IN#(5)' = []\n", "V004", 2, "one value per read"),
        ("[variables]\nB010 = 256\n", "V004", 2, "0 .. 255"),
        ("[variables]\nI010 = 1.5\n", "V004", 2, "integer"),
        ("[variables]\nQ010 = 1\n", "V003", 2, "B010"),
        ("[variables]\nP010 = 1\n", "V004", 2, "pulse"),
        ("[variables]\nP010 = { puls = [1] }\n", "V003", 2, "did you mean pulse?"),
        ("[variables]\nP010 = { pulse = [1], joint_deg = [2] }\n", "V004", 2, "pulse"),
        ("[variables]\nP010 = { pulse = ['a'] }\n", "V004", 2, "pulse"),
        ("[variables]\nP010 = { pose_mm_deg = [1, 2, 3, 4, 5, 6], frame = 'moon' }\n", "V004", 2, "frame"),
        ("[process]\narcon = 0.3\n", "V003", 2, "arcon_s"),
        ("[motion]\nmodle = 'x'\n", "V003", 2, "did you mean model?"),
        ("[motion]\naccel_mm_s2 = 0\n", "V004", 2, "3050"),
        ("[motion]\nmodel = 'lin'\n", "V004", 2, "constant, linear"),
        ("[robots]\nARM = 'x'\n", "V003", 2, "RB1"),
        ("robot = 5\n", "V004", 1, "yaskawa"),
        ("waits = 5\n", "V004", 1, "[waits]"),
        ("[inputs]\nIN#(5) = true\n", "V002", 2, "quotes"),
        ("[inputs\n", "V002", 1, ""),
    ],
)
def test_each_mistake_is_told_with_its_line_and_what_would_have_worked(
    tmp_path: Path, text: str, code: str, line: int, help_text: str
) -> None:
    path = written(tmp_path, text)
    found = load_assumptions(path).diagnostics
    assert (found[0].code, found[0].line, found[0].file) == (code, line, str(path))
    assert help_text in found[0].help
    assert found[0].is_error
    assert found[0].source_line == text.split("\n")[line - 1]


def test_all_mistakes_are_told_at_once_and_the_rest_holds(tmp_path: Path) -> None:
    text = "robot = 'yaskawa/gp25'\n[waits]\ndefault_s = 0.3\npaus_s = 1\n[variables]\nB001 = 300\nB002 = 7\n"
    found = load_assumptions(written(tmp_path, text))
    assert sorted(d.line for d in found.diagnostics) == [4, 6]
    assert (found.robot, found.default_wait, found.variables) == ("yaskawa/gp25", 0.3, {(Store.BYTE, 2): 7})


def test_a_file_that_cannot_be_read_is_told(tmp_path: Path) -> None:
    assert [d.code for d in load_assumptions(tmp_path / "olp.toml").diagnostics] == ["V001"]
    (tmp_path / "olp.toml").write_bytes(b"robot = '\xff'\n")
    assert [d.code for d in load_assumptions(tmp_path / "olp.toml").diagnostics] == ["V001"]


def test_files_of_windows_editors_are_read(tmp_path: Path) -> None:
    (tmp_path / "olp.toml").write_bytes(b"\xef\xbb\xbfrobot = 'yaskawa/gp25'\r\n[waits]\r\npaus_s = 1\r\n")
    found = load_assumptions(tmp_path / "olp.toml")
    assert found.robot == "yaskawa/gp25"
    assert [(d.code, d.line, d.source_line) for d in found.diagnostics] == [("V003", 3, "paus_s = 1")]


def test_a_changed_file_is_read_again(tmp_path: Path) -> None:
    assert load_assumptions(written(tmp_path, "robot = 'a'\n")).robot == "a"
    assert load_assumptions(written(tmp_path, "robot = 'other'\n")).robot == "other"


def test_the_nearest_file_holds_up_to_five_folders_above(tmp_path: Path) -> None:
    deep = tmp_path / "a" / "b" / "c" / "d" / "e" / "f"
    deep.mkdir(parents=True)
    top = written(tmp_path, "")
    assert nearest_assumptions(tmp_path) == top
    assert nearest_assumptions(deep.parent) == top
    assert nearest_assumptions(deep) != top
    near = written(tmp_path / "a" / "b", "")
    assert nearest_assumptions(deep) == near


def test_the_search_ends_at_a_repository(tmp_path: Path) -> None:
    written(tmp_path, "")
    folder = tmp_path / "repository" / "jobs"
    folder.mkdir(parents=True)
    (tmp_path / "repository" / ".git").mkdir()
    assert nearest_assumptions(folder) is None


@pytest.mark.parametrize("text", ["IN#(12)", "in 12", "IN12", "IN[12]", " In#( 12 ) "])
def test_signals_are_recognised_in_every_spelling(text: str) -> None:
    assert signal_key(text) == SignalKey("in", 12)


def test_names_of_signals_and_variables_go_both_ways() -> None:
    for name in ("IN#(1)", "OG#(26)", "SOUT#(81)", "MREG#(14)", "RIN#(3)", "AI#(2)"):
        key = signal_key(name)
        assert key is not None
        assert signal_name(key) == name
    assert variable_key("BP007") == (Store.BASE, 7)
    assert variable_key("b10") == (Store.BYTE, 10)
    assert variable_key("LB001") is None
    assert signal_key("TIMER 3") is None


DOCUMENT = Path(__file__).parent.parent / "docs" / "assumptions.md"


def test_the_documented_file_is_valid_and_says_something_in_every_section(tmp_path: Path) -> None:
    block = DOCUMENT.read_text(encoding="utf-8").split("```toml\n")[1].split("```")[0]
    found = load_assumptions(written(tmp_path, block))
    assert not found.diagnostics
    assert all([found.robot, found.robots, found.inputs, found.variables, found.waits, found.process])
    assert all([found.start, found.motion, found.pause])


def test_tools_frames_and_named_values_come_from_the_file(tmp_path):
    file = tmp_path / "olp.toml"
    file.write_text(
        '[names]\nheight = 120.5\n"$H_POS" = { joint_deg = [0, -90, 90, 0, 0, 0] }\n'
        "[tools]\n1 = [10, 20, 30, 0, 0, 90]\n[frames]\n2 = [1000, 0, 0, 0, 0, 0]\n"
    )
    given = load_assumptions(file)
    assert given.diagnostics == ()
    assert given.names["height"] == 120.5
    assert given.names["$h_pos"].values[2] == pytest.approx(math.pi / 2)
    assert given.tools[1] == pytest.approx((0.01, 0.02, 0.03, 0, 0, math.pi / 2))
    assert given.frames[2][0] == 1.0


@pytest.mark.parametrize(
    "text", ["[tools]\n1 = [1, 2]\n", "[frames]\nx = [1, 2, 3, 4, 5, 6]\n", "[names]\na = []\n"]
)
def test_tools_frames_and_names_that_are_none_are_told(tmp_path, text):
    file = tmp_path / "olp.toml"
    file.write_text(text)
    assert [d.code[:3] for d in load_assumptions(file).diagnostics] == ["V00"]


@pytest.mark.parametrize(
    ("text", "code"), [("bad = [", "V002"), ("[speed]\nx = 3\n", "V003"), (None, "V001")]
)
@pytest.mark.parametrize("words", ["lint", "lint --load", "merge", "merge --no-time"])
def test_a_broken_file_is_told_where_nothing_needs_it(
    words: str, text: str | None, code: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = str(SAMPLES / "inform/touch-up/before/TOUCH-UP.JBI")
    given = tmp_path / "olp.toml"
    if text is not None:
        given.write_text(text, encoding="utf-8")
    command, *options = words.split()
    files = [job] if command == "lint" else [job, job, job, "-o", str(tmp_path / "out.jbi")]
    assert main([command, *files, *options, "--assumptions", str(given)]) == 2
    assert f"error[{code}]" in capsys.readouterr().err
    assert not (tmp_path / "out.jbi").exists()
