"""A journal of connection events, in memory that several processes share.

One process writes, and any process may read. The writer never waits for a reader. It writes a
record into the next of a few slots and then publishes the number of the record. A slow reader
misses records, and `Read` contains the number of missed records.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from rcx_harness.enip.cyclic.connections import ConnectionKind

__all__ = ["ConnectionEvent", "Journal", "Read", "RefusedOpen"]

_SLOTS, _SLOT = 128, 1024
_WORD = 8
_LENGTH = struct.Struct("=H")


class Read(NamedTuple):
    """The records that one read of a journal returns, and the number of lost records.

    Attributes:
        lost: How many records were overwritten before they could be read.
    """

    records: list[dict[str, Any]]
    lost: int


class Journal:
    """A ring buffer of short records, in memory that several processes share.

    Args:
        memory: The part of the shared memory for the journal: `NEEDS` bytes, initially zero.
    """

    NEEDS = _WORD + _SLOTS * _SLOT

    def __init__(self, memory: memoryview) -> None:
        self._written = memory[:_WORD].cast("Q")
        self._ring = memory[_WORD : self.NEEDS]
        self._read = 0

    def write(self, record: Mapping[str, Any]) -> None:
        """Publish a record; the caller ensures that its text fits into a slot."""
        data = json.dumps(record, separators=(",", ":")).encode()
        number = self._written[0]
        at = number % _SLOTS * _SLOT
        _LENGTH.pack_into(self._ring, at, len(data))
        at += _LENGTH.size
        self._ring[at : at + len(data)] = data
        self._written[0] = number + 1

    def read(self) -> Read:
        """Return the records that were written since the last read by this process."""
        first, last = self._read, self._written[0]
        if first == last:
            return Read([], 0)
        self._read = last
        copies = [self._slot(number) for number in range(first, last)[-_SLOTS:]]
        # The writer may have overwritten the oldest slots during the copy.
        oldest = self._written[0] - _SLOTS + 1
        whole = copies[max(0, oldest - (last - len(copies))) :]
        records = [json.loads(each[_LENGTH.size :][: _length(each)]) for each in whole]
        return Read(records, last - first - len(whole))

    def release(self) -> None:
        """Release the view of the shared memory, so that the memory can be closed."""
        self._written.release()
        self._ring.release()

    def _slot(self, number: int) -> bytes:
        at = number % _SLOTS * _SLOT
        return bytes(self._ring[at : at + _SLOT])


def _length(slot: bytes) -> int:
    return int(_LENGTH.unpack_from(slot)[0])


@dataclass(frozen=True)
class ConnectionEvent:
    """A change of one class 1 connection.

    Attributes:
        at_us: Time by the clock of `shared.now_us`.
        state: `waiting` (just opened), `run` or `idle`; after the end of the connection `closed` or
            an `EndReason`.
        readers: Number of open connections that only read (input only and listen only).
    """

    at_us: int
    kind: ConnectionKind
    state: str
    peer: str
    o_to_t_api_us: int
    t_to_o_api_us: int
    readers: int

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> ConnectionEvent:
        """Return the event of a record, which is the JSON form of `asdict`."""
        return cls(**{**record, "kind": ConnectionKind(record["kind"])})


@dataclass(frozen=True)
class RefusedOpen:
    """A refused Forward Open: its time, the requester, and a sentence with request and reason."""

    at_us: int
    text: str
