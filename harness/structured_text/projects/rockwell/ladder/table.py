"""The table of ladder instructions."""

from __future__ import annotations

from structured_text.projects.rockwell.ladder.bits import BITS
from structured_text.projects.rockwell.ladder.call import Entry
from structured_text.projects.rockwell.ladder.program_flow import PROGRAM_FLOW

__all__ = ["TABLE"]

#: The instructions by name.
TABLE: dict[str, Entry] = {entry.name: entry for entry in (*BITS, *PROGRAM_FLOW)}
