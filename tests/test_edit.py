"""Changes of positions and speeds: what was asked is what is read back, and every other byte stays."""

from __future__ import annotations

import difflib
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import olp
from olp.checks.edit import ChangeSpeed, PlacePoint, SetPoint, edited, visits
from olp.core.units import deg, mm
from olp.ir.points import PointKind
from olp.ir.program import Move, SetSpeed
from olp.languages.literals import speed_of, speeds, written_points
from olp.robots.geometry import Pose, rotation_angle

SAMPLES = Path(__file__).parent.parent / "samples"
ROBOT = "yaskawa/gp25"
PROGRAMS = {
    "inform": "inform/handling/HANDLING.JBI",
    "krl": "krl/handling.src",
    "rapid": "rapid/handling.mod",
    "tp": "tp/handling.ls",
    "urscript": "urscript/handling.script",
}
BY = Pose.from_xyz_angles([0.011, -0.0213, 0.0307, 0.021, -0.034, 0.013])
LANGUAGES = pytest.mark.parametrize("language", PROGRAMS)


def program(language: str) -> olp.Program:
    return olp.read(SAMPLES / PROGRAMS[language])


def changed_lines(before: olp.Program, result) -> set[tuple[str, int]]:
    """The lines that differ, each file with as many lines as before and the same bytes between them."""
    old = {one.path: one for one in (before.source, *before.companions)}
    found = set()
    for source in result.sources:
        rows, new_rows = old[source.path].raw.split(b"\n"), source.raw.split(b"\n")
        assert len(rows) == len(new_rows)
        found |= {
            (source.path, n)
            for n, pair in enumerate(zip(rows, new_rows, strict=True), 1)
            if len(set(pair)) > 1
        }
    return found


@LANGUAGES
def test_every_point_takes_new_numbers_and_only_its_lines_change(language):
    before = program(language)
    for name, point in written_points(before).items():
        values = np.asarray(point.values())
        if point.kind is PointKind.POSE:
            wanted = tuple((Pose.from_xyz_angles(values) @ BY).xyz_angles().tolist())
        else:
            wanted = tuple((values + 0.0123 * np.arange(1, len(values) + 1)).tolist())
        result = edited(before, [SetPoint(name, wanted)])
        after = written_points(result.program)[name]
        if point.kind is PointKind.POSE:
            assert np.allclose(after.pose().position, wanted[:3], atol=0.00051 * mm)
            turn = rotation_angle(after.pose().rotation, Pose.from_xyz_angles(wanted).rotation)
            assert float(turn) < 0.002 * deg
        else:
            assert np.allclose(after.values(), wanted, atol=0.00051 * deg)
        lines = changed_lines(before, result)
        assert lines == set(result.lines)
        assert {line for _, line in lines} == {one.line for one in point.numbers}


@LANGUAGES
def test_the_tool_goes_where_a_point_is_placed(language):
    before = program(language)
    plan = before.plan(robot=ROBOT)
    # The first visit counts: a later one may be with another tool.
    seen = {one.name: one for one in reversed([*visits(before, plan)]) if one.name != "LIFTED"}
    assert len(seen) >= 3
    for name, visit in seen.items():
        wanted = visit.pose @ BY
        result = edited(before, [PlacePoint(name, wanted)], plan, lambda p: p.plan(robot=ROBOT))
        again = result.program.plan(robot=ROBOT)
        moved = next(
            one for one in visits(result.program, again) if (one.name, one.step) == (name, visit.step)
        )
        assert np.allclose(moved.pose.position, wanted.position, atol=0.03 * mm)
        # Independent of `visits`: where the plan itself says that the tool goes.
        if not visit.is_via:
            at = again.moves.target[again.row[visit.step]]
            assert np.allclose(again.positions.position[at], wanted.position, atol=0.03 * mm)


