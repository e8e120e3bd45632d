"""The server: features found by listing their folder, messages read ahead so that the newest text wins.

Places differ between the protocol and olp: lines from 0 there and from 1 here, columns in code units and in characters.
"""

from __future__ import annotations

import asyncio
import gc
import logging
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from importlib import import_module
from pkgutil import iter_modules
from threading import Event, Thread
from typing import Any, BinaryIO
from urllib.parse import urlsplit

from lsprotocol import types
from pygls.exceptions import JsonRpcException, JsonRpcInternalError
from pygls.io_ import StdoutWriter, run_async
from pygls.lsp.server import LanguageServer
from pygls.protocol import LanguageServerProtocol, default_converter, lsp_method
from pygls.uris import from_fs_path, to_fs_path

from olp.core.result_cache import SupersededError
from olp.core.version import __version__
from olp.servers.language.document import OpenDocument, Place, TextChange
from olp.servers.language.service import (
    Analysis,
    FindingMark,
    ProgramService,
    Weight,
    marks,
    rule_runs,
    settings_of,
)

Line = Callable[[int], str]  # the text of a line, counted from 1
Json = dict[str, Any]


class Places:
    """Converts columns between the protocol and olp. `encoding`: the agreed unit of columns (utf-8, utf-16 or
    utf-32).
    """

    def __init__(self, encoding: str = "utf-16") -> None:
        self.encoding = encoding

    def units(self, text: str, column: int) -> int:
        """Return the number of code units before `column` (from 1) of a line."""
        before = text[: column - 1]
        if self.encoding == "utf-32" or before.isascii():
            return len(before)
        if self.encoding == "utf-8":
            return len(before.encode("utf-8", "surrogatepass"))
        return len(before) + sum(ord(c) > 0xFFFF for c in before)

    def column(self, text: str, units: int) -> int:
        """Return the column (from 1) behind `units` code units of a line; the end of a shorter line."""
        if self.encoding == "utf-32" or text.isascii():
            return min(units, len(text)) + 1
        width = _utf8 if self.encoding == "utf-8" else _utf16
        for column, character in enumerate(text, 1):
            units -= width(character)
            if units < 0:
                return column
        return len(text) + 1

    def place(self, line: Line, position: types.Position) -> Place:
        return Place(position.line + 1, self.column(line(position.line + 1), position.character))

    def position(self, line: Line, number: int, column: int) -> Json:
        return {"line": max(number, 1) - 1, "character": self.units(line(number), column)}

    def range(self, line: Line, number: int, column: int = 1, end_column: int = 0) -> Json:
        """Return the protocol's range from `column` to `end_column` of one line; `end_column` 0 means the end of
        the line.
        """
        text = line(number)
        stop = end_column or len(text) + 1
        return {
            "start": self.position(line, number, column),
            "end": self.position(line, number, max(stop, column)),
        }

    def change(
        self, document: OpenDocument, change: types.TextDocumentContentChangeEvent
    ) -> TextChange | str:
        if isinstance(change, types.TextDocumentContentChangeWholeDocument):
            return change.text
        start = self.place(document.line, change.range.start)
        return TextChange(start, self.place(document.line, change.range.end), change.text)


def _utf8(character: str) -> int:
    return len(character.encode("utf-8", "surrogatepass"))


def _utf16(character: str) -> int:
    return 1 + (ord(character) > 0xFFFF)


def path_of(uri: str) -> str:
    """Return the path of a file's URI; any other URI unchanged."""
    try:
        return to_fs_path(uri) or uri
    except ValueError:
        return uri


def uri_of(path: str) -> str:
    """Return the URI of a path; a URI that `path_of` left unchanged stays as it is."""
    if urlsplit(path).scheme not in ("", "file") and len(urlsplit(path).scheme) > 1:
        return path
    return from_fs_path(path) or path


_CHANGE = b'"textDocument/didChange"'


