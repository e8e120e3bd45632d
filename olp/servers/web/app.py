"""What the browser talks to: who asks is checked first, the workers answer, and what they refuse is told as it is.

Workers are kept: a few that answer one request after the other, and one of its own for each recording.

Codes: Z003 an upload that is too large, Z005 out of time, or ended without an answer, Z006 a request that is none, Z008
unexpected.
"""

from __future__ import annotations

import asyncio
import io
import json
import logging
import os
import secrets
import tempfile
import zipfile
from asyncio.subprocess import Process
from collections import OrderedDict
from collections.abc import AsyncGenerator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import Any, Final

from starlette.applications import Starlette
from starlette.datastructures import FormData, UploadFile
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import HTMLResponse, PlainTextResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from olp.core import resources
from olp.core.diagnostic import Diagnostic, OlpError, Severity, error
from olp.core.files import parse_json
from olp.reports.diagnosis.svg import variables
from olp.reports.webpage import FOLDER, render_page
from olp.servers.confinement import as_json, end_worker, start_worker
from olp.servers.folder import too_large
from olp.servers.web.desk import DROPPED, HEAD, MOST_BYTES, MOST_FILES, WorkerSetting, packed, plain_path

_KEPT = 2  # workers that wait for requests, and requests at once
_ALONE = 1  # recordings at once


class PageWorker:
    """A worker process and its temporary folder, which is removed with it."""

    def __init__(self, process: Process, temporary: tempfile.TemporaryDirectory[str]) -> None:
        self._process = process
        self._temporary = temporary

    @classmethod
    async def started(cls, setting: WorkerSetting) -> PageWorker:
        temporary = tempfile.TemporaryDirectory(prefix="olp-serve-", ignore_cleanup_errors=True)
        worker = cls(await start_worker("web_worker.py"), temporary)
        await worker._send(replace(setting, temporary=str(worker.folder)).as_json())
        return worker

    @property
    def folder(self) -> Path:
        return Path(os.path.realpath(self._temporary.name))

    async def ask(self, request: dict[str, Any], seconds: float) -> dict[str, Any]:
        """Return the answer. Raises OlpError: what the worker rejects, and Z005, after which the worker must be
        ended.
        """
        try:
            told = await asyncio.wait_for(self._asked(request), seconds)
        except TimeoutError:
            says = f"no answer after {seconds:g} s"
            raise OlpError(error("Z005", says, help="ask about less, or use the command line")) from None
        except (asyncio.IncompleteReadError, ConnectionError, ValueError):
            says = "this ended without an answer: it takes too much memory"
            raise OlpError(error("Z005", says, help="ask about less, or use the command line")) from None
        return told

    async def _asked(self, request: dict[str, Any]) -> dict[str, Any]:
        await self._send(request)
        assert self._process.stdout is not None
        size = int.from_bytes(await self._process.stdout.readexactly(HEAD), "big")
        told: dict[str, Any] = parse_json(await self._process.stdout.readexactly(size))
        return told

    async def _send(self, message: dict[str, Any]) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(packed(message))
        await self._process.stdin.drain()

    async def end(self) -> None:
        await end_worker(self._process)
        self._temporary.cleanup()


