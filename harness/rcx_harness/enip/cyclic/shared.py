"""The two assemblies and the state of their connection, in memory that several processes share.

No process waits for another process. A writer writes an image into the next of a few slots and then
publishes the number of the slot. A reader therefore always gets a complete image, even while the
next image is being written, and even if the writer ends during a write. State and counters are
single words of 64 bits, which are stored and loaded as a whole.
"""

from __future__ import annotations

import ipaddress
import struct
import time
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Literal, Protocol

from rcx_harness.enip.closing import Closing
from rcx_harness.enip.cyclic.connections import ConnectionParameters, OwnerState
from rcx_harness.enip.cyclic.journal import Journal
from structured_text.output.system import SharedMemory

__all__ = [
    "GAPS",
    "Drop",
    "Image",
    "LinkState",
    "SharedImage",
    "SharedImages",
    "Status",
    "Word",
    "drops_text",
    "now_us",
]

GAPS = 8192
"""Number of gaps between packets that are saved; the oldest gap is overwritten."""

_SLOTS = 8
_WORD = 8


class LinkState(IntEnum):
    """The state of the adapter's link and power, set by its parent."""

    UP = 0
    CUT = 1
    """The cable is unplugged: nothing is sent, nothing arrives, connections time out."""
    OFF = 2
    """The adapter has no power and has no connections any more."""


class Word(IntEnum):
    """Indices of the words in the status block.

    The process of the cyclic exchange writes most words.
    """

    SIZE = 0  # bytes of assembly 100; written once, by the creator
    LINK = 1  # a `LinkState`; written by the parent
    RUN = 2  # whether the program runs; written by the scanner
    OWNER = 3  # generation << 8 | OwnerState
    PEER = 4
    O_TO_T_API = 5
    T_TO_O_API = 6
    OWNERS = 7
    INPUT_ONLY = 8
    LISTEN_ONLY = 9
    RECEIVED = 10
    SENT = 11
    MISSING = 12
    SKIPPED = 13
    ARRIVED = 14  # time of the last packet on the monotonic clock in microseconds
    GAPS = 15  # number of stored gaps
    SENDING_ENDS = 16  # monotonic clock in microseconds, 0 for never; by the scanner
    TO_ROBOT_SIZE = 17  # bytes of assembly 150; written once, by the creator
    CYCLIC_ALIVE = 18  # last sign of life on the monotonic clock in microseconds
    ADAPTER_ALIVE = 19  # monotonic clock in microseconds; by the adapter's process
    # bytes of connected data in the last packet that was dropped for its length
    WRONG_LENGTH = 20
    RIGHT_LENGTH = 21  # bytes that the connection of the dropped packet expects
    DROPPED = 22  # the first of the counters: one word for each `Drop`


class Drop(IntEnum):
    """Reasons why a packet is dropped."""

    text: str

    def __new__(cls, number: int, text: str) -> Drop:
        """Create a member. A message shows its `text` after a number of packets."""
        member = int.__new__(cls, number)
        member._value_ = number
        member.text = text
        return member

    UNKNOWN = 0, "of no connection"
    PEER = 1, "from another address than that of its connection"
    LENGTH = 2, "of a wrong length"
    OLD = 3, "with an old sequence number"
    JUMP = 4, "whose sequence number is too far ahead"


_WORDS = len(Word) - 1 + len(Drop)
# Maps the number of an owner state to its member; used once per packet.
_LINK_STATES, _OWNER_STATES = tuple(LinkState), tuple(OwnerState)


@dataclass(frozen=True)
class Status:
    """The state and counters of the connections, as the cyclic process reports them.

    Attributes:
        owner: The state of the connection that owns the outputs.
        generation: How often `owner` has changed; both are read together.
        peer: IPv4 address of the owner, empty without one.
        o_to_t_api_us: Packet interval of the owner in microseconds, 0 without one.
        t_to_o_api_us: Packet interval to the owner in microseconds, 0 without one.
        drops: Number of dropped packets for each `Drop`, in the order of its members.
        wrong_length: Bytes of connected data in the last packet dropped for its length.
        right_length: Bytes that the connection of that packet expects.
        missing: Lost packets, according to the sequence numbers.
        skipped: Packets not sent because their time had passed.
    """

    owner: OwnerState
    generation: int
    peer: str
    o_to_t_api_us: int
    t_to_o_api_us: int
    owners: int
    input_only: int
    listen_only: int
    received: int
    sent: int
    drops: tuple[int, ...]
    missing: int
    skipped: int
    wrong_length: int = 0
    right_length: int = 0

    @property
    def dropped(self) -> int:
        """Return the total number of dropped packets, whatever the reason."""
        return sum(self.drops)

    @property
    def connections(self) -> int:
        """Return the number of open connections of all kinds."""
        return self.owners + self.input_only + self.listen_only


