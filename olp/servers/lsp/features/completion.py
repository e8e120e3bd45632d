"""`textDocument/completion`: words of the language, names of the text, jobs of the folder."""

from __future__ import annotations

from lsprotocol import types

from olp.languages.tokens import TokenKind
from olp.servers.language.service import ProgramService
from olp.servers.language.symbols import Proposal, completion
from olp.servers.lsp.server import Json, OlpLanguageServer, Raw, path_of

_KINDS = {
    None: types.CompletionItemKind.Keyword,
    TokenKind.ROUTINE: types.CompletionItemKind.Function,
    TokenKind.LABEL: types.CompletionItemKind.Reference,
    TokenKind.POINT: types.CompletionItemKind.Constant,
    TokenKind.VARIABLE: types.CompletionItemKind.Variable,
    TokenKind.FRAME: types.CompletionItemKind.Struct,
    TokenKind.TOOL: types.CompletionItemKind.Struct,
    TokenKind.SIGNAL: types.CompletionItemKind.Event,
}


def register(server: OlpLanguageServer, service: ProgramService) -> None:
    options = types.CompletionOptions(trigger_characters=[":", "*", "$", "[", "#"])

    @server.feature(types.TEXT_DOCUMENT_COMPLETION, options)
    async def on_completion(params: types.CompletionParams) -> Raw:
        analysis = await server.work.current(params.text_document.uri)
        document = service.documents.get(path_of(params.text_document.uri))
        if analysis is None or document is None:
            return Raw([])
        place = server.places.place(document.line, params.position)

        def item(proposal: Proposal) -> Json:
            where = server.places.range(document.line, place.line, proposal.column, place.column)
            return {
                "label": proposal.text,
                "kind": _KINDS[proposal.kind].value,
                "detail": proposal.detail,
                "filterText": proposal.text,
                "sortText": f"{proposal.kind is None:d}{proposal.text}",
                "textEdit": {"range": where, "newText": proposal.text},
            }

        found = completion(analysis, document.line(place.line), place.line, place.column)
        return Raw([item(proposal) for proposal in found])
