"""The language server as its clients see it: a process of its own, spoken with by pytest-lsp."""

from __future__ import annotations

import asyncio
import json
import subprocess
import sys
from pathlib import Path

import pytest
import pytest_lsp
from lsprotocol import types
from pytest_lsp import ClientServerConfig, LanguageClient

from olp.reports.batch import Job, plan_and_time

ROOT = Path(__file__).parent.parent
SAMPLES = ROOT / "samples"
SAMPLE = SAMPLES / "inform/generations/dx200.jbi"
LANGUAGES = {
    "inform": SAMPLES / "inform/handling/HANDLING.JBI",
    "krl": SAMPLES / "krl/handling.src",
    "rapid": SAMPLES / "rapid/handling.mod",
    "tp": SAMPLES / "tp/handling.ls",
    "urscript": SAMPLES / "urscript/handling.script",
}
ASYNC = pytest.mark.asyncio(loop_scope="module")


@pytest_lsp.fixture(config=ClientServerConfig([sys.executable, "-m", "olp", "lsp"]), scope="module")
async def client(lsp_client: LanguageClient):
    general = types.GeneralClientCapabilities(position_encodings=[types.PositionEncodingKind.Utf16])
    capabilities = types.ClientCapabilities(general=general)
    await lsp_client.initialize_session(
        types.InitializeParams(capabilities=capabilities, root_uri=ROOT.as_uri())
    )
    yield
    await lsp_client.shutdown_session()


def open_text(client: LanguageClient, path: Path, text: str | None = None, language: str = "") -> str:
    """`text` in place of the file's."""
    uri = path.as_uri()
    text = path.read_bytes().decode() if text is None else text
    item = types.TextDocumentItem(uri, language, 1, text)
    client.text_document_did_open(types.DidOpenTextDocumentParams(item))
    return uri


def close_text(client: LanguageClient, uri: str) -> None:
    client.text_document_did_close(types.DidCloseTextDocumentParams(types.TextDocumentIdentifier(uri)))


def change(
    client: LanguageClient, uri: str, version: int, line: int, column: int, text: str, end: int = -1
) -> None:
    """Replaces the letters from `column` to `end` (counted from 0) of a line (counted from 1)."""
    start, stop = types.Position(line - 1, column), types.Position(line - 1, column if end < 0 else end)
    edit = types.TextDocumentContentChangePartial(types.Range(start, stop), text)
    known = types.VersionedTextDocumentIdentifier(version, uri)
    client.text_document_did_change(types.DidChangeTextDocumentParams(known, [edit]))


async def told(client: LanguageClient, uri: str, word: str = "") -> list[types.Diagnostic]:
    """What is told of the text as it is now, once a finding with that code, or that word in it, is among it."""
    await labels(client, uri)  # findings come before the answer to a question that is asked after them
    async with asyncio.timeout(30):
        while True:
            found = list(client.diagnostics.get(uri, ()))
            if not word or any(word == d.code or word in d.message for d in found):
                return found
            await asyncio.sleep(0.02)


def document(uri: str) -> types.TextDocumentIdentifier:
    return types.TextDocumentIdentifier(uri)


def everything() -> types.Range:
    return types.Range(types.Position(0, 0), types.Position(100_000, 0))


async def labels(client: LanguageClient, uri: str) -> dict[int, str]:
    """The hints by line, counted from 1."""
    found = await client.text_document_inlay_hint_async(types.InlayHintParams(document(uri), everything()))
    assert found is not None
    return {hint.position.line + 1: str(hint.label) for hint in found}


@ASYNC
async def test_hints_and_findings_follow_a_keystroke(client: LanguageClient) -> None:
    uri = open_text(client, SAMPLE)
    await told(client, uri)
    before = await labels(client, uri)
    assert before[27] == "0.146 s  Σ 0.146 s  acceleration"
    assert before[30].startswith("2 × = ")
    change(client, uri, 2, 27, 12, "nonsense")
    found = await told(client, uri)
    assert any(d.code == "P020" and d.range.start.line == 26 for d in found)
    assert 27 not in await labels(client, uri)
    change(client, uri, 3, 27, 12, "", 12 + len("nonsense"))
    assert await labels(client, uri) == before
    close_text(client, uri)


