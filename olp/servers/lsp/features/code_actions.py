"""`textDocument/codeAction`: quick fixes for findings."""

from __future__ import annotations

from asyncio import to_thread

from lsprotocol import types

from olp.servers.language.actions import actions
from olp.servers.language.document import Action, TextEdit
from olp.servers.language.service import ProgramService
from olp.servers.lsp.server import Json, OlpLanguageServer, Raw


def register(server: OlpLanguageServer, service: ProgramService) -> None:
    options = types.CodeActionOptions(code_action_kinds=[types.CodeActionKind.QuickFix])

    @server.feature(types.TEXT_DOCUMENT_CODE_ACTION, options)
    async def on_code_action(params: types.CodeActionParams) -> Raw:
        uri = params.text_document.uri
        analysis = await server.work.complete(uri)
        if analysis is None:
            return Raw([])
        line = analysis.source.line

        def edit(one: TextEdit) -> Json:
            start = server.places.position(line, one.line, one.column)
            return {
                "range": {"start": start, "end": server.places.position(line, one.end_line, one.end_column)},
                "newText": one.text,
            }

        def item(action: Action) -> Json:
            told = [d for d in params.context.diagnostics if d.code == action.code]
            return {
                "title": action.title,
                "kind": "quickfix",
                "isPreferred": action.preferred,
                "diagnostics": [server.protocol.plain(d) for d in told],
                "edit": {"changes": {uri: [edit(one) for one in action.edits]}},
            }

        first, last = params.range.start.line + 1, params.range.end.line + 1
        # Edits that hold a budget take many timings.
        return Raw([item(action) for action in await to_thread(actions, analysis, first, last)])
