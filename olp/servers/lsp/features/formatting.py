"""`textDocument/formatting` and `rangeFormatting`: laid out anew, or not at all."""

from __future__ import annotations

from lsprotocol import types

from olp.servers.language.actions import formatting
from olp.servers.language.service import Analysis, ProgramService
from olp.servers.lsp.server import Json, OlpLanguageServer, Raw

_MOST = 16  # columns of one step


def register(server: OlpLanguageServer, service: ProgramService) -> None:
    def edits(analysis: Analysis, options: types.FormattingOptions, first: int, last: int) -> list[Json]:
        width = min(max(options.tab_size, 1), _MOST)
        line = analysis.source.line
        return [
            {
                "range": server.places.range(line, edit.line, edit.column, edit.end_column),
                "newText": edit.text,
            }
            for edit in formatting(analysis, first, last, " " * width)
        ]

    @server.feature(types.TEXT_DOCUMENT_FORMATTING)
    async def on_formatting(params: types.DocumentFormattingParams) -> Raw:
        analysis = await server.work.current(params.text_document.uri)
        return Raw([] if analysis is None else edits(analysis, params.options, 1, 1 << 30))

    @server.feature(types.TEXT_DOCUMENT_RANGE_FORMATTING)
    async def on_range_formatting(params: types.DocumentRangeFormattingParams) -> Raw:
        analysis = await server.work.current(params.text_document.uri)
        first, last = params.range.start.line + 1, params.range.end.line + 1
        return Raw([] if analysis is None else edits(analysis, params.options, first, last))
