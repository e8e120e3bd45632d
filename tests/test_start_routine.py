"""Where a run begins: what the file says, what a reader asks for, and what is told where nothing says it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.fluent import read
from olp.identification.timing_job import TimingJob, plan_and_time

MODULE = """MODULE Parts
  FUNC num half(num whole)
    RETURN whole/2;
  ENDFUNC
  PROC {first}()
    pause;
  ENDPROC
  PROC pause()
    WaitTime half(2);
  ENDPROC
  PROC pick()
    WaitTime 3;
  ENDPROC
  PROC place(num seconds)
    WaitTime seconds;
  ENDPROC
ENDMODULE
"""
KRL = "DEF {first}()\nWAIT SEC 1\nEND\n\nDEF pick()\nWAIT SEC 3\nEND\n"
AS = ".PROGRAM prepare()\nTWAIT 1\n.END\n.PROGRAM pick()\nTWAIT 3\n.END\n"


def written(folder: Path, name: str, text: str) -> str:
    file = folder / name
    file.write_text(text, "utf-8", newline="\r\n")
    return str(file)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("parts.mod", MODULE.format(first="prepare")),
        ("parts.src", KRL.format(first="prepare")),
        ("parts.as", AS),
    ],
)
def test_a_file_that_does_not_say_where_it_begins_is_told(tmp_path: Path, name: str, text: str) -> None:
    file = written(tmp_path, name, text)
    timing = plan_and_time(file, TimingJob())
    assert timing.total_s == pytest.approx(1.0)
    told = [one.says for one in timing.assumptions]
    assert len(told) == 1
    assert told[0].casefold().startswith("prepare is run")
    assert told[0].casefold().endswith("(pick)")  # no function, none that is called, none that needs a number


@pytest.mark.parametrize(
    ("name", "text"),
    [("parts.mod", MODULE.format(first="main")), ("parts.src", KRL.format(first="parts"))],
)
def test_a_file_that_says_it_needs_no_assumption(tmp_path: Path, name: str, text: str) -> None:
    timing = plan_and_time(written(tmp_path, name, text), TimingJob())
    assert timing.total_s == pytest.approx(1.0)
    assert not timing.assumptions


@pytest.mark.parametrize(
    ("name", "text"),
    [("parts.mod", MODULE.format(first="main")), ("parts.src", KRL.format(first="parts")), ("parts.as", AS)],
)
def test_a_reader_starts_another_routine(tmp_path: Path, name: str, text: str) -> None:
    timing = plan_and_time(written(tmp_path, name, text), TimingJob(routine="PICK"))
    assert timing.total_s == pytest.approx(3.0)
    assert not timing.assumptions


def test_files_of_a_folder_without_the_routine_are_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    written(tmp_path, "parts.mod", MODULE.format(first="main"))
    other = written(tmp_path, "other.mod", "MODULE other\nPROC main()\nWaitTime 1;\nENDPROC\nENDMODULE\n")
    assert main(["time", str(tmp_path), "--routine", "pick", "--format", "json"]) == 0
    out, err = capsys.readouterr()
    assert [Path(one["file"]).name for one in json.loads(out)] == ["parts.mod"]
    assert "left out: 1 of the folder's files, which have no routine pick" in err
    assert main(["time", str(tmp_path), other, "--routine", "pick"]) == 2, "a file that is named must have it"
    assert main(["time", str(tmp_path), "--routine", "weld"]) == 2, "nothing is left to time"


def test_a_routine_that_the_file_has_not_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = written(tmp_path, "parts.mod", MODULE.format(first="main"))
    with pytest.raises(OlpError) as found:
        plan_and_time(file, TimingJob(routine="pik"))
    (told,) = found.value.diagnostics
    assert (told.code, told.help) == ("I101", "did you mean pick?")
    assert main(["time", file, "--routine", "weld"]) == 2
    assert "it has half, main, pause, pick and 1 more" in capsys.readouterr().err
    assert read(file).main == "main"


DATA = "MODULE Data(SYSMODULE)\n  PERS num n:=3;\nENDMODULE\n"
RUNS = "MODULE Main\n  PROC main()\n    WaitTime n/10;\n  ENDPROC\nENDMODULE\n"


def test_modules_that_hold_data_alone_are_no_programs_of_a_cell(tmp_path, capsys):
    """As those of every RobotStudio backup: BASE.sys, USER.sys and the user's own."""
    (tmp_path / "Data.sys").write_text(DATA)
    (tmp_path / "Main.mod").write_text(RUNS)
    assert main(["time", str(tmp_path)]) == 0
    out, err = capsys.readouterr()
    assert "0.300" in out
    assert "Data.sys" not in out
    assert "left out: 1 of the folder's files, which hold data alone" in err
    assert main(["lint", str(tmp_path)]) == 0
    assert "unknown" not in capsys.readouterr().out
    assert main(["init", str(tmp_path)]) == 0
    out, err = capsys.readouterr()
    assert "1 programs" in out
    assert "I101" not in err
    assert main(["time", str(tmp_path / "Data.sys")]) == 2  # asked for it alone
    assert "I101" in capsys.readouterr().err
