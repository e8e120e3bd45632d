"""Assistants: a real client talks to `olp mcp` over stdio, with honest questions and hostile ones."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import anyio
import jsonschema
import pytest
from mcp import ClientSession, StdioServerParameters, stdio_client
from olp_process import run_olp

from olp.core.diagnostic import OlpError
from olp.servers.folder import Folder, ServerLimits
from olp.servers.mcp.tool import load_tool, tool_names
from olp.servers.mcp.worker import fit

ROOT = Path(__file__).parent.parent
JOB = "handling/HANDLING.JBI"
Call = tuple[str, dict[str, Any]]


def ask(root: Path, calls: list[Call], *options: str) -> tuple[dict[str, Any], list[Any]]:
    """One session: the tools by name, and one result per call, in order."""
    server = StdioServerParameters(
        command=sys.executable,
        args=["-m", "olp", "mcp", "--root", str(root), *options],
        env={"PYTHONPATH": str(ROOT)},
    )
    results: list[Any] = [None] * len(calls)

    async def one(session: ClientSession, number: int) -> None:
        name, arguments = calls[number]
        results[number] = await session.call_tool(name, arguments)

    async def whole() -> dict[str, Any]:
        with open(os.devnull, "w") as log:
            async with stdio_client(server, errlog=log) as streams, ClientSession(*streams) as session:
                told = await session.initialize()
                assert told.server_info.name == "olp"
                tools = {tool.name: tool for tool in (await session.list_tools()).tools}
                async with anyio.create_task_group() as group:
                    for number in range(len(calls)):
                        group.start_soon(one, session, number)
                # Whatever came before, it still answers.
                assert not (await session.call_tool("robots", {"robots": ["gp25"]})).is_error
                return tools

    return anyio.run(whole), results


def words(result: Any) -> str:
    return "\n".join(part.text for part in result.content)


def command_line(root: Path, *arguments: str) -> Any:
    return json.loads(run_olp(arguments, root, {**os.environ, "PYTHONPATH": str(ROOT)}).stdout)


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder as a user has it, with a second version in git."""
    root = tmp_path_factory.mktemp("cells")
    shutil.copytree(ROOT / "samples" / "inform" / "handling", root / "handling")
    shutil.copytree(ROOT / "samples" / "recordings" / "tuned", root / "tuned")
    budget = "[[budget]]\nname = 'promise'\njob = 'HANDLING'\nlimit_s = 9\n"
    with open(root / "olp.toml", "a") as settings:
        settings.write(budget)
    for command in (
        ["init", "-q"],
        ["add", "-A"],
        ["-c", "user.name=a", "-c", "user.email=a@b.example", "commit", "-qm", "1"],
    ):
        subprocess.run(["git", *command], cwd=root, check=True)
    job = root / JOB
    job.write_bytes(job.read_bytes().replace(b"TIMER T=0.35", b"TIMER T=1.35"))
    return root


QUESTIONS: dict[str, dict[str, Any]] = {
    "time": {"jobs": [JOB], "robot": "yaskawa/gp25"},
    "explain": {"job": JOB, "line": 40, "robot": "yaskawa/gp25"},
    "check": {"jobs": ["."], "robot": "yaskawa/gp25"},
    "lint": {"jobs": ["handling"], "robot": "yaskawa/gp25"},
    "diff": {"old": "HEAD", "new": ".", "robot": "yaskawa/gp25"},
    "convert": {"job": JOB, "to": "krl", "robot": "yaskawa/gp25"},
    "diagnose": {"recording": "tuned"},
    "robots": {"robots": ["gp25"]},
    "vendors": {},
}
WRITING: dict[str, dict[str, Any]] = {
    "annotate": {"job": JOB, "output": "new/HANDLING.JBI", "robot": "yaskawa/gp25"},
    "report": {"jobs": [JOB], "output": "report.html", "robot": "yaskawa/gp25"},
    "convert": {"job": JOB, "to": "krl", "robot": "yaskawa/gp25", "output": "krl"},
}


