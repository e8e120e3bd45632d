"""What the server answers to hosts that draw: the page of the side view, its data, and the total."""

from __future__ import annotations

import sys
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any

import pytest
import pytest_asyncio
import pytest_lsp
from lsprotocol import types
from pytest_lsp import ClientServerConfig, LanguageClient

from olp.fluent import read

FOLDER = Path(__file__).parent.parent / "samples/inform/palletising"
KRL = FOLDER.parent.parent / "krl"


ASYNC = pytest.mark.asyncio(loop_scope="module")


@pytest_lsp.fixture(config=ClientServerConfig([sys.executable, "-m", "olp", "lsp"]), scope="module")
async def client(lsp_client: LanguageClient):
    await lsp_client.initialize_session(
        types.InitializeParams(capabilities=types.ClientCapabilities(), root_uri=FOLDER.as_uri())
    )
    yield
    await lsp_client.shutdown_session()


Show = Callable[..., str]


@pytest_asyncio.fixture(loop_scope="module")
async def show(client: LanguageClient) -> AsyncIterator[Show]:
    """Opens a file, `text` in place of its own, and answers with its address; behind the test it is closed."""
    opened: list[str] = []

    def show(path: Path, text: str | None = None, language: str = "inform") -> str:
        item = types.TextDocumentItem(path.as_uri(), language, 1, path.read_text() if text is None else text)
        client.text_document_did_open(types.DidOpenTextDocumentParams(item))
        opened.append(item.uri)
        return item.uri

    yield show
    for uri in opened:
        client.text_document_did_close(types.DidCloseTextDocumentParams(types.TextDocumentIdentifier(uri)))


async def ask(client: LanguageClient, method: str, **question: object) -> Any:
    return await client.protocol.send_request_async(method, question)


@ASYNC
async def test_the_view_draws_the_text_of_the_editor_and_names_the_files_of_its_segments(
    client, show: Show
) -> None:
    text = (FOLDER / "PICK.JBI").read_text().replace("V=120.0", "V=60.0")
    show(FOLDER / "PICK.JBI", text)
    answer = await ask(client, "olp/view", uri=show(FOLDER / "MAIN.JBI"))
    files, data = answer.files, answer.data
    slow = [s for s, line in enumerate(data.line) if line == 23 and files[data.file[s]].endswith("/PICK.JBI")]
    assert len(slow) == 24
    assert min(data.seconds[s] for s in slow) > 3.0  # 192 mm at 60 mm/s
    assert answer.title == "MAIN.JBI"
    assert not hasattr(answer, "html")


@ASYNC
async def test_lists_of_data_belong_to_the_view_of_their_program(client, show: Show) -> None:
    answer = await ask(client, "olp/view", uri=show(KRL / "handling.src", language="krl"))
    names = [Path(uri).name for uri in answer.files]
    assert names[0] == "handling.src"
    assert "handling.dat" in names


@ASYNC
async def test_the_page_is_that_of_the_report_and_asks_for_nothing(client, show: Show) -> None:
    answer = await ask(client, "olp/view", uri=show(FOLDER / "PICK.JBI"), page=True)
    assert "default-src 'none'" in answer.html
    assert '<body class="hosted"' in answer.html
    assert "https://" not in answer.html


@ASYNC
async def test_the_total_is_that_of_olp_time(client, show: Show) -> None:
    total = await ask(client, "olp/total", uri=show(FOLDER / "PICK.JBI"))
    assert total.total_s == pytest.approx(read(FOLDER / "PICK.JBI").plan().time()["duration_s"].sum())
    assert total.segments == []


@ASYNC
async def test_what_cannot_be_timed_is_no_picture_and_what_is_not_open_no_answer(client, show: Show) -> None:
    uri = show(FOLDER / "NEW.JBI", "nothing of a job\r\n")
    broken = await ask(client, "olp/view", uri=uri, page=True)
    assert broken.data is None
    assert "cannot be timed" in broken.html
    for method in ("olp/view", "olp/total"):
        assert await ask(client, method, uri="file:///nowhere.jbi") is None
        assert await ask(client, method, uri=7) is None
