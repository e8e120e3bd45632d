"""`olp lsp`: the language server, over standard input and output."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

SUMMARY = "serve an editor: times, findings and more while a program is written"
SERVES = True


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--stdio", action="store_true", help="speak over standard input and output (it does so anyway)"
    )


def run(args: Namespace) -> int:
    import gc

    from olp.core.diagnostic import OlpError, error

    gc.disable()  # thousands of classes of the protocol are made while it is imported; the server looks when it is idle
    try:
        from olp.servers.lsp.server import start
    except ModuleNotFoundError as problem:
        if (problem.name or "").partition(".")[0] not in ("pygls", "lsprotocol", "cattrs", "attrs"):
            raise
        missing = error("C012", "the language server needs the library pygls", help='pip install "olp[lsp]"')
        raise OlpError(missing) from None
    start()
    return 0
