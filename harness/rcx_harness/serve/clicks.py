"""A record of the user's actions on the page, as a stimulus that repeats them in `rcx run`."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

from rcx_harness.cell.stimulus import Entry, stimulus_text

__all__ = ["MOST", "Clicks", "entry_of"]

#: Maximum number of recorded actions; older actions are dropped.
MOST = 10_000


class Clicks:
    """The recorded actions: controller, time and action.

    Time 0 is the start of each controller, or the last call of `begin`.
    """

    def __init__(self) -> None:
        self._begin_us: Mapping[int, int] = {}
        self._entries: deque[Entry] = deque(maxlen=MOST)

    def __len__(self) -> int:
        return len(self._entries)

    def begin(self, now_us: Sequence[int]) -> None:
        """Delete all actions, and restart the time; `now_us` is the time of each controller."""
        self._begin_us = dict(enumerate(now_us))
        self._entries.clear()

    def add(self, number: int, t_us: int, message: Mapping[str, Any]) -> None:
        """Add an action on controller `number` (from 0) at the controller's time `t_us`."""
        since = max(0, t_us - self._begin_us.get(number, 0))
        self._entries.append(entry_of(since, number + 1, message))

    def text(self) -> str:
        """Return the text of the stimulus file."""
        about = "Actions on the page of rcx serve: rcx run PROGRAM --stimulus THIS"
        return stimulus_text(sorted(self._entries, key=lambda entry: entry.t_us), about)


def entry_of(t_us: int, controller: int, message: Mapping[str, Any]) -> Entry:
    """Convert a message to a station (`Station.obey`) into an entry of a stimulus."""
    if "output" in message:
        name = message["output"]
        if message["do"] == "force":
            return Entry(t_us, controller=controller, force={name: message["value"]})
        if message["do"] == "hold":
            return Entry(t_us, controller=controller, hold=(name,))
        return Entry(t_us, controller=controller, release=(name,))
    if "workpiece" in message:
        place = {message["workpiece"]: message["pulses"]}
        return Entry(t_us, controller=controller, workpieces=place)
    return Entry(t_us, controller=controller, events=((message["event"], message["args"]),))