class OlpLanguageServer(LanguageServer):
    """The language server. `arrived`: the number of changes that have been received, processed or not."""

    protocol: Protocol

    def __init__(self) -> None:
        super().__init__("olp", __version__, protocol_cls=Protocol, converter_factory=default_converter)
        self.service = ProgramService()
        self.places = Places()
        self.texts = Texts(self)
        self.work = Scheduler(self)
        self.arrived = 0
        for module in iter_modules(import_module("olp.servers.lsp.features").__path__):
            import_module(f"olp.servers.lsp.features.{module.name}").register(self, self.service)

    def configure(self, given: object) -> None:
        """Take over the client's settings and time every open text again."""
        self.service.configure(settings_of(given))
        self.work.refresh()

    def ask_again(self) -> None:
        """Ask the client to request inlay hints and code lenses again, because something else than the text has
        changed.
        """
        capabilities = self.client_capabilities.workspace
        if capabilities is None:
            return
        if capabilities.inlay_hint is not None and capabilities.inlay_hint.refresh_support:
            self.protocol.send_request(types.WORKSPACE_INLAY_HINT_REFRESH)
        if capabilities.code_lens is not None and capabilities.code_lens.refresh_support:
            self.protocol.send_request(types.WORKSPACE_CODE_LENS_REFRESH)

    def report_server_error(self, error: Exception, source: Any) -> None:
        """Log an internal error in one line; the client is not shown a message, because its user cannot act on it."""
        logging.getLogger("olp.lsp").warning("%s: %s", type(error).__name__, str(error).partition("\n")[0])

    # --- transport --------------------------------------------------------------------------------------

    def serve(self, incoming: BinaryIO, outgoing: BinaryIO) -> None:
        """Serve one client until it sends `exit` or closes the connection."""
        gone = (BrokenPipeError, asyncio.IncompleteReadError, KeyboardInterrupt)
        with suppress(*gone):
            asyncio.run(self._serve(incoming.fileno(), outgoing))

    async def _serve(self, incoming: int, outgoing: BinaryIO) -> None:
        reader = asyncio.StreamReader()
        self.protocol.set_writer(StdoutWriter(outgoing))
        loop = asyncio.get_running_loop()
        Thread(target=self._pump, args=(loop, reader, incoming), daemon=True).start()
        await run_async(Event(), reader, self.protocol, None, self.report_server_error)

    def _pump(self, loop: asyncio.AbstractEventLoop, reader: asyncio.StreamReader, incoming: int) -> None:
        """Pass all received bytes on at once, so that the loop handles every message before it computes anything."""
        try:
            while data := os.read(incoming, 1 << 20):
                self.arrived += data.count(_CHANGE)
                loop.call_soon_threadsafe(reader.feed_data, data)
            loop.call_soon_threadsafe(reader.feed_eof)
        except (OSError, RuntimeError):
            pass  # the loop has ended


def start() -> None:
    """Serve the client on standard input and output."""
    logging.basicConfig(stream=sys.stderr, level=logging.WARNING, format="%(message)s")
    logging.getLogger("pygls").setLevel(logging.CRITICAL)  # its log holds whole texts, and tracebacks
    outgoing = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # nothing else may speak there
    server = OlpLanguageServer()
    gc.disable()
    gc.freeze()
    server.serve(sys.stdin.buffer, outgoing)


# --- Protocol ---
# The protocol of pygls, changed: texts are kept once, long answers are sent as they are, no traceback leaves.
#
# pygls keeps texts of its own and converts every answer field by field; with 20,000 lines both take longer than the
# answer itself.


class Raw:
    """An answer that is already JSON."""

    def __init__(self, value: Any) -> None:
        self.value = value


class Protocol(LanguageServerProtocol):
    _server: OlpLanguageServer

    @lsp_method(types.TEXT_DOCUMENT_DID_OPEN)
    # pyrefly: ignore[bad-override]  # its generator is for what runs in threads
    def lsp_text_document__did_open(self, params: types.DidOpenTextDocumentParams) -> None:
        self._server.texts.opened(params.text_document)

    @lsp_method(types.TEXT_DOCUMENT_DID_CHANGE)
    # pyrefly: ignore[bad-override]  # its generator is for what runs in threads
    def lsp_text_document__did_change(self, params: types.DidChangeTextDocumentParams) -> None:
        self._server.texts.changed(params)

    @lsp_method(types.TEXT_DOCUMENT_DID_CLOSE)
    # pyrefly: ignore[bad-override]  # its generator is for what runs in threads
    def lsp_text_document__did_close(self, params: types.DidCloseTextDocumentParams) -> None:
        self._server.texts.closed(params.text_document.uri)

    def tell(self, method: str, params: Any) -> None:
        """Send a notification whose parameters are already JSON."""
        self._send_data({"jsonrpc": "2.0", "method": method, "params": params})

    def plain(self, thing: Any) -> Any:
        """Return an object of the protocol as JSON data."""
        return self._converter.unstructure(thing)

    def structure_message(self, data: dict[str, Any]) -> Any:
        try:
            return super().structure_message(data)
        except JsonRpcException as problem:
            # Nobody else would answer a question that cannot be understood.
            if "method" in data and isinstance(data.get("id"), (int, str)):
                self._send_response(data["id"], error=problem.to_response_error())
            raise

    def _send_response(
        self, msg_id: str | int, result: Any = None, error: types.ResponseError | None = None
    ) -> None:
        if error is not None:
            self._send_data({"jsonrpc": "2.0", "id": msg_id, "error": _without_traceback(error)})
        elif isinstance(result, Raw):
            self._result_types.pop(msg_id, None)
            self._send_data({"jsonrpc": "2.0", "id": msg_id, "result": result.value})
        else:
            super()._send_response(msg_id, result, error)


