"""Charts as inline SVG: scaled axes, dots, bars and bands; colours are classes of the page's style sheet."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import ArrayLike, NDArray

from olp.identification.diagnosis import phrasing
from olp.reports.plot.figure import SERIES, TONES, number, room, ticks

Floats = NDArray[np.float64]
Range = tuple[float, float]

_LEFT, _RIGHT, _TOP, _BOTTOM = 58.0, 14.0, 14.0, 44.0  # [px] around a panel


class Chart:
    """A panel in pixels of its own viewBox; y grows upwards in data."""

    def __init__(
        self,
        x_range: Range,
        y_range: Range,
        size: tuple[float, float] = (480.0, 300.0),
        left: float = _LEFT,
        equal: bool = False,
    ) -> None:
        self.width, self.height = size
        self.left, self.top = left, _TOP
        self.inner_width, self.inner_height = self.width - left - _RIGHT, self.height - _TOP - _BOTTOM
        self.x_range, self.y_range = x_range, y_range
        if equal:
            self.x_range, self.y_range = self._equal(x_range, y_range)
        self.parts: list[str] = []

    def _equal(self, x: Range, y: Range) -> tuple[Range, Range]:
        """Ranges with equal scale on both axes: the range with too much room is widened."""
        scale = max((x[1] - x[0]) / self.inner_width, (y[1] - y[0]) / self.inner_height)
        half_x, half_y = scale * self.inner_width / 2, scale * self.inner_height / 2
        mid_x, mid_y = (x[0] + x[1]) / 2, (y[0] + y[1]) / 2
        return (mid_x - half_x, mid_x + half_x), (mid_y - half_y, mid_y + half_y)

    def x(self, value: ArrayLike) -> Floats:
        low, high = self.x_range
        share = (np.asarray(value, dtype=np.float64) - low) / (high - low)
        return np.asarray(self.left + np.clip(share, -0.02, 1.02) * self.inner_width)

    def y(self, value: ArrayLike) -> Floats:
        low, high = self.y_range
        share = (np.asarray(value, dtype=np.float64) - low) / (high - low)
        return np.asarray(self.top + (1.0 - np.clip(share, -0.02, 1.02)) * self.inner_height)

    def axes(self, x_label: str, y_label: str, x_ticks: bool = True, y_ticks: bool = True) -> None:
        """Grid, numbers and labels; drawn before the data."""
        right, bottom = self.left + self.inner_width, self.top + self.inner_height
        if y_ticks:
            for value in ticks(self.y_range, max(3, int(self.inner_height / 38))):
                y = n(self.y(value))
                strong = " zero" if value == 0 and self.y_range[0] < 0 else ""
                self.parts.append(f'<path class="grid{strong}" d="M{n(self.left)} {y}H{n(right)}"/>')
                self.text(self.left - 7, float(y) + 4, number(value), "end")
        if x_ticks:
            for value in ticks(self.x_range, max(3, int(self.inner_width / 70))):
                x = n(self.x(value))
                strong = " zero" if value == 0 and self.x_range[0] < 0 else ""
                self.parts.append(f'<path class="grid{strong}" d="M{x} {n(self.top)}V{n(bottom)}"/>')
                self.text(float(x), bottom + 17, number(value), "middle")
        self.parts.append(f'<path class="frame" d="M{n(self.left)} {n(self.top)}V{n(bottom)}H{n(right)}"/>')
        if x_label:
            self.text(self.left + self.inner_width / 2, bottom + 36, x_label, "middle")
        if y_label:
            x, y = n(14.0), n(self.top + self.inner_height / 2)
            turned = f'transform="rotate(-90 {x} {y})"'
            self.parts.append(
                f'<text x="{x}" y="{y}" text-anchor="middle" {turned}>{escape(phrasing.plain(y_label))}</text>'
            )

    def text(self, x: float, y: float, text: str, anchor: str = "start", css: str = "") -> None:
        """Text at (x, y) [px]."""
        where = f'x="{n(x)}" y="{n(y)}"'
        how = f' text-anchor="{anchor}"' if anchor != "start" else ""
        kind = f' class="{css}"' if css else ""
        self.parts.append(f"<text {where}{how}{kind}>{escape(phrasing.plain(text))}</text>")

    def band(self, low: float, high: float, css: str = "noise", upright: bool = False) -> None:
        """A stretch of y over the panel's width, or `upright` of x over its height."""
        if not (np.isfinite(low) and np.isfinite(high)):
            return
        if upright:
            x = sorted(self.x([low, high]).tolist())
            box = (x[0], self.top, x[1] - x[0], self.inner_height)
        else:
            y = sorted(self.y([low, high]).tolist())
            box = (self.left, y[0], self.inner_width, y[1] - y[0])
        self.box(*box, css)

    def box(self, x: float, y: float, width: float, height: float, css: str, title: str = "") -> None:
        """A rectangle at (x, y) [px] with a tooltip `title`."""
        tip = f"<title>{escape(title)}</title>" if title else ""
        place = f'x="{n(x)}" y="{n(y)}" width="{n(width)}" height="{n(max(height, 0.0))}"'
        self.parts.append(f'<rect class="{css}" {place}>{tip}</rect>')

    def dots(self, x: ArrayLike, y: ArrayLike, css: str, index: Iterable[int] = ()) -> None:
        """A dot per known pair, all in one path; `index`: row numbers for the tooltip."""
        xs, ys = np.asarray(self.x(x)).ravel(), np.asarray(self.y(y)).ravel()
        known = np.isfinite(xs) & np.isfinite(ys)
        d = "".join(f"M{n(a)} {n(b)}h.1" for a, b in zip(xs[known].tolist(), ys[known].tolist(), strict=True))
        rows = list(index)
        told = (
            f' data-rows="{" ".join(str(i) for i, k in zip(rows, known.tolist(), strict=True) if k)}"'
            if rows
            else ""
        )
        if d:
            self.parts.append(f'<path class="dots {css}" d="{d}"{told}/>')

    def line(self, x: ArrayLike, y: ArrayLike, css: str) -> None:
        """A line through all points."""
        xs, ys = np.asarray(self.x(x)).tolist(), np.asarray(self.y(y)).tolist()
        points = "L".join(f"{n(a)} {n(b)}" for a, b in zip(xs, ys, strict=True))
        self.parts.append(f'<path class="{css}" d="M{points}"/>')

    def svg(self, title: str, description: str = "") -> Markup:
        """The chart as an image with a title for screen readers."""
        return svg(self.parts, self.width, self.height, title, description)