def listing(root: Path) -> dict[str, bytes]:
    return {str(p): p.read_bytes() for p in root.rglob("*") if p.is_file() and ".git" not in p.parts}


@pytest.fixture(scope="module")
def session(cell: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Tools and answers of a server that only reads; it must have left everything as it was."""
    before = listing(cell)
    tools, results = ask(cell, list(QUESTIONS.items()))
    assert listing(cell) == before
    return tools, dict(zip(QUESTIONS, results, strict=True))


def test_every_tool_that_reads_is_listed_with_typed_arguments_and_answers(session):
    tools, _ = session
    assert set(tools) == set(QUESTIONS) == {n for n in tool_names() if not load_tool(n).writes}
    for tool in tools.values():
        jsonschema.Draft202012Validator.check_schema(tool.input_schema)
        jsonschema.Draft202012Validator.check_schema(tool.output_schema)
        assert tool.input_schema["additionalProperties"] is False
        assert tool.annotations.read_only_hint
        for name, field in tool.input_schema["properties"].items():
            assert field.get("description"), (tool.name, name)


@pytest.mark.parametrize("name", QUESTIONS)
def test_every_tool_answers_in_the_form_that_it_promises(session, name):
    tools, results = session
    result = results[name]
    assert not result.is_error, words(result)
    jsonschema.validate(result.structured_content, tools[name].output_schema)
    assert json.loads(words(result)) == result.structured_content
    assert result.structured_content["truncated"] == []


def test_the_answers_are_those_of_the_command_line(session, cell):
    _, results = session
    robot = ("--robot", "yaskawa/gp25")
    answers = {name: result.structured_content for name, result in results.items()}
    assert answers["time"]["programs"] == command_line(cell, "time", JOB, "--format", "json", *robot)
    for name, paths in (("check", ["--no-cache", "."]), ("lint", ["handling"]), ("diff", ["HEAD", "."])):
        printed = command_line(
            cell, name, "--format", "json", *paths, *robot, *(["--all"] * (name == "diff"))
        )
        assert {k: v for k, v in printed.items() if k != "tables"}.items() <= answers[name].items()
    assert answers["robots"]["robots"] == command_line(cell, "robots", "gp25", "--format", "json")
    assert answers["diff"]["programs"][0]["change_s"] == pytest.approx(1.0, abs=1e-6)
    assert "limited" in answers["explain"]["text"]
    assert answers["diagnose"]["verdict"] == "explained"


def test_a_translation_comes_back_as_text_with_its_receipt(session):
    _, results = session
    answer = results["convert"].structured_content
    texts = {file["name"]: file["text"] for file in answer["files"]}
    assert "DEF HANDLING" in texts["HANDLING.src"]
    assert "E6POS" in texts["HANDLING.dat"]
    assert answer["receipt"]["totals"]["refused"] == 0


def test_with_write_files_are_written_where_they_were_asked_for_and_nowhere_else(cell, tmp_path):
    root = tmp_path / "root"
    shutil.copytree(cell, root)
    before = listing(root)
    (root / "new").mkdir()
    again = ("annotate", {**WRITING["annotate"], "output": JOB, "force": True})
    hidden = ("annotate", {**WRITING["annotate"], "output": ".git/config.jbi"})
    other = ("annotate", {**WRITING["annotate"], "output": "olp.toml", "force": True})
    away = ("report", {**WRITING["report"], "output": "../report.html"})
    tools, results = ask(root, [*WRITING.items(), again, hidden, other, away], "--write")
    assert set(tools) == set(tool_names())
    assert not tools["annotate"].annotations.read_only_hint
    for result in results[:3]:
        assert not result.is_error, words(result)
    for result in results[3:]:
        assert result.is_error
    written = {str(Path(name).relative_to(root)) for name in set(listing(root)) - set(before)}
    assert written == {
        str(Path(name))
        for name in ("new/HANDLING.JBI", "report.html", "krl/HANDLING.src", "krl/HANDLING.dat")
    }
    assert {name: data for name, data in listing(root).items() if name in before} == before
    assert sorted(os.listdir(tmp_path)) == ["root"]


# Hostile inputs


@pytest.fixture
def hostile(tmp_path: Path) -> Path:
    """A folder with traps, beside a file that must stay unread."""
    secret = (ROOT / "samples" / "inform" / "handling" / "DROP.JBI").read_bytes()
    (tmp_path / "DROP.JBI").write_bytes(secret)
    (tmp_path / "robot.toml").write_text("password = 'SECRET'\n")
    root = tmp_path / "root"
    shutil.copytree(ROOT / "samples" / "inform" / "handling", root / "handling")
    (root / "olp.toml").write_text("")  # so that none above is looked for
    (root / "link.jbi").symlink_to(tmp_path / "DROP.JBI")
    (root / "away").symlink_to(tmp_path)
    (root / "calls").mkdir()
    shutil.copy(root / JOB, root / "calls")
    (root / "calls" / "DROP.JBI").symlink_to(tmp_path / "DROP.JBI")
    (root / "settings").mkdir()
    shutil.copy(root / JOB, root / "settings")
    (root / "settings" / "olp.toml").symlink_to(tmp_path / "robot.toml")
    os.mkfifo(root / "pipe.jbi")
    (root / "binary.jbi").write_bytes(bytes(range(256)) * 64)
    (root / "empty.jbi").write_bytes(b"")
    with open(root / "huge.jbi", "wb") as huge:
        huge.truncate(ServerLimits().file + 1)
    (root / "many").mkdir()
    for number in range(ServerLimits().files + 1):
        (root / "many" / f"{number}.jbi").touch()
    return root


OUTSIDE = [
    "../DROP.JBI",
    "handling/../../DROP.JBI",
    "..\\DROP.JBI",
    "/etc/passwd",
    "C:\\cells\\MAIN.JBI",
    "\\\\server\\share\\MAIN.JBI",
    "//server/share/MAIN.JBI",
    "\\\\.\\PhysicalDrive0",
    "MAIN.JBI\0.txt",
    "x" * 100_000,
    "",
    "link.jbi",
    "away/DROP.JBI",
    "away/*.JBI",
    "/dev/zero",
]
REFUSED: list[tuple[str, dict[str, Any], str]] = [
    ("time", {"jobs": OUTSIDE}, "Z001"),
    ("time", {"jobs": ["l*.jbi"]}, "Z001"),
    ("time", {"jobs": ["pipe.jbi"]}, "Z002"),
    ("time", {"jobs": ["huge.jbi"]}, "Z003"),
    ("lint", {"jobs": ["many"]}, "Z004"),
    ("time", {"jobs": ["missing.jbi"]}, "C003"),
    ("time", {"jobs": ["binary.jbi"]}, '"total_s": null'),
    ("time", {"jobs": ["calls/HANDLING.JBI"], "robot": "yaskawa/gp25"}, "outside the folder"),
    ("time", {"jobs": ["settings/HANDLING.JBI"]}, "outside the folder"),
    ("time", {"jobs": [JOB], "robot": "away/robot.toml"}, "Z001"),
    ("check", {"jobs": [JOB], "assumptions": "../robot.toml"}, "Z001"),
    ("time", {"jobs": [JOB], "signature": "away/robot.toml"}, "Z001"),
    ("time", {"jobs": "handling"}, "must be a list"),
    ("time", {"jobs": [1, None, {}]}, "must be a text"),
    ("time", {"jobs": [JOB], "override_pct": "fast"}, "must be a number"),
    ("time", {"jobs": [JOB], "max_steps": 10**30}, "Z006"),
    ("time", {"jobs": [JOB], "rows": True}, "Z006"),
    ("time", {}, "'jobs' is missing"),
    ("time", {"jobs": [JOB], "output": "x"}, "there is no argument 'output'"),
    ("lint", {"jobs": ["--fix", "handling"]}, "C003"),
    ("lint", {"jobs": ["handling"], "select": ["W001 --fix"]}, ""),
    ("explain", {"job": JOB, "line": 9_999}, "E00"),
    ("diff", {"old": "HEAD~1", "new": "."}, "Z001"),
    ("diff", {"old": "--output=x", "new": "."}, "Z001"),
    ("convert", {"job": JOB, "to": "cobol"}, "X0"),
    ("convert", {"job": JOB, "to": "krl", "output": "krl"}, "Z007"),
    ("diagnose", {"recording": "away"}, "Z001"),
    ("report", WRITING["report"], "Z007"),
    ("os.system", {"command": "ls"}, "there is no tool"),
    ("../tool", {}, "there is no tool"),
]


def test_whatever_is_hostile_is_refused_with_a_message_and_the_server_lives_on(hostile):
    before = sorted(os.listdir(hostile))
    _, results = ask(hostile, [(name, arguments) for name, arguments, _ in REFUSED])
    for (name, arguments, wanted), result in zip(REFUSED, results, strict=True):
        asked = f"{name} {str(arguments)[:200]}: {words(result)[:9000]}"
        assert result.is_error, asked
        assert wanted in words(result), asked
        assert asked.count("Z001") >= (len(OUTSIDE) if arguments.get("jobs") is OUTSIDE else 0)
        assert "Traceback" not in asked
        assert "SECRET" not in words(result)
        assert "Z008" not in words(result), asked
    assert sorted(os.listdir(hostile)) == before


ENDLESS = """/JOB
//NAME ENDLESS
//POS
///NPOS 0,0,0,0,0,0
//INST
///DATE 2024/01/01 10:00
///ATTR SC,RW
///GROUP1 RB1
NOP
SET B000 0
*AGAIN
TIMER T=0.01
SET B000 0
JUMP *MORE IF B000=1
JUMP *AGAIN
*MORE
END
"""


def write_long(root: Path) -> None:
    """LONG.JBI, which keeps a worker busy for many seconds."""
    loops = "".join(f"FOR I{n:03d} = 0 TO 9999\n" for n in range(3)) + "ADD D000 1\n"
    loops += "".join(f"NEXT I{n:03d}\n" for n in reversed(range(3)))
    head, _, tail = ENDLESS.partition("SET B000 0\n*AGAIN")
    (root / "LONG.JBI").write_text(head + loops + tail.partition("*MORE\n")[2], newline="\r\n")


@pytest.mark.slow
def test_a_program_without_an_end_is_answered_and_a_call_out_of_time_is_ended(tmp_path):
    (tmp_path / "olp.toml").write_text("")
    (tmp_path / "ENDLESS.JBI").write_text(ENDLESS, newline="\r\n")
    calls: list[Call] = [("time", {"jobs": ["ENDLESS.JBI"], "max_steps": 1000})]
    _, (result,) = ask(tmp_path, calls)
    assert "no answer after" not in words(result)
    write_long(tmp_path)
    server = _Slow(tmp_path)
    assert "no answer after 1 s" in words(server.result)
    assert "max_steps" in words(server.result)


class _Slow:
    """A server whose calls may take one second; importing and two million steps take longer."""

    def __init__(self, root: Path) -> None:
        server = StdioServerParameters(
            command=sys.executable,
            args=["-m", "olp", "mcp", "--root", str(root), "--seconds", "1"],
            env={"PYTHONPATH": str(ROOT)},
        )
        self.result: Any = None

        async def whole() -> None:
            async with stdio_client(server) as streams, ClientSession(*streams) as session:
                await session.initialize()
                asked = {"jobs": ["LONG.JBI"], "max_steps": 2_000_000}
                self.result = await session.call_tool("time", asked)
                assert (await session.call_tool("time", {})).is_error

        anyio.run(whole)


def test_a_call_that_is_taken_back_leaves_nothing_running(tmp_path):
    root, temporary = tmp_path / "root", tmp_path / "temporary"
    root.mkdir()
    temporary.mkdir()
    (root / "olp.toml").write_text("")
    write_long(root)
    server = StdioServerParameters(
        command=sys.executable,
        args=["-m", "olp", "mcp", "--root", str(root)],
        env={"PYTHONPATH": str(ROOT), "TMPDIR": str(temporary)},
    )

    async def whole() -> None:
        async with stdio_client(server) as streams, ClientSession(*streams) as session:
            await session.initialize()
            async with anyio.create_task_group() as group:
                group.start_soon(session.call_tool, "time", {"jobs": ["LONG.JBI"]})
                while not os.listdir(temporary):
                    await anyio.sleep(0.02)
                group.cancel_scope.cancel()
            with anyio.fail_after(10):
                while os.listdir(temporary):  # the worker's folder goes when the worker has gone
                    await anyio.sleep(0.02)

    anyio.run(whole)


def test_an_olp_toml_above_the_folder_is_not_read(tmp_path):
    root = tmp_path / "root"
    shutil.copytree(ROOT / "samples" / "inform" / "handling", root)
    (root / "olp.toml").unlink()
    (tmp_path / "olp.toml").write_text("robot = 'SECRET'\n")
    _, (result,) = ask(root, [("time", {"jobs": ["HANDLING.JBI"]})])
    assert "outside the folder" in words(result)
    assert "SECRET" not in words(result)


# The parts


def test_paths_inside_are_taken_as_they_are_and_absolute_ones_are_shortened(tmp_path, monkeypatch):
    root = Path(os.path.realpath(tmp_path))
    monkeypatch.chdir(root)
    (root / "a").mkdir()
    (root / "a" / "B.JBI").touch()
    (root / "inner").symlink_to(root / "a")
    folder = Folder(root)
    assert folder.inside("a/B.JBI") == "a/B.JBI"
    assert folder.inside(str(root / "a" / "B.JBI")) == str(Path("a/B.JBI"))
    assert folder.inside("inner/B.JBI") == "inner/B.JBI"
    assert folder.inside(".") == "."
    assert folder.inside("-o.jbi") == "./-o.jbi"
    assert folder.programs(["*/*.JBI"], (".jbi",)) == ["*/*.JBI"]


def test_all_that_is_refused_is_told_at_once(tmp_path):
    with pytest.raises(OlpError) as refused:
        Folder(Path(os.path.realpath(tmp_path))).programs(["../x", "/etc/passwd", ""], (".jbi",))
    assert [d.code for d in refused.value.diagnostics] == ["Z001"] * 3


def test_long_lists_are_cut_and_it_is_said(tmp_path):
    whole = {"programs": [{"segments": list(range(1000))}], "files": [{"text": "x" * 50}] * 4}
    shown = fit(whole, 10, 10_000)
    assert shown["programs"][0]["segments"] == list(range(10))
    assert shown["truncated"] == ["programs[0].segments: 10 of 1000"]
    assert len(shown["files"]) == 4
    assert len(json.dumps(fit(whole, 1000, 1_000))) <= 1_000
    with pytest.raises(OlpError, match="Z010"):
        fit(whole, 1000, 200)


def test_a_missing_library_and_a_missing_folder_are_told(tmp_path, capsys, monkeypatch):
    from olp.__main__ import main

    assert main(["mcp", "--root", str(tmp_path / "nowhere")]) == 2
    assert "C015" in capsys.readouterr().err
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert main(["mcp"]) == 2
    assert 'pip install "olp[mcp]"' in capsys.readouterr().err


def test_nothing_that_lies_in_the_folder_is_imported(tmp_path):
    (tmp_path / "olp.toml").write_text("")
    for name in ("numpy", "lark", "olp", "json"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('imported from the served folder')\n")
    shutil.copy(ROOT / "samples" / "inform" / "handling" / "DROP.JBI", tmp_path)
    _, (result,) = ask(tmp_path, [("time", {"jobs": ["DROP.JBI"], "robot": "yaskawa/gp25"})])
    assert result.structured_content["programs"][0]["file"] == "DROP.JBI"