class WorkerPool:
    """The worker processes of the page. `seconds` [s]: the time limit of one request."""

    def __init__(self, setting: WorkerSetting, seconds: float) -> None:
        self._setting = setting
        self._seconds = seconds
        self._free: list[PageWorker] = []
        self._all: set[PageWorker] = set()
        self._places = asyncio.Semaphore(_KEPT)
        self._alone = asyncio.Semaphore(_ALONE)

    async def warm(self) -> None:
        """Start the workers before the first request."""
        self._free = [await self._start() for _ in range(_KEPT)]

    async def ask(self, what: str, given: dict[str, Any]) -> dict[str, Any]:
        """Return the answer of one of the running workers. Raises OlpError."""
        async with self._places:
            worker = self._free.pop() if self._free else await self._start()
            try:
                told = await worker.ask({"ask": what, "given": given}, self._seconds)
            except BaseException:
                await self._end(worker)
                raise
            self._free.append(worker)
        return _answer(told)

    async def ask_alone(
        self, what: str, given: dict[str, Any], fill: Callable[[Path], None]
    ) -> dict[str, Any]:
        """Return the answer of a new worker for this request alone; `fill` puts the files into its folder. Raises
        OlpError.
        """
        async with self._alone:
            worker = await self._start()
            try:
                await asyncio.to_thread(fill, worker.folder / DROPPED)
                return _answer(await worker.ask({"ask": what, "given": given}, self._seconds))
            finally:
                await self._end(worker)

    async def close(self) -> None:
        """End all workers, busy ones included."""
        for worker in list(self._all):
            await self._end(worker)

    async def _start(self) -> PageWorker:
        worker = await PageWorker.started(self._setting)
        self._all.add(worker)
        return worker

    async def _end(self, worker: PageWorker) -> None:
        self._all.discard(worker)
        await worker.end()


def _answer(told: dict[str, Any]) -> dict[str, Any]:
    if "diagnostics" in told:
        raise OlpError(*(_diagnostic(row) for row in told["diagnostics"]))
    answer: dict[str, Any] = told["answer"]
    return answer


def _diagnostic(row: dict[str, Any]) -> Diagnostic:
    return Diagnostic(**(row | {"severity": Severity(row["severity"])}))


log = logging.getLogger("olp.serve")
_MOST_JSON = 1_000_000  # [bytes] of a request that is no upload
_RESULTS = 8  # diagnoses that are kept for the page
_ASKS: Final = ("cell", "compare", "what_if_lines", "what_if_times")
# Of every answer. A report has a policy of its own, which allows its own script and nothing else.
_HEADERS: Final = {
    "content-security-policy": "frame-ancestors 'self'; base-uri 'none'; form-action 'none'",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cache-control": "no-store",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
}
_OWN: Final = "default-src 'none'; style-src 'self'; img-src data:; base-uri 'none'; form-action 'none'; "
_PAGE_POLICY: Final = f"{_OWN}script-src 'self'; connect-src 'self'; frame-src 'self'; frame-ancestors 'none'"
_PROBLEM_POLICY: Final = f"{_OWN}frame-ancestors 'self'"


class Doorkeeper:
    """Lets requests pass that carry the token and name this host; all others get no information.

    A foreign Host header means that another site's name resolves to this machine (DNS rebinding); a foreign Origin
    header means that another page sent the request.
    """

    def __init__(self, app: ASGIApp, token: str, port: int) -> None:
        self.app = app
        self.token = token.encode()
        self.hosts = tuple(f"{name}:{port}".encode() for name in ("127.0.0.1", "localhost"))

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        refused = self._refused(scope)
        if refused is not None:
            await refused(scope, receive, _with_headers(send))
            return
        rest = scope["path"].removeprefix("/").partition("/")[2]
        inner = {**scope, "path": f"/{rest}", "root_path": ""}
        await self.app(inner, _bounded(scope, receive), _with_headers(send))

    def _refused(self, scope: Scope) -> Response | None:
        named: dict[bytes, list[bytes]] = {}
        for name, value in scope["headers"]:
            named.setdefault(name, []).append(value)
        hosts, origins = named.get(b"host", []), named.get(b"origin", [])
        if len(hosts) != 1 or hosts[0].lower() not in self.hosts:
            return PlainTextResponse("This server answers to 127.0.0.1 only.", 400)
        if any(origin.lower() != b"http://" + hosts[0].lower() for origin in origins):
            return PlainTextResponse("This server answers its own page only.", 403)
        token, slash, _ = scope["path"].encode().removeprefix(b"/").partition(b"/")
        if not secrets.compare_digest(token, self.token) or not slash:
            return PlainTextResponse("Use the address that olp serve has printed.", 404)
        return None