@LANGUAGES
def test_every_written_speed_can_be_changed_and_nothing_else_changes(language):
    before = program(language)
    lines = sorted({one.line for one in before.statements() if isinstance(one, Move | SetSpeed)})
    known = {line: speed_of(before, line) for line in lines}
    known = {line: speed for line, speed in known.items() if speed is not None}
    assert len(known) >= 6
    for line, speed in known.items():
        result = edited(before, [ChangeSpeed(line, speed.value.literal * 0.8)])
        assert speed_of(result.program, line).value.literal == pytest.approx(
            speed.value.literal * 0.8, rel=0.02
        )
        lines = changed_lines(before, result)
        assert lines == set(result.lines)
        assert 1 <= len(lines) <= 2


@LANGUAGES
def test_a_change_and_its_opposite_give_the_same_numbers(language):
    before = program(language)
    name, point = next((n, p) for n, p in written_points(before).items() if p.kind is PointKind.POSE)
    other = (Pose.from_xyz_angles(point.values()) @ BY).xyz_angles().tolist()
    there = edited(before, [SetPoint(name, tuple(other))]).program
    back = edited(there, [SetPoint(name, point.values())])
    old, new = (np.asarray(one.written()) for one in (point, written_points(back.program)[name]))
    assert np.allclose(old, new, atol=1e-3)


@LANGUAGES
def test_no_change_is_no_change(language):
    before = program(language)
    edits = [SetPoint(name, point.values()) for name, point in written_points(before).items()]
    assert edited(before, edits).sources == ()


@LANGUAGES
def test_a_program_looks_as_before_where_only_a_height_changes(language):
    """The frame of the eye: one number of the line is another one."""
    before = program(language)
    name, point = next((n, p) for n, p in written_points(before).items() if p.kind is PointKind.POSE)
    values = list(point.values())
    values[2] += 1.5 * mm
    result = edited(before, [SetPoint(name, tuple(values))])
    (source,) = result.sources
    numbers = zip(point.written(), written_points(result.program)[name].written(), strict=True)
    assert [i for i, (a, b) in enumerate(numbers) if a != b] == [2]
    ((_, line),) = result.lines
    old = next(one for one in (before.source, *before.companions) if one.path == source.path).line(line)
    matcher = difflib.SequenceMatcher(None, old, source.line(line), autojunk=False)
    assert sum(one[2] - one[1] for one in matcher.get_opcodes() if one[0] != "equal") <= 8


def test_several_changes_are_one(tmp_path):
    before = program("inform")
    result = edited(
        before, [ChangeSpeed(41, 0.2), ChangeSpeed(40, 0.5), SetPoint("C00002", (0.1, 0.2, 0.3, 3, 0, 0))]
    )
    shown = [result.program.source.line(n) for n in (13, 40, 41)]
    assert shown == [
        "C00002=100.000,200.000,300.000,171.8873,0.0000,0.0000",
        "MOVJ C00001 VJ=50.00 PL=2",
        "MOVL C00002 V=200.0 PL=0",
    ]


def test_pulses_are_placed_through_the_robot_and_come_back_whole(tmp_path):
    job = tmp_path / "PULSES.JBI"
    lines = (
        "/JOB\r\n//NAME PULSES\r\n//POS\r\n///NPOS 2,0,0,0,0,0\r\n///TOOL 0\r\n///POSTYPE PULSE\r\n///PULSE\r\n"
        "C00000=5200,-10400,8100,3300,-41200,2100\r\nC00001=9100,-8400,7100,3900,-39200,4100\r\n"
        "//INST\r\n///DATE 2026/01/02 03:04\r\n///ATTR SC,RW\r\n///GROUP1 RB1\r\nNOP\r\n"
        "MOVJ C00000 VJ=25.00\r\nMOVL C00001 V=80.0\r\nEND\r\n"
    )
    job.write_bytes(lines.encode())
    before = olp.read(job)
    plan = before.plan(robot="yaskawa/ma2010")
    visit = next(one for one in visits(before, plan) if one.name == "C00001")
    wanted = visit.pose @ BY
    with pytest.raises(olp.OlpError) as caught:
        edited(before, [PlacePoint("C00001", wanted)])
    assert [one.code for one in caught.value.diagnostics] in (["O007"], ["O009"])
    result = edited(before, [PlacePoint("C00001", wanted)], plan, lambda p: p.plan(robot="yaskawa/ma2010"))
    assert changed_lines(before, result) == {(str(job), 9)}
    numbers = result.program.source.line(9).partition("=")[2].split(",")
    assert len(numbers) == 6
    assert all(one.lstrip("-").isdigit() for one in numbers)
    again = result.program.plan(robot="yaskawa/ma2010")
    pose = next(one for one in visits(result.program, again) if one.name == "C00001").pose
    assert np.allclose(pose.position, wanted.position, atol=0.05 * mm)


