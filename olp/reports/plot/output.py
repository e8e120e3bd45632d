"""Which picture a file name asks for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from olp.core.diagnostic import OlpError, error
from olp.reports.plot.figure import Figure


def _svg(figure: Figure) -> bytes:
    from olp.reports.plot.svg import svg

    return svg(figure).encode("utf-8")


def _png(figure: Figure) -> bytes:
    from olp.reports.plot.png import png

    return png(figure)


PICTURES: Final[dict[str, Callable[[Figure], bytes]]] = {".svg": _svg, ".png": _png}


def refuse_unknown(path: str) -> None:
    """Raises OlpError (E003) for a file name that is no picture's, before the work is done."""
    if not path.lower().endswith(tuple(PICTURES)):
        says = "a picture is a .svg or a .png file"
        raise OlpError(error("E003", says, file=path, help="name it so: -o picture.svg"))


def picture(figure: Figure, path: str) -> bytes:
    """The figure as the file `path` wants it. Raises OlpError E003, and E004 when a library is missing."""
    refuse_unknown(path)
    return PICTURES["." + path.lower().rpartition(".")[2]](figure)
