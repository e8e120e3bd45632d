"""RAPID: what is told about text that is wrong, where, and what is read all the same."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from cpu_time import cpu_time_below
from rapid_modules import NO_AXES, codes, errors, module, read

from olp.core.source import decode
from olp.fluent import read_source
from olp.ir.program import LineKind, Move, Program
from olp.languages.vendor import recognise

SAMPLES = Path(__file__).resolve().parent.parent / "samples" / "rapid"


def told(body: list[str] | str, data: list[str] | str = ()) -> list[tuple[str, int]]:
    return [(d.code, d.line) for d in read(module(body, data)).diagnostics if d.severity != "info"]


def whole(*lines: str) -> list[tuple[str, int]]:
    return [(d.code, d.line) for d in read("\n".join(lines)).diagnostics if d.severity != "info"]


# --- the file -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "raw", [b"", b" \r\n\r\n", b"poem\r\nand more\r\n", b"MODULE A\0\r\n", "MODULE A".encode("utf-16")]
)
def test_what_is_no_module_is_told_once(raw: bytes) -> None:
    program = read_source(decode(raw, "a.mod"), vendor="rapid")
    assert [d.code for d in program.diagnostics] == ["P450"]
    assert program.to_bytes() == raw


def test_a_module_that_is_cut_off() -> None:
    assert whole("MODULE A", "PROC main()", "x:=1;") == [("P453", 2), ("P453", 3)]


def test_a_routine_without_its_end_ends_before_the_next_one() -> None:
    lines = ["MODULE A", "PROC a()", "x:=1;", "PROC b()", "x:=2;", "ENDPROC", "ENDMODULE"]
    program = read("\n".join(lines))
    assert errors(program) == ["P453 2"]
    assert [(one.name, len(one.body)) for one in program.routines] == [("a", 1), ("b", 1)]


def test_ends_that_end_something_else() -> None:
    assert whole("MODULE A", "PROC a()", "ENDFUNC", "ENDMODULE") == [("P454", 3)]
    assert whole("MODULE A", "ENDPROC", "ENDMODULE", "ENDMODULE") == [("P454", 2), ("P454", 4)]


def test_routines_and_instructions_stand_where_they_belong() -> None:
    assert whole("PROC a()", "ENDPROC") == [("P456", 1)]
    assert whole("MODULE A", "x:=1;", "ERROR", "ENDMODULE")[0] == ("P457", 2)


def test_two_data_of_one_name() -> None:
    assert told("x:=1;", ["VAR num a;", "VAR num A;"]) == [("P459", 3)]


# --- blocks -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("body", "wanted"),
    [
        (["IF a THEN"], [("P453", 3)]),
        (["FOR i FROM 1 TO 2 DO", "IF a THEN", "ENDFOR"], [("P453", 4)]),
        (["ENDWHILE"], [("P454", 3)]),
        (["ELSE"], [("P454", 3)]),
        (["CASE 1:"], [("P454", 3)]),
        (["TEST a", "CASE 1:", "ENDIF", "ENDTEST"], [("P454", 5)]),
        (["IF a THEN", "ERROR", "ENDIF"], [("P453", 3), ("P454", 5)]),
        (["IF a THEN", "ELSE", "IF b THEN", "ELSE", "ENDIF", "ELSEIF c THEN", "ENDIF"], [("P454", 8)]),
        (["TEST a", "DEFAULT:", "CASE 1:", "ENDTEST"], [("P454", 5)]),
        (["IF a THEN IF b THEN ELSE ENDIF ELSE ENDIF"], []),
    ],
)
def test_blocks_that_do_not_pair(body: list[str], wanted: list[tuple[str, int]]) -> None:
    assert told(body) == wanted


def test_a_broken_opener_still_opens_its_block() -> None:
    assert told(["IF a + THEN", "x:=1;", "ENDIF"]) == [("P451", 3)]
    assert told(["WHILE DO", "ENDWHILE"]) == [("P451", 3)]
    assert told(['s:=StrPart("a");']) == [("P451", 3)]


def test_labels_that_do_not_exist_or_stand_twice() -> None:
    assert told(["GOTO done;"]) == [("P458", 3)]
    assert told(["done:", "Done:", "GOTO DONE;"]) == [("P458", 4)]


# --- instructions -------------------------------------------------------------------------------------------------


def test_a_missing_semicolon_is_told_where_it_is_missing_and_both_instructions_are_read() -> None:
    program = read(module(["MoveL p1,v100,z10,tool0", "MoveL p2,v100,z10,tool0;", "x:=1", "ENDIF"]))
    found = [(d.code, d.line, d.column) for d in program.diagnostics if d.is_error]
    assert found == [("P452", 3, 24), ("P452", 5, 5), ("P454", 6, 1)]
    assert sum(isinstance(one, Move) for one in program.routines[0].body) == 2


@pytest.mark.parametrize(
    ("line", "column", "says"),
    [
        ("MoveL p1,v100 z10,tool0;", 15, "unexpected 'z10'"),
        ("MoveL p1,v100,z10;", 1, "MoveL has no tool"),
        ("MoveL p1,v100,z10,tool0,x;", 1, "too many"),
        ("x:=1+;", 6, "unexpected ';'"),
        ("x=1;", 2, "unexpected '='"),
        ('TPWrite "abc;', 9, "a text that is not closed"),
        ("SetDO do1;", 1, "needs 2 arguments"),
        ("x:=(1+2;", 8, "unexpected ';'"),
        ("FOR i TO 3 DO", 7, "unexpected 'TO'"),
        ("MoveL [[1,2],[1,0,0,0],[0,0,0,0],[0,0,0,0,0,0]],v5,fine,tool0;", 7, "2 values, where a pos has 3"),
        ("§", 1, "unexpected"),
    ],
)
def test_what_is_refused_is_told_with_its_place(line: str, column: int, says: str) -> None:
    program = read(module(line))
    first = next(d for d in program.diagnostics if d.is_error)
    assert first.code in ("P451", "P452")
    assert (first.line, first.column) == (3, column)
    assert says in first.message
    assert program.line_kinds[2] == LineKind.ERROR


def test_errors_in_a_clause_of_several_lines_have_their_own_line() -> None:
    program = read(module(["MoveL p1,", "  v100,z10 t,", "  3;"]))
    (found,) = [d for d in program.diagnostics if d.is_error]
    assert (found.code, found.line, found.column) == ("P451", 4, 12)


def test_errors_inside_handlers_are_told() -> None:
    assert told(["x:=1;", "ERROR", "x:=;"]) == [("P451", 5)]


def test_data_that_only_another_file_has_is_told_once() -> None:
    found = read(module(["MoveL p1,v100,z10,t;", "MoveL p1,v100,z10,t;"]))
    assert codes(found)["P472"] == [3, 3]
    assert "P472" not in codes(
        read(module("MoveL p1,v5,z1,tool0;", f"CONST robtarget p1:=[[1,2,3],[1,0,0,0],[0,0,0,0],{NO_AXES}];"))
    )


def test_a_work_object_that_a_unit_carries_is_told() -> None:
    frames = "[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]"
    data = [
        f'PERS wobjdata w{n}:=[FALSE,{way},"{unit}",{frames}];'
        for n, (way, unit) in enumerate([("TRUE", ""), ("FALSE", "CNV1"), ("TRUE", "STN1")])
    ]
    assert codes(read(module("x:=1;", data)))["P473"] == [3, 4]


def test_the_fastest_speed_is_an_assumption() -> None:
    assert codes(read(module(["MoveL p,vmax,fine,tool0;", "MoveJ p,vmax,fine,tool0;"])))["P464"] == [3]


def test_a_long_name_is_told() -> None:
    assert codes(read(module("x:=1;", f"VAR num {'n' * 33};")))["P460"] == [2]


# --- too much -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "line",
    [
        "x:=" + "(" * 200 + "1" + ")" * 200 + ";",
        "x:=1" + "+1" * 5000 + ";",
        "x:=" + "-" * 3000 + "1;",
        "x:=" + "NOT " * 3000 + "a;",
        "a" + ".b" * 2000 + ":=1;",
        "x:=" + "[" * 500 + "]" * 500 + ";",
        "foo " + "\\a" * 2000 + ";",
    ],
)
def test_an_instruction_beyond_all_bounds_is_told_and_not_read(line: str) -> None:
    assert told(line) == [("P467", 3)]


@pytest.mark.parametrize(
    "line",
    [
        "setdo \\a" + " " * 40_000 + "!",
        "VAR num x" + " " * 40_000 + "y;",
        "x" + "{" * 40_000,
        "PROC a(" + "num x " * 5_000 + ")",
        '"' * 40_001,
        "MoveL [[" + "1," * 30_000 + ";",
        "IF " * 10_000,
        "%" * 20_000,
        "a:" * 20_000,
        ";" * 100_000,
        "ENDIF " * 3_000,
    ],
)
def test_hostile_lines_take_bounded_time(line: str) -> None:
    with cpu_time_below(3.0):
        program = read(module([line, "x:=1;"]))
    assert len(program.line_kinds) == len(program.source.lines)


def test_thousands_of_broken_lines_are_not_explained_one_by_one() -> None:
    found = codes(read(module([f"x{n} := ;" for n in range(2100)])))
    assert len(found["P451"]) == 2000
    assert found["P468"] == [2003]


def test_a_list_of_modules_stays_in_its_folder(tmp_path: Path) -> None:
    (tmp_path / "inside").mkdir()
    (tmp_path / "secret.mod").write_text(module("x:=1;"))
    (tmp_path / "inside" / "Good.mod").write_text(module("x:=1;"))
    names = ["../secret.mod", "/etc/passwd", "no.mod", "GOOD.MOD", "", "a\\b.mod"]
    rows = "".join(f"<Module>{name}</Module>\n" for name in names)
    listing = tmp_path / "inside" / "a.pgf"
    listing.write_text(f'<?xml version="1.0"?>\n<Program>\n{rows}</Program>\n')
    program = read_source(decode(listing.read_bytes(), str(listing)))
    assert [(d.code, d.line) for d in program.diagnostics] == [("P470", n) for n in (3, 4, 5, 7, 8)]
    assert [Path(one.path).name for one in program.companions] == ["Good.mod"]


# --- damaged files --------------------------------------------------------------------------------------------------


def _damaged(raw: bytes, chance: random.Random) -> bytes:
    data = bytearray(raw)
    kind = chance.randrange(5)
    if kind == 0:
        return bytes(data[: chance.randrange(len(data))])
    for _ in range(chance.randint(1, 12)):
        place = chance.randrange(len(data))
        if kind == 1:
            data[place] = chance.randrange(1, 256)
        elif kind == 2:
            del data[place : place + chance.randint(1, 40)]
        elif kind == 3:
            other = chance.randrange(len(data))
            data[place:place] = data[other : other + chance.randint(1, 60)]
        else:
            lines = bytes(data).split(b"\r\n")
            first, second = chance.randrange(len(lines)), chance.randrange(len(lines))
            lines[first], lines[second] = lines[second], lines[first]
            data = bytearray(b"\r\n".join(lines))
    return bytes(data)


@pytest.mark.slow("pallet.prg")
@pytest.mark.parametrize("name", ["handling.mod", "pallet.prg"])
def test_damaged_files_never_raise_and_keep_their_bytes(name: str) -> None:
    raw = (SAMPLES / name).read_bytes()
    chance = random.Random(name)
    with cpu_time_below(30):
        for _ in range(120):
            data = _damaged(raw, chance)
            program: Program = read_source(decode(data, name), vendor="rapid")
            assert program.to_bytes() == data
            assert len(program.line_kinds) == len(program.source.lines)
            for line, kind in zip(program.source.lines, program.line_kinds, strict=True):
                assert kind or not line.strip(" \t\f\v;") or not line.strip(), line


# --- whose file it is -----------------------------------------------------------------------------------------------


def test_files_with_suffixes_that_others_use_are_known_by_their_text() -> None:
    for name in ("a.prg", "a.sys", "a.txt", "a.mod"):
        for text in (
            "%%%\n  VERSION:1\n%%%\nMODULE A\nENDMODULE\n",
            "! hello\nmodule A (sysmodule)\nendmodule\n",
        ):
            vendor = recognise(decode(text.encode(), name))
            assert vendor is not None
            assert vendor.name == "rapid"
    other = recognise(decode(b"10 PRINT\n", "a.txt"))
    assert other is None
