"""The translation of a diagram to statements of Structured Text."""

from __future__ import annotations

from structured_text.projects.diagrams.networks.check import check
from structured_text.projects.diagrams.networks.model import Diagram
from structured_text.projects.diagrams.networks.types import Types
from structured_text.projects.diagrams.sfc.names import Names
from structured_text.projects.model import Lines

__all__ = ["translate"]


def translate(diagram: Diagram, names: Names, types: Types) -> tuple[Lines, Lines]:
    """Return the section with the variables of a diagram, and its statements.

    The section is empty if the translation adds no variable.
    """
    check(diagram)
    raise NotImplementedError(names, types)
