"""The limits of a call of a tool."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["MOST_CALLS", "MOST_EVENTS", "MOST_FILE_BYTES", "MOST_SEEDS", "MOST_VIRTUAL", "Limits"]

#: Longest virtual time of a run, as text.
MOST_VIRTUAL = "10m"
#: Greatest number of seeds of a campaign.
MOST_SEEDS = 1_000
#: Greatest number of events in the explanation of a trace.
MOST_EVENTS = 200
#: Greatest size of a file that a call writes [bytes].
MOST_FILE_BYTES = 256 << 20
#: Greatest number of calls that run at the same time; further calls wait.
MOST_CALLS = 4


@dataclass(frozen=True)
class Limits:
    """The limits of each call.

    Attributes:
        seconds: Longest real time [s].
        megabytes: Greatest memory of the process that does the work [MB].
    """

    seconds: float = 120.0
    megabytes: int = 2048
