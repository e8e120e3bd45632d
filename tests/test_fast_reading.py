"""What is read without the grammar is what the grammar reads: whole programs of all languages, both ways."""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from lark.exceptions import UnexpectedInput
from translate_programs import Maker
from translated_texts import VENDORS

import olp
from olp.core.diagnostic import Diagnostic, OlpError
from olp.core.source import decode
from olp.ir.program import Program
from olp.languages.lark_host import Grammar
from olp.languages.short_reader import AlikeLines
from olp.languages.vendors.rapid.clauses import Clause, Cutter
from olp.languages.vendors.rapid.fast import PlainClauses
from olp.languages.vendors.rapid.names import gather
from olp.languages.vendors.rapid.parsing import clause_parser
from olp.robots.robot import load_robot
from olp.transpile import Context
from olp.transpile.convert import convert

SAMPLES = Path(__file__).resolve().parent.parent / "samples"
SUFFIXES = {".jbi", ".src", ".mod", ".prg", ".ls", ".script"}
LONGEST = 200_000  # bytes
FILES = sorted(
    path
    for path in SAMPLES.rglob("*")
    if path.suffix.lower() in SUFFIXES and path.is_file() and path.stat().st_size < LONGEST
)
ROBOT = load_robot("yaskawa/gp25")


def read_by_the_grammar_alone(path: Path, patch: pytest.MonkeyPatch, vendor: str | None = None) -> Program:
    """The program as it is read when every fast way declines."""
    with patch.context() as patched:
        for reader in ("inform.instructions.Inform", "tp.instructions.Tp", "krl.fast.Krl"):
            patched.setattr(f"olp.languages.vendors.{reader}MoveLines.read", lambda *_: None)
        patched.setattr("olp.languages.vendors.krl.fast.literal", lambda *_: None)
        patched.setattr(PlainClauses, "move", lambda *_: None)
        patched.setattr(PlainClauses, "point", lambda *_: None)
        patched.setattr("olp.languages.vendors.urscript.lines.quick", lambda _: None)
        patched.setattr(
            "olp.languages.vendors.urscript.reader._UrscriptBody._point",
            lambda body, name, content, _: body._named(name, content),
        )
        return olp.read(path, vendor=vendor)


def assert_same_program(one: Program, other: Program) -> None:
    assert repr(one.data) == repr(other.data)  # of points also what takes no part in their equality
    assert [repr(routine.body) for routine in one.routines] == [repr(r.body) for r in other.routines]
    assert (one.diagnostics, one.line_kinds, one.main) == (other.diagnostics, other.line_kinds, other.main)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(SAMPLES).as_posix())