@pytest.mark.parametrize("language", LANGUAGES)
@ASYNC
async def test_every_feature_answers_in_every_language(client: LanguageClient, language: str) -> None:
    uri = open_text(client, LANGUAGES[language], language=language)
    text = LANGUAGES[language].read_text().splitlines()
    hints = await labels(client, uri)
    assert len(hints) >= 5
    move = types.Position(max(line for line, label in hints.items() if "speed" in label) - 1, 4)
    at = (document(uri), move)
    hover = await client.text_document_hover_async(types.HoverParams(*at))
    assert hover is not None
    assert " s**" in hover.contents.value
    symbols = await client.text_document_document_symbol_async(types.DocumentSymbolParams(document(uri)))
    assert symbols
    names = [symbols[0], *(symbols[0].children or ())]
    place = names[-1].selection_range
    where = await client.text_document_references_async(
        types.ReferenceParams(types.ReferenceContext(True), document(uri), place.start)
    )
    assert where
    assert all(one.range.start.line < len(text) for one in where if one.uri == uri)
    defined = await client.text_document_definition_async(types.DefinitionParams(document(uri), place.start))
    assert defined[0].range == place
    proposed = await client.text_document_completion_async(
        types.CompletionParams(document(uri), types.Position(len(text) - 1, 0))
    )
    assert len(proposed) > 40
    lenses = await client.text_document_code_lens_async(types.CodeLensParams(document(uri)))
    assert " s: motion " in lenses[0].command.title
    edits = await client.text_document_formatting_async(
        types.DocumentFormattingParams(document(uri), types.FormattingOptions(2, True))
    )
    assert not edits
    close_text(client, uri)


@ASYNC
async def test_a_rule_is_told_when_nobody_types_and_its_fix_is_offered(client: LanguageClient) -> None:
    uri = open_text(client, SAMPLES / "inform/pitfalls/labels.jbi")
    found = await told(client, uri, "W014")
    wrong = next(d for d in found if d.code == "W014")
    offered = await client.text_document_code_action_async(
        types.CodeActionParams(document(uri), wrong.range, types.CodeActionContext([wrong]))
    )
    assert offered is not None
    fix = next(a for a in offered if a.is_preferred)
    assert fix.diagnostics[0].code == "W014"
    (edit,) = fix.edit.changes[uri]
    assert edit.new_text == ""
    assert (edit.range.end.line, edit.range.end.character) == (edit.range.start.line + 1, 0)
    close_text(client, uri)


@ASYNC
async def test_an_open_list_counts_for_the_program_beside_it(client: LanguageClient) -> None:
    uri = open_text(client, LANGUAGES["krl"])
    before = await labels(client, uri)
    data = SAMPLES / "krl/handling.dat"
    beside = open_text(client, data, data.read_bytes().decode().replace("Z 160.0", "Z 460.0"))
    async with asyncio.timeout(20):
        while await labels(client, uri) == before:
            await asyncio.sleep(0.05)
    close_text(client, beside)
    async with asyncio.timeout(20):
        while await labels(client, uri) != before:
            await asyncio.sleep(0.05)
    close_text(client, uri)


