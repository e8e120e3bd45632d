"""The server: features found by listing their folder, messages read ahead so that the newest text wins."""

from __future__ import annotations

import asyncio
import gc
import logging
import os
import sys
from contextlib import suppress
from importlib import import_module
from pkgutil import iter_modules
from threading import Event, Thread
from typing import Any, BinaryIO

from lsprotocol import types
from pygls.io_ import StdoutWriter, run_async
from pygls.lsp.server import LanguageServer
from pygls.protocol import default_converter

from olp.core.version import __version__
from olp.servers.language.service import ProgramService
from olp.servers.language.settings import settings_of
from olp.servers.lsp.places import Places
from olp.servers.lsp.protocol import Protocol
from olp.servers.lsp.scheduler import Scheduler
from olp.servers.lsp.texts import Texts

_CHANGE = b'"textDocument/didChange"'


class OlpLanguageServer(LanguageServer):
    """`arrived`: how many changes have come in, handled or not."""

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

    def line_of(self, path: str) -> Any:
        """The lines of an open text, for `Places`."""
        document = self.service.documents.get(path)
        return document.line if document is not None else lambda _: ""

    def configure(self, given: object) -> None:
        """Takes settings and times everything anew."""
        self.service.configure(settings_of(given))
        self.work.refresh()

    def ask_again(self) -> None:
        """Asks the client to ask again for what stands beside lines: something else than the text has changed."""
        capabilities = self.client_capabilities.workspace
        if capabilities is None:
            return
        if capabilities.inlay_hint is not None and capabilities.inlay_hint.refresh_support:
            self.protocol.send_request(types.WORKSPACE_INLAY_HINT_REFRESH)
        if capabilities.code_lens is not None and capabilities.code_lens.refresh_support:
            self.protocol.send_request(types.WORKSPACE_CODE_LENS_REFRESH)

    def report_server_error(self, error: Exception, source: Any) -> None:
        """One line in the log: a client can do nothing about a mistake in olp, and a box in the way of the text helps
        nobody."""
        logging.getLogger("olp.lsp").warning("%s: %s", type(error).__name__, str(error).partition("\n")[0])

    # --- transport --------------------------------------------------------------------------------------

    def serve(self, incoming: BinaryIO, outgoing: BinaryIO) -> None:
        """Speaks with one client until it says exit or goes away."""
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
        """Reads whatever comes, at once: the loop then handles all of it before it computes anything."""
        try:
            while data := os.read(incoming, 1 << 20):
                self.arrived += data.count(_CHANGE)
                loop.call_soon_threadsafe(reader.feed_data, data)
            loop.call_soon_threadsafe(reader.feed_eof)
        except (OSError, RuntimeError):
            pass  # the loop has ended


def start() -> None:
    """Serves the client at standard input and output."""
    logging.basicConfig(stream=sys.stderr, level=logging.WARNING, format="%(message)s")
    logging.getLogger("pygls").setLevel(logging.CRITICAL)  # its log holds whole texts, and tracebacks
    outgoing = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # nothing else may speak there
    server = OlpLanguageServer()
    gc.disable()
    gc.freeze()
    server.serve(sys.stdin.buffer, outgoing)
