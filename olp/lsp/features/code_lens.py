"""`textDocument/codeLens`: the total and its budgets above the program."""

from __future__ import annotations

from lsprotocol import types

from olp.language.lens import lenses
from olp.language.service import Service
from olp.lsp.protocol import Raw
from olp.lsp.server import Server


def register(server: Server, service: Service) -> None:
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
