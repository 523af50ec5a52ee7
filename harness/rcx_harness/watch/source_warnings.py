"""All warnings about the use of the library in a program's sources, from one function.

`rcx check`, `rcx run`, the pytest plugin and editors call it, so that all of them report the same
mistakes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from rcx_harness.watch.calls_source import call_findings
from rcx_harness.watch.first_mistakes import first_mistakes, time_pins
from rcx_harness.watch.image_source import image_use
from rcx_harness.watch.time_pins import TimePin
from structured_text.errors import place_text
from structured_text.language.syntax import Position

__all__ = [
    "DEFAULT_RPI_US",
    "PAGE",
    "SourceFacts",
    "SourceWarning",
    "source_facts",
    "source_warnings",
]

#: Packet interval of a connection that is not known: the default of `rcx run` [us].
DEFAULT_RPI_US = 10_000

#: The page with a section for each kind of warning.
PAGE = "docs/how-to/first-mistakes.md"


class SourceWarning(NamedTuple):
    """A mistake in the use of the library.

    Attributes:
        file: The file.
        at: The position in the file.
        text: What is wrong, its consequence, and the remedy.
        kind: The section of `PAGE` that explains it.
        rule: The rule of `rcx check`: `call-order`, `process-image` or `first-mistake`.
        certain: Whether the mistake has an effect in each run, so that `rcx check` fails.
    """

    file: Path
    at: Position
    text: str
    kind: str
    rule: str
    certain: bool = False

    @property
    def page(self) -> str:
        """Return the address of the explanation."""
        return f"{PAGE}#{self.kind}"

    def __str__(self) -> str:
        return f"{place_text(self.file, self.at.line, self.at.column)}: warning: {self.text}"


@dataclass(frozen=True)
class SourceFacts:
    """The mistakes in a program's own files, for any connection.

    Attributes:
        warnings: The mistakes that do not depend on the connection.
        pins: The times that must suit the packet interval.
        files: The program's own files, in their order.
    """

    warnings: tuple[SourceWarning, ...]
    pins: tuple[TimePin, ...]
    files: tuple[Path, ...]

    def on(self, rpi_us: int = DEFAULT_RPI_US, jitter_us: int = 0) -> list[SourceWarning]:
        """Return the mistakes for a connection, in the order of files and lines."""
        texts = ((pin, pin.mistake(rpi_us, jitter_us)) for pin in self.pins)
        timed = (
            SourceWarning(pin.file, pin.at, text, pin.kind, "first-mistake")
            for pin, text in texts
            if text
        )
        ranks = {file: rank for rank, file in enumerate(self.files)}
        return sorted((*self.warnings, *timed), key=lambda one: (ranks[one.file], one.at))


def source_facts(files: Sequence[Path], library: Sequence[Path] = ()) -> SourceFacts:
    """Find the mistakes in a program's own files; `library` has the files that they use."""
    found = [
        SourceWarning(one.file, one.at, one.text, one.kind, "call-order", one.certain)
        for one in call_findings(files, library)
    ]
    found += [
        SourceWarning(one.file, one.at, one.text, one.kind, "process-image")
        for one in image_use(files, library).findings
    ]
    found += [
        SourceWarning(one.file, one.at, one.text, one.kind, "first-mistake")
        for one in first_mistakes(files, library)
    ]
    return SourceFacts(tuple(found), tuple(time_pins(files, library)), tuple(files))


def source_warnings(
    files: Sequence[Path],
    library: Sequence[Path] = (),
    rpi_us: int = DEFAULT_RPI_US,
    jitter_us: int = 0,
) -> list[SourceWarning]:
    """Return the mistakes in a program's own files, in the order of files and lines.

    Args:
        files: The user's files.
        library: The files of the library that they use.
        rpi_us: Packet interval of the connection.
        jitter_us: Its jitter.
    """
    return source_facts(files, library).on(rpi_us, jitter_us)
