"""`textDocument/hover`: what a line does, what a name means."""

from __future__ import annotations

from lsprotocol import types

from olp.servers.language.service import ProgramService
from olp.servers.language.symbols import hover
from olp.servers.lsp.server import OlpLanguageServer


def register(server: OlpLanguageServer, service: ProgramService) -> None:
    @server.feature(types.TEXT_DOCUMENT_HOVER)
    async def on_hover(params: types.HoverParams) -> types.Hover | None:
        analysis = await server.work.current(params.text_document.uri)
        if analysis is None:
            return None
        place = server.places.place(analysis.source.line, params.position)
        text = hover(service, analysis, place.line, place.column)
        return types.Hover(types.MarkupContent(types.MarkupKind.Markdown, text)) if text else None
