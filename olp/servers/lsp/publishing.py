"""Marks sent to the client: per file, what every open text tells of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lsprotocol import types

from olp.servers.language.findings import FindingMark, Weight
from olp.servers.lsp.places import Json, uri_of

if TYPE_CHECKING:
    from olp.servers.lsp.server import OlpLanguageServer

_SEVERITIES = {Weight.ERROR: 1, Weight.WARNING: 2, Weight.INFO: 3, Weight.HINT: 4}


class Publisher:
    """`_told`: file -> owner (the text whose analysis tells it) -> its marks, as sent last."""

    def __init__(self, server: OlpLanguageServer) -> None:
        self._server = server
        self._told: dict[str, dict[str, list[FindingMark]]] = {}

    def publish(self, owner: str, found: list[FindingMark]) -> None:
        """What the text `owner` tells now, in place of what it told before."""
        files: dict[str, list[FindingMark]] = {owner: []}
        for mark in found:
            files.setdefault(mark.file or owner, []).append(mark)
        for file, tellers in self._told.items():
            if owner in tellers:
                files.setdefault(file, [])
        for file, told in files.items():
            self._put(file, owner, told)

    def forget(self, owner: str) -> None:
        """The text is closed: it tells nothing any more."""
        for file in [file for file, tellers in self._told.items() if owner in tellers]:
            self._put(file, owner, [])

    def _put(self, file: str, owner: str, told: list[FindingMark]) -> None:
        tellers = self._told.setdefault(file, {})
        tellers.pop(owner, None)
        if told:
            tellers[owner] = told
        if not tellers:
            del self._told[file]
        document = self._server.service.documents.get(file)
        marks = dict.fromkeys(mark for found in tellers.values() for mark in found)
        params: Json = {
            "uri": self._server.texts.uris.get(file) or uri_of(file),
            "diagnostics": [self._json(mark) for mark in marks],
        }
        if document is not None and file == owner:
            params["version"] = document.version
        self._server.protocol.tell(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS, params)

    def _json(self, mark: FindingMark) -> Json:
        document = self._server.service.documents.get(mark.file)
        if document is not None:
            where = self._server.places.range(
                document.line, max(mark.line, 1), mark.column, mark.end_column if mark.line else 0
            )
        else:
            where = self._server.places.range(lambda _: "", max(mark.line, 1))
        return {
            "range": where,
            "severity": _SEVERITIES[mark.weight],
            "code": mark.code,
            "source": "olp",
            "message": mark.message,
        }
