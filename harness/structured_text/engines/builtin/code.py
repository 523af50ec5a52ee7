"""The result of the built-in engine's compilation, in the form that `language.cache` saves."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Code"]


@dataclass(frozen=True)
class Code:
    """The generated Python code of a project.

    Attributes:
        file: File name that Python shows for the code in a traceback.
        first: Number of generated lines before the first line of a POU.
        origins: File and line of the Structured Text for each generated line of a POU.
        body: The compiled code as `marshal` writes it: a tuple of code objects, run in order.
    """

    file: str
    first: int
    origins: list[tuple[str, int]]
    body: bytes
