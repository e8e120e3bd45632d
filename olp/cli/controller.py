"""`olp controller`: a robot controller that a simulator steps, behind a socket of this machine."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

SUMMARY = "serve a controller that a simulator can step through its motion"
SERVES = True
DEFAULT_PORT = 40115


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--port",
        type=port,
        default=DEFAULT_PORT,
        metavar="N",
        help=f"of this machine only, 0 takes a free one (default: {DEFAULT_PORT})",
    )


def port(text: str) -> int:
    """A TCP port, 0 to 65535."""
    value = int(text)
    if not 0 <= value <= 65_535:
        raise ValueError(text)
    return value


def run(args: Namespace) -> int:
    import signal

    from olp.servers.controller.server import HOST, ControllerServer

    # A service manager ends it with SIGTERM, and a shell's background job is deaf to Ctrl-C unless told otherwise.
    for ending in (signal.SIGINT, signal.SIGTERM):
        signal.signal(ending, signal.default_int_handler)
    with ControllerServer(args.port) as server:
        print(f"listening on {HOST}:{server.port}, end with Ctrl-C", flush=True)
        try:
            server.serve_forever()
        except KeyboardInterrupt:  # how a server is ended
            print()
    return 0
