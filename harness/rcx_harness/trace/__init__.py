"""Traces of runs as JSON lines, and the charts, wave files and pages made from them."""

from rcx_harness.trace.records import CutOffError, Cycle, Record, Scan, Trace, read_trace
from structured_text.bench.samples import FORMAT, KEPT
from structured_text.errors import Violation

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