@ASYNC
async def test_settings_change_the_times(client: LanguageClient) -> None:
    uri = open_text(client, SAMPLE)
    before = await labels(client, uri)
    client.workspace_did_change_configuration(
        types.DidChangeConfigurationParams({"olp": {"override": 10, "robot": "yaskawa/ma2010"}})
    )
    slow = await labels(client, uri)
    timing = plan_and_time(str(SAMPLE), Job(robot="yaskawa/ma2010", override=0.1))
    step = timing.plan.line.tolist().index(27)
    assert slow[27].startswith(f"{timing.duration_s[step]:.3f} s  Σ {timing.end_s[step]:.3f} s")
    assert slow != before
    client.workspace_did_change_configuration(
        types.DidChangeConfigurationParams({"olp": {"robot": "nobody/x"}})
    )
    await told(client, uri, "nobody/x")
    client.workspace_did_change_configuration(types.DidChangeConfigurationParams({"olp": {}}))
    assert await labels(client, uri) == before
    close_text(client, uri)


@ASYNC
async def test_hosts_get_the_object_of_olp_time(client: LanguageClient) -> None:
    uri = open_text(client, SAMPLE)
    found = await client.protocol.send_request_async("olp/timing", {"uri": uri})
    close_text(client, uri)
    done = subprocess.run(
        [sys.executable, "-m", "olp", "time", str(SAMPLE), "--format", "json"],
        capture_output=True,
        check=False,
    )
    (wanted,) = json.loads(done.stdout)
    assert found.total_s == wanted["total_s"]
    assert [s.duration_s for s in found.segments] == [s["duration_s"] for s in wanted["segments"]]
    assert [d.code for d in found.diagnostics] == [d["code"] for d in wanted["diagnostics"]]


@ASYNC
async def test_columns_count_in_the_units_that_were_agreed_on(client: LanguageClient, tmp_path: Path) -> None:
    text = SAMPLE.read_text().replace("MOVL C00001 PL=1", "MOVL C00001 PL=1 //😀ü")
    uri = open_text(client, tmp_path / "A.JBI", text)
    found = await client.text_document_inlay_hint_async(types.InlayHintParams(document(uri), everything()))
    hint = next(h for h in found if h.position.line == 26)
    assert hint.position.character == len("MOVL C00001 PL=1 //ü") + 2
    change(client, uri, 2, 27, len("MOVL C00001 PL=1 //") + 2, "x")
    hover = await client.text_document_hover_async(types.HoverParams(document(uri), types.Position(26, 7)))
    assert hover is not None
    close_text(client, uri)


HOSTILE = {
    "empty": "",
    "binary": "\0\1\2\3" * 200,
    "one huge line": "MOVL C00001 V=" + "9" * 300_000,
    "nested": "/JOB\n//NAME X\n//POS\n//INST\nNOP\nSET B000 EXPRESS " + "(" * 5000 + "\nEND\n",
    "lone surrogates": "/JOB\n//NAME \ud800\udfff\n//POS\n",
    "an endless loop": "/JOB\n//NAME X\n//POS\n///NPOS 0,0,0,0,0,0\n//INST\n///GROUP1 RB1\nNOP\n*A\nJUMP *A\nEND\n",
    "line ends": "/JOB\r//NAME X\n\r//POS\r\n\r//INST\rNOP\rEND",
}


@pytest.mark.parametrize("name", HOSTILE)
@ASYNC
async def test_whatever_stands_in_a_text_every_question_is_answered(
    client, name: str, tmp_path: Path
) -> None:
    text = HOSTILE[name].encode("utf-8", "surrogatepass").decode("utf-8", "replace")
    for suffix, language in ((".JBI", "cobol"), (".src", "inform"), (".txt", "")):
        uri = open_text(client, tmp_path / f"x{suffix}", text, language)
        await answers(client, uri)
        change(client, uri, 2, 1, 0, "x")
        change(client, uri, 3, 9_999_999, 9_999_999, "y")
        await answers(client, uri)
        close_text(client, uri)


