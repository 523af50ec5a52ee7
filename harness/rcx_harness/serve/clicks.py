"""What was done on the page, as a stimulus that does the same to `rcx run`."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

from rcx_harness.cell.stimulus import Entry, stimulus_text

__all__ = ["MOST", "Clicks", "entry_of"]

#: So many are kept, the latest.
MOST = 10_000


class Clicks:
    """Keeps what was done to which controller, and when.

    Time 0 is the start of each controller, or when `begin` was called last.
    """

    def __init__(self) -> None:
        self._begin_us: Mapping[int, int] = {}
        self._entries: deque[Entry] = deque(maxlen=MOST)

    def __len__(self) -> int:
        return len(self._entries)

    def begin(self, now_us: Sequence[int]) -> None:
        """Forget all, and count from now on; `now_us` is the time of each controller."""
        self._begin_us = dict(enumerate(now_us))
        self._entries.clear()

    def add(self, number: int, t_us: int, message: Mapping[str, Any]) -> None:
        """Something was done to a controller, by its place from 0, at its time `t_us`."""
        since = max(0, t_us - self._begin_us.get(number, 0))
        self._entries.append(entry_of(since, number + 1, message))

    def text(self) -> str:
        """The stimulus file."""
        about = "What was done on the page of rcx serve: rcx run PROGRAM --stimulus THIS"
        return stimulus_text(sorted(self._entries, key=lambda entry: entry.t_us), about)


def entry_of(t_us: int, controller: int, message: Mapping[str, Any]) -> Entry:
    """A message to a station (`Station.obey`) as an entry of a stimulus."""
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
