"""The channels of an area: status, response, signals and ports, which are compared separately."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

from rcx_harness.spec import signals
from rcx_harness.spec.wire import DEDICATED_AT, RESERVED_AT, SIZE

__all__ = ["RESPONSE", "STATUS", "Channel", "Difference", "Timeline", "channels", "differences"]

STATUS, RESPONSE = "status", "response"


@dataclass(frozen=True)
class Channel:
    """A channel of the area from the controller: one signal, one port, or some words.

    Attributes:
        name: `status`, `response`, `SO02`, `SO2()`, `reserved` or `SOW(24)`.
        end: Offset of the first byte behind the channel.
        bit: The channel's bit within the byte; None if the channel consists of whole bytes.
    """

    name: str
    first: int
    end: int
    bit: int | None = None

    def of(self, area: bytes) -> int:
        """Return the value that the channel has in `area`."""
        value = int.from_bytes(area[self.first : self.end], "little")
        return value if self.bit is None else value >> self.bit & 1


@lru_cache(maxsize=2)
def channels(size: int) -> tuple[Channel, ...]:
    """Return all channels of an area with `size` bytes, in the order of their bytes."""
    found = [Channel(STATUS, 0, 2), Channel(RESPONSE, 2, DEDICATED_AT)]
    names = {(one.byte, one.bit): one.short for one in signals().output}
    for at in (DEDICATED_AT, DEDICATED_AT + 1):
        for bit in range(8):
            name = names.get((at, bit), f"m+{at} bit {bit}")
            found.append(Channel(name, at, at + 1, bit))
    found += [
        Channel(f"SO{at - DEDICATED_AT}()", at, at + 1)
        for at in range(DEDICATED_AT + 2, RESERVED_AT)
    ]
    found.append(Channel("reserved", RESERVED_AT, SIZE))
    found += [Channel(f"SOW({at // 2})", at, at + 2) for at in range(SIZE, size, 2)]
    return tuple(found)


class Timeline:
    """The values of one channel over time.

    Args:
        changes: Pairs of a time and the value from that time on; successive values differ.
    """

    def __init__(self, changes: Sequence[tuple[int, int]]) -> None:
        self.times = [t_us for t_us, _ in changes]
        self.values = [value for _, value in changes]

    @classmethod
    def of(cls, channel: Channel, outputs: Sequence[tuple[int, bytes]]) -> Timeline:
        """Return the timeline of one channel, taken from consecutive areas."""
        changes: list[tuple[int, int]] = []
        for t_us, area in outputs:
            value = channel.of(area)
            if not changes or value != changes[-1][1]:
                changes.append((t_us, value))
        return cls(changes)

    def at(self, t_us: int) -> int | None:
        """Return the value at a time. Before the first value this is None."""
        place = bisect_right(self.times, t_us) - 1
        return self.values[place] if place >= 0 else None

    def stretches(self, from_us: int, end_us: int) -> Iterator[tuple[int, int, int]]:
        """Yield each period of constant value between two times as begin, end and value."""
        first = max(0, bisect_right(self.times, from_us) - 1)
        for place in range(first, len(self.times)):
            begin_us = max(from_us, self.times[place])
            if begin_us >= end_us:
                return
            behind_us = self.times[place + 1] if place + 1 < len(self.times) else end_us
            if min(behind_us, end_us) > begin_us:
                yield begin_us, min(behind_us, end_us), self.values[place]

    def next_change(self, from_us: int, wanted: int | None) -> int | None:
        """Return the time of the next change to `value`; with `value` None, of the next change.

        Return None if there is no later change.
        """
        for place in range(bisect_left(self.times, from_us), len(self.times)):
            if place and (wanted is None or self.values[place] == wanted):
                return self.times[place]
        return None


@dataclass(frozen=True)
class Difference:
    """A period in which recording and virtual controller show different values of a channel."""

    channel: str
    begin_us: int
    end_us: int
    recorded: int
    virtual: int


def differences(
    channel: Channel,
    recorded: Timeline,
    virtual: Timeline,
    span: tuple[int, int],
    tolerance_us: int,
) -> Iterator[Difference]:
    """Return the periods in which only one of the two controllers shows a value.

    A value counts as shown by both if its times differ by at most the tolerance.

    A value that the virtual controller shows for less time than the tolerance may be missing in the
    recording, because no packet was sent while it lasted.

    `span` is the compared time.
    """
    found: list[tuple[int, int]] = []
    for one, other, brief in ((recorded, virtual, False), (virtual, recorded, True)):
        for begin_us, end_us, value in one.stretches(*span):
            if brief and tolerance_us and end_us - begin_us <= tolerance_us:
                continue
            at_us = begin_us
            window = (max(span[0], begin_us - tolerance_us), min(span[1], end_us + tolerance_us))
            for from_us, until_us, there in other.stretches(*window):
                if there == value and until_us + tolerance_us > at_us:
                    if from_us - tolerance_us > at_us:
                        found.append((at_us, from_us - tolerance_us))
                    at_us = until_us + tolerance_us
            if at_us < end_us:
                found.append((at_us, end_us))
    end_us = -1
    for begin_us, until_us in sorted(found):
        if end_us < 0 or begin_us > end_us + tolerance_us:
            values = recorded.at(begin_us), virtual.at(begin_us)
            yield Difference(channel.name, begin_us, until_us, values[0] or 0, values[1] or 0)
        end_us = max(end_us, until_us)
