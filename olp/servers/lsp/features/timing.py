"""Requests for hosts that draw: `olp/timing`, `olp/total` and `olp/view` of the open text.

`olp/timing` is the object of `olp time --format json`, `olp/total` the same without its segments, for a status bar;
`olp/view` is the page of `olp report`, and its data alone once a host has the page.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from olp.servers.language.service import Analysis, ProgramService
from olp.servers.lsp.server import OlpLanguageServer, Raw, uri_of


def register(server: OlpLanguageServer, service: ProgramService) -> None:
    @server.feature("olp/timing")
    async def timing(params: Any) -> Raw:
        return _timed(await _analysis(server, params), segments=True)

    @server.feature("olp/total")
    async def total(params: Any) -> Raw:
        return _timed(await _analysis(server, params), segments=False)

    @server.feature("olp/view")
    async def view(params: Any) -> Raw:
        """{uri, page?} -> {title, files, data, html?} or null; `files`: the URI of each number in data.file."""
        analysis = await _analysis(server, params)
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


async def _analysis(server: OlpLanguageServer, params: Any) -> Analysis | None:
    """Return the analysis of the open text that `params.uri` names; None where no such text is open."""
    uri = getattr(params, "uri", None)
    return await server.work.current(uri) if isinstance(uri, str) else None


def _timed(analysis: Analysis | None, segments: bool) -> Raw:
    from olp.reports.formats.json import as_object
    from olp.reports.formats.report import Options

    if analysis is None:
        return Raw(None)
    return Raw(as_object(analysis.path, analysis.timing, analysis.diagnostics, Options(segments=segments)))


def _files(server: OlpLanguageServer, analysis: Analysis) -> list[str]:
    """Return the URIs of the files that run, in the order of their numbers, then those that the analysis also needs."""
    run = [analysis.path] if analysis.timing is None else [s.path for s in analysis.timing.plan.sources]
    paths = [*run, *(path for path in analysis.needs if path not in run)]
    return [server.texts.uris.get(path) or uri_of(path) for path in paths]


def _data(analysis: Analysis) -> dict[str, Any] | None:
    from olp.reports.page import program_data

    return None if analysis.timing is None else program_data(analysis.timing)


def _page(analysis: Analysis) -> str:
    from olp.reports.page import PageEntry, report_page

    entry = PageEntry(Path(analysis.path).name, analysis.timing, analysis.diagnostics)
    return report_page([entry], hosted=True)
