"""`textDocument/codeLens`: the total and its budgets above the program."""

from __future__ import annotations

from lsprotocol import types

from olp.servers.language.lens import lenses
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
