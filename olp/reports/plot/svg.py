"""Figures as SVG text: no script, no outside file, light or dark as the reader's system is."""

from __future__ import annotations

from html import escape

from olp.reports.plot.figure import TONES, Box, Dot, Figure, Polyline, Shape, TextLabel

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
    """Text of a program as XML may hold it: control characters are not allowed there."""
    return escape(
        "".join(c if c >= " " and not "\ud800" <= c <= "\udfff" and c < "\ufffe" else "\ufffd" for c in text)
    )