def refused(before: olp.Program, *edits) -> list[str]:
    with pytest.raises(olp.OlpError) as caught:
        edited(before, edits, before.plan(robot=ROBOT), lambda p: p.plan(robot=ROBOT))
    assert all(one.file for one in caught.value.diagnostics)
    return [one.code for one in caught.value.diagnostics]


def test_what_cannot_be_changed_is_told_at_once():
    before = program("inform")
    far = Pose.from_xyz_angles([9.0, 0, 0, 0, 0, 0])
    assert refused(
        before,
        SetPoint("C00077", (0,) * 6),
        SetPoint("C00001", (0.0, 1.0)),
        SetPoint("C00001", (float("nan"),) * 6),
        ChangeSpeed(42, 0.2),
        ChangeSpeed(41, 0.0),
        ChangeSpeed(40, 1.5),
        ChangeSpeed(10**6, 0.2),
        PlacePoint("C00000", far),
        PlacePoint("P00020", far),
    ) == ["O002", "O004", "O004", "O005", "O006", "O006", "O005", "O007", "O009"]


def test_a_point_that_the_program_computes_with_is_refused():
    before = program("krl")
    plan = before.plan(robot=ROBOT)
    visit = next(one for one in visits(before, plan) if one.name == "LIFTED")
    assert refused(before, PlacePoint("LIFTED", visit.pose @ BY)) == ["O009"]


def test_a_name_that_is_written_twice_is_refused(tmp_path):
    path = tmp_path / "twice.script"
    path.write_text(
        "def a():\n  q = p[.1,.2,.3,0,0,0]\n  movel(q)\n  q = p[.1,.2,.4,0,0,0]\n  movel(q)\nend\n"
    )
    before = olp.read(path)
    assert written_points(before) == {}
    assert refused(before, SetPoint("q", (0,) * 6)) == ["O003"]


def test_a_speed_that_other_moves_share_is_changed_only_where_it_is_set(tmp_path):
    for name in ("handling.dat", "$config.dat"):
        shutil.copy(SAMPLES / "krl" / name, tmp_path / name)
    path = tmp_path / "handling.src"
    path.write_text("DEF handling()\n$VEL.CP=0.2\nLIN XP2\nLIN XP3\nEND\n")
    before = olp.read(path)
    assert refused(before, ChangeSpeed(3, 0.1)) == ["O005"]
    assert [(one.line, one.written) for one in speeds(before)] == [(2, 2)]
    assert {one.line: one.written for one in speeds(program("krl"))}[38] == 37
    assert edited(before, [ChangeSpeed(2, 0.1)]).program.source.line(2) == "$VEL.CP=0.1"


def test_positions_in_moves_themselves_are_found(tmp_path):
    texts = {
        "m.mod": "MODULE m\n PROC main()\n  MoveL [[500,10.5,400],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,"
        "fine,tool0;\n ENDPROC\nENDMODULE\n",
        "k.src": "DEF k()\n$VEL.CP=0.2\nLIN {X 500,Y 10.5,Z 400,A 0,B 0,C 0}\nEND\n",
        "u.script": "def u():\n  set_tcp(p[0,0,0,0,0,0])\n  movel(p[0.5, 0.0105, 0.4, 0, 0, 0], v=0.2)\nend\n",
    }
    for name, text_ in texts.items():
        path = tmp_path / name
        path.write_text(text_)
        before = olp.read(path)
        (point,) = written_points(before).values()
        assert point.name == "line 3"
        result = edited(before, [SetPoint("line 3", (0.5, 0.02, 0.4, 0, 0, 0))])
        assert changed_lines(before, result) == {(str(path), 3)}
        assert written_points(result.program)["line 3"].values()[1] == pytest.approx(0.02)