def svg(parts: Sequence[str], width: float, height: float, title: str, description: str = "") -> Markup:
    """Shapes as an inline SVG image. `parts` are already markup."""
    label = escape(phrasing.plain(f"{title}. {description}" if description else title))
    return Markup(
        f'<svg viewBox="0 0 {n(width)} {n(height)}" role="img" aria-label="{label}" '
        f'style="--w:{n(width)}px">{"".join(parts)}</svg>'
    )


def n(value: float | Floats) -> str:
    """Pixels with one decimal."""
    text = f"{float(value):.1f}"
    return text.removesuffix(".0") if text != "-0.0" else "0"


def around(*values: ArrayLike, share: float = 0.06) -> Range:
    """A range that includes all known values and zero."""
    return room(np.concatenate([np.asarray(v, dtype=np.float64).ravel() for v in values]), share)


# --- Colours ---
# The page's colours as CSS variables, light and dark, and the scale from "robot faster" to "robot slower".

# Blue and orange stay apart for all common kinds of colour blindness; the middle recedes into the paper.
_SCALE = (
    ("#08468c", "#a9d2ff"),
    ("#2672b8", "#6fb1f5"),
    ("#62a5d6", "#4385cb"),
    ("#a6c8e0", "#35587d"),
    ("#b3b9c0", "#525b66"),
    ("#edc196", "#7d5735"),
    ("#e08e3e", "#bb6f2a"),
    ("#c25a0c", "#f09a4c"),
    ("#853602", "#ffcd9c"),
)
STEPS = len(_SCALE)


def variables() -> str:
    """CSS declarations of both themes; the system's preference holds until the reader chooses."""
    light = _declared(0)
    dark = _declared(1)
    return (
        f":root{{color-scheme:light;{light}}}"
        f"@media (prefers-color-scheme:dark){{:root:not([data-theme=light]){{color-scheme:dark;{dark}}}}}"
        f":root[data-theme=dark]{{color-scheme:dark;{dark}}}"
        f"@media print{{:root:root:root{{color-scheme:light;{light}}}}}"
    )


def _declared(theme: int) -> str:
    tones = "".join(f"--{role}:{tone[theme]};" for role, tone in TONES.items())
    series = "".join(f"--s{i}:var(--{role});" for i, role in enumerate(SERIES))
    scale = "".join(f"--r{i}:{step[theme]};" for i, step in enumerate(_SCALE))
    return tones + series + scale


def scale_limit(residual: Floats) -> float:
    """End of the colour scale [s]: 95 % of the moves are within, so that one outlier does not fade the rest."""
    known = np.abs(residual[np.isfinite(residual)])
    return float(max(np.quantile(known, 0.95), 1e-6)) if len(known) else 1e-3


def step_of(residual: Floats, limit: float) -> NDArray[np.int64]:
    """Step of the colour scale (n,): 0 much faster than simulated … STEPS - 1 much slower."""
    half = (STEPS - 1) / 2
    steps = np.round(np.nan_to_num(residual) / limit * half) + half
    return np.asarray(np.clip(steps, 0, STEPS - 1).astype(np.int64))
