"""What the client says of its texts, handed to the service."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lsprotocol import types

from olp.servers.lsp.places import path_of

if TYPE_CHECKING:
    from olp.servers.lsp.server import OlpLanguageServer


class Texts:
    """`uris`: path -> URI as the client writes it, of every open text."""

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
