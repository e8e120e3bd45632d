"""When what is computed: the newest text first, the rules when nobody types, nothing twice.

Messages that have arrived are all handled before anything is computed, because the reader hands them over without a
pause. So of many keystrokes only the last one is computed, and one that arrives meanwhile ends the computation.
"""

from __future__ import annotations

import asyncio
import gc
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from olp.core.memory_limit import SupersededError
from olp.servers.language.analysis import Analysis
from olp.servers.language.findings import marks
from olp.servers.language.rules import rule_runs
from olp.servers.lsp.publishing import Publisher

if TYPE_CHECKING:
    from olp.servers.lsp.server import OlpLanguageServer

_PATIENCE = 1.0  # [s] without an answer; then no keystroke ends a computation any more
_IDLE = 0.25  # [s] without a message, before the rules run
_TIDY = 3.0  # [s], before garbage is looked for


class Scheduler:
    """`arrived`: counts the changes that the reader has seen, handled or not."""

    def __init__(self, server: OlpLanguageServer) -> None:
        self._server = server
        self._publisher = Publisher(server)
        self._dirty: dict[str, None] = {}
        self._waiting: dict[str, list[asyncio.Future[None]]] = {}
        self._scheduled = False
        self._idle: asyncio.TimerHandle | None = None
        self._answered = time.monotonic()

    def changed(self, path: str) -> None:
        """The text of `path` is another one: it comes first, then those that need it."""
        self._concern(path)
        self._dirty.pop(path, None)
        self._dirty[path] = None
        self._soon()

    def _concern(self, path: str) -> None:
        """Other texts that the change of `path` may have made out of date."""
        service = self._server.service
        for other in service.dependents(path):
            service.forget(other)
            self._dirty.setdefault(other)

    def refresh(self) -> None:
        """Nothing that is known holds any more: settings or files of the disk have changed."""
        self._server.service.forget()
        for path in self._server.service.documents:
            self._dirty.setdefault(path)
        self._soon()

    def closed(self, path: str) -> None:
        self._dirty.pop(path, None)
        self._release(path)
        self._publisher.forget(path)
        self._concern(path)
        self._soon()

    async def current(self, uri: str) -> Analysis | None:
        """What is known of the newest text, None where none is open."""
        from olp.servers.lsp.places import path_of

        path, service = path_of(uri), self._server.service
        while path in service.documents and not service.is_current(path):
            waiting: asyncio.Future[None] = asyncio.get_running_loop().create_future()
            self._waiting.setdefault(path, []).append(waiting)
            self._dirty.setdefault(path)
            self._soon()
            await waiting
        return service.analyses.get(path)

    async def complete(self, uri: str) -> Analysis | None:
        """The same with what the rules find, for whoever cannot wait until nobody types."""
        from olp.servers.language.rules import complete
        from olp.servers.lsp.places import path_of

        if await self.current(uri) is None:
            return None
        return complete(self._server.service, path_of(uri))

    # --- one thing after the other ----------------------------------------------------------------------

    def _soon(self) -> None:
        if self._idle is not None:
            self._idle.cancel()
            self._idle = None
        if not self._scheduled and self._dirty:
            self._scheduled = True
            asyncio.get_running_loop().call_soon(self._next)

    def _next(self) -> None:
        """The text that was changed last."""
        self._scheduled = False
        if self._dirty:
            path, _ = self._dirty.popitem()
            self._compute(path)
        if self._dirty:
            self._soon()
        else:
            self._later(_IDLE, self._rules)

    def _compute(self, path: str) -> None:
        before = self._server.service.analyses.get(path)
        handled = self._server.arrived
        patient = time.monotonic() - self._answered < _PATIENCE

        def wanted() -> bool:
            return not patient or self._server.arrived == handled

        try:
            analysis = self._server.service.current(path, wanted, whole=False)
        except SupersededError:
            self._dirty[path] = None
            return
        self._answered = time.monotonic()
        self._release(path)
        if analysis is not None:
            self._publisher.publish(path, marks(analysis))
            if before is not None and before.edition == -1:
                self._server.ask_again()

    def _release(self, path: str) -> None:
        for waiting in self._waiting.pop(path, ()):
            if not waiting.done():
                waiting.set_result(None)

    # --- when nobody types ------------------------------------------------------------------------------

    def _later(self, seconds: float, what: Callable[[], None]) -> None:
        self._idle = asyncio.get_running_loop().call_later(seconds, what)

    def _rules(self) -> None:
        """Programs that go on and on to their end, then the rules of lint over all texts, until one changes."""
        self._idle = None
        if self._complete():
            self._step(rule_runs(self._server.service))

    def _complete(self) -> bool:
        """False where a keystroke has come meanwhile."""
        service, seen = self._server.service, self._server.arrived
        for path in [path for path, analysis in service.analyses.items() if analysis.partial]:
            try:
                analysis = service.current(path, lambda: self._server.arrived == seen)
            except SupersededError:
                return False
            if analysis is not None:
                self._publisher.publish(path, marks(analysis))
                self._server.ask_again()
        return True

    def _step(self, runs: Iterator[str]) -> None:
        self._idle = None
        path = next(runs, None)
        if path is None:
            self._later(_TIDY, self._tidy)
            return
        if path and path in self._server.service.analyses:
            self._publisher.publish(path, marks(self._server.service.analyses[path]))
        self._later(0.0, lambda: self._step(runs))

    def _tidy(self) -> None:
        """Looks for garbage while nobody waits; the collector never runs by itself."""
        self._idle = None
        gc.collect()
        gc.freeze()
