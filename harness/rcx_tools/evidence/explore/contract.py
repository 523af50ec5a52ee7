"""Rules for the outputs of a block after a scan: PLCopen rules, and rules about its end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from rcx_harness.spec.wire import ABNORMAL_END, ENDS, NORMAL_END
from rcx_tools.evidence.explore.model import Block, Situation, Wire, response

__all__ = ["Case", "Link", "Pins", "Seen", "contract", "link_of"]

_CPU_OK = 0x0002


class Pins(NamedTuple):
    """The outputs of a block after a scan."""

    done: bool
    """The output Done; for a block with Enable, Valid."""
    busy: bool
    error: bool
    error_id: int
    active: bool

    @property
    def shown(self) -> int:
        """Return how many of Done, Busy and Error are TRUE."""
        return int(self.done) + int(self.busy) + int(self.error)


@dataclass(frozen=True, eq=False)
class Seen:
    """The values of a block that the oracle judges.

    Attributes:
        pins: Outputs of the block.
        first: Response[1] of a command block; 0 for other blocks.
        works: Whether the block is Busy or stopping.
    """

    pins: Pins
    first: int
    works: bool


@dataclass(frozen=True, eq=False)
class Link:
    """The values that were read in a scan.

    Attributes:
        connected: Connection status of the PLC's scanner.
        status: SOW(0); 0 without a connection.
        so: Dedicated outputs of the controller; 0 without a connection.
        was_up: There was a connection in the previous scan.
    """

    connected: bool
    status: int
    so: int
    was_up: bool

    @property
    def cpu_ok(self) -> bool:
        """Return whether CPU_OK is ON."""
        return bool(self.so & _CPU_OK)

    @property
    def judged(self) -> bool:
        """Return whether there is a connection in this scan and in the previous scan."""
        return self.connected and self.was_up


def link_of(situation: Situation, was_up: bool) -> Link:
    """Return the values that are read in a scan.

    `was_up` says whether the previous scan had a connection.
    """
    connected = situation.connected
    status, so = (situation.status, situation.so) if connected else (0, 0)
    return Link(connected, status, so, was_up)


class Case(NamedTuple):
    """A block that is called in a scan, with the values that the rules need."""

    block: Block
    up: bool
    started: bool
    """Whether the block was started in this scan."""
    missed: bool
    """Whether the block was left out in a scan since its start."""
    out: bool
    """Whether the command of this start was on the wire.

    The command of an earlier start does not count.
    """
    was: Pins
    seen: Seen
    link: Link
    wire: Wire


def contract(case: Case) -> Iterator[str]:
    """Yield the violations of the PLCopen rules by one block (design section 3)."""
    block, was, now, up = case.block, case.was, case.seen.pins, case.up
    if bool(now.error) != (now.error_id != 0):
        yield f"contract: {block.name}: Error without ErrorID, or the reverse"
    if now.shown > 1 or (now.active and not now.busy):
        yield f"contract: {block.name}: {now}"
    if block.is_level:
        if bool(now.shown) != up:
            yield f"contract: {block.name}: {now} with Enable {up}"
        return
    if was.busy:
        if not now.shown:
            yield f"contract: {block.name}: Busy fell without an end"
        elif not now.busy:
            yield from _ended(case)
    elif now.busy:
        if not case.started:
            yield f"contract: {block.name}: Busy without a rising edge of Execute"
    elif case.started:
        yield f"contract: {block.name}: no Busy in the call of the rising edge"
    elif now[:4] != ((False, False, False, 0) if not up else was[:4]):
        yield f"contract: {block.name}: {was} became {now} with Execute {up}"
    # The block copies the response in the scan in which it reads the end status (design 2).
    must_end = block.kind == "command" and case.out and case.link.status in ENDS
    if now.busy and was.busy and must_end and not case.missed:
        yield f"answer: {block.name} does not end with the status 0x{case.link.status:04X}"


def _ended(case: Case) -> Iterator[str]:
    """Yield the violations of the conditions under which a block may end."""
    block, now, link = case.block, case.seen.pins, case.link
    if now.error_id == 0x8001 and link.connected:
        yield f"answer: {block.name}: 16#8001 with a connection"
    if now.error_id == 0x8013 and not case.missed:
        yield f"turn: {block.name} has lost its turn, though it was called in each scan"
    without = block.kind in ("emergency", "stop", "job")
    if not now.error and not link.connected and not without:
        yield f"answer: {block.name}: Done without a connection"
    if block.kind == "command":
        ends = {0x0000: NORMAL_END, 0x8020: ABNORMAL_END}.get(now.error_id)
        if ends is not None and not (case.out and link.status == ends):
            text = f"end {now.error_id:04X}, status {link.status:04X}"
            yield f"answer: {block.name}: {text}"
        if ends is not None and case.seen.first != response(ends):
            yield f"answer: {block.name}: not the response of the end status"
    elif block.answer[0] and not now.error:
        mask, value = block.answer
        if link.so & mask != value:
            yield f"answer: {block.name}: Done, dedicated outputs {link.so:04X}"
        if block.bits and not case.wire.bits & 1 << block.bits[-1]:
            yield f"answer: {block.name}: Done, but its input was not on the wire"
