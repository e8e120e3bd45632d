"""Pictures: one figure of plain shapes, written as SVG (own writer) or PNG (with the extra `plot`)."""

from olp.reports.plot.figure import Figure
from olp.reports.plot.output import PICTURES, picture, refuse_unknown

__all__ = ["PICTURES", "Figure", "picture", "refuse_unknown"]
