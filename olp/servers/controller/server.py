"""The stepping controller behind a TCP socket of this machine, for simulators in any language."""

from __future__ import annotations

import os
import socketserver
from threading import BoundedSemaphore
from typing import Final

from olp.core.diagnostic import OlpError, error
from olp.servers.controller.session import LONGEST_LINE, Session

HOST: Final = "127.0.0.1"  # never reachable from elsewhere: the protocol asks nobody who they are
MOST_SESSIONS: Final = 8
PATIENCE: Final = 3600.0  # [s] without a request, then the session ends

_BUSY = (
    b'{"ok": false, "diagnostics": [{"code": "S014", "severity": "error", '
    b'"message": "too many sessions at once", "help": "close another one first"}]}\n'
)


class _Handler(socketserver.StreamRequestHandler):
    """One connection is one session."""

    server: ControllerServer
    timeout = PATIENCE
    disable_nagle_algorithm = True  # a simulator waits for each answer

    def handle(self) -> None:
        if not self.server.places.acquire(blocking=False):
            self.wfile.write(_BUSY)
            return
        try:
            self._serve(Session())
        except (ConnectionError, TimeoutError):
            pass  # the simulator has gone
        finally:
            self.server.places.release()

    def _serve(self, session: Session) -> None:
        while line := self.rfile.readline(LONGEST_LINE + 1):
            answer = session.answer(line)
            self.wfile.write(answer.line)
            if answer.last:
                return


class ControllerServer(socketserver.ThreadingTCPServer):
    """Serves until `shutdown`. Raises OlpError S015 for a port that cannot be had."""

    # Elsewhere it lets a server come back at once; on Windows two could share a port.
    allow_reuse_address = os.name != "nt"
    daemon_threads = True

    def __init__(self, port: int) -> None:
        self.places = BoundedSemaphore(MOST_SESSIONS)
        try:
            super().__init__((HOST, port), _Handler)
        except (OSError, OverflowError) as problem:
            why = getattr(problem, "strerror", None) or str(problem)
            raise OlpError(
                error(
                    "S015", f"cannot listen on port {port}: {why}", help="another --port; 0 takes a free one"
                )
            ) from None

    @property
    def port(self) -> int:
        """The port it listens on."""
        port: int = self.socket.getsockname()[1]
        return port
