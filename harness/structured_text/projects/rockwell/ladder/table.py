"""The table of ladder instructions."""

from __future__ import annotations

from structured_text.projects.rockwell.ladder.bits import BITS
from structured_text.projects.rockwell.ladder.call import Entry
from structured_text.projects.rockwell.ladder.compare import COMPARES
from structured_text.projects.rockwell.ladder.compute import COMPUTES
from structured_text.projects.rockwell.ladder.file_loops import FILE_LOOPS
from structured_text.projects.rockwell.ladder.files import FILES
from structured_text.projects.rockwell.ladder.one_shots import ONE_SHOTS
from structured_text.projects.rockwell.ladder.others import OTHERS
from structured_text.projects.rockwell.ladder.program_flow import PROGRAM_FLOW
from structured_text.projects.rockwell.ladder.queues import QUEUES
from structured_text.projects.rockwell.ladder.sequencers import SEQUENCERS
from structured_text.projects.rockwell.ladder.texts import TEXTS
from structured_text.projects.rockwell.ladder.timers import TIMERS

__all__ = ["TABLE"]

_ALL = (*BITS, *ONE_SHOTS, *TIMERS, *COMPARES, *COMPUTES, *PROGRAM_FLOW, *TEXTS, *FILES, *OTHERS)
_ALL = (*_ALL, *FILE_LOOPS, *QUEUES, *SEQUENCERS)
#: The instructions by name.
TABLE: dict[str, Entry] = {entry.name: entry for entry in _ALL}
