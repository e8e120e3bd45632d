"""Formats of timing reports. One file per format; the file's name is the format's name."""

from olp.reports.formats.report import (
    WORKBOOK,
    Options,
    Report,
    ReportPart,
    format_of,
    load_report,
    report_names,
)

__all__ = ["WORKBOOK", "Options", "Report", "ReportPart", "format_of", "load_report", "report_names"]
