"""Projects of PLC tools: their Structured Text, with the lines that it stands in."""

from rcx_harness.engine.projects.open import (
    Sources,
    in_folder,
    is_project,
    project_sources,
    read_project,
)
from rcx_harness.engine.projects.texts import st_texts

__all__ = ["Sources", "in_folder", "is_project", "project_sources", "read_project", "st_texts"]
