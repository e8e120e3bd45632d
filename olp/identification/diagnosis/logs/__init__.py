"""What is told from time series: clocks first, then how axes follow, then what they need. docs/diagnose-logs.md."""

from olp.identification.diagnosis.logs.diagnose import diagnose_log, diagnose_logs
from olp.identification.diagnosis.logs.result import (
    AxisEvidence,
    AxisResidual,
    ClockFit,
    LogCorrelate,
    LogDiagnosis,
)

__all__ = [
    "AxisEvidence",
    "AxisResidual",
    "ClockFit",
    "LogCorrelate",
    "LogDiagnosis",
    "diagnose_log",
    "diagnose_logs",
]