def _with_headers(send: Send) -> Send:
    async def sent(message: Message) -> None:
        if message["type"] == "http.response.start":
            known = {name for name, _ in message["headers"]}
            more = [(n.encode(), v.encode()) for n, v in _HEADERS.items() if n.encode() not in known]
            message = {**message, "headers": [*message["headers"], *more]}
        await send(message)

    return sent


def _bounded(scope: Scope, receive: Receive) -> Receive:
    """Return `receive` with a limit of the body's size, whatever its header states. Raises OlpError (Z003) beyond
    it.
    """
    most = MOST_BYTES if scope["path"].endswith("/api/diagnose") else _MOST_JSON
    size = 0

    async def received() -> Message:
        nonlocal size
        message = await receive()
        size += len(message.get("body", b""))
        if size > most:
            raise OlpError(too_large("the upload", size, most))
        return message

    return received


Answer = Callable[["FolderSite", Request], Awaitable[Response]]


def told(answer: Answer) -> Callable[[FolderSite, Request], Awaitable[Response]]:
    """Wrap a handler so that errors become diagnostics: as JSON, or as a page where a page was requested."""

    async def answered(site: FolderSite, request: Request) -> Response:
        status = 422
        try:
            return await answer(site, request)
        except OlpError as refused:
            diagnostics = refused.diagnostics
        except asyncio.CancelledError:  # Ctrl+C: the browser is told, and the terminal sees no traceback
            diagnostics, status = (error("Z005", "olp serve has been ended"),), 503
        except ClientDisconnect:
            diagnostics = (error("Z006", "the browser has gone"),)
        except HTTPException as refused:  # a form that is none
            diagnostics = (error("Z006", str(refused.detail), help="drop files on the page"),)
        except Exception as problem:
            log.exception("a request failed")
            says = f"olp failed in a way that it does not know ({type(problem).__name__})"
            diagnostics = (error("Z008", says, help="the terminal of olp serve has the details"),)
            status = 500
        rows = [as_json(d) for d in diagnostics]
        if request.method == "GET":
            html = render_page("serve_problem.html.j2", {"diagnostics": rows})
            return HTMLResponse(html, status, {"content-security-policy": _PROBLEM_POLICY})
        return _json({"diagnostics": rows}, status)

    return answered


class FolderSite:
    """The pages and answers of one folder."""

    def __init__(self, pool: WorkerPool, name: str) -> None:
        self.pool = pool
        self.name = name
        self._cell: dict[str, Any] = {}
        self._results: OrderedDict[str, str] = OrderedDict()

    async def start_page(self, request: Request) -> Response:
        text = resources.read_text(FOLDER, "serve.html")
        return HTMLResponse(text, headers={"content-security-policy": _PAGE_POLICY})

    async def script(self, request: Request) -> Response:
        return Response(resources.read_text(FOLDER, "serve.js"), media_type="text/javascript")

    async def style(self, request: Request) -> Response:
        parts = (
            variables(),
            resources.read_text(FOLDER, "report.css"),
            resources.read_text(FOLDER, "serve.css"),
        )
        return Response("".join(parts), media_type="text/css")

    @told
    async def ask(self, request: Request) -> Response:
        what = request.path_params["what"]
        if what not in _ASKS:
            raise OlpError(error("Z006", f"there is no question {what[:40]!r}", help=", ".join(_ASKS)))
        given = _object(await request.body() or b"{}")
        if what == "cell":
            return _json(await self._asked_cell())
        return _json(await self.pool.ask(what, given))

    async def _asked_cell(self) -> dict[str, Any]:
        fresh = await self.pool.ask("cell", {"known": self._cell.get("stamp")})
        self._cell = fresh or self._cell
        return {"folder": self.name, **self._cell}

    @told
    async def program_page(self, request: Request) -> Response:
        return HTMLResponse(
            (await self.pool.ask("page", _object(request.query_params.get("given", ""))))["html"]
        )

    @told
    async def download(self, request: Request) -> Response:
        given = _object(request.query_params.get("given", ""))
        files = {
            name: bytes.fromhex(data) for name, data in (await self.pool.ask("what_if_files", given)).items()
        }
        ((name, data),) = files.items() if len(files) == 1 else (_zipped(given, files),)
        plain = "".join(
            sign if sign.isascii() and (sign.isalnum() or sign in "._-$") else "_" for sign in name
        )
        headers = {"content-disposition": f'attachment; filename="{plain}"'}
        return Response(data, media_type="application/octet-stream", headers=headers)

    @told
    async def diagnose(self, request: Request) -> Response:
        async with request.form(max_files=MOST_FILES, max_fields=2) as form:
            job = form.get("job")
            given = {"job": job if isinstance(job, str) else ""}
            files = _uploads(form)
            answer = await self.pool.ask_alone("diagnose", given, lambda folder: _laid_down(files, folder))
        key = secrets.token_hex(8)
        self._results[key] = answer["html"]
        while len(self._results) > _RESULTS:
            self._results.popitem(last=False)
        return _json({"page": f"result?key={key}"})

    @told
    async def result(self, request: Request) -> Response:
        html = self._results.get(request.query_params.get("key", ""))
        if html is None:
            raise OlpError(error("Z006", "this diagnosis is no longer kept", help="drop the recording again"))
        return HTMLResponse(html)


