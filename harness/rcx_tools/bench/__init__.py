"""What a session of the project should know of its speed: `make bench`, see timing.md."""

from rcx_tools.bench.figure import Figure

__all__ = ["Figure"]
