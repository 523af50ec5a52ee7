"""What the built-in engine makes of a project, as it is kept (`language.cache`)."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Code"]


@dataclass(frozen=True)
class Code:
    """The Python of a project.

    Attributes:
        file: Name under which it is compiled.
        first: Lines before those of the POUs.
        origins: File and line of the source for each line of the POUs.
        body: The compiled code, as `marshal` writes it.
    """

    file: str
    first: int
    origins: list[tuple[str, int]]
    body: bytes
