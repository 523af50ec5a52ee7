"""Traces of runs, line by line, and the pictures made from them."""

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
