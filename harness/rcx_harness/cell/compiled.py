"""Compiled programs that several cells use in sequence."""

from __future__ import annotations

from rcx_harness.watch.calls_source import call_plan, steady_instances
from rcx_harness.watch.image_source import image_use
from rcx_harness.watch.source_warnings import DEFAULT_RPI_US, source_facts
from structured_text.bench import compiled
from structured_text.projects.sources import SourceFiles

__all__ = ["Compiled"]


class Compiled(compiled.Compiled):
    """A compiled program with the findings about its sources and its use of the library."""

    def __init__(self, files: SourceFiles, engine: str = "auto") -> None:
        super().__init__(files, engine)
        self.located = image_use(*files.users).located
        self._facts = source_facts(*files.users)
        self.steady = steady_instances(files.own, files.lib)
        self.calls = call_plan(*files.users)

    def warned(self, rpi_us: int = DEFAULT_RPI_US, jitter_us: int = 0) -> tuple[str, ...]:
        """Return the warnings about the sources for a connection with this packet interval."""
        return tuple(f"{one} ({one.page})" for one in self._facts.on(rpi_us, jitter_us))
