"""Settings at the start and later, and files that change on the disk."""

from __future__ import annotations

from lsprotocol import types

from olp.language.service import Service
from olp.language.settings import settings_of
from olp.lsp.places import Places
from olp.lsp.server import Server


def register(server: Server, service: Service) -> None:
    @server.feature(types.INITIALIZE)
    def initialize(params: types.InitializeParams) -> None:
        server.places = Places(str(server.workspace.position_encoding))
        service.settings = settings_of(params.initialization_options)

    @server.feature(types.WORKSPACE_DID_CHANGE_CONFIGURATION)
    def configured(params: types.DidChangeConfigurationParams) -> None:
        server.configure(params.settings)

    @server.feature(types.WORKSPACE_DID_CHANGE_WATCHED_FILES)
    def watched(params: types.DidChangeWatchedFilesParams) -> None:
        server.work.refresh()

    @server.feature(types.TEXT_DOCUMENT_DID_SAVE)
    def saved(params: types.DidSaveTextDocumentParams) -> None:
        """Nothing changes: the text is known already."""
