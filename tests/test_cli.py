"""The command line: what every command promises, and what olp answers when something is wrong."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from argparse import ArgumentParser
from pathlib import Path

import pytest

from olp import cli
from olp.__main__ import main
from olp.cli.command import Parser
from olp.core.diagnostic import Diagnostic, OlpError
from olp.core.files import expand_paths, write_output
from olp.core.version import __version__
from olp.languages.vendor import program_files

ROOT = Path(__file__).parent.parent
HEAVY = {"numpy", "pandas", "lark", "rich", "jinja2", "scipy", "pyarrow", "multiprocessing"}

BAD_INPUT = """
from olp.core.diagnostic import OlpError, Span, error
SUMMARY = "fail in two places"
def add_arguments(parser): parser.add_argument("how")
def run(args):
    match args.how:
        case "input":
            raise OlpError(
                error("X001", "first", Span(3, 2, 4), file="a.jbi", source_line="ABCD", help="try harder"),
                error("X002", "second", file="b.jbi"),
            )
        case "missing": open("no/such/file")
        case "interrupt": raise KeyboardInterrupt
        case "finding": return 1
        case "flood":
            for line in range(100_000): print("line", line)
    return 0
"""


@pytest.fixture
def extra_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A command `olp go wrong`, added by nothing but a file in the folder of commands."""
    (tmp_path / "go_wrong.py").write_text(BAD_INPUT)
    monkeypatch.setattr(cli, "__path__", [*cli.__path__, str(tmp_path)])
    monkeypatch.delitem(sys.modules, "olp.cli.go_wrong", raising=False)


def run_olp(*words: str, **more: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "olp", *words],
        capture_output=True,
        text=True,
        encoding="utf-8",
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        **more,  # type: ignore[call-overload]
    )


# --- every command ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", cli.names())
def test_every_command_says_what_it_does_in_one_line_and_explains_its_arguments(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    summary = cli.load(name).SUMMARY
    assert "\n" not in summary
    assert 10 < len(summary) <= 80
    assert main([*name.split(), "--help"]) == 0
    assert f"usage: olp {name}" in capsys.readouterr().out


@pytest.mark.parametrize("name", cli.names())
def test_every_argument_is_explained(name: str) -> None:
    parser = ArgumentParser()
    cli.load(name).add_arguments(parser)
    assert [action.dest for action in parser._actions if not action.help] == []


@pytest.mark.parametrize("name", cli.names())
def test_every_command_answers_an_unknown_option_with_a_diagnostic(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*name.split(), "--no-such-option"]) == 2
    assert capsys.readouterr().err.startswith("error[C002]: ")


@pytest.mark.parametrize(
    ("name", "words", "key", "paths"),
    [
        ("check", "a --format json b -o x c", "paths", ["a", "b", "c"]),
        ("lint", "--format json a --select W001 b", "paths", ["a", "b"]),
        ("diff", "A B --format json c --all d", "paths", ["c", "d"]),
        ("diff", "A --format json B", "new", "B"),
        ("report", "a -o x b", "paths", ["a", "b"]),
        ("time", "a --format json b", "jobs", ["a", "b"]),
        ("time", "a -- --b", "jobs", ["a", "--b"]),
    ],
)
def test_options_may_stand_between_paths(name: str, words: str, key: str, paths: object) -> None:
    parser = Parser(f"olp {name}", "")
    cli.load(name).add_arguments(parser)
    assert getattr(parser.parse_words(words.split()), key) == paths


def test_the_listing_of_the_folder_is_the_list_of_commands() -> None:
    files = {file.stem for file in (ROOT / "olp/cli").glob("[!_]*.py")} - {"command"}
    assert {name.replace(" ", "_").replace("-", "_") for name in cli.names()} == files


def test_help_names_every_command_and_imports_nothing_heavy_in_under_0_3_s() -> None:
    script = (
        "import sys, time; from olp.__main__ import main; main(['--help']);"
        f"print(sorted({HEAVY!r} & set(sys.modules)), time.process_time())"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True
    )
    *help_text, last = done.stdout.splitlines()
    for name in cli.names():
        assert any(line.startswith(f"  {name} ") for line in help_text)
    heavy, seconds = last.rsplit(" ", 1)
    assert heavy == "[]"
    assert float(seconds) < 0.3


