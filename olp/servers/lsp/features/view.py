"""`olp/view`: the page of `olp report` for the open text, and its data alone once a host has the page."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from olp.servers.language.analysis import Analysis
from olp.servers.language.service import ProgramService
from olp.servers.lsp.places import uri_of
from olp.servers.lsp.server import OlpLanguageServer, Raw


def register(server: OlpLanguageServer, service: ProgramService) -> None:
    @server.feature("olp/view")
    async def view(params: Any) -> Raw:
        """{uri, page?} -> {title, files, data, html?} or null; `files`: the URI of each number in data.file."""
        uri = getattr(params, "uri", None)
        analysis = await server.work.current(uri) if isinstance(uri, str) else None
        if analysis is None:
            return Raw(None)
        answer = {
            "title": Path(analysis.path).name,
            "files": _files(server, analysis),
            "data": _data(analysis),
        }
        if getattr(params, "page", False) is True:
            answer["html"] = _page(analysis)
        return Raw(answer)


def _files(server: OlpLanguageServer, analysis: Analysis) -> list[str]:
    """Those that run by their numbers, then those that only say something about them, such as lists of data."""
    run = [analysis.path] if analysis.timing is None else [s.path for s in analysis.timing.plan.sources]
    paths = [*run, *(path for path in analysis.needs if path not in run)]
    return [server.texts.uris.get(path) or uri_of(path) for path in paths]


def _data(analysis: Analysis) -> dict[str, Any] | None:
    from olp.reports.page.data import program_data

    return None if analysis.timing is None else program_data(analysis.timing)


def _page(analysis: Analysis) -> str:
    from olp.reports.page.page import PageEntry, report_page

    entry = PageEntry(Path(analysis.path).name, analysis.timing, analysis.diagnostics)
    return report_page([entry], hosted=True)
