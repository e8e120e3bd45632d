"""Programs and their times as one self-contained HTML file."""

from olp.reports.page.page import report_page

__all__ = ["report_page"]
