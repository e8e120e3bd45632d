"""Definitions, references and the outline."""

from __future__ import annotations

from lsprotocol import types

from olp.core.source import load
from olp.languages.tokens import TokenKind
from olp.servers.language.service import ProgramService
from olp.servers.language.symbols import OutlineSymbol, PlacedName, definitions, outline, references
from olp.servers.lsp.server import Json, Line, OlpLanguageServer, Raw, uri_of

_KINDS = {
    TokenKind.ROUTINE: types.SymbolKind.Function,
    TokenKind.LABEL: types.SymbolKind.Key,
    TokenKind.POINT: types.SymbolKind.Constant,
    TokenKind.VARIABLE: types.SymbolKind.Variable,
    TokenKind.FRAME: types.SymbolKind.Object,
    TokenKind.TOOL: types.SymbolKind.Object,
    TokenKind.SIGNAL: types.SymbolKind.Event,
}


def register(server: OlpLanguageServer, service: ProgramService) -> None:
    def location(name: PlacedName) -> Json:
        line = _lines(service, name.file)
        where = server.places.range(line, name.line, name.column, name.end_column)
        return {"uri": server.texts.uris.get(name.file) or uri_of(name.file), "range": where}

    @server.feature(types.TEXT_DOCUMENT_DEFINITION)
    async def on_definition(params: types.DefinitionParams) -> Raw:
        analysis = await server.work.current(params.text_document.uri)
        if analysis is None:
            return Raw([])
        place = server.places.place(analysis.source.line, params.position)
        return Raw([location(name) for name in definitions(service, analysis, *place)])

    @server.feature(types.TEXT_DOCUMENT_REFERENCES)
    async def on_references(params: types.ReferenceParams) -> Raw:
        analysis = await server.work.current(params.text_document.uri)
        if analysis is None:
            return Raw([])
        place = server.places.place(analysis.source.line, params.position)
        found = references(service, analysis, *place, params.context.include_declaration)
        return Raw([location(name) for name in found])

    @server.feature(types.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
    async def on_symbols(params: types.DocumentSymbolParams) -> Raw:
        analysis = await server.work.current(params.text_document.uri)
        if analysis is None:
            return Raw([])
        line = analysis.source.line

        def entry(symbol: OutlineSymbol) -> Json:
            places = server.places
            return {
                "name": symbol.name,
                "kind": _KINDS[symbol.kind].value,
                "range": {
                    "start": places.position(line, symbol.line, 1),
                    "end": places.position(line, symbol.last, len(line(symbol.last)) + 1),
                },
                "selectionRange": places.range(line, symbol.line, symbol.column, symbol.end_column),
                "children": [entry(child) for child in symbol.children],
            }

        return Raw([entry(symbol) for symbol in outline(analysis)])


def _lines(service: ProgramService, file: str) -> Line:
    document = service.documents.get(file)
    if document is not None:
        return document.line
    try:
        return load(file).line
    except OSError:
        return lambda _: ""
