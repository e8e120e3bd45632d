"""`olp/total`: what `olp/timing` says of the whole program, without its segments: for a status bar."""

from __future__ import annotations

from typing import Any

from olp.servers.language.service import ProgramService
from olp.servers.lsp.server import OlpLanguageServer, Raw


def register(server: OlpLanguageServer, service: ProgramService) -> None:
    @server.feature("olp/total")
    async def total(params: Any) -> Raw:
        from olp.reports.formats import Options
        from olp.reports.formats.json import as_object

        uri = getattr(params, "uri", None)
        analysis = await server.work.current(uri) if isinstance(uri, str) else None
        if analysis is None:
            return Raw(None)
        options = Options(segments=False)
        return Raw(as_object(analysis.path, analysis.timing, analysis.diagnostics, options))