def _without_traceback(error: types.ResponseError) -> dict[str, Any]:
    message = error.message
    if error.code == JsonRpcInternalError.CODE:
        message = f"{message.partition(chr(10))[0]} (a mistake in olp)"
    return {"code": int(error.code), "message": message}


# --- Texts ---
# What the client says of its texts, handed to the service.


class Texts:
    """The open texts. `uris`: path -> URI as the client writes it."""

    def __init__(self, server: OlpLanguageServer) -> None:
        self._server = server
        self.uris: dict[str, str] = {}

    def opened(self, item: types.TextDocumentItem) -> None:
        path = path_of(item.uri)
        self.uris[path] = item.uri
        self._server.service.open(path, item.text, item.language_id, item.version)
        self._server.work.changed(path)

    def changed(self, params: types.DidChangeTextDocumentParams) -> None:
        path = path_of(params.text_document.uri)
        document = self._server.service.documents.get(path)
        if document is None:
            return
        for change in params.content_changes:
            # Places count in the text as the changes before have left it.
            edit = self._server.places.change(document, change)
            self._server.service.change(path, [edit], params.text_document.version)
        self._server.work.changed(path)

    def closed(self, uri: str) -> None:
        path = path_of(uri)
        if self._server.service.close(path):
            self._server.work.closed(path)
        self.uris.pop(path, None)


# --- Scheduler ---
# When what is computed: the newest text first, the rules when nobody types, nothing twice.
#
# Messages that have arrived are all handled before anything is computed, because the reader hands them over without a
# pause. So of many keystrokes only the last one is computed, and one that arrives meanwhile ends the computation.

_PATIENCE = 1.0  # [s] without an answer; then no keystroke ends a computation any more
_IDLE = 0.25  # [s] without a message, before the rules run
_TIDY = 3.0  # [s], before garbage is looked for


class Scheduler:
    """Decides which open text is analysed next, and sends its diagnostics to the client."""

    def __init__(self, server: OlpLanguageServer) -> None:
        self._server = server
        self._publisher = Publisher(server)
        self._dirty: dict[str, None] = {}
        self._waiting: dict[str, list[asyncio.Future[None]]] = {}
        self._scheduled = False
        self._idle: asyncio.TimerHandle | None = None
        self._answered = time.monotonic()

    def changed(self, path: str) -> None:
        """Schedule the analysis of the changed text first, and of the texts that depend on it."""
        self._concern(path)
        self._dirty.pop(path, None)
        self._dirty[path] = None
        self._soon()

    def _concern(self, path: str) -> None:
        """Forget the analyses of the texts that depend on `path`, and schedule them."""
        service = self._server.service
        for other in service.dependents(path):
            service.forget(other)
            self._dirty.setdefault(other)

    def refresh(self) -> None:
        """Forget every analysis and schedule all open texts, because settings or files on the disk have changed."""
        self._server.service.forget()
        for path in self._server.service.documents:
            self._dirty.setdefault(path)
        self._soon()

    def closed(self, path: str) -> None:
        self._dirty.pop(path, None)
        self._release(path)
        self._publisher.forget(path)
        self._concern(path)
        self._soon()

    async def current(self, uri: str) -> Analysis | None:
        """Wait for and return the analysis of the newest text; None where the text is not open."""

        path, service = path_of(uri), self._server.service
        while path in service.documents and not service.is_current(path):
            waiting: asyncio.Future[None] = asyncio.get_running_loop().create_future()
            self._waiting.setdefault(path, []).append(waiting)
            self._dirty.setdefault(path)
            self._soon()
            await waiting
        return service.analyses.get(path)

    async def complete(self, uri: str) -> Analysis | None:
        """Return `current` with the findings of lint's rules added, without waiting for an idle moment."""
        from olp.servers.language.service import complete

        if await self.current(uri) is None:
            return None
        return complete(self._server.service, path_of(uri))

    # --- one thing after the other ----------------------------------------------------------------------

    def _soon(self) -> None:
        if self._idle is not None:
            self._idle.cancel()
            self._idle = None
        if not self._scheduled and self._dirty:
            self._scheduled = True
            asyncio.get_running_loop().call_soon(self._next)

    def _next(self) -> None:
        """Analyse the text that was changed last."""
        self._scheduled = False
        if self._dirty:
            path, _ = self._dirty.popitem()
            self._compute(path)
        if self._dirty:
            self._soon()
        else:
            self._later(_IDLE, self._rules)

    def _compute(self, path: str) -> None:
        before = self._server.service.analyses.get(path)
        handled = self._server.arrived
        patient = time.monotonic() - self._answered < _PATIENCE

        def wanted() -> bool:
            return not patient or self._server.arrived == handled

        try:
            analysis = self._server.service.current(path, wanted, whole=False)
        except SupersededError:
            self._dirty[path] = None
            return
        self._answered = time.monotonic()
        self._release(path)
        if analysis is not None:
            self._publisher.publish(path, marks(analysis))
            if before is not None and before.edition == -1:
                self._server.ask_again()

    def _release(self, path: str) -> None:
        for waiting in self._waiting.pop(path, ()):
            if not waiting.done():
                waiting.set_result(None)

    # --- when nobody types ------------------------------------------------------------------------------

    def _later(self, seconds: float, what: Callable[[], None]) -> None:
        self._idle = asyncio.get_running_loop().call_later(seconds, what)

    def _rules(self) -> None:
        """Finish the timing of long programs, then run lint's rules over all texts, until a text changes."""
        self._idle = None
        if self._complete():
            self._step(rule_runs(self._server.service))

    def _complete(self) -> bool:
        """Finish the analyses that were cut short. Returns False where a change arrives meanwhile."""
        service, seen = self._server.service, self._server.arrived
        for path in [path for path, analysis in service.analyses.items() if analysis.partial]:
            try:
                analysis = service.current(path, lambda: self._server.arrived == seen)
            except SupersededError:
                return False
            if analysis is not None:
                self._publisher.publish(path, marks(analysis))
                self._server.ask_again()
        return True

    def _step(self, runs: Iterator[str]) -> None:
        self._idle = None
        path = next(runs, None)
        if path is None:
            self._later(_TIDY, self._tidy)
            return
        if path and path in self._server.service.analyses:
            self._publisher.publish(path, marks(self._server.service.analyses[path]))
        self._later(0.0, lambda: self._step(runs))

    def _tidy(self) -> None:
        """Collect garbage in an idle moment; the automatic collector is switched off."""
        self._idle = None
        gc.collect()
        gc.freeze()


