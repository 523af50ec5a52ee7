"""The table of ladder instructions."""

from __future__ import annotations

from structured_text.projects.rockwell.ladder.bits import BITS
from structured_text.projects.rockwell.ladder.call import Entry
from structured_text.projects.rockwell.ladder.one_shots import ONE_SHOTS
from structured_text.projects.rockwell.ladder.program_flow import PROGRAM_FLOW
from structured_text.projects.rockwell.ladder.timers import TIMERS

__all__ = ["TABLE"]

#: The instructions by name.
TABLE: dict[str, Entry] = {entry.name: entry for entry in (*BITS, *ONE_SHOTS, *TIMERS, *PROGRAM_FLOW)}