def test_samples_are_read_alike_with_and_without_the_fast_ways(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, other = (told(lambda: olp.read(path)), told(lambda: read_by_the_grammar_alone(path, monkeypatch)))
    if isinstance(one, Program) and isinstance(other, Program):
        assert_same_program(one, other)
    else:
        assert one == other


def told(read: Callable[[], Program]) -> Program | tuple[Diagnostic, ...]:
    """What is read, or why it is refused: a picture is no program."""
    try:
        return read()
    except OlpError as refused:
        return refused.diagnostics


@pytest.mark.parametrize("vendor", VENDORS)
def test_random_programs_are_read_alike_with_and_without_the_fast_ways(
    vendor: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for seed in range(3):
        made = convert(Maker(seed).program(), vendor, Context(robot=ROBOT), date="2026/01/01 00:00")
        for name, data in made.files.items():
            (tmp_path / name).write_bytes(data)
        file = tmp_path / made.main
        assert_same_program(
            olp.read(file, vendor=vendor), read_by_the_grammar_alone(file, monkeypatch, vendor)
        )


@pytest.mark.parametrize(
    "text",
    [
        "CONST speeddata v1:=[50,500,5000,1000];",
        "LOCAL PERS SpeedData V_2:=[ 50.25 , 500,5000,1000 ];",
        "VAR zonedata z1 := [FALSE,12.5,18.75,18.75,1.875,18.75,1.875];",
        "VAR zonedata z2:=[true,0,0,0,0,0,0];",
    ],
)
def test_speeds_and_zones_are_read_without_the_grammar_as_it_reads_them(text: str) -> None:
    (clause,) = [one for one in Cutter([text]).cut() if isinstance(one, Clause)]
    names = gather([clause])
    found = PlainClauses(names).point(clause.text, 0, "")
    assert [found] == clause_parser().clause(clause.text, names)


@pytest.mark.parametrize(
    "text",
    [
        "CONST speeddata v1:=[50,500,5000];",
        "CONST speeddata v1:=[50,500,5000,1000,];",
        "CONST speeddata v1:=[50,500,-5000,1000];",
        "CONST speeddata v1:=[50,500,5000,TRUE];",
        "CONST speeddata v1:=[50,500,5E3,1000];",
        "VAR zonedata z1:=[0,12.5,18.75,18.75,1.875,18.75,1.875];",
        "TASK PERS speeddata v1:=[50,500,5000,1000];",
        "VAR speeddata v1;",
    ],
)
def test_speeds_and_zones_that_are_not_plain_are_left_to_the_grammar(text: str) -> None:
    assert PlainClauses(gather([])).point(text, 0, "") is None


def test_a_record_of_the_programs_own_that_is_called_like_a_speed_is_left_to_the_grammar() -> None:
    rows = ["RECORD speeddata", "num a;", "ENDRECORD", "CONST speeddata v1:=[50,500,5000,1000];"]
    clauses = [one for one in Cutter(rows).cut() if isinstance(one, Clause)]
    assert PlainClauses(gather(clauses)).point(clauses[-1].text, 0, "") is None


@pytest.mark.parametrize(
    "texts",
    [
        [f"MoveL p{n},v100,z10,tool0{rest};" for rest in ("", "\\WObj:=wobj0") for n in range(3)],
        ["MoveJ p1, v100 ,z10,gripper;", "moveabsj p2, v100 ,z10,gripper;", "MoveL p1, v100 ,z10,gripper;"],
        ["MoveL p1,v100,fine,tool0;", "MoveL p1,v100,fine,tool0 ;", "MoveL [[1,2,3],[1,0,0,0],[0,0,0,0],"
         "[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;", "MoveC p1,p2,v100,fine,tool0;"],
    ],
)  # fmt: skip
def test_rapid_moves_that_go_alike_are_read_as_the_grammar_reads_each(texts: list[str]) -> None:
    """What stands behind the target is read once for each of its texts."""
    names = gather([])
    plain = PlainClauses(names)
    for text in texts * 2:
        assert repr([plain.move(text, 0, "")]) == repr(clause_parser().clause(text, names))


def test_rapid_moves_of_any_form_are_read_by_the_grammar_once_for_all_their_targets() -> None:
    names = gather([])
    plain = PlainClauses(names)
    behind = (
        "v100\\V:=weld,z10,tool0;",
        "v100,z10\\Inpos:=inpos20,tool0;",
        "[100,50,0,0],fine,tool0\\WObj:=wobj0;",
    )
    for rest in behind:
        first = f"MoveL p1,{rest}"
        assert plain.move(first, 0, "") is None
        plain.learn(first, clause_parser().clause(first, names))
        for text in (f"MoveL p2,{rest}", f"MoveL p3 ,{rest}"):
            assert repr([plain.move(text, 0, "")]) == repr(clause_parser().clause(text, names))
        for other in (f"MoveJ p2,{rest}", f"MoveL Offs(p2,1,2,3),{rest}", f"MoveL\\Conc,p2,{rest}"):
            assert plain.move(other, 0, "") is None
    plain.forget()
    assert plain.move(f"MoveL p2,{behind[0]}", 0, "") is None


@pytest.mark.parametrize(
    "numbers",
    ["1_000,0,0],[1,0,0,0", "nan,0,0],[1,0,0,0", "1,2,3],[1,0,0,inf", "1,2,3],[0,0,0,0", "1,2],[1,0,0,0"],
)
def test_rapid_points_of_what_only_python_takes_for_numbers_are_left_to_the_grammar(numbers: str) -> None:
    text = f"CONST robtarget p1:=[[{numbers}],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    assert PlainClauses(gather([])).point(text, 0, "") is None


def test_krl_names_of_the_motion_data_are_found_wherever_code_names_them(tmp_path: Path) -> None:
    """With no $config.dat only the names that olp knows values for are looked for; comments name nothing."""
    file = tmp_path / "P.src"
    file.write_text("DEF P ( )\nBAS (#PTP_PARAMS,100)\nFDAT_ACT=fhome\nPTP {A1 0}\nEND\n", encoding="ascii")
    assert [declare.name.upper() for declare in olp.read(file).data] == ["FHOME"]
    file.write_text("DEF P ( )\n; FDAT_ACT=FHOME\nPTP {A1 0}\nEND\n", encoding="ascii")
    assert not olp.read(file).data


def test_a_long_path_is_read_as_its_points_one_by_one() -> None:
    """URScript: thousands of poses with names, and moves to them, against what each line alone says."""
    chance = random.Random(4)
    points = [[round(chance.uniform(-1, 1), 6) for _ in range(6)] for _ in range(200)]
    rows = [f"  global P{n} = p[{', '.join(map(str, row))}]" for n, row in enumerate(points)]
    rows += [f"  movel(pose_trans(f1, P{n}), v={0.1 + n / 1000:.3f})" for n in range(200)]
    frame = "  global f1 = p[0.5, 0, 0.2, 0, 0, 1]"
    text = "\n".join(["def main():", frame, *rows, "end", ""])
    program = olp.fluent.read_source(decode(text.encode(), "a.script"), vendor="urscript")
    values = {declare.name: declare.value.values for declare in program.data}  # type: ignore[union-attr]
    assert [list(values[f"P{n}"][:3]) for n in range(200)] == [row[:3] for row in points]
    moves = program.routines[0].body
    assert [move.targets[0].name for move in moves] == [f"P{n}" for n in range(200)]  # type: ignore[union-attr]
    assert {move.frame.name for move in moves} == {"f1"}  # type: ignore[union-attr]


@pytest.mark.parametrize("language", ["as", "pdl2", "val3"])
def test_lines_with_other_digits_have_the_tree_that_the_grammar_gives(language: str) -> None:
    declared = (SAMPLES / language / f"readings/{language}.reading").read_text(encoding="utf-8")
    texts = {re.split(r"\s*(?:;|--|//)", text)[0] for text in re.findall(r"(?m)^S +(.*\S)", declared)}
    choose = random.Random(language)

    def other(digits: re.Match[str]) -> str:
        return str(choose.randrange(10 ** choose.choice((1, 1, 2, 3, 9))))

    variants = [re.sub("[0-9]+", other, text) for text in sorted(texts) for _ in range(4)]
    odd = [
        "x = 0x1F",
        "x = 1x1F",
        "x = 1E5",
        "x = 1E50",
        "x = 1E500",
        "C1MOVE a",
        "C2MOVE a",
        "C3MOVE a",
        "x = '%s1 %%s'",
    ]
    variants = choose.sample(variants, len(variants)) + odd * 2
    grammar = Grammar(language)
    lines = AlikeLines(grammar)
    trees = 0
    for text in variants:
        try:
            tree = repr(grammar.parse(text))
        except UnexpectedInput as refused:
            with pytest.raises(type(refused)):
                lines.read(text, repr)
        else:
            assert lines.read(text, repr) == tree, text
            trees += 1
    assert trees > len(variants) / 2
