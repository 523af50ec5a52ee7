"""Benchmarks of the project: `make bench`, see timing.md."""

from rcx_tools.bench.figure import Figure

__all__ = ["Figure"]
