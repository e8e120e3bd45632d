"""Workers that are kept: a few that answer one request after the other, and one of its own for each recording.

Code: Z005 out of time, or ended without an answer.
"""

from __future__ import annotations

import asyncio
import os
import tempfile
from asyncio.subprocess import Process
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from olp.core.diagnostic import Diagnostic, OlpError, Severity, error
from olp.core.files import parse_json
from olp.servers.web.messages import DROPPED, HEAD, WorkerSetting, packed
from olp.servers.worker_process import end_worker, start_worker

_KEPT = 2  # workers that wait for requests, and requests at once
_ALONE = 1  # recordings at once


class PageWorker:
    """One process and its own temporary folder, which goes with it."""

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
        """The answer. Raises OlpError: what the worker refuses, and Z005; then it has to be ended."""
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
    """`seconds` [s]: of one request."""

    def __init__(self, setting: WorkerSetting, seconds: float) -> None:
        self._setting = setting
        self._seconds = seconds
        self._free: list[PageWorker] = []
        self._all: set[PageWorker] = set()
        self._places = asyncio.Semaphore(_KEPT)
        self._alone = asyncio.Semaphore(_ALONE)

    async def warm(self) -> None:
        """Starts the workers before somebody waits for them."""
        self._free = [await self._start() for _ in range(_KEPT)]

    async def ask(self, what: str, given: dict[str, Any]) -> dict[str, Any]:
        """The answer of a kept worker. Raises OlpError."""
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
        """The answer of a worker for this request alone, whose folder `fill` has filled. Raises OlpError."""
        async with self._alone:
            worker = await self._start()
            try:
                await asyncio.to_thread(fill, worker.folder / DROPPED)
                return _answer(await worker.ask({"ask": what, "given": given}, self._seconds))
            finally:
                await self._end(worker)

    async def close(self) -> None:
        """Ends all workers, also those that are at work."""
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
    return Diagnostic(**{**row, "severity": Severity(row["severity"])})
