"""`olp/timing`: the object of `olp time --format json` for the open text, for hosts that draw."""

from __future__ import annotations

from typing import Any

from olp.servers.language.service import ProgramService
from olp.servers.lsp.places import path_of
from olp.servers.lsp.server import OlpLanguageServer, Raw


def register(server: OlpLanguageServer, service: ProgramService) -> None:
    @server.feature("olp/timing")
    async def timing(params: Any) -> Raw:
        from olp.reports.formats import Options
        from olp.reports.formats.json import as_object

        uri = getattr(params, "uri", None)
        if not isinstance(uri, str):
            return Raw(None)
        analysis = await server.work.current(uri)
        if analysis is None:
            return Raw(None)
        file = path_of(uri)
        return Raw(as_object(file, analysis.timing, analysis.diagnostics, Options()))
