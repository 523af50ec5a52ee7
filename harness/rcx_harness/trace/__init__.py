"""What happened, line by line, and its pictures."""

from rcx_harness.trace.records import (
    FORMAT,
    KEPT,
    CutOffError,
    Cycle,
    Record,
    Scan,
    Trace,
    Violation,
    read_trace,
)

__all__ = [
    "FORMAT",
    "KEPT",
    "CutOffError",
    "Cycle",
    "Record",
    "Scan",
    "Trace",
    "Violation",
    "read_trace",
]
