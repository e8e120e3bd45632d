"""Writes figures as files; the suffix of the name selects the format.

PNG is drawn by Pillow (the extra `plot`) at double size, for sharp screens. SVG is text without scripts and outside
files, light or dark as the reader's system.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from functools import lru_cache
from html import escape
from itertools import pairwise
from typing import TYPE_CHECKING, Final, cast

from olp.core.diagnostic import OlpError, error
from olp.reports.plot.figure import TONES, Box, Dot, Figure, Polyline, Shape, TextLabel

if TYPE_CHECKING:
    from PIL import Image
    from PIL.ImageDraw import ImageDraw
    from PIL.ImageFont import FreeTypeFont


_FONT = "system-ui, 'Segoe UI', Helvetica, Arial, sans-serif"


def svg(figure: Figure) -> str:
    """The figure as an SVG document."""
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{figure.width}" height="{figure.height}" '
        f'viewBox="0 0 {figure.width} {figure.height}" role="img" font-family="{escape(_FONT)}">'
    )
    light = "".join(f".{role}{{--c:{tone.light}}}" for role, tone in TONES.items())
    dark = "".join(f".{role}{{--c:{tone.dark}}}" for role, tone in TONES.items())
    style = (
        f"<style>{light}@media (prefers-color-scheme: dark){{{dark}}}"
        ".l{fill:none;stroke:var(--c);stroke-linejoin:round;stroke-linecap:round}.f{fill:var(--c)}"
        "text{white-space:pre}</style>"
    )
    title = f"<title>{_clean(figure.title)}</title>"
    paper = f'<rect class="f paper" width="{figure.width}" height="{figure.height}"/>'
    rows = [head, title, style, paper, *map(_shape, figure.shapes), "</svg>"]
    return "\n".join(rows) + "\n"


def _shape(shape: Shape) -> str:
    match shape:
        case Polyline():
            points = " ".join(f"{_n(x)},{_n(y)}" for x, y in shape.points)
            dash = f' stroke-dasharray="{" ".join(map(_n, shape.dash))}"' if shape.dash else ""
            return f'<polyline class="l {shape.colour}" stroke-width="{_n(shape.width)}"{dash} points="{points}"/>'
        case Box():
            opacity = "" if shape.opacity == 1.0 else f' fill-opacity="{_n(shape.opacity)}"'
            place = (
                f'x="{_n(shape.x)}" y="{_n(shape.y)}" width="{_n(shape.width)}" height="{_n(shape.height)}"'
            )
            return f'<rect class="f {shape.colour}" {place}{opacity}/>'
        case Dot():
            kind = (
                f'class="l {shape.colour}" stroke-width="1.8"'
                if shape.hollow
                else f'class="f {shape.colour}"'
            )
            return f'<circle {kind} cx="{_n(shape.x)}" cy="{_n(shape.y)}" r="{_n(shape.radius)}"/>'
        case TextLabel():
            return _text(shape)


def _text(shape: TextLabel) -> str:
    x, y = _n(shape.x), _n(shape.y)
    weight = ' font-weight="600"' if shape.bold else ""
    anchor = "" if shape.anchor == "start" else f' text-anchor="{shape.anchor}"'
    turn = f' transform="rotate(-90 {x} {y})"' if shape.upright else ""
    return (
        f'<text class="f {shape.colour}" x="{x}" y="{y}" font-size="{_n(shape.size)}"{weight}{anchor}{turn}>'
        f"{_clean(shape.text)}</text>"
    )


def _n(value: float) -> str:
    """A number with at most two decimals: a hundredth of a pixel is enough."""
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _clean(text: str) -> str:
    """Text of a program for XML, without control characters, which XML forbids."""
    return escape(
        "".join(c if c >= " " and not "\ud800" <= c <= "\udfff" and c < "\ufffe" else "\ufffd" for c in text)
    )


_SCALE = 2  # pixels of the picture per pixel of the figure
_PLAIN = {"−": "-", "→": "->", "\u3000": " "}  # what Pillow's font lacks and how else to write it
_FINER = 2  # drawn so much finer still and then reduced: Pillow's lines have no soft edges


def png(figure: Figure) -> bytes:
    """The figure as a PNG file, in light colours. Raises OlpError (E004) when Pillow is not installed."""
    try:
        from PIL import Image, ImageDraw
    except ImportError:
        says = 'install it: pip install "olp[plot]"; or write .svg, which needs nothing'
        raise OlpError(error("E004", "PNG pictures need Pillow", help=says)) from None
    size = figure.width * _SCALE, figure.height * _SCALE
    large = Image.new("RGB", (size[0] * _FINER, size[1] * _FINER), TONES["paper"].light)
    draw = ImageDraw.Draw(large)
    for shape in figure.shapes:
        if not isinstance(shape, TextLabel):
            _draw(draw, shape, _SCALE * _FINER)
    # Text is drawn at its final size, where its hinting is right.
    image = large.resize(size, Image.Resampling.LANCZOS)
    for shape in figure.shapes:
        if isinstance(shape, TextLabel):
            _write(image, shape)
    buffer = io.BytesIO()
    image.save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


def _draw(draw: ImageDraw, shape: Polyline | Box | Dot, k: int) -> None:
    colour = TONES[shape.colour].light
    match shape:
        case Polyline():
            width = max(1, round(shape.width * k))
            for part in _dashed(shape.points, shape.dash):
                draw.line([(x * k, y * k) for x, y in part], fill=colour, width=width, joint="curve")
        case Box():
            corners = [
                (shape.x * k, shape.y * k),
                ((shape.x + shape.width) * k - 1, (shape.y + shape.height) * k - 1),
            ]
            if corners[1][0] >= corners[0][0] and corners[1][1] >= corners[0][1]:
                draw.rectangle([corners[0], corners[1]], fill=_mixed(colour, shape.opacity))
        case Dot():
            x, y, r = shape.x * k, shape.y * k, shape.radius * k
            fill, edge = (None, colour) if shape.hollow else (colour, None)
            draw.ellipse([x - r, y - r, x + r, y + r], fill=fill, outline=edge, width=round(1.8 * k))


def _mixed(colour: str, opacity: float) -> tuple[int, int, int]:
    """The colour over paper white; transparent shapes are only drawn on paper."""
    paper = TONES["paper"].light
    channels = [
        round(int(colour[i : i + 2], 16) * opacity + int(paper[i : i + 2], 16) * (1 - opacity))
        for i in (1, 3, 5)
    ]
    return channels[0], channels[1], channels[2]


def _dashed(
    points: tuple[tuple[float, float], ...], dash: tuple[float, ...]
) -> list[list[tuple[float, float]]]:
    """The visible pieces of a dashed line."""
    if not dash:
        return [list(points)]
    on, off = dash[0], dash[-1]
    parts, current, phase = [], [points[0]], 0.0
    for (x0, y0), (x1, y1) in pairwise(points):
        length = ((x1 - x0) ** 2 + (y1 - y0) ** 2) ** 0.5
        done = 0.0
        while length - done > 1e-9:
            drawing = phase < on
            step = min((on if drawing else on + off) - phase, length - done)
            done += step
            phase += step
            place = (x0 + (x1 - x0) * done / length, y0 + (y1 - y0) * done / length)
            if drawing:
                current.append(place)
            if drawing and phase >= on - 1e-9:
                parts.append(current)
            if phase >= on + off - 1e-9:
                phase, current = 0.0, [place]
    if phase < on and len(current) > 1:
        parts.append(current)
    return parts


def _write(image: Image.Image, shape: TextLabel) -> None:
    from PIL import Image, ImageDraw

    size = shape.size * _SCALE
    width, height = round(_length(shape.text, size)) + 8, round(size * 1.6)
    label = Image.new("L", (width, height), 0)
    _put(ImageDraw.Draw(label), shape.text, size, 4, height * 0.75, 0.35 * _SCALE if shape.bold else 0)
    before = {"start": 4.0, "middle": width / 2, "end": width - 4.0}[shape.anchor]
    x, y = shape.x * _SCALE, shape.y * _SCALE
    place = round(x - before), round(y - height * 0.75)
    if shape.upright:
        label = label.rotate(90, expand=True)
        place = round(x - height * 0.75), round(y - (width - before))
    image.paste(Image.new("RGB", label.size, TONES[shape.colour].light), place, label)


def _put(draw: ImageDraw, text: str, size: float, x: float, y: float, stroke: float) -> None:
    """Text on the baseline `y`; the font of Pillow has no ², so a small 2 stands for it."""
    for part, factor in _parts(text):
        draw.text(
            (x, y - (size * 0.36 if factor < 1 else 0)),
            part,
            fill=255,
            font=_font(size * factor),
            anchor="ls",
            stroke_width=stroke,
        )
        x += _font(size * factor).getlength(part)


def _length(text: str, size: float) -> float:
    return sum(_font(size * factor).getlength(part) for part, factor in _parts(text))


def _parts(text: str) -> list[tuple[str, float]]:
    """Pieces of text and the share of the font's size each is written in."""
    pieces = "".join(_PLAIN.get(c, c) for c in text).split("²")
    found = [(pieces[0], 1.0)]
    for piece in pieces[1:]:
        found += [("2", 0.66), (piece, 1.0)]
    return [part for part in found if part[0]]


@lru_cache(maxsize=32)
def _font(size: float) -> FreeTypeFont:
    from PIL import ImageFont

    return cast("FreeTypeFont", ImageFont.load_default(size))


def _svg(figure: Figure) -> bytes:
    return svg(figure).encode("utf-8")


def _png(figure: Figure) -> bytes:
    return png(figure)


PICTURES: Final[dict[str, Callable[[Figure], bytes]]] = {".svg": _svg, ".png": _png}


def refuse_unknown(path: str) -> None:
    """Raises OlpError (E003), before any work is done, for a file name that is not a picture's."""
    if not path.lower().endswith(tuple(PICTURES)):
        says = "a picture is a .svg or a .png file"
        raise OlpError(error("E003", says, file=path, help="name it so: -o picture.svg"))


def picture(figure: Figure, path: str) -> bytes:
    """The figure in the format of the file `path`. Raises OlpError E003, and E004 when a library is missing."""
    refuse_unknown(path)
    return PICTURES["." + path.lower().rpartition(".")[2]](figure)
