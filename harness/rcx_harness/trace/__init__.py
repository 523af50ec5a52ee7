"""What happened, line by line, and its pictures."""

from rcx_harness.trace.records import FORMAT, Cycle, Record, Scan, Trace, Violation, read_trace

__all__ = ["FORMAT", "Cycle", "Record", "Scan", "Trace", "Violation", "read_trace"]
