"""`olp mcp`: a server for assistants. Codes: C014 its library is missing, C015 no such folder."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from olp.core.diagnostic import OlpError, error

SUMMARY = "serve one folder to an assistant (Model Context Protocol over stdio)"
SERVES = True


def add_arguments(parser: ArgumentParser) -> None:
    from olp.cli._timing import positive

    parser.add_argument(
        "--root",
        default=".",
        metavar="FOLDER",
        help="what the assistant sees; nothing outside is read (default: .)",
    )
    parser.add_argument(
        "--write", action="store_true", help="let it write new files there: convert, annotate, report"
    )
    parser.add_argument(
        "--seconds",
        type=positive,
        default=60.0,
        metavar="S",
        help="of one call, then it is ended (default: 60)",
    )


def run(args: Namespace) -> int:
    import asyncio
    import logging
    import os
    import sys
    from importlib.util import find_spec
    from pathlib import Path

    if find_spec("mcp") is None:
        says = "olp mcp needs the library mcp"
        raise OlpError(error("C014", says, help='install it: pip install "olp[mcp]"'))
    root = Path(os.path.realpath(args.root))
    if not root.is_dir():
        raise OlpError(error("C015", "this is not a folder", file=args.root, help="name one with --root"))
    from olp.servers.folder import ServerLimits
    from olp.servers.mcp.server import FolderService, serve

    # Standard output is the protocol's.
    logging.basicConfig(stream=sys.stderr, level=logging.WARNING, format="olp mcp: %(message)s")
    asyncio.run(serve(FolderService(root, args.write, ServerLimits(seconds=args.seconds))))
    return 0
