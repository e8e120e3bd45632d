"""The times of an open text: each line's (`textDocument/inlayHint`), and all above it (`textDocument/codeLens`)."""

from __future__ import annotations

from lsprotocol import types

from olp.servers.language.actions import hints, lenses
from olp.servers.language.service import ProgramService
from olp.servers.lsp.server import OlpLanguageServer, Raw


def register(server: OlpLanguageServer, service: ProgramService) -> None:
    @server.feature(types.TEXT_DOCUMENT_CODE_LENS)
    async def on_code_lens(params: types.CodeLensParams) -> Raw:
        analysis = await server.work.current(params.text_document.uri)
        if analysis is None:
            return Raw([])
        return Raw(
            [
                {
                    "range": server.places.range(analysis.source.line, lens.line),
                    "command": {"title": lens.text, "command": ""},
                }
                for lens in lenses(analysis)
            ]
        )

    @server.feature(types.TEXT_DOCUMENT_INLAY_HINT)
    async def inlay_hints(params: types.InlayHintParams) -> Raw:
        analysis = await server.work.current(params.text_document.uri)
        if analysis is None:
            return Raw([])
        line, first, last = analysis.source.line, params.range.start.line + 1, params.range.end.line + 1
        return Raw(
            [
                {
                    "position": server.places.position(line, hint.line, len(line(hint.line)) + 1),
                    "label": hint.text,
                    "paddingLeft": True,
                }
                for hint in hints(analysis, first, last)
            ]
        )
