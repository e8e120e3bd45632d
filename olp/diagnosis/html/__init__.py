"""A diagnosis as one self-contained HTML file."""

from olp.diagnosis.html.page import html_report

__all__ = ["html_report"]
