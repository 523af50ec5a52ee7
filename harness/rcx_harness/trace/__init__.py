"""What happened, line by line, and its pictures."""

from rcx_harness.trace.records import FORMAT, Cycle, Finding, Record, Scan, Trace, read_trace

__all__ = ["FORMAT", "Cycle", "Finding", "Record", "Scan", "Trace", "read_trace"]
