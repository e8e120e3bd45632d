"""`olp serve`: who is let in, and that what the page is told is what the command line says."""

from __future__ import annotations

import io
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import zipfile
from argparse import ArgumentTypeError
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote
from urllib.request import urlopen

import pytest
from starlette.testclient import TestClient

from olp.__main__ import dispatch, main
from olp.checks.what_if import LineEdit, editable_lines, what_if
from olp.cli import serve
from olp.cli.command import Parser
from olp.core.diagnostic import OlpError
from olp.identification.timing_job import TimingJob, time_program
from olp.languages.vendor import read
from olp.servers.confinement import captured
from olp.servers.web import app as web
from olp.servers.web.answers import diagnose
from olp.servers.web.app import WorkerPool
from olp.servers.web.desk import DROPPED, Desk, WorkerSetting, plain_path, recording_of

ROOT = Path(__file__).parent.parent
SAMPLES = ROOT / "samples"
ROBOT = "yaskawa/gp25"
TOKEN, PORT = "right-token", 8123
JOB = "handling/HANDLING.JBI"


def client(app: Any, path: str = f"/{TOKEN}/") -> TestClient:
    return TestClient(app, base_url=f"http://127.0.0.1:{PORT}{path}", raise_server_exceptions=False)


def setting(root: Path) -> WorkerSetting:
    return WorkerSetting(str(root), "", TimingJob(robot=ROBOT), (f"--robot={ROBOT}",))


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cell in a git repository, with a link that leads out and a pipe."""
    made = Path(os.path.realpath(tmp_path_factory.mktemp("served"))) / "cell"
    shutil.copytree(SAMPLES / "inform" / "handling", made / "handling")
    shutil.copytree(SAMPLES / "krl", made / "krl")
    for words in (
        ["init", "-q"],
        ["add", "-A"],
        ["-c", "user.name=a", "-c", "user.email=a@b.example", "commit", "-qm", "1"],
    ):
        subprocess.run(["git", *words], cwd=made, check=True)
    job = made / JOB
    job.write_bytes(job.read_bytes().replace(b"TIMER T=0.35", b"TIMER T=1.35"))
    (made.parent / "SECRET.JBI").write_bytes(job.read_bytes())
    (made / "LINK.txt").symlink_to(made.parent / "SECRET.JBI")
    if hasattr(os, "mkfifo"):
        os.mkfifo(made / "PIPE.txt")
    return made


@pytest.fixture(scope="module")
def site(root: Path) -> Iterator[TestClient]:
    with client(web.web_app(WorkerPool(setting(root), 60.0), "cell", TOKEN, PORT)) as opened:
        yield opened


def asked(site: TestClient, what: str, status: int = 200, **given: Any) -> Any:
    reply = site.post(f"api/{what}", content=json.dumps(given))
    assert reply.status_code == status, reply.text
    return reply.json()


def codes(told: Any) -> set[str]:
    return {d["code"] for d in told["diagnostics"]}


def said(*words: str) -> bytes:
    return captured(dispatch, words).printed


# Who is let in


class Silent:
    """A pool that nobody may ask."""

    async def warm(self) -> None: ...

    async def close(self) -> None: ...


@pytest.mark.parametrize(
    ("path", "headers", "status"),
    [
        (f"/{TOKEN}/", {}, 200),
        (f"/{TOKEN}/", {"host": f"localhost:{PORT}"}, 200),
        (f"/{TOKEN}/", {"origin": f"http://127.0.0.1:{PORT}"}, 200),
        ("/", {}, 404),
        (f"/{TOKEN}", {}, 404),
        (f"/{TOKEN[:-1]}/", {}, 404),
        (f"/{TOKEN}x/", {}, 404),
        (f"/x/../{TOKEN}x/serve.js", {}, 404),
        ("/%00/", {}, 404),
        ("/ä/", {}, 404),
        (f"/{TOKEN}/", {"host": "evil.example"}, 400),
        (f"/{TOKEN}/", {"host": f"evil.example:{PORT}"}, 400),
        (f"/{TOKEN}/", {"host": f"127.0.0.1:{PORT + 1}"}, 400),
        (f"/{TOKEN}/", {"host": ""}, 400),
        (f"/{TOKEN}/", {"origin": "http://evil.example"}, 403),
        (f"/{TOKEN}/", {"origin": "null"}, 403),
    ],
)
def test_only_who_knows_the_token_and_asks_this_host_is_let_in(path, headers, status):
    app = web.web_app(Silent(), "cell", TOKEN, PORT)  # type: ignore[arg-type]
    reply = client(app, "").get(path, headers=headers)
    assert reply.status_code == status
    assert not [name for name in reply.headers if name.startswith("access-control")]
    policy = reply.headers["content-security-policy"]
    assert "frame-ancestors" in policy
    assert reply.headers["referrer-policy"] == "no-referrer"
    assert reply.headers["cache-control"] == "no-store"
    if status == 200:
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
    else:
        assert TOKEN not in reply.text


def test_the_page_loads_nothing_from_elsewhere():
    for name in ("serve.html", "serve.css", "serve.js", "serve_problem.html.j2"):
        text = (ROOT / "templates" / name).read_text()
        assert not re.search(r"https?://|//[a-z]+\.[a-z]", text)
        assert "innerHTML" not in text
        assert not re.search(r"\son\w+=", text)


# What is told


def test_the_cell_is_that_of_olp_time_and_is_not_timed_again_unless_a_file_changes(site, root, monkeypatch):
    monkeypatch.chdir(root)
    cell = asked(site, "cell")
    known = {
        one["file"]: one
        for one in json.loads(said("time", ".", "--robot", ROBOT, "--format", "json", "--top", "10"))
    }
    assert {one["file"] for one in cell["programs"]} == set(known)
    for one in cell["programs"]:
        assert one["total_s"] == known[one["file"]]["total_s"]
        assert (one["depth"] == 0) == known[one["file"]]["started"]
    assert [one["file"] for one in cell["programs"]].index("handling/DROP.JBI") == 1, "below its caller"
    assert cell["total_s"] == pytest.approx(
        sum(one["total_s"] for one in known.values() if one["started"]), abs=1e-9
    )
    assert sum(cell["by_cause"].values()) == pytest.approx(cell["total_s"], abs=1e-6)
    assert cell["lines"][0]["seconds"] == max(
        line["seconds"] for one in known.values() if one["started"] for line in one["top"]
    )
    assert asked(site, "cell") == cell
    job, before = root / JOB, (root / JOB).read_bytes()
    try:
        job.write_bytes(before.replace(b"T=1.35", b"T=2.35"))
        assert asked(site, "cell")["total_s"] == pytest.approx(cell["total_s"] + 1.0, abs=1e-9)
    finally:
        job.write_bytes(before)


@pytest.mark.parametrize(
    ("file", "override"),
    [(JOB, None), ("krl/handling.src", None), (JOB, 40.0)],
    ids=["inform", "krl", "override"],
)
def test_what_if_says_what_olp_time_says_of_the_edited_file(site, root, tmp_path, file, override):
    lines = asked(site, "what_if_lines", file=file)
    spoken = [one for one in lines["lines"] if one["speed"] and one["seconds"]]
    changes = [{"line": one["line"], "speed": one["speed"] / 2} for one in spoken[:2]]
    zoned = next(one for one in lines["lines"] if one["zones"] and one["seconds"])
    changes.append({"line": zoned["line"], "zone": zoned["zones"][-1][0]})
    given = {"file": file, "digest": lines["digest"], "changes": changes}
    given |= {} if override is None else {"override": override}
    before = (root / file).read_bytes()
    told = asked(site, "what_if_times", **given)
    reply = site.get(f"download?given={quote(json.dumps(given))}")
    assert reply.headers["content-disposition"] == f'attachment; filename="{Path(file).name}"'
    assert (root / file).read_bytes() == before != reply.content
    edited = shutil.copytree(root / Path(file).parent, tmp_path / "edited") / Path(file).name
    edited.write_bytes(reply.content)
    more = [] if override is None else ["--override", str(override)]
    total = json.loads(said("time", str(edited), "--robot", ROBOT, "--format", "json", *more))[0]["total_s"]
    assert abs(told["total_s"] - total) <= 1e-9
    assert told["before_s"] == lines["total_s"] != told["total_s"]


def made_at_any_time(html: str) -> str:
    return re.sub(r"\d{4}-\d\d-\d\d \d\d:\d\d", "", html)


def test_the_page_of_a_program_is_that_of_olp_report_edited_as_well(site, root, tmp_path, monkeypatch):
    monkeypatch.chdir(root)
    page = site.get(f"page?given={quote(json.dumps({'file': JOB}))}")
    title = f"--title={Path(JOB).name}"
    main(["report", JOB, "-o", str(tmp_path / "page.html"), "--robot", ROBOT, title])
    assert made_at_any_time(page.text) == made_at_any_time((tmp_path / "page.html").read_text("utf-8"))
    lines = asked(site, "what_if_lines", file=JOB)
    line = next(one for one in lines["lines"] if one["speed"] == 250.0)
    given = {"file": JOB, "digest": lines["digest"], "changes": [{"line": line["line"], "speed": 123.0}]}
    assert "V=123.0" in site.get(f"page?given={quote(json.dumps(given))}").text
    assert "V=123.0" not in site.get(f"page?given={quote(json.dumps({'file': JOB}))}").text


def test_two_versions_are_compared_as_olp_diff_does(site, root, monkeypatch):
    monkeypatch.chdir(root)
    words = ("--robot", ROBOT, "--all", "--format", "json")
    assert asked(site, "compare", old="", new=JOB) == json.loads(said("diff", "HEAD", ".", JOB, *words))
    other = "handling/DROP.JBI"
    assert asked(site, "compare", old=JOB, new=other) == json.loads(said("diff", JOB, other, *words))


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("every-column/moves.csv", "."),
        ("logs/run.mcap", "imported"),
        ("logs/fanuc.csv", "imported"),
        ("dx200/log.csv", "imported"),
        ("trace/PALLET_PROG.TXT", "imported"),
        ("tuned/PICK-7.JBI", None),
    ],
)
def test_recordings_are_found_or_made_of_what_was_dropped(root, tmp_path, source, found):
    folder = Path(shutil.copytree((SAMPLES / "recordings" / source).parent, tmp_path / "all"))
    name = Path(source).name
    for file in folder.iterdir():
        if file.is_file() and file.name != name and not name.startswith("PALLET"):
            file.unlink()
    desk = Desk(setting(root), tmp_path, dispatch)
    if found is None:
        with pytest.raises(OlpError, match="Z013"):
            recording_of(desk, folder, "")
    else:
        made = recording_of(desk, folder, "")
        assert made == folder / found
        assert len((made / "moves.csv").read_text().splitlines()) > 2


def test_a_table_of_times_becomes_a_recording_of_the_program_that_ran(root, tmp_path):
    (tmp_path / "times.csv").write_text("line,duration_s\n40,0.5\n41,0.9\n")
    made = recording_of(Desk(setting(root), tmp_path, dispatch), tmp_path, str(root / JOB))
    assert "HANDLING.JBI" in (made / "moves.csv").read_text()
    assert recording_of(Desk(setting(root), tmp_path, dispatch), tmp_path, "") == made, "it is there by now"


def test_a_dropped_recording_is_diagnosed_as_the_command_line_does(site, tmp_path, monkeypatch):
    trace = SAMPLES / "recordings" / "trace"
    files = [("file", (f"trace/{one.name}", one.read_bytes())) for one in sorted(trace.iterdir())]
    told = site.post("api/diagnose", files=files)
    assert told.status_code == 200, told.text
    page = site.get(told.json()["page"])
    monkeypatch.chdir(tmp_path)
    for words in (
        [
            "recording",
            "import",
            *map(str, sorted(trace.iterdir())),
            "--robot",
            ROBOT,
            "-o",
            "recording/imported",
        ],
        ["diagnose", "recording/imported", "--html", "page.html"],
    ):
        main(words)
    assert made_at_any_time(page.text) == made_at_any_time((tmp_path / "page.html").read_text("utf-8"))
    assert site.get("result?key=unknown").status_code == 422


# What is refused


@pytest.mark.parametrize(
    ("file", "code"),
    [
        ("../SECRET.JBI", "Z001"),
        ("handling/../../SECRET.JBI", "Z001"),
        ("/etc/passwd", "Z001"),
        ("LINK.txt", "Z001"),
        ("PIPE.txt", "Z002"),
        ("C:\\Windows\\win.ini", "Z001"),
        ("\\\\server\\share", "Z001"),
        ("a\0b", "Z001"),
        ("", "Z001"),
        ("GONE.JBI", "P004"),
        ("handling", "Z002"),
        ("\ud800", "Z001"),
        (7, "Z006"),
        (None, "Z006"),
    ],
)
def test_only_plain_files_of_the_folder_are_read(site, file, code):
    for what in ("what_if_lines", "what_if_times"):
        told = asked(site, what, 422, file=file)
        assert codes(told) == {code}
        assert "Traceback" not in json.dumps(told)
    page = site.get(f"page?given={quote(json.dumps({'file': file}))}")
    assert page.status_code == 422
    assert "This cannot be shown" in page.text
    assert "SECRET" not in page.text.replace("SECRET.JBI", "")
    told = asked(site, "compare", 422, old=JOB, new=file)
    assert told["diagnostics"]


@pytest.mark.parametrize(
    ("given", "code"),
    [
        ({"changes": [{"line": 1, "speed": 5.0}]}, "O005"),
        ({"changes": [{"line": 40, "speed": -1.0}]}, "O006"),
        ({"changes": [{"line": 40, "zone": 99}]}, "O011"),
        ({"changes": [{"line": 10**30, "zone": 1}]}, "O011"),
        ({"changes": [{"line": "40"}]}, "Z006"),
        ({"changes": [{"line": True}]}, "Z006"),
        ({"changes": [{"speed": 3.0}]}, "Z006"),
        ({"changes": "all"}, "Z006"),
        ({"override": 0}, "Z006"),
        ({"override": "fast"}, "Z006"),
        ({"digest": "of another text"}, "Z011"),
    ],
)
def test_changes_that_cannot_be_are_told(site, given, code):
    digest = asked(site, "what_if_lines", file=JOB)["digest"]
    assert codes(asked(site, "what_if_times", 422, **{"file": JOB, "digest": digest, **given})) == {code}


@pytest.mark.parametrize(
    "body", [b"", b"[]", b"{", b"\xff", b"[" * 100_000, b'{"file": NaN}', b"0" * 1_100_000]
)
def test_a_request_that_is_none_is_told(site, body):
    reply = site.post("api/what_if_lines", content=body)
    assert reply.status_code == 422
    assert codes(reply.json()) <= {"Z003", "Z006"}


def archive(files: dict[str, bytes]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, data in files.items():
            packed.writestr(name, data)
    return out.getvalue()


@pytest.mark.parametrize(
    ("name", "data", "code"),
    [
        ("x.csv", b"", "D002"),
        ("x.csv", b"a;;b", "D011"),
        ("x.txt", b"nothing", "Z013"),
        ("x.zip", b"PK\x03\x04 no archive", "Z012"),
        ("x.zip", lambda: archive({"../moves.csv": b"move\n"}), "Z012"),
        ("x.zip", lambda: archive({"a.txt": b"", "b.txt": b""}), "Z013"),
        (
            "x.zip",
            lambda: archive({"a": b"0" * 250_000_000}),
            "Z003",
        ),  # two seconds of each worker that collects
        ("x.zip", lambda: archive({str(n): b"" for n in range(501)}), "Z012"),
    ],
)
def test_files_that_are_no_recording_are_told(root, tmp_path, monkeypatch, name, data, code):
    (tmp_path / DROPPED).mkdir()
    (tmp_path / DROPPED / name).write_bytes(data if isinstance(data, bytes) else data())
    monkeypatch.chdir(tmp_path)
    with pytest.raises(OlpError) as refused:
        diagnose(Desk(setting(root), tmp_path, dispatch), {})
    assert code in {d.code for d in refused.value.diagnostics}
    assert str(tmp_path) not in str(refused.value)
    assert all(one.is_relative_to(tmp_path / DROPPED) for one in tmp_path.rglob("*.*"))


@pytest.mark.parametrize(("name", "code"), [("x.csv", "D002"), ("a/../../moves.csv", "Z012"), ("", "Z006")])
def test_uploads_that_are_no_recording_are_told(site, name, code):
    reply = site.post("api/diagnose", files=[("file", (name, b""))])
    assert reply.status_code == 422
    assert codes(reply.json()) == {code}


def test_an_upload_is_cut_off_at_its_limit_whatever_its_header_says(monkeypatch):
    monkeypatch.setattr(web, "MOST_BYTES", 10_000)
    app = web.web_app(Silent(), "cell", TOKEN, PORT)  # type: ignore[arg-type]
    reply = client(app).post("api/diagnose", files=[("file", ("moves.csv", b"0" * 20_000))])
    assert codes(reply.json()) == {"Z003"}
    assert client(app).post("api/diagnose", content=b"no form").status_code == 422
    assert codes(client(app).post("api/format_disk", content=b"{}").json()) == {"Z006"}


@pytest.mark.parametrize(
    "name", ["", ".", "..", "a//b", "a/", "/a", "a\\b", "c:x", "a\nb", "a.", "a ", "/".join("abcdefghij")]
)
def test_names_of_uploads_lead_nowhere_else(name):
    with pytest.raises(OlpError, match="Z012"):
        plain_path(name)


def test_nothing_in_the_folder_was_written(site, root):
    changed = subprocess.run(
        ["git", "status", "--porcelain"], cwd=root, capture_output=True, text=True, check=True
    )
    assert set(changed.stdout.split("\n")) == {f" M {JOB}", "?? LINK.txt", ""}


def test_an_answer_that_takes_too_long_is_ended_and_the_next_question_answered_by_the_olp_toml_above(
    tmp_path,
):
    above = Path(os.path.realpath(tmp_path))
    root = Path(shutil.copytree(SAMPLES / "krl", above / "served"))
    (above / "olp.toml").write_text("robot = 'kuka/kr210-r2700-prime'\n")
    parser = Parser("olp serve", "")
    serve.add_arguments(parser)
    pool = WorkerPool(serve._setting(parser.parse_words([str(root)]), root), 0.01)
    with client(web.web_app(pool, "cell", TOKEN, PORT)) as site:
        assert codes(asked(site, "cell", 422)) == {"Z005"}
        pool._seconds = 60.0
        total = asked(site, "what_if_lines", file="handling.src")["total_s"]
    assert total == json.loads(said("time", str(root / "handling.src"), "--format", "json"))[0]["total_s"]


# The parts


def test_every_line_that_is_offered_can_be_changed_as_offered(root):
    program = read(root / JOB)
    for one in editable_lines(program):
        for n, says in one.zones:
            (text,) = what_if(program, [LineEdit(one.line, zone=n)]).sources
            assert says in text.line(one.line)
            assert [i for i, line in enumerate(program.source.lines, 1) if line != text.line(i)] == [one.line]
    assert what_if(program, []).sources == ()
    untouched = time_program(what_if(program, []).program, TimingJob(robot=ROBOT), root / "handling")
    assert untouched.total_s == time_program(program, TimingJob(robot=ROBOT)).total_s


def test_names_that_other_lists_declare_keep_their_meaning_in_the_edited_program(tmp_path):
    (tmp_path / "shared.dat").write_text("DEFDAT SHARED PUBLIC\nGLOBAL SIGNAL DI_READY $IN[5]\nENDDAT\n")
    job = tmp_path / "main.src"
    move = "LIN {X 900,Y 0,Z 900,A 0,B 90,C 0}"
    job.write_text(f"DEF MAIN()\nWAIT FOR DI_READY\n{move}\n{move} C_DIS\nEND\n")
    program = read(job)
    assert [one.line for one in editable_lines(program) if one.zones] == [3], "C_DIS is no number to change"
    edited = what_if(program, [LineEdit(3, zone=1)]).program
    waits = [next(iter(one.statements())) for one in (program, edited)]
    assert waits[0] == waits[1]
    assert "Signal" in repr(waits[0])


def test_a_packed_program_and_a_project_are_told_to_have_no_lines_of_their_own():
    with pytest.raises(OlpError, match="O012"):
        editable_lines(read(SAMPLES / "rapid" / "handling.pgf"))


def test_bad_folders_ports_and_missing_libraries_are_told(tmp_path, capsys, monkeypatch):
    assert main(["serve", str(tmp_path / "gone")]) == 2
    assert "C015" in capsys.readouterr().err
    taken = serve._listener(0)
    assert main(["serve", str(tmp_path), "--port", str(taken.getsockname()[1])]) == 2
    assert "C021" in capsys.readouterr().err
    taken.close()
    for text in ("0", "65536", "-1", "http"):
        with pytest.raises(ArgumentTypeError):
            serve._port(text)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert main(["serve", str(tmp_path)]) == 2
    assert 'pip install "olp[serve]"' in capsys.readouterr().err


@pytest.mark.skipif(os.name == "nt", reason="Windows sends no SIGINT to one process")
def test_ctrl_c_ends_the_server_and_its_workers_with_status_0(root):
    words = ["serve", str(root), "--no-browser", "--robot", ROBOT, "--override", "50"]
    server = subprocess.Popen(
        [sys.executable, "-m", "olp", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert server.stdout is not None
    assert server.stderr is not None
    found = re.search(r"http://127\.0\.0\.1:\d+/[\w-]{32}/", server.stdout.readline())
    assert found is not None
    with urlopen(f"{found[0]}serve.js") as reply:
        assert reply.status == 200
    with urlopen(f"{found[0]}api/what_if_lines", json.dumps({"file": JOB}).encode()) as reply:
        assert json.load(reply)["override"] == 50.0
    host, port, path = re.findall(r"http://(.*):(\d+)(/.*)", found[0])[0]
    head = f"POST {path}api/diagnose HTTP/1.1\r\nHost: {host}:{port}\r\nContent-Length: 99\r\n"
    unfinished = f"{head}Content-Type: multipart/form-data; boundary=x\r\n\r\n".encode()
    with socket.create_connection((host, int(port))) as gone:
        gone.sendall(unfinished)
    with socket.create_connection((host, int(port))) as waiting:
        waiting.sendall(unfinished)
        with urlopen(found[0]) as reply:
            assert reply.status == 200
        server.send_signal(signal.SIGINT)
        assert server.wait(10) == 0
    assert server.stderr.read() == ""
    server.stdout.close()
    server.stderr.close()
