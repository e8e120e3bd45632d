"""Several programs at once: those that call one another or share data become one, each routine and variable once."""

from __future__ import annotations

from dataclasses import replace

import pytest

from olp.__main__ import main
from olp.fluent import read
from olp.robots.robot import load_robot
from olp.transpile import Context
from olp.transpile.convert import convert, runs_of
from olp.transpile.link import Whole, link, wholes
from olp.transpile.receipt import receipt_of

ROBOT = load_robot("yaskawa/gp25")
CELL = {
    "pick": ["R[1]=R[1]+1", "CALL GRIP(1)", "WAIT 1.00(sec)", "CALL GRIP(2)"],
    "grip": ["IF AR[1]=1,DO[3]=(ON)", "WAIT .20(sec)"],
    "show": ["IF R[1]>3,JMP LBL[1]", "WAIT 2.00(sec)", "LBL[1]"],
    "alone": ["WAIT 3.00(sec)"],
}


@pytest.fixture
def cell(tmp_path):
    folder = tmp_path / "cell"
    folder.mkdir()
    for name, rows in CELL.items():
        lines = [f"{n:4d}:  {row} ;" for n, row in enumerate(rows, 1)]
        head = [f"/PROG  {name.upper()}", "/ATTR", "DEFAULT_GROUP\t= *,*,*,*,*;", "/MN"]
        (folder / f"{name}.ls").write_text("\n".join([*head, *lines, "/POS", "/END", ""]))
    return folder


def translated(cell, target, *swap):
    """The receipt of what shares something, with one text of its files another where `swap` is given."""
    programs = [read(path) for path in sorted(cell.glob("*.ls"))]
    whole = max(wholes(programs), key=lambda one: len(one.others))
    linked = link(whole.program, target, whole.others)
    made = convert(linked.program, target, Context(ROBOT))
    if swap:
        files = {name: data.replace(*(one.encode() for one in swap)) for name, data in made.files.items()}
        assert files != made.files
        made = replace(made, files=files)
    runs = runs_of(linked.program, made, target, (ROBOT, None))
    return receipt_of(linked, made.translated, target, tuple(made.files), runs, (ROBOT, None)), made


def test_programs_that_share_something_are_found(cell):
    programs = [read(path) for path in sorted(cell.glob("*.ls"))]
    found = [(one.program.main or one.program.routines[0].name, len(one.others)) for one in wholes(programs)]
    assert found == [("ALONE", 0), ("PICK", 2)]
    assert wholes(programs[:1]) == [Whole(programs[0], ())]


@pytest.mark.parametrize("target", ["rapid", "krl", "inform"])
def test_each_routine_and_variable_stands_once(cell, target):
    found, made = translated(cell, target)
    assert found.verdict.agrees, found.verdict.objections
    assert list(found.starts) == ["SHOW"]
    assert found.starts["SHOW"].steps
    text = b"\n".join(made.files.values()).decode()
    heads = {"rapid": "PROC {}(", "krl": "DEF {} (", "inform": "//NAME {}"}
    assert [text.count(heads[target].format(name)) for name in ("PICK", "GRIP", "SHOW")] == [1, 1, 1]
    if target == "krl":
        assert "GLOBAL DEF SHOW" in text  # cell.src may call it
    assert text.count("num R1:=") == (target == "rapid")


@pytest.mark.parametrize(("old", "new"), [("WaitTime 2.0", "WaitTime 2.5"), ("IF R1>3", "IF R1>4")])
def test_a_fault_in_a_further_program_is_found(cell, old, new):
    found, _ = translated(cell, "rapid", old, new)
    assert [one.kind for one in found.verdict.objections] == ["difference"]


@pytest.mark.parametrize(
    ("target", "files"),
    [
        ("rapid", {"ALONE.mod", "PICK.mod"}),
        ("inform", {"ALONE.JBI", "PICK.JBI", "GRIP.JBI", "SHOW.JBI"}),
        ("urscript", {"ALONE.script", "PICK.script", "GRIP.script", "SHOW.script"}),
    ],
)
def test_a_folder_is_translated_as_a_whole(cell, tmp_path, target, files, capsys):
    """It was refused where each program has a file: GRIP came from two programs."""
    assert main(["convert", str(cell), "--to", target, "-o", str(tmp_path / "out")]) == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} == files
    told = capsys.readouterr().out
    assert ("from SHOW: 1 steps, no differences" in told) is (target != "urscript")


def test_no_routine_but_the_first_is_called_as_the_one_that_the_controller_starts(cell, tmp_path):
    """RAPID starts at a routine called main: there a cell began at FANUC's MAIN that its PNS0001 calls."""
    text = (cell / "pick.ls").read_text()
    (cell / "main.ls").write_text((cell / "grip.ls").read_text().replace("GRIP", "MAIN"))
    (cell / "pick.ls").write_text(text.replace("GRIP", "MAIN"))
    (cell / "grip.ls").unlink()
    found, made = translated(cell, "rapid")
    assert found.verdict.agrees, found.verdict.objections
    assert made.translated.mapping["routine", "MAIN"] == "MAIN_2"