def test_version_is_the_one_the_wheel_carries(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"olp {__version__}\n"


def test_without_a_command_the_help_is_shown_and_nothing_is_claimed_done(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main([]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert "olp help COMMAND" in output.err


# --- what goes wrong -------------------------------------------------------------------------------------


def test_a_mistyped_command_is_answered_with_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robtos"]) == 2
    assert capsys.readouterr().err == (
        "error[C001]: there is no command 'robtos'\n"
        "help: did you mean: olp robots? olp --help lists the commands\n"
    )


@pytest.mark.usefixtures("extra_command")
def test_a_new_file_is_a_new_command_and_its_first_word_alone_names_it(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["--help"]) == 0
    assert re.search("^  go wrong +fail in two places$", capsys.readouterr().out, re.MULTILINE)
    assert main(["go", "wrong", "finding"]) == 1
    assert main(["go"]) == 2
    assert "did you mean: olp go wrong?" in capsys.readouterr().err


def test_a_line_of_a_binary_file_does_not_steer_the_terminal() -> None:
    line = "DEF\x1b[2J\x00\x9bA\tB"
    shown = Diagnostic("P400", "no text", line=1, column=4, end_column=5, source_line=line).render()
    assert "1 | DEF [2J  A B" in shown


@pytest.mark.usefixtures("extra_command")
def test_all_problems_are_printed_with_their_places_and_the_status_is_2(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["go", "wrong", "input"]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err == (
        "error[X001]: first\n  --> a.jbi:3:2\n3 | ABCD\n  |  ^^\nhelp: try harder\n\n"
        "error[X002]: second\n  --> b.jbi\n"
    )


@pytest.mark.usefixtures("extra_command")
def test_what_the_system_refuses_is_one_diagnostic_that_names_the_file(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["go", "wrong", "missing"]) == 2
    assert capsys.readouterr().err == (
        "error[C005]: No such file or directory\n  --> no/such/file\n"
        "help: create the folder first, or name another one\n"
    )


@pytest.mark.usefixtures("extra_command")
def test_an_interrupt_ends_in_silence_with_the_status_of_a_shell(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["go", "wrong", "interrupt"]) == 130
    assert capsys.readouterr() == ("", "")


def test_a_reader_that_stops_reading_is_no_error(tmp_path: Path) -> None:
    (tmp_path / "go_wrong.py").write_text(BAD_INPUT)
    script = (
        f"from olp import cli; cli.__path__.append({str(tmp_path)!r});"
        "from olp.__main__ import main; raise SystemExit(main(['go', 'wrong', 'flood']))"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", script], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert process.stdout is not None
    assert process.stderr is not None
    assert process.stdout.readline().rstrip() == b"line 0"
    process.stdout.close()
    complaints = process.stderr.read()
    process.stderr.close()
    assert complaints == b""
    assert process.wait() == 128 + signal.SIGPIPE


def test_a_name_that_the_terminal_cannot_show_does_not_stop_the_answer(tmp_path: Path) -> None:
    done = run_olp("robots", "日本語.toml", cwd=tmp_path)
    assert done.returncode == 2
    assert "日本語.toml" in done.stderr
    ascii_only = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "ascii"}
    for words in (["robots"], ["--help"]):
        plain = subprocess.run([sys.executable, "-m", "olp", *words], env=ascii_only, capture_output=True)
        assert plain.returncode == 0, plain.stderr


# --- input files -----------------------------------------------------------------------------------------


def make_files(folder: Path, *names: str) -> None:
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(b"")


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", ">&- 2>&-"])
def test_closed_streams_stop_nothing(closed: str) -> None:
    command = f'"{sys.executable}" -m olp time samples/inform/twins/base.jbi {closed}'
    done = subprocess.run(["sh", "-c", command], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0
    assert "Traceback" not in done.stderr
    assert ("total" in done.stdout) is (">&-" not in closed.replace("2>&-", ""))


def test_folders_are_searched_in_order_and_files_are_taken_as_they_are(tmp_path: Path) -> None:
    make_files(tmp_path, "b/Z.JBI", "b/a.jbi", "b/c/d.Jbi", "b/notes.txt", "odd.txt")
    found = expand_paths([tmp_path / "odd.txt", tmp_path / "b"], [".jbi"])
    assert [file.relative_to(tmp_path).as_posix() for file in found] == [
        "odd.txt",
        "b/Z.JBI",
        "b/a.jbi",
        "b/c/d.Jbi",
    ]


def test_a_file_named_twice_comes_once(tmp_path: Path) -> None:
    make_files(tmp_path, "a.jbi")
    assert expand_paths([tmp_path / "a.jbi", tmp_path, f"{tmp_path}/./a.jbi"], [".jbi"]) == [
        tmp_path / "a.jbi"
    ]


def test_patterns_that_the_shell_left_alone_are_expanded(tmp_path: Path) -> None:
    make_files(tmp_path, "a1.jbi", "a2.jbi", "b.jbi", "x[1].jbi")
    assert [file.name for file in expand_paths([tmp_path / "a?.jbi"], [".jbi"])] == ["a1.jbi", "a2.jbi"]
    assert [file.name for file in expand_paths([tmp_path / "x[1].jbi"], [".jbi"])] == ["x[1].jbi"]


def test_a_file_of_another_maker_with_a_programs_suffix_is_left_alone_in_a_folder(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "samples/backup/dx200", tmp_path / "backup")
    shutil.copy(ROOT / "samples/inform/twins/base.jbi", tmp_path / "backup")
    module = "MODULE Base(SYSMODULE)\n    VAR num count:=0;\nENDMODULE\n"
    (tmp_path / "backup/BASE.SYS").write_text(module)
    (tmp_path / "backup/LOST.SYS").symlink_to("nowhere")
    names = [file.name for file in program_files([tmp_path / "backup"])]
    assert names == [
        "BASE.SYS",
        "LOST.SYS",
        "base.jbi",
    ]  # not SYSTEM.SYS; who reads LOST.SYS tells that it is gone
    named = tmp_path / "backup/SYSTEM.SYS"
    assert program_files([named]) == [named]


def test_a_folder_without_programs_says_which_names_are_looked_for(tmp_path: Path) -> None:
    make_files(tmp_path, "notes.txt")
    with pytest.raises(OlpError) as caught:
        expand_paths([tmp_path], [".jbi", ".src"])
    (problem,) = caught.value.diagnostics
    assert problem.help == "their names end in .jbi .src"


def test_everything_missing_or_empty_is_reported_at_once(tmp_path: Path) -> None:
    make_files(tmp_path, "a.jbi", "empty/readme.txt")
    wanted = ["no.jbi", "empty", "*.prg"]
    with pytest.raises(OlpError) as caught:
        expand_paths([tmp_path / name for name in wanted], [".jbi"])
    assert [(d.code, Path(d.file).name) for d in caught.value.diagnostics] == [
        ("C003", "no.jbi"),
        ("C004", "empty"),
        ("C003", "*.prg"),
    ]


@pytest.mark.parametrize("command", [["time"], ["lint"], ["check", "--no-cache"], ["annotate", "-o", "out"]])
def test_a_file_that_is_missing_is_told_and_the_others_are_answered(command, tmp_path, monkeypatch, capsys):
    job = Path(__file__).parent.parent / "samples" / "inform" / "palletising" / "PICK.JBI"
    monkeypatch.chdir(tmp_path)
    assert main([command[0], str(job), "no.jbi", "*.prg", *command[1:]]) == 2
    told = "".join(capsys.readouterr())
    assert "no.jbi" in told
    assert "*.prg" in told
    assert "PICK.JBI" in told


# --- output files ----------------------------------------------------------------------------------------


def test_output_is_written_as_given_and_nothing_is_left_beside_it(tmp_path: Path) -> None:
    write_output(tmp_path / "out.jbi", b"/JOB\r\n\x1a")
    write_output(tmp_path / "out.jbi", b"again")
    assert (tmp_path / "out.jbi").read_bytes() == b"again"
    assert [file.name for file in tmp_path.iterdir()] == ["out.jbi"]


@pytest.mark.parametrize("target", [None, "-"])
def test_standard_output_gets_the_same_bytes(
    target: str | None, capfdbinary: pytest.CaptureFixture[bytes]
) -> None:
    write_output(target, b"A\r\nB\n\xe9")
    assert capfdbinary.readouterr().out == b"A\r\nB\n\xe9"


def test_an_input_is_never_overwritten_under_any_name_unless_asked(tmp_path: Path) -> None:
    source, link, hard = tmp_path / "a.jbi", tmp_path / "link.jbi", tmp_path / "hard.jbi"
    source.write_bytes(b"old")
    hard.hardlink_to(source)
    link.symlink_to(source)
    for name in (source, f"{tmp_path}/../{tmp_path.name}/a.jbi", link, hard):
        with pytest.raises(OlpError, match="C006"):
            write_output(name, b"new", inputs=[tmp_path / "other.jbi", source])
    assert source.read_bytes() == b"old"
    write_output(link, b"new", inputs=[source], in_place=True)
    assert source.read_bytes() == b"new"
    assert link.is_symlink()


def test_a_write_that_fails_leaves_the_old_file_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "out.jbi"
    target.write_bytes(b"old")
    monkeypatch.setattr(os, "fsync", lambda _: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    with pytest.raises(OSError, match="No space"):
        write_output(target, b"new")
    assert target.read_bytes() == b"old"
    assert [file.name for file in tmp_path.iterdir()] == ["out.jbi"]


def test_a_missing_folder_is_named_not_the_temporary_file(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as caught:
        write_output(tmp_path / "no" / "out.jbi", b"new")
    assert caught.value.filename == str(tmp_path / "no")


def test_permissions_survive_and_devices_are_written_through(tmp_path: Path) -> None:
    target = tmp_path / "out.jbi"
    target.write_bytes(b"old")
    target.chmod(0o640)
    write_output(target, b"new")
    assert target.stat().st_mode & 0o777 == 0o640
    write_output("/dev/null", b"new")
    assert Path("/dev/null").is_char_device()


# --- olp robots ------------------------------------------------------------------------------------------


def test_robots_lists_the_whole_library_in_every_form(capsys: pytest.CaptureFixture[str]) -> None:
    in_library = sorted(
        file.relative_to(ROOT / "olp/robots").with_suffix("").as_posix()
        for file in (ROOT / "olp/robots").glob("*/*.toml")
    )
    assert main(["robots"]) == 0
    lines = capsys.readouterr().out.split("\n\n")[0].splitlines()[1:]
    assert [line.split()[0] for line in lines] == in_library
    assert main(["robots", "--format", "json"]) == 0
    assert [robot["robot"] for robot in json.loads(capsys.readouterr().out)] == in_library
    assert main(["robots", "--format", "markdown"]) == 0
    rows = capsys.readouterr().out.splitlines()
    assert [row.split("|")[1].strip() for row in rows[2:]] == in_library
    assert len({row.count("|") for row in rows}) == 1


def test_robots_counts_what_is_known_of_some_axes_only(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robots", "ma2010", "sia20d", "ar2010"]) == 0
    rows = {line.split()[0]: line.split("  ")[-1] for line in capsys.readouterr().out.splitlines()[1:4]}
    assert rows == {"yaskawa/ma2010": "5 of 6", "yaskawa/sia20d": "unknown", "yaskawa/ar2010": "known"}


def test_robots_gives_the_source_of_every_group_of_numbers_when_asked(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["robots", "--format", "json", "--verbose"]) == 0
    for robot in json.loads(capsys.readouterr().out):
        assert robot["sources"]
        assert all(robot["sources"].values())
        assert set(robot["inferred"]) <= set(robot["sources"])
    assert main(["robots", "--verbose", "yaskawa/ma2010"]) == 0
    assert "\n    limits" in capsys.readouterr().out


def test_robots_states_limits_in_the_units_of_the_data_sheet(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robots", "--format", "json", "yaskawa/ma2010"]) == 0
    first = json.loads(capsys.readouterr().out)[0]["axes"][0]
    assert (first["axis"], first["speed_deg_s"]) == ("S", pytest.approx(197.0))


def test_robots_reports_every_unknown_name_at_once(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robots", "nobody/knows", "yaskawa/ma2010", "no/file.toml"]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert "nobody/knows" in output.err
    assert "no/file.toml" in output.err
