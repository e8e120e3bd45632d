"""Settings at the start and later, and files that change on the disk."""

from __future__ import annotations

from lsprotocol import types

from olp.languages.vendor import vendor_suffixes
from olp.servers.language.service import ProgramService, settings_of
from olp.servers.lsp.server import OlpLanguageServer, Places


def register(server: OlpLanguageServer, service: ProgramService) -> None:
    @server.feature(types.INITIALIZE)
    def initialize(params: types.InitializeParams) -> None:
        server.places = Places(str(server.workspace.position_encoding))
        service.settings = settings_of(params.initialization_options)

    @server.feature(types.INITIALIZED)
    def initialized(_: types.InitializedParams) -> None:
        """Ask the client to report changes of files that programs need, where it can."""
        workspace = server.client_capabilities.workspace
        watching = None if workspace is None else workspace.did_change_watched_files
        if watching is None or not watching.dynamic_registration:
            return
        patterns = ("**/olp.toml", *(f"**/*{suffix}" for suffix in (*vendor_suffixes(), ".dat")))
        watchers = [types.FileSystemWatcher(pattern) for pattern in patterns]
        asked = types.DidChangeWatchedFilesRegistrationOptions(watchers)
        method = types.WORKSPACE_DID_CHANGE_WATCHED_FILES
        registration = types.Registration("olp-files", method, server.protocol.plain(asked))
        server.protocol.send_request(
            types.CLIENT_REGISTER_CAPABILITY, types.RegistrationParams([registration])
        )

    @server.feature(types.WORKSPACE_DID_CHANGE_CONFIGURATION)
    def configured(params: types.DidChangeConfigurationParams) -> None:
        server.configure(params.settings)

    @server.feature(types.WORKSPACE_DID_CHANGE_WATCHED_FILES)
    def watched(params: types.DidChangeWatchedFilesParams) -> None:
        server.work.refresh()

    @server.feature(types.TEXT_DOCUMENT_DID_SAVE)
    def saved(params: types.DidSaveTextDocumentParams) -> None:
        """Do nothing: the saved text is known from its changes."""
