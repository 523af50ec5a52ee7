"""Rules for every scan of an exploration, taken only from the manual and the design.

The oracle uses only values that are visible to a user: the values read, the calls of the blocks,
the values written, and the outputs of the blocks. It does not use internal tickets, phases or
timers.

Each group of rules is a function of a few values, and most scans repeat values of earlier scans.
The results are therefore cached (`functools.cache`). A value with many parts is created only once.
Two such values are compared by identity.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any, NamedTuple

from rcx_harness.spec.wire import ENDS, RUN
from rcx_tools.evidence.explore.contract import Case, Link, Pins, Seen, contract, link_of
from rcx_tools.evidence.explore.model import (
    SKIPPED,
    UP,
    Choice,
    Model,
    Wire,
)

__all__ = ["Oracle"]

_SI00, _SI06 = 0x0001, 0x0040
_SAFETY = _SI00 | _SI06
#: Inputs that start something, each with the levels that must be ON: SI(01) needs SI(00) (chapter
#: 5, 2), other starts need SI(00) and SI(06) (chapter 5, 3.2).
_NEEDS = ((0x0002, _SI00), (0x9400, _SAFETY))
_CONTINUOUS = (0x0505, 0x0506)
_INTERVAL_US = 100_000

# Bits of the byte with the flags of the whole cell.
_HELD_E, _HELD_S, _BACK_E, _BACK_S, _QUIT, _STOPPED, _UP, _RAN = (1 << bit for bit in range(8))
# Bits of the byte with the flags of a block.
_WAS, _ASKED, _MISSED, _OUT = 1, 2, 4, 8

_HEAD = 7


@dataclass(frozen=True, eq=False)
class _Turn:
    """The values of a block that are relevant for its turn.

    Attributes:
        called: The block was called in this scan.
        started: The block was started in this scan.
        missed: The block was left out in a scan since its start.
        was_active: Active was TRUE before the scan.
        busy: Busy is TRUE after the scan.
        active: Active is TRUE after the scan.
    """

    called: bool
    started: bool
    missed: bool
    was_active: bool
    busy: bool
    active: bool


@dataclass(frozen=True, eq=False)
class _Hold:
    """The values of a block that are relevant for the dedicated inputs it switches on or holds OFF.

    Attributes:
        does: Treatment of the block in this scan: DOWN, UP or SKIPPED.
        started: The block was started in this scan.
        works: Busy was TRUE before the scan, or is TRUE after it.
        was_up: Execute was TRUE in the last call.
        failed: The block was busy and now shows an error.
    """

    does: int
    started: bool
    works: bool
    was_up: bool
    failed: bool


class _One(NamedTuple):
    """The result of judging one block in a scan."""

    flags: int
    turn: _Turn
    hold: _Hold
    broken: tuple[str, ...]


class _Memory(NamedTuple):
    """The memory of the oracle, unpacked into separate values."""

    was: Wire
    words: int
    since: int
    clear: int
    flags: int
    own: bytes
    ranks: bytes


class Oracle:
    """The judge of consecutive scans. Its memory is a part of each state."""

    def __init__(self, model: Model, root: Any) -> None:
        self.blocks = model.blocks
        self._held = [getattr(root, block.name.upper()) for block in model.blocks]
        self._out = root.OUTPUTAREA
        self.interval = -(-_INTERVAL_US // (model.tick_ms * 1000))
        self.words: list[bytes] = [bytes(32)]
        self._index: dict[bytes, int] = {bytes(32): 0}
        self.by_code = {block.code: k for k, block in enumerate(self.blocks) if block.code}
        self._channels = {
            channel: [
                k
                for k, block in enumerate(self.blocks)
                if block.channel == channel and not block.is_level
            ]
            for channel in ("command", "sequence")
        }
        self._codes, self._by_word = [0], [self.by_code.get(0, -1)]
        self._has_jog = any(block.kind == "jog" for block in self.blocks)
        kinds = [block.kind.removeprefix("release ") for block in self.blocks]
        self._has_holds = bool({"emergency", "stop"}.intersection(kinds))
        self._recalled = lru_cache(maxsize=16)(self._recall)
        self._seen, self._turn, self._hold = cache(Seen), cache(_Turn), cache(_Hold)
        self._link, self._one = cache(link_of), cache(self._judge_block)
        self._turns, self._command = cache(self._judge_turns), cache(self._judge_command)
        self._dedicated, self._holds = cache(self._judge_dedicated), cache(self._judge_holds)

    def initial(self) -> bytes:
        """Return the memory of the oracle before the first scan."""
        return bytes(_HEAD + 2 * len(self.blocks))

    def wire(self, memory: bytes) -> Wire:
        """Return the values that were written in the previous scan."""
        return self._recalled(memory).was

    def _recall(self, memory: bytes) -> _Memory:
        index = memory[0] | memory[1] << 8
        words = self.words[index]
        was = Wire(words[0] | words[1] << 8, words[2] | words[3] << 8, memory[2] | memory[3] << 8)
        since, clear, flags = memory[4:_HEAD]
        middle = _HEAD + len(self.blocks)
        return _Memory(was, index, since, clear, flags, memory[_HEAD:middle], memory[middle:])

    def seen(self, k: int) -> Seen:
        """Return the present outputs of block k."""
        block, o = self.blocks[k], self._held[k]
        works = bool(o.BUSY or getattr(o, "STOPPING", False))
        if block.is_level:
            return self._seen(Pins(o.VALID, o.BUSY, o.ERROR, o.ERRORID, False), 0, works)
        first = int(o.RESPONSE[0]) if block.kind == "command" else 0
        return self._seen(Pins(o.DONE, o.BUSY, o.ERROR, o.ERRORID, o.ACTIVE), first, works)

    def all_seen(self) -> list[Seen]:
        """Return the outputs of all blocks."""
        return [self.seen(k) for k in range(len(self.blocks))]

    def written(self) -> tuple[int, int]:
        """Return the index of the 16 words that the PLC has written, and the dedicated inputs."""
        area = bytes(self._out[:34])
        words = area[:32]
        index = self._index.get(words)
        if index is None:
            index = self._index[words] = len(self.words)
            self.words.append(words)
            self._codes.append(words[0] | words[1] << 8)
            self._by_word.append(self.by_code.get(self._codes[-1], -1))
        return index, area[32] | area[33] << 8

    def judge(
        self,
        memory: bytes,
        choice: Choice,
        before: Sequence[Seen],
        now: Sequence[Seen],
        written: tuple[int, int],
    ) -> tuple[bytes, list[str]]:
        """Judge a scan by all rules.

        Args:
            memory: Memory after the previous scan.
            choice: Choice of the environment.
            before: Outputs of the blocks before the scan.
            now: Outputs of the blocks after the scan.
            written: Result of `written` after the scan.

        Returns:
            The new memory, and the broken rules in words.
        """
        was, old_words, since, clear, flags, own, places = self._recalled(memory)
        # Commands and dedicated inputs are judged separately, with separate clocks. `clear` counts
        # the ticks since the link recovered. `since` counts the ticks since the inputs changed.
        # Both stop at the interval. The memory therefore has few values, and the exploration stays
        # finite.
        words, bits = written
        link = self._link(choice.situation, bool(flags & _UP))
        held, turns, holds = [], [], []
        broken: list[str] = []
        for k, do in enumerate(choice.does):
            one = self._one(k, own[k], do, before[k], now[k], link, was)
            held.append(one.flags)
            turns.append(one.turn)
            holds.append(one.hold)
            broken += one.broken
        places, said = self._turns(places, tuple(turns))
        broken += said
        k = self._by_word[words]
        asked = k >= 0 and bool(held[k] & _ASKED)
        clear = min(clear + choice.ticks, self.interval)
        clear, flags, goes, said = self._command(was, old_words, words, link, flags, clear, asked)
        if goes:
            held[k] = held[k] & ~_ASKED | _OUT
        broken += said
        starts = tuple(
            [bool(one & _ASKED and hold.works) for one, hold in zip(held, holds, strict=True)]
            if bits & ~was.bits
            else []
        )
        since = min(since + choice.ticks, self.interval)
        allowed = (choice.emergency_ok, choice.stop_ok)
        since, said = self._dedicated(was.bits, bits, since, link, allowed, starts)
        broken += said
        if self._has_holds:
            flags, said = self._holds(flags, bits, tuple(holds))
            broken += said
        if self._has_jog:
            does = SKIPPED if k < 0 else choice.does[k]
            flags, said = self._jog(flags, bits, k, does, link.connected, choice.stop_ok)
            broken += said
        flags = flags & ~_UP | (_UP if link.connected else 0)
        head = (words & 255, words >> 8, bits & 255, bits >> 8, since, clear, flags)
        return bytes((*head, *held)) + places, broken

    def _judge_block(
        self, k: int, flags: int, do: int, before: Seen, now: Seen, link: Link, was: Wire
    ) -> _One:
        """Judge the outputs of one block after a scan."""
        block, old, new = self.blocks[k], before.pins, now.pins
        edge = do == UP and not flags & _WAS
        if do == SKIPPED:
            flags |= _MISSED if old.busy else 0
        else:
            # A block has a request if its edge came after the last loss of the link (or of CPU_OK).
            if not link.connected or (block.code and not link.cpu_ok):
                flags &= ~_ASKED
            if edge and (block.is_level or not old.busy):
                flags = (flags | _ASKED) & ~(_MISSED | _OUT)
            elif do != UP and block.kind == "level":
                flags &= ~_ASKED
            flags = flags & ~_WAS | (_WAS if do == UP else 0)
        started, called, missed = edge and not old.busy, do != SKIPPED, bool(flags & _MISSED)
        turn = self._turn(
            called, started, missed, bool(old.active), bool(new.busy), bool(new.active)
        )
        works, failed = bool(old.busy or new.busy), bool(old.busy and new.error)
        hold = self._hold(do, started, works, bool(flags & _WAS), failed)
        out = was.code == block.code and bool(flags & _OUT) and link.judged
        case = Case(block, do == UP, started, missed, out, before.pins, now, link, was)
        return _One(flags, turn, hold, tuple(contract(case)) if called else ())

    def _judge_turns(
        self, places: bytes, turns: tuple[_Turn, ...]
    ) -> tuple[bytes, tuple[str, ...]]:
        """Judge the turns: one block at a time, in the order of the requests (design 2).

        Args:
            places: For each block its place in the order of requests; 0 means that it does not
                wait.
            turns: Values of each block that are relevant for its turn.

        Returns:
            The new `places`, and the broken rules.
        """
        after, broken = bytearray(places), []
        for channel, ours in self._channels.items():
            ranks = {k: places[k] for k in ours}
            called = [k for k in ours if turns[k].called]
            if sum(turns[k].active for k in called) > 1:
                broken.append(f"turn: two blocks are Active on the {channel} channel")
            for k in called:
                if turns[k].active and not turns[k].was_active:
                    for other in called:
                        ahead = 0 < ranks[other] < ranks[k]
                        if ahead and turns[other].busy and not turns[other].active:
                            one, two = self.blocks[k].name, self.blocks[other].name
                            broken.append(f"turn: {one} was served before {two}")
            for k in ours:
                if not turns[k].busy or turns[k].missed:
                    ranks[k] = 0
                elif turns[k].called and turns[k].started:
                    ranks[k] = max(ranks.values()) + 1
            order = sorted((rank, k) for k, rank in ranks.items() if rank)
            for k in ours:
                after[k] = 0
            for place, (_, k) in enumerate(order, start=1):
                after[k] = place
        return bytes(after), tuple(broken)

    def _judge_command(
        self, was: Wire, old: int, new: int, link: Link, flags: int, clear: int, asked: bool
    ) -> tuple[int, int, bool, tuple[str, ...]]:
        """Judge the handshake (guide, chapters 1 and 2).

        Args:
            was: Values that were on the wire before the scan.
            old: Index of the words that were on the wire before the scan.
            new: Index of the words that are on the wire now.
            link: Values that the PLC has read.
            flags: Flags of the cell in the oracle's memory.
            clear: Time since link and CPU_OK are ON.
            asked: Whether the block with the present code has a request.

        Returns:
            The new `clear` and `flags`, whether a requested code went out in this scan, and the
            broken rules.
        """
        code, broken = self._codes[new], []
        if code and not link.cpu_ok:
            broken.append(f"link: the code {code:04X} is out without link or CPU_OK")
        if was.code and link.judged:
            lost = not link.cpu_ok or (flags & _RAN and link.status == 0)
            endless = was.code & 0x0FFF in _CONTINUOUS and was.first & 1 and link.status == RUN
            ended = link.status in ENDS
            may = ended or lost or (endless and code == 0)
            if (code != was.code or new != old) and not may:
                text = f"code {was.code:04X} to {code:04X}, or data, status {link.status:04X}"
                broken.append(f"held: {text}")
            if ended and code:
                broken.append(
                    f"reset: the code {code:04X} stays after the status {link.status:04X}"
                )
            if code not in (was.code, 0):
                broken.append(
                    f"reset: code {was.code:04X} to {code:04X} without 0x0000 between them"
                )
        if (link.connected and not link.was_up) or not link.cpu_ok:
            clear = 0
        goes = bool(code and not was.code)
        if goes:
            broken += self._goes_out(was, old, new, link, flags, clear, asked)
        flags &= ~_RAN if code != was.code or not code else 255
        if code and was.code and link.status:
            flags |= _RAN
        return clear, flags, goes and asked, tuple(broken)

    def _goes_out(
        self, was: Wire, old: int, new: int, link: Link, flags: int, clear: int, asked: bool
    ) -> Iterator[str]:
        code = self._codes[new]
        if self.words[new][2:] != self.words[old][2:]:
            yield f"data first: data and the code {code:04X} went out together"
        if not link.judged:
            yield f"data first: the data of {code:04X} were not there with a connection"
        if link.status:
            yield f"ready: the code {code:04X} went out with the status {link.status:04X}"
        if clear < self.interval:
            yield f"recovered: the code {code:04X} went out too soon after the recovery"
        if not asked:
            yield f"unasked: the code {code:04X} was sent without a request"
            return
        if self.blocks[self.by_code[code]].kind == "jog" and not was.bits & _SI06:
            yield "jog: a jog went out while SI(06) was OFF"
        if flags & _STOPPED:
            yield f"jog: the code {code:04X} went out before SI(06) was back"

    def _judge_dedicated(
        self,
        was: int,
        bits: int,
        since: int,
        link: Link,
        allowed: tuple[bool, bool],
        starts: tuple[bool, ...],
    ) -> tuple[int, tuple[str, ...]]:
        """Judge the dedicated inputs: one change at a time, 100 ms apart (chapter 5, 3; design 2).

        Args:
            was: Dedicated inputs that were on the wire before the scan.
            bits: Dedicated inputs that are on the wire now.
            since: Time since the last change of a dedicated input.
            link: Values that the PLC has read.
            allowed: Values of EmergencyStopOk and StopOk.
            starts: Whether each block has a request and is busy. This is only used if an input went
                ON.

        Returns:
            The new `since`, and the broken rules.
        """
        changed, broken = was ^ bits, []
        if bits & _SAFETY and not link.connected:
            broken.append("safety: SI(00) or SI(06) is ON without a link")
        if bits & _SI00 and not allowed[0]:
            broken.append("safety: SI(00) is ON while EmergencyStopOk is FALSE")
        if bits & _SI06 and not allowed[1]:
            broken.append("safety: SI(06) is ON while StopOk is FALSE")
        if link.connected and not link.was_up:
            since = 0
        paced = changed & ~(was & _SAFETY)
        if paced and link.connected:
            if changed & (changed - 1):
                broken.append(f"interval: inputs {was:04X} to {bits:04X} in one scan")
            elif since < self.interval:
                broken.append(f"interval: inputs {was:04X} to {bits:04X} too soon")
        if changed:
            since = 0
        rises = bits & ~was & ~_SAFETY
        for inputs, levels in _NEEDS:
            if rises & inputs and bits & levels != levels:
                broken.append(f"start: inputs {rises:04X} went ON with {bits & _SAFETY:04X}")
        bit = 0
        while rises >> bit:
            mine = zip(self.blocks, starts, strict=True)
            if rises >> bit & 1 and not any(bit in block.bits and it for block, it in mine):
                broken.append(f"unasked: SI bit {bit} went ON without a request")
            bit += 1
        return since, tuple(broken)

    def _judge_holds(
        self, flags: int, bits: int, holds: tuple[_Hold, ...]
    ) -> tuple[int, tuple[str, ...]]:
        """Judge FB_EmergencyStop and FB_ProgramStop: inputs that they hold must be OFF."""
        for block, one in zip(self.blocks, holds, strict=True):
            which = block.kind.removeprefix("release ")
            held, back = {"emergency": (_HELD_E, _BACK_E), "stop": (_HELD_S, _BACK_S)}.get(
                which, (0, 0)
            )
            if not held or one.does == SKIPPED:
                continue
            if which == block.kind:
                if one.does == UP or one.works:
                    flags = flags & ~back | held
            elif one.started:
                keeps = any(
                    other.kind == which and (its.was_up or its.works)
                    for other, its in zip(self.blocks, holds, strict=True)
                )
                if flags & held and not keeps:
                    flags = flags & ~held | back
            elif one.failed and flags & back:
                flags = flags & ~back | held
        broken = []
        for held, back, bit in ((_HELD_E, _BACK_E, _SI00), (_HELD_S, _BACK_S, _SI06)):
            if flags & held and bits & bit:
                broken.append(f"hold: SI bit {bit:04X} is ON, though a block holds it OFF")
            if bits & bit:
                flags &= ~back
        return flags, tuple(broken)

    def _jog(
        self, flags: int, bits: int, k: int, does: int, connected: bool, stop_ok: bool
    ) -> tuple[int, tuple[str, ...]]:
        """Judge a jog: while its code is sent without Enable, SI(06) must be OFF (guide 4.2.6).

        Before the next code is sent, SI(06) must be ON again. `_goes_out` checks this.
        """
        broken: tuple[str, ...] = ()
        if k >= 0 and self.blocks[k].kind == "jog":
            if does != UP:
                flags |= _QUIT
            if flags & _QUIT:
                flags |= _STOPPED
                if bits & _SI06:
                    broken = ("jog: a jog is out without its Enable, and SI(06) is ON",)
        else:
            flags &= ~_QUIT
        back = bits & _SI06 or not stop_ok or not connected
        if flags & _STOPPED and not flags & _QUIT and back:
            flags &= ~_STOPPED
        return flags, broken