def _object(text: str | bytes) -> dict[str, Any]:
    """What a request says: the JSON object in its body, or in its address as `?given=…`. Raises OlpError (Z006)."""
    try:
        given = parse_json(text)
        json.dumps(given, allow_nan=False)
    except ValueError as problem:
        raise OlpError(error("Z006", f"this is no JSON: {problem}"[:200])) from None
    if not isinstance(given, dict):
        raise OlpError(error("Z006", "a request is a JSON object"))
    return given


def _uploads(form: FormData) -> list[tuple[PurePosixPath, UploadFile]]:
    """The files of a form, each with its name. Raises OlpError (Z006, Z012)."""
    files = [one for one in form.getlist("file") if isinstance(one, UploadFile)]
    if not files:
        raise OlpError(error("Z006", "there is no file in this upload", help="drop a recording on the page"))
    return [(plain_path(one.filename or ""), one) for one in files]


def _laid_down(files: list[tuple[PurePosixPath, UploadFile]], folder: Path) -> None:
    folder.mkdir()
    for name, upload in files:
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(upload.file.read())


def _zipped(given: dict[str, Any], files: dict[str, bytes]) -> tuple[str, bytes]:
    """A program whose data stand in a file of their own: both in one archive."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return f"{Path(str(given['file'])).stem}.zip", out.getvalue()


def _json(value: Any, status: int = 200) -> Response:
    text = json.dumps(value, ensure_ascii=False, allow_nan=False)
    return Response(text.encode("utf-8", "replace"), status, media_type="application/json")


def web_app(
    pool: WorkerPool, name: str, token: str, port: int, ready: Callable[[], object] = lambda: None
) -> ASGIApp:
    """The application. `name`: of the folder, for people; `ready` is called when it can answer."""
    site = FolderSite(pool, name)

    @asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncGenerator[None]:
        await pool.warm()
        ready()
        try:
            yield
        finally:
            await pool.close()

    inner = Starlette(
        lifespan=lifespan,
        routes=[
            Route("/", site.start_page),
            Route("/serve.js", site.script),
            Route("/serve.css", site.style),
            Route("/page", site.program_page),
            Route("/download", site.download),
            Route("/result", site.result),
            Route("/api/diagnose", site.diagnose, methods=["POST"]),
            Route("/api/{what}", site.ask, methods=["POST"]),
        ],
    )
    return Doorkeeper(inner, token, port)
