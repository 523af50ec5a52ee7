"""Compiled programs that several cells use in sequence."""

from __future__ import annotations

from rcx_harness.watch.calls_source import call_plan, steady_instances
from rcx_harness.watch.first_mistakes import first_mistakes
from rcx_harness.watch.image_source import image_use
from structured_text.bench import compiled
from structured_text.errors import place_text
from structured_text.projects.sources import SourceFiles

__all__ = ["Compiled"]


class Compiled(compiled.Compiled):
    """A compiled program with the findings about its sources and its use of the library."""

    def __init__(self, files: SourceFiles, engine: str = "auto") -> None:
        super().__init__(files, engine)
        use = image_use(*files.users)
        self.located = use.located
        self.mistakes = (
            *map(str, first_mistakes(*files.users)),
            *(
                f"{place_text(one.file, one.at.line, one.at.column)}: warning: {one.text}"
                for one in use.findings
            ),
        )
        self.notice = "\n".join(filter(None, (self.notice, *self.mistakes)))
        self.steady = steady_instances(files.own, files.lib)
        self.calls = call_plan(*files.users)
