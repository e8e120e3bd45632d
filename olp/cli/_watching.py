"""`--watch`: a command runs again whenever something changes in the folders that it was asked about.

Code: C018 watchfiles is not installed.
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path

from olp.core.diagnostic import OlpError, error

_BEAT_MS = 100  # after which no change is told, too: the first one says that the folders are watched


def add_watch(parser: ArgumentParser, paths: str) -> None:
    """The option; `paths`: the argument that holds the programs and folders."""
    parser.add_argument(
        "--watch", action="store_true", help="run again whenever a file changes there, until Ctrl+C"
    )
    parser.set_defaults(watched=paths)


def watching(run: Callable[[Namespace], int], args: Namespace) -> int:
    """Runs the command now and after every change; the status is that of its last run. Raises OlpError (C018).

    What changes while the first run lasts is a change: the folders are watched before it begins.
    """
    changes = _changes(_folders(getattr(args, args.watched)), _written(args))
    early = next(changes)
    status = _once(run, args)
    try:
        for changed in chain([early], changes):
            if not changed:
                continue
            print(f"\n{'-' * 60}\nchanged: {changed}", flush=True)
            status = _once(run, args)
    except KeyboardInterrupt:
        print(file=sys.stderr)
    return status


def _once(run: Callable[[Namespace], int], args: Namespace) -> int:
    """One run; a program that is being edited may be wrong, and is told without an end of watching."""
    import copy

    try:
        # A run may set what was left out; the next one begins as the first did.
        return run(copy.deepcopy(args))
    except OlpError as problem:
        print("\n\n".join(diagnostic.render() for diagnostic in problem.diagnostics), file=sys.stderr)
        return 2
    finally:
        sys.stdout.flush()


def _folders(paths: list[str]) -> list[Path]:
    """Each folder, and that of each file: editors replace a file by another one."""
    folders = {Path(path) if Path(path).is_dir() else Path(path).parent for path in paths}
    return sorted(folder for folder in folders if folder.is_dir())


def _written(args: Namespace) -> set[Path]:
    """What the command writes itself, which is no change."""
    names = ("output", "cache", "store", "write_baseline")
    return {Path(value).resolve() for name in names if (value := getattr(args, name, None))}


def _changes(folders: list[Path], own: set[Path]) -> Iterator[str]:
    """The name of a changed file for each batch of changes, "" at once and while nothing changes.

    Raises OlpError (C018).
    """
    try:
        from watchfiles import Change, DefaultFilter, watch
    except ImportError:
        help = 'install it: pip install "olp[watch]"'
        raise OlpError(error("C018", "--watch needs watchfiles, which is not installed", help=help)) from None

    class WatchedFiles(DefaultFilter):
        def __call__(self, change: Change, path: str) -> bool:
            file = Path(path)
            hidden = file.name.startswith(".olp-") or file.suffix == ".part"
            return super().__call__(change, path) and not hidden and file.resolve() not in own

    batches = watch(*folders, watch_filter=WatchedFiles(), rust_timeout=_BEAT_MS, yield_on_timeout=True)
    return (min((path for _, path in batch), default="") for batch in batches)