def drops_text(status: Status, drops: Sequence[int] | None = None, *, numbers: bool = True) -> str:
    """Return the number of dropped packets for each reason; empty if no packet was dropped.

    `drops` has a number for each `Drop`, in the order of its members; by default the numbers of the
    status are used. Without `numbers` the text has only the reasons.
    """
    texts = []
    for reason, number in zip(Drop, status.drops if drops is None else drops, strict=True):
        if number:
            text = f"{number} {reason.text}" if numbers else reason.text
            if reason is Drop.LENGTH:
                text += f" ({status.wrong_length} bytes instead of {status.right_length})"
            texts.append(text)
    return ", ".join(texts)


class Image(Protocol):
    """The data of an Assembly, of constant length."""

    def read(self) -> bytes:
        """Return a copy of the complete image."""
        ...

    def write(self, image: bytes, /) -> None:
        """Write a new image, which replaces the old image as a whole."""
        ...


class SharedImage:
    """One assembly with one writer at a time and any number of readers."""

    def __init__(self, memory: memoryview, size: int) -> None:
        self.size = size
        self._version = memory[:_WORD].cast("Q")
        slot = _whole_words(size)
        starts = range(_WORD, _WORD + _SLOTS * slot, slot)
        self._slots = [memory[start : start + size] for start in starts]

    @staticmethod
    def needs(size: int) -> int:
        """Return the number of bytes of shared memory that an assembly of `size` bytes needs."""
        return _WORD + _SLOTS * _whole_words(size)

    @property
    def version(self) -> int:
        """Return the number of writes so far; a new number means a new image."""
        return self._version[0]

    def write(self, image: bytes) -> None:
        """Publish a new image of exactly `size` bytes."""
        version = self._version[0] + 1
        self._slots[version % _SLOTS][:] = image
        self._version[0] = version

    def read(self) -> bytes:
        """Return the newest complete image."""
        while True:
            version = self._version[0]
            image = bytes(self._slots[version % _SLOTS])
            # The writer reuses this slot only after all other slots, so the slot does not change
            # during the copy.
            if self._version[0] - version < _SLOTS - 1:
                return image

    def release(self) -> None:
        """Release the views of the shared memory, so that the memory can be closed."""
        for view in (self._version, *self._slots):
            view.release()


