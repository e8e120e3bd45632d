"""A diagnosis as one self-contained HTML file."""

from olp.reports.diagnosis.page import diagnosis_page, html_report

__all__ = ["diagnosis_page", "html_report"]