def test_folders_beside_the_program_are_parts_of_a_cell(tmp_path, monkeypatch):
    (tmp_path / "krc" / "parts").mkdir(parents=True)
    (tmp_path / "krc" / "cell.src").write_text("DEF cell ( )\nWAIT SEC 1\nGRIP( )\nEND\n")
    (tmp_path / "krc" / "parts" / "grip.src").write_text("DEF grip ( )\nWAIT SEC 2\nEND\n")
    monkeypatch.chdir(tmp_path)
    assert main(["convert", "krc", "--to", "rapid", "-o", "out"]) == 0
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["cell.mod"]


def test_two_programs_of_one_name_that_share_nothing_are_told_apart_by_folders(tmp_path, capsys):
    for name in ("a", "b"):
        (tmp_path / f"{name}.mod").write_text(
            f"MODULE M{name}\nPROC main()\nWaitTime {ord(name)};\nENDPROC\nENDMODULE\n"
        )
    assert main(["convert", str(tmp_path), "--to", "tp", "-o", str(tmp_path / "out")]) == 2
    told = capsys.readouterr().err
    assert "error[C008]: two programs that share nothing make the file main.ls" in told
    assert "each into a folder of its own" in told
    assert not (tmp_path / "out").exists()


def test_tasks_of_a_cell_that_share_nothing_are_written_into_folders_of_their_own(tmp_path, capsys):
    for task in ("T_ROB1", "T_ROB2"):
        place = tmp_path / "cell" / task / "PROGMOD"
        place.mkdir(parents=True)
        rows = ("MODULE MainModule", "PROC main()", f"WaitTime {task[-1]};", "ENDPROC", "ENDMODULE", "")
        (place / "MainModule.mod").write_text("\n".join(rows))
    out = tmp_path / "out"
    assert main(["convert", str(tmp_path / "cell"), "--to", "krl", "-o", str(out)]) == 0
    told = capsys.readouterr()
    assert "warning[C008]" in told.err
    assert "T_ROB1/main.src" in told.out
    for task in ("T_ROB1", "T_ROB2"):
        assert f"WAIT SEC {task[-1]}" in (out / task / "main.src").read_text()


def test_a_program_with_an_error_stops_itself_and_what_shares_with_it_alone(tmp_path, capsys):
    folder, out = tmp_path / "cell", tmp_path / "out"
    folder.mkdir()
    (folder / "good.mod").write_text("MODULE A\nPROC good()\nWaitTime 1;\nENDPROC\nENDMODULE\n")
    (folder / "bad.mod").write_text("MODULE B\nPROC bad()\nWaitTime ((;\nENDPROC\nENDMODULE\n")
    (folder / "caller.mod").write_text("MODULE C\nPROC caller()\nbad;\nENDPROC\nENDMODULE\n")
    assert main(["convert", str(folder), "--to", "krl", "-o", str(out)]) == 2
    assert sorted(path.name for path in out.iterdir()) == ["good.src"]
    told = capsys.readouterr()
    assert "bad.mod:3" in told.err
    assert "good.mod" in told.out
    assert main(["convert", str(folder / "bad.mod"), "--to", "krl", "-o", str(tmp_path / "none")]) == 2
    assert not (tmp_path / "none").exists()


def test_a_routine_of_another_file_is_the_global_one_and_no_file_s_own(tmp_path):
    """A file's own routine stood before in the folder, and was called by all."""
    (tmp_path / "AREA.src").write_text("DEF AREA ( )\nEND\nDEF TELL (n :IN)\nINT n\nWAIT SEC 7\nEND\n")
    (tmp_path / "LIB.src").write_text("DEF LIB ( )\nEND\nGLOBAL DEF TELL (n :IN)\nINT n\nWAIT SEC n\nEND\n")
    (tmp_path / "PART.src").write_text("DEF PART ( )\nTELL (2)\nEND\n")
    assert read(tmp_path / "PART.src").plan().durations.sum() == pytest.approx(2.0)
    linked = link(read(tmp_path / "PART.src")).program
    made = convert(linked, "rapid", Context())
    assert b"WaitTime 7" not in b"".join(made.files.values())


@pytest.mark.parametrize("rows", ["GLOBAL DEF TELL ( )", "DEF TELL ( )"])
def test_a_routine_that_another_file_has_for_itself_is_told_where_none_is_shared(tmp_path, capsys, rows):
    (tmp_path / "LIB.src").write_text(f"DEF LIB ( )\nTELL ( )\nEND\n{rows}\nWAIT SEC 7\nEND\n")
    (tmp_path / "PART.src").write_text("DEF PART ( )\nTELL ( )\nEND\n")
    main(["convert", str(tmp_path / "PART.src"), "--to", "rapid", "-o", str(tmp_path / "made")])
    says = "see that these routines are meant, as their files share them with no other: TELL (LIB.src)"
    assert (says in capsys.readouterr().out) == (not rows.startswith("GLOBAL"))