class SharedImages(Closing):
    """Assembly 100 (`to_master`), assembly 150 (`to_robot`) and the status of their connection.

    Attributes:
        to_master: Assembly 100, written by the robot.
        to_robot: Assembly 150, written by the master.
        events: A `ConnectionEvent` for each change; written by the process of the cyclic exchange.
        refusals: A `RefusedOpen` for each refused Forward Open; written by the adapter's process.
    """

    def __init__(self, memory: SharedMemory) -> None:
        self._memory = memory
        self._buffer = memory.buf
        self.name = memory.name
        self._words = self._buffer[: _WORDS * _WORD].cast("Q")
        self.size = size = self._words[Word.SIZE]
        at = _WORDS * _WORD
        self._gaps = self._buffer[at : at + GAPS * 4].cast("I")
        at += GAPS * 4
        end = at + SharedImage.needs(size)
        self.to_master = SharedImage(self._buffer[at:end], size)
        other = self._words[Word.TO_ROBOT_SIZE]
        at = end + SharedImage.needs(other)
        self.to_robot = SharedImage(self._buffer[end:at], other)
        self.events = Journal(self._buffer[at : at + Journal.NEEDS])
        at += Journal.NEEDS
        self.refusals = Journal(self._buffer[at : at + Journal.NEEDS])

    @classmethod
    def create(cls, size: int, to_robot_size: int | None = None) -> SharedImages:
        """Create the shared memory, filled with zeros. The caller must call `unlink` later.

        `size` is the size of assembly 100. If `to_robot_size` is None, assembly 150 has the same
        size.
        """
        other = size if to_robot_size is None else to_robot_size
        needs = _WORDS * _WORD + GAPS * 4 + SharedImage.needs(size) + SharedImage.needs(other)
        needs += 2 * Journal.NEEDS
        memory = SharedMemory(size=needs)
        struct.pack_into("=Q", memory.buf, Word.SIZE * _WORD, size)
        struct.pack_into("=Q", memory.buf, Word.TO_ROBOT_SIZE * _WORD, other)
        return cls(memory)

    @classmethod
    def attach(cls, name: str) -> SharedImages:
        """Open the shared memory that another process has created with this name."""
        memory = SharedMemory(name)
        if not struct.unpack_from("=Q", memory.buf, Word.SIZE * _WORD)[0]:
            memory.close()  # Windows creates new, uninitialised memory if the name is unknown
            raise FileNotFoundError(name)
        return cls(memory)

    @property
    def link(self) -> LinkState:
        """Return the state of the adapter's link and power."""
        return _LINK_STATES[self._words[Word.LINK]]

    @link.setter
    def link(self, state: LinkState) -> None:
        self._words[Word.LINK] = state

    @property
    def run(self) -> bool:
        """Return whether the scanner's program runs, as the run/idle header states."""
        return bool(self._words[Word.RUN])

    @run.setter
    def run(self, run: bool) -> None:
        self._words[Word.RUN] = run

    @property
    def sending_ends_us(self) -> int:
        """Return the time after which nothing is sent, on the monotonic clock [us]; 0: never."""
        return self._words[Word.SENDING_ENDS]

    @sending_ends_us.setter
    def sending_ends_us(self, time_us: int) -> None:
        self._words[Word.SENDING_ENDS] = time_us

    @property
    def owner(self) -> OwnerState:
        """Return the state of the connection that owns the outputs."""
        return _OWNER_STATES[self._words[Word.OWNER] & 0xFF]

    @property
    def arrived_us(self) -> int:
        """Return the time of the last accepted packet, on the monotonic clock [us]; 0: none yet."""
        return self._words[Word.ARRIVED]

    def status(self) -> Status:
        """Return the state of the connections and the packet counters."""
        words = self._words
        generation, owner = divmod(words[Word.OWNER], 256)
        peer = words[Word.PEER]
        return Status(
            owner=OwnerState(owner),
            generation=generation,
            peer=str(ipaddress.IPv4Address(peer)) if peer else "",
            o_to_t_api_us=words[Word.O_TO_T_API],
            t_to_o_api_us=words[Word.T_TO_O_API],
            owners=words[Word.OWNERS],
            input_only=words[Word.INPUT_ONLY],
            listen_only=words[Word.LISTEN_ONLY],
            received=words[Word.RECEIVED],
            sent=words[Word.SENT],
            drops=tuple(words[Word.DROPPED : Word.DROPPED + len(Drop)]),
            missing=words[Word.MISSING],
            skipped=words[Word.SKIPPED],
            wrong_length=words[Word.WRONG_LENGTH],
            right_length=words[Word.RIGHT_LENGTH],
        )

    def gaps_us(self) -> list[int]:
        """Return the last `GAPS` gaps between consecutive accepted packets [us]."""
        return list(self._gaps[: min(self._words[Word.GAPS], GAPS)])

    def set_owner(self, state: OwnerState, connection: ConnectionParameters | None) -> None:
        """Publish state and address of the owner; only the cyclic process calls this method."""
        words = self._words
        words[Word.PEER] = int(ipaddress.IPv4Address(connection.peer)) if connection else 0
        words[Word.O_TO_T_API] = connection.o_to_t_api_us if connection else 0
        words[Word.T_TO_O_API] = connection.t_to_o_api_us if connection else 0
        words[Word.OWNER] = ((words[Word.OWNER] >> 8) + 1) << 8 | state

    def count(self, counter: Word, number: int = 1) -> None:
        """Add to a counter of the status block; only the cyclic process calls this method."""
        self._words[counter] += number

    def drop(self, reason: Drop) -> None:
        """Count a dropped packet; only the cyclic process calls this method."""
        self._words[Word.DROPPED + reason] += 1

    def note_length(self, wrong: int, right: int) -> None:
        """Save the length of a packet that was dropped because of its length.

        Only the cyclic process calls this method. `wrong` is the length of the packet's data,
        `right` the length that the connection expects.
        """
        self._words[Word.WRONG_LENGTH], self._words[Word.RIGHT_LENGTH] = wrong, right

    def beat(self, part: Literal[Word.CYCLIC_ALIVE, Word.ADAPTER_ALIVE], now_us: int) -> None:
        """Publish the current time as the last sign of life of a process."""
        self._words[part] = now_us

    def heard_us(self, part: Literal[Word.CYCLIC_ALIVE, Word.ADAPTER_ALIVE]) -> int:
        """Return the time of the last sign of life of a process, on the monotonic clock [us]."""
        return self._words[part]

    def arrive(self, now_us: int, gap_us: int | None) -> None:
        """Count an accepted packet and save the gap before it.

        Only the cyclic process calls this method.
        """
        words = self._words
        words[Word.RECEIVED] += 1
        words[Word.ARRIVED] = now_us
        if gap_us is not None:
            kept = words[Word.GAPS]
            self._gaps[kept % GAPS] = min(gap_us, 0xFFFFFFFF)
            words[Word.GAPS] = kept + 1

    def unlink(self) -> None:
        """Remove the name of the memory.

        No further process can attach, and the last user frees it.
        """
        self._memory.unlink()

    def close(self) -> None:
        """Release the memory; may be called more than once."""
        self.to_master.release()
        self.to_robot.release()
        self.events.release()
        self.refusals.release()
        self._words.release()
        self._gaps.release()
        self._memory.close()


def now_us() -> int:
    """Return the time of a clock that never goes back and is the same in all processes [us]."""
    return time.perf_counter_ns() // 1000  # on Windows `time.monotonic` may step by 15.6 ms


def _whole_words(size: int) -> int:
    return -(-size // _WORD) * _WORD