# --- Publishing ---
# Marks sent to the client: per file, what every open text tells of it.

_SEVERITIES = {Weight.ERROR: 1, Weight.WARNING: 2, Weight.INFO: 3, Weight.HINT: 4}


class Publisher:
    """Sends diagnostics to the client. `_told`: file -> the text whose analysis reports it -> the marks sent last."""

    def __init__(self, server: OlpLanguageServer) -> None:
        self._server = server
        self._told: dict[str, dict[str, list[FindingMark]]] = {}

    def publish(self, owner: str, found: list[FindingMark]) -> None:
        """Replace the diagnostics that the analysis of the text `owner` reported before by `found`."""
        files: dict[str, list[FindingMark]] = {owner: []}
        for mark in found:
            files.setdefault(mark.file or owner, []).append(mark)
        for file, tellers in self._told.items():
            if owner in tellers:
                files.setdefault(file, [])
        for file, told in files.items():
            self._put(file, owner, told)

    def forget(self, owner: str) -> None:
        """Remove all diagnostics that a closed text reported."""
        for file in [file for file, tellers in self._told.items() if owner in tellers]:
            self._put(file, owner, [])

    def _put(self, file: str, owner: str, told: list[FindingMark]) -> None:
        tellers = self._told.setdefault(file, {})
        tellers.pop(owner, None)
        if told:
            tellers[owner] = told
        if not tellers:
            del self._told[file]
        document = self._server.service.documents.get(file)
        marks = dict.fromkeys(mark for found in tellers.values() for mark in found)
        params: Json = {
            "uri": self._server.texts.uris.get(file) or uri_of(file),
            "diagnostics": [self._json(mark) for mark in marks],
        }
        if document is not None and file == owner:
            params["version"] = document.version
        self._server.protocol.tell(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS, params)

    def _json(self, mark: FindingMark) -> Json:
        document = self._server.service.documents.get(mark.file)
        if document is not None:
            where = self._server.places.range(
                document.line, max(mark.line, 1), mark.column, mark.end_column if mark.line else 0
            )
        else:
            where = self._server.places.range(lambda _: "", max(mark.line, 1))
        return {
            "range": where,
            "severity": _SEVERITIES[mark.weight],
            "code": mark.code,
            "source": "olp",
            "message": mark.message,
        }