def test_what_a_comment_or_a_string_says_is_no_point(tmp_path):
    point = "robtarget p1:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    path = tmp_path / "c.mod"
    path.write_text(f'MODULE c\n! CONST {point}\nCONST string s:="x {point}";\nENDMODULE\n')
    assert written_points(olp.read(path)) == {}


def test_line_ends_and_encodings_stay(tmp_path):
    raw = (
        (SAMPLES / PROGRAMS["inform"]).read_bytes().replace(b"'gripper and probe", "'Größe".encode("cp1252"))
    )
    path = tmp_path / "MIXED.JBI"
    path.write_bytes(raw.replace(b"MOVL C00002 V=250.0 PL=0\r\n", b"MOVL C00002 V=250.0 PL=0\n", 1))
    before = olp.read(path)
    result = edited(before, [ChangeSpeed(41, 0.2)])
    assert result.program.to_bytes() == before.to_bytes().replace(b"V=250.0", b"V=200.0", 1)


@pytest.mark.parametrize("language", ["val3", "pdl2", "as"])
def test_other_languages_are_refused(language):
    path = next(
        p for p in sorted((SAMPLES / language).rglob("*")) if p.suffix in (".as", ".pdl", ".pgx", ".PDL")
    )
    before = olp.read(path)
    with pytest.raises(olp.OlpError) as caught:
        edited(before, [ChangeSpeed(3, 0.1)])
    assert {one.code for one in caught.value.diagnostics} <= {"O001", "O005"}
    with pytest.raises(olp.OlpError, match="cannot be changed"):
        written_points(before)


def test_a_program_with_mistakes_elsewhere_can_be_changed():
    before = olp.read(SAMPLES / "inform" / "broken" / "missing-point.jbi")
    assert any(one.is_error for one in before.diagnostics)
    assert edited(before, [ChangeSpeed(17, 0.05)]).program.source.line(17) == "MOVL C00009 V=50.0"


def test_a_time_that_decides_in_place_of_the_speed_is_what_is_changed(tmp_path):
    path = tmp_path / "t.script"
    path.write_text(
        "def t():\n  movej([0.1,0.2,0.3,0.4,0.5,0.6], 1.2, 0.25, 0.5, 0.001)\n"
        "  movej([0.2,0.2,0.3,0.4,0.5,0.6], a=1.2, v=0.25, t=0.5)\nend\n"
    )
    before = olp.read(path)
    result = edited(before, [ChangeSpeed(2, 0.75), ChangeSpeed(3, 0.625)])
    assert "1.2, 0.25, 0.75, 0.001)" in result.program.source.line(2)
    assert "v=0.25, t=0.625)" in result.program.source.line(3)


def test_rounding_is_told():
    before = program("tp")
    assert edited(before, [ChangeSpeed(62, 0.36)]).notes == ()
    (note,) = edited(before, [ChangeSpeed(62, 0.0149)]).notes
    assert note.code == "O010"
    assert "1.49 is written as 1" in note.message


@pytest.mark.parametrize("language", ["inform", "rapid", "tp"])
def test_a_reader_that_sees_something_else_stops_the_change(language, monkeypatch):
    """The finder of numbers is held by the reader: one that takes y for x is refused, not believed."""
    from importlib import import_module

    module = import_module(f"olp.languages.vendors.{language}.written")
    honest = module.points

    def crooked(one):
        for point in honest(one):
            x, y, *rest = point.numbers
            yield replace(point, numbers=(y, x, *rest))

    before = program(language)
    name, point = next((n, p) for n, p in written_points(before).items() if p.kind is PointKind.POSE)
    values = (point.values()[0] + 0.05, *point.values()[1:])
    monkeypatch.setattr(module, "points", crooked)
    assert refused(before, SetPoint(name, values)) == ["O008"]
