"""The language server as its clients see it: a process of its own, spoken with by pytest-lsp."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
import pytest_lsp
from lsprotocol import types
from pytest_lsp import ClientServerConfig, LanguageClient

ROOT = Path(__file__).parent.parent
SAMPLE = ROOT / "samples/inform/generations/dx200.jbi"


@pytest_lsp.fixture(config=ClientServerConfig([sys.executable, "-m", "olp", "lsp"]))
async def client(lsp_client: LanguageClient):
    await lsp_client.initialize_session(
        types.InitializeParams(capabilities=types.ClientCapabilities(), root_uri=ROOT.as_uri())
    )
    yield
    await lsp_client.shutdown_session()


def open_text(client: LanguageClient, path: Path, text: str | None = None, language: str = "") -> str:
    uri = path.as_uri()
    text = path.read_text() if text is None else text
    item = types.TextDocumentItem(uri, language, 1, text)
    client.text_document_did_open(types.DidOpenTextDocumentParams(item))
    return uri


async def told(client: LanguageClient, uri: str, version: int) -> list[types.Diagnostic]:
    """What is told of the text, once it is told of that version."""
    while True:
        done = client.protocol.wait_for_notification_async(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        params = await done
        if params.uri == uri and (params.version or 0) >= version:
            return list(params.diagnostics)


def everything() -> types.Range:
    return types.Range(types.Position(0, 0), types.Position(100_000, 0))


@pytest.mark.asyncio
async def test_hints_and_findings_follow_a_keystroke(client: LanguageClient) -> None:
    uri = open_text(client, SAMPLE)
    document = types.TextDocumentIdentifier(uri)
    await told(client, uri, 1)
    before = await client.text_document_inlay_hint_async(types.InlayHintParams(document, everything()))
    assert before is not None
    labels = {hint.position.line + 1: hint.label for hint in before}
    assert labels[27] == "0.136 s  Σ 0.136 s  speed"
    place = types.Position(26, 12)
    edit = types.TextDocumentContentChangePartial(types.Range(place, place), "nonsense")
    client.text_document_did_change(
        types.DidChangeTextDocumentParams(types.VersionedTextDocumentIdentifier(2, uri), [edit])
    )
    found = await told(client, uri, 2)
    assert any(d.code == "P020" and d.range.start.line == 26 for d in found)
    after = await client.text_document_inlay_hint_async(types.InlayHintParams(document, everything()))
    assert after is not None
    assert 26 not in {hint.position.line for hint in after}
