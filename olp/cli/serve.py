"""`olp serve`: a folder on a local page. Codes: C015 no such folder, C020 libraries missing, C021 no such port."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from olp.core.diagnostic import OlpError, error

if TYPE_CHECKING:
    import socket
    from collections.abc import Callable
    from pathlib import Path

    from olp.servers.web.desk import WorkerSetting

SUMMARY = "show a folder on a local page: times, what-if, versions, recordings"
SERVES = True
_NEEDED = ("starlette", "uvicorn", "python_multipart")


def add_arguments(parser: ArgumentParser) -> None:
    from olp.cli._timing import add_timing_arguments, positive

    parser.add_argument("folder", nargs="?", default=".", metavar="FOLDER", help="what is shown (default: .)")
    parser.add_argument(
        "--port", type=_port, default=0, metavar="N", help="of 127.0.0.1 (default: a free one)"
    )
    parser.add_argument("--no-browser", action="store_true", help="print the address, open nothing")
    parser.add_argument(
        "--seconds", type=positive, default=120.0, metavar="S", help="of one request (default: 120)"
    )
    add_timing_arguments(parser)


def _port(text: str) -> int:
    from argparse import ArgumentTypeError

    if not text.isdecimal() or not 0 < int(text) < 65536:
        raise ArgumentTypeError(f"{text!r} is not a port: 1 to 65535")
    return int(text)


def run(args: Namespace) -> int:
    import os
    import secrets
    import webbrowser
    from importlib.util import find_spec
    from pathlib import Path
    from threading import Thread

    missing = [name.replace("_", "-") for name in _NEEDED if find_spec(name) is None]
    if missing:
        says = f"olp serve needs {' and '.join(missing)}"
        raise OlpError(error("C020", says, help='install them: pip install "olp[serve]"'))
    root = Path(os.path.realpath(args.folder))
    if not root.is_dir():
        raise OlpError(error("C015", "this is not a folder", file=args.folder, help="name one that is there"))
    setting = _setting(args, root)
    listener = _listener(args.port)
    port, token = listener.getsockname()[1], secrets.token_urlsafe(24)
    address = f"http://127.0.0.1:{port}/{token}/"
    print(f"{root} is shown at {address}\nCtrl+C ends it.", flush=True)

    def ready() -> None:
        if not args.no_browser:
            Thread(target=webbrowser.open, args=(address,), daemon=True).start()

    _serve(setting, args.seconds, listener, token, ready)
    return 0


def _setting(args: Namespace, root: Path) -> WorkerSetting:
    """How workers time. Paths become absolute: they work in the folder. Raises OlpError for what is none."""
    import os
    from pathlib import Path

    from olp.cli._timing import timing_job_of
    from olp.runtime.assumptions import nearest_assumptions
    from olp.servers.web.desk import WorkerSetting

    also = []
    for name in ("robot", "signature", "assumptions"):
        path = getattr(args, name)
        if path is not None and os.path.isfile(path):
            setattr(args, name, os.path.realpath(path))
            also.append(os.path.realpath(path))
    above = nearest_assumptions(root)
    if above is not None:
        also.append(os.path.realpath(above))
    job = timing_job_of(args)
    outside = tuple(path for path in also if not Path(path).is_relative_to(root))
    return WorkerSetting(str(root), "", job, tuple(_words(args)), outside)


def _words(args: Namespace) -> list[str]:
    """The options of timing, as the command line takes them again."""
    from olp.cli._timing import add_timing_arguments
    from olp.cli.command import Parser

    known = Parser("olp", "")
    add_timing_arguments(known)
    given = ((action.option_strings, getattr(args, action.dest, None), action) for action in known._actions)
    return [f"{names[-1]}={value}" for names, value, action in given if value not in (None, action.default)]


def _listener(port: int) -> socket.socket:
    """Raises OlpError (C021) for a port that is taken or not given."""
    import os
    import socket

    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        # On Windows this would take over the port of another program.
        if os.name != "nt":
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(("127.0.0.1", port))
        listener.listen(64)
    except OSError as problem:
        listener.close()
        says = f"port {port} cannot be used: {problem.strerror}"
        raise OlpError(error("C021", says, help="another --port, or none for a free one")) from None
    return listener


def _serve(
    setting: WorkerSetting, seconds: float, listener: socket.socket, token: str, ready: Callable[[], None]
) -> None:
    """Until Ctrl+C."""
    import contextlib
    import logging
    from pathlib import Path

    import uvicorn

    from olp.servers.web.app import WorkerPool, web_app

    logging.basicConfig(level=logging.WARNING, format="olp serve: %(message)s")
    # Whatever goes wrong is told by the application; this one adds what it ended, and how.
    logging.getLogger("uvicorn.error").setLevel(logging.CRITICAL)
    app = web_app(
        WorkerPool(setting, seconds), Path(setting.root).name, token, listener.getsockname()[1], ready
    )
    server = uvicorn.Server(
        uvicorn.Config(
            app,
            loop="asyncio",
            ws="none",
            log_config=None,
            access_log=False,
            server_header=False,
            proxy_headers=False,
            timeout_graceful_shutdown=1,
        )
    )
    # Uvicorn ends as it should and raises the signal again afterwards.
    with contextlib.suppress(KeyboardInterrupt):
        server.run(sockets=[listener])