async def answers(client: LanguageClient, uri: str) -> None:
    place = types.Position(4_000_000, 77)
    far = types.TextDocumentPositionParams(document(uri), place)
    await client.text_document_inlay_hint_async(types.InlayHintParams(document(uri), everything()))
    await client.text_document_hover_async(types.HoverParams(far.text_document, far.position))
    await client.text_document_definition_async(types.DefinitionParams(far.text_document, far.position))
    await client.text_document_completion_async(types.CompletionParams(far.text_document, far.position))
    await client.text_document_document_symbol_async(types.DocumentSymbolParams(document(uri)))
    await client.text_document_code_lens_async(types.CodeLensParams(document(uri)))
    await client.text_document_code_action_async(
        types.CodeActionParams(document(uri), everything(), types.CodeActionContext([]))
    )


@ASYNC
async def test_texts_that_are_not_open_are_no_reason_to_fail(client: LanguageClient) -> None:
    uri = "file:///nowhere/at/all.jbi"
    close_text(client, uri)
    change(client, uri, 5, 1, 0, "x")
    await answers(client, uri)
    await answers(client, "untitled:Untitled-1")
    await answers(client, "%%% no uri")
    assert await client.protocol.send_request_async("olp/timing", {"uri": uri}) is None
    assert await client.protocol.send_request_async("olp/timing", {"other": 7}) is None


@ASYNC
async def test_a_text_without_a_file_is_read_all_the_same(client: LanguageClient) -> None:
    uri = "untitled:Untitled-1"
    item = types.TextDocumentItem(uri, "inform", 1, SAMPLE.read_text())
    client.text_document_did_open(types.DidOpenTextDocumentParams(item))
    found = await told(client, uri)
    assert {"I001", "I003"} & {d.code for d in found}  # no olp.toml beside it says which robot
    close_text(client, uri)


@ASYNC
async def test_cancelled_questions_and_wrong_ones_end_in_an_error_and_no_traceback(
    client: LanguageClient,
) -> None:
    uri = open_text(client, SAMPLE)
    for number in range(5):
        wrong = {
            "jsonrpc": "2.0",
            "id": f"wrong {number}",
            "method": "textDocument/inlayHint",
            "params": {"no": 1},
        }
        client.protocol._send_data(wrong)
        hints = client.protocol.send_request(
            types.TEXT_DOCUMENT_INLAY_HINT,
            types.InlayHintParams(document(uri), everything()),
            msg_id=f"gone {number}",
        )
        client.cancel_request(types.CancelParams(f"gone {number}"))
        del hints
    with pytest.raises(Exception, match="Method Not Found") as refused:
        await client.protocol.send_request_async("olp/unheard-of", {})
    assert "Traceback" not in str(refused.value)
    assert len(await labels(client, uri)) > 5
    close_text(client, uri)


@ASYNC
async def test_of_many_keystrokes_only_the_last_text_is_told(client: LanguageClient) -> None:
    uri = open_text(client, LANGUAGES["krl"])
    await told(client, uri)
    for version in range(2, 60):
        change(client, uri, version, 22, 0, ";" if version % 2 else "x")
    await told(client, uri)
    before = len(await labels(client, uri))
    assert before > 3
    close_text(client, uri)


def test_a_client_that_goes_away_ends_the_server() -> None:
    for last_words in (
        b"",
        b"Content-Length: 100\r\n\r\n{",
        b"nonsense\r\n\r\n",
        b"Content-Length: x\r\n\r\n{}",
    ):
        done = subprocess.run(
            [sys.executable, "-m", "olp", "lsp"],
            input=last_words,
            capture_output=True,
            timeout=30,
            check=False,
        )
        assert b"Traceback" not in done.stderr
        assert done.stdout == b""


@pytest.mark.slow
def test_without_its_library_the_server_says_what_to_install(tmp_path: Path) -> None:
    (tmp_path / "pygls.py").write_text("raise ModuleNotFoundError('gone', name='pygls')")
    done = subprocess.run(
        [sys.executable, "-c", "import sys; sys.path.insert(0, sys.argv[1]); from olp.__main__ import main; "
         "sys.argv = ['olp', 'lsp']; sys.exit(main())", str(tmp_path)],
        capture_output=True, text=True, cwd=ROOT, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert 'pip install "olp[lsp]"' in done.stderr
