"""Ways to print timings. One file per format; the file's name is the format's name."""

from olp.reports.formats.report import Options, Report, ReportPart, load_report, report_names

__all__ = ["Options", "Report", "ReportPart", "load_report", "report_names"]
