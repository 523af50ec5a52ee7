"""The result of the built-in engine's compilation, in the form that `language.cache` saves."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Code"]


@dataclass(frozen=True)
class Code:
    """The generated Python code of a project.

    Attributes:
        file: File name under which the code is compiled.
        first: Number of lines before the lines of the POUs.
        origins: File and line of the source for each line of the POUs.
        body: The compiled code, as `marshal` writes it.
    """

    file: str
    first: int
    origins: list[tuple[str, int]]
    body: bytes
